// Sheets that are damaged at random, by a seed, and in every place: nothing crashes, and what is read is read again the
// same (tests/support/every_sheet.hpp).
#include <gtest/gtest.h>

#include <random>

#include "tests/eds/sheet_file.hpp"
#include "tests/support/every_sheet.hpp"

namespace servobus::test {
namespace {

class HostileSheets : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Sheets, HostileSheets, testing::Values("clean.eds", "mixed.eds", "quirks.eds"));

TEST_P(HostileSheets, AsItIs) { read_everything(sheet(GetParam())); }

TEST_P(HostileSheets, CutEverywhere) {
    const auto text = sheet(GetParam());
    for (std::size_t length = 0; length < text.size(); ++length)
        read_everything(std::string_view(text).substr(0, length));
}

TEST_P(HostileSheets, WithoutEachCharacterThatMeansSomething) {
    const auto text = sheet(GetParam());
    for (std::size_t at = 0; at < text.size(); ++at) {
        if (std::string_view("[]=;,\"$\n\\").find(text[at]) == std::string_view::npos) continue;
        auto damaged = text;
        damaged.erase(at, 1);
        read_everything(damaged);
    }
}

TEST_P(HostileSheets, DamagedAtRandom) {
    constexpr std::string_view pieces = "[]=;,\"$\n\r\\ 0x9-AParam\x1a\xff";
    const auto text = sheet(GetParam());
    std::mt19937_64 random(20251121);
    for (int round = 0; round < 300; ++round) {
        auto damaged = text;
        for (auto changes = 1 + random() % 20; changes > 0; --changes) {
            const auto at = random() % damaged.size();
            damaged[at] = pieces[random() % pieces.size()];
            if (random() % 4 == 0) damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 200));
            if (random() % 4 == 0) damaged.erase(at, random() % 50);
            if (damaged.empty()) damaged = "[";
        }
        read_everything(damaged);
    }
}

}  // namespace
}  // namespace servobus::test
