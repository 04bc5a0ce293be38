// R-DHC: the clients of DHCP and BOOTP against a server that is made of octets, in virtual time.
#include <algorithm>
#include <random>
#include <set>

#include "adapter/bootp_client.hpp"
#include "adapter/dhcp_client.hpp"
#include "adapter/ethernet_frame.hpp"
#include "tests/support/octets.hpp"

namespace servobus::adapter {
namespace {

using namespace std::chrono_literals;
using test::hex;
using test::operator+;
using Event = AddressClient::Event;

constexpr MacAddress own{0x02, 0x00, 0x00, 0x00, 0x00, 0x64};
constexpr MacAddress server_mac{0x02, 0x00, 0x00, 0x00, 0x00, 0x01};
constexpr std::uint32_t address = 0xC0A80264;
constexpr std::uint32_t server = 0xC0A80201;
constexpr std::uint32_t other_server = 0xC0A80202;

// A whole frame of the shortest message: up to the client's MAC address, and from the cookie on. Wireshark's dissector
// has agreed with both frames that are held against it.
std::string whole_frame(std::string_view front, std::string_view options) {
    constexpr std::size_t cookie_at = 278;
    constexpr std::size_t octets = 342;
    auto frame = test::octets(front);
    frame.resize(cookie_at);
    frame = frame + test::octets(options);
    frame.resize(octets);
    return hex(frame);
}

struct Sent {
    std::int64_t at = 0;  ///< ms since the beginning
    UdpFrame frame{};
    DhcpMessage message{};
    cip::Bytes octets{};

    std::string kind() const {
        const auto type = message.type();
        if (!type) return "bootp";
        return std::array{"", "discover", "offer", "request", "decline"}[static_cast<std::size_t>(*type)];
    }
};

// A client with its clock, its server and the wire between.
template <class Client>
class ClientBench : public testing::Test {
protected:
    std::int64_t elapsed() const {
        return std::chrono::duration_cast<std::chrono::milliseconds>(now_ - start_).count();
    }

    void collect() {
        for (auto& octets : client_.take_frames()) {
            Sent sent{.at = elapsed(), .octets = std::move(octets)};
            const auto frame = UdpFrame::parse(sent.octets);
            ASSERT_TRUE(frame) << cip::describe(frame.error());
            sent.frame = *frame;
            const auto message = DhcpMessage::parse(frame->payload);
            ASSERT_TRUE(message) << cip::describe(message.error());
            sent.message = *message;
            sent_.push_back(std::move(sent));
        }
    }
    void note(std::optional<Event> event) {
        if (event) events_.push_back(*event);
        collect();
    }
    void run(std::chrono::milliseconds duration) {
        const auto end = now_ + duration;
        while (const auto next = client_.next_deadline()) {
            if (*next > end) break;
            now_ = std::max(now_, *next);
            note(client_.on_timer(now_));
        }
        now_ = end;
    }
    void start() {
        client_.start(now_);
        run(0ms);
    }
    std::vector<std::string> kinds() {
        static_cast<void>(last_transaction());
        std::vector<std::string> list;
        for (const auto& sent : std::exchange(sent_, {})) list.push_back(sent.kind());
        return list;
    }
    std::vector<Event> events() { return std::exchange(events_, {}); }

    // A reply to the latest message, as a server would send it.
    DhcpMessage reply(std::optional<DhcpType> type) {
        DhcpMessage message{.operation = DhcpMessage::Operation::reply,
                            .transaction = last_transaction(),
                            .your_address = address,
                            .client_mac = own};
        if (type) {
            message.add(DhcpOption::message_type, cip::Bytes{static_cast<std::uint8_t>(*type)});
            message.add(DhcpOption::server_identifier, server);
        }
        message.add(DhcpOption::subnet_mask, 0xFFFFFF00);
        message.add(DhcpOption::router, 0xC0A802FE);
        message.add(DhcpOption::lease_time, 3600);
        return message;
    }
    DhcpMessage nak() {
        auto message = reply(DhcpType::nak);
        message.your_address = 0;
        return message;
    }
    std::uint32_t last_transaction() {
        if (!sent_.empty()) transaction_ = sent_.back().message.transaction;
        return transaction_;
    }
    void hear(const DhcpMessage& message) { hear(message.encode()); }
    void hear(const cip::Bytes& payload) {
        static_cast<void>(last_transaction());
        note(client_.on_datagram({.source_mac = server_mac, .source = {server, 67}, .payload = payload}, now_));
    }

