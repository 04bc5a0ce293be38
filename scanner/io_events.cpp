#include "scanner/io_events.hpp"

namespace servobus::scanner {

std::string_view name(IoState state) {
    switch (state) {
        case IoState::idle:
            return "idle";
        case IoState::connecting:
            return "connecting";
        case IoState::opening:
            return "opening";
        case IoState::open:
            return "open";
        case IoState::closing:
            return "closing";
        case IoState::waiting:
            return "waiting";
        case IoState::closed:
            return "closed";
    }
    return "unknown";
}

std::string_view name(CloseReason reason) {
    switch (reason) {
        case CloseReason::asked:
            return "asked";
        case CloseReason::unreachable:
            return "unreachable";
        case CloseReason::refused:
            return "refused";
        case CloseReason::bad_reply:
            return "bad reply";
        case CloseReason::timed_out:
            return "timed out";
        case CloseReason::no_socket:
            return "no socket";
    }
    return "unknown";
}

}  // namespace servobus::scanner
