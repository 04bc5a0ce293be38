// The file that keeps the state of one drive: a line that says what it is and guards it, then the state as JSON.
//
//     servobus-state 1 DE5A3C24 66
//     {"network":{"host_name":"press-7"},"parameters":{"0x64/0x00":50}}
//
// The numbers are the version, the CRC-32 of what follows the line, and its length in octets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <variant>

#include "adapter/file_system.hpp"

namespace servobus::adapter {

/// Of the payload. A member that is new needs no new version: an older program keeps a file aside that has a member which
/// it does not know, and a newer one takes what is not there as delivered.
inline constexpr std::uint32_t state_version = 1;
/// Of a whole file.
inline constexpr std::size_t max_state_octets = std::size_t{1} << 20;
/// Files of one drive that are kept aside for a reason; after that the last one makes room for the next.
inline constexpr int max_kept_aside = 9;

/// The file around a payload.
[[nodiscard]] std::string seal(std::string_view payload);

/// Why a file is of no use.
struct BadState {
    enum class Kind : std::uint8_t { damaged, newer };
    Kind kind = Kind::damaged;
    std::string reason;  ///< a sentence without a full stop
};
/// The payload of a file that is whole.
[[nodiscard]] std::variant<std::string, BadState> unseal(std::string_view octets);

class StateFile {
public:
    /// The file system outlives this.
    StateFile(FileSystem& files, std::filesystem::path path) : files_(&files), path_(std::move(path)) {}

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

    /// The payload as it was stored last; nullopt when there is no file.
    [[nodiscard]] std::optional<std::variant<std::string, BadState>> load();
    /// Puts the payload in the place of the one before, whole or not at all, and returns when it survives power-off.
    /// After an error the one before is there.
    [[nodiscard]] std::error_code store(std::string_view payload);
    /// Gives the file another name, such as `drive.state.damaged-1`, so that somebody may look at it. Returns it, or why
    /// not.
    [[nodiscard]] std::variant<std::filesystem::path, std::error_code> keep_aside(BadState::Kind kind);

private:
    [[nodiscard]] std::error_code replace(std::string_view octets);
    void undo();

    FileSystem* files_;
    std::filesystem::path path_;
    std::optional<std::string> stored_;  ///< what the file holds, for as long as there is one
};

}  // namespace servobus::adapter
