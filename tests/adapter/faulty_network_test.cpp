// A whole device under network faults, in virtual time: what its peers see of them, and what the drive does.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "adapter/network_fault.hpp"
#include "cip/services.hpp"
#include "enip/io_packet.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
namespace fault = adapter::fault;
using Kind = fault::DisturbIo::Kind;
using Direction = fault::Direction;

constexpr enip::Endpoint originator{0xC0A80201, enip::io_port};
constexpr enip::Endpoint io_local{0xC0A80264, enip::io_port};
constexpr std::string_view get_vendor = "0E 03 20 01 24 01 30 01";
constexpr std::string_view vendor = "8E 00 00 00 6D 05";

/// A drive that is owned through 101/100 by point-to-point, every 10 ms, and times out after 40 ms.
class FaultyNetwork : public testing::Test {
protected:
    FaultyNetwork() { peer.register_session(); }

    static cip::ForwardOpen standard() {
        cip::ForwardOpen open;
        open.t_to_o_id = 0x0A110001;
        open.triad = {7, 0x004D, 0x11223344};
        open.o_to_t_rpi = open.t_to_o_rpi = 10'000;
        open.o_to_t.priority = open.t_to_o.priority = cip::Priority::scheduled;
        open.o_to_t.size = 24;
        open.t_to_o.size = 30;
        open.transport = {false, 0, 1};
        open.path = octets("20 04 24 01 2C 65 2C 64");
        return open;
    }
    /// General status and the first extended word of the reply.
    std::string open() {
        const auto request = cip::Request{0x54, cip::Path::to(6, 1), standard().encode()}.encode();
        const auto reply = octets(peer.call(request));
        if (reply.size() < 4) return "no reply";
        if (reply[2] == 0) o_to_t_id = cip::Reader(cip::ByteView(reply).subspan(4)).u32();
        return hex(cip::ByteView(reply).subspan(2, std::size_t{2} + 2U * std::min<std::size_t>(reply[3], 1)));
    }
    void opened() { ASSERT_EQ(open(), "00 00"); }

    void send_output() {
        ++sequence;
        cip::Bytes datagram(enip::io_packet_overhead + 24);
        const auto data = enip::begin_io_packet(datagram, o_to_t_id, sequence);
        const auto image = octets("0000 01000000 00000000 50C30000 40420F00 14000000 0600");
        std::ranges::copy(image, data.begin());
        data[0] = static_cast<std::uint8_t>(sequence);
        site.adapter.on_io(originator, io_local, datagram, site.now);
    }
    /// The encapsulation sequence numbers of what has been sent.
    std::vector<std::uint32_t> produced() {
        std::vector<std::uint32_t> numbers;
        auto& queue = site.adapter.io_queue();
        for (const auto& entry : queue.entries()) {
            EXPECT_EQ(entry.route.peer, originator);
            numbers.push_back(enip::IoPacket::parse(queue.octets(entry)).value().sequence);
        }
        queue.clear();
        return numbers;
    }
    /// Both sides send every 10 ms for so long.
    void run(int cycles) {
        for (int i = 0; i < cycles; ++i) {
            send_output();
            site.advance(10ms);
        }
    }
    bool inject(const adapter::Happening& event) { return site.adapter.inject(event, site.now); }
    bool is_open() const { return site.adapter.io().size() == 1; }
    const enip::IoConsumer& consumer() const { return site.adapter.io().all().front()->consumer; }
    /// Replies of the peer's connection that have become ready by themselves.
    std::string late_replies() {
        const auto ready = site.adapter.take_ready();
        if (std::ranges::count(ready, peer.id()) == 0) return "";
        return hex(site.adapter.take_replies(peer.id()));
    }

    Site site{{}, drive::Device(drive::xenax_models().front(), drive::Machine{})};
    Peer peer{site};
    std::uint32_t o_to_t_id = 0;
    std::uint32_t sequence = 0;
};

