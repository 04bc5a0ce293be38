// The originator over real sockets on loopback, against a target that does what a test tells it to.
#include "scanner/originator.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "cip/services.hpp"
#include "enip/asio/io_socket.hpp"
#include "enip/io_packet.hpp"
#include "tests/scanner/fake_server.hpp"
#include "tests/support/octets.hpp"

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;
using namespace test;
using enip::Endpoint;
using enip::ItemType;
using enip::asio::IoSocket;
namespace service = cip::service;

constexpr std::uint32_t loopback = 0x7F000001;
constexpr std::uint32_t group_address = 0xEFC00D61;
constexpr std::uint32_t o_to_t_id = 0x56A00001;

/// The TCP side of a target that grants what is asked; a test may change each answer.
class FakeTarget {
public:
    using Answer = std::function<void(Peer&, const enip::Frame&, const cip::ForwardOpen&)>;

    explicit FakeTarget(std::uint16_t udp_port, Answer on_open = {})
        : udp_port_(udp_port), server_(after_registration([this, on_open](Peer& peer, const enip::Frame& frame) {
              if (frame.command != enip::Command::send_rr_data) return;
              const auto request = request_in(frame);
              if (request.service == service::forward_close) {
                  ++closes;
                  const auto close = cip::ForwardClose::parse(request.data);
                  peer.send(reply_with(
                      frame, cip::Response{request.service, {}, cip::ForwardCloseReply{close->triad, {}}.encode()}));
                  return;
              }
              const auto open =
                  cip::ForwardOpen::parse(request.data, request.service == service::large_forward_open).value();
              ++opens;
              last_item_ = port_in(frame);
              if (on_open) {
                  on_open(peer, frame, open);
              } else {
                  peer.send(grant(frame, open));
              }
          })) {}

    [[nodiscard]] enip::Frame grant(const enip::Frame& frame, const cip::ForwardOpen& open) const {
        const bool multicast = open.t_to_o.type == cip::ConnectionType::multicast;
        const auto t_to_o_id = multicast ? 0x56A00002 : open.t_to_o_id;
        const cip::ForwardOpenReply reply{o_to_t_id, t_to_o_id, open.triad, open.o_to_t_rpi, open.t_to_o_rpi, {}};
        auto data = enip::SendData::unconnected(cip::Response{request_in(frame).service, {}, reply.encode()}.encode());
        const auto add = [&](ItemType type, std::uint16_t port, std::uint32_t address) {
            data.packet.items.push_back({type, enip::SocketAddress{.port = port, .address = address}.encode()});
        };
        add(ItemType::sockaddr_o_to_t, udp_port_, 0);
        if (multicast) add(ItemType::sockaddr_t_to_o, group_port, group_address);
        return frame.reply(enip::EncapsulationStatus::success, data.encode());
    }
    /// The port in the last Forward_Open's item 0x8001; 0 without one.
    [[nodiscard]] std::uint16_t last_item() const { return last_item_; }
    [[nodiscard]] std::uint16_t port() const { return server_.port(); }
    [[nodiscard]] std::vector<enip::Command> commands() const { return server_.commands(); }

    std::atomic<int> opens = 0;
    std::atomic<int> closes = 0;
    std::atomic<std::uint16_t> group_port = 0;

private:
    static std::uint16_t port_in(const enip::Frame& frame) {
        const auto data = enip::SendData::parse(frame.data);
        const auto* item = data->packet.find(ItemType::sockaddr_t_to_o);
        return item != nullptr ? enip::SocketAddress::parse(item->data)->port : std::uint16_t{0};
    }

    std::uint16_t udp_port_;
    std::atomic<std::uint16_t> last_item_ = 0;
    FakeServer server_;
};

class Originators : public testing::Test {
protected:
    Originators() {
        EXPECT_FALSE(udp.open({loopback, 0}, false));
        hear();
    }

