// A drive parameter's value in CIP's octets, for every type.
#include "assemblies/parameter_value.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "drive/xenax.hpp"
#include "tests/support/octets.hpp"

namespace servobus::assemblies {
namespace {

using cip::GeneralStatus;
using test::hex;
using test::octets;

drive::Parameter row_of(drive::Type type) {
    drive::Parameter row{};
    row.cip.type = type;
    row.max_length = 10;
    return row;
}

std::string written(drive::Type type, const drive::Value& value) {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    write_value(writer, row_of(type), value);
    return hex(bytes);
}

GeneralStatus error(drive::Type type, std::string_view text) {
    const auto value = read_value(row_of(type), octets(text));
    return value ? GeneralStatus::success : value.error();
}

struct Sample {
    drive::Type type;
    std::int64_t number;
    std::string octets;
};

const std::vector<Sample> samples{
    {drive::Type::i8, -1, "FF"},
    {drive::Type::i8, 127, "7F"},
    {drive::Type::i8, -128, "80"},
    {drive::Type::i16, 0x0250, "50 02"},
    {drive::Type::i16, -32768, "00 80"},
    {drive::Type::i32, -200'000, "C0 F2 FC FF"},
    {drive::Type::i32, -2147483648, "00 00 00 80"},
    {drive::Type::i32, 2147483647, "FF FF FF 7F"},
    {drive::Type::u8, 255, "FF"},
    {drive::Type::u16, 65535, "FF FF"},
    {drive::Type::u16, 1000, "E8 03"},
    {drive::Type::u32, 4294967295, "FF FF FF FF"},
    {drive::Type::u32, 0x1000, "00 10 00 00"},
};

TEST(ParameterValue, R_TYP_1_and_R_TYP_3_integers_are_written_bare) {
    for (const auto& each : samples) EXPECT_EQ(written(each.type, each.number), each.octets);
}

TEST(ParameterValue, R_TYP_1_integers_are_read_with_their_sign) {
    for (const auto& each : samples) {
        EXPECT_EQ(read_value(row_of(each.type), octets(each.octets)).value(), drive::Value(each.number)) << each.octets;
    }
}

TEST(ParameterValue, R_TYP_9_an_integer_has_exactly_its_size) {
    for (const auto type :
         {drive::Type::i8, drive::Type::i16, drive::Type::i32, drive::Type::u8, drive::Type::u16, drive::Type::u32}) {
        for (std::size_t length = 0; length < 6; ++length) {
            const auto size = drive::size_of(type);
            const auto expected = length < size   ? GeneralStatus::not_enough_data
                                  : length > size ? GeneralStatus::too_much_data
                                                  : GeneralStatus::success;
            EXPECT_EQ(error(type, hex(cip::Bytes(length))), expected) << length << " of " << size;
        }
    }
}

TEST(ParameterValue, R_TYP_4_text_is_a_string) {
    EXPECT_EQ(written(drive::Type::text, std::string("rotative")), "08 00 72 6F 74 61 74 69 76 65");
    EXPECT_EQ(written(drive::Type::text, std::string()), "00 00");
    EXPECT_EQ(read_value(row_of(drive::Type::text), octets("03 00 61 62 63")).value(),
              drive::Value(std::string("abc")));
    EXPECT_EQ(read_value(row_of(drive::Type::text), octets("00 00")).value(), drive::Value(std::string()));
}

TEST(ParameterValue, R_TYP_5_a_string_may_have_a_pad_octet_behind_an_odd_count) {
    EXPECT_EQ(read_value(row_of(drive::Type::text), octets("03 00 61 62 63 00")).value(),
              drive::Value(std::string("abc")));
    EXPECT_EQ(error(drive::Type::text, "02 00 61 62 00"), GeneralStatus::too_much_data);
    EXPECT_EQ(error(drive::Type::text, "00 00 00"), GeneralStatus::too_much_data);
}

TEST(ParameterValue, R_TYP_9_a_string_has_the_length_that_it_counts) {
    for (const auto* text : {"", "03", "03 00", "03 00 61", "03 00 61 62", "FF FF 61"}) {
        EXPECT_EQ(error(drive::Type::text, text), GeneralStatus::not_enough_data) << text;
    }
    EXPECT_EQ(error(drive::Type::text, "03 00 61 62 63 00 00"), GeneralStatus::too_much_data);
}

TEST(ParameterValue, R_MSG_15_the_size_of_the_value_in_front) {
    EXPECT_EQ(value_size(row_of(drive::Type::i16), octets("01 02 03 04")), 2U);
    EXPECT_EQ(value_size(row_of(drive::Type::u32), {}), 4U) << "an integer has its size even when it is not there";
    EXPECT_EQ(value_size(row_of(drive::Type::text), octets("03 00 61")), 5U);
    EXPECT_EQ(value_size(row_of(drive::Type::text), octets("FF FF")), 2U + 0xFFFF);
    EXPECT_EQ(value_size(row_of(drive::Type::text), octets("03")), std::nullopt);
    EXPECT_EQ(value_size(row_of(drive::Type::text), {}), std::nullopt);
}

TEST(ParameterValue, R_TYP_1_type_codes) {
    EXPECT_EQ(data_type(drive::Type::i8), cip::DataType::SINT);
    EXPECT_EQ(data_type(drive::Type::i16), cip::DataType::INT);
    EXPECT_EQ(data_type(drive::Type::i32), cip::DataType::DINT);
    EXPECT_EQ(data_type(drive::Type::u8), cip::DataType::USINT);
    EXPECT_EQ(data_type(drive::Type::u16), cip::DataType::UINT);
    EXPECT_EQ(data_type(drive::Type::u32), cip::DataType::UDINT);
    EXPECT_EQ(data_type(drive::Type::text), cip::DataType::STRING);
}

TEST(ParameterValue, every_row_of_the_drive_reads_back_what_is_written) {
    drive::Device device(*drive::xenax_model("75v8s"));
    for (const auto& row : device.store().table()) {
        std::vector<drive::Value> values{device.store().value(row)};
        if (!row.is_text()) values.insert(values.end(), {row.low, row.high});
        for (const auto& value : values) {
            cip::Bytes bytes;
            cip::Writer writer(bytes);
            write_value(writer, row, value);
            EXPECT_EQ(read_value(row, bytes).value(), value) << row.name;
            EXPECT_EQ(value_size(row, bytes), bytes.size()) << row.name;
        }
    }
}

TEST(Refusal, R_ERR_6_to_R_ERR_10_the_drives_word_becomes_a_status) {
    EXPECT_EQ(to_status(drive::Refusal::read_only), GeneralStatus::attribute_not_settable);
    EXPECT_EQ(to_status(drive::Refusal::write_only), GeneralStatus::attribute_not_gettable);
    for (const auto refusal : {drive::Refusal::too_low, drive::Refusal::too_high, drive::Refusal::not_allowed,
                               drive::Refusal::too_long, drive::Refusal::wrong_type}) {
        EXPECT_EQ(to_status(refusal), GeneralStatus::invalid_attribute_value);
    }
    EXPECT_EQ(to_status(drive::Refusal::not_configured),
              cip::Status(GeneralStatus::vendor_specific, {cip::drive_refuses}));
}

}  // namespace
}  // namespace servobus::assemblies
