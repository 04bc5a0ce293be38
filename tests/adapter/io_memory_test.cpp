// The path of class 1 data asks for no memory once it runs, so that no cycle waits for an allocator.
#include <gmock/gmock.h>

#include "tests/adapter/io_site.hpp"
#include "tests/support/allocations.hpp"

namespace servobus::test {
namespace {

void put(cip::Bytes& octets, std::size_t at, std::uint32_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) octets[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

struct Setting {
    const char* name;
    bool machine;
    std::uint16_t point;
};

class IoMemory : public testing::TestWithParam<Setting> {};

TEST_P(IoMemory, NoneIsAskedForOnceItRuns) {
    IoSite site(GetParam().machine ? drive::Device(*drive::xenax_model("75v8s"), drive::Machine{})
                                   : drive::Device(drive::xenax_models().front()));
    IoPeer peer(site);
    const auto point = GetParam().point;
    const auto input = points_of(point).t_to_o;
    const auto owner = peer.must_open(every(multicast(io_open(1, point)), 1000));
    const auto looker = peer.must_open(every(multicast(io_open(2, 254, input)), 1000));
    const auto listener = peer.must_open(every(multicast(io_open(3, 255, input)), 1000));
    const auto changes = peer.must_open(every(on_change(io_open(4, 254, input), 0), 10'000));
    auto output = o_to_t(owner, 0, 0, run, cip::Bytes(points_of(point).o_to_t_size - 6U));
    std::array<cip::Bytes, 3> beats{heartbeat(looker, 0), heartbeat(listener, 0), heartbeat(changes, 0)};
    const auto old = output;
    const auto stray = octets("02 00");
    auto unknown = output;
    unknown[9] ^= 0xFF;

    std::uint64_t sent = 0;
    const auto on_io = [&](const cip::Bytes& datagram) {
        site.adapter.on_io({IoPeer::usual_address, 2222}, {IoSite::address, 2222}, datagram, site.now);
    };
    const auto cycle = [&](std::uint32_t number) {
        put(output, 10, number, 4);
        put(output, 18, number, 2);
        put(output, 20, number % 100 == 0 ? idle : run, 4);
        put(output, 24, number, 4);         // the target position
        put(output, 28, 1000 + number, 4);  // the speed
        put(output, 32, 2'000'000, 4);
        on_io(output);
        for (auto& beat : beats) {
            put(beat, 10, number, 4);
            on_io(beat);
        }
        for (const cip::Bytes* bad : {&old, &stray, &std::as_const(unknown)}) on_io(*bad);
        const auto end = site.now + 1ms;
        for (auto next = site.adapter.next_deadline(); next && *next <= end; next = site.adapter.next_deadline()) {
            site.now = std::max(site.now, *next);
            site.adapter.on_timer(site.now);
            sent += site.adapter.io_queue().entries().size();
            site.adapter.io_queue().clear();
            (void)site.adapter.take_datagrams();
            (void)site.adapter.take_expired();
        }
        site.now = end;
    };
    for (std::uint32_t number = 1; number <= 99; ++number) cycle(number);
    site.log.reserve(site.log.size() + 1000);
    std::size_t asked = 0;
    std::size_t for_lines = 0;
    for (std::uint32_t number = 100; number <= 1199; ++number) {
        const bool mode_changes = number % 100 <= 1;  // a line is logged
        const auto before = allocations();
        cycle(number);
        (mode_changes ? for_lines : asked) += allocations() - before;
    }
    EXPECT_EQ(asked, 0U);
    EXPECT_GT(for_lines, 0U) << "somebody counts";
    EXPECT_GT(sent, 1200U);
    EXPECT_EQ(site.adapter.io().size(), 4U);
}

INSTANTIATE_TEST_SUITE_P(Io, IoMemory,
                         testing::Values(Setting{"Table101", false, 101}, Setting{"Table112", false, 112},
                                         Setting{"Machine101", true, 101}, Setting{"Machine112", true, 112}),
                         [](const auto& each) { return each.param.name; });

// What is not told to anybody is not written for anybody: a read in no case, a change only where somebody wants it.
TEST(AccessMemory, WhatNobodyWantsToKnowAsksForNone) {
    IoSite site;
    IoPeer peer(site);
    const auto cost = [&](std::string_view request, std::string_view reply) {
        const auto message = octets(request);
        EXPECT_EQ(peer.call(message), hex(reply));
        const auto before = allocations();
        for (int i = 0; i < 10; ++i) static_cast<void>(peer.ask(message));
        return allocations() - before;
    };
    const auto read = [&] { return cost("0E 03 20 64 24 01 30 00", "8E 00 00 00 14 00 00 00"); };
    const auto change = [&] { return cost("10 03 20 66 24 01 30 25 D1 07 00 00", "90 00 00 00"); };
    const auto plain_read = read();
    const auto plain_change = change();
    std::size_t lines = 0;
    site.adapter.on_access({adapter::LogLevel::warning, [&](const adapter::LogLine&) { ++lines; }});
    EXPECT_EQ(change(), plain_change) << "changes are info";
    site.adapter.on_access({adapter::LogLevel::trace, [&](const adapter::LogLine&) { ++lines; }});
    EXPECT_GT(change(), plain_change) << "somebody counts";
    EXPECT_GT(lines, 0U);
    const auto before = lines;
    EXPECT_EQ(read(), plain_read);
    site.adapter.protect({.read_only = true, .harden = true});
    EXPECT_EQ(read(), plain_read);
    EXPECT_EQ(lines, before);
}

}  // namespace
}  // namespace servobus::test
