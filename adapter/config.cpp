#include "adapter/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <string_view>

#include "adapter/json_document.hpp"
#include "drive/lookup.hpp"
#include "drive/text.hpp"
#include "drive/xenax.hpp"

namespace servobus::adapter {
namespace {

using nlohmann::json;

constexpr std::size_t max_file_bytes = std::size_t{1} << 20;  // of a configuration, and of an EDS
constexpr std::size_t max_product_name = 32;                  // R-ID-1
// Enough for every descriptor that a process usually may open, and less than would exhaust memory.
constexpr std::size_t max_limit = 100'000;
// The lower half of a connection id is a number of 16 bits (R-CON-16).
constexpr std::size_t max_class3_connections = 65'535;

constexpr std::array<std::pair<std::string_view, LogLevel>, 5> levels{{
    {"trace", LogLevel::trace},
    {"debug", LogLevel::debug},
    {"info", LogLevel::info},
    {"warning", LogLevel::warning},
    {"error", LogLevel::error},
}};

constexpr std::array<std::pair<std::string_view, drive::Motor>, 3> motors{{
    {"any", drive::Motor::any},
    {"linear", drive::Motor::linear},
    {"rotative", drive::Motor::rotative},
}};

// Why one value is not taken; the walk adds where it stands. Empty: taken.
using Reason = std::string;
using Setter = std::function<Reason(const json&)>;
using Setters = std::map<std::string, Setter>;

template <class Number>
Setter whole_number(Number& target, std::uint64_t low, std::uint64_t high) {
    return [&target, low, high](const json& value) -> Reason {
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() < low || value.get<std::uint64_t>() > high) {
            return fmt::format("must be a whole number from {} to {}", low, high);
        }
        target = static_cast<Number>(value.get<std::uint64_t>());
        return {};
    };
}

template <class Number>
Setter whole_number(std::optional<Number>& target, std::uint64_t low, std::uint64_t high) {
    return [&target, low, high](const json& value) -> Reason {
        Number number{};
        auto reason = whole_number(number, low, high)(value);
        if (reason.empty()) target = number;
        return reason;
    };
}

template <class Words>
std::string list(const Words& words) {
    std::string line;
    for (const auto& entry : words) line += fmt::format("{}\"{}\"", line.empty() ? "" : ", ", entry.first);
    return line;
}

template <class Word, class Words>
Setter one_of(Word& target, const Words& words) {
    return [&target, &words](const json& value) -> Reason {
        for (const auto& [word, meaning] : words) {
            if (value.is_string() && value.get_ref<const std::string&>() == word) {
                target = meaning;
                return {};
            }
        }
        return fmt::format("must be one of {}", list(words));
    };
}

Setter variant_setter(std::string& target) {
    return [&target](const json& value) -> Reason {
        if (value.is_string() && drive::xenax_model(value.get_ref<const std::string&>())) {
            target = value.get<std::string>();
            return {};
        }
        std::string keys;
        for (const auto& model : drive::xenax_models()) {
            keys += fmt::format("{}\"{}\"", keys.empty() ? "" : ", ", model.key);
        }
        return fmt::format("must be one of {}", keys);
    };
}

Setter text(std::string& target) {
    return [&target](const json& value) -> Reason {
        if (!value.is_string() || value.get_ref<const std::string&>().empty()) return "must be a text";
        target = value.get<std::string>();
        return {};
    };
}

Setter text(std::optional<std::string>& target) {
    return [&target](const json& value) -> Reason {
        target.emplace();
        return text(*target)(value);
    };
}

Setter product_name(std::optional<std::string>& target) {
    return [&target](const json& value) -> Reason {
        if (!value.is_string() || value.get_ref<const std::string&>().empty() ||
            value.get_ref<const std::string&>().size() > max_product_name) {
            return fmt::format("must be a text of 1 to {} characters", max_product_name);
        }
        target = value.get<std::string>();
        return {};
    };
}

std::variant<drive::Value, Reason> parameter_value(const drive::Parameter& row, const json& value) {
    drive::Value parsed;
    if (value.is_string()) {
        auto result = drive::parse(row, value.get_ref<const std::string&>());
        if (const auto* error = std::get_if<drive::ParseError>(&result)) return error->reason;
        parsed = std::get<drive::Value>(std::move(result));
    } else if (value.is_number_unsigned() && !row.is_text()) {
        constexpr std::uint64_t highest = std::numeric_limits<std::int64_t>::max();
        parsed = static_cast<std::int64_t>(std::min(value.get<std::uint64_t>(), highest));
    } else if (value.is_number_integer() && !row.is_text()) {
        parsed = value.get<std::int64_t>();
    } else {
        return Reason(row.is_text() ? "must be a text" : "must be a whole number, or a text such as \"0x1F\"");
    }
    if (const auto refusal = drive::check_value(row, parsed)) {
        if (row.is_text()) return fmt::format("holds at most {} characters", row.max_length);
        return fmt::format("{}: it holds {} to {}", drive::describe(*refusal), row.low, row.high);
    }
    return parsed;
}

Reason add_value(Config& config, const std::string& name, const json& value) {
    const auto rows = drive::find_by_name(drive::parameters(), drive::parameter_classes(), name);
    if (rows.empty()) {
        const auto nearest = drive::nearest_names(drive::parameters(), drive::parameter_classes(), name, 1);
        return nearest.empty() ? "is no parameter"
                               : fmt::format("is no parameter; did you mean '{}'?", nearest.front());
    }
    if (rows.size() > 1) {
        return fmt::format("names several parameters; write '{}' or '{}'",
                           drive::qualified_name(drive::parameter_classes(), *rows[0]),
                           drive::qualified_name(drive::parameter_classes(), *rows[1]));
    }
    auto parsed = parameter_value(*rows.front(), value);
    if (auto* reason = std::get_if<Reason>(&parsed)) return *reason;
    if (std::ranges::count(config.values, rows.front()->key(), &std::pair<drive::Key, drive::Value>::first) > 0) {
        return "has a value already, under another name";
    }
    config.values.emplace_back(rows.front()->key(), std::get<drive::Value>(std::move(parsed)));
    return {};
}

// One object of the file: every member has a setter, or is an error.
class Walk {
public:
    explicit Walk(const JsonDocument& document) : document_(document) {}

