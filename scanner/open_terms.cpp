#include "scanner/open_terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "cip/hex.hpp"
#include "enip/io_stream.hpp"
#include "scanner/io_words.hpp"

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;

constexpr auto header = static_cast<long>(cip::run_idle_octets);
constexpr auto count = static_cast<long>(cip::sequence_count_octets);

std::string_view type_text(cip::ConnectionType type) {
    switch (type) {
        case cip::ConnectionType::null:
            return "null";
        case cip::ConnectionType::multicast:
            return "multicast";
        case cip::ConnectionType::point_to_point:
            return "point-to-point";
        case cip::ConnectionType::reserved:
            return "the reserved type 3";
    }
    return "";
}

std::string_view trigger_text(std::uint8_t trigger) {
    constexpr std::string_view names[] = {"cyclic", "change of state", "application triggered"};
    return trigger < std::size(names) ? names[trigger] : "with a reserved trigger";
}

std::string direction_text(std::string_view name, std::optional<std::uint32_t> point,
                           const cip::ConnectionParameters& parameters, std::uint32_t rpi) {
    auto text = fmt::format("{}: ", name);
    if (point) text += fmt::format("point {}, ", *point);
    text += fmt::format("size {}, {}, {}, {} priority, every {}", parameters.size,
                        parameters.variable ? "variable" : "fixed", type_text(parameters.type),
                        word_of(priority_words, parameters.priority), duration_text(std::chrono::microseconds(rpi)));
    if (parameters.redundant_owner) text += ", redundant owner";
    return text;
}

std::string transport_text(const cip::ForwardOpen& request) {
    const auto& transport = request.transport;
    auto text = fmt::format("{}, class {}, {}", request.large ? "Large_Forward_Open" : "Forward_Open",
                            transport.transport_class, trigger_text(transport.trigger));
    if (transport.server) text += ", direction bit set";
    if (request.timeout_multiplier > 7) {
        return text + fmt::format("; timeout multiplier code {}, which is none", request.timeout_multiplier);
    }
    return text + fmt::format("; timeout after {} intervals", 4 << request.timeout_multiplier);
}

}  // namespace

std::string duration_text(std::chrono::nanoseconds time) {
    const auto ns = static_cast<double>(time.count());
    if (time >= 10s || time <= -10s) return fmt::format("{:.4g} s", ns / 1e9);
    if (time >= 1s && time.count() % 1'000'000'000 == 0) return fmt::format("{:.0f} s", ns / 1e9);
    if (time >= 1s) return fmt::format("{:.6g} ms", ns / 1e6);
    return fmt::format("{:.5g} ms", ns / 1e6);
}

std::vector<std::string> asked_text(const cip::ForwardOpen& request, const ConnectionPath& path) {
    std::vector<std::string> lines{direction_text("O->T", path.o_to_t(), request.o_to_t, request.o_to_t_rpi),
                                   direction_text("T->O", path.t_to_o(), request.t_to_o, request.t_to_o_rpi),
                                   transport_text(request)};
    const auto parsed = cip::Path::parse(request.path);
    lines.push_back(fmt::format("path: {}", parsed ? cip::describe(*parsed) : cip::to_hex(request.path)));
    return lines;
}

std::string size_parts(const assemblies::Connection& connection, bool o_to_t) {
    const auto* layout = o_to_t ? connection.outputs() : connection.inputs();
    const auto format = o_to_t ? connection.o_to_t_format() : connection.t_to_o_format();
    std::string text;
    if (layout != nullptr) text = fmt::format("{} of assembly {} + ", layout->size(), layout->instance);
    if (format == cip::RealTimeFormat::header32) text += "4 run/idle header + ";
    text += "2 sequence count";
    return layout != nullptr ? text : text + " and no data: a heartbeat";
}

std::vector<std::string> size_causes(const SizeMistake& mistake) {
    std::vector<std::string> causes;
    const auto difference = static_cast<long>(mistake.asked) - static_cast<long>(mistake.expected);
    const auto* name = mistake.o_to_t ? "O->T" : "T->O";
    // Where nobody has said whether there is a header, its 4 octets are only the likely reading.
    const bool with = mistake.header.value_or(mistake.o_to_t);
    const auto* surely = mistake.header ? "" : "probably ";
    if (mistake.opposite && mistake.asked == *mistake.opposite) {
        causes.push_back(
            fmt::format("{} is the size of the other direction: the two sizes are exchanged.", mistake.asked));
    }
    if (difference == -header && with) {
        causes.push_back(
            fmt::format("You {}left out the 4 octets of the run/idle header, which {} has.", surely, name));
    } else if (difference == -count) {
        causes.emplace_back("You forgot the 2 octets of the sequence count of class 1.");
    } else if (difference == -header - count && with) {
        causes.push_back(
            fmt::format("You {}gave the size of the data alone; the connection size also counts 4 octets of run/idle "
                        "header and 2 of "
                        "sequence count.",
                        surely));
    } else if (difference == header && !with) {
        causes.push_back(
            fmt::format("You {}counted the 4 octets of the run/idle header on the wrong side: {} has none{}.", surely,
                        name, mistake.header ? "" : " on most devices"));
    } else if (difference == header && with) {
        causes.push_back(fmt::format(
            "You {}counted the 4 octets of the run/idle header twice, or {} has none at this device.", surely, name));
    } else if (difference == count) {
        causes.emplace_back(
            "You counted the 2 octets of the sequence count twice: a tool that adds them was given a size that has "
            "them.");
    } else if (difference == header + count) {
        causes.emplace_back(
            "You counted run/idle header and sequence count twice: a tool that adds them was given a size that has "
            "them.");
    }
    if (causes.empty()) {
        causes.push_back(fmt::format(
            "A difference of {} octets is neither header (4) nor sequence count (2): the data itself has another size, "
            "as of another point or another configuration of the device.",
            difference < 0 ? -difference : difference));
    }
    return causes;
}

std::chrono::microseconds target_patience(const cip::ForwardOpen& request) {
    return enip::connection_timeout(std::chrono::microseconds(request.o_to_t_rpi),
                                    std::min<std::uint8_t>(request.timeout_multiplier, 7));
}

}  // namespace servobus::scanner
