// The kinds of defect that have hit other EtherNet/IP stacks, clients and dissectors, each as octets in and octets out. What is
// named beside a row is where the kind was found; the octets are our own, and the answers are those of the reference. What a
// peer does to the server's sockets (crowds, slow ones, deaf ones) is in tests/adapter/hostile_peers_test.cpp.
#include <gtest/gtest.h>

#include <array>
#include <sstream>

#include "assemblies/connection.hpp"
#include "cip/services.hpp"
#include "enip/common_packet.hpp"
#include "enip/frame_decoder.hpp"
#include "scanner/capture_file.hpp"
#include "scanner/class3.hpp"
#include "scanner/file_upload.hpp"
#include "scanner/identity.hpp"
#include "scanner/io_plan.hpp"
#include "scanner/io_reply.hpp"
#include "scanner/multiple_service.hpp"
#include "tests/support/adapter_harness.hpp"
#include "tests/support/octets.hpp"

namespace servobus::fuzz {
namespace {

using enip::EncapsulationStatus;
using test::AdapterHarness;
using test::hex;
using test::octets;

const std::string get_vendor = "0E 03 20 01 24 01 30 01";
const std::string vendor = "8E 00 00 00 6D 05";

/// A request of the message router and its reply.
struct Row {
    const char* name;
    const char* request;
    const char* reply;
};
void PrintTo(const Row& row, std::ostream* out) { *out << row.request; }

class Message : public testing::TestWithParam<Row> {};

TEST_P(Message, HasItsAnswerAndTheNextOneToo) {
    AdapterHarness t;
    t.register_session();
    EXPECT_EQ(t.call(GetParam().request), hex(GetParam().reply));
    EXPECT_EQ(t.call(get_vendor), vendor);
}

const auto name_of = [](const auto& each) { return std::string(each.param.name); };

// Counts that are larger or smaller than what is there. OpENer CVE-2020-13556 and issue 567 (Get_Attribute_List), 586 (a string
// shorter than its length); R-MSG-14, R-MSG-15, R-TYP-9.
// clang-format off
INSTANTIATE_TEST_SUITE_P(Regression, Message, testing::ValuesIn(std::to_array<Row>({
    {"GetAttributeListCountsMoreThanItCarries", "03 02 20 01 24 01  FFFF 0100", "83 00 13 00"},
    {"GetAttributeListCountsOneMore", "03 02 20 01 24 01  0300 0100 0200", "83 00 13 00"},
    {"GetAttributeListCountsLess", "03 02 20 01 24 01  0100 0100 0200", "83 00 15 00"},
    {"GetAttributeListWithoutACount", "03 02 20 01 24 01", "83 00 13 00"},
    {"GetAttributeListWithHalfACount", "03 02 20 01 24 01  01", "83 00 13 00"},
    {"GetAttributeListWithHalfAnAttribute", "03 02 20 01 24 01  0100 01", "83 00 13 00"},
    {"GetAttributeListOfNothing", "03 02 20 01 24 01  0000", "83 00 00 00 0000"},
    {"GetAttributeListOfUnknownAttributes", "03 02 20 01 24 01  0200 FFFF 0180", "83 00 0A 00 0200 FFFF 1400 0180 1400"},
    {"SetAttributeListCountsMoreThanItCarries", "04 02 20 64 24 01  FFFF 0000 32000000", "84 00 13 00"},
    {"SetAttributeListCountsOneMore", "04 02 20 64 24 01  0200 0000 32000000", "84 00 0A 00 0200 0000 0000 0000 1C00"},
    {"SetAttributeListCountsLess", "04 02 20 64 24 01  0100 0000 32000000 00", "84 00 15 00"},
    {"SetAttributeListWithoutACount", "04 02 20 64 24 01", "84 00 13 00"},
    {"SetAttributeListWithoutItsValue", "04 02 20 64 24 01  0100 0000", "84 00 13 00"},
    {"SetAttributeListWithHalfAValue", "04 02 20 64 24 01  0100 0000 3200", "84 00 0A 00 0100 0000 1300"},
    {"SetAttributeListWithHalfAString", "04 02 20 69 24 01  0100 0200 FF 41", "84 00 0A 00 0100 0200 1300"},
    {"SetStringIsShorterThanItsLength", "10 03 20 F5 24 01 30 06  FFFF 41", "90 00 13 00"},
    {"SetStringIsNotTerminated", "10 03 20 F5 24 01 30 06  0200 4142", "90 00 00 00"},
}) ), name_of);

// Paths that end behind the message, and segments that end behind the path. OpENer CVE-2021-27482, issues 557 and 564; its
// reachable assertions CVE-2021-27498 and CVE-2021-27500 on segments that it did not expect; R-ERR-1, R-ERR-2, R-PTH-1 to -12.
INSTANTIATE_TEST_SUITE_P(RegressionOfPaths, Message, testing::ValuesIn(std::to_array<Row>({
    {"PathHasMoreWordsThanTheMessage", "0E FF 20 01 24 01 30 01", "8E 00 26 00"},
    {"PathHasOneWordMoreThanTheMessage", "0E 04 20 01 24 01 30 01", "8E 00 26 00"},
    {"PathIsNotThere", "0E 03", "8E 00 26 00"},
    {"PathIsEmpty", "0E 00", "8E 00 05 00"},
    {"LogicalSegmentOf16BitsIsCut", "0E 01 21 00", "8E 00 04 00"},
    {"LogicalSegmentOf32BitsIsCut", "0E 02 22 00 01 00", "8E 00 04 00"},
    {"LogicalFormatIsReserved", "0E 01 23 01", "8E 00 04 00"},
    {"ElectronicKeyIsCut", "0E 02 34 04 6D 05", "8E 00 04 00"},
    {"ElectronicKeyHasAnotherFormat", "0E 05 34 FF 6D 05 2B 00 75 09 01 01", "8E 00 04 00"},
    {"PortSegmentIsCut", "0E 01 1F 00", "8E 00 04 00"},
    {"LinkAddressIsLongerThanThePath", "0E 01 11 FF", "8E 00 04 00"},
    {"SymbolIsLongerThanThePath", "0E 01 91 FF", "8E 00 04 00"},
    {"ShortSymbolIsLongerThanThePath", "0E 01 7F 41", "8E 00 04 00"},
    {"NetworkSegmentIsLongerThanThePath", "0E 01 51 FF", "8E 00 04 00"},
    {"SimpleDataSegmentIsLongerThanThePath", "0E 01 80 FF", "8E 00 04 00"},
    {"SimpleDataSegmentInARequest", "0E 04 20 01 24 01 80 01 00 00", "8E 00 04 00"},
    {"ConstructedTypeSegment", "0E 01 A0 00", "8E 00 04 00"},
    {"ElementaryTypeSegment", "0E 01 C1 00", "8E 00 04 00"},
    {"ReservedSegmentType", "0E 01 E0 00", "8E 00 04 00"},
    {"SpecialLogicalType", "0E 03 20 01 24 01 35 00", "8E 00 04 00"},
    {"ServiceIdSegment", "0E 03 20 01 24 01 38 01", "8E 00 04 00"},
    {"ClassTwice", "0E 03 20 01 20 01 24 01", "8E 00 04 00"},
    {"AttributeBeforeClass", "0E 02 30 01 20 01", "8E 00 04 00"},
    {"ClassOf32BitsThatNobodyHas", "0E 04 22 00 FFFFFFFF 24 01", "8E 00 05 00"},
}) ), name_of);

// Requests in requests: offsets outside of the data or into each other, counts that nothing follows, lengths that contradict,
// and nesting without end. pylogix issue 238, nDPI pull request 2295 (a loop without progress); R-MSG-16, R-CM-9, R-CM-10.
INSTANTIATE_TEST_SUITE_P(RegressionOfNesting, Message, testing::ValuesIn(std::to_array<Row>({
    {"MultipleServiceWithoutACount", "0A 02 20 02 24 01", "8A 00 13 00"},
    {"MultipleServiceCountsMoreThanItHas", "0A 02 20 02 24 01  FFFF 0400", "8A 00 13 00"},
    {"MultipleServiceOffsetBehindTheEnd", "0A 02 20 02 24 01  0100 FFFF 0E 03 20 01 24 01 30 01", "8A 00 13 00"},
    {"MultipleServiceOffsetIntoItsHead", "0A 02 20 02 24 01  0100 0000 0E 03 20 01 24 01 30 01", "8A 00 13 00"},
    {"MultipleServiceOffsetsBackwards", "0A 02 20 02 24 01  0200 0E00 0600 0E 03 20 01 24 01 30 01 0E 03 20 01 24 01 30 01", "8A 00 13 00"},
    {"MultipleServiceOfAnEmptyPart", "0A 02 20 02 24 01  0100 0400", "8A 00 13 00"},
    {"MultipleServiceInItself", "0A 02 20 02 24 01  0100 0400 0A 02 20 02 24 01 0000", "8A 00 1E 00 0100 0400 8A 00 08 00"},
    {"UnconnectedSendWithoutData", "52 02 20 06 24 01", "D2 00 01 01 0502 00 00"},
    {"UnconnectedSendOfMoreThanItHas", "52 02 20 06 24 01  0A 05 FFFF 0E 03 20 01 24 01 30 01 01 00 01 00", "D2 00 01 01 0502 00 00"},
    {"UnconnectedSendRouteBehindTheEnd", "52 02 20 06 24 01  0A 05 0800 0E 03 20 01 24 01 30 01 FF 00 01 00", "D2 00 01 01 0502 00 00"},
    {"UnconnectedSendOfNothing", "52 02 20 06 24 01  0A 05 0000 01 00 01 00", "D2 00 01 01 0502 01 00"},
    {"UnconnectedSendInItself", "52 02 20 06 24 01  0A 05 1600 52 02 20 06 24 01 0A 05 0800 0E 03 20 01 24 01 30 01 01 00 01 00 01 00 01 00", "D2 00 08 00"},
}) ), name_of);

// Opens that end too early, at every kind of place; connection paths whose words or segments end behind the request, above all
// simple data segments. OpENer issues 408 (large form), 564 (short), 570 (simple data); R-CON-1, R-CON-10, R-CON-14, R-CM-7.
const char* const head = "0A 0E 00000000 0300110A 0300 4D00 44332211 00 000000 80841E00 F443 80841E00 F443 A3 ";
// clang-format on

class Open : public testing::TestWithParam<Row> {};

TEST_P(Open, IsRefusedByNameAndOpensNothing) {
    AdapterHarness t;
    t.register_session();
    EXPECT_EQ(t.call("54 02 20 06 24 01" + std::string(head) + GetParam().request),
              hex(std::string(GetParam().reply) + "0300 4D00 44332211 00 00"));
    EXPECT_EQ(t.adapter().class3_connections(), 0U);
    EXPECT_EQ(t.adapter().io().size(), 0U);
    EXPECT_EQ(t.call(get_vendor), vendor);
}

// clang-format off
INSTANTIATE_TEST_SUITE_P(Regression, Open, testing::ValuesIn(std::to_array<Row>({
    {"ForwardOpenWithoutPathSize", "", "D4 00 13 00"},
    {"ForwardOpenPathHasMoreWordsThanTheRequest", "FF 20 02 24 01", "D4 00 13 00"},
    {"ForwardOpenPathHasLessWordsThanTheRequest", "01 20 02 24 01", "D4 00 15 00"},
    {"ForwardOpenSimpleDataBehindThePath", "03 20 02 24 01 80 FF", "D4 00 01 01 1503"},
    {"ForwardOpenSimpleDataOneWordBehindThePath", "04 20 02 24 01 80 02 00 00", "D4 00 01 01 1503"},
    {"ForwardOpenSimpleDataAlone", "01 80 FF", "D4 00 01 01 1503"},
    {"ForwardOpenKeyIsCut", "02 34 04 00 00", "D4 00 01 01 1503"},
    {"ForwardOpenSymbolBehindThePath", "01 91 FF", "D4 00 01 01 1503"},
    {"ForwardOpenLinkAddressBehindThePath", "01 11 FF", "D4 00 01 01 1503"},
    {"ForwardOpenReservedSegment", "01 FF FF", "D4 00 01 01 1503"},
}) ), name_of);
// clang-format on

TEST(Regression, ForwardOpenCutAnywhereIsShort) {
    AdapterHarness t;
    t.register_session();
    for (const auto& [service, whole] :
         {std::pair(0x54, octets(std::string(head) + "02 20 02 24 01")),
          std::pair(0x5B, octets("0A 0E 00000000 0300110A 0300 4D00 44332211 00 000000 80841E00 F4010042 80841E00 "
                                 "F4010042 A3 02 20 02 24 01"))}) {
        for (std::size_t length = 0; length < whole.size(); ++length) {
            auto request = octets("54 02 20 06 24 01");
            request[0] = static_cast<std::uint8_t>(service);
            request.insert(request.end(), whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
            const auto reply = cip::Response::parse(t.call(request));
            ASSERT_TRUE(reply) << length;
            EXPECT_EQ(reply->status, cip::Status(cip::GeneralStatus::not_enough_data)) << length;
        }
    }
    EXPECT_EQ(t.adapter().class3_connections(), 0U);
    EXPECT_EQ(t.call(get_vendor), vendor);
}

TEST(Regression, ForwardCloseCutAnywhereIsShort) {
    AdapterHarness t;
    t.register_session();
    const auto whole = octets("4E 02 20 06 24 01 0A 0E 0300 4D00 44332211 02 00 20 02 24 01");
    for (std::size_t length = 6; length < whole.size(); ++length) {
        const auto reply = cip::Response::parse(t.call(cip::ByteView(whole).first(length)));
        ASSERT_TRUE(reply) << length;
        EXPECT_EQ(reply->status, cip::Status(cip::GeneralStatus::not_enough_data)) << length;
    }
    EXPECT_EQ(t.call(get_vendor), vendor);
}

// A Set of the address is looked at once the address is one that is stored.
TEST(Regression, AnInterfaceConfigurationIsNoLongerThanItIs) {
    AdapterHarness t;
    t.register_session();
    ASSERT_EQ(t.call("10 03 20 F5 24 01 30 03  00000000"), "90 00 00 00");
    const std::string set = "10 03 20 F5 24 01 30 05  6402A8C0 00FFFFFF 00000000 00000000 00000000";
    for (const char* name : {"", "00", "FFFF", "0200 41", "FF00 41"}) {
        EXPECT_EQ(t.call(set + name), "90 00 13 00") << name;
    }
    EXPECT_EQ(t.call(set + "0000 00"), "90 00 15 00");
    EXPECT_EQ(t.call(get_vendor), vendor);
}

// Replies that outgrow their buffer, because a short request asks for much. OpENer issue 567: count 0x3030; R-MSG-14, R-ENC-27.
TEST(Regression, GetAttributeListOfThousandsKeepsTheLimitOfReplies) {
    AdapterHarness t;
    t.register_session();
    cip::Bytes request = octets("03 02 20 01 24 01");
    cip::Writer writer(request);
    constexpr std::uint16_t count = 1990;
    writer.u16(count);
    for (std::uint16_t i = 0; i < count; ++i) writer.u16(7);  // the product name, the longest
    const auto encoded = t.call(request);
    EXPECT_LE(encoded.size(), cip::max_message_bytes);
    const auto reply = cip::Response::parse(encoded);
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->status, cip::Status(cip::GeneralStatus::reply_data_too_large));
    EXPECT_EQ(t.call(get_vendor), vendor);
}

TEST(Regression, AReplyFitsAConnectionOfFewOctets) {
    AdapterHarness t;
    t.register_session();
    // T->O of 20 octets: 18 for the message.
    const auto opened = cip::Response::parse(
        t.call(octets("54 02 20 06 24 01 0A 0E 00000000 0300110A 0300 4D00 44332211 00 000000 80841E00 F443 80841E00 "
                      "1442 A3 02 20 02 24 01")));
    ASSERT_TRUE(opened && opened->status.ok());
    const auto id = cip::ForwardOpenReply::parse(opened->data).value().o_to_t_id;
    for (const char* request : {"01 02 20 01 24 01", "03 02 20 01 24 01 0300 0700 0700 0700"}) {
        t.send(enip::Frame{
            .command = enip::Command::send_unit_data,
            .session = t.session(),
            .data = enip::SendData::connected(id, static_cast<std::uint16_t>(request[1]), octets(request)).encode()}
                   .encode());
        const auto frame = t.frame();
        ASSERT_TRUE(frame) << request;
        const auto data = enip::SendData::parse(frame->data);
        const auto answer = enip::connected_message(data.value());
        ASSERT_TRUE(answer) << request;
        EXPECT_LE(answer->message.size(), 18U) << request;
        EXPECT_EQ(answer->message[2], 0x11) << request;
    }
}

// --- frames

/// The data portion of a SendRRData, and the status of its reply.
class Packet : public testing::TestWithParam<Row> {};

TEST_P(Packet, IsIncorrectData) {
    AdapterHarness t;
    t.register_session();
    t.send(
        enip::Frame{.command = enip::Command::send_rr_data, .session = t.session(), .data = octets(GetParam().request)}
            .encode());
    const auto reply = t.frame();
    ASSERT_TRUE(reply);
    EXPECT_EQ(hex(cip::Bytes{static_cast<std::uint8_t>(reply->status)}), GetParam().reply);
    EXPECT_TRUE(reply->data.empty());
    EXPECT_EQ(t.call(get_vendor), vendor);
}

// Items that are counted and not there, or longer than the message. OpENer issue 558 (count 0xE801), CIPster issue 35 (256);
// cpppo issue 45 and nDPI pull request 2295 (items of length 0); R-CPF-2, R-ENC-11.
// clang-format off
INSTANTIATE_TEST_SUITE_P(Regression, Packet, testing::ValuesIn(std::to_array<Row>({
    {"ItemCountWithoutItems", "00000000 0000  FFFF 0000 0000 B200 0000", "03"},
    {"ItemCountOf256", "00000000 0000  0001 0000 0000 B200 0800 0E03200124013001", "03"},
    {"ItemCountOneMore", "00000000 0000  0300 0000 0000 B200 0800 0E03200124013001", "03"},
    {"ItemCountOneLess", "00000000 0000  0100 0000 0000 B200 0800 0E03200124013001", "03"},
    {"ItemCountOfNone", "00000000 0000  0000 0000 0000 B200 0800 0E03200124013001", "03"},
    {"ItemIsLongerThanTheMessage", "00000000 0000  0200 0000 0000 B200 FFFF 0E03200124013001", "03"},
    {"ItemIsOneOctetLonger", "00000000 0000  0200 0000 0000 B200 0900 0E03200124013001", "03"},
    {"ItemHeadIsCut", "00000000 0000  0300 0000 0000 B200 0000 0080", "03"},
    {"NullItemHasALength", "00000000 0000  0200 0000 FFFF B200 0000", "03"},
    {"ItemsOfNothingWithoutEnd", "00000000 0000  1000 0000 0000 0000 0000 0000 0000 0000 0000 0000 0000", "03"},
    {"MessageOfOneOctet", "00000000 0000  0200 0000 0000 B200 0100 0E", "03"},
    {"MessageOfNothing", "00000000 0000  0200 0000 0000 B200 0000", "03"},
    {"DataOf15Octets", "00000000 0000  0200 0000 0000 B200 00", "65"},
    {"DataOfNothing", "", "65"},
}) ), name_of);
// clang-format on

// Lengths that are taken for negative, or cut to fewer bits, on their way through the layers. OpENer CVE-2021-27478, issue 563;
// R-ENC-3: passed over to the last octet, and the place is kept.
TEST(Regression, LengthsThatLookNegativeOrSmallArePassedOver) {
    AdapterHarness t;
    t.register_session();
    for (const std::uint16_t length : std::to_array<std::uint16_t>({0x7FFF, 0x8000, 0x8001, 0xFF00, 0xFFFF, 4201})) {
        auto frame =
            enip::Frame{.command = enip::Command::send_rr_data, .session = t.session(), .context = {1, 2}}.encode();
        frame[2] = static_cast<std::uint8_t>(length);
        frame[3] = static_cast<std::uint8_t>(length >> 8);
        frame.resize(frame.size() + length, 0xB2);
        t.send(frame);
        const auto reply = t.frame();
        ASSERT_TRUE(reply) << length;
        EXPECT_EQ(reply->status, EncapsulationStatus::invalid_length) << length;
        EXPECT_EQ(reply->context, (enip::SenderContext{1, 2})) << length;
        EXPECT_EQ(t.call(get_vendor), vendor) << length;
    }
}

TEST(Regression, ADatagramShorterThanItSaysIsDropped) {
    AdapterHarness t;
    EXPECT_TRUE(t.datagram(octets("6300 0100 00000000 00000000 0000000000000000 00000000")).empty());
    EXPECT_TRUE(t.datagram(octets("6300 FFFF 00000000 00000000 0000000000000000 00000000")).empty());
    EXPECT_TRUE(t.datagram(octets("6300 0000 00000000 00000000 0000000000000000 000000")).empty());
    EXPECT_EQ(t.datagram(octets("6300 0000 00000000 00000000 0000000000000000 00000000")).size(), 1U);
}

// A header that never ends. OpENer issue 562: it waits in a read, and serves nobody else. With sockets:
// HostilePeers.AnOctetEveryTenMilliseconds and HostilePeers.ThoseWhoAnnounceMuchAndSendNothing.
TEST(Regression, AHeaderWithoutEndKeepsNobodyWaitingAndIsClosed) {
    AdapterHarness t;
    t.register_session();
    const auto slow = t.adapter().on_open(AdapterHarness::peer, AdapterHarness::local, t.now());
    ASSERT_TRUE(slow);
    const auto head_octets = octets("6F00 FFFF 00000000 00000000 0000000000000000 000000");
    for (const auto octet : head_octets) {
        EXPECT_EQ(t.adapter().on_octets(*slow, cip::ByteView(&octet, 1), t.now()), 1U);
        EXPECT_TRUE(t.adapter().take_replies(*slow).empty());
        EXPECT_EQ(t.call(get_vendor), vendor);
    }
    for (int i = 0; i < 13; ++i) {
        t.advance(std::chrono::seconds(10));
        EXPECT_EQ(t.call(get_vendor), vendor);
    }
    EXPECT_TRUE(t.adapter().wants_close(*slow)) << "R-ENC-24";
}

// Handles and ids of others. OpENer issue 565: a handle was good on any TCP connection; R-ENC-20, R-ENC-21, R-ENC-23.
TEST(Regression, ASessionHandleOfAnotherIsWorthNothing) {
    AdapterHarness t;
    t.register_session();
    const auto thief = t.adapter().on_open(AdapterHarness::peer, AdapterHarness::local, t.now());
    ASSERT_TRUE(thief);
    const auto send = [&](enip::Command command, cip::Bytes data) {
        const auto frame = enip::Frame{.command = command, .session = t.session(), .data = std::move(data)}.encode();
        EXPECT_EQ(t.adapter().on_octets(*thief, frame, t.now()), frame.size());
        return enip::Frame::parse(t.adapter().take_replies(*thief));
    };
    const auto request = enip::SendData::unconnected(octets(get_vendor)).encode();
    const auto connected = enip::SendData::connected(1, 1, octets(get_vendor)).encode();
    for (const bool registered : {false, true}) {
        if (registered) {
            EXPECT_TRUE(send(enip::Command::register_session, enip::RegisterSession{}.encode()));
        }
        for (const auto& reply :
             {send(enip::Command::send_rr_data, request), send(enip::Command::send_unit_data, connected),
              send(enip::Command::unregister_session, {})}) {
            ASSERT_TRUE(reply);
            EXPECT_EQ(reply->status, EncapsulationStatus::invalid_session);
            EXPECT_TRUE(reply->data.empty());
        }
    }
    EXPECT_TRUE(t.connected());
    EXPECT_EQ(t.call(get_vendor), vendor) << "whose session it is lives on";
}

TEST(Regression, AConnectionOfAnotherIsNotAnswered) {
    AdapterHarness t;
    t.register_session();
    const auto opened =
        cip::Response::parse(t.call(octets("54 02 20 06 24 01" + std::string(head) + "02 20 02 24 01")));
    ASSERT_TRUE(opened && opened->status.ok());
    const auto id = cip::ForwardOpenReply::parse(opened->data).value().o_to_t_id;
    const auto thief = t.adapter().on_open(AdapterHarness::peer, AdapterHarness::local, t.now());
    ASSERT_TRUE(thief);
    const auto send = [&](const enip::Frame& frame) {
        (void)t.adapter().on_octets(*thief, frame.encode(), t.now());
        return t.adapter().take_replies(*thief);
    };
    const auto session =
        enip::Frame::parse(send({.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()}))
            .value()
            .session;
    EXPECT_TRUE(send({.command = enip::Command::send_unit_data,
                      .session = session,
                      .data = enip::SendData::connected(id, 1, octets(get_vendor)).encode()})
                    .empty());
    EXPECT_EQ(t.adapter().class3_connections(), 1U);
}

// --- class 1

// Counts and lengths of datagrams, which nobody answers: they change nothing and are counted; R-IO-7, R-IO-8.
TEST(Regression, DatagramsOfClass1ThatLieChangeNothing) {
    AdapterHarness t;
    t.register_session();
    const auto plan = scanner::plan_of(*assemblies::find_connection("standard"));
    const auto opened = cip::Response::parse(
        t.call(scanner::open_request(plan.forward_open(0, 0x33000001, {3, 0x4D, 0x11223344})).encode()));
    ASSERT_TRUE(opened && opened->status.ok());
    const auto own = cip::ForwardOpenReply::parse(opened->data).value().o_to_t_id;
    cip::Bytes little;
    cip::Writer(little).u32(own);
    const auto& strays = t.adapter().io().strays();
    const auto& counters = t.adapter().io().owner()->consumer.counters();
    const std::string address = "0280 0800" + hex(little) + "01000000";
    std::uint64_t malformed = 0;
    for (const auto& datagram :
         {std::string(), std::string("0200"), "FFFF" + address, "0200" + address, "0200" + address + "B100",
          "0200" + address + "B100 FFFF 0100", "0200 0280 0700" + hex(little) + "010000 B100 0200 0100",
          "0100" + address, "0200" + address + "B200 0200 0100"}) {
        t.io(octets(datagram));
        EXPECT_EQ(strays.malformed, ++malformed) << datagram;
    }
    EXPECT_EQ(counters.accepted + counters.wrong_size, 0U);
    // No room for the run/idle header, or for the sequence count.
    for (const std::string data : {"B100 0000", "B100 0100 01", "B100 0200 0100", "B100 0500 0100010000"}) {
        t.io(octets("0200" + address + data));
    }
    EXPECT_EQ(counters.wrong_size, 4U);
    EXPECT_EQ(counters.accepted, 0U);
    EXPECT_TRUE(t.produced().empty());
}

// --- our own client

// A reply that counts more services than it has, and offsets behind its end. pylogix issue 238.
TEST(Regression, AReplyThatCountsMoreServicesThanItHasIsNonsense) {
    const std::array requests{cip::Request{0x0E, cip::Path::to(1, 1, 1), {}},
                              cip::Request{0x0E, cip::Path::to(1, 1, 2), {}}};
    for (const char* data : {"", "0200", "0200 0600", "0200 0600 0C00", "0200 0600 CE00 8E000000 6D05 8E000000",
                             "0200 0C00 0600 8E0000006D05 8E0000002B00", "0100 0400 8E0000006D05",
                             "0200 0600 0C00 8E0000006D05 8E0000", "0200 0600 0C00 8E0000006D05 900000002B00"}) {
        EXPECT_FALSE(scanner::multiple_service_responses(requests, {0x0A, {}, octets(data)})) << data;
    }
    EXPECT_TRUE(
        scanner::multiple_service_responses(requests, {0x0A, {}, octets("0200 0600 0C00 8E0000006D05 8E0000002B00")}));
}

// Replies to a Forward_Open that are short, or about something else.
TEST(Regression, AReplyToAForwardOpenIsCheckedBeforeItIsBelieved) {
    const scanner::Class3Proposal proposal{
        .t_to_o_id = 0x0A110003, .triad = {3, 0x4D, 0x11223344}, .path = scanner::class3_path({})};
    const auto whole = octets("01000056 0300110A 0300 4D00 44332211 80841E00 80841E00 00 00");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_FALSE(scanner::class3_connection(proposal, cip::ByteView(whole).first(length))) << length;
    }
    EXPECT_TRUE(scanner::class3_connection(proposal, whole));
    EXPECT_FALSE(
        scanner::class3_connection(proposal, octets("01000056 0300110A 0400 4D00 44332211 80841E00 80841E00 00 00")));
    EXPECT_FALSE(
        scanner::class3_connection(proposal, octets("01000056 0300110A 0300 4D00 44332211 80841E00 80841E00 FF 00")));
}

// ListIdentity replies with a length of 0, and names that are longer than their item. cpppo issue 45.
TEST(Regression, AnIdentityThatIsCutIsNone) {
    const auto whole = octets("0100 0002AF12C0A80264 0000000000000000 6D05 2B00 7509 0101 0000 01000000 03 414243 03");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_FALSE(enip::IdentityItem::parse(cip::ByteView(whole).first(length))) << length;
    }
    ASSERT_TRUE(enip::IdentityItem::parse(whole));
    EXPECT_FALSE(enip::CommonPacket::parse(octets("0100 0C00 0000 00")));
    EXPECT_FALSE(enip::CommonPacket::parse(octets("FFFF 0C00 0000")));
}

