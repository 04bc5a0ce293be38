#include "adapter/address_conflict.hpp"

#include <algorithm>

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;

// R-ACD-1. These two are fixed; RFC 5227 would take them from a range.
constexpr auto probe_interval = 200ms;  // also before the first probe, and after the last one
constexpr int probes = 4;
constexpr auto announce_interval = 2s;

constexpr int semi_active_probes = 2;                     // R-ACD-5
constexpr std::chrono::milliseconds shortest_look = 90s;  // R-ACD-4
constexpr std::chrono::milliseconds longest_look = 150s;
constexpr auto defend_interval = 10s;

// R-ACD-3
constexpr auto usual_pause = 10s;
constexpr int conflicts_before_patience = 10;
constexpr auto patient_pause = 60s;

}  // namespace

void AddressConflictDetection::start(std::uint32_t address, enip::Time now) {
    address_ = address;
    defended_.reset();
    enter(Phase::probing, now + probe_interval);
}

void AddressConflictDetection::stop() {
    phase_ = Phase::idle;
    defended_.reset();
}

void AddressConflictDetection::enter(Phase phase, enip::Time due) {
    phase_ = phase;
    sent_ = 0;
    due_ = due;
}

std::chrono::seconds AddressConflictDetection::pause() const { return is_patient() ? patient_pause : usual_pause; }

bool AddressConflictDetection::is_patient() const { return conflicts_ > conflicts_before_patience; }

std::chrono::milliseconds AddressConflictDetection::until_next_look() {
    std::uniform_int_distribution<std::int64_t> wait(shortest_look.count(), longest_look.count());
    return std::chrono::milliseconds(wait(random_));
}

// Who merely asks for the address is no rival once it is ours: the answer keeps him away.
bool AddressConflictDetection::claims(const ArpPacket& packet) const {
    if (packet.sender_mac == own_) return false;
    if (packet.sender_address == address_) return true;
    return phase_ == Phase::probing && packet.is_probe() && packet.target_address == address_;
}

std::optional<AddressVerdict> AddressConflictDetection::on_arp(cip::ByteView payload, enip::Time now) {
    if (!runs()) return std::nullopt;
    const auto packet = ArpPacket::parse(payload);
    if (!packet || !claims(*packet)) return std::nullopt;
    record(*packet, payload);
    if (phase_ != Phase::probing) return defend(now);
    ++conflicts_;
    stop();
    return AddressVerdict::refused;
}

void AddressConflictDetection::record(const ArpPacket& packet, cip::ByteView payload) {
    const auto activity = phase_ == Phase::probing       ? ConflictActivity::probing
                          : phase_ == Phase::semi_active ? ConflictActivity::semi_active_probing
                                                         : ConflictActivity::ongoing_detection;
    last_conflict_[0] = static_cast<std::uint8_t>(activity);
    const auto arp = std::ranges::copy(packet.sender_mac, last_conflict_.begin() + 1).out;
    std::ranges::copy(payload.first(ArpPacket::octets), arp);
}

AddressVerdict AddressConflictDetection::defend(enip::Time now) {
    if (defended_ && now < *defended_ + defend_interval) {
        ++conflicts_;
        stop();
        return AddressVerdict::lost;
    }
    defended_ = now;
    announce();
    return AddressVerdict::defended;
}

void AddressConflictDetection::on_link(bool up, enip::Time now) {
    const bool came_back = up && !link_up_;
    link_up_ = up;
    if (!came_back || !runs()) return;
    enter(phase_ == Phase::probing ? Phase::probing : Phase::semi_active, now + probe_interval);
}

std::optional<AddressVerdict> AddressConflictDetection::on_timer(enip::Time now) {
    if (!runs()) return std::nullopt;
    if (defended_ && now >= *defended_ + defend_interval) {
        defended_.reset();
        return AddressVerdict::undisputed;
    }
    return link_up_ && now >= due_ ? go_on(now) : std::nullopt;
}

std::optional<AddressVerdict> AddressConflictDetection::go_on(enip::Time now) {
    switch (phase_) {
        case Phase::idle:
            break;
        case Phase::probing:
            if (sent_ < probes) {
                probe(now);
                break;
            }
            announce();
            enter(Phase::announcing, now + announce_interval);
            return AddressVerdict::usable;
        case Phase::announcing:
            announce();
            enter(Phase::guarding, now + until_next_look());
            break;
        case Phase::guarding:
            conflicts_ = 0;
            probe(now);
            due_ = now + until_next_look();
            break;
        case Phase::semi_active:
            if (sent_ < semi_active_probes) {
                probe(now);
            } else {
                enter(Phase::guarding, now + until_next_look());
            }
            break;
    }
    return std::nullopt;
}

// The next step is counted from the frame that leaves now, not from the time it was due at: what others may rely on is
// the distance between two frames.
void AddressConflictDetection::probe(enip::Time now) {
    frames_.push_back(arp_probe(own_, address_));
    ++sent_;
    due_ = now + probe_interval;
}

std::optional<enip::Time> AddressConflictDetection::next_deadline() const {
    if (!runs()) return std::nullopt;
    std::optional<enip::Time> next;
    if (link_up_) next = due_;
    if (defended_ && (!next || *defended_ + defend_interval < *next)) next = *defended_ + defend_interval;
    return next;
}

}  // namespace servobus::adapter
