#include "adapter/state_directory.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

namespace servobus::adapter {
namespace {

constexpr int accessible_by_all = 0755;
constexpr int readable_by_all = 0644;

std::string cannot(const std::filesystem::path& path, std::error_code error) {
    return fmt::format("the state cannot be kept in '{}': {}", path.string(), error.message());
}

std::error_code last_error() { return {errno, std::generic_category()}; }

// Who holds the lock has written its process number there.
std::string holder(int descriptor) {
    std::array<char, 16> text{};
    const auto size = ::pread(descriptor, text.data(), text.size() - 1, 0);
    const std::string number(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    return number.empty() ? std::string() : fmt::format(", process {}", number.substr(0, number.find('\n')));
}

}  // namespace

std::variant<StateDirectory, std::string> StateDirectory::open(const std::filesystem::path& path) {
    PosixFileSystem files;
    const auto absolute = std::filesystem::absolute(path).lexically_normal();
    const bool made = ::mkdir(absolute.c_str(), accessible_by_all) == 0;
    if (!made && errno != EEXIST) return cannot(path, last_error());
    if (made) static_cast<void>(files.synchronise_directory(absolute.parent_path()));
    const auto file = absolute / "lock";
    const int lock = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, readable_by_all);
    if (lock < 0) return cannot(path, last_error());
    StateDirectory directory(absolute, lock);
    if (::flock(lock, LOCK_EX | LOCK_NB) != 0) {
        if (errno != EWOULDBLOCK) return cannot(path, last_error());
        return fmt::format("the state in '{}' is another servobus-adapter's{}; stop it, or choose another --state",
                           path.string(), holder(lock));
    }
    const auto trial = absolute / "trial.new";
    auto error = files.write(trial, std::to_string(::getpid()));
    if (!error) error = files.remove(trial);
    if (!error) error = files.write(file, fmt::format("{}\n", ::getpid()));
    if (!error) error = files.synchronise_directory(absolute);
    if (error) return cannot(path, error);
    return directory;
}

StateDirectory::~StateDirectory() {
    if (lock_ >= 0) ::close(lock_);
}

StateDirectory::StateDirectory(StateDirectory&& other) noexcept
    : path_(std::move(other.path_)), lock_(std::exchange(other.lock_, -1)) {}

std::filesystem::path StateDirectory::file_of(std::uint32_t serial_number) const {
    return path_ / fmt::format("drive-{:08X}.state", serial_number);
}

}  // namespace servobus::adapter
