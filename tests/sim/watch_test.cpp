// Every invariant can be broken: the books, told of a device or an originator that does it wrong, say so in its words.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "cip/services.hpp"
#include "drive/xenax.hpp"
#include "enip/messages.hpp"
#include "scanner/io_plan.hpp"
#include "tests/adapter/io_site.hpp"
#include "tests/sim/originator_watch.hpp"
#include "tests/sim/target_watch.hpp"

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;
using scanner::IoPlan;
namespace service = cip::service;

/// The names of what has been broken so far in these tests.
std::string broken(const Judge& judge) {
    return judge.violation() ? std::string(law(judge.violation()->invariant).name) : "nothing";
}

TEST(Laws, EachHasNameRuleAndWords) {
    std::set<std::string_view> names;
    for (int i = 0; i <= static_cast<int>(Invariant::time_goes_on); ++i) {
        const auto& each = law(static_cast<Invariant>(i));
        EXPECT_EQ(static_cast<int>(each.invariant), i);
        EXPECT_FALSE(each.rules.empty() || each.words.empty()) << each.name;
        EXPECT_EQ(find_invariant(each.name), each.invariant);
        names.insert(each.name);
    }
    EXPECT_EQ(names.size(), static_cast<std::size_t>(Invariant::time_goes_on) + 1);
}

TEST(Judge, TheFirstViolationCounts) {
    Judge judge;
    judge.report(Invariant::in_order, Time{1s}, "first");
    judge.report(Invariant::one_owner, Time{2s}, "second");
    EXPECT_EQ(judge.violation()->what, "first");
}

// ---------------------------------------------------------------------------------------------------- production

class Production : public testing::Test {
protected:
    std::string take(std::uint32_t sequence, Time now, bool excused = false) {
        const auto fault = book.take(sequence, now, excused);
        return fault ? std::string(law(fault->invariant).name) : "nothing";
    }
    ProductionBook book{{10ms, 2ms, true}, Time{}};
    ProductionBook on_change{{10ms, 2ms, false}, Time{}};
};

TEST_F(Production, CyclicIsExact) {
    EXPECT_EQ(take(1, Time{3ms}), "nothing");
    EXPECT_EQ(take(2, Time{13ms}), "nothing");
    EXPECT_FALSE(book.is_overdue(Time{23ms}));
    EXPECT_TRUE(book.is_overdue(Time{23ms + 1ns}));
    EXPECT_EQ(take(3, Time{23ms - 1ns}), "produced_in_time") << "early";
}

TEST_F(Production, CyclicIsNotLate) {
    EXPECT_EQ(take(1, Time{3ms}), "nothing");
    EXPECT_EQ(take(2, Time{13ms + 1ns}), "produced_in_time");
}

TEST_F(Production, TheFirstComesWithinAnInterval) {  // R-CON-50
    EXPECT_EQ(take(1, Time{10ms + 1ns}), "produced_in_time");
}

TEST_F(Production, NumbersGrowByOne) {
    EXPECT_EQ(take(7, Time{3ms}), "nothing") << "the first is free";
    EXPECT_EQ(take(9, Time{13ms}), "produced_in_sequence");
}

TEST_F(Production, ChangesWaitForTheInhibitTime) {  // R-CON-51
    EXPECT_FALSE(on_change.take(1, Time{3ms}, false));
    EXPECT_FALSE(on_change.take(2, Time{5ms}, false));
    EXPECT_FALSE(on_change.take(3, Time{15ms}, false)) << "an interval after the change";
    EXPECT_TRUE(on_change.take(4, Time{17ms - 1ns}, false));
}

TEST_F(Production, AProgramThatWasHeldUpCatchesUp) {
    EXPECT_EQ(take(1, Time{3ms}), "nothing");
    for (std::uint32_t i = 2; i < 6; ++i) EXPECT_EQ(take(i, Time{45ms}, true), "nothing");  // 13, 23, 33, 43
    EXPECT_EQ(take(6, Time{53ms}), "nothing") << "the rate is kept";
}

// ------------------------------------------------------------------------------------------------------ the target

constexpr std::uint32_t originator = 0xC0A80201;
constexpr enip::Target::ConnectionId stream = 1;

