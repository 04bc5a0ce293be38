// Data sheets out of files.
#pragma once

#include <memory>
#include <string>

#include "eds/data_sheet.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner::cli {

/// The octets of a file that is to be a data sheet; why not, with its name.
[[nodiscard]] Parsed<std::string> read_sheet_file(const std::string& file);

/// The sheet in it. Findings do not matter: whatever can be read is.
[[nodiscard]] Parsed<std::shared_ptr<const eds::DataSheet>> load_sheet(const std::string& file);

/// Parameters of a sheet that a word means: by name (case, blanks and punctuation do not count), `Param12`, or the
/// address of the attribute. One; otherwise the mistake says which are near.
[[nodiscard]] Parsed<const eds::Parameter*> find_parameter(const eds::DataSheet& sheet, std::string_view word);

/// `SCurve`, or `Param12` where the sheet has that name again or none.
[[nodiscard]] std::string display_name(const eds::DataSheet& sheet, const eds::Parameter& parameter);

/// `0x64/1/0x00`; empty for a parameter without an address.
[[nodiscard]] std::string cip_address(const eds::Parameter& parameter);

}  // namespace servobus::scanner::cli
