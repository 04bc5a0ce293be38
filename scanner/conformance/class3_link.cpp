#include "scanner/conformance/class3_link.hpp"

#include <fmt/format.h>

#include "enip/messages.hpp"
#include "scanner/conformance/io_link.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner::conformance {
namespace {

constexpr std::uint16_t usual_size = 500;
constexpr std::uint32_t usual_interval = 1'000'000;
constexpr std::uint8_t times_16 = 2;
constexpr std::uint8_t explicit_server = 0xA3;

/// Not every device has explicit connections; one that has none says so in one of these ways.
bool has_none(const cip::Status& status) {
    for (const auto& code : {Code{0x08}, Code{0x01, 0x0103}, Code{0x01, 0x011C}}) {
        if (code.matches(status)) return true;
    }
    return false;
}

bool has_none_left(const cip::Status& status) {
    for (const auto& code : {Code{0x02}, Code{0x01, 0x0113}, Code{0x01, 0x011A}}) {
        if (code.matches(status)) return true;
    }
    return false;
}

}  // namespace

cip::ForwardOpen class3_open(Bench& bench) {
    cip::ForwardOpen open;
    open.t_to_o_id = bench.subject().next_id();
    open.triad = bench.subject().next_triad();
    open.timeout_multiplier = times_16;
    open.o_to_t_rpi = usual_interval;
    open.t_to_o_rpi = usual_interval;
    open.o_to_t.variable = true;
    open.o_to_t.size = usual_size;
    open.t_to_o = open.o_to_t;
    open.transport = cip::Transport::from_byte(explicit_server);
    open.path = hex("20 02 24 01");
    return open;
}

Class3Link::Class3Link(Session& session, const std::function<void(cip::ForwardOpen&)>& change)
    : session_(session), request_(class3_open(session.bench())) {
    if (change) change(request_);
    auto& bench = session.bench();
    const auto reply = session.call(open_request(request_));
    if (!reply) return;
    if (has_none(reply->response.status)) {
        bench.skip("the device has no explicit connections");
        return;
    }
    if (has_none_left(reply->response.status)) {
        bench.skip("the device has no connection left");
        return;
    }
    if (!granted(bench, reply)) return;
    open_ = true;
    const auto grant = cip::ForwardOpenReply::parse(reply->response.data);
    if (!bench.require(grant.has_value(), fmt::format("the reply to the Forward_Open has {} octets and not 26",
                                                      reply->response.data.size()))) {
        return;
    }
    grant_ = *grant;
}

Class3Link::~Class3Link() {
    if (open_ && session_.is_open()) static_cast<void>(close_triad(session_, request_));
}

std::optional<Reply> Class3Link::close() {
    open_ = false;
    return close_triad(session_, request_);
}

std::optional<Reply> Class3Link::call(cip::ByteView message, std::optional<std::uint16_t> sequence) {
    auto& bench = session_.bench();
    const auto count = sequence ? *sequence : next_sequence();
    const auto request = session_.unit_frame(grant_.o_to_t_id, count, message);
    if (!session_.wire().send(request)) {
        bench.require(false, "the connection is over");
        return std::nullopt;
    }
    // The context of a SendUnitData means nothing.
    const auto frame = session_.wire().receive();
    if (!bench.require(frame.has_value(), "no answer over the connection")) return std::nullopt;
    const auto nothing = [&](std::string words) {
        bench.require(false, std::move(words));
        return std::nullopt;
    };
    if (frame->command != enip::Command::send_unit_data || frame->status != enip::EncapsulationStatus::success) {
        return nothing(fmt::format("{}, status {}, instead of a SendUnitData", enip::describe(frame->command),
                                   enip::describe(frame->status)));
    }
    const auto data = enip::SendData::parse(frame->data);
    if (!data) return nothing("the items of the reply cannot be read");
    const auto connected = enip::connected_message(*data);
    if (!connected) return nothing("the reply is not a connected address and a connected data item");
    bench.require(connected->connection_id == request_.t_to_o_id,
                  fmt::format("the reply is for connection 0x{:08X}; the originator has chosen 0x{:08X}",
                              connected->connection_id, request_.t_to_o_id));
    bench.require(connected->sequence == count,
                  fmt::format("sequence count {} in the reply to {}", connected->sequence, count));
    auto response = cip::Response::parse(connected->message);
    if (!response) return nothing("the CIP reply cannot be read");
    Reply reply;
    reply.frame = *frame;
    reply.message.assign(connected->message.begin(), connected->message.end());
    reply.response = std::move(*response);
    return reply;
}

bool Class3Link::expect_silence(cip::ByteView message, std::string_view what, bool firm) {
    return session_.wire().expect_silence(session_.unit_frame(grant_.o_to_t_id, next_sequence(), message).encode(),
                                          what, firm);
}

}  // namespace servobus::scanner::conformance
