// The frame decoder keeps its place in a byte stream, however it is cut and whatever is in it.
#include "enip/frame_decoder.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/octets.hpp"

namespace servobus::enip {
namespace {

using cip::Bytes;
using cip::ByteView;
using test::hex;
using test::operator+;

Bytes nop(std::size_t length, std::uint8_t fill = 0x55) {
    return Frame{.command = Command::nop, .data = Bytes(length, fill)}.encode();
}

Bytes list_services() { return Frame{.command = Command::list_services}.encode(); }

const FrameDecoder::Result& at(const FrameDecoder::Result* message) {
    static const FrameDecoder::Result none;
    EXPECT_NE(message, nullptr);
    return message != nullptr ? *message : none;
}

/// All messages of a stream that arrives in pieces of `size` octets.
std::vector<FrameDecoder::Result> decode(FrameDecoder& decoder, ByteView stream, std::size_t size) {
    std::vector<FrameDecoder::Result> messages;
    while (!stream.empty()) {
        auto piece = stream.first(std::min(size, stream.size()));
        stream = stream.subspan(piece.size());
        while (!piece.empty()) {
            const auto before = piece.size();
            if (auto message = decoder.next(piece)) {
                messages.push_back(std::move(*message));
            } else {
                EXPECT_TRUE(piece.empty()) << "without a message everything has been taken";
            }
            if (piece.size() == before) {
                ADD_FAILURE() << "the decoder takes nothing";
                return messages;
            }
        }
    }
    return messages;
}

TEST(FrameDecoder, R_ENC_3_one_message_in_one_piece) {
    FrameDecoder decoder;
    const auto stream = nop(2);
    ByteView rest = stream;
    EXPECT_FALSE(decoder.partial());
    const auto message = decoder.next(rest);
    ASSERT_TRUE(message);
    EXPECT_FALSE(message->oversize);
    EXPECT_EQ(hex(message->frame.encode()), hex(stream));
    EXPECT_TRUE(rest.empty());
    EXPECT_FALSE(decoder.partial());
}

TEST(FrameDecoder, R_ENC_3_a_message_without_data_is_complete_with_its_header) {
    FrameDecoder decoder;
    const auto stream = list_services();
    ByteView rest = stream;
    EXPECT_EQ(at(decoder.next(rest)).frame.command, Command::list_services);
}

TEST(FrameDecoder, R_ENC_3_several_messages_in_one_segment_are_taken_one_by_one) {
    FrameDecoder decoder;
    const auto stream = nop(2) + list_services() + nop(1);
    ByteView rest = stream;
    EXPECT_EQ(at(decoder.next(rest)).frame.data.size(), 2U);
    EXPECT_EQ(rest.size(), 24U + 25U) << "what follows is left where it is";
    EXPECT_EQ(at(decoder.next(rest)).frame.command, Command::list_services);
    EXPECT_EQ(at(decoder.next(rest)).frame.data.size(), 1U);
    EXPECT_EQ(decoder.next(rest), nullptr);
}

TEST(FrameDecoder, R_ENC_3_nothing_of_a_message_is_left_in_the_one_that_follows) {
    FrameDecoder decoder;
    const Frame first{Command::send_rr_data,    7, EncapsulationStatus::invalid_length,
                      {1, 2, 3, 4, 5, 6, 7, 8}, 9, {1, 2}};
    const auto stream = first.encode() + list_services();
    ByteView rest = stream;
    EXPECT_EQ(at(decoder.next(rest)).frame, first);
    EXPECT_EQ(at(decoder.next(rest)).frame, Frame{.command = Command::list_services});
}

TEST(FrameDecoder, R_ENC_3_any_cut_of_a_stream_gives_the_same_messages) {
    const auto stream = nop(2, 0xAA) + list_services() + nop(70, 0xBB) + list_services() + nop(0) + nop(1, 0xCC);
    for (std::size_t size = 1; size <= stream.size(); ++size) {
        FrameDecoder decoder;
        Bytes again;
        for (const auto& message : decode(decoder, stream, size)) {
            EXPECT_FALSE(message.oversize);
            message.frame.write(again);
        }
        ASSERT_EQ(hex(again), hex(stream)) << "in pieces of " << size;
        EXPECT_FALSE(decoder.partial());
    }
}

TEST(FrameDecoder, R_ENC_3_is_partial_between_the_first_octet_and_the_last) {
    FrameDecoder decoder;
    const auto stream = nop(3);
    for (std::size_t i = 0; i < stream.size(); ++i) {
        EXPECT_EQ(decoder.partial(), i > 0) << i;
        auto octet = ByteView(stream).subspan(i, 1);
        EXPECT_EQ(decoder.next(octet) != nullptr, i + 1 == stream.size()) << i;
    }
    EXPECT_FALSE(decoder.partial());
}

TEST(FrameDecoder, R_ENC_3_nothing_in_nothing_out) {
    FrameDecoder decoder;
    ByteView none;
    EXPECT_EQ(decoder.next(none), nullptr);
    EXPECT_FALSE(decoder.partial());
}

TEST(FrameDecoder, R_ENC_3_the_limit_is_held_and_one_past_it_is_oversize) {
    FrameDecoder decoder(10);
    const auto stream = nop(10) + nop(11) + nop(9);
    const auto messages = decode(decoder, stream, stream.size());
    ASSERT_EQ(messages.size(), 3U);
    EXPECT_FALSE(messages[0].oversize);
    EXPECT_EQ(messages[0].frame.data.size(), 10U);
    EXPECT_TRUE(messages[1].oversize);
    EXPECT_TRUE(messages[1].frame.data.empty());
    EXPECT_EQ(messages[1].frame.command, Command::nop) << "the header is known";
    EXPECT_FALSE(messages[2].oversize);
    EXPECT_EQ(messages[2].frame.data.size(), 9U);
}

TEST(FrameDecoder, R_ENC_3_the_default_limit) {
    FrameDecoder decoder;
    const auto stream = nop(max_data_bytes) + nop(max_data_bytes + 1) + list_services();
    const auto messages = decode(decoder, stream, 1000);
    ASSERT_EQ(messages.size(), 3U);
    EXPECT_FALSE(messages[0].oversize);
    EXPECT_TRUE(messages[1].oversize);
    EXPECT_EQ(messages[2].frame.command, Command::list_services);
}

TEST(FrameDecoder, R_ENC_3_the_longest_message_that_a_header_can_state_is_passed_over) {
    const auto stream = nop(0xFFFF) + list_services();
    for (const std::size_t size : {std::size_t{1}, std::size_t{24}, std::size_t{1460}, stream.size()}) {
        FrameDecoder decoder;
        const auto messages = decode(decoder, stream, size);
        ASSERT_EQ(messages.size(), 2U) << size;
        EXPECT_TRUE(messages[0].oversize);
        EXPECT_EQ(messages[1].frame.command, Command::list_services);
    }
}

TEST(FrameDecoder, R_ENC_3_an_oversize_message_is_reported_at_its_end_and_is_partial_before) {
    FrameDecoder decoder(4);
    const auto stream = nop(5);
    ByteView head = ByteView(stream).first(stream.size() - 1);
    EXPECT_EQ(decoder.next(head), nullptr);
    EXPECT_TRUE(head.empty());
    EXPECT_TRUE(decoder.partial());
    ByteView last = ByteView(stream).last(1);
    EXPECT_TRUE(at(decoder.next(last)).oversize);
    EXPECT_FALSE(decoder.partial());
}

TEST(FrameDecoder, R_ENC_3_a_limit_of_zero_takes_headers_only) {
    FrameDecoder decoder(0);
    const auto stream = list_services() + nop(1) + list_services();
    const auto messages = decode(decoder, stream, 7);
    ASSERT_EQ(messages.size(), 3U);
    EXPECT_FALSE(messages[0].oversize);
    EXPECT_TRUE(messages[1].oversize);
    EXPECT_FALSE(messages[2].oversize);
}

}  // namespace
}  // namespace servobus::enip
