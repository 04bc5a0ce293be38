// The encapsulation header and a TCP stream of messages. The stream is cut in two ways: both must give the same messages.
// The first two octets choose the decoder's limit and the size of the pieces.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "enip/frame_decoder.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

struct Outcome {
    cip::Bytes messages;
    std::size_t oversize = 0;
    bool partial = false;
    bool operator==(const Outcome&) const = default;
};

Outcome decode(cip::ByteView stream, std::size_t limit, std::size_t piece_size) {
    enip::FrameDecoder decoder(limit);
    Outcome outcome;
    while (!stream.empty()) {
        const auto front = stream.first(std::min(piece_size, stream.size()));
        stream = stream.subspan(front.size());
        const cip::Bytes exact(front.begin(), front.end());
        for (cip::ByteView piece(exact); !piece.empty();) {
            const auto before = piece.size();
            const auto message = decoder.next(piece);
            require(piece.size() < before, "the decoder takes something");
            require(message || piece.empty(), "without a message everything is taken");
            if (!message) continue;
            require(message->frame.data.size() <= limit, "the limit is kept");
            require(!message->oversize || message->frame.data.empty(), "oversize data is dropped");
            message->frame.write(outcome.messages);
            if (message->oversize) ++outcome.oversize;
        }
    }
    outcome.partial = decoder.partial();
    return outcome;
}

// R-ENC-9.
void check_reply(const enip::Frame& request, cip::ByteView octets) {
    const auto reply = request.reply(enip::EncapsulationStatus::invalid_length);
    require(reply.command == request.command && reply.session == request.session && reply.context == request.context,
            "a reply has command, session and context of its request", octets);
    require(reply.encode().size() == enip::header_bytes, "a refusal has no data", octets);
    require(!enip::describe(request.command).empty() && !enip::describe(request.status).empty(),
            "command and status have words", octets);
}

}  // namespace

void encapsulation(cip::ByteView input) {
    if (input.size() < 2) return;
    const auto stream = input.subspan(2);
    const std::size_t limit = input[0] == 0xFF ? enip::max_data_bytes : input[0];
    const auto whole = decode(stream, limit, stream.size());
    require(whole == decode(stream, limit, input[1] + std::size_t{1}), "pieces do not change the messages", stream);
    require(whole.messages.size() <= stream.size(), "no octet is made up", stream);

    const auto datagram = enip::Frame::parse(stream);
    if (!datagram) return;
    require(std::ranges::equal(datagram->encode(), stream.first(enip::header_bytes + datagram->data.size())),
            "a message comes out octet by octet", stream);
    check_reply(*datagram, stream);
}

}  // namespace servobus::fuzz
