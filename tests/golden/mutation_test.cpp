// Each golden vector cut at each length, and with each octet changed, through every decoder and through a whole device.
// Nobody may crash, assert or answer more than is reasonable, and the device answers a good request afterwards.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

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

}  // namespace
}  // namespace servobus
