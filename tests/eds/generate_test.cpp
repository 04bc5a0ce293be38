// The sheets in eds/ are what the table says; with SERVOBUS_WRITE_EDS=1 (scripts/write-eds) they are written instead of
// compared. What they say is read back with the reader, and compared with the table, the assemblies and the connections.
#include "eds/generate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "assemblies/connection.hpp"
#include "assemblies/layout.hpp"
#include "assemblies/parameter_value.hpp"
#include "cip/hex.hpp"
#include "drive/value_names.hpp"
#include "drive/xenax.hpp"
#include "eds/data_sheet.hpp"
#include "eds/icon.hpp"

namespace servobus::eds {
namespace {

using testing::IsEmpty;

class DataSheetFiles : public testing::TestWithParam<std::string> {
protected:
    drive::Model model_ = *drive::xenax_model(GetParam());
    std::string text_ = generate(model_);
    DataSheet sheet_ = *read(text_);

    bool has(const drive::Parameter& row) const { return !row.force_option || model_.has_force_option; }
    const Parameter* parameter_of(const drive::Parameter& row) const {
        return sheet_.parameter_at({row.cip.class_id, row.cip.instance, row.cip.attribute});
    }
};

INSTANTIATE_TEST_SUITE_P(Variants, DataSheetFiles, testing::Values("75v8s", "75v8", "48v8"),
                         [](const auto& variant) { return variant.param; });

TEST_P(DataSheetFiles, AreWhatTheTableSays) {
    const auto path = std::string(SERVOBUS_EDS) + "/" + file_name(model_);
    if (std::getenv("SERVOBUS_WRITE_EDS") != nullptr) {
        std::ofstream(path, std::ios::binary) << text_;
        return;
    }
    std::ifstream file(path, std::ios::binary);
    const std::string written{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(written, text_) << path << ": scripts/write-eds writes it anew";
}

TEST_P(DataSheetFiles, AreReadWithoutAFinding) {
    for (const auto& finding : sheet_.findings) ADD_FAILURE() << to_text(finding);
}

TEST_P(DataSheetFiles, ArePlainAscii) {
    for (const char c : text_) ASSERT_TRUE(c == '\n' || (c >= ' ' && c <= '~')) << static_cast<int>(c);
}

TEST_P(DataSheetFiles, SayWhoTheDeviceIs) {
    const auto& identity = model_.identity;
    EXPECT_EQ(sheet_.device.vendor, identity.vendor);
    EXPECT_EQ(sheet_.device.vendor_name, "Jenny Science AG");
    EXPECT_EQ(sheet_.device.product_type, identity.device_type);
    EXPECT_EQ(sheet_.device.product_code, identity.product_code);
    EXPECT_EQ(sheet_.device.major_revision, identity.major_revision);
    EXPECT_EQ(sheet_.device.minor_revision, identity.minor_revision);
    EXPECT_EQ(sheet_.device.product_name, identity.product_name);
    EXPECT_EQ(sheet_.file.revision, sheet_revision);
    EXPECT_EQ(sheet_.device.icon, icon_file_name);
    EXPECT_EQ(sheet_.device.icon_content, icon());
    EXPECT_THAT(sheet_.classifications, testing::ElementsAre("EtherNetIP"));
}

TEST_P(DataSheetFiles, HaveAParamForEachRowOfTheVariant) {
    std::size_t rows = 0;
    for (const auto& row : model_.parameters) {
        const auto* parameter = parameter_of(row);
        ASSERT_EQ(parameter != nullptr, has(row)) << row.name;
        if (parameter == nullptr) continue;
        ++rows;
        EXPECT_TRUE(parameter->name == row.name || parameter->name.ends_with("." + std::string(row.name))) << row.name;
        EXPECT_EQ(parameter->type, assemblies::data_type(row.cip.type)) << row.name;
        EXPECT_EQ(parameter->units, row.unit) << row.name;
        EXPECT_TRUE(parameter->help.ends_with(row.text)) << row.name;
        EXPECT_EQ(parameter->help.starts_with("Only to be written."), !drive::may_get(row.access)) << row.name;
        EXPECT_EQ(parameter->read_only(), !drive::may_set(row.access)) << row.name;
        EXPECT_EQ(sheet_.parameters_named(parameter->name).size(), 1U) << row.name;
    }
    EXPECT_EQ(rows + 1, sheet_.parameters.size()) << "and one for the packet interval";
    EXPECT_EQ(model_.has_force_option, rows == model_.parameters.size());
}

TEST_P(DataSheetFiles, HaveTheLimitsOfTheRows) {
    for (const auto& row : model_.parameters) {
        if (!has(row)) continue;
        const auto& parameter = *parameter_of(row);
        if (row.is_text()) {
            EXPECT_EQ(parameter.maximum, Value(static_cast<std::int64_t>(row.max_length))) << row.name;
            EXPECT_EQ(parameter.standard, Value(std::string(row.standard_text))) << row.name;
            EXPECT_EQ(parameter.size, 2 + row.max_length) << row.name;
            continue;
        }
        EXPECT_EQ(parameter.minimum, Value(row.low)) << row.name;
        EXPECT_EQ(parameter.maximum, Value(row.high)) << row.name;
        const bool has_default = row.name != "DirectCommands";
        EXPECT_EQ(parameter.standard, has_default ? Value(row.standard) : Value()) << row.name;
        EXPECT_EQ(parameter.size, drive::size_of(row.cip.type)) << row.name;
    }
}

TEST_P(DataSheetFiles, NameTheListedValues) {
    for (const auto& row : model_.parameters) {
        if (!has(row)) continue;
        const auto& parameter = *parameter_of(row);
        const auto names = drive::value_names(model_, row);
        ASSERT_EQ(parameter.enumeration.size(), names.size()) << row.name;
        EXPECT_EQ(parameter.has(ParameterBit::enumerated), !names.empty()) << row.name;
        for (const auto& [value, name] : names) EXPECT_EQ(*parameter.enum_text(value), name) << row.name;
    }
}

TEST_P(DataSheetFiles, PutEveryRowIntoTheGroupOfItsClass) {
    std::size_t members = 0;
    for (const auto& group : sheet_.groups) {
        for (const auto number : group.parameters) {
            const auto address = sheet_.parameter(number)->address();
            ASSERT_TRUE(address);
            const auto& classes = drive::parameter_classes();
            const auto found = std::ranges::find(classes, address->class_id, &drive::ParameterClass::class_id);
            EXPECT_EQ(group.name, found->title);
            ++members;
        }
    }
    EXPECT_EQ(members + 1, sheet_.parameters.size());
    EXPECT_EQ(sheet_.groups.size(), model_.has_force_option ? 7U : 6U);
}

TEST_P(DataSheetFiles, DescribeTheAssemblies) {
    for (const auto& layout : assemblies::layouts()) {
        const auto* assembly = sheet_.assembly("Assem" + std::to_string(layout.instance));
        ASSERT_NE(assembly, nullptr) << layout.instance;
        EXPECT_EQ(assembly->size, layout.size()) << layout.instance;
        ASSERT_EQ(assembly->members.size(), layout.members.size()) << layout.instance;
        for (std::size_t i = 0; i < layout.members.size(); ++i) {
            const auto& member = layout.members[i];
            EXPECT_EQ(assembly->members[i].bits, 8U * member.octets);
            const auto* reference = std::get_if<Member::Parameter>(&assembly->members[i].reference);
            const auto row = std::ranges::find(model_.parameters, member.key, &drive::Parameter::key);
            const bool expected = member.kind == assemblies::Member::Kind::parameter && has(*row);
            ASSERT_EQ(reference != nullptr, expected) << layout.instance << ' ' << i;
            if (!expected) continue;
            EXPECT_EQ(sheet_.parameter(reference->number), parameter_of(*row));
        }
    }
    for (const auto* empty : {"Assem1", "Assem254", "Assem255"}) EXPECT_EQ(sheet_.assembly(empty)->size, 0U) << empty;
    EXPECT_EQ(sheet_.assemblies.size(), assemblies::layouts().size() + 3);
}

TEST_P(DataSheetFiles, OfferTheConnections) {
    const std::vector<std::string> names{"Standard", "I Force", "Digital Outputs", "Force", "CIP Sync", "Input only"};
    ASSERT_EQ(sheet_.connections.size(), names.size());
    for (std::size_t i = 0; i < names.size(); ++i) {
        const auto& connection = sheet_.connections[i];
        EXPECT_EQ(connection.name, names[i]);
        const auto& meant = assemblies::connections()[i];
        const bool owner = meant.kind == assemblies::Connection::Kind::exclusive_owner;
        // R-EDS-9.
        EXPECT_EQ(connection.transport.bits, owner ? 0x04010002U : 0x02010002U);
        EXPECT_EQ(connection.parameters.bits, owner ? 0x44640405U : 0x44640305U);
        const auto rpi = Range{static_cast<std::uint32_t>(sheet_.parameters.size()), 1000, 3'200'000, 10'000};
        EXPECT_EQ(connection.o_to_t.rpi, rpi);
        EXPECT_EQ(connection.t_to_o.rpi, rpi);
        const auto octets = meant.outputs() != nullptr ? meant.outputs()->size() : 0;
        EXPECT_EQ(connection.o_to_t.size.standard, octets);
        EXPECT_EQ(connection.t_to_o.size.standard, meant.inputs()->size());
        EXPECT_EQ(*sheet_.connection_path(connection),
                  (cip::Bytes{0x20, 0x04, 0x24, 0x01, 0x2C, static_cast<std::uint8_t>(meant.o_to_t_point), 0x2C,
                              static_cast<std::uint8_t>(meant.t_to_o_point)}));
        EXPECT_THAT(sheet_.configuration(connection), IsEmpty());
    }
}

TEST_P(DataSheetFiles, SayHowMuchTheDeviceTakes) {
    EXPECT_EQ(sheet_.capacity.io_connections, 9U);
    EXPECT_EQ(sheet_.capacity.message_connections, 128U);
    ASSERT_EQ(sheet_.capacity.traffic.size(), 1U);
    EXPECT_EQ(sheet_.capacity.traffic[0].size, 54U) << "the outputs of CIP Sync with their header and count";
    EXPECT_EQ(sheet_.capacity.traffic[0].packets_per_second, 18'000U);
    const auto more = *read(generate(model_, {.io = 3, .messages = 5}));
    EXPECT_EQ(more.capacity.io_connections, 3U);
    EXPECT_EQ(more.capacity.message_connections, 5U);
    EXPECT_EQ(more.capacity.traffic[0].packets_per_second, 6'000U);
}

TEST(DataSheetFileNames, AreThoseOfTheManual) {
    std::vector<std::string> names;
    for (const auto& model : drive::xenax_models()) names.push_back(file_name(model));
    EXPECT_THAT(names, testing::ElementsAre("XENAX_XVI_75V8S_EtherNetIP.eds", "XENAX_XVI_75V8_EtherNetIP.eds",
                                            "XENAX_XVI_48V8_EtherNetIP.eds"));
}

TEST(DataSheetFileNames, ADeviceOfAnotherNameHasItsOwnSheet) {
    auto model = *drive::xenax_model("75v8");
    model.identity.product_name = "Press \"3\" \\ left";
    model.identity.major_revision = 2;
    const auto sheet = *read(generate(model));
    EXPECT_EQ(sheet.device.product_name, "Press \"3\" \\ left");
    EXPECT_EQ(sheet.device.major_revision, 2);
    EXPECT_THAT(sheet.findings, IsEmpty());
}

// The fields of the file that other programs look at: the directory, the header and the sizes.
TEST(Icon, IsAPictureOf32By32) {
    const auto octets = icon();
    ASSERT_EQ(octets.size(), 766U);
    EXPECT_EQ(cip::to_hex(cip::ByteView(octets).first(62)),
              "00 00 01 00 01 00 20 20 10 00 01 00 04 00 E8 02 00 00 16 00 00 00 "
              "28 00 00 00 20 00 00 00 40 00 00 00 01 00 04 00 00 00 00 00 80 02 00 00 "
              "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00");
    // Where a pixel is transparent in the mask it is colour 0.
    for (std::size_t y = 0; y < 32; ++y) {
        for (std::size_t x = 0; x < 32; ++x) {
            const auto pair = octets[126 + 16 * y + x / 2];
            const auto colour = x % 2 == 0 ? pair >> 4 : pair & 15;
            const bool masked = (octets[638 + 4 * y + x / 8] >> (7 - x % 8) & 1) != 0;
            ASSERT_EQ(masked, colour == 0) << x << ' ' << y;
        }
    }
}

}  // namespace
}  // namespace servobus::eds