    IoOptions options(const FakeTarget& target) const {
        IoOptions made{.host = "127.0.0.1", .port = target.port()};
        made.plan = plan_of(*assemblies::find_connection("standard"));
        made.timeout = 2s;
        made.first_pause = 10ms;
        return made;
    }
    IoEvents events() {
        return {.opened = [this](const IoOpened& event) { opened.push_back(event); },
                .input = [this](const IoInput& input) { inputs.emplace_back(input.data.begin(), input.data.end()); },
                .output =
                    [](std::span<std::uint8_t> data) {
                        data[0] = 0x42;
                        return true;
                    },
                .closed = [this](const IoClosed& event) { closed.push_back(event); }};
    }

    void hear() {
        udp.socket().async_wait(net::ip::udp::socket::wait_read, [this](auto error) {
            if (error) return;
            udp.receive([this](const IoSocket::Received& datagram) {
                produced.emplace_back(datagram.octets.begin(), datagram.octets.end());
                if (answers) send(++sequence);
            });
            hear();
        });
    }
    cip::Bytes t_to_o(std::uint32_t number) const {
        cip::Bytes datagram(enip::io_packet_overhead + 30);
        enip::begin_io_packet(datagram, opened.at(0).reply.t_to_o_id, number)[0] = static_cast<std::uint8_t>(number);
        return datagram;
    }
    void send(std::uint32_t number) { send(t_to_o(number), udp); }
    void send(const cip::Bytes& datagram, IoSocket& from) {
        enip::IoQueue queue;
        std::ranges::copy(datagram,
                          queue.add({.local = from.local(), .peer = opened.at(0).receiver}, datagram.size()).begin());
        EXPECT_EQ(from.send(queue).sent, 1U);
    }

    void run_until(const std::function<bool()>& done) {
        const auto end = std::chrono::steady_clock::now() + 10s;  // io goes on by itself, for ever
        context.restart();
        while (!done() && context.run_one_until(end) > 0) {
        }
        ASSERT_TRUE(done());
    }
    /// Everything ends by itself: no timer, socket or request is left behind.
    void run_out() {
        udp.close();
        context.restart();
        context.run_for(5s);
        EXPECT_TRUE(context.stopped());
    }

    net::io_context context{1};
    IoSocket udp{context.get_executor()};
    std::vector<cip::Bytes> produced;  ///< what the target has got
    bool answers = true;               ///< each datagram with one
    std::uint32_t sequence = 0;

    std::vector<IoOpened> opened;
    std::vector<cip::Bytes> inputs;
    std::vector<IoClosed> closed;
};

TEST_F(Originators, OpenRunAndClose) {  // R-SCN-1
    FakeTarget target(udp.local().port);
    Originator originator(context.get_executor());
    auto& io = originator.add(options(target), events());
    EXPECT_EQ(io.state(), IoState::idle);
    io.open();
    run_until([&] { return inputs.size() == 3; });
    EXPECT_EQ(io.state(), IoState::open);
    EXPECT_EQ(opened.at(0).target, udp.local());
    EXPECT_EQ(opened[0].receiver.address, loopback);
    EXPECT_EQ(opened[0].local.address, loopback);
    EXPECT_GE(produced.size(), 3U);
    const auto packet = enip::IoPacket::parse(produced[0]).value();
    EXPECT_EQ(packet.connection_id, o_to_t_id);
    EXPECT_EQ(packet.data.size(), 24U);
    EXPECT_EQ(packet.data[6], 0x42);
    EXPECT_EQ(io.received().accepted, 3U);
    EXPECT_EQ(io.sent().sent, produced.size());
    io.close();
    run_until([&] { return !closed.empty(); });
    EXPECT_EQ(closed[0].reason, CloseReason::asked);
    EXPECT_EQ(target.closes, 1);
    run_out();
    const auto end = std::chrono::steady_clock::now() + 10s;  // the target has a thread of its own
    while (target.commands().back() != enip::Command::unregister_session && std::chrono::steady_clock::now() < end) {
        std::this_thread::yield();
    }
    EXPECT_EQ(target.commands().back(), enip::Command::unregister_session);
    EXPECT_EQ(originator.unsent(), 0U);
}

