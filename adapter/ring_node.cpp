#include "adapter/ring_node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "enip/endpoint.hpp"

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;

// R-DLR-2.
constexpr std::uint8_t linear = 0;
constexpr std::uint8_t ring = 1;
constexpr std::uint8_t normal_network = 0;
constexpr std::uint8_t ring_fault = 1;

constexpr auto announce_timeout = 2500ms;  // R-DLR-6
constexpr auto neighbor_patience = 100ms;
constexpr int neighbor_requests = 3;

// Bits of a status frame (R-DLR-10): port 1 is bit 0, port 2 is bit 1.
constexpr std::uint8_t of_neighbors_bit = 0x80;
constexpr std::uint8_t bit_of(std::size_t port) { return static_cast<std::uint8_t>(1U << port); }

constexpr std::uint8_t number_of(std::size_t port) { return static_cast<std::uint8_t>(port + 1); }

}  // namespace

void RingNode::on_frame(std::size_t port, const enip::HeardFrame& heard, enip::Time now) {
    const auto frame = RingFrame::parse(heard.octets);
    if (!frame || frame->source == network_.mac) return;  // what we have sent may come round
    switch (frame->type) {
        case RingFrameType::beacon:
            on_beacon(port, *frame, now);
            break;
        case RingFrameType::announce:
            on_announce(*frame, now);
            break;
        case RingFrameType::sign_on:
            on_sign_on(port, *frame);
            break;
        case RingFrameType::locate_fault:
            on_locate_fault(*frame, now);
            break;
        case RingFrameType::neighbor_check_request:
            on_check_request(port, *frame);
            break;
        case RingFrameType::neighbor_check_response:
            on_check_response(port, *frame);
            break;
        case RingFrameType::flush_tables:
            on_flush_tables(*frame);
            break;
        case RingFrameType::status:
        case RingFrameType::advertise:
        case RingFrameType::learning_update:
            break;  // for supervisors, gateways and switches
    }
}

// The higher precedence wins, then the higher MAC address (R-DLR-5).
bool RingNode::accepts(const RingFrame& frame, const Beacon& beacon) const {
    if (state_ == State::idle || frame.source == supervisor_.mac) return true;
    return std::pair(beacon.precedence, frame.source) > std::pair(supervisor_.precedence, supervisor_.mac);
}

void RingNode::on_beacon(std::size_t port, const RingFrame& frame, enip::Time now) {
    const auto beacon = Beacon::parse(frame.content);
    if (network_.ring.announce_based || !beacon || !accepts(frame, *beacon)) return;
    follow({frame.source, frame.source_address, beacon->precedence, std::chrono::microseconds(beacon->timeout)});
    ports_[port].silent_at = now + supervisor_.timeout;
    ports_[port].ring = beacon->state;
    judge();
}

// There is no precedence in it: who announces is the supervisor.
void RingNode::on_announce(const RingFrame& frame, enip::Time now) {
    if (!network_.ring.announce_based || frame.content.empty()) return;
    const auto announced = static_cast<RingState>(frame.content.front());
    if (announced != RingState::normal && announced != RingState::fault) return;
    follow({frame.source, frame.source_address, 0, announce_timeout});
    for (auto& port : ports_) {
        port.silent_at = now + supervisor_.timeout;
        port.ring = announced;
    }
    judge();
}

void RingNode::follow(const Supervisor& supervisor) {
    if (supervisor.mac != supervisor_.mac) {
        log_(LogLevel::info, fmt::format("the ring's supervisor is {} at {}", to_string(supervisor.mac),
                                         enip::address_text(supervisor.address)));
        for (auto& port : ports_) forget(port);
    }
    supervisor_ = supervisor;
}

void RingNode::forget(Port& port) {
    port.silent_at.reset();
    port.ring.reset();
}

// What the ports have heard makes the state, whatever it was (R-DLR-5).
void RingNode::judge() {
    const auto hears = [](const Port& port) { return port.up && port.silent_at; };
    const auto is_normal = [&](const Port& port) { return hears(port) && port.ring == RingState::normal; };
    if (std::ranges::none_of(ports_, hears)) {
        supervisor_ = {};
        enter(State::idle);
    } else {
        enter(std::ranges::all_of(ports_, is_normal) ? State::normal : State::fault);
    }
    auto& told = network_.ring;
    told.topology = state_ == State::idle ? linear : ring;
    told.status = state_ == State::fault ? ring_fault : normal_network;
    told.supervisor_address = supervisor_.address;
    told.supervisor_mac = supervisor_.mac;
    told.supervisor_precedence = supervisor_.precedence;
}

void RingNode::enter(State state) {
    if (std::exchange(state_, state) == state) return;
    constexpr std::array<std::string_view, 3> words{"there is no ring", "the ring has a fault", "the ring is closed"};
    log_(LogLevel::info, std::string(words[static_cast<std::size_t>(state)]));
    if (state == State::fault) return;
    check_due_.reset();
    for (auto& port : ports_) port.check.reset();
}

void RingNode::on_link(std::size_t number, bool up, enip::Time) {
    auto& port = ports_[number];
    port.up = up;
    forget(port);
    if (!up && state_ != State::idle) tell_links();
    judge();
}

