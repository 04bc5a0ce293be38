// What a device keeps over power-off: the configuration that somebody has written to it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "drive/parameter.hpp"
#include "drive/store.hpp"

namespace servobus::drive {

/// One value that is not as delivered: of a row, and of its element (from 0) where a selector chooses one.
struct StoredValue {
    Key row{};
    std::uint16_t element = 0;
    Value value;

    friend bool operator==(const StoredValue&, const StoredValue&) = default;
};

/// In the order of the table, each place once.
using StoredValues = std::vector<StoredValue>;

/// Which values of a store are kept: those that can be both written and read, save for set points, commands
/// (Parameter::momentary) and the selectors (NIX, NIF, ...), which only choose what others show. What a command changes
/// there is kept as well. What process data writes is not (Store::cover).
class KeptValues {
public:
    /// The store outlives this.
    explicit KeptValues(Store& store);

    [[nodiscard]] bool keeps(const Parameter& row) const;

    /// What the store holds now is how the device is delivered.
    void deliver();
    /// What is not as delivered.
    [[nodiscard]] StoredValues changes() const;

    /// Whether the value could be one of changes().
    [[nodiscard]] bool fits(const StoredValue& stored) const;
    /// Makes changes() these; those that do not fit are left out. Returns the rows whose value is another one now.
    std::vector<const Parameter*> restore(const StoredValues& stored);

private:
    /// Calls `visit` with each row and element whose value is kept, in the order of both.
    void for_each_place(const std::function<void(const Parameter&, std::uint16_t)>& visit) const;
    [[nodiscard]] Value delivered(const Parameter& row, std::uint16_t element) const;

    Store& store_;
    std::vector<const Parameter*> rows_;  ///< that own a variable which is kept
    StoredValues delivered_;              ///< what is not as printed
};

}  // namespace servobus::drive
