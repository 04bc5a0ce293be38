// One device without sockets and any number of peers. Rules about foreign sessions, limits and lost connections need
// more than the one connection of AdapterHarness.
//
//     Site site;
//     Peer peer(site);
//     peer.register_session();
//     EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
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
#include "cip/forward_open.hpp"
#include "cip/wire.hpp"
#include "drive/device.hpp"
#include "drive/xenax.hpp"
#include "enip/messages.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {

using namespace std::chrono_literals;

/// The device, its clock and what it logs.
struct Site {
    static constexpr enip::Endpoint local{0xC0A80264, enip::tcp_port};  // 192.168.2.100

    explicit Site(adapter::Limits limits = {}, drive::Device drive = drive::Device(drive::xenax_models().front()),
                  std::uint64_t seed = 1, adapter::DeviceFiles files = {})
        : device(std::move(drive)),
          adapter(
              device, limits, seed, [this](adapter::LogLevel, std::string_view line) { log.emplace_back(line); }, {},
              std::move(files)) {}
    explicit Site(adapter::DeviceFiles files, adapter::Limits limits = {})
        : Site(limits, drive::Device(drive::xenax_models().front()), 1, std::move(files)) {}

    /// Lets time pass, from deadline to deadline, as the server does.
    void advance(std::chrono::milliseconds duration) {
        const auto end = now + duration;
        for (auto next = adapter.next_deadline(); next && *next <= end; next = adapter.next_deadline()) {
            now = std::max(now, *next);
            adapter.on_timer(now);
            for (const auto id : adapter.take_expired()) expired.push_back(id);
            ASSERT_TRUE(adapter.next_deadline() != next) << "a deadline that has passed stays";
        }
        now = end;
    }

    /// Sends a datagram; the replies that are due at once, in hex.
    std::vector<std::string> datagram(std::string_view text, bool broadcast = false) {
        adapter.on_datagram({0xC0A80201, 4000}, local, broadcast, octets(text), now);
        return datagrams();
    }
    std::vector<std::string> datagrams() {
        std::vector<std::string> list;
        for (const auto& datagram : adapter.take_datagrams()) {
            EXPECT_EQ(datagram.peer, (enip::Endpoint{0xC0A80201, 4000}));
            EXPECT_EQ(datagram.local, local);
            list.push_back(hex(datagram.octets));
        }
        return list;
    }

    drive::Device device;
    std::vector<std::string> log;
    enip::Time now{1h};
    std::vector<enip::Target::ConnectionId> expired;
    adapter::Adapter adapter;
};

inline constexpr std::string_view no_session = "00 00 00 00";
inline constexpr std::string_view own_session = "{S}";
inline constexpr std::string_view context = "A1 A2 A3 A4 A5 A6 A7 A8";

/// A frame in hex, its length counted: `frame("6F 00", own_session, "00 00 ...")`.
struct FrameText {
    std::string_view command;
    std::string_view session = no_session;
    std::string data{};
    std::string_view status = "00 00 00 00";
    std::string_view options = "00 00 00 00";

    std::string text() const {
        const auto count = octets(data).size();
        return fmt::format("{} {:02X} {:02X} {} {} {} {} {}", command, count & 0xFF, count >> 8, session, status,
                           context, options, data);
    }
};

inline std::string frame(std::string_view command, std::string_view session = no_session, std::string data = "") {
    return FrameText{.command = command, .session = session, .data = std::move(data)}.text();
}
/// A frame that reports an error, with nothing in it.
inline std::string failure(std::string_view command, std::string_view session, std::string_view status) {
    return FrameText{.command = command, .session = session, .status = status}.text();
}

/// One TCP connection. In all texts `{S}` is its session handle.
class Peer {
public:
    explicit Peer(Site& site, std::uint32_t address = 0xC0A80201)
        : site_(&site), address_(address), id_(site.adapter.on_open({address, 50000}, Site::local, site.now)) {}
    ~Peer() { close(); }
    Peer(Peer&& other) noexcept
        : site_(other.site_),
          address_(other.address_),
          id_(std::exchange(other.id_, std::nullopt)),
          session_(other.session_),
          connection_(other.connection_) {}
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;
    Peer& operator=(Peer&&) = delete;

    bool accepted() const { return id_.has_value(); }
    /// Whether the device keeps the connection.
    bool open() const { return id_ && !site_->adapter.wants_close(*id_); }
    enip::Target::ConnectionId id() const { return id_.value_or(0); }
    std::uint32_t session() const { return session_; }
    std::uint32_t connection() const { return connection_; }

    void close() {
        if (id_) site_->adapter.on_closed(*std::exchange(id_, std::nullopt), site_->now);
    }

