// Connections of a data sheet as plans (R-EDS-8, R-EDS-9).
#include "scanner/sheet_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drive/xenax.hpp"
#include "eds/generate.hpp"
#include "tests/scanner/sample_sheet.hpp"
#include "tests/support/octets.hpp"

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;
using servobus::test::hex;
using test::altered;
using test::sheet_of;
using test::valve_text;
using testing::HasSubstr;

std::string chosen(const eds::DataSheet& sheet, std::string_view text) {
    const auto connection = choose_connection(sheet, text);
    return connection ? (*connection)->keyword : connection.error().text;
}

IoPlan plan(const eds::DataSheet& sheet, std::string_view name) {
    auto made = plan_of(sheet, **choose_connection(sheet, name));
    EXPECT_TRUE(made) << made.error().text;
    return made ? *made : IoPlan{};
}

TEST(SheetConnections, AreChosenByNameKeywordBeginningOrNumber) {
    const auto sheet = test::valve();
    EXPECT_EQ(chosen(sheet, "Exclusive Owner"), "Connection1");
    EXPECT_EQ(chosen(sheet, "exclusive OWNER"), "Connection1");
    EXPECT_EQ(chosen(sheet, "connection2"), "Connection2");
    EXPECT_EQ(chosen(sheet, "inp"), "Connection2");
    EXPECT_EQ(chosen(sheet, "3"), "Connection3");
    const std::string all = "'Exclusive Owner' (Connection1), 'Input Only' (Connection2), 'Listen Only' (Connection3)";
    EXPECT_EQ(chosen(sheet, ""), "the file has 3 connections; write which: " + all);
    EXPECT_EQ(chosen(sheet, "owner"), "no connection of the file is called 'owner'; there are " + all);
    EXPECT_EQ(chosen(sheet, "4"), "no connection of the file is called '4'; there are " + all);
    EXPECT_EQ(chosen({}, "x"), "the file has no connection");
}

TEST(SheetConnections, OneAloneNeedsNoName) {
    auto sheet = test::valve();
    sheet.connections.resize(1);
    EXPECT_EQ(chosen(sheet, ""), "Connection1");
}

TEST(SheetConnections, ABeginningThatTwoHaveIsNone) {
    const auto sheet = sheet_of(altered(std::string(valve_text), "\"Input Only\"", "\"Exclusive Input\""));
    EXPECT_THAT(chosen(sheet, "excl"), HasSubstr("more than one connection of the file is called 'excl'"));
}

TEST(SheetPlan, HasWhatTheFileSays) {
    const auto sheet = test::valve();
    const auto made = plan(sheet, "1");
    EXPECT_EQ(hex(made.path().encode()), hex("20 04 24 97 2C 96 2C 64 80 02 FA 00 01 00"));
    EXPECT_FALSE(made.application_path) << "the path is of the usual form";
    EXPECT_EQ(made.configuration_instance, 0x97U);
    EXPECT_EQ(made.o_to_t,
              (IoDirection{.point = 150, .data_octets = 4, .format = cip::RealTimeFormat::header32, .rpi = 20ms}));
    EXPECT_EQ(made.t_to_o,
              (IoDirection{.point = 100, .data_octets = 8, .format = cip::RealTimeFormat::modeless, .rpi = 20ms}));
    EXPECT_EQ(made.trigger, enip::Trigger::cyclic);
    EXPECT_FALSE(conflict(*sheet.connection("Connection1"), made));
    const auto inputs = plan(sheet, "2");
    EXPECT_EQ(inputs.o_to_t.format, cip::RealTimeFormat::heartbeat);
    EXPECT_EQ(inputs.o_to_t.data_octets, 0U);
    EXPECT_EQ(hex(inputs.path().encode()), hex("20 04 24 97 2C FE 2C 64"));
    EXPECT_EQ(inputs.t_to_o.type, cip::ConnectionType::point_to_point);
    EXPECT_EQ(plan(sheet, "3").t_to_o.type, cip::ConnectionType::multicast);
}

TEST(SheetPlan, OtherPathsAreTakenAsTheyAre) {
    const auto sheet = sheet_of(altered(std::string(valve_text), "20 04 24 97 2C 96 2C 64", "20 7E 24 05 2C 96 2C 64"));
    const auto made = plan(sheet, "1");
    ASSERT_TRUE(made.application_path);
    EXPECT_EQ(hex(made.path().encode()), hex("20 7E 24 05 2C 96 2C 64 80 02 FA 00 01 00"));
    const auto symbolic =
        sheet_of(altered(std::string(valve_text), "\"20 04 24 97 2C 96 2C 64\"", "\"20 04 24 97 2C 96 2C 64 2C 65\""));
    EXPECT_EQ(hex(plan(symbolic, "1").path().encode()), hex("20 04 24 97 2C 96 2C 64 2C 65 80 02 FA 00 01 00"));
}

