// What the compiler cannot prove about the table, and the values that people look for first.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "drive/device.hpp"
#include "drive/xenax.hpp"

namespace servobus::drive {
namespace {

const Parameter& row(std::uint16_t class_id, std::uint16_t attribute) {
    static const Store store(parameters());
    return *store.find({class_id, attribute});
}

TEST(Table, NamesAreOneWordThatStartsWithACapital) {
    for (const Parameter& each : parameters()) {
        EXPECT_TRUE(each.name.front() >= 'A' && each.name.front() <= 'Z') << each.name;
        EXPECT_TRUE(std::ranges::all_of(each.name, [](char c) {
            return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
        })) << each.name;
    }
}

TEST(Table, TextsAreSentencesAndEachSaysSomethingOfItsOwn) {
    std::set<std::string_view> texts;
    for (const Parameter& each : parameters()) {
        EXPECT_GT(each.text.size(), 15U) << each.name;
        EXPECT_EQ(each.text.back(), '.') << each.name;
        EXPECT_TRUE(each.section.starts_with("000 §2.3.")) << each.name;
        EXPECT_TRUE(texts.insert(each.text).second || each.name.starts_with("Reserved")) << each.name;
    }
}

TEST(Table, ReservedRowsSaySo) {
    const auto reserved =
        std::ranges::count_if(parameters(), [](const Parameter& each) { return each.name.starts_with("Reserved"); });
    EXPECT_EQ(reserved, 7);
    EXPECT_TRUE(row(0x65, 0x6B).text.starts_with("Reserved"));
}

TEST(Table, ObjectDictionaryAddressesAreUsedOnce) {
    std::set<std::pair<int, int>> addresses;
    for (const Parameter& each : parameters()) {
        if (each.od) {
            EXPECT_TRUE(addresses.emplace(each.od->index, each.od->subindex).second) << each.name;
        }
    }
    EXPECT_EQ(addresses.size(), 249U);  // SignateqMeasurementRangeNegative has none, errata X-13
}

TEST(Table, ObjectDictionaryLimitsStandOnlyWhereTheyDiffer) {
    for (const Parameter& each : parameters()) {
        if (each.od) {
            EXPECT_NE(each.od->low, each.low) << each.name;
            EXPECT_NE(each.od->standard, each.standard) << each.name;
            EXPECT_NE(each.od->high, each.high) << each.name;
        }
    }
    EXPECT_EQ(row(0x66, 0x38).od->low, -20'000);
    EXPECT_EQ(row(0x66, 0x00).od->high, 65'535);
    EXPECT_EQ(row(0x66, 0x00).od->type, Type::u16);
    EXPECT_EQ(row(0x65, 0x95).od->standard, 0);
    EXPECT_EQ(row(0x6E, 0x09).od->standard, 0);
}

TEST(Table, FormsTellHowPeopleReadARow) {
    EXPECT_EQ(row(0x66, 0x00).form, Form::bits);
    EXPECT_EQ(row(0x64, 0x06).form, Form::bits);
    EXPECT_EQ(row(0x65, 0xBB).form, Form::ipv4);
    EXPECT_EQ(row(0x66, 0x24).form, Form::number);
}

TEST(Table, DirectCommandTakesTheValuesOfTheCommandList) {
    const Parameter& commands = row(0x65, 0x00);
    ASSERT_EQ(commands.allowed.size(), direct_commands().size());
    for (std::size_t i = 0; i < direct_commands().size(); ++i) {
        EXPECT_EQ(commands.allowed[i], direct_commands()[i].value);
    }
    for (const std::int64_t missing : {0x1040, 0x3060, 0x7000, 0x7001}) {
        EXPECT_EQ(std::ranges::find(commands.allowed, missing), commands.allowed.end()) << missing;
    }
}

TEST(Table, DirectCommandsHaveNamesAndTexts) {
    std::set<std::string_view> words;
    for (const DirectCommand& command : direct_commands()) {
        EXPECT_TRUE(words.insert(command.name).second) << command.name;
        EXPECT_TRUE(command.mnemonic.empty() || words.insert(command.mnemonic).second) << command.mnemonic;
        EXPECT_EQ(command.text.back(), '.') << command.name;
    }
}

TEST(Table, SelectedRowsFollowTheirSelector) {
    const auto selected_by = [](std::uint16_t attribute) {
        std::vector<std::string> mnemonics;
        for (const Parameter& each : parameters()) {
            if (each.selected_by == Key{0x65, attribute}) {
                mnemonics.emplace_back(each.mnemonic);
            }
        }
        return mnemonics;
    };
    using Mnemonics = std::vector<std::string>;
    EXPECT_EQ(selected_by(0x5A), (Mnemonics{"AIX", "SIX", "DIX", "TYIX"}));
    EXPECT_EQ(selected_by(0x3E), (Mnemonics{"TYIF", "PAIF", "PBIF", "PCIF"}));
    EXPECT_EQ(selected_by(0x3C), (Mnemonics{"TYOF"}));
    EXPECT_EQ(selected_by(0x78), (Mnemonics{"IFPKn", "FH", "SIFS", "SIFE", "IFL", "IFH", "STCX", "FL"}));
    EXPECT_EQ(selected_by(0x7A), (Mnemonics{"FDF", "ADIF", "SDIF", "IDIF", "DDIF"}));
}

TEST(Table, ForceOptionRowsAreThoseOfTheManual) {
    std::vector<Key> keys;
    for (const Parameter& each : parameters()) {
        if (each.force_option && each.cip.class_id != 0x6E) {
            keys.push_back(each.key());
        }
        EXPECT_TRUE(each.force_option || each.cip.class_id != 0x6E) << each.name;
    }
    EXPECT_EQ(keys, (std::vector<Key>{{0x64, 0x09},
                                      {0x64, 0x0A},
                                      {0x65, 0x38},
                                      {0x65, 0x43},
                                      {0x65, 0x44},
                                      {0x65, 0x45},
                                      {0x65, 0xA7},
                                      {0x65, 0xC4},
                                      {0x65, 0xC5},
                                      {0x65, 0xC6},
                                      {0x65, 0xC7}}));
}

}  // namespace
}  // namespace servobus::drive
