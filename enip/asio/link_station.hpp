// One LinkUser and the interfaces that are its ports: their frames, their links, its timer.
#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enip/asio/link_watch.hpp"
#include "enip/asio/packet_socket.hpp"
#include "enip/link_user.hpp"

namespace servobus::enip::asio {

class LinkStation {
public:
    /// `after_event` is called when a frame, a link or the time has done something to the user. The user outlives this.
    LinkStation(boost::asio::io_context& context, LinkUser& user, Traffic traffic, std::function<void()> after_event);

    /// By the names of the interfaces, the user's first port first. Returns why not.
    [[nodiscard]] std::optional<std::string> open(const std::vector<std::string>& interfaces);
    /// The MAC address of the first port.
    [[nodiscard]] const std::array<std::uint8_t, 6>& mac() const { return ports_.front()->mac; }
    /// Tells the user of its links, and serves it from now on, once the context runs.
    void start();
    /// Sends what is to be sent and looks at the next deadline: also when others have had to do with the user.
    void settle();
    void shut_down();

private:
    struct Port {
        explicit Port(const boost::asio::any_io_executor& executor) : packets(executor), watch(executor) {}
        PacketSocket packets;
        LinkWatch watch;
        std::array<std::uint8_t, 6> mac{};
        bool up = true;
    };

    [[nodiscard]] boost::asio::awaitable<void> frames(std::size_t number);
    [[nodiscard]] boost::asio::awaitable<void> links(std::size_t number);
    [[nodiscard]] boost::asio::awaitable<void> timer();
    void tell_link(std::size_t number, bool up);
    [[nodiscard]] bool is_due();
    /// The time for the user, which never goes back.
    [[nodiscard]] Time now();

    boost::asio::io_context& context_;
    LinkUser& user_;
    Traffic traffic_;
    std::function<void()> after_event_;
    std::vector<std::unique_ptr<Port>> ports_;
    boost::asio::steady_timer timer_;
    std::optional<Time> armed_;
    Time latest_{};
    bool stopped_ = false;
};

}  // namespace servobus::enip::asio
