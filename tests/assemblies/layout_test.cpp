// The assemblies against the table that the manual prints (tests/reference/xenax_assemblies.csv, from 000 §2.4).
#include "assemblies/layout.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "assemblies/parameter_value.hpp"
#include "drive/xenax.hpp"
#include "tests/support/octets.hpp"
#include "tests/support/places.hpp"

namespace servobus::assemblies {
namespace {

using test::hex;
using test::octets;

struct PrintedField {
    std::size_t offset = 0;
    std::size_t length = 0;
    std::string name;
    std::string class_id;
    std::string attribute;
};

struct PrintedAssembly {
    std::string direction;
    std::size_t size = 0;
    std::vector<PrintedField> fields;
};

// Columns: assembly, direction, offset, length, name, class, instance, attribute, type, assembly_bytes, section.
std::map<unsigned, PrintedAssembly> printed_assemblies() {
    std::ifstream file(test::data_path("reference/xenax_assemblies.csv"));
    std::map<unsigned, PrintedAssembly> assemblies;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        std::vector<std::string> cells;
        std::istringstream row(line);
        for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
        auto& assembly = assemblies[static_cast<unsigned>(std::stoul(cells.at(0)))];
        assembly.direction = cells.at(1);
        assembly.size = std::stoul(cells.at(9));
        assembly.fields.push_back(
            {std::stoul(cells.at(2)), std::stoul(cells.at(3)), cells.at(4), cells.at(5), cells.at(7)});
    }
    return assemblies;
}

std::uint16_t number(const std::string& text) { return static_cast<std::uint16_t>(std::stoul(text, nullptr, 16)); }

class Layouts : public testing::Test {
protected:
    void assign(drive::Key key, std::int64_t value) { device.store().assign(*device.find(key), value); }
    std::int64_t value(drive::Key key) const { return std::get<std::int64_t>(device.store().value(*device.find(key))); }
    std::string packed(std::uint16_t instance, std::int64_t time_stamp = 0) const {
        cip::Bytes image(find_layout(instance)->size(), 0xEE);
        pack(*find_layout(instance), device, time_stamp, image);
        return hex(image);
    }
    /// Everything that can be read in the drive, to see that nothing has changed.
    std::vector<drive::Value> everything() const {
        std::vector<drive::Value> values;
        for (const auto& row : device.store().table()) values.push_back(device.store().value(row));
        return values;
    }
    void set_actual_values() {
        assign({0x66, 0x01}, 0x0237);
        assign({0x66, 0x38}, 250);
        assign({0x66, 0x24}, 123456);
        assign({0x64, 0x05}, -125);
        assign({0x64, 0x06}, 3);
        assign({0x66, 0xB4}, -2);
        assign({0x66, 0xBD}, 5);
        assign({0x66, 0xBF}, 1);
        assign({0x64, 0x0A}, 1490);
    }

