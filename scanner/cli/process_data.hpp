// The process data of an open I/O connection, as somebody uses them who waits for what he has caused.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>

#include "assemblies/layout.hpp"
#include "cip/bytes.hpp"
#include "scanner/cli/link.hpp"

namespace servobus::scanner::cli {

class ProcessData {
public:
    using Clock = std::chrono::steady_clock;
    struct Input {
        cip::Bytes data;
        Clock::time_point time{};
    };

    virtual ~ProcessData() = default;

    [[nodiscard]] virtual const assemblies::Layout& output_layout() const = 0;
    [[nodiscard]] virtual const assemblies::Layout& input_layout() const = 0;

    /// What the next datagram carries, and all after it. Between two datagrams it may change as often as one likes.
    [[nodiscard]] virtual cip::Bytes& outputs() = 0;
    /// Datagrams that have left with their outputs, since the opening.
    [[nodiscard]] virtual std::uint64_t sent() const = 0;
    /// The last inputs, and how many have come since the opening.
    [[nodiscard]] virtual const Input& input() const = 0;
    [[nodiscard]] virtual std::uint64_t received() const = 0;
    /// Called for all inputs that come.
    virtual void on_input(std::function<void(const Input&)> listener) = 0;

    /// Lets time pass until `done` says so. A failure when the connection has ended before.
    [[nodiscard]] virtual std::optional<Failure> run_until(const std::function<bool()>& done) = 0;

protected:
    ProcessData() = default;
    ProcessData(const ProcessData&) = default;
    ProcessData& operator=(const ProcessData&) = default;
};

}  // namespace servobus::scanner::cli
