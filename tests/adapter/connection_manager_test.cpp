// Class 3 connections and Unconnected_Send (R-CM, R-CON), hex in and hex out.
#include <gtest/gtest.h>

#include "cip/unconnected_send.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

constexpr std::string_view get_s_curve = "0E 03 20 64 24 01 30 00";
const std::string s_curve = hex("8E 00 00 00 14 00 00 00");

std::string counter(Peer& peer, unsigned attribute) {
    return peer.call(fmt::format("0E 03 20 06 24 01 30 {:02X}", attribute));
}
std::string count(unsigned value) { return hex(fmt::format("8E 00 00 00 {:02X} {:02X}", value & 0xFF, value >> 8)); }

cip::Bytes request(const cip::ForwardOpen& open) {
    const std::uint8_t service = open.large ? 0x5B : 0x54;
    return cip::Request{service, cip::Path::to(6, 1), open.encode()}.encode();
}

TEST(ForwardOpen, R_CON_13_OpensAClass3Connection) {
    Site site;
    auto peer = registered(site);
    const auto reply =
        octets(peer.call("54 02 2006 2401 0A0E 00000000 0100FE80 0100 4D00 44332211 02 000000 "
                         "20A10700 F843 30A20700 F843 A3 02 2002 2401"));
    ASSERT_EQ(reply.size(), 4U + 26);
    cip::Reader ids(cip::ByteView(reply).subspan(4));
    const auto id = ids.u32();
    EXPECT_NE(id, 0U);
    EXPECT_EQ(hex(ids.rest()), hex("0100FE80 0100 4D00 44332211 20A10700 30A20700 00 00"));
    EXPECT_EQ(site.adapter.class3_connections(), 1U);
    EXPECT_EQ(hex(cip::ByteView(reply).first(4)), hex("D4 00 00 00"));
}

TEST(ForwardOpen, R_CON_2_OpensALargeClass3Connection) {
    Site site;
    auto peer = registered(site);
    const auto reply = peer.call(
        "5B 02 2006 2401 0A0E 00000000 0100FE80 0100 4D00 44332211 02 000000 "
        "20A10700 A20F0042 20A10700 A20F0042 A3 02 2002 2401");
    EXPECT_EQ(reply.substr(0, 11), "DB 00 00 00");
    EXPECT_EQ(octets(reply).size(), 4U + 26);
}

TEST(ForwardOpen, R_CON_10_TakesAKeyAndTheDevicesOwnPort) {
    for (const auto* path :
         {"20 02 24 01", "34 04 6D05 2B00 0975 01 01 2002 2401", "34 04 0000 0000 0000 00 00 2002 2401",
          "34 04 6D05 2B00 0975 81 01 2002 2401", "01 00 20 02 24 01", "01 00 34 04 6D05 2B00 0975 01 00 20 02 24 01",
          "21 00 02 00 25 00 01 00", "34 05 6D05 2B00 0975 01 01 00000000 2002 2401"}) {
        Site site;
        auto peer = registered(site);
        auto open = Peer::class3_open(1);
        open.path = octets(path);
        EXPECT_EQ(peer.call(request(open)).substr(0, 11), "D4 00 00 00") << path;
    }
}

TEST(ForwardOpen, R_CON_16_ChoosesIdsThatDifferBetweenConnectionsAndStarts) {
    const auto ids = [](std::uint64_t seed) {
        Site site({}, drive::Device(drive::xenax_models().front()), seed);
        auto peer = registered(site);
        peer.open_class3(1);
        const auto first = peer.connection();
        peer.open_class3(2);
        return std::pair(first, peer.connection());
    };
    const auto [first, second] = ids(1);
    EXPECT_NE(first, second);
    EXPECT_EQ(first >> 16, second >> 16);
    EXPECT_NE(ids(2).first >> 16, first >> 16);
}

struct Refused {
    const char* what;
    const char* status;  ///< general status, size and words, in hex
    void (*change)(cip::ForwardOpen&);
    unsigned counter = 2;  ///< which reject counts (R-CM-3)
};
void PrintTo(const Refused& each, std::ostream* out) { *out << each.what; }

