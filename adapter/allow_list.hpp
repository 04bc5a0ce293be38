// Who may speak to the drive: IPv4 networks, in the notation 192.168.2.0/24.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace servobus::adapter {

/// Networks of one list.
inline constexpr std::size_t max_allowed_networks = 256;

class AllowList {
public:
    struct Network {
        std::uint32_t address = 0;  ///< host order; no bit outside the mask
        std::uint32_t mask = 0;
        friend bool operator==(const Network&, const Network&) = default;
    };

    /// `192.168.2.0/24`, or an address alone, which means /32. The text says why not.
    [[nodiscard]] static std::variant<Network, std::string> parse(std::string_view text);

    void add(Network network) { networks_.push_back(network); }
    [[nodiscard]] std::size_t size() const { return networks_.size(); }
    /// An empty list permits everybody. Otherwise nobody else is permitted, loopback neither.
    [[nodiscard]] bool permits(std::uint32_t address) const;

private:
    std::vector<Network> networks_;
};

}  // namespace servobus::adapter
