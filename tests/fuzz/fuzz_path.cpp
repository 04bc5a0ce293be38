// Paths: as segments, as the target of a request, and for people.
#include <cstddef>
#include <cstdint>

#include "cip/path.hpp"
#include "cip/request_path.hpp"
#include "tests/support/everything.hpp"

using namespace servobus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const cip::ByteView octets(data, size);
    const auto path = cip::Path::parse(octets);
    if (path) {
        const auto encoded = path->encode();
        test::require(encoded.size() <= octets.size(), "a path is not written longer than it was read", octets);
        test::require(encoded.size() % 2 == 0, "a path is a whole number of words", octets);
        const auto again = cip::Path::parse(encoded);
        test::require(again && *again == *path, "a path comes out the same", octets);
        (void)cip::describe(*path);
    }
    const auto target = cip::RequestPath::parse(octets);
    test::require(!target || path, "what a request is addressed to is a path", octets);
    if (target && target->key) (void)cip::mismatch(*target->key, cip::NodeIdentity{1389, 43, 0x7509, 1, 1});
    return 0;
}
