#include "scanner/conformance/bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "cip/hex.hpp"
#include "cip/services.hpp"
#include "enip/asio/asio.hpp"
#include "enip/asio/datagram_socket.hpp"
#include "enip/asio/interfaces.hpp"
#include "enip/asio/raw_stream.hpp"
#include "enip/messages.hpp"

namespace servobus::scanner::conformance {
namespace {

using enip::asio::RawStream;
using Clock = std::chrono::steady_clock;

/// Once the answer behind it has come, nothing more is expected; what comes all the same comes soon.
constexpr milliseconds afterthought{20};

/// Answers of others that are passed over while one is waited for.
constexpr int max_passed_over = 256;

std::string code_text(const Code& code) {
    cip::Status status{static_cast<cip::GeneralStatus>(code.general)};
    if (code.extended) status.extended.push_back(*code.extended);
    return cip::describe(status);
}

std::string encapsulation_text(std::span<const std::uint32_t> statuses) {
    std::string text;
    for (const auto status : statuses) {
        text += fmt::format("{}{}", text.empty() ? "" : " or ",
                            enip::describe(static_cast<enip::EncapsulationStatus>(status)));
    }
    return text;
}

template <class Range, class Value>
bool contains(const Range& range, const Value& value) {
    return std::ranges::find(range, value) != std::ranges::end(range);
}

}  // namespace

// ---------------------------------------------------------------------------------------------------------- judgement

bool Bench::require(bool good, std::string words) {
    if (!good) findings_.push_back({true, std::move(words)});
    return good;
}

bool Bench::advise(bool good, std::string words) {
    if (!good) findings_.push_back({false, std::move(words)});
    return good;
}

void Bench::skip(std::string reason) {
    if (reason_.empty()) reason_ = std::move(reason);
}

void Bench::later(milliseconds time, std::function<void()> then) {
    later_ = Later{Clock::now() + time, std::move(then)};
}

std::optional<Bench::Later> Bench::take_later() { return std::exchange(later_, std::nullopt); }

Outcome Bench::outcome() const {
    if (std::ranges::any_of(findings_, &Finding::firm)) return Outcome::fail;
    if (!findings_.empty()) return Outcome::advisory;
    return reason_.empty() ? Outcome::pass : Outcome::skipped;
}

// --------------------------------------------------------------------------------------------------------------- TCP

Wire::Wire(Bench& bench) : bench_(&bench), stream_(std::make_unique<RawStream>()) {
    const auto& options = bench.subject().options();
    const auto error = stream_->connect(options.host.name, options.host.port, options.timeout);
    if (!bench.require(!error, fmt::format("no TCP connection: {}", error.message()))) return;
    bench.subject().address = stream_->remote();
    bench.subject().own = stream_->local();
}

Wire::Wire(Wire&& other) noexcept = default;
Wire::~Wire() = default;

bool Wire::is_open() const { return stream_->is_open(); }

bool Wire::send(cip::ByteView octets, std::string words) {
    if (!is_open()) return false;
    bench_->record.add(Step::Kind::sent, words.empty() ? describe_request(octets) : std::move(words), octets);
    const auto error = stream_->send(octets, bench_->timeout());
    if (error) bench_->note(fmt::format("the connection takes no more: {}", error.message()));
    return !error;
}

void Wire::send_unrecorded(const enip::Frame& frame) {
    if (is_open()) static_cast<void>(stream_->send(frame.encode(), milliseconds(100)));
}

std::optional<enip::Frame> Wire::receive() { return receive(bench_->timeout()); }

std::optional<enip::Frame> Wire::receive(milliseconds patience) {
    if (!is_open()) return std::nullopt;
    auto received = stream_->receive(patience);
    switch (received.event) {
        case RawStream::Event::message: {
            const auto octets = received.frame.encode();
            bench_->record.add(Step::Kind::came, describe_reply(octets), octets);
            return std::move(received.frame);
        }
        case RawStream::Event::silence:
            bench_->record.add(Step::Kind::came, fmt::format("nothing in {} ms", patience.count()));
            break;
        case RawStream::Event::closed:
            bench_->record.add(Step::Kind::came, "the device closed the connection", received.rest);
            break;
    }
    return std::nullopt;
}

std::optional<enip::Frame> Wire::exchange(const enip::Frame& request) {
    if (!send(request)) {
        bench_->require(false,
                        fmt::format("{} could not be sent: the connection is over", enip::describe(request.command)));
        return std::nullopt;
    }
    return answer_to(request);
}

std::optional<enip::Frame> Wire::answer_to(const enip::Frame& request) {
    const auto end = Clock::now() + bench_->timeout();
    for (int i = 0; i < max_passed_over; ++i) {
        const auto left = std::chrono::duration_cast<milliseconds>(end - Clock::now());
        auto reply = receive(std::max(left, milliseconds(0)));
        if (!reply) {
            bench_->require(false, fmt::format("no answer to {}", enip::describe(request.command)));
            return std::nullopt;
        }
        if (reply->context == request.context) return reply;
        bench_->require(false, fmt::format("{} came with the context {}, which no request has that waits",
                                           enip::describe(reply->command), cip::to_hex(reply->context)));
        // Whoever loses contexts is to fail by that, and not by everything that follows from it.
        if (reply->command == request.command) return reply;
    }
    return std::nullopt;
}

bool Wire::expect_silence(cip::ByteView octets, std::string_view what, bool firm) {
    const auto marker = make_frame(*bench_, enip::Command::list_services);
    const auto judge = [&](bool good, std::string words) {
        return firm ? bench_->require(good, std::move(words)) : bench_->advise(good, std::move(words));
    };
    if (!send(octets) || !send(marker)) return judge(false, fmt::format("the connection ended over {}", what));
    const auto first = receive();
    if (!judge(first.has_value(), fmt::format("no answer to an ordinary request behind {}", what))) return false;
    if (!judge(first->context == marker.context && first->command == marker.command,
               fmt::format("{} was answered", what))) {
        return false;
    }
    const auto stray = stream_->receive(afterthought);
    if (stray.event != RawStream::Event::message) return true;
    const auto late = stray.frame.encode();
    bench_->record.add(Step::Kind::came, describe_reply(late), late);
    return judge(false, fmt::format("{} was answered", what));
}

bool Wire::is_alive() {
    const auto marker = make_frame(*bench_, enip::Command::list_services);
    if (!send(marker)) return false;
    for (int i = 0; i < max_passed_over; ++i) {
        const auto reply = receive();
        if (!reply) return false;
        if (reply->command == marker.command) return true;
    }
    return false;
}

bool Wire::closes(milliseconds patience) {
    const auto end = Clock::now() + patience;
    while (is_open() && Clock::now() < end) {
        static_cast<void>(receive(std::chrono::duration_cast<milliseconds>(end - Clock::now()) + milliseconds(1)));
    }
    return !is_open();
}

void Wire::close() { stream_->close(); }
void Wire::reset() { stream_->reset(); }

enip::Frame make_frame(Bench& bench, enip::Command command, cip::Bytes data, std::uint32_t session) {
    enip::Frame frame;
    frame.command = command;
    frame.session = session;
    auto number = bench.subject().next_context();
    for (auto& octet : frame.context) {
        octet = static_cast<std::uint8_t>(number);
        number >>= 8;
    }
    frame.data = std::move(data);
    return frame;
}

// ----------------------------------------------------------------------------------------------------------- sessions

Session::Session(Bench& bench) : wire_(bench) {
    if (!wire_.is_open()) return;
    const auto reply =
        wire_.exchange(make_frame(bench, enip::Command::register_session, enip::RegisterSession{}.encode()));
    if (!reply) return;
    const bool fine = reply->status == enip::EncapsulationStatus::success && reply->session != 0;
    if (bench.require(fine, fmt::format("no session: {}", enip::describe(reply->status)))) handle_ = reply->session;
}

Session::~Session() { leave(); }

void Session::leave() {
    const auto handle = std::exchange(handle_, 0);
    if (handle == 0 || !wire_.is_open()) return;
    wire_.send_unrecorded(make_frame(bench(), enip::Command::unregister_session, {}, handle));
    wire_.close();
}

enip::Frame Session::rr_frame(cip::ByteView message, std::vector<enip::Item> items) {
    auto data = enip::SendData::unconnected({message.begin(), message.end()});
    for (auto& item : items) data.packet.items.push_back(std::move(item));
    return make_frame(bench(), enip::Command::send_rr_data, data.encode(), handle_);
}

enip::Frame Session::unit_frame(std::uint32_t connection, std::uint16_t sequence, cip::ByteView message) {
    const auto data = enip::SendData::connected(connection, sequence, message);
    return make_frame(bench(), enip::Command::send_unit_data, data.encode(), handle_);
}

std::optional<Reply> Session::call(const cip::Request& request, std::vector<enip::Item> items) {
    return call(request.encode(), std::move(items));
}

std::optional<Reply> Session::call(cip::ByteView message, std::vector<enip::Item> items) {
    if (!is_open()) return std::nullopt;
    const auto frame = wire_.exchange(rr_frame(message, std::move(items)));
    if (!frame) return std::nullopt;
    return read(*frame, message.empty() ? std::uint8_t{0} : message[0]);
}

std::optional<Reply> Session::read(const enip::Frame& frame, std::uint8_t service) {
    auto& bench = this->bench();
    const auto nothing = [&](std::string words) {
        bench.require(false, std::move(words));
        return std::nullopt;
    };
    if (frame.status != enip::EncapsulationStatus::success) {
        return nothing(fmt::format("encapsulation status {} instead of a CIP reply", enip::describe(frame.status)));
    }
    if (frame.command != enip::Command::send_rr_data) {
        return nothing(fmt::format("{} instead of SendRRData", enip::describe(frame.command)));
    }
    const auto data = enip::SendData::parse(frame.data);
    if (!data) return nothing("the items of the reply cannot be read: " + std::string(cip::describe(data.error())));
    const auto message = enip::unconnected_message(*data);
    if (!message) return nothing("the reply is not a null address item and an unconnected data item");
    auto response = cip::Response::parse(*message);
    if (!response) return nothing("the CIP reply cannot be read: " + std::string(cip::describe(response.error())));
    Reply reply;
    reply.frame = frame;
    reply.message.assign(message->begin(), message->end());
    reply.response = std::move(*response);
    reply.items.assign(data->packet.items.begin() + 2, data->packet.items.end());
    // The reply to an Unconnected_Send is that of the request in it.
    const bool fits =
        reply.response.service == (service & ~cip::service::reply_bit) || service == cip::service::unconnected_send;
    bench.require(fits,
                  fmt::format("a reply to service 0x{:02X}, and 0x{:02X} was asked", reply.response.service, service));
    return reply;
}

// --------------------------------------------------------------------------------------------------------------- UDP

class Udp::Impl {
public:
    explicit Impl(Bench& bench) : bench_(bench) {
        const auto error = socket_.open({bench.subject().own.address, 0}, false);
        bench.require(!error, fmt::format("no UDP socket: {}", error.message()));
    }