TEST_F(FaultyNetwork, DroppedInputsLeaveAGap) {
    opened();
    run(3);
    const auto before = produced();
    ASSERT_THAT(before, SizeIs(3));
    ASSERT_TRUE(inject(fault::DisturbIo{.kind = Kind::drop, .direction = Direction::t_to_o, .count = 2}));
    run(4);
    const auto last = before.back();
    EXPECT_THAT(produced(), ElementsAre(last + 3, last + 4)) << "the numbers go on";
    ASSERT_TRUE(is_open());
    EXPECT_EQ(consumer().counters().lost, 0U) << "the other direction is as it was";
    EXPECT_THAT(site.log, Contains("event: drop-io direction=t_to_o share=1 count=2 seconds=0"));
}

TEST_F(FaultyNetwork, DroppedOutputsAreMissedAndEndTheConnectionInTheEnd) {
    opened();
    run(3);
    ASSERT_TRUE(inject(fault::DisturbIo{.kind = Kind::drop, .direction = Direction::o_to_t, .count = 2}));
    run(4);
    ASSERT_TRUE(is_open());
    EXPECT_EQ(consumer().counters().lost, 2U);
    ASSERT_TRUE(inject(fault::DisturbIo{.kind = Kind::drop, .direction = Direction::o_to_t}));
    run(4);
    EXPECT_FALSE(is_open()) << "4 times 10 ms";
    EXPECT_THAT(site.log, Contains(HasSubstr("timed out")));
}

TEST_F(FaultyNetwork, DelayedOutputsAreNotStale) {
    opened();
    ASSERT_TRUE(inject(fault::DisturbIo{.kind = Kind::delay, .direction = Direction::o_to_t, .milliseconds = 25}));
    run(10);
    ASSERT_TRUE(is_open());
    EXPECT_EQ(consumer().counters().stale, 0U);
    EXPECT_EQ(consumer().counters().accepted, 8U) << "two are on their way";
}

TEST_F(FaultyNetwork, DelayedInputsLeaveLater) {
    opened();
    ASSERT_TRUE(inject(fault::DisturbIo{.kind = Kind::delay, .direction = Direction::t_to_o, .milliseconds = 15}));
    run(2);
    EXPECT_THAT(produced(), SizeIs(1));
    run(1);
    EXPECT_THAT(produced(), SizeIs(1));
}

TEST_F(FaultyNetwork, DuplicatesAndReorderedOnesAreCountedAndChangeNothing) {
    opened();
    run(1);
    ASSERT_TRUE(inject(fault::DisturbIo{.kind = Kind::duplicate, .direction = Direction::o_to_t, .count = 2}));
    run(2);
    EXPECT_EQ(consumer().counters().stale, 2U);
    EXPECT_EQ(consumer().counters().accepted, 3U);
    ASSERT_TRUE(inject(fault::DisturbIo{.kind = Kind::reorder, .direction = Direction::o_to_t, .count = 1}));
    run(3);
    EXPECT_EQ(consumer().counters().stale, 3U) << "the one that was overtaken";
    EXPECT_EQ(consumer().counters().lost, 1U);
    EXPECT_TRUE(is_open());
    produced();
    ASSERT_TRUE(inject(fault::DisturbIo{.kind = Kind::reorder, .direction = Direction::t_to_o, .count = 1}));
    run(3);
    const auto numbers = produced();
    ASSERT_THAT(numbers, SizeIs(3));
    EXPECT_EQ(numbers[0], numbers[1] + 1);
}

TEST_F(FaultyNetwork, ACutCableTimesTheOwnerOut) {
    opened();
    run(3);
    produced();
    ASSERT_TRUE(inject(fault::CutCable{0.1}));
    EXPECT_EQ(peer.call(get_vendor), "") << "TCP is silent as well";
    EXPECT_THAT(site.datagram(frame("63 00")), IsEmpty()) << "and so is UDP 44818";
    run(4);
    EXPECT_THAT(produced(), IsEmpty());
    EXPECT_FALSE(is_open());
    EXPECT_EQ(late_replies(), "");
    site.advance(60ms);
    EXPECT_THAT(late_replies(), HasSubstr(std::string(vendor))) << "what TCP had to send again";
    EXPECT_EQ(peer.call(get_vendor), vendor);
    EXPECT_EQ(open(), "00 00");
}

