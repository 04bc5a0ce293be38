// A UDP port that is heard otherwise, frame by frame: without a socket of its own the kernel would tell every sender that
// nobody is there.
#pragma once

#include <cstdint>
#include <string>

namespace servobus::enip::asio {

class SilentPort {
public:
    /// On one interface. Where it is not permitted, or the port is taken, the kernel answers as it would.
    SilentPort(const std::string& interface, std::uint16_t port);
    ~SilentPort();
    SilentPort(const SilentPort&) = delete;
    SilentPort& operator=(const SilentPort&) = delete;

private:
    int socket_;
};

}  // namespace servobus::enip::asio
