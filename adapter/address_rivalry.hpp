// A rival for the address of a drive whose address is the host's: what conflict detection would do, without an ARP packet on
// any wire (R-ACD-4, R-ACD-7). With an address of its own the drive has an AddressManager instead.
#pragma once

#include <cstdint>
#include <optional>

#include "adapter/mac_address.hpp"
#include "adapter/network_state.hpp"
#include "enip/time.hpp"

namespace servobus::adapter {

class AddressRivalry {
public:
    enum class Outcome : std::uint8_t {
        unnoticed,  ///< detection is off, or there is no address
        defended,   ///< bit 6 of attribute 1 is set while the defence counts
        lost,       ///< claimed again meanwhile: no address for a while, bits 6 and 7
    };

    /// The network outlives this.
    explicit AddressRivalry(Network& network) : network_(network) {}

    /// The device starts: SelectAcd takes effect (R-TCP-9), and a dispute is forgotten.
    void restart();
    /// Somebody announces the address of the device as his. What is noticed is kept in attribute 11 (R-TCP-10).
    Outcome claim(const MacAddress& rival, enip::Time now);
    /// A defence has lasted, or the address is free again.
    void on_timer(enip::Time now);
    [[nodiscard]] std::optional<enip::Time> next_deadline() const { return over_; }

private:
    Network& network_;
    bool detects_ = true;
    std::optional<enip::Time> over_{};  ///< when the dispute ends, unless there is another claim
};

}  // namespace servobus::adapter
