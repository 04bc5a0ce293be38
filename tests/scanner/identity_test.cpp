#include "scanner/identity.hpp"

#include <gtest/gtest.h>

#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner {
namespace {

using test::hex;

const Identity xenax{.vendor = 0x056D,
                     .device_type = 0x2B,
                     .product_code = 0x7509,
                     .major_revision = 1,
                     .minor_revision = 2,
                     .status = 0x0030,
                     .serial_number = 0x00A1B2C3,
                     .product_name = "XENAX"};
constexpr auto xenax_octets = "6D05 2B00 0975 01 02 3000 C3B2A100 05 58454E4158";

TEST(Identity, IsReadFromAttributesAll) {
    EXPECT_EQ(read_identity(hex(xenax_octets)), xenax);
    auto with_state = xenax;
    with_state.state = 3;
    EXPECT_EQ(read_identity(hex(std::string(xenax_octets) + "03")), with_state);
    EXPECT_EQ(read_identity(hex(std::string(xenax_octets) + "03 FF FF")), with_state) << "surplus octets";
}

TEST(Identity, IsNotReadFromLess) {
    auto octets = hex(xenax_octets);
    while (!octets.empty()) {
        octets.pop_back();
        EXPECT_EQ(read_identity(octets), std::nullopt);
    }
}

TEST(Identity, DescribesAttributes) {
    EXPECT_EQ(describe_identity_attribute(1, hex("6D 05")), "vendor 1389 (Jenny Science AG)");
    EXPECT_EQ(describe_identity_attribute(1, hex("FE FF")), "vendor 65534");
    EXPECT_EQ(describe_identity_attribute(2, hex("2B 00")), "device type 43 (generic device)");
    EXPECT_EQ(describe_identity_attribute(3, hex("09 75")), "product code 29961 (0x7509)");
    EXPECT_EQ(describe_identity_attribute(4, hex("01 02")), "revision 1.2");
    EXPECT_EQ(describe_identity_attribute(5, hex("61 00")), "status 0x0061 (owned, I/O runs)");
    EXPECT_EQ(describe_identity_attribute(6, hex("C3 B2 A1 00")), "serial number 0x00A1B2C3");
    EXPECT_EQ(describe_identity_attribute(7, hex("02 41 42")), "product name AB");
    EXPECT_EQ(describe_identity_attribute(8, hex("03")), "state 3 (operational)");
    EXPECT_EQ(describe_identity_attribute(8, hex("77")), "state 119 (unknown)");
    EXPECT_EQ(describe_identity_attribute(9, hex("03")), "");
    EXPECT_EQ(describe_identity_attribute(0, hex("03")), "");
    EXPECT_EQ(describe_identity_attribute(7, hex("03 41 42")), "");
}

TEST(Identity, TellsTheStatusInWords) {
    EXPECT_EQ(status_text(0x0030), "no I/O connection");
    EXPECT_EQ(status_text(0x0F05),
              "owned, configured, minor recoverable fault, minor unrecoverable fault, "
              "major recoverable fault, major unrecoverable fault, self test or unknown");
    EXPECT_EQ(status_text(0x0090), "vendor's status 9");
}

}  // namespace
}  // namespace servobus::scanner
