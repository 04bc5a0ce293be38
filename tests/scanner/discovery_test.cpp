// Finding devices: broadcast and unicast, UDP and TCP.
#include "enip/asio/discovery.hpp"

#include <gtest/gtest.h>

#include "enip/asio/asio.hpp"
#include "tests/scanner/fake_server.hpp"

namespace servobus::enip::asio {
namespace {

using namespace std::chrono_literals;
using net::ip::udp;
using scanner::test::FakeServer;
using scanner::test::Peer;

IdentityItem xenax() {
    IdentityItem item;
    item.vendor = 1389;
    item.serial_number = 7;
    item.product_name = "XENAX";
    item.state = 3;
    return item;
}

Frame identity_reply(const Frame& request, const cip::Bytes& item) {
    CommonPacket packet;
    packet.items.push_back({ItemType::identity, item});
    return request.reply(EncapsulationStatus::success, packet.encode());
}

/// Answers datagrams on a loopback port, with as many copies as `copies` says.
class FakeResponder {
public:
    explicit FakeResponder(const char* address, int copies = 1, std::function<cip::Bytes(const Frame&)> answer = {})
        : copies_(copies), answer_(std::move(answer)), socket_(context_, udp::v4()) {
        socket_.set_option(net::socket_base::reuse_address(true));
        socket_.bind({net::ip::make_address(address), 0});
        receive();
        thread_ = std::thread([this] { context_.run(); });
    }
    ~FakeResponder() {
        net::post(context_, [this] { socket_.close(); });
        thread_.join();
    }
    FakeResponder(const FakeResponder&) = delete;
    FakeResponder& operator=(const FakeResponder&) = delete;
    [[nodiscard]] std::uint16_t port() const { return socket_.local_endpoint().port(); }

private:
    void receive() {
        socket_.async_receive_from(net::buffer(octets_), sender_, [this](error_code error, std::size_t count) {
            if (error) return;
            const auto request = Frame::parse(cip::ByteView(octets_).first(count));
            EXPECT_TRUE(request && request->command == Command::list_identity);
            EXPECT_NE(request->context[0] | request->context[1], 0) << "the longest delay (R-ENC-14)";
            const auto reply = answer_ ? answer_(*request) : identity_reply(*request, xenax().encode()).encode();
            for (int i = 0; i < copies_; ++i) socket_.send_to(net::buffer(reply), sender_);
            receive();
        });
    }