// An upload that announces much and brings little, or nothing for ever.
TEST(Regression, AnUploadWithoutEndEnds) {
    for (const char* grant : {"FFFFFFFF FF", "00000000 00", "05000000 00", "0500000003"}) {
        scanner::FileUpload upload;
        std::size_t answers = 0;
        for (; answers < 1000 && !upload.done(); ++answers) {
            const bool begins = upload.request().service == cip::file::initiate_upload;
            upload.on_response({upload.request().service, {}, octets(begins ? grant : "00 01")});
        }
        EXPECT_TRUE(upload.done()) << grant;
        EXPECT_TRUE(upload.failure()) << grant;
        EXPECT_LT(answers, 20U) << grant;
    }
}

// Captures whose blocks have a length of 0, or one that is no end; Wireshark's own parser of pcapng CVE-2018-7420.
TEST(Regression, ACaptureWhoseBlocksHaveNoLengthEnds) {
    const std::string section = "0A0D0D0A 1C000000 4D3C2B1A 0100 0000 FFFFFFFFFFFFFFFF 1C000000";
    for (const char* block : {"01000000 00000000", "06000000 FFFFFFFF", "06000000 0C000000 0C000000",
                              "06000000 20000000 00000000 00000000 00000000 FFFFFFFF FFFFFFFF 20000000"}) {
        const auto bytes = octets(section + block);
        std::istringstream file(std::string(bytes.begin(), bytes.end()));
        std::size_t packets = 0;
        const auto summary = scanner::read_capture(file, [&](const auto&) { ++packets; });
        EXPECT_TRUE(summary.damage) << block;
        EXPECT_EQ(packets, 0U) << block;
    }
}

}  // namespace
}  // namespace servobus::fuzz
