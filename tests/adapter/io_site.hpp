// One device and any number of originators of class 1 connections, without sockets and in virtual time.
//
//     IoSite site;
//     IoPeer peer(site);
//     const auto link = peer.must_open(owner_open(1, 101));
//     peer.send(link, o_to_t(link, 1, 1, run, data));
//     site.advance(10ms);
//     EXPECT_EQ(hex(site.sent.back().octets), ...);
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "adapter/adapter.hpp"
#include "cip/connection_data.hpp"
#include "cip/forward_open.hpp"
#include "cip/unconnected_send.hpp"
#include "cip/wire.hpp"
#include "drive/device.hpp"
#include "drive/lookup.hpp"
#include "drive/xenax.hpp"
#include "enip/messages.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {

using namespace std::chrono_literals;
using cip::ConnectionType;
using std::chrono::microseconds;

/// The device, its clock, what it logs, and what it has produced.
class IoSite {
public:
    static constexpr std::uint32_t address = 0xC0A80264;  // 192.168.2.100

    struct Sent {
        enip::Time at;
        enip::IoRoute route;
        cip::Bytes octets;
    };
    struct Line {
        adapter::LogLevel level;
        std::string text;
    };

    explicit IoSite(drive::Device drive = drive::Device(drive::xenax_models().front()), adapter::Limits limits = {},
                    adapter::Network network = in_subnet(24), std::uint64_t seed = 1)
        : device(std::move(drive)),
          adapter(
              device, limits, seed,
              [this](adapter::LogLevel level, std::string_view line) {
                  log.push_back({level, std::string(line)});
              },
              std::move(network)) {
        adapter.on_timer(now);
    }

    static adapter::Network in_subnet(unsigned bits) {
        adapter::Network network;
        network.state.interface.address = address;
        network.state.interface.mask = bits == 0 ? 0 : 0xFFFFFFFFU << (32 - bits);
        return network;
    }

    /// Lets time pass, from deadline to deadline, as the server does.
    void advance(microseconds duration) {
        const auto end = now + duration;
        for (auto next = adapter.next_deadline(); next && *next <= end; next = adapter.next_deadline()) {
            now = std::max(now, *next);
            tick();
            ASSERT_NE(adapter.next_deadline(), next) << "a deadline that has passed stays";
        }
        now = end;
    }
    /// The timer, whatever is due.
    void tick() {
        adapter.on_timer(now);
        collect();
        (void)adapter.take_expired();
    }
    void collect() {
        auto& queue = adapter.io_queue();
        for (const auto& entry : queue.entries()) {
            const auto octets = queue.octets(entry);
            sent.push_back({now, entry.route, {octets.begin(), octets.end()}});
        }
        queue.clear();
    }
    std::vector<Sent> take() { return std::exchange(sent, {}); }

    std::int64_t value(std::string_view name) {
        const auto rows = drive::find_by_name(device.store().table(), drive::parameter_classes(), name);
        EXPECT_EQ(rows.size(), 1U) << name;
        return std::get<std::int64_t>(device.store().value(*rows.front()));
    }
    std::uint16_t counter(adapter::Counter which) const { return adapter.connection_manager().counter(which); }
    std::string last_line(adapter::LogLevel level) const {
        for (auto line = log.rbegin(); line != log.rend(); ++line) {
            if (line->level == level) return line->text;
        }
        return "";
    }
    std::string last_warning() const { return last_line(adapter::LogLevel::warning); }

    drive::Device device;
    std::vector<Line> log;
    std::vector<Sent> sent;
    enip::Time now{1h};
    adapter::Adapter adapter;
};

/// Octets of a connection by R-CON-9, written down once more so that they are compared with something.
struct Points {
    std::uint16_t o_to_t;
    std::uint16_t t_to_o;
    std::uint16_t o_to_t_size;
    std::uint16_t t_to_o_size;
};
inline constexpr std::array<Points, 11> all_points{{{101, 100, 24, 30},
                                                    {102, 100, 26, 30},
                                                    {103, 100, 38, 30},
                                                    {104, 105, 42, 34},
                                                    {112, 113, 54, 42},
                                                    {254, 100, 2, 30},
                                                    {254, 105, 2, 34},
                                                    {254, 113, 2, 42},
                                                    {255, 100, 2, 30},
                                                    {255, 105, 2, 34},
                                                    {255, 113, 2, 42}}};
inline constexpr std::array<std::uint16_t, 5> owner_points{101, 102, 103, 104, 112};
inline const Points& points_of(std::uint16_t o_to_t, std::uint16_t t_to_o = 0) {
    return *std::ranges::find_if(
        all_points, [&](const auto& each) { return each.o_to_t == o_to_t && (t_to_o == 0 || each.t_to_o == t_to_o); });
}

