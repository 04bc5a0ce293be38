// The client against a target that answers late, in pieces, in another order, wrongly, or not at all.
#include "scanner/client.hpp"

#include <gtest/gtest.h>

#include "cip/object.hpp"
#include "cip/services.hpp"
#include "cip/unconnected_send.hpp"
#include "drive/lookup.hpp"
#include "drive/xenax.hpp"
#include "enip/asio/asio.hpp"
#include "scanner/host.hpp"
#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;
using namespace test;
using cip::service::get_attribute_single;

const cip::Request read_scurve{get_attribute_single, cip::Path::to(0x64, 1, 0), {}};
const cip::Response twenty{get_attribute_single, {}, {20, 0, 0, 0}};

const drive::Parameter& row(std::string_view name) {
    return *drive::find_by_name(drive::parameters(), drive::parameter_classes(), name).front();
}

struct Answer {
    error_code error;
    cip::Response response;
};

/// A client, and functions that wait.
class Harness {
public:
    explicit Harness(ClientOptions options = {}) : client(context.get_executor(), std::move(options)) {}
    Harness(const FakeServer& server, ClientOptions options = {}) : Harness(std::move(options)) {
        EXPECT_EQ(connect(server.port()), error_code());
    }

    error_code connect(std::uint16_t port) {
        std::optional<error_code> result;
        client.async_connect("127.0.0.1", port, [&](error_code error) { result = error; });
        run([&] { return result.has_value(); });
        return *result;
    }
    Answer call(const cip::Request& request = read_scurve, CallOptions options = {}) {
        std::optional<Answer> result;
        client.async_call(request, options, [&](error_code error, cip::Response response) {
            result = Answer{error, std::move(response)};
        });
        run([&] { return result.has_value(); });
        return *result;
    }
    error_code close() {
        std::optional<error_code> result;
        client.async_close([&](error_code error) { result = error; });
        run([&] { return result.has_value(); });
        return *result;
    }
    void run(const std::function<bool()>& done) {
        context.restart();
        while (!done() && context.run_one_for(10s) > 0) {
        }
        ASSERT_TRUE(done());
    }

    net::io_context context;
    Client client;
};

ClientOptions quick() {
    ClientOptions options;
    options.timeout = 100ms;
    return options;
}

TEST(Client, CompletesCallbacks) {
    FakeServer server(answering([](const cip::Request& request) {
        EXPECT_EQ(request, read_scurve);
        return twenty;
    }));
    Harness harness(server);
    const auto answer = harness.call();
    EXPECT_EQ(answer.error, error_code());
    EXPECT_EQ(answer.response, twenty);
}

TEST(Client, CompletesFutures) {
    FakeServer server(answering([](const auto&) { return twenty; }));
    net::io_context context;
    auto work = net::make_work_guard(context);
    std::thread thread([&] { context.run(); });
    {
        Client client(context.get_executor());
        client.async_connect("127.0.0.1", server.port(), net::use_future).get();
        EXPECT_EQ(client.async_call(read_scurve, net::use_future).get(), twenty);
        EXPECT_EQ(client.async_read(row("SCurve"), net::use_future).get().value, drive::Value(20));
        client.async_close(net::use_future).get();
        EXPECT_THROW(client.async_call(read_scurve, net::use_future).get(), boost::system::system_error);
    }
    work.reset();
    thread.join();
}

TEST(Client, CompletesCoroutines) {
    FakeServer server(answering([](const auto&) { return twenty; }));
    net::io_context context;
    bool finished = false;
    const auto talk = [&]() -> net::awaitable<void> {
        Client client(co_await net::this_coro::executor);
        co_await client.async_connect("127.0.0.1", server.port(), net::use_awaitable);
        EXPECT_EQ(co_await client.async_call(read_scurve, net::use_awaitable), twenty);
        const auto outcome = co_await client.async_read(row("SCurve"), net::use_awaitable);
        EXPECT_EQ(outcome.value, drive::Value(20));
        co_await client.async_close(net::use_awaitable);
        error_code error;
        co_await client.async_call(read_scurve, net::redirect_error(net::use_awaitable, error));
        EXPECT_EQ(error, make_error_code(Error::not_connected));
        finished = true;
    };
    net::co_spawn(context, talk(), net::detached);
    context.run_for(10s);
    EXPECT_TRUE(finished);
}

