// Every row of the table, read and written as through a bus: at its limits and one past them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "drive/device.hpp"
#include "drive/lookup.hpp"
#include "drive/xenax.hpp"

namespace servobus::drive {
namespace {

std::string label(const Parameter& row) { return qualified_name(parameter_classes(), row); }

bool is_listed(const Parameter& row, std::int64_t value) {
    return row.allowed.empty() || std::ranges::find(row.allowed, value) != row.allowed.end();
}

Device device_with_everything() { return Device(*xenax_model("75v8s")); }

TEST(EveryRow, ReadsItsDefaultUnlessItIsWriteOnly) {
    const Device device = device_with_everything();
    for (const Parameter& row : parameters()) {
        const Value standard = row.is_text() ? Value{std::string(row.standard_text)} : Value{row.standard};
        const auto expected = row.access == Access::set ? ReadResult{Refusal::write_only} : ReadResult{standard};
        EXPECT_EQ(device.read(row), expected) << label(row);
    }
}

TEST(EveryReadOnlyRow, RefusesEveryWrite) {
    Device device = device_with_everything();
    for (const Parameter& row : parameters()) {
        if (row.access == Access::get) {
            EXPECT_EQ(device.write(row, row.standard), Refusal::read_only) << label(row);
            EXPECT_EQ(device.write(row, std::string("text")), Refusal::read_only) << label(row);
        }
    }
}

TEST(EverySettableNumber, TakesLowDefaultAndHighAndNothingBeyond) {
    for (const Parameter& row : parameters()) {
        if (row.access == Access::get || row.is_text()) {
            continue;
        }
        SCOPED_TRACE(label(row));
        Device device = device_with_everything();
        for (const std::int64_t value : {row.low, row.standard, row.high}) {
            const bool listed = is_listed(row, value);
            EXPECT_EQ(device.write(row, value), listed ? std::nullopt : std::optional(Refusal::not_allowed)) << value;
            EXPECT_EQ(device.store().value(row) == Value{value}, listed || value == row.standard) << value;
        }
        const Value before = device.store().value(row);
        EXPECT_EQ(device.write(row, row.low - 1), Refusal::too_low);
        EXPECT_EQ(device.write(row, row.high + 1), Refusal::too_high);
        EXPECT_EQ(device.write(row, std::string("text")), Refusal::wrong_type);
        EXPECT_EQ(device.store().value(row), before);
    }
}

TEST(EveryRowWithListedValues, TakesThoseAndNoNeighbour) {
    for (const Parameter& row : parameters()) {
        if (row.access == Access::get || row.allowed.empty()) {
            continue;
        }
        SCOPED_TRACE(label(row));
        Device device = device_with_everything();
        for (const std::int64_t value : row.allowed) {
            EXPECT_EQ(device.write(row, value), std::nullopt) << value;
            if (!is_listed(row, value + 1) && value < row.high) {
                EXPECT_EQ(device.write(row, value + 1), Refusal::not_allowed) << value + 1;
            }
        }
    }
}

TEST(EverySettableText, TakesUpToItsLength) {
    for (const Parameter& row : parameters()) {
        if (row.access == Access::get || !row.is_text()) {
            continue;
        }
        SCOPED_TRACE(label(row));
        Device device = device_with_everything();
        const std::string longest(row.max_length, 'x');
        EXPECT_EQ(device.write(row, std::string()), std::nullopt);
        EXPECT_EQ(device.write(row, longest), std::nullopt);
        EXPECT_EQ(device.write(row, longest + "x"), Refusal::too_long);
        EXPECT_EQ(device.write(row, std::int64_t{0}), Refusal::wrong_type);
        EXPECT_EQ(device.store().value(row), Value{longest});
    }
}

}  // namespace
}  // namespace servobus::drive
