// Books about one I/O connection of an originator: what its application has to see, when it is over, what it sends.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "scanner/io_events.hpp"
#include "scanner/io_session.hpp"
#include "tests/sim/judge.hpp"
#include "tests/sim/production_book.hpp"

namespace servobus::sim {

class OriginatorWatch {
public:
    OriginatorWatch(unsigned number, Judge& judge) : number_(number), judge_(&judge) {}

    void opened(const scanner::IoOpened& opened, const scanner::IoPlan& plan, Time now);
    void closed(const scanner::IoClosed& closed, Time now);
    /// close() was called, or the program has gone: nothing is sent and nothing is owed any more.
    void left() { link_.reset(); }

    /// Around the session's own look at a datagram; the application's in between.
    void before(const scanner::IoArrival& arrival);
    void input(const scanner::IoInput& input, Time now);
    void after(Time now);

    void sends(cip::ByteView octets, Time now);
    void was_held_up(Time now) { excused_at_ = now; }
    void settle(Time now);

    struct Counters {
        std::uint64_t opened = 0;
        std::uint64_t timed_out = 0;
        std::uint64_t inputs = 0;
        std::uint64_t dropped = 0;  ///< late, doubled, foreign
    };
    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    struct Link {
        std::uint32_t o_to_t_id = 0;
        std::uint32_t t_to_o_id = 0;
        std::uint32_t target = 0;
        std::optional<enip::Endpoint> group{};
        std::size_t size = 0;
        std::chrono::microseconds timeout{};
        Time opened_at{};
        Time deadline{};
        std::optional<std::uint32_t> sequence{};
        std::optional<std::uint16_t> count{};
        bool count_known = true;  ///< it was not seen of what has overtaken the reply
        ProductionBook production{};
    };
    void report(Invariant invariant, Time now, const std::string& what) const;
    [[nodiscard]] bool fits(const Link& link, const scanner::IoArrival& arrival) const;
    [[nodiscard]] static bool is_newer(const Link& link, std::uint32_t sequence);

    unsigned number_;
    Judge* judge_;
    std::optional<Link> link_{};
    const scanner::IoArrival* arrival_ = nullptr;
    bool expected_ = false;
    bool seen_ = false;
    Time excused_at_{};
    Counters counters_;
};

}  // namespace servobus::sim
