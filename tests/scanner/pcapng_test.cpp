// Captures: what is written can be read, and damaged files end in an error that says where.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "cip/wire.hpp"
#include "scanner/cli/doctor.hpp"
#include "tests/scanner/sample_capture.hpp"

namespace servobus::scanner {
namespace {

using namespace test;
using testing::HasSubstr;

struct Kept {
    CapturedPacket packet;
    cip::Bytes payload;
};

struct File {
    CaptureSummary summary;
    std::vector<Kept> packets;
};

File packets_of(const std::string& text) {
    std::istringstream stream(text);
    File file;
    file.summary = read_capture(stream, [&](const CapturedPacket& packet) {
        file.packets.push_back({packet, {packet.payload.begin(), packet.payload.end()}});
        file.packets.back().packet.payload = {};
    });
    return file;
}

std::string text_of(const cip::Bytes& bytes) { return {bytes.begin(), bytes.end()}; }

std::uint16_t ones_complement_sum(cip::ByteView bytes, std::uint32_t sum = 0) {
    for (std::size_t i = 0; i < bytes.size(); ++i) sum += i % 2 == 0 ? bytes[i] * 256U : bytes[i];
    while (sum > 0xFFFF) sum = (sum & 0xFFFF) + (sum >> 16);
    return static_cast<std::uint16_t>(sum);
}

TEST(PcapngWriter, WritesTheseOctets) {
    std::ostringstream out;
    PcapngWriter writer(out);
    const auto payload = octets("01 02 03");
    EXPECT_TRUE(writer.udp({0x7F000001, 0x08AE}, {0x7F000002, 0x08AE}, payload, CaptureTime(1ns + 4294967296ns)));
    EXPECT_EQ(servobus::test::hex(octets_of(out.str())),
              servobus::test::hex(
                  // Section header, version 1.0, with the name of the application.
                  "0A0D0D0A 2C000000 4D3C2B1A 01000000 FFFFFFFFFFFFFFFF 04000800 536572766F627573 00000000 2C000000"
                  // Interface: Ethernet, packets never cut, nanoseconds.
                  "01000000 20000000 01000000 00000000 09000100 09000000 00000000 20000000"
                  // Packet: time in two halves, 45 octets, padded.
                  "06000000 50000000 00000000 01000000 01000000 2D000000 2D000000"
                  "02007F000002 02007F000001 0800"
                  "4500001F 00004000 40113CCB 7F000001 7F000002"
                  "08AE08AE 000B EC76 010203"
                  "000000 50000000"));
}

TEST(PcapngWriter, ChecksumsAddUpAndMulticastHasItsOwnAddress) {
    SampleCapture sample;
    sample.io(false, octets("AA BB CC"), {0xEFC00D60, enip::io_port});
    sample.say(true, octets("01 02 03 04 05"));
    const auto text = sample.text();
    const auto begin = text.find(text_of(octets("01 00 5E 40 0D 60")));
    ASSERT_NE(begin, std::string::npos) << "239.192.13.96 is the group address 01:00:5E:40:0D:60";
    const auto frame = octets_of(text.substr(begin, 14 + 20 + 8 + 3));
    const cip::ByteView view(frame);
    EXPECT_EQ(ones_complement_sum(view.subspan(14, 20)), 0xFFFF);
    EXPECT_EQ(ones_complement_sum(view.subspan(34), ones_complement_sum(view.subspan(26, 8)) + 17U + 11U), 0xFFFF);
    EXPECT_EQ(frame[22], 1) << "multicast stays in its network";
}

TEST(PcapngWriter, RefusesWhatNoDatagramHolds) {
    std::ostringstream out;
    PcapngWriter writer(out);
    EXPECT_TRUE(writer.udp(originator_io, target_io, cip::Bytes(PcapngWriter::max_udp_payload), capture_begin));
    EXPECT_FALSE(writer.udp(originator_io, target_io, cip::Bytes(PcapngWriter::max_udp_payload + 1), capture_begin));
    EXPECT_EQ(writer.packets(), 1U);
    EXPECT_EQ(packets_of(out.str()).packets.size(), 1U);
}

TEST(PcapngWriter, ATcpConnectionBeginsWithItsHandshakeAndIsCutIntoSegments) {
    SampleCapture sample;
    const cip::Bytes message(3000, 0x5A);
    sample.say(false, message);  // the server may be the first who is heard
    sample.say(true, octets("01"));
    sample.writer().tcp_close(originator, target, sample.now());
    sample.writer().tcp_close(originator, target, sample.now());
    const auto file = packets_of(sample.text());
    ASSERT_FALSE(file.summary.damage);
    ASSERT_EQ(file.packets.size(), 3U + 3 + 1 + 3);
    EXPECT_TRUE(file.packets[0].packet.syn);
    EXPECT_EQ(file.packets[0].packet.source, originator) << "the port tells who is the server";
    EXPECT_EQ(file.packets[3].payload.size(), PcapngWriter::tcp_segment);
    EXPECT_EQ(file.packets[5].payload.size(), 3000 - 2 * PcapngWriter::tcp_segment);
    EXPECT_EQ(file.packets[5].packet.sequence, 1 + 2 * PcapngWriter::tcp_segment);
    EXPECT_EQ(file.packets[6].packet.sequence, 1U);
    EXPECT_TRUE(file.packets[7].packet.fin);
}

TEST(PcapngWriter, ForgetsTheOldestOfTooManyConnections) {
    std::ostringstream out;
    PcapngWriter writer(out);
    const auto payload = octets("01");
    const auto talk = [&](std::uint32_t host) { writer.tcp({host, 4000}, target, payload, capture_begin); };
    for (std::uint32_t host = 1; host <= PcapngWriter::max_streams; ++host) talk(host);
    talk(1);
    EXPECT_EQ(writer.packets(), 4 * PcapngWriter::max_streams + 1) << "known: no second handshake";
    talk(PcapngWriter::max_streams + 1);
    talk(1);
    EXPECT_EQ(writer.packets(), 4 * PcapngWriter::max_streams + 1 + 4 + 4);
}

TEST(CaptureFile, ReadsBackWhatWasWritten) {
    SampleCapture sample;
    sample.golden(5);
    const auto file = packets_of(sample.text());
    ASSERT_FALSE(file.summary.damage);
    EXPECT_EQ(file.summary.packets, sample.writer().packets());
    EXPECT_EQ(file.summary.first, capture_begin);
    std::vector<cip::Bytes> expected;
    for (const auto& vector : golden_vectors()) {
        if (vector.scene == 5) expected.push_back(vector.octets);
    }
    std::vector<cip::Bytes> got;
    for (const auto& kept : file.packets) {
        if (!kept.payload.empty()) got.push_back(kept.payload);
    }
    EXPECT_EQ(got, expected);
}

// The same Ethernet-less datagram in every dress.
const std::string ip_datagram = "4500001F 00004000 40113CCB 7F000001 7F000002 08AE08AF 000BEC75 010203";

class Dress : public testing::TestWithParam<std::pair<unsigned, std::string>> {};

TEST_P(Dress, TakesThePacketOutOfEachLinkLayer) {
    const auto& [link, front] = GetParam();
    const auto frame = octets(front + ip_datagram);
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    // pcap in big-endian order, with nanoseconds.
    writer.big(std::uint32_t{0xA1B23C4D});
    writer.big(std::uint32_t{0x00020004});
    writer.zeros(8);
    writer.big(std::uint32_t{262144});
    writer.big(std::uint32_t{link});
    writer.big(std::uint32_t{5});
    writer.big(std::uint32_t{7});
    writer.big(static_cast<std::uint32_t>(frame.size()));
    writer.big(static_cast<std::uint32_t>(frame.size()));
    writer.bytes(frame);
    const auto file = packets_of(text_of(bytes));
    ASSERT_FALSE(file.summary.damage) << file.summary.damage->text;
    ASSERT_EQ(file.packets.size(), 1U);
    const auto& [packet, payload] = file.packets[0];
    EXPECT_EQ(packet.time, CaptureTime(5s + 7ns));
    EXPECT_EQ(packet.source, (enip::Endpoint{0x7F000001, 0x08AE}));
    EXPECT_EQ(packet.destination, (enip::Endpoint{0x7F000002, 0x08AF}));
    EXPECT_EQ(payload, octets("010203"));
}

INSTANTIATE_TEST_SUITE_P(LinkLayers, Dress,
                         testing::Values(std::pair{0U, "02000000"}, std::pair{0U, "00000002"},
                                         std::pair{1U, "000000000000 000000000000 0800"},
                                         std::pair{1U, "000000000000 000000000000 8100 0005 0800"},
                                         std::pair{1U, "000000000000 000000000000 88A8 0005 8100 0006 0800"},
                                         std::pair{12U, ""}, std::pair{101U, ""}, std::pair{108U, "00000002"},
                                         std::pair{228U, ""}, std::pair{113U, "0000 0304 0006 000000000000 0000 0800"},
                                         std::pair{276U, "0800 0000 00000001 0304 00 06 0000000000000000"}));

std::string little_pcap(const std::string& frame_hex, std::uint32_t extra_original = 0) {
    const auto frame = octets(frame_hex);
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    writer.u32(0xA1B2C3D4);
    writer.u32(0x00040002);
    writer.zeros(8);
    writer.u32(65535);
    writer.u32(101);
    writer.u32(1);
    writer.u32(2);
    writer.u32(static_cast<std::uint32_t>(frame.size()));
    writer.u32(static_cast<std::uint32_t>(frame.size()) + extra_original);
    writer.bytes(frame);
    return text_of(bytes);
}

TEST(CaptureFile, ReadsClassicPcapInMicroseconds) {
    const auto file = packets_of(little_pcap(ip_datagram));
    ASSERT_EQ(file.packets.size(), 1U);
    EXPECT_EQ(file.packets[0].packet.time, CaptureTime(1s + 2us));
}

TEST(CaptureFile, CountsWhatItDoesNotTake) {
    EXPECT_EQ(packets_of(little_pcap("60" + ip_datagram.substr(2))).summary.foreign, 1U) << "IPv6";
    EXPECT_EQ(packets_of(little_pcap("4500001F 00002000" + ip_datagram.substr(17))).summary.fragments, 1U);
    EXPECT_EQ(packets_of(little_pcap("4500001F 00004000 4001" + ip_datagram.substr(22))).summary.foreign, 1U) << "ICMP";
    EXPECT_EQ(packets_of(little_pcap(ip_datagram.substr(0, ip_datagram.size() - 2), 1)).summary.cut, 1U);
    EXPECT_EQ(packets_of(little_pcap(ip_datagram.substr(0, ip_datagram.size() - 2))).summary.malformed, 1U);
    EXPECT_EQ(packets_of(little_pcap("4400" + ip_datagram.substr(4))).summary.malformed, 1U) << "a header of 16 octets";
}

TEST(CaptureFile, ReadsBigEndianPcapngWithItsOptionsAndOtherBlocks) {
    const auto frame = octets(ip_datagram);
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    const auto block = [&](std::uint32_t type, const cip::Bytes& body) {
        writer.big(type);
        writer.big(static_cast<std::uint32_t>(body.size() + 12));
        writer.bytes(body);
        writer.big(static_cast<std::uint32_t>(body.size() + 12));
    };
    block(0x0A0D0D0A, octets("1A2B3C4D 0001 0000 FFFFFFFFFFFFFFFF"));
    // Milliseconds, counted from second 100: options 9 and 14.
    block(1, octets("0065 0000 00000000 0009 0001 03000000 000E 0008 0000000000000064 0000 0000"));
    block(1, octets("0065 0000 00000000 0009 0001 94000000"));  // 2^-20 s
    block(5, octets("00000000"));                               // statistics, passed over
    block(6, octets("00000000 00000000 000004D2 0000001F 0000001F" + ip_datagram + "00"));
    block(6, octets("00000001 00000000 00180000 0000001F 0000001F" + ip_datagram + "00"));
    block(2, octets("0000 0000 00000000 000004D2 0000001F 0000001F" + ip_datagram + "00"));
    block(3, octets("0000001F" + ip_datagram + "00"));
    const auto file = packets_of(text_of(bytes));
    ASSERT_FALSE(file.summary.damage) << file.summary.damage->text;
    ASSERT_EQ(file.packets.size(), 4U);
    EXPECT_EQ(file.packets[0].packet.time, CaptureTime(101s + 234ms));
    EXPECT_EQ(file.packets[1].packet.time, CaptureTime(1s + 500ms));
    EXPECT_EQ(file.packets[2].packet.time, CaptureTime(101s + 234ms));
    EXPECT_EQ(file.packets[3].payload, octets("010203"));
}

std::string damage_of(const std::string& text) {
    const auto summary = packets_of(text).summary;
    return summary.damage ? std::to_string(summary.damage->offset) + ": " + summary.damage->text : "";
}

TEST(CaptureFile, SaysWhatIsWrongAndWhere) {
    EXPECT_EQ(damage_of(""), "0: the file is empty");
    EXPECT_EQ(damage_of("abc"), "0: the file is too short for a capture");
    EXPECT_THAT(damage_of("hello, world"), HasSubstr("neither pcapng nor pcap"));
    EXPECT_THAT(damage_of(text_of(octets("1F 8B 08 00 00 00"))), HasSubstr("gunzip"));
    SampleCapture sample;
    sample.io(true, octets("01 02"));
    const auto good = sample.text();
    EXPECT_EQ(damage_of(good), "");
    auto bad = good;
    bad[44 + 4] = 0x03;  // the length of the interface's block
    EXPECT_EQ(damage_of(bad), "44: a block of 3 octets cannot be");
    bad = good;
    bad[44 + 28] = 0x24;
    EXPECT_EQ(damage_of(bad), "44: the two lengths of a block differ");
    bad = good;
    bad[76 + 8] = 1;
    EXPECT_EQ(damage_of(bad), "76: a packet names interface 1, which is not described");
    bad = good;
    bad[76 + 4 + 3] = 2;  // 32 MiB
    EXPECT_THAT(damage_of(bad), HasSubstr("76: a block of 33554"));
    auto pcap = little_pcap(ip_datagram);
    pcap[24 + 8 + 2] = 5;
    EXPECT_EQ(damage_of(pcap), "24: a packet of 327711 octets cannot be");
}

// Cut at each length, a file ends between two blocks or is damaged; never anything else, and never a packet too many.
TEST(CaptureFile, EndsWellWhereverItIsCut) {
    SampleCapture sample;
    sample.golden(6);
    for (const auto& text : {sample.text(), little_pcap(ip_datagram)}) {
        const auto whole = packets_of(text);
        std::size_t between = 0;
        for (std::size_t length = 0; length <= text.size(); ++length) {
            const auto part = packets_of(text.substr(0, length));
            EXPECT_LE(part.packets.size(), whole.packets.size());
            if (!part.summary.damage) {
                ++between;
            } else {
                EXPECT_LE(part.summary.damage->offset, length);
            }
        }
        // Behind the section header, the interface and each packet; behind the header of the file and each packet.
        EXPECT_EQ(between, whole.packets.size() + (text[0] == 0x0A ? 2 : 1));
    }
}

TEST(CaptureFile, SurvivesFlippedOctets) {
    SampleCapture sample;
    sample.golden(5);
    sample.golden(13);
    const auto good = sample.text();
    std::mt19937 random(4711);
    std::size_t damaged = 0;
    for (int round = 0; round < 2000; ++round) {
        auto bad = good;
        for (int flips = 0; flips < 1 + round % 8; ++flips) {
            bad[random() % bad.size()] = static_cast<char>(random());
        }
        const auto capture = test::read(bad);
        damaged += capture.summary.damage ? 1 : 0;
        for (const auto& open : capture.conversation.opens()) {
            const auto diagnosis = cli::diagnose(open, capture.conversation, capture.summary.last.value());
            EXPECT_FALSE(diagnosis.summary.empty());
        }
    }
    EXPECT_GT(damaged, 100U);
}

}  // namespace
}  // namespace servobus::scanner