TEST(SheetPlan, WhatCannotBeOpened) {
    const auto why = [](std::string_view from, std::string_view to) {
        const auto sheet = sheet_of(altered(std::string(valve_text), from, to));
        const auto made = plan_of(sheet, sheet.connections.front());
        return made ? std::string("a plan") : made.error().text;
    };
    EXPECT_THAT(why("0x04030002", "0x04030008"), HasSubstr("is no connection of class 1"));
    EXPECT_THAT(why("0x44640405", "0x44600405"), HasSubstr("neither multicast nor point-to-point"));
    EXPECT_THAT(why("0x44640405", "0x44640505"), HasSubstr("O->T: the real-time format 5 is none"));
    EXPECT_THAT(why("Param6,,Assem150", "Param6,,"), HasSubstr("O->T: the file does not say how many octets"));
    EXPECT_THAT(why("\"20 04 24 97 2C 96 2C 64\"", "\"[Param77] 2C 64\""), HasSubstr("Param77"));
    EXPECT_THAT(why("\"20 04 24 97 2C 96 2C 64\"", "SYMBOL_ANSI"), HasSubstr("the name of a tag"));
}

TEST(SheetPlan, KeepsInsideTheFile) {
    const auto sheet = test::valve();
    const auto& connection = sheet.connections.front();
    const auto wrong = [&](const std::function<void(IoPlan&)>& change) {
        auto made = plan(sheet, "1");
        change(made);
        const auto found = conflict(connection, made);
        return found ? found->text : std::string("fine");
    };
    EXPECT_EQ(wrong([](IoPlan& p) { p.o_to_t.rpi = 2ms; }), "fine");
    EXPECT_EQ(wrong([](IoPlan& p) { p.t_to_o.rpi = 100ms; }), "fine");
    EXPECT_EQ(wrong([](IoPlan& p) { p.o_to_t.rpi = 1999us; }),
              "O->T: an interval of 1.999 ms; the file allows 2 ms to 100 ms");
    EXPECT_EQ(wrong([](IoPlan& p) { p.t_to_o.rpi = 101ms; }),
              "T->O: an interval of 101 ms; the file allows 2 ms to 100 ms");
    EXPECT_EQ(wrong([](IoPlan& p) { p.o_to_t.data_octets = 5; }), "O->T: 5 octets; the file allows 4 octets");
    EXPECT_EQ(wrong([](IoPlan& p) { p.t_to_o.format = cip::RealTimeFormat::header32; }),
              "T->O: 32-bit run/idle header; the file allows modeless");
    EXPECT_EQ(wrong([](IoPlan& p) { p.t_to_o.type = cip::ConnectionType::multicast; }), "fine");
    EXPECT_EQ(wrong([](IoPlan& p) { p.o_to_t.type = cip::ConnectionType::multicast; }),
              "O->T: multicast; the file allows point-to-point");
    EXPECT_EQ(wrong([](IoPlan& p) { p.o_to_t.priority = cip::Priority::urgent; }),
              "O->T: priority urgent; the file allows scheduled");
    EXPECT_EQ(wrong([](IoPlan& p) { p.t_to_o.variable = true; }), "T->O: a variable size; the file allows a fixed one");
    EXPECT_EQ(wrong([](IoPlan& p) { p.trigger = enip::Trigger::change_of_state; }), "fine");
    EXPECT_EQ(wrong([](IoPlan& p) { p.trigger = enip::Trigger::application; }),
              "the trigger application; the file allows cyclic or cos");
}

TEST(SheetPlan, AKeyFitsTheDeviceOfTheFile) {
    auto device = test::valve().device;
    EXPECT_EQ(key_of(device),
              (cip::ElectronicKey{
                  .vendor = 77, .device_type = 43, .product_code = 5, .major_revision = 2, .minor_revision = 3}));
    device.product_code.reset();
    EXPECT_EQ(key_of(device), std::nullopt);
}

// The sheets that we write ask for what our own connections are.
TEST(SheetPlan, OurOwnSheetsMeanOurOwnConnections) {
    for (const auto& model : drive::xenax_models()) {
        const auto sheet = sheet_of(eds::generate(model));
        ASSERT_FALSE(sheet.connections.empty());
        for (const auto& connection : sheet.connections) {
            const auto made = plan_of(sheet, connection);
            ASSERT_TRUE(made) << connection.name << made.error().text;
            const auto* known = assemblies::find_connection(made->o_to_t.point, made->t_to_o.point);
            ASSERT_NE(known, nullptr) << connection.name;
            auto ours = plan_of(*known);
            ours.o_to_t.rpi = made->o_to_t.rpi;
            ours.t_to_o.rpi = made->t_to_o.rpi;
            if (known->kind == assemblies::Connection::Kind::listen_only) {
                ours.t_to_o.type = cip::ConnectionType::multicast;
            }
            EXPECT_EQ(*made, ours) << connection.name;
            EXPECT_FALSE(conflict(connection, *made));
        }
    }
}

}  // namespace
}  // namespace servobus::scanner
