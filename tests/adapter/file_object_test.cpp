// The File object through the whole target, hex in and hex out (R-FIL).
#include <gtest/gtest.h>

#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

constexpr std::string_view initiate = "4B 02 20 37 24 C8";
constexpr std::string_view transfer = "4F 02 20 37 24 C8";

std::string call(Peer& peer, std::string_view service, unsigned octet) {
    return peer.call(fmt::format("{} {:02X}", service, octet));
}

/// `00 01 02 …`: every piece of it is different.
cip::Bytes counting(std::size_t size) {
    cip::Bytes content(size);
    for (std::size_t i = 0; i < size; ++i) content[i] = static_cast<std::uint8_t>(i);
    return content;
}

adapter::DeviceFile stored(cip::Bytes content, std::string name = "a.eds") {
    return {.content = std::make_shared<const cip::Bytes>(std::move(content)),
            .name = std::move(name),
            .major_revision = 2,
            .minor_revision = 3};
}

/// A device that hands out `content`, and no icon.
Site site_of(cip::Bytes content) { return Site(adapter::DeviceFiles{.eds = stored(std::move(content))}); }

const std::string ten = "00 01 02 03 04 05 06 07 08 09";

TEST(File, R_FIL_2_InstanceAttributes) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    const auto get = [&](unsigned id) { return peer.call(fmt::format("0E 03 20 37 24 C8 30 {:02X}", id)); };
    EXPECT_EQ(get(1), hex("8E 00 00 00 02"));
    EXPECT_EQ(get(2), hex("8E 00 00 00 01 656E67 DA 0400 12 45445320616E642049636F6E2046696C6573"));
    EXPECT_EQ(get(3), hex("8E 00 00 00 01 00"));
    EXPECT_EQ(get(4), hex("8E 00 00 00 01 656E67 DA 0400 05 612E656473"));
    EXPECT_EQ(get(5), hex("8E 00 00 00 02 03"));
    EXPECT_EQ(get(6), hex("8E 00 00 00 0A 00 00 00"));
    EXPECT_EQ(get(7), hex("8E 00 00 00 D3 FF"));
    EXPECT_EQ(get(8), hex("8E 00 00 00 FF"));
    EXPECT_EQ(get(9), hex("8E 00 00 00 00"));
    EXPECT_EQ(get(10), hex("8E 00 00 00 01"));
    EXPECT_EQ(get(11), hex("8E 00 00 00 00"));
    EXPECT_EQ(get(0), hex("8E 00 14 00"));
    EXPECT_EQ(get(12), hex("8E 00 14 00"));
    EXPECT_EQ(peer.call("0E 02 20 37 24 C8"), hex("8E 00 14 00"));
}

TEST(File, R_FIL_1_ClassAttributesCountTheFiles) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    const auto get = [&](unsigned id) { return peer.call(fmt::format("0E 03 20 37 24 00 30 {:02X}", id)); };
    EXPECT_EQ(get(1), hex("8E 00 00 00 03 00"));
    EXPECT_EQ(get(2), hex("8E 00 00 00 C8 00"));
    EXPECT_EQ(get(3), hex("8E 00 00 00 01 00"));
    EXPECT_EQ(get(6), hex("8E 00 00 00 20 00"));
    EXPECT_EQ(get(7), hex("8E 00 00 00 0B 00"));
    EXPECT_EQ(get(4), hex("8E 00 14 00"));
    EXPECT_EQ(get(31), hex("8E 00 14 00"));
    EXPECT_EQ(get(33), hex("8E 00 14 00"));
    EXPECT_EQ(peer.call("0E 03 20 64 24 00 30 20"), hex("8E 00 14 00")) << "other classes have no directory";
}

// As many entries as attribute 3 says (Rockwell 1444-UM001, table 286).
TEST(File, R_FIL_3_DirectoryListsTheFiles) {
    const std::string eds =
        "C800 01 656E67 DA 0400 12 45445320616E642049636F6E2046696C6573 "
        "01 656E67 DA 0400 05 612E656473";
    auto site = site_of(octets(ten));
    EXPECT_EQ(registered(site).call("0E 03 20 37 24 00 30 20"), hex("8E 00 00 00 " + eds));
    Site both(adapter::DeviceFiles{.eds = stored(octets(ten)), .icon = stored(octets("AA"), "a.ico")});
    auto peer = registered(both);
    EXPECT_EQ(peer.call("0E 03 20 37 24 00 30 20"),
              hex("8E 00 00 00 " + eds +
                  " C900 01 656E67 DA 0400 1A 52656C617465642045445320616E642049636F6E2046696C6573 "
                  "01 656E67 DA 0400 05 612E69636F"));
    EXPECT_EQ(peer.call("0E 03 20 37 24 00 30 02"), hex("8E 00 00 00 C9 00"));
    EXPECT_EQ(peer.call("0E 03 20 37 24 00 30 03"), hex("8E 00 00 00 02 00"));
}