TEST(Client, TakesLeave) {
    FakeServer server(answering([](const auto&) { return twenty; }));
    Harness harness(server);
    EXPECT_EQ(harness.close(), error_code());
    EXPECT_EQ(harness.close(), error_code());
    for (int i = 0; i < 1000 && server.commands().size() < 2; ++i) std::this_thread::sleep_for(1ms);
    EXPECT_EQ(server.commands(), (std::vector{enip::Command::register_session, enip::Command::unregister_session}));
    EXPECT_EQ(harness.connect(server.port()), error_code());
    EXPECT_EQ(harness.call().response, twenty);
}

TEST(Client, MatchesRepliesInAnyOrder) {
    constexpr std::size_t requests = 5;
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        peer.kept.push_back(frame);
        if (peer.kept.size() < requests) return;
        for (auto kept = peer.kept.rbegin(); kept != peer.kept.rend(); ++kept) {
            const auto data = request_in(*kept).data;
            peer.send(reply_with(*kept, cip::Response{get_attribute_single, {}, data}));
        }
    }));
    Harness harness(server);
    std::vector<std::uint8_t> order;
    for (std::uint8_t i = 0; i < requests; ++i) {
        auto request = read_scurve;
        request.data = {i};
        harness.client.async_call(request, [&order, i](error_code error, const cip::Response& response) {
            EXPECT_EQ(error, error_code());
            EXPECT_EQ(response.data, cip::Bytes{i});
            order.push_back(i);
        });
    }
    harness.run([&] { return order.size() == requests; });
    EXPECT_EQ(order, (std::vector<std::uint8_t>{4, 3, 2, 1, 0}));
}

TEST(Client, ReadsRepliesInPieces) {
    FakeServer server([](Peer& peer, const enip::Frame& frame) {
        if (frame.command == enip::Command::register_session) peer.trickle(registered(frame).encode());
        if (frame.command == enip::Command::send_rr_data) peer.trickle(reply_with(frame, twenty).encode());
    });
    Harness harness(server);
    EXPECT_EQ(harness.call().response, twenty);
}

TEST(Client, ReadsTwoRepliesInOnePiece) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        peer.kept.push_back(frame);
        if (peer.kept.size() < 2) return;
        auto octets = reply_with(peer.kept[0], twenty).encode();
        reply_with(peer.kept[1], twenty).write(octets);
        peer.send(octets);
    }));
    Harness harness(server);
    int answers = 0;
    for (int i = 0; i < 2; ++i) {
        harness.client.async_call(read_scurve, [&](error_code error, const cip::Response&) {
            EXPECT_EQ(error, error_code());
            ++answers;
        });
    }
    harness.run([&] { return answers == 2; });
}

TEST(Client, TimesOutWhenNothingIsRegistered) {
    FakeServer server([](Peer&, const enip::Frame&) {});
    Harness harness(quick());
    EXPECT_EQ(harness.connect(server.port()), make_error_code(Error::timeout));
    EXPECT_EQ(harness.call().error, make_error_code(Error::not_connected));
}

TEST(Client, DropsAReplyThatIsLate) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        peer.kept.push_back(frame);
        if (peer.kept.size() == 1) return;
        peer.send(reply_with(peer.kept[0], cip::Response{get_attribute_single, {}, {1}}));
        peer.send(reply_with(peer.kept[1], cip::Response{get_attribute_single, {}, {2}}));
    }));
    Harness harness(server);
    EXPECT_EQ(harness.call(read_scurve, {50ms}).error, make_error_code(Error::timeout));
    EXPECT_EQ(harness.call().response.data, cip::Bytes{2});
}

TEST(Client, BoundsTheTimeOfATrickle) {
    FakeServer server(after_registration(
        [](Peer& peer, const enip::Frame& frame) { peer.trickle(reply_with(frame, twenty).encode(), 30ms); }));
    Harness harness(server);
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_EQ(harness.call(read_scurve, {200ms}).error, make_error_code(Error::timeout));
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 600ms);
}

