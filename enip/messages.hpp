// The data portions of the encapsulation commands (R-ENC-12 to R-ENC-23).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/message.hpp"
#include "enip/common_packet.hpp"

namespace servobus::enip {

inline constexpr std::uint16_t protocol_version = 1;

/// RegisterSession, request and reply (R-ENC-17).
struct RegisterSession {
    std::uint16_t version = protocol_version;
    std::uint16_t options = 0;

    [[nodiscard]] cip::Bytes encode() const;
    [[nodiscard]] static cip::Decoded<RegisterSession> parse(cip::ByteView data);
    friend bool operator==(const RegisterSession&, const RegisterSession&) = default;
};

/// The identity item of ListIdentity (R-CPF-5).
struct IdentityItem {
    std::uint16_t version = protocol_version;
    SocketAddress socket;
    std::uint16_t vendor = 0;
    std::uint16_t device_type = 0;
    std::uint16_t product_code = 0;
    std::uint8_t major_revision = 0;
    std::uint8_t minor_revision = 0;
    std::uint16_t status = 0;
    std::uint32_t serial_number = 0;
    std::string product_name;
    std::uint8_t state = 0;

    [[nodiscard]] cip::Bytes encode() const;
    [[nodiscard]] static cip::Decoded<IdentityItem> parse(cip::ByteView data);
    friend bool operator==(const IdentityItem&, const IdentityItem&) = default;
};

/// The service item of ListServices (R-CPF-4).
struct ServiceItem {
    static constexpr std::uint16_t cip_over_tcp = 0x0020;
    static constexpr std::uint16_t io_over_udp = 0x0100;

    std::uint16_t version = protocol_version;
    std::uint16_t flags = cip_over_tcp | io_over_udp;
    std::string name = "Communications";  ///< at most 16 characters, filled with zeros

    [[nodiscard]] cip::Bytes encode() const;
    [[nodiscard]] static cip::Decoded<ServiceItem> parse(cip::ByteView data);
    friend bool operator==(const ServiceItem&, const ServiceItem&) = default;
};

/// SendRRData and SendUnitData, both ways: interface handle, timeout, items (R-ENC-22, R-ENC-23).
struct SendData {
    std::uint32_t interface_handle = 0;
    std::uint16_t timeout = 0;  ///< seconds; 0 and ignored for CIP
    CommonPacket packet;

    [[nodiscard]] cip::Bytes encode() const;
    [[nodiscard]] static cip::Decoded<SendData> parse(cip::ByteView data);
    friend bool operator==(const SendData&, const SendData&) = default;

    /// An unconnected message: null address, then the message router's octets.
    [[nodiscard]] static SendData unconnected(cip::Bytes message);
    /// A connected message: the receiver's connection id, then sequence count and message router's octets.
    [[nodiscard]] static SendData connected(std::uint32_t connection_id, std::uint16_t sequence, cip::ByteView message);
};

/// The same in the octets that it came in.
struct SendDataView {
    std::uint32_t interface_handle = 0;
    std::uint16_t timeout = 0;
    CommonPacketView packet{};

    [[nodiscard]] static cip::Decoded<SendDataView> parse(cip::ByteView data);
};

/// The parts of a SendRRData that may be processed (R-CPF-2): null address item, unconnected data, extra items.
[[nodiscard]] cip::Decoded<cip::ByteView> unconnected_message(const SendDataView& data);
[[nodiscard]] cip::Decoded<cip::ByteView> unconnected_message(const SendData& data);

/// The parts of a SendUnitData that may be processed (R-ENC-23).
struct ConnectedMessage {
    std::uint32_t connection_id = 0;
    std::uint16_t sequence = 0;
    cip::ByteView message;
};
[[nodiscard]] cip::Decoded<ConnectedMessage> connected_message(const SendDataView& data);
[[nodiscard]] cip::Decoded<ConnectedMessage> connected_message(const SendData& data);

/// The octets of SendData::unconnected() with a reply in it and items beside it.
[[nodiscard]] cip::Bytes unconnected_reply(const cip::Response& response, std::span<const ItemView> beside = {});
/// The octets of SendData::connected().
[[nodiscard]] cip::Bytes connected_reply(std::uint32_t connection_id, std::uint16_t sequence, cip::ByteView message);

}  // namespace servobus::enip