TEST_F(FaultyNetwork, APeerThatTalksIntoTheSilenceIsBounded) {
    ASSERT_TRUE(inject(fault::CutCable{0}));
    const cip::Bytes much(16 * 1024, 0);
    EXPECT_TRUE(peer.exchange(much).empty());
    EXPECT_TRUE(peer.open());
    EXPECT_TRUE(peer.exchange(cip::Bytes(1)).empty());
    EXPECT_FALSE(peer.open());
}

TEST_F(FaultyNetwork, RestoredByHandEverythingIsAnsweredAtOnce) {
    ASSERT_TRUE(inject(fault::CutCable{0}));
    EXPECT_EQ(peer.call(get_vendor), "");
    site.advance(30s);
    EXPECT_EQ(late_replies(), "");
    ASSERT_TRUE(inject(fault::RestoreNetwork{}));
    EXPECT_THAT(late_replies(), HasSubstr(std::string(vendor)));
}

TEST_F(FaultyNetwork, AFrozenDeviceDoesNotTimeOut) {
    opened();
    run(3);
    produced();
    ASSERT_TRUE(inject(fault::Freeze{5}));
    EXPECT_EQ(peer.call(get_vendor), "");
    site.advance(4999ms);
    EXPECT_THAT(produced(), IsEmpty());
    EXPECT_TRUE(is_open());
    site.advance(1ms);
    EXPECT_THAT(late_replies(), HasSubstr(std::string(vendor)));
    run(3);
    ASSERT_TRUE(is_open());
    EXPECT_THAT(produced(), SizeIs(3)) << "and no burst for what it has missed";
    EXPECT_EQ(site.adapter.io().all().front()->production->producer.counters().skipped, 0U);
    for (int i = 0; i < 4; ++i) site.advance(10ms);
    EXPECT_FALSE(is_open()) << "afterwards it counts again";
}

TEST_F(FaultyNetwork, TheAxisGoesOnInAFreeze) {
    ASSERT_TRUE(inject(fault::Freeze{5}));
    ASSERT_TRUE(inject(drive::event::PushAxis{5}));
    site.advance(1s);
    EXPECT_NE(std::get<std::int64_t>(site.device.store().value(*site.device.find({0x66, 0x24}))), 0);
}

TEST_F(FaultyNetwork, RepliesAreLateAndKeepTheirOrder) {
    ASSERT_TRUE(inject(fault::DisturbReplies{fault::DisturbReplies::Kind::delay, 200, 1}));
    EXPECT_EQ(peer.call(get_vendor), "");
    EXPECT_EQ(peer.call("0E 03 20 01 24 01 30 02"), "") << "behind the late one";
    site.advance(199ms);
    EXPECT_EQ(late_replies(), "");
    site.advance(1ms);
    const auto replies = late_replies();
    const auto first = replies.find(vendor);
    const auto second = replies.find("8E 00 00 00 2B 00");
    ASSERT_NE(first, std::string::npos);
    ASSERT_NE(second, std::string::npos);
    EXPECT_LT(first, second);
    EXPECT_EQ(peer.call(get_vendor), vendor);
}

TEST_F(FaultyNetwork, AWithheldReplyHasBeenCarriedOut) {
    ASSERT_TRUE(inject(fault::DisturbReplies{fault::DisturbReplies::Kind::withhold, 0, 1}));
    EXPECT_EQ(open(), "no reply");
    EXPECT_TRUE(is_open());
    EXPECT_EQ(open(), "01 01 00 01") << "duplicate Forward_Open";
    EXPECT_EQ(site.adapter.faults().replies().withheld, 1U);
}

