#include "tests/sim/wire.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "cip/wire.hpp"
#include "enip/encapsulation.hpp"
#include "enip/io_packet.hpp"

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;

/// What TCP waits until it sends a segment again that was lost, or that has met a cut line.
constexpr auto retransmission = 200ms;
/// What is overtaken is later by up to so much, where the jitter is not larger.
constexpr microseconds reorder_time = 5ms;
/// A stream is cut into pieces of up to so many octets, so that messages come in parts.
constexpr std::int64_t largest_piece = 1'400;

}  // namespace

Wire::Wire(EventQueue& queue, const Scenario& scenario)
    : queue_(queue), drives_(scenario.drives.size()), lines_(scenario.nodes * scenario.drives.size() * 2) {
    hosts_[0].resize(scenario.nodes);
    hosts_[1].resize(scenario.drives.size());
    for (std::size_t i = 0; i < lines_.size(); ++i) lines_[i].random = Random(scenario.seed, 1000 + i);
}

void Wire::set_faults(unsigned node, unsigned drive, Action::Way way, const Faults& faults) {
    for_lines(node, drive, way, [&](Line& each) { each.faults = faults; });
}

void Wire::cut(unsigned node, unsigned drive, Action::Way way, Time until) {
    for_lines(node, drive, way, [&](Line& each) { each.cut_until = std::max(each.cut_until, until); });
}

void Wire::heal() {
    for (auto& each : lines_) {
        each.faults = {};
        each.cut_until = {};
    }
}

// ----------------------------------------------------------------------------------------------------- datagrams

std::uint32_t Wire::free_slot() {
    if (free_.empty()) {
        free_.push_back(static_cast<std::uint32_t>(packets_.size()));
        packets_.emplace_back();
        copies_.push_back(0);
    }
    const auto slot = free_.back();
    free_.pop_back();
    return slot;
}

void Wire::send(unsigned node, unsigned drive, End to, enip::Endpoint source, enip::Endpoint destination,
                cip::ByteView octets) {
    auto& way = line(node, drive, to);
    ++counters_.sent;
    const bool lost = way.random.chance(way.faults.loss) || way.cut_until > queue_.now();
    if (lost) {
        ++counters_.lost;
        return;
    }
    const auto slot = free_slot();
    auto& packet = packets_[slot];
    packet.node = node;
    packet.drive = drive;
    packet.to = to;
    packet.source = source;
    packet.destination = destination;
    packet.octets.assign(octets.begin(), octets.end());
    const bool twice = way.random.chance(way.faults.duplicate);
    copies_[slot] = twice ? 2 : 1;
    travel(way, slot);
    if (!twice) return;
    ++counters_.duplicated;
    travel(way, slot);
}

void Wire::travel(Line& way, std::uint32_t slot) {
    auto delay = way.faults.delay;
    if (way.faults.jitter.count() > 0) delay += microseconds(way.random.between(0, way.faults.jitter.count()));
    if (way.random.chance(way.faults.reorder)) {
        ++counters_.reordered;
        delay += microseconds(way.random.between(1, std::max(way.faults.jitter, reorder_time).count()));
    }
    queue_.after(delay, [this, slot] { arrive(slot); });
}

void Wire::arrive(std::uint32_t slot) {
    // By value where it matters: what is sent meanwhile may move the places.
    auto packet = std::move(packets_[slot]);
    const bool last = --copies_[slot] == 0;
    const bool cut = line(packet.node, packet.drive, packet.to).cut_until > queue_.now();
    auto& receiver = *hosts_[static_cast<std::size_t>(packet.to)][packet.to == End::node ? packet.node : packet.drive];
    if (cut || !receiver.is_up()) {
        ++counters_.lost;
    } else {
        ++counters_.delivered;
        note(packet);
        receiver.on_packet(packet);
    }
    packets_[slot] = std::move(packet);
    if (last) free_.push_back(slot);
}

// ------------------------------------------------------------------------------------------------------- streams

