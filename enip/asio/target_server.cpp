#include "enip/asio/target_server.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <utility>
#include <vector>

#include "enip/asio/line_server.hpp"
#include "enip/asio/link_station.hpp"
#include "enip/asio/local_exchange.hpp"
#include "enip/asio/managed_interface.hpp"
#include "enip/asio/target_station.hpp"

namespace servobus::enip::asio {
namespace {

namespace net = boost::asio;
using boost::system::error_code;

constexpr auto awaited = net::as_tuple(net::use_awaitable);

}  // namespace

class TargetServer::Impl {
public:
    explicit Impl(std::function<void(const std::string&)> problem)
        : shared_{context_, std::move(problem), [this](TargetStation& station) { gather(station); },
                  [this] {
                      if (managed_) managed_->settle();
                  },
                  [this](Time time) { wake_by(time); }},
          timer_(context_),
          signals_(context_) {}

    boost::system::result<Listening, ListenError> listen(Target& target, const ListenOptions& options);
    boost::system::result<std::array<std::uint8_t, 6>, ListenError> manage(Target& target, AddressUser& user,
                                                                           ManageOptions options);
    std::optional<ListenError> join_ring(LinkUser& user, const std::vector<std::string>& interfaces);
    std::optional<ListenError> converse(MessageUser& user, const std::string& path);
    std::optional<ListenError> serve_lines(const LineService& service, const std::string& where);
    void every(std::chrono::milliseconds interval, std::function<void(Time)> look);
    void catch_signals();
    void run(const std::function<void()>& stopping);
    void in_background(Target& target, std::function<void()> job, std::function<void(Time)> done);
    void stop() {
        net::post(context_, [this] { shut_down(); });
    }

private:
    /// Somebody who looks at the targets from time to time.
    struct Onlooker {
        std::chrono::milliseconds interval;
        std::function<void(Time)> look;
        net::steady_timer timer;
    };

    void report(const std::string& line) const {
        if (shared_.problem) shared_.problem(line);
    }
    net::awaitable<void> wait_for_signal();
    net::awaitable<void> look_on(Onlooker& onlooker);
    net::awaitable<void> keep_time();
    void wake_by(Time time);
    void gather(TargetStation& station);
    void send_gathered();
    void after_line();
    void shut_down();

