// How the device comes to its address (R-DHC, R-ACD, R-TCP-4, R-TCP-6), with a server and rivals that are made of octets.
#include "adapter/address_manager.hpp"

#include "adapter/arp_packet.hpp"
#include "adapter/dhcp_message.hpp"
#include "adapter/ethernet_frame.hpp"
#include "adapter/udp_frame.hpp"
#include "tests/support/adapter_harness.hpp"
#include "tests/support/octets.hpp"

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;
using test::hex;

constexpr MacAddress server_mac{0x02, 0x00, 0x00, 0x00, 0x00, 0x01};
constexpr MacAddress rival{0x02, 0x00, 0x00, 0x00, 0x00, 0x07};
constexpr std::uint32_t server = 0xC0A80201;
constexpr InterfaceConfiguration stored{.address = 0xC0A802F9, .mask = 0xFFFFFF00, .gateway = server};
constexpr enip::InterfaceAddress stored_address{0xC0A802F9, 24, server};

// The manager on a link where everything that it sends is kept, and a server hands out what `grant` says.
class ManagedAddress : public testing::Test {
protected:
    ManagedAddress() {
        manager_.on_loss([this] { ++losses_; });
    }

    void start(AddressMethod method) {
        network_.settings.method = method;
        manager_.restart();
        run(0ms);
    }
    void start_stored() {
        network_.settings.configured = stored;
        start(AddressMethod::stored);
    }

    void run(std::chrono::milliseconds duration) {
        const auto end = now_ + duration;
        settle();
        while (const auto next = manager_.next_deadline()) {
            if (*next > end) break;
            now_ = std::max(now_, *next);
            manager_.on_timer(now_);
            settle();
        }
        now_ = end;
    }
    // What is sent is written down, and answered by the server until there is nothing to answer any more.
    void settle() {
        for (auto frames = manager_.take_frames(); !frames.empty(); frames = manager_.take_frames()) {
            for (const auto& frame : frames) {
                sent_.push_back(name_of(frame.octets));
                if (const auto reply = answer(frame.octets)) hear_octets(*reply);
            }
        }
    }
    void hear_octets(const cip::Bytes& octets) { manager_.on_frame(0, {.octets = octets}, now_); }
    void hear_arp(const ArpPacket& packet, std::optional<std::uint16_t> vlan_tag = {}) {
        const auto payload = packet.encode();
        hear_octets(EthernetFrame{broadcast_mac, packet.sender_mac, vlan_tag, EtherType::arp, payload}.encode());
        settle();
    }
    // Somebody says that he has the address.
    void claim(std::uint32_t address) {
        hear_arp({.operation = ArpPacket::Operation::reply, .sender_mac = rival, .sender_address = address});
    }

    static std::string name_of(const cip::Bytes& octets) {
        const auto frame = EthernetFrame::parse(octets);
        if (frame && frame->type == EtherType::arp) {
            return ArpPacket::parse(frame->payload).value().is_probe() ? "probe" : "announcement";
        }
        const auto datagram = UdpFrame::parse(octets);
        const auto type = DhcpMessage::parse(datagram.value().payload).value().type();
        if (!type) return "bootp";
        return std::array{"", "discover", "offer", "request", "decline"}[static_cast<std::size_t>(*type)];
    }

    std::optional<cip::Bytes> answer(const cip::Bytes& octets) {
        const auto datagram = UdpFrame::parse(octets);
        if (!datagram || grant_ == 0) return std::nullopt;
        const auto request = DhcpMessage::parse(datagram->payload).value();
        host_name_ = request.text(DhcpOption::host_name);
        const auto type = request.type();
        if (type == DhcpType::decline) return std::nullopt;
        DhcpMessage reply{.operation = DhcpMessage::Operation::reply,
                          .transaction = request.transaction,
                          .your_address = grant_,
                          .client_mac = request.client_mac};
        reply.add(DhcpOption::subnet_mask, 0xFFFF0000);
        reply.add(DhcpOption::router, gateway_);
        if (type) {
            const auto kind = type == DhcpType::discover ? DhcpType::offer : DhcpType::ack;
            reply.add(DhcpOption::message_type, cip::Bytes{static_cast<std::uint8_t>(kind)});
            reply.add(DhcpOption::server_identifier, server);
            reply.add(DhcpOption::lease_time, 3600);
        }
        const auto payload = reply.encode();
        return UdpFrame{network_.state.mac, server_mac, {server, 67}, {grant_, 68}, payload}.encode();
    }

