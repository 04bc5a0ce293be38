#include "adapter/allow_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "enip/endpoint.hpp"

namespace servobus::adapter {
namespace {

// Takes a decimal number of at most `largest` from the front; no sign, no leading zero.
std::optional<std::uint32_t> take_number(std::string_view& text, std::uint32_t largest) {
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const auto digits = static_cast<std::size_t>(end - text.data());
    if (error != std::errc() || number > largest || (digits > 1 && text.front() == '0')) return std::nullopt;
    text.remove_prefix(digits);
    return number;
}

std::optional<std::uint32_t> take_address(std::string_view& text) {
    std::uint32_t address = 0;
    for (int octet = 0; octet < 4; ++octet) {
        if (octet > 0) {
            if (!text.starts_with('.')) return std::nullopt;
            text.remove_prefix(1);
        }
        const auto number = take_number(text, 255);
        if (!number) return std::nullopt;
        address = address << 8 | *number;
    }
    return address;
}

}  // namespace

std::variant<AllowList::Network, std::string> AllowList::parse(std::string_view text) {
    constexpr std::uint32_t all_bits = 32;
    auto rest = text;
    const auto address = take_address(rest);
    auto bits = std::optional(all_bits);
    if (address && rest.starts_with('/')) {
        rest.remove_prefix(1);
        bits = take_number(rest, all_bits);
    }
    if (!address || !bits || !rest.empty()) {
        return fmt::format("'{}' is no IPv4 network; write it as 192.168.2.0/24 or 192.168.2.7", text);
    }
    const std::uint32_t mask = *bits == 0 ? 0 : ~std::uint32_t{0} << (all_bits - *bits);
    if ((*address & ~mask) != 0) {
        return fmt::format("'{}' has host bits; the network is {}/{}", text, enip::address_text(*address & mask),
                           *bits);
    }
    return Network{*address, mask};
}

bool AllowList::permits(std::uint32_t address) const {
    return networks_.empty() || std::ranges::any_of(networks_, [&](const Network& network) {
               return (address & network.mask) == network.address;
           });
}

}  // namespace servobus::adapter
