// A device: an identity, a table, and a machine behind both. No bus, no clock, no thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drive/axis_kind.hpp"
#include "drive/behaviour.hpp"
#include "drive/event.hpp"
#include "drive/motion_memory.hpp"
#include "drive/parameter.hpp"
#include "drive/refusal.hpp"
#include "drive/store.hpp"
#include "drive/stored_values.hpp"
#include "drive/time.hpp"

namespace servobus::drive {

/// Who the device says it is. The product name has at most 32 characters.
struct Identity {
    std::uint16_t vendor = 0;
    std::uint16_t device_type = 0;
    std::uint16_t product_code = 0;
    std::uint8_t major_revision = 1;  ///< 1..127
    std::uint8_t minor_revision = 1;  ///< 1..255
    std::uint32_t serial_number = 1;  ///< unique per vendor, never 0
    std::string product_name;
};

/// A command that has a number but no parameter (000 §2.3.2.1).
struct DirectCommand {
    std::uint32_t value;
    std::string_view mnemonic;  ///< `REF`; empty where the manual gives none
    std::string_view name;      ///< one word, for people without a mnemonic: `StartForceMonitoring`
    std::string_view text;
    Fidelity fidelity = Fidelity::behaves;
    std::string_view remark{};  ///< what it does instead, or what is different; a sentence
};

/// The row that tells which motor is connected, and what it says for each kind (000 §2.3.1.6). The printed default
/// stands when the motor is Motor::any.
struct MotorNames {
    Key row;
    std::string_view linear;
    std::string_view rotative;
};

/// What the outputs without a function do when the controller is lost.
enum class OutputsWithoutController : std::uint8_t { keep, off };

/// What is connected to a drive, and what it has stored. `seed` chooses the noise of what it measures.
struct Machine {
    AxisKind axis{};
    std::uint64_t seed = 1;
    MotionMemory memory{};
    OutputsWithoutController outputs_without_controller = OutputsWithoutController::keep;
};

struct Model;
/// Makes the behaviour of a model over its store, which outlives it.
using MakeBehaviour = std::unique_ptr<Behaviour> (*)(const Model& model, Store& store, const Machine& machine);

/// What is fixed about a kind of drive: a second drive model is a second one of these.
struct Model {
    std::string_view key;   ///< what `--variant` is given: `75v8s`
    std::string_view name;  ///< for people: `XENAX Xvi 75V8S`
    Identity identity;
    std::span<const Parameter> parameters;
    std::span<const DirectCommand> direct_commands;
    std::optional<Key> direct_command_row{};    ///< the row that takes a DirectCommand's value
    std::optional<Key> reference_method_row{};  ///< the row whose legal values depend on the motor
    bool has_force_option = false;              ///< rows marked `force_option` answer
    std::optional<MotorNames> motor_names{};    ///< the row that tells the connected motor
    MakeBehaviour make_behaviour = nullptr;     ///< what the drive does with a machine
};

/// The connected motor, as far as it decides which reference methods are legal (000 §2.3.4.16, §2.3.2).
enum class Motor : std::uint8_t { any, linear, rotative };

class Device {
public:
    /// A table without a machine: it keeps what is written, and nothing moves.
    explicit Device(Model model, Motor motor = Motor::any);
    /// The drive with an axis. The model has to have a behaviour.
    Device(Model model, const Machine& machine, Motor motor = Motor::any);

    [[nodiscard]] const Model& model() const { return model_; }
    [[nodiscard]] const Identity& identity() const { return model_.identity; }
    /// Another firmware runs.
    void set_revision(std::uint8_t major, std::uint8_t minor) {
        model_.identity.major_revision = major;
        model_.identity.minor_revision = minor;
    }
    [[nodiscard]] Store& store() { return *store_; }
    [[nodiscard]] const Store& store() const { return *store_; }
    [[nodiscard]] Motor motor() const { return motor_; }
    [[nodiscard]] bool has_machine() const { return behaviour_ != nullptr; }

    [[nodiscard]] const Parameter* find(Key key) const { return store_->find(key); }

    /// As Store::read, and `not_configured` for a row that this model does not have the hardware for.
    [[nodiscard]] ReadResult read(const Parameter& row) const;
    /// As Store::check, and `not_configured` for what variant or motor do not allow: a missing option comes right after
    /// access, so that its limits tell nothing; then the motor, and last what the machine can do now.
    [[nodiscard]] std::optional<Refusal> check(const Parameter& row, const Value& value) const;
    /// What a bus writes takes effect at once: the state machine has moved and the status word tells it.
    [[nodiscard]] std::optional<Refusal> write(const Parameter& row, Value value);

    /// What a controller's process data brings: as write(), but only until power-off (Store::cover).
    [[nodiscard]] std::optional<Refusal> write_process_data(const Parameter& row, const Value& value);

    /// What the device holds from delivery on instead of its printed defaults, whatever the rows' access: the drive hears
    /// of commands and set points among them after each power-up. Then power off and on, as delivered.
    void deliver(std::vector<std::pair<Key, Value>> values);
    /// What has been written since delivery, and power-off does not take: stored_values.hpp says of which rows.
    [[nodiscard]] StoredValues stored() const { return kept_->changes(); }
    /// Whether such a value can be this device's.
    [[nodiscard]] bool fits(const StoredValue& value) const { return kept_->fits(value); }
    /// Grows with each write that may have changed stored(), other than a command that takes time.
    [[nodiscard]] std::uint64_t lasting_writes() const { return lasting_writes_; }
    /// What is stored becomes this, with the power on: a write is taken back.
    void restore(const StoredValues& stored);
    /// Logic power off and on: stored() is this, set points and commands are forgotten.
    void power_up(const StoredValues& stored);

    /// Lets time pass. `now` never goes back; the first call only says when the drive was switched on.
    void step(Time now);
    /// When step() is wanted at the latest; nullopt while nothing moves.
    [[nodiscard]] std::optional<Time> next_deadline() const;
    /// Something happens from outside. Without a machine only a power cycle does, which keeps what is stored.
    void inject(const Event& event);
    /// A fault keeps the drive from doing what it is for, until it is reset.
    [[nodiscard]] bool has_fault() const { return behaviour_ && behaviour_->has_fault(); }
    /// What output `number`, 1 to 8, does to its wire; open without a machine.
    [[nodiscard]] OutputLevel output_wire(int number) const;

    /// Back to the state after delivery, power off and on.
    void reset() { power_up({}); }

private:
    [[nodiscard]] bool has(const Parameter& row) const { return !row.force_option || model_.has_force_option; }
    [[nodiscard]] bool motor_allows(const Parameter& row, const Value& value) const;
    [[nodiscard]] bool is_for_the_machine(const Parameter& row) const;
    void name_motor();

    Model model_;
    Motor motor_;
    std::unique_ptr<Store> store_;  ///< the behaviour keeps references into it, also when the device is moved
    std::unique_ptr<KeptValues> kept_;
    std::unique_ptr<Behaviour> behaviour_;
    std::vector<std::pair<Key, Value>> delivered_;
    std::uint64_t lasting_writes_ = 0;
};

}  // namespace servobus::drive
