// The management messages of PTP (IEEE 1588-2008, 15): questions to a PTP node, and what it answers. Everything in them
// is big-endian.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "cip/bytes.hpp"

namespace servobus::adapter {

using ClockIdentity = std::array<std::uint8_t, 8>;

struct PortIdentity {
    ClockIdentity clock{};
    std::uint16_t port = 0;
    friend bool operator==(const PortIdentity&, const PortIdentity&) = default;
};

/// What can be asked for (table 40).
enum class ManagementId : std::uint16_t {
    clock_description = 0x0001,
    default_data_set = 0x2000,
    current_data_set = 0x2001,
    parent_data_set = 0x2002,
    time_properties_data_set = 0x2003,
    port_data_set = 0x2004,
};

/// The port number that means all of them, or the node itself.
inline constexpr std::uint16_t all_ports = 0xFFFF;

struct ManagementQuestion {
    ManagementId id = ManagementId::default_data_set;
    std::uint16_t port = all_ports;
    std::uint16_t sequence = 0;
    std::uint8_t domain = 0;  ///< a node answers in its own alone
    friend bool operator==(const ManagementQuestion&, const ManagementQuestion&) = default;
};

/// The message that asks, with action GET.
[[nodiscard]] cip::Bytes encode(const ManagementQuestion& question);

struct ManagementAnswer {
    ManagementId id = ManagementId::default_data_set;
    std::uint16_t sequence = 0;  ///< of the question
    bool refused = false;        ///< the node does not tell it (15.5.4)
    cip::ByteView data{};        ///< of the message that was decoded
};

/// Nullopt: it is no answer, or not whole.
[[nodiscard]] std::optional<ManagementAnswer> decode_answer(cip::ByteView message);

struct ClockQuality {
    std::uint8_t clock_class = 248;   ///< the default one (7.6.2.4)
    std::uint8_t accuracy = 0xFE;     ///< unknown
    std::uint16_t variance = 0xFFFF;  ///< offsetScaledLogVariance: not computed
    friend bool operator==(const ClockQuality&, const ClockQuality&) = default;
};

/// 15.5.3.3.1.
struct DefaultDataSet {
    bool slave_only = false;
    std::uint16_t ports = 0;
    std::uint8_t priority_1 = 128;
    ClockQuality quality;
    std::uint8_t priority_2 = 128;
    ClockIdentity identity{};
    std::uint8_t domain = 0;
};

/// 15.5.3.4.1. The times are in 1/65536 ns (5.3.2).
struct CurrentDataSet {
    std::uint16_t steps_removed = 0;
    std::int64_t offset_from_master = 0;
    std::int64_t mean_path_delay = 0;
};

/// 15.5.3.5.1.
struct ParentDataSet {
    PortIdentity parent;
    std::uint16_t observed_variance = 0xFFFF;
    std::uint32_t observed_phase_change_rate = 0x7FFFFFFF;
    std::uint8_t grandmaster_priority_1 = 128;
    ClockQuality grandmaster_quality;
    std::uint8_t grandmaster_priority_2 = 128;
    ClockIdentity grandmaster{};
};

/// Flags of TimePropertiesDataSet.
inline constexpr std::uint8_t ptp_timescale = 0x08;

/// 15.5.3.6.1.
struct TimePropertiesDataSet {
    std::int16_t utc_offset = 0;  ///< TAI less UTC, in s
    std::uint8_t flags =
        0;  ///< bit 0 leap 61, 1 leap 59, 2 offset valid, 3 PTP timescale, 4 time and 5 frequency traceable
    std::uint8_t time_source = 0xA0;  ///< internal oscillator (table 7)
};

enum class PtpPortState : std::uint8_t {
    initializing = 1,
    faulty = 2,
    disabled = 3,
    listening = 4,
    pre_master = 5,
    master = 6,
    passive = 7,
    uncalibrated = 8,
    slave = 9,
};

/// 15.5.3.7.1.
struct PortDataSet {
    PortIdentity identity;
    PtpPortState state = PtpPortState::initializing;
    std::int8_t log_announce_interval = 0;  ///< of two, in s
    std::int8_t log_sync_interval = 0;
};

/// What a node tells of itself as seen from one of its ports (15.5.3.1.2).
struct ClockDescription {
    std::uint16_t clock_type =
        0;  ///< 0x8000 ordinary, 0x4000 boundary, 0x2000 and 0x1000 transparent, 0x0800 management
    std::string physical_protocol;
    cip::Bytes physical_address;
    std::uint16_t network_protocol = 0;  ///< 1 UDP/IPv4, 2 UDP/IPv6, 3 Ethernet (table 3)
    cip::Bytes protocol_address;
    std::string user_description;
    std::array<std::uint8_t, 6> profile{};
};

// Each from ManagementAnswer::data. Nullopt: there are too few octets.
[[nodiscard]] std::optional<DefaultDataSet> decode_default_data_set(cip::ByteView data);
[[nodiscard]] std::optional<CurrentDataSet> decode_current_data_set(cip::ByteView data);
[[nodiscard]] std::optional<ParentDataSet> decode_parent_data_set(cip::ByteView data);
[[nodiscard]] std::optional<TimePropertiesDataSet> decode_time_properties(cip::ByteView data);
[[nodiscard]] std::optional<PortDataSet> decode_port_data_set(cip::ByteView data);
[[nodiscard]] std::optional<ClockDescription> decode_clock_description(cip::ByteView data);

}  // namespace servobus::adapter
