#include "adapter/file_system.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>

namespace servobus::adapter {
namespace {

constexpr int readable_by_all = 0644;

std::error_code last_error() { return {errno, std::generic_category()}; }

/// A descriptor that is closed with it.
class Descriptor {
public:
    Descriptor(const std::filesystem::path& file, int flags, int mode = 0)
        : number_(::open(file.c_str(), flags | O_CLOEXEC, mode)) {}
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    [[nodiscard]] bool is_open() const { return number_ >= 0; }
    [[nodiscard]] int number() const { return number_; }
    [[nodiscard]] std::error_code synchronise() const {
        while (::fsync(number_) != 0) {
            if (errno != EINTR) return last_error();
        }
        return {};
    }

private:
    int number_;
};

std::error_code write_all(int descriptor, std::string_view octets) {
    while (!octets.empty()) {
        const auto written = ::write(descriptor, octets.data(), octets.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return last_error();
        octets.remove_prefix(static_cast<std::size_t>(written));
    }
    return {};
}

}  // namespace

boost::system::result<std::string, std::error_code> PosixFileSystem::read(const std::filesystem::path& file,
                                                                          std::size_t limit) const {
    const Descriptor descriptor(file, O_RDONLY);
    if (!descriptor.is_open()) return last_error();
    std::string octets;
    std::array<char, 16384> part{};
    while (octets.size() <= limit) {
        const auto size = ::read(descriptor.number(), part.data(), part.size());
        if (size < 0 && errno == EINTR) continue;
        if (size < 0) return last_error();
        if (size == 0) return octets;
        octets.append(part.data(), static_cast<std::size_t>(size));
    }
    return std::make_error_code(std::errc::file_too_large);
}

bool PosixFileSystem::exists(const std::filesystem::path& file) const {
    struct stat status {};
    return ::lstat(file.c_str(), &status) == 0;
}

std::error_code PosixFileSystem::write(const std::filesystem::path& file, std::string_view octets) {
    const Descriptor descriptor(file, O_WRONLY | O_CREAT | O_TRUNC, readable_by_all);
    if (!descriptor.is_open()) return last_error();
    if (const auto error = write_all(descriptor.number(), octets)) return error;
    return descriptor.synchronise();
}

std::error_code PosixFileSystem::rename(const std::filesystem::path& from, const std::filesystem::path& to) {
    return std::rename(from.c_str(), to.c_str()) == 0 ? std::error_code() : last_error();
}

std::error_code PosixFileSystem::remove(const std::filesystem::path& file) {
    return ::unlink(file.c_str()) == 0 ? std::error_code() : last_error();
}

std::error_code PosixFileSystem::synchronise_directory(const std::filesystem::path& directory) {
    const Descriptor descriptor(directory, O_RDONLY | O_DIRECTORY);
    return descriptor.is_open() ? descriptor.synchronise() : last_error();
}

}  // namespace servobus::adapter
