// The encapsulation layer of the target, hex in and hex out (R-ENC, R-CPF).
#include <gtest/gtest.h>

#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

constexpr std::string_view nop = "00 00";
constexpr std::string_view list_services = "04 00";
constexpr std::string_view list_identity = "63 00";
constexpr std::string_view list_interfaces = "64 00";
constexpr std::string_view register_session = "65 00";
constexpr std::string_view unregister_session = "66 00";
constexpr std::string_view send_rr_data = "6F 00";
constexpr std::string_view send_unit_data = "70 00";

constexpr std::string_view unsupported_command = "01 00 00 00";
constexpr std::string_view incorrect_data = "03 00 00 00";
constexpr std::string_view invalid_session = "64 00 00 00";
constexpr std::string_view invalid_length = "65 00 00 00";
constexpr std::string_view unsupported_protocol = "69 00 00 00";

// Interface handle 0, timeout 0, two items: null address, and an unconnected Get of 0x64/1/0.
const std::string get_s_curve = "00000000 0000 0200 0000 0000 B200 0800 0E03 2064 2401 3000";
const std::string s_curve = "00000000 0000 0200 0000 0000 B200 0800 8E00 0000 14000000";

const std::string services_item = "0100 0001 1400 0100 2001 436F6D6D756E69636174696F6E730000";
// Version 1; family 2, port 44818, 192.168.2.100; vendor 1389, type 43, product 0x7509, 1.1; no I/O; serial; name; state.
const std::string identity_item =
    "0100 0C00 3100 0100 0002 AF12 C0A80264 0000000000000000 6D05 2B00 0975 0101 3000 C3B2A100 "
    "0F 58454E4158205876692037355638 53 03";

TEST(Encapsulation, R_ENC_2_AnswersListServicesOctetByOctet) {
    Site site;
    Peer peer(site);
    EXPECT_EQ(peer.send("0400 0000 00000000 00000000 0102030405060708 00000000"),
              hex("0400 1A00 00000000 00000000 0102030405060708 00000000"
                  "0100 0001 1400 0100 2001 436F6D6D756E69636174696F6E730000"));
}

TEST(Encapsulation, R_ENC_3_TakesOneOctetAtATime) {
    Site site;
    auto peer = registered(site);
    std::string replies;
    const auto request = octets(peer.text(frame(send_rr_data, own_session, get_s_curve)));
    for (std::size_t i = 0; i < request.size(); ++i) {
        const auto reply = peer.exchange(cip::ByteView(request).subspan(i, 1));
        EXPECT_EQ(reply.empty(), i + 1 < request.size()) << "octet " << i;
        replies += hex(reply);
    }
    EXPECT_EQ(replies, peer.text(frame(send_rr_data, own_session, s_curve)));
}

TEST(Encapsulation, R_ENC_3_AnswersSixteenRequestsOfOneSegmentInOrder) {
    Site site;
    auto peer = registered(site);
    cip::Bytes requests;
    cip::Bytes expected;
    for (unsigned i = 0; i < 16; ++i) {
        auto request = *enip::Frame::parse(octets(peer.text(frame(send_rr_data, own_session, get_s_curve))));
        request.context[0] = static_cast<std::uint8_t>(i);
        request.write(requests);
        request.reply(enip::EncapsulationStatus::success, octets(s_curve)).write(expected);
    }
    EXPECT_EQ(site.adapter.on_octets(peer.id(), requests, site.now), requests.size());
    EXPECT_EQ(hex(site.adapter.take_replies(peer.id())), hex(expected)) << "one buffer, so that one write sends it";
    EXPECT_TRUE(site.adapter.take_replies(peer.id()).empty());
}

