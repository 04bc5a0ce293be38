// Each attribute of each standard object, through the wire: its width, its value in a device that has just been started,
// what may be set and what is refused. The table is a transcript of the specification and of the manual; nothing in it
// is computed by what it tests.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/adapter_harness.hpp"

namespace servobus::test {
namespace {

using namespace std::string_literals;

enum class Access : std::uint8_t {
    get,
    set,     // get and set
    in_all,  // stands in Get_Attributes_All, and answers 0x14 alone
};
using enum Access;

struct Attribute {
    unsigned class_id;
    unsigned instance;
    unsigned id;
    Access access;
    std::string value;                   // in hex
    std::string other{};                 // of a settable one: a value that is taken
    std::vector<std::string> refused{};  // of the right length and not legal: 0x09
    std::string_view rule{};
};

const std::string zeros_35(70, '0');
const std::string zeros_44(88, '0');
const std::string zeros_48(96, '0');
const std::string conflict = "02 020000000001 0001 0800 06 04 0001 020000000001 C0A80264 000000000000 C0A80264";

// The device is 192.168.2.100/24 by DHCP; its File object has the octets 01 02 03.
const std::vector<Attribute>& attributes() {
    // clang-format off
    static const std::vector<Attribute> table{
        // Identity (R-ID-1)
        {0x01, 1, 1, get, "6D05"},
        {0x01, 1, 2, get, "2B00"},
        {0x01, 1, 3, get, "0975"},
        {0x01, 1, 4, get, "01 01"},
        {0x01, 1, 5, get, "3000"},
        {0x01, 1, 6, get, "C3B2A100"},
        {0x01, 1, 7, get, "0F 58454E4158205876692037355638 53"},
        {0x01, 1, 8, get, "03"},
        {0x01, 1, 10, get, "00"},
        // Assembly (R-ASM-2, R-ASM-3): what an I/O connection sends and takes
        {0x04, 100, 3, get, std::string(56, '0')}, {0x04, 100, 4, get, "1C00"},
        {0x04, 101, 3, set, std::string(36, '0'), "00000000 10270000 10270000 14000000 0000", {"00000000 10270000 10270000 65000000 0000"}},
        {0x04, 101, 4, get, "1200"},
        {0x04, 102, 3, set, std::string(40, '0'), "00000000 10270000 10270000 14000000 0000 6400"}, {0x04, 102, 4, get, "1400"},
        {0x04, 103, 3, set, std::string(64, '0'), "00000000 10270000 10270000 14000000 0000 6400 64000000 64000000 00000000"}, {0x04, 103, 4, get, "2000"},
        {0x04, 104, 3, set, std::string(72, '0'), "00000000 10270000 10270000 14000000 0000 6400 64000000 64000000 00000000 64000000"}, {0x04, 104, 4, get, "2400"},
        {0x04, 105, 3, get, std::string(64, '0')}, {0x04, 105, 4, get, "2000"},
        {0x04, 112, 3, set, std::string(96, '0'), "00000000 10270000 10270000 14000000 0000 6400 64000000 64000000 00000000 64000000 00000000 0000000000000000"},
        {0x04, 112, 4, get, "3000"},
        {0x04, 113, 4, get, "2800"},
        {0x04, 1, 3, get, ""}, {0x04, 1, 4, get, "0000"},
        {0x04, 254, 3, get, ""}, {0x04, 254, 4, get, "0000"},
        {0x04, 255, 3, get, ""}, {0x04, 255, 4, get, "0000"},
        // Connection Manager (R-CM-2): 137 connections, none of them open; 192 times 64 KiB
        {0x06, 1, 1, set, "0000", "0000", {"0100", "FFFF"}},
        {0x06, 1, 2, set, "0000", "0000", {"0100"}},
        {0x06, 1, 3, set, "0000", "0000", {"0100"}},
        {0x06, 1, 4, set, "0000", "0000", {"0100"}},
        {0x06, 1, 5, set, "0000", "0000", {"0100"}},
        {0x06, 1, 6, set, "0000", "0000", {"0100"}},
        {0x06, 1, 7, set, "0000", "0000", {"0100"}},
        {0x06, 1, 8, set, "0000", "0000", {"0100"}},
        {0x06, 1, 9, get, "8900 FFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFFF 01"},
        {0x06, 1, 11, get, "0000"},
        {0x06, 1, 12, get, "0000C000"},
        {0x06, 1, 13, get, "0000C000"},
        // File (R-FIL-2)
        {0x37, 1, 6, get, "03000000", {}, {}, "R-FIL-1: the same file"},
        {0x37, 0xC8, 1, get, "02"},
        {0x37, 0xC8, 2, get, "01 656E67 DA 0400 12 45445320616E642049636F6E2046696C6573"},
        {0x37, 0xC8, 3, get, "0100"},
        {0x37, 0xC8, 4, get, "01 656E67 DA 0400 1E 58454E41585F5856495F37355638535F45746865724E657449502E656473"},
        {0x37, 0xC8, 5, get, "01 00"},
        {0x37, 0xC8, 6, get, "03000000"},
        {0x37, 0xC8, 7, get, "FAFF"},
        {0x37, 0xC8, 8, get, "FF"},
        {0x37, 0xC8, 9, get, "00"},
        {0x37, 0xC8, 10, get, "01"},
        {0x37, 0xC8, 11, get, "00"},
        // Device Level Ring (R-DLR-2, R-DLR-3): a line
        {0x47, 1, 1, get, "00"},
        {0x47, 1, 2, get, "00"},
        {0x47, 1, 3, in_all, "FF"},
        {0x47, 1, 4, in_all, "000000000000000000000000"},
        {0x47, 1, 5, in_all, "0000"},
        {0x47, 1, 6, in_all, "00000000 000000000000"},
        {0x47, 1, 7, in_all, "00000000 000000000000"},
        {0x47, 1, 8, in_all, "FFFF"},
        {0x47, 1, 10, get, "00000000 000000000000"},
        {0x47, 1, 11, in_all, "00"},
        {0x47, 1, 12, get, "82000000"},
        // QoS (R-QOS-2, R-QOS-3)
        {0x48, 1, 1, set, "00", "01", {"02", "FF"}},
        {0x48, 1, 4, set, "37", "3F", {"40", "FF"}},
        {0x48, 1, 5, set, "2F", "00", {"40", "FF"}},
        {0x48, 1, 6, set, "2B", "01", {"40"}},
        {0x48, 1, 7, set, "1F", "02", {"40"}},
        {0x48, 1, 8, set, "1B", "1A", {"40"}},
        // Port (R-PRT-1)
        {0xF4, 1, 1, get, "0400"},
        {0xF4, 1, 2, get, "0200"},
        {0xF4, 1, 3, get, "0200 20F52401"},
        {0xF4, 1, 4, get, "0B 45746865724E65742F4950"},
        {0xF4, 1, 7, get, "12 0D 3139322E3136382E322E313030 00"},
        // TCP/IP Interface (R-TCP)
        {0xF5, 1, 1, get, "01000000", {}, {}, "R-TCP-2"},
        {0xF5, 1, 2, get, "94000000", {}, {}, "R-TCP-3"},
        {0xF5, 1, 3, set, "02000000", "00000000", {"01000000", "03000000", "0F000000", "12000000", "20000000", "02010000", "00000080"}, "R-TCP-4"},
        {0xF5, 1, 4, get, "0200 20F62401", {}, {}, "R-TCP-5"},
        {0xF5, 1, 6, set, "0000", "0500 78656E6178 00", {"0500 78656E5F78 00", "0400 78656E20", "0100 E4 00"}, "R-TCP-7"},
        {0xF5, 1, 7, in_all, "000000000000"},
        {0xF5, 1, 8, set, "01", "FF", {"00"}, "R-TCP-8"},
        {0xF5, 1, 9, set, "00 00 0100 600DC0EF", "01 00 0400 0000C0EF",
         {"02 00 0100 0000C0EF", "01 01 0100 0000C0EF", "01 00 0000 0000C0EF", "01 00 2100 0000C0EF", "01 00 0100 0000A8C0", "01 00 0100 000000F0", "01 00 0200 FFFFFFEF"}, "R-MC-2"},
        {0xF5, 1, 10, set, "01", "00", {"02", "FF"}, "R-TCP-9"},
        {0xF5, 1, 11, set, zeros_35, zeros_35, {conflict, zeros_35.substr(2) + "01"}, "R-TCP-10"},
        {0xF5, 1, 12, in_all, "00"},
        {0xF5, 1, 13, set, "7800", "100E", {"110E", "FFFF"}, "R-TCP-11"},
        // Ethernet Link (R-ETH): port 1 has a link, nothing is plugged into port 2
        {0xF6, 1, 1, get, "64000000"},
        {0xF6, 1, 2, get, "0F000000"},
        {0xF6, 1, 3, get, "020000000064"},
        {0xF6, 1, 4, get, zeros_44},
        {0xF6, 1, 5, get, zeros_48},
        {0xF6, 1, 6, set, "0100 0000", "0200 6400", {"0400 0000", "0500 0000", "0000 0000", "0200 E803", "0000 3200"}, "R-ETH-6"},
        {0xF6, 1, 7, get, "02"},
        {0xF6, 1, 8, get, "01"},
        {0xF6, 1, 9, in_all, "01"},
        {0xF6, 1, 10, get, "06 504F52542031"},
        {0xF6, 1, 11, get, "0A000000 04 0A0000 0A0001 640000 640001", {}, {}, "R-ETH-10"},
        {0xF6, 2, 1, get, "00000000"},
        {0xF6, 2, 2, get, "00000000"},
        {0xF6, 2, 3, get, "020000000064"},
        {0xF6, 2, 4, get, zeros_44},
        {0xF6, 2, 5, get, zeros_48},
        {0xF6, 2, 6, set, "0100 0000", "0000 0A00", {"0800 0000", "0200 0000"}, "R-ETH-6"},
        {0xF6, 2, 7, get, "02"},
        {0xF6, 2, 8, get, "01"},
        {0xF6, 2, 9, in_all, "01"},
        {0xF6, 2, 10, get, "06 504F52542032"},
        {0xF6, 2, 11, get, "0A000000 04 0A0000 0A0001 640000 640001", {}, {}, "R-ETH-10"},
    };
    // clang-format on
    return table;
}

// Those whose values cannot be told beforehand, or need more than the table has room for.
const std::set<std::array<unsigned, 3>> elsewhere{
    {0x04, 113, 3},  // ends with the time of day
    {0xF5, 1, 5},    // TcpIpAddress
};

struct Class {
    unsigned id;
    unsigned revision;
    unsigned max_instance;
    unsigned instances;
    unsigned max_class_attribute;
    unsigned max_attribute;
    std::vector<unsigned> services;  // at the instances; object specific ones included
    std::string all{};               // Get_Attributes_All at instance 0; empty: 0x08
};

// Revisions: R-OBJ-2. Services: R-DEV-2, R-MSG-4, R-CM-1.
const std::vector<Class>& classes() {
    static const std::vector<Class> table{
        {0x01, 1, 1, 1, 7, 10, {0x01, 0x03, 0x05, 0x0E}, "0100 0100 0700 0A00"},
        {0x04, 2, 255, 11, 7, 4, {0x0E, 0x10}},
        {0x06, 1, 1, 1, 7, 13, {0x0E, 0x10, 0x4E, 0x52, 0x54, 0x56, 0x57, 0x5A, 0x5B}},
        {0x37, 3, 0xC8, 1, 32, 11, {0x0E, 0x4B, 0x4F}},
        {0x47, 3, 1, 1, 7, 12, {0x01, 0x0E}},
        {0x48, 1, 1, 1, 7, 8, {0x0E, 0x10}},
        {0xF4, 1, 1, 1, 9, 7, {0x01, 0x0E}, "0100 0100 0100 0100 00000000 0400 0200"},
        {0xF5, 4, 1, 1, 7, 13, {0x01, 0x03, 0x0E, 0x10}},
        {0xF6, 4, 2, 2, 7, 11, {0x01, 0x03, 0x0E, 0x10}},
    };
    return table;
}

adapter::Network network() {
    adapter::Network network;
    network.state.interface.address = AdapterHarness::local.address;
    network.state.interface.mask = 0xFFFFFF00;
    return network;
}

adapter::DeviceFiles files() {
    return {.eds = adapter::DeviceFile{.content = std::make_shared<const cip::Bytes>(octets("010203")),
                                       .name = "XENAX_XVI_75V8S_EtherNetIP.eds"}};
}

class StandardObjects : public testing::Test {
protected:
    StandardObjects() { device_.register_session(); }

