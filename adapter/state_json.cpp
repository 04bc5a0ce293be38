#include "adapter/state_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <concepts>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

namespace servobus::adapter {
namespace {

using nlohmann::json;

/// Why a value is not taken; empty: taken.
using Reason = std::string;

/// A member of the settings by its name in the file.
template <class T>
struct Field {
    const char* name;
    T& value;
};
template <class T>
Field(const char*, T&) -> Field<T>;

template <class T, class Struct>
concept ConstOrNot = std::same_as<std::remove_const_t<T>, Struct>;

// A new member of the settings is a name and a line here; the compiler counts them.

template <ConstOrNot<InterfaceConfiguration> T>
auto fields(T& interface) {
    auto& [address, mask, gateway, name_server_1, name_server_2, domain] = interface;
    return std::tuple{Field{"address", address},
                      Field{"mask", mask},
                      Field{"gateway", gateway},
                      Field{"name_server_1", name_server_1},
                      Field{"name_server_2", name_server_2},
                      Field{"domain", domain}};
}

template <ConstOrNot<QualityOfService> T>
auto fields(T& qos) {
    auto& [tag_enable, dscp, ptp_dscp] = qos;
    return std::tuple{Field{"tag_enable", tag_enable}, Field{"dscp", dscp}, Field{"ptp_dscp", ptp_dscp}};
}

template <ConstOrNot<TimeSyncSettings> T>
auto fields(T& time_sync) {
    auto& [enabled, max_offset_from_master] = time_sync;
    return std::tuple{Field{"enabled", enabled}, Field{"max_offset_from_master", max_offset_from_master}};
}

template <ConstOrNot<NetworkSettings::LinkControl> T>
auto fields(T& link) {
    auto& [bits, forced_speed] = link;
    return std::tuple{Field{"bits", bits}, Field{"forced_speed", forced_speed}};
}

template <ConstOrNot<MulticastAllocation> T>
auto fields(T& multicast) {
    auto& [chosen, count, start] = multicast;
    return std::tuple{Field{"chosen", chosen}, Field{"count", count}, Field{"start", start}};
}

template <ConstOrNot<NetworkSettings> T>
auto fields(T& settings) {
    auto& [method, configured, host_name, ttl, multicast, select_acd, last_conflict, inactivity_seconds, links, qos,
           time_sync] = settings;
    return std::tuple{Field{"method", method},
                      Field{"configured", configured},
                      Field{"host_name", host_name},
                      Field{"ttl", ttl},
                      Field{"multicast", multicast},
                      Field{"select_acd", select_acd},
                      Field{"last_conflict", last_conflict},
                      Field{"inactivity_seconds", inactivity_seconds},
                      Field{"links", links},
                      Field{"qos", qos},
                      Field{"time_sync", time_sync}};
}

template <ConstOrNot<FirmwareVersion> T>
auto fields(T& version) {
    auto& [major, minor] = version;
    return std::tuple{Field{"major", major}, Field{"minor", minor}};
}

template <ConstOrNot<Revision> T>
auto fields(T& revision) {
    auto& [major, minor] = revision;
    return std::tuple{Field{"major", major}, Field{"minor", minor}};
}

template <ConstOrNot<FirmwareUnit::Release> T>
auto fields(T& release) {
    auto& [version, revision] = release;
    return std::tuple{Field{"version", version}, Field{"revision", revision}};
}

template <ConstOrNot<FirmwareUnit::Flash> T>
auto fields(T& flash) {
    auto& [release, bit_stream, firmware] = flash;
    return std::tuple{Field{"release", release}, Field{"bit_stream", bit_stream}, Field{"firmware", firmware}};
}

// The values of an enumeration.
constexpr std::array<AddressMethod, 3> values_of(AddressMethod) {
    return {AddressMethod::stored, AddressMethod::bootp, AddressMethod::dhcp};
}

template <class T>
concept HasFields = requires(T& value) {
    fields(value);
};
template <class T>
concept Enumeration = std::is_enum_v<T>;
template <class T>
concept WholeNumber = std::unsigned_integral<T> && !std::same_as<T, bool>;

// Characters of a device are octets, and those of JSON are not: each octet becomes the character of its number.
std::string to_characters(std::string_view octets) {
    std::string text;
    for (const char c : octets) {
        const auto octet = static_cast<unsigned char>(c);
        if (octet < 0x80) {
            text += c;
        } else {
            text += static_cast<char>(0xC0 | octet >> 6);
            text += static_cast<char>(0x80 | (octet & 0x3F));
        }
    }
    return text;
}

std::optional<std::string> to_octets(std::string_view text) {
    std::string octets;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto first = static_cast<unsigned char>(text[i]);
        if (first < 0x80) {
            octets += text[i];
            continue;
        }
        if ((first != 0xC2 && first != 0xC3) || ++i == text.size()) return std::nullopt;
        octets += static_cast<char>((first & 0x03) << 6 | (static_cast<unsigned char>(text[i]) & 0x3F));
    }
    return octets;
}

json encode(bool value) { return value; }
template <WholeNumber T>
json encode(T value) {
    return value;
}
template <Enumeration T>
json encode(T value) {
    return static_cast<std::underlying_type_t<T>>(value);
}
json encode(const std::string& value) { return to_characters(value); }
template <HasFields T>
json encode(const T& value);
template <class T, std::size_t Size>
json encode(const std::array<T, Size>& value) {
    auto list = json::array();
    for (const auto& each : value) list.push_back(encode(each));
    return list;
}
template <HasFields T>
json encode(const T& value) {
    auto object = json::object();
    std::apply([&](const auto&... field) { ((object[field.name] = encode(field.value)), ...); }, fields(value));
    return object;
}

Reason decode(const json& from, bool& to) {
    if (!from.is_boolean()) return "must be true or false";
    to = from.get<bool>();
    return {};
}
template <WholeNumber T>
Reason decode(const json& from, T& to) {
    if (!from.is_number_unsigned() || from.get<std::uint64_t>() > std::numeric_limits<T>::max()) {
        return fmt::format("must be a whole number from 0 to {}", std::numeric_limits<T>::max());
    }
    to = from.get<T>();
    return {};
}
template <Enumeration T>
Reason decode(const json& from, T& to) {
    std::underlying_type_t<T> number{};
    if (auto reason = decode(from, number); !reason.empty()) return reason;
    const auto known = values_of(T{});
    if (std::ranges::count(known, static_cast<T>(number)) == 0) return fmt::format("cannot be {}", number);
    to = static_cast<T>(number);
    return {};
}
Reason decode(const json& from, std::string& to) {
    auto octets = from.is_string() ? to_octets(from.get_ref<const std::string&>()) : std::nullopt;
    if (!octets) return "must be a text of characters up to 255";
    to = *std::move(octets);
    return {};
}
template <HasFields T>
Reason decode(const json& from, T& to);
template <class T, std::size_t Size>
Reason decode(const json& from, std::array<T, Size>& to) {
    if (!from.is_array() || from.size() != Size) return fmt::format("must be a list of {}", Size);
    for (std::size_t i = 0; i < Size; ++i) {
        if (auto reason = decode(from[i], to[i]); !reason.empty()) return fmt::format("[{}] {}", i, reason);
    }
    return {};
}
// What is not there stays as it is.
template <HasFields T>
Reason decode(const json& from, T& to) {
    if (!from.is_object()) return "must be an object";
    for (auto member = from.begin(); member != from.end(); ++member) {
        Reason reason = "is not known";
        const auto take = [&](auto field) {
            if (member.key() == field.name) reason = decode(member.value(), field.value);
        };
        std::apply([&](auto... field) { (take(field), ...); }, fields(to));
        if (!reason.empty()) return fmt::format("'{}' {}", member.key(), reason);
    }
    return {};
}

/// The members that differ.
json changes(const NetworkSettings& settings, const NetworkSettings& delivered) {
    auto object = encode(settings);
    const auto before = encode(delivered);
    for (auto member = object.begin(); member != object.end();) {
        member = member.value() == before[member.key()] ? object.erase(member) : std::next(member);
    }
    return object;
}

json encode(const drive::Value& value) {
    if (const auto* text = std::get_if<std::string>(&value)) return to_characters(*text);
    return std::get<std::int64_t>(value);
}

std::optional<drive::Value> value_of(const json& from) {
    if (from.is_number_unsigned() && from.get<std::uint64_t>() > std::uint64_t{INT64_MAX}) return std::nullopt;
    if (from.is_number_integer()) return from.get<std::int64_t>();
    if (!from.is_string()) return std::nullopt;
    auto octets = to_octets(from.get_ref<const std::string&>());
    return octets ? std::optional<drive::Value>(*std::move(octets)) : std::nullopt;
}

std::string address_of(drive::Key row) { return fmt::format("0x{:02X}/0x{:02X}", row.class_id, row.attribute); }

/// What the selector of a row is when it chooses its first element.
std::int64_t first_selected(const drive::Store& table, const drive::Parameter& row) {
    return table.find(*row.selected_by)->low;
}

json encode(const drive::StoredValues& values, const drive::Store& table) {
    auto object = json::object();
    for (const auto& stored : values) {
        const auto& row = *table.find(stored.row);
        auto& place = object[address_of(stored.row)];
        if (row.selected_by) {
            place[std::to_string(first_selected(table, row) + stored.element)] = encode(stored.value);
        } else {
            place = encode(stored.value);
        }
    }
    return object;
}

const drive::Parameter* find(const drive::Store& table, std::string_view address) {
    const auto found =
        std::ranges::find_if(table.table(), [&](const auto& row) { return address_of(row.key()) == address; });
    return found != table.table().end() ? &*found : nullptr;
}

Reason decode(const json& from, const drive::Parameter& row, std::uint16_t element, const drive::Device& device,
              drive::StoredValues& to) {
    auto value = value_of(from);
    if (!value) return "must be a whole number or a text";
    drive::StoredValue stored{row.key(), element, *std::move(value)};
    if (!device.fits(stored)) return "is nothing that this drive keeps, or out of its limits";
    to.push_back(std::move(stored));
    return {};
}

// A number that is none, or out of range, becomes an element that does not fit.
std::uint16_t element_of(const std::string& number, std::int64_t first) {
    std::int64_t value = -1;
    const auto* const end = number.data() + number.size();
    const bool whole = std::from_chars(number.data(), end, value).ptr == end;
    const bool fits = whole && value >= first && value - first < std::numeric_limits<std::uint16_t>::max();
    return fits ? static_cast<std::uint16_t>(value - first) : std::numeric_limits<std::uint16_t>::max();
}

Reason decode_elements(const json& from, const drive::Parameter& row, const drive::Device& device,
                       drive::StoredValues& to) {
    if (!from.is_object()) return "must be an object";
    for (const auto& [number, value] : from.items()) {
        const auto element = element_of(number, first_selected(device.store(), row));
        if (auto reason = decode(value, row, element, device, to); !reason.empty()) {
            return fmt::format("'{}' {}", number, reason);
        }
    }
    return {};
}

// In the order of the table afterwards, as the device tells them.
Reason decode(const json& from, const drive::Device& device, drive::StoredValues& to) {
    if (!from.is_object()) return "must be an object";
    for (const auto& [address, value] : from.items()) {
        const auto* row = find(device.store(), address);
        if (row == nullptr) return fmt::format("'{}' is no parameter", address);
        const auto reason =
            row->selected_by ? decode_elements(value, *row, device, to) : decode(value, *row, 0, device, to);
        if (!reason.empty()) return fmt::format("'{}' {}", address, reason);
    }
    std::ranges::sort(to, {}, [](const auto& each) { return std::pair(each.row, each.element); });
    return {};
}

}  // namespace

std::string state_text(const StoredState& state, const StoredState& delivered, const drive::Store& table) {
    json document{{"network", changes(state.network, delivered.network)},
                  {"parameters", encode(state.parameters, table)}};
    if (state.firmware != delivered.firmware) document["firmware"] = encode(state.firmware);
    return document.dump() + "\n";
}

std::variant<StoredState, std::string> parse_state(std::string_view text, const StoredState& delivered,
                                                   const drive::Device& device) {
    const auto document = json::parse(text, nullptr, false);
    if (!document.is_object()) return std::string("it is no JSON object");
    auto state = delivered;
    for (const auto& [name, value] : document.items()) {
        Reason reason = "is not known";
        if (name == "network") reason = decode(value, state.network);
        if (name == "firmware") reason = decode(value, state.firmware);
        if (name == "parameters") reason = decode(value, device, state.parameters);
        if (!reason.empty()) return fmt::format("'{}': {}", name, reason);
    }
    return state;
}

}  // namespace servobus::adapter
