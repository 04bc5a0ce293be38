// A TCP connection for whoever puts a peer to the test: any octets go out, whole messages come in. Blocking, and never
// beyond the time that is given.
#pragma once

#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "cip/bytes.hpp"
#include "enip/encapsulation.hpp"
#include "enip/endpoint.hpp"

namespace servobus::enip::asio {

class RawStream {
public:
    RawStream();
    RawStream(RawStream&& other) noexcept;
    RawStream& operator=(RawStream&& other) noexcept;
    ~RawStream();

    [[nodiscard]] boost::system::error_code connect(const std::string& host, std::uint16_t port,
                                                    std::chrono::milliseconds patience);
    [[nodiscard]] bool is_open() const;

    /// All of it, or an error: timed_out when the peer has taken too little, otherwise the connection is over.
    [[nodiscard]] boost::system::error_code send(cip::ByteView octets, std::chrono::milliseconds patience);

    enum class Event : std::uint8_t {
        message,  ///< in `frame`
        silence,  ///< nothing whole in time
        closed,   ///< by the peer, or reset; is_open() is false from then on
    };
    struct Received {
        Event event = Event::silence;
        Frame frame{};
        cip::Bytes rest{};  ///< of a message that has begun when the connection is closed
    };
    [[nodiscard]] Received receive(std::chrono::milliseconds patience);

    /// In good manners, and in the way of a peer that crashes: with a reset.
    void close();
    void reset();

    /// Both ends; zeros when there is no connection, or none over IPv4.
    [[nodiscard]] Endpoint local() const;
    [[nodiscard]] Endpoint remote() const;

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace servobus::enip::asio
