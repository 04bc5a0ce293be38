// Forward_Open, Large_Forward_Open, Forward_Close, Unconnected_Send and what is asked about connections: decoders, checks, and
// the Connection Manager of a whole device. The input is a row of requests; a request is octet by octet, or a good one with
// octets changed. A good open opens one connection, a refusal none and names the connection, and what is open can be closed.
#include <array>
#include <cstddef>
#include <cstdint>

#include "adapter/forward_open_checks.hpp"
#include "assemblies/connection.hpp"
#include "cip/services.hpp"
#include "scanner/class3.hpp"
#include "scanner/io_plan.hpp"
#include "tests/fuzz/device_site.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using test::require;

constexpr std::size_t most_requests = 12;
constexpr cip::NodeIdentity node{1389, 43, 0x7509, 1, 1};
constexpr std::array services{cip::service::forward_open,        cip::service::large_forward_open,
                              cip::service::forward_close,       cip::service::unconnected_send,
                              cip::service::get_connection_data, cip::service::search_connection_data,
                              cip::service::get_connection_owner};

void check(const cip::ForwardOpen& open) {
    (void)adapter::is_null(open);
    (void)adapter::check_transport(open);
    (void)adapter::check_rpi(open, assemblies::largest_rpi);
    const auto wanted = adapter::check_io_open(open, node);
    require(!wanted || wanted->connection != nullptr, "an open that is admitted is for a connection", open.path);
}

// The first octet chooses what is opened, the second how often an octet is changed: at which offset, into what.
cip::Bytes nearly_good(Input& input, std::uint16_t serial) {
    const auto kinds = assemblies::connections();
    const auto which = input.below(kinds.size() + 1);
    const cip::ConnectionTriad triad{serial, 0x004D, 0x11223344};
    cip::Bytes octets;
    if (which == kinds.size()) {
        octets = scanner::Class3Proposal{.t_to_o_id = 7, .triad = triad, .path = scanner::class3_path({})}
                     .forward_open()
                     .encode();
    } else {
        auto plan = scanner::plan_of(kinds[which]);
        const auto choice = input.u8();
        if ((choice & 1) != 0) plan.t_to_o.type = cip::ConnectionType::multicast;
        if ((choice & 2) != 0) plan.large = true;
        octets = scanner::open_request(plan.forward_open(0, 0x22000000U + serial, triad)).encode();
    }
    for (auto changes = input.below(5); changes > 0; --changes) {
        const auto at = input.u8() % octets.size();
        octets[at] = input.u8();
    }
    return octets;
}

class Opener {
public:
    Opener() : id_(site_.join(0)) {}

    void ask(cip::ByteView message) {
        if (!site_.is_open(id_)) id_ = site_.join(0);
        const auto before = open();
        const auto response = site_.call(id_, message);
        if (!response) return;
        const auto now_open = open();
        require(now_open <= before + 1, "one request opens one connection", message);
        const auto request = cip::Request::parse(message);
        if (!request || request->path != manager()) return;
        if (request->service == cip::service::forward_open || request->service == cip::service::large_forward_open) {
            check_open(*request, *response, now_open == before + 1, message);
        } else if (request->service == cip::service::forward_close) {
            require(!response->status.ok() || now_open < before, "who closes closes something", message);
        }
    }
    void pass(std::uint8_t tenths) { site_.advance(std::chrono::milliseconds(100) * tenths); }
    void leave() { site_.leave(); }

private:
    static cip::Path manager() { return cip::Path::to(cip::class_id::connection_manager, 1); }
    [[nodiscard]] std::size_t open() { return site_.adapter().io().size() + site_.adapter().class3_connections(); }

    void check_open(const cip::Request& request, const cip::Response& response, bool opened, cip::ByteView message) {
        require(response.status.ok() == opened, "success is an open connection, a refusal none", message);
        const auto asked = cip::ForwardOpen::parse(request.data, request.service == cip::service::large_forward_open);
        require(asked || !opened, "what cannot be read opens nothing", message);
        if (opened) {
            const auto reply = cip::ForwardOpenReply::parse(response.data);
            require(reply && reply->triad == asked->triad, "the reply names the connection", message);
            require(reply->o_to_t_id != 0 || asked->o_to_t.type == cip::ConnectionType::null,
                    "who sends has an id to send to", message);
        } else if (asked) {
            const auto refusal = cip::ConnectionRefusal::parse(response.data);
            require(refusal && refusal->triad == asked->triad, "the refusal names the connection",
                    message);  // R-CON-14
        }
    }

    DeviceSite site_;
    DeviceSite::Id id_;
};

}  // namespace

void forward_open(cip::ByteView octets) {
    test::decode_everything(octets);
    for (const bool large : {false, true}) {
        if (const auto open = cip::ForwardOpen::parse(octets, large)) check(*open);
    }
    Input input(octets);
    Opener opener;
    std::uint16_t serial = 0;
    for (std::size_t count = 0; count < most_requests && !input.over(); ++count) {
        const auto how = input.u8();
        if ((how & 0xC0U) == 0xC0U) {
            opener.pass(how & 0x3FU);
        } else if ((how & 0x80U) != 0) {
            const auto service = services[how % services.size()];
            opener.ask(
                cip::Request{service, cip::Path::to(cip::class_id::connection_manager, 1), input.piece()}.encode());
        } else {
            // A repeated serial number is a repeated open.
            serial = static_cast<std::uint16_t>((how & 0x40U) != 0 ? serial : serial + 1);
            opener.ask(nearly_good(input, serial));
        }
    }
    opener.leave();
}

}  // namespace servobus::fuzz
