// `eds upload`: a device's files on the disk, from devices that do as they should and others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cip/file_transfer.hpp"
#include "cip/strings.hpp"
#include "cip/wire.hpp"
#include "scanner/cli/stored_file.hpp"
#include "scanner/upload_file.hpp"
#include "tests/scanner/fake_server.hpp"
#include "tests/scanner/run_scanner.hpp"
#include "tests/scanner/running_adapter.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using namespace test;
namespace file = cip::file;
namespace fs = std::filesystem;
using cip::GeneralStatus;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// A file in a device, and what is wrong with how it hands it out.
struct Stored {
    cip::Bytes content = hex("01 02 03 04 05 06");
    std::string name = "drive.eds";
    file::Encoding encoding = file::Encoding::binary;
    std::uint8_t piece = 4;
    /// Has the last word about each piece.
    std::function<void(file::UploadPiece&)> damage = [](file::UploadPiece&) {};
};

cip::Response attribute(const cip::Request& request, std::uint32_t id, const Stored& stored) {
    cip::Response response{request.service};
    cip::Writer value(response.data);
    switch (static_cast<file::Attribute>(id)) {
        case file::Attribute::state:
            value.field(file::State::loaded);
            break;
        case file::Attribute::file_name:
            cip::write_stringi(value, {{.text = stored.name}});
            break;
        case file::Attribute::revision:
            value.u16(0x0102);
            break;
        case file::Attribute::encoding:
            value.field(stored.encoding);
            break;
        default:
            response.status = GeneralStatus::attribute_not_supported;
            break;
    }
    return response;
}

FakeServer::Script handing_out(Stored stored) {
    return answering([stored = std::move(stored)](const cip::Request& request) -> cip::Response {
        const auto octets = request.path.encode();
        if (request.service == 0x0E) return attribute(request, octets.back(), stored);
        if (request.service == file::initiate_upload) {
            const file::UploadGrant grant{static_cast<std::uint32_t>(stored.content.size()), stored.piece};
            return {request.service, {}, grant.encode()};
        }
        // Small enough that numbers do not go round.
        const auto begin = std::min<std::size_t>(std::size_t{request.data[0]} * stored.piece, stored.content.size());
        const auto end = std::min(begin + stored.piece, stored.content.size());
        file::UploadPiece piece{.number = request.data[0]};
        piece.data.assign(stored.content.begin() + static_cast<std::ptrdiff_t>(begin),
                          stored.content.begin() + static_cast<std::ptrdiff_t>(end));
        const bool ends = end == stored.content.size();
        if (ends) piece.checksum = file::checksum(stored.content);
        piece.type = begin == 0 ? (ends ? file::PieceType::first_and_last : file::PieceType::first)
                                : (ends ? file::PieceType::last : file::PieceType::middle);
        stored.damage(piece);
        return {request.service, {}, piece.encode()};
    });
}

std::string content(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// Each test in a directory of its own, which it stands in.
class EdsUpload : public testing::Test {
protected:
    void SetUp() override {
        fs::create_directories(directory_);
        fs::current_path(directory_);
    }
    void TearDown() override {
        fs::current_path(before_);
        fs::remove_all(directory_);
    }
    std::size_t files() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(directory_), fs::directory_iterator()));
    }

private:
    const fs::path before_ = fs::current_path();
    const fs::path directory_ = fs::temp_directory_path() / ("servobus-eds-upload-" + std::to_string(getpid()));
};

TEST_F(EdsUpload, StoresTheFileUnderItsName) {
    FakeServer server(handing_out({}));
    const auto result = run_scanner({"eds", "upload", server.host()});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(result.out, "drive.eds: 6 octets, revision 2.1, checksum 0xFFEB\n");
    EXPECT_THAT(result.err, IsEmpty());
    EXPECT_EQ(content("drive.eds"), "\x01\x02\x03\x04\x05\x06");
    EXPECT_EQ(files(), 1U);
}

