// What a device's answers are worth against its data sheet.
#include "scanner/sheet_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scanner/sheet_plan.hpp"
#include "tests/scanner/sample_sheet.hpp"
#include "tests/support/octets.hpp"

namespace servobus::scanner {
namespace {

using cip::GeneralStatus;
using servobus::test::hex;
using servobus::test::octets;
using test::altered;
using test::valve_text;
using testing::HasSubstr;

/// `equal`, or the agreement and the words.
std::string shown(const Comparison& comparison) {
    if (comparison.agreement == Agreement::equal) return "equal";
    return std::string(name(comparison.agreement)) + ": " + comparison.words;
}

Identity valve_identity() {
    Identity identity;
    identity.vendor = 77;
    identity.device_type = 43;
    identity.product_code = 5;
    identity.major_revision = 2;
    identity.minor_revision = 3;
    identity.product_name = "Valve 5";
    return identity;
}

TEST(SheetCheck, IdentityIsEqualOrExplained) {
    const auto device = test::valve().device;
    auto identity = valve_identity();
    for (const auto& each : compare_identity(device, identity)) EXPECT_EQ(shown(each), "equal") << each.subject;
    EXPECT_EQ(compare_identity(device, identity).size(), 5U);
    identity.vendor = 1389;
    identity.device_type = 12;
    identity.product_code = 6;
    identity.major_revision = 3;
    identity.product_name = "Valve 6";
    const auto all = compare_identity(device, identity);
    EXPECT_EQ(shown(all[0]),
              "different: the device says 1389 (Jenny Science AG), the file 77: the file is of another "
              "maker's device");
    EXPECT_THAT(shown(all[1]), HasSubstr("the device says 12 (communications adapter), the file 43: "));
    EXPECT_EQ(shown(all[2]), "different: the device says 6 (Valve 6), the file 5: the file is of another product");
    EXPECT_EQ(shown(all[3]), "different: the device says 3.3, the file 2.3: no tool takes this file for the device");
    EXPECT_EQ(shown(all[4]), "different: the device says 'Valve 6', the file 'Valve 5'");
    identity = valve_identity();
    identity.minor_revision = 4;
    EXPECT_THAT(shown(compare_identity(device, identity)[3]), HasSubstr("made for another firmware"));
    for (const auto& each : compare_identity({}, identity)) EXPECT_EQ(each.agreement, Agreement::not_compared);
}

class SheetParameter : public testing::Test {
protected:
    std::string compared(std::uint32_t number, std::string_view data,
                         const std::string& text = std::string(valve_text)) {
        return compared(number, cip::Response{0x0E, {}, octets(data)}, text);
    }
    std::string compared(std::uint32_t number, cip::Status status) {
        return compared(number, cip::Response{0x0E, std::move(status), {}}, std::string(valve_text));
    }

private:
    static std::string compared(std::uint32_t number, const cip::Response& response, const std::string& text) {
        const auto sheet = test::sheet_of(text);
        return shown(compare_parameter(*sheet.parameter(number), response));
    }
};

TEST_F(SheetParameter, IsAskedForByItsPath) {
    const auto sheet = test::valve();
    EXPECT_EQ(hex(read_request(*sheet.parameter(1))->encode()), hex("0E 03 20 70 24 01 30 01"));
    EXPECT_FALSE(read_request(*sheet.parameter(6))) << "it has no path";
}

TEST_F(SheetParameter, SizeAndLimits) {
    EXPECT_EQ(compared(1, "FA 00"), "equal");
    EXPECT_EQ(compared(1, "9C FF"), "equal") << "-100";
    EXPECT_EQ(compared(1, "9B FF"),
              "different: its value -10.1 in the device is outside the limits of the file, -10.0 to 100.0 bar");
    EXPECT_EQ(compared(1, "FA 00 00 00"), "different: 4 octets in the device, 2 octets by the INT of the file");
    EXPECT_EQ(compared(1, "FA"), "different: 1 octets in the device, 2 octets by the INT of the file");
    EXPECT_EQ(compared(4, "00 00 C8 42"), "equal") << "100.0";
    EXPECT_THAT(compared(4, "01 00 C8 42"), HasSubstr("outside the limits"));
    EXPECT_EQ(compared(5, "02 61 62"), "equal");
    EXPECT_EQ(compared(5, "03 61 62"), "different: 3 octets in the device, 4 octets by the SHORT_STRING of the file");
    EXPECT_THAT(compared(5, "21 " + std::string(33 * 2, '6')), HasSubstr("outside the limits of the file, at most 32"));
    EXPECT_EQ(compared(9, "FF FF FF FF FF FF FF FF"), "equal") << "no limits";
}

TEST_F(SheetParameter, AlteredFilesAreFound) {
    const std::string text(valve_text);
    EXPECT_THAT(compared(1, "FA 00", altered(text, "-100,1000,250", "-100,249,25")), HasSubstr("outside the limits"));
    EXPECT_THAT(compared(1, "FA 00", altered(text, "0xC3,2, \"Set Point\"", "0xC4,4, \"Set Point\"")),
                HasSubstr("2 octets in the device, 4 octets by the DINT of the file"));
    EXPECT_THAT(compared(1, "FA 00", altered(text, "0xC3,2, \"Set Point\"", "0xC3,4, \"Set Point\"")),
                HasSubstr("the file contradicts itself: 4 octets, and INT has 2"));
}

TEST_F(SheetParameter, RefusalsMeanDifferentThings) {
    EXPECT_THAT(compared(1, GeneralStatus::attribute_not_supported),
                HasSubstr("different: the device does not have it"));
    EXPECT_THAT(compared(1, GeneralStatus::path_destination_unknown),
                HasSubstr("different: the device does not have it"));
    EXPECT_THAT(compared(1, GeneralStatus::service_not_supported), HasSubstr("different: the device does not let it"));
    EXPECT_THAT(compared(1, GeneralStatus::attribute_not_gettable), HasSubstr("not_compared: it can only be written"));
    EXPECT_THAT(compared(3, GeneralStatus::attribute_not_gettable),
                HasSubstr("different: the file says that it is read only"));
    EXPECT_THAT(compared(1, {GeneralStatus::vendor_specific, {1}}),
                HasSubstr("not_compared: the device does not tell it now"));
    EXPECT_THAT(compared(1, GeneralStatus::device_state_conflict), HasSubstr("not_compared"));
}

TEST(SheetAssembly, SizesAreCompared) {
    const auto sheet = test::valve();
    const auto& inputs = *sheet.assembly("Assem100");
    EXPECT_EQ(instance_of(inputs), 100U);
    EXPECT_EQ(hex(size_request(100).encode()), hex("0E 03 20 04 24 64 30 04"));
    EXPECT_EQ(hex(data_request(100).encode()), hex("0E 03 20 04 24 64 30 03"));
    const cip::Response refused{0x0E, GeneralStatus::attribute_not_supported, {}};
    const cip::Response missing{0x0E, GeneralStatus::path_destination_unknown, {}};
    EXPECT_EQ(shown(compare_assembly(inputs, assembly_size({0x0E, {}, octets("08 00")}, {}))), "equal");
    EXPECT_EQ(shown(compare_assembly(inputs, assembly_size({0x0E, {}, octets("09 00")}, {}))),
              "different: 9 octets in the device, 8 octets in the file");
    EXPECT_EQ(shown(compare_assembly(inputs, assembly_size(refused, cip::Response{0x0E, {}, cip::Bytes(8)}))), "equal");
    EXPECT_THAT(shown(compare_assembly(inputs, assembly_size(refused, refused))), HasSubstr("not_compared: "));
    EXPECT_THAT(shown(compare_assembly(inputs, assembly_size(missing, missing))),
                HasSubstr("different: the device does not have it"));
}

TEST(SheetConnection, SizesAreThoseOfTheAssemblies) {
    const auto sheet = test::valve();
    const auto compared = [&](std::size_t index, ConnectionSizes sizes) {
        const auto& connection = sheet.connections[index];
        return shown(compare_connection(connection, *plan_of(sheet, connection), sizes));
    };
    const AssemblySize missing{.status = GeneralStatus::path_destination_unknown};
    const AssemblySize untold{.status = GeneralStatus::service_not_supported};
    EXPECT_EQ(compared(0, {{4}, {8}, {3}}), "equal");
    EXPECT_EQ(compared(0, {{4}, {8}, untold}), "equal");
    EXPECT_EQ(compared(0, {{5}, {8}, {3}}),
              "different: O->T: assembly 150 has 5 octets in the device, 4 octets in the file");
    EXPECT_EQ(compared(0, {{4}, {7}, {3}}),
              "different: T->O: assembly 100 has 7 octets in the device, 8 octets in the file");
    EXPECT_EQ(compared(0, {{4}, {8}, {6}}),
              "different: configuration: assembly 151 has 6 octets in the device, 4 octets in the file");
    EXPECT_EQ(compared(0, {missing, {8}, {3}}), "different: O->T: the device has no assembly 150");
    EXPECT_THAT(compared(0, {untold, {8}, {3}}), HasSubstr("not_compared"));
    EXPECT_EQ(compared(1, {missing, {8}, {}}), "equal") << "a heartbeat point need not be an assembly";
}

TEST(SheetFile, DiffersFromALineOn) {
    const auto octets_of = [](std::string_view text) { return cip::Bytes(text.begin(), text.end()); };
    EXPECT_EQ(shown(compare_file(octets_of("a\nb\n"), octets_of("a\nb\n"))), "equal");
    EXPECT_EQ(shown(compare_file(octets_of("a\nb\nc"), octets_of("a\nb\nd"))),
              "different: it is another one: 5 octets in the device, 5 octets here, different from line 3 on");
    EXPECT_THAT(shown(compare_file(octets_of("a\n"), octets_of("a\nb"))), HasSubstr("from line 2 on"));
    EXPECT_THAT(shown(compare_file({}, octets_of("a"))), HasSubstr("from line 1 on"));
}

}  // namespace
}  // namespace servobus::scanner
