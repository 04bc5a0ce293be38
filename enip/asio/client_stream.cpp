#include "enip/asio/client_stream.hpp"

#include <boost/asio/connect.hpp>
#include <utility>

#include "enip/asio/lookup.hpp"
#include "enip/asio/mark.hpp"
#include "enip/dscp.hpp"

namespace servobus::enip::asio {
namespace {

using boost::system::error_code;

constexpr std::size_t command_octets = 2;

// A peer that speaks another protocol shows it in its first octets; there is no need to wait for as many more as
// they would mean as a length.
bool is_command(cip::ByteView octets) {
    switch (static_cast<Command>(octets[0] | octets[1] << 8)) {
        case Command::nop:
        case Command::list_services:
        case Command::list_identity:
        case Command::list_interfaces:
        case Command::register_session:
        case Command::unregister_session:
        case Command::send_rr_data:
        case Command::send_unit_data:
            return true;
    }
    return false;
}

Endpoint to_endpoint(const net::ip::tcp::endpoint& native) {
    if (!native.address().is_v4()) return {};
    return {native.address().to_v4().to_uint(), native.port()};
}

}  // namespace

std::shared_ptr<ClientStream> ClientStream::create(const net::any_io_executor& executor) {
    return std::shared_ptr<ClientStream>(new ClientStream(executor));
}

void ClientStream::connect(const std::string& host, std::uint16_t port, Events events, Connected connected) {
    events_ = std::move(events);
    connected_ = std::move(connected);
    abandon_lookup_ =
        look_up(socket_.get_executor(), host, port,
                [self = shared_from_this()](auto error, auto addresses) { self->on_addresses(error, addresses); });
}

void ClientStream::on_addresses(error_code error, const Addresses& addresses) {
    if (!open_) return;
    if (error) {
        open_ = false;
        std::exchange(connected_, nullptr)(error);
        return;
    }
    net::async_connect(socket_, addresses, [self = shared_from_this()](error_code failure, const auto&) {
        if (!self->open_) return;
        if (failure) {
            self->open_ = false;
        } else {
            error_code ignored;
            self->socket_.set_option(net::ip::tcp::no_delay(true), ignored);
            mark(self->socket_.native_handle(), dscp_explicit);
            self->read();
        }
        std::exchange(self->connected_, nullptr)(failure);
    });
}

void ClientStream::read() {
    socket_.async_read_some(net::buffer(incoming_), [self = shared_from_this()](error_code error, std::size_t count) {
        if (!self->open_) return;
        if (error) {
            self->end(error);
            return;
        }
        self->on_octets(count);
        if (self->open_) self->read();
    });
}

void ClientStream::on_octets(std::size_t count) {
    cip::ByteView octets(incoming_.data(), count);
    while (open_ && !octets.empty()) {
        if (!begins_like_a_frame(octets)) {
            const auto foreign = events_.foreign;
            close();
            if (foreign) foreign();
            return;
        }
        if (auto frame = decoder_.next(octets)) events_.frame(std::move(*frame));
    }
}

bool ClientStream::begins_like_a_frame(cip::ByteView octets) {
    if (!decoder_.partial()) first_octets_.clear();
    if (first_octets_.size() == command_octets) return true;
    while (!octets.empty() && first_octets_.size() < command_octets) {
        first_octets_.push_back(octets.front());
        octets = octets.subspan(1);
    }
    return first_octets_.size() < command_octets || is_command(first_octets_);
}

void ClientStream::send(const Frame& frame) {
    if (!open_) return;
    frame.write(outgoing_);
    write();
}

Endpoint ClientStream::local() const {
    error_code ignored;
    return to_endpoint(socket_.local_endpoint(ignored));
}

Endpoint ClientStream::remote() const {
    error_code ignored;
    return to_endpoint(socket_.remote_endpoint(ignored));
}

void ClientStream::finish(std::function<void()> done) {
    if (!open_ || (writing_.empty() && outgoing_.empty())) {
        close();
        done();
        return;
    }
    finished_ = std::move(done);
}

void ClientStream::write() {
    if (!writing_.empty() || outgoing_.empty()) return;
    std::swap(writing_, outgoing_);
    net::async_write(socket_, net::buffer(writing_), [self = shared_from_this()](error_code error, std::size_t) {
        self->writing_.clear();
        if (!self->open_) return;
        if (error) {
            self->end(error);
            return;
        }
        self->write();
        if (self->writing_.empty() && self->finished_) {
            const auto finished = std::exchange(self->finished_, nullptr);
            self->close();
            finished();
        }
    });
}

void ClientStream::end(error_code error) {
    const auto finished = std::exchange(finished_, nullptr);
    const auto closed = events_.closed;
    close();
    if (finished) {
        finished();
    } else if (closed) {
        closed(error, decoder_.partial());
    }
}

void ClientStream::close() {
    open_ = false;
    if (const auto abandon = std::exchange(abandon_lookup_, nullptr)) abandon();
    error_code ignored;
    socket_.shutdown(net::ip::tcp::socket::shutdown_both, ignored);
    socket_.close(ignored);
}

}  // namespace servobus::enip::asio