TEST(Client, TellsAnotherProtocolAtOnce) {
    for (const std::string_view greeting : {"HTTP/1.1 400 Bad Request\r\n\r\n", "SSH-2.0-x\r\n", "no"}) {
        FakeServer server(
            [greeting](Peer& peer, const enip::Frame&) { peer.send(cip::Bytes(greeting.begin(), greeting.end())); });
        Harness harness;
        EXPECT_EQ(harness.connect(server.port()), make_error_code(Error::foreign_protocol));
    }
    FakeServer server(after_registration([](Peer& peer, const enip::Frame&) { peer.send(hex("FF FF 00")); }));
    Harness harness(server);
    EXPECT_EQ(harness.call().error, make_error_code(Error::foreign_protocol));
    EXPECT_EQ(harness.call().error, make_error_code(Error::not_connected));
}

TEST(Client, DropsAReplyWithAForeignContext) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        auto reply = reply_with(frame, twenty);
        reply.context = {1, 2, 3, 4, 5, 6, 7, 8};
        peer.send(reply);
        if (++peer.count > 1) peer.send(reply_with(frame, twenty));
    }));
    Harness harness(server);
    EXPECT_EQ(harness.call(read_scurve, {100ms}).error, make_error_code(Error::wrong_command));
    EXPECT_EQ(harness.call().response, twenty);
}

TEST(Client, PassesOnEncapsulationErrors) {
    using enum enip::EncapsulationStatus;
    for (const auto status : {unsupported_command, insufficient_memory, incorrect_data, invalid_length}) {
        FakeServer server(
            after_registration([status](Peer& peer, const enip::Frame& frame) { peer.send(frame.reply(status)); }));
        Harness harness(server);
        EXPECT_EQ(harness.call().error, make_error_code(status));
        EXPECT_EQ(trouble_of(harness.call().error), Trouble::refusal);
    }
    FakeServer refuses([](Peer& peer, const enip::Frame& frame) { peer.send(frame.reply(unsupported_protocol)); });
    Harness harness;
    EXPECT_EQ(harness.connect(refuses.port()), make_error_code(unsupported_protocol));
}

TEST(Client, RegistersAgainWhenTheSessionIsGone) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        const bool first = peer.count++ == 0;
        peer.send(first ? frame.reply(enip::EncapsulationStatus::invalid_session) : reply_with(frame, twenty));
    }));
    Harness harness(server);
    EXPECT_EQ(harness.call().response, twenty);
    EXPECT_EQ(server.commands(), (std::vector{enip::Command::register_session, enip::Command::send_rr_data,
                                              enip::Command::register_session, enip::Command::send_rr_data}));
}

TEST(Client, RegistersAgainOnceOnly) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        peer.send(frame.reply(enip::EncapsulationStatus::invalid_session));
    }));
    Harness harness(server);
    EXPECT_EQ(harness.call().error, make_error_code(enip::EncapsulationStatus::invalid_session));
    EXPECT_EQ(server.seen().size(), 4U);
}

TEST(Client, SaysWhenTheSessionCannotBeMadeAgain) {
    FakeServer server([](Peer& peer, const enip::Frame& frame) {
        if (frame.command == enip::Command::register_session && peer.count++ == 0) {
            peer.send(registered(frame));
        } else {
            peer.send(frame.reply(frame.command == enip::Command::register_session
                                      ? enip::EncapsulationStatus::unsupported_command
                                      : enip::EncapsulationStatus::invalid_session));
        }
    });
    Harness harness(server);
    EXPECT_EQ(harness.call().error, make_error_code(enip::EncapsulationStatus::invalid_session));
}

TEST(Client, LeavesCipErrorsInTheResponse) {
    const cip::Response refusal{get_attribute_single, cip::Status(cip::GeneralStatus::vendor_specific, {1}), {}};
    FakeServer server(answering([&](const auto&) { return refusal; }));
    Harness harness(server);
    const auto answer = harness.call();
    EXPECT_EQ(answer.error, error_code());
    EXPECT_EQ(answer.response, refusal);
}

TEST(Client, ToleratesAReservedOctetAndOtherItems) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        auto data = enip::SendData::unconnected(hex("8E FF 00 00 14 00 00 00"));
        data.packet.items.push_back({enip::ItemType::sockaddr_o_to_t, cip::Bytes(16)});
        data.timeout = 7;
        peer.send(frame.reply(enip::EncapsulationStatus::success, data.encode()));
    }));
    Harness harness(server);
    EXPECT_EQ(harness.call().response, twenty);
}

