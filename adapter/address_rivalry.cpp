#include "adapter/address_rivalry.hpp"

#include <algorithm>

#include "adapter/address_conflict.hpp"
#include "adapter/arp_packet.hpp"

namespace servobus::adapter {
namespace {

// As long as a defence counts, and as long as a lost address is left alone (R-ACD-3, R-ACD-4).
constexpr std::chrono::seconds dispute{10};

LastConflict conflict_with(const MacAddress& rival, std::uint32_t address) {
    const ArpPacket packet{.sender_mac = rival, .sender_address = address, .target_address = address};
    LastConflict conflict{};
    conflict[0] = static_cast<std::uint8_t>(ConflictActivity::ongoing_detection);
    const auto behind_mac = std::ranges::copy(rival, conflict.begin() + 1).out;
    std::ranges::copy(packet.encode(), behind_mac);
    return conflict;
}

}  // namespace

void AddressRivalry::restart() {
    detects_ = network_.settings.select_acd;
    over_.reset();  // the bits of attribute 1 go with the address settings, which are applied next
}

AddressRivalry::Outcome AddressRivalry::claim(const MacAddress& rival, enip::Time now) {
    auto& state = network_.state;
    if (!detects_ || state.interface.address == 0) return Outcome::unnoticed;
    network_.settings.last_conflict = conflict_with(rival, state.interface.address);
    state.address.conflict = true;
    const bool defends = !over_;
    over_ = now + dispute;
    if (defends) return Outcome::defended;
    state.address.configured = false;
    state.address.without_address = true;
    state.interface = {};
    return Outcome::lost;
}

void AddressRivalry::on_timer(enip::Time now) {
    if (!over_ || *over_ > now) return;
    over_.reset();
    network_.state.address.conflict = false;
    if (network_.state.address.without_address) apply_address_settings(network_);
}

}  // namespace servobus::adapter
