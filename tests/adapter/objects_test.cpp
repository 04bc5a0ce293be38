// Identity, Assembly and the drive's own classes through the whole target, hex in and hex out (R-ID, R-ASM, R-DEV).
#include <gtest/gtest.h>

#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

constexpr std::string_view get_s_curve = "0E 03 20 64 24 01 30 00";
const std::string s_curve = hex("8E 00 00 00 14 00 00 00");
const std::string done = hex("90 00 00 00");

drive::Device xenax(std::string_view key, drive::Motor motor = drive::Motor::any) {
    return drive::Device(*drive::xenax_model(key), motor);
}

TEST(Identity, R_ID_1_SaysWhoItIs) {
    Site site;
    auto peer = registered(site);
    const auto get = [&](unsigned id) { return peer.call(fmt::format("0E 03 20 01 24 01 30 {:02X}", id)); };
    EXPECT_EQ(get(1), hex("8E 00 00 00 6D 05"));
    EXPECT_EQ(get(2), hex("8E 00 00 00 2B 00"));
    EXPECT_EQ(get(3), hex("8E 00 00 00 09 75"));
    EXPECT_EQ(get(4), hex("8E 00 00 00 01 01"));
    EXPECT_EQ(get(5), hex("8E 00 00 00 30 00"));
    EXPECT_EQ(get(6), hex("8E 00 00 00 C3 B2 A1 00"));
    EXPECT_EQ(get(7), hex("8E 00 00 00 0F 58454E4158205876692037355638 53"));
    EXPECT_EQ(get(8), hex("8E 00 00 00 03"));
    EXPECT_EQ(get(0), hex("8E 00 14 00"));
    EXPECT_EQ(get(9), hex("8E 00 14 00"));
}

TEST(Identity, R_ID_2_IsNotWritten) {
    Site site;
    EXPECT_EQ(registered(site).call("10 03 20 01 24 01 30 06 01 00 00 00"), hex("90 00 08 00"));
}

TEST(Identity, R_ID_6_AllAttributes) {
    Site site;
    EXPECT_EQ(registered(site).call("01 02 20 01 24 01"),
              hex("81 00 00 00 6D05 2B00 0975 0101 3000 C3B2A100 0F 58454E4158205876692037355638 53"));
}

TEST(Identity, R_OBJ_3_AllClassAttributes) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call("01 02 20 01 24 00"), hex("81 00 00 00 0100 0100 0700 0A00"));
    EXPECT_EQ(peer.call("0E 03 20 01 24 00 30 01"), hex("8E 00 00 00 01 00"));
    EXPECT_EQ(peer.call("05 02 20 01 24 00"), hex("85 00 08 00"));
}

TEST(Identity, R_MSG_14_AttributeList) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call("03 02 20 01 24 01 0200 0100 0600"), hex("83 00 00 00 0200 0100 0000 6D05 0600 0000 C3B2A100"));
    EXPECT_EQ(peer.call("03 02 20 01 24 01 0200 0100 6300"), hex("83 00 0A 00 0200 0100 0000 6D05 6300 1400"));
    EXPECT_EQ(peer.call("03 02 20 01 24 01 0200 0100"), hex("83 00 13 00"));
    EXPECT_EQ(peer.call("03 02 20 01 24 01 0100 0100 02"), hex("83 00 15 00"));
    EXPECT_EQ(peer.call("03 02 20 01 24 01"), hex("83 00 13 00"));
}

TEST(Identity, R_ID_7_ListIdentityAgreesWithTheAttributes) {
    for (const auto& model : drive::xenax_models()) {
        Site site({}, drive::Device(model));
        auto peer = registered(site);
        const auto all = octets(peer.call("01 02 20 01 24 01")).size() - 4;
        const auto list = octets(peer.send(frame("63 00")));
        // The item's attributes begin behind version and socket address; the state ends it.
        const auto item = cip::ByteView(list).subspan(24 + 2 + 4 + 18);
        EXPECT_EQ(hex(item.first(all)), peer.call("01 02 20 01 24 01").substr(12)) << model.name;
        EXPECT_EQ(item.size(), all + 1);
        EXPECT_EQ(item.back(), 3);
    }
}

