// Which state is written when, and what is safe.
#include "adapter/state_keeper.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace servobus::adapter {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

StoredState named(const std::string& host_name) {
    StoredState state;
    state.network.host_name = host_name;
    return state;
}

/// Its states are told apart by their host names.
class Keeping : public testing::Test {
protected:
    Keeping() {
        keeper_.write_with([this](const StoredState& state) { written_.push_back(state.network.host_name); });
    }
    void change(const std::string& host_name) { keeper_.change(named(host_name)); }
    std::string newest() const { return keeper_.newest().network.host_name; }
    std::string durable() const { return keeper_.durable().network.host_name; }

    StateKeeper keeper_{named("old")};
    std::vector<std::string> written_;
};

TEST_F(Keeping, AChangeIsWrittenAndThenSafe) {
    EXPECT_FALSE(keeper_.waits());
    change("a");
    EXPECT_THAT(written_, ElementsAre("a"));
    EXPECT_TRUE(keeper_.waits());
    EXPECT_FALSE(keeper_.is_settled(keeper_.generation()));
    EXPECT_EQ(durable(), "old");
    keeper_.on_stored(true);
    EXPECT_FALSE(keeper_.waits());
    EXPECT_TRUE(keeper_.is_settled(keeper_.generation()));
    EXPECT_EQ(durable(), "a");
}

TEST_F(Keeping, WhatIsAsBeforeIsNotWritten) {
    change("old");
    EXPECT_THAT(written_, IsEmpty());
    EXPECT_FALSE(keeper_.waits());
}

TEST_F(Keeping, ManyChangesDuringAWriteAreOneMore) {
    change("a");
    const auto first = keeper_.generation();
    for (int i = 0; i < 1000; ++i) change(std::to_string(i));
    const auto last = keeper_.generation();
    EXPECT_THAT(written_, ElementsAre("a"));
    keeper_.on_stored(true);
    EXPECT_TRUE(keeper_.is_settled(first));
    EXPECT_FALSE(keeper_.is_settled(last));
    EXPECT_THAT(written_, ElementsAre("a", "999"));
    keeper_.on_stored(true);
    EXPECT_TRUE(keeper_.is_settled(last));
    EXPECT_THAT(written_, ElementsAre("a", "999"));
}

TEST_F(Keeping, AChangeThatIsUndoneDuringAWriteIsWrittenAsWell) {
    change("a");
    change("old");
    keeper_.on_stored(true);
    EXPECT_TRUE(keeper_.waits()) << "the file says a";
    EXPECT_THAT(written_, ElementsAre("a", "old"));
}

TEST_F(Keeping, AChangeThatIsMadeAgainDuringItsWriteNeedsNoOther) {
    change("a");
    change("b");
    change("a");
    keeper_.on_stored(true);
    EXPECT_FALSE(keeper_.waits());
    EXPECT_THAT(written_, ElementsAre("a"));
}

TEST_F(Keeping, AWriteThatFailsTakesAllWithItThatWasNotSafe) {
    change("a");
    keeper_.on_stored(true);
    change("b");
    change("c");
    keeper_.on_stored(false);
    EXPECT_EQ(newest(), "a");
    EXPECT_EQ(durable(), "a");
    EXPECT_FALSE(keeper_.waits()) << "nobody waits for what is lost";
    EXPECT_THAT(written_, ElementsAre("a", "b"));
    change("d");
    EXPECT_THAT(written_, ElementsAre("a", "b", "d"));
}

TEST_F(Keeping, APowerCutLeavesWhatAWriteHasBegunFor) {
    change("a");
    change("b");
    keeper_.cut_power();
    EXPECT_EQ(newest(), "a");
    keeper_.on_stored(true);
    EXPECT_FALSE(keeper_.waits());
    EXPECT_THAT(written_, ElementsAre("a"));
    EXPECT_EQ(durable(), "a");
}

TEST_F(Keeping, APowerCutDuringAWriteThatFailsLeavesWhatWasSafe) {
    change("a");
    keeper_.cut_power();
    keeper_.on_stored(false);
    EXPECT_EQ(newest(), "old");
}

TEST_F(Keeping, AnAnswerThatNobodyWaitsForChangesNothing) {
    keeper_.on_stored(true);
    keeper_.on_stored(false);
    EXPECT_EQ(newest(), "old");
    EXPECT_FALSE(keeper_.waits());
}

TEST(KeepingInMemory, EverythingIsSafeAtOnce) {
    StateKeeper keeper(named("old"));
    keeper.change(named("a"));
    EXPECT_FALSE(keeper.waits());
    EXPECT_EQ(keeper.durable(), named("a"));
    keeper.cut_power();
    EXPECT_EQ(keeper.newest(), named("a"));
}

}  // namespace
}  // namespace servobus::adapter
