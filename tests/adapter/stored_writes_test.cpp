// Writes to a device whose state is made durable elsewhere: when they are answered, and what becomes of those that fail.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/adapter/fake_machine.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

using adapter::StoredState;
using testing::Contains;
using testing::HasSubstr;

constexpr std::string_view set_s_curve = "10 03 20 64 24 01 30 00 32 00 00 00";
constexpr std::string_view get_s_curve = "0E 03 20 64 24 01 30 00";
constexpr std::string_view set_target = "10 03 20 66 24 01 30 3A 05 00 00 00";
constexpr std::string_view set_dscp = "10 03 20 48 24 01 30 04 2E";
constexpr std::string_view get_dscp = "0E 03 20 48 24 01 30 04";
const std::string set_done = hex("90 00 00 00");
const std::string not_stored = hex("90 00 19 00");
const std::string s_curve_of_50 = hex("8E 00 00 00 32 00 00 00");
const std::string s_curve_of_20 = hex("8E 00 00 00 14 00 00 00");

class StoredWrites : public testing::Test {
protected:
    StoredWrites() { keep(site_); }
    void keep(Site& site) {
        site.adapter.store_with([this](const StoredState& state) { written_.push_back(state); });
    }

    /// What has become ready for a connection meanwhile.
    std::vector<std::string> arrived(Peer& peer) {
        std::vector<std::string> messages;
        auto rest = site_.adapter.take_replies(peer.id());
        while (!rest.empty()) {
            const auto size = std::min<std::size_t>(rest.size(), 24U + rest[2] + 256U * rest[3]);
            const auto frame = enip::Frame::parse(cip::ByteView(rest).first(size));
            const auto data = frame ? enip::SendData::parse(frame->data) : cip::DecodeError::truncated;
            if (!data) return {"no message in a reply"};
            if (const auto connected = enip::connected_message(*data)) {
                messages.push_back(hex(connected->message));
            } else if (const auto message = enip::unconnected_message(*data)) {
                messages.push_back(hex(*message));
            }
            rest.erase(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(size));
        }
        return messages;
    }
    void stored(bool ok = true) { site_.adapter.on_stored(ok, site_.now); }

    using Messages = std::vector<std::string>;

    std::vector<StoredState> written_;
    Site site_;
    Peer peer_ = registered(site_);
};

TEST_F(StoredWrites, AreAnsweredWhenTheyAreDurable) {
    EXPECT_EQ(peer_.call(set_s_curve), "");
    ASSERT_EQ(written_.size(), 1U);
    EXPECT_EQ(written_[0].parameters, (drive::StoredValues{{{0x64, 0x00}, 0, std::int64_t{50}}}));
    site_.advance(10s);
    EXPECT_EQ(arrived(peer_), Messages{});
    stored();
    EXPECT_THAT(site_.adapter.take_ready(), Contains(peer_.id()));
    EXPECT_EQ(arrived(peer_), Messages{set_done});
}

TEST_F(StoredWrites, OfTheNetworkObjectsAreToo) {
    EXPECT_EQ(peer_.call(set_dscp), "");
    ASSERT_EQ(written_.size(), 1U);
    EXPECT_EQ(written_[0].network.qos.dscp[0], 0x2E);
    stored();
    EXPECT_EQ(arrived(peer_), Messages{set_done});
}

TEST_F(StoredWrites, AreNotThoseOfSetPointsAndReads) {
    EXPECT_EQ(peer_.call(set_target), set_done);
    EXPECT_EQ(peer_.call(get_s_curve), s_curve_of_20);
    EXPECT_EQ(peer_.call(set_s_curve), "");
    auto other = registered(site_, 0xC0A80202);
    EXPECT_EQ(other.call(get_s_curve), s_curve_of_50) << "nobody else waits for a read";
    EXPECT_EQ(written_.size(), 1U);
}

TEST_F(StoredWrites, ThatChangeNothingAreAnsweredAtOnce) {
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 14 00 00 00"), set_done);
    EXPECT_TRUE(written_.empty());
}

TEST_F(StoredWrites, OfWhatSomebodyElseIsStoringWaitForThat) {
    EXPECT_EQ(peer_.call(set_s_curve), "");
    auto other = registered(site_, 0xC0A80202);
    EXPECT_EQ(other.call(set_s_curve), "") << "it is the same, and not durable yet";
    stored();
    EXPECT_EQ(arrived(peer_), Messages{set_done});
    EXPECT_EQ(arrived(other), Messages{set_done});
    EXPECT_EQ(written_.size(), 1U);
}

