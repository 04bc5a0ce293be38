#include "assemblies/layout.hpp"

#include <algorithm>
#include <array>

#include "assemblies/parameter_value.hpp"
#include "cip/wire.hpp"

namespace servobus::assemblies {
namespace {

constexpr Member parameter(std::uint16_t class_id, std::uint16_t attribute, std::uint8_t octets) {
    return {Member::Kind::parameter, {class_id, attribute}, octets};
}

// Every output assembly is the front of the largest one, every input assembly likewise.
constexpr std::array outputs{
    parameter(0x66, 0x3A, 4),  // TargetPositionOrDistance
    parameter(0x66, 0x41, 4),  // SpeedJogOrProfilePositionMode
    parameter(0x66, 0x43, 4),  // AccelerationJogOrProfilePositionMode
    parameter(0x64, 0x00, 4),  // SCurve
    parameter(0x66, 0x00, 2),  // Controlword
    parameter(0x66, 0x33, 2),  // LimitIForce
    parameter(0x66, 0x25, 4),  // FollowingPositionErrorWindow
    parameter(0x66, 0x27, 4),  // TargetPositionWindow
    parameter(0x66, 0xBF, 4),  // DigitalOutputsXENAX
    parameter(0x64, 0x09, 4),  // LimitForce
    Member{Member::Kind::padding, {}, 4},
    Member{Member::Kind::time_stamp, {}, 8},
};

constexpr std::array inputs{
    parameter(0x66, 0x01, 2),  // Statusword
    parameter(0x66, 0x38, 2),  // MotorCurrentActualValue
    parameter(0x66, 0x24, 4),  // PositionActualValue
    parameter(0x64, 0x05, 4),  // IForceActual
    parameter(0x64, 0x06, 4),  // ProcessStatusRegisterXENAX
    parameter(0x66, 0xB4, 4),  // ActualPositionFollowingError
    parameter(0x66, 0xBD, 4),  // DigitalInputsXENAX
    parameter(0x66, 0xBF, 4),  // DigitalOutputsXENAX
    parameter(0x64, 0x0A, 4),  // ForceActual
    Member{Member::Kind::time_stamp, {}, 8},
};

constexpr std::span<const Member> first_outputs(std::size_t count) {
    return std::span<const Member>(outputs).first(count);
}
constexpr std::span<const Member> first_inputs(std::size_t count) {
    return std::span<const Member>(inputs).first(count);
}

constexpr std::array all{
    Layout{100, Direction::t_to_o, "Standard", first_inputs(8)},
    Layout{101, Direction::o_to_t, "Standard", first_outputs(5)},
    Layout{102, Direction::o_to_t, "I Force", first_outputs(6)},
    Layout{103, Direction::o_to_t, "Digital Outputs", first_outputs(9)},
    Layout{104, Direction::o_to_t, "Force", first_outputs(10)},
    Layout{105, Direction::t_to_o, "Force", first_inputs(9)},
    Layout{112, Direction::o_to_t, "CIP Sync", first_outputs(12)},
    Layout{113, Direction::t_to_o, "CIP Sync", first_inputs(10)},
};
static_assert(all[0].size() == 28 && all[1].size() == 18 && all[2].size() == 20 && all[3].size() == 32);
static_assert(all[4].size() == 36 && all[5].size() == 32 && all[6].size() == 48 && all[7].size() == 40);

void put(std::uint64_t raw, std::span<std::uint8_t> octets) {
    for (auto& octet : octets) {
        octet = static_cast<std::uint8_t>(raw);
        raw >>= 8;
    }
}

std::uint64_t present(const Member& member, const drive::Device& device, std::int64_t time_stamp) {
    if (member.kind == Member::Kind::time_stamp) return static_cast<std::uint64_t>(time_stamp);
    const auto* row = member.kind == Member::Kind::parameter ? device.find(member.key) : nullptr;
    if (row == nullptr) return 0;
    const auto* number = std::get_if<std::int64_t>(&device.store().value(*row));
    return number != nullptr ? static_cast<std::uint64_t>(*number) : 0;
}

// Calls `act(row, value)` for each parameter of the image until one refuses.
template <class Act>
std::optional<drive::Refusal> for_each_parameter(const Layout& layout, cip::ByteView image, const drive::Device& device,
                                                 Act act) {
    cip::Reader reader(image);
    for (const auto& member : layout.members) {
        const auto octets = reader.take(member.octets);
        if (member.kind != Member::Kind::parameter) continue;
        const auto* row = device.find(member.key);
        if (row == nullptr) return drive::Refusal::not_configured;
        const auto value = read_value(*row, octets);
        if (!value) return drive::Refusal::wrong_type;
        if (const auto refusal = act(*row, *value)) return refusal;
    }
    return std::nullopt;
}

}  // namespace

std::span<const Layout> layouts() { return all; }

const Layout* find_layout(std::uint32_t instance) {
    const auto found = std::ranges::find(all, instance, &Layout::instance);
    return found != all.end() ? &*found : nullptr;
}

void pack(const Layout& layout, const drive::Device& device, std::int64_t time_stamp, std::span<std::uint8_t> image) {
    for (const auto& member : layout.members) {
        put(present(member, device, time_stamp), image.first(member.octets));
        image = image.subspan(member.octets);
    }
}

std::optional<drive::Refusal> unpack(const Layout& layout, cip::ByteView image, drive::Device& device) {
    const auto refused = for_each_parameter(
        layout, image, device, [&](const auto& row, const auto& value) { return device.check(row, value); });
    if (refused) return refused;
    return for_each_parameter(layout, image, device, [&](const auto& row, const auto& value) {
        return device.write_process_data(row, value);
    });
}

}  // namespace servobus::assemblies
