// An I/O connection as a capture file: its datagrams as they went, and the Forward_Open and Forward_Close around them,
// so that an analyser knows what they are.
#pragma once

#include <optional>
#include <ostream>
#include <vector>

#include "enip/common_packet.hpp"
#include "scanner/cli/io_runner.hpp"
#include "scanner/pcapng.hpp"

namespace servobus::scanner::cli {

class IoCapture : public IoSink {
public:
    /// `port`: of the device, for TCP.
    IoCapture(std::ostream& out, std::uint16_t port);

    void opened(const IoOpened& opened) override;
    void packet(const IoPacketSeen& seen) override;
    void closed(const IoClosed& closed, const std::string& text) override;

    /// What goes beside a request and its reply.
    struct SocketItems {
        std::vector<enip::Item> request{};
        std::vector<enip::Item> reply{};
    };

private:
    [[nodiscard]] CaptureTime time_of(enip::Time time) const;
    void exchange(const IoOpened& opened, const cip::Request& request, const cip::Response& response,
                  const SocketItems& items);

    std::ostream& out_;
    PcapngWriter writer_;
    std::uint16_t port_;
    std::optional<IoOpened> opened_{};
    enip::Time start_ = std::chrono::steady_clock::now();
    CaptureTime calendar_start_ = std::chrono::system_clock::now();
};

}  // namespace servobus::scanner::cli
