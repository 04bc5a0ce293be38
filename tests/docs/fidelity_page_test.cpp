// docs/fidelity.md says of every attribute and command how true it is, as the one table does. With
// SERVOBUS_WRITE_DOCS=1 (scripts/write-docs) the page is written instead of compared.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

#include "drive/xenax.hpp"

namespace servobus {
namespace {

constexpr std::string_view begin_mark = "<!-- written from the table: begin -->\n";
constexpr std::string_view end_mark = "<!-- written from the table: end -->\n";

std::string_view word(drive::Fidelity fidelity) {
    switch (fidelity) {
        case drive::Fidelity::behaves:
            return "behaves";
        case drive::Fidelity::stored:
            return "stored";
        case drive::Fidelity::fixed:
            return "fixed";
    }
    return "";
}

std::string hex(const char* form, unsigned number) {
    std::array<char, 16> text{};
    std::snprintf(text.data(), text.size(), form, number);
    return text.data();
}

std::string line(const std::string& address, std::string_view mnemonic, std::string_view name, drive::Fidelity fidelity,
                 std::string_view remark) {
    std::string text = "| " + address + " | ";
    text.append(mnemonic).append(" | ").append(name).append(" | ").append(word(fidelity)).append(" | ");
    return text.append(remark).append(" |\n");
}

template <class Rows>
std::string counts(const Rows& rows) {
    std::string text;
    for (const auto fidelity : {drive::Fidelity::behaves, drive::Fidelity::stored, drive::Fidelity::fixed}) {
        const auto count = std::ranges::count(rows, fidelity, [](const auto& row) { return row.fidelity; });
        text.append(text.empty() ? "" : ", ").append(std::to_string(count)).append(" ").append(word(fidelity));
    }
    return text;
}

std::string page() {
    std::string text = "\n### Direct commands (0x65/1/0): " + counts(drive::direct_commands()) +
                       "\n\n| value | command | name | | remark |\n|---|---|---|---|---|\n";
    for (const auto& command : drive::direct_commands()) {
        text += line(hex("0x%04X", command.value), command.mnemonic, command.name, command.fidelity, command.remark);
    }
    text += "\n### Attributes: " + counts(drive::parameters()) +
            "\n\n| address | command | name | | remark |\n|---|---|---|---|---|\n";
    for (const auto& row : drive::parameters()) {
        text += line(hex("0x%02X", row.cip.class_id) + "/1/" + hex("0x%02X", row.cip.attribute), row.mnemonic, row.name,
                     row.fidelity, row.remark);
    }
    return text + "\n";
}

TEST(FidelityPage, IsWhatTheTableSays) {
    const std::string path = std::string(SERVOBUS_DOCS) + "/fidelity.md";
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto begin = text.find(begin_mark);
    const auto end = text.find(end_mark);
    ASSERT_NE(begin, std::string::npos);
    ASSERT_NE(end, std::string::npos);
    const auto from = begin + begin_mark.size();
    if (std::getenv("SERVOBUS_WRITE_DOCS") != nullptr) {
        std::ofstream(path, std::ios::binary) << text.substr(0, from) << page() << text.substr(end);
        return;
    }
    EXPECT_EQ(text.substr(from, end - from), page()) << "scripts/write-docs writes it anew";
}

// A row that only keeps what is written, or tells one value for ever, says why.
TEST(FidelityPage, ExplainsWhatDoesNotBehave) {
    for (const auto& row : drive::parameters()) {
        EXPECT_TRUE(row.fidelity == drive::Fidelity::behaves || !row.remark.empty()) << row.name;
    }
    for (const auto& command : drive::direct_commands()) {
        EXPECT_TRUE(command.fidelity == drive::Fidelity::behaves || !command.remark.empty()) << command.name;
    }
}

}  // namespace
}  // namespace servobus
