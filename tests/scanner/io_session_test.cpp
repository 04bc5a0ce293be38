// The life of an I/O connection, in virtual time and without a socket: R-SCN-1 to R-SCN-6, R-CON-18 to R-CON-21.
#include "scanner/io_session.hpp"

#include <gtest/gtest.h>

#include <boost/asio/error.hpp>

#include "tests/scanner/io_bench.hpp"

namespace servobus::scanner {
namespace {

using namespace test;
using cip::ConnectionFailure;
using cip::ConnectionType;
using cip::GeneralStatus;
using enip::ItemType;
using net_error = boost::asio::error::basic_errors;
namespace service = cip::service;

IoOptions multicast() {
    auto options = standard();
    options.plan.t_to_o.type = ConnectionType::multicast;
    return options;
}

IoOptions without_reopen() {
    auto options = standard();
    options.reopen = false;
    return options;
}

std::vector<enip::Item> group_item() { return {sockaddr(ItemType::sockaddr_t_to_o, 2222, group_address)}; }

struct Sent {
    enip::IoRoute route;
    enip::IoPacket packet;
};
std::vector<Sent> sent(const IoBench& bench) {
    std::vector<Sent> list;
    for (const auto& entry : bench.queue.entries()) {
        list.push_back({entry.route, enip::IoPacket::parse(bench.queue.octets(entry)).value()});
    }
    return list;
}

// ------------------------------------------------------------------------------------------------------- opening

TEST(IoSession, ConnectsAsksAndOpens) {  // R-SCN-1
    IoBench bench;
    EXPECT_EQ(bench.session.state(), IoState::idle);
    bench.open();
    EXPECT_EQ(bench.session.state(), IoState::connecting);
    bench.reach();
    EXPECT_EQ(bench.session.state(), IoState::opening);
    const auto request = bench.asked_open();
    EXPECT_EQ(request.path, standard().plan.path().encode());
    EXPECT_EQ(request.triad.originator_vendor, 0x004D);
    EXPECT_TRUE(bench.asked.front().items.empty());
    bench.grant();
    EXPECT_EQ(bench.session.state(), IoState::open);
    ASSERT_EQ(bench.opened.size(), 1U);
    const auto& opened = bench.opened[0];
    EXPECT_EQ(opened.request, request);
    EXPECT_EQ(opened.target, (enip::Endpoint{device.address, 2222}));
    EXPECT_EQ(opened.receiver, (enip::Endpoint{ourselves.address, 2222}));
    EXPECT_EQ(opened.local, ourselves);
    EXPECT_EQ(opened.attempt, 1U);
    EXPECT_EQ(opened.t_to_o_interval(), 10ms);
}

TEST(IoSession, NamesItsPortWhenItIsAnother) {  // R-CPF-8
    IoBench bench;
    bench.port = 50'222;
    bench.open();
    bench.reach();
    ASSERT_EQ(bench.asked.front().items.size(), 1U);
    EXPECT_EQ(bench.asked.front().items[0], sockaddr(ItemType::sockaddr_t_to_o, 50'222));
}

TEST(IoSession, NamesItsPortAlwaysWhenTold) {
    auto options = standard();
    options.always_name_port = true;
    IoBench bench(options);
    bench.open();
    bench.reach();
    ASSERT_EQ(bench.asked.front().items.size(), 1U);
    EXPECT_EQ(bench.asked.front().items[0], sockaddr(ItemType::sockaddr_t_to_o, 2222));
}

TEST(IoSession, MulticastNeedsNoPortOfOurs) {
    IoBench bench(multicast());
    bench.port = 50'222;
    bench.open();
    bench.reach();
    EXPECT_TRUE(bench.asked.front().items.empty());
    EXPECT_EQ(bench.asked_open().t_to_o_id, 0U);  // the target's to choose (R-CON-16)
    EXPECT_TRUE(bench.expected.empty());
}

TEST(IoSession, EveryOpenHasItsOwnTriadAndId) {  // R-SCN-2
    IoBench bench(without_reopen());
    bench.open();
    bench.reach();
    const auto first = bench.asked_open();
    bench.refuse(ConnectionFailure::ownership_conflict);
    bench.open();
    bench.reach();
    const auto second = bench.asked_open();
    EXPECT_EQ(second.triad.serial_number, static_cast<std::uint16_t>(first.triad.serial_number + 1));
    EXPECT_EQ(second.triad.originator_serial, first.triad.originator_serial);
    EXPECT_NE(second.t_to_o_id, first.t_to_o_id);
    EXPECT_EQ(second.t_to_o_id >> 16, first.t_to_o_id >> 16);
    IoNumbers other(0x004D, 2);
    EXPECT_NE(other.next_id() >> 16, first.t_to_o_id >> 16);
    EXPECT_NE(other.next_triad().originator_serial, first.triad.originator_serial);
}

TEST(IoSession, PassesOverAnIdThatIsTaken) {
    IoBench bench;
    IoNumbers same(0x004D, 1);
    const auto taken = same.next_id();
    bench.taken.insert(taken);
    bench.open();
    bench.reach();
    EXPECT_EQ(bench.asked_open().t_to_o_id, same.next_id());
}

TEST(IoSession, FallsBackToTheSmallForm) {  // R-SCN-5
    auto options = standard();
    options.plan.large = true;
    IoBench bench(options);
    bench.open();
    bench.reach();
    EXPECT_EQ(bench.services(), std::vector{service::large_forward_open});
    bench.refuse(GeneralStatus::service_not_supported);
    EXPECT_EQ(bench.services(), std::vector{service::forward_open});
    bench.grant();
    EXPECT_EQ(bench.session.state(), IoState::open);
    EXPECT_FALSE(bench.opened.at(0).request.large);
}

TEST(IoSession, DoesNotFallBackWhenTheSizesForbidIt) {
    auto options = standard();
    options.plan.t_to_o.data_octets = 600;
    IoBench bench(options);
    bench.open();
    bench.reach();
    EXPECT_EQ(bench.services(), std::vector{service::large_forward_open});
    bench.refuse(GeneralStatus::service_not_supported);
    ASSERT_EQ(bench.closed.size(), 1U);
    EXPECT_EQ(bench.closed[0].reason, CloseReason::refused);
    EXPECT_EQ(bench.session.state(), IoState::closed);
}

TEST(IoSession, DoesNotAskForWhatItCouldNotReceive) {
    auto options = standard();
    options.plan.t_to_o.data_octets = max_io_connection_size - 2;
    IoBench fitting(options);
    fitting.open();
    fitting.reach();
    EXPECT_EQ(fitting.session.state(), IoState::opening);
    ++options.plan.t_to_o.data_octets;
    IoBench bench(options);
    bench.open();
    bench.reach();
    EXPECT_EQ(bench.session.state(), IoState::closed);
    EXPECT_EQ(bench.closed.at(0).error, Error::request_too_large);
}

TEST(IoSession, OpensMulticast) {  // R-MC-3
    IoBench bench(multicast());
    bench.open();
    bench.reach();
    auto reply = bench.good_reply();
    reply.t_to_o_id = bench.id = 0x56A00002;
    bench.answer(bench.granting(reply), group_item());
    EXPECT_EQ(bench.session.state(), IoState::open);
    const enip::Endpoint group{group_address, 2222};
    EXPECT_EQ(bench.joined, group);
    EXPECT_EQ(bench.opened.at(0).receiver, group);
    EXPECT_EQ(bench.expected, std::multiset<std::uint32_t>{0x56A00002});
    bench.receive(bench.t_to_o(1, 1), {device.address, 2222}, group);
    EXPECT_EQ(bench.inputs.size(), 1U);
    EXPECT_EQ(bench.receive(bench.t_to_o(2, 2), {device.address, 2222}, {ourselves.address, 2222}),
              IoSession::Reception::wrong_source);  // not by the way that was agreed
    bench.close();
    EXPECT_TRUE(bench.joined);  // left after the close
    bench.accept_close();
    EXPECT_FALSE(bench.joined);
}

TEST(IoSession, AGroupThatCannotBeJoinedIsClosedAgain) {
    IoBench bench(multicast());
    bench.join_error = boost::asio::error::no_buffer_space;
    bench.run(group_item());
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::no_socket);
    EXPECT_EQ(bench.closed.at(0).error, boost::asio::error::no_buffer_space);
    EXPECT_EQ(bench.services(), std::vector{service::forward_close});
    EXPECT_EQ(bench.session.state(), IoState::waiting);
}

TEST(IoSession, NeedsASocketOfItsOwn) {
    IoBench bench;
    bench.listen_error = boost::asio::error::no_descriptors;
    bench.open();
    bench.reach();
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::no_socket);
    EXPECT_TRUE(bench.asked.empty());
    EXPECT_TRUE(bench.closed.at(0).next_try);
}

TEST(IoSession, ANullOpenOpensNothing) {  // R-CON-23
    auto options = standard();
    options.plan.o_to_t.type = options.plan.t_to_o.type = ConnectionType::null;
    IoBench bench(options);
    bench.open();
    bench.reach();
    EXPECT_EQ(bench.listeners, 0);
    auto reply = bench.good_reply();
    reply.o_to_t_api = reply.t_to_o_api = 0;
    bench.answer(bench.granting(reply));
    EXPECT_EQ(bench.opened.size(), 1U);
    EXPECT_EQ(bench.session.state(), IoState::closed);
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::asked);
    EXPECT_TRUE(bench.asked.empty());
}

TEST(IoSession, ADirectionThatIsNullHasNoTraffic) {
    auto options = standard();
    options.plan.o_to_t.type = ConnectionType::null;
    IoBench bench(options);
    bench.run();
    bench.receive(bench.t_to_o(1, 1));
    bench.pass(100ms);
    EXPECT_TRUE(bench.queue.empty());
    EXPECT_EQ(bench.inputs.size(), 1U);
    bench.pass(100ms);
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::timed_out);
}

