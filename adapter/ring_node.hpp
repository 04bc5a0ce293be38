// A node of a Device Level Ring that is no supervisor (R-DLR-5, R-DLR-6): what it hears on its two ports makes its state,
// which the DLR object tells. Frames and time in, frames and status out.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "adapter/log.hpp"
#include "adapter/network_state.hpp"
#include "adapter/ring_frame.hpp"
#include "enip/link_user.hpp"

namespace servobus::adapter {

class RingNode final : public enip::LinkUser {
public:
    /// Writes `network.ring`; MAC and IPv4 address in there are the node's own. By `network.ring.announce_based` it looks at
    /// announcements, or at beacons.
    RingNode(NetworkState& network, Log log = {}) : network_(network), log_(std::move(log)) {}

    void on_frame(std::size_t port, const enip::HeardFrame& heard, enip::Time now) override;
    void on_link(std::size_t number, bool up, enip::Time now) override;
    void on_timer(enip::Time now) override;
    [[nodiscard]] std::optional<enip::Time> next_deadline() const override;
    [[nodiscard]] std::vector<enip::LinkFrame> take_frames() override { return std::exchange(frames_, {}); }

private:
    enum class State : std::uint8_t { idle, fault, normal };
    static constexpr std::size_t port_count = 2;

    /// A neighbor that is asked whether it is there.
    struct NeighborCheck {
        int asked = 0;
        std::uint32_t first_sequence = 0;
        std::uint32_t last_sequence = 0;
    };
    struct Port {
        bool up = true;
        std::optional<enip::Time> silent_at;   ///< when the supervisor's beacons count as missing; nullopt: they do
        std::optional<RingState> ring{};       ///< by the latest beacon
        std::optional<NeighborCheck> check{};  ///< that goes on
        bool neighbor_lost = false;            ///< by the latest check
    };
    struct Supervisor {
        MacAddress mac{};
        std::uint32_t address = 0;
        std::uint8_t precedence = 0;
        std::chrono::microseconds timeout{0};
    };

    void on_beacon(std::size_t port, const RingFrame& frame, enip::Time now);
    void on_announce(const RingFrame& frame, enip::Time now);
    void on_sign_on(std::size_t port, const RingFrame& frame);
    void on_locate_fault(const RingFrame& frame, enip::Time now);
    void on_check_request(std::size_t port, const RingFrame& frame);
    void on_check_response(std::size_t port, const RingFrame& frame);
    void on_flush_tables(const RingFrame& frame);

    [[nodiscard]] bool accepts(const RingFrame& frame, const Beacon& beacon) const;
    void follow(const Supervisor& supervisor);
    static void forget(Port& port);
    void judge();
    void enter(State state);
    void tell_links();
    void ask_neighbor(std::size_t port);
    void check_again(enip::Time now);
    void finish_check();
    [[nodiscard]] static std::size_t other(std::size_t port) { return port_count - 1 - port; }
    [[nodiscard]] RingFrame from_here(RingFrameType type, const MacAddress& destination);
    void send(std::size_t port, const RingFrame& frame);
    void send_status(std::uint8_t bits, bool (*works)(const Port&));

    NetworkState& network_;
    Log log_;
    State state_ = State::idle;
    std::array<Port, port_count> ports_{};
    Supervisor supervisor_;
    std::optional<enip::Time> check_due_;
    std::uint32_t sequence_ = 0;
    std::vector<enip::LinkFrame> frames_;
};

}  // namespace servobus::adapter
