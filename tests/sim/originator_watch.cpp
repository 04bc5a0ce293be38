#include "tests/sim/originator_watch.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cip/wire.hpp"

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;
using std::chrono::microseconds;

std::int64_t in_microseconds(Time::duration time) { return std::chrono::duration_cast<microseconds>(time).count(); }

}  // namespace

void OriginatorWatch::report(Invariant invariant, Time now, const std::string& what) const {
    judge_->report(invariant, now, fmt::format("connection {}: {}", number_, what));
}

void OriginatorWatch::opened(const scanner::IoOpened& opened, const scanner::IoPlan& plan, Time now) {
    ++counters_.opened;
    const auto timeout = opened.t_to_o_interval() * (std::int64_t{4} << plan.multiplier_code);
    Link link{.o_to_t_id = opened.reply.o_to_t_id,
              .t_to_o_id = opened.reply.t_to_o_id,
              .target = opened.target.address,
              .size = plan.t_to_o.connection_size(),
              .timeout = timeout,
              .opened_at = now,
              .deadline = now + std::max<microseconds>(timeout, 10s)};
    if (plan.t_to_o.type == cip::ConnectionType::multicast) link.group = opened.receiver;
    const auto interval = opened.o_to_t_interval();
    link.production = ProductionBook({interval, interval / 4, plan.trigger == enip::Trigger::cyclic}, now);
    link_ = link;
}

void OriginatorWatch::closed(const scanner::IoClosed& closed, Time now) {
    if (closed.reason == scanner::CloseReason::timed_out) {
        ++counters_.timed_out;
        if (!link_) {
            report(Invariant::originator_timeout_early, now, "it times out, and was not open");
        } else if (now < link_->deadline) {
            report(Invariant::originator_timeout_early, now,
                   fmt::format("it is given up {} us before its time", in_microseconds(link_->deadline - now)));
        } else if (now > link_->deadline && now != excused_at_) {
            report(Invariant::originator_timeout_late, now,
                   fmt::format("it is given up {} us after its time", in_microseconds(now - link_->deadline)));
        }
    }
    link_.reset();
}

bool OriginatorWatch::is_newer(const Link& link, std::uint32_t sequence) {
    return !link.sequence || static_cast<std::int32_t>(sequence - *link.sequence) > 0;
}

bool OriginatorWatch::fits(const Link& link, const scanner::IoArrival& arrival) const {
    const bool way = link.group ? arrival.local == *link.group && arrival.time >= link.opened_at
                                : !enip::is_multicast(arrival.local.address);
    return way && arrival.peer.address == link.target && arrival.packet.connection_id == link.t_to_o_id &&
           arrival.packet.data.size() == link.size;
}

void OriginatorWatch::before(const scanner::IoArrival& arrival) {
    arrival_ = &arrival;
    seen_ = false;
    expected_ =
        link_ && fits(*link_, arrival) && arrival.time < link_->deadline && is_newer(*link_, arrival.packet.sequence);
}

void OriginatorWatch::input(const scanner::IoInput& input, Time now) {
    ++counters_.inputs;
    seen_ = true;
    if (!link_) {
        report(Invariant::from_its_own_connection, now, "data of a connection that is not open");
        return;
    }
    if (!is_newer(*link_, input.sequence)) {
        report(Invariant::in_order, now, fmt::format("number {} after {}", input.sequence, *link_->sequence));
    }
    link_->sequence = input.sequence;
    if (arrival_ == nullptr) {  // it has overtaken the reply, and was kept
        if (now != link_->opened_at) report(Invariant::from_its_own_connection, now, "data out of nowhere");
        link_->deadline = now + link_->timeout;
        link_->count_known = false;
        return;
    }
    const auto& arrival = *arrival_;
    if (!fits(*link_, arrival) ||
        !std::ranges::equal(input.data, arrival.packet.data.subspan(cip::sequence_count_octets))) {
        report(Invariant::from_its_own_connection, now, fmt::format("number {} is not for it", input.sequence));
    }
    if (arrival.time >= link_->deadline) {
        report(Invariant::originator_timeout_late, now,
               fmt::format("number {} came {} us after its time was over", input.sequence,
                           in_microseconds(arrival.time - link_->deadline)));
    }
    const auto count = cip::Reader(arrival.packet.data).u16();
    if (link_->count_known && input.fresh != (link_->count != count)) {
        report(Invariant::in_order, now, "old data is called fresh, or the other way round");
    }
    link_->count = count;
    link_->count_known = true;
    link_->deadline = std::max(arrival.time, link_->opened_at) + link_->timeout;
}

void OriginatorWatch::after(Time now) {
    if (expected_ && !seen_) {
        report(Invariant::nothing_good_is_dropped, now,
               fmt::format("number {} has not reached the application", arrival_->packet.sequence));
    }
    if (!seen_) ++counters_.dropped;
    arrival_ = nullptr;
}

void OriginatorWatch::sends(cip::ByteView octets, Time now) {
    const auto packet = enip::IoPacket::parse(octets);
    if (!link_ || !packet || packet->connection_id != link_->o_to_t_id) {
        report(Invariant::produced_for_somebody, now, "a datagram leaves, and the connection is not open");
        return;
    }
    const auto fault = link_->production.take(packet->sequence, now, now == excused_at_);
    if (fault) report(fault->invariant, now, fault->what);
}

void OriginatorWatch::settle(Time now) {
    if (!link_) return;
    if (link_->deadline <= now) {
        report(Invariant::originator_timeout_late, now,
               fmt::format("it is open {} us after its time", in_microseconds(now - link_->deadline)));
    }
    if (link_->production.is_overdue(now)) report(Invariant::produced_in_time, now, "a datagram is overdue");
}

}  // namespace servobus::sim
