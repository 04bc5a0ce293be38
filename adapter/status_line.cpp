#include "adapter/status_line.hpp"

#include <fmt/format.h>

#include <array>
#include <map>
#include <optional>
#include <string_view>
#include <variant>

#include "drive/ds402.hpp"

namespace servobus::adapter {
namespace {

std::string_view drive_state(const Adapter& adapter) {
    constexpr drive::Key status_word{0x66, 0x01};
    const auto& device = adapter.device();
    const auto* row = device.find(status_word);
    const auto* word = row != nullptr ? std::get_if<std::int64_t>(&device.store().value(*row)) : nullptr;
    const auto state = word != nullptr ? drive::Ds402::state_of(static_cast<std::uint16_t>(*word)) : std::nullopt;
    return state ? drive::Ds402::name(*state) : "no state";
}

std::string lights_of_one(const Adapter& adapter, enip::Time now) {
    const auto lights = adapter.lights();
    std::string text;
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const bool lit = is_lit(lights[i].mode, adapter.elapsed(now));
        text += fmt::format("{}{} {}", i == 0 ? "" : " ", light_names[i], lit ? '*' : '-');
    }
    return text;
}

std::string owner_of_one(const Adapter& adapter) {
    const auto* owner = adapter.io().owner();
    if (owner == nullptr) return "no owner";
    const auto* doing = !owner->consumer.alive() ? "waiting" : owner->consumer.run() ? "run" : "idle";
    return fmt::format("owner {} {} {}", enip::address_text(owner->originator.address), owner->kind->key, doing);
}

// "RUN 3 on, 5 blink"; a light that is off everywhere is left out.
std::string lights_of_many(std::span<const Adapter* const> drives) {
    std::array<std::map<LightMode, std::size_t>, light_names.size()> counts;
    for (const auto* adapter : drives) {
        const auto lights = adapter->lights();
        for (std::size_t i = 0; i < lights.size(); ++i) ++counts[i][lights[i].mode];
    }
    std::string text;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        std::string modes;
        for (const auto mode : {LightMode::on, LightMode::blink}) {
            const auto count = counts[i][mode];
            if (count > 0) modes += fmt::format("{} {} {}", modes.empty() ? "" : ",", count, name(mode));
        }
        if (!modes.empty()) text += fmt::format("{}{}{}", text.empty() ? "" : ", ", light_names[i], modes);
    }
    return text.empty() ? "all lights off" : text;
}

std::string states_of_many(std::span<const Adapter* const> drives) {
    std::map<std::string_view, std::size_t> counts;
    for (const auto* adapter : drives) ++counts[drive_state(*adapter)];
    std::string text;
    for (const auto& [state, count] : counts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, state);
    return text;
}

std::string connections_of(std::span<const Adapter* const> drives) {
    std::size_t io = 0;
    std::size_t class3 = 0;
    for (const auto* adapter : drives) {
        io += adapter->io().size();
        class3 += adapter->class3_connections();
    }
    return fmt::format("{} I/O, {} class 3", io, class3);
}

std::size_t owners_of(std::span<const Adapter* const> drives) {
    std::size_t owners = 0;
    for (const auto* adapter : drives) owners += adapter->io().owner() != nullptr ? 1 : 0;
    return owners;
}

}  // namespace

std::string status_line(std::span<const Adapter* const> drives, enip::Time now, std::size_t width) {
    if (drives.empty()) return {};
    auto line = drives.size() == 1
                    ? fmt::format("{} | {} | {} | {}", lights_of_one(*drives[0], now), owner_of_one(*drives[0]),
                                  connections_of(drives), drive_state(*drives[0]))
                    : fmt::format("{} | {} owners | {} | {}", lights_of_many(drives), owners_of(drives),
                                  connections_of(drives), states_of_many(drives));
    if (line.size() > width) line.resize(width);
    return line;
}

}  // namespace servobus::adapter
