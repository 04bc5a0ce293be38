// The configuration file of servobus-adapter: JSON, read whole or refused whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "adapter/access_policy.hpp"
#include "adapter/allow_list.hpp"
#include "adapter/limits.hpp"
#include "adapter/log.hpp"
#include "adapter/network_settings.hpp"
#include "adapter/network_state.hpp"
#include "adapter/text_file.hpp"
#include "drive/axis_kind.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

/// Everything that the command line or a file can choose. The defaults are those of a program started without either.
struct Config {
    std::string variant = "75v8s";
    std::string bind = "127.0.0.1";
    std::uint16_t port = 44818;
    std::optional<std::uint16_t> io_port{};  ///< of class 0 and 1; see enip::asio::ListenOptions
    std::size_t count = 1;                   ///< how many drives, at addresses from `bind` on
    /// The interface whose address the drive decides, instead of `bind`.
    std::optional<std::string> manage_interface{};
    NetworkSettings network{};  ///< of a drive that has just come from the factory
    LogLevel log_level = LogLevel::info;
    /// The axis that somebody has chosen; without one it is default_axis, and any motor is accepted.
    std::optional<drive::AxisKind> axis{};
    /// A file that it is still to be read from, by load_axis().
    std::optional<std::string> axis_file{};
    /// Chooses the noise of what the drive measures: the same seed, the same noise.
    std::uint64_t seed = 1;
    /// Without one it follows from a chosen axis.
    std::optional<drive::Motor> motor{};
    std::optional<std::uint32_t> serial_number{};
    std::optional<std::uint8_t> major_revision{};
    std::optional<std::uint8_t> minor_revision{};
    std::optional<std::string> product_name{};
    /// What the File object hands out as EDS and icon instead of what is generated: paths relative to the working
    /// directory. With an EDS of somebody's own there is no icon but a configured one.
    std::optional<std::string> eds{};
    std::optional<std::string> icon{};
    /// The firmware image that is in the flash at power-on; a path relative to the working directory.
    std::optional<std::string> flash{};
    /// The directory that keeps what is written to the drives over the end of the program.
    std::optional<std::string> state{};
    /// What happens to the drive while the program runs: the file that parse_scenario() reads.
    std::optional<std::string> scenario{};
    /// What parameters hold instead of their printed defaults until somebody writes them, whatever their access.
    std::vector<std::pair<drive::Key, drive::Value>> values{};
    drive::MotionMemory memory{};  ///< programs and profiles
    drive::OutputsWithoutController outputs_without_controller = drive::OutputsWithoutController::keep;
    Limits limits{};
    AllowList allowed{};  ///< who may speak to the drives; empty: everybody
    Protection protection{};
    /// The file that gets a line of JSON for each access that changes something or is refused.
    std::optional<std::string> access_log{};
};

/// `text` is the file's content. Unknown and repeated keys are errors: a misspelt setting that is silently ignored
/// costs its author an afternoon.
[[nodiscard]] std::variant<Config, FileError> parse_config(const std::string& text);
[[nodiscard]] std::variant<Config, FileError> load_config(const std::filesystem::path& file);

/// Takes an axis by its key, or remembers its file. Returns why not; empty when it is taken.
[[nodiscard]] std::string choose_axis(const std::string& word, Config& config);
/// Reads the axis' file, if one is still to be read; the error is about config.axis_file.
[[nodiscard]] std::optional<FileError> load_axis(Config& config);

/// The level that a word names: trace, debug, info, warning, error.
[[nodiscard]] std::optional<LogLevel> log_level(std::string_view word);
[[nodiscard]] std::string_view word(LogLevel level);

/// The network of a device that has just come from the factory: the MAC address follows from the serial number, so that two
/// drives on one network differ.
[[nodiscard]] Network make_network(const drive::Identity& identity, NetworkSettings settings = {});

/// The axis that is chosen, or the default one.
[[nodiscard]] const drive::AxisKind& axis_of(const Config& config);
[[nodiscard]] drive::Motor motor_of(const Config& config);
/// The configured variant, with the configured identity.
[[nodiscard]] drive::Model model_of(const Config& config);
/// The device that a configuration describes, after power-up.
[[nodiscard]] drive::Device make_device(const Config& config);

}  // namespace servobus::adapter
