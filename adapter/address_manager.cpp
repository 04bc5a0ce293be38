#include "adapter/address_manager.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "adapter/bootp_client.hpp"
#include "adapter/dhcp_client.hpp"
#include "adapter/ethernet_frame.hpp"
#include "adapter/usable_address.hpp"
#include "enip/endpoint.hpp"

namespace servobus::adapter {
namespace {

// A tag with this in it is for another network than that of the port.
constexpr std::uint16_t vlan_id = 0x0FFF;

constexpr std::size_t rival_mac_at = 1;  // in attribute 11 (R-TCP-10)

std::string text_of(const InterfaceConfiguration& configuration) {
    return fmt::format("{}/{}", enip::address_text(configuration.address), prefix_length(configuration.mask));
}

std::string rival_of(const LastConflict& conflict) {
    MacAddress mac{};
    std::copy_n(conflict.begin() + rival_mac_at, mac.size(), mac.begin());
    return to_string(mac);
}

std::string_view name_of(AddressMethod method) { return method == AddressMethod::bootp ? "BOOTP" : "DHCP"; }

}  // namespace

AddressManager::AddressManager(Network& network, std::uint64_t seed, Log log)
    : network_(network), log_(std::move(log)), random_(seed), detection_(network.state.mac, random_()) {
    drop();
}

AddressManager::~AddressManager() = default;

std::unique_ptr<AddressClient> AddressManager::client_of(AddressMethod method) {
    const auto& mac = network_.state.mac;
    const auto& host_name = network_.settings.host_name;
    switch (method) {
        case AddressMethod::stored:
            return nullptr;
        case AddressMethod::bootp:
            return std::make_unique<BootpClient>(mac, host_name, random_());
        case AddressMethod::dhcp:
            return std::make_unique<DhcpClient>(mac, host_name, random_());
    }
    return nullptr;
}

void AddressManager::restart() {
    detects_ = network_.settings.select_acd;
    detection_ = AddressConflictDetection(network_.state.mac, random_());
    detection_.on_link(link_up_, {});
    forget();
}

void AddressManager::change_address() { forget(); }

void AddressManager::forget() {
    drop();
    client_.reset();
    retry_.reset();
    const bool pending = network_.state.address.pending;
    network_.state.address = {.configured = false, .pending = pending};
    begins_ = true;
}

void AddressManager::begin(enip::Time now) {
    begins_ = false;
    const auto method = network_.settings.method;
    client_ = client_of(method);
    if (!client_) {
        begin_with_stored(now);
        return;
    }
    log_(LogLevel::info, fmt::format("an address is asked for by {}", name_of(method)));
    client_->start(now);
}

void AddressManager::begin_with_stored(enip::Time now) {
    const auto& stored = network_.settings.configured;
    if (stored.address == 0) {
        log_(LogLevel::warning, "no address is stored, and none is asked for");  // R-DHC-1
        return;
    }
    examine(stored, now);
}

// Attribute 3 was set to 0 while there is an address of a server: it stays, and nobody is asked again (R-TCP-4).
void AddressManager::follow_settings() {
    if (!client_ || network_.settings.method != AddressMethod::stored) return;
    client_.reset();
    if (in_use_) log_(LogLevel::info, fmt::format("{} is kept as the stored address", text_of(candidate_)));
}

void AddressManager::examine(const InterfaceConfiguration& configuration, enip::Time now) {
    candidate_ = configuration;
    if (!detects_) {
        use();
        return;
    }
    log_(LogLevel::debug, fmt::format("is {} free?", text_of(candidate_)));
    detection_.start(candidate_.address, now);
}

void AddressManager::use() {
    in_use_ = true;
    network_.state.interface = candidate_;
    network_.state.address = {};
    if (client_) client_->confirm();
    log_(LogLevel::info, fmt::format("{} is in use", text_of(candidate_)));
}

void AddressManager::drop() {
    in_use_ = false;
    detection_.stop();
    network_.state.interface = {};
    network_.state.address.configured = false;
}

void AddressManager::lose() {
    if (!in_use_) return;
    drop();
    if (lost_) lost_();
}

void AddressManager::on_frame(std::size_t, const enip::HeardFrame& heard, enip::Time now) {
    follow_settings();
    const auto frame = EthernetFrame::parse(heard.octets);
    if (!frame || (frame->vlan_tag.value_or(0) & vlan_id) != 0) return;
    if (frame->type == EtherType::arp) take(detection_.on_arp(frame->payload, now), now);
    if (frame->type == EtherType::ipv4 && client_) take(client_->on_frame(heard, now), now);
}

void AddressManager::on_link(std::size_t, bool up, enip::Time now) {
    follow_settings();
    const bool came_back = up && !link_up_;
    link_up_ = up;
    log_(LogLevel::info, up ? "the link is there" : "there is no link");
    detection_.on_link(up, now);
    if (!came_back || in_use_ || detection_.runs() || detection_.is_patient()) return;
    if (retry_) retry_ = now;  // R-ACD-3
    if (client_ && !network_.state.address.conflict) client_->start(now);
}

void AddressManager::on_timer(enip::Time now) {
    follow_settings();
    if (begins_) begin(now);
    if (retry_ && now >= *retry_) {
        retry_.reset();
        begin_with_stored(now);
    }
    if (client_) take(client_->on_timer(now), now);
    take(detection_.on_timer(now), now);
}

std::optional<enip::Time> AddressManager::next_deadline() const {
    if (begins_) return enip::Time{};
    auto next = detection_.next_deadline();
    for (const auto& other : {retry_, client_ ? client_->next_deadline() : std::nullopt}) {
        if (other && (!next || *other < *next)) next = other;
    }
    return next;
}

std::vector<enip::LinkFrame> AddressManager::take_frames() {
    std::vector<enip::LinkFrame> frames;
    if (client_) {
        for (auto& octets : client_->take_frames()) frames.push_back({.octets = std::move(octets)});
    }
    for (auto& octets : detection_.take_frames()) frames.push_back({.octets = std::move(octets)});
    return frames;
}

std::optional<enip::InterfaceAddress> AddressManager::address() const {
    if (!in_use_) return std::nullopt;
    return enip::InterfaceAddress{candidate_.address, prefix_length(candidate_.mask), candidate_.gateway};
}

IgnoredReplies AddressManager::ignored_replies() const { return client_ ? client_->ignored() : IgnoredReplies{}; }

void AddressManager::take(std::optional<AddressClient::Event> event, enip::Time now) {
    if (!event) return;
    switch (*event) {
        case AddressClient::Event::granted:
            examine(client_->granted(), now);
            break;
        case AddressClient::Event::changed:
            candidate_ = client_->granted();
            network_.state.interface = candidate_;
            log_(LogLevel::info, fmt::format("the lease of {} has other particulars now", text_of(candidate_)));
            break;
        case AddressClient::Event::lost:
            log_(LogLevel::warning, fmt::format("the lease of {} is over", text_of(candidate_)));
            lose();
            break;
    }
}

void AddressManager::take(std::optional<AddressVerdict> verdict, enip::Time now) {
    if (!verdict) return;
    auto& status = network_.state.address;
    auto& record = network_.settings.last_conflict;
    switch (*verdict) {
        case AddressVerdict::usable:
            use();
            break;
        case AddressVerdict::undisputed:
            status.conflict = false;
            break;
        case AddressVerdict::defended:
            record = detection_.last_conflict();
            status.conflict = true;
            log_(LogLevel::warning,
                 fmt::format("{} is claimed by {} too; it is defended", text_of(candidate_), rival_of(record)));
            break;
        case AddressVerdict::refused:
        case AddressVerdict::lost:
            record = detection_.last_conflict();
            log_(LogLevel::error,
                 fmt::format("{} belongs to {}: the device has no address", text_of(candidate_), rival_of(record)));
            suffer_conflict(now);
            break;
    }
}

// R-ACD-3, R-ACD-4.
void AddressManager::suffer_conflict(enip::Time now) {
    lose();
    network_.state.address.conflict = true;
    network_.state.address.without_address = true;
    if (client_) {
        client_->decline(detection_.pause(), now);
    } else {
        retry_ = now + detection_.pause();
    }
}

}  // namespace servobus::adapter
