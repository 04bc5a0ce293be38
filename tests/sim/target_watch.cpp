#include "tests/sim/target_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "cip/path.hpp"
#include "cip/real_time_format.hpp"
#include "cip/services.hpp"
#include "cip/wire.hpp"
#include "enip/io_stream.hpp"
#include "enip/messages.hpp"

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;
using std::chrono::microseconds;
namespace service = cip::service;

constexpr drive::Key status_word{0x66, 0x01};
constexpr drive::Key actual_position{0x66, 0x24};
constexpr drive::Key target_position{0x66, 0x3A};
constexpr drive::Key quick_stop_deceleration{0x66, 0x45};
constexpr drive::Key process_status{0x64, 0x06};

constexpr std::uint32_t state_bits = 0x006F;
constexpr std::uint32_t operation_enabled = 0x0027;
constexpr std::uint32_t quick_stop_active = 0x0007;
constexpr std::uint32_t in_motion = 1U << 2;

/// Beside the ramp: a control period, and what the axis needs to settle.
constexpr auto settling_time = 300ms;
/// Without power, by friction alone.
constexpr auto coasting_time = 800ms;
/// Increments that an axis under power may swing around the place where it stands.
constexpr std::int64_t standing_window = 60;
/// The highest speed that programs of the simulation command, increment/s.
constexpr double highest_speed = 50'000;
/// R-CON-48.
constexpr std::size_t listening_connections = 8;

std::int64_t value_of(const drive::Device& device, const drive::Parameter* row) {
    return std::get<std::int64_t>(device.store().value(*row));
}
std::uint32_t word_of(const drive::Device& device, const drive::Parameter* row) {
    return static_cast<std::uint32_t>(value_of(device, row));
}

std::int64_t in_microseconds(Time::duration time) { return std::chrono::duration_cast<microseconds>(time).count(); }

std::string text(const cip::ConnectionTriad& triad) {
    return fmt::format("{:04X}/{:08X}", triad.serial_number, triad.originator_serial);
}

/// What the path asks for; nullptr for class 3, and for what no device has.
const assemblies::Connection* kind_of(const cip::ForwardOpen& open) {
    const auto path = cip::Path::parse(open.path);
    if (!path) return nullptr;
    std::vector<std::uint32_t> points;
    for (const auto& segment : path->segments) {
        const auto* logical = std::get_if<cip::LogicalSegment>(&segment);
        if (logical != nullptr && logical->type == cip::LogicalType::connection_point) points.push_back(logical->value);
    }
    return points.size() == 2 ? assemblies::find_connection(points[0], points[1]) : nullptr;
}

microseconds inhibit_of(const cip::ForwardOpen& open) {
    if (const auto path = cip::Path::parse(open.path)) {
        if (const auto said = cip::production_inhibit_time(*path)) return microseconds(*said);
    }
    return microseconds(open.t_to_o_rpi / 4);
}

bool is_multicast(const cip::ForwardOpen& open) { return open.t_to_o.type == cip::ConnectionType::multicast; }

}  // namespace

std::optional<std::size_t> offset_of(const assemblies::Layout& layout, drive::Key key) {
    std::size_t offset = 0;
    for (const auto& member : layout.members) {
        if (member.kind == assemblies::Member::Kind::parameter && member.key == key) return offset;
        offset += member.octets;
    }
    return std::nullopt;
}

void TargetWatch::report(Invariant invariant, Time now, const std::string& what) const {
    judge_->report(invariant, now, fmt::format("drive {}: {}", number_, what));
}

// ------------------------------------------------------------------------------------------------------- streams

void TargetWatch::restarted(Time now, Time until) {
    rows_ = {};
    connections_.clear();
    productions_.clear();
    explicit_.clear();
    target_.reset();
    sessions_end_ = true;
    deaf_until_ = until;
    for (auto& [key, stream] : streams_) {
        stream.owed.clear();
        stream.asked.clear();
        stream.owed_connected.clear();
        stream.leaving = true;
    }
    // An axis that coasts stands some time later; one that is another drive's after a change stands somewhere else.
    loss_ = Loss{.at = now, .stops_by = now + coasting_time};
    controlled_ = false;
}

