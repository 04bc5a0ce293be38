#include "drive/device.hpp"

#include <utility>

namespace servobus::drive {

namespace {

/// Methods below are for linear axes, the others for rotative motors (000 §2.3.4.16).
constexpr std::int64_t first_rotative_method = 10;

}  // namespace

Device::Device(Model model, Motor motor)
    : model_(std::move(model)),
      motor_(motor),
      store_(std::make_unique<Store>(model_.parameters)),
      kept_(std::make_unique<KeptValues>(*store_)) {
    reset();
}

Device::Device(Model model, const Machine& machine, Motor motor) : Device(std::move(model), motor) {
    behaviour_ = model_.make_behaviour(model_, *store_, machine);
    reset();
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
    if (kept_->keeps(row) || !may_get(row.access)) {
        ++lasting_writes_;
    }
    return std::nullopt;
}

std::optional<Refusal> Device::write_process_data(const Parameter& row, const Value& value) {
    if (auto refusal = check(row, value)) {
        return refusal;
    }
    store_->cover(row, value);
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
    if (std::holds_alternative<event::PowerCycle>(event)) {
        power_up(stored());
    } else if (behaviour_) {
        behaviour_->inject(event);
    }
}

OutputLevel Device::output_wire(int number) const {
    return behaviour_ ? behaviour_->output_wire(number) : OutputLevel::open;
}

void Device::deliver(std::vector<std::pair<Key, Value>> values) {
    delivered_ = std::move(values);
    reset();
}

void Device::restore(const StoredValues& stored) {
    for (const Parameter* row : kept_->restore(stored)) {
        if (behaviour_) {
            behaviour_->written(*row);
        }
    }
}

void Device::power_up(const StoredValues& stored) {
    store_->reset();
    name_motor();
    if (behaviour_) {
        behaviour_->tell_machine();
    }
    for (const auto& [key, value] : delivered_) {
        const Parameter* row = find(key);
        if (row != nullptr && !is_for_the_machine(*row)) store_->assign(*row, value);
    }
    kept_->deliver();
    kept_->restore(stored);
    if (behaviour_) {
        behaviour_->power_up();
    }
    for (const auto& [key, value] : delivered_) {
        const Parameter* row = find(key);
        if (row == nullptr || !is_for_the_machine(*row)) continue;
        if (check(*row, value)) {
            store_->assign(*row, value);
        } else {
            static_cast<void>(write(*row, value));
        }
    }
}

/// A command or a set point: the machine has to hear of it, and only once it runs.
bool Device::is_for_the_machine(const Parameter& row) const {
    return may_set(row.access) && (row.momentary || !may_get(row.access));
}

void Device::name_motor() {
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
