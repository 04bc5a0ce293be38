// Class 1 datagrams at both ends: at a device with an owner and one who looks on, and at an originator. The input is a row of
// datagrams, octet by octet or with an id, a sequence number and a size that fit. One of a foreign id or from a foreign
// address changes nothing; every other one is counted once.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "assemblies/connection.hpp"
#include "cip/services.hpp"
#include "cip/wire.hpp"
#include "enip/io_packet.hpp"
#include "scanner/io_plan.hpp"
#include "tests/fuzz/device_site.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/originator_site.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

constexpr std::size_t most_datagrams = 64;

/// The first octet of each datagram.
enum How : std::uint8_t {
    as_it_is = 0x01,  ///< octet by octet
    foreign_id = 0x02,
    from_elsewhere = 0x04,
    to_second = 0x08,  ///< of two connections
    any_sequence = 0x10,
    any_size = 0x20,
    late = 0x40,  ///< time goes on before it
};

void decode(cip::ByteView octets) {
    const auto packet = enip::IoPacket::parse(octets);
    if (!packet) return;
    cip::Bytes head(enip::io_packet_overhead + packet->data.size());
    (void)enip::begin_io_packet(head, packet->connection_id, packet->sequence);
    require(
        std::ranges::equal(cip::ByteView(head).first(enip::io_packet_overhead), octets.first(enip::io_packet_overhead)),
        "the head of a datagram comes out octet by octet", octets);
    require(std::ranges::equal(packet->data, octets.subspan(enip::io_packet_overhead, packet->data.size())),
            "its data stands behind the head", octets);
}

/// Datagrams of one direction, most of which fit.
class Sender {
public:
    Sender(std::uint32_t id, std::size_t size) : id_(id), size_(size) {}

    cip::Bytes next(Input& input, std::uint8_t how) {
        const auto id = (how & foreign_id) != 0 ? input.u32() : id_;
        sequence_ = (how & any_sequence) != 0 ? input.u32() : sequence_ + 1;
        auto data = input.piece();
        if ((how & any_size) == 0) data.resize(size_);
        cip::Bytes datagram(enip::io_packet_overhead + data.size());
        std::ranges::copy(data, enip::begin_io_packet(datagram, id, sequence_).begin());
        return datagram;
    }
    [[nodiscard]] std::uint32_t id() const { return id_; }

private:
    std::uint32_t id_;
    std::size_t size_;
    std::uint32_t sequence_ = 0;
};

std::uint64_t counted(const enip::IoConsumer::Counters& counters) {
    return counters.accepted + counters.stale + counters.wrong_size;
}

// --- the device

class Consumer {
public:
    Consumer()
        : id_(site_.join(0)),
          senders_{open(*assemblies::find_connection(0x65, 0x64), 1),
                   open(*assemblies::find_connection(0xFE, 0x64), 2)} {}