inline constexpr std::string_view own_key = "34 04 6D05 2B00 0975 81 01";

/// Point-to-point, 10 ms both ways, multiplier 4, cyclic, with key and configuration point.
inline cip::ForwardOpen io_open(std::uint16_t serial, std::uint16_t o_to_t = 101, std::uint16_t t_to_o = 0) {
    const auto& points = points_of(o_to_t, t_to_o);
    cip::ForwardOpen open;
    open.triad = {serial, 0x004D, 0x11223344};
    open.t_to_o_id = 0x0A110000U | serial;
    open.o_to_t_rpi = open.t_to_o_rpi = 10'000;
    open.o_to_t = {.priority = cip::Priority::scheduled, .size = points.o_to_t_size};
    open.t_to_o = {.priority = cip::Priority::scheduled, .size = points.t_to_o_size};
    open.transport = {.transport_class = 1};
    open.path = octets(fmt::format("{} 20 04 24 01 2C {:02X} 2C {:02X}", own_key, points.o_to_t, points.t_to_o));
    return open;
}
inline cip::ForwardOpen multicast(cip::ForwardOpen open) {
    open.t_to_o.type = ConnectionType::multicast;
    return open;
}
inline cip::ForwardOpen every(cip::ForwardOpen open, std::uint32_t interval) {
    open.o_to_t_rpi = open.t_to_o_rpi = interval;
    return open;
}
/// Change of state, with the production inhibit time given in ms, or none at all.
inline cip::ForwardOpen on_change(cip::ForwardOpen open, std::optional<unsigned> inhibit = {},
                                  std::uint8_t trigger = 1) {
    open.transport.trigger = trigger;
    if (inhibit) {
        const auto segment = octets(fmt::format("43 {:02X}", *inhibit));
        open.path.insert(open.path.begin() + 10, segment.begin(), segment.end());
    }
    return open;
}

inline cip::Bytes request_of(const cip::ForwardOpen& open) {
    const std::uint8_t service = open.large ? 0x5B : 0x54;
    return cip::Request{service, cip::Path::to(6, 1), open.encode()}.encode();
}
inline cip::Bytes through_unconnected_send(const cip::Bytes& message, std::string_view route = "01 00") {
    cip::UnconnectedSend send;
    send.message = message;
    send.route_path = octets(route);
    return cip::Request{0x52, cip::Path::to(6, 1), send.encode()}.encode();
}

inline enip::Item socket_item(enip::ItemType type, std::uint16_t port, std::uint32_t address = 0) {
    return {type, enip::SocketAddress{.port = port, .address = address}.encode()};
}

/// An open connection as its originator knows it.
struct Link {
    cip::ForwardOpen request;
    cip::ForwardOpenReply reply;
    std::vector<enip::Item> items;  ///< of the reply

    [[nodiscard]] std::optional<enip::SocketAddress> socket(enip::ItemType type) const {
        for (const auto& item : items) {
            if (item.type != type) continue;
            const auto address = enip::SocketAddress::parse(item.data);
            if (address) return *address;
        }
        return std::nullopt;
    }
};

inline constexpr std::uint32_t run = 1;
inline constexpr std::uint32_t idle = 0;

/// A datagram of an owner: 32-bit header and data (R-IO-1).
inline cip::Bytes o_to_t(const Link& link, std::uint32_t sequence, std::uint16_t count, std::uint32_t header,
                         const cip::Bytes& data) {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    writer.u16(2);
    writer.u16(0x8002);
    writer.u16(8);
    writer.u32(link.reply.o_to_t_id);
    writer.u32(sequence);
    writer.u16(0x00B1);
    writer.u16(static_cast<std::uint16_t>(6 + data.size()));
    writer.u16(count);
    writer.u32(header);
    writer.bytes(data);
    return bytes;
}
/// R-IO-3.
inline cip::Bytes heartbeat(const Link& link, std::uint32_t sequence, std::uint16_t count = 1) {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    writer.u16(2);
    writer.u16(0x8002);
    writer.u16(8);
    writer.u32(link.reply.o_to_t_id);
    writer.u32(sequence);
    writer.u16(0x00B1);
    writer.u16(2);
    writer.u16(count);
    return bytes;
}

/// Of a datagram that the device has sent.
inline std::uint32_t id_in(const cip::Bytes& datagram) { return cip::Reader(cip::ByteView(datagram).subspan(6)).u32(); }
inline std::uint32_t sequence_in(const cip::Bytes& datagram) {
    return cip::Reader(cip::ByteView(datagram).subspan(10)).u32();
}
inline std::uint16_t count_in(const cip::Bytes& datagram) {
    return cip::Reader(cip::ByteView(datagram).subspan(18)).u16();
}
inline std::string data_in(const cip::Bytes& datagram) { return hex(cip::ByteView(datagram).subspan(20)); }

