// The Forward-Open doctor: each refusal in words, with its likely cause and the plan that would do.
#include "scanner/open_doctor.hpp"

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "assemblies/connection.hpp"
#include "scanner/connection_path.hpp"
#include "scanner/open_causes.hpp"
#include "scanner/plan_arguments.hpp"
#include "tests/scanner/sample_capture.hpp"

namespace servobus::scanner {
namespace {

using namespace test;
using cip::GeneralStatus;
using std::chrono::microseconds;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

IoPlan known(std::string_view key = "standard") { return plan_of(*assemblies::find_connection(key)); }

/// Of nobody we know.
IoPlan foreign() {
    IoPlan plan;
    plan.configuration_instance = 5;
    plan.o_to_t.point = 150;
    plan.o_to_t.data_octets = 8;
    plan.t_to_o.point = 160;
    plan.t_to_o.data_octets = 16;
    return plan;
}

cip::ForwardOpen request_of(const IoPlan& plan) { return plan.forward_open(1, 2, {3, 4, 5}); }

cip::Status failure(std::uint16_t word, std::vector<std::uint16_t> more = {}) {
    more.insert(more.begin(), word);
    return {GeneralStatus::connection_failure, more};
}

Diagnosis refused(const cip::ForwardOpen& request, const cip::Status& status, std::optional<Identity> identity = {}) {
    OpenQuestion question;
    question.request = request;
    question.identity = std::move(identity);
    return diagnose_refusal(question, status);
}

Identity xenax() {
    Identity identity;
    identity.vendor = 1389;
    identity.device_type = 43;
    identity.product_code = 0x7509;
    identity.major_revision = 1;
    identity.minor_revision = 2;
    return identity;
}

// --- the golden refusals, as they come out of a capture

struct Refusal {
    std::string_view name;
    std::string_view cause;  ///< a part of the first one
    std::string_view command;
};

class GoldenRefusal : public testing::TestWithParam<Refusal> {};

TEST_P(GoldenRefusal, HasItsCauseAndTheCommandThatWouldDo) {
    SampleCapture sample;
    sample.golden(13, std::string(GetParam().name));
    const auto capture = test::read(sample.text());
    ASSERT_EQ(capture.conversation.opens().size(), 1U);
    const auto& open = capture.conversation.opens()[0];
    OpenQuestion question;
    question.request = open.request;
    const auto diagnosis = diagnose_refusal(question, open.status);
    EXPECT_FALSE(diagnosis.well);
    ASSERT_THAT(diagnosis.causes, Not(IsEmpty()));
    EXPECT_THAT(diagnosis.causes.front(), HasSubstr(std::string(GetParam().cause)));
    const auto command = diagnosis.corrected ? command_line(*diagnosis.corrected, "D") : "";
    EXPECT_EQ(command, GetParam().command);
}

INSTANTIATE_TEST_SUITE_P(
    Scene13, GoldenRefusal,
    testing::Values(
        Refusal{"fo_bad_o2t_size", "forgot the 2 octets of the sequence count",
                "servobus-scanner io D --connection standard --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_bad_t2o_size", "run/idle header on the wrong side: T->O has none",
                "servobus-scanner io D --connection standard --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_bad_class", "Transport class 5 is none for I/O data",
                "servobus-scanner io D --connection standard --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_bad_point_re", "O->T point 99 does not exist; 101 goes with 100",
                "servobus-scanner io D --connection standard --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_bad_point_t_", "T->O point 99 does not exist; 100 goes with 101",
                "servobus-scanner io D --connection standard --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_rpi_small", "shorter than the device can keep",
                "servobus-scanner io D --connection standard --rpi 1 --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_rpi_zero", "An interval of 0 is none",
                "servobus-scanner io D --connection standard --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_key_vendor", "The key names vendor 77; a XENAX is of vendor 1389",
                "servobus-scanner io D --connection standard --multicast"},
        Refusal{"fo_key_type", "another device type", "servobus-scanner io D --connection standard --multicast"},
        Refusal{"fo_key_rev", "a revision that the device does not have",
                "servobus-scanner io D --connection standard --multicast"},
        Refusal{"fo_type_reserved", "O->T has connection type 3",
                "servobus-scanner io D --connection standard --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_null_unmatched", "Both directions are of the type null",
                "servobus-scanner io D --connection standard --key 1389/43/29961/129.1"},
        Refusal{"fo_mult_bad", "the code 0 to 7, not the multiplier itself",
                "servobus-scanner io D --connection standard --multicast --key 1389/43/29961/129.1"},
        Refusal{"fo_short", "ends before its path does", ""}),
    [](const auto& test) { return std::string(test.param.name); });

// --- every code

TEST(OpenDoctor, EveryExtendedStatusHasACauseAndAnAdvice) {
    // R-CON-40, all that have a text, and all of the table.
    std::size_t codes = 0;
    for (unsigned word = 0; word <= 0xFFFF; ++word) {
        const auto text = cip::extended_text(GeneralStatus::connection_failure, static_cast<std::uint16_t>(word));
        if (text.empty() || text.starts_with("safety")) continue;
        ++codes;
        const auto status = failure(static_cast<std::uint16_t>(word));
        EXPECT_EQ(open_cause(status).code, word) << text;
        EXPECT_TRUE(open_cause(status).cause.ends_with('.'));
        EXPECT_TRUE(open_cause(status).next.ends_with('.'));
        for (const auto& plan : {known(), foreign()}) {
            const auto diagnosis = refused(request_of(plan), status);
            EXPECT_THAT(diagnosis.causes, Not(IsEmpty())) << text;
            EXPECT_TRUE(diagnosis.corrected || !diagnosis.next.empty()) << text;
            for (const auto& list : {diagnosis.findings, diagnosis.causes, diagnosis.next}) {
                for (const auto& sentence : list) EXPECT_TRUE(sentence.ends_with('.')) << sentence;
            }
        }
    }
    EXPECT_EQ(codes + 1, extended_causes().size()) << "and one for all others";
}

TEST(OpenDoctor, EveryGeneralStatusIsAnswered) {
    for (unsigned code = 1; code <= 0xFF; ++code) {
        for (const auto& plan : {known(), foreign()}) {
            const auto diagnosis = refused(request_of(plan), static_cast<GeneralStatus>(code));
            EXPECT_THAT(diagnosis.causes, Not(IsEmpty())) << code;
            EXPECT_THAT(diagnosis.summary, Not(IsEmpty()));
        }
    }
    for (const unsigned code : {0x02, 0x05, 0x08, 0x0F, 0x10, 0x13, 0x15, 0x25, 0x26}) {
        EXPECT_EQ(open_cause(static_cast<GeneralStatus>(code)).code, code);
    }
}

TEST(OpenDoctor, OnlyWhatMayPassIsWorthAnotherTry) {
    for (const auto& entry : extended_causes()) {
        const bool passes =
            entry.code == 0x0100 || entry.code == 0x0106 || entry.code == 0x0113 || entry.code == 0x011A;
        EXPECT_EQ(refused(request_of(known()), failure(entry.code)).may_pass, passes) << "R-SCN-4: " << entry.code;
    }
}

// --- sizes

struct Counted {
    const char* what;
    bool o_to_t;
    int difference;
    const char* cause;
};

class CountedWrong : public testing::TestWithParam<Counted> {};

TEST_P(CountedWrong, IsToldApart) {
    const auto& [what, o_to_t, difference, cause] = GetParam();
    auto request = request_of(known());
    auto& parameters = o_to_t ? request.o_to_t : request.t_to_o;
    const auto right = parameters.size;
    parameters.size = static_cast<std::uint16_t>(right + difference);
    const auto diagnosis = refused(request, failure(o_to_t ? 0x0127 : 0x0128, {right}));
    ASSERT_THAT(diagnosis.findings, Not(IsEmpty()));
    EXPECT_EQ(diagnosis.findings[0],
              fmt::format("{} size {} asked, {} expected: {}.", o_to_t ? "O->T" : "T->O", right + difference, right,
                          o_to_t ? "18 of assembly 101 + 4 run/idle header + 2 sequence count"
                                 : "28 of assembly 100 + 2 sequence count"));
    ASSERT_THAT(diagnosis.causes, Not(IsEmpty()));
    EXPECT_THAT(diagnosis.causes[0], HasSubstr(cause));
    EXPECT_EQ(diagnosis.corrected, known());
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, CountedWrong,
    testing::Values(
        Counted{"header_left_out", true, -4, "left out the 4 octets of the run/idle header, which O->T has"},
        Counted{"count_forgotten", true, -2, "forgot the 2 octets of the sequence count"},
        Counted{"data_alone", true, -6, "gave the size of the data alone"},
        Counted{"header_twice", true, 4, "run/idle header twice"},
        Counted{"count_twice", true, 2, "sequence count twice"},
        Counted{"both_twice", true, 6, "30 is the size of the other direction"},
        Counted{"something_else", true, 11, "A difference of 11 octets is neither"},
        Counted{"t_count_forgotten", false, -2, "forgot the 2 octets of the sequence count"},
        Counted{"t_header", false, 4, "on the wrong side: T->O has none"},
        Counted{"exchanged", false, -6, "24 is the size of the other direction: the two sizes are exchanged"}),
    [](const auto& test) { return std::string(test.param.what); });

TEST(OpenDoctor, LooksAtTheOtherDirectionTooWhenItKnowsTheDevice) {
    // The header on the wrong side: 4 too few out, 4 too many in. The target speaks of the first only.
    auto request = request_of(known());
    request.o_to_t.size = 20;
    request.t_to_o.size = 34;
    const auto diagnosis = refused(request, failure(0x0127, {24}));
    EXPECT_THAT(diagnosis.findings, ElementsAre(StartsWith("O->T size 20 asked, 24 expected"),
                                                StartsWith("T->O size 34 asked, 30 expected"),
                                                HasSubstr("are those of the connection 'Standard' of a XENAX")));
    EXPECT_EQ(diagnosis.corrected, known());
}

TEST(OpenDoctor, TakesTheSizeOfAnUnknownDeviceFromItsReply) {
    auto request = request_of(foreign());
    request.o_to_t.size = 10;
    const auto diagnosis = refused(request, failure(0x0127, {14}));
    EXPECT_THAT(diagnosis.findings,
                ElementsAre("O->T size 10 asked, 14 expected: 2 sequence count + 12, which is either data alone, or "
                            "4 run/idle header + 8 data."));
    EXPECT_THAT(diagnosis.causes, ElementsAre(HasSubstr("probably left out the 4 octets of the run/idle header")));
    EXPECT_THAT(diagnosis.next, ElementsAre(HasSubstr("--o2t-size 12 --o2t-format modeless")));
    EXPECT_EQ(diagnosis.corrected, foreign());
}

TEST(OpenDoctor, ClaimsNoSizeThatNobodyHasTold) {
    const auto diagnosis = refused(request_of(foreign()), failure(0x0128));
    EXPECT_THAT(diagnosis.findings, ElementsAre(HasSubstr("the target does not say which it expects")));
    EXPECT_FALSE(diagnosis.corrected);
}

TEST(OpenDoctor, AForeignDeviceMayShareThePointsOfAXenax) {
    auto request = request_of(known());
    request.t_to_o.size = 20;
    const auto diagnosis = refused(request, failure(0x0128, {12}));
    EXPECT_THAT(diagnosis.findings, ElementsAre("T->O size 20 asked, 12 expected: 2 sequence count + 10 data."));
    ASSERT_TRUE(diagnosis.corrected);
    EXPECT_EQ(diagnosis.corrected->t_to_o.data_octets, 10U);
    // Who says that he is somebody else is.
    auto other = xenax();
    other.vendor = 1;
    EXPECT_FALSE(refused(request, failure(0x0109), other).corrected);
    EXPECT_TRUE(refused(request, failure(0x0109), xenax()).corrected);
}

// --- points and paths

TEST(OpenDoctor, SeesExchangedPoints) {
    auto plan = known();
    std::swap(plan.o_to_t.point, plan.t_to_o.point);
    const auto diagnosis = refused(request_of(plan), failure(0x012F), xenax());
    EXPECT_THAT(diagnosis.causes, Contains(HasSubstr("The points are exchanged: 101 is what the drive consumes")));
    EXPECT_EQ(diagnosis.corrected, known());
    // Points 100 and 101 are in many devices, so without an identity nothing is claimed.
    const auto unknown = refused(request_of(plan), failure(0x012F));
    EXPECT_FALSE(unknown.corrected);
    EXPECT_THAT(unknown.findings, Contains(HasSubstr("whether it has them is not known here")));
}

TEST(OpenDoctor, KnowsWhichPointsGoTogether) {
    auto plan = known("force");
    plan.t_to_o.point = 100;
    const auto diagnosis = refused(request_of(plan), failure(0x012F), xenax());
    EXPECT_THAT(diagnosis.causes, ElementsAre("T->O point 100 does not go with 104; 105 does."));
    EXPECT_EQ(diagnosis.corrected, known("force"));
    plan.o_to_t.point = 100;
    const auto wrong_side = refused(request_of(plan), failure(0x012A), xenax());
    EXPECT_THAT(wrong_side.causes, Contains(HasSubstr("O->T point 100 is of the other direction")));
}

TEST(OpenDoctor, SeesTheConfigurationInstance) {
    auto plan = known();
    plan.configuration_instance.reset();
    const auto missing = refused(request_of(plan), failure(0x0129));
    EXPECT_THAT(missing.causes, ElementsAre("The configuration instance, 1, is missing."));
    EXPECT_EQ(missing.corrected, known());
    plan.configuration_instance = 7;
    EXPECT_THAT(refused(request_of(plan), failure(0x0315)).causes,
                ElementsAre("Configuration instance 7 is asked; the XENAX has 1."));
}

std::vector<std::string> oddities(std::string_view hex) { return ConnectionPath::read(octets(hex)).oddities(); }

TEST(ConnectionPath, SaysWhatIsUnusual) {
    EXPECT_THAT(oddities("20 04 24 01 2C 65 2C 64"), IsEmpty());
    EXPECT_THAT(oddities("34 04 6D05 2B00 0975 81 01 20 04 24 01 2C 65 2C 64 80 01 0000"), IsEmpty());
    EXPECT_THAT(oddities("24 01 2C 65 2C 64"), ElementsAre(HasSubstr("names no class")));
    EXPECT_THAT(oddities("20 06 24 01 2C 65 2C 64"), ElementsAre(HasSubstr("names class 0x06")));
    EXPECT_THAT(oddities("20 04 2C 65 2C 64"), ElementsAre(HasSubstr("no configuration instance")));
    EXPECT_THAT(oddities("20 04 2C 65"), ElementsAre(HasSubstr("one point, 101, for both")));
    EXPECT_THAT(oddities("20 04"), ElementsAre(HasSubstr("no connection point at all")));
    EXPECT_THAT(oddities("20 04 24 01 2C 65 2C 64 2C 66"), ElementsAre(HasSubstr("names 4 points")));
    EXPECT_THAT(oddities("20 04 24 01 2D 00 65 00 2C 64"), ElementsAre(HasSubstr("16 or 32 bits")));
    EXPECT_THAT(oddities("20 04 24 01 2D 00 65 01 2C 64"), IsEmpty()) << "357 does need 16 bits";
    EXPECT_THAT(oddities("01 00 20 04 24 01 2C 65 2C 64"), ElementsAre(HasSubstr("begins with hops")));
    EXPECT_THAT(oddities("91 02 41 42"), ElementsAre(HasSubstr("names no class"), HasSubstr("symbol 'AB'")));
    EXPECT_THAT(oddities("20"), ElementsAre(HasSubstr("cannot be read")));
}

TEST(OpenDoctor, SaysWhichPartOfThePathIsUnusualForABare0x0315) {
    auto request = request_of(foreign());
    request.path = octets("24 05 2C 96 2C A0");
    EXPECT_THAT(refused(request, failure(0x0315)).findings, Contains(HasSubstr("names no class")));
    request = request_of(known());
    request.path = octets("24 01 2C 65 2C 64");
    const auto diagnosis = refused(request, failure(0x0315));
    EXPECT_EQ(diagnosis.corrected, known());
}

TEST(OpenDoctor, SaysWhichPartOfTheTransportIsUnusualForABare0x0103) {
    auto request = request_of(foreign());
    request.transport = cip::Transport::from_byte(0x91);
    const auto diagnosis = refused(request, failure(0x0103));
    EXPECT_THAT(diagnosis.findings, Contains(HasSubstr("is 0x91; cyclic class 1 is 0x01")));
    EXPECT_THAT(diagnosis.causes, ElementsAre(HasSubstr("not cyclic"), HasSubstr("direction bit")));
    EXPECT_EQ(diagnosis.corrected, foreign());
    EXPECT_THAT(refused(request_of(foreign()), failure(0x0103)).causes, ElementsAre(HasSubstr("the usual one")));
}

// --- intervals, key, owners and the rest

TEST(OpenDoctor, TakesTheIntervalsThatTheTargetNames) {
    using enum cip::RpiKind;
    auto plan = foreign();
    plan.o_to_t.rpi = plan.t_to_o.rpi = 2ms;
    const auto corrected = [&](const cip::RpiRefusal& refusal) {
        const auto diagnosis = refused(request_of(plan), refusal.status());
        return std::pair(diagnosis.corrected->o_to_t.rpi, diagnosis.corrected->t_to_o.rpi);
    };
    EXPECT_EQ(corrected({minimum, acceptable, 5000, 0}), std::pair(microseconds(5000), microseconds(2000)));
    EXPECT_EQ(corrected({maximum, required, 1000, 20'000}), std::pair(microseconds(1000), microseconds(20'000)));
    EXPECT_EQ(corrected({minimum, maximum, 1000, 1500}), std::pair(microseconds(2000), microseconds(1500)));
    EXPECT_FALSE(refused(request_of(plan), cip::RpiRefusal{unspecified, unspecified, 0, 0}.status()).corrected);
    EXPECT_FALSE(refused(request_of(plan), failure(0x0112)).corrected);
}

TEST(OpenDoctor, SaysWhichFieldOfTheKeyDiffers) {
    auto plan = known();
    plan.key = cip::ElectronicKey{1389, 12, 0x7509, 2, 1, {}};
    const auto diagnosis = refused(request_of(plan), failure(0x0115), xenax());
    EXPECT_THAT(diagnosis.causes, ElementsAre("The key asks for device type 12, and the device has 43.",
                                              "The key asks for major revision 2, and the device has 1.",
                                              "The key asks for minor revision 1, and the device has 2."));
    EXPECT_EQ(diagnosis.corrected->key, (cip::ElectronicKey{1389, 43, 0x7509, 1, 2, {}}));
    // R-CON-11: with the compatibility bit a lower minor revision will do.
    plan.key = cip::ElectronicKey{1389, 43, 0x7509, 0x81, 3, {}};
    EXPECT_THAT(refused(request_of(plan), failure(0x0116), xenax()).causes,
                ElementsAre("The key asks for a revision that can stand in for 1.3, and the device has 1.2."));
}

TEST(OpenDoctor, OffersInputOnlyBesideAnotherOwner) {
    const auto diagnosis = refused(request_of(known("force")), failure(0x0106));
    EXPECT_TRUE(diagnosis.may_pass);
    EXPECT_EQ(command_line(*diagnosis.corrected, "D"), "servobus-scanner io D --connection input-only --t2o 105");
    EXPECT_THAT(diagnosis.causes, ElementsAre(HasSubstr("Somebody else owns"), HasSubstr("within 160 ms")));
    EXPECT_FALSE(refused(request_of(foreign()), failure(0x0106)).corrected);
}

TEST(OpenDoctor, SaysWhatListeningNeeds) {
    auto plan = known("listen-only");
    const auto alone = refused(request_of(plan), failure(0x0119));
    EXPECT_EQ(alone.corrected->t_to_o.type, cip::ConnectionType::multicast) << "R-CON-32";
    plan.t_to_o.type = cip::ConnectionType::multicast;
    const auto nobody = refused(request_of(plan), failure(0x0119));
    EXPECT_EQ(nobody.corrected->o_to_t.point, assemblies::input_only_point);
}

TEST(OpenDoctor, AnOldConnectionEndsWithItsTimeout) {
    const auto diagnosis = refused(request_of(known()), failure(0x0100));
    EXPECT_TRUE(diagnosis.may_pass);
    EXPECT_FALSE(diagnosis.corrected);
    EXPECT_THAT(diagnosis.next, Contains(HasSubstr("within 160 ms")));
}

TEST(OpenDoctor, TurnsWhatTheTargetDoesNotHave) {
    const auto corrected = [](IoPlan plan, const cip::Status& status) {
        return *refused(request_of(plan), status).corrected;
    };
    auto plan = foreign();
    plan.t_to_o.type = cip::ConnectionType::multicast;
    EXPECT_EQ(corrected(plan, failure(0x0124)), foreign());
    EXPECT_EQ(corrected(plan, failure(0x0813)), foreign());
    EXPECT_EQ(corrected(foreign(), failure(0x0124)), plan);
    plan = foreign();
    plan.large = true;
    EXPECT_EQ(corrected(plan, GeneralStatus::service_not_supported), foreign());
    plan = foreign();
    plan.redundant_owner = true;
    EXPECT_EQ(corrected(plan, failure(0x0125)), foreign());
    plan = foreign();
    plan.inhibit = 20ms;
    EXPECT_EQ(corrected(plan, failure(0x011B)), foreign());
    plan = foreign();
    plan.o_to_t.variable = true;
    EXPECT_EQ(corrected(plan, failure(0x011F)), foreign());
    plan = foreign();
    plan.configuration = {1, 2};
    EXPECT_EQ(corrected(plan, failure(0x0126, {0})), foreign());
    EXPECT_FALSE(refused(request_of(plan), failure(0x0126, {3})).corrected) << "three words, but which";
    plan = foreign();
    plan.o_to_t.data_octets = 600;
    plan.large = true;
    EXPECT_FALSE(refused(request_of(plan), GeneralStatus::service_not_supported).corrected);
}

TEST(OpenDoctor, SpeaksOfSilenceAndOtherLayers) {
    OpenQuestion question;
    question.request = request_of(known());
    EXPECT_THAT(diagnose_silence(question).summary, HasSubstr("not answered"));
    EXPECT_THAT(diagnose_bad_reply(question).summary, HasSubstr("makes no sense"));
    EXPECT_THAT(diagnose_refusal(question, enip::EncapsulationStatus::invalid_session).causes,
                ElementsAre(HasSubstr("RegisterSession")));
}

// --- after the grant

class GrantedOpen : public testing::Test {
protected:
    GrantedOpen() {
        question_.request = request_of(known());
        traffic_.o_to_t_api = traffic_.t_to_o_api = 10'000;
        traffic_.o_to_t.packets = traffic_.t_to_o.packets = 100;
        traffic_.receiver = originator_io;
        traffic_.observed = 1s;
    }
    Diagnosis diagnosis() const { return diagnose_traffic(question_, traffic_); }