TEST(Encapsulation, R_ENC_3_PassesOverAMessageThatIsTooLongAndKeepsItsPlace) {
    Site site;
    auto peer = registered(site);
    for (const std::size_t length : {enip::max_data_bytes + 1, enip::max_stated_length, std::size_t{0xFFFF}}) {
        auto request = octets(peer.text(frame(send_rr_data, own_session)));
        request[2] = static_cast<std::uint8_t>(length);
        request[3] = static_cast<std::uint8_t>(length >> 8);
        request.resize(request.size() + length, 0xEE);
        EXPECT_EQ(hex(peer.exchange(request)), peer.text(failure(send_rr_data, own_session, invalid_length)));
        EXPECT_EQ(peer.send(frame(send_rr_data, own_session, get_s_curve)),
                  peer.text(frame(send_rr_data, own_session, s_curve)));
    }
}

TEST(Encapsulation, R_ENC_3_TakesTheLongestMessageThatItHolds) {
    Site site;
    auto peer = registered(site);
    auto request = octets(peer.text(frame(send_rr_data, own_session, get_s_curve)));
    // The unconnected item grows with octets behind the request, which a Get does not look at (R-MSG-10).
    const std::size_t missing = enip::header_bytes + enip::max_data_bytes - request.size();
    request.resize(enip::header_bytes + enip::max_data_bytes);
    request[2] = enip::max_data_bytes & 0xFF;
    request[3] = enip::max_data_bytes >> 8;
    const auto item = 8 + missing;
    request[enip::header_bytes + 14] = static_cast<std::uint8_t>(item);
    request[enip::header_bytes + 15] = static_cast<std::uint8_t>(item >> 8);
    EXPECT_EQ(hex(peer.exchange(request)), peer.text(frame(send_rr_data, own_session, s_curve)));
}

TEST(Encapsulation, R_ENC_3_AnAnnouncedLengthThatNeverComesAnswersNothing) {
    Site site;
    auto peer = registered(site);
    auto head = octets(peer.text(frame(send_rr_data, own_session)));
    head[2] = 0xE7;
    head[3] = 0xFF;  // 65511
    EXPECT_TRUE(peer.exchange(head).empty());
    const cip::Bytes octet{0};
    for (int i = 0; i < 60'000; ++i) ASSERT_TRUE(peer.exchange(octet).empty());
    EXPECT_TRUE(peer.open());
    site.advance(120s);
    EXPECT_FALSE(peer.open()) << "what is not complete does not count as activity";
}

class UnknownCommand : public testing::TestWithParam<std::string_view> {};
TEST_P(UnknownCommand, R_ENC_6_IsAnsweredAndItsDataSkipped) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.send(frame(GetParam(), own_session, "DE AD BE EF")),
              peer.text(failure(GetParam(), own_session, unsupported_command)));
    EXPECT_EQ(peer.send(frame(list_interfaces)), hex(frame(list_interfaces, no_session, "0000")));
}
INSTANTIATE_TEST_SUITE_P(R_ENC_5, UnknownCommand,
                         testing::Values("01 00", "05 00", "62 00", "67 00", "6E 00", "71 00", "72 00", "73 00",
                                         "C8 00", "63 01", "FF FF"));

TEST(Encapsulation, R_ENC_7_DiscardsARequestWithOptions) {
    Site site;
    auto peer = registered(site);
    for (const auto command : {list_services, list_identity, list_interfaces}) {
        EXPECT_EQ(peer.send(FrameText{.command = command, .options = "01 00 00 00"}.text()), "");
    }
    EXPECT_EQ(peer.send(FrameText{
                  .command = send_rr_data, .session = own_session, .data = get_s_curve, .options = "00 00 00 80"}
                            .text()),
              "");
    EXPECT_EQ(
        peer.send(FrameText{.command = unregister_session, .session = own_session, .options = "01 00 00 00"}.text()),
        "");
    EXPECT_EQ(peer.send(FrameText{.command = "72 00", .options = "01 00 00 00"}.text()), "");
    EXPECT_TRUE(peer.open());
    EXPECT_EQ(site.adapter.sessions(), 1U);
}

TEST(Encapsulation, R_ENC_7_AnswersARegisterSessionWithOptions) {
    Site site;
    Peer peer(site);
    EXPECT_EQ(peer.send(FrameText{.command = register_session, .data = "01 00 00 00", .options = "01 00 00 00"}.text()),
              hex(failure(register_session, no_session, unsupported_protocol)));
    EXPECT_EQ(site.adapter.sessions(), 0U);
    EXPECT_TRUE(peer.open());
}

