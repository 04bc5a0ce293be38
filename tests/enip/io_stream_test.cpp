// Both ends of one direction of a class 1 connection, in virtual time.
#include "enip/io_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "cip/wire.hpp"
#include "tests/support/golden.hpp"
#include "tests/support/octets.hpp"

namespace servobus::enip {
namespace {

using namespace std::chrono_literals;
using cip::RealTimeFormat;
using test::hex;
using test::octets;
using Verdict = IoConsumer::Verdict;

constexpr Time start{1000s};
constexpr auto image_101 = "400D0300 50C30000 40420F00 14000000 1F00";

IoPacket packet(std::uint32_t sequence, const cip::Bytes& data) { return {0x56A00001, sequence, data}; }

// ------------------------------------------------------------------------------------------------------------ consumer

/// Sends itself datagrams: sequence number, sequence count, and what stands behind it.
class Consumer {
public:
    explicit Consumer(RealTimeFormat format = RealTimeFormat::modeless, std::size_t size = 4,
                      std::chrono::microseconds timeout = 40ms)
        : consumer({format, size, timeout}, start) {}

    IoConsumer::Arrival take(std::uint32_t sequence, std::uint16_t count, std::string_view rest = "0000",
                             Time now = start) {
        data_ = {static_cast<std::uint8_t>(count), static_cast<std::uint8_t>(count >> 8)};
        for (const auto octet : octets(rest)) data_.push_back(octet);
        return consumer.take(packet(sequence, data_), now);
    }
    Verdict verdict(std::uint32_t sequence, std::uint16_t count = 1) { return take(sequence, count).verdict; }

