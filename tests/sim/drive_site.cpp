#include "tests/sim/drive_site.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "drive/xenax.hpp"
#include "tests/support/rotative_axis.hpp"

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;

/// Later than this, what has come in time is looked at before the timers are (enip/asio/target_station.cpp).
constexpr auto late = 500us;

constexpr drive::Key mode_requested{0x66, 0x20};
constexpr drive::Key quick_stop_deceleration{0x66, 0x45};

/// A rotative axis that knows its place from the first moment and turns without end, so that owners may move it at once.
drive::AxisKind axis() {
    auto kind = test::rotative_axis();
    kind.key = "sim-rotative";
    kind.name = "simulated rotative axis";
    kind.reference = drive::AxisKind::Reference::absolute;
    return kind;
}

std::unique_ptr<drive::Device> make_device(const DriveSpec& spec, std::uint64_t seed) {
    auto device = std::make_unique<drive::Device>(drive::xenax_models().front(), drive::Machine{axis(), seed},
                                                  drive::Motor::rotative);
    // A quick stop that takes a while, so that there is a way on which it could go wrong.
    device->deliver(
        {{mode_requested, std::int64_t{spec.jog ? -1 : 1}}, {quick_stop_deceleration, std::int64_t{200'000}}});
    return device;
}

adapter::Network network_of(unsigned number) {
    adapter::Network network;
    network.state.interface.address = Neighbourhood::drive_address(number);
    network.state.interface.mask = 0xFFFFFF00;
    return network;
}

}  // namespace

DriveSite::DriveSite(unsigned number, const DriveSpec& spec, std::uint64_t seed, EventQueue& queue, Wire& wire,
                     Neighbourhood& neighbourhood, Judge& judge)
    : number_(number),
      spec_(spec),
      random_(seed, 100 + number),
      queue_(queue),
      wire_(wire),
      neighbourhood_(neighbourhood),
      judge_(judge),
      watch_(number, judge) {
    start();
}

void DriveSite::start() {
    powered_ = true;
    device_ = make_device(spec_, random_.next());
    adapter_ = std::make_unique<adapter::Adapter>(*device_, adapter::Limits{}, random_.next(), adapter::LogSink{},
                                                  network_of(number_));
    armed_.reset();
    adapter_->on_timer(queue_.now());
    after_event();
}

// --------------------------------------------------------------------------------------------- what befalls it

void DriveSite::kill(microseconds duration, bool silent) {
    if (!adapter_) return;
    for (const auto& [stream, id] : ids_) wire_.abort(stream, End::drive, silent);
    for (const auto stream : kernel_accepted_) wire_.abort(stream, End::drive, silent);
    kernel_accepted_.clear();
    ids_.clear();
    for (const auto& [id, peer] : peers_) watch_.stream_closed(id);
    peers_.clear();
    adapter_.reset();
    device_.reset();
    kernel_io_.clear();
    kernel_rest_.clear();
    held_up_ = false;
    powered_ = !silent;
    watch_.restarted(queue_.now(), {});
    queue_.after(duration, [this, life = ++life_] {
        if (life == life_) start();
    });
}

void DriveSite::power_cycle() {
    whenever_it_runs([this] {
        watch_.restarted(queue_.now(), {});
        adapter_->inject(drive::event::PowerCycle{}, queue_.now());
        after_event();
    });
}

void DriveSite::restart(microseconds duration) {
    whenever_it_runs([this, duration] {
        watch_.restarted(queue_.now(), queue_.now() + duration);
        adapter_->inject(adapter::NetworkFault(adapter::fault::Restart{static_cast<double>(duration.count()) * 1e-6}),
                         queue_.now());
        after_event();
    });
}

void DriveSite::close_sessions() {
    whenever_it_runs([this] {
        watch_.sessions_closed_on_purpose();
        adapter_->inject(adapter::NetworkFault(adapter::fault::CloseSessions{}), queue_.now());
        after_event();
    });
}

void DriveSite::hold_up(microseconds duration) {
    if (!adapter_) return;
    held_until_ = std::max(held_until_, queue_.now() + duration);
    held_up_ = true;
    queue_.at(held_until_, [this, life = life_] {
        if (life == life_ && held_up_ && held_until_ <= queue_.now()) wake();
    });
}

// ------------------------------------------------------------------------------------------------ what arrives

void DriveSite::whenever_it_runs(std::function<void()> what) {
    if (!adapter_) return;
    if (held_up_) {
        kernel_rest_.push_back(std::move(what));
    } else {
        what();
    }
}

/// As TargetStation::catch_up(): what has come in time counts, also when nobody could look at it.
void DriveSite::wake() {
    held_up_ = false;
    watch_.was_held_up(queue_.now());
    static_cast<void>(catch_up());
    flush();
    take_kernel_io();
    after_event();
    while (!kernel_rest_.empty() && adapter_ && !held_up_) {
        const auto next = std::move(kernel_rest_.front());
        kernel_rest_.pop_front();
        next();
    }
}

void DriveSite::on_packet(const Packet& packet) {
    if (!adapter_) return;
    if (packet.destination.port == enip::io_port) {
        if (held_up_) {
            kernel_io_.emplace_back(queue_.now(), packet);
            return;
        }
        take_io(packet, queue_.now());
        after_event();
        return;
    }
    whenever_it_runs([this, packet] {
        const bool broadcast = packet.destination.address != Neighbourhood::drive_address(number_);
        adapter_->on_datagram(packet.source, {Neighbourhood::drive_address(number_), enip::tcp_port}, broadcast,
                              packet.octets, queue_.now());
        after_event();
    });
}

/// Each with the time at which the kernel took it, however late it is looked at; but time does not go back.
void DriveSite::take_kernel_io() {
    while (!kernel_io_.empty()) {
        const auto [came, packet] = std::move(kernel_io_.front());
        kernel_io_.pop_front();
        take_io(packet, came);
    }
}

void DriveSite::take_io(const Packet& packet, Time came) {
    came = latest_ = std::max(latest_, came);
    watch_.hears_io(packet.source.address, packet.octets, came);
    adapter_->on_io(packet.source, packet.destination, packet.octets, came);
}

void DriveSite::on_accepted(StreamId id, enip::Endpoint peer, enip::Endpoint local) {
    kernel_accepted_.insert(id);
    whenever_it_runs([this, id, peer, local] {
        kernel_accepted_.erase(id);
        const auto connection = adapter_->on_open(peer, local, queue_.now());
        if (!connection) {
            wire_.close(id, End::drive);
            return;
        }
        peers_[*connection].stream = id;
        ids_[id] = *connection;
        watch_.stream_opened(*connection, peer.address, queue_.now());
        after_event();
    });
}

void DriveSite::on_octets(StreamId id, cip::ByteView octets) {
    if (!held_up_) {
        take_octets(id, octets);
        return;
    }
    whenever_it_runs([this, id, kept = cip::Bytes(octets.begin(), octets.end())] { take_octets(id, kept); });
}

void DriveSite::take_octets(StreamId id, cip::ByteView octets) {
    if (!adapter_ || !ids_.contains(id)) return;
    const auto connection = ids_.at(id);
    const auto now = queue_.now();
    while (!octets.empty() && ids_.contains(id)) {
        if (catch_up()) flush();  // what was due before comes before
        auto& peer = peers_.at(connection);
        // The books hear what the adapter has taken, before they see what it says to it.
        const auto taken = adapter_->on_octets(connection, octets, now);
        auto heard = octets.first(taken);
        while (!heard.empty()) {
            if (const auto message = peer.heard.next(heard)) watch_.hears(connection, message->frame, now);
        }
        octets = octets.subspan(taken);
        send_replies(connection);
        after_event();
    }
}

void DriveSite::on_end(StreamId id) {
    whenever_it_runs([this, id] { take_end(id); });
}

void DriveSite::take_end(StreamId id) {
    const auto found = ids_.find(id);
    if (found == ids_.end()) return;
    const auto connection = found->second;
    ids_.erase(found);
    peers_.erase(connection);
    adapter_->on_closed(connection, queue_.now());
    watch_.stream_closed(connection);
    after_event();
}

// ------------------------------------------------------------------------------------------------- what goes out

bool DriveSite::catch_up() {
    const auto next = adapter_->next_deadline();
    if (!next || *next > queue_.now()) return false;
    if (queue_.now() - *next > late) take_kernel_io();
    adapter_->on_timer(latest_ = queue_.now());
    if (adapter_->next_deadline() == next) {
        judge_.report(Invariant::time_goes_on, queue_.now(), fmt::format("drive {}: a deadline stays", number_));
    }
    return true;
}

void DriveSite::after_event() {
    static_cast<void>(catch_up());
    flush();
    if (adapter_) {
        watch_.settle(*adapter_, queue_.now());
        arm();
    }
}

void DriveSite::flush() {
    auto& io = adapter_->io_queue();
    for (const auto& entry : io.entries()) {
        const auto octets = std::as_const(io).octets(entry);
        watch_.produces(entry.route, octets, queue_.now());
        const enip::Endpoint source{Neighbourhood::drive_address(number_), enip::io_port};
        if (!enip::is_multicast(entry.route.peer.address)) {
            if (const auto node = Neighbourhood::node_at(entry.route.peer.address)) {
                wire_.send(*node, number_, End::node, source, entry.route.peer, octets);
            }
        } else if (const auto* members = neighbourhood_.members(entry.route.peer.address)) {
            for (const auto node : *members) wire_.send(node, number_, End::node, source, entry.route.peer, octets);
        }
    }
    io.clear();
    for (const auto& datagram : adapter_->take_datagrams()) {
        if (const auto node = Neighbourhood::node_at(datagram.peer.address)) {
            wire_.send(*node, number_, End::node, datagram.local, datagram.peer, datagram.octets);
        }
    }
    for (const auto id : adapter_->take_ready()) send_replies(id);
    for (const auto id : adapter_->take_expired()) {
        watch_.stream_expired(id, queue_.now());
        end(id);
    }
}

void DriveSite::send_replies(ConnectionId id) {
    const auto found = peers_.find(id);
    if (found == peers_.end()) return;
    const auto replies = adapter_->take_replies(id);
    cip::ByteView said(replies);
    while (!said.empty()) {
        if (const auto message = found->second.said.next(said)) watch_.says(id, message->frame, queue_.now());
    }
    if (!replies.empty()) wire_.write(found->second.stream, End::drive, replies);
    if (adapter_->wants_close(id)) end(id);
}

void DriveSite::end(ConnectionId id) {
    const auto found = peers_.find(id);
    if (found == peers_.end()) return;
    wire_.close(found->second.stream, End::drive);
    ids_.erase(found->second.stream);
    peers_.erase(found);
    adapter_->on_closed(id, queue_.now());
    watch_.stream_closed(id);
}

/// A deadline that has moved later is noticed when the timer fires.
void DriveSite::arm() {
    const auto next = adapter_->next_deadline();
    if (!next || (armed_ && *armed_ <= *next && *armed_ > queue_.now())) return;
    armed_ = *next;
    queue_.at(*next, [this, when = *next, life = life_] {
        if (life != life_ || !adapter_ || armed_ != when) return;
        armed_.reset();
        if (held_up_) return;  // wake() looks
        after_event();
    });
}

void DriveSite::expect_nothing() {
    if (adapter_) watch_.expect_nothing(*adapter_, queue_.now());
}

}  // namespace servobus::sim
