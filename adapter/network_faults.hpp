// The faults that are at work: what becomes of each datagram, reply and open. No socket and no clock; the same seed and
// the same calls give the same fates.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <vector>

#include "adapter/network_fault.hpp"
#include "cip/bytes.hpp"
#include "cip/status.hpp"
#include "enip/endpoint.hpp"
#include "enip/io_queue.hpp"
#include "enip/time.hpp"

namespace servobus::adapter {

class NetworkFaults {
public:
    /// Faults of datagrams and replies at one time; more are not taken.
    static constexpr std::size_t max_active = 64;
    /// Datagrams that are late, in each direction; more are dropped.
    static constexpr std::size_t max_held = 4096;
    /// A datagram that waits to be overtaken waits no longer than this.
    static constexpr std::chrono::seconds reorder_patience{1};

    struct Counters {
        std::uint64_t dropped = 0;
        std::uint64_t delayed = 0;
        std::uint64_t duplicated = 0;
        std::uint64_t reordered = 0;
        std::uint64_t overflowed = 0;  ///< dropped because max_held were waiting
        std::uint64_t silenced = 0;    ///< lost to a cut cable, a freeze or a restart
    };
    struct ReplyCounters {
        std::uint64_t delayed = 0;
        std::uint64_t withheld = 0;
        std::uint64_t opens_refused = 0;
    };
    /// A datagram from outside whose time has come.
    struct Arrival {
        enip::Endpoint peer;
        cip::Bytes octets;
    };

    explicit NetworkFaults(std::uint64_t seed) : random_(seed) {}

    /// A fault begins. CloseSessions is over at once and none of this object's business. False: there are too many.
    [[nodiscard]] bool begin(const NetworkFault& fault, enip::Time now);
    /// What is over by `now` ends. To be called before anything else at a time.
    void advance(enip::Time now);
    /// When something has to be done: a datagram is due, or a silence is over.
    [[nodiscard]] std::optional<enip::Time> next_deadline() const;

    /// Nothing goes in or out.
    [[nodiscard]] bool is_silent() const { return cable_.on() || is_down() || is_frozen(); }
    /// Nobody is there to accept a connection.
    [[nodiscard]] bool is_down() const { return down_.on(); }
    [[nodiscard]] bool is_frozen() const { return freeze_.on(); }
    /// The time of everything on the bus side, which stands still in a freeze; and back, while there is none.
    [[nodiscard]] enip::Time bus_time(enip::Time now) const;
    [[nodiscard]] enip::Time true_time(enip::Time bus) const { return bus + frozen_; }
    /// By how much the two differ, but for a freeze that goes on.
    [[nodiscard]] enip::Time::duration frozen() const { return frozen_; }

    /// An I/O datagram has come: true when it counts now. Others, and copies, are told by take_in().
    [[nodiscard]] bool filter_in(enip::Endpoint peer, cip::ByteView octets, enip::Time now);
    [[nodiscard]] std::optional<Arrival> take_in(enip::Time now);
    /// What has been produced, to be called before it is sent, and at deadlines.
    void filter_out(enip::IoQueue& queue, enip::Time now);
    /// filter_out() would do nothing.
    [[nodiscard]] bool leaves_output_alone() const { return io_.empty() && waiting_[1].empty() && !is_silent(); }

    /// How much later a reply leaves; nullopt: never.
    [[nodiscard]] std::optional<std::chrono::microseconds> reply_delay();
    /// What a Forward_Open is refused with; nullopt: it is looked at.
    [[nodiscard]] std::optional<cip::Status> refuse_open();

    /// Of what the drive receives, and of what it sends.
    [[nodiscard]] const Counters& in() const { return counters_[0]; }
    [[nodiscard]] const Counters& out() const { return counters_[1]; }
    [[nodiscard]] const ReplyCounters& replies() const { return reply_counters_; }
    /// Faults that are at work now.
    [[nodiscard]] std::size_t active() const;

private:
    enum class Way : std::uint8_t { in, out };
    template <class Fault>
    struct Active {
        Fault fault;
        std::optional<enip::Time> end{};
        bool used_up = false;
    };
    struct Silence {
        std::optional<enip::Time> begin{};
        std::optional<enip::Time> end{};  ///< nullopt: until restored
        [[nodiscard]] bool on() const { return begin.has_value(); }
        [[nodiscard]] bool is_over(enip::Time now) const { return on() && end && *end <= now; }
        void extend(double seconds, enip::Time now);
    };
    struct Fate {
        bool gone = false;
        bool behind_next = false;
        unsigned copies = 1;
        std::chrono::microseconds delay{0};
    };
    struct Held {
        enip::Endpoint peer{};
        enip::IoRoute route{};
        cip::Bytes octets{};
        bool behind_next = false;
    };
    using Waiting = std::multimap<enip::Time, Held>;

    [[nodiscard]] Counters& counters(Way way) { return counters_[static_cast<std::size_t>(way)]; }
    [[nodiscard]] Waiting& waiting(Way way) { return waiting_[static_cast<std::size_t>(way)]; }
    [[nodiscard]] double chance();
    [[nodiscard]] Fate fate_of(Way way);
    void hold(Way way, const Fate& fate, const Held& held, enip::Time now);
    void let_overtaken(Way way, cip::ByteView octets, enip::Time now);
    void end_freeze(enip::Time end);
    void restore(enip::Time now);

    std::mt19937_64 random_;
    std::vector<Active<fault::DisturbIo>> io_;
    std::vector<Active<fault::DisturbReplies>> replies_;
    std::vector<fault::RefuseOpen> refusals_;
    Silence cable_;
    Silence freeze_;
    Silence down_;
    enip::Time::duration frozen_{0};  ///< by freezes that are over
    std::array<Waiting, 2> waiting_;
    std::array<Counters, 2> counters_{};
    ReplyCounters reply_counters_{};
    enip::IoQueue scratch_;
};

}  // namespace servobus::adapter
