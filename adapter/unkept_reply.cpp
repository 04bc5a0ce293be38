#include "adapter/unkept_reply.hpp"

#include "cip/message.hpp"
#include "enip/messages.hpp"

namespace servobus::adapter {
namespace {

cip::Bytes refused(cip::ByteView message) {
    const auto response = cip::Response::parse(message);
    const std::uint8_t service = response ? response->service : 0;
    return cip::Response{service, cip::GeneralStatus::store_operation_failure, {}}.encode();
}

}  // namespace

enip::Frame unkept(const enip::Frame& reply) {
    auto other = reply;
    const auto data = enip::SendData::parse(reply.data);
    if (!data) return other;
    if (const auto connected = enip::connected_message(*data)) {
        other.data =
            enip::SendData::connected(connected->connection_id, connected->sequence, refused(connected->message))
                .encode();
    } else if (const auto message = enip::unconnected_message(*data)) {
        other.data = enip::SendData::unconnected(refused(*message)).encode();
    }
    return other;
}

}  // namespace servobus::adapter
