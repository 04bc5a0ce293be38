#include "adapter/file_settings.hpp"

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "eds/data_sheet.hpp"
#include "eds/generate.hpp"
#include "eds/icon.hpp"

namespace servobus::adapter {
namespace {

DeviceFile device_file(std::string_view content, std::string name, eds::Revision revision) {
    return {.content = std::make_shared<const cip::Bytes>(content.begin(), content.end()),
            .name = std::move(name),
            .major_revision = revision.major,
            .minor_revision = revision.minor};
}

}  // namespace

std::variant<DeviceFile, FileError> load_device_file(const std::filesystem::path& path) {
    const auto content = read_file(path);
    if (const auto* error = std::get_if<FileError>(&content)) return *error;
    const auto& text = std::get<std::string>(content);
    const auto sheet = eds::read(text);
    const auto revision = sheet && sheet->file.revision ? *sheet->file.revision : eds::Revision{1, 0};
    return device_file(text, path.filename().string(), revision);
}

DeviceFiles generated_files(const Config& config) {
    const auto model = model_of(config);
    const eds::ConnectionLimits limits{.io = 1 + static_cast<std::uint32_t>(config.limits.listening_connections),
                                       .messages = static_cast<std::uint32_t>(config.limits.class3_connections)};
    const auto icon = eds::icon();
    return {.eds = device_file(eds::generate(model, limits), eds::file_name(model), eds::sheet_revision),
            .icon = device_file({reinterpret_cast<const char*>(icon.data()), icon.size()},
                                std::string(eds::icon_file_name), eds::sheet_revision)};
}

}  // namespace servobus::adapter