// ------------------------------------------------------------------------------------------------------- running

TEST(IoSession, ProducesAtOnceAndAtTheGrantedInterval) {  // R-SCN-1, R-SCN-3
    IoBench bench;
    bench.output = cip::Bytes(18, 7);
    bench.open();
    bench.reach();
    auto reply = bench.good_reply();
    reply.o_to_t_api = 4000;
    bench.id = reply.t_to_o_id;
    bench.answer(bench.granting(reply), {sockaddr(ItemType::sockaddr_o_to_t, 3333)});
    bench.pass(39ms);
    const auto out = sent(bench);
    ASSERT_EQ(out.size(), 10U);  // the first one within 250 us, without waiting for T->O
    for (std::uint32_t i = 0; i < out.size(); ++i) {
        EXPECT_EQ(out[i].packet.connection_id, o_to_t_id);
        EXPECT_EQ(out[i].packet.sequence, i + 1);
        EXPECT_EQ(out[i].route.peer, (enip::Endpoint{device.address, 3333}));
        EXPECT_EQ(out[i].route.local.address, ourselves.address);
        EXPECT_EQ(out[i].route.dscp, 47);  // scheduled (R-QOS-5)
        EXPECT_EQ(out[i].packet.data.size(), 24U);
        EXPECT_EQ(out[i].packet.data[0], 1);  // the same data under the same count (R-IO-5)
        EXPECT_EQ(out[i].packet.data[2], 1);  // run
        EXPECT_EQ(out[i].packet.data[6], 7);
    }
}

TEST(IoSession, TellsIdleAndZerosWithoutAnApplication) {
    IoBench bench;
    bench.run_mode = false;
    bench.run();
    bench.pass(1ms);
    ASSERT_EQ(sent(bench).size(), 1U);
    EXPECT_EQ(sent(bench)[0].packet.data[2], 0);
}

TEST(IoSession, SendsAChangeAtOnceButNotTooOften) {  // R-CON-50, R-CON-52
    auto options = standard();
    options.plan.trigger = enip::Trigger::change_of_state;
    IoBench bench(options);
    bench.run();
    bench.pass(5ms);
    EXPECT_EQ(sent(bench).size(), 1U);
    bench.session.trigger(bench.now);  // nothing has changed
    bench.pass(1ms);
    EXPECT_EQ(sent(bench).size(), 1U);
    bench.output = cip::Bytes(18, 1);
    bench.session.trigger(bench.now);
    bench.pass(0ms);
    ASSERT_EQ(sent(bench).size(), 2U);
    EXPECT_EQ(sent(bench)[1].packet.data[0], 2);
    bench.output = cip::Bytes(18, 2);
    bench.session.trigger(bench.now);
    bench.pass(2400us);
    EXPECT_EQ(sent(bench).size(), 2U);
    bench.pass(100us);
    ASSERT_EQ(sent(bench).size(), 3U);  // a quarter of 10 ms after the last
    EXPECT_EQ(sent(bench)[2].packet.data[6], 2);
    bench.pass(9ms);
    EXPECT_EQ(sent(bench).size(), 3U);
    bench.pass(1ms);
    EXPECT_EQ(sent(bench).size(), 4U);  // and at the interval's end in any case
}

