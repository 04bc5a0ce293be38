// Peers that mean no good, or do not know better, against the real server: others are served, memory stays bounded, and
// everything that they hold is given back.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <random>
#include <thread>

#include "enip/messages.hpp"
#include "tests/adapter/tcp_client.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using enip::EncapsulationStatus;

/// How long one reply may take while others misbehave: far more than it takes, far less than a stall.
constexpr auto bearable = 2s;

const cip::Bytes get_s_curve = octets("0E 03 20 64 24 01 30 00");
const std::string s_curve = hex("8E 00 00 00 14 00 00 00");

std::size_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t total = 0;
    std::size_t resident = 0;
    file >> total >> resident;
    return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

constexpr std::size_t megabyte = std::size_t{1} << 20;

// The address sanitizer keeps what is freed for a while.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool keeps_freed_memory = true;
#elif defined(__has_feature)
constexpr bool keeps_freed_memory = __has_feature(address_sanitizer);
#else
constexpr bool keeps_freed_memory = false;
#endif
constexpr std::size_t bounded_growth = (keeps_freed_memory ? 512 : 32) * megabyte;

bool allow_descriptors(rlim_t count) {
    rlimit files{};
    if (::getrlimit(RLIMIT_NOFILE, &files) != 0) return false;
    if (files.rlim_cur >= count) return true;
    if (files.rlim_max < count) files.rlim_max = count;  // taken only from a process that may
    files.rlim_cur = count;
    return ::setrlimit(RLIMIT_NOFILE, &files) == 0;
}

cip::Bytes register_frame() {
    return enip::Frame{.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()}.encode();
}

/// Tries until it is served.
bool is_served(std::uint16_t port) {
    for (const auto end = Clock::now() + patience; Clock::now() < end;) {
        TcpClient newcomer(port);
        if (newcomer.connected() && newcomer.register_session()) return hex(newcomer.call(get_s_curve)) == s_curve;
        std::this_thread::sleep_for(20ms);
    }
    return false;
}

class HostilePeers : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(friend_.register_session()); }

    void expect_service() {
        const auto start = Clock::now();
        EXPECT_EQ(hex(friend_.call(get_s_curve)), s_curve);
        EXPECT_LT(Clock::now() - start, bearable);
    }

    RunningServer server_;
    TcpClient friend_{server_.port()};
};

TEST_F(HostilePeers, ElevenHundredConnections) {
    constexpr std::size_t count = 1100;
    if (!allow_descriptors(2 * count + 200)) GTEST_SKIP() << "this process may not open so many descriptors";
    std::vector<TcpClient> crowd;
    for (std::size_t i = 0; i < count; ++i) {
        crowd.emplace_back(server_.port());
        ASSERT_TRUE(crowd.back().connected()) << i;
        if (i % 100 == 0) expect_service();
    }
    expect_service();
    TcpClient newcomer(server_.port());
    EXPECT_TRUE(newcomer.register_session()) << "those who say nothing keep nobody out";
    EXPECT_EQ(hex(newcomer.call(get_s_curve)), s_curve);
    crowd.clear();
    EXPECT_TRUE(is_served(server_.port()));
    expect_service();
}

TEST_F(HostilePeers, ElevenHundredWhoWantASession) {
    constexpr std::size_t count = 1100;
    if (!allow_descriptors(2 * count + 200)) GTEST_SKIP() << "this process may not open so many descriptors";
    std::vector<TcpClient> crowd;
    std::size_t sessions = 1;  // the friend's
    for (std::size_t i = 0; i < count; ++i) {
        crowd.emplace_back(server_.port());
        ASSERT_TRUE(crowd.back().send(register_frame())) << i;
        const auto reply = crowd.back().receive();
        ASSERT_TRUE(reply) << i << ": everybody is told";
        if (reply->status == EncapsulationStatus::success) {
            ++sessions;
        } else {
            EXPECT_EQ(reply->status, EncapsulationStatus::insufficient_memory);
        }
        if (i % 100 == 0) expect_service();
    }
    EXPECT_EQ(sessions, adapter::Limits{}.sessions);
    expect_service();
}

TEST_F(HostilePeers, ThoseWhoRegisterAndStay) {
    adapter::Limits limits;
    limits.tcp_connections = 8;
    limits.sessions = 4;
    limits.refusals = 2;
    const RunningServer small(limits);
    std::vector<TcpClient> sessions;
    for (int i = 0; i < 4; ++i) {
        sessions.emplace_back(small.port());
        ASSERT_TRUE(sessions.back().register_session());
    }
    const TcpClient fifth(small.port());
    ASSERT_TRUE(fifth.send(register_frame()));
    const auto reply = fifth.receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, EncapsulationStatus::insufficient_memory);
    sessions.pop_back();
    EXPECT_TRUE(is_served(small.port()));
    for (const auto& session : sessions) EXPECT_EQ(hex(session.call(get_s_curve)), s_curve);
}