TEST_F(FaultyNetwork, SessionsCanBeRegisteredWhileRepliesAreWithheld) {
    ASSERT_TRUE(inject(fault::DisturbReplies{fault::DisturbReplies::Kind::withhold}));
    Peer other(site);
    other.register_session();
    EXPECT_EQ(other.call(get_vendor), "");
}

TEST_F(FaultyNetwork, OpensAreRefusedWithTheChosenStatus) {
    ASSERT_TRUE(inject(fault::RefuseOpen{2, 1, 0x0113}));
    EXPECT_EQ(open(), "01 01 13 01");
    EXPECT_EQ(open(), "01 01 13 01");
    EXPECT_FALSE(is_open());
    EXPECT_EQ(open(), "00 00");
    ASSERT_TRUE(inject(fault::RefuseOpen{1, 2, 0}));
    EXPECT_EQ(open(), "02 00");
}

TEST_F(FaultyNetwork, SessionsAreClosedOneOrAll) {
    opened();
    auto second = registered(site, 0xC0A80202);
    Peer without(site, 0xC0A80203);
    ASSERT_TRUE(inject(fault::CloseSessions{second.session()}));
    EXPECT_TRUE(peer.open());
    EXPECT_FALSE(second.open());
    EXPECT_THAT(site.adapter.take_expired(), ElementsAre(second.id()));
    ASSERT_TRUE(inject(fault::CloseSessions{}));
    EXPECT_FALSE(peer.open());
    EXPECT_TRUE(without.open()) << "it has no session";
    peer.close();
    run(10);
    EXPECT_TRUE(is_open()) << "class 1 outlives its session (R-ENC-25)";
}

TEST_F(FaultyNetwork, ARestartForgetsEverythingAndIsAwayForAWhile) {
    opened();
    run(3);
    produced();
    ASSERT_TRUE(inject(fault::Restart{2}));
    EXPECT_FALSE(peer.open());
    EXPECT_FALSE(is_open());
    EXPECT_FALSE(Peer(site).accepted()) << "nobody is there";
    site.advance(1999ms);
    EXPECT_FALSE(Peer(site).accepted());
    EXPECT_THAT(produced(), IsEmpty());
    site.advance(1ms);
    auto again = registered(site);
    EXPECT_EQ(again.call(get_vendor), vendor);
}

TEST_F(FaultyNetwork, FaultsComeByTimetableToo) {
    Site other{{}, drive::Device(drive::xenax_models().front(), drive::Machine{})};
    adapter::Timetable timetable;
    timetable.entries.push_back({drive::Time(1s), adapter::NetworkFault(fault::CutCable{1})});
    other.adapter.play(timetable);
    other.adapter.on_timer(other.now);
    auto speaker = registered(other);
    EXPECT_EQ(speaker.call(get_vendor), vendor);
    other.advance(1s);
    EXPECT_EQ(speaker.call(get_vendor), "");
    other.advance(1s);
    EXPECT_EQ(other.adapter.take_ready().size(), 1U);
}

TEST_F(FaultyNetwork, TheSameSeedLosesTheSameDatagrams) {
    const auto numbers = [](std::uint64_t seed) {
        FaultyNetwork_TheSameSeedLosesTheSameDatagrams_Test own;
        own.site.adapter.seed_faults(seed);
        own.opened();
        EXPECT_TRUE(own.inject(fault::DisturbIo{.kind = Kind::drop, .direction = Direction::t_to_o, .share = 0.5}));
        own.run(40);
        return own.produced();
    };
    EXPECT_EQ(numbers(5), numbers(5));
    EXPECT_NE(numbers(5), numbers(6));
}

TEST_F(FaultyNetwork, ThereIsALimit) {
    for (std::size_t i = 0; i < adapter::NetworkFaults::max_active; ++i) {
        ASSERT_TRUE(inject(fault::RefuseOpen{1, 1, 0x0113}));
    }
    EXPECT_FALSE(inject(fault::RefuseOpen{1, 1, 0x0113}));
    EXPECT_THAT(site.log, Contains("there are 64 network faults already; this one is left out"));
}

}  // namespace
}  // namespace servobus::test
