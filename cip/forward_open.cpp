#include "cip/forward_open.hpp"

#include "cip/triad_wire.hpp"
#include "cip/wire.hpp"

namespace servobus::cip {
namespace {

// Network segments of a connection path (R-PTH-7).
constexpr std::uint8_t inhibit_milliseconds = 0x43;
constexpr std::uint8_t inhibit_microseconds = 0x51;

// The parameters differ in width between the two forms, so they pass through the raw word.
template <class Io, class Parameters>
void describe_parameters(Io& io, Parameters& parameters, bool large) {
    std::uint16_t word = 0;
    std::uint32_t dword = 0;
    if constexpr (std::is_const_v<Parameters>) {
        word = parameters.to_word();
        dword = parameters.to_dword();
    }
    if (large) {
        io.field(dword);
    } else {
        io.field(word);
    }
    if constexpr (!std::is_const_v<Parameters>) {
        parameters = large ? ConnectionParameters::from_dword(dword) : ConnectionParameters::from_word(word);
    }
}

template <class Io, class Open>
void describe_open(Io& io, Open& open) {
    io.field(open.priority_tick);
    io.field(open.timeout_ticks);
    io.field(open.o_to_t_id);
    io.field(open.t_to_o_id);
    describe_triad(io, open.triad);
    io.field(open.timeout_multiplier);
    io.reserved(3);
    io.field(open.o_to_t_rpi);
    describe_parameters(io, open.o_to_t, open.large);
    io.field(open.t_to_o_rpi);
    describe_parameters(io, open.t_to_o, open.large);
}

template <class Io, class Reply>
void describe_reply(Io& io, Reply& reply) {
    io.field(reply.o_to_t_id);
    io.field(reply.t_to_o_id);
    describe_triad(io, reply.triad);
    io.field(reply.o_to_t_api);
    io.field(reply.t_to_o_api);
}

template <class Io, class Close>
void describe_close(Io& io, Close& close) {
    io.field(close.priority_tick);
    io.field(close.timeout_ticks);
    describe_triad(io, close.triad);
}

// A path or application reply: size in words, perhaps a reserved octet, then the octets, to the end of the message.
Decoded<Bytes> read_words(Reader& reader, bool reserved_octet) {
    const auto octets = reader.u8() * std::size_t{2};
    if (reserved_octet) reader.reserved(1);
    const auto words = reader.take(octets);
    if (!reader.ok()) return DecodeError::truncated;
    if (reader.remaining() > 0) return DecodeError::trailing;
    return Bytes(words.begin(), words.end());
}

void write_words(Writer& writer, ByteView words, bool reserved_octet) {
    writer.u8(static_cast<std::uint8_t>(words.size() / 2));
    if (reserved_octet) writer.u8(0);
    writer.bytes(words);
}

}  // namespace

ConnectionParameters ConnectionParameters::from_word(std::uint16_t word) {
    return {
        .redundant_owner = (word & 0x8000) != 0,
        .type = static_cast<ConnectionType>((word >> 13) & 3),
        .priority = static_cast<Priority>((word >> 10) & 3),
        .variable = (word & 0x0200) != 0,
        .size = static_cast<std::uint16_t>(word & 0x01FF),
    };
}

ConnectionParameters ConnectionParameters::from_dword(std::uint32_t dword) {
    auto parameters = from_word(static_cast<std::uint16_t>((dword >> 16) & 0xFE00));
    parameters.size = static_cast<std::uint16_t>(dword);
    return parameters;
}

std::uint16_t ConnectionParameters::to_word() const {
    return static_cast<std::uint16_t>((to_dword() >> 16) | (size & 0x01FFU));
}

std::uint32_t ConnectionParameters::to_dword() const {
    const std::uint32_t high = (redundant_owner ? 0x8000U : 0U) | static_cast<std::uint32_t>(type) << 13 |
                               static_cast<std::uint32_t>(priority) << 10 | (variable ? 0x0200U : 0U);
    return high << 16 | size;
}

Transport Transport::from_byte(std::uint8_t byte) {
    return {(byte & 0x80) != 0, static_cast<std::uint8_t>((byte >> 4) & 7), static_cast<std::uint8_t>(byte & 0x0F)};
}

std::uint8_t Transport::to_byte() const {
    return static_cast<std::uint8_t>((server ? 0x80U : 0U) | (trigger & 7U) << 4 | (transport_class & 0x0FU));
}

Bytes ForwardOpen::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    describe_open(writer, *this);
    writer.u8(transport.to_byte());
    write_words(writer, path, false);
    return bytes;
}

