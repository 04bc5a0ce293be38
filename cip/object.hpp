// What a CIP class offers to the message router.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/message.hpp"
#include "cip/request_path.hpp"
#include "cip/wire.hpp"

namespace servobus::cip {

/// Time as every core here takes it: an argument. Only enip/asio reads a clock.
using Time = std::chrono::steady_clock::time_point;

/// The largest message router message taken or sent, in octets: more than the 504 that every peer manages (R-ENC-27),
/// as much as a Large_Forward_Open's usual 4,000.
inline constexpr std::size_t max_message_bytes = 4000;

/// A typed item that stands beside a message in its packet, such as a sockaddr item (R-CPF-8).
struct SideItem {
    std::uint16_t type = 0;
    Bytes data{};
    friend bool operator==(const SideItem&, const SideItem&) = default;
};
using SideItems = std::vector<SideItem>;

/// How a request came here. The same service behaves alike on all ways (R-MSG-5), save where the standard says not.
struct Origin {
    enum class Via : std::uint8_t { unconnected, connected };

    Via via = Via::unconnected;
    std::uint64_t session = 0;                    ///< the transport connection it came on
    std::uint32_t address = 0;                    ///< the peer's IPv4 address, 0 when there is none
    std::uint16_t port = 0;                       ///< the peer's
    std::uint32_t local_address = 0;              ///< our own, that the peer has connected to
    const SideItems* items = nullptr;             ///< what came beside an unconnected request, if anything
    SideItems* reply_items = nullptr;             ///< what is to go beside its reply; null where nothing can
    std::size_t reply_limit = max_message_bytes;  ///< octets that a reply may have
    std::size_t depth = 0;                        ///< how many requests this one is embedded in
    bool is_routed = false;                       ///< one of them is an Unconnected_Send
    bool is_part = false;                         ///< one of them is a Multiple_Service_Packet
    Time now{};
};

/// What a peer may do with an attribute.
struct AttributeAccess {
    bool gettable = true;
    bool settable = false;
};

/// The class attributes of instance 0 (R-OBJ-1).
struct ClassInfo {
    std::uint16_t class_id = 0;
    std::uint16_t revision = 1;
    std::uint32_t max_instance = 1;
    std::uint16_t instances = 1;
    std::uint16_t max_class_attribute = 7;
    std::uint16_t max_instance_attribute = 0;
    /// What Get_Attributes_All concatenates at instance 0 (R-OBJ-3); none: the class does not offer it.
    std::span<const std::uint16_t> class_attributes_all{};
};

/// A CIP class with its instances. The router checks path, instance, service, attribute and access in the order of
/// section 2.4 before it calls get() or set(), so an object holds only what is its own.
class Object {
public:
    virtual ~Object() = default;

    [[nodiscard]] virtual ClassInfo info() const = 0;
    /// A class attribute beside those of ClassInfo: appends its value. False: there is none of that number.
    [[nodiscard]] virtual bool get_class_attribute(std::uint32_t id, Writer& value) const;
    [[nodiscard]] virtual bool has_instance(std::uint32_t instance) const { return instance == 1; }
    /// Whether the instances of this class offer a service.
    [[nodiscard]] virtual bool offers(std::uint8_t service) const = 0;

    /// Nullopt: the attribute does not exist (0x14).
    [[nodiscard]] virtual std::optional<AttributeAccess> attribute(std::uint32_t instance, std::uint32_t id) const = 0;
    /// The attribute that a path without attribute segment means (R-DEV-4).
    [[nodiscard]] virtual std::optional<std::uint32_t> implied_attribute() const { return std::nullopt; }

    /// Appends the value. Only called for attributes that exist and are gettable.
    [[nodiscard]] virtual Status get(std::uint32_t instance, std::uint32_t id, Writer& value) const = 0;
    /// Takes the value, whose length is not checked yet. A refused set changes nothing (R-ERR-11).
    [[nodiscard]] virtual Status set(std::uint32_t instance, std::uint32_t id, ByteView value);
    /// Octets of a value at the front of `data`, for Set_Attribute_List; nullopt when there are too few to tell.
    [[nodiscard]] virtual std::optional<std::size_t> value_size(std::uint32_t instance, std::uint32_t id,
                                                                ByteView data) const;

    /// The attributes that Get_Attributes_All concatenates, in the object's order (R-MSG-12).
    [[nodiscard]] virtual std::span<const std::uint16_t> attributes_all() const { return {}; }

    /// An object specific service that offers() named. `request.path` has been resolved to `path`.
    [[nodiscard]] virtual Response call(const RequestView& request, const RequestPath& path, const Origin& origin);
    /// The answer to a request that is not admitted: the status, and what the object's refusals of this service carry.
    [[nodiscard]] virtual Response refuse(const RequestView& request, Status status);

protected:
    Object() = default;
    Object(const Object&) = default;
    Object& operator=(const Object&) = default;
};

}  // namespace servobus::cip
