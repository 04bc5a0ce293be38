// eds show: what a data sheet says, as tables.
#include <fmt/format.h>

#include "scanner/cli/eds.hpp"
#include "scanner/cli/io_options.hpp"
#include "scanner/cli/sheet_fields.hpp"
#include "scanner/cli/sheet_file.hpp"
#include "scanner/cli/sheet_json.hpp"
#include "scanner/cli/table.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/sheet_check.hpp"
#include "scanner/sheet_plan.hpp"
#include "scanner/sheet_value.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
// Those of a data sheet; what is called so in here is about the drive's table.
using scanner::limits_text;
using scanner::type_name;
using scanner::value_text;

std::string number_text(const auto& number) { return number ? fmt::format("{}", *number) : std::string("-"); }

/// printable() takes line ends for what they are in a device's text; here they are ours.
std::string lines(const std::string& first, const std::string& second) {
    return printable(first) + '\n' + printable(second) + '\n';
}

std::string heading(const eds::DataSheet& sheet) {
    const auto& device = sheet.device;
    auto text = fmt::format("vendor {} {}, device type {} {}, product code {}, revision {}.{}",
                            number_text(device.vendor), device.vendor_name, number_text(device.product_type),
                            device.product_type_name, number_text(device.product_code),
                            number_text(device.major_revision), number_text(device.minor_revision));
    if (sheet.file.revision) {
        text += fmt::format(", file revision {}.{}", sheet.file.revision->major, sheet.file.revision->minor);
    }
    return lines(device.product_name, text);
}

std::string parameters_text(const eds::DataSheet& sheet) {
    if (sheet.parameters.empty()) return {};
    Table table({"PARAM", "NAME", "TYPE", "UNIT", "LIMITS", "DEFAULT", "CIP", ""});
    for (const auto& each : sheet.parameters) {
        const bool has_default = !std::holds_alternative<std::monostate>(each.standard);
        table.add({fmt::format("{}", each.number), printable(each.name), type_name(each.type), printable(each.units),
                   printable(limits_text(each)), has_default ? printable(value_text(each, each.standard)) : "",
                   cip_address(each), each.read_only() ? "read only" : ""});
    }
    return "\nParameters\n" + table.text();
}

std::string assemblies_text(const eds::DataSheet& sheet) {
    if (sheet.assemblies.empty()) return {};
    Table table({"ASSEMBLY", "NAME", "INSTANCE", "OCTETS", "OFFSET", "MEMBER", "BITS"});
    for (const auto& each : sheet.assemblies) {
        table.add(
            {each.keyword, printable(each.name), number_text(instance_of(each)), number_text(each.size), "", "", ""});
        for (const auto& field : fields_of(sheet, each)) {
            const auto offset = field.first_bit > 0 ? fmt::format("{}.{}", field.offset, field.first_bit)
                                                    : fmt::format("{}", field.offset);
            table.add({"", "", "", "", offset, field.name(), fmt::format("{}", field.bits)});
        }
    }
    return "\nAssemblies\n" + table.text();
}

std::string size_text(const IoDirection& direction) {
    if (direction.format == cip::RealTimeFormat::heartbeat) return "heartbeat";
    return fmt::format("{} octets, {}", direction.data_octets, cip::name(direction.format));
}

std::string range_text(const eds::Range& rpi) {
    const auto text = [](std::uint32_t value) { return fmt::format("{}", static_cast<double>(value) / 1000); };
    if (!rpi.minimum && !rpi.maximum) return "any";
    const auto low = text(rpi.minimum.value_or(0));
    if (rpi.minimum == rpi.maximum) return low + " ms";
    return fmt::format("{} to {} ms", low, rpi.maximum ? text(*rpi.maximum) : "any");
}

