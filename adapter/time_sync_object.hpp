// The Time Sync object (0x43, R-TSY): how the clock of the device stands with PTP, and the time by it.
#pragma once

#include <chrono>

#include "adapter/network_state.hpp"
#include "adapter/time_sync.hpp"
#include "cip/object.hpp"
#include "drive/device.hpp"
#include "enip/time.hpp"

namespace servobus::adapter {

class TimeSyncObject final : public cip::Object {
public:
    /// All of them outlive the object.
    TimeSyncObject(const TimeSync& known, Network& network, const drive::Identity& identity)
        : known_(known), network_(network), identity_(identity) {}

    /// Before each request: the time of the device's own clock, and how far system time is ahead of it.
    void on_time(enip::Time now, std::chrono::nanoseconds ahead) {
        now_ = now;
        ahead_ = ahead;
    }

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Status set(std::uint32_t instance, std::uint32_t id, cip::ByteView value) override;
    [[nodiscard]] std::optional<std::size_t> value_size(std::uint32_t instance, std::uint32_t id,
                                                        cip::ByteView data) const override;

private:
    [[nodiscard]] TimeSyncSettings& settings() const { return network_.settings.time_sync; }
    [[nodiscard]] PtpNode node() const;
    [[nodiscard]] bool is_synchronized(const PtpNode& node) const;
    [[nodiscard]] std::chrono::nanoseconds system_time() const { return now_.time_since_epoch() + ahead_; }
    [[nodiscard]] std::string product_description() const;
    [[nodiscard]] std::string revision_data() const;

    const TimeSync& known_;
    Network& network_;
    const drive::Identity& identity_;
    enip::Time now_{};
    std::chrono::nanoseconds ahead_{0};
};

}  // namespace servobus::adapter
