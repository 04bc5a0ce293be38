#include "scanner/conformance/io_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "cip/services.hpp"
#include "enip/asio/asio.hpp"
#include "enip/asio/io_socket.hpp"
#include "enip/io_packet.hpp"
#include "enip/io_stream.hpp"

namespace servobus::scanner::conformance {
namespace {

using enip::Time;
using enip::asio::IoSocket;
using std::chrono::microseconds;
using Clock = std::chrono::steady_clock;

constexpr std::uint8_t longest_multiplier = 7;
/// Of each direction and connection, so many datagrams are recorded.
constexpr std::size_t recorded_datagrams = 4;

constexpr std::uint16_t word(cip::ConnectionFailure failure) { return static_cast<std::uint16_t>(failure); }

bool has_no_room(const cip::Status& status) {
    if (status.general == cip::GeneralStatus::resource_unavailable) return true;
    if (status.general != cip::GeneralStatus::connection_failure || status.extended.empty()) return false;
    constexpr std::array none_left{word(cip::ConnectionFailure::out_of_connections),
                                   word(cip::ConnectionFailure::target_out_of_connections)};
    return std::ranges::find(none_left, status.extended.front()) != none_left.end();
}

IoPlan at_interval(IoPlan plan, const Candidate& candidate, microseconds rpi) {
    const auto clamped = microseconds(std::clamp<std::int64_t>(
        rpi.count(), candidate.shortest_rpi, std::max(candidate.longest_rpi, candidate.shortest_rpi)));
    plan.o_to_t.rpi = clamped;
    plan.t_to_o.rpi = clamped;
    plan.multiplier_code = longest_multiplier;
    return plan;
}

}  // namespace

std::optional<std::uint16_t> Datagram::count() const {
    if (data.size() < cip::sequence_count_octets) return std::nullopt;
    return cip::Reader(data).u16();
}

IoPlan usual_plan(const Candidate& candidate, microseconds rpi) {
    auto plan = at_interval(candidate.plan, candidate, rpi);
    if (candidate.point_to_point) plan.t_to_o.type = cip::ConnectionType::point_to_point;
    return plan;
}

IoPlan multicast_plan(const Candidate& candidate, microseconds rpi) {
    auto plan = at_interval(candidate.plan, candidate, rpi);
    plan.t_to_o.type = cip::ConnectionType::multicast;
    return plan;
}

cip::ForwardOpen open_of(Session& session, const IoPlan& plan, const Change& change) {
    auto& subject = session.bench().subject();
    auto open = plan.forward_open(0, subject.next_id(), subject.next_triad());
    if (change) change(open);
    return open;
}

std::optional<Reply> try_open(Session& session, const cip::ForwardOpen& open, std::vector<enip::Item> items) {
    auto reply = session.call(open_request(open), std::move(items));
    if (reply && reply->ok()) static_cast<void>(close_triad(session, open));
    return reply;
}

std::optional<Reply> close_triad(Session& session, const cip::ForwardOpen& open) {
    return session.call(close_request(open));
}

void check_refusal_data(Bench& bench, const std::optional<Reply>& reply, const cip::ForwardOpen& open) {
    if (!reply || reply->ok()) return;
    constexpr std::size_t whole = 10;
    const auto refusal = cip::ConnectionRefusal::parse(reply->response.data);
    if (!bench.advise(refusal.has_value(), fmt::format("the refusal carries {} octets instead of triad, remaining path "
                                                       "size and a reserved octet",
                                                       reply->response.data.size()))) {
        return;
    }
    bench.require(refusal->triad == open.triad, "the refusal names another connection than the one that was asked for");
    bench.advise(reply->response.data.size() == whole,
                 fmt::format("the refusal carries {} octets and not 10", reply->response.data.size()));
}

const Candidate* harmless(Bench& bench) {
    const auto* candidate = bench.subject().harmless();
    if (candidate == nullptr) {
        bench.skip(bench.subject().options().candidates.empty()
                       ? "no connection of the device is known; give --eds"
                       : "the device has no input-only connection, and others need --allow-writes");
    }
    return candidate;
}

const Candidate* harmless_multicast(Bench& bench) {
    const auto* candidate = bench.subject().harmless_multicast();
    if (candidate == nullptr) bench.skip("no connection with multicast inputs is known that may be opened");
    return candidate;
}

const Candidate* of_kind(Bench& bench, Kind kind) {
    const auto* candidate = bench.subject().find(kind);
    if (candidate == nullptr) bench.skip(fmt::format("no {} connection of the device is known", name(kind)));
    return candidate;
}

bool flows(IoLink& link, Bench& bench) {
    constexpr std::size_t some = 3;
    return bench.require(link.run(some, bench.timeout()).size() >= some, "the inputs do not come");
}

class IoLink::Impl {
public:
    Impl(Session& session, IoPlan plan) : session_(session), plan_(std::move(plan)) {}

