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

}  // namespace

IoCapture::IoCapture(std::ostream& out, std::uint16_t port) : out_(out), writer_(out), port_(port) {}

CaptureTime IoCapture::time_of(enip::Time time) const {
    return calendar_start_ + std::chrono::duration_cast<std::chrono::nanoseconds>(time - start_);
}

void IoCapture::exchange(const IoOpened& opened, const cip::Request& request, const cip::Response& response) {
    const auto time = time_of(std::chrono::steady_clock::now());
    const enip::Endpoint target{opened.target.address, port_};
    const auto frame = [](const cip::Bytes& message) {
        enip::Frame made;
        made.command = enip::Command::send_rr_data;
        made.session = session;
        made.data = enip::SendData::unconnected(message).encode();
        return made.encode();
    };
    writer_.tcp(opened.local, target, frame(request.encode()), time);
    writer_.tcp(target, opened.local, frame(response.encode()), time);
}

void IoCapture::opened(const IoOpened& opened) {
    opened_ = opened;
    const auto service = opened.request.large ? cip::service::large_forward_open : cip::service::forward_open;
    exchange(opened, {service, connection_manager(), opened.request.encode()}, {service, {}, opened.reply.encode()});
}

void IoCapture::packet(const IoPacketSeen& seen) {
    writer_.udp(seen.source, seen.destination, seen.octets, time_of(seen.time));
}

void IoCapture::closed(const IoClosed& closed, const std::string&) {
    if (!opened_) return;
    if (closed.reason == CloseReason::asked && !closed.error && closed.status.ok()) {
        exchange(*opened_, close_request(opened_->request),
                 {cip::service::forward_close, {}, cip::ForwardCloseReply{opened_->request.triad, {}}.encode()});
    }
    writer_.tcp_close(opened_->local, {opened_->target.address, port_}, time_of(std::chrono::steady_clock::now()));
    opened_.reset();
    out_.flush();
}

}  // namespace servobus::scanner::cli
