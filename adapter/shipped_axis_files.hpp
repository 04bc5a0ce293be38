// The files of drive/axes as they are, inside the program; cmake/EmbedAxes.cmake writes the source file.
#pragma once

#include <span>
#include <string_view>

namespace servobus::adapter {

struct ShippedAxisFile {
    std::string_view name;  ///< `linax-lxc-230f10.json`
    std::string_view text;
};

[[nodiscard]] std::span<const ShippedAxisFile> shipped_axis_files();

}  // namespace servobus::adapter
