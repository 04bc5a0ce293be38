// Each group of the conformance suite against servers that are wrong in one way: the case that is about it must fail.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cip/forward_open.hpp"
#include "cip/services.hpp"
#include "enip/io_packet.hpp"
#include "enip/messages.hpp"
#include "tests/conformance/bad_target.hpp"
#include "tests/scanner/run_scanner.hpp"

namespace servobus::test {
namespace {

using enip::Command;
using enip::EncapsulationStatus;
using enip::Frame;
using Json = nlohmann::json;

constexpr std::uint16_t identity = 0x01;
constexpr std::uint16_t connection_manager = 0x06;
constexpr std::uint8_t get_single = 0x0E;
constexpr std::uint8_t set_single = 0x10;
constexpr std::uint8_t forward_open = 0x54;
constexpr std::uint8_t forward_close = 0x4E;
constexpr std::uint16_t timeout_places = 0xF5;

// -------------------------------------------------------------------------------------------------- encapsulation

Vice zeroes_the_context() {
    Vice vice;
    vice.on_reply = [](const Frame&, Frame& reply) { reply.context = {}; };
    return vice;
}

Vice answers_nops() {
    Vice vice;
    vice.on_request = [](Frame& request) {
        if (request.command != Command::nop) return Fate{};
        return Fate{Fate::Kind::answer, request.reply()};
    };
    return vice;
}

Vice knows_every_command() {
    Vice vice;
    vice.on_reply = [](const Frame&, Frame& reply) {
        if (reply.status == EncapsulationStatus::unsupported_command) reply.status = EncapsulationStatus::success;
    };
    return vice;
}

Vice ignores_options() {
    Vice vice;
    vice.on_request = [](Frame& request) {
        request.options = 0;
        return Fate{};
    };
    return vice;
}

Vice loses_the_fifth() {
    Vice vice;
    vice.on_request = [count = 0](Frame& request) mutable {
        return request.command == Command::send_rr_data && ++count == 5 ? Fate{Fate::Kind::drop, {}} : Fate{};
    };
    return vice;
}

Vice is_another_over_udp() {
    Vice vice;
    vice.on_udp_reply = [](Frame& reply) {
        if (reply.command == Command::list_identity && reply.data.size() > 30) reply.data[26] ^= 1;
    };
    return vice;
}

// ------------------------------------------------------------------------------------------------------- sessions

Vice takes_any_version() {
    Vice vice;
    vice.on_request = [](Frame& request) {
        if (request.command == Command::register_session && !request.data.empty()) request.data[0] = 1;
        return Fate{};
    };
    return vice;
}

Vice takes_any_handle() {
    Vice vice;
    const auto handle = std::make_shared<std::uint32_t>(0);
    vice.on_reply = [handle](const Frame&, Frame& reply) {
        if (reply.command == Command::register_session) *handle = reply.session;
    };
    vice.on_request = [handle](Frame& request) {
        if (request.command == Command::send_rr_data) request.session = *handle;
        return Fate{};
    };
    return vice;
}

Vice never_leaves() {
    Vice vice;
    vice.on_request = [](Frame& request) {
        return request.command == Command::unregister_session ? Fate{Fate::Kind::drop, {}} : Fate{};
    };
    return vice;
}

// --------------------------------------------------------------------------------------------------------- packet

/// An item's type is not looked at.
Vice takes_any_item() {
    Vice vice;
    vice.on_request = [](Frame& request) {
        auto data = enip::SendData::parse(request.data);
        if (request.command != Command::send_rr_data || !data || data->packet.items.size() < 2) return Fate{};
        data->packet.items[1].type = enip::ItemType::unconnected_data;
        request.data = data->encode();
        return Fate{};
    };
    return vice;
}

Vice takes_two_items_only() {
    Vice vice;
    vice.on_request = [](Frame& request) {
        const auto data = enip::SendData::parse(request.data);
        if (request.command != Command::send_rr_data || !data || data->packet.items.size() <= 2) return Fate{};
        return Fate{Fate::Kind::answer, request.reply(EncapsulationStatus::incorrect_data)};
    };
    return vice;
}

// ----------------------------------------------------------------------------------------------------------- ucmm

Vice says_another_status(cip::GeneralStatus from, cip::GeneralStatus to) {
    Vice vice;
    vice.on_reply = [=](const Frame&, Frame& reply) {
        auto response = reply_in(reply);
        if (!response || response->status.general != from) return;
        response->status = to;
        put_reply(reply, *response);
    };
    return vice;
}

Vice puts_lengths_in_front() {
    return altering(identity, get_single, [](cip::Response& reply) {
        if (reply.status.ok()) reply.data.insert(reply.data.begin(), static_cast<std::uint8_t>(reply.data.size()));
    });
}

Vice swaps_parts() {
    return altering(0x02, 0x0A, [](cip::Response& reply) {
        if (reply.data.size() > 12) std::swap(reply.data[2], reply.data[4]);
    });
}

// --------------------------------------------------------------------------------------------------------- class 3

void change_count(Frame& frame, const std::function<std::uint16_t(std::uint16_t)>& change) {
    auto data = enip::SendData::parse(frame.data);
    if (frame.command != Command::send_unit_data || !data || data->packet.items.size() < 2) return;
    auto& item = data->packet.items[1].data;
    if (item.size() < 2) return;
    const auto count = change(static_cast<std::uint16_t>(item[0] | item[1] << 8));
    item[0] = static_cast<std::uint8_t>(count);
    item[1] = static_cast<std::uint8_t>(count >> 8);
    frame.data = data->encode();
}

/// Every request is new, whatever its sequence count.
Vice executes_twice() {
    Vice vice;
    const auto own = std::make_shared<std::uint16_t>(0);
    vice.on_request = [own](Frame& request) {
        change_count(request, [&](std::uint16_t) { return ++*own; });
        return Fate{};
    };
    vice.on_reply = [](const Frame& request, Frame& reply) {
        std::uint16_t asked = 0;
        auto copy = request;
        change_count(copy, [&](std::uint16_t count) { return asked = count; });
        change_count(reply, [&](std::uint16_t) { return asked; });
    };
    return vice;
}

Vice answers_with_count_zero() {
    Vice vice;
    vice.on_reply = [](const Frame&, Frame& reply) {
        change_count(reply, [](std::uint16_t) { return std::uint16_t{0}; });
    };
    return vice;
}

// --------------------------------------------------------------------------------------------------------- objects

Vice sets_reserved_bits(std::uint16_t class_id, std::size_t octet, std::uint8_t bits) {
    return altering(class_id, get_single, [=](cip::Response& reply) {
        if (reply.data.size() > octet) reply.data[octet] |= bits;
    });
}

Vice lists_another_vendor() {
    Vice vice;
    vice.on_reply = [](const Frame&, Frame& reply) {
        if (reply.command == Command::list_identity && reply.data.size() > 26) reply.data[24] ^= 1;
    };
    return vice;
}

Vice has_short_counters() {
    return altering(0xF6, get_single, [](cip::Response& reply) {
        if (reply.data.size() == 44) reply.data.resize(40);
    });
}

// ----------------------------------------------------------------------------------------------------- connections

/// The Forward_Open is altered before it is looked at, and the reply afterwards.
Vice opening(std::function<void(cip::ForwardOpen&)> change, std::function<void(cip::ForwardOpenReply&)> back = {}) {
    auto vice = requesting(connection_manager, forward_open, [=](cip::Request& request) {
        auto open = cip::ForwardOpen::parse(request.data, false);
        if (!open) return;
        change(*open);
        request.data = open->encode();
    });
    if (!back) return vice;
    vice.on_reply = altering(connection_manager, forward_open, [=](cip::Response& reply) {
                        auto grant = cip::ForwardOpenReply::parse(reply.data);
                        if (!reply.status.ok() || !grant) return;
                        back(*grant);
                        reply.data = grant->encode();
                    }).on_reply;
    return vice;
}

Vice ignores_keys() {
    return opening([](cip::ForwardOpen& open) {
        auto path = cip::Path::parse(open.path);
        if (!path || path->segments.empty()) return;
        if (auto* key = std::get_if<cip::ElectronicKey>(&path->segments.front())) *key = {};
        open.path = path->encode();
    });
}

Vice takes_any_size() {
    return opening([](cip::ForwardOpen& open) {
        if (open.transport.transport_class == 1) open.t_to_o.size = 30;
    });
}

Vice takes_few_multipliers() {
    return opening([](cip::ForwardOpen& open) {
        if (open.timeout_multiplier == 3) open.timeout_multiplier = 9;
    });
}

Vice opens_null() {
    return opening([](cip::ForwardOpen& open) {
        if (open.o_to_t.type != cip::ConnectionType::null || open.t_to_o.type != cip::ConnectionType::null) return;
        open.o_to_t.type = open.t_to_o.type = cip::ConnectionType::point_to_point;
        open.o_to_t.size = 2;
        open.t_to_o.size = 30;
    });
}

/// A refusal with this extended status becomes a grant.
Vice grants_instead_of(std::uint16_t word, std::uint8_t service) {
    Vice vice;
    vice.on_reply = [=](const Frame& request, Frame& reply) {
        const auto asked = request_in(request);
        auto response = reply_in(reply);
        if (!asked || !response || asked->service != service || response->status.extended.empty() ||
            response->status.extended.front() != word) {
            return;
        }
        response->status = {};
        if (service == forward_close) {
            response->data.resize(10);
        } else if (const auto open = cip::ForwardOpen::parse(asked->data, false)) {
            response->data = cip::ForwardOpenReply{.o_to_t_id = 0x11223344,
                                                   .t_to_o_id = open->t_to_o_id,
                                                   .triad = open->triad,
                                                   .o_to_t_api = open->o_to_t_rpi,
                                                   .t_to_o_api = open->t_to_o_rpi,
                                                   .application_reply = {}}
                                 .encode();
        }
        put_reply(reply, *response);
    };
    return vice;
}

Vice closes_only_in_words() {
    Vice vice;
    vice.on_request = [](Frame& frame) {
        const auto request = request_in(frame);
        if (!request || request->service != forward_close) return Fate{};
        const auto close = cip::ForwardClose::parse(request->data);
        if (!close) return Fate{};
        const cip::Response granted{forward_close, {}, cip::ForwardCloseReply{close->triad, {}}.encode()};
        return Fate{Fate::Kind::answer,
                    frame.reply(EncapsulationStatus::success, enip::SendData::unconnected(granted.encode()).encode())};
    };
    return vice;
}

Vice forgets_the_owner_bit() {
    return altering(identity, get_single, [](cip::Response& reply) {
        if (reply.data.size() == 2) reply.data[0] &= 0xFE;
    });
}

Vice sends_to_another_group() {
    Vice vice;
    vice.on_reply = [](const Frame&, Frame& reply) {
        auto data = enip::SendData::parse(reply.data);
        if (reply.command != Command::send_rr_data || !data) return;
        for (auto& item : data->packet.items) {
            if (item.type == enip::ItemType::sockaddr_t_to_o && item.data.size() == 16) item.data[6] ^= 0x40;
        }
        reply.data = data->encode();
    };
    return vice;
}

Vice sends_far() {
    Vice vice;
    vice.on_input_route = [](enip::IoRoute& route) { route.ttl = 32; };
    return vice;
}

// ------------------------------------------------------------------------------------------------------ production

Vice sends_at_double_interval() {
    return opening([](cip::ForwardOpen& open) { open.t_to_o_rpi *= 2; },
                   [](cip::ForwardOpenReply& reply) { reply.t_to_o_api /= 2; });
}

/// A number in a datagram, in place.
void change_number(cip::Bytes& datagram, std::size_t at, std::size_t octets,
                   const std::function<std::uint32_t(std::uint32_t)>& change) {
    if (datagram.size() < at + octets) return;
    std::uint32_t value = 0;
    for (std::size_t i = octets; i-- > 0;) value = value << 8 | datagram[at + i];
    value = change(value);
    for (std::size_t i = 0; i < octets; ++i, value >>= 8) datagram[at + i] = static_cast<std::uint8_t>(value);
}

constexpr std::size_t sequence_at = 10;
constexpr std::size_t count_at = 18;

Vice leaves_numbers_out() {
    Vice vice;
    vice.on_input = [](cip::Bytes& datagram) {
        change_number(datagram, sequence_at, 4, [](std::uint32_t n) { return 3 * n; });
    };
    return vice;
}

Vice counts_in_tens() {
    Vice vice;
    vice.on_input = [own = std::uint32_t{0}](cip::Bytes& datagram) mutable {
        change_number(datagram, count_at, 2, [&](std::uint32_t) { return own += 10; });
    };
    return vice;
}

Vice sends_surplus_data() {
    Vice vice;
    vice.on_input = [](cip::Bytes& datagram) {
        change_number(datagram, 16, 2, [](std::uint32_t size) { return size + 2; });
        datagram.resize(datagram.size() + 2);
    };
    return vice;
}

// -------------------------------------------------------------------------------------------------------- timeouts

Vice never_times_out() {
    return opening([](cip::ForwardOpen& open) { open.timeout_multiplier = 7; });
}

Vice times_out_early() {
    return opening([](cip::ForwardOpen& open) { open.o_to_t_rpi = std::max(open.o_to_t_rpi / 5, 1000U); },
                   [](cip::ForwardOpenReply& reply) { reply.o_to_t_api *= 5; });
}

/// Whatever number comes, it is new.
Vice takes_old_numbers() {
    Vice vice;
    const auto own = std::make_shared<std::uint32_t>(0);
    vice.on_output = [own](cip::Bytes& datagram) {
        change_number(datagram, sequence_at, 4, [&](std::uint32_t) { return ++*own; });
    };
    return vice;
}

/// Writing the inactivity timeout is granted and does nothing.
Vice forgets_the_inactivity_timeout() {
    Vice vice;
    const auto written = std::make_shared<cip::Bytes>();
    const auto is_it = [](const std::optional<cip::Request>& request, std::uint8_t service) {
        return request && request->service == service &&
               place_of(*request) == std::array<std::uint32_t, 3>{timeout_places, 1, 13};
    };
    vice.on_request = [=](Frame& frame) {
        const auto request = request_in(frame);
        const bool sets = is_it(request, set_single);
        if (!sets && !(is_it(request, get_single) && !written->empty())) return Fate{};
        if (sets) *written = request->data;
        const cip::Response reply{request->service, {}, sets ? cip::Bytes{} : *written};
        return Fate{Fate::Kind::answer,
                    frame.reply(EncapsulationStatus::success, enip::SendData::unconnected(reply.encode()).encode())};
    };
    return vice;
}

// ------------------------------------------------------------------------------------------------------- malformed

/// It dies of a list that says it is longer than it is.
Vice dies_of_a_list() {
    Vice vice;
    vice.on_request = [](Frame& frame) {
        const auto request = request_in(frame);
        const bool lies = request && request->service == 0x03 && request->data.size() < 6 && request->data.size() > 1 &&
                          request->data[0] == 0xFF;
        return lies ? Fate{Fate::Kind::die, {}} : Fate{};
    };
    return vice;
}

Vice dies_of_a_long_header() {
    Vice vice;
    vice.on_octets = [](cip::ByteView octets) { return octets.size() < 4 || octets[2] != 0xE7 || octets[3] != 0xFF; };
    return vice;
}

Vice loses_some_of_many() {
    Vice vice;
    vice.on_request = [count = 0](Frame& request) mutable {
        return request.command == Command::list_services && ++count == 150 ? Fate{Fate::Kind::drop, {}} : Fate{};
    };
    return vice;
}

// -----------------------------------------------------------------------------------------------------------------

struct Row {
    const char* caught_by;
    const char* name;
    Vice (*vice)();
};

void PrintTo(const Row& row, std::ostream* out) { *out << row.name << ", caught by " << row.caught_by; }

class BadServers : public testing::TestWithParam<Row> {};

TEST_P(BadServers, AreCaughtByTheRightCase) {
    const BadServer server(GetParam().vice());
    const auto run = scanner::test::run_scanner({"conformance", server.host(), "--allow-writes", "--timeout", "1.5",
                                                 "--case", GetParam().caught_by, "--json", "-"});
    EXPECT_EQ(run.code, 4) << run.out << run.err;
    const auto document = Json::parse(run.out, nullptr, false);
    ASSERT_FALSE(document.is_discarded()) << run.out;
    ASSERT_EQ(document["results"].size(), 1U);
    const auto& result = document["results"][0];
    EXPECT_EQ(result["id"], GetParam().caught_by);
    EXPECT_EQ(result["outcome"], "fail") << result.dump(2);
    EXPECT_FALSE(result["findings"].empty());
}

// clang-format off
const std::vector<Row> rows{
    {"ENC-08", "ZeroesTheContext", zeroes_the_context},
    {"ENC-13", "AnswersNops", answers_nops},
    {"ENC-15", "KnowsEveryCommand", knows_every_command},
    {"ENC-20", "IgnoresOptions", ignores_options},
    {"ENC-30", "LosesTheFifth", loses_the_fifth},
    {"ENC-04", "IsAnotherOverUdp", is_another_over_udp},
    {"SES-03", "TakesAnyVersion", takes_any_version},
    {"SES-10", "TakesAnyHandle", takes_any_handle},
    {"SES-13", "NeverLeaves", never_leaves},
    {"CPF-05", "TakesAnyItem", takes_any_item},
    {"CPF-17", "TakesTwoItemsOnly", takes_two_items_only},
    {"UCM-14", "SaysAnotherStatus", [] { return says_another_status(cip::GeneralStatus::path_destination_unknown, cip::GeneralStatus::service_not_supported); }},
    {"UCM-19", "GrantsUnknownAttributes", [] { return says_another_status(cip::GeneralStatus::attribute_not_supported, cip::GeneralStatus::success); }},
    {"UCM-01", "PutsLengthsInFront", puts_lengths_in_front},
    {"UCM-40", "SwapsParts", swaps_parts},
    {"CL3-03", "AnswersWithCountZero", answers_with_count_zero},
    {"CL3-05", "ExecutesTwice", executes_twice},
    {"IDE-09", "ListsAnotherVendor", lists_another_vendor},
    {"TCP-01", "SetsReservedBits", [] { return sets_reserved_bits(0xF5, 3, 0x80); }},
    {"ETH-03", "HasAGroupAsMacAddress", [] { return sets_reserved_bits(0xF6, 0, 0x01); }},
    {"ETH-05", "HasShortCounters", has_short_counters},
    {"KEY-08", "IgnoresKeys", ignores_keys},
    {"FWO-05", "TakesFewMultipliers", takes_few_multipliers},
    {"FWR-07", "TakesAnySize", takes_any_size},
    {"FWR-35", "OpensTwice", [] { return grants_instead_of(0x0100, forward_open); }},
    {"NUL-01", "OpensNull", opens_null},
    {"FCL-03", "ClosesTwice", [] { return grants_instead_of(0x0107, forward_close); }},
    {"FCL-12", "ClosesOnlyInWords", closes_only_in_words},
    {"OWN-01", "LetsListenToNobody", [] { return grants_instead_of(0x0119, forward_open); }},
    {"OWN-06", "LetsASecondOwnerIn", [] { return grants_instead_of(0x0106, forward_open); }},
    {"OWN-11", "ForgetsTheOwnerBit", forgets_the_owner_bit},
    {"MCA-02", "SendsToAnotherGroup", sends_to_another_group},
    {"MCA-04", "TellsAnotherGroup", sends_to_another_group},
    {"MCA-05", "SendsFar", sends_far},
    {"PRD-01", "SendsSurplusData", sends_surplus_data},
    {"PRD-02", "LeavesNumbersOut", leaves_numbers_out},
    {"PRD-03", "CountsInTens", counts_in_tens},
    {"PRD-04", "SendsAtDoubleInterval", sends_at_double_interval},
    {"TMO-04", "NeverTimesOut", never_times_out},
    {"TMO-05", "TimesOutEarly", times_out_early},
    {"TMO-08", "TakesOldNumbers", takes_old_numbers},
    {"INA-01", "ForgetsTheInactivityTimeout", forgets_the_inactivity_timeout},
    {"MAL-01", "DiesOfAList", dies_of_a_list},
    {"MAL-40", "DiesOfALongHeader", dies_of_a_long_header},
    {"MAL-47", "LosesSomeOfMany", loses_some_of_many},
};
// clang-format on

INSTANTIATE_TEST_SUITE_P(All, BadServers, testing::ValuesIn(rows), [](const auto& row) { return row.param.name; });

/// The same server without a vice passes each of these cases, so that it is the vice that is caught.
TEST(BadServer, WithoutAViceFailsNothing) {
    const BadServer server(Vice{});
    std::vector<std::string> words{"conformance", server.host(), "--allow-writes", "--json", "-"};
    for (const auto& row : rows) words.insert(words.end(), {"--case", row.caught_by});
    const auto run = scanner::test::run_scanner(words);
    EXPECT_EQ(run.code, 0) << run.err;
    const auto document = Json::parse(run.out, nullptr, false);
    ASSERT_FALSE(document.is_discarded()) << run.out;
    for (const auto& result : document["results"]) EXPECT_EQ(result["outcome"], "pass") << result.dump(2);
}

/// A device that dies in the middle does not drag the rest with it: they are skipped, and it is said why.
TEST(BadServer, ThatDiesEndsTheRun) {
    const BadServer server(dies_of_a_list());
    const auto run = scanner::test::run_scanner({"conformance", server.host(), "--timeout", "0.5", "--case", "MAL-01",
                                                 "--case", "MAL-02", "--case", "MAL-03", "--json", "-"});
    EXPECT_EQ(run.code, 4);
    const auto document = Json::parse(run.out, nullptr, false);
    ASSERT_FALSE(document.is_discarded()) << run.out;
    EXPECT_EQ(document["lost"], true);
    EXPECT_EQ(document["results"][0]["outcome"], "fail");
    EXPECT_EQ(document["results"][2]["outcome"], "skipped");
    EXPECT_EQ(document["results"][2]["reason"], "the device has not answered since MAL-01");
}

/// What a run without leave sends: nothing that writes, resets or owns.
TEST(ReadOnly, NeitherWritesNorOwns) {
    std::vector<std::string> wrong;
    std::mutex mutex;
    std::size_t requests = 0;
    Vice watch;
    watch.on_request = [&](Frame& frame) {
        const std::lock_guard lock(mutex);
        auto request = request_in(frame);
        // Whatever is wrapped up counts too.
        for (int depth = 0; request && depth < 3; ++depth) {
            ++requests;
            constexpr std::array<std::uint8_t, 4> writing{0x02, 0x04, 0x05, 0x10};
            const auto service = request->service;
            if (std::ranges::find(writing, service) != writing.end())
                wrong.push_back(cip::service::name(service, 0).data());
            if (service == 0x54 || service == 0x5B) {
                const auto open = cip::ForwardOpen::parse(request->data, service == 0x5B);
                if (open && open->transport.transport_class == 1 && open->o_to_t.size > 8)
                    wrong.push_back("a Forward_Open of outputs");
            }
            if (service != 0x52 || request->data.size() < 6) break;
            const auto inner = cip::Request::parse(cip::ByteView(request->data).subspan(4));
            request = inner ? std::optional(*inner) : std::nullopt;
        }
        return Fate{};
    };
    const BadServer server(watch);
    std::vector<std::string> words{"conformance", server.host(), "--json", "-"};
    for (const auto* group : {"encapsulation", "sessions", "packet", "ucmm", "class3", "objects", "keys",
                              "forward-open", "null-open", "forward-close", "ownership", "multicast", "malformed"}) {
        words.insert(words.end(), {"--group", group});
    }
    const auto run = scanner::test::run_scanner(words);
    EXPECT_EQ(run.code, 0) << run.err;
    const std::lock_guard lock(mutex);
    EXPECT_GT(requests, 500U);
    EXPECT_TRUE(wrong.empty()) << wrong.size() << ", the first is " << wrong.front();
}

}  // namespace
}  // namespace servobus::test
