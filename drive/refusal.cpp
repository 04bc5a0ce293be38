#include "drive/refusal.hpp"

namespace servobus::drive {

std::string_view describe(Refusal refusal) {
    switch (refusal) {
        case Refusal::read_only:
            return "the parameter is read only";
        case Refusal::write_only:
            return "the parameter is write only";
        case Refusal::too_low:
            return "the value is below the lower limit";
        case Refusal::too_high:
            return "the value is above the upper limit";
        case Refusal::not_allowed:
            return "the value is inside the limits, but not one of the values that exist";
        case Refusal::too_long:
            return "the text is longer than the parameter holds";
        case Refusal::wrong_type:
            return "the parameter holds another type";
        case Refusal::not_configured:
            return "this variant, motor or option does not have it";
        case Refusal::wrong_state:
            return "the drive cannot do that in its present state";
    }
    return "unknown reason";
}

}  // namespace servobus::drive
