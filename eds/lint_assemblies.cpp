#include <fmt/format.h>

#include "eds/field_values.hpp"
#include "eds/lint_rules.hpp"

namespace servobus::eds {
namespace {

constexpr std::size_t fields_before_members = 6;

class AssemblyCheck {
public:
    AssemblyCheck(const DataSheet& sheet, const Assembly& assembly, Notes& notes)
        : sheet_(sheet), assembly_(assembly), notes_(notes) {}

    void run() {
        check_path(sheet_, assembly_.path, assembly_.line, assembly_.keyword, notes_);
        for (const auto& member : assembly_.members) check_member(member);
        if (!assembly_.size) return warning("neither its size nor its members tell how many octets it has");
        check_sum();
    }

private:
    void error(std::string_view words) {
        notes_.error(assembly_.line, fmt::format("{}: {}", assembly_.keyword, words));
    }
    void warning(std::string_view words) {
        notes_.warning(assembly_.line, fmt::format("{}: {}", assembly_.keyword, words));
    }

    // Octets of what a member refers to, as far as they are known.
    std::optional<std::size_t> octets_of_reference(const Member& member) {
        if (const auto* reference = std::get_if<Member::Parameter>(&member.reference)) {
            const auto* parameter = sheet_.parameter(reference->number);
            return parameter != nullptr ? parameter->size : std::nullopt;
        }
        if (const auto* reference = std::get_if<Member::Assembly>(&member.reference)) {
            const auto* inner = sheet_.assembly(reference->keyword);
            return inner != nullptr ? inner->size : std::nullopt;
        }
        return std::nullopt;
    }

    void check_member(const Member& member) {
        const auto* parameter = std::get_if<Member::Parameter>(&member.reference);
        const auto* inner = std::get_if<Member::Assembly>(&member.reference);
        if (parameter != nullptr && sheet_.parameter(parameter->number) == nullptr) {
            error(fmt::format("a member is Param{}, which is not there", parameter->number));
        }
        if (inner != nullptr && sheet_.assembly(inner->keyword) == nullptr && inner->keyword.starts_with("Assem")) {
            error(fmt::format("a member is {}, which is not there", shown(inner->keyword)));
        }
        const auto octets = octets_of_reference(member);
        const bool one_bit = parameter != nullptr && octets && member.bits == 1U &&
                             kind_of(sheet_.parameter(parameter->number)->type) == TypeKind::boolean;
        if (octets && member.bits && *member.bits != 8 * *octets && !one_bit) {
            const auto what =
                parameter != nullptr ? fmt::format("Param{}", parameter->number) : std::string(shown(inner->keyword));
            warning(fmt::format("a member has {} bits, and {} has {}", *member.bits, what, 8 * *octets));
        }
    }

    // The members' bits are those of the size; nothing is said where a member's are not known.
    void check_sum() {
        std::uint64_t bits = 0;
        for (const auto& member : assembly_.members) {
            const auto octets = octets_of_reference(member);
            if (!member.bits && !octets) return;
            bits += member.bits ? *member.bits : 8 * *octets;
        }
        if (assembly_.members.empty() || (bits + 7) / 8 == *assembly_.size) return;
        error(fmt::format("the members have {} bits, and {} octets are stated", bits, *assembly_.size));
    }

    const DataSheet& sheet_;
    const Assembly& assembly_;
    Notes& notes_;
};

void check_fields(const Entry& entry, Notes& notes) {
    if (entry.fields.size() < fields_before_members) {
        notes.warning(entry.line, fmt::format("{} has {} fields, where at least {} belong", shown(entry.keyword),
                                              entry.fields.size(), fields_before_members));
    }
    if (!entry.field(5).is_empty() || !entry.field(6).is_empty()) {
        notes.warning(entry.line, fmt::format("{}: fields 5 and 6 are reserved, and empty", shown(entry.keyword)));
    }
    if (entry.fields.size() > fields_before_members && entry.fields.size() % 2 != 0) {
        notes.warning(entry.line, fmt::format("{}: its last member has a size and no reference", shown(entry.keyword)));
    }
}

}  // namespace

void lint_assemblies(const Sheet& sheet, Notes& notes) {
    for (const auto& assembly : sheet.read.assemblies) {
        AssemblyCheck(sheet.read, assembly, notes).run();
    }
    for (const auto* entry : numbered(sheet.document, "Assembly", "Assem")) check_fields(*entry, notes);
}

}  // namespace servobus::eds
