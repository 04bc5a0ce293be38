// Forward_Open in both forms, Forward_Close, and their replies.
#include "cip/forward_open.hpp"

#include <gtest/gtest.h>

#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::error_of;
using test::hex;
using test::octets;

constexpr ConnectionTriad triad{0x000B, 77, 0x11223344};

ForwardOpen example() {
    ForwardOpen open;
    open.t_to_o_id = 0x0A11000B;
    open.triad = triad;
    open.timeout_multiplier = 2;
    open.o_to_t_rpi = 10'000;
    open.o_to_t = {.priority = Priority::scheduled, .size = 24};
    open.t_to_o_rpi = 10'000;
    open.t_to_o = {.priority = Priority::scheduled, .size = 30};
    open.transport = {.transport_class = 1};
    open.path = octets("20 04 24 01 2C 65 2C 64");
    return open;
}

// priority, ticks | ids | serial, vendor, originator serial | multiplier, reserved | RPI, parameters, twice | trigger, path
constexpr auto example_octets =
    "0A 0E 00000000 0B00110A 0B00 4D00 44332211 02 000000 10270000 1848 10270000 1E48 01 04 20 04 24 01 2C 65 2C 64";
constexpr auto large_octets =
    "0A 0E 00000000 0B00110A 0B00 4D00 44332211 02 000000 10270000 18000048 10270000 1E000048 01 04 2004 2401 2C65 "
    "2C64";

TEST(ForwardOpen, R_CON_1_example_of_101_100) {
    EXPECT_EQ(hex(example().encode()), hex(example_octets));
    EXPECT_EQ(ForwardOpen::parse(octets(example_octets), false).value(), example());
}

TEST(ForwardOpen, R_CON_2_the_large_form_has_wide_parameters) {
    auto open = example();
    open.large = true;
    EXPECT_EQ(hex(open.encode()), hex(large_octets));
    EXPECT_EQ(ForwardOpen::parse(octets(large_octets), true).value(), open);
}

TEST(ForwardOpen, R_CON_2_the_large_form_has_any_size) {
    auto open = example();
    open.large = true;
    open.o_to_t = {true, ConnectionType::multicast, Priority::urgent, true, 0xFFFF};
    const auto encoded = open.encode();
    EXPECT_EQ(hex(ByteView(encoded).subspan(26, 4)), "FF FF 00 AE");
    EXPECT_EQ(ForwardOpen::parse(encoded, true).value(), open);
}

TEST(ForwardOpen, R_CON_1_the_reserved_octets_are_ignored) {
    auto bytes = octets(example_octets);
    bytes[19] = bytes[20] = bytes[21] = 0xFF;
    EXPECT_EQ(ForwardOpen::parse(bytes, false).value(), example());
}

TEST(ForwardOpen, R_CON_14_every_shorter_length_is_truncated_and_a_longer_one_trails) {
    for (const bool large : {false, true}) {
        const auto whole = octets(large ? large_octets : example_octets);
        for (std::size_t length = 0; length < whole.size(); ++length) {
            EXPECT_EQ(error_of(ForwardOpen::parse(ByteView(whole).first(length), large)), DecodeError::truncated)
                << length;
        }
        EXPECT_EQ(error_of(ForwardOpen::parse(test::operator+(whole, {0}), large)), DecodeError::trailing);
    }
}

TEST(ForwardOpen, R_CON_1_the_path_may_be_malformed_or_empty) {
    auto open = example();
    open.path = octets("E0 00");
    EXPECT_EQ(ForwardOpen::parse(open.encode(), false).value(), open);
    open.path.clear();
    EXPECT_EQ(ForwardOpen::parse(open.encode(), false).value(), open);
}

TEST(ForwardOpen, R_CON_1_the_longest_path) {
    auto open = example();
    open.path.assign(2 * max_path_words, 0x24);
    EXPECT_EQ(ForwardOpen::parse(open.encode(), false).value(), open);
}

TEST(ConnectionParameters, R_CON_3_examples) {
    EXPECT_EQ((ConnectionParameters{.priority = Priority::scheduled, .size = 24}.to_word()), 0x4818);
    EXPECT_EQ((ConnectionParameters{.type = ConnectionType::multicast, .priority = Priority::scheduled, .size = 30}
                   .to_word()),
              0x281E);
    EXPECT_EQ((ConnectionParameters{.variable = true, .size = 500}.to_word()), 0x43F4);
}

TEST(ConnectionParameters, R_CON_3_every_word_reads_back_but_for_its_reserved_bit) {
    for (unsigned word = 0; word <= 0xFFFF; ++word) {
        const auto parameters = ConnectionParameters::from_word(static_cast<std::uint16_t>(word));
        ASSERT_EQ(parameters.to_word(), word & 0xEFFF) << std::hex << word;
    }
}