/// An originator with a session at the device.
class IoPeer {
public:
    static constexpr std::uint32_t usual_address = 0xC0A80201;  // 192.168.2.1

    explicit IoPeer(IoSite& site, std::uint32_t address = usual_address) : site_(&site), address_(address) {
        connect();
    }

    void connect() {
        id_ = site_->adapter.on_open({address_, 50'000}, {IoSite::address, enip::tcp_port}, site_->now);
        ASSERT_TRUE(id_);
        const auto reply =
            exchange({.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()});
        ASSERT_TRUE(reply && reply->status == enip::EncapsulationStatus::success);
        session_ = reply->session;
    }
    void disconnect() {
        if (id_) site_->adapter.on_closed(*id_, site_->now);
        id_.reset();
    }
    [[nodiscard]] std::uint32_t address() const { return address_; }

    struct Answer {
        cip::Bytes message;
        std::vector<enip::Item> items;
    };
    Answer ask(const cip::Bytes& message, const std::vector<enip::Item>& items = {}) {
        auto data = enip::SendData::unconnected(message);
        data.packet.items.insert(data.packet.items.end(), items.begin(), items.end());
        const auto reply =
            exchange({.command = enip::Command::send_rr_data, .session = session_, .data = data.encode()});
        if (!reply) return {};
        const auto answer = enip::SendData::parse(reply->data);
        if (!answer || answer->packet.items.size() < 2) return {};
        return {answer->packet.items[1].data, {answer->packet.items.begin() + 2, answer->packet.items.end()}};
    }
    std::string call(const cip::Bytes& message, const std::vector<enip::Item>& items = {}) {
        return hex(ask(message, items).message);
    }
    std::string call(std::string_view text) { return call(octets(text)); }

    std::optional<Link> open(const cip::ForwardOpen& wanted, const std::vector<enip::Item>& items = {}) {
        auto answer = ask(request_of(wanted), items);
        const auto response = cip::Response::parse(answer.message);
        if (!response || !response->status.ok()) return std::nullopt;
        const auto reply = cip::ForwardOpenReply::parse(response->data);
        if (!reply) return std::nullopt;
        return Link{wanted, *reply, std::move(answer.items)};
    }
    Link must_open(const cip::ForwardOpen& wanted, const std::vector<enip::Item>& items = {}) {
        auto link = open(wanted, items);
        EXPECT_TRUE(link) << site_->last_warning();
        return link ? *std::move(link) : Link{wanted, {}, {}};
    }
    /// General status and extended words in hex, without the triad: "01 01 06 01".
    std::string refusal(const cip::ForwardOpen& wanted, const std::vector<enip::Item>& items = {}) {
        const auto answer = ask(request_of(wanted), items).message;
        if (answer.size() < 4) return "no answer";
        return hex(cip::ByteView(answer).subspan(2, std::min<std::size_t>(2 + 2U * answer[3], answer.size() - 2)));
    }
    std::string close(const cip::ConnectionTriad& triad) {
        cip::ForwardClose close;
        close.triad = triad;
        return call(cip::Request{0x4E, cip::Path::to(6, 1), close.encode()}.encode());
    }
    std::string close(const Link& link) { return close(link.request.triad); }

    /// A datagram to the device's port 2222, from this originator's address.
    void send(cip::ByteView datagram, std::uint16_t from_port = enip::io_port) {
        site_->adapter.on_io({address_, from_port}, {IoSite::address, enip::io_port}, datagram, site_->now);
        site_->collect();
    }

private:
    std::optional<enip::Frame> exchange(const enip::Frame& request) {
        if (!id_) return std::nullopt;
        cip::Bytes encoded = request.encode();
        auto rest = cip::ByteView(encoded);
        cip::Bytes replies;
        while (!rest.empty()) {
            const auto taken = site_->adapter.on_octets(*id_, rest, site_->now);
            const auto part = site_->adapter.take_replies(*id_);
            replies.insert(replies.end(), part.begin(), part.end());
            if (taken == 0 && part.empty()) return std::nullopt;
            rest = rest.subspan(taken);
        }
        site_->collect();
        const auto reply = enip::Frame::parse(replies);
        if (!reply) return std::nullopt;
        return *reply;
    }

    IoSite* site_;
    std::uint32_t address_;
    std::optional<enip::Target::ConnectionId> id_;
    std::uint32_t session_ = 0;
};

inline std::string closed(const cip::ConnectionTriad& triad) {
    return hex(cip::Response{0x4E, {}, cip::ForwardCloseReply{triad, {}}.encode()}.encode());
}

}  // namespace servobus::test
