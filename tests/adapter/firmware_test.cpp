// The firmware of the module: its files, how they get into the flash, what runs then, and what a power cut leaves.
#include "adapter/firmware_unit.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "adapter/control.hpp"
#include "adapter/flash_image.hpp"
#include "tests/adapter/io_site.hpp"
#include "tests/adapter/peers.hpp"
#include "tests/support/flash_file.hpp"

namespace servobus::test {
namespace {

using adapter::FirmwareUnit;
using adapter::FlashImage;
using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

std::string wrong_with(cip::ByteView file) {
    const auto parsed = FlashImage::parse(file);
    const auto* reason = std::get_if<std::string>(&parsed);
    return reason != nullptr ? *reason : "nothing";
}

FlashImage image_of(const FlashFile& file) {
    const auto octets = file.octets();
    EXPECT_EQ(wrong_with(octets), "nothing");
    return std::get<FlashImage>(FlashImage::parse(octets));
}

// ------------------------------------------------------------------------------------------------------------ the files

// As docs/examples/make_flash.py --version 1.05 --revision 2.1 --variant 75v8s --bit-stream 3 --firmware 2 writes it; the
// checksum is that of Python's zlib.
constexpr std::string_view written_file =
    "53 56 42 46 4C 41 53 48 01 00 01 05 02 01 01 00 03 00 00 00 02 00 00 00 09 75 CD 07 2C D8 62 71 52 A9 41";

TEST(FlashImages, AreRead) {
    const auto parsed = FlashImage::parse(octets(written_file));
    const auto* image = std::get_if<FlashImage>(&parsed);
    ASSERT_NE(image, nullptr) << wrong_with(octets(written_file));
    EXPECT_EQ(to_string(image->version), "1.05");
    EXPECT_EQ(image->revision, (adapter::Revision{2, 1}));
    EXPECT_EQ(image->product_codes, std::vector<std::uint16_t>{0x7509});
    EXPECT_EQ(image->bit_stream_octets, 3U);
    EXPECT_EQ(image->firmware_octets, 2U);
    EXPECT_TRUE(image->fits(0x7509));
    EXPECT_FALSE(image->fits(0x7508));
    EXPECT_EQ(image_of({}).revision, std::nullopt);
}

TEST(FlashImages, OfWhichAPieceIsMissingAreRefusedWhereverItEnds) {
    const auto whole = octets(written_file);
    for (std::size_t size = 0; size < whole.size(); ++size) {
        EXPECT_NE(wrong_with(cip::ByteView(whole).first(size)), "nothing") << size;
    }
    EXPECT_EQ(wrong_with(cip::ByteView(whole).first(20)), "it is cut off: it has 20 octets, its head alone 24");
    EXPECT_EQ(wrong_with(cip::ByteView(whole).first(34)), "it is cut off: it has 34 octets and speaks of 35");
    EXPECT_EQ(wrong_with(whole + octets("00")), "it is too long: it has 36 octets and speaks of 35");
}

TEST(FlashImages, WithAnyBitTurnedAreRefused) {
    const auto whole = octets(written_file);
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
        auto damaged = whole;
        damaged[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
        EXPECT_NE(wrong_with(damaged), "nothing") << "bit " << bit;
    }
}

TEST(FlashImages, SayWhatIsWrong) {
    EXPECT_EQ(wrong_with(octets("7F 45 4C 46 02 01 01 00 00")), "it is no flash image: it does not begin as one");
    EXPECT_EQ(wrong_with({}), "it is no flash image: it does not begin as one");
    EXPECT_EQ(wrong_with(FlashFile{.format = 2}.octets()), "its format is 2; 1 is known");
    EXPECT_EQ(wrong_with(FlashFile{.minor = 100}.octets()), "its version is 1.100; the second number goes to 99");
    EXPECT_EQ(wrong_with(FlashFile{.products = {}}.octets()), "it names 0 products; 1 to 16 can be");
    EXPECT_EQ(wrong_with(FlashFile{.products = std::vector<std::uint16_t>(17)}.octets()),
              "it names 17 products; 1 to 16 can be");
    EXPECT_EQ(wrong_with(FlashFile{.firmware = 0}.octets()), "it has no bit stream or no firmware");
    EXPECT_EQ(wrong_with(FlashFile{.major_revision = 128, .minor_revision = 1}.octets()),
              "its revision is 128.1; 1.1 to 127.255 can be");
    EXPECT_EQ(wrong_with(FlashFile{.major_revision = 1, .minor_revision = 0}.octets()),
              "its revision is 1.0; 1.1 to 127.255 can be");
    auto damaged = FlashFile{.bit_stream = 4, .firmware = 4}.octets();
    damaged[30] ^= 1;
    EXPECT_THAT(wrong_with(damaged), StartsWith("it is damaged: its checksum is 0x"));
}

TEST(FlashImages, OfTheLargestSizeAreTakenAndNoneAbove) {
    const auto around = static_cast<std::uint32_t>(FlashFile{.bit_stream = 0, .firmware = 0}.octets().size());
    FlashFile file{.bit_stream = 1};
    file.firmware = static_cast<std::uint32_t>(adapter::max_flash_octets) - around - file.bit_stream;
    EXPECT_EQ(wrong_with(file.octets()), "nothing");
    ++file.firmware;
    EXPECT_EQ(wrong_with(file.octets()), "it has more than 4194304 octets");
}

// ------------------------------------------------------------------------------------------------------------- the unit

constexpr enip::Time begin{1h};
constexpr FirmwareUnit::Release first{{1, 0}, {1, 1}};

TEST(FirmwareUnit, WritesBitStreamThenFirmwareAtItsSpeed) {
    FirmwareUnit unit(0x7509, first);
    EXPECT_EQ(unit.next_deadline(), std::nullopt);
    EXPECT_EQ(unit.download(image_of({}), begin), std::nullopt);
    EXPECT_TRUE(unit.is_downloading());
    EXPECT_FALSE(unit.has_bit_stream());
    EXPECT_EQ(unit.next_deadline(), begin + 1s);
    unit.advance(begin + 250ms);
    EXPECT_EQ(unit.download_in_progress()->written, 16384U);
    EXPECT_EQ(unit.download_in_progress()->octets, 131072U);
    unit.advance(begin + 1s - 1ns);
    EXPECT_FALSE(unit.has_bit_stream());
    unit.advance(begin + 1s);
    EXPECT_TRUE(unit.has_bit_stream());
    EXPECT_EQ(unit.next_deadline(), begin + 2s);
    unit.advance(begin + 2s - 1ns);
    EXPECT_TRUE(unit.is_downloading());
    unit.advance(begin + 2s);
    EXPECT_FALSE(unit.is_downloading());
    EXPECT_EQ(unit.next_deadline(), std::nullopt);
    EXPECT_EQ(unit.running(), first) << "until the power has been off";
    EXPECT_EQ(unit.pending(), (FirmwareUnit::Release{{1, 5}, {1, 1}}));
    unit.power_cycle();
    EXPECT_EQ(unit.running(), (FirmwareUnit::Release{{1, 5}, {1, 1}})) << "the revision stays without one in the image";
    EXPECT_EQ(unit.pending(), std::nullopt);
}

// An odd number of octets does not end a deadline too early.
TEST(FirmwareUnit, IsThroughAtItsDeadlines) {
    for (const std::uint32_t octets : {1U, 3U, 7U, 65535U, 65537U, 99991U}) {
        FirmwareUnit unit(0x7509, first);
        ASSERT_EQ(unit.download(image_of({.bit_stream = octets, .firmware = octets}), begin), std::nullopt);
        const auto half = *unit.next_deadline();
        unit.advance(half);
        EXPECT_TRUE(unit.has_bit_stream()) << octets;
        ASSERT_TRUE(unit.next_deadline()) << octets;
        unit.advance(*unit.next_deadline());
        EXPECT_FALSE(unit.is_downloading()) << octets;
    }
}

TEST(FirmwareUnit, APowerCutLeavesWhatIsWhole) {
    struct Cut {
        std::chrono::milliseconds after;
        bool factory;
        bool bit_stream;
    };
    for (const auto& cut : {Cut{0ms, true, false}, Cut{999ms, true, false}, Cut{1000ms, true, true},
                            Cut{1999ms, true, true}, Cut{2000ms, false, true}}) {
        FirmwareUnit unit(0x7509, first);
        ASSERT_EQ(unit.download(image_of({}), begin), std::nullopt);
        unit.advance(begin + cut.after);
        unit.power_cycle();
        EXPECT_EQ(unit.is_in_factory_mode(), cut.factory) << cut.after.count();
        EXPECT_EQ(unit.has_bit_stream(), cut.bit_stream) << cut.after.count();
        EXPECT_FALSE(unit.is_downloading());
        // The end of the program is a power cut too.
        FirmwareUnit next(0x7509, first);
        next.restore(unit.snapshot());
        EXPECT_EQ(next.is_in_factory_mode(), cut.factory) << cut.after.count();
        EXPECT_EQ(next.running(), unit.running());
    }
}

TEST(FirmwareUnit, InFactoryModeOnlyAnImageAndAPowerCycleHelp) {
    FirmwareUnit unit(0x7509, first);
    ASSERT_EQ(unit.download(image_of({}), begin), std::nullopt);
    unit.power_cycle();
    unit.power_cycle();
    EXPECT_TRUE(unit.is_in_factory_mode());
    ASSERT_EQ(unit.download(image_of({.minor = 6}), begin + 10s), std::nullopt);
    unit.advance(begin + 20s);
    EXPECT_TRUE(unit.is_in_factory_mode());
    EXPECT_EQ(unit.pending()->version, (adapter::FirmwareVersion{1, 6}));
    unit.power_cycle();
    EXPECT_EQ(unit.running()->version, (adapter::FirmwareVersion{1, 6}));
}

TEST(FirmwareUnit, WhatItRefusesChangesNothing) {
    FirmwareUnit unit(0x7509, first);
    EXPECT_EQ(unit.download(image_of({.products = {0x7508, 0x4808}}), begin),
              "it is for product code 0x7508, 0x4808, and this drive has 0x7509");
    EXPECT_EQ(unit.snapshot(), FirmwareUnit::Flash{.release = first});
    EXPECT_FALSE(unit.is_downloading());
    ASSERT_EQ(unit.download(image_of({}), begin), std::nullopt);
    EXPECT_EQ(unit.download(image_of({.minor = 9}), begin + 100ms), "another download is in progress");
    unit.advance(begin + 2s);
    EXPECT_EQ(unit.pending()->version, (adapter::FirmwareVersion{1, 5}));
    EXPECT_EQ(unit.download(image_of({.major = 0, .minor = 90}), begin + 2s), std::nullopt) << "older ones are taken";
}

// ------------------------------------------------------------------------------------------------------------ the drive

std::string modes(const adapter::StatusLights& lights) {
    std::string text;
    for (const auto& light : lights) text += fmt::format("{}{}", text.empty() ? "" : " ", name(light.mode));
    return text;
}

constexpr auto revision = "0E 03 20 01 24 01 30 04";
constexpr auto status_word = "0E 03 20 01 24 01 30 05";
constexpr auto identity_state = "0E 03 20 01 24 01 30 08";

void cut_power(IoSite& site) { ASSERT_TRUE(site.adapter.inject(drive::Event(drive::event::PowerCycle{}), site.now)); }

TEST(FirmwareOfADrive, RunsAfterAPowerCycleAndTellsItsRevisionEverywhere) {
    IoSite site;
    {
        IoPeer peer(site);
        ASSERT_EQ(site.adapter.download(image_of({.major_revision = 2, .minor_revision = 7}), site.now), std::nullopt);
        EXPECT_EQ(modes(site.adapter.lights()), "blink off off blink");
        site.advance(2s);
        EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
        EXPECT_EQ(peer.call(revision), hex("8E 00 00 00 01 01"));
        peer.must_open(io_open(1, 254, 100));
    }
    cut_power(site);
    EXPECT_EQ(site.adapter.io().size(), 0U);
    IoPeer peer(site);
    EXPECT_EQ(peer.call(revision), hex("8E 00 00 00 02 07"));
    EXPECT_EQ(hex(cip::ByteView(peer.ask(octets("01 02 20 01 24 01")).message).subspan(4, 8)),
              hex("6D 05 2B 00 09 75 02 07"));
    site.adapter.on_datagram({IoPeer::usual_address, 4000}, {IoSite::address, 44818}, false,
                             octets("63 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00"),
                             site.now);
    const auto datagrams = site.adapter.take_datagrams();
    ASSERT_EQ(datagrams.size(), 1U);
    EXPECT_THAT(hex(datagrams[0].octets), HasSubstr("6D 05 2B 00 09 75 02 07"));
    // The electronic key is that of the new firmware, for requests and connections.
    EXPECT_EQ(peer.refusal(io_open(2)), hex("01 01 16 01")) << "key of revision 1.1";
    auto open = io_open(3);
    open.path = octets("34 04 6D05 2B00 0975 02 07 20 04 24 01 2C 65 2C 64");
    peer.must_open(open);
    EXPECT_EQ(peer.call("0E 08 34 04 6D05 2B00 0975 02 07 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
    EXPECT_EQ(peer.call("0E 08 34 04 6D05 2B00 0975 01 01 20 64 24 01 30 00"), hex("8E 00 25 00"));
}

// The File object hands out the sheet of the revision that runs.
TEST(FirmwareOfADrive, HasADataSheetOfItsOwn) {
    IoSite site;
    site.adapter.on_revision([](const drive::Identity& identity) {
        return adapter::DeviceFile{.content = std::make_shared<const cip::Bytes>(identity.major_revision * 100U)};
    });
    constexpr auto size = "0E 03 20 37 24 C8 30 06";
    ASSERT_EQ(site.adapter.download(image_of({.major_revision = 2, .minor_revision = 7}), site.now), std::nullopt);
    site.advance(2s);
    EXPECT_EQ(IoPeer(site).call(size), hex("8E 00 00 00 00 00 00 00"));
    cut_power(site);
    EXPECT_EQ(IoPeer(site).call(size), hex("8E 00 00 00 C8 00 00 00"));
}

TEST(FirmwareOfADrive, RunsAfterAResetToo) {
    for (const auto* request : {"05 02 20 01 24 01 00", "05 02 20 01 24 01 01"}) {
        IoSite site;
        {
            IoPeer peer(site);
            ASSERT_EQ(site.adapter.download(image_of({.major_revision = 2, .minor_revision = 7}), site.now),
                      std::nullopt);
            EXPECT_EQ(peer.call(request), hex("85 00 10 00")) << "not in the middle of it";
            site.advance(2s);
            EXPECT_EQ(peer.call(request), hex("85 00 00 00"));
        }
        site.advance(200ms);
        IoPeer peer(site);
        EXPECT_EQ(peer.call(revision), hex("8E 00 00 00 02 07"));
    }
}

// R-ID-3, R-ID-4: 1 firmware update; R-ID-5: 2 standby.
TEST(FirmwareOfADrive, TheBusHearsOfADownload) {
    IoSite site;
    IoPeer peer(site);
    const auto before = peer.must_open(io_open(1, 254, 100));
    ASSERT_EQ(site.adapter.download(image_of({}), site.now), std::nullopt);
    EXPECT_EQ(peer.call(status_word), hex("8E 00 00 00 10 00"));
    EXPECT_EQ(peer.call(identity_state), hex("8E 00 00 00 02"));
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00")) << "the old firmware goes on";
    for (const auto& open : {io_open(2), io_open(3, 254, 105)}) EXPECT_EQ(peer.refusal(open), hex("10 00"));
    EXPECT_THAT(site.last_warning(), HasSubstr("a download of firmware is in progress"));
    const auto class3 = cip::Request{0x54, cip::Path::to(6, 1), Peer::class3_open(9).encode()}.encode();
    EXPECT_THAT(peer.call(class3), StartsWith("D4 00 00 00"));
    peer.send(heartbeat(before, 1));
    site.take();
    site.advance(20ms);
    EXPECT_FALSE(site.take().empty()) << "connections that are there go on";
    site.advance(2s);
    EXPECT_EQ(peer.call(identity_state), hex("8E 00 00 00 03"));
    peer.must_open(io_open(4));
    EXPECT_EQ(peer.call(status_word), hex("8E 00 00 00 71 00"));
}

TEST(FirmwareOfADrive, AnOwnerThatRunsIsNotDisturbed) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.send(o_to_t(link, 1, 1, run, cip::Bytes(18)));
    EXPECT_EQ(site.adapter.download(image_of({}), site.now),
              "an owner runs the drive; it has to go to idle or close first");
    peer.send(o_to_t(link, 2, 2, idle, cip::Bytes(18)));
    EXPECT_EQ(site.adapter.download(image_of({}), site.now), std::nullopt);
    EXPECT_EQ(peer.call(status_word), hex("8E 00 00 00 11 00")) << "owned, and updated";
}

TEST(FirmwareOfADrive, InFactoryModeNobodyIsThere) {
    IoSite site;
    ASSERT_EQ(site.adapter.download(image_of({}), site.now), std::nullopt);
    site.advance(500ms);
    cut_power(site);
    EXPECT_EQ(modes(site.adapter.lights()), "off off blink off");
    EXPECT_EQ(site.last_warning(),
              "factory mode: the flash has no whole bit stream; nothing is answered until there is an image");
    const enip::Endpoint peer{IoPeer::usual_address, 50'000};
    const enip::Endpoint local{IoSite::address, 44818};
    EXPECT_FALSE(site.adapter.on_open(peer, local, site.now));
    for (const bool broadcast : {false, true}) {
        site.adapter.on_datagram(peer, local, broadcast, octets(frame("63 00")), site.now);
        site.advance(66s);
        EXPECT_THAT(site.adapter.take_datagrams(), IsEmpty());
    }
    // The next image brings it back.
    ASSERT_EQ(site.adapter.download(image_of({}), site.now), std::nullopt);
    EXPECT_EQ(modes(site.adapter.lights()), "off off blink blink");
    site.advance(1s);
    EXPECT_EQ(modes(site.adapter.lights()), "off off on blink") << "the bit stream is whole";
    site.advance(1s);
    EXPECT_EQ(modes(site.adapter.lights()), "off off on off");
    cut_power(site);
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
    IoPeer back(site);
    EXPECT_EQ(back.call(revision), hex("8E 00 00 00 01 01"));
}

TEST(FirmwareOfADrive, APowerCutBetweenThePartsLeavesTheBitStream) {
    IoSite site;
    ASSERT_EQ(site.adapter.download(image_of({}), site.now), std::nullopt);
    site.now += 1500ms;  // nobody has looked in between
    cut_power(site);
    EXPECT_EQ(modes(site.adapter.lights()), "off off on off");
}

TEST(FirmwareOfADrive, AScenarioCutsThePowerAtItsOwnTime) {
    IoSite site;
    site.adapter.play({.entries = {{1500ms, drive::Event(drive::event::PowerCycle{})}}});
    site.tick();
    ASSERT_EQ(site.adapter.download(image_of({}), site.now), std::nullopt);
    site.now += 10s;  // the timer comes late
    site.tick();
    EXPECT_EQ(modes(site.adapter.lights()), "off off on off") << "the firmware was not whole when the power went";
}

TEST(FirmwareOfADrive, IsKeptByWhoeverKeepsItsSnapshot) {
    IoSite site;
    ASSERT_EQ(site.adapter.download(image_of({.major_revision = 3, .minor_revision = 2}), site.now), std::nullopt);
    site.advance(2s);
    IoSite next;
    next.adapter.power_up_with(site.adapter.kept());
    IoPeer peer(next);
    EXPECT_EQ(peer.call(revision), hex("8E 00 00 00 03 02"));
    EXPECT_EQ(to_string(next.adapter.firmware().running()->version), "1.05");
}

// ---------------------------------------------------------------------------------------------------- the control lines

class FirmwareLines : public testing::Test {
protected:
    FirmwareLines() { std::filesystem::create_directories(directory); }
    ~FirmwareLines() override { std::filesystem::remove_all(directory); }

    std::string file(const cip::Bytes& content, const std::string& name = "new.flash") const {
        const auto path = directory / name;
        std::ofstream stream(path, std::ios::binary);
        for (const auto octet : content) stream.put(static_cast<char>(octet));
        return path.string();
    }
    json answer(const json& line) { return json::parse(control.answer(line.dump(), site.now)); }
    json download(const std::string& path) { return answer({{"command", "download"}, {"file", path}}); }
    json firmware() { return answer({{"query", "firmware"}}); }

    const std::filesystem::path directory =
        std::filesystem::path(testing::TempDir()) /
        ("servobus_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    IoSite site;
    adapter::Control control{site.adapter, drive::AxisKind{}, "127.0.1.1"};
};

TEST_F(FirmwareLines, DownloadAndTellHowItGoes) {
    const auto path = file(FlashFile{.major_revision = 2, .minor_revision = 1}.octets());
    EXPECT_EQ(control.answer(R"({"query": "firmware"})", site.now),
              R"({"ok":true,"mode":"application","installed":{"version":"1.00","revision":"1.1"},"pending":null,)"
              R"("download":null})");
    EXPECT_EQ(download(path), (json{{"ok", true}}));
    site.advance(500ms);
    EXPECT_EQ(firmware()["download"],
              (json{{"version", "1.05"}, {"revision", "2.1"}, {"written", 32768}, {"octets", 131072}}));
    EXPECT_EQ(answer({{"query", "lights"}})["ST2"]["mode"], "blink");
    site.advance(1500ms);
    EXPECT_EQ(firmware()["download"], nullptr);
    EXPECT_EQ(firmware()["installed"]["version"], "1.00");
    EXPECT_EQ(firmware()["pending"]["version"], "1.05");
    EXPECT_EQ(answer({{"event", "restart"}, {"seconds", 0}}), (json{{"ok", true}}));
    EXPECT_EQ(firmware()["installed"], (json{{"version", "1.05"}, {"revision", "2.1"}}));
    EXPECT_EQ(firmware()["pending"], nullptr);
    download(path);
    answer({{"event", "restart"}, {"seconds", 0}});
    EXPECT_EQ(firmware()["mode"], "factory");
    EXPECT_EQ(firmware()["installed"], nullptr);
}

TEST_F(FirmwareLines, WhatIsWrongIsSaid) {
    const auto reason = [&](const json& line) { return answer(line)["error"].get<std::string>(); };
    const auto of_download = [&](const std::string& path) { return reason({{"command", "download"}, {"file", path}}); };
    EXPECT_THAT(of_download((directory / "none").string()), testing::EndsWith("none: cannot be read"));
    EXPECT_THAT(of_download(file(octets("01 02"))),
                testing::EndsWith("new.flash: it is no flash image: it does not begin "
                                  "as one"));
    EXPECT_THAT(of_download(file(FlashFile{.products = {0x7508}}.octets())),
                testing::EndsWith("it is for product code 0x7508, and this drive has 0x7509"));
    EXPECT_THAT(of_download(file(cip::Bytes(adapter::max_flash_octets + 1))),
                testing::EndsWith("is larger than 4194304 octets"));
    EXPECT_EQ(reason({{"command", "download"}}), "column 1: 'file' is missing");
    EXPECT_THAT(reason({{"command", "download"}, {"file", 5}}), HasSubstr("'file' must be a text"));
    EXPECT_THAT(reason({{"command", "download"}, {"file", "x"}, {"drive", "127.0.1.9"}}), HasSubstr("127.0.1.1"));
    EXPECT_THAT(reason({{"command", "stop"}, {"file", "x"}}), HasSubstr("'file' is not a setting"));
    EXPECT_THAT(reason({{"command", "upload"}}), HasSubstr("must be one of \"stop\", \"download\""));
    EXPECT_EQ(firmware()["download"], nullptr) << "and nothing has begun";
    EXPECT_EQ(modes(site.adapter.lights()), "blink off off off");
}

TEST_F(FirmwareLines, OfManyDrivesOneIsMeant) {
    IoSite other;
    control.add(other.adapter, "127.0.1.2");
    const auto path = file(FlashFile{}.octets());
    EXPECT_EQ(answer({{"command", "download"}, {"file", path}, {"drive", "127.0.1.2"}}), (json{{"ok", true}}));
    EXPECT_FALSE(site.adapter.firmware().is_downloading());
    EXPECT_TRUE(other.adapter.firmware().is_downloading());
}

}  // namespace
}  // namespace servobus::test
