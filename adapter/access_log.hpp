// What the log tells of those who change something, are refused, or are not to be here at all: each a line, and a flood
// of them a few lines and a count.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "adapter/log_line.hpp"
#include "cip/gate.hpp"
#include "cip/object.hpp"
#include "drive/device.hpp"

namespace servobus::adapter {

/// Lines of one kind in one second; further ones are counted, and the count is a line of its own.
inline constexpr std::size_t access_lines_per_second = 20;
/// Octets of a value that a line shows.
inline constexpr std::size_t shown_octets = 32;

class AccessLog {
public:
    /// Each has a limit of its own, so that none can hide another.
    enum class Kind : std::uint8_t { change, connection, refusal, stranger };

    void listen(LineSink sink) { sink_ = std::move(sink); }

    /// `make` is called, and the line written, when somebody wants it and the limit is not reached. `now` never goes
    /// back.
    template <class MakeLine>
    void note(Kind kind, cip::Time now, MakeLine make) {
        if (!sink_.wants(level_of(kind)) || !has_room(kind, now)) return;
        write(kind, make());
    }
    /// Tells the counts whose second is over.
    void on_timer(cip::Time now);
    [[nodiscard]] std::optional<cip::Time> next_deadline() const;
    /// Tells the counts that are left; nothing is lost without a word.
    void flush();

    [[nodiscard]] static LogLevel level_of(Kind kind);

private:
    struct Window {
        std::optional<cip::Time> end{};
        std::size_t lines = 0;
        std::uint64_t suppressed = 0;
    };

    [[nodiscard]] Window& window(Kind kind) { return windows_[static_cast<std::size_t>(kind)]; }
    [[nodiscard]] bool has_room(Kind kind, cip::Time now);
    void write(Kind kind, LogLine line) const;
    void close(Kind kind);

    LineSink sink_;
    std::array<Window, 4> windows_{};
};

/// How an access ended: who, on which way, what, and with which result. `session` is the handle, 0 when there is none;
/// `why` is told beside the status when it is not empty.
[[nodiscard]] LogLine access_line(const cip::Access& access, const cip::Status& result, std::uint32_t session,
                                  const drive::Device& device, std::string_view why);

}  // namespace servobus::adapter
