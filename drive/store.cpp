#include "drive/store.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <utility>

namespace servobus::drive {

namespace {

/// More cells than the members of any process images that one drive takes at a time; taking them asks for no memory then.
constexpr std::size_t usual_covers = 32;
constexpr std::uint16_t npos = std::numeric_limits<std::uint16_t>::max();

/// Our own invariants, checked in production too; nothing that a peer sends can break one.
void require(bool holds, const char* what) {
    if (holds) {
        return;
    }
    std::fputs("servobus::drive::Store: ", stderr);
    std::fputs(what, stderr);
    std::fputs("\n", stderr);
    std::abort();
}

std::optional<Refusal> check_text(const Parameter& row, const std::string& text) {
    if (text.size() > row.max_length) {
        return Refusal::too_long;
    }
    return std::nullopt;
}

std::optional<Refusal> check_number(const Parameter& row, std::int64_t number) {
    if (number < row.low) {
        return Refusal::too_low;
    }
    if (number > row.high) {
        return Refusal::too_high;
    }
    if (!row.allowed.empty() && std::ranges::find(row.allowed, number) == row.allowed.end()) {
        return Refusal::not_allowed;
    }
    return std::nullopt;
}

bool ordered_by_key(std::span<const Parameter> table) {
    return std::ranges::adjacent_find(table, std::greater_equal{}, &Parameter::key) == table.end();
}

}  // namespace

std::optional<Refusal> check_value(const Parameter& row, const Value& value) {
    if (row.is_text() != std::holds_alternative<std::string>(value)) {
        return Refusal::wrong_type;
    }
    return row.is_text() ? check_text(row, std::get<std::string>(value))
                         : check_number(row, std::get<std::int64_t>(value));
}

Value standard_value(const Parameter& row) {
    if (row.is_text()) {
        return std::string(row.standard_text);
    }
    return row.standard;
}

Store::Store(std::span<const Parameter> table)
    : table_(table), first_cell_(table.size(), npos), selector_(table.size(), npos) {
    require(ordered_by_key(table), "the table is not ordered by class, then attribute");
    std::size_t cells = 0;
    for (std::size_t i = 0; i < table.size(); ++i) {
        if (table[i].same_as) {
            continue;
        }
        first_cell_[i] = static_cast<std::uint16_t>(cells);
        cells += table[i].elements;
        if (table[i].selected_by) {
            const Parameter* selector = find(*table[i].selected_by);
            require(selector != nullptr, "selected_by names no row");
            require(table[i].elements == selector->high - selector->low + 1, "a selector reaches other elements");
            selector_[i] = static_cast<std::uint16_t>(index_of(*selector));
        }
    }
    for (std::size_t i = 0; i < table.size(); ++i) {
        if (table[i].same_as) {
            const Parameter* owner = find(*table[i].same_as);
            require(owner != nullptr && !owner->same_as, "same_as does not name the row that owns the variable");
            first_cell_[i] = first_cell_[index_of(*owner)];
            selector_[i] = selector_[index_of(*owner)];
        }
    }
    require(cells < npos && table.size() < npos, "the table is too long");
    cells_.resize(cells);
    covers_.reserve(usual_covers);
    reset();
}

// As one number, because every request searches and two comparisons cost more than one.
const Parameter* Store::find(Key key) const {
    const auto number = [](Key each) { return std::uint32_t{each.class_id} << 16 | each.attribute; };
    const auto found =
        std::ranges::lower_bound(table_, number(key), {}, [&](const Parameter& row) { return number(row.key()); });
    return found != table_.end() && found->key() == key ? &*found : nullptr;
}

ReadResult Store::read(const Parameter& row) const {
    if (!may_get(row.access)) {
        return Refusal::write_only;
    }
    return value(row);
}

std::optional<Refusal> Store::check(const Parameter& row, const Value& value) const {
    if (!may_set(row.access)) {
        return Refusal::read_only;
    }
    return check_value(row, value);
}

std::optional<Refusal> Store::write(const Parameter& row, Value value) {
    if (auto refusal = check(row, value)) {
        return refusal;
    }
    assign(row, std::move(value));
    return std::nullopt;
}

const Value& Store::value(const Parameter& row) const { return cells_[cell_of(row)]; }

void Store::assign(const Parameter& row, Value value) {
    require(row.is_text() == std::holds_alternative<std::string>(value), "a value of the other kind was assigned");
    const auto cell = cell_of(row);
    cells_[cell] = std::move(value);
    if (auto* cover = cover_of(cell)) cover->lasting.reset();
}

void Store::cover(const Parameter& row, Value value) {
    require(row.is_text() == std::holds_alternative<std::string>(value), "a value of the other kind was assigned");
    const auto cell = cell_of(row);
    auto* cover = cover_of(cell);
    if (cover == nullptr) cover = &covers_.emplace_back(Cover{cell, std::nullopt});
    if (!cover->lasting) cover->lasting = cells_[cell];
    cells_[cell] = std::move(value);
}

Store::Cover* Store::cover_of(std::size_t cell) {
    return const_cast<Cover*>(std::as_const(*this).cover_of(cell));  // NOLINT(*-const-cast): this one is not const
}

const Store::Cover* Store::cover_of(std::size_t cell) const {
    const auto found = std::ranges::find(covers_, cell, &Cover::cell);
    return found != covers_.end() ? &*found : nullptr;
}

const Value& Store::lasting(const Parameter& row, std::size_t element) const {
    const auto cell = cell_of(row, element);
    const auto* cover = cover_of(cell);
    return cover != nullptr && cover->lasting ? *cover->lasting : cells_[cell];
}

void Store::set_lasting(const Parameter& row, std::size_t element, Value value) {
    const auto cell = cell_of(row, element);
    require(cells_[cell].index() == value.index(), "a value of the other kind was assigned");
    auto* cover = cover_of(cell);
    (cover != nullptr && cover->lasting ? *cover->lasting : cells_[cell]) = std::move(value);
}

bool Store::is_selector(const Parameter& row) const {
    return std::ranges::find(selector_, index_of(row)) != selector_.end();
}

Variable Store::variable(const Parameter& row, std::size_t element) {
    require(!row.is_text(), "a text has no variable");
    return Variable(cells_[cell_of(row, element)]);
}

void Store::reset() {
    for (auto& cover : covers_) cover.lasting.reset();
    for (std::size_t i = 0; i < table_.size(); ++i) {
        if (!table_[i].same_as) {
            std::fill_n(cells_.begin() + static_cast<std::ptrdiff_t>(first_cell_[i]), table_[i].elements,
                        standard_value(table_[i]));
        }
    }
}

std::size_t Store::index_of(const Parameter& row) const {
    const std::less_equal<const Parameter*> not_after;
    require(not_after(table_.data(), &row) && !not_after(table_.data() + table_.size(), &row),
            "the row is of another table");
    return static_cast<std::size_t>(&row - table_.data());
}

std::size_t Store::cell_of(const Parameter& row) const {
    const std::size_t index = index_of(row);
    if (selector_[index] == npos) {
        return first_cell_[index];
    }
    // A bus cannot bring a selector outside its limits; the drive could, and then gets the nearest element.
    const Parameter& selector = table_[selector_[index]];
    const auto chosen = std::clamp(std::get<std::int64_t>(value(selector)), selector.low, selector.high);
    return first_cell_[index] + static_cast<std::size_t>(chosen - selector.low);
}

std::size_t Store::cell_of(const Parameter& row, std::size_t element) const {
    const std::size_t index = index_of(row);
    const Parameter& owner = row.same_as ? *find(*row.same_as) : row;
    require(element < owner.elements, "there is no such element");
    return first_cell_[index] + element;
}

}  // namespace servobus::drive
