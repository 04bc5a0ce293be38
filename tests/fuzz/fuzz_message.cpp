// The message router over a whole drive. The first octet chooses how long a reply may be.
#include <cstddef>
#include <cstdint>

#include "tests/support/everything.hpp"

using namespace servobus;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 1) return 0;
    // One drive for all: what an input leaves behind must not harm the next.
    static test::DriveRouter router;
    const cip::ByteView message(data + 1, size - 1);
    router.ask(message, data[0] == 0xFF ? cip::max_message_bytes : 4 + 2 * std::size_t{data[0]});
    test::decode_everything(message);
    return 0;
}
