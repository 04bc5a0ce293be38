#include "tests/bench/io/request_run.hpp"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <array>
#include <deque>

#include "tests/bench/io/image.hpp"

namespace servobus::bench {
namespace {

class Asker {
public:
    Asker(RequestStream& stream, std::size_t reply_octets) : stream_(stream), reply_octets_(reply_octets) {}

    void ask(std::size_t count) {
        out_.clear();
        for (std::size_t i = 0; i < count; ++i) {
            if (stream_.sequence_at) put16(stream_.frame, *stream_.sequence_at, ++stream_.sequence);
            out_.insert(out_.end(), stream_.frame.begin(), stream_.frame.end());
        }
        const auto now = monotonic();
        asked_.insert(asked_.end(), count, now);
        send_all(stream_.socket, out_);
    }

    /// Returns how many replies have become complete.
    std::size_t take(std::vector<double>& waits_us) {
        std::array<std::uint8_t, 65536> in;  // NOLINT(cppcoreguidelines-pro-type-member-init)
        const auto got = ::recv(stream_.socket.number(), in.data(), in.size(), MSG_DONTWAIT);
        if (got == 0) give_up("the session was closed");
        if (got < 0) return 0;
        const auto now = monotonic();
        octets_ += static_cast<std::size_t>(got);
        const auto complete = octets_ / reply_octets_;
        octets_ %= reply_octets_;
        for (std::size_t i = 0; i < complete; ++i) {
            if (asked_.empty()) give_up("there are more replies than requests");
            waits_us.push_back(static_cast<double>(now - asked_.front()) / 1000);
            asked_.pop_front();
        }
        return complete;
    }

    [[nodiscard]] bool waits() const { return !asked_.empty(); }

private:
    RequestStream& stream_;
    std::size_t reply_octets_;
    std::size_t octets_ = 0;  ///< of a reply that is not complete
    std::deque<Nanoseconds> asked_;
    cip::Bytes out_;
};

}  // namespace

RequestRun run_requests(std::vector<RequestStream>& streams, std::size_t depth, std::size_t reply_octets,
                        double seconds) {
    const Descriptor poll(::epoll_create1(EPOLL_CLOEXEC));
    std::vector<Asker> askers;
    for (auto& stream : streams) {
        epoll_event event{.events = EPOLLIN, .data = {.u64 = askers.size()}};
        if (::epoll_ctl(poll.number(), EPOLL_CTL_ADD, stream.socket.number(), &event) != 0) give_up_errno("epoll_ctl");
        askers.emplace_back(stream, reply_octets);
    }
    RequestRun run;
    const auto begin = monotonic();
    const auto end = begin + static_cast<Nanoseconds>(seconds * 1e9);
    for (auto& asker : askers) asker.ask(depth);
    auto waiting = askers.size();
    while (waiting > 0) {
        std::array<epoll_event, 64> events{};
        const auto ready = ::epoll_wait(poll.number(), events.data(), static_cast<int>(events.size()), 5000);
        if (ready == 0) give_up("a request was not answered within 5 s");
        const bool over = monotonic() >= end;
        for (int i = 0; i < ready; ++i) {
            auto& asker = askers[events[static_cast<std::size_t>(i)].data.u64];
            const auto complete = asker.take(run.waits_us);
            if (complete == 0) continue;
            if (!over) {
                asker.ask(complete);
            } else if (!asker.waits()) {
                --waiting;
            }
        }
    }
    run.seconds = static_cast<double>(monotonic() - begin) / 1e9;
    return run;
}

}  // namespace servobus::bench
