// What an I/O connection is to be like: everything that a Forward_Open asks for, for any device.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "assemblies/connection.hpp"
#include "cip/bytes.hpp"
#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "cip/path.hpp"
#include "cip/real_time_format.hpp"
#include "enip/io_stream.hpp"

namespace servobus::scanner {

/// One direction. `data_octets` are the application's: neither sequence count nor run/idle header.
struct IoDirection {
    std::uint32_t point = 0;
    std::size_t data_octets = 0;
    cip::RealTimeFormat format = cip::RealTimeFormat::modeless;
    cip::ConnectionType type = cip::ConnectionType::point_to_point;
    cip::Priority priority = cip::Priority::scheduled;
    bool variable = false;
    std::chrono::microseconds rpi{10'000};

    /// What the Forward_Open says (R-CON-7).
    [[nodiscard]] std::size_t connection_size() const { return cip::connection_size(format, data_octets); }
    [[nodiscard]] cip::ConnectionParameters parameters(bool redundant_owner = false) const;
    friend bool operator==(const IoDirection&, const IoDirection&) = default;
};

struct IoPlan {
    cip::Path route{};  ///< hops to the device, port segments only
    std::optional<cip::ElectronicKey> key{};
    /// What stands between key and configuration data where it is not the usual class, instance and points.
    std::optional<cip::Path> application_path{};
    std::optional<std::uint32_t> configuration_instance{assemblies::configuration_instance};
    cip::Bytes configuration{};  ///< a whole number of words
    IoDirection o_to_t{.format = cip::RealTimeFormat::header32};
    IoDirection t_to_o{};
    enip::Trigger trigger = enip::Trigger::cyclic;
    std::optional<std::chrono::microseconds> inhibit{};  ///< production inhibit time of T->O
    std::uint8_t multiplier_code = 2;                    ///< 0..7 for 4..512 (R-CON-6)
    bool redundant_owner = false;
    bool large = false;  ///< Large_Forward_Open; also taken when a size needs it

    [[nodiscard]] bool needs_large() const;
    /// Both directions null: asks or configures, and opens nothing (R-CON-23).
    [[nodiscard]] bool is_null() const {
        return o_to_t.type == cip::ConnectionType::null && t_to_o.type == cip::ConnectionType::null;
    }
    /// `[route] [key] [43 pit] 20 04 [24 cfg] 2C o2t 2C t2o [80 words data]` (R-CON-10).
    [[nodiscard]] cip::Path path() const;
    /// The request; the ids and the triad are the originator's to choose.
    [[nodiscard]] cip::ForwardOpen forward_open(std::uint32_t o_to_t_id, std::uint32_t t_to_o_id,
                                                const cip::ConnectionTriad& triad) const;
    friend bool operator==(const IoPlan&, const IoPlan&) = default;
};

/// The services of the connection manager that these ask for.
[[nodiscard]] cip::Request open_request(const cip::ForwardOpen& open);
/// Of the same triad and path (R-CON-34).
[[nodiscard]] cip::Request close_request(const cip::ForwardOpen& open);

/// A connection of the XENAX, at 10 ms, point-to-point.
[[nodiscard]] IoPlan plan_of(const assemblies::Connection& connection);

}  // namespace servobus::scanner
