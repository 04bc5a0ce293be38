#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "eds/field_values.hpp"
#include "eds/lint_rules.hpp"

namespace servobus::eds {
namespace {

constexpr std::size_t fields_of_a_parameter = 21;
constexpr std::size_t with_international_texts = 24;

// The numbers of whole-number types that have fewer than 64 bits.
struct Numbers {
    std::int64_t lowest;
    std::int64_t highest;
};
std::optional<Numbers> numbers_of(const Parameter& parameter) {
    const auto kind = kind_of(parameter.type);
    const auto octets = octets_of(parameter.type);
    if (kind == TypeKind::boolean) return Numbers{0, 1};
    if (!octets || *octets > 4) return std::nullopt;
    const auto bits = 8 * *octets;
    if (kind == TypeKind::signed_integer)
        return Numbers{-(std::int64_t{1} << (bits - 1)), (std::int64_t{1} << (bits - 1)) - 1};
    if (kind == TypeKind::unsigned_integer) return Numbers{0, (std::int64_t{1} << bits) - 1};
    return std::nullopt;
}

// -1, 0 or 1 as two values of a parameter's type compare; nullopt when one of them is missing, or no number.
std::optional<int> compare(const Parameter& parameter, const Value& one, const Value& other) {
    const auto order = [](auto a, auto b) { return a < b ? -1 : a > b ? 1 : 0; };
    const auto* whole = std::get_if<std::int64_t>(&one);
    const auto* other_whole = std::get_if<std::int64_t>(&other);
    if (whole != nullptr && other_whole != nullptr) {
        if (kind_of(parameter.type) != TypeKind::unsigned_integer) return order(*whole, *other_whole);
        return order(static_cast<std::uint64_t>(*whole), static_cast<std::uint64_t>(*other_whole));
    }
    const auto real = [](const Value& value) -> std::optional<double> {
        if (const auto* fraction = std::get_if<double>(&value)) return *fraction;
        if (const auto* number = std::get_if<std::int64_t>(&value)) return static_cast<double>(*number);
        return std::nullopt;
    };
    const auto left = real(one);
    const auto right = real(other);
    return left && right ? std::optional(order(*left, *right)) : std::nullopt;
}

// One ParamN as it is written.
void check_fields(const Entry& entry, Notes& notes) {
    const auto count = entry.fields.size();
    if (count < fields_of_a_parameter || count > with_international_texts) {
        notes.warning(entry.line,
                      fmt::format("{} has {} fields, where {} belong", entry.keyword, count, fields_of_a_parameter));
    }
    if (integer(entry.field(1)) != 0)
        notes.warning(entry.line, fmt::format("{}: field 1 is reserved, and 0", entry.keyword));
    const auto pattern = path_pattern(entry.field(3));
    const auto octets = pattern ? pattern->octets() : std::nullopt;
    if (!octets) return;
    const auto stated = integer(entry.field(2)).value_or(0);
    if (static_cast<std::uint64_t>(stated) != octets->size()) {
        notes.error(entry.line, fmt::format("{}: the path has {} octets, and {} are stated", entry.keyword,
                                            octets->size(), stated));
    }
    if (!octets->empty() && entry.field(3).kind == Field::Kind::word) {
        notes.warning(entry.line, fmt::format("{}: the path should be in quotes", entry.keyword));
    }
}

// One parameter, as far as no other has to do with it.
class ParameterCheck {
public:
    ParameterCheck(const DataSheet& sheet, const Parameter& parameter, Notes& notes)
        : sheet_(sheet), parameter_(parameter), notes_(notes) {}