TEST(IoSession, AnApplicationThatTriggersWhileItIsAskedIsAskedOnce) {
    auto options = standard();
    options.plan.trigger = enip::Trigger::application;
    IoBench* self = nullptr;
    int asked = 0;
    IoBench bench(options, {.output = [&](std::span<std::uint8_t> data) {
                      data[0] = static_cast<std::uint8_t>(++asked);
                      self->session.trigger(self->now);
                      return true;
                  }});
    self = &bench;
    bench.run();
    bench.pass(1ms);
    EXPECT_EQ(asked, 1);
}

TEST(IoSession, HandsOnWhatComes) {
    IoBench bench;
    bench.run();
    EXPECT_EQ(bench.receive(bench.t_to_o(1, 1)), IoSession::Reception::taken);
    EXPECT_EQ(bench.receive(bench.t_to_o(2, 1)), IoSession::Reception::taken);
    ASSERT_EQ(bench.inputs.size(), 2U);
    EXPECT_EQ(bench.inputs[0].data.size(), 28U);
    EXPECT_TRUE(bench.inputs[0].fresh);
    EXPECT_FALSE(bench.inputs[1].fresh);  // the same count (R-IO-5)
    EXPECT_EQ(bench.inputs[1].sequence, 2U);
}

TEST(IoSession, ShowsEveryDatagramToWhoeverRecords) {
    std::vector<bool> seen;
    IoBench bench(standard(), {.packet = [&](const IoPacketSeen& packet) {
                      seen.push_back(packet.sent);
                      EXPECT_EQ(packet.octets.size(), packet.sent ? 42U : 48U);
                      EXPECT_EQ((packet.sent ? packet.source : packet.destination).address, ourselves.address);
                      EXPECT_EQ((packet.sent ? packet.destination : packet.source).address, device.address);
                  }});
    bench.run();
    bench.pass(1ms);
    bench.receive(bench.t_to_o(1, 1));
    bench.receive(bench.t_to_o(1, 1));  // stale, and still a datagram
    EXPECT_EQ(seen, (std::vector{true, false, false}));
}

TEST(IoSession, WaitsTenSecondsForTheFirst) {  // R-CON-19
    IoBench bench;
    bench.run();
    bench.pass(9999ms);
    EXPECT_TRUE(bench.closed.empty());
    bench.pass(1ms);
    ASSERT_EQ(bench.closed.size(), 1U);
    EXPECT_EQ(bench.closed[0].reason, CloseReason::timed_out);
}

TEST(IoSession, WaitsLongerThanTenSecondsWhenItsTimeoutIsLonger) {
    auto options = standard();
    options.plan.t_to_o.rpi = 1s;
    options.plan.multiplier_code = 2;  // x16
    IoBench bench(options);
    bench.run();
    bench.pass(15999ms);
    EXPECT_TRUE(bench.closed.empty());
    bench.pass(1ms);
    EXPECT_EQ(bench.closed.size(), 1U);
}

class EveryMultiplier : public testing::TestWithParam<std::uint8_t> {};

TEST_P(EveryMultiplier, TimesOut) {  // R-CON-6, R-CON-18
    auto options = standard();
    options.plan.multiplier_code = GetParam();
    IoBench bench(options);
    bench.open();
    bench.reach();
    auto reply = bench.good_reply();
    reply.t_to_o_api = 20'000;  // the interval is the granted one
    bench.id = reply.t_to_o_id;
    bench.answer(bench.granting(reply));
    bench.receive(bench.t_to_o(1, 1));
    const auto timeout = 20ms * (4 << GetParam());
    bench.pass(timeout - 1us);
    EXPECT_EQ(bench.session.state(), IoState::open);
    bench.pass(1us);
    EXPECT_EQ(bench.session.state(), IoState::waiting);
}
INSTANTIATE_TEST_SUITE_P(IoSession, EveryMultiplier, testing::Range(std::uint8_t{0}, std::uint8_t{8}));

// As at the device: what comes when the time is over changes nothing, also when nobody had the time to look before.
TEST(IoSession, ADatagramDoesNotReviveAConnectionWhoseTimeIsOver) {  // R-CON-18
    for (const auto late : {0ms, 25ms}) {
        SCOPED_TRACE(late.count());
        IoBench bench;
        bench.run();
        bench.receive(bench.t_to_o(1, 1));
        bench.now += 160ms - 1us;
        bench.receive(bench.t_to_o(2, 2));
        ASSERT_EQ(bench.inputs.size(), 2U) << "in time";
        bench.now += 160ms + late;
        bench.receive(bench.t_to_o(3, 3));
        EXPECT_EQ(bench.inputs.size(), 2U);
        bench.pass(0ms);
        ASSERT_EQ(bench.closed.size(), 1U);
        EXPECT_EQ(bench.closed[0].reason, CloseReason::timed_out);
    }
}

TEST(IoSession, AfterATimeoutItClosesAndOpensAnew) {  // R-CON-21
    IoBench bench;
    bench.run();
    const auto first = bench.opened[0].request;
    bench.receive(bench.t_to_o(1, 1));
    bench.pass(160ms);
    ASSERT_EQ(bench.closed.size(), 1U);
    EXPECT_EQ(bench.closed[0].reason, CloseReason::timed_out);
    EXPECT_EQ(bench.closed[0].next_try, 250ms);
    EXPECT_EQ(bench.closed[0].request, first);
    EXPECT_EQ(bench.services(), std::vector{service::forward_close});
    EXPECT_EQ(cip::ForwardClose::parse(bench.asked[0].request.data)->triad, first.triad);
    EXPECT_TRUE(bench.expected.empty());
    bench.queue.clear();
    bench.pass(249ms);
    EXPECT_TRUE(bench.queue.empty());
    EXPECT_TRUE(bench.connects.empty());
    bench.accept_close();  // changes nothing
    EXPECT_EQ(bench.session.state(), IoState::waiting);
    bench.pass(1ms);
    bench.reach();
    EXPECT_NE(bench.asked_open().triad, first.triad);
    bench.grant();
    EXPECT_EQ(bench.opened.at(1).attempt, 2U);
}