    static std::string path(unsigned class_id, unsigned instance, unsigned attribute) {
        return fmt::format("03 20 {:02X} 24 {:02X} 30 {:02X}", class_id, instance, attribute);
    }
    static std::string path(const Attribute& row) { return path(row.class_id, row.instance, row.id); }
    std::string read(const Attribute& row) { return device_.call("0E " + path(row)); }
    std::string write(const Attribute& row, const std::string& value) {
        return device_.call("10 " + path(row) + value);
    }

    static std::string refused(unsigned service, unsigned status) {
        return hex(fmt::format("{:02X} 00 {:02X} 00", service | 0x80U, status));
    }
    static std::string told(const std::string& value) { return hex("8E 00 00 00" + value); }
    static bool offers(unsigned class_id, unsigned service) {
        const auto found = std::ranges::find(classes(), class_id, &Class::id);
        return found != classes().end() && std::ranges::count(found->services, service) > 0;
    }
    static std::string name(const Attribute& row) {
        return fmt::format("0x{:02X}/{}/{} {}", row.class_id, row.instance, row.id, row.rule);
    }

    AdapterHarness device_{drive::Device(drive::xenax_models().front()), {}, network(), files()};
};

TEST_F(StandardObjects, HaveTheirValues) {
    for (const auto& row : attributes()) {
        EXPECT_EQ(read(row), row.access == in_all ? refused(0x0E, 0x14) : told(row.value)) << name(row);
    }
}

TEST_F(StandardObjects, HaveNoOtherAttributes) {
    std::set<std::array<unsigned, 3>> known = elsewhere;
    for (const auto& row : attributes()) known.insert({row.class_id, row.instance, row.id});
    for (const auto& each : classes()) {
        for (unsigned id = 0; id <= 0x40; ++id) {
            if (known.contains({each.id, each.max_instance, id})) continue;
            EXPECT_EQ(device_.call("0E " + path(each.id, each.max_instance, id)), refused(0x0E, 0x14))
                << each.id << "/" << id;
            if (offers(each.id, 0x10)) {
                EXPECT_EQ(device_.call("10 " + path(each.id, each.max_instance, id) + "00"), refused(0x10, 0x14))
                    << each.id << "/" << id;
            }
        }
    }
}

TEST_F(StandardObjects, R_ERR_6_WhatIsNotSettableIsRefusedWhateverIsSent) {
    for (const auto& row : attributes()) {
        if (row.access == set) continue;
        const auto status = !offers(row.class_id, 0x10) ? 0x08U : row.access == in_all ? 0x14U : 0x0EU;
        for (const auto& value : {row.value, row.value + "00"s, ""s}) {
            EXPECT_EQ(write(row, value), refused(0x10, status)) << name(row);
        }
    }
}

TEST_F(StandardObjects, WhatIsSettableIsTakenAndReadBack) {
    for (const auto& row : attributes()) {
        if (row.access != set) continue;
        EXPECT_EQ(write(row, row.other), hex("90 00 00 00")) << name(row);
        EXPECT_EQ(read(row), told(row.other)) << name(row);
    }
}

TEST_F(StandardObjects, R_ERR_8_TheLengthMustFit) {
    for (const auto& row : attributes()) {
        if (row.access != set) continue;
        const auto value = octets(row.other);
        auto shorter = value;
        shorter.pop_back();
        EXPECT_EQ(write(row, hex(shorter)), refused(0x10, 0x13)) << name(row);
        EXPECT_EQ(write(row, ""), refused(0x10, 0x13)) << name(row);
        EXPECT_EQ(write(row, row.other + "00"), refused(0x10, 0x15)) << name(row);
        EXPECT_EQ(read(row), told(row.value)) << name(row) << ": R-ERR-11";
    }
}

TEST_F(StandardObjects, R_ERR_9_TheValueMustBeLegal) {
    for (const auto& row : attributes()) {
        for (const auto& value : row.refused) {
            EXPECT_EQ(write(row, value), refused(0x10, 0x09)) << name(row) << ": " << value;
        }
        if (row.access == set) {
            EXPECT_EQ(read(row), told(row.value)) << name(row) << ": R-ERR-11";
        }
    }
}

TEST_F(StandardObjects, R_ETH_6_NegotiationAndForcedValuesExcludeEachOther) {
    for (const auto* value : {"0300 0000", "0100 6400", "0300 6400"}) {
        EXPECT_EQ(device_.call("10 03 20 F6 24 01 30 06"s + value), refused(0x10, 0x0C)) << value;
    }
    EXPECT_EQ(device_.call("0E 03 20 F6 24 01 30 06"), told("0100 0000"));
}

TEST_F(StandardObjects, R_TCP_7_AHostNameHas64CharactersAtMost) {
    const std::string at_limit = "4000" + hex(cip::Bytes(64, 'a'));
    EXPECT_EQ(device_.call("10 03 20 F5 24 01 30 06" + at_limit), hex("90 00 00 00"));
    EXPECT_EQ(device_.call("10 03 20 F5 24 01 30 06 4100" + hex(cip::Bytes(65, 'a')) + "00"), refused(0x10, 0x15));
    EXPECT_EQ(device_.call("0E 03 20 F5 24 01 30 06"), told(at_limit));
}

TEST_F(StandardObjects, R_MSG_12_AllAttributesAreTheirConcatenation) {
    struct All {
        unsigned class_id;
        unsigned instance;
        std::vector<unsigned> ids;
    };
    for (const auto& [class_id, instance, ids] : {All{0x01, 1, {1, 2, 3, 4, 5, 6, 7}},
                                                  {0x47, 1, {1, 2, 3, 4, 5, 6, 7, 8, 10, 11, 12}},
                                                  {0xF4, 1, {1, 2, 3, 4, 7}},
                                                  {0xF5, 1, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13}},
                                                  {0xF6, 1, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}},
                                                  {0xF6, 2, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}}}) {
        std::string all = "81 00 00 00";
        for (const auto id : ids) {
            const auto row = std::ranges::find_if(attributes(), [&](const Attribute& each) {
                return each.class_id == class_id && each.instance == instance && each.id == id;
            });
            all += row != attributes().end() ? row->value : "6402A8C0 00FFFFFF 00000000 00000000 00000000 0000";
        }
        EXPECT_EQ(device_.call(fmt::format("01 02 20 {:02X} 24 {:02X}", class_id, instance)), hex(all)) << class_id;
    }
}