class ForwardOpenRefusal : public testing::TestWithParam<Refused> {};
TEST_P(ForwardOpenRefusal, R_CON_15_NamesTheReasonAndOpensNothing) {
    Site site;
    auto peer = registered(site);
    for (const bool large : {false, true}) {
        auto open = Peer::class3_open(0x1234);
        open.large = large;
        GetParam().change(open);
        EXPECT_EQ(peer.call(request(open)),
                  hex(std::string(large ? "DB 00 " : "D4 00 ") + GetParam().status + "3412 4D00 44332211 00 00"));
    }
    EXPECT_EQ(site.adapter.class3_connections(), 0U);
    EXPECT_EQ(counter(peer, 1), count(2));
    for (unsigned reject = 2; reject <= 4; ++reject) {
        EXPECT_EQ(counter(peer, reject), count(reject == GetParam().counter ? 2 : 0)) << "attribute " << reject;
    }
    peer.open_class3(0x1234);
}
using cip::ConnectionType;
INSTANTIATE_TEST_SUITE_P(
    R_CON_40, ForwardOpenRefusal,
    testing::Values(
        Refused{"0x0103 class 0", "01 01 0301",
                [](auto& open) {
                    open.transport = {false, 0, 0};
                }},
        Refused{"0x0103 class 2", "01 01 0301",
                [](auto& open) {
                    open.transport = {true, 2, 2};
                }},
        Refused{"0x0103 class 4", "01 01 0301",
                [](auto& open) {
                    open.transport = {true, 2, 4};
                }},
        Refused{"0x0103 class 15", "01 01 0301",
                [](auto& open) {
                    open.transport = {true, 2, 15};
                }},
        Refused{"0x0103 trigger 3", "01 01 0301", [](auto& open) { open.transport.trigger = 3; }},
        Refused{"0x0103 trigger 7", "01 01 0301", [](auto& open) { open.transport.trigger = 7; }},
        Refused{"0x0111 O->T", "01 01 1101", [](auto& open) { open.o_to_t_rpi = 0; }},
        Refused{"0x0111 T->O", "01 01 1101", [](auto& open) { open.t_to_o_rpi = 0; }},
        Refused{"0x0112 O->T below 1 ms", "01 06 1201 0200 E8030000 90D00300",
                [](auto& open) { open.o_to_t_rpi = 999; }},
        Refused{"0x0112 T->O below 1 ms", "01 06 1201 0002 90D00300 E8030000", [](auto& open) { open.t_to_o_rpi = 1; }},
        Refused{"0x0112 both below 1 ms", "01 06 1201 0202 E8030000 E8030000",
                [](auto& open) { open.o_to_t_rpi = open.t_to_o_rpi = 500; }},
        Refused{"0x0114 vendor", "01 01 1401",
                [](auto& open) { open.path = octets("34 04 0100 2B00 0975 01 01 2002 2401"); }},
        Refused{"0x0114 product code", "01 01 1401",
                [](auto& open) { open.path = octets("34 04 6D05 2B00 0875 01 01 2002 2401"); }},
        Refused{"0x0115 device type", "01 01 1501",
                [](auto& open) { open.path = octets("34 04 6D05 0C00 0975 01 01 2002 2401"); }},
        Refused{"0x0116 major revision", "01 01 1601",
                [](auto& open) { open.path = octets("34 04 6D05 2B00 0975 02 01 2002 2401"); }},
        Refused{"0x0116 minor revision", "01 01 1601",
                [](auto& open) { open.path = octets("34 04 6D05 2B00 0975 01 02 2002 2401"); }},
        Refused{"0x0116 compatible major", "01 01 1601",
                [](auto& open) { open.path = octets("34 04 6D05 2B00 0975 82 01 2002 2401"); }},
        Refused{"0x0116 compatible minor", "01 01 1601",
                [](auto& open) { open.path = octets("34 04 6D05 2B00 0975 81 02 2002 2401"); }},
        Refused{"0x0123 multicast O->T", "01 01 2301",
                [](auto& open) { open.o_to_t.type = ConnectionType::multicast; }},
        Refused{"0x0123 reserved O->T", "01 01 2301", [](auto& open) { open.o_to_t.type = ConnectionType::reserved; }},
        Refused{"0x0123 null O->T", "01 01 2301", [](auto& open) { open.o_to_t.type = ConnectionType::null; }},
        Refused{"0x0124 multicast T->O", "01 01 2401",
                [](auto& open) { open.t_to_o.type = ConnectionType::multicast; }},
        Refused{"0x0124 reserved T->O", "01 01 2401", [](auto& open) { open.t_to_o.type = ConnectionType::reserved; }},
        Refused{"0x0124 null T->O", "01 01 2401", [](auto& open) { open.t_to_o.type = ConnectionType::null; }},
        Refused{"0x0125", "01 01 2501", [](auto& open) { open.o_to_t.redundant_owner = true; }},
        Refused{"0x0127 too small", "01 02 2701 A20F", [](auto& open) { open.o_to_t.size = 3; }},
        Refused{"0x0127 zero", "01 02 2701 A20F", [](auto& open) { open.o_to_t.size = 0; }},
        Refused{"0x0128 too small", "01 02 2801 A20F", [](auto& open) { open.t_to_o.size = 3; }},
        Refused{"0x0132", "01 01 3201", [](auto& open) { open.o_to_t.type = open.t_to_o.type = ConnectionType::null; },
                4},
        Refused{"0x0133 code 8", "01 01 3301", [](auto& open) { open.timeout_multiplier = 8; }},
        Refused{"0x0133 code 255", "01 01 3301", [](auto& open) { open.timeout_multiplier = 255; }},
        Refused{"0x0311 port 3", "01 01 1103", [](auto& open) { open.path = octets("03 00 2002 2401"); }},
        Refused{"0x0312 backplane slot 1", "01 01 1203", [](auto& open) { open.path = octets("01 01 2002 2401"); }},
        Refused{"0x0312 network port", "01 01 1203",
                [](auto& open) { open.path = octets("12 0D 3139322E3136382E312E31303000 2002 2401"); }},
        Refused{"0x0315 empty path", "01 01 1503", [](auto& open) { open.path = {}; }},
        Refused{"0x0315 class alone", "01 01 1503", [](auto& open) { open.path = octets("20 02"); }},
        Refused{"0x0315 another class", "01 01 1503", [](auto& open) { open.path = octets("20 64 24 01"); }},
        Refused{"0x0315 instance 0", "01 01 1503", [](auto& open) { open.path = octets("20 02 24 00"); }},
        Refused{"0x0315 something behind", "01 01 1503", [](auto& open) { open.path = octets("20 02 24 01 30 01"); }},
        Refused{"0x0315 a symbol", "01 01 1503", [](auto& open) { open.path = octets("91 02 4142"); }},
        Refused{"0x0315 a reserved segment", "01 01 1503", [](auto& open) { open.path = octets("E0 00"); }},
        Refused{"0x0315 an unknown key format", "01 01 1503",
                [](auto& open) { open.path = octets("34 06 6D05 2B00 0975 01 01 2002 2401"); }},
        Refused{"0x0315 two hops", "01 01 1503", [](auto& open) { open.path = octets("01 00 01 00 2002 2401"); }}));

