// The two ends of one direction of a class 1 connection: what is accepted and when it is too late, what is sent and when.
// The target consumes O->T and produces T->O, the originator the other way round; the rules are the same.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/real_time_format.hpp"
#include "enip/io_packet.hpp"
#include "enip/io_queue.hpp"
#include "enip/time.hpp"

namespace servobus::enip {

/// Before the first datagram has come, a connection lives at least this long (R-CON-19).
inline constexpr std::chrono::seconds first_packet_patience{10};

/// Interval times multiplier: what a consumer waits for the next datagram (R-CON-6, R-CON-18). `code` is 0 to 7.
[[nodiscard]] constexpr std::chrono::microseconds connection_timeout(std::chrono::microseconds interval,
                                                                     std::uint8_t code) {
    return interval * (std::int64_t{4} << code);
}

/// Receives datagrams of one connection, whose id and source address its owner has checked.
class IoConsumer {
public:
    struct Settings {
        cip::RealTimeFormat format = cip::RealTimeFormat::modeless;
        std::size_t size = 0;  ///< of the connection: what the data item has to have
        std::chrono::microseconds timeout{};
    };
    enum class Verdict : std::uint8_t {
        fresh,       ///< data that has not been seen: apply it
        repeated,    ///< the same data once more (R-IO-5); it keeps the connection alive
        stale,       ///< its sequence number is not newer: dropped without effect
        wrong_size,  ///< dropped without effect (R-IO-8)
    };
    struct Arrival {
        Verdict verdict;
        bool run = false;        ///< what the sender's mode is
        bool run_began = false;  ///< from idle to run: the data counts whatever its sequence count (R-IO-6)
        bool run_ended = false;
        cip::ByteView data{};  ///< the application's octets; none in a heartbeat and in idle of zero_length
    };
    struct Counters {
        std::uint64_t accepted = 0;  ///< fresh and repeated
        std::uint64_t lost = 0;      ///< numbers that were left out
        std::uint64_t stale = 0;     ///< late, duplicated or reordered
        std::uint64_t wrong_size = 0;
    };

    IoConsumer() = default;
    /// The watchdog starts now: when the target has sent its reply, when the originator has got it.
    IoConsumer(const Settings& settings, Time now);

    [[nodiscard]] Arrival take(const IoPacket& packet, Time now);

    /// When the connection is over unless something comes before.
    [[nodiscard]] Time deadline() const { return deadline_; }
    /// Whether any datagram has been accepted.
    [[nodiscard]] bool alive() const { return sequence_.has_value(); }
    [[nodiscard]] bool run() const { return run_; }
    [[nodiscard]] const Counters& counters() const { return counters_; }
    [[nodiscard]] const Settings& settings() const { return settings_; }

private:
    [[nodiscard]] bool fits(std::size_t octets) const;

    Settings settings_{};
    Time deadline_{};
    std::optional<std::uint32_t> sequence_{};
    std::optional<std::uint16_t> count_{};
    bool run_ = false;
    Counters counters_{};
};

/// When a producer sends beside its interval (R-CON-5, R-CON-50).
enum class Trigger : std::uint8_t { cyclic = 0, change_of_state = 1, application = 2 };

/// Sends the datagrams of one connection.
class IoProducer {
public:
    struct Settings {
        std::uint32_t connection_id = 0;
        cip::RealTimeFormat format = cip::RealTimeFormat::modeless;
        std::size_t data_octets = 0;  ///< of the application
        std::chrono::microseconds interval{};
        Trigger trigger = Trigger::cyclic;
        std::chrono::microseconds inhibit{};  ///< between two datagrams, for all triggers but cyclic (R-CON-51)
        IoRoute route{};
    };
    struct Counters {
        std::uint64_t sent = 0;
        std::uint64_t skipped = 0;  ///< intervals that had passed too long ago when somebody came to send
    };

    IoProducer() = default;
    /// The first datagram is due at `first`.
    IoProducer(const Settings& settings, Time first);

    /// When the next datagram is due: the interval's end, or that of the inhibit time while a change waits.
    [[nodiscard]] Time deadline() const;
    /// To be called when the data may have changed: marks what a change of state has to send.
    void note(cip::ByteView data, Time now);
    /// Appends the next datagram and moves the deadline on. `data` has Settings::data_octets; `run` is told where the
    /// format can tell it.
    void produce(cip::ByteView data, bool run, Time now, IoQueue& queue);

    [[nodiscard]] const Settings& settings() const { return settings_; }
    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    void advance(Time now);

    Settings settings_{};
    Time deadline_{};
    Time inhibited_until_{};
    bool changed_ = false;
    std::uint32_t sequence_ = 0;
    std::uint16_t count_ = 0;
    bool run_ = false;
    std::vector<std::uint8_t> last_data_{};
    Counters counters_{};
};

/// Deadlines of different connections fall on multiples of this.
inline constexpr std::chrono::microseconds production_grid{250};

/// The first deadline of a producer that may start at `now`: on a grid that all producers share, so that many of them
/// are due together and leave in one system call. At most `interval`, and at most production_grid, later.
[[nodiscard]] Time first_deadline(Time now, std::chrono::microseconds interval);

/// Intervals that are a multiple of this have deadlines together, once in it: who has many of them wakes up once for all.
inline constexpr std::chrono::microseconds shared_grid{1000};

/// The same for one of many producers: when `interval` is a multiple of shared_grid, `phase` behind one of its multiples
/// and at most shared_grid later; otherwise first_deadline().
[[nodiscard]] Time first_shared_deadline(Time now, std::chrono::microseconds interval, std::chrono::microseconds phase);

}  // namespace servobus::enip
