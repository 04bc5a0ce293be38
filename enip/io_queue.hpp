// Class 0 and 1 datagrams on their way out: built in place, so that nothing is allocated once the queue has its size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enip/endpoint.hpp"

namespace servobus::enip {

/// How a datagram travels. The same for all datagrams of one connection.
struct IoRoute {
    Endpoint local;         ///< its address is the source; 0 when the system may choose
    Endpoint peer;          ///< one receiver, or a multicast group
    std::uint8_t dscp = 0;  ///< 0..63 (R-QOS-5)
    std::uint8_t ttl = 0;   ///< of multicast; 0: what the system does
};

class IoQueue {
public:
    struct Entry {
        IoRoute route;
        std::size_t offset;
        std::size_t size;
    };

    /// Room for a datagram, to be filled before anything else is added.
    [[nodiscard]] std::span<std::uint8_t> add(const IoRoute& route, std::size_t size) {
        const auto offset = octets_.size();
        octets_.resize(offset + size);
        entries_.push_back({route, offset, size});
        return std::span(octets_).subspan(offset, size);
    }

    [[nodiscard]] bool empty() const { return entries_.empty(); }
    [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
    [[nodiscard]] std::span<std::uint8_t> octets(const Entry& entry) {
        return std::span(octets_).subspan(entry.offset, entry.size);
    }
    [[nodiscard]] std::span<const std::uint8_t> octets(const Entry& entry) const {
        return std::span(octets_).subspan(entry.offset, entry.size);
    }
    /// All of another queue, behind what is here.
    void append(const IoQueue& other) {
        const auto offset = octets_.size();
        octets_.insert(octets_.end(), other.octets_.begin(), other.octets_.end());
        for (const auto& entry : other.entries_) entries_.push_back({entry.route, offset + entry.offset, entry.size});
    }
    /// Keeps its memory.
    void clear() {
        entries_.clear();
        octets_.clear();
    }

private:
    std::vector<Entry> entries_;
    std::vector<std::uint8_t> octets_;
};

}  // namespace servobus::enip
