// The objects of the network side: TCP/IP Interface, Ethernet Link, QoS, DLR, Port, File, Time Sync (R-TCP, R-ETH, R-QOS,
// R-DLR, R-PRT, R-FIL, R-TSY).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <thread>

#include "cip/file_transfer.hpp"
#include "cip/hex.hpp"
#include "cip/path.hpp"
#include "cip/strings.hpp"
#include "scanner/conformance/attribute.hpp"
#include "scanner/conformance/bench.hpp"
#include "scanner/conformance/case_tables.hpp"

namespace servobus::scanner::conformance {
namespace {

constexpr std::uint16_t tcp_ip = 0xF5;
constexpr std::uint16_t ethernet_link = 0xF6;
constexpr std::uint16_t qos = 0x48;
constexpr std::uint16_t ring = 0x47;
constexpr std::uint16_t port = 0xF4;
constexpr std::uint16_t file = 0x37;
constexpr std::uint16_t time_sync = 0x43;
constexpr auto needed = Presence::required;
constexpr auto if_there = Presence::optional;

std::string at_most(unsigned value, unsigned most) {
    return value <= most ? "" : fmt::format("{}; the highest is {}", value, most);
}
std::string no_bits(std::uint32_t value, std::uint32_t reserved) {
    return (value & reserved) == 0 ? "" : fmt::format("0x{:08X}: bits 0x{:08X} are reserved", value, reserved);
}
std::string either(std::string first, std::string second) {
    return first.empty() ? std::move(second) : std::move(first);
}

// -------------------------------------------------------------------------------------------------------------- TCP/IP

std::string tcp_status(cip::Reader& v) {
    const auto status = v.u32();
    constexpr std::uint32_t reserved = 0xFFFFFC00;
    return either(no_bits(status, reserved), at_most(status & 0xF, 2));
}

std::string tcp_control(cip::Reader& v) {
    const auto control = v.u32();
    constexpr std::uint32_t reserved = 0xFFFFFFE0;
    return either(no_bits(control, reserved), at_most(control & 0xF, 2));
}

/// What is asked for must be among what it can do.
void control_is_capable(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto capability = read(session, {tcp_ip, 1, 2}, needed);
    const auto control = read(session, {tcp_ip, 1, 3}, needed);
    if (!capability || !control || capability->size() != 4 || control->size() != 4) return;
    const auto can = cip::Reader(*capability).u32();
    const auto method = cip::Reader(*control).u32() & 0xF;
    constexpr std::uint32_t bootp = 1;
    constexpr std::uint32_t dhcp = 4;
    bench.require(method != 1 || (can & bootp) != 0,
                  "the address is to come by BOOTP, which the device says it cannot");
    bench.require(method != 2 || (can & dhcp) != 0, "the address is to come by DHCP, which the device says it cannot");
}

void physical_link(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto value = read(session, {tcp_ip, 1, 4}, needed);
    if (!value) return;
    cip::Reader reader(*value);
    const auto words = reader.u16();
    const auto octets = reader.take(words * std::size_t{2});
    if (!bench.require(reader.done(), fmt::format("{} octets are not a size in words and a path", value->size())))
        return;
    if (words == 0) return;  // several ports, and none of them is the one
    const auto path = cip::Path::parse(octets);
    if (!bench.require(path.has_value(), fmt::format("the path {} cannot be read", cip::to_hex(octets)))) return;
    bench.advise(octets.size() == 4 && octets[0] == 0x20 && octets[1] == ethernet_link,
                 fmt::format("the path {} does not lead to the Ethernet Link object", cip::to_hex(octets)));
    if (octets.size() != 4) return;
    const auto reply = session.call(join({hex("0E 03"), octets, hex("30 01")}));
    granted(bench, reply);
}

std::string interface_configuration(cip::Reader& v) {
    const auto address = v.u32();
    const auto mask = v.u32();
    const auto gateway = v.u32();
    v.take(8);
    const auto domain = cip::read_string(v);
    if (domain.size() % 2 != 0) v.take(1);
    if (!v.ok()) return "it is too short";
    constexpr std::size_t longest_domain = 48;
    if (domain.size() > longest_domain) return fmt::format("a domain of {} characters", domain.size());
    const auto hosts = ~mask;
    if ((hosts & (hosts + 1)) != 0) return fmt::format("the mask 0x{:08X} has a gap", mask);
    if (gateway != 0 && ((gateway ^ address) & mask) != 0) return "the gateway is in another subnet";
    return {};
}

void own_address(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto value = read(session, {tcp_ip, 1, 5}, needed);
    if (!value || value->size() < 4) return;
    const auto address = cip::Reader(*value).u32();
    bench.advise(address == bench.subject().address.address,
                 fmt::format("the device says {} and was called at {}: a translation on the way?",
                             enip::address_text(address), enip::address_text(bench.subject().address.address)));
}

std::string host_name(cip::Reader& v) {
    const auto name = cip::read_string(v);
    if (name.size() % 2 != 0) v.take(1);
    constexpr std::size_t longest = 64;
    return name.size() <= longest ? "" : fmt::format("{} characters", name.size());
}

std::string multicast(cip::Reader& v) {
    const unsigned control = v.u8();
    const unsigned reserved = v.u8();
    const auto count = v.u16();
    const auto start = v.u32();
    if (control > 1) return fmt::format("allocation control {}", control);
    if (reserved != 0) return "the reserved octet is not 0";
    if (count == 0) return "no groups";
    return enip::is_multicast(start) ? "" : fmt::format("{} is no multicast address", enip::address_text(start));
}

/// The whole of a value that must not be written, with another value in it.
void set_tcp(Bench& bench, std::uint16_t id, std::string_view value, std::initializer_list<Code> right,
             std::initializer_list<Code> tolerated = {}) {
    check_refused_set(bench, {tcp_ip, 1, id}, hex(value), right, tolerated);
}

void too_long_host_name(Bench& bench) {
    auto value = u16(66);
    value.resize(2 + 66, 'a');
    check_refused_set(bench, {tcp_ip, 1, 6}, value, {0x15, 0x09});
}

void write_inactivity(Bench& bench) { check_write_back(bench, {tcp_ip, 1, 13}); }

// ------------------------------------------------------------------------------------------------------- Ethernet Link

std::string link_flags(cip::Reader& v) {
    const auto flags = v.u32();
    constexpr std::uint32_t reserved = 0xFFFFFF80;
    return either(no_bits(flags, reserved), at_most(flags >> 2 & 7, 4));
}

std::string mac_address(cip::Reader& v) {
    const auto octets = v.take(6);
    if (octets.size() != 6) return "it is too short";
    if ((octets[0] & 1) != 0) return "a multicast address";
    const bool zero = std::ranges::all_of(octets, [](std::uint8_t octet) { return octet == 0; });
    return zero ? "it is zero" : "";
}

void speed_and_link(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto speed = read(session, {ethernet_link, 1, 1}, needed);
    const auto flags = read(session, {ethernet_link, 1, 2}, needed);
    if (!speed || !flags || speed->size() != 4 || flags->size() != 4) return;
    const bool up = (cip::Reader(*flags).u32() & 1) != 0;
    const auto rate = cip::Reader(*speed).u32();
    bench.advise(!up || rate != 0, "the link is up, and its speed is 0");
    constexpr std::array<std::uint32_t, 9> usual{0, 10, 100, 1000, 2500, 5000, 10'000, 25'000, 40'000};
    bench.advise(std::ranges::find(usual, rate) != usual.end(), fmt::format("a speed of {} Mbit/s", rate));
}

void counters_count(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto before = read(session, {ethernet_link, 1, 4}, if_there);
    if (!before || before->size() < 28) return;
    const auto at = [](const cip::Bytes& value, std::size_t index) {
        cip::Reader reader(value);
        reader.take(index * 4);
        return reader.u32();
    };
    constexpr std::size_t in_octets = 0;
    constexpr std::size_t out_octets = 6;
    // Some devices look at their counters once a second.
    constexpr int looks = 20;
    for (int i = 0; i < looks; ++i) {
        const auto after = read(session, {ethernet_link, 1, 4}, needed);
        if (!after || after->size() != before->size()) return;
        if (at(*after, in_octets) != at(*before, in_octets) && at(*after, out_octets) != at(*before, out_octets))
            return;
        std::this_thread::sleep_for(milliseconds(100));
    }
    // The counters may be those of a switch port that this traffic does not pass.
    bench.advise(false, "requests and replies of two seconds do not show in the octets that are counted");
}

std::string interface_control(cip::Reader& v) {
    const auto bits = v.u16();
    const auto speed = v.u16();
    if ((bits & 0xFFFC) != 0) return fmt::format("0x{:04X}: bits 2 to 15 are reserved", bits);
    static_cast<void>(speed);
    return {};
}

std::string link_capability(cip::Reader& v) {
    const auto bits = v.u32();
    const auto count = v.u8();
    for (unsigned i = 0; i < count; ++i) {
        v.u16();
        if (const unsigned duplex = v.u8(); v.ok() && duplex > 1) return fmt::format("duplex {}", duplex);
    }
    return no_bits(bits, 0xFFFFFFF0);
}

void second_port(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    if (!has_instance(session, ethernet_link, 2)) return bench.skip("the device has one port");
    const auto first = read(session, {ethernet_link, 1, 3}, needed);
    const auto second = read(session, {ethernet_link, 2, 3}, needed);
    if (!first || !second) return;
    bench.advise(*first == *second, "the ports of a switch have different MAC addresses");
    const auto label = peek(session, {ethernet_link, 1, 10});
    const auto other = peek(session, {ethernet_link, 2, 10});
    if (label && other) bench.require(*label != *other, "two ports have the same label");
}

// ----------------------------------------------------------------------------------------------------------------- QoS

void dscp(Bench& bench, std::uint16_t id) {
    check_value(bench, {qos, 1, id}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 63); });
}

// ---------------------------------------------------------------------------------------------------------------- DLR

void ring_agrees(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto topology = read(session, {ring, 1, 1}, if_there);
    const auto supervisor = read(session, {ring, 1, 10}, if_there);
    if (!topology || !supervisor || topology->size() != 1 || supervisor->size() != 10) return;
    const bool known = std::ranges::any_of(*supervisor, [](std::uint8_t octet) { return octet != 0; });
    bench.advise((*topology)[0] != 0 || !known, "there is no ring, and it has a supervisor");
}

// --------------------------------------------------------------------------------------------------------------- Port

void ports(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto all = read(session, {port, 0, 9}, if_there);
    const auto entry = read(session, {port, 0, 8}, if_there);
    if (!all || !entry) return;
    if (!bench.require(all->size() % 4 == 0 && entry->size() == 2,
                       "class attribute 9 has four octets for each port, 8 has two"))
        return;
    cip::Reader reader(*all);
    const auto wanted = cip::Reader(*entry).u16();
    bool found = false;
    for (std::size_t i = 0; reader.remaining() > 0; ++i) {
        const auto type = reader.u16();
        const auto number = reader.u16();
        if (i == 0) bench.require(type == 0 && number == 0, "the first entry of class attribute 9 is not zero");
        found = found || (i > 0 && i == wanted);
    }
    bench.require(found, fmt::format("the entry port {} is not among the ports", wanted));
}

void port_link(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto value = read(session, {port, 1, 3}, if_there);
    if (!value) return;
    cip::Reader reader(*value);
    const auto words = reader.u16();
    const auto path = reader.take(words * std::size_t{2});
    if (!bench.require(reader.done(), fmt::format("{} octets are not a size in words and a path", value->size())))
        return;
    if (path.empty()) return;
    bench.require(cip::Path::parse(path).has_value(), fmt::format("the path {} cannot be read", cip::to_hex(path)));
}

// ---------------------------------------------------------------------------------------------------------------- File

constexpr std::uint16_t sheet = 0xC8;

std::string stringi(cip::Reader& v) {
    const auto strings = cip::read_stringi(v);
    return v.ok() && !strings.empty() ? "" : "it is no STRINGI";
}

/// One packet of an upload: number, type, data.
struct Packet {
    std::uint8_t number = 0;
    std::uint8_t type = 0;
    cip::Bytes data;
};

std::optional<Packet> packet_of(Bench& bench, const std::optional<Reply>& reply) {
    if (!granted(bench, reply)) return std::nullopt;
    cip::Reader reader(reply->response.data);
    Packet packet;
    packet.number = reader.u8();
    packet.type = reader.u8();
    if (!bench.require(reader.ok(), "the reply has no packet number and type")) return std::nullopt;
    const auto data = reader.take_rest();
    packet.data.assign(data.begin(), data.end());
    return packet;
}

std::optional<Reply> start_upload(Session& session, std::uint8_t transfer_size) {
    auto reply = session.call(join({hex("4B 02 20 37 24 C8"), std::array{transfer_size}}));
    if (!reply) return std::nullopt;
    const auto general = reply->response.status.general;
    if (general == cip::GeneralStatus::path_destination_unknown ||
        general == cip::GeneralStatus::object_does_not_exist || general == cip::GeneralStatus::service_not_supported) {
        session.bench().skip("the device keeps no data sheet");
        return std::nullopt;
    }
    return reply;
}

std::optional<Reply> transfer(Session& session, std::uint8_t number) {
    return session.call(join({hex("4F 02 20 37 24 C8"), std::array{number}}));
}

void upload(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    constexpr std::uint8_t wanted = 250;
    const auto begun = start_upload(session, wanted);
    if (!begun || !granted(bench, begun)) return;
    cip::Reader head(begun->response.data);
    const auto size = head.u32();
    const auto transfer_size = head.u8();
    if (!bench.require(head.ok() && transfer_size > 0 && transfer_size <= wanted,
                       "the reply is not a file size and a transfer size of at most 250"))
        return;
    constexpr std::uint32_t largest = 4 * 1024 * 1024;
    if (size > largest) return bench.skip(fmt::format("a file of {} octets takes too long", size));
    std::uint32_t received = 0;
    std::uint16_t sum = 0;
    for (std::uint32_t i = 0; i <= size / transfer_size + 1; ++i) {
        const auto number = static_cast<std::uint8_t>(i);
        const auto packet = packet_of(bench, transfer(session, number));
        if (!packet) return;
        if (!bench.require(packet->number == number,
                           fmt::format("packet {} was asked for, and {} came", number, packet->number)))
            return;
        const bool last = packet->type == 2 || packet->type == 4;
        const bool first = packet->type == 0 || packet->type == 4;
        if (!bench.require(packet->type != 3, "the device aborts the transfer")) return;
        if (!bench.require(first == (i == 0), fmt::format("packet {} has type {}", i, packet->type))) return;
        auto data = cip::ByteView(packet->data);
        std::uint16_t checksum = 0;
        if (last) {
            if (!bench.require(data.size() >= 2, "the last packet has no checksum")) return;
            checksum = cip::Reader(data.last(2)).u16();
            data = data.first(data.size() - 2);
        }
        received += static_cast<std::uint32_t>(data.size());
        for (const auto octet : data) sum = static_cast<std::uint16_t>(sum + octet);
        if (!last) {
            if (!bench.require(data.size() == transfer_size,
                               fmt::format("packet {} has {} octets and not {}", i, data.size(), transfer_size)))
                return;
            continue;
        }
        bench.require(received == size, fmt::format("{} octets came; {} were announced", received, size));
        bench.require(static_cast<std::uint16_t>(sum + checksum) == 0,
                      fmt::format("octets and checksum 0x{:04X} do not add up to 0", checksum));
        return;
    }
    bench.require(false, "there is no last packet");
}

void upload_repeats(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto begun = start_upload(session, 32);
    if (!begun || !granted(bench, begun)) return;
    const auto first = transfer(session, 0);
    const auto again = transfer(session, 0);
    if (granted(bench, first) && granted(bench, again))
        bench.require(first->message == again->message, "the same packet asked for again is another one");
    refused(bench, transfer(session, 77), {0x20}, {0x02}, Weight::any);
}

void upload_of_nothing(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto reply = start_upload(session, 0);
    if (reply) refused(bench, reply, {0x20}, {}, Weight::any);
}

void transfer_of_nothing(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    if (!has_instance(session, file, sheet)) return bench.skip("the device keeps no data sheet");
    // Asking for a transfer of size 0 has ended whatever was going on.
    if (!start_upload(session, 0)) return;
    const auto reply = transfer(session, 200);
    refused(bench, reply, {0x02}, {0x20, 0x0C, 0x08}, Weight::any);
}

// ------------------------------------------------------------------------------------------------------------ Time Sync

void whole_microseconds(Bench& bench) {
    Session session(bench);
    if (!session.is_open()) return;
    const auto microseconds = read(session, {time_sync, 1, 3}, if_there);
    const auto nanoseconds = read(session, {time_sync, 1, 4}, if_there);
    if (!microseconds || !nanoseconds) return;
    if (!bench.require(microseconds->size() == 8 && nanoseconds->size() == 8, "the system time has eight octets"))
        return;
    const auto us = cip::Reader(*microseconds).u64();
    const auto ns = cip::Reader(*nanoseconds).u64();
    constexpr std::uint64_t ten_seconds = 10'000'000;
    bench.require(ns / 1000 >= us && ns / 1000 - us < ten_seconds,
                  "the system time in nanoseconds is another one than in microseconds");
}

constexpr auto O = Group::objects;
constexpr auto R = Manner::reads;
constexpr auto W = Manner::writes;

// clang-format off
constexpr std::array cases{
    Case{"TCP-01", O, "TCP/IP 1 is a status", "R-TCP-2", "DWORD; the lower four bits are 0 to 2, bits 10 to 31 reserved.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 1}, needed, 4, tcp_status); }},
    Case{"TCP-02", O, "TCP/IP 2 is a capability", "R-TCP-3", "DWORD; bits 8 to 31 are reserved.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 2}, needed, 4, [](cip::Reader& v) { return no_bits(v.u32(), 0xFFFFFF00); }); }},
    Case{"TCP-03", O, "TCP/IP 3 is a control", "R-TCP-4", "DWORD; the lower four bits are 0 to 2, bits 5 to 31 are 0.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 3}, needed, 4, tcp_control); }},
    Case{"TCP-04", O, "The device can do what it is told to", "R-TCP-3", "A method in attribute 3 is among the capabilities in attribute 2.", R, control_is_capable},
    Case{"TCP-05", O, "TCP/IP 4 leads to the physical link", "R-TCP-5", "A size in words and the path of the Ethernet Link object, or nothing.", R, physical_link},
    Case{"TCP-06", O, "TCP/IP 5 is the interface configuration", "R-TCP-6", "Five addresses and the domain, padded to an even number; mask and gateway make sense.", R, [](Bench& b) { check_whole(b, {tcp_ip, 1, 5}, needed, interface_configuration); }},
    Case{"TCP-07", O, "TCP/IP 5 has the address of the device", "R-TCP-6", "The address is the one where the device is found.", R, own_address},
    Case{"TCP-08", O, "TCP/IP 6 is a host name", "R-TYP-5", "STRING of at most 64 characters, padded to an even number.", R, [](Bench& b) { check_whole(b, {tcp_ip, 1, 6}, needed, host_name); }},
    Case{"TCP-09", O, "TCP/IP 8 is a TTL", "R-TCP-8", "USINT, never 0.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 8}, if_there, 1, [](cip::Reader& v) { return v.u8() != 0 ? "" : "TTL 0"; }); }},
    Case{"TCP-10", O, "TCP/IP 9 is the multicast allocation", "R-MC-2", "Control 0 or 1, a reserved 0, a number of groups, the first of them.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 9}, if_there, 8, multicast); }},
    Case{"TCP-11", O, "TCP/IP 10 switches conflict detection", "R-TCP-9", "BOOL.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 10}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 1); }); }},
    Case{"TCP-12", O, "TCP/IP 11 is the last conflict", "R-TCP-10", "35 octets; the activity is 0 to 3.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 11}, if_there, 35, [](cip::Reader& v) { return at_most(v.u8(), 3); }); }},
    Case{"TCP-13", O, "TCP/IP 12 switches Quick Connect", "R-TCP-1", "BOOL, where it is there.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 12}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 1); }); }},
    Case{"TCP-14", O, "TCP/IP 13 is the inactivity timeout", "R-TCP-11", "UINT of at most 3600 seconds.", R, [](Bench& b) { check_value(b, {tcp_ip, 1, 13}, if_there, 2, [](cip::Reader& v) { return at_most(v.u16(), 3600); }); }},
    Case{"TCP-15", O, "All attributes of TCP/IP are the single ones", "R-TCP-12", "Get_Attributes_All is the attributes in their order.", R, [](Bench& b) { check_all(b, tcp_ip, 1, 13, if_there); }},
    Case{"TCP-16", O, "Class attributes of TCP/IP", "R-OBJ-1", "UINTs; revision 1 to 4.", R, [](Bench& b) { check_class(b, tcp_ip, 1, 4, needed); }},
    Case{"TCP-17", O, "The status cannot be written", "R-ERR-6", "Status 0x0E.", W, [](Bench& b) { set_tcp(b, 1, "01 00 00 00", {0x0E}, {0x08}); }},
    Case{"TCP-18", O, "Reserved bits of the control are refused", "R-TCP-4", "Status 0x09.", W, [](Bench& b) { set_tcp(b, 3, "00 00 00 80", {0x09}, {0x0E, 0x08}); }},
    Case{"TCP-19", O, "A method that is none is refused", "R-TCP-4", "Status 0x09.", W, [](Bench& b) { set_tcp(b, 3, "0F 00 00 00", {0x09}, {0x0E, 0x08}); }},
    Case{"TCP-20", O, "A control of three octets is refused", "R-ERR-8", "Status 0x13.", W, [](Bench& b) { set_tcp(b, 3, "00 00 00", {0x13}, {0x0E, 0x08}); }},
    Case{"TCP-21", O, "A control of five octets is refused", "R-ERR-8", "Status 0x15.", W, [](Bench& b) { set_tcp(b, 3, "00 00 00 00 00", {0x15}, {0x0E, 0x08}); }},
    Case{"TCP-22", O, "A host name with blanks is refused", "R-TCP-7", "Letters, digits, hyphen and dot; otherwise 0x09.", W, [](Bench& b) { set_tcp(b, 6, "04 00 61 20 62 20", {0x09}, {0x0E, 0x08}); }},
    Case{"TCP-23", O, "A host name of 66 characters is refused", "R-TCP-7", "At most 64 characters; otherwise 0x15.", W, too_long_host_name},
    Case{"TCP-24", O, "The host name can be written", "R-TCP-7", "What was read is taken, and reads back.", W, [](Bench& b) { check_write_back(b, {tcp_ip, 1, 6}); }},
    Case{"TCP-25", O, "TTL 0 is refused", "R-TCP-8", "Status 0x09.", W, [](Bench& b) { set_tcp(b, 8, "00", {0x09}, {0x0E, 0x08}); }},
    Case{"TCP-26", O, "Groups that are no multicast addresses are refused", "R-MC-2", "Status 0x09.", W, [](Bench& b) { set_tcp(b, 9, "01 00 01 00 01 01 A8 C0", {0x09}, {0x0E, 0x08}); }},
    Case{"TCP-27", O, "Conflict detection 2 is refused", "R-TCP-9", "Status 0x09.", W, [](Bench& b) { set_tcp(b, 10, "02", {0x09}, {0x0E, 0x08}); }},
    Case{"TCP-28", O, "An inactivity timeout of 3601 s is refused", "R-TCP-11", "Status 0x09.", W, [](Bench& b) { set_tcp(b, 13, "11 0E", {0x09}, {0x0E, 0x08}); }},
    Case{"TCP-29", O, "An inactivity timeout of one octet is refused", "R-ERR-8", "Status 0x13.", W, [](Bench& b) { set_tcp(b, 13, "78", {0x13}, {0x0E, 0x08}); }},
    Case{"TCP-30", O, "An inactivity timeout of three octets is refused", "R-ERR-8", "Status 0x15.", W, [](Bench& b) { set_tcp(b, 13, "78 00 00", {0x15}, {0x0E, 0x08}); }},
    Case{"TCP-31", O, "The inactivity timeout can be written", "R-TCP-11", "What was read is taken, and reads back.", W, write_inactivity},
    Case{"ETH-01", O, "Ethernet Link 1 is a speed", "R-ETH-1", "UDINT in Mbit/s.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 1}, needed, 4); }},
    Case{"ETH-02", O, "Ethernet Link 2 is a set of flags", "R-ETH-2", "DWORD; the negotiation is 0 to 4, bits 7 to 31 are reserved.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 2}, needed, 4, link_flags); }},
    Case{"ETH-03", O, "Ethernet Link 3 is a MAC address", "R-ETH-3", "Six octets, no group and not zero.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 3}, needed, 6, mac_address); }},
    Case{"ETH-04", O, "A link that is up has a speed", "R-ETH-1", "The speed is 0 only while it is unknown.", R, speed_and_link},
    Case{"ETH-05", O, "Ethernet Link 4 has eleven counters", "R-ETH-4", "11 UDINTs.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 4}, if_there, 44); }},
    Case{"ETH-06", O, "Ethernet Link 5 has twelve counters", "R-ETH-5", "12 UDINTs.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 5}, if_there, 48); }},
    Case{"ETH-07", O, "The counters count", "R-ETH-4", "In octets and out octets grow with the traffic.", R, counters_count},
    Case{"ETH-08", O, "Ethernet Link 6 is a control", "R-ETH-6", "WORD of two bits, UINT of a speed.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 6}, if_there, 4, interface_control); }},
    Case{"ETH-09", O, "Ethernet Link 7 is a type", "R-ETH-7", "USINT from 0 to 3.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 7}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 3); }); }},
    Case{"ETH-10", O, "Ethernet Link 8 is a state", "R-ETH-7", "USINT from 0 to 3.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 8}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 3); }); }},
    Case{"ETH-11", O, "Ethernet Link 9 is what was asked for", "R-ETH-7", "USINT, 1 or 2, where it is there.", R, [](Bench& b) { check_value(b, {ethernet_link, 1, 9}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 2); }); }},
    Case{"ETH-12", O, "Ethernet Link 10 is a label", "R-ETH-8", "SHORT_STRING of at most 64 characters.", R, [](Bench& b) { check_whole(b, {ethernet_link, 1, 10}, if_there, [](cip::Reader& v) { return at_most(static_cast<unsigned>(cip::read_short_string(v).size()), 64); }); }},
    Case{"ETH-13", O, "Ethernet Link 11 is a capability", "R-ETH-10", "DWORD of four bits, and pairs of speed and duplex.", R, [](Bench& b) { check_whole(b, {ethernet_link, 1, 11}, if_there, link_capability); }},
    Case{"ETH-14", O, "Both ports are of one device", "R-ETH-3", "The same MAC address, different labels.", R, second_port},
    Case{"ETH-15", O, "Class attributes of Ethernet Link", "R-OBJ-1", "UINTs; revision 1 to 4.", R, [](Bench& b) { check_class(b, ethernet_link, 1, 4, needed); }},
    Case{"ETH-16", O, "All attributes of Ethernet Link can be had at once", "R-ETH-9", "Get_Attributes_All begins with speed, flags and MAC address.", R, [](Bench& b) { check_all(b, ethernet_link, 1, 3, if_there); }},
    Case{"ETH-17", O, "The speed cannot be written", "R-ERR-6", "Status 0x0E.", W, [](Bench& b) { check_refused_set(b, {ethernet_link, 1, 1}, hex("0A 00 00 00"), {0x0E}, {0x08}); }},
    Case{"ETH-18", O, "Reserved bits of the control are refused", "R-ETH-6", "Status 0x09.", W, [](Bench& b) { check_refused_set(b, {ethernet_link, 1, 6}, hex("00 80 64 00"), {0x09}, {0x0E, 0x08, 0x0C}); }},
    Case{"ETH-19", O, "Autonegotiation with a speed is refused", "R-ETH-6", "Status 0x0C.", W, [](Bench& b) { check_refused_set(b, {ethernet_link, 1, 6}, hex("03 00 64 00"), {0x0C}, {0x09, 0x0E, 0x08}); }},
    Case{"QOS-01", O, "QoS 1 switches tags", "R-QOS-2", "USINT, 0 or 1.", R, [](Bench& b) { check_value(b, {qos, 1, 1}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 1); }); }},
    Case{"QOS-02", O, "QoS 4 is a DSCP", "R-QOS-2", "USINT from 0 to 63.", R, [](Bench& b) { dscp(b, 4); }},
    Case{"QOS-03", O, "QoS 5 is a DSCP", "R-QOS-2", "USINT from 0 to 63.", R, [](Bench& b) { dscp(b, 5); }},
    Case{"QOS-04", O, "QoS 6 is a DSCP", "R-QOS-2", "USINT from 0 to 63.", R, [](Bench& b) { dscp(b, 6); }},
    Case{"QOS-05", O, "QoS 7 is a DSCP", "R-QOS-2", "USINT from 0 to 63.", R, [](Bench& b) { dscp(b, 7); }},
    Case{"QOS-06", O, "QoS 8 is a DSCP", "R-QOS-2", "USINT from 0 to 63.", R, [](Bench& b) { dscp(b, 8); }},
    Case{"QOS-07", O, "Class attributes of QoS", "R-OBJ-1", "UINTs; revision 1.", R, [](Bench& b) { check_class(b, qos, 1, 1, if_there); }},
    Case{"QOS-08", O, "DSCP 64 is refused", "R-QOS-3", "Status 0x09.", W, [](Bench& b) { check_refused_set(b, {qos, 1, 4}, hex("40"), {0x09}, {0x0E, 0x08}); }},
    Case{"QOS-09", O, "A DSCP can be written", "R-QOS-3", "What was read is taken, and reads back.", W, [](Bench& b) { check_write_back(b, {qos, 1, 8}); }},
    Case{"DLR-01", O, "DLR 1 is a topology", "R-DLR-2", "USINT, 0 or 1.", R, [](Bench& b) { check_value(b, {ring, 1, 1}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 1); }); }},
    Case{"DLR-02", O, "DLR 2 is a status", "R-DLR-2", "USINT from 0 to 4.", R, [](Bench& b) { check_value(b, {ring, 1, 2}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 4); }); }},
    Case{"DLR-03", O, "DLR 10 is the supervisor", "R-DLR-2", "UDINT address and six octets of MAC address.", R, [](Bench& b) { check_value(b, {ring, 1, 10}, if_there, 10); }},
    Case{"DLR-04", O, "DLR 12 is a capability", "R-DLR-2", "DWORD; bits 8 to 31 are reserved.", R, [](Bench& b) { check_value(b, {ring, 1, 12}, if_there, 4, [](cip::Reader& v) { return no_bits(v.u32(), 0xFFFFFF00); }); }},
    Case{"DLR-05", O, "A node of no ring knows no supervisor", "R-DLR-2", "The supervisor is zero while the topology is linear.", R, ring_agrees},
    Case{"DLR-06", O, "All attributes of DLR can be had at once", "R-DLR-3", "Get_Attributes_All begins with topology and status.", R, [](Bench& b) { check_all(b, ring, 1, 2, if_there); }},
    Case{"DLR-07", O, "Class attributes of DLR", "R-OBJ-1", "UINTs; revision 1 to 4.", R, [](Bench& b) { check_class(b, ring, 1, 4, if_there); }},
    Case{"PRT-01", O, "The ports are listed", "R-PRT-1", "Class attribute 9 has type and number of each port, the first entry zero; 8 is the one of the request.", R, ports},
    Case{"PRT-02", O, "Port 1 is a type", "R-PRT-1", "UINT.", R, [](Bench& b) { check_value(b, {port, 1, 1}, if_there, 2); }},
    Case{"PRT-03", O, "Port 2 is a number", "R-PRT-1", "UINT, never 0.", R, [](Bench& b) { check_value(b, {port, 1, 2}, if_there, 2, [](cip::Reader& v) { return v.u16() != 0 ? "" : "port 0"; }); }},
    Case{"PRT-04", O, "Port 3 leads to the link object", "R-PRT-1", "A size in words and a path.", R, port_link},
    Case{"PRT-05", O, "Port 4 is a name", "R-PRT-1", "SHORT_STRING.", R, [](Bench& b) { check_whole(b, {port, 1, 4}, if_there, [](cip::Reader& v) { return at_most(static_cast<unsigned>(cip::read_short_string(v).size()), 64); }); }},
    Case{"PRT-06", O, "Class attributes of Port", "R-OBJ-1", "UINTs; revision 1 or 2.", R, [](Bench& b) { check_class(b, port, 1, 2, if_there); }},
    Case{"FIL-01", O, "File 1 is a state", "R-FIL-2", "USINT from 0 to 7.", R, [](Bench& b) { check_value(b, {file, sheet, 1}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 7); }); }},
    Case{"FIL-02", O, "File 2 is a name", "R-FIL-2", "STRINGI.", R, [](Bench& b) { check_whole(b, {file, sheet, 2}, if_there, stringi); }},
    Case{"FIL-03", O, "File 3 is a version of the format", "R-FIL-2", "UINT.", R, [](Bench& b) { check_value(b, {file, sheet, 3}, if_there, 2); }},
    Case{"FIL-04", O, "File 4 is a file name", "R-FIL-2", "STRINGI.", R, [](Bench& b) { check_whole(b, {file, sheet, 4}, if_there, stringi); }},
    Case{"FIL-05", O, "File 5 is a revision", "R-FIL-2", "USINT major, USINT minor.", R, [](Bench& b) { check_value(b, {file, sheet, 5}, if_there, 2); }},
    Case{"FIL-06", O, "File 6 is a size", "R-FIL-2", "UDINT.", R, [](Bench& b) { check_value(b, {file, sheet, 6}, if_there, 4); }},
    Case{"FIL-07", O, "File 7 is a checksum", "R-FIL-2", "Two octets.", R, [](Bench& b) { check_value(b, {file, sheet, 7}, if_there, 2); }},
    Case{"FIL-08", O, "File 10 is an access rule", "R-FIL-2", "USINT, 0 or 1.", R, [](Bench& b) { check_value(b, {file, sheet, 10}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 1); }); }},
    Case{"FIL-09", O, "The data sheet can be uploaded", "R-FIL-5", "Packets in order, as many octets as announced, a checksum that fits.", R, upload},
    Case{"FIL-10", O, "A packet can be had again", "R-FIL-5", "The number of the packet before means that packet; any other ends the transfer with 0x20.", R, upload_repeats},
    Case{"FIL-11", O, "A transfer size of 0 is refused", "R-FIL-7", "Status 0x20.", R, upload_of_nothing},
    Case{"FIL-12", O, "A packet of no transfer is refused", "R-FIL-7", "Status 0x02.", R, transfer_of_nothing},
    Case{"TSY-01", O, "Time Sync tells the time twice", "R-TSY-1", "Attributes 3 and 4 are the same time in microseconds and nanoseconds.", R, whole_microseconds},
    Case{"TSY-02", O, "Time Sync 1 switches PTP", "R-TSY-1", "BOOL.", R, [](Bench& b) { check_value(b, {time_sync, 1, 1}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 1); }); }},
    Case{"TSY-03", O, "Time Sync 2 says whether it is synchronised", "R-TSY-1", "BOOL.", R, [](Bench& b) { check_value(b, {time_sync, 1, 2}, if_there, 1, [](cip::Reader& v) { return at_most(v.u8(), 1); }); }},
};
// clang-format on

}  // namespace

std::span<const Case> network_object_cases() { return cases; }

}  // namespace servobus::scanner::conformance