    std::vector<std::string> sent() { return std::exchange(sent_, {}); }
    const AddressStatus& status() const { return network_.state.address; }

    Network network_;
    std::vector<std::string> log_;
    AddressManager manager_{network_, 1, Log([this](LogLevel, std::string_view line) { log_.emplace_back(line); })};
    enip::Time now_{1h};
    std::vector<std::string> sent_;
    int losses_ = 0;
    std::uint32_t grant_ = 0;  ///< what the server hands out; 0: there is no server
    std::uint32_t gateway_ = server;
    std::string host_name_;  ///< that the server has heard
};

using Words = std::vector<std::string>;
const Words examination{"probe", "probe", "probe", "probe", "announcement"};

Words operator+(Words front, const Words& back) {
    front.insert(front.end(), back.begin(), back.end());
    return front;
}

TEST_F(ManagedAddress, NothingHappensBeforePowerIsOn) {
    EXPECT_EQ(manager_.next_deadline(), std::nullopt);
    EXPECT_EQ(manager_.address(), std::nullopt);
    EXPECT_FALSE(status().configured);
}

TEST_F(ManagedAddress, TheStoredAddressIsExaminedAndUsed) {  // R-DHC-1
    start_stored();
    run(999ms);
    EXPECT_EQ(manager_.address(), std::nullopt);
    EXPECT_FALSE(status().configured);
    EXPECT_EQ(network_.state.interface, InterfaceConfiguration{});
    run(1ms);
    EXPECT_EQ(manager_.address(), stored_address);
    EXPECT_TRUE(status().configured);
    EXPECT_FALSE(status().conflict || status().without_address);
    EXPECT_EQ(network_.state.interface, stored);
    EXPECT_EQ(sent(), examination);
    EXPECT_THAT(log_, testing::ElementsAre("is 192.168.2.249/24 free?", "192.168.2.249/24 is in use"));
}

TEST_F(ManagedAddress, WithoutAStoredOneThereIsNone) {  // R-DHC-1: all zero
    start(AddressMethod::stored);
    run(10min);
    EXPECT_EQ(manager_.address(), std::nullopt);
    EXPECT_FALSE(status().configured);
    EXPECT_TRUE(sent().empty());
}

TEST_F(ManagedAddress, WithoutDetectionItIsUsedAtOnce) {  // R-ACD-1
    network_.settings.select_acd = false;
    start_stored();
    EXPECT_EQ(manager_.address(), stored_address);
    claim(stored.address);
    claim(stored.address);
    run(10min);
    EXPECT_TRUE(sent().empty());
    EXPECT_EQ(manager_.address(), stored_address);
}

TEST_F(ManagedAddress, DetectionIsChosenAtTheNextRestart) {  // R-TCP-9
    start_stored();
    run(1s);
    network_.settings.select_acd = false;
    manager_.change_address();
    run(999ms);
    EXPECT_EQ(manager_.address(), std::nullopt);
    run(1ms);
    EXPECT_EQ(manager_.address(), stored_address);
    manager_.restart();
    run(0ms);
    EXPECT_EQ(manager_.address(), stored_address);
}

