// What is wrong with a data sheet, beyond what its reader stumbles over (R-EDS-2 to R-EDS-10).
#pragma once

#include <string_view>
#include <vector>

#include "eds/document.hpp"
#include "eds/finding.hpp"

namespace servobus::eds {

/// All findings by line, those of parse() and read() among them; those of the whole file first. Empty: nothing is known
/// against the sheet. Errors are what no tool can make sense of, or what contradicts itself; warnings what some tools
/// may refuse, or what was hardly meant.
[[nodiscard]] std::vector<Finding> lint(const Document& document);

/// The same from the text; what is no data sheet at all is the only finding.
[[nodiscard]] std::vector<Finding> lint(std::string_view octets);

}  // namespace servobus::eds