    void send(cip::ByteView octets, std::string words, enip::Endpoint to) {
        bench_.record.add(Step::Kind::sent, std::move(words), octets);
        socket_.send({{}, to, {octets.begin(), octets.end()}});
    }

    [[nodiscard]] enip::Endpoint device() const {
        const auto& subject = bench_.subject();
        return {subject.address.address, subject.options().host.port};
    }

    bool broadcast(cip::ByteView octets) {
        const auto interface = enip::asio::interface_of(bench_.subject().own.address);
        if (!interface || !interface->broadcasts) return false;
        boost::system::error_code error;
        socket_.socket().set_option(net::socket_base::broadcast(true), error);
        if (error) return false;
        const enip::Endpoint all{interface->broadcast(), bench_.subject().options().host.port};
        send(octets, fmt::format("by broadcast to {}: {}", enip::to_string(all), describe_request(octets)), all);
        return true;
    }

    std::optional<cip::Bytes> receive(milliseconds patience) {
        const auto end = Clock::now() + patience;
        for (;;) {
            while (const auto received = socket_.receive(buffer_)) {
                if (received->peer.address != bench_.subject().address.address) continue;
                bench_.record.add(Step::Kind::came, "over UDP: " + describe_reply(received->octets), received->octets);
                return cip::Bytes(received->octets.begin(), received->octets.end());
            }
            if (!wait_until(end)) break;
        }
        bench_.record.add(Step::Kind::came, fmt::format("nothing over UDP in {} ms", patience.count()));
        return std::nullopt;
    }

