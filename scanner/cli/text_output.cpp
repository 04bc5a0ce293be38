#include "scanner/cli/text_output.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cip/hex.hpp"
#include "cip/services.hpp"
#include "drive/text.hpp"
#include "drive/xenax.hpp"
#include "scanner/cli/table.hpp"

namespace servobus::scanner::cli {
namespace {

constexpr unsigned first_printable = 0x20;
constexpr unsigned delete_character = 0x7F;
constexpr unsigned first_latin1_printable = 0xA0;

/// Octets of the UTF-8 sequence at the front of `text`; 0 when there is none.
std::size_t utf8_length(std::string_view text) {
    const auto first = static_cast<unsigned char>(text.front());
    const std::size_t length = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
    if (length == 0 || text.size() < length) return 0;
    const auto second = static_cast<unsigned char>(text[1]);
    // C1 control characters, surrogates and overlong forms.
    if ((first == 0xC2 && second < first_latin1_printable) || (first == 0xE0 && second < 0xA0) ||
        (first == 0xED && second > 0x9F) || (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F)) {
        return 0;
    }
    const auto tail = text.substr(1, length - 1);
    return std::ranges::all_of(tail, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }) ? length
                                                                                                            : 0;
}

std::string named(std::uint16_t number, std::string_view name) {
    return name.empty() ? fmt::format("{}", number) : fmt::format("{} {}", number, name);
}

std::string addresses(const drive::Parameter& row) {
    const auto od = canopen_address(row);
    return od.empty() ? fmt::format("CIP {}", cip_address(row))
                      : fmt::format("CIP {}, CANopen {}", cip_address(row), od);
}

std::string with_unit(const drive::Parameter& row, const drive::Value& value) {
    const auto text = printable(drive::format(row, value));
    return row.unit.empty() ? text : fmt::format("{} {}", text, row.unit);
}

std::string raw_text(const What& what, cip::ByteView octets) {
    const auto name = display_name(what);
    const auto* at = std::get_if<Attribute>(&what.target);
    const auto meaning = at != nullptr && at->class_id == 1 && at->instance == 1
                             ? printable(describe_identity_attribute(at->attribute, octets))
                             : std::string();
    const auto hex = octets.empty() ? std::string("(no data)") : cip::to_hex(octets);
    return meaning.empty() ? fmt::format("{} = {}\n", name, hex) : fmt::format("{} = {}  ({})\n", name, hex, meaning);
}

/// What the row says about a refusal; empty when it has nothing to do with it.
std::string hint(const What& what, const cip::Status& status) {
    const auto* row = what.row();
    if (row == nullptr) return {};
    switch (status.general) {
        case cip::GeneralStatus::invalid_attribute_value:
            return fmt::format("; it takes {}", limits_text(*row));
        case cip::GeneralStatus::attribute_not_settable:
            return drive::may_set(row->access) ? "" : "; it is read only";
        case cip::GeneralStatus::attribute_not_gettable:
            return drive::may_get(row->access) ? "" : "; it is write only";
        case cip::GeneralStatus::vendor_specific:
            return row->force_option ? "; it needs the force option (Signateq)" : "";
        default:
            return {};
    }
}

std::string_view access_text(drive::Access access) {
    switch (access) {
        case drive::Access::get:
            return "get";
        case drive::Access::set:
            return "set";
        case drive::Access::get_set:
            return "get/set";
    }
    return "";
}

std::string limits_cell(const drive::Parameter& row) {
    if (row.is_text()) return fmt::format("{} characters", row.max_length);
    if (row.form != drive::Form::number) return "";
    return row.allowed.empty() ? fmt::format("{} to {}", row.low, row.high) : limits_text(row);
}

std::string remark(const Outcome& outcome) {
    if (const auto* reason = std::get_if<NotAsked>(&outcome.result)) return reason->reason;
    if (const auto* status = std::get_if<cip::Status>(&outcome.result)) return "refused: " + cip::describe(*status);
    if (const auto* error = std::get_if<error_code>(&outcome.result)) return words(*error);
    return outcome.surplus > 0 ? fmt::format("{} surplus octets", outcome.surplus) : "";
}

std::vector<std::string> dump_row(const Outcome& outcome) {
    const auto& row = *outcome.what.row();
    const auto* value = std::get_if<drive::Value>(&outcome.result);
    return {std::string(row.name),
            std::string(row.mnemonic),
            value != nullptr ? printable(drive::format(row, *value)) : "-",
            std::string(row.unit),
            std::string(access_text(row.access)),
            limits_cell(row),
            cip_address(row),
            canopen_address(row),
            remark(outcome)};
}

std::string class_title(const drive::ParameterClass& group) {
    return fmt::format("0x{:02X} {} ({})\n", group.class_id, group.title, group.prefix);
}

}  // namespace

