// R-DLR: what a node of a ring makes of what its two ports hear, octet by octet, in virtual time.
#include "adapter/ring_node.hpp"

#include <random>

#include "adapter/dlr_object.hpp"
#include "cip/wire.hpp"
#include "tests/support/golden.hpp"
#include "tests/support/octets.hpp"

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;
using test::hex;

constexpr MacAddress own{0x02, 0x00, 0x00, 0x00, 0x00, 0x64};
constexpr MacAddress supervisor{0x02, 0x00, 0x00, 0x00, 0x00, 0x01};
constexpr MacAddress lower{0x02, 0x00, 0x00, 0x00, 0x00, 0x00};
constexpr MacAddress higher{0x02, 0x00, 0x00, 0x00, 0x00, 0x02};
constexpr std::uint32_t own_address = 0xC0A80264;
constexpr std::uint32_t supervisor_address = 0xC0A80201;
constexpr auto beacon_timeout = 1960us;

cip::Bytes golden(std::string_view name) {
    const auto* vector = test::find_golden_vector(name);
    return vector != nullptr ? vector->octets : cip::Bytes{};
}

class Ring : public testing::Test {
protected:
    Ring() {
        network_.mac = own;
        network_.interface.address = own_address;
    }

    void hear(std::size_t port, const cip::Bytes& octets) { node_.on_frame(port, {.octets = octets}, now_); }
    void beacon(std::size_t port, RingState state = RingState::normal, std::uint8_t precedence = 0,
                const MacAddress& source = supervisor) {
        const auto content = Beacon{state, precedence, 400, 1960}.encode();
        hear(port, RingFrame{.destination = ring_beacon_mac,
                             .source = source,
                             .type = RingFrameType::beacon,
                             .source_address = supervisor_address,
                             .sequence = sequence_++,
                             .content = content}
                       .encode());
    }
    void beacons(RingState state = RingState::normal, std::uint8_t precedence = 0,
                 const MacAddress& source = supervisor) {
        beacon(0, state, precedence, source);
        beacon(1, state, precedence, source);
    }
    void from_supervisor(std::size_t port, RingFrameType type, const cip::Bytes& content = {}) {
        hear(port, RingFrame{.source = supervisor,
                             .type = type,
                             .source_address = supervisor_address,
                             .sequence = sequence_++,
                             .content = content}
                       .encode());
    }
    void run(std::chrono::microseconds duration) {
        const auto end = now_ + duration;
        while (const auto next = node_.next_deadline()) {
            if (*next > end) break;
            now_ = std::max(now_, *next);
            node_.on_timer(now_);
        }
        now_ = end;
    }
    // What is sent: the port and the octets up to the padding.
    std::vector<std::string> sent() {
        std::vector<std::string> list;
        for (const auto& frame : node_.take_frames()) {
            EXPECT_GE(frame.octets.size(), 60U);
            list.push_back(std::to_string(frame.port + 1) + ": " + hex(frame.octets));
        }
        return list;
    }
    // The frame that the node would send: with tag, padded.
    static std::string frame(std::string_view destination, std::string_view rest, std::size_t size = 64) {
        auto octets = test::octets(destination);
        const auto behind = test::octets(rest);
        octets.insert(octets.end(), own.begin(), own.end());
        octets.insert(octets.end(), behind.begin(), behind.end());
        octets.resize(size);
        return hex(octets);
    }
    std::string attribute(std::uint32_t id) {
        cip::Bytes value;
        cip::Writer writer(value);
        EXPECT_EQ(DlrObject(network_.ring).get(1, id, writer), cip::Status{});
        return hex(value);
    }
    void expect(std::string_view topology, std::string_view status, std::string_view active) {
        EXPECT_EQ(attribute(1), topology);
        EXPECT_EQ(attribute(2), status);
        EXPECT_EQ(attribute(10), active);
    }
    void expect_idle() { expect("00", "00", "00 00 00 00 00 00 00 00 00 00"); }
    void expect_fault() { expect("01", "01", "01 02 A8 C0 02 00 00 00 00 01"); }
    void expect_normal() { expect("01", "00", "01 02 A8 C0 02 00 00 00 00 01"); }

    NetworkState network_;
    RingNode node_{network_};
    enip::Time now_{1h};
    std::uint32_t sequence_ = 1;
};

using Frames = std::vector<std::string>;

TEST_F(Ring, IsALineWithoutBeacons) {
    expect_idle();
    EXPECT_EQ(node_.next_deadline(), std::nullopt);
}

