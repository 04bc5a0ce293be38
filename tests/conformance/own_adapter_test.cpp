// The conformance suite against our own adapter, as a process: each variant passes all of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tests/scanner/run_scanner.hpp"
#include "tests/scanner/running_adapter.hpp"

namespace servobus::scanner::test {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

/// What is about time may be spoilt by a busy machine, and then is an advisory.
const std::set<std::string> about_time{"ENC-37", "UCM-55", "ETH-07", "PRD-09", "PRD-10", "TMO-04", "TMO-05"};

const Words spoken{"encapsulation", "sessions", "packet", "ucmm", "class3", "objects", "keys", "malformed"};
const Words connected{"forward-open", "null-open", "forward-close", "ownership", "multicast"};
const Words produced{"production"};
const Words waited{"timeouts", "inactivity"};

/// What our adapter does not have, and so cannot be tried.
const std::set<std::string> absent_objects{"MRO-01", "MRO-02", "TCP-13", "ETH-11",
                                           "TSY-01", "TSY-02", "TSY-03", "PRD-12"};

/// What its data sheet does not tell of, beside those.
const std::set<std::string> not_in_the_sheet{"FWO-03", "FWR-49", "OWN-01", "OWN-02", "OWN-03"};

class OwnAdapter : public RunningAdapter {
protected:
    void passes(const Words& groups, const Words& more = {}, const std::set<std::string>& absent = absent_objects) {
        Words words{"conformance", host, "--json", "-"};
        words.insert(words.end(), more.begin(), more.end());
        for (const auto& group : groups) words.insert(words.end(), {"--group", group});
        const auto run = run_scanner(words);
        EXPECT_EQ(run.code, 0) << run.err;
        const auto document = Json::parse(run.out, nullptr, false);
        ASSERT_FALSE(document.is_discarded()) << run.out;
        EXPECT_FALSE(document["results"].empty());
        for (const auto& result : document["results"]) {
            const auto id = result["id"].get<std::string>();
            const auto outcome = result["outcome"].get<std::string>();
            if (outcome == "skipped") {
                const bool asks = result["reason"] == "needs --allow-writes" && !document["writes"].get<bool>();
                EXPECT_TRUE(absent.contains(id) || asks) << id << " is skipped: " << result["reason"];
            } else if (outcome == "advisory") {
                EXPECT_TRUE(about_time.contains(id)) << result.dump(2);
            } else {
                EXPECT_EQ(outcome, "pass") << result.dump(2);
            }
        }
        std::printf("%s: %s in %.1f s\n", host.c_str(), document["counts"].dump().c_str(),
                    document["milliseconds"].get<double>() / 1000);
    }
};

class EachVariant : public OwnAdapter, public testing::WithParamInterface<const char*> {
protected:
    void SetUp() override {
        options = {"--variant", GetParam()};
        OwnAdapter::SetUp();
    }
};

TEST_P(EachVariant, SpeaksByTheRules) { passes(spoken, {"--allow-writes"}); }
TEST_P(EachVariant, ConnectsByTheRules) { passes(connected, {"--allow-writes"}); }

INSTANTIATE_TEST_SUITE_P(Xenax, EachVariant, testing::Values("75v8s", "75v8", "48v8"),
                         [](const auto& row) { return "Of" + std::string(row.param); });

// How it keeps time does not depend on the variant.
TEST_F(OwnAdapter, ProducesByTheRules) { passes(produced, {"--allow-writes"}); }
TEST_F(OwnAdapter, WaitsByTheRules) { passes(waited, {"--allow-writes"}); }

TEST_F(OwnAdapter, PassesReadOnly) {
    auto groups = spoken;
    groups.insert(groups.end(), connected.begin(), connected.end());
    passes(groups);
}

TEST_F(OwnAdapter, PassesByItsDataSheet) {
    const auto sheet = file(".eds");
    ASSERT_EQ(run_scanner({"eds", "upload", host, "-o", sheet, "--force"}).code, 0);
    passes(connected, {"--allow-writes", "--eds", sheet}, not_in_the_sheet);
    std::filesystem::remove(sheet);
}

TEST_F(OwnAdapter, PassesByTheNumbersOfAConnection) {
    passes({"forward-close"},
           {"--o2t", "254", "--o2t-size", "0", "--t2o", "100", "--t2o-size", "28", "--config-instance", "1"});
}

TEST_F(OwnAdapter, IsAsItWasAfterwards) {
    const auto before = run_scanner({"dump", host, "--json"});
    const auto network = [&] {
        return run_scanner({"call", host, "0x01", "0xF5/1"}).out + run_scanner({"get", host, "@0x48/1/8"}).out;
    };
    const auto settings = network();
    ASSERT_EQ(run_scanner({"conformance", host, "--allow-writes", "--group", "objects", "--group", "ucmm"}).code, 0);
    EXPECT_EQ(network(), settings);
    EXPECT_EQ(run_scanner({"identity", host}).code, 0);
    EXPECT_EQ(before.code, run_scanner({"dump", host, "--json"}).code);
}

}  // namespace
}  // namespace servobus::scanner::test