    OpenQuestion question_;
    IoTraffic traffic_;
};

TEST_F(GrantedOpen, IsWellWhenDataFlows) {
    traffic_.o_to_t.lost = 2;
    EXPECT_TRUE(diagnosis().well);
    EXPECT_THAT(diagnosis().findings, ElementsAre("2 O->T datagrams are missing beside 100 that came."));
}

TEST_F(GrantedOpen, NothingCame) {
    traffic_.t_to_o.packets = 0;
    EXPECT_FALSE(diagnosis().well);
    EXPECT_EQ(diagnosis().summary, "granted, but no T->O datagram came");
    EXPECT_THAT(diagnosis().causes.at(0), HasSubstr("firewall on the originator drops UDP to port 2222"));
    traffic_.receiver = {0xEFC00D60, enip::io_port};
    EXPECT_THAT(diagnosis().causes.at(0), HasSubstr("IGMP"));
    traffic_.observed = 5ms;
    EXPECT_THAT(diagnosis().causes, ElementsAre(HasSubstr("before the first one was due")));
}

TEST_F(GrantedOpen, NothingWasSent) {
    traffic_.o_to_t.packets = 0;
    EXPECT_EQ(diagnosis().summary, "granted, but the originator sends nothing");
    EXPECT_THAT(diagnosis().findings, ElementsAre(HasSubstr("ends the connection after 10 s"))) << "R-CON-19";
}

TEST_F(GrantedOpen, WentElsewhere) {
    traffic_.t_to_o.elsewhere = enip::Endpoint{originator.address, 4000};
    EXPECT_EQ(diagnosis().summary, "granted, but T->O goes to 192.168.2.10:4000 instead of 192.168.2.10:2222");
}

TEST_F(GrantedOpen, HasAnotherSize) {
    traffic_.o_to_t.other_size = 20;
    traffic_.o_to_t.other_size_packets = 100;
    EXPECT_EQ(diagnosis().summary, "granted, but O->T datagrams have 20 octets and not 24");
    EXPECT_THAT(diagnosis().causes, ElementsAre(HasSubstr("The sender probably left out the 4 octets")));
}

TEST_F(GrantedOpen, TimedOut) {
    traffic_.t_to_o.silent = 161ms;
    EXPECT_EQ(diagnosis().summary, "granted, but T->O timed out after 100 datagrams");
    EXPECT_THAT(diagnosis().causes.at(0), HasSubstr("switched off"));
    traffic_.o_to_t.longest_interval = 200ms;
    EXPECT_THAT(diagnosis().causes.at(0), HasSubstr("because O->T stopped: 200 ms without a datagram"));
    traffic_.t_to_o.silent = 160ms;
    EXPECT_TRUE(diagnosis().well);
    traffic_.t_to_o.silent = 2s;
    traffic_.closed = true;
    EXPECT_TRUE(diagnosis().well);
}

TEST_F(GrantedOpen, IsIdleAllTheTime) {
    traffic_.o_to_t.always_idle = true;
    EXPECT_EQ(diagnosis().summary, "granted, but the originator is idle all the time");
}

TEST_F(GrantedOpen, ADirectionOfTheTypeNullHasNoData) {
    question_.request->o_to_t.type = cip::ConnectionType::null;
    traffic_.o_to_t.packets = 0;
    EXPECT_TRUE(diagnosis().well);
}

// --- the command line

TEST(PlanArguments, PreferTheConnectionByName) {
    for (const auto& connection : assemblies::connections()) {
        const auto words = plan_arguments(plan_of(connection), "D");
        ASSERT_GE(words.size(), 3U);
        EXPECT_EQ(words[1], "--connection");
        EXPECT_EQ(words[2], connection.key);
    }
    EXPECT_THAT(plan_arguments(known(), "D"), ElementsAre("D", "--connection", "standard"));
    auto plan = known();
    plan.o_to_t.rpi = 2ms;
    plan.t_to_o.rpi = 2500us;
    plan.configuration_instance.reset();
    plan.configuration = {0xAB, 0x01};
    plan.multiplier_code = 5;
    plan.trigger = enip::Trigger::change_of_state;
    plan.inhibit = 500us;
    plan.o_to_t.priority = cip::Priority::urgent;
    plan.large = true;
    plan.route = cip::Path({cip::PortSegment{1, {0}}, cip::PortSegment{2, {'1', '0', '.', '0', '.', '0', '.', '1'}}});
    EXPECT_EQ(command_line(plan, "D"),
              "servobus-scanner io D --connection standard --config-instance none --rpi-o2t 2 --rpi-t2o 2.5 "
              "--multiplier 128 --trigger cos --inhibit 0.5 --priority urgent --large --config AB01 "
              "--route 1/0,2/10.0.0.1");
}

TEST(PlanArguments, SixNumbersForAnyOtherDevice) {
    EXPECT_EQ(
        command_line(foreign(), "10.0.0.1"),
        "servobus-scanner io 10.0.0.1 --o2t 150 --o2t-size 8 --t2o 160 --t2o-size 16 --config-instance 5 --rpi 10");
    auto plan = known();
    plan.t_to_o.data_octets = 30;
    EXPECT_EQ(command_line(plan, "D"),
              "servobus-scanner io D --o2t 101 --o2t-size 18 --t2o 100 --t2o-size 30 --config-instance 1 --rpi 10");
    plan = foreign();
    plan.o_to_t.format = cip::RealTimeFormat::heartbeat;
    plan.o_to_t.data_octets = 0;
    plan.t_to_o.format = cip::RealTimeFormat::header32;
    EXPECT_THAT(command_line(plan, "D"),
                HasSubstr("--o2t-size 0 --t2o 160 --t2o-size 16 --config-instance 5 --t2o-format header32"));
}

TEST(PlanFrom, IsWhatTheRequestWasMadeFrom) {
    for (const auto& connection : assemblies::connections()) {
        EXPECT_EQ(plan_from(request_of(plan_of(connection))), plan_of(connection));
    }
    EXPECT_EQ(plan_from(request_of(foreign())), foreign());
    auto request = request_of(foreign());
    request.path = octets("20 04 2C 65");
    EXPECT_FALSE(plan_from(request));
}

}  // namespace
}  // namespace servobus::scanner
