#include "enip/asio/discovery.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <set>
#include <tuple>
#include <utility>

#include "cip/wire.hpp"
#include "enip/asio/asio.hpp"
#include "enip/asio/client_stream.hpp"
#include "enip/asio/interfaces.hpp"
#include "enip/asio/lookup.hpp"
#include "enip/asio/mark.hpp"
#include "enip/dscp.hpp"

namespace servobus::enip::asio {
namespace {

using net::ip::udp;
using std::chrono::milliseconds;

constexpr std::size_t max_datagram = 1500;
constexpr milliseconds probe_interval{300};
/// The state when a device does not tell it (R-CPF-5).
constexpr std::uint8_t unknown_state = 0xFF;

/// A ListIdentity request; its context tells how long a device may take to answer a broadcast (R-ENC-14). Devices
/// stretch less than 500 ms to 500 ms.
Frame list_identity(milliseconds wait) {
    Frame request;
    request.command = Command::list_identity;
    const auto longest = std::clamp<milliseconds::rep>(wait.count() / 2, 1, 0xFFFF);
    request.context[0] = static_cast<std::uint8_t>(longest & 0xFF);
    request.context[1] = static_cast<std::uint8_t>(longest >> 8);
    return request;
}

// ---------------------------------------------------------------------------------------------------- broadcast

/// Sends through every interface and collects until time is up.
class Broadcast : public std::enable_shared_from_this<Broadcast> {
public:
    Broadcast(const net::any_io_executor& executor, BroadcastOptions options, DiscoveryDone done)
        : executor_(executor), options_(options), done_(std::move(done)), end_(executor), again_(executor) {}

    void start() {
        for (const auto& interface : interfaces()) {
            if (interface.broadcasts) open(interface);
        }
        send();
        if (!sent_) {
            finish(first_error_ ? first_error_ : net::error::network_down);
            return;
        }
        done_.on_cancel([weak = weak_from_this(), executor = executor_] {
            net::post(executor, [weak] {
                if (const auto self = weak.lock()) self->finish(net::error::operation_aborted);
            });
        });
        // Datagrams get lost, so the question is put twice; a device that answers twice is found once.
        again_.expires_after(options_.wait / 4);
        again_.async_wait([self = shared_from_this()](error_code error) {
            if (!error) self->send();
        });
        end_.expires_after(options_.wait);
        end_.async_wait([self = shared_from_this()](error_code error) {
            if (!error) self->finish({});
        });
    }

private:
    /// A socket of one interface. Its address is where the answers go to.
    struct Outlet {
        Outlet(const net::any_io_executor& executor, const Interface& at) : interface(at), socket(executor) {}
        Interface interface;
        udp::socket socket;
        udp::endpoint sender;
        std::array<std::uint8_t, max_datagram> octets{};
    };

    void open(const Interface& interface) {
        const auto outlet = std::make_shared<Outlet>(executor_, interface);
        error_code error;
        outlet->socket.open(udp::v4(), error);
        if (!error) outlet->socket.set_option(net::socket_base::broadcast(true), error);
        if (!error) outlet->socket.bind({net::ip::address_v4(interface.address), 0}, error);
        if (!error) outlet->socket.non_blocking(true, error);
        if (error) {
            if (!first_error_) first_error_ = error;
            return;
        }
        mark(outlet->socket.native_handle(), dscp_explicit);
        // Without this the system sends 255.255.255.255 through one interface only.
        const auto index = htonl(interface.index);
        ::setsockopt(outlet->socket.native_handle(), IPPROTO_IP, IP_UNICAST_IF, &index, sizeof index);
        outlets_.push_back(outlet);
        receive(outlet);
    }

    void send() {
        const auto octets = list_identity(options_.wait).encode();
        for (const auto& outlet : outlets_) {
            for (const auto& address :
                 {net::ip::address_v4(outlet->interface.broadcast()), net::ip::address_v4::broadcast()}) {
                error_code error;
                outlet->socket.send_to(net::buffer(octets), {address, options_.port}, 0, error);
                if (!error) sent_ = true;
                if (error && !first_error_) first_error_ = error;
            }
        }
    }

