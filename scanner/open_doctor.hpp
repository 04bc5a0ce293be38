// The Forward-Open doctor: why an I/O connection did not open, or does not work, in words, and what to ask instead.
// Pure: a request and what became of it go in, a diagnosis comes out. Of a device that is known, it compares with what
// that device has; of others it says what the reply says and what is typical, and no more.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cip/forward_open.hpp"
#include "cip/status.hpp"
#include "enip/encapsulation.hpp"
#include "enip/endpoint.hpp"
#include "scanner/identity.hpp"
#include "scanner/io_plan.hpp"

namespace servobus::scanner {

/// What was asked, and of whom.
struct OpenQuestion {
    std::optional<cip::ForwardOpen> request{};  ///< nullopt: its lengths are wrong, and it cannot be read
    std::optional<Identity> identity{};         ///< of the device, when it is known
    cip::Path route{};                          ///< of the Unconnected_Send around the request
    std::optional<IoPlan> plan{};               ///< what the request was made from, when that is known
};

struct Diagnosis {
    bool well = false;                  ///< nothing is wrong
    bool may_pass = false;              ///< the same request may be granted later (R-SCN-4)
    std::string summary;                ///< a line without a full stop: the status in words, with its numbers
    std::vector<std::string> asked;     ///< a line for each direction and for what else was asked
    std::vector<std::string> findings;  ///< what certainly is so, a sentence each
    std::vector<std::string> causes;    ///< what may be the reason, the likeliest first, a sentence each
    std::vector<std::string> next;      ///< what to do, a sentence each
    std::optional<IoPlan> corrected{};  ///< what should be asked instead, when that can be told
};

/// The target, or a router on the way, has refused.
[[nodiscard]] Diagnosis diagnose_refusal(const OpenQuestion& question, const cip::Status& status);
/// The encapsulation layer has refused the message around the request.
[[nodiscard]] Diagnosis diagnose_refusal(const OpenQuestion& question, enip::EncapsulationStatus status);
/// There was no reply.
[[nodiscard]] Diagnosis diagnose_silence(const OpenQuestion& question);
/// There was a reply that says yes and makes no sense.
[[nodiscard]] Diagnosis diagnose_bad_reply(const OpenQuestion& question);

/// What flowed after the connection was granted.
struct IoTraffic {
    struct Direction {
        std::uint64_t packets = 0;
        std::uint64_t lost = 0;
        /// A size of the data item that is not the connection's, and how many datagrams had it.
        std::optional<std::size_t> other_size{};
        std::uint64_t other_size_packets = 0;
        bool always_idle = false;                   ///< as far as the format can tell
        std::optional<enip::Endpoint> elsewhere{};  ///< where they all went instead of where they were expected
        std::chrono::nanoseconds longest_interval{};
        std::chrono::nanoseconds silent{};  ///< from the last datagram, or the grant, to the end
    };

    std::uint32_t o_to_t_api = 0;  ///< microseconds, as granted
    std::uint32_t t_to_o_api = 0;
    Direction o_to_t{};
    Direction t_to_o{};
    enip::Endpoint receiver{};            ///< where T->O was expected
    std::chrono::nanoseconds observed{};  ///< from the grant to the close, or the end of what was seen
    bool closed = false;                  ///< by a Forward_Close
};

/// The connection was granted. `well` when data flowed in each direction that has any, and nothing else is wrong.
[[nodiscard]] Diagnosis diagnose_traffic(const OpenQuestion& question, const IoTraffic& traffic);

/// A Forward_Open as a plan. The formats are those of the XENAX for its pairs of points, and otherwise the typical ones:
/// O->T a heartbeat at size 2 and with a run/idle header above 5, T->O modeless. Nullopt when the path does not name two
/// points.
[[nodiscard]] std::optional<IoPlan> plan_from(const cip::ForwardOpen& request);

}  // namespace servobus::scanner
