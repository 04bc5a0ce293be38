// The status word and state of the Identity object, by what they are made of (R-ID-3 to R-ID-5).
#include "adapter/identity_status.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "tests/adapter/fake_machine.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

using adapter::DeviceCondition;
using adapter::DeviceFault;
using adapter::identity_state;
using adapter::identity_status;
using adapter::IdentityState;
using adapter::IoCondition;

TEST(IdentityStatus, R_ID_4_AnIdleDeviceHasNoConnection) {
    EXPECT_EQ(identity_status({}), 0x0030);
    EXPECT_EQ(identity_state({}), IdentityState::operational);
}

TEST(IdentityStatus, R_ID_3_HasABitForEachThing) {
    EXPECT_EQ(identity_status({.owned = true, .io = IoCondition::running}), 0x0061);
    EXPECT_EQ(identity_status({.owned = true, .io = IoCondition::idle}), 0x0071);
    EXPECT_EQ(identity_status({.io = IoCondition::timed_out}), 0x0020);
    EXPECT_EQ(identity_status({.configured = true}), 0x0034);
    EXPECT_EQ(identity_status({.configuration_bad = true}), 0x0040);
    EXPECT_EQ(identity_status({.firmware_update = true}), 0x0010);
    EXPECT_EQ(identity_status({.fault = DeviceFault::minor_recoverable}), 0x0130);
    EXPECT_EQ(identity_status({.fault = DeviceFault::minor_unrecoverable}), 0x0230);
    EXPECT_EQ(identity_status({.fault = DeviceFault::major_recoverable}), 0x0450);
    EXPECT_EQ(identity_status({.fault = DeviceFault::major_unrecoverable}), 0x0850);
}

// Everything at once, and then without what came first each time: 5, 1, 4, 6, 2, 7, 3.
TEST(IdentityStatus, R_ID_4_TheExtendedStatusIsTheFirstByPriority) {
    DeviceCondition condition{.configuration_bad = true,
                              .firmware_update = true,
                              .fault = DeviceFault::major_recoverable,
                              .io = IoCondition::running};
    const std::vector<std::function<void()>> ends{
        [&] { condition.fault = DeviceFault::none; }, [&] { condition.firmware_update = false; },
        [&] { condition.configuration_bad = false; }, [&] { condition.io = IoCondition::timed_out; },
        [&] { condition.io = IoCondition::idle; },    [&] { condition.io = IoCondition::none; },
    };
    std::vector<int> seen{identity_status(condition) >> 4 & 0xF};
    for (const auto& end : ends) {
        end();
        seen.push_back(identity_status(condition) >> 4 & 0xF);
    }
    EXPECT_EQ(seen, (std::vector{5, 1, 4, 6, 2, 7, 3}));
}

TEST(IdentityStatus, R_ID_5_TheStateFollowsMajorFaultsAndTheAddress) {
    EXPECT_EQ(identity_state({.has_address = false}), IdentityState::standby);
    EXPECT_EQ(identity_state({.fault = DeviceFault::minor_recoverable}), IdentityState::operational);
    EXPECT_EQ(identity_state({.fault = DeviceFault::minor_unrecoverable}), IdentityState::operational);
    EXPECT_EQ(identity_state({.has_address = false, .fault = DeviceFault::major_recoverable}),
              IdentityState::major_recoverable_fault);
    EXPECT_EQ(identity_state({.fault = DeviceFault::major_unrecoverable}), IdentityState::major_unrecoverable_fault);
    EXPECT_EQ(static_cast<int>(IdentityState::standby), 2);
    EXPECT_EQ(static_cast<int>(IdentityState::operational), 3);
}

/// Status word and state, as attributes and as ListIdentity tells them.
class IdentityOfADevice : public testing::Test {
protected:
    std::string attributes() {
        const auto status = peer_.call("0E 03 20 01 24 01 30 05");
        const auto state = peer_.call("0E 03 20 01 24 01 30 08");
        return hex(octets(status.substr(12) + " " + state.substr(12)));
    }
    std::string listed() {
        const auto list = octets(peer_.send(frame("63 00")));
        constexpr std::size_t status_at = 24 + 2 + 4 + 18 + 8;
        if (list.size() <= status_at) return "no item";
        return hex(cip::Bytes{list[status_at], list[status_at + 1], list.back()});
    }
    void expect(std::string_view text) {
        EXPECT_EQ(attributes(), hex(text));
        EXPECT_EQ(listed(), hex(text)) << "R-ID-7";
    }

    Site site_{{}, device_with_fake_machine()};
    Peer peer_ = registered(site_);
};

TEST_F(IdentityOfADevice, R_ID_3_IsConfiguredOnceSomethingIsStoredThatIsNotAsDelivered) {
    expect("3000 03");
    EXPECT_EQ(peer_.call("10 03 20 66 24 01 30 3A 05 00 00 00"), hex("90 00 00 00"));
    expect("3000 03");
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 32 00 00 00"), hex("90 00 00 00"));
    expect("3400 03");
    EXPECT_EQ(peer_.call("10 03 20 64 24 01 30 00 14 00 00 00"), hex("90 00 00 00"));
    expect("3000 03");
    EXPECT_EQ(peer_.call("10 03 20 48 24 01 30 04 2E"), hex("90 00 00 00"));
    expect("3400 03");
}

TEST_F(IdentityOfADevice, R_ID_5_AFaultOfTheDriveIsAMinorRecoverableOne) {
    fake_machine().fault = true;
    expect("3001 03");
    fake_machine().fault = false;
    expect("3000 03");
}

TEST_F(IdentityOfADevice, R_ID_5_WithoutAnAddressItStandsBy) {
    site_.adapter.network().state.address.configured = false;
    expect("3000 02");
}

TEST_F(IdentityOfADevice, R_ID_4_TellsOfABadConfigurationUntilSomethingIsStored) {
    site_.adapter.report_bad_configuration();
    site_.adapter.store_with([](const adapter::StoredState&) {});
    expect("4000 03");
    EXPECT_EQ(peer_.call("10 03 20 48 24 01 30 04 2E"), "") << "it waits";
    site_.adapter.on_stored(true, site_.now);
    (void)site_.adapter.take_replies(peer_.id());
    expect("3400 03");
}

TEST_F(IdentityOfADevice, R_ID_4_ForgetsABadConfigurationWithThePower) {
    site_.adapter.report_bad_configuration();
    site_.adapter.inject(drive::event::PowerCycle{}, site_.now);
    Peer next = registered(site_);
    EXPECT_EQ(next.call("0E 03 20 01 24 01 30 05"), hex("8E 00 00 00 3000"));
}

TEST_F(IdentityOfADevice, HasNoHeartbeat) {
    EXPECT_EQ(peer_.call("0E 03 20 01 24 01 30 0A"), hex("8E 00 00 00 00"));
    EXPECT_EQ(peer_.call("10 03 20 01 24 01 30 0A 05"), hex("90 00 08 00"));
    EXPECT_EQ(peer_.call("0E 03 20 01 24 01 30 09"), hex("8E 00 14 00"));
    EXPECT_EQ(peer_.call("0E 03 20 01 24 01 30 0B"), hex("8E 00 14 00"));
}

}  // namespace
}  // namespace servobus::test
