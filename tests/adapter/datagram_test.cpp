// What comes by UDP 44818 (R-ENC-3, R-ENC-5, R-ENC-14, R-ENC-15).
#include <gtest/gtest.h>

#include <set>

#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::string_view list_interfaces = "6400 0000 00000000 00000000 A1A2A3A4A5A6A7A8 00000000";
constexpr std::string_view no_interfaces = "6400 0200 00000000 00000000 A1A2A3A4A5A6A7A8 00000000 0000";

// `delay` is the first UINT of the context: the longest delay in milliseconds.
std::string list_identity(std::uint16_t delay) {
    return fmt::format("6300 0000 00000000 00000000 {:02X}{:02X} A3A4A5A6A7A8 00000000", delay & 0xFF, delay >> 8);
}

TEST(Datagram, R_ENC_5_ListCommandsAreAnsweredAtOnce) {
    Site site;
    EXPECT_THAT(site.datagram(list_interfaces), ElementsAre(hex(no_interfaces)));
    EXPECT_THAT(site.datagram("0400 0000 00000000 00000000 A1A2A3A4A5A6A7A8 00000000"),
                ElementsAre(hex("0400 1A00 00000000 00000000 A1A2A3A4A5A6A7A8 00000000"
                                "0100 0001 1400 0100 2001 436F6D6D756E69636174696F6E730000")));
    const auto identity = site.datagram(list_identity(1));
    ASSERT_EQ(identity.size(), 1U);
    EXPECT_EQ(identity[0].substr(0, 24 * 3 - 1), hex("6300 3700 00000000 00000000 0100A3A4A5A6A7A8 00000000"));
}

TEST(Datagram, R_ENC_5_CommandsOfTcpAreUnsupported) {
    Site site;
    for (const auto* command : {"65 00", "66 00", "6F 00", "70 00", "72 00", "C8 00"}) {
        EXPECT_THAT(site.datagram(frame(command, "01 02 03 04", "01 00 00 00")),
                    ElementsAre(hex(failure(command, "01 02 03 04", "01 00 00 00"))));
    }
    EXPECT_EQ(site.adapter.sessions(), 0U);
}

TEST(Datagram, R_ENC_5_ANopIsIgnored) {
    Site site;
    EXPECT_THAT(site.datagram(frame("00 00")), IsEmpty());
    EXPECT_THAT(site.datagram(frame("00 00", no_session, "01 02")), IsEmpty());
}

TEST(Datagram, R_ENC_3_AShortDatagramIsDropped) {
    Site site;
    const auto whole = octets(frame("64 00", no_session, "01 02 03 04"));
    for (std::size_t size = 0; size < whole.size(); ++size) {
        EXPECT_THAT(site.datagram(hex(cip::ByteView(whole).first(size))), IsEmpty()) << size;
    }
    EXPECT_THAT(site.datagram(hex(whole)), ElementsAre(hex(failure("64 00", no_session, "65 00 00 00"))));
}

TEST(Datagram, R_ENC_7_and_8_OptionsAndStatusAreIgnored) {
    Site site;
    for (const auto* command : {"04 00", "63 00", "64 00", "65 00", "6F 00"}) {
        EXPECT_THAT(site.datagram(FrameText{.command = command, .options = "01 00 00 00"}.text()), IsEmpty());
        EXPECT_THAT(site.datagram(FrameText{.command = command, .status = "01 00 00 00"}.text()), IsEmpty());
    }
}

TEST(Datagram, R_ENC_14_ABroadcastIsAnsweredAfterARandomTime) {
    struct Case {
        std::uint16_t asked;
        std::chrono::milliseconds longest;
    };
    for (const auto& [asked, longest] : {Case{0, 2000ms}, Case{1, 500ms}, Case{499, 500ms}, Case{500, 500ms},
                                         Case{501, 501ms}, Case{3000, 3000ms}, Case{65535, 65535ms}}) {
        std::set<enip::Time> times;
        for (std::uint64_t seed = 0; seed < 100; ++seed) {
            Site site({}, drive::Device(drive::xenax_models().front()), seed);
            EXPECT_THAT(site.datagram(list_identity(asked), true), IsEmpty());
            const auto due = site.adapter.next_deadline();
            ASSERT_TRUE(due);
            EXPECT_GE(*due, site.now);
            EXPECT_LE(*due, site.now + longest);
            times.insert(*due);
            if (*due > site.now) {
                site.adapter.on_timer(*due - 1us);
                EXPECT_THAT(site.datagrams(), IsEmpty());
            }
            site.adapter.on_timer(*due);
            const auto replies = site.datagrams();
            ASSERT_EQ(replies.size(), 1U);
            EXPECT_EQ(octets(replies[0])[12], asked & 0xFF) << "the context comes back unchanged";
            EXPECT_EQ(octets(replies[0])[13], asked >> 8);
            EXPECT_EQ(site.adapter.next_deadline(), std::nullopt);
        }
        EXPECT_GT(times.size(), 50U) << "a hundred devices do not answer together";
        EXPECT_GT(*times.rbegin() - *times.begin(), longest / 2);
    }
}

TEST(Datagram, R_ENC_14_TheDelayFollowsTheSeed) {
    const auto due = [](std::uint64_t seed) {
        Site site({}, drive::Device(drive::xenax_models().front()), seed);
        site.datagram(list_identity(0), true);
        return *site.adapter.next_deadline();
    };
    EXPECT_EQ(due(7), due(7));
    EXPECT_NE(due(7), due(8));
}

TEST(Datagram, R_ENC_15_ADelayedReplyHoldsNothingUp) {
    Site site;
    Peer peer(site);
    EXPECT_THAT(site.datagram(list_identity(0), true), IsEmpty());
    EXPECT_THAT(site.datagram(list_interfaces), ElementsAre(hex(no_interfaces)));
    EXPECT_EQ(peer.send(std::string(list_interfaces)), hex(no_interfaces));
    site.advance(2s);
    EXPECT_EQ(site.datagrams().size(), 1U);
}

TEST(Datagram, R_ENC_15_OtherBroadcastsAreNotDelayedAndNonsenseIsNotAnswered) {
    Site site;
    EXPECT_THAT(site.datagram(list_interfaces, true), ElementsAre(hex(no_interfaces)));
    EXPECT_THAT(site.datagram(frame("6F 00"), true), IsEmpty());
    EXPECT_THAT(site.datagram(frame("72 00"), true), IsEmpty());
    site.advance(70s);
    EXPECT_THAT(site.datagrams(), IsEmpty());
}

TEST(Datagram, R_ENC_15_TwoBroadcastsAreAnsweredTwice) {
    Site site;
    site.datagram(list_identity(600), true);
    site.datagram(list_identity(700), true);
    site.advance(700ms);
    EXPECT_EQ(site.datagrams().size(), 2U);
}

}  // namespace
}  // namespace servobus::test
