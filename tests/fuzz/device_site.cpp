#include "tests/fuzz/device_site.hpp"

#include <algorithm>

#include "cip/services.hpp"
#include "enip/frame_decoder.hpp"
#include "enip/io_packet.hpp"
#include "scanner/class3.hpp"
#include "scanner/io_plan.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using cip::Bytes;
using cip::ByteView;
using test::require;

constexpr std::uint64_t seed = 1;
constexpr std::size_t most_at_once = 17;  // datagrams of one connection, when the timer comes late

const auto get_vendor = cip::Request{cip::service::get_attribute_single, cip::Path::to(0x01, 1, 1), {}};

}  // namespace

DeviceSite::DeviceSite(adapter::Limits limits, adapter::DeviceFiles files)
    : adapter_(device_, limits, seed, {}, {}, std::move(files)) {}

std::optional<DeviceSite::Id> DeviceSite::connect(std::size_t peer_number) {
    const auto id = adapter_.on_open(peer(peer_number), local, now_);
    if (id) sessions_[*id] = 0;
    settle();
    check_bounds({});
    return id && is_open(*id) ? id : std::nullopt;
}

void DeviceSite::disconnect(Id id) {
    if (sessions_.erase(id) > 0) adapter_.on_closed(id, now_);
}

std::vector<DeviceSite::Id> DeviceSite::open() const {
    std::vector<Id> ids;
    for (const auto& [id, session] : sessions_) ids.push_back(id);
    return ids;
}

std::uint32_t DeviceSite::session(Id id) const {
    const auto found = sessions_.find(id);
    return found == sessions_.end() ? 0 : found->second;
}

Bytes DeviceSite::send(Id id, ByteView octets, std::size_t piece_octets) {
    Bytes replies;
    auto rest = octets;
    while (!rest.empty() && is_open(id) && !adapter_.wants_close(id)) {
        const auto front = rest.first(std::min(piece_octets, rest.size()));
        const Bytes piece(front.begin(), front.end());
        const auto taken = adapter_.on_octets(id, piece, now_);
        require(taken <= piece.size(), "no more is taken than there was", octets);
        const auto some = adapter_.take_replies(id);
        require(taken > 0 || !some.empty(), "a device that takes nothing has something to say", octets);
        require(some.size() <= adapter_.limits().queued_bytes + enip::max_data_bytes + enip::header_bytes,
                "the replies that wait are bounded", octets);
        replies.insert(replies.end(), some.begin(), some.end());
        rest = rest.subspan(taken);
    }
    check_replies(replies, octets);
    settle();
    check_bounds(octets);
    return replies;
}

std::optional<enip::Frame> DeviceSite::ask(Id id, const enip::Frame& request) {
    const auto replies = send(id, request.encode());
    if (replies.empty()) return std::nullopt;
    auto reply = enip::Frame::parse(replies);
    require(reply && reply->encode().size() == replies.size(), "one frame has one reply", replies);
    require(reply->command == request.command && reply->context == request.context,
            "a reply has the command and the context of its request", replies);
    return *reply;
}

bool DeviceSite::register_session(Id id) {
    const auto reply = ask(id, {.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()});
    if (!reply || reply->status != enip::EncapsulationStatus::success) return false;
    require(reply->session != 0, "a session has a handle", reply->data);
    sessions_[id] = reply->session;
    return true;
}

std::optional<cip::Response> DeviceSite::call(Id id, ByteView message) {
    const auto reply = ask(id, {.command = enip::Command::send_rr_data,
                                .session = session(id),
                                .data = enip::SendData::unconnected({message.begin(), message.end()}).encode()});
    require(reply.has_value(), "every SendRRData is answered", message);
    if (message.size() < 2) {
        require(reply->status != enip::EncapsulationStatus::success, "less than two octets are no request", message);
        return std::nullopt;
    }
    require(reply->status == enip::EncapsulationStatus::success, "every request of two octets is answered", message);
    const auto data = enip::SendData::parse(reply->data);
    require(data.has_value(), "the reply is a list of items", reply->data);
    const auto answer = enip::unconnected_message(*data);
    require(answer.has_value(), "the reply has an answer in it", reply->data);
    require(answer->size() <= adapter_.limits().message_bytes, "the answer keeps its limit", message);
    auto response = cip::Response::parse(*answer);
    require(response.has_value(), "the answer can be read", *answer);
    // An Unconnected_Send is answered with what it carries.
    require(response->service == (message[0] & 0x7F) || (message[0] & 0x7F) == cip::service::unconnected_send,
            "the answer names the service", message);
    return *response;
}

std::optional<DeviceSite::Connected> DeviceSite::open_class3(Id id, std::uint16_t serial, bool large) {
    const scanner::Class3Proposal proposal{.large = large,
                                           .t_to_o_id = 0x11000000U + serial,
                                           .triad = {serial, 0x004D, 0x11223344},
                                           .path = scanner::class3_path({})};
    const auto response = call(id, proposal.forward_open().encode());
    if (!response->status.ok()) return std::nullopt;
    const auto connection = scanner::class3_connection(proposal, response->data);
    require(connection.has_value(), "the reply is about the connection", response->data);
    return Connected{id, connection->o_to_t_id, proposal.t_to_o_id, connection->max_message()};
}

