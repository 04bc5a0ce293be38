// What an I/O connection tells and is told: how it is to be made, what happens to it, and why it has ended.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "cip/forward_open.hpp"
#include "cip/status.hpp"
#include "enip/encapsulation.hpp"
#include "enip/endpoint.hpp"
#include "enip/io_stream.hpp"
#include "scanner/error.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner {

/// How far a connection is. The arrows: idle -> connecting -> opening -> open -> closing -> closed, and from closed or
/// waiting (for its next try) again to connecting.
enum class IoState : std::uint8_t { idle, connecting, opening, open, closing, waiting, closed };
[[nodiscard]] std::string_view name(IoState state);

/// Why a connection is not open any more, or has not become so.
enum class CloseReason : std::uint8_t {
    asked,        ///< close() was called, or the originator went away
    unreachable,  ///< no TCP connection, no session or no answer: IoClosed::error says which
    refused,      ///< the target refused the Forward_Open: IoClosed::status
    bad_reply,    ///< the reply to the Forward_Open makes no sense: IoClosed::error; a Forward_Close has been sent
    timed_out,    ///< no T->O datagram in time (R-CON-18, R-CON-19)
    no_socket,    ///< this machine gave no UDP socket for it: IoClosed::error
};
[[nodiscard]] std::string_view name(CloseReason reason);

struct IoOptions {
    std::string host;
    std::uint16_t port = enip::tcp_port;
    IoPlan plan{};
    std::chrono::milliseconds timeout{5000};  ///< for connecting and for each answer
    /// After a loss, and after a refusal that may pass (R-SCN-4), it is tried again; the pause doubles from the first to
    /// the last. Without this the connection stays closed.
    bool reopen = true;
    std::chrono::milliseconds first_pause{250};
    std::chrono::milliseconds last_pause{8000};
    /// Names the port of point-to-point T->O in a sockaddr item also when it is the usual one, which needs no naming.
    bool always_name_port = false;
};

/// What the target has granted.
struct IoOpened {
    cip::ForwardOpen request;
    cip::ForwardOpenReply reply;
    enip::Endpoint target;    ///< where O->T goes
    enip::Endpoint receiver;  ///< where T->O comes to: our own port, or a multicast group
    enip::Endpoint local;     ///< our end of the TCP connection
    unsigned attempt = 1;     ///< since open()
    [[nodiscard]] std::chrono::microseconds o_to_t_interval() const {
        return std::chrono::microseconds(reply.o_to_t_api);
    }
    [[nodiscard]] std::chrono::microseconds t_to_o_interval() const {
        return std::chrono::microseconds(reply.t_to_o_api);
    }
};

/// An accepted T->O datagram. `time` is when the kernel took it, where that is known.
struct IoInput {
    std::span<const std::uint8_t> data;  ///< the application's octets; valid during the call
    bool fresh = true;                   ///< not under the sequence count of the one before
    bool run = true;
    std::uint32_t sequence = 0;
    enip::Time time{};
    const enip::IoConsumer::Counters& counters;
};

struct IoClosed {
    CloseReason reason = CloseReason::asked;
    error_code error{};
    cip::Status status{};                                 ///< for `refused`
    std::optional<cip::ForwardOpen> request{};            ///< what was asked, when it came to that
    std::optional<std::chrono::milliseconds> next_try{};  ///< when it is tried again; nullopt: not
};

/// A datagram as it went over the wire, for whoever records.
struct IoPacketSeen {
    bool sent = false;
    enip::Endpoint source;
    enip::Endpoint destination;
    std::span<const std::uint8_t> octets;
    enip::Time time{};
};

/// All are called on the originator's executor, and may call open() and close().
struct IoEvents {
    std::function<void(const IoOpened&)> opened{};
    std::function<void(const IoInput&)> input{};
    /// Fills in what the next O->T datagram carries (as it was left last time); the result is run (true) or idle.
    /// Without it zeros go out, in idle.
    std::function<bool(std::span<std::uint8_t>)> output{};
    std::function<void(const IoClosed&)> closed{};
    std::function<void(const IoPacketSeen&)> packet{};
};

}  // namespace servobus::scanner
