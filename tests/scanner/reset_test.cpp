// `reset` and devices that do what a test wants: refuse, go without a word, stay away, come back as somebody else.
#include "scanner/cli/reset.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cip/services.hpp"
#include "cip/strings.hpp"
#include "cip/wire.hpp"
#include "tests/scanner/fake_server.hpp"
#include "tests/scanner/run_scanner.hpp"

namespace servobus::scanner::cli {
namespace {

using namespace test;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// A device with an Identity and, if it is to have one, an address; it may close the connection instead of an answer.
struct FakeDevice {
    std::uint32_t serial_number = 0x00A1B2C3;
    std::uint32_t serial_number_afterwards = 0x00A1B2C3;
    std::atomic<cip::GeneralStatus> answer = cip::GeneralStatus::success;
    bool goes_without_a_word = false;
    bool stays_away = false;
    bool has_address = true;

    std::atomic<int> resets = 0;
    std::atomic<int> type = -1;

    void on_frame(Peer& peer, const enip::Frame& frame) {
        if (stays_away && resets > 0) return peer.close();
        if (frame.command == enip::Command::register_session) return peer.send(registered(frame));
        if (frame.command != enip::Command::send_rr_data) return;
        const auto request = request_in(frame);
        if (request.service != cip::service::reset) return peer.send(reply_with(frame, response(request)));
        type = request.data.empty() ? -1 : request.data[0];
        const cip::Status status = answer.load();
        if (status.ok()) ++resets;
        if (!goes_without_a_word) peer.send(reply_with(frame, cip::Response{request.service, status, {}}));
        if (status.ok()) peer.close();
    }

    cip::Response response(const cip::Request& request) const {
        cip::Response response{request.service, {}, {}};
        cip::Writer value(response.data);
        const bool is_identity = request.path == cip::Path::to(1, 1);
        if (is_identity && request.service == cip::service::get_attributes_all) {
            value.u16(1389);
            value.u16(43);
            value.u16(0x7509);
            value.u8(1);
            value.u8(2);
            value.u16(0x0030);
            value.u32(resets > 0 ? serial_number_afterwards : serial_number);
            cip::write_short_string(value, "press\x1B");
            value.u8(3);
        } else if (has_address && request.path == cip::Path::to(0xF5, 1, 3)) {
            value.u32(resets > 0 ? 2 : 0);
        } else if (has_address && request.path == cip::Path::to(0xF5, 1, 5)) {
            for (const auto word : {0xC0A80264U, 0xFFFFFF00U, 0U, 0U, 0U}) value.u32(word);
            value.u16(0);
        } else {
            response.status = cip::GeneralStatus::path_destination_unknown;
        }
        return response;
    }
};

class ResetVerb : public testing::Test {
protected:
    test::Run reset(std::vector<std::string> options = {}, std::istream* person = nullptr) {
        std::vector<std::string> arguments{"reset", server_.host()};
        arguments.insert(arguments.end(), options.begin(), options.end());
        return run_scanner(arguments, {.person = person});
    }
    test::Run answered(const std::string& answer, std::vector<std::string> options = {}) {
        std::istringstream person(answer);
        return reset(std::move(options), &person);
    }

