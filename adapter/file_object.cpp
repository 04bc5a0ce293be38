#include "adapter/file_object.hpp"

#include <algorithm>
#include <numeric>

#include "cip/services.hpp"
#include "cip/strings.hpp"

namespace servobus::adapter {
namespace {

constexpr std::uint16_t class_id = 0x37;
constexpr std::uint32_t eds_instance = 0xC8;
constexpr std::uint32_t printed_instance = 1;  // 000 §2.3.12 prints 1; it is the same file (R-FIL-1)

constexpr std::uint8_t initiate_upload_service = 0x4B;
constexpr std::uint8_t upload_transfer_service = 0x4F;

enum Attribute : std::uint16_t {
    state_attribute = 1,
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

constexpr std::uint8_t no_invocation = 255;
constexpr std::uint8_t read_only = 1;

// Packet types of Upload_Transfer (R-FIL-5).
enum class Packet : std::uint8_t { first = 0, middle = 1, last = 2, first_and_last = 4 };

// Extended words of 0x20 (R-FIL-7).
constexpr std::uint16_t bad_transfer_size = 0x0008;
constexpr std::uint16_t bad_transfer_number = 0x0006;

constexpr std::chrono::seconds idle_limit{10};  // R-FIL-8

}  // namespace

std::uint16_t file_checksum(cip::ByteView content) {
    const auto sum = std::accumulate(content.begin(), content.end(), std::uint32_t{0});
    return static_cast<std::uint16_t>(0U - sum);
}

FileObject::FileObject(const DeviceFile& file) : file_(file), checksum_(file_checksum(file.content)) {}

cip::ClassInfo FileObject::info() const {
    return {.class_id = class_id, .revision = 3, .max_instance = eds_instance, .max_instance_attribute = encoding};
}

bool FileObject::has_instance(std::uint32_t instance) const {
    return instance == eds_instance || instance == printed_instance;
}

bool FileObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == initiate_upload_service ||
           service == upload_transfer_service;
}

std::optional<cip::AttributeAccess> FileObject::attribute(std::uint32_t, std::uint32_t id) const {
    if (id < state_attribute || id > encoding) return std::nullopt;
    return cip::AttributeAccess{};
}

FileObject::State FileObject::state() const {
    if (file_.content.empty()) return State::nonexistent;
    if (!transfer_ || transfer_->finished) return State::loaded;
    return transfer_->last ? State::uploading : State::upload_initiated;
}

cip::Status FileObject::get(std::uint32_t, std::uint32_t id, cip::Writer& value) const {
    switch (id) {
        case state_attribute:
            value.field(state());
            break;
        case instance_name:
            cip::write_stringi(value, {cip::InternationalString{.text = "EDS and Icon Files"}});
            break;
        case format_version:
            value.u16(1);
            break;
        case file_name:
            cip::write_stringi(value, {cip::InternationalString{.text = file_.name}});
            break;
        case revision:
            value.u8(file_.major_revision);
            value.u8(file_.minor_revision);
            break;
        case size:
            value.u32(static_cast<std::uint32_t>(file_.content.size()));
            break;
        case checksum:
            value.u16(checksum_);
            break;
        case invocation:
            value.u8(no_invocation);
            break;
        case save_parameters:
        case encoding:
            value.u8(0);
            break;
        case access_rule:
            value.u8(read_only);
            break;
        default:
            return cip::GeneralStatus::attribute_not_supported;
    }
    return {};
}

cip::Response FileObject::call(const cip::RequestView& request, const cip::RequestPath&, const cip::Origin& origin) {
    drop_when_idle(origin.now);
    if (request.service == initiate_upload_service) return initiate_upload(request, origin);
    return upload_transfer(request, origin);
}

void FileObject::drop_when_idle(cip::Time now) {
    if (transfer_ && transfer_->deadline <= now) transfer_.reset();
}

cip::Response FileObject::initiate_upload(const cip::RequestView& request, const cip::Origin& origin) {
    const auto refuse = [&](cip::Status status) { return cip::Response{request.service, std::move(status), {}}; };
    if (request.data.empty()) return refuse(cip::GeneralStatus::not_enough_data);
    if (request.data.size() > 1) return refuse(cip::GeneralStatus::too_much_data);
    if (file_.content.empty()) return refuse(cip::GeneralStatus::object_does_not_exist);
    const bool busy = transfer_ && !transfer_->finished && transfer_->client != origin.session;
    if (busy) {
        return refuse({cip::GeneralStatus::object_state_conflict, {static_cast<std::uint16_t>(state())}});
    }
    constexpr std::size_t around_the_piece = 4 + 2 + 2;  // reply header, number and type, checksum
    const std::size_t room = origin.reply_limit - std::min(origin.reply_limit, around_the_piece);
    const auto piece = std::min<std::size_t>(request.data[0], room);
    if (piece == 0) return refuse({cip::GeneralStatus::invalid_parameter, {bad_transfer_size}});
    transfer_ = Transfer{.client = origin.session, .piece = piece, .deadline = origin.now + idle_limit};
    cip::Response response{request.service};
    cip::Writer writer(response.data);
    writer.u32(static_cast<std::uint32_t>(file_.content.size()));
    writer.u8(static_cast<std::uint8_t>(piece));
    return response;
}

cip::Response FileObject::upload_transfer(const cip::RequestView& request, const cip::Origin& origin) {
    const auto refuse = [&](cip::Status status) { return cip::Response{request.service, std::move(status), {}}; };
    if (request.data.empty()) return refuse(cip::GeneralStatus::not_enough_data);
    if (request.data.size() > 1) return refuse(cip::GeneralStatus::too_much_data);
    if (!transfer_) return refuse(cip::GeneralStatus::resource_unavailable);
    if (transfer_->client != origin.session) {
        if (transfer_->finished) return refuse(cip::GeneralStatus::resource_unavailable);
        return refuse({cip::GeneralStatus::object_state_conflict, {static_cast<std::uint16_t>(state())}});
    }
    transfer_->deadline = origin.now + idle_limit;
    const auto number = request.data[0];
    if (transfer_->last == number) return {request.service, {}, transfer_->last_reply};
    if (transfer_->finished) {
        // The next number tells that the last piece has arrived; after it, nothing is under way any more.
        transfer_.reset();
        return refuse(cip::GeneralStatus::resource_unavailable);
    }
    const auto expected = static_cast<std::uint8_t>(transfer_->last ? *transfer_->last + 1 : 0);
    if (number != expected) {
        transfer_.reset();
        return refuse({cip::GeneralStatus::invalid_parameter, {bad_transfer_number}});
    }
    transfer_->last_reply = next_piece(number);
    transfer_->last = number;
    return {request.service, {}, transfer_->last_reply};
}

cip::Bytes FileObject::next_piece(std::uint8_t number) {
    const bool first = transfer_->next_offset == 0;
    const auto left = cip::ByteView(file_.content).subspan(transfer_->next_offset);
    const auto piece = left.first(std::min(left.size(), transfer_->piece));
    const bool last = piece.size() == left.size();
    transfer_->next_offset += piece.size();
    transfer_->finished = last;
    cip::Bytes reply;
    cip::Writer writer(reply);
    writer.u8(number);
    writer.field(first && last ? Packet::first_and_last : first ? Packet::first : last ? Packet::last : Packet::middle);
    writer.bytes(piece);
    if (last) writer.u16(checksum_);
    return reply;
}

}  // namespace servobus::adapter