class IdentityReset : public testing::Test {
protected:
    const std::string written = hex("8E 00 00 00 32 00 00 00");

    // A parameter that a restart keeps and factory defaults do not, process data over it, and what no reset keeps: an
    // assembly's memory, a counter, an open connection.
    void spoil() {
        EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 32 00 00 00"), done);
        EXPECT_EQ(peer_.call("10 03 20 04 24 65 30 03 07000000 10270000 10270000 0A000000 0000"), done);
        peer_.open_class3();
    }
    void expect_restarted(const std::string& s_curve_then) {
        EXPECT_FALSE(peer_.open());
        EXPECT_EQ(site_.expired, std::vector{peer_.id()});
        peer_.close();
        EXPECT_EQ(site_.adapter.sessions(), 0U);
        EXPECT_EQ(site_.adapter.class3_connections(), 0U);
        auto next = registered(site_);
        EXPECT_EQ(next.call(get_s_curve), s_curve_then);
        EXPECT_EQ(next.call("0E 03 20 04 24 65 30 03"), hex("8E 00 00 00" + std::string(36, '0'))) << "R-ASM-2";
        EXPECT_EQ(next.call("0E 03 20 06 24 01 30 01"), hex("8E 00 00 00 00 00"));
    }
    Site site_;
    Peer peer_ = registered(site_);
};

TEST_F(IdentityReset, R_ID_8_Type0RestartsAHundredMillisecondsAfterTheReply) {
    for (const auto* request : {"05 02 20 01 24 01 00"}) {
        spoil();
        EXPECT_EQ(peer_.call(request), hex("85 00 00 00"));
        site_.advance(99ms);
        EXPECT_TRUE(peer_.open());
        EXPECT_EQ(peer_.call(get_s_curve), hex("8E 00 00 00 0A 00 00 00"));
        site_.advance(1ms);
        expect_restarted(written);
    }
}

TEST_F(IdentityReset, R_ID_8_NoTypeIsType0) {
    spoil();
    EXPECT_EQ(peer_.call("05 02 20 01 24 01"), hex("85 00 00 00"));
    site_.advance(100ms);
    expect_restarted(written);
}

TEST_F(IdentityReset, R_ID_8_AskingAgainDoesNotPutItOff) {
    spoil();
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    site_.advance(60ms);
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    site_.advance(40ms);
    expect_restarted(written);
}

TEST_F(IdentityReset, R_ID_8_Type1BringsTheFactoryDefaults) {
    spoil();
    EXPECT_EQ(peer_.call("10 03 20 F5 24 01 30 0D 0A 00"), done);
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 01"), hex("85 00 00 00"));
    site_.advance(100ms);
    expect_restarted(s_curve);
    EXPECT_EQ(registered(site_).call("0E 03 20 F5 24 01 30 0D"), hex("8E 00 00 00 78 00"));
}

TEST_F(IdentityReset, R_ID_8_Type0KeepsTheNetworkSettings) {
    EXPECT_EQ(peer_.call("10 03 20 F5 24 01 30 0D 0A 00"), done);
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
    site_.advance(100ms);
    peer_.close();
    EXPECT_EQ(registered(site_).call("0E 03 20 F5 24 01 30 0D"), hex("8E 00 00 00 0A 00"));
}

TEST_F(IdentityReset, R_ID_8_Type2BringsTheFactoryDefaultsButForTheNetwork) {
    spoil();
    EXPECT_EQ(peer_.call("10 03 20 F5 24 01 30 0D 0A 00"), done);
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 02"), hex("85 00 00 00"));
    site_.advance(100ms);
    expect_restarted(s_curve);
    EXPECT_EQ(registered(site_).call("0E 03 20 F5 24 01 30 0D"), hex("8E 00 00 00 0A 00"));
}

