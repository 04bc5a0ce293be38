// Uploads from the File object. With an even first octet hostile clients ask a device for its file, and in the end an honest one
// gets it whole; with an odd one a hostile device answers our client, which comes to an end and believes nothing that its
// checksum does not cover.
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "cip/file_transfer.hpp"
#include "cip/services.hpp"
#include "scanner/file_upload.hpp"
#include "scanner/inflate.hpp"
#include "tests/fuzz/device_site.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/support/everything.hpp"

namespace servobus::fuzz {
namespace {

using scanner::FileUpload;
using test::require;

constexpr std::size_t most_requests = 64;
constexpr std::size_t most_octets = 4096;
/// Attributes, the beginning, and a piece for each octet, each as often as it is tried.
constexpr std::size_t most_answers = 3 * (8 + most_octets) * 3;

cip::Bytes sheet() {
    cip::Bytes octets(700);
    for (std::size_t i = 0; i < octets.size(); ++i) octets[i] = static_cast<std::uint8_t>(i * 7);
    return octets;
}

// --- the device

adapter::DeviceFiles files() {
    adapter::DeviceFile file;
    file.content = std::make_shared<const cip::Bytes>(sheet());
    file.name = "sheet.eds";
    return {.eds = file, .icon = {}};
}

void ask_hostile(DeviceSite& site, Input& input) {
    const std::array clients{site.join(1), site.join(2)};
    for (std::size_t count = 0; count < most_requests && !input.over(); ++count) {
        const auto how = input.u8();
        const auto id = clients[how & 1U];
        if ((how & 0x0FU) == 0x0F) site.advance(std::chrono::seconds(how >> 4));
        if (!site.is_open(id)) continue;
        const auto instance = (how & 0x80U) != 0 ? cip::file::icon_instance : cip::file::eds_instance;
        cip::Request request;
        request.service = (how & 2U) != 0 ? cip::file::upload_transfer : cip::file::initiate_upload;
        request.path = cip::Path::to(cip::file::class_id, instance);
        request.data = (how & 4U) != 0 ? input.piece() : cip::Bytes{input.u8()};
        const auto response = site.call(id, request.encode());
        if (!response->status.ok()) continue;
        if (request.service == cip::file::initiate_upload) {
            const auto grant = cip::file::UploadGrant::parse(response->data);
            require(grant && grant->piece_octets != 0 && grant->piece_octets <= request.data[0],
                    "no larger piece is granted than was asked for", response->data);
        } else {
            const auto piece = cip::file::UploadPiece::parse(response->data);
            require(piece && piece->number == request.data[0], "a piece has the number that was asked for",
                    response->data);
        }
    }
}

void upload_honest(DeviceSite& site) {
    const auto id = site.join(0);
    FileUpload upload;
    for (std::size_t count = 0; count < most_answers && !upload.done(); ++count) {
        upload.on_response(*site.call(id, upload.request().encode()));
    }
    require(upload.done() && !upload.failure(), "an honest client gets the file");
    require(upload.file().content == sheet() && upload.file().oddities.empty(), "and gets it whole");
}

void ask_device(Input& input) {
    DeviceSite site({}, files());
    ask_hostile(site, input);
    // Uploads that are not gone on with are dropped (R-FIL-8).
    site.advance(std::chrono::seconds(11));
    upload_honest(site);
    site.leave();
}

// --- the client

void answer_client(Input& input) {
    scanner::FileUploadOptions options;
    options.max_octets = most_octets;
    options.piece_octets = static_cast<std::uint8_t>(input.u8() | 1U);
    FileUpload upload(options);
    std::size_t answers = 0;
    for (; answers < most_answers && !upload.done(); ++answers) {
        const auto request = upload.request().encode();
        require(cip::Request::parse(request).has_value(), "a request can be read", request);
        const auto how = input.u8();
        if (input.over() || how == 0xFF) {
            upload.on_silence();
            continue;
        }
        cip::Response response;
        response.service = upload.request().service;
        response.status.general = static_cast<cip::GeneralStatus>(how & 0x1FU);
        if ((how & 0x20U) != 0) response.status.extended = {input.u8()};
        response.data = input.piece();
        // With the number that is asked for the next check is reached.
        if ((how & 0x40U) != 0 && !response.data.empty() && !upload.request().data.empty()) {
            response.data[0] = upload.request().data[0];
        }
        upload.on_response(response);
        require(upload.received() <= most_octets, "no more is kept than may be", response.data);
    }
    require(upload.done(), "an upload comes to an end");
    if (const auto& failure = upload.failure()) {
        require(!describe(*failure).empty(), "a failure has words");
        return;
    }
    require(upload.file().content.size() == upload.announced(), "a file is as long as was announced");
    if (const auto inflated = scanner::inflate(upload.file().content, most_octets)) {
        require(inflated->size() <= most_octets, "a compressed file keeps its limit");
    }
}

}  // namespace

void file_upload(cip::ByteView octets) {
    Input input(octets);
    if ((input.u8() & 1U) == 0) {
        ask_device(input);
    } else {
        answer_client(input);
    }
    (void)scanner::inflate(octets, most_octets);
}

}  // namespace servobus::fuzz
