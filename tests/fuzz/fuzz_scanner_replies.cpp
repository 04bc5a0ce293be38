// What a hostile device answers our client. The first octet chooses the reply: identities, Forward_Open and Forward_Close,
// several services in one, values of parameters, a class 3 connection, or everything that an I/O connection hears in its life.
// Nothing is believed that has not been checked.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "assemblies/connection.hpp"
#include "cip/services.hpp"
#include "drive/xenax.hpp"
#include "enip/io_packet.hpp"
#include "scanner/class3.hpp"
#include "scanner/identity.hpp"
#include "scanner/io_reply.hpp"
#include "scanner/multiple_service.hpp"
#include "scanner/open_doctor.hpp"
#include "scanner/reading.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/originator_site.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using namespace std::chrono_literals;
using test::require;

constexpr std::size_t most_steps = 48;
constexpr cip::ConnectionTriad triad{0x0102, 0x004D, 0x11223344};

scanner::IoPlan plan(bool multicast) {
    auto plan = scanner::plan_of(*assemblies::find_connection("standard"));
    if (multicast) plan.t_to_o.type = cip::ConnectionType::multicast;
    return plan;
}

std::vector<enip::Item> items_from(Input& input) {
    std::vector<enip::Item> items;
    for (auto count = input.below(4); count > 0; --count) {
        static constexpr std::array types{enip::ItemType::sockaddr_o_to_t, enip::ItemType::sockaddr_t_to_o,
                                          enip::ItemType::sequenced_address};
        const auto type = types[input.below(types.size())];
        items.push_back({type, input.piece()});
    }
    return items;
}

// --- who it says it is

void identities(cip::ByteView octets) {
    const auto frame = enip::Frame::parse(octets);
    const auto packet = enip::CommonPacket::parse(frame ? cip::ByteView(frame->data) : octets);
    if (packet) {
        for (const auto& item : packet->items) {
            const auto parsed = enip::IdentityItem::parse(item.data);
            if (!parsed) continue;
            const auto identity = scanner::identity_of(*parsed);
            // A state of 0xFF is none (R-CPF-5).
            require(identity.state.value_or(0xFF) == parsed->state && identity.product_name == parsed->product_name,
                    "an identity is that of its item", item.data);
            (void)scanner::status_text(identity.status);
            (void)scanner::state_text(parsed->state);
        }
    }
    (void)scanner::read_identity(octets);
    for (std::uint32_t id = 0; id < 20; ++id) {
        scanner::Identity identity;
        const bool taken = scanner::set_attribute(identity, id, octets);
        require(taken || identity == scanner::Identity{}, "a value that is too short changes nothing", octets);
        (void)scanner::describe_identity_attribute(id, octets);
    }
}

// --- what it grants

void grants(Input& input) {
    const auto how = input.u8();
    const auto wanted = plan((how & 1U) != 0);
    const auto request = wanted.forward_open(0, 0x33000001, triad);
    const auto items = items_from(input);
    auto data = input.rest();
    // With the triad that was sent the next check is reached.
    if ((how & 2U) != 0 && data.size() >= 16) {
        const auto names = cip::ConnectionRefusal{triad, 0}.encode();
        std::copy_n(names.begin(), 8, data.begin() + 8);
    }
    if (const auto grant = scanner::check_open_reply(wanted, request, data, items, OriginatorSite::device)) {
        require(grant->reply.triad == triad, "a grant is for this connection", data);
        require(grant->target.port != 0, "data is sent to a port", data);
        require(std::chrono::microseconds(grant->reply.t_to_o_api) >= scanner::shortest_api, "an interval can be kept",
                data);
        require(!grant->group || enip::is_multicast(grant->group->address), "a group is one", data);
    }
    (void)scanner::check_close_reply(triad, data);
    const auto response = cip::Response::parse(data);
    if (!response) return;
    (void)scanner::check_refusal(triad, *response);
    const auto diagnosis = scanner::diagnose_refusal({.request = request, .plan = wanted}, response->status);
    require(!diagnosis.summary.empty(), "a diagnosis has a summary", data);
}

void class3(cip::ByteView data) {
    const scanner::Class3Proposal proposal{.t_to_o_id = 7, .triad = triad, .path = scanner::class3_path({})};
    const auto connection = scanner::class3_connection(proposal, data);
    if (connection) require(connection->max_message() > 0, "a connection has room for a message", data);
}

// --- what it answers to reads

void several(Input& input) {
    std::vector<cip::Request> requests;
    for (auto count = input.below(6); count > 0; --count) {
        requests.push_back({input.u8(), cip::Path::to(input.u8(), 1), {}});
        requests.back().service &= 0x7FU;
    }
    cip::Response reply{cip::service::multiple_service_packet, {}, input.rest()};
    const auto responses = scanner::multiple_service_responses(requests, reply);
    if (!responses) return;
    require(responses->size() == requests.size(), "every request has its response", reply.data);
    for (std::size_t i = 0; i < requests.size(); ++i) {
        require((*responses)[i].service == requests[i].service, "a response is to its service", reply.data);
    }
}