StreamId Wire::connect(unsigned node, unsigned drive, enip::Endpoint source, enip::Endpoint destination) {
    const auto id = ++last_stream_;
    ++counters_.streams;
    auto& stream = streams_[id];
    stream.node = node;
    stream.drive = drive;
    stream.source = source;
    stream.destination = destination;
    stream.open[static_cast<std::size_t>(End::node)] = true;
    push(id, stream, End::drive, Segment::Kind::connect);
    return id;
}

void Wire::write(StreamId id, End from, cip::ByteView octets) {
    const auto found = streams_.find(id);
    if (found == streams_.end()) return;
    auto& stream = found->second;
    const auto to = other_end(from);
    auto& way = line(stream.node, stream.drive, to);
    while (!octets.empty()) {
        const auto most = std::min<std::int64_t>(largest_piece, static_cast<std::int64_t>(octets.size()));
        const bool whole = way.random.chance(0.7);
        const auto piece = octets.first(static_cast<std::size_t>(whole ? most : way.random.between(1, most)));
        push(id, stream, to, Segment::Kind::octets, {piece.begin(), piece.end()});
        octets = octets.subspan(piece.size());
    }
}

void Wire::close(StreamId id, End from) {
    const auto found = streams_.find(id);
    if (found == streams_.end()) return;
    found->second.open[static_cast<std::size_t>(from)] = false;
    push(id, found->second, other_end(from), Segment::Kind::close);
}

void Wire::abort(StreamId id, End from, bool silent) {
    const auto found = streams_.find(id);
    if (found == streams_.end()) return;
    found->second.open[static_cast<std::size_t>(from)] = false;
    if (!silent) push(id, found->second, other_end(from), Segment::Kind::reset);
    forget_if_over(id);
}

void Wire::reset_streams(unsigned node, unsigned drive) {
    std::vector<StreamId> meant;
    for (const auto& [id, stream] : streams_) {
        if (stream.node == node && stream.drive == drive) meant.push_back(id);
    }
    std::ranges::sort(meant);  // the map has no order of its own
    for (const auto id : meant) {
        ++counters_.resets;
        for (const auto end : {End::drive, End::node}) {
            const auto found = streams_.find(id);
            if (found == streams_.end()) break;
            if (!std::exchange(found->second.open[static_cast<std::size_t>(end)], false)) continue;
            auto& receiver = host(found->second, end);
            if (receiver.is_up()) receiver.on_end(id);
        }
        streams_.erase(id);
    }
}

void Wire::push(StreamId id, Stream& stream, End to, Segment::Kind kind, cip::Bytes octets) {
    auto& way = line(stream.node, stream.drive, to);
    auto& flow = stream.flows[static_cast<std::size_t>(to)];
    Time::duration delay = way.faults.delay;
    if (way.faults.jitter.count() > 0) delay += microseconds(way.random.between(0, way.faults.jitter.count()));
    // Each loss of the same segment doubles the wait, as TCP does; a line that loses everything is no reason to wait for ever.
    for (int again = 0; again < 6 && way.random.chance(way.faults.loss); ++again)
        delay += retransmission * (1 << again);
    flow.last = std::max(flow.last, queue_.now() + delay);  // nothing overtakes
    flow.segments.push_back({flow.last, kind, std::move(octets)});
    if (flow.segments.size() == 1) queue_.at(flow.last, [this, id, to] { pump(id, to); });
}

void Wire::pump(StreamId id, End to) {
    const auto found = streams_.find(id);
    if (found == streams_.end()) return;
    auto& stream = found->second;
    auto& flow = stream.flows[static_cast<std::size_t>(to)];
    if (flow.segments.empty()) return;
    if (line(stream.node, stream.drive, to).cut_until > queue_.now()) {
        queue_.after(retransmission, [this, id, to] { pump(id, to); });
        return;
    }
    const auto segment = std::move(flow.segments.front());
    flow.segments.pop_front();
    if (!flow.segments.empty()) queue_.at(flow.segments.front().due, [this, id, to] { pump(id, to); });
    arrive(id, to, segment);
}

