// Our adapter behind a liar: requests, replies and datagrams pass through something that alters them, so that a device is
// wrong in exactly one way.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "adapter/adapter.hpp"
#include "cip/message.hpp"
#include "drive/device.hpp"
#include "drive/xenax.hpp"
#include "enip/asio/target_server.hpp"
#include "enip/encapsulation.hpp"
#include "enip/frame_decoder.hpp"
#include "enip/target.hpp"

namespace servobus::test {

/// What becomes of a request before the adapter sees it.
struct Fate {
    enum class Kind : std::uint8_t { pass, drop, answer, close, die };
    Kind kind = Kind::pass;
    enip::Frame reply{};  ///< with `answer`: instead of the adapter's
};

/// One way of being wrong. What is not given does nothing.
struct Vice {
    std::function<Fate(enip::Frame& request)> on_request{};
    std::function<void(const enip::Frame& request, enip::Frame& reply)> on_reply{};
    std::function<void(enip::Frame& reply)> on_udp_reply{};
    std::function<void(cip::Bytes& datagram)> on_input{};        ///< T->O
    std::function<void(enip::IoRoute& route)> on_input_route{};  ///< of T->O
    std::function<void(cip::Bytes& datagram)> on_output{};       ///< O->T
    std::function<bool(cip::ByteView octets)> on_octets{};       ///< false: it dies of them
};

class BadTarget final : public enip::Target {
public:
    BadTarget(enip::Target& inner, Vice vice) : inner_(inner), vice_(std::move(vice)) {}

    std::optional<ConnectionId> on_open(enip::Endpoint peer, enip::Endpoint local, enip::Time now) override;
    std::size_t on_octets(ConnectionId id, cip::ByteView octets, enip::Time now) override;
    cip::Bytes take_replies(ConnectionId id) override;
    bool wants_close(ConnectionId id) const override;
    void on_closed(ConnectionId id, enip::Time now) override;
    void on_datagram(enip::Endpoint peer, enip::Endpoint local, bool broadcast, cip::ByteView octets,
                     enip::Time now) override;
    std::vector<enip::Datagram> take_datagrams() override;
    void on_io(enip::Endpoint peer, enip::Endpoint local, cip::ByteView octets, enip::Time now) override;
    enip::IoQueue& io_queue() override;
    void on_timer(enip::Time now) override { inner_.on_timer(now); }
    std::optional<enip::Time> next_deadline() const override { return inner_.next_deadline(); }
    void on_day_clock(std::chrono::nanoseconds ahead) override { inner_.on_day_clock(ahead); }
    std::vector<ConnectionId> take_expired() override { return inner_.take_expired(); }
    std::vector<ConnectionId> take_ready() override { return inner_.take_ready(); }

private:
    struct Stream {
        enip::FrameDecoder decoder{0xFFFF};
        std::map<enip::SenderContext, enip::Frame> requests;  ///< as they came
        cip::Bytes replies;
        bool closing = false;
    };

    void take(ConnectionId id, Stream& stream, enip::Frame request, enip::Time now);
    void pass(ConnectionId id, Stream& stream, const enip::Frame& request, enip::Time now);
    void collect(ConnectionId id, Stream& stream);

    enip::Target& inner_;
    Vice vice_;
    std::map<ConnectionId, Stream> streams_;
    enip::IoQueue queue_;
    bool dead_ = false;
};

/// Serves it at a loopback address of its own, until it goes.
class BadServer {
public:
    explicit BadServer(Vice vice);
    ~BadServer();
    BadServer(const BadServer&) = delete;
    BadServer& operator=(const BadServer&) = delete;

    const std::string& host() const { return host_; }

private:
    std::string host_;
    drive::Device device_{drive::xenax_models().front()};
    std::unique_ptr<adapter::Adapter> adapter_;
    std::unique_ptr<BadTarget> target_;
    std::unique_ptr<enip::asio::TargetServer> server_;
    std::thread thread_;
};

// What vices are made of.

/// The CIP request in a SendRRData, or over a connection; nullopt when there is none.
std::optional<cip::Request> request_in(const enip::Frame& frame);
/// The same frame with another request, or another reply, in it.
void put_request(enip::Frame& frame, const cip::Request& request);
std::optional<cip::Response> reply_in(const enip::Frame& frame);
void put_reply(enip::Frame& frame, const cip::Response& response);
/// The reply of the adapter to that service of that class is altered.
Vice altering(std::uint16_t class_id, std::uint8_t service, std::function<void(cip::Response&)> change);
/// The request is altered before the adapter sees it.
Vice requesting(std::uint16_t class_id, std::uint8_t service, std::function<void(cip::Request&)> change);
/// Class, instance and attribute of a request; zeros for what is not there.
std::array<std::uint32_t, 3> place_of(const cip::Request& request);

}  // namespace servobus::test