std::optional<cip::Response> DeviceSite::call(const Connected& connection, std::uint16_t sequence, ByteView message) {
    const auto reply =
        ask(connection.on, {.command = enip::Command::send_unit_data,
                            .session = session(connection.on),
                            .data = enip::SendData::connected(connection.o_to_t_id, sequence, message).encode()});
    if (!reply) return std::nullopt;
    require(reply->status == enip::EncapsulationStatus::success, "a sound SendUnitData is not refused", message);
    const auto data = enip::SendData::parse(reply->data);
    require(data.has_value(), "the reply is a list of items", reply->data);
    const auto answer = enip::connected_message(*data);
    require(answer.has_value(), "the reply has an answer in it", reply->data);
    require(answer->connection_id == connection.t_to_o_id && answer->sequence == sequence,
            "the answer has connection and sequence count", reply->data);
    require(answer->message.size() <= connection.max_reply, "the answer fits the connection", message);
    auto response = cip::Response::parse(answer->message);
    require(response.has_value(), "the answer can be read", answer->message);
    return *response;
}

void DeviceSite::send_datagram(ByteView octets, bool broadcast) {
    const Bytes exact(octets.begin(), octets.end());
    adapter_.on_datagram(peer(0), local, broadcast, exact, now_);
    const auto replies = adapter_.take_datagrams();
    require(replies.size() <= 1, "a datagram has one answer", octets);
    for (const auto& reply : replies) {
        require(reply.peer == peer(0), "the answer goes to whoever has asked", octets);
        const auto frame = enip::Frame::parse(reply.octets);
        require(frame && frame->encode() == reply.octets, "the answer is one frame", reply.octets);
    }
    check_bounds(octets);
}

void DeviceSite::send_io(ByteView octets, std::size_t peer_number) {
    const Bytes exact(octets.begin(), octets.end());
    const auto before = adapter_.io().size();
    adapter_.on_io(io_peer(peer_number), io_local, exact, now_);
    require(adapter_.io().size() == before && adapter_.io_queue().empty(),
            "a datagram opens, closes and answers nothing", octets);
}

void DeviceSite::advance(std::chrono::microseconds duration) {
    now_ += duration;
    const auto connections = adapter_.io().size();
    adapter_.on_timer(now_);
    auto& queue = adapter_.io_queue();
    require(queue.entries().size() <= connections * most_at_once, "what is made up for is bounded");
    for (const auto& entry : queue.entries()) {
        require(entry.size <= longest_io_datagram, "a datagram has its size", queue.octets(entry));
        require(enip::IoPacket::parse(queue.octets(entry)).has_value(), "a datagram can be read", queue.octets(entry));
    }
    queue.clear();
    for (const auto& late : adapter_.take_datagrams()) {
        require(enip::Frame::parse(late.octets).has_value(), "a late answer is a frame", late.octets);
    }
    settle();
    check_bounds({});
    const auto next = adapter_.next_deadline();
    require(!next || *next > now_, "what was due is done");
}

void DeviceSite::leave() {
    for (const auto id : open()) disconnect(id);
    require(adapter_.sessions() == 0 && adapter_.tcp_connections() == 0, "no session and no connection is left");
    require(adapter_.class3_connections() == 0, "class 3 goes with its TCP connection");
    // What was asked to come later, a restart for example, has come.
    advance(std::chrono::seconds(3));
    while (adapter_.io().size() > 0) {
        const auto left = adapter_.io().size();
        const auto& connection = *adapter_.io().all().front();
        const auto close = scanner::close_request(connection.request).encode();
        const auto id = join(connection.originator.address - peer(0).address);
        const auto response = call(id, close);
        disconnect(id);
        require(response->status.ok() && adapter_.io().size() < left, "what is open can be closed", close);
    }
    const auto vendor = call(join(0), get_vendor.encode());
    require(vendor->status.ok() && vendor->data == Bytes{0x6D, 0x05}, "a good request has its answer", vendor->data);
}

DeviceSite::Id DeviceSite::join(std::size_t peer_number) {
    const auto id = connect(peer_number);
    require(id && register_session(*id), "a newcomer is served");
    return *id;
}

void DeviceSite::check_replies(ByteView octets, ByteView because) const {
    enip::FrameDecoder decoder;
    while (!octets.empty()) {
        const auto message = decoder.next(octets);
        if (!message) break;
        require(!message->oversize, "a reply has a length that peers take", because);
    }
    require(!decoder.partial(), "replies are whole frames", because);
}

void DeviceSite::check_bounds(ByteView because) const {
    const auto& limits = adapter_.limits();
    require(adapter_.tcp_connections() <= limits.tcp_connections + limits.refusals, "TCP connections are bounded",
            because);
    require(adapter_.sessions() <= limits.sessions, "sessions are bounded", because);
    require(adapter_.class3_connections() <= limits.class3_connections, "class 3 connections are bounded", because);
    require(adapter_.io().size() <= 1 + limits.listening_connections, "class 1 connections are bounded", because);
}

// What the device wants to be closed is closed, and late replies are written.
void DeviceSite::settle() {
    for (const auto id : adapter_.take_ready()) {
        if (is_open(id)) check_replies(adapter_.take_replies(id), {});
    }
    (void)adapter_.take_expired();  // wants_close() says so too
    for (const auto id : open()) {
        if (adapter_.wants_close(id)) disconnect(id);
    }
}

}  // namespace servobus::fuzz
