// What `io` and `open` say about a connection, for people and for programs. Every text is whole lines; every document
// is one line.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scanner/cli/io_options.hpp"
#include "scanner/cli/io_runner.hpp"
#include "scanner/cli/link.hpp"
#include "scanner/originator.hpp"

namespace servobus::scanner::cli {

/// What was granted, a line for each direction.
[[nodiscard]] std::string opened_text(const ConnectionTask& task, const IoOpened& opened);
/// The statistics at the end.
[[nodiscard]] std::string report_text(const IoReport& report);
/// The same in one line, while it runs.
[[nodiscard]] std::string report_line(const IoReport& report);

/// `Statusword 0x0637 (1591)`, `PositionActualValue 1000 increment`, …; octets where there are no names.
[[nodiscard]] std::string inputs_line(const IoFields& fields, cip::ByteView data);
/// A table of the inputs, a line for each member, or for each 16 octets.
[[nodiscard]] std::vector<std::string> inputs_table(const IoFields& fields, cip::ByteView data);

[[nodiscard]] std::string opened_line_json(const std::string& host, const ConnectionTask& task, const IoOpened& opened);
[[nodiscard]] std::string input_line_json(const IoFields& fields, const IoInput& input, double seconds);
[[nodiscard]] std::string closed_line_json(const IoClosed& closed, const std::string& text);
/// The last line. `diagnosis` is a JSON document, or empty.
[[nodiscard]] std::string end_line_json(const std::string& host, const IoReport& report,
                                        const std::optional<Failure>& failure, const std::string& diagnosis);

/// The first line of a table of inputs: what each column is.
[[nodiscard]] std::string csv_header(const IoFields& fields, std::size_t octets);
[[nodiscard]] std::string csv_line(const IoFields& fields, const IoInput& input, double seconds);

}  // namespace servobus::scanner::cli