std::string printable(std::string_view text) {
    std::string shown;
    while (!text.empty()) {
        const unsigned first = static_cast<unsigned char>(text.front());
        std::size_t length = 1;
        if (first >= first_printable && first < delete_character) {
            shown += text.front();
        } else if (const auto sequence = utf8_length(text); sequence > 0) {
            shown += text.substr(0, sequence);
            length = sequence;
        } else if (first >= first_latin1_printable) {
            // CIP strings are ISO 8859-1.
            shown += static_cast<char>(0xC0 | first >> 6);
            shown += static_cast<char>(0x80 | (first & 0x3F));
        } else {
            shown += fmt::format("\\x{:02X}", first);
        }
        text.remove_prefix(length);
    }
    return shown;
}

std::string value_text(const Outcome& outcome) {
    if (const auto* octets = std::get_if<cip::Bytes>(&outcome.result)) return raw_text(outcome.what, *octets);
    const auto* value = std::get_if<drive::Value>(&outcome.result);
    const auto* row = outcome.what.row();
    if (value == nullptr || row == nullptr) return {};
    return fmt::format("{} = {}  ({})\n", display_name(*row), with_unit(*row, *value), addresses(*row));
}

std::string refusal_text(const Outcome& outcome) {
    const auto name = display_name(outcome.what);
    if (const auto* reason = std::get_if<NotAsked>(&outcome.result))
        return fmt::format("{}: {}\n", name, reason->reason);
    if (const auto* error = std::get_if<error_code>(&outcome.result))
        return fmt::format("{}: {}\n", name, words(*error));
    if (const auto* status = std::get_if<cip::Status>(&outcome.result)) {
        return fmt::format("{}: refused with {}{}\n", name, cip::describe(*status), hint(outcome.what, *status));
    }
    return {};
}

std::string warning_text(const Outcome& outcome) {
    if (outcome.surplus == 0) return {};
    return fmt::format("{}: {} surplus octets behind the value, ignored\n", display_name(outcome.what),
                       outcome.surplus);
}

std::string dump_text(const std::vector<Outcome>& outcomes) {
    std::string text;
    for (const auto& group : drive::parameter_classes()) {
        Table table({"NAME", "MNEMONIC", "VALUE", "UNIT", "ACCESS", "LIMITS", "CIP", "CANOPEN", "REMARK"});
        bool any = false;
        for (const auto& outcome : outcomes) {
            if (outcome.what.row()->cip.class_id != group.class_id) continue;
            table.add(dump_row(outcome));
            any = true;
        }
        if (any) text += (text.empty() ? "" : "\n") + class_title(group) + table.text();
    }
    return text;
}

std::string identity_text(const Identity& identity) {
    const auto state = identity.state ? named(*identity.state, state_text(*identity.state)) : std::string("not told");
    return fmt::format(
        "vendor         {}\n"
        "device type    {}\n"
        "product code   {} (0x{:04X})\n"
        "product name   {}\n"
        "revision       {}.{}\n"
        "serial number  0x{:08X}\n"
        "status         0x{:04X} {}\n"
        "state          {}\n",
        named(identity.vendor, vendor_name(identity.vendor)),
        named(identity.device_type, device_type_name(identity.device_type)), identity.product_code,
        identity.product_code, printable(identity.product_name), identity.major_revision, identity.minor_revision,
        identity.serial_number, identity.status, status_text(identity.status), state);
}

