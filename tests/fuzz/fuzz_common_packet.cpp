// Item lists, what SendRRData and SendUnitData make of them, and the items themselves.
#include <algorithm>

#include "enip/common_packet.hpp"
#include "enip/messages.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

bool lies_in(cip::ByteView part, const enip::SendData& data) {
    return part.empty() || std::ranges::any_of(data.packet.items, [&](const enip::Item& item) {
               return part.data() >= item.data.data() &&
                      part.data() + part.size() <= item.data.data() + item.data.size();
           });
}

}  // namespace

void common_packet(cip::ByteView octets) {
    if (const auto packet = enip::CommonPacket::parse(octets)) {
        require(std::ranges::equal(packet->encode(), octets), "a packet comes out octet by octet", octets);
        require(packet->items.size() <= enip::max_items, "the limit of items is kept", octets);
        for (const auto& item : packet->items) {
            const auto* first = packet->find(item.type);
            require(first != nullptr && first <= &item, "an item is found by its type", octets);
        }
    }
    if (const auto data = enip::SendData::parse(octets)) {
        require(std::ranges::equal(data->encode(), octets), "a message comes out octet by octet", octets);
        if (const auto message = enip::unconnected_message(*data)) {
            require(lies_in(*message, *data), "an unconnected message is in its packet", octets);
        }
        if (const auto message = enip::connected_message(*data)) {
            require(lies_in(message->message, *data), "a connected message is in its packet", octets);
        }
    }
    test::decode_everything(octets);
}

}  // namespace servobus::fuzz
