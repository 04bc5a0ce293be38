// Requests over a class 3 connection.
#include "scanner/class3.hpp"

#include <gtest/gtest.h>

#include "cip/services.hpp"
#include "enip/asio/asio.hpp"
#include "scanner/client.hpp"
#include "scanner/host.hpp"
#include "tests/scanner/fake_server.hpp"

namespace servobus::scanner {
namespace {

using namespace std::chrono_literals;
using namespace test;

constexpr std::uint32_t target_id = 0x56A00001;
const cip::Request read_scurve{cip::service::get_attribute_single, cip::Path::to(0x64, 1, 0), {}};
const cip::Response twenty{cip::service::get_attribute_single, {}, {20, 0, 0, 0}};

/// What a script needs to remember about the connection.
struct Opened {
    cip::ForwardOpen request;
    int closed = 0;
};

cip::Response open_reply(const cip::ForwardOpen& open, std::uint8_t service) {
    const cip::ForwardOpenReply reply{target_id, open.t_to_o_id, open.triad, open.o_to_t_rpi, open.t_to_o_rpi, {}};
    return {service, {}, reply.encode()};
}

/// Opens connections as `accepts` says, closes them, and leaves connected messages to `connected`.
FakeServer::Script class3(Opened& opened, std::function<bool(const cip::ForwardOpen&)> accepts,
                          FakeServer::Script connected) {
    return after_registration([&opened, accepts, connected](Peer& peer, const enip::Frame& frame) {
        if (frame.command == enip::Command::send_unit_data) {
            connected(peer, frame);
            return;
        }
        const auto request = request_in(frame);
        EXPECT_EQ(request.path, cip::Path::to(0x06, 1));
        if (request.service == cip::service::forward_close) {
            const auto close = cip::ForwardClose::parse(request.data);
            EXPECT_TRUE(close && close->triad == opened.request.triad);
            ++opened.closed;
            peer.send(reply_with(
                frame, cip::Response{request.service, {}, cip::ForwardCloseReply{close->triad, {}}.encode()}));
            return;
        }
        const auto open = cip::ForwardOpen::parse(request.data, request.service == cip::service::large_forward_open);
        ASSERT_TRUE(open.has_value());
        opened.request = *open;
        peer.send(reply_with(
            frame, accepts(*open) ? open_reply(*open, request.service)
                                  : cip::Response{request.service, cip::GeneralStatus::service_not_supported, {}}));
    });
}

void answer(Peer& peer, const Opened& opened, std::uint16_t sequence, const cip::Response& response) {
    enip::Frame frame;
    frame.command = enip::Command::send_unit_data;
    frame.session = fake_session;
    frame.data = enip::SendData::connected(opened.request.t_to_o_id, sequence, response.encode()).encode();
    peer.send(frame);
}

struct Sent {
    std::uint32_t connection_id;
    std::uint16_t sequence;
    cip::Bytes message;
};
Sent sent_in(const enip::Frame& frame) {
    const auto data = enip::SendData::parse(frame.data);
    const auto message = enip::connected_message(*data);
    return {message->connection_id, message->sequence, {message->message.begin(), message->message.end()}};
}

class Session {
public:
    explicit Session(const FakeServer& server, ClientOptions options = {}) : client(context.get_executor(), options) {
        wait([&](auto done) {
            client.async_connect("127.0.0.1", server.port(), [=](error_code error) { done(error); });
        });
    }
    error_code open() {
        return wait([&](auto done) {
            client.async_open_connection([this, done](error_code error, cip::Response reply) {
                response = std::move(reply);
                done(error);
            });
        });
    }
    error_code call(const cip::Request& request = read_scurve, CallOptions options = {}) {
        return wait([&](auto done) {
            client.async_call(request, options, [this, done](error_code error, cip::Response reply) {
                response = std::move(reply);
                done(error);
            });
        });
    }
    error_code close() {
        return wait([&](auto done) { client.async_close([=](error_code error) { done(error); }); });
    }
    error_code wait(auto start) {
        std::optional<error_code> result;
        start([&result](error_code error) { result = error; });
        context.restart();
        while (!result && context.run_one_for(10s) > 0) {
        }
        return *result;
    }

