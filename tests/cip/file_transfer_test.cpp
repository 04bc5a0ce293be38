// The messages of an upload (R-FIL-4, R-FIL-5) and its checksum (R-FIL-6).
#include "cip/file_transfer.hpp"

#include <gtest/gtest.h>

#include "tests/support/octets.hpp"

namespace servobus::cip::file {
namespace {

using test::error_of;
using test::hex;
using test::octets;

TEST(FileTransfer, R_FIL_4_Grant) {
    const UploadGrant grant{0x00012345, 0xFE};
    EXPECT_EQ(hex(grant.encode()), "45 23 01 00 FE");
    EXPECT_EQ(UploadGrant::parse(octets("45 23 01 00 FE")).value(), grant);
    EXPECT_EQ(error_of(UploadGrant::parse(octets("45 23 01 00"))), DecodeError::truncated);
}

TEST(FileTransfer, R_FIL_5_Pieces) {
    const UploadPiece middle{.number = 7, .type = PieceType::middle, .data = octets("01 02 03")};
    EXPECT_EQ(hex(middle.encode()), "07 01 01 02 03");
    EXPECT_EQ(UploadPiece::parse(octets("07 01 01 02 03")).value(), middle);
    // The checksum is behind the data of a piece that ends the file, and of no other.
    const UploadPiece last{.number = 8, .type = PieceType::last, .data = octets("01 02"), .checksum = 0xFFFD};
    EXPECT_EQ(hex(last.encode()), "08 02 01 02 FD FF");
    EXPECT_EQ(UploadPiece::parse(octets("08 02 01 02 FD FF")).value(), last);
    EXPECT_EQ(UploadPiece::parse(octets("00 04 FF FF")).value().checksum, 0xFFFF);
    EXPECT_TRUE(UploadPiece::parse(octets("00 04 FF FF")).value().data.empty());
    EXPECT_EQ(UploadPiece::parse(octets("05 03")).value().type, PieceType::abort);
}

TEST(FileTransfer, BrokenPieces) {
    EXPECT_EQ(error_of(UploadPiece::parse({})), DecodeError::truncated);
    EXPECT_EQ(error_of(UploadPiece::parse(octets("00"))), DecodeError::truncated);
    EXPECT_EQ(error_of(UploadPiece::parse(octets("00 05 01"))), DecodeError::bad_value);
    EXPECT_EQ(error_of(UploadPiece::parse(octets("00 02 FF"))), DecodeError::truncated) << "half a checksum";
}

TEST(FileTransfer, R_FIL_6_Checksum) {
    EXPECT_EQ(checksum(octets("01 02 03")), 0xFFFA);
    EXPECT_EQ(checksum({}), 0);
    // 0x0101 times 0xFF is 0xFFFF.
    EXPECT_EQ(checksum(Bytes(0x101, 0xFF)), 1);
    EXPECT_EQ(checksum(Bytes(0x100 * 0x101, 0xFF)), 0x100);
}

}  // namespace
}  // namespace servobus::cip::file
