// Who has which address, and who listens to which group.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>

#include "enip/endpoint.hpp"

namespace servobus::sim {

class Neighbourhood {
public:
    [[nodiscard]] static constexpr std::uint32_t node_address(unsigned node) {
        return 0xC0A80201 + node;
    }  // 192.168.2.1
    [[nodiscard]] static constexpr std::uint32_t drive_address(unsigned drive) {
        return 0xC0A80264 + drive;
    }  // 192.168.2.100
    [[nodiscard]] static constexpr std::optional<unsigned> node_at(std::uint32_t address) {
        const auto number = address - node_address(0);
        if (number >= drive_address(0) - node_address(0)) return std::nullopt;
        return number;
    }

    void join(std::uint32_t group, unsigned node) { members_[group].insert(node); }
    void leave(std::uint32_t group, unsigned node) {
        const auto found = members_.find(group);
        if (found == members_.end()) return;
        found->second.erase(node);
        if (found->second.empty()) members_.erase(found);
    }
    void leave_all(unsigned node) {
        for (auto& [group, nodes] : members_) nodes.erase(node);
        std::erase_if(members_, [](const auto& entry) { return entry.second.empty(); });
    }
    [[nodiscard]] const std::set<unsigned>* members(std::uint32_t group) const {
        const auto found = members_.find(group);
        return found != members_.end() ? &found->second : nullptr;
    }
    [[nodiscard]] std::size_t groups() const { return members_.size(); }

private:
    std::map<std::uint32_t, std::set<unsigned>> members_;
};

}  // namespace servobus::sim