void Wire::arrive(StreamId id, End to, const Segment& segment) {
    using Kind = Segment::Kind;
    auto& stream = streams_.at(id);
    auto& receiver = host(stream, to);
    auto& open = stream.open[static_cast<std::size_t>(to)];
    if (!receiver.is_up()) {  // nobody is there to say so
        open = false;
        forget_if_over(id);
        return;
    }
    switch (segment.kind) {
        case Kind::connect:
            open = receiver.listens();
            push(id, stream, End::node, open ? Kind::accept : Kind::refuse);
            if (open) receiver.on_accepted(id, stream.source, stream.destination);
            break;
        case Kind::accept:
            if (open) receiver.on_connected(id, true);
            break;
        case Kind::refuse:
            if (std::exchange(open, false)) receiver.on_connected(id, false);
            break;
        case Kind::octets:
            if (open) {
                arrivals_[arrived_++ % arrivals_.size()] = {.at = queue_.now(),
                                                            .node = stream.node,
                                                            .drive = stream.drive,
                                                            .to = to,
                                                            .stream = id,
                                                            .octets = segment.octets.size()};
                receiver.on_octets(id, segment.octets);
            } else if (stream.open[static_cast<std::size_t>(other_end(to))]) {
                push(id, stream, other_end(to), Kind::reset);  // nobody reads here any more
            }
            break;
        case Kind::close:
        case Kind::reset:
            if (std::exchange(open, false)) receiver.on_end(id);
            break;
    }
    forget_if_over(id);
}

/// Of class 1 also whose it is, from their places in the datagram (R-IO-1).
void Wire::note(const Packet& packet) {
    auto& arrival = arrivals_[arrived_++ % arrivals_.size()];
    arrival = {.at = queue_.now(),
               .node = packet.node,
               .drive = packet.drive,
               .to = packet.to,
               .octets = packet.octets.size()};
    if (packet.destination.port != enip::io_port || packet.octets.size() < enip::io_packet_overhead) return;
    cip::Reader reader(cip::ByteView(packet.octets).subspan(6));
    arrival.id = reader.u32();
    arrival.sequence = reader.u32();
}

std::vector<std::string> Wire::last_arrivals(Time began) const {
    std::vector<std::string> lines;
    const auto count = std::min<std::uint64_t>(arrived_, arrivals_.size());
    for (auto i = arrived_ - count; i < arrived_; ++i) {
        const auto& each = arrivals_[i % arrivals_.size()];
        const auto time = std::chrono::duration<double>(each.at - began).count();
        const auto what = each.stream != 0 ? fmt::format("TCP connection {}", each.stream)
                          : each.id != 0   ? fmt::format("id 0x{:08X}, number {}", each.id, each.sequence)
                                           : std::string("a datagram");
        lines.push_back(fmt::format(
            "{:.6f} s, {} {} {}: {}, {} octets", time, each.to == End::drive ? "node" : "drive",
            each.to == End::drive ? each.node : each.drive,
            each.to == End::drive ? fmt::format("to drive {}", each.drive) : fmt::format("to node {}", each.node), what,
            each.octets));
    }
    return lines;
}

std::string Wire::describe_streams() const {
    std::string text;
    for (const auto& [id, stream] : streams_) {
        text +=
            fmt::format("; {} from node {} to drive {}, open at{}{}, {} and {} segments on their way", id, stream.node,
                        stream.drive, stream.open[0] ? " the node" : "", stream.open[1] ? " the drive" : "",
                        stream.flows[0].segments.size(), stream.flows[1].segments.size());
    }
    return text;
}

void Wire::forget_if_over(StreamId id) {
    const auto found = streams_.find(id);
    if (found == streams_.end()) return;
    const auto& stream = found->second;
    if (stream.open[0] || stream.open[1] || !stream.flows[0].segments.empty() || !stream.flows[1].segments.empty())
        return;
    streams_.erase(found);
}

}  // namespace servobus::sim