struct Nonsense {
    std::string_view name;
    Error error;
    cip::Bytes (*data)();  ///< the data portion of the reply

    friend void PrintTo(const Nonsense& nonsense, std::ostream* out) { *out << nonsense.name; }
};

class ClientNonsense : public testing::TestWithParam<Nonsense> {};

TEST_P(ClientNonsense, IsAnErrorOfThisRequestOnly) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        const bool first = peer.count++ == 0;
        peer.send(first ? frame.reply(enip::EncapsulationStatus::success, GetParam().data())
                        : reply_with(frame, twenty));
    }));
    Harness harness(server);
    EXPECT_EQ(harness.call().error, make_error_code(GetParam().error));
    EXPECT_EQ(trouble_of(make_error_code(GetParam().error)), Trouble::nonsense);
    EXPECT_EQ(harness.call().response, twenty);
}

INSTANTIATE_TEST_SUITE_P(
    Replies, ClientNonsense,
    testing::Values(Nonsense{"NoData", Error::malformed_packet, [] { return cip::Bytes{}; }},
                    Nonsense{"NoItems", Error::malformed_packet, [] { return hex("00000000 0000 0000"); }},
                    Nonsense{"ItemPastTheEnd", Error::malformed_packet,
                             [] { return hex("00000000 0000 0200 00000000 B2002000 8E"); }},
                    Nonsense{"TooManyItems", Error::malformed_packet, [] { return hex("00000000 0000 FFFF"); }},
                    Nonsense{"OtherItem", Error::malformed_packet,
                             [] { return hex("00000000 0000 0200 00000000 B1000400 8E000000"); }},
                    Nonsense{"EmptyResponse", Error::malformed_response,
                             [] { return enip::SendData::unconnected({}).encode(); }},
                    Nonsense{"CutResponse", Error::malformed_response,
                             [] { return enip::SendData::unconnected(hex("8E 00 1F 01 01")).encode(); }},
                    Nonsense{"NoReplyBit", Error::malformed_response,
                             [] { return enip::SendData::unconnected(hex("0E 00 00 00")).encode(); }},
                    Nonsense{"OtherService", Error::wrong_service,
                             [] { return enip::SendData::unconnected(hex("90 00 00 00")).encode(); }},
                    Nonsense{"RouterWithoutRoute", Error::wrong_service,
                             [] { return enip::SendData::unconnected(hex("D2 00 01 01 12 03")).encode(); }},
                    Nonsense{"Oversize", Error::oversize_reply,
                             [] { return enip::SendData::unconnected(cip::Bytes(enip::max_data_bytes)).encode(); }}),
    [](const auto& suite) { return std::string(suite.param.name); });

TEST(Client, TakesTheLargestReply) {
    // 16 octets of the packet and 4 of the response surround the data.
    const cip::Response large{get_attribute_single, {}, cip::Bytes(enip::max_data_bytes - 20, 0xAA)};
    FakeServer server(answering([&](const auto&) { return large; }));
    Harness harness(server);
    EXPECT_EQ(harness.call().response, large);
}

TEST(Client, SaysWhenAReplyHasAnotherCommand) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        auto reply = reply_with(frame, twenty);
        reply.command = enip::Command::list_identity;
        peer.send(reply);
    }));
    Harness harness(server);
    EXPECT_EQ(harness.call().error, make_error_code(Error::wrong_command));
}

TEST(Client, SaysWhenTheDeviceCloses) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame&) { peer.close(); }));
    Harness harness(server);
    EXPECT_EQ(harness.call().error, make_error_code(Error::closed));
    EXPECT_EQ(harness.call().error, make_error_code(Error::not_connected));
}

TEST(Client, SaysWhenTheDeviceClosesInTheMiddleOfAReply) {
    for (const std::size_t octets : {1, 2, 23, 24, 25, 40}) {
        FakeServer server(after_registration([octets](Peer& peer, const enip::Frame& frame) {
            auto reply = reply_with(frame, twenty).encode();
            reply.resize(octets);
            peer.send(reply);
            peer.close();
        }));
        Harness harness(server);
        EXPECT_EQ(harness.call().error, make_error_code(Error::closed_in_message)) << octets;
    }
}

