// Finds the object that a request means, and checks what is the same for all objects (sections 2.3 and 2.4).
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "cip/bytes.hpp"
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

    /// The class ids of all objects, ascending.
    [[nodiscard]] std::vector<std::uint16_t> classes() const;

    /// Answers any message of at least two octets (R-MSG-3); shorter ones are an encapsulation error and yield nullopt.
    [[nodiscard]] std::optional<Response> handle(ByteView message, const Origin& origin);

private:
    Response dispatch(const RequestView& request, const Origin& origin);
    Response dispatch(const RequestView& request, const RequestPath& path, Object& object, const Origin& origin);
    Response multiple_service_packet(const RequestView& request, const Origin& origin);

    NodeIdentity node_;
    std::map<std::uint32_t, std::unique_ptr<Object>> objects_;
};

}  // namespace servobus::cip