    Bench& bench() { return bench_; }

private:
    bool wait_until(Clock::time_point end) {
        if (Clock::now() >= end) return false;
        bool ready = false;
        bool over = false;
        socket_.socket().async_wait(net::socket_base::wait_read, [&](boost::system::error_code error) {
            ready = !error;
            over = true;
        });
        while (!over && Clock::now() < end) {
            context_.restart();
            context_.run_one_until(end);
        }
        if (!over) {
            boost::system::error_code ignored;
            socket_.socket().cancel(ignored);
            context_.restart();
            context_.run();
        }
        return ready;
    }

    Bench& bench_;
    net::io_context context_{1};
    enip::asio::DatagramSocket socket_{context_.get_executor()};
    std::array<std::uint8_t, 2048> buffer_{};
};

Udp::Udp(Bench& bench) : impl_(std::make_unique<Impl>(bench)) {}
Udp::Udp(Udp&& other) noexcept = default;
Udp::~Udp() = default;

void Udp::send(cip::ByteView octets, const std::string& words) {
    impl_->send(octets, "over UDP: " + (words.empty() ? describe_request(octets) : words), impl_->device());
}
bool Udp::broadcast(cip::ByteView octets) { return impl_->broadcast(octets); }
void Udp::send_io(cip::ByteView octets, std::string words) {
    impl_->send(octets, words.empty() ? describe_datagram(octets) : std::move(words),
                {impl_->device().address, enip::io_port});
}
std::optional<cip::Bytes> Udp::receive(milliseconds patience) { return impl_->receive(patience); }

std::optional<enip::Frame> Udp::exchange(const enip::Frame& request) {
    // A datagram may be lost.
    constexpr int tries = 3;
    const auto octets = request.encode();
    for (int i = 0; i < tries; ++i) {
        send(octets);
        const auto came = receive(impl_->bench().timeout() / tries);
        if (!came) continue;
        const auto frame = enip::Frame::parse(*came);
        if (frame && frame->context == request.context) return *frame;
        impl_->bench().require(false, "a datagram that is no answer to the request");
    }
    return std::nullopt;
}

bool Udp::expect_silence(cip::ByteView octets, std::string_view what, bool firm) {
    auto& bench = impl_->bench();
    const auto judge = [&](bool good, std::string words) {
        return firm ? bench.require(good, std::move(words)) : bench.advise(good, std::move(words));
    };
    const auto marker = make_frame(bench, enip::Command::list_services);
    send(octets);
    send(marker.encode());
    for (int i = 0; i < 2; ++i) {
        const auto came = receive(i == 0 ? bench.timeout() : afterthought);
        if (!came) return i > 0 || judge(false, fmt::format("no answer to an ordinary request behind {}", what));
        const auto frame = enip::Frame::parse(*came);
        if (!judge(frame && frame->context == marker.context, fmt::format("{} was answered", what))) return false;
    }
    return true;
}

// -------------------------------------------------------------------------------------------------------------- octets

cip::Bytes hex(std::string_view text) { return cip::from_hex(text).value_or(cip::Bytes{}); }

cip::Bytes join(std::initializer_list<cip::ByteView> pieces) {
    cip::Bytes all;
    for (const auto piece : pieces) all.insert(all.end(), piece.begin(), piece.end());
    return all;
}

cip::Bytes u16(std::uint32_t value) {
    return {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8)};
}

