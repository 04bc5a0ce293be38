#include "scanner/tcp_stream.hpp"

#include <algorithm>
#include <array>

#include "cip/wire.hpp"

namespace servobus::scanner {
namespace {

using Command = enip::Command;

constexpr std::array commands{Command::nop,
                              Command::list_services,
                              Command::list_identity,
                              Command::list_interfaces,
                              Command::register_session,
                              Command::unregister_session,
                              Command::send_rr_data,
                              Command::send_unit_data};

/// Whether a message may begin here: a known command, a possible length, and no options, which nobody sets.
bool begins_message(cip::ByteView octets) {
    cip::Reader reader(octets);
    const auto command = reader.little<Command>();
    const auto length = reader.u16();
    reader.take(16);
    const auto options = reader.u32();
    return reader.ok() && std::ranges::find(commands, command) != commands.end() && length <= enip::max_stated_length &&
           options == 0;
}

}  // namespace

void TcpStream::take(const CapturedPacket& segment, const Sink& sink) {
    if (segment.syn) {
        // The connection begins, perhaps anew on the ports of an old one.
        next_ = segment.sequence + 1;
        waiting_.clear();
        decoder_ = enip::FrameDecoder();
        in_step_ = true;
        return;
    }
    if (segment.payload.empty()) return;
    if (!next_) next_ = segment.sequence;
    const auto distance = static_cast<std::int32_t>(segment.sequence - *next_);
    if (distance > 0) {
        ++counters_.reordered;
        waiting_.try_emplace(position_ + static_cast<std::uint32_t>(distance),
                             Waiting{{segment.payload.begin(), segment.payload.end()}, segment.time});
        if (waiting_.size() > max_waiting) pass_gap(sink);
        return;
    }
    const auto known = std::size_t{0} - static_cast<std::size_t>(std::int64_t{distance});
    if (known >= segment.payload.size()) {
        ++counters_.repeated;
        return;
    }
    read(segment.payload.subspan(known), segment.time, sink);
    read_waiting(sink);
}

void TcpStream::finish(const Sink& sink) {
    while (!waiting_.empty()) pass_gap(sink);
}

void TcpStream::pass_gap(const Sink& sink) {
    ++counters_.gaps;
    const auto first = waiting_.begin()->first;
    *next_ += static_cast<std::uint32_t>(first - position_);
    position_ = first;
    decoder_ = enip::FrameDecoder();
    in_step_ = false;
    read_waiting(sink);
}

void TcpStream::read_waiting(const Sink& sink) {
    while (!waiting_.empty() && waiting_.begin()->first <= position_) {
        const auto node = waiting_.extract(waiting_.begin());
        const auto known = position_ - node.key();
        const auto& octets = node.mapped().octets;
        if (known >= octets.size()) {
            ++counters_.repeated;
        } else {
            read(cip::ByteView(octets).subspan(known), node.mapped().time, sink);
        }
    }
}

void TcpStream::read(cip::ByteView octets, CaptureTime time, const Sink& sink) {
    *next_ += static_cast<std::uint32_t>(octets.size());
    position_ += octets.size();
    if (!in_step_ && !begins_message(octets)) {
        ++counters_.skipped;
        return;
    }
    in_step_ = true;
    while (!octets.empty()) {
        if (const auto message = decoder_.next(octets); message && !message->oversize) sink(message->frame, time);
    }
}

}  // namespace servobus::scanner
