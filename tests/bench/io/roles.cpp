#include "tests/bench/io/roles.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/prctl.h>
#include <sys/socket.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <vector>

#include "enip/encapsulation.hpp"
#include "tests/bench/io/explicit_client.hpp"
#include "tests/bench/io/image.hpp"
#include "tests/bench/io/originator_role.hpp"
#include "tests/bench/io/sockets.hpp"

namespace servobus::bench {
namespace {

volatile sig_atomic_t stopped = 0;

// Without SA_RESTART: whatever waits returns.
void stop_at_sigterm() {
    struct sigaction action {};
    action.sa_handler = [](int) { stopped = 1; };
    ::sigaction(SIGTERM, &action, nullptr);
}

void say(const std::string& line) {
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

int spin() {
    say("ready");
    while (stopped == 0) continue;
    return 0;
}

struct Pacing {
    Descriptor socket;
    sockaddr_in peer;
    Nanoseconds interval;
};

Pacing pacing(const std::vector<std::string>& words) {
    // A sleep may end 50 us late unless one says otherwise; a floor must not owe its height to that.
    ::prctl(PR_SET_TIMERSLACK, 1);
    Pacing result{udp_socket(parse_endpoint(words.at(1))), to_sockaddr(parse_endpoint(words.at(2))),
                  std::stoll(words.at(3)) * 1000};
    say(std::to_string(local_endpoint(result.socket).port));
    return result;
}

template <std::size_t Octets>
void send_to(const Pacing& to, const std::array<std::uint8_t, Octets>& octets) {
    ::sendto(to.socket.number(), octets.data(), octets.size(), 0, reinterpret_cast<const sockaddr*>(&to.peer),
             sizeof to.peer);
}

int sender(const std::vector<std::string>& words) {
    const auto to = pacing(words);
    const auto connection = static_cast<std::uint32_t>(std::stoul(words.at(4)));
    std::uint32_t sequence = 0;
    for (auto next = monotonic() + to.interval; stopped == 0; next += to.interval) {
        if (!sleep_until(next)) continue;
        send_to(to, t_to_o(connection, ++sequence, 0));
    }
    return 0;
}

int paced_echo(const std::vector<std::string>& words) {
    const auto to = pacing(words);
    std::array<std::uint8_t, o_to_t_octets> last{};
    std::uint32_t sequence = 0;
    for (auto next = monotonic() + to.interval; stopped == 0; next += to.interval) {
        if (!sleep_until(next)) continue;
        while (::recv(to.socket.number(), last.data(), last.size(), MSG_DONTWAIT) > 0) continue;
        send_to(to, t_to_o(0, ++sequence, get32(last, outputs_in_o_to_t)));
    }
    return 0;
}

/// What many connections ask of one end at least: at each interval one system call that sends all of its datagrams, and one
/// for each socket that takes what has come there.
int fleet(const std::vector<std::string>& words) {
    const auto from = parse_endpoint(words.at(1));
    const auto to = parse_endpoint(words.at(2));
    const auto count = std::stoul(words.at(3));
    const auto interval = std::stoll(words.at(4)) * 1000;
    ::prctl(PR_SET_TIMERSLACK, 1);
    std::vector<Descriptor> sockets;
    std::vector<sockaddr_in> peers;
    for (std::uint32_t i = 0; i < count; ++i) {
        sockets.push_back(udp_socket({from.address + i, from.port}));
        peers.push_back(to_sockaddr({to.address + i, to.port}));
    }
    std::array<std::uint8_t, t_to_o_octets> octets{};
    std::array<std::uint8_t, 512> room{};
    iovec part{octets.data(), octets.size()};
    iovec place{room.data(), room.size()};
    std::vector<mmsghdr> out(count);
    for (std::size_t i = 0; i < count; ++i) {
        auto& message = out[i].msg_hdr;
        message.msg_name = &peers[i];
        message.msg_namelen = sizeof peers[i];
        message.msg_iov = &part;
        message.msg_iovlen = 1;
    }
    say("ready");
    std::uint64_t sent = 0;
    std::uint64_t received = 0;
    for (auto next = monotonic() + interval; stopped == 0; next += interval) {
        if (!sleep_until(next)) continue;
        for (const auto& socket : sockets) {
            mmsghdr in{};
            in.msg_hdr.msg_iov = &place;
            in.msg_hdr.msg_iovlen = 1;
            received += ::recvmmsg(socket.number(), &in, 1, MSG_DONTWAIT, nullptr) == 1 ? 1 : 0;
        }
        const auto taken = ::sendmmsg(sockets[0].number(), out.data(), static_cast<unsigned>(count), MSG_DONTWAIT);
        if (taken > 0) sent += static_cast<std::uint64_t>(taken);
    }
    say(fmt::format(R"({{"sent": {}, "received": {}}})", sent, received));
    return 0;
}

int udp_echo(const std::vector<std::string>& words) {
    const auto socket = udp_socket(parse_endpoint(words.at(1)));
    say(std::to_string(local_endpoint(socket).port));
    std::array<std::uint8_t, 2048> octets{};
    while (stopped == 0) {
        sockaddr_in peer{};
        socklen_t size = sizeof peer;
        const auto got =
            ::recvfrom(socket.number(), octets.data(), octets.size(), 0, reinterpret_cast<sockaddr*>(&peer), &size);
        if (got < 0) continue;
        ::sendto(socket.number(), octets.data(), static_cast<std::size_t>(got), 0,
                 reinterpret_cast<const sockaddr*>(&peer), size);
    }
    return 0;
}

int tcp_echo(const std::vector<std::string>& words) {
    const auto listener = tcp_listener(parse_endpoint(words.at(1)));
    say(std::to_string(local_endpoint(listener).port));
    std::array<std::uint8_t, 65536> octets{};
    while (stopped == 0) {
        const auto peer = tcp_accept(listener);
        if (peer.number() < 0) continue;
        for (ssize_t got = 0; (got = ::recv(peer.number(), octets.data(), octets.size(), 0)) > 0;) {
            send_all(peer, std::span(octets).first(static_cast<std::size_t>(got)));
        }
    }
    return 0;
}

/// Single thread, level-triggered: what a server has to do for each request at least.
class BareServer {
public:
    BareServer(enip::Endpoint local, std::size_t request_octets, std::size_t reply_octets)
        : listener_(tcp_listener(local)),
          request_octets_(request_octets),
          reply_(reply_octets),
          poll_(::epoll_create1(0)) {
        watch(listener_.number());
    }

    void run() {
        say(std::to_string(local_endpoint(listener_).port));
        while (stopped == 0) {
            std::array<epoll_event, 64> events{};
            const auto ready = ::epoll_wait(poll_.number(), events.data(), static_cast<int>(events.size()), -1);
            for (int i = 0; i < ready; ++i) {
                const auto number = events[static_cast<std::size_t>(i)].data.fd;
                if (number == listener_.number()) {
                    accept();
                } else {
                    answer(peers_.at(number));
                }
            }
        }
    }

private:
    struct Peer {
        Descriptor socket;
        std::size_t octets = 0;  ///< of a request that is not complete
    };

    void watch(int number) {
        epoll_event event{.events = EPOLLIN, .data = {.fd = number}};
        if (::epoll_ctl(poll_.number(), EPOLL_CTL_ADD, number, &event) != 0) give_up_errno("epoll_ctl");
    }
    void accept() {
        auto socket = tcp_accept(listener_);
        if (socket.number() < 0) return;
        watch(socket.number());
        const auto number = socket.number();
        peers_[number].socket = std::move(socket);
    }
    void answer(Peer& peer) {
        const auto got = ::recv(peer.socket.number(), in_.data(), in_.size(), 0);
        if (got <= 0) {
            peers_.erase(peer.socket.number());
            return;
        }
        peer.octets += static_cast<std::size_t>(got);
        out_.clear();
        for (; peer.octets >= request_octets_; peer.octets -= request_octets_)
            out_.insert(out_.end(), reply_.begin(), reply_.end());
        if (!out_.empty()) send_all(peer.socket, out_);
    }

    Descriptor listener_;
    std::size_t request_octets_;
    std::vector<std::uint8_t> reply_;
    Descriptor poll_;
    std::map<int, Peer> peers_;
    std::array<std::uint8_t, 65536> in_{};
    std::vector<std::uint8_t> out_;
};

int tcp_reply(const std::vector<std::string>& words) {
    BareServer(parse_endpoint(words.at(1)), std::stoul(words.at(2)), std::stoul(words.at(3))).run();
    return 0;
}

int udp_sink(const std::vector<std::string>& words) {
    const auto socket = udp_socket(parse_endpoint(words.at(1)));
    say(std::to_string(local_endpoint(socket).port));
    std::array<std::array<std::uint8_t, 512>, 32> rooms{};
    while (stopped == 0) {
        std::array<iovec, rooms.size()> places;
        std::array<mmsghdr, rooms.size()> messages{};
        for (std::size_t i = 0; i < rooms.size(); ++i) {
            places[i] = {rooms[i].data(), rooms[i].size()};
            messages[i].msg_hdr.msg_iov = &places[i];
            messages[i].msg_hdr.msg_iovlen = 1;
        }
        ::recvmmsg(socket.number(), messages.data(), rooms.size(), MSG_WAITFORONE, nullptr);
    }
    return 0;
}

/// Requests that go out at their times, whether or not those before are answered, up to a window.
class Load {
public:
    Load(enip::Endpoint peer, double rate, std::size_t attributes)
        : client_(peer), attributes_(attributes), requests_per_ns_(rate / static_cast<double>(attributes) / 1e9) {
        const auto request = read_positions(attributes);
        if (!client_.call(request).status.ok()) give_up("the load's request is refused");
        frame_ = client_.frame(request);
        reply_octets_ = client_.exchange(frame_).size();  // The value has a fixed size, and so have all replies.
    }

    void run() {
        const auto begin = monotonic();
        for (auto next = begin; stopped == 0; next += tick) {
            sleep_until(next);
            const auto now = monotonic();
            send(static_cast<std::uint64_t>(static_cast<double>(now - begin) * requests_per_ns_));
            receive();
        }
        say(fmt::format(R"({{"rate": {:.0f}}})", static_cast<double>(received_ / reply_octets_ * attributes_) /
                                                     (static_cast<double>(monotonic() - begin) / 1e9)));
    }

private:
    static constexpr Nanoseconds tick = second / 1000;
    static constexpr std::uint64_t window = 512;

    void send(std::uint64_t due) {
        out_.clear();
        const auto answered = received_ / reply_octets_;
        // What cannot be asked in time is left out: the rate that is reached says so.
        for (; asked_ < due && asked_ - answered < window; ++asked_)
            out_.insert(out_.end(), frame_.begin(), frame_.end());
        send_all(client_.socket(), out_);
    }
    void receive() {
        while (true) {
            const auto got = ::recv(client_.socket().number(), in_.data(), in_.size(), MSG_DONTWAIT);
            if (got == 0) give_up("the load's session was closed");
            if (got < 0) return;
            received_ += static_cast<std::uint64_t>(got);
        }
    }

    ExplicitClient client_;
    std::size_t attributes_;
    double requests_per_ns_;
    cip::Bytes frame_;
    std::uint64_t reply_octets_ = 0;
    std::uint64_t asked_ = 0;
    std::uint64_t received_ = 0;
    cip::Bytes out_;
    std::array<std::uint8_t, 65536> in_{};
};

int load(const std::vector<std::string>& words) {
    Load load({parse_address(words.at(1)), enip::tcp_port}, std::stod(words.at(2)), std::stoul(words.at(3)));
    say("ready");
    load.run();
    return 0;
}

}  // namespace

int play(const std::vector<std::string>& words) {
    stop_at_sigterm();
    const auto& role = words.at(0);
    if (role == "spin") return spin();
    if (role == "sender") return sender(words);
    if (role == "paced-echo") return paced_echo(words);
    if (role == "fleet") return fleet(words);
    if (role == "udp-echo") return udp_echo(words);
    if (role == "tcp-echo") return tcp_echo(words);
    if (role == "tcp-reply") return tcp_reply(words);
    if (role == "udp-sink") return udp_sink(words);
    if (role == "load") return load(words);
    if (role == "originator") return originator_role(words);
    give_up("there is no role " + role);
}

}  // namespace servobus::bench