    void hear(Input& input) {
        const auto how = input.u8();
        if ((how & late) != 0) site_.advance(std::chrono::milliseconds(input.u8()));
        const auto datagram =
            (how & as_it_is) != 0 ? input.piece() : senders_[(how & to_second) != 0 ? 1 : 0].next(input, how);
        decode(datagram);
        const auto packet = enip::IoPacket::parse(datagram);
        const bool ours = packet && is_open(packet->connection_id) && (how & from_elsewhere) == 0;
        const auto before = arrivals();
        const auto strays = all_strays();
        const auto outputs = ours ? cip::Bytes{} : outputs_now();
        site_.send_io(datagram, (how & from_elsewhere) != 0 ? 1 : 0);
        const auto counted_now = arrivals() - before + all_strays() - strays;
        require(counted_now == 1, "every datagram is counted once", datagram);
        if (ours) return;
        require(arrivals() == before, "no connection counts what is not its own", datagram);
        require(outputs_now() == outputs, "what is foreign changes nothing", datagram);
    }
    void leave() { site_.leave(); }

private:
    Sender open(const assemblies::Connection& kind, std::uint16_t serial) {
        auto plan = scanner::plan_of(kind);
        const auto request =
            scanner::open_request(plan.forward_open(0, 0x33000000U + serial, {serial, 0x004D, 0x11223344})).encode();
        const auto response = site_.call(id_, request);
        require(response->status.ok(), "a good connection opens", request);
        return {cip::ForwardOpenReply::parse(response->data)->o_to_t_id, plan.o_to_t.connection_size()};
    }
    [[nodiscard]] bool is_open(std::uint32_t id) {
        return std::ranges::any_of(site_.adapter().io().all(),
                                   [&](const auto& connection) { return connection->o_to_t_id == id; });
    }
    [[nodiscard]] std::uint64_t arrivals() {
        std::uint64_t sum = 0;
        for (const auto& connection : site_.adapter().io().all()) sum += counted(connection->consumer.counters());
        return sum;
    }
    [[nodiscard]] std::uint64_t all_strays() {
        const auto& strays = site_.adapter().io().strays();
        return strays.malformed + strays.unknown_id + strays.wrong_source + strays.too_late;
    }
    [[nodiscard]] cip::Bytes outputs_now() {
        return site_
            .call(id_, cip::Request{cip::service::get_attribute_single, cip::Path::to(0x04, 0x65, 3), {}}.encode())
            ->encode();
    }

    DeviceSite site_;
    DeviceSite::Id id_;
    std::array<Sender, 2> senders_;
};

void hear_at_device(Input& input) {
    Consumer device;
    for (std::size_t count = 0; count < most_datagrams && !input.over(); ++count) device.hear(input);
    device.leave();
}

// --- the originator

void hear_at_originator(Input& input) {
    const auto plan = scanner::plan_of(*assemblies::find_connection("standard"));
    OriginatorSite site(plan);
    site.begin();
    const auto open = cip::ForwardOpen::parse(site.asked.front().request.data, false).value();
    const cip::ForwardOpenReply reply{0x56A00001, open.t_to_o_id, open.triad, open.o_to_t_rpi, open.t_to_o_rpi, {}};
    site.answer({site.asked.front().request.service, {}, reply.encode()});
    require(site.session.state() == scanner::IoState::open, "a good reply opens");
    Sender sender(open.t_to_o_id, plan.t_to_o.connection_size());
    for (std::size_t count = 0; count < most_datagrams && !input.over(); ++count) {
        const auto how = input.u8();
        if ((how & late) != 0) site.advance(std::chrono::milliseconds(input.u8()));
        if (site.session.state() != scanner::IoState::open) break;
        const auto datagram = (how & as_it_is) != 0 ? input.piece() : sender.next(input, how);
        decode(datagram);
        const auto packet = enip::IoPacket::parse(datagram);
        // Whoever owns the socket gives a session only what carries its id.
        if (!packet || packet->connection_id != sender.id()) continue;
        const auto before = counted(site.session.received());
        const auto inputs = site.sizes.size();
        const auto reception = site.receive(datagram, *packet, (how & from_elsewhere) == 0);
        const bool taken = reception == scanner::IoSession::Reception::taken;
        require(taken == ((how & from_elsewhere) == 0), "what comes from elsewhere is not taken", datagram);
        require(counted(site.session.received()) == before + (taken ? 1 : 0), "what is taken is counted once",
                datagram);
        require(site.sizes.size() <= inputs + 1, "one datagram is one input", datagram);
    }
    for (const auto size : site.sizes) require(size == plan.t_to_o.data_octets, "an input has its size");
}

}  // namespace

void io_packet(cip::ByteView octets) {
    decode(octets);
    Input input(octets);
    if ((input.u8() & 1U) == 0) {
        hear_at_device(input);
    } else {
        hear_at_originator(input);
    }
}

}  // namespace servobus::fuzz