    std::string host_name_;
    Client client_{own, host_name_, 1};
    enip::Time start_{1h};
    enip::Time now_ = start_;
    std::vector<Sent> sent_;
    std::vector<Event> events_;
    std::uint32_t transaction_ = 0;
};

using Kinds = std::vector<std::string>;
using Events = std::vector<Event>;

class Dhcp : public ClientBench<DhcpClient> {
protected:
    void obtain(DhcpMessage ack) {
        ack.transaction = last_transaction();
        hear(ack);
    }
    // From the start to an address in use.
    void bind(const std::function<void(DhcpMessage&)>& shape = [](DhcpMessage&) {}) {
        start();
        hear(reply(DhcpType::offer));
        auto ack = reply(DhcpType::ack);
        shape(ack);
        hear(ack);
        client_.confirm();
        EXPECT_EQ(events(), Events{Event::granted});
        sent_.clear();
    }
    std::uint64_t ignored(std::uint64_t IgnoredReplies::*which) const { return client_.ignored().*which; }
};

TEST_F(Dhcp, DiscoverByteForByte) {
    host_name_ = "xenax-7";
    start();
    ASSERT_EQ(sent_.size(), 1U);
    EXPECT_EQ(
        hex(sent_[0].octets),
        whole_frame(
            "FF FF FF FF FF FF 02 00 00 00 00 64 08 00 "
            "45 00 01 48 00 00 00 00 40 11 79 A6 00 00 00 00 FF FF FF FF "
            "00 44 00 43 01 34 8A 89 "
            "01 01 06 00 BB 68 6F 68 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "
            "02 00 00 00 00 64 ",
            "63 82 53 63 35 01 01 0C 07 78 65 6E 61 78 2D 37 37 05 01 03 06 0C 0F 3D 07 01 02 00 00 00 00 64 FF"));
}

TEST_F(Dhcp, AsksAtGrowingIntervalsWithoutEnd) {  // R-DHC-1
    start();
    run(10min);
    std::vector<std::int64_t> gaps;
    for (std::size_t i = 1; i < sent_.size(); ++i) {
        EXPECT_EQ(sent_[i].kind(), "discover");
        EXPECT_EQ(sent_[i].message.transaction, sent_[0].message.transaction);
        EXPECT_EQ(sent_[i].message.seconds, sent_[i].at / 1000);
        gaps.push_back(sent_[i].at - sent_[i - 1].at);
    }
    const std::vector<std::int64_t> nominal{4000, 8000, 16000, 32000, 64000, 64000, 64000};
    ASSERT_GT(gaps.size(), nominal.size());
    for (std::size_t i = 0; i < nominal.size(); ++i) EXPECT_LE(std::abs(gaps[i] - nominal[i]), 1000) << i;
    EXPECT_GT(std::ranges::count_if(gaps, [](auto gap) { return gap % 1000 != 0; }), 3) << "that is not random";
}

TEST_F(Dhcp, OfferIsTakenUpAndConfirmed) {  // R-DHC-2
    start();
    EXPECT_EQ(kinds(), Kinds{"discover"});
    hear(reply(DhcpType::offer));
    ASSERT_EQ(sent_.size(), 1U);
    const auto& request = sent_[0];
    EXPECT_EQ(request.kind(), "request");
    EXPECT_EQ(request.message.number(DhcpOption::requested_address), address);
    EXPECT_EQ(request.message.number(DhcpOption::server_identifier), server);
    EXPECT_EQ(request.message.client_address, 0U);
    EXPECT_EQ(request.frame.destination, (enip::Endpoint{broadcast_address, 67}));
    EXPECT_EQ(request.frame.source, (enip::Endpoint{0, 68}));
    auto ack = reply(DhcpType::ack);
    ack.options[DhcpOption::name_server] = test::octets("C0A80203 C0A80204 C0A80205");
    ack.add(DhcpOption::domain_name, std::string("press.example\0", 14));
    hear(ack);
    EXPECT_EQ(events(), Events{Event::granted});
    const auto& granted = client_.granted();
    EXPECT_EQ(granted.address, address);
    EXPECT_EQ(granted.mask, 0xFFFFFF00);
    EXPECT_EQ(granted.gateway, 0xC0A802FE);
    EXPECT_EQ(granted.name_server_1, 0xC0A80203);
    EXPECT_EQ(granted.name_server_2, 0xC0A80204);
    EXPECT_EQ(granted.domain, "press.example");
    sent_.clear();
    run(2h);
    EXPECT_TRUE(sent_.empty()) << "before it is confirmed it is not renewed";
}

TEST_F(Dhcp, RequestIsRepeatedFourTimesThenItBeginsAnew) {
    start();
    hear(reply(DhcpType::offer));
    const auto first = last_transaction();
    run(70s);
    EXPECT_NE(last_transaction(), first);
    EXPECT_EQ(kinds(), (Kinds{"discover", "request", "request", "request", "request", "discover", "discover"}));
}

TEST_F(Dhcp, NakBeginsAnewAfterAWhile) {
    start();
    hear(reply(DhcpType::offer));
    const auto first = last_transaction();
    hear(nak());
    sent_.clear();
    run(3999ms);
    EXPECT_TRUE(sent_.empty());
    run(1ms);
    EXPECT_NE(last_transaction(), first);
    EXPECT_EQ(kinds(), Kinds{"discover"});
    EXPECT_TRUE(events().empty()) << "nothing was granted yet";
}

TEST_F(Dhcp, DeclineSaysWhichAddressAndWaits) {  // R-ACD-3
    start();
    hear(reply(DhcpType::offer));
    hear(reply(DhcpType::ack));
    sent_.clear();
    client_.decline(10s, now_);
    collect();
    ASSERT_EQ(sent_.size(), 1U);
    EXPECT_EQ(sent_[0].kind(), "decline");
    EXPECT_EQ(sent_[0].message.number(DhcpOption::requested_address), address);
    EXPECT_EQ(sent_[0].message.number(DhcpOption::server_identifier), server);
    EXPECT_EQ(sent_[0].message.client_address, 0U);
    EXPECT_FALSE(sent_[0].message.has(DhcpOption::parameter_request_list));
    EXPECT_EQ(sent_[0].frame.destination, (enip::Endpoint{broadcast_address, 67}));
    sent_.clear();
    run(9999ms);
    EXPECT_TRUE(sent_.empty());
    run(1ms);
    EXPECT_EQ(kinds(), Kinds{"discover"});
    EXPECT_EQ(client_.granted().address, 0U);
}

TEST_F(Dhcp, IsRenewedByUnicastAtHalfTheLease) {  // R-DHC-2
    bind();
    run(1800s - 1ms);
    EXPECT_TRUE(sent_.empty());
    run(1ms);
    ASSERT_EQ(sent_.size(), 1U);
    const auto& request = sent_[0];
    EXPECT_EQ(request.kind(), "request");
    EXPECT_EQ(request.message.client_address, address);
    EXPECT_FALSE(request.message.has(DhcpOption::requested_address));
    EXPECT_FALSE(request.message.has(DhcpOption::server_identifier));
    EXPECT_EQ(request.frame.source, (enip::Endpoint{address, 68}));
    EXPECT_EQ(request.frame.destination, (enip::Endpoint{server, 67}));
    EXPECT_EQ(request.frame.destination_mac, server_mac);
    hear(reply(DhcpType::ack));
    EXPECT_TRUE(events().empty()) << "a renewed lease interrupts nothing";
    sent_.clear();
    run(1800s - 1ms);
    EXPECT_TRUE(sent_.empty());
    run(1ms);
    EXPECT_EQ(kinds(), Kinds{"request"});
}

TEST_F(Dhcp, ARenewedLeaseMayChangeTheGateway) {
    bind();
    run(1800s);
    auto ack = reply(DhcpType::ack);
    ack.add(DhcpOption::router, 0xC0A802FD);
    hear(ack);
    EXPECT_EQ(events(), Events{Event::changed});
    EXPECT_EQ(client_.granted().gateway, 0xC0A802FD);
}

TEST_F(Dhcp, IsReboundByBroadcastThenExpires) {
    bind();
    run(3600s - 1ms);
    std::vector<std::int64_t> renewals;
    std::vector<std::int64_t> rebindings;
    for (const auto& sent : sent_) {
        const bool to_all = sent.frame.destination.address == broadcast_address;
        (to_all ? rebindings : renewals).push_back(sent.at / 1000);
        EXPECT_EQ(sent.message.client_address, address);
        EXPECT_EQ(sent.frame.source.address, address);
    }
    // 1350 s from T1 to T2, 450 s from there to the end; half of the rest, and not less than a minute.
    EXPECT_EQ(renewals, (std::vector<std::int64_t>{1800, 2475, 2812, 2981, 3065, 3125}));
    EXPECT_EQ(rebindings, (std::vector<std::int64_t>{3150, 3375, 3487, 3547}));
    EXPECT_TRUE(events().empty());
    sent_.clear();
    run(1ms);
    EXPECT_EQ(events(), Events{Event::lost});
    EXPECT_EQ(client_.granted().address, 0U);
    EXPECT_EQ(kinds(), Kinds{"discover"});
}

TEST_F(Dhcp, AnyServerMayRebind) {
    bind();
    run(3150s);
    auto ack = reply(DhcpType::ack);
    ack.add(DhcpOption::server_identifier, other_server);
    hear(ack);
    sent_.clear();
    run(1800s);
    ASSERT_EQ(sent_.size(), 1U);
    EXPECT_EQ(sent_[0].frame.destination.address, other_server);
}

TEST_F(Dhcp, NakTakesTheAddressAway) {
    bind();
    run(1800s);
    hear(nak());
    EXPECT_EQ(events(), Events{Event::lost});
    EXPECT_EQ(client_.granted().address, 0U);
}

TEST_F(Dhcp, TheServerMayChooseWhenToRenew) {
    bind([](DhcpMessage& ack) {
        ack.add(DhcpOption::renewal_time, 20);
        ack.add(DhcpOption::rebinding_time, 40);
    });
    run(20s);
    ASSERT_EQ(sent_.size(), 1U);
    EXPECT_EQ(sent_[0].frame.destination.address, server);
    run(20s);
    ASSERT_EQ(sent_.size(), 2U);
    EXPECT_EQ(sent_[1].frame.destination.address, broadcast_address);
}

TEST_F(Dhcp, TimesThatMakeNoSenseAreNotTaken) {
    bind([](DhcpMessage& ack) {
        ack.add(DhcpOption::renewal_time, 3500);
        ack.add(DhcpOption::rebinding_time, 40);
    });
    run(1800s - 1ms);
    EXPECT_TRUE(sent_.empty());
    run(1ms);
    EXPECT_EQ(sent_.size(), 1U);
}

TEST_F(Dhcp, AnEndlessLeaseIsNeverRenewed) {
    bind([](DhcpMessage& ack) { ack.add(DhcpOption::lease_time, 0xFFFFFFFF); });
    EXPECT_EQ(client_.next_deadline(), std::nullopt);
}

TEST_F(Dhcp, TheHostNameIsThatOfTheNextCycle) {  // R-TCP-7
    host_name_ = "first";
    start();
    EXPECT_EQ(sent_.back().message.text(DhcpOption::host_name), "first");
    host_name_ = "second";
    run(5s);
    EXPECT_EQ(sent_.back().message.text(DhcpOption::host_name), "first");
    hear(reply(DhcpType::offer));
    hear(nak());
    run(4s);
    EXPECT_EQ(sent_.back().message.text(DhcpOption::host_name), "second");
}

TEST_F(Dhcp, ALeaseCountsFromTheRequest) {
    start();
    run(2s);
    hear(reply(DhcpType::offer));
    run(3s);
    hear(reply(DhcpType::ack));
    run(1s);
    client_.confirm();
    sent_.clear();
    run(1796s - 1ms);
    EXPECT_TRUE(sent_.empty());
    run(1ms);
    EXPECT_EQ(sent_.size(), 1U);
}

// What servers must not send; each is counted and changes nothing.

TEST_F(Dhcp, RepliesOfOthersAreIgnored) {
    start();
    auto wrong = reply(DhcpType::offer);
    wrong.transaction ^= 1;
    hear(wrong);
    wrong = reply(DhcpType::offer);
    wrong.client_mac[5] ^= 1;
    hear(wrong);
    EXPECT_EQ(ignored(&IgnoredReplies::foreign), 2U);
    EXPECT_EQ(kinds(), Kinds{"discover"});
}

TEST_F(Dhcp, RepliesThatNobodyWaitsForAreIgnored) {
    start();
    hear(reply(DhcpType::ack));
    hear(reply(DhcpType::nak));
    hear(reply(DhcpType::discover));
    hear(reply(std::nullopt));  // BOOTP, R-DHC-3
    EXPECT_EQ(ignored(&IgnoredReplies::unexpected), 4U);
    hear(reply(DhcpType::offer));
    hear(reply(DhcpType::offer));
    auto ack = reply(DhcpType::ack);
    ack.add(DhcpOption::server_identifier, other_server);
    hear(ack);
    auto refusal = nak();
    refusal.add(DhcpOption::server_identifier, other_server);
    hear(refusal);
    EXPECT_EQ(ignored(&IgnoredReplies::unexpected), 7U);
    EXPECT_EQ(kinds(), (Kinds{"discover", "request"}));
    EXPECT_TRUE(events().empty());
}

TEST_F(Dhcp, IllegalGrantsAreIgnored) {  // R-DHC-2
    start();
    std::uint64_t count = 0;
    for (const std::uint32_t illegal :
         {0x00000000U, 0x00000001U, 0x7F000001U, 0xE0000001U, 0xF0000001U, 0xFFFFFFFFU, 0xC0A80200U, 0xC0A802FFU}) {
        auto offer = reply(DhcpType::offer);
        offer.your_address = illegal;
        hear(offer);
        EXPECT_EQ(ignored(&IgnoredReplies::illegal), ++count) << std::hex << illegal;
    }
    for (const std::uint32_t mask : {0x00000000U, 0xFF00FF00U, 0xFFFFFFFFU, 0xFFFFFFFEU}) {
        auto offer = reply(DhcpType::offer);
        offer.add(DhcpOption::subnet_mask, mask);
        hear(offer);
        EXPECT_EQ(ignored(&IgnoredReplies::illegal), ++count) << std::hex << mask;
    }
    for (const std::uint32_t identifier : {0x00000000U, 0x7F000001U, 0xE0000001U}) {
        auto offer = reply(DhcpType::offer);
        offer.add(DhcpOption::server_identifier, identifier);
        hear(offer);
        EXPECT_EQ(ignored(&IgnoredReplies::illegal), ++count) << std::hex << identifier;
    }
    auto nobody = reply(DhcpType::offer);
    nobody.options.erase(DhcpOption::server_identifier);
    hear(nobody);
    EXPECT_EQ(ignored(&IgnoredReplies::illegal), ++count);
    EXPECT_EQ(kinds(), Kinds{"discover"});
    hear(reply(DhcpType::offer));
    auto another = reply(DhcpType::ack);
    another.your_address = address + 1;
    hear(another);
    auto brief = reply(DhcpType::ack);
    brief.add(DhcpOption::lease_time, 9);
    hear(brief);
    auto endless = reply(DhcpType::ack);
    endless.options.erase(DhcpOption::lease_time);
    hear(endless);
    EXPECT_EQ(ignored(&IgnoredReplies::illegal), count + 3);
    EXPECT_TRUE(events().empty());
}

TEST_F(Dhcp, WithoutAMaskTheClassDecides) {
    bind([](DhcpMessage& ack) {
        ack.options.erase(DhcpOption::subnet_mask);
        ack.options.erase(DhcpOption::router);
    });
    EXPECT_EQ(client_.granted().mask, 0xFFFFFF00);
    EXPECT_EQ(client_.granted().gateway, 0U);
}

TEST_F(Dhcp, AGatewayOutsideTheSubnetIsLeftOut) {
    bind([](DhcpMessage& ack) { ack.options[DhcpOption::router] = test::octets("0A000001 C0A802FB"); });
    EXPECT_EQ(client_.granted().gateway, 0xC0A802FB);
}

TEST_F(Dhcp, CutOffMessagesAreIgnored) {
    constexpr std::size_t fixed = 236;    // octets in front of the cookie
    constexpr std::size_t options = 240;  // where they begin
    const std::set<std::size_t> between{240, 243, 249, 255, 261, 267};
    std::uint64_t malformed = 0;
    for (std::size_t size = 0; size < *between.rbegin(); ++size) {
        start();
        const auto offer = reply(DhcpType::offer).encode();
        hear(cip::Bytes(offer.begin(), offer.begin() + static_cast<std::ptrdiff_t>(size)));
        if (size < fixed || (size > options && !between.contains(size))) ++malformed;
        EXPECT_EQ(ignored(&IgnoredReplies::malformed), malformed) << size;
        EXPECT_EQ(kinds(), Kinds{"discover"}) << size;
    }
}

TEST_F(Dhcp, OptionsOfAnotherLengthAreIgnored) {
    start();
    std::uint64_t malformed = 0;
    const std::vector<std::pair<DhcpOption, std::size_t>> wrong{{DhcpOption::message_type, 2},
                                                                {DhcpOption::message_type, 0},
                                                                {DhcpOption::subnet_mask, 3},
                                                                {DhcpOption::subnet_mask, 5},
                                                                {DhcpOption::router, 0},
                                                                {DhcpOption::router, 6},
                                                                {DhcpOption::name_server, 7},
                                                                {DhcpOption::lease_time, 3},
                                                                {DhcpOption::lease_time, 8},
                                                                {DhcpOption::server_identifier, 0},
                                                                {DhcpOption::server_identifier, 5},
                                                                {DhcpOption::renewal_time, 2},
                                                                {DhcpOption::rebinding_time, 255},
                                                                {DhcpOption::overload, 0},
                                                                {DhcpOption::overload, 2}};
    for (const auto& [option, size] : wrong) {
        auto offer = reply(DhcpType::offer);
        offer.options[option] = cip::Bytes(size, 1);
        hear(offer);
        EXPECT_EQ(ignored(&IgnoredReplies::malformed), ++malformed) << static_cast<int>(option) << ' ' << size;
    }
    EXPECT_EQ(kinds(), Kinds{"discover"});
}

TEST_F(Dhcp, OverlongMessagesAreIgnored) {
    start();
    auto offer = reply(DhcpType::offer).encode();
    offer.resize(max_dhcp_octets + 1);
    hear(offer);
    EXPECT_EQ(ignored(&IgnoredReplies::malformed), 1U);
    offer.resize(max_dhcp_octets);
    hear(offer);
    EXPECT_EQ(kinds(), (Kinds{"discover", "request"}));
}

TEST_F(Dhcp, OptionsMayStandInTheFieldsForFileAndName) {  // option 52
    constexpr std::size_t name_at = 44;
    constexpr std::size_t file_at = 108;
    start();
    auto bare = reply(DhcpType::offer);
    bare.options.erase(DhcpOption::server_identifier);
    bare.options.erase(DhcpOption::subnet_mask);
    const auto with = [&](std::uint8_t overload, std::string_view file, std::string_view name) {
        auto message = bare;
        message.options[DhcpOption::overload] = {overload};
        auto octets = message.encode();
        std::ranges::copy(test::octets(file), octets.begin() + file_at);
        std::ranges::copy(test::octets(name), octets.begin() + name_at);
        return octets;
    };
    hear(with(0, "3604C0A80201FF", "0104FFFFFF00FF"));
    hear(with(4, "3604C0A80201FF", "0104FFFFFF00FF"));
    hear(with(3, "3604C0A80201FF", "0104FFFFFF00340103FF"));  // it speaks of itself again
    hear(with(3, "3604C0A80201FF", "01C8FFFFFF00"));          // beyond the field
    EXPECT_EQ(ignored(&IgnoredReplies::malformed), 4U);
    hear(with(2, "3604C0A80201FF", "0104FFFFFF00FF"));  // the file is a file
    EXPECT_EQ(ignored(&IgnoredReplies::illegal), 1U);
    EXPECT_EQ(kinds(), Kinds{"discover"});
    hear(with(3, "3604C0A80201FF", "0104FFFFFF00FF"));
    EXPECT_EQ(kinds(), Kinds{"request"});
}

TEST_F(Dhcp, PartsOfAnOptionArePutTogether) {  // RFC 3396
    start();
    auto offer = reply(DhcpType::offer);
    offer.options.erase(DhcpOption::server_identifier);
    auto octets = offer.encode();
    const auto end = std::ranges::find(octets.begin() + 240, octets.end(), std::uint8_t{0xFF}) - octets.begin();
    octets.resize(400);
    // The mask holds 0xFF too: the end is the last one.
    std::size_t at = 240;
    while (octets[at] != 0xFF) at += 2U + octets[at + 1];
    EXPECT_GE(at, static_cast<std::size_t>(end));
    std::ranges::copy(test::octets("3601C0 3603A80201 FF"), octets.begin() + static_cast<std::ptrdiff_t>(at));
    hear(octets);
    EXPECT_EQ(kinds(), (Kinds{"discover", "request"}));
}

TEST_F(Dhcp, RandomOctetsChangeNothing) {
    start();
    std::mt19937_64 random(1);
    const auto whole = reply(DhcpType::offer).encode();
    for (int i = 0; i < 20'000; ++i) {
        auto octets = whole;
        octets.resize(random() % 600);
        for (int n = 0; n < 4 && !octets.empty(); ++n)
            octets[random() % octets.size()] = static_cast<std::uint8_t>(random());
        hear(octets);
    }
    const auto& counters = client_.ignored();
    EXPECT_GT(counters.malformed, 0U);
    EXPECT_GT(counters.foreign, 0U);
    EXPECT_TRUE(events().empty()) << "an address without an ACK";
}

// BOOTP

class Bootp : public ClientBench<BootpClient> {};

TEST_F(Bootp, RequestByteForByte) {
    start();
    ASSERT_EQ(sent_.size(), 1U);
    EXPECT_EQ(hex(sent_[0].octets),
              whole_frame("FF FF FF FF FF FF 02 00 00 00 00 64 08 00 "
                          "45 00 01 48 00 00 00 00 40 11 79 A6 00 00 00 00 FF FF FF FF "
                          "00 44 00 43 01 34 12 E3 "
                          "01 01 06 00 BB 68 6F 68 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "
                          "02 00 00 00 00 64 ",
                          "63 82 53 63 FF"));
}

TEST_F(Bootp, AReplyIsAnAddressForGood) {  // R-DHC-3
    start();
    auto message = reply(std::nullopt);
    message.options.erase(DhcpOption::lease_time);
    hear(message);
    EXPECT_EQ(events(), Events{Event::granted});
    EXPECT_EQ(client_.granted().address, address);
    EXPECT_EQ(client_.granted().gateway, 0xC0A802FE);
    client_.confirm();
    EXPECT_EQ(client_.next_deadline(), std::nullopt);
    hear(message);
    EXPECT_EQ(client_.ignored().unexpected, 1U);
}

TEST_F(Bootp, AReplyWithoutOptionsHasTheMaskOfItsClass) {  // RFC 951
    start();
    auto octets = reply(std::nullopt).encode();
    octets.resize(300);
    std::fill(octets.begin() + 236, octets.end(), 0);
    hear(octets);
    EXPECT_EQ(events(), Events{Event::granted});
    EXPECT_EQ(client_.granted().mask, 0xFFFFFF00);
}

TEST_F(Bootp, DhcpGrantsNothing) {
    start();
    hear(reply(DhcpType::offer));
    hear(reply(DhcpType::ack));
    EXPECT_EQ(client_.ignored().unexpected, 2U);
    EXPECT_TRUE(events().empty());
}

TEST_F(Bootp, AsksAgainAtGrowingIntervals) {
    start();
    run(3min);
    ASSERT_GE(sent_.size(), 6U);
    for (std::size_t i = 1; i < 6; ++i) {
        EXPECT_NEAR(static_cast<double>(sent_[i].at - sent_[i - 1].at), i < 5 ? 2000 << i : 64000, 1000) << i;
        EXPECT_FALSE(sent_[i].message.has(DhcpOption::message_type));
    }
}

TEST_F(Bootp, AnAddressThatSomebodyHasIsAskedForAgain) {
    start();
    hear(reply(std::nullopt));
    sent_.clear();
    client_.decline(10s, now_);
    run(9999ms);
    EXPECT_TRUE(sent_.empty());
    run(1ms);
    EXPECT_EQ(kinds(), Kinds{"bootp"});
}

// The frames below

TEST(UdpFrames, OthersThanSoundDatagramsAreRefused) {
    const cip::Bytes payload{1, 2, 3};
    const auto whole = UdpFrame{.destination_mac = own,
                                .source_mac = server_mac,
                                .source = {server, 67},
                                .destination = {address, 68},
                                .payload = payload}
                           .encode();
    const auto parsed = UdpFrame::parse(whole);
    ASSERT_TRUE(parsed);
    EXPECT_EQ(hex(parsed->payload), hex(payload));
    EXPECT_EQ(parsed->source, (enip::Endpoint{server, 67}));
    for (std::size_t size = 0; size < 45; ++size) {
        EXPECT_FALSE(UdpFrame::parse(cip::ByteView(whole).first(size))) << size;
    }
    const auto damaged = [&](std::size_t at, std::uint8_t change, bool checksummed = true) {
        auto octets = whole;
        octets[at] ^= change;
        return UdpFrame::parse(octets, checksummed).has_value();
    };
    for (std::size_t at = 12; at < 45; ++at) EXPECT_FALSE(damaged(at, 0x21)) << at;
    EXPECT_TRUE(damaged(40, 1, false)) << "the UDP checksum is still to be computed";
    EXPECT_FALSE(damaged(24, 1, false)) << "that of IP is not";
    auto without = whole;
    without[40] = without[41] = 0;
    EXPECT_TRUE(UdpFrame::parse(without)) << "a sender may leave it out";
}

TEST(UdpFrames, AChecksumOfZeroIsWrittenAsOnes) {
    // 0x0043 + 0x0044 + lengths + the pseudo header + this payload give 0xFFFF.
    cip::Bytes payload(2);
    const auto frame = [&] {
        return UdpFrame{.source = {0, 68}, .destination = {broadcast_address, 67}, .payload = payload}.encode();
    };
    const auto at_zero = frame();
    payload = {at_zero[40], at_zero[41]};
    EXPECT_EQ(hex(cip::ByteView(frame()).subspan(40, 2)), "FF FF");
    EXPECT_TRUE(UdpFrame::parse(frame()));
}

}  // namespace
}  // namespace servobus::adapter
