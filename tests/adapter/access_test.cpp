// Who may do what, on whatever way he comes: --read-only, --harden, --allow, and the lines that the log gets of it.
#include <gmock/gmock.h>

#include <random>

#include "adapter/access_file.hpp"
#include "adapter/access_gate.hpp"
#include "adapter/allow_list.hpp"
#include "cip/multiple_service.hpp"
#include "tests/adapter/io_site.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

using adapter::AllowList;
using adapter::Effect;
using adapter::LogLevel;
using adapter::LogLine;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

constexpr adapter::Protection read_only{.read_only = true};
constexpr adapter::Protection hardened{.harden = true};

// ------------------------------------------------------------------------------------------------------------ the ways

enum class Way : std::uint8_t { unconnected, class3, routed, part, part_in_class3, part_routed };
constexpr std::array ways{Way::unconnected, Way::class3, Way::routed, Way::part, Way::part_in_class3, Way::part_routed};

std::string_view name(Way way) {
    constexpr std::array<std::string_view, ways.size()> names{"unconnected",
                                                              "class 3",
                                                              "unconnected, Unconnected_Send",
                                                              "unconnected, Multiple_Service_Packet",
                                                              "class 3, Multiple_Service_Packet",
                                                              "unconnected, Unconnected_Send, Multiple_Service_Packet"};
    return names[static_cast<std::size_t>(way)];
}

/// A peer that sends requests on all ways, and gives back the answer to the request itself.
class Traveller {
public:
    explicit Traveller(Site& site) : peer_(registered(site)) { peer_.open_class3(); }

    Peer& peer() { return peer_; }

    std::string call(Way way, const cip::Bytes& request) {
        const bool is_part = way == Way::part || way == Way::part_in_class3 || way == Way::part_routed;
        auto message = is_part ? packet_of(request) : request;
        if (way == Way::routed || way == Way::part_routed) message = through_unconnected_send(message);
        const bool connected = way == Way::class3 || way == Way::part_in_class3;
        const auto reply =
            connected ? peer_.connected_call(peer_.connection(), ++sequence_, hex(message)) : peer_.call(message);
        return is_part ? part_of(octets(reply)) : reply;
    }
    std::string call(Way way, std::string_view request) { return call(way, octets(request)); }

private:
    static cip::Bytes packet_of(const cip::Bytes& request) {
        return cip::Request{0x0A, cip::Path::to(2, 1), cip::write_parts(std::span(&request, 1))}.encode();
    }
    static std::string part_of(const cip::Bytes& reply) {
        const auto response = cip::Response::parse(reply);
        if (!response) return "no response";
        const auto parts = cip::read_parts(response->data);
        if (!parts || parts->size() != 1) return "no part in " + hex(reply);
        const bool failed = (*parts)[0][2] != 0;
        EXPECT_EQ(response->status.general,
                  failed ? cip::GeneralStatus::embedded_service_error : cip::GeneralStatus::success);
        return hex((*parts)[0]);
    }

    Peer peer_;
    std::uint16_t sequence_ = 0;
};

struct Lines {
    std::vector<LogLine> all;

    adapter::LineSink sink(LogLevel lowest = LogLevel::trace) {
        return {lowest, [this](const LogLine& line) { all.push_back(line); }};
    }
    std::vector<std::string> texts() const {
        std::vector<std::string> list;
        for (const auto& line : all) list.push_back(to_text(line));
        return list;
    }
    std::string value(std::size_t index, std::string_view key) const {
        if (index >= all.size()) return "no such line";
        for (const auto& [name, text] : all[index].values) {
            if (name == key) return text;
        }
        return "no such value";
    }
};

// ----------------------------------------------------------------------------------------------------------- read-only

struct Change {
    const char* what;
    const char* request;
    const char* reply;  ///< when it is admitted
};
void PrintTo(const Change& each, std::ostream* out) { *out << each.what; }