TEST(ForwardOpen, R_CON_47_ALargeConnectionAtItsLimitAndOnePastIt) {
    Site site;
    auto peer = registered(site);
    auto open = Peer::class3_open(1);
    open.large = true;
    open.o_to_t.size = open.t_to_o.size = 4002;
    EXPECT_EQ(peer.call(request(open)).substr(0, 11), "DB 00 00 00");
    open.triad.serial_number = 2;
    open.o_to_t.size = 4003;
    EXPECT_EQ(peer.call(request(open)), hex("DB 00 01 02 2701 A20F 0200 4D00 44332211 00 00"));
    open.o_to_t.size = 4;
    open.t_to_o.size = 0xFFFF;
    EXPECT_EQ(peer.call(request(open)), hex("DB 00 01 02 2801 A20F 0200 4D00 44332211 00 00"));
    open.t_to_o.size = 4;
    EXPECT_EQ(peer.call(request(open)).substr(0, 11), "DB 00 00 00");
}

TEST(ForwardOpen, R_CON_17_TakesTheSmallestAndTheLargestInterval) {
    Site site;
    auto peer = registered(site);
    auto open = Peer::class3_open(1);
    open.o_to_t_rpi = 1000;
    open.t_to_o_rpi = 0xFFFFFFFF;
    open.timeout_multiplier = 7;
    EXPECT_EQ(peer.call(request(open)).substr(0, 11), "D4 00 00 00");
    open.triad.serial_number = 2;
    open.o_to_t_rpi = 0xFFFFFFFF;
    EXPECT_EQ(peer.call(request(open)).substr(0, 11), "D4 00 00 00");
    EXPECT_EQ(site.adapter.class3_connections(), 2U);
}

TEST(ForwardOpen, R_CON_26_AnOpenTriadIsADuplicateWhateverElseIsWrong) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    auto open = Peer::class3_open(1);
    const auto duplicate = hex("D4 00 01 01 0001 0100 4D00 44332211 00 00");
    EXPECT_EQ(peer.call(request(open)), duplicate);
    open.transport = {false, 0, 1};
    open.path = {};
    EXPECT_EQ(peer.call(request(open)), duplicate);
    EXPECT_EQ(registered(site, 0xC0A80202).call(request(open)), duplicate);
    EXPECT_EQ(counter(peer, 4), count(3));
    EXPECT_EQ(peer.connected_call(1, get_s_curve), s_curve) << "the open connection stays";
    open = Peer::class3_open(1);
    open.triad.originator_vendor = 0x4E;
    EXPECT_EQ(peer.call(request(open)).substr(0, 11), "D4 00 00 00") << "each part of the triad counts";
    open.triad = {1, 0x4D, 0x11223345};
    EXPECT_EQ(peer.call(request(open)).substr(0, 11), "D4 00 00 00");
}