    std::optional<ConfigError> object(const json& members, const std::string& pointer, const Setters& setters) const {
        for (const auto& [key, value] : members.items()) {
            const auto setter = setters.find(key);
            const auto reason = setter != setters.end() ? setter->second(value) : unknown(key, setters);
            if (!reason.empty()) return error(pointer, key, reason);
        }
        return std::nullopt;
    }

    ConfigError error(const std::string& pointer, const std::string& key, const Reason& reason) const {
        const auto found = document_.positions.find((json::json_pointer(pointer) / key).to_string());
        const auto position = found != document_.positions.end() ? found->second : Position{};
        return {position.line, position.column, fmt::format("'{}' {}", key, reason)};
    }

private:
    static Reason unknown(const std::string&, const Setters& setters) {
        std::string known;
        for (const auto& [name, setter] : setters) known += fmt::format("{}{}", known.empty() ? "" : ", ", name);
        return fmt::format("is not a setting; here may stand: {}", known);
    }

    const JsonDocument& document_;
};

Setters identity_setters(Config& config) {
    return {
        {"serial_number", whole_number(config.serial_number, 1, std::numeric_limits<std::uint32_t>::max())},
        {"major_revision", whole_number(config.major_revision, 1, 127)},
        {"minor_revision", whole_number(config.minor_revision, 1, 255)},
        {"product_name", product_name(config.product_name)},
    };
}

Setters limit_setters(Config& config, std::uint64_t& inactivity_seconds) {
    return {
        {"tcp_connections", whole_number(config.limits.tcp_connections, 1, max_limit)},
        {"sessions", whole_number(config.limits.sessions, 1, max_limit)},
        {"class3_connections", whole_number(config.limits.class3_connections, 0, max_class3_connections)},
        {"inactivity_seconds", whole_number(inactivity_seconds, 0, 3600)},  // R-ENC-24
    };
}

std::optional<ConfigError> read_members(const JsonDocument& document, Config& config) {
    const Walk walk(document);
    std::optional<ConfigError> inner;
    auto inactivity_seconds = static_cast<std::uint64_t>(config.limits.inactivity.count());
    const auto section = [&](const std::string& name, auto fill) -> Setter {
        return [&, name, fill](const json& value) -> Reason {
            if (!value.is_object()) return "must be an object in braces";
            inner = fill(value, "/" + name);
            return {};
        };
    };
    const Setters setters{
        {"variant", variant_setter(config.variant)},
        {"bind", text(config.bind)},
        {"port", whole_number(config.port, 0, 65535)},
        {"log_level", one_of(config.log_level, levels)},
        {"motor", one_of(config.motor, motors)},
        {"eds", text(config.eds)},
        {"identity", section("identity",
                             [&](const json& value, const std::string& pointer) {
                                 return walk.object(value, pointer, identity_setters(config));
                             })},
        {"limits", section("limits",
                           [&](const json& value, const std::string& pointer) {
                               return walk.object(value, pointer, limit_setters(config, inactivity_seconds));
                           })},
        {"values", section("values",
                           [&](const json& value, const std::string& pointer) -> std::optional<ConfigError> {
                               for (const auto& [name, entry] : value.items()) {
                                   const auto reason = add_value(config, name, entry);
                                   if (!reason.empty()) return walk.error(pointer, name, reason);
                               }
                               return std::nullopt;
                           })},
    };
    for (const auto& [key, value] : document.root.items()) {
        if (auto error = walk.object(json::object({{key, value}}), "", setters)) return error;
        if (inner) return inner;
    }
    config.limits.inactivity = std::chrono::seconds(inactivity_seconds);
    return std::nullopt;
}

std::variant<std::string, ConfigError> read_file(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) return ConfigError{0, 0, "is a directory, not a file"};
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return ConfigError{0, 0, "cannot be read"};
    std::string text(max_file_bytes + 1, '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    if (text.size() > max_file_bytes) return ConfigError{0, 0, fmt::format("is larger than {} octets", max_file_bytes)};
    return text;
}

}  // namespace

