#include "scanner/cli/io_capture.hpp"

#include "cip/services.hpp"
#include "enip/encapsulation.hpp"
#include "enip/messages.hpp"

namespace servobus::scanner::cli {
namespace {

/// The session's real number is nobody's business, and no analyser asks for it.
constexpr std::uint32_t session = 1;

const cip::Path& connection_manager() {
    static const auto path = cip::Path::to(cip::class_id::connection_manager, 1);
    return path;
}

/// As the originator makes it: of the whole path, without hops (R-CON-34).
cip::Request close_request(const cip::ForwardOpen& open) {
    cip::ForwardClose close;
    close.triad = open.triad;
    close.path = open.path;
    return {cip::service::forward_close, connection_manager(), close.encode()};
}

enip::Item socket_item(enip::ItemType type, enip::Endpoint endpoint) {
    return {type, enip::SocketAddress{.port = endpoint.port, .address = endpoint.address}.encode()};
}

/// Without them nobody could tell where the data of this connection goes (R-CPF-8).
IoCapture::SocketItems socket_items(const IoOpened& opened) {
    using enip::ItemType;
    IoCapture::SocketItems items;
    const bool multicast = enip::is_multicast(opened.receiver.address);
    if (multicast) items.reply.push_back(socket_item(ItemType::sockaddr_t_to_o, opened.receiver));
    if (!multicast && opened.receiver.port != enip::io_port) {
        items.request.push_back(socket_item(ItemType::sockaddr_t_to_o, {0, opened.receiver.port}));
    }
    if (opened.target.port != enip::io_port) {
        items.reply.push_back(socket_item(ItemType::sockaddr_o_to_t, {0, opened.target.port}));
    }
    return items;
}

}  // namespace

IoCapture::IoCapture(std::ostream& out, std::uint16_t port) : out_(out), writer_(out), port_(port) {}

CaptureTime IoCapture::time_of(enip::Time time) const {
    return calendar_start_ + std::chrono::duration_cast<std::chrono::nanoseconds>(time - start_);
}

void IoCapture::exchange(const IoOpened& opened, const cip::Request& request, const cip::Response& response,
                         const SocketItems& items) {
    const auto time = time_of(std::chrono::steady_clock::now());
    const enip::Endpoint target{opened.target.address, port_};
    const auto frame = [](const cip::Bytes& message, const std::vector<enip::Item>& beside) {
        enip::Frame made;
        made.command = enip::Command::send_rr_data;
        made.session = session;
        auto data = enip::SendData::unconnected(message);
        data.packet.items.insert(data.packet.items.end(), beside.begin(), beside.end());
        made.data = data.encode();
        return made.encode();
    };
    writer_.tcp(opened.local, target, frame(request.encode(), items.request), time);
    writer_.tcp(target, opened.local, frame(response.encode(), items.reply), time);
}

void IoCapture::opened(const IoOpened& opened) {
    opened_ = opened;
    const auto service = opened.request.large ? cip::service::large_forward_open : cip::service::forward_open;
    exchange(opened, {service, connection_manager(), opened.request.encode()}, {service, {}, opened.reply.encode()},
             socket_items(opened));
}

void IoCapture::packet(const IoPacketSeen& seen) {
    writer_.udp(seen.source, seen.destination, seen.octets, time_of(seen.time));
}

void IoCapture::closed(const IoClosed& closed, const std::string&) {
    if (!opened_) return;
    if (closed.reason == CloseReason::asked && !closed.error && closed.status.ok()) {
        exchange(*opened_, close_request(opened_->request),
                 {cip::service::forward_close, {}, cip::ForwardCloseReply{opened_->request.triad, {}}.encode()}, {});
    }
    writer_.tcp_close(opened_->local, {opened_->target.address, port_}, time_of(std::chrono::steady_clock::now()));
    opened_.reset();
    out_.flush();
}

}  // namespace servobus::scanner::cli
