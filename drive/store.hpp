// The values behind a parameter table, and the rules by which a bus may change them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "drive/parameter.hpp"
#include "drive/refusal.hpp"

namespace servobus::drive {

/// What a parameter holds: a number in the row's unit, or characters.
using Value = std::variant<std::int64_t, std::string>;

/// Either the value, or why there is none.
using ReadResult = std::variant<Value, Refusal>;

/// Whether a row can hold a value at all, whoever brings it: its kind, its limits, its listed values.
[[nodiscard]] std::optional<Refusal> check_value(const Parameter& row, const Value& value);

/// The printed default of a row, or nothing of its kind: 0, no characters.
[[nodiscard]] Value standard_value(const Parameter& row);

/// The number behind a row, for a drive that looks at it ten thousand times a second. Valid as long as its store.
class Variable {
public:
    Variable() = default;
    explicit Variable(Value& cell) : cell_(&cell) {}

    [[nodiscard]] std::int64_t get() const { return *std::get_if<std::int64_t>(cell_); }
    /// The caller keeps it inside the row's type.
    void set(std::int64_t number) { *std::get_if<std::int64_t>(cell_) = number; }

private:
    Value* cell_ = nullptr;
};

/// Values of one table. Rows with the same variable (`same_as`) share one cell; rows chosen by a selector
/// (NIX, NIF, ...) have one cell per element and show the selected one.
/// Every `Parameter` given must be a row of the table that the store was built with.
class Store {
public:
    /// All values start at their printed defaults. The table must outlive the store, and be ordered by class, then
    /// attribute; what it names in `same_as` and `selected_by` must be in it.
    explicit Store(std::span<const Parameter> table);

    [[nodiscard]] std::span<const Parameter> table() const { return table_; }

    /// The row at a CIP class and attribute, or nullptr.
    [[nodiscard]] const Parameter* find(Key key) const;

    /// What a bus reads; refuses write-only rows.
    [[nodiscard]] ReadResult read(const Parameter& row) const;

    /// Whether a bus may write this, in the order access, type, limits, listed values. Changes nothing.
    [[nodiscard]] std::optional<Refusal> check(const Parameter& row, const Value& value) const;

    /// What a bus writes. A refused write changes nothing.
    [[nodiscard]] std::optional<Refusal> write(const Parameter& row, Value value);

    /// The drive's own view of a row, whatever its access.
    [[nodiscard]] const Value& value(const Parameter& row) const;

    /// The drive's own change of a row (status, actual values). The caller keeps it inside the type.
    void assign(const Parameter& row, Value value);

    /// What a controller's process data brings: it is shown and in force, and what the row held before is what lasts until
    /// something else writes it.
    void cover(const Parameter& row, Value value);

    /// What an element (from 0) of a row holds for good: its value, or the one under process data.
    [[nodiscard]] const Value& lasting(const Parameter& row, std::size_t element) const;
    void set_lasting(const Parameter& row, std::size_t element, Value value);

    /// Whether the row chooses which elements others show.
    [[nodiscard]] bool is_selector(const Parameter& row) const;

    /// The variable behind a row of numbers; element `element` (from 0) of a selected row, whatever its selector says.
    [[nodiscard]] Variable variable(const Parameter& row, std::size_t element = 0);

    /// Back to the printed defaults.
    void reset();

private:
    [[nodiscard]] std::size_t index_of(const Parameter& row) const;
    [[nodiscard]] std::size_t cell_of(const Parameter& row) const;
    [[nodiscard]] std::size_t cell_of(const Parameter& row, std::size_t element) const;

    /// What lasts while process data stands in a cell. Cells that it has come to once keep their place here, so that more
    /// of it asks for no memory; they are as many as the process images have members.
    struct Cover {
        std::size_t cell;
        std::optional<Value> lasting;
    };
    [[nodiscard]] Cover* cover_of(std::size_t cell);
    [[nodiscard]] const Cover* cover_of(std::size_t cell) const;

    std::span<const Parameter> table_;
    std::vector<std::uint16_t> first_cell_;  ///< per row: the first cell of its variable
    std::vector<std::uint16_t> selector_;    ///< per row: the row that selects its element, or none
    std::vector<Value> cells_;
    std::vector<Cover> covers_;
};

}  // namespace servobus::drive
