#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "eds/field_values.hpp"
#include "eds/lint_rules.hpp"

namespace servobus::eds {
namespace {

constexpr std::array<std::string_view, 3> first_sections{"File", "Device", "Device Classification"};

/// Sections by the names that tools look for.
constexpr std::array<std::string_view, 15> known_sections{"File",
                                                          "Device",
                                                          "Device Classification",
                                                          "ParamClass",
                                                          "Params",
                                                          "Groups",
                                                          "Assembly",
                                                          "Connection Manager",
                                                          "Port",
                                                          "Capacity",
                                                          "DLR Class",
                                                          "QoS Class",
                                                          "TCP/IP Interface Class",
                                                          "Ethernet Link Class",
                                                          "Identity Class"};

struct Keywords {
    std::string_view section;
    std::span<const std::string_view> required;
    std::span<const std::string_view> optional;
};

constexpr std::array<std::string_view, 4> file_required{"DescText", "CreateDate", "CreateTime", "Revision"};
constexpr std::array<std::string_view, 5> file_optional{"ModDate", "ModTime", "HomeURL", "Exclude", "EDSFileCRC"};
constexpr std::array<std::string_view, 8> device_required{"VendCode", "VendName", "ProdType", "ProdTypeStr",
                                                          "ProdCode", "MajRev",   "MinRev",   "ProdName"};
constexpr std::array<std::string_view, 4> device_optional{"Catalog", "Icon", "IconContents",
                                                          "ApplicationProfilesAssembly"};
constexpr std::array all_keywords{Keywords{"File", file_required, file_optional},
                                  Keywords{"Device", device_required, device_optional}};

template <class List>
bool contains(const List& list, std::string_view word) {
    return std::ranges::find(list, word) != list.end();
}

void check_required(const Keywords& keywords, const Section& section, Notes& notes) {
    for (const auto keyword : keywords.required) {
        const auto* entry = section.find(keyword);
        if (entry == nullptr) {
            notes.error(section.line, fmt::format("[{}] has no {}", section.name, keyword));
        } else if (entry->field(1).is_empty()) {
            notes.error(entry->line, fmt::format("{} is empty", entry->keyword));
        }
    }
}

// In these two sections every keyword has one field.
void check_known(const Keywords& keywords, const Section& section, Notes& notes) {
    for (const auto& entry : section.entries) {
        const auto same = [&](std::string_view keyword) { return same_name(keyword, entry.keyword); };
        const bool known = std::ranges::any_of(keywords.required, same) || std::ranges::any_of(keywords.optional, same);
        if (!known && !is_of_a_vendor(entry.keyword)) {
            notes.warning(entry.line, fmt::format("'{}' is no keyword of [{}]", shown(entry.keyword), section.name));
        } else if (known && entry.fields.size() > 1) {
            notes.warning(entry.line,
                          fmt::format("{} has {} fields, where one belongs", entry.keyword, entry.fields.size()));
        }
        const bool exact = contains(keywords.required, entry.keyword) || contains(keywords.optional, entry.keyword);
        if (known && !exact) {
            notes.warning(entry.line,
                          fmt::format("{} is written in another case than the format has it", entry.keyword));
        }
    }
}

void check_keywords(const Document& document, Notes& notes) {
    for (const auto& keywords : all_keywords) {
        const auto* section = document.find(keywords.section);
        if (section == nullptr) continue;
        check_required(keywords, *section, notes);
        check_known(keywords, *section, notes);
    }
}

void check_names(const Document& document, Notes& notes) {
    for (const auto& section : document.sections) {
        const auto known = std::ranges::find_if(known_sections, [&](std::string_view each) {
            return same_name(each, section.name) && each != section.name;
        });
        if (known != known_sections.end()) {
            notes.warning(section.line, fmt::format("[{}] is written [{}]", section.name, *known));
        }
        std::unordered_set<std::string_view> seen;
        for (const auto& entry : section.entries) {
            if (!seen.insert(entry.keyword).second) {
                notes.error(entry.line, fmt::format("{} is twice in [{}]", shown(entry.keyword), shown(section.name)));
            }
        }
    }
}

void check_order(const Document& document, Notes& notes) {
    for (std::size_t i = 0; i < first_sections.size(); ++i) {
        const auto* section = document.find(first_sections.at(i));
        if (section == nullptr) {
            notes.error(0, fmt::format("there is no [{}]", first_sections.at(i)));
        } else if (section != document.sections.data() + i) {
            notes.warning(section->line, fmt::format("[{}] should be section {} of the sheet", section->name, i + 1));
        }
    }
    const auto* params = document.find("Params");
    if (params == nullptr) return;
    for (const auto* user : {"Groups", "Assembly", "Connection Manager"}) {
        const auto* section = document.find(user);
        if (section == nullptr || section > params) continue;
        notes.warning(params->line, fmt::format("[Params] comes after [{}], which refers to it", user));
        return;
    }
}

}  // namespace

void lint_sections(const Sheet& sheet, Notes& notes) {
    check_order(sheet.document, notes);
    check_names(sheet.document, notes);
    check_keywords(sheet.document, notes);
}

void lint_identity(const Sheet& sheet, Notes& notes) {
    const auto line = [&](std::string_view section, std::string_view keyword) {
        const auto* entry = sheet.document.find(section, keyword);
        return entry != nullptr ? entry->line : 0;
    };
    constexpr std::uint8_t largest_major = 127;  // the highest bit is the key's (R-CON-11)
    constexpr std::size_t longest_product_name = 32;
    const auto& file = sheet.read.file;
    const auto& device = sheet.read.device;
    if (file.create_date && file.modification_date &&
        std::chrono::sys_days(*file.modification_date) < std::chrono::sys_days(*file.create_date)) {
        notes.warning(line("File", "ModDate"), "ModDate is before CreateDate");
    }
    if (device.major_revision && (*device.major_revision == 0 || *device.major_revision > largest_major)) {
        notes.error(line("Device", "MajRev"), fmt::format("MajRev is {}, and 1 to 127 can be", *device.major_revision));
    }
    if (device.minor_revision == 0) {
        notes.warning(line("Device", "MinRev"), "MinRev is 0; a device has 1 to 255, and 0 in a key means any");
    }
    if (device.product_name.size() > longest_product_name) {
        notes.error(line("Device", "ProdName"), fmt::format("ProdName has {} characters, and a device tells at most {}",
                                                            device.product_name.size(), longest_product_name));
    }
    constexpr std::array<std::uint8_t, 4> icon_begins{0, 0, 1, 0};
    if (!device.icon_content.empty() &&
        !std::ranges::equal(
            cip::ByteView(device.icon_content).first(std::min<std::size_t>(4, device.icon_content.size())),
            icon_begins)) {
        notes.warning(line("Device", "IconContents"), "IconContents is no .ico file");
    }
    if (!device.icon_content.empty() && device.icon.empty()) {
        notes.warning(line("Device", "IconContents"), "IconContents has no Icon, which is its file name");
    }
    const auto* classification = sheet.document.find("Device Classification");
    if (classification != nullptr && !contains(sheet.read.classifications, "EtherNetIP")) {
        notes.warning(classification->line, "no Class of [Device Classification] is EtherNetIP");
    }
}

}  // namespace servobus::eds
