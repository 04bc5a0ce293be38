// The explicit messaging client: one TCP connection and session to one device, requests over it.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cip/message.hpp"
#include "cip/path.hpp"
#include "drive/parameter.hpp"
#include "drive/store.hpp"
#include "enip/asio/completion.hpp"
#include "enip/encapsulation.hpp"
#include "scanner/error.hpp"
#include "scanner/exchange.hpp"
#include "scanner/reading.hpp"

namespace servobus::scanner {

/// Requests of one client that are on the wire at a time; further ones wait.
inline constexpr std::size_t max_outstanding = 16;
/// Requests that wait; one more is refused with Error::too_many_requests.
inline constexpr std::size_t max_waiting = 1024;

struct ClientOptions {
    /// For connecting, and for each request from the moment that it is made.
    std::chrono::milliseconds timeout{5000};
    /// The hops to the device, port segments only. Requests travel in an Unconnected_Send; a class 3 connection takes
    /// them in front of its path.
    cip::Path route{};
    /// How many requests may be on the wire, at most max_outstanding. 1 suits devices that read one message at a time.
    std::size_t outstanding = max_outstanding;
    /// Who the originator is in a Forward_Open (R-SCN-2). 0xFFFF is nobody's vendor id.
    std::uint16_t vendor = 0xFFFF;
    /// Start of serial numbers, connection ids and sender contexts; random when left out.
    std::optional<std::uint64_t> seed{};
};

/// The parts of a request that may differ from call to call.
struct CallOptions {
    /// Instead of ClientOptions::timeout.
    std::optional<std::chrono::milliseconds> timeout{};
};

/// A client for any EtherNet/IP adapter. Every operation takes a completion token (a callback, use_future,
/// use_awaitable, ...), never blocks, never throws, and always completes: with a result, an Error, an error of the
/// operating system, or operation_aborted when its cancellation signal was given or the client went away.
/// A device's refusal is no error: its CIP status is in the Response.
/// All members may be called from any thread. The executor's context must outlive the client.
class Client {
public:
    explicit Client(net::any_io_executor executor, ClientOptions options = {});
    Client(Client&&) noexcept = default;
    Client& operator=(Client&& other) noexcept;
    /// Closes the connection at once; outstanding operations complete with operation_aborted.
    ~Client();

    [[nodiscard]] net::any_io_executor get_executor() const;

    /// Connects and registers a session. Completes with void(error_code). After an error it may be called again.
    template <class Token>
    auto async_connect(std::string host, std::uint16_t port, Token&& token) {
        return enip::asio::initiate<void(error_code)>(
            get_executor(),
            [impl = impl_, host = std::move(host), port](ConnectDone done) mutable {
                start_connect(impl, std::move(host), port, std::move(done));
            },
            std::forward<Token>(token));
    }

    /// Opens a class 3 connection to the device's message router, large if it can and small otherwise. Completes with
    /// void(error_code, cip::Response): the answer to the Forward_Open. When its status is ok, later requests take the
    /// connection, one after the other. Without requests the device drops the connection after about a minute.
    template <class Token>
    auto async_open_connection(Token&& token) {
        return enip::asio::initiate<void(error_code, cip::Response)>(
            get_executor(), [impl = impl_](CallDone done) { start_open_connection(impl, std::move(done)); },
            std::forward<Token>(token));
    }

    /// Sends a request. Completes with void(error_code, cip::Response). Several may be outstanding; their responses
    /// come in any order. With a route, a response to service 0x52 is the word of a router on the way.
    template <class Token>
    auto async_call(cip::Request request, CallOptions options, Token&& token) {
        return enip::asio::initiate<void(error_code, cip::Response)>(
            get_executor(),
            [impl = impl_, request = std::move(request), options](CallDone done) mutable {
                start_call(impl, std::move(request), options, std::move(done));
            },
            std::forward<Token>(token));
    }
    template <class Token>
    auto async_call(cip::Request request, Token&& token) {
        return async_call(std::move(request), CallOptions{}, std::forward<Token>(token));
    }

    /// As async_call, never over the class 3 connection and never in an Unconnected_Send: a request to the device at
    /// the other end of the TCP connection, with `items` behind it. Completes with void(error_code, Exchange).
    template <class Token>
    auto async_exchange(cip::Request request, std::vector<enip::Item> items, CallOptions options, Token&& token) {
        return enip::asio::initiate<void(error_code, Exchange)>(
            get_executor(),
            [impl = impl_, request = std::move(request), items = std::move(items), options](ExchangeDone done) mutable {
                start_exchange(impl, std::move(request), std::move(items), options, std::move(done));
            },
            std::forward<Token>(token));
    }

    /// Nullopt when there is no session, or no more.
    [[nodiscard]] std::optional<TcpEnds> ends() const;

    /// Sends a NOP, which nobody answers: it keeps the device from closing an idle session (R-ENC-24).
    void keep_alive();

    /// Reads a parameter. Completes with void(error_code, ReadOutcome). The row must outlive the operation.
    template <class Token>
    auto async_read(const drive::Parameter& row, Token&& token) {
        return enip::asio::initiate<void(error_code, ReadOutcome)>(
            get_executor(), [impl = impl_, &row](ReadDone done) { start_read(impl, row, std::move(done)); },
            std::forward<Token>(token));
    }

    /// Writes a parameter; the value is of the row's kind and fits its CIP type. Completes with
    /// void(error_code, cip::Status). Limits are the device's affair.
    template <class Token>
    auto async_write(const drive::Parameter& row, drive::Value value, Token&& token) {
        return enip::asio::initiate<void(error_code, cip::Status)>(
            get_executor(),
            [impl = impl_, &row, value = std::move(value)](WriteDone done) {
                start_write(impl, row, value, std::move(done));
            },
            std::forward<Token>(token));
    }

    /// Closes the class 3 connection and the session in good manners; outstanding requests complete with
    /// operation_aborted. Completes with void(error_code), success also when there was nothing to close.
    template <class Token>
    auto async_close(Token&& token) {
        return enip::asio::initiate<void(error_code)>(
            get_executor(), [impl = impl_](ConnectDone done) { start_close(impl, std::move(done)); },
            std::forward<Token>(token));
    }

private:
    class Impl;
    using Shared = std::shared_ptr<Impl>;
    using ConnectDone = enip::asio::Completion<void(error_code)>;
    using CallDone = enip::asio::Completion<void(error_code, cip::Response)>;
    using ExchangeDone = enip::asio::Completion<void(error_code, Exchange)>;
    using ReadDone = enip::asio::Completion<void(error_code, ReadOutcome)>;
    using WriteDone = enip::asio::Completion<void(error_code, cip::Status)>;

    static void start_connect(const Shared& impl, std::string host, std::uint16_t port, ConnectDone done);
    static void start_open_connection(const Shared& impl, CallDone done);
    static void start_call(const Shared& impl, cip::Request request, CallOptions options, CallDone done);
    static void start_exchange(const Shared& impl, cip::Request request, std::vector<enip::Item> items,
                               CallOptions options, ExchangeDone done);
    static void start_read(const Shared& impl, const drive::Parameter& row, ReadDone done);
    static void start_write(const Shared& impl, const drive::Parameter& row, const drive::Value& value, WriteDone done);
    static void start_close(const Shared& impl, ConnectDone done);

    Shared impl_;
};

}  // namespace servobus::scanner
