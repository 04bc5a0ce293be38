// An axis over process data: what leaves when, and how new what comes is. Against a drive whose every input was on its
// way already when the output before it arrived.
#include "scanner/cli/io_axis_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "assemblies/connection.hpp"
#include "assemblies/parameter_value.hpp"
#include "cip/wire.hpp"
#include "scanner/cli/axis_runner.hpp"
#include "tests/scanner/fake_axis.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using test::FakeAxis;
using testing::Contains;
using testing::ElementsAre;
using testing::EndsWith;
using testing::IsEmpty;
using testing::Not;

/// Explicit messages that arrive at once.
class FakeMessages : public AxisLink {
public:
    explicit FakeMessages(FakeAxis& axis) : axis_(axis) {}

    std::optional<Failure> read(std::span<const AxisValue> values, AxisState& state) override {
        for (const auto which : values) {
            reads.push_back(which);
            if (row_of(which).is_text()) {
                state.take(which, drive::Value(std::string(axis_.state.text(which))));
            } else {
                state.take(which, drive::Value(axis_.state.number(which)));
            }
        }
        return std::nullopt;
    }
    std::optional<Failure> look(std::span<const AxisValue> needed, AxisState& state) override {
        return read(needed, state);
    }
    std::optional<Failure> write(const AxisWrite& write) override {
        writes.push_back(write);
        if (axis_.refuses(write)) {
            refused_ = write;
            return Failure{ExitCode::refused, "refused"};
        }
        axis_.write(write);
        return std::nullopt;
    }
    const std::optional<AxisWrite>& refused() const override { return refused_; }
    void wait_until(Clock::time_point) override {}

    std::vector<AxisValue> reads;
    std::vector<AxisWrite> writes;

private:
    FakeAxis& axis_;
    std::optional<AxisWrite> refused_;
};

/// A datagram in each direction every 4 ms of a time of its own.
class FakeProcessData : public ProcessData {
public:
    FakeProcessData(FakeAxis& axis, const assemblies::Connection& connection)
        : axis_(axis), connection_(connection), outputs_(connection.outputs()->size(), 0) {
        for (const auto& field : fields_of(*connection.outputs())) {
            for (const auto which : values) {
                if (field.row == &row_of(which)) fields_.emplace_back(which, field);
            }
        }
        for (const auto& [which, field] : fields_) {
            put(*change_of(fields_of(*connection.outputs()), *field.row, drive::Value(axis.state.number(which))),
                outputs_);
        }
        applied_ = outputs_;
    }

    const assemblies::Layout& output_layout() const override { return *connection_.outputs(); }
    const assemblies::Layout& input_layout() const override { return *connection_.inputs(); }
    cip::Bytes& outputs() override { return outputs_; }
    std::uint64_t sent() const override { return datagrams.size(); }
    const Input& input() const override { return input_; }
    std::uint64_t received() const override { return received_; }
    void on_input(std::function<void(const Input&)> listener) override { listener_ = std::move(listener); }
    std::optional<Failure> run_until(const std::function<bool()>& done) override {
        while (!done()) {
            if (datagrams.size() >= lost_after) return Failure{ExitCode::no_connection, "lost"};
            exchange();
        }
        return std::nullopt;
    }

    [[nodiscard]] std::int64_t in(const cip::Bytes& datagram, AxisValue which) const {
        const auto found = std::ranges::find(fields_, which, [](const auto& field) { return field.first; });
        return number_in(found->second, datagram);
    }

    std::vector<cip::Bytes> datagrams;
    std::size_t lost_after = 100'000;

private:
    static constexpr std::array values{AxisValue::target,       AxisValue::speed,        AxisValue::acceleration,
                                       AxisValue::s_curve,      AxisValue::control_word, AxisValue::following_window,
                                       AxisValue::target_window};

    void exchange() {
        // Produced before the output that crosses it.
        axis_.look();
        cip::Bytes data;
        for (const auto& field : fields_of(input_layout())) {
            auto value = drive::Value(std::int64_t{0});
            for (std::size_t i = 0; i < axis_value_count; ++i) {
                const auto which = static_cast<AxisValue>(i);
                if (field.row == &row_of(which)) value = axis_.state.number(which);
            }
            cip::Writer writer(data);
            assemblies::write_value(writer, *field.row, value);
        }
        datagrams.push_back(outputs_);
        for (const auto& [which, field] : fields_) {
            const auto number = number_in(field, outputs_);
            if (number != number_in(field, applied_)) axis_.write({which, number});
        }
        applied_ = outputs_;
        input_ = {data, Clock::time_point(4ms * received_)};
        ++received_;
        if (listener_) listener_(input_);
    }

