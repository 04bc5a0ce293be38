// What both ends of an upload from the File object (0x37) have in common (R-FIL).
#pragma once

#include <cstdint>
#include <optional>

#include "cip/bytes.hpp"
#include "cip/decode_error.hpp"

namespace servobus::cip::file {

inline constexpr std::uint16_t class_id = 0x37;
inline constexpr std::uint32_t eds_instance = 0xC8;
inline constexpr std::uint32_t icon_instance = 0xC9;

inline constexpr std::uint8_t initiate_upload = 0x4B;
inline constexpr std::uint8_t upload_transfer = 0x4F;

/// The class attribute that lists the instances (R-FIL-3).
inline constexpr std::uint32_t directory_attribute = 32;

/// The instance attributes (R-FIL-2).
enum class Attribute : std::uint8_t {
    state = 1,
    instance_name = 2,
    format_version = 3,
    file_name = 4,
    revision = 5,
    size = 6,
    checksum = 7,
    invocation = 8,
    save_parameters = 9,
    access_rule = 10,
    encoding = 11,
};

enum class State : std::uint8_t {
    nonexistent = 0,
    empty = 1,
    loaded = 2,
    upload_initiated = 3,
    download_initiated = 4,
    uploading = 5,
    downloading = 6,
    storing = 7,
};

enum class Encoding : std::uint8_t { binary = 0, compressed = 1, ascii_text = 11 };

/// What a piece is (R-FIL-5).
enum class PieceType : std::uint8_t { first = 0, middle = 1, last = 2, abort = 3, first_and_last = 4 };
[[nodiscard]] constexpr bool ends_file(PieceType type) {
    return type == PieceType::last || type == PieceType::first_and_last;
}

/// Extended words of status 0x20 (R-FIL-7).
inline constexpr std::uint16_t wrong_transfer_number = 0x0006;
inline constexpr std::uint16_t zero_transfer_size = 0x0008;

/// The data of a reply to Initiate_Upload (R-FIL-4).
struct UploadGrant {
    std::uint32_t file_octets = 0;
    std::uint8_t piece_octets = 0;  ///< of every piece but the last

    [[nodiscard]] Bytes encode() const;
    [[nodiscard]] static Decoded<UploadGrant> parse(ByteView data);
    friend bool operator==(const UploadGrant&, const UploadGrant&) = default;
};

/// The data of a reply to Upload_Transfer (R-FIL-5).
struct UploadPiece {
    std::uint8_t number = 0;
    PieceType type = PieceType::first;
    Bytes data{};
    std::optional<std::uint16_t> checksum{};  ///< behind the data of a piece that ends the file

    [[nodiscard]] Bytes encode() const;
    /// bad_value for a type that is none.
    [[nodiscard]] static Decoded<UploadPiece> parse(ByteView data);
    friend bool operator==(const UploadPiece&, const UploadPiece&) = default;
};

/// The two's complement of the sum of all octets, modulo 65536 (R-FIL-6).
[[nodiscard]] std::uint16_t checksum(ByteView content);

}  // namespace servobus::cip::file