constexpr auto changes = std::to_array<Change>({
    {"a parameter", "10 03 20 64 24 01 30 00 32 00 00 00", "90 00 00 00"},
    {"a parameter, its attribute left out", "10 02 20 64 24 01 32 00 00 00", "90 00 00 00"},
    {"a control word", "10 03 20 66 24 01 30 00 06 00", "90 00 00 00"},
    {"a direct command", "10 03 20 65 24 01 30 00 00 10 00 00", "90 00 00 00"},
    {"a list", "04 02 20 64 24 01 01 00 00 00 32 00 00 00", "84 00 00 00 01 00 00 00 00 00"},
    {"data of an assembly", "10 03 20 04 24 65 30 03 10 27 00 00 10 27 00 00 40 42 0F 00 14 00 00 00 06 00",
     "90 00 00 00"},
    {"a host name", "10 03 20 F5 24 01 30 06 03 00 61 62 63 00", "90 00 00 00"},
    {"the way to an address", "10 03 20 F5 24 01 30 03 00 00 00 00", "90 00 00 00"},
    {"a port", "10 03 20 F6 24 01 30 06 01 00 00 00", "90 00 00 00"},
    {"a DSCP value", "10 03 20 48 24 01 30 04 30", "90 00 00 00"},
    {"a counter", "10 03 20 06 24 01 30 01 00 00", "90 00 00 00"},
    {"a reset", "05 02 20 01 24 01 00", "85 00 00 00"},
    {"a reset without its type", "05 02 20 01 24 01", "85 00 00 00"},
    {"a value that is not legal", "10 03 20 64 24 01 30 00 00 00 00 00", "90 00 09 00"},
    {"an attribute that is read-only anyway", "10 03 20 66 24 01 30 01 00 00", "90 00 0E 00"},
});

class EachChange : public testing::TestWithParam<Change> {};
INSTANTIATE_TEST_SUITE_P(Access, EachChange, testing::ValuesIn(changes));

TEST_P(EachChange, IsRefusedByAReadOnlyDriveOnEveryWay) {
    for (const auto way : ways) {
        Site site;
        Traveller peer(site);
        site.adapter.protect(read_only);
        const auto request = octets(GetParam().request);
        auto refused = cip::Bytes{static_cast<std::uint8_t>(request[0] | 0x80), 0, 0x0F, 0};
        EXPECT_EQ(peer.call(way, request), hex(refused)) << name(way);
        site.advance(500ms);
        EXPECT_TRUE(peer.peer().open()) << name(way) << ": nothing was reset";
        EXPECT_EQ(peer.call(way, "0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00")) << name(way);
    }
}

// The test above could pass with a request that is wrong in itself.
TEST_P(EachChange, IsOrdinaryWithoutProtection) {
    for (const auto way : ways) {
        Site site;
        Traveller peer(site);
        EXPECT_EQ(peer.call(way, GetParam().request), hex(GetParam().reply)) << name(way);
    }
}

constexpr auto reads = std::to_array<Change>({
    {"a parameter", "0E 03 20 64 24 01 30 00", "8E 00 00 00 14 00 00 00"},
    {"a list", "03 02 20 64 24 01 01 00 00 00", "83 00 00 00 01 00 00 00 00 00 14 00 00 00"},
    {"who owns the drive", "5A 02 20 06 24 01 00 02 20 04 2C 65", "DA 00 00 00 00 00 00 00"},
    {"a class attribute", "0E 03 20 01 24 00 30 01", "8E 00 00 00 01 00"},
    {"an attribute that is not there", "0E 03 20 64 24 01 30 63", "8E 00 14 00"},
    {"a service that is not there", "4C 02 20 F6 24 01", "CC 00 08 00"},
    {"a class that is not there", "10 03 20 99 24 01 30 01 00", "90 00 05 00"},
    {"an upload of a file that is not there", "4B 02 20 37 24 C8 FF", "CB 00 16 00"},
});

TEST(ReadOnly, AnswersEverythingElseAsAlways) {
    for (const auto& protection : {adapter::Protection{}, read_only, hardened}) {
        Site site;
        Traveller peer(site);
        site.adapter.protect(protection);
        for (const auto& read : reads) {
            for (const auto way : ways) {
                EXPECT_THAT(peer.call(way, read.request), StartsWith(hex(read.reply)))
                    << read.what << ", " << name(way);
            }
        }
    }
}

/// The answers to a question about each attribute that the device has.
std::string everything(Peer& peer) {
    std::string all;
    const auto read = [&](unsigned class_id, unsigned instance, unsigned attribute) {
        all += peer.call(octets(fmt::format("0E 03 20 {:02X} 24 {:02X} 30 {:02X}", class_id, instance, attribute)));
        all += '\n';
    };
    for (const auto class_id :
         {0x01U, 0x06U, 0x37U, 0x47U, 0x48U, 0x64U, 0x65U, 0x66U, 0x67U, 0x68U, 0x69U, 0x6EU, 0xF5U, 0xF6U}) {
        for (unsigned attribute = 0; attribute < 0xC8; ++attribute) read(class_id, 1, attribute);
    }
    for (const auto point : owner_points) read(0x04, point, 3);
    return all;
}

