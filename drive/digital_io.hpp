// The 12 digital inputs and 8 outputs: which level is active, what an input function asks for, what an output function
// shows (004 §4.2.26, §4.2.27). The manuals here number the functions (TYIF 0 to 22, TYOF 0 to 13) and do not name
// them: the names are chosen.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace servobus::drive {

inline constexpr int digital_inputs = 12;
inline constexpr int digital_outputs = 8;
/// Inputs and outputs 1 to 8 can have a function; function n (NIF, NOF) belongs to input or output n.
inline constexpr std::size_t io_functions = 8;

// ---------------------------------------------------------------------------------------------------------- inputs

/// TYIF. "On" is the edge on which the input becomes active. A, B and C are PAIF, PBIF and PCIF.
enum class InputFunction : std::uint8_t {
    none = 0,
    reference = 1,                 ///< on: REF
    power_on = 2,                  ///< on: PWC
    power_off = 3,                 ///< on: PQ
    power = 4,                     ///< on: PWC, off: PQ
    stop = 5,                      ///< on: SM
    go_position = 6,               ///< on: G to A, with speed B and acceleration C * 1000; 0 leaves SP, AC
    go_way = 7,                    ///< on: GW by A, with B and C like go_position
    index = 8,                     ///< on: IX A
    index_both_edges = 9,          ///< on: IX A, off: IX B
    program = 10,                  ///< on: PG A
    profile = 11,                  ///< on: PRF A
    jog_positive = 12,             ///< on: JP, off: SM
    jog_negative = 13,             ///< on: JN, off: SM
    drive_force = 14,              ///< on: DIF A
    interrupt_program = 15,        ///< on: the program stops, off: it goes on
    capture_position = 16,         ///< on: the position is captured as by input 12
    sector_offset = 17,            ///< on: TPSO
    negative_limit_switch = 18,    ///< while active
    positive_limit_switch = 19,    ///< while active
    emergency_exit = 20,           ///< while active: EE
    emergency_exit_power_on = 21,  ///< while active: EE1
    fault_reset = 22,              ///< on
};

/// What an edge asks for.
enum class InputAction : std::uint8_t {
    reference,
    power_on,
    power_off,
    stop,
    go_position,
    go_way,
    start_index,
    start_program,
    start_profile,
    jog_positive,
    jog_negative,
    drive_force,
    interrupt_program,
    continue_program,
    capture_position,
    take_sector_offset,
    fault_reset,
};

struct InputRequest {
    InputAction action{};
    int input = 1;  ///< 1 to 8
    /// a: the position, way, or number; b and c: speed and acceleration / 1000 of a motion, 0 for the set ones.
    std::int32_t a = 0;
    std::int32_t b = 0;
    std::int32_t c = 0;

    friend bool operator==(const InputRequest&, const InputRequest&) = default;
};

/// At most one request for each function, in the order of the inputs. Lives on the stack: it is made in every period.
class InputRequests {
public:
    void push(const InputRequest& request) { requests_[size_++] = request; }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }
    [[nodiscard]] const InputRequest* begin() const { return requests_.data(); }
    [[nodiscard]] const InputRequest* end() const { return requests_.data() + size_; }

private:
    std::array<InputRequest, io_functions> requests_{};
    std::size_t size_ = 0;
};

/// TYIF, PAIF, PBIF, PCIF of one input.
struct InputFunctionSettings {
    std::int64_t type = 0;  ///< numbers that InputFunction does not have are `none`
    std::int32_t a = 0;
    std::int32_t b = 0;
    std::int32_t c = 0;
};

struct InputSettings {
    std::int64_t low_active = 0;        ///< ILA: 0 all active high, 1 all active low, 2 as ILAS says
    std::uint16_t low_active_mask = 0;  ///< ILAS, input 1 in the lowest bit
    std::array<InputFunctionSettings, io_functions> functions{};
};

/// What active inputs say for as long as they are active.
struct InputSignals {
    bool negative_limit_switch = false;    ///< PSR 10
    bool positive_limit_switch = false;    ///< PSR 11
    bool emergency_exit_power_on = false;  ///< PSR 12
    bool emergency_exit = false;           ///< PSR 13

    friend bool operator==(const InputSignals&, const InputSignals&) = default;
};

