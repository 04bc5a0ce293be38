#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <unordered_map>

#include "eds/field_values.hpp"
#include "eds/lint_rules.hpp"

namespace servobus::eds {
namespace {

constexpr std::array<std::string_view, 7> port_types{
    "TCP", "ControlNet", "ControlNet_Redundant", "DeviceNet", "CompoNet", "ModbusSL", "ModbusTCP"};

struct ClassCode {
    std::string_view section;
    std::uint32_t class_id;
};
constexpr std::array class_codes{
    ClassCode{"Identity Class", 0x01},
    ClassCode{"Message Router Class", 0x02},
    ClassCode{"Assembly", 0x04},
    ClassCode{"Connection Manager", 0x06},
    ClassCode{"File Class", 0x37},
    ClassCode{"DLR Class", 0x47},
    ClassCode{"QoS Class", 0x48},
    ClassCode{"Port", 0xF4},
    ClassCode{"TCP/IP Interface Class", 0xF5},
    ClassCode{"Ethernet Link Class", 0xF6},
};

bool is_port_type(std::string_view type) {
    return is_of_a_vendor(type) || std::ranges::find(port_types, type) != port_types.end();
}

void check_ports(const Sheet& sheet, Notes& notes) {
    std::unordered_set<std::uint16_t> numbers;
    const auto entries = numbered(sheet.document, "Port", "Port");
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const auto& entry = *entries[i];
        const auto& port = sheet.read.ports[i];
        if (!is_port_type(port.type)) {
            notes.warning(entry.line, fmt::format("{}: '{}' is no type of a port", entry.keyword, shown(port.type)));
        }
        check_path(sheet.read, port.path, entry.line, entry.keyword, notes);
        if (!port.number) {
            notes.error(entry.line, fmt::format("{}: there is no port number", entry.keyword));
        } else if (!numbers.insert(*port.number).second) {
            notes.error(entry.line, fmt::format("{}: another port has the number {}", entry.keyword, *port.number));
        }
    }
}

void check_capacity(const Sheet& sheet, Notes& notes) {
    const auto entries = numbered(sheet.document, "Capacity", "TSpec");
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const auto& traffic = sheet.read.capacity.traffic[i];
        const auto& entry = *entries[i];
        if (traffic.direction != "TxRx" && traffic.direction != "Tx" && traffic.direction != "Rx") {
            notes.error(entry.line,
                        fmt::format("{}: '{}' is none of TxRx, Tx and Rx", entry.keyword, shown(traffic.direction)));
        }
        if (traffic.size.value_or(0) == 0 || traffic.packets_per_second.value_or(0) == 0) {
            notes.error(entry.line,
                        fmt::format("{}: size and packets per second have to be more than 0", entry.keyword));
        }
    }
    const auto* entry = sheet.document.find("Capacity", "MaxIOConnections");
    if (sheet.read.capacity.io_connections == 0U && !sheet.read.connections.empty()) {
        notes.warning(entry->line, "MaxIOConnections is 0, and there are connections");
    }
}

void check_class(const Section& section, const ObjectClass& object, Notes& notes) {
    const auto known =
        std::ranges::find_if(class_codes, [&](const ClassCode& each) { return same_name(each.section, section.name); });
    if (known != class_codes.end() && object.class_id && *object.class_id != known->class_id) {
        notes.error(section.line, fmt::format("[{}] has the Object_Class_Code 0x{:02X}, and is class 0x{:02X}",
                                              section.name, *object.class_id, known->class_id));
    }
    if (object.max_instance && object.static_instances && *object.static_instances > *object.max_instance) {
        notes.error(section.line, fmt::format("[{}] has {} instances, and its highest is {}", shown(section.name),
                                              *object.static_instances, *object.max_instance));
    }
}

void check_classes(const Sheet& sheet, Notes& notes) {
    std::unordered_map<std::uint32_t, std::string_view> seen;
    for (const auto& object : sheet.read.classes) {
        const auto* section = sheet.document.find(object.section);
        check_class(*section, object, notes);
        if (!object.class_id) continue;
        const auto [first, is_new] = seen.try_emplace(*object.class_id, object.section);
        if (is_new) continue;
        notes.warning(section->line, fmt::format("[{}] has the Object_Class_Code of [{}]", shown(object.section),
                                                 shown(first->second)));
    }
}

}  // namespace

void lint_network(const Sheet& sheet, Notes& notes) {
    check_ports(sheet, notes);
    check_capacity(sheet, notes);
    check_classes(sheet, notes);
}

}  // namespace servobus::eds
