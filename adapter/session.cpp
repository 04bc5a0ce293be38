#include "adapter/session.hpp"

#include <algorithm>

namespace servobus::adapter {

std::optional<std::uint32_t> SessionTable::open(std::uint64_t connection) {
    if (handles_.size() >= limit_) return std::nullopt;
    std::uint32_t handle = 0;
    while (handle == 0 || in_use(handle)) handle = static_cast<std::uint32_t>(random_());
    handles_[connection] = handle;
    return handle;
}

std::uint32_t SessionTable::handle_of(std::uint64_t connection) const {
    const auto found = handles_.find(connection);
    return found != handles_.end() ? found->second : 0;
}

void SessionTable::close(std::uint64_t connection) { handles_.erase(connection); }

bool SessionTable::in_use(std::uint32_t handle) const {
    return std::ranges::any_of(handles_, [&](const auto& entry) { return entry.second == handle; });
}

}  // namespace servobus::adapter
