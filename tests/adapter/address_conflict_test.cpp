// R-ACD: which frames leave when, and what becomes of an address that others want.
#include "adapter/address_conflict.hpp"

#include "adapter/ethernet_frame.hpp"
#include "tests/support/golden.hpp"
#include "tests/support/octets.hpp"

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;
using test::hex;

constexpr MacAddress own{0x02, 0x00, 0x00, 0x00, 0x00, 0x64};
constexpr MacAddress rival{0x02, 0x00, 0x00, 0x00, 0x00, 0x01};
constexpr std::uint32_t address = 0xC0A80264;

std::string golden(std::string_view name) {
    const auto* vector = test::find_golden_vector(name);
    return vector != nullptr ? hex(vector->octets) : "no such vector";
}

const std::string probe = golden("acd_probe");
const std::string announcement = golden("acd_announce");

cip::Bytes reply_of_rival() { return ArpPacket{ArpPacket::Operation::reply, rival, address, own, 0}.encode(); }
cip::Bytes announcement_of_rival() {
    return ArpPacket{ArpPacket::Operation::request, rival, address, {}, address}.encode();
}
cip::Bytes probe_of_rival() { return ArpPacket{ArpPacket::Operation::request, rival, 0, {}, address}.encode(); }

// A detection with its clock: what it sends and says, with the milliseconds since the beginning.
class AddressConflict : public testing::Test {
protected:
    struct Happened {
        std::int64_t at;
        std::string what;
        friend bool operator==(const Happened&, const Happened&) = default;
        friend void PrintTo(const Happened& happened, std::ostream* out) {
            *out << happened.at << ' ' << happened.what;
        }
    };

    std::int64_t elapsed() const {
        return std::chrono::duration_cast<std::chrono::milliseconds>(now_ - start_).count();
    }

    void note(std::optional<AddressVerdict> verdict) {
        for (const auto& frame : detection_.take_frames()) {
            const auto text = hex(frame);
            happened_.push_back({elapsed(), text == probe ? "probe" : text == announcement ? "announcement" : text});
        }
        if (verdict)
            happened_.push_back({elapsed(), std::array{"usable", "refused", "defended", "undisputed",
                                                       "lost"}[static_cast<std::size_t>(*verdict)]});
    }
    void run(std::chrono::milliseconds duration) {
        const auto end = now_ + duration;
        while (const auto next = detection_.next_deadline()) {
            if (*next > end) break;
            now_ = std::max(now_, *next);
            note(detection_.on_timer(now_));
        }
        now_ = end;
    }
    void hear(const cip::Bytes& arp) { note(detection_.on_arp(arp, now_)); }
    void start() { detection_.start(address, now_); }
    void use() {
        start();
        run(3100ms);
        happened_.clear();
    }
    std::vector<Happened> take() { return std::exchange(happened_, {}); }
    std::vector<std::string> words() {
        std::vector<std::string> list;
        for (auto& each : take()) list.push_back(std::move(each.what));
        return list;
    }

    AddressConflictDetection detection_{own, 1};
    enip::Time start_{1h};
    enip::Time now_ = start_;
    std::vector<Happened> happened_;
};

using Words = std::vector<std::string>;

TEST_F(AddressConflict, FourProbesThenTwoAnnouncements) {  // R-ACD-1, R-ACD-2
    start();
    run(10s);
    EXPECT_EQ(take(), (std::vector<Happened>{{200, "probe"},
                                             {400, "probe"},
                                             {600, "probe"},
                                             {800, "probe"},
                                             {1000, "announcement"},
                                             {1000, "usable"},
                                             {3000, "announcement"}}));
}

TEST_F(AddressConflict, ProbesKeepTheirDistanceWhenTheTimerIsLate) {  // 180 to 220 ms are accepted, R-ACD-1
    start();
    now_ += 260ms;
    note(detection_.on_timer(now_));
    run(1s);
    EXPECT_EQ(take().at(1), (Happened{460, "probe"}));
}

TEST_F(AddressConflict, WhoHasItOrProbesForItRefusesIt) {  // R-ACD-3
    for (const auto& arp : {reply_of_rival(), announcement_of_rival(), probe_of_rival()}) {
        start();
        run(500ms);
        take();
        hear(arp);
        EXPECT_EQ(words(), (Words{"refused"}));
        EXPECT_FALSE(detection_.runs());
        EXPECT_EQ(detection_.last_conflict()[0], 1);
        EXPECT_EQ(hex(cip::ByteView(detection_.last_conflict()).subspan(1, 6)), hex(rival));
        EXPECT_EQ(hex(cip::ByteView(detection_.last_conflict()).subspan(7)), hex(arp));
        run(10s);
        EXPECT_TRUE(take().empty()) << "it goes on probing";
    }
}

TEST_F(AddressConflict, TheRecordIsTheGoldenOne) {  // R-TCP-10, get_f5_lastconflict_set
    use();
    hear(ArpPacket{ArpPacket::Operation::request, rival, address, {}, address}.encode());
    const auto reply = golden("get_f5_lastconflict_set_rep");
    EXPECT_THAT(reply, testing::EndsWith(hex(detection_.last_conflict())));
}