TEST_F(HostilePeers, TheRefusedGetTheirFrameAndThenTheEnd) {
    adapter::Limits limits;
    limits.tcp_connections = 1;
    const RunningServer small(limits);
    TcpClient only(small.port());
    ASSERT_TRUE(only.register_session());
    for (int i = 0; i < 10; ++i) {
        const TcpClient newcomer(small.port());
        // More than the refused request: the refusal must not be lost to a reset.
        auto requests = register_frame();
        requests.resize(requests.size() + 20'000, 0);
        ASSERT_TRUE(newcomer.send(requests));
        const auto reply = newcomer.receive();
        ASSERT_TRUE(reply);
        EXPECT_EQ(reply->status, EncapsulationStatus::insufficient_memory);
        EXPECT_TRUE(newcomer.closed_by_peer());
    }
    EXPECT_EQ(hex(only.call(get_s_curve)), s_curve);
}

TEST_F(HostilePeers, OneWhoLeavesAWordUnfinishedAfterItsRefusalIsCutOff) {
    adapter::Limits limits;
    limits.tcp_connections = 1;
    const RunningServer small(limits);
    TcpClient only(small.port());
    ASSERT_TRUE(only.register_session());
    std::vector<TcpClient> lingering;
    for (int i = 0; i < 10; ++i) {
        lingering.emplace_back(small.port());
        ASSERT_TRUE(lingering.back().send(register_frame()));
        ASSERT_TRUE(lingering.back().receive());
    }
    // None of them closes its end; the server lets go of all after a moment, and the place comes free.
    only.close();
    EXPECT_TRUE(is_served(small.port()));
    std::this_thread::sleep_for(700ms);
    for (const auto& each : lingering) EXPECT_TRUE(each.closed_by_peer());
}

TEST_F(HostilePeers, AnOctetEveryTenMilliseconds) {
    const TcpClient slow(server_.port());
    const auto request = register_frame();
    for (const auto octet : request) {
        ASSERT_TRUE(slow.send(cip::ByteView(&octet, 1)));
        expect_service();
        std::this_thread::sleep_for(10ms);
    }
    const auto reply = slow.receive();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, EncapsulationStatus::success);
}

TEST_F(HostilePeers, OneWhoRegistersWithoutEnd) {
    TcpClient greedy(server_.port());
    ASSERT_TRUE(greedy.register_session());
    cip::Bytes many;
    for (int i = 0; i < 2000; ++i) {
        const auto request = register_frame();
        many.insert(many.end(), request.begin(), request.end());
    }
    std::thread sender([&] { EXPECT_TRUE(greedy.send(many)); });
    for (int i = 0; i < 2000; ++i) {
        const auto reply = greedy.receive();
        ASSERT_TRUE(reply) << i;
        EXPECT_EQ(reply->status, EncapsulationStatus::unsupported_command);
        EXPECT_EQ(reply->session, greedy.session());
    }
    sender.join();
    expect_service();
    // And with a connection for each, again and again: all handles come back.
    for (int i = 0; i < 400; ++i) {
        TcpClient next(server_.port());
        ASSERT_TRUE(next.register_session()) << i;
        if (i % 2 == 0) next.reset();
    }
    expect_service();
}

TEST_F(HostilePeers, ThoseWhoAnnounceMuchAndSendNothing) {
    const auto before = resident_bytes();
    std::vector<TcpClient> liars;
    auto head = enip::Frame{.command = enip::Command::send_rr_data}.encode();
    for (const std::uint16_t length : std::to_array<std::uint16_t>({65511, 65535, 4200, 4201})) {
        head[2] = static_cast<std::uint8_t>(length);
        head[3] = static_cast<std::uint8_t>(length >> 8);
        for (int i = 0; i < 40; ++i) {
            liars.emplace_back(server_.port());
            ASSERT_TRUE(liars.back().send(head));
        }
    }
    expect_service();
    EXPECT_LT(resident_bytes(), before + bounded_growth);
}

TEST_F(HostilePeers, OneWhoNeverReadsItsReplies) {
    TcpClient deaf(server_.port(), 4096);
    ASSERT_TRUE(deaf.register_session());
    // Four kilobytes of reply for each request of a hundred octets.
    cip::Bytes list = octets("0A 02 20 02 24 01");
    cip::Writer writer(list);
    constexpr std::uint16_t parts = 80;
    writer.u16(parts);
    for (std::uint16_t i = 0; i < parts; ++i) writer.u16(static_cast<std::uint16_t>(2 + 2 * parts + 6 * i));
    for (std::uint16_t i = 0; i < parts; ++i) writer.bytes(octets("01 02 20 01 24 01"));
    const auto data = enip::SendData::unconnected(list).encode();
    const auto request =
        enip::Frame{.command = enip::Command::send_rr_data, .session = deaf.session(), .data = data}.encode();
    cip::Bytes pipelined;
    while (pipelined.size() < megabyte) pipelined.insert(pipelined.end(), request.begin(), request.end());

    const auto before = resident_bytes();
    std::size_t sent = 0;
    const auto end = Clock::now() + 4s;
    for (auto quiet_since = Clock::now(); Clock::now() < end && Clock::now() - quiet_since < 500ms;) {
        const auto count = deaf.send_some(cip::ByteView(pipelined).subspan(sent % request.size()));
        sent += count;
        if (count > 0) quiet_since = Clock::now();
        if (count == 0) std::this_thread::sleep_for(5ms);
    }
    expect_service();
    EXPECT_LT(sent, 64 * megabyte) << "the server goes on reading from a peer that does not";
    EXPECT_LT(resident_bytes(), before + bounded_growth);
    EXPECT_TRUE(is_served(server_.port()));
    deaf.reset();
    expect_service();
}

