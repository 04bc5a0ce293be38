#include "drive/lookup.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace servobus::drive {
namespace {

std::vector<std::string> found(std::string_view what) {
    std::vector<std::string> names;
    for (const Parameter* row : find_by_name(parameters(), parameter_classes(), what)) {
        names.push_back(qualified_name(parameter_classes(), *row));
    }
    return names;
}

std::vector<std::string> nearest(std::string_view what) {
    return nearest_names(parameters(), parameter_classes(), what);
}

using Names = std::vector<std::string>;

TEST(FindByName, TakesNameMnemonicAndBoth) {
    EXPECT_EQ(found("TellStatus"), Names{"command.TellStatus"});
    EXPECT_EQ(found("TS"), Names{"command.TellStatus"});
    EXPECT_EQ(found("TS: Tell Status"), Names{"command.TellStatus"});
}

TEST(FindByName, IgnoresCaseBlanksAndPunctuation) {
    EXPECT_EQ(found("ts"), Names{"command.TellStatus"});
    EXPECT_EQ(found("tell status"), Names{"command.TellStatus"});
    EXPECT_EQ(found("Deceleration, Quick Stop"), Names{"drive.DecelerationQuickStop"});
    EXPECT_EQ(found("S-Curve"), Names{"general.SCurve"});
    EXPECT_EQ(found("XENAX® Error Number"), Names{"general.XENAXErrorNumber"});
}

TEST(FindByName, ReadsADotAsClassOnlyWhenItFollowsOne) {
    EXPECT_EQ(found("drive.Controlword"), Names{"drive.Controlword"});
    EXPECT_EQ(found("0x66.Controlword"), Names{"drive.Controlword"});
    EXPECT_EQ(found("102.Controlword"), Names{"drive.Controlword"});
    EXPECT_EQ(found("general.Controlword"), Names{});
    EXPECT_EQ(found("Tell Capture Pos.Buffer 1"), Names{"command.TellCapturePosBuffer1"});
}

TEST(FindByName, GivesTheOwnerOfAVariableWithTwoAddresses) {
    EXPECT_EQ(found("AC"), Names{"drive.AccelerationJogOrProfilePositionMode"});
    EXPECT_EQ(found("TE"), Names{"general.XENAXErrorNumber"});
    EXPECT_EQ(found("LimitIForce"), Names{"drive.LimitIForce"});
    EXPECT_EQ(found("TESM"), Names{"command.TellSMUError"});
    EXPECT_EQ(found("SQBW"), Names{"forceteq.SignateqBandwidth"});
}

TEST(FindByName, ReachesTheSecondAddressThroughItsClassOrItsOwnName) {
    EXPECT_EQ(found("command.AC"), Names{"command.Acceleration"});
    EXPECT_EQ(found("Acceleration"), Names{"command.Acceleration"});
    EXPECT_EQ(found("command.LimitIForce"), Names{"command.LimitIForce"});
}

TEST(FindByName, PrefersANameToAMnemonic) {
    EXPECT_EQ(found("Mode"), Names{"command.Mode"});
    EXPECT_EQ(found("Speed"), Names{"command.Speed"});
}

TEST(FindByName, GivesAllRowsOfASharedMnemonic) {
    EXPECT_EQ(found("EMAC"), (Names{"command.ReadMACAddress3HighBytes", "command.ReadMACAddress3LowBytes"}));
}

TEST(FindByName, FindsNothingInNothing) {
    for (const char* what : {"", " ", ".", "drive.", "NoSuchThing", "Tell"}) {
        EXPECT_EQ(found(what), Names{}) << what;
    }
}

TEST(QualifiedName, LeadsBackToItsRow) {
    for (const Parameter& row : parameters()) {
        const auto rows = find_by_name(parameters(), parameter_classes(), qualified_name(parameter_classes(), row));
        EXPECT_EQ(rows, std::vector<const Parameter*>{&row}) << row.name;
    }
}

TEST(EveryName, AndEveryMnemonicFindsARow) {
    for (const Parameter& row : parameters()) {
        EXPECT_EQ(found(row.name).size(), 1U) << row.name;
        if (!row.mnemonic.empty()) {
            EXPECT_EQ(found(row.mnemonic).size(), row.mnemonic == "EMAC" ? 2U : 1U) << row.mnemonic;
        }
    }
}

TEST(NearestNames, KnowsWhatWasMeant) {
    EXPECT_EQ(nearest("Contolword").front(), "Controlword");
    EXPECT_EQ(nearest("statusword ").front(), "Statusword");
    EXPECT_EQ(nearest("S-Cuve").front(), "SCurve");
    EXPECT_EQ(nearest("PositionActual").front(), "PositionActualValue");
    EXPECT_EQ(nearest("drive.Contolword").front(), "drive.Controlword");
}

TEST(NearestNames, PrefersBeginningsToOtherParts) {
    EXPECT_EQ(nearest("TargetPositon"),
              (Names{"TargetPositionWindow", "TargetPositionWindowTime", "TargetPositionOrDistance"}));
    EXPECT_EQ(nearest("WebsiteAddress"), Names{"ProductWebsiteAddress"});
}

TEST(NearestNames, GivesAtMostTheCountAndNoneTwice) {
    const auto names = nearest("TX");
    EXPECT_EQ(names.size(), 3U);
    EXPECT_NE(names[0], names[1]);
    EXPECT_EQ(nearest_names(parameters(), parameter_classes(), "TX", 1).size(), 1U);
    EXPECT_TRUE(nearest_names(parameters(), parameter_classes(), "TX", 0).empty());
}

TEST(NearestNames, DoesNotGuessWildly) {
    EXPECT_EQ(nearest(""), Names{});
    EXPECT_EQ(nearest("refrigerator"), Names{});
}

TEST(NearestNames, AreNamesThatAreFound) {
    for (const Parameter& row : parameters()) {
        for (const std::string& name : nearest(std::string(row.name) + "x")) {
            EXPECT_EQ(found(name).size(), 1U) << name;
        }
    }
}

TEST(FindCommand, TakesMnemonicNameAndNumber) {
    const auto commands = direct_commands();
    const DirectCommand* reference = find_command(commands, "ref");
    ASSERT_NE(reference, nullptr);
    EXPECT_EQ(reference->value, 0x1000U);
    EXPECT_EQ(find_command(commands, "Reference"), reference);
    EXPECT_EQ(find_command(commands, "0x1000"), reference);
    EXPECT_EQ(find_command(commands, "4096"), reference);
    EXPECT_EQ(find_command(commands, "Start force monitoring")->value, 0x6000U);
}

TEST(FindCommand, DoesNotKnowReservedValues) {
    for (const char* what : {"0x1040", "0x3060", "0x7000", "0x7001", "", "Reserved", "0"}) {
        EXPECT_EQ(find_command(direct_commands(), what), nullptr) << what;
    }
}

TEST(NearestCommands, KnowsWhatWasMeant) {
    EXPECT_EQ(nearest_commands(direct_commands(), "REFF").front(), "REF");
    EXPECT_EQ(nearest_commands(direct_commands(), "PowerOff").front(), "PW");
    EXPECT_EQ(nearest_commands(direct_commands(), "StartForceMonitor").front(), "StartForceMonitoring");
    EXPECT_TRUE(nearest_commands(direct_commands(), "").empty());
}

}  // namespace
}  // namespace servobus::drive