Decoded<ForwardOpen> ForwardOpen::parse(ByteView data, bool large) {
    Reader reader(data);
    ForwardOpen open;
    open.large = large;
    describe_open(reader, open);
    open.transport = Transport::from_byte(reader.u8());
    auto path = read_words(reader, false);
    if (!path) return path.error();
    open.path = std::move(*path);
    return open;
}

Bytes ForwardOpenReply::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    describe_reply(writer, *this);
    write_words(writer, application_reply, true);
    return bytes;
}

Decoded<ForwardOpenReply> ForwardOpenReply::parse(ByteView data) {
    Reader reader(data);
    ForwardOpenReply reply;
    describe_reply(reader, reply);
    auto application = read_words(reader, true);
    if (!application) return application.error();
    reply.application_reply = std::move(*application);
    return reply;
}

Bytes ConnectionRefusal::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    describe_triad(writer, triad);
    writer.u8(remaining_path_words);
    writer.u8(0);
    return bytes;
}

Decoded<ConnectionRefusal> ConnectionRefusal::parse(ByteView data) {
    Reader reader(data);
    ConnectionRefusal refusal;
    describe_triad(reader, refusal.triad);
    if (!reader.ok()) return DecodeError::truncated;
    // Some stacks send only the size octet, or nothing (R-CM-10).
    if (reader.remaining() > 0) reader.field(refusal.remaining_path_words);
    return refusal;
}

Status RpiRefusal::status() const {
    const auto low = [](std::uint32_t value) { return static_cast<std::uint16_t>(value); };
    const auto high = [](std::uint32_t value) { return static_cast<std::uint16_t>(value >> 16); };
    const auto kinds = static_cast<unsigned>(o_to_t_kind) | static_cast<unsigned>(t_to_o_kind) << 8;
    return {GeneralStatus::connection_failure,
            {static_cast<std::uint16_t>(ConnectionFailure::rpi_not_acceptable), static_cast<std::uint16_t>(kinds),
             low(o_to_t), high(o_to_t), low(t_to_o), high(t_to_o)}};
}

std::optional<RpiRefusal> RpiRefusal::from(const Status& status) {
    constexpr std::size_t all_words = 6;
    const auto& words = status.extended;
    if (status.general != GeneralStatus::connection_failure || words.size() < all_words ||
        words[0] != static_cast<std::uint16_t>(ConnectionFailure::rpi_not_acceptable)) {
        return std::nullopt;
    }
    const auto dword = [&](std::size_t at) { return words[at] | std::uint32_t{words[at + 1]} << 16; };
    return RpiRefusal{static_cast<RpiKind>(words[1] & 0xFF), static_cast<RpiKind>(words[1] >> 8), dword(2), dword(4)};
}

std::optional<std::uint32_t> production_inhibit_time(const Path& path) {
    for (const auto& segment : path.segments) {
        const auto* network = std::get_if<NetworkSegment>(&segment);
        if (network == nullptr) continue;
        if (network->type == inhibit_milliseconds && network->data.size() == 1) return network->data[0] * 1000U;
        if (network->type == inhibit_microseconds && network->data.size() == 4) return Reader(network->data).u32();
    }
    return std::nullopt;
}

NetworkSegment production_inhibit_segment(std::uint32_t microseconds) {
    if (microseconds % 1000 == 0 && microseconds / 1000 <= 0xFF) {
        return {inhibit_milliseconds, {static_cast<std::uint8_t>(microseconds / 1000)}};
    }
    Bytes data;
    Writer(data).u32(microseconds);
    return {inhibit_microseconds, std::move(data)};
}

Bytes ForwardClose::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    describe_close(writer, *this);
    write_words(writer, path, true);
    return bytes;
}

Decoded<ForwardClose> ForwardClose::parse(ByteView data) {
    Reader reader(data);
    ForwardClose close;
    describe_close(reader, close);
    auto path = read_words(reader, true);
    if (!path) return path.error();
    close.path = std::move(*path);
    return close;
}

Bytes ForwardCloseReply::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    describe_triad(writer, triad);
    write_words(writer, application_reply, true);
    return bytes;
}

Decoded<ForwardCloseReply> ForwardCloseReply::parse(ByteView data) {
    Reader reader(data);
    ForwardCloseReply reply;
    describe_triad(reader, reply.triad);
    auto application = read_words(reader, true);
    if (!application) return application.error();
    reply.application_reply = std::move(*application);
    return reply;
}

}  // namespace servobus::cip