TEST_F(AddressConflict, OtherArpIsNoConflict) {
    start();
    run(300ms);
    take();
    hear(ArpPacket{ArpPacket::Operation::reply, own, address, rival, 0}.encode());             // our own, come back
    hear(ArpPacket{ArpPacket::Operation::request, own, 0, {}, address}.encode());              // our own probe
    hear(ArpPacket{ArpPacket::Operation::request, rival, address + 1, {}, address}.encode());  // somebody asks
    hear(ArpPacket{ArpPacket::Operation::request, rival, 0, {}, address + 1}.encode());        // probes for another one
    hear(ArpPacket{ArpPacket::Operation::reply, rival, 0, {}, address}.encode());              // a reply is no probe
    EXPECT_TRUE(take().empty());
    run(1s);
    EXPECT_EQ(words().back(), "usable");
    hear(probe_of_rival());  // it is told by a reply that the address is taken
    EXPECT_TRUE(take().empty());
}

TEST_F(AddressConflict, DamagedArpIsIgnored) {
    start();
    const auto whole = reply_of_rival();
    for (std::size_t size = 0; size < whole.size(); ++size) {
        hear(cip::Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    }
    for (const std::size_t field : {0U, 3U, 4U, 5U, 6U}) {
        auto damaged = whole;
        damaged[field] ^= 0x40;
        hear(damaged);
    }
    auto padded = whole;
    padded.resize(46);
    EXPECT_TRUE(take().empty());
    hear(padded);
    EXPECT_EQ(words(), (Words{"refused"}));
}

TEST_F(AddressConflict, LooksAgainEvery90To150Seconds) {  // R-ACD-4
    use();
    run(60min);
    auto before = std::int64_t{3000};
    std::int64_t shortest = 1'000'000;
    std::int64_t longest = 0;
    for (const auto& [at, what] : take()) {
        EXPECT_EQ(what, "probe");
        shortest = std::min(shortest, at - before);
        longest = std::max(longest, at - before);
        before = at;
    }
    EXPECT_GE(shortest, 90'000);
    EXPECT_LE(longest, 150'000);
    EXPECT_GT(longest - shortest, 20'000) << "that is not random";
}

TEST_F(AddressConflict, IsDefendedOnceInTenSeconds) {  // R-ACD-4
    use();
    hear(announcement_of_rival());
    EXPECT_EQ(words(), (Words{"announcement", "defended"}));
    EXPECT_EQ(detection_.last_conflict()[0], 2);
    run(9999ms);
    EXPECT_TRUE(take().empty());
    run(1ms);
    EXPECT_EQ(words(), (Words{"undisputed"}));
    hear(reply_of_rival());
    EXPECT_EQ(words(), (Words{"announcement", "defended"}));
    run(9999ms);
    hear(reply_of_rival());
    EXPECT_EQ(words(), (Words{"lost"}));
    EXPECT_FALSE(detection_.runs());
    EXPECT_EQ(detection_.next_deadline(), std::nullopt);
}

TEST_F(AddressConflict, LinkLossWhileItIsUsedBringsTwoProbes) {  // R-ACD-5
    use();
    detection_.on_link(false, now_);
    run(10min);
    EXPECT_TRUE(take().empty()) << "something is sent without a link";
    detection_.on_link(true, now_);
    const auto back = elapsed();
    run(10s);
    EXPECT_EQ(take(), (std::vector<Happened>{{back + 200, "probe"}, {back + 400, "probe"}}));
    run(150s);
    EXPECT_EQ(words(), (Words{"probe"}));
}

TEST_F(AddressConflict, AConflictAfterLinkLossIsActivityThree) {  // R-ACD-5
    use();
    detection_.on_link(false, now_);
    detection_.on_link(true, now_);
    run(250ms);
    take();
    hear(reply_of_rival());
    EXPECT_EQ(words(), (Words{"announcement", "defended"}));
    EXPECT_EQ(detection_.last_conflict()[0], 3);
    hear(reply_of_rival());
    EXPECT_EQ(words(), (Words{"lost"}));
}

TEST_F(AddressConflict, LinkLossWhileProbingBeginsAnew) {
    start();
    run(700ms);
    take();
    detection_.on_link(false, now_);
    run(5s);
    detection_.on_link(true, now_);
    run(1s);
    EXPECT_EQ(words(), (Words{"probe", "probe", "probe", "probe", "announcement", "usable"}));
}

TEST_F(AddressConflict, MoreThanTenConflictsMakeItPatient) {  // R-ACD-3
    for (int i = 0; i < 10; ++i) {
        start();
        hear(reply_of_rival());
        EXPECT_EQ(detection_.pause(), 10s) << i;
    }
    start();
    hear(reply_of_rival());
    EXPECT_EQ(detection_.pause(), 60s);
    use();
    EXPECT_EQ(detection_.pause(), 60s) << "one that was just obtained may be lost again";
    run(150s);
    EXPECT_EQ(detection_.pause(), 10s);
}

TEST_F(AddressConflict, NothingIsHeardOrSentWhenStopped) {
    use();
    detection_.stop();
    hear(reply_of_rival());
    run(10min);
    EXPECT_TRUE(take().empty());
    EXPECT_EQ(detection_.last_conflict(), LastConflict{});
}

}  // namespace
}  // namespace servobus::adapter
