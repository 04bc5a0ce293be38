#include "adapter/stored_file.hpp"

#include <algorithm>
#include <utility>

#include "cip/strings.hpp"

namespace servobus::adapter {
namespace {

namespace file = cip::file;
using cip::GeneralStatus;

constexpr std::uint16_t format = 1;
constexpr std::uint8_t not_invoked = 255;
constexpr std::uint8_t read_only = 1;

constexpr std::chrono::seconds idle_limit{10};  // R-FIL-8

cip::Response refuse(const cip::RequestView& request, cip::Status status) {
    return {request.service, std::move(status), {}};
}

void write_text(cip::Writer& value, const std::string& text) {
    cip::write_stringi(value, {cip::InternationalString{.text = text}});
}

}  // namespace

StoredFile::StoredFile(std::string name, const std::optional<DeviceFile>& file)
    : name_(std::move(name)),
      exists_(file.has_value()),
      file_(file.value_or(DeviceFile{})),
      checksum_(file::checksum(*file_.content)) {}

file::State StoredFile::state() const {
    if (!exists_) return file::State::nonexistent;
    if (file_.content->empty()) return file::State::empty;
    if (!transfer_ || transfer_->finished) return file::State::loaded;
    return transfer_->last ? file::State::uploading : file::State::upload_initiated;
}

void StoredFile::get(file::Attribute id, cip::Writer& value) const {
    using enum file::Attribute;
    switch (id) {
        case file::Attribute::state:
            value.field(this->state());
            break;
        case instance_name:
            write_text(value, name_);
            break;
        case format_version:
            value.u16(format);
            break;
        case file_name:
            write_text(value, file_.name);
            break;
        case revision:
            value.u8(file_.major_revision);
            value.u8(file_.minor_revision);
            break;
        case size:
            value.u32(static_cast<std::uint32_t>(file_.content->size()));
            break;
        case checksum:
            value.u16(checksum_);
            break;
        case invocation:
            value.u8(not_invoked);
            break;
        case save_parameters:
            value.u8(0);
            break;
        case access_rule:
            value.u8(read_only);
            break;
        case encoding:
            value.field(file::Encoding::binary);
            break;
    }
}

void StoredFile::drop_when_idle(cip::Time now) {
    if (transfer_ && transfer_->deadline <= now) transfer_.reset();
}

void StoredFile::drop_client(std::uint64_t session) {
    if (transfer_ && transfer_->client == session) transfer_.reset();
}

// What both services are refused with, in this order (R-FIL-7).
std::optional<cip::Status> StoredFile::refusal(const cip::RequestView& request, const cip::Origin& origin) const {
    if (request.data.empty()) return GeneralStatus::not_enough_data;
    if (request.data.size() > 1) return GeneralStatus::too_much_data;
    if (!exists_) return GeneralStatus::object_does_not_exist;
    if (file_.content->empty()) return GeneralStatus::object_state_conflict;
    const bool busy = transfer_ && !transfer_->finished && transfer_->client != origin.session;
    if (busy) return cip::Status(GeneralStatus::object_state_conflict, {static_cast<std::uint16_t>(state())});
    return std::nullopt;
}

cip::Response StoredFile::initiate_upload(const cip::RequestView& request, const cip::Origin& origin) {
    if (auto status = refusal(request, origin)) return refuse(request, std::move(*status));
    const std::size_t asked = request.data[0];
    if (asked == 0) return refuse(request, {GeneralStatus::invalid_parameter, {file::zero_transfer_size}});
    constexpr std::size_t around_the_piece = 4 + 2 + 2;  // reply header, number and type, checksum
    if (origin.reply_limit <= around_the_piece) return refuse(request, GeneralStatus::reply_data_too_large);
    const auto piece = std::min(asked, origin.reply_limit - around_the_piece);
    transfer_ = Transfer{.client = origin.session, .piece_octets = piece, .deadline = origin.now + idle_limit};
    const file::UploadGrant grant{static_cast<std::uint32_t>(file_.content->size()), static_cast<std::uint8_t>(piece)};
    return {request.service, {}, grant.encode()};
}

cip::Response StoredFile::upload_transfer(const cip::RequestView& request, const cip::Origin& origin) {
    if (auto status = refusal(request, origin)) return refuse(request, std::move(*status));
    if (!transfer_ || transfer_->client != origin.session) return refuse(request, GeneralStatus::resource_unavailable);
    transfer_->deadline = origin.now + idle_limit;
    const auto number = request.data[0];
    if (transfer_->last == number) return {request.service, {}, transfer_->last_reply};
    if (transfer_->finished) {
        // The next number tells that the last piece has arrived; after it, nothing is under way any more.
        transfer_.reset();
        return refuse(request, GeneralStatus::resource_unavailable);
    }
    const auto expected = static_cast<std::uint8_t>(transfer_->last ? *transfer_->last + 1 : 0);
    if (number != expected) {
        transfer_.reset();
        return refuse(request, {GeneralStatus::invalid_parameter, {file::wrong_transfer_number}});
    }
    transfer_->last_reply = next_piece(number);
    transfer_->last = number;
    return {request.service, {}, transfer_->last_reply};
}

cip::Bytes StoredFile::next_piece(std::uint8_t number) {
    using enum file::PieceType;
    const bool begins = transfer_->next_offset == 0;
    const auto left = cip::ByteView(*file_.content).subspan(transfer_->next_offset);
    const auto data = left.first(std::min(left.size(), transfer_->piece_octets));
    const bool ends = data.size() == left.size();
    transfer_->next_offset += data.size();
    transfer_->finished = ends;
    file::UploadPiece piece{.number = number, .data = {data.begin(), data.end()}};
    if (ends) piece.checksum = checksum_;
    if (begins) {
        piece.type = ends ? first_and_last : first;
    } else {
        piece.type = ends ? last : middle;
    }
    return piece.encode();
}

}  // namespace servobus::adapter