TEST_F(StandardObjects, R_OBJ_1_ClassAttributes) {
    for (const auto& each : classes()) {
        const auto get = [&](unsigned id) { return device_.call("0E " + path(each.id, 0, id)); };
        const auto number = [](unsigned value) { return told(fmt::format("{:02X} {:02X}", value & 0xFF, value >> 8)); };
        EXPECT_EQ(get(1), number(each.revision)) << each.id;
        EXPECT_EQ(get(2), number(each.max_instance)) << each.id;
        EXPECT_EQ(get(3), number(each.instances)) << each.id;
        EXPECT_EQ(get(6), number(each.max_class_attribute)) << each.id;
        EXPECT_EQ(get(7), number(each.max_attribute)) << each.id;
        for (const unsigned id : {0, 4, 5, 10, 31}) EXPECT_EQ(get(id), refused(0x0E, 0x14)) << each.id << "/" << id;
        EXPECT_EQ(device_.call("10 " + path(each.id, 0, 1) + "0100"), refused(0x10, 0x08)) << each.id;
        EXPECT_EQ(device_.call(fmt::format("01 02 20 {:02X} 24 00", each.id)),
                  each.all.empty() ? refused(0x01, 0x08) : hex("81 00 00 00" + each.all))
            << each.id;
    }
    EXPECT_EQ(device_.call("0E 03 20 F4 24 00 30 08"), told("0100")) << "R-PRT-1";
    EXPECT_EQ(device_.call("0E 03 20 F4 24 00 30 09"), told("00000000 0400 0200")) << "R-PRT-1";
    EXPECT_EQ(device_.call("0E 03 20 37 24 00 30 20"),
              told("C800 01 656E67 DA 0400 12 45445320616E642049636F6E2046696C6573"
                   "01 656E67 DA 0400 1E 58454E41585F5856495F37355638535F45746865724E657449502E656473"))
        << "R-FIL-3";
    EXPECT_EQ(device_.call("0E 03 20 02 24 00 30 01"), told("0100")) << "R-OBJ-2";
}

