#include "cip/file_transfer.hpp"

#include <numeric>

#include "cip/wire.hpp"

namespace servobus::cip::file {

Bytes UploadGrant::encode() const {
    Bytes data;
    Writer writer(data);
    writer.u32(file_octets);
    writer.u8(piece_octets);
    return data;
}

Decoded<UploadGrant> UploadGrant::parse(ByteView data) {
    Reader reader(data);
    UploadGrant grant;
    grant.file_octets = reader.u32();
    grant.piece_octets = reader.u8();
    if (!reader.ok()) return DecodeError::truncated;
    return grant;
}

Bytes UploadPiece::encode() const {
    Bytes octets;
    Writer writer(octets);
    writer.u8(number);
    writer.field(type);
    writer.bytes(data);
    if (checksum) writer.u16(*checksum);
    return octets;
}

Decoded<UploadPiece> UploadPiece::parse(ByteView data) {
    Reader reader(data);
    UploadPiece piece;
    piece.number = reader.u8();
    piece.type = reader.little<PieceType>();
    if (!reader.ok()) return DecodeError::truncated;
    if (piece.type > PieceType::first_and_last) return DecodeError::bad_value;
    constexpr std::size_t checksum_octets = 2;
    const std::size_t behind = ends_file(piece.type) ? checksum_octets : 0;
    if (reader.remaining() < behind) return DecodeError::truncated;
    const auto octets = reader.take(reader.remaining() - behind);
    piece.data.assign(octets.begin(), octets.end());
    if (behind > 0) piece.checksum = reader.u16();
    return piece;
}

std::uint16_t checksum(ByteView content) {
    const auto sum = std::accumulate(content.begin(), content.end(), std::uint32_t{0});
    return static_cast<std::uint16_t>(0U - sum);
}

}  // namespace servobus::cip::file
