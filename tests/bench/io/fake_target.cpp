#include "tests/bench/io/fake_target.hpp"

#include <sys/socket.h>

#include <arpa/inet.h>

#include "cip/forward_open.hpp"
#include "cip/services.hpp"
#include "enip/messages.hpp"
#include "tests/bench/io/image.hpp"

namespace servobus::bench {
namespace {

std::optional<enip::Frame> read_frame(const Descriptor& peer) {
    cip::Bytes octets(enip::header_bytes);
    if (!receive_all(peer, octets)) return std::nullopt;
    octets.resize(enip::header_bytes + (get32(octets, 0) >> 16));
    if (!receive_all(peer, std::span(octets).subspan(enip::header_bytes))) return std::nullopt;
    const auto frame = enip::Frame::parse(octets);
    return frame ? std::optional(*frame) : std::nullopt;
}

enip::Endpoint peer_of(const Descriptor& socket) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    ::getpeername(socket.number(), reinterpret_cast<sockaddr*>(&address), &size);
    return {ntohl(address.sin_addr.s_addr), enip::io_port};
}

}  // namespace

FakeTarget::FakeTarget(std::uint32_t address)
    : address_(address),
      receiver_({address, enip::io_port}),
      listener_(tcp_listener({address, enip::tcp_port})),
      thread_([this] {
          while (!stopped_) {
              if (const auto peer = tcp_accept(listener_); peer.number() >= 0 && !stopped_) serve(peer);
          }
      }) {}

FakeTarget::~FakeTarget() {
    stopped_ = true;
    static_cast<void>(tcp_connect({address_, enip::tcp_port}));  // So that accept() returns.
    thread_.join();
}

void FakeTarget::serve(const Descriptor& peer) {
    originator_ = peer_of(peer);
    while (const auto request = read_frame(peer)) {
        if (request->command == enip::Command::unregister_session) return;
        send_all(peer, answer(*request).encode());
    }
}

enip::Frame FakeTarget::answer(const enip::Frame& request) {
    if (request.command == enip::Command::register_session) {
        auto reply = request.reply(enip::EncapsulationStatus::success, request.data);
        reply.session = 1;
        return reply;
    }
    const auto data = enip::SendData::parse(request.data);
    if (!data) give_up("the originator sent something that makes no sense");
    // It may name the port that it receives at; otherwise that is the one of the standard.
    if (const auto* item = data->packet.find(enip::ItemType::sockaddr_t_to_o)) {
        if (const auto socket = enip::SocketAddress::parse(item->data)) originator_.port = socket->port;
    }
    const auto message = enip::unconnected_message(*data);
    const auto inner = message ? cip::Request::parse(*message) : cip::Decoded<cip::Request>(message.error());
    if (!inner) give_up("the originator sent a request that makes no sense");
    return request.reply(enip::EncapsulationStatus::success,
                         enip::SendData::unconnected(answer(*inner).encode()).encode());
}

cip::Response FakeTarget::answer(const cip::Request& request) {
    if (request.service == cip::service::forward_close) {
        sender_.reset();
        const auto close = cip::ForwardClose::parse(request.data);
        if (!close) give_up("the Forward_Close of the originator makes no sense");
        return {.service = request.service, .data = cip::ForwardCloseReply{close->triad, {}}.encode()};
    }
    const auto open = cip::ForwardOpen::parse(request.data, request.service == cip::service::large_forward_open);
    if (!open) give_up("the Forward_Open of the originator makes no sense");
    sender_.emplace(Child::in_role({"sender", to_string(enip::Endpoint{address_, 0}), to_string(originator_),
                                    std::to_string(open->t_to_o_rpi), std::to_string(open->t_to_o_id)}));
    const cip::ForwardOpenReply reply{.o_to_t_id = 0xFA4E0001,
                                      .t_to_o_id = open->t_to_o_id,
                                      .triad = open->triad,
                                      .o_to_t_api = open->o_to_t_rpi,
                                      .t_to_o_api = open->t_to_o_rpi,
                                      .application_reply = {}};
    return {.service = request.service, .data = reply.encode()};
}

}  // namespace servobus::bench