TEST(IoSession, WhatOvertakesTheReplyIsNotLost) {
    IoBench bench;
    bench.open();
    bench.reach();
    bench.id = bench.asked_open().t_to_o_id;
    const auto first = bench.now;
    bench.receive(bench.t_to_o(1, 1));
    bench.receive(bench.t_to_o(2, 2), {device.address + 1, 2222});  // from elsewhere
    EXPECT_TRUE(bench.inputs.empty());
    bench.now += 20ms;
    bench.grant();
    ASSERT_EQ(bench.inputs.size(), 1U);
    EXPECT_EQ(bench.inputs[0].sequence, 1U);
    EXPECT_EQ(bench.session.received().accepted, 1U);
    bench.pass(159ms);
    EXPECT_EQ(bench.session.state(), IoState::open);  // the watchdog started with the reply
    EXPECT_GT(bench.now, first + 160ms);
    bench.pass(1ms);
    EXPECT_EQ(bench.session.state(), IoState::waiting);
}

TEST(IoSession, KeepsOnlySomeOfWhatOvertakesTheReply) {
    IoBench bench;
    bench.open();
    bench.reach();
    bench.id = bench.asked_open().t_to_o_id;
    for (std::uint32_t i = 1; i <= max_early_datagrams + 1; ++i) bench.receive(bench.t_to_o(i, 1));
    bench.grant();
    EXPECT_EQ(bench.inputs.size(), max_early_datagrams);
    EXPECT_EQ(bench.inputs.at(0).sequence, 2U);
}

TEST(IoSession, ARefusedOpenForgetsWhatCameEarly) {
    IoBench bench(without_reopen());
    bench.open();
    bench.reach();
    bench.id = bench.asked_open().t_to_o_id;
    bench.receive(bench.t_to_o(1, 1));
    bench.refuse(ConnectionFailure::ownership_conflict);
    bench.run();
    EXPECT_TRUE(bench.inputs.empty());
}

