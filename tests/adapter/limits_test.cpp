// Every limit of adapter/limits.hpp, at it and one past it.
#include <gtest/gtest.h>

#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

const std::string no_memory = "02 00 00 00";

adapter::Limits few_connections() {
    adapter::Limits limits;
    limits.tcp_connections = 2;
    limits.refusals = 1;
    limits.sessions = 3;
    return limits;
}

TEST(Limits, R_ENC_26_TcpConnections_ANewcomerPastThemIsRefusedAndClosed) {
    Site site(few_connections());
    auto first = registered(site);
    auto second = registered(site);
    Peer newcomer(site);
    ASSERT_TRUE(newcomer.accepted());
    EXPECT_TRUE(newcomer.open());
    EXPECT_EQ(newcomer.send(frame("65 00", no_session, "01 00 00 00") + frame("04 00")),
              hex(failure("65 00", no_session, no_memory)));
    EXPECT_FALSE(newcomer.open());
    EXPECT_EQ(site.adapter.sessions(), 2U);
    EXPECT_EQ(first.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
    EXPECT_EQ(second.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
}

TEST(Limits, R_ENC_26_TcpConnections_AFreePlaceIsTakenAgain) {
    Site site(few_connections());
    Peer first(site);
    Peer second(site);
    first.close();
    auto third = registered(site);
    EXPECT_EQ(third.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
}

TEST(Limits, TcpConnections_ANewcomerTakesThePlaceOfTheLongestSilentWithoutASession) {
    Site site(few_connections());
    Peer first(site);
    Peer second(site);
    site.advance(1s);
    EXPECT_NE(first.send(frame("04 00")), "") << "it has spoken last";
    auto third = registered(site);
    EXPECT_EQ(site.adapter.take_expired(), std::vector{second.id()});
    EXPECT_FALSE(second.open());
    EXPECT_TRUE(first.open());
    auto fourth = registered(site);
    EXPECT_EQ(site.adapter.take_expired(), std::vector{first.id()});
    EXPECT_EQ(third.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00")) << "a session stays";
    EXPECT_EQ(fourth.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
}

/// A device whose two places have sessions.
struct FullSite : Site {
    FullSite() : Site(few_connections()) {}
    Peer first = registered(*this);
    Peer second = registered(*this);
};

TEST(Limits, Refusals_OnePastThemTakesThePlaceOfTheOldest) {
    FullSite site;
    Peer refused(site);
    EXPECT_TRUE(refused.open());
    Peer newer(site);
    EXPECT_EQ(site.adapter.take_expired(), std::vector{refused.id()});
    EXPECT_FALSE(refused.open());
    EXPECT_EQ(newer.send(frame("65 00", no_session, "01 00 00 00")), hex(failure("65 00", no_session, no_memory)));
}

TEST(Limits, Refusals_NoneAtAllMeansNotAccepted) {
    auto limits = few_connections();
    limits.refusals = 0;
    Site site(limits);
    auto first = registered(site);
    auto second = registered(site);
    EXPECT_FALSE(Peer(site).accepted());
    first.close();
    EXPECT_TRUE(Peer(site).accepted());
}

TEST(Limits, Refusals_DoNotTakeThePlacesOfOthers) {
    FullSite site;
    Peer refused(site);
    site.first.close();
    auto served = registered(site);
    EXPECT_NE(served.session(), 0U);
    EXPECT_EQ(refused.send(frame("04 00")), hex(failure("04 00", no_session, no_memory)));
}

TEST(Limits, RefusalPatience_ASilentNewcomerIsClosedAfterIt) {
    FullSite site;
    Peer silent(site);
    site.advance(999ms);
    EXPECT_TRUE(silent.open());
    EXPECT_TRUE(silent.send("65 00 04 00 00").empty());
    site.advance(1ms);
    EXPECT_FALSE(silent.open());
    EXPECT_EQ(site.expired, std::vector{silent.id()});
    EXPECT_TRUE(site.first.open());
}

TEST(Limits, RefusalPatience_WhatIsNeverAnsweredIsNotAnsweredHere) {
    for (const auto& message : {frame("00 00"), FrameText{.command = "04 00", .status = "01 00 00 00"}.text()}) {
        FullSite site;
        Peer newcomer(site);
        EXPECT_EQ(newcomer.send(message), "") << "R-ENC-8, R-ENC-10";
        EXPECT_FALSE(newcomer.open());
    }
}

TEST(Limits, Sessions_OnePastThemIsAnsweredNoMemory) {
    adapter::Limits limits;
    limits.sessions = 2;
    Site site(limits);
    auto first = registered(site);
    auto second = registered(site);
    Peer third(site);
    EXPECT_EQ(third.send(frame("65 00", no_session, "01 00 00 00")), hex(failure("65 00", no_session, no_memory)));
    EXPECT_TRUE(third.open());
    EXPECT_EQ(site.adapter.sessions(), 2U);
    first.close();
    third.register_session();
    EXPECT_EQ(site.adapter.sessions(), 2U);
}

TEST(Limits, Class3Connections_OnePastThemIsOutOfConnections) {
    adapter::Limits limits;
    limits.class3_connections = 2;
    Site site(limits);
    auto peer = registered(site);
    peer.open_class3(1);
    peer.open_class3(2);
    const auto third = cip::Request{0x54, cip::Path::to(6, 1), Peer::class3_open(3).encode()}.encode();
    EXPECT_EQ(peer.call(third), hex("D4 00 01 01 1301 0300 4D00 44332211 00 00"));
    EXPECT_EQ(site.adapter.class3_connections(), 2U);
    EXPECT_EQ(peer.call("0E 03 20 06 24 01 30 03"), hex("8E 00 00 00 01 00")) << "a reject for want of resources";
    // Closing one makes room.
    EXPECT_EQ(peer.call("4E 02 2006 2401 0A0E 0100 4D00 44332211 02 00 2002 2401"),
              hex("CE 00 00 00 0100 4D00 44332211 00 00"));
    peer.open_class3(3);
    EXPECT_EQ(site.adapter.class3_connections(), 2U);
}

TEST(Limits, QueuedBytes_NoMoreRequestsAreReadAndNothingIsLost) {
    adapter::Limits limits;
    limits.queued_bytes = 100;
    Site site(limits);
    auto peer = registered(site);
    cip::Bytes requests;
    constexpr std::size_t count = 50;
    const auto request = octets(frame("64 00"));
    for (std::size_t i = 0; i < count; ++i) {
        requests.insert(requests.end(), request.begin(), request.end());
        requests[i * request.size() + 12] = static_cast<std::uint8_t>(i);
    }
    // A reply has 26 octets: the fourth brings the queue over its limit, and the fifth request stays.
    EXPECT_EQ(site.adapter.on_octets(peer.id(), requests, site.now), 4 * request.size());
    EXPECT_EQ(site.adapter.on_octets(peer.id(), cip::ByteView(requests).subspan(4 * request.size()), site.now), 0U);
    auto rest = cip::ByteView(requests).subspan(4 * request.size());
    auto replies = site.adapter.take_replies(peer.id());
    EXPECT_EQ(replies.size(), 4U * 26);
    while (!rest.empty()) {
        const auto taken = site.adapter.on_octets(peer.id(), rest, site.now);
        ASSERT_GT(taken, 0U);
        rest = rest.subspan(taken);
        const auto batch = site.adapter.take_replies(peer.id());
        EXPECT_LE(batch.size(), limits.queued_bytes + 26);
        replies.insert(replies.end(), batch.begin(), batch.end());
    }
    ASSERT_EQ(replies.size(), count * 26);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(replies[i * 26 + 12], i);
}

TEST(Limits, MessagesPerTurn_OnePastThemWaitsForTheNextTurn) {
    adapter::Limits limits;
    limits.messages_per_turn = 3;
    Site site(limits);
    Peer peer(site);
    const auto request = octets(frame("04 00"));
    cip::Bytes requests;
    for (int i = 0; i < 4; ++i) requests.insert(requests.end(), request.begin(), request.end());
    EXPECT_EQ(site.adapter.on_octets(peer.id(), requests, site.now), 3 * request.size());
    EXPECT_EQ(site.adapter.take_replies(peer.id()).size(), 3U * 50);
    EXPECT_EQ(site.adapter.on_octets(peer.id(), request, site.now), request.size());
    EXPECT_EQ(site.adapter.take_replies(peer.id()).size(), 50U);
}

TEST(Limits, QueuedBytes_OneReplyMayReachPastThem) {
    adapter::Limits limits;
    limits.queued_bytes = 26;
    Site site(limits);
    auto peer = registered(site);
    const auto two = octets(frame("64 00") + frame("64 00"));
    EXPECT_EQ(site.adapter.on_octets(peer.id(), two, site.now), 24U);
    EXPECT_EQ(site.adapter.take_replies(peer.id()).size(), 26U);
    limits.queued_bytes = 27;
    Site wider(limits);
    auto other = registered(wider);
    EXPECT_EQ(wider.adapter.on_octets(other.id(), two, wider.now), 48U);
}

TEST(Limits, QueuedBytes_APeerThatTakesNothingIsClosedByTheInactivityTimer) {
    adapter::Limits limits;
    limits.queued_bytes = 26;
    Site site(limits);
    auto peer = registered(site);
    EXPECT_EQ(site.adapter.on_octets(peer.id(), octets(frame("64 00") + frame("64 00")), site.now), 24U);
    site.advance(120s);
    EXPECT_FALSE(peer.open());
    EXPECT_EQ(site.expired, std::vector{peer.id()});
}

// The last replies are written before the connection goes; if the peer does not take them, that must end too.
TEST(Limits, QueuedBytes_AClosingConnectionWhosePeerTakesNothingIsGivenUp) {
    Site site;
    auto peer = registered(site);
    EXPECT_FALSE(site.adapter.on_octets(peer.id(), octets(peer.text(frame("64 00") + frame("66 00", own_session))),
                                        site.now) == 0);
    EXPECT_FALSE(peer.open());
    site.advance(120s);
    EXPECT_EQ(site.expired, std::vector{peer.id()});
    EXPECT_EQ(site.adapter.next_deadline(), std::nullopt) << "and it is reported once";
}

TEST(Limits, FrameDataBytes_OnePastThemIsInvalidLength) {
    adapter::Limits limits;
    limits.frame_data_bytes = 24;
    Site site(limits);
    auto peer = registered(site);
    const std::string fits = "00000000 0000 0200 0000 0000 B200 0800 0E03 2064 2401 3000";
    EXPECT_EQ(peer.send(frame("6F 00", own_session, fits)),
              peer.text(frame("6F 00", own_session, "00000000 0000 0200 0000 0000 B200 0800 8E00 0000 14000000")));
    EXPECT_EQ(peer.send(frame("6F 00", own_session, fits + "00")),
              peer.text(failure("6F 00", own_session, "65 00 00 00")));
}

TEST(Limits, MessageBytes_ALongerReplyIs0x11) {
    adapter::Limits limits;
    limits.message_bytes = 8;
    Site site(limits);
    auto peer = registered(site);
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 08"), hex("8E 00 11 00"));
}

TEST(Limits, MessageBytes_BoundTheSizeOfAConnection) {
    adapter::Limits limits;
    limits.message_bytes = 100;
    Site site(limits);
    auto peer = registered(site);
    auto open = Peer::class3_open(1);
    const auto call = [&] { return peer.call(cip::Request{0x54, cip::Path::to(6, 1), open.encode()}.encode()); };
    open.o_to_t.size = 103;
    open.t_to_o.size = 102;
    EXPECT_EQ(call(), hex("D4 00 01 02 2701 6600 0100 4D00 44332211 00 00"));
    open.o_to_t.size = 102;
    open.t_to_o.size = 103;
    EXPECT_EQ(call(), hex("D4 00 01 02 2801 6600 0100 4D00 44332211 00 00"));
    open.t_to_o.size = 102;
    EXPECT_EQ(call().substr(0, 11), "D4 00 00 00");
}

TEST(Limits, DelayedReplies_OneBroadcastPastThemIsDropped) {
    adapter::Limits limits;
    limits.delayed_replies = 2;
    Site site(limits);
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(site.datagram(frame("63 00"), true).empty());
    site.advance(60s);
    EXPECT_EQ(site.datagrams().size(), 2U);
    site.datagram(frame("63 00"), true);
    site.advance(60s);
    EXPECT_EQ(site.datagrams().size(), 1U);
}

TEST(Limits, Inactivity_ClosesAtItAndNotBefore) {
    adapter::Limits limits;
    limits.inactivity = 3s;
    Site site(limits);
    auto peer = registered(site);
    EXPECT_EQ(peer.call("0E 03 20 F5 24 01 30 0D"), hex("8E 00 00 00 03 00"));
    EXPECT_EQ(site.adapter.next_deadline(), site.now + 3s);
    site.advance(2s + 999ms);
    EXPECT_TRUE(peer.open());
    site.advance(1ms);
    EXPECT_FALSE(peer.open());
}

// Connection ids are chosen in order and wrap; the one in use is never given again.
TEST(Limits, ConnectionIds_AreNotGivenTwice) {
    Site site;
    auto peer = registered(site);
    peer.open_class3(1);
    const auto kept = peer.connection();
    for (unsigned i = 0; i < 0x1'0010; ++i) {
        peer.open_class3(2);
        ASSERT_NE(peer.connection(), kept);
        ASSERT_EQ(peer.call("4E 02 2006 2401 0A0E 0200 4D00 44332211 00 00").substr(6, 2), "00");
    }
    EXPECT_NE(peer.connected_call(kept, 1, "0E 03 20 64 24 01 30 00"), "");
}

}  // namespace
}  // namespace servobus::test
