// The command line as a person or a program meets it: arguments in; data, messages and exit code out.
#include "scanner/cli/run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "cip/services.hpp"
#include "cip/wire.hpp"
#include "tests/scanner/fake_server.hpp"
#include "tests/scanner/run_scanner.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace std::chrono_literals;
using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// Every message is a line of its own that says who speaks.
void expect_clear(const std::string& err) {
    EXPECT_THAT(err, StartsWith("servobus-scanner: "));
    EXPECT_TRUE(err.ends_with('\n'));
}

cip::Response number(const cip::Request& request, std::uint32_t value) {
    cip::Response response{request.service, {}, {}};
    cip::Writer(response.data).u32(value);
    return response;
}

cip::Response refusal(const cip::Request& request, cip::Status status) {
    return {request.service, std::move(status), {}};
}

FakeServer::Script always(std::uint32_t value) {
    return answering([value](const cip::Request& request) { return number(request, value); });
}

TEST(Run, RefusesWrongUsage) {
    const std::vector<std::vector<std::string>> mistakes{
        {},
        {"fetch"},
        {"get"},
        {"get", "127.0.0.1"},
        {"get", "127.0.0.1:0", "SCurve"},
        {"get", "", "SCurve"},
        {"get", "300.0.0.1", "SCurve"},
        {"get", "127.0.0.1", "SCurv"},
        {"get", "127.0.0.1", "0x64/1"},
        {"get", "127.0.0.1", "SCurve", "--route", "1"},
        {"get", "127.0.0.1", "SCurve", "--route", ""},
        {"get", "127.0.0.1", "SCurve", "--timeout", "0"},
        {"get", "127.0.0.1", "SCurve", "--timeout", "-1"},
        {"get", "127.0.0.1", "SCurve", "--timeout", "nan"},
        {"get", "127.0.0.1", "SCurve", "--timeout", "inf"},
        {"get", "127.0.0.1", "SCurve", "--timeout", "soon"},
        {"get", "127.0.0.1", "SCurve", "--timeout"},
        {"get", "127.0.0.1", "SCurve", "--colour"},
        {"set", "127.0.0.1", "SCurve"},
        {"set", "127.0.0.1", "SCurve=abc"},
        {"set", "127.0.0.1", "SCurve=99999999999"},
        {"set", "127.0.0.1", "0x01/1/1=5"},
        {"set", "127.0.0.1", "0x01/1/1=hex:5"},
        {"command", "127.0.0.1"},
        {"command", "127.0.0.1", "REFF"},
        {"command", "127.0.0.1", "REF", "PQ"},
        {"call", "127.0.0.1", "0x0E"},
        {"call", "127.0.0.1", "0x80", "1/1"},
        {"call", "127.0.0.1", "Get_Everything", "1/1"},
        {"call", "127.0.0.1", "0x0E", "1"},
        {"call", "127.0.0.1", "0x0E", "hex:2"},
        {"call", "127.0.0.1", "0x10", "1/1/1", "5"},
        {"call", "127.0.0.1", "0x10", "1/1/1", "zz"},
        {"discover", "--host", "a b"},
        {"discover", "--wait", "0"},
        {"discover", "--wait", "x"},
        {"discover", "--port", "65536"},
        {"discover", "--route", "1/0"},
        {"identity"},
        {"dump"},
        {"dump", "host", "more"},
        {"list", "qqqqqqqqq"},
        {"list", "--commands", "qqqqqqqqq"},
        {"completion"},
        {"completion", "tcsh"},
    };
    for (const auto& arguments : mistakes) {
        const auto result = run_scanner(arguments);
        const auto shown = testing::PrintToString(arguments);
        EXPECT_EQ(result.code, 2) << shown;
        EXPECT_THAT(result.out, IsEmpty()) << shown;
        expect_clear(result.err);
        EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << shown << result.err;
    }
}

TEST(Run, TellsMistakesInJsonToo) {
    const auto result = run_scanner({"get", "127.0.0.1", "SCurv", "--json"});
    EXPECT_EQ(result.code, 2);
    const auto document = json::parse(result.out);
    EXPECT_EQ(document["error"]["kind"], "usage");
    EXPECT_EQ(document["error"]["exit_code"], 2);
    EXPECT_THAT(document["error"]["text"].get<std::string>(), HasSubstr("did you mean SCurve"));
    EXPECT_EQ(json::parse(run_scanner({"--json", "fetch"}).out)["error"]["kind"], "usage");
}

