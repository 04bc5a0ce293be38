// The few operations that bring a file into safety. Behind an interface, so that each of them can fail in a test.
#pragma once

#include <boost/system/result.hpp>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

namespace servobus::adapter {

class FileSystem {
public:
    virtual ~FileSystem() = default;

    /// The whole file; at most `limit` octets, one more is file_too_large.
    [[nodiscard]] virtual boost::system::result<std::string, std::error_code> read(const std::filesystem::path& file,
                                                                                   std::size_t limit) const = 0;
    [[nodiscard]] virtual bool exists(const std::filesystem::path& file) const = 0;
    /// Makes or empties the file, and writes into it. When this returns without an error the content survives power-off;
    /// with one, the file may have any part of it.
    [[nodiscard]] virtual std::error_code write(const std::filesystem::path& file, std::string_view octets) = 0;
    /// In one step, over what is there. It survives power-off once the directory is synchronised.
    [[nodiscard]] virtual std::error_code rename(const std::filesystem::path& from,
                                                 const std::filesystem::path& to) = 0;
    [[nodiscard]] virtual std::error_code remove(const std::filesystem::path& file) = 0;
    [[nodiscard]] virtual std::error_code synchronise_directory(const std::filesystem::path& directory) = 0;

protected:
    FileSystem() = default;
    FileSystem(const FileSystem&) = default;
    FileSystem& operator=(const FileSystem&) = default;
};

/// That of the operating system.
class PosixFileSystem final : public FileSystem {
public:
    [[nodiscard]] boost::system::result<std::string, std::error_code> read(const std::filesystem::path& file,
                                                                           std::size_t limit) const override;
    [[nodiscard]] bool exists(const std::filesystem::path& file) const override;
    [[nodiscard]] std::error_code write(const std::filesystem::path& file, std::string_view octets) override;
    [[nodiscard]] std::error_code rename(const std::filesystem::path& from, const std::filesystem::path& to) override;
    [[nodiscard]] std::error_code remove(const std::filesystem::path& file) override;
    [[nodiscard]] std::error_code synchronise_directory(const std::filesystem::path& directory) override;
};

}  // namespace servobus::adapter
