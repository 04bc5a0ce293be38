#include "scanner/multiple_service.hpp"

#include <gtest/gtest.h>

#include "cip/services.hpp"
#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner {
namespace {

using test::hex;

const std::vector<cip::Request> requests{{0x0E, cip::Path::to(0x64, 1, 0), {}}, {0x10, cip::Path::to(0x65, 1, 2), {7}}};

boost::system::result<std::vector<cip::Response>> read(std::string_view data) {
    return multiple_service_responses(requests, {0x0A, {}, hex(data)});
}

TEST(MultipleService, WritesOffsetsFromTheCount) {
    const auto packet = multiple_service_packet(requests);
    EXPECT_EQ(packet.encode(),
              hex("0A 02 20 02 24 01  02 00 06 00 0E 00  0E 03 20 64 24 01 30 00  10 03 20 65 24 01 30 02 07"));
    EXPECT_EQ(packet.encode().size(), packet_overhead + packet_share(requests[0]) + packet_share(requests[1]));
}

TEST(MultipleService, ReadsResponses) {
    const auto responses = read("02 00 06 00 0E 00  8E 00 00 00 14 00 00 00  90 00 0E 00");
    ASSERT_TRUE(responses.has_value());
    EXPECT_EQ(responses->at(0), (cip::Response{0x0E, {}, hex("14 00 00 00")}));
    EXPECT_EQ(responses->at(1), (cip::Response{0x10, cip::GeneralStatus::attribute_not_settable, {}}));
    EXPECT_TRUE(read("02 00 08 00 0E 00  FF FF  8E 00 00 00 00 00  90 00 0E 00")) << "a gap is no harm";
}

TEST(MultipleService, TellsNonsense) {
    for (const auto* data : {"", "02", "01 00 04 00 8E 00 00 00", "02 00 06 00", "02 00 06 00 0E 00 8E 00 00 00",
                             "02 00 05 00 0A 00 8E 00 00 00 90 00 00 00", "02 00 0A 00 06 00 90 00 00 00 8E 00 00 00",
                             "02 00 06 00 0A 00 90 00 00 00 8E 00 00 00", "02 00 06 00 FF FF 8E 00 00 00 90 00 00 00",
                             "02 00 06 00 09 00 8E 00 00 90 00 00 00", "FF FF"}) {
        const auto responses = read(data);
        ASSERT_FALSE(responses) << data;
        EXPECT_EQ(responses.error(), make_error_code(Error::unexpected_data));
    }
}

}  // namespace
}  // namespace servobus::scanner
