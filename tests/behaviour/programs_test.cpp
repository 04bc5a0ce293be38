// Programs, profiles of several parts, and running in step with a master: PG, PRF, APSN, SR.
#include <gtest/gtest.h>

#include "drive/motion_memory.hpp"
#include "tests/support/drive_harness.hpp"

namespace servobus {
namespace {

using namespace std::chrono_literals;
using test::DriveHarness;

drive::ProgramStep step(std::string_view line) {
    const auto parsed = drive::parse_step(drive::parameters(), drive::direct_commands(), {0x65, 0x00}, line);
    const auto* wrong = std::get_if<std::string>(&parsed);
    EXPECT_EQ(wrong, nullptr) << line << ": " << (wrong != nullptr ? *wrong : "");
    return wrong != nullptr ? drive::ProgramStep{} : std::get<drive::ProgramStep>(parsed);
}

std::string mistake(std::string_view line) {
    const auto parsed = drive::parse_step(drive::parameters(), drive::direct_commands(), {0x65, 0x00}, line);
    const auto* wrong = std::get_if<std::string>(&parsed);
    return wrong != nullptr ? *wrong : "";
}

DriveHarness with_program(std::initializer_list<std::string_view> lines) {
    drive::Machine machine;
    for (const auto line : lines) machine.memory.programs[1].push_back(step(line));
    return DriveHarness(machine);
}

bool end_of_program(DriveHarness& drive) { return drive.bit("ProcessStatusRegisterXENAX", 4); }

TEST(ProgramStep, IsWrittenLikeTheDrivesOwnCommands) {
    EXPECT_EQ(step("REF"), (drive::ProgramStep{drive::ProgramStep::Kind::write, {0x65, 0x00}, 0x1000}));
    EXPECT_EQ(step("SO 3"), (drive::ProgramStep{drive::ProgramStep::Kind::write, {0x65, 0x2E}, 3}));
    EXPECT_EQ(step("WT 500"), (drive::ProgramStep{drive::ProgramStep::Kind::wait_time, {}, 500}));
    EXPECT_EQ(step("WI 12"), (drive::ProgramStep{drive::ProgramStep::Kind::wait_input, {}, 12}));
}

TEST(ProgramStep, SaysWhatIsWrong) {
    EXPECT_EQ(mistake("DANCE"), "'DANCE' is no direct command");
    EXPECT_EQ(mistake("DANCE 3"), "'DANCE' is no command with a number");
    EXPECT_EQ(mistake("SO x"), "'x' is no number");
    EXPECT_EQ(mistake("SO 9"), "the value is above the upper limit");
    EXPECT_EQ(mistake("WI 13"), "must be 1 to 12");
    EXPECT_EQ(mistake("TP 3"), "'TP' is no command with a number");
    EXPECT_EQ(mistake(""), "'' is no direct command");
}

TEST(Program, RunsStepByStep) {
    auto drive = with_program({"REF", "SP 200000", "G 100000", "SO 1", "WT 200", "WI 2", "G 50000", "CO 1"});
    EXPECT_TRUE(end_of_program(drive));
    drive.set("PG", 1);
    EXPECT_FALSE(end_of_program(drive));
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("TellOutputHex") == 1; }, 10s));
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 100'000, 100);
    drive.run(1s);
    EXPECT_FALSE(end_of_program(drive)) << "it waits for input 2";
    drive.inject(drive::event::SetInput{2, true});
    EXPECT_TRUE(drive.runs_until([&] { return end_of_program(drive); }, 10s));
    EXPECT_EQ(drive.get("TellOutputHex"), 0);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 50'000, 100);
}

TEST(Program, EndsAtAFaultAtSmAndAtWhatCannotBeDone) {
    auto drive = with_program({"REF", "G 200000", "SO 1"});
    drive.set("PG", 1);
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("PositionActualValue") > 100'000; }, 10s));
    drive.command("SM");
    EXPECT_TRUE(end_of_program(drive));
    drive.run(1s);
    EXPECT_EQ(drive.get("TellOutputHex"), 0);

    drive.set("PG", 1);
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("PositionActualValue") > 150'000; }, 10s));
    drive.inject(drive::event::BlockAxis{true});
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("TellError") == 50; }, 3s));
    EXPECT_TRUE(end_of_program(drive));

    auto early = with_program({"G 1000"});
    early.set("PG", 1);
    early.run(10ms);
    EXPECT_TRUE(end_of_program(early));
    EXPECT_EQ(early.get("TellError"), 83) << "motion without power is not possible now";
}

TEST(Program, StartsByItself) {
    drive::Machine machine;
    machine.memory.programs[7] = {step("REF"), step("SO 4")};
    DriveHarness drive(machine);
    drive.set("APSN", 7);
    drive.set("APSD", 300);
    drive.inject(drive::event::PowerCycle{});
    drive.run(200ms);
    EXPECT_TRUE(end_of_program(drive));
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("TellOutputHex") == 8; }, 10s));
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 1));
}

TEST(Program, OfAnEmptyPlaceIsAWarning) {
    DriveHarness drive;
    drive.set("PG", 5);
    EXPECT_EQ(drive.get("TellError"), 81);
    EXPECT_TRUE(drive.bit("Statusword", 7));
    EXPECT_TRUE(drive.bit("ProcessStatusRegisterXENAX", 23));
}

TEST(MotionProfile, DrivesItsPartsOneAfterTheOther) {
    drive::Machine machine;
    machine.memory.profiles[2] = {{120'000, false, 200'000, 2'000'000}, {-40'000, true, 50'000, 500'000}};
    DriveHarness drive(machine);
    drive.reference(1, 0);
    drive.set("PRF", 2);
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("PositionActualValue") > 119'950; }, 5s));
    EXPECT_TRUE(drive.runs_until([&] { return drive.get("TellVelocity") < -40'000; }, 5s));
    EXPECT_TRUE(drive.runs_until([&] { return !drive.bit("ProcessStatusRegisterXENAX", 2); }, 5s));
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), 80'000, 100);
    drive.set("PRF", 3);
    EXPECT_EQ(drive.get("TellError"), 82);
}

TEST(SynchronousRatio, CouplesTheAxisToItsMaster) {
    DriveHarness drive;
    drive.reference(1, 0);
    const auto begin = static_cast<double>(drive.get("PositionActualValue"));
    drive.run(100ms);
    drive.set("SR", 200);
    drive.inject(drive::event::TurnMaster{5'000});
    drive.run(2s);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), begin + 20'000, 100);
    drive.set("SR", -100);
    drive.run(1s);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), begin + 15'000, 100);
    drive.command("SM");
    drive.run(500ms);
    EXPECT_EQ(drive.get("TellVelocity"), 0);
    drive.set("SR", 0);
    drive.run(500ms);
    EXPECT_EQ(drive.get("TellVelocity"), 0);
    EXPECT_NEAR(static_cast<double>(drive.get("PositionActualValue")), begin + 15'000, 200);
    EXPECT_EQ(drive.get("TellError"), 0);
}

}  // namespace
}  // namespace servobus
