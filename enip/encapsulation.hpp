// The encapsulation header, its commands and its status codes (R-ENC-2, R-ENC-4, R-ENC-5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::enip {

inline constexpr std::uint16_t tcp_port = 44818;  ///< also UDP, for explicit messages (R-ENC-1)
inline constexpr std::uint16_t io_port = 2222;
inline constexpr std::size_t header_bytes = 24;
/// The largest length that the header may state (R-ENC-2).
inline constexpr std::size_t max_stated_length = 65511;
/// The largest data portion that this end holds; longer ones are passed over and answered 0x0065 (R-ENC-3).
inline constexpr std::size_t max_data_bytes = 4200;

enum class Command : std::uint16_t {
    nop = 0x0000,
    list_services = 0x0004,
    list_identity = 0x0063,
    list_interfaces = 0x0064,
    register_session = 0x0065,
    unregister_session = 0x0066,
    send_rr_data = 0x006F,
    send_unit_data = 0x0070,
};

enum class EncapsulationStatus : std::uint32_t {
    success = 0x0000,
    unsupported_command = 0x0001,
    insufficient_memory = 0x0002,
    incorrect_data = 0x0003,
    invalid_session = 0x0064,
    invalid_length = 0x0065,
    unsupported_protocol = 0x0069,
};

/// "invalid session handle", with its number for codes that are not defined.
[[nodiscard]] std::string describe(EncapsulationStatus status);
[[nodiscard]] std::string describe(Command command);

using SenderContext = std::array<std::uint8_t, 8>;

/// A message of the encapsulation layer: header fields and data portion. The length is that of the data.
struct Frame {
    Command command = Command::nop;
    std::uint32_t session = 0;
    EncapsulationStatus status = EncapsulationStatus::success;
    SenderContext context{};
    std::uint32_t options = 0;
    cip::Bytes data{};

    /// Appends header and data.
    void write(cip::Bytes& out) const;
    [[nodiscard]] cip::Bytes encode() const;

    /// Exactly one message, as a datagram holds it: truncated when shorter than it states; octets behind it are
    /// ignored. Longer than max_data_bytes: too_many.
    [[nodiscard]] static cip::Decoded<Frame> parse(cip::ByteView datagram);

    /// The reply to this frame: same command, session and context (R-ENC-9).
    [[nodiscard]] Frame reply(EncapsulationStatus code = EncapsulationStatus::success, cip::Bytes body = {}) const;

    friend bool operator==(const Frame&, const Frame&) = default;
};

}  // namespace servobus::enip