    void run() {
        if (parameter_.number == 0) error("the numbers of Params begin with 1");
        if (parameter_.name.empty()) warning("there is no name");
        check_path(sheet_, parameter_.path, parameter_.line, fmt::format("Param{}", parameter_.number), notes_);
        if ((parameter_.descriptor & reserved_parameter_bits) != 0) {
            warning(fmt::format("descriptor 0x{:04X} has reserved bits", parameter_.descriptor));
        }
        check_type();
        check_limits();
        check_enumeration();
        check_scaling();
    }

private:
    void error(std::string_view words) { notes_.error(parameter_.line, said(words)); }
    void warning(std::string_view words) { notes_.warning(parameter_.line, said(words)); }
    [[nodiscard]] std::string said(std::string_view words) const {
        return fmt::format("Param{}: {}", parameter_.number, words);
    }

    void check_type() {
        const auto octets = octets_of(parameter_.type);
        const bool known = octets || kind_of(parameter_.type) != TypeKind::unknown;
        if (!known)
            return error(fmt::format("data type 0x{:02X} does not exist", static_cast<unsigned>(parameter_.type)));
        if (octets && parameter_.size && *octets != *parameter_.size) {
            error(fmt::format("the data type has {} octets, and {} are stated", *octets, *parameter_.size));
        }
    }

    void check_limits() {
        const auto& p = parameter_;
        if (const auto numbers = numbers_of(p)) {
            for (const auto& [value, name] : {std::pair(&p.minimum, "minimum"), std::pair(&p.maximum, "maximum"),
                                              std::pair(&p.standard, "default")}) {
                const auto* number = std::get_if<std::int64_t>(value);
                if (number == nullptr || (*number >= numbers->lowest && *number <= numbers->highest)) continue;
                error(fmt::format("the {} {} does not fit the data type", name, *number));
            }
        }
        if (compare(p, p.minimum, p.maximum) == 1) error("the minimum is above the maximum");
        if (const auto* text = std::get_if<std::string>(&p.standard)) return check_text(*text);
        if (compare(p, p.standard, p.minimum) == -1) error("the default is below the minimum");
        if (compare(p, p.standard, p.maximum) == 1) error("the default is above the maximum");
    }

    void check_text(const std::string& text) {
        const auto* longest = std::get_if<std::int64_t>(&parameter_.maximum);
        if (parameter_.type == cip::DataType::EPATH || longest == nullptr || *longest < 0) return;
        if (text.size() > static_cast<std::uint64_t>(*longest)) error("the default is longer than the maximum");
    }

    void check_enumeration() {
        const auto& p = parameter_;
        if (p.has(ParameterBit::enumerated) != !p.enumeration.empty()) {
            if (p.enumeration.empty()) {
                error(fmt::format("the descriptor promises Enum{}, which is not there", p.number));
            } else {
                warning(fmt::format("the descriptor does not say that there is an Enum{}", p.number));
            }
        }
        std::unordered_set<std::int64_t> values;
        for (const auto& [value, text] : p.enumeration) {
            if (!values.insert(value).second) error(fmt::format("Enum{} has {} twice", p.number, value));
            if (text.empty()) warning(fmt::format("Enum{} has no text for {}", p.number, value));
            if (!is_bit_string() && (compare(p, value, p.minimum) == -1 || compare(p, value, p.maximum) == 1)) {
                warning(fmt::format("Enum{} has {}, which is outside the limits", p.number, value));
            }
        }
        const auto* standard = std::get_if<std::int64_t>(&p.standard);
        const bool also_numbers = p.has(ParameterBit::numbers_and_enumeration) || is_bit_string();
        if (standard != nullptr && !values.empty() && !also_numbers && !values.contains(*standard)) {
            warning(fmt::format("the default {} is not in Enum{}", *standard, p.number));
        }
    }

    // The texts are those of its bits.
    [[nodiscard]] bool is_bit_string() const {
        using enum cip::DataType;
        return parameter_.type == BYTE || parameter_.type == WORD || parameter_.type == DWORD ||
               parameter_.type == LWORD;
    }

