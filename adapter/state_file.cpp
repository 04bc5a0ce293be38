#include "adapter/state_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/crc.hpp>
#include <charconv>
#include <vector>

namespace servobus::adapter {
namespace {

constexpr std::string_view magic = "servobus-state";
constexpr int hexadecimal = 16;

std::uint32_t checksum(std::string_view octets) {
    boost::crc_32_type crc;
    crc.process_bytes(octets.data(), octets.size());
    return crc.checksum();
}

std::optional<std::uint32_t> number(std::string_view text, int base = 10) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::vector<std::string_view> words(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::size_t begin = 0; begin <= line.size();) {
        const auto end = std::min(line.find(' ', begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        begin = end + 1;
    }
    return words;
}

BadState damaged(std::string reason) { return {BadState::Kind::damaged, std::move(reason)}; }

std::string_view name(BadState::Kind kind) { return kind == BadState::Kind::newer ? "newer" : "damaged"; }

}  // namespace

std::string seal(std::string_view payload) {
    return fmt::format("{} {} {:08X} {}\n{}", magic, state_version, checksum(payload), payload.size(), payload);
}

// The version is looked at first: what another one looks like behind it is its own business.
std::variant<std::string, BadState> unseal(std::string_view octets) {
    const auto end = octets.find('\n');
    const auto head = words(octets.substr(0, end));
    if (end == std::string_view::npos || head.size() < 2 || head[0] != magic)
        return damaged("it is no state of a drive");
    const auto version = number(head[1]);
    if (!version || *version == 0) return damaged("its version is no number from 1 on");
    if (*version > state_version) {
        return BadState{BadState::Kind::newer,
                        fmt::format("it has version {}, and this program knows {}", *version, state_version)};
    }
    const auto payload = octets.substr(end + 1);
    const auto crc = head.size() == 4 ? number(head[2], hexadecimal) : std::nullopt;
    const auto size = head.size() == 4 ? number(head[3]) : std::nullopt;
    if (!crc || !size) return damaged("its first line is not whole");
    if (payload.size() != *size)
        return damaged(fmt::format("it should have {} octets and has {}", *size, payload.size()));
    if (checksum(payload) != *crc) return damaged("its checksum is wrong");
    return std::string(payload);
}

std::optional<std::variant<std::string, BadState>> StateFile::load() {
    auto octets = files_->read(path_, max_state_octets);
    if (!octets && octets.error() == std::errc::no_such_file_or_directory) return std::nullopt;
    if (!octets) return damaged(fmt::format("it cannot be read: {}", octets.error().message()));
    auto payload = unseal(*octets);
    if (std::holds_alternative<std::string>(payload)) stored_ = *std::move(octets);
    return payload;
}

std::error_code StateFile::store(std::string_view payload) {
    auto octets = seal(payload);
    if (octets.size() > max_state_octets) return std::make_error_code(std::errc::file_too_large);
    if (const auto error = replace(octets)) return error;
    stored_ = std::move(octets);
    return {};
}

std::error_code StateFile::replace(std::string_view octets) {
    auto fresh = path_;
    fresh += ".new";
    auto error = files_->write(fresh, octets);
    if (!error) error = files_->rename(fresh, path_);
    if (error) {
        static_cast<void>(files_->remove(fresh));
        return error;
    }
    error = files_->synchronise_directory(path_.parent_path());
    if (error) undo();
    return error;
}

// The new content is in its place, and nobody knows for how long: the old one goes back. If that fails too, there is a
// whole file at least.
void StateFile::undo() {
    auto again = path_;
    again += ".new";
    const bool had_one = stored_.has_value();
    if (had_one && !files_->write(again, *stored_)) static_cast<void>(files_->rename(again, path_));
    if (!had_one) static_cast<void>(files_->remove(path_));
    static_cast<void>(files_->synchronise_directory(path_.parent_path()));
}

std::variant<std::filesystem::path, std::error_code> StateFile::keep_aside(BadState::Kind kind) {
    std::filesystem::path aside;
    for (int i = 1; i <= max_kept_aside; ++i) {
        aside = path_;
        aside += fmt::format(".{}-{}", name(kind), i);
        if (!files_->exists(aside)) break;
    }
    if (const auto error = files_->rename(path_, aside)) return error;
    static_cast<void>(files_->synchronise_directory(path_.parent_path()));
    stored_.reset();
    return aside;
}

}  // namespace servobus::adapter
