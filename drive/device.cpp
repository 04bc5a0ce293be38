#include "drive/device.hpp"

#include <utility>

namespace servobus::drive {

namespace {

/// Methods below are for linear axes, the others for rotative motors (000 §2.3.4.16).
constexpr std::int64_t first_rotative_method = 10;

}  // namespace

Device::Device(Model model, Motor motor) : model_(std::move(model)), motor_(motor), store_(model_.parameters) {
    reset();
}

ReadResult Device::read(const Parameter& row) const {
    if (!may_get(row.access)) {
        return Refusal::write_only;
    }
    if (!has(row)) {
        return Refusal::not_configured;
    }
    return store_.read(row);
}

std::optional<Refusal> Device::check(const Parameter& row, const Value& value) const {
    const auto refusal = store_.check(row, value);
    if (refusal == Refusal::read_only) {
        return refusal;
    }
    if (!has(row)) {
        return Refusal::not_configured;
    }
    if (refusal) {
        return refusal;
    }
    if (!motor_allows(row, value)) {
        return Refusal::not_configured;
    }
    return std::nullopt;
}

std::optional<Refusal> Device::write(const Parameter& row, Value value) {
    if (auto refusal = check(row, value)) {
        return refusal;
    }
    store_.assign(row, std::move(value));
    return std::nullopt;
}

void Device::reset() {
    store_.reset();
    if (!model_.motor_names || motor_ == Motor::any) {
        return;
    }
    const MotorNames& names = *model_.motor_names;
    if (const Parameter* row = find(names.row)) {
        store_.assign(*row, std::string(motor_ == Motor::linear ? names.linear : names.rotative));
    }
}

bool Device::motor_allows(const Parameter& row, const Value& value) const {
    if (motor_ == Motor::any || row.key() != model_.reference_method_row) {
        return true;
    }
    const bool rotative_method = std::get<std::int64_t>(value) >= first_rotative_method;
    return rotative_method == (motor_ == Motor::rotative);
}

}  // namespace servobus::drive
