// The Identity object (0x01, R-ID): who the device is. ListIdentity says the same (R-ID-7).
#pragma once

#include <cstdint>
#include <functional>

#include "adapter/identity_status.hpp"
#include "cip/object.hpp"
#include "cip/request_path.hpp"
#include "drive/device.hpp"
#include "enip/messages.hpp"

namespace servobus::adapter {

/// The data of service 0x05 (R-ID-8).
enum class ResetType : std::uint8_t {
    restart = 0,                        ///< as after a power cycle
    factory_defaults = 1,               ///< and then a restart
    factory_defaults_keep_network = 2,  ///< the same, with the settings of 0xF5, 0xF6 and 0x48 as they are
};

class IdentityObject final : public cip::Object {
public:
    /// Grants a reset, which takes effect when the reply has left, or says why not.
    using Reset = std::function<cip::GeneralStatus(ResetType, cip::Time)>;
    /// The identity outlives this; what changes in it is told from then on.
    IdentityObject(const drive::Identity& identity, Reset reset, std::function<DeviceCondition()> condition);

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
    const drive::Identity& identity_;
    Reset reset_;
    std::function<DeviceCondition()> condition_;
};

/// What an electronic key is compared with.
[[nodiscard]] cip::NodeIdentity node_identity(const drive::Identity& identity);

}  // namespace servobus::adapter
