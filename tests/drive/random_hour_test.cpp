// An hour of everything at once: control words with and without sense, modes, parameters, commands and mishaps, on
// every kind of axis, in virtual time. Whatever happens, what the drive tells has to fit together, and afterwards it has
// to work again. A seed is a whole history; the failing one is printed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drive/device.hpp"
#include "drive/lookup.hpp"
#include "drive/xenax.hpp"
#include "drive/xenax_drive.hpp"
#include "drive/xenax_errors.hpp"
#include "tests/support/axis_kinds.hpp"

namespace servobus::drive {
namespace {

using namespace std::chrono_literals;
using State = Ds402::State;

#if defined(__SANITIZE_ADDRESS__)
constexpr Time simulated = 90s;  // for each of the four tests; a sanitizer makes everything ten times slower
#else
constexpr Time simulated = 900s;
#endif

// Direct commands (000 §2.3.2.1).
constexpr std::int64_t cmd_res = 0x5000;
constexpr std::int64_t cmd_clpo = 0x5020;

// Bits of the process status register (004 §3.3.7).
constexpr unsigned psr_error = 0;
constexpr unsigned psr_reference = 1;
constexpr unsigned psr_in_motion = 2;
constexpr unsigned psr_warning = 23;
constexpr unsigned psr_information = 24;

/// splitmix64. The distributions of the standard library differ between implementations, so a seed would mean
/// something else on each.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t next() {
        state_ += 0x9E3779B97F4A7C15U;
        std::uint64_t value = state_;
        value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9U;
        value = (value ^ (value >> 27)) * 0x94D049BB133111EBU;
        return value ^ (value >> 31);
    }
    std::int64_t between(std::int64_t low, std::int64_t high) {
        const auto span = static_cast<std::uint64_t>(high - low) + 1;
        return low + static_cast<std::int64_t>(next() % span);
    }
    bool chance(std::int64_t percent) { return between(1, 100) <= percent; }
    template <std::size_t Count>
    std::int64_t one_of(const std::int64_t (&values)[Count]) {
        return values[next() % Count];
    }

private:
    std::uint64_t state_;
};

/// The drive that a Device makes, so that what is inside can be looked at.
XenaxDrive* made = nullptr;

std::unique_ptr<Behaviour> make_and_remember(const Model& model, Store& store, const Machine& machine) {
    auto drive = std::make_unique<XenaxDrive>(model, store, machine);
    made = drive.get();
    return drive;
}

Model watched_model(std::string_view variant) {
    Model model = *xenax_model(variant);
    model.make_behaviour = &make_and_remember;
    return model;
}

/// What a history has led to: noise that never gets the axis to move would prove nothing.
struct Seen {
    std::array<Time, 8> states{};
    std::map<std::int64_t, Time> modes_in_motion;
    std::map<std::int64_t, int> messages;
    Time total{0};
    Time referenced{0};
    std::int64_t steps = 0;

    void add(const Seen& other) {
        for (std::size_t i = 0; i < states.size(); ++i) states[i] += other.states[i];
        for (const auto& [mode, time] : other.modes_in_motion) modes_in_motion[mode] += time;
        for (const auto& [number, times] : other.messages) messages[number] += times;
        total += other.total;
        referenced += other.referenced;
        steps += other.steps;
    }
};

class World {
public:
    World(const AxisKind& kind, std::string_view variant, std::uint64_t seed)
        : kind_(kind),
          random_(seed),
          device_(watched_model(variant), Machine{kind, seed}),
          drive_(made),
          name_(kind.key + " on " + std::string(variant) + ", seed " + std::to_string(seed)) {
        device_.step(now_);
        linear_ = kind.motion == AxisKind::Motion::linear;
        settle_parameters();
    }

