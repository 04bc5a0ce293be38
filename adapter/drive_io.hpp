// What I/O connections do with the drive: inputs are its values, outputs are written into it, and it stops when its
// controller is gone.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "adapter/assembly_object.hpp"
#include "adapter/log.hpp"
#include "assemblies/image.hpp"
#include "assemblies/layout.hpp"
#include "cip/bytes.hpp"
#include "cip/object.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

class DriveIo {
public:
    /// All of them outlive this.
    DriveIo(drive::Device& device, AssemblyObject& assemblies, const Log& log);

    /// The present octets of a T->O assembly; good until the next call for the same one.
    [[nodiscard]] cip::ByteView inputs(const assemblies::Layout& layout, cip::Time now);
    /// New octets of an O->T assembly, of its size. Members that the drive refuses are left out (R-IO-9).
    void apply(const assemblies::Layout& layout, cip::ByteView octets);
    /// The controller went to idle, closed its connection, or has been lost: the drive stops (docs/motion.md).
    void lose_controller();

    /// How far the clock of the time stamps, which counts from 1970, is ahead of that of `now` (R-IO-10).
    void set_day_clock(std::chrono::nanoseconds ahead) { day_ahead_ = ahead; }

private:
    struct Bound {
        assemblies::Image image;
        cip::Bytes octets;
        std::uint32_t refused = 0;  ///< what the log has been told of, a bit for each member
    };
    [[nodiscard]] Bound& bound(const assemblies::Layout& layout) { return bound_.at(layout.instance); }

    drive::Device& device_;
    AssemblyObject& assemblies_;
    const Log& log_;
    std::map<std::uint16_t, Bound> bound_;
    std::chrono::nanoseconds day_ahead_{0};
};

}  // namespace servobus::adapter
