#include "drive/stored_values.hpp"

#include <algorithm>

namespace servobus::drive {

KeptValues::KeptValues(Store& store) : store_(store) {
    for (const auto& row : store_.table()) {
        if (row.same_as || !keeps(row)) continue;
        for (std::uint16_t element = 0; element < row.elements; ++element) places_.push_back({&row, element, {}});
    }
    deliver();
}

bool KeptValues::keeps(const Parameter& row) const {
    const Parameter& owner = row.same_as ? *store_.find(*row.same_as) : row;
    return may_get(owner.access) && may_set(owner.access) && !owner.momentary && !store_.is_selector(owner);
}

void KeptValues::deliver() {
    for (auto& place : places_) place.delivered = store_.lasting(*place.row, place.element);
}

StoredValues KeptValues::changes() const {
    StoredValues changes;
    for (const auto& place : places_) {
        const auto& value = store_.lasting(*place.row, place.element);
        if (value != place.delivered) changes.push_back({place.row->key(), place.element, value});
    }
    return changes;
}

bool KeptValues::fits(const StoredValue& stored) const {
    const auto* row = store_.find(stored.row);
    return row != nullptr && !row->same_as && keeps(*row) && stored.element < row->elements &&
           !check_value(*row, stored.value);
}

std::vector<const Parameter*> KeptValues::restore(const StoredValues& stored) {
    std::vector<const Parameter*> changed;
    for (const auto& place : places_) {
        const auto is_here = [&](const StoredValue& each) {
            return each.row == place.row->key() && each.element == place.element && fits(each);
        };
        const auto found = std::ranges::find_if(stored, is_here);
        const auto& wanted = found != stored.end() ? found->value : place.delivered;
        if (store_.lasting(*place.row, place.element) == wanted) continue;
        store_.set_lasting(*place.row, place.element, wanted);
        if (changed.empty() || changed.back() != place.row) changed.push_back(place.row);
    }
    return changed;
}

}  // namespace servobus::drive