TEST(File, R_FIL_1_TheIconIsAnInstanceOfItsOwn) {
    auto without = site_of(octets(ten));
    EXPECT_EQ(registered(without).call("0E 03 20 37 24 C9 30 01"), hex("8E 00 05 00"));
    EXPECT_EQ(registered(without).call("4B 02 20 37 24 C9 20"), hex("CB 00 05 00"));
    Site site(adapter::DeviceFiles{.eds = stored(octets(ten)), .icon = stored(octets("AA BB"), "a.ico")});
    auto peer = registered(site);
    auto other = registered(site);
    EXPECT_EQ(peer.call("0E 03 20 37 24 C9 30 06"), hex("8E 00 00 00 02 00 00 00"));
    EXPECT_EQ(peer.call("4B 02 20 37 24 C9 20"), hex("CB 00 00 00 02 00 00 00 20"));
    // Its upload keeps nobody from the EDS, and the other way round.
    EXPECT_EQ(call(other, initiate, 0x20), hex("CB 00 00 00 0A 00 00 00 20"));
    EXPECT_EQ(peer.call("4F 02 20 37 24 C9 00"), hex("CF 00 00 00 00 04 AA BB 9B FE"));
    EXPECT_EQ(call(other, transfer, 0), hex("CF 00 00 00 00 04 " + ten + " D3 FF"));
}

TEST(File, R_FIL_1_InstancesOneAnd200AreOneObjectWithOneTransfer) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    auto other = registered(site);
    EXPECT_EQ(peer.call("0E 03 20 37 24 01 30 06"), hex("8E 00 00 00 0A 00 00 00"));
    EXPECT_EQ(peer.call("4B 02 20 37 24 01 06"), hex("CB 00 00 00 0A 00 00 00 06"));
    EXPECT_EQ(call(other, initiate, 6), hex("CB 00 0C 01 03 00"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03 04 05"));
    EXPECT_EQ(peer.call("4F 02 20 37 24 01 01"), hex("CF 00 00 00 01 02 06 07 08 09 D3 FF"));
    EXPECT_EQ(peer.call("0E 03 20 37 24 02 30 01"), hex("8E 00 05 00"));
}

TEST(File, R_FIL_4_And5_StatesAndPiecesOfAnUpload) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    const auto state = [&] { return peer.call("0E 03 20 37 24 C8 30 01"); };
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
    EXPECT_EQ(state(), hex("8E 00 00 00 03"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03"));
    EXPECT_EQ(state(), hex("8E 00 00 00 05"));
    EXPECT_EQ(call(peer, transfer, 1), hex("CF 00 00 00 01 01 04 05 06 07"));
    EXPECT_EQ(call(peer, transfer, 2), hex("CF 00 00 00 02 02 08 09 D3 FF"));
    EXPECT_EQ(state(), hex("8E 00 00 00 02"));
    EXPECT_EQ(call(peer, transfer, 3), hex("CF 00 02 00")) << "the last piece has been acknowledged";
    EXPECT_EQ(call(peer, transfer, 2), hex("CF 00 02 00")) << "and is gone with that";
}

// A file that ends where a piece ends has no empty piece behind it.
TEST(File, R_FIL_5_WholePieces) {
    auto site = site_of(octets("01 02 03 04"));
    auto peer = registered(site);
    EXPECT_EQ(call(peer, initiate, 2), hex("CB 00 00 00 04 00 00 00 02"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 01 02"));
    EXPECT_EQ(call(peer, transfer, 1), hex("CF 00 00 00 01 02 03 04 F6 FF"));
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 04 00 00 00 04"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 04 01 02 03 04 F6 FF"));
}

TEST(File, R_FIL_5_ARepeatedNumberSendsThePieceAgain) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
    for (int i = 0; i < 3; ++i) EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03"));
    for (int i = 0; i < 3; ++i) EXPECT_EQ(call(peer, transfer, 1), hex("CF 00 00 00 01 01 04 05 06 07"));
    for (int i = 0; i < 3; ++i) EXPECT_EQ(call(peer, transfer, 2), hex("CF 00 00 00 02 02 08 09 D3 FF"));
    EXPECT_EQ(call(peer, transfer, 3), hex("CF 00 02 00"));
}

TEST(File, R_FIL_4_ASecondInitiateStartsAgain) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
        EXPECT_EQ(call(peer, initiate, 6), hex("CB 00 00 00 0A 00 00 00 06"));
        EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03 04 05"));
    }
}

