// A TCP connection and session of a node to a drive, and requests over it: what scanner::Client is, which has sockets and the
// clock of the machine in it, in virtual time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "cip/message.hpp"
#include "enip/encapsulation.hpp"
#include "enip/frame_decoder.hpp"
#include "scanner/class3.hpp"
#include "scanner/error.hpp"
#include "scanner/exchange.hpp"
#include "tests/sim/event_queue.hpp"
#include "tests/sim/judge.hpp"
#include "tests/sim/wire.hpp"

namespace servobus::sim {

class SessionClient {
public:
    using Done = std::function<void(scanner::error_code)>;
    using Replied = std::function<void(scanner::error_code, const scanner::Exchange&)>;
    /// What it has of its node. References outlive it.
    struct Surroundings {
        EventQueue& queue;
        Wire& wire;
        Judge& judge;
        /// Which client a TCP connection belongs to; nullptr when to nobody any more.
        std::function<void(StreamId, SessionClient*)> enter;
        /// A timer does this when its program gets a CPU.
        std::function<void(std::function<void()>)> run;
    };

    SessionClient(unsigned node, unsigned drive, std::uint32_t nonce, Surroundings surroundings);
    ~SessionClient() { abandon(false); }
    SessionClient(const SessionClient&) = delete;
    SessionClient& operator=(const SessionClient&) = delete;

    void connect(std::chrono::milliseconds timeout, Done done);
    void exchange(const cip::Request& request, std::vector<enip::Item> items, std::chrono::milliseconds timeout,
                  Replied done);
    /// A class 3 connection to the message router; `done` tells its status.
    void open_class3(std::chrono::milliseconds timeout, Replied done);
    /// Over that, one at a time.
    void exchange_connected(const cip::Request& request, std::chrono::milliseconds timeout, Replied done);
    void keep_alive();
    /// In good manners. Whoever waits hears that it is over.
    void close();
    /// Without a word, or with a reset.
    void abandon(bool silent);

    [[nodiscard]] bool is_ready() const { return state_ == State::ready; }
    [[nodiscard]] bool has_class3() const { return class3_.has_value(); }
    [[nodiscard]] std::optional<scanner::TcpEnds> ends() const;
    [[nodiscard]] std::size_t outstanding() const { return outstanding_.size(); }

    // What the TCP connection brings
    void on_connected(bool stands);
    void on_octets(cip::ByteView octets);
    void on_end();

    struct Counters {
        std::uint64_t requests = 0;
        std::uint64_t answered = 0;
        std::uint64_t timed_out = 0;
        std::uint64_t aborted = 0;  ///< their TCP connection has ended
    };
    /// Of all clients of a run.
    static void add(Counters& to, const Counters& more) {
        to.requests += more.requests;
        to.answered += more.answered;
        to.timed_out += more.timed_out;
        to.aborted += more.aborted;
    }
    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    enum class State : std::uint8_t { idle, connecting, registering, ready };
    struct Call {
        std::uint8_t service = 0;
        std::optional<std::uint16_t> sequence{};  ///< of a connected one
        Replied done;
    };

    void send(const enip::Frame& frame);
    void later(std::chrono::milliseconds pause, std::function<void()> what);
    std::uint32_t note(Call call, std::chrono::milliseconds timeout);
    void on_timeout(std::uint32_t id);
    void on_frame(const enip::Frame& frame);
    void on_unconnected(const enip::Frame& frame);
    void on_connected_reply(const enip::Frame& frame);
    void answer(std::uint32_t id, cip::ByteView message, std::vector<enip::Item> items);
    void lose(scanner::error_code error);
    void end_setup(scanner::error_code error);
    [[nodiscard]] enip::SenderContext context_of(std::uint32_t id) const;
    void report(Invariant invariant, std::string what) const {
        around_.judge.report(invariant, around_.queue.now(), std::move(what));
    }

    unsigned node_;
    unsigned drive_;
    std::uint32_t nonce_;
    Surroundings around_;
    std::shared_ptr<char> alive_ = std::make_shared<char>();

    State state_ = State::idle;
    std::optional<StreamId> stream_{};
    std::uint16_t port_ = 0;
    enip::FrameDecoder decoder_;
    std::uint32_t session_ = 0;
    std::uint32_t last_id_ = 0;
    std::uint32_t setup_id_ = 0;
    Done setup_done_;
    std::map<std::uint32_t, Call> outstanding_;
    std::set<std::uint32_t> given_up_;  ///< on this TCP connection: their answers may still come
    std::set<std::uint16_t> given_up_connected_;
    std::optional<scanner::Class3Connection> class3_{};
    Counters counters_;
};

}  // namespace servobus::sim