TEST(Encapsulation, R_ENC_8_IgnoresARequestWithAStatus) {
    Site site;
    auto peer = registered(site);
    for (const auto command :
         {nop, list_services, list_identity, list_interfaces, unregister_session, std::string_view("72 00")}) {
        EXPECT_EQ(peer.send(FrameText{.command = command, .session = own_session, .status = "01 00 00 00"}.text()), "");
    }
    EXPECT_EQ(peer.send(FrameText{.command = register_session, .data = "01 00 00 00", .status = "01 00 00 00"}.text()),
              "");
    EXPECT_EQ(peer.send(FrameText{
                  .command = send_rr_data, .session = own_session, .data = get_s_curve, .status = "64 00 00 00"}
                            .text()),
              "");
    EXPECT_TRUE(peer.open());
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
}

TEST(Encapsulation, R_ENC_10_NeverAnswersANop) {
    Site site;
    Peer peer(site);
    EXPECT_EQ(peer.send(frame(nop)), "");
    EXPECT_EQ(peer.send(frame(nop, no_session, "01 02 03 04 05")), "");
    auto longest = octets(frame(nop));
    longest[2] = 0xE7;
    longest[3] = 0xFF;
    longest.resize(longest.size() + enip::max_stated_length);
    EXPECT_TRUE(peer.exchange(longest).empty());
    EXPECT_EQ(peer.send(frame(list_interfaces)), hex(frame(list_interfaces, no_session, "0000")));
}

TEST(Encapsulation, R_ENC_11_ListRequestsHoldNothing) {
    Site site;
    Peer peer(site);
    for (const auto command : {list_services, list_identity, list_interfaces}) {
        EXPECT_EQ(peer.send(frame(command, no_session, "00")), hex(failure(command, no_session, invalid_length)));
    }
}

TEST(Encapsulation, R_ENC_11_RegisterSessionHoldsFourOctets) {
    Site site;
    Peer peer(site);
    for (const auto* data : {"", "01 00", "01 00 00", "01 00 00 00 00"}) {
        EXPECT_EQ(peer.send(frame(register_session, no_session, data)),
                  hex(failure(register_session, no_session, invalid_length)));
    }
    EXPECT_EQ(site.adapter.sessions(), 0U);
}

TEST(Encapsulation, R_ENC_11_SendDataHoldsSixteenOctetsAtLeast) {
    Site site;
    auto peer = registered(site);
    for (const auto command : {send_rr_data, send_unit_data}) {
        EXPECT_EQ(peer.send(frame(command, own_session, "00000000 0000 0200 0000 0000 B200 00")),
                  peer.text(failure(command, own_session, invalid_length)));
        EXPECT_EQ(peer.send(frame(command, own_session)), peer.text(failure(command, own_session, invalid_length)));
    }
}

TEST(Encapsulation, R_ENC_12_SaysWhatItServes) {
    Site site;
    Peer peer(site);
    EXPECT_EQ(peer.send(frame(list_services)), hex(frame(list_services, no_session, services_item)));
}

TEST(Encapsulation, R_ENC_13_SaysWhoItIsWithoutASessionAndCopiesTheHandle) {
    Site site;
    Peer peer(site);
    EXPECT_EQ(peer.send(frame(list_identity)), hex(frame(list_identity, no_session, identity_item)));
    EXPECT_EQ(peer.send(frame(list_identity, "78 56 34 12")), hex(frame(list_identity, "78 56 34 12", identity_item)));
}

TEST(Encapsulation, R_ENC_16_HasNoOtherInterfaces) {
    Site site;
    Peer peer(site);
    EXPECT_EQ(peer.send(frame(list_interfaces)), hex(frame(list_interfaces, no_session, "0000")));
}

TEST(Encapsulation, R_ENC_17_RegistersOneSessionPerConnection) {
    Site site;
    Peer first(site);
    Peer second(site);
    first.register_session();
    second.register_session();
    EXPECT_NE(first.session(), 0U);
    EXPECT_NE(second.session(), 0U);
    EXPECT_NE(first.session(), second.session());
    EXPECT_EQ(site.adapter.sessions(), 2U);
}