TEST(Run, HelpsWithExamplesForEveryVerb) {
    const auto help = run_scanner({"--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_THAT(help.out, AllOf(HasSubstr("Exit codes:"), HasSubstr("  5  the device's answer makes no sense")));
    for (const std::string verb :
         {"discover", "identity", "get", "set", "dump", "command", "call", "axis", "list", "completion"}) {
        EXPECT_THAT(help.out, HasSubstr("  " + verb));
        const auto result = run_scanner({verb, "--help"});
        EXPECT_EQ(result.code, 0);
        EXPECT_THAT(result.out, AllOf(HasSubstr("Examples:"), HasSubstr("servobus-scanner " + verb)));
        EXPECT_THAT(result.err, IsEmpty());
    }
    EXPECT_THAT(run_scanner({"--version"}).out, StartsWith("servobus-scanner "));
}

TEST(Run, GetsValues) {
    FakeServer server(always(20));
    const auto text = run_scanner({"get", server.host(), "SCurve", "0x99/1/1"});
    EXPECT_EQ(text.code, 0);
    EXPECT_EQ(text.out, "SCurve = 20 %  (CIP 0x64/1/0x00, CANopen 0x2000:00)\n0x99/1/0x01 = 14 00 00 00\n");
    EXPECT_THAT(text.err, IsEmpty());

    const auto document = run_scanner({"--json", "get", server.host(), "SCurve"});
    EXPECT_EQ(document.code, 0);
    EXPECT_EQ(json::parse(document.out)["values"][0]["value"], 20);
    EXPECT_EQ(json::parse(document.out)["host"], server.host());
}

TEST(Run, TakesOptionsBeforeAndBehindTheVerb) {
    FakeServer server(answering([](const cip::Request& request) {
        EXPECT_EQ(request.service, cip::service::unconnected_send);
        cip::Response response{cip::service::get_attribute_single, {}, {1, 0, 0, 0}};
        return response;
    }));
    for (const auto& arguments :
         {std::vector<std::string>{"--route", "1/0", "--timeout", "2", "get", server.host(), "SCurve"},
          std::vector<std::string>{"get", "--route=1/0", server.host(), "SCurve", "--timeout=2"}}) {
        EXPECT_EQ(run_scanner(arguments).code, 0);
    }
}

TEST(Run, GoesOnAfterARefusedRead) {
    FakeServer server(answering([](const cip::Request& request) {
        if (request.path == cip::Path::to(0x64, 1, 0))
            return refusal(request, cip::GeneralStatus::attribute_not_supported);
        return number(request, 7);
    }));
    const auto result = run_scanner({"get", server.host(), "SCurve", "TS"});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.out, StartsWith("TellStatus = 7 "));
    EXPECT_EQ(result.err, "servobus-scanner: SCurve: refused with 0x14 attribute not supported\n");
}

TEST(Run, SetsInOrderAndStopsAtARefusal) {
    FakeServer server(answering([](const cip::Request& request) {
        EXPECT_EQ(request.service, cip::service::set_attribute_single);
        if (request.data == hex("F4 01 00 00")) return refusal(request, cip::GeneralStatus::invalid_attribute_value);
        return cip::Response{request.service, {}, {}};
    }));
    const auto good = run_scanner({"set", server.host(), "SCurve=35", "@0xF5/1/13=UINT:60"});
    EXPECT_EQ(good.code, 0);
    EXPECT_EQ(good.out, "SCurve = 35 %  (CIP 0x64/1/0x00, CANopen 0x2000:00)\n0xF5/1/0x0D = 3C 00\n");

    const auto bad = run_scanner({"set", server.host(), "SCurve=500", "SID=x"});
    EXPECT_EQ(bad.code, 4);
    EXPECT_THAT(bad.out, IsEmpty());
    EXPECT_THAT(bad.err, AllOf(HasSubstr("SCurve: refused with 0x09 invalid attribute value; it takes 1 to 100 %"),
                               HasSubstr("ServoIdentificationString: not set")));
    EXPECT_EQ(std::ranges::count(server.commands(), enip::Command::send_rr_data), 3);
}

TEST(Run, SendsNothingWhenAnyValueIsWrong) {
    FakeServer server(always(0));
    EXPECT_EQ(run_scanner({"set", server.host(), "SCurve=35", "SCurve=x"}).code, 2);
    EXPECT_TRUE(server.seen().empty());
}

TEST(Run, GivesCommands) {
    FakeServer server(answering([](const cip::Request& request) {
        EXPECT_EQ(request.encode(), hex("10 03 20 65 24 01 30 00 00 10 00 00"));
        return cip::Response{request.service, {}, {}};
    }));
    EXPECT_EQ(run_scanner({"command", server.host(), "ref"}).out, "REF Reference (0x1000): accepted\n");
    EXPECT_EQ(json::parse(run_scanner({"command", server.host(), "0x1000", "--json"}).out)["accepted"], true);
    const auto unknown = run_scanner({"command", server.host(), "REFE"});
    EXPECT_EQ(unknown.code, 2);
    EXPECT_THAT(unknown.err, HasSubstr("did you mean"));

    FakeServer refuses(answering([](const cip::Request& request) {
        return refusal(request, cip::Status(cip::GeneralStatus::vendor_specific, {1}));
    }));
    const auto result = run_scanner({"command", refuses.host(), "REF"});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.err, AllOf(HasSubstr("0x1F"), HasSubstr("0x0001")));
    EXPECT_EQ(json::parse(run_scanner({"command", refuses.host(), "REF", "--json"}).out)["error"]["general"], 0x1F);
}