// A pattern of inputs has input 1 in its lowest bit. Levels are electrical (1 is high) and are what TIX shows; an input
// is active at the level that ILA and ILAS give.

/// The pattern with input `number` (1 to 12) changed; other numbers change nothing.
[[nodiscard]] std::uint16_t with_input(std::uint16_t levels, int number, bool high);
[[nodiscard]] bool is_set(std::uint16_t pattern, int number);

[[nodiscard]] std::uint16_t active_inputs(std::uint16_t levels, const InputSettings& settings);
[[nodiscard]] InputSignals input_signals(std::uint16_t levels, const InputSettings& settings);

/// What the edges between two patterns of levels ask for. Both are read with the same settings, so that a change of
/// ILA alone starts nothing.
[[nodiscard]] InputRequests input_requests(std::uint16_t before, std::uint16_t now, const InputSettings& settings);

/// 60FDh, 0x66/0xBD: levels in bits 16 to 27, limit switches in bits 0 and 1, either emergency exit in bit 3.
[[nodiscard]] std::uint32_t digital_inputs_word(std::uint16_t levels, const InputSignals& signals);

/// ETI, DTI and EVT: which inputs are watched. Number 0 means all of them.
class InputTracking {
public:
    void enable(int number);
    void disable(int number);
    void set_events(bool on) { events_ = on; }
    [[nodiscard]] bool events() const { return events_; }
    [[nodiscard]] std::uint16_t tracked() const { return tracked_; }
    /// The inputs whose change an event reports.
    [[nodiscard]] std::uint16_t reported(std::uint16_t before, std::uint16_t now) const;

private:
    std::uint16_t tracked_ = 0;
    bool events_ = false;
};

// --------------------------------------------------------------------------------------------------------- outputs

/// TYOF: the flag that the output shows instead of what is written to it.
enum class OutputFunction : std::uint8_t {
    none = 0,
    error = 1,
    reference = 2,
    in_motion = 3,
    in_position = 4,
    end_of_program = 5,
    in_force = 6,
    in_sector = 7,
    force_in_sector = 8,
    power_on = 9,
    trigger = 10,
    brake_released = 11,
    warning = 12,
    force_limit_reached = 13,
};

/// The drive as the output functions see it.
struct OutputFlags {
    bool error = false;
    bool reference = false;
    bool in_motion = false;
    bool in_position = false;
    bool end_of_program = false;
    bool in_force = false;
    bool in_sector = false;
    bool force_in_sector = false;
    bool power_on = false;
    bool trigger = false;
    bool brake_released = false;
    bool warning = false;
    bool force_limit_reached = false;
};

struct OutputSettings {
    std::uint8_t high_active = 0xFF;  ///< SOA: logic 1 is the driven level, output 1 in the lowest bit
    std::uint16_t type = 0x5555;      ///< SOT: 0 sink, 1 source, 2 both, two bits each, output 1 in the lowest
    std::array<std::int64_t, io_functions> functions{};  ///< TYOF; numbers that OutputFunction does not have are `none`
};

/// What an output does to its wire.
enum class OutputLevel : std::uint8_t { open, low, high };

/// What SO, CO, SOX and 60FEh have written last, whoever it was. An output with a function keeps what is written for
/// the time when the function is taken away.
class DigitalOutputs {
public:
    void set(int number) { write(number, true); }         ///< SO; numbers other than 1 to 8 do nothing
    void clear(int number) { write(number, false); }      ///< CO
    void set_all(std::uint8_t mask) { written_ = mask; }  ///< SOX
    /// 60FEh, 0x66/0xBF: bits 16 to 23, the others mean nothing.
    void write_word(std::uint32_t word) { written_ = static_cast<std::uint8_t>(word >> 16U); }
    [[nodiscard]] std::uint32_t word() const { return static_cast<std::uint32_t>(written_) << 16U; }

    /// TOX: logic states, output 1 in the lowest bit.
    [[nodiscard]] std::uint8_t states(const OutputSettings& settings, const OutputFlags& flags) const;

private:
    void write(int number, bool on);

    std::uint8_t written_ = 0;
};

/// What output `number` (1 to 8) does to its wire in a pattern of states().
[[nodiscard]] OutputLevel output_level(std::uint8_t states, int number, const OutputSettings& settings);

}  // namespace servobus::drive
