// A target on loopback that does what a test tells it to, right or wrong.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "cip/message.hpp"
#include "enip/asio/asio.hpp"
#include "enip/encapsulation.hpp"
#include "enip/frame_decoder.hpp"
#include "enip/messages.hpp"

namespace servobus::scanner::test {

/// One connection to the server; used in its thread only.
class Peer : public std::enable_shared_from_this<Peer> {
public:
    explicit Peer(net::ip::tcp::socket socket) : socket_(std::move(socket)), timer_(socket_.get_executor()) {}

    void send(const cip::Bytes& octets);
    void send(const enip::Frame& frame) { send(frame.encode()); }
    /// One octet every millisecond, or every `pause`.
    void trickle(cip::Bytes octets, std::chrono::milliseconds pause = std::chrono::milliseconds(1));
    void close();

    std::vector<enip::Frame> kept;  ///< for scripts that answer later
    int count = 0;                  ///< for scripts that count

private:
    friend class FakeServer;
    net::ip::tcp::socket socket_;
    net::steady_timer timer_;
    enip::FrameDecoder decoder_;
    std::array<std::uint8_t, 4096> incoming_{};
};

class FakeServer {
public:
    /// Called for every frame, in the server's thread.
    using Script = std::function<void(Peer&, const enip::Frame&)>;

    explicit FakeServer(Script script);
    ~FakeServer();
    FakeServer(const FakeServer&) = delete;
    FakeServer& operator=(const FakeServer&) = delete;

    [[nodiscard]] std::uint16_t port() const { return port_; }
    [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
    /// Every frame so far.
    [[nodiscard]] std::vector<enip::Frame> seen() const;
    /// The commands of these frames.
    [[nodiscard]] std::vector<enip::Command> commands() const;

private:
    void accept();
    void read(const std::shared_ptr<Peer>& peer);

    Script script_;
    net::io_context context_{1};
    net::ip::tcp::acceptor acceptor_;
    std::uint16_t port_ = 0;
    std::vector<std::weak_ptr<Peer>> peers_;
    mutable std::mutex mutex_;
    std::vector<enip::Frame> seen_;
    std::thread thread_;
};

inline constexpr std::uint32_t fake_session = 0x00010203;

/// A reply to RegisterSession.
[[nodiscard]] enip::Frame registered(const enip::Frame& request);
/// The CIP request in a SendRRData.
[[nodiscard]] cip::Request request_in(const enip::Frame& frame);
/// A SendRRData reply with these octets in its data item.
[[nodiscard]] enip::Frame reply_with(const enip::Frame& request, cip::Bytes message);
[[nodiscard]] enip::Frame reply_with(const enip::Frame& request, const cip::Response& response);

/// Registers sessions, and answers every request as `answer` says.
[[nodiscard]] FakeServer::Script answering(std::function<cip::Response(const cip::Request&)> answer);
/// Registers sessions, and leaves SendRRData and SendUnitData to `then`.
[[nodiscard]] FakeServer::Script after_registration(FakeServer::Script then);

/// `1E 00 …`; fails the test when it is no hex.
[[nodiscard]] cip::Bytes hex(std::string_view text);

}  // namespace servobus::scanner::test