TEST_F(EdsUpload, OverwritesOnlyWhenItIsTold) {
    FakeServer server(handing_out({}));
    std::ofstream("drive.eds") << "mine";
    const auto refused = run_scanner({"eds", "upload", server.host()});
    EXPECT_EQ(refused.code, 2);
    EXPECT_EQ(refused.err, "servobus-scanner: 'drive.eds' is there already; --force overwrites it\n");
    EXPECT_EQ(content("drive.eds"), "mine");
    EXPECT_EQ(files(), 1U) << "nothing half-written lies about";
    EXPECT_EQ(run_scanner({"eds", "upload", server.host(), "--force"}).code, 0);
    EXPECT_EQ(content("drive.eds"), "\x01\x02\x03\x04\x05\x06");
    EXPECT_EQ(run_scanner({"eds", "upload", server.host(), "-o", "other.eds"}).code, 0);
    EXPECT_EQ(content("other.eds"), "\x01\x02\x03\x04\x05\x06");
    const auto nowhere = run_scanner({"eds", "upload", server.host(), "-o", "no/such/directory.eds"});
    EXPECT_EQ(nowhere.code, 2);
    EXPECT_THAT(nowhere.err, HasSubstr("cannot be written: No such file or directory"));
}

TEST_F(EdsUpload, ToStandardOutput) {
    FakeServer server(handing_out({}));
    const auto result = run_scanner({"eds", "upload", server.host(), "-o", "-"});
    EXPECT_EQ(result.out, "\x01\x02\x03\x04\x05\x06");
    EXPECT_EQ(files(), 0U);
    EXPECT_EQ(run_scanner({"eds", "upload", server.host(), "-o", "-", "--json"}).code, 2);
}

TEST_F(EdsUpload, SpeaksJson) {
    FakeServer server(handing_out({}));
    const auto document = json::parse(run_scanner({"eds", "upload", server.host(), "--json"}).out);
    EXPECT_EQ(document, json({{"host", server.host()},
                              {"file", "drive.eds"},
                              {"name", "drive.eds"},
                              {"octets", 6},
                              {"transferred_octets", 6},
                              {"checksum", 0xFFEB},
                              {"revision", "2.1"},
                              {"encoding", 0},
                              {"decompressed", false},
                              {"pieces", 2},
                              {"repeats", 0},
                              {"remarks", json::array()}}));
}

TEST_F(EdsUpload, ANameOfADeviceIsNoPath) {
    FakeServer server(handing_out({.name = "../../etc/.pass\nwd\x1B.eds"}));
    EXPECT_THAT(run_scanner({"eds", "upload", server.host()}).out, StartsWith("pass_wd_.eds: "));
    EXPECT_TRUE(fs::exists("pass_wd_.eds"));
    FakeServer nameless(handing_out({.name = "..", .encoding = file::Encoding::ascii_text}));
    EXPECT_THAT(run_scanner({"eds", "upload", nameless.host()}).out, StartsWith("device.eds: "));
    EXPECT_THAT(run_scanner({"eds", "upload", nameless.host(), "--icon"}).out, StartsWith("device.ico: "));
}

