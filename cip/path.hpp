// EPATH: the segments of a path, as read and as written (R-PTH-1 to R-PTH-9). Padded form only (R-PTH-3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"
#include "cip/wire.hpp"

namespace servobus::cip {

/// The path size of a request is one octet, in words.
inline constexpr std::size_t max_path_words = 255;

enum class LogicalType : std::uint8_t {
    class_id = 0,
    instance = 1,
    member = 2,
    connection_point = 3,
    attribute = 4,
    special = 5,
    service_id = 6,
    extended = 7,
};

/// Octets of a logical value on the wire.
enum class Width : std::uint8_t { bits8 = 0, bits16 = 1, bits32 = 2 };

struct LogicalSegment {
    LogicalType type{};
    std::uint32_t value = 0;
    Width width = Width::bits8;
    friend bool operator==(const LogicalSegment&, const LogicalSegment&) = default;
};

/// `34 04` or, with a serial number, `34 05` (R-PTH-5). Zero fields mean "any" (R-CON-11).
struct ElectronicKey {
    std::uint16_t vendor = 0;
    std::uint16_t device_type = 0;
    std::uint16_t product_code = 0;
    std::uint8_t major_revision = 0;  ///< bit 7: the device may emulate this revision
    std::uint8_t minor_revision = 0;
    std::optional<std::uint32_t> serial_number{};
    friend bool operator==(const ElectronicKey&, const ElectronicKey&) = default;
};

/// A hop: leave through `port` to `link_address` (R-PTH-6).
struct PortSegment {
    std::uint16_t port = 0;
    Bytes link_address;
    friend bool operator==(const PortSegment&, const PortSegment&) = default;
};

/// `43 05` production inhibit time and the like; `type` is the whole first octet, `data` without size octet (R-PTH-7).
struct NetworkSegment {
    std::uint8_t type = 0;
    Bytes data;
    friend bool operator==(const NetworkSegment&, const NetworkSegment&) = default;
};

/// A tag name; `extended` is the ANSI form `91 len` (R-PTH-9).
struct SymbolSegment {
    std::string name;
    bool extended = true;
    friend bool operator==(const SymbolSegment&, const SymbolSegment&) = default;
};

/// `80 nn`: configuration data, a whole number of words (R-PTH-8).
struct DataSegment {
    Bytes data;
    friend bool operator==(const DataSegment&, const DataSegment&) = default;
};

using Segment = std::variant<LogicalSegment, ElectronicKey, PortSegment, NetworkSegment, SymbolSegment, DataSegment>;

/// The segment in front. Fails with bad_segment on a reserved type or format, truncated on a cut one.
[[nodiscard]] Decoded<Segment> read_segment(Reader& reader);

struct Path {
    std::vector<Segment> segments;

    Path() = default;
    explicit Path(std::vector<Segment> list) : segments(std::move(list)) {}

    /// The shortest form of class / instance [/ attribute].
    [[nodiscard]] static Path to(std::uint32_t class_id, std::uint32_t instance);
    [[nodiscard]] static Path to(std::uint32_t class_id, std::uint32_t instance, std::uint32_t attribute);

    /// All of `bytes` as segments; fails as read_segment() does.
    [[nodiscard]] static Decoded<Path> parse(ByteView bytes);

    /// Appends the padded segments.
    void write(Writer& writer) const;
    [[nodiscard]] Bytes encode() const;
    /// Words of the encoded path.
    [[nodiscard]] std::size_t words() const;

    friend bool operator==(const Path&, const Path&) = default;
};

/// The narrowest logical segment for a value.
[[nodiscard]] LogicalSegment logical(LogicalType type, std::uint32_t value);

/// A path for people: `class 0x66, instance 1, attribute 0x24`.
[[nodiscard]] std::string describe(const Path& path);

}  // namespace servobus::cip
