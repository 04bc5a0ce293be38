// The common packet format: a list of typed items (R-CPF-1 to R-CPF-10).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/wire.hpp"

namespace servobus::enip {

/// More items than any message of the standard has; a longer list is refused.
inline constexpr std::size_t max_items = 16;

enum class ItemType : std::uint16_t {
    null_address = 0x0000,
    identity = 0x000C,
    connected_address = 0x00A1,
    connected_data = 0x00B1,
    unconnected_data = 0x00B2,
    service_information = 0x0100,
    sockaddr_o_to_t = 0x8000,
    sockaddr_t_to_o = 0x8001,
    sequenced_address = 0x8002,
};

struct Item {
    ItemType type = ItemType::null_address;
    cip::Bytes data{};
    friend bool operator==(const Item&, const Item&) = default;
};

struct CommonPacket {
    std::vector<Item> items;

    [[nodiscard]] cip::Bytes encode() const;
    [[nodiscard]] std::size_t encoded_size() const;
    /// Appends it.
    void write(cip::Writer& writer) const;
    /// truncated: an item ends behind the message; trailing: octets behind the last item; too_many: above max_items.
    [[nodiscard]] static cip::Decoded<CommonPacket> parse(cip::ByteView bytes);
    /// The first item of a type, or nullptr.
    [[nodiscard]] const Item* find(ItemType type) const;
    friend bool operator==(const CommonPacket&, const CommonPacket&) = default;
};

/// Appends what stands in front of the data of an item.
void write_item_head(cip::Writer& writer, ItemType type, std::size_t octets);

/// An item in the octets that it came in.
struct ItemView {
    ItemType type = ItemType::null_address;
    cip::ByteView data{};
};

/// A packet in the octets that it came in, all of whose items are there.
class CommonPacketView {
public:
    CommonPacketView() = default;

    [[nodiscard]] std::size_t size() const { return count_; }
    /// Looks for it from the first one on; there are few.
    [[nodiscard]] ItemView operator[](std::size_t index) const;
    /// As CommonPacket::parse().
    [[nodiscard]] static cip::Decoded<CommonPacketView> parse(cip::ByteView bytes);

private:
    cip::ByteView items_{};
    std::size_t count_ = 0;
};

/// A socket address as the sockaddr items and the identity item carry it: big-endian (R-CPF-8).
struct SocketAddress {
    std::uint16_t family = 2;
    std::uint16_t port = 0;
    std::uint32_t address = 0;  ///< IPv4, host order
    std::array<std::uint8_t, 8> zero{};

    [[nodiscard]] cip::Bytes encode() const;
    [[nodiscard]] static cip::Decoded<SocketAddress> parse(cip::ByteView bytes);
    friend bool operator==(const SocketAddress&, const SocketAddress&) = default;
};

}  // namespace servobus::enip
