#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eds/document.hpp"

namespace servobus::eds {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Document parsed(std::string_view text) {
    auto document = parse(text);
    EXPECT_TRUE(document) << to_text(document.error());
    return document ? *document : Document{};
}

// Fields as one line: words as they are, strings in quotes, an empty field as nothing.
std::vector<std::string> fields(const Document& document, std::string_view section, std::string_view keyword) {
    const auto* entry = document.find(section, keyword);
    if (entry == nullptr) return {"no such entry"};
    std::vector<std::string> shown;
    for (const auto& field : entry->fields) {
        shown.push_back(field.kind == Field::Kind::text ? '"' + field.value + '"' : field.value);
    }
    return shown;
}

std::vector<std::string> warnings(const Document& document) {
    std::vector<std::string> words;
    for (const auto& warning : document.warnings) words.push_back(to_text(warning));
    return words;
}

TEST(Parse, SectionsEntriesAndFields) {
    const auto document = parsed(
        "$ a comment\r\n"
        "[File]\r\n"
        "        DescText = \"A device\";   $ to the end; of [the] line\r\n"
        "        Revision = 1.0;CreateDate=11-21-2025;\r\n"
        "[Params]\r\n"
        "  Param1 = 0, 6,\"20 66 24 01 30 01\", 0x0010,\r\n"
        "     $ between fields\r\n"
        "     ,, -5;\r\n");
    EXPECT_THAT(warnings(document), IsEmpty());
    ASSERT_EQ(document.sections.size(), 2U);
    EXPECT_EQ(document.sections[0].name, "File");
    EXPECT_EQ(document.sections[0].line, 2U);
    EXPECT_THAT(fields(document, "File", "DescText"), ElementsAre("\"A device\""));
    EXPECT_THAT(fields(document, "File", "Revision"), ElementsAre("1.0"));
    EXPECT_THAT(fields(document, "File", "CreateDate"), ElementsAre("11-21-2025"));
    EXPECT_THAT(fields(document, "Params", "Param1"),
                ElementsAre("0", "6", "\"20 66 24 01 30 01\"", "0x0010", "", "", "-5"));
    const auto& entry = document.sections[1].entries[0];
    EXPECT_EQ(entry.line, 6U);
    EXPECT_EQ(entry.field(1).line, 6U);
    EXPECT_EQ(entry.field(7).line, 8U);
    EXPECT_TRUE(entry.field(5).is_empty());
    EXPECT_TRUE(entry.field(8).is_empty()) << "past the end";
    EXPECT_TRUE(entry.field(0).is_empty());
}

TEST(Parse, AdjacentStringsAreOne) {
    const auto document = parsed("[Device]\nIconContents = \"AAAB\" $ first\n   \"AAEA\"\n\"ICAQ\";Icon=\"a.ico\";");
    EXPECT_THAT(fields(document, "Device", "IconContents"), ElementsAre("\"AAABAAEAICAQ\""));
    EXPECT_THAT(fields(document, "Device", "Icon"), ElementsAre("\"a.ico\""));
    EXPECT_THAT(warnings(document), IsEmpty());
}

TEST(Parse, StringsKeepWhatElseIsPunctuation) {
    const auto document =
        parsed("[A]\nx = \"a,b;c=$d[e]\", \"say \\\"no\\\"\", \"C:\\icons\", \"one\\ntwo\", \"\\\\\", \"\";");
    EXPECT_THAT(fields(document, "A", "x"),
                ElementsAre("\"a,b;c=$d[e]\"", "\"say \"no\"\"", "\"C:\\icons\"", "\"one\ntwo\"", "\"\\\"", "\"\""));
    EXPECT_EQ(document.find("A", "x")->field(6).kind, Field::Kind::text) << "an empty string is no empty field";
}

TEST(Parse, ABackslashDoesNotSwallowTheLastQuote) {
    const auto document = parsed("[A]\nx = \"C:\\dir\\\";\ny = 1;");
    EXPECT_THAT(fields(document, "A", "x"), ElementsAre("\"C:\\dir\\\""));
    EXPECT_THAT(fields(document, "A", "y"), ElementsAre("1"));
}

TEST(Parse, Iso8859) {
    const auto document = parsed(
        "[File]\nDescText = \"Gr\xF6\xDF"
        "e in \xB5s\";");
    EXPECT_EQ(document.find("File", "DescText")->field(1).value,
              "Gr\xF6\xDF"
              "e in \xB5s");
}

TEST(Parse, EveryEndOfLineCounts) {
    for (const std::string end : {"\n", "\r\n", "\r"}) {
        const auto document = parsed("[A]" + end + "x = 1;" + end + end + "y = 2;" + end);
        EXPECT_EQ(document.find("A", "y")->line, 4U);
    }
}

TEST(Parse, NamesDifferInCaseOnlyWhenNoneIsWrittenSo) {
    const auto document = parsed("[params]\nparam1 = 1;\nParam1 = 2;");
    EXPECT_THAT(fields(document, "Params", "Param1"), ElementsAre("2"));
    EXPECT_THAT(fields(document, "Params", "PARAM1"), ElementsAre("1")) << "the first";
    EXPECT_EQ(document.find("Paramz"), nullptr);
    EXPECT_EQ(document.find("params", "Param"), nullptr);
}

TEST(Parse, VendorKeywordsArePlainEntries) {
    const auto document = parsed("[Device]\n1_IOC_Details_License = 0x82E7C35B;\n65535_x=1;");
    EXPECT_THAT(fields(document, "Device", "1_IOC_Details_License"), ElementsAre("0x82E7C35B"));
    EXPECT_THAT(fields(document, "Device", "65535_x"), ElementsAre("1"));
    EXPECT_THAT(warnings(document), IsEmpty());
}

TEST(Parse, PathsWithParamsAreOneField) {
    const auto document = parsed("[A]\nx = \"20 04 24 01 2C [Param6] 2C [Param5]\", 20 66 24 01, 2C [Param6], 1;");
    EXPECT_THAT(fields(document, "A", "x"),
                ElementsAre("\"20 04 24 01 2C [Param6] 2C [Param5]\"", "20 66 24 01", "2C [Param6]", "1"));
    EXPECT_THAT(warnings(document), IsEmpty());
}

TEST(Parse, AMissingSemicolonEndsWhereTheNextEntryBegins) {
    const auto document = parsed("[File]\nDescText = \"x\"\nRevision = 1.0\n[Device]\nVendCode = 1,\nProdCode = 2");
    EXPECT_THAT(fields(document, "File", "DescText"), ElementsAre("\"x\""));
    EXPECT_THAT(fields(document, "File", "Revision"), ElementsAre("1.0"));
    EXPECT_THAT(fields(document, "Device", "VendCode"), ElementsAre("1", ""));
    EXPECT_THAT(fields(document, "Device", "ProdCode"), ElementsAre("2"));
    EXPECT_THAT(warnings(document), ElementsAre("line 2: warning: DescText has no semicolon at its end",
                                                "line 3: warning: Revision has no semicolon at its end",
                                                "line 5: warning: VendCode has no semicolon at its end",
                                                "line 6: warning: ProdCode has no semicolon at its end"));
}

TEST(Parse, AnOpenStringEndsWithItsLine) {
    const auto document = parsed("[File]\nDescText = \"no end;\nHomeURL = \"http\", \"two $ words\n;");
    EXPECT_THAT(fields(document, "File", "DescText"), ElementsAre("\"no end\""));
    EXPECT_THAT(fields(document, "File", "HomeURL"), ElementsAre("\"http\"", "\"two\""));
    EXPECT_THAT(warnings(document), ElementsAre("line 2: warning: a string of DescText is not closed in its line",
                                                "line 3: warning: a string of HomeURL is not closed in its line"));
}

TEST(Parse, ASectionThatComesTwiceGoesOn) {
    const auto document = parsed("[Params]\nParam1=1;\n[Groups]\nGroup1=1;\n[Params]\nParam2=2;");
    EXPECT_EQ(document.sections.size(), 2U);
    EXPECT_THAT(fields(document, "Params", "Param2"), ElementsAre("2"));
    EXPECT_THAT(warnings(document), ElementsAre("line 5: warning: [Params] is already in line 1"));
}

TEST(Parse, ASectionInAnotherCaseIsTheSame) {
    const auto document = parsed("[params]\nParam1=1;\n[Params]\nParam2=2;");
    EXPECT_EQ(document.sections.size(), 1U);
    EXPECT_THAT(warnings(document), ElementsAre("line 3: warning: [Params] is already in line 1"));
}

TEST(Parse, WhatIsNoEntryIsLeftOut) {
    const auto document = parsed("Early = 1;\n[A\nnonsense\nx = 1;\n;;\n\"text\";\nonly; y = 2;\n= 3;\nz = 4;");
    EXPECT_THAT(fields(document, "A", "x"), ElementsAre("1"));
    EXPECT_THAT(fields(document, "A", "y"), ElementsAre("2"));
    EXPECT_THAT(fields(document, "A", "z"), ElementsAre("4"));
    EXPECT_EQ(document.sections[0].entries.size(), 3U);
    EXPECT_THAT(warnings(document),
                ElementsAre("line 1: warning: Early is in no section", "line 2: warning: [A has no closing bracket",
                            "line 3: warning: 'nonsense' is no entry, since '=' does not follow",
                            "line 5: warning: here should be a keyword", "line 5: warning: here should be a keyword",
                            "line 6: warning: here should be a keyword",
                            "line 7: warning: 'only' is no entry, since '=' does not follow",
                            "line 8: warning: here should be a keyword"));
}

TEST(Parse, StringsAndWordsBesideEachOther) {
    const auto document = parsed("[A]\nx = 1 \"a\", \"b\" 2, = 3;");
    EXPECT_THAT(fields(document, "A", "x"), ElementsAre("\"1a\"", "\"b 2\"", "3"));
    EXPECT_EQ(document.warnings.size(), 3U);
}

TEST(Parse, RefusesWhatIsNoSuchText) {
    const auto why = [](std::string_view text) { return to_text(parse(text).error()); };
    EXPECT_EQ(why(""), "error: there is no [section] in it");
    EXPECT_EQ(why("<html>no data sheet</html>"), "error: there is no [section] in it");
    EXPECT_EQ(why(std::string_view("[A]\n\0x = 1;", 11)), "error: it is no text: it has octets of value 0");
    EXPECT_EQ(why(std::string_view("\xFF\xFE[\0A\0]\0", 8)), "error: it is UTF-16; a data sheet is ISO 8859-1");
}

TEST(Parse, TakesTheMarkOfUtf8Away) {
    const auto document = parsed("\xEF\xBB\xBF[A]\nx = 1;");
    EXPECT_THAT(fields(document, "A", "x"), ElementsAre("1"));
    EXPECT_THAT(warnings(document), ElementsAre("line 1: warning: the file begins with the mark of UTF-8"));
}

TEST(Parse, TheEndOfFileMarkOfOldEditorsIsBlank) { EXPECT_THAT(warnings(parsed("[A]\nx = 1;\n\x1A")), IsEmpty()); }

std::string repeated(std::string_view what, std::size_t times) {
    std::string text;
    for (std::size_t i = 0; i < times; ++i) text += what;
    return text;
}

TEST(ParseLimits, OctetsOfAText) {
    std::string text = "[A]\nx = 1;\n$";
    text.resize(max_octets, ' ');
    EXPECT_TRUE(parse(text));
    text.push_back(' ');
    EXPECT_EQ(to_text(parse(text).error()), "error: it is larger than 8388608 octets");
}

TEST(ParseLimits, FieldsOfAnEntry) {
    EXPECT_EQ(parsed("[A]\nx = " + repeated(",", max_fields - 1) + ";").find("A", "x")->fields.size(), max_fields);
    EXPECT_EQ(to_text(parse("[A]\nx = " + repeated(",", max_fields) + ";").error()),
              "line 2: error: x has more than 65536 fields");
}

TEST(ParseLimits, FieldsOfAll) {
    const auto entry = "x = " + repeated(",", max_fields - 1) + ";\n";
    const auto full = "[A]\n" + repeated(entry, max_all_fields / max_fields);
    EXPECT_TRUE(parse(full));
    EXPECT_EQ(to_text(parse(full + "y = 1;").error()), "line 18: error: there are more than 1048576 fields");
}

TEST(ParseLimits, Entries) {
    const auto full = "[A]\n" + repeated("x=;", max_entries);
    EXPECT_TRUE(parse(full));
    EXPECT_EQ(to_text(parse(full + "x=;").error()), "line 2: error: there are more than 262144 entries");
}

TEST(ParseLimits, Sections) {
    std::string full;
    for (std::size_t i = 0; i < max_sections; ++i) full += "[" + std::to_string(i) + "]\n";
    EXPECT_EQ(parsed(full).sections.size(), max_sections);
    EXPECT_EQ(to_text(parse(full + "[x]").error()), "line 4097: error: there are more than 4096 sections");
}

TEST(ParseLimits, Warnings) {
    const auto document = parsed("[A]\n" + repeated("oops\n", max_findings + 5));
    ASSERT_EQ(document.warnings.size(), max_findings + 1);
    EXPECT_EQ(document.warnings.back().words, "there are more warnings, from here on left out");
}

// Texts whose parts tempt a reader to look far ahead again and again: all are read in a moment.
TEST(ParseLimits, TheTimeIsThatOfTheLength) {
    const auto parts = {",",     "a=;", ";",     "[a]",    "\"", "\"\\\"",       "[",           "a ", "a\n", "x=\"a\" ",
                        "a,$\n", "=",   "\"a\"", "x=1[\n", "[ ", "a=b[Param1] ", "\"\\\" \"\"", "$\n"};
    for (const std::string_view part : parts) {
        const auto start = std::chrono::steady_clock::now();
        (void)parse("[A]\nx = " + repeated(part, 2'000'000 / part.size()));
        const auto took = std::chrono::steady_clock::now() - start;
        EXPECT_LT(took, std::chrono::seconds(10)) << part;
    }
}

}  // namespace
}  // namespace servobus::eds
