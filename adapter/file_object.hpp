// The File object (0x37, R-FIL): hands out the EDS, piece by piece. Nothing can be written.
#pragma once

#include <cstdint>
#include <optional>

#include "adapter/network_settings.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

class FileObject final : public cip::Object {
public:
    /// The file must outlive the object.
    explicit FileObject(const DeviceFile& file);

    [[nodiscard]] cip::ClassInfo info() const override;
    [[nodiscard]] bool has_instance(std::uint32_t instance) const override;
    [[nodiscard]] bool offers(std::uint8_t service) const override;
    [[nodiscard]] std::optional<cip::AttributeAccess> attribute(std::uint32_t instance,
                                                                std::uint32_t id) const override;
    [[nodiscard]] cip::Status get(std::uint32_t instance, std::uint32_t id, cip::Writer& value) const override;
    [[nodiscard]] cip::Response call(const cip::RequestView& request, const cip::RequestPath& path,
                                     const cip::Origin& origin) override;

    /// Attribute 1 (R-FIL-2), as far as a file that is only read has states.
    enum class State : std::uint8_t { nonexistent = 0, loaded = 2, upload_initiated = 3, uploading = 5 };

private:
    /// One client's upload. `last` is the number that was sent last, none right after Initiate_Upload.
    struct Transfer {
        std::uint64_t client = 0;
        std::size_t piece = 0;
        std::size_t next_offset = 0;
        std::optional<std::uint8_t> last{};
        cip::Bytes last_reply{};
        bool finished = false;
        cip::Time deadline{};
    };

    [[nodiscard]] State state() const;
    cip::Response initiate_upload(const cip::RequestView& request, const cip::Origin& origin);
    cip::Response upload_transfer(const cip::RequestView& request, const cip::Origin& origin);
    [[nodiscard]] cip::Bytes next_piece(std::uint8_t number);
    void drop_when_idle(cip::Time now);

    const DeviceFile& file_;
    std::uint16_t checksum_;
    std::optional<Transfer> transfer_{};
};

/// The two's complement of the sum of all octets, modulo 65536 (R-FIL-6).
[[nodiscard]] std::uint16_t file_checksum(cip::ByteView content);

}  // namespace servobus::adapter
