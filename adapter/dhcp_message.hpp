// BOOTP and DHCP messages: one format, of which DHCP is the part that has a message type (RFC 951, RFC 1542, RFC 2131,
// RFC 2132, RFC 3396).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "adapter/mac_address.hpp"
#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::adapter {

inline constexpr std::uint16_t dhcp_server_port = 67;
inline constexpr std::uint16_t dhcp_client_port = 68;

/// Octets of a message that are looked at: what one Ethernet frame can carry.
inline constexpr std::size_t max_dhcp_octets = 1472;

enum class DhcpType : std::uint8_t { discover = 1, offer, request, decline, ack, nak, release, inform };

enum class DhcpOption : std::uint8_t {
    pad = 0,
    subnet_mask = 1,
    router = 3,
    name_server = 6,
    host_name = 12,
    domain_name = 15,
    requested_address = 50,
    lease_time = 51,
    overload = 52,
    message_type = 53,
    server_identifier = 54,
    parameter_request_list = 55,
    renewal_time = 58,
    rebinding_time = 59,
    client_identifier = 61,
    end = 255,
};

/// A message with its options as they stand there. IPv4 addresses in host order.
struct DhcpMessage {
    enum class Operation : std::uint8_t { request = 1, reply = 2 };

    Operation operation = Operation::request;
    std::uint32_t transaction = 0;
    std::uint16_t seconds = 0;
    std::uint16_t flags = 0;
    std::uint32_t client_address = 0;   ///< ciaddr: the address that the client has
    std::uint32_t your_address = 0;     ///< yiaddr: the one that it is to have
    std::uint32_t server_address = 0;   ///< siaddr
    std::uint32_t gateway_address = 0;  ///< giaddr
    MacAddress client_mac{};
    std::map<DhcpOption, cip::Bytes> options{};

    /// Filled up to the shortest message that relays take.
    [[nodiscard]] cip::Bytes encode() const;
    /// Options may stand in the fields for file and server name too (option 52), and in several parts.
    /// `truncated`: it or an option ends too early. `too_many`: longer than max_dhcp_octets. `bad_length`: an option that
    /// has a fixed length has another one. `bad_value`: not for Ethernet, no operation, or an option 52 that means nothing.
    /// A BOOTP message may have no options at all.
    [[nodiscard]] static cip::Decoded<DhcpMessage> parse(cip::ByteView octets);

    void add(DhcpOption option, std::uint32_t value);
    void add(DhcpOption option, const std::string& text);
    void add(DhcpOption option, cip::Bytes octets) { options[option] = std::move(octets); }

    /// Nullopt: it is BOOTP, or has a type that DHCP does not have.
    [[nodiscard]] std::optional<DhcpType> type() const;
    /// The number, or the first address, of an option.
    [[nodiscard]] std::optional<std::uint32_t> number(DhcpOption option) const;
    [[nodiscard]] std::vector<std::uint32_t> addresses(DhcpOption option) const;
    /// Without the NUL that some servers append.
    [[nodiscard]] std::string text(DhcpOption option) const;
    [[nodiscard]] bool has(DhcpOption option) const { return options.contains(option); }
};

}  // namespace servobus::adapter
