#include "enip/asio/raw_stream.hpp"

#include <boost/asio/connect.hpp>
#include <optional>

#include "enip/asio/asio.hpp"
#include "enip/asio/lookup.hpp"
#include "enip/frame_decoder.hpp"

namespace servobus::enip::asio {
namespace {

using boost::system::error_code;
using Clock = std::chrono::steady_clock;

Endpoint to_endpoint(const net::ip::tcp::endpoint& native) {
    if (!native.address().is_v4()) return {};
    return {native.address().to_v4().to_uint(), native.port()};
}

}  // namespace

class RawStream::Impl {
public:
    error_code connect(const std::string& host, std::uint16_t port, std::chrono::milliseconds patience) {
        std::optional<error_code> outcome;
        const auto abandon =
            look_up(context_.get_executor(), host, port, [&](error_code failure, const Addresses& addresses) {
                if (failure) {
                    outcome = failure;
                    return;
                }
                net::async_connect(socket_, addresses, [&](error_code connected, const auto&) { outcome = connected; });
            });
        wait(patience, [&] { return outcome.has_value(); });
        if (!outcome) {
            abandon();
            close();
            wait(std::chrono::milliseconds(100), [&] { return outcome.has_value(); });
            return net::error::timed_out;
        }
        if (*outcome) {
            close();
            return *outcome;
        }
        error_code ignored;
        socket_.set_option(net::ip::tcp::no_delay(true), ignored);
        return {};
    }

    error_code send(cip::ByteView octets, std::chrono::milliseconds patience) {
        if (!socket_.is_open()) return net::error::not_connected;
        std::optional<error_code> outcome;
        net::async_write(socket_, net::buffer(octets.data(), octets.size()),
                         [&](error_code error, std::size_t) { outcome = error; });
        wait(patience, [&] { return outcome.has_value(); });
        if (outcome) return *outcome;
        error_code ignored;
        socket_.cancel(ignored);
        wait(patience, [&] { return outcome.has_value(); });
        return net::error::timed_out;
    }

    Received receive(std::chrono::milliseconds patience) {
        const auto end = Clock::now() + patience;
        for (;;) {
            if (auto frame = next_frame()) return {Event::message, *std::move(frame), {}};
            if (!socket_.is_open()) return {Event::closed, {}, {}};
            std::optional<error_code> outcome;
            std::size_t count = 0;
            socket_.async_read_some(net::buffer(buffer_), [&](error_code error, std::size_t octets) {
                outcome = error;
                count = octets;
            });
            wait_until(end, [&] { return outcome.has_value(); });
            if (!outcome) {
                error_code ignored;
                socket_.cancel(ignored);
                wait(std::chrono::milliseconds(1000), [&] { return outcome.has_value(); });
            }
            received_.insert(received_.end(), buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(count));
            if (count > 0) continue;
            if (!outcome || *outcome == net::error::operation_aborted) return {};
            Received over{Event::closed, {}, std::move(received_)};
            received_.clear();
            close();
            return over;
        }
    }

    void close() {
        error_code ignored;
        socket_.shutdown(net::ip::tcp::socket::shutdown_both, ignored);
        socket_.close(ignored);
    }

    void reset() {
        error_code ignored;
        socket_.set_option(net::socket_base::linger(true, 0), ignored);
        socket_.close(ignored);
    }

    [[nodiscard]] bool is_open() const { return socket_.is_open(); }
    [[nodiscard]] Endpoint local() const {
        error_code ignored;
        return to_endpoint(socket_.local_endpoint(ignored));
    }
    [[nodiscard]] Endpoint remote() const {
        error_code ignored;
        return to_endpoint(socket_.remote_endpoint(ignored));
    }

private:
    /// Replies may be as long as the header can say.
    std::optional<Frame> next_frame() {
        FrameDecoder decoder(0xFFFF);
        cip::ByteView view(received_);
        auto message = decoder.next(view);
        if (!message) return std::nullopt;
        received_.erase(received_.begin(), received_.end() - static_cast<std::ptrdiff_t>(view.size()));
        return std::move(message->frame);
    }

    template <class Done>
    void wait(std::chrono::milliseconds patience, Done done) {
        wait_until(Clock::now() + patience, done);
    }
    template <class Done>
    void wait_until(Clock::time_point end, Done done) {
        while (!done() && Clock::now() < end) {
            context_.restart();
            context_.run_one_until(end);
        }
    }

    net::io_context context_{1};
    net::ip::tcp::socket socket_{context_};
    cip::Bytes buffer_ = cip::Bytes(16384);
    cip::Bytes received_;
};

RawStream::RawStream() : impl_(std::make_unique<Impl>()) {}
RawStream::RawStream(RawStream&& other) noexcept = default;
RawStream& RawStream::operator=(RawStream&& other) noexcept = default;
RawStream::~RawStream() = default;

error_code RawStream::connect(const std::string& host, std::uint16_t port, std::chrono::milliseconds patience) {
    return impl_->connect(host, port, patience);
}
bool RawStream::is_open() const { return impl_->is_open(); }
error_code RawStream::send(cip::ByteView octets, std::chrono::milliseconds patience) {
    return impl_->send(octets, patience);
}
RawStream::Received RawStream::receive(std::chrono::milliseconds patience) { return impl_->receive(patience); }
void RawStream::close() { impl_->close(); }
void RawStream::reset() { impl_->reset(); }
Endpoint RawStream::local() const { return impl_->local(); }
Endpoint RawStream::remote() const { return impl_->remote(); }

}  // namespace servobus::enip::asio