    void receive(const std::shared_ptr<Outlet>& outlet) {
        outlet->socket.async_receive_from(net::buffer(outlet->octets), outlet->sender,
                                          [self = shared_from_this(), outlet](error_code error, std::size_t count) {
                                              if (self->finished_) return;
                                              if (!error)
                                                  self->on_datagram(outlet->sender,
                                                                    cip::ByteView(outlet->octets).first(count));
                                              // An ICMP message may make one receive fail; a closed socket makes all of them fail.
                                              if (error != net::error::operation_aborted && outlet->socket.is_open())
                                                  self->receive(outlet);
                                          });
    }

    void on_datagram(const udp::endpoint& sender, cip::ByteView octets) {
        const auto frame = Frame::parse(octets);
        if (!frame) return;
        auto identity = read_identity_reply(*frame);
        if (!identity || found_.size() >= max_found_devices) return;
        if (!seen_.emplace(sender, identity->vendor, identity->serial_number).second) return;
        found_.emplace_back(sender, std::move(*identity));
    }

    void finish(error_code error) {
        if (finished_) return;
        finished_ = true;
        for (const auto& outlet : outlets_) {
            error_code ignored;
            outlet->socket.close(ignored);
        }
        again_.cancel();
        end_.cancel();
        std::ranges::sort(found_, {},
                          [](const auto& each) { return std::pair(each.first, each.second.serial_number); });
        FoundDevices devices;
        for (auto& [sender, identity] : found_) {
            devices.push_back({sender.address().to_string(), sender.port(), std::move(identity)});
        }
        done_(error, std::move(devices));
    }

    net::any_io_executor executor_;
    BroadcastOptions options_;
    DiscoveryDone done_;
    net::steady_timer end_;
    net::steady_timer again_;
    std::vector<std::shared_ptr<Outlet>> outlets_;
    std::set<std::tuple<udp::endpoint, std::uint16_t, std::uint32_t>> seen_;
    std::vector<std::pair<udp::endpoint, IdentityItem>> found_;
    error_code first_error_;
    bool sent_ = false;
    bool finished_ = false;
};

// ---------------------------------------------------------------------------------------------------- one host

/// Asks over UDP until `wait` has passed, then once over TCP.
class Probe : public std::enable_shared_from_this<Probe> {
public:
    Probe(const net::any_io_executor& executor, ProbeOptions options, DiscoveryDone done)
        : executor_(executor),
          options_(std::move(options)),
          done_(std::move(done)),
          socket_(executor),
          end_(executor),
          next_(executor) {}

    void start() {
        const auto weak = weak_from_this();
        done_.on_cancel([weak, executor = executor_] {
            net::post(executor, [weak] {
                if (const auto self = weak.lock()) self->finish(net::error::operation_aborted);
            });
        });
        end_.expires_after(options_.timeout);
        end_.async_wait([self = shared_from_this()](error_code error) {
            if (!error) self->finish(net::error::timed_out);
        });
        started_ = std::chrono::steady_clock::now();
        abandon_lookup_ =
            look_up(executor_, options_.host, options_.port, [weak](error_code error, const Addresses& found) {
                if (const auto self = weak.lock()) self->on_addresses(error, found);
            });
    }

private:
    void on_addresses(error_code error, const Addresses& found) {
        if (finished_) return;
        if (error) {
            finish(error);
            return;
        }
        target_ = udp::endpoint(found.front().address(), found.front().port());
        error_code failure;
        socket_.open(target_.protocol(), failure);
        if (!failure) mark(socket_.native_handle(), dscp_explicit);
        // Connected, so that only the asked host answers, and a closed port is told at once.
        if (!failure) socket_.connect(target_, failure);
        if (failure) {
            ask_over_tcp();
            return;
        }
        receive();
        ask_over_udp();
    }

    void ask_over_udp() {
        if (finished_ || over_tcp_) return;
        if (std::chrono::steady_clock::now() - started_ >= options_.wait) {
            ask_over_tcp();
            return;
        }
        error_code failure;
        socket_.send(net::buffer(list_identity(options_.wait).encode()), 0, failure);
        if (failure) {
            ask_over_tcp();
            return;
        }
        next_.expires_after(std::min(probe_interval, options_.wait));
        next_.async_wait([self = shared_from_this()](error_code error) {
            if (!error) self->ask_over_udp();
        });
    }