TEST_F(Ring, ClosesWhenBothPortsHearANormalRing) {  // R-DLR-5, with the golden beacon
    const auto octets = golden("dlr_beacon");
    hear(0, octets);
    expect_fault();
    hear(0, octets);
    expect_fault();
    hear(1, octets);
    expect_normal();
    EXPECT_TRUE(sent().empty()) << "a node says nothing of itself";
}

TEST_F(Ring, BeaconsAreReadWithAndWithoutTheirTag) {
    auto untagged = golden("dlr_beacon");
    untagged.erase(untagged.begin() + 12, untagged.begin() + 16);
    hear(0, untagged);
    hear(1, golden("dlr_beacon"));
    expect_normal();
}

TEST_F(Ring, ABeaconThatSaysFaultOpensIt) {
    beacons();
    beacon(1, RingState::fault);
    expect_fault();
    beacon(0);
    expect_fault();
    beacon(1);
    expect_normal();
}

TEST_F(Ring, SilenceOfOnePortIsAFaultAndOfBothIsALine) {
    beacons();
    run(1000us);
    beacon(0);
    run(beacon_timeout - 1001us);
    expect_normal();
    run(1us);
    expect_fault();
    beacon(0);
    run(beacon_timeout - 1us);
    expect_fault();
    run(1us);
    expect_idle();
    EXPECT_EQ(node_.next_deadline(), std::nullopt);
}

TEST_F(Ring, TheSupervisorChoosesTheTimeout) {
    const auto content = Beacon{RingState::normal, 0, 100'000, 500'000}.encode();
    for (const std::size_t port : {0U, 1U}) from_supervisor(port, RingFrameType::beacon, content);
    run(499ms);
    expect_normal();
    run(1ms);
    expect_idle();
}

TEST_F(Ring, LinkLossIsToldToTheSupervisor) {  // R-DLR-5, R-DLR-10
    beacons();
    node_.on_link(1, false, now_);
    expect_fault();
    EXPECT_EQ(sent(),
              (Frames{"1: " + frame("02 00 00 00 00 01", "81 00 E0 00 80 E1 02 01 04 00 C0 A8 02 64 00 00 00 00 01")}));
    node_.on_link(1, true, now_);
    expect_fault();
    beacon(1);
    expect_normal();
    node_.on_link(0, false, now_);
    EXPECT_EQ(sent(),
              (Frames{"2: " + frame("02 00 00 00 00 01", "81 00 E0 00 80 E1 02 01 04 00 C0 A8 02 64 00 00 00 01 02")}));
    node_.on_link(1, false, now_);
    expect_idle();
    EXPECT_TRUE(sent().empty()) << "there is no way left";
}

TEST_F(Ring, HigherPrecedenceWinsThenTheHigherMac) {  // R-DLR-5
    beacons(RingState::normal, 5);
    beacon(0, RingState::normal, 4, higher);
    beacon(0, RingState::normal, 5, lower);
    expect_normal();
    beacon(0, RingState::normal, 5, higher);
    expect("01", "01", "01 02 A8 C0 02 00 00 00 00 02");
    beacon(1, RingState::normal, 5, supervisor);
    expect("01", "01", "01 02 A8 C0 02 00 00 00 00 02");
    beacon(1, RingState::normal, 5, higher);
    expect("01", "00", "01 02 A8 C0 02 00 00 00 00 02");
    beacon(0, RingState::normal, 6, lower);
    expect("01", "01", "01 02 A8 C0 02 00 00 00 00 00");
    EXPECT_EQ(network_.ring.supervisor_precedence, 6);
}

TEST_F(Ring, AfterALineAnySupervisorIsTaken) {
    beacons(RingState::normal, 5);
    run(beacon_timeout);
    beacons(RingState::normal, 1, lower);
    expect("01", "00", "01 02 A8 C0 02 00 00 00 00 00");
}

TEST_F(Ring, OwnFramesThatComeRoundDoNotCount) {
    beacons(RingState::normal, 0, own);
    expect_idle();
}

TEST_F(Ring, SignOnGoesOnWithTheNodeInIt) {  // R-DLR-10, with the golden frame
    beacons();
    hear(0, golden("dlr_sign_on"));
    EXPECT_EQ(sent(), (Frames{"2: " + frame("01 21 6C 00 00 02",
                                            "81 00 E0 00 80 E1 02 01 07 02 C0 A8 02 01 00 00 10 03 00 02 "
                                            "02 00 00 00 00 01 C0 A8 02 01 02 00 00 00 00 64 C0 A8 02 64")}));
    hear(1, golden("dlr_sign_on"));
    EXPECT_THAT(sent(), testing::ElementsAre(testing::StartsWith("1: ")));
}

