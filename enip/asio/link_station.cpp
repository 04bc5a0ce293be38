#include "enip/asio/link_station.hpp"

#include <fmt/format.h>
#include <net/if.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <string_view>
#include <utility>

namespace servobus::enip::asio {
namespace {

namespace net = boost::asio;
using boost::system::error_code;
using Wait = net::posix::stream_descriptor::wait_type;

constexpr auto awaited = net::as_tuple(net::use_awaitable);

// Frames taken in one go before other work has its turn.
constexpr int frames_at_once = 64;

std::string cannot_hear(const std::string& interface, const error_code& error) {
    std::string_view hint;
    if (error == boost::system::errc::operation_not_permitted) hint = "; it takes root or CAP_NET_RAW";
    return fmt::format("the frames of {} cannot be heard: {}{}", interface, error.message(), hint);
}

}  // namespace

LinkStation::LinkStation(net::io_context& context, LinkUser& user, Traffic traffic, std::function<void()> after_event)
    : context_(context), user_(user), traffic_(traffic), after_event_(std::move(after_event)), timer_(context) {}

std::optional<std::string> LinkStation::open(const std::vector<std::string>& interfaces) {
    for (const auto& interface : interfaces) {
        const auto index = ::if_nametoindex(interface.c_str());
        if (index == 0) return fmt::format("this machine has no interface '{}'", interface);
        auto port = std::make_unique<Port>(context_.get_executor());
        if (const auto error = port->packets.open(index, traffic_)) return cannot_hear(interface, error);
        if (const auto error = port->watch.open(index)) return cannot_hear(interface, error);
        const auto mac = port->watch.mac();
        if (!mac) return fmt::format("{} is no Ethernet interface", interface);
        port->mac = *mac;
        ports_.push_back(std::move(port));
    }
    return std::nullopt;
}

void LinkStation::start() {
    for (std::size_t number = 0; number < ports_.size(); ++number) {
        tell_link(number, ports_[number]->watch.has_link());
        net::co_spawn(context_, frames(number), net::detached);
        net::co_spawn(context_, links(number), net::detached);
    }
    net::co_spawn(context_, timer(), net::detached);
    after_event_();
    settle();
}

void LinkStation::tell_link(std::size_t number, bool up) {
    if (std::exchange(ports_[number]->up, up) != up) user_.on_link(number, up, now());
}

// gcc 12 inlines one of the two functions of Asio that allocate and free a coroutine's frame, and not the other.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"

net::awaitable<void> LinkStation::frames(std::size_t number) {
    auto& socket = ports_[number]->packets;
    std::array<std::uint8_t, max_link_frame> buffer;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    while (!stopped_) {
        const auto [error] = co_await socket.descriptor().async_wait(Wait::wait_read, awaited);
        if (stopped_ || error == net::error::operation_aborted) co_return;
        for (int i = 0; i < frames_at_once; ++i) {
            const auto frame = socket.receive(buffer);
            if (!frame) break;
            user_.on_frame(number, *frame, now());
        }
        after_event_();
        settle();
    }
}

net::awaitable<void> LinkStation::links(std::size_t number) {
    auto& watch = ports_[number]->watch;
    while (!stopped_) {
        const auto [error] = co_await watch.descriptor().async_wait(Wait::wait_read, awaited);
        if (stopped_ || error == net::error::operation_aborted) co_return;
        const auto up = watch.news();
        if (!up) continue;
        tell_link(number, *up);
        after_event_();
        settle();
    }
}

net::awaitable<void> LinkStation::timer() {
    while (!stopped_) {
        timer_.expires_at(armed_.value_or(Time::max()));
        static_cast<void>(co_await timer_.async_wait(awaited));
        if (stopped_) co_return;
        if (is_due()) {
            user_.on_timer(now());
            after_event_();
        }
        settle();
        armed_ = user_.next_deadline();
    }
}

#pragma GCC diagnostic pop

bool LinkStation::is_due() {
    const auto next = user_.next_deadline();
    return next && *next <= now();
}

// A deadline that moved later is noticed when the timer fires; only an earlier one needs a new start.
void LinkStation::settle() {
    if (stopped_) return;
    for (const auto& frame : user_.take_frames()) ports_[frame.port]->packets.send(frame.octets);
    const auto next = user_.next_deadline();
    if (!next || (armed_ && *armed_ <= *next)) return;
    armed_ = next;
    timer_.cancel();
}

Time LinkStation::now() { return latest_ = std::max(latest_, std::chrono::steady_clock::now()); }

void LinkStation::shut_down() {
    if (std::exchange(stopped_, true)) return;
    for (auto& port : ports_) {
        port->packets.close();
        port->watch.close();
    }
    timer_.cancel();
}

}  // namespace servobus::enip::asio
