#include "drive/stored_values.hpp"

#include <algorithm>

namespace servobus::drive {

KeptValues::KeptValues(Store& store) : store_(store) {
    for (const auto& row : store_.table()) {
        if (!row.same_as && keeps(row)) rows_.push_back(&row);
    }
    deliver();
}

bool KeptValues::keeps(const Parameter& row) const {
    const Parameter& owner = row.same_as ? *store_.find(*row.same_as) : row;
    return may_get(owner.access) && may_set(owner.access) && !owner.momentary && !store_.is_selector(owner);
}

void KeptValues::for_each_place(const std::function<void(const Parameter&, std::uint16_t)>& visit) const {
    for (const auto* row : rows_) {
        for (std::uint16_t element = 0; element < row->elements; ++element) visit(*row, element);
    }
}

void KeptValues::deliver() {
    delivered_.clear();
    for_each_place([&](const Parameter& row, std::uint16_t element) {
        const auto& value = store_.lasting(row, element);
        if (value != standard_value(row)) delivered_.push_back({row.key(), element, value});
    });
}

Value KeptValues::delivered(const Parameter& row, std::uint16_t element) const {
    const auto found = std::ranges::find_if(
        delivered_, [&](const StoredValue& each) { return each.row == row.key() && each.element == element; });
    return found != delivered_.end() ? found->value : standard_value(row);
}

StoredValues KeptValues::changes() const {
    StoredValues changes;
    for_each_place([&](const Parameter& row, std::uint16_t element) {
        const auto& value = store_.lasting(row, element);
        if (value != delivered(row, element)) changes.push_back({row.key(), element, value});
    });
    return changes;
}

bool KeptValues::fits(const StoredValue& stored) const {
    const auto* row = store_.find(stored.row);
    return row != nullptr && !row->same_as && keeps(*row) && stored.element < row->elements &&
           !check_value(*row, stored.value);
}

std::vector<const Parameter*> KeptValues::restore(const StoredValues& stored) {
    std::vector<const Parameter*> changed;
    for_each_place([&](const Parameter& row, std::uint16_t element) {
        const auto is_here = [&](const StoredValue& each) {
            return each.row == row.key() && each.element == element && fits(each);
        };
        const auto found = std::ranges::find_if(stored, is_here);
        const auto wanted = found != stored.end() ? found->value : delivered(row, element);
        if (store_.lasting(row, element) == wanted) return;
        store_.set_lasting(row, element, wanted);
        if (changed.empty() || changed.back() != &row) changed.push_back(&row);
    });
    return changed;
}

}  // namespace servobus::drive
