// What a node hears below IP: an address manager that asks for an address, and a ring node. The input is a row of steps: an
// octet that says what happens, and a frame with its length in front.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "adapter/address_manager.hpp"
#include "adapter/ring_node.hpp"
#include "adapter/usable_address.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

constexpr std::size_t longest_frame = 1518;

// Lets time pass to the user's next deadline, or a little on.
void pass_time(enip::LinkUser& user, enip::Time& now) {
    const auto next = user.next_deadline();
    now = std::max(now + std::chrono::microseconds(100), next.value_or(now));
    user.on_timer(now);
}

void step(enip::LinkUser& user, std::uint8_t what, const enip::HeardFrame& frame, enip::Time& now) {
    const std::size_t port = what & 1U;
    if ((what & 0xE0U) == 0xE0U) {
        user.on_link(port, (what & 2U) != 0, now);
    } else if ((what & 0xC0U) == 0xC0U) {
        pass_time(user, now);
    } else {
        user.on_frame(port, frame, now);
    }
    for (const auto& sent : user.take_frames()) {
        test::require(sent.octets.size() >= 60 && sent.octets.size() <= longest_frame, "a frame has its size");
    }
}

}  // namespace

void link(cip::ByteView octets) {
    Input input(octets);
    const auto how = input.u8();
    adapter::Network network;
    network.settings.method = static_cast<adapter::AddressMethod>(how % 3);
    network.settings.configured = {.address = 0xC0A80264, .mask = 0xFFFFFF00};
    network.state.ring.announce_based = (how & 0x80U) != 0;
    adapter::AddressManager manager(network, how);
    adapter::RingNode node(network.state);
    enip::Time now{std::chrono::hours(1)};
    manager.restart();
    manager.on_timer(now);
    while (!input.over()) {
        const auto what = input.u8();
        const auto heard = input.long_piece();
        const enip::HeardFrame frame{heard, (what & 0x10U) != 0};
        step(manager, what, frame, now);
        step(node, what, frame, now);
        const auto address = manager.address();
        test::require(!address || adapter::is_usable(network.state.interface), "the address is one of a host");
        test::require(address.has_value() == network.state.address.configured, "status and address agree");
    }
}

}  // namespace servobus::fuzz
