// The drives of one process: each with its own address, identity, serial number and state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "adapter/adapter.hpp"
#include "adapter/config.hpp"
#include "adapter/device_files.hpp"
#include "adapter/log.hpp"
#include "adapter/log_line.hpp"
#include "adapter/timetable.hpp"
#include "drive/device.hpp"
#include "enip/endpoint.hpp"

namespace servobus::adapter {

/// Drives of one process at most.
inline constexpr std::size_t max_drives = 1024;

/// The addresses of `count` drives: those that are given, or as many as there are from the only one on. The result is
/// why not, when there are too few, too many, or they are no IPv4 addresses.
[[nodiscard]] std::variant<std::vector<std::string>, std::string> drive_addresses(const std::vector<std::string>& binds,
                                                                                  std::size_t count);

class Fleet {
public:
    struct Member {
        Member(drive::Device made, const Config& config, std::uint64_t seed, LogSink log, DeviceFiles files);

        drive::Device device;
        Adapter adapter;
    };

    /// The first drive has the configured serial number and seed, each further one the next.
    /// `seed` is for what must not be predicted. With more than one drive each line of the log says whose it is.
    Fleet(const Config& config, const std::vector<std::string>& addresses, std::uint64_t seed, const LogSink& log,
          const DeviceFiles& files, const Timetable& scenario);

    [[nodiscard]] std::size_t size() const { return members_.size(); }
    [[nodiscard]] Member& operator[](std::size_t index) { return *members_[index]; }
    [[nodiscard]] std::size_t sessions() const;
    /// Who wants a line about each access to any of them. With more than one drive each line says which.
    void on_access(const LineSink& sink);
    /// All of them have this image in their flash at power-on; why not, a clause.
    [[nodiscard]] std::optional<std::string> install(const FlashImage& image);
    void shut_down();

private:
    std::vector<std::unique_ptr<Member>> members_;
    std::vector<std::string> addresses_;
};

}  // namespace servobus::adapter
