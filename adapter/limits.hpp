// What one device holds at most. Every resource that a peer can use has a number here.
#pragma once

#include <chrono>
#include <cstddef>

#include "cip/object.hpp"
#include "enip/encapsulation.hpp"

namespace servobus::adapter {

struct Limits {
    /// TCP connections that are served. A newcomer past this takes the place of the connection without a session that
    /// has been silent longest; when all have sessions, its first request is answered with encapsulation status 0x0002
    /// and it is closed (R-ENC-26).
    std::size_t tcp_connections = 192;
    /// Registered sessions; the next RegisterSession is answered 0x0002.
    std::size_t sessions = 128;
    /// Newcomers past tcp_connections that wait for their refusal; one more takes the place of the oldest.
    std::size_t refusals = 32;
    /// How long a newcomer past the limit may take to send the request that is refused.
    std::chrono::milliseconds refusal_patience{1000};
    /// Class 3 connections of the whole device.
    std::size_t class3_connections = 128;
    /// Class 1 connections of those who only look on; beside them there is one owner (R-CON-48).
    std::size_t listening_connections = 8;
    /// Octets of replies that may wait on one TCP connection before no more of its requests are read.
    std::size_t queued_bytes = std::size_t{64} * 1024;
    /// Messages of one TCP connection that are answered before others have their turn.
    std::size_t messages_per_turn = 16;
    /// Data portion of one encapsulation message.
    std::size_t frame_data_bytes = enip::max_data_bytes;
    /// Message router message, in and out.
    std::size_t message_bytes = cip::max_message_bytes;
    /// Broadcast ListIdentity replies that wait for their random delay (R-ENC-15).
    std::size_t delayed_replies = 64;
    /// A TCP connection without a message for this long is closed; zero: never (R-ENC-24). Where 0xF5/1/13 starts.
    std::chrono::seconds inactivity{120};
};

}  // namespace servobus::adapter
