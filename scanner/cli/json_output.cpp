#include "scanner/cli/json_output.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cip/hex.hpp"
#include "cip/services.hpp"
#include "drive/lookup.hpp"
#include "drive/xenax.hpp"
#include "scanner/cli/text_output.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;

/// What a device sent may be no UTF-8; printable() has already taken care, and this makes sure.
std::string document(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n'; }

Json with_host(const std::string& host) {
    Json json = Json::object();
    if (!host.empty()) json["host"] = host;
    return json;
}

Json text_or_null(std::string_view text) { return text.empty() ? Json() : Json(std::string(text)); }

Json to_json(const drive::Value& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return printable(*text);
    return std::get<std::int64_t>(value);
}

Json to_json(const cip::Status& status) {
    return {
        {"general", static_cast<int>(status.general)}, {"extended", status.extended}, {"text", cip::describe(status)}};
}

Json error_json(ExitCode code, const std::string& text) {
    return {{"kind", std::string(row_of(code).kind)}, {"text", text}};
}

Json to_json(const Failure& failure) {
    auto json = error_json(failure.code, failure.text);
    json["exit_code"] = static_cast<int>(failure.code);
    if (failure.status) {
        json["general"] = static_cast<int>(failure.status->general);
        json["extended"] = failure.status->extended;
    }
    return json;
}

Json names_json(const drive::Parameter& row) {
    return {{"name", std::string(row.name)},
            {"qualified", drive::qualified_name(drive::parameter_classes(), row)},
            {"mnemonic", text_or_null(row.mnemonic)}};
}

void add_addresses(Json& json, const drive::Parameter& row) {
    json["unit"] = text_or_null(row.unit);
    json["cip"] = cip_address(row);
    json["canopen"] = text_or_null(canopen_address(row));
    json["type"] = std::string(type_name(row));
}

void add_limits(Json& json, const drive::Parameter& row) {
    json["access"] = row.access == drive::Access::get ? "get" : row.access == drive::Access::set ? "set" : "get/set";
    if (row.is_text()) {
        json["max_length"] = row.max_length;
        return;
    }
    json["low"] = row.low;
    json["high"] = row.high;
    if (!row.allowed.empty()) json["allowed"] = std::vector<std::int64_t>(row.allowed.begin(), row.allowed.end());
}

void add_result(Json& json, const Outcome& outcome) {
    if (const auto* value = std::get_if<drive::Value>(&outcome.result)) {
        json["value"] = to_json(*value);
    } else if (const auto* octets = std::get_if<cip::Bytes>(&outcome.result)) {
        json["value"] = nullptr;
        json["raw"] = cip::to_hex(*octets);
    } else if (const auto* status = std::get_if<cip::Status>(&outcome.result)) {
        json["error"] = to_json(*status);
    } else if (const auto* error = std::get_if<error_code>(&outcome.result)) {
        json["error"] = error_json(exit_code_of(*error), words(*error));
    } else {
        json["not_asked"] = std::get<NotAsked>(outcome.result).reason;
    }
}

void add_meaning(Json& json, const Attribute& at, const Outcome& outcome) {
    const auto* octets = std::get_if<cip::Bytes>(&outcome.result);
    if (octets == nullptr || at.class_id != 1 || at.instance != 1) return;
    const auto meaning = describe_identity_attribute(at.attribute, *octets);
    if (!meaning.empty()) json["text"] = printable(meaning);
}

Json to_json(const Outcome& outcome) {
    const auto* row = outcome.what.row();
    Json json =
        row != nullptr ? names_json(*row) : Json{{"name", nullptr}, {"qualified", nullptr}, {"mnemonic", nullptr}};
    add_result(json, outcome);
    if (row != nullptr) {
        add_addresses(json, *row);
    } else {
        const auto& at = std::get<Attribute>(outcome.what.target);
        json["unit"] = nullptr;
        json["cip"] = cip_address(at);
        json["canopen"] = nullptr;
        json["type"] = nullptr;
        add_meaning(json, at, outcome);
    }
    if (outcome.surplus > 0) json["surplus_octets"] = outcome.surplus;
    return json;
}

Json to_json(const Identity& identity) {
    Json json{{"vendor", identity.vendor},
              {"vendor_name", text_or_null(vendor_name(identity.vendor))},
              {"device_type", identity.device_type},
              {"device_type_name", text_or_null(device_type_name(identity.device_type))},
              {"product_code", identity.product_code},
              {"product_name", printable(identity.product_name)},
              {"revision", fmt::format("{}.{}", identity.major_revision, identity.minor_revision)},
              {"serial_number", identity.serial_number},
              {"status", identity.status},
              {"status_text", status_text(identity.status)},
              {"state", nullptr},
              {"state_text", nullptr}};
    if (identity.state) {
        json["state"] = *identity.state;
        json["state_text"] = std::string(state_text(*identity.state));
    }
    return json;
}

Json to_json(const drive::DirectCommand& command) {
    return {{"mnemonic", text_or_null(command.mnemonic)},
            {"name", std::string(command.name)},
            {"value", command.value},
            {"text", std::string(command.text)}};
}

std::uint32_t class_of(const cip::Path& path) {
    for (const auto& segment : path.segments) {
        const auto* logical = std::get_if<cip::LogicalSegment>(&segment);
        if (logical != nullptr && logical->type == cip::LogicalType::class_id) return logical->value;
    }
    return 0;
}

}  // namespace