TEST(IoSession, ADatagramOfAnEarlierLifeCountsForNothing) {
    IoBench bench(multicast());
    bench.open();
    bench.reach();
    auto reply = bench.good_reply();
    reply.t_to_o_id = bench.id = 0x56A00002;
    bench.answer(bench.granting(reply), group_item());
    const auto datagram = bench.t_to_o(500'000, 1);
    const auto packet = enip::IoPacket::parse(datagram).value();
    bench.session.on_datagram({{device.address, 2222}, {group_address, 2222}, datagram, packet, bench.now - 1us});
    EXPECT_TRUE(bench.inputs.empty());
    EXPECT_EQ(bench.session.received().accepted, 0U);
    bench.receive(bench.t_to_o(1, 1), {device.address, 2222}, {group_address, 2222});
    EXPECT_EQ(bench.inputs.size(), 1U);
}

// ------------------------------------------------------------------------------------------- back-off, R-SCN-4

TEST(IoSession, PausesDoubleUpToTheLast) {
    auto options = standard();
    options.first_pause = 250ms;
    options.last_pause = 1500ms;
    IoBench bench(options);
    bench.open();
    std::vector<std::int64_t> pauses;
    for (int i = 0; i < 5; ++i) {
        bench.reach(boost::asio::error::connection_refused);
        const auto& closed = bench.closed.back();
        EXPECT_EQ(closed.reason, CloseReason::unreachable);
        EXPECT_EQ(closed.error, boost::asio::error::connection_refused);
        pauses.push_back(closed.next_try->count());
        bench.pass(*closed.next_try - 1us);
        EXPECT_TRUE(bench.connects.empty());
        bench.pass(1us);
    }
    EXPECT_EQ(pauses, (std::vector<std::int64_t>{250, 500, 1000, 1500, 1500}));
}

TEST(IoSession, DataEndsTheBackOffAndAnOpenWithoutDataDoesNot) {
    IoBench bench;
    bench.run();
    bench.pass(10s);
    EXPECT_EQ(bench.closed.back().next_try, 250ms);
    bench.asked.clear();
    bench.pass(250ms);
    bench.reach();
    bench.grant();
    bench.pass(10s);
    EXPECT_EQ(bench.closed.back().next_try, 500ms);
    bench.asked.clear();
    bench.pass(500ms);
    bench.reach();
    bench.id = bench.asked_open().t_to_o_id;
    bench.grant();
    bench.receive(bench.t_to_o(1, 1));
    bench.pass(1s - 250ms);
    EXPECT_EQ(bench.closed.back().next_try, 250ms);
}

struct Refusal {
    const char* name;
    cip::Status status;
    bool tried_again;
};
void PrintTo(const Refusal& refusal, std::ostream* out) { *out << refusal.name; }

class Refusals : public testing::TestWithParam<Refusal> {};

TEST_P(Refusals, AreTriedAgainOrNot) {  // R-SCN-4
    const auto& refusal = GetParam();
    IoBench bench;
    bench.open();
    bench.reach();
    bench.refuse(refusal.status);
    ASSERT_EQ(bench.closed.size(), 1U);
    EXPECT_EQ(bench.closed[0].reason, CloseReason::refused);
    EXPECT_EQ(bench.closed[0].status, refusal.status);
    EXPECT_TRUE(bench.closed[0].request);
    EXPECT_EQ(bench.closed[0].next_try.has_value(), refusal.tried_again);
    EXPECT_EQ(bench.session.state(), refusal.tried_again ? IoState::waiting : IoState::closed);
    EXPECT_TRUE(bench.asked.empty());  // there is nothing to close
    EXPECT_TRUE(bench.expected.empty());
}

INSTANTIATE_TEST_SUITE_P(
    IoSession, Refusals,
    testing::Values(Refusal{"duplicate", ConnectionFailure::duplicate_forward_open, true},
                    Refusal{"owned", ConnectionFailure::ownership_conflict, true},
                    Refusal{"full", ConnectionFailure::out_of_connections, true},
                    Refusal{"target_full", ConnectionFailure::target_out_of_connections, true},
                    Refusal{"nothing_to_listen_to", ConnectionFailure::no_non_listen_only_connection, true},
                    Refusal{"no_answer_behind_the_router", ConnectionFailure::unconnected_request_timed_out, true},
                    Refusal{"size", {GeneralStatus::connection_failure, {0x0127, 24}}, false},
                    Refusal{"interval", ConnectionFailure::rpi_not_acceptable, false},
                    Refusal{"key", ConnectionFailure::vendor_or_product_mismatch, false},
                    Refusal{"path", ConnectionFailure::invalid_path_segment, false},
                    Refusal{"bare", {GeneralStatus::connection_failure, {}}, false},
                    Refusal{"not_this_service", GeneralStatus::service_not_supported, false},
                    Refusal{"short", GeneralStatus::not_enough_data, false}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(IoSession, ADuplicateIsTriedAgainWhenItsTimeIsOver) {
    auto options = standard();
    options.plan.o_to_t.rpi = 100ms;
    IoBench bench(options);
    bench.open();
    bench.reach();
    bench.refuse(ConnectionFailure::duplicate_forward_open);
    EXPECT_EQ(bench.closed.at(0).next_try, 1600ms);
}

TEST(IoSession, StaysClosedWhenItIsNotToOpenAgain) {
    IoBench bench(without_reopen());
    bench.run();
    bench.pass(10s);
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::timed_out);
    EXPECT_FALSE(bench.closed.at(0).next_try);
    EXPECT_EQ(bench.session.state(), IoState::closed);
    bench.pass(60s);
    EXPECT_TRUE(bench.connects.empty());
}

// ------------------------------------------------------------------------------------------------------- closing

TEST(IoSession, ClosesInGoodManners) {
    IoBench bench;
    bench.run();
    bench.pass(1ms);
    bench.queue.clear();
    bench.close();
    EXPECT_EQ(bench.session.state(), IoState::closing);
    EXPECT_TRUE(bench.closed.empty());
    const auto close = cip::ForwardClose::parse(bench.asked.front().request.data).value();
    EXPECT_EQ(close.triad, bench.opened[0].request.triad);
    EXPECT_EQ(close.path, bench.opened[0].request.path);
    bench.pass(100ms);
    EXPECT_TRUE(bench.queue.empty());
    EXPECT_EQ(bench.receive(bench.t_to_o(1, 1)), IoSession::Reception::taken);  // on its way, and no stray
    EXPECT_TRUE(bench.inputs.empty());
    bench.accept_close();
    EXPECT_EQ(bench.session.state(), IoState::closed);
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::asked);
    EXPECT_EQ(bench.closed[0].error, error_code());
    EXPECT_TRUE(bench.closed[0].status.ok());
    EXPECT_EQ(bench.listeners, 0);
}

TEST(IoSession, NotFoundIsClosedToo) {  // R-CON-36
    IoBench bench;
    bench.run();
    bench.close();
    bench.answer(cip::Response{service::forward_close, ConnectionFailure::connection_not_found, {}});
    EXPECT_TRUE(bench.closed.at(0).status.ok());
    EXPECT_EQ(bench.session.state(), IoState::closed);
}

TEST(IoSession, ARefusedCloseIsOverAndTold) {
    IoBench bench;
    bench.run();
    bench.close();
    bench.answer(cip::Response{service::forward_close, GeneralStatus::privilege_violation, {}});
    EXPECT_EQ(bench.closed.at(0).status, cip::Status(GeneralStatus::privilege_violation));
    EXPECT_EQ(bench.session.state(), IoState::closed);
}

TEST(IoSession, IoOutlivesItsSessionWhichIsMadeAgainToClose) {  // R-ENC-25
    IoBench bench;
    bench.run();
    bench.tcp = false;
    bench.receive(bench.t_to_o(1, 1));
    bench.pass(100ms);
    EXPECT_EQ(bench.session.state(), IoState::open);
    bench.close();
    EXPECT_TRUE(bench.asked.empty());
    bench.reach();
    EXPECT_EQ(bench.services(), std::vector{service::forward_close});
    bench.accept_close();
    EXPECT_EQ(bench.session.state(), IoState::closed);
}

TEST(IoSession, ASessionThatGoesWithTheCloseIsMadeAgainOnce) {
    IoBench bench;
    bench.run();
    bench.close();
    bench.tcp = false;
    bench.answer(make_error_code(Error::closed));
    EXPECT_EQ(bench.session.state(), IoState::closing);
    bench.reach();
    bench.tcp = false;
    bench.answer(make_error_code(Error::closed));
    EXPECT_EQ(bench.session.state(), IoState::closed);
    EXPECT_EQ(bench.closed.at(0).error, Error::closed);
}

TEST(IoSession, CloseWhileOpeningWaitsForTheAnswer) {
    IoBench bench;
    bench.open();
    bench.reach();
    bench.close();
    EXPECT_EQ(bench.session.state(), IoState::closing);
    bench.grant();
    EXPECT_TRUE(bench.opened.empty());
    EXPECT_EQ(bench.services(), std::vector{service::forward_close});
    bench.accept_close();
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::asked);
    EXPECT_EQ(bench.session.state(), IoState::closed);
}

TEST(IoSession, CloseWhileOpeningHasNothingToCloseAfterARefusal) {
    IoBench bench;
    bench.open();
    bench.reach();
    bench.close();
    bench.refuse(ConnectionFailure::ownership_conflict);
    EXPECT_TRUE(bench.asked.empty());
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::asked);
}

TEST(IoSession, CloseWhileConnectingOrWaitingIsDoneAtOnce) {
    IoBench bench;
    bench.open();
    bench.close();
    EXPECT_EQ(bench.session.state(), IoState::closed);
    bench.reach();  // too late
    EXPECT_EQ(bench.session.state(), IoState::closed);
    bench.open();
    bench.reach(boost::asio::error::connection_refused);
    EXPECT_EQ(bench.session.state(), IoState::waiting);
    bench.close();
    EXPECT_EQ(bench.session.state(), IoState::closed);
    bench.pass(10s);
    EXPECT_TRUE(bench.connects.empty());
}

