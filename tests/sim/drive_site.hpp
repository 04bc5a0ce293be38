// A drive with its adapter, at the end of its lines: what enip/asio does for it in the real world, in virtual time.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "adapter/adapter.hpp"
#include "drive/device.hpp"
#include "enip/frame_decoder.hpp"
#include "tests/sim/event_queue.hpp"
#include "tests/sim/neighbourhood.hpp"
#include "tests/sim/target_watch.hpp"
#include "tests/sim/wire.hpp"

namespace servobus::sim {

class DriveSite final : public Host {
public:
    DriveSite(unsigned number, const DriveSpec& spec, std::uint64_t seed, EventQueue& queue, Wire& wire,
              Neighbourhood& neighbourhood, Judge& judge);

    // What befalls it
    void kill(microseconds duration, bool silent);
    void power_cycle();
    void restart(microseconds duration);
    void close_sessions();
    void hold_up(microseconds duration);

    [[nodiscard]] bool is_up() const override { return powered_; }
    void on_packet(const Packet& packet) override;
    [[nodiscard]] bool listens() const override { return adapter_ != nullptr; }
    void on_accepted(StreamId id, enip::Endpoint peer, enip::Endpoint local) override;
    void on_connected(StreamId, bool) override {}
    void on_octets(StreamId id, cip::ByteView octets) override;
    void on_end(StreamId id) override;

    /// Everybody has gone, and all times are over.
    void expect_nothing();
    [[nodiscard]] adapter::Adapter* adapter() { return adapter_.get(); }
    [[nodiscard]] TargetWatch& watch() { return watch_; }

private:
    using ConnectionId = enip::Target::ConnectionId;
    struct Peer {
        StreamId stream = 0;
        enip::FrameDecoder heard;  ///< the books' own decoders
        enip::FrameDecoder said;
    };
    void start();
    void whenever_it_runs(std::function<void()> what);
    void wake();
    void take_kernel_io();
    void take_io(const Packet& packet, Time came);
    void take_octets(StreamId id, cip::ByteView octets);
    void take_end(StreamId id);
    bool catch_up();
    void after_event();
    void flush();
    void send_replies(ConnectionId id);
    void end(ConnectionId id);
    void arm();

    unsigned number_;
    DriveSpec spec_;
    Random random_;
    EventQueue& queue_;
    Wire& wire_;
    Neighbourhood& neighbourhood_;
    Judge& judge_;
    TargetWatch watch_;

    bool powered_ = true;
    unsigned life_ = 0;  ///< of the program
    std::unique_ptr<drive::Device> device_;
    std::unique_ptr<adapter::Adapter> adapter_;  ///< none: the program does not run
    std::map<ConnectionId, Peer> peers_;
    std::map<StreamId, ConnectionId> ids_;
    std::optional<Time> armed_;
    bool held_up_ = false;
    Time held_until_{};
    Time latest_{};
    /// What waits in the kernel while the program gets no CPU.
    std::deque<std::pair<Time, Packet>> kernel_io_;
    std::set<StreamId> kernel_accepted_;
    std::deque<std::function<void()>> kernel_rest_;
};

}  // namespace servobus::sim
