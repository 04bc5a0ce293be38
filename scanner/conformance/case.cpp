#include "scanner/conformance/case.hpp"

#include <vector>

#include "scanner/conformance/case_tables.hpp"

namespace servobus::scanner::conformance {

std::span<const Case> all_cases() {
    static const auto all = [] {
        std::vector<Case> cases;
        for (const auto table :
             {encapsulation_cases(), session_cases(), packet_cases(), ucmm_cases(), class3_cases(), object_cases(),
              network_object_cases(), key_cases(), forward_open_cases(), refused_open_cases(), null_open_cases(),
              forward_close_cases(), ownership_cases(), multicast_cases(), production_cases(), timeout_cases(),
              inactivity_cases(), malformed_cases()}) {
            cases.insert(cases.end(), table.begin(), table.end());
        }
        return cases;
    }();
    return all;
}

std::string_view name(Outcome outcome) {
    switch (outcome) {
        case Outcome::pass:
            return "pass";
        case Outcome::advisory:
            return "advisory";
        case Outcome::fail:
            return "fail";
        case Outcome::skipped:
            return "skipped";
    }
    return "unknown";
}

}  // namespace servobus::scanner::conformance