TEST(IoSession, OpenWhileClosingOpensAfterwards) {
    IoBench bench;
    bench.run();
    bench.close();
    bench.open();
    bench.accept_close();
    EXPECT_EQ(bench.closed.size(), 1U);
    EXPECT_EQ(bench.session.state(), IoState::connecting);
}

TEST(IoSession, MayBeClosedAndOpenedInItsOwnEvents) {
    IoBench* self = nullptr;
    int closes = 0;
    IoBench bench(standard(), {.opened = [&](const IoOpened&) { self->close(); },
                               .closed =
                                   [&](const IoClosed&) {
                                       if (++closes == 1) self->open();
                                   }});
    self = &bench;
    bench.run();
    EXPECT_EQ(bench.session.state(), IoState::closing);
    bench.accept_close();
    EXPECT_EQ(bench.session.state(), IoState::connecting);
    bench.reach();
    EXPECT_EQ(bench.session.state(), IoState::opening);
}

TEST(IoSession, WhatCouldNotBeClosedIsClosedInTheNextSession) {
    IoBench bench;
    bench.run();
    const auto first = bench.opened[0].request.triad;
    bench.tcp = false;
    bench.pass(10s);
    EXPECT_TRUE(bench.asked.empty());
    bench.pass(250ms);
    bench.reach();
    EXPECT_EQ(bench.services(), (std::vector{service::forward_close, service::forward_open}));
    EXPECT_EQ(cip::ForwardClose::parse(bench.asked[0].request.data)->triad, first);
}

TEST(IoSession, AnOpenWithoutAnAnswerIsClosedBeforeTheNext) {
    IoBench bench;
    bench.open();
    bench.reach();
    const auto first = bench.asked_open().triad;
    bench.tcp = false;
    bench.answer(make_error_code(Error::timeout));
    EXPECT_EQ(bench.closed.at(0).reason, CloseReason::unreachable);
    EXPECT_EQ(bench.closed[0].error, Error::timeout);
    bench.pass(250ms);
    bench.reach();
    EXPECT_EQ(bench.services(), (std::vector{service::forward_close, service::forward_open}));
    EXPECT_EQ(cip::ForwardClose::parse(bench.asked[0].request.data)->triad, first);
    bench.take();
    bench.grant();
    EXPECT_EQ(bench.session.state(), IoState::open);
}

// --------------------------------------------------------------------------------------------- hostile replies

struct Hostile {
    const char* name;
    ConnectionType t_to_o;
    std::function<void(IoBench&)> reply;
    std::optional<Error> error;  ///< nullopt: it opens all the same
};
void PrintTo(const Hostile& hostile, std::ostream* out) { *out << hostile.name; }

std::function<void(IoBench&)> changed(std::function<void(cip::ForwardOpenReply&)> change) {
    return [change](IoBench& bench) {
        auto reply = bench.good_reply();
        change(reply);
        bench.answer(bench.granting(reply));
    };
}

std::function<void(IoBench&)> with_items(std::vector<enip::Item> items) {
    return [items](IoBench& bench) { bench.grant(items); };
}

std::function<void(IoBench&)> with_octets(std::function<void(cip::Bytes&)> change) {
    return [change](IoBench& bench) {
        auto response = bench.granting(bench.good_reply());
        change(response.data);
        bench.answer(response);
    };
}

std::function<void(IoBench&)> with_error(Error error) {
    return [error](IoBench& bench) { bench.answer(make_error_code(error)); };
}

enip::Item cut(enip::Item item, std::size_t size) {
    item.data.resize(size);
    return item;
}

class HostileReplies : public testing::TestWithParam<Hostile> {};

TEST_P(HostileReplies, EndInATypedErrorAndAForwardClose) {  // R-SCN-3, R-SCN-6, R-CPF-9
    const auto& hostile = GetParam();
    auto options = standard();
    options.plan.t_to_o.type = hostile.t_to_o;
    IoBench bench(options);
    bench.taken = {0x0BAD0001};
    bench.open();
    bench.reach();
    const auto triad = bench.asked_open().triad;
    hostile.reply(bench);
    if (!hostile.error) {
        EXPECT_EQ(bench.session.state(), IoState::open);
        EXPECT_EQ(bench.opened.size(), 1U);
        return;
    }
    EXPECT_TRUE(bench.opened.empty());
    ASSERT_EQ(bench.closed.size(), 1U);
    EXPECT_EQ(bench.closed[0].reason, CloseReason::bad_reply);
    EXPECT_EQ(bench.closed[0].error, *hostile.error);
    EXPECT_FALSE(bench.closed[0].next_try);
    EXPECT_EQ(bench.session.state(), IoState::closed);
    ASSERT_EQ(bench.services(), std::vector{service::forward_close});
    EXPECT_EQ(cip::ForwardClose::parse(bench.asked[0].request.data)->triad, triad);
    EXPECT_TRUE(bench.expected.empty());
    EXPECT_EQ(bench.listeners, 0);
    EXPECT_FALSE(bench.joined);
}

constexpr auto p2p = ConnectionType::point_to_point;
constexpr auto mcast = ConnectionType::multicast;
constexpr auto to_target = ItemType::sockaddr_o_to_t;
constexpr auto to_us = ItemType::sockaddr_t_to_o;
const auto good_group = sockaddr(to_us, 2222, group_address);

