#include "adapter/status_lights.hpp"

namespace servobus::adapter {
namespace {

// A row of the manual's table: what one light does when all that `with` names is so, and nothing of `without`.
struct Row {
    Light light;
    unsigned with;
    unsigned without;
    ShownLight shows;
};

enum Condition : unsigned {
    powered = 1,
    initialising = 2,
    connected = 4,
    conflict = 8,
    fault = 16,
    factory = 32,
    bit_stream = 64,
    download = 128,
};

// The first row that fits counts; a light without one is off. What the manual leaves open: an address conflict hides a
// fault, since a drive that nobody can ask cannot tell of it otherwise; in factory mode no application runs that could
// leave the init process or know of conflicts and faults.
// clang-format off
constexpr std::array<Row, 10> rows{{
    {Light::run, 0,                    powered, {LightMode::off,   "no power"}},
    {Light::run, powered|initialising, 0,       {LightMode::off,   "in init process"}},
    {Light::run, powered|factory,      0,       {LightMode::off,   "in init process: no application runs"}},
    {Light::run, powered|connected,    0,       {LightMode::on,    "power on, connected"}},
    {Light::run, powered,              0,       {LightMode::blink, "power on, not connected"}},
    {Light::err, powered|conflict,     factory, {LightMode::blink, "IPv4 address conflict detected"}},
    {Light::err, powered|fault,        factory, {LightMode::on,    "fault state"}},
    {Light::st1, powered|factory|bit_stream, 0, {LightMode::on,
        "factory mode, valid application bit stream in the flash, ready for firmware download"}},
    {Light::st1, powered|factory,      0,       {LightMode::blink,
        "factory mode, no valid application bit stream in the flash, ready for bit stream download"}},
    {Light::st2, powered|download,     0,       {LightMode::blink, "firmware or bit stream download in progress"}},
}};
// clang-format on

constexpr unsigned conditions_of(const ModuleState& state) {
    const auto bit = [](bool is, Condition condition) { return is ? unsigned{condition} : 0U; };
    return bit(state.powered, powered) | bit(state.initialising, initialising) | bit(state.connected, connected) |
           bit(state.address_conflict, conflict) | bit(state.fault, fault) | bit(state.factory_mode, factory) |
           bit(state.valid_bit_stream, bit_stream) | bit(state.download, download);
}

}  // namespace

std::string_view name(LightMode mode) {
    switch (mode) {
        case LightMode::off:
            return "off";
        case LightMode::on:
            return "on";
        case LightMode::blink:
            return "blink";
    }
    return "";
}

StatusLights status_lights(const ModuleState& state) {
    const auto conditions = conditions_of(state);
    StatusLights lights;
    std::array<bool, lights.size()> decided{};
    for (const auto& row : rows) {
        const auto index = static_cast<std::size_t>(row.light);
        const bool fits = (conditions & row.with) == row.with && (conditions & row.without) == 0;
        if (!fits || decided[index]) continue;
        decided[index] = true;
        lights[index] = row.shows;
    }
    return lights;
}

}  // namespace servobus::adapter
