// A TCP stream into a whole device. The first octet chooses the piece size, the second how long a piece takes. The
// session handle and the connection id of the golden vectors stand for those that are open here.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "adapter/adapter.hpp"
#include "cip/forward_open.hpp"
#include "enip/messages.hpp"
#include "tests/support/everything.hpp"

using namespace servobus;

namespace {

constexpr enip::Endpoint peer{0xC0A80201, 50000};
constexpr enip::Endpoint local{0xC0A80264, enip::tcp_port};
constexpr std::uint32_t example_session = 0x00010203;
constexpr std::uint32_t example_connection = 0x56A0000B;

/// A device with one TCP connection.
class Peer {
public:
    explicit Peer(adapter::Limits limits) : adapter_(device_, limits, 1) {
        id_ = adapter_.on_open(peer, local, now_).value();
    }

    /// One frame and its answer, with the session.
    enip::Frame ask(enip::Command command, cip::Bytes data) {
        const auto octets = enip::Frame{.command = command, .session = session_, .data = std::move(data)}.encode();
        test::require(adapter_.on_octets(id_, octets, now_) == octets.size(), "a frame is taken", octets);
        const auto reply = enip::Frame::parse(adapter_.take_replies(id_));
        test::require(reply && reply->status == enip::EncapsulationStatus::success, "a good request is answered",
                      octets);
        return *reply;
    }

    void open() {
        session_ = ask(enip::Command::register_session, enip::RegisterSession{}.encode()).session;
        static const auto forward_open = test::octets(
            "54 02 20 06 24 01 0A 0E 00000000 0A00110A 0A00 4D00 44332211 02 000000 80841E00 F443 80841E00 F443 A3"
            "02 20 02 24 01");
        const auto reply = ask(enip::Command::send_rr_data, enip::SendData::unconnected(forward_open).encode());
        const auto data = enip::SendData::parse(reply.data);
        const auto response = cip::Response::parse(*enip::unconnected_message(*data));
        connection_ = cip::ForwardOpenReply::parse(response->data)->o_to_t_id;
    }

    void send(cip::ByteView stream, std::size_t piece_size, std::chrono::milliseconds pause) {
        cip::Bytes octets(stream.begin(), stream.end());
        replace(octets, example_session, session_);
        replace(octets, example_connection, connection_);
        auto rest = cip::ByteView(octets);
        while (!rest.empty() && !adapter_.wants_close(id_)) {
            const auto taken = adapter_.on_octets(id_, rest.first(std::min(piece_size, rest.size())), now_);
            const auto replies = adapter_.take_replies(id_);
            test::require(taken > 0 || !replies.empty(), "a device that takes nothing has something to say", stream);
            test::require(replies.size() <= adapter_.limits().queued_bytes + enip::max_data_bytes + enip::header_bytes,
                          "the replies that wait are bounded", stream);
            rest = rest.subspan(taken);
            now_ += pause;
            adapter_.on_timer(now_);
            (void)adapter_.take_expired();
        }
    }

    /// As a datagram, too.
    void send_datagram(cip::ByteView octets) {
        adapter_.on_datagram(peer, local, false, octets, now_);
        test::require(adapter_.take_datagrams().size() <= 1, "a datagram has one answer", octets);
        adapter_.on_datagram(peer, local, true, octets, now_);
        test::require(adapter_.take_datagrams().size() <= 1, "a broadcast has one answer", octets);
    }

    /// Whatever happened, a newcomer is served.
    void serves_the_next() {
        adapter_.on_closed(id_, now_);
        test::require(adapter_.sessions() == 0 && adapter_.class3_connections() == 0, "nothing is left open");
        id_ = adapter_.on_open(peer, local, now_).value();
        session_ = 0;
        session_ = ask(enip::Command::register_session, enip::RegisterSession{}.encode()).session;
        const auto get = test::octets("0E 03 20 01 24 01 30 01");
        (void)ask(enip::Command::send_rr_data, enip::SendData::unconnected(get).encode());
    }

private:
    static void replace(cip::Bytes& octets, std::uint32_t example, std::uint32_t own) {
        for (std::size_t i = 0; i + 4 <= octets.size(); ++i) {
            if (cip::Reader(cip::ByteView(octets).subspan(i, 4)).u32() != example) continue;
            for (std::size_t k = 0; k < 4; ++k) octets[i + k] = static_cast<std::uint8_t>(own >> (8 * k));
        }
    }

    drive::Device device_{drive::xenax_models().front()};
    adapter::Adapter adapter_;
    enip::Time now_{std::chrono::hours(1)};
    enip::Target::ConnectionId id_ = 0;
    std::uint32_t session_ = 0;
    std::uint32_t connection_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    const cip::ByteView stream(data + 2, size - 2);
    adapter::Limits limits;
    limits.queued_bytes = 2000;  // few, so that they are reached
    Peer device(limits);
    device.open();
    device.send_datagram(stream);
    device.send(stream, data[0] + std::size_t{1}, std::chrono::milliseconds(data[1]));
    device.serves_the_next();
    return 0;
}
