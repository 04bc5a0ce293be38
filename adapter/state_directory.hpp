// The directory of `--state`: a file for each drive of the process, by its serial number, and nobody else's meanwhile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "adapter/file_system.hpp"
#include "adapter/state_file.hpp"

namespace servobus::adapter {

class StateDirectory {
public:
    /// Makes the directory if it is not there (its parent has to be), locks it until this object goes, and looks whether it
    /// can be written. Otherwise the sentence that says why not, without a full stop.
    [[nodiscard]] static std::variant<StateDirectory, std::string> open(const std::filesystem::path& path);
    ~StateDirectory();
    StateDirectory(StateDirectory&& other) noexcept;
    StateDirectory(const StateDirectory&) = delete;
    StateDirectory& operator=(const StateDirectory&) = delete;
    StateDirectory& operator=(StateDirectory&&) = delete;

    /// `drive-00A1B2C3.state`.
    [[nodiscard]] std::filesystem::path file_of(std::uint32_t serial_number) const;

private:
    StateDirectory(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}

    std::filesystem::path path_;
    int lock_;  ///< descriptor of the file that is locked
};

}  // namespace servobus::adapter