    void check_scaling() {
        const auto& scaling = parameter_.scaling;
        const bool scales = parameter_.has(ParameterBit::scaling);
        const bool zero = scaling.divisor == 0 || scaling.multiplier == 0 || scaling.base == 0;
        if (scales && zero) error("a multiplier, divisor or base of 0 makes no value");
        const bool changes = scaling.multiplier * scaling.base != scaling.divisor || scaling.offset != 0;
        if (!scales && !zero && changes) warning("it has a scaling, and the descriptor says that it has none");
        for (const auto link : scaling.links) {
            if (link == 0) continue;
            if (sheet_.parameter(link) == nullptr)
                error(fmt::format("a scaling link names Param{}, which is not there", link));
            if (!parameter_.has(ParameterBit::scaling_links))
                warning("it has scaling links, and the descriptor says none");
        }
    }

    const DataSheet& sheet_;
    const Parameter& parameter_;
    Notes& notes_;
};

void check_names(const DataSheet& sheet, Notes& notes) {
    std::unordered_map<std::string, std::uint32_t> seen;
    for (const auto& parameter : sheet.parameters) {
        if (parameter.name.empty()) continue;
        const auto [first, is_new] = seen.try_emplace(lower_case(parameter.name), parameter.number);
        if (is_new) continue;
        notes.warning(parameter.line, fmt::format("Param{} has the name of Param{}, {}", parameter.number,
                                                  first->second, shown(parameter.name)));
    }
}

void check_class(const Sheet& sheet, Notes& notes) {
    const auto* entry = sheet.document.find("ParamClass", "MaxInst");
    const auto stated = entry != nullptr ? integer(entry->field(1)) : std::nullopt;
    std::uint32_t highest = 0;
    for (const auto& parameter : sheet.read.parameters) highest = std::max(highest, parameter.number);
    if (stated && *stated != highest) {
        notes.error(entry->line,
                    fmt::format("MaxInst of [ParamClass] is {}, and the highest Param is {}", *stated, highest));
    }
    const auto* configuration = sheet.document.find("ParamClass", "CfgAssembly");
    const auto instance = configuration != nullptr ? integer(configuration->field(1)) : std::nullopt;
    if (instance && *instance != 0 && sheet.read.assembly(fmt::format("Assem{}", *instance)) == nullptr) {
        notes.warning(configuration->line,
                      fmt::format("CfgAssembly is {}, and there is no Assem{}", *instance, *instance));
    }
}

void check_group(const DataSheet& sheet, const Entry& entry, const Group& group, Notes& notes) {
    if (group.name.empty()) notes.warning(group.line, fmt::format("{} has no name", entry.keyword));
    const auto stated = integer(entry.field(2));
    const auto listed = entry.fields.size() - std::min<std::size_t>(2, entry.fields.size());
    if (!stated || static_cast<std::uint64_t>(*stated) != listed) {
        notes.error(group.line, fmt::format("{} says that it has {} Params, and lists {}", entry.keyword,
                                            shown(entry.field(2).value), listed));
    }
    std::unordered_set<std::uint32_t> seen;
    for (const auto number : group.parameters) {
        if (sheet.parameter(number) == nullptr) {
            notes.error(group.line, fmt::format("{} lists Param{}, which is not there", entry.keyword, number));
        } else if (!seen.insert(number).second) {
            notes.warning(group.line, fmt::format("{} lists Param{} twice", entry.keyword, number));
        }
    }
}

}  // namespace

void lint_parameters(const Sheet& sheet, Notes& notes) {
    const auto& [document, read] = sheet;
    for (const auto* entry : numbered(document, "Params", "Param")) check_fields(*entry, notes);
    for (const auto& parameter : read.parameters) ParameterCheck(read, parameter, notes).run();
    check_names(read, notes);
    check_class(sheet, notes);
    const auto groups = numbered(document, "Groups", "Group");
    for (std::size_t i = 0; i < groups.size(); ++i) check_group(read, *groups[i], read.groups[i], notes);
}

}  // namespace servobus::eds