/// A device that is made up: what it hears and says is written here, and the real one beside it is empty or has what is given.
class Target : public testing::Test {
protected:
    Target() {
        watch.restarted(now, {});
        watch.settle(adapter, now);
        register_session();
    }

    void register_session() {
        watch.stream_opened(stream, originator, now);
        const enip::Frame request{.command = enip::Command::register_session, .data = enip::RegisterSession{}.encode()};
        watch.hears(stream, request, now);
        auto reply = request.reply();
        reply.session = session;
        watch.says(stream, reply, now);
    }

    static cip::ForwardOpen wanted(std::uint16_t serial, std::string_view kind = "standard", bool multicast = false) {
        auto plan = scanner::plan_of(*assemblies::find_connection(kind));
        if (multicast) plan.t_to_o.type = cip::ConnectionType::multicast;
        return plan.forward_open(0, 0x0A110000U | serial, {serial, 0x0100, 1});
    }
    enip::Frame ask(const cip::Request& request) {
        enip::Frame frame{.command = enip::Command::send_rr_data,
                          .session = session,
                          .data = enip::SendData::unconnected(request.encode()).encode()};
        frame.context[0] = ++context;
        watch.hears(stream, frame, now);
        return frame;
    }
    void answer(const enip::Frame& request, const cip::Response& response) {
        watch.says(stream, request.reply({}, enip::SendData::unconnected(response.encode()).encode()), now);
    }
    /// A Forward_Open that is granted.
    cip::ForwardOpenReply grant(const cip::ForwardOpen& open, std::uint32_t id) {
        const cip::ForwardOpenReply reply{id, open.t_to_o_id, open.triad, open.o_to_t_rpi, open.t_to_o_rpi, {}};
        answer(ask(scanner::open_request(open)), {service::forward_open, {}, reply.encode()});
        return reply;
    }
    void refuse(const cip::ForwardOpen& open, cip::ConnectionFailure failure) {
        answer(ask(scanner::open_request(open)),
               {service::forward_open, failure, cip::ConnectionRefusal{open.triad, 0}.encode()});
    }
    void close(const cip::ForwardOpen& open) {
        answer(ask(scanner::close_request(open)),
               {service::forward_close, {}, cip::ForwardCloseReply{open.triad, {}}.encode()});
    }
    void produce(std::uint32_t id, std::uint32_t sequence) {
        cip::Bytes octets(enip::io_packet_overhead + 30);
        static_cast<void>(enip::begin_io_packet(octets, id, sequence));
        watch.produces({.local = {}, .peer = {originator, enip::io_port}}, octets, now);
    }
    void settle() { watch.settle(adapter, now); }
    /// An owner that the real device has too; without TCP connections.
    std::uint32_t open_at_the_real_one() {
        test::IoPeer peer(site);
        const auto id = peer.must_open(test::io_open(1)).reply.o_to_t_id;
        peer.disconnect();
        register_session();
        grant(wanted(1), id);
        watch.stream_closed(stream);
        return id;
    }

    static constexpr std::uint32_t session = 0x1234;
    Judge judge;
    TargetWatch watch{0, judge};
    test::IoSite site{drive::Device(drive::xenax_models().front(), drive::Machine{})};
    drive::Device& device = site.device;
    adapter::Adapter& adapter = site.adapter;
    Time now = site.now;
    std::uint8_t context = 0;
};

TEST_F(Target, TwoOwners) {
    grant(wanted(1), 100);
    EXPECT_EQ(broken(judge), "nothing");
    grant(wanted(2, "force"), 101);
    EXPECT_EQ(broken(judge), "one_owner");
}

TEST_F(Target, RefusesAnOwnerAndThereIsNone) {
    refuse(wanted(1), cip::ConnectionFailure::ownership_conflict);
    EXPECT_EQ(broken(judge), "admitted_by_the_rules");
}

TEST_F(Target, RefusesASecondOwner) {
    grant(wanted(1), 100);
    refuse(wanted(2), cip::ConnectionFailure::ownership_conflict);
    EXPECT_EQ(broken(judge), "nothing");
}

TEST_F(Target, GrantsARedundantOwner) {
    auto open = wanted(1);
    open.o_to_t.redundant_owner = true;
    grant(open, 100);
    EXPECT_EQ(broken(judge), "admitted_by_the_rules");
}

