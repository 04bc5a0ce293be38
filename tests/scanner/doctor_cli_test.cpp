// `servobus-scanner doctor FILE`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/scanner/run_scanner.hpp"
#include "tests/scanner/sample_capture.hpp"

namespace servobus::scanner {
namespace {

using namespace test;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class DoctorVerb : public testing::Test {
protected:
    ~DoctorVerb() override { std::filesystem::remove(file_); }

    test::Run doctor(const std::string& text, bool as_json = false) {
        std::ofstream(file_, std::ios::binary) << text;
        std::vector<std::string> words{"doctor", file_};
        if (as_json) words.emplace_back("--json");
        return run_scanner(words);
    }

    /// The owner of scene 6, and `count` datagrams each way, with what the caller does to them.
    static void flow(SampleCapture& sample, unsigned count, std::size_t o_to_t_size = 24, bool run = true) {
        sample.golden(6, "fo_");
        const auto open = test::read(sample.text()).conversation.opens().at(0);
        cip::Bytes out(o_to_t_size);
        out[0] = run ? 1 : 0;
        for (std::uint32_t i = 1; i <= count; ++i) {
            sample.io(true, io_datagram(open.reply->o_to_t_id, i, out));
            sample.wait(1ms);
            sample.io(false, io_datagram(open.reply->t_to_o_id, i, cip::Bytes(28)), open.expected_receiver());
            sample.wait(9ms);
        }
    }

    std::string file_ =
        testing::TempDir() + "doctor_" + testing::UnitTest::GetInstance()->current_test_info()->name() + ".pcapng";
};

TEST_F(DoctorVerb, SaysThatAllIsWell) {
    SampleCapture sample;
    flow(sample, 100);
    const auto run = doctor(sample.text());
    EXPECT_EQ(run.code, 0) << run.out;
    EXPECT_THAT(run.out, HasSubstr("granted, and data flows"));
    EXPECT_THAT(run.out, HasSubstr("O->T  100      0     0     0           10 ms    10 ms"));
    EXPECT_EQ(run.err, "");
    const auto document = json::parse(doctor(sample.text(), true).out);
    const auto& open = document.at("opens").at(0);
    EXPECT_TRUE(open.at("granted").get<bool>());
    EXPECT_TRUE(open.at("diagnosis").at("well").get<bool>());
    EXPECT_TRUE(open.at("diagnosis").at("corrected").is_null());
    EXPECT_EQ(open.at("t_to_o").at("packets"), 100);
    EXPECT_DOUBLE_EQ(open.at("t_to_o").at("mean_ms"), 10);
    EXPECT_TRUE(document.at("damage").is_null());
}

TEST_F(DoctorVerb, ExplainsARefusal) {
    SampleCapture sample;
    sample.golden(13, "fo_bad_t2o_size");
    const auto run = doctor(sample.text());
    EXPECT_EQ(run.code, 4);
    EXPECT_THAT(run.out, HasSubstr("192.168.2.10:50000 opens a connection to 192.168.2.100:44818"));
    EXPECT_THAT(run.out, HasSubstr("T->O size 34 asked, 30 expected: 28 of assembly 100 + 2 sequence count."));
    EXPECT_THAT(run.out, HasSubstr("servobus-scanner io 192.168.2.100 --connection standard"));
    const auto json_run = doctor(sample.text(), true);
    EXPECT_EQ(json_run.code, 4);
    const auto open = json::parse(json_run.out).at("opens").at(0);
    EXPECT_EQ(open.at("status").at("extended"), json({0x0128, 30}));
    EXPECT_EQ(open.at("diagnosis").at("corrected").at("arguments").at(0), "192.168.2.100");
}

TEST_F(DoctorVerb, UsesTheIdentityThatTheCaptureHas) {
    SampleCapture sample;
    sample.golden(3);
    sample.golden(13, "fo_key_rev");
    const auto run = doctor(sample.text());
    EXPECT_THAT(run.out, HasSubstr("The key asks for major revision 2, and the device has 1."));
    EXPECT_THAT(run.out, HasSubstr("--key 1389/43/"));
}

TEST_F(DoctorVerb, SeesWhatDoesNotFlow) {
    SampleCapture idle;
    flow(idle, 10, 24, false);
    EXPECT_THAT(doctor(idle.text()).out, HasSubstr("the originator is idle all the time"));
    SampleCapture sized;
    flow(sized, 10, 20);
    const auto run = doctor(sized.text());
    EXPECT_EQ(run.code, 4);
    EXPECT_THAT(run.out, HasSubstr("O->T datagrams have 22 octets and not 26"));
    SampleCapture silent;
    silent.golden(6, "fo_");
    silent.wait(1s);
    silent.say(true, servobus::test::find_golden_vector("fo_short_req")->octets);
    EXPECT_THAT(doctor(silent.text()).out, HasSubstr("no T->O datagram came"));
    EXPECT_THAT(doctor(silent.text()).out, HasSubstr("the Forward_Open was not answered"));
}

TEST_F(DoctorVerb, ReadsWhatStandsBeforeTheDamage) {
    SampleCapture sample;
    sample.golden(13, "fo_bad_t2o_size");
    const auto run = doctor(sample.text() + "more");
    EXPECT_EQ(run.code, 2);
    EXPECT_THAT(run.out, HasSubstr("T->O size 34 asked"));
    EXPECT_THAT(run.err, HasSubstr("the file ends in the header of a block; what stands before it was read"));
}

TEST_F(DoctorVerb, RefusesWhatIsNoCapture) {
    const auto run = doctor("this is no capture");
    EXPECT_EQ(run.code, 2);
    EXPECT_THAT(run.err, HasSubstr("octet 0: the file is neither pcapng nor pcap"));
    EXPECT_EQ(run_scanner({"doctor", "/nowhere/at.all"}).code, 2);
    EXPECT_EQ(run_scanner({"doctor"}).code, 2);
    const auto document = json::parse(doctor("", true).out);
    EXPECT_EQ(document.at("error").at("exit_code"), 2);
}

TEST_F(DoctorVerb, FindsNothingInACaptureWithoutOpens) {
    SampleCapture sample;
    sample.golden(3);
    const auto run = doctor(sample.text());
    EXPECT_EQ(run.code, 0);
    EXPECT_THAT(run.out, HasSubstr("There is no Forward_Open in this capture."));
}

}  // namespace
}  // namespace servobus::scanner
