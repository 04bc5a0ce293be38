#include "scanner/cli/io_axis_link.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scanner/cli/what.hpp"

namespace servobus::scanner::cli {

IoAxisLink::IoAxisLink(AxisLink& messages, ProcessData& data)
    : messages_(messages),
      data_(data),
      output_fields_(fields_of(data.output_layout())),
      inputs_(values_in(data.input_layout())),
      outputs_(values_in(data.output_layout())) {
    data_.on_input([this](const ProcessData::Input& input) { note(input); });
}

IoAxisLink::Fields IoAxisLink::values_in(const assemblies::Layout& layout) {
    Fields values;
    for (const auto& field : fields_of(layout)) {
        for (std::size_t i = 0; i < axis_value_count; ++i) {
            const auto which = static_cast<AxisValue>(i);
            if (field.row == &row_of(which)) values.emplace_back(which, field);
        }
    }
    return values;
}

void IoAxisLink::take(const ProcessData::Input& input, AxisState& state) const {
    for (const auto& [which, field] : inputs_) state.take(which, drive::Value(number_in(field, input.data)));
    if (positions_.size() < 2) return;
    const auto& [first, first_time] = positions_.front();
    const auto& [last, last_time] = positions_.back();
    const auto seconds = std::chrono::duration<double>(last_time - first_time).count();
    if (seconds <= 0) return;
    state.take(AxisValue::velocity,
               drive::Value(std::int64_t{std::llround(static_cast<double>(last - first) / seconds)}));
}

void IoAxisLink::note(const ProcessData::Input& input) {
    for (const auto& [which, field] : inputs_) {
        if (which != AxisValue::position) continue;
        positions_.emplace_back(number_in(field, input.data), input.time);
        if (positions_.size() > velocity_inputs) positions_.pop_front();
    }
    if (!recorder_) return;
    AxisState state;
    take(input, state);
    recorder_(state, input.time);
}

std::optional<Failure> IoAxisLink::send(std::uint64_t datagrams) {
    const auto wanted = data_.sent() + datagrams;
    if (auto failure = data_.run_until([&] { return data_.sent() >= wanted; })) return failure;
    pending_ = false;
    newer_than_ = data_.received() + inputs_after_write - 1;
    return std::nullopt;
}

std::optional<Failure> IoAxisLink::read(std::span<const AxisValue> values, AxisState& state) {
    if (auto failure = flush()) return failure;
    if (auto failure = messages_.read(values, state)) return failure;
    for (const auto& [which, field] : outputs_) {
        const bool asked = std::ranges::find(values, which) != values.end();
        if (asked) state.take(which, drive::Value(number_in(field, data_.outputs())));
    }
    return std::nullopt;
}

std::optional<Failure> IoAxisLink::look(std::span<const AxisValue> needed, AxisState& state) {
    if (auto failure = flush()) return failure;
    const auto after = std::max(newer_than_, data_.received());
    if (auto failure = data_.run_until([&] { return data_.received() > after; })) return failure;
    take(data_.input(), state);
    std::vector<AxisValue> asked;
    for (const auto which : needed) {
        const auto has = [which](const auto& value) { return value.first == which; };
        if (std::ranges::none_of(inputs_, has)) asked.push_back(which);
    }
    return asked.empty() ? std::nullopt : messages_.read(asked, state);
}

std::optional<Failure> IoAxisLink::write(const AxisWrite& write) {
    const auto& row = row_of(write.to);
    const auto change = change_of(output_fields_, row, drive::Value(write.value));
    const bool is_control_word = write.to == AxisValue::control_word;
    if (!change || is_control_word) {
        if (auto failure = flush()) return failure;
    }
    if (!change) {
        auto failure = messages_.write(write);
        refused_ = messages_.refused();
        return failure;
    }
    // No reply tells that a member of the outputs was refused; it would only be left out (R-IO-9).
    if (drive::check_value(row, drive::Value(write.value))) {
        refused_ = write;
        return Failure{ExitCode::refused,
                       fmt::format("{}: it takes {} (value {})", display_name(row), limits_text(row), write.value)};
    }
    put(*change, data_.outputs());
    pending_ = true;
    return is_control_word ? send(control_word_datagrams) : std::nullopt;
}

bool IoAxisLink::record(Recorder recorder) {
    recorder_ = std::move(recorder);
    return true;
}

}  // namespace servobus::scanner::cli