TEST(ForwardOpen, R_CON_23_ANullOpenOfAnOpenTriadIsNotADuplicate) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    auto open = Peer::class3_open(1);
    open.o_to_t.type = open.t_to_o.type = ConnectionType::null;
    EXPECT_EQ(peer.call(request(open)), hex("D4 00 01 01 3201 0100 4D00 44332211 00 00"));
}

TEST(ForwardOpen, R_CON_14_IsCutShortOrTooLong) {
    Site site;
    auto peer = registered(site);
    const auto whole = Peer::class3_open(0x1234).encode();
    const auto call = [&](cip::Bytes data) {
        return peer.call(cip::Request{0x54, cip::Path::to(6, 1), std::move(data)}.encode());
    };
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const auto* triad = size < 18 ? "0000 0000 00000000" : "3412 4D00 44332211";
        EXPECT_EQ(call({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}),
                  hex(std::string("D4 00 13 00") + triad + "00 00"))
            << size;
    }
    auto longer = whole;
    longer.push_back(0);
    EXPECT_EQ(call(longer), hex("D4 00 15 00 3412 4D00 44332211 00 00"));
    EXPECT_EQ(counter(peer, 2), count(static_cast<unsigned>(whole.size()) + 1));
    EXPECT_EQ(site.adapter.class3_connections(), 0U);
}

TEST(ForwardClose, R_CON_34_EndsTheConnection) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    EXPECT_EQ(peer.call("4E 02 2006 2401 0A0E 0100 4D00 44332211 02 00 2002 2401"),
              hex("CE 00 00 00 0100 4D00 44332211 00 00"));
    EXPECT_EQ(site.adapter.class3_connections(), 0U);
    EXPECT_EQ(peer.connected_call(1, get_s_curve), "");
    EXPECT_EQ(counter(peer, 5), count(1));
    EXPECT_EQ(counter(peer, 6), count(0));
    EXPECT_EQ(counter(peer, 7), count(0));
}

TEST(ForwardClose, R_CON_35_MatchesByTheTriadAlone) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    EXPECT_EQ(peer.call("4E 02 2006 2401 0A0E 0100 4D00 44332211 00 00"), hex("CE 00 00 00 0100 4D00 44332211 00 00"));
}

TEST(ForwardClose, R_CON_36_OfAnUnknownTriad) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    for (const auto* triad : {"0200 4D00 44332211", "0100 4E00 44332211", "0100 4D00 45332211"}) {
        EXPECT_EQ(peer.call(std::string("4E 02 2006 2401 0A0E ") + triad + "02 00 2002 2401"),
                  hex(std::string("CE 00 01 01 0701") + triad + "00 00"));
    }
    EXPECT_EQ(counter(peer, 7), count(3));
    EXPECT_EQ(site.adapter.class3_connections(), 1U);
}

TEST(ForwardClose, R_CON_36_FromAnotherAddressIsAPrivilegeViolation) {
    Site site;
    auto owner = registered(site);
    owner.open_class3(1);
    auto stranger = registered(site, 0xC0A80202);
    EXPECT_EQ(stranger.call("4E 02 2006 2401 0A0E 0100 4D00 44332211 02 00 2002 2401"),
              hex("CE 00 0F 00 0100 4D00 44332211 00 00"));
    EXPECT_EQ(owner.connected_call(1, get_s_curve), s_curve);
    EXPECT_EQ(counter(owner, 7), count(1));
    auto same_host = registered(site);
    EXPECT_EQ(same_host.call("4E 02 2006 2401 0A0E 0100 4D00 44332211 02 00 2002 2401"),
              hex("CE 00 00 00 0100 4D00 44332211 00 00"));
}

TEST(ForwardClose, R_CON_36_IsCutShortOrTooLong) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    EXPECT_EQ(peer.call("4E 02 2006 2401 0A0E 0100 4D00 44332211 02 00 2002 24"),
              hex("CE 00 13 00 0100 4D00 44332211 00 00"));
    EXPECT_EQ(peer.call("4E 02 2006 2401 0A0E 0100 4D00"), hex("CE 00 13 00 0000 0000 00000000 00 00"));
    EXPECT_EQ(peer.call("4E 02 2006 2401 0A0E 0100 4D00 44332211 02 00 2002 2401 00"),
              hex("CE 00 15 00 0100 4D00 44332211 00 00"));
    EXPECT_EQ(counter(peer, 6), count(3));
    EXPECT_EQ(site.adapter.class3_connections(), 1U);
}

