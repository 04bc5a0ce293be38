#include "scanner/inflate.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>

namespace servobus::scanner {
namespace {

/// zlib's own number for "find out which of the two it is" (inflateInit2).
constexpr int either_format = 15 + 32;

constexpr std::size_t step_octets = std::size_t{64} * 1024;

bool is_gzip(cip::ByteView stream) { return stream.size() >= 2 && stream[0] == 0x1F && stream[1] == 0x8B; }

/// RFC 1950: method 8, and both octets together a multiple of 31.
bool is_zlib(cip::ByteView stream) {
    return stream.size() >= 2 && (stream[0] & 0x0F) == 8 && (stream[0] * 256 + stream[1]) % 31 == 0;
}

class Stream {
public:
    explicit Stream(cip::ByteView input) {
        state_.next_in = const_cast<Bytef*>(input.data());  // zlib only reads there
        state_.avail_in = static_cast<uInt>(input.size());
        ready_ = ::inflateInit2(&state_, either_format) == Z_OK;
    }
    ~Stream() {
        if (ready_) ::inflateEnd(&state_);
    }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    [[nodiscard]] bool ready() const { return ready_; }
    /// zlib's word, and how many octets came.
    int next(std::array<std::uint8_t, step_octets>& output, std::size_t& octets) {
        state_.next_out = output.data();
        state_.avail_out = static_cast<uInt>(output.size());
        const int word = ::inflate(&state_, Z_NO_FLUSH);
        octets = output.size() - state_.avail_out;
        return word;
    }

private:
    z_stream state_{};
    bool ready_ = false;
};

}  // namespace

std::string_view describe(InflateError error) {
    switch (error) {
        case InflateError::unknown_format:
            return "it is neither a zlib nor a gzip stream";
        case InflateError::damaged:
            return "the compressed stream is damaged, or ends too early";
        case InflateError::too_large:
            return "it becomes larger than any data sheet";
    }
    return "";
}

boost::system::result<cip::Bytes, InflateError> inflate(cip::ByteView stream, std::size_t max_octets) {
    if (!is_gzip(stream) && !is_zlib(stream)) return InflateError::unknown_format;
    if (stream.size() > std::numeric_limits<uInt>::max()) return InflateError::too_large;
    Stream input(stream);
    if (!input.ready()) return InflateError::damaged;
    cip::Bytes content;
    std::array<std::uint8_t, step_octets> part{};
    for (;;) {
        std::size_t octets = 0;
        const int word = input.next(part, octets);
        if (content.size() + octets > max_octets) return InflateError::too_large;
        content.insert(content.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(octets));
        if (word == Z_STREAM_END) return content;
        // Without any progress it would go on for ever.
        if (word != Z_OK || octets == 0) return InflateError::damaged;
    }
}

}  // namespace servobus::scanner