TEST_F(IdentityReset, R_ID_8_OtherTypesAreRefusedAndNothingHappens) {
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 32 00 00 00"), done);
    for (const auto* type : {"03", "05", "FF"}) {
        EXPECT_EQ(peer_.call(std::string("05 02 20 01 24 01 ") + type), hex("85 00 20 00")) << type;
    }
    EXPECT_EQ(peer_.call("05 02 20 01 24 01 00 00"), hex("85 00 15 00"));
    site_.advance(1s);
    EXPECT_TRUE(peer_.open());
    EXPECT_EQ(peer_.call(get_s_curve), hex("8E 00 00 00 32 00 00 00"));
}

TEST_F(IdentityReset, R_ID_8_ClosesEveryConnection) {
    auto other = registered(site_, 0xC0A80202);
    Peer unregistered(site_);
    EXPECT_EQ(peer_.call("05 02 20 01 24 01"), hex("85 00 00 00"));
    site_.advance(100ms);
    EXPECT_FALSE(other.open());
    EXPECT_FALSE(unregistered.open());
    EXPECT_EQ(site_.expired, (std::vector{peer_.id(), other.id(), unregistered.id()}));
}

TEST(ShutDown, ClosesEveryConnectionAndAnswersNothingMore) {
    Site site;
    auto peer = registered(site);
    site.adapter.shut_down();
    EXPECT_FALSE(peer.open());
    EXPECT_EQ(site.adapter.take_expired(), std::vector{peer.id()});
    EXPECT_EQ(peer.send(frame("64 00")), "");
}

TEST(Assembly, R_ASM_2_InputsAreFresh) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call("0E 03 20 04 24 64 30 03"), hex("8E 00 00 00" + std::string(56, '0')));
    site.device.store().assign(*site.device.find({0x66, 0x01}), std::int64_t{0x0237});
    site.device.store().assign(*site.device.find({0x66, 0x24}), std::int64_t{-2});
    EXPECT_EQ(peer.call("0E 03 20 04 24 64 30 03"),
              hex("8E 00 00 00 3702 0000 FEFFFFFF 00000000 00000000 00000000 00000000 00000000"));
}

TEST(Assembly, R_ASM_2_OutputsAreWhatWasLastWritten) {
    Site site;
    auto peer = registered(site);
    const std::string data = "64000000 10270000 204E0000 32000000 0F00";
    EXPECT_EQ(peer.call("0E 03 20 04 24 65 30 03"), hex("8E 00 00 00" + std::string(36, '0'))) << "zeros before";
    EXPECT_EQ(peer.call("10 03 20 04 24 65 30 03" + data), done);
    EXPECT_EQ(peer.call("0E 03 20 04 24 65 30 03"), hex("8E 00 00 00" + data));
    EXPECT_EQ(peer.call("0E 03 20 66 24 01 30 3A"), hex("8E 00 00 00 64000000")) << "it is in the drive";
    EXPECT_EQ(peer.call("0E 03 20 66 24 01 30 00"), hex("8E 00 00 00 0F00"));
    EXPECT_EQ(peer.call("0E 03 20 04 24 66 30 03"), hex("8E 00 00 00" + std::string(40, '0'))) << "the others stay";
}

TEST(Assembly, R_ASM_1_and_3_Sizes) {
    Site site;
    auto peer = registered(site);
    for (const auto& [instance, size] : {std::pair(100, 28),
                                         {101, 18},
                                         {102, 20},
                                         {103, 32},
                                         {104, 36},
                                         {105, 32},
                                         {112, 48},
                                         {113, 40},
                                         {1, 0},
                                         {254, 0},
                                         {255, 0}}) {
        EXPECT_EQ(peer.call(fmt::format("0E 03 20 04 24 {:02X} 30 04", instance)),
                  hex(fmt::format("8E 00 00 00 {:02X} 00", size)));
        EXPECT_EQ(octets(peer.call(fmt::format("0E 03 20 04 24 {:02X} 30 03", instance))).size(),
                  4U + static_cast<unsigned>(size));
        EXPECT_EQ(peer.call(fmt::format("10 03 20 04 24 {:02X} 30 04 01 00", instance)), hex("90 00 0E 00"));
        for (const int attribute : {0, 1, 2, 5}) {
            EXPECT_EQ(peer.call(fmt::format("0E 03 20 04 24 {:02X} 30 {:02X}", instance, attribute)),
                      hex("8E 00 14 00"));
        }
        EXPECT_EQ(peer.call(fmt::format("0E 02 20 04 24 {:02X}", instance)), hex("8E 00 14 00"));
    }
}

