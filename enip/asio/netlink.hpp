// Requests to the kernel's tables of links, addresses and routes (rtnetlink), and what it answers.
#pragma once

#include <arpa/inet.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>

#include <boost/system/error_code.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace servobus::enip::asio::netlink {

/// What the kernel writes at once, at most.
inline constexpr std::size_t answer_octets = 32768;

/// A header, a struct of its kind, attributes.
class Request {
public:
    template <class Body>
    Request(std::uint16_t type, int flags, const Body& body) {
        append(nlmsghdr{.nlmsg_len = 0,
                        .nlmsg_type = type,
                        .nlmsg_flags = static_cast<std::uint16_t>(flags | NLM_F_REQUEST),
                        .nlmsg_seq = 1,
                        .nlmsg_pid = 0});
        append(body);
    }

    template <class Value>
    Request& attribute(std::uint16_t type, const Value& value) {
        append(rtattr{.rta_len = RTA_LENGTH(sizeof value), .rta_type = type});
        append(value);
        return *this;
    }
    /// An IPv4 address in host order.
    Request& address(std::uint16_t type, std::uint32_t address) { return attribute(type, htonl(address)); }

    [[nodiscard]] std::span<const std::byte> octets();

private:
    template <class Value>
    void append(const Value& value) {
        const auto at = octets_.size();
        octets_.resize(at + NLMSG_ALIGN(sizeof value));
        std::memcpy(octets_.data() + at, &value, sizeof value);
    }

    std::vector<std::byte> octets_;
};

/// One message of the kernel's.
struct Answer {
    nlmsghdr header{};
    std::span<const std::byte> body;

    /// The struct that it begins with; nullopt when it is shorter.
    template <class Body>
    [[nodiscard]] std::optional<Body> as() const {
        if (body.size() < sizeof(Body)) return std::nullopt;
        Body copy{};
        std::memcpy(&copy, body.data(), sizeof copy);
        return copy;
    }
    /// An attribute behind that struct.
    template <class Value, class Body>
    [[nodiscard]] std::optional<Value> attribute(std::uint16_t type) const {
        const auto octets = attribute_octets(sizeof(Body), type);
        if (!octets || octets->size() < sizeof(Value)) return std::nullopt;
        Value value{};
        std::memcpy(&value, octets->data(), sizeof value);
        return value;
    }

private:
    [[nodiscard]] std::optional<std::span<const std::byte>> attribute_octets(std::size_t behind,
                                                                             std::uint16_t type) const;
};

using Take = std::function<void(const Answer&)>;

/// A socket that hears these groups, or -1 and errno.
[[nodiscard]] int open(unsigned groups);
/// Calls `take` with each message; what is damaged, and all behind it, is left out.
void split(std::span<const std::byte> octets, const Take& take);
/// Sends the request and waits for the kernel's word on it; `take` gets what it tells beside.
[[nodiscard]] boost::system::error_code ask(Request request, const Take& take = {});

}  // namespace servobus::enip::asio::netlink
