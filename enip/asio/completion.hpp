// The thin edge between completion tokens (a callback, use_future, use_awaitable, ...) and code that is compiled once:
// an operation takes a Completion, and initiate() makes one of any token.
#pragma once

#include <boost/asio/any_completion_handler.hpp>
#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/associated_cancellation_slot.hpp>
#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/cancellation_type.hpp>
#include <boost/asio/execution/outstanding_work.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/prefer.hpp>
#include <boost/system/error_code.hpp>
#include <functional>
#include <utility>

namespace servobus {
namespace net = boost::asio;
}  // namespace servobus

namespace servobus::enip::asio {

using boost::system::error_code;

template <class Signature>
class Completion;

/// What is to be called, once, when an operation is done. It runs on the executor that belongs to the handler, never
/// inside the call that started the operation, and it keeps that executor busy until then.
template <class... Args>
class Completion<void(Args...)> {
public:
    using Handler = net::any_completion_handler<void(Args...)>;

    Completion() = default;
    Completion(Completion&&) noexcept = default;
    // The handler's own assignment never ends in Boost 1.81: it copies, and so on.
    Completion& operator=(Completion&& other) noexcept {
        handler_.swap(other.handler_);
        std::swap(executor_, other.executor_);
        return *this;
    }
    ~Completion() = default;

    template <class H>
    Completion(H handler, const net::any_io_executor& otherwise)
        : executor_(net::prefer(net::any_io_executor(net::get_associated_executor(handler, otherwise)),
                                net::execution::outstanding_work_t::tracked)),
          handler_(std::move(handler)) {}

    explicit operator bool() const { return static_cast<bool>(handler_); }

    /// Consumes the completion; a second call does nothing.
    void operator()(Args... args) {
        if (!handler_) return;
        net::post(std::exchange(executor_, {}),
                  [handler = Handler(std::move(handler_)), ... args = std::move(args)]() mutable {
                      std::move(handler)(std::move(args)...);
                  });
    }

    /// `cancel` is called, on any thread, when the handler's cancellation signal is given; that may be when all is done.
    void on_cancel(std::function<void()> cancel) {
        auto slot = net::get_associated_cancellation_slot(handler_);
        if (!slot.is_connected()) return;
        slot.assign([cancel = std::move(cancel)](net::cancellation_type type) {
            if (type != net::cancellation_type::none) cancel();
        });
    }

private:
    net::any_io_executor executor_;
    Handler handler_;
};

/// Starts an operation for a token: `start` is called with the Completion and must arrange that it is called.
template <class Signature, class Token, class Start>
auto initiate(const net::any_io_executor& executor, Start start, Token&& token) {
    return net::async_initiate<Token, Signature>(
        [executor, start = std::move(start)](auto handler) mutable {
            start(Completion<Signature>(std::move(handler), executor));
        },
        token);
}

}  // namespace servobus::enip::asio