    net::io_context context_{1};
    TargetStation::Shared shared_;
    net::steady_timer timer_;       ///< of all stations: what is due at the same time wakes the process once
    std::optional<Time> wakes_at_;  ///< while it waits
    net::signal_set signals_;
    std::vector<std::unique_ptr<TargetStation>> stations_;
    std::unique_ptr<ManagedInterface> managed_;
    std::unique_ptr<LinkStation> ring_;
    std::unique_ptr<LocalExchange> local_;
    std::vector<std::unique_ptr<LineServer>> lines_;
    std::vector<std::unique_ptr<Onlooker>> onlookers_;
    IoQueue gathered_;    ///< of several stations, on its way through the socket of the first
    bool sends_ = false;  ///< soon: nobody need ask for it
    std::function<void()> stopping_;
    bool stopped_ = false;
    std::unique_ptr<net::thread_pool> background_;  ///< from the first job on
};

boost::system::result<Listening, ListenError> TargetServer::Impl::listen(Target& target, const ListenOptions& options) {
    auto station = std::make_unique<TargetStation>(target, shared_);
    auto listening = station->listen(options);
    if (listening) stations_.push_back(std::move(station));
    return listening;
}

boost::system::result<std::array<std::uint8_t, 6>, ListenError> TargetServer::Impl::manage(Target& target,
                                                                                           AddressUser& user,
                                                                                           ManageOptions options) {
    auto& station = *stations_.emplace_back(std::make_unique<TargetStation>(target, shared_));
    managed_ = std::make_unique<ManagedInterface>(context_, station, user, shared_.problem);
    if (auto failed = managed_->open(std::move(options))) return *std::move(failed);
    return managed_->mac();
}

std::optional<ListenError> TargetServer::Impl::join_ring(LinkUser& user, const std::vector<std::string>& interfaces) {
    ring_ = std::make_unique<LinkStation>(context_, user, Traffic::ring, [] {});
    if (auto reason = ring_->open(interfaces)) return ListenError{*std::move(reason)};
    return std::nullopt;
}

std::optional<ListenError> TargetServer::Impl::converse(MessageUser& user, const std::string& path) {
    local_ = std::make_unique<LocalExchange>(context_, user);
    if (auto reason = local_->open(path)) return ListenError{*std::move(reason)};
    return std::nullopt;
}

std::optional<ListenError> TargetServer::Impl::serve_lines(const LineService& service, const std::string& where) {
    auto server = std::make_unique<LineServer>(
        context_.get_executor(), service, [this] { after_line(); }, [this](const std::string& line) { report(line); });
    auto reason = where == "-" ? server->use_standard_streams() : server->listen(where);
    if (reason) return ListenError{*std::move(reason)};
    lines_.push_back(std::move(server));
    return std::nullopt;
}

void TargetServer::Impl::every(std::chrono::milliseconds interval, std::function<void(Time)> look) {
    onlookers_.push_back(std::make_unique<Onlooker>(Onlooker{interval, std::move(look), net::steady_timer(context_)}));
}

net::awaitable<void> TargetServer::Impl::look_on(Onlooker& onlooker) {
    auto next = std::chrono::steady_clock::now();
    while (!stopped_) {
        onlooker.look(std::chrono::steady_clock::now());
        // A rate is kept, but what nobody has seen in time is not shown afterwards.
        next = std::max(next + onlooker.interval, std::chrono::steady_clock::now());
        onlooker.timer.expires_at(next);
        static_cast<void>(co_await onlooker.timer.async_wait(awaited));
    }
}

void TargetServer::Impl::catch_signals() {
    error_code error;
    signals_.add(SIGINT, error);
    if (!error) signals_.add(SIGTERM, error);
    if (error) {
        report(fmt::format("signals are not caught: {}", error.message()));
        return;
    }
    net::co_spawn(context_, wait_for_signal(), net::detached);
}

void TargetServer::Impl::run(const std::function<void()>& stopping) {
    stopping_ = stopping;
    for (const auto& station : stations_) station->start();
    net::co_spawn(context_, keep_time(), net::detached);
    if (managed_) managed_->start();
    if (ring_) ring_->start();
    if (local_) local_->start();
    for (const auto& lines : lines_) lines->start();
    for (const auto& onlooker : onlookers_) net::co_spawn(context_, look_on(*onlooker), net::detached);
    context_.run();
    if (background_) background_->join();
}

void TargetServer::Impl::in_background(Target& target, std::function<void()> job, std::function<void(Time)> done) {
    if (!background_) background_ = std::make_unique<net::thread_pool>(1);
    net::post(*background_, [this, &target, job = std::move(job), done = std::move(done)] {
        job();
        net::post(context_, [this, &target, done] {
            if (stopped_) return;
            done(std::chrono::steady_clock::now());
            for (const auto& station : stations_) {
                if (&station->target() == &target) station->after_line();
            }
        });
    });
}

net::awaitable<void> TargetServer::Impl::keep_time() {
    for (const auto& station : stations_) station->on_time();
    while (!stopped_) {
        auto next = Time::max();
        for (const auto& station : stations_) next = std::min(next, station->deadline().value_or(Time::max()));
        wakes_at_ = next;
        timer_.expires_at(next);
        static_cast<void>(co_await timer_.async_wait(awaited));
        wakes_at_.reset();
        const auto now = std::chrono::steady_clock::now();
        sends_ = true;
        for (const auto& station : stations_) {
            if (station->deadline().value_or(Time::max()) <= now) station->on_time();
        }
        send_gathered();
    }
}

void TargetServer::Impl::wake_by(Time time) {
    if (wakes_at_ && time < *wakes_at_) timer_.cancel();
}

net::awaitable<void> TargetServer::Impl::wait_for_signal() {
    if (stopped_) co_return;
    const auto [failed, number] = co_await signals_.async_wait(awaited);
    if (!failed) shut_down();
}

// A line may have happened to any of them.
void TargetServer::Impl::after_line() {
    for (const auto& station : stations_) station->after_line();
}

// What several stations have to send at the same time leaves in one system call: a socket may send for other addresses
// of its machine, as long as the port is the same.
void TargetServer::Impl::gather(TargetStation& station) {
    auto& queue = station.target().io_queue();
    auto& first = *stations_.front();
    if (stations_.size() == 1 || station.io_port() != first.io_port()) {
        static_cast<void>(station.io_socket().send(queue));
        queue.clear();
        return;
    }
    gathered_.append(queue);
    queue.clear();
    if (!std::exchange(sends_, true)) net::post(context_, [this] { send_gathered(); });
}

void TargetServer::Impl::send_gathered() {
    sends_ = false;
    if (!stopped_) static_cast<void>(stations_.front()->io_socket().send(gathered_));
    gathered_.clear();
}

void TargetServer::Impl::shut_down() {
    if (std::exchange(stopped_, true)) return;
    if (stopping_) stopping_();
    signals_.cancel();
    timer_.cancel();
    for (const auto& lines : lines_) lines->stop();
    for (const auto& onlooker : onlookers_) onlooker->timer.cancel();
    for (const auto& station : stations_) station->shut_down();
    if (managed_) managed_->shut_down();  // when nobody uses the address any more
    if (ring_) ring_->shut_down();
    if (local_) local_->shut_down();
}

TargetServer::TargetServer(std::function<void(const std::string&)> problem)
    : impl_(std::make_unique<Impl>(std::move(problem))) {}

TargetServer::~TargetServer() = default;

boost::system::result<Listening, ListenError> TargetServer::listen(Target& target, const ListenOptions& options) {
    return impl_->listen(target, options);
}

boost::system::result<std::array<std::uint8_t, 6>, ListenError> TargetServer::manage(Target& target, AddressUser& user,
                                                                                     ManageOptions options) {
    return impl_->manage(target, user, std::move(options));
}

std::optional<ListenError> TargetServer::join_ring(LinkUser& user, const std::vector<std::string>& interfaces) {
    return impl_->join_ring(user, interfaces);
}

std::optional<ListenError> TargetServer::converse(MessageUser& user, const std::string& path) {
    return impl_->converse(user, path);
}

std::optional<ListenError> TargetServer::serve_lines(const LineService& service, const std::string& where) {
    return impl_->serve_lines(service, where);
}

void TargetServer::every(std::chrono::milliseconds interval, std::function<void(Time)> look) {
    impl_->every(interval, std::move(look));
}

void TargetServer::in_background(Target& target, std::function<void()> job, std::function<void(Time)> done) {
    impl_->in_background(target, std::move(job), std::move(done));
}

void TargetServer::catch_signals() { impl_->catch_signals(); }

void TargetServer::run(const std::function<void()>& stopping) { impl_->run(stopping); }

void TargetServer::stop() { impl_->stop(); }

}  // namespace servobus::enip::asio