TEST_F(EdsUpload, InflatesWhatIsCompressed) {
    // gzip.compress(b'abcabcabcabc', mtime=0)
    const auto gzip = hex("1F 8B 08 00 00 00 00 00 02 03 4B 4C 4A 4E 84 21 00 34 2A 6E 5A 0C 00 00 00");
    FakeServer server(handing_out({.content = gzip, .name = "icon.ico.gz", .encoding = file::Encoding::compressed}));
    const auto result = run_scanner({"eds", "upload", server.host(), "--icon"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out, StartsWith("icon.ico: 12 octets (25 compressed), revision 2.1, "));
    EXPECT_EQ(content("icon.ico"), "abcabcabcabc");
    const auto raw = run_scanner({"eds", "upload", server.host(), "--raw"});
    EXPECT_EQ(raw.code, 0);
    EXPECT_THAT(raw.err, HasSubstr("stored as the device keeps it: compressed"));
    EXPECT_EQ(content("icon.ico.gz"), std::string(gzip.begin(), gzip.end()));

    auto damaged = gzip;
    damaged[12] ^= 0xFF;
    FakeServer broken(handing_out({.content = damaged, .encoding = file::Encoding::compressed}));
    const auto refused = run_scanner({"eds", "upload", broken.host()});
    EXPECT_EQ(refused.code, 5);
    EXPECT_THAT(refused.err, HasSubstr("the compressed stream is damaged, or ends too early; --raw stores it"));
    EXPECT_FALSE(fs::exists("drive.eds"));

    FakeServer other(handing_out({.encoding = file::Encoding::compressed}));
    const auto stored = run_scanner({"eds", "upload", other.host()});
    EXPECT_EQ(stored.code, 0);
    EXPECT_THAT(stored.err, HasSubstr("it is neither a zlib nor a gzip stream; it is stored as it came"));
    EXPECT_EQ(content("drive.eds"), "\x01\x02\x03\x04\x05\x06");
}

TEST_F(EdsUpload, StoresNothingThatIsDamaged) {
    FakeServer server(handing_out({.damage = [](file::UploadPiece& piece) {
        if (piece.checksum) piece.checksum = 0x1234;
    }}));
    const auto result = run_scanner({"eds", "upload", server.host(), "--json"});
    EXPECT_EQ(result.code, 5);
    EXPECT_THAT(result.err, HasSubstr("the checksum is 0x1234, and 0xFFEB fits the octets"));
    EXPECT_EQ(json::parse(result.out)["error"]["kind"], "nonsense");
    EXPECT_EQ(files(), 0U);
}

TEST_F(EdsUpload, RefusalsAndSilenceHaveTheirExitCodes) {
    FakeServer without(answering([](const cip::Request& request) {
        return cip::Response{request.service, GeneralStatus::path_destination_unknown, {}};
    }));
    const auto refused = run_scanner({"eds", "upload", without.host(), "--json"});
    EXPECT_EQ(refused.code, 4);
    EXPECT_EQ(json::parse(refused.out)["error"]["general"], 5);
    EXPECT_THAT(refused.err, HasSubstr("the device has no such file"));
    FakeServer mute(after_registration([](Peer&, const enip::Frame&) {}));
    const auto silent = run_scanner({"eds", "upload", mute.host(), "--timeout", "0.05"});
    EXPECT_EQ(silent.code, 3);
    EXPECT_THAT(silent.err, HasSubstr("did not answer in time"));
    EXPECT_EQ(run_scanner({"eds", "upload"}).code, 2);
    EXPECT_EQ(run_scanner({"eds"}).code, 2);
    EXPECT_EQ(run_scanner({"eds", "upload", "127.0.0.1:0"}).code, 2);
}

TEST(StoredFile, NamesOfDevices) {
    EXPECT_EQ(safe_file_name("EDS.txt", "x"), "EDS.txt");
    EXPECT_EQ(safe_file_name("C:\\temp\\a b.eds", "x"), "a_b.eds");
    EXPECT_EQ(safe_file_name("-rf", "x"), "rf");
    EXPECT_EQ(safe_file_name("", "x"), "x");
    EXPECT_EQ(safe_file_name("/", "x"), "x");
    EXPECT_EQ(safe_file_name(std::string(300, 'a') + ".eds", "x"), std::string(96, 'a') + ".eds");
    EXPECT_EQ(safe_file_name(std::string("a\0b", 3), "x"), "a_b");
}

/// A client without a command line around it.
struct ClientOnly {
    net::io_context context{1};
    Client client{context.get_executor()};

    explicit ClientOnly(const FakeServer& server) {
        bool connected = false;
        client.async_connect("127.0.0.1", server.port(), [&](error_code failure) {
            EXPECT_FALSE(failure);
            connected = true;
        });
        run_until(connected);
    }
    /// The client goes on reading, so its context never runs out of work.
    void run_until(const bool& reached) {
        const auto limit = std::chrono::steady_clock::now() + 10s;
        while (!reached && std::chrono::steady_clock::now() < limit) context.run_one_until(limit);
        EXPECT_TRUE(reached);
    }

    bool done = false;
    error_code error;
    UploadOutcome outcome;
    auto token() {
        return [this](error_code result, UploadOutcome file) {
            error = result;
            outcome = std::move(file);
            done = true;
        };
    }
};

TEST(UploadFile, OverAClientWithProgress) {
    FakeServer server(handing_out({}));
    ClientOnly one(server);
    std::vector<std::size_t> progress;
    UploadManners manners{1s, [&](std::size_t octets, std::uint32_t) { progress.push_back(octets); }};
    async_upload_file(one.client, {}, std::move(manners), one.token());
    one.run_until(one.done);
    EXPECT_FALSE(one.error);
    ASSERT_TRUE(std::holds_alternative<UploadedFile>(one.outcome));
    EXPECT_EQ(std::get<UploadedFile>(one.outcome).content.size(), 6U);
    EXPECT_EQ(progress.back(), 6U);
}

TEST(UploadFile, AClosedConnectionIsAnError) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame&) { peer.close(); }));
    ClientOnly one(server);
    async_upload_file(one.client, {}, {}, one.token());
    one.run_until(one.done);
    EXPECT_EQ(one.error, make_error_code(Error::closed));
}

