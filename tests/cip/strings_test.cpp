// STRING, SHORT_STRING and STRINGI.
#include "cip/strings.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/octets.hpp"

namespace servobus::cip {
namespace {

using test::hex;
using test::octets;

Bytes string_octets(std::string_view text) {
    Bytes bytes;
    Writer writer(bytes);
    write_string(writer, text);
    return bytes;
}

Bytes short_string_octets(std::string_view text) {
    Bytes bytes;
    Writer writer(bytes);
    write_short_string(writer, text);
    return bytes;
}

Bytes stringi_octets(const std::vector<InternationalString>& strings) {
    Bytes bytes;
    Writer writer(bytes);
    write_stringi(writer, strings);
    return bytes;
}

TEST(String, R_TYP_4_is_a_two_octet_count_and_the_characters) {
    EXPECT_EQ(hex(string_octets("rotative")), "08 00 72 6F 74 61 74 69 76 65");
    EXPECT_EQ(hex(string_octets("")), "00 00");
    const auto bytes = octets("08 00 72 6F 74 61 74 69 76 65 AA");
    Reader reader(bytes);
    EXPECT_EQ(read_string(reader), "rotative");
    EXPECT_EQ(hex(reader.rest()), "AA");
}

TEST(String, R_TYP_4_holds_every_octet_and_no_terminator) {
    const std::string text("\0\xE4\xFF", 3);
    const auto bytes = string_octets(text);
    EXPECT_EQ(hex(bytes), "03 00 00 E4 FF");
    Reader reader(bytes);
    EXPECT_EQ(read_string(reader), text);
    EXPECT_TRUE(reader.done());
}

TEST(String, R_TYP_4_is_cut_at_the_largest_count) {
    const auto bytes = string_octets(std::string(0x10000, 'x'));
    EXPECT_EQ(bytes.size(), 2U + 0xFFFF);
    EXPECT_EQ(hex(ByteView(bytes).first(2)), "FF FF");
}

TEST(String, R_TYP_9_a_cut_string_is_not_there) {
    const auto whole = string_octets("abc");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        Reader reader(ByteView(whole).first(length));
        EXPECT_EQ(read_string(reader), "") << length;
        EXPECT_FALSE(reader.ok()) << length;
    }
}

TEST(ShortString, R_TYP_4_is_a_one_octet_count_and_the_characters) {
    EXPECT_EQ(hex(short_string_octets("XENAX Xvi 75V8S")), "0F 58 45 4E 41 58 20 58 76 69 20 37 35 56 38 53");
    EXPECT_EQ(hex(short_string_octets("")), "00");
    const auto bytes = octets("03 61 62 63 AA");
    Reader reader(bytes);
    EXPECT_EQ(read_short_string(reader), "abc");
    EXPECT_EQ(hex(reader.rest()), "AA");
}

TEST(ShortString, R_TYP_4_is_cut_at_255_characters) {
    EXPECT_EQ(short_string_octets(std::string(255, 'x')).size(), 256U);
    const auto bytes = short_string_octets(std::string(256, 'x'));
    EXPECT_EQ(bytes.size(), 256U);
    EXPECT_EQ(bytes[0], 255);
}

TEST(ShortString, R_TYP_9_a_cut_string_is_not_there) {
    const auto whole = short_string_octets("abc");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        Reader reader(ByteView(whole).first(length));
        EXPECT_EQ(read_short_string(reader), "") << length;
        EXPECT_FALSE(reader.ok()) << length;
    }
}

TEST(Stringi, R_TYP_6_example_of_one_short_string) {
    const auto example = octets("01 65 6E 67 DA 04 00 03 45 44 53");
    EXPECT_EQ(hex(stringi_octets({{.text = "EDS"}})), hex(example));
    Reader reader(example);
    EXPECT_EQ(read_stringi(reader), (std::vector<InternationalString>{{"eng", DataType::SHORT_STRING, 4, "EDS"}}));
    EXPECT_TRUE(reader.done());
}

TEST(Stringi, R_TYP_6_several_languages_and_both_narrow_types) {
    const std::vector<InternationalString> strings{{"eng", DataType::STRING, 4, "drive"},
                                                   {"deu", DataType::SHORT_STRING, 4, "Antrieb"}};
    const auto bytes = stringi_octets(strings);
    EXPECT_EQ(hex(bytes), hex("02 656E67 D0 0400 0500 6472697665 646575 DA 0400 07 416E7472696562"));
    Reader reader(bytes);
    EXPECT_EQ(read_stringi(reader), strings);
    EXPECT_TRUE(reader.done());
}

TEST(Stringi, R_TYP_6_no_string_at_all) {
    EXPECT_EQ(hex(stringi_octets({})), "00");
    const auto none = octets("00");
    Reader reader(none);
    EXPECT_TRUE(read_stringi(reader).empty());
    EXPECT_TRUE(reader.done());
}

TEST(Stringi, R_TYP_6_a_language_is_three_characters) {
    EXPECT_EQ(hex(stringi_octets({{.language = "e", .text = ""}})), hex("01 652020 DA 0400 00"));
    EXPECT_EQ(hex(stringi_octets({{.language = "english", .text = ""}})), hex("01 656E67 DA 0400 00"));
}

TEST(Stringi, R_TYP_6_wide_characters_are_not_read) {
    for (const auto* type : {"D5", "D9", "C7", "00"}) {
        const auto bytes = octets("01 656E67" + std::string(type) + "E803 0100 4100");
        Reader reader(bytes);
        (void)read_stringi(reader);
        EXPECT_FALSE(reader.ok()) << type;
    }
}

TEST(Stringi, R_TYP_6_every_cut_is_found) {
    const auto whole = octets("02 656E67 D0 0400 0500 6472697665 646575 DA 0400 07 416E7472696562");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        Reader reader(ByteView(whole).first(length));
        (void)read_stringi(reader);
        EXPECT_FALSE(reader.ok()) << length;
    }
}

}  // namespace
}  // namespace servobus::cip
