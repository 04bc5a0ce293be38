#include "tests/bench/io/explicit_client.hpp"

#include "cip/multiple_service.hpp"
#include "cip/services.hpp"
#include "enip/encapsulation.hpp"
#include "enip/messages.hpp"
#include "tests/bench/io/image.hpp"

namespace servobus::bench {
namespace {

constexpr Nanoseconds patience = 10 * second;

Descriptor connect_patiently(enip::Endpoint peer, std::uint32_t local_address) {
    const auto end = monotonic() + patience;
    while (true) {
        if (auto socket = tcp_connect(peer, local_address); socket.number() >= 0) return socket;
        if (monotonic() > end) give_up("nobody listens at " + to_string(peer));
        sleep_until(monotonic() + second / 1000);
    }
}

}  // namespace

ExplicitClient::ExplicitClient(enip::Endpoint peer, std::uint32_t local_address)
    : socket_(connect_patiently(peer, local_address)) {
    const enip::Frame request{.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()};
    session_ = get32(exchange(request.encode()), 4);
}

cip::Bytes ExplicitClient::frame(const cip::Request& request) const {
    return enip::Frame{.command = enip::Command::send_rr_data,
                       .session = session_,
                       .data = enip::SendData::unconnected(request.encode()).encode()}
        .encode();
}

const cip::Bytes& ExplicitClient::exchange(const cip::Bytes& frame) {
    send_all(socket_, frame);
    reply_.resize(enip::header_bytes);
    if (!receive_all(socket_, reply_)) give_up("the session was closed");
    const auto length = get32(reply_, 0) >> 16;
    reply_.resize(enip::header_bytes + length);
    if (!receive_all(socket_, std::span(reply_).subspan(enip::header_bytes))) give_up("the session was closed");
    return reply_;
}

cip::Response ExplicitClient::call(const cip::Request& request) {
    const auto reply = enip::Frame::parse(exchange(frame(request)));
    if (!reply || reply->status != enip::EncapsulationStatus::success) give_up("a request was refused");
    const auto data = enip::SendData::parse(reply->data);
    if (!data) give_up("a reply makes no sense");
    const auto message = enip::unconnected_message(*data);
    if (!message) give_up("a reply has no message");
    const auto response = cip::Response::parse(*message);
    if (!response) give_up("a reply makes no sense");
    return *response;
}

cip::Bytes ExplicitClient::connected_frame(const cip::Request& request) {
    cip::ForwardOpen open;
    open.triad = new_triad();
    open.t_to_o_id = 0xBF000000 + open.triad.serial_number;
    open.timeout_multiplier = 7;
    open.o_to_t_rpi = open.t_to_o_rpi = 1'000'000;
    open.o_to_t = open.t_to_o = {.variable = true, .size = 500};
    open.transport = {.server = true, .trigger = 2, .transport_class = 3};
    open.path = cip::Path::to(cip::class_id::message_router, 1).encode();
    const auto response = call({.service = cip::service::forward_open,
                                .path = cip::Path::to(cip::class_id::connection_manager, 1),
                                .data = open.encode()});
    if (!response.status.ok()) give_up("the Forward_Open is refused: " + describe(response.status));
    const auto reply = cip::ForwardOpenReply::parse(response.data);
    if (!reply) give_up("the reply to the Forward_Open makes no sense");
    return enip::Frame{.command = enip::Command::send_unit_data,
                       .session = session_,
                       .data = enip::SendData::connected(reply->o_to_t_id, 0, request.encode()).encode()}
        .encode();
}

cip::ConnectionTriad new_triad() {
    static std::uint16_t serial = 0;
    return {.serial_number = ++serial,
            .originator_vendor = 0xFFFF,
            .originator_serial = static_cast<std::uint32_t>(monotonic())};
}

cip::Request read_position() {
    return {.service = cip::service::get_attribute_single, .path = cip::Path::to(0x66, 1, 0x24), .data = {}};
}

cip::Request read_positions(std::size_t count) {
    if (count == 1) return read_position();
    const std::vector<cip::Bytes> parts(count, read_position().encode());
    return {.service = cip::service::multiple_service_packet,
            .path = cip::Path::to(cip::class_id::message_router, 1),
            .data = cip::write_parts(parts)};
}

}  // namespace servobus::bench
