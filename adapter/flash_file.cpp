#include "adapter/flash_file.hpp"

#include <fmt/format.h>

#include "adapter/text_file.hpp"

namespace servobus::adapter {

std::variant<FlashImage, std::string> load_flash(const std::filesystem::path& file) {
    const auto content = read_file(file, max_flash_octets);
    if (const auto* error = std::get_if<FileError>(&content)) return describe(file, *error);
    const auto& text = std::get<std::string>(content);
    auto image = FlashImage::parse(cip::Bytes(text.begin(), text.end()));
    if (const auto* wrong = std::get_if<std::string>(&image)) return fmt::format("{}: {}", file.string(), *wrong);
    return image;
}

}  // namespace servobus::adapter
