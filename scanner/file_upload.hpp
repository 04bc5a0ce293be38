// An upload from the File object (0x37) of any device, without I/O (R-FIL): asks for one thing after the other, and
// looks at every answer.
//
//     FileUpload upload;
//     while (!upload.done()) upload.on_response(send(upload.request()));     // or on_silence()
//     if (upload.failure()) ... else upload.file()
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cip/bytes.hpp"
#include "cip/file_transfer.hpp"
#include "cip/message.hpp"

namespace servobus::scanner {

/// Octets of a file as it is transferred, at most.
inline constexpr std::size_t max_file_octets = std::size_t{16} << 20;

struct FileUploadOptions {
    std::uint32_t instance = cip::file::eds_instance;
    std::uint8_t piece_octets = 255;  ///< the largest piece that is asked for
    unsigned tries = 3;               ///< of each request that is not answered, and of the transfer as a whole
    std::size_t max_octets = max_file_octets;
};

/// What the device says about the file; many devices have only some of the attributes.
struct FileAttributes {
    std::optional<cip::file::State> state{};
    std::optional<std::string> name{};
    std::optional<std::pair<std::uint8_t, std::uint8_t>> revision{};  ///< major, minor
    std::optional<std::uint32_t> octets{};
    std::optional<std::uint16_t> checksum{};
    std::optional<cip::file::Encoding> encoding{};
    friend bool operator==(const FileAttributes&, const FileAttributes&) = default;
};

/// What is odd about a transfer that is whole all the same.
enum class UploadOddity : std::uint8_t {
    other_size,      ///< attribute 6 is not the size that the transfer has
    other_checksum,  ///< attribute 7 is not the checksum that the transfer has
    first_again,     ///< the piece after number 255 is called the first again
};
[[nodiscard]] std::string_view describe(UploadOddity oddity);

struct UploadedFile {
    FileAttributes attributes{};
    cip::Bytes content{};  ///< as it is stored: R-FIL-2's attribute `encoding` says how
    std::size_t pieces = 0;
    unsigned repeats = 0;  ///< requests that had to be sent again
    std::vector<UploadOddity> oddities{};
};

/// Why there is no file.
enum class UploadError : std::uint8_t {
    no_file_object,   ///< the device has no such class or instance
    no_file,          ///< the instance is there, and its file is not
    busy,             ///< another client is uploading
    refused,          ///< any other status
    no_answer,        ///< to one request, as often as it was sent
    malformed_reply,  ///< the data of a reply is none of this service
    bad_piece_size,   ///< granted: zero, or more than was asked for
    too_large,        ///< more octets are announced than are taken
    wrong_number,     ///< a piece has another number than was asked for
    wrong_order,      ///< a first piece in the middle, or a middle one first
    short_piece,      ///< a piece before the last is shorter than agreed
    long_piece,       ///< a piece is longer than agreed
    too_many_octets,  ///< more than were announced
    too_few_octets,   ///< the last piece comes before all that was announced
    wrong_checksum,
    aborted,  ///< by the device
};

struct UploadFailure {
    UploadError error = UploadError::refused;
    cip::Status status{};           ///< the device's word, when it refused
    std::size_t received = 0;       ///< octets, before it failed
    std::uint32_t announced = 0;    ///< octets
    std::uint8_t number = 0;        ///< of the piece that was asked for
    std::uint16_t checksum = 0;     ///< that was sent
    std::uint16_t sum_of_data = 0;  ///< that would fit the octets
};

/// A sentence without a full stop.
[[nodiscard]] std::string describe(const UploadFailure& failure);

class FileUpload {
public:
    explicit FileUpload(FileUploadOptions options = {});

    [[nodiscard]] bool done() const { return step_ == Step::done; }
    /// What is to be sent now, until it is done.
    [[nodiscard]] const cip::Request& request() const { return request_; }
    void on_response(const cip::Response& response);
    /// No answer came. The same is asked again, which brings the same piece again (R-FIL-5), and not for ever.
    void on_silence();

    /// Nullopt when it is done and well.
    [[nodiscard]] const std::optional<UploadFailure>& failure() const { return failure_; }
    /// Whole and checked when it is done and well.
    [[nodiscard]] const UploadedFile& file() const { return file_; }

    // How far it is.
    [[nodiscard]] std::size_t received() const { return file_.content.size(); }
    [[nodiscard]] std::uint32_t announced() const { return grant_.file_octets; }

private:
    enum class Step : std::uint8_t { attributes, initiate, transfer, done };

    void ask(Step step, cip::Request request);
    void ask_attribute();
    void ask_initiate();
    void ask_piece(std::uint8_t number);
    void on_attribute(const cip::Response& response);
    void on_grant(const cip::Response& response);
    void on_piece(const cip::Response& response);
    void on_refused_piece(const cip::Status& status);
    [[nodiscard]] std::optional<UploadError> wrong_with(const cip::file::UploadPiece& piece);
    void finish(std::uint16_t sent_checksum);
    void fail(UploadError error, cip::Status status = {});
    [[nodiscard]] cip::Path instance() const;

    FileUploadOptions options_;
    Step step_ = Step::attributes;
    cip::Request request_{};
    unsigned tries_ = 0;      ///< of the request that is out
    unsigned transfers_ = 0;  ///< begun
    std::size_t attribute_ = 0;
    cip::file::UploadGrant grant_{};
    std::uint8_t number_ = 0;
    UploadedFile file_{};
    std::uint16_t sent_checksum_ = 0;
    std::optional<UploadFailure> failure_{};
};

}  // namespace servobus::scanner
