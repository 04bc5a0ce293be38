// A file system in memory whose power can go: what was not synchronised is lost, or half there, as the test wants it.
//
//     FragileFiles files;
//     files.fail_at(2, std::make_error_code(std::errc::no_space_on_device));   // the second operation that changes something
//     files.die_at(3);                                                         // nothing happens from the third one on
//     files.cut_power(FragileFiles::Renames::lost);
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <system_error>

#include "adapter/file_system.hpp"

namespace servobus::test {

class FragileFiles final : public adapter::FileSystem {
public:
    /// What becomes of names that have been changed and not synchronised.
    enum class Renames : bool { lost, kept };

    /// Operation `number`, from 1, of those that change something fails with this; half of what it writes is there.
    void fail_at(std::size_t number, std::error_code error) {
        failing_ = number;
        error_ = error;
    }
    /// Operation `number` is carried out by half, and none after it: the process has gone.
    void die_at(std::size_t number) { dying_ = number; }
    [[nodiscard]] bool is_dead() const { return dying_ != 0 && done_ >= dying_; }
    /// Nothing fails from now on.
    void heal() { failing_ = dying_ = done_ = 0; }

    /// Power off and on: what is there is what was synchronised, and of the rest what `renames` says.
    void cut_power(Renames renames) {
        if (renames == Renames::lost) now_ = durable_;
        durable_ = now_;
        heal();
    }
    void put(const std::filesystem::path& file, const std::string& octets) { now_[file] = durable_[file] = octets; }
    [[nodiscard]] const std::map<std::filesystem::path, std::string>& files() const { return now_; }

    [[nodiscard]] boost::system::result<std::string, std::error_code> read(const std::filesystem::path& file,
                                                                           std::size_t limit) const override {
        const auto found = now_.find(file);
        if (found == now_.end()) return std::make_error_code(std::errc::no_such_file_or_directory);
        if (found->second.size() > limit) return std::make_error_code(std::errc::file_too_large);
        return found->second;
    }
    [[nodiscard]] bool exists(const std::filesystem::path& file) const override { return now_.contains(file); }
    [[nodiscard]] std::error_code write(const std::filesystem::path& file, std::string_view octets) override {
        const auto outcome = begin();
        if (outcome.lost) return dead();
        now_[file] = octets.substr(0, outcome.whole ? octets.size() : octets.size() / 2);
        if (outcome.whole && durable_.contains(file)) durable_[file] = now_[file];
        return outcome.error;
    }
    [[nodiscard]] std::error_code rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
        const auto outcome = begin();
        if (outcome.lost) return dead();
        if (outcome.error) return outcome.error;
        const auto moved = now_.extract(from);
        if (moved.empty()) return std::make_error_code(std::errc::no_such_file_or_directory);
        now_[to] = moved.mapped();
        return {};
    }
    [[nodiscard]] std::error_code remove(const std::filesystem::path& file) override {
        const auto outcome = begin();
        if (outcome.lost) return dead();
        if (outcome.error) return outcome.error;
        return now_.erase(file) > 0 ? std::error_code() : std::make_error_code(std::errc::no_such_file_or_directory);
    }
    [[nodiscard]] std::error_code synchronise_directory(const std::filesystem::path&) override {
        const auto outcome = begin();
        if (outcome.lost) return dead();
        if (outcome.whole) durable_ = now_;
        return outcome.error;
    }

private:
    struct Outcome {
        bool lost = false;  ///< nothing of it happens
        bool whole = true;  ///< all of it happens
        std::error_code error{};
    };
    Outcome begin() {
        ++done_;
        if (dying_ != 0 && done_ > dying_) return {.lost = true, .whole = false, .error = dead()};
        if (done_ == failing_) return {.whole = false, .error = error_};
        if (done_ == dying_) return {.whole = false};
        return {};
    }
    static std::error_code dead() { return std::make_error_code(std::errc::owner_dead); }

    std::map<std::filesystem::path, std::string> now_;
    std::map<std::filesystem::path, std::string> durable_;
    std::size_t done_ = 0;
    std::size_t failing_ = 0;
    std::size_t dying_ = 0;
    std::error_code error_{};
};

}  // namespace servobus::test