TEST_F(Target, GrantsTheSameTriadTwice) {
    grant(wanted(1, "input-only"), 100);
    grant(wanted(1, "input-only"), 101);
    EXPECT_EQ(broken(judge), "admitted_by_the_rules");
}

TEST_F(Target, LetsAListenerInWithoutAnybodyToListenTo) {
    grant(wanted(1, "listen-only", true), 100);
    EXPECT_EQ(broken(judge), "admitted_by_the_rules");
}

TEST_F(Target, LetsAJoinerChangeTheTerms) {
    auto first = wanted(1, "input-only", true);
    auto second = wanted(2, "input-only", true);
    second.t_to_o_id = first.t_to_o_id;
    second.t_to_o_rpi = 20'000;
    grant(first, 100);
    grant(second, 101);
    EXPECT_EQ(broken(judge), "admitted_by_the_rules");
}

TEST_F(Target, GrantsMoreThanItHas) {
    for (std::uint16_t i = 1; i <= 8; ++i) grant(wanted(i, "input-only"), 100U + i);
    EXPECT_EQ(broken(judge), "nothing");
    grant(wanted(9, "input-only"), 109);
    EXPECT_EQ(broken(judge), "admitted_by_the_rules");
}

TEST_F(Target, GrantsAnotherInterval) {
    const auto open = wanted(1);
    const cip::ForwardOpenReply reply{100, open.t_to_o_id, open.triad, open.o_to_t_rpi, 20'000, {}};
    answer(ask(scanner::open_request(open)), {service::forward_open, {}, reply.encode()});
    EXPECT_EQ(broken(judge), "admitted_by_the_rules");
}

TEST_F(Target, ForgetsAConnection) {
    grant(wanted(1), 100);
    watch.stream_closed(stream);
    settle();  // the real one knows of none
    EXPECT_EQ(broken(judge), "target_timeout_early");
}

TEST_F(Target, KeepsAConnectionWhoseTimeIsOver) {
    open_at_the_real_one();
    settle();
    EXPECT_EQ(broken(judge), "nothing");
    now += 10s;  // and nobody tells the real one
    settle();
    EXPECT_EQ(broken(judge), "target_timeout_late");
}

TEST_F(Target, SendsForNobody) {
    produce(0x0A110001, 1);
    EXPECT_EQ(broken(judge), "produced_for_somebody");
}

TEST_F(Target, SendsAfterTheClose) {
    const auto open = wanted(1);
    grant(open, 100);
    now += 5ms;
    produce(open.t_to_o_id, 1);
    close(open);
    EXPECT_EQ(broken(judge), "nothing");
    produce(open.t_to_o_id, 2);
    EXPECT_EQ(broken(judge), "produced_for_somebody");
}

TEST_F(Target, SendsTooEarly) {
    const auto open = wanted(1);
    grant(open, 100);
    produce(open.t_to_o_id, 1);
    now += 9ms;
    produce(open.t_to_o_id, 2);
    EXPECT_EQ(broken(judge), "produced_in_time");
}

TEST_F(Target, ClosesWhatWasNotOpen) {
    close(wanted(1));
    EXPECT_EQ(broken(judge), "reply_is_asked_for");
}

TEST_F(Target, DoesNotAnswer) {
    ask({service::get_attribute_single, cip::Path::to(1, 1, 1), {}});
    settle();
    EXPECT_EQ(broken(judge), "request_answered");
}

TEST_F(Target, AnswersTwice) {
    const auto request = ask({service::get_attribute_single, cip::Path::to(1, 1, 1), {}});
    answer(request, {service::get_attribute_single, {}, {}});
    EXPECT_EQ(broken(judge), "nothing");
    answer(request, {service::get_attribute_single, {}, {}});
    EXPECT_EQ(broken(judge), "reply_is_asked_for");
}

TEST_F(Target, AnswersAnotherRequest) {
    answer(ask({service::get_attribute_single, cip::Path::to(1, 1, 1), {}}), {service::set_attribute_single, {}, {}});
    EXPECT_EQ(broken(judge), "reply_is_asked_for");
}

TEST_F(Target, EndsATcpConnectionTooEarly) {
    now += 119s;
    watch.stream_expired(stream, now);
    EXPECT_EQ(broken(judge), "explicit_timeout");
}

TEST_F(Target, EndsATcpConnectionInTime) {
    now += 120s;
    watch.stream_expired(stream, now);
    EXPECT_EQ(broken(judge), "nothing");
}

TEST_F(Target, LosesATcpConnection) {
    settle();  // the real one has none
    EXPECT_EQ(broken(judge), "explicit_timeout");
}

/// The real device is enabled, and nobody has lost it.
class Axis : public Target {
protected:
    Axis() {
        watch.stream_closed(stream);
        write(0x20, 1);
        for (const int word : {0x06, 0x07, 0x0F}) write(0x00, word);
        settle();
    }
    void write(std::uint16_t attribute, std::int64_t value) {
        ASSERT_FALSE(device.write(*device.find({0x66, attribute}), value));
    }
    std::int64_t status() { return std::get<std::int64_t>(device.store().value(*device.find({0x66, 0x01}))) & 0x6F; }
    /// An owner who runs.
    void own() {
        id = open_at_the_real_one();
        say(1, true);
    }
    /// To the books alone.
    void say(std::uint32_t sequence, bool run) {
        cip::Bytes octets(enip::io_packet_overhead + 24);
        auto data = enip::begin_io_packet(octets, id, sequence);
        data[0] = static_cast<std::uint8_t>(sequence);
        data[2] = run ? 1 : 0;
        watch.hears_io(originator, octets, now);
    }
    std::uint32_t id = 0;
};

TEST_F(Axis, IsNotInQuickStopAfterAnIdle) {
    own();
    settle();
    EXPECT_EQ(broken(judge), "nothing");
    ASSERT_EQ(status(), 0x27);
    say(2, false);
    settle();
    EXPECT_EQ(broken(judge), "drive_stops_like_a_quick_stop");
}

TEST_F(Axis, IsInQuickStopAfterAnIdle) {
    own();
    settle();
    say(2, false);
    device.inject(drive::event::LoseController{});
    settle();
    EXPECT_EQ(broken(judge), "nothing");
}

TEST_F(Axis, MovesWithoutAnOwner) {
    now += 2s;
    settle();
    now += 1s;
    settle();
    EXPECT_EQ(broken(judge), "nothing");
    device.store().assign(*device.find({0x66, 0x24}), std::int64_t{5'000});
    settle();
    EXPECT_EQ(broken(judge), "drive_stands_without_owner");
}

TEST_F(Axis, HoldsWhatItsOwnerHasNotSaid) {
    own();
    settle();
    EXPECT_EQ(broken(judge), "nothing");
    device.store().assign(*device.find({0x66, 0x3A}), std::int64_t{77});
    settle();
    EXPECT_EQ(broken(judge), "newest_data_is_in_force");
}

TEST(Rest, SomethingIsLeft) {
    Judge judge;
    TargetWatch watch(0, judge);
    drive::Device device(drive::xenax_models().front(), drive::Machine{});
    adapter::Adapter adapter(device, adapter::Limits{}, 1);
    watch.expect_nothing(adapter, Time{1h});
    EXPECT_EQ(broken(judge), "nothing");
    ASSERT_TRUE(adapter.on_open({originator, 1}, {}, Time{1h}));
    watch.expect_nothing(adapter, Time{1h});
    EXPECT_EQ(broken(judge), "nothing_left_behind");
}

// -------------------------------------------------------------------------------------------------- the originator

class Originator : public testing::Test {
protected:
    Originator() { open(); }

    void open() {
        scanner::IoOpened opened;
        opened.reply = {100, id, {}, 10'000, 10'000, {}};
        opened.target = target;
        opened.receiver = receiver;
        watch.opened(opened, plan, now);
    }
    struct Seen {
        bool given = true;  ///< to the application
        bool fresh = true;
        std::optional<std::uint8_t> first{};  ///< instead of what came
    };
    void receive(std::uint32_t sequence, const Seen& seen, std::uint32_t connection = id) {
        cip::Bytes octets(enip::io_packet_overhead + 30);
        auto data = enip::begin_io_packet(octets, connection, sequence);
        data[0] = static_cast<std::uint8_t>(sequence);
        data[2] = static_cast<std::uint8_t>(sequence);
        const auto packet = enip::IoPacket::parse(octets);
        const scanner::IoArrival arrival{target, receiver, octets, *packet, now};
        watch.before(arrival);
        cip::Bytes shown(data.begin() + 2, data.end());
        if (seen.first) shown[0] = *seen.first;
        const enip::IoConsumer::Counters counters;
        if (seen.given) {
            watch.input({.data = shown, .fresh = seen.fresh, .sequence = sequence, .time = now, .counters = counters},
                        now);
        }
        watch.after(now);
    }
    void time_out() { watch.closed({.reason = scanner::CloseReason::timed_out}, now); }
    void send(std::uint32_t sequence) {
        cip::Bytes octets(enip::io_packet_overhead + 24);
        static_cast<void>(enip::begin_io_packet(octets, 100, sequence));
        watch.sends(octets, now);
    }

    static constexpr std::uint32_t id = 0x0A110001;
    static constexpr enip::Endpoint target{0xC0A80264, enip::io_port};
    static constexpr enip::Endpoint receiver{originator, enip::io_port};
    Judge judge;
    OriginatorWatch watch{0, judge};
    IoPlan plan = scanner::plan_of(*assemblies::find_connection("standard"));  // 10 ms, times 16
    Time now{1h};
};

TEST_F(Originator, IsFineWhenItIsFine) {
    for (std::uint32_t i = 1; i < 10; ++i) {
        send(i);
        receive(i, {});
        receive(i, {.given = false});
        now += 10ms;
        watch.settle(now - 1ns);
    }
    EXPECT_EQ(broken(judge), "nothing");
}

TEST_F(Originator, GetsOldData) {
    receive(5, {});
    receive(4, {});
    EXPECT_EQ(broken(judge), "in_order");
}

TEST_F(Originator, GetsDataTwice) {
    receive(5, {});
    receive(5, {.fresh = false});
    EXPECT_EQ(broken(judge), "in_order");
}

TEST_F(Originator, IsToldThatOldDataIsFresh) {
    receive(1, {});
    receive(2, {.fresh = false});
    EXPECT_EQ(broken(judge), "in_order");
}

TEST_F(Originator, GetsDataOfAnother) {
    receive(1, {}, id + 1);
    EXPECT_EQ(broken(judge), "from_its_own_connection");
}

TEST_F(Originator, GetsOtherDataThanWasSent) {
    receive(1, {.first = 0xEE});
    EXPECT_EQ(broken(judge), "from_its_own_connection");
}

TEST_F(Originator, MissesGoodData) {
    receive(1, {.given = false});
    EXPECT_EQ(broken(judge), "nothing_good_is_dropped");
}

TEST_F(Originator, GivesUpTooEarly) {
    receive(1, {});
    now += 160ms - 1ns;
    time_out();
    EXPECT_EQ(broken(judge), "originator_timeout_early");
}

TEST_F(Originator, GivesUpInTime) {
    receive(1, {});
    now += 160ms;
    time_out();
    EXPECT_EQ(broken(judge), "nothing");
}

TEST_F(Originator, GivesUpTooEarlyBeforeTheFirst) {  // R-CON-19
    now += 10s - 1ns;
    time_out();
    EXPECT_EQ(broken(judge), "originator_timeout_early");
}

TEST_F(Originator, GivesUpTooLate) {
    receive(1, {});
    now += 160ms + 1ns;
    time_out();
    EXPECT_EQ(broken(judge), "originator_timeout_late");
}

TEST_F(Originator, DoesNotGiveUp) {
    receive(1, {});
    now += 160ms;
    watch.settle(now);
    EXPECT_EQ(broken(judge), "originator_timeout_late");
}

TEST_F(Originator, IsRevived) {
    receive(1, {});
    now += 160ms;
    receive(2, {});
    EXPECT_EQ(broken(judge), "originator_timeout_late");
}

TEST_F(Originator, SendsWithoutAConnection) {
    watch.left();
    send(1);
    EXPECT_EQ(broken(judge), "produced_for_somebody");
}

TEST_F(Originator, LeavesOutANumber) {
    send(1);
    now += 10ms;
    send(3);
    EXPECT_EQ(broken(judge), "produced_in_sequence");
}

}  // namespace
}  // namespace servobus::sim