TEST(Assembly, R_ASM_4_LengthMustFit) {
    Site site;
    auto peer = registered(site);
    for (const auto& [instance, size] : {std::pair(101U, 18U), {102U, 20U}, {103U, 32U}, {104U, 36U}, {112U, 48U}}) {
        const auto set = fmt::format("10 03 20 04 24 {:02X} 30 03", instance);
        EXPECT_EQ(peer.call(set + std::string(2UL * (size - 1), '0')), hex("90 00 13 00"));
        EXPECT_EQ(peer.call(set + std::string(2UL * (size + 1), '0')), hex("90 00 15 00"));
        EXPECT_EQ(peer.call(set), hex("90 00 13 00"));
    }
}

TEST(Assembly, R_ASM_4_OneBadMemberRefusesAll) {
    Site site;
    auto peer = registered(site);
    // Position 7, speed 10000, acceleration 10000, S-curve 101 (at most 100), control word.
    EXPECT_EQ(peer.call("10 03 20 04 24 65 30 03 07000000 10270000 10270000 65000000 0F00"), hex("90 00 09 00"));
    EXPECT_EQ(peer.call("0E 03 20 66 24 01 30 3A"), hex("8E 00 00 00 00000000")) << "not even the members before it";
    EXPECT_EQ(peer.call("0E 03 20 66 24 01 30 00"), hex("8E 00 00 00 0000"));
    EXPECT_EQ(peer.call("0E 03 20 04 24 65 30 03"), hex("8E 00 00 00" + std::string(36, '0')));
}

TEST(Assembly, R_ASM_4_TheDriveRefusesAMember) {
    Site site({}, xenax("75v8"));
    auto peer = registered(site);
    // 104 ends with LimitForce, which needs the force option.
    EXPECT_EQ(peer.call("10 03 20 04 24 68 30 03 07000000 10270000 10270000 14000000 0F00 6400 64000000 64000000 "
                        "00000000 00000000"),
              hex("90 00 1F 01 01 00"));
    EXPECT_EQ(peer.call("0E 03 20 66 24 01 30 3A"), hex("8E 00 00 00 00000000"));
    EXPECT_EQ(
        peer.call("10 03 20 04 24 67 30 03 07000000 10270000 10270000 14000000 0F00 6400 64000000 64000000 00000000"),
        done);
}

TEST(Assembly, R_ASM_5_WhatIsNoOutputIsNotSettable) {
    Site site;
    auto peer = registered(site);
    for (const int instance : {100, 105, 113, 1, 254, 255}) {
        EXPECT_EQ(peer.call(fmt::format("10 03 20 04 24 {:02X} 30 03 00", instance)), hex("90 00 0E 00")) << instance;
    }
}

TEST(Assembly, R_ASM_6_UnknownInstancesAndServices) {
    Site site;
    auto peer = registered(site);
    for (const int instance : {2, 99, 106, 111, 114, 253}) {
        EXPECT_EQ(peer.call(fmt::format("0E 03 20 04 24 {:02X} 30 03", instance)), hex("8E 00 05 00")) << instance;
    }
    EXPECT_EQ(peer.call("08 02 20 04 24 00"), hex("88 00 08 00"));
    EXPECT_EQ(peer.call("08 02 20 04 24 65"), hex("88 00 08 00"));
    EXPECT_EQ(peer.call("0E 03 20 04 24 00 30 01"), hex("8E 00 00 00 02 00")) << "R-OBJ-2";
}

