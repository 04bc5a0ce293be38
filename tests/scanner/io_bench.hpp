// A session between an application and a device that both are the test: everything that a session asks for is written
// down, and time is a number.
#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <set>

#include "cip/services.hpp"
#include "enip/messages.hpp"
#include "scanner/io_session.hpp"
#include "tests/support/octets.hpp"

namespace servobus::scanner::test {

using namespace std::chrono_literals;
using servobus::test::octets;

inline constexpr enip::Endpoint device{0xC0A80264, 44818};  // 192.168.2.100
inline constexpr enip::Endpoint ourselves{0xC0A80201, 50000};
inline constexpr std::uint32_t o_to_t_id = 0x56A00001;

inline IoOptions standard() {
    IoOptions options;
    options.host = "device";
    options.plan = plan_of(*assemblies::find_connection("standard"));
    return options;
}

class IoBench : private IoSession::Surroundings {
public:
    struct Asked {
        std::uint64_t ticket;
        cip::Request request;
        std::vector<enip::Item> items;
    };

    explicit IoBench(IoOptions options = standard(), IoEvents extra = {})
        : extra_(std::move(extra)), session(std::move(options), events(), numbers, *this) {}

    // What the application does
    void open() { session.open(now); }
    void close() { session.close(now); }

    // What the world does
    void reach(error_code error = {}) {
        ASSERT_FALSE(connects.empty());
        const auto ticket = connects.front();
        connects.pop_front();
        tcp = !error;
        session.on_connected(ticket, error, {ourselves, device}, now);
    }
    /// Answers the oldest request.
    void answer(const cip::Response& response, std::vector<enip::Item> items = {}) {
        session.on_reply(take().ticket, {}, {response, std::move(items)}, now);
    }
    void answer(error_code error) { session.on_reply(take().ticket, error, {}, now); }
    Asked take() {
        EXPECT_FALSE(asked.empty());
        if (asked.empty()) return {};
        auto first = asked.front();
        asked.pop_front();
        return first;
    }

    /// The Forward_Open that waits for its answer.
    [[nodiscard]] cip::ForwardOpen asked_open() const {
        if (asked.empty()) return {};
        const auto& request = asked.front().request;
        const auto open = cip::ForwardOpen::parse(request.data, request.service == cip::service::large_forward_open);
        return open ? *open : cip::ForwardOpen{};
    }
    [[nodiscard]] cip::ForwardOpenReply good_reply() const {
        const auto open = asked_open();
        return {o_to_t_id, open.t_to_o_id, open.triad, open.o_to_t_rpi, open.t_to_o_rpi, {}};
    }
    [[nodiscard]] cip::Response granting(const cip::ForwardOpenReply& reply) const {
        return {asked.empty() ? std::uint8_t{0} : asked.front().request.service, {}, reply.encode()};
    }
    void grant(std::vector<enip::Item> items = {}) { answer(granting(good_reply()), std::move(items)); }
    /// All the way to an open connection.
    void run(std::vector<enip::Item> items = {}) {
        open();
        reach();
        id = asked_open().t_to_o_id;
        grant(std::move(items));
    }
    void refuse(const cip::Status& status) {
        const auto triad = asked_open().triad;
        answer(cip::Response{asked.front().request.service, status, cip::ConnectionRefusal{triad, 0}.encode()});
    }
    void accept_close() {
        const auto close = cip::ForwardClose::parse(asked.front().request.data);
        ASSERT_TRUE(close.has_value());
        answer(cip::Response{cip::service::forward_close, {}, cip::ForwardCloseReply{close->triad, {}}.encode()});
    }

    [[nodiscard]] cip::Bytes t_to_o(std::uint32_t sequence, std::uint16_t count, std::size_t data = 28) const {
        const auto size = cip::sequence_count_octets + data;
        cip::Bytes datagram(enip::io_packet_overhead + size);
        auto rest = enip::begin_io_packet(datagram, id, sequence);
        rest[0] = static_cast<std::uint8_t>(count);
        rest[1] = static_cast<std::uint8_t>(count >> 8);
        if (data > 0) rest[2] = static_cast<std::uint8_t>(sequence);
        return datagram;
    }
    IoSession::Reception receive(const cip::Bytes& datagram, enip::Endpoint peer = {device.address, 2222},
                                 enip::Endpoint local = {ourselves.address, 2222}) {
        const auto packet = enip::IoPacket::parse(datagram);
        EXPECT_TRUE(packet.has_value());
        return session.on_datagram({peer, local, datagram, *packet, now});
    }