    void open(const Change& change, bool may_fail) {
        auto& bench = session_.bench();
        if (!session_.is_open()) return;
        const auto own = bench.subject().own.address;
        if (const auto error = port_.open({own, 0}, false); error) {
            bench.require(false, fmt::format("no UDP port for the inputs: {}", error.message()));
            return;
        }
        port_.tell_ttl();
        request_ = open_of(session_, plan_, change);
        std::vector<enip::Item> items;
        if (request_.t_to_o.type == cip::ConnectionType::point_to_point) {
            items.push_back(
                {enip::ItemType::sockaddr_t_to_o, enip::SocketAddress{.port = port_.local().port}.encode()});
        }
        reply_ = session_.call(open_request(request_), std::move(items));
        if (!reply_) return;
        const auto& status = reply_->response.status;
        if (!status.ok()) {
            if (has_no_room(status)) {
                bench.skip("the device has no connection left");
            } else if (!may_fail) {
                bench.require(false, fmt::format("the Forward_Open was refused with {}", cip::describe(status)));
            }
            return;
        }
        must_close_ = true;
        auto grant = check_open_reply(plan_, request_, reply_->response.data, reply_->items, bench.subject().address);
        if (!grant) {
            bench.require(false, "the reply to the Forward_Open makes no sense: " + grant.error().message());
            return;
        }
        grant_ = std::move(*grant);
        if (grant_.group) join(own);
        open_ = true;
        granted_at_ = Clock::now();
    }

    void join(std::uint32_t own) {
        // Heard where the group is the address, so that nobody else's group is taken for this one.
        auto error = group_.open(*grant_.group, true);
        if (!error) error = group_.join(grant_.group->address, own);
        if (!error) group_.tell_ttl();
        if (error) session_.bench().note(fmt::format("the group cannot be joined: {}", error.message()));
    }

    template <class Over>
    std::vector<Datagram> go(bool sends, Time end, Over over) {
        std::vector<Datagram> taken;
        auto due = Clock::now();
        while (!over(taken)) {
            const auto now = Clock::now();
            if (now >= end) break;
            if (sends && now >= due) {
                send(Output{});
                // After a pause it goes on from now.
                due = std::max(due + o_to_t_api(), now);
            }
            wait_until(sends ? std::min(end, due) : end);
            take(taken);
        }
        take(taken);
        return taken;
    }

    void take(std::vector<Datagram>& taken) {
        for (auto* socket : {&port_, &group_}) {
            if (!socket->socket().is_open()) continue;
            while (socket->receive([&](const IoSocket::Received& received) { take(received, taken); }) > 0) {
            }
        }
    }

    void take(const IoSocket::Received& received, std::vector<Datagram>& taken) {
        const auto packet = enip::IoPacket::parse(received.octets);
        const bool ours = packet && packet->connection_id == grant_.reply.t_to_o_id &&
                          received.peer.address == session_.bench().subject().address.address;
        if (recorded_in_ < recorded_datagrams) {
            ++recorded_in_;
            session_.bench().record.add(Step::Kind::came, describe_datagram(received.octets), received.octets);
        }
        if (!ours) {
            ++strays_;
            return;
        }
        taken.push_back({received.time,
                         received.peer,
                         received.local,
                         received.ttl,
                         packet->sequence,
                         {packet->data.begin(), packet->data.end()},
                         {received.octets.begin(), received.octets.end()}});
    }

    void send(const Output& output) {
        const auto sequence = output.sequence ? *output.sequence : ++sequence_;
        const auto count = output.count ? *output.count : ++count_;
        auto data = output.data ? *output.data : idle_data(output.run);
        cip::Bytes octets(enip::io_packet_overhead + cip::sequence_count_octets + data.size());
        auto place = enip::begin_io_packet(octets, output.connection_id.value_or(grant_.reply.o_to_t_id), sequence);
        place[0] = static_cast<std::uint8_t>(count);
        place[1] = static_cast<std::uint8_t>(count >> 8);
        std::ranges::copy(data, place.begin() + cip::sequence_count_octets);
        if (recorded_out_ < recorded_datagrams) {
            ++recorded_out_;
            session_.bench().record.add(Step::Kind::sent, describe_datagram(octets), octets);
        }
        enip::IoQueue queue;
        const enip::IoRoute route{.local = {session_.bench().subject().own.address, 0}, .peer = grant_.target};
        std::ranges::copy(octets, queue.add(route, octets.size()).begin());
        static_cast<void>(port_.send(queue));
        last_sent_ = Clock::now();
    }

