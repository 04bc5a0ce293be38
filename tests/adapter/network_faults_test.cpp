// What becomes of datagrams, replies and opens under faults, in virtual time and with a seed.
#include "adapter/network_faults.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/octets.hpp"

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;
using enip::Time;
using testing::ElementsAre;
using testing::IsEmpty;
using Kind = fault::DisturbIo::Kind;
using Direction = fault::Direction;

constexpr Time start{1000s};
constexpr enip::Endpoint peer{0x7F000001, 2222};

/// The datagram `number` of a connection.
cip::Bytes datagram(unsigned number, std::uint8_t connection = 1) {
    cip::Bytes bytes(18);
    bytes[6] = connection;
    bytes[10] = static_cast<std::uint8_t>(number);
    bytes[11] = static_cast<std::uint8_t>(number >> 8);
    return bytes;
}
unsigned number_of(cip::ByteView octets) { return octets[10] | static_cast<unsigned>(octets[11]) << 8; }

class Faults : public testing::Test {
protected:
    bool begin(const NetworkFault& fault) { return faults.begin(fault, now); }

    /// The numbers of those that count when this one comes.
    std::vector<unsigned> come(unsigned number, std::uint8_t connection = 1) {
        std::vector<unsigned> seen;
        faults.advance(now);
        if (faults.filter_in(peer, datagram(number, connection), now)) seen.push_back(number);
        for (const auto late : late_in()) seen.push_back(late);
        return seen;
    }
    std::vector<unsigned> late_in() {
        std::vector<unsigned> seen;
        while (const auto arrival = faults.take_in(now)) {
            EXPECT_EQ(arrival->peer, peer);
            seen.push_back(number_of(arrival->octets));
        }
        return seen;
    }
    /// The numbers of those that leave when these are produced.
    std::vector<unsigned> go(const std::vector<unsigned>& numbers = {}, std::uint8_t connection = 1) {
        faults.advance(now);
        enip::IoQueue queue;
        for (const auto number : numbers) {
            const auto octets = datagram(number, connection);
            std::ranges::copy(octets, queue.add({{}, peer}, octets.size()).begin());
        }
        faults.filter_out(queue, now);
        std::vector<unsigned> seen;
        for (const auto& entry : queue.entries()) {
            EXPECT_EQ(entry.route.peer, peer);
            seen.push_back(number_of(queue.octets(entry)));
        }
        return seen;
    }

    NetworkFaults faults{1};
    Time now = start;
};

TEST_F(Faults, WithoutAFaultEverythingGoesBy) {
    EXPECT_THAT(come(1), ElementsAre(1));
    EXPECT_THAT(go({1, 2}), ElementsAre(1, 2));
    EXPECT_EQ(faults.next_deadline(), std::nullopt);
    EXPECT_EQ(faults.active(), 0U);
    EXPECT_EQ(faults.reply_delay(), 0us);
    EXPECT_EQ(faults.refuse_open(), std::nullopt);
    EXPECT_EQ(faults.bus_time(now), now);
}

TEST_F(Faults, DropsInOneDirectionAlone) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::drop, .direction = Direction::o_to_t}));
    EXPECT_THAT(come(1), IsEmpty());
    EXPECT_THAT(go({1}), ElementsAre(1));
    ASSERT_TRUE(begin(fault::RestoreNetwork{}));
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::drop, .direction = Direction::t_to_o}));
    EXPECT_THAT(come(2), ElementsAre(2));
    EXPECT_THAT(go({2}), IsEmpty());
    EXPECT_EQ(faults.in().dropped, 1U);
    EXPECT_EQ(faults.out().dropped, 1U);
}

TEST_F(Faults, DropsAShare) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::drop, .share = 0.3}));
    std::size_t passed = 0;
    for (unsigned i = 0; i < 10'000; ++i) passed += come(i).size();
    EXPECT_NEAR(static_cast<double>(passed), 7'000, 200);
    EXPECT_EQ(passed + faults.in().dropped, 10'000U);
}

TEST_F(Faults, AShareOf0IsNone) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::drop, .share = 0}));
    for (unsigned i = 0; i < 1'000; ++i) EXPECT_THAT(come(i), ElementsAre(i));
}

TEST_F(Faults, EndsAfterSoManyOrAfterItsTime) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::drop, .direction = Direction::o_to_t, .count = 2}));
    EXPECT_THAT(come(1), IsEmpty());
    EXPECT_THAT(go({1}), ElementsAre(1)) << "the other direction is not counted";
    EXPECT_THAT(come(2), IsEmpty());
    EXPECT_THAT(come(3), ElementsAre(3));
    EXPECT_EQ(faults.active(), 0U);
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::drop, .seconds = 0.5}));
    now += 499'999us;
    EXPECT_THAT(come(4), IsEmpty());
    now += 1us;
    EXPECT_THAT(come(5), ElementsAre(5));
    EXPECT_EQ(faults.active(), 0U);
}

