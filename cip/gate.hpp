// Who may do what: asked before a request is carried out, whatever way it came, and told how each one ended.
#pragma once

#include <cstdint>
#include <optional>

#include "cip/bytes.hpp"
#include "cip/message.hpp"
#include "cip/object.hpp"
#include "cip/request_path.hpp"

namespace servobus::cip {

/// A request as the router sees it. A Set_Attribute_List is an access of its own, and so is each of its entries; the
/// same goes for a Multiple_Service_Packet or an Unconnected_Send and what is in it. Valid during the call alone.
struct Access {
    const RequestView& request;
    const Origin& origin;
    const RequestPath* path = nullptr;         ///< nullptr: the path is malformed
    std::optional<std::uint32_t> attribute{};  ///< that is meant, also where the path leaves it out
    ByteView data{};                           ///< of the service, or the value of the entry
    bool is_entry = false;                     ///< of a Set_Attribute_List
};

class Gate {
public:
    virtual ~Gate() = default;

    /// Success: it is carried out. Any other status is its answer. Asked for what an object offers, and for nothing that
    /// the router refuses by itself.
    [[nodiscard]] virtual Status admit(const Access& access) = 0;
    /// How an access ended, also one that was not admitted or never came as far.
    virtual void ended(const Access& access, const Response& response) = 0;

protected:
    Gate() = default;
    Gate(const Gate&) = default;
    Gate& operator=(const Gate&) = default;
};

}  // namespace servobus::cip