    void live(Time duration) {
        lives_ = true;
        const Time end = now_ + duration;
        while (now_ < end && !failed()) {
            if (calm_steps_ > 0) {
                --calm_steps_;
                if (random_.chance(20)) use_sensibly();
                if (random_.chance(1)) mishap();
            } else {
                const auto actions = random_.between(0, 2);
                for (std::int64_t i = 0; i < actions; ++i) act();
                if (random_.chance(6)) begin_calm();
            }
            pass(random_.chance(1) ? Time(random_.between(100'000, 3'000'000)) : step_size());
        }
    }

    /// Everything that was done to the drive is taken back: then it has to come back, find its reference, and move.
    void recover() {
        lives_ = false;
        release_everything();
        write(control_word_, 0);
        pass(3s);                                // a coasting axis stands, a brake is closed
        for (int i = 0; i < 6; ++i) pass(600s);  // what was too hot has cooled
        write(control_word_, 0x80);
        for (const std::int64_t word : {0x06, 0x07, 0x0F}) {
            write(control_word_, word);
            pass(1ms);
        }
        pass(1100ms);  // the longest BRKD
        // Parameters of a madman may make the axis leave its place at once; it was enabled all the same.
        EXPECT_TRUE(error() != 0 || drive_->state() == State::operation_enabled) << name_;

        write(control_word_, 0);
        pass(5s);
        EXPECT_FALSE(write(direct_command_, cmd_res)) << name_;
        settle_parameters();
        write(control_word_, 0x80);
        write(control_word_, 0x00);
        write(mode_requested_, 6);
        EXPECT_EQ(get(mode_displayed_), 6) << name_;
        for (const std::int64_t word : {0x06, 0x07, 0x0F}) {
            write(control_word_, word);
            pass(1ms);
        }
        EXPECT_EQ(drive_->state(), State::operation_enabled) << name_ << ", error " << error();
        write(control_word_, 0x1F);
        wait_for(30s, [&] { return status_bit(12) || error() != 0; });
        EXPECT_TRUE(status_bit(12)) << name_ << ", error " << error();
        EXPECT_TRUE(process_bit(psr_reference)) << name_;
        write(mode_requested_, 1);
        pass(1ms);
        EXPECT_EQ(get(mode_displayed_), 1) << name_;
        write(control_word_, 0x0F);
        const std::int64_t target = linear_ ? static_cast<std::int64_t>(kind_.travel / 2) : get(position_) + 5'000;
        write(target_, target);
        write(control_word_, 0x1F);
        wait_for(30s, [&] { return (status_bit(10) && !status_bit(12)) || error() != 0; });
        EXPECT_TRUE(status_bit(10)) << name_ << ", error " << error();
        EXPECT_NEAR(static_cast<double>(get(position_)), static_cast<double>(target), 100) << name_;
    }

    [[nodiscard]] std::uint64_t trace() const { return trace_; }
    [[nodiscard]] const Seen& seen() const { return seen_; }
    [[nodiscard]] bool failed() const { return ::testing::Test::HasFailure(); }

private:
    // ------------------------------------------------------------------------------------------------- what happens

    Time step_size() { return Time(random_.chance(50) ? random_.between(100, 3'000) : random_.between(100, 50'000)); }

    void pass(Time duration) {
        const bool was_moving = axis().moving();
        const auto mode_before = get(mode_displayed_);
        const bool rests = !device_.next_deadline();
        const auto position_before = get(position_);
        const auto status_before = get(status_word_);
        now_ += duration;
        device_.step(now_);
        if (rests) {
            EXPECT_EQ(get(position_), position_before) << name_ << " at rest";
            EXPECT_EQ(get(status_word_), status_before) << name_ << " at rest";
        }
        if (was_moving && duration <= 100us) {
            EXPECT_TRUE(get(mode_displayed_) == mode_before || !axis().moving()) << name_;
        }
        check();
        follow_trace();
        if (lives_) look(duration);
    }

    void look(Time duration) {
        seen_.states[static_cast<std::size_t>(drive_->state())] += duration;
        if (process_bit(psr_in_motion)) seen_.modes_in_motion[get(mode_displayed_)] += duration;
        if (process_bit(psr_reference)) seen_.referenced += duration;
        if (error() != last_message_) ++seen_.messages[error()];
        last_message_ = error();
        seen_.total += duration;
        ++seen_.steps;
    }

    template <class Condition>
    void wait_for(Time longest, const Condition& condition) {
        const Time end = now_ + longest;
        while (now_ < end && !condition() && !failed()) pass(5ms);
    }

    /// What an engineer sets before anything works on this axis.
    void settle_parameters() {
        if (!linear_) {
            write(row("ReferenceSpeedForExternalReferenceSensor"), kind_.sensor_width > 0 ? 20'000 : 0);
            write(row("ReferenceSpeedForInternalZMark"), 5'000);
            write(reference_method_, kind_.family == AxisKind::Family::rotax_rxvp ? 14 : 10);
        }
    }

    /// For a while somebody uses the axis as it is meant to be used.
    void begin_calm() {
        calm_steps_ = random_.between(20, 150);
        if (random_.chance(70)) release_everything();
        if (random_.chance(30)) return;
        settle_parameters();
        write(override_, random_.between(20, 100));
        write(speed_, random_.between(20'000, 300'000));
        write(acceleration_, random_.between(200'000, 3'000'000));
        write(row("FollowingPositionErrorWindow"), random_.between(2'000, 10'000));
        write(row("LimitIForce"), 0);
        write(row("LF"), 0);
        write(row("BWP"), 50);
        write(row("IR"), 1'200);
    }

    void act() {
        const auto dice = random_.between(1, 100);
        if (dice <= 40) return use_sensibly();
        if (dice <= 52) return void(write(control_word_, random_.between(-32768, 32767)));
        if (dice <= 62) return void(write(control_word_, sensible_word()));
        if (dice <= 66) return void(write(mode_requested_, random_.one_of({-2, -1, 0, 1, 6, 8})));
        if (dice <= 76) return set_sensible_parameter();
        if (dice <= 79) return set_any_parameter();
        if (dice <= 87) return command();
        if (dice <= 97) return mishap();
        release_everything();
    }

    std::int64_t sensible_word() {
        return random_.one_of({0x00, 0x02, 0x06, 0x07, 0x0F, 0x1F, 0x5F, 0x10F, 0x11F, 0x15F, 0x80, 0x4F, 0x86});
    }

    /// The next thing that a controller that knows what it does would do.
    void use_sensibly() {
        switch (drive_->state()) {
            case State::switch_on_disabled:
                write(control_word_, 0x06);
                return;
            case State::ready_to_switch_on:
                write(control_word_, random_.chance(70) ? 0x07 : 0x0F);
                return;
            case State::switched_on:
                write(control_word_, 0x0F);
                return;
            case State::quick_stop_active:
                write(control_word_, random_.one_of({0x00, 0x0F, 0x02}));
                return;
            case State::fault:
                if (random_.chance(30)) release_everything();
                write(control_word_, 0x00);
                write(control_word_, 0x80);
                return;
            case State::operation_enabled:
                return drive_sensibly();
            case State::not_ready_to_switch_on:
            case State::fault_reaction_active:
                return;
        }
    }

    void drive_sensibly() {
        switch (get(mode_displayed_)) {
            case 1:
                write(control_word_, 0x0F);
                if (random_.chance(30)) {
                    write(target_, random_.between(-20'000, 20'000));
                    write(control_word_, 0x5F);
                } else {
                    write(target_, place());
                    write(control_word_, 0x1F);
                }
                break;
            case -1:
                write(control_word_, random_.one_of({0x0F, 0x1F, 0x5F, 0x11F, 0x15F, 0x10F}));
                break;
            case 6:
                write(control_word_, random_.chance(80) ? 0x0F : 0x10F);
                if (!process_bit(psr_reference) || random_.chance(20)) {
                    write(control_word_, 0x1F);
                } else {
                    write(mode_requested_, random_.one_of({-1, 1, 8}));
                }
                break;
            case 8:
                write(target_, get(position_) + random_.between(-200, 200));
                write(control_word_, random_.chance(85) ? 0x1F : 0x0F);
                if (random_.chance(50)) stream_targets();
                break;
            default:
                write(mode_requested_, process_bit(psr_reference) ? random_.one_of({-1, 1, 1, 8}) : 6);
                return;
        }
        if (random_.chance(5)) {
            write(mode_requested_, process_bit(psr_reference) ? random_.one_of({-1, 0, 1, 1, 6, 8}) : 6);
        }
    }

    /// A controller that sends its own trajectory, a set point in each cycle.
    void stream_targets() {
        write(row("PDOCycleTime"), 1'000);
        auto target = get(position_);
        std::int64_t way = 0;
        const auto acceleration = random_.between(-2, 2);
        for (int cycle = 0; cycle < 60 && status_bit(12) && !failed(); ++cycle) {
            way += cycle < 30 ? acceleration : -acceleration;
            target += way;
            write(target_, target);
            pass(Time(random_.chance(95) ? 1'000 : random_.between(500, 2'500)));
        }
    }

    std::int64_t place() {
        const auto travel = linear_ ? static_cast<std::int64_t>(kind_.travel) : 100'000;
        return random_.chance(85) ? random_.between(0, travel) : random_.between(-2 * travel, 3 * travel);
    }

    void set_sensible_parameter() {
        switch (random_.between(0, 29)) {
            case 0:
            case 1:
                return void(write(speed_, random_.between(1'000, 400'000)));
            case 2:
                return void(write(acceleration_, random_.between(50'000, 5'000'000)));
            case 3:
                return void(write(row("DecelerationQuickStop"), random_.between(100'000, 50'000'000)));
            case 4:
                return void(write(row("SCurve"), random_.between(1, 100)));
            case 5:
                return void(write(override_, random_.chance(20) ? 0 : random_.between(1, 100)));
            case 6:
                return void(write(row("FollowingPositionErrorWindow"), random_.between(500, 20'000)));
            case 7:
                return void(write(row("TargetPositionWindow"), random_.between(1, 500)));
            case 8:
                return void(write(row("TargetPositionWindowTime"), random_.between(0, 50)));
            case 9:
                return void(write(row("LimitIForce"), random_.chance(60) ? 0 : random_.between(50, 600)));
            case 10:
                write(row("SoftLimitPositionNegative"), random_.chance(50) ? 0 : place());
                return void(write(row("SoftLimitPositionPositive"), random_.chance(50) ? 0 : place()));
            case 11:
                return void(write(row("SPAD"), random_.between(0, 1)));
            case 12:
                return void(write(row("PDOCycleTime"), random_.between(100, 10'000)));
            case 13:
                return void(write(row("SOD"), random_.between(0, 1)));
            case 14:
                write(row("NOF"), random_.between(1, 8));
                return void(write(row("TYOF"), random_.chance(30) ? 11 : random_.between(0, 13)));
            case 15:
                return void(write(row("BRKD"), random_.between(1, 1'000)));
            case 16:
                return void(write(row("AREF"), random_.between(0, 1)));
            case 17:
                return void(write(row("FBCM"), random_.between(0, 1)));
            case 18:
                return void(write(reference_method_, linear_ ? random_.between(1, 6) : random_.between(10, 15)));
            case 19:
                return settle_parameters();
            case 20:
                return void(write(row("MassLoad"), random_.between(0, linear_ ? 1'000 : 50'000)));
            case 21:
                write(row("NIX"), random_.between(1, 50));
                write(row("AIX"), random_.between(50, 5'000));
                write(row("SIX"), random_.between(1'000, 400'000));
                write(row("TYIX"), random_.between(1, 2));
                return void(write(row("DIX"), random_.between(-30'000, 30'000)));
            case 22:
                write(row("NDIF"), random_.between(1, 10));
                write(row("ADIF"), random_.between(50, 2'000));
                write(row("SDIF"), random_.between(1'000, 30'000));
                write(row("DDIF"), random_.between(0, 1));
                return void(write(row("IDIF"), random_.between(0, 500)));
            case 23:
                write(row("NIF"), random_.between(1, 8));
                write(row("PAIF"), random_.between(0, 30'000));
                write(row("PBIF"), random_.chance(50) ? 0 : random_.between(1'000, 200'000));
                write(row("PCIF"), random_.chance(50) ? 0 : random_.between(50, 2'000));
                return void(write(row("TYIF"), random_.between(0, 22)));
            case 24:
                return void(write(row("ILA"), random_.chance(80) ? 0 : random_.between(0, 2)));
            case 25:
                write(row("NSEC"), random_.between(1, 10));
                write(row("SIFS"), place());
                write(row("SIFE"), place());
                return void(write(row("SSEC"), random_.between(0, 1023)));
            case 26:
                return void(write(row("WA"), random_.between(-40'000, 40'000)));
            case 27:
                return void(write(row("LF"), random_.chance(60) ? 0 : random_.between(1'000, 20'000)));
            case 28:
                return void(write(row("ReferenceSpeedForInternalZMark"), random_.between(0, 20'000)));
            default:
                return void(write(target_, place()));
        }
    }

    /// Any row that a bus may write, anything inside its limits; with a tendency to the default and the ends.
    void set_any_parameter() {
        const auto table = device_.store().table();
        const Parameter& chosen = table[static_cast<std::size_t>(random_.between(0, std::ssize(table) - 1))];
        if (!may_set(chosen.access) || &chosen == &direct_command_ || chosen.is_text()) return;
        std::int64_t value = random_.between(chosen.low, chosen.high);
        if (!chosen.allowed.empty()) {
            value = chosen.allowed[static_cast<std::size_t>(random_.between(0, std::ssize(chosen.allowed) - 1))];
        } else if (random_.chance(60)) {
            value = chosen.standard;
        } else if (random_.chance(10)) {
            value = random_.chance(50) ? chosen.low : chosen.high;
        }
        write(chosen, value);
    }

    void command() {
        const auto known = direct_commands();
        const auto& chosen = known[static_cast<std::size_t>(random_.between(0, std::ssize(known) - 1))];
        switch (random_.between(0, 9)) {
            case 0:
                return void(write(row("G"), place()));
            case 1:
                return void(write(row("IX"), random_.between(1, 50)));
            case 2:
                return void(write(row("DIF"), random_.between(1, 10)));
            case 3:
                return void(write(row("PG"), random_.between(1, 63)));
            default:
                // RES undoes what makes the rest interesting, CLPO moves the world under the soft limits.
                if ((chosen.value == cmd_res || chosen.value == cmd_clpo) && !random_.chance(10)) return;
                write(direct_command_, chosen.value);
        }
    }

    void mishap() {
        switch (random_.between(0, 16)) {
            case 0:
                return inject(
                    event::PutObstacle{place(), static_cast<double>(random_.between(1, 200)), random_.chance(50)});
            case 1:
                return inject(event::RemoveObstacle{});
            case 2:
                return inject(event::BlockAxis{random_.chance(40)});
            case 3:
                return inject(event::SetInput{static_cast<int>(random_.between(1, 12)), random_.chance(50)});
            case 4:
            case 5:
                return inject(event::LimitSwitch{
                    random_.chance(50) ? event::Direction::negative : event::Direction::positive, random_.chance(40)});
            case 6:
                return inject(event::EmergencyExit{random_.chance(40), random_.chance(50)});
            case 7:
            case 8: {
                using enum event::SafetyFunction;
                constexpr std::array functions{sto, ss1, ss2, sls};
                return inject(event::SafetyStop{functions[random_.next() % 4], random_.chance(40)});
            }
            case 9:
                return inject(event::LoseEncoder{random_.chance(30)});
            case 10:
                return inject(event::SetSupply{random_.chance(70) ? kind_.supply_voltage
                                                                  : static_cast<double>(random_.between(0, 100))});
            case 11:
                return inject(event::SetTemperature{static_cast<double>(random_.between(-20, 95))});
            case 12:
                return inject(
                    event::SetPayload{static_cast<double>(random_.between(0, 200)) / 100 * kind_.moving_mass});
            case 13:
                return inject(event::PushAxis{static_cast<double>(random_.between(-100, 100)) / 100 * strength()});
            case 14:
                if (random_.chance(30)) inject(event::CutPowerStage{});
                return;
            case 15:
                return inject(event::TurnMaster{static_cast<double>(random_.between(-5, 5)) * 10'000});
            default:
                if (random_.chance(30)) inject(event::PowerCycle{});
                if (random_.chance(30)) lose_controller();
        }
    }

    /// Its ramp may begin, as a fault reaction does, with the speed that the axis has.
    void lose_controller() {
        unlimited_ = true;
        inject(event::LoseController{});
    }

    [[nodiscard]] double strength() const { return kind_.force_constant * kind_.peak_current; }

    void release_everything() {
        inject(event::RemoveObstacle{});
        inject(event::BlockAxis{false});
        for (int number = 1; number <= 12; ++number) inject(event::SetInput{number, false});
        for (const auto direction : {event::Direction::negative, event::Direction::positive}) {
            inject(event::LimitSwitch{direction, false});
        }
        for (const bool keep_power : {false, true}) inject(event::EmergencyExit{false, keep_power});
        using enum event::SafetyFunction;
        for (const auto function : {sto, ss1, ss2, sls}) inject(event::SafetyStop{function, false});
        inject(event::LoseEncoder{false});
        inject(event::SetSupply{kind_.supply_voltage});
        inject(event::SetTemperature{25});
        inject(event::SetPayload{0});
        inject(event::PushAxis{0});
        inject(event::TurnMaster{0});
        // An input that is active while its wire is low, and stops everything, was asked for.
        write(row("ILA"), 0);
    }

    void inject(const Event& event) {
        device_.inject(event);
        check();
    }

    std::optional<Refusal> write(const Parameter& parameter, std::int64_t value) {
        allow_motions();
        const auto refusal = device_.write(parameter, value);
        allow_motions();
        check();
        return refusal;
    }

    // --------------------------------------------------------------------------------------------- what has to hold

    /// The fastest that any motion may go which could begin now, besides those of cyclic set points.
    void allow_motions() {
        const auto set = static_cast<double>(get(speed_));
        const double share = static_cast<double>(get(override_)) / 100;
        double speed = std::max({set * share, 40'000.0, static_cast<double>(get(sensor_speed_)),
                                 static_cast<double>(get(z_mark_speed_)), static_cast<double>(get(index_speed_)),
                                 static_cast<double>(get(dynamic_speed_)), static_cast<double>(get(force_speed_))});
        speed = std::max(speed, 400'000.0);  // other indices, and inputs
        allowed_speed_ = std::max(allowed_speed_, speed);
        const double most = std::max({static_cast<double>(get(acceleration_)), static_cast<double>(get(quick_stop_)),
                                      1000 * static_cast<double>(get(index_acceleration_)),
                                      1000 * static_cast<double>(get(dynamic_acceleration_)),
                                      1000 * static_cast<double>(get(force_acceleration_)), 5'000'000.0});
        allowed_acceleration_ = std::max(allowed_acceleration_, most);
    }

    void check() {
        if (failed()) return;
        check_status_word();
        check_messages();
        check_power();
        check_set_point();
        check_place();
        check_rows();
        if (failed()) {
            ADD_FAILURE() << name_ << " at " << now_.count() << " us, state " << Ds402::name(drive_->state())
                          << ", mode " << get(mode_displayed_) << ", error " << error();
        }
    }

    void check_status_word() {
        const auto word = static_cast<std::uint16_t>(get(status_word_));
        EXPECT_EQ(Ds402::state_of(word), drive_->state());
        EXPECT_EQ(word & 0x0200, 0x0200) << "remote";
        EXPECT_EQ(word & 0xC100, 0) << "bits 8, 14 and 15 mean nothing";
        const auto mode = get(mode_displayed_);
        EXPECT_TRUE(mode == -2 || mode == -1 || mode == 0 || mode == 1 || mode == 6 || mode == 8) << mode;
    }

    void check_messages() {
        const auto number = error();
        const auto* shown = xenax::find_message(number);
        EXPECT_TRUE(number == 0 || shown != nullptr) << number;
        const bool is_error = shown != nullptr && shown->severity == xenax::Severity::error;
        const bool fault = drive_->state() == State::fault || drive_->state() == State::fault_reaction_active;
        EXPECT_EQ(process_bit(psr_error), is_error) << number;
        EXPECT_EQ(fault, is_error) << number;
        EXPECT_EQ(process_bit(psr_warning), status_bit(7));
        EXPECT_EQ(number != 0, process_bit(psr_error) || process_bit(psr_warning) || process_bit(psr_information));
        EXPECT_EQ(std::get<std::string>(device_.store().value(error_text_)), xenax::error_text(number));
        EXPECT_EQ(get(tell_status_) == 9, is_error);
    }

    [[nodiscard]] bool may_have_power() const {
        return drive_->state() == State::operation_enabled || drive_->state() == State::quick_stop_active ||
               drive_->state() == State::fault_reaction_active;
    }

    void check_power() {
        if (may_have_power()) return;
        EXPECT_EQ(axis().set_point().velocity, 0);
        if (axis().brake()) return;  // the motor holds until the brake does
        EXPECT_EQ(axis().current(), 0);
        EXPECT_EQ(get(motor_current_), 0);
    }

    void check_set_point() {
        const MotionState& state = axis().set_point();
        EXPECT_TRUE(std::isfinite(state.position) && std::isfinite(state.velocity) &&
                    std::isfinite(state.acceleration));
        // A fault reaction begins with the speed that the axis has, and a cyclic set point is the controller's own.
        // A set point in step with a master is the master's.
        const bool cyclic = get(mode_displayed_) == 8 || get(synchronous_ratio_) != 0;
        if (drive_->state() == State::fault_reaction_active || cyclic) unlimited_ = true;
        if (!unlimited_) {
            EXPECT_LE(std::abs(state.velocity), allowed_speed_ * 1.000001);
            EXPECT_LE(std::abs(state.acceleration), allowed_acceleration_ * 1.000001);
        }
        const bool stands = state.velocity == 0 && !axis().moving();
        if (stands && drive_->state() != State::fault_reaction_active && !cyclic) {
            unlimited_ = false;
            allowed_speed_ = allowed_acceleration_ = 0;
            allow_motions();
        }
    }

    void check_place() {
        const Plant& plant = axis().plant();
        EXPECT_TRUE(std::isfinite(plant.position()) && std::isfinite(plant.velocity()) &&
                    std::isfinite(plant.contact_force()) && std::isfinite(axis().current()) &&
                    std::isfinite(axis().heat().winding()) && std::isfinite(axis().heat().i2t()));
        if (!kind_.has_stops) return;
        const double give = 0.02 * kind_.increments_per_unit;
        EXPECT_GT(plant.position(), kind_.stop_negative - give);
        EXPECT_LT(plant.position(), kind_.stop_positive + give);
        EXPECT_LE(std::abs(axis().current()), kind_.peak_current * 1.000001);
    }

    void check_rows() {
        for (const Parameter& parameter : device_.store().table()) {
            const Value& value = device_.store().value(parameter);
            if (parameter.is_text()) {
                EXPECT_LE(std::get<std::string>(value).size(), parameter.max_length) << parameter.name;
                continue;
            }
            // A second address may have narrower limits (PO and 607Ah); the variable has those of its owner.
            if (parameter.same_as) continue;
            const auto number = *std::get_if<std::int64_t>(&value);
            if (number < parameter.low || number > parameter.high) {
                ADD_FAILURE() << parameter.name << " = " << number << ", limits " << parameter.low << " and "
                              << parameter.high;
            }
        }
    }

    void mix(std::uint64_t value) { trace_ = (trace_ ^ value) * 0x100000001B3U; }

    void follow_trace() {
        mix(static_cast<std::uint64_t>(now_.count()));
        for (const Parameter& parameter : device_.store().table()) {
            const Value& value = device_.store().value(parameter);
            if (const auto* number = std::get_if<std::int64_t>(&value)) {
                mix(static_cast<std::uint64_t>(*number));
            } else {
                for (const char c : *std::get_if<std::string>(&value)) mix(static_cast<std::uint8_t>(c));
            }
        }
    }

    const Parameter& row(std::string_view name) {
        const auto rows = find_by_name(device_.store().table(), parameter_classes(), name);
        EXPECT_GE(rows.size(), 1U) << name;
        return *rows.front();
    }
    const Parameter& row(Key key) { return *device_.find(key); }
    [[nodiscard]] std::int64_t get(const Parameter& parameter) const {
        return *std::get_if<std::int64_t>(&device_.store().value(parameter));
    }
    [[nodiscard]] std::int64_t error() const { return get(error_number_); }
    [[nodiscard]] bool status_bit(unsigned number) const { return (get(status_word_) >> number & 1) != 0; }
    [[nodiscard]] bool process_bit(unsigned number) const { return (get(process_status_) >> number & 1) != 0; }
    [[nodiscard]] const Axis& axis() const { return drive_->axis(); }

    AxisKind kind_;
    Random random_;
    Device device_;
    XenaxDrive* drive_;
    std::string name_;
    bool linear_ = true;
    Time now_{0};
    std::uint64_t trace_ = 0xCBF29CE484222325U;
    double allowed_speed_ = 0;
    double allowed_acceleration_ = 0;
    bool unlimited_ = false;
    bool lives_ = false;
    std::int64_t calm_steps_ = 0;
    std::int64_t last_message_ = 0;
    Seen seen_;

    const Parameter& direct_command_ = row({0x65, 0x00});
    const Parameter& control_word_ = row({0x66, 0x00});
    const Parameter& status_word_ = row({0x66, 0x01});
    const Parameter& mode_requested_ = row({0x66, 0x20});
    const Parameter& mode_displayed_ = row({0x66, 0x21});
    const Parameter& position_ = row({0x66, 0x24});
    const Parameter& motor_current_ = row({0x66, 0x38});
    const Parameter& target_ = row({0x66, 0x3A});
    const Parameter& speed_ = row({0x66, 0x41});
    const Parameter& acceleration_ = row({0x66, 0x43});
    const Parameter& quick_stop_ = row({0x66, 0x45});
    const Parameter& reference_method_ = row({0x66, 0x58});
    const Parameter& sensor_speed_ = row({0x66, 0x5A});
    const Parameter& z_mark_speed_ = row({0x66, 0x5B});
    const Parameter& synchronous_ratio_ = row({0x65, 0x68});
    const Parameter& override_ = row({0x65, 0x64});
    const Parameter& index_acceleration_ = row({0x65, 0x5B});
    const Parameter& index_speed_ = row({0x65, 0x5C});
    const Parameter& dynamic_acceleration_ = row({0x65, 0x8A});
    const Parameter& dynamic_speed_ = row({0x65, 0x8B});
    const Parameter& force_acceleration_ = row({0x65, 0x7B});
    const Parameter& force_speed_ = row({0x65, 0x7C});
    const Parameter& error_number_ = row({0x64, 0x04});
    const Parameter& process_status_ = row({0x64, 0x06});
    const Parameter& tell_status_ = row({0x65, 0x02});
    const Parameter& error_text_ = row({0x69, 0x01});
};

constexpr int quarters = 4;

class RandomHour : public ::testing::TestWithParam<int> {};

// A quarter of an hour in each test, so that they run side by side. Each history is short enough to be looked into.
TEST_P(RandomHour, KeepsItsPromises) {
    const auto kinds = shipped_kinds();
    constexpr Time history = 30s;
    const auto histories = simulated / history;
    Seen seen;
    for (std::int64_t i = 0; i < histories; ++i) {
        const auto seed = static_cast<std::uint64_t>(GetParam() * histories + i + 1);
        constexpr std::array<std::string_view, 3> variants{"75v8s", "75v8", "48v8"};
        World world(kinds[seed % kinds.size()], variants[seed / 2 % variants.size()], seed);
        world.live(history);
        if (world.failed()) break;
        world.recover();
        ASSERT_FALSE(world.failed()) << "seed " << seed;
        seen.add(world.seen());
    }
    if (simulated < 900s) return;  // too short to have seen everything
    // What has been seen on the way. The self-test takes no time.
    for (std::size_t state = 1; state < seen.states.size(); ++state) {
        EXPECT_GT(seen.states[state], 0us) << Ds402::name(static_cast<State>(state));
    }
    for (const std::int64_t mode : {-1, 1, 6, 8}) EXPECT_GT(seen.modes_in_motion[mode], seen.total / 500) << mode;
    EXPECT_GT(seen.referenced, seen.total / 5);
    EXPECT_GE(seen.messages.size(), 12U);
}

INSTANTIATE_TEST_SUITE_P(Quarter, RandomHour, ::testing::Range(0, quarters));

TEST(RandomHistory, IsTheSameForTheSameSeed) {
    for (const AxisKind& kind : shipped_kinds()) {
        const auto trace_of = [&](std::uint64_t seed) {
            World world(kind, "75v8s", seed);
            world.live(3s);
            return world.trace();
        };
        const auto first = trace_of(17);
        EXPECT_EQ(trace_of(17), first) << kind.key;
        EXPECT_NE(trace_of(18), first) << kind.key;
    }
}

}  // namespace
}  // namespace servobus::drive
