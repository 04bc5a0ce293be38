#include "adapter/bootp_client.hpp"

#include <utility>

namespace servobus::adapter {

void BootpClient::start(enip::Time now) { wait(std::chrono::milliseconds(0), now); }

void BootpClient::stop() {
    due_.reset();
    granted_ = {};
}

// BOOTP has no word for it: the server's table has to be mended.
void BootpClient::decline(std::chrono::seconds pause, enip::Time now) { wait(pause, now); }

void BootpClient::wait(std::chrono::milliseconds pause, enip::Time now) {
    stop();
    due_ = now + pause;
    begin_transaction(*due_);
}

std::optional<AddressClient::Event> BootpClient::on_timer(enip::Time now) {
    if (!due_ || now < *due_) return std::nullopt;
    send_to_all(request(now));
    due_ = now + next_interval();
    return std::nullopt;
}

// A message type would make it DHCP, which grants nothing that was not asked for.
std::optional<AddressClient::Event> BootpClient::on_reply(const DhcpMessage& reply, const UdpFrame&, enip::Time) {
    if (!due_ || reply.has(DhcpOption::message_type)) return count(&IgnoredReplies::unexpected);
    auto configuration = configuration_of(reply);
    if (!configuration) return std::nullopt;
    granted_ = *std::move(configuration);
    due_.reset();
    return Event::granted;
}

}  // namespace servobus::adapter
