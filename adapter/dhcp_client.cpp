#include "adapter/dhcp_client.hpp"

#include <algorithm>
#include <utility>

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;

constexpr int requests_for_an_offer = 4;                   // RFC 2131, 3.1.5
constexpr std::chrono::milliseconds shortest_retry = 60s;  // of a renewal: RFC 2131, 4.4.5
constexpr std::uint32_t shortest_lease = 10;               // s; one that ends sooner is not worth its detection
constexpr std::chrono::milliseconds after_nak = 4s;
constexpr std::uint32_t for_ever = 0xFFFFFFFF;

const cip::Bytes wanted_options{
    static_cast<std::uint8_t>(DhcpOption::subnet_mask), static_cast<std::uint8_t>(DhcpOption::router),
    static_cast<std::uint8_t>(DhcpOption::name_server), static_cast<std::uint8_t>(DhcpOption::host_name),
    static_cast<std::uint8_t>(DhcpOption::domain_name)};

bool is_unicast(std::uint32_t address) {
    const auto first = address >> 24;
    return first != 0 && first != 127 && first < 224;
}

}  // namespace

void DhcpClient::start(enip::Time now) {
    stop();
    wait(0ms, now);
}

void DhcpClient::stop() {
    state_ = State::stopped;
    due_.reset();
    lease_.reset();
    granted_ = {};
}

void DhcpClient::confirm() {
    if (state_ != State::checking) return;
    state_ = State::bound;
    due_ = lease_ ? std::optional(lease_->renewal) : std::nullopt;
}

void DhcpClient::decline(std::chrono::seconds pause, enip::Time now) {
    if (state_ == State::stopped || granted_.address == 0) return;
    auto decline = message(DhcpType::decline, now);
    decline.options.erase(DhcpOption::host_name);
    decline.options.erase(DhcpOption::parameter_request_list);
    decline.add(DhcpOption::requested_address, granted_.address);
    decline.add(DhcpOption::server_identifier, server_.address);
    send_to_all(decline);
    wait(pause, now);
}

void DhcpClient::wait(std::chrono::milliseconds pause, enip::Time now) {
    stop();
    state_ = State::waiting;
    due_ = now + pause;
    begin_transaction(*due_);
}

std::optional<enip::Time> DhcpClient::next_deadline() const { return due_; }

std::optional<AddressClient::Event> DhcpClient::on_timer(enip::Time now) {
    if (!due_ || now < *due_) return std::nullopt;
    switch (state_) {
        case State::stopped:
        case State::checking:
            break;
        case State::waiting:
        case State::selecting:
            discover(now);
            break;
        case State::requesting:
            if (requests_ < requests_for_an_offer) {
                request_offer(now);
            } else {
                wait(0ms, now);
            }
            break;
        case State::bound:
            begin_transaction(now);
            renew(now);
            break;
        case State::renewing:
            now < lease_->rebinding ? renew(now) : rebind(now);
            break;
        case State::rebinding:
            if (now >= lease_->end) return lose(now);
            rebind(now);
            break;
    }
    return std::nullopt;
}

DhcpMessage DhcpClient::message(DhcpType type, enip::Time now) const {
    auto message = request(now);
    message.add(DhcpOption::message_type, cip::Bytes{static_cast<std::uint8_t>(type)});
    message.add(DhcpOption::parameter_request_list, wanted_options);
    cip::Bytes identifier{1};  // Ethernet
    identifier.insert(identifier.end(), own().begin(), own().end());
    message.add(DhcpOption::client_identifier, std::move(identifier));
    return message;
}

void DhcpClient::discover(enip::Time now) {
    state_ = State::selecting;
    send_to_all(message(DhcpType::discover, now));
    due_ = now + next_interval();
}

void DhcpClient::request_offer(enip::Time now) {
    state_ = State::requesting;
    auto request = message(DhcpType::request, now);
    request.add(DhcpOption::requested_address, offered_);
    request.add(DhcpOption::server_identifier, server_.address);
    send_to_all(request);
    requested_ = now;
    ++requests_;
    due_ = now + next_interval();
}

// Half of the time that is left, but not too often (RFC 2131, 4.4.5).
void DhcpClient::renew(enip::Time now) {
    state_ = State::renewing;
    auto request = message(DhcpType::request, now);
    request.client_address = granted_.address;
    send(request, granted_.address, server_.mac, server_.address);
    requested_ = now;
    const auto half = std::chrono::duration_cast<std::chrono::milliseconds>(lease_->rebinding - now) / 2;
    due_ = std::min(lease_->rebinding, now + std::max(half, shortest_retry));
}

