// Item lists, what SendRRData and SendUnitData make of them, and every other decoder of the encapsulation.
#include <cstddef>
#include <cstdint>

#include "enip/common_packet.hpp"
#include "enip/messages.hpp"
#include "tests/support/everything.hpp"

using namespace servobus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const cip::ByteView octets(data, size);
    if (const auto packet = enip::CommonPacket::parse(octets)) {
        const auto encoded = packet->encode();
        test::require(std::ranges::equal(encoded, octets), "a packet comes out octet by octet", octets);
        test::require(packet->items.size() <= enip::max_items, "the limit of items is kept", octets);
    }
    test::decode_everything(octets);
    return 0;
}
