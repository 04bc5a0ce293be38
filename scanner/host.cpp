#include "scanner/host.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace servobus::scanner {
namespace {

constexpr std::size_t max_host_name = 253;
constexpr std::size_t max_link_address = 63;

std::optional<unsigned> decimal(std::string_view text, unsigned highest) {
    unsigned number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{} || end != text.data() + text.size() || number > highest) return std::nullopt;
    return number;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_name_character(char c) { return is_digit(c) || is_letter(c) || c == '.' || c == '-' || c == '_'; }
bool is_v6_character(char c) { return is_digit(c) || is_letter(c) || c == ':' || c == '.' || c == '%'; }

/// Four numbers of 0 to 255 with dots between them.
bool is_v4_address(std::string_view text) {
    for (int part = 0; part < 4; ++part) {
        const auto dot = part < 3 ? text.find('.') : text.size();
        if (dot == std::string_view::npos || !decimal(text.substr(0, dot), 255)) return false;
        text.remove_prefix(part < 3 ? dot + 1 : dot);
    }
    return true;
}

bool looks_like_v4_address(std::string_view text) {
    return std::ranges::all_of(text, [](char c) { return is_digit(c) || c == '.'; });
}

Mistake bad_host(std::string_view text, std::string_view why) {
    return {fmt::format("'{}' is no HOST: {}", text, why)};
}

/// Takes the port, if there is one, off the end of `text`.
Parsed<std::uint16_t> take_port(std::string_view& text, std::string_view whole) {
    const auto colon = text.rfind(':');
    if (colon == std::string_view::npos) return enip::tcp_port;
    const auto port = decimal(text.substr(colon + 1), 0xFFFF);
    if (!port || *port == 0) return bad_host(whole, "the port behind the colon is a number from 1 to 65535");
    text = text.substr(0, colon);
    return static_cast<std::uint16_t>(*port);
}

Parsed<Host> parse_v6_host(std::string_view text) {
    const auto bracket = text.find(']');
    if (bracket == std::string_view::npos) return bad_host(text, "the bracket is not closed");
    auto rest = text.substr(bracket + 1);
    const auto name = text.substr(1, bracket - 1);
    const auto port = take_port(rest, text);
    if (!port) return port.error();
    if (!rest.empty() || name.empty() || !std::ranges::all_of(name, is_v6_character)) {
        return bad_host(text, "write [ADDRESS] or [ADDRESS]:PORT");
    }
    return Host{std::string(name), *port};
}

Mistake bad_route(std::string_view hop, std::string_view why) {
    return {fmt::format("'{}' is no hop of a route: {}", hop, why)};
}

Parsed<cip::PortSegment> parse_hop(std::string_view hop) {
    const auto slash = hop.find('/');
    if (slash == std::string_view::npos) return bad_route(hop, "write PORT/LINK, for example 1/0");
    const auto port = decimal(hop.substr(0, slash), 0xFFFF);
    if (!port || *port == 0) return bad_route(hop, "the port is a number from 1 to 65535");
    const auto link = hop.substr(slash + 1);
    cip::PortSegment segment{static_cast<std::uint16_t>(*port), {}};
    if (const auto number = decimal(link, 0xFF)) {
        segment.link_address.push_back(static_cast<std::uint8_t>(*number));
        return segment;
    }
    const bool is_address =
        looks_like_v4_address(link) ? is_v4_address(link) : std::ranges::all_of(link, is_name_character);
    // One character would read as a number on the wire.
    if (!is_address || link.size() < 2 || link.size() > max_link_address) {
        return bad_route(hop, "the link is a number from 0 to 255, or an address");
    }
    segment.link_address.assign(link.begin(), link.end());
    return segment;
}

}  // namespace

Parsed<Host> parse_host(std::string_view text) {
    if (text.starts_with('[')) return parse_v6_host(text);
    if (std::ranges::count(text, ':') > 1) {
        if (!std::ranges::all_of(text, is_v6_character)) return bad_host(text, "it has more than one colon");
        return Host{std::string(text)};
    }
    auto name = text;
    const auto port = take_port(name, text);
    if (!port) return port.error();
    if (name.empty()) return bad_host(text, "there is no name or address");
    if (name.size() > max_host_name) return bad_host(text, "it is too long");
    if (looks_like_v4_address(name) && !is_v4_address(name)) {
        return bad_host(text, "an address has four numbers from 0 to 255, like 192.168.2.100");
    }
    if (!std::ranges::all_of(name, is_name_character)) {
        return bad_host(text, "a name has letters, digits, dots and hyphens only");
    }
    return Host{std::string(name), *port};
}

std::string to_string(const Host& host) {
    const bool is_v6 = host.name.find(':') != std::string::npos;
    if (host.port == enip::tcp_port) return host.name;
    return fmt::format("{}{}{}:{}", is_v6 ? "[" : "", host.name, is_v6 ? "]" : "", host.port);
}

Parsed<cip::Path> parse_route(std::string_view text) {
    cip::Path route;
    for (;;) {
        const auto comma = text.find(',');
        const auto hop = parse_hop(text.substr(0, comma));
        if (!hop) return hop.error();
        route.segments.emplace_back(*hop);
        if (comma == std::string_view::npos) break;
        text.remove_prefix(comma + 1);
    }
    if (route.words() > cip::max_path_words) return Mistake{"the route is too long"};
    return route;
}

}  // namespace servobus::scanner