void RingNode::on_timer(enip::Time now) {
    for (auto& port : ports_) {
        if (port.silent_at && now >= *port.silent_at) forget(port);
    }
    judge();
    if (check_due_ && now >= *check_due_) check_again(now);
}

std::optional<enip::Time> RingNode::next_deadline() const {
    auto next = check_due_;
    for (const auto& port : ports_) {
        if (port.silent_at && (!next || *port.silent_at < *next)) next = port.silent_at;
    }
    return next;
}

// On its way around the ring each node adds itself, as long as there is room (R-DLR-10, R-DLR-11).
void RingNode::on_sign_on(std::size_t port, const RingFrame& frame) {
    auto entries = parse_sign_on(frame.content);
    if (state_ != State::normal || !entries) return;
    const SignOnEntry own{network_.mac, network_.place().address};
    if (std::ranges::find(*entries, own.mac, &SignOnEntry::mac) != entries->end()) return;  // it has been here
    const bool full = entries->size() == max_sign_on_entries;
    if (!full) entries->push_back(own);
    const auto out = full ? port : other(port);
    auto next = frame;  // the supervisor's address and number stay in it
    next.source = network_.mac;
    next.source_port = number_of(out);
    if (full) next.destination = supervisor_.mac;
    const auto content = encode_sign_on(*entries);
    next.content = content;
    send(out, next);
}

void RingNode::on_check_request(std::size_t port, const RingFrame& frame) {
    if (state_ != State::fault) return;
    auto response = from_here(RingFrameType::neighbor_check_response, ring_neighbor_mac);
    response.source_port = number_of(port);
    response.sequence = frame.sequence;
    const cip::Bytes content{frame.source_port};
    response.content = content;
    send(port, response);
}

void RingNode::on_locate_fault(const RingFrame& frame, enip::Time now) {
    if (state_ != State::fault || frame.source != supervisor_.mac) return;
    if (!std::ranges::all_of(ports_, &Port::up)) {
        tell_links();
        return;
    }
    if (check_due_) return;  // it goes on already
    for (std::size_t port = 0; port < port_count; ++port) {
        ports_[port].check = NeighborCheck{};
        ports_[port].neighbor_lost = false;
        ask_neighbor(port);
    }
    check_due_ = now + neighbor_patience;
}

void RingNode::ask_neighbor(std::size_t port) {
    auto request = from_here(RingFrameType::neighbor_check_request, ring_neighbor_mac);
    request.source_port = number_of(port);
    auto& check = *ports_[port].check;
    if (check.asked++ == 0) check.first_sequence = request.sequence;
    check.last_sequence = request.sequence;
    send(port, request);
}

void RingNode::on_check_response(std::size_t port, const RingFrame& frame) {
    auto& check = ports_[port].check;
    if (!check || frame.content.empty() || frame.content.front() != number_of(port)) return;
    if (frame.sequence - check->first_sequence > check->last_sequence - check->first_sequence) return;
    check.reset();
    finish_check();
}

void RingNode::check_again(enip::Time now) {
    check_due_ = now + neighbor_patience;
    for (std::size_t port = 0; port < port_count; ++port) {
        auto& check = ports_[port].check;
        if (!check) continue;
        if (check->asked < neighbor_requests) {
            ask_neighbor(port);
        } else {
            check.reset();
            ports_[port].neighbor_lost = true;
        }
    }
    finish_check();
}

// When both neighbors have answered, or one or both are given up.
void RingNode::finish_check() {
    if (std::ranges::any_of(ports_, [](const Port& port) { return port.check.has_value(); })) return;
    check_due_.reset();
    if (std::ranges::none_of(ports_, &Port::neighbor_lost)) return;
    send_status(of_neighbors_bit, [](const Port& port) { return !port.neighbor_lost; });
}

void RingNode::tell_links() {
    send_status(0, [](const Port& port) { return port.up; });
}

// To the supervisor, by every way that there may be: a neighbor that does not answer may still pass it on.
void RingNode::send_status(std::uint8_t bits, bool (*works)(const Port&)) {
    for (std::size_t port = 0; port < port_count; ++port) {
        if (works(ports_[port])) bits |= bit_of(port);
    }
    auto status = from_here(RingFrameType::status, supervisor_.mac);
    const cip::Bytes content{bits};
    status.content = content;
    for (std::size_t port = 0; port < port_count; ++port) send(port, status);
}

// Switches between here and elsewhere learn anew where this node is.
void RingNode::on_flush_tables(const RingFrame& frame) {
    if (state_ == State::idle || frame.content.empty() || frame.content.front() == 0) return;
    const auto update = from_here(RingFrameType::learning_update, ring_learning_mac);
    for (std::size_t port = 0; port < port_count; ++port) send(port, update);
}

RingFrame RingNode::from_here(RingFrameType type, const MacAddress& destination) {
    return {.destination = destination,
            .source = network_.mac,
            .type = type,
            .source_address = network_.place().address,
            .sequence = sequence_++};
}

void RingNode::send(std::size_t port, const RingFrame& frame) {
    if (ports_[port].up) frames_.push_back({port, frame.encode()});
}

}  // namespace servobus::adapter
