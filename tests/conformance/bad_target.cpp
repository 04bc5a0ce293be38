#include "tests/conformance/bad_target.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "adapter/config.hpp"
#include "cip/services.hpp"
#include "enip/messages.hpp"

namespace servobus::test {

std::optional<enip::Target::ConnectionId> BadTarget::on_open(enip::Endpoint peer, enip::Endpoint local,
                                                             enip::Time now) {
    if (dead_) return std::nullopt;
    const auto id = inner_.on_open(peer, local, now);
    if (id) streams_[*id];
    return id;
}

std::size_t BadTarget::on_octets(ConnectionId id, cip::ByteView octets, enip::Time now) {
    auto& stream = streams_[id];
    if (vice_.on_octets && !vice_.on_octets(octets)) dead_ = true;
    auto rest = octets;
    while (!dead_ && !stream.closing && !rest.empty()) {
        if (auto message = stream.decoder.next(rest)) take(id, stream, std::move(message->frame), now);
    }
    if (dead_) {
        for (auto& [each, other] : streams_) other.closing = true;
    }
    return octets.size();
}

void BadTarget::take(ConnectionId id, Stream& stream, enip::Frame request, enip::Time now) {
    stream.requests[request.context] = request;
    auto fate = vice_.on_request ? vice_.on_request(request) : Fate{};
    switch (fate.kind) {
        case Fate::Kind::pass:
            pass(id, stream, request, now);
            break;
        case Fate::Kind::drop:
            break;
        case Fate::Kind::answer:
            fate.reply.write(stream.replies);
            break;
        case Fate::Kind::close:
            stream.closing = true;
            break;
        case Fate::Kind::die:
            dead_ = true;
            break;
    }
}

void BadTarget::pass(ConnectionId id, Stream& stream, const enip::Frame& request, enip::Time now) {
    const auto octets = request.encode();
    cip::ByteView rest(octets);
    while (!rest.empty()) {
        const auto taken = inner_.on_octets(id, rest, now);
        rest = rest.subspan(taken);
        collect(id, stream);
    }
}

void BadTarget::collect(ConnectionId id, Stream& stream) {
    const auto replies = inner_.take_replies(id);
    enip::FrameDecoder decoder(0xFFFF);
    cip::ByteView rest(replies);
    while (!rest.empty()) {
        auto message = decoder.next(rest);
        if (!message) break;
        const auto asked = stream.requests.find(message->frame.context);
        if (vice_.on_reply && asked != stream.requests.end()) vice_.on_reply(asked->second, message->frame);
        message->frame.write(stream.replies);
    }
}

cip::Bytes BadTarget::take_replies(ConnectionId id) {
    const auto found = streams_.find(id);
    if (found == streams_.end() || dead_) return {};
    collect(id, found->second);
    return std::exchange(found->second.replies, {});
}

bool BadTarget::wants_close(ConnectionId id) const {
    const auto found = streams_.find(id);
    return inner_.wants_close(id) || (found != streams_.end() && found->second.closing);
}

void BadTarget::on_closed(ConnectionId id, enip::Time now) {
    streams_.erase(id);
    inner_.on_closed(id, now);
}

void BadTarget::on_datagram(enip::Endpoint peer, enip::Endpoint local, bool broadcast, cip::ByteView octets,
                            enip::Time now) {
    if (!dead_) inner_.on_datagram(peer, local, broadcast, octets, now);
}

std::vector<enip::Datagram> BadTarget::take_datagrams() {
    auto datagrams = inner_.take_datagrams();
    for (auto& each : datagrams) {
        auto frame = enip::Frame::parse(each.octets);
        if (!vice_.on_udp_reply || !frame) continue;
        vice_.on_udp_reply(*frame);
        each.octets = frame->encode();
    }
    return datagrams;
}

void BadTarget::on_io(enip::Endpoint peer, enip::Endpoint local, cip::ByteView octets, enip::Time now) {
    if (dead_) return;
    cip::Bytes altered(octets.begin(), octets.end());
    if (vice_.on_output) vice_.on_output(altered);
    inner_.on_io(peer, local, altered, now);
}

enip::IoQueue& BadTarget::io_queue() {
    auto& inner = inner_.io_queue();
    for (const auto& entry : inner.entries()) {
        const auto octets = std::as_const(inner).octets(entry);
        cip::Bytes altered(octets.begin(), octets.end());
        if (vice_.on_input) vice_.on_input(altered);
        auto route = entry.route;
        if (vice_.on_input_route) vice_.on_input_route(route);
        std::ranges::copy(altered, queue_.add(route, altered.size()).begin());
    }
    inner.clear();
    return queue_;
}

BadServer::BadServer(Vice vice) {
    // A loopback address that no other test has.
    const auto number = static_cast<unsigned>(getpid()) & 0xFFFFU;
    host_ = "127.91." + std::to_string(number >> 8) + "." + std::to_string(number & 0xFF);
    adapter_ = std::make_unique<adapter::Adapter>(device_, adapter::Limits{}, 1, adapter::LogSink{},
                                                  adapter::make_network(device_.identity()));
    target_ = std::make_unique<BadTarget>(*adapter_, std::move(vice));
    server_ = std::make_unique<enip::asio::TargetServer>();
    const auto listening = server_->listen(*target_, {.address = host_});
    if (!listening) {
        ADD_FAILURE() << listening.error().reason;
        return;
    }
    auto& state = adapter_->network().state;
    state.interface.address = listening->local.address;
    state.interface.mask = listening->subnet_mask;
    state.io_port = listening->io_port;
    thread_ = std::thread([this] { server_->run(); });
}

BadServer::~BadServer() {
    server_->stop();
    if (thread_.joinable()) thread_.join();
}

// ---------------------------------------------------------------------------------------------------------------------

std::optional<cip::Request> request_in(const enip::Frame& frame) {
    const auto data = enip::SendData::parse(frame.data);
    if (!data) return std::nullopt;
    if (const auto message = enip::unconnected_message(*data)) {
        const auto request = cip::Request::parse(*message);
        return request ? std::optional(*request) : std::nullopt;
    }
    if (const auto message = enip::connected_message(*data)) {
        const auto request = cip::Request::parse(message->message);
        return request ? std::optional(*request) : std::nullopt;
    }
    return std::nullopt;
}

void put_request(enip::Frame& frame, const cip::Request& request) {
    auto data = enip::SendData::parse(frame.data);
    if (!data || data->packet.items.size() < 2) return;
    data->packet.items[1].data = request.encode();
    frame.data = data->encode();
}

std::optional<cip::Response> reply_in(const enip::Frame& frame) {
    const auto data = enip::SendData::parse(frame.data);
    if (!data) return std::nullopt;
    const auto message = enip::unconnected_message(*data);
    if (!message) return std::nullopt;
    const auto response = cip::Response::parse(*message);
    return response ? std::optional(*response) : std::nullopt;
}

void put_reply(enip::Frame& frame, const cip::Response& response) {
    auto data = enip::SendData::parse(frame.data);
    if (!data || data->packet.items.size() < 2) return;
    data->packet.items[1].data = response.encode();
    frame.data = data->encode();
}

std::array<std::uint32_t, 3> place_of(const cip::Request& request) {
    std::array<std::uint32_t, 3> place{};
    for (const auto& segment : request.path.segments) {
        const auto* logical = std::get_if<cip::LogicalSegment>(&segment);
        if (logical == nullptr) continue;
        if (logical->type == cip::LogicalType::class_id) place[0] = logical->value;
        if (logical->type == cip::LogicalType::instance) place[1] = logical->value;
        if (logical->type == cip::LogicalType::attribute) place[2] = logical->value;
    }
    return place;
}

namespace {

bool is_about(const std::optional<cip::Request>& request, std::uint16_t class_id, std::uint8_t service) {
    return request && request->service == service && place_of(*request)[0] == class_id;
}

}  // namespace

Vice altering(std::uint16_t class_id, std::uint8_t service, std::function<void(cip::Response&)> change) {
    Vice vice;
    vice.on_reply = [=](const enip::Frame& request, enip::Frame& reply) {
        if (!is_about(request_in(request), class_id, service)) return;
        auto response = reply_in(reply);
        if (!response) return;
        change(*response);
        put_reply(reply, *response);
    };
    return vice;
}

Vice requesting(std::uint16_t class_id, std::uint8_t service, std::function<void(cip::Request&)> change) {
    Vice vice;
    vice.on_request = [=](enip::Frame& frame) {
        auto request = request_in(frame);
        if (!is_about(request, class_id, service)) return Fate{};
        change(*request);
        put_request(frame, *request);
        return Fate{};
    };
    return vice;
}

}  // namespace servobus::test
