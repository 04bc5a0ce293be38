// Finds the object that a request means, and checks what is the same for all objects (sections 2.3 and 2.4).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/gate.hpp"
#include "cip/message.hpp"
#include "cip/object.hpp"
#include "cip/request_path.hpp"

namespace servobus::cip {

/// Requests inside requests: an Unconnected_Send may hold a Multiple_Service_Packet, whose parts hold none.
inline constexpr std::size_t max_embedding = 2;

/// The Message Router object (0x02) and the dispatch to all others.
class MessageRouter {
public:
    explicit MessageRouter(NodeIdentity node);
    MessageRouter(const MessageRouter&) = delete;
    MessageRouter& operator=(const MessageRouter&) = delete;

    /// One object per class; a second one of a class takes the place of the first.
    void add(std::unique_ptr<Object> object);

    /// What electronic keys are compared with from now on.
    void set_node(NodeIdentity node) { node_ = node; }
    /// Asked before each request is carried out; it outlives the router. nullptr: everything is admitted.
    void set_gate(Gate* gate) { gate_ = gate; }

    /// The class ids of all objects, ascending.
    [[nodiscard]] std::vector<std::uint16_t> classes() const;

    /// Answers any message of at least two octets (R-MSG-3); shorter ones are an encapsulation error and yield nullopt.
    [[nodiscard]] std::optional<Response> handle(ByteView message, const Origin& origin);

    /// How many attributes have been set.
    [[nodiscard]] std::uint64_t sets() const { return sets_; }

private:
    struct SetEntry;  ///< one entry of a Set_Attribute_List

    Response dispatch(Access& access);
    Response dispatch(Access& access, Object& object);
    Response carry_out(const Access& access, Object& object);
    static SetEntry read_entry(const Object& object, std::uint32_t instance, Reader& reader);
    Status set_entry(const Access& list, Object& object, const SetEntry& entry);
    Status set_list(const Access& access, Object& object, std::size_t limit, Bytes& data);
    Response multiple_service_packet(const RequestView& request, const Origin& origin);

    NodeIdentity node_;
    Gate* gate_ = nullptr;
    std::map<std::uint32_t, std::unique_ptr<Object>> objects_;
    std::uint64_t sets_ = 0;
};

}  // namespace servobus::cip
