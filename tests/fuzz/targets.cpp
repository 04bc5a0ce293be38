#include "tests/fuzz/targets.hpp"

#include <array>

namespace servobus::fuzz {

std::span<const Target> targets() {
    static constexpr std::array all{
        Target{"adapter", adapter},
        Target{"capture", capture},
        Target{"common_packet", common_packet},
        Target{"config", config},
        Target{"eds", eds},
        Target{"encapsulation", encapsulation},
        Target{"file_upload", file_upload},
        Target{"forward_open", forward_open},
        Target{"io_packet", io_packet},
        Target{"link", link},
        Target{"message", message},
        Target{"message_router", message_router},
        Target{"path", path},
        Target{"ptp_answers", ptp_answers},
        Target{"scanner_replies", scanner_replies},
        Target{"session", session},
    };
    return all;
}

}  // namespace servobus::fuzz