    void receive() {
        socket_.async_receive(net::buffer(octets_), [self = shared_from_this()](error_code error, std::size_t count) {
            if (self->finished_ || self->over_tcp_) return;
            if (error) {
                self->ask_over_tcp();
                return;
            }
            if (const auto frame = Frame::parse(cip::ByteView(self->octets_).first(count))) self->on_frame(*frame);
            if (!self->finished_) self->receive();
        });
    }

    void ask_over_tcp() {
        if (finished_ || over_tcp_) return;
        over_tcp_ = true;
        error_code ignored;
        socket_.close(ignored);
        next_.cancel();
        stream_ = ClientStream::create(executor_);
        const auto weak = weak_from_this();
        const auto on_end = [weak](error_code error) {
            if (const auto self = weak.lock()) self->finish(error);
        };
        stream_->connect(options_.host, options_.port,
                         {.frame =
                              [weak](const FrameDecoder::Result& result) {
                                  if (const auto self = weak.lock()) self->on_frame(result.frame);
                              },
                          .foreign = [on_end] { on_end(make_error_code(boost::system::errc::bad_message)); },
                          .closed = [on_end](error_code error, bool) { on_end(error); }},
                         [weak](error_code error) {
                             const auto self = weak.lock();
                             if (!self || self->finished_) return;
                             if (error) {
                                 self->finish(error);
                             } else {
                                 self->stream_->send(list_identity(self->options_.wait));
                             }
                         });
    }

    void on_frame(const Frame& frame) {
        auto identity = read_identity_reply(frame);
        if (!identity || finished_) return;
        devices_.push_back({target_.address().to_string(), target_.port(), std::move(*identity)});
        finish({});
    }

    void finish(error_code error) {
        if (finished_) return;
        finished_ = true;
        if (const auto abandon = std::exchange(abandon_lookup_, nullptr)) abandon();
        error_code ignored;
        socket_.close(ignored);
        next_.cancel();
        end_.cancel();
        if (stream_) stream_->close();
        done_(error, std::move(devices_));
    }

    net::any_io_executor executor_;
    ProbeOptions options_;
    DiscoveryDone done_;
    udp::socket socket_;
    net::steady_timer end_;
    net::steady_timer next_;
    std::chrono::steady_clock::time_point started_;
    std::function<void()> abandon_lookup_;
    udp::endpoint target_;
    std::array<std::uint8_t, max_datagram> octets_{};
    std::shared_ptr<ClientStream> stream_;
    FoundDevices devices_;
    bool over_tcp_ = false;
    bool finished_ = false;
};

}  // namespace

void start_broadcast(const net::any_io_executor& executor, BroadcastOptions options, DiscoveryDone done) {
    const auto broadcast = std::make_shared<Broadcast>(executor, options, std::move(done));
    net::dispatch(executor, [broadcast] { broadcast->start(); });
}

void start_probe(const net::any_io_executor& executor, ProbeOptions options, DiscoveryDone done) {
    const auto probe = std::make_shared<Probe>(executor, std::move(options), std::move(done));
    net::dispatch(executor, [probe] { probe->start(); });
}

cip::Decoded<IdentityItem> read_identity_reply(const Frame& reply) {
    constexpr std::size_t name_length_at = 32;
    constexpr std::size_t fixed_octets = 34;
    if (reply.command != Command::list_identity || reply.status != EncapsulationStatus::success) {
        return cip::DecodeError::bad_value;
    }
    const auto packet = CommonPacket::parse(reply.data);
    if (!packet) return packet.error();
    const auto* item = packet->find(ItemType::identity);
    if (item == nullptr || item->data.size() <= name_length_at) return cip::DecodeError::truncated;
    auto octets = item->data;
    const std::size_t whole = fixed_octets + octets[name_length_at];
    if (octets.size() == whole - 1) octets.push_back(unknown_state);
    if (octets.size() > whole) octets.resize(whole);
    return IdentityItem::parse(octets);
}

}  // namespace servobus::enip::asio