/// Requests of all services to all classes, with data of all usual sizes.
void send_everything(Peer& peer, std::mt19937& random) {
    for (const auto class_id : {0x01U, 0x02U, 0x04U, 0x06U, 0x37U, 0x47U, 0x48U, 0x64U, 0x65U, 0x66U, 0x67U, 0x68U,
                                0x69U, 0x6EU, 0xF5U, 0xF6U}) {
        for (unsigned service = 1; service < 0x64; ++service) {
            for (const std::size_t size : {0U, 1U, 2U, 4U, 8U, 18U, 20U, 32U, 36U, 48U}) {
                const unsigned instance = class_id == 0x04 ? owner_points[random() % owner_points.size()] : 1;
                auto request = octets(fmt::format("{:02X} 03 20 {:02X} 24 {:02X} 30 {:02X}", service, class_id,
                                                  instance, class_id == 0x04 ? 3 : random() % 0xC8));
                for (std::size_t i = 0; i < size; ++i) {
                    request.push_back(static_cast<std::uint8_t>(random() % 4 == 0 ? random() : 0));
                }
                static_cast<void>(peer.call(request));
            }
        }
    }
}

// Not only what somebody has thought of: services by the hundred, seeded.
TEST(ReadOnly, NothingThatIsSentChangesAnything) {
    Site site;
    auto peer = registered(site);
    std::mt19937 random(1);
    site.adapter.protect(read_only);
    const auto before = everything(peer);
    for (int round = 0; round < 3; ++round) send_everything(peer, random);
    site.advance(1s);
    ASSERT_TRUE(peer.open());
    // The counters of the Connection Manager count what is asked, refused or not.
    const auto after = everything(peer);
    std::size_t differences = 0;
    for (std::size_t at = 0, line = 0; at < before.size(); ++line) {
        const auto end = before.find('\n', at);
        const bool is_counter = line >= 0xC8 && line < std::size_t{2} * 0xC8;
        differences += !is_counter && after.compare(at, end - at, before, at, end - at) != 0 ? 1 : 0;
        at = end + 1;
    }
    EXPECT_EQ(before.size(), after.size());
    EXPECT_EQ(differences, 0U);

    // The same without protection: what was sent could have changed something.
    Site open_site;
    auto open_peer = registered(open_site);
    std::mt19937 again(1);
    send_everything(open_peer, again);
    EXPECT_NE(everything(open_peer), before);
}

TEST(ReadOnly, OwnersAreRefusedWithTheirTriadAndOnlookersAreNot) {
    IoSite site;
    site.adapter.protect(read_only);
    IoPeer peer(site);
    std::uint16_t serial = 0;
    for (const auto point : owner_points) {
        for (const bool large : {false, true}) {
            auto open = io_open(++serial, point);
            open.large = large;
            const auto answer = peer.call(request_of(open));
            EXPECT_EQ(answer,
                      hex(fmt::format("{} 00 0F 00 {:02X} 00 4D 00 44 33 22 11 00 00", large ? "DB" : "D4", serial)))
                << point;
            EXPECT_EQ(peer.call(through_unconnected_send(request_of(open))), answer) << point;
        }
    }
    EXPECT_EQ(site.adapter.io().size(), 0U);
    EXPECT_EQ(site.counter(adapter::Counter::open_requests), 20);
    EXPECT_EQ(site.counter(adapter::Counter::open_other_rejects), 20);

    const auto looker = peer.must_open(multicast(io_open(100, 254, 100)));
    const auto listener = peer.must_open(multicast(io_open(101, 255, 100)));
    peer.must_open(io_open(102, 254, 105));
    EXPECT_EQ(site.adapter.io().size(), 3U);
    peer.send(heartbeat(looker, 1));
    site.advance(20ms);
    EXPECT_FALSE(site.take().empty()) << "and they get their data";
    EXPECT_EQ(peer.close(listener), closed(listener.request.triad));
}

TEST(ReadOnly, AnOpenThatIsWrongInItselfSaysWhatIsWrong) {
    IoSite site;
    site.adapter.protect(read_only);
    IoPeer peer(site);
    auto open = io_open(1);
    open.o_to_t.size = 99;
    EXPECT_EQ(peer.refusal(open), hex("01 02 27 01 18 00"));
    open = io_open(2);
    open.path = octets("20 04 24 01 2C 65");
    EXPECT_THAT(peer.refusal(open), StartsWith("01 "));
    EXPECT_EQ(hex(cip::ByteView(peer.ask(octets("54 02 20 06 24 01 0A 0E")).message).first(4)), hex("D4 00 13 00"));
}

