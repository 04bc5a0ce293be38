// The gate of the message router: asks the policy, and tells the log.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>

#include "adapter/access_log.hpp"
#include "adapter/access_policy.hpp"
#include "cip/gate.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

class AccessGate final : public cip::Gate {
public:
    /// What the gate asks its device.
    struct Questions {
        std::function<const assemblies::Layout*()> owned;            ///< the outputs of the owner; nullptr: no owner
        std::function<std::uint32_t(std::uint64_t session)> handle;  ///< of a transport connection; 0: none
        std::function<cip::Time(cip::Time bus)> true_time;  ///< which goes on when that of the bus stands still
    };

    /// `device` and `log` outlive this.
    AccessGate(const drive::Device& device, AccessLog& log, Questions questions)
        : device_(device), log_(log), questions_(std::move(questions)) {}

    void protect(Protection protection) { protection_ = protection; }
    [[nodiscard]] const Protection& protection() const { return protection_; }

    [[nodiscard]] cip::Status admit(const cip::Access& access) override;
    void ended(const cip::Access& access, const cip::Response& response) override;

private:
    const drive::Device& device_;
    AccessLog& log_;
    Questions questions_;
    Protection protection_{};
    std::string_view why_;  ///< the access that is about to end was not admitted
};

}  // namespace servobus::adapter