TEST_F(StoredWrites, ThatComeDuringAWriteGoWithTheNextOne) {
    auto other = registered(site_, 0xC0A80202);
    EXPECT_EQ(peer_.call(set_s_curve), "");
    EXPECT_EQ(other.call("10 03 20 64 24 01 30 00 33 00 00 00"), "");
    EXPECT_EQ(other.call("10 03 20 64 24 01 30 00 34 00 00 00"), "");
    stored();
    EXPECT_EQ(arrived(peer_), Messages{set_done});
    EXPECT_EQ(arrived(other), Messages{});
    ASSERT_EQ(written_.size(), 2U);
    EXPECT_EQ(written_[1].parameters, (drive::StoredValues{{{0x64, 0x00}, 0, std::int64_t{0x34}}}));
    stored();
    EXPECT_EQ(arrived(other), (Messages{set_done, set_done}));
    EXPECT_EQ(written_.size(), 2U);
}

TEST_F(StoredWrites, KeepTheOrderOfTheReplies) {
    EXPECT_EQ(peer_.call(set_s_curve), "");
    EXPECT_EQ(peer_.call(get_s_curve), "") << "behind the one that waits";
    stored();
    EXPECT_EQ(arrived(peer_), (Messages{set_done, s_curve_of_50}));
    EXPECT_EQ(peer_.call(get_s_curve), s_curve_of_50);
}

TEST_F(StoredWrites, HoldUpNoDeadline) {
    site_.adapter.on_timer(site_.now);
    const auto before = site_.adapter.next_deadline();
    EXPECT_EQ(peer_.call(set_s_curve), "");
    EXPECT_EQ(site_.adapter.next_deadline(), before) << "no time says when it will be durable";
}

TEST_F(StoredWrites, ThatFailAreTakenBackAndRefusedWith0x19) {
    EXPECT_EQ(peer_.call(set_s_curve), "");
    EXPECT_EQ(peer_.call(set_dscp), "");
    EXPECT_EQ(peer_.call(get_s_curve), "");
    stored(false);
    EXPECT_EQ(arrived(peer_), (Messages{not_stored, not_stored, s_curve_of_50}));
    EXPECT_EQ(peer_.call(get_s_curve), s_curve_of_20);
    EXPECT_EQ(peer_.call(get_dscp), hex("8E 00 00 00 37"));
    EXPECT_THAT(site_.log, Contains(HasSubstr("could not be stored")));
    EXPECT_EQ(written_.size(), 1U);
    EXPECT_EQ(peer_.call("0E 03 20 01 24 01 30 05"), hex("8E 00 00 00 3000")) << "not configured";
}

TEST_F(StoredWrites, ThatFailLeaveWhatWasDurableBefore) {
    EXPECT_EQ(peer_.call(set_s_curve), "");
    stored();
    EXPECT_EQ(arrived(peer_), Messages{set_done});
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 33 00 00 00"), "");
    stored(false);
    EXPECT_EQ(arrived(peer_), Messages{not_stored});
    EXPECT_EQ(peer_.call(get_s_curve), s_curve_of_50);
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 33 00 00 00"), "") << "and may be tried again";
    stored();
    EXPECT_EQ(arrived(peer_), Messages{set_done});
}

TEST_F(StoredWrites, ThatFailTellTheMachine) {
    Site site({}, device_with_fake_machine());
    keep(site);
    auto peer = registered(site);
    EXPECT_EQ(peer.call(set_s_curve), "");
    fake_machine().rows.clear();
    site.adapter.on_stored(false, site.now);
    EXPECT_EQ(fake_machine().rows, (std::vector{drive::Key{0x64, 0x00}}));
}

TEST_F(StoredWrites, InOneOfSeveralServicesFailAsAWhole) {
    const std::string both = "0A 02 20 02 24 01 0200 0600 1200";
    EXPECT_EQ(peer_.call(both + std::string(set_s_curve) + std::string(get_s_curve)), "");
    stored(false);
    EXPECT_EQ(arrived(peer_), Messages{hex("8A 00 19 00")});
    EXPECT_EQ(peer_.call(both + std::string(set_s_curve) + std::string(get_s_curve)), "");
    stored();
    EXPECT_EQ(arrived(peer_), Messages{hex("8A 00 00 00 0200 0600 0A00" + set_done + s_curve_of_50)});
}

TEST_F(StoredWrites, OverAClass3ConnectionAreTheSame) {
    peer_.open_class3();
    EXPECT_EQ(peer_.connected_call(1, set_s_curve), "");
    EXPECT_EQ(peer_.connected_call(1, set_s_curve), "") << "asked again before the reply";
    stored(false);
    EXPECT_EQ(arrived(peer_), (Messages{not_stored, not_stored}));
    EXPECT_EQ(peer_.connected_call(1, set_s_curve), not_stored) << "R-CON-46: it is not carried out again";
    EXPECT_EQ(peer_.connected_call(2, set_s_curve), "");
    stored();
    EXPECT_EQ(arrived(peer_), Messages{set_done});
    EXPECT_EQ(peer_.connected_call(2, set_s_curve), set_done);
}

