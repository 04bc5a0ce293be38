// EPATH segments, octet by octet.
#include "cip/path.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::error_of;
using test::hex;
using test::octets;

struct Sample {
    std::string name;
    std::string octets;
    Segment segment;
};

void PrintTo(const Sample& sample, std::ostream* out) { *out << sample.octets; }

LogicalSegment segment(LogicalType type, std::uint32_t value, Width width) { return {type, value, width}; }

const std::vector<Sample>& samples() {
    using enum LogicalType;
    using enum Width;
    static const std::vector<Sample> list{
        {"R_PTH_2_class_8_bit", "20 66", segment(class_id, 0x66, bits8)},
        {"R_PTH_3_padded_16_bit_class", "21 00 66 01", segment(class_id, 0x0166, bits16)},
        {"R_PTH_3_padded_32_bit_class", "22 00 66 01 00 80", segment(class_id, 0x80000166, bits32)},
        {"R_PTH_2_instance_8_bit", "24 FF", segment(instance, 0xFF, bits8)},
        {"R_PTH_3_padded_16_bit_instance", "25 00 34 12", segment(instance, 0x1234, bits16)},
        {"R_PTH_3_padded_32_bit_instance", "26 00 78 56 34 12", segment(instance, 0x12345678, bits32)},
        {"R_PTH_2_member_8_bit", "28 01", segment(member, 1, bits8)},
        {"R_PTH_3_padded_16_bit_member", "29 00 01 00", segment(member, 1, bits16)},
        {"R_PTH_3_padded_32_bit_member", "2A 00 01 00 00 00", segment(member, 1, bits32)},
        {"R_PTH_2_connection_point_8_bit", "2C 65", segment(connection_point, 101, bits8)},
        {"R_PTH_3_padded_16_bit_connection_point", "2D 00 65 00", segment(connection_point, 101, bits16)},
        {"R_PTH_3_padded_32_bit_connection_point", "2E 00 65 00 00 00", segment(connection_point, 101, bits32)},
        {"R_PTH_2_attribute_8_bit", "30 00", segment(attribute, 0, bits8)},
        {"R_PTH_3_padded_16_bit_attribute", "31 00 C6 00", segment(attribute, 0xC6, bits16)},
        {"R_PTH_3_padded_32_bit_attribute", "32 00 C6 00 00 00", segment(attribute, 0xC6, bits32)},
        {"R_PTH_2_service_id", "38 0E", segment(service_id, 0x0E, bits8)},
        {"R_PTH_5_key_format_4", "34 04 6D 05 2B 00 09 75 81 01", ElectronicKey{1389, 43, 0x7509, 0x81, 1}},
        {"R_PTH_5_key_format_5_with_serial_number", "34 05 6D 05 2B 00 09 75 01 01 C3 B2 A1 00",
         ElectronicKey{1389, 43, 0x7509, 1, 1, 0x00A1B2C3}},
        {"R_PTH_6_port_with_one_octet_address", "01 00", PortSegment{1, {0}}},
        {"R_PTH_6_largest_short_port", "0E 05", PortSegment{14, {5}}},
        {"R_PTH_6_extended_port", "0F 05 12 34", PortSegment{0x1205, {0x34}}},
        {"R_PTH_6_extended_address_of_odd_length", "12 0D 31 39 32 2E 31 36 38 2E 31 2E 31 30 30 00",
         PortSegment{2, octets("31 39 32 2E 31 36 38 2E 31 2E 31 30 30")}},
        {"R_PTH_6_extended_address_of_even_length", "12 02 0A 0B", PortSegment{2, {0x0A, 0x0B}}},
        {"R_PTH_6_extended_address_without_octets", "12 00", PortSegment{2, {}}},
        {"R_PTH_6_extended_port_and_odd_address", "1F 03 10 00 0A 0B 0C 00", PortSegment{16, {10, 11, 12}}},
        {"R_PTH_6_extended_port_and_even_address", "1F 02 FF FF 0A 0B", PortSegment{0xFFFF, {10, 11}}},
        {"R_PTH_7_schedule", "41 05", NetworkSegment{0x41, {5}}},
        {"R_PTH_7_fixed_tag", "42 05", NetworkSegment{0x42, {5}}},
        {"R_PTH_7_production_inhibit_time_in_ms", "43 05", NetworkSegment{0x43, {5}}},
        {"R_PTH_7_production_inhibit_time_in_us", "51 02 88 13 00 00", NetworkSegment{0x51, octets("88 13 00 00")}},
        {"R_PTH_7_safety", "50 01 AA BB", NetworkSegment{0x50, {0xAA, 0xBB}}},
        {"R_PTH_7_extended_without_data", "5F 00", NetworkSegment{0x5F, {}}},
        {"R_PTH_8_data_segment", "80 02 01 02 03 04", DataSegment{octets("01 02 03 04")}},
        {"R_PTH_8_empty_data_segment", "80 00", DataSegment{}},
        {"R_PTH_9_extended_symbol_of_odd_length", "91 03 61 62 63 00", SymbolSegment{"abc", true}},
        {"R_PTH_9_extended_symbol_of_even_length", "91 04 61 62 63 64", SymbolSegment{"abcd", true}},
        {"R_PTH_9_short_symbol_of_odd_length", "63 61 62 63", SymbolSegment{"abc", false}},
        {"R_PTH_9_short_symbol_of_even_length", "62 61 62 00", SymbolSegment{"ab", false}},
    };
    return list;
}

