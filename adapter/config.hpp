// The configuration file of servobus-adapter: JSON, read whole or refused whole.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "adapter/limits.hpp"
#include "adapter/log.hpp"
#include "adapter/network_settings.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

/// Everything that the command line or a file can choose. The defaults are those of a program started without either.
struct Config {
    std::string variant = "75v8s";
    std::string bind = "127.0.0.1";
    std::uint16_t port = 44818;
    LogLevel log_level = LogLevel::info;
    drive::Motor motor = drive::Motor::any;
    std::optional<std::uint32_t> serial_number{};
    std::optional<std::uint8_t> major_revision{};
    std::optional<std::uint8_t> minor_revision{};
    std::optional<std::string> product_name{};
    /// The EDS file that the File object hands out; a path relative to the working directory.
    std::optional<std::string> eds{};
    /// What parameters hold after power-up instead of their printed defaults, whatever their access.
    std::vector<std::pair<drive::Key, drive::Value>> values{};
    Limits limits{};
};

/// What is wrong with a file, and where: line and column count from 1, 0 when the file as a whole is meant.
struct ConfigError {
    std::size_t line = 0;
    std::size_t column = 0;
    std::string reason;
};

/// `drive.json:3:15: 'port' must be a whole number from 0 to 65535`.
[[nodiscard]] std::string describe(const std::filesystem::path& file, const ConfigError& error);

/// `text` is the file's content. Unknown and repeated keys are errors: a misspelt setting that is silently ignored
/// costs its author an afternoon.
[[nodiscard]] std::variant<Config, ConfigError> parse_config(const std::string& text);
[[nodiscard]] std::variant<Config, ConfigError> load_config(const std::filesystem::path& file);

/// The level that a word names: trace, debug, info, warning, error.
[[nodiscard]] std::optional<LogLevel> log_level(std::string_view word);

/// The network settings that a configuration describes: the MAC address follows from the serial number, so that two
/// drives on one network differ.
[[nodiscard]] NetworkSettings make_network(const drive::Identity& identity);

/// The EDS that is configured, read whole; without one, a file object that says it has none.
[[nodiscard]] std::variant<DeviceFile, ConfigError> load_eds(const Config& config);

/// The device that a configuration describes, after power-up.
[[nodiscard]] drive::Device make_device(const Config& config);
/// The configured values on top of what the device holds.
void apply_values(const Config& config, drive::Device& device);

}  // namespace servobus::adapter
