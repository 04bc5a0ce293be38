// Outputs and inputs of a connection by name and by place.
#include "scanner/cli/io_data.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "assemblies/connection.hpp"
#include "cip/hex.hpp"
#include "scanner/axis_state.hpp"
#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner::cli {
namespace {

using test::hex;
using testing::HasSubstr;

IoOutputs outputs_of(std::uint32_t instance) { return IoOutputs::of(assemblies::find_layout(instance)); }

std::string change(const std::string& text, const IoOutputs& outputs) {
    const auto parsed = parse_change(text, outputs);
    if (!parsed) return parsed.error().text;
    return std::to_string(parsed->offset) + ": " + cip::to_hex(parsed->octets);
}

TEST(IoData, FieldsLieAsTheManualPrintsThem) {
    // 000 §2.4.2
    const auto fields = fields_of(*assemblies::find_layout(112));
    ASSERT_EQ(fields.size(), 12U);
    EXPECT_EQ(fields[0].name(), "TargetPositionOrDistance");
    EXPECT_EQ(fields[4].name(), "Controlword");
    EXPECT_EQ(fields[4].offset, 16U);
    EXPECT_EQ(fields[10].name(), "Padding");
    EXPECT_EQ(fields[11].name(), "TimeStamp");
    EXPECT_EQ(fields[11].offset, 40U);
    EXPECT_EQ(fields[11].unit(), "us");
    for (const auto& layout : assemblies::layouts()) {
        const auto all = fields_of(layout);
        EXPECT_EQ(all.back().offset + all.back().octets, layout.size());
    }
}

TEST(IoData, SetsByNameAsSetDoes) {
    const auto standard = outputs_of(101);
    EXPECT_EQ(change("TargetPositionOrDistance=1000", standard), "0: E8 03 00 00");
    EXPECT_EQ(change("targetpositionordistance=-2", standard), "0: FE FF FF FF");
    EXPECT_EQ(change("drive.Controlword=0x800F", standard), "16: 0F 80");
    EXPECT_EQ(change("drive.Controlword=0b1111", standard), "16: 0F 00");
    EXPECT_EQ(change("@0x66/1/0x00=6", standard), "16: 06 00");
    EXPECT_EQ(change("SCRV=35", standard), "12: 23 00 00 00");
    EXPECT_EQ(change("TimeStamp=0x0102030405060708", outputs_of(112)), "40: 08 07 06 05 04 03 02 01");
    EXPECT_EQ(change("padding=1", outputs_of(112)), "36: 01 00 00 00");
}

TEST(IoData, AMnemonicMeansTheVariable) {
    // Both addresses of one variable are the same to a person (Parameter::same_as).
    const auto fields = fields_of(*assemblies::find_layout(101));
    for (const auto& field : fields) {
        if (field.row->mnemonic.empty()) continue;
        const auto parsed = parse_change(std::string(field.row->mnemonic) + "=1", outputs_of(101));
        ASSERT_TRUE(parsed) << parsed.error().text;
        EXPECT_EQ(parsed->offset, field.offset) << field.name();
    }
}

TEST(IoData, SetsByPlace) {
    const IoOutputs any{nullptr, 18};
    EXPECT_EQ(change("@0:DINT=5", any), "0: 05 00 00 00");
    EXPECT_EQ(change("@16:hex=0F00", any), "16: 0F 00");
    EXPECT_EQ(change("@0x10:int=-1", any), "16: FF FF");
    EXPECT_EQ(change("@14:REAL=1", any), "14: 00 00 80 3F");
    EXPECT_EQ(change("@16:INT=1", outputs_of(101)), "16: 01 00");
}

TEST(IoData, SaysWhatIsWrong) {
    const auto standard = outputs_of(101);
    const IoOutputs any{nullptr, 18};
    EXPECT_THAT(change("Controlword", standard), HasSubstr("has no value"));
    EXPECT_THAT(change("Kontrollwort=1", standard), HasSubstr("no parameter is called"));
    EXPECT_THAT(change("Statusword=1", standard),
                HasSubstr("not in assembly 101, which has TargetPositionOrDistance, Speed"));
    EXPECT_THAT(change("SCurve=x", standard), HasSubstr("SCurve: "));
    EXPECT_THAT(change("TimeStamp=x", outputs_of(112)), HasSubstr("'x' is no number"));
    EXPECT_THAT(change("SCurve=1", any), HasSubstr("no names; write @OFFSET:TYPE=VALUE"));
    EXPECT_THAT(change("@DINT=1", any), HasSubstr("is no place"));
    EXPECT_THAT(change("@-1:DINT=1", any), HasSubstr("is no place"));
    EXPECT_THAT(change("@0:DINK=1", any), HasSubstr("has no type"));
    EXPECT_THAT(change("@0:SINT=128", any), HasSubstr("it holds -128 to 127"));
    EXPECT_THAT(change("@14:DINT=1", any), HasSubstr("14: 01"));
    EXPECT_THAT(change("@15:DINT=1", any), HasSubstr("ends behind the 18 octets"));
    EXPECT_THAT(change("@99999999999999999999:DINT=1", any), HasSubstr("ends behind the 18 octets"));
}

TEST(IoData, PutsAChangeInItsPlace) {
    cip::Bytes image(18, 0xEE);
    put({16, hex("0F 00")}, image);
    EXPECT_EQ(image[15], 0xEE);
    EXPECT_EQ(image[16], 0x0F);
    EXPECT_EQ(image[17], 0x00);
}

TEST(IoData, ReadsInputsInWords) {
    const auto fields = fields_of(*assemblies::find_layout(100));
    // Status word 0x0637, current -5 mA, position -100000, process status: reference and in position.
    const auto data = hex("37 06 FB FF 60 79 FE FF 00 00 00 00 0A 00 00 00 00 00 00 00 01 00 01 00 01 00 00 00");
    EXPECT_EQ(text_in(fields[0], data), "0x0637 (1591)");
    EXPECT_EQ(meaning_in(fields[0], data), "Operation enabled; voltage enabled, remote, bit 10");
    EXPECT_EQ(number_in(fields[1], data), -5);
    EXPECT_EQ(fields[1].unit(), "mA");
    EXPECT_EQ(text_in(fields[2], data), "-100000");
    EXPECT_EQ(meaning_in(fields[2], data), "");
    EXPECT_EQ(meaning_in(fields[4], data), "reference, in position");
    EXPECT_EQ(meaning_in(fields[6], data), "negative limit switch, input 1");
    EXPECT_EQ(meaning_in(fields[7], data), "brake");
}

TEST(IoData, ReadsATimeStamp) {
    const auto fields = fields_of(*assemblies::find_layout(113));
    cip::Bytes data(40, 0);
    data[32] = 0x01;
    data[39] = 0x10;
    EXPECT_EQ(text_in(fields.back(), data), "1152921504606846977");
}

TEST(IoData, GivesAParameterItsValue) {
    const auto fields = fields_of(*assemblies::find_layout(101));
    const auto change = change_of(fields, row_of(AxisValue::target), std::int64_t{-1});
    ASSERT_TRUE(change);
    EXPECT_EQ(*change, (IoChange{0, hex("FF FF FF FF")}));
    EXPECT_EQ(change_of(fields, row_of(AxisValue::status_word), std::int64_t{1}), std::nullopt);
}

}  // namespace
}  // namespace servobus::scanner::cli