class PathSegment : public testing::TestWithParam<Sample> {};

TEST_P(PathSegment, is_read) {
    const auto path = Path::parse(octets(GetParam().octets));
    ASSERT_TRUE(path) << describe(path.error());
    ASSERT_EQ(path->segments.size(), 1U);
    EXPECT_TRUE(path->segments[0] == GetParam().segment);
}

TEST_P(PathSegment, is_written) {
    const Path path({GetParam().segment});
    EXPECT_EQ(hex(path.encode()), GetParam().octets);
    EXPECT_EQ(path.words() * 2, path.encode().size()) << "a padded segment is a whole number of words";
}

TEST_P(PathSegment, is_truncated_at_every_shorter_length) {
    const auto whole = octets(GetParam().octets);
    for (std::size_t length = 1; length < whole.size(); ++length) {
        EXPECT_EQ(error_of(Path::parse(ByteView(whole).first(length))), DecodeError::truncated) << length;
    }
}

TEST_P(PathSegment, is_read_behind_another_and_before_another) {
    const auto path = Path::parse(octets("20 04" + GetParam().octets + "24 01"));
    ASSERT_TRUE(path) << describe(path.error());
    ASSERT_EQ(path->segments.size(), 3U);
    EXPECT_TRUE(path->segments[1] == GetParam().segment);
    EXPECT_EQ(hex(path->encode()), hex("20 04" + GetParam().octets + "24 01"));
}

TEST_P(PathSegment, has_words_for_people) { EXPECT_NE(describe(Path({GetParam().segment})), ""); }

INSTANTIATE_TEST_SUITE_P(Path, PathSegment, testing::ValuesIn(samples()),
                         [](const auto& each) { return each.param.name; });

TEST(Path, R_PTH_3_the_pad_octet_is_not_checked) {
    EXPECT_TRUE(Path::parse(octets("25 AA 34 12")).value() ==
                Path({segment(LogicalType::instance, 0x1234, Width::bits16)}));
    EXPECT_TRUE(Path::parse(octets("26 FF 78 56 34 12")).value() ==
                Path({segment(LogicalType::instance, 0x12345678, Width::bits32)}));
    EXPECT_TRUE(Path::parse(octets("91 01 61 FF")).value() == Path({SymbolSegment{"a", true}}));
    EXPECT_TRUE(Path::parse(octets("12 01 61 FF")).value() == Path({PortSegment{2, {0x61}}}));
}

TEST(Path, R_PTH_6_one_octet_in_an_extended_address_means_the_short_form) {
    EXPECT_TRUE(Path::parse(octets("11 01 05 00")).value() == Path::parse(octets("01 05")).value());
    EXPECT_TRUE(Path::parse(octets("0F 03 00 05")).value() == Path::parse(octets("03 05")).value());
}

