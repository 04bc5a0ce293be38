// The socket of class 0 and 1 on loopback: what is sent arrives, with both addresses and the time of its arrival.
#include "enip/asio/io_socket.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>

#include "enip/asio/asio.hpp"
#include "enip/asio/io_rhythm.hpp"

namespace servobus::enip::asio {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t first_address = 0x7F000001;
constexpr std::uint32_t second_address = 0x7F000005;
constexpr std::uint32_t group = 0xEFC00D60;  // 239.192.13.96

struct Seen {
    Endpoint peer;
    Endpoint local;
    cip::Bytes octets;
    Time time;
};

class IoSockets : public testing::Test {
protected:
    IoSockets() {
        EXPECT_FALSE(first.open({first_address, 0}, false));
        EXPECT_FALSE(second.open({second_address, 0}, false));
    }

    /// Waits until `count` datagrams are there.
    std::vector<Seen> receive(IoSocket& socket, std::size_t count) {
        std::vector<Seen> seen;
        while (seen.size() < count) {
            bool ready = false;
            socket.socket().async_wait(net::ip::udp::socket::wait_read, [&](auto error) { ready = !error; });
            context.restart();
            context.run_for(5s);
            if (!ready) break;
            socket.receive([&](const IoSocket::Received& datagram) {
                seen.push_back(
                    {datagram.peer, datagram.local, {datagram.octets.begin(), datagram.octets.end()}, datagram.time});
            });
        }
        return seen;
    }
    void put(const IoRoute& route, std::uint8_t first_octet, std::size_t size = 4) {
        std::ranges::fill(queue.add(route, size), first_octet);
    }

