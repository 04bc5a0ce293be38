#include "drive/xenax_errors.hpp"

namespace servobus::drive::xenax {
namespace {

constexpr bool ascending_and_unique() {
    return std::ranges::adjacent_find(message_table, std::ranges::greater_equal{}, &Message::number) ==
           message_table.end();
}

constexpr bool fits(const Message& message) {
    return message.number >= 1 && message.number <= 99 && !message.name.empty() && !message.text.empty() &&
           message.text.size() <= longest_text && !message.source.empty();
}

/// Only what interrupts the drive is an error, and an error always does.
constexpr bool reaction_suits(const Message& message) {
    const bool power_goes_off = message.reaction == Reaction::ramp_down || message.reaction == Reaction::power_off;
    return power_goes_off == (message.severity == Severity::error);
}

constexpr bool unique_name(const Message& message) {
    return std::ranges::count(message_table, message.name, &Message::name) == 1;
}

static_assert(ascending_and_unique());
static_assert(std::ranges::all_of(message_table, fits));
static_assert(std::ranges::all_of(message_table, reaction_suits));
static_assert(std::ranges::all_of(message_table, unique_name));
static_assert(no_error_text.size() <= longest_text);

}  // namespace

std::string_view error_text(std::int64_t number) {
    if (number == 0) return no_error_text;
    const Message* const found = find_message(number);
    return found == nullptr ? "unknown number" : found->text;
}

}  // namespace servobus::drive::xenax