TEST_F(HostilePeers, ThoseWhoLeaveWithAReset) {
    std::mt19937 random(1);
    for (int i = 0; i < 300; ++i) {
        TcpClient client(server_.port());
        ASSERT_TRUE(client.connected());
        const auto request = register_frame();
        static_cast<void>(client.send(cip::ByteView(request).first(random() % (request.size() + 1))));
        if (i % 3 == 0) std::this_thread::sleep_for(1ms);
        client.reset();
    }
    // With requests in flight, and a class 3 connection open.
    for (int i = 0; i < 50; ++i) {
        TcpClient client(server_.port());
        ASSERT_TRUE(client.register_session());
        ASSERT_TRUE(client.open_class3());
        cip::Bytes requests;
        const auto data = enip::SendData::unconnected(get_s_curve).encode();
        for (int n = 0; n < 100; ++n) {
            enip::Frame{.command = enip::Command::send_rr_data, .session = client.session(), .data = data}.write(
                requests);
        }
        static_cast<void>(client.send(requests));
        client.reset();
    }
    expect_service();
    EXPECT_TRUE(is_served(server_.port()));
}

TEST_F(HostilePeers, Garbage) {
    const auto before = resident_bytes();
    std::mt19937 random(2);
    for (int i = 0; i < 60; ++i) {
        TcpClient client(server_.port());
        ASSERT_TRUE(client.connected());
        cip::Bytes noise(1 + random() % 50'000);
        for (auto& octet : noise) octet = static_cast<std::uint8_t>(random());
        static_cast<void>(client.send_some(noise));
        if (i % 2 == 0) client.reset();
    }
    expect_service();
    EXPECT_TRUE(is_served(server_.port()));
    EXPECT_LT(resident_bytes(), before + bounded_growth);
}

TEST_F(HostilePeers, HalfClosedOnesGetTheirReplies) {
    const TcpClient client(server_.port());
    ASSERT_TRUE(client.send(register_frame()));
    const auto reply = client.receive();
    ASSERT_TRUE(reply);
    ASSERT_TRUE(
        client.send(enip::Frame{.command = enip::Command::unregister_session, .session = reply->session}.encode()));
    EXPECT_TRUE(client.closed_by_peer()) << "R-ENC-20";
    expect_service();
}

TEST_F(HostilePeers, SixteenRequestsInFlightComeBackInOrderAndAtOnce) {
    const auto data = enip::SendData::unconnected(get_s_curve).encode();
    const auto start = Clock::now();
    for (int round = 0; round < 20; ++round) {
        cip::Bytes requests;
        for (std::uint8_t i = 0; i < 16; ++i) {
            enip::Frame{
                .command = enip::Command::send_rr_data, .session = friend_.session(), .context = {i}, .data = data}
                .write(requests);
        }
        ASSERT_TRUE(friend_.send(requests));
        for (std::uint8_t i = 0; i < 16; ++i) {
            const auto reply = friend_.receive();
            ASSERT_TRUE(reply);
            EXPECT_EQ(reply->context[0], i);
            EXPECT_EQ(reply->status, EncapsulationStatus::success);
        }
    }
    // A stall of 40 ms for each reply would take 12 seconds, one for each round 0.8.
    EXPECT_LT(Clock::now() - start, bearable);
}

TEST_F(HostilePeers, StoppingTheServerClosesEveryConnection) {
    std::optional<RunningServer> server;
    server.emplace();
    std::vector<TcpClient> clients;
    for (int i = 0; i < 20; ++i) {
        clients.emplace_back(server->port());
        if (i % 2 == 0) {
            ASSERT_TRUE(clients.back().register_session());
        }
    }
    const auto start = Clock::now();
    server.reset();
    EXPECT_LT(Clock::now() - start, bearable);
    for (const auto& client : clients) EXPECT_TRUE(client.closed_by_peer());
}

TEST_F(HostilePeers, AResetClosesEveryConnection) {
    const TcpClient idle(server_.port());
    EXPECT_EQ(hex(friend_.call(octets("05 02 20 01 24 01"))), hex("85 00 00 00"));
    EXPECT_TRUE(friend_.closed_by_peer());
    EXPECT_TRUE(idle.closed_by_peer());
    EXPECT_TRUE(is_served(server_.port()));
}

}  // namespace
}  // namespace servobus::test