// --------------------------------------------------------------------------------------------------------------- harden

TEST(Harden, RefusesResetsAndNetworkSettingsOnEveryWay) {
    constexpr auto refused = std::to_array<const char*>({
        "05 02 20 01 24 01 00",
        "05 02 20 01 24 01 01",
        "10 03 20 F5 24 01 30 03 00 00 00 00",
        "10 03 20 F5 24 01 30 06 03 00 61 62 63 00",
        "10 03 20 F5 24 01 30 0D 78 00",
        "10 03 20 F6 24 02 30 06 01 00 00 00",
        "10 03 20 48 24 01 30 04 30",
        "10 03 20 65 24 01 30 BB 07 02 A8 C0",
    });
    for (const auto way : ways) {
        Site site;
        Traveller peer(site);
        site.adapter.protect(hardened);
        for (const auto* text : refused) {
            const auto request = octets(text);
            EXPECT_EQ(peer.call(way, request),
                      hex(cip::Bytes{static_cast<std::uint8_t>(request[0] | 0x80), 0, 0x0F, 0}))
                << text << ", " << name(way);
        }
        EXPECT_EQ(peer.call(way, "10 03 20 64 24 01 30 00 32 00 00 00"), hex("90 00 00 00")) << name(way);
        EXPECT_EQ(peer.call(way, "10 03 20 06 24 01 30 01 00 00"), hex("90 00 00 00")) << name(way);
        site.advance(1s);
        EXPECT_TRUE(peer.peer().open());
    }
}

TEST(Harden, WhatAnOwnerHasNobodyElseSets) {
    IoSite site;
    site.adapter.protect(hardened);
    IoPeer owner(site);
    IoPeer other(site, 0xC0A80202);
    const auto* controlword = "10 03 20 66 24 01 30 00 06 00";
    const auto* speed = "10 03 20 66 24 01 30 41 10 27 00 00";
    const auto* window = "10 03 20 66 24 01 30 25 10 27 00 00";  // in no assembly
    EXPECT_EQ(other.call(controlword), hex("90 00 00 00")) << "nobody owns anything yet";
    const auto link = owner.must_open(io_open(1, 101));
    for (auto* peer : {&owner, &other}) {
        EXPECT_EQ(peer->call(controlword), hex("90 00 0F 00"));
        EXPECT_EQ(peer->call(speed), hex("90 00 0F 00"));
        EXPECT_EQ(peer->call(window), hex("90 00 00 00"));
        EXPECT_EQ(peer->call("10 03 20 04 24 66 30 03 00"), hex("90 00 0E 00")) << "assemblies as always";
    }
    EXPECT_EQ(owner.close(link), closed(link.request.triad));
    EXPECT_EQ(other.call(controlword), hex("90 00 00 00"));
}

TEST(Harden, ASecondAddressOfAnOwnedVariableIsTheSameVariable) {
    IoSite site;
    site.adapter.protect(hardened);
    IoPeer peer(site);
    const auto* acceleration = "10 03 20 65 24 01 30 47 40 42 0F 00";  // AC, a second address of 0x66/0x43
    EXPECT_EQ(peer.call(acceleration), hex("90 00 00 00"));
    peer.must_open(io_open(1, 101));
    EXPECT_EQ(peer.call(acceleration), hex("90 00 0F 00"));
}

TEST(Harden, OfAListTheOwnedEntriesAreRefusedAndTheOthersSet) {
    IoSite site;
    site.adapter.protect(hardened);
    IoPeer peer(site);
    peer.must_open(io_open(1, 101));
    // SP, in assembly 101, and DP, in none.
    EXPECT_EQ(peer.call("04 02 20 66 24 01 02 00 41 00 10 27 00 00 25 00 11 27 00 00"),
              hex("84 00 0A 00 02 00 41 00 0F 00 25 00 00 00"));
    EXPECT_EQ(peer.call("0E 03 20 66 24 01 30 25"), hex("8E 00 00 00 11 27 00 00"));
    EXPECT_EQ(peer.call("0E 03 20 66 24 01 30 41"), hex("8E 00 00 00 A0 86 01 00"));
}

TEST(Harden, AndReadOnlyTogetherRefuseBoth) {
    IoSite site;
    site.adapter.protect({.read_only = true, .harden = true});
    IoPeer peer(site);
    EXPECT_EQ(peer.refusal(io_open(1)), hex("0F 00"));
    EXPECT_EQ(peer.call("05 02 20 01 24 01 00"), hex("85 00 0F 00"));
    EXPECT_EQ(peer.call("0E 03 20 64 24 01 30 00"), hex("8E 00 00 00 14 00 00 00"));
}

