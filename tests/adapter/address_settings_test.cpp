// What a Set does to the device's address, its multicast and its marks: the TCP/IP Interface object (R-TCP) and QoS
// (R-QOS) where they take effect.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "adapter/multicast_groups.hpp"
#include "tests/adapter/io_site.hpp"
#include "tests/support/adapter_harness.hpp"

namespace servobus::test {
namespace {

using testing::HasSubstr;

const std::string done = hex("90 00 00 00");
const std::string to_stored = "10 03 20 F5 24 01 30 03 00000000";
const std::string to_bootp = "10 03 20 F5 24 01 30 03 01000000";
const std::string to_dhcp = "10 03 20 F5 24 01 30 03 02000000";
const std::string set_interface = "10 03 20 F5 24 01 30 05";
const std::string get_interface = "0E 03 20 F5 24 01 30 05";
const std::string get_status = "0E 03 20 F5 24 01 30 01";
// 192.168.2.249/24, gateway 192.168.2.1, no name servers, no domain.
const std::string another = "F902A8C0 00FFFFFF 0102A8C0 00000000 00000000 0000";
const std::string first = "6402A8C0 00FFFFFF 00000000 00000000 00000000 0000";

std::string refused(std::string_view status) { return hex("90 00 " + std::string(status) + " 00"); }

adapter::Network at_home() {
    adapter::Network network;
    network.state.interface = {.address = AdapterHarness::local.address, .mask = 0xFFFFFF00};
    return network;
}

class TcpIpAddress : public testing::Test {
protected:
    explicit TcpIpAddress(adapter::Network network = at_home())
        : device_(drive::Device(drive::xenax_models().front()), {}, std::move(network)) {
        device_.register_session();
    }
    std::string get(const std::string& request) {
        const auto reply = octets(device_.call(request));
        return reply.size() < 4 ? "no answer" : hex(cip::ByteView(reply).subspan(4));
    }
    void come_back() {
        EXPECT_FALSE(device_.connected());
        device_.connect();
        device_.register_session();
    }