std::string devices_text(const enip::asio::FoundDevices& devices) {
    Table table({"ADDRESS", "VENDOR", "DEVICE TYPE", "PRODUCT", "NAME", "REVISION", "SERIAL", "STATUS", "STATE"});
    for (const auto& device : devices) {
        const auto identity = identity_of(device.identity);
        table.add({to_string(Host{device.address, device.port}), named(identity.vendor, vendor_name(identity.vendor)),
                   named(identity.device_type, device_type_name(identity.device_type)),
                   fmt::format("0x{:04X}", identity.product_code), printable(identity.product_name),
                   fmt::format("{}.{}", identity.major_revision, identity.minor_revision),
                   fmt::format("0x{:08X}", identity.serial_number),
                   fmt::format("0x{:04X} {}", identity.status, status_text(identity.status)),
                   identity.state ? std::string(state_text(*identity.state)) : "-"});
    }
    return table.text();
}

std::string call_text(const CallResult& result) {
    auto text = fmt::format("status  {}\n", cip::describe(result.response.status));
    if (!result.response.data.empty()) text += hex_dump(result.response.data);
    return text;
}

std::string address_method_text(std::optional<std::uint8_t> method) {
    if (!method) return {};
    switch (*method) {
        case 0:
            return "static address";
        case 1:
            return "address by BOOTP";
        case 2:
            return "address by DHCP";
        default:
            return fmt::format("address by method {}", *method);
    }
}

std::string reset_text(const ResetResult& result) {
    const auto name = printable(result.before.identity.product_name);
    if (!result.after) return fmt::format("{} restarts\n", name);
    const auto& [identity, method, address] = *result.after;
    auto text =
        fmt::format("{} is back after {:.1f} s: revision {}.{}, serial number 0x{:08X}, status 0x{:04X} {}", name,
                    static_cast<double>(result.away.count()) / 1000, identity.major_revision, identity.minor_revision,
                    identity.serial_number, identity.status, status_text(identity.status));
    if (!address.empty()) text += fmt::format("; {}", address);
    if (method) text += fmt::format("{}{}", address.empty() ? "; " : ", ", address_method_text(method));
    return text + '\n';
}

std::string command_text(const CommandResult& result) {
    const auto& command = *result.command;
    const auto mnemonic = command.mnemonic.empty() ? std::string() : std::string(command.mnemonic) + " ";
    return fmt::format("{}{} (0x{:04X}): accepted\n", mnemonic, command.name, command.value);
}

std::string list_text(std::span<const drive::Parameter* const> rows) {
    std::string text;
    for (const auto& group : drive::parameter_classes()) {
        Table table({"NAME", "MNEMONIC", "TYPE", "UNIT", "ACCESS", "LIMITS", "CIP", "CANOPEN"});
        bool any = false;
        for (const auto* row : rows) {
            if (row->cip.class_id != group.class_id) continue;
            table.add({std::string(row->name), std::string(row->mnemonic), std::string(type_name(*row)),
                       std::string(row->unit), std::string(access_text(row->access)), limits_cell(*row),
                       cip_address(*row), canopen_address(*row)});
            any = true;
        }
        if (any) text += (text.empty() ? "" : "\n") + class_title(group) + table.text();
    }
    return text;
}

std::string commands_text(std::span<const drive::DirectCommand* const> commands) {
    Table table({"MNEMONIC", "NAME", "VALUE", "WHAT IT DOES"});
    for (const auto* command : commands) {
        table.add({std::string(command->mnemonic), std::string(command->name), fmt::format("0x{:04X}", command->value),
                   std::string(command->text)});
    }
    return table.text();
}

std::string hex_dump(cip::ByteView octets) {
    constexpr std::size_t per_line = 16;
    std::string text;
    for (std::size_t at = 0; at < octets.size(); at += per_line) {
        const auto part = octets.subspan(at, std::min(per_line, octets.size() - at));
        std::string characters;
        for (const auto octet : part) {
            characters += octet >= first_printable && octet < delete_character ? static_cast<char>(octet) : '.';
        }
        text += fmt::format("{:04X}    {:<47}  {}\n", at, cip::to_hex(part), characters);
    }
    return text;
}

}  // namespace servobus::scanner::cli
