// Books about one drive, kept from what goes in and comes out of it: its connections, their deadlines, what it may send, what
// it owes an answer to, and whether its axis may move. None of it asks the adapter, save what settle() compares.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "adapter/adapter.hpp"
#include "assemblies/connection.hpp"
#include "cip/forward_open.hpp"
#include "enip/encapsulation.hpp"
#include "enip/io_packet.hpp"
#include "enip/io_queue.hpp"
#include "tests/sim/judge.hpp"
#include "tests/sim/production_book.hpp"

namespace servobus::sim {

class TargetWatch {
public:
    using StreamKey = enip::Target::ConnectionId;

    TargetWatch(unsigned number, Judge& judge) : number_(number), judge_(&judge) {}

    /// Logic power or program have gone: nothing of before counts. Nothing is heard until `until`.
    void restarted(Time now, Time until);
    /// Its program gets a CPU again: what it does now may be late.
    void was_held_up(Time now) { excused_at_ = now; }
    /// What the drive does with its TCP connections now is on purpose.
    void sessions_closed_on_purpose() { sessions_end_ = true; }

    void stream_opened(StreamKey key, std::uint32_t peer, Time now);
    void stream_closed(StreamKey key);
    /// The drive ends it by itself.
    void stream_expired(StreamKey key, Time now);
    /// A whole message of a TCP connection, before the drive has it, and what it has answered.
    void hears(StreamKey key, const enip::Frame& frame, Time now);
    void says(StreamKey key, const enip::Frame& frame, Time now);

    /// A datagram of class 1, before the drive has it.
    void hears_io(std::uint32_t peer, cip::ByteView octets, Time now);
    /// One that the drive sends.
    void produces(const enip::IoRoute& route, cip::ByteView octets, Time now);

    /// After each event of the drive, at its time.
    void settle(const adapter::Adapter& adapter, Time now);
    /// Everybody has gone, and all times are over.
    void expect_nothing(const adapter::Adapter& adapter, Time now);

    struct Counters {
        std::uint64_t owners = 0;     ///< opened
        std::uint64_t onlookers = 0;  ///< opened, input only
        std::uint64_t listeners = 0;  ///< opened, listen only
        std::uint64_t class3 = 0;     ///< opened
        std::uint64_t refused = 0;
        std::uint64_t closed = 0;
        std::uint64_t timed_out = 0;
        std::uint64_t taken = 0;  ///< datagrams
        std::uint64_t stale = 0;
        std::uint64_t foreign = 0;  ///< from another address, or of another size
        std::uint64_t answers = 0;
        std::uint64_t losses_in_motion = 0;  ///< of the owner, while the axis moved
    };
    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    struct Connection {
        cip::ForwardOpen request;
        const assemblies::Connection* kind = nullptr;
        std::uint32_t o_to_t_id = 0;
        std::uint32_t production = 0;  ///< its T->O id and, for point-to-point, a key of its own
        std::uint32_t originator = 0;
        std::chrono::microseconds timeout{};
        Time deadline{};
        std::optional<std::uint32_t> sequence{};
        std::optional<std::uint16_t> count{};
        bool run = false;
        [[nodiscard]] bool is_owner() const { return kind->kind == assemblies::Connection::Kind::exclusive_owner; }
        [[nodiscard]] bool is_listener() const { return kind->kind == assemblies::Connection::Kind::listen_only; }
        [[nodiscard]] bool is_multicast() const { return request.t_to_o.type == cip::ConnectionType::multicast; }
    };
    struct ProductionKey {
        std::uint32_t id = 0;
        enip::Endpoint peer;
        friend auto operator<=>(const ProductionKey&, const ProductionKey&) = default;  // NOLINT(modernize-use-nullptr)
    };
    struct Production {
        ProductionBook book;
        unsigned users = 0;
    };
    struct Explicit {
        cip::ConnectionTriad triad;
        StreamKey stream = 0;
        std::chrono::microseconds timeout{};
        Time deadline{};
    };
    struct Stream {
        std::uint32_t peer = 0;
        Time last_message{};
        bool leaving = false;                     ///< it has said good-bye
        std::vector<enip::SenderContext> owed{};  ///< replies, in the order of the requests
        std::vector<cip::Request> asked{};        ///< what they are about; an empty one for no CIP request
        std::vector<std::uint16_t> owed_connected{};
        std::uint32_t session = 0;
    };

    void report(Invariant invariant, Time now, const std::string& what) const;
    void hears_request(Stream& stream, const enip::Frame& frame);
    void hears_connected(StreamKey key, Stream& stream, const enip::Frame& frame, Time now);
    void says_response(StreamKey key, Stream& stream, const cip::Request& request, const enip::Frame& frame, Time now);
    void granted(StreamKey key, const Stream& stream, const cip::ForwardOpen& open, const cip::Response& response,
                 Time now);
    void refused(const cip::ForwardOpen& open, const cip::Status& status, Time now);
    [[nodiscard]] std::optional<std::string> reason_to_refuse(const cip::ForwardOpen& open) const;
    void closed(const cip::ConnectionTriad& triad, Time now);
    void remove(std::uint32_t o_to_t_id, Time now);
    void release(const Connection& connection);
    [[nodiscard]] ProductionKey key_of(const Connection& connection) const;
    [[nodiscard]] const Connection* owner() const;

    void settle_connections(const adapter::Adapter& adapter, Time now);
    void settle_explicit(const adapter::Adapter& adapter, Time now);
    void settle_answers(Time now);
    void settle_axis(const drive::Device& device, Time now);
    void find_rows(const drive::Device& device);

    unsigned number_;
    Judge* judge_;
    Time deaf_until_{};
    bool sessions_end_ = false;
    std::map<std::uint32_t, Connection> connections_;  ///< by O->T id
    std::map<ProductionKey, Production> productions_;
    std::map<std::uint32_t, Explicit> explicit_;  ///< by O->T id
    std::map<StreamKey, Stream> streams_;
    std::optional<std::int64_t> target_{};  ///< what the newest datagram of the owner has said
    Counters counters_;

    /// What of the axis is looked at, in the table of this device.
    struct Rows {
        const drive::Device* device = nullptr;
        const drive::Parameter* status = nullptr;
        const drive::Parameter* process = nullptr;
        const drive::Parameter* position = nullptr;
        const drive::Parameter* target = nullptr;
        const drive::Parameter* quick_stop = nullptr;
    };
    Rows rows_;

    /// Since when no owner runs, and what the axis did then.
    struct Loss {
        Time at{};
        Time stops_by{};
        std::optional<std::int64_t> place{};  ///< where it stands since it has stopped
    };
    std::optional<Loss> loss_{};
    bool controlled_ = false;  ///< a running owner was there at the last event
    std::uint32_t status_before_ = 0;
    Time excused_at_{};
};

/// What the datagrams of an owner say in the member at this key; nullopt when the assembly has none.
[[nodiscard]] std::optional<std::size_t> offset_of(const assemblies::Layout& layout, drive::Key key);

}  // namespace servobus::sim
