// What people write: configuration, scenario, axis, what a drive has kept, and control lines. The first octet chooses which.
// A text is taken or refused with a reason and a place that is in it; what is taken describes a device that runs.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include "adapter/axis_file.hpp"
#include "adapter/config.hpp"
#include "adapter/control.hpp"
#include "adapter/json_document.hpp"
#include "adapter/scenario.hpp"
#include "adapter/state_file.hpp"
#include "adapter/state_json.hpp"
#include "drive/xenax.hpp"
#include "tests/fuzz/device_site.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

constexpr std::size_t most_events = 24;

void check_place(const adapter::FileError& error, const std::string& text, cip::ByteView input) {
    const auto lines = static_cast<std::size_t>(std::ranges::count(text, '\n')) + 1;
    require(!error.reason.empty(), "a refusal has a reason", input);
    require(error.line <= lines && error.column <= text.size() + 1, "what is wrong is in the text", input);
}

/// What was parsed; nullopt when it is refused, which has its place.
template <class Parsed>
std::optional<Parsed> taken(std::variant<Parsed, adapter::FileError> result, const std::string& text,
                            cip::ByteView input) {
    if (const auto* error = std::get_if<adapter::FileError>(&result)) {
        check_place(*error, text, input);
        return std::nullopt;
    }
    return std::get<Parsed>(std::move(result));
}

void read_config(const std::string& text, cip::ByteView input) {
    const auto config = taken(adapter::parse_config(text), text, input);
    if (!config) return;
    auto device = adapter::make_device(*config);
    adapter::Adapter drive(device, config->limits, config->seed, {},
                           adapter::make_network(device.identity(), config->network));
    drive.protect(config->protection);
    drive.allow(config->allowed);
    enip::Time now{std::chrono::hours(1)};
    drive.on_timer(now);
    const auto id = drive.on_open(DeviceSite::peer(0), DeviceSite::local, now);
    if (id) drive.on_closed(*id, now);
    drive.on_timer(now + std::chrono::seconds(1));
    require(drive.tcp_connections() == 0, "no connection is left", input);
}

void read_scenario(const std::string& text, cip::ByteView input) {
    const auto timetable = taken(adapter::parse_scenario(text), text, input);
    if (!timetable) return;
    const auto& entries = timetable->entries;
    require(entries.size() <= adapter::max_scenario_events, "events are bounded", input);
    require(std::ranges::is_sorted(entries, {}, &adapter::Timetable::Entry::at), "events are in order", input);
    require(!timetable->repeat_every || (timetable->repeat_every->count() > 0 &&
                                         (entries.empty() || *timetable->repeat_every >= entries.back().at)),
            "a repetition is not shorter than its events", input);
    DeviceSite site;
    for (std::size_t i = 0; i < std::min(most_events, entries.size()); ++i) {
        (void)site.adapter().inject(entries[i].event, site.now());
        site.advance(std::chrono::milliseconds(100));
    }
}

void read_axis(const std::string& text, cip::ByteView input) {
    const auto axis = taken(adapter::parse_axis(text), text, input);
    if (!axis) return;
    drive::Device device(drive::xenax_models().front(), {.axis = *axis});
    for (int i = 0; i < 20; ++i) device.step(std::chrono::microseconds(100) * i);
}

void read_state(const std::string& text, cip::ByteView input) {
    DeviceSite site;
    auto& drive = site.adapter();
    const auto& delivered = drive.delivered();
    const auto state = adapter::parse_state(text, delivered, drive.device());
    if (const auto* reason = std::get_if<std::string>(&state)) {
        require(!reason->empty(), "a refusal has a reason", input);
        return;
    }
    const auto& kept = std::get<adapter::StoredState>(state);
    const auto written = adapter::state_text(kept, delivered, drive.device().store());
    const auto again = adapter::parse_state(written, delivered, drive.device());
    require(std::holds_alternative<adapter::StoredState>(again) && std::get<adapter::StoredState>(again) == kept,
            "what was kept comes out the same", input);
    drive.power_up_with(kept);
    site.advance(std::chrono::milliseconds(10));
}

void read_state_file(const std::string& text, cip::ByteView input) {
    const auto payload = adapter::unseal(text);
    if (const auto* bad = std::get_if<adapter::BadState>(&payload)) {
        require(!bad->reason.empty(), "a refusal has a reason", input);
    } else {
        require(adapter::seal(std::get<std::string>(payload)) == text, "a whole file is sealed as it was", input);
    }
    const auto sealed = adapter::unseal(adapter::seal(text));
    require(std::holds_alternative<std::string>(sealed) && std::get<std::string>(sealed) == text,
            "what is sealed comes out the same", input);
}

// The one command that reads a file of the machine.
bool reads_a_file(const std::string& line) {
    const auto document = adapter::parse_json(line);
    const auto* read = std::get_if<adapter::JsonDocument>(&document);
    return read != nullptr && read->root.is_object() && read->root.contains("file");
}

void obey_lines(const std::string& text, cip::ByteView input) {
    DeviceSite site;
    adapter::Control control(site.adapter(), *adapter::shipped_axis(adapter::default_axis));
    std::size_t count = 0;
    for (std::size_t begin = 0; begin < text.size() && count < most_events; ++count) {
        const auto end = std::min(text.find('\n', begin), text.size());
        const auto line = text.substr(begin, end - begin);
        begin = end + 1;
        if (reads_a_file(line)) continue;
        const auto answer = control.answer(line, site.now());
        const auto document = adapter::parse_json(answer);
        require(std::holds_alternative<adapter::JsonDocument>(document), "an answer is JSON", input);
        require(answer.find('\n') == std::string::npos, "an answer is one line", input);
        site.advance(std::chrono::milliseconds(100));
    }
}

}  // namespace

void config(cip::ByteView input) {
    if (input.empty()) return;
    const std::string text(input.begin() + 1, input.end());
    switch (input[0] % 6) {
        case 0:
            return read_config(text, input);
        case 1:
            return read_scenario(text, input);
        case 2:
            return read_axis(text, input);
        case 3:
            return read_state(text, input);
        case 4:
            return read_state_file(text, input);
        default:
            return obey_lines(text, input);
    }
}

}  // namespace servobus::fuzz
