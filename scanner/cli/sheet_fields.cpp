#include "scanner/cli/sheet_fields.hpp"

#include <fmt/format.h>

#include <map>

#include "scanner/cli/text_output.hpp"
#include "scanner/cli/what.hpp"

namespace servobus::scanner::cli {
namespace {

using Kind = assemblies::Member::Kind;
using Reference = eds::Member;

constexpr std::size_t bits_per_octet = 8;

class Walker {
public:
    explicit Walker(const eds::DataSheet& sheet) : sheet_(sheet) {}

    void walk(const eds::Assembly& assembly, unsigned depth) {
        for (const auto& member : assembly.members) {
            if (fields_.size() >= max_sheet_fields) return;
            const auto* inner = inner_assembly(member);
            if (inner != nullptr && depth < eds::max_assembly_depth) {
                const auto end = bit_ + bits_of(member, inner->size.value_or(0));
                walk(*inner, depth + 1);
                bit_ = end;
            } else {
                add(member);
            }
        }
    }

    IoFields take() { return std::move(fields_); }

private:
    [[nodiscard]] const eds::Assembly* inner_assembly(const eds::Member& member) const {
        const auto* reference = std::get_if<Reference::Assembly>(&member.reference);
        return reference != nullptr ? sheet_.assembly(reference->keyword) : nullptr;
    }

    static std::size_t bits_of(const eds::Member& member, std::size_t octets) {
        return member.bits.value_or(static_cast<std::uint32_t>(bits_per_octet * octets));
    }

    void add(const eds::Member& member) {
        IoField field;
        field.kind = Kind::padding;
        std::size_t octets = 0;
        if (const auto* reference = std::get_if<Reference::Parameter>(&member.reference)) {
            field.parameter = sheet_.parameter(reference->number);
            if (field.parameter != nullptr) octets = field.parameter->size.value_or(0);
            describe(field, fmt::format("Param{}", reference->number));
        } else if (const auto* path = std::get_if<eds::PathPattern>(&member.reference)) {
            const auto at = eds::attribute_address(*path);
            if (at) describe(field, cip_address(Attribute{at->class_id, at->instance, at->attribute}));
        }
        const auto bits = bits_of(member, octets);
        if (bits == 0) return;
        field.offset = bit_ / bits_per_octet;
        field.first_bit = bit_ % bits_per_octet;
        field.octets = (field.first_bit + bits + bits_per_octet - 1) / bits_per_octet;
        field.bits = bits;
        bit_ += bits;
        fields_.push_back(std::move(field));
    }

    void describe(IoField& field, const std::string& otherwise) {
        field.kind = Kind::parameter;
        const bool named = field.parameter != nullptr && !field.parameter->name.empty();
        field.label = named ? printable(field.parameter->name) : otherwise;
        const auto count = ++seen_[field.label];
        if (count > 1) field.label += fmt::format("#{}", count);
    }

    const eds::DataSheet& sheet_;
    std::size_t bit_ = 0;
    std::map<std::string, unsigned> seen_;
    IoFields fields_;
};

}  // namespace

IoFields fields_of(const eds::DataSheet& sheet, const eds::Assembly& assembly) {
    Walker walker(sheet);
    walker.walk(assembly, 0);
    return walker.take();
}

}  // namespace servobus::scanner::cli
