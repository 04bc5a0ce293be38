// The Time Sync object (0x43) and what comes with it, through the router: each attribute octet by octet (R-TSY-1, R-TSY-2).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "adapter/ptp_client.hpp"
#include "adapter/time_sync.hpp"
#include "tests/adapter/ptp_node.hpp"
#include "tests/support/adapter_harness.hpp"

namespace servobus::test {
namespace {

using namespace std::chrono_literals;
using adapter::ManagementId;

constexpr auto day = 1'700'000'000'123'456'789ns;  // ahead of the clock of the harness, which shows an hour

adapter::Network network() {
    adapter::Network network;
    network.state.mac = {0x02, 0x11, 0x22, 0x33, 0x44, 0x55};
    return network;
}

std::string little(std::int64_t value) {
    cip::Bytes octets;
    cip::Writer(octets).little(value);
    return hex(octets);
}

const std::map<unsigned, std::string>& of_a_slave() {
    // clang-format off
    static const std::map<unsigned, std::string> values{
        {1, "01"},
        {2, "01"},
        {3, little(1'700'003'600'123'456 + 37'000'000)},  // µs, TAI
        {4, little(1'700'003'600'123'456'789 + 37'000'000'000)},
        {5, little(-500)},
        {6, little(1'000'000)},
        {7, little(1562)},
        {8, "E6DF21FFFE788277 0600 2100 5D4E 2500 3C00 2000 0A00 0B00"},
        {9, "E6DF21FFFE788278 0300 3412 FEFFFF7F"},
        {10, "5E88D9FFFE77A0B1 F800 FE00 FFFF 2500 3C00 2000"},
        {11, "0100"},
        {12, "0100 0100 0900"},
        {13, "0100 0100 0100"},
        {14, "0100 0100 FEFF"},
        {15, "0100 0100 FDFF"},
        {16, "80"},
        {17, "81"},
        {18, "07"},
        {19, "8001"},
        {21, "29000000 4A656E6E7920536369656E6365204147 3B 58454E4158205876692037355638 53 3B 3030413142324333"},
        {22, "05000000 3B 312E31 3B"},
        {23, "05000000 5072657373"},
        {24, "0100 0100 001B190001000000"},
        {25, "0100 0100 49454545203830322E33000000000000 0600 5E88D977A0B100000000000000000000"},
        {26, "0100 0100 0100 0400 0A010102000000000000000000000000"},
        {27, "0200"},
        {28, little(1'700'003'600'123'456 + 37'000'000) + little(1'700'000'000'123'456 + 37'000'000)},
    };
    // clang-format on
    return values;
}

// Nobody does PTP here: time is UTC, as the machine has it.
const std::map<unsigned, std::string>& of_a_lone_clock() {
    static const std::map<unsigned, std::string> values{
        {1, "01"},
        {2, "00"},
        {3, little(1'700'003'600'123'456)},
        {4, little(1'700'003'600'123'456'789)},
        {5, little(0)},
        {6, little(1'000'000)},
        {7, little(0)},
        {8, "021122FFFE334455 F800 FE00 FFFF 0000 0000 A000 8000 8000"},
        {9, "021122FFFE334455 0000 FFFF FFFFFF7F"},
        {10, "021122FFFE334455 F800 FE00 FFFF 0000 0000 A000"},
        {11, "0000"},
        {12, "0000"},
        {13, "0000"},
        {14, "0000"},
        {15, "0000"},
        {16, "80"},
        {17, "80"},
        {18, "00"},
        {19, "0000"},
        {21, of_a_slave().at(21)},
        {22, of_a_slave().at(22)},
        {23, "00000000"},
        {24, "0000"},
        {25, "0000"},
        {26, "0000"},
        {27, "FFFF"},
        {28, little(1'700'003'600'123'456) + little(1'700'000'000'123'456)},
    };
    return values;
}

class TimeSyncObject : public testing::Test {
protected:
    TimeSyncObject() {
        device_.adapter().follow_time(known_);
        device_.adapter().on_day_clock(day);
        device_.register_session();
    }

    /// One round of questions to the node.
    void ask() {
        enip::Time now{1h};
        adapter::PtpClient client(known_, 7, adapter::Log());
        client.on_timer(now);
        for (auto asked = client.take_messages(); !asked.empty(); asked = client.take_messages()) {
            client.on_message(node_.answer(asked.front()), now);
        }
        ASSERT_TRUE(known_.node);
    }

    static std::string path(unsigned attribute) { return fmt::format("03 20 43 24 01 30 {:02X}", attribute); }
    std::string get(unsigned attribute) { return device_.call("0E " + path(attribute)); }
    std::string set(unsigned attribute, const std::string& value) {
        return device_.call("10 " + path(attribute) + value);
    }
    static std::string told(const std::string& value) { return hex("8E 00 00 00" + value); }
    static std::string refused(unsigned service, unsigned status) {
        return hex(fmt::format("{:02X} 00 {:02X} 00", service | 0x80U, status));
    }
    void expect_all(const std::map<unsigned, std::string>& values) {
        for (const auto& [id, value] : values) EXPECT_EQ(get(id), told(value)) << id;
    }

    FakePtpNode node_;
    adapter::TimeSync known_;
    AdapterHarness device_{drive::Device(drive::xenax_models().front()), {}, network()};
};

TEST_F(TimeSyncObject, R_TSY_2_OfAClockThatFollowsAMaster) {
    ask();
    expect_all(of_a_slave());
}

TEST_F(TimeSyncObject, R_TSY_3_OfAMachineWithoutPtp) { expect_all(of_a_lone_clock()); }

TEST_F(TimeSyncObject, HasNoOtherAttributes) {
    ask();
    for (unsigned id = 0; id <= 0x40; ++id) {
        if (of_a_slave().contains(id)) continue;
        EXPECT_EQ(get(id), refused(0x0E, 0x14)) << id;
        EXPECT_EQ(set(id, "00"), refused(0x10, 0x14)) << id;
    }
}

TEST_F(TimeSyncObject, OnlyWhatIsTheDrivesOwnCanBeSet) {
    for (const auto& [id, value] : of_a_slave()) {
        if (id == 1 || id == 6) continue;
        EXPECT_EQ(set(id, value), refused(0x10, 0x0E)) << id;
    }
}

TEST_F(TimeSyncObject, OfTwoPorts) {
    node_.told[{ManagementId::default_data_set, adapter::all_ports}] =
        "00 00 0002 80 F8FEFFFF 81 5E88D9FFFE77A0B1 07 00";
    node_.told[{ManagementId::port_data_set, 2}] = "5E88D9FFFE77A0B1 0002 03 00 0000000000000000 01 03 02 01 00 02";
    node_.told[{ManagementId::clock_description, 1}] =
        "4800 18 303132333435363738394142434445464748494A4B4C4D4E 0012 000102030405060708090A0B0C0D0E0F1011 0003 0000 "
        "000000 00 00 00 00 001B19000200";
    ask();
    EXPECT_EQ(get(11), told("0200"));
    EXPECT_EQ(get(12), told("0200 0100 0900 0200 0300"));
    EXPECT_EQ(get(13), told("0200 0100 0100 0200 0000")) << "a disabled port is not enabled";
    EXPECT_EQ(get(14), told("0200 0100 FEFF 0200 0100"));
    EXPECT_EQ(get(15), told("0200 0100 FDFF 0200 0200"));
    EXPECT_EQ(get(19), told("4800")) << "boundary clock and management node";
    EXPECT_EQ(get(23), told("00000000"));
    EXPECT_EQ(get(24), told("0100 0100 001B190002000000")) << "the second port does not tell";
    EXPECT_EQ(get(25), told("0100 0100 30313233343536373839414243444546 1000 000102030405060708090A0B0C0D0E0F"))
        << "there is room for 16 characters and 16 octets";
    EXPECT_EQ(get(26), told("0100 0100 0300 0000" + std::string(32, '0')));
}

TEST_F(TimeSyncObject, R_TSY_3_SynchronizedIsWhoHasAMasterAndIsNear) {
    ask();
    EXPECT_EQ(get(2), told("01"));
    EXPECT_EQ(set(6, little(500)), told("").replace(0, 2, "90"));
    EXPECT_EQ(get(6), told(little(500)));
    EXPECT_EQ(get(2), told("00")) << "500 ns off is not less than 500 ns";
    EXPECT_EQ(get(27), told("0200")) << "it has a master all the same";
    EXPECT_EQ(set(6, little(501)), hex("90 00 00 00"));
    EXPECT_EQ(get(2), told("01"));
    for (const unsigned state : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U}) {
        node_.told[{ManagementId::port_data_set, 1}] =
            fmt::format("5E88D9FFFE77A0B1 0001 {:02X} 00 0000000000000000 FE 03 FD 01 00 02", state);
        ask();
        EXPECT_EQ(get(2), told("00")) << state;
        EXPECT_EQ(get(27), told("FFFF")) << state;
        EXPECT_EQ(get(12), told(fmt::format("0100 0100 {:02X}00", state)));
    }
    node_.told[{ManagementId::port_data_set, 1}] = "5E88D9FFFE77A0B1 0001 09 00 0000000000000000 FE 03 FD 01 00 02";
    node_.told[{ManagementId::current_data_set, adapter::all_ports}] = "0001 8000000000000000 0000000000000000";
    ask();
    EXPECT_EQ(get(2), told("00"));
    EXPECT_EQ(get(5), told(little(-(std::int64_t{1} << 47))));
}

TEST_F(TimeSyncObject, WhatIsSetIsChecked) {
    for (const auto* value : {"02", "FF"}) EXPECT_EQ(set(1, value), refused(0x10, 0x09)) << value;
    EXPECT_EQ(set(1, ""), refused(0x10, 0x13));
    EXPECT_EQ(set(1, "0000"), refused(0x10, 0x15));
    EXPECT_EQ(set(6, "00000000000000"), refused(0x10, 0x13));
    EXPECT_EQ(set(6, "000000000000000000"), refused(0x10, 0x15));
    EXPECT_EQ(set(6, little(0)), refused(0x10, 0x09)) << "it would never be synchronised";
    EXPECT_EQ(set(6, "FFFFFFFFFFFFFFFF"), hex("90 00 00 00"));
    EXPECT_EQ(get(6), told("FFFFFFFFFFFFFFFF"));
    EXPECT_EQ(get(1), told("01"));
}

TEST_F(TimeSyncObject, WithoutPtpTheDriveKnowsOfNoMasterAndItsTimeGoesOn) {
    ask();
    EXPECT_EQ(set(1, "00"), hex("90 00 00 00"));
    auto values = of_a_lone_clock();
    values[1] = "00";
    for (const unsigned time : {3U, 4U, 28U}) values[time] = of_a_slave().at(time);
    expect_all(values);
    EXPECT_EQ(set(1, "01"), hex("90 00 00 00"));
    expect_all(of_a_slave());
}

TEST_F(TimeSyncObject, WhatIsSetIsKeptOverAResetAndGoesWithTheFactorySettings) {
    const auto& kept = device_.adapter().kept().network.time_sync;
    EXPECT_EQ(set(1, "00"), hex("90 00 00 00"));
    EXPECT_EQ(set(6, little(2000)), hex("90 00 00 00"));
    EXPECT_EQ(kept, (adapter::TimeSyncSettings{false, 2000}));
    EXPECT_EQ(device_.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    device_.advance(10s);
    device_.connect();
    device_.register_session();
    EXPECT_EQ(get(1), told("00")) << "and there is an object still";
    EXPECT_EQ(get(6), told(little(2000)));
    EXPECT_EQ(device_.call("05 02 20 01 24 01 01"), hex("85 00 00 00"));
    device_.advance(10s);
    EXPECT_EQ(kept, adapter::TimeSyncSettings());
}

TEST_F(TimeSyncObject, ClassAttributesAndServices) {
    const std::map<unsigned, std::string> of_class{{1, "0300"}, {2, "0100"}, {3, "0100"}, {6, "0700"}, {7, "1C00"}};
    for (const auto& [id, value] : of_class) {
        EXPECT_EQ(device_.call(fmt::format("0E 03 20 43 24 00 30 {:02X}", id)), told(value)) << id;
    }
    EXPECT_EQ(device_.call("0E 03 20 43 24 02 30 01"), refused(0x0E, 0x05));
    for (const unsigned service : {0x01U, 0x02U, 0x05U, 0x4BU}) {
        EXPECT_EQ(device_.call(fmt::format("{:02X} 02 20 43 24 01", service)), refused(service, 0x08)) << service;
    }
    ask();
    EXPECT_EQ(device_.call("03 02 20 43 24 01 0400 0100 0200 1400 1B00"),
              hex("83 00 0A 00 0400 0100 0000 01 0200 0000 01 1400 1400 1B00 0000 0200"));
    EXPECT_EQ(device_.call("04 02 20 43 24 01 0200 0100 00 0600" + little(77)),
              hex("84 00 00 00 0200 0100 0000 0600 0000"));
    EXPECT_EQ(get(1), told("00"));
    EXPECT_EQ(get(6), told(little(77)));
}

// A PLC that reads the time twice sees how much later it is.
TEST_F(TimeSyncObject, TimeGoesOnAndFollowsTheClockOfTheDay) {
    EXPECT_EQ(get(4), told(little(1'700'003'600'123'456'789)));
    device_.advance(1500ms);
    EXPECT_EQ(get(4), told(little(1'700'003'601'623'456'789)));
    device_.adapter().on_day_clock(day - 1h);  // somebody sets the clock
    EXPECT_EQ(get(4), told(little(1'700'000'001'623'456'789)));
    EXPECT_EQ(get(28), told(little(1'700'000'001'623'456) + little(1'699'996'400'123'456)));
}

TEST_F(TimeSyncObject, R_QOS_2_TheDscpOfPtpIsThere) {
    EXPECT_EQ(device_.call("0E 03 20 48 24 01 30 02"), told("3B"));
    EXPECT_EQ(device_.call("0E 03 20 48 24 01 30 03"), told("2F"));
    EXPECT_EQ(device_.call("10 03 20 48 24 01 30 02 3F"), hex("90 00 00 00"));
    EXPECT_EQ(device_.call("10 03 20 48 24 01 30 03 40"), refused(0x10, 0x09));
    EXPECT_EQ(device_.call("0E 03 20 48 24 01 30 02"), told("3F"));
    EXPECT_EQ(device_.call("0E 03 20 48 24 01 30 04"), told("37"));
    EXPECT_EQ(device_.call("0E 03 20 48 24 01 30 00"), refused(0x0E, 0x14));
    EXPECT_EQ(device_.adapter().kept().network.qos.ptp_dscp[0], 0x3F);
}

TEST_F(TimeSyncObject, AHardenedDriveRefusesToBeSet) {
    device_.adapter().protect({.harden = true});
    EXPECT_EQ(set(1, "00"), refused(0x10, 0x0F));
    EXPECT_EQ(set(6, little(77)), refused(0x10, 0x0F));
    EXPECT_EQ(device_.call("04 02 20 43 24 01 0100 0100 00"), refused(0x04, 0x0F));
    EXPECT_EQ(get(1), told("01"));
    EXPECT_EQ(get(6), told(little(1'000'000)));
}

TEST(NoTimeSync, D_1_NeitherTheObjectNorTheDscpOfPtpExists) {
    AdapterHarness device;
    device.register_session();
    EXPECT_EQ(device.call("0E 03 20 43 24 01 30 02"), hex("8E 00 05 00"));
    EXPECT_EQ(device.call("0E 03 20 48 24 01 30 02"), hex("8E 00 14 00"));
    EXPECT_EQ(device.call("0E 03 20 48 24 01 30 03"), hex("8E 00 14 00"));
}

}  // namespace
}  // namespace servobus::test