void TargetWatch::stream_opened(StreamKey key, std::uint32_t peer, Time now) {
    streams_[key] = {.peer = peer, .last_message = now};
}

void TargetWatch::stream_closed(StreamKey key) {
    streams_.erase(key);
    std::erase_if(explicit_, [&](const auto& entry) { return entry.second.stream == key; });  // R-ENC-25
}

void TargetWatch::stream_expired(StreamKey key, Time now) {
    const auto found = streams_.find(key);
    if (found == streams_.end() || found->second.leaving || sessions_end_) return;
    const auto silence = now - found->second.last_message;
    if (silence < 120s) {
        report(Invariant::explicit_timeout, now,
               fmt::format("a TCP connection is closed after {} us of silence", in_microseconds(silence)));
    }
}

void TargetWatch::hears(StreamKey key, const enip::Frame& frame, Time now) {
    const auto found = streams_.find(key);
    if (found == streams_.end() || found->second.leaving) return;
    auto& stream = found->second;
    stream.last_message = now;
    if (frame.status != enip::EncapsulationStatus::success || frame.options != 0) return;
    switch (frame.command) {
        case enip::Command::nop:
            return;
        case enip::Command::unregister_session:
            stream.leaving = stream.session != 0 && stream.session == frame.session;
            if (stream.leaving) return;
            break;
        case enip::Command::send_unit_data:
            hears_connected(key, stream, frame, now);
            return;
        default:
            break;
    }
    hears_request(stream, frame);
}

void TargetWatch::hears_request(Stream& stream, const enip::Frame& frame) {
    stream.owed.push_back(frame.context);
    cip::Request request;
    if (frame.command == enip::Command::send_rr_data && stream.session != 0 && frame.session == stream.session) {
        const auto data = enip::SendData::parse(frame.data);
        const auto message = data ? enip::unconnected_message(*data) : cip::DecodeError::truncated;
        if (message) {
            if (auto parsed = cip::Request::parse(*message)) request = *std::move(parsed);
        }
    }
    stream.asked.push_back(std::move(request));
}

void TargetWatch::hears_connected(StreamKey key, Stream& stream, const enip::Frame& frame, Time now) {
    if (stream.session == 0 || frame.session != stream.session) return;
    const auto data = enip::SendData::parse(frame.data);
    const auto message = data ? enip::connected_message(*data) : cip::DecodeError::truncated;
    if (!message) return;
    const auto found = explicit_.find(message->connection_id);
    if (found == explicit_.end() || found->second.stream != key) return;  // R-ENC-23
    found->second.deadline = now + found->second.timeout;
    stream.owed_connected.push_back(message->sequence);
}

void TargetWatch::says(StreamKey key, const enip::Frame& frame, Time now) {
    const auto found = streams_.find(key);
    if (found == streams_.end()) return;
    auto& stream = found->second;
    ++counters_.answers;
    if (frame.command == enip::Command::send_unit_data) {
        const auto data = enip::SendData::parse(frame.data);
        const auto message = data ? enip::connected_message(*data) : cip::DecodeError::truncated;
        if (!message || stream.owed_connected.empty() || stream.owed_connected.front() != message->sequence) {
            report(Invariant::reply_is_asked_for, now, "a connected reply has a sequence count that is not due");
            return;
        }
        stream.owed_connected.erase(stream.owed_connected.begin());
        return;
    }
    if (stream.owed.empty() || stream.owed.front() != frame.context) {
        report(Invariant::reply_is_asked_for, now, "a reply has a context that is not due");
        return;
    }
    const auto request = std::move(stream.asked.front());
    stream.owed.erase(stream.owed.begin());
    stream.asked.erase(stream.asked.begin());
    if (frame.command == enip::Command::register_session && frame.status == enip::EncapsulationStatus::success) {
        stream.session = frame.session;
    }
    if (frame.command == enip::Command::send_rr_data && request.service != 0)
        says_response(key, stream, request, frame, now);
}

