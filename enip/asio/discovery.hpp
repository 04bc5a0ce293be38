// Who is there: ListIdentity by broadcast on every interface, or to one host (R-ENC-13 to R-ENC-15).
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "enip/asio/completion.hpp"
#include "enip/encapsulation.hpp"
#include "enip/messages.hpp"

namespace servobus::enip::asio {

/// A device that answered, and from where.
struct FoundDevice {
    std::string address;
    std::uint16_t port = tcp_port;
    IdentityItem identity;
};

/// Answers to a broadcast that are kept; a larger network is searched host by host.
inline constexpr std::size_t max_found_devices = 1024;

struct BroadcastOptions {
    std::uint16_t port = tcp_port;
    std::chrono::milliseconds wait{1000};  ///< how long answers are collected
};

struct ProbeOptions {
    std::string host;
    std::uint16_t port = tcp_port;
    std::chrono::milliseconds wait{1000};     ///< for an answer over UDP; then TCP is tried
    std::chrono::milliseconds timeout{5000};  ///< for all of it
};

using FoundDevices = std::vector<FoundDevice>;
using DiscoveryDone = Completion<void(error_code, FoundDevices)>;

void start_broadcast(const net::any_io_executor& executor, BroadcastOptions options, DiscoveryDone done);
void start_probe(const net::any_io_executor& executor, ProbeOptions options, DiscoveryDone done);

/// Asks every device that a broadcast reaches. Completes after `wait` with void(error_code, FoundDevices), ordered by
/// address, each device once. An error means that not one interface could send.
/// The executor must not run handlers of this operation in parallel: a context with one thread, or a strand.
template <class Token>
auto async_discover(const net::any_io_executor& executor, BroadcastOptions options, Token&& token) {
    return initiate<void(error_code, FoundDevices)>(
        executor, [executor, options](DiscoveryDone done) { start_broadcast(executor, options, std::move(done)); },
        std::forward<Token>(token));
}

/// Asks one host, first over UDP, then over TCP. Completes with void(error_code, FoundDevices): one device, or why
/// there is none. The executor as above.
template <class Token>
auto async_probe(const net::any_io_executor& executor, ProbeOptions options, Token&& token) {
    return initiate<void(error_code, FoundDevices)>(
        executor,
        [executor, options = std::move(options)](DiscoveryDone done) mutable {
            start_probe(executor, std::move(options), std::move(done));
        },
        std::forward<Token>(token));
}

/// The identity in a ListIdentity reply. Devices that leave out the state octet or append some are understood too.
[[nodiscard]] cip::Decoded<IdentityItem> read_identity_reply(const Frame& reply);

}  // namespace servobus::enip::asio
