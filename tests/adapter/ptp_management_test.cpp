// PTP management messages, octet by octet. The answers were recorded from ptp4l 3.1.1.
#include "adapter/ptp_management.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/octets.hpp"

namespace servobus::test {
namespace {

using adapter::ManagementId;

const std::string header = "0D02 LLLL 00 00 0000 0000000000000000 00000000 5E88D9FFFE77A0B1 0000 0007 04 7F";
const std::string to_the_asker = "0000000000000000 0001 00 00 02 00";

// Of ptp4l, with the length of the whole message.
std::string recorded(const std::string& length, const std::string& tlv) {
    auto text = header + to_the_asker + tlv;
    return text.replace(text.find("LLLL"), 4, length);
}

const std::string default_data_set = "0001 0016 2000 01 00 0001 80 C8FEFFFF 80 5E88D9FFFE77A0B1 00 00";
const std::string refusal = "0002 0008 0004 2004 00000000";

template <class Set>
void expect_needs_all(const std::string& text, std::optional<Set> (*decode)(cip::ByteView)) {
    const auto data = octets(text);
    EXPECT_TRUE(decode(data));
    for (std::size_t size = 0; size < data.size(); ++size)
        EXPECT_FALSE(decode(cip::ByteView(data).first(size))) << size;
}

TEST(PtpManagement, AQuestionIsAGetToWhoeverListens) {
    EXPECT_EQ(hex(adapter::encode({.id = ManagementId::port_data_set, .port = 2, .sequence = 0x1234, .domain = 5})),
              hex("0D02 0036 05 00 0000 0000000000000000 00000000 0000000000000000 0001 1234 04 7F"
                  "FFFFFFFFFFFFFFFF 0002 00 00 00 00 0001 0002 2004"));
    EXPECT_EQ(hex(adapter::encode({})),
              hex("0D02 0036 00 00 0000 0000000000000000 00000000 0000000000000000 0001 0000 04 7F"
                  "FFFFFFFFFFFFFFFF FFFF 00 00 00 00 0001 0002 2000"));
}

TEST(PtpManagement, AnAnswerTellsWhatWasAsked) {
    const auto message = octets(recorded("004A", default_data_set));
    const auto answer = adapter::decode_answer(message);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->id, ManagementId::default_data_set);
    EXPECT_EQ(answer->sequence, 7);
    EXPECT_FALSE(answer->refused);
    const auto set = adapter::decode_default_data_set(answer->data);
    ASSERT_TRUE(set);
    EXPECT_FALSE(set->slave_only);
    EXPECT_EQ(set->ports, 1);
    EXPECT_EQ(set->priority_1, 128);
    EXPECT_EQ(set->quality, (adapter::ClockQuality{200, 0xFE, 0xFFFF}));
    EXPECT_EQ(set->priority_2, 128);
    EXPECT_EQ(set->identity, (adapter::ClockIdentity{0x5E, 0x88, 0xD9, 0xFF, 0xFE, 0x77, 0xA0, 0xB1}));
    EXPECT_EQ(set->domain, 0);
    expect_needs_all("01 00 0001 80 C8FEFFFF 80 5E88D9FFFE77A0B1 00", adapter::decode_default_data_set);
    EXPECT_TRUE(adapter::decode_default_data_set(octets("03 00 0001 80 C8FEFFFF 80 5E88D9FFFE77A0B1 05"))->slave_only);
}

TEST(PtpManagement, ARefusalSaysOfWhat) {
    const auto message = octets(recorded("003C", refusal));
    const auto answer = adapter::decode_answer(message);
    ASSERT_TRUE(answer);
    EXPECT_TRUE(answer->refused);
    EXPECT_EQ(answer->id, ManagementId::port_data_set);
}

TEST(PtpManagement, WhatIsNoWholeAnswerIsNone) {
    for (const auto& [length, tlv] : {std::pair{"004A", default_data_set}, std::pair{"003C", refusal}}) {
        const auto whole = octets(recorded(length, tlv));
        for (std::size_t size = 0; size < whole.size(); ++size) {
            EXPECT_FALSE(adapter::decode_answer(cip::ByteView(whole).first(size))) << size;
            // A message that says it is shorter ends there.
            auto shorter = whole;
            shorter[3] = static_cast<std::uint8_t>(size);
            const auto answer = adapter::decode_answer(shorter);
            EXPECT_FALSE(answer && !answer->refused) << size;
        }
        auto longer = whole;
        longer.push_back(0);
        EXPECT_TRUE(adapter::decode_answer(longer)) << "what comes after the message does not count";
    }
    const std::pair<std::size_t, std::uint8_t> spoilt[]{{0, 0x0B},    // an announcement
                                                        {1, 0x01},    // PTP version 1
                                                        {46, 0x00},   // a question
                                                        {49, 0x03}};  // another TLV
    for (const auto& [at, octet] : spoilt) {
        auto message = octets(recorded("004A", default_data_set));
        message[at] = octet;
        EXPECT_FALSE(adapter::decode_answer(message)) << at;
    }
    auto next_minor_version = octets(recorded("004A", default_data_set));
    next_minor_version[1] = 0x12;
    EXPECT_TRUE(adapter::decode_answer(next_minor_version)) << "IEEE 1588-2019 calls itself 2.1";
}

TEST(PtpManagement, CurrentDataSet) {
    const std::string text = "0001 FFFFFFFFFE0C0000 00000000061A8000";
    const auto set = adapter::decode_current_data_set(octets(text));
    ASSERT_TRUE(set);
    EXPECT_EQ(set->steps_removed, 1);
    EXPECT_EQ(set->offset_from_master, -500 * 65536);
    EXPECT_EQ(set->mean_path_delay, 1562 * 65536 + 32768);
    expect_needs_all(text, adapter::decode_current_data_set);
}

TEST(PtpManagement, ParentDataSet) {
    const std::string text = "E6DF21FFFE788278 0003 00 00 1234 7FFFFFFE 0A 06214E5D 0B E6DF21FFFE788277";
    const auto set = adapter::decode_parent_data_set(octets(text));
    ASSERT_TRUE(set);
    EXPECT_EQ(hex(set->parent.clock), hex("E6DF21FFFE788278"));
    EXPECT_EQ(set->parent.port, 3);
    EXPECT_EQ(set->observed_variance, 0x1234);
    EXPECT_EQ(set->observed_phase_change_rate, 0x7FFFFFFEU);
    EXPECT_EQ(set->grandmaster_priority_1, 10);
    EXPECT_EQ(set->grandmaster_quality, (adapter::ClockQuality{6, 0x21, 0x4E5D}));
    EXPECT_EQ(set->grandmaster_priority_2, 11);
    EXPECT_EQ(hex(set->grandmaster), hex("E6DF21FFFE788277"));
    expect_needs_all(text, adapter::decode_parent_data_set);
}

TEST(PtpManagement, TimePropertiesDataSet) {
    const auto set = adapter::decode_time_properties(octets("0025 3C 20"));
    ASSERT_TRUE(set);
    EXPECT_EQ(set->utc_offset, 37);
    EXPECT_EQ(set->flags, 0x3C);
    EXPECT_EQ(set->time_source, 0x20);
    expect_needs_all("0025 3C 20", adapter::decode_time_properties);
}

TEST(PtpManagement, PortDataSet) {
    const auto set =
        adapter::decode_port_data_set(octets("5E88D9FFFE77A0B1 0002 09 00 0000000000000000 FE 03 FD 01 00 02"));
    ASSERT_TRUE(set);
    EXPECT_EQ(set->identity.port, 2);
    EXPECT_EQ(hex(set->identity.clock), hex("5E88D9FFFE77A0B1"));
    EXPECT_EQ(set->state, adapter::PtpPortState::slave);
    EXPECT_EQ(set->log_announce_interval, -2);
    EXPECT_EQ(set->log_sync_interval, -3);
    expect_needs_all("5E88D9FFFE77A0B1 0002 09 00 0000000000000000 FE 03 FD", adapter::decode_port_data_set);
}

TEST(PtpManagement, ClockDescription) {
    const std::string text =
        "8000 0A 49454545203830322E33 0006 5E88D977A0B1 0001 0004 0A010102 000000 00 02 3B3B 02 3B3B 05 5072657373 "
        "001B19000100";
    const auto description = adapter::decode_clock_description(octets(text + "00"));
    ASSERT_TRUE(description);
    EXPECT_EQ(description->clock_type, 0x8000);
    EXPECT_EQ(description->physical_protocol, "IEEE 802.3");
    EXPECT_EQ(hex(description->physical_address), hex("5E88D977A0B1"));
    EXPECT_EQ(description->network_protocol, 1);
    EXPECT_EQ(hex(description->protocol_address), hex("0A010102"));
    EXPECT_EQ(description->user_description, "Press");
    EXPECT_EQ(hex(description->profile), hex("001B19000100"));
    expect_needs_all(text, adapter::decode_clock_description);
}

}  // namespace
}  // namespace servobus::test
