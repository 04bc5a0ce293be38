// The Identity object (0x01, R-ID): who the device is. ListIdentity says the same (R-ID-7).
#pragma once

#include <cstdint>
#include <functional>

#include "cip/object.hpp"
#include "cip/request_path.hpp"
#include "drive/device.hpp"
#include "enip/messages.hpp"

namespace servobus::adapter {

/// Attribute 8, as far as this device takes the states (R-ID-5).
enum class IdentityState : std::uint8_t { standby = 2, operational = 3 };

/// The data of service 0x05 (R-ID-8).
enum class ResetType : std::uint8_t {
    restart = 0,           ///< as after a power cycle
    factory_defaults = 1,  ///< and then a restart
};

class IdentityObject final : public cip::Object {
public:
    /// Grants a reset, which takes effect when the reply has left, or says why not.
    using Reset = std::function<cip::GeneralStatus(ResetType, cip::Time)>;
    /// What is so at the moment of asking: the status word (R-ID-3, R-ID-4) and the state (R-ID-5).
    struct Present {
        std::uint16_t status = 0;
        IdentityState state = IdentityState::operational;
    };
    IdentityObject(drive::Identity identity, Reset reset, std::function<Present()> present);

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] std::span<const std::uint16_t> attributes_all() const override;
    [[nodiscard]] cip::Response call(const cip::RequestView& request, const cip::RequestPath& path,
                                     const cip::Origin& origin) override;

    /// The item of ListIdentity. `own` is the address that the request came to.
    [[nodiscard]] enip::IdentityItem item(enip::SocketAddress own) const;

private:
    drive::Identity identity_;
    Reset reset_;
    std::function<Present()> present_;
};

/// What an electronic key is compared with.
[[nodiscard]] cip::NodeIdentity node_identity(const drive::Identity& identity);

}  // namespace servobus::adapter
