// The members of an assembly of a data sheet as fields of an I/O connection.
#pragma once

#include "eds/data_sheet.hpp"
#include "scanner/cli/io_data.hpp"

namespace servobus::scanner::cli {

/// Fields of one assembly at most; what is behind them has no names.
inline constexpr std::size_t max_sheet_fields = 16'384;

/// The members in their order, those of inner assemblies in their places, padding where nothing is named. Names that come
/// twice get a number: `Data`, `Data#2`. The sheet outlives the fields.
[[nodiscard]] IoFields fields_of(const eds::DataSheet& sheet, const eds::Assembly& assembly);

}  // namespace servobus::scanner::cli