TEST_F(Ring, SignOnCountsInAClosedRingOnly) {
    hear(0, golden("dlr_sign_on"));
    beacon(0);
    hear(0, golden("dlr_sign_on"));
    EXPECT_TRUE(sent().empty());
}

TEST_F(Ring, AFullSignOnGoesBackToTheSupervisor) {  // R-DLR-11
    beacons();
    std::vector<SignOnEntry> entries(max_sign_on_entries - 1);
    for (std::size_t i = 0; i < entries.size(); ++i) entries[i].mac[5] = static_cast<std::uint8_t>(0x80 + i);
    from_supervisor(0, RingFrameType::sign_on, encode_sign_on(entries));
    auto frames = node_.take_frames();
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].port, 1U);
    EXPECT_EQ(frames[0].octets.size(), 1512U);
    entries.emplace_back().mac[0] = 1;
    from_supervisor(0, RingFrameType::sign_on, encode_sign_on(entries));
    frames = node_.take_frames();
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(frames[0].port, 0U);
    const auto parsed = RingFrame::parse(frames[0].octets);
    ASSERT_TRUE(parsed);
    EXPECT_EQ(parsed->destination, supervisor);
    EXPECT_EQ(parse_sign_on(parsed->content).value(), entries);
    entries.emplace_back();
    from_supervisor(0, RingFrameType::sign_on, encode_sign_on(entries));
    EXPECT_TRUE(node_.take_frames().empty()) << "more than a frame can hold";
}

TEST_F(Ring, ASignOnThatHasBeenHereEnds) {
    beacons();
    from_supervisor(0, RingFrameType::sign_on, encode_sign_on({{supervisor, supervisor_address}, {own, own_address}}));
    EXPECT_TRUE(sent().empty());
}

TEST_F(Ring, NeighborCheckIsAnsweredInAFault) {  // R-DLR-10, with the golden request
    hear(0, golden("dlr_neighbor_req"));
    beacons();
    hear(0, golden("dlr_neighbor_req"));
    EXPECT_TRUE(sent().empty());
    beacons(RingState::fault);
    hear(1, golden("dlr_neighbor_req"));
    EXPECT_EQ(sent(),
              (Frames{"2: " + frame("01 21 6C 00 00 02", "81 00 E0 00 80 E1 02 01 03 02 C0 A8 02 64 00 00 10 02 01")}));
}