    FakeDevice device_;
    FakeServer server_{[this](Peer& peer, const enip::Frame& frame) { device_.on_frame(peer, frame); }};
};

TEST_F(ResetVerb, AsksAndSaysWhichDeviceItIsAndWhatIsLost) {
    const auto result = answered("y\n", {"--factory"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_THAT(result.err,
                AllOf(HasSubstr("press\\x1B, product code 0x7509, serial number 0x00A1B2C3, at " + server_.host() +
                                " (static address)"),
                      HasSubstr("Everything that has been set is lost"), HasSubstr("DHCP"), HasSubstr("[y/N]")));
    EXPECT_EQ(device_.resets, 1);
    EXPECT_EQ(device_.type, 1);
    EXPECT_THAT(result.out, AllOf(StartsWith("press\\x1B is back after "), HasSubstr("revision 1.2"),
                                  HasSubstr("192.168.2.100, address by DHCP\n")));
}

TEST_F(ResetVerb, DoesNothingWithoutAYes) {
    for (const auto* answer : {"n\n", "\n", "", "yess\n", "no\n"}) {
        const auto result = answered(answer);
        EXPECT_EQ(result.code, 2) << answer;
        EXPECT_THAT(result.err, HasSubstr("nothing was reset"));
        EXPECT_THAT(result.out, IsEmpty());
    }
    EXPECT_EQ(device_.resets, 0);
    EXPECT_EQ(answered("yes\n").code, 0);
    EXPECT_EQ(device_.resets, 1);
}

TEST_F(ResetVerb, SaysWhatEachKindDoes) {
    EXPECT_THAT(answered("n\n").err, HasSubstr("What is stored is kept"));
    EXPECT_THAT(answered("n\n", {"--factory-keep-network"}).err, HasSubstr("lost but for the network settings"));
}

TEST_F(ResetVerb, AsksNobodyWhereNobodyIs) {
    const auto result = reset();
    EXPECT_EQ(result.code, 2);
    EXPECT_THAT(result.err, HasSubstr("--yes"));
    EXPECT_THAT(server_.seen(), IsEmpty()) << "nothing was sent";
}

TEST_F(ResetVerb, SendsTheTypeOfItsKind) {
    for (const auto& [options, type] : {std::pair(std::vector<std::string>{"--yes"}, 0),
                                        {{"--yes", "--factory"}, 1},
                                        {{"--yes", "--factory-keep-network"}, 2}}) {
        EXPECT_EQ(reset(options).code, 0);
        EXPECT_EQ(device_.type, type);
    }
    EXPECT_EQ(reset({"--yes", "--factory", "--factory-keep-network"}).code, 2);
    EXPECT_EQ(reset({"--yes", "--wait", "3", "--no-wait"}).code, 2);
    EXPECT_EQ(device_.resets, 3);
}

TEST_F(ResetVerb, TellsARefusalInWords) {
    device_.answer = cip::GeneralStatus::device_state_conflict;
    auto result = reset({"--yes"});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.err, AllOf(HasSubstr("refused with 0x10"), HasSubstr("an owner runs it")));
    device_.answer = cip::GeneralStatus::invalid_parameter;
    result = reset({"--yes", "--factory-keep-network"});
    EXPECT_EQ(result.code, 4);
    EXPECT_THAT(result.err, AllOf(HasSubstr("0x20"), HasSubstr("does not have this kind of reset")));
    device_.answer = cip::GeneralStatus::store_operation_failure;
    result = reset({"--yes", "--json"});
    EXPECT_EQ(result.code, 4);
    EXPECT_EQ(json::parse(result.out)["error"]["general"], 0x19);
}

TEST_F(ResetVerb, TakesADeviceThatGoesWithoutAWord) {
    device_.goes_without_a_word = true;
    EXPECT_EQ(reset({"--yes"}).code, 0);
    EXPECT_EQ(device_.resets, 1);
}

TEST_F(ResetVerb, WaitsNoLongerThanItIsTold) {
    device_.stays_away = true;
    const auto begin = std::chrono::steady_clock::now();
    const auto result = reset({"--yes", "--factory", "--wait", "0.6"});
    EXPECT_EQ(result.code, 3);
    EXPECT_THAT(result.err, HasSubstr("did not answer at 127.0.0.1:"));
    EXPECT_THAT(result.err, HasSubstr("within 0.6 s"));
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
}

TEST_F(ResetVerb, DoesNotWaitWhenItIsTold) {
    device_.stays_away = true;
    const auto result = reset({"--yes", "--no-wait"});
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.out, "press\\x1B restarts\n");
}

TEST_F(ResetVerb, NoticesThatAnotherDeviceHasTheAddress) {
    device_.serial_number_afterwards = 7;
    const auto result = reset({"--yes"});
    EXPECT_EQ(result.code, 5);
    EXPECT_THAT(result.err, HasSubstr("another device answers there now: press\\x1B, product code 0x7509, serial "
                                      "number 0x00000007"));
}

TEST_F(ResetVerb, TellsProgramsBothStates) {
    const auto result = reset({"--yes", "--factory", "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    const auto document = json::parse(result.out);
    EXPECT_EQ(document["host"], server_.host());
    EXPECT_EQ(document["reset"], json::parse(R"({"type":1,"name":"factory"})"));
    EXPECT_EQ(document["before"]["serial_number"], 0x00A1B2C3);
    EXPECT_EQ(document["before"]["address_method"], 0);
    EXPECT_EQ(document["after"]["address_method"], 2);
    EXPECT_EQ(document["after"]["address"], "192.168.2.100");
    EXPECT_TRUE(document["away_ms"].is_number_unsigned());
}

TEST_F(ResetVerb, NeedsNoTcpIpObject) {
    device_.has_address = false;
    const auto result = reset({"--yes", "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(json::parse(result.out)["after"]["address"].is_null());
    EXPECT_TRUE(json::parse(result.out)["after"]["address_method"].is_null());
}

}  // namespace
}  // namespace servobus::scanner::cli