TEST(Client, PassesOnErrorsOfTheSystem) {
    std::uint16_t port = 0;
    {
        port = FakeServer([](Peer&, const enip::Frame&) {}).port();
    }
    Harness harness;
    EXPECT_EQ(harness.connect(port), net::error::connection_refused);
    EXPECT_EQ(harness.connect(port), net::error::connection_refused) << "a second attempt is possible";
}

TEST(Client, RefusesASecondConnection) {
    FakeServer server(answering([](const auto&) { return twenty; }));
    Harness harness(server);
    EXPECT_EQ(harness.connect(server.port()), make_error_code(Error::already_connected));
    EXPECT_EQ(harness.call().response, twenty);
}

TEST(Client, HoldsTheLimitOfOutstandingRequests) {
    ClientOptions options;
    options.outstanding = 2;
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        peer.kept.push_back(frame);
        ++peer.count;
        EXPECT_LE(peer.kept.size(), 2U);
        if (peer.kept.size() < 2) return;
        for (const auto& kept : peer.kept) peer.send(reply_with(kept, twenty));
        peer.kept.clear();
    }));
    Harness harness(server, options);
    int answers = 0;
    for (int i = 0; i < 10; ++i) {
        harness.client.async_call(read_scurve, [&](error_code error, const cip::Response&) {
            EXPECT_EQ(error, error_code());
            ++answers;
        });
    }
    harness.run([&] { return answers == 10; });
}

TEST(Client, HoldsTheLimitOfWaitingRequests) {
    FakeServer server(after_registration([](Peer&, const enip::Frame&) {}));
    Harness harness(server);
    std::size_t refused = 0;
    std::size_t failed = 0;
    const auto count = [&](error_code error, const cip::Response&) {
        ++(error == make_error_code(Error::too_many_requests) ? refused : failed);
    };
    for (std::size_t i = 0; i < max_outstanding + max_waiting + 1; ++i) {
        harness.client.async_call(read_scurve, {300ms}, count);
    }
    harness.run([&] { return refused + failed == max_outstanding + max_waiting + 1; });
    EXPECT_EQ(refused, 1U);
}

TEST(Client, HoldsTheLimitOfARequest) {
    FakeServer server(answering([](const auto&) { return twenty; }));
    Harness harness(server);
    auto request = read_scurve;
    request.data.resize(cip::max_message_bytes - request.encode().size());
    EXPECT_EQ(harness.call(request).error, error_code());
    request.data.push_back(0);
    EXPECT_EQ(harness.call(request).error, make_error_code(Error::request_too_large));

    cip::Request long_path{
        get_attribute_single,
        cip::Path(std::vector<cip::Segment>(cip::max_path_words, cip::logical(cip::LogicalType::member, 1))),
        {}};
    EXPECT_EQ(harness.call(long_path).error, error_code());
    long_path.path.segments.push_back(cip::logical(cip::LogicalType::member, 1));
    EXPECT_EQ(harness.call(long_path).error, make_error_code(Error::request_too_large));
}

TEST(Client, CancelsOneRequestAndKeepsTheOthers) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        peer.kept.push_back(frame);
        if (peer.kept.size() < 3) return;
        for (const auto& kept : peer.kept) peer.send(reply_with(kept, twenty));
    }));
    Harness harness(server);
    net::cancellation_signal signal;
    std::vector<error_code> errors(2);
    int answers = 0;
    harness.client.async_call(read_scurve,
                              net::bind_cancellation_slot(signal.slot(), [&](error_code error, cip::Response) {
                                  errors[0] = error;
                                  ++answers;
                              }));
    harness.client.async_call(read_scurve, [&](error_code error, const cip::Response&) {
        errors[1] = error;
        ++answers;
    });
    harness.context.restart();
    harness.context.poll();
    signal.emit(net::cancellation_type::terminal);
    harness.run([&] { return answers == 1; });
    EXPECT_EQ(errors[0], net::error::operation_aborted);
    EXPECT_EQ(harness.call().response, twenty);
    harness.run([&] { return answers == 2; });
    EXPECT_EQ(errors[1], error_code());
    signal.emit(net::cancellation_type::terminal);
    harness.context.restart();
    harness.context.poll();
}

