#include "adapter/network_json.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "adapter/usable_address.hpp"
#include "cip/hex.hpp"
#include "enip/endpoint.hpp"

namespace servobus::adapter {
namespace {

using Json = nlohmann::ordered_json;

std::string_view name_of(AddressMethod method) {
    switch (method) {
        case AddressMethod::stored:
            return "stored";
        case AddressMethod::bootp:
            return "bootp";
        case AddressMethod::dhcp:
            return "dhcp";
    }
    return "";
}

Json address_or_null(std::uint32_t address) { return address != 0 ? Json(enip::address_text(address)) : Json(nullptr); }

// The parts of attribute 11 (R-TCP-10).
Json describe(const LastConflict& conflict) {
    constexpr std::array<std::string_view, 4> activities{"none", "probing", "ongoing detection", "semi-active probing"};
    MacAddress mac{};
    std::copy_n(conflict.begin() + 1, mac.size(), mac.begin());
    const auto arp = cip::ByteView(conflict).subspan(1 + mac.size());
    if (conflict[0] == 0 || conflict[0] >= activities.size()) return nullptr;
    return {{"activity", activities[conflict[0]]}, {"mac", to_string(mac)}, {"arp", cip::to_hex(arp)}};
}

}  // namespace

Json describe_network(const Network& network) {
    const auto& state = network.state;
    const auto& place = state.place();
    return {{"method", name_of(network.settings.method)},
            {"address", address_or_null(place.address)},
            {"prefix", prefix_length(place.mask)},
            {"gateway", address_or_null(place.gateway)},
            {"mac", to_string(state.mac)},
            {"configured", state.address.configured},
            {"pending", state.address.pending},
            {"conflict", state.address.conflict},
            {"without_address", state.address.without_address},
            {"last_conflict", describe(network.settings.last_conflict)},
            {"ring",
             {{"topology", state.ring.topology},
              {"status", state.ring.status},
              {"supervisor", address_or_null(state.ring.supervisor_address)},
              {"supervisor_mac", to_string(state.ring.supervisor_mac)}}}};
}

}  // namespace servobus::adapter
