// What an interface of this machine is, and what it has counted (R-ETH-1 to R-ETH-5).
#include "enip/asio/interface_reader.hpp"

#include <gtest/gtest.h>
#include <linux/ethtool.h>
#include <linux/if_link.h>

#include <array>
#include <thread>

#include "enip/asio/cpu_load.hpp"
#include "enip/asio/interfaces.hpp"
#include "enip/asio/io_socket.hpp"

namespace servobus::enip::asio {
namespace {

rtnl_link_stats counted() {
    rtnl_link_stats stats{};
    stats.rx_packets = 1000;
    stats.multicast = 100;
    stats.rx_bytes = 2;
    stats.rx_dropped = 3;
    stats.rx_errors = 4;
    stats.rx_nohandler = 5;
    stats.tx_bytes = 6;
    stats.tx_packets = 7;
    stats.tx_dropped = 8;
    stats.tx_errors = 9;
    stats.rx_frame_errors = 21;
    stats.rx_crc_errors = 22;
    stats.collisions = 23;
    stats.tx_heartbeat_errors = 24;
    stats.tx_window_errors = 25;
    stats.tx_aborted_errors = 26;
    stats.tx_fifo_errors = 27;
    stats.tx_carrier_errors = 28;
    stats.rx_length_errors = 29;
    stats.rx_fifo_errors = 30;
    return stats;
}

TEST(InterfaceCounters, R_ETH_4_AreThoseOfTheKernel) {
    const auto counters = interface_counters(counted());
    EXPECT_EQ(counters.in_octets, 2U);
    EXPECT_EQ(counters.in_unicast, 900U);
    EXPECT_EQ(counters.in_non_unicast, 100U);
    EXPECT_EQ(counters.in_discards, 3U);
    EXPECT_EQ(counters.in_errors, 4U);
    EXPECT_EQ(counters.in_unknown_protocols, 5U);
    EXPECT_EQ(counters.out_octets, 6U);
    EXPECT_EQ(counters.out_unicast, 7U);
    EXPECT_EQ(counters.out_non_unicast, 0U) << "which the kernel does not count";
    EXPECT_EQ(counters.out_discards, 8U);
    EXPECT_EQ(counters.out_errors, 9U);
}

TEST(MediaCounters, R_ETH_5_AreItsErrors) {
    const auto media = media_counters(counted());
    EXPECT_EQ(media.alignment_errors, 21U);
    EXPECT_EQ(media.fcs_errors, 22U);
    EXPECT_EQ(media.single_collisions, 23U);
    EXPECT_EQ(media.multiple_collisions, 0U);
    EXPECT_EQ(media.sqe_test_errors, 24U);
    EXPECT_EQ(media.deferred_transmissions, 0U);
    EXPECT_EQ(media.late_collisions, 25U);
    EXPECT_EQ(media.excessive_collisions, 26U);
    EXPECT_EQ(media.mac_transmit_errors, 27U);
    EXPECT_EQ(media.carrier_sense_errors, 28U);
    EXPECT_EQ(media.frames_too_long, 29U);
    EXPECT_EQ(media.mac_receive_errors, 30U);
}

InterfaceFacts told(std::uint32_t speed, std::uint8_t duplex, std::uint8_t autoneg, bool link = true) {
    ethtool_cmd settings{};
    ethtool_cmd_speed_set(&settings, speed);
    settings.duplex = duplex;
    settings.autoneg = autoneg;
    InterfaceFacts facts;
    facts.link = link;
    tell_link(settings, facts);
    return facts;
}

TEST(LinkSettings, R_ETH_2_SpeedDuplexAndNegotiation) {
    const auto usual = told(1000, DUPLEX_FULL, AUTONEG_ENABLE);
    EXPECT_EQ(usual.speed, 1000U);
    EXPECT_TRUE(usual.full_duplex);
    EXPECT_EQ(usual.negotiation, Negotiation::done);
    const auto forced = told(100'000, DUPLEX_HALF, AUTONEG_DISABLE);
    EXPECT_EQ(forced.speed, 100'000U) << "both halves of the number";
    EXPECT_FALSE(forced.full_duplex);
    EXPECT_EQ(forced.negotiation, Negotiation::not_attempted);
    EXPECT_EQ(told(static_cast<std::uint32_t>(SPEED_UNKNOWN), DUPLEX_UNKNOWN, AUTONEG_ENABLE).speed, 0U);
    EXPECT_EQ(told(1000, DUPLEX_FULL, AUTONEG_ENABLE, false).speed, 0U) << "without a link";
}

TEST(InterfaceReader, LoopbackCountsWhatIsSent) {
    const auto loopback = interface_of(0x7F000001);
    ASSERT_TRUE(loopback);
    InterfaceReader reader(loopback->name);
    const auto before = reader.read();
    EXPECT_FALSE(before.ethernet);
    EXPECT_TRUE(before.link);

    boost::asio::io_context context;
    IoSocket socket(context.get_executor());
    ASSERT_FALSE(socket.open({0x7F000001, 0}, false));
    IoQueue queue;
    constexpr std::size_t size = 1000;
    (void)queue.add({.local = socket.local(), .peer = socket.local()}, size);
    ASSERT_EQ(socket.send(queue).sent, 1U);
    EXPECT_EQ(reader.read().counters.out_octets, before.counters.out_octets) << "it does not look again so soon";
    std::this_thread::sleep_for(interface_look_interval);
    EXPECT_GE(reader.read().counters.out_octets - before.counters.out_octets, size);
    EXPECT_GE(reader.read().counters.in_unicast - before.counters.in_unicast, 1U);
}

TEST(InterfaceReader, WhatIsNotThereHasNoLink) {
    InterfaceReader reader("no-such-port");
    EXPECT_FALSE(reader.read().link);
    EXPECT_FALSE(reader.read().ethernet);
    EXPECT_EQ(reader.read().counters.in_octets, 0U);
}

TEST(CpuLoad, IsBetweenNothingAndAWholeOne) {
    CpuLoad load;
    EXPECT_EQ(load.read(), 0) << "nothing has been measured yet";
    const auto begin = std::chrono::steady_clock::now();
    unsigned work = 0;
    while (std::chrono::steady_clock::now() - begin < cpu_load_interval) ++work;
    EXPECT_GT(work, 0U);
    EXPECT_GT(load.read(), 0) << "it has worked all the time";
    EXPECT_LE(load.read(), 1000);
}

}  // namespace
}  // namespace servobus::enip::asio