TEST(Class3, R_CON_45_AnswersWithTheOtherIdAndTheSameCount) {
    Site site;
    auto peer = registered(site);
    peer.open_class3();
    const auto id = fmt::format("{:02X} {:02X} {:02X} {:02X}", peer.connection() & 0xFF, peer.connection() >> 8 & 0xFF,
                                peer.connection() >> 16 & 0xFF, peer.connection() >> 24);
    EXPECT_EQ(peer.send(frame("70 00", own_session,
                              "00000000 0000 0200 A100 0400" + id + "B100 0A00 2A01 0E03 2064 2401 3000")),
              peer.text(frame("70 00", own_session,
                              "00000000 0000 0200 A100 0400 0100FE80 B100 0A00 2A01 8E00 0000 14000000")));
}

TEST(Class3, R_CON_46_ARepeatedCountIsAnsweredAgainAndNotExecuted) {
    Site site;
    auto peer = registered(site);
    peer.open_class3();
    const auto& row = *site.device.find({0x64, 0});
    EXPECT_EQ(peer.connected_call(7, "10 03 20 64 24 01 30 00 32 00 00 00"), hex("90 00 00 00"));
    EXPECT_EQ(site.device.store().value(row), drive::Value{std::int64_t{50}});
    site.device.store().assign(row, std::int64_t{60});
    EXPECT_EQ(peer.connected_call(7, "10 03 20 64 24 01 30 00 32 00 00 00"), hex("90 00 00 00"));
    EXPECT_EQ(site.device.store().value(row), drive::Value{std::int64_t{60}}) << "the Set ran a second time";
    EXPECT_EQ(peer.connected_call(7, get_s_curve), hex("90 00 00 00")) << "the stored reply, whatever is asked";
    EXPECT_EQ(peer.connected_call(8, get_s_curve), hex("8E 00 00 00 3C 00 00 00"));
    EXPECT_EQ(peer.connected_call(7, get_s_curve), hex("8E 00 00 00 3C 00 00 00")) << "only the previous count repeats";
}

TEST(Class3, R_CON_46_TheFirstRequestMayHaveAnyCount) {
    for (const auto first : std::to_array<std::uint16_t>({0, 1, 0xFFFF})) {
        Site site;
        auto peer = registered(site);
        peer.open_class3();
        EXPECT_EQ(peer.connected_call(first, get_s_curve), s_curve);
    }
}

TEST(Class3, R_CON_46_EachConnectionCountsForItself) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    const auto first = peer.connection();
    peer.open_class3(2);
    EXPECT_EQ(peer.connected_call(first, 1, get_s_curve), s_curve);
    EXPECT_EQ(peer.connected_call(1, "0E 03 20 64 24 01 30 07"), hex("8E 00 00 00 E8 03"));
    EXPECT_EQ(peer.connected_call(first, 1, "0E 03 20 64 24 01 30 07"), s_curve);
}

TEST(Class3, R_ENC_23_TheIdOfAnotherTcpConnectionIsIgnored) {
    Site site;
    auto owner = registered(site);
    owner.open_class3();
    auto stranger = registered(site);
    EXPECT_EQ(stranger.connected_call(owner.connection(), 1, "10 03 20 64 24 01 30 00 32 00 00 00"), "");
    EXPECT_EQ(owner.connected_call(1, get_s_curve), s_curve) << "neither executed nor counted";
}

TEST(Class3, R_CON_19_TheFirstRequestMayTakeTenSeconds) {
    Site site;
    auto peer = registered(site);
    peer.open_class3();  // 250 ms, four times
    site.advance(9s + 999ms);
    EXPECT_EQ(site.adapter.class3_connections(), 1U);
    site.advance(1ms);
    EXPECT_EQ(site.adapter.class3_connections(), 0U);
    EXPECT_EQ(peer.connected_call(1, get_s_curve), "");
    EXPECT_EQ(counter(peer, 8), count(1));
    EXPECT_TRUE(peer.open()) << "the TCP connection stays";
}

TEST(Class3, R_CON_19_OrLongerWhenItsOwnTimeIsLonger) {
    Site site;
    auto peer = registered(site);
    auto open = Peer::class3_open(1);
    open.o_to_t_rpi = 1'000'000;
    open.timeout_multiplier = 2;  // 16
    EXPECT_EQ(peer.call(request(open)).substr(0, 11), "D4 00 00 00");
    site.advance(15s + 999ms);
    EXPECT_EQ(site.adapter.class3_connections(), 1U);
    site.advance(1ms);
    EXPECT_EQ(site.adapter.class3_connections(), 0U);
}

