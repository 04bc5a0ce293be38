#include "drive/device.hpp"

#include <utility>

namespace servobus::drive {

namespace {

/// Methods below are for linear axes, the others for rotative motors (000 §2.3.4.16).
constexpr std::int64_t first_rotative_method = 10;

}  // namespace

Device::Device(Model model, Motor motor)
    : model_(std::move(model)), motor_(motor), store_(std::make_unique<Store>(model_.parameters)) {
    reset_store();
}

Device::Device(Model model, const Machine& machine, Motor motor) : Device(std::move(model), motor) {
    behaviour_ = model_.make_behaviour(model_, *store_, machine);
    behaviour_->power_up();
}

ReadResult Device::read(const Parameter& row) const {
    if (!may_get(row.access)) {
        return Refusal::write_only;
    }
    if (!has(row)) {
        return Refusal::not_configured;
    }
    return store_->read(row);
}

std::optional<Refusal> Device::check(const Parameter& row, const Value& value) const {
    const auto refusal = store_->check(row, value);
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
    return behaviour_ ? behaviour_->check(row, value) : std::nullopt;
}

std::optional<Refusal> Device::write(const Parameter& row, Value value) {
    if (auto refusal = check(row, value)) {
        return refusal;
    }
    store_->assign(row, std::move(value));
    if (behaviour_) {
        behaviour_->written(row);
    }
    return std::nullopt;
}

void Device::step(Time now) {
    if (behaviour_) {
        behaviour_->step(now);
    }
}

std::optional<Time> Device::next_deadline() const { return behaviour_ ? behaviour_->next_deadline() : std::nullopt; }

void Device::inject(const Event& event) {
    if (behaviour_) {
        behaviour_->inject(event);
    }
}

OutputLevel Device::output_wire(int number) const {
    return behaviour_ ? behaviour_->output_wire(number) : OutputLevel::open;
}

void Device::reset() {
    reset_store();
    if (behaviour_) {
        behaviour_->power_up();
    }
}

void Device::reset_store() {
    store_->reset();
    if (!model_.motor_names || motor_ == Motor::any) {
        return;
    }
    const MotorNames& names = *model_.motor_names;
    if (const Parameter* row = find(names.row)) {
        store_->assign(*row, std::string(motor_ == Motor::linear ? names.linear : names.rotative));
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
