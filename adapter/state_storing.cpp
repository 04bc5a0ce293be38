#include "adapter/state_storing.hpp"

#include <fmt/format.h>

#include "adapter/state_json.hpp"

namespace servobus::adapter {

void StateStoring::keep(Adapter& adapter) {
    const auto serial_number = adapter.device().identity().serial_number;
    auto& drive = *drives_.emplace_back(
        std::make_unique<Drive>(Drive{&adapter, StateFile(files_, directory_.file_of(serial_number)), {}}));
    load(drive);
    adapter.store_with([this, &drive](const StoredState& state) { begin(drive, state); });
}

void StateStoring::load(Drive& drive) {
    const auto payload = drive.file.load();
    if (!payload) return;
    if (const auto* bad = std::get_if<BadState>(&*payload)) return set_aside(drive, *bad);
    auto& adapter = *drive.adapter;
    const auto state = parse_state(std::get<std::string>(*payload), adapter.delivered(), adapter.device());
    if (const auto* reason = std::get_if<std::string>(&state)) {
        return set_aside(drive, {BadState::Kind::damaged, *reason});
    }
    adapter.power_up_with(std::get<StoredState>(state));
    log_(LogLevel::info, fmt::format("the state is that of {}", drive.file.path().string()));
}

void StateStoring::set_aside(Drive& drive, const BadState& bad) {
    const auto aside = drive.file.keep_aside(bad.kind);
    const auto* error = std::get_if<std::error_code>(&aside);
    const auto where = error == nullptr
                           ? fmt::format("it is kept as {}", std::get<std::filesystem::path>(aside).filename().string())
                           : fmt::format("it cannot be renamed: {}", error->message());
    log_(LogLevel::error, fmt::format("{} is of no use: {}. {}, and the drive is as delivered",
                                      drive.file.path().string(), bad.reason, where));
    drive.adapter->report_bad_configuration();
}

void StateStoring::begin(Drive& drive, const StoredState& state) {
    background_(
        *drive.adapter, [&drive, state] { drive.outcome = store(drive, state); },
        [this, &drive](enip::Time now) {
            if (drive.outcome) {
                log_(LogLevel::error,
                     fmt::format("{} cannot be stored: {}", drive.file.path().string(), drive.outcome.message()));
            }
            drive.adapter->on_stored(!drive.outcome, now);
        });
}

std::error_code StateStoring::store(Drive& drive, const StoredState& state) {
    return drive.file.store(state_text(state, drive.adapter->delivered(), drive.adapter->device().store()));
}

void StateStoring::finish() {
    for (const auto& drive : drives_) {
        if (!drive->adapter->is_storing()) continue;
        if (const auto error = store(*drive, drive->adapter->kept())) {
            log_(LogLevel::error, fmt::format("{} cannot be stored: {}", drive->file.path().string(), error.message()));
        }
    }
}

}  // namespace servobus::adapter
