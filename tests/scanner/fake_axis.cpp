#include "tests/scanner/fake_axis.hpp"

#include "assemblies/parameter_value.hpp"
#include "cip/multiple_service.hpp"
#include "cip/services.hpp"
#include "cip/wire.hpp"
#include "scanner/reading.hpp"

namespace servobus::scanner::test {
namespace {

constexpr std::uint32_t state_mask = 0x6F;

}  // namespace

FakeAxis::FakeAxis() {
    for (std::size_t i = 0; i < axis_value_count; ++i) {
        const auto which = static_cast<AxisValue>(i);
        if (row_of(which).is_text()) {
            state.take(which, drive::Value(std::string()));
        } else {
            set(which, 0);
        }
    }
    state.take(AxisValue::motor_type, drive::Value(std::string("230101")));
    set(AxisValue::status_word, 0x0250);
    set(AxisValue::position, 1000);
    set(AxisValue::speed, 100'000);
    set(AxisValue::acceleration, 1'000'000);
    set(AxisValue::speed_override, 100);
    set(AxisValue::target_window, 100);
    set(AxisValue::quick_stop_deceleration, 10'000'000);
    set(AxisValue::supply, 48'000);
    set(AxisValue::temperature, 25);
}

void FakeAxis::set_status(std::uint32_t mask, std::uint32_t value) {
    set(AxisValue::status_word, static_cast<std::int16_t>((state.status_word() & ~mask) | value));
}

void FakeAxis::set_process(std::uint32_t mask, std::uint32_t value) {
    set(AxisValue::process_status, static_cast<std::int32_t>((state.process_status() & ~mask) | value));
}

void FakeAxis::make_ready() {
    set_status(state_mask, 0x27);
    set_process(process_bit::reference, process_bit::reference);
    set(AxisValue::mode, 1);
    set(AxisValue::mode_requested, 1);
    set(AxisValue::control_word, 0x0F);
}

void FakeAxis::fail_with(int error, const std::string& text) {
    set_status(state_mask, 0x08);
    set_process(process_bit::in_motion, 0);
    set(AxisValue::error, error);
    state.take(AxisValue::error_text, drive::Value(text));
    left_ = 0;
}

std::vector<std::int64_t> FakeAxis::control_words() const {
    std::vector<std::int64_t> words;
    for (const auto& write : writes) {
        if (write.to == AxisValue::control_word) words.push_back(write.value);
    }
    return words;
}

void FakeAxis::write(const AxisWrite& write) {
    writes.push_back(write);
    set(write.to, write.value);
    if (write.to == AxisValue::control_word) control(static_cast<std::uint16_t>(write.value));
    if (write.to == AxisValue::mode_requested) {
        set(AxisValue::mode, write.value);
        set_status(status_bit::reached | status_bit::specific, 0);
    }
    if (write.to != AxisValue::direct_command) return;
    left_ = motion;
    target_ = state.number(AxisValue::calibration_start);
    set_process(process_bit::in_motion | process_bit::in_position, process_bit::in_motion);
    if (write.value == 0x4000) set_process(process_bit::calibrating, process_bit::calibrating);
    if (write.value == 0x3040) end_motion();
}

void FakeAxis::control(std::uint16_t word) {
    const auto was = state.status_word() & state_mask;
    if ((word & 0x80) != 0) {
        if (was == 0x08) set_status(state_mask, 0x40);
        set(AxisValue::error, 0);
        return;
    }
    if (was == 0x08) return;
    if ((word & 0x06) == 0x02 || (word & 0x02) == 0) {
        set_status(state_mask, was == 0x27 && (word & 0x02) != 0 ? 0x07 : 0x40);
        end_motion();
        return;
    }
    const std::uint32_t next = (word & 0x0F) == 0x0F ? 0x27 : (word & 0x0F) == 0x07 ? 0x23 : 0x21;
    set_status(state_mask, next);
    if (next != 0x27) return;
    if ((word & 0x100) != 0) {
        end_motion();
    } else if ((word & 0x10) != 0) {
        start(word);
    }
}

void FakeAxis::start(std::uint16_t word) {
    left_ = motion;
    const auto at = state.number(AxisValue::position);
    const bool relative = (word & 0x40) != 0;
    switch (state.mode()) {
        case mode::profile_position:
            target_ = state.number(AxisValue::target) + (relative ? at : 0);
            set_status(status_bit::reached | status_bit::specific, status_bit::specific);
            break;
        case mode::jog:
            target_ = at + (relative ? 5000 : -5000);
            set_status(status_bit::reached | status_bit::specific, status_bit::reached);
            break;
        default:
            target_ = 500;
            set_status(status_bit::reached | status_bit::specific | status_bit::error, 0);
    }
    set_process(process_bit::in_motion | process_bit::in_position, process_bit::in_motion);
}

void FakeAxis::end_motion() {
    left_ = 0;
    set(AxisValue::following_error, 0);
    set_process(process_bit::in_motion | process_bit::in_position | process_bit::calibrating, process_bit::in_position);
    const bool acknowledges_end = state.mode() != mode::profile_position;
    set_status(status_bit::reached | status_bit::specific,
               status_bit::reached | (acknowledges_end ? status_bit::specific : 0U));
    if (state.mode() == mode::reference) set_process(process_bit::reference, process_bit::reference);
}

void FakeAxis::look() {
    if (left_ == 0) return;
    in_motion(*this);
    if (left_ == 0) return;
    const auto at = state.number(AxisValue::position);
    set(AxisValue::position, at + (target_ - at) / left_);
    set(AxisValue::following_error, -7);
    if (--left_ == 0 && state.mode() != mode::jog) end_motion();
}

cip::Response FakeAxis::answer(const cip::Request& request) {
    if (request.service != cip::service::multiple_service_packet) return answer_single(request);
    if (!takes_packets) return {request.service, cip::GeneralStatus::service_not_supported, {}};
    std::vector<cip::Bytes> parts;
    for (const auto part : *cip::read_parts(request.data)) {
        parts.push_back(answer_single(*cip::Request::parse(part)).encode());
    }
    return {request.service, {}, cip::write_parts(parts)};
}

cip::Response FakeAxis::answer_single(const cip::Request& request) {
    for (std::size_t i = 0; i < axis_value_count; ++i) {
        const auto which = static_cast<AxisValue>(i);
        const auto& row = row_of(which);
        if (request.path != path_to(row)) continue;
        cip::Response response{request.service, {}, {}};
        if (request.service == cip::service::set_attribute_single) {
            const auto value = assemblies::read_value(row, request.data);
            const AxisWrite wanted{which, std::get<std::int64_t>(*value)};
            if (refuses(wanted)) return {request.service, cip::GeneralStatus::invalid_attribute_value, {}};
            write(wanted);
            return response;
        }
        if (which == AxisValue::status_word) look();
        const auto value = row.is_text() ? drive::Value(std::string(state.text(which))) : state.number(which);
        cip::Writer writer(response.data);
        assemblies::write_value(writer, row, value);
        return response;
    }
    return {request.service, cip::GeneralStatus::attribute_not_supported, {}};
}

}  // namespace servobus::scanner::test