TEST(Encapsulation, R_ENC_17_EchoesTheRegistration) {
    Site site;
    Peer peer(site);
    const auto reply = peer.send(frame(register_session, no_session, "01 00 00 00"));
    const auto parsed = enip::Frame::parse(octets(reply));
    ASSERT_TRUE(parsed);
    EXPECT_NE(parsed->session, 0U);
    auto expected = *enip::Frame::parse(octets(frame(register_session, no_session, "01 00 00 00")));
    expected.session = parsed->session;
    EXPECT_EQ(reply, hex(expected.encode()));
}

TEST(Encapsulation, R_ENC_17_HandlesFollowTheSeed) {
    const auto handle_of = [](std::uint64_t seed) {
        Site site({}, drive::Device(drive::xenax_models().front()), seed);
        return registered(site).session();
    };
    EXPECT_EQ(handle_of(1), handle_of(1));
    EXPECT_NE(handle_of(1), handle_of(2));
}

TEST(Encapsulation, R_ENC_18_RefusesAnotherVersionAndSaysItsOwn) {
    Site site;
    Peer peer(site);
    for (const auto* data : {"02 00 00 00", "00 00 00 00", "01 00 01 00", "FF FF FF FF"}) {
        EXPECT_EQ(
            peer.send(FrameText{.command = register_session, .session = "09 08 07 06", .data = data}.text()),
            hex(FrameText{.command = register_session, .data = "01 00 00 00", .status = unsupported_protocol}.text()));
    }
    EXPECT_EQ(site.adapter.sessions(), 0U);
    EXPECT_TRUE(peer.open());
    peer.register_session();
    EXPECT_EQ(site.adapter.sessions(), 1U);
}

TEST(Encapsulation, R_ENC_19_ASecondRegistrationIsRefusedWithTheExistingHandle) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(
        peer.send(frame(register_session, no_session, "01 00 00 00")),
        peer.text(FrameText{
            .command = register_session, .session = own_session, .data = "01 00 00 00", .status = unsupported_command}
                      .text()));
    EXPECT_EQ(site.adapter.sessions(), 1U);
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
}

TEST(Encapsulation, R_ENC_20_UnRegisterSessionClosesWithoutAReply) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.send(frame(unregister_session, own_session)), "");
    EXPECT_FALSE(peer.open());
    peer.close();
    EXPECT_EQ(site.adapter.sessions(), 0U);
    EXPECT_EQ(site.adapter.tcp_connections(), 0U);
}

TEST(Encapsulation, R_ENC_20_WhatFollowsAnUnRegisterSessionIsNotExecuted) {
    Site site;
    auto peer = registered(site);
    // Set of 0x64/1/0 to 50 in the same segment.
    const std::string set = "00000000 0000 0200 0000 0000 B200 0C00 1003 2064 2401 3000 32000000";
    const auto requests = frame(send_rr_data, own_session, get_s_curve) + frame(unregister_session, own_session) +
                          frame(send_rr_data, own_session, set);
    EXPECT_EQ(peer.send(requests), peer.text(frame(send_rr_data, own_session, s_curve)));
    EXPECT_FALSE(peer.open());
    EXPECT_EQ(site.device.store().value(*site.device.find({0x64, 0})), drive::Value{std::int64_t{20}});
}

TEST(Encapsulation, R_ENC_20_UnRegisterSessionWithAnUnknownHandleIsAnswered) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.send(frame(unregister_session, no_session)),
              hex(failure(unregister_session, no_session, invalid_session)));
    EXPECT_EQ(peer.send(frame(unregister_session, "01 02 03 04")),
              hex(failure(unregister_session, "01 02 03 04", invalid_session)));
    EXPECT_TRUE(peer.open());
    Peer other(site);
    EXPECT_EQ(hex(other.exchange(octets(peer.text(frame(unregister_session, own_session))))),
              peer.text(failure(unregister_session, own_session, invalid_session)));
    EXPECT_TRUE(peer.open());
    EXPECT_EQ(site.adapter.sessions(), 1U);
}