TEST(Class3, R_CON_47_TimesOutAfterItsIntervalTimesItsMultiplier) {
    constexpr std::array multipliers{4, 8, 16, 32, 64, 128, 256, 512};
    for (std::uint8_t code = 0; code < 8; ++code) {
        Site site;
        auto peer = registered(site);
        auto open = Peer::class3_open(1);
        open.o_to_t_rpi = 10'000;
        open.t_to_o_rpi = 999'000;  // not the supervised direction
        open.timeout_multiplier = code;
        const auto reply = octets(peer.call(request(open)));
        cip::Reader id(cip::ByteView(reply).subspan(4));
        const auto connection = id.u32();
        EXPECT_EQ(peer.connected_call(connection, 1, get_s_curve), s_curve);
        const auto timeout = multipliers[code] * 10ms;
        site.advance(timeout - 1ms);
        EXPECT_EQ(peer.connected_call(connection, 1, get_s_curve), s_curve) << "a repeat counts too (R-CON-20)";
        site.advance(timeout - 1ms);
        EXPECT_EQ(site.adapter.class3_connections(), 1U);
        site.advance(1ms);
        EXPECT_EQ(site.adapter.class3_connections(), 0U);
    }
}

TEST(Class3, R_CON_47_ARequestThatComesTooLateRevivesNothing) {
    Site site;
    auto peer = registered(site);
    peer.open_class3();
    site.now += 10s;  // the request is there before the timer has run
    EXPECT_EQ(peer.connected_call(1, get_s_curve), "");
    EXPECT_EQ(site.adapter.class3_connections(), 0U);
}

TEST(Class3, R_CON_47_EndsWithItsTcpConnection) {
    Site site;
    auto peer = registered(site);
    auto other = registered(site);
    peer.open_class3(1);
    peer.open_class3(2);
    other.open_class3(3);
    peer.close();
    EXPECT_EQ(site.adapter.class3_connections(), 1U);
    EXPECT_EQ(other.connected_call(1, get_s_curve), s_curve);
    EXPECT_EQ(counter(other, 8), count(0)) << "that is no timeout";
}

TEST(Class3, R_ENC_24_TrafficCountsAsActivity) {
    Site site;
    auto peer = registered(site);
    auto open = Peer::class3_open(1);
    open.o_to_t_rpi = 60'000'000;
    const auto reply = octets(peer.call(request(open)));
    cip::Reader id(cip::ByteView(reply).subspan(4));
    const auto connection = id.u32();
    for (std::uint16_t i = 0; i < 5; ++i) {
        site.advance(100s);
        EXPECT_EQ(peer.connected_call(connection, i, get_s_curve), s_curve);
    }
    site.advance(120s);
    EXPECT_FALSE(peer.open()) << "and an open connection alone does not";
}

TEST(Class3, R_CM_1_ConnectionsAreOpenedAndClosedUnconnectedOnly) {
    Site site;
    auto peer = registered(site);
    peer.open_class3();
    std::uint16_t sequence = 0;
    const auto open = hex(request(Peer::class3_open(2)));
    EXPECT_EQ(peer.connected_call(++sequence, open), hex("D4 00 08 00"));
    auto large = Peer::class3_open(2);
    large.large = true;
    EXPECT_EQ(peer.connected_call(++sequence, hex(request(large))), hex("DB 00 08 00"));
    EXPECT_EQ(peer.connected_call(++sequence, "4E 02 2006 2401 0A0E 0100 4D00 44332211 02 00 2002 2401"),
              hex("CE 00 08 00"));
    EXPECT_EQ(peer.connected_call(++sequence, "52 02 2006 2401 0A05 0800 0E03 2064 2401 3000 00 00"),
              hex("D2 00 08 00"));
    EXPECT_EQ(site.adapter.class3_connections(), 1U);
    // Hidden in a Multiple_Service_Packet it is still the same.
    const auto close = std::string("4E 02 2006 2401 0A0E 0100 4D00 44332211 00 00");
    EXPECT_EQ(peer.connected_call(++sequence, "0A 02 2002 2401 0100 0400" + close),
              hex("8A 00 1E 00 0100 0400 CE 00 08 00"));
    EXPECT_EQ(peer.connected_call(++sequence, "0E 03 20 06 24 01 30 01"), count(1)) << "reading stays allowed";
}

