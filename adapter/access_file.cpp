#include "adapter/access_file.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "adapter/config.hpp"

namespace servobus::adapter {
namespace {

std::string text_of(std::chrono::system_clock::time_point time) {
    const auto whole = std::chrono::floor<std::chrono::seconds>(time);
    const auto rest = std::chrono::floor<std::chrono::milliseconds>(time - whole);
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(whole), rest.count());
}

}  // namespace

std::string to_json(const LogLine& line, std::chrono::system_clock::time_point time) {
    using Object = nlohmann::ordered_json;
    Object object{{"time", text_of(time)}, {"level", word(line.level)}, {"event", line.event}};
    for (const auto& [key, value] : line.values) object[key] = value;
    return object.dump(-1, ' ', false, Object::error_handler_t::replace);
}

std::variant<AccessFile, std::string> AccessFile::open(const std::string& path) {
    // Close on exec, and not a terminal that would become ours.
    const int descriptor =
        ::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NOCTTY, S_IRUSR | S_IWUSR);
    auto* file = descriptor < 0 ? nullptr : ::fdopen(descriptor, "a");
    if (file == nullptr) {
        const auto reason = fmt::format("{}: cannot be written: {}", path, std::strerror(errno));
        if (descriptor >= 0) ::close(descriptor);
        return reason;
    }
    return AccessFile(file, path);
}

std::optional<std::string> AccessFile::write(const LogLine& line, std::chrono::system_clock::time_point time) {
    const auto text = to_json(line, time) + '\n';
    const bool written = std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size();
    if (written && std::fflush(file_.get()) == 0) return std::nullopt;
    std::clearerr(file_.get());
    if (std::exchange(failed_, true)) return std::nullopt;
    return fmt::format("{} cannot be written any more: {}; lines are lost", path_, std::strerror(errno));
}

}  // namespace servobus::adapter
