// Somebody else claims the address of a drive that stands on an ordinary host (R-ACD-4, R-ACD-6, R-ACD-7).
#include <gtest/gtest.h>

#include "adapter/network_fault.hpp"
#include "tests/support/adapter_harness.hpp"

namespace servobus::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const std::string status = "0E 03 20 F5 24 01 30 01";
const std::string interface = "0E 03 20 F5 24 01 30 05";
const std::string latest_conflict = "0E 03 20 F5 24 01 30 0B";
const std::string home = "6402A8C0 00FFFFFF 00000000 00000000 00000000 0000";
const std::string nowhere = "00000000 00000000 00000000 00000000 00000000 0000";
// Activity 2, the rival's MAC address, and the ARP packet in which he says that he has 192.168.2.100.
const std::string conflict = "02 020000000001 0001 0800 06 04 0001 020000000001 C0A80264 000000000000 C0A80264";

adapter::Network on_a_host() {
    adapter::Network network;
    network.state.interface = {.address = AdapterHarness::local.address, .mask = 0xFFFFFF00};
    network.state.host = network.state.interface;
    return network;
}

class AddressRivalry : public testing::Test {
protected:
    AddressRivalry() { device_.register_session(); }
    std::string get(const std::string& request) {
        const auto reply = octets(device_.call(request));
        return reply.size() < 4 ? "no answer" : hex(cip::ByteView(reply).subspan(4));
    }
    void claim() {
        EXPECT_TRUE(device_.adapter().inject(adapter::NetworkFault(adapter::fault::ClaimAddress{}), device_.now()));
    }
    void come_back() {
        device_.advance(milliseconds(0));
        EXPECT_FALSE(device_.connected());
        device_.connect();
        device_.register_session();
    }

    AdapterHarness device_{drive::Device(drive::xenax_models().front()), {}, on_a_host()};
};

TEST_F(AddressRivalry, R_ACD_4_IsDefendedOnce) {
    EXPECT_EQ(get(latest_conflict), hex(std::string(70, '0')));
    claim();
    EXPECT_TRUE(device_.connected());
    EXPECT_EQ(get(status), hex("41000000"));
    EXPECT_EQ(get(interface), hex(home));
    EXPECT_EQ(get(latest_conflict), hex(conflict)) << "R-TCP-10";
    device_.advance(milliseconds(9999));
    EXPECT_EQ(get(status), hex("41000000"));
    device_.advance(milliseconds(1));
    EXPECT_EQ(get(status), hex("01000000")) << "R-ACD-6";
    EXPECT_EQ(get(latest_conflict), hex(conflict)) << "it is a record";
    claim();
    EXPECT_TRUE(device_.connected()) << "the defence before is long ago";
}

TEST_F(AddressRivalry, R_ACD_4_IsGivenUpToTheSecondClaim) {
    claim();
    device_.advance(seconds(5));
    claim();
    come_back();
    EXPECT_EQ(get(status), hex("C0000000"));
    EXPECT_EQ(get(interface), hex(nowhere));
    claim();
    EXPECT_EQ(get(status), hex("C0000000")) << "without an address there is nothing to claim";
    device_.advance(seconds(10));
    EXPECT_EQ(get(status), hex("01000000"));
    EXPECT_EQ(get(interface), hex(home));
}

TEST_F(AddressRivalry, R_ACD_6_EndsWhenTheRecordIsCleared) {
    claim();
    EXPECT_EQ(device_.call("10 03 20 F5 24 01 30 0B" + std::string(70, '0')), hex("90 00 00 00"));
    EXPECT_EQ(get(status), hex("01000000"));
    EXPECT_EQ(get(latest_conflict), hex(std::string(70, '0')));
}

TEST_F(AddressRivalry, R_TCP_9_IsNotNoticedWithoutDetection) {
    EXPECT_EQ(device_.call("10 03 20 F5 24 01 30 0A 00"), hex("90 00 00 00"));
    claim();
    EXPECT_EQ(get(status), hex("41000000")) << "from the next restart on";
    EXPECT_TRUE(device_.adapter().inject(adapter::NetworkFault(adapter::fault::Restart{}), device_.now()));
    device_.advance(seconds(2));
    device_.connect();
    device_.register_session();
    EXPECT_EQ(get(status), hex("01000000"));
    claim();
    EXPECT_EQ(get(status), hex("01000000"));
}

}  // namespace
}  // namespace servobus::test
