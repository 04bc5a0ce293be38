#include "scanner/client.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <random>

#include "cip/object.hpp"
#include "cip/services.hpp"
#include "cip/unconnected_send.hpp"
#include "cip/wire.hpp"
#include "enip/asio/asio.hpp"
#include "enip/asio/client_stream.hpp"
#include "enip/messages.hpp"
#include "scanner/class3.hpp"

namespace servobus::scanner {
namespace {

using enip::asio::ClientStream;
using std::chrono::milliseconds;

/// What a good-bye may take before the connection is simply closed.
constexpr milliseconds close_timeout{1000};

/// Ticks of an Unconnected_Send, about a second each.
constexpr std::uint8_t tick_exponent = 10;

std::uint64_t random_seed() {
    std::random_device device;
    return std::uint64_t{device()} << 32 | device();
}

/// The request in an Unconnected_Send, for the first hop to pass on (R-CM-9).
cip::Request routed(const cip::Request& request, const cip::Path& route, milliseconds timeout) {
    cip::UnconnectedSend send;
    const auto ticks = (timeout.count() + (1 << tick_exponent) - 1) >> tick_exponent;
    send.priority_tick = tick_exponent;
    send.timeout_ticks = static_cast<std::uint8_t>(std::clamp<milliseconds::rep>(ticks, 1, 255));
    send.message = request.encode();
    send.route_path = route.encode();
    return {cip::service::unconnected_send, cip::Path::to(cip::class_id::connection_manager, 1), send.encode()};
}

struct UnconnectedReply {
    cip::Bytes message;
    std::vector<enip::Item> items;  ///< those beside it
};

/// The octets of a CIP response in a SendRRData reply; in which order the items come does not matter (R-SCN-6).
boost::system::result<UnconnectedReply> unconnected_reply(cip::ByteView data) {
    auto message = enip::SendData::parse(data);
    if (!message) return make_error_code(Error::malformed_packet);
    const auto* item = message->packet.find(enip::ItemType::unconnected_data);
    if (item == nullptr) return make_error_code(Error::malformed_packet);
    UnconnectedReply reply{item->data, std::move(message->packet.items)};
    std::erase_if(reply.items, [](const enip::Item& each) {
        return each.type == enip::ItemType::unconnected_data || each.type == enip::ItemType::null_address;
    });
    return reply;
}

struct ConnectedReply {
    std::uint32_t connection_id = 0;
    std::uint16_t sequence = 0;
    cip::Bytes message;
};

boost::system::result<ConnectedReply> connected_reply(cip::ByteView data) {
    const auto message = enip::SendData::parse(data);
    if (!message) return make_error_code(Error::malformed_packet);
    const auto parts = enip::connected_message(*message);
    if (!parts) return make_error_code(Error::malformed_packet);
    return ConnectedReply{parts->connection_id, parts->sequence, {parts->message.begin(), parts->message.end()}};
}

}  // namespace

/// Everything but construction runs on `strand`.
class Client::Impl : public std::enable_shared_from_this<Impl> {
public:
    Impl(net::any_io_executor user, ClientOptions given)
        : executor(std::move(user)),
          strand(net::make_strand(executor)),
          options(std::move(given)),
          setup_timer_(strand) {
        const auto seed = options.seed ? *options.seed : random_seed();
        nonce_ = static_cast<std::uint32_t>(seed >> 32);
        serial_ = static_cast<std::uint32_t>(seed);
        options.outstanding = std::clamp<std::size_t>(options.outstanding, 1, max_outstanding);
    }
    ~Impl() {
        if (stream_) stream_->close();
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    const net::any_io_executor executor;
    const net::any_io_executor strand;
    ClientOptions options;

    /// Numbers an operation and lets its completion cancel it. Called where the operation is started.
    std::uint64_t begin(auto& done) {
        const auto id = next_operation_.fetch_add(1);
        done.on_cancel([weak = weak_from_this(), id] {
            const auto self = weak.lock();
            if (!self) return;
            net::post(self->strand, [self, id] { self->cancel(id); });
        });
        return id;
    }

    void connect(std::uint64_t id, const std::string& host, std::uint16_t port, ConnectDone done);
    void open_connection(std::uint64_t id, CallDone done);
    void call(std::uint64_t id, const cip::Request& request, CallOptions call_options, CallDone done);
    void exchange(std::uint64_t id, const cip::Request& request, std::vector<enip::Item> items,
                  std::shared_ptr<std::vector<enip::Item>> reply_items, CallOptions call_options, CallDone done);
    void keep_alive();
    void close(ConnectDone done);
    void abandon();
    [[nodiscard]] std::optional<TcpEnds> ends() const {
        const std::lock_guard lock(ends_mutex_);
        return ends_;
    }

private:
    enum class State : std::uint8_t { idle, connecting, registering, ready, registering_again, closing };

    /// A request on its way, from call() to finish().
    struct Call {
        Call(const net::any_io_executor& executor, std::uint64_t number) : id(number), timer(executor) {}
        std::uint64_t id;
        std::uint8_t service = 0;
        bool is_routed = false;
        bool connected = false;  ///< takes the class 3 connection
        bool retried = false;    ///< has been sent in a session that the device did not know
        cip::Bytes message;
        std::vector<enip::Item> items{};                         ///< that go beside it
        std::shared_ptr<std::vector<enip::Item>> reply_items{};  ///< where those of the reply go
        CallDone done;
        net::steady_timer timer;
        std::uint64_t strays = 0;  ///< what stray_replies_ was when it was sent
    };
    using CallPtr = std::shared_ptr<Call>;

    // Session
    [[nodiscard]] ClientStream::Events events();
    void register_session();
    void on_connected(error_code error);
    void on_register_reply(const enip::Frame& frame);
    void end_setup(error_code error);
    void lose_connection(error_code error);
    void say_goodbye(ConnectDone done);
    void on_setup_timeout();

    // Requests
    CallPtr prepare(std::uint64_t id, const cip::Request& request, CallDone done);
    void submit(const CallPtr& call, milliseconds timeout);
    void pump();
    void transmit(Call& call);
    void finish(const CallPtr& call, error_code error, cip::Response response = {});
    void fail_all(error_code error);
    void cancel(std::uint64_t id);
    void on_call_timeout(const CallPtr& call);
    void retry_in_new_session(const CallPtr& call);
    void propose(std::uint64_t id, Class3Proposal proposal, CallDone done);
    void on_open_reply(std::uint64_t id, const Class3Proposal& proposal, error_code error, cip::Response response,
                       CallDone done);

    // Replies
    void on_frame(const enip::FrameDecoder::Result& result);
    void on_unconnected_reply(const enip::Frame& frame, bool oversize);
    void on_connected_reply(const enip::Frame& frame, bool oversize);
    void answer(const CallPtr& call, cip::ByteView message);

    void note_ends(const std::optional<TcpEnds>& ends) {
        const std::lock_guard lock(ends_mutex_);
        ends_ = ends;
    }

    [[nodiscard]] enip::SenderContext context_of(std::uint64_t id) const;
    [[nodiscard]] std::optional<std::uint64_t> operation_of(const enip::SenderContext& context) const;

    std::atomic<std::uint64_t> next_operation_{1};
    std::uint32_t nonce_ = 0;   ///< makes this client's contexts and ids different from another's
    std::uint32_t serial_ = 0;  ///< of the next connection

    State state_ = State::idle;
    std::shared_ptr<ClientStream> stream_;
    std::uint32_t session_ = 0;
    std::uint64_t setup_id_ = 0;
    ConnectDone setup_done_;
    net::steady_timer setup_timer_;

    std::deque<CallPtr> waiting_;
    std::map<std::uint64_t, CallPtr> on_wire_;
    CallPtr connected_call_;  ///< the one of on_wire_ that takes the class 3 connection
    std::optional<Class3Connection> class3_;
    bool opening_class3_ = false;
    std::uint64_t stray_replies_ = 0;

    mutable std::mutex ends_mutex_;  ///< the one thing that is asked for from any thread
    std::optional<TcpEnds> ends_;
};

// ------------------------------------------------------------------------------------------------------ session

ClientStream::Events Client::Impl::events() {
    const auto weak = weak_from_this();
    return {.frame =
                [weak](const enip::FrameDecoder::Result& result) {
                    if (const auto self = weak.lock()) self->on_frame(result);
                },
            .foreign =
                [weak] {
                    if (const auto self = weak.lock()) self->lose_connection(make_error_code(Error::foreign_protocol));
                },
            .closed =
                [weak](error_code error, bool in_message) {
                    const auto self = weak.lock();
                    if (!self) return;
                    if (error == net::error::eof) {
                        error = make_error_code(in_message ? Error::closed_in_message : Error::closed);
                    }
                    self->lose_connection(error);
                }};
}

void Client::Impl::connect(std::uint64_t id, const std::string& host, std::uint16_t port, ConnectDone done) {
    if (state_ != State::idle) {
        done(make_error_code(Error::already_connected));
        return;
    }
    state_ = State::connecting;
    setup_id_ = id;
    setup_done_ = std::move(done);
    setup_timer_.expires_after(options.timeout);
    setup_timer_.async_wait([self = shared_from_this(), id](error_code error) {
        if (!error && self->setup_id_ == id) self->on_setup_timeout();
    });
    stream_ = ClientStream::create(strand);
    stream_->connect(host, port, events(), [weak = weak_from_this()](error_code error) {
        if (const auto self = weak.lock()) self->on_connected(error);
    });
}

void Client::Impl::on_connected(error_code error) {
    if (state_ != State::connecting) return;
    if (error) {
        lose_connection(error);
        return;
    }
    state_ = State::registering;
    register_session();
}

void Client::Impl::register_session() {
    enip::Frame frame;
    frame.command = enip::Command::register_session;
    frame.context = context_of(setup_id_);
    frame.data = enip::RegisterSession{}.encode();
    stream_->send(frame);
}

void Client::Impl::on_register_reply(const enip::Frame& frame) {
    const bool again = state_ == State::registering_again;
    if (state_ != State::registering && !again) {
        ++stray_replies_;
        return;
    }
    const bool refused = frame.status != enip::EncapsulationStatus::success;
    if (!refused && frame.session != 0) {
        session_ = frame.session;
        state_ = State::ready;
        note_ends(TcpEnds{stream_->local(), stream_->remote()});
        if (!again) end_setup({});
        pump();
        return;
    }
    const auto error = refused ? make_error_code(frame.status) : make_error_code(Error::unexpected_data);
    if (!again) {
        lose_connection(error);
        return;
    }
    // The device knows neither the old session nor makes a new one: whoever has been told so learns that.
    state_ = State::ready;
    const auto calls = waiting_;
    for (const auto& call : calls) {
        if (call->retried) finish(call, make_error_code(enip::EncapsulationStatus::invalid_session));
    }
    pump();
}

void Client::Impl::on_setup_timeout() {
    lose_connection(make_error_code(stray_replies_ > 0 ? Error::wrong_command : Error::timeout));
}

void Client::Impl::end_setup(error_code error) {
    setup_timer_.cancel();
    setup_done_(error);
}

void Client::Impl::lose_connection(error_code error) {
    state_ = State::idle;
    session_ = 0;
    note_ends(std::nullopt);
    class3_.reset();
    if (stream_) stream_->close();
    end_setup(error);
    fail_all(error ? error : net::error::operation_aborted);
}

void Client::Impl::close(ConnectDone done) {
    if (state_ != State::ready && state_ != State::registering_again) {
        lose_connection(net::error::operation_aborted);
        done({});
        return;
    }
    state_ = State::closing;
    fail_all(net::error::operation_aborted);
    if (!class3_) {
        say_goodbye(std::move(done));
        return;
    }
    const auto close_request = class3_->proposal.forward_close();
    class3_.reset();
    const auto shared = std::make_shared<ConnectDone>(std::move(done));
    // Whatever the device says to the Forward_Close, the connection ends with its TCP connection (R-CON-47).
    const auto then = [self = shared_from_this(), shared](error_code, const cip::Response&) {
        self->say_goodbye(std::move(*shared));
    };
    const auto call = prepare(next_operation_.fetch_add(1), close_request, CallDone(then, strand));
    if (call) submit(call, close_timeout);
}

void Client::Impl::say_goodbye(ConnectDone done) {
    if (!stream_) {
        done({});
        return;
    }
    enip::Frame frame;
    frame.command = enip::Command::unregister_session;
    frame.session = session_;
    stream_->send(frame);
    setup_done_ = std::move(done);
    setup_id_ = next_operation_.fetch_add(1);
    const auto end = [self = shared_from_this(), id = setup_id_] {
        if (self->setup_id_ == id) self->lose_connection({});
    };
    setup_timer_.expires_after(close_timeout);
    setup_timer_.async_wait([end](error_code error) {
        if (!error) end();
    });
    stream_->finish(end);
}

void Client::Impl::abandon() { lose_connection(net::error::operation_aborted); }

// ----------------------------------------------------------------------------------------------------- requests

void Client::Impl::call(std::uint64_t id, const cip::Request& request, CallOptions call_options, CallDone done) {
    if (state_ != State::ready && state_ != State::registering_again) {
        done(make_error_code(Error::not_connected), {});
        return;
    }
    const auto timeout = call_options.timeout.value_or(options.timeout);
    const bool connected = class3_.has_value();
    const bool is_routed = !connected && !options.route.segments.empty();
    if (request.path.words() > cip::max_path_words) {
        done(make_error_code(Error::request_too_large), {});
        return;
    }
    const auto call = prepare(id, is_routed ? routed(request, options.route, timeout) : request, std::move(done));
    if (!call) return;
    call->service = request.service & static_cast<std::uint8_t>(~cip::service::reply_bit);
    call->is_routed = is_routed;
    call->connected = connected;
    if (connected && call->message.size() > class3_->max_message()) {
        call->done(make_error_code(Error::request_too_large), {});
        return;
    }
    submit(call, timeout);
}

void Client::Impl::exchange(std::uint64_t id, const cip::Request& request, std::vector<enip::Item> items,
                            std::shared_ptr<std::vector<enip::Item>> reply_items, CallOptions call_options,
                            CallDone done) {
    if (state_ != State::ready && state_ != State::registering_again) {
        done(make_error_code(Error::not_connected), {});
        return;
    }
    if (request.path.words() > cip::max_path_words) {
        done(make_error_code(Error::request_too_large), {});
        return;
    }
    const auto call = prepare(id, request, std::move(done));
    if (!call) return;
    call->items = std::move(items);
    call->reply_items = std::move(reply_items);
    submit(call, call_options.timeout.value_or(options.timeout));
}

void Client::Impl::keep_alive() {
    if (state_ != State::ready) return;
    enip::Frame frame;
    frame.command = enip::Command::nop;
    stream_->send(frame);
}

/// Nullptr, and `done` called, when the request cannot be sent.
Client::Impl::CallPtr Client::Impl::prepare(std::uint64_t id, const cip::Request& request, CallDone done) {
    auto call = std::make_shared<Call>(strand, id);
    call->service = request.service;
    call->message = request.encode();
    call->done = std::move(done);
    auto error = error_code{};
    if (call->message.size() > cip::max_message_bytes) error = make_error_code(Error::request_too_large);
    if (waiting_.size() >= max_waiting) error = make_error_code(Error::too_many_requests);
    if (!error) return call;
    call->done(error, {});
    return nullptr;
}

void Client::Impl::submit(const CallPtr& call, milliseconds timeout) {
    call->timer.expires_after(timeout);
    call->timer.async_wait([self = shared_from_this(), call](error_code error) {
        if (!error) self->on_call_timeout(call);
    });
    waiting_.push_back(call);
    pump();
}

void Client::Impl::pump() {
    while ((state_ == State::ready || state_ == State::closing) && !waiting_.empty() &&
           on_wire_.size() < options.outstanding) {
        const auto call = waiting_.front();
        if (call->connected && connected_call_) return;  // one at a time (R-CON-46)
        waiting_.pop_front();
        on_wire_.emplace(call->id, call);
        transmit(*call);
        if (call->connected) connected_call_ = call;
    }
}

void Client::Impl::transmit(Call& call) {
    enip::Frame frame;
    frame.session = session_;
    if (call.connected) {
        frame.command = enip::Command::send_unit_data;
        frame.data = enip::SendData::connected(class3_->o_to_t_id, ++class3_->sequence, call.message).encode();
    } else {
        frame.command = enip::Command::send_rr_data;
        frame.context = context_of(call.id);
        auto data = enip::SendData::unconnected(call.message);
        data.packet.items.insert(data.packet.items.end(), call.items.begin(), call.items.end());
        frame.data = data.encode();
    }
    call.strays = stray_replies_;
    stream_->send(frame);
}

void Client::Impl::finish(const CallPtr& call, error_code error, cip::Response response) {
    call->timer.cancel();
    std::erase(waiting_, call);
    if (const auto found = on_wire_.find(call->id); found != on_wire_.end() && found->second == call) {
        on_wire_.erase(found);
    }
    if (connected_call_ == call) connected_call_.reset();
    call->done(error, std::move(response));
    pump();
}

void Client::Impl::fail_all(error_code error) {
    const auto waiting = std::exchange(waiting_, {});
    const auto on_wire = std::exchange(on_wire_, {});
    connected_call_.reset();
    const auto fail = [error](const CallPtr& call) {
        call->timer.cancel();
        call->done(error, {});
    };
    for (const auto& [id, call] : on_wire) fail(call);
    std::ranges::for_each(waiting, fail);
}

void Client::Impl::cancel(std::uint64_t id) {
    if (setup_id_ == id && (state_ == State::connecting || state_ == State::registering)) {
        lose_connection(net::error::operation_aborted);
        return;
    }
    if (const auto found = on_wire_.find(id); found != on_wire_.end()) {
        finish(CallPtr(found->second), net::error::operation_aborted);
        return;
    }
    const auto found = std::ranges::find(waiting_, id, [](const CallPtr& call) { return call->id; });
    if (found != waiting_.end()) finish(CallPtr(*found), net::error::operation_aborted);
}

void Client::Impl::on_call_timeout(const CallPtr& call) {
    const bool answered_something = on_wire_.contains(call->id) && stray_replies_ > call->strays;
    finish(call, make_error_code(answered_something ? Error::wrong_command : Error::timeout));
}

void Client::Impl::retry_in_new_session(const CallPtr& call) {
    call->retried = true;
    on_wire_.erase(call->id);
    const auto later = std::ranges::find_if(waiting_, [&](const CallPtr& other) { return other->id > call->id; });
    waiting_.insert(later, call);
    if (state_ != State::ready) return;
    state_ = State::registering_again;
    register_session();
}

// ------------------------------------------------------------------------------------------- class 3 connection

void Client::Impl::open_connection(std::uint64_t id, CallDone done) {
    if (state_ != State::ready || class3_ || opening_class3_) {
        done(make_error_code(state_ == State::ready ? Error::already_connected : Error::not_connected), {});
        return;
    }
    Class3Proposal proposal;
    proposal.path = class3_path(options.route);
    if (proposal.path.words() > cip::max_path_words) {
        done(make_error_code(Error::request_too_large), {});
        return;
    }
    proposal.triad = {0, options.vendor, nonce_};
    opening_class3_ = true;
    propose(id, std::move(proposal), std::move(done));
}

void Client::Impl::propose(std::uint64_t id, Class3Proposal proposal, CallDone done) {
    proposal.triad.serial_number = static_cast<std::uint16_t>(++serial_);
    proposal.t_to_o_id = (nonce_ & 0xFFFF0000U) | (serial_ & 0xFFFFU);
    const auto shared = std::make_shared<CallDone>(std::move(done));
    const auto then = [self = shared_from_this(), id, proposal, shared](error_code error, cip::Response response) {
        self->on_open_reply(id, proposal, error, std::move(response), std::move(*shared));
    };
    const auto call = prepare(id, proposal.forward_open(), CallDone(then, strand));
    if (call) submit(call, options.timeout);
}

void Client::Impl::on_open_reply(std::uint64_t id, const Class3Proposal& proposal, error_code error,
                                 cip::Response response, CallDone done) {
    opening_class3_ = false;
    if (error || state_ != State::ready) {
        done(error ? error : net::error::operation_aborted, {});
        return;
    }
    if (response.status.ok()) {
        auto connection = class3_connection(proposal, response.data);
        if (connection) class3_ = std::move(*connection);
        done(class3_ ? error_code{} : make_error_code(Error::unexpected_data), std::move(response));
        return;
    }
    if (!proposal.large) {
        done({}, std::move(response));
        return;
    }
    // 0x08 from a device that does not know the service, and other words from those that dislike the size.
    auto smaller = proposal;
    smaller.large = false;
    opening_class3_ = true;
    propose(id, std::move(smaller), std::move(done));
}

// ------------------------------------------------------------------------------------------------------ replies

enip::SenderContext Client::Impl::context_of(std::uint64_t id) const {
    cip::Bytes octets;
    cip::Writer writer(octets);
    writer.u32(static_cast<std::uint32_t>(id));
    writer.u32(nonce_);
    enip::SenderContext context{};
    std::ranges::copy(octets, context.begin());
    return context;
}

std::optional<std::uint64_t> Client::Impl::operation_of(const enip::SenderContext& context) const {
    cip::Reader reader(context);
    const auto low = reader.u32();
    if (reader.u32() != nonce_) return std::nullopt;
    const auto next = next_operation_.load();
    auto id = (next & ~std::uint64_t{0xFFFFFFFF}) | low;
    if (id >= next && id > 0xFFFFFFFF) id -= std::uint64_t{1} << 32;
    if (id >= next) return std::nullopt;
    return id;
}

void Client::Impl::on_frame(const enip::FrameDecoder::Result& result) {
    switch (result.frame.command) {
        case enip::Command::nop:
            return;
        case enip::Command::register_session:
            on_register_reply(result.frame);
            return;
        case enip::Command::send_unit_data:
            on_connected_reply(result.frame, result.oversize);
            return;
        default:
            on_unconnected_reply(result.frame, result.oversize);
            return;
    }
}

void Client::Impl::on_unconnected_reply(const enip::Frame& frame, bool oversize) {
    const auto id = operation_of(frame.context);
    const auto found = id ? on_wire_.find(*id) : on_wire_.end();
    if (found == on_wire_.end() || found->second->connected) {
        if (!id) ++stray_replies_;  // otherwise it is late: nobody waits for it any more (R-SCN-5)
        return;
    }
    const CallPtr call = found->second;
    if (frame.command != enip::Command::send_rr_data) {
        finish(call, make_error_code(Error::wrong_command));
    } else if (frame.status == enip::EncapsulationStatus::invalid_session && !call->retried &&
               state_ != State::closing) {
        retry_in_new_session(call);
    } else if (frame.status != enip::EncapsulationStatus::success) {
        finish(call, make_error_code(frame.status));
    } else if (oversize) {
        finish(call, make_error_code(Error::oversize_reply));
    } else if (auto reply = unconnected_reply(frame.data)) {
        if (call->reply_items) *call->reply_items = std::move(reply->items);
        answer(call, reply->message);
    } else {
        finish(call, reply.error());
    }
}

void Client::Impl::on_connected_reply(const enip::Frame& frame, bool oversize) {
    if (!connected_call_ || !class3_) return;
    const CallPtr call = connected_call_;
    if (frame.status != enip::EncapsulationStatus::success) {
        finish(call, make_error_code(frame.status));
        return;
    }
    if (oversize) {
        finish(call, make_error_code(Error::oversize_reply));
        return;
    }
    const auto reply = connected_reply(frame.data);
    if (!reply) {
        finish(call, reply.error());
        return;
    }
    if (reply->connection_id != class3_->proposal.t_to_o_id) {
        ++stray_replies_;
        return;
    }
    if (reply->sequence != class3_->sequence) return;  // of an earlier request, which has timed out
    answer(call, reply->message);
}

void Client::Impl::answer(const CallPtr& call, cip::ByteView message) {
    auto response = cip::Response::parse(message);
    if (!response) {
        finish(call, make_error_code(Error::malformed_response));
        return;
    }
    const bool from_router =
        call->is_routed && response->service == cip::service::unconnected_send && !response->status.ok();
    if (response->service != call->service && !from_router) {
        finish(call, make_error_code(Error::wrong_service));
        return;
    }
    finish(call, {}, std::move(*response));
}

// ----------------------------------------------------------------------------------------------- the thin edge

Client::Client(net::any_io_executor executor, ClientOptions options)
    : impl_(std::make_shared<Impl>(std::move(executor), std::move(options))) {}

Client& Client::operator=(Client&& other) noexcept {
    Client old(std::move(*this));
    impl_ = std::move(other.impl_);
    return *this;
}

Client::~Client() {
    if (impl_) net::post(impl_->strand, [impl = impl_] { impl->abandon(); });
}

net::any_io_executor Client::get_executor() const { return impl_->executor; }

void Client::start_connect(const Shared& impl, std::string host, std::uint16_t port, ConnectDone done) {
    const auto id = impl->begin(done);
    net::dispatch(impl->strand, [impl, id, host = std::move(host), port, done = std::move(done)]() mutable {
        impl->connect(id, host, port, std::move(done));
    });
}

void Client::start_open_connection(const Shared& impl, CallDone done) {
    const auto id = impl->begin(done);
    net::dispatch(impl->strand,
                  [impl, id, done = std::move(done)]() mutable { impl->open_connection(id, std::move(done)); });
}

void Client::start_call(const Shared& impl, cip::Request request, CallOptions options, CallDone done) {
    const auto id = impl->begin(done);
    net::dispatch(impl->strand, [impl, id, request = std::move(request), options, done = std::move(done)]() mutable {
        impl->call(id, request, options, std::move(done));
    });
}

void Client::start_exchange(const Shared& impl, cip::Request request, std::vector<enip::Item> items,
                            CallOptions options, ExchangeDone done) {
    const auto id = impl->begin(done);
    const auto shared = std::make_shared<ExchangeDone>(std::move(done));
    const auto beside = std::make_shared<std::vector<enip::Item>>();
    const auto then = [shared, beside](error_code error, cip::Response response) {
        (*shared)(error, {std::move(response), std::move(*beside)});
    };
    net::dispatch(impl->strand, [impl, id, request = std::move(request), items = std::move(items), beside, options,
                                 done = CallDone(then, impl->strand)]() mutable {
        impl->exchange(id, request, std::move(items), beside, options, std::move(done));
    });
}

std::optional<TcpEnds> Client::ends() const { return impl_->ends(); }

void Client::keep_alive() {
    net::dispatch(impl_->strand, [impl = impl_] { impl->keep_alive(); });
}

void Client::start_read(const Shared& impl, const drive::Parameter& row, ReadDone done) {
    const auto id = impl->begin(done);
    const auto shared = std::make_shared<ReadDone>(std::move(done));
    const auto then = [&row, shared](error_code error, const cip::Response& response) {
        if (error) {
            (*shared)(error, {});
            return;
        }
        auto outcome = read_outcome(row, response);
        (*shared)(outcome ? error_code{} : outcome.error(), outcome ? std::move(*outcome) : ReadOutcome{});
    };
    net::dispatch(impl->strand, [impl, id, &row, done = CallDone(then, impl->strand)]() mutable {
        impl->call(id, read_request(row), {}, std::move(done));
    });
}

void Client::start_write(const Shared& impl, const drive::Parameter& row, const drive::Value& value, WriteDone done) {
    const auto id = impl->begin(done);
    const auto shared = std::make_shared<WriteDone>(std::move(done));
    const auto then = [shared](error_code error, cip::Response response) {
        (*shared)(error, std::move(response.status));
    };
    net::dispatch(impl->strand,
                  [impl, id, request = write_request(row, value), done = CallDone(then, impl->strand)]() mutable {
                      impl->call(id, request, {}, std::move(done));
                  });
}

void Client::start_close(const Shared& impl, ConnectDone done) {
    net::dispatch(impl->strand, [impl, done = std::move(done)]() mutable { impl->close(std::move(done)); });
}

}  // namespace servobus::scanner
