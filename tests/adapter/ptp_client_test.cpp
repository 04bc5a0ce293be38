// Whoever asks the PTP node of the machine, in virtual time: what he asks, how long he waits, and what is known then.
#include "adapter/ptp_client.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <vector>

#include "tests/adapter/ptp_node.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {
namespace {

using namespace std::chrono_literals;
using adapter::ManagementId;
using testing::ElementsAre;
using testing::IsEmpty;

class PtpClientTest : public testing::Test {
protected:
    /// Lets the deadline pass; the questions that are asked then.
    std::vector<cip::Bytes> wait() {
        now_ = std::max(now_, *client_.next_deadline());
        client_.on_timer(now_);
        return client_.take_messages();
    }
    /// A round: each question is answered at once. The questions.
    std::vector<cip::Bytes> round() {
        std::vector<cip::Bytes> asked;
        for (auto questions = wait(); !questions.empty(); questions = client_.take_messages()) {
            EXPECT_EQ(questions.size(), 1U) << "one after the other";
            asked.push_back(questions.front());
            client_.on_message(node_.answer(questions.front()), now_);
        }
        return asked;
    }

    FakePtpNode node_;
    adapter::TimeSync known_;
    std::vector<std::string> log_;
    enip::Time now_{1h};
    adapter::PtpClient client_{
        known_, 7, adapter::Log([this](adapter::LogLevel, std::string_view line) { log_.emplace_back(line); })};
};

TEST_F(PtpClientTest, AsksOneAfterTheOtherAndKnowsAllAfterwards) {
    EXPECT_FALSE(known_.node);
    const auto asked = round();
    const std::vector<std::pair<ManagementId, std::uint16_t>> wanted{
        {ManagementId::default_data_set, adapter::all_ports},
        {ManagementId::current_data_set, adapter::all_ports},
        {ManagementId::parent_data_set, adapter::all_ports},
        {ManagementId::time_properties_data_set, adapter::all_ports},
        {ManagementId::port_data_set, 1},
        {ManagementId::clock_description, 1}};
    ASSERT_EQ(asked.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        const auto& [id, port] = wanted[i];
        const auto sequence = static_cast<std::uint16_t>(i + 1);
        EXPECT_EQ(hex(asked[i]), hex(adapter::encode({.id = id, .port = port, .sequence = sequence, .domain = 7})));
    }
    ASSERT_TRUE(known_.node);
    EXPECT_EQ(known_.node->own.priority_2, 129);
    EXPECT_EQ(offset_from_master(*known_.node), -500ns);
    EXPECT_EQ(mean_path_delay(*known_.node), 1562ns);
    EXPECT_EQ(hex(known_.node->parent.grandmaster), hex("E6DF21FFFE788277"));
    EXPECT_EQ(known_.node->time.time_source, 0x20);
    ASSERT_EQ(known_.node->ports.size(), 1U);
    EXPECT_EQ(known_.node->ports[0].data.identity.port, 1);
    EXPECT_EQ(known_.node->ports[0].description->user_description, "Press");
    EXPECT_TRUE(has_master(*known_.node));
    EXPECT_EQ(known_.utc_offset, 37s);
    EXPECT_THAT(log_, ElementsAre("PTP: the clock follows the grandmaster e6df21.fffe.788277"));
}

TEST_F(PtpClientTest, AsksAgainAtItsInterval) {
    (void)round();
    const auto first = now_;
    EXPECT_EQ(client_.next_deadline(), first + 500ms);
    node_.told[{ManagementId::current_data_set, adapter::all_ports}] = "0002 0000000000010000 0000000000000000";
    client_.on_timer(first + 499ms);
    EXPECT_THAT(client_.take_messages(), IsEmpty());
    (void)round();
    EXPECT_EQ(now_, first + 500ms);
    EXPECT_EQ(offset_from_master(*known_.node), 1ns);
    EXPECT_EQ(log_.size(), 1U) << "nothing has changed that a log would tell";
}

TEST_F(PtpClientTest, WhatIsHalfToldIsNotKnown) {
    auto question = wait().front();
    for (int i = 0; i < 5; ++i) {
        client_.on_message(node_.answer(question), now_);
        EXPECT_FALSE(known_.node);
        question = client_.take_messages().front();
    }
    client_.on_message(node_.answer(question), now_);
    EXPECT_TRUE(known_.node);
}

TEST_F(PtpClientTest, AnAnswerToAnotherQuestionDoesNotCount) {
    const auto first = wait().front();
    auto other_sequence = node_.answer(first);
    other_sequence[31] ^= 1;
    client_.on_message(other_sequence, now_);
    auto other_id = node_.answer(first);
    other_id[53] = 0x01;
    client_.on_message(other_id, now_);
    client_.on_message(octets("0D02"), now_);
    client_.on_message({}, now_);
    EXPECT_THAT(client_.take_messages(), IsEmpty()) << "it still waits";
    client_.on_message(node_.answer(first), now_);
    EXPECT_EQ(client_.take_messages().size(), 1U);
    client_.on_message(node_.answer(first), now_);
    EXPECT_THAT(client_.take_messages(), IsEmpty()) << "the same once more";
    (void)wait();
    (void)client_.take_messages();
}

TEST_F(PtpClientTest, AnAnswerBetweenTwoRoundsDoesNotCount) {
    const auto asked = round();
    client_.on_message(node_.answer(asked.back()), now_);
    EXPECT_THAT(client_.take_messages(), IsEmpty());
    EXPECT_EQ(known_.node->ports.size(), 1U);
}

TEST_F(PtpClientTest, GivesUpAfterThreeRoundsWithoutAnAnswer) {
    (void)round();
    for (int i = 0; i < 3; ++i) {
        const auto asked = wait();
        ASSERT_EQ(asked.size(), 1U) << "it begins from the beginning";
        EXPECT_TRUE(known_.node) << i;
        EXPECT_EQ(client_.next_deadline(), now_ + 1s);
    }
    (void)wait();
    EXPECT_FALSE(known_.node);
    EXPECT_EQ(log_.back(), "the PTP node of this machine does not answer any more");
    EXPECT_EQ(known_.utc_offset, 37s) << "the time goes on as before";
    const auto lines = log_.size();
    for (int i = 0; i < 5; ++i) EXPECT_EQ(wait().size(), 1U) << "it goes on asking";
    EXPECT_EQ(log_.size(), lines) << "and says it once";
    (void)round();
    EXPECT_TRUE(known_.node);
}

TEST_F(PtpClientTest, OneRoundThatFailsIsNothing) {
    (void)round();
    (void)wait();
    (void)wait();
    (void)round();
    (void)wait();
    (void)wait();
    (void)round();
    EXPECT_TRUE(known_.node);
    EXPECT_EQ(log_.size(), 1U);
}

TEST_F(PtpClientTest, SaysNothingWhereThereHasNeverBeenANode) {
    for (int i = 0; i < 10; ++i) EXPECT_EQ(wait().size(), 1U);
    EXPECT_FALSE(known_.node);
    EXPECT_THAT(log_, IsEmpty());
}

TEST_F(PtpClientTest, ANodeThatRefusesToTellOfItselfTellsNothing) {
    for (const auto id : {ManagementId::default_data_set, ManagementId::current_data_set, ManagementId::parent_data_set,
                          ManagementId::time_properties_data_set}) {
        (void)round();
        EXPECT_TRUE(known_.node);
        const auto before = node_.told;
        node_.told.erase({id, adapter::all_ports});
        for (int i = 0; i < 3; ++i) {
            const auto began = now_;
            (void)round();
            EXPECT_EQ(now_, began + 500ms) << "a refusal is an answer: the next round is at its time";
        }
        EXPECT_FALSE(known_.node);
        node_.told = before;
    }
}

TEST_F(PtpClientTest, APortThatIsNotToldIsLeftOut) {
    node_.told[{ManagementId::default_data_set, adapter::all_ports}] =
        "00 00 0003 80 F8FEFFFF 81 5E88D9FFFE77A0B1 07 00";
    node_.told[{ManagementId::port_data_set, 3}] = "5E88D9FFFE77A0B1 0003 04 00 0000000000000000 00 03 00 01 00 02";
    (void)round();
    ASSERT_EQ(known_.node->ports.size(), 2U);
    EXPECT_EQ(known_.node->ports[0].data.identity.port, 1);
    EXPECT_EQ(known_.node->ports[1].data.identity.port, 3);
    EXPECT_TRUE(known_.node->ports[0].description);
    EXPECT_FALSE(known_.node->ports[1].description);
}

TEST_F(PtpClientTest, AsksForSixteenPortsAndNoMore) {
    for (const unsigned ports : {16U, 17U, 65535U}) {
        node_.told[{ManagementId::default_data_set, adapter::all_ports}] =
            fmt::format("00 00 {:04X} 80 F8FEFFFF 81 5E88D9FFFE77A0B1 07 00", ports);
        EXPECT_EQ(round().size(), 4U + 2 * 16) << ports;
    }
}

TEST_F(PtpClientTest, R_TSY_3_TheOffsetToUtcIsThatOfTheLastMaster) {
    (void)round();
    EXPECT_EQ(known_.utc_offset, 37s);
    // The master is gone, and the node is alone with its own UTC.
    node_.told[{ManagementId::port_data_set, 1}] = "5E88D9FFFE77A0B1 0001 04 00 0000000000000000 FE 03 FD 01 00 02";
    node_.told[{ManagementId::time_properties_data_set, adapter::all_ports}] = "0025 00 A0";
    (void)round();
    EXPECT_FALSE(has_master(*known_.node));
    EXPECT_EQ(log_.back(), "PTP: the clock follows no master any more");
    EXPECT_EQ(known_.utc_offset, 37s);
    // A master whose time scale is its own.
    node_.told[{ManagementId::port_data_set, 1}] = "5E88D9FFFE77A0B1 0001 09 00 0000000000000000 FE 03 FD 01 00 02";
    (void)round();
    EXPECT_EQ(known_.utc_offset, 0s);
}

}  // namespace
}  // namespace servobus::test
