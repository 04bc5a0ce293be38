// The lines between nodes and drives: what they do to datagrams and to TCP connections.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "cip/bytes.hpp"
#include "enip/endpoint.hpp"
#include "tests/sim/event_queue.hpp"
#include "tests/sim/random.hpp"
#include "tests/sim/scenario.hpp"

namespace servobus::sim {

enum class End : std::uint8_t { node, drive };
[[nodiscard]] constexpr End other_end(End end) { return end == End::node ? End::drive : End::node; }

struct Packet {
    unsigned node = 0;
    unsigned drive = 0;
    End to = End::drive;
    enip::Endpoint source;
    enip::Endpoint destination;
    cip::Bytes octets;
};

using StreamId = std::uint64_t;

/// The machine at one end of a line: what arrives there.
class Host {
public:
    virtual ~Host() = default;
    /// The machine has power: it answers, if only that nobody is there.
    [[nodiscard]] virtual bool is_up() const = 0;
    virtual void on_packet(const Packet& packet) = 0;
    /// A program waits for TCP connections; its kernel accepts them.
    [[nodiscard]] virtual bool listens() const = 0;
    virtual void on_accepted(StreamId id, enip::Endpoint peer, enip::Endpoint local) = 0;
    /// The TCP connection that this end has asked for stands, or not.
    virtual void on_connected(StreamId id, bool stands) = 0;
    virtual void on_octets(StreamId id, cip::ByteView octets) = 0;
    /// The other end has closed or reset it; there is nothing left of it.
    virtual void on_end(StreamId id) = 0;

protected:
    Host() = default;
    Host(const Host&) = default;
    Host& operator=(const Host&) = default;
};

/// What has happened on the lines so far.
struct WireCounters {
    std::uint64_t sent = 0;
    std::uint64_t delivered = 0;
    std::uint64_t lost = 0;
    std::uint64_t duplicated = 0;
    std::uint64_t reordered = 0;
    std::uint64_t streams = 0;
    std::uint64_t resets = 0;
};

class Wire {
public:
    Wire(EventQueue& queue, const Scenario& scenario);

    /// The machines, which outlive this.
    void attach(End end, unsigned index, Host& host) { hosts_[static_cast<std::size_t>(end)].at(index) = &host; }

    void set_faults(unsigned node, unsigned drive, Action::Way way, const Faults& faults);
    /// Nothing gets through until then.
    void cut(unsigned node, unsigned drive, Action::Way way, Time until);
    void reset_streams(unsigned node, unsigned drive);
    /// All lines are as new.
    void heal();

    /// One datagram on the line between both, towards `to`.
    void send(unsigned node, unsigned drive, End to, enip::Endpoint source, enip::Endpoint destination,
              cip::ByteView octets);

    [[nodiscard]] StreamId connect(unsigned node, unsigned drive, enip::Endpoint source, enip::Endpoint destination);
    void write(StreamId id, End from, cip::ByteView octets);
    /// What has been written still arrives, then the other end hears of it. This end hears nothing any more.
    void close(StreamId id, End from);
    /// The other end hears of it at once, or never when `silent`. This end hears nothing any more.
    void abort(StreamId id, End from, bool silent);

    /// TCP connections that an end still knows of.
    [[nodiscard]] std::size_t streams() const { return streams_.size(); }
    /// Which ends of which of them, for people.
    [[nodiscard]] std::string describe_streams() const;
    [[nodiscard]] const WireCounters& counters() const { return counters_; }
    /// What has arrived last, the latest at the end; times count from `began`.
    [[nodiscard]] std::vector<std::string> last_arrivals(Time began) const;

private:
    /// For people who look for the cause of something.
    struct Arrival {
        Time at{};
        unsigned node = 0;
        unsigned drive = 0;
        End to = End::drive;
        StreamId stream = 0;  ///< 0: a datagram
        std::size_t octets = 0;
        std::uint32_t id = 0;
        std::uint32_t sequence = 0;
    };
    struct Line {
        Faults faults{};
        Time cut_until{};
        Random random{0};
    };
    struct Segment {
        enum class Kind : std::uint8_t { connect, accept, refuse, octets, close, reset };
        Time due;
        Kind kind;
        cip::Bytes octets{};
    };
    /// One direction of a TCP connection: what is on its way, in order.
    struct Flow {
        std::deque<Segment> segments;
        Time last{};
    };
    struct Stream {
        unsigned node = 0;
        unsigned drive = 0;
        enip::Endpoint source;
        enip::Endpoint destination;
        std::array<bool, 2> open{};  ///< by end: it still wants to hear
        std::array<Flow, 2> flows;   ///< by the end to which it goes
    };

    [[nodiscard]] Line& line(unsigned node, unsigned drive, End to) {
        return lines_[(static_cast<std::size_t>(node) * drives_ + drive) * 2 + static_cast<std::size_t>(to)];
    }
    template <class Each>
    void for_lines(unsigned node, unsigned drive, Action::Way way, Each each) {
        if (way != Action::Way::to_node) each(line(node, drive, End::drive));
        if (way != Action::Way::to_drive) each(line(node, drive, End::node));
    }
    [[nodiscard]] Host& host(const Stream& stream, End end) {
        return *hosts_[static_cast<std::size_t>(end)][end == End::node ? stream.node : stream.drive];
    }
    void note(const Packet& packet);
    void travel(Line& line, std::uint32_t slot);
    void arrive(std::uint32_t slot);
    [[nodiscard]] std::uint32_t free_slot();

    void push(StreamId id, Stream& stream, End to, Segment::Kind kind, cip::Bytes octets = {});
    void pump(StreamId id, End to);
    void arrive(StreamId id, End to, const Segment& segment);
    void forget_if_over(StreamId id);

    EventQueue& queue_;
    std::size_t drives_;
    std::array<std::vector<Host*>, 2> hosts_;
    std::vector<Line> lines_;
    std::vector<Packet> packets_;   ///< on their way; the places are used again
    std::vector<unsigned> copies_;  ///< of each place that are still to arrive
    std::vector<std::uint32_t> free_;
    std::unordered_map<StreamId, Stream> streams_;
    StreamId last_stream_ = 0;
    WireCounters counters_;
    std::array<Arrival, 16> arrivals_{};
    std::uint64_t arrived_ = 0;
};

}  // namespace servobus::sim