TEST(Class3, R_CON_47_AReplyThatDoesNotFitTheConnectionIs0x11) {
    Site site;
    auto peer = registered(site);
    auto open = Peer::class3_open(1);
    open.t_to_o.size = 10;
    const auto reply = octets(peer.call(request(open)));
    cip::Reader id(cip::ByteView(reply).subspan(4));
    const auto connection = id.u32();
    EXPECT_EQ(peer.connected_call(connection, 1, get_s_curve), s_curve);
    EXPECT_EQ(peer.connected_call(connection, 2, "0E 03 20 64 24 01 30 08"), hex("8E 00 11 00"));
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 08"), hex("8E 00 00 00 0800 726F746174697665")) << "unconnected it fits";
}

TEST(Class3, AMessageWithoutAServiceIsNotAnswered) {
    Site site;
    auto peer = registered(site);
    peer.open_class3();
    EXPECT_EQ(peer.connected_call(1, ""), "");
    EXPECT_EQ(peer.connected_call(1, "0E"), "");
    EXPECT_EQ(peer.connected_call(1, get_s_curve), s_curve);
}

// R-MSG-5: the same request, the four ways that it can come.
class AllWays : public testing::TestWithParam<const char*> {};
TEST_P(AllWays, R_MSG_5_AnswerAlike) {
    const std::string message = GetParam();
    const auto unconnected = [&] {
        Site site;
        return registered(site).call(message);
    }();
    {
        Site site;
        auto peer = registered(site);
        peer.open_class3();
        EXPECT_EQ(peer.connected_call(1, message), unconnected);
    }
    {
        Site site;
        EXPECT_EQ(registered(site).call("0A 02 2002 2401 0100 0400" + message).substr(4 * 3 + 4 * 3), unconnected);
    }
    for (const auto* route : {"", "01 00"}) {
        Site site;
        cip::UnconnectedSend send;
        send.message = octets(message);
        send.route_path = octets(route);
        EXPECT_EQ(registered(site).call(cip::Request{0x52, cip::Path::to(6, 1), send.encode()}.encode()), unconnected);
    }
}
INSTANTIATE_TEST_SUITE_P(Requests, AllWays,
                         testing::Values("0E 03 20 64 24 01 30 00",              // 20
                                         "0E 02 20 64 24 01",                    // attribute 0 left out
                                         "10 03 20 64 24 01 30 00 32 00 00 00",  // a Set
                                         "10 03 20 64 24 01 30 00 00 00 00 00",  // 0x09
                                         "10 03 20 64 24 01 30 04 00",           // 0x0E
                                         "0E 03 20 65 24 01 30 00",              // 0x2C
                                         "0E 03 20 64 24 01 30 77",              // 0x14
                                         "4B 03 20 64 24 01 30 00",              // 0x08
                                         "0E 03 20 63 24 01 30 00",              // 0x05
                                         "01 02 20 01 24 01",                    // Get_Attributes_All
                                         "03 02 20 01 24 01 02 00 01 00 63 00",  // Get_Attribute_List, one unknown
                                         "0E 03 20 04 24 64 30 03",              // an assembly
                                         "0E 05 20 64 24 01 30 00"));            // 0x26

TEST(UnconnectedSend, R_CM_9_RunsWhatItHoldsWithPadding) {
    Site site;
    auto peer = registered(site);
    // A Set of one octet to 0x65/1/0x1C would be odd; here a Get with one octet behind it.
    EXPECT_EQ(peer.call("52 02 2006 2401 0A05 0900 0E03 2064 2401 3000 FF 00 01 00 0100"), s_curve);
    EXPECT_EQ(peer.call("52 02 2006 2401 0A05 0800 0E03 2064 2401 3000 01 00 0100"), s_curve);
    EXPECT_EQ(peer.call("52 02 2006 2401 0A05 0800 0E03 2064 2401 3000 00 00"), s_curve);
}

TEST(UnconnectedSend, R_CM_9_TheReplyIsTheEmbeddedOneWhateverItsStatus) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call("52 02 2006 2401 0A05 0800 0E03 2064 2401 3077 01 00 0100"), hex("8E 00 14 00"));
}

TEST(UnconnectedSend, R_CM_9_OpensConnections) {
    Site site;
    auto peer = registered(site);
    cip::UnconnectedSend send;
    send.message = request(Peer::class3_open(1));
    send.route_path = octets("01 00");
    EXPECT_EQ(peer.call(cip::Request{0x52, cip::Path::to(6, 1), send.encode()}.encode()).substr(0, 11), "D4 00 00 00");
    EXPECT_EQ(site.adapter.class3_connections(), 1U);
}

