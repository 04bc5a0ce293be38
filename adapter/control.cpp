#include "adapter/control.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <variant>

#include "adapter/event_json.hpp"
#include "adapter/flash_file.hpp"
#include "adapter/network_json.hpp"
#include "adapter/status_lights.hpp"
#include "drive/ds402.hpp"

namespace servobus::adapter {
namespace {

// The order in which the members are written is the one in which people read them.
using Answer = nlohmann::ordered_json;
using nlohmann::json;

enum class Query : std::uint8_t { state, axis, connections, counters, lights, firmware, network };
constexpr std::array<std::pair<std::string_view, Query>, 7> queries{{{"state", Query::state},
                                                                     {"axis", Query::axis},
                                                                     {"connections", Query::connections},
                                                                     {"counters", Query::counters},
                                                                     {"lights", Query::lights},
                                                                     {"firmware", Query::firmware},
                                                                     {"network", Query::network}}};

enum class Command : std::uint8_t { stop, download };
constexpr std::array<std::pair<std::string_view, Command>, 2> commands{
    {{"stop", Command::stop}, {"download", Command::download}}};

// Where the table has what {"query": "state"} tells.
constexpr drive::Key status_word{0x66, 0x01};
constexpr drive::Key error_number{0x64, 0x04};
struct Told {
    const char* name;
    drive::Key key;
};
constexpr auto told = std::to_array<Told>({
    {"mode", {0x66, 0x21}},        // ModesOfOperationDisplayed
    {"position", {0x66, 0x24}},    // TP, increments
    {"velocity", {0x65, 0x1D}},    // TV, increments/s
    {"current", {0x66, 0x38}},     // TMC, mA
    {"error", error_number},       // TE
    {"error_text", {0x69, 0x01}},  // TES
    {"inputs", {0x65, 0x07}},      // TIX
    {"outputs", {0x65, 0x06}},     // TOX
});

std::string_view word(drive::OutputLevel level) {
    switch (level) {
        case drive::OutputLevel::open:
            return "open";
        case drive::OutputLevel::low:
            return "low";
        case drive::OutputLevel::high:
            return "high";
    }
    return "open";
}

// Output 1 first.
Answer output_wires(const drive::Device& device) {
    auto wires = Answer::array();
    for (int number = 1; number <= drive::digital_outputs; ++number) wires.push_back(word(device.output_wire(number)));
    return wires;
}

std::string text_of(const Answer& answer) { return answer.dump(-1, ' ', false, Answer::error_handler_t::replace); }

std::string refusal(const FileError& error) {
    return control_error(error.column == 0 ? error.reason : fmt::format("column {}: {}", error.column, error.reason));
}

Answer value_of(const drive::Device& device, drive::Key key) {
    const auto* row = device.find(key);
    if (row == nullptr) return nullptr;
    const auto& value = device.store().value(*row);
    if (const auto* number = std::get_if<std::int64_t>(&value)) return *number;
    return std::get<std::string>(value);
}

// The power stage is on in these (004 §4.1); in a fault reaction it still brakes.
bool is_powered(drive::Ds402::State state) {
    using State = drive::Ds402::State;
    return state == State::switched_on || state == State::operation_enabled || state == State::quick_stop_active ||
           state == State::fault_reaction_active;
}

Answer state_of(const Adapter& adapter, enip::Time now) {
    const auto& device = adapter.device();
    Answer answer{{"ok", true}, {"time", std::chrono::duration<double>(adapter.elapsed(now)).count()}};
    if (const auto word = value_of(device, status_word); word.is_number()) {
        const auto bits = static_cast<std::uint16_t>(word.get<std::int64_t>());
        const auto state = drive::Ds402::state_of(bits);
        answer["statusword"] = bits;
        answer["state"] = state ? Answer(drive::Ds402::name(*state)) : Answer(nullptr);
        answer["power"] = state && is_powered(*state);
    }
    for (const auto& [name, key] : told) answer[name] = value_of(device, key);
    answer["output_wires"] = output_wires(device);
    return answer;
}

Answer describe_axis(const drive::AxisKind& axis) {
    Answer answer{{"ok", true},
                  {"key", axis.key},
                  {"name", axis.name},
                  {"motion", axis.motion == drive::AxisKind::Motion::linear ? "linear" : "rotative"},
                  {"increments_per_unit", axis.increments_per_unit},
                  {"travel", axis.travel}};
    if (axis.has_stops) {
        answer["stop_negative"] = axis.stop_negative;
        answer["stop_positive"] = axis.stop_positive;
    }
    return answer;
}

std::string_view name_of(enip::Trigger trigger) {
    switch (trigger) {
        case enip::Trigger::cyclic:
            return "cyclic";
        case enip::Trigger::change_of_state:
            return "change of state";
        case enip::Trigger::application:
            return "application";
    }
    return "";
}

std::string_view state_of(const enip::IoConsumer& consumer) {
    if (!consumer.alive()) return "waiting";
    return consumer.run() ? "run" : "idle";
}

Answer members_of(const IoConnection& connection) {
    const auto& consumer = connection.consumer;
    const auto& producer = connection.production->producer;
    const auto& triad = connection.request.triad;
    return {{"number", connection.number},
            {"kind", assemblies::name(connection.kind->kind)},
            {"o_to_t_point", connection.kind->o_to_t_point},
            {"t_to_o_point", connection.kind->t_to_o_point},
            {"originator", enip::to_string(connection.originator)},
            {"vendor", triad.originator_vendor},
            {"originator_serial", triad.originator_serial},
            {"serial", triad.serial_number},
            {"o_to_t_id", connection.o_to_t_id},
            {"t_to_o_id", connection.t_to_o_id},
            {"state", state_of(consumer)},
            {"run", consumer.run()},
            {"trigger", name_of(producer.settings().trigger)},
            {"multicast", connection.production->multicast},
            {"destination", enip::to_string(producer.settings().route.peer)},
            {"o_to_t_interval_us", connection.request.o_to_t_rpi},
            {"t_to_o_interval_us", producer.settings().interval.count()},
            {"timeout_us", consumer.settings().timeout.count()},
            {"received", consumer.counters().accepted},
            {"lost", consumer.counters().lost},
            {"stale", consumer.counters().stale},
            {"wrong_size", consumer.counters().wrong_size},
            {"sent", producer.counters().sent},
            {"skipped", producer.counters().skipped}};
}

Answer connections_of(const Adapter& adapter) {
    auto list = Answer::array();
    for (const auto& connection : adapter.io().all()) list.push_back(members_of(*connection));
    return {{"ok", true}, {"connections", std::move(list)}};
}

Answer members_of(const NetworkFaults::Counters& counters) {
    return {{"dropped", counters.dropped},     {"delayed", counters.delayed},       {"duplicated", counters.duplicated},
            {"reordered", counters.reordered}, {"overflowed", counters.overflowed}, {"silenced", counters.silenced}};
}

Answer counters_of(const Adapter& adapter) {
    const auto count = [&](Counter which) { return adapter.connection_manager().counter(which); };
    const auto& strays = adapter.io().strays();
    const auto& faults = adapter.faults();
    auto sessions = Answer::array();
    for (const auto& [handle, peer] : adapter.open_sessions()) {
        sessions.push_back({{"session", handle}, {"peer", enip::to_string(peer)}});
    }
    return {
        {"ok", true},
        {"tcp_connections", adapter.tcp_connections()},
        {"sessions", std::move(sessions)},
        {"class3_connections", adapter.class3_connections()},
        {"io_connections", adapter.io().size()},
        {"open_requests", count(Counter::open_requests)},
        {"open_format_rejects", count(Counter::open_format_rejects)},
        {"open_resource_rejects", count(Counter::open_resource_rejects)},
        {"open_other_rejects", count(Counter::open_other_rejects)},
        {"close_requests", count(Counter::close_requests)},
        {"close_format_rejects", count(Counter::close_format_rejects)},
        {"close_other_rejects", count(Counter::close_other_rejects)},
        {"connection_timeouts", count(Counter::connection_timeouts)},
        {"stray_datagrams",
         {{"malformed", strays.malformed}, {"unknown_id", strays.unknown_id}, {"wrong_source", strays.wrong_source}}},
        {"strangers",
         {{"connections", adapter.strangers().connections},
          {"requests", adapter.strangers().requests},
          {"datagrams", adapter.strangers().datagrams}}},
        {"faults",
         {{"active", faults.active()},
          {"o_to_t", members_of(faults.in())},
          {"t_to_o", members_of(faults.out())},
          {"replies_delayed", faults.replies().delayed},
          {"replies_withheld", faults.replies().withheld},
          {"opens_refused", faults.replies().opens_refused}}}};
}

Answer lights_of(const Adapter& adapter, enip::Time now) {
    Answer answer{{"ok", true}};
    const auto lights = adapter.lights();
    for (std::size_t i = 0; i < lights.size(); ++i) {
        answer[std::string(light_names[i])] = {{"mode", name(lights[i].mode)},
                                               {"lit", is_lit(lights[i].mode, adapter.elapsed(now))},
                                               {"meaning", lights[i].meaning}};
    }
    return answer;
}

Answer members_of(const FirmwareUnit::Release& release) {
    return {{"version", to_string(release.version)},
            {"revision", fmt::format("{}.{}", release.revision.major, release.revision.minor)}};
}

Answer firmware_of(const Adapter& adapter) {
    const auto& firmware = adapter.firmware();
    const auto& installed = firmware.running();
    const auto pending = firmware.pending();
    Answer answer{{"ok", true},
                  {"mode", firmware.is_in_factory_mode() ? "factory" : "application"},
                  {"installed", installed ? members_of(*installed) : Answer(nullptr)},
                  {"pending", pending ? members_of(*pending) : Answer(nullptr)},
                  {"download", nullptr}};
    if (const auto download = firmware.download_in_progress()) {
        answer["download"] = members_of(download->release);
        answer["download"]["written"] = download->written;
        answer["download"]["octets"] = download->octets;
    }
    return answer;
}

Answer network_of(Adapter& adapter) {
    Answer answer{{"ok", true}};
    answer.update(describe_network(adapter.network()));
    return answer;
}

std::string tell(Adapter& adapter, Query query, const drive::AxisKind& axis, enip::Time now) {
    adapter.advance(now);
    switch (query) {
        case Query::state:
            return text_of(state_of(adapter, now));
        case Query::axis:
            return text_of(describe_axis(axis));
        case Query::connections:
            return text_of(connections_of(adapter));
        case Query::counters:
            return text_of(counters_of(adapter));
        case Query::lights:
            return text_of(lights_of(adapter, now));
        case Query::firmware:
            return text_of(firmware_of(adapter));
        case Query::network:
            return text_of(network_of(adapter));
    }
    return {};
}

std::string happen(Adapter& adapter, const Happening& event, enip::Time now) {
    if (std::holds_alternative<drive::Event>(event) && !adapter.device().has_machine()) {
        return control_error("this drive has no machine that anything could happen to");
    }
    if (!adapter.inject(event, now)) {
        return control_error(fmt::format("there are {} network faults already", NetworkFaults::max_active));
    }
    return text_of({{"ok", true}});
}

std::string download(Adapter& adapter, const std::string& file, enip::Time now) {
    const auto image = load_flash(file);
    if (const auto* reason = std::get_if<std::string>(&image)) return control_error(*reason);
    if (const auto reason = adapter.download(std::get<FlashImage>(image), now)) {
        return control_error(fmt::format("{}: {}", file, *reason));
    }
    return text_of({{"ok", true}});
}

}  // namespace

std::string control_error(std::string_view reason) { return text_of({{"ok", false}, {"error", reason}}); }

std::vector<std::pair<std::string_view, Adapter*>> Control::names() const {
    std::vector<std::pair<std::string_view, Adapter*>> pairs;
    for (const auto& drive : drives_) pairs.emplace_back(drive.address, drive.adapter);
    return pairs;
}

// Each command has members of its own.
std::string Control::obey(const JsonDocument& document, enip::Time now) {
    const Walk walk(document);
    auto command = Command::stop;
    const auto is_command = one_of(command, commands);
    if (const auto reason = is_command(document.root["command"]); !reason.empty()) {
        return refusal(walk.error("", "command", reason));
    }
    Setters setters{{"command", is_command}};
    if (command == Command::stop) {
        if (const auto error = walk.object(document.root, "", setters)) return refusal(*error);
        if (!stop_) return control_error("nothing here can be stopped");
        stop_();
        return text_of({{"ok", true}});
    }
    const auto drives = names();
    auto* adapter = drives.front().second;
    std::string file;
    setters.emplace("drive", one_of(adapter, drives));
    setters.emplace("file", text(file));
    if (const auto error = walk.object(document.root, "", setters, {"file"})) return refusal(*error);
    return download(*adapter, file, now);
}

std::string Control::answer(std::string_view line, enip::Time now) {
    auto parsed = parse_settings(std::string(line), "line");
    if (const auto* error = std::get_if<FileError>(&parsed)) return refusal(*error);
    const auto& document = std::get<JsonDocument>(parsed);
    const Walk walk(document);
    const auto drives = names();
    auto* adapter = drives.front().second;
    const auto which_drive = one_of(adapter, drives);
    if (document.root.contains("query")) {
        auto query = Query::state;
        if (const auto error =
                walk.object(document.root, "", {{"query", one_of(query, queries)}, {"drive", which_drive}})) {
            return refusal(*error);
        }
        return tell(*adapter, query, axis_, now);
    }
    if (document.root.contains("command")) {
        return obey(document, now);
    }
    const auto event = read_event(document, "", document.root, {.setters = {{"drive", which_drive}}});
    if (const auto* error = std::get_if<FileError>(&event)) return refusal(*error);
    return happen(*adapter, std::get<Happening>(event), now);
}

}  // namespace servobus::adapter