TEST_F(Faults, TheSameSeedHasTheSameFates) {
    const auto fates = [](std::uint64_t seed) {
        NetworkFaults own(seed);
        EXPECT_TRUE(own.begin(fault::DisturbIo{.kind = Kind::drop, .share = 0.5}, start));
        std::string text;
        for (unsigned i = 0; i < 64; ++i) text += own.filter_in(peer, datagram(i), start) ? '1' : '0';
        return text;
    };
    EXPECT_EQ(fates(7), fates(7));
    EXPECT_NE(fates(7), fates(8));
}

TEST_F(Faults, DelaysAndSaysWhenToLook) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::delay, .milliseconds = 3}));
    EXPECT_THAT(come(1), IsEmpty());
    EXPECT_EQ(faults.next_deadline(), start + 3ms);
    now += 1ms;
    EXPECT_THAT(go({7}), IsEmpty());
    now += 1ms;
    EXPECT_THAT(come(2), IsEmpty());
    now += 1ms;
    EXPECT_THAT(late_in(), ElementsAre(1));
    EXPECT_THAT(go(), IsEmpty());
    EXPECT_EQ(faults.next_deadline(), start + 4ms);
    now += 1ms;
    EXPECT_THAT(go(), ElementsAre(7));
    EXPECT_EQ(faults.next_deadline(), start + 5ms);
    now += 10ms;
    EXPECT_THAT(late_in(), ElementsAre(2));
    EXPECT_EQ(faults.next_deadline(), std::nullopt);
    EXPECT_EQ(faults.in().delayed, 2U);
    EXPECT_EQ(faults.out().delayed, 1U);
}

TEST_F(Faults, JitterOvertakes) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::delay, .milliseconds = 1, .jitter = 20}));
    std::vector<unsigned> seen;
    for (unsigned i = 0; i < 200; ++i) {
        for (const auto number : come(i)) seen.push_back(number);
        now += 1ms;
    }
    now += 21ms;
    for (const auto number : late_in()) seen.push_back(number);
    ASSERT_EQ(seen.size(), 200U) << "none is lost";
    EXPECT_FALSE(std::ranges::is_sorted(seen));
    for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_NEAR(static_cast<double>(seen[i]), static_cast<double>(i), 21);
}

TEST_F(Faults, Duplicates) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::duplicate}));
    EXPECT_THAT(come(1), ElementsAre(1, 1));
    EXPECT_THAT(go({1, 2}), ElementsAre(1, 1, 2, 2));
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::delay, .milliseconds = 1}));
    EXPECT_THAT(come(2), IsEmpty());
    now += 1ms;
    EXPECT_THAT(late_in(), ElementsAre(2, 2)) << "faults work together";
}

TEST_F(Faults, ReordersInsideAConnection) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::reorder, .count = 1}));
    EXPECT_THAT(come(1), IsEmpty());
    EXPECT_THAT(come(9, 2), ElementsAre(9)) << "of another connection";
    EXPECT_THAT(come(2), ElementsAre(2, 1));
    EXPECT_THAT(come(3), ElementsAre(3));
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::reorder, .count = 1}));
    EXPECT_THAT(go({1, 2, 3}), ElementsAre(2, 1, 3));
}

TEST_F(Faults, OneThatNobodyOvertakesComesInTheEnd) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::reorder, .count = 1}));
    EXPECT_THAT(come(1), IsEmpty());
    EXPECT_EQ(faults.next_deadline(), start + NetworkFaults::reorder_patience);
    now += NetworkFaults::reorder_patience;
    EXPECT_THAT(late_in(), ElementsAre(1));
}

TEST_F(Faults, ShortDatagramsAreOfNoConnection) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::reorder}));
    for (std::size_t size = 0; size < 10; ++size) EXPECT_FALSE(faults.filter_in(peer, cip::Bytes(size), now));
    now += NetworkFaults::reorder_patience;
    std::size_t count = 0;
    while (faults.take_in(now)) ++count;
    EXPECT_EQ(count, 10U);
}

TEST_F(Faults, HoldsNoMoreThanItsLimit) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::delay, .milliseconds = 1}));
    for (unsigned i = 0; i <= NetworkFaults::max_held; ++i) EXPECT_THAT(come(i), IsEmpty());
    EXPECT_EQ(faults.in().overflowed, 1U);
    now += 1ms;
    EXPECT_EQ(late_in().size(), NetworkFaults::max_held);
}

TEST_F(Faults, TakesNoMoreFaultsThanItsLimit) {
    for (std::size_t i = 0; i < NetworkFaults::max_active; ++i) {
        ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::drop, .seconds = 1}));
    }
    EXPECT_FALSE(begin(fault::DisturbIo{.kind = Kind::drop}));
    EXPECT_FALSE(begin(fault::DisturbReplies{}));
    EXPECT_FALSE(begin(fault::RefuseOpen{}));
    EXPECT_TRUE(begin(fault::CutCable{1})) << "there is one cable";
    now += 1s;
    EXPECT_TRUE(begin(fault::DisturbIo{.kind = Kind::drop})) << "those are over";
}