TEST(Run, CallsAnyService) {
    FakeServer server(answering([](const cip::Request& request) {
        EXPECT_EQ(request.encode(), hex("4B 02 20 37 24 C8 01 02"));
        return cip::Response{request.service, {}, hex("AA BB")};
    }));
    const auto text = run_scanner({"call", server.host(), "Initiate_Upload", "0x37/200", "01", "02"});
    EXPECT_EQ(text.code, 0);
    EXPECT_THAT(text.out, AllOf(HasSubstr("0x00 success"), HasSubstr("AA BB")));
    const auto document =
        json::parse(run_scanner({"call", server.host(), "0x4b", "hex:203724C8", "0102", "--json"}).out);
    EXPECT_EQ(document["data"], "AA BB");
    EXPECT_EQ(document["service"]["code"], 0x4B);
    EXPECT_EQ(document["service"]["name"], "Initiate_Upload");
    EXPECT_EQ(document["status"]["general"], 0);

    FakeServer refuses(answering(
        [](const cip::Request& request) { return refusal(request, cip::ConnectionFailure::out_of_connections); }));
    const auto result = run_scanner({"call", refuses.host(), "0x54", "6/1"});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.err, AllOf(HasSubstr("0x01"), HasSubstr("0x0113 out of connections")));
}

TEST(Run, TellsWhoADeviceIs) {
    const auto all = hex("6D05 2B00 0975 01 02 3000 C3B2A100 05 58454E4158");
    FakeServer whole(answering([&](const cip::Request& request) {
        const bool asks_all = request.service == cip::service::get_attributes_all;
        EXPECT_TRUE(asks_all || request.path == cip::Path::to(1, 1, 8)) << "only what the list of all does not hold";
        return cip::Response{request.service, {}, asks_all ? all : hex("03")};
    }));
    const auto known = run_scanner({"identity", whole.host()}).out;
    EXPECT_THAT(known, HasSubstr("vendor         1389 Jenny Science AG\n"));
    EXPECT_THAT(known, HasSubstr("state          3 operational\n"));

    FakeServer stateless(answering([&](const cip::Request& request) {
        const bool asks_all = request.service == cip::service::get_attributes_all;
        return asks_all ? cip::Response{request.service, {}, all}
                        : refusal(request, cip::GeneralStatus::attribute_not_supported);
    }));
    const auto partly = run_scanner({"identity", stateless.host()});
    EXPECT_EQ(partly.code, 0);
    EXPECT_THAT(partly.out, HasSubstr("state          not told\n"));

    FakeServer single(answering([](const cip::Request& request) {
        if (request.service != cip::service::get_attribute_single) {
            return refusal(request, cip::GeneralStatus::service_not_supported);
        }
        const auto id = std::get<cip::LogicalSegment>(request.path.segments.at(2)).value;
        const std::array<std::string_view, 7> values{"0100", "0E00", "3600", "1401", "6031", "785634", "03414243"};
        if (id > values.size()) return refusal(request, cip::GeneralStatus::attribute_not_supported);
        return cip::Response{request.service, {}, hex(id == 6 ? "78563412" : values.at(id - 1))};
    }));
    const auto document = json::parse(run_scanner({"identity", single.host(), "--json"}).out);
    EXPECT_EQ(document["identity"]["vendor_name"], "Rockwell Automation");
    EXPECT_EQ(document["identity"]["serial_number"], 0x12345678);
    EXPECT_EQ(document["identity"]["product_name"], "ABC");
    EXPECT_TRUE(document["identity"]["state"].is_null());

    FakeServer none(answering(
        [](const cip::Request& request) { return refusal(request, cip::GeneralStatus::path_destination_unknown); }));
    EXPECT_EQ(run_scanner({"identity", none.host()}).code, 4);
    FakeServer cut(answering([](const cip::Request& request) {
        return cip::Response{request.service, {}, hex("6D 05")};
    }));
    EXPECT_EQ(run_scanner({"identity", cut.host()}).code, 5);
}

