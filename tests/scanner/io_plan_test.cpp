// What a plan asks for, octet by octet as the golden vectors have it.
#include "scanner/io_plan.hpp"

#include <gtest/gtest.h>

#include "enip/encapsulation.hpp"
#include "enip/messages.hpp"
#include "tests/support/golden.hpp"

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;
using cip::ConnectionType;
using servobus::test::hex;

constexpr cip::ConnectionTriad triad{1, 0x004D, 0x11223344};
const cip::ElectronicKey key{1389, 43, 29961, 0x81, 1};

IoPlan plan(std::string_view connection) {
    auto made = plan_of(*assemblies::find_connection(connection));
    made.key = key;
    return made;
}

cip::ConnectionTriad numbered(std::uint16_t serial) {
    auto made = triad;
    made.serial_number = serial;
    return made;
}

/// The message that a vector carries, and the items beside it.
enip::SendData golden(std::string_view name) {
    const auto* vector = test::find_golden_vector(name);
    EXPECT_NE(vector, nullptr) << name;
    const auto frame = enip::Frame::parse(vector->octets);
    EXPECT_TRUE(frame.has_value());
    return enip::SendData::parse(frame->data).value();
}

std::string golden_message(std::string_view name) { return hex(enip::unconnected_message(golden(name)).value()); }

std::string message(const cip::ForwardOpen& open) { return hex(open_request(open).encode()); }

TEST(IoPlan, AsksForMulticast) {
    auto made = plan("standard");
    made.t_to_o.type = ConnectionType::multicast;
    // The target ignores our T->O id, whatever it is (R-CON-16).
    EXPECT_EQ(message(made.forward_open(0, 0x4D010001, triad)), golden_message("fo_eo_101_100_mcast_req"));
}

TEST(IoPlan, AsksForPointToPoint) {
    EXPECT_EQ(message(plan("iforce").forward_open(0, 0x0A110003, numbered(3))),
              golden_message("fo_eo_102_100_p2p_req"));
}

TEST(IoPlan, ClosesWithTheSamePath) {
    EXPECT_EQ(hex(close_request(plan("standard").forward_open(0, 0, triad)).encode()), golden_message("fc_eo_req"));
}

TEST(IoPlan, AsksForChangeOfStateWithItsInhibitTime) {  // R-CON-50, R-CON-51
    auto made = plan("standard");
    made.trigger = enip::Trigger::change_of_state;
    made.inhibit = 5ms;
    EXPECT_EQ(message(made.forward_open(0, 0x0A11000D, numbered(13))), golden_message("fo_eo_101_100_cos_pit_req"));
}

TEST(IoPlan, AsksInTheLargeForm) {  // R-CON-2
    auto made = plan("standard");
    made.large = true;
    EXPECT_EQ(message(made.forward_open(0, 0x0A110009, numbered(9))), golden_message("lfo_eo_101_100_req"));
}

TEST(IoPlan, AsksForHeartbeats) {  // R-CON-8
    auto made = plan("input-only");
    made.o_to_t.rpi = 100ms;
    made.t_to_o.type = ConnectionType::multicast;
    EXPECT_EQ(message(made.forward_open(0, 0, numbered(7))), golden_message("fo_io_heartbeat_req"));
}

TEST(IoPlan, AsksForNothing) {  // R-CON-23
    auto made = plan("standard");
    made.o_to_t.type = ConnectionType::null;
    made.t_to_o.type = ConnectionType::null;
    EXPECT_TRUE(made.is_null());
    EXPECT_EQ(message(made.forward_open(0, 0, numbered(0x2B))), golden_message("fo_null_unmatched_req"));
}

TEST(IoPlan, KnowsEveryConnectionOfTheDrive) {  // R-CON-9
    for (const auto& connection : assemblies::connections()) {
        const auto made = plan_of(connection);
        EXPECT_EQ(made.o_to_t.connection_size(), connection.o_to_t_size()) << connection.name;
        EXPECT_EQ(made.t_to_o.connection_size(), connection.t_to_o_size()) << connection.name;
        EXPECT_EQ(made.o_to_t.point, connection.o_to_t_point);
        EXPECT_EQ(made.t_to_o.point, connection.t_to_o_point);
        EXPECT_EQ(made.t_to_o.type, ConnectionType::point_to_point);
        EXPECT_EQ(made.o_to_t.rpi, 10ms);
    }
}

TEST(IoPlan, PutsThePathTogether) {  // R-CON-10
    IoPlan made;
    made.o_to_t.point = 0x1234;
    made.t_to_o.point = 0x64;
    made.configuration_instance = std::nullopt;
    EXPECT_EQ(hex(made.path().encode()), hex("20 04 2D 00 34 12 2C 64"));
    made.configuration_instance = 3;
    made.configuration = {1, 2, 3, 4};
    EXPECT_EQ(hex(made.path().encode()), hex("20 04 24 03 2D 00 34 12 2C 64 80 02 01 02 03 04"));
    made.route = cip::Path({cip::PortSegment{1, {0}}});
    EXPECT_EQ(hex(made.path().encode()), hex("01 00 20 04 24 03 2D 00 34 12 2C 64 80 02 01 02 03 04"));
}

TEST(IoPlan, TakesTheLargeFormWhenASizeNeedsIt) {
    IoPlan made;
    made.o_to_t.data_octets = 505;  // and 6 of count and header
    EXPECT_FALSE(made.needs_large());
    made.o_to_t.data_octets = 506;
    EXPECT_TRUE(made.needs_large());
    EXPECT_EQ(made.forward_open(0, 0, triad).o_to_t.size, 512);
}

TEST(IoPlan, TheRedundantOwnerIsTheOneOfOutputs) {
    IoPlan made;
    made.redundant_owner = true;
    const auto open = made.forward_open(0, 0, triad);
    EXPECT_TRUE(open.o_to_t.redundant_owner);
    EXPECT_FALSE(open.t_to_o.redundant_owner);
}

}  // namespace
}  // namespace servobus::scanner
