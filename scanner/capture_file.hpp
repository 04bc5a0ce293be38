// Reads captures: pcapng, and pcap in both byte orders, with microseconds and nanoseconds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <istream>
#include <optional>
#include <string>

#include "scanner/captured_packet.hpp"

namespace servobus::scanner {

/// The longest block of a pcapng file that is taken, and the longest packet: longer ones are damage.
inline constexpr std::size_t max_block_octets = std::size_t{16} * 1024 * 1024;
inline constexpr std::size_t max_packet_octets = 262'144;
/// Interfaces of a section.
inline constexpr std::size_t max_interfaces = 1024;

/// Where in a file it goes on no more, and why: a sentence without a full stop.
struct CaptureDamage {
    std::uint64_t offset = 0;  ///< of the block or record that is damaged
    std::string text;
};

struct CaptureSummary {
    std::uint64_t packets = 0;    ///< frames of the file, whatever is in them
    std::uint64_t foreign = 0;    ///< neither UDP nor TCP over IPv4
    std::uint64_t fragments = 0;  ///< of datagrams, which are passed over
    std::uint64_t cut = 0;        ///< of which the file has not all octets
    std::uint64_t malformed = 0;
    std::uint64_t unknown_link = 0;  ///< of interfaces with a link type that is_known() does not know
    std::optional<CaptureTime> first{};
    std::optional<CaptureTime> last{};
    std::optional<CaptureDamage> damage{};  ///< what stood before it has been read
};

/// Hands every UDP and TCP packet to `each`, in the file's order. Payloads are valid during the call.
[[nodiscard]] CaptureSummary read_capture(std::istream& file, const std::function<void(const CapturedPacket&)>& each);

}  // namespace servobus::scanner
