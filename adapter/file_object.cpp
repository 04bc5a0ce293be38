#include "adapter/file_object.hpp"

#include "cip/file_transfer.hpp"
#include "cip/services.hpp"

namespace servobus::adapter {
namespace {

namespace file = cip::file;

constexpr std::uint32_t printed_instance = 1;  // 000 §2.3.12 prints 1; it is the same file (R-FIL-1)

constexpr auto last_attribute = static_cast<std::uint16_t>(file::Attribute::encoding);

}  // namespace

FileObject::FileObject(const DeviceFiles& files) : eds_("EDS and Icon Files", files.eds) {
    if (files.icon) icon_.emplace("Related EDS and Icon Files", files.icon);
}

cip::ClassInfo FileObject::info() const {
    return {.class_id = file::class_id,
            .revision = 3,
            .max_instance = icon_ ? file::icon_instance : file::eds_instance,
            .instances = static_cast<std::uint16_t>(icon_ ? 2 : 1),
            .max_class_attribute = file::directory_attribute,
            .max_instance_attribute = last_attribute};
}

// As many entries as class attribute 3 says; the alias is none of them (R-FIL-3).
bool FileObject::get_class_attribute(std::uint32_t id, cip::Writer& value) const {
    if (id != file::directory_attribute) return false;
    for (const auto instance : {file::eds_instance, file::icon_instance}) {
        const auto* entry = find(instance);
        if (entry == nullptr) continue;
        value.u16(static_cast<std::uint16_t>(instance));
        entry->get(file::Attribute::instance_name, value);
        entry->get(file::Attribute::file_name, value);
    }
    return true;
}

const StoredFile* FileObject::find(std::uint32_t instance) const {
    if (instance == file::eds_instance || instance == printed_instance) return &eds_;
    return instance == file::icon_instance && icon_ ? &*icon_ : nullptr;
}

bool FileObject::offers(std::uint8_t service) const {
    return service == cip::service::get_attribute_single || service == file::initiate_upload ||
           service == file::upload_transfer;
}

std::optional<cip::AttributeAccess> FileObject::attribute(std::uint32_t, std::uint32_t id) const {
    if (id < 1 || id > last_attribute) return std::nullopt;
    return cip::AttributeAccess{};
}

cip::Status FileObject::get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const {
    find(instance)->get(static_cast<file::Attribute>(id), value);
    return {};
}

cip::Response FileObject::call(const cip::RequestView& request, const cip::RequestPath& path,
                               const cip::Origin& origin) {
    auto& meant = path.instance == file::icon_instance ? *icon_ : eds_;
    return request.service == file::initiate_upload ? meant.initiate_upload(request, origin)
                                                    : meant.upload_transfer(request, origin);
}

void FileObject::on_time(cip::Time now) {
    eds_.drop_when_idle(now);
    if (icon_) icon_->drop_when_idle(now);
}

void FileObject::on_session_closed(std::uint64_t session) {
    eds_.drop_client(session);
    if (icon_) icon_->drop_client(session);
}

}  // namespace servobus::adapter