TEST(File, R_FIL_5_TransferNumbersGoRound) {
    constexpr std::size_t pieces = 600;
    auto site = site_of(counting(2 * pieces));
    auto peer = registered(site);
    EXPECT_EQ(call(peer, initiate, 2), hex("CB 00 00 00 B0 04 00 00 02"));
    for (unsigned i = 0; i + 1 < pieces; ++i) {
        const auto number = i & 0xFF;
        const auto octet = (2 * i) & 0xFF;
        EXPECT_EQ(call(peer, transfer, number), hex(fmt::format("CF 00 00 00 {:02X} {:02X} {:02X} {:02X}", number,
                                                                i == 0 ? 0 : 1, octet, octet + 1)));
    }
    EXPECT_EQ(call(peer, transfer, 599 & 0xFF), hex("CF 00 00 00 57 02 AE AF D8 C5"));
}

// A reply holds header, number, type and checksum beside the piece; of a packet of requests, what is left of its room.
TEST(File, R_FIL_4_APieceFitsTheReply) {
    auto site = site_of(counting(300));
    auto peer = registered(site);
    EXPECT_EQ(call(peer, initiate, 0xFF), hex("CB 00 00 00 2C 01 00 00 FF"));
    adapter::Limits limits;
    limits.message_bytes = 100;
    Site small(adapter::DeviceFiles{.eds = stored(counting(300))}, limits);
    auto client = registered(small);
    EXPECT_EQ(call(client, initiate, 0xFF), hex("CB 00 00 00 2C 01 00 00 5C"));
    EXPECT_EQ(octets(call(client, transfer, 0)).size(), 4U + 2 + 0x5C);
    EXPECT_EQ(octets(call(client, transfer, 3)).size(), 6U) << "out of order";
}

