#include "enip/io_stream.hpp"

#include <algorithm>

#include "cip/wire.hpp"

namespace servobus::enip {
namespace {

using std::chrono::microseconds;

/// Intervals that a producer makes up for when it comes late.
constexpr int most_intervals_late = 16;

bool is_newer(std::uint32_t sequence, std::uint32_t last) { return static_cast<std::int32_t>(sequence - last) > 0; }

std::span<std::uint8_t> put(std::span<std::uint8_t> octets, std::uint32_t value, std::size_t size) {
    for (auto& octet : octets.first(size)) {
        octet = static_cast<std::uint8_t>(value);
        value >>= 8;
    }
    return octets.subspan(size);
}

}  // namespace

IoConsumer::IoConsumer(const Settings& settings, Time now)
    : settings_(settings), deadline_(now + std::max<microseconds>(settings.timeout, first_packet_patience)) {}

bool IoConsumer::fits(std::size_t octets) const {
    if (octets == settings_.size) return true;
    return settings_.format == cip::RealTimeFormat::zero_length && octets == cip::sequence_count_octets;
}

IoConsumer::Arrival IoConsumer::take(const IoPacket& packet, Time now) {
    if (!fits(packet.data.size())) {
        ++counters_.wrong_size;
        return {.verdict = Verdict::wrong_size};
    }
    if (sequence_ && !is_newer(packet.sequence, *sequence_)) {
        ++counters_.stale;
        return {.verdict = Verdict::stale};
    }
    if (sequence_) counters_.lost += packet.sequence - *sequence_ - 1;
    sequence_ = packet.sequence;
    ++counters_.accepted;
    deadline_ = now + settings_.timeout;

    cip::Reader reader(packet.data);
    const auto count = reader.u16();
    const bool run = settings_.format == cip::RealTimeFormat::header32      ? (reader.u32() & cip::run_bit) != 0
                     : settings_.format == cip::RealTimeFormat::zero_length ? reader.remaining() > 0
                                                                            : true;
    Arrival arrival{.verdict = count_ == count ? Verdict::repeated : Verdict::fresh,
                    .run = run,
                    .run_began = run && !run_,
                    .run_ended = !run && run_,
                    .data = reader.rest()};
    count_ = count;
    run_ = run;
    return arrival;
}

IoProducer::IoProducer(const Settings& settings, Time first)
    : settings_(settings), deadline_(first), last_data_(settings_.data_octets) {}

Time IoProducer::deadline() const { return changed_ ? std::min(deadline_, inhibited_until_) : deadline_; }

void IoProducer::note(cip::ByteView data, Time now) {
    if (settings_.trigger == Trigger::cyclic || counters_.sent == 0 || changed_) return;
    changed_ = !std::ranges::equal(data, last_data_);
    if (changed_) inhibited_until_ = std::max(inhibited_until_, now);
}

void IoProducer::produce(cip::ByteView data, bool run, Time now, IoQueue& queue) {
    const bool idle_is_silence = settings_.format == cip::RealTimeFormat::zero_length && !run;
    const bool has_data = settings_.format != cip::RealTimeFormat::heartbeat && !idle_is_silence;
    const auto octets = has_data ? data : cip::ByteView{};
    // New data never goes out under an old count; the same data keeps its count, as a consumer expects (R-IO-5).
    if (counters_.sent == 0 || run != run_ || !std::ranges::equal(data, last_data_)) ++count_;
    run_ = run;
    std::ranges::copy(data, last_data_.begin());
    ++sequence_;

    const auto size =
        idle_is_silence ? cip::sequence_count_octets : cip::connection_size(settings_.format, octets.size());
    auto rest =
        begin_io_packet(queue.add(settings_.route, io_packet_overhead + size), settings_.connection_id, sequence_);
    rest = put(rest, count_, cip::sequence_count_octets);
    if (settings_.format == cip::RealTimeFormat::header32) {
        rest = put(rest, run ? cip::run_bit : 0, cip::run_idle_octets);
    }
    std::ranges::copy(octets, rest.begin());
    ++counters_.sent;
    changed_ = false;
    inhibited_until_ = now + settings_.inhibit;
    advance(now);
}

// From the previous deadline, so that the rate is kept (decision 3): who comes late sends what was missed at once. After
// a longer pause that would be a burst that helps nobody, so those intervals are left out. A datagram that a change has
// sent starts a new interval.
void IoProducer::advance(Time now) {
    if (now < deadline_) {
        deadline_ = now + settings_.interval;
        return;
    }
    deadline_ += settings_.interval;
    if (now - deadline_ < most_intervals_late * settings_.interval) return;
    const auto passed = (now - deadline_) / settings_.interval + 1;
    counters_.skipped += static_cast<std::uint64_t>(passed);
    deadline_ += passed * settings_.interval;
}

namespace {

Time first_deadline_on(Time::duration grid, Time now) { return now + (grid - now.time_since_epoch() % grid); }

}  // namespace

Time first_deadline(Time now, microseconds interval) {
    return first_deadline_on(std::min(production_grid, interval), now);
}

Time first_shared_deadline(Time now, microseconds interval, microseconds phase) {
    if (interval % shared_grid != microseconds(0)) return first_deadline(now, interval);
    return first_deadline_on(shared_grid, now - phase) + phase;
}

}  // namespace servobus::enip