TEST_F(StandardObjects, R_ERR_3_HaveNoOtherInstances) {
    for (const auto& each : classes()) {
        const auto beyond = each.max_instance + 1;
        EXPECT_EQ(
            device_.call(fmt::format("0E 04 20 {:02X} 25 00 {:02X} {:02X} 30 01", each.id, beyond & 0xFF, beyond >> 8)),
            refused(0x0E, 0x05))
            << each.id;
        EXPECT_EQ(device_.call(fmt::format("7F 03 20 {:02X} 25 00 {:02X} {:02X}", each.id, beyond & 0xFF, beyond >> 8)),
                  refused(0x7F, 0x05))
            << each.id;
    }
}

TEST_F(StandardObjects, R_ERR_4_HaveNoOtherServices) {
    for (const auto& each : classes()) {
        for (unsigned service = 0; service <= 0x7F; ++service) {
            if (std::ranges::count(each.services, service) > 0) continue;
            EXPECT_EQ(
                device_.call(fmt::format("{:02X} 03 20 {:02X} 24 {:02X} 30 01", service, each.id, each.max_instance)),
                refused(service, 0x08))
                << each.id;
        }
    }
    EXPECT_EQ(device_.call("4C 03 20 F6 24 01 30 04"), refused(0x4C, 0x08)) << "R-ETH-11";
}

