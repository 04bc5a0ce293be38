#include "adapter/firmware_unit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

namespace servobus::adapter {
namespace {

using Nanoseconds = std::chrono::nanoseconds;

constexpr std::int64_t rate = flash_octets_per_second;
constexpr std::int64_t second = Nanoseconds(std::chrono::seconds(1)).count();

// The first time at which so many octets are written.
Nanoseconds time_to_write(std::size_t octets) {
    return Nanoseconds((second * static_cast<std::int64_t>(octets) + rate - 1) / rate);
}

std::size_t octets_written(Nanoseconds time) {
    return static_cast<std::size_t>(time.count() / second * rate + time.count() % second * rate / second);
}

}  // namespace

FirmwareUnit::FirmwareUnit(std::uint16_t product_code, const Release& release)
    : product_code_(product_code), flash_{.release = release}, running_(release) {}

std::optional<std::string> FirmwareUnit::check(const FlashImage& image) const {
    if (image.fits(product_code_)) return std::nullopt;
    std::string codes;
    for (const auto code : image.product_codes) codes += fmt::format("{}0x{:04X}", codes.empty() ? "" : ", ", code);
    return fmt::format("it is for product code {}, and this drive has 0x{:04X}", codes, product_code_);
}

// An image without a revision of its own keeps that of the release before it.
FirmwareUnit::Release FirmwareUnit::release_of(const FlashImage& image) const {
    return {image.version, image.revision.value_or(flash_.release.revision)};
}

std::optional<std::string> FirmwareUnit::download(const FlashImage& image, enip::Time now) {
    advance(now);
    if (writing_) return "another download is in progress";
    if (auto wrong = check(image)) return wrong;
    flash_ = {.release = release_of(image), .bit_stream = false, .firmware = false};
    writing_ = Writing{.begin = now,
                       .bit_stream_octets = image.bit_stream_octets,
                       .octets = image.bit_stream_octets + image.firmware_octets};
    return std::nullopt;
}

std::optional<std::string> FirmwareUnit::install(const FlashImage& image) {
    if (auto wrong = check(image)) return wrong;
    restore({.release = release_of(image)});
    return std::nullopt;
}

void FirmwareUnit::advance(enip::Time now) {
    if (!writing_) return;
    writing_->written = std::min(writing_->octets, octets_written(now - writing_->begin));
    flash_.bit_stream = writing_->written >= writing_->bit_stream_octets;
    flash_.firmware = writing_->written == writing_->octets;
    if (flash_.firmware) writing_.reset();
}

std::optional<enip::Time> FirmwareUnit::next_deadline() const {
    if (!writing_) return std::nullopt;
    return writing_->begin + time_to_write(flash_.bit_stream ? writing_->octets : writing_->bit_stream_octets);
}

void FirmwareUnit::power_cycle() { restore(Flash(flash_)); }

void FirmwareUnit::restore(const Flash& flash) {
    flash_ = flash;
    writing_.reset();
    running_ = flash_.is_whole() ? std::optional(flash_.release) : std::nullopt;
}

std::optional<FirmwareUnit::Release> FirmwareUnit::pending() const {
    if (!flash_.is_whole() || running_ == flash_.release) return std::nullopt;
    return flash_.release;
}

std::optional<FirmwareUnit::Download> FirmwareUnit::download_in_progress() const {
    if (!writing_) return std::nullopt;
    return Download{flash_.release, writing_->written, writing_->octets};
}

}  // namespace servobus::adapter
