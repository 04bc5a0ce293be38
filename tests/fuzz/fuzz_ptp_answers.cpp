// What comes from the socket of a PTP node, for whoever asks it and for the Time Sync object that tells it. The input is a row
// of steps: an octet that says what happens, and a piece with its length in front. The piece is a whole message, or what the
// node tells in its answer to the question that is asked.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "adapter/ptp_client.hpp"
#include "adapter/time_sync_object.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

constexpr std::size_t question_octets = 54;
constexpr std::size_t before_tlv = 48;
constexpr std::uint8_t last_attribute = 28;

// The answer of a node that means well to a question, with these octets told.
cip::Bytes answer(cip::ByteView question, bool refused, const cip::Bytes& told) {
    constexpr std::size_t length = 2;
    constexpr std::size_t action = 46;
    constexpr std::uint8_t response = 2;
    cip::Bytes octets;
    cip::Writer writer(octets);
    const auto id = question.last(2);
    const std::size_t body = (refused ? 4U : 2U) + told.size();
    writer.bytes(question.first(length));
    writer.big(static_cast<std::uint16_t>(before_tlv + 4 + body));
    writer.bytes(question.subspan(length + 2, before_tlv - length - 2));
    octets[action] = response;
    writer.big(static_cast<std::uint16_t>(refused ? 2 : 1));
    writer.big(static_cast<std::uint16_t>(body));
    if (refused) writer.big(std::uint16_t{1});
    writer.bytes(id);
    writer.bytes(told);
    return octets;
}

void tell_all(const adapter::TimeSyncObject& object) {
    for (std::uint32_t id = 0; id <= last_attribute + 1U; ++id) {
        if (!object.attribute(1, id)) continue;
        cip::Bytes octets;
        cip::Writer writer(octets);
        test::require(object.get(1, id, writer).ok(), "an attribute that is there can be told");
        test::require(!octets.empty() && octets.size() <= cip::max_message_bytes, "a value has its size");
    }
}

}  // namespace

void ptp_answers(cip::ByteView octets) {
    Input input(octets);
    adapter::TimeSync known;
    adapter::Network network;
    const drive::Identity identity{.serial_number = 1, .product_name = "drive"};
    adapter::PtpClient client(known, input.u8(), adapter::Log());
    adapter::TimeSyncObject object(known, network, identity);
    enip::Time now{std::chrono::hours(1)};
    cip::Bytes question;
    while (!input.over()) {
        const auto what = input.u8();
        if ((what & 0xC0U) == 0xC0U || question.empty()) {
            now = std::max(now + std::chrono::microseconds(what), client.next_deadline().value_or(now));
            client.on_timer(now);
        } else {
            const auto piece = input.piece();
            client.on_message((what & 0x80U) != 0 ? piece : answer(question, (what & 1U) != 0, piece), now);
        }
        const auto asked = client.take_messages();
        test::require(asked.size() <= 1, "one question after the other");
        if (!asked.empty()) question = asked.front();
        test::require(question.empty() || question.size() == question_octets, "a question has its size");
        test::require(client.next_deadline() >= now, "a deadline that has passed does not stay");
        test::require(!known.node || known.node->ports.size() <= adapter::max_ptp_ports, "ports are bounded");
        tell_all(object);
    }
}

}  // namespace servobus::fuzz
