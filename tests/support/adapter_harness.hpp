// A whole device without sockets, spoken to in hex:
//
//     AdapterHarness t;
//     t.register_session();
//     EXPECT_EQ(t.call("0E 03 20 64 24 01 30 00"), "8E 00 00 00 14 00 00 00");
//     t.send("04 00 00 00 ...");      // or whole frames
//     EXPECT_EQ(t.reply(), "04 00 1A 00 ...");
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "adapter/adapter.hpp"
#include "adapter/network_settings.hpp"
#include "cip/wire.hpp"
#include "drive/device.hpp"
#include "drive/xenax.hpp"
#include "enip/encapsulation.hpp"
#include "enip/messages.hpp"
#include "enip/target.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {

class AdapterHarness {
public:
    static constexpr std::uint64_t seed = 1;
    // 192.168.2.1 speaks to the device at 192.168.2.100.
    static constexpr enip::Endpoint peer{0xC0A80201, 50000};
    static constexpr enip::Endpoint local{0xC0A80264, enip::tcp_port};
    static constexpr enip::Endpoint io_peer{0xC0A80201, enip::io_port};
    static constexpr enip::Endpoint io_local{0xC0A80264, enip::io_port};

    explicit AdapterHarness(drive::Device device = drive::Device(drive::xenax_models().front()),
                            adapter::Limits limits = {}, adapter::Network network = {}, adapter::DeviceFiles files = {})
        : device_(std::move(device)), adapter_(device_, limits, seed, {}, std::move(network), std::move(files)) {
        connect();
    }

    drive::Device& device() { return device_; }
    adapter::Adapter& adapter() { return adapter_; }
    enip::Time now() const { return now_; }
    std::uint32_t session() const { return session_; }

    /// A new TCP connection takes the place of the one before.
    void connect() {
        if (id_) adapter_.on_closed(*id_, now_);
        session_ = 0;
        waiting_.clear();
        id_ = adapter_.on_open(peer, local, now_);
        EXPECT_TRUE(id_) << "the device takes no connection";
    }

    /// Octets of the TCP stream: any piece of any number of messages.
    void send(cip::ByteView octets) {
        while (id_ && !octets.empty()) {
            const auto taken = adapter_.on_octets(*id_, octets, now_);
            ASSERT_LE(taken, octets.size());
            octets = octets.subspan(taken);
            const auto replies = adapter_.take_replies(*id_);
            waiting_.insert(waiting_.end(), replies.begin(), replies.end());
            if (taken == 0 && replies.empty()) FAIL() << "the device takes nothing and answers nothing";
        }
    }
    void send(std::string_view text) { send(octets(text)); }

    /// Everything that was answered since the last call.
    cip::Bytes take() { return std::exchange(waiting_, {}); }
    std::string reply() { return hex(take()); }

    /// The only frame that was answered since the last call; nullopt when there was none, or something else.
    std::optional<enip::Frame> frame() {
        const auto answer = take();
        const auto frame = enip::Frame::parse(answer);
        if (!frame || frame->encode() != answer) return std::nullopt;
        return *frame;
    }

    void register_session() {
        send(
            enip::Frame{.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()}.encode());
        const auto reply = frame();
        ASSERT_TRUE(reply && reply->status == enip::EncapsulationStatus::success) << "no session";
        session_ = reply->session;
    }

    /// A message router request in the session, as SendRRData; the encoded response, empty when there was none.
    cip::Bytes call(cip::ByteView message) {
        const auto data = enip::SendData::unconnected({message.begin(), message.end()});
        send(enip::Frame{.command = enip::Command::send_rr_data, .session = session_, .data = data.encode()}.encode());
        const auto reply = frame();
        if (!reply || reply->status != enip::EncapsulationStatus::success) return {};
        const auto answer = enip::SendData::parse(reply->data);
        if (!answer) return {};
        const auto response = enip::unconnected_message(*answer);
        return response ? cip::Bytes(response->begin(), response->end()) : cip::Bytes{};
    }
    std::string call(std::string_view text) { return hex(call(octets(text))); }

    /// A datagram at UDP 44818, and the ones that are sent after at most the longest random delay.
    std::vector<enip::Datagram> datagram(cip::ByteView octets, bool broadcast = false) {
        adapter_.on_datagram(peer, local, broadcast, octets, now_);
        if (broadcast) advance(std::chrono::seconds(66));
        return adapter_.take_datagrams();
    }

    /// A datagram at UDP 2222.
    void io(cip::ByteView octets, enip::Endpoint from = io_peer) { adapter_.on_io(from, io_local, octets, now_); }
    void io(std::string_view text) { io(octets(text)); }
    /// The class 1 datagrams that were sent since the last call, each with its route.
    struct Produced {
        enip::IoRoute route;
        cip::Bytes octets;
    };
    std::vector<Produced> produced() {
        std::vector<Produced> all;
        auto& queue = adapter_.io_queue();
        for (const auto& entry : queue.entries()) {
            const auto sent = queue.octets(entry);
            all.push_back({entry.route, {sent.begin(), sent.end()}});
        }
        queue.clear();
        return all;
    }

    /// Lets time pass, from deadline to deadline. A connection that the device ends is gone afterwards.
    void advance(std::chrono::milliseconds duration) {
        const auto end = now_ + duration;
        while (const auto next = adapter_.next_deadline()) {
            if (*next > end) break;
            now_ = std::max(now_, *next);
            adapter_.on_timer(now_);
            close_what_wants_to();
        }
        now_ = end;
        adapter_.on_timer(now_);
        close_what_wants_to();
    }

    /// False once the device has ended the TCP connection.
    bool connected() const { return id_ && !adapter_.wants_close(*id_); }

private:
    void close_what_wants_to() {
        (void)adapter_.take_expired();
        if (!id_ || !adapter_.wants_close(*id_)) return;
        adapter_.on_closed(*id_, now_);
        id_.reset();
        session_ = 0;
    }

    drive::Device device_;
    adapter::Adapter adapter_;
    enip::Time now_{std::chrono::hours(1)};
    std::optional<enip::Target::ConnectionId> id_;
    std::uint32_t session_ = 0;
    cip::Bytes waiting_;
};

}  // namespace servobus::test
