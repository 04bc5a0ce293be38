// What happens in a simulation: who is there, and what befalls them, and when. A value: drawn from a seed, printed, shrunk,
// kept in a file, and played again.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace servobus::sim {

using std::chrono::microseconds;

/// What one direction of the line between a node and a drive does to what travels.
struct Faults {
    double loss = 0;       ///< share of the datagrams; a segment of a TCP connection comes 200 ms later instead
    double duplicate = 0;  ///< share of the datagrams that come twice
    double reorder = 0;    ///< share of the datagrams that are overtaken by what is sent within `jitter` or 5 ms
    microseconds delay{100};
    microseconds jitter{0};  ///< up to so much more, by chance
    friend bool operator==(const Faults&, const Faults&) = default;
};

struct DriveSpec {
    bool jog = false;  ///< the mode it is in: jog, or profile position
    friend bool operator==(const DriveSpec&, const DriveSpec&) = default;
};

/// An I/O connection that a node may open.
struct ConnectionSpec {
    unsigned node = 0;
    unsigned drive = 0;
    unsigned o_to_t_point = 101;
    unsigned t_to_o_point = 100;
    bool multicast = false;
    bool large = false;
    bool redundant = false;  ///< owner; no device here grants that
    microseconds o_to_t_rpi{10'000};
    microseconds t_to_o_rpi{10'000};
    unsigned multiplier = 2;  ///< code 0 to 7
    unsigned trigger = 0;     ///< 0 cyclic, 1 change of state, 2 application
    std::optional<microseconds> inhibit{};
    friend bool operator==(const ConnectionSpec&, const ConnectionSpec&) = default;
};

/// Somebody with explicit requests.
struct ClientSpec {
    unsigned node = 0;
    unsigned drive = 0;
    bool class3 = false;
    microseconds pause{100'000};  ///< from an answer to the next request
    unsigned burst = 1;           ///< requests at a time
    friend bool operator==(const ClientSpec&, const ClientSpec&) = default;
};

struct Action {
    enum class Kind : std::uint8_t {
        open,            ///< connection `subject`
        close,           ///< connection `subject`
        run,             ///< connection `subject` sends the run bit
        idle,            ///< connection `subject` sends idle
        move,            ///< the owner's program of connection `subject` makes the axis move, back and forth
        hold,            ///< ... stands under power
        relax,           ///< ... takes the power away
        start_client,    ///< client `subject`
        stop_client,     ///< client `subject`; `silent`: without good-bye
        faults,          ///< the line from node `subject` to drive `other`, in the directions of `way`
        cut,             ///< that line carries nothing for `duration`
        reset_streams,   ///< the TCP connections between node `subject` and drive `other` end at both ends
        crash_node,      ///< the program of node `subject` is gone for `duration`; `silent`: and so is its machine
        kill_drive,      ///< the program of drive `subject` is gone for `duration`; `silent`: and so is its machine
        power_cycle,     ///< logic power of drive `subject` off and on
        restart_drive,   ///< the module of drive `subject` is away for `duration`
        close_sessions,  ///< drive `subject` ends its sessions
        hold_up_node,    ///< the program of node `subject` gets no CPU for `duration`
        hold_up_drive,   ///< the same of drive `subject`
        discover,        ///< node `subject` broadcasts ListIdentity
        forge,           ///< node `subject` sends drive `other` data in the name of connections of other nodes
    };
    enum class Way : std::uint8_t { both, to_drive, to_node };

    microseconds at{0};
    Kind kind = Kind::open;
    unsigned subject = 0;
    unsigned other = 0;
    Way way = Way::both;
    bool silent = false;
    microseconds duration{0};
    Faults faults{};
    friend bool operator==(const Action&, const Action&) = default;
};

struct Scenario {
    std::uint64_t seed = 0;  ///< of what is left to chance while it runs
    microseconds length{0};  ///< afterwards everybody leaves, and it is looked at what stays behind
    unsigned nodes = 1;
    std::vector<DriveSpec> drives;
    std::vector<ConnectionSpec> connections;
    std::vector<ClientSpec> clients;
    std::vector<Action> actions;  ///< in the order of their times
    friend bool operator==(const Scenario&, const Scenario&) = default;
};

/// The same seed and length give the same scenario on every machine.
[[nodiscard]] Scenario draw(std::uint64_t seed, microseconds length);

[[nodiscard]] std::string to_json(const Scenario& scenario);
/// Nullopt, and `mistake` says why, when the text is none.
[[nodiscard]] std::optional<Scenario> from_json(const std::string& text, std::string& mistake);

[[nodiscard]] const char* name(Action::Kind kind);
/// One line, for people.
[[nodiscard]] std::string describe(const Action& action);

}  // namespace servobus::sim