    drive::Device device{*drive::xenax_model("75v8s")};
};

TEST_F(Layouts, R_DEV_6_every_printed_assembly_is_there_and_no_other) {
    const auto printed = printed_assemblies();
    ASSERT_EQ(printed.size(), 8U);
    EXPECT_EQ(layouts().size(), printed.size());
    for (const auto& [instance, assembly] : printed) {
        const auto* layout = find_layout(instance);
        ASSERT_NE(layout, nullptr) << instance;
        EXPECT_EQ(layout->instance, instance);
        EXPECT_EQ(layout->size(), assembly.size) << instance;
        EXPECT_EQ(layout->direction == Direction::o_to_t ? "O->T" : "T->O", assembly.direction) << instance;
        EXPECT_FALSE(layout->name.empty());
    }
    for (const unsigned instance : {0U, 1U, 99U, 106U, 111U, 114U, 254U, 255U, 65636U}) {
        EXPECT_EQ(find_layout(instance), nullptr) << instance;
    }
}

TEST_F(Layouts, R_DEV_6_every_printed_field_is_where_it_is_printed) {
    for (const auto& [instance, assembly] : printed_assemblies()) {
        const auto& members = find_layout(instance)->members;
        ASSERT_EQ(members.size(), assembly.fields.size()) << instance;
        std::size_t offset = 0;
        for (std::size_t i = 0; i < members.size(); ++i) {
            const auto& field = assembly.fields[i];
            SCOPED_TRACE(std::to_string(instance) + " " + field.name);
            EXPECT_EQ(offset, field.offset);
            EXPECT_EQ(members[i].octets, field.length);
            offset += members[i].octets;
            if (field.class_id.empty()) {
                const bool stamp = field.length == 8;
                EXPECT_EQ(members[i].kind, stamp ? Member::Kind::time_stamp : Member::Kind::padding);
                continue;
            }
            EXPECT_EQ(members[i].kind, Member::Kind::parameter);
            EXPECT_EQ(members[i].key, (drive::Key{number(field.class_id), number(field.attribute)}));
            const auto* row = device.find(members[i].key);
            ASSERT_NE(row, nullptr);
            EXPECT_EQ(row->name, field.name);
            EXPECT_EQ(drive::size_of(row->cip.type), field.length);
        }
    }
}

TEST_F(Layouts, R_ASM_2_packs_the_present_values) {
    set_actual_values();
    // Statusword, current | position | I force | process status | following error | inputs | outputs [| force | time]
    const std::string standard = "3702 FA00 40E20100 83FFFFFF 03000000 FEFFFFFF 05000000 01000000";
    EXPECT_EQ(packed(100), hex(standard));
    EXPECT_EQ(packed(105), hex(standard + "D2050000"));
    EXPECT_EQ(packed(113, 0x00060A2418202240), hex(standard + "D2050000 4022201824 0A0600"));
    EXPECT_EQ(packed(113, -1), hex(standard + "D2050000 FFFFFFFFFFFFFFFF"));
}

TEST_F(Layouts, R_ASM_2_packs_an_output_assembly_too) {
    assign({0x66, 0x3A}, 200'000);
    assign({0x66, 0x00}, 0x001F);
    const auto image = packed(112, 5);
    EXPECT_EQ(image.substr(0, 11), "40 0D 03 00");
    EXPECT_EQ(image.substr(16 * 3, 5), "1F 00");
    EXPECT_EQ(image.substr(36 * 3), hex("00000000 0500000000000000"));
}

constexpr auto standard_octets = "400D0300 50C30000 40420F00 14000000 1F00";

TEST_F(Layouts, R_ASM_4_unpacks_into_the_drive) {
    EXPECT_EQ(unpack(*find_layout(101), octets(standard_octets), device), std::nullopt);
    EXPECT_EQ(value({0x66, 0x3A}), 200'000);
    EXPECT_EQ(value({0x66, 0x41}), 50'000);
    EXPECT_EQ(value({0x66, 0x43}), 1'000'000);
    EXPECT_EQ(value({0x64, 0x00}), 20);
    EXPECT_EQ(value({0x66, 0x00}), 0x1F);
}

TEST_F(Layouts, R_ASM_4_unpacks_all_members_of_the_largest_one) {
    const auto image =
        octets(std::string(standard_octets) + "B004 E8030000 14000000 03000000 DC050000 AAAAAAAA 4022201824 0A0600");
    ASSERT_EQ(image.size(), 48U);
    EXPECT_EQ(unpack(*find_layout(112), image, device), std::nullopt) << "padding and time stamp hold anything";
    EXPECT_EQ(value({0x66, 0x33}), 1200);
    EXPECT_EQ(value({0x66, 0x25}), 1000);
    EXPECT_EQ(value({0x66, 0x27}), 20);
    EXPECT_EQ(value({0x66, 0xBF}), 3);
    EXPECT_EQ(value({0x64, 0x09}), 1500);
}

TEST_F(Layouts, R_ASM_4_keeps_the_sign) {
    EXPECT_EQ(unpack(*find_layout(101), octets("FFFFFFFF 50C30000 40420F00 14000000 0F80"), device), std::nullopt);
    EXPECT_EQ(value({0x66, 0x3A}), -1);
    EXPECT_EQ(value({0x66, 0x00}), static_cast<std::int16_t>(0x800F));
}

TEST_F(Layouts, R_ASM_4_what_is_packed_unpacks_to_the_same) {
    for (const auto& layout : layouts()) {
        if (layout.direction != Direction::o_to_t) continue;
        cip::Bytes image(layout.size());
        pack(layout, device, 0, image);
        const auto before = everything();
        EXPECT_EQ(unpack(layout, image, device), std::nullopt) << layout.instance;
        EXPECT_TRUE(everything() == before) << layout.instance;
    }
}

// Each member in turn is one past its limits while all others hold new legal values: nothing may change.
TEST_F(Layouts, R_ASM_4_one_refused_member_changes_nothing) {
    unsigned refused = 0;
    for (const auto& layout : layouts()) {
        if (layout.direction != Direction::o_to_t) continue;
        for (std::size_t bad = 0; bad < layout.members.size(); ++bad) {
            if (layout.members[bad].kind != Member::Kind::parameter) continue;
            const auto& row = *device.find(layout.members[bad].key);
            if (row.high == drive::highest(row.cip.type) && row.low == drive::lowest(row.cip.type)) continue;
            cip::Bytes image;
            cip::Writer writer(image);
            for (std::size_t i = 0; i < layout.members.size(); ++i) {
                const auto& member = layout.members[i];
                if (member.kind != Member::Kind::parameter) {
                    writer.zeros(member.octets);
                    continue;
                }
                const auto& each = *device.find(member.key);
                const bool above = each.high < drive::highest(each.cip.type);
                const auto wrong = above ? each.high + 1 : each.low - 1;
                write_value(writer, each, i == bad ? wrong : each.high);
            }
            const auto before = everything();
            const auto refusal = unpack(layout, image, device);
            ASSERT_TRUE(refusal) << layout.instance << ' ' << row.name;
            EXPECT_TRUE(refusal == drive::Refusal::too_high || refusal == drive::Refusal::too_low);
            EXPECT_TRUE(everything() == before) << layout.instance << ' ' << row.name;
            ++refused;
        }
    }
    EXPECT_GE(refused, 20U) << "too few members have limits inside their type for this test to say something";
}

TEST_F(Layouts, R_ERR_10_a_member_that_the_variant_does_not_have_is_not_configured) {
    drive::Device plain(*drive::xenax_model("75v8"));
    cip::Bytes image(36);
    pack(*find_layout(104), plain, 0, image);
    EXPECT_EQ(unpack(*find_layout(104), image, plain), drive::Refusal::not_configured);
    EXPECT_EQ(unpack(*find_layout(103), cip::ByteView(image).first(32), plain), std::nullopt);
}

TEST_F(Layouts, R_ASM_4_a_short_image_is_refused) {
    const auto image = octets(standard_octets);
    const auto before = everything();
    for (std::size_t length = 0; length < image.size(); ++length) {
        EXPECT_TRUE(unpack(*find_layout(101), cip::ByteView(image).first(length), device)) << length;
    }
    EXPECT_TRUE(everything() == before);
}

}  // namespace
}  // namespace servobus::assemblies
