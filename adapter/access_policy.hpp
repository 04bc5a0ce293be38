// Who may change what: the rules behind --read-only and --harden, as a table.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "assemblies/layout.hpp"
#include "cip/gate.hpp"
#include "cip/request_path.hpp"
#include "cip/status.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

struct Protection {
    bool read_only = false;  ///< nothing is changed, and nobody becomes the owner
    bool harden = false;     ///< no resets, no network settings, and what an I/O connection owns is its own
};

/// What a service does to the device.
enum class Effect : std::uint8_t {
    reads,    ///< nothing
    carries,  ///< nothing by itself: what is in it counts
    sets,     ///< attributes
    resets,
    opens,    ///< a connection, which may or may not carry data to the drive
    closes,   ///< one of the peer's own
    changes,  ///< anything else; also what is not known
};
/// By the service and, for codes from 0x4B on, its class. A service that no row names changes something.
[[nodiscard]] Effect effect_of(std::uint8_t code, std::uint32_t class_id);

/// What the rules look at beside the request.
struct Surroundings {
    cip::NodeIdentity node;
    const drive::Device& device;
    const assemblies::Layout* owned = nullptr;  ///< the outputs of the owner's connection
};

struct Denial {
    cip::Status status{};
    std::string_view why;  ///< a clause for the log
};
/// Nullopt: nothing is against it. The same answer for every way on which a request comes.
[[nodiscard]] std::optional<Denial> denied(const Protection& protection, const cip::Access& access,
                                           const Surroundings& surroundings);

}  // namespace servobus::adapter
