// All decoders at once, for octets that nobody has written on purpose. What they take must come out the same when it is
// encoded and decoded again; what they refuse they refuse with an error.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>

#include "adapter/assembly_object.hpp"
#include "adapter/parameter_object.hpp"
#include "cip/connection_data.hpp"
#include "cip/forward_open.hpp"
#include "cip/message.hpp"
#include "cip/message_router.hpp"
#include "cip/path.hpp"
#include "cip/request_path.hpp"
#include "cip/strings.hpp"
#include "cip/unconnected_send.hpp"
#include "drive/device.hpp"
#include "drive/xenax.hpp"
#include "enip/common_packet.hpp"
#include "enip/encapsulation.hpp"
#include "enip/io_packet.hpp"
#include "enip/messages.hpp"
#include "tests/support/octets.hpp"

namespace servobus::test {

/// Ends the program with a sentence: fuzzer and test both show it, with the stack of the sanitizer.
inline void require(bool holds, const char* sentence, cip::ByteView octets = {}) {
    if (holds) return;
    std::fprintf(stderr, "%s: %s\n", sentence, hex(octets).c_str());
    std::abort();
}

/// Decodes, and when that succeeds encodes and decodes again.
template <class Parse>
void comes_out_the_same(cip::ByteView octets, const char* what, Parse parse) {
    const auto message = parse(octets);
    if (!message) return;
    const auto again = message->encode();
    const auto second = parse(again);
    require(second && *second == *message, what, octets);
}

/// Every decoder that takes octets which come from a peer.
inline void decode_everything(cip::ByteView octets) {
    const auto each = [&](const char* what, auto parse) { comes_out_the_same(octets, what, parse); };
    each("path", [](auto bytes) { return cip::Path::parse(bytes); });
    each("request", [](auto bytes) { return cip::Request::parse(bytes); });
    each("response", [](auto bytes) { return cip::Response::parse(bytes); });
    each("forward open", [](auto bytes) { return cip::ForwardOpen::parse(bytes, false); });
    each("large forward open", [](auto bytes) { return cip::ForwardOpen::parse(bytes, true); });
    each("forward open reply", [](auto bytes) { return cip::ForwardOpenReply::parse(bytes); });
    each("forward close", [](auto bytes) { return cip::ForwardClose::parse(bytes); });
    each("forward close reply", [](auto bytes) { return cip::ForwardCloseReply::parse(bytes); });
    each("refusal", [](auto bytes) { return cip::ConnectionRefusal::parse(bytes); });
    each("connection data", [](auto bytes) { return cip::ConnectionData::parse(bytes); });
    each("connection owner", [](auto bytes) { return cip::ConnectionOwner::parse(bytes); });
    each("unconnected send", [](auto bytes) { return cip::UnconnectedSend::parse(bytes); });
    each("common packet", [](auto bytes) { return enip::CommonPacket::parse(bytes); });
    each("socket address", [](auto bytes) { return enip::SocketAddress::parse(bytes); });
    each("register session", [](auto bytes) { return enip::RegisterSession::parse(bytes); });
    each("identity item", [](auto bytes) { return enip::IdentityItem::parse(bytes); });
    each("service item", [](auto bytes) { return enip::ServiceItem::parse(bytes); });
    each("send data", [](auto bytes) { return enip::SendData::parse(bytes); });
    each("frame", [](auto bytes) { return enip::Frame::parse(bytes); });

    if (const auto data = enip::SendData::parse(octets)) {
        (void)enip::unconnected_message(*data);
        (void)enip::connected_message(*data);
    }
    if (const auto packet = enip::IoPacket::parse(octets)) {
        require(packet->data.size() + enip::io_packet_overhead <= octets.size(), "the data is in the datagram", octets);
    }
    (void)cip::RequestPath::parse(octets);
    if (const auto path = cip::Path::parse(octets)) {
        (void)describe(*path);
        (void)cip::production_inhibit_time(*path);
    }
    if (const auto response = cip::Response::parse(octets)) {
        (void)describe(response->status);
        (void)cip::RpiRefusal::from(response->status);
    }
    cip::Reader strings(octets);
    (void)cip::read_stringi(strings);
}

/// A router with the classes of a drive, and the drive behind it.
class DriveRouter {
public:
    DriveRouter() {
        router_.add(std::make_unique<adapter::AssemblyObject>(device_));
        for (const auto& each : drive::parameter_classes()) {
            router_.add(std::make_unique<adapter::ParameterObject>(device_, each.class_id));
        }
    }

    /// Asks, and holds what every answer must hold.
    void ask(cip::ByteView message, std::size_t reply_limit = cip::max_message_bytes) {
        cip::Origin origin;
        origin.reply_limit = reply_limit;
        const auto response = router_.handle(message, origin);
        require(response.has_value() == (message.size() >= 2), "every request of two octets is answered", message);
        if (!response) return;
        const auto encoded = response->encode();
        require(encoded.size() == response->encoded_size(), "the size is told right", message);
        require(encoded.size() <= reply_limit, "the reply keeps its limit", message);
        require(encoded[0] == (message[0] | 0x80), "the reply names the service", message);
        const auto parsed = cip::Response::parse(encoded);
        require(parsed && *parsed == *response, "the reply can be read", message);
    }

private:
    drive::Device device_{drive::xenax_models().front()};
    cip::MessageRouter router_{cip::NodeIdentity{1389, 43, 0x7509, 1, 1}};
};

}  // namespace servobus::test
