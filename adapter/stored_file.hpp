// One instance of the File object: a file that can be read, and the one upload that may be under way (R-FIL).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "adapter/device_files.hpp"
#include "cip/file_transfer.hpp"
#include "cip/object.hpp"

namespace servobus::adapter {

class StoredFile {
public:
    /// `name` is attribute 2. Without a file the instance is there and says that it has none.
    StoredFile(std::string name, const std::optional<DeviceFile>& file);

    [[nodiscard]] cip::file::State state() const;
    /// Appends an instance attribute of R-FIL-2.
    void get(cip::file::Attribute id, cip::Writer& value) const;

    [[nodiscard]] cip::Response initiate_upload(const cip::RequestView& request, const cip::Origin& origin);
    [[nodiscard]] cip::Response upload_transfer(const cip::RequestView& request, const cip::Origin& origin);

    /// An upload that nobody goes on with is dropped (R-FIL-8).
    void drop_when_idle(cip::Time now);
    /// A client that went away does not keep others waiting.
    void drop_client(std::uint64_t session);

private:
    /// `last` is the number that was sent last, none right after Initiate_Upload.
    struct Transfer {
        std::uint64_t client = 0;
        std::size_t piece_octets = 0;
        std::size_t next_offset = 0;
        std::optional<std::uint8_t> last{};
        cip::Bytes last_reply{};
        bool finished = false;
        cip::Time deadline{};
    };

    [[nodiscard]] std::optional<cip::Status> refusal(const cip::RequestView& request, const cip::Origin& origin) const;
    [[nodiscard]] cip::Bytes next_piece(std::uint8_t number);

    std::string name_;
    bool exists_;
    DeviceFile file_;
    std::uint16_t checksum_;
    std::optional<Transfer> transfer_{};
};

}  // namespace servobus::adapter