    net::io_context context{1};
    IoSocket first{context.get_executor()};
    IoSocket second{context.get_executor()};
    IoQueue queue;
};

TEST_F(IoSockets, GiveBothAddressesAndTheTimeOfArrival) {
    put({.local = first.local(), .peer = second.local()}, 7);
    EXPECT_EQ(first.send(queue).sent, 1U);
    const auto seen = receive(second, 1);
    ASSERT_EQ(seen.size(), 1U);
    EXPECT_EQ(seen[0].peer, first.local());
    EXPECT_EQ(seen[0].local, second.local());
    EXPECT_EQ(seen[0].octets, cip::Bytes(4, 7));
    EXPECT_LE(seen[0].time, std::chrono::steady_clock::now());
}

TEST_F(IoSockets, WhileQuietWakeNobodyAndLoseNothing) {
    bool aborted = false;
    second.socket().async_wait(net::ip::udp::socket::wait_read,
                               [&](auto error) { aborted = error == net::error::operation_aborted; });
    second.set_quiet(true);
    EXPECT_TRUE(second.is_quiet());
    EXPECT_TRUE(second.is_open());
    context.run_for(5s);
    EXPECT_TRUE(aborted) << "whoever waits is told";

    put({.local = first.local(), .peer = second.local()}, 7);
    EXPECT_EQ(first.send(queue).sent, 1U);
    std::size_t taken = 0;
    const auto end = std::chrono::steady_clock::now() + 5s;
    while (taken == 0 && std::chrono::steady_clock::now() < end) taken = second.receive([](const auto&) {});
    EXPECT_EQ(taken, 1U) << "it is there to be received";
    // It goes on to send from its own port.
    queue.clear();
    put({.local = second.local(), .peer = first.local()}, 8);
    EXPECT_EQ(second.send(queue).sent, 1U);
    EXPECT_EQ(receive(first, 1).at(0).peer, second.local());

    queue.clear();
    put({.local = first.local(), .peer = second.local()}, 9);
    EXPECT_EQ(first.send(queue).sent, 1U);
    second.set_quiet(false);
    EXPECT_FALSE(second.is_quiet());
    const auto seen = receive(second, 1);
    ASSERT_EQ(seen.size(), 1U) << "what came while it was quiet wakes whoever waits afterwards";
    EXPECT_EQ(seen[0].octets, cip::Bytes(4, 9));
}

TEST_F(IoSockets, AreClosedWhileQuietAndOpenAgain) {
    const auto local = second.local();
    second.set_quiet(true);
    second.close();
    EXPECT_FALSE(second.is_open());
    EXPECT_FALSE(second.is_quiet());
    EXPECT_FALSE(second.open(local, false)) << "the port is free again";
}

TEST(IoRhythm, IsBusyFromARateOnAndCalmBelowHalfOfIt) {
    IoRhythm rhythm;
    auto now = Time(1h);
    // `each_ms` datagrams a millisecond, for long enough to be judged.
    const auto run = [&](std::size_t each_ms) {
        for (int i = 0; i < 3 * rhythm_window.count(); ++i) rhythm.count(each_ms, now += 1ms);
        return rhythm.is_busy();
    };
    EXPECT_FALSE(run(3));
    EXPECT_TRUE(run(5));
    EXPECT_TRUE(run(3)) << "not below half of it";
    EXPECT_FALSE(run(1));
    EXPECT_TRUE(run(5));
    rhythm.count(1000, now += 1s);
    EXPECT_FALSE(rhythm.is_busy()) << "what comes after a long time is not a rate";
}

// The kernel begins to stamp some time after the first socket has asked for it, so the first datagrams may have the time
// at which they were received.
TEST_F(IoSockets, TellATimeBeforeThatOfReceiving) {
    put({.local = first.local(), .peer = second.local()}, 7);
    const auto end = std::chrono::steady_clock::now() + 10s;
    bool stamped = false;
    while (!stamped && std::chrono::steady_clock::now() < end) {
        EXPECT_EQ(first.send(queue).sent, 1U);
        const auto sent = std::chrono::steady_clock::now();
        const auto seen = receive(second, 1);
        ASSERT_EQ(seen.size(), 1U);
        stamped = seen[0].time <= sent;
    }
    EXPECT_TRUE(stamped);
}

TEST_F(IoSockets, SendMoreThanOneBatchInOrder) {
    const std::size_t count = 2 * io_batch + 3;
    for (std::size_t i = 0; i < count; ++i) {
        put({.local = first.local(), .peer = second.local()}, static_cast<std::uint8_t>(i), 1 + i);
    }
    const auto sent = first.send(queue);
    EXPECT_EQ(sent.sent, count);
    EXPECT_EQ(sent.failed, 0U);
    const auto seen = receive(second, count);
    ASSERT_EQ(seen.size(), count);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(seen[i].octets, cip::Bytes(1 + i, static_cast<std::uint8_t>(i)));
}

TEST_F(IoSockets, OneBadDatagramDoesNotStopTheOthers) {
    const Endpoint nowhere{0xFFFFFFFF, 2222};  // broadcast is not allowed here
    put({.local = first.local(), .peer = second.local()}, 1);
    put({.local = first.local(), .peer = nowhere}, 2);
    put({.local = first.local(), .peer = second.local()}, 3);
    const auto sent = first.send(queue);
    EXPECT_EQ(sent.sent, 2U);
    EXPECT_EQ(sent.failed, 1U);
    const auto seen = receive(second, 2);
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_EQ(seen[1].octets, cip::Bytes(4, 3));
}

TEST_F(IoSockets, MarkEachDatagramWithItsOwnPriority) {  // R-QOS-5
    const int on = 1;
    ASSERT_EQ(::setsockopt(second.socket().native_handle(), IPPROTO_IP, IP_RECVTOS, &on, sizeof on), 0);
    put({.local = first.local(), .peer = second.local(), .dscp = 47}, 1);
    EXPECT_EQ(first.send(queue).sent, 1U);
    second.socket().non_blocking(false);
    std::array<char, 64> octets{};
    alignas(cmsghdr) std::array<char, 256> control{};
    iovec part{octets.data(), octets.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    ASSERT_EQ(::recvmsg(second.socket().native_handle(), &message, 0), 4);
    std::optional<int> tos;
    for (auto* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
        if (header->cmsg_level == IPPROTO_IP && header->cmsg_type == IP_TOS) tos = *CMSG_DATA(header);
    }
    EXPECT_EQ(tos, 47 << 2);
}

TEST_F(IoSockets, EmptyAndOverlongDatagramsAreDatagrams) {
    put({.local = first.local(), .peer = second.local()}, 1, 0);
    put({.local = first.local(), .peer = second.local()}, 2, max_io_datagram + 1);
    EXPECT_EQ(first.send(queue).sent, 2U);
    const auto seen = receive(second, 2);
    ASSERT_EQ(seen.size(), 2U);
    EXPECT_TRUE(seen[0].octets.empty());
    EXPECT_EQ(seen[1].octets.size(), max_io_datagram);
}

TEST_F(IoSockets, AreHeardInTheirGroupUntilTheyLeave) {  // R-MC-3
    IoSocket member(context.get_executor());
    ASSERT_FALSE(member.open({group, 0}, true));
    IoSocket other(context.get_executor());
    ASSERT_FALSE(other.open(member.local(), true));
    ASSERT_FALSE(member.join(group, second_address));
    put({.local = first.local(), .peer = member.local(), .ttl = 1}, 9);
    EXPECT_EQ(first.send(queue).sent, 1U);
    const auto seen = receive(member, 1);
    ASSERT_EQ(seen.size(), 1U);
    EXPECT_EQ(seen[0].peer, first.local());
    EXPECT_EQ(seen[0].local, member.local());
    EXPECT_EQ(other.receive([](const auto&) {}), 0U);  // bound there too, but no member

    ASSERT_FALSE(other.join(group, second_address));
    ASSERT_FALSE(member.leave(group, second_address));
    EXPECT_EQ(first.send(queue).sent, 1U);
    EXPECT_EQ(receive(other, 1).size(), 1U);
    EXPECT_EQ(member.receive([](const auto&) {}), 0U);
}

TEST_F(IoSockets, APortIsTakenUnlessBothShareIt) {
    IoSocket third(context.get_executor());
    EXPECT_EQ(third.open(first.local(), false), net::error::address_in_use);
    EXPECT_FALSE(third.open({first_address, 0}, false));  // an error leaves it as it was
    EXPECT_NE(third.local().port, 0);
    EXPECT_NE(third.local().port, first.local().port);
}

TEST_F(IoSockets, MayBeClosedByWhoeverTakesADatagram) {
    put({.local = first.local(), .peer = second.local()}, 1);
    put({.local = first.local(), .peer = second.local()}, 2);
    EXPECT_EQ(first.send(queue).sent, 2U);
    unsigned taken = 0;
    EXPECT_EQ(second.receive([&](const auto&) {
        ++taken;
        second.close();
    }),
              2U);
    EXPECT_EQ(taken, 1U);
}

}  // namespace
}  // namespace servobus::enip::asio
