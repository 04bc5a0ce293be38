#include "scanner/multiple_service.hpp"

#include "cip/services.hpp"
#include "cip/wire.hpp"

namespace servobus::scanner {
namespace {

constexpr std::size_t offset_octets = 2;

/// The octets from one offset to the next; nullopt when the offsets do not ascend inside `data`.
std::optional<std::vector<cip::ByteView>> cut(cip::ByteView data, std::size_t count) {
    cip::Reader reader(data);
    if (reader.u16() != count) return std::nullopt;
    std::vector<std::size_t> offsets;
    for (std::size_t i = 0; i < count; ++i) offsets.push_back(reader.u16());
    if (!reader.ok()) return std::nullopt;
    offsets.push_back(data.size());
    std::vector<cip::ByteView> parts;
    auto begin = offset_octets * (count + 1);
    for (std::size_t i = 0; i < count; ++i) {
        if (offsets[i] < begin || offsets[i + 1] < offsets[i] || offsets[i + 1] > data.size()) return std::nullopt;
        parts.push_back(data.subspan(offsets[i], offsets[i + 1] - offsets[i]));
        begin = offsets[i + 1];
    }
    return parts;
}

}  // namespace

std::size_t packet_share(const cip::Request& request) { return offset_octets + request.encode().size(); }

cip::Request multiple_service_packet(std::span<const cip::Request> requests) {
    cip::Request packet{cip::service::multiple_service_packet, cip::Path::to(cip::class_id::message_router, 1), {}};
    cip::Bytes embedded;
    cip::Writer writer(packet.data);
    writer.u16(static_cast<std::uint16_t>(requests.size()));
    const auto head = offset_octets * (requests.size() + 1);
    for (const auto& request : requests) {
        writer.u16(static_cast<std::uint16_t>(head + embedded.size()));
        const auto octets = request.encode();
        embedded.insert(embedded.end(), octets.begin(), octets.end());
    }
    writer.bytes(embedded);
    return packet;
}

boost::system::result<std::vector<cip::Response>> multiple_service_responses(std::span<const cip::Request> requests,
                                                                             const cip::Response& reply) {
    const auto parts = cut(reply.data, requests.size());
    if (!parts) return make_error_code(Error::unexpected_data);
    std::vector<cip::Response> responses;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        auto response = cip::Response::parse((*parts)[i]);
        if (!response || response->service != requests[i].service) return make_error_code(Error::unexpected_data);
        responses.push_back(std::move(*response));
    }
    return responses;
}

}  // namespace servobus::scanner
