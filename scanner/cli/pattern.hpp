// Which of many names somebody means.
#pragma once

#include <string>
#include <string_view>

namespace servobus::scanner::cli {

/// ASCII.
[[nodiscard]] std::string lower_case(std::string_view text);

/// `*` stands for any characters and `?` for one; without either, the pattern may be anywhere in the text.
[[nodiscard]] bool matches(std::string_view pattern, std::string_view text);

}  // namespace servobus::scanner::cli