TEST(Encapsulation, R_ENC_20_UnRegisterSessionWithDataIsHonoured) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.send(frame(unregister_session, own_session, "00 00")), "");
    EXPECT_FALSE(peer.open());
}

TEST(Encapsulation, R_ENC_21_RefusesAHandleOfAnotherConnection) {
    Site site;
    auto owner = registered(site);
    auto stranger = registered(site);
    owner.open_class3();
    const auto connected =
        hex(enip::SendData::connected(owner.connection(), 1, octets("0E 03 20 64 24 01 30 00")).encode());
    for (const auto& [command, data] : {std::pair(send_rr_data, get_s_curve), std::pair(send_unit_data, connected)}) {
        const auto request = octets(owner.text(frame(command, own_session, data)));
        EXPECT_EQ(hex(stranger.exchange(request)), owner.text(failure(command, own_session, invalid_session)));
    }
    Peer unregistered(site);
    EXPECT_EQ(hex(unregistered.exchange(octets(owner.text(frame(send_rr_data, own_session, get_s_curve))))),
              owner.text(failure(send_rr_data, own_session, invalid_session)));
    EXPECT_EQ(unregistered.send(frame(send_rr_data, no_session, get_s_curve)),
              hex(failure(send_rr_data, no_session, invalid_session)));
}

TEST(Encapsulation, R_ENC_21_AHandleEndsWithItsConnection) {
    Site site;
    auto peer = registered(site);
    const auto request = octets(peer.text(frame(send_rr_data, own_session, get_s_curve)));
    const auto refusal = peer.text(failure(send_rr_data, own_session, invalid_session));
    peer.close();
    Peer next(site);
    EXPECT_EQ(hex(next.exchange(request)), refusal);
}

TEST(Encapsulation, R_ENC_22_IgnoresTheTimeout) {
    Site site;
    auto peer = registered(site);
    auto data = octets(get_s_curve);
    data[4] = 0x0A;
    EXPECT_EQ(peer.send(frame(send_rr_data, own_session, hex(data))),
              peer.text(frame(send_rr_data, own_session, s_curve)));
}

TEST(Encapsulation, R_CPF_10_IgnoresItemsBehindTheData) {
    Site site;
    auto peer = registered(site);
    auto data = octets(get_s_curve + " 0180 1000 0002 08AE 00000000 0000000000000000");
    data[6] = 3;
    EXPECT_EQ(peer.send(frame(send_rr_data, own_session, hex(data))),
              peer.text(frame(send_rr_data, own_session, s_curve)));
}

struct Malformed {
    const char* what;
    const char* data;
};
void PrintTo(const Malformed& each, std::ostream* out) { *out << each.what; }

class MalformedRequest : public testing::TestWithParam<Malformed> {};
TEST_P(MalformedRequest, R_CPF_2_IsMalformedData) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.send(frame(send_rr_data, own_session, GetParam().data)),
              peer.text(failure(send_rr_data, own_session, incorrect_data)));
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
}
INSTANTIATE_TEST_SUITE_P(
    SendRRData, MalformedRequest,
    testing::Values(
        Malformed{"no item", "00000000 0000 0000 0000 0000 B200 0800 0E03 2064 2401 3000"},
        Malformed{"one item", "00000000 0000 0100 B200 0800 0E03 2064 2401 3000"},
        Malformed{"one item and the rest behind it", "00000000 0000 0100 0000 0000 B200 0800 0E03 2064 2401 3000"},
        Malformed{"items turned round", "00000000 0000 0200 B200 0800 0E03 2064 2401 3000 0000 0000"},
        Malformed{"null item with data", "00000000 0000 0200 0000 0200 0000 B200 0800 0E03 2064 2401 3000"},
        Malformed{"connected data", "00000000 0000 0200 0000 0000 B100 0800 0E03 2064 2401 3000"},
        Malformed{"connected address", "00000000 0000 0200 A100 0400 01000000 B200 0800 0E03 2064 2401 3000"},
        Malformed{"item longer than the message", "00000000 0000 0200 0000 0000 B200 0900 0E03 2064 2401 3000"},
        Malformed{"item shorter than the message", "00000000 0000 0200 0000 0000 B200 0700 0E03 2064 2401 3000"},
        Malformed{"announced item missing", "00000000 0000 0300 0000 0000 B200 0800 0E03 2064 2401 3000"},
        Malformed{"seventeen items announced", "00000000 0000 1100 0000 0000 B200 0800 0E03 2064 2401 3000"},
        Malformed{"interface handle 1", "01000000 0000 0200 0000 0000 B200 0800 0E03 2064 2401 3000"},
        Malformed{"no message", "00000000 0000 0200 0000 0000 B200 0000"},
        Malformed{"message of one octet", "00000000 0000 0200 0000 0000 B200 0100 0E"}));