    net::io_context context;
    Client client;
    cip::Response response;
};

TEST(Class3, AsksForALargeConnection) {
    Opened opened;
    FakeServer server(class3(
        opened, [](const auto&) { return true; },
        [&](Peer& peer, const enip::Frame& frame) {
            const auto sent = sent_in(frame);
            EXPECT_EQ(sent.connection_id, target_id);
            EXPECT_EQ(sent.message, read_scurve.encode());
            EXPECT_EQ(frame.context, enip::SenderContext{});
            answer(peer, opened, sent.sequence, twenty);
        }));
    Session session(server);
    EXPECT_EQ(session.open(), error_code());
    EXPECT_TRUE(session.response.status.ok());
    EXPECT_TRUE(opened.request.large);
    EXPECT_EQ(opened.request.path, hex("20 02 24 01"));
    EXPECT_EQ(opened.request.transport.to_byte(), 0xA3);
    EXPECT_EQ(opened.request.o_to_t.size, large_connection_size);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(session.call(), error_code());
        EXPECT_EQ(session.response, twenty);
    }
    EXPECT_EQ(session.close(), error_code());
    EXPECT_EQ(opened.closed, 1);
}

TEST(Class3, FallsBackToASmallConnection) {
    Opened opened;
    FakeServer server(class3(
        opened, [](const auto& open) { return !open.large; },
        [&](Peer& peer, const enip::Frame& frame) { answer(peer, opened, sent_in(frame).sequence, twenty); }));
    Session session(server);
    EXPECT_EQ(session.open(), error_code());
    EXPECT_TRUE(session.response.status.ok());
    EXPECT_FALSE(opened.request.large);
    EXPECT_EQ(opened.request.o_to_t.to_word(), 0x43F4);
    EXPECT_EQ(session.call(), error_code());

    auto request = read_scurve;
    request.data.resize(small_connection_size - 2 - request.encode().size());
    EXPECT_EQ(session.call(request), error_code());
    request.data.push_back(0);
    EXPECT_EQ(session.call(request), make_error_code(Error::request_too_large));
    EXPECT_EQ(session.open(), make_error_code(Error::already_connected));
}

TEST(Class3, PassesOnARefusal) {
    Opened opened;
    FakeServer server(class3(
        opened, [](const auto&) { return false; }, [](Peer&, const enip::Frame&) {}));
    Session session(server);
    EXPECT_EQ(session.open(), error_code());
    EXPECT_EQ(session.response.status, cip::Status(cip::GeneralStatus::service_not_supported));
    EXPECT_EQ(session.close(), error_code());
    EXPECT_EQ(opened.closed, 0);
}

TEST(Class3, PutsTheRouteIntoThePath) {
    ClientOptions options;
    options.route = *parse_route("1/3");
    Opened opened;
    FakeServer server(class3(
        opened, [](const auto&) { return true; },
        [&](Peer& peer, const enip::Frame& frame) {
            EXPECT_EQ(sent_in(frame).message, read_scurve.encode());
            answer(peer, opened, sent_in(frame).sequence, twenty);
        }));
    Session session(server, options);
    EXPECT_EQ(session.open(), error_code());
    EXPECT_EQ(opened.request.path, hex("01 03 20 02 24 01"));
    EXPECT_EQ(session.call(), error_code());
}

TEST(Class3, DropsStaleAndForeignReplies) {
    Opened opened;
    FakeServer server(class3(
        opened, [](const auto&) { return true; },
        [&](Peer& peer, const enip::Frame& frame) {
            const auto sequence = sent_in(frame).sequence;
            const cip::Response stale{cip::service::get_attribute_single, {}, {9}};
            answer(peer, opened, static_cast<std::uint16_t>(sequence - 1), stale);
            auto foreign = opened;
            foreign.request.t_to_o_id ^= 1;
            answer(peer, foreign, sequence, stale);
            answer(peer, opened, sequence, twenty);
            answer(peer, opened, sequence, stale);
        }));
    Session session(server);
    EXPECT_EQ(session.open(), error_code());
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(session.call(), error_code());
        EXPECT_EQ(session.response, twenty);
    }
}

TEST(Class3, GoesOnAfterATimeout) {
    Opened opened;
    FakeServer server(class3(
        opened, [](const auto&) { return true; },
        [&](Peer& peer, const enip::Frame& frame) {
            if (peer.count++ > 0) answer(peer, opened, sent_in(frame).sequence, twenty);
        }));
    Session session(server);
    EXPECT_EQ(session.open(), error_code());
    EXPECT_EQ(session.call(read_scurve, {50ms}), make_error_code(Error::timeout));
    EXPECT_EQ(session.call(), error_code());
}

TEST(Class3, SendsOneRequestAtATime) {
    Opened opened;
    FakeServer server(class3(
        opened, [](const auto&) { return true; },
        [&](Peer& peer, const enip::Frame& frame) {
            const auto sent = sent_in(frame);
            EXPECT_EQ(sent.sequence, peer.count + 1);
            ++peer.count;
            answer(peer, opened, sent.sequence, twenty);
        }));
    Session session(server);
    EXPECT_EQ(session.open(), error_code());
    int answers = 0;
    for (int i = 0; i < 5; ++i) {
        session.client.async_call(read_scurve, [&](error_code error, const cip::Response&) {
            EXPECT_EQ(error, error_code());
            ++answers;
        });
    }
    while (answers < 5 && session.context.run_one_for(10s) > 0) {
    }
    EXPECT_EQ(answers, 5);
}

TEST(Class3, TellsNonsense) {
    Opened opened;
    FakeServer server(class3(
        opened, [](const auto&) { return true; },
        [&](Peer& peer, const enip::Frame& frame) {
            enip::Frame reply;
            reply.command = enip::Command::send_unit_data;
            switch (peer.count++) {
                case 0:
                    reply.data = hex("00 00");
                    break;
                case 1:
                    reply.status = enip::EncapsulationStatus::invalid_session;
                    break;
                default:
                    answer(peer, opened, sent_in(frame).sequence, {cip::service::reset, {}, {}});
                    return;
            }
            peer.send(reply);
        }));
    Session session(server);
    EXPECT_EQ(session.open(), error_code());
    EXPECT_EQ(session.call(), make_error_code(Error::malformed_packet));
    EXPECT_EQ(session.call(), make_error_code(enip::EncapsulationStatus::invalid_session));
    EXPECT_EQ(session.call(), make_error_code(Error::wrong_service));
}

TEST(Class3, RefusesAReplyToAnotherOpen) {
    FakeServer server(answering([](const cip::Request& request) {
        auto open = *cip::ForwardOpen::parse(request.data, true);
        ++open.triad.serial_number;
        return open_reply(open, request.service);
    }));
    Session session(server);
    EXPECT_EQ(session.open(), make_error_code(Error::unexpected_data));
}

}  // namespace
}  // namespace servobus::scanner