std::string values_json(const std::string& host, const std::vector<Outcome>& outcomes,
                        const std::optional<Failure>& failure) {
    auto json = with_host(host);
    json["values"] = Json::array();
    for (const auto& outcome : outcomes) json["values"].push_back(to_json(outcome));
    if (failure) json["error"] = to_json(*failure);
    return document(json);
}

std::string dump_json(const std::string& host, const std::vector<Outcome>& outcomes,
                      const std::optional<Failure>& failure) {
    auto json = with_host(host);
    json["values"] = Json::array();
    for (const auto& outcome : outcomes) {
        auto value = to_json(outcome);
        add_limits(value, *outcome.what.row());
        json["values"].push_back(std::move(value));
    }
    if (failure) json["error"] = to_json(*failure);
    return document(json);
}

std::string identity_json(const std::string& host, const Identity& identity) {
    auto json = with_host(host);
    json["identity"] = to_json(identity);
    return document(json);
}

std::string devices_json(const enip::asio::FoundDevices& devices, const std::optional<Failure>& failure) {
    Json json{{"devices", Json::array()}};
    for (const auto& device : devices) {
        Json entry{{"address", device.address}, {"port", device.port}};
        entry.update(to_json(identity_of(device.identity)));
        json["devices"].push_back(std::move(entry));
    }
    if (failure) json["error"] = to_json(*failure);
    return document(json);
}

std::string call_json(const std::string& host, const CallResult& result) {
    auto json = with_host(host);
    const auto service = result.request.service;
    json["service"] = {{"code", service},
                       {"name", text_or_null(cip::service::name(service, class_of(result.request.path)))}};
    json["path"] = cip::to_hex(result.request.path.encode());
    json["status"] = to_json(result.response.status);
    json["data"] = cip::to_hex(result.response.data);
    return document(json);
}

namespace {

Json to_json(const ResetDevice& device) {
    auto json = to_json(device.identity);
    json["address"] = text_or_null(device.address);
    json["address_method"] = device.address_method ? Json(*device.address_method) : Json();
    return json;
}

std::string_view name(ResetKind kind) {
    switch (kind) {
        case ResetKind::restart:
            return "restart";
        case ResetKind::factory:
            return "factory";
        case ResetKind::factory_keep_network:
            return "factory-keep-network";
    }
    return {};
}

}  // namespace

std::string reset_json(const std::string& host, const ResetResult& result) {
    auto json = with_host(host);
    json["reset"] = {{"type", static_cast<int>(result.kind)}, {"name", std::string(name(result.kind))}};
    json["before"] = to_json(result.before);
    json["after"] = result.after ? to_json(*result.after) : Json();
    if (result.after) json["away_ms"] = result.away.count();
    return document(json);
}

std::string command_json(const std::string& host, const CommandResult& result) {
    auto json = with_host(host);
    json["command"] = to_json(*result.command);
    if (result.outcome.has_value()) {
        json["accepted"] = true;
    } else {
        json["accepted"] = false;
        add_result(json, result.outcome);
    }
    return document(json);
}

std::string list_json(std::span<const drive::Parameter* const> rows) {
    Json json{{"parameters", Json::array()}};
    for (const auto* row : rows) {
        auto entry = names_json(*row);
        add_addresses(entry, *row);
        add_limits(entry, *row);
        if (row->is_text()) {
            entry["default"] = std::string(row->standard_text);
        } else {
            entry["default"] = row->standard;
        }
        entry["section"] = std::string(row->section);
        entry["text"] = std::string(row->text);
        json["parameters"].push_back(std::move(entry));
    }
    return document(json);
}

std::string commands_json(std::span<const drive::DirectCommand* const> commands) {
    Json json{{"commands", Json::array()}};
    for (const auto* command : commands) json["commands"].push_back(to_json(*command));
    return document(json);
}

std::string failure_json(const std::string& host, const Failure& failure) {
    auto json = with_host(host);
    json["error"] = to_json(failure);
    return document(json);
}

}  // namespace servobus::scanner::cli
