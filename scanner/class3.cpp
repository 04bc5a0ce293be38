#include "scanner/class3.hpp"

#include "cip/services.hpp"

namespace servobus::scanner {
namespace {

// The target drops a connection on which nothing came for the product of both, 64 s.
constexpr std::uint32_t request_interval_us = 2'000'000;
constexpr std::uint8_t multiplier_32 = 3;

constexpr std::uint8_t application_trigger = 2;

cip::Path connection_manager() { return cip::Path::to(cip::class_id::connection_manager, 1); }

}  // namespace

cip::Request Class3Proposal::forward_open() const {
    cip::ForwardOpen open;
    open.large = large;
    open.t_to_o_id = t_to_o_id;
    open.triad = triad;
    open.timeout_multiplier = multiplier_32;
    open.o_to_t_rpi = request_interval_us;
    open.t_to_o_rpi = request_interval_us;
    open.o_to_t = {.variable = true, .size = size()};
    open.t_to_o = open.o_to_t;
    open.transport = {.server = true, .trigger = application_trigger, .transport_class = 3};
    open.path = path.encode();
    const auto service = large ? cip::service::large_forward_open : cip::service::forward_open;
    return {service, connection_manager(), open.encode()};
}

cip::Request Class3Proposal::forward_close() const {
    cip::ForwardClose close;
    close.triad = triad;
    close.path = path.encode();
    return {cip::service::forward_close, connection_manager(), close.encode()};
}

cip::Path class3_path(const cip::Path& route) {
    auto path = route;
    const auto router = cip::Path::to(cip::class_id::message_router, 1);
    path.segments.insert(path.segments.end(), router.segments.begin(), router.segments.end());
    return path;
}

cip::Decoded<Class3Connection> class3_connection(const Class3Proposal& proposal, cip::ByteView reply) {
    const auto parsed = cip::ForwardOpenReply::parse(reply);
    if (!parsed) return parsed.error();
    if (parsed->triad != proposal.triad) return cip::DecodeError::bad_value;
    Class3Connection connection;
    connection.proposal = proposal;
    // Some targets choose this one too, although it is the originator's.
    connection.proposal.t_to_o_id = parsed->t_to_o_id;
    connection.o_to_t_id = parsed->o_to_t_id;
    return connection;
}

}  // namespace servobus::scanner
