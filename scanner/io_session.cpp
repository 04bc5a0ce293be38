#include "scanner/io_session.hpp"

#include <algorithm>
#include <array>
#include <boost/system/errc.hpp>
#include <utility>

#include "enip/dscp.hpp"

namespace servobus::scanner {
namespace {

using std::chrono::milliseconds;

/// Of class 0 and 1 by priority (R-QOS-5).
constexpr std::array<std::uint8_t, 4> dscp_of_priority{enip::dscp_low, enip::dscp_high, enip::dscp_scheduled,
                                                       enip::dscp_urgent};
/// Of O->T to a group (R-IO-11).
constexpr std::uint8_t multicast_ttl = 1;
/// O->T goes out on a change at most this many times in an interval (R-CON-52).
constexpr int sends_per_interval = 4;

bool is_failure(const cip::Status& status, cip::ConnectionFailure failure) {
    return status.general == cip::GeneralStatus::connection_failure && !status.extended.empty() &&
           status.extended.front() == static_cast<std::uint16_t>(failure);
}

/// Refusals that are about the moment, and not about what was asked (R-SCN-4). 0x0204 is a router's word for a device
/// that did not answer.
bool may_pass(const cip::Status& status) {
    using enum cip::ConnectionFailure;
    return std::ranges::any_of(
        std::array{duplicate_forward_open, ownership_conflict, out_of_connections, no_non_listen_only_connection,
                   target_out_of_connections, unconnected_request_timed_out},
        [&](auto failure) { return is_failure(status, failure); });
}

bool may_pass(const IoClosed& closed) {
    switch (closed.reason) {
        case CloseReason::unreachable:
            return closed.error != Error::request_too_large;
        case CloseReason::refused:
            return may_pass(closed.status);
        case CloseReason::timed_out:
        case CloseReason::no_socket:
            return true;
        case CloseReason::asked:
        case CloseReason::bad_reply:
            return false;
    }
    return false;
}

/// Nothing can be said about what the device has done with the request.
bool leaves_doubt(const error_code& error) {
    return error && error != Error::not_connected && error != Error::request_too_large &&
           error != Error::too_many_requests && trouble_of(error) != Trouble::refusal;
}

bool is_sendable(const IoPlan& plan) {
    return plan.path().words() <= cip::max_path_words &&
           std::max(plan.o_to_t.connection_size(), plan.t_to_o.connection_size()) <= max_io_connection_size;
}

}  // namespace

IoSession::IoSession(IoOptions options, IoEvents events, IoNumbers& numbers, Surroundings& surroundings)
    : options_(std::move(options)),
      events_(std::move(events)),
      numbers_(numbers),
      surroundings_(surroundings),
      output_(options_.plan.o_to_t.data_octets) {}

std::uint64_t IoSession::await(Awaited what) {
    awaited_ = what;
    ticket_ = ++last_ticket_;
    return ticket_;
}

void IoSession::stop_awaiting() {
    awaited_ = Awaited::nothing;
    ticket_ = 0;
}

void IoSession::enter(IoState state) {
    state_ = state;
    surroundings_.changed();
}

// ------------------------------------------------------------------------------------------------------- opening

void IoSession::open(enip::Time) {
    switch (state_) {
        case IoState::idle:
        case IoState::waiting:
        case IoState::closed:
            attempt_ = 0;
            pause_ = options_.first_pause;
            begin();
            return;
        case IoState::closing:
            open_again_ = true;
            return;
        case IoState::connecting:
        case IoState::opening:
        case IoState::open:
            return;
    }
}

void IoSession::begin() {
    ++attempt_;
    request_.reset();
    enter(IoState::connecting);
    surroundings_.connect(await(Awaited::session));
}

void IoSession::on_connected(std::uint64_t ticket, error_code error, const TcpEnds& ends, enip::Time now) {
    if (!is_awaited(ticket) || awaited_ != Awaited::session) return;
    stop_awaiting();
    if (state_ == IoState::closing) {
        if (error) {
            finish_close({.error = error}, now);
        } else {
            surroundings_.request(await(Awaited::close_reply), close_request(*request_), {});
        }
        return;
    }
    if (error) {
        fail({.reason = CloseReason::unreachable, .error = error}, now);
    } else {
        ask(ends, now);
    }
}

void IoSession::ask(const TcpEnds& ends, enip::Time now) {
    ends_ = ends;
    const auto& plan = options_.plan;
    if (!is_sendable(plan)) {
        fail({.reason = CloseReason::unreachable, .error = make_error_code(Error::request_too_large)}, now);
        return;
    }
    if (!plan.is_null()) {
        if (ends.remote.address == 0) {  // over IPv6, which has no class 1
            using boost::system::errc::address_family_not_supported;
            fail({.reason = CloseReason::no_socket, .error = make_error_code(address_family_not_supported)}, now);
            return;
        }
        const auto receiver = surroundings_.listen(ends.local.address);
        if (!receiver) {
            fail({.reason = CloseReason::no_socket, .error = receiver.error()}, now);
            return;
        }
        receiver_ = *receiver;
    }
    close_in_passing(std::exchange(owed_close_, std::nullopt));
    const bool own_id = plan.t_to_o.type == cip::ConnectionType::point_to_point;  // R-CON-16
    std::uint32_t id = 0;
    if (own_id) {
        do id = numbers_.next_id();
        while (surroundings_.is_taken(id));
        expect(id);
    }
    request_ = plan.forward_open(0, id, numbers_.next_triad());
    if (small_only_) request_->large = false;
    enter(IoState::opening);
    send_open();
}

void IoSession::send_open() {
    std::vector<enip::Item> items;
    const bool has_port = options_.plan.t_to_o.type == cip::ConnectionType::point_to_point;
    if (has_port && (receiver_.port != enip::io_port || options_.always_name_port)) {
        items.push_back({enip::ItemType::sockaddr_t_to_o, enip::SocketAddress{.port = receiver_.port}.encode()});
    }
    surroundings_.request(await(Awaited::open_reply), open_request(*request_), std::move(items));
}

void IoSession::on_reply(std::uint64_t ticket, error_code error, const Exchange& exchange, enip::Time now) {
    if (!is_awaited(ticket)) return;
    const auto awaited = awaited_;
    stop_awaiting();
    if (awaited == Awaited::open_reply) on_open_reply(error, exchange, now);
    if (awaited == Awaited::close_reply) on_close_reply(error, exchange, now);
}

void IoSession::on_open_reply(error_code error, const Exchange& exchange, enip::Time now) {
    const auto& response = exchange.response;
    if (!error && !response.status.ok() && state_ == IoState::opening && try_small(response.status)) return;
    if (state_ == IoState::closing) {  // close() was called meanwhile
        const bool is_refused = !error && !response.status.ok();
        if (is_refused || options_.plan.is_null() || (error && !leaves_doubt(error))) {
            finish_close({}, now);
        } else {
            send_close();
        }
        return;
    }
    if (error) {
        if (leaves_doubt(error)) close_in_passing(request_);
        const bool is_nonsense = trouble_of(error) == Trouble::nonsense;
        fail({.reason = is_nonsense ? CloseReason::bad_reply : CloseReason::unreachable, .error = error}, now);
        return;
    }
    if (!response.status.ok()) {
        const auto wrong = check_refusal(request_->triad, response);
        if (wrong) close_in_passing(request_);
        const auto reason = wrong ? CloseReason::bad_reply : CloseReason::refused;
        fail({.reason = reason, .error = wrong, .status = response.status}, now);
        return;
    }
    auto grant = check_open_reply(options_.plan, *request_, response.data, exchange.items, ends_.remote);
    if (grant && consumes() && grant->reply.t_to_o_id != request_->t_to_o_id &&
        surroundings_.is_taken(grant->reply.t_to_o_id)) {
        grant = make_error_code(Error::wrong_connection);
    }
    if (!grant) {
        close_in_passing(request_);
        fail({.reason = CloseReason::bad_reply, .error = grant.error()}, now);
        return;
    }
    on_grant(std::move(*grant), now);
}

/// Another try in the 16-bit form, where that can say the sizes (R-CON-2).
bool IoSession::try_small(const cip::Status& status) {
    const auto fits = [](const cip::ConnectionParameters& parameters) {
        return cip::ConnectionParameters::from_word(parameters.to_word()).size == parameters.size;
    };
    if (!request_->large || status.general != cip::GeneralStatus::service_not_supported || !fits(request_->o_to_t) ||
        !fits(request_->t_to_o)) {
        return false;
    }
    small_only_ = true;
    request_->large = false;
    send_open();
    return true;
}

void IoSession::on_grant(IoGrant grant, enip::Time now) {
    if (grant.group) {
        if (const auto error = surroundings_.join(*grant.group, ends_.local.address)) {
            close_in_passing(request_);
            fail({.reason = CloseReason::no_socket, .error = error}, now);
            return;
        }
    }
    const IoOpened opened{.request = *request_,
                          .reply = grant.reply,
                          .target = grant.target,
                          .receiver = grant.group.value_or(receiver_),
                          .local = ends_.local,
                          .attempt = attempt_};
    if (!options_.plan.is_null()) start_streams(grant, now);
    enter(IoState::open);
    if (events_.opened) events_.opened(opened);
    take_early();
    if (options_.plan.is_null() && state_ == IoState::open) finish_close({}, now);  // there is nothing to keep
}

void IoSession::start_streams(const IoGrant& grant, enip::Time now) {
    const auto& plan = options_.plan;
    opened_at_ = now;
    group_ = grant.group;
    consumer_ = {};
    producer_ = {};
    if (consumes()) {
        expect(grant.reply.t_to_o_id);
        const std::chrono::microseconds interval(grant.reply.t_to_o_api);
        consumer_ = enip::IoConsumer({.format = plan.t_to_o.format,
                                      .size = plan.t_to_o.connection_size(),
                                      .timeout = enip::connection_timeout(interval, plan.multiplier_code)},
                                     now);
    }
    if (produces()) {
        const std::chrono::microseconds interval(grant.reply.o_to_t_api);
        const bool to_group = plan.o_to_t.type == cip::ConnectionType::multicast;
        producer_ =
            enip::IoProducer({.connection_id = grant.reply.o_to_t_id,
                              .format = plan.o_to_t.format,
                              .data_octets = plan.o_to_t.data_octets,
                              .interval = interval,
                              .trigger = plan.trigger,
                              .inhibit = interval / sends_per_interval,
                              .route = {.local = {ends_.local.address, receiver_.port},
                                        .peer = grant.target,
                                        .dscp = dscp_of_priority[static_cast<std::size_t>(plan.o_to_t.priority)],
                                        .ttl = to_group ? multicast_ttl : std::uint8_t{0}}},
                             enip::first_deadline(now, interval));
    }
}

// ------------------------------------------------------------------------------------------------------- closing

void IoSession::close(enip::Time now) {
    open_again_ = false;
    switch (state_) {
        case IoState::idle:
        case IoState::closed:
        case IoState::closing:
            return;
        case IoState::waiting:
        case IoState::connecting:
            stop_awaiting();
            finish_close({}, now);
            return;
        case IoState::opening:  // the answer tells whether there is something to close
            enter(IoState::closing);
            return;
        case IoState::open:
            close_again_ = true;
            send_close();
            return;
    }
}

void IoSession::send_close() {
    enter(IoState::closing);
    if (surroundings_.connected()) {
        surroundings_.request(await(Awaited::close_reply), close_request(*request_), {});
    } else {
        close_again_ = false;
        surroundings_.connect(await(Awaited::session));
    }
}

/// Tells the device to close what it may hold open; whatever it says to that, nobody waits for it. Without a session it
/// is told in the next one.
void IoSession::close_in_passing(const std::optional<cip::ForwardOpen>& open) {
    if (!open || options_.plan.is_null()) return;
    if (surroundings_.connected()) {
        surroundings_.request(++last_ticket_, close_request(*open), {});
    } else {
        owed_close_ = open;
    }
}

void IoSession::on_close_reply(error_code error, const Exchange& exchange, enip::Time now) {
    if (error && std::exchange(close_again_, false) && !surroundings_.connected() && error != Error::timeout) {
        send_close();
        return;
    }
    const auto& status = exchange.response.status;
    IoClosed closed{.error = error};
    if (!error && status.ok()) closed.error = check_close_reply(request_->triad, exchange.response.data);
    // Not found is closed as well (R-CON-36).
    if (!error && !is_failure(status, cip::ConnectionFailure::connection_not_found)) closed.status = status;
    finish_close(std::move(closed), now);
}

void IoSession::finish_close(IoClosed closed, enip::Time now) {
    closed.request = request_;
    tear_down();
    enter(IoState::closed);
    const bool again = std::exchange(open_again_, false);
    if (events_.closed) events_.closed(closed);
    if (again && state_ == IoState::closed) open(now);
}

void IoSession::fail(IoClosed closed, enip::Time now) {
    tear_down();
    closed.request = request_;
    if (options_.reopen && may_pass(closed)) {
        closed.next_try = next_pause(closed);
        retry_at_ = now + *closed.next_try;
        enter(IoState::waiting);
    } else {
        enter(IoState::closed);
    }
    if (events_.closed) events_.closed(closed);
}

milliseconds IoSession::next_pause(const IoClosed& closed) {
    auto pause = pause_;
    pause_ = std::min(2 * pause_, std::max(options_.last_pause, pause_));
    // The device holds our last connection until its patience ends (R-SCN-4).
    if (is_failure(closed.status, cip::ConnectionFailure::duplicate_forward_open)) {
        const auto patience = enip::connection_timeout(options_.plan.o_to_t.rpi, options_.plan.multiplier_code);
        pause = std::max(pause, std::chrono::ceil<milliseconds>(patience));
    }
    return pause;
}

void IoSession::tear_down() {
    stop_awaiting();
    expect(std::nullopt);
    group_.reset();
    early_.clear();
    surroundings_.stop_listening();
}

void IoSession::expect(std::optional<std::uint32_t> id) {
    if (id == expected_id_) return;
    if (expected_id_) surroundings_.forget(*expected_id_);
    expected_id_ = id;
    if (id) surroundings_.expect(*id);
}

// ------------------------------------------------------------------------------------------------------- running

IoSession::Reception IoSession::on_datagram(const IoArrival& arrival) {
    if (arrival.peer.address != ends_.remote.address) return Reception::wrong_source;
    const bool way_fits = group_ ? arrival.local == *group_ : !enip::is_multicast(arrival.local.address);
    if (!way_fits) return Reception::wrong_source;
    if (state_ == IoState::opening) keep_early(arrival);
    // A group and its id are older than this connection, and so may a datagram be; an id of our own is never.
    if (state_ == IoState::open && (!group_ || arrival.time >= opened_at_)) take(arrival);
    return Reception::taken;
}

void IoSession::keep_early(const IoArrival& arrival) {
    if (early_.size() == max_early_datagrams) early_.erase(early_.begin());
    early_.push_back({arrival, {arrival.octets.begin(), arrival.octets.end()}});
}

void IoSession::take_early() {
    for (auto& [arrival, octets] : std::exchange(early_, {})) {
        const auto packet = enip::IoPacket::parse(octets);
        if (!packet || packet->connection_id != expected_id_ || state_ != IoState::open) continue;
        arrival.octets = octets;
        arrival.packet = *packet;
        take(arrival);
    }
}

void IoSession::take(const IoArrival& arrival) {
    if (events_.packet) {
        events_.packet(
            {.source = arrival.peer, .destination = arrival.local, .octets = arrival.octets, .time = arrival.time});
    }
    // A datagram does not revive a connection whose time is over; the timer ends it (R-CON-18).
    if (arrival.time >= consumer_.deadline()) return;
    using Verdict = enip::IoConsumer::Verdict;
    const auto taken = consumer_.take(arrival.packet, std::max(arrival.time, opened_at_));
    if (taken.verdict != Verdict::fresh && taken.verdict != Verdict::repeated) return;
    if (consumer_.counters().accepted == 1) pause_ = options_.first_pause;
    if (events_.input) {
        events_.input({.data = taken.data,
                       .fresh = taken.verdict == Verdict::fresh,
                       .run = taken.run,
                       .sequence = arrival.packet.sequence,
                       .time = arrival.time,
                       .counters = consumer_.counters()});
    }
}

std::optional<enip::Time> IoSession::next_deadline() const {
    if (state_ == IoState::waiting) return retry_at_;
    if (state_ != IoState::open || (!consumes() && !produces())) return std::nullopt;
    auto next = enip::Time::max();
    if (consumes()) next = consumer_.deadline();
    if (produces()) next = std::min(next, producer_.deadline());
    return next;
}

bool IoSession::is_starving(enip::Time now) const {
    return state_ == IoState::open && consumes() && consumer_.deadline() <= now;
}

void IoSession::on_timer(enip::Time now, enip::IoQueue& queue) {
    if (state_ == IoState::waiting && retry_at_ <= now) {
        begin();
        return;
    }
    if (is_starving(now)) {
        close_in_passing(request_);
        fail({.reason = CloseReason::timed_out}, now);
        return;
    }
    if (state_ == IoState::open && produces() && producer_.deadline() <= now) produce(now, queue);
}

void IoSession::trigger(enip::Time now) {
    if (state_ != IoState::open || asking_ || !produces() || options_.plan.trigger == enip::Trigger::cyclic) return;
    ask_for_output();
    if (state_ != IoState::open) return;
    producer_.note(output_, now);
    surroundings_.changed();
}

bool IoSession::ask_for_output() {
    if (!events_.output) return false;
    asking_ = true;
    const bool run = events_.output(output_);
    asking_ = false;
    return run;
}

void IoSession::produce(enip::Time now, enip::IoQueue& queue) {
    const bool run = ask_for_output();
    if (state_ != IoState::open) return;  // the application has closed it instead
    producer_.produce(output_, run, now, queue);
    if (!events_.packet) return;
    const auto& entry = queue.entries().back();
    events_.packet({.sent = true,
                    .source = entry.route.local,
                    .destination = entry.route.peer,
                    .octets = std::as_const(queue).octets(entry),
                    .time = now});
}

}  // namespace servobus::scanner