    AdapterHarness device_;
};

TEST_F(TcpIpAddress, R_TCP_6_IsSetWhenItIsStored) {
    EXPECT_EQ(device_.call(set_interface + another), refused("0C")) << "by DHCP";
    EXPECT_EQ(device_.call(to_stored), done);
    EXPECT_EQ(get(get_interface), hex(first)) << "R-TCP-4: what was leased stays";
    EXPECT_EQ(device_.call(set_interface + another), done);
    EXPECT_EQ(get(get_interface), hex(another));
}

TEST_F(TcpIpAddress, R_TCP_6_ReplyFirstThenAllConnectionsEnd) {
    EXPECT_EQ(device_.call(to_stored), done);
    EXPECT_EQ(device_.call(set_interface + another), done);
    EXPECT_EQ(get(get_status), hex("21000000")) << "R-TCP-2: pending";
    device_.advance(std::chrono::milliseconds(99));
    EXPECT_TRUE(device_.connected());
    device_.advance(std::chrono::milliseconds(1));
    come_back();
    EXPECT_EQ(get(get_status), hex("01000000"));
    EXPECT_EQ(get(get_interface), hex(another));
    EXPECT_EQ(get("0E 03 20 F4 24 01 30 07"), hex("12 0D 3139322E3136382E322E323439 00")) << "R-PRT-1";
}

TEST_F(TcpIpAddress, IsNotChangedByTheSameAddress) {
    EXPECT_EQ(device_.call(to_stored), done);
    EXPECT_EQ(device_.call(set_interface + first), done);
    EXPECT_EQ(get(get_status), hex("01000000"));
    device_.advance(std::chrono::milliseconds(200));
    EXPECT_TRUE(device_.connected());
}

TEST_F(TcpIpAddress, R_TCP_4_ToStoredEndsNothing) {
    EXPECT_EQ(device_.call(to_stored), done);
    device_.advance(std::chrono::milliseconds(200));
    EXPECT_TRUE(device_.connected());
    EXPECT_EQ(device_.call(to_stored), done) << "again";
    EXPECT_EQ(get(get_interface), hex(first));
}

TEST_F(TcpIpAddress, R_TCP_6_TheFirstThingThatIsWrongDecides) {
    // Too short and not stored; illegal and not stored.
    EXPECT_EQ(device_.call(set_interface + "00"), refused("0C"));
    EXPECT_EQ(device_.call(set_interface + std::string(44, '0')), refused("0C"));
    EXPECT_EQ(device_.call(to_stored), done);
    // Too short and illegal.
    EXPECT_EQ(device_.call(set_interface + std::string(40, '0')), refused("13"));
    EXPECT_EQ(device_.call(set_interface + std::string(46, '0')), refused("15"));
    EXPECT_EQ(get(get_interface), hex(first));
}

TEST_F(TcpIpAddress, R_TCP_6_WhatNoHostMayHave) {
    EXPECT_EQ(device_.call(to_stored), done);
    const auto rest = std::string(24, '0') + "0000";
    for (const auto* wrong : {
             "00000000 00000000",  // nothing at all
             "F902A8C0 00000000",  // no mask
             "F90200E0 00FFFFFF",  // class D
             "F90200F0 00FFFFFF",  // class E
             "0100007F 000000FF",  // loopback
             "F9020000 00FFFFFF",  // 0.x
             "0002A8C0 00FFFFFF",  // the subnet
             "FF02A8C0 00FFFFFF",  // its broadcast
             "F902A8C0 00FF00FF",  // a mask with a hole
             "F902A8C0 00FFFF7F",  // and one that does not begin with a one
             "F902A8C0 FFFFFFFF",  // no room for a host
         }) {
        EXPECT_EQ(device_.call(set_interface + wrong + rest), refused("09")) << wrong;
    }
    EXPECT_EQ(device_.call(set_interface + "F902A8C0 00FFFFFF 0103A8C0 00000000 00000000 0000"), refused("09"))
        << "a gateway elsewhere";
    EXPECT_EQ(get(get_interface), hex(first)) << "R-ERR-11";
    for (const auto* fine : {"F902A8C0 00FFFFFF", "0100000A 000000FF", "FEFFBF9F 0000FFFF", "0102A8C0 FCFFFFFF"}) {
        EXPECT_EQ(device_.call(set_interface + fine + rest), done) << fine;
    }
}

TEST_F(TcpIpAddress, R_TCP_6_TheDomainIsPaddedAndHas48CharactersAtMost) {
    EXPECT_EQ(device_.call(to_stored), done);
    const std::string numbers = "F902A8C0 00FFFFFF 0102A8C0 0102A8C0 0202A8C0";
    EXPECT_EQ(device_.call(set_interface + numbers + "0300 616263 00"), done);
    EXPECT_EQ(get(get_interface), hex(numbers + "0300 616263 00"));
    EXPECT_EQ(device_.call(set_interface + numbers + "0300 616263"), refused("13")) << "R-TYP-5";
    const auto longest = "3000" + hex(cip::Bytes(48, 'd'));
    EXPECT_EQ(device_.call(set_interface + numbers + longest), done);
    EXPECT_EQ(device_.call(set_interface + numbers + "3100" + hex(cip::Bytes(49, 'd')) + "00"), refused("15"));
    EXPECT_EQ(get(get_interface), hex(numbers + longest));
}

TEST_F(TcpIpAddress, R_TCP_3_BootpIsThereWhenSomebodySpeaksIt) {
    EXPECT_EQ(device_.call(to_bootp), refused("09"));
    device_.adapter().network().state.address_service = adapter::AddressService::dhcp_and_bootp;
    EXPECT_EQ(get("0E 03 20 F5 24 01 30 02"), hex("95000000"));
    EXPECT_EQ(device_.call(to_bootp), done);
    EXPECT_EQ(get("0E 03 20 F5 24 01 30 03"), hex("01000000"));
}

TEST_F(TcpIpAddress, R_TCP_4_ToALeaseIsAnotherAddress) {
    EXPECT_EQ(device_.call(to_stored), done);
    unsigned changes = 0;
    device_.adapter().on_address_change([&](adapter::AddressChange) { ++changes; });
    EXPECT_EQ(device_.call(to_dhcp), done);
    EXPECT_EQ(get(get_status), hex("21000000"));
    EXPECT_EQ(get(get_interface), hex(first)) << "nobody knows the next one yet";
    EXPECT_EQ(changes, 0U);
    device_.advance(std::chrono::milliseconds(100));
    EXPECT_EQ(changes, 1U);
    come_back();
}

TEST_F(TcpIpAddress, IsTheAffairOfWhoeverManagesIt) {
    auto& network = device_.adapter().network();
    device_.adapter().on_address_change([&](adapter::AddressChange) {
        EXPECT_FALSE(device_.connected()) << "the connections have ended before";
        network.state.interface = network.settings.configured;
        network.state.interface.domain = "managed";
        network.state.address = {.configured = true};
    });
    EXPECT_EQ(device_.call(to_stored), done);
    EXPECT_EQ(device_.call(set_interface + another), done);
    device_.advance(std::chrono::milliseconds(100));
    come_back();
    EXPECT_EQ(get(get_interface), hex(another.substr(0, another.size() - 4) + "0700 6D616E61676564 00"));
}

TEST_F(TcpIpAddress, ComesIntoForceAgainAtARestart) {
    EXPECT_EQ(device_.call(to_stored), done);
    EXPECT_EQ(device_.call(set_interface + another), done);
    EXPECT_EQ(device_.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    device_.advance(std::chrono::milliseconds(100));
    come_back();
    EXPECT_EQ(get(get_interface), hex(another));
    EXPECT_EQ(get(get_status), hex("01000000"));
}

// On an ordinary host clients are told what they have set, and the device stays where it is.
class TcpIpOnAHost : public TcpIpAddress {
protected:
    static adapter::Network on_a_host() {
        adapter::Network network;
        network.state.host = {.address = AdapterHarness::local.address, .mask = 0xFFFFFF00};
        adapter::apply_address_settings(network);
        return network;
    }
    TcpIpOnAHost() : TcpIpAddress(on_a_host()) {}
};

TEST_F(TcpIpOnAHost, R_DHC_5_ALeaseIsTheAddressOfTheHost) {
    EXPECT_EQ(get(get_interface), hex(first));
    EXPECT_EQ(device_.call(to_stored), done);
    EXPECT_EQ(device_.call(set_interface + another), done);
    device_.advance(std::chrono::milliseconds(100));
    come_back();
    EXPECT_EQ(get(get_interface), hex(another));
    EXPECT_EQ(get("0E 03 20 F5 24 01 30 09"), hex("00 00 0100 600DC0EF")) << "multicast is sent from where it is";
    EXPECT_EQ(device_.call(to_dhcp), done);
    device_.advance(std::chrono::milliseconds(100));
    come_back();
    EXPECT_EQ(get(get_interface), hex(first));
}

TEST_F(TcpIpOnAHost, R_ID_8_FactoryDefaultsBringTheLeaseBack) {
    EXPECT_EQ(device_.call(to_stored), done);
    EXPECT_EQ(device_.call(set_interface + another), done);
    device_.advance(std::chrono::milliseconds(100));
    come_back();
    EXPECT_EQ(device_.call("05 02 20 01 24 01 01"), hex("85 00 00 00"));
    device_.advance(std::chrono::milliseconds(100));
    come_back();
    EXPECT_EQ(get(get_interface), hex(first));
    EXPECT_EQ(get("0E 03 20 F5 24 01 30 03"), hex("02000000"));
}

// ------------------------------------------------------------------------------------------------ with I/O connections

TEST(TcpIpWithIo, R_TCP_6_AnAddressThatIsInUseIsNotTakenAway) {
    IoSite site;
    IoPeer peer(site);
    EXPECT_EQ(peer.call(to_stored), done);
    const auto link = peer.must_open(io_open(1, 254));
    EXPECT_EQ(peer.call(set_interface + another), refused("10"));
    EXPECT_EQ(peer.call(set_interface + "00"), refused("10")) << "before anything else";
    EXPECT_EQ(peer.call(to_dhcp), refused("10"));
    EXPECT_EQ(peer.call("0E 03 20 F5 24 01 30 03"), hex("8E 00 00 00 00000000"));
    (void)peer.close(link);
    EXPECT_EQ(peer.call(set_interface + another), done);
}

TEST(TcpIpWithIo, R_TCP_4_ToStoredIsFineWhileItIsInUse) {
    IoSite site;
    IoPeer peer(site);
    (void)peer.must_open(io_open(1, 254));
    EXPECT_EQ(peer.call(to_stored), done);
    EXPECT_EQ(peer.call(to_dhcp), refused("10"));
    EXPECT_EQ(site.adapter.io().size(), 1U);
}

TEST(TcpIpWithIo, R_TCP_6_WhatOpensBetweenReplyAndChangeEndsToo) {
    IoSite site;
    IoPeer peer(site);
    EXPECT_EQ(peer.call(to_stored), done);
    EXPECT_EQ(peer.call(set_interface + another), done);
    const auto link = peer.must_open(io_open(1));
    site.advance(99ms);
    EXPECT_EQ(site.adapter.io().size(), 1U);
    EXPECT_FALSE(site.take().empty());
    site.advance(1ms);
    EXPECT_EQ(site.adapter.io().size(), 0U);
    EXPECT_EQ(site.adapter.io().owner(), nullptr);
    EXPECT_THAT(site.last_warning(), HasSubstr("the device gives its address up"));
    site.take();
    site.advance(50ms);
    EXPECT_TRUE(site.take().empty());
    EXPECT_EQ(site.adapter.io().strays().unknown_id, 0U);
    peer.send(o_to_t(link, 1, 1, run, cip::Bytes(18)));
    EXPECT_EQ(site.adapter.io().strays().unknown_id, 1U);
}

TEST(TcpIpWithIo, R_TCP_8_MulticastIsSentAsItIsSet) {
    IoSite site;
    IoPeer peer(site);
    EXPECT_EQ(peer.call("10 03 20 F5 24 01 30 08 05"), done);
    // Two groups from 239.193.0.16 on.
    EXPECT_EQ(peer.call("10 03 20 F5 24 01 30 09 01 00 0200 1000C1EF"), done);
    const auto group_of = [&](std::uint16_t serial, std::uint16_t point) {
        const auto link = peer.must_open(multicast(io_open(serial, 254, point)));
        const auto told = link.socket(enip::ItemType::sockaddr_t_to_o);
        site.take();
        site.advance(10ms);
        const auto sent = site.take();
        EXPECT_EQ(sent.size(), serial) << "one of each connection so far";
        for (const auto& each : sent) EXPECT_EQ(each.route.ttl, 5);
        return enip::to_string({told->address, told->port});
    };
    EXPECT_EQ(group_of(1, 100), "239.193.0.16:2222");
    EXPECT_EQ(group_of(2, 105), "239.193.0.17:2222");
    EXPECT_EQ(group_of(3, 113), "239.193.0.16:2222") << "the third of two";
}

TEST(TcpIpWithIo, R_TCP_8_NothingIsRedirectedWhileItIsSent) {
    IoSite site;
    IoPeer peer(site);
    const auto alone = peer.must_open(io_open(1, 254));
    EXPECT_EQ(peer.call("10 03 20 F5 24 01 30 08 02"), done) << "point-to-point does not count";
    const auto link = peer.must_open(multicast(io_open(2, 254)));
    for (const auto* request : {"10 03 20 F5 24 01 30 08 03", "10 03 20 F5 24 01 30 08 00",
                                "10 03 20 F5 24 01 30 09 01 00 0100 0000C1EF", "10 03 20 F5 24 01 30 09 00"}) {
        EXPECT_EQ(peer.call(request), refused("0C")) << request;
    }
    EXPECT_EQ(peer.call("0E 03 20 F5 24 01 30 08"), hex("8E 00 00 00 02"));
    (void)peer.close(link);
    EXPECT_EQ(peer.call("10 03 20 F5 24 01 30 08 03"), done);
    EXPECT_EQ(peer.call("10 03 20 F5 24 01 30 09 01 00 0100 0000C1EF"), done);
    EXPECT_EQ(peer.call("10 03 20 F5 24 01 30 09 00 FF 2100 FFFFFFFF"), done) << "by the algorithm the rest is ignored";
    EXPECT_EQ(peer.call("0E 03 20 F5 24 01 30 09"), hex("8E 00 00 00 00 00 0100 600DC0EF"));
    (void)peer.close(alone);
}

TEST(TcpIpWithIo, R_MC_2_TheGroupsInUseAreCounted) {
    IoSite site;
    IoPeer peer(site);
    const auto count = [&] { return peer.call("0E 03 20 F5 24 01 30 09"); };
    (void)peer.must_open(multicast(io_open(1, 254, 100)));
    EXPECT_EQ(count(), hex("8E 00 00 00 00 00 0100 600DC0EF"));
    (void)peer.must_open(multicast(io_open(2, 254, 113)));
    EXPECT_EQ(count(), hex("8E 00 00 00 00 00 0300 600DC0EF")) << "113 has the third";
}

TEST(TcpIpWithIo, R_MC_4_WithALargerTtlItCrossesRouters) {
    IoSite site;
    IoPeer far(site, 0xC0A80301);
    EXPECT_EQ(far.refusal(multicast(io_open(1))), hex("01 01 1308"));
    EXPECT_EQ(far.call("10 03 20 F5 24 01 30 08 02"), done);
    EXPECT_TRUE(far.open(multicast(io_open(1))));
}

TEST(TcpIpWithIo, R_MC_1_TheMaskOfTheClassCountsWhereNoneIsKnown) {
    adapter::Network network;
    EXPECT_EQ(adapter::multicast_groups(network, 0).first, 0U) << "no address, no groups";
    EXPECT_EQ(adapter::multicast_groups(network, 0xC0A80264).first, 0xEFC00D60);
    EXPECT_EQ(adapter::multicast_groups(network, 0xC0A80264).of(31), 0xEFC00D7F);
    EXPECT_EQ(adapter::multicast_groups(network, 0xC0A80264).of(32), 0xEFC00D60);
    EXPECT_EQ(adapter::multicast_groups(network, 0x0A000001).first, 0xEFC00100);
    EXPECT_EQ(adapter::multicast_groups(network, 0xAC100102).first, 0xEFC00100 + 0x101U * 32) << "172.16.1.2";
}

// ----------------------------------------------------------------------------------------------------------------- QoS

TEST(QosInForce, R_QOS_4_FromTheNextRestartOn) {
    IoSite site;
    IoPeer peer(site);
    const auto dscp_of_data = [&](IoPeer& originator, cip::Priority priority) {
        auto open = io_open(1, 254);
        open.t_to_o.priority = priority;
        const auto link = originator.must_open(open);
        site.take();
        site.advance(10ms);
        const auto sent = site.take();
        (void)originator.close(link);
        return sent.empty() ? 0 : sent[0].route.dscp;
    };
    using enum cip::Priority;
    const std::array<std::pair<cip::Priority, std::string_view>, 4> priorities{
        {{urgent, "04"}, {scheduled, "05"}, {high, "06"}, {low, "07"}}};
    std::uint8_t value = 1;
    for (const auto& [priority, attribute] : priorities) {
        EXPECT_EQ(peer.call(fmt::format("10 03 20 48 24 01 30 {} {:02X}", attribute, value++)), done);
    }
    EXPECT_EQ(peer.call("10 03 20 48 24 01 30 08 05"), done);
    EXPECT_EQ(peer.call("0E 03 20 48 24 01 30 08"), hex("8E 00 00 00 05")) << "what is stored is told at once";
    EXPECT_EQ(site.adapter.explicit_dscp(), 27);
    const std::array<int, 4> before{55, 47, 43, 31};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(dscp_of_data(peer, priorities[i].first), before[i]);
    EXPECT_EQ(peer.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    site.advance(100ms);
    IoPeer next(site);
    EXPECT_EQ(site.adapter.explicit_dscp(), 5);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(dscp_of_data(next, priorities[i].first), static_cast<int>(i) + 1);
}

// ------------------------------------------------------------------------------------------------ Connection Manager

TEST(ConnectionEntries, R_CM_2_ABitIsClearWhileItsConnectionIsOpen) {
    adapter::Limits limits;
    limits.listening_connections = 2;
    limits.class3_connections = 7;
    IoSite site(drive::Device(drive::xenax_models().front()), limits);
    IoPeer peer(site);
    const auto entries = [&] { return peer.call("0E 03 20 06 24 01 30 09"); };
    EXPECT_EQ(entries(), hex("8E 00 00 00 0A00 FF03"));
    const auto owner = peer.must_open(io_open(1));
    (void)peer.must_open(io_open(2, 254));
    EXPECT_EQ(entries(), hex("8E 00 00 00 0A00 FC03"));
    (void)peer.close(owner);
    EXPECT_EQ(entries(), hex("8E 00 00 00 0A00 FD03"));
}

TEST(ConnectionManagerResources, R_CM_2_AreMeasured) {
    AdapterHarness device;
    device.register_session();
    device.adapter().measure_cpu([] { return std::uint16_t{123}; });
    EXPECT_EQ(device.call("0E 03 20 06 24 01 30 0B"), hex("8E 00 00 00 7B00"));
    EXPECT_EQ(device.call("0E 03 20 06 24 01 30 0D"), hex("8E 00 00 00 0000C000")) << "nothing waits";
    // What a peer has not taken yet takes room: a second connection that sends and does not read.
    const auto id = device.adapter().on_open({0xC0A80202, 5000}, AdapterHarness::local, device.now());
    ASSERT_TRUE(id);
    const auto list = octets("04 00 00 00 00000000 00000000 0000000000000000 00000000");
    ASSERT_EQ(device.adapter().on_octets(*id, list, device.now()), list.size());
    // 24 octets of header and 26 of ListServices.
    EXPECT_EQ(device.call("0E 03 20 06 24 01 30 0D"), hex("8E 00 00 00 CEFFBF00"));
    device.adapter().on_closed(*id, device.now());
}

// --------------------------------------------------------------------------------------------------------- Ethernet Link

TEST(EthernetPort, R_ETH_6_TheModuleOnTheDeskTakesWhatItIsTold) {
    AdapterHarness device;
    device.register_session();
    EXPECT_EQ(device.call("10 03 20 F6 24 01 30 06 0000 0A00"), done);
    EXPECT_EQ(device.call("0E 03 20 F6 24 01 30 01"), hex("8E 00 00 00 0A000000"));
    EXPECT_EQ(device.call("0E 03 20 F6 24 01 30 02"), hex("8E 00 00 00 11000000")) << "link, half duplex, forced";
    EXPECT_EQ(device.call("10 03 20 F6 24 01 30 06 0200 6400"), done);
    EXPECT_EQ(device.call("0E 03 20 F6 24 01 30 02"), hex("8E 00 00 00 13000000")) << "link, full duplex, forced";
    EXPECT_EQ(device.call("10 03 20 F6 24 02 30 06 0200 6400"), done);
    EXPECT_EQ(device.call("0E 03 20 F6 24 02 30 02"), hex("8E 00 00 00 00000000")) << "still no cable";
}

TEST(EthernetPort, R_ETH_1_TellsWhatTheInterfaceIs) {
    AdapterHarness device;
    device.register_session();
    enip::InterfaceFacts facts{.ethernet = true,
                               .link = true,
                               .speed = 1000,
                               .negotiation = enip::Negotiation::done,
                               .counters = {},
                               .media = {}};
    facts.counters = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
    facts.media = {21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32};
    device.adapter().network().state.ports[0] = [&] { return facts; };
    const auto get = [&](unsigned id) { return device.call(fmt::format("0E 03 20 F6 24 01 30 {:02X}", id)); };
    EXPECT_EQ(get(1), hex("8E 00 00 00 E8030000"));
    EXPECT_EQ(get(2), hex("8E 00 00 00 0D000000")) << "link, half duplex, negotiated";
    std::string counters;
    for (int i = 1; i <= 11; ++i) counters += fmt::format("{:02X}000000", i);
    EXPECT_EQ(get(4), hex("8E 00 00 00" + counters));
    std::string media;
    for (int i = 21; i <= 32; ++i) media += fmt::format("{:02X}000000", i);
    EXPECT_EQ(get(5), hex("8E 00 00 00" + media));
    facts.full_duplex = true;
    EXPECT_EQ(get(2), hex("8E 00 00 00 0F000000"));
    EXPECT_EQ(device.call("10 03 20 F6 24 01 30 06 0000 0A00"), done);
    EXPECT_EQ(get(1), hex("8E 00 00 00 E8030000")) << "the host's interface is not touched";
    facts.link = false;
    EXPECT_EQ(get(2), hex("8E 00 00 00 00000000")) << "R-ETH-2";
}

TEST(EthernetPort, OnLoopbackTheModuleIsToldAndTheCountersAreReal) {
    AdapterHarness device;
    device.register_session();
    device.adapter().network().state.ports[0] = [] {
        enip::InterfaceFacts lo{.ethernet = false, .link = true, .counters = {}, .media = {}};
        lo.counters.in_octets = 0x1234;
        return lo;
    };
    EXPECT_EQ(device.call("0E 03 20 F6 24 01 30 01"), hex("8E 00 00 00 64000000"));
    EXPECT_EQ(device.call("0E 03 20 F6 24 01 30 02"), hex("8E 00 00 00 0F000000"));
    EXPECT_EQ(device.call("0E 03 20 F6 24 01 30 04").substr(0, 23), hex("8E 00 00 00 34120000"));
}

}  // namespace
}  // namespace servobus::test