    FakeAxis& axis_;
    const assemblies::Connection& connection_;
    cip::Bytes outputs_;
    cip::Bytes applied_;
    std::vector<std::pair<AxisValue, IoField>> fields_;
    Input input_;
    std::uint64_t received_ = 0;
    std::function<void(const Input&)> listener_;
};

class IoAxis : public testing::Test {
protected:
    IoAxis() { axis.make_ready(); }

    FakeAxis axis;
    FakeMessages messages{axis};
};

const assemblies::Connection& connection(std::string_view key) { return *assemblies::find_connection(key); }

TEST_F(IoAxis, AControlWordDoesNotOvertakeItsTarget) {
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    EXPECT_EQ(link.write({AxisValue::speed, 7'000}), std::nullopt);
    EXPECT_EQ(link.write({AxisValue::target, 500}), std::nullopt);
    EXPECT_TRUE(data.datagrams.empty()) << "nothing leaves between two that belong together";
    EXPECT_EQ(link.write({AxisValue::control_word, 0x1F}), std::nullopt);
    ASSERT_EQ(data.datagrams.size(), 1 + IoAxisLink::control_word_datagrams);
    for (const auto& datagram : data.datagrams) {
        EXPECT_EQ(data.in(datagram, AxisValue::target), 500);
        EXPECT_EQ(data.in(datagram, AxisValue::speed), 7'000);
    }
    EXPECT_EQ(data.in(data.datagrams[0], AxisValue::control_word), 0x0F);
    EXPECT_EQ(data.in(data.datagrams[1], AxisValue::control_word), 0x1F);
    EXPECT_THAT(messages.writes, IsEmpty());
}

TEST_F(IoAxis, EveryControlWordLeavesMoreThanOnce) {
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    for (const auto word : {0x00, 0x80, 0x00}) {
        ASSERT_EQ(link.write({AxisValue::control_word, word}), std::nullopt);
    }
    std::vector<std::int64_t> words;
    for (const auto& datagram : data.datagrams) words.push_back(data.in(datagram, AxisValue::control_word));
    EXPECT_THAT(words, ElementsAre(0x00, 0x00, 0x80, 0x80, 0x00, 0x00));
}

TEST_F(IoAxis, ALookIsNewerThanWhatWasWritten) {
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    AxisState state;
    ASSERT_EQ(link.look({}, state), std::nullopt);
    EXPECT_TRUE(state.is_enabled());
    ASSERT_EQ(link.write({AxisValue::control_word, 0x06}), std::nullopt);
    ASSERT_EQ(link.look({}, state), std::nullopt);
    EXPECT_FALSE(state.is_enabled());
    // Also what nobody has waited for yet: it leaves before it is looked.
    ASSERT_EQ(link.write({AxisValue::target, 77}), std::nullopt);
    const auto before = data.received();
    ASSERT_EQ(link.look({}, state), std::nullopt);
    EXPECT_EQ(data.in(data.datagrams.back(), AxisValue::target), 77);
    EXPECT_GT(data.received(), before + IoAxisLink::inputs_after_write);
}

TEST_F(IoAxis, WhatNoAssemblyHasGoesByMessage) {
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    ASSERT_EQ(link.write({AxisValue::target, 5}), std::nullopt);
    ASSERT_EQ(link.write({AxisValue::mode_requested, -1}), std::nullopt);
    EXPECT_EQ(data.datagrams.size(), 1U) << "what was written before has left before";
    ASSERT_EQ(link.write({AxisValue::target_window, 5}), std::nullopt);
    EXPECT_THAT(messages.writes,
                ElementsAre(AxisWrite{AxisValue::mode_requested, -1}, AxisWrite{AxisValue::target_window, 5}));
    AxisState state;
    const std::array needed{AxisValue::status_word, AxisValue::mode};
    ASSERT_EQ(link.look(needed, state), std::nullopt);
    EXPECT_EQ(state.mode(), -1);
    EXPECT_THAT(messages.reads, ElementsAre(AxisValue::mode));
    axis.refuses = [](const AxisWrite&) { return true; };
    EXPECT_EQ(link.write({AxisValue::reference_method, 1})->code, ExitCode::refused);
    EXPECT_EQ(link.refused(), (AxisWrite{AxisValue::reference_method, 1}));
}

TEST_F(IoAxis, LargerOutputsHaveTheWindows) {
    FakeProcessData data(axis, connection("outputs"));
    IoAxisLink link(messages, data);
    ASSERT_EQ(link.write({AxisValue::target_window, 5}), std::nullopt);
    ASSERT_EQ(link.write({AxisValue::control_word, 0x1F}), std::nullopt);
    EXPECT_THAT(messages.writes, IsEmpty());
    EXPECT_EQ(data.in(data.datagrams.front(), AxisValue::target_window), 5);
}

TEST_F(IoAxis, RefusesWhatNobodyWouldRefuse) {
    // A datagram has no answer: the drive would only leave it out (R-IO-9).
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    const auto failure = link.write({AxisValue::s_curve, 500});
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->code, ExitCode::refused);
    EXPECT_EQ(failure->text, "SCurve: it takes 1 to 100 % (value 500)");
    EXPECT_EQ(link.refused(), (AxisWrite{AxisValue::s_curve, 500}));
    ASSERT_EQ(link.write({AxisValue::control_word, 0x0F}), std::nullopt);
    EXPECT_EQ(data.in(data.datagrams.back(), AxisValue::s_curve), 0);
}

TEST_F(IoAxis, TellsWhatItHasSent) {
    // The device may not have read the last datagram yet.
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    ASSERT_EQ(link.write({AxisValue::control_word, 0x1F}), std::nullopt);
    axis.set(AxisValue::control_word, 0);
    AxisState state;
    const std::array asked{AxisValue::control_word, AxisValue::speed_override};
    ASSERT_EQ(link.read(asked, state), std::nullopt);
    EXPECT_EQ(state.number(AxisValue::control_word), 0x1F);
    EXPECT_EQ(state.number(AxisValue::speed_override), 100);
    EXPECT_FALSE(state.has(AxisValue::target));
}

TEST_F(IoAxis, RecordsEveryInputAtItsTime) {
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    std::vector<AxisState> states;
    std::vector<AxisLink::Clock::time_point> times;
    EXPECT_TRUE(link.record([&](const AxisState& state, AxisLink::Clock::time_point time) {
        states.push_back(state);
        times.push_back(time);
    }));
    axis.motion = 50;
    ASSERT_EQ(link.write({AxisValue::target, 6'000}), std::nullopt);
    ASSERT_EQ(link.write({AxisValue::control_word, 0x1F}), std::nullopt);
    ASSERT_EQ(data.run_until([&] { return data.received() == 30; }), std::nullopt);
    ASSERT_EQ(states.size(), 30U);
    for (std::size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i], AxisLink::Clock::time_point(4ms * i));
    // 5000 increments in 50 inputs, 4 ms apart.
    EXPECT_EQ(states.back().number(AxisValue::velocity), 25'000);
    EXPECT_FALSE(states.front().has(AxisValue::velocity));
}

TEST_F(IoAxis, WalksTheSequences) {
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    std::ostringstream out;
    std::ostringstream err;
    const Console console{out, err};
    const std::atomic<int> none{0};
    const Interruption interruption(&none);
    AxisRunner runner(console, link, interruption, Time(0), true);
    ASSERT_EQ(runner.run(move_steps({.position = 5'000, .speed = 9'000}, 2s)), AxisRunner::End::done);
    EXPECT_EQ(runner.state().number(AxisValue::position), 5'000);
    EXPECT_EQ(axis.state.number(AxisValue::speed), 9'000);
    EXPECT_EQ(runner.samples().size(), 0U) << "the time of this test is not that of the clock";
    EXPECT_THAT(axis.control_words(), ElementsAre(0x1F)) << "0x0F stood already";
    ASSERT_EQ(runner.run(jog_steps({.positive = true, .speed = 700, .duration = 20ms}, runner.state())),
              AxisRunner::End::done);
    EXPECT_THAT(axis.control_words(), ElementsAre(0x1F, 0x0F, 0x5F, 0x11F));
    axis.fail_with(50, "following error");
    ASSERT_EQ(runner.run(fault_reset_steps()), AxisRunner::End::done);
    EXPECT_FALSE(axis.state.has_fault());
}

TEST_F(IoAxis, SaysThatTheConnectionIsLost) {
    FakeProcessData data(axis, connection("standard"));
    IoAxisLink link(messages, data);
    std::ostringstream out;
    std::ostringstream err;
    const Console console{out, err};
    const std::atomic<int> none{0};
    const Interruption interruption(&none);
    AxisRunner runner(console, link, interruption, Time(0), false);
    axis.motion = 1'000'000;
    data.lost_after = 20;
    ASSERT_EQ(runner.run(move_steps({.position = 5'000}, 2s)), AxisRunner::End::failed);
    EXPECT_EQ(runner.failure().code, ExitCode::no_connection);
    EXPECT_THAT(runner.failure().text, EndsWith("; the axis may still move"));
}

}  // namespace
}  // namespace servobus::scanner::cli