struct BadRoute {
    const char* what;
    const char* request;
    const char* reply;
};
void PrintTo(const BadRoute& each, std::ostream* out) { *out << each.what; }
class UnconnectedSendFailure : public testing::TestWithParam<BadRoute> {};
TEST_P(UnconnectedSendFailure, R_CM_10_NamesTheReason) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call(std::string("52 02 2006 2401 ") + GetParam().request), hex(GetParam().reply));
    EXPECT_EQ(site.device.store().value(*site.device.find({0x64, 0})), drive::Value{std::int64_t{20}});
}
INSTANTIATE_TEST_SUITE_P(
    Routes, UnconnectedSendFailure,
    testing::Values(
        BadRoute{"a port that does not exist", "0A05 0C00 1003 2064 2401 3000 32000000 01 00 0300",
                 "D2 00 01 01 1103 01 00"},
        BadRoute{"a slot that is empty", "0A05 0C00 1003 2064 2401 3000 32000000 01 00 0105", "D2 00 01 01 1203 01 00"},
        BadRoute{"another host", "0A05 0C00 1003 2064 2401 3000 32000000 08 00 120D3139322E3136382E312E31303000",
                 "D2 00 01 01 1203 08 00"},
        BadRoute{"two hops", "0A05 0C00 1003 2064 2401 3000 32000000 02 00 0100 0100", "D2 00 01 01 1203 02 00"},
        BadRoute{"no port segment", "0A05 0C00 1003 2064 2401 3000 32000000 01 00 2006", "D2 00 04 00 01 00"},
        BadRoute{"a reserved segment", "0A05 0C00 1003 2064 2401 3000 32000000 01 00 E000", "D2 00 04 00 01 00"},
        BadRoute{"a message longer than the data", "0A05 4000 1003 2064 2401 3000 32000000 01 00 0100",
                 "D2 00 01 01 0502 00 00"},
        BadRoute{"a route longer than the data", "0A05 0C00 1003 2064 2401 3000 32000000 02 00 0100",
                 "D2 00 01 01 0502 00 00"},
        BadRoute{"something behind the route", "0A05 0C00 1003 2064 2401 3000 32000000 01 00 0100 00",
                 "D2 00 01 01 0502 00 00"},
        BadRoute{"nothing", "", "D2 00 01 01 0502 00 00"},
        BadRoute{"an empty message", "0A05 0000 01 00 0100", "D2 00 01 01 0502 01 00"},
        BadRoute{"a message of one octet", "0A05 0100 0E 00 01 00 0100", "D2 00 01 01 0502 01 00"}));

TEST(UnconnectedSend, R_CM_9_HoldsNoOther) {
    Site site;
    EXPECT_EQ(
        registered(site).call("52 02 2006 2401 0A05 1400 5202 2006 2401 0A05 0800 0E03 2064 2401 3000 00 00 00 00"),
        hex("D2 00 08 00"));
}

TEST(ConnectionManager, R_CM_1_OffersNothingElse) {
    Site site;
    auto peer = registered(site);
    for (const unsigned service : {0x01, 0x02, 0x03, 0x04, 0x05, 0x4B, 0x53, 0x55}) {
        EXPECT_EQ(peer.call(fmt::format("{:02X} 02 20 06 24 01", service)),
                  hex(fmt::format("{:02X} 00 08 00", service | 0x80)));
    }
    EXPECT_EQ(peer.call("54 02 20 06 24 02"), hex("D4 00 05 00"));
    EXPECT_EQ(peer.call("54 02 20 06 24 00"), hex("D4 00 08 00"));
}

TEST(ConnectionManager, R_CM_2_CountersAreClearedAndNotSet) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    EXPECT_EQ(counter(peer, 1), count(1));
    EXPECT_EQ(peer.call("10 03 20 06 24 01 30 01 01 00"), hex("90 00 09 00"));
    EXPECT_EQ(peer.call("10 03 20 06 24 01 30 01 00"), hex("90 00 13 00"));
    EXPECT_EQ(peer.call("10 03 20 06 24 01 30 01 00 00 00"), hex("90 00 15 00"));
    EXPECT_EQ(counter(peer, 1), count(1));
    EXPECT_EQ(peer.call("10 03 20 06 24 01 30 01 00 00"), hex("90 00 00 00"));
    EXPECT_EQ(counter(peer, 1), count(0));
    for (unsigned attribute = 1; attribute <= 8; ++attribute) EXPECT_EQ(counter(peer, attribute), count(0));
    EXPECT_EQ(counter(peer, 0), hex("8E 00 14 00"));
    EXPECT_EQ(counter(peer, 10), hex("8E 00 14 00"));
}

}  // namespace
}  // namespace servobus::test
