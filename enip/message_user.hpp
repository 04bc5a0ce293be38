// What one who asks a program of this machine is to its socket: messages and time in, messages and the next deadline out
// (decision 2).
#pragma once

#include <optional>
#include <vector>

#include "cip/bytes.hpp"
#include "enip/time.hpp"

namespace servobus::enip {

/// All calls come from one thread at a time; `now` never goes back.
class MessageUser {
public:
    virtual ~MessageUser() = default;

    virtual void on_message(cip::ByteView octets, Time now) = 0;
    /// To be called when the exchange starts, and at or after next_deadline().
    virtual void on_timer(Time now) = 0;
    [[nodiscard]] virtual std::optional<Time> next_deadline() const = 0;
    /// What is to be sent now.
    [[nodiscard]] virtual std::vector<cip::Bytes> take_messages() = 0;

protected:
    MessageUser() = default;
    MessageUser(const MessageUser&) = default;
    MessageUser& operator=(const MessageUser&) = default;
};

}  // namespace servobus::enip