TEST_F(StoredWrites, OfAConnectionThatHasGoneAreStoredAllTheSame) {
    {
        auto other = registered(site_, 0xC0A80202);
        EXPECT_EQ(other.call(set_s_curve), "");
    }
    stored();
    EXPECT_EQ(peer_.call(get_s_curve), s_curve_of_50);
    EXPECT_EQ(site_.adapter.kept(), written_.back());
    EXPECT_FALSE(site_.adapter.is_storing());
}

TEST_F(StoredWrites, FewerThanALimitWaitOnOneConnection) {
    for (int i = 0; i < 1024; ++i) EXPECT_EQ(peer_.call(i % 2 == 0 ? set_s_curve : set_dscp), "");
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 33 00 00 00"), "encapsulation status 0x0002");
    EXPECT_EQ(peer_.call(get_s_curve), "encapsulation status 0x0002");
    EXPECT_EQ(site_.adapter.kept().parameters, (drive::StoredValues{{{0x64, 0x00}, 0, std::int64_t{50}}}))
        << "it was not carried out";
    stored();
    stored();
    EXPECT_EQ(arrived(peer_).size(), 1024U);
    EXPECT_EQ(peer_.call(get_s_curve), s_curve_of_50);
}

TEST_F(StoredWrites, WaitForADelayThatIsOnPurposeAsWell) {
    ASSERT_TRUE(
        site_.adapter.inject(adapter::NetworkFault(adapter::fault::DisturbReplies{.milliseconds = 500}), site_.now));
    EXPECT_EQ(peer_.call(set_s_curve), "");
    stored();
    EXPECT_EQ(arrived(peer_), Messages{});
    site_.advance(500ms);
    EXPECT_EQ(arrived(peer_), Messages{set_done});
}

TEST_F(StoredWrites, AreThereAfterThePowerHasBeenCut) {
    EXPECT_EQ(peer_.call(set_s_curve), "");
    stored();
    (void)arrived(peer_);
    site_.adapter.inject(drive::event::PowerCycle{}, site_.now);
    auto next = registered(site_);
    EXPECT_EQ(next.call(get_s_curve), s_curve_of_50);
}

TEST_F(StoredWrites, ThatNoWriteHasBegunForAreLostWithThePowerAndNotAnswered) {
    auto other = registered(site_, 0xC0A80202);
    EXPECT_EQ(peer_.call(set_s_curve), "");
    EXPECT_EQ(other.call(set_dscp), "");
    site_.adapter.inject(drive::event::PowerCycle{}, site_.now);
    stored();
    EXPECT_EQ(arrived(peer_), Messages{});
    EXPECT_EQ(arrived(other), Messages{});
    auto next = registered(site_);
    EXPECT_EQ(next.call(get_s_curve), s_curve_of_50) << "its write had begun";
    EXPECT_EQ(next.call(get_dscp), hex("8E 00 00 00 37"));
    EXPECT_EQ(written_.size(), 1U);
}

TEST_F(StoredWrites, AreThoseOfTheDriveItselfToo) {
    Site site({}, device_with_fake_machine());
    keep(site);
    fake_machine().deadline = drive::Time(1h) + 1ms;
    fake_machine().on_step = [](drive::Time now) -> std::optional<drive::Time> {
        return now < drive::Time(1h) + 3ms ? std::optional(now + 1ms) : std::nullopt;
    };
    site.adapter.on_timer(site.now);
    const auto* limit = site.device.find({0x65, 0x72});
    site.device.store().variable(*limit).set(4711);  // as MLC finds it, in the middle of its motion
    EXPECT_TRUE(written_.empty());
    site.advance(5ms);
    ASSERT_EQ(written_.size(), 1U);
    EXPECT_EQ(written_[0].parameters, (drive::StoredValues{{{0x65, 0x72}, 0, std::int64_t{4711}}}));
}

TEST_F(StoredWrites, AreThoseOfTheNetworkItselfToo) {
    site_.adapter.network().settings.last_conflict[0] = 2;
    site_.adapter.on_timer(site_.now);
    ASSERT_EQ(written_.size(), 1U);
    EXPECT_EQ(written_[0].network.last_conflict[0], 2);
}

TEST(PowerUp, WithWhatWasKept) {
    Site site;
    StoredState kept = site.adapter.delivered();
    kept.network.qos.dscp[0] = 0x2E;
    kept.parameters = {{{0x64, 0x00}, 0, std::int64_t{50}}};
    std::vector<StoredState> written;
    site.adapter.store_with([&](const StoredState& state) { written.push_back(state); });
    site.adapter.power_up_with(kept);
    auto peer = registered(site);
    EXPECT_EQ(peer.call(get_s_curve), s_curve_of_50);
    EXPECT_EQ(peer.call(get_dscp), hex("8E 00 00 00 2E"));
    EXPECT_EQ(peer.call("0E 03 20 01 24 01 30 05"), hex("8E 00 00 00 3400"));
    EXPECT_EQ(peer.call(set_s_curve), set_done) << "it is so already";
    EXPECT_TRUE(written.empty());
}

