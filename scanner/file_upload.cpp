#include "scanner/file_upload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cip/services.hpp"
#include "cip/strings.hpp"
#include "cip/wire.hpp"

namespace servobus::scanner {
namespace {

namespace file = cip::file;
using cip::GeneralStatus;

/// What is read before the transfer; the rest says nothing that a client needs.
constexpr std::array read_before{file::Attribute::state, file::Attribute::file_name, file::Attribute::revision,
                                 file::Attribute::size,  file::Attribute::checksum,  file::Attribute::encoding};

/// An attribute that is broken is as good as none: the transfer has checks of its own.
void take(FileAttributes& attributes, file::Attribute id, cip::ByteView data) {
    cip::Reader reader(data);
    const auto keep = [&](auto& target, auto value) {
        if (reader.ok()) target = std::move(value);
    };
    switch (id) {
        case file::Attribute::state:
            keep(attributes.state, reader.little<file::State>());
            break;
        case file::Attribute::file_name: {
            const auto names = cip::read_stringi(reader);
            if (reader.ok() && !names.empty()) attributes.name = names.front().text;
            break;
        }
        case file::Attribute::revision: {
            const auto major = reader.u8();
            keep(attributes.revision, std::pair(major, reader.u8()));
            break;
        }
        case file::Attribute::size:
            keep(attributes.octets, reader.u32());
            break;
        case file::Attribute::checksum:
            keep(attributes.checksum, reader.u16());
            break;
        case file::Attribute::encoding:
            keep(attributes.encoding, reader.little<file::Encoding>());
            break;
        default:
            break;
    }
}

UploadError refusal_of_start(const cip::Status& status) {
    switch (status.general) {
        case GeneralStatus::path_destination_unknown:
            return UploadError::no_file_object;
        case GeneralStatus::object_does_not_exist:
            return UploadError::no_file;
        case GeneralStatus::object_state_conflict: {
            const auto state = status.extended.empty() ? 0U : status.extended.front();
            const bool transfers = state >= static_cast<unsigned>(file::State::upload_initiated);
            return transfers ? UploadError::busy : UploadError::no_file;
        }
        default:
            return UploadError::refused;
    }
}

}  // namespace

std::string_view describe(UploadOddity oddity) {
    switch (oddity) {
        case UploadOddity::other_size:
            return "attribute 6 says another size than the transfer has";
        case UploadOddity::other_checksum:
            return "attribute 7 says another checksum than the transfer has";
        case UploadOddity::first_again:
            return "the piece behind number 255 was called the first again";
    }
    return "";
}

std::string describe(const UploadFailure& failure) {
    const auto progress = fmt::format("after {} of {} octets", failure.received, failure.announced);
    switch (failure.error) {
        case UploadError::no_file_object:
            return "the device has no such file: no File object (0x37) of that instance";
        case UploadError::no_file:
            return "the device has a place for the file, and no file in it";
        case UploadError::busy:
            return "another client is uploading the file; the device forgets it after 10 s of silence";
        case UploadError::refused:
            return fmt::format("the device refused the upload {}: {}", progress, cip::describe(failure.status));
        case UploadError::no_answer:
            return fmt::format("the device did not answer in time {}, also when it was asked again", progress);
        case UploadError::malformed_reply:
            return fmt::format("a reply is not what the File object sends, {}", progress);
        case UploadError::bad_piece_size:
            return "the device grants pieces of no octet, or of more than were asked for";
        case UploadError::too_large:
            return fmt::format("the device announces {} octets, which is more than is taken", failure.announced);
        case UploadError::wrong_number:
            return fmt::format("piece {} was asked for and another one came, {}", failure.number, progress);
        case UploadError::wrong_order:
            return fmt::format("the pieces are not in the order first, middle, last, {}", progress);
        case UploadError::short_piece:
            return fmt::format("a piece in the middle is shorter than agreed, {}", progress);
        case UploadError::long_piece:
            return fmt::format("a piece is longer than agreed, {}", progress);
        case UploadError::too_many_octets:
            return fmt::format("more octets come than the {} that were announced", failure.announced);
        case UploadError::too_few_octets:
            return fmt::format("the file ends {}", progress);
        case UploadError::wrong_checksum:
            return fmt::format("the checksum is 0x{:04X}, and 0x{:04X} fits the octets", failure.checksum,
                               failure.sum_of_data);
        case UploadError::aborted:
            return fmt::format("the device aborted the upload {}", progress);
    }
    return "";
}

FileUpload::FileUpload(FileUploadOptions options) : options_(options) {
    options_.tries = std::max(options_.tries, 1U);
    ask_attribute();
}

cip::Path FileUpload::instance() const { return cip::Path::to(file::class_id, options_.instance); }

void FileUpload::ask(Step step, cip::Request request) {
    step_ = step;
    request_ = std::move(request);
    tries_ = 1;
}

void FileUpload::ask_attribute() {
    const auto id = static_cast<std::uint32_t>(read_before[attribute_]);
    ask(Step::attributes,
        {cip::service::get_attribute_single, cip::Path::to(file::class_id, options_.instance, id), {}});
}

void FileUpload::ask_initiate() {
    ++transfers_;
    file_.content.clear();
    file_.pieces = 0;
    std::erase(file_.oddities, UploadOddity::first_again);
    ask(Step::initiate, {file::initiate_upload, instance(), {options_.piece_octets}});
}

void FileUpload::ask_piece(std::uint8_t number) {
    number_ = number;
    ask(Step::transfer, {file::upload_transfer, instance(), {number}});
}

void FileUpload::on_response(const cip::Response& response) {
    switch (step_) {
        case Step::attributes:
            on_attribute(response);
            break;
        case Step::initiate:
            on_grant(response);
            break;
        case Step::transfer:
            on_piece(response);
            break;
        case Step::done:
            break;
    }
}

void FileUpload::on_silence() {
    if (done()) return;
    if (tries_ >= options_.tries) {
        fail(UploadError::no_answer);
        return;
    }
    ++tries_;
    ++file_.repeats;
}

// A device may have none of the attributes and a file all the same; that there is no such instance ends it.
void FileUpload::on_attribute(const cip::Response& response) {
    if (response.status.general == GeneralStatus::path_destination_unknown) {
        fail(UploadError::no_file_object, response.status);
        return;
    }
    if (response.status.ok()) take(file_.attributes, read_before[attribute_], response.data);
    if (++attribute_ < read_before.size()) {
        ask_attribute();
    } else {
        ask_initiate();
    }
}

void FileUpload::on_grant(const cip::Response& response) {
    if (!response.status.ok()) {
        fail(refusal_of_start(response.status), response.status);
        return;
    }
    const auto grant = file::UploadGrant::parse(response.data);
    if (!grant) {
        fail(UploadError::malformed_reply);
        return;
    }
    grant_ = *grant;
    if (grant_.file_octets > options_.max_octets) {
        fail(UploadError::too_large);
    } else if (grant_.piece_octets == 0 || grant_.piece_octets > options_.piece_octets) {
        fail(UploadError::bad_piece_size);
    } else {
        file_.content.reserve(grant_.file_octets);
        ask_piece(0);
    }
}

void FileUpload::on_piece(const cip::Response& response) {
    if (!response.status.ok()) {
        on_refused_piece(response.status);
        return;
    }
    const auto piece = file::UploadPiece::parse(response.data);
    if (!piece) {
        fail(UploadError::malformed_reply);
        return;
    }
    if (const auto error = wrong_with(*piece)) {
        fail(*error);
        return;
    }
    file_.content.insert(file_.content.end(), piece->data.begin(), piece->data.end());
    ++file_.pieces;
    if (piece->checksum) {
        finish(*piece->checksum);
    } else {
        ask_piece(static_cast<std::uint8_t>(number_ + 1));
    }
}

// Some devices do not send a piece again: they have forgotten the transfer, or are one piece further. Then it starts
// anew.
void FileUpload::on_refused_piece(const cip::Status& status) {
    const bool forgotten = status.general == GeneralStatus::resource_unavailable;
    const bool further = tries_ > 1 && status.general == GeneralStatus::invalid_parameter;
    if ((forgotten || further) && transfers_ < options_.tries) {
        ++file_.repeats;
        ask_initiate();
        return;
    }
    const bool is_busy = status.general == GeneralStatus::object_state_conflict;
    fail(is_busy ? refusal_of_start(status) : UploadError::refused, status);
}

std::optional<UploadError> FileUpload::wrong_with(const file::UploadPiece& piece) {
    using enum file::PieceType;
    if (piece.number != number_) return UploadError::wrong_number;
    if (piece.type == abort) return UploadError::aborted;
    const bool is_first = file_.pieces == 0;
    const bool says_first = piece.type == first || piece.type == first_and_last;
    if (is_first != says_first) {
        // An adapter of a wide-spread stack takes each piece of number 0 for the first.
        const bool goes_round = !is_first && number_ == 0 && piece.type == first;
        if (!goes_round) return UploadError::wrong_order;
        if (std::ranges::find(file_.oddities, UploadOddity::first_again) == file_.oddities.end()) {
            file_.oddities.push_back(UploadOddity::first_again);
        }
    }
    if (piece.data.size() > grant_.piece_octets) return UploadError::long_piece;
    if (file_.content.size() + piece.data.size() > grant_.file_octets) return UploadError::too_many_octets;
    const bool ends = file::ends_file(piece.type);
    if (!ends && piece.data.size() < grant_.piece_octets) return UploadError::short_piece;
    if (ends && file_.content.size() + piece.data.size() < grant_.file_octets) return UploadError::too_few_octets;
    return std::nullopt;
}

void FileUpload::finish(std::uint16_t sent_checksum) {
    sent_checksum_ = sent_checksum;
    if (file::checksum(file_.content) != sent_checksum) {
        fail(UploadError::wrong_checksum);
        return;
    }
    const auto& said = file_.attributes;
    if (said.octets && *said.octets != file_.content.size()) file_.oddities.push_back(UploadOddity::other_size);
    if (said.checksum && *said.checksum != sent_checksum) file_.oddities.push_back(UploadOddity::other_checksum);
    step_ = Step::done;
}

void FileUpload::fail(UploadError error, cip::Status status) {
    step_ = Step::done;
    failure_ = UploadFailure{.error = error,
                             .status = std::move(status),
                             .received = file_.content.size(),
                             .announced = grant_.file_octets,
                             .number = number_,
                             .checksum = sent_checksum_,
                             .sum_of_data = file::checksum(file_.content)};
}

}  // namespace servobus::scanner