TEST(ConnectionParameters, R_CON_4_every_bit_has_its_place) {
    EXPECT_TRUE(ConnectionParameters::from_dword(0x80000000).redundant_owner);
    EXPECT_EQ(ConnectionParameters::from_dword(0x60000000).type, ConnectionType::reserved);
    EXPECT_EQ(ConnectionParameters::from_dword(0x40000000).type, ConnectionType::point_to_point);
    EXPECT_EQ(ConnectionParameters::from_dword(0x0C000000).priority, Priority::urgent);
    EXPECT_TRUE(ConnectionParameters::from_dword(0x02000000).variable);
    EXPECT_EQ(ConnectionParameters::from_dword(0x0000FFFF).size, 0xFFFF);
    // Bits 28 and 24 to 16 are reserved.
    EXPECT_EQ(ConnectionParameters::from_dword(0x11FF0000), ConnectionParameters::from_dword(0));
    for (const std::uint32_t dword : {0x48000018U, 0x2800001EU, 0x42000FA0U, 0xEE00FFFFU}) {
        EXPECT_EQ(ConnectionParameters::from_dword(dword).to_dword(), dword);
    }
}

TEST(Transport, R_CON_5_examples) {
    EXPECT_EQ(Transport::from_byte(0x01), (Transport{false, 0, 1}));
    EXPECT_EQ(Transport::from_byte(0x11), (Transport{false, 1, 1}));
    EXPECT_EQ(Transport::from_byte(0xA3), (Transport{true, 2, 3}));
    for (unsigned byte = 0; byte < 256; ++byte) {
        EXPECT_EQ(Transport::from_byte(static_cast<std::uint8_t>(byte)).to_byte(), byte);
    }
}

TEST(ForwardOpenReply, R_CON_13_layout) {
    const ForwardOpenReply reply{0x56A0000C, 0x0A11000B, triad, 10'000, 10'000, {}};
    EXPECT_EQ(hex(reply.encode()), hex("0C00A056 0B00110A 0B00 4D00 44332211 10270000 10270000 00 00"));
    EXPECT_EQ(ForwardOpenReply::parse(reply.encode()).value(), reply);
    const ForwardOpenReply with_data{1, 2, triad, 3, 4, octets("AA BB CC DD")};
    EXPECT_EQ(hex(with_data.encode()), hex("01000000 02000000 0B00 4D00 44332211 03000000 04000000 02 00 AABBCCDD"));
    EXPECT_EQ(ForwardOpenReply::parse(with_data.encode()).value(), with_data);
}