/// Answers Multiple_Service_Packet with one number for every request.
cip::Response packet_of_numbers(const cip::Request& request, std::uint32_t value) {
    cip::Reader reader(request.data);
    const std::size_t count = reader.u16();
    cip::Response reply{request.service, {}, {}};
    cip::Writer writer(reply.data);
    writer.u16(static_cast<std::uint16_t>(count));
    for (std::size_t i = 0; i < count; ++i) writer.u16(static_cast<std::uint16_t>(2 + 2 * count + 8 * i));
    for (std::size_t i = 0; i < count; ++i)
        writer.bytes(number({cip::service::get_attribute_single, {}, {}}, value).encode());
    return reply;
}

TEST(Run, DumpsInPackets) {
    FakeServer server(answering([](const cip::Request& request) {
        EXPECT_LE(request.encode().size(), 500U);
        if (request.service == cip::service::multiple_service_packet) return packet_of_numbers(request, 1);
        return number(request, 1);
    }));
    const auto result = run_scanner({"dump", server.host()});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.out, AllOf(HasSubstr("0x64 XENAX General Parameter (general)\n"), HasSubstr("0x6E Forceteq")));
    EXPECT_LT(server.seen().size(), 20U);
}

TEST(Run, DumpsOneByOneWhenThereAreNoPackets) {
    FakeServer server(answering([](const cip::Request& request) {
        if (request.service != cip::service::get_attribute_single) {
            return refusal(request, cip::GeneralStatus::service_not_supported);
        }
        if (request.path == cip::Path::to(0x64, 1, 0))
            return refusal(request, cip::GeneralStatus::device_state_conflict);
        return number(request, 0);
    }));
    const auto result = run_scanner({"dump", server.host(), "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    const auto document = json::parse(result.out);
    EXPECT_EQ(document["values"].size(), 250U);
    EXPECT_EQ(document["values"][0]["error"]["general"], 0x10);
    EXPECT_EQ(document["values"][0]["high"], 100);
    EXPECT_EQ(document["values"][1]["value"], 0);
    EXPECT_GT(server.seen().size(), 200U);
}

TEST(Run, DumpsOneByOneWhenPacketsAreBroken) {
    FakeServer server(answering([](const cip::Request& request) { return number(request, 0); }));
    const auto result = run_scanner({"dump", server.host()});
    EXPECT_EQ(result.code, 0);
    EXPECT_THAT(result.err, HasSubstr("Multiple_Service_Packet"));
}

TEST(Run, SaysWhenADumpIsRefusedOrBreaks) {
    FakeServer refuses(answering(
        [](const cip::Request& request) { return refusal(request, cip::GeneralStatus::path_destination_unknown); }));
    const auto refused = run_scanner({"dump", refuses.host()});
    EXPECT_EQ(refused.code, 4);
    EXPECT_THAT(refused.out, HasSubstr("refused: 0x05 path destination unknown"));

    FakeServer breaks(after_registration([](Peer& peer, const enip::Frame& frame) {
        if (peer.count++ < 2) {
            peer.send(reply_with(frame, packet_of_numbers(request_in(frame), 1)));
        } else {
            peer.close();
        }
    }));
    const auto broken = run_scanner({"dump", breaks.host(), "--json"});
    EXPECT_EQ(broken.code, 3);
    EXPECT_EQ(json::parse(broken.out)["error"]["kind"], "no_connection");
}

TEST(Run, EndsWithThreeWithoutAnAnswer) {
    FakeServer silent([](Peer&, const enip::Frame&) {});
    FakeServer deaf(after_registration([](Peer&, const enip::Frame&) {}));
    FakeServer slow(after_registration([](Peer& peer, const enip::Frame& frame) {
        peer.trickle(reply_with(frame, number(request_in(frame), 1)).encode(), 50ms);
    }));
    for (const auto* server : {&silent, &deaf, &slow}) {
        const auto begin = std::chrono::steady_clock::now();
        const auto result = run_scanner({"get", server->host(), "SCurve", "TS", "--timeout", "0.3"});
        EXPECT_EQ(result.code, 3);
        EXPECT_THAT(result.err, HasSubstr("did not answer within 0.3 s"));
        EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
    }
    std::string gone;
    {
        gone = FakeServer([](Peer&, const enip::Frame&) {}).host();
    }
    const auto refused = run_scanner({"get", gone, "SCurve", "--json"});
    EXPECT_EQ(refused.code, 3);
    EXPECT_THAT(refused.err, HasSubstr("connection refused"));
    EXPECT_EQ(json::parse(refused.out)["error"]["kind"], "no_connection");

    const auto unknown = run_scanner({"get", "no-such-host.invalid", "SCurve", "--timeout", "2"});
    EXPECT_EQ(unknown.code, 3);

    FakeServer closes(after_registration([](Peer& peer, const enip::Frame&) { peer.close(); }));
    EXPECT_EQ(run_scanner({"get", closes.host(), "SCurve"}).code, 3);
}

TEST(Run, BoundsTheTimeOfAllRequestsTogether) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        std::this_thread::sleep_for(100ms);
        peer.send(reply_with(frame, number(request_in(frame), 1)));
    }));
    std::vector<std::string> arguments{"get", server.host(), "--timeout", "0.35"};
    for (int i = 0; i < 10; ++i) arguments.emplace_back("SCurve");
    const auto begin = std::chrono::steady_clock::now();
    const auto result = run_scanner(arguments);
    EXPECT_EQ(result.code, 3);
    EXPECT_THAT(result.out, StartsWith("SCurve = 1 %"));
    EXPECT_THAT(result.err, HasSubstr("SCurve: not asked any more"));
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s);
}