    IoConsumer consumer;

private:
    cip::Bytes data_;
};

TEST(IoConsumer, R_IO_5_the_first_datagram_is_accepted_whatever_its_number) {
    for (const std::uint32_t first : {0U, 1U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFFU}) {
        Consumer consumer;
        EXPECT_FALSE(consumer.consumer.alive());
        EXPECT_EQ(consumer.verdict(first), Verdict::fresh) << first;
        EXPECT_TRUE(consumer.consumer.alive());
        EXPECT_EQ(consumer.consumer.counters().lost, 0U);
    }
}

TEST(IoConsumer, R_IO_5_the_window_is_half_of_all_numbers) {
    for (const std::uint32_t last : {0U, 1U, 100U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFEU, 0xFFFFFFFFU}) {
        for (const std::uint32_t ahead : {1U, 2U, 1000U, 0x7FFFFFFFU}) {
            Consumer consumer;
            static_cast<void>(consumer.verdict(last));
            EXPECT_EQ(consumer.verdict(last + ahead), Verdict::repeated) << last << " + " << ahead;
            EXPECT_EQ(consumer.consumer.counters().lost, ahead - 1);
        }
        for (const std::uint32_t ahead : {0U, 0x80000000U, 0x80000001U, 0xFFFFFFFFU}) {
            Consumer consumer;
            static_cast<void>(consumer.verdict(last));
            EXPECT_EQ(consumer.verdict(last + ahead, 2), Verdict::stale) << last << " + " << ahead;
            EXPECT_EQ(consumer.consumer.counters().stale, 1U);
            EXPECT_EQ(consumer.consumer.counters().lost, 0U);
        }
    }
}

TEST(IoConsumer, R_IO_5_a_stale_datagram_changes_nothing) {
    Consumer consumer(RealTimeFormat::header32, 8);
    static_cast<void>(consumer.take(10, 1, "01000000 AAAA"));
    const auto stale = consumer.take(9, 2, "00000000 BBBB", start + 5ms);
    EXPECT_EQ(stale.verdict, Verdict::stale);
    EXPECT_FALSE(stale.run_ended);
    EXPECT_TRUE(stale.data.empty());
    EXPECT_TRUE(consumer.consumer.run());
    EXPECT_EQ(consumer.consumer.deadline(), start + 40ms) << "it does not keep the connection alive";
    EXPECT_EQ(consumer.take(11, 1, "01000000 AAAA").verdict, Verdict::repeated) << "nor is its count remembered";
}

TEST(IoConsumer, R_IO_5_the_count_alone_tells_what_is_new) {
    Consumer consumer;
    EXPECT_EQ(consumer.verdict(1, 0xFFFF), Verdict::fresh);
    EXPECT_EQ(consumer.verdict(2, 0xFFFF), Verdict::repeated);
    EXPECT_EQ(consumer.verdict(3, 0x0000), Verdict::fresh) << "it wraps";
    EXPECT_EQ(consumer.verdict(4, 0x0001), Verdict::fresh);
    EXPECT_EQ(consumer.verdict(5, 0xFFFF), Verdict::fresh) << "any other count is new, a lower one too";
    EXPECT_EQ(consumer.consumer.counters().accepted, 5U);
}

TEST(IoConsumer, R_IO_6_the_golden_run_idle_repeat_and_resume) {
    IoConsumer consumer({RealTimeFormat::header32, 24, 40ms}, start);
    const auto take = [&](const char* name) {
        return consumer.take(IoPacket::parse(test::find_golden_vector(name)->octets).value(), start);
    };
    const auto run = take("io_o2t_101_run");
    EXPECT_EQ(run.verdict, Verdict::fresh);
    EXPECT_TRUE(run.run && run.run_began && !run.run_ended);
    EXPECT_EQ(hex(run.data), hex(image_101));

    const auto idle = take("io_o2t_101_idle");
    EXPECT_EQ(idle.verdict, Verdict::fresh);
    EXPECT_TRUE(!idle.run && !idle.run_began && idle.run_ended);
    EXPECT_FALSE(consumer.run());

    const auto repeat = take("io_o2t_101_repeat");
    EXPECT_EQ(repeat.verdict, Verdict::repeated);
    EXPECT_TRUE(!repeat.run && !repeat.run_began && !repeat.run_ended) << "edges are told once";

    const auto resume = take("io_o2t_101_resume");
    EXPECT_EQ(resume.verdict, Verdict::repeated) << "the count is that of the idle datagram";
    EXPECT_TRUE(resume.run && resume.run_began && !resume.run_ended) << "and its data counts all the same";
    EXPECT_EQ(hex(resume.data), hex(image_101));
}

TEST(IoConsumer, R_IO_1_only_bit_0_of_the_header_means_run) {
    for (const auto* header : {"01000000", "03000000", "0D000000", "FFFFFFFF"}) {
        Consumer consumer(RealTimeFormat::header32, 8);
        EXPECT_TRUE(consumer.take(1, 1, std::string(header) + "AAAA").run) << header;
    }
    for (const auto* header : {"00000000", "02000000", "0C000000", "FEFFFFFF", "00000001"}) {
        Consumer consumer(RealTimeFormat::header32, 8);
        const auto arrival = consumer.take(1, 1, std::string(header) + "AAAA");
        EXPECT_FALSE(arrival.run) << header;
        EXPECT_FALSE(arrival.run_ended) << "it has never run";
    }
}

TEST(IoConsumer, R_CON_8_modeless_always_runs_and_a_heartbeat_has_no_data) {
    Consumer modeless;
    const auto first = modeless.take(1, 1, "BBAA");
    EXPECT_TRUE(first.run && first.run_began);
    EXPECT_EQ(hex(first.data), "BB AA");
    Consumer heartbeat(RealTimeFormat::heartbeat, 2);
    const auto beat = heartbeat.take(1, 1, "");
    EXPECT_EQ(beat.verdict, Verdict::fresh);
    EXPECT_TRUE(beat.data.empty());
    EXPECT_EQ(heartbeat.take(2, 1, "00").verdict, Verdict::wrong_size);
}

TEST(IoConsumer, R_CON_8_zero_length_is_idle_without_data) {
    Consumer consumer(RealTimeFormat::zero_length, 4);
    const auto run = consumer.take(1, 1, "BBAA");
    EXPECT_TRUE(run.run && run.run_began);
    const auto idle = consumer.take(2, 2, "");
    EXPECT_TRUE(!idle.run && idle.run_ended);
    EXPECT_TRUE(idle.data.empty());
    EXPECT_EQ(consumer.take(3, 2, "").verdict, Verdict::repeated);
    const auto again = consumer.take(4, 2, "BBAA");
    EXPECT_TRUE(again.run && again.run_began) << "R-IO-6";
    EXPECT_EQ(consumer.take(5, 3, "BB").verdict, Verdict::wrong_size);
    EXPECT_TRUE(consumer.consumer.run());
}

TEST(IoConsumer, R_IO_8_another_size_changes_nothing) {
    IoConsumer consumer({RealTimeFormat::header32, 24, 40ms}, start);
    cip::Bytes data(40, 1);
    for (std::size_t size = 0; size <= data.size(); ++size) {
        if (size == 24) continue;
        const auto arrival = consumer.take({1, 1, cip::ByteView(data).first(size)}, start + 5ms);
        EXPECT_EQ(arrival.verdict, Verdict::wrong_size) << size;
        EXPECT_TRUE(arrival.data.empty() && !arrival.run_began);
    }
    EXPECT_FALSE(consumer.alive());
    EXPECT_EQ(consumer.counters().wrong_size, 40U);
    EXPECT_EQ(consumer.deadline(), start + 10s);
}

TEST(IoConsumer, R_CON_19_the_first_datagram_has_10_s_at_least) {
    EXPECT_EQ(IoConsumer({RealTimeFormat::modeless, 4, 4ms}, start).deadline(), start + 10s);
    EXPECT_EQ(IoConsumer({RealTimeFormat::modeless, 4, 9'999ms}, start).deadline(), start + 10s);
    EXPECT_EQ(IoConsumer({RealTimeFormat::modeless, 4, 12s}, start).deadline(), start + 12s);
}

TEST(IoConsumer, R_CON_20_every_valid_datagram_restarts_the_watchdog) {
    Consumer consumer(RealTimeFormat::header32, 8, 4ms);
    static_cast<void>(consumer.take(1, 1, "01000000 AAAA", start + 9'999ms));
    EXPECT_EQ(consumer.consumer.deadline(), start + 9'999ms + 4ms) << "the 10 s are over with the first";
    static_cast<void>(consumer.take(2, 1, "01000000 AAAA", start + 10'001ms));
    EXPECT_EQ(consumer.consumer.deadline(), start + 10'005ms) << "new data or not";
    static_cast<void>(consumer.take(3, 2, "00000000 AAAA", start + 10'003ms));
    EXPECT_EQ(consumer.consumer.deadline(), start + 10'007ms) << "run or idle";
}

TEST(IoConsumer, R_CON_6_timeouts_of_all_multipliers) {
    EXPECT_EQ(connection_timeout(1ms, 0), 4ms);
    EXPECT_EQ(connection_timeout(1ms, 1), 8ms);
    EXPECT_EQ(connection_timeout(1ms, 7), 512ms);
    EXPECT_EQ(connection_timeout(3'200ms, 7), 1'638'400ms) << "it does not overflow";
}

// ------------------------------------------------------------------------------------------------------------ producer

IoProducer::Settings settings(std::chrono::microseconds interval = 10ms, Trigger trigger = Trigger::cyclic,
                              std::chrono::microseconds inhibit = 0us, RealTimeFormat format = RealTimeFormat::modeless,
                              std::size_t data_octets = 2) {
    return {.connection_id = 0x56A00001,
            .format = format,
            .data_octets = data_octets,
            .interval = interval,
            .trigger = trigger,
            .inhibit = inhibit};
}

/// A producer with the datagrams that it has made.
class Producer {
public:
    explicit Producer(IoProducer::Settings chosen = settings()) : producer(std::move(chosen), start) {}

    std::string produce(std::string_view data, Time now, bool run = true) {
        queue.clear();
        producer.produce(octets(data), run, now, queue);
        EXPECT_EQ(queue.entries().size(), 1U);
        return hex(queue.octets(queue.entries().front()));
    }
    std::uint16_t count() const {
        const auto octets = queue.octets(queue.entries().front());
        return static_cast<std::uint16_t>(octets[18] | octets[19] << 8);
    }

    IoProducer producer;
    IoQueue queue;
};

TEST(IoProducer, R_IO_1_writes_the_golden_datagrams) {
    Producer producer(settings(10ms, Trigger::cyclic, 0us, RealTimeFormat::header32, 18));
    const auto golden = [](const char* name) { return hex(test::find_golden_vector(name)->octets); };
    EXPECT_EQ(producer.produce(image_101, start), golden("io_o2t_101_run"));
    EXPECT_EQ(producer.produce(image_101, start + 10ms, false), golden("io_o2t_101_idle"));
    EXPECT_EQ(producer.produce(image_101, start + 20ms, false), golden("io_o2t_101_repeat"));
}

TEST(IoProducer, R_IO_2_writes_the_golden_input_datagrams) {
    for (const auto& [name, head] : {std::pair{"io_t2o_100", 20U},
                                     {"io_t2o_100_p2p", 20U},
                                     {"io_t2o_105", 20U},
                                     {"io_t2o_113", 20U},
                                     {"io_o2t_heartbeat", 20U}}) {
        const auto& golden = test::find_golden_vector(name)->octets;
        const auto data = cip::ByteView(golden).subspan(head);
        const bool heartbeat = data.empty();
        auto chosen = settings(10ms, Trigger::cyclic, 0us,
                               heartbeat ? RealTimeFormat::heartbeat : RealTimeFormat::modeless, data.size());
        chosen.connection_id = IoPacket::parse(golden)->connection_id;
        Producer producer(chosen);
        EXPECT_EQ(producer.produce(hex(data), start), hex(golden)) << name;
    }
}

TEST(IoProducer, R_CON_8_zero_length_sends_nothing_but_the_count_in_idle) {
    Producer producer(settings(10ms, Trigger::cyclic, 0us, RealTimeFormat::zero_length));
    EXPECT_EQ(producer.produce("BBAA", start), hex("0200 0280 0800 0100A056 01000000 B100 0400 0100 BBAA"));
    EXPECT_EQ(producer.produce("BBAA", start + 10ms, false), hex("0200 0280 0800 0100A056 02000000 B100 0200 0200"));
    EXPECT_EQ(producer.produce("BBAA", start + 20ms, true),
              hex("0200 0280 0800 0100A056 03000000 B100 0400 0300 BBAA"));
}

TEST(IoProducer, R_IO_5_the_number_rises_with_each_datagram_and_the_count_with_new_data) {
    Producer producer;
    EXPECT_EQ(producer.produce("0000", start), hex("0200 0280 0800 0100A056 01000000 B100 0400 0100 0000"));
    EXPECT_EQ(producer.produce("0000", start), hex("0200 0280 0800 0100A056 02000000 B100 0400 0100 0000"));
    EXPECT_EQ(producer.produce("0001", start), hex("0200 0280 0800 0100A056 03000000 B100 0400 0200 0001"));
    EXPECT_EQ(producer.produce("0000", start), hex("0200 0280 0800 0100A056 04000000 B100 0400 0300 0000"));
}

TEST(IoProducer, R_IO_5_the_count_wraps) {
    Producer producer;
    auto now = start;
    for (int i = 0; i < 0x10000; ++i) {
        static_cast<void>(producer.produce(i % 2 == 0 ? "0000" : "0001", now));
        now += 10ms;
    }
    EXPECT_EQ(producer.count(), 0U);
    static_cast<void>(producer.produce("0000", now));
    EXPECT_EQ(producer.count(), 1U);
    EXPECT_EQ(producer.producer.counters().sent, 0x10001U);
}

// A timer that comes late by up to nine tenths of an interval: what is due stays on the grid of the first deadline.
TEST(IoProducer, DeadlinesDoNotDrift) {
    std::mt19937 random(1);
    std::uniform_int_distribution<int> late(0, 899);
    Producer producer(settings(1ms));
    for (std::int64_t i = 0; i < 10'000; ++i) {
        EXPECT_EQ(producer.producer.deadline(), start + i * 1ms);
        static_cast<void>(
            producer.produce("0000", producer.producer.deadline() + std::chrono::microseconds(late(random))));
    }
    EXPECT_EQ(producer.producer.counters().skipped, 0U);
    EXPECT_EQ(producer.producer.counters().sent, 10'000U);
}

TEST(IoProducer, WhoComesLateSendsWhatWasMissed) {
    Producer producer(settings(10ms));
    static_cast<void>(producer.produce("0000", start + 35ms));  // due at 0, 10, 20 and 30
    for (const auto due : {10ms, 20ms, 30ms}) {
        EXPECT_EQ(producer.producer.deadline(), start + due) << "it is due at once, and the grid stays";
        static_cast<void>(producer.produce("0000", start + 35ms));
    }
    EXPECT_EQ(producer.producer.deadline(), start + 40ms);
    EXPECT_EQ(producer.producer.counters().skipped, 0U);
}

TEST(IoProducer, IntervalsThatHavePassedLongAgoAreLeftOut) {
    Producer producer(settings(10ms));
    static_cast<void>(producer.produce("0000", start + 169ms));  // 15.9 intervals after the next one
    EXPECT_EQ(producer.producer.deadline(), start + 10ms);
    EXPECT_EQ(producer.producer.counters().skipped, 0U);
    static_cast<void>(producer.produce("0000", start + 180ms));  // 16 after the next one
    EXPECT_EQ(producer.producer.deadline(), start + 190ms) << "no burst, and the grid stays";
    EXPECT_EQ(producer.producer.counters().skipped, 17U);
}

TEST(IoProducer, R_CON_50_a_change_is_sent_at_once_and_begins_a_new_interval) {
    Producer producer(settings(10ms, Trigger::change_of_state));
    producer.producer.note(octets("0001"), start);
    EXPECT_EQ(producer.producer.deadline(), start) << "the first one is due anyway";
    static_cast<void>(producer.produce("0000", start));
    producer.producer.note(octets("0000"), start + 3ms);
    EXPECT_EQ(producer.producer.deadline(), start + 10ms) << "nothing has changed";
    producer.producer.note(octets("0001"), start + 4ms);
    EXPECT_EQ(producer.producer.deadline(), start + 4ms);
    static_cast<void>(producer.produce("0001", start + 4ms));
    EXPECT_EQ(producer.producer.deadline(), start + 14ms);
    static_cast<void>(producer.produce("0001", start + 14ms));
    EXPECT_EQ(producer.producer.deadline(), start + 24ms) << "and every interval at the latest";
}

TEST(IoProducer, R_CON_51_changes_keep_the_inhibit_time_apart) {
    for (const auto trigger : {Trigger::change_of_state, Trigger::application}) {
        Producer producer(settings(10ms, trigger, 3ms));
        static_cast<void>(producer.produce("0000", start));
        producer.producer.note(octets("0001"), start + 1ms);
        EXPECT_EQ(producer.producer.deadline(), start + 3ms);
        producer.producer.note(octets("0002"), start + 2ms);
        EXPECT_EQ(producer.producer.deadline(), start + 3ms) << "the newest data goes with it";
        static_cast<void>(producer.produce("0002", start + 3ms));
        producer.producer.note(octets("0003"), start + 9ms);
        EXPECT_EQ(producer.producer.deadline(), start + 9ms) << "it is over";
    }
}

TEST(IoProducer, R_CON_51_a_change_that_waits_does_not_delay_the_interval) {
    Producer producer(settings(10ms, Trigger::change_of_state, 10ms));
    static_cast<void>(producer.produce("0000", start));
    producer.producer.note(octets("0001"), start + 9ms);
    EXPECT_EQ(producer.producer.deadline(), start + 10ms);
}

TEST(IoProducer, R_CON_50_cyclic_takes_no_notice_of_changes) {
    Producer producer;
    static_cast<void>(producer.produce("0000", start));
    producer.producer.note(octets("0001"), start + 1ms);
    EXPECT_EQ(producer.producer.deadline(), start + 10ms);
}

TEST(IoProducer, FirstDeadlinesFallOnOneGrid) {
    for (const auto offset : {0us, 1us, 249us, 250us, 999us, 123'456us}) {
        for (const std::chrono::microseconds interval :
             {std::chrono::microseconds(1ms), std::chrono::microseconds(3'200ms)}) {
            const auto first = first_deadline(start + offset, interval);
            EXPECT_GT(first, start + offset);
            EXPECT_LE(first, start + offset + 250us);
            EXPECT_EQ(first.time_since_epoch() % std::chrono::nanoseconds(250us), 0ns);
        }
    }
    EXPECT_LE(first_deadline(start + 90us, 100us), start + 190us) << "at most an interval later";
}

TEST(IoProducer, WholeMillisecondsAreDueTogether) {
    for (const auto offset : {0us, 1us, 250us, 999us, 123'456us}) {
        for (const auto phase : {0us, 250us, 750us}) {
            const auto first = first_shared_deadline(start + offset, 10ms, phase);
            EXPECT_GT(first, start + offset);
            EXPECT_LE(first, start + offset + 1ms);
            EXPECT_EQ(first.time_since_epoch() % std::chrono::nanoseconds(1ms), std::chrono::nanoseconds(phase));
        }
        EXPECT_EQ(first_shared_deadline(start + offset, 1500us, 750us), first_deadline(start + offset, 1500us));
    }
}

// ----------------------------------------------------------------------------------------------------------- both ends

struct Wire {
    RealTimeFormat format;
    Trigger trigger;
    unsigned seed;
};
void PrintTo(const Wire& wire, std::ostream* out) { *out << cip::name(wire.format) << ", seed " << wire.seed; }

class IoStream : public testing::TestWithParam<Wire> {};

// Random data, modes and losses: what the consumer is told to apply is always what the producer had last, and what it
// is told to leave alone it has. That is: new data never goes out under an old count.
TEST_P(IoStream, WhatIsNotFreshIsKnown) {
    const auto& [format, trigger, seed] = GetParam();
    std::mt19937 random(seed);
    const auto chance = [&](unsigned percent) { return random() % 100 < percent; };
    const std::size_t data_octets = 3;
    const auto size = cip::connection_size(format, data_octets);
    IoProducer producer(settings(10ms, trigger, 2ms, format, data_octets), start);
    IoConsumer consumer({format, size, 40ms}, start);
    IoQueue queue;
    cip::Bytes data(data_octets);
    cip::Bytes applied;
    bool run = true;
    auto now = start;
    std::uint64_t dropped = 0;
    std::uint64_t fresh = 0;
    bool first_arrived = false;
    for (int i = 0; i < 20'000; ++i) {
        now += std::chrono::microseconds(random() % 3'000);
        if (chance(30)) data[random() % data_octets] = static_cast<std::uint8_t>(random() % 3);
        if (chance(5)) run = !run;
        producer.note(data, now);
        if (now < producer.deadline()) continue;
        queue.clear();
        producer.produce(data, run, now, queue);
        ASSERT_GT(producer.deadline(), now);
        if (chance(10)) {
            dropped += first_arrived ? 1 : 0;
            continue;
        }
        first_arrived = true;
        const auto arrived = IoPacket::parse(queue.octets(queue.entries().front()));
        ASSERT_TRUE(arrived);
        const auto arrival = consumer.take(*arrived, now);
        ASSERT_TRUE(arrival.verdict == Verdict::fresh || arrival.verdict == Verdict::repeated);
        ASSERT_EQ(arrival.run, run || format == RealTimeFormat::modeless);
        if (!arrival.run) continue;
        if (arrival.verdict == Verdict::fresh || arrival.run_began) {
            applied.assign(arrival.data.begin(), arrival.data.end());
            ++fresh;
        }
        ASSERT_EQ(hex(applied), hex(data)) << i;
    }
    EXPECT_GE(dropped, consumer.counters().lost) << "the last ones are not missed yet";
    EXPECT_LE(dropped, consumer.counters().lost + 20);
    EXPECT_EQ(consumer.counters().stale, 0U);
    EXPECT_GT(fresh, 100U);
    EXPECT_LT(fresh, consumer.counters().accepted) << "something has to have been repeated";
}

INSTANTIATE_TEST_SUITE_P(Random, IoStream,
                         testing::Values(Wire{RealTimeFormat::modeless, Trigger::cyclic, 1},
                                         Wire{RealTimeFormat::modeless, Trigger::change_of_state, 2},
                                         Wire{RealTimeFormat::header32, Trigger::cyclic, 3},
                                         Wire{RealTimeFormat::header32, Trigger::application, 4},
                                         Wire{RealTimeFormat::zero_length, Trigger::cyclic, 5},
                                         Wire{RealTimeFormat::zero_length, Trigger::change_of_state, 6}));

}  // namespace
}  // namespace servobus::enip