// clang-format off
INSTANTIATE_TEST_SUITE_P(IoSession, HostileReplies, testing::Values(
    Hostile{"empty", p2p, with_octets([](auto& data) { data.clear(); }), Error::missing_data},
    Hostile{"cut", p2p, with_octets([](auto& data) { data.pop_back(); }), Error::missing_data},
    Hostile{"doubled", p2p, with_octets([](auto& data) { data = servobus::test::operator+(data, data); }), Error::unexpected_data},
    Hostile{"application_reply_longer_than_the_data", p2p, with_octets([](auto& data) { data[24] = 255; }), Error::missing_data},
    Hostile{"huge_application_reply", p2p, changed([](auto& reply) { reply.application_reply = cip::Bytes(510, 0xAA); }), std::nullopt},
    Hostile{"other_serial_number", p2p, changed([](auto& reply) { ++reply.triad.serial_number; }), Error::wrong_connection},
    Hostile{"other_vendor", p2p, changed([](auto& reply) { ++reply.triad.originator_vendor; }), Error::wrong_connection},
    Hostile{"other_originator", p2p, changed([](auto& reply) { ++reply.triad.originator_serial; }), Error::wrong_connection},
    Hostile{"id_of_another_connection", p2p, changed([](auto& reply) { reply.t_to_o_id = 0x0BAD0001; }), Error::wrong_connection},
    Hostile{"id_of_its_own_choice", p2p, changed([](auto& reply) { reply.t_to_o_id = 0x0BAD0002; }), std::nullopt},
    Hostile{"o_to_t_api_0", p2p, changed([](auto& reply) { reply.o_to_t_api = 0; }), Error::bad_interval},
    Hostile{"t_to_o_api_0", p2p, changed([](auto& reply) { reply.t_to_o_api = 0; }), Error::bad_interval},
    Hostile{"o_to_t_api_below_what_can_be_kept", p2p, changed([](auto& reply) { reply.o_to_t_api = 249; }), Error::bad_interval},
    Hostile{"o_to_t_api_that_can_just_be_kept", p2p, changed([](auto& reply) { reply.o_to_t_api = 250; }), std::nullopt},
    Hostile{"t_to_o_api_of_a_minute", p2p, changed([](auto& reply) { reply.t_to_o_api = 60'000'000; }), std::nullopt},
    Hostile{"t_to_o_api_of_more_than_a_minute", p2p, changed([](auto& reply) { reply.t_to_o_api = 60'000'001; }), Error::bad_interval},
    Hostile{"o_to_t_api_of_an_hour", p2p, changed([](auto& reply) { reply.o_to_t_api = 0xFFFFFFFF; }), Error::bad_interval},
    Hostile{"target_port_0", p2p, with_items({sockaddr(to_target, 0)}), Error::bad_socket_address},
    Hostile{"target_family_ipv6", p2p, with_items({sockaddr(to_target, 2222, 0, 10)}), Error::bad_socket_address},
    Hostile{"target_family_little_endian", p2p, with_items({sockaddr(to_target, 2222, 0, 0x0200)}), Error::bad_socket_address},
    Hostile{"target_address_cut", p2p, with_items({cut(sockaddr(to_target, 2222), 15)}), Error::bad_socket_address},
    Hostile{"target_address_too_long", p2p, with_items({cut(sockaddr(to_target, 2222), 17)}), Error::bad_socket_address},
    Hostile{"target_address_empty", p2p, with_items({cut(sockaddr(to_target, 2222), 0)}), Error::bad_socket_address},
    Hostile{"target_address_twice", p2p, with_items({sockaddr(to_target, 2222), sockaddr(to_target, 2222)}), Error::bad_socket_address},
    Hostile{"own_address_with_port_0", p2p, with_items({sockaddr(to_us, 0)}), Error::bad_socket_address},
    Hostile{"own_address_echoed", p2p, with_items({sockaddr(to_us, 2222)}), std::nullopt},
    Hostile{"group_missing", mcast, with_items({}), Error::bad_socket_address},
    Hostile{"group_in_the_wrong_item", mcast, with_items({sockaddr(to_target, 2222, group_address)}), Error::bad_socket_address},
    Hostile{"group_with_port_0", mcast, with_items({sockaddr(to_us, 0, group_address)}), Error::bad_socket_address},
    Hostile{"group_of_family_0", mcast, with_items({sockaddr(to_us, 2222, group_address, 0)}), Error::bad_socket_address},
    Hostile{"group_that_is_none", mcast, with_items({sockaddr(to_us, 2222, 0xC0A80264)}), Error::bad_socket_address},
    Hostile{"group_0", mcast, with_items({sockaddr(to_us, 2222, 0)}), Error::bad_socket_address},
    Hostile{"group_cut", mcast, with_items({cut(good_group, 8)}), Error::bad_socket_address},
    Hostile{"group_twice", mcast, with_items({good_group, good_group}), Error::bad_socket_address},
    Hostile{"group_among_unknown_items", mcast, with_items({{ItemType(0x7777), {1, 2, 3}}, good_group}), std::nullopt},
    Hostile{"other_service", p2p, with_error(Error::wrong_service), Error::wrong_service},
    Hostile{"other_command", p2p, with_error(Error::wrong_command), Error::wrong_command},
    Hostile{"malformed_packet", p2p, with_error(Error::malformed_packet), Error::malformed_packet},
    Hostile{"malformed_response", p2p, with_error(Error::malformed_response), Error::malformed_response},
    Hostile{"refusal_of_anothers_connection", p2p, [](IoBench& bench) {
        auto triad = bench.asked_open().triad;
        ++triad.originator_serial;
        bench.answer(cip::Response{service::forward_open, ConnectionFailure::ownership_conflict, cip::ConnectionRefusal{triad, 0}.encode()});
    }, Error::wrong_connection}),
    [](const auto& row) { return std::string(row.param.name); });
// clang-format on

TEST(IoSession, AReplyCutAnywhereIsABadReply) {
    for (std::size_t size = 0; size < 26; ++size) {
        IoBench bench;
        bench.open();
        bench.reach();
        auto response = bench.granting(bench.good_reply());
        ASSERT_EQ(response.data.size(), 26U);
        response.data.resize(size);
        bench.answer(response);
        EXPECT_EQ(bench.session.state(), IoState::closed) << size;
        EXPECT_EQ(bench.closed.at(0).error, Error::missing_data) << size;
    }
}

TEST(IoSession, ARefusalMayEndAnywhere) {  // R-CM-10
    for (std::size_t size = 0; size <= 10; ++size) {
        IoBench bench;
        bench.open();
        bench.reach();
        auto data = cip::ConnectionRefusal{bench.asked_open().triad, 0}.encode();
        data.resize(size);
        bench.answer(cip::Response{service::forward_open, ConnectionFailure::invalid_path_segment, data});
        EXPECT_EQ(bench.closed.at(0).reason, CloseReason::refused) << size;
    }
}

