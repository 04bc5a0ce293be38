#include "cip/connection_data.hpp"

#include "cip/triad_wire.hpp"
#include "cip/wire.hpp"

namespace servobus::cip {
namespace {

void describe_data(auto& io, auto& data) {
    io.field(data.number);
    io.field(data.state);
    io.field(data.originator_port);
    io.field(data.target_port);
    describe_triad(io, data.triad);
    io.field(data.o_to_t_id_at_originator);
    io.field(data.o_to_t_id_at_target);
    io.field(data.o_to_t_multiplier);
    io.reserved(3);
    io.field(data.o_to_t_rpi);
    io.field(data.o_to_t_api);
    io.field(data.t_to_o_id_at_originator);
    io.field(data.t_to_o_id_at_target);
    io.field(data.t_to_o_multiplier);
    io.reserved(3);
    io.field(data.t_to_o_rpi);
    io.field(data.t_to_o_api);
}

void describe_owner(auto& io, auto& owner) {
    io.field(owner.connections);
    io.field(owner.claim_output_ownership);
    io.field(owner.ready_for_ownership);
    io.field(owner.last_action);
    describe_triad(io, owner.triad);
}

template <class Message>
Decoded<Message> finished(const Reader& reader, const Message& message) {
    if (!reader.ok()) return DecodeError::truncated;
    if (reader.remaining() > 0) return DecodeError::trailing;
    return message;
}

}  // namespace

Bytes ConnectionData::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    describe_data(writer, *this);
    return bytes;
}

Decoded<ConnectionData> ConnectionData::parse(ByteView data) {
    Reader reader(data);
    ConnectionData message;
    describe_data(reader, message);
    return finished(reader, message);
}

Bytes ConnectionOwner::encode() const {
    Bytes bytes;
    Writer writer(bytes);
    describe_owner(writer, *this);
    return bytes;
}

Decoded<ConnectionOwner> ConnectionOwner::parse(ByteView data) {
    Reader reader(data);
    ConnectionOwner message;
    describe_owner(reader, message);
    return finished(reader, message);
}

}  // namespace servobus::cip