void TargetWatch::says_response(StreamKey key, Stream& stream, const cip::Request& request, const enip::Frame& frame,
                                Time now) {
    const auto data = enip::SendData::parse(frame.data);
    const auto message = data ? enip::unconnected_message(*data) : cip::DecodeError::truncated;
    const auto response = message ? cip::Response::parse(*message) : cip::DecodeError::truncated;
    if (!response || response->service != request.service) {
        report(Invariant::reply_is_asked_for, now, fmt::format("no response to service 0x{:02X}", request.service));
        return;
    }
    if (request.service == service::forward_open || request.service == service::large_forward_open) {
        const auto open = cip::ForwardOpen::parse(request.data, request.service == service::large_forward_open);
        if (!open) return;
        if (response->status.ok()) {
            granted(key, stream, *open, *response, now);
        } else {
            refused(*open, response->status, now);
        }
    }
    if (request.service == service::forward_close && response->status.ok()) {
        if (const auto close = cip::ForwardClose::parse(request.data)) closed(close->triad, now);
    }
}

// --------------------------------------------------------------------------------------------------- connections

const TargetWatch::Connection* TargetWatch::owner() const {
    const auto found = std::ranges::find_if(connections_, [](const auto& entry) { return entry.second.is_owner(); });
    return found != connections_.end() ? &found->second : nullptr;
}

/// Multicast has one key, whoever listens.
TargetWatch::ProductionKey TargetWatch::key_of(const Connection& connection) const {
    const bool shared = connection.is_multicast();
    return {connection.production, {shared ? 0 : connection.originator, 0}};
}

std::optional<std::string> TargetWatch::reason_to_refuse(const cip::ForwardOpen& open) const {
    const auto is_triad = [&](const auto& entry) { return entry.second.request.triad == open.triad; };
    if (std::ranges::any_of(connections_, is_triad)) return "its triad is open (R-CON-26)";
    if (open.o_to_t.redundant_owner) return "it asks for a redundant owner (R-CON-15)";
    const auto* kind = kind_of(open);
    if (kind == nullptr) return std::nullopt;
    using Kind = assemblies::Connection::Kind;
    if (kind->kind == Kind::exclusive_owner && owner() != nullptr) return "there is an owner (R-CON-30)";
    const auto heard = [&](const auto& entry) {
        const auto& each = entry.second;
        return !each.is_listener() && each.is_multicast() && each.kind->t_to_o_point == kind->t_to_o_point;
    };
    if (kind->kind == Kind::listen_only && (!is_multicast(open) || std::ranges::none_of(connections_, heard))) {
        return "there is nothing to listen to (R-CON-32)";
    }
    if (is_multicast(open)) {
        for (const auto& [id, each] : connections_) {
            if (!each.is_multicast() || each.kind->t_to_o_point != kind->t_to_o_point) continue;
            const auto& terms = productions_.at(key_of(each)).book.terms();
            const bool same = terms.interval == microseconds(open.t_to_o_rpi) &&
                              each.request.transport.trigger == open.transport.trigger &&
                              terms.inhibit == inhibit_of(open);
            if (!same) return "the group has other terms (R-CON-33)";
        }
    }
    const auto others = std::ranges::count_if(connections_, [](const auto& entry) { return !entry.second.is_owner(); });
    if (kind->kind != Kind::exclusive_owner && static_cast<std::size_t>(others) >= listening_connections) {
        return "all connections are in use (R-CON-48)";
    }
    return std::nullopt;
}

void TargetWatch::refused(const cip::ForwardOpen& open, const cip::Status& status, Time now) {
    ++counters_.refused;
    if (open.transport.transport_class == 3 || reason_to_refuse(open)) return;
    report(Invariant::admitted_by_the_rules, now,
           fmt::format("{} is refused with 0x{:02X}/0x{:04X}, and there is no reason", text(open.triad),
                       static_cast<unsigned>(status.general), status.extended.empty() ? 0U : status.extended.front()));
}