class MalformedConnectedRequest : public testing::TestWithParam<Malformed> {};
TEST_P(MalformedConnectedRequest, R_CPF_2_IsMalformedData) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.send(frame(send_unit_data, own_session, GetParam().data)),
              peer.text(failure(send_unit_data, own_session, incorrect_data)));
}
INSTANTIATE_TEST_SUITE_P(
    SendUnitData, MalformedConnectedRequest,
    testing::Values(
        Malformed{"null address", "00000000 0000 0200 0000 0000 B100 0A00 0100 0E03 2064 2401 3000"},
        Malformed{"unconnected data", "00000000 0000 0200 A100 0400 01000000 B200 0A00 0100 0E03 2064 2401 3000"},
        Malformed{"address of two octets", "00000000 0000 0200 A100 0200 0100 B100 0A00 0100 0E03 2064 2401 3000"},
        Malformed{"no sequence count", "00000000 0000 0200 A100 0400 01000000 B100 0100 01"},
        Malformed{"interface handle 1", "01000000 0000 0200 A100 0400 01000000 B100 0A00 0100 0E03 2064 2401 3000"}));

TEST(Encapsulation, R_ENC_23_DiscardsAnUnknownConnectionId) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.send(frame(send_unit_data, own_session,
                              "00000000 0000 0200 A100 0400 78563412 B100 0A00 0100 0E03 2064 2401 3000")),
              "");
    EXPECT_TRUE(peer.open());
}

TEST(Encapsulation, R_ENC_24_ClosesAConnectionWithoutMessages) {
    Site site;
    Peer silent(site);
    auto talking = registered(site);
    site.advance(60s);
    EXPECT_EQ(talking.send(frame(nop)), "");
    site.advance(59s + 999ms);
    EXPECT_TRUE(silent.open());
    site.advance(1ms);
    EXPECT_FALSE(silent.open());
    EXPECT_EQ(site.expired, std::vector{silent.id()});
    EXPECT_TRUE(talking.open());
    site.advance(60s);
    EXPECT_FALSE(talking.open());
    talking.close();
    EXPECT_EQ(site.adapter.sessions(), 0U);
}

TEST(Encapsulation, R_ENC_24_EveryCompleteMessageCountsEvenARefusedOne) {
    Site site;
    Peer peer(site);
    for (const auto& message : {frame("72 00"), frame(nop), frame(send_rr_data),
                                FrameText{.command = list_services, .options = "01 00 00 00"}.text(),
                                FrameText{.command = list_services, .status = "01 00 00 00"}.text()}) {
        site.advance(119s);
        peer.send(message);
        EXPECT_TRUE(peer.open());
    }
    site.advance(120s);
    EXPECT_FALSE(peer.open());
}

TEST(Encapsulation, R_ENC_24_AnOctetASecondIsNoMessage) {
    Site site;
    Peer peer(site);
    auto request = octets(frame(register_session, no_session, std::string(300, '0')));
    int seconds = 0;
    for (; peer.open() && seconds < 200; ++seconds) {
        peer.exchange(cip::ByteView(request).subspan(static_cast<std::size_t>(seconds) % request.size(), 1));
        site.advance(1s);
    }
    EXPECT_EQ(seconds, 120);
}