TEST_F(StandardObjects, R_MR_1_TheMessageRouterOffersMultipleServicePacketAlone) {
    for (unsigned service = 0; service <= 0x7F; ++service) {
        if (service == 0x0A) continue;
        EXPECT_EQ(device_.call(fmt::format("{:02X} 03 20 02 24 01 30 01", service)), refused(service, 0x08));
    }
    EXPECT_EQ(device_.call("0A 02 20 02 24 01 0100 0400 0E 03 20 01 24 01 30 01"),
              hex("8A 00 00 00 0100 0400 8E 00 00 00 6D05"));
}

TEST_F(StandardObjects, R_ERR_5_AMissingAttributeSegmentIsNoAttribute) {
    for (const auto& each : classes()) {
        EXPECT_EQ(device_.call(fmt::format("0E 02 20 {:02X} 24 {:02X}", each.id, each.max_instance)),
                  refused(0x0E, 0x14))
            << each.id;
    }
}

TEST_F(StandardObjects, R_MSG_14_ListsTellTheSame) {
    for (const unsigned class_id : {0x01U, 0xF5U, 0xF6U}) {
        std::string request;
        std::string reply;
        unsigned count = 0;
        for (const auto& row : attributes()) {
            if (row.class_id != class_id || row.instance != 1) continue;
            ++count;
            request += fmt::format("{:02X} 00", row.id);
            reply += fmt::format("{:02X} 00", row.id) + (row.access == in_all ? "1400"s : "0000"s + row.value);
        }
        const bool all = class_id == 0x01;
        EXPECT_EQ(device_.call(fmt::format("03 02 20 {:02X} 24 01 {:02X} 00", class_id, count) + request),
                  hex(fmt::format("83 00 {} 00 {:02X} 00", all ? "00" : "0A", count) + reply));
    }
}

TEST(ClassList, EachClassIsThereAndNoOther) {
    AdapterHarness device;
    device.register_session();
    const std::set<unsigned> expected{0x01, 0x02, 0x04, 0x06, 0x37, 0x47, 0x48, 0x64, 0x65,
                                      0x66, 0x67, 0x68, 0x69, 0x6E, 0xF4, 0xF5, 0xF6};
    for (unsigned id = 0; id <= 0xFF; ++id) {
        const auto there = device.call(fmt::format("0E 03 20 {:02X} 24 00 30 01", id)) != hex("8E 00 05 00");
        EXPECT_EQ(there, expected.contains(id)) << id;
    }
}

}  // namespace
}  // namespace servobus::test
