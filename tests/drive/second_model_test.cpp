// A second drive model is a second table: nothing in Store, Device, lookup or text knows the XENAX.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>

#include "drive/device.hpp"
#include "drive/lookup.hpp"
#include "drive/text.hpp"

namespace servobus::drive {
namespace {

constexpr std::array<DirectCommand, 1> commands{{{7, "HM", "Home", "Drives home."}}};
constexpr std::array<std::int64_t, 2> ways_home{1, 10};

// clang-format off
constexpr std::array<Parameter, 7> table{{
    {.name = "Command", .mnemonic = "", .access = Access::set, .high = 255,
     .cip = {0x300, 1, 1, Type::u8}, .section = "1", .text = "Runs a command."},
    {.name = "Home", .mnemonic = "H", .access = Access::get_set, .low = 1, .standard = 1, .high = 10,
     .allowed = ways_home, .cip = {0x300, 1, 2, Type::u8}, .section = "2", .text = "How to drive home."},
    {.name = "Motor", .mnemonic = "", .standard_text = "none", .max_length = 8,
     .cip = {0x300, 1, 3, Type::text}, .section = "3", .text = "The motor."},
    {.name = "Zone", .mnemonic = "Z", .access = Access::get_set, .low = 5, .standard = 5, .high = 7,
     .cip = {0x301, 1, 1, Type::i8}, .section = "4", .text = "The zone shown."},
    {.name = "Border", .mnemonic = "B", .access = Access::get_set, .low = -100, .standard = -1, .high = 100,
     .form = Form::bits, .cip = {0x301, 1, 2, Type::i8}, .selected_by = Key{0x301, 1}, .elements = 3,
     .section = "5", .text = "The border of the zone."},
    {.name = "BorderAgain", .mnemonic = "B", .access = Access::get_set, .low = -10, .standard = -1, .high = 10,
     .cip = {0x302, 1, 1, Type::i16}, .same_as = Key{0x301, 2}, .section = "6", .text = "The same border."},
    {.name = "Camera", .mnemonic = "", .access = Access::get_set, .high = 1, .force_option = true,
     .cip = {0x302, 1, 2, Type::u8}, .section = "7", .text = "An option."},
}};
// clang-format on

constexpr std::array<ParameterClass, 2> classes{{{0x300, "main", "Main"}, {0x301, "zone", "Zones"}}};

Model other_model() {
    return {.key = "other",
            .name = "Other drive",
            .identity = {.vendor = 1, .product_name = "Other drive"},
            .parameters = table,
            .direct_commands = commands,
            .direct_command_row = Key{0x300, 1},
            .reference_method_row = Key{0x300, 2},
            .motor_names = MotorNames{.row = {0x300, 3}, .linear = "straight", .rotative = "round"}};
}

Value number(std::int64_t value) { return value; }

TEST(SecondModel, StartsWithItsOwnDefaults) {
    const Device device(other_model());
    EXPECT_EQ(device.identity().product_name, "Other drive");
    EXPECT_EQ(device.read(table[1]), ReadResult{number(1)});
    EXPECT_EQ(device.read(table[2]), ReadResult{Value{std::string("none")}});
    EXPECT_EQ(device.find({0x64, 0}), nullptr);
}

TEST(SecondModel, HasItsOwnMotor) {
    Device device(other_model(), Motor::rotative);
    EXPECT_EQ(device.read(table[2]), ReadResult{Value{std::string("round")}});
    EXPECT_EQ(device.write(table[1], number(10)), std::nullopt);
    EXPECT_EQ(device.write(table[1], number(1)), Refusal::not_configured);
    EXPECT_EQ(device.write(table[1], number(2)), Refusal::not_allowed);
}

TEST(SecondModel, LacksItsOption) {
    Device device(other_model());
    EXPECT_EQ(device.write(table[6], number(1)), Refusal::not_configured);
    Model with_option = other_model();
    with_option.has_force_option = true;
    EXPECT_EQ(Device(with_option).write(table[6], number(1)), std::nullopt);
}

TEST(SecondModel, SelectsFromAnyFirstNumberThroughBothAddresses) {
    Device device(other_model());
    EXPECT_EQ(device.write(table[3], number(7)), std::nullopt);
    EXPECT_EQ(device.write(table[4], number(42)), std::nullopt);
    EXPECT_EQ(device.read(table[5]), ReadResult{number(42)});
    EXPECT_EQ(device.write(table[5], number(42)), Refusal::too_high);
    EXPECT_EQ(device.write(table[3], number(5)), std::nullopt);
    EXPECT_EQ(device.read(table[5]), ReadResult{number(-1)});
}

TEST(SecondModel, IsFoundByItsOwnNames) {
    EXPECT_EQ(find_by_name(table, classes, "zone.b"), std::vector<const Parameter*>{&table[4]});
    EXPECT_EQ(find_by_name(table, classes, "B"), std::vector<const Parameter*>{&table[4]});
    EXPECT_EQ(qualified_name(classes, table[1]), "main.Home");
    EXPECT_EQ(qualified_name(classes, table[5]), "0x302.BorderAgain");  // a class without a prefix
    EXPECT_EQ(find_by_name(table, classes, "0x302.BorderAgain"), std::vector<const Parameter*>{&table[5]});
    EXPECT_EQ(find_command(commands, "hm"), &commands[0]);
}

TEST(SecondModel, FormatsItsOwnTypes) {
    EXPECT_EQ(format(table[4], number(-1)), "0xFF (-1)");
    EXPECT_EQ(std::get<Value>(parse(table[4], "0xFF")), number(-1));
}

}  // namespace
}  // namespace servobus::drive