TEST(Policy, AServiceThatNobodyKnowsChangesSomething) {
    EXPECT_EQ(adapter::effect_of(0x0E, 0x64), Effect::reads);
    EXPECT_EQ(adapter::effect_of(0x4B, 0x37), Effect::reads);
    EXPECT_EQ(adapter::effect_of(0x4B, 0x47), Effect::changes);
    EXPECT_EQ(adapter::effect_of(0x54, 0x06), Effect::opens);
    EXPECT_EQ(adapter::effect_of(0x54, 0x64), Effect::changes);
    EXPECT_EQ(adapter::effect_of(0x50, 0x37), Effect::changes);
    EXPECT_EQ(adapter::effect_of(0x15, 0x01), Effect::changes);
    EXPECT_EQ(adapter::effect_of(0x0A, 0x02), Effect::carries);
}

// ------------------------------------------------------------------------------------------------------------ the lines

TEST(AccessLines, TellWhoWhatAndHowItEnded) {
    Site site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    auto peer = registered(site);
    EXPECT_EQ(peer.call("10 03 20 66 24 01 30 41 10 27 00 00"), hex("90 00 00 00"));
    EXPECT_EQ(peer.call("10 03 20 64 24 01 30 00 00 00 00 00"), hex("90 00 09 00"));
    EXPECT_EQ(peer.call("10 03 20 F5 24 01 30 06 03 00 61 62 63 00"), hex("90 00 00 00"));
    const auto who = fmt::format("peer=192.168.2.1:50000 session=0x{:08X} via=unconnected ", peer.session());
    EXPECT_THAT(
        lines.texts(),
        ElementsAre("access granted " + who +
                        "service=Set_Attribute_Single path=\"class 0x66, instance 0x01, attribute 0x41\" "
                        "name=drive.SpeedJogOrProfilePositionMode value=\"10 27 00 00\" result=\"0x00 success\"",
                    "access refused " + who +
                        "service=Set_Attribute_Single path=\"class 0x64, instance 0x01, attribute 0x00\" "
                        "name=general.SCurve value=\"00 00 00 00\" result=\"0x09 invalid attribute value\"",
                    "access granted " + who +
                        "service=Set_Attribute_Single path=\"class 0xF5, instance 0x01, attribute 0x06\" "
                        "name=\"TCP/IP Interface.Host Name\" value=\"03 00 61 62 63 00\" result=\"0x00 success\""));
    EXPECT_EQ(lines.all[0].level, LogLevel::info);
    EXPECT_EQ(lines.all[1].level, LogLevel::warning);
}

TEST(AccessLines, SayOnWhichWay) {
    Site site;
    Traveller peer(site);
    Lines lines;
    site.adapter.on_access(lines.sink());
    for (const auto way : ways) peer.call(way, "10 03 20 64 24 01 30 00 32 00 00 00");
    ASSERT_THAT(lines.all, SizeIs(ways.size())) << "one line each, also when it comes in something";
    for (std::size_t i = 0; i < ways.size(); ++i) EXPECT_EQ(lines.value(i, "via"), name(ways[i]));
}

TEST(AccessLines, SayWhyTheDriveIsProtected) {
    Site site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    site.adapter.protect(read_only);
    auto peer = registered(site);
    EXPECT_EQ(peer.call("05 02 20 01 24 01 00"), hex("85 00 0F 00"));
    EXPECT_EQ(peer.call(request_of(io_open(1))), hex("D4 00 0F 00 01 00 4D 00 44 33 22 11 00 00"));
    ASSERT_THAT(lines.all, SizeIs(2));
    EXPECT_EQ(lines.value(0, "service"), "Reset");
    EXPECT_EQ(lines.value(0, "result"), "0x0F privilege violation");
    EXPECT_EQ(lines.value(0, "why"), "the drive is read-only");
    EXPECT_EQ(lines.value(1, "service"), "Forward_Open");
    EXPECT_EQ(lines.value(1, "why"), "the drive is read-only, and this connection carries data to it");
    EXPECT_EQ(lines.all[1].level, LogLevel::warning);
    // The reason is of that request alone.
    site.adapter.protect({});
    EXPECT_EQ(peer.call("10 03 20 64 24 01 30 00 00 00 00 00"), hex("90 00 09 00"));
    EXPECT_EQ(lines.value(2, "why"), "no such value");
}

