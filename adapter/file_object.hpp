// The File object (0x37, R-FIL): hands out the EDS and, if there is one, the icon, piece by piece. Nothing can be written.
#pragma once

#include <cstdint>
#include <optional>

#include "adapter/device_files.hpp"
#include "adapter/stored_file.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

class FileObject final : public cip::Object {
public:
    explicit FileObject(const DeviceFiles& files);

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool get_class_attribute(std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] bool has_instance(std::uint32_t instance) const override { return find(instance) != nullptr; }
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Response call(const cip::RequestView& request, const cip::RequestPath& path,
                                     const cip::Origin& origin) override;

    /// Before anything is asked: uploads that nobody goes on with are dropped.
    void on_time(cip::Time now);
    void on_session_closed(std::uint64_t session);

private:
    [[nodiscard]] const StoredFile* find(std::uint32_t instance) const;

    StoredFile eds_;
    std::optional<StoredFile> icon_{};
};

}  // namespace servobus::adapter
