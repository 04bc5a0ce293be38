#include "tests/adapter/tcp_client.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "cip/forward_open.hpp"
#include "cip/wire.hpp"
#include "enip/messages.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {
namespace {

using Clock = std::chrono::steady_clock;

bool wait_for(int descriptor, short events, Clock::time_point end) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    pollfd entry{descriptor, events, 0};
    return ::poll(&entry, 1, static_cast<int>(std::max<std::int64_t>(left, 0))) > 0;
}

void set_option(int descriptor, int level, int name, int value) {
    ::setsockopt(descriptor, level, name, &value, sizeof value);
}

}  // namespace

RunningServer::RunningServer(adapter::Limits limits, drive::Device device)
    : device_(std::move(device)), adapter_(device_, limits, 1), server_() {
    const auto listening = server_.listen(adapter_, {.port = 0});
    if (!listening) throw std::runtime_error(listening.error().reason);
    port_ = listening->local.port;
    thread_ = std::thread([this] { server_.run([this] { adapter_.shut_down(); }); });
}

RunningServer::~RunningServer() {
    server_.stop();
    thread_.join();
}

TcpClient::TcpClient(std::uint16_t port, int receive_buffer, std::uint32_t host)
    : descriptor_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0) set_option(descriptor_, SOL_SOCKET, SO_RCVBUF, receive_buffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(host);
    sockaddr generic{};
    static_assert(sizeof generic == sizeof address);
    std::memcpy(&generic, &address, sizeof address);
    if (descriptor_ >= 0 && ::connect(descriptor_, &generic, sizeof generic) != 0) close();
    set_option(descriptor_, IPPROTO_TCP, TCP_NODELAY, 1);
}

TcpClient::~TcpClient() { close(); }

TcpClient::TcpClient(TcpClient&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      session_(other.session_),
      connection_(other.connection_),
      sequence_(other.sequence_) {}

TcpClient& TcpClient::operator=(TcpClient&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    std::swap(session_, other.session_);
    std::swap(connection_, other.connection_);
    std::swap(sequence_, other.sequence_);
    return *this;
}

void TcpClient::close() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

void TcpClient::reset() {
    const linger at_once{1, 0};
    ::setsockopt(descriptor_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    close();
}

std::size_t TcpClient::send_some(cip::ByteView octets) const {
    const auto sent = ::send(descriptor_, octets.data(), octets.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    return sent > 0 ? static_cast<std::size_t>(sent) : 0;
}

bool TcpClient::send(cip::ByteView octets) const {
    const auto end = Clock::now() + patience;
    while (!octets.empty()) {
        const auto sent = ::send(descriptor_, octets.data(), octets.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent > 0) {
            octets = octets.subspan(static_cast<std::size_t>(sent));
        } else if (errno != EAGAIN || !wait_for(descriptor_, POLLOUT, end)) {
            return false;
        }
    }
    return true;
}

bool TcpClient::receive_exactly(std::uint8_t* octets, std::size_t count, Clock::time_point end) const {
    while (count > 0) {
        if (!wait_for(descriptor_, POLLIN, end)) return false;
        const auto size = ::recv(descriptor_, octets, count, 0);
        if (size <= 0) return false;
        octets += size;
        count -= static_cast<std::size_t>(size);
    }
    return true;
}

std::optional<enip::Frame> TcpClient::receive(std::chrono::milliseconds limit) const {
    const auto end = Clock::now() + limit;
    cip::Bytes octets(enip::header_bytes);
    if (!receive_exactly(octets.data(), octets.size(), end)) return std::nullopt;
    const auto length = static_cast<std::size_t>(octets[2] | octets[3] << 8);
    octets.resize(enip::header_bytes + length);
    if (!receive_exactly(octets.data() + enip::header_bytes, length, end)) return std::nullopt;
    const auto frame = enip::Frame::parse(octets);
    return frame ? std::optional(*frame) : std::nullopt;
}

bool TcpClient::closed_by_peer(std::chrono::milliseconds limit) const {
    const auto end = Clock::now() + limit;
    std::array<char, 4096> octets{};
    while (wait_for(descriptor_, POLLIN, end)) {
        if (::recv(descriptor_, octets.data(), octets.size(), 0) <= 0) return true;
    }
    return false;
}

bool TcpClient::register_session() {
    const enip::Frame request{.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()};
    if (!send(request.encode())) return false;
    const auto reply = receive();
    if (!reply || reply->status != enip::EncapsulationStatus::success) return false;
    session_ = reply->session;
    return true;
}

cip::Bytes TcpClient::call(cip::ByteView message) const {
    const auto data = enip::SendData::unconnected({message.begin(), message.end()}).encode();
    if (!send(enip::Frame{.command = enip::Command::send_rr_data, .session = session_, .data = data}.encode()))
        return {};
    const auto reply = receive();
    if (!reply || reply->status != enip::EncapsulationStatus::success) return {};
    const auto answer = enip::SendData::parse(reply->data);
    if (!answer) return {};
    const auto response = enip::unconnected_message(*answer);
    return response ? cip::Bytes(response->begin(), response->end()) : cip::Bytes{};
}

bool TcpClient::open_class3() {
    cip::ForwardOpen open;
    open.t_to_o_id = 0x80FE0001;
    open.triad = {1, 0x004D, 0x11223344};
    open.timeout_multiplier = 7;
    open.o_to_t_rpi = open.t_to_o_rpi = 1'000'000;
    open.o_to_t.size = open.t_to_o.size = 504;
    open.transport = {true, 2, 3};
    open.path = octets("20 02 24 01");
    const auto reply = call(cip::Request{0x54, cip::Path::to(6, 1), open.encode()}.encode());
    if (reply.size() < 8 || reply[2] != 0) return false;
    cip::Reader reader(cip::ByteView(reply).subspan(4));
    connection_ = reader.u32();
    return true;
}

cip::Bytes TcpClient::connected_call(cip::ByteView message) {
    const auto data = enip::SendData::connected(connection_, ++sequence_, message).encode();
    const enip::Frame request{.command = enip::Command::send_unit_data, .session = session_, .data = data};
    if (!send(request.encode())) return {};
    const auto reply = receive();
    if (!reply || reply->status != enip::EncapsulationStatus::success) return {};
    const auto answer = enip::SendData::parse(reply->data);
    if (!answer) return {};
    const auto response = enip::connected_message(*answer);
    if (!response || response->sequence != sequence_) return {};
    return {response->message.begin(), response->message.end()};
}

}  // namespace servobus::test
