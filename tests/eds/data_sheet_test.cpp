#include "eds/data_sheet.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cip/hex.hpp"
#include "tests/eds/sheet_file.hpp"

namespace servobus::eds {
namespace {

using namespace std::chrono;
using testing::ElementsAre;
using testing::IsEmpty;

// A device with everything that sheets of different makers have, in the ways in which they write it.
const std::string sample = test::sheet("mixed.eds");

DataSheet sheet_of(std::string_view text) {
    auto sheet = read(text);
    EXPECT_TRUE(sheet) << to_text(sheet.error());
    return sheet ? *sheet : DataSheet{};
}

std::vector<std::string> findings(const DataSheet& sheet) {
    std::vector<std::string> words;
    for (const auto& finding : sheet.findings) words.push_back(to_text(finding));
    return words;
}

TEST(DataSheet, FileAndDevice) {
    const auto sheet = sheet_of(sample);
    EXPECT_THAT(findings(sheet), IsEmpty());
    EXPECT_EQ(sheet.file.description, "A mixed device");
    EXPECT_EQ(sheet.file.create_date, 2020y / 1 / 31);
    EXPECT_EQ(sheet.file.create_time, 10h + 50min + 30s);
    EXPECT_EQ(sheet.file.modification_date, 2021y / 2 / 1);
    EXPECT_EQ(sheet.file.modification_time, 1s);
    EXPECT_EQ(sheet.file.revision, (Revision{2, 3}));
    EXPECT_EQ(sheet.file.home_url, "http://example.com");
    EXPECT_EQ(sheet.device.vendor, 283);
    EXPECT_EQ(sheet.device.vendor_name, "Someone");
    EXPECT_EQ(sheet.device.product_type, 12);
    EXPECT_EQ(sheet.device.product_type_name, "Communications Adapter");
    EXPECT_EQ(sheet.device.product_code, 0x129);
    EXPECT_EQ(sheet.device.major_revision, 2);
    EXPECT_EQ(sheet.device.minor_revision, 6);
    EXPECT_EQ(sheet.device.product_name, "Mix");
    EXPECT_EQ(sheet.device.catalog, "2270.000");
    EXPECT_EQ(sheet.device.icon, "mix.ico");
    EXPECT_EQ(sheet.device.icon_content, (cip::Bytes{0, 0, 1, 0}));
    EXPECT_THAT(sheet.classifications, ElementsAre("EtherNetIP", "1_Rack"));
}

TEST(DataSheet, Parameters) {
    const auto sheet = sheet_of(sample);
    ASSERT_EQ(sheet.parameters.size(), 11U);
    const auto& mode = *sheet.parameter(7);
    EXPECT_EQ(mode.name, "Mode");
    EXPECT_EQ(mode.help, "Chooses the mode");
    EXPECT_EQ(mode.type, cip::DataType::SINT);
    EXPECT_EQ(mode.size, 1U);
    EXPECT_EQ(mode.minimum, Value(std::int64_t{-2}));
    EXPECT_EQ(mode.maximum, Value(std::int64_t{8}));
    EXPECT_EQ(mode.standard, Value(std::int64_t{-1}));
    EXPECT_TRUE(mode.has(ParameterBit::enumerated) && mode.has(ParameterBit::gaps_in_enumeration));
    EXPECT_FALSE(mode.read_only());
    EXPECT_EQ(mode.address(), (AttributeAddress{0x0F, 7, 1}));
    EXPECT_EQ(*mode.enum_text(-1), "Rotate");
    EXPECT_EQ(mode.enum_text(0), nullptr);
    EXPECT_EQ(mode.enum_value("cyclic"), 8);
    EXPECT_EQ(mode.enum_value("home"), std::nullopt);

    const auto& label = *sheet.parameter(8);
    EXPECT_TRUE(label.read_only());
    EXPECT_EQ(label.size, std::nullopt);
    EXPECT_EQ(label.maximum, Value(std::int64_t{20})) << "characters";
    EXPECT_EQ(label.standard, Value(std::string("motor")));

    EXPECT_EQ(sheet.parameter(9)->minimum, Value(-1.5));
    EXPECT_EQ(sheet.parameter(9)->standard, Value(0.5));
    EXPECT_EQ(sheet.parameter(10)->maximum, Value(std::int64_t{-1})) << "the 64 bits of a ULINT";
    EXPECT_EQ(sheet.parameter(11)->minimum, Value()) << "none stated";
    EXPECT_EQ(sheet.parameter(2)->address(), std::nullopt) << "no path";
    EXPECT_EQ(sheet.parameter(3), nullptr);
    EXPECT_THAT(sheet.parameters_named("OUT POINT"), ElementsAre(sheet.parameter(6)));
    EXPECT_THAT(sheet.parameters_named("nothing"), IsEmpty());
    EXPECT_EQ(sheet.parameter_at({0x0F, 9, 1}), sheet.parameter(9));
    EXPECT_EQ(sheet.parameter_at({0x0F, 1, 1}), nullptr);
}

TEST(DataSheet, Scaling) {
    const auto sheet = sheet_of(sample);
    const auto& rpi = *sheet.parameter(1);
    EXPECT_EQ(rpi.decimals, 1U);
    EXPECT_EQ(rpi.to_engineering(100'000), 100.0) << "milliseconds";
    EXPECT_EQ(rpi.from_engineering(100), 100'000.0);
    const auto& speed = *sheet.parameter(13);
    EXPECT_EQ(speed.to_engineering(7), (7.0 - 1) * 3 * 5 / 2);
    EXPECT_EQ(speed.from_engineering(45), 7.0);
    EXPECT_EQ(speed.scaling.links, (std::array<std::uint32_t, 4>{5, 6, 0, 0}));
    EXPECT_EQ(sheet.parameter(2)->to_engineering(32), 32.0) << "the descriptor has no scaling";
}

TEST(DataSheet, ValuesAsOctets) {
    const auto sheet = sheet_of(sample);
    const auto octets = [&](std::uint32_t number) { return cip::to_hex(sheet.parameter(number)->standard_octets()); };
    EXPECT_EQ(octets(1), "A0 86 01 00");
    EXPECT_EQ(octets(7), "FF");
    EXPECT_EQ(octets(8), "05 00 6D 6F 74 6F 72");
    EXPECT_EQ(octets(9), "00 00 00 3F");
    EXPECT_EQ(octets(10), "01 00 00 00 00 00 00 00");
    EXPECT_EQ(octets(12), "20 0C 21 01");
    const auto& mode = *sheet.parameter(7);
    EXPECT_EQ(mode.encode(std::int64_t{-128}), cip::Bytes{0x80});
    EXPECT_EQ(mode.encode(std::int64_t{-129}), std::nullopt);
    EXPECT_EQ(mode.encode(std::int64_t{128}), std::nullopt);
    EXPECT_EQ(mode.encode(1.5), std::nullopt);
    EXPECT_EQ(mode.encode(std::string("x")), std::nullopt);
    EXPECT_EQ(mode.encode(Value()), std::nullopt);
    EXPECT_EQ(sheet.parameter(5)->encode(std::int64_t{255}), cip::Bytes{0xFF});
    EXPECT_EQ(sheet.parameter(5)->encode(std::int64_t{256}), std::nullopt);
    EXPECT_EQ(sheet.parameter(9)->encode(std::int64_t{1}), (cip::Bytes{0, 0, 0x80, 0x3F}));
}

TEST(DataSheet, Assemblies) {
    const auto sheet = sheet_of(sample);
    ASSERT_EQ(sheet.assemblies.size(), 5U) << "a vendor's own are not looked into";
    const auto& out = *sheet.assembly("Assem100");
    EXPECT_EQ(out.name, "Out");
    EXPECT_EQ(out.number, 100U);
    EXPECT_EQ(out.size, 4U);
    ASSERT_EQ(out.members.size(), 3U);
    EXPECT_EQ(out.members[0].bits, 16U);
    EXPECT_EQ(out.members[0].reference, Member::Reference(Member::Parameter{6}));
    EXPECT_EQ(out.members[1].reference, Member::Reference());
    EXPECT_TRUE(std::holds_alternative<PathPattern>(out.members[2].reference));
    const auto& in = *sheet.assembly("assem101");
    EXPECT_EQ(in.size, 4U) << "1 + 3 + 4 + 16 of Param6 + 8 bits";
    EXPECT_EQ(in.members[2].reference, Member::Reference(std::int64_t{5}));
    EXPECT_EQ(in.members[4].reference, Member::Reference(Member::Assembly{"Assem102"}));
    EXPECT_EQ(sheet.assembly("AssemExa1")->size, 1U);
    EXPECT_EQ(sheet.assembly("Assem1"), nullptr);
}

TEST(DataSheet, ImagesOfDefaultsAndChoices) {
    const auto sheet = sheet_of(sample);
    const auto image = [&](std::string_view keyword, const Choices& choices = {}) {
        return cip::to_hex(sheet.image(*sheet.assembly(keyword), choices));
    };
    EXPECT_EQ(image("Assem100"), "64 00 00 00");
    // Bit 0 of Param11, three bits of nothing, 5 in four bits, Param6, and Assem102.
    EXPECT_EQ(image("Assem101"), "51 64 00 65");
    EXPECT_EQ(image("Assem101", {{6, std::int64_t{110}}, {11, std::int64_t{0}}}), "50 6E 00 65");
    EXPECT_EQ(image("Assem103"), "FF 00 00 00 3F 81 00 00") << "as long as it says";
    EXPECT_EQ(image("Assem103", {{7, std::int64_t{500}}}), "FF 00 00 00 3F 81 00 00")
        << "what does not fit is not taken";
}

TEST(DataSheet, Connections) {
    const auto sheet = sheet_of(sample);
    ASSERT_EQ(sheet.connections.size(), 3U);
    const auto& owner = *sheet.connection("exclusive owner");
    EXPECT_EQ(owner.keyword, "Connection1");
    EXPECT_EQ(owner.help, "Opens it");
    EXPECT_EQ(owner.transport.ownership(), Ownership::exclusive_owner);
    EXPECT_TRUE(owner.transport.allows_class(1) && !owner.transport.allows_class(3));
    EXPECT_TRUE(owner.transport.cyclic() && owner.transport.change_of_state() && owner.transport.application());
    EXPECT_EQ(owner.o_to_t.rpi, (Range{1, 10'000, 1'000'000, 100'000}));
    EXPECT_TRUE(owner.o_to_t.rpi.allows(10'000) && !owner.o_to_t.rpi.allows(9'999) &&
                !owner.o_to_t.rpi.allows(1'000'001));
    EXPECT_EQ(owner.o_to_t.size, (Range{{}, 4, 4, 4})) << "the size of its format";
    EXPECT_EQ(owner.o_to_t.format, "Assem100");
    EXPECT_EQ(owner.t_to_o.size, (Range{2, 0, 504, 32}));
    const auto& listen = *sheet.connection("Connection2");
    EXPECT_EQ(listen.o_to_t.rpi, (Range{{}, 5000, 5000, 5000}));
    EXPECT_EQ(listen.o_to_t.size, (Range{{}, 0, 0, 0}));
    EXPECT_EQ(listen.t_to_o.rpi, Range{}) << "any";
    EXPECT_TRUE(listen.t_to_o.rpi.allows(1));
    EXPECT_EQ(listen.t_to_o.size, (Range{{}, 4, 4, 4}));
    EXPECT_EQ(sheet.connection("nothing"), nullptr);
}

TEST(DataSheet, ConnectionWords) {
    const auto sheet = sheet_of(sample);
    const auto owner = sheet.connections[0].parameters;
    EXPECT_EQ(owner.o_to_t(), (DirectionBits{.fixed = true, .format = 4, .point_to_point = true, .priorities = 4}));
    EXPECT_EQ(owner.t_to_o(),
              (DirectionBits{.fixed = true, .multicast = true, .point_to_point = true, .priorities = 4}));
    EXPECT_TRUE(owner.o_to_t().is(cip::RealTimeFormat::header32) && owner.t_to_o().is(cip::RealTimeFormat::modeless));
    const auto listen = sheet.connections[1].parameters;
    EXPECT_TRUE(listen.o_to_t().is(cip::RealTimeFormat::heartbeat));
    EXPECT_EQ(listen.t_to_o(), (DirectionBits{.fixed = true, .multicast = true, .priorities = 4}));
    EXPECT_EQ((ParameterWord{0xFF77770F}.bits & ParameterWord::reserved_bits), 0U);
    EXPECT_EQ(ParameterWord{0xFF77770F}.o_to_t(), (DirectionBits{true, true, 7, true, true, true, 15}));
    EXPECT_EQ(ParameterWord{0xFF77770F}.t_to_o(), (DirectionBits{true, true, 7, true, true, true, 15}));
    EXPECT_TRUE(sheet.connections[2].transport.server());
    EXPECT_EQ(TransportWord{0x05010002}.ownership(), std::nullopt) << "two of the four bits";
    EXPECT_EQ(TransportWord{0x00010002}.ownership(), std::nullopt);
}

TEST(DataSheet, ConnectionPaths) {
    const auto sheet = sheet_of(sample);
    const auto path = [&](std::size_t index, const Choices& choices = {}, std::string_view symbol = {}) {
        const auto octets = sheet.connection_path(sheet.connections[index], choices, symbol);
        return octets ? cip::to_hex(*octets) : octets.error();
    };
    EXPECT_EQ(path(0), "20 04 24 01 2C 64 00 2C 65") << "as large as the Params are";
    EXPECT_EQ(path(0, {{6, std::int64_t{0x6E}}}), "20 04 24 01 2C 6E 00 2C 65");
    EXPECT_EQ(path(1), "20 04 24 01 2C C0 2C 65");
    EXPECT_EQ(path(2), "the path needs the name of a tag, of 1 to 255 characters");
    EXPECT_EQ(path(2, {}, "Tag"), "91 03 54 61 67 00");
    EXPECT_EQ(path(2, {}, "Tags"), "91 04 54 61 67 73");
    EXPECT_EQ(path(2, {}, std::string(256, 'x')), "the path needs the name of a tag, of 1 to 255 characters");
    auto broken = sheet;
    broken.connections[0].path = {{PathPattern::Parameter{99}}};
    EXPECT_EQ(broken.connection_path(broken.connections[0]).error(), "the path needs Param99, which is not there");
    broken.connections[0].path = {{PathPattern::Parameter{12}}};
    broken.parameters[broken.parameter_index[12]].standard = {};
    EXPECT_EQ(broken.connection_path(broken.connections[0]).error(), "the path needs a value of Param12");
}

TEST(DataSheet, ConfigurationData) {
    const auto sheet = sheet_of(sample);
    EXPECT_EQ(cip::to_hex(sheet.configuration(sheet.connections[0])), "FF 00 00 00 3F 81 00 00");
    EXPECT_EQ(cip::to_hex(sheet.configuration(sheet.connections[1])), "65 00 FF 00 00 00")
        << "the proxy's in two octets, the target's cut to four";
    EXPECT_EQ(cip::to_hex(sheet.configuration(sheet.connections[2])), "FF") << "a Param as format";
    EXPECT_EQ(cip::to_hex(sheet.configuration(sheet.connections[0], {{7, std::int64_t{8}}})),
              "08 00 00 00 3F 81 00 00");
}

TEST(DataSheet, TheRest) {
    const auto sheet = sheet_of(sample);
    ASSERT_EQ(sheet.groups.size(), 1U);
    EXPECT_EQ(sheet.groups[0].name, "Setup");
    EXPECT_THAT(sheet.groups[0].parameters, ElementsAre(7, 8, 9));
    ASSERT_EQ(sheet.ports.size(), 2U);
    EXPECT_EQ(sheet.ports[0].type, "TCP");
    EXPECT_EQ(sheet.ports[0].name, "EtherNet/IP");
    EXPECT_EQ(sheet.ports[0].path.octets(), (cip::Bytes{0x20, 0xF5, 0x24, 0x01}));
    EXPECT_EQ(sheet.ports[0].number, 2);
    EXPECT_EQ(sheet.ports[1].path.octets(), (cip::Bytes{0x20, 0x66, 0x24, 0x01})) << "without quotes";
    EXPECT_EQ(sheet.capacity.io_connections, 5U);
    EXPECT_EQ(sheet.capacity.message_connections, 8U);
    EXPECT_EQ(sheet.capacity.consumers_per_multicast, 4U);
    ASSERT_EQ(sheet.capacity.traffic.size(), 1U);
    EXPECT_EQ(sheet.capacity.traffic[0].direction, "TxRx");
    EXPECT_EQ(sheet.capacity.traffic[0].size, 504U);
    EXPECT_EQ(sheet.capacity.traffic[0].packets_per_second, 3000U);
    ASSERT_EQ(sheet.classes.size(), 3U);
    EXPECT_EQ(sheet.classes[0].section, "Assembly");
    EXPECT_EQ(sheet.classes[0].max_instance, 110U);
    EXPECT_EQ(sheet.classes[1].class_id, 0xF6U);
    EXPECT_EQ(sheet.classes[1].static_instances, 2U);
    EXPECT_EQ(sheet.classes[2].class_id, 0x3ACU);
}

TEST(DataSheet, SaysWhatAFieldShouldBe) {
    const auto sheet = sheet_of(
        "[File]\nCreateDate = 31-12-2020;\nRevision = x;\nDescText = word;\n"
        "[Device]\nVendCode = 70000;\nIconContents = \"*\";\n"
        "[Params]\nParam1 = 0,2,\"20 6\",0x10000,0xC7,2,\"a\",\"\",\"\",low,,;\nEnum2 = 0,\"x\";\n"
        "[Assembly]\nAssem1 = \"a\",\"\",70000,0,,,x,Param1;\n"
        "[Connection Manager]\nConnection1 = 1,1,Param9,,Assem9,y,,,,,,,\"\",\"\",\"\";\n"
        "[Port]\nPort1 = \"TCP\";");
    EXPECT_THAT(
        findings(sheet),
        ElementsAre("line 4: warning: DescText: 'word' should be in quotes",
                    "line 2: error: CreateDate: field 1 is '31-12-2020', no date mm-dd-yyyy",
                    "line 3: error: Revision: field 1 is 'x', no revision like 1.0",
                    "line 6: error: VendCode: field 1 is '70000', no number of 0 to 65535",
                    "line 7: error: IconContents: it is no base64", "line 9: error: Param1: field 3 is '20 6', no path",
                    "line 9: error: Param1: field 4 is '0x10000', no descriptor of 0 to 65535",
                    "line 9: error: Param1: field 10 is 'low', no value of the data type",
                    "line 12: error: Assem1: field 3 is '70000', no size in octets of 0 to 65535",
                    "line 12: error: Assem1: field 7 is 'x', no number of bits of 0 to 4294967295",
                    "line 16: warning: Port1: 'TCP' should not be in quotes",
                    "line 10: error: Enum2: there is no Param2",
                    "line 14: error: Connection1: field 3 is 'Param9', which is not there",
                    "line 14: error: Connection1: field 5 is 'Assem9', which is not there",
                    "line 14: error: Connection1: field 6 is 'y', no number and no Param of 0 to 4294967295"));
}

// What is written as badly as it can be, and what is made of it.
TEST(DataSheet, Quirks) {
    const auto sheet = sheet_of(test::sheet("quirks.eds"));
    EXPECT_EQ(sheet.file.description, "no end of the string");
    EXPECT_EQ(sheet.file.create_date, 2001y / 6 / 6);
    EXPECT_EQ(sheet.file.create_time, 9h + 5min);
    EXPECT_EQ(sheet.file.revision, (Revision{2, 0}));
    EXPECT_EQ(sheet.file.home_url, "C:\\dir\\");
    EXPECT_EQ(sheet.device.vendor, 1);
    EXPECT_EQ(sheet.device.vendor_name, "Someoneelse twice");
    EXPECT_EQ(sheet.device.product_name, "AB");
    ASSERT_EQ(sheet.parameters.size(), 2U);
    EXPECT_EQ(sheet.parameter(1)->address(), (AttributeAddress{0x0F, 1, 1}));
    EXPECT_EQ(sheet.parameter(2)->standard, Value(std::string("x")));
    EXPECT_EQ(*sheet.parameter(2)->enum_text(1), "a");
    EXPECT_EQ(sheet.assembly("Assem1")->size, 4U) << "the inner one counts as the bits that are stated";
    EXPECT_EQ(attribute_address(sheet.assembly("AssemExa2")->path), (AttributeAddress{4, 2, 3}));
    EXPECT_EQ(sheet.assembly("AssemExa2")->size, 2U) << "12 bits";
    const auto& connection = *sheet.connection("n\"1\"");
    EXPECT_EQ(connection.transport.bits, 6U);
    EXPECT_EQ(cip::to_hex(*sheet.connection_path(connection, {{1, std::int64_t{7}}}, "ab")), "2C 07 00 91 02 61 62");
}

TEST(DataSheet, AnAssemblyInsideItselfHasNoSize) {
    const auto sheet = sheet_of("[Assembly]\nAssem1 = \"\",\"\",,0,,,,Assem2;\nAssem2 = \"\",\"\",,0,,,,Assem1;");
    EXPECT_EQ(sheet.assembly("Assem1")->size, std::nullopt);
    EXPECT_THAT(sheet.image(*sheet.assembly("Assem1")), IsEmpty());
}

TEST(DataSheet, AnImageHasALimit) {
    const auto sheet = sheet_of("[Assembly]\nAssem1 = \"\",\"\",,0,,,4000000000,, 8,0xFF;");
    EXPECT_EQ(sheet.assembly("Assem1")->size, std::nullopt);
    EXPECT_EQ(sheet.image(*sheet.assembly("Assem1")).size(), max_image_octets);
}

// Assemblies that each name the next a thousand times would make 10^48 members.
TEST(DataSheet, AnImageLooksAtALimitedNumberOfMembers) {
    std::string text = "[Assembly]\n";
    for (int i = 1; i <= 16; ++i) {
        text += "Assem" + std::to_string(i) + " = \"\",\"\",,0,,";
        for (int member = 0; member < 1000; ++member) text += ",0,Assem" + std::to_string(i + 1);
        text += ";\n";
    }
    const auto sheet = sheet_of(text);
    EXPECT_THAT(sheet.image(*sheet.assembly("Assem1")), IsEmpty());
}

}  // namespace
}  // namespace servobus::eds
