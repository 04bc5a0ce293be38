// Each golden vector cut at each length, and with each octet changed, through every decoder and through a whole device.
// Nobody may crash, assert or answer more than is reasonable, and the device answers a good request afterwards.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "cip/forward_open.hpp"
#include "enip/common_packet.hpp"
#include "enip/frame_decoder.hpp"
#include "enip/messages.hpp"
#include "tests/support/adapter_harness.hpp"
#include "tests/support/everything.hpp"
#include "tests/support/golden.hpp"

namespace servobus {
namespace {

using cip::Bytes;
using cip::ByteView;
using test::AdapterHarness;
using test::golden_vectors;
using test::GoldenVector;

/// What an octet is changed into: each bit turned, and the two values at which counts and lengths go wrong.
std::vector<std::uint8_t> changes_of(std::uint8_t octet) {
    std::vector<std::uint8_t> changes;
    for (unsigned bit = 0; bit < 8; ++bit) changes.push_back(static_cast<std::uint8_t>(octet ^ (1U << bit)));
    for (const auto value : {std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
        if (value != octet && std::ranges::count(changes, value) == 0) changes.push_back(value);
    }
    return changes;
}

/// Calls `act(octets)` for the vector cut at each length and changed at each place.
template <class Act>
unsigned for_each_mutation(ByteView whole, Act act) {
    unsigned mutations = 0;
    for (std::size_t length = 0; length < whole.size(); ++length, ++mutations) act(whole.first(length));
    Bytes changed(whole.begin(), whole.end());
    for (std::size_t i = 0; i < whole.size(); ++i) {
        for (const auto value : changes_of(whole[i])) {
            changed[i] = value;
            act(ByteView(changed));
            ++mutations;
        }
        changed[i] = whole[i];
    }
    return mutations;
}

/// The octets of a vector from the layer on that each kind of decoder is for.
std::vector<Bytes> layers(const GoldenVector& vector) {
    std::vector<Bytes> layers{vector.octets};
    if (vector.transport == "eth" || vector.is_io_datagram()) return layers;
    const auto frame = enip::Frame::parse(vector.octets);
    if (!frame || frame->data.empty()) return layers;
    layers.push_back(frame->data);
    const auto data = enip::SendData::parse(frame->data);
    if (!data) return layers;
    for (const auto& item : data->packet.items) {
        if (item.data.size() < 4) continue;
        layers.push_back(item.data);
        // What follows a request's path or a response's status is a message of its own.
        const auto view = cip::RequestView::parse(item.data);
        const auto response = cip::Response::parse(item.data);
        if (response && response->data.size() > 4) {
            layers.push_back(response->data);
        } else if (view && view->data.size() > 4) {
            layers.push_back(Bytes(view->data.begin(), view->data.end()));
        }
    }
    return layers;
}

TEST(Mutation, every_decoder_survives_every_golden_vector) {
    unsigned mutations = 0;
    for (const auto& vector : golden_vectors()) {
        for (const auto& layer : layers(vector)) mutations += for_each_mutation(layer, test::decode_everything);
    }
    EXPECT_GT(mutations, 200'000U);
}

TEST(Mutation, the_frame_decoder_keeps_its_place) {
    // Two headers without data always end a message, as far as the changed one does not ask for more.
    const auto follower = enip::Frame{.command = enip::Command::list_services}.encode();
    for (const auto& vector : golden_vectors()) {
        if (!vector.is_encapsulation()) continue;
        for_each_mutation(vector.octets, [&](ByteView octets) {
            enip::FrameDecoder decoder;
            std::size_t data = 0;
            unsigned messages = 0;
            for (ByteView stream : {octets, ByteView(follower), ByteView(follower)}) {
                while (!stream.empty()) {
                    const auto before = stream.size();
                    const auto message = decoder.next(stream);
                    test::require(stream.size() < before, "the decoder takes something", octets);
                    if (!message) continue;
                    ++messages;
                    data += message->frame.data.size();
                    test::require(!message->oversize || message->frame.data.empty(), "oversize data is dropped",
                                  octets);
                }
            }
            test::require(data <= octets.size() + 2 * follower.size(), "no octet is made up", octets);
            test::require(messages > 0 || decoder.partial(), "a message, or the wish for more", octets);
        });
    }
}

TEST(Mutation, the_message_router_answers_every_golden_request) {
    test::DriveRouter router;
    unsigned mutations = 0;
    for (const auto& vector : golden_vectors()) {
        if (!vector.is_request() || !vector.is_encapsulation()) continue;
        const auto frame = enip::Frame::parse(vector.octets);
        const auto data = enip::SendData::parse(frame->data);
        if (!data) continue;
        const auto message = enip::unconnected_message(*data);
        if (!message) continue;
        mutations += for_each_mutation(*message, [&](ByteView octets) {
            router.ask(octets);
            router.ask(octets, 64);
        });
    }
    EXPECT_GT(mutations, 25'000U);
}

/// A device that has been spoken to, and everything that a peer may keep there is open: a session and a connection.
class SpokenTo {
public:
    SpokenTo() { reconnect(); }

    void reconnect() {
        harness_.connect();
        harness_.register_session();
        const auto reply = harness_.call(test::octets(
            "54 02 20 06 24 01 0A 0E 00000000 0A00110A 0A00 4D00 44332211 02 000000 80841E00 F443 80841E00 F443 A3"
            "02 20 02 24 01"));
        const auto response = cip::Response::parse(reply);
        ASSERT_TRUE(response && response->status.ok()) << test::hex(reply);
        connection_id_ = cip::ForwardOpenReply::parse(response->data).value().o_to_t_id;
    }

    /// Sends what was a golden request, with the session and the connection that are open here.
    void survive(ByteView mutated) {
        Bytes octets(mutated.begin(), mutated.end());
        replace(octets, 0x00010203, harness_.session());
        replace(octets, 0x56A0000B, connection_id_);
        harness_.send(octets);
        // Two replies at most: the mutation may have cut one message into two.
        const auto answer = harness_.take();
        test::require(answer.size() <= 2 * (enip::max_data_bytes + enip::header_bytes), "the answer is bounded",
                      octets);
        if (!harness_.connected() || !answers_a_list_request()) reconnect();
    }

    void answers_a_good_request() {
        harness_.advance(std::chrono::seconds(1));
        reconnect();
        EXPECT_EQ(harness_.call("0E 03 20 01 24 01 30 01"), "8E 00 00 00 6D 05");
    }

    AdapterHarness& harness() { return harness_; }

private:
    /// False when the mutation left the device waiting for the rest of a message.
    bool answers_a_list_request() {
        harness_.send(list_interfaces_);
        return harness_.take().size() == enip::header_bytes + 2;
    }

    static void replace(Bytes& octets, std::uint32_t example, std::uint32_t own) {
        for (std::size_t i = 0; i + 4 <= octets.size(); ++i) {
            if (cip::Reader(ByteView(octets).subspan(i, 4)).u32() != example) continue;
            for (std::size_t k = 0; k < 4; ++k) octets[i + k] = static_cast<std::uint8_t>(own >> (8 * k));
        }
    }

    AdapterHarness harness_;
    std::uint32_t connection_id_ = 0;
    Bytes list_interfaces_ = enip::Frame{.command = enip::Command::list_interfaces}.encode();
};

TEST(Mutation, a_device_survives_every_golden_request_on_tcp) {
    SpokenTo device;
    unsigned mutations = 0;
    for (const auto& vector : golden_vectors()) {
        if (!vector.is_request() || vector.transport != "tcp") continue;
        SCOPED_TRACE(vector.name);
        mutations += for_each_mutation(vector.octets, [&](ByteView octets) { device.survive(octets); });
        device.answers_a_good_request();
        if (HasFatalFailure()) return;
    }
    EXPECT_GT(mutations, 50'000U);
    EXPECT_EQ(device.harness().adapter().tcp_connections(), 1U);
    EXPECT_EQ(device.harness().adapter().sessions(), 1U);
    EXPECT_LE(device.harness().adapter().class3_connections(), device.harness().adapter().limits().class3_connections);
}

TEST(Mutation, a_device_survives_every_golden_vector_on_udp) {
    SpokenTo device;
    for (const auto& vector : golden_vectors()) {
        if (vector.transport == "eth") continue;
        for_each_mutation(vector.octets, [&](ByteView octets) {
            for (const auto& datagram : device.harness().datagram(octets)) {
                test::require(datagram.octets.size() <= 512, "a datagram is bounded", octets);
            }
        });
    }
    device.answers_a_good_request();
}

/// A device with an owner and one that looks on, whose time is not over soon.
class Connected {
public:
    Connected() {
        harness_.register_session();
        // Multiplier 512, 100 ms; the T->O data of both is the same multicast.
        owner_ = open("0100", "1848", "2C 65 2C 64");
        looker_ = open("0200", "0248", "2C FE 2C 64");
        EXPECT_EQ(harness_.adapter().io().size(), 2U);
    }

    AdapterHarness& harness() { return harness_; }
    const adapter::IoConnections& io() { return harness_.adapter().io(); }
    std::uint32_t owner() const { return owner_; }

    void survive_datagram(ByteView mutated, std::uint32_t id) {
        Bytes octets(mutated.begin(), mutated.end());
        if (octets.size() >= 10 && cip::Reader(ByteView(octets).subspan(6)).u32() >> 16 == 0x56A0) {
            for (std::size_t k = 0; k < 4; ++k) octets[6 + k] = static_cast<std::uint8_t>(id >> (8 * k));
        }
        harness_.io(octets);
        test::require(harness_.produced().empty(), "a datagram is not answered", octets);
        holds(octets);
    }

    /// The data portion of a SendRRData. What it opens is closed again.
    void survive_request(ByteView mutated) {
        harness_.send(enip::Frame{.command = enip::Command::send_rr_data,
                                  .session = harness_.session(),
                                  .data = {mutated.begin(), mutated.end()}}
                          .encode());
        const auto reply = harness_.frame();
        test::require(reply.has_value(), "every request is answered", mutated);
        test::require(io().size() <= 3, "one request opens one connection", mutated);
        if (io().size() == 3) ++opened_;
        while (io().size() > 2) {
            const auto triad = io().all().back()->request.triad;
            cip::ForwardClose wanted;
            wanted.triad = triad;
            const auto answer = harness_.call(cip::Request{0x4E, cip::Path::to(6, 1), wanted.encode()}.encode());
            test::require(answer.size() > 2 && answer[2] == 0, "what is open can be closed", mutated);
        }
        holds(mutated);
    }

    void still_works() {
        (void)harness_.produced();
        harness_.advance(std::chrono::milliseconds(100));
        EXPECT_EQ(harness_.produced().size(), 1U) << "one producer for both";
        EXPECT_EQ(harness_.call("0E 03 20 01 24 01 30 01"), "8E 00 00 00 6D 05");
    }
    unsigned opened() const { return opened_; }

private:
    std::uint32_t open(std::string_view serial, std::string_view o_to_t, std::string_view points) {
        const auto reply = harness_.call(test::octets(
            "54 02 20 06 24 01 0A 0E 00000000 00000000" + std::string(serial) + "4D00 44332211 07 000000 A0860100" +
            std::string(o_to_t) + "A0860100 1E28 01 04 20 04 24 01" + std::string(points)));
        const auto response = cip::Response::parse(reply);
        test::require(response && response->status.ok(), "the connection opens", reply);
        return cip::ForwardOpenReply::parse(response->data).value().o_to_t_id;
    }
    void holds(ByteView octets) {
        test::require(io().size() == 2 && io().owner() != nullptr, "the two connections stay", octets);
        test::require(io().all()[0]->o_to_t_id == owner_ && io().all()[1]->o_to_t_id == looker_,
                      "and they are the same", octets);
        test::require(harness_.adapter().class3_connections() == 0, "and nobody else comes", octets);
    }

    AdapterHarness harness_;
    std::uint32_t owner_ = 0;
    std::uint32_t looker_ = 0;
    unsigned opened_ = 0;
};

TEST(Mutation, a_device_with_connections_survives_every_datagram) {
    Connected device;
    unsigned mutations = 0;
    for (const auto& vector : golden_vectors()) {
        if (!vector.is_io_datagram()) continue;
        for (const std::uint32_t id : {device.owner(), device.owner() + 1}) {
            mutations +=
                for_each_mutation(vector.octets, [&](ByteView octets) { device.survive_datagram(octets, id); });
        }
        device.still_works();
    }
    EXPECT_GT(mutations, 10'000U);
    const auto& strays = device.io().strays();
    EXPECT_GT(strays.malformed, 1000U);
    EXPECT_GT(strays.unknown_id, 1000U);
    const auto& counters = device.io().owner()->consumer.counters();
    EXPECT_GT(counters.wrong_size, 100U);
    EXPECT_GT(counters.accepted, 10U);
    EXPECT_GT(counters.stale, 100U);
}

TEST(Mutation, a_device_with_connections_survives_every_open_of_class_1) {
    Connected device;
    const auto item = [](enip::ItemType type) {
        return enip::Item{type, enip::SocketAddress{.port = 3000, .address = 0xC0A80201}.encode()};
    };
    const std::string head = "02 20 06 24 01 0A 0E 00000000 0300110A 0300 4D00 44332211 02 000000 ";
    const std::string key = "34 04 6D05 2B00 0975 81 01 ";
    const std::vector<std::string> opens{
        "54" + head + "A0860100 0248 A0860100 1E48 01 09" + key + "20 04 24 01 2C FE 2C 64",
        "54" + head + "A0860100 0248 A0860100 1E28 01 04 20 04 24 01 2C FE 2C 64",
        "54" + head + "A0860100 0248 A0860100 1E28 01 04 20 04 24 01 2C FF 2C 64",
        "54" + head + "A0860100 0248 A0860100 2248 11 0A" + key + "43 05 20 04 24 01 2C FE 2C 69",
        "54" + head + "A0860100 0248 A0860100 2A48 21 08 20 04 24 01 51 02 88130000 2C FE 2D 00 71 00",
        "54" + head + "A0860100 1848 A0860100 1E48 01 04 20 04 24 01 2C 65 2C 64",
        "5B" + head + "A0860100 02000048 A0860100 1E000028 01 04 20 04 24 01 2C FE 2C 64"};
    unsigned mutations = 0;
    for (const auto& open : opens) {
        SCOPED_TRACE(open);
        auto data = enip::SendData::unconnected(test::octets(open));
        if (open == opens.front()) {
            data.packet.items.push_back(item(enip::ItemType::sockaddr_t_to_o));
            data.packet.items.push_back(item(enip::ItemType::sockaddr_o_to_t));
        }
        mutations += for_each_mutation(data.encode(), [&](ByteView octets) { device.survive_request(octets); });
        device.still_works();
    }
    EXPECT_GT(mutations, 4'000U);
    EXPECT_GT(device.opened(), 1000U) << "most octets may be others";
}

}  // namespace
}  // namespace servobus
