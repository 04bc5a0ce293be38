// Reader and Writer: the ends of the buffer, sign, and byte order.
#include "cip/wire.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <limits>

#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::hex;
using test::octets;

TEST(Reader, R_TYP_2_reads_little_endian) {
    const auto bytes = octets("01 0203 04050607 08090A0B0C0D0E0F");
    Reader reader(bytes);
    EXPECT_EQ(reader.u8(), 0x01);
    EXPECT_EQ(reader.u16(), 0x0302);
    EXPECT_EQ(reader.u32(), 0x07060504U);
    EXPECT_EQ(reader.u64(), 0x0F0E0D0C0B0A0908U);
    EXPECT_TRUE(reader.done());
}

TEST(Reader, R_TYP_2_reads_big_endian_where_the_name_says_so) {
    const auto bytes = octets("01 0203 04050607 08090A0B0C0D0E0F");
    Reader reader(bytes);
    EXPECT_EQ(reader.big<std::uint8_t>(), 0x01);
    EXPECT_EQ(reader.big<std::uint16_t>(), 0x0203);
    EXPECT_EQ(reader.big<std::uint32_t>(), 0x04050607U);
    EXPECT_EQ(reader.big<std::uint64_t>(), 0x08090A0B0C0D0E0FU);
    EXPECT_TRUE(reader.done());
}

TEST(Reader, R_TYP_1_keeps_the_sign) {
    const auto bytes = octets("FF FEFF 00000080 FFFFFFFFFFFFFFFF 7F FF7F");
    Reader reader(bytes);
    EXPECT_EQ(reader.little<std::int8_t>(), -1);
    EXPECT_EQ(reader.little<std::int16_t>(), -2);
    EXPECT_EQ(reader.little<std::int32_t>(), std::numeric_limits<std::int32_t>::min());
    EXPECT_EQ(reader.little<std::int64_t>(), -1);
    EXPECT_EQ(reader.little<std::int8_t>(), 127);
    EXPECT_EQ(reader.little<std::int16_t>(), 32767);
    EXPECT_TRUE(reader.done());
}

TEST(Reader, yields_zero_past_the_end_and_stays_failed) {
    const auto bytes = octets("FF FF FF");
    Reader reader(bytes);
    EXPECT_EQ(reader.u32(), 0U);
    EXPECT_FALSE(reader.ok());
    EXPECT_EQ(reader.remaining(), 0U);
    EXPECT_EQ(reader.u8(), 0);  // the three octets are not handed out afterwards
    EXPECT_FALSE(reader.ok());
    EXPECT_FALSE(reader.done());
}

TEST(Reader, an_empty_buffer_is_read_to_its_end) {
    Reader reader(ByteView{});
    EXPECT_TRUE(reader.done());
    EXPECT_TRUE(reader.take(0).empty());
    EXPECT_TRUE(reader.take_rest().empty());
    EXPECT_TRUE(reader.done());
    EXPECT_EQ(reader.big<std::uint16_t>(), 0);
    EXPECT_FALSE(reader.ok());
}

TEST(Reader, takes_exactly_what_is_there_and_not_one_octet_more) {
    const auto bytes = octets("01 02 03");
    Reader exact(bytes);
    EXPECT_EQ(hex(exact.take(3)), "01 02 03");
    EXPECT_TRUE(exact.done());
    Reader beyond(bytes);
    EXPECT_TRUE(beyond.take(4).empty());
    EXPECT_FALSE(beyond.ok());
    Reader huge(bytes);
    EXPECT_TRUE(huge.take(std::numeric_limits<std::size_t>::max()).empty());
    EXPECT_FALSE(huge.ok());
}

TEST(Reader, is_not_done_while_octets_are_left) {
    const auto bytes = octets("01 02");
    Reader reader(bytes);
    EXPECT_EQ(reader.u8(), 1);
    EXPECT_TRUE(reader.ok());
    EXPECT_FALSE(reader.done());
    EXPECT_EQ(hex(reader.rest()), "02");
}