TEST_F(Originators, NameThePortThatTheyHaveFound) {  // R-CPF-8
    FakeTarget target(udp.local().port);
    IoSocket occupied(context.get_executor());
    ASSERT_FALSE(occupied.open({loopback, 0}, false));
    Originator originator(context.get_executor(), {.io_port = occupied.local().port});
    auto& io = originator.add(options(target), events());
    io.open();
    run_until([&] { return !inputs.empty(); });
    EXPECT_NE(opened.at(0).receiver.port, occupied.local().port);
    EXPECT_EQ(target.last_item(), opened[0].receiver.port);
}

TEST_F(Originators, ShareSocketAndSessionAmongConnections) {
    FakeTarget target(udp.local().port);
    Originator originator(context.get_executor());
    std::vector<IoConnection*> connections;
    for (int i = 0; i < 5; ++i) connections.push_back(&originator.add(options(target), events()));
    for (auto* io : connections) io->open();
    run_until([&] { return opened.size() == 5; });
    for (const auto& each : opened) EXPECT_EQ(each.receiver, opened[0].receiver);
    EXPECT_EQ(std::ranges::count(target.commands(), enip::Command::register_session), 1);
    connections[0]->close();
    run_until([&] { return closed.size() == 1; });
    for (int i = 1; i < 5; ++i) EXPECT_EQ(connections[i]->state(), IoState::open);
    for (auto* io : connections) io->close();
    run_until([&] { return closed.size() == 5; });
    run_out();
}

TEST_F(Originators, OfOneProcessDoNotMeet) {
    FakeTarget target(udp.local().port);
    Originator first(context.get_executor());
    Originator second(context.get_executor());
    auto& one = first.add(options(target), events());
    auto& two = second.add(options(target), events());
    one.open();
    two.open();
    run_until([&] { return opened.size() == 2; });
    EXPECT_NE(opened[0].receiver, opened[1].receiver);
    EXPECT_NE(opened[0].request.triad.originator_serial, opened[1].request.triad.originator_serial);
}

TEST_F(Originators, HearMulticastUntilTheyClose) {  // R-MC-3
    IoSocket reserve(context.get_executor());
    ASSERT_FALSE(reserve.open({group_address, 0}, true));
    FakeTarget target(udp.local().port);
    target.group_port = reserve.local().port;
    Originator originator(context.get_executor());
    auto asked = options(target);
    asked.plan.t_to_o.type = cip::ConnectionType::multicast;
    auto& first = originator.add(asked, events());
    auto& second = originator.add(asked, events());
    answers = false;
    first.open();
    second.open();
    run_until([&] { return opened.size() == 2; });
    EXPECT_EQ(opened[0].receiver, (Endpoint{group_address, reserve.local().port}));
    send(1);
    run_until([&] { return inputs.size() == 2; });  // one datagram, for both (R-CON-33)
    first.close();
    run_until([&] { return closed.size() == 1; });
    send(2);
    run_until([&] { return inputs.size() == 3; });
    EXPECT_EQ(second.received().accepted, 2U);
    second.close();
    run_until([&] { return closed.size() == 2; });
    run_out();
}

TEST_F(Originators, CountWhatFitsNowhere) {  // R-IO-7
    FakeTarget target(udp.local().port);
    Originator originator(context.get_executor());
    auto& io = originator.add(options(target), events());
    answers = false;
    io.open();
    run_until([&] { return io.state() == IoState::open; });
    const auto& strays = originator.strays();

    const auto good = t_to_o(1);
    unsigned malformed = 0;
    const auto send_malformed = [&](const cip::Bytes& datagram) {
        send(datagram, udp);
        ++malformed;
    };
    send_malformed({});
    send_malformed({0, 0});
    for (std::size_t size = 1; size < good.size(); ++size) send_malformed({good.begin(), good.begin() + int(size)});
    for (const std::size_t at : {0, 2, 4, 14}) {  // item count, address type, its length, data type
        auto broken = good;
        broken[at] ^= 0x10;
        send_malformed(broken);
    }
    run_until([&] { return strays.malformed == malformed; });

    auto unknown = good;
    unknown[6] ^= 1;
    send(unknown, udp);
    run_until([&] { return strays.unknown_id == 1; });

    IoSocket stranger(context.get_executor());
    ASSERT_FALSE(stranger.open({loopback + 1, 0}, false));
    send(good, stranger);
    run_until([&] { return strays.wrong_source == 1; });

    auto short_data = good;
    short_data[16] = 29;
    send(short_data, udp);
    run_until([&] { return io.received().wrong_size == 1; });

    EXPECT_EQ(io.state(), IoState::open);
    EXPECT_TRUE(inputs.empty());
    EXPECT_EQ(io.received().accepted, 0U);
    send(good, udp);
    run_until([&] { return io.received().accepted == 1; });
    send(good, udp);
    run_until([&] { return io.received().stale == 1; });
    EXPECT_EQ(inputs.size(), 1U);
    EXPECT_EQ(strays.malformed, malformed);
}