TEST(File, R_FIL_7_WrongRequests) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    EXPECT_EQ(call(peer, initiate, 0), hex("CB 00 20 01 08 00"));
    EXPECT_EQ(peer.call(std::string(initiate)), hex("CB 00 13 00"));
    EXPECT_EQ(peer.call(std::string(initiate) + " 20 00"), hex("CB 00 15 00"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 02 00")) << "none of these has initiated anything";
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
    EXPECT_EQ(peer.call(std::string(transfer)), hex("CF 00 13 00"));
    EXPECT_EQ(peer.call(std::string(transfer) + " 00 00"), hex("CF 00 15 00"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03")) << "the transfer stands";
}

TEST(File, R_FIL_7_ANumberOutOfOrderAbortsTheTransfer) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    for (const unsigned wrong : {1U, 255U}) {
        EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
        EXPECT_EQ(call(peer, transfer, wrong), hex("CF 00 20 01 06 00"));
        EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 02 00"));
    }
    for (const unsigned wrong : {0U, 3U}) {
        EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
        EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03"));
        EXPECT_EQ(call(peer, transfer, 1), hex("CF 00 00 00 01 01 04 05 06 07"));
        EXPECT_EQ(call(peer, transfer, wrong), hex("CF 00 20 01 06 00"));
        EXPECT_EQ(peer.call("0E 03 20 37 24 C8 30 01"), hex("8E 00 00 00 02"));
        EXPECT_EQ(call(peer, transfer, 2), hex("CF 00 02 00"));
    }
}

TEST(File, R_FIL_7_OneClientAtATime) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    auto other = registered(site);
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
    EXPECT_EQ(call(other, initiate, 4), hex("CB 00 0C 01 03 00"));
    EXPECT_EQ(call(other, transfer, 0), hex("CF 00 0C 01 03 00"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03"));
    EXPECT_EQ(call(other, initiate, 4), hex("CB 00 0C 01 05 00"));
    EXPECT_EQ(call(other, transfer, 1), hex("CF 00 0C 01 05 00"));
    EXPECT_EQ(call(peer, transfer, 1), hex("CF 00 00 00 01 01 04 05 06 07")) << "the others have disturbed nothing";
    EXPECT_EQ(call(peer, transfer, 2), hex("CF 00 00 00 02 02 08 09 D3 FF"));
    // Once the last piece is out, the next client may have it.
    EXPECT_EQ(call(other, transfer, 0), hex("CF 00 02 00"));
    EXPECT_EQ(call(other, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
    EXPECT_EQ(call(peer, transfer, 2), hex("CF 00 0C 01 03 00"));
}

TEST(File, AClientThatGoesAwayFreesItAtOnce) {
    auto site = site_of(octets(ten));
    auto other = registered(site);
    {
        auto peer = registered(site);
        EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
        EXPECT_EQ(call(other, initiate, 4), hex("CB 00 0C 01 03 00"));
    }
    EXPECT_EQ(other.call("0E 03 20 37 24 C8 30 01"), hex("8E 00 00 00 02"));
    EXPECT_EQ(call(other, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
    // Somebody else who goes is none of its business.
    { auto third = registered(site); }
    EXPECT_EQ(call(other, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03"));
}

TEST(File, R_FIL_8_IdleTransfersAreDropped) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
    site.advance(9'999ms);
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03"));
    site.advance(9'999ms);
    EXPECT_EQ(peer.call("0E 03 20 37 24 C8 30 01"), hex("8E 00 00 00 05"));
    EXPECT_EQ(call(peer, transfer, 1), hex("CF 00 00 00 01 01 04 05 06 07")) << "each piece starts the time again";
    site.advance(10'000ms);
    EXPECT_EQ(peer.call("0E 03 20 37 24 C8 30 01"), hex("8E 00 00 00 02"));
    EXPECT_EQ(call(peer, transfer, 2), hex("CF 00 02 00"));
    // Nobody has to wait for it, either.
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
    site.advance(10'000ms);
    auto other = registered(site);
    EXPECT_EQ(call(other, initiate, 4), hex("CB 00 00 00 0A 00 00 00 04"));
}

TEST(File, R_FIL_7_WithoutAFile) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call("0E 03 20 37 24 C8 30 01"), hex("8E 00 00 00 00"));
    EXPECT_EQ(peer.call("0E 03 20 37 24 C8 30 06"), hex("8E 00 00 00 00 00 00 00"));
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 16 00"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 16 00"));
    EXPECT_EQ(peer.call("4B 02 20 37 24 01 04"), hex("CB 00 16 00"));
}

TEST(File, R_FIL_7_AnEmptyFile) {
    auto site = site_of({});
    auto peer = registered(site);
    EXPECT_EQ(peer.call("0E 03 20 37 24 C8 30 01"), hex("8E 00 00 00 01"));
    EXPECT_EQ(peer.call("0E 03 20 37 24 C8 30 07"), hex("8E 00 00 00 00 00"));
    EXPECT_EQ(call(peer, initiate, 4), hex("CB 00 0C 00"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 0C 00"));
}

TEST(File, R_FIL_7_NothingIsWritten) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    // Initiate_Download, Initiate_Partial_Read, an unassigned one, Download_Transfer, Clear_File, Create, Delete.
    for (const unsigned service : {0x4CU, 0x4DU, 0x4EU, 0x50U, 0x51U, 0x08U, 0x09U}) {
        EXPECT_EQ(peer.call(fmt::format("{:02X} 02 20 37 24 C8 00 00 00 00", service)),
                  hex(fmt::format("{:02X} 00 08 00", service | 0x80)));
    }
    EXPECT_EQ(peer.call("10 03 20 37 24 C8 30 04 00"), hex("90 00 08 00"));
    EXPECT_EQ(peer.call("04 02 20 37 24 C8 0100 0400 00"), hex("84 00 08 00"));
    EXPECT_EQ(peer.call("10 03 20 37 24 00 30 20 00"), hex("90 00 08 00"));
}

// The same transfer over a class 3 connection and beside it: both are one client.
TEST(File, ConnectedAndUnconnectedRequestsOfASessionAreOneClient) {
    auto site = site_of(octets(ten));
    auto peer = registered(site);
    peer.open_class3();
    EXPECT_EQ(peer.connected_call(1, fmt::format("{} 04", initiate)), hex("CB 00 00 00 0A 00 00 00 04"));
    EXPECT_EQ(call(peer, transfer, 0), hex("CF 00 00 00 00 00 00 01 02 03"));
    EXPECT_EQ(peer.connected_call(2, fmt::format("{} 01", transfer)), hex("CF 00 00 00 01 01 04 05 06 07"));
}

}  // namespace
}  // namespace servobus::test
