// The DS402 state machine: the transitions of 004 §4.1 as a table, control words as 004 §4.2.2 and status words as
// 004 §4.2.3 print them. What a transition does to power and motion is its user's business.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace servobus::drive {

class Ds402 {
public:
    enum class State : std::uint8_t {
        not_ready_to_switch_on,
        switch_on_disabled,
        ready_to_switch_on,
        switched_on,
        operation_enabled,
        quick_stop_active,
        fault_reaction_active,
        fault,
    };

    /// What moves the machine: commands of the control word, and what the drive itself notices.
    enum class Event : std::uint8_t {
        shutdown,
        switch_on,
        disable_voltage,
        quick_stop,
        disable_operation,
        enable_operation,
        fault_reset,  ///< bit 7 rises
        powered_on,   ///< power on or reset of the application: the self-test begins
        initialised,  ///< the self-test is over
        fault_detected,
        reaction_done,  ///< the fault reaction has ended
    };

    /// What a control word looks like for an event: `word & mask == value`, and for fault_reset a rising bit. Some
    /// words mean two events; at most one of them has a row in any state.
    struct Command {
        Event event;
        std::uint16_t mask;
        std::uint16_t value;
    };

    /// A row of 004 §4.1. Transition 13 has a row for each state that it leaves.
    struct Transition {
        int number;  ///< 0 to 16
        State from;
        Event event;
        State to;
    };

    /// A row of the status word table.
    struct Pattern {
        State state;
        std::uint16_t mask;
        std::uint16_t value;
        std::string_view name;  ///< "Ready to switch on"
    };

    [[nodiscard]] static std::span<const Command> commands();
    [[nodiscard]] static std::span<const Transition> transitions();
    [[nodiscard]] static std::span<const Pattern> patterns();
    [[nodiscard]] static std::string_view name(State state);
    /// The state that a status word shows, or nullopt when it is none of the printed patterns.
    [[nodiscard]] static std::optional<State> state_of(std::uint16_t status_word);

    /// Bits of the status word that belong to the state: 0, 1, 2, 3, 5 and 6.
    static constexpr std::uint16_t state_bits = 0x006F;

    /// Called with the row of each transition that happens, after the state has changed. The guard says whether a
    /// transition may happen now: a fault that is still there is not reset (row 15), without voltage nothing is
    /// switched on (row 3).
    class Listener {
    public:
        virtual ~Listener() = default;
        [[nodiscard]] virtual bool allows(const Transition& transition) = 0;
        virtual void happened(const Transition& transition) = 0;

    protected:
        Listener() = default;
        Listener(const Listener&) = default;
        Listener& operator=(const Listener&) = default;
    };

    [[nodiscard]] State state() const { return state_; }
    /// The bits of `state_bits` for the state.
    [[nodiscard]] std::uint16_t status_word() const;

    /// A control word has been written, changed or not. At most two transitions follow: 3 is followed by 4 when the
    /// word also enables operation (004 §4.2.2, note).
    void on_control_word(std::uint16_t word, Listener& listener);
    /// Something that the drive notices itself, or a local command that stands for a control word.
    void on_event(Event event, Listener& listener);
    /// Not ready to switch on, with no control word seen yet. Nobody is told; Event::powered_on is row 0.
    void reset();

    [[nodiscard]] std::uint16_t control_word() const { return control_word_; }

private:
    const Transition* take(Event event, Listener& listener);

    State state_ = State::not_ready_to_switch_on;
    std::uint16_t control_word_ = 0;
};

}  // namespace servobus::drive