cip::Bytes u32(std::uint32_t value) {
    cip::Bytes bytes;
    cip::Writer(bytes).u32(value);
    return bytes;
}

// ------------------------------------------------------------------------------------------------------------ refusals

bool Code::matches(const cip::Status& status) const {
    if (static_cast<std::uint8_t>(status.general) != general) return false;
    return !extended || (!status.extended.empty() && status.extended.front() == *extended);
}

std::string describe(std::span<const Code> codes) {
    std::string text;
    for (const auto& code : codes) text += (text.empty() ? "" : " or ") + code_text(code);
    return text;
}

void refused(Bench& bench, const std::optional<Reply>& reply, std::initializer_list<Code> right,
             std::initializer_list<Code> tolerated, Weight weight) {
    if (!reply) return;  // which is held against the device already
    const auto& status = reply->response.status;
    const auto matches = [&](const Code& code) { return code.matches(status); };
    if (std::ranges::any_of(right, matches)) return;
    const auto wanted = describe(std::span(right.begin(), right.size()));
    const auto words = status.ok() ? fmt::format("it was granted; expected is {}", wanted)
                                   : fmt::format("{} came; expected is {}", cip::describe(status), wanted);
    const bool gently =
        weight == Weight::soft || (weight == Weight::any && !status.ok()) || std::ranges::any_of(tolerated, matches);
    if (gently) {
        bench.advise(false, words);
    } else {
        bench.require(false, words);
    }
}

bool granted(Bench& bench, const std::optional<Reply>& reply) {
    if (!reply) return false;
    return bench.require(reply->ok(), fmt::format("refused with {}", cip::describe(reply->response.status)));
}

void refused(Bench& bench, const std::optional<enip::Frame>& reply, std::initializer_list<std::uint32_t> right,
             std::initializer_list<std::uint32_t> tolerated, Weight weight) {
    if (!reply) return;
    const auto status = static_cast<std::uint32_t>(reply->status);
    if (!contains(right, status)) {
        const auto words = fmt::format("status {} came; expected is {}", enip::describe(reply->status),
                                       encapsulation_text(std::span(right.begin(), right.size())));
        const bool gently =
            weight == Weight::soft || (weight == Weight::any && status != 0) || contains(tolerated, status);
        if (gently) {
            bench.advise(false, words);
        } else {
            bench.require(false, words);
        }
    }
    if (status == 0) return;
    // RegisterSession tells the version that it would have taken (R-ENC-18).
    if (reply->command == enip::Command::register_session) return;
    bench.advise(reply->data.empty(), fmt::format("{} octets of data came with the refusal", reply->data.size()));
}

bool is_unsupported(const std::optional<Reply>& reply) {
    return reply && reply->response.status.general == cip::GeneralStatus::service_not_supported;
}

}  // namespace servobus::scanner::conformance
