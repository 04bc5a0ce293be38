// The Assembly object (0x04, R-ASM): the layouts as attributes.
#pragma once

#include <cstdint>
#include <functional>
#include <map>

#include "assemblies/layout.hpp"
#include "cip/object.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

class AssemblyObject final : public cip::Object {
public:
    /// The device must outlive the object.
    explicit AssemblyObject(drive::Device& device);

    /// Asked before each Set: while a connection owns the drive, its data is nobody else's to write (R-ASM-5). That goes
    /// for all O->T instances, because they are windows on the same parameters.
    void ask_owned(std::function<bool()> owned) { owned_ = std::move(owned); }
    /// A connection has brought new data for an O->T instance, of its size.
    void received(const assemblies::Layout& layout, cip::ByteView octets);

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool has_instance(std::uint32_t instance) const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;
    [[nodiscard]] std::optional<std::size_t> value_size(std::uint32_t instance, std::uint32_t id,
                                                        cip::ByteView data) const override;

private:
    void keep(const assemblies::Layout& layout, cip::ByteView octets);

    drive::Device& device_;
    std::function<bool()> owned_;
    std::map<std::uint32_t, cip::Bytes> written_;  ///< what was last set or received, per O->T instance (R-ASM-2)
};

/// Whether class 0x04 has an instance: a layout, a heartbeat point or the configuration (R-ASM-1).
[[nodiscard]] bool is_assembly_instance(std::uint32_t instance);

}  // namespace servobus::adapter