TEST(Reader, an_array_field_past_the_end_is_left_as_it_was) {
    const auto bytes = octets("01 02");
    Reader reader(bytes);
    std::array<std::uint8_t, 3> field{9, 9, 9};
    reader.field(field);
    EXPECT_EQ(hex(field), "09 09 09");
    EXPECT_FALSE(reader.ok());
}

TEST(Reader, skips_reserved_octets_whatever_they_hold) {
    const auto bytes = octets("AA BB 05");
    Reader reader(bytes);
    reader.reserved(2);
    EXPECT_EQ(reader.u8(), 5);
    EXPECT_TRUE(reader.done());
}

TEST(Writer, R_TYP_2_writes_little_endian) {
    Bytes bytes;
    Writer writer(bytes);
    writer.u8(0x01);
    writer.u16(0x0302);
    writer.u32(0x07060504);
    writer.u64(0x0F0E0D0C0B0A0908);
    EXPECT_EQ(hex(bytes), hex("01 0203 04050607 08090A0B0C0D0E0F"));
    EXPECT_EQ(writer.size(), 15U);
}

TEST(Writer, R_TYP_2_writes_big_endian_where_the_name_says_so) {
    Bytes bytes;
    Writer writer(bytes);
    writer.big(std::uint8_t{0x01});
    writer.big(std::uint16_t{0x0203});
    writer.big(std::uint32_t{0x04050607});
    writer.big(std::uint64_t{0x08090A0B0C0D0E0F});
    writer.big(std::int16_t{-2});
    EXPECT_EQ(hex(bytes), hex("01 0203 04050607 08090A0B0C0D0E0F FFFE"));
}

TEST(Writer, R_TYP_1_writes_negative_numbers_in_their_width) {
    Bytes bytes;
    Writer writer(bytes);
    writer.little(std::int8_t{-1});
    writer.little(std::int16_t{-2});
    writer.little(std::numeric_limits<std::int32_t>::min());
    writer.little(std::int64_t{-3});
    EXPECT_EQ(hex(bytes), hex("FF FEFF 00000080 FDFFFFFFFFFFFFFF"));
}

TEST(Writer, appends_octets_zeros_and_enumerations) {
    enum class Code : std::uint16_t { some = 0x1234 };
    Bytes bytes = octets("AA");
    Writer writer(bytes);
    writer.bytes(octets("01 02"));
    writer.zeros(2);
    writer.reserved(1);
    writer.field(Code::some);
    writer.big_endian_field(Code::some);
    writer.field(std::array<std::uint8_t, 2>{7, 8});
    EXPECT_EQ(hex(bytes), "AA 01 02 00 00 00 34 12 12 34 07 08");
}

TEST(Hex, reads_pairs_in_any_spelling) {
    EXPECT_EQ(from_hex("0E 03 20"), octets("0e0320"));
    EXPECT_EQ(from_hex("0x0E03"), octets("0E 03"));
    EXPECT_EQ(from_hex("02:00:00:00:00:64"), octets("020000000064"));
    EXPECT_EQ(from_hex(" 0E\n03\t20 "), octets("0E0320"));
    EXPECT_EQ(from_hex(""), Bytes{});
    EXPECT_EQ(from_hex("0x"), Bytes{});
}

TEST(Hex, refuses_what_is_not_pairs_of_digits) {
    for (const auto* text : {"0", "0E 3", "0E0", "0 E", "0G", "0E,03", "x", "0E 0x03", "\xC3\xA4"}) {
        EXPECT_EQ(from_hex(text), std::nullopt) << text;
    }
}

TEST(Hex, writes_upper_case_pairs_with_blanks_between) {
    EXPECT_EQ(to_hex(Bytes{}), "");
    EXPECT_EQ(to_hex(Bytes{0x0E}), "0E");
    EXPECT_EQ(to_hex(Bytes{0x0E, 0xAF, 0x00}), "0E AF 00");
}

}  // namespace
}  // namespace servobus::cip
