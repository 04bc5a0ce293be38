// Class 1 data both ways, and what becomes of connections: sequence rules, timeouts, ownership, multicast, triggers
// (R-CON-16 to R-CON-37, R-CON-50, R-CON-51, R-IO, R-MC). In virtual time, to the microsecond.
#include <gmock/gmock.h>

#include <map>
#include <random>

#include "adapter/time_sync.hpp"
#include "tests/adapter/io_site.hpp"

namespace servobus::test {
namespace {

using adapter::Counter;
using testing::HasSubstr;

// The example values of the golden vectors, which every output assembly begins with.
constexpr std::string_view outputs_112 =
    "400D0300 50C30000 40420F00 14000000 1F00 B004 E8030000 14000000 03000000 DC050000 00000000 0040222018240A00";
cip::Bytes outputs_of(std::uint16_t point) {
    auto all = octets(outputs_112);
    all.resize(points_of(point).o_to_t_size - 6U);
    return all;
}
constexpr std::string_view target = "TargetPositionOrDistance";

void set(IoSite& site, std::string_view name, std::int64_t value) {
    const auto rows = drive::find_by_name(site.device.store().table(), drive::parameter_classes(), name);
    ASSERT_EQ(rows.size(), 1U) << name;
    site.device.store().assign(*rows.front(), value);
}
/// Target position alone, everything else 0.
cip::Bytes target_of(std::uint32_t position) {
    cip::Bytes bytes;
    cip::Writer writer(bytes);
    writer.u32(position);
    bytes.resize(18);
    return bytes;
}

// ------------------------------------------------------------------------------------------------------ data both ways

TEST(IoData, R_IO_1_EachOutputAssemblyReachesTheDriveOctetByOctet) {
    struct Value {
        const char* name;
        std::int64_t value;
        unsigned end;  ///< octets of data that it needs
    };
    const std::vector<Value> values{{"TargetPositionOrDistance", 200'000, 4},
                                    {"SpeedJogOrProfilePositionMode", 50'000, 8},
                                    {"AccelerationJogOrProfilePositionMode", 1'000'000, 12},
                                    {"SCurve", 20, 16},
                                    {"Controlword", 0x1F, 18},
                                    {"LimitIForce", 1200, 20},
                                    {"FollowingPositionErrorWindow", 1000, 24},
                                    {"TargetPositionWindow", 20, 28},
                                    {"DigitalOutputsXENAX", 3, 32},
                                    {"LimitForce", 1500, 36}};
    for (const auto point : owner_points) {
        IoSite site;
        IoPeer peer(site);
        std::map<std::string, std::int64_t> before;
        for (const auto& each : values) {
            set(site, each.name, 5);
            before[each.name] = 5;
        }
        const auto link = peer.must_open(io_open(1, point));
        const auto data = outputs_of(point);
        peer.send(o_to_t(link, 1, 1, idle, data));
        for (const auto& each : values) EXPECT_EQ(site.value(each.name), 5) << each.name << " in idle (R-IO-6)";
        peer.send(o_to_t(link, 2, 1, run, data));
        for (const auto& each : values) {
            EXPECT_EQ(site.value(each.name), each.end <= data.size() ? each.value : 5) << point << " " << each.name;
        }
        // R-ASM-2, R-ASM-7: what was received, padding as 0.
        EXPECT_EQ(peer.call(fmt::format("0E 03 20 04 24 {:02X} 30 03", point)), hex(octets("8E 00 00 00") + data));
        // R-IO-9: the header's other bits do not count.
        auto next = data;
        next[0] = 0x41;
        peer.send(o_to_t(link, 3, 2, 0xFFFFFFFF, next));
        EXPECT_EQ(site.value(target), 200'001);
    }
}

TEST(IoData, R_IO_2_EachInputAssemblyComesFromTheDriveOctetByOctet) {
    for (const auto& points : all_points) {
        if (points.o_to_t == 255) continue;
        IoSite site;
        site.adapter.on_day_clock(1'700'000'000'000'000us);
        IoPeer peer(site);
        set(site, "Statusword", 0x0237);
        set(site, "MotorCurrentActualValue", 250);
        set(site, "PositionActualValue", 123'456);
        set(site, "IForceActual", -125);
        set(site, "ProcessStatusRegisterXENAX", 3);
        set(site, "ActualPositionFollowingError", -2);
        set(site, "DigitalInputsXENAX", 5);
        set(site, "DigitalOutputsXENAX", 1);
        set(site, "ForceActual", 1490);
        const auto link = peer.must_open(io_open(1, points.o_to_t, points.t_to_o));
        site.advance(10ms);
        const auto sent = site.take();
        ASSERT_EQ(sent.size(), 1U) << "R-CON-50: the first within one API";
        std::string data = "3702 FA00 40E20100 83FFFFFF 03000000 FEFFFFFF 05000000 01000000";
        if (points.t_to_o != 100) data += "D2050000";
        if (points.t_to_o == 113) {
            const auto now = std::chrono::duration_cast<microseconds>(sent[0].at.time_since_epoch()).count();
            cip::Bytes stamp;
            cip::Writer(stamp).u64(static_cast<std::uint64_t>(1'700'000'000'000'000 + now));
            data += hex(stamp);
        }
        EXPECT_EQ(hex(sent[0].octets),
                  hex(fmt::format("0200 0280 0800 0100110A 01000000 B100 {:02X}00 0100 {}", points.t_to_o_size, data)));
        EXPECT_EQ(sent[0].route.peer, (enip::Endpoint{IoPeer::usual_address, 2222}));
        EXPECT_EQ(link.reply.t_to_o_id, 0x0A110001U);
    }
}

// Somebody sets the clock, or PTP keeps it right: the time stamps are those of the clock as it is now, to the
// microsecond.
TEST(IoData, R_IO_10_TimeStampsFollowTheClockOfTheDay) {
    IoSite site;
    IoPeer peer(site);
    const adapter::TimeSync known{.utc_offset = 37s};
    (void)peer.must_open(io_open(1, 112, 113));
    const auto stamp = [&] {
        site.advance(10ms);
        const auto sent = site.take();
        if (sent.size() != 1) return microseconds(0);
        const auto octets = cip::ByteView(sent[0].octets).last(sizeof(std::uint64_t));
        const auto stamped = microseconds(static_cast<std::int64_t>(cip::Reader(octets).u64()));
        return stamped - std::chrono::floor<microseconds>(sent[0].at.time_since_epoch());
    };
    EXPECT_EQ(stamp(), 0us);
    for (const std::chrono::nanoseconds ahead :
         std::vector<std::chrono::nanoseconds>{1'700'000'000s, 1'700'000'000s + 1us, 1'600'000'000s + 1999ns, -1h}) {
        site.adapter.on_day_clock(ahead);
        EXPECT_EQ(stamp(), std::chrono::floor<microseconds>(ahead));
    }
    site.adapter.on_day_clock(1'700'000'000s);
    site.adapter.follow_time(known);  // R-TSY-3: the time of PTP
    EXPECT_EQ(stamp(), 1'700'000'037s);
}

TEST(IoData, R_IO_5_NewDataHasANewCountAndTheSameDataKeepsIt) {
    IoSite site;
    IoPeer peer(site);
    (void)peer.must_open(io_open(1));
    std::vector<std::uint16_t> counts;
    std::vector<std::uint32_t> sequences;
    for (int i = 0; i < 9; ++i) {
        set(site, "PositionActualValue", i / 3);
        site.advance(10ms);
        for (const auto& each : site.take()) {
            counts.push_back(count_in(each.octets));
            sequences.push_back(sequence_in(each.octets));
        }
    }
    EXPECT_EQ(counts, (std::vector<std::uint16_t>{1, 1, 1, 2, 2, 2, 3, 3, 3}));
    EXPECT_EQ(sequences, (std::vector<std::uint32_t>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

TEST(IoData, R_IO_9_ABadMemberIsLeftOutAndTheOthersCount) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    set(site, "SCurve", 20);
    auto data = target_of(7);
    data[12] = 101;  // SCurve goes to 100
    peer.send(o_to_t(link, 1, 1, run, data));
    EXPECT_EQ(site.value("SCurve"), 20);
    EXPECT_EQ(site.value(target), 7);
    EXPECT_THAT(site.last_warning(), HasSubstr("output assembly 101: "));
    EXPECT_THAT(site.last_warning(), HasSubstr("SCurve"));
}

// ------------------------------------------------------------------------------------------------------ sequence rules

TEST(IoData, R_IO_5_OldAndEqualNumbersChangeNothing) {
    for (const std::uint32_t first : {0U, 1U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFEU, 0xFFFFFFFFU}) {
        IoSite site;
        IoPeer peer(site);
        const auto link = peer.must_open(io_open(1));
        const auto& consumer = site.adapter.io().owner()->consumer;
        peer.send(o_to_t(link, first, 1, run, target_of(1)));
        EXPECT_EQ(site.value(target), 1) << "R-IO-5: the first is accepted whatever its number";
        std::uint16_t count = 1;
        for (const std::uint32_t back : {0U, 1U, 2U, 1000U, 0x7FFFFFFFU, 0x80000000U}) {
            site.advance(1ms);
            const auto deadline = consumer.deadline();
            peer.send(o_to_t(link, first - back, ++count, run, target_of(99)));
            EXPECT_EQ(site.value(target), 1) << back;
            EXPECT_EQ(consumer.deadline(), deadline) << "R-IO-8: it keeps nothing alive";
        }
        EXPECT_EQ(consumer.counters().stale, 6U);
        peer.send(o_to_t(link, first + 3, ++count, run, target_of(2)));
        EXPECT_EQ(site.value(target), 2);
        EXPECT_EQ(consumer.counters().lost, 2U);
        peer.send(o_to_t(link, first + 3 + 0x7FFFFFFF, ++count, run, target_of(3)));
        EXPECT_EQ(site.value(target), 3) << "the greatest step forward";
        EXPECT_EQ(consumer.counters().accepted, 3U);
    }
}

TEST(IoData, R_IO_5_ARepeatKeepsAliveAndIsNotAppliedAgain) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.send(o_to_t(link, 1, 7, run, target_of(1)));
    set(site, target, 55);
    for (std::uint32_t sequence = 2; sequence < 20; ++sequence) {
        site.advance(30ms);
        peer.send(o_to_t(link, sequence, 7, run, target_of(1)));
        EXPECT_EQ(site.value(target), 55);
    }
    EXPECT_EQ(site.adapter.io().size(), 1U);
    peer.send(o_to_t(link, 20, 6, run, target_of(6)));
    EXPECT_EQ(site.value(target), 6) << "any other count is new, lower ones too";
}

TEST(IoData, R_IO_6_IdleAppliesNothingAndRunAppliesTheSameCount) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.send(o_to_t(link, 1, 1, run, target_of(1)));
    peer.send(o_to_t(link, 2, 2, idle, target_of(2)));
    EXPECT_EQ(site.value(target), 1);
    peer.send(o_to_t(link, 3, 3, idle, target_of(3)));
    EXPECT_EQ(site.value(target), 1);
    peer.send(o_to_t(link, 4, 3, run, target_of(3)));
    EXPECT_EQ(site.value(target), 3) << "the data of that datagram, whose count is the last one's";
    const auto modes = std::ranges::count_if(site.log, [](const auto& line) {
        return line.text.ends_with(" goes to idle") || line.text.ends_with(" runs");
    });
    EXPECT_EQ(modes, 3) << "one line for each change";
}

// ---------------------------------------------------------------------------------------------------- hostile datagrams

struct Stray {
    const char* what;
    std::function<cip::Bytes(const Link&)> datagram;
    std::uint64_t adapter::StrayCounters::*stray = nullptr;  ///< what counts it; otherwise wrong_size of the connection
    std::uint32_t from = IoPeer::usual_address;
};

cip::Bytes changed(cip::Bytes datagram, std::size_t at, std::uint8_t to) {
    datagram[at] = to;
    return datagram;
}

TEST(IoData, R_IO_7_R_IO_8_WhatIsNotRightChangesNothingAndIsCounted) {
    using adapter::StrayCounters;
    const auto good = [](const Link& link) { return o_to_t(link, 2, 2, run, target_of(99)); };
    const auto sized = [](int difference) {
        return [=](const Link& link) {
            auto data = target_of(99);
            data.resize(static_cast<std::size_t>(18 + difference));
            return o_to_t(link, 2, 2, run, data);
        };
    };
    const auto octet = [=](std::size_t at, std::uint8_t to) {
        return [=](const Link& link) { return changed(good(link), at, to); };
    };
    const std::vector<Stray> strays{
        {"empty", [](const auto&) { return cip::Bytes{}; }, &StrayCounters::malformed},
        {"one octet", [](const auto&) { return octets("02"); }, &StrayCounters::malformed},
        {"two octets", [](const auto&) { return octets("02 00"); }, &StrayCounters::malformed},
        {"no items", [](const auto&) { return octets("00 00"); }, &StrayCounters::malformed},
        {"65535 items", [](const auto&) { return octets("FF FF 02 80"); }, &StrayCounters::malformed},
        {"one item", octet(0, 1), &StrayCounters::malformed},
        {"three items", octet(0, 3), &StrayCounters::malformed},
        {"another address item", octet(2, 0xA1), &StrayCounters::malformed},
        {"a short address item", octet(4, 4), &StrayCounters::malformed},
        {"a long address item", octet(4, 12), &StrayCounters::malformed},
        {"another data item", octet(14, 0xB2), &StrayCounters::malformed},
        {"a length beyond the datagram", octet(16, 25), &StrayCounters::malformed},
        {"the longest length", octet(17, 0xFF), &StrayCounters::malformed},
        {"an id that nobody has", octet(9, 0x77), &StrayCounters::unknown_id},
        {"the T->O id",
         [=](const auto& link) {
             auto datagram = good(link);
             for (std::size_t i = 0; i < 4; ++i) {
                 datagram[6 + i] = static_cast<std::uint8_t>(link.reply.t_to_o_id >> (8 * i));
             }
             return datagram;
         },
         &StrayCounters::unknown_id},
        {"another address", good, &StrayCounters::wrong_source, 0xC0A80202},
        {"no address", good, &StrayCounters::wrong_source, 0},
        {"one octet short", sized(-1)},
        {"one octet too many", sized(1)},
        {"no data", sized(-18)},
        {"a heartbeat", [](const auto& link) { return heartbeat(link, 2, 2); }},
        {"without header",
         [](const auto& link) { return cip::Bytes{changed(o_to_t(link, 2, 2, run, cip::Bytes(14)), 16, 20)}; }},
        {"an empty data item", [=](const auto& link) { return changed(good(link), 16, 0); }},
        {"a length that leaves one octet out", octet(16, 23)},
    };
    for (const auto& stray : strays) {
        SCOPED_TRACE(stray.what);
        IoSite site;
        IoPeer peer(site);
        IoPeer sender(site, stray.from == 0 ? 0xC0A80203 : stray.from);
        const auto link = peer.must_open(io_open(1));
        peer.send(o_to_t(link, 1, 1, run, target_of(1)));
        site.advance(25ms);
        const auto& consumer = site.adapter.io().owner()->consumer;
        const auto deadline = consumer.deadline();
        site.take();
        sender.send(stray.datagram(link));
        EXPECT_EQ(site.value(target), 1);
        EXPECT_EQ(consumer.deadline(), deadline) << "the watchdog goes on";
        const auto& counted = site.adapter.io().strays();
        EXPECT_EQ(counted.malformed + counted.unknown_id + counted.wrong_source, stray.stray != nullptr ? 1U : 0U);
        if (stray.stray != nullptr) {
            EXPECT_EQ(counted.*stray.stray, 1U);
        }
        EXPECT_EQ(consumer.counters().wrong_size, stray.stray == nullptr ? 1U : 0U);
        EXPECT_EQ(consumer.counters().accepted, 1U);
        EXPECT_TRUE(site.take().empty()) << "nothing is answered";
        peer.send(good(link));
        EXPECT_EQ(site.value(target), 99) << "it has not used up the sequence number either";
        EXPECT_EQ(site.adapter.io().size(), 1U);
    }
}

TEST(IoData, R_IO_7_TheSourcePortDoesNotCountAndOctetsBehindTheItemsNeither) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.send(o_to_t(link, 1, 1, run, target_of(1)), 54321);
    EXPECT_EQ(site.value(target), 1);
    peer.send(o_to_t(link, 2, 2, run, target_of(2)) + octets("00 00 AA"));
    EXPECT_EQ(site.value(target), 2) << "R-IO-8";
}

TEST(IoData, R_CON_31_WhoLooksOnControlsNothing) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(multicast(io_open(1, 254)));
    const auto listener = peer.must_open(multicast(io_open(2, 255)));
    set(site, target, 5);
    for (const auto& each : {link, listener}) {
        peer.send(o_to_t(each, 1, 1, run, target_of(1)));
        peer.send(heartbeat(each, 2, 2));
    }
    EXPECT_EQ(site.value(target), 5);
    for (const auto& each : site.adapter.io().all()) EXPECT_EQ(each->consumer.counters().wrong_size, 1U);
}

// ----------------------------------------------------------------------------------------------------------- timeouts

TEST(IoData, R_CON_18_EachMultiplierNeitherEarlyNorLate) {
    for (std::uint8_t code = 0; code < 8; ++code) {
        for (const std::uint32_t interval : {1000U, 1001U, 12'500U, 3'200'000U}) {
            IoSite site;
            IoPeer peer(site);
            auto open = io_open(1);
            open.timeout_multiplier = code;
            open.o_to_t_rpi = interval;
            open.t_to_o_rpi = 3'200'000;
            const auto link = peer.must_open(open);
            site.advance(1234567us);
            peer.send(o_to_t(link, 1, 1, run, target_of(1)));
            const microseconds timeout{std::int64_t{interval} * (4 << code)};
            site.advance(timeout - 1us);
            site.tick();
            ASSERT_EQ(site.adapter.io().size(), 1U) << "code " << int{code} << ", " << interval << " us";
            EXPECT_EQ(site.counter(Counter::connection_timeouts), 0U);
            site.advance(1us);
            EXPECT_EQ(site.adapter.io().size(), 0U) << "code " << int{code} << ", " << interval << " us";
            EXPECT_EQ(site.counter(Counter::connection_timeouts), 1U);
            EXPECT_THAT(site.last_warning(),
                        HasSubstr(fmt::format("timed out: no datagram for {} ms", timeout.count() / 1000)));
            site.take();
            site.advance(10s);
            EXPECT_TRUE(site.take().empty()) << "R-CON-21: it stops to produce";
            IoPeer again(site);  // the session may have timed out as well
            EXPECT_TRUE(again.open(io_open(1))) << "and its triad is free";
        }
    }
}

TEST(IoData, R_CON_19_TheFirstDatagramMayTakeTenSecondsOrAsLongAsTheTimeout) {
    struct Case {
        std::uint32_t interval;
        std::uint8_t code;
        microseconds patience;
    };
    for (const auto& each : {Case{1000, 0, 10s}, Case{10'000, 2, 10s}, Case{2'500'000, 0, 10s},
                             Case{2'500'001, 0, 10'000'004us}, Case{3'200'000, 7, 1638'400ms}}) {
        for (const bool comes : {false, true}) {
            IoSite site;
            IoPeer peer(site);
            auto open = io_open(1);
            open.o_to_t_rpi = each.interval;
            open.t_to_o_rpi = 3'200'000;
            open.timeout_multiplier = each.code;
            const auto link = peer.must_open(open);
            site.advance(each.patience - 1us);
            site.tick();
            ASSERT_EQ(site.adapter.io().size(), 1U);
            if (comes) {
                peer.send(o_to_t(link, 1, 1, run, target_of(1)));
                EXPECT_EQ(site.value(target), 1);
                site.advance(1ms);
                EXPECT_EQ(site.adapter.io().size(), 1U);
                continue;
            }
            site.advance(1us);
            EXPECT_EQ(site.adapter.io().size(), 0U);
            EXPECT_THAT(site.last_warning(), HasSubstr("none has ever come"));
        }
    }
}

TEST(IoData, R_CON_20_EveryValidDatagramRestartsTheWatchdog) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(every(io_open(1), 1000));  // x4 at 1 ms
    const auto looker = peer.must_open(every(io_open(2, 254), 1000));
    std::uint32_t sequence = 0;
    for (int i = 0; i < 5000; ++i) {
        ++sequence;
        peer.send(o_to_t(link, sequence, static_cast<std::uint16_t>(i / 7), i % 5 == 0 ? idle : run, target_of(1)));
        peer.send(heartbeat(looker, sequence, 3));
        site.advance(i % 10 == 0 ? 3999us : 1000us);  // three are lost now and then
        site.take();
    }
    EXPECT_EQ(site.adapter.io().size(), 2U);
    EXPECT_EQ(site.counter(Counter::connection_timeouts), 0U);
    peer.send(o_to_t(link, ++sequence, 1, run, target_of(1)));
    peer.send(heartbeat(looker, sequence));
    site.advance(4000us);
    EXPECT_EQ(site.adapter.io().size(), 0U);
    EXPECT_EQ(site.counter(Counter::connection_timeouts), 2U);
}

TEST(IoData, R_CON_21_ADatagramDoesNotReviveWhatIsOver) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.send(o_to_t(link, 1, 1, run, target_of(1)));
    site.now += 40ms;  // nobody has looked at the timer yet
    peer.send(o_to_t(link, 2, 2, run, target_of(2)));
    EXPECT_EQ(site.value(target), 1);
    EXPECT_EQ(site.adapter.io().strays().too_late, 1U);
    site.tick();
    EXPECT_EQ(site.adapter.io().size(), 0U);
    peer.send(o_to_t(link, 3, 3, run, target_of(3)));
    EXPECT_EQ(site.value(target), 1);
    EXPECT_EQ(site.adapter.io().strays().unknown_id, 1U);
}

// ---------------------------------------------------------------------------------------- the drive without controller

/// A drive with an axis that an owner of 101/100 moves at 200,000 increments/s; 6085h is 1,000,000.
class MovingAxis : public testing::Test {
protected:
    void write(std::string_view name, std::int64_t value) {
        const auto rows = drive::find_by_name(site_.device.store().table(), drive::parameter_classes(), name);
        ASSERT_EQ(rows.size(), 1U) << name;
        const auto refusal = site_.device.write(*rows.front(), value);
        ASSERT_FALSE(refusal) << name << ": " << drive::describe(*refusal);
    }
    /// Sends every 10 ms what the owner wants.
    void cycle(microseconds duration, std::uint32_t header = run) {
        for (microseconds passed{0}; passed < duration; passed += 10ms) {
            ++count_;
            if (owner_) peer_.send(o_to_t(*owner_, ++sequence_, count_, header, outputs_));
            site_.advance(10ms);
        }
    }
    void want(std::uint32_t position, std::uint16_t word) {
        outputs_.clear();
        cip::Writer writer(outputs_);
        writer.u32(position);
        writer.u32(200'000);
        writer.u32(2'000'000);
        writer.u32(20);
        writer.u16(word);
    }
    void SetUp() override {
        write("ModesOfOperationRequested", 6);
        write("ReferenceMethods", 1);
        for (const auto word : {0x06, 0x07, 0x0F, 0x1F}) write("Controlword", word);
        for (int i = 0; i < 300 && (site_.value("Statusword") & 0x1000) == 0; ++i) site_.advance(100ms);
        ASSERT_NE(site_.value("Statusword") & 0x1000, 0) << "no reference";
        write("ModesOfOperationRequested", 1);
        write("DecelerationQuickStop", 1'000'000);
        auto open = io_open(1);
        owner_ = peer_.must_open(open);
        want(10'000, 0x0F);
        cycle(50ms);
        want(10'000, 0x1F);
        cycle(2s);
        want(220'000, 0x0F);
        cycle(50ms);
        want(220'000, 0x1F);
        cycle(200ms);
        ASSERT_NEAR(static_cast<double>(site_.value("TellVelocity")), 200'000, 5'000);
        ASSERT_EQ(state(), 0x0027);
    }
    std::int64_t state() { return site_.value("Statusword") & 0x6F; }
    void stops(double place) {
        EXPECT_EQ(state(), 0x0007) << "quick stop active";
        cycle(100ms);
        EXPECT_NEAR(static_cast<double>(site_.value("TellVelocity")), 100'000, 15'000);
        cycle(200ms);
        EXPECT_NEAR(static_cast<double>(site_.value("PositionActualValue")) - place, 20'000, 2'000)
            << "the ramp of the quick stop";
        stands();
        EXPECT_EQ(state(), 0x0007);
    }
    void stands() {
        cycle(300ms);
        const auto place = site_.value("PositionActualValue");
        cycle(500ms);
        EXPECT_NEAR(static_cast<double>(site_.value("PositionActualValue") - place), 0, 20);
    }
    double position() { return static_cast<double>(site_.value("PositionActualValue")); }

    IoSite site_{drive::Device(*drive::xenax_model("75v8s"), drive::Machine{})};
    IoPeer peer_{site_};
    std::optional<Link> owner_;
    cip::Bytes outputs_;
    std::uint32_t sequence_ = 0;
    std::uint16_t count_ = 0;
};

TEST_F(MovingAxis, R_IO_6_StopsWhenTheOwnerGoesToIdle) {
    const auto place = position();
    peer_.send(o_to_t(*owner_, ++sequence_, ++count_, idle, outputs_));
    const auto owner = std::exchange(owner_, std::nullopt);
    EXPECT_EQ(state(), 0x0007);
    for (int i = 0; i < 30; ++i) {
        site_.advance(10ms);
        peer_.send(o_to_t(*owner, ++sequence_, ++count_, idle, outputs_));
    }
    EXPECT_NEAR(position() - place, 20'000, 2'000);
    owner_ = owner;
    stands();  // back in run with the same word: the old start bit starts nothing
    want(220'000, 0x0F);
    cycle(50ms);
    stands();
    want(220'000, 0x1F);
    cycle(3s);
    EXPECT_NEAR(position(), 220'000, 100) << "a new edge does";
}

TEST_F(MovingAxis, R_CON_34_StopsWhenTheOwnerCloses) {
    const auto place = position();
    ASSERT_EQ(peer_.close(*owner_), closed(owner_->request.triad));
    owner_.reset();
    stops(place);
}

TEST_F(MovingAxis, R_CON_21_StopsWhenTheOwnerIsLost) {
    owner_.reset();
    site_.advance(29'999us);  // of the 40 ms, ten have passed with the last cycle
    EXPECT_EQ(state(), 0x0027) << "not before its time";
    const auto place = position();
    site_.advance(1us);
    EXPECT_EQ(site_.adapter.io().size(), 0U);
    stops(place);
}

TEST_F(MovingAxis, R_ENC_25_GoesOnWhenTheSessionEnds) {
    peer_.disconnect();
    cycle(300ms);
    EXPECT_EQ(state(), 0x0027);
    EXPECT_NEAR(static_cast<double>(site_.value("TellVelocity")), 200'000, 5'000);
}

TEST_F(MovingAxis, R_CON_31_GoesOnWhenSomebodyElseComesAndGoes) {
    IoPeer other(site_, 0xC0A80202);
    const auto looker = other.must_open(io_open(2, 254));
    (void)other.must_open(every(io_open(3, 254), 1000));
    (void)other.refusal(io_open(4, 102));
    cycle(50ms);
    (void)other.close(looker);
    cycle(50ms);
    EXPECT_EQ(state(), 0x0027);
    EXPECT_NEAR(static_cast<double>(site_.value("TellVelocity")), 200'000, 5'000);
}

// ------------------------------------------------------------------------------------------------- who goes with whom

enum class End : std::uint8_t { closed, timed_out };
class IoOwnership : public testing::TestWithParam<End> {
protected:
    /// All connections are kept alive but the one that times out.
    void end(const Link& link, std::vector<Link> others) {
        if (GetParam() == End::closed) {
            EXPECT_EQ(peer_.close(link), closed(link.request.triad));
            return;
        }
        peer_.send(link.request.o_to_t.size == 2 ? heartbeat(link, ++sequence_)
                                                 : o_to_t(link, ++sequence_, 1, run, target_of(1)));
        for (int i = 0; i < 4; ++i) {
            for (const auto& each : others) {
                peer_.send(each.request.o_to_t.size == 2 ? heartbeat(each, ++sequence_)
                                                         : o_to_t(each, ++sequence_, 1, run, target_of(1)));
            }
            site_.advance(10ms);
        }
        EXPECT_EQ(site_.counter(Counter::connection_timeouts), ++timeouts_);
    }
    std::vector<unsigned> open_ones() {
        std::vector<unsigned> serials;
        for (const auto& each : site_.adapter.io().all()) serials.push_back(each->request.triad.serial_number);
        std::ranges::sort(serials);
        return serials;
    }
    /// How many datagrams leave in an interval, by id.
    std::map<std::uint32_t, unsigned> produced() {
        site_.take();
        site_.advance(10ms);
        std::map<std::uint32_t, unsigned> counts;
        for (const auto& each : site_.take()) ++counts[id_in(each.octets)];
        return counts;
    }
    using Serials = std::vector<unsigned>;

    IoSite site_;
    IoPeer peer_{site_};
    std::uint32_t sequence_ = 0;
    unsigned timeouts_ = 0;
};

TEST_P(IoOwnership, R_CON_33_ProductionGoesOnWhenTheMasterEnds) {
    const auto owner = peer_.must_open(multicast(io_open(1)));
    const auto looker = peer_.must_open(multicast(io_open(2, 254)));
    const auto listener = peer_.must_open(multicast(io_open(3, 255)));
    EXPECT_EQ(owner.reply.t_to_o_id, looker.reply.t_to_o_id);
    EXPECT_EQ(owner.reply.t_to_o_id, listener.reply.t_to_o_id);
    const std::map<std::uint32_t, unsigned> once{{owner.reply.t_to_o_id, 1}};
    EXPECT_EQ(produced(), once) << "one datagram for three";
    end(owner, {looker, listener});
    EXPECT_EQ(open_ones(), (Serials{2, 3}));
    EXPECT_EQ(produced(), once);
    EXPECT_TRUE(peer_.open(multicast(io_open(4)))) << "a new owner joins again";
    EXPECT_EQ(produced(), once);
    EXPECT_EQ(peer_.refusal(every(multicast(io_open(5, 254)), 20'000)), hex("01 06 1201 0004 204E0000 10270000"))
        << "the interval is still the first one's";
}

TEST_P(IoOwnership, R_CON_32_AListenerGoesWithTheLastThatIsNone) {
    const auto owner = peer_.must_open(multicast(io_open(1)));
    const auto looker = peer_.must_open(multicast(io_open(2, 254)));
    (void)peer_.must_open(multicast(io_open(3, 255)));
    (void)peer_.must_open(multicast(io_open(4, 255)));
    const auto others = peer_.must_open(multicast(io_open(5, 254, 105)));
    (void)peer_.must_open(multicast(io_open(6, 255, 105)));
    const auto own = peer_.must_open(io_open(7, 254));
    end(looker, {owner, others, own});  // the listeners have their ten seconds
    EXPECT_EQ(open_ones(), (Serials{1, 3, 4, 5, 6, 7}));
    end(owner, {others, own});
    EXPECT_EQ(open_ones(), (Serials{5, 6, 7})) << "the ones of 100, and nobody else";
    EXPECT_EQ(site_.counter(Counter::connection_timeouts), timeouts_) << "to go with somebody is no timeout";
    const std::map<std::uint32_t, unsigned> left{{others.reply.t_to_o_id, 1}, {own.reply.t_to_o_id, 1}};
    EXPECT_EQ(produced(), left);
    EXPECT_TRUE(std::ranges::any_of(site_.log, [](const auto& line) {
        return line.text.find("listen only 255/100 of 192.168.2.1 ends: what it listened to has been closed") !=
               std::string::npos;
    }));
}

TEST_P(IoOwnership, R_CON_32_AnOwnerWithAStreamOfItsOwnKeepsNoListener) {
    const auto owner = peer_.must_open(io_open(1));
    const auto looker = peer_.must_open(multicast(io_open(2, 254)));
    (void)peer_.must_open(multicast(io_open(3, 255)));
    end(looker, {owner});
    EXPECT_EQ(open_ones(), Serials{1});
    EXPECT_EQ(produced(), (std::map<std::uint32_t, unsigned>{{owner.reply.t_to_o_id, 1}}));
}

TEST_P(IoOwnership, R_CON_32_AListenerThatEndsTakesNobodyWithIt) {
    const auto owner = peer_.must_open(multicast(io_open(1)));
    const auto listener = peer_.must_open(multicast(io_open(3, 255)));
    end(listener, {owner});
    EXPECT_EQ(open_ones(), Serials{1});
}

TEST_P(IoOwnership, R_CON_30_OwnershipIsFreeAtOnce) {
    for (const auto point : owner_points) {
        const auto owner = peer_.must_open(io_open(1, point));
        if (GetParam() == End::closed) {
            end(owner, {});
        } else {
            peer_.send(o_to_t(owner, ++sequence_, 1, run, outputs_of(point)));
            site_.advance(40ms);
        }
        EXPECT_EQ(site_.adapter.io().owner(), nullptr);
        EXPECT_TRUE(produced().empty());
    }
}

INSTANTIATE_TEST_SUITE_P(Io, IoOwnership, testing::Values(End::closed, End::timed_out),
                         [](const auto& each) { return each.param == End::closed ? "Closed" : "TimedOut"; });

TEST(IoData, R_CON_37_NothingLeavesAndNothingArrivesAfterTheClose) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(every(io_open(1), 1000));
    peer.send(o_to_t(link, 1, 1, run, target_of(1)));
    site.advance(3500us);
    site.take();
    ASSERT_EQ(peer.close(link), closed(link.request.triad));
    EXPECT_TRUE(site.take().empty());
    peer.send(o_to_t(link, 2, 2, run, target_of(2)));
    site.advance(1s);
    EXPECT_TRUE(site.take().empty());
    EXPECT_EQ(site.value(target), 1);
    EXPECT_EQ(site.adapter.io().strays().unknown_id, 1U);
    // The same triad again: another id, its own ten seconds, sequence numbers from the start.
    const auto again = peer.must_open(every(io_open(1), 1000));
    EXPECT_NE(again.reply.o_to_t_id, link.reply.o_to_t_id);
    peer.send(o_to_t(link, 3, 3, run, target_of(3)));
    EXPECT_EQ(site.value(target), 1) << "the old one's datagrams are nobody's";
    peer.send(o_to_t(again, 1, 1, run, target_of(4)));
    EXPECT_EQ(site.value(target), 4);
}

TEST(IoData, R_ASM_5_AnOwnedAssemblyIsNotWrittenByMessages) {
    IoSite site;
    IoPeer peer(site);
    const std::string write = "10 03 20 04 24 65 30 03 " + hex(outputs_of(101));
    EXPECT_EQ(peer.call(write), hex("90 00 00 00"));
    const auto looker = peer.must_open(io_open(2, 254));
    EXPECT_EQ(peer.call(write), hex("90 00 00 00"));
    const auto link = peer.must_open(io_open(1));
    EXPECT_EQ(peer.call(write), hex("90 00 0E 00"));
    (void)peer.close(link);
    EXPECT_EQ(peer.call(write), hex("90 00 00 00"));
}

// ------------------------------------------------------------------------------------------ multicast and socket items

TEST(IoData, R_MC_1_TheGroupsOfTheExamples) {
    struct Case {
        unsigned bits;
        std::uint32_t address;
        std::uint32_t base;
    };
    for (const auto& each :
         {Case{24, 0xC0A80264, 0xEFC00D60}, Case{22, 0xC0A80264, 0xEFC04D60}, Case{24, 0xC0A80201, 0xEFC00100},
          Case{0, 0xC0A80264, 0xEFC00D60}, Case{8, 0x7F000004, 0xEFC00160}, Case{16, 0xC0A80401, 0xEFC00100},
          Case{16, 0xC0A803FF, 0xEFC080C0}}) {
        for (const std::uint16_t point : std::array<std::uint16_t, 3>{100, 105, 113}) {
            auto network = IoSite::in_subnet(each.bits);
            network.state.interface.address = each.address;
            IoSite site(drive::Device(drive::xenax_models().front()), {}, network);
            IoPeer peer(site, each.address == 0xC0A80201 ? 0xC0A80202 : (each.address & 0xFFFFFF00) | 1);
            const auto link = peer.must_open(multicast(io_open(1, 254, point)));
            const enip::Endpoint group{each.base + (point == 100 ? 0 : point == 105 ? 1 : 2), 2222};
            const auto told = link.socket(enip::ItemType::sockaddr_t_to_o);
            ASSERT_TRUE(told) << "R-CPF-8";
            EXPECT_EQ((enip::Endpoint{told->address, told->port}), group) << enip::to_string(group);
            EXPECT_EQ(told->family, 2);
            site.advance(10ms);
            const auto sent = site.take();
            ASSERT_EQ(sent.size(), 1U);
            EXPECT_EQ(sent[0].route.peer, group);
            EXPECT_EQ(sent[0].route.ttl, 1);
            EXPECT_EQ(id_in(sent[0].octets), link.reply.t_to_o_id);
            EXPECT_NE(link.reply.t_to_o_id, link.request.t_to_o_id) << "R-CON-16: the producer's";
        }
    }
}

TEST(IoData, R_CON_33_PointToPointConsumersGetTheirOwn) {
    IoSite site;
    IoPeer peer(site);
    IoPeer other(site, 0xC0A80202);
    (void)peer.must_open(io_open(1));
    (void)other.must_open(io_open(2, 254), {socket_item(enip::ItemType::sockaddr_t_to_o, 3000, 0x01020304)});
    auto slow = io_open(3, 254);
    slow.t_to_o_rpi = 20'000;
    (void)peer.must_open(slow, {socket_item(enip::ItemType::sockaddr_o_to_t, 4000)});
    const auto group = other.must_open(multicast(io_open(4, 254)));
    site.advance(20ms);
    std::map<std::pair<std::uint32_t, std::string>, unsigned> counts;
    for (const auto& each : site.take()) ++counts[{id_in(each.octets), enip::to_string(each.route.peer)}];
    const std::map<std::pair<std::uint32_t, std::string>, unsigned> expected{
        {{0x0A110001, "192.168.2.1:2222"}, 2},
        {{0x0A110002, "192.168.2.2:3000"}, 2},  // R-CPF-8: the address of the item does not count
        {{0x0A110003, "192.168.2.1:2222"}, 1},
        {{group.reply.t_to_o_id, "239.192.13.96:2222"}, 2}};
    EXPECT_EQ(counts, expected);
}

TEST(IoData, R_CPF_8_OurOwnPortIsToldToWhoSpeaksOfPorts) {
    using enip::ItemType;
    IoSite site;
    IoPeer peer(site);
    EXPECT_TRUE(peer.must_open(io_open(1)).items.empty());
    const auto asked = peer.must_open(io_open(2, 254), {socket_item(ItemType::sockaddr_t_to_o, 3000)});
    ASSERT_EQ(asked.items.size(), 1U);
    EXPECT_EQ(hex(asked.items[0].data), hex("0002 08AE 00000000 0000000000000000"));
    EXPECT_EQ(asked.items[0].type, ItemType::sockaddr_o_to_t);
    const auto both = peer.must_open(multicast(io_open(3, 254)), {socket_item(ItemType::sockaddr_o_to_t, 2222)});
    ASSERT_EQ(both.items.size(), 2U);
    EXPECT_EQ(hex(both.items[1].data), hex("0002 08AE EFC00D60 0000000000000000"));
    EXPECT_TRUE(peer.ask(request_of(io_open(1)), {socket_item(ItemType::sockaddr_t_to_o, 3000)}).items.empty())
        << "a refusal has none";
}

TEST(IoData, R_CPF_8_AnotherPortThanTheUsualOneIsToldToEverybody) {
    auto network = IoSite::in_subnet(24);
    network.state.io_port = 40'000;
    IoSite site(drive::Device(drive::xenax_models().front()), {}, network);
    for (const auto* reset : {"", "05 02 20 01 24 01 00", "05 02 20 01 24 01 01"}) {
        if (*reset != '\0') {
            IoPeer peer(site);
            EXPECT_EQ(peer.call(reset), hex("85 00 00 00"));
            site.advance(200ms);
        }
        IoPeer peer(site);
        const auto link = peer.must_open(io_open(1));
        const auto told = link.socket(enip::ItemType::sockaddr_o_to_t);
        ASSERT_TRUE(told) << "after " << reset;
        EXPECT_EQ(told->port, 40'000) << "after " << reset;
        site.take();
        site.advance(10ms);
        EXPECT_EQ(site.take().at(0).route.local.port, 40'000);
        (void)peer.close(link);
    }
}

// ----------------------------------------------------------------------------------------------- triggers and intervals

TEST(IoData, R_CON_50_ChangeOfStateSendsChangesAtOnceAndEachIntervalAtTheLatest) {
    for (const std::uint8_t trigger : std::array<std::uint8_t, 2>{1, 2}) {
        IoSite site;
        IoPeer peer(site);
        const auto link = peer.must_open(every(on_change(io_open(1), 20, trigger), 100'000));
        site.advance(2ms);  // the first, at most
        auto sent = site.take();
        ASSERT_EQ(sent.size(), 1U);
        const auto send_change = [&](int value) {
            set(site, "PositionActualValue", value);
            peer.send(o_to_t(link, static_cast<std::uint32_t>(value), 1, run, target_of(1)));  // something happens
            site.advance(0us);
        };
        site.advance(50ms);
        EXPECT_TRUE(site.take().empty());
        send_change(1);
        sent = site.take();
        ASSERT_EQ(sent.size(), 1U);
        EXPECT_EQ(sent[0].at, site.now) << "at once";
        EXPECT_EQ(count_in(sent[0].octets), 2);
        auto last = sent[0].at;
        site.advance(5ms);
        send_change(2);
        site.advance(2ms);
        send_change(3);
        EXPECT_TRUE(site.take().empty()) << "inhibited";
        site.advance(12'999us);
        EXPECT_TRUE(site.take().empty());
        site.advance(1us);
        sent = site.take();
        ASSERT_EQ(sent.size(), 1U) << "20 ms after the last one";
        EXPECT_EQ(sent[0].at, last + 20ms);
        EXPECT_EQ(count_in(sent[0].octets), 3);
        EXPECT_EQ(data_in(sent[0].octets).substr(12, 11), "03 00 00 00");
        last = sent[0].at;
        peer.send(o_to_t(link, 4, 1, run, target_of(1)));
        site.advance(99'999us);
        EXPECT_TRUE(site.take().empty()) << "nothing has changed";
        site.advance(1us);
        sent = site.take();
        ASSERT_EQ(sent.size(), 1U);
        EXPECT_EQ(sent[0].at, last + 100ms);
        EXPECT_EQ(count_in(sent[0].octets), 3) << "the same data";
    }
}

TEST(IoData, R_CON_51_WithoutASegmentAQuarterOfTheIntervalAndWithZeroNone) {
    struct Case {
        std::optional<unsigned> segment;
        microseconds least;
    };
    for (const auto& each : {Case{std::nullopt, 25ms}, Case{0, 0us}, Case{1, 1ms}, Case{100, 100ms}}) {
        IoSite site;
        IoPeer peer(site);
        const auto link = peer.must_open(every(on_change(io_open(1), each.segment), 100'000));
        site.advance(100ms);
        site.take();
        std::vector<enip::Time> times;
        for (int i = 1; i <= 2000; ++i) {
            set(site, "PositionActualValue", i);
            peer.send(o_to_t(link, static_cast<std::uint32_t>(i), 1, run, target_of(1)));
            site.advance(500us);
            for (const auto& sent : site.take()) times.push_back(sent.at);
        }
        ASSERT_GT(times.size(), 8U);
        microseconds shortest = 1h;
        for (std::size_t i = 1; i < times.size(); ++i) {
            shortest = std::min(shortest, std::chrono::duration_cast<microseconds>(times[i] - times[i - 1]));
        }
        EXPECT_EQ(shortest, std::max<microseconds>(each.least, 500us));
    }
}

// What changes by a message or an event is a change of state too.
TEST(IoData, R_CON_50_ChangesThatNoDatagramBrought) {
    IoSite site;
    IoPeer peer(site);
    (void)peer.must_open(every(on_change(io_open(1), 0), 100'000));
    site.advance(10ms);
    EXPECT_EQ(site.take().size(), 1U);
    EXPECT_EQ(peer.call("10 03 20 66 24 01 30 BF 01 00 00 00"), hex("90 00 00 00"));
    site.advance(0us);
    auto sent = site.take();
    ASSERT_EQ(sent.size(), 1U) << "written by an explicit message";
    EXPECT_EQ(sent[0].at, site.now);
    EXPECT_EQ(count_in(sent[0].octets), 2);

    IoSite other(drive::Device(*drive::xenax_model("75v8s"), drive::Machine{}));
    IoPeer looker(other);
    (void)looker.must_open(every(on_change(io_open(1, 254), 0), 100'000));
    other.advance(10ms);
    EXPECT_EQ(other.take().size(), 1U);
    other.adapter.inject(drive::event::SetInput{3, true}, other.now);
    other.advance(0us);
    EXPECT_EQ(other.take().size(), 1U) << "an input";
}

TEST(IoData, R_CON_17_TheIntervalIsKeptForAMinuteWithoutDrift) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(every(io_open(1), 1000));
    std::mt19937 random(5);
    std::uint32_t sequence = 0;
    std::optional<enip::Time> first;
    std::uint64_t sent = 0;
    for (int ms = 0; ms < 60'000; ++ms) {
        if (ms % 2 == 0) {
            ++sequence;
            peer.send(o_to_t(link, sequence, static_cast<std::uint16_t>(sequence), run,
                             target_of(static_cast<std::uint32_t>(ms))));
        }
        const auto due = site.adapter.next_deadline();
        ASSERT_TRUE(due);
        // Somebody comes late each time, and sometimes almost too late.
        site.now = *due + microseconds(random() % 1000);
        site.tick();
        for (const auto& each : site.take()) {
            ++sent;
            ASSERT_EQ(sequence_in(each.octets), sent);
            if (!first) first = *due;
            ASSERT_EQ(*due, *first + (sent - 1) * 1ms) << "deadlines follow from the deadline before";
        }
    }
    EXPECT_EQ(sent, 60'000U);
    EXPECT_EQ(site.adapter.io().owner()->production->producer.counters().skipped, 0U);
    EXPECT_EQ(site.adapter.io().owner()->consumer.counters().accepted, 30'000U);
    EXPECT_EQ(site.value(target), 59'998);
}

TEST(IoData, R_CON_17_WhoeverComesLateSendsWhatWasMissedAndKeepsTheGrid) {
    IoSite site;
    IoPeer peer(site);
    (void)peer.must_open(every(io_open(1), 1000));
    const auto& producer = site.adapter.io().owner()->production->producer;
    const auto due = *site.adapter.next_deadline();
    site.now = due + 5500us;
    site.tick();
    const auto sent = site.take();
    ASSERT_EQ(sent.size(), 6U);
    for (std::size_t i = 0; i < sent.size(); ++i) {
        EXPECT_EQ(sequence_in(sent[i].octets), i + 1);
        EXPECT_EQ(count_in(sent[i].octets), 1) << "the same data";
    }
    EXPECT_EQ(site.adapter.next_deadline(), due + 6ms);
    EXPECT_EQ(producer.counters().skipped, 0U);
    site.now = due + 1006'500us;
    site.tick();
    EXPECT_LE(site.take().size(), 17U) << "no endless burst";
    EXPECT_EQ(site.adapter.next_deadline(), due + 1007ms);
    EXPECT_EQ(producer.counters().sent + producer.counters().skipped, 1007U) << "nothing is forgotten";
}

// ------------------------------------------------------------------------------------------------- what is told of them

TEST(IoData, R_CM_7_GetAndSearchConnectionData) {
    IoSite site;
    IoPeer peer(site);
    auto open = io_open(0x1234, 254);
    open.o_to_t_rpi = 20'000;
    open.timeout_multiplier = 3;
    (void)peer.must_open(io_open(1));
    const auto link = peer.must_open(open, {socket_item(enip::ItemType::sockaddr_t_to_o, 3000)});
    cip::Bytes id;
    cip::Writer(id).u32(link.reply.o_to_t_id);
    const auto data = "0200 0300 B80B AE08 3412 4D00 44332211 " + hex(id) + hex(id) +
                      "03 000000 204E0000 204E0000 3412110A 3412110A 03 000000 10270000 10270000";
    EXPECT_EQ(peer.call("56 02 20 06 24 01 02 00"), hex("D6 00 00 00" + data));
    EXPECT_EQ(peer.call("57 02 20 06 24 01 3412 4D00 44332211"), hex("D7 00 00 00" + data));
    for (const auto* missing : {"56 02 20 06 24 01 03 00", "56 02 20 06 24 01 00 00",
                                "57 02 20 06 24 01 3512 4D00 44332211", "57 02 20 06 24 01 3412 4E00 44332211"}) {
        EXPECT_EQ(peer.call(missing).substr(6), hex("05 00")) << missing;
    }
    EXPECT_EQ(peer.call("56 02 20 06 24 01 02"), hex("D6 00 13 00"));
    EXPECT_EQ(peer.call("56 02 20 06 24 01 02 00 00"), hex("D6 00 15 00"));
    EXPECT_EQ(peer.call("57 02 20 06 24 01 3412 4D00 443322"), hex("D7 00 13 00"));
    EXPECT_EQ(peer.call("57 02 20 06 24 01 3412 4D00 44332211 00"), hex("D7 00 15 00"));
    (void)peer.close(link);
    EXPECT_EQ(peer.call("56 02 20 06 24 01 02 00"), hex("D6 00 05 00"));
}

TEST(IoData, R_CM_8_GetConnectionOwner) {
    IoSite site;
    IoPeer peer(site);
    const auto none = hex("DA 00 00 00 00 00 00 00 0000 0000 00000000");
    const auto owner = hex("DA 00 00 00 01 00 00 00 0100 4D00 44332211");
    const std::string of_101 = "5A 02 20 06 24 01 00 02 20 04 2C 65";
    EXPECT_EQ(peer.call(of_101), none);
    const auto link = peer.must_open(io_open(1));
    (void)peer.must_open(io_open(2, 254));
    (void)peer.must_open(io_open(3, 254, 105));
    EXPECT_EQ(peer.call(of_101), owner);
    EXPECT_EQ(peer.call("5A 02 20 06 24 01 00 02 20 04 24 65"), owner);
    EXPECT_EQ(peer.call("5A 02 20 06 24 01 00 02 20 04 2C 66"), none);
    EXPECT_EQ(peer.call("5A 02 20 06 24 01 00 02 20 04 2C FE"), hex("DA 00 00 00 02 00 00 00 0000 0000 00000000"));
    EXPECT_EQ(peer.call("5A 02 20 06 24 01 00 02 20 04 2C 63"), hex("DA 00 05 00"));
    EXPECT_EQ(peer.call("5A 02 20 06 24 01 00 00"), hex("DA 00 04 00"));
    EXPECT_EQ(peer.call("5A 02 20 06 24 01 00"), hex("DA 00 13 00"));
    EXPECT_EQ(peer.call("5A 02 20 06 24 01 00 02 20 04 2C"), hex("DA 00 13 00"));
    EXPECT_EQ(peer.call(of_101 + "00"), hex("DA 00 15 00"));
    (void)peer.close(link);
    EXPECT_EQ(peer.call(of_101), none);
}

TEST(IoData, R_ID_4_TheStatusWordOfTheIdentity) {
    IoSite site;
    IoPeer peer(site);
    const auto status = [&] { return peer.call("0E 03 20 01 24 01 30 05"); };
    const auto word = [](const char* text) { return hex(std::string("8E 00 00 00") + text); };
    EXPECT_EQ(status(), word("3000"));
    const auto link = peer.must_open(io_open(1));
    EXPECT_EQ(status(), word("7100"));
    peer.send(o_to_t(link, 1, 1, idle, target_of(1)));
    EXPECT_EQ(status(), word("7100"));
    peer.send(o_to_t(link, 2, 2, run, target_of(1)));
    EXPECT_EQ(status(), word("6100"));
    const auto looker = peer.must_open(io_open(2, 254));
    peer.send(heartbeat(looker, 1));
    EXPECT_EQ(status(), word("6100"));
    peer.send(o_to_t(link, 3, 3, idle, target_of(1)));
    EXPECT_EQ(status(), word("7100"));
    (void)peer.close(link);
    EXPECT_EQ(status(), word("7000"));
    peer.send(heartbeat(looker, 2));
    site.advance(40ms);
    EXPECT_EQ(status(), word("2000"));
    const auto again = peer.must_open(io_open(1));
    EXPECT_EQ(status(), word("7100")) << "until a new connection opens";
    peer.send(o_to_t(again, 1, 1, run, target_of(1)));
    EXPECT_EQ(status(), word("6100"));
    const auto other = peer.must_open(io_open(3, 254));
    peer.send(heartbeat(other, 1));
    for (std::uint32_t i = 2; i < 7; ++i) {
        site.advance(10ms);
        peer.send(o_to_t(again, i, 1, run, target_of(1)));
    }
    EXPECT_EQ(site.adapter.io().size(), 1U);
    EXPECT_EQ(status(), word("6100")) << "6 comes before 2";
    peer.send(o_to_t(again, 7, 1, idle, target_of(1)));
    EXPECT_EQ(status(), word("2100")) << "2 comes before 7";
    (void)peer.close(again);
    EXPECT_EQ(status(), word("2000"));
}

TEST(IoData, R_ID_8_NoResetWhileTheOwnerRuns) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.send(o_to_t(link, 1, 1, run, target_of(1)));
    for (const auto* reset : {"05 02 20 01 24 01", "05 02 20 01 24 01 00", "05 02 20 01 24 01 01"}) {
        EXPECT_EQ(peer.call(reset), hex("85 00 10 00"));
    }
    site.advance(10ms);
    EXPECT_EQ(site.adapter.io().size(), 1U);
    peer.send(o_to_t(link, 2, 2, idle, target_of(1)));
    EXPECT_EQ(peer.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
}

TEST(IoData, R_ID_8_ARestartEndsAllOfThem) {
    for (const bool power_cycle : {false, true}) {
        IoSite site;
        IoPeer peer(site);
        const auto owner = peer.must_open(multicast(io_open(1)));
        (void)peer.must_open(multicast(io_open(2, 254)));
        (void)peer.must_open(multicast(io_open(3, 255)));
        (void)peer.must_open(on_change(io_open(4, 254)));
        site.advance(10ms);
        if (power_cycle) {
            peer.send(o_to_t(owner, 1, 1, run, target_of(1)));
            site.adapter.inject(drive::event::PowerCycle{}, site.now);
        } else {
            EXPECT_EQ(peer.call("05 02 20 01 24 01 00"), hex("85 00 00 00"));
            site.advance(100ms);
        }
        EXPECT_EQ(site.adapter.io().size(), 0U);
        site.take();
        peer.send(o_to_t(owner, 2, 2, run, target_of(2)));
        EXPECT_NE(site.value(target), 2);
        site.advance(1s);
        EXPECT_TRUE(site.take().empty());
        IoPeer again(site);
        EXPECT_EQ(again.call("0E 03 20 01 24 01 30 05"), hex("8E 00 00 00 3000"));
        const auto next = again.must_open(multicast(io_open(1)));
        EXPECT_NE(next.reply.o_to_t_id >> 16, owner.reply.o_to_t_id >> 16) << "R-CON-16: another incarnation";
        peer.send(o_to_t(next, 1, 1, run, target_of(3)));
        EXPECT_EQ(site.value(target), 3);
    }
}

TEST(IoData, R_ENC_25_ConnectionsLiveOnWithoutTheSession) {
    IoSite site;
    IoPeer peer(site);
    const auto link = peer.must_open(io_open(1));
    peer.disconnect();
    for (std::uint32_t i = 1; i <= 1000; ++i) {
        peer.send(o_to_t(link, i, static_cast<std::uint16_t>(i), run, target_of(i)));
        site.advance(10ms);
    }
    EXPECT_EQ(site.value(target), 1000);
    EXPECT_EQ(site.take().size(), 1000U);
    EXPECT_EQ(site.adapter.tcp_connections(), 0U);
    site.advance(30ms);
    EXPECT_EQ(site.adapter.io().size(), 0U);
}

// -------------------------------------------------------------------------------------------------------- all together

/// What the rules say is open, written a second time and without the code that is tested.
class Model {
public:
    struct Entry {
        Link link;
        bool multicast = false;
        bool listens = false;
        enip::Time deadline{};
        std::uint32_t sequence = 0;
        unsigned peer = 0;
    };
    std::map<std::uint16_t, Entry> open;  // by serial

    bool owned() const {
        return std::ranges::any_of(open, [](const auto& each) { return each.second.link.request.o_to_t.size > 2; });
    }
    bool heard(std::uint16_t size) const {
        return std::ranges::any_of(open, [&](const auto& each) {
            return each.second.multicast && !each.second.listens && each.second.link.request.t_to_o.size == size;
        });
    }
    std::size_t lookers() const {
        return static_cast<std::size_t>(
            std::ranges::count_if(open, [](const auto& each) { return each.second.link.request.o_to_t.size == 2; }));
    }
    void drop_listeners() {
        std::erase_if(open, [this](const auto& each) {
            return each.second.listens && !heard(each.second.link.request.t_to_o.size);
        });
    }
    void expire(enip::Time now) {
        // One after another by their time, so that what goes with somebody goes then.
        std::erase_if(open, [&](const auto& each) { return each.second.deadline <= now; });
        drop_listeners();
    }
};

TEST(IoData, ManyConnectionsInAnyOrderNeverTouchEachOther) {
    for (const unsigned seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
        std::mt19937 random(seed);
        const auto choose = [&](unsigned count) { return static_cast<unsigned>(random() % count); };
        IoSite site;
        std::array<IoPeer, 3> peers{IoPeer(site), IoPeer(site, 0xC0A80202), IoPeer(site, 0xC0A80203)};
        Model model;
        struct Stream {
            std::uint32_t sequence = 0;
            std::uint16_t count = 0;
            std::string data;
        };
        std::map<std::pair<std::uint32_t, std::string>, Stream> streams;
        std::map<std::uint32_t, std::uint16_t> used;  // our ids, and whose they are
        std::int64_t applied = 0;
        set(site, target, 0);
        unsigned opened = 0;
        unsigned refused = 0;
        for (int step = 0; step < 4000; ++step) {
            const auto serial = static_cast<std::uint16_t>(1 + choose(14));
            const auto found = model.open.find(serial);
            switch (choose(6)) {
                case 0: {
                    const auto& points = all_points[choose(all_points.size())];
                    auto open = io_open(serial, points.o_to_t, points.t_to_o);
                    if (choose(2) == 0) open = multicast(open);
                    const bool wants_multicast = open.t_to_o.type == ConnectionType::multicast;
                    const bool listens = points.o_to_t == 255;
                    const bool owns = points.o_to_t_size > 2;
                    const bool legal = found == model.open.end() && !(owns && model.owned()) &&
                                       (!listens || (wants_multicast && model.heard(points.t_to_o_size))) &&
                                       (owns || model.lookers() < 8);
                    const auto peer = choose(3);
                    const auto link = peers[peer].open(open);
                    ASSERT_EQ(link.has_value(), legal) << "step " << step << ": " << site.last_warning();
                    ++(legal ? opened : refused);
                    if (!link) break;
                    model.open[serial] = {*link,          wants_multicast,         listens,
                                          site.now + 10s, choose(2) * 0xFFFFFFF0U, peer};
                    ASSERT_TRUE(used.emplace(link->reply.o_to_t_id, serial).second) << "an id comes again";
                    break;
                }
                case 1: {
                    if (found == model.open.end()) break;
                    const auto entry = found->second;
                    ASSERT_EQ(peers[entry.peer].close(entry.link), closed(entry.link.request.triad));
                    model.open.erase(found);
                    model.drop_listeners();
                    break;
                }
                default: {
                    if (found == model.open.end()) break;
                    auto& entry = found->second;
                    if (entry.link.request.o_to_t.size == 2) {
                        peers[entry.peer].send(heartbeat(entry.link, ++entry.sequence));
                    } else {
                        auto data = cip::Bytes(entry.link.request.o_to_t.size - 6U);
                        ++applied;
                        for (std::size_t i = 0; i < 4; ++i) data[i] = static_cast<std::uint8_t>(applied >> (8 * i));
                        ++entry.sequence;
                        peers[entry.peer].send(
                            o_to_t(entry.link, entry.sequence, static_cast<std::uint16_t>(step), run, data));
                        ASSERT_EQ(site.value(target), applied) << "step " << step;
                    }
                    entry.deadline = site.now + 40ms;
                    set(site, "PositionActualValue", choose(4));
                    break;
                }
            }
            site.advance(microseconds(choose(3) == 0 ? choose(12'000) : choose(800)));
            model.expire(site.now);
            std::vector<std::uint16_t> expected;
            for (const auto& [number, entry] : model.open) expected.push_back(number);
            std::vector<std::uint16_t> actual;
            for (const auto& each : site.adapter.io().all()) actual.push_back(each->request.triad.serial_number);
            std::ranges::sort(actual);
            ASSERT_EQ(actual, expected) << "seed " << seed << ", step " << step;
            for (const auto& each : site.take()) {
                auto& stream = streams[{id_in(each.octets), enip::to_string(each.route.peer)}];
                const auto sequence = sequence_in(each.octets);
                const bool starts = sequence == 1;
                ASSERT_TRUE(starts || sequence == stream.sequence + 1) << sequence;
                ASSERT_TRUE(starts || (count_in(each.octets) != stream.count) == (data_in(each.octets) != stream.data))
                    << "new data under an old count, or the other way round";
                stream = {sequence, count_in(each.octets), data_in(each.octets)};
            }
        }
        EXPECT_GT(opened, 100U);
        EXPECT_GT(refused, 50U);
        EXPECT_GT(site.counter(Counter::connection_timeouts), 20U);
        site.advance(20s);
        EXPECT_EQ(site.adapter.io().size(), 0U);
        site.take();
        site.advance(10s);
        EXPECT_TRUE(site.take().empty());
        for (auto& peer : peers) peer.disconnect();
        EXPECT_EQ(site.adapter.next_deadline(), std::nullopt) << "nothing is left that wants time";
    }
}

}  // namespace
}  // namespace servobus::test
