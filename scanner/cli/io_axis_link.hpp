// An axis over an I/O connection: what its assemblies have goes with them, everything else by explicit messages.
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "scanner/cli/axis_link.hpp"
#include "scanner/cli/io_data.hpp"
#include "scanner/cli/process_data.hpp"

namespace servobus::scanner::cli {

/// The outputs change as a whole: what is written before a control word has left in a datagram when the control word
/// does, and a control word has left before anything else is written. A look sees inputs that are newer than every
/// write.
class IoAxisLink : public AxisLink {
public:
    /// Datagrams that carry each control word, so that one that is lost takes no edge with it.
    static constexpr std::uint64_t control_word_datagrams = 2;
    /// Inputs that come after a write has left until they have seen it: one may have been on its way already.
    static constexpr std::uint64_t inputs_after_write = 2;
    /// Inputs that a velocity is taken from: the slope from the first to the last.
    static constexpr std::size_t velocity_inputs = 5;

    /// Both outlive this. The connection is open, and its outputs are what the device has.
    IoAxisLink(AxisLink& messages, ProcessData& data);

    /// By explicit messages; what is in the outputs is as it was sent.
    [[nodiscard]] std::optional<Failure> read(std::span<const AxisValue> values, AxisState& state) override;
    [[nodiscard]] std::optional<Failure> ask(std::span<const AxisValue> values, AxisState& state) override {
        return messages_.read(values, state);
    }
    /// The next inputs; what they do not have is asked for when it is needed.
    [[nodiscard]] std::optional<Failure> look(std::span<const AxisValue> needed, AxisState& state) override;
    [[nodiscard]] std::optional<Failure> write(const AxisWrite& write) override;
    [[nodiscard]] const std::optional<AxisWrite>& refused() const override { return refused_; }
    void wait_until(Clock::time_point when) override { messages_.wait_until(when); }
    [[nodiscard]] bool record(Recorder recorder) override;

private:
    using Fields = std::vector<std::pair<AxisValue, IoField>>;

    [[nodiscard]] static Fields values_in(const assemblies::Layout& layout);
    [[nodiscard]] std::optional<Failure> send(std::uint64_t datagrams);
    [[nodiscard]] std::optional<Failure> flush() { return pending_ ? send(1) : std::nullopt; }
    void take(const ProcessData::Input& input, AxisState& state) const;
    void note(const ProcessData::Input& input);

    AxisLink& messages_;
    ProcessData& data_;
    IoFields output_fields_;
    Fields inputs_;
    Fields outputs_;
    bool pending_ = false;          ///< something was written that has not left
    std::uint64_t newer_than_ = 0;  ///< inputs that were there before the last write had an effect
    std::deque<std::pair<std::int64_t, Clock::time_point>> positions_;
    std::optional<AxisWrite> refused_;
    Recorder recorder_;
};

}  // namespace servobus::scanner::cli