TEST(Client, CancelsAConnect) {
    FakeServer server([](Peer&, const enip::Frame&) {});
    Harness harness;
    net::cancellation_signal signal;
    std::optional<error_code> result;
    harness.client.async_connect("127.0.0.1", server.port(),
                                 net::bind_cancellation_slot(signal.slot(), [&](error_code error) { result = error; }));
    harness.context.restart();
    harness.context.poll();
    signal.emit(net::cancellation_type::all);
    harness.run([&] { return result.has_value(); });
    EXPECT_EQ(*result, net::error::operation_aborted);
}

TEST(Client, EndsItsRequestsWhenItGoes) {
    FakeServer server(after_registration([](Peer&, const enip::Frame&) {}));
    net::io_context context;
    std::vector<error_code> errors;
    {
        Client client(context.get_executor());
        client.async_connect("127.0.0.1", server.port(), [&](error_code error) {
            EXPECT_EQ(error, error_code());
            for (int i = 0; i < 20; ++i) {
                client.async_call(read_scurve,
                                  [&](error_code failure, const cip::Response&) { errors.push_back(failure); });
            }
        });
        for (int i = 0; i < 100 && server.seen().size() < 2; ++i) context.run_for(5ms);
    }
    context.run_for(5s);
    EXPECT_EQ(errors, std::vector<error_code>(20, net::error::operation_aborted));
}

TEST(Client, EndsItsRequestsWhenItCloses) {
    FakeServer server(after_registration([](Peer&, const enip::Frame&) {}));
    Harness harness(server);
    std::optional<error_code> result;
    harness.client.async_call(read_scurve, [&](error_code error, const cip::Response&) { result = error; });
    EXPECT_EQ(harness.close(), error_code());
    harness.run([&] { return result.has_value(); });
    EXPECT_EQ(*result, net::error::operation_aborted);
}

TEST(Client, WrapsRequestsForARoute) {
    ClientOptions options;
    options.route = *parse_route("1/0,2/192.168.1.10");
    FakeServer server(answering([](const cip::Request& request) {
        EXPECT_EQ(request.service, cip::service::unconnected_send);
        EXPECT_EQ(request.path, cip::Path::to(0x06, 1));
        const auto send = cip::UnconnectedSend::parse(request.data);
        EXPECT_TRUE(send.has_value());
        EXPECT_EQ(send->message, read_scurve.encode());
        EXPECT_EQ(send->route_path, hex("01 00 12 0C 31 39 32 2E 31 36 38 2E 31 2E 31 30"));
        EXPECT_GE(send->timeout(), 5000ms);
        return twenty;
    }));
    Harness harness(server, options);
    EXPECT_EQ(harness.call().response, twenty);
}

TEST(Client, PassesOnWhatARouterSays) {
    ClientOptions options;
    options.route = *parse_route("1/0");
    const cip::Response refusal{cip::service::unconnected_send, cip::ConnectionFailure::link_address_not_valid, {}};
    FakeServer server(answering([&](const auto&) { return refusal; }));
    Harness harness(server, options);
    EXPECT_EQ(harness.call().response, refusal);
}

TEST(Client, ReadsParameters) {
    cip::Response response = twenty;
    FakeServer server(answering([&](const auto&) { return response; }));
    Harness harness(server);
    const auto read = [&](const drive::Parameter& parameter) {
        std::optional<std::pair<error_code, ReadOutcome>> result;
        harness.client.async_read(parameter, [&](error_code error, ReadOutcome outcome) { result = {error, outcome}; });
        harness.run([&] { return result.has_value(); });
        return *result;
    };
    EXPECT_EQ(read(row("SCurve")).second.value, drive::Value(20));

    response.data = {20, 0, 0, 0, 9, 9};
    EXPECT_EQ(read(row("SCurve")).second.value, drive::Value(20));
    EXPECT_EQ(read(row("SCurve")).second.surplus, 2U);

    response.data = {20, 0, 0};
    EXPECT_EQ(read(row("SCurve")).first, make_error_code(Error::missing_data));

    response.data = hex("03 00 61 62 63 00");
    EXPECT_EQ(read(row("MotorType")).second.value, drive::Value("abc"));
    EXPECT_EQ(read(row("MotorType")).second.surplus, 0U) << "one octet of padding behind an odd count";
    response.data = hex("04 00 61 62 63");
    EXPECT_EQ(read(row("MotorType")).first, make_error_code(Error::missing_data));

    response.data = {};
    response.status = cip::GeneralStatus::attribute_not_gettable;
    EXPECT_EQ(read(row("SCurve")).second.status, response.status);
    EXPECT_FALSE(read(row("SCurve")).second.value);
}