/// Resets of a device whose state is made durable elsewhere (R-ID-8).
class StoredResets : public StoredWrites {
protected:
    StoredResets() {
        EXPECT_EQ(peer_.call(set_s_curve), "");
        EXPECT_EQ(peer_.call(set_dscp), "");
        stored();
        stored();
        (void)arrived(peer_);
        written_.clear();
    }
    void expect_after_restart(const std::string& s_curve, std::string_view dscp) {
        EXPECT_FALSE(peer_.open());
        auto next = registered(site_);
        EXPECT_EQ(next.call(get_s_curve), s_curve);
        EXPECT_EQ(next.call(get_dscp), hex("8E 00 00 00" + std::string(dscp)));
    }
};

TEST_F(StoredResets, Type0LeavesAll) {
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    site_.advance(100ms);
    expect_after_restart(s_curve_of_50, "2E");
    EXPECT_TRUE(written_.empty());
}

TEST_F(StoredResets, Type1IsAnsweredWhenTheDefaultsAreDurableAndRestarts100MillisecondsLater) {
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 01"), "");
    ASSERT_EQ(written_.size(), 1U);
    EXPECT_EQ(written_[0], site_.adapter.delivered());
    site_.advance(5s);
    EXPECT_TRUE(peer_.open());
    stored();
    EXPECT_EQ(arrived(peer_), Messages{hex("85 00 00 00")});
    site_.advance(99ms);
    EXPECT_TRUE(peer_.open());
    site_.advance(1ms);
    expect_after_restart(s_curve_of_20, "37");
    EXPECT_EQ(written_.size(), 1U);
}

TEST_F(StoredResets, Type2KeepsTheNetwork) {
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 02"), "");
    ASSERT_EQ(written_.size(), 1U);
    EXPECT_TRUE(written_[0].parameters.empty());
    EXPECT_EQ(written_[0].network.qos.dscp[0], 0x2E);
    stored();
    site_.advance(100ms);
    expect_after_restart(s_curve_of_20, "2E");
}

TEST_F(StoredResets, OfDefaultsThatAreThereNeedNoWrite) {
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 01"), "");
    stored();
    site_.advance(100ms);
    auto next = registered(site_);
    EXPECT_EQ(next.call("05 02 20 01 24 01 01"), hex("85 00 00 00"));
    EXPECT_EQ(written_.size(), 1U);
}

TEST_F(StoredResets, ThatCannotBeMadeDurableDoNotHappen) {
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 01"), "");
    stored(false);
    EXPECT_EQ(arrived(peer_), Messages{hex("85 00 19 00")});
    site_.advance(5s);
    EXPECT_TRUE(peer_.open());
    EXPECT_EQ(peer_.call(get_s_curve), s_curve_of_50);
    EXPECT_EQ(peer_.call(get_dscp), hex("8E 00 00 00 2E"));
}

TEST_F(StoredResets, TakeWithThemWhatIsWrittenMeanwhile) {
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 01"), "");
    stored();
    EXPECT_EQ(arrived(peer_), Messages{hex("85 00 00 00")});
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 33 00 00 00"), set_done);
    site_.advance(100ms);
    expect_after_restart(s_curve_of_20, "37");
    EXPECT_EQ(written_.size(), 1U);
}

TEST_F(StoredResets, OfAnotherTypeAreRefusedUntilTheFirstHasHappened) {
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 01"), hex("85 00 10 00"));
    site_.advance(100ms);
    expect_after_restart(s_curve_of_50, "2E");
}

TEST_F(StoredResets, FollowWritesThatWereAskedForBefore) {
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 33 00 00 00"), "");
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 00"), "");
    site_.advance(1s);
    EXPECT_TRUE(peer_.open());
    stored();
    EXPECT_EQ(arrived(peer_), (Messages{set_done, hex("85 00 00 00")}));
    site_.advance(100ms);
    expect_after_restart(hex("8E 00 00 00 33 00 00 00"), "2E");
}

TEST_F(StoredResets, HappenAtOnceWhenThePowerIsCut) {
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 01"), "");
    site_.adapter.inject(drive::event::PowerCycle{}, site_.now);
    expect_after_restart(s_curve_of_20, "37");
    stored();
    EXPECT_FALSE(site_.adapter.is_storing());
}

}  // namespace
}  // namespace servobus::test
