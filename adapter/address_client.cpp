#include "adapter/address_client.hpp"

#include <algorithm>
#include <limits>

#include "adapter/usable_address.hpp"

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;

constexpr std::chrono::milliseconds first_interval = 4s;
constexpr std::chrono::milliseconds longest_interval = 64s;
constexpr std::chrono::milliseconds jitter = 1s;

// What attribute 5 can hold (R-TCP-6).
constexpr std::size_t longest_domain = 48;

// The first router that is in the subnet: another one could not be reached.
std::uint32_t gateway_in(const InterfaceConfiguration& configuration, const std::vector<std::uint32_t>& routers) {
    for (const auto router : routers) {
        auto with = configuration;
        with.gateway = router;
        if (is_usable(with)) return router;
    }
    return 0;
}

}  // namespace

std::optional<AddressClient::Event> AddressClient::on_frame(const enip::HeardFrame& frame, enip::Time now) {
    const auto datagram = UdpFrame::parse(frame.octets, frame.checksummed);
    if (!datagram) return count(&IgnoredReplies::malformed);
    if (datagram->destination.port != dhcp_client_port) return std::nullopt;
    return on_datagram(*datagram, now);
}

std::optional<AddressClient::Event> AddressClient::on_datagram(const UdpFrame& frame, enip::Time now) {
    const auto reply = DhcpMessage::parse(frame.payload);
    if (!reply || reply->operation != DhcpMessage::Operation::reply) return count(&IgnoredReplies::malformed);
    if (reply->transaction != transaction_ || reply->client_mac != own_) return count(&IgnoredReplies::foreign);
    return on_reply(*reply, frame, now);
}

void AddressClient::begin_transaction(enip::Time now) {
    transaction_ = static_cast<std::uint32_t>(random_());
    began_ = now;
    asked_ = 0;
    name_sent_ = host_name_;
}

DhcpMessage AddressClient::request(enip::Time now) const {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now - began_).count();
    DhcpMessage message{.transaction = transaction_, .client_mac = own_};
    message.seconds =
        static_cast<std::uint16_t>(std::min<std::int64_t>(seconds, std::numeric_limits<std::uint16_t>::max()));
    if (!name_sent_.empty()) message.add(DhcpOption::host_name, name_sent_);
    return message;
}

void AddressClient::send_to_all(const DhcpMessage& message, std::uint32_t source) {
    send(message, source, broadcast_mac, broadcast_address);
}

void AddressClient::send(const DhcpMessage& message, std::uint32_t source, const MacAddress& mac,
                         std::uint32_t destination) {
    const auto payload = message.encode();
    frames_.push_back(UdpFrame{.destination_mac = mac,
                               .source_mac = own_,
                               .source = {source, dhcp_client_port},
                               .destination = {destination, dhcp_server_port},
                               .payload = payload}
                          .encode());
}

std::chrono::milliseconds AddressClient::next_interval() {
    constexpr int doublings = 4;  // from the first interval to the longest
    const auto interval = std::min(longest_interval, first_interval * (1 << std::min(asked_, doublings)));
    ++asked_;
    std::uniform_int_distribution<std::int64_t> by_chance(-jitter.count(), jitter.count());
    return interval + std::chrono::milliseconds(by_chance(random_));
}

std::optional<InterfaceConfiguration> AddressClient::configuration_of(const DhcpMessage& reply) {
    InterfaceConfiguration configuration;
    configuration.address = reply.your_address;
    configuration.mask = reply.number(DhcpOption::subnet_mask).value_or(natural_mask(reply.your_address));
    if (!is_usable(configuration)) return count(&IgnoredReplies::illegal);
    configuration.gateway = gateway_in(configuration, reply.addresses(DhcpOption::router));
    const auto servers = reply.addresses(DhcpOption::name_server);
    if (!servers.empty()) configuration.name_server_1 = servers[0];
    if (servers.size() > 1) configuration.name_server_2 = servers[1];
    if (auto domain = reply.text(DhcpOption::domain_name); domain.size() <= longest_domain) {
        configuration.domain = std::move(domain);
    }
    return configuration;
}

}  // namespace servobus::adapter
