// From packets to connections: who opened what, what was answered, what flowed.
#include <gtest/gtest.h>

#include "cip/unconnected_send.hpp"
#include "tests/scanner/sample_capture.hpp"

namespace servobus::scanner {
namespace {

using namespace test;

const cip::Bytes& golden(std::string_view name) { return servobus::test::find_golden_vector(name)->octets; }

CapturedPacket packet(CapturedPacket::Transport transport, enip::Endpoint source, enip::Endpoint destination,
                      cip::ByteView payload, std::uint32_t sequence = 0, CaptureTime time = capture_begin) {
    CapturedPacket made;
    made.time = time;
    made.transport = transport;
    made.source = source;
    made.destination = destination;
    made.payload = payload;
    made.sequence = sequence;
    return made;
}

/// Octets of the originator's stream.
CapturedPacket segment(std::uint32_t sequence, cip::ByteView payload) {
    return packet(CapturedPacket::Transport::tcp, originator, target, payload, sequence);
}

TEST(Conversation, PairsOpensDataAndCloses) {
    SampleCapture sample;
    sample.golden(5);
    const auto capture = test::read(sample.text());
    const auto& opens = capture.conversation.opens();
    ASSERT_EQ(opens.size(), 3U);
    const auto& open = opens[0];
    EXPECT_EQ(open.originator, originator);
    EXPECT_EQ(open.target, target);
    ASSERT_TRUE(open.granted());
    EXPECT_EQ(open.reply->o_to_t_id, 0x56A00001U);
    EXPECT_EQ(open.expected_receiver(), (enip::Endpoint{0xEFC00D60, enip::io_port}));
    EXPECT_EQ(open.o_to_t.packets, 4U);
    EXPECT_EQ(open.o_to_t.sizes, (std::map<std::size_t, std::uint64_t>{{24, 4}}));
    EXPECT_EQ(open.o_to_t.header_run, 2U + (4U - 2U - open.o_to_t.header_idle));
    EXPECT_EQ(open.o_to_t.repeated, 2U) << "R-IO-5: the repeat, and the return to run under the old count";
    EXPECT_EQ(open.t_to_o.packets, 2U);
    EXPECT_EQ(open.t_to_o.statistics.granted(), 10ms);
    EXPECT_TRUE(open.closing);
    EXPECT_EQ(open.close_status, cip::Status());
    EXPECT_EQ(opens[1].status, cip::Status(cip::ConnectionFailure::duplicate_forward_open));
    EXPECT_EQ(opens[2].status, cip::Status(cip::ConnectionFailure::ownership_conflict));
    EXPECT_EQ(capture.conversation.counters().io_without_open, 0U);
}

TEST(Conversation, TakesTheReceiverFromTheSockaddrItem) {
    SampleCapture sample;
    sample.golden(6);
    const auto capture = test::read(sample.text());
    const auto& opens = capture.conversation.opens();
    ASSERT_EQ(opens.size(), 1U);
    ASSERT_TRUE(opens[0].wanted_receiver);
    EXPECT_EQ(opens[0].expected_receiver(), (enip::Endpoint{originator.address, opens[0].wanted_receiver->port}));
    EXPECT_EQ(opens[0].t_to_o.packets, 1U);
}

TEST(Conversation, LooksIntoUnconnectedSends) {
    const auto frame = enip::Frame::parse(golden("fo_bad_o2t_size_req")).value();
    const auto data = enip::SendData::parse(frame.data).value();
    const auto message = enip::unconnected_message(data).value();
    cip::UnconnectedSend send;
    send.message.assign(message.begin(), message.end());
    send.route_path = octets("01 02");
    auto routed = frame;
    routed.data =
        enip::SendData::unconnected(cip::Request{0x52, cip::Path::to(0x06, 1), send.encode()}.encode()).encode();
    SampleCapture sample;
    sample.say(true, routed.encode());
    sample.say(false, golden("fo_bad_o2t_size_rep"));
    // A router that cannot pass it on answers for itself.
    sample.say(true, routed.encode());
    sample.say(false, frame
                          .reply(enip::EncapsulationStatus::success,
                                 enip::SendData::unconnected(
                                     cip::Response{0x52, cip::ConnectionFailure::link_address_not_valid, {0}}.encode())
                                     .encode())
                          .encode());
    const auto capture = test::read(sample.text());
    const auto& opens = capture.conversation.opens();
    ASSERT_EQ(opens.size(), 2U);
    EXPECT_EQ(opens[0].route, octets("01 02"));
    EXPECT_EQ(opens[0].status.extended, (std::vector<std::uint16_t>{0x0127, 24}));
    EXPECT_EQ(opens[1].status, cip::Status(cip::ConnectionFailure::link_address_not_valid));
}

TEST(Conversation, RepliesWithTheSameContextComeInOrder) {
    SampleCapture sample;
    const auto without_context = [](const char* name) {
        auto frame = enip::Frame::parse(golden(name)).value();
        frame.context = {};
        return frame.encode();
    };
    sample.say(true, without_context("fo_bad_o2t_size_req"));
    sample.say(true, without_context("fo_bad_t2o_size_req"));
    sample.say(false, without_context("fo_bad_o2t_size_rep"));
    sample.say(false, without_context("fo_bad_t2o_size_rep"));
    const auto capture = test::read(sample.text());
    ASSERT_EQ(capture.conversation.opens().size(), 2U);
    EXPECT_EQ(capture.conversation.opens()[0].status.extended.at(0), 0x0127);
    EXPECT_EQ(capture.conversation.opens()[1].status.extended.at(0), 0x0128);
}

TEST(Conversation, KnowsWhoANodeSaysItIs) {
    SampleCapture sample;
    sample.golden(3);
    const auto capture = test::read(sample.text());
    const auto* identity = capture.conversation.identity(target.address);
    ASSERT_NE(identity, nullptr);
    EXPECT_EQ(identity->vendor, 1389);
    EXPECT_EQ(capture.conversation.identity(originator.address), nullptr);
}

TEST(Conversation, CountsLostLateAndForeignDatagrams) {
    SampleCapture sample;
    sample.golden(6);
    const auto data = cip::Bytes(28);
    for (const std::uint32_t sequence : {2U, 3U, 6U, 6U, 5U}) {
        sample.io(false, io_datagram(0x5AFE0001, sequence, data));
        sample.wait(10ms);
    }
    const auto before = test::read(sample.text()).conversation.opens().at(0);
    const auto id = before.reply->t_to_o_id;
    for (const std::uint32_t sequence : {2U, 3U, 6U, 6U, 5U}) {
        sample.io(false, io_datagram(id, sequence, data));
        sample.wait(10ms);
    }
    sample.io(true, io_datagram(id, 9, data));  // the right id from the wrong side
    sample.io(false, octets("00 00"));
    const auto capture = test::read(sample.text());
    EXPECT_EQ(capture.conversation.counters().io_without_open, 5U + 1);
    EXPECT_EQ(capture.conversation.counters().io_malformed, 1U);
    const auto& flow = capture.conversation.opens().at(0).t_to_o;
    EXPECT_EQ(flow.packets, 6U);
    const auto& counters = flow.statistics.counters();
    EXPECT_EQ(counters.lost, 1U) << "number 4: 5 came after all";
    EXPECT_EQ(counters.duplicated, 1U);
    EXPECT_EQ(counters.reordered, 1U);
}

class Stream : public testing::Test {
protected:
    void take(std::uint32_t sequence, cip::ByteView payload) { stream_.take(segment(sequence, payload), sink_); }

