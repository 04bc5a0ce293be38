// Uploads without I/O: every answer that a device may give, right and wrong (R-FIL-4 to R-FIL-9).
#include "scanner/file_upload.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cip/wire.hpp"
#include "scanner/inflate.hpp"
#include "tests/support/octets.hpp"

namespace servobus::scanner {
namespace {

using cip::GeneralStatus;
using cip::Request;
using cip::Response;
using servobus::test::hex;
using servobus::test::octets;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Response answer(const Request& request, std::string_view data) { return {request.service, {}, octets(data)}; }
Response refusal(const Request& request, cip::Status status) { return {request.service, std::move(status), {}}; }

/// An upload whose attributes have been refused: a device needs none of them.
FileUpload without_attributes(FileUploadOptions options = {}) {
    FileUpload upload(options);
    while (upload.request().service == 0x0E) {
        upload.on_response(refusal(upload.request(), GeneralStatus::attribute_not_supported));
    }
    return upload;
}

/// One that is to get `size` octets in pieces of `piece`.
FileUpload granted(std::uint32_t size, std::uint8_t piece, FileUploadOptions options = {}) {
    auto upload = without_attributes(options);
    upload.on_response({0x4B, {}, cip::file::UploadGrant{size, piece}.encode()});
    return upload;
}

/// Answers one request after the other with these pieces.
void feed(FileUpload& upload, const std::vector<std::string>& pieces) {
    for (const auto& piece : pieces) {
        ASSERT_FALSE(upload.done()) << "before " << piece;
        upload.on_response(answer(upload.request(), piece));
    }
}

std::optional<UploadError> error_of(const FileUpload& upload) {
    if (!upload.failure()) return std::nullopt;
    return upload.failure()->error;
}

TEST(FileUpload, AsksForAttributesThenTheFile) {
    FileUpload upload;
    const std::vector<std::pair<std::string, std::string>> exchange{
        {"0E 03 20 37 24 C8 30 01", "02"},          {"0E 03 20 37 24 C8 30 04", "01 656E67 DA 0400 05 612E656473"},
        {"0E 03 20 37 24 C8 30 05", "02 03"},       {"0E 03 20 37 24 C8 30 06", "05 00 00 00"},
        {"0E 03 20 37 24 C8 30 07", "F1 FF"},       {"0E 03 20 37 24 C8 30 0B", "00"},
        {"4B 02 20 37 24 C8 FF", "05 00 00 00 02"}, {"4F 02 20 37 24 C8 00", "00 00 01 02"},
        {"4F 02 20 37 24 C8 01", "01 01 03 04"},    {"4F 02 20 37 24 C8 02", "02 02 05 F1 FF"},
    };
    for (const auto& [request, reply] : exchange) {
        ASSERT_FALSE(upload.done());
        EXPECT_EQ(hex(upload.request().encode()), hex(request));
        upload.on_response(answer(upload.request(), reply));
    }
    ASSERT_TRUE(upload.done());
    ASSERT_FALSE(upload.failure());
    const auto& file = upload.file();
    EXPECT_EQ(hex(file.content), "01 02 03 04 05");
    EXPECT_EQ(file.attributes, (FileAttributes{.state = cip::file::State::loaded,
                                               .name = "a.eds",
                                               .revision = std::pair<std::uint8_t, std::uint8_t>(2, 3),
                                               .octets = 5,
                                               .checksum = 0xFFF1,
                                               .encoding = cip::file::Encoding::binary}));
    EXPECT_EQ(file.pieces, 3U);
    EXPECT_EQ(file.repeats, 0U);
    EXPECT_THAT(file.oddities, IsEmpty());
}

TEST(FileUpload, NeedsNoAttribute) {
    auto upload = granted(2, 255, {.instance = 0xC9});
    EXPECT_EQ(hex(upload.request().encode()), hex("4F 02 20 37 24 C9 00"));
    feed(upload, {"00 04 01 02 FD FF"});
    EXPECT_EQ(error_of(upload), std::nullopt);
    EXPECT_EQ(hex(upload.file().content), "01 02");
    EXPECT_EQ(upload.file().attributes, FileAttributes{});
}

TEST(FileUpload, BrokenAttributesAreAsGoodAsNone) {
    FileUpload upload;
    while (upload.request().service == 0x0E) upload.on_response(answer(upload.request(), ""));
    EXPECT_EQ(upload.file().attributes, FileAttributes{});
    EXPECT_FALSE(upload.done());
}

TEST(FileUpload, AnEmptyLastPieceIsFine) {
    auto upload = granted(4, 2);
    feed(upload, {"00 00 01 02", "01 01 03 04", "02 02 F6 FF"});
    EXPECT_EQ(error_of(upload), std::nullopt);
    EXPECT_EQ(hex(upload.file().content), "01 02 03 04");
}

TEST(FileUpload, NumbersGoRound) {
    for (const bool says_first : {false, true}) {
        auto upload = granted(301, 1);
        unsigned sum = 0;
        for (unsigned i = 0; i < 300; ++i) {
            ASSERT_FALSE(upload.done()) << i;
            EXPECT_EQ(upload.request().data, cip::Bytes{static_cast<std::uint8_t>(i)});
            const auto type = i == 0 || (says_first && i == 256) ? 0 : 1;
            upload.on_response(answer(upload.request(), fmt::format("{:02X} {:02X} 07", i & 0xFF, type)));
            sum += 7;
        }
        sum += 9;
        const auto checksum = static_cast<std::uint16_t>(0x10000 - sum);
        feed(upload, {fmt::format("2C 02 09 {:02X} {:02X}", checksum & 0xFF, checksum >> 8)});
        EXPECT_EQ(error_of(upload), std::nullopt);
        EXPECT_EQ(upload.file().content.size(), 301U);
        if (says_first) {
            EXPECT_THAT(upload.file().oddities, ElementsAre(UploadOddity::first_again));
        } else {
            EXPECT_THAT(upload.file().oddities, IsEmpty());
        }
    }
}

TEST(FileUpload, R_FIL_9_PiecesThatAreWrong) {
    struct Case {
        std::vector<std::string> pieces;
        UploadError error;
    };
    const std::vector<Case> cases{
        // Numbers.
        {{"01 00 01 02 03 04"}, UploadError::wrong_number},
        {{"00 00 01 02 03 04", "00 01 05 06 07 08"}, UploadError::wrong_number},
        {{"00 00 01 02 03 04", "02 01 05 06 07 08"}, UploadError::wrong_number},
        // Order.
        {{"00 01 01 02 03 04"}, UploadError::wrong_order},
        {{"00 02 01 02 03 04 05 06 07 08 09 0A C9 FF"}, UploadError::wrong_order},
        {{"00 00 01 02 03 04", "01 00 05 06 07 08"}, UploadError::wrong_order},
        {{"00 00 01 02 03 04", "01 04 05 06 07 08 00 00"}, UploadError::wrong_order},
        // Sizes: ten octets in pieces of four.
        {{"00 00 01 02 03"}, UploadError::short_piece},
        {{"00 00"}, UploadError::short_piece},
        {{"00 00 01 02 03 04", "01 01 05 06"}, UploadError::short_piece},
        {{"00 00 01 02 03 04 05"}, UploadError::long_piece},
        {{"00 04 01 02 03 04 05 06 07 08 09 0A C9 FF"}, UploadError::long_piece},
        {{"00 00 01 02 03 04", "01 01 05 06 07 08", "02 01 09 0A 0B 0C"}, UploadError::too_many_octets},
        {{"00 00 01 02 03 04", "01 01 05 06 07 08", "02 02 09 0A 0B 00 00"}, UploadError::too_many_octets},
        {{"00 04 01 02 03 F0 FF"}, UploadError::too_few_octets},
        {{"00 00 01 02 03 04", "01 02 05 06 07 08 DC FF"}, UploadError::too_few_octets},
        {{"00 00 01 02 03 04", "01 01 05 06 07 08", "02 02 09 C8 FF"}, UploadError::too_few_octets},
        // The end.
        {{"00 00 01 02 03 04", "01 01 05 06 07 08", "02 02 09 0A C8 FF"}, UploadError::wrong_checksum},
        {{"00 00 01 02 03 04", "01 01 05 06 07 08", "02 02 09 0A FF C9"}, UploadError::wrong_checksum},
        {{"00 03"}, UploadError::aborted},
        {{"00 00 01 02 03 04", "01 03"}, UploadError::aborted},
        // No pieces at all.
        {{""}, UploadError::malformed_reply},
        {{"00"}, UploadError::malformed_reply},
        {{"00 05 01 02 03 04"}, UploadError::malformed_reply},
        {{"00 00 01 02 03 04", "01 02 05"}, UploadError::malformed_reply},
    };
    for (const auto& each : cases) {
        auto upload = granted(10, 4);
        feed(upload, each.pieces);
        EXPECT_TRUE(upload.done()) << each.pieces.back();
        EXPECT_EQ(error_of(upload), each.error) << each.pieces.back();
        ASSERT_TRUE(upload.failure());
        EXPECT_THAT(describe(*upload.failure()), testing::Not(IsEmpty()));
    }
}

TEST(FileUpload, SaysWhatWasWrong) {
    auto upload = granted(4, 4);
    feed(upload, {"00 04 01 02 03 04 00 00"});
    EXPECT_EQ(describe(*upload.failure()), "the checksum is 0x0000, and 0xFFF6 fits the octets");
    auto early = granted(10, 4);
    feed(early, {"00 00 01 02 03 04", "01 02 05 06 07 08 DC FF"});
    EXPECT_EQ(describe(*early.failure()), "the file ends after 4 of 10 octets");
}

TEST(FileUpload, GrantsThatAreWrong) {
    const auto after = [](std::string_view grant, FileUploadOptions options = {}) {
        auto upload = without_attributes(options);
        upload.on_response(answer(upload.request(), grant));
        return error_of(upload);
    };
    EXPECT_EQ(after("0A 00 00 00"), UploadError::malformed_reply);
    EXPECT_EQ(after("0A 00 00 00 00"), UploadError::bad_piece_size);
    EXPECT_EQ(after("0A 00 00 00 21", {.piece_octets = 0x20}), UploadError::bad_piece_size);
    EXPECT_EQ(after("0A 00 00 00 20", {.piece_octets = 0x20}), std::nullopt);
    EXPECT_EQ(after("FF FF FF FF 20"), UploadError::too_large);
    EXPECT_EQ(after("00 00 00 01 20"), std::nullopt) << "16 MiB are the limit";
    EXPECT_EQ(after("01 00 00 01 20"), UploadError::too_large);
    EXPECT_EQ(after("0A 00 00 00 20", {.max_octets = 10}), std::nullopt);
    EXPECT_EQ(after("0B 00 00 00 20", {.max_octets = 10}), UploadError::too_large);
}

TEST(FileUpload, RefusalsBeforeIt) {
    const auto after = [](cip::Status status) {
        auto upload = without_attributes();
        upload.on_response(refusal(upload.request(), std::move(status)));
        return error_of(upload);
    };
    EXPECT_EQ(after(GeneralStatus::path_destination_unknown), UploadError::no_file_object);
    EXPECT_EQ(after(GeneralStatus::object_does_not_exist), UploadError::no_file);
    EXPECT_EQ(after(GeneralStatus::object_state_conflict), UploadError::no_file);
    EXPECT_EQ(after({GeneralStatus::object_state_conflict, {1}}), UploadError::no_file);
    EXPECT_EQ(after({GeneralStatus::object_state_conflict, {3}}), UploadError::busy);
    EXPECT_EQ(after({GeneralStatus::object_state_conflict, {5}}), UploadError::busy);
    EXPECT_EQ(after(GeneralStatus::service_not_supported), UploadError::refused);
    FileUpload upload;
    upload.on_response(refusal(upload.request(), GeneralStatus::path_destination_unknown));
    EXPECT_EQ(error_of(upload), UploadError::no_file_object) << "there is no need to ask on";
}

TEST(FileUpload, RefusalsInTheMiddle) {
    auto upload = granted(10, 4);
    feed(upload, {"00 00 01 02 03 04"});
    upload.on_response(refusal(upload.request(), {GeneralStatus::invalid_parameter, {6}}));
    EXPECT_EQ(error_of(upload), UploadError::refused);
    EXPECT_THAT(describe(*upload.failure()), HasSubstr("after 4 of 10 octets: 0x20"));
    auto other = granted(10, 4);
    other.on_response(refusal(other.request(), {GeneralStatus::object_state_conflict, {3}}));
    EXPECT_EQ(error_of(other), UploadError::busy);
}

TEST(FileUpload, ALostPieceIsAskedForAgain) {
    auto upload = granted(6, 4);
    feed(upload, {"00 00 01 02 03 04"});
    const auto request = upload.request();
    upload.on_silence();
    EXPECT_EQ(upload.request(), request);
    upload.on_silence();
    EXPECT_EQ(upload.request(), request);
    feed(upload, {"01 02 05 06 EB FF"});
    EXPECT_EQ(error_of(upload), std::nullopt);
    EXPECT_EQ(upload.file().repeats, 2U);
}

TEST(FileUpload, SilenceIsNotAskedForEver) {
    auto upload = granted(6, 4, {.tries = 3});
    for (int i = 0; i < 2; ++i) upload.on_silence();
    EXPECT_FALSE(upload.done());
    upload.on_silence();
    EXPECT_EQ(error_of(upload), UploadError::no_answer);
    FileUpload first({.tries = 1});
    first.on_silence();
    EXPECT_EQ(error_of(first), UploadError::no_answer);
}

// Some devices let go of the transfer with the last piece, whether it arrives or not.
TEST(FileUpload, WhatIsForgottenStartsAgain) {
    for (const auto& status :
         {cip::Status(GeneralStatus::resource_unavailable), cip::Status(GeneralStatus::invalid_parameter, {6})}) {
        auto upload = granted(6, 4);
        feed(upload, {"00 00 01 02 03 04"});
        upload.on_silence();
        upload.on_response(refusal(upload.request(), status));
        EXPECT_EQ(hex(upload.request().encode()), hex("4B 02 20 37 24 C8 FF"));
        EXPECT_EQ(upload.received(), 0U);
        feed(upload, {"06 00 00 00 04", "00 00 01 02 03 04", "01 02 05 06 EB FF"});
        EXPECT_EQ(error_of(upload), std::nullopt);
        EXPECT_EQ(hex(upload.file().content), "01 02 03 04 05 06");
    }
}

TEST(FileUpload, ADeviceThatForgetsAlwaysIsGivenUp) {
    auto upload = granted(6, 4);
    for (int i = 0; i < 2; ++i) {
        ASSERT_FALSE(upload.done());
        upload.on_response(refusal(upload.request(), GeneralStatus::resource_unavailable));
        feed(upload, {"06 00 00 00 04"});
    }
    upload.on_response(refusal(upload.request(), GeneralStatus::resource_unavailable));
    EXPECT_EQ(error_of(upload), UploadError::refused);
}

// The announced size ends every transfer, whatever the device goes on to send.
TEST(FileUpload, AnEndlessTransferEnds) {
    auto upload = granted(100'000, 255);
    std::size_t requests = 0;
    for (; !upload.done() && requests < 1000; ++requests) {
        const cip::file::UploadPiece piece{
            .number = upload.request().data[0],
            .type = requests == 0 ? cip::file::PieceType::first : cip::file::PieceType::middle,
            .data = cip::Bytes(255, 1)};
        upload.on_response({upload.request().service, {}, piece.encode()});
    }
    EXPECT_EQ(requests, 393U);
    EXPECT_EQ(error_of(upload), UploadError::too_many_octets);
}

TEST(FileUpload, AttributesThatDifferAreOdd) {
    FileUpload upload;
    while (upload.request().service == 0x0E) upload.on_response(answer(upload.request(), "02 03 04 05"));
    feed(upload, {"02 00 00 00 FF", "00 04 01 02 FD FF"});
    EXPECT_EQ(error_of(upload), std::nullopt);
    EXPECT_THAT(upload.file().oddities, ElementsAre(UploadOddity::other_size, UploadOddity::other_checksum));
}

TEST(Inflate, TakesWhatZlibWrites) {
    // Made by Python: zlib.compress(b'abcabcabcabc'), gzip.compress(b'abcabcabcabc', mtime=0).
    const auto zlib = octets("78 9C 4B 4C 4A 4E 84 21 00 1D E0 04 99");
    const auto gzip = octets("1F 8B 08 00 00 00 00 00 02 03 4B 4C 4A 4E 84 21 00 34 2A 6E 5A 0C 00 00 00");
    for (const auto& stream : {zlib, gzip}) {
        const auto content = inflate(stream);
        ASSERT_TRUE(content) << describe(content.error());
        EXPECT_EQ(std::string(content->begin(), content->end()), "abcabcabcabc");
        auto cut = stream;
        cut.pop_back();
        ASSERT_FALSE(inflate(cut));
        EXPECT_EQ(inflate(cut).error(), InflateError::damaged);
        auto damaged = stream;
        damaged.back() ^= 1;
        EXPECT_EQ(inflate(damaged).error(), InflateError::damaged) << "it has a checksum";
        EXPECT_TRUE(inflate(stream, 12));
        EXPECT_EQ(inflate(stream, 11).error(), InflateError::too_large);
    }
    EXPECT_EQ(inflate({}).error(), InflateError::unknown_format);
    EXPECT_EQ(inflate(octets("5B 46 69 6C 65 5D")).error(), InflateError::unknown_format) << "an EDS as it is";
}

}  // namespace
}  // namespace servobus::scanner
