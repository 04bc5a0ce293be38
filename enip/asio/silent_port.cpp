#include "enip/asio/silent_port.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace servobus::enip::asio {
namespace {

void set_up(int socket, const std::string& interface, std::uint16_t port) {
    sock_filter nothing = BPF_STMT(BPF_RET | BPF_K, 0);
    sock_fprog program{};
    program.len = 1;
    program.filter = &nothing;
    const int on = 1;
    ::setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program);
    ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    ::setsockopt(socket, SOL_SOCKET, SO_BINDTODEVICE, interface.data(), static_cast<socklen_t>(interface.size()));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    // NOLINTNEXTLINE(*-reinterpret-cast): what the call takes
    static_cast<void>(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address));
}

}  // namespace

SilentPort::SilentPort(const std::string& interface, std::uint16_t port)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    if (socket_ >= 0) set_up(socket_, interface, port);
}

SilentPort::~SilentPort() {
    if (socket_ >= 0) ::close(socket_);
}

}  // namespace servobus::enip::asio
