// Parts of a data sheet as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "eds/data_sheet.hpp"

namespace servobus::scanner::cli {

/// `name`, `param`, `unit`, `cip`, `type`, `low`, `high`, `names` of values.
[[nodiscard]] nlohmann::ordered_json parameter_json(const eds::Parameter& parameter);
/// A number, a text, null.
[[nodiscard]] nlohmann::ordered_json value_json(const eds::Value& value);

/// The text of a document, whatever octets are in it.
[[nodiscard]] std::string document(const nlohmann::ordered_json& json);

}  // namespace servobus::scanner::cli