std::string connections_text(const eds::DataSheet& sheet) {
    if (sheet.connections.empty()) return {};
    Table table({"CONNECTION", "NAME", "KIND", "O->T", "", "RPI", "T->O", "", "RPI"});
    for (const auto& each : sheet.connections) {
        const auto plan = plan_of(sheet, each);
        const auto point = [&](std::uint32_t number) { return plan ? fmt::format("{}", number) : std::string("-"); };
        table.add({each.keyword, printable(each.name), std::string(ownership_text(each)),
                   point(plan ? plan->o_to_t.point : 0), plan ? size_text(plan->o_to_t) : printable(plan.error().text),
                   range_text(each.o_to_t.rpi), point(plan ? plan->t_to_o.point : 0),
                   plan ? size_text(plan->t_to_o) : "", range_text(each.t_to_o.rpi)});
    }
    return "\nConnections\n" + table.text();
}

Json direction_json(const IoDirection& direction, const eds::Range& rpi) {
    return {{"point", direction.point},
            {"octets", direction.data_octets},
            {"format", std::string(format_key(direction.format))},
            {"rpi_us", direction.rpi.count()},
            {"rpi_low_us", rpi.minimum ? Json(*rpi.minimum) : Json()},
            {"rpi_high_us", rpi.maximum ? Json(*rpi.maximum) : Json()}};
}

Json assembly_json(const eds::DataSheet& sheet, const eds::Assembly& assembly) {
    const auto instance = instance_of(assembly);
    Json json{{"keyword", assembly.keyword},
              {"name", printable(assembly.name)},
              {"instance", instance ? Json(*instance) : Json()},
              {"octets", assembly.size ? Json(*assembly.size) : Json()},
              {"members", Json::array()}};
    for (const auto& field : fields_of(sheet, assembly)) {
        json["members"].push_back({{"name", field.name()},
                                   {"param", field.parameter != nullptr ? Json(field.parameter->number) : Json()},
                                   {"first_bit", 8 * field.offset + field.first_bit},
                                   {"bits", field.bits}});
    }
    return json;
}

Json connection_json(const eds::DataSheet& sheet, const eds::Connection& connection) {
    Json json{{"keyword", connection.keyword},
              {"name", printable(connection.name)},
              {"kind", std::string(ownership_text(connection))}};
    const auto plan = plan_of(sheet, connection);
    if (plan) {
        json["o_to_t"] = direction_json(plan->o_to_t, connection.o_to_t.rpi);
        json["t_to_o"] = direction_json(plan->t_to_o, connection.t_to_o.rpi);
    } else {
        json["error"] = printable(plan.error().text);
    }
    return json;
}

Json device_json(const eds::Device& device) {
    const auto number = [](const auto& value) { return value ? Json(*value) : Json(); };
    return {{"vendor", number(device.vendor)},
            {"vendor_name", printable(device.vendor_name)},
            {"device_type", number(device.product_type)},
            {"product_code", number(device.product_code)},
            {"product_name", printable(device.product_name)},
            {"major_revision", number(device.major_revision)},
            {"minor_revision", number(device.minor_revision)}};
}

std::string json_of(const std::string& file, const eds::DataSheet& sheet) {
    Json json{{"file", file}, {"device", device_json(sheet.device)}, {"parameters", Json::array()}};
    for (const auto& each : sheet.parameters) json["parameters"].push_back(parameter_json(each));
    json["assemblies"] = Json::array();
    for (const auto& each : sheet.assemblies) json["assemblies"].push_back(assembly_json(sheet, each));
    json["connections"] = Json::array();
    for (const auto& each : sheet.connections) json["connections"].push_back(connection_json(sheet, each));
    json["findings"] = sheet.findings.size();
    return document(json);
}

}  // namespace

ExitCode eds_show(const Console& console, const std::string& file) {
    const auto sheet = load_sheet(file);
    if (!sheet) return fail(console, sheet.error());
    const auto& all = **sheet;
    console.show(heading(all) + parameters_text(all) + assemblies_text(all) + connections_text(all),
                 console.json ? json_of(file, all) : std::string());
    if (!all.findings.empty()) {
        console.say(
            fmt::format("the file is not quite as it should be; 'servobus-scanner eds lint {}' says where", file));
    }
    return ExitCode::done;
}

}  // namespace servobus::scanner::cli