    [[nodiscard]] cip::Bytes idle_data(bool run) const {
        using cip::RealTimeFormat;
        const auto& direction = plan_.o_to_t;
        cip::Bytes data;
        if (direction.format == RealTimeFormat::header32) data = u32(run ? cip::run_bit : 0);
        const bool empty =
            direction.format == RealTimeFormat::heartbeat || (direction.format == RealTimeFormat::zero_length && !run);
        if (!empty) data.resize(data.size() + direction.data_octets);
        return data;
    }

    [[nodiscard]] microseconds o_to_t_api() const { return microseconds(grant_.reply.o_to_t_api); }

    std::optional<Reply> close(Session& by) {
        must_close_ = false;
        open_ = false;
        return close_triad(by, request_);
    }

    Session& session_;
    IoPlan plan_;
    cip::ForwardOpen request_{};
    std::optional<Reply> reply_{};
    IoGrant grant_{};
    bool open_ = false;
    bool must_close_ = false;
    Time granted_at_{};
    Time last_sent_{};
    std::uint32_t sequence_ = 0;
    std::uint16_t count_ = 0;
    std::size_t strays_ = 0;
    std::size_t recorded_in_ = 0;
    std::size_t recorded_out_ = 0;

    net::io_context context_{1};
    IoSocket port_{context_.get_executor()};
    IoSocket group_{context_.get_executor()};

private:
    /// Until something has come or the time is over.
    void wait_until(Time end) {
        if (Clock::now() >= end) return;
        bool ready = false;
        std::size_t waiting = 0;
        for (auto* socket : {&port_, &group_}) {
            if (!socket->socket().is_open()) continue;
            ++waiting;
            socket->socket().async_wait(net::socket_base::wait_read, [&](boost::system::error_code) {
                ready = true;
                --waiting;
            });
        }
        while (!ready && waiting > 0 && Clock::now() < end) {
            context_.restart();
            context_.run_one_until(end);
        }
        boost::system::error_code ignored;
        for (auto* socket : {&port_, &group_}) {
            if (socket->socket().is_open()) socket->socket().cancel(ignored);
        }
        while (waiting > 0) {
            context_.restart();
            context_.run();
        }
    }
};

IoLink::IoLink(Session& session, const IoPlan& plan, const Change& change, bool may_fail)
    : impl_(std::make_unique<Impl>(session, plan)) {
    impl_->open(change, may_fail);
}

IoLink::IoLink(IoLink&& other) noexcept = default;

IoLink::~IoLink() {
    if (impl_ && impl_->must_close_ && impl_->session_.is_open()) static_cast<void>(impl_->close(impl_->session_));
}

bool IoLink::is_open() const { return impl_->open_; }
const std::optional<Reply>& IoLink::reply() const { return impl_->reply_; }
const cip::ForwardOpen& IoLink::request() const { return impl_->request_; }
const IoGrant& IoLink::grant() const { return impl_->grant_; }
microseconds IoLink::o_to_t_api() const { return impl_->o_to_t_api(); }
microseconds IoLink::t_to_o_api() const { return microseconds(impl_->grant_.reply.t_to_o_api); }
microseconds IoLink::timeout() const {
    return enip::connection_timeout(o_to_t_api(), impl_->request_.timeout_multiplier);
}
enip::Endpoint IoLink::receiver() const { return impl_->grant_.group.value_or(impl_->port_.local()); }

std::vector<Datagram> IoLink::run(microseconds time) {
    return impl_->go(true, Clock::now() + time, [](const auto&) { return false; });
}

std::vector<Datagram> IoLink::run(std::size_t datagrams, microseconds longest) {
    return impl_->go(true, Clock::now() + longest, [&](const auto& taken) { return taken.size() >= datagrams; });
}

std::vector<Datagram> IoLink::listen(microseconds time) {
    return impl_->go(false, Clock::now() + time, [](const auto&) { return false; });
}

bool IoLink::listen_until_quiet(microseconds quiet, microseconds longest, std::vector<Datagram>& taken) {
    const auto end = Clock::now() + longest;
    for (;;) {
        const auto some = listen(quiet);
        if (some.empty()) return true;
        taken.insert(taken.end(), some.begin(), some.end());
        if (Clock::now() >= end) return false;
    }
}

void IoLink::send(const Output& output) { impl_->send(output); }
Time IoLink::last_sent() const { return impl_->last_sent_; }
std::uint32_t IoLink::last_sequence() const { return impl_->sequence_; }
std::size_t IoLink::strays() const { return impl_->strays_; }

std::optional<Reply> IoLink::close(Session& session) { return impl_->close(session); }
std::optional<Reply> IoLink::close() { return impl_->close(impl_->session_); }
void IoLink::forget() {
    impl_->must_close_ = false;
    impl_->open_ = false;
}

}  // namespace servobus::scanner::conformance
