#include "scanner/cli/sheet_json.hpp"

#include "scanner/cli/sheet_file.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/sheet_value.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
using scanner::type_name;  // of a data sheet; what is called so in here is about the drive's table

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(printable(text)); }

}  // namespace

Json value_json(const eds::Value& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return printable(*text);
    if (const auto* fraction = std::get_if<double>(&value)) return *fraction;
    const auto* whole = std::get_if<std::int64_t>(&value);
    return whole != nullptr ? Json(*whole) : Json();
}

Json parameter_json(const eds::Parameter& parameter) {
    Json json{{"name", text_or_null(parameter.name)},
              {"param", parameter.number},
              {"unit", text_or_null(parameter.units)},
              {"cip", text_or_null(cip_address(parameter))},
              {"type", type_name(parameter.type)},
              {"low", value_json(engineering(parameter, parameter.minimum))},
              {"high", value_json(engineering(parameter, parameter.maximum))}};
    for (const auto& each : parameter.enumeration) {
        json["names"].push_back({{"value", each.value}, {"text", printable(each.text)}});
    }
    return json;
}

std::string document(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n'; }

}  // namespace servobus::scanner::cli