TEST_F(Originators, OpenAgainAfterTheTargetFellSilent) {  // R-CON-18, R-CON-21
    FakeTarget target(udp.local().port);
    Originator originator(context.get_executor());
    auto& io = originator.add(options(target), events());
    io.open();
    run_until([&] { return inputs.size() == 2; });
    answers = false;
    run_until([&] { return !closed.empty(); });
    EXPECT_EQ(closed[0].reason, CloseReason::timed_out);
    EXPECT_EQ(closed[0].next_try, 10ms);
    run_until([&] { return opened.size() == 2; });
    EXPECT_NE(opened[1].request.triad, opened[0].request.triad);
    EXPECT_EQ(target.closes, 1);
}

TEST_F(Originators, KeepIoWhenTheSessionGoes) {  // R-ENC-25
    std::shared_ptr<Peer> peer;
    FakeTarget* self = nullptr;
    FakeTarget target(udp.local().port, [&](Peer& from, const enip::Frame& frame, const cip::ForwardOpen& open) {
        from.send(self->grant(frame, open));
        from.close();
    });
    self = &target;
    Originator originator(context.get_executor());
    auto& io = originator.add(options(target), events());
    io.open();
    run_until([&] { return inputs.size() == 5; });
    EXPECT_EQ(io.state(), IoState::open);
    io.close();
    run_until([&] { return !closed.empty(); });
    EXPECT_EQ(closed[0].reason, CloseReason::asked);
    EXPECT_EQ(closed[0].error, error_code());
    EXPECT_EQ(target.closes, 1);
    EXPECT_EQ(std::ranges::count(target.commands(), enip::Command::register_session), 2);
    run_out();
}

TEST_F(Originators, TryAgainUntilSomebodyAnswers) {
    Originator originator(context.get_executor());
    IoOptions nobody{.host = "127.0.0.1", .port = 1, .first_pause = 1ms, .last_pause = 2ms};
    auto& io = originator.add(nobody, events());
    io.open();
    run_until([&] { return closed.size() == 3; });
    EXPECT_EQ(closed[0].reason, CloseReason::unreachable);
    EXPECT_EQ(closed[0].error, net::error::connection_refused);
    EXPECT_EQ(closed[2].next_try, 2ms);
    io.close();
    EXPECT_EQ(io.state(), IoState::closed);
    run_out();
}

TEST_F(Originators, MayGoAwayInTheirOwnEvents) {
    FakeTarget target(udp.local().port);
    auto originator = std::make_unique<Originator>(context.get_executor());
    auto own = events();
    own.input = [&](const IoInput&) { originator.reset(); };
    auto& io = originator->add(options(target), own);
    originator->add(options(target), own).open();
    io.open();
    run_until([&] { return originator == nullptr; });
    run_out();
}

