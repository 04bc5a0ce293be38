// eds upload: from the File object of a device into a file.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cip/file_transfer.hpp"
#include "scanner/cli/eds.hpp"
#include "scanner/cli/live_table.hpp"
#include "scanner/cli/stored_file.hpp"
#include "scanner/cli/text_output.hpp"
#include "scanner/inflate.hpp"

namespace servobus::scanner::cli {
namespace {

using Json = nlohmann::ordered_json;
using cip::file::Encoding;

/// A file on its way from the device to the disk.
struct Fetched {
    UploadedFile file{};
    cip::Bytes content{};  ///< as it is stored
    bool inflated = false;
    std::string remark{};  ///< why it is not inflated though it is compressed
    std::string path{};    ///< `-`: standard output
};

ExitCode exit_code_of(UploadError error) {
    switch (error) {
        case UploadError::no_file_object:
        case UploadError::no_file:
        case UploadError::busy:
        case UploadError::refused:
        case UploadError::aborted:
            return ExitCode::refused;
        case UploadError::no_answer:
            return ExitCode::no_connection;
        default:
            return ExitCode::nonsense;
    }
}

/// `EDSCollection.gz` is `EDSCollection` once it is inflated.
std::string without_compression_suffix(std::string name) {
    for (const std::string_view suffix : {".gz", ".GZ", ".zlib", ".z"}) {
        if (name.size() > suffix.size() && name.ends_with(suffix)) return name.substr(0, name.size() - suffix.size());
    }
    return name;
}

std::string path_of(const EdsUploadArguments& arguments, const Fetched& fetched) {
    if (!arguments.output.empty()) return arguments.output;
    auto name = fetched.file.attributes.name.value_or(std::string());
    if (fetched.inflated) name = without_compression_suffix(std::move(name));
    return safe_file_name(name, arguments.icon ? "device.ico" : "device.eds");
}

/// The content to be stored; a failure when a compressed file is damaged.
std::optional<Failure> unpack(Fetched& fetched, bool raw) {
    fetched.content = fetched.file.content;
    if (fetched.file.attributes.encoding != Encoding::compressed) return std::nullopt;
    if (raw) {
        fetched.remark = "stored as the device keeps it: compressed";
        return std::nullopt;
    }
    auto content = inflate(fetched.content);
    if (content) {
        fetched.content = std::move(*content);
        fetched.inflated = true;
        return std::nullopt;
    }
    if (content.error() != InflateError::unknown_format) {
        return Failure{ExitCode::nonsense,
                       fmt::format("the device says that the file is compressed: {}; --raw stores it "
                                   "as it is",
                                   describe(content.error()))};
    }
    fetched.remark = fmt::format("the device says that the file is compressed, but {}; it is stored as it came",
                                 describe(content.error()));
    return std::nullopt;
}

std::string revision_text(const FileAttributes& attributes) {
    if (!attributes.revision) return {};
    return fmt::format("{}.{}", attributes.revision->first, attributes.revision->second);
}

std::string text_of(const Fetched& fetched) {
    const auto revision = revision_text(fetched.file.attributes);
    const auto transferred = fetched.inflated ? fmt::format(" ({} compressed)", fetched.file.content.size()) : "";
    return fmt::format("{}: {} octets{}{}, checksum 0x{:04X}\n", fetched.path, fetched.content.size(), transferred,
                       revision.empty() ? "" : ", revision " + revision, cip::file::checksum(fetched.file.content));
}

std::string document(const std::string& host, const Fetched& fetched) {
    const auto& attributes = fetched.file.attributes;
    Json json{{"host", host},
              {"file", fetched.path},
              {"name", attributes.name ? Json(printable(*attributes.name)) : Json()},
              {"octets", fetched.content.size()},
              {"transferred_octets", fetched.file.content.size()},
              {"checksum", cip::file::checksum(fetched.file.content)},
              {"revision", attributes.revision ? Json(revision_text(attributes)) : Json()},
              {"encoding", attributes.encoding ? Json(static_cast<int>(*attributes.encoding)) : Json()},
              {"decompressed", fetched.inflated},
              {"pieces", fetched.file.pieces},
              {"repeats", fetched.file.repeats},
              {"remarks", Json::array()}};
    for (const auto oddity : fetched.file.oddities) json["remarks"].push_back(std::string(describe(oddity)));
    if (!fetched.remark.empty()) json["remarks"].push_back(fetched.remark);
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace

Failure failure_of(const UploadFailure& failure, const Host& host) {
    return {exit_code_of(failure.error), fmt::format("{}: {}", to_string(host), describe(failure)),
            failure.status.ok() ? std::nullopt : std::optional(failure.status)};
}

ExitCode eds_upload(const Console& console, const Settings& settings, const EdsUploadArguments& arguments) {
    const auto host = parse_host(arguments.host);
    if (!host) return fail(console, host.error());
    const bool to_out = arguments.output == "-";
    if (to_out && console.json) return fail(console, Mistake{"--json and '-o -' both want the standard output"});
    Link link(settings, *host);
    if (const auto failure = link.open()) return fail(console, *failure, arguments.host);

    FileUploadOptions options;
    if (arguments.icon) options.instance = cip::file::icon_instance;
    LiveTable table(console.err);
    const auto progress = [&](std::size_t octets, std::uint32_t of) {
        if (console.terminal) table.show({fmt::format("{} of {} octets", octets, of)});
    };
    auto outcome = link.upload(options, progress);
    table.clear();
    if (!outcome) return fail(console, link.failure_of(outcome.error()), arguments.host);
    if (const auto* failure = std::get_if<UploadFailure>(&*outcome)) {
        return fail(console, failure_of(*failure, *host), arguments.host);
    }

    Fetched fetched{.file = std::get<UploadedFile>(std::move(*outcome))};
    if (const auto failure = unpack(fetched, arguments.raw)) return fail(console, *failure, arguments.host);
    fetched.path = path_of(arguments, fetched);
    if (to_out) {
        console.out.write(reinterpret_cast<const char*>(fetched.content.data()),
                          static_cast<std::streamsize>(fetched.content.size()));
    } else {
        if (const auto mistake = store_file(fetched.path, fetched.content, arguments.force)) {
            return fail(console, *mistake, arguments.host);
        }
        console.show(text_of(fetched), console.json ? document(arguments.host, fetched) : std::string());
    }
    for (const auto oddity : fetched.file.oddities) console.say(describe(oddity));
    console.say(fetched.remark);
    return ExitCode::done;
}

}  // namespace servobus::scanner::cli
