// Opening class 1 connections: every form that is legal, and every illegal one with the status that the rules name
// (R-CON-1 to R-CON-17, R-CON-23 to R-CON-33, R-CON-40, R-CON-48, R-CON-51, R-CPF-9, R-MC-4), octet by octet.
#include <gmock/gmock.h>

#include "tests/adapter/io_site.hpp"

namespace servobus::test {
namespace {

using adapter::Counter;
using testing::HasSubstr;

enum class Way : std::uint8_t { plain, large, plain_sent, large_sent };
constexpr std::array<Way, 4> all_ways{Way::plain, Way::large, Way::plain_sent, Way::large_sent};
bool is_large(Way way) { return way == Way::large || way == Way::large_sent; }

/// The Forward_Open in one of the four forms in which it may come.
cip::Bytes in_form(cip::ForwardOpen open, Way way) {
    open.large = is_large(way);
    const auto request = request_of(open);
    return way == Way::plain || way == Way::large ? request : through_unconnected_send(request);
}

void expect_nothing_open(IoSite& site) {
    EXPECT_EQ(site.adapter.io().size(), 0U);
    EXPECT_EQ(site.adapter.io().owner(), nullptr);
    EXPECT_EQ(site.adapter.class3_connections(), 0U);
    site.advance(20ms);
    EXPECT_TRUE(site.take().empty()) << "somebody produces";
}

struct Refused {
    std::string what;
    std::string status;  ///< general status, size and words, in hex
    std::function<void(cip::ForwardOpen&)> change;
    Counter counter = Counter::open_format_rejects;
    std::string words{};  ///< a piece of the log line
    std::vector<enip::Item> items{};
};
void PrintTo(const Refused& each, std::ostream* out) { *out << each.what; }

Refused at_path(std::string what, std::string status, std::string path, std::string words = "") {
    return {std::move(what), std::move(status),
            [path = std::move(path)](cip::ForwardOpen& open) { open.path = octets(path); },
            Counter::open_format_rejects, std::move(words)};
}
Refused at_points(std::string what, std::string status, std::string points, std::string words = "") {
    return at_path(std::move(what), std::move(status), std::string(own_key) + " 20 04 24 01 " + points,
                   std::move(words));
}
Refused with_key(std::string what, std::string status, std::string key, std::string words = "") {
    return at_path(std::move(what), std::move(status), key + " 20 04 24 01 2C 65 2C 64", std::move(words));
}
Refused with_items(std::string what, std::vector<enip::Item> items) {
    return {std::move(what), "01 01 0502",    [](auto&) {}, Counter::open_format_rejects,
            "sockaddr item", std::move(items)};
}

class IoOpenRefusal : public testing::TestWithParam<Refused> {};

TEST_P(IoOpenRefusal, R_CON_15_NamesTheReasonAndOpensNothing) {
    const auto& refused = GetParam();
    IoSite site;
    IoPeer peer(site);
    unsigned count = 0;
    for (const auto way : all_ways) {
        if (!refused.items.empty() && way != Way::plain && way != Way::large) continue;
        SCOPED_TRACE(static_cast<int>(way));
        auto open = io_open(0x1234);
        refused.change(open);
        EXPECT_EQ(peer.call(in_form(open, way), refused.items),
                  hex(std::string(is_large(way) ? "DB 00 " : "D4 00 ") + refused.status + "3412 4D00 44332211 00 00"));
        ++count;
        expect_nothing_open(site);
        EXPECT_EQ(site.counter(Counter::open_requests), count);
        for (const auto which :
             {Counter::open_format_rejects, Counter::open_resource_rejects, Counter::open_other_rejects}) {
            EXPECT_EQ(site.counter(which), which == refused.counter ? count : 0) << static_cast<int>(which);
        }
        EXPECT_THAT(site.last_warning(), HasSubstr("connection serial 4660 by vendor 77 refused: 0x01"));
        EXPECT_THAT(site.last_warning(), HasSubstr(refused.words));
        EXPECT_EQ(std::ranges::count(site.log, adapter::LogLevel::warning, &IoSite::Line::level), count);
    }
    const auto link = peer.must_open(io_open(0x1234));
    EXPECT_EQ(site.adapter.io().size(), 1U);
    EXPECT_EQ(peer.close(link), closed(link.request.triad));
}

std::vector<Refused> transport_cases() {
    std::vector<Refused> cases;
    for (const unsigned transport_class : {0, 2, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}) {
        cases.push_back(
            {fmt::format("0x0103 class {}", transport_class), "01 01 0301",
             [=](auto& open) { open.transport.transport_class = static_cast<std::uint8_t>(transport_class); },
             Counter::open_format_rejects,
             fmt::format("transport class {} with trigger 0 asked; there are "
                         "class 1 (I/O)",
                         transport_class)});
    }
    for (const unsigned trigger : {3, 4, 5, 6, 7}) {
        cases.push_back({fmt::format("0x0103 trigger {}", trigger), "01 01 0301",
                         [=](auto& open) { open.transport.trigger = static_cast<std::uint8_t>(trigger); },
                         Counter::open_format_rejects, fmt::format("trigger {} asked", trigger)});
    }
    for (const unsigned code : {8, 9, 127, 255}) {
        cases.push_back({fmt::format("0x0133 multiplier {}", code), "01 01 3301",
                         [=](auto& open) { open.timeout_multiplier = static_cast<std::uint8_t>(code); },
                         Counter::open_format_rejects, fmt::format("multiplier code {} asked; 0 to 7", code)});
    }
    return cases;
}
INSTANTIATE_TEST_SUITE_P(R_CON_5_R_CON_6_Transport, IoOpenRefusal, testing::ValuesIn(transport_cases()));

INSTANTIATE_TEST_SUITE_P(
    R_CON_23_Types, IoOpenRefusal,
    testing::Values(
        Refused{"0x0132 null", "01 01 3201",
                [](auto& open) { open.o_to_t.type = open.t_to_o.type = ConnectionType::null; },
                Counter::open_other_rejects, "both directions are null"},
        Refused{"0x0123 O->T null", "01 01 2301", [](auto& open) { open.o_to_t.type = ConnectionType::null; },
                Counter::open_format_rejects, "O->T is point-to-point"},
        Refused{"0x0123 O->T multicast", "01 01 2301",
                [](auto& open) { open.o_to_t.type = ConnectionType::multicast; }},
        Refused{"0x0123 O->T reserved", "01 01 2301", [](auto& open) { open.o_to_t.type = ConnectionType::reserved; }},
        Refused{"0x0124 T->O null", "01 01 2401", [](auto& open) { open.t_to_o.type = ConnectionType::null; },
                Counter::open_format_rejects, "point-to-point or multicast"},
        Refused{"0x0124 T->O reserved", "01 01 2401", [](auto& open) { open.t_to_o.type = ConnectionType::reserved; }},
        Refused{"0x0125 redundant owner", "01 01 2501", [](auto& open) { open.o_to_t.redundant_owner = true; },
                Counter::open_format_rejects, "no redundant owners"}));

// R-CON-11, and its order: vendor and product code, device type, revision.
INSTANTIATE_TEST_SUITE_P(
    R_CON_11_Key, IoOpenRefusal,
    testing::Values(
        with_key("0x0114 vendor", "01 01 1401", "34 04 6E05 2B00 0975 01 01",
                 "asks for vendor 1390, device type 43, product code 0x7509, revision 1.1; this is vendor 1389"),
        with_key("0x0114 product code", "01 01 1401", "34 04 6D05 2B00 0875 01 01", "product code 0x7508"),
        with_key("0x0114 comes before 0x0115 and 0x0116", "01 01 1401", "34 04 6D05 0C00 0875 02 01"),
        with_key("0x0115 device type", "01 01 1501", "34 04 6D05 0C00 0975 01 01", "device type 12"),
        with_key("0x0115 comes before 0x0116", "01 01 1501", "34 04 6D05 0C00 0975 02 01"),
        with_key("0x0116 major", "01 01 1601", "34 04 6D05 2B00 0975 02 01", "revision 2.1"),
        with_key("0x0116 minor", "01 01 1601", "34 04 6D05 2B00 0975 01 02", "revision 1.2"),
        with_key("0x0116 compatible major", "01 01 1601", "34 04 6D05 2B00 0975 82 01", "revision 2.1"),
        with_key("0x0116 compatible minor is newer", "01 01 1601", "34 04 6D05 2B00 0975 81 02"),
        with_key("0x0116 with a serial number in the key", "01 01 1601", "34 05 6D05 2B00 0975 02 01 00000000"),
        with_key("0x0116 behind the own port", "01 01 1601", "01 00 34 04 6D05 2B00 0975 02 01")));

INSTANTIATE_TEST_SUITE_P(
    R_CON_10_R_CON_12_Path, IoOpenRefusal,
    testing::Values(
        at_path("0x0315 no path", "01 01 1503", "", "0 connection points"),
        at_path("0x0315 key alone", "01 01 1503", "34 04 6D05 2B00 0975 01 01"),
        at_path("0x0315 class alone", "01 01 1503", "20 04", "0 connection points"),
        at_path("0x0315 no class", "01 01 1503", "24 01 2C 65 2C 64", "not class 0x04 and then"),
        at_path("0x0315 a reserved logical format", "01 01 1503", "20 04 24 01 2F 65 2C 64", "malformed"),
        at_path("0x0315 a cut segment", "01 01 1503", "20 04 24 01 2C 65 2D 00", "malformed"),
        at_path("0x0315 a reserved segment class", "01 01 1503", "20 04 24 01 E0 00 2C 65 2C 64", "malformed"),
        at_path("0x0315 a key of another format", "01 01 1503", "34 06 6D05 2B00 0975 01 01 2004 2C65 2C64"),
        at_path("0x0315 the key behind the points", "01 01 1503", "20 04 24 01 2C 65 2C 64 34 04 6D05 2B00 0975 01 01"),
        at_path("0x0315 a symbol", "01 01 1503", "91 04 64 61 74 61", "a segment that no I/O connection has"),
        at_path("0x0315 a symbol behind the class", "01 01 1503", "20 04 91 02 64 61 2C 65 2C 64"),
        at_path("0x0315 class 0x02", "01 01 1503", "20 02 24 01", "class 0x02"),
        at_path("0x0315 class 0x66", "01 01 1503", "20 66 24 01 2C 65 2C 64", "class 0x66"),
        at_path("0x0315 another class in the middle", "01 01 1503", "20 04 24 01 2C 65 20 66 2C 64", "class 0x66"),
        at_path("0x0315 a 16-bit class that ends in 04", "01 01 1503", "21 00 04 01 24 01 2C 65 2C 64", "class 0x104"),
        at_path("0x0315 an attribute", "01 01 1503", "20 04 24 64 30 03"),
        at_path("0x0315 a member", "01 01 1503", "20 04 28 01 2C 65 2C 64"),
        at_points("0x0315 four points", "01 01 1503", "2C 65 2C 64 2C 64", "4 connection points"),
        at_path("0x0315 the own port twice", "01 01 1503", "01 00 01 00 20 04 24 01 2C 65 2C 64"),
        at_path("0x0311 a port that is not there", "01 01 1103", "03 00 20 04 24 01 2C 65 2C 64", "routes nowhere"),
        at_path("0x0312 another slot", "01 01 1203", "01 01 20 04 24 01 2C 65 2C 64", "routes nowhere"),
        at_path("0x0312 the network port", "01 01 1203", "12 0B 3139322E3136382E322E35 00 20 04 2C 65 2C 64"),
        at_path("0x012F one point", "01 01 2F01", "20 04 2C 65", "one connection point, 101"),
        at_path("0x012F one instance", "01 01 2F01", "20 04 24 64"),
        at_points("0x012A O->T 99", "01 01 2A01", "2C 63 2C 64", "O->T 99 with T->O 100 is no connection"),
        at_points("0x012A O->T 0", "01 01 2A01", "2C 00 2C 64"),
        at_points("0x012A O->T 256 + 101", "01 01 2A01", "2D 00 65 01 2C 64", "O->T 357"),
        at_points("0x012A O->T 65536 + 101", "01 01 2A01", "2E 00 65 00 01 00 2C 64", "O->T 65637"),
        at_points("0x012B T->O 99", "01 01 2B01", "2C 65 2C 63", "O->T 101 with T->O 99"),
        at_points("0x012B T->O 256 + 100", "01 01 2B01", "2C 65 2D 00 64 01"),
        at_points("0x0117 both unknown", "01 01 1701", "2C 63 2C 62", "these are: 101/100, 102/100"),
        at_points("0x012F 101/105", "01 01 2F01", "2C 65 2C 69", "O->T 101 with T->O 105"),
        at_points("0x012F 101/113", "01 01 2F01", "2C 65 2C 71"),
        at_points("0x012F 104/100", "01 01 2F01", "2C 68 2C 64"),
        at_points("0x012F 112/100", "01 01 2F01", "2C 70 2C 64"),
        at_points("0x012F 103/113", "01 01 2F01", "2C 67 2C 71"),
        at_points("0x012F points exchanged", "01 01 2F01", "2C 64 2C 65"),
        at_points("0x012F 101/101", "01 01 2F01", "2C 65 2C 65"),
        at_points("0x012F 100/100", "01 01 2F01", "2C 64 2C 64"),
        at_points("0x012F 254/101", "01 01 2F01", "2C FE 2C 65"),
        at_points("0x012F 254/255", "01 01 2F01", "2C FE 2C FF"),
        at_points("0x012F 1/100", "01 01 2F01", "2C 01 2C 64"),
        at_points("0x0126 configuration data", "01 02 2601 0000", "2C 65 2C 64 80 01 AA BB",
                  "2 octets of configuration data came; this device takes none"),
        at_points("0x0126 configuration data in front of the points", "01 02 2601 0000",
                  "80 02 AA BB CC DD 2C 65 2C 64", "4 octets")));

TEST(IoOpen, R_CON_10_AClass3OpenDoesNotLeadToAssemblies) {
    IoSite site;
    IoPeer peer(site);
    auto open = io_open(1);
    open.transport = {true, 2, 3};
    EXPECT_EQ(peer.refusal(open), hex("01 01 1503"));
    EXPECT_THAT(site.last_warning(), HasSubstr("a class 3 connection leads to the message router"));
    expect_nothing_open(site);
}

std::vector<Refused> size_cases() {
    std::vector<Refused> cases;
    struct Size {
        unsigned size;
        const char* why;
    };
    for (const auto& [size, why] : {Size{0, "none"}, Size{2, "a heartbeat"}, Size{18, "data alone"},
                                    Size{20, "without header"}, Size{22, "without count"}, Size{23, "one short"},
                                    Size{25, "one too many"}, Size{28, "the header twice"}, Size{511, "the largest"}}) {
        cases.push_back({fmt::format("0x0127 O->T {}, {}", size, why), "01 02 2701 1800",
                         [s = size](auto& open) { open.o_to_t.size = static_cast<std::uint16_t>(s); },
                         Counter::open_format_rejects,
                         fmt::format("O->T size {} asked, 24 expected: 18 of assembly 101 + 2 sequence count + 4 "
                                     "run/idle header",
                                     size)});
    }
    for (const auto& [size, why] : {Size{0, "none"}, Size{28, "without count"}, Size{29, "one short"},
                                    Size{31, "one too many"}, Size{34, "with a header"}, Size{511, "the largest"}}) {
        cases.push_back({fmt::format("0x0128 T->O {}, {}", size, why), "01 02 2801 1E00",
                         [s = size](auto& open) { open.t_to_o.size = static_cast<std::uint16_t>(s); },
                         Counter::open_format_rejects,
                         fmt::format("T->O size {} asked, 30 expected: 28 of assembly 100 + 2 sequence count", size)});
    }
    for (const bool larger : {false, true}) {
        cases.push_back({fmt::format("0x0127 variable {}", larger), "01 02 2701 1800", [=](auto& open) {
                             open.o_to_t.variable = true;
                             open.o_to_t.size = larger ? 25 : 23;
                         }});
        cases.push_back({fmt::format("0x0128 variable {}", larger), "01 02 2801 1E00", [=](auto& open) {
                             open.t_to_o.variable = true;
                             open.t_to_o.size = larger ? 31 : 29;
                         }});
    }
    return cases;
}
INSTANTIATE_TEST_SUITE_P(R_CON_7_R_CON_14_Size, IoOpenRefusal, testing::ValuesIn(size_cases()));

INSTANTIATE_TEST_SUITE_P(
    R_CON_17_R_CON_51_Interval, IoOpenRefusal,
    testing::Values(
        Refused{"0x0111 O->T", "01 01 1101", [](auto& open) { open.o_to_t_rpi = 0; }, Counter::open_format_rejects,
                "0 us O->T and 10000 us T->O asked; at least 1000 us and at most 3200000 us"},
        Refused{"0x0111 T->O", "01 01 1101", [](auto& open) { open.t_to_o_rpi = 0; }},
        Refused{"0x0111 both", "01 01 1101", [](auto& open) { open.t_to_o_rpi = open.o_to_t_rpi = 0; }},
        Refused{"0x0112 O->T 999", "01 06 1201 0200 E8030000 10270000", [](auto& open) { open.o_to_t_rpi = 999; },
                Counter::open_format_rejects, "999 us O->T"},
        Refused{"0x0112 T->O 1", "01 06 1201 0002 10270000 E8030000", [](auto& open) { open.t_to_o_rpi = 1; }},
        Refused{"0x0112 both 500", "01 06 1201 0202 E8030000 E8030000",
                [](auto& open) { open.o_to_t_rpi = open.t_to_o_rpi = 500; }},
        Refused{"0x0112 O->T 3200001", "01 06 1201 0300 00D43000 10270000",
                [](auto& open) { open.o_to_t_rpi = 3'200'001; }},
        Refused{"0x0112 T->O longest", "01 06 1201 0003 10270000 00D43000",
                [](auto& open) { open.t_to_o_rpi = 0xFFFFFFFF; }},
        Refused{"0x0112 one each", "01 06 1201 0302 00D43000 E8030000",
                [](auto& open) {
                    open.o_to_t_rpi = 4'000'000;
                    open.t_to_o_rpi = 999;
                }},
        Refused{"0x011B change of state", "01 01 1B01", [](auto& open) { open = on_change(open, 11); },
                Counter::open_format_rejects, "inhibit time is 11000 us and the T->O interval 10000 us"},
        Refused{"0x011B application", "01 01 1B01", [](auto& open) { open = on_change(open, 255, 2); }},
        Refused{"0x011B one microsecond", "01 01 1B01",
                [](auto& open) {
                    open.transport.trigger = 1;
                    open.path = octets("20 04 51 02 11270000 24 01 2C 65 2C 64");
                },
                Counter::open_format_rejects, "10001 us"}));

cip::Bytes socket_octets(std::uint16_t family, std::uint16_t port) {
    return enip::SocketAddress{.family = family, .port = port, .address = IoPeer::usual_address}.encode();
}
std::vector<Refused> socket_cases() {
    std::vector<Refused> cases;
    for (const auto type : {enip::ItemType::sockaddr_o_to_t, enip::ItemType::sockaddr_t_to_o}) {
        const auto name = fmt::format("0x{:04X}", static_cast<unsigned>(type));
        const auto good = socket_octets(2, 3000);
        cases.push_back(with_items(name + " family 1", {{type, socket_octets(1, 3000)}}));
        cases.push_back(with_items(name + " family in the wrong order", {{type, socket_octets(0x0200, 3000)}}));
        cases.push_back(with_items(name + " port 0", {{type, socket_octets(2, 0)}}));
        cases.push_back(with_items(name + " 15 octets", {{type, {good.begin(), good.end() - 1}}}));
        cases.push_back(with_items(name + " 17 octets", {{type, good + cip::Bytes{0}}}));
        cases.push_back(with_items(name + " empty", {{type, {}}}));
        cases.push_back(with_items(name + " twice", {{type, good}, {type, good}}));
    }
    return cases;
}
INSTANTIATE_TEST_SUITE_P(R_CPF_9_SocketItems, IoOpenRefusal, testing::ValuesIn(socket_cases()));

TEST(IoOpen, R_CPF_9_ABadSocketItemIsRefusedForMulticastToo) {
    IoSite site;
    IoPeer peer(site);
    const std::vector<enip::Item> bad{{enip::ItemType::sockaddr_t_to_o, socket_octets(2, 0)}};
    EXPECT_EQ(peer.refusal(multicast(io_open(1)), bad), hex("01 01 0502"));
    expect_nothing_open(site);
}

TEST(IoOpen, R_CPF_10_OtherItemsAreIgnored) {
    IoSite site;
    IoPeer peer(site);
    EXPECT_TRUE(peer.open(io_open(1), {{static_cast<enip::ItemType>(0x0077), octets("01 02 03")}}));
}

// R-CON-14: at every length, with the triad as far as it came.
TEST(IoOpen, R_CON_14_TooShortAndTooLong) {
    for (const bool large : {false, true}) {
        IoSite site;
        IoPeer peer(site);
        auto open = io_open(0x1234);
        open.large = large;
        const auto data = open.encode();
        const std::uint8_t service = large ? 0x5B : 0x54;
        unsigned refused = 0;
        const auto answer_to = [&](cip::ByteView part) {
            ++refused;
            return peer.call(cip::Request{service, cip::Path::to(6, 1), {part.begin(), part.end()}}.encode());
        };
        const std::string head = large ? "DB 00 " : "D4 00 ";
        for (std::size_t length = 0; length < data.size(); ++length) {
            const std::string triad = length < 18 ? "0000 0000 00000000" : "3412 4D00 44332211";
            EXPECT_EQ(answer_to(cip::ByteView(data).first(length)), hex(head + "13 00" + triad + "00 00")) << length;
        }
        EXPECT_THAT(site.last_warning(), HasSubstr("octets end before its connection path does"));
        for (const auto* more : {"00", "00 00", "2C 64"}) {
            EXPECT_EQ(answer_to(data + octets(more)), hex(head + "15 00 3412 4D00 44332211 00 00")) << more;
        }
        EXPECT_THAT(site.last_warning(), HasSubstr("octets end after its connection path does"));
        auto words = data;
        --words[large ? 39 : 35];
        EXPECT_EQ(answer_to(words), hex(head + "15 00 3412 4D00 44332211 00 00"));
        words[large ? 39 : 35] += 2;
        EXPECT_EQ(answer_to(words), hex(head + "13 00 3412 4D00 44332211 00 00"));
        EXPECT_EQ(site.counter(Counter::open_format_rejects), refused);
        EXPECT_EQ(site.counter(Counter::open_requests), refused);
        expect_nothing_open(site);
        EXPECT_TRUE(peer.open(open));
    }
}

TEST(IoOpen, R_CON_4_TheLargeFormMayNameSizesThatTheSmallOneCannot) {
    IoSite site;
    IoPeer peer(site);
    auto open = io_open(1);
    open.large = true;
    open.o_to_t.size = 0x0218;  // 24 in the nine bits of the small form
    EXPECT_EQ(peer.refusal(open), hex("01 02 2701 1800"));
    open = io_open(1);
    open.large = true;
    open.t_to_o.size = 0xFFFF;
    EXPECT_EQ(peer.refusal(open), hex("01 02 2801 1E00"));
    expect_nothing_open(site);
}

TEST(IoOpen, R_CM_10_NotThroughTwoUnconnectedSends) {
    IoSite site;
    IoPeer peer(site);
    EXPECT_EQ(peer.call(through_unconnected_send(through_unconnected_send(request_of(io_open(1))))),
              hex("D2 00 08 00"));
    EXPECT_EQ(peer.call(through_unconnected_send(request_of(io_open(1)), "03 00")), hex("D2 00 01 01 1103 01 00"));
    EXPECT_EQ(peer.call(through_unconnected_send(request_of(io_open(1)), "01 05")), hex("D2 00 01 01 1203 01 00"));
    EXPECT_EQ(site.counter(Counter::open_requests), 0U);
    expect_nothing_open(site);
}

// ------------------------------------------------------------------------------------------ what depends on the others

TEST(IoOpen, R_CON_26_ADuplicateIsRefusedWhateverItAsksForAndTheOpenOneStays) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    std::vector<cip::ForwardOpen> again{io_open(1), io_open(1, 102), io_open(1, 254), multicast(io_open(1, 255))};
    again.push_back(io_open(1));
    again.back().o_to_t_rpi = 0;
    again.push_back(io_open(1));
    again.back().path = octets("20 66");
    again.push_back(io_open(1));
    again.back().transport = {true, 2, 3};
    unsigned count = 0;
    for (const auto& open : again) {
        for (const auto way : all_ways) {
            EXPECT_EQ(peer.call(in_form(open, way)),
                      hex(std::string(is_large(way) ? "DB 00" : "D4 00") + "01 01 0001 0100 4D00 44332211 00 00"));
            EXPECT_EQ(site.counter(Counter::open_other_rejects), ++count);
        }
    }
    EXPECT_THAT(site.last_warning(), HasSubstr("serial number, vendor and originator serial is open"));
    ASSERT_EQ(site.adapter.io().size(), 1U);
    EXPECT_EQ(site.adapter.io().all().front()->o_to_t_id, link.reply.o_to_t_id);
    site.advance(10ms);
    EXPECT_EQ(site.take().size(), 1U);
    // Each part of the triad makes another connection.
    for (auto open : {io_open(2, 254), io_open(1, 254), io_open(1, 254)}) {
        static unsigned which = 0;
        if (++which == 2) open.triad.originator_vendor = 0x4E;
        if (which == 3) open.triad.originator_serial = 1;
        EXPECT_TRUE(peer.open(open)) << which;
    }
    // From another address it is the same connection.
    IoPeer other(site, 0xC0A80202);
    EXPECT_EQ(other.refusal(io_open(1)), hex("01 01 0001"));
}

TEST(IoOpen, R_CON_23_ANullOpenIsRefusedWithAndWithoutAnOpenTriad) {
    IoSite site;
    IoPeer peer(site);
    (void)peer.must_open(io_open(1));
    auto open = io_open(1);
    open.o_to_t.type = open.t_to_o.type = ConnectionType::null;
    EXPECT_EQ(peer.refusal(open), hex("01 01 3201"));
    open.triad.serial_number = 2;
    EXPECT_EQ(peer.refusal(open), hex("01 01 3201"));
    open.o_to_t.size = open.t_to_o.size = 0;
    EXPECT_EQ(peer.refusal(open), hex("01 01 3201"));
    EXPECT_EQ(site.adapter.io().size(), 1U);
}

TEST(IoOpen, R_CON_30_OneOwnerInTheWholeDevice) {
    for (const auto first : owner_points) {
        IoSite site;
        IoPeer peer(site);
        IoPeer other(site, 0xC0A80202);
        const auto link = peer.must_open(io_open(1, first));
        unsigned count = 0;
        for (const auto second : owner_points) {
            auto open = io_open(2, second);
            EXPECT_EQ(peer.refusal(open), hex("01 01 0601")) << first << ", then " << second;
            EXPECT_EQ(other.refusal(multicast(open)), hex("01 01 0601")) << first << ", then " << second;
            count += 2;
        }
        EXPECT_THAT(site.last_warning(),
                    HasSubstr(fmt::format("exclusive owner {}/{} of 192.168.2.1 is open (connection serial 1 of vendor "
                                          "77)",
                                          first, points_of(first).t_to_o)));
        EXPECT_EQ(site.counter(Counter::open_other_rejects), count);
        EXPECT_EQ(site.adapter.io().size(), 1U);
        EXPECT_EQ(peer.close(link), closed(link.request.triad));
        EXPECT_TRUE(other.open(io_open(2, 112))) << "free at once";
    }
}

TEST(IoOpen, R_CON_32_AListenerNeedsSomebodyElsesMulticastOfTheSamePoint) {
    IoSite site;
    IoPeer peer(site);
    const std::string refused = hex("01 01 1901");
    EXPECT_EQ(peer.refusal(multicast(io_open(9, 255))), refused);
    EXPECT_THAT(site.last_warning(), HasSubstr("nobody has opened T->O 100 by multicast"));
    EXPECT_EQ(peer.refusal(io_open(9, 255)), refused);
    EXPECT_THAT(site.last_warning(), HasSubstr("a listener asks for multicast"));
    const auto p2p = peer.must_open(io_open(1));
    EXPECT_EQ(peer.refusal(multicast(io_open(9, 255))), refused) << "an owner's own stream is not for listeners";
    (void)peer.close(p2p);
    const auto owner = peer.must_open(multicast(io_open(2)));
    EXPECT_EQ(peer.refusal(multicast(io_open(9, 255, 105))), refused) << "another point";
    EXPECT_EQ(peer.refusal(io_open(9, 255)), refused) << "P2P";
    EXPECT_EQ(site.counter(Counter::open_other_rejects), 5U);
    const auto listener = peer.must_open(multicast(io_open(9, 255)));
    EXPECT_EQ(listener.reply.t_to_o_id, owner.reply.t_to_o_id);
    EXPECT_EQ(site.adapter.io().size(), 2U);
}

TEST(IoOpen, R_CON_32_AListenerIsNoReasonForAnotherListener) {
    IoSite site;
    IoPeer peer(site);
    const auto first = peer.must_open(multicast(io_open(1, 254)));
    (void)peer.must_open(multicast(io_open(2, 255)));
    (void)peer.close(first);
    EXPECT_EQ(site.adapter.io().size(), 0U);
    EXPECT_EQ(peer.refusal(multicast(io_open(3, 255))), hex("01 01 1901"));
}

TEST(IoOpen, R_CON_48_OneOwnerAndEightThatLookOn) {
    IoSite site;
    IoPeer peer(site);
    std::vector<Link> links;
    links.push_back(peer.must_open(multicast(io_open(1))));
    for (std::uint16_t serial = 2; serial <= 9; ++serial) {
        links.push_back(peer.must_open(multicast(io_open(serial, serial % 2 == 0 ? 254 : 255))));
    }
    EXPECT_EQ(site.adapter.io().size(), 9U);
    for (const auto point : std::array<std::uint16_t, 2>{254, 255}) {
        EXPECT_EQ(peer.refusal(multicast(io_open(10, point))), hex("01 01 1301"));
    }
    EXPECT_THAT(site.last_warning(), HasSubstr("all 8 connections of those who look on are in use"));
    EXPECT_EQ(site.counter(Counter::open_resource_rejects), 2U);
    EXPECT_EQ(site.counter(Counter::open_other_rejects) + site.counter(Counter::open_format_rejects), 0U);
    EXPECT_EQ(peer.refusal(multicast(io_open(10))), hex("01 01 0601")) << "the owner's place is another matter";
    (void)peer.close(links[4]);
    EXPECT_TRUE(peer.open(multicast(io_open(10, 254))));
    EXPECT_EQ(peer.refusal(multicast(io_open(11, 254))), hex("01 01 1301"));
}

TEST(IoOpen, R_CON_48_LookersOnDoNotKeepTheOwnerOut) {
    IoSite site;
    IoPeer peer(site);
    for (std::uint16_t serial = 2; serial <= 9; ++serial) (void)peer.must_open(io_open(serial, 254));
    EXPECT_TRUE(peer.open(io_open(1)));
}

TEST(IoOpen, R_CON_48_TheLimitIsTheOneOfTheConfiguration) {
    adapter::Limits limits;
    limits.listening_connections = 0;
    IoSite site(drive::Device(drive::xenax_models().front()), limits);
    IoPeer peer(site);
    EXPECT_EQ(peer.refusal(io_open(1, 254)), hex("01 01 1301"));
    EXPECT_TRUE(peer.open(io_open(1)));
}

TEST(IoOpen, R_MC_4_NoMulticastForAnotherSubnet) {
    struct Case {
        unsigned bits;
        std::uint32_t originator;
        bool arrives;
    };
    for (const auto& each : {Case{24, 0xC0A80201, true}, Case{24, 0xC0A802FE, true}, Case{24, 0xC0A80301, false},
                             Case{24, 0x0A000001, false}, Case{22, 0xC0A80301, true}, Case{22, 0xC0A80401, false},
                             Case{25, 0xC0A80281, false}, Case{0, 0xC0A80301, true}}) {
        IoSite site(drive::Device(drive::xenax_models().front()), {}, IoSite::in_subnet(each.bits));
        IoPeer peer(site, each.originator);
        SCOPED_TRACE(fmt::format("{:08X}/{}", each.originator, each.bits));
        if (each.arrives) {
            EXPECT_TRUE(peer.open(multicast(io_open(1))));
            continue;
        }
        EXPECT_EQ(peer.refusal(multicast(io_open(1))), hex("01 01 1308"));
        EXPECT_THAT(site.last_warning(), HasSubstr("is in another subnet, where multicast with TTL 1 does not arrive"));
        EXPECT_EQ(site.counter(Counter::open_other_rejects), 1U);
        expect_nothing_open(site);
        EXPECT_TRUE(peer.open(io_open(1))) << "point-to-point goes through routers";
    }
}

struct Joining {
    const char* what;
    const char* status;
    std::function<void(cip::ForwardOpen&)> change;
    const char* words;
};
TEST(IoOpen, R_CON_33_WhoJoinsTakesWhatIsThere) {
    const std::vector<Joining> cases{
        {"shorter interval", "01 06 1201 0004 10270000 10270000", [](auto& open) { open.t_to_o_rpi = 5000; },
         "T->O 100 is already sent by multicast every 10000 us; 5000 us asked"},
        {"longer interval", "01 06 1201 0004 10270000 10270000", [](auto& open) { open.t_to_o_rpi = 10'001; },
         "10001 us asked"},
        {"size", "01 02 2801 1E00", [](auto& open) { open.t_to_o.size = 31; }, "T->O size 31 asked"},
        {"variable", "01 01 3501", [](auto& open) { open.t_to_o.variable = true; }, "fixed or variable"},
        {"priority", "01 01 3601", [](auto& open) { open.t_to_o.priority = cip::Priority::urgent; }, "priority"},
        {"trigger", "01 01 3801", [](auto& open) { open.transport.trigger = 2; }, "trigger"},
        {"inhibit time", "01 01 3901", [](auto& open) { open = on_change(open, 3); },
         "a production inhibit time of 5000 us"},
        {"no inhibit time", "01 01 3901", [](auto& open) { open = on_change(open, 0); }, "5000 us"},
    };
    for (const auto& each : cases) {
        IoSite site;
        IoPeer peer(site);
        SCOPED_TRACE(each.what);
        const auto first = peer.must_open(multicast(on_change(io_open(1, 254), 5)));
        for (const auto point : std::array<std::uint16_t, 3>{101, 254, 255}) {
            auto open = multicast(io_open(2, point));
            if (std::string_view(each.what).find("inhibit") == std::string_view::npos) open = on_change(open, 5);
            each.change(open);
            EXPECT_EQ(peer.refusal(open), hex(each.status)) << point;
            EXPECT_THAT(site.last_warning(), HasSubstr(each.words));
        }
        EXPECT_EQ(site.counter(Counter::open_format_rejects), 3U);
        EXPECT_EQ(site.adapter.io().size(), 1U);
        auto same = multicast(on_change(io_open(2), 5));
        same.o_to_t_rpi = 2000;  // its own direction is its own matter
        same.o_to_t.priority = cip::Priority::low;
        same.o_to_t.variable = true;
        same.timeout_multiplier = 7;
        const auto joined = peer.must_open(same);
        EXPECT_EQ(joined.reply.t_to_o_id, first.reply.t_to_o_id);
        auto own = io_open(3, 254);  // and who wants a stream of its own has it as it likes
        own.t_to_o_rpi = 3000;
        EXPECT_TRUE(peer.open(own));
    }
}

TEST(IoOpen, R_CON_33_CyclicHasNoInhibitTimeToDisagreeAbout) {
    IoSite site;
    IoPeer peer(site);
    (void)peer.must_open(multicast(io_open(1)));
    auto open = multicast(io_open(2, 254));
    open.path = octets("43 05 20 04 24 01 2C FE 2C 64");
    EXPECT_TRUE(peer.open(open));
}

// --------------------------------------------------------------------------------------------------------- legal forms

TEST(IoOpen, R_CON_13_TheReplyOfEachConnectionOctetByOctet) {
    for (const auto way : all_ways) {
        for (const auto& points : all_points) {
            IoSite site;
            IoPeer peer(site);
            SCOPED_TRACE(fmt::format("{}/{} way {}", points.o_to_t, points.t_to_o, static_cast<int>(way)));
            if (points.o_to_t == 255) (void)peer.must_open(multicast(io_open(0x99, 254, points.t_to_o)));
            auto open = io_open(0x1234, points.o_to_t, points.t_to_o);
            open.o_to_t_rpi = 20'000;
            if (points.o_to_t == 255) open = multicast(open);
            const auto answer = peer.ask(in_form(open, way)).message;
            ASSERT_EQ(answer.size(), 4U + 26);
            EXPECT_EQ(hex(cip::ByteView(answer).first(4)), hex(is_large(way) ? "DB 00 00 00" : "D4 00 00 00"));
            EXPECT_EQ(hex(cip::ByteView(answer).subspan(12)), hex("3412 4D00 44332211 204E0000 10270000 00 00"));
            cip::Reader ids(cip::ByteView(answer).subspan(4));
            const auto o_to_t = ids.u32();
            const auto t_to_o = ids.u32();
            EXPECT_NE(o_to_t, 0U);
            EXPECT_NE(o_to_t, t_to_o);
            EXPECT_EQ(t_to_o == open.t_to_o_id, points.o_to_t != 255)
                << "R-CON-16: the originator's, but for multicast";
            EXPECT_THAT(
                site.last_line(adapter::LogLevel::info),
                HasSubstr(fmt::format("{}/{} of 192.168.2.1 open: O->T every 20000 us", points.o_to_t, points.t_to_o)));
        }
    }
}

TEST(IoOpen, R_CON_10_EveryFormOfThePath) {
    for (const auto* path : {
             "20 04 24 01 2C 65 2C 64",
             "20 04 2C 65 2C 64",  // R-CON-12: no configuration
             "20 04 24 01 24 65 24 64",
             "20 04 2C 01 2C 65 2C 64",
             "20 04 24 65 24 64",
             "20 04 24 01 20 04 2C 65 20 04 2C 64",
             "20 04 2C 65 20 04 24 64",
             "01 00 20 04 24 01 2C 65 2C 64",
             "01 00 34 04 6D05 2B00 0975 01 01 20 04 24 01 2C 65 2C 64",
             "21 00 04 00 25 00 01 00 2D 00 65 00 2D 00 64 00",
             "22 00 04000000 26 00 01000000 2E 00 65000000 2E 00 64000000",
             "20 04 25 00 01 00 2C 65 2E 00 64000000",
             "20 04 24 C8 2C 65 2C 64",  // any configuration instance
             "20 04 25 00 34 12 2C 65 2C 64",
             "20 04 24 01 2C 65 2C 64 80 00",  // no configuration data
             "43 05 20 04 24 01 2C 65 2C 64",  // R-CON-51: ignored when cyclic, also one that is too long
             "20 04 24 01 43 FF 2C 65 2C 64",
             "20 04 24 01 2C 65 2C 64 51 02 FFFFFFFF",
             "34 04 6D05 2B00 0975 01 01 43 05 20 04 24 01 2C 65 2C 64",
             "34 04 0000 0000 0000 00 00 20 04 24 01 2C 65 2C 64",
             "34 04 6D05 2B00 0975 01 00 20 04 24 01 2C 65 2C 64",
             "34 04 6D05 2B00 0975 81 01 20 04 24 01 2C 65 2C 64",
             "34 04 6D05 0000 0000 80 00 20 04 24 01 2C 65 2C 64",
             "34 05 6D05 2B00 0975 01 01 00000000 20 04 24 01 2C 65 2C 64",
         }) {
        for (const auto way : all_ways) {
            IoSite site;
            IoPeer peer(site);
            auto open = io_open(1);
            open.path = octets(path);
            const auto answer = peer.ask(in_form(open, way)).message;
            ASSERT_EQ(answer.size(), 30U) << path << ": " << site.last_warning();
            ASSERT_NE(site.adapter.io().owner(), nullptr) << path;
            EXPECT_EQ(site.adapter.io().owner()->kind->o_to_t_point, 101) << path;
        }
    }
}

TEST(IoOpen, R_CON_1_WhatTheTargetDoesNotLookAt) {
    const std::vector<std::function<void(cip::ForwardOpen&)>> changes{
        [](auto& open) { open.priority_tick = 0xFF; },
        [](auto& open) { open.timeout_ticks = 0; },
        [](auto& open) { open.o_to_t_id = 0xDEADBEEF; },
        [](auto& open) { open.t_to_o_id = 0; },
        [](auto& open) { open.t_to_o_id = 0xFFFFFFFF; },
        [](auto& open) { open.triad = {}; },
        [](auto& open) { open.transport.server = true; },
        [](auto& open) { open.o_to_t.variable = true; },
        [](auto& open) { open.t_to_o.variable = true; },
        [](auto& open) { open.o_to_t.variable = open.t_to_o.variable = true; },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        for (const auto way : all_ways) {
            IoSite site;
            IoPeer peer(site);
            auto open = io_open(1);
            changes[i](open);
            EXPECT_EQ(peer.ask(in_form(open, way)).message.size(), 30U) << i << ": " << site.last_warning();
        }
    }
    // Reserved octets and bit 12 (28) of the parameters.
    IoSite site;
    IoPeer peer(site);
    auto data = io_open(1).encode();
    data[19] = data[20] = data[21] = 0xFF;
    data[27] |= 0x10;
    data[33] |= 0x10;
    EXPECT_EQ(peer.ask(cip::Request{0x54, cip::Path::to(6, 1), data}.encode()).message.size(), 30U);
}

TEST(IoOpen, R_CON_3_R_CON_5_EachPriorityTriggerAndType) {
    for (const auto priority :
         {cip::Priority::low, cip::Priority::high, cip::Priority::scheduled, cip::Priority::urgent}) {
        for (const auto trigger : std::array<std::uint8_t, 3>{0, 1, 2}) {
            for (const auto type : {ConnectionType::point_to_point, ConnectionType::multicast}) {
                for (const auto way : all_ways) {
                    IoSite site;
                    IoPeer peer(site);
                    auto open = io_open(1);
                    open.o_to_t.priority = open.t_to_o.priority = priority;
                    open.transport.trigger = trigger;
                    open.t_to_o.type = type;
                    EXPECT_EQ(peer.ask(in_form(open, way)).message.size(), 30U) << site.last_warning();
                    site.advance(10ms);
                    const auto sent = site.take();
                    ASSERT_EQ(sent.size(), 1U);
                    constexpr std::array<unsigned, 4> dscp{31, 43, 47, 55};  // R-QOS-5
                    EXPECT_EQ(sent[0].route.dscp, dscp[static_cast<std::size_t>(priority)]);
                    EXPECT_EQ(sent[0].route.ttl, type == ConnectionType::multicast ? 1 : 0) << "R-IO-11";
                    EXPECT_EQ(sent[0].route.local, (enip::Endpoint{IoSite::address, 2222}));
                }
            }
        }
    }
}

TEST(IoOpen, R_CON_6_R_CON_17_EachMultiplierAndTheIntervalsAtTheirLimits) {
    for (std::uint8_t code = 0; code < 8; ++code) {
        for (const std::uint32_t o_to_t : {1000U, 1001U, 3'200'000U}) {
            for (const std::uint32_t t_to_o : {1000U, 12'345U, 3'200'000U}) {
                IoSite site;
                IoPeer peer(site);
                auto open = io_open(1);
                open.timeout_multiplier = code;
                open.o_to_t_rpi = o_to_t;
                open.t_to_o_rpi = t_to_o;
                const auto link = peer.must_open(open);
                EXPECT_EQ(link.reply.o_to_t_api, o_to_t) << "the interval that is granted is the one that is kept";
                EXPECT_EQ(link.reply.t_to_o_api, t_to_o);
                EXPECT_EQ(site.adapter.io().owner()->consumer.settings().timeout, microseconds(o_to_t) * (4 << code));
            }
        }
    }
}

TEST(IoOpen, R_CON_51_TheInhibitTimeMayBeAsLongAsTheInterval) {
    for (const auto* path :
         {"43 0A 20 04 24 01 2C 65 2C 64", "20 04 51 02 10270000 24 01 2C 65 2C 64", "20 04 24 01 2C 65 2C 64 43 00"}) {
        for (const auto trigger : std::array<std::uint8_t, 2>{1, 2}) {
            IoSite site;
            IoPeer peer(site);
            auto open = io_open(1);
            open.transport.trigger = trigger;
            open.path = octets(path);
            EXPECT_TRUE(peer.open(open)) << path << ": " << site.last_warning();
        }
    }
}

TEST(IoOpen, R_CON_16_IdsDifferFromEachOtherAndFromClass3) {
    IoSite site;
    IoPeer peer(site);
    auto messages = io_open(100);
    messages.transport = {true, 2, 3};
    messages.path = octets("20 02 24 01");
    messages.o_to_t.size = messages.t_to_o.size = 500;
    std::vector<std::uint32_t> ids;
    const auto class3 = peer.must_open(messages);
    ids.push_back(class3.reply.o_to_t_id);
    // As many opens as there are ids: those that are in use are passed over.
    for (unsigned i = 0; i < 0x10000; ++i) {
        const auto link = peer.must_open(io_open(1, 254));
        ASSERT_NE(link.reply.o_to_t_id, class3.reply.o_to_t_id) << "after " << i << " opens";
        ASSERT_EQ(link.reply.o_to_t_id >> 16, class3.reply.o_to_t_id >> 16);
        ASSERT_EQ(peer.close(link), closed(link.request.triad));
        site.log.clear();
    }
}

// ------------------------------------------------------------------------------------------------------------ closing

TEST(IoOpen, R_CON_36_WhatAForwardCloseIsRefusedWith) {
    IoSite site;
    IoPeer peer(site);
    IoPeer other(site, 0xC0A80202);
    const auto link = peer.must_open(io_open(1));
    EXPECT_EQ(other.close(link), hex("CE 00 0F 00 0100 4D00 44332211 00 00")) << "not its originator";
    EXPECT_EQ(site.counter(Counter::close_other_rejects), 1U);
    for (auto triad : {cip::ConnectionTriad{2, 0x4D, 0x11223344}, cip::ConnectionTriad{1, 0x4E, 0x11223344},
                       cip::ConnectionTriad{1, 0x4D, 0x11223345}}) {
        EXPECT_EQ(peer.close(triad), hex(cip::Response{0x4E, cip::ConnectionFailure::connection_not_found,
                                                       cip::ConnectionRefusal{triad, 0}.encode()}
                                             .encode()));
    }
    EXPECT_EQ(site.counter(Counter::close_other_rejects), 4U);
    const auto data =
        cip::ForwardClose{.triad = link.request.triad, .path = octets("20 04 24 01 2C 65 2C 64")}.encode();
    const auto answer_to = [&](cip::ByteView part) {
        return peer.call(cip::Request{0x4E, cip::Path::to(6, 1), {part.begin(), part.end()}}.encode());
    };
    for (std::size_t length = 0; length < data.size(); ++length) {
        EXPECT_EQ(
            answer_to(cip::ByteView(data).first(length)),
            hex(std::string("CE 00 13 00") + (length < 10 ? "0000 0000 00000000" : "0100 4D00 44332211") + "00 00"));
    }
    EXPECT_EQ(answer_to(data + octets("00")), hex("CE 00 15 00 0100 4D00 44332211 00 00"));
    EXPECT_EQ(site.counter(Counter::close_format_rejects), data.size() + 1);
    EXPECT_EQ(site.adapter.io().size(), 1U);
    // R-CON-35: the path does not count.
    cip::ForwardClose close{.triad = link.request.triad, .path = octets("20 66 24 01")};
    EXPECT_EQ(peer.call(cip::Request{0x4E, cip::Path::to(6, 1), close.encode()}.encode()), closed(link.request.triad));
    EXPECT_EQ(peer.close(link), hex("CE 00 01 01 0701 0100 4D00 44332211 00 00")) << "once";
    EXPECT_EQ(site.counter(Counter::close_requests), 1 + 3 + data.size() + 1 + 2);
}

TEST(IoOpen, R_CON_34_AnotherConnectionOfTheSameOriginatorMayClose) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.disconnect();
    IoPeer again(site);
    EXPECT_EQ(again.close(link), closed(link.request.triad));
    EXPECT_EQ(site.adapter.io().size(), 0U);
}

}  // namespace
}  // namespace servobus::test
