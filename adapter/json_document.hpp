// JSON whose members know where they stand in the file, so that an error can name line and column.
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

namespace servobus::adapter {

/// Line and column count from 1.
struct Position {
    std::size_t line = 1;
    std::size_t column = 1;
};

struct JsonError {
    Position position;
    std::string reason;
};

struct JsonDocument {
    nlohmann::json root;
    /// Where the key of a member begins, and an object or array inside an array, by JSON pointer:
    /// `/identity/serial_number`, `/events/0`.
    std::map<std::string, Position> positions;
};

/// Fails on malformed JSON and on a key that stands twice in one object.
[[nodiscard]] std::variant<JsonDocument, JsonError> parse_json(const std::string& text);

}  // namespace servobus::adapter
