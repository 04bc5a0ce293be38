#include "tests/bench/io/link.hpp"

#include <fmt/format.h>

#include "cip/services.hpp"
#include "enip/encapsulation.hpp"
#include "tests/bench/io/image.hpp"

namespace servobus::bench {
namespace {

cip::Path connection_manager() { return cip::Path::to(cip::class_id::connection_manager, 1); }

cip::ForwardOpen forward_open(const LinkSettings& settings) {
    cip::ForwardOpen open;
    open.triad = new_triad();
    open.t_to_o_id = 0xBE000000 + open.triad.serial_number;
    open.timeout_multiplier = settings.multiplier_code;
    open.o_to_t_rpi = settings.interval_us;
    open.t_to_o_rpi = settings.interval_us;
    open.o_to_t = {.priority = cip::Priority::scheduled, .size = o_to_t_size};
    open.t_to_o = {.priority = cip::Priority::scheduled, .size = t_to_o_size};
    open.transport = {.trigger = settings.trigger, .transport_class = 1};
    open.path = {0x20, 0x04, 0x24, 0x01, 0x2C, 103, 0x2C, 100};
    return open;
}

}  // namespace

Link::Link(const LinkSettings& settings)
    : client_(settings.target, settings.local_address), request_(forward_open(settings)) {
    const auto response =
        client_.call({.service = cip::service::forward_open, .path = connection_manager(), .data = request_.encode()});
    if (!response.status.ok()) give_up("the Forward_Open is refused: " + describe(response.status));
    const auto reply = cip::ForwardOpenReply::parse(response.data);
    if (!reply) give_up("the reply to the Forward_Open makes no sense");
    outlet_ = {.peer = {settings.target.address, enip::io_port}, .connection = reply->o_to_t_id};
    t_to_o_id_ = reply->t_to_o_id;
    interval_us_ = reply->t_to_o_api;
}

Link::~Link() {
    const cip::ForwardClose close{.triad = request_.triad, .path = request_.path};
    static_cast<void>(
        client_.call({.service = cip::service::forward_close, .path = connection_manager(), .data = close.encode()}));
}

}  // namespace servobus::bench
