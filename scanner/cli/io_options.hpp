// The options of an I/O connection as they were typed, and the connection that they mean.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assemblies/connection.hpp"
#include "cip/path.hpp"
#include "eds/data_sheet.hpp"
#include "scanner/cli/io_data.hpp"
#include "scanner/io_plan.hpp"
#include "scanner/mistake.hpp"

namespace servobus::scanner::cli {

/// Application octets that fit a connection size of 16 bits in every format (R-CON-4, R-CON-7).
inline constexpr std::size_t max_io_octets = 0xFFFF - cip::sequence_count_octets - cip::run_idle_octets;

/// What `io`, `open` and `axis --io` are told about a connection.
struct ConnectionArguments {
    std::string connection{};  ///< a key of assemblies::connections(), or a name of the data sheet; empty: not said
    std::string eds{};         ///< a file; its connections instead of the XENAX's
    // The six numbers of any other device.
    std::optional<std::uint32_t> o_to_t_point{};
    std::optional<std::size_t> o_to_t_octets{};
    std::optional<std::uint32_t> t_to_o_point{};
    std::optional<std::size_t> t_to_o_octets{};
    std::string config_instance{};  ///< a number or `none`
    std::string rpi{};              ///< in milliseconds

    std::string o_to_t_rpi{};
    std::string t_to_o_rpi{};
    std::string o_to_t_format{};
    std::string t_to_o_format{};
    std::string key{};  ///< `auto`, `eds`, `none` or numbers
    std::string config{};
    std::string trigger{};
    std::string inhibit{};
    std::string priority{};
    unsigned multiplier = 16;
    bool multicast = false;
    bool variable = false;
    bool large = false;
    std::vector<std::string> changes{};  ///< `--set`
    bool idle = false;
};

/// The connection that they mean.
struct ConnectionTask {
    const assemblies::Connection* known = nullptr;  ///< nullptr when it is none of the XENAX's
    std::shared_ptr<const eds::DataSheet> sheet{};  ///< where it is described, if it is
    const eds::Connection* described = nullptr;     ///< in the sheet
    IoPlan plan{};
    IoOutputs outputs{};
    const assemblies::Layout* inputs = nullptr;  ///< of the XENAX's
    IoFields input_fields{};                     ///< empty when only their number of octets is known
    // What the assemblies are called, where they have names.
    std::string output_name{};
    std::string input_name{};
    cip::Bytes start{};  ///< of the outputs, where nothing is read from the device; empty: zeros
    std::vector<IoChange> changes{};
    bool key_of_device = false;  ///< the key is what the device says it is; it is still to be asked
    bool run = true;

    [[nodiscard]] bool has_outputs() const { return outputs.octets > 0; }
};

/// `default_rpi` is for those who say none.
[[nodiscard]] Parsed<ConnectionTask> make_task(const ConnectionArguments& arguments, const cip::Path& route,
                                               std::chrono::microseconds default_rpi = std::chrono::milliseconds(10));

/// `2.5` in milliseconds, or with a unit as parse_duration takes it; from 1 us to what a Forward_Open can say.
[[nodiscard]] Parsed<std::chrono::microseconds> parse_interval(std::string_view option, std::string_view text);

/// `header32`, as `--o2t-format` takes it.
[[nodiscard]] std::string_view format_key(cip::RealTimeFormat format);
/// `standard, iforce, …`.
[[nodiscard]] std::string connection_keys();

}  // namespace servobus::scanner::cli
