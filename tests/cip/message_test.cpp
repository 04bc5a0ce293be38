// Request and reply of the message router.
#include "cip/message.hpp"

#include <gtest/gtest.h>

#include <string>

#include "cip/services.hpp"
#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::error_of;
using test::hex;
using test::octets;

TEST(Request, R_MSG_1_service_path_size_path_data) {
    const Request get{service::get_attribute_single, Path::to(0x64, 1, 6), {}};
    EXPECT_EQ(hex(get.encode()), "0E 03 20 64 24 01 30 06");
    EXPECT_EQ(Request::parse(get.encode()).value(), get);
    const Request set{service::set_attribute_single, Path::to(0x64, 1, 0), octets("32 00 00 00")};
    EXPECT_EQ(hex(set.encode()), "10 03 20 64 24 01 30 00 32 00 00 00");
    EXPECT_EQ(Request::parse(set.encode()).value(), set);
}

TEST(Request, R_MSG_1_without_path_and_data) {
    const Request request{0x17, {}, {}};
    EXPECT_EQ(hex(request.encode()), "17 00");
    EXPECT_EQ(Request::parse(request.encode()).value(), request);
}

TEST(Request, R_MSG_3_shorter_than_two_octets_is_truncated) {
    EXPECT_EQ(error_of(Request::parse({})), DecodeError::truncated);
    EXPECT_EQ(error_of(Request::parse(octets("0E"))), DecodeError::truncated);
    EXPECT_EQ(error_of(RequestView::parse(octets("0E"))), DecodeError::truncated);
}

TEST(Request, R_ERR_1_a_path_beyond_the_message_is_told_apart) {
    for (const auto* text : {"0E 03 20 64 24 01 30", "0E 09 20 64 24 01 30 05", "0E 01", "0E FF"}) {
        EXPECT_EQ(error_of(Request::parse(octets(text))), DecodeError::path_too_long) << text;
        EXPECT_EQ(error_of(RequestView::parse(octets(text))), DecodeError::path_too_long) << text;
    }
}

TEST(Request, R_ERR_2_a_bad_segment_is_told_apart) {
    EXPECT_EQ(error_of(Request::parse(octets("0E 02 20 64 E0 01"))), DecodeError::bad_segment);
    EXPECT_TRUE(RequestView::parse(octets("0E 02 20 64 E0 01"))) << "the path is not looked at yet";
}

TEST(Request, R_MSG_1_the_view_shows_the_octets_that_came) {
    const auto message = octets("10 02 20 64 24 01 AA BB");
    const auto view = RequestView::parse(message).value();
    EXPECT_EQ(view.service, 0x10);
    EXPECT_EQ(hex(view.path), "20 64 24 01");
    EXPECT_EQ(hex(view.data), "AA BB");
}

TEST(Response, R_MSG_2_success_with_data) {
    const Response response{0x0E, {}, octets("03 00 00 00")};
    EXPECT_EQ(hex(response.encode()), "8E 00 00 00 03 00 00 00");
    EXPECT_EQ(response.encoded_size(), 8U);
    EXPECT_EQ(Response::parse(response.encode()).value(), response);
}

TEST(Response, R_MSG_2_status_with_extended_words_and_data) {
    const Response response{0x54, Status(GeneralStatus::connection_failure, {0x0127, 24}), octets("20 00")};
    EXPECT_EQ(hex(response.encode()), "D4 00 01 02 27 01 18 00 20 00");
    EXPECT_EQ(response.encoded_size(), 10U);
    EXPECT_EQ(Response::parse(response.encode()).value(), response);
}

TEST(Response, R_SCN_6_the_reserved_octet_is_not_enforced) {
    EXPECT_EQ(Response::parse(octets("8E FF 00 00 01")).value(), (Response{0x0E, {}, {1}}));
}

TEST(Response, R_MSG_2_is_truncated_at_every_length_before_its_data) {
    const auto whole = octets("D4 00 01 02 27 01 18 00");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(Response::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_TRUE(Response::parse(whole));
    EXPECT_EQ(error_of(Response::parse(octets("8E 00 00 FF 00"))), DecodeError::truncated);
}

TEST(Response, R_MSG_2_without_reply_bit_is_no_reply) {
    EXPECT_EQ(error_of(Response::parse(octets("0E 00 00 00"))), DecodeError::bad_value);
}

}  // namespace
}  // namespace servobus::cip
