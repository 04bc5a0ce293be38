// I/O connections of a device whose state is being made durable: they go on, and what they write is not kept.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/adapter/io_site.hpp"

namespace servobus::test {
namespace {

using adapter::StoredState;
using testing::IsEmpty;

constexpr std::string_view set_s_curve = "10 03 20 64 24 01 30 00 32 00 00 00";

/// Target 0, speed, acceleration and S-curve as given, no control word.
cip::Bytes outputs_with_speed(std::uint32_t speed) {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    for (const auto value : {0U, speed, 1'000'000U, 20U}) writer.u32(value);
    writer.u16(0);
    return bytes;
}

class StoredIo : public testing::Test {
protected:
    StoredIo() {
        site_.adapter.store_with([this](const StoredState& state) { written_.push_back(state); });
    }

    std::vector<StoredState> written_;
    IoSite site_;
    IoPeer peer_{site_};
};

TEST_F(StoredIo, GoesOnInItsTimeWhileAWriteWaits) {
    const auto link = peer_.must_open(every(io_open(1), 1000));
    std::uint32_t sequence = 0;
    const auto exchange = [&] {
        ++sequence;
        peer_.send(o_to_t(link, sequence, static_cast<std::uint16_t>(sequence), run, outputs_with_speed(1000)));
        site_.advance(1ms);
    };
    for (int i = 0; i < 10; ++i) exchange();
    EXPECT_EQ(peer_.call(set_s_curve), "") << "its reply waits";
    ASSERT_EQ(written_.size(), 1U);
    (void)site_.take();
    const auto begin = site_.now;
    for (int i = 0; i < 500; ++i) exchange();
    const auto sent = site_.take();
    ASSERT_EQ(sent.size(), 500U);
    for (std::size_t i = 1; i < sent.size(); ++i) EXPECT_EQ(sent[i].at - sent[i - 1].at, 1ms) << i;
    EXPECT_LE(sent.front().at - begin, 1ms);
    EXPECT_EQ(site_.adapter.io().size(), 1U) << "no timeout";
    EXPECT_TRUE(site_.adapter.is_storing());
}

TEST_F(StoredIo, WritesNothingThatIsKept) {
    const auto link = peer_.must_open(io_open(1));
    for (std::uint32_t i = 1; i <= 100; ++i) {
        peer_.send(o_to_t(link, i, static_cast<std::uint16_t>(i), run, outputs_with_speed(1000 + i)));
        site_.advance(5ms);
    }
    EXPECT_EQ(site_.value("SpeedJogOrProfilePositionMode"), 1100) << "it is in force";
    EXPECT_THAT(written_, IsEmpty());
    (void)peer_.close(link);
    EXPECT_EQ(peer_.call(set_s_curve), "");
    ASSERT_EQ(written_.size(), 1U);
    EXPECT_EQ(written_[0].parameters, (drive::StoredValues{{{0x64, 0x00}, 0, std::int64_t{50}}}))
        << "and not when something else is written either";
}

TEST_F(StoredIo, LeavesWhatWasWrittenBefore) {
    EXPECT_EQ(peer_.call("10 03 20 66 24 01 30 41 88 13 00 00"), "") << "speed 5000";
    site_.adapter.on_stored(true, site_.now);
    IoPeer owner(site_, 0xC0A80202);
    const auto link = owner.must_open(io_open(1));
    owner.send(o_to_t(link, 1, 1, run, outputs_with_speed(1000)));
    EXPECT_EQ(site_.value("SpeedJogOrProfilePositionMode"), 1000);
    site_.adapter.inject(drive::event::PowerCycle{}, site_.now);
    EXPECT_EQ(site_.value("SpeedJogOrProfilePositionMode"), 5000);
    EXPECT_EQ(written_.size(), 1U);
}

TEST_F(StoredIo, ASetOfAnOutputAssemblyIsProcessDataToo) {
    const auto message = octets("10 03 20 04 24 65 30 03") + outputs_with_speed(1000);
    EXPECT_EQ(peer_.call(message), hex("90 00 00 00"));
    EXPECT_EQ(site_.value("SpeedJogOrProfilePositionMode"), 1000);
    EXPECT_THAT(written_, IsEmpty());
}

}  // namespace
}  // namespace servobus::test
