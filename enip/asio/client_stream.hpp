// A TCP connection to a target: encapsulation messages out, encapsulation messages in.
#pragma once

#include <boost/system/error_code.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "cip/bytes.hpp"
#include "enip/asio/asio.hpp"
#include "enip/endpoint.hpp"
#include "enip/frame_decoder.hpp"

namespace servobus::enip::asio {

/// Not for several threads: all calls come from its executor, which is a strand or a context with one thread. After
/// close() nothing is called any more.
class ClientStream : public std::enable_shared_from_this<ClientStream> {
public:
    struct Events {
        std::function<void(FrameDecoder::Result)> frame;
        /// What came in is no encapsulation message: the peer speaks another protocol. The stream is closed.
        std::function<void()> foreign;
        /// The connection has ended: eof when the peer closed it, and whether that was in the middle of a message. The
        /// stream is closed.
        std::function<void(boost::system::error_code, bool in_message)> closed;
    };
    using Connected = std::function<void(boost::system::error_code)>;

    [[nodiscard]] static std::shared_ptr<ClientStream> create(const net::any_io_executor& executor);

    /// Finds the host and connects to the first of its addresses that answers. Then frames are read.
    void connect(const std::string& host, std::uint16_t port, Events events, Connected connected);

    void send(const Frame& frame);

    /// Both ends of the TCP connection; zeros when there is none, or none over IPv4.
    [[nodiscard]] Endpoint local() const;
    [[nodiscard]] Endpoint remote() const;

    /// Closes when everything is sent, and calls `done`.
    void finish(std::function<void()> done);

    void close();

private:
    explicit ClientStream(const net::any_io_executor& executor) : socket_(executor) {}

    void on_addresses(boost::system::error_code error, const std::vector<net::ip::tcp::endpoint>& addresses);
    void read();
    void on_octets(std::size_t count);
    [[nodiscard]] bool begins_like_a_frame(cip::ByteView octets);
    void write();
    void end(boost::system::error_code error);

    net::ip::tcp::socket socket_;
    std::function<void()> abandon_lookup_;
    Connected connected_;
    Events events_;
    bool open_ = true;

    FrameDecoder decoder_;
    cip::Bytes first_octets_;  ///< of the message that comes in, at most the command's two
    cip::Bytes incoming_ = cip::Bytes(4096);
    cip::Bytes outgoing_;
    cip::Bytes writing_;
    std::function<void()> finished_;
};

}  // namespace servobus::enip::asio
