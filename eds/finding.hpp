// What a reader or the lint has to say about a place of a data sheet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace servobus::eds {

enum class Severity : std::uint8_t {
    error,    ///< against the format, or impossible: a tool reads something else, or nothing
    warning,  ///< readable, but not as the format asks
};

struct Finding {
    std::size_t line = 0;  ///< counted from 1; 0: of the whole file
    Severity severity = Severity::error;
    std::string words{};  ///< without line and without a full stop

    friend bool operator==(const Finding&, const Finding&) = default;
};

/// "error", "warning".
[[nodiscard]] std::string_view name(Severity severity);
/// As much of a name or value of the text as belongs into a sentence.
[[nodiscard]] std::string_view shown(std::string_view text);
/// `line 12: warning: Param3 has 20 fields, 21 belong there`.
[[nodiscard]] std::string to_text(const Finding& finding);

}  // namespace servobus::eds