// A ring with a fault whose beacons do not run out while the neighbors are asked.
class BrokenRing : public Ring {
protected:
    BrokenRing() {
        const auto content = Beacon{RingState::fault, 0, 100'000, 60'000'000}.encode();
        for (const std::size_t port : {0U, 1U}) from_supervisor(port, RingFrameType::beacon, content);
    }
    static std::string request(std::size_t number, std::string_view sequence) {
        return std::to_string(number) + ": " +
               frame("01 21 6C 00 00 02", "81 00 E0 00 80 E1 02 01 02 0" + std::to_string(number) +
                                              " C0 A8 02 64 00 00 00 0" + std::string(sequence));
    }
    void respond(std::size_t port, std::uint32_t sequence, std::uint8_t asked_from) {
        const cip::Bytes content{asked_from};
        hear(port, RingFrame{.source = higher,
                             .type = RingFrameType::neighbor_check_response,
                             .sequence = sequence,
                             .content = content}
                       .encode());
    }
};

TEST_F(BrokenRing, LocateFaultAsksBothNeighborsThreeTimes) {  // R-DLR-10
    from_supervisor(0, RingFrameType::locate_fault);
    EXPECT_EQ(sent(), (Frames{request(1, "0"), request(2, "1")}));
    from_supervisor(1, RingFrameType::locate_fault);
    EXPECT_TRUE(sent().empty()) << "it goes on already";
    respond(0, 0, 1);
    run(99ms);
    EXPECT_TRUE(sent().empty());
    run(1ms);
    EXPECT_EQ(sent(), (Frames{request(2, "2")}));
    run(100ms);
    EXPECT_EQ(sent(), (Frames{request(2, "3")}));
    run(100ms);
    const auto status = frame("02 00 00 00 00 01", "81 00 E0 00 80 E1 02 01 04 00 C0 A8 02 64 00 00 00 04 81");
    EXPECT_EQ(sent(), (Frames{"1: " + status, "2: " + status}));
    run(1s);
    EXPECT_TRUE(sent().empty());
}

TEST_F(BrokenRing, NeighborsThatAnswerAreNotReported) {
    from_supervisor(0, RingFrameType::locate_fault);
    sent();
    respond(0, 5, 1);  // of no request
    respond(0, 0, 2);  // of the other port's
    respond(1, 1, 2);
    run(100ms);
    EXPECT_EQ(sent(), (Frames{request(1, "2")}));
    respond(0, 0, 1);  // a late one counts
    run(1s);
    EXPECT_TRUE(sent().empty());
}

TEST_F(BrokenRing, LocateFaultWithoutALinkTellsThat) {
    node_.on_link(0, false, now_);
    sent();
    from_supervisor(1, RingFrameType::locate_fault);
    EXPECT_THAT(sent(), testing::ElementsAre(testing::HasSubstr("02 01 04 00 C0 A8 02 64 00 00 00 01 02")));
}

TEST_F(BrokenRing, OnlyTheSupervisorLocatesFaults) {
    hear(0, RingFrame{.source = higher, .type = RingFrameType::locate_fault}.encode());
    EXPECT_TRUE(sent().empty());
}

TEST_F(BrokenRing, ARingThatClosesEndsTheSearch) {
    from_supervisor(0, RingFrameType::locate_fault);
    sent();
    beacons();
    expect_normal();
    run(1900us);
    EXPECT_TRUE(sent().empty());
    EXPECT_LT(*node_.next_deadline(), now_ + 1ms) << "the beacons' timeout is all that is waited for";
}

TEST_F(BrokenRing, FlushTablesMaySayThatSwitchesShallLearn) {
    from_supervisor(0, RingFrameType::flush_tables, {0});
    EXPECT_TRUE(sent().empty());
    from_supervisor(0, RingFrameType::flush_tables, {1});
    const auto update = frame("01 21 6C 00 00 05", "80 E1 02 01 0A 00 C0 A8 02 64 00 00 00 00", 60);
    EXPECT_EQ(sent(), (Frames{"1: " + update, "2: " + update}));
}

TEST_F(Ring, AnAnnounceBasedNodeListensToAnnouncements) {  // R-DLR-6, with the golden frame
    network_.ring.announce_based = true;
    EXPECT_EQ(attribute(12), "81 00 00 00");
    beacons();
    expect_idle();
    hear(0, golden("dlr_announce"));
    expect_normal();
    run(1s);
    from_supervisor(1, RingFrameType::announce, {2});
    expect_fault();
    run(2499ms);
    expect_fault();
    run(1ms);
    expect_idle();
    hear(1, golden("dlr_announce"));
    node_.on_link(0, false, now_);
    expect_fault();
    EXPECT_EQ(sent().size(), 1U);
}

TEST_F(Ring, AnnouncementsAreNothingToABeaconBasedNode) {
    EXPECT_EQ(attribute(12), "82 00 00 00");
    hear(0, golden("dlr_announce"));
    expect_idle();
}

TEST_F(Ring, DamagedFramesAreIgnored) {
    const auto whole = golden("dlr_beacon");
    constexpr std::size_t end_of_beacon = 18 + 12 + 10;
    for (std::size_t size = 0; size < end_of_beacon; ++size) {
        hear(0, cip::Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    }
    const auto damaged = [&](std::size_t at, std::uint8_t value) {
        auto octets = whole;
        octets[at] = value;
        hear(0, octets);
    };
    damaged(16, 0x81);  // EtherType
    damaged(18, 3);     // sub-type
    damaged(19, 2);     // version
    damaged(20, 0);     // types that there are not
    damaged(20, 11);
    damaged(30, 0);  // ring states that there are not
    damaged(30, 3);
    auto endless = whole;
    std::fill(endless.begin() + 36, endless.begin() + 40, 0);  // a timeout of nothing
    hear(0, endless);
    expect_idle();
    beacons();
    auto sign_on = golden("dlr_sign_on");
    sign_on.resize(sign_on.size() - 30);
    sign_on[31] = 5;  // more nodes than there are
    hear(0, sign_on);
    EXPECT_TRUE(sent().empty());
}

TEST_F(Ring, RandomFramesDoNoHarm) {
    std::mt19937_64 random(1);
    const std::vector<cip::Bytes> seeds{golden("dlr_beacon"), golden("dlr_sign_on"), golden("dlr_neighbor_req"),
                                        golden("dlr_announce")};
    for (int i = 0; i < 50'000; ++i) {
        auto octets = seeds[random() % seeds.size()];
        octets.resize(1 + random() % 100);
        for (int n = 0; n < 3; ++n) octets[random() % octets.size()] = static_cast<std::uint8_t>(random());
        hear(random() % 2, octets);
        for (const auto& frame : node_.take_frames()) EXPECT_LE(frame.octets.size(), 1518U);
        if (random() % 8 == 0) run(std::chrono::microseconds(random() % 3000));
        if (random() % 64 == 0) node_.on_link(random() % 2, random() % 2 == 0, now_);
    }
}

}  // namespace
}  // namespace servobus::adapter