void TargetWatch::granted(StreamKey key, const Stream& stream, const cip::ForwardOpen& open,
                          const cip::Response& response, Time now) {
    const auto reply = cip::ForwardOpenReply::parse(response.data);
    if (!reply || reply->triad != open.triad) {
        report(Invariant::reply_is_asked_for, now, "the reply to a Forward_Open is about another connection");
        return;
    }
    const auto interval = microseconds(open.o_to_t_rpi);
    const auto timeout = interval * (std::int64_t{4} << open.timeout_multiplier);
    const auto deadline = now + std::max<microseconds>(timeout, 10s);
    if (open.transport.transport_class == 3) {
        ++counters_.class3;
        explicit_[reply->o_to_t_id] = {open.triad, key, timeout, deadline};
        return;
    }
    if (const auto reason = reason_to_refuse(open)) {
        report(reason->find("R-CON-30") != std::string::npos ? Invariant::one_owner : Invariant::admitted_by_the_rules,
               now, fmt::format("{} is granted, though {}", text(open.triad), *reason));
    }
    const auto* kind = kind_of(open);
    if (kind == nullptr || connections_.contains(reply->o_to_t_id) || reply->t_to_o_api != open.t_to_o_rpi ||
        reply->o_to_t_api != open.o_to_t_rpi) {
        report(
            Invariant::admitted_by_the_rules, now,
            fmt::format("{} is granted with an id in use, other intervals, or for no known points", text(open.triad)));
        return;
    }
    Connection connection{.request = open,
                          .kind = kind,
                          .o_to_t_id = reply->o_to_t_id,
                          .production = reply->t_to_o_id,
                          .originator = stream.peer,
                          .timeout = timeout,
                          .deadline = deadline};
    auto& production = productions_[key_of(connection)];
    if (production.users++ == 0) {
        production.book =
            ProductionBook({microseconds(open.t_to_o_rpi), inhibit_of(open), open.transport.trigger == 0}, now);
    }
    ++(connection.is_owner() ? counters_.owners : connection.is_listener() ? counters_.listeners : counters_.onlookers);
    connections_.emplace(reply->o_to_t_id, std::move(connection));
}

void TargetWatch::closed(const cip::ConnectionTriad& triad, Time now) {
    ++counters_.closed;
    const auto found =
        std::ranges::find_if(connections_, [&](const auto& entry) { return entry.second.request.triad == triad; });
    if (found != connections_.end()) {
        remove(found->first, now);
        return;
    }
    const auto erased = std::erase_if(explicit_, [&](const auto& entry) { return entry.second.triad == triad; });
    if (erased == 0) {
        report(Invariant::reply_is_asked_for, now, fmt::format("{} is closed, and was not open", text(triad)));
    }
}

/// And the listeners that have nothing to listen to any more (R-CON-32).
void TargetWatch::remove(std::uint32_t o_to_t_id, Time now) {
    const auto connection = connections_.at(o_to_t_id);
    connections_.erase(o_to_t_id);
    release(connection);
    if (connection.is_owner()) target_.reset();
    if (!connection.is_multicast() || connection.is_listener()) return;
    const auto same_group = [&](const Connection& each) {
        return each.is_multicast() && each.production == connection.production;
    };
    const bool heard = std::ranges::any_of(
        connections_, [&](const auto& entry) { return !entry.second.is_listener() && same_group(entry.second); });
    if (heard) return;
    for (auto each = connections_.begin(); each != connections_.end();) {
        if (!each->second.is_listener() || !same_group(each->second)) {
            ++each;
            continue;
        }
        release(each->second);
        each = connections_.erase(each);
    }
    static_cast<void>(now);
}

void TargetWatch::release(const Connection& connection) {
    const auto found = productions_.find(key_of(connection));
    if (found != productions_.end() && --found->second.users == 0) productions_.erase(found);
}

// ---------------------------------------------------------------------------------------------------------- data