    int copies_;
    std::function<cip::Bytes(const Frame&)> answer_;
    net::io_context context_{1};
    udp::socket socket_;
    udp::endpoint sender_;
    std::array<std::uint8_t, 1500> octets_{};
    std::thread thread_;
};

struct Result {
    error_code error;
    FoundDevices devices;
};

Result probe(ProbeOptions options) {
    net::io_context context;
    std::optional<Result> result;
    async_probe(context.get_executor(), std::move(options), [&](error_code error, FoundDevices devices) {
        result = Result{error, std::move(devices)};
    });
    context.run_for(10s);
    EXPECT_TRUE(result.has_value());
    return *result;
}

Result broadcast(BroadcastOptions options) {
    net::io_context context;
    std::optional<Result> result;
    async_discover(context.get_executor(), options, [&](error_code error, FoundDevices devices) {
        result = Result{error, std::move(devices)};
    });
    context.run_for(10s);
    EXPECT_TRUE(result.has_value());
    return *result;
}

TEST(Discovery, FindsByBroadcastAndOnce) {
    // A socket at the broadcast address itself: what is found does not depend on the machine's network.
    FakeResponder responder("0.0.0.0", 3);
    const auto result = broadcast({responder.port(), 300ms});
    EXPECT_EQ(result.error, error_code());
    ASSERT_FALSE(result.devices.empty());
    const auto on_loopback = std::ranges::count(result.devices, "127.0.0.1", &FoundDevice::address);
    EXPECT_EQ(on_loopback, 1);
    EXPECT_EQ(result.devices.front().identity, xenax());
    EXPECT_EQ(result.devices.front().port, responder.port());
}

TEST(Discovery, FindsNobody) {
    std::uint16_t port = 0;
    { port = FakeResponder("127.0.0.1").port(); }
    const auto begin = std::chrono::steady_clock::now();
    const auto result = broadcast({port, 200ms});
    EXPECT_EQ(result.error, error_code());
    EXPECT_TRUE(result.devices.empty());
    EXPECT_GE(std::chrono::steady_clock::now() - begin, 190ms);
}

TEST(Discovery, IsCancelled) {
    net::io_context context;
    net::cancellation_signal signal;
    std::optional<error_code> result;
    async_discover(context.get_executor(), BroadcastOptions{1, 10s},
                   net::bind_cancellation_slot(signal.slot(), [&](error_code error, FoundDevices) { result = error; }));
    net::post(context, [&] { signal.emit(net::cancellation_type::terminal); });
    context.run_for(5s);
    EXPECT_EQ(result, net::error::operation_aborted);
}

TEST(Discovery, AsksOneHostOverUdp) {
    FakeResponder responder("127.0.0.1");
    const auto result = probe({"127.0.0.1", responder.port(), 1s, 2s});
    EXPECT_EQ(result.error, error_code());
    ASSERT_EQ(result.devices.size(), 1U);
    EXPECT_EQ(result.devices[0].identity, xenax());
    EXPECT_EQ(result.devices[0].address, "127.0.0.1");
}

TEST(Discovery, AsksAgainWhenADatagramIsLostOrNonsense) {
    int asked = 0;
    FakeResponder responder("127.0.0.1", 1, [&](const Frame& request) {
        if (asked++ == 0) return cip::Bytes{1, 2, 3};
        return identity_reply(request, xenax().encode()).encode();
    });
    const auto result = probe({"127.0.0.1", responder.port(), 2s, 3s});
    EXPECT_EQ(result.error, error_code());
    EXPECT_EQ(result.devices.size(), 1U);
}

TEST(Discovery, FallsBackToTcp) {
    FakeServer server([](Peer& peer, const Frame& frame) {
        EXPECT_EQ(frame.command, Command::list_identity);
        peer.send(identity_reply(frame, xenax().encode()));
    });
    const auto result = probe({"127.0.0.1", server.port(), 200ms, 2s});
    EXPECT_EQ(result.error, error_code());
    ASSERT_EQ(result.devices.size(), 1U);
    EXPECT_EQ(result.devices[0].port, server.port());
}

TEST(Discovery, SaysWhyOneHostDoesNotAnswer) {
    std::uint16_t port = 0;
    {
        port = FakeServer([](Peer&, const Frame&) {}).port();
    }
    EXPECT_EQ(probe({"127.0.0.1", port, 100ms, 1s}).error, net::error::connection_refused);

    FakeServer silent([](Peer&, const Frame&) {});
    EXPECT_EQ(probe({"127.0.0.1", silent.port(), 100ms, 300ms}).error, net::error::timed_out);

    FakeServer foreign([](Peer& peer, const Frame&) { peer.send(cip::Bytes{'H', 'T', 'T', 'P'}); });
    EXPECT_EQ(probe({"127.0.0.1", foreign.port(), 100ms, 1s}).error, boost::system::errc::bad_message);
}

TEST(IdentityReply, IsReadTolerantly) {
    Frame request;
    request.command = Command::list_identity;
    auto octets = xenax().encode();
    EXPECT_EQ(*read_identity_reply(identity_reply(request, octets)), xenax());

    octets.push_back(0x55);
    EXPECT_EQ(*read_identity_reply(identity_reply(request, octets)), xenax()) << "surplus octets";

    octets.resize(octets.size() - 2);
    auto without_state = xenax();
    without_state.state = 0xFF;
    EXPECT_EQ(*read_identity_reply(identity_reply(request, octets)), without_state);
    while (!octets.empty()) {
        octets.pop_back();
        EXPECT_FALSE(read_identity_reply(identity_reply(request, octets))) << octets.size();
    }
}

TEST(IdentityReply, IsNothingElse) {
    Frame request;
    request.command = Command::list_identity;
    auto reply = identity_reply(request, xenax().encode());
    reply.status = EncapsulationStatus::unsupported_command;
    EXPECT_FALSE(read_identity_reply(reply));
    reply = identity_reply(request, xenax().encode());
    reply.command = Command::list_services;
    EXPECT_FALSE(read_identity_reply(reply));
    EXPECT_FALSE(read_identity_reply(request));
}

}  // namespace
}  // namespace servobus::enip::asio
