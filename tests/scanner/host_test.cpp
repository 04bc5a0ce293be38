#include "scanner/host.hpp"

#include <gtest/gtest.h>

#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner {
namespace {

using test::hex;

TEST(Host, IsANameOrAnAddressAndAPort) {
    EXPECT_EQ(*parse_host("192.168.2.100"), (Host{"192.168.2.100", 44818}));
    EXPECT_EQ(*parse_host("192.168.2.100:1"), (Host{"192.168.2.100", 1}));
    EXPECT_EQ(*parse_host("drive-1.local:65535"), (Host{"drive-1.local", 65535}));
    EXPECT_EQ(*parse_host("::1"), (Host{"::1", 44818}));
    EXPECT_EQ(*parse_host("[::1]"), (Host{"::1", 44818}));
    EXPECT_EQ(*parse_host("[fe80::1%eth0]:502"), (Host{"fe80::1%eth0", 502}));
}

TEST(Host, IsNothingElse) {
    for (const auto* text : {"",       ":",   ":44818", "a:",      "a:0",       "a:65536",   "a:-1",     "a:1x",
                             "a b",    "a/b", "a\n",    "1.2.3",   "1.2.3.4.5", "999.1.1.1", "1..2.3",   "[::1",
                             "[::1]x", "[]",  "[::1]:", "[::1]:0", "[a b]",     "http://a",  "-\xC3\xA4"}) {
        const auto host = parse_host(text);
        ASSERT_FALSE(host) << text;
        EXPECT_NE(host.error().text.find(text), std::string::npos);
    }
    EXPECT_TRUE(parse_host(std::string(253, 'a')));
    EXPECT_FALSE(parse_host(std::string(254, 'a')));
}

TEST(Host, PrintsAsItIsTyped) {
    for (const auto* text : {"192.168.2.100", "drive:502", "[::1]:502"}) EXPECT_EQ(to_string(*parse_host(text)), text);
}

TEST(Route, IsPortsAndLinks) {
    EXPECT_EQ(parse_route("1/0")->encode(), hex("01 00"));
    EXPECT_EQ(parse_route("1/255,2/3")->encode(), hex("01 FF 02 03"));
    EXPECT_EQ(parse_route("2/192.168.1.10")->encode(), hex("12 0C 31 39 32 2E 31 36 38 2E 31 2E 31 30"));
    EXPECT_EQ(parse_route("2/10.0.0.1")->encode(), hex("12 08 31 30 2E 30 2E 30 2E 31"));
    EXPECT_EQ(parse_route("2/10.0.0.12")->encode(), hex("12 09 31 30 2E 30 2E 30 2E 31 32 00"));
    EXPECT_EQ(parse_route("20/7")->encode(), hex("0F 14 00 07"));
}

TEST(Route, IsNothingElse) {
    for (const auto* text : {"", "1", "1/", "/1", "0/1", "1/256", "1/x", "1/0,", ",1/0", "1/0,,1/0", "65536/1",
                             "1/1.2.3", "1/a b", "a/1"}) {
        EXPECT_FALSE(parse_route(text)) << text;
    }
    std::string hops = "1/0";
    for (std::size_t i = 1; i < cip::max_path_words; ++i) hops += ",1/0";
    EXPECT_TRUE(parse_route(hops));
    EXPECT_FALSE(parse_route(hops + ",1/0"));
}

}  // namespace
}  // namespace servobus::scanner
