// A node with the program of an originator: I/O connections over scanner::IoSession, and clients with explicit requests. What
// scanner::Originator does for its sessions with sockets is done here in virtual time.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "scanner/io_numbers.hpp"
#include "scanner/io_session.hpp"
#include "tests/sim/event_queue.hpp"
#include "tests/sim/motion_program.hpp"
#include "tests/sim/neighbourhood.hpp"
#include "tests/sim/originator_watch.hpp"
#include "tests/sim/session_client.hpp"
#include "tests/sim/wire.hpp"

namespace servobus::sim {

class NodeSite final : public Host {
public:
    NodeSite(unsigned number, const Scenario& scenario, EventQueue& queue, Wire& wire, Neighbourhood& neighbourhood,
             Judge& judge);
    ~NodeSite() override;

    // What its people want
    void open(unsigned connection);
    void close(unsigned connection);
    void run(unsigned connection, bool run);
    void want(unsigned connection, MotionProgram::Goal goal);
    void start_client(unsigned client);
    void stop_client(unsigned client, bool silent);
    void discover();

    // What befalls it
    void crash(microseconds duration, bool silent);
    void hold_up(microseconds duration);

    [[nodiscard]] bool is_up() const override { return powered_; }
    void on_packet(const Packet& packet) override;
    [[nodiscard]] bool listens() const override { return false; }
    void on_accepted(StreamId, enip::Endpoint, enip::Endpoint) override {}
    void on_connected(StreamId id, bool stands) override;
    void on_octets(StreamId id, cip::ByteView octets) override;
    void on_end(StreamId id) override;

    /// Everybody has gone, and all times are over.
    void expect_nothing();

    struct Counters {
        OriginatorWatch::Counters io;
        SessionClient::Counters requests;
        std::uint64_t discovered = 0;
    };
    [[nodiscard]] Counters counters() const;

private:
    class Connection;
    class Client;
    struct Process;

    void start();
    void whenever_it_runs(std::function<void()> what);
    void wake();
    void take_io(const Packet& packet, Time came);
    void take_kernel_io();
    void run_due();
    void after_event();
    void arm();
    void post(std::function<void()> what);
    void keep_alive();
    [[nodiscard]] SessionClient::Surroundings surroundings();
    [[nodiscard]] Connection* connection(unsigned number);
    [[nodiscard]] Client* client(unsigned number);

    unsigned number_;
    const Scenario& scenario_;
    Random random_;
    EventQueue& queue_;
    Wire& wire_;
    Neighbourhood& neighbourhood_;
    Judge& judge_;

    bool powered_ = true;
    unsigned life_ = 0;
    std::unique_ptr<Process> process_;  ///< none: the program does not run
    /// What its people want, whether it runs or not.
    std::map<unsigned, bool> wanted_connections_;
    std::map<unsigned, bool> wanted_runs_;
    std::map<unsigned, MotionProgram::Goal> wanted_goals_;
    std::map<unsigned, bool> wanted_clients_;
    std::unordered_map<StreamId, SessionClient*> streams_;
    std::optional<Time> armed_;
    bool held_up_ = false;
    Time held_until_{};
    std::deque<std::pair<Time, Packet>> kernel_io_;
    std::deque<std::function<void()>> kernel_rest_;
    Counters past_;  ///< of programs that are gone
};

}  // namespace servobus::sim