TEST(Assembly, R_ASM_7_PaddingReadsBackAsZero) {
    Site site;
    auto peer = registered(site);
    const std::string members = "07000000 10270000 10270000 14000000 0F00 6400 64000000 64000000 00000000 64000000";
    const std::string stamp = "0102030405060708";
    EXPECT_EQ(peer.call("10 03 20 04 24 70 30 03" + members + "DEADBEEF" + stamp), done);
    EXPECT_EQ(peer.call("0E 03 20 04 24 70 30 03"), hex("8E 00 00 00" + members + "00000000" + stamp));
}

TEST(ElectronicKey, LeadsAnExplicitPath) {
    Site site;
    auto peer = registered(site);
    EXPECT_EQ(peer.call("0E 08 34 04 6D05 2B00 0975 01 01 2064 2401 3000"), s_curve);
    EXPECT_EQ(peer.call("0E 08 34 04 0000 0000 0000 00 00 2064 2401 3000"), s_curve);
    EXPECT_EQ(peer.call("0E 08 34 04 6D05 2B00 0975 81 01 2064 2401 3000"), s_curve);
    for (const auto* key : {"0100 2B00 0975 01 01", "6D05 0C00 0975 01 01", "6D05 2B00 0875 01 01",
                            "6D05 2B00 0975 02 01", "6D05 2B00 0975 01 02", "6D05 2B00 0975 81 02"}) {
        EXPECT_EQ(peer.call(std::string("0E 08 34 04 ") + key + "2064 2401 3000"), hex("8E 00 25 00")) << key;
    }
    EXPECT_EQ(peer.call("0E 08 34 07 6D05 2B00 0975 01 01 2064 2401 3000"), hex("8E 00 04 00")) << "an unknown format";
    EXPECT_EQ(peer.call("0E 08 20 64 34 04 6D05 2B00 0975 01 01 2401 3000"), hex("8E 00 04 00")) << "out of order";
}

TEST(ElectronicKey, FollowsTheVariant) {
    Site site({}, xenax("48v8"));
    auto peer = registered(site);
    EXPECT_EQ(peer.call("0E 08 34 04 6D05 2B00 0848 01 01 2064 2401 3000"), s_curve);
    EXPECT_EQ(peer.call("0E 08 34 04 6D05 2B00 0975 01 01 2064 2401 3000"), hex("8E 00 25 00"));
}

TEST(Variant, R_DEV_3_WithoutForceOptionItsRowsAnswerThatTheDriveRefuses) {
    Site site({}, xenax("75v8"));
    auto peer = registered(site);
    std::size_t rows = 0;
    for (const auto& row : site.device.store().table()) {
        if (!row.force_option) continue;
        ++rows;
        const auto path = fmt::format("03 20 {:02X} 24 01 30 {:02X}", row.cip.class_id, row.cip.attribute);
        if (drive::may_get(row.access)) {
            EXPECT_EQ(peer.call("0E " + path), hex("8E 00 1F 01 01 00")) << row.name;
        }
        if (drive::may_set(row.access)) {
            const auto value = row.is_text() ? std::string("0000") : std::string(2 * drive::size_of(row.cip.type), '0');
            EXPECT_EQ(peer.call("10 " + path + value), hex("90 00 1F 01 01 00")) << row.name;
        }
    }
    EXPECT_GT(rows, 16U);
    for (const auto& row : site.device.store().table()) {
        EXPECT_TRUE(row.cip.class_id != 0x6E || row.force_option) << row.name;
    }
}

TEST(Variant, WithForceOptionTheSameRowsAnswer) {
    Site site({}, xenax("75v8s"));
    auto peer = registered(site);
    EXPECT_EQ(peer.call("10 03 20 64 24 01 30 09 64 00 00 00"), done);
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 09"), hex("8E 00 00 00 64 00 00 00"));
}

