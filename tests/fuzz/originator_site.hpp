// One I/O connection of an originator, whose device is whoever drives this: what the session asks for is written down, and
// time is a number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <set>
#include <vector>

#include "scanner/io_session.hpp"

namespace servobus::fuzz {

class OriginatorSite : private scanner::IoSession::Surroundings {
public:
    static constexpr enip::Endpoint device{0xC0A80264, enip::tcp_port};
    static constexpr enip::Endpoint ourselves{0xC0A80201, 50000};

    struct Asked {
        std::uint64_t ticket;
        cip::Request request;
    };

    explicit OriginatorSite(scanner::IoPlan plan)
        : session(options_of(std::move(plan)),
                  {.input = [this](const scanner::IoInput& input) { sizes.push_back(input.data.size()); },
                   .closed = [this](const scanner::IoClosed& closed) { reasons.push_back(closed.reason); }},
                  numbers_, *this) {}

    /// Up to the Forward_Open, which then waits in `asked`.
    void begin() {
        session.open(now);
        reach();
    }
    /// The device takes the TCP connection that was wanted last, if any.
    void reach() {
        if (!wanted_) return;
        const auto ticket = *wanted_;
        wanted_.reset();
        tcp_ = true;
        session.on_connected(ticket, {}, {ourselves, device}, now);
    }
    /// The oldest request is answered.
    void answer(const cip::Response& response, std::vector<enip::Item> items = {}) {
        if (asked.empty()) return;
        const auto ticket = asked.front().ticket;
        asked.pop_front();
        session.on_reply(ticket, {}, {response, std::move(items)}, now);
    }
    void refuse_tcp() {
        if (!wanted_) return;
        const auto ticket = *wanted_;
        wanted_.reset();
        session.on_connected(ticket, make_error_code(scanner::Error::timeout), {}, now);
    }
    [[nodiscard]] bool owes_an_answer() const { return wanted_.has_value() || !asked.empty(); }
    /// Whoever waits for an answer over it is told.
    void lose_tcp() {
        tcp_ = false;
        while (!asked.empty()) {
            const auto ticket = asked.front().ticket;
            asked.pop_front();
            session.on_reply(ticket, make_error_code(scanner::Error::closed), {}, now);
        }
    }
    scanner::IoSession::Reception receive(cip::ByteView octets, const enip::IoPacket& packet, bool from_device = true) {
        const auto address = device.address + (from_device ? 0U : 1U);
        return session.on_datagram({{address, enip::io_port}, {ourselves.address, enip::io_port}, octets, packet, now});
    }
    /// In one step, as when the timer comes late. What is sent is dropped.
    void advance(enip::Time::duration duration) {
        now += duration;
        session.on_timer(now, queue_);
        queue_.clear();
    }

    enip::Time now{std::chrono::hours(1)};
    std::deque<Asked> asked;
    std::multiset<std::uint32_t> expected;  ///< T->O ids
    std::vector<std::size_t> sizes;         ///< of the inputs
    std::vector<scanner::CloseReason> reasons;

private:
    static scanner::IoOptions options_of(scanner::IoPlan plan) {
        scanner::IoOptions options;
        options.host = "device";
        options.plan = std::move(plan);
        return options;
    }

    void connect(std::uint64_t ticket) override { wanted_ = ticket; }
    [[nodiscard]] bool connected() const override { return tcp_; }
    void request(std::uint64_t ticket, const cip::Request& request, std::vector<enip::Item>) override {
        asked.push_back({ticket, request});
    }
    [[nodiscard]] boost::system::result<enip::Endpoint> listen(std::uint32_t address) override {
        return enip::Endpoint{address, enip::io_port};
    }
    [[nodiscard]] scanner::error_code join(enip::Endpoint, std::uint32_t) override { return {}; }
    void stop_listening() override {}
    void expect(std::uint32_t id) override { expected.insert(id); }
    void forget(std::uint32_t id) override { expected.erase(expected.find(id)); }
    [[nodiscard]] bool is_taken(std::uint32_t) const override { return false; }
    void changed() override {}

    scanner::IoNumbers numbers_{0x004D, 1};
    std::optional<std::uint64_t> wanted_;
    bool tcp_ = false;
    enip::IoQueue queue_;

public:
    scanner::IoSession session;  ///< last: it uses all of the above
};

}  // namespace servobus::fuzz