std::string describe(const std::filesystem::path& file, const ConfigError& error) {
    if (error.line == 0) return fmt::format("{}: {}", file.string(), error.reason);
    return fmt::format("{}:{}:{}: {}", file.string(), error.line, error.column, error.reason);
}

std::variant<Config, ConfigError> parse_config(const std::string& text) {
    auto parsed = parse_json(text);
    if (const auto* error = std::get_if<JsonError>(&parsed)) {
        return ConfigError{error->position.line, error->position.column, error->reason};
    }
    const auto& document = std::get<JsonDocument>(parsed);
    if (!document.root.is_object()) return ConfigError{1, 1, "the file must hold one object in braces"};
    Config config;
    if (auto error = read_members(document, config)) return *error;
    return config;
}

std::variant<Config, ConfigError> load_config(const std::filesystem::path& file) {
    auto content = read_file(file);
    if (auto* error = std::get_if<ConfigError>(&content)) return *error;
    return parse_config(std::get<std::string>(content));
}

std::variant<DeviceFile, ConfigError> load_eds(const Config& config) {
    DeviceFile file;
    if (!config.eds) return file;
    auto content = read_file(*config.eds);
    if (auto* error = std::get_if<ConfigError>(&content)) return *error;
    const auto& octets = std::get<std::string>(content);
    file.content.assign(octets.begin(), octets.end());
    file.name = std::filesystem::path(*config.eds).filename().string();
    return file;
}

NetworkSettings make_network(const drive::Identity& identity) {
    NetworkSettings network;
    const auto serial = identity.serial_number;
    network.mac = {0x02,
                   0x00,
                   static_cast<std::uint8_t>(serial >> 24),
                   static_cast<std::uint8_t>(serial >> 16),
                   static_cast<std::uint8_t>(serial >> 8),
                   static_cast<std::uint8_t>(serial)};
    return network;
}

std::optional<LogLevel> log_level(std::string_view word) {
    for (const auto& [name, level] : levels) {
        if (name == word) return level;
    }
    return std::nullopt;
}

drive::Device make_device(const Config& config) {
    auto model = *drive::xenax_model(config.variant);
    auto& identity = model.identity;
    identity.serial_number = config.serial_number.value_or(identity.serial_number);
    identity.major_revision = config.major_revision.value_or(identity.major_revision);
    identity.minor_revision = config.minor_revision.value_or(identity.minor_revision);
    identity.product_name = config.product_name.value_or(identity.product_name);
    drive::Device device(std::move(model), config.motor);
    apply_values(config, device);
    return device;
}

void apply_values(const Config& config, drive::Device& device) {
    for (const auto& [key, value] : config.values) {
        if (const auto* row = device.find(key)) device.store().assign(*row, value);
    }
}

}  // namespace servobus::adapter
