// One I/O connection of an originator, without sockets: what has happened and the time go in; requests, datagrams, events
// and the next deadline come out (R-SCN-1 to R-SCN-6, decision 2).
#pragma once

#include <boost/system/result.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cip/forward_open.hpp"
#include "enip/io_packet.hpp"
#include "enip/io_queue.hpp"
#include "enip/io_stream.hpp"
#include "enip/time.hpp"
#include "scanner/exchange.hpp"
#include "scanner/io_events.hpp"
#include "scanner/io_numbers.hpp"
#include "scanner/io_reply.hpp"

namespace servobus::scanner {

/// What a connection may ask for in one direction, so that its datagrams fit the buffers.
inline constexpr std::size_t max_io_connection_size = 8000;

/// Datagrams that are kept while the reply to the Forward_Open, which they have overtaken, is on its way; the latest ones.
inline constexpr std::size_t max_early_datagrams = 16;

/// A datagram that carries the T->O id of a connection.
struct IoArrival {
    enip::Endpoint peer;
    enip::Endpoint local;  ///< where it was sent to: an address of ours, or a group
    cip::ByteView octets;
    enip::IoPacket packet;
    enip::Time time{};
};

class IoSession {
public:
    /// What a session needs from around it. Answers to connect() and request() come later, never inside the call; those
    /// to a ticket that nobody waits for any more may come and are ignored.
    class Surroundings {
    public:
        virtual ~Surroundings() = default;
        /// A session to the device, in which on_connected() tells.
        virtual void connect(std::uint64_t ticket) = 0;
        [[nodiscard]] virtual bool connected() const = 0;
        /// A request over that session; on_reply() tells.
        virtual void request(std::uint64_t ticket, const cip::Request& request, std::vector<enip::Item> items) = 0;
        /// Our own end for I/O at this address.
        [[nodiscard]] virtual boost::system::result<enip::Endpoint> listen(std::uint32_t local_address) = 0;
        [[nodiscard]] virtual error_code join(enip::Endpoint group, std::uint32_t local_address) = 0;
        /// Neither own end nor group are needed any more.
        virtual void stop_listening() = 0;
        /// Datagrams with this id are for this session, until it is forgotten.
        virtual void expect(std::uint32_t t_to_o_id) = 0;
        virtual void forget(std::uint32_t t_to_o_id) = 0;
        /// Whether another session expects datagrams with this id from the same device, as not even multicast may.
        [[nodiscard]] virtual bool is_taken(std::uint32_t t_to_o_id) const = 0;
        /// The next deadline may have become an earlier one, or the state another.
        virtual void changed() = 0;

    protected:
        Surroundings() = default;
        Surroundings(const Surroundings&) = default;
        Surroundings& operator=(const Surroundings&) = default;
    };

    IoSession(IoOptions options, IoEvents events, IoNumbers& numbers, Surroundings& surroundings);

    void open(enip::Time now);
    void close(enip::Time now);
    void trigger(enip::Time now);

    void on_connected(std::uint64_t ticket, error_code error, const TcpEnds& ends, enip::Time now);
    void on_reply(std::uint64_t ticket, error_code error, const Exchange& exchange, enip::Time now);

    enum class Reception : std::uint8_t { taken, wrong_source };
    Reception on_datagram(const IoArrival& arrival);

    /// What is due: a production, the end of patience, the next try.
    void on_timer(enip::Time now, enip::IoQueue& queue);
    [[nodiscard]] std::optional<enip::Time> next_deadline() const;
    /// Whether on_timer(now) would give up; who can look for datagrams once more does so before.
    [[nodiscard]] bool is_starving(enip::Time now) const;

    [[nodiscard]] IoState state() const { return state_; }
    [[nodiscard]] const IoOptions& options() const { return options_; }
    [[nodiscard]] const TcpEnds& ends() const { return ends_; }
    /// Whether T->O comes by multicast, whose id others may share.
    [[nodiscard]] bool is_multicast() const { return options_.plan.t_to_o.type == cip::ConnectionType::multicast; }
    /// Of the connection that is open, or was last.
    [[nodiscard]] const enip::IoConsumer::Counters& received() const { return consumer_.counters(); }
    [[nodiscard]] const enip::IoProducer::Counters& sent() const { return producer_.counters(); }

private:
    enum class Awaited : std::uint8_t { nothing, session, open_reply, close_reply };

    [[nodiscard]] std::uint64_t await(Awaited what);
    void stop_awaiting();
    [[nodiscard]] bool is_awaited(std::uint64_t ticket) const { return ticket != 0 && ticket == ticket_; }
    void enter(IoState state);

    void begin();
    void ask(const TcpEnds& ends, enip::Time now);
    void send_open();
    void on_open_reply(error_code error, const Exchange& exchange, enip::Time now);
    [[nodiscard]] bool try_small(const cip::Status& status);
    void on_grant(IoGrant grant, enip::Time now);
    void start_streams(const IoGrant& grant, enip::Time now);

    void send_close();
    void close_in_passing(const std::optional<cip::ForwardOpen>& open);
    void on_close_reply(error_code error, const Exchange& exchange, enip::Time now);
    void finish_close(IoClosed closed, enip::Time now);

    void fail(IoClosed closed, enip::Time now);
    void tear_down();
    void expect(std::optional<std::uint32_t> id);
    [[nodiscard]] std::chrono::milliseconds next_pause(const IoClosed& closed);
    void keep_early(const IoArrival& arrival);
    void take_early();
    void take(const IoArrival& arrival);
    void produce(enip::Time now, enip::IoQueue& queue);
    bool ask_for_output();

    [[nodiscard]] bool consumes() const { return options_.plan.t_to_o.type != cip::ConnectionType::null; }
    [[nodiscard]] bool produces() const { return options_.plan.o_to_t.type != cip::ConnectionType::null; }

    IoOptions options_;
    IoEvents events_;
    IoNumbers& numbers_;
    Surroundings& surroundings_;

    IoState state_ = IoState::idle;
    Awaited awaited_ = Awaited::nothing;
    std::uint64_t ticket_ = 0;       ///< of what is awaited
    std::uint64_t last_ticket_ = 0;  ///< ever given
    unsigned attempt_ = 0;
    std::chrono::milliseconds pause_{};
    enip::Time retry_at_{};
    bool open_again_ = false;   ///< open() was called while closing
    bool close_again_ = false;  ///< the session may have gone while the Forward_Close was on its way: try another one
    bool small_only_ = false;   ///< the device does not know the large form
    std::optional<cip::ForwardOpen> request_{};
    std::optional<cip::ForwardOpen> owed_close_{};  ///< what the device may hold open, and could not be told to close
    TcpEnds ends_{};
    enip::Endpoint receiver_{};

    std::optional<std::uint32_t> expected_id_{};
    std::optional<enip::Endpoint> group_{};
    enip::Time opened_at_{};
    struct Early {
        IoArrival arrival;
        cip::Bytes octets;
    };
    std::vector<Early> early_;
    enip::IoConsumer consumer_{};
    enip::IoProducer producer_{};
    std::vector<std::uint8_t> output_;
    bool asking_ = false;  ///< the application is being asked for its output
};

}  // namespace servobus::scanner
