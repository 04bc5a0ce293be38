#include "cip/message_router.hpp"

#include <algorithm>
#include <utility>

#include "cip/multiple_service.hpp"
#include "cip/services.hpp"
#include "cip/wire.hpp"

namespace servobus::cip {
namespace {

// Class attributes (R-OBJ-1).
enum class ClassAttribute : std::uint32_t {
    revision = 1,
    max_instance = 2,
    instances = 3,
    max_class_attribute = 6,
    max_instance_attribute = 7,
};

std::optional<std::uint16_t> class_attribute(const ClassInfo& info, std::uint32_t id) {
    switch (static_cast<ClassAttribute>(id)) {
        case ClassAttribute::revision:
            return info.revision;
        case ClassAttribute::max_instance:
            return static_cast<std::uint16_t>(info.max_instance);
        case ClassAttribute::instances:
            return info.instances;
        case ClassAttribute::max_class_attribute:
            return info.max_class_attribute;
        case ClassAttribute::max_instance_attribute:
            return info.max_instance_attribute;
    }
    return std::nullopt;
}

// The Message Router is no `object`.
bool get_class(const ClassInfo& info, const Object* object, std::uint32_t id, Writer& writer) {
    const auto value = class_attribute(info, id);
    if (value) writer.u16(*value);
    return value || (object != nullptr && object->get_class_attribute(id, writer));
}

// Services at instance 0: reading class attributes, and nothing else.
Response call_class(const RequestView& request, const RequestPath& path, const ClassInfo& info, const Object* object) {
    Response response{static_cast<std::uint8_t>(request.service & 0x7F)};
    Writer writer(response.data);
    if (request.service == service::get_attributes_all && !info.class_attributes_all.empty()) {
        for (const auto id : info.class_attributes_all) static_cast<void>(get_class(info, object, id, writer));
        return response;
    }
    if (request.service != service::get_attribute_single) {
        response.status = GeneralStatus::service_not_supported;
        return response;
    }
    if (!path.attribute || !get_class(info, object, *path.attribute, writer)) {
        response.status = GeneralStatus::attribute_not_supported;
    }
    return response;
}

Status get_single(const Object& object, const RequestPath& path, Bytes& data) {
    const auto id = path.attribute ? path.attribute : object.implied_attribute();
    const auto access = id ? object.attribute(path.instance, *id) : std::nullopt;
    if (!access) return GeneralStatus::attribute_not_supported;
    if (!access->gettable) return GeneralStatus::attribute_not_gettable;
    Writer writer(data);
    return object.get(path.instance, *id, writer);
}

Status set_single(Object& object, const RequestPath& path, ByteView value) {
    const auto id = path.attribute ? path.attribute : object.implied_attribute();
    const auto access = id ? object.attribute(path.instance, *id) : std::nullopt;
    if (!access) return GeneralStatus::attribute_not_supported;
    if (!access->settable) return GeneralStatus::attribute_not_settable;
    return object.set(path.instance, *id, value);
}

Status get_all(const Object& object, const RequestPath& path, Bytes& data) {
    Writer writer(data);
    for (const auto id : object.attributes_all()) {
        auto status = object.get(path.instance, id, writer);
        if (!status.ok()) {
            data.clear();
            return status;
        }
    }
    return {};
}

// R-MSG-14. Stops with 0x11 at the entry that no longer fits; what fits is sent.
Status get_list(const Object& object, const RequestPath& path, ByteView request, std::size_t limit, Bytes& data) {
    Reader reader(request);
    const auto count = reader.u16();
    if (!reader.ok() || reader.remaining() < std::size_t{count} * 2) return GeneralStatus::not_enough_data;
    if (reader.remaining() > std::size_t{count} * 2) return GeneralStatus::too_much_data;
    Writer writer(data);
    writer.u16(0);
    GeneralStatus outcome = GeneralStatus::success;
    std::uint16_t answered = 0;
    for (; answered < count; ++answered) {
        const auto id = reader.u16();
        Bytes value;
        const auto status = get_single(object, {path.class_id, path.instance, id, {}}, value);
        if (!status.ok()) value.clear();
        if (data.size() + 4 + value.size() > limit) {
            outcome = GeneralStatus::reply_data_too_large;
            break;
        }
        writer.u16(id);
        writer.u16(static_cast<std::uint16_t>(status.general));
        writer.bytes(value);
        if (!status.ok()) outcome = GeneralStatus::attribute_list_error;
    }
    data[0] = static_cast<std::uint8_t>(answered);
    data[1] = static_cast<std::uint8_t>(answered >> 8);
    return outcome;
}

Response refusal(const RequestView& request, Status status) {
    return {static_cast<std::uint8_t>(request.service & ~service::reply_bit), std::move(status), {}};
}

bool keeps_data(const Status& status) {
    return status.ok() || status.general == GeneralStatus::attribute_list_error ||
           status.general == GeneralStatus::embedded_service_error;
}

}  // namespace

MessageRouter::MessageRouter(NodeIdentity node) : node_(node) {}

void MessageRouter::add(std::unique_ptr<Object> object) {
    const auto id = object->info().class_id;
    objects_[id] = std::move(object);
}

std::vector<std::uint16_t> MessageRouter::classes() const {
    std::vector<std::uint16_t> ids{class_id::message_router};
    for (const auto& [id, object] : objects_) ids.push_back(static_cast<std::uint16_t>(id));
    std::ranges::sort(ids);
    return ids;
}

std::optional<Response> MessageRouter::handle(ByteView message, const Origin& origin) {
    const auto request = RequestView::parse(message);
    if (!request) {
        if (request.error() == DecodeError::truncated) return std::nullopt;
        const RequestView pathless{.service = message[0], .path = {}, .data = {}};
        auto response = refusal(pathless, GeneralStatus::path_size_invalid);
        if (gate_ != nullptr) gate_->ended({.request = pathless, .origin = origin}, response);
        return response;
    }
    const auto path = RequestPath::parse(request->path);
    Access access{.request = *request, .origin = origin, .data = request->data};
    if (path) {
        access.path = &*path;
        access.attribute = path->attribute;
    }
    auto response = path ? dispatch(access) : refusal(*request, path.error());
    if (gate_ != nullptr) gate_->ended(access, response);
    if (response.encoded_size() > origin.reply_limit) {
        response.status = GeneralStatus::reply_data_too_large;
        response.data.clear();
    }
    return response;
}

Response MessageRouter::dispatch(Access& access) {
    const auto& request = access.request;
    const auto& path = *access.path;
    if (path.key && mismatch(*path.key, node_)) return refusal(request, GeneralStatus::key_failure_in_path);
    if (path.class_id == class_id::message_router) {
        if (path.instance > 1) return refusal(request, GeneralStatus::path_destination_unknown);
        if (path.instance == 1 && request.service == service::multiple_service_packet) {
            return multiple_service_packet(request, access.origin);
        }
        static constexpr ClassInfo router{.class_id = class_id::message_router, .max_instance_attribute = 0};
        if (path.instance == 0) return call_class(request, path, router, nullptr);
        return refusal(request, GeneralStatus::service_not_supported);  // R-MR-1
    }
    const auto found = objects_.find(path.class_id);
    if (found == objects_.end()) return refusal(request, GeneralStatus::path_destination_unknown);
    return dispatch(access, *found->second);
}

Response MessageRouter::dispatch(Access& access, Object& object) {
    const auto& request = access.request;
    const auto& path = *access.path;
    const bool means_one =
        request.service == service::get_attribute_single || request.service == service::set_attribute_single;
    if (means_one && !path.attribute) access.attribute = object.implied_attribute();
    if (path.instance == 0) return call_class(request, path, object.info(), &object);
    if (!object.has_instance(path.instance)) return refusal(request, GeneralStatus::path_destination_unknown);
    if ((request.service & service::reply_bit) != 0 || !object.offers(request.service)) {
        return refusal(request, GeneralStatus::service_not_supported);
    }
    if (gate_ != nullptr) {
        if (auto status = gate_->admit(access); !status.ok()) return object.refuse(request, std::move(status));
    }
    return carry_out(access, object);
}

Response MessageRouter::carry_out(const Access& access, Object& object) {
    const auto& request = access.request;
    const auto& path = *access.path;
    Response response{request.service};
    constexpr std::size_t reply_header = 4;
    const auto limit = access.origin.reply_limit - std::min(access.origin.reply_limit, reply_header);
    switch (request.service) {
        case service::get_attribute_single:
            response.status = get_single(object, path, response.data);
            break;
        case service::set_attribute_single:
            response.status = set_single(object, path, request.data);
            if (response.status.ok()) ++sets_;
            break;
        case service::get_attributes_all:
            response.status = get_all(object, path, response.data);
            break;
        case service::get_attribute_list:
            response.status = get_list(object, path, request.data, limit, response.data);
            if (response.status.general == GeneralStatus::reply_data_too_large) return response;
            break;
        case service::set_attribute_list:
            response.status = set_list(access, object, limit, response.data);
            break;
        default:
            return object.call(request, path, access.origin);
    }
    if (!keeps_data(response.status)) response.data.clear();
    return response;
}

// The octets of its value, or why they could not be found.
struct MessageRouter::SetEntry {
    std::uint16_t id = 0;
    ByteView value;
    GeneralStatus found = GeneralStatus::missing_attribute_list_entry;
};

MessageRouter::SetEntry MessageRouter::read_entry(const Object& object, std::uint32_t instance, Reader& reader) {
    SetEntry entry;
    if (reader.remaining() < 2) return entry;
    entry.id = reader.u16();
    if (!object.attribute(instance, entry.id)) {
        entry.found = GeneralStatus::attribute_not_supported;
        return entry;
    }
    const auto size = object.value_size(instance, entry.id, reader.rest());
    if (!size || *size > reader.remaining()) {
        entry.found = GeneralStatus::not_enough_data;
        return entry;
    }
    entry.value = reader.take(*size);
    entry.found = GeneralStatus::success;
    return entry;
}

// Each entry that could be read has to pass the gate by itself.
Status MessageRouter::set_entry(const Access& list, Object& object, const SetEntry& entry) {
    if (entry.found == GeneralStatus::missing_attribute_list_entry) return entry.found;
    auto access = list;
    access.attribute = entry.id;
    access.data = entry.value;
    access.is_entry = true;
    Status status = entry.found;
    if (status.ok() && gate_ != nullptr) status = gate_->admit(access);
    if (status.ok()) {
        status = set_single(object, {list.path->class_id, list.path->instance, entry.id, {}}, entry.value);
        if (status.ok()) ++sets_;
    }
    if (gate_ != nullptr) gate_->ended(access, {list.request.service, status, {}});
    return status;
}

// R-MSG-15. Behind an entry whose value has no known size nothing can be found: 0x1C for the rest. All entries are
// found before any is applied, so that a request with surplus data changes nothing.
Status MessageRouter::set_list(const Access& access, Object& object, std::size_t limit, Bytes& data) {
    Reader reader(access.data);
    const auto count = reader.u16();
    if (!reader.ok()) return GeneralStatus::not_enough_data;
    // The shortest entry has an id and one octet of value; each is answered by four octets.
    if (std::size_t{count} * 3 > reader.remaining()) return GeneralStatus::not_enough_data;
    if (2 + std::size_t{count} * 4 > limit) return GeneralStatus::reply_data_too_large;
    std::vector<SetEntry> entries(count);
    bool lost = false;
    for (auto& entry : entries) {
        if (!lost) entry = read_entry(object, access.path->instance, reader);
        lost = lost || entry.found != GeneralStatus::success;
    }
    if (!lost && reader.remaining() > 0) return GeneralStatus::too_much_data;

    Writer writer(data);
    writer.u16(count);
    GeneralStatus outcome = GeneralStatus::success;
    for (const auto& entry : entries) {
        const auto status = set_entry(access, object, entry);
        writer.u16(entry.id);
        writer.field(static_cast<std::uint16_t>(status.general));
        if (!status.ok()) outcome = GeneralStatus::attribute_list_error;
    }
    return outcome;
}

// R-MSG-16. The head of the reply is as long as that of the request; a part that does not fit any more is 0x11 in its
// place.
Response MessageRouter::multiple_service_packet(const RequestView& request, const Origin& origin) {
    const auto refuse = [&](GeneralStatus status) { return Response{request.service, status, {}}; };
    if (origin.depth >= max_embedding) return refuse(GeneralStatus::service_not_supported);
    constexpr std::size_t smallest_request = 2;
    const auto parts = read_parts(request.data);
    const auto is_short = [](ByteView part) { return part.size() < smallest_request; };
    if (!parts || std::ranges::any_of(*parts, is_short)) return refuse(GeneralStatus::not_enough_data);

    constexpr std::size_t reply_header = 4;
    auto left = parts->size();
    const auto head = reply_header + parts_head(left);
    if (head + left * reply_header > origin.reply_limit) return refuse(GeneralStatus::reply_data_too_large);
    auto inner = origin;
    inner.depth = max_embedding;
    inner.is_part = true;
    auto room = origin.reply_limit - head;
    Response response{request.service};
    std::vector<Bytes> replies;
    for (const auto part : *parts) {
        --left;
        inner.reply_limit = room - left * reply_header;  // the others have room at least to say that they had none
        const auto reply = handle(part, inner);
        if (!reply->status.ok()) response.status = GeneralStatus::embedded_service_error;
        replies.push_back(reply->encode());
        room -= replies.back().size();
    }
    response.data = write_parts(replies);
    return response;
}

}  // namespace servobus::cip
