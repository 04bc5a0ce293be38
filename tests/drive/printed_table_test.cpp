// The table against the table that the manual prints (tests/reference/xenax_cip_attributes.csv, from 000 §2.3).
// What is not as printed stands in one list, with the id of its entry in docs/errata.md.
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "drive/xenax.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/places.hpp"

namespace servobus::drive {
namespace {

struct Deviation {
    Key key;
    std::string_view column;
    std::string_view value;  ///< what our table says
    std::string_view errata;
};

constexpr auto deviations = std::to_array<Deviation>({
    {{0x65, 0x00}, "low", "0", "S-1"},
    {{0x65, 0x00}, "high", "4294967295", "S-1"},
    {{0x65, 0x19}, "name", "DetectedGantryMasterSlaveOffset", "X-32"},
    {{0x65, 0x20}, "mnemonic", "TCPB1", "S-3"},
    {{0x65, 0x21}, "mnemonic", "TCPB2", "S-3"},
    {{0x65, 0x22}, "mnemonic", "TCPB3", "S-3"},
    {{0x65, 0x23}, "mnemonic", "TCPB4", "S-3"},
    {{0x65, 0x24}, "mnemonic", "TCPB5", "S-3"},
    {{0x65, 0x25}, "mnemonic", "TCPB6", "S-3"},
    {{0x65, 0x26}, "mnemonic", "TCPB7", "S-3"},
    {{0x65, 0x27}, "mnemonic", "TCPB8", "S-3"},
    {{0x65, 0x39}, "low", "0", "X-3"},
    {{0x65, 0x4F}, "default", "10000000", "X-4"},
    {{0x65, 0x59}, "default", "1200", "X-39"},
    {{0x65, 0x74}, "name", "BrakeDelay", "X-32"},
    {{0x65, 0x86}, "low", "500", "X-5"},
    {{0x65, 0x8E}, "default", "0", "X-8"},
    {{0x65, 0x8F}, "default", "3", "X-8"},
    {{0x65, 0xB1}, "name", "TellSMUErrorAlias", "X-33"},
    {{0x65, 0xB5}, "name", "SMUSlaveInfoBitfield", "X-31"},
    {{0x66, 0x33}, "high", "2000", "X-7"},
    {{0x66, 0x45}, "default", "10000000", "X-2"},
    {{0x66, 0x58}, "high", "15", "X-19"},
    {{0x68, 0x04}, "type", "UINT", "X-17"},
    {{0x68, 0x04}, "high", "65535", "X-17"},
    {{0x6E, 0x01}, "name", "SignateqBandwidth", "S-2"},
    {{0x6E, 0x0B}, "access", "Get", "X-14"},
    {{0x6E, 0x0D}, "name", "ForceteqProElasticSpringConstant", "S-2"},
});

using test::Record;

std::uint16_t hex(const std::string& text) { return static_cast<std::uint16_t>(std::stoul(text, nullptr, 16)); }

Key key_of(const Record& record) { return {hex(record.at("class_id")), hex(record.at("attribute_id"))}; }

/// The rows of the classes that a drive has; the others belong to the bus module.
std::vector<Record> printed_rows() {
    const std::set<std::uint16_t> classes{0x64, 0x65, 0x66, 0x67, 0x68, 0x69, 0x6E};
    auto records = test::read_csv(test::data_path("reference/xenax_cip_attributes.csv"));
    std::erase_if(records, [&](const Record& record) { return !classes.contains(key_of(record).class_id); });
    return records;
}

/// Where a command has one name for the motor current and one for the load cell, the first counts.
std::string printed_mnemonic(const Record& record) {
    const auto& mnemonic = record.at("mnemonic");
    return mnemonic.substr(0, mnemonic.find('/'));
}

/// One word of the printed name: without the mnemonic before it, and the remark or unit behind it.
std::string printed_name(const Record& record) {
    std::string name = record.at("name");
    if (name == "Reserved") {
        return name + record.at("attribute_id").substr(2);
    }
    if (const auto mnemonic = printed_mnemonic(record); !mnemonic.empty() && name.starts_with(mnemonic)) {
        name.erase(0, mnemonic.size());
    }
    for (const char* remark : {" (", " “", " in [", " in ms"}) {
        name = name.substr(0, name.find(remark));
    }
    std::string word;
    bool first_letter = true;
    for (const char letter : name) {
        const auto c = static_cast<unsigned char>(letter);
        if (std::isalnum(c) != 0) {
            word += static_cast<char>(first_letter ? std::toupper(c) : c);
            first_letter = false;
        } else {
            first_letter = c < 0x80;  // the registered trademark sign ends no word
        }
    }
    return word;
}

std::string type_name(Type type) {
    switch (type) {
        case Type::i8:
            return "SINT";
        case Type::i16:
            return "INT";
        case Type::i32:
            return "DINT";
        case Type::u8:
            return "USINT";
        case Type::u16:
            return "UINT";
        case Type::u32:
            return "UDINT";
        case Type::text:
            return "STRING";
    }
    return "";
}

std::string access_name(Access access) {
    switch (access) {
        case Access::get:
            return "Get";
        case Access::set:
            return "Set";
        case Access::get_set:
            return "Get/Set";
    }
    return "";
}

/// Our row in the words of the printed table.
Record in_print(const Parameter& row) {
    const auto number = [&row](std::int64_t value) { return row.is_text() ? "" : std::to_string(value); };
    return {{"name", std::string(row.name)},
            {"mnemonic", std::string(row.mnemonic)},
            {"type", type_name(row.cip.type)},
            {"access", access_name(row.access)},
            {"low", number(row.low)},
            {"default", number(row.standard)},
            {"high", number(row.high)},
            {"canopen_index", row.od ? std::to_string(row.od->index) : ""},
            {"canopen_subindex", row.od ? std::to_string(row.od->subindex) : ""}};
}

/// The printed row. A default that is not printed is 0 if that is legal, otherwise the lower limit.
Record printed(const Record& record, const Parameter& row) {
    const auto& index = record.at("canopen_index");
    Record result{{"name", printed_name(record)},
                  {"mnemonic", printed_mnemonic(record)},
                  {"type", record.at("type")},
                  {"access", record.at("access")},
                  {"low", record.at("low_value")},
                  {"default", record.at("default_value")},
                  {"high", record.at("high_value")},
                  {"canopen_index", index.empty() ? "" : std::to_string(hex(index))},
                  {"canopen_subindex", record.at("canopen_subindex")}};
    if (!row.is_text() && result["default"].empty()) {
        result["default"] = row.low <= 0 && 0 <= row.high ? "0" : result["low"];
    }
    return result;
}

const Parameter* row_at(Key key) {
    for (const Parameter& row : parameters()) {
        if (row.key() == key) {
            return &row;
        }
    }
    return nullptr;
}

const Deviation* deviation_of(Key key, std::string_view column) {
    for (const Deviation& each : deviations) {
        if (each.key == key && each.column == column) {
            return &each;
        }
    }
    return nullptr;
}

TEST(PrintedTable, HasAllRowsOfTheManualInItsOrder) {
    const auto records = printed_rows();
    ASSERT_EQ(records.size(), 250U);
    ASSERT_EQ(parameters().size(), 250U);
    for (std::size_t i = 0; i < records.size(); ++i) {
        EXPECT_EQ(parameters()[i].key(), key_of(records[i])) << records[i].at("name");
        EXPECT_EQ(parameters()[i].cip.instance, 1) << records[i].at("name");
    }
}

TEST(PrintedTable, DiffersFromTheManualOnlyWhereErrataSaySo) {
    for (const Record& record : printed_rows()) {
        const Parameter* row = row_at(key_of(record));
        ASSERT_NE(row, nullptr);
        const Record ours = in_print(*row);
        for (const auto& [column, value] : printed(record, *row)) {
            const Deviation* deviation = deviation_of(row->key(), column);
            if (deviation == nullptr) {
                EXPECT_EQ(ours.at(column), value) << row->name << ", " << column;
            } else {
                EXPECT_EQ(ours.at(column), deviation->value) << row->name << ", " << column;
                EXPECT_NE(value, deviation->value) << row->name << ", " << column << " is as printed";
            }
        }
    }
}

TEST(PrintedTable, EveryDeviationIsExplainedInTheErrata) {
    std::ifstream file(test::data_path("../docs/errata.md"));
    const std::string errata{std::istreambuf_iterator<char>(file), {}};
    for (const Deviation& each : deviations) {
        EXPECT_NE(errata.find("| " + std::string(each.errata) + " |"), std::string::npos) << each.errata;
    }
}

}  // namespace
}  // namespace servobus::drive
