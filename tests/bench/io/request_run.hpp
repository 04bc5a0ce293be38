// Many explicit requests over plain sockets: as many sessions as wanted, as many requests of each on their way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/bench/io/clock.hpp"
#include "tests/bench/io/explicit_client.hpp"
#include "tests/bench/io/sockets.hpp"

namespace servobus::bench {

/// One TCP connection on which one frame is sent again and again.
struct RequestStream {
    Descriptor socket;
    cip::Bytes frame;
    /// Where a 16-bit number that counts up stands in the frame, as connected messages need it.
    std::optional<std::size_t> sequence_at{};
    std::uint16_t sequence = 0;
};

struct RequestRun {
    std::vector<double> waits_us;  ///< of each request, from the call that sends it to the one that yields its reply
    double seconds = 0;
    [[nodiscard]] double rate() const { return static_cast<double>(waits_us.size()) / seconds; }
};

/// Keeps `depth` requests of each stream on their way for a time. Each reply has `reply_octets`. What is answered in
/// one read is asked again in one write.
[[nodiscard]] RequestRun run_requests(std::vector<RequestStream>& streams, std::size_t depth, std::size_t reply_octets,
                                      double seconds);

}  // namespace servobus::bench
