// The objects that every device has: Identity, Message Router, Assembly, Connection Manager (R-ID, R-MR, R-ASM, R-CM).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <set>

#include "cip/connection_data.hpp"
#include "cip/hex.hpp"
#include "cip/services.hpp"
#include "cip/strings.hpp"
#include "enip/asio/discovery.hpp"
#include "scanner/conformance/attribute.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"
#include "scanner/conformance/class3_link.hpp"
#include "scanner/conformance/io_link.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner::conformance {
namespace {

constexpr std::uint16_t identity = 0x01;
constexpr std::uint16_t message_router = 0x02;
constexpr std::uint16_t assembly = 0x04;
constexpr std::uint16_t connection_manager = 0x06;
constexpr auto needed = Presence::required;
constexpr auto if_there = Presence::optional;

// ------------------------------------------------------------------------------------------------------------ Identity

std::string revision(cip::Reader& value) {
    const auto major = value.u8();
    const auto minor = value.u8();
    if (major == 0 || minor == 0) return fmt::format("revision {}.{}: 0 is not legal", major, minor);
    return major > 127 ? fmt::format("major revision {}; the highest is 127", major) : "";
}

std::string identity_status(cip::Reader& value) {
    constexpr unsigned reserved = 0xF00A;
    const unsigned status = value.u16();
    if ((status & reserved) != 0) return fmt::format("status 0x{:04X}: bits 1, 3 and 12 to 15 are reserved", status);
    const auto extended = status >> 4 & 0xF;
    return extended > 7 ? fmt::format("extended device status {}; above 7 nothing is defined", extended) : "";
}

std::string product_name(cip::Reader& value) {
    const auto name = cip::read_short_string(value);
    constexpr std::size_t longest = 32;
    if (name.empty()) return "it is empty";
    if (name.size() > longest) return fmt::format("it has {} characters; 32 are allowed", name.size());
    const bool printable = std::ranges::all_of(name, [](char c) { return static_cast<unsigned char>(c) >= 0x20; });
    return printable ? "" : "it has characters that cannot be printed";
}

void identity_state(Bench& bench) {
    check_value(bench, {identity, 1, 8}, if_there, 1, [](cip::Reader& value) {
        const auto state = value.u8();
        return state <= 5 || state == 0xFF ? "" : fmt::format("state {}; above 5 nothing is defined", state);
    });
}

void says_the_same(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto listed = session.wire().exchange(make_frame(bench, enip::Command::list_identity));
    if (!listed) return;
    const auto item = enip::asio::read_identity_reply(*listed);
    if (!bench.require(item.has_value(), "the identity item cannot be read")) return;
    const auto compare = [&](std::uint16_t id, const cip::Bytes& expected, std::string_view what) {
        const auto value = read(session, {identity, 1, id}, needed);
        if (value)
            bench.require(*value == expected, fmt::format("the {} is {} in ListIdentity and {} in the object", what,
                                                          cip::to_hex(expected), cip::to_hex(*value)));
    };
    compare(1, u16(item->vendor), "vendor");
    compare(2, u16(item->device_type), "device type");
    compare(3, u16(item->product_code), "product code");
    compare(4, {item->major_revision, item->minor_revision}, "revision");
    compare(6, u32(item->serial_number), "serial number");
    cip::Bytes name;
    cip::Writer writer(name);
    cip::write_short_string(writer, item->product_name);
    compare(7, name, "product name");
}

void agrees_with_status(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto status = read(session, {identity, 1, 5}, needed);
    const auto listed = session.wire().exchange(make_frame(bench, enip::Command::list_identity));
    if (!status || status->size() != 2 || !listed) return;
    const auto item = enip::asio::read_identity_reply(*listed);
    if (!item) return;
    // From one request to the next a drive may change.
    const auto again = read(session, {identity, 1, 5}, needed);
    const bool either = u16(item->status) == *status || (again && u16(item->status) == *again);
    bench.require(either, fmt::format("the status is 0x{:04X} in ListIdentity and {} in the object", item->status,
                                      cip::to_hex(*status)));
    const auto state = peek(session, {identity, 1, 8});
    if (state && state->size() == 1) {
        bench.require(item->state == (*state)[0],
                      fmt::format("the state is {} in ListIdentity and {} in the object", item->state, (*state)[0]));
    }
}

// ------------------------------------------------------------------------------------------------------ Message Router

void object_list(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto value = read(session, {message_router, 1, 1}, if_there);
    if (!value) return;
    cip::Reader reader(*value);
    const auto count = reader.u16();
    std::set<std::uint16_t> classes;
    for (int i = 0; i < count && reader.ok(); ++i) classes.insert(reader.u16());
    if (!bench.require(reader.done(), fmt::format("{} octets are not a count and {} classes", value->size(), count)))
        return;
    bench.require(classes.size() == count, "a class is listed twice");
    for (const auto each : {identity, message_router, connection_manager}) {
        bench.require(classes.contains(each), fmt::format("class 0x{:02X} is not listed", each));
    }
    for (const auto each : classes) {
        const auto reply = session.call(get_request({each, 0, 1}));
        if (!reply) return;
        const bool absent = reply->response.status.general == cip::GeneralStatus::path_destination_unknown;
        bench.require(!absent, fmt::format("class 0x{:02X} is listed and not there", each));
    }
}

void connections_of_router(Bench& bench) {
    check_value(bench, {message_router, 1, 2}, if_there, 2,
                [](cip::Reader& value) { return value.u16() > 0 ? "" : "no connections at all"; });
}

void router_class(Bench& bench) { check_class(bench, message_router, 1, 1, if_there); }

// ------------------------------------------------------------------------------------------------------------ Assembly

/// Each pair of point and octets that a connection of the device has, in one direction.
template <class Then>
void each_assembly(Bench& bench, bool inputs, Then then) {
    std::set<std::uint32_t> seen;
    for (const auto& each : bench.subject().options().candidates) {
        const auto& direction = inputs ? each.plan.t_to_o : each.plan.o_to_t;
        const bool has_data = direction.format != cip::RealTimeFormat::heartbeat && direction.data_octets > 0;
        if (each.plan.application_path || !has_data || direction.variable || !seen.insert(direction.point).second)
            continue;
        then(static_cast<std::uint16_t>(direction.point), direction.data_octets);
    }
    if (seen.empty()) bench.skip("no connection of the device is known; give --eds");
}

void assembly_data(Bench& bench, bool inputs) {
    Session session(bench);
    if (!session.is_open()) return;
    each_assembly(bench, inputs, [&](std::uint16_t point, std::size_t octets) {
        const auto data = read(session, {assembly, point, 3}, needed);
        if (data)
            bench.require(data->size() == octets, fmt::format("assembly {} has {} octets; a connection to it has {}",
                                                              point, data->size(), octets));
    });
}

void assembly_sizes(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    for (const bool inputs : {true, false}) {
        each_assembly(bench, inputs, [&](std::uint16_t point, std::size_t octets) {
            const auto size = read(session, {assembly, point, 4}, if_there);
            if (!size) return;
            bench.require(
                *size == u16(static_cast<std::uint32_t>(octets)),
                fmt::format("assembly {} says {} where a connection has {} octets", point, cip::to_hex(*size), octets));
        });
    }
}

void unknown_assembly(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    std::set<std::uint32_t> points;
    for (const auto& each : bench.subject().options().candidates) {
        points.insert({each.plan.o_to_t.point, each.plan.t_to_o.point, each.plan.configuration_instance.value_or(0)});
    }
    std::uint16_t unknown = 0x03E7;
    while (points.contains(unknown)) ++unknown;
    refused(bench, session.call(get_request({assembly, unknown, 3})), {0x05}, {}, Weight::any);
}

void set_inputs(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    each_assembly(bench, true, [&](std::uint16_t point, std::size_t) {
        const auto data = read(session, {assembly, point, 3}, needed);
        if (data)
            refused(bench, session.call(set_request({assembly, point, 3}, *data)), {0x0E, 0x08}, {}, Weight::soft);
    });
}

void set_outputs_of_wrong_length(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    each_assembly(bench, false, [&](std::uint16_t point, std::size_t) {
        auto data = read(session, {assembly, point, 3}, needed);
        if (!data || data->empty()) return;
        const auto shorter = cip::ByteView(*data).first(data->size() - 1);
        const auto first = session.call(set_request({assembly, point, 3}, shorter));
        refused(bench, first, {0x13, 0x0E, 0x08}, {0x15}, Weight::any);
        data->push_back(0);
        refused(bench, session.call(set_request({assembly, point, 3}, *data)), {0x15, 0x0E, 0x08}, {0x13}, Weight::any);
    });
}

// -------------------------------------------------------------------------------------------------- Connection Manager

void counters(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    std::size_t there = 0;
    for (std::uint16_t id = 1; id <= 8; ++id) {
        const auto value = peek(session, {connection_manager, 1, id});
        if (!value) continue;
        ++there;
        bench.require(value->size() == 2, fmt::format("counter {} has {} octets and not 2", id, value->size()));
    }
    if (there == 0) bench.skip("the Connection Manager has no counters");
}

void open_is_counted(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto before = read(session, {connection_manager, 1, 1}, if_there);
    if (!before || before->size() != 2) return;
    auto open = class3_open(bench);
    open.path = hex("20 C7 24 01");
    static_cast<void>(try_open(session, open));
    const auto after = read(session, {connection_manager, 1, 1}, needed);
    if (!after || after->size() != 2) return;
    const auto grown = static_cast<std::uint16_t>(cip::Reader(*after).u16() - cip::Reader(*before).u16());
    // Others may open too.
    bench.advise(grown >= 1, "a Forward_Open is not counted in attribute 1");
}

void entry_list(Bench& bench) {
    check_whole(bench, {connection_manager, 1, 9}, if_there, [](cip::Reader& value) -> std::string {
        const std::size_t bits = value.u16();
        const auto octets = value.take((bits + 7) / 8);
        return octets.empty() && bits > 0 ? fmt::format("{} bits are announced", bits) : "";
    });
}

void processor_use(Bench& bench) {
    check_value(bench, {connection_manager, 1, 11}, if_there, 2, [](cip::Reader& value) {
        const auto tenths = value.u16();
        return tenths <= 1000 ? "" : fmt::format("{} tenths of a percent", tenths);
    });
}

void buffers(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto whole = read(session, {connection_manager, 1, 12}, if_there);
    const auto left = read(session, {connection_manager, 1, 13}, if_there);
    if (!whole || !left) return;
    const bool sized = whole->size() == 4 && left->size() == 4;
    if (!bench.require(sized, "attributes 12 and 13 have four octets")) return;
    bench.require(cip::Reader(*left).u32() <= cip::Reader(*whole).u32(), "more buffer is left than there is");
}

void unknown_connection_data(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto reply = session.call(hex("56 02 20 06 24 01 FE FF"));
    if (is_unsupported(reply)) return bench.skip("the Connection Manager does not offer Get_Connection_Data");
    refused(bench, reply, {0x05}, {}, Weight::any);
}

void search_connection(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    Class3Link link(session);
    if (!link.is_open()) return;
    const auto& triad = link.request().triad;
    const auto reply = session.call(join({hex("57 02 20 06 24 01"), u16(triad.serial_number),
                                          u16(triad.originator_vendor), u32(triad.originator_serial)}));
    if (is_unsupported(reply)) return bench.skip("the Connection Manager does not offer Search_Connection_Data");
    if (!granted(bench, reply)) return;
    const auto data = cip::ConnectionData::parse(reply->response.data);
    if (!bench.require(data.has_value(), fmt::format("{} octets and not 56", reply->response.data.size()))) return;
    bench.require(data->triad == triad, "another connection is told");
    bench.require(data->o_to_t_rpi == link.request().o_to_t_rpi,
                  fmt::format("an O->T interval of {} us is told, and {} us was asked", data->o_to_t_rpi,
                              link.request().o_to_t_rpi));
    bench.require(data->t_to_o_id_at_originator == link.request().t_to_o_id ||
                      data->t_to_o_id_at_target == link.request().t_to_o_id,
                  "the T->O id of the connection is not told");
}

constexpr auto O = Group::objects;
constexpr auto R = Manner::reads;
constexpr auto W = Manner::writes;

// clang-format off
constexpr std::array cases{
    Case{"IDE-01", O, "Identity 1 is a vendor", "R-ID-1", "UINT, never 0.", R, [](Bench& b) { check_value(b, {identity, 1, 1}, needed, 2, [](cip::Reader& v) { return v.u16() != 0 ? "" : "vendor 0"; }); }},
    Case{"IDE-02", O, "Identity 2 is a device type", "R-ID-1", "UINT.", R, [](Bench& b) { check_value(b, {identity, 1, 2}, needed, 2); }},
    Case{"IDE-03", O, "Identity 3 is a product code", "R-ID-1", "UINT, never 0.", R, [](Bench& b) { check_value(b, {identity, 1, 3}, needed, 2, [](cip::Reader& v) { return v.u16() != 0 ? "" : "product code 0"; }); }},
    Case{"IDE-04", O, "Identity 4 is a revision", "R-ID-1", "USINT major 1 to 127, USINT minor 1 to 255.", R, [](Bench& b) { check_value(b, {identity, 1, 4}, needed, 2, revision); }},
    Case{"IDE-05", O, "Identity 5 is a status", "R-ID-3", "WORD; bits 1, 3 and 12 to 15 are 0, the extended device status is at most 7.", R, [](Bench& b) { check_value(b, {identity, 1, 5}, needed, 2, identity_status); }},
    Case{"IDE-06", O, "Identity 6 is a serial number", "R-ID-1", "UDINT, unique, never 0.", R, [](Bench& b) { check_value(b, {identity, 1, 6}, needed, 4, [](cip::Reader& v) { return v.u32() != 0 ? "" : "serial number 0"; }); }},
    Case{"IDE-07", O, "Identity 7 is a product name", "R-ID-1", "SHORT_STRING of at most 32 characters.", R, [](Bench& b) { check_whole(b, {identity, 1, 7}, needed, product_name); }},
    Case{"IDE-08", O, "Identity 8 is a state", "R-ID-5", "USINT from 0 to 5, where it is there.", R, identity_state},
    Case{"IDE-09", O, "ListIdentity and Identity agree", "R-ID-7", "Attributes 1 to 7 are what ListIdentity says.", R, says_the_same},
    Case{"IDE-10", O, "ListIdentity and Identity agree about status and state", "R-ID-7", "Attributes 5 and 8 are what ListIdentity says.", R, agrees_with_status},
    Case{"IDE-11", O, "Class attributes of Identity", "R-OBJ-1", "UINTs; revision 1 or 2.", R, [](Bench& b) { check_class(b, identity, 1, 2, needed); }},
    Case{"IDE-12", O, "Identity has no attribute 0", "R-ERR-5", "Status 0x14.", R, [](Bench& b) { Session s(b); if (s.is_open()) refused(b, s.call(hex("0E 03 20 01 24 01 30 00")), {0x14}, {}, Weight::any); }},
    Case{"IDE-13", O, "Identity 7 cannot be written", "R-ID-2", "Status 0x08, or 0x0E.", W, [](Bench& b) { check_refused_set(b, {identity, 1, 7}, hex("01 41"), {0x08, 0x0E}); }},
    Case{"MRO-01", O, "The object list has the objects", "R-MR-1", "UINT count and as many classes, each of which is there.", R, object_list},
    Case{"MRO-02", O, "The number of connections is a UINT", "R-MR-1", "UINT, where it is there.", R, connections_of_router},
    Case{"MRO-03", O, "Class attributes of the Message Router", "R-OBJ-1", "UINTs; revision 1.", R, router_class},
    Case{"MRO-04", O, "The Message Router has one instance", "R-ERR-3", "Instance 2 is answered 0x05.", R, [](Bench& b) { Session s(b); if (s.is_open()) refused(b, s.call(hex("0E 03 20 02 24 02 30 01")), {0x05}, {}, Weight::any); }},
    Case{"ASM-01", O, "Input assemblies have the size of their connections", "R-ASM-2", "Attribute 3 is the data of the assembly, as long as that of a connection to it.", R, [](Bench& b) { assembly_data(b, true); }},
    Case{"ASM-02", O, "Output assemblies have the size of their connections", "R-ASM-2", "Attribute 3 is the data of the assembly, as long as that of a connection to it.", R, [](Bench& b) { assembly_data(b, false); }},
    Case{"ASM-03", O, "Assemblies tell their size", "R-ASM-3", "Attribute 4 is a UINT, the octets of attribute 3.", R, assembly_sizes},
    Case{"ASM-04", O, "An assembly that is not there", "R-ASM-6", "Status 0x05.", R, unknown_assembly},
    Case{"ASM-05", O, "Class attributes of Assembly", "R-OBJ-1", "UINTs; revision 1 or 2.", R, [](Bench& b) { check_class(b, assembly, 1, 2, if_there); }},
    Case{"ASM-06", O, "Input assemblies cannot be written", "R-ASM-5", "Status 0x0E; some stacks take it.", W, set_inputs},
    Case{"ASM-07", O, "Outputs of a wrong length are refused", "R-ASM-4", "One octet short 0x13, one too many 0x15.", W, set_outputs_of_wrong_length},
    Case{"CMG-01", O, "Counters of the Connection Manager", "R-CM-2", "Attributes 1 to 8 are UINTs, where they are there.", R, counters},
    Case{"CMG-02", O, "A Forward_Open is counted", "R-CM-3", "Attribute 1 counts every Forward_Open.", R, open_is_counted},
    Case{"CMG-03", O, "The connection entry list", "R-CM-2", "Attribute 9 is a number of bits and as many bits.", R, entry_list},
    Case{"CMG-04", O, "The use of the processor", "R-CM-2", "Attribute 11 is in tenths of a percent.", R, processor_use},
    Case{"CMG-05", O, "Buffers", "R-CM-2", "Of the octets in attribute 12 those in attribute 13 are left.", R, buffers},
    Case{"CMG-06", O, "Data of a connection that is not there", "R-CM-7", "Get_Connection_Data answers 0x05.", R, unknown_connection_data},
    Case{"CMG-07", O, "A connection is found by its triad", "R-CM-7", "Search_Connection_Data tells what was opened.", R, search_connection},
    Case{"CMG-08", O, "Class attributes of the Connection Manager", "R-OBJ-1", "UINTs; revision 1.", R, [](Bench& b) { check_class(b, connection_manager, 1, 1, needed); }},
    Case{"CMG-09", O, "A counter takes nothing but 0", "R-CM-2", "Any other value is answered 0x09.", W, [](Bench& b) { check_refused_set(b, {connection_manager, 1, 8}, hex("05 00"), {0x09, 0x0E, 0x08}); }},
};
// clang-format on

}  // namespace

std::span<const Case> object_cases() { return cases; }

}  // namespace servobus::scanner::conformance