    /// Serves all deadlines until the time has passed. What is sent stays in `queue`.
    void pass(enip::Time::duration duration) {
        const auto end = now + duration;
        for (auto next = session.next_deadline(); next && *next <= end; next = session.next_deadline()) {
            now = std::max(now, *next);
            session.on_timer(now, queue);
        }
        now = end;
    }

    [[nodiscard]] std::vector<std::uint8_t> services() const {
        std::vector<std::uint8_t> list;
        for (const auto& each : asked) list.push_back(each.request.service);
        return list;
    }

    enip::Time now{std::chrono::seconds(1000)};
    IoNumbers numbers{0x004D, 1};
    enip::IoQueue queue;
    std::uint32_t id = 0;
    bool tcp = false;
    std::uint16_t port = enip::io_port;
    error_code listen_error{};
    error_code join_error{};

    std::deque<std::uint64_t> connects;
    std::deque<Asked> asked;
    std::multiset<std::uint32_t> expected;
    std::set<std::uint32_t> taken;
    std::optional<enip::Endpoint> joined;
    int listeners = 0;

    std::vector<IoOpened> opened;
    std::vector<IoClosed> closed;
    struct Input {
        cip::Bytes data;
        bool fresh;
        std::uint32_t sequence;
    };
    std::vector<Input> inputs;
    cip::Bytes output;  ///< what the application wants to send; empty: zeros
    bool run_mode = true;

private:
    IoEvents extra_;

    IoEvents events() {
        return {.opened =
                    [this](const IoOpened& event) {
                        opened.push_back(event);
                        if (extra_.opened) extra_.opened(event);
                    },
                .input =
                    [this](const IoInput& event) {
                        inputs.push_back({{event.data.begin(), event.data.end()}, event.fresh, event.sequence});
                        if (extra_.input) extra_.input(event);
                    },
                .output =
                    [this](std::span<std::uint8_t> data) {
                        if (extra_.output) return extra_.output(data);
                        std::ranges::copy(output, data.begin());
                        return run_mode;
                    },
                .closed =
                    [this](const IoClosed& event) {
                        closed.push_back(event);
                        if (extra_.closed) extra_.closed(event);
                    },
                .packet = extra_.packet};
    }

    void connect(std::uint64_t ticket) override { connects.push_back(ticket); }
    [[nodiscard]] bool connected() const override { return tcp; }
    void request(std::uint64_t ticket, const cip::Request& request, std::vector<enip::Item> items) override {
        asked.push_back({ticket, request, std::move(items)});
    }
    [[nodiscard]] boost::system::result<enip::Endpoint> listen(std::uint32_t address) override {
        EXPECT_EQ(address, ourselves.address);
        if (listen_error) return listen_error;
        ++listeners;
        return enip::Endpoint{address, port};
    }
    [[nodiscard]] error_code join(enip::Endpoint group, std::uint32_t address) override {
        EXPECT_EQ(address, ourselves.address);
        if (!join_error) joined = group;
        return join_error;
    }
    void stop_listening() override {
        listeners = 0;
        joined.reset();
    }
    void expect(std::uint32_t t_to_o_id) override { expected.insert(t_to_o_id); }
    void forget(std::uint32_t t_to_o_id) override { expected.erase(expected.find(t_to_o_id)); }
    [[nodiscard]] bool is_taken(std::uint32_t t_to_o_id) const override { return taken.contains(t_to_o_id); }
    void changed() override {}

public:
    IoSession session;  ///< last: it uses all of the above
};

inline enip::Item sockaddr(enip::ItemType type, std::uint16_t port, std::uint32_t address = 0,
                           std::uint16_t family = 2) {
    return {type, enip::SocketAddress{family, port, address, {}}.encode()};
}
inline constexpr std::uint32_t group_address = 0xEFC00D60;  // 239.192.13.96

}  // namespace servobus::scanner::test
