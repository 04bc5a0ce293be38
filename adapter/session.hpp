// The sessions of the encapsulation layer: random handles, each good on one TCP connection only (R-ENC-17, R-ENC-21).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <random>

namespace servobus::adapter {

class SessionTable {
public:
    /// The same seed gives the same handles; the process that serves a network takes an unpredictable one.
    SessionTable(std::size_t limit, std::uint64_t seed) : limit_(limit), random_(seed) {}

    /// A new handle for a connection; nullopt when all are taken. Never 0.
    [[nodiscard]] std::optional<std::uint32_t> open(std::uint64_t connection);
    /// The handle of a connection, 0 when it has none.
    [[nodiscard]] std::uint32_t handle_of(std::uint64_t connection) const;
    void close(std::uint64_t connection);
    [[nodiscard]] std::size_t size() const { return handles_.size(); }

private:
    [[nodiscard]] bool in_use(std::uint32_t handle) const;

    std::size_t limit_;
    std::mt19937_64 random_;
    std::map<std::uint64_t, std::uint32_t> handles_;  ///< by connection
};

}  // namespace servobus::adapter
