#include "adapter/adapter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <set>
#include <utility>

#include "adapter/assembly_object.hpp"
#include "adapter/dlr_object.hpp"
#include "adapter/ethernet_link_object.hpp"
#include "adapter/event_words.hpp"
#include "adapter/file_object.hpp"
#include "adapter/forward_open_checks.hpp"
#include "adapter/parameter_object.hpp"
#include "adapter/port_object.hpp"
#include "adapter/qos_object.hpp"
#include "adapter/tcp_ip_object.hpp"
#include "adapter/time_sync.hpp"
#include "adapter/time_sync_object.hpp"
#include "adapter/unkept_reply.hpp"
#include "cip/wire.hpp"

namespace servobus::adapter {
namespace {

using enip::Command;
using enip::EncapsulationStatus;
using enip::Frame;

// The reply to a Reset, or to a Set of the address, is on its way before the connections go (R-ID-8, R-TCP-6).
constexpr std::chrono::milliseconds reply_pause{100};

// Octets of one TCP connection that come while nothing is answered; one that sends more is closed.
constexpr std::size_t held_octets = std::size_t{16} * 1024;
// Replies of one TCP connection that are late on purpose, or wait for what was written to be durable. More are not sent,
// and while the latter is so nothing more is carried out.
constexpr std::size_t late_replies = 1024;

// What the drives of the maker come with is not printed.
constexpr FirmwareVersion first_firmware{1, 0};

// Room for the replies to what one read brings, in octets, which grows when they need more.
constexpr std::size_t usual_replies = 512;

// Shortly before an I/O datagram is due, requests are answered one at a time, so that it does not wait for a whole turn.
constexpr std::chrono::microseconds io_comes_first{100};

bool is_list(Command command) {
    return command == Command::list_services || command == Command::list_identity ||
           command == Command::list_interfaces;
}

// R-ENC-14: the originator's maximum delay; 0 means the default, and less than the shortest is the shortest.
std::chrono::milliseconds maximum_delay(const enip::SenderContext& context) {
    constexpr unsigned standard = 2000;
    constexpr unsigned shortest = 500;
    const unsigned asked = context[0] | static_cast<unsigned>(context[1]) << 8;
    return std::chrono::milliseconds(asked == 0 ? standard : std::max(asked, shortest));
}

// The drive counts whole microseconds on the same clock.
drive::Time to_drive(enip::Time now) { return std::chrono::floor<drive::Time>(now.time_since_epoch()); }

enip::Time to_server(drive::Time time) { return enip::Time(std::chrono::duration_cast<enip::Time::duration>(time)); }

std::optional<enip::Time> to_server(std::optional<drive::Time> time) {
    if (!time) return std::nullopt;
    return to_server(*time);
}

// What stands behind the message in a SendRRData (R-CPF-8). Most have nothing there.
cip::SideItems side_items(const enip::SendDataView& data) {
    constexpr std::size_t address_and_message = 2;
    cip::SideItems items;
    for (std::size_t i = address_and_message; i < data.packet.size(); ++i) {
        const auto item = data.packet[i];
        items.push_back({static_cast<std::uint16_t>(item.type), {item.data.begin(), item.data.end()}});
    }
    return items;
}

template <class T>
void take_earlier(std::optional<T>& best, std::optional<T> candidate) {
    if (candidate && (!best || *candidate < *best)) best = candidate;
}

}  // namespace

/// One TCP connection. `refused`: it came past the limit, and its first request is its last. `expired`: its time is over,
/// and the server knows.
struct Adapter::Connection {
    ConnectionId id = 0;
    enip::Endpoint peer;
    enip::Endpoint local;
    bool refused = false;
    bool closing = false;
    bool expired = false;
    enip::FrameDecoder decoder;
    enip::Time last_message{};  ///< on the bus' time
    cip::Bytes replies;
    struct LateReply {
        enip::Time due;
        Frame reply;
        StateKeeper::Generation waits_for = 0;
    };
    std::deque<LateReply> late;
    cip::Bytes held;  ///< what came while nothing was answered
};

Adapter::Adapter(drive::Device& device, Limits limits, std::uint64_t seed, LogSink log, Network network,
                 DeviceFiles files)
    : device_(device),
      limits_(limits),
      network_(std::move(network)),
      files_(std::move(files)),
      log_(std::move(log)),
      random_(seed),
      sessions_(limits.sessions, random_()),
      firmware_(device.identity().product_code,
                {first_firmware, {device.identity().major_revision, device.identity().minor_revision}}),
      gate_(device, access_log_,
            {.owned = [this]() -> const assemblies::Layout* {
                 const auto* owner = io().owner();
                 return owner != nullptr ? owner->kind->outputs() : nullptr;
             },
             .handle = [this](std::uint64_t session) { return sessions_.handle_of(session); },
             .true_time = [this](enip::Time bus) { return faults_.true_time(bus); }}),
      router_(node_identity(device.identity())),
      faults_(seed),
      keeper_(StoredState{}),
      noted_flash_(firmware_.snapshot()) {
    network_.settings.inactivity_seconds = static_cast<std::uint16_t>(limits_.inactivity.count());
    delivered_ = {network_.settings, {}, firmware_.snapshot()};
    keeper_.start_from({network_.settings, device_.stored(), firmware_.snapshot()});
    router_.set_gate(&gate_);
    build_objects();
    shown_ = module_state();
}

Adapter::~Adapter() = default;

// Also after a restart: what objects remember (counters, written assemblies, a file on its way) does not outlive it.
void Adapter::build_objects() {
    explicit_dscp_ = network_.settings.qos.dscp.back();  // R-QOS-4
    auto identity = std::make_unique<IdentityObject>(
        device_.identity(), [this](ResetType type, enip::Time) { return grant_reset(type); },
        [this] { return condition(); });
    identity_ = identity.get();
    router_.add(std::move(identity));
    auto assembly = std::make_unique<AssemblyObject>(device_);
    assembly->ask_owned([this] { return io().owner() != nullptr; });
    drive_io_ = std::make_unique<DriveIo>(device_, *assembly, log_);
    drive_io_->set_day_clock(system_time_ahead());
    router_.add(std::move(assembly));
    router_.add(std::make_unique<TcpIpObject>(network_, TcpIpSurroundings{
                                                            .io_is_open = [this] { return io().size() > 0; },
                                                            .groups_in_use = [this] { return io().groups_in_use(); },
                                                            .address_changed = [this] { wants_address_ = 0; },
                                                        }));
    router_.add(std::make_unique<EthernetLinkObject>(network_));
    build_time_objects();
    router_.add(std::make_unique<DlrObject>(network_.state.ring));
    auto file_object = std::make_unique<FileObject>(files_);
    file_object_ = file_object.get();
    router_.add(std::move(file_object));
    router_.add(std::make_unique<PortObject>(network_.state));
    auto manager = std::make_unique<ConnectionManager>(router_, node_identity(device_.identity()), *drive_io_, network_,
                                                       limits_, static_cast<std::uint16_t>(random_()), log_);
    manager_ = manager.get();
    manager_->refuse_opens([this](const cip::ForwardOpen& open) { return refuse_open(open); });
    manager_->tell_resources([this] { return resources(); });
    router_.add(std::move(manager));
    std::set<std::uint16_t> classes;
    for (const auto& row : device_.store().table()) classes.insert(row.cip.class_id);
    for (const auto id : classes) router_.add(std::make_unique<ParameterObject>(device_, id));
}

// The DSCP values of PTP are those of a device that has it (R-QOS-2).
void Adapter::build_time_objects() {
    router_.add(std::make_unique<QosObject>(network_.settings.qos, time_sync_ != nullptr));
    if (time_sync_ == nullptr) return;
    auto object = std::make_unique<TimeSyncObject>(*time_sync_, network_, device_.identity());
    time_sync_object_ = object.get();
    router_.add(std::move(object));
}

void Adapter::follow_time(const TimeSync& known) {
    time_sync_ = &known;
    build_time_objects();
}

// System time is that of PTP, once its offset to UTC is known (R-TSY-3).
std::chrono::nanoseconds Adapter::system_time_ahead() const {
    return time_sync_ != nullptr ? day_ahead_ + time_sync_->utc_offset : day_ahead_;
}

// The buffers are those of the replies that peers have not taken yet.
Resources Adapter::resources() const {
    std::size_t waiting = 0;
    for (const auto& [id, connection] : connections_) {
        waiting += connection->replies.size();
        for (const auto& late : connection->late) waiting += enip::header_bytes + late.reply.data.size();
    }
    const auto all = limits_.tcp_connections * limits_.queued_bytes;
    const auto octets = [](std::size_t count) {
        return static_cast<std::uint32_t>(std::min<std::size_t>(count, std::numeric_limits<std::uint32_t>::max()));
    };
    return {.cpu = measure_cpu_ ? measure_cpu_() : std::uint16_t{0},
            .buffer = octets(all),
            .buffer_space = octets(all - std::min(all, waiting))};
}

DeviceCondition Adapter::condition() const {
    auto network = keeper_.newest().network;
    network.last_conflict = delivered_.network.last_conflict;
    return {.owned = io().owner() != nullptr,
            .configured = !keeper_.newest().parameters.empty() || network != delivered_.network,
            .configuration_bad = configuration_bad_,
            .firmware_update = firmware_.is_downloading(),
            .has_address = network_.state.address.configured,
            .fault = device_.has_fault() ? DeviceFault::minor_recoverable : DeviceFault::none,
            .io = io().condition()};
}

std::optional<OpenRefusal> Adapter::refuse_open(const cip::ForwardOpen& open) {
    if (auto status = faults_.refuse_open()) return OpenRefusal{*std::move(status), "as the scenario wants it"};
    if (firmware_.is_downloading() && open.transport.transport_class != explicit_class) {
        return OpenRefusal{cip::GeneralStatus::device_state_conflict, "a download of firmware is in progress"};
    }
    return std::nullopt;
}

std::optional<Adapter::ConnectionId> Adapter::on_open(enip::Endpoint peer, enip::Endpoint local, enip::Time now) {
    advance(now);
    if (faults_.is_down() || firmware_.is_in_factory_mode() ||
        is_stranger(peer, strangers_.connections, "TCP connection", now))
        return std::nullopt;
    const bool refused = !make_room();
    if (refused && limits_.refusals == 0) return std::nullopt;
    auto connection = std::make_unique<Connection>();
    connection->id = ++last_id_;
    connection->peer = peer;
    connection->local = local;
    connection->refused = refused;
    connection->decoder = enip::FrameDecoder(limits_.frame_data_bytes);
    connection->last_message = faults_.bus_time(now);
    if (refused) {
        log_(LogLevel::warning, fmt::format("{} refused: all {} TCP connections are in use", enip::to_string(peer),
                                            limits_.tcp_connections));
    } else {
        log_(LogLevel::debug, fmt::format("{} connected", enip::to_string(peer)));
    }
    const auto id = connection->id;
    connections_.emplace(id, std::move(connection));
    return id;
}

bool Adapter::is_stranger(enip::Endpoint peer, std::uint64_t& count, std::string_view way, enip::Time now) {
    if (allowed_.permits(peer.address)) return false;
    ++count;
    access_log_.note(AccessLog::Kind::stranger, now, [&] {
        return LogLine{.event = "stranger refused",
                       .values = {{"peer", enip::to_string(peer)},
                                  {"via", std::string(way)},
                                  {"why", "not in the list of those who are allowed"}}};
    });
    return true;
}

// Whether one more connection can be served. Those that have connected and then said nothing do not keep out those that
// have something to say; sessions are never taken from anybody.
bool Adapter::make_room() {
    const auto waits = [](const Connection& connection) { return connection.refused && !connection.expired; };
    const auto served = [](const Connection& connection) { return !connection.refused && !connection.expired; };
    const auto count = [&](auto condition) {
        return static_cast<std::size_t>(
            std::ranges::count_if(connections_, [&](const auto& entry) { return condition(*entry.second); }));
    };
    if (count(served) < limits_.tcp_connections) return true;
    auto* idle = longest_silent(
        [&](const Connection& connection) { return served(connection) && sessions_.handle_of(connection.id) == 0; });
    if (idle != nullptr) {
        log_(LogLevel::debug, fmt::format("{} makes room for another", enip::to_string(idle->peer)));
        expire(*idle);
        return true;
    }
    if (limits_.refusals > 0 && count(waits) >= limits_.refusals) expire(*longest_silent(waits));
    return false;
}

Adapter::Connection* Adapter::longest_silent(const std::function<bool(const Connection&)>& condition) const {
    Connection* found = nullptr;
    for (const auto& [id, connection] : connections_) {
        const bool longer = found == nullptr || connection->last_message < found->last_message;
        if (longer && condition(*connection)) found = connection.get();
    }
    return found;
}

void Adapter::expire(Connection& connection) {
    connection.closing = true;
    connection.expired = true;
    expired_.push_back(connection.id);
}

std::size_t Adapter::on_octets(ConnectionId id, cip::ByteView octets, enip::Time now) {
    advance(now);
    const auto found = connections_.find(id);
    if (found == connections_.end()) return octets.size();
    auto& connection = *found->second;
    if (faults_.is_silent()) {
        hold_octets(connection, octets);
        return octets.size();
    }
    auto rest = octets;
    take_messages(connection, rest, now);
    manager_->io().note_changes(faults_.bus_time(now));
    note_lights();
    // What follows an UnRegisterSession or a refusal is nobody's any more.
    return connection.closing ? octets.size() : octets.size() - rest.size();
}

void Adapter::take_messages(Connection& connection, cip::ByteView& rest, enip::Time now) {
    std::size_t messages = 0;
    const auto turn = io_is_due_by(now + io_comes_first) ? 1 : limits_.messages_per_turn;
    while (!rest.empty() && !connection.closing && connection.replies.size() < limits_.queued_bytes &&
           messages < turn) {
        const auto message = connection.decoder.next(rest);
        if (!message) continue;
        on_message(connection, *message, now);
        ++messages;
    }
}

bool Adapter::io_is_due_by(enip::Time time) const {
    const auto next = manager_->io().next_deadline();
    return next && faults_.true_time(*next) <= time;
}

void Adapter::hold_octets(Connection& connection, cip::ByteView octets) {
    if (connection.closing) return;
    if (connection.held.size() + octets.size() > held_octets) {
        log_(LogLevel::info, fmt::format("{} closed: it has sent more than {} octets while nothing is answered",
                                         enip::to_string(connection.peer), held_octets));
        expire(connection);
        return;
    }
    connection.held.insert(connection.held.end(), octets.begin(), octets.end());
    holds_octets_ = true;
}

// The silence is over. There are few of them, so that they need not wait for their turn.
void Adapter::take_held_octets(enip::Time now) {
    if (!holds_octets_ || faults_.is_silent()) return;
    holds_octets_ = false;
    for (auto& [id, connection] : connections_) {
        const auto held = std::exchange(connection->held, {});
        cip::ByteView rest(held);
        while (!rest.empty() && !connection->closing) {
            const auto before = rest.size();
            take_messages(*connection, rest, now);
            if (rest.size() == before) break;
        }
        connection->held.assign(rest.begin(), rest.end());
        holds_octets_ = holds_octets_ || (!rest.empty() && !connection->closing);
        if (!held.empty()) ready_.push_back(id);
    }
}

void Adapter::on_message(Connection& connection, const enip::FrameDecoder::Result& message, enip::Time now) {
    connection.last_message = faults_.bus_time(now);
    const auto& request = message.frame;
    const bool answerable = request.command != Command::nop && request.status == EncapsulationStatus::success;
    if (connection.refused) {
        if (answerable) request.reply(EncapsulationStatus::insufficient_memory).write(connection.replies);
        connection.closing = true;
        return;
    }
    if (!answerable) return;  // R-ENC-8, R-ENC-10
    if (message.oversize) {
        log_(LogLevel::warning,
             fmt::format("{} sent a {} that is longer than {} octets", enip::to_string(connection.peer),
                         enip::describe(request.command), limits_.frame_data_bytes));
        request.reply(EncapsulationStatus::invalid_length).write(connection.replies);
        return;
    }
    if (keeper_.waits() && connection.late.size() >= late_replies) {
        request.reply(EncapsulationStatus::insufficient_memory).write(connection.replies);
        return;
    }
    const auto writes = router_.sets() + resets_granted_;
    const auto reply = answer(connection, request, now);
    const bool wrote = router_.sets() + resets_granted_ != writes;
    note_changes();
    if (wrote && wants_address_) wants_address_ = keeper_.generation();
    schedule_reset(now);
    schedule_address(now);
    if (reply) send_reply(connection, *reply, wrote ? keeper_.generation() : 0, now);
}

// At once, later or never; what is late keeps its order. The reply to a write leaves when everything that has been
// written is durable: also what somebody else has, since it may be the same.
void Adapter::send_reply(Connection& connection, const Frame& reply, StateKeeper::Generation waits_for,
                         enip::Time now) {
    const bool is_explicit = reply.command == Command::send_rr_data || reply.command == Command::send_unit_data;
    const auto delay = is_explicit ? faults_.reply_delay() : std::chrono::microseconds(0);
    if (!delay) return;
    if (delay->count() == 0 && connection.late.empty() && keeper_.is_settled(waits_for)) {
        if (connection.replies.empty()) connection.replies.reserve(usual_replies);
        reply.write(connection.replies);
        return;
    }
    if (connection.late.size() >= late_replies) return;
    for (const auto& late : connection.late) {
        if (late.reply.data == reply.data) waits_for = std::max(waits_for, late.waits_for);  // R-CON-46: said again
    }
    const auto due = now + *delay;
    connection.late.push_back(
        {connection.late.empty() ? due : std::max(due, connection.late.back().due), reply, waits_for});
}

bool Adapter::may_leave(const Connection& connection, enip::Time now) const {
    if (connection.late.empty()) return false;
    const auto& first = connection.late.front();
    return first.due <= now && keeper_.is_settled(first.waits_for);
}

void Adapter::send_late_replies(Connection& connection, enip::Time now) {
    if (faults_.is_silent() || !may_leave(connection, now)) return;
    for (; may_leave(connection, now); connection.late.pop_front()) {
        connection.late.front().reply.write(connection.replies);
    }
    ready_.push_back(connection.id);
}

std::optional<Frame> Adapter::answer(Connection& connection, const Frame& request, enip::Time now) {
    // R-ENC-7: options are dropped without a reply, save in RegisterSession, where they are answered.
    if (request.options != 0) {
        if (request.command != Command::register_session) return std::nullopt;
        return request.reply(EncapsulationStatus::unsupported_protocol);
    }
    if (is_list(request.command)) return list(request, connection.local);
    switch (request.command) {
        case Command::register_session:
            return register_session(connection, request);
        case Command::unregister_session:
            return unregister_session(connection, request);
        case Command::send_rr_data:
            return send_rr_data(connection, request, now);
        case Command::send_unit_data:
            return send_unit_data(connection, request, now);
        default:
            return request.reply(EncapsulationStatus::unsupported_command);  // R-ENC-6
    }
}

Frame Adapter::list(const Frame& request, enip::Endpoint local) const {
    if (!request.data.empty()) return request.reply(EncapsulationStatus::invalid_length);  // R-ENC-11
    enip::CommonPacket packet;
    if (request.command == Command::list_identity) {
        const enip::SocketAddress own{.port = local.port, .address = local.address};
        packet.items.push_back({enip::ItemType::identity, identity_->item(own).encode()});
    } else if (request.command == Command::list_services) {
        packet.items.push_back({enip::ItemType::service_information, enip::ServiceItem{}.encode()});
    }
    return request.reply(EncapsulationStatus::success, packet.encode());
}

Frame Adapter::register_session(const Connection& connection, const Frame& request) {
    const auto wanted = enip::RegisterSession::parse(request.data);
    if (!wanted) return request.reply(EncapsulationStatus::invalid_length);
    auto reply = request.reply(EncapsulationStatus::success, request.data);
    if (wanted->version != enip::protocol_version || wanted->options != 0) {  // R-ENC-18
        reply.status = EncapsulationStatus::unsupported_protocol;
        reply.session = 0;
        reply.data = enip::RegisterSession{}.encode();
        return reply;
    }
    if (const auto existing = sessions_.handle_of(connection.id)) {  // R-ENC-19
        reply.status = EncapsulationStatus::unsupported_command;
        reply.session = existing;
        return reply;
    }
    const auto handle = sessions_.open(connection.id);
    if (!handle) {
        log_(LogLevel::warning,
             fmt::format("{} gets no session: all {} are in use", enip::to_string(connection.peer), limits_.sessions));
        return request.reply(EncapsulationStatus::insufficient_memory);
    }
    log_(LogLevel::info, fmt::format("session 0x{:08X} open for {}", *handle, enip::to_string(connection.peer)));
    reply.session = *handle;
    return reply;
}

// R-ENC-20: honoured with data in it too.
std::optional<Frame> Adapter::unregister_session(Connection& connection, const Frame& request) {
    const auto handle = sessions_.handle_of(connection.id);
    if (handle == 0 || handle != request.session) return request.reply(EncapsulationStatus::invalid_session);
    connection.closing = true;
    return std::nullopt;
}

// What SendRRData and SendUnitData have in common: they need this connection's session and a sound list of items.
boost::system::result<enip::SendDataView, EncapsulationStatus> Adapter::session_data(const Connection& connection,
                                                                                     const Frame& request) const {
    const auto handle = sessions_.handle_of(connection.id);
    if (handle == 0 || handle != request.session) return EncapsulationStatus::invalid_session;
    constexpr std::size_t smallest = 16;  // R-ENC-11
    if (request.data.size() < smallest) return EncapsulationStatus::invalid_length;
    const auto data = enip::SendDataView::parse(request.data);
    if (!data) return EncapsulationStatus::incorrect_data;
    return *data;
}

cip::Origin Adapter::origin_of(const Connection& connection, enip::Time now) const {
    return {.session = connection.id,
            .address = connection.peer.address,
            .port = connection.peer.port,
            .local_address = connection.local.address,
            .reply_limit = limits_.message_bytes,
            .now = faults_.bus_time(now)};
}

Frame Adapter::send_rr_data(const Connection& connection, const Frame& request, enip::Time now) {
    const auto data = session_data(connection, request);
    if (!data) return request.reply(data.error());
    const auto message = enip::unconnected_message(*data);
    if (!message) return request.reply(EncapsulationStatus::incorrect_data);
    const auto items = side_items(*data);
    cip::SideItems reply_items;
    auto origin = origin_of(connection, now);
    origin.items = &items;
    origin.reply_items = &reply_items;
    const auto response = router_.handle(*message, origin);
    if (!response) return request.reply(EncapsulationStatus::incorrect_data);  // R-MSG-3
    std::vector<enip::ItemView> beside;
    for (const auto& item : reply_items) beside.push_back({static_cast<enip::ItemType>(item.type), item.data});
    return request.reply(EncapsulationStatus::success, enip::unconnected_reply(*response, beside));
}

std::optional<Frame> Adapter::send_unit_data(const Connection& connection, const Frame& request, enip::Time now) {
    const auto data = session_data(connection, request);
    if (!data) return request.reply(data.error());
    const auto message = enip::connected_message(*data);
    if (!message) return request.reply(EncapsulationStatus::incorrect_data);
    auto origin = origin_of(connection, now);
    origin.via = cip::Origin::Via::connected;
    auto reply = manager_->on_connected(*message, origin);
    if (!reply) return std::nullopt;  // R-ENC-23
    return request.reply(EncapsulationStatus::success, *std::move(reply));
}

cip::Bytes Adapter::take_replies(ConnectionId id) {
    const auto found = connections_.find(id);
    return found != connections_.end() ? std::exchange(found->second->replies, {}) : cip::Bytes{};
}

bool Adapter::wants_close(ConnectionId id) const {
    const auto found = connections_.find(id);
    return found == connections_.end() || found->second->closing;
}

void Adapter::on_closed(ConnectionId id, enip::Time) {
    const auto found = connections_.find(id);
    if (found == connections_.end()) return;
    if (const auto handle = sessions_.handle_of(id)) {
        log_(LogLevel::info, fmt::format("session 0x{:08X} of {} ended", handle, enip::to_string(found->second->peer)));
    }
    sessions_.close(id);
    manager_->on_session_closed(id);
    file_object_->on_session_closed(id);
    connections_.erase(found);
    note_lights();
}

void Adapter::on_datagram(enip::Endpoint peer, enip::Endpoint local, bool broadcast, cip::ByteView octets,
                          enip::Time now) {
    faults_.advance(now);
    if (is_mute() || is_stranger(peer, strangers_.requests, "UDP request", now)) return;
    const auto request = Frame::parse(octets);
    if (!request || request->status != EncapsulationStatus::success || request->options != 0) return;
    if (request->command == Command::nop) return;
    if (is_list(request->command)) {
        enip::Datagram reply{local, peer, list(*request, local).encode()};
        if (broadcast && request->command == Command::list_identity) {
            if (!delay(std::move(reply), *request, now)) log_(LogLevel::debug, "too many broadcasts, one is dropped");
            return;
        }
        datagrams_.push_back(std::move(reply));
        return;
    }
    // R-ENC-5: sessions live on TCP only, and R-ENC-6. A broadcast of nonsense is not worth a reply of every device.
    if (broadcast) return;
    datagrams_.push_back({local, peer, request->reply(EncapsulationStatus::unsupported_command).encode()});
}

void Adapter::on_io(enip::Endpoint peer, enip::Endpoint, cip::ByteView octets, enip::Time now) {
    advance(now);
    if (firmware_.is_in_factory_mode() || is_stranger(peer, strangers_.datagrams, "I/O datagram", now)) return;
    const auto bus_time = faults_.bus_time(now);
    if (faults_.filter_in(peer, octets, now)) manager_->io().on_datagram(peer, octets, bus_time);
    take_late_io(now);
    manager_->io().note_changes(bus_time);
}

void Adapter::take_late_io(enip::Time now) {
    while (const auto late = faults_.take_in(now)) {
        manager_->io().on_datagram(late->peer, late->octets, faults_.bus_time(now));
    }
}

// While the bus side is frozen its time stands still: no timeout, and nothing that is due.
void Adapter::produce(enip::Time now) {
    auto& queue = faults_.leaves_output_alone() ? io_queue_ : produced_;
    if (!faults_.is_frozen()) {
        const auto bus_time = faults_.bus_time(now);
        manager_->io().note_changes(bus_time);
        manager_->on_timer(bus_time, queue);
    }
    if (&queue == &io_queue_) return;
    faults_.filter_out(produced_, now);
    io_queue_.append(produced_);
    produced_.clear();
}

bool Adapter::delay(enip::Datagram datagram, const Frame& request, enip::Time now) {
    if (delayed_.size() >= limits_.delayed_replies) return false;
    std::uniform_int_distribution<std::int64_t> wait(0, maximum_delay(request.context).count());
    delayed_.push_back({now + std::chrono::milliseconds(wait(random_)), std::move(datagram)});
    return true;
}

std::vector<enip::Datagram> Adapter::take_datagrams() { return std::exchange(datagrams_, {}); }

std::vector<Adapter::ConnectionId> Adapter::take_expired() { return std::exchange(expired_, {}); }

std::vector<Adapter::ConnectionId> Adapter::take_ready() { return std::exchange(ready_, {}); }

// One that is closing has a deadline too: its peer may never take the last replies.
std::optional<enip::Time> Adapter::deadline_of(const Connection& connection) const {
    if (connection.expired || faults_.is_frozen()) return std::nullopt;
    const auto since = faults_.true_time(connection.last_message);
    if (connection.refused) return since + limits_.refusal_patience;
    if (network_.settings.inactivity_seconds == 0) return std::nullopt;
    return since + std::chrono::seconds(network_.settings.inactivity_seconds);
}

void Adapter::on_timer(enip::Time now) {
    advance(now);
    change_address(now);
    rivalry_.on_timer(now);
    reset(now);
    take_late_io(now);
    produce(now);
    std::erase_if(delayed_, [&](DelayedReply& reply) {
        if (reply.due > now) return false;
        if (!is_mute()) datagrams_.push_back(std::move(reply.datagram));
        return true;
    });
    for (auto& [id, connection] : connections_) {
        send_late_replies(*connection, now);
        const auto deadline = deadline_of(*connection);
        if (!deadline || *deadline > now) continue;
        if (!connection->refused) {
            log_(LogLevel::info, fmt::format("{} closed: no message for {} s", enip::to_string(connection->peer),
                                             network_.settings.inactivity_seconds));
        }
        expire(*connection);
    }
    access_log_.on_timer(now);
    note_changes();
    note_lights();
}

std::optional<enip::Time> Adapter::next_deadline() const {
    auto next = faults_.next_deadline();
    take_earlier(next, access_log_.next_deadline());
    take_earlier(next, firmware_.next_deadline());
    if (!faults_.is_frozen()) {
        if (const auto bus_time = manager_->next_deadline()) {
            take_earlier(next, std::optional(faults_.true_time(*bus_time)));
        }
    }
    take_earlier(next, to_server(device_.next_deadline()));
    take_earlier(next, to_server(playback_.next()));
    if (reset_) take_earlier(next, reset_->due);
    take_earlier(next, address_due_);
    take_earlier(next, rivalry_.next_deadline());
    for (const auto& reply : delayed_) take_earlier(next, std::optional(reply.due));
    for (const auto& [id, connection] : connections_) {
        take_earlier(next, deadline_of(*connection));
        const bool waits = connection->late.empty() || !keeper_.is_settled(connection->late.front().waits_for);
        if (!waits && !faults_.is_silent()) {
            take_earlier(next, std::optional(connection->late.front().due));
        }
    }
    return next;
}

cip::GeneralStatus Adapter::grant_reset(ResetType type) {
    const auto* owner = io().owner();
    if (owner != nullptr && owner->consumer.run()) return cip::GeneralStatus::device_state_conflict;  // R-ID-8
    if (firmware_.is_downloading()) return cip::GeneralStatus::device_state_conflict;  // it would end in factory mode
    if (reset_ && reset_->type != type) return cip::GeneralStatus::device_state_conflict;
    ++resets_granted_;
    if (reset_) return cip::GeneralStatus::success;  // asking again does not put it off
    if (type != ResetType::restart) keeper_.change(after_reset(type));
    reset_ = Reset{type, keeper_.generation(), std::nullopt};
    return cip::GeneralStatus::success;
}

// Everything that a client can set goes back; the latest conflict is a record, not a setting.
StoredState Adapter::after_reset(ResetType type) const {
    auto state = delivered_;
    if (type == ResetType::factory_defaults_keep_network) state.network = network_.settings;
    state.network.last_conflict = network_.settings.last_conflict;
    state.firmware = firmware_.snapshot();
    return state;
}

// The time counts from when the reply may leave.
void Adapter::schedule_reset(enip::Time now) {
    if (reset_ && !reset_->due && keeper_.is_settled(reset_->waits_for)) reset_->due = now + reply_pause;
}

void Adapter::schedule_address(enip::Time now) {
    if (!wants_address_ || !keeper_.is_settled(*wants_address_)) return;
    wants_address_.reset();
    address_due_ = now + reply_pause;
}

void Adapter::reset(enip::Time now) {
    if (!reset_ || !reset_->due || *reset_->due > now) return;
    log_(LogLevel::info, reset_->type == ResetType::restart
                             ? "restart: all connections are closed"
                             : "factory defaults and restart: all connections are closed");
    restart();
}

// Logic power has been off: what objects and connections remember is forgotten, and what is kept comes back.
void Adapter::restart() {
    note_changes();
    reset_.reset();  // what it asked for has happened
    end_connections();
    keeper_.cut_power();
    come_up();
}

void Adapter::come_up() {
    const auto state = keeper_.newest();
    network_.settings = state.network;
    device_.power_up(state.parameters);
    noted_writes_ = device_.lasting_writes();
    configuration_bad_ = false;
    wants_address_.reset();
    start_firmware();
    apply_address(AddressChange::restart);
}

void Adapter::power_up_with(const StoredState& state) {
    firmware_.restore(state.firmware);
    noted_flash_ = state.firmware;
    keeper_.start_from(state);
    come_up();
    shown_ = module_state();
}

// Whoever has changed what is kept: a request, a command that has ended by now, the network, a download. What is written
// while factory defaults are on their way goes with the rest.
void Adapter::note_changes() {
    if (reset_ && reset_->type != ResetType::restart) return;
    const auto writes = device_.lasting_writes();
    if (writes == noted_writes_ && !came_to_rest_ && firmware_.snapshot() == noted_flash_ &&
        network_.settings == keeper_.newest().network) {
        return;
    }
    noted_writes_ = writes;
    came_to_rest_ = false;
    noted_flash_ = firmware_.snapshot();
    keeper_.change({network_.settings, device_.stored(), noted_flash_});
}

void Adapter::on_stored(bool ok, enip::Time now) {
    if (!ok) take_back();
    keeper_.on_stored(ok);
    if (ok) configuration_bad_ = false;
    schedule_reset(now);
    schedule_address(now);
    for (auto& [id, connection] : connections_) send_late_replies(*connection, now);
}

// Those who wait for it hear that it is not kept, and nobody finds it afterwards.
void Adapter::take_back() {
    refuse_waiting_replies();
    const auto& kept = keeper_.durable();
    network_.settings = kept.network;
    device_.restore(kept.parameters);
    noted_writes_ = device_.lasting_writes();
    if (reset_ && reset_->type != ResetType::restart) reset_.reset();
    if (wants_address_) network_.state.address.pending = false;
    wants_address_.reset();
}

void Adapter::refuse_waiting_replies() {
    std::size_t refused = 0;
    for (auto& [id, connection] : connections_) {
        for (auto& late : connection->late) {
            if (keeper_.is_settled(late.waits_for)) continue;
            late.reply = unkept(late.reply);
            manager_->amend(id, late.reply);
            ++refused;
        }
    }
    log_(LogLevel::error,
         fmt::format("what was written could not be stored and is taken back; {} requests are refused", refused));
}

// Reply first, then apply (R-TCP-6).
void Adapter::change_address(enip::Time now) {
    if (!address_due_ || *address_due_ > now) return;
    log_(LogLevel::info, "the address settings have changed: all connections are closed");
    give_address_up();
    apply_address(AddressChange::set);
}

void Adapter::apply_address(AddressChange change) {
    address_due_.reset();
    if (change_address_) {
        change_address_(change);
    } else {
        if (change == AddressChange::restart) rivalry_.restart();
        apply_address_settings(network_);
    }
}

// With an address of its own the drive hears of rivals from the network.
void Adapter::suffer(const fault::ClaimAddress& claim, enip::Time now) {
    if (network_.state.address_service != AddressService::none) {
        log_(LogLevel::warning, "the address is a real one: nobody can claim it by an event");
        return;
    }
    MacAddress rival{};
    for (std::size_t i = 0; i < rival.size(); ++i) rival[i] = static_cast<std::uint8_t>(claim.mac >> (40 - 8 * i));
    const auto address = enip::address_text(network_.state.interface.address);
    switch (rivalry_.claim(rival, now)) {
        case AddressRivalry::Outcome::unnoticed:
            log_(LogLevel::info, "the claim is not noticed: conflict detection is off, or there is no address");
            break;
        case AddressRivalry::Outcome::defended:
            log_(LogLevel::warning, fmt::format("{} is claimed by {} too; it is defended", address, to_string(rival)));
            break;
        case AddressRivalry::Outcome::lost:
            log_(LogLevel::error,
                 fmt::format("{} belongs to {}: all connections are closed", address, to_string(rival)));
            give_address_up();
            break;
    }
}

void Adapter::give_address_up() {
    manager_->io().abandon();
    shut_down();
}

// Each event meets the drive as it is at the event's own time, however late the timer comes.
void Adapter::advance(enip::Time now) {
    const auto time = to_drive(now);
    playback_.start(time);
    while (const auto due = playback_.take(time)) {
        device_.step(due->at);
        static_cast<void>(apply(due->event, to_server(due->at)));
    }
    device_.step(time);
    const bool moves = device_.next_deadline().has_value();
    came_to_rest_ = came_to_rest_ || (moves_ && !moves);
    moves_ = moves;
    faults_.advance(now);
    file_object_->on_time(faults_.bus_time(now));
    advance_firmware(now);
    drive_io_->set_day_clock(system_time_ahead() + faults_.frozen());
    if (time_sync_object_ != nullptr) time_sync_object_->on_time(now, system_time_ahead());
    take_held_octets(now);
}

bool Adapter::inject(const Happening& event, enip::Time now) {
    advance(now);
    const bool taken = apply(event, now);
    manager_->io().note_changes(faults_.bus_time(now));
    take_held_octets(now);
    manager_->io().note_changes(faults_.bus_time(now));
    note_changes();
    note_lights();
    return taken;
}

drive::Time Adapter::elapsed(enip::Time now) const { return playback_.elapsed(to_drive(now)); }

bool Adapter::apply(const Happening& event, enip::Time now) {
    advance_firmware(now);  // what is written by now is there also when the power goes
    log_(LogLevel::info, fmt::format("event: {}", describe(event)));
    if (const auto* fault = std::get_if<NetworkFault>(&event)) return begin(*fault, now);
    const auto& machine = std::get<drive::Event>(event);
    if (std::holds_alternative<drive::event::PowerCycle>(machine)) {
        restart();
    } else {
        device_.inject(machine);
    }
    return true;
}

bool Adapter::begin(const NetworkFault& fault, enip::Time now) {
    if (!faults_.begin(fault, now)) {
        log_(LogLevel::warning,
             fmt::format("there are {} network faults already; this one is left out", NetworkFaults::max_active));
        return false;
    }
    if (std::holds_alternative<fault::Restart>(fault)) {
        restart();
    } else if (const auto* claim = std::get_if<fault::ClaimAddress>(&fault)) {
        suffer(*claim, now);
    } else if (const auto* close = std::get_if<fault::CloseSessions>(&fault)) {
        for (auto& [id, connection] : connections_) {
            const auto handle = sessions_.handle_of(id);
            const bool meant = close->session == 0 ? handle != 0 : handle == close->session;
            if (meant && !connection->expired) expire(*connection);
        }
    }
    return true;
}

// The flash has been written up to now.
void Adapter::advance_firmware(enip::Time now) {
    if (!firmware_.is_downloading()) return;
    firmware_.advance(now);
    if (firmware_.is_downloading()) return;
    log_(LogLevel::info, fmt::format("firmware {} is in the flash; it runs after power off and on",
                                     to_string(firmware_.snapshot().release.version)));
}

// To all who say it, or compare it with something.
void Adapter::tell_revision(Revision revision) {
    const auto& identity = device_.identity();
    if (revision == Revision{identity.major_revision, identity.minor_revision}) return;
    device_.set_revision(revision.major, revision.minor);
    router_.set_node(node_identity(identity));
    if (make_sheet_) files_.eds = make_sheet_(identity);
}

// What is in the flash now speaks to the bus, and nothing that it remembered is left.
void Adapter::start_firmware() {
    const auto before = firmware_.running();
    firmware_.power_cycle();
    if (const auto& now = firmware_.running()) {
        tell_revision(now->revision);
        if (now != before) {
            log_(LogLevel::info, fmt::format("firmware {} runs, revision {}.{}", to_string(now->version),
                                             now->revision.major, now->revision.minor));
        }
    } else {
        log_(LogLevel::warning,
             fmt::format("factory mode: the flash has no whole {}; nothing is answered until there is an image",
                         firmware_.has_bit_stream() ? "firmware" : "bit stream"));
    }
    build_objects();
}

std::optional<std::string> Adapter::download(const FlashImage& image, enip::Time now) {
    advance(now);
    const auto* owner = io().owner();
    if (owner != nullptr && owner->consumer.run())
        return "an owner runs the drive; it has to go to idle or close first";
    if (auto wrong = firmware_.download(image, now)) return wrong;
    log_(LogLevel::info, fmt::format("download of firmware {} begins, {} octets", to_string(image.version),
                                     image.bit_stream_octets + image.firmware_octets));
    note_changes();
    note_lights();
    return std::nullopt;
}

std::optional<std::string> Adapter::install(const FlashImage& image) {
    if (auto wrong = firmware_.install(image)) return wrong;
    delivered_.firmware = noted_flash_ = firmware_.snapshot();
    keeper_.start_from({network_.settings, device_.stored(), noted_flash_});
    start_firmware();
    shown_ = module_state();
    return std::nullopt;
}

ModuleState Adapter::module_state() const {
    constexpr drive::Key status_word{0x66, 0x01};
    constexpr std::int64_t fault_bit = 1 << 3;
    const auto* row = device_.find(status_word);
    const auto* word = row != nullptr ? std::get_if<std::int64_t>(&device_.store().value(*row)) : nullptr;
    const auto& address = network_.state.address;
    const bool conflict = address.conflict || address.without_address;  // R-LED-2
    return {.powered = !faults_.is_down(),
            .initialising = !address.configured && !conflict,
            .connected = io().size() + class3_connections() > 0,
            .address_conflict = conflict,
            .fault = word != nullptr && (*word & fault_bit) != 0,
            .factory_mode = firmware_.is_in_factory_mode(),
            .valid_bit_stream = firmware_.has_bit_stream(),
            .download = firmware_.is_downloading()};
}

// Connections have lines of their own in the log, so that RUN is for those who look closely.
void Adapter::note_lights() {
    const auto state = module_state();
    if (state == shown_) return;
    const auto before = status_lights(std::exchange(shown_, state));
    const auto now = status_lights(state);
    for (std::size_t i = 0; i < now.size(); ++i) {
        if (now[i] == before[i]) continue;
        const auto level = static_cast<Light>(i) == Light::run ? LogLevel::debug : LogLevel::info;
        log_(level, fmt::format("light {}: {}{}{}", light_names[i], name(now[i].mode),
                                now[i].meaning.empty() ? "" : ", ", now[i].meaning));
    }
}

std::vector<std::pair<std::uint32_t, enip::Endpoint>> Adapter::open_sessions() const {
    std::vector<std::pair<std::uint32_t, enip::Endpoint>> all;
    for (const auto& [id, connection] : connections_) {
        if (const auto handle = sessions_.handle_of(id)) all.emplace_back(handle, connection->peer);
    }
    return all;
}

void Adapter::end_connections() {
    access_log_.flush();
    for (auto& [id, connection] : connections_) {
        connection->late.clear();
        expire(*connection);
    }
}

void Adapter::shut_down() {
    note_changes();
    end_connections();
}

}  // namespace servobus::adapter