TEST_F(Faults, ACutCableIsSilent) {
    ASSERT_TRUE(begin(fault::DisturbIo{.kind = Kind::delay, .milliseconds = 5, .count = 1}));
    EXPECT_THAT(come(1), IsEmpty());
    ASSERT_TRUE(begin(fault::CutCable{0.01}));
    EXPECT_TRUE(faults.is_silent());
    EXPECT_FALSE(faults.is_frozen());
    EXPECT_FALSE(faults.is_down());
    EXPECT_THAT(come(2), IsEmpty());
    EXPECT_THAT(go({1, 2}), IsEmpty());
    now += 5ms;
    EXPECT_THAT(late_in(), IsEmpty()) << "what was on its way is lost";
    EXPECT_EQ(faults.bus_time(now), now);
    EXPECT_EQ(faults.next_deadline(), start + 10ms);
    now = start + 10ms;
    faults.advance(now);
    EXPECT_FALSE(faults.is_silent());
    EXPECT_THAT(come(3), ElementsAre(3));
    EXPECT_EQ(faults.in().silenced, 2U);
    EXPECT_EQ(faults.out().silenced, 2U);
}

TEST_F(Faults, ASilenceWithoutEndIsEndedByHand) {
    ASSERT_TRUE(begin(fault::CutCable{0}));
    EXPECT_EQ(faults.next_deadline(), std::nullopt);
    now += 1h;
    EXPECT_THAT(come(1), IsEmpty());
    ASSERT_TRUE(begin(fault::CutCable{1})) << "and not by another one";
    now += 1h;
    EXPECT_THAT(come(1), IsEmpty());
    ASSERT_TRUE(begin(fault::RestoreNetwork{}));
    EXPECT_THAT(come(1), ElementsAre(1));
}

TEST_F(Faults, TheLongerSilenceCounts) {
    ASSERT_TRUE(begin(fault::CutCable{2}));
    ASSERT_TRUE(begin(fault::CutCable{1}));
    EXPECT_EQ(faults.next_deadline(), start + 2s);
    now += 1s;
    ASSERT_TRUE(begin(fault::CutCable{3}));
    EXPECT_EQ(faults.next_deadline(), start + 4s);
}

TEST_F(Faults, InAFreezeTheTimeOfTheBusStandsStill) {
    ASSERT_TRUE(begin(fault::Freeze{0.05}));
    EXPECT_TRUE(faults.is_frozen() && faults.is_silent());
    now += 20ms;
    faults.advance(now);
    EXPECT_EQ(faults.bus_time(now), start);
    now += 40ms;
    faults.advance(now);
    EXPECT_FALSE(faults.is_frozen());
    EXPECT_EQ(faults.bus_time(now), start + 10ms) << "however late somebody looks";
    EXPECT_EQ(faults.true_time(start + 10ms), now);
    ASSERT_TRUE(begin(fault::Freeze{0}));
    now += 1s;
    ASSERT_TRUE(begin(fault::RestoreNetwork{}));
    EXPECT_EQ(faults.bus_time(now), now - 1050ms);
}

TEST_F(Faults, ARestartHasAPause) {
    ASSERT_TRUE(begin(fault::Restart{2}));
    EXPECT_TRUE(faults.is_down() && faults.is_silent());
    EXPECT_THAT(come(1), IsEmpty());
    now += 2s;
    faults.advance(now);
    EXPECT_FALSE(faults.is_down());
    ASSERT_TRUE(begin(fault::Restart{0}));
    EXPECT_FALSE(faults.is_down()) << "no pause";
}

TEST_F(Faults, RepliesAreLateOrNever) {
    ASSERT_TRUE(begin(fault::DisturbReplies{fault::DisturbReplies::Kind::delay, 250, 2}));
    EXPECT_EQ(faults.reply_delay(), 250ms);
    ASSERT_TRUE(begin(fault::DisturbReplies{fault::DisturbReplies::Kind::delay, 50, 1}));
    EXPECT_EQ(faults.reply_delay(), 300ms);
    EXPECT_EQ(faults.reply_delay(), 0ms);
    ASSERT_TRUE(begin(fault::DisturbReplies{fault::DisturbReplies::Kind::withhold, 0, 1}));
    EXPECT_EQ(faults.reply_delay(), std::nullopt);
    EXPECT_EQ(faults.reply_delay(), 0ms);
    EXPECT_EQ(faults.replies().delayed, 3U);
    EXPECT_EQ(faults.replies().withheld, 1U);
}

TEST_F(Faults, OpensAreRefusedInTurn) {
    ASSERT_TRUE(begin(fault::RefuseOpen{2, 1, 0x0113}));
    ASSERT_TRUE(begin(fault::RefuseOpen{1, 2, 0}));
    const cip::Status full(cip::GeneralStatus::connection_failure, {0x0113});
    EXPECT_EQ(faults.refuse_open(), full);
    EXPECT_EQ(faults.refuse_open(), full);
    EXPECT_EQ(faults.refuse_open(), cip::Status(cip::GeneralStatus::resource_unavailable));
    EXPECT_EQ(faults.refuse_open(), std::nullopt);
    EXPECT_EQ(faults.replies().opens_refused, 3U);
}

}  // namespace
}  // namespace servobus::adapter
