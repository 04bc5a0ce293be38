#include "tests/scanner/fake_server.hpp"

#include <gtest/gtest.h>

#include "cip/hex.hpp"

namespace servobus::scanner::test {

using boost::system::error_code;

void Peer::send(const cip::Bytes& octets) {
    error_code ignored;
    net::write(socket_, net::buffer(octets), ignored);
}

void Peer::trickle(cip::Bytes octets, std::chrono::milliseconds pause) {
    if (octets.empty()) return;
    send(cip::Bytes{octets.front()});
    octets.erase(octets.begin());
    timer_.expires_after(pause);
    timer_.async_wait([self = shared_from_this(), octets = std::move(octets), pause](error_code error) mutable {
        if (!error) self->trickle(std::move(octets), pause);
    });
}

void Peer::close() {
    error_code ignored;
    timer_.cancel();
    socket_.shutdown(net::ip::tcp::socket::shutdown_both, ignored);
    socket_.close(ignored);
}

FakeServer::FakeServer(Script script)
    : script_(std::move(script)), acceptor_(context_, {net::ip::address_v4::loopback(), 0}) {
    port_ = acceptor_.local_endpoint().port();
    accept();
    thread_ = std::thread([this] { context_.run(); });
}

FakeServer::~FakeServer() {
    net::post(context_, [this] {
        acceptor_.close();
        for (const auto& weak : peers_) {
            if (const auto peer = weak.lock()) peer->close();
        }
    });
    thread_.join();
}

void FakeServer::accept() {
    acceptor_.async_accept([this](error_code error, net::ip::tcp::socket socket) {
        if (error) return;
        const auto peer = std::make_shared<Peer>(std::move(socket));
        peers_.push_back(peer);
        read(peer);
        accept();
    });
}

void FakeServer::read(const std::shared_ptr<Peer>& peer) {
    peer->socket_.async_read_some(net::buffer(peer->incoming_), [this, peer](error_code error, std::size_t count) {
        if (error) return;
        cip::ByteView octets(peer->incoming_.data(), count);
        while (!octets.empty()) {
            auto result = peer->decoder_.next(octets);
            if (!result) continue;
            {
                const std::lock_guard lock(mutex_);
                seen_.push_back(result->frame);
            }
            script_(*peer, result->frame);
        }
        if (peer->socket_.is_open()) read(peer);
    });
}

std::vector<enip::Frame> FakeServer::seen() const {
    const std::lock_guard lock(mutex_);
    return seen_;
}

std::vector<enip::Command> FakeServer::commands() const {
    std::vector<enip::Command> commands;
    for (const auto& frame : seen()) commands.push_back(frame.command);
    return commands;
}

enip::Frame registered(const enip::Frame& request) {
    auto reply = request.reply(enip::EncapsulationStatus::success, enip::RegisterSession{}.encode());
    reply.session = fake_session;
    return reply;
}

cip::Request request_in(const enip::Frame& frame) {
    const auto data = enip::SendData::parse(frame.data);
    EXPECT_TRUE(data.has_value());
    const auto message = enip::unconnected_message(*data);
    EXPECT_TRUE(message.has_value());
    auto request = cip::Request::parse(*message);
    EXPECT_TRUE(request.has_value());
    return *request;
}

enip::Frame reply_with(const enip::Frame& request, cip::Bytes message) {
    return request.reply(enip::EncapsulationStatus::success, enip::SendData::unconnected(std::move(message)).encode());
}

enip::Frame reply_with(const enip::Frame& request, const cip::Response& response) {
    return reply_with(request, response.encode());
}

FakeServer::Script after_registration(FakeServer::Script then) {
    return [then = std::move(then)](Peer& peer, const enip::Frame& frame) {
        if (frame.command == enip::Command::register_session) {
            peer.send(registered(frame));
        } else if (frame.command == enip::Command::unregister_session) {
            peer.close();
        } else {
            then(peer, frame);
        }
    };
}

FakeServer::Script answering(std::function<cip::Response(const cip::Request&)> answer) {
    return after_registration([answer = std::move(answer)](Peer& peer, const enip::Frame& frame) {
        peer.send(reply_with(frame, answer(request_in(frame))));
    });
}

cip::Bytes hex(std::string_view text) {
    auto octets = cip::from_hex(text);
    EXPECT_TRUE(octets.has_value()) << text;
    return octets.value_or(cip::Bytes{});
}

}  // namespace servobus::scanner::test
