// What can go wrong between a request and its response, besides the operating system's own errors. A CIP status is
// none of these: it is in the Response (decision 4).
#pragma once

#include <boost/system/error_code.hpp>
#include <cstdint>

#include "enip/encapsulation.hpp"

namespace servobus::scanner {

using boost::system::error_code;

/// Each value: when it happens, and whether the connection stands afterwards.
enum class Error : std::uint8_t {
    timeout = 1,         ///< no answer in time; the connection stands, a late answer is dropped
    closed,              ///< the device closed the connection between two messages
    closed_in_message,   ///< the device closed the connection in the middle of a message
    not_connected,       ///< no session: connect first
    already_connected,   ///< connect was called twice
    too_many_requests,   ///< more than max_waiting requests wait to be sent
    request_too_large,   ///< the request is longer than the way to the device takes; nothing was sent
    foreign_protocol,    ///< what came in is not EtherNet/IP; the connection is closed
    oversize_reply,      ///< longer than max_data_bytes; the connection stands, as it does after all that follow
    wrong_command,       ///< a reply to another encapsulation command, or with the context of nobody's request
    malformed_packet,    ///< the common packet format is broken
    malformed_response,  ///< too short for a CIP reply, or no reply
    wrong_service,       ///< a reply to another CIP service
    missing_data,        ///< the value is shorter than its type
    unexpected_data,     ///< the data of a reply does not have the shape that the service gives it
    wrong_connection,    ///< a reply about another I/O connection
    bad_interval,        ///< a packet interval is granted that nobody can keep
    bad_socket_address,  ///< a sockaddr item is malformed, or missing where multicast needs it (R-CPF-9)
};

[[nodiscard]] error_code make_error_code(Error error);

/// The device refused a message of the encapsulation layer; the value is its status (R-ENC-4).
[[nodiscard]] error_code make_error_code(enip::EncapsulationStatus status);

/// What a person, or an exit code, makes of an error.
enum class Trouble : std::uint8_t {
    usage,       ///< the caller's own mistake
    connection,  ///< no way to the device, or no answer
    refusal,     ///< the device said no
    nonsense,    ///< the device's answer makes no sense
};
[[nodiscard]] Trouble trouble_of(const error_code& error);

}  // namespace servobus::scanner

template <>
struct boost::system::is_error_code_enum<servobus::scanner::Error> : std::true_type {};