TEST(AccessLines, OfAListEachEntryHasItsOwn) {
    Site site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    auto peer = registered(site);
    // SCurve, one that is read-only, and one that nobody knows.
    EXPECT_EQ(peer.call("04 02 20 64 24 01 03 00 00 00 32 00 00 00 04 00 01 63 00 00"),
              hex("84 00 0A 00 03 00 00 00 00 00 04 00 0E 00 63 00 14 00"));
    ASSERT_THAT(lines.all, SizeIs(3));
    EXPECT_EQ(lines.value(0, "name"), "general.SCurve");
    EXPECT_EQ(lines.value(0, "value"), "32 00 00 00");
    EXPECT_EQ(lines.value(1, "result"), "0x0E attribute not settable");
    EXPECT_EQ(lines.value(2, "path"), "class 0x64, instance 0x01, attribute 0x63");
    EXPECT_EQ(lines.value(2, "result"), "0x14 attribute not supported");
    // One that is wrong as a whole is one line.
    EXPECT_EQ(peer.call("04 02 20 64 24 01 03 00"), hex("84 00 13 00"));
    ASSERT_THAT(lines.all, SizeIs(4));
    EXPECT_EQ(lines.value(3, "path"), "class 0x64, instance 0x01");
}

TEST(AccessLines, WhateverIsWrongWithARequestIsToldToo) {
    Site site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    auto peer = registered(site);
    for (const auto* request : {
             "10 03 20 99 24 01 30 01 00",     // no such class
             "10 03 20 01 24 01 30 01 00",     // a service that Identity does not have
             "10 03 20 64 24 01 30 63 00",     // no such attribute
             "10 03 20 64 24 01 FF 00 00",     // a path that is none
             "10 0A 20 64",                    // a path that ends early
             "10 03 20 64 24 01 30 00 32 00",  // too short
             "4C 02 20 F6 24 01",              // a service that nobody knows
         }) {
        static_cast<void>(peer.call(request));
    }
    ASSERT_THAT(lines.all, SizeIs(7));
    for (const auto& line : lines.all) {
        EXPECT_EQ(line.event, "access refused");
        EXPECT_EQ(line.level, LogLevel::warning);
    }
    EXPECT_EQ(lines.value(3, "path"), "20 64 24 01 FF 00");
    EXPECT_EQ(lines.value(6, "service"), "0x4C");
}

TEST(AccessLines, ReadsAreNotTold) {
    Site site;
    Traveller peer(site);
    Lines lines;
    site.adapter.on_access(lines.sink());
    for (const auto& read : reads) {
        if (read.request[0] == '1' || read.request[1] == 'C') continue;  // a Set, and an unknown service
        for (const auto way : ways) peer.call(way, read.request);
    }
    EXPECT_THAT(lines.texts(), IsEmpty());
}

TEST(AccessLines, ALongValueIsCutAndCounted) {
    Site site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    auto peer = registered(site);
    peer.call("10 03 20 04 24 68 30 03 " + hex(cip::Bytes(36)));
    ASSERT_THAT(lines.all, SizeIs(1));
    EXPECT_EQ(lines.value(0, "name"), "Assembly.Data");
    EXPECT_EQ(lines.value(0, "value"), hex(cip::Bytes(adapter::shown_octets)) + " ... (36 octets)");
}

TEST(AccessLines, ConnectionsAreForThoseWhoWantAll) {
    IoSite site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    EXPECT_EQ(peer.refusal(io_open(2)), hex("01 01 06 01"));
    peer.close(link);
    ASSERT_THAT(lines.all, SizeIs(3));
    for (const auto& line : lines.all) EXPECT_EQ(line.level, LogLevel::debug);
    EXPECT_EQ(lines.value(1, "result"), "0x01 connection failure, 0x0106 ownership conflict");
    EXPECT_EQ(lines.value(2, "service"), "Forward_Close");
    Lines fewer;
    site.adapter.on_access(fewer.sink(LogLevel::info));
    peer.must_open(io_open(3));
    EXPECT_THAT(fewer.all, IsEmpty());
}

