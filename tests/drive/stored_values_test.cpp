// What power-off leaves in a drive, and what it takes.
#include "drive/stored_values.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <string>

#include "drive/xenax.hpp"
#include "tests/support/drive_harness.hpp"

namespace servobus::drive {
namespace {

using test::DriveHarness;
using testing::ElementsAre;
using testing::IsEmpty;

Value number(std::int64_t value) { return value; }

constexpr Key s_curve{0x64, 0x00};
constexpr Key index_distance{0x65, 0x5D};
constexpr Key speed{0x66, 0x41};
constexpr Key identification{0x69, 0x02};

TEST(StoredValues, OfANewDriveAreNone) {
    EXPECT_THAT(DriveHarness().device().stored(), IsEmpty());
    EXPECT_THAT(Device(xenax_models()[0]).stored(), IsEmpty());
    EXPECT_THAT(Device(xenax_models()[0], Motor::linear).stored(), IsEmpty());
}

TEST(StoredValues, AreWhatIsNotAsDelivered) {
    DriveHarness drive;
    drive.set("SCurve", 35);
    drive.set("AC", 2'000'000);
    EXPECT_THAT(drive.device().stored(),
                ElementsAre(StoredValue{s_curve, 0, number(35)}, StoredValue{{0x66, 0x43}, 0, number(2'000'000)}));
    drive.set("SCurve", 20);
    EXPECT_THAT(drive.device().stored(), ElementsAre(StoredValue{{0x66, 0x43}, 0, number(2'000'000)}));
}

TEST(StoredValues, HaveTheElementThatWasSelected) {
    DriveHarness drive;
    drive.set("NIX", 3);
    drive.set("DIX", 500);
    drive.set("NIX", 50);
    drive.set("DIX", -7);
    EXPECT_THAT(drive.device().stored(),
                ElementsAre(StoredValue{index_distance, 2, number(500)}, StoredValue{index_distance, 49, number(-7)}))
        << "and the selector itself is not kept";
}

TEST(StoredValues, AreThereAfterAPowerCycleAndSetPointsAreNot) {
    DriveHarness drive;
    drive.set("SCurve", 35);
    drive.set("NIX", 3);
    drive.set("DIX", 500);
    drive.set("PO", 1234);
    drive.set("OVRD", 50);
    drive.set("Controlword", 0x06);
    ASSERT_FALSE(drive.device().write(drive.row("SID"), std::string("press 3")));
    const auto before = drive.device().stored();
    drive.inject(event::PowerCycle{});
    EXPECT_EQ(drive.device().stored(), before);
    EXPECT_EQ(drive.get("SCurve"), 35);
    EXPECT_EQ(drive.text("SID"), "press 3");
    EXPECT_EQ(drive.get("NIX"), 1);
    EXPECT_EQ(drive.get("DIX"), 0);
    drive.set("NIX", 3);
    EXPECT_EQ(drive.get("DIX"), 500);
    EXPECT_EQ(drive.get("PO"), 0);
    EXPECT_EQ(drive.get("OVRD"), 100);
    EXPECT_EQ(drive.word("Controlword"), 0U);
}

TEST(StoredValues, OfAnotherDriveOfTheKindMakeItTheSame) {
    DriveHarness first;
    first.set("MassLoad", 250);
    first.set("StopCurrent", 123);
    DriveHarness second;
    second.device().power_up(first.device().stored());
    EXPECT_EQ(second.get("MassLoad"), 250);
    EXPECT_EQ(second.get("StopCurrent"), 123) << "which the motor tells of a new drive";
    EXPECT_EQ(second.device().stored(), first.device().stored());
}

TEST(StoredValues, OfProcessDataAreThoseFromBefore) {
    DriveHarness drive;
    auto& device = drive.device();
    drive.set("SP", 5000);
    EXPECT_FALSE(device.write_process_data(drive.row("SpeedJogOrProfilePositionMode"), number(9000)));
    EXPECT_FALSE(device.write_process_data(drive.row("SpeedJogOrProfilePositionMode"), number(9001)));
    EXPECT_EQ(device.write_process_data(drive.row("SpeedJogOrProfilePositionMode"), number(-1)), Refusal::too_low);
    EXPECT_EQ(drive.get("SP"), 9001) << "it is in force, also under its other address";
    EXPECT_THAT(device.stored(), ElementsAre(StoredValue{speed, 0, number(5000)}));
    drive.set("SP", 9001);
    EXPECT_THAT(device.stored(), ElementsAre(StoredValue{speed, 0, number(9001)})) << "now somebody has written it";
}

TEST(StoredValues, ProcessDataAreForgottenOverAPowerCycle) {
    DriveHarness drive;
    drive.set("SP", 5000);
    EXPECT_FALSE(drive.device().write_process_data(drive.row("SpeedJogOrProfilePositionMode"), number(9000)));
    drive.inject(event::PowerCycle{});
    EXPECT_EQ(drive.get("SP"), 5000);
}

TEST(StoredValues, ResForgetsAllOfThem) {
    DriveHarness drive;
    drive.set("SCurve", 35);
    drive.set("SP", 5000);
    EXPECT_FALSE(drive.device().write_process_data(drive.row("SpeedJogOrProfilePositionMode"), number(9000)));
    drive.command("RES");
    EXPECT_EQ(drive.get("SP"), 100'000);
    EXPECT_THAT(drive.device().stored(), IsEmpty());
}

TEST(StoredValues, FitWhatTheTableSays) {
    const Device device(xenax_models()[0]);
    EXPECT_TRUE(device.fits({s_curve, 0, number(100)}));
    EXPECT_FALSE(device.fits({s_curve, 0, number(101)})) << "out of its limits";
    EXPECT_FALSE(device.fits({s_curve, 0, std::string("35")}));
    EXPECT_FALSE(device.fits({s_curve, 1, number(35)})) << "there is one element";
    EXPECT_TRUE(device.fits({index_distance, 49, number(35)}));
    EXPECT_FALSE(device.fits({index_distance, 50, number(35)}));
    EXPECT_TRUE(device.fits({identification, 0, std::string("press 3")}));
    EXPECT_FALSE(device.fits({identification, 0, std::string(200, 'x')}));
    EXPECT_FALSE(device.fits({{0x66, 0x00}, 0, number(6)})) << "a control word is a command";
    EXPECT_FALSE(device.fits({{0x65, 0x5A}, 0, number(6)})) << "NIX is a selector";
    EXPECT_FALSE(device.fits({{0x65, 0x2B}, 0, number(6)})) << "G cannot be read";
    EXPECT_FALSE(device.fits({{0x66, 0x24}, 0, number(6)})) << "an actual value cannot be written";
    EXPECT_FALSE(device.fits({{0x65, 0x49}, 0, number(5000)})) << "the second address of 0x66/0x41";
    EXPECT_FALSE(device.fits({{0x65, 0x01}, 0, number(6)})) << "there is no such row";
}

TEST(StoredValues, ThatDoNotFitAreLeftOutAtPowerUp) {
    Device device(xenax_models()[0]);
    device.power_up({{s_curve, 0, number(101)}, {speed, 0, number(5000)}, {speed, 7, number(5000)}});
    EXPECT_THAT(device.stored(), ElementsAre(StoredValue{speed, 0, number(5000)}));
}

TEST(StoredValues, CanBeTakenBackWithThePowerOn) {
    DriveHarness drive;
    drive.set("LIF", 400);
    const auto before = drive.device().stored();
    drive.set("LIF", 800);
    drive.set("SP", 5000);
    drive.set("PO", 1234);
    drive.device().restore(before);
    EXPECT_EQ(drive.get("LIF"), 400);
    EXPECT_EQ(drive.get("SP"), 100'000);
    EXPECT_EQ(drive.get("PO"), 1234) << "which is none of them";
    EXPECT_EQ(drive.device().stored(), before);
}

TEST(StoredValues, TakenBackUnderProcessDataLeaveThatInForce) {
    DriveHarness drive;
    drive.set("SP", 5000);
    EXPECT_FALSE(drive.device().write_process_data(drive.row("SpeedJogOrProfilePositionMode"), number(9000)));
    drive.device().restore({});
    EXPECT_EQ(drive.get("SP"), 9000);
    EXPECT_THAT(drive.device().stored(), IsEmpty());
}

TEST(LastingWrites, CountWhatMayBeKeptAndNoSetPoints) {
    DriveHarness drive;
    const auto count = [&] { return drive.device().lasting_writes(); };
    const auto start = count();
    drive.set("PO", 1234);
    drive.set("Controlword", 0x06);
    drive.set("NIX", 3);
    EXPECT_EQ(drive.try_set("SCurve", 101), Refusal::too_high);
    EXPECT_FALSE(drive.device().write_process_data(drive.row("SCurve"), number(30)));
    EXPECT_EQ(count(), start);
    drive.set("SCurve", 30);
    EXPECT_EQ(count(), start + 1);
    drive.set("SP", 5000);
    EXPECT_EQ(count(), start + 2) << "by a second address";
    drive.command("RES");
    EXPECT_EQ(count(), start + 3);
}

TEST(DeliveredValues, StandUnderWhatIsStored) {
    DriveHarness drive;
    drive.device().deliver({{s_curve, number(40)}, {speed, number(7000)}});
    EXPECT_EQ(drive.get("SCurve"), 40);
    EXPECT_THAT(drive.device().stored(), IsEmpty()) << "it was delivered so";
    drive.set("SCurve", 20);
    EXPECT_THAT(drive.device().stored(), ElementsAre(StoredValue{s_curve, 0, number(20)})) << "the printed default";
    drive.inject(event::PowerCycle{});
    EXPECT_EQ(drive.get("SCurve"), 20);
    EXPECT_EQ(drive.get("SP"), 7000);
    drive.device().reset();
    EXPECT_EQ(drive.get("SCurve"), 40);
}

TEST(DeliveredValues, AreAlsoWhatClientsCannotWrite) {
    constexpr Key version{0x65, 0x1F};
    DriveHarness drive;
    drive.device().deliver({{version, number(123)}});
    EXPECT_EQ(std::get<std::int64_t>(drive.device().store().value(*drive.device().find(version))), 123);
    drive.device().reset();
    EXPECT_EQ(std::get<std::int64_t>(drive.device().store().value(*drive.device().find(version))), 123);
}

TEST(DeliveredValues, ThatAreCommandsAreGivenAfterEachPowerUp) {
    DriveHarness drive;
    drive.device().deliver({{{0x66, 0x00}, number(0x06)}});
    EXPECT_EQ(drive.word("Statusword") & 0x6FU, 0x21U) << "ready to switch on";
    drive.set("Controlword", 0);
    drive.inject(event::PowerCycle{});
    EXPECT_EQ(drive.word("Statusword") & 0x6FU, 0x21U);
}

TEST(MomentaryRows, AreTheSetPointsAndCommandsThatCanBeRead) {
    std::set<std::string> mnemonics;
    for (const auto& row : parameters()) {
        if (!row.momentary) continue;
        EXPECT_EQ(row.access, Access::get_set) << row.name;
        EXPECT_FALSE(row.same_as) << row.name;
        mnemonics.emplace(row.mnemonic.empty() ? row.name : row.mnemonic);
    }
    EXPECT_THAT(mnemonics, ElementsAre("AIXD", "CLFO", "Controlword", "DIXD", "DigitalOutputsXENAX",
                                       "ModesOfOperationRequested", "OVRD", "PO", "SIXD", "TYIXD", "WA"));
}

}  // namespace
}  // namespace servobus::drive