TEST_F(Originators, TellADeviceThatDoesNotAnswer) {
    FakeTarget target(udp.local().port, [](Peer&, const enip::Frame&, const cip::ForwardOpen&) {});
    Originator originator(context.get_executor());
    auto asked = options(target);
    asked.timeout = 50ms;
    auto& io = originator.add(asked, events());
    io.open();
    run_until([&] { return closed.size() == 2; });
    EXPECT_EQ(closed[0].reason, CloseReason::unreachable);
    EXPECT_EQ(closed[0].error, Error::timeout);
    // The next try has a TCP connection of its own, and closes first what may have been opened.
    EXPECT_EQ(std::ranges::count(target.commands(), enip::Command::register_session), 2);
    EXPECT_EQ(target.closes, 1);
}

TEST_F(Originators, NullOpensAreAskedAndDone) {  // R-CON-23
    FakeTarget target(udp.local().port);
    Originator originator(context.get_executor());
    auto asked = options(target);
    asked.plan.o_to_t.type = asked.plan.t_to_o.type = cip::ConnectionType::null;
    auto& io = originator.add(asked, events());
    io.open();
    run_until([&] { return !closed.empty(); });
    EXPECT_EQ(opened.size(), 1U);
    EXPECT_EQ(closed[0].reason, CloseReason::asked);
    EXPECT_EQ(target.closes, 0);
    EXPECT_EQ(io.state(), IoState::closed);
    run_out();
}

// ------------------------------------------------------------------------------- hostile replies, below the reply

struct HostileFrame {
    const char* name;
    std::function<void(Peer&, const enip::Frame& request, enip::Frame reply)> send;
    CloseReason reason;
    std::optional<Error> error;
};
void PrintTo(const HostileFrame& hostile, std::ostream* out) { *out << hostile.name; }

class HostileFrames : public Originators, public testing::WithParamInterface<HostileFrame> {};

TEST_P(HostileFrames, EndInATypedError) {  // R-SCN-5, R-SCN-6
    const auto& hostile = GetParam();
    FakeTarget* self = nullptr;
    FakeTarget target(udp.local().port, [&](Peer& peer, const enip::Frame& frame, const cip::ForwardOpen& open) {
        hostile.send(peer, frame, self->grant(frame, open));
    });
    self = &target;
    Originator originator(context.get_executor());
    auto asked = options(target);
    asked.timeout = 200ms;
    asked.reopen = false;
    auto& io = originator.add(asked, events());
    io.open();
    run_until([&] { return !closed.empty(); });
    EXPECT_EQ(closed[0].reason, hostile.reason);
    if (hostile.error) {
        EXPECT_EQ(closed[0].error, *hostile.error);
    } else {
        EXPECT_NE(closed[0].error, error_code());
    }
    EXPECT_EQ(io.state(), IoState::closed);
    EXPECT_TRUE(opened.empty());
    run_out();
}

/// The reply with other octets in its data item.
enip::Frame with_message(const enip::Frame& reply, const std::function<void(cip::Bytes&)>& change) {
    auto data = enip::SendData::parse(reply.data).value();
    change(data.packet.items.at(1).data);
    auto changed = reply;
    changed.data = data.encode();
    return changed;
}

constexpr auto bad_reply = CloseReason::bad_reply;
constexpr auto unreachable = CloseReason::unreachable;