void TargetWatch::hears_io(std::uint32_t peer, cip::ByteView octets, Time now) {
    if (now < deaf_until_) return;
    const auto packet = enip::IoPacket::parse(octets);
    if (!packet) return;
    const auto found = connections_.find(packet->connection_id);
    if (found == connections_.end()) return;
    auto& connection = found->second;
    const bool fits =
        peer == connection.originator && packet->data.size() == connection.request.o_to_t.size;  // R-IO-7, R-IO-8
    if (!fits) ++counters_.foreign;
    if (!fits || connection.deadline <= now) return;
    if (connection.sequence && static_cast<std::int32_t>(packet->sequence - *connection.sequence) <= 0) {  // R-IO-5
        ++counters_.stale;
        return;
    }
    ++counters_.taken;
    connection.sequence = packet->sequence;
    connection.deadline = now + connection.timeout;
    if (!connection.is_owner()) return;
    cip::Reader reader(packet->data);
    const auto count = reader.u16();
    const bool run = (reader.u32() & 1) != 0;
    const bool counts = connection.count != count || !connection.run;  // R-IO-6
    connection.count = count;
    connection.run = run;
    if (!run || !counts) return;
    const auto image = reader.rest();
    if (const auto offset = offset_of(*connection.kind->outputs(), target_position)) {
        target_ = static_cast<std::int32_t>(cip::Reader(image.subspan(*offset)).u32());
    }
}

void TargetWatch::produces(const enip::IoRoute& route, cip::ByteView octets, Time now) {
    const auto packet = enip::IoPacket::parse(octets);
    if (!packet) {
        report(Invariant::produced_in_sequence, now, "what is sent is no class 1 datagram");
        return;
    }
    const bool shared = enip::is_multicast(route.peer.address);
    const auto found = productions_.find({packet->connection_id, {shared ? 0 : route.peer.address, 0}});
    if (found == productions_.end()) {
        report(
            Invariant::produced_for_somebody, now,
            fmt::format("a datagram with id 0x{:08X} goes to {}", packet->connection_id, enip::to_string(route.peer)));
        return;
    }
    const auto fault = found->second.book.take(packet->sequence, now, now == excused_at_);
    if (fault) report(fault->invariant, now, fmt::format("id 0x{:08X}: {}", packet->connection_id, fault->what));
}

// ------------------------------------------------------------------------------------------------------- looking

void TargetWatch::settle(const adapter::Adapter& adapter, Time now) {
    settle_connections(adapter, now);
    settle_answers(now);
    settle_explicit(adapter, now);
    settle_axis(adapter.device(), now);
    sessions_end_ = false;
}

void TargetWatch::settle_answers(Time now) {
    for (const auto& [key, stream] : streams_) {
        if (stream.owed.empty() && stream.owed_connected.empty()) continue;
        report(Invariant::request_answered, now,
               fmt::format("{} requests have been taken and not answered",
                           stream.owed.size() + stream.owed_connected.size()));
    }
}

void TargetWatch::settle_explicit(const adapter::Adapter& adapter, Time now) {
    std::erase_if(explicit_, [&](const auto& entry) { return entry.second.deadline <= now; });
    if (adapter.class3_connections() != explicit_.size()) {
        report(
            Invariant::explicit_timeout, now,
            fmt::format("{} class 3 connections, and {} by the books", adapter.class3_connections(), explicit_.size()));
    }
    if (adapter.tcp_connections() != streams_.size()) {
        report(Invariant::explicit_timeout, now,
               fmt::format("{} TCP connections, and {} by the books", adapter.tcp_connections(), streams_.size()));
    }
    for (const auto& [key, stream] : streams_) {
        if (now - stream.last_message > 120s && !stream.leaving) {
            report(Invariant::explicit_timeout, now, "a TCP connection stays after 120 s of silence");
        }
    }
}

