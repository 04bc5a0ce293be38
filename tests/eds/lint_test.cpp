// Each rule of the lint with a sheet that breaks it, and nothing else found; and the sheets that break none.
#include "eds/lint.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drive/xenax.hpp"
#include "eds/generate.hpp"
#include "tests/eds/sheet_file.hpp"

namespace servobus::eds {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const std::string clean = test::sheet("clean.eds");

std::vector<std::string> found(std::string_view text) {
    std::vector<std::string> words;
    for (const auto& finding : lint(text)) words.push_back(to_text(finding));
    return words;
}

struct Break {
    std::string_view from;
    std::string_view to;
    std::vector<std::string> findings;
};

std::string broken(const Break& each) {
    auto text = clean;
    const auto at = text.find(each.from);
    EXPECT_NE(at, std::string::npos) << each.from;
    if (at != std::string::npos) text.replace(at, each.from.size(), each.to);
    return text;
}

void expect_findings(const std::vector<Break>& breaks) {
    for (const auto& each : breaks) EXPECT_EQ(found(broken(each)), each.findings) << each.from << " -> " << each.to;
}

TEST(Lint, FindsNothingInACleanSheet) { EXPECT_THAT(found(clean), IsEmpty()); }

TEST(Lint, FindsNothingInTheGeneratedSheets) {
    for (const auto& model : drive::xenax_models()) EXPECT_THAT(found(generate(model)), IsEmpty()) << model.key;
}

TEST(Lint, WhatIsNoSheetIsTheOnlyFinding) {
    EXPECT_THAT(found("nothing"), ElementsAre("error: there is no [section] in it"));
}

TEST(Lint, FindingsComeByLineWithThoseOfTheReader) {
    EXPECT_THAT(found("[File]\nDescText = \"x\"\nCreateDate = today;"),
                ElementsAre("error: there is no [Device]", "error: there is no [Device Classification]",
                            "line 1: error: [File] has no CreateTime", "line 1: error: [File] has no Revision",
                            "line 2: warning: DescText has no semicolon at its end",
                            "line 3: error: CreateDate: field 1 is 'today', no date mm-dd-yyyy"));
}

TEST(Lint, Sections) {
    expect_findings({
        {"[Device Classification]\nClass1 = EtherNetIP;\n", "", {"error: there is no [Device Classification]"}},
        {"[File]",
         "[Extra]\n[File]",
         {"line 2: warning: [File] should be section 1 of the sheet",
          "line 5: warning: [Device] should be section 2 of the sheet",
          "line 8: warning: [Device Classification] should be section 3 of the sheet"}},
        {"[ParamClass]",
         "[Groups]\n[ParamClass]",
         {"line 12: warning: [Params] comes after [Groups], which refers to it",
          "line 19: warning: [Groups] is already in line 9"}},
        {"[Port]", "[PORT]", {"line 28: warning: [PORT] is written [Port]"}},
        {"[Device]\n", "[Device]\nVendCode = 283;\n", {"line 6: error: VendCode is twice in [Device]"}},
        {"[Ethernet Link Class]", "[Port]\n[Ethernet Link Class]", {"line 32: warning: [Port] is already in line 28"}},
    });
}

TEST(Lint, Keywords) {
    expect_findings({
        {"VendCode = 283; ", "", {"line 4: error: [Device] has no VendCode"}},
        {"DescText = \"A device\"", "DescText = ", {"line 2: error: DescText is empty"}},
        {"Revision = 1.0",
         "HomeUrl = \"x\"; Revision = 1.0",
         {"line 3: warning: HomeUrl is written in another case than the format has it"}},
        {"Revision = 1.0",
         "Author = \"x\"; 283_Author = \"x\"; Revision = 1.0",
         {"line 3: warning: 'Author' is no keyword of [File]"}},
        {"ProdCode = 1", "ProdCode = 1,2", {"line 5: warning: ProdCode has 2 fields, where one belongs"}},
        {"VendName = \"Someone\"", "VendName = Someone", {"line 5: warning: VendName: 'Someone' should be in quotes"}},
    });
}

TEST(Lint, Identity) {
    expect_findings({
        {"ModDate = 01-31-2020", "ModDate = 01-30-2020", {"line 2: warning: ModDate is before CreateDate"}},
        {"MajRev = 2", "MajRev = 0", {"line 6: error: MajRev is 0, and 1 to 127 can be"}},
        {"MajRev = 2", "MajRev = 128", {"line 6: error: MajRev is 128, and 1 to 127 can be"}},
        {"MinRev = 6", "MinRev = 0", {"line 6: warning: MinRev is 0; a device has 1 to 255, and 0 in a key means any"}},
        {"\"Mix\"",
         "\"123456789012345678901234567890123\"",
         {"line 6: error: ProdName has 33 characters, and a device tells at most 32"}},
        {"VendCode = 283",
         "VendCode = 65536",
         {"line 5: error: VendCode: field 1 is '65536', no number of 0 to 65535"}},
        {"AAABAA==", "AAEAAA==", {"line 6: warning: IconContents is no .ico file"}},
        {"Icon = \"mix.ico\"; ", "", {"line 6: warning: IconContents has no Icon, which is its file name"}},
        {"= EtherNetIP", "= DeviceNet", {"line 7: warning: no Class of [Device Classification] is EtherNetIP"}},
    });
}

TEST(Lint, FieldsOfAParam) {
    expect_findings({
        {",1,1,1,0,,,,,0;\n[Groups]",
         ",1,1,1,0;\n[Groups]",
         {"line 17: warning: Param5 has 16 fields, where 21 belong"}},
        {"Param5 = 0,", "Param5 = 1,", {"line 17: warning: Param5: field 1 is reserved, and 0"}},
        {"0,6,\"20 64 24 01 30 01\"",
         "0,5,\"20 64 24 01 30 01\"",
         {"line 12: error: Param1: the path has 6 octets, and 5 are stated"}},
        {"0,6,\"20 64 24 01 30 01\"",
         "0,,\"20 64 24 01 30 01\"",
         {"line 12: error: Param1: the path has 6 octets, and 0 are stated"}},
        {"Param5 = 0,,,", "Param5 = 0,6,,", {"line 17: error: Param5: the path has 0 octets, and 6 are stated"}},
        {"\"20 64 24 01 30 01\"", "20 64 24 01 30 01", {"line 12: warning: Param1: the path should be in quotes"}},
        {"\"20 64 24 01 30 01\"",
         "\"20 64 24 01 30 zz\"",
         {"line 12: error: Param1: field 3 is '20 64 24 01 30 zz', no path"}},
        {"\"20 64 24 01 30 01\"",
         "\"20 64 24 01 FF 01\"",
         {"line 12: error: Param1: the path '20 64 24 01 FF 01' has a segment that does not exist, or is cut"}},
        {"6,\"20 64 24 01 30 01\"",
         "7,\"21 64 03 24 01 30 01\"",
         {"line 12: warning: Param1: the path '21 64 03 24 01 30 01' lacks the padding of wide segments"}},
        {"0,6,\"20 64 24 01 30 01\"",
         "0,,\"20 64 24 [Param9]\"",
         {"line 12: error: Param1: the path names Param9, which is not there"}},
        {"0x0010,0xD0", "0x8010,0xD0", {"line 15: warning: Param3: descriptor 0x8010 has reserved bits"}},
        {"\"Gain\"", "\"\"", {"line 16: warning: Param4: there is no name"}},
        {"\"Gain\"", "\"SPEED\"", {"line 16: warning: Param4 has the name of Param2, SPEED"}},
        {"Param4 =", "Param0 =", {"line 16: error: Param0: the numbers of Params begin with 1"}},
    });
}

TEST(Lint, TypesAndLimits) {
    expect_findings({
        {"0xCA,4", "0x01,4", {"line 16: error: Param4: data type 0x01 does not exist"}},
        {"0xCA,4", "0xCA,8", {"line 16: error: Param4: the data type has 4 octets, and 8 are stated"}},
        {"-1.5,2.5,.5", "2.5,-1.5,", {"line 16: error: Param4: the minimum is above the maximum"}},
        {"-1.5,2.5,.5", "-1.5,2.5,-2", {"line 16: error: Param4: the default is below the minimum"}},
        {"-1.5,2.5,.5", "-1.5,2.5,3", {"line 16: error: Param4: the default is above the maximum"}},
        {"-1.5,2.5,.5", ",,much", {"line 16: error: Param4: field 12 is 'much', no value of the data type"}},
        {"-100,100,5", "-100,40000,5", {"line 14: error: Param2: the maximum 40000 does not fit the data type"}},
        {"-100,100,5", "-40000,100,5", {"line 14: error: Param2: the minimum -40000 does not fit the data type"}},
        {"1000,100000,10000",
         ",,4294967296",
         {"line 17: error: Param5: the default 4294967296 does not fit the data type"}},
        {"0,20,\"motor\"", "0,4,\"motor\"", {"line 15: error: Param3: the default is longer than the maximum"}},
        {"0xCA,4,\"Gain\",\"\",\"\",-1.5,2.5,.5", "0xC9,8,\"Gain\",\"\",\"\",1,0xFFFFFFFFFFFFFFFF,2", {}},
        {"0xCA,4,\"Gain\",\"\",\"\",-1.5,2.5,.5",
         "0xC9,8,\"Gain\",\"\",\"\",0xFFFFFFFFFFFFFFFF,1,",
         {"line 16: error: Param4: the minimum is above the maximum"}},
        {"0xCA,4,\"Gain\",\"\",\"\",-1.5,2.5,.5",
         "0xC1,1,\"Gain\",\"\",\"\",0,2,1",
         {"line 16: error: Param4: the maximum 2 does not fit the data type"}},
    });
}

TEST(Lint, Enumerations) {
    expect_findings({
        {"Enum1 = -2,\"none\", 0,\"jog\", 8,\"fast\";",
         "",
         {"line 12: error: Param1: the descriptor promises Enum1, which is not there"}},
        {"0x0082", "0x0000", {"line 12: warning: Param1: the descriptor does not say that there is an Enum1"}},
        {"8,\"fast\"", "0,\"fast\"", {"line 12: error: Param1: Enum1 has 0 twice"}},
        {"\"fast\"", "\"\"", {"line 12: warning: Param1: Enum1 has no text for 8"}},
        {"8,\"fast\"", "9,\"fast\"", {"line 12: warning: Param1: Enum1 has 9, which is outside the limits"}},
        {"-2,8,0,", "-2,8,1,", {"line 12: warning: Param1: the default 1 is not in Enum1"}},
        {"0x0082,0xC2,1,\"Mode\",\"\",\"\",-2,8,0,", "0x0182,0xC2,1,\"Mode\",\"\",\"\",-2,8,1,", {}},
        {"Enum1",
         "Enum9",
         {"line 12: error: Param1: the descriptor promises Enum1, which is not there",
          "line 13: error: Enum9: there is no Param9"}},
    });
}

TEST(Lint, Scaling) {
    expect_findings({
        {"3,2,1,1,Param1",
         "3,0,1,1,Param1",
         {"line 14: error: Param2: a multiplier, divisor or base of 0 makes no value"}},
        {"0x000C", "0x0008", {"line 14: warning: Param2: it has a scaling, and the descriptor says that it has none"}},
        {"0x000C", "0x0004", {"line 14: warning: Param2: it has scaling links, and the descriptor says none"}},
        {"1,1,Param1", "1,1,9", {"line 14: error: Param2: a scaling link names Param9, which is not there"}},
    });
}

TEST(Lint, ParamClassAndGroups) {
    expect_findings({
        {"MaxInst = 5;", "MaxInst = 4;", {"line 10: error: MaxInst of [ParamClass] is 4, and the highest Param is 5"}},
        {"CfgAssembly = 0", "CfgAssembly = 9", {"line 10: warning: CfgAssembly is 9, and there is no Assem9"}},
        {"CfgAssembly = 0", "CfgAssembly = 100", {}},
        {"\"Setup\",2,1,2", "\"\",2,1,2", {"line 19: warning: Group1 has no name"}},
        {"\"Setup\",2,1,2", "\"Setup\",3,1,2", {"line 19: error: Group1 says that it has 3 Params, and lists 2"}},
        {"\"Setup\",2,1,2", "\"Setup\"", {"line 19: error: Group1 says that it has  Params, and lists 0"}},
        {"\"Setup\",2,1,2", "\"Setup\",2,1,7", {"line 19: error: Group1 lists Param7, which is not there"}},
        {"\"Setup\",2,1,2", "\"Setup\",2,1,1", {"line 19: warning: Group1 lists Param1 twice"}},
    });
}

TEST(Lint, Assemblies) {
    expect_findings({
        {"8,,8,Param1",
         "8,,16,Param1",
         {"line 22: warning: Assem100: a member has 16 bits, and Param1 has 8",
          "line 22: error: Assem100: the members have 40 bits, and 4 octets are stated"}},
        {"8,,8,Param1", "8,,8,Param9", {"line 22: error: Assem100: a member is Param9, which is not there"}},
        {"32,Assem100;", "32,Assem9;", {"line 23: error: Assem101: a member is Assem9, which is not there"}},
        {"\"20 04 24 64 30 03\"",
         "\"20 04 24 64 30\"",
         {"line 22: error: Assem100: the path '20 04 24 64 30' has a segment that does not exist, or is cut"}},
        {"4,0,,,16", "4,0,1,,16", {"line 22: warning: Assem100: fields 5 and 6 are reserved, and empty"}},
        {"8,,8,Param1;", "8,,8;", {"line 22: warning: Assem100: its last member has a size and no reference"}},
        {"Assem101 =",
         "Assem9 = \"\",\"\",0;\nAssem101 =",
         {"line 23: warning: Assem9 has 3 fields, where at least 6 belong"}},
        {"Assem101 =",
         "Assem9 = \"\",\"\",,0,,,,Assem9;\nAssem101 =",
         {"line 23: warning: Assem9: neither its size nor its members tell how many octets it has"}},
        {"8,,8,Param1", ",,,Param1", {}},
    });
}

TEST(Lint, ConnectionWords) {
    expect_findings({
        {"0x04010002",
         "0x05010002",
         {"line 26: error: Connection1: exactly one of the bits 24 to 27 has to be set: listen only, input only, "
          "exclusive or redundant owner"}},
        {"0x04010002",
         "0x04090002",
         {"line 26: error: Connection1: trigger and transport 0x04090002 have reserved bits"}},
        {"0x04010002", "0x04010000", {"line 26: error: Connection1: no transport class is allowed"}},
        {"0x04010002", "0x04000002", {"line 26: error: Connection1: no trigger is allowed"}},
        {"0x44640405", "0x44640404", {"line 26: error: Connection1: O->T has neither a fixed nor a variable size"}},
        {"0x44640405", "0x44040405", {"line 26: error: Connection1: T->O has no connection type"}},
        {"0x44640405", "0x40640405", {"line 26: warning: Connection1: O->T has no priority"}},
        {"0x44640405", "0x44640605", {"line 26: error: Connection1: O->T has the reserved format 6"}},
        {"0x44640405",
         "0x44641405",
         {"line 26: error: Connection1: T->O tells idle by a length of zero, and has no variable size"}},
        {"0x44640405", "0x44640415", {"line 26: error: Connection1: the parameters 0x44640415 have reserved bits"}},
        {"0x44640405",
         "0x44640305",
         {"line 26: error: Connection1: O->T is a heartbeat, and has 5 octets",
          "line 26: warning: Connection1: an owner should send data, and O->T is a heartbeat"}},
        {"0x44640405", "0x44640505", {}},
        {"0x44240305",
         "0x44440305",
         {"line 27: error: Connection2: who only listens joins a multicast, and T->O has none"}},
        {"0x01010002,0x44240305,Param5,0",
         "0x02010002,0x44240405,Param5,2",
         {"line 27: warning: Connection2: who only looks should send a heartbeat, and O->T has data"}},
        {"0x01010002,0x44240305,Param5,0,,Param5,,Assem100",
         "0x02010002,0x44240305,Param5,0,,Param5,,",
         {"line 27: warning: Connection2: neither size nor format tell how many octets T->O has"}},
    });
}

TEST(Lint, WhatConnectionsReferTo) {
    expect_findings({
        {"Param5,5,Assem101",
         "Param9,5,Assem101",
         {"line 26: error: Connection1: field 3 is 'Param9', which is not there"}},
        {"Param5,5,Assem101",
         "Param2,5,Assem101",
         {"line 26: warning: Connection1: the interval of O->T is Param2, which is no UDINT"}},
        {"Param5,5,Assem101", "0,5,Assem101", {"line 26: warning: Connection1: the interval of O->T may be 0"}},
        {"Param5,5,Assem101",
         "Param5,6,Assem101",
         {"line 26: error: Connection1: O->T has 6 octets, and Assem101 has 5"}},
        {"Param5,4,Assem100",
         "Param5,Param2,Assem100",
         {"line 26: warning: Connection1: T->O has up to 100 octets, and Assem100 has 4"}},
        {"Param5,5,Assem101",
         "Param5,5,Assem9",
         {"line 26: error: Connection1: field 5 is 'Assem9', which is not there"}},
        {",,,,,\"Owner\"",
         ",,,3,Assem100,\"Owner\"",
         {"line 26: error: Connection1: the target's configuration has 3 octets, and Assem100 has 4"}},
        {",,,,,\"Owner\"",
         ",3,Assem100,,,\"Owner\"",
         {"line 26: error: Connection1: the proxy's configuration has 3 octets, and Assem100 has 4"}},
        {"\"20 04 24 01 2C 65 2C 64\"", "\"\"", {"line 26: error: Connection1: there is no path"}},
        {"\"20 04 24 01 2C 65 2C 64\"",
         "\"20 04 24 01 2C\"",
         {"line 26: error: Connection1: the path '20 04 24 01 2C' has a segment that does not exist, or is cut"}},
        {"\"20 04 24 01 2C 65 2C 64\"",
         "\"20 04 24 01 2C [Param8]\"",
         {"line 26: error: Connection1: the path names Param8, which is not there"}},
        {"\"20 04 24 01 2C 65 2C 64\"", "SYMBOL_ANSI", {}},
        {"\"Listen\"", "\"\"", {"line 27: error: Connection2: there is no name, by which it is chosen"}},
        {"\"Listen\"", "\"owner\"", {"line 27: error: Connection2 has the name of Connection1, owner"}},
        {",\"Listen\",\"\",\"20 04 24 01 2C C0 2C 64\"",
         ",\"Listen\",\"\"",
         {"line 27: error: Connection2: there is no path",
          "line 27: error: Connection2 has 14 fields, where 15 belong"}},
        {"PITNS = Yes", "PITNS = 1", {"line 25: error: PITNS is '1', and Yes or No can be"}},
    });
}

TEST(Lint, PortsCapacityAndClasses) {
    expect_findings({
        {"= TCP", "= UDP", {"line 29: warning: Port1: 'UDP' is no type of a port"}},
        {"= TCP", "= 283_Backplane", {}},
        {"\"20 F5 24 01\",2",
         "\"20 F5 24\",2",
         {"line 29: error: Port1: the path '20 F5 24' has a segment that does not exist, or is cut"}},
        {"\"20 F5 24 01\",2", "\"20 F5 24 01\"", {"line 29: error: Port1: there is no port number"}},
        {"[Capacity]",
         "Port3 = TCP,\"b\",\"\",2;\n[Capacity]",
         {"line 30: error: Port3: another port has the number 2"}},
        {"TxRx", "Both", {"line 31: error: TSpec1: 'Both' is none of TxRx, Tx and Rx"}},
        {"504,3000", "504", {"line 31: error: TSpec1: size and packets per second have to be more than 0"}},
        {"MaxIOConnections = 5",
         "MaxIOConnections = 0",
         {"line 31: warning: MaxIOConnections is 0, and there are connections"}},
        {"0xF6", "0xF5", {"line 32: error: [Ethernet Link Class] has the Object_Class_Code 0xF5, and is class 0xF6"}},
        {"Number_Of_Static_Instances = 2",
         "Number_Of_Static_Instances = 3",
         {"line 32: error: [Ethernet Link Class] has 3 instances, and its highest is 2"}},
        {"[Ethernet Link Class]",
         "[Other Class]\nObject_Class_Code = 0xF6;\n[Ethernet Link Class]",
         {"line 34: warning: [Ethernet Link Class] has the Object_Class_Code of [Other Class]"}},
    });
}

}  // namespace
}  // namespace servobus::eds