void DhcpClient::rebind(enip::Time now) {
    state_ = State::rebinding;
    auto request = message(DhcpType::request, now);
    request.client_address = granted_.address;
    send_to_all(request, granted_.address);
    requested_ = now;
    const auto half = std::chrono::duration_cast<std::chrono::milliseconds>(lease_->end - now) / 2;
    due_ = std::min(lease_->end, now + std::max(half, shortest_retry));
}

std::optional<AddressClient::Event> DhcpClient::lose(enip::Time now) {
    wait(0ms, now);
    return Event::lost;
}

bool DhcpClient::has_lease() const {
    return state_ == State::bound || state_ == State::renewing || state_ == State::rebinding;
}

bool DhcpClient::waits_for_ack() const {
    return state_ == State::requesting || state_ == State::renewing || state_ == State::rebinding;
}

std::optional<AddressClient::Event> DhcpClient::on_reply(const DhcpMessage& reply, const UdpFrame& frame,
                                                         enip::Time now) {
    const auto type = reply.type();
    if (type == DhcpType::offer && state_ == State::selecting) return on_offer(reply, now);
    if (type == DhcpType::ack && waits_for_ack()) return on_ack(reply, frame);
    if (type == DhcpType::nak && waits_for_ack()) return on_nak(reply, now);
    return count(&IgnoredReplies::unexpected);
}

// The first one that will do.
std::optional<AddressClient::Event> DhcpClient::on_offer(const DhcpMessage& offer, enip::Time now) {
    const auto server = offer.number(DhcpOption::server_identifier);
    if (!server || !is_unicast(*server)) return count(&IgnoredReplies::illegal);
    if (!configuration_of(offer)) return std::nullopt;
    server_.address = *server;
    offered_ = offer.your_address;
    requests_ = 0;
    restart_intervals();
    request_offer(now);
    return std::nullopt;
}

std::optional<AddressClient::Event> DhcpClient::on_ack(const DhcpMessage& ack, const UdpFrame& frame) {
    const auto server = ack.number(DhcpOption::server_identifier);
    const bool any_server = state_ == State::rebinding;
    if (!server || !is_unicast(*server)) return count(&IgnoredReplies::illegal);
    if (!any_server && *server != server_.address) return count(&IgnoredReplies::unexpected);
    const auto seconds = ack.number(DhcpOption::lease_time).value_or(0);
    const auto wanted = state_ == State::requesting ? offered_ : granted_.address;
    if (ack.your_address != wanted || seconds < shortest_lease) return count(&IgnoredReplies::illegal);
    auto configuration = configuration_of(ack);
    if (!configuration) return std::nullopt;
    server_ = {*server, frame.source_mac};
    lease_ = lease_of(ack, seconds);
    const bool changed = granted_ != *configuration;
    granted_ = *std::move(configuration);
    const bool renewed = has_lease();
    state_ = State::checking;
    due_.reset();
    if (!renewed) return Event::granted;
    confirm();
    return changed ? std::optional(Event::changed) : std::nullopt;
}

// Half and seven eighths of the lease, unless the server has something better that makes sense (RFC 2131, 4.4.5).
std::optional<DhcpClient::Lease> DhcpClient::lease_of(const DhcpMessage& ack, std::uint32_t seconds) const {
    if (seconds == for_ever) return std::nullopt;
    const std::chrono::milliseconds length = std::chrono::seconds(seconds);
    std::chrono::milliseconds renewal = length / 2;
    std::chrono::milliseconds rebinding = length * 7 / 8;
    const auto t1 = ack.number(DhcpOption::renewal_time);
    const auto t2 = ack.number(DhcpOption::rebinding_time);
    const std::chrono::milliseconds wanted_renewal = t1 ? std::chrono::seconds(*t1) : renewal;
    const std::chrono::milliseconds wanted_rebinding = t2 ? std::chrono::seconds(*t2) : rebinding;
    if (wanted_renewal > 0ms && wanted_renewal <= wanted_rebinding && wanted_rebinding <= length) {
        renewal = wanted_renewal;
        rebinding = wanted_rebinding;
    }
    return Lease{requested_ + renewal, requested_ + rebinding, requested_ + length};
}

// From the server that was asked. Not asked again at once, or two machines would do nothing else.
std::optional<AddressClient::Event> DhcpClient::on_nak(const DhcpMessage& nak, enip::Time now) {
    const auto server = nak.number(DhcpOption::server_identifier);
    if (state_ != State::rebinding && server != server_.address) return count(&IgnoredReplies::unexpected);
    const bool had_lease = has_lease();
    wait(after_nak, now);
    return had_lease ? std::optional(Event::lost) : std::nullopt;
}

}  // namespace servobus::adapter
