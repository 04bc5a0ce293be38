// A TCP stream, cut in two ways: both must give the same messages. The first two octets choose limit and piece size.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "enip/frame_decoder.hpp"
#include "tests/support/everything.hpp"

using namespace servobus;

namespace {

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
        auto piece = stream.first(std::min(piece_size, stream.size()));
        stream = stream.subspan(piece.size());
        while (!piece.empty()) {
            const auto before = piece.size();
            const auto message = decoder.next(piece);
            test::require(piece.size() < before, "the decoder takes something");
            test::require(message || piece.empty(), "without a message everything is taken");
            if (!message) continue;
            test::require(message->frame.data.size() <= limit, "the limit is kept");
            test::require(!message->oversize || message->frame.data.empty(), "oversize data is dropped");
            message->frame.write(outcome.messages);
            if (message->oversize) ++outcome.oversize;
        }
    }
    outcome.partial = decoder.partial();
    return outcome;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    const cip::ByteView stream(data + 2, size - 2);
    const std::size_t limit = data[0] == 0xFF ? enip::max_data_bytes : data[0];
    const auto whole = decode(stream, limit, stream.size());
    test::require(whole == decode(stream, limit, data[1] + std::size_t{1}), "pieces do not change the messages",
                  stream);
    test::require(whole.messages.size() <= stream.size(), "no octet is made up", stream);
    return 0;
}
