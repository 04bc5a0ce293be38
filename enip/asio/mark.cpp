#include "enip/asio/mark.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

namespace servobus::enip::asio {

void mark(int socket, std::uint8_t dscp) {
    const int type_of_service = dscp << 2;
    static_cast<void>(::setsockopt(socket, IPPROTO_IP, IP_TOS, &type_of_service, sizeof type_of_service));
}

}  // namespace servobus::enip::asio