TEST(Variant, R_DEV_3_ALinearMotorTakesNoRotativeReferenceMethod) {
    Site site({}, xenax("75v8s", drive::Motor::linear));
    auto peer = registered(site);
    const auto& row = *site.device.find({0x66, 0x58});
    const auto set = [&](std::uint8_t method) {
        cip::Bytes request = octets("10 03 20 66 24 01 30 58");
        request.push_back(method);
        request.resize(request.size() + drive::size_of(row.cip.type) - 1);
        return peer.call(request);
    };
    EXPECT_EQ(set(0x0A), hex("90 00 1F 01 01 00"));
    EXPECT_EQ(set(0x06), done);
    EXPECT_EQ(set(0x07), hex("90 00 09 00"));
    EXPECT_EQ(set(0x10), hex("90 00 09 00"));
    EXPECT_EQ(site.device.store().value(row), drive::Value{std::int64_t{6}});
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 08"), hex("8E 00 00 00 0600 323330313031")) << "and its name is 230101";
}

// A second drive model is a second table; the adapter serves it without a line of its own.
constexpr std::array<drive::Parameter, 3> other_table{{
    {.name = "Zone",
     .mnemonic = "Z",
     .access = drive::Access::get_set,
     .low = -5,
     .standard = -1,
     .high = 7,
     .cip = {0x300, 1, 1, drive::Type::i8},
     .section = "1",
     .text = "The zone."},
    {.name = "Label",
     .mnemonic = "",
     .access = drive::Access::get_set,
     .standard_text = "abc",
     .max_length = 3,
     .cip = {0x301, 1, 0, drive::Type::text},
     .section = "2",
     .text = "A text at attribute 0."},
    {.name = "Far",
     .mnemonic = "",
     .access = drive::Access::get,
     .high = 9,
     .standard_text = {},
     .cip = {0x301, 1, 0x1234, drive::Type::u32},
     .section = "3",
     .text = "An attribute that needs 16 bits."},
}};

TEST(SecondModel, IsServedFromItsOwnTable) {
    const drive::Model model{.key = "other",
                             .name = "Other drive",
                             .identity = {.vendor = 1, .device_type = 2, .product_code = 3, .product_name = "Other"},
                             .parameters = other_table,
                             .direct_commands = {}};
    Site site({}, drive::Device(model));
    auto peer = registered(site);
    EXPECT_EQ(peer.call("01 02 20 01 24 01"), hex("81 00 00 00 0100 0200 0300 0101 3000 01000000 05 4F74686572"));
    EXPECT_EQ(peer.call("0E 05 21 00 00 03 24 01 30 01"), hex("8E 00 26 00")) << "five words, and only four are there";
    EXPECT_EQ(peer.call("0E 04 21 00 00 03 24 01 30 01"), hex("8E 00 00 00 FF"));
    EXPECT_EQ(peer.call("10 04 21 00 00 03 24 01 30 01 FB"), done);
    EXPECT_EQ(peer.call("10 04 21 00 00 03 24 01 30 01 FA"), hex("90 00 09 00"));
    EXPECT_EQ(peer.call("0E 03 21 00 01 03 24 01"), hex("8E 00 00 00 0300 616263")) << "attribute 0 is implied";
    EXPECT_EQ(peer.call("0E 03 21 00 00 03 24 01"), hex("8E 00 14 00")) << "and here there is none";
    EXPECT_EQ(peer.call("10 03 21 00 01 03 24 01 0400 61626364"), hex("90 00 09 00"));
    EXPECT_EQ(peer.call("0E 05 21 00 01 03 24 01 31 00 34 12"), hex("8E 00 00 00 00000000"));
    EXPECT_EQ(peer.call("0E 04 21 00 01 03 24 00 30 07"), hex("8E 00 00 00 34 12")) << "the largest attribute id";
    EXPECT_EQ(peer.call(get_s_curve), hex("8E 00 05 00")) << "no class of the XENAX";
    EXPECT_EQ(peer.call("10 03 20 04 24 65 30 03" + std::string(36, '0')), hex("90 00 1F 01 01 00"))
        << "its assemblies name rows that this drive does not have";
}

}  // namespace
}  // namespace servobus::test