TEST(ForwardOpenReply, R_CON_13_every_other_length_is_refused) {
    const auto whole = ForwardOpenReply{1, 2, triad, 3, 4, octets("AA BB")}.encode();
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(ForwardOpenReply::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_EQ(error_of(ForwardOpenReply::parse(test::operator+(whole, {0}))), DecodeError::trailing);
}

TEST(ConnectionRefusal, R_CON_14_triad_and_remaining_path) {
    const ConnectionRefusal refusal{triad, 0};
    EXPECT_EQ(hex(refusal.encode()), hex("0B00 4D00 44332211 00 00"));
    EXPECT_EQ(ConnectionRefusal::parse(refusal.encode()).value(), refusal);
    EXPECT_EQ(hex(ConnectionRefusal{triad, 9}.encode()), hex("0B00 4D00 44332211 09 00"));
}

TEST(ConnectionRefusal, R_CM_10_the_last_two_octets_may_be_missing) {
    const auto whole = ConnectionRefusal{triad, 9}.encode();
    EXPECT_EQ(ConnectionRefusal::parse(ByteView(whole).first(9)).value(), (ConnectionRefusal{triad, 9}));
    EXPECT_EQ(ConnectionRefusal::parse(ByteView(whole).first(8)).value(), (ConnectionRefusal{triad, 0}));
    for (std::size_t length = 0; length < 8; ++length) {
        EXPECT_EQ(error_of(ConnectionRefusal::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
}

TEST(ForwardClose, R_CON_34_layout) {
    const ForwardClose close{0x0A, 0x0E, triad, octets("20 04 24 01 2C 65 2C 64")};
    EXPECT_EQ(hex(close.encode()), hex("0A 0E 0B00 4D00 44332211 04 00 20 04 24 01 2C 65 2C 64"));
    EXPECT_EQ(ForwardClose::parse(close.encode()).value(), close);
}

TEST(ForwardClose, R_CON_36_every_other_length_is_refused) {
    const auto whole = ForwardClose{0x0A, 0x0E, triad, octets("20 02 24 01")}.encode();
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(ForwardClose::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_EQ(error_of(ForwardClose::parse(test::operator+(whole, {0}))), DecodeError::trailing);
}

TEST(ForwardCloseReply, R_CON_34_layout) {
    const ForwardCloseReply reply{triad, {}};
    EXPECT_EQ(hex(reply.encode()), hex("0B00 4D00 44332211 00 00"));
    EXPECT_EQ(ForwardCloseReply::parse(reply.encode()).value(), reply);
    const auto whole = ForwardCloseReply{triad, octets("AABB")}.encode();
    EXPECT_EQ(hex(whole), hex("0B00 4D00 44332211 01 00 AABB"));
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(ForwardCloseReply::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
    EXPECT_EQ(error_of(ForwardCloseReply::parse(test::operator+(whole, {0}))), DecodeError::trailing);
}

// ------------------------------------------------------------------------------------------- intervals in a refusal

Status refused(std::string_view words) {
    Status status{GeneralStatus::connection_failure, {}};
    const auto bytes = octets(words);
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
        status.extended.push_back(static_cast<std::uint16_t>(bytes[i] | bytes[i + 1] << 8));
    }
    return status;
}

TEST(RpiRefusal, R_CON_14_six_words) {
    const RpiRefusal both{RpiKind::minimum, RpiKind::maximum, 1000, 3'200'000};
    EXPECT_EQ(both.status(), refused("1201 0203 E8030000 00D43000"));
    EXPECT_EQ(RpiRefusal::from(both.status()), both);
    const RpiRefusal joins{RpiKind::acceptable, RpiKind::required, 0xFFFFFFFF, 0x00010000};
    EXPECT_EQ(joins.status(), refused("1201 0004 FFFFFFFF 00000100"));
    EXPECT_EQ(RpiRefusal::from(joins.status()), joins);
}

TEST(RpiRefusal, R_CON_14_longer_is_read_and_shorter_says_nothing) {
    EXPECT_TRUE(RpiRefusal::from(refused("1201 0203 E8030000 00D43000 0000")));
    for (const auto* words : {"", "1201", "1201 0203", "1201 0203 E803", "1201 0203 E8030000 00D4"}) {
        EXPECT_FALSE(RpiRefusal::from(refused(words))) << words;
    }
}

TEST(RpiRefusal, R_CON_14_is_of_0x0112_alone) {
    EXPECT_FALSE(RpiRefusal::from(refused("1101 0203 E8030000 00D43000")));
    auto other = refused("1201 0203 E8030000 00D43000");
    other.general = GeneralStatus::vendor_specific;
    EXPECT_FALSE(RpiRefusal::from(other));
    EXPECT_FALSE(RpiRefusal::from(Status{}));
}

TEST(RpiRefusal, R_CON_14_kinds_that_nobody_has_defined_are_kept) {
    const auto read = RpiRefusal::from(refused("1201 FF05 E8030000 00D43000"));
    ASSERT_TRUE(read);
    EXPECT_EQ(static_cast<unsigned>(read->o_to_t_kind), 0xFFU);
    EXPECT_EQ(static_cast<unsigned>(read->t_to_o_kind), 5U);
}

// -------------------------------------------------------------------------------------------- production inhibit time

std::optional<std::uint32_t> inhibit_in(std::string_view path) {
    return production_inhibit_time(Path::parse(octets(path)).value());
}

TEST(ProductionInhibitTime, R_CON_51_in_milliseconds_and_microseconds) {
    EXPECT_EQ(inhibit_in("43 05 20 04 24 01 2C 65 2C 64"), 5000U);
    EXPECT_EQ(inhibit_in("20 04 43 00 2C 65 2C 64"), 0U);
    EXPECT_EQ(inhibit_in("20 04 2C 65 2C 64 43 FF"), 255'000U);
    EXPECT_EQ(inhibit_in("34 04 6D05 2B00 0975 01 01 51 02 88130000 20 04"), 5000U);
    EXPECT_EQ(inhibit_in("51 02 FFFFFFFF"), 0xFFFFFFFFU);
    EXPECT_EQ(inhibit_in("43 02 51 02 88130000"), 2000U) << "the first counts";
}

TEST(ProductionInhibitTime, R_CON_51_none) {
    EXPECT_EQ(inhibit_in("20 04 24 01 2C 65 2C 64"), std::nullopt);
    EXPECT_EQ(inhibit_in("41 05 42 05 20 04"), std::nullopt) << "schedule and fixed tag";
    EXPECT_EQ(inhibit_in("51 01 8813 20 04"), std::nullopt) << "of another size";
    EXPECT_EQ(inhibit_in("51 03 881300000000 43 07"), 7000U) << "and the search goes on";
    EXPECT_EQ(production_inhibit_time(Path{}), std::nullopt);
}

TEST(ProductionInhibitTime, R_CON_51_is_written_as_short_as_it_can_be) {
    const auto written = [](std::uint32_t time) { return hex(Path({production_inhibit_segment(time)}).encode()); };
    EXPECT_EQ(written(0), hex("43 00"));
    EXPECT_EQ(written(1000), hex("43 01"));
    EXPECT_EQ(written(255'000), hex("43 FF"));
    EXPECT_EQ(written(256'000), hex("51 02 00E80300"));
    EXPECT_EQ(written(1001), hex("51 02 E9030000"));
    EXPECT_EQ(written(999), hex("51 02 E7030000"));
    for (const std::uint32_t time : {0U, 1U, 1000U, 254'999U, 255'000U, 255'001U, 3'200'000U, 0xFFFFFFFFU}) {
        EXPECT_EQ(production_inhibit_time(Path({production_inhibit_segment(time)})), time);
    }
}

}  // namespace
}  // namespace servobus::cip
