#include "scanner/multiple_service.hpp"

#include "cip/multiple_service.hpp"
#include "cip/services.hpp"

namespace servobus::scanner {
std::size_t packet_share(const cip::Request& request) {
    return cip::parts_head(1) - cip::parts_head(0) + request.encode().size();
}

cip::Request multiple_service_packet(std::span<const cip::Request> requests) {
    std::vector<cip::Bytes> parts;
    for (const auto& request : requests) parts.push_back(request.encode());
    return {cip::service::multiple_service_packet, cip::Path::to(cip::class_id::message_router, 1),
            cip::write_parts(parts)};
}

boost::system::result<std::vector<cip::Response>> multiple_service_responses(std::span<const cip::Request> requests,
                                                                             const cip::Response& reply) {
    const auto parts = cip::read_parts(reply.data);
    if (!parts || parts->size() != requests.size()) return make_error_code(Error::unexpected_data);
    std::vector<cip::Response> responses;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        auto response = cip::Response::parse((*parts)[i]);
        if (!response || response->service != requests[i].service) return make_error_code(Error::unexpected_data);
        responses.push_back(std::move(*response));
    }
    return responses;
}

}  // namespace servobus::scanner