TEST(UploadFile, IsCancelled) {
    FakeServer server(after_registration([](Peer&, const enip::Frame&) {}));
    ClientOnly one(server);
    net::cancellation_signal signal;
    async_upload_file(one.client, {}, {60s, {}}, net::bind_cancellation_slot(signal.slot(), one.token()));
    net::post(one.context, [&] { signal.emit(net::cancellation_type::terminal); });
    one.run_until(one.done);
    EXPECT_EQ(one.error, net::error::operation_aborted);
}

/// The real adapter with files of this test's making.
class EdsUploadEndToEnd : public test::RunningAdapter {
protected:
    void SetUp() override {
        eds_ = file(".eds");
        icon_ = file(".ico");
        std::string text = "$ ";
        for (int i = 0; i < 9000; ++i) text += std::to_string(i % 10);
        std::ofstream(eds_) << text << "\r\n";
        std::ofstream(icon_) << "icon";
        std::ofstream(config_ = file(".json")) << json{{"eds", eds_}, {"icon", icon_}};
        options = {"--config", config_};
        RunningAdapter::SetUp();
    }
    void TearDown() override {
        RunningAdapter::TearDown();
        for (const auto& path : {eds_, icon_, config_, output_}) fs::remove(path);
    }

    std::string eds_;
    std::string icon_;
    std::string config_;
    std::string output_ = file(".uploaded");
};

TEST_F(EdsUploadEndToEnd, ComesAsItIsInTheDevice) {
    const auto result = run_scanner({"eds", "upload", host, "-o", output_, "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(json::parse(result.out)["pieces"], 36);
    EXPECT_EQ(content(output_), content(eds_));
    EXPECT_EQ(run_scanner({"eds", "upload", host, "-o", output_, "--force", "--connected"}).code, 0);
    EXPECT_EQ(content(output_), content(eds_));
    EXPECT_EQ(run_scanner({"eds", "upload", host, "-o", output_, "--force", "--route", "1/0"}).code, 0);
    EXPECT_EQ(content(output_), content(eds_));
    EXPECT_EQ(run_scanner({"eds", "upload", host, "--icon", "-o", output_, "--force"}).code, 0);
    EXPECT_EQ(content(output_), "icon");
}

TEST_F(EdsUploadEndToEnd, LostRepliesAreAskedForAgain) {
    for (const int lost : {1, 2}) {
        EXPECT_EQ(control(R"({"event": "withhold-replies", "count": )" + std::to_string(lost) + "}"), "{\"ok\":true}");
        const auto result =
            run_scanner({"eds", "upload", host, "-o", output_, "--force", "--timeout", "0.3", "--json"});
        EXPECT_EQ(result.code, 0) << result.err;
        EXPECT_EQ(json::parse(result.out)["repeats"], lost);
        EXPECT_EQ(content(output_), content(eds_));
    }
}

}  // namespace
}  // namespace servobus::scanner::cli
