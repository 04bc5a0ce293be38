// What the lines do to datagrams and streams.
#include "tests/sim/wire.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace servobus::sim {
namespace {

using namespace std::chrono_literals;

class Listener final : public Host {
public:
    [[nodiscard]] bool is_up() const override { return up; }
    void on_packet(const Packet& packet) override { numbers.push_back(packet.octets.front()); }
    [[nodiscard]] bool listens() const override { return accepts; }
    void on_accepted(StreamId id, enip::Endpoint, enip::Endpoint) override { accepted = id; }
    void on_connected(StreamId, bool stands) override { connected = stands; }
    void on_octets(StreamId, cip::ByteView octets) override {
        stream.insert(stream.end(), octets.begin(), octets.end());
        ++pieces;
    }
    void on_end(StreamId) override { ++ends; }

    bool up = true;
    bool accepts = true;
    std::vector<std::uint8_t> numbers;
    std::optional<StreamId> accepted;
    std::optional<bool> connected;
    cip::Bytes stream;
    int pieces = 0;
    int ends = 0;
};

class Line : public testing::Test {
protected:
    Line() {
        wire.attach(End::node, 0, node);
        wire.attach(End::drive, 0, drive);
    }
    static Scenario pair() {
        Scenario scenario;
        scenario.seed = 5;
        scenario.drives.resize(1);
        return scenario;
    }
    void faults(const Faults& all) { wire.set_faults(0, 0, Action::Way::both, all); }
    /// 200 datagrams, one every millisecond.
    std::vector<std::uint8_t> send_many() {
        for (int i = 0; i < 200; ++i) {
            queue.after(i * 1ms, [this, i] { send(static_cast<std::uint8_t>(i)); });
        }
        run();
        return drive.numbers;
    }
    void send(std::uint8_t number) { wire.send(0, 0, End::drive, {}, {}, cip::Bytes{number}); }
    void run(Time::duration time = 1h) {
        const auto end = queue.now() + time;
        while (!queue.empty() && queue.next() <= end) queue.run_next();
    }
    StreamId connect() {
        const auto id = wire.connect(0, 0, {}, {});
        run(1s);
        return id;
    }

    Scenario scenario = pair();
    EventQueue queue;
    Wire wire{queue, scenario};
    Listener node;
    Listener drive;
};

TEST_F(Line, AsNewDeliversAllInOrder) {
    std::vector<std::uint8_t> all(200);
    std::iota(all.begin(), all.end(), std::uint8_t{0});
    EXPECT_EQ(send_many(), all);
}

TEST_F(Line, Loses) {
    faults({.loss = 0.3});
    EXPECT_NEAR(static_cast<double>(send_many().size()), 140, 25);
    EXPECT_EQ(wire.counters().lost + drive.numbers.size(), 200U);
}

TEST_F(Line, Doubles) {
    faults({.duplicate = 0.3});
    const auto count = send_many().size();
    EXPECT_EQ(count, 200 + wire.counters().duplicated);
    EXPECT_GT(wire.counters().duplicated, 30U);
}

TEST_F(Line, LetsLaterOnesOvertake) {
    faults({.reorder = 0.3});
    auto numbers = send_many();
    EXPECT_EQ(numbers.size(), 200U);
    EXPECT_FALSE(std::ranges::is_sorted(numbers));
    std::ranges::sort(numbers);
    EXPECT_EQ(std::ranges::adjacent_find(numbers), numbers.end());
}

TEST_F(Line, OneDirectionIsNotTheOther) {
    wire.set_faults(0, 0, Action::Way::to_node, {.loss = 1});
    EXPECT_EQ(send_many().size(), 200U);
}

TEST_F(Line, CutCarriesNothingAndThenAsBefore) {
    wire.cut(0, 0, Action::Way::both, queue.now() + 100ms);
    const auto numbers = send_many();
    ASSERT_EQ(numbers.size(), 100U);
    EXPECT_EQ(numbers.front(), 100);
}

TEST_F(Line, WhatIsOnItsWayWhenTheLineIsCutIsLost) {
    faults({.delay = 5ms});
    send(1);
    run(1ms);
    wire.cut(0, 0, Action::Way::both, queue.now() + 10ms);
    run(1s);
    EXPECT_TRUE(drive.numbers.empty());
}

TEST_F(Line, StreamsStayWholeWhateverHappens) {
    faults({.loss = 0.2, .duplicate = 0.5, .reorder = 0.5, .jitter = 20ms});
    const auto id = connect();
    ASSERT_EQ(node.connected, true);
    cip::Bytes sent;
    for (int i = 0; i < 100; ++i) {
        const cip::Bytes part(97, static_cast<std::uint8_t>(i));
        wire.write(id, End::node, part);
        sent.insert(sent.end(), part.begin(), part.end());
    }
    wire.cut(0, 0, Action::Way::to_drive, queue.now() + 3s);
    wire.close(id, End::node);
    run();
    EXPECT_EQ(drive.stream, sent);
    EXPECT_GT(drive.pieces, 100) << "cut into pieces";
    EXPECT_EQ(drive.ends, 1);
    wire.close(id, End::drive);
    run();
    EXPECT_EQ(node.ends, 0) << "it has closed itself";
    EXPECT_EQ(wire.streams(), 0U);
}

TEST_F(Line, NobodyListens) {
    drive.accepts = false;
    connect();
    EXPECT_EQ(node.connected, false);
    EXPECT_EQ(wire.streams(), 0U);
}

TEST_F(Line, AMachineWithoutPowerSaysNothing) {
    drive.up = false;
    const auto id = connect();
    EXPECT_FALSE(node.connected);
    wire.abort(id, End::node, false);
    run();
    EXPECT_EQ(wire.streams(), 0U);
}

TEST_F(Line, WhoHasGoneWithoutAWordIsMissedWhenSomethingIsSent) {
    const auto id = connect();
    wire.abort(id, End::node, true);
    run();
    EXPECT_EQ(drive.ends, 0);
    wire.write(id, End::drive, cip::Bytes{1});
    run();
    EXPECT_EQ(drive.ends, 1) << "a reset";
    EXPECT_EQ(wire.streams(), 0U);
}

TEST_F(Line, ResetEndsBothEnds) {
    connect();
    wire.reset_streams(0, 0);
    EXPECT_EQ(node.ends, 1);
    EXPECT_EQ(drive.ends, 1);
    EXPECT_EQ(wire.streams(), 0U);
}

}  // namespace
}  // namespace servobus::sim
