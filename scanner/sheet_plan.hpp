// A connection of a data sheet as what a Forward_Open asks for (R-EDS-8, R-EDS-9).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "eds/data_sheet.hpp"
#include "scanner/io_plan.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner {

/// The connection that somebody means: by name or keyword, the beginning of a name where only one has it, or its number
/// N of ConnectionN. Case does not count. Without a text, the only one. Otherwise the mistake lists them all.
[[nodiscard]] Parsed<const eds::Connection*> choose_connection(const eds::DataSheet& sheet, std::string_view text);

/// What the sheet asks for: path, sizes, formats, configuration and the intervals that it proposes. Of the kinds that it
/// leaves open, point-to-point, fixed size, cyclic and scheduled are taken first.
[[nodiscard]] Parsed<IoPlan> plan_of(const eds::DataSheet& sheet, const eds::Connection& connection);

/// Why a plan is none of those that the sheet allows: a sentence without a full stop, which begins with what is wrong.
/// Nullopt: it is one.
[[nodiscard]] std::optional<Mistake> conflict(const eds::Connection& connection, const IoPlan& plan);

/// The key that lets in the device of the sheet and no other; nullopt when the sheet does not say enough.
[[nodiscard]] std::optional<cip::ElectronicKey> key_of(const eds::Device& device);

/// `exclusive owner`, `input only`; empty when the sheet does not tell.
[[nodiscard]] std::string_view ownership_text(const eds::Connection& connection);

}  // namespace servobus::scanner