TEST_F(ManagedAddress, AStoredAddressThatSomebodyHasIsNotUsed) {  // R-ACD-3
    start_stored();
    run(500ms);
    claim(stored.address);
    sent();
    EXPECT_EQ(manager_.address(), std::nullopt);
    EXPECT_TRUE(status().conflict && status().without_address);
    EXPECT_FALSE(status().configured);
    EXPECT_EQ(network_.settings.last_conflict[0], 1);
    EXPECT_EQ(losses_, 0) << "it was not in use";
    EXPECT_THAT(log_.back(), testing::HasSubstr("02:00:00:00:00:07"));
    run(10'199ms);
    EXPECT_TRUE(sent().empty()) << "it is tried again too soon";
    run(1ms);
    EXPECT_EQ(sent(), Words{"probe"});
    claim(stored.address);
    run(10'200ms + 800ms);
    EXPECT_EQ(manager_.address(), stored_address) << "the rival has gone";
    EXPECT_FALSE(status().conflict || status().without_address);
    EXPECT_EQ(network_.settings.last_conflict[0], 1) << "it is a record";
}

TEST_F(ManagedAddress, ALinkThatReturnsIsAReasonToTryAgain) {  // R-ACD-3
    start_stored();
    claim(stored.address);
    manager_.on_link(0, false, now_);
    manager_.on_link(0, true, now_);
    run(1s);
    EXPECT_EQ(sent(), examination);
    EXPECT_EQ(manager_.address(), stored_address);
}

TEST_F(ManagedAddress, AfterTenConflictsItIsPatient) {  // R-ACD-3
    start_stored();
    claim(stored.address);
    for (int i = 0; i < 10; ++i) {
        run(10'200ms);
        claim(stored.address);
    }
    EXPECT_EQ(sent().size(), 10U);
    manager_.on_link(0, false, now_);
    manager_.on_link(0, true, now_);
    run(60'199ms);
    EXPECT_TRUE(sent().empty());
    run(1ms);
    EXPECT_EQ(sent(), Words{"probe"});
}

TEST_F(ManagedAddress, DhcpGrantsExaminesAndUses) {  // R-DHC-2
    grant_ = 0xC0A80264;
    network_.settings.host_name = "press-7";
    start(AddressMethod::dhcp);
    run(1s);
    EXPECT_EQ(sent(), (Words{"discover", "request"} + examination));
    EXPECT_EQ(manager_.address(), (enip::InterfaceAddress{0xC0A80264, 16, server}));
    EXPECT_TRUE(status().configured);
    EXPECT_EQ(network_.state.interface.mask, 0xFFFF0000);
    EXPECT_EQ(host_name_, "press-7");
}

TEST_F(ManagedAddress, BootpDoesTheSame) {  // R-DHC-3
    grant_ = 0xC0A80264;
    start(AddressMethod::bootp);
    run(1s);
    EXPECT_EQ(sent(), (Words{"bootp"} + examination));
    EXPECT_EQ(manager_.address(), (enip::InterfaceAddress{0xC0A80264, 16, server}));
}

TEST_F(ManagedAddress, NoServerNoAddress) {  // R-DHC-1: no fall-back
    network_.settings.configured = stored;
    start(AddressMethod::dhcp);
    run(1h);
    EXPECT_EQ(manager_.address(), std::nullopt);
    EXPECT_FALSE(status().configured);
    EXPECT_THAT(sent(), testing::Each("discover"));
}

TEST_F(ManagedAddress, AGrantedAddressThatSomebodyHasIsDeclined) {  // R-ACD-3
    grant_ = 0xC0A80264;
    start(AddressMethod::dhcp);
    run(300ms);
    sent();
    claim(grant_);
    EXPECT_EQ(sent(), Words{"decline"});
    EXPECT_TRUE(status().conflict && status().without_address);
    grant_ = 0xC0A80265;
    run(9999ms);
    EXPECT_TRUE(sent().empty());
    run(1001ms);
    EXPECT_EQ(sent(), (Words{"discover", "request"} + examination));
    EXPECT_EQ(manager_.address()->address, 0xC0A80265);
    EXPECT_FALSE(status().conflict || status().without_address);
}

TEST_F(ManagedAddress, ARenewedLeaseInterruptsNothing) {  // R-DHC-2
    grant_ = 0xC0A80264;
    start(AddressMethod::dhcp);
    run(10s);
    sent();
    gateway_ = 0xC0A80202;
    run(30min);
    EXPECT_EQ(losses_, 0);
    EXPECT_THAT(sent(), testing::Contains("request"));
    EXPECT_EQ(manager_.address(), (enip::InterfaceAddress{0xC0A80264, 16, 0xC0A80202}));
    EXPECT_EQ(network_.state.interface.gateway, 0xC0A80202);
    run(10h);
    EXPECT_EQ(losses_, 0);
}

TEST_F(ManagedAddress, AnExpiredLeaseTakesTheAddressAway) {  // R-DHC-2
    grant_ = 0xC0A80264;
    start(AddressMethod::dhcp);
    run(10s);
    grant_ = 0;
    run(1h);
    EXPECT_EQ(losses_, 1);
    EXPECT_EQ(manager_.address(), std::nullopt);
    EXPECT_FALSE(status().configured || status().without_address);
    EXPECT_EQ(network_.state.interface, InterfaceConfiguration{});
}

TEST_F(ManagedAddress, IsDefendedThenLost) {  // R-ACD-4
    start_stored();
    run(5s);
    sent();
    claim(stored.address);
    EXPECT_EQ(sent(), Words{"announcement"});
    EXPECT_TRUE(status().conflict && status().configured);
    EXPECT_FALSE(status().without_address);
    EXPECT_EQ(network_.settings.last_conflict[0], 2);
    run(10s);
    EXPECT_FALSE(status().conflict) << "the rival has given up";
    claim(stored.address);
    run(9s);
    EXPECT_EQ(losses_, 0);
    claim(stored.address);
    EXPECT_EQ(losses_, 1);
    EXPECT_EQ(manager_.address(), std::nullopt);
    EXPECT_TRUE(status().conflict && status().without_address);
    EXPECT_FALSE(status().configured);
    run(11s);
    EXPECT_EQ(manager_.address(), stored_address) << "it is looked for again";
    EXPECT_FALSE(status().conflict || status().without_address);
}

TEST_F(ManagedAddress, AGrantedAddressThatIsLostIsDeclined) {
    grant_ = 0xC0A80264;
    start(AddressMethod::dhcp);
    run(5s);
    sent();
    claim(grant_);
    claim(grant_);
    EXPECT_EQ(sent(), (Words{"announcement", "decline"}));
    EXPECT_EQ(losses_, 1);
}

TEST_F(ManagedAddress, ClearingTheRecordEndsTheConflict) {  // R-ACD-6; the object does it
    start_stored();
    run(5s);
    claim(stored.address);
    network_.settings.last_conflict = {};
    network_.state.address.conflict = false;
    run(20s);
    EXPECT_EQ(network_.settings.last_conflict, LastConflict{});
    EXPECT_FALSE(status().conflict);
}

TEST_F(ManagedAddress, AnotherStoredAddressIsExamined) {  // R-TCP-6
    start_stored();
    run(5s);
    sent();
    network_.settings.configured.address = 0xC0A802FA;
    network_.state.address.pending = true;
    manager_.change_address();
    EXPECT_EQ(manager_.address(), std::nullopt) << "the old one is given up at once";
    EXPECT_TRUE(status().pending);
    run(1s);
    EXPECT_EQ(sent(), examination);
    EXPECT_EQ(manager_.address()->address, 0xC0A802FA);
    EXPECT_FALSE(status().pending);
    EXPECT_EQ(losses_, 0) << "whoever has set it knows";
}

TEST_F(ManagedAddress, DisablingDhcpKeepsTheAddress) {  // 000 §1.4, R-TCP-4, R-DHC-4
    grant_ = 0xC0A80264;
    start(AddressMethod::dhcp);
    run(5s);
    const auto in_use = manager_.address();
    network_.settings.configured = network_.state.interface;
    network_.settings.method = AddressMethod::stored;
    grant_ = 0;
    sent();
    run(24h);
    EXPECT_THAT(sent(), testing::Each("probe")) << "the lease is nobody's business any more";
    EXPECT_EQ(manager_.address(), in_use);
    EXPECT_EQ(losses_, 0);
    claim(in_use->address);
    claim(in_use->address);
    EXPECT_EQ(sent(), Words{"announcement"}) << "nothing is declined";
    manager_.restart();
    run(1s);
    EXPECT_EQ(manager_.address(), in_use);
}

TEST_F(ManagedAddress, ALinkThatReturnsIsAReasonToAskAtOnce) {
    start(AddressMethod::dhcp);
    run(5min);
    sent();
    manager_.on_link(0, false, now_);
    grant_ = 0xC0A80264;
    manager_.on_link(0, true, now_);
    run(1s);
    EXPECT_EQ(sent(), (Words{"discover", "request"} + examination));
}

TEST_F(ManagedAddress, FramesOfOtherNetworksDoNotCount) {
    start_stored();
    const ArpPacket packet{
        .operation = ArpPacket::Operation::reply, .sender_mac = rival, .sender_address = stored.address};
    hear_arp(packet, 0x0005);  // VLAN 5
    EXPECT_FALSE(status().conflict);
    hear_arp(packet, 0xE000);  // a priority, and no VLAN
    EXPECT_TRUE(status().conflict);
}

TEST_F(ManagedAddress, DamagedFramesAreIgnoredAndCounted) {  // R-DHC
    start(AddressMethod::dhcp);
    const auto offer = [this] {
        grant_ = 0xC0A80264;
        manager_.restart();
        manager_.on_timer(now_);
        const auto discover = manager_.take_frames().at(0).octets;
        auto reply = *answer(discover);
        grant_ = 0;
        return reply;
    };
    auto damaged = offer();
    damaged[60] ^= 1;  // in the UDP payload
    hear_octets(damaged);
    EXPECT_EQ(manager_.ignored_replies().malformed, 1U);
    EXPECT_TRUE(manager_.take_frames().empty());
    manager_.on_frame(0, {.octets = offer(), .checksummed = false}, now_);
    settle();
    EXPECT_EQ(sent().back(), "request");
    hear_octets({});
    hear_octets(cip::Bytes(13));
    for (std::size_t size = 14; size < damaged.size(); ++size) {
        hear_octets(cip::Bytes(damaged.begin(), damaged.begin() + static_cast<std::ptrdiff_t>(size)));
    }
    EXPECT_EQ(manager_.ignored_replies().malformed, damaged.size() - 14);
}

// The whole device: what is set by the wire, and when.
class ManagedDevice : public testing::Test {
protected:
    ManagedDevice() {
        auto& network = t_.adapter().network();
        network.state.address_service = AddressService::dhcp_and_bootp;
        network.settings.method = AddressMethod::stored;
        network.settings.configured = {.address = 0xC0A80264, .mask = 0xFFFFFF00};
        manager_.on_loss([this] { t_.adapter().give_address_up(); });
        t_.adapter().on_address_change([this](AddressChange change) {
            change == AddressChange::set ? manager_.change_address() : manager_.restart();
        });
        manager_.restart();
        run(5s);
        t_.register_session();
    }

    void run(std::chrono::milliseconds duration) {
        for (auto left = duration; left > 0ms; left -= 10ms) {
            t_.advance(std::min(left, std::chrono::milliseconds(10)));
            if (const auto next = manager_.next_deadline(); next && *next <= t_.now()) manager_.on_timer(t_.now());
            frames_ += manager_.take_frames().size();
        }
    }

    test::AdapterHarness t_;
    AddressManager manager_{t_.adapter().network(), 1};
    std::size_t frames_ = 0;
};

TEST_F(ManagedDevice, ASetIsAnsweredBeforeAnythingChanges) {  // R-TCP-6, golden set_f5_ifconfig
    EXPECT_EQ(t_.call("0E 03 20 F5 24 01 30 02"), "8E 00 00 00 95 00 00 00");
    EXPECT_EQ(t_.call("10 03 20 F5 24 01 30 05 F9 02 A8 C0 00 FF FF FF 01 02 A8 C0 00 00 00 00 00 00 00 00 00 00"),
              "90 00 00 00");
    EXPECT_EQ(t_.call("0E 03 20 F5 24 01 30 01"), "8E 00 00 00 21 00 00 00") << "pending";
    EXPECT_EQ(manager_.address()->address, 0xC0A80264);
    run(90ms);
    EXPECT_TRUE(t_.connected());
    run(20ms);
    EXPECT_FALSE(t_.connected());
    EXPECT_EQ(manager_.address(), std::nullopt);
    run(1s);
    EXPECT_EQ(manager_.address(), (enip::InterfaceAddress{0xC0A802F9, 24, 0xC0A80201}));
    t_.connect();
    t_.register_session();
    EXPECT_EQ(t_.call("0E 03 20 F5 24 01 30 01"), "8E 00 00 00 01 00 00 00");
    EXPECT_EQ(t_.call("0E 03 20 F5 24 01 30 05"),
              "8E 00 00 00 F9 02 A8 C0 00 FF FF FF 01 02 A8 C0 00 00 00 00 00 00 00 00 00 00");
}

TEST_F(ManagedDevice, AResetLooksForTheAddressAnew) {  // R-ID-8, R-TCP-9
    EXPECT_EQ(t_.call("10 03 20 F5 24 01 30 0A 00"), "90 00 00 00");
    const auto before = frames_;
    EXPECT_EQ(t_.call("05 02 20 01 24 01"), "85 00 00 00");
    run(110ms);
    EXPECT_FALSE(t_.connected());
    EXPECT_EQ(manager_.address()->address, 0xC0A80264) << "without detection it is in use at once";
    EXPECT_EQ(frames_, before);
}

TEST_F(ManagedDevice, ALostAddressEndsAllConnections) {  // R-ACD-4, R-TCP-2
    const auto arp = ArpPacket{ArpPacket::Operation::reply, rival, 0xC0A80264, {}, 0}.encode();
    const auto claim = EthernetFrame{broadcast_mac, rival, {}, EtherType::arp, arp}.encode();
    manager_.on_frame(0, {.octets = claim}, t_.now());
    EXPECT_EQ(t_.call("0E 03 20 F5 24 01 30 01"), "8E 00 00 00 41 00 00 00");
    manager_.on_frame(0, {.octets = claim}, t_.now());
    run(10ms);
    EXPECT_FALSE(t_.connected());
    EXPECT_EQ(t_.adapter().sessions(), 0U);
}

}  // namespace
}  // namespace servobus::adapter