TEST(Path, an_empty_path_has_no_segments) {
    const auto path = Path::parse(ByteView{});
    ASSERT_TRUE(path);
    EXPECT_TRUE(path->segments.empty());
    EXPECT_EQ(path->words(), 0U);
    EXPECT_EQ(describe(*path), "");
}

TEST(Path, the_longest_path_of_a_request_is_read) {
    std::string text;
    for (std::size_t word = 0; word < max_path_words; ++word) text += "24 01";
    const auto path = Path::parse(octets(text));
    ASSERT_TRUE(path);
    EXPECT_EQ(path->segments.size(), max_path_words);
    EXPECT_EQ(path->words(), max_path_words);
}

TEST(Path, R_PTH_5_other_key_formats_are_bad_segments) {
    for (const auto* format : {"00", "01", "02", "03", "06", "FF"}) {
        EXPECT_EQ(error_of(Path::parse(octets("34" + std::string(format) + "6D052B000975810100000000"))),
                  DecodeError::bad_segment)
            << format;
    }
}

TEST(Path, R_PTH_6_port_0_is_reserved) {
    EXPECT_EQ(error_of(Path::parse(octets("00 00"))), DecodeError::bad_segment);
    EXPECT_EQ(error_of(Path::parse(octets("10 02 01 01"))), DecodeError::bad_segment);
    EXPECT_EQ(error_of(Path::parse(octets("0F 00 00 05"))), DecodeError::bad_segment) << "also when it is extended";
    EXPECT_EQ(error_of(Path::parse(octets("1F 02 00 00 01 01"))), DecodeError::bad_segment);
}

TEST(Path, R_PTH_9_a_short_symbol_has_characters) {
    EXPECT_EQ(error_of(Path::parse(octets("60 00"))), DecodeError::bad_segment);
    EXPECT_TRUE(Path::parse(octets("61 61")));
}

// Every first octet, followed by more than enough: it is either a segment that is known, or bad_segment.
TEST(Path, R_PTH_1_every_first_octet) {
    const auto is_known = [](unsigned first) {
        if (first < 0x20) return first % 16 != 0;  // port
        if (first < 0x40) return first == 0x34 || (first % 4 != 3 && (first & 0x1C) != 0x14 && (first & 0x1C) != 0x1C);
        if (first < 0x60) return true;           // network
        if (first < 0x80) return first != 0x60;  // symbol
        return first == 0x80 || first == 0x91;   // data
    };
    for (unsigned first = 0; first < 256; ++first) {
        // The second octet is a length for some and a key format for one: 4 is good for all.
        auto bytes = octets("00 04");
        bytes[0] = static_cast<std::uint8_t>(first);
        bytes.resize(40, 0x01);
        bool known = false;
        for (std::size_t length = 2; length <= bytes.size() && !known; length += 2) {
            known = static_cast<bool>(Path::parse(ByteView(bytes).first(length)));
        }
        EXPECT_EQ(known, is_known(first)) << std::hex << first;
        if (!is_known(first)) {
            EXPECT_EQ(error_of(Path::parse(bytes)), DecodeError::bad_segment) << std::hex << first;
        }
    }
}

TEST(Path, R_PTH_10_to_takes_the_shortest_form) {
    EXPECT_EQ(hex(Path::to(0x66, 1, 0x24).encode()), "20 66 24 01 30 24");
    EXPECT_EQ(hex(Path::to(0x04, 0xFF).encode()), "20 04 24 FF");
    EXPECT_EQ(hex(Path::to(0x04, 0x100, 3).encode()), "20 04 25 00 00 01 30 03");
    EXPECT_EQ(hex(Path::to(0x0300, 0xFFFF, 0x10000).encode()), "21 00 00 03 25 00 FF FF 32 00 00 00 01 00");
}

TEST(Path, R_CON_10_a_connection_path) {
    const auto path = Path::parse(octets("34 04 6D 05 2B 00 09 75 81 01 20 04 24 01 2C 65 2C 64"));
    ASSERT_TRUE(path);
    EXPECT_EQ(path->words(), 9U);
    EXPECT_EQ(describe(*path),
              "key vendor 1389 type 43 product 0x7509 revision 1.1, class 0x04, instance 0x01, connection point 0x65, "
              "connection point 0x64");
}

}  // namespace
}  // namespace servobus::cip
