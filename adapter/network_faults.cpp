#include "adapter/network_faults.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

namespace servobus::adapter {
namespace {

using enip::Time;
using std::chrono::microseconds;

microseconds from_seconds(double seconds) { return microseconds(std::llround(seconds * 1e6)); }
microseconds from_milliseconds(double milliseconds) { return from_seconds(milliseconds / 1000); }

std::optional<Time> end_of(double seconds, Time now) {
    return seconds > 0 ? std::optional(now + from_seconds(seconds)) : std::nullopt;
}

// Datagrams of one connection are told apart from others by it. One without a whole id is of none.
cip::ByteView connection_id(cip::ByteView octets) {
    constexpr std::size_t offset = 6;
    constexpr std::size_t size = 4;
    return octets.size() >= offset + size ? octets.subspan(offset, size) : cip::ByteView{};
}

template <class Actives>
void erase_ended(Actives& actives, Time now) {
    std::erase_if(actives, [&](const auto& each) { return each.used_up || (each.end && *each.end <= now); });
}

// One more that it has met. A count that has come to its end is not 0, which would be none.
template <class Active>
void use(Active& active) {
    if (active.fault.count > 0 && --active.fault.count == 0) active.used_up = true;
}

}  // namespace

void NetworkFaults::Silence::extend(double seconds, Time now) {
    const bool endless = on() && !end;
    const auto until = end_of(seconds, now);
    begin = begin.value_or(now);
    end = endless || !until ? std::nullopt : std::optional(std::max(*until, end.value_or(*until)));
}

bool NetworkFaults::begin(const NetworkFault& fault, Time now) {
    advance(now);
    const bool room = io_.size() + replies_.size() + refusals_.size() < max_active;
    return std::visit(
        [&](const auto& each) {
            using Fault = std::decay_t<decltype(each)>;
            if constexpr (std::is_same_v<Fault, fault::DisturbIo>) {
                if (room) io_.push_back({each, end_of(each.seconds, now)});
                return room;
            } else if constexpr (std::is_same_v<Fault, fault::DisturbReplies>) {
                if (room) replies_.push_back({each, end_of(each.seconds, now)});
                return room;
            } else if constexpr (std::is_same_v<Fault, fault::RefuseOpen>) {
                if (room) refusals_.push_back(each);
                return room;
            } else if constexpr (std::is_same_v<Fault, fault::CutCable>) {
                cable_.extend(each.seconds, now);
            } else if constexpr (std::is_same_v<Fault, fault::Freeze>) {
                freeze_.extend(each.seconds, now);
            } else if constexpr (std::is_same_v<Fault, fault::Restart>) {
                if (freeze_.on()) end_freeze(now);
                down_.extend(each.seconds, now);
                if (each.seconds <= 0) down_ = {};
            } else if constexpr (std::is_same_v<Fault, fault::RestoreNetwork>) {
                restore(now);
            }
            return true;
        },
        fault);
}

void NetworkFaults::advance(Time now) {
    erase_ended(io_, now);
    erase_ended(replies_, now);
    if (cable_.is_over(now)) cable_ = {};
    if (down_.is_over(now)) down_ = {};
    if (freeze_.is_over(now)) end_freeze(*freeze_.end);
}

// What is late already still comes.
void NetworkFaults::restore(Time now) {
    io_.clear();
    replies_.clear();
    refusals_.clear();
    cable_ = {};
    down_ = {};
    if (freeze_.on()) end_freeze(now);
}

void NetworkFaults::end_freeze(Time end) {
    frozen_ += end - *freeze_.begin;
    freeze_ = {};
}

Time NetworkFaults::bus_time(Time now) const { return freeze_.begin.value_or(now) - frozen_; }

std::optional<Time> NetworkFaults::next_deadline() const {
    std::optional<Time> next;
    const auto take_earlier = [&](std::optional<Time> time) {
        if (time && (!next || *time < *next)) next = time;
    };
    for (const auto& waiting : waiting_) {
        if (!waiting.empty()) take_earlier(waiting.begin()->first);
    }
    for (const auto* silence : {&cable_, &freeze_, &down_}) take_earlier(silence->end);
    return next;
}

std::size_t NetworkFaults::active() const {
    std::size_t count = io_.size() + replies_.size() + refusals_.size();
    for (const auto* silence : {&cable_, &freeze_, &down_}) count += silence->on() ? 1 : 0;
    return count;
}

// From 0 to 1, and never 1.
double NetworkFaults::chance() { return static_cast<double>(random_() >> 11U) * 0x1p-53; }

// All faults at work have their turn, in the order in which they began; what is lost is not late as well.
NetworkFaults::Fate NetworkFaults::fate_of(Way way) {
    Fate fate;
    const auto other = way == Way::in ? fault::Direction::t_to_o : fault::Direction::o_to_t;
    auto& counted = counters(way);
    for (auto& active : io_) {
        const auto& fault = active.fault;
        if (active.used_up || fault.direction == other || chance() >= fault.share) continue;
        switch (fault.kind) {
            case fault::DisturbIo::Kind::drop:
                ++counted.dropped;
                fate.gone = true;
                break;
            case fault::DisturbIo::Kind::delay:
                ++counted.delayed;
                fate.delay += from_milliseconds(fault.milliseconds + fault.jitter * chance());
                break;
            case fault::DisturbIo::Kind::duplicate:
                ++counted.duplicated;
                ++fate.copies;
                break;
            case fault::DisturbIo::Kind::reorder:
                ++counted.reordered;
                fate.behind_next = true;
                break;
        }
        use(active);
        if (fate.gone) break;
    }
    return fate;
}

void NetworkFaults::hold(Way way, const Fate& fate, const Held& held, Time now) {
    const bool behind_next = fate.behind_next && fate.delay <= microseconds(0);
    const auto due = behind_next ? now + reorder_patience : now + fate.delay;
    for (unsigned copy = 0; copy < fate.copies; ++copy) {
        if (waiting(way).size() >= max_held) {
            ++counters(way).overflowed;
            continue;
        }
        waiting(way).emplace(due, held)->second.behind_next = behind_next;
    }
}

// One has gone by: those of its connection that waited for that follow at once.
void NetworkFaults::let_overtaken(Way way, cip::ByteView octets, Time now) {
    auto& all = waiting(way);
    const auto id = connection_id(octets);
    for (auto each = all.begin(); each != all.end();) {
        const auto found = each++;
        if (!found->second.behind_next || !std::ranges::equal(connection_id(found->second.octets), id)) continue;
        auto node = all.extract(found);
        node.key() = now;
        node.mapped().behind_next = false;
        all.insert(std::move(node));
    }
}

bool NetworkFaults::filter_in(enip::Endpoint peer, cip::ByteView octets, Time now) {
    if (is_silent()) {
        ++counters(Way::in).silenced;
        return false;
    }
    if (io_.empty() && waiting(Way::in).empty()) return true;
    auto fate = fate_of(Way::in);
    if (fate.gone) return false;
    const Held held{.peer = peer, .octets = {octets.begin(), octets.end()}};
    if (fate.behind_next || fate.delay > microseconds(0)) {
        hold(Way::in, fate, held, now);
        return false;
    }
    --fate.copies;
    hold(Way::in, fate, held, now);
    let_overtaken(Way::in, octets, now);
    return true;
}

std::optional<NetworkFaults::Arrival> NetworkFaults::take_in(Time now) {
    auto& all = waiting(Way::in);
    while (!all.empty() && all.begin()->first <= now) {
        auto held = std::move(all.extract(all.begin()).mapped());
        if (!is_silent()) return Arrival{held.peer, std::move(held.octets)};
        ++counters(Way::in).silenced;
    }
    return std::nullopt;
}

void NetworkFaults::filter_out(enip::IoQueue& queue, Time now) {
    auto& all = waiting(Way::out);
    if (is_silent()) {
        counters(Way::out).silenced += queue.entries().size();
        queue.clear();
    }
    if (io_.empty() && all.empty()) return;
    scratch_.clear();
    const auto send = [&](const enip::IoRoute& route, cip::ByteView octets) {
        std::ranges::copy(octets, scratch_.add(route, octets.size()).begin());
    };
    const auto send_due = [&] {
        while (!all.empty() && all.begin()->first <= now) {
            const auto held = std::move(all.extract(all.begin()).mapped());
            if (is_silent()) {
                ++counters(Way::out).silenced;
            } else {
                send(held.route, held.octets);
            }
        }
    };
    send_due();
    for (const auto& entry : std::as_const(queue).entries()) {
        const auto octets = std::as_const(queue).octets(entry);
        const auto fate = fate_of(Way::out);
        if (fate.gone) continue;
        if (fate.behind_next || fate.delay > microseconds(0)) {
            hold(Way::out, fate, {.route = entry.route, .octets = {octets.begin(), octets.end()}}, now);
            continue;
        }
        for (unsigned copy = 0; copy < fate.copies; ++copy) send(entry.route, octets);
        let_overtaken(Way::out, octets, now);
        send_due();
    }
    std::swap(queue, scratch_);
}

std::optional<microseconds> NetworkFaults::reply_delay() {
    microseconds delay{0};
    for (auto& active : replies_) {
        if (active.used_up) continue;
        use(active);
        if (active.fault.kind == fault::DisturbReplies::Kind::withhold) {
            ++reply_counters_.withheld;
            return std::nullopt;
        }
        ++reply_counters_.delayed;
        delay += from_milliseconds(active.fault.milliseconds);
    }
    return delay;
}

std::optional<cip::Status> NetworkFaults::refuse_open() {
    if (refusals_.empty()) return std::nullopt;
    auto& refusal = refusals_.front();
    cip::Status status(static_cast<cip::GeneralStatus>(refusal.general));
    if (refusal.extended != 0) status.extended.push_back(refusal.extended);
    if (--refusal.count == 0) refusals_.erase(refusals_.begin());
    ++reply_counters_.opens_refused;
    return status;
}

}  // namespace servobus::adapter
