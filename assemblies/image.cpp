#include "assemblies/image.hpp"

#include <algorithm>

#include "assemblies/parameter_value.hpp"
#include "cip/wire.hpp"

namespace servobus::assemblies {
namespace {

constexpr drive::Key control_word_key{0x66, 0x00};
constexpr drive::Key target_key{0x66, 0x3A};  // a set point in cyclic synchronous position mode
constexpr std::int64_t start_bit = 1 << 4;
// What may start a motion while bit 4 is set: bit 4 itself, enabling operation, the end of a halt.
constexpr std::int64_t starting_bits = 0x011F;

void put(std::uint64_t raw, std::span<std::uint8_t> octets) {
    for (auto& octet : octets) {
        octet = static_cast<std::uint8_t>(raw);
        raw >>= 8;
    }
}

// The octets of a member are as many as its row's type has, so that there is always a number.
std::int64_t number(const drive::Parameter& row, cip::ByteView octets) {
    const auto value = read_value(row, octets);
    return value ? *std::get_if<std::int64_t>(&*value) : 0;
}

}  // namespace

Image::Image(const Layout& layout, drive::Device& device) : layout_(&layout), device_(&device), size_(layout.size()) {
    members_.reserve(layout.members.size());
    for (const auto& member : layout.members) members_.push_back(bind(member, device));
}

Image::Bound Image::bind(const Member& member, drive::Device& device) {
    Bound bound{.octets = member.octets};
    if (member.kind == Member::Kind::time_stamp) bound.role = Role::time_stamp;
    if (member.kind != Member::Kind::parameter) return bound;
    const auto* row = device.find(member.key);
    if (row == nullptr || row->is_text() || drive::size_of(row->cip.type) != member.octets) return bound;
    // What the drive does not have it still shows, as 0 (ForceActual of an Xvi 75V8).
    bound.cell = device.store().variable(*row);
    bound.row = row;
    const bool missing = device.check(*row, device.store().value(*row)) == drive::Refusal::not_configured;
    bound.role = missing                          ? Role::nothing
                 : member.key == control_word_key ? Role::control_word
                 : member.key == target_key       ? Role::command
                                                  : Role::setting;
    return bound;
}

void Image::pack(std::int64_t time_stamp, std::span<std::uint8_t> octets) const {
    for (const auto& member : members_) {
        std::int64_t value = 0;
        if (member.row != nullptr) value = member.cell.get();
        if (member.role == Role::time_stamp) value = time_stamp;
        put(static_cast<std::uint64_t>(value), octets.first(member.octets));
        octets = octets.subspan(member.octets);
    }
}

void Image::refuse(std::size_t index, drive::Refusal refusal, Outcome& outcome) const {
    if (outcome.refused == 0) outcome.first_refusal = refusal;
    outcome.refused |= 1U << index;
}

// Before anything is written, since the Controlword stands in the middle.
Image::Outcome Image::check(cip::ByteView octets) const {
    Outcome outcome;
    cip::Reader reader(octets);
    for (std::size_t i = 0; i < members_.size(); ++i) {
        const auto& member = members_[i];
        const auto raw = reader.take(member.octets);
        if (member.role != Role::setting && member.role != Role::command) continue;
        const auto value = number(*member.row, raw);
        if (value == member.cell.get()) continue;
        if (const auto refusal = device_->check(*member.row, value)) refuse(i, *refusal, outcome);
    }
    return outcome;
}

std::int64_t Image::guarded(std::int64_t word, const Bound& control_word, Outcome& outcome) {
    const bool start = (word & start_bit) != 0;
    const bool starts = ((word ^ control_word.cell.get()) & starting_bits) != 0;
    start_held_ = start && (start_held_ || (starts && outcome.refused != 0));
    outcome.start_held = start_held_;
    return start_held_ ? word & ~start_bit : word;
}

Image::Outcome Image::apply(cip::ByteView octets) {
    if (octets.size() != size_) {
        return {.refused = (1U << members_.size()) - 1, .first_refusal = drive::Refusal::wrong_type};
    }
    auto outcome = check(octets);
    cip::Reader reader(octets);
    for (std::size_t i = 0; i < members_.size(); ++i) {
        const auto& member = members_[i];
        const auto raw = reader.take(member.octets);
        if (member.role == Role::nothing || member.role == Role::time_stamp || (outcome.refused >> i & 1U) != 0) {
            continue;
        }
        auto value = number(*member.row, raw);
        if (member.role == Role::control_word) value = guarded(value, member, outcome);
        if (member.role == Role::setting && value == member.cell.get()) continue;
        if (const auto refusal = device_->write_process_data(*member.row, value)) refuse(i, *refusal, outcome);
    }
    return outcome;
}

}  // namespace servobus::assemblies