TEST(AccessLines, AFloodIsAFewLinesAndACount) {
    Site site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    auto peer = registered(site);
    const auto* wrong = "10 03 20 64 24 01 30 00 00 00 00 00";
    for (std::size_t i = 0; i < adapter::access_lines_per_second; ++i) peer.call(wrong);
    EXPECT_THAT(lines.all, SizeIs(adapter::access_lines_per_second)) << "the limit itself is no flood";
    for (int i = 0; i < 480; ++i) peer.call(wrong);
    EXPECT_THAT(lines.all, SizeIs(adapter::access_lines_per_second));
    peer.call("10 03 20 64 24 01 30 00 32 00 00 00");
    EXPECT_EQ(lines.all.back().event, "access granted") << "refusals do not hide changes";
    const auto before = lines.all.size();
    site.advance(999ms);
    EXPECT_THAT(lines.all, SizeIs(before));
    site.advance(1ms);
    ASSERT_THAT(lines.all, SizeIs(before + 1)) << "also when nothing more comes";
    EXPECT_EQ(to_text(lines.all.back()), "access lines left out kind=refusal lines=480");
    EXPECT_EQ(lines.all.back().level, LogLevel::warning);
    peer.call(wrong);
    EXPECT_EQ(lines.all.back().event, "access refused") << "a new second";
}

// The limit counts true seconds, also when the time of the bus has stood still and is behind for ever.
TEST(AccessLines, AFloodAfterAFreezeIsOneToo) {
    Site site;
    ASSERT_TRUE(site.adapter.inject(adapter::NetworkFault(adapter::fault::Freeze{10}), site.now));
    site.advance(10s);
    Lines lines;
    site.adapter.on_access(lines.sink());
    auto peer = registered(site);
    for (int i = 0; i < 90; ++i) {
        peer.call("10 03 20 64 24 01 30 00 00 00 00 00");
        site.adapter.on_timer(site.now);
        site.now += 10ms;
    }
    EXPECT_THAT(lines.all, SizeIs(adapter::access_lines_per_second));
    site.advance(200ms);
    EXPECT_EQ(to_text(lines.all.back()), "access lines left out kind=refusal lines=70");
}

TEST(AccessLines, WhatIsLeftIsToldAtTheEnd) {
    Site site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    auto peer = registered(site);
    for (std::size_t i = 0; i < adapter::access_lines_per_second + 7; ++i)
        peer.call("10 03 20 64 24 01 30 00 00 00 00 00");
    site.adapter.shut_down();
    EXPECT_EQ(to_text(lines.all.back()), "access lines left out kind=refusal lines=7");
}

TEST(AccessLines, NothingIsWrittenForNobody) {
    adapter::AccessLog log;
    int made = 0;
    const auto make = [&] {
        ++made;
        return LogLine{};
    };
    log.note(adapter::AccessLog::Kind::refusal, enip::Time{}, make);
    EXPECT_EQ(made, 0);
    Lines lines;
    log.listen(lines.sink(LogLevel::error));
    log.note(adapter::AccessLog::Kind::refusal, enip::Time{}, make);
    EXPECT_EQ(made, 0) << "a level that the log does not show";
    log.listen(lines.sink(LogLevel::warning));
    log.note(adapter::AccessLog::Kind::refusal, enip::Time{}, make);
    log.note(adapter::AccessLog::Kind::change, enip::Time{}, make);
    EXPECT_EQ(made, 1);
}

TEST(LogLines, ValuesThatAreNotPlainAreQuoted) {
    LogLine line{.event = "x",
                 .values = {{"a", "192.168.2.1:80"}, {"b", ""}, {"c", "two words"}, {"d", "\"\\\n\xFF"}, {"e", "a=b"}}};
    EXPECT_EQ(to_text(line), R"(x a=192.168.2.1:80 b="" c="two words" d="\"\\\x0A\xFF" e="a=b")");
    using namespace std::chrono;
    const auto time = sys_days(year(2026) / 11 / 26) + 9h + 31min + 39s + 123ms;
    EXPECT_EQ(adapter::to_json(line, time),
              R"({"time":"2026-11-26T09:31:39.123Z","level":"info","event":"x","a":"192.168.2.1:80","b":"",)"
              "\"c\":\"two words\",\"d\":\"\\\"\\\\\\n\xEF\xBF\xBD\",\"e\":\"a=b\"}");
}

// ------------------------------------------------------------------------------------------------------- who may be here

AllowList list_of(std::initializer_list<std::string_view> words) {
    AllowList list;
    for (const auto word : words) list.add(std::get<AllowList::Network>(AllowList::parse(word)));
    return list;
}