    /// The text with the session handle in it, as hex() writes it.
    std::string text(std::string text) const {
        const auto handle = fmt::format("{:02X} {:02X} {:02X} {:02X}", session_ & 0xFF, session_ >> 8 & 0xFF,
                                        session_ >> 16 & 0xFF, session_ >> 24);
        for (auto at = text.find(own_session); at != std::string::npos; at = text.find(own_session)) {
            text.replace(at, own_session.size(), handle);
        }
        return hex(text);
    }

    /// Sends octets and takes all replies.
    cip::Bytes exchange(cip::ByteView octets) {
        cip::Bytes replies;
        while (id_ && !octets.empty()) {
            const auto taken = site_->adapter.on_octets(*id_, octets, site_->now);
            octets = octets.subspan(taken);
            const auto batch = site_->adapter.take_replies(*id_);
            replies.insert(replies.end(), batch.begin(), batch.end());
            if (taken == 0 && batch.empty()) break;
        }
        return replies;
    }
    std::string send(const std::string& text) { return hex(exchange(octets(this->text(text)))); }

    void register_session() {
        const auto reply = enip::Frame::parse(exchange(octets(frame("65 00", no_session, "01 00 00 00"))));
        ASSERT_TRUE(reply && reply->status == enip::EncapsulationStatus::success);
        session_ = reply->session;
    }

    /// A message router request by SendRRData: its reply, or `encapsulation status 0x0064`, or nothing.
    std::string call(cip::ByteView message) {
        const auto data = enip::SendData::unconnected({message.begin(), message.end()}).encode();
        const auto answer = round_trip(enip::Command::send_rr_data, data);
        if (!answer) return "";
        if (answer->status != enip::EncapsulationStatus::success) return complaint(*answer);
        const auto reply = enip::SendData::parse(answer->data);
        const auto inner = reply ? enip::unconnected_message(*reply) : cip::DecodeError::truncated;
        return inner ? hex(*inner) : "no message in the reply";
    }
    std::string call(std::string_view message) { return call(octets(message)); }

    /// The same by SendUnitData on the class 3 connection that open_class3() has opened; "" when nothing is answered.
    std::string connected_call(std::uint16_t sequence, std::string_view message) {
        return connected_call(connection_, sequence, message);
    }
    std::string connected_call(std::uint32_t connection, std::uint16_t sequence, std::string_view message) {
        const auto data = enip::SendData::connected(connection, sequence, octets(message)).encode();
        const auto answer = round_trip(enip::Command::send_unit_data, data);
        if (!answer) return "";
        if (answer->status != enip::EncapsulationStatus::success) return complaint(*answer);
        const auto reply = enip::SendData::parse(answer->data);
        if (!reply) return "no message in the reply";
        const auto inner = enip::connected_message(*reply);
        if (!inner || inner->sequence != sequence || inner->connection_id != t_to_o_id)
            return "another connection's reply";
        return hex(inner->message);
    }

    /// Opens a class 3 connection with this serial number; 1 s without a request and it times out, the first 10 s aside.
    void open_class3(std::uint16_t serial_number = 1) {
        const auto message = cip::Request{0x54, cip::Path::to(6, 1), class3_open(serial_number).encode()}.encode();
        const auto reply = octets(call(message));
        ASSERT_GE(reply.size(), 8U);
        ASSERT_EQ(reply[2], 0) << hex(reply);
        cip::Reader reader(cip::ByteView(reply).subspan(4));
        connection_ = reader.u32();
    }

    static constexpr std::uint32_t t_to_o_id = 0x80FE0001;

    static cip::ForwardOpen class3_open(std::uint16_t serial_number) {
        cip::ForwardOpen open;
        open.t_to_o_id = t_to_o_id;
        open.triad = {serial_number, 0x004D, 0x11223344};
        open.o_to_t_rpi = open.t_to_o_rpi = 250'000;
        open.o_to_t.size = open.t_to_o.size = 504;
        open.transport = {true, 2, 3};
        open.path = octets("20 02 24 01");
        return open;
    }

private:
    std::optional<enip::Frame> round_trip(enip::Command command, cip::Bytes data) {
        const auto answer =
            exchange(enip::Frame{.command = command, .session = session_, .data = std::move(data)}.encode());
        if (answer.empty()) return std::nullopt;
        const auto reply = enip::Frame::parse(answer);
        EXPECT_TRUE(reply && reply->encode() == answer) << "not one frame: " << hex(answer);
        if (!reply) return std::nullopt;
        return *reply;
    }
    static std::string complaint(const enip::Frame& reply) {
        EXPECT_TRUE(reply.data.empty());
        return fmt::format("encapsulation status 0x{:04X}", static_cast<std::uint32_t>(reply.status));
    }

    Site* site_;
    std::uint32_t address_;
    std::optional<enip::Target::ConnectionId> id_;
    std::uint32_t session_ = 0;
    std::uint32_t connection_ = 0;
};

/// A peer with a session.
inline Peer registered(Site& site, std::uint32_t address = 0xC0A80201) {
    Peer peer(site, address);
    peer.register_session();
    return peer;
}

}  // namespace servobus::test
