// The firmware of the bus module: what its flash holds, what runs, and how a new one comes in (000 §1.1, §1.3). No clock
// and no file; the bus knows nothing of it.
//
// A download writes in place, first the bit stream, then the firmware, while the old firmware goes on from memory. What
// it has written runs after the next power-on. A power cut in between leaves a part that is not whole, and the module
// comes up in factory mode, in which it does nothing but wait for a download.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "adapter/flash_image.hpp"
#include "enip/time.hpp"

namespace servobus::adapter {

/// How fast a flash is written.
inline constexpr std::size_t flash_octets_per_second = std::size_t{64} * 1024;

class FirmwareUnit {
public:
    /// A firmware, and the revision that Identity has with it.
    struct Release {
        FirmwareVersion version{};
        Revision revision{};
        friend bool operator==(const Release&, const Release&) = default;
    };
    /// What the flash holds, and what is left of the unit when the power goes.
    struct Flash {
        Release release{};  ///< that was written last; it runs when both parts are whole
        bool bit_stream = true;
        bool firmware = true;
        [[nodiscard]] bool is_whole() const { return bit_stream && firmware; }
        friend bool operator==(const Flash&, const Flash&) = default;
    };
    struct Download {
        Release release{};
        std::size_t written = 0;
        std::size_t octets = 0;
    };

    /// With this release in its flash, and running.
    FirmwareUnit(std::uint16_t product_code, const Release& release);

    /// Begins to write an image. Why not, a clause, when one is being written already or this one is for other drives;
    /// then nothing has changed.
    [[nodiscard]] std::optional<std::string> download(const FlashImage& image, enip::Time now);
    /// An image as if it had been there at the last power-on; what runs is what it holds. Why not, as above.
    [[nodiscard]] std::optional<std::string> install(const FlashImage& image);
    /// Writes what there has been time for. To be called before anything else at a time.
    void advance(enip::Time now);
    /// When bit stream or firmware is whole.
    [[nodiscard]] std::optional<enip::Time> next_deadline() const;
    /// Power off and on: what the flash holds runs, or nothing does.
    void power_cycle();

    [[nodiscard]] bool is_downloading() const { return writing_.has_value(); }
    [[nodiscard]] bool is_in_factory_mode() const { return !running_; }
    [[nodiscard]] bool has_bit_stream() const { return flash_.bit_stream; }
    /// Nullopt in factory mode.
    [[nodiscard]] const std::optional<Release>& running() const { return running_; }
    /// What the next power-on starts, when that is something else than what runs.
    [[nodiscard]] std::optional<Release> pending() const;
    /// The download in progress, as of the last advance().
    [[nodiscard]] std::optional<Download> download_in_progress() const;

    /// To be kept over the end of the program: what a power cut now would leave.
    [[nodiscard]] const Flash& snapshot() const { return flash_; }
    /// Powers up with this flash.
    void restore(const Flash& flash);

private:
    struct Writing {
        enip::Time begin;
        std::size_t bit_stream_octets = 0;
        std::size_t octets = 0;
        std::size_t written = 0;
    };
    [[nodiscard]] std::optional<std::string> check(const FlashImage& image) const;
    [[nodiscard]] Release release_of(const FlashImage& image) const;

    std::uint16_t product_code_;
    Flash flash_;
    std::optional<Release> running_;
    std::optional<Writing> writing_{};
};

}  // namespace servobus::adapter
