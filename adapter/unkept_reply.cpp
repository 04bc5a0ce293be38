#include "adapter/unkept_reply.hpp"

#include "cip/message.hpp"
#include "enip/messages.hpp"

namespace servobus::adapter {
namespace {

cip::Response refused(cip::ByteView message) {
    const auto response = cip::Response::parse(message);
    const std::uint8_t service = response ? response->service : 0;
    return {service, cip::GeneralStatus::store_operation_failure, {}};
}

}  // namespace

enip::Frame unkept(const enip::Frame& reply) {
    auto other = reply;
    const auto data = enip::SendDataView::parse(reply.data);
    if (!data) return other;
    if (const auto connected = enip::connected_message(*data)) {
        const auto message = refused(connected->message).encode();
        other.data = enip::connected_reply(connected->connection_id, connected->sequence, message);
    } else if (const auto message = enip::unconnected_message(*data)) {
        other.data = enip::unconnected_reply(refused(*message));
    }
    return other;
}

}  // namespace servobus::adapter
