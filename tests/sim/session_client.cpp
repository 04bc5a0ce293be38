#include "tests/sim/session_client.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/error.hpp>
#include <utility>

#include "cip/wire.hpp"
#include "enip/messages.hpp"
#include "tests/sim/neighbourhood.hpp"

namespace servobus::sim {

using scanner::Error;
using scanner::error_code;
using scanner::make_error_code;
using std::chrono::milliseconds;

SessionClient::SessionClient(unsigned node, unsigned drive, std::uint32_t nonce, Surroundings surroundings)
    : node_(node), drive_(drive), nonce_(nonce), around_(std::move(surroundings)) {}

void SessionClient::later(milliseconds pause, std::function<void()> what) {
    around_.queue.after(pause, [this, alive = std::weak_ptr(alive_), what = std::move(what)] {
        if (alive.expired()) return;
        around_.run([alive, what] {
            if (!alive.expired()) what();
        });
    });
}

std::optional<scanner::TcpEnds> SessionClient::ends() const {
    if (!is_ready()) return std::nullopt;
    return scanner::TcpEnds{{Neighbourhood::node_address(node_), port_},
                            {Neighbourhood::drive_address(drive_), enip::tcp_port}};
}

// --------------------------------------------------------------------------------------------------------- setup

void SessionClient::connect(milliseconds timeout, Done done) {
    abandon(false);
    state_ = State::connecting;
    setup_done_ = std::move(done);
    setup_id_ = ++last_id_;
    port_ = static_cast<std::uint16_t>(50'000 + last_id_ % 10'000);
    decoder_ = enip::FrameDecoder();
    stream_ = around_.wire.connect(node_, drive_, {Neighbourhood::node_address(node_), port_},
                                   {Neighbourhood::drive_address(drive_), enip::tcp_port});
    around_.enter(*stream_, this);
    later(timeout, [this, id = setup_id_] {
        if (setup_id_ == id && setup_done_) lose(make_error_code(Error::timeout));
    });
}

void SessionClient::on_connected(bool stands) {
    if (!stands) {
        lose(boost::asio::error::make_error_code(boost::asio::error::connection_refused));
        return;
    }
    state_ = State::registering;
    send({.command = enip::Command::register_session,
          .context = context_of(setup_id_),
          .data = enip::RegisterSession{}.encode()});
}

void SessionClient::end_setup(error_code error) {
    if (const auto done = std::exchange(setup_done_, nullptr)) done(error);
}

void SessionClient::lose(error_code error) {
    abandon(false);
    end_setup(error);
}

void SessionClient::abandon(bool silent) {
    state_ = State::idle;
    session_ = 0;
    class3_.reset();
    given_up_.clear();
    given_up_connected_.clear();
    if (const auto stream = std::exchange(stream_, std::nullopt)) {
        around_.enter(*stream, nullptr);
        around_.wire.abort(*stream, End::node, silent);
    }
    for (const auto& [id, call] : std::exchange(outstanding_, {})) {
        ++counters_.aborted;
        if (call.done) call.done(make_error_code(Error::closed), {});
    }
}

void SessionClient::close() {
    if (is_ready()) {
        send({.command = enip::Command::unregister_session, .session = session_});
        const auto stream = std::exchange(stream_, std::nullopt);
        around_.enter(*stream, nullptr);
        around_.wire.close(*stream, End::node);
    }
    abandon(false);
}

void SessionClient::on_end() {
    if (const auto stream = std::exchange(stream_, std::nullopt)) around_.enter(*stream, nullptr);
    lose(make_error_code(decoder_.partial() ? Error::closed_in_message : Error::closed));
}

void SessionClient::keep_alive() {
    if (is_ready()) send({.command = enip::Command::nop, .session = session_});
}

// ------------------------------------------------------------------------------------------------------ requests

enip::SenderContext SessionClient::context_of(std::uint32_t id) const {
    cip::Bytes octets;
    cip::Writer writer(octets);
    writer.u32(id);
    writer.u32(nonce_);
    enip::SenderContext context{};
    std::ranges::copy(octets, context.begin());
    return context;
}

void SessionClient::send(const enip::Frame& frame) { around_.wire.write(*stream_, End::node, frame.encode()); }

std::uint32_t SessionClient::note(Call call, milliseconds timeout) {
    const auto id = ++last_id_;
    ++counters_.requests;
    outstanding_.emplace(id, std::move(call));
    later(timeout, [this, id] { on_timeout(id); });
    return id;
}

void SessionClient::on_timeout(std::uint32_t id) {
    const auto found = outstanding_.find(id);
    if (found == outstanding_.end()) return;
    const auto call = std::move(found->second);
    outstanding_.erase(found);
    ++counters_.timed_out;
    if (call.sequence) {
        given_up_connected_.insert(*call.sequence);
    } else {
        given_up_.insert(id);
    }
    call.done(make_error_code(Error::timeout), {});
}

void SessionClient::exchange(const cip::Request& request, std::vector<enip::Item> items, milliseconds timeout,
                             Replied done) {
    if (!is_ready()) {
        done(make_error_code(Error::not_connected), {});
        return;
    }
    const auto id = note({.service = request.service, .done = std::move(done)}, timeout);
    auto data = enip::SendData::unconnected(request.encode());
    data.packet.items.insert(data.packet.items.end(), items.begin(), items.end());
    send({.command = enip::Command::send_rr_data,
          .session = session_,
          .context = context_of(id),
          .data = data.encode()});
}

void SessionClient::open_class3(milliseconds timeout, Replied done) {
    scanner::Class3Proposal proposal;
    proposal.large = last_id_ % 2 == 0;
    proposal.path = scanner::class3_path({});
    proposal.triad = {static_cast<std::uint16_t>(last_id_), 0xFFFF, nonce_};
    proposal.t_to_o_id = (nonce_ & 0xFFFF0000U) | (last_id_ & 0xFFFFU);
    exchange(proposal.forward_open(), {}, timeout,
             [this, proposal, done = std::move(done)](error_code error, const scanner::Exchange& exchange) {
                 if (!error && exchange.response.status.ok()) {
                     auto connection = scanner::class3_connection(proposal, exchange.response.data);
                     if (connection) {
                         class3_ = *std::move(connection);
                     } else {
                         report(Invariant::reply_is_asked_for,
                                "the reply to a class 3 Forward_Open is about another connection");
                     }
                 }
                 done(error, exchange);
             });
}

void SessionClient::exchange_connected(const cip::Request& request, milliseconds timeout, Replied done) {
    if (!is_ready() || !class3_) {
        done(make_error_code(Error::not_connected), {});
        return;
    }
    const auto sequence = ++class3_->sequence;
    note({.service = request.service, .sequence = sequence, .done = std::move(done)}, timeout);
    send({.command = enip::Command::send_unit_data,
          .session = session_,
          .data = enip::SendData::connected(class3_->o_to_t_id, sequence, request.encode()).encode()});
}

// ------------------------------------------------------------------------------------------------------- replies

void SessionClient::on_octets(cip::ByteView octets) {
    // What is behind a message that ended this TCP connection is nobody's any more.
    const auto stream = stream_;
    while (!octets.empty() && stream && stream_ == stream) {
        if (const auto message = decoder_.next(octets)) on_frame(message->frame);
    }
}

void SessionClient::on_frame(const enip::Frame& frame) {
    switch (frame.command) {
        case enip::Command::register_session:
            if (state_ != State::registering || frame.context != context_of(setup_id_)) {
                report(Invariant::reply_is_asked_for, "a session that nobody has asked for");
            } else if (frame.status != enip::EncapsulationStatus::success || frame.session == 0) {
                lose(make_error_code(frame.status));
            } else {
                session_ = frame.session;
                state_ = State::ready;
                end_setup({});
            }
            return;
        case enip::Command::send_unit_data:
            on_connected_reply(frame);
            return;
        default:
            on_unconnected(frame);
            return;
    }
}

void SessionClient::on_unconnected(const enip::Frame& frame) {
    cip::Reader reader(frame.context);
    const auto id = reader.u32();
    const bool ours =
        reader.u32() == nonce_ && frame.session == session_ && frame.command == enip::Command::send_rr_data;
    const auto found = outstanding_.find(id);
    if (!ours || found == outstanding_.end() || found->second.sequence) {
        if (!ours || given_up_.erase(id) == 0)
            report(Invariant::reply_is_asked_for, "a reply that nobody has asked for");
        return;
    }
    if (frame.status != enip::EncapsulationStatus::success) {
        const auto call = std::move(found->second);
        outstanding_.erase(found);
        ++counters_.answered;
        call.done(make_error_code(frame.status), {});
        return;
    }
    auto data = enip::SendData::parse(frame.data);
    const auto message = data ? enip::unconnected_message(*data) : cip::DecodeError::truncated;
    if (!message) {
        report(Invariant::reply_is_asked_for, "a reply without a message");
        return;
    }
    std::vector<enip::Item> items;
    if (data->packet.items.size() > 2) items.assign(data->packet.items.begin() + 2, data->packet.items.end());
    answer(id, *message, std::move(items));
}

void SessionClient::on_connected_reply(const enip::Frame& frame) {
    const auto data = enip::SendData::parse(frame.data);
    const auto message = data ? enip::connected_message(*data) : cip::DecodeError::truncated;
    if (frame.status != enip::EncapsulationStatus::success || !message) {
        report(Invariant::reply_is_asked_for, "a connected reply without a message");
        return;
    }
    const bool ours = class3_ && message->connection_id == class3_->proposal.t_to_o_id;
    const auto found = std::ranges::find_if(
        outstanding_, [&](const auto& entry) { return entry.second.sequence == message->sequence; });
    if (ours && found != outstanding_.end()) {
        answer(found->first, message->message, {});
    } else if (given_up_connected_.erase(message->sequence) == 0) {
        report(Invariant::reply_is_asked_for,
               fmt::format("a connected reply {} that nobody has asked for", message->sequence));
    }
}

void SessionClient::answer(std::uint32_t id, cip::ByteView message, std::vector<enip::Item> items) {
    const auto found = outstanding_.find(id);
    const auto call = std::move(found->second);
    outstanding_.erase(found);
    auto response = cip::Response::parse(message);
    if (!response || response->service != call.service) {
        report(Invariant::reply_is_asked_for, fmt::format("no response to service 0x{:02X}", call.service));
        return;
    }
    ++counters_.answered;
    call.done({}, {*std::move(response), std::move(items)});
}

}  // namespace servobus::sim
