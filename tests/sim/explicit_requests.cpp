#include "tests/sim/explicit_requests.hpp"

#include <algorithm>
#include <array>

#include "tests/support/octets.hpp"

namespace servobus::sim {
namespace {

using servobus::test::octets;

// clang-format off
constexpr std::array<ExplicitRequest, 14> requests{{
    {"vendor",                         0x0E, "20 01 24 01 30 01", "",            0x00, 2,  "6D 05"},
    {"identity",                       0x01, "20 01 24 01",       "",            0x00, {}, "6D 05 2B 00"},
    {"process status",                 0x0E, "20 64 24 01 30 06", "",            0x00, 4,  ""},
    {"status word",                    0x0E, "20 66 24 01 30 01", "",            0x00, 2,  ""},
    {"input assembly",                 0x0E, "20 04 24 64 30 03", "",            0x00, 28, ""},
    {"following error window, set",    0x10, "20 66 24 01 30 25", "D0 07 00 00", 0x00, 0,  ""},
    {"the same, out of its limits",    0x10, "20 66 24 01 30 25", "00 00 00 00", 0x09, {}, ""},
    {"the same, too short",            0x10, "20 66 24 01 30 25", "D0 07",       0x13, {}, ""},
    {"an attribute that is not there", 0x0E, "20 66 24 01 30 EE", "",            0x14, {}, ""},
    {"an object that is not there",    0x0E, "20 99 24 01 30 01", "",            0x05, {}, ""},
    {"a service that is not there",    0x32, "20 66 24 01",       "",            0x08, {}, ""},
    {"counter of the manager",         0x0E, "20 06 24 01 30 01", "",            0x00, 2,  ""},
    {"TCP/IP status",                  0x0E, "20 F5 24 01 30 01", "",            0x00, 4,  ""},
    {"two at once",                    0x0A, "20 02 24 01",
     "02 00 06 00 0E 00 0E 03 20 01 24 01 30 01 0E 03 20 66 24 01 30 01",        0x00, {}, "02 00"},
}};
// clang-format on

}  // namespace

std::span<const ExplicitRequest> explicit_requests() { return requests; }

cip::Request request_of(const ExplicitRequest& request) {
    return {request.service, cip::Path::parse(octets(request.path)).value(), octets(request.data)};
}

bool fits(const ExplicitRequest& request, const cip::Response& response) {
    const auto beginning = octets(request.beginning);
    const bool data = response.data.size() >= beginning.size() &&
                      std::equal(beginning.begin(), beginning.end(), response.data.begin());
    return static_cast<std::uint8_t>(response.status.general) == request.status && data &&
           (!request.size || response.data.size() == *request.size);
}

}  // namespace servobus::sim
