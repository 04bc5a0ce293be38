// Address conflict detection (ACD, R-ACD): whether an IPv4 address is free before it is used, and whether it stays ours.
// Frames and time in, frames and verdicts out.
//
//     detection.start(address, now);        // probes leave; then on_timer() says `usable`, or on_arp() says `refused`
//     detection.on_arp(payload, now);       // while it is used: `defended`, or `lost`
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "adapter/arp_packet.hpp"
#include "adapter/mac_address.hpp"
#include "adapter/network_settings.hpp"
#include "cip/bytes.hpp"
#include "enip/time.hpp"

namespace servobus::adapter {

/// What was being done when somebody else claimed the address: the first octet of attribute 11 (R-TCP-10).
enum class ConflictActivity : std::uint8_t { none, probing, ongoing_detection, semi_active_probing };

enum class AddressVerdict : std::uint8_t {
    usable,      ///< nobody has objected: the address may be used from now on
    refused,     ///< somebody has it, or wants it too: it must not be used
    defended,    ///< somebody has claimed it; it is kept and announced again
    undisputed,  ///< nobody has claimed it since, for as long as a defence counts
    lost,        ///< claimed again: it must be given up
};

class AddressConflictDetection {
public:
    /// The seed chooses when the ongoing detection asks.
    AddressConflictDetection(const MacAddress& own, std::uint64_t seed) : own_(own), random_(seed) {}

    /// The address is to be used: probing begins. Whatever address there was is forgotten.
    void start(std::uint32_t address, enip::Time now);
    /// No address is wanted or used any more.
    void stop();
    [[nodiscard]] bool runs() const { return phase_ != Phase::idle; }

    /// An ARP packet of the link, without its Ethernet header. Others than ARP over IPv4 are ignored.
    [[nodiscard]] std::optional<AddressVerdict> on_arp(cip::ByteView payload, enip::Time now);
    /// Nothing is sent while the link is down; when it comes back, an address that is used is looked at again (R-ACD-5).
    void on_link(bool up, enip::Time now);
    [[nodiscard]] std::optional<AddressVerdict> on_timer(enip::Time now);
    [[nodiscard]] std::optional<enip::Time> next_deadline() const;
    /// What is to be sent.
    [[nodiscard]] std::vector<cip::Bytes> take_frames() { return std::exchange(frames_, {}); }

    /// The latest conflict; all zero before the first one.
    [[nodiscard]] const LastConflict& last_conflict() const { return last_conflict_; }
    /// How long to wait after `refused` or `lost` before an address is tried again.
    [[nodiscard]] std::chrono::seconds pause() const;
    /// There were so many conflicts that nothing may shorten the pause.
    [[nodiscard]] bool is_patient() const;

private:
    /// From `announcing` on the address is in use.
    enum class Phase : std::uint8_t { idle, probing, announcing, guarding, semi_active };

    [[nodiscard]] bool claims(const ArpPacket& packet) const;
    void record(const ArpPacket& packet, cip::ByteView payload);
    [[nodiscard]] AddressVerdict defend(enip::Time now);
    [[nodiscard]] std::optional<AddressVerdict> go_on(enip::Time now);
    void enter(Phase phase, enip::Time due);
    void probe(enip::Time now);
    void announce() { frames_.push_back(arp_announcement(own_, address_)); }
    [[nodiscard]] std::chrono::milliseconds until_next_look();

    MacAddress own_;
    std::mt19937_64 random_;
    std::uint32_t address_ = 0;
    Phase phase_ = Phase::idle;
    bool link_up_ = true;
    int sent_ = 0;       ///< frames of this phase
    enip::Time due_{};   ///< the next step of this phase
    int conflicts_ = 0;  ///< addresses that could not be kept, since one was kept for long
    LastConflict last_conflict_{};
    std::optional<enip::Time> defended_;  ///< the latest defence, while it counts
    std::vector<cip::Bytes> frames_;
};

}  // namespace servobus::adapter
