#include "adapter/start_address.hpp"

#include <arpa/inet.h>

#include <array>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include "adapter/usable_address.hpp"

namespace servobus::adapter {
namespace {

using nlohmann::json;

constexpr std::array<std::pair<std::string_view, AddressMethod>, 3> methods{{
    {"stored", AddressMethod::stored},
    {"bootp", AddressMethod::bootp},
    {"dhcp", AddressMethod::dhcp},
}};

std::optional<std::uint32_t> address_of(const std::string& text) {
    in_addr address{};
    if (::inet_pton(AF_INET, text.c_str(), &address) != 1) return std::nullopt;
    return ntohl(address.s_addr);
}

std::optional<std::uint32_t> mask_of(std::string_view prefix) {
    unsigned length = 0;
    const auto [end, error] = std::from_chars(prefix.data(), prefix.data() + prefix.size(), length);
    if (error != std::errc() || end != prefix.data() + prefix.size() || length < 1 || length > 32) return std::nullopt;
    return 0xFFFFFFFFU << (32 - length);
}

Setter subnet_address(InterfaceConfiguration& target) {
    return [&target](const json& value) -> Reason {
        const auto text = value.is_string() ? value.get<std::string>() : std::string();
        const auto slash = text.find('/');
        const auto address = address_of(text.substr(0, slash));
        const auto mask = slash == std::string::npos ? std::nullopt : mask_of(std::string_view(text).substr(slash + 1));
        if (!address || !mask) return "must be an address in its subnet, such as \"192.168.2.100/24\"";
        target.address = *address;
        target.mask = *mask;
        return {};
    };
}

Setter gateway_address(InterfaceConfiguration& target) {
    return [&target](const json& value) -> Reason {
        const auto address = address_of(value.is_string() ? value.get<std::string>() : std::string());
        if (!address) return "must be an address, such as \"192.168.2.1\"";
        target.gateway = *address;
        return {};
    };
}

}  // namespace

std::optional<FileError> read_network(const Walk& walk, const json& value, const std::string& pointer,
                                      NetworkSettings& settings) {
    std::optional<AddressMethod> method;
    AddressMethod word{};
    auto& configured = settings.configured;
    const auto chosen = one_of(word, methods);
    const Setters setters{
        {"method",
         [&](const json& member) -> Reason {
             auto reason = chosen(member);
             if (reason.empty()) method = word;
             return reason;
         }},
        {"address", subnet_address(configured)},
        {"gateway", gateway_address(configured)},
        {"acd", flag(settings.select_acd)},
    };
    if (auto error = walk.object(value, pointer, setters)) return error;
    const bool has_address = value.contains("address");
    if (has_address && !is_usable(configured)) {
        return walk.error(pointer, "address", "is none that a host can have, or its gateway is in another subnet");
    }
    if (!has_address && value.contains("gateway")) return walk.error(pointer, "gateway", "needs an address beside it");
    settings.method = method.value_or(has_address ? AddressMethod::stored : settings.method);
    return std::nullopt;
}

}  // namespace servobus::adapter