TEST(Run, EndsWithFourWhenTheEncapsulationRefuses) {
    FakeServer server(after_registration([](Peer& peer, const enip::Frame& frame) {
        peer.send(frame.reply(enip::EncapsulationStatus::invalid_session));
    }));
    const auto result = run_scanner({"get", server.host(), "SCurve"});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.err, AllOf(HasSubstr("0x0064"), HasSubstr("invalid session handle")));

    FakeServer no_session([](Peer& peer, const enip::Frame& frame) {
        peer.send(frame.reply(enip::EncapsulationStatus::unsupported_protocol));
    });
    EXPECT_EQ(run_scanner({"get", no_session.host(), "SCurve"}).code, 4);
}

TEST(Run, EndsWithFiveOnNonsense) {
    FakeServer http([](Peer& peer, const enip::Frame&) { peer.send(cip::Bytes{'H', 'T', 'T', 'P', '/'}); });
    FakeServer service(answering([](const cip::Request&) { return cip::Response{cip::service::reset, {}, {}}; }));
    FakeServer packet(after_registration([](Peer& peer, const enip::Frame& frame) { peer.send(frame.reply()); }));
    FakeServer data(answering([](const cip::Request& request) { return cip::Response{request.service, {}, {1}}; }));
    for (const auto* server : {&http, &service, &packet, &data}) {
        const auto result = run_scanner({"get", server->host(), "SCurve"});
        EXPECT_EQ(result.code, 5) << result.err;
        expect_clear(result.err);
    }
    EXPECT_EQ(run_scanner({"discover", "--host", http.host(), "--wait", "100"}).code, 5);
}

TEST(Run, WarnsAboutSurplusOctets) {
    FakeServer server(answering([](const cip::Request& request) {
        return cip::Response{request.service, {}, {20, 0, 0, 0, 1}};
    }));
    const auto result = run_scanner({"get", server.host(), "SCurve"});
    EXPECT_EQ(result.code, 0);
    EXPECT_THAT(result.out, StartsWith("SCurve = 20 %"));
    EXPECT_THAT(result.err, HasSubstr("1 surplus octets"));
}

TEST(Run, SaysWhenAConnectionIsRefused) {
    FakeServer server(answering(
        [](const cip::Request& request) { return refusal(request, cip::GeneralStatus::service_not_supported); }));
    const auto result = run_scanner({"get", server.host(), "SCurve", "--connected", "--json"});
    EXPECT_EQ(result.code, 4);
    EXPECT_EQ(json::parse(result.out)["error"]["general"], 8);
    EXPECT_THAT(result.err, HasSubstr("refused the connection: 0x08 service not supported"));
}

TEST(Run, SaysWhenNobodyIsFound) {
    const auto result = run_scanner({"discover", "--port", "1", "--wait", "50"});
    EXPECT_EQ(result.code, 3);
    EXPECT_THAT(result.err, HasSubstr("try a longer --wait"));
    const auto document = json::parse(run_scanner({"discover", "--port", "1", "--wait", "50", "--json"}).out);
    EXPECT_TRUE(document["devices"].empty());
    EXPECT_EQ(document["error"]["exit_code"], 3);
}

}  // namespace
}  // namespace servobus::scanner::cli