void TargetWatch::settle_connections(const adapter::Adapter& adapter, Time now) {
    // By their time, whichever is first: a listener that goes with another does not time out.
    std::vector<std::uint32_t> over;
    for (const auto& [id, each] : connections_) {
        if (each.deadline <= now) over.push_back(id);
    }
    for (const auto id : over) {
        if (!connections_.contains(id)) continue;
        ++counters_.timed_out;
        remove(id, now);
    }
    std::size_t owners = 0;
    for (const auto& each : adapter.io().all()) {
        if (each->is_owner()) ++owners;
        if (connections_.contains(each->o_to_t_id)) continue;
        report(Invariant::target_timeout_late, now,
               fmt::format("0x{:08X} is still open, though its time is over or it was closed", each->o_to_t_id));
    }
    if (owners > 1) report(Invariant::one_owner, now, fmt::format("{} owners", owners));
    if (adapter.io().size() < connections_.size()) {
        for (const auto& [id, each] : connections_) {
            const auto is_it = [&](const auto& other) { return other->o_to_t_id == id; };
            if (std::ranges::any_of(adapter.io().all(), is_it)) continue;
            report(Invariant::target_timeout_early, now,
                   fmt::format("0x{:08X} is gone, {} us before its time", id, in_microseconds(each.deadline - now)));
        }
    }
    if (adapter.io().size() > listening_connections + 1) {
        report(Invariant::within_limits, now, fmt::format("{} I/O connections", adapter.io().size()));
    }
    for (const auto& [key, production] : productions_) {
        if (!production.book.is_overdue(now)) continue;
        report(Invariant::produced_in_time, now, fmt::format("id 0x{:08X} is overdue", key.id));
    }
}

/// Looked up once, since they are read after each event.
void TargetWatch::find_rows(const drive::Device& device) {
    rows_ = {&device,
             device.find(status_word),
             device.find(process_status),
             device.find(actual_position),
             device.find(target_position),
             device.find(quick_stop_deceleration)};
}

void TargetWatch::settle_axis(const drive::Device& device, Time now) {
    if (rows_.device != &device) find_rows(device);
    const auto status = word_of(device, rows_.status) & state_bits;
    const auto* runs = owner();
    const bool controlled = runs != nullptr && runs->run;
    if (target_ && controlled && value_of(device, rows_.target) != *target_) {
        report(Invariant::newest_data_is_in_force, now,
               fmt::format("the target is {}, and the owner has said {}", value_of(device, rows_.target), *target_));
    }
    const bool moves = (word_of(device, rows_.process) & in_motion) != 0;
    if (controlled_ && !controlled) {
        const auto ramp = highest_speed / static_cast<double>(value_of(device, rows_.quick_stop));
        loss_ = Loss{.at = now, .stops_by = now + settling_time + microseconds(static_cast<std::int64_t>(ramp * 1e6))};
        if (moves) ++counters_.losses_in_motion;
        if (status_before_ == operation_enabled && status != quick_stop_active) {
            report(Invariant::drive_stops_like_a_quick_stop, now, fmt::format("the state is 0x{:04X}", status));
        }
    }
    if (controlled) {
        loss_.reset();
    } else if (!loss_) {
        loss_ = Loss{.at = now, .stops_by = now};
    } else if (now > loss_->stops_by) {
        const auto place = value_of(device, rows_.position);
        if (!loss_->place) loss_->place = place;
        if (moves || std::abs(place - *loss_->place) > standing_window) {
            report(Invariant::drive_stands_without_owner, now,
                   fmt::format("it is at {} and was at {}, {} us after the owner was lost, {}", place, *loss_->place,
                               in_microseconds(now - loss_->at), moves ? "in motion" : "not in motion"));
        }
    }
    controlled_ = controlled;
    status_before_ = status;
}

void TargetWatch::expect_nothing(const adapter::Adapter& adapter, Time now) {
    const auto none = [&](std::size_t count, const char* what) {
        if (count != 0) report(Invariant::nothing_left_behind, now, fmt::format("{} {}", count, what));
    };
    none(adapter.tcp_connections(), "TCP connections");
    none(adapter.sessions(), "sessions");
    none(adapter.class3_connections(), "class 3 connections");
    none(adapter.io().size(), "I/O connections");
    none(adapter.io().groups_in_use(), "multicast groups");
    none(adapter.faults().active(), "faults");
    if (const auto next = adapter.next_deadline()) {
        report(Invariant::nothing_left_behind, now,
               fmt::format("a deadline in {} us, and nothing that it could be for", in_microseconds(*next - now)));
    }
}

}  // namespace servobus::sim
