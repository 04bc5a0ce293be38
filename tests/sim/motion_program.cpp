#include "tests/sim/motion_program.hpp"

#include <algorithm>

#include "drive/xenax.hpp"
#include "tests/sim/target_watch.hpp"

namespace servobus::sim {
namespace {

constexpr std::uint16_t start_bit = 1U << 4;
constexpr std::uint16_t positive_bit = 1U << 6;

constexpr std::uint16_t switch_on = 0x07;
constexpr std::uint16_t shutdown = 0x06;
constexpr std::uint16_t enable_operation = 0x0F;
constexpr std::uint16_t fault_reset = 0x80;

void put(std::span<std::uint8_t> to, std::uint32_t value, std::size_t octets) {
    for (auto& octet : to.first(octets)) {
        octet = static_cast<std::uint8_t>(value);
        value >>= 8;
    }
}

/// Members that nobody cares about have their defaults, which every drive takes.
cip::Bytes default_image(const assemblies::Layout& layout) {
    cip::Bytes image(layout.size());
    std::size_t offset = 0;
    for (const auto& member : layout.members) {
        if (member.kind == assemblies::Member::Kind::parameter) {
            const auto rows = drive::parameters();
            const auto row = std::ranges::find_if(rows, [&](const auto& each) { return each.key() == member.key; });
            put(std::span(image).subspan(offset), static_cast<std::uint32_t>(row->standard),
                std::min<std::size_t>(member.octets, 4));
        }
        offset += member.octets;
    }
    return image;
}

}  // namespace

MotionProgram::MotionProgram(const assemblies::Connection& kind, bool jog, std::uint64_t seed)
    : jog_(jog), random_(seed) {
    status_place_ = offset_of(*kind.inputs(), {0x66, 0x01}).value_or(0);
    const auto* outputs = kind.outputs();
    if (outputs == nullptr) return;
    idle_image_ = default_image(*outputs);
    places_ = Places{.target = *offset_of(*outputs, {0x66, 0x3A}),
                     .speed = *offset_of(*outputs, {0x66, 0x41}),
                     .acceleration = *offset_of(*outputs, {0x66, 0x43}),
                     .control = *offset_of(*outputs, {0x66, 0x00})};
}

void MotionProgram::input(cip::ByteView data) {
    if (data.size() < status_place_ + 2) return;
    status_ = static_cast<std::uint16_t>(data[status_place_] | data[status_place_ + 1] << 8);
}

bool MotionProgram::output(std::span<std::uint8_t> data) {
    if (!places_) return run_;
    std::ranges::copy(idle_image_, data.begin());
    word_ = next_word();
    const auto base = there_ ? 40'000U : 0U;
    put(data.subspan(places_->target), base + ++stamp_ % 20'000, 4);
    put(data.subspan(places_->speed), 40'000, 4);
    put(data.subspan(places_->acceleration), 400'000, 4);
    put(data.subspan(places_->control), word_, 2);
    return run_;
}

/// The state machine of the drive, from the side of whoever commands it (004 §4.1).
std::uint16_t MotionProgram::next_word() {
    if (goal_ == Goal::relax) return 0;
    if ((status_ & 0x08) != 0) return word_ == 0 ? fault_reset : std::uint16_t{0};
    switch (status_ & 0x6F) {
        case 0x21:
            return switch_on;
        case 0x23:
        case 0x07:
            return enable_operation;
        case 0x27:
            return goal_ == Goal::move ? moving_word() : enable_operation;
        default:
            return shutdown;
    }
}

/// Back and forth. A start bit is taken back first, since only its edge counts after a stop.
std::uint16_t MotionProgram::moving_word() {
    if ((word_ & 0x0F) != enable_operation) return enable_operation;
    if (patience_ > 0) {
        --patience_;
        return word_;
    }
    patience_ = static_cast<std::uint32_t>(random_.between(5, 400));
    if ((word_ & start_bit) != 0) return enable_operation;
    there_ = !there_;
    return static_cast<std::uint16_t>(enable_operation | start_bit | (jog_ && there_ ? positive_bit : 0));
}

}  // namespace servobus::sim