void values(Input& input) {
    const auto rows = drive::xenax_models().front().parameters;
    const auto& row = rows[input.u16() % rows.size()];
    const auto octets = input.rest();
    const auto response = cip::Response::parse(octets);
    const auto outcome = scanner::read_outcome(
        row, response ? *response : cip::Response{cip::service::get_attribute_single, {}, octets});
    if (!outcome) return;
    require(outcome->value.has_value() == outcome->status.ok(), "a value or a refusal", octets);
    require(outcome->surplus <= octets.size(), "what was not read is in the reply", octets);
}

// --- what an I/O connection hears

void check(const OriginatorSite& site) {
    using enum scanner::IoState;
    const auto state = site.session.state();
    require(site.expected.size() <= 1, "one connection listens for one id");
    require(state != closed || site.expected.empty(), "what is closed listens for nothing");
    const bool waits_for_device = state == connecting || state == opening || state == closing;
    require(!waits_for_device || site.owes_an_answer(), "what is waited for has been asked for");
    require((state != waiting && state != open) || site.session.next_deadline(), "nobody waits for ever");
}

cip::Response answer_from(Input& input, const OriginatorSite& site, std::uint8_t how) {
    const auto service = site.asked.empty() ? std::uint8_t{0} : site.asked.front().request.service;
    if ((how & 0x10U) != 0 && !site.asked.empty()) {
        const auto& request = site.asked.front().request;
        const bool large = request.service == cip::service::large_forward_open;
        if (const auto open = cip::ForwardOpen::parse(request.data, large)) {
            auto octets =
                cip::ForwardOpenReply{0x56A00001, open->t_to_o_id, open->triad, open->o_to_t_rpi, open->t_to_o_rpi, {}}
                    .encode();
            for (auto changes = input.below(3); changes > 0; --changes) {
                const auto at = input.u8() % octets.size();
                octets[at] = input.u8();
            }
            return {service, {}, octets};
        }
        if (const auto close = cip::ForwardClose::parse(request.data)) {
            return {service, {}, cip::ForwardCloseReply{close->triad, {}}.encode()};
        }
    }
    cip::Response response{(how & 0x20U) != 0 ? input.u8() : service};
    response.service &= 0x7FU;
    response.status.general = static_cast<cip::GeneralStatus>(input.u8());
    if ((how & 0x40U) != 0) response.status.extended = {input.u16()};
    response.data = input.piece();
    return response;
}

void step(OriginatorSite& site, Input& input) {
    const auto how = input.u8();
    switch (how & 0x07U) {
        case 0:
            return site.session.open(site.now);
        case 1:
            return site.reach();
        case 2:
        case 3: {
            auto response = answer_from(input, site, how);
            return site.answer(response, (how & 0x08U) != 0 ? items_from(input) : std::vector<enip::Item>{});
        }
        case 4: {
            const auto id = site.expected.empty() ? input.u32() : *site.expected.begin();
            auto data = input.piece();
            if ((how & 0x10U) != 0) data.resize(30);
            cip::Bytes datagram(enip::io_packet_overhead + data.size());
            std::ranges::copy(data, enip::begin_io_packet(datagram, id, input.u16()).begin());
            if (const auto packet = enip::IoPacket::parse(datagram)) (void)site.receive(datagram, *packet);
            return;
        }
        case 5:
            return site.advance(1ms * input.u16());
        case 6:
            return site.lose_tcp();
        default:
            return site.session.close(site.now);
    }
}

void life(Input& input) {
    OriginatorSite site(plan((input.u8() & 1U) != 0));
    site.begin();
    for (std::size_t count = 0; count < most_steps && !input.over(); ++count) {
        step(site, input);
        check(site);
    }
    // Closed by its owner, with a device that is gone, it comes to rest.
    site.session.close(site.now);
    for (int i = 0; i < 4; ++i) {
        site.refuse_tcp();
        site.lose_tcp();
        site.advance(10s);
    }
    require(site.session.state() == scanner::IoState::closed || site.session.state() == scanner::IoState::idle,
            "what is closed comes to rest");
    require(site.expected.empty(), "and listens for nothing");
}

}  // namespace

void scanner_replies(cip::ByteView octets) {
    Input input(octets);
    switch (input.u8() % 6) {
        case 0:
            return identities(input.rest());
        case 1:
            return grants(input);
        case 2:
            return class3(input.rest());
        case 3:
            return several(input);
        case 4:
            return values(input);
        default:
            return life(input);
    }
}

}  // namespace servobus::fuzz