TEST(AllowList, TakesNetworksAndAddresses) {
    EXPECT_EQ(std::get<AllowList::Network>(AllowList::parse("192.168.2.0/24")),
              (AllowList::Network{0xC0A80200, 0xFFFFFF00}));
    EXPECT_EQ(std::get<AllowList::Network>(AllowList::parse("192.168.2.7")),
              (AllowList::Network{0xC0A80207, 0xFFFFFFFF}));
    EXPECT_EQ(std::get<AllowList::Network>(AllowList::parse("0.0.0.0/0")), (AllowList::Network{0, 0}));
    for (const auto* wrong :
         {"", "192.168.2", "192.168.2.0/", "192.168.2.0/33", "192.168.2.0/-1", "192.168.2.256", "192.168.2.0.1",
          "192.168.2.0/24x", " 192.168.2.0/24", "localhost", "192.168.2.0/024", "::1", "1.2.3.4/2 4", "+1.2.3.4"}) {
        const auto parsed = AllowList::parse(wrong);
        const auto* reason = std::get_if<std::string>(&parsed);
        ASSERT_NE(reason, nullptr) << wrong;
        EXPECT_THAT(*reason, HasSubstr("is no IPv4 network; write it as"));
    }
    EXPECT_EQ(std::get<std::string>(AllowList::parse("192.168.2.7/24")),
              "'192.168.2.7/24' has host bits; the network is 192.168.2.0/24");
}

TEST(AllowList, PermitsWhoIsInIt) {
    EXPECT_TRUE(AllowList().permits(0x01020304)) << "an empty one has everybody";
    const auto list = list_of({"192.168.2.0/24", "10.0.0.5"});
    for (const auto address : {0xC0A80200U, 0xC0A802FFU, 0x0A000005U}) EXPECT_TRUE(list.permits(address));
    for (const auto address : {0xC0A801FFU, 0xC0A80300U, 0x0A000004U, 0x7F000001U, 0U}) {
        EXPECT_FALSE(list.permits(address)) << "also loopback, unless it is listed";
    }
    EXPECT_TRUE(list_of({"0.0.0.0/0"}).permits(0x7F000001));
    EXPECT_TRUE(list_of({"127.0.0.0/8"}).permits(0x7F000001));
}

constexpr enip::Endpoint friend_of_ours{0xC0A80201, 50000};
constexpr enip::Endpoint stranger{0x0A000009, 50000};

TEST(Strangers, AreNotConnected) {
    Site site;
    Lines lines;
    site.adapter.on_access(lines.sink());
    site.adapter.allow(list_of({"192.168.2.0/24"}));
    EXPECT_FALSE(site.adapter.on_open(stranger, Site::local, site.now));
    EXPECT_TRUE(site.adapter.on_open(friend_of_ours, Site::local, site.now));
    EXPECT_THAT(lines.texts(), ElementsAre("stranger refused peer=10.0.0.9:50000 via=\"TCP connection\" why=\"not in "
                                           "the list of those who are allowed\""));
    EXPECT_EQ(lines.all[0].level, LogLevel::warning);
    EXPECT_EQ(site.adapter.strangers().connections, 1U);
    EXPECT_EQ(site.adapter.tcp_connections(), 1U);
}

TEST(Strangers, GetNoDatagramBack) {
    Site site;
    site.adapter.allow(list_of({"192.168.2.0/24"}));
    const auto list_identity = octets(frame("63 00"));
    for (const bool broadcast : {false, true}) {
        site.adapter.on_datagram(stranger, Site::local, broadcast, list_identity, site.now);
        site.advance(66s);
        EXPECT_THAT(site.adapter.take_datagrams(), IsEmpty());
        site.adapter.on_datagram(friend_of_ours, Site::local, broadcast, list_identity, site.now);
        site.advance(66s);
        EXPECT_THAT(site.adapter.take_datagrams(), SizeIs(1));
    }
    EXPECT_EQ(site.adapter.strangers().requests, 2U);
}

// Even one that knows the connection's id: with the address of another it would count as a wrong source, and its own
// originator may have been allowed when it came.
TEST(Strangers, AreNotListenedTo) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.send(o_to_t(link, 1, 1, run, cip::Bytes(18)));
    EXPECT_EQ(site.adapter.io().all()[0]->consumer.counters().accepted, 1U);
    site.adapter.allow(list_of({"192.168.3.0/24"}));
    Lines lines;
    site.adapter.on_access(lines.sink());
    for (std::uint32_t i = 2; i < 102; ++i)
        peer.send(o_to_t(link, i, static_cast<std::uint16_t>(i), run, cip::Bytes(18)));
    EXPECT_EQ(site.adapter.io().all()[0]->consumer.counters().accepted, 1U);
    EXPECT_EQ(site.adapter.strangers().datagrams, 100U);
    EXPECT_THAT(lines.all, SizeIs(adapter::access_lines_per_second));
    site.advance(2s);
    EXPECT_EQ(to_text(lines.all.back()), "access lines left out kind=stranger lines=80");
}

}  // namespace
}  // namespace servobus::test
