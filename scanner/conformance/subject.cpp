#include "scanner/conformance/subject.hpp"

#include <algorithm>

namespace servobus::scanner::conformance {
namespace {

template <class Fits>
const Candidate* first(const std::vector<Candidate>& candidates, Fits fits) {
    const auto found = std::ranges::find_if(candidates, fits);
    return found != candidates.end() ? &*found : nullptr;
}

}  // namespace

const Candidate* Subject::find(Kind kind) const {
    return first(options_.candidates, [&](const Candidate& each) { return each.kind == kind; });
}

const Candidate* Subject::harmless() const {
    if (const auto* found = first(options_.candidates, [](const Candidate& each) {
            return each.kind == Kind::input_only && each.point_to_point;
        })) {
        return found;
    }
    if (const auto* found = find(Kind::input_only)) return found;
    return writes() ? first(options_.candidates, [](const Candidate& each) { return each.owns(); }) : nullptr;
}

const Candidate* Subject::harmless_multicast() const {
    if (const auto* found = first(options_.candidates, [](const Candidate& each) {
            return each.kind == Kind::input_only && each.multicast;
        })) {
        return found;
    }
    if (!writes()) return nullptr;
    return first(options_.candidates, [](const Candidate& each) { return each.owns() && each.multicast; });
}

}  // namespace servobus::scanner::conformance