TEST(Client, WritesParameters) {
    FakeServer server(answering([](const cip::Request& request) {
        EXPECT_EQ(request.encode(), hex("10 03 20 64 24 01 30 00 F4 01 00 00"));
        return cip::Response{request.service, cip::GeneralStatus::invalid_attribute_value, {}};
    }));
    Harness harness(server);
    std::optional<cip::Status> result;
    harness.client.async_write(row("SCurve"), drive::Value(500), [&](error_code error, cip::Status status) {
        EXPECT_EQ(error, error_code());
        result = status;
    });
    harness.run([&] { return result.has_value(); });
    EXPECT_EQ(*result, cip::Status(cip::GeneralStatus::invalid_attribute_value));
}

TEST(Client, FindsAHostByName) {
    FakeServer server(answering([](const auto&) { return twenty; }));
    Harness harness;
    std::optional<error_code> result;
    harness.client.async_connect("localhost", server.port(), [&](error_code error) { result = error; });
    harness.run([&] { return result.has_value(); });
    EXPECT_EQ(*result, error_code());
}

TEST(Client, ExchangesItemsBesideTheMessages) {  // R-CPF-8
    const enip::Item asked{enip::ItemType::sockaddr_t_to_o, enip::SocketAddress{.port = 50'000}.encode()};
    const enip::Item answered{enip::ItemType::sockaddr_o_to_t, enip::SocketAddress{.port = 3333}.encode()};
    FakeServer server(after_registration([&](Peer& peer, const enip::Frame& frame) {
        const auto data = enip::SendData::parse(frame.data);
        ASSERT_TRUE(data && data->packet.items.size() == 3);
        EXPECT_EQ(data->packet.items[2], asked);
        auto reply = enip::SendData::unconnected(twenty.encode());
        reply.packet.items.push_back(answered);
        peer.send(frame.reply(enip::EncapsulationStatus::success, reply.encode()));
    }));
    Harness harness(server);
    std::optional<Exchange> result;
    harness.client.async_exchange(read_scurve, {asked}, {}, [&](error_code error, Exchange exchange) {
        EXPECT_EQ(error, error_code());
        result = std::move(exchange);
    });
    harness.run([&] { return result.has_value(); });
    EXPECT_EQ(result->response, twenty);
    EXPECT_EQ(result->items, std::vector{answered});
}

TEST(Client, KnowsTheEndsOfItsConnection) {
    FakeServer server(answering([](const auto&) { return twenty; }));
    Harness harness;
    EXPECT_FALSE(harness.client.ends());
    ASSERT_EQ(harness.connect(server.port()), error_code());
    const auto ends = harness.client.ends();
    ASSERT_TRUE(ends);
    EXPECT_EQ(ends->remote, (enip::Endpoint{0x7F000001, server.port()}));
    EXPECT_EQ(ends->local.address, 0x7F000001U);
    EXPECT_NE(ends->local.port, 0);
    harness.close();
    EXPECT_FALSE(harness.client.ends());
}

TEST(Client, KeepsItsSessionAliveWithoutAnAnswer) {  // R-ENC-24
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        if (frame.command == enip::Command::send_rr_data) peer.send(reply_with(frame, twenty));
    }));
    Harness harness(server);
    harness.client.keep_alive();
    EXPECT_EQ(harness.call().response, twenty);
    EXPECT_EQ(server.commands(),
              (std::vector{enip::Command::register_session, enip::Command::nop, enip::Command::send_rr_data}));
}

}  // namespace
}  // namespace servobus::scanner
