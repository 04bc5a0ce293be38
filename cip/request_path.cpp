#include "cip/request_path.hpp"

namespace servobus::cip {
namespace {

// The order in which segments may come; each step may be taken once.
enum class Step : std::uint8_t { start, key, class_id, instance, attribute };

bool advance(Step& at, Step to) {
    if (at >= to) return false;
    at = to;
    return true;
}

std::optional<Step> step_of(LogicalType type) {
    switch (type) {
        case LogicalType::class_id:
            return Step::class_id;
        case LogicalType::instance:
            return Step::instance;
        case LogicalType::attribute:
            return Step::attribute;
        case LogicalType::member:
        case LogicalType::connection_point:
        case LogicalType::special:
        case LogicalType::service_id:
        case LogicalType::extended:
            return std::nullopt;
    }
    return std::nullopt;
}

bool add(RequestPath& path, Step& at, const LogicalSegment& segment) {
    const auto step = step_of(segment.type);
    if (!step) return false;
    if (*step > Step::class_id && at < Step::class_id) return false;  // a class comes first
    if (!advance(at, *step)) return false;
    if (*step == Step::class_id) path.class_id = segment.value;
    if (*step == Step::instance) path.instance = segment.value;
    if (*step == Step::attribute) path.attribute = segment.value;
    return true;
}

}  // namespace

boost::system::result<RequestPath, Status> RequestPath::parse(ByteView path) {
    if (path.empty()) return Status(GeneralStatus::path_destination_unknown);
    RequestPath target;
    auto at = Step::start;
    for (Reader reader(path); reader.remaining() > 0;) {
        const auto segment = read_segment(reader);
        if (!segment) return Status(GeneralStatus::path_segment_error);
        bool fits = false;
        if (const auto* known = std::get_if<LogicalSegment>(&*segment)) {
            fits = add(target, at, *known);
        } else if (const auto* key = std::get_if<ElectronicKey>(&*segment)) {
            fits = advance(at, Step::key);
            target.key = *key;
        }
        if (!fits) return Status(GeneralStatus::path_segment_error);
    }
    if (at < Step::class_id) return Status(GeneralStatus::path_segment_error);
    if (at == Step::class_id) return Status(GeneralStatus::path_destination_unknown);
    return target;
}

std::optional<ConnectionFailure> mismatch(const ElectronicKey& key, const NodeIdentity& node) {
    const auto differs = [](auto asked, auto own) { return asked != 0 && asked != own; };
    if (differs(key.vendor, node.vendor) || differs(key.product_code, node.product_code)) {
        return ConnectionFailure::vendor_or_product_mismatch;
    }
    if (differs(key.device_type, node.device_type)) return ConnectionFailure::device_type_mismatch;
    const auto major = static_cast<std::uint8_t>(key.major_revision & 0x7F);
    const bool compatible = (key.major_revision & 0x80) != 0;
    if (major == 0 && !compatible) return std::nullopt;  // any revision; the minor is then not looked at
    if (differs(major, node.major_revision)) return ConnectionFailure::revision_mismatch;
    const bool minor_fits =
        compatible ? key.minor_revision <= node.minor_revision : !differs(key.minor_revision, node.minor_revision);
    if (!minor_fits) return ConnectionFailure::revision_mismatch;
    return std::nullopt;
}

}  // namespace servobus::cip