TEST(IoSession, AnswersThatNobodyWaitsForChangeNothing) {
    IoBench bench;
    bench.open();
    bench.reach();
    const auto open = bench.asked.front();
    const auto reply = bench.granting(bench.good_reply());
    bench.grant();
    for (const std::uint64_t ticket : {std::uint64_t{0}, open.ticket, open.ticket + 1, ~std::uint64_t{0}}) {
        bench.session.on_reply(ticket, {}, {reply, {}}, bench.now);
        bench.session.on_reply(ticket, make_error_code(Error::timeout), {}, bench.now);
        bench.session.on_connected(ticket, make_error_code(Error::timeout), {}, bench.now);
    }
    EXPECT_EQ(bench.session.state(), IoState::open);
    EXPECT_EQ(bench.opened.size(), 1U);
    EXPECT_TRUE(bench.closed.empty());
}

TEST(IoSession, ACloseReplyAboutAnotherIsTold) {
    IoBench bench;
    bench.run();
    bench.close();
    bench.answer(cip::Response{service::forward_close, {}, cip::ForwardCloseReply{{1, 2, 3}, {}}.encode()});
    EXPECT_EQ(bench.closed.at(0).error, Error::wrong_connection);
    EXPECT_EQ(bench.session.state(), IoState::closed);
}

TEST(IoSession, TheItemsAddressIsNotBelieved) {
    IoBench bench;
    bench.run({sockaddr(to_target, 3333, 0x08080808)});
    EXPECT_EQ(bench.opened.at(0).target, (enip::Endpoint{device.address, 3333}));
}

// ------------------------------------------------------------------------------------------- hostile datagrams

struct HostileDatagram {
    const char* name;
    std::function<IoSession::Reception(IoBench&)> send;
    IoSession::Reception reception;
    std::uint64_t stale;
    std::uint64_t wrong_size;
};
void PrintTo(const HostileDatagram& hostile, std::ostream* out) { *out << hostile.name; }

class HostileDatagrams : public testing::TestWithParam<HostileDatagram> {};

TEST_P(HostileDatagrams, ChangeNothingAndAreCounted) {  // R-IO-5, R-IO-7, R-IO-8
    const auto& hostile = GetParam();
    IoBench bench;
    bench.run();
    bench.receive(bench.t_to_o(100, 1));
    const auto deadline = bench.session.next_deadline();
    bench.now += 1ms;
    EXPECT_EQ(hostile.send(bench), hostile.reception);
    EXPECT_EQ(bench.session.received().stale, hostile.stale);
    EXPECT_EQ(bench.session.received().wrong_size, hostile.wrong_size);
    EXPECT_EQ(bench.session.received().accepted, 1U);
    EXPECT_EQ(bench.inputs.size(), 1U);
    EXPECT_EQ(bench.session.next_deadline(), deadline);
    EXPECT_EQ(bench.session.state(), IoState::open);
    bench.now -= 1ms;
    bench.pass(160ms);  // the watchdog has not been restarted
    EXPECT_EQ(bench.session.state(), IoState::waiting);
}

using Reception = IoSession::Reception;
// clang-format off
INSTANTIATE_TEST_SUITE_P(IoSession, HostileDatagrams, testing::Values(
    HostileDatagram{"from_another_address", [](IoBench& bench) { return bench.receive(bench.t_to_o(101, 2), {device.address + 1, 2222}); }, Reception::wrong_source, 0, 0},
    HostileDatagram{"from_nowhere", [](IoBench& bench) { return bench.receive(bench.t_to_o(101, 2), {0, 2222}); }, Reception::wrong_source, 0, 0},
    HostileDatagram{"by_multicast", [](IoBench& bench) { return bench.receive(bench.t_to_o(101, 2), {device.address, 2222}, {group_address, 2222}); }, Reception::wrong_source, 0, 0},
    HostileDatagram{"same_sequence", [](IoBench& bench) { return bench.receive(bench.t_to_o(100, 2)); }, Reception::taken, 1, 0},
    HostileDatagram{"older_sequence", [](IoBench& bench) { return bench.receive(bench.t_to_o(99, 2)); }, Reception::taken, 1, 0},
    HostileDatagram{"half_the_circle_ahead", [](IoBench& bench) { return bench.receive(bench.t_to_o(100 + 0x80000000, 2)); }, Reception::taken, 1, 0},
    HostileDatagram{"one_octet_short", [](IoBench& bench) { return bench.receive(bench.t_to_o(101, 2, 27)); }, Reception::taken, 0, 1},
    HostileDatagram{"one_octet_long", [](IoBench& bench) { return bench.receive(bench.t_to_o(101, 2, 29)); }, Reception::taken, 0, 1},
    HostileDatagram{"count_only", [](IoBench& bench) { return bench.receive(bench.t_to_o(101, 2, 0)); }, Reception::taken, 0, 1},
    HostileDatagram{"no_data_at_all", [](IoBench& bench) {
        auto datagram = bench.t_to_o(101, 2, 0);
        datagram.resize(18);
        datagram[16] = 0;
        return bench.receive(datagram);
    }, Reception::taken, 0, 1},
    HostileDatagram{"with_a_run_idle_header", [](IoBench& bench) { return bench.receive(bench.t_to_o(101, 2, 32)); }, Reception::taken, 0, 1}),
    [](const auto& row) { return std::string(row.param.name); });
// clang-format on

TEST(IoSession, SequenceNumbersWrap) {  // R-IO-5
    IoBench bench;
    bench.run();
    for (const std::uint32_t sequence : {0xFFFFFFFEU, 0xFFFFFFFFU, 0U, 1U}) {
        bench.receive(bench.t_to_o(sequence, static_cast<std::uint16_t>(sequence)));
    }
    EXPECT_EQ(bench.session.received().accepted, 4U);
    EXPECT_EQ(bench.session.received().lost, 0U);
    bench.receive(bench.t_to_o(4, 4));
    EXPECT_EQ(bench.session.received().lost, 2U);
}

TEST(IoSession, OctetsBehindTheItemsDoNotMatter) {  // R-IO-8
    IoBench bench;
    bench.run();
    auto datagram = bench.t_to_o(1, 1);
    datagram.push_back(0xFF);
    bench.receive(datagram);
    EXPECT_EQ(bench.inputs.size(), 1U);
}

TEST(IoSession, AnyPortOfTheTargetWillDo) {  // R-IO-7
    IoBench bench;
    bench.run();
    bench.receive(bench.t_to_o(1, 1), {device.address, 50'001});
    EXPECT_EQ(bench.inputs.size(), 1U);
}

}  // namespace
}  // namespace servobus::scanner
