// The connection ids and numbers that this target chooses, for all its connections (R-CON-16).
#pragma once

#include <cstdint>
#include <functional>
#include <utility>

namespace servobus::adapter {

class ConnectionIds {
public:
    /// `incarnation` goes into the upper half of every id, so that ids differ between starts. `taken`: whether any open
    /// connection has an id.
    ConnectionIds(std::uint16_t incarnation, std::function<bool(std::uint32_t)> taken)
        : incarnation_(incarnation), taken_(std::move(taken)) {}

    /// An id that no open connection has, of whatever class, and that none has had for 65,000 ids.
    [[nodiscard]] std::uint32_t next() {
        std::uint32_t id = 0;
        do {
            id = std::uint32_t{incarnation_} << 16 | ++last_;
        } while (taken_(id));
        return id;
    }

private:
    std::uint16_t incarnation_;
    std::uint16_t last_ = 0;
    std::function<bool(std::uint32_t)> taken_;
};

}  // namespace servobus::adapter