    TcpStream stream_;
    std::size_t messages_ = 0;
    TcpStream::Sink sink_ = [this](const enip::Frame&, CaptureTime) { ++messages_; };
    cip::Bytes message_ = golden("fo_eo_101_100_mcast_req");
};

TEST_F(Stream, PutsSegmentsInOrder) {
    const cip::ByteView view(message_);
    take(100, view.first(30));
    take(150, view.subspan(50));
    take(100, view.first(30));
    take(120, view.subspan(20, 30));
    EXPECT_EQ(messages_, 1U);
    EXPECT_EQ(stream_.counters().reordered, 1U);
    EXPECT_EQ(stream_.counters().repeated, 1U);
    EXPECT_EQ(stream_.counters().gaps, 0U);
}

TEST_F(Stream, SequenceNumbersWrap) {
    const cip::ByteView view(message_);
    take(0xFFFFFFF0, view.first(30));
    take(14, view.subspan(30));
    EXPECT_EQ(messages_, 1U);
}

TEST_F(Stream, GoesOnBehindAGapAtTheNextMessage) {
    const cip::ByteView view(message_);
    take(0, view.first(30));
    take(5000, view.subspan(40));  // the end of a message whose beginning is lost
    take(static_cast<std::uint32_t>(5000 + view.size() - 40), view);
    EXPECT_EQ(messages_, 0U);
    stream_.finish(sink_);
    EXPECT_EQ(messages_, 1U);
    EXPECT_EQ(stream_.counters().gaps, 1U);
    EXPECT_EQ(stream_.counters().skipped, 1U);
}

TEST_F(Stream, GivesUpOnWhatDoesNotCome) {
    take(0, message_);
    const auto size = static_cast<std::uint32_t>(message_.size());
    for (std::uint32_t i = 0; i <= TcpStream::max_waiting; ++i) {
        EXPECT_EQ(messages_, 1U);
        take(10'000 + i * size, message_);
    }
    EXPECT_EQ(messages_, 1 + TcpStream::max_waiting + 1);
    EXPECT_EQ(stream_.counters().gaps, 1U);
}

TEST_F(Stream, BeginsInTheMiddle) {
    take(77, octets("01 02 03"));
    take(80, message_);
    EXPECT_EQ(messages_, 1U);
    EXPECT_EQ(stream_.counters().skipped, 1U);
}

TEST(Conversation, KeepsItsLimits) {
    Conversation conversation;
    const auto& request = golden("fo_bad_point_req");
    std::uint32_t sequence = 0;
    for (std::size_t i = 0; i < Conversation::max_opens + 2;
         ++i, sequence += static_cast<std::uint32_t>(request.size())) {
        conversation.take(segment(sequence, request));
    }
    EXPECT_EQ(conversation.opens().size(), Conversation::max_opens);
    EXPECT_EQ(conversation.counters().opens_left_out, 2U);
    for (std::uint32_t host = 1; host <= Conversation::max_streams; ++host) {
        conversation.take(packet(CapturedPacket::Transport::tcp, {host, 4000}, target, request));
    }
    EXPECT_EQ(conversation.counters().streams_left_out, 1U) << "one was there before";
}

}  // namespace
}  // namespace servobus::scanner