TEST(Encapsulation, R_ENC_24_ZeroMeansNever) {
    adapter::Limits limits;
    limits.inactivity = 0s;
    Site site(limits);
    Peer peer(site);
    EXPECT_EQ(site.adapter.next_deadline(), std::nullopt);
    site.advance(24h);
    EXPECT_TRUE(peer.open());
}

TEST(Encapsulation, R_ENC_24_AClientChangesTheTimeWithAttribute13) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call("10 03 20 F5 24 01 30 0D 05 00"), hex("90 00 00 00"));
    site.advance(4s + 999ms);
    EXPECT_TRUE(peer.open());
    site.advance(1ms);
    EXPECT_FALSE(peer.open());
}

TEST(Encapsulation, R_ENC_25_ALostConnectionTakesItsSessionAndItsHalfMessageWithIt) {
    Site site;
    auto peer = registered(site);
    const auto request = octets(peer.text(frame(send_rr_data, own_session, get_s_curve)));
    EXPECT_TRUE(peer.exchange(cip::ByteView(request).first(30)).empty());
    const auto id = peer.id();
    peer.close();
    EXPECT_EQ(site.adapter.sessions(), 0U);
    EXPECT_EQ(site.adapter.tcp_connections(), 0U);
    // Octets that were still on their way find nobody.
    EXPECT_EQ(site.adapter.on_octets(id, cip::ByteView(request).subspan(30), site.now), request.size() - 30);
    EXPECT_TRUE(site.adapter.take_replies(id).empty());
    EXPECT_TRUE(site.adapter.wants_close(id));
}

TEST(Encapsulation, R_ENC_27_AReplyOfFourThousandOctetsFitsAndALongerOneIs0x11) {
    Site site;
    auto peer = registered(site);
    // Get_Attribute_List of 0x64: 8 octets for each attribute 0.
    const auto ask = [&](std::size_t count) {
        cip::Bytes request = octets("03 02 20 64 24 01");
        cip::Writer writer(request);
        writer.u16(static_cast<std::uint16_t>(count));
        writer.zeros(2 * count);
        return octets(peer.call(request));
    };
    const auto fits = (cip::max_message_bytes - 6) / 8;
    EXPECT_EQ(ask(fits).size(), 6 + 8 * fits);
    EXPECT_EQ(ask(fits)[2], 0x00);
    EXPECT_EQ(ask(fits + 1)[2], 0x11);
    EXPECT_LE(ask(fits + 1).size(), cip::max_message_bytes);
}

TEST(Encapsulation, EveryFrameCutAnywhereIsAnsweredOnceItIsComplete) {
    Site site;
    auto peer = registered(site);
    const auto whole = octets(peer.text(frame(send_rr_data, own_session, get_s_curve)));
    for (std::size_t cut = 1; cut < whole.size(); ++cut) {
        EXPECT_TRUE(peer.exchange(cip::ByteView(whole).first(cut)).empty());
        EXPECT_EQ(hex(peer.exchange(cip::ByteView(whole).subspan(cut))),
                  peer.text(frame(send_rr_data, own_session, s_curve)));
    }
}

TEST(Encapsulation, TwoFramesInThreePieces) {
    Site site;
    auto peer = registered(site);
    const auto both = octets(peer.text(frame(send_rr_data, own_session, get_s_curve) + frame(list_interfaces)));
    EXPECT_TRUE(peer.exchange(cip::ByteView(both).first(10)).empty());
    EXPECT_EQ(hex(peer.exchange(cip::ByteView(both).subspan(10, 50))),
              peer.text(frame(send_rr_data, own_session, s_curve)));
    EXPECT_EQ(hex(peer.exchange(cip::ByteView(both).subspan(60))), hex(frame(list_interfaces, no_session, "0000")));
}

TEST(Encapsulation, TheSameInputGivesTheSameOctets) {
    const auto run = [] {
        Site site;
        auto peer = registered(site);
        peer.open_class3();
        return peer.send(frame(send_rr_data, own_session, get_s_curve)) +
               peer.connected_call(1, "0E 03 20 64 24 01 30 00") + std::to_string(peer.connection());
    };
    EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace servobus::test
