#include "adapter/network_state.hpp"

namespace servobus::adapter {

void apply_address_settings(Network& network) {
    auto& state = network.state;
    const bool stored = network.settings.method == AddressMethod::stored;
    if (stored) {
        state.interface = network.settings.configured;
    } else if (state.host) {
        state.interface = *state.host;
    }
    state.address = {.configured = !stored || state.interface.address != 0};
}

}  // namespace servobus::adapter
