#include "adapter/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>

#include "adapter/axis_file.hpp"
#include "adapter/fleet.hpp"
#include "adapter/json_settings.hpp"
#include "adapter/memory_settings.hpp"
#include "adapter/start_address.hpp"
#include "drive/lookup.hpp"
#include "drive/text.hpp"
#include "drive/xenax.hpp"

namespace servobus::adapter {
namespace {

using nlohmann::json;

constexpr std::size_t max_product_name = 32;  // R-ID-1
// Enough for every descriptor that a process usually may open, and less than would exhaust memory.
constexpr std::int64_t max_limit = 100'000;
// The lower half of a connection id is a number of 16 bits (R-CON-16).
constexpr std::int64_t max_class3_connections = 65'535;
constexpr std::int64_t max_listening_connections = 128;
constexpr std::int64_t max_inactivity_seconds = 3600;  // R-ENC-24
constexpr std::int64_t max_seed = std::numeric_limits<std::int64_t>::max();

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

constexpr std::array<std::pair<std::string_view, drive::OutputsWithoutController>, 2> outputs_without_controller{{
    {"keep", drive::OutputsWithoutController::keep},
    {"off", drive::OutputsWithoutController::off},
}};

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

Setter axis_setter(Config& config) {
    return [&config](const json& value) -> Reason {
        return choose_axis(value.is_string() ? value.get<std::string>() : std::string(), config);
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

Setter allow_setter(AllowList& target) {
    return [&target](const json& value) -> Reason {
        // An empty one could be meant for everybody as well as for nobody.
        if (!value.is_array() || value.empty()) return "must be a list of networks such as \"192.168.2.0/24\"";
        if (value.size() > max_allowed_networks) return fmt::format("has at most {} networks", max_allowed_networks);
        AllowList list;
        for (const auto& entry : value) {
            const auto network = AllowList::parse(entry.is_string() ? entry.get<std::string>() : entry.dump());
            if (const auto* reason = std::get_if<std::string>(&network)) return "is not sound: " + *reason;
            list.add(std::get<AllowList::Network>(network));
        }
        target = std::move(list);
        return {};
    };
}

Setters protection_setters(Config& config) {
    return {
        {"allow", allow_setter(config.allowed)},
        {"read_only", flag(config.protection.read_only)},
        {"harden", flag(config.protection.harden)},
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

bool is_told_by_drive(const drive::Parameter& row) {
    return row.access == drive::Access::get && row.fidelity == drive::Fidelity::behaves;
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
    if (is_told_by_drive(*rows.front())) return "is told by the drive itself; a scenario can bring it about";
    auto parsed = parameter_value(*rows.front(), value);
    if (auto* reason = std::get_if<Reason>(&parsed)) return *reason;
    if (std::ranges::count(config.values, rows.front()->key(), &std::pair<drive::Key, drive::Value>::first) > 0) {
        return "has a value already, under another name";
    }
    config.values.emplace_back(rows.front()->key(), std::get<drive::Value>(std::move(parsed)));
    return {};
}

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
        {"listening_connections", whole_number(config.limits.listening_connections, 0, max_listening_connections)},
        {"inactivity_seconds", whole_number(inactivity_seconds, 0, max_inactivity_seconds)},
    };
}

std::optional<FileError> read_members(const JsonDocument& document, Config& config) {
    const Walk walk(document);
    std::optional<FileError> inner;
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
        {"io_port", whole_number(config.io_port, 0, 65535)},
        {"count", whole_number(config.count, 1, max_drives)},
        {"manage_interface", text(config.manage_interface)},
        {"network", section("network",
                            [&](const json& value, const std::string& pointer) {
                                return read_network(walk, value, pointer, config.network);
                            })},
        {"log_level", one_of(config.log_level, levels)},
        {"axis", axis_setter(config)},
        {"seed", whole_number(config.seed, 0, max_seed)},
        {"motor", one_of(config.motor, motors)},
        {"scenario", text(config.scenario)},
        {"state", text(config.state)},
        {"eds", text(config.eds)},
        {"icon", text(config.icon)},
        {"flash", text(config.flash)},
        {"identity", section("identity",
                             [&](const json& value, const std::string& pointer) {
                                 return walk.object(value, pointer, identity_setters(config));
                             })},
        {"limits", section("limits",
                           [&](const json& value, const std::string& pointer) {
                               return walk.object(value, pointer, limit_setters(config, inactivity_seconds));
                           })},
        {"access_log", text(config.access_log)},
        {"protection", section("protection",
                               [&](const json& value, const std::string& pointer) {
                                   return walk.object(value, pointer, protection_setters(config));
                               })},
        {"lost_controller", section("lost_controller",
                                    [&](const json& value, const std::string& pointer) {
                                        return walk.object(value, pointer,
                                                           {{"outputs", one_of(config.outputs_without_controller,
                                                                               outputs_without_controller)}});
                                    })},
        {"programs", section("programs",
                             [&](const json& value, const std::string& pointer) {
                                 return read_programs(walk, value, pointer, config.memory);
                             })},
        {"profiles", section("profiles",
                             [&](const json& value, const std::string& pointer) {
                                 return read_profiles(walk, value, pointer, config.memory);
                             })},
        {"values", section("values",
                           [&](const json& value, const std::string& pointer) -> std::optional<FileError> {
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

}  // namespace

std::variant<Config, FileError> parse_config(const std::string& text) {
    auto parsed = parse_settings(text);
    if (auto* error = std::get_if<FileError>(&parsed)) return *error;
    const auto& document = std::get<JsonDocument>(parsed);
    Config config;
    if (auto error = read_members(document, config)) return *error;
    return config;
}

std::variant<Config, FileError> load_config(const std::filesystem::path& file) {
    auto content = read_file(file);
    if (auto* error = std::get_if<FileError>(&content)) return *error;
    return parse_config(std::get<std::string>(content));
}

Network make_network(const drive::Identity& identity, NetworkSettings settings) {
    Network network{.settings = std::move(settings), .state = {}};
    const auto serial = identity.serial_number;
    network.state.mac = {0x02,
                         0x00,
                         static_cast<std::uint8_t>(serial >> 24),
                         static_cast<std::uint8_t>(serial >> 16),
                         static_cast<std::uint8_t>(serial >> 8),
                         static_cast<std::uint8_t>(serial)};
    return network;
}

std::string choose_axis(const std::string& word, Config& config) {
    const auto* shipped = shipped_axis(word);
    if (shipped == nullptr && !names_axis_file(word)) return unknown_axis();
    config.axis.reset();
    config.axis_file.reset();
    if (shipped != nullptr) {
        config.axis = *shipped;
    } else {
        config.axis_file = word;
    }
    return {};
}

std::optional<FileError> load_axis(Config& config) {
    if (!config.axis_file) return std::nullopt;
    const auto content = read_file(*config.axis_file);
    if (const auto* error = std::get_if<FileError>(&content)) return *error;
    auto parsed = parse_axis(std::get<std::string>(content));
    if (const auto* error = std::get_if<FileError>(&parsed)) return *error;
    config.axis = std::get<drive::AxisKind>(std::move(parsed));
    config.axis_file.reset();
    return std::nullopt;
}

std::optional<LogLevel> log_level(std::string_view word) {
    for (const auto& [name, level] : levels) {
        if (name == word) return level;
    }
    return std::nullopt;
}

std::string_view word(LogLevel level) { return levels[static_cast<std::size_t>(level)].first; }

const drive::AxisKind& axis_of(const Config& config) {
    static const drive::AxisKind standard;
    if (config.axis) return *config.axis;
    const auto* shipped = shipped_axis(default_axis);
    return shipped != nullptr ? *shipped : standard;
}

drive::Motor motor_of(const Config& config) {
    if (config.motor) return *config.motor;
    if (!config.axis) return drive::Motor::any;
    return config.axis->motion == drive::AxisKind::Motion::linear ? drive::Motor::linear : drive::Motor::rotative;
}

drive::Model model_of(const Config& config) {
    auto model = *drive::xenax_model(config.variant);
    auto& identity = model.identity;
    identity.serial_number = config.serial_number.value_or(identity.serial_number);
    identity.major_revision = config.major_revision.value_or(identity.major_revision);
    identity.minor_revision = config.minor_revision.value_or(identity.minor_revision);
    identity.product_name = config.product_name.value_or(identity.product_name);
    return model;
}

drive::Device make_device(const Config& config) {
    auto model = model_of(config);
    const bool moves = model.make_behaviour != nullptr;
    auto device = moves
                      ? drive::Device(std::move(model),
                                      {axis_of(config), config.seed, config.memory, config.outputs_without_controller},
                                      motor_of(config))
                      : drive::Device(std::move(model), motor_of(config));
    device.deliver(config.values);
    return device;
}

}  // namespace servobus::adapter
