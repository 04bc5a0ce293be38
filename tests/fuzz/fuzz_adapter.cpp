// A TCP stream into a whole device, and its pieces as datagrams of class 1. The first octet chooses the piece size, the
// second how long a piece takes. The session handle and the connection ids of the golden vectors stand for those that are
// open here.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "adapter/adapter.hpp"
#include "cip/forward_open.hpp"
#include "enip/io_packet.hpp"
#include "enip/messages.hpp"
#include "tests/support/everything.hpp"

using namespace servobus;

namespace {

constexpr enip::Endpoint peer{0xC0A80201, 50000};
constexpr enip::Endpoint local{0xC0A80264, enip::tcp_port};
constexpr std::uint32_t example_session = 0x00010203;
constexpr std::uint32_t example_connection = 0x56A0000B;
constexpr std::uint32_t example_owner = 0x56A00001;   // of 101/100
constexpr std::uint32_t example_looker = 0x56A00008;  // with a heartbeat
constexpr enip::Endpoint io_peer{peer.address, enip::io_port};
constexpr enip::Endpoint io_local{local.address, enip::io_port};
constexpr std::size_t longest_io_datagram = 18 + 2 + 40;
constexpr std::size_t most_at_once = 17;  // of one connection, when the timer comes late

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
        connection_ = open_connection("0A00 4D00 44332211 02 000000 80841E00 F443 80841E00 F443 A3 02 20 02 24 01");
        owner_ =
            open_connection("0100 4D00 44332211 00 000000 E8030000 1848 E8030000 1E28 11 04 20 04 24 01 2C 65 2C 64");
        looker_ =
            open_connection("0200 4D00 44332211 00 000000 E8030000 0248 E8030000 1E28 11 04 20 04 24 01 2C FE 2C 64");
    }

    void send(cip::ByteView stream, std::size_t piece_size, std::chrono::milliseconds pause) {
        cip::Bytes octets(stream.begin(), stream.end());
        replace_all(octets);
        auto rest = cip::ByteView(octets);
        while (!rest.empty() && !adapter_.wants_close(id_)) {
            const auto taken = adapter_.on_octets(id_, rest.first(std::min(piece_size, rest.size())), now_);
            const auto replies = adapter_.take_replies(id_);
            test::require(taken > 0 || !replies.empty(), "a device that takes nothing has something to say", stream);
            test::require(replies.size() <= adapter_.limits().queued_bytes + enip::max_data_bytes + enip::header_bytes,
                          "the replies that wait are bounded", stream);
            rest = rest.subspan(taken);
            let_pass(pause, stream);
        }
    }

    /// As datagrams of class 1, which nobody answers.
    void send_io(cip::ByteView stream, std::size_t piece_size, std::chrono::milliseconds pause) {
        cip::Bytes octets(stream.begin(), stream.end());
        replace_all(octets);
        for (auto rest = cip::ByteView(octets); !rest.empty();) {
            const auto piece = rest.first(std::min(piece_size, rest.size()));
            const auto before = adapter_.io().size();
            adapter_.on_io(io_peer, io_local, piece, now_);
            adapter_.on_io({io_peer.address + 1, io_peer.port}, io_local, piece, now_);
            test::require(adapter_.io().size() == before && adapter_.io_queue().empty(),
                          "a datagram opens, closes and answers nothing", stream);
            rest = rest.subspan(piece.size());
            let_pass(pause, stream);
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
    std::uint32_t open_connection(std::string_view rest) {
        const auto request = test::octets("54 02 20 06 24 01 0A 0E 00000000 0A00110A" + std::string(rest));
        const auto reply = ask(enip::Command::send_rr_data, enip::SendData::unconnected(request).encode());
        const auto data = enip::SendData::parse(reply.data);
        const auto response = cip::Response::parse(*enip::unconnected_message(*data));
        test::require(response->status.ok(), "a good connection opens", request);
        return cip::ForwardOpenReply::parse(response->data)->o_to_t_id;
    }

    /// What is produced meanwhile is bounded, and can be read.
    void let_pass(std::chrono::milliseconds pause, cip::ByteView stream) {
        now_ += pause;
        const auto connections = adapter_.io().size();
        adapter_.on_timer(now_);
        (void)adapter_.take_expired();
        test::require(adapter_.io().size() <= 1 + adapter_.limits().listening_connections, "connections are bounded",
                      stream);
        auto& queue = adapter_.io_queue();
        test::require(queue.entries().size() <= connections * most_at_once, "what is made up for is bounded", stream);
        for (const auto& entry : queue.entries()) {
            test::require(entry.size <= longest_io_datagram, "a datagram has its size", stream);
            test::require(enip::IoPacket::parse(queue.octets(entry)).has_value(), "a datagram can be read", stream);
        }
        queue.clear();
        const auto next = adapter_.next_deadline();
        test::require(!next || *next > now_ || adapter_.wants_close(id_), "what was due is done", stream);
    }

    void replace_all(cip::Bytes& octets) const {
        replace(octets, example_session, session_);
        replace(octets, example_connection, connection_);
        replace(octets, example_owner, owner_);
        replace(octets, example_looker, looker_);
    }

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
    std::uint32_t owner_ = 0;
    std::uint32_t looker_ = 0;
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
    device.send_io(stream, data[0] + std::size_t{1}, std::chrono::milliseconds(data[1]) / 16);
    device.send(stream, data[0] + std::size_t{1}, std::chrono::milliseconds(data[1]));
    device.serves_the_next();
    return 0;
}
