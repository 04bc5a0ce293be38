#include "adapter/access_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "adapter/attribute_names.hpp"
#include "cip/hex.hpp"
#include "cip/path.hpp"
#include "cip/services.hpp"
#include "enip/endpoint.hpp"

namespace servobus::adapter {
namespace {

constexpr std::chrono::seconds window_length{1};

struct KindRow {
    std::string_view name;
    LogLevel level;
};
// By Kind. The log has other lines about connections, which say more than the status does.
constexpr std::array<KindRow, 4> kinds{{{"change", LogLevel::info},
                                        {"connection", LogLevel::debug},
                                        {"refusal", LogLevel::warning},
                                        {"stranger", LogLevel::warning}}};

const KindRow& row_of(AccessLog::Kind kind) { return kinds[static_cast<std::size_t>(kind)]; }

std::string way_of(const cip::Origin& origin) {
    return fmt::format("{}{}{}", origin.via == cip::Origin::Via::connected ? "class 3" : "unconnected",
                       origin.is_routed ? ", Unconnected_Send" : "", origin.is_part ? ", Multiple_Service_Packet" : "");
}

std::string service_of(const cip::Access& access) {
    const auto code = access.request.service;
    const auto known = cip::service::name(code, access.path != nullptr ? access.path->class_id : 0);
    return known.empty() ? fmt::format("0x{:02X}", code) : std::string(known);
}

// With the attribute that is meant, where the path leaves it to the object or to the list.
std::string path_of(const cip::Access& access) {
    if (access.path == nullptr)
        return cip::to_hex(access.request.path.first(std::min(access.request.path.size(), shown_octets)));
    const auto& path = *access.path;
    return cip::describe(access.attribute ? cip::Path::to(path.class_id, path.instance, *access.attribute)
                                          : cip::Path::to(path.class_id, path.instance));
}

std::string octets_of(cip::ByteView data) {
    auto text = cip::to_hex(data.first(std::min(data.size(), shown_octets)));
    if (data.size() > shown_octets) text += fmt::format(" ... ({} octets)", data.size());
    return text;
}

}  // namespace

LogLevel AccessLog::level_of(Kind kind) { return row_of(kind).level; }

void AccessLog::write(Kind kind, LogLine line) const {
    line.level = level_of(kind);
    sink_.take(line);
}

bool AccessLog::has_room(Kind kind, cip::Time now) {
    auto& current = window(kind);
    if (current.end && *current.end <= now) close(kind);
    if (!current.end) current.end = now + window_length;
    if (current.lines < access_lines_per_second) {
        ++current.lines;
        return true;
    }
    ++current.suppressed;
    return false;
}

void AccessLog::close(Kind kind) {
    const auto over = std::exchange(window(kind), {});
    if (over.suppressed == 0) return;
    write(kind, {.event = "access lines left out",
                 .values = {{"kind", std::string(row_of(kind).name)}, {"lines", std::to_string(over.suppressed)}}});
}

void AccessLog::on_timer(cip::Time now) {
    for (std::size_t i = 0; i < windows_.size(); ++i) {
        if (windows_[i].end && *windows_[i].end <= now) close(static_cast<Kind>(i));
    }
}

// A second in which nothing was left out ends without anybody's help.
std::optional<cip::Time> AccessLog::next_deadline() const {
    std::optional<cip::Time> next;
    for (const auto& each : windows_) {
        if (each.suppressed > 0 && (!next || *each.end < *next)) next = each.end;
    }
    return next;
}

void AccessLog::flush() {
    for (std::size_t i = 0; i < windows_.size(); ++i) close(static_cast<Kind>(i));
}

LogLine access_line(const cip::Access& access, const cip::Status& result, std::uint32_t session,
                    const drive::Device& device, std::string_view why) {
    LogLine line{.event = result.ok() ? "access granted" : "access refused"};
    const auto add = [&](const char* key, std::string value) { line.values.emplace_back(key, std::move(value)); };
    add("peer", enip::to_string({access.origin.address, access.origin.port}));
    if (session != 0) add("session", fmt::format("0x{:08X}", session));
    add("via", way_of(access.origin));
    add("service", service_of(access));
    add("path", path_of(access));
    if (access.path != nullptr && access.attribute) {
        auto name = attribute_name(device, access.path->class_id, *access.attribute);
        if (!name.empty()) add("name", std::move(name));
    }
    if (!access.data.empty()) add("value", octets_of(access.data));
    add("result", cip::describe(result));
    if (!why.empty()) add("why", std::string(why));
    return line;
}

}  // namespace servobus::adapter
