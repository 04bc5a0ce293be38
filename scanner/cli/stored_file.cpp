#include "scanner/cli/stored_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace servobus::scanner::cli {
namespace {

constexpr std::size_t longest_name = 100;

/// A file beside the one that it is to become; gone with this object, unless it has become that.
class Draft {
public:
    explicit Draft(const std::filesystem::path& path) : name_(path.string() + ".XXXXXX") {
        descriptor_ = ::mkstemp(name_.data());
    }
    ~Draft() {
        if (descriptor_ < 0) return;
        ::close(descriptor_);
        if (!name_.empty()) ::unlink(name_.c_str());
    }
    Draft(const Draft&) = delete;
    Draft& operator=(const Draft&) = delete;

    [[nodiscard]] bool ready() const { return descriptor_ >= 0; }

    bool write(cip::ByteView content) {
        while (!content.empty()) {
            const auto written = ::write(descriptor_, content.data(), content.size());
            if (written < 0 && errno == EINTR) continue;
            if (written <= 0) return false;
            content = content.subspan(static_cast<std::size_t>(written));
        }
        // mkstemp is for secrets; this is a file as any other.
        const auto mask = ::umask(0);
        ::umask(mask);
        return ::fchmod(descriptor_, 0666 & ~mask) == 0 && ::fsync(descriptor_) == 0;
    }

    bool become(const std::filesystem::path& path, bool overwrite) {
        if (!rename(path, overwrite)) return false;
        name_.clear();
        return true;
    }

private:
    bool rename(const std::filesystem::path& path, bool overwrite) const {
        if (overwrite) return ::rename(name_.c_str(), path.c_str()) == 0;
        if (::renameat2(AT_FDCWD, name_.c_str(), AT_FDCWD, path.c_str(), RENAME_NOREPLACE) == 0) return true;
        // Some file systems do not know that; for them it is looked before.
        if (errno != EINVAL && errno != ENOSYS) return false;
        std::error_code unknown;
        if (std::filesystem::exists(path, unknown)) {
            errno = EEXIST;
            return false;
        }
        return ::rename(name_.c_str(), path.c_str()) == 0;
    }

    std::string name_;
    int descriptor_ = -1;
};

Mistake not_written(const std::filesystem::path& path) {
    return {fmt::format("'{}' cannot be written: {}", path.string(), std::strerror(errno))};
}

}  // namespace

std::optional<Mistake> store_file(const std::filesystem::path& path, cip::ByteView content, bool overwrite) {
    Draft draft(path);
    if (!draft.ready() || !draft.write(content)) return not_written(path);
    if (draft.become(path, overwrite)) return std::nullopt;
    if (errno == EEXIST) return Mistake{fmt::format("'{}' is there already; --force overwrites it", path.string())};
    return not_written(path);
}

std::string safe_file_name(std::string_view name, const std::string& otherwise) {
    const auto cut = name.find_last_of("/\\:");
    if (cut != std::string_view::npos) name.remove_prefix(cut + 1);
    std::string safe;
    for (const char c : name) {
        const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("._-+", c) != nullptr;
        safe += plain && c != '\0' ? c : '_';
    }
    const auto begin = safe.find_first_not_of("._-");
    if (begin == std::string::npos) return otherwise;
    safe.erase(0, begin);
    if (safe.size() <= longest_name) return safe;
    // Its kind is at the end.
    const auto dot = safe.rfind('.');
    const auto kind = dot != std::string::npos && safe.size() - dot < 10 ? safe.substr(dot) : std::string();
    return safe.substr(0, longest_name - kind.size()) + kind;
}

}  // namespace servobus::scanner::cli