// clang-format off
INSTANTIATE_TEST_SUITE_P(Originator, HostileFrames, testing::Values(
    HostileFrame{"context_of_nobody", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.context[5] ^= 1; peer.send(reply); }, bad_reply, Error::wrong_command},
    HostileFrame{"context_of_an_earlier_request", [](Peer& peer, const enip::Frame&, enip::Frame reply) { --reply.context[0]; peer.send(reply); }, unreachable, Error::timeout},
    HostileFrame{"other_command", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.command = enip::Command::list_services; peer.send(reply); }, bad_reply, Error::wrong_command},
    HostileFrame{"unit_data_instead", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.command = enip::Command::send_unit_data; peer.send(reply); }, unreachable, Error::timeout},
    HostileFrame{"encapsulation_status", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.status = enip::EncapsulationStatus::incorrect_data; peer.send(reply); }, unreachable, std::nullopt},
    HostileFrame{"other_service", [](Peer& peer, const enip::Frame&, enip::Frame reply) { peer.send(with_message(reply, [](auto& octets) { octets[0] = 0xCE; })); }, bad_reply, Error::wrong_service},
    HostileFrame{"a_request", [](Peer& peer, const enip::Frame&, enip::Frame reply) { peer.send(with_message(reply, [](auto& octets) { octets[0] &= 0x7F; })); }, bad_reply, Error::malformed_response},
    HostileFrame{"no_response", [](Peer& peer, const enip::Frame&, enip::Frame reply) { peer.send(with_message(reply, [](auto& octets) { octets.resize(3); })); }, bad_reply, Error::malformed_response},
    HostileFrame{"empty_response", [](Peer& peer, const enip::Frame&, enip::Frame reply) { peer.send(with_message(reply, [](auto& octets) { octets.clear(); })); }, bad_reply, Error::malformed_response},
    HostileFrame{"extended_words_beyond_the_end", [](Peer& peer, const enip::Frame&, enip::Frame reply) { peer.send(with_message(reply, [](auto& octets) { octets[3] = 200; })); }, bad_reply, Error::malformed_response},
    HostileFrame{"no_data", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.data.clear(); peer.send(reply); }, bad_reply, Error::malformed_packet},
    HostileFrame{"items_cut", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.data.pop_back(); peer.send(reply); }, bad_reply, Error::malformed_packet},
    HostileFrame{"octets_behind_the_items", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.data.push_back(0); peer.send(reply); }, bad_reply, Error::malformed_packet},
    HostileFrame{"no_data_item", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.data = enip::SendData{}.encode(); peer.send(reply); }, bad_reply, Error::malformed_packet},
    HostileFrame{"connected_data_item", [](Peer& peer, const enip::Frame&, enip::Frame reply) { reply.data[12] = 0xB1; peer.send(reply); }, bad_reply, Error::malformed_packet},
    HostileFrame{"the_request_echoed", [](Peer& peer, const enip::Frame& request, const enip::Frame&) { peer.send(request); }, bad_reply, Error::malformed_response},
    HostileFrame{"closed_in_the_message", [](Peer& peer, const enip::Frame&, const enip::Frame& reply) { auto octets = reply.encode(); octets.resize(40); peer.send(octets); peer.close(); }, unreachable, Error::closed_in_message},
    HostileFrame{"closed", [](Peer& peer, const enip::Frame&, const enip::Frame&) { peer.close(); }, unreachable, Error::closed},
    HostileFrame{"another_protocol", [](Peer& peer, const enip::Frame&, const enip::Frame&) { peer.send(hex("48 54 54 50 2F 31 2E 31")); }, bad_reply, Error::foreign_protocol},
    HostileFrame{"never_the_end", [](Peer& peer, const enip::Frame&, const enip::Frame& reply) { auto octets = reply.encode(); octets.pop_back(); peer.send(octets); }, unreachable, Error::timeout}),
    [](const auto& row) { return std::string(row.param.name); });
// clang-format on

TEST_F(Originators, AReplyTwiceIsOneReply) {
    FakeTarget* self = nullptr;
    FakeTarget target(udp.local().port, [&](Peer& peer, const enip::Frame& frame, const cip::ForwardOpen& open) {
        peer.send(self->grant(frame, open));
        peer.send(self->grant(frame, open));
    });
    self = &target;
    Originator originator(context.get_executor());
    auto& io = originator.add(options(target), events());
    io.open();
    run_until([&] { return inputs.size() == 3; });
    EXPECT_EQ(opened.size(), 1U);
    EXPECT_EQ(io.state(), IoState::open);
}

TEST_F(Originators, AReplyInPiecesIsAReply) {
    FakeTarget* self = nullptr;
    FakeTarget target(udp.local().port, [&](Peer& peer, const enip::Frame& frame, const cip::ForwardOpen& open) {
        peer.trickle(self->grant(frame, open).encode());
    });
    self = &target;
    Originator originator(context.get_executor());
    originator.add(options(target), events()).open();
    run_until([&] { return inputs.size() == 1; });
}

}  // namespace
}  // namespace servobus::scanner
