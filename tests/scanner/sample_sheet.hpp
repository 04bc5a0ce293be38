// A data sheet of a valve that does not exist: scaling, names of values, bits, texts, configuration.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include "eds/data_sheet.hpp"

namespace servobus::scanner::test {

inline constexpr std::string_view valve_text = R"eds([File]
        DescText = "Valve"; CreateDate = 01-02-2024; CreateTime = 12:00:00; ModDate = 01-02-2024; ModTime = 12:00:00;
        Revision = 1.2;
[Device]
        VendCode = 77; VendName = "Acme"; ProdType = 43; ProdTypeStr = "Generic Device (keyable)"; ProdCode = 5;
        MajRev = 2; MinRev = 3; ProdName = "Valve 5"; Catalog = "V5";
[Device Classification]
        Class1 = EtherNetIP;
[Params]
        Param1 = 0, 6,"20 70 24 01 30 01", 0x0004, 0xC3,2, "Set Point","bar","What it is to hold.",
                 -100,1000,250, 1,10,1,0, ,,,, 1;
        Param2 = 0, 6,"20 70 24 01 30 02", 0x0002, 0xC6,1, "Mode","","", 0,2,1, 1,1,1,0, ,,,, 0;
        Enum2 = 0,"Off", 1,"On", 2,"Auto matic";
        Param3 = 0, 6,"20 70 24 01 30 03", 0x0010, 0xD2,2, "Status","","", 0,65535,0, 1,1,1,0, ,,,, 0;
        Param4 = 0, 6,"20 70 24 01 30 04", 0x0010, 0xCA,4, "Flow","l/min","", 0.0,100.0,0.0, 1,1,1,0, ,,,, 2;
        Param5 = 0, 6,"20 70 24 01 30 05", 0x0000, 0xDA,33, "Tag","","", 0,32,"", ,,,, ,,,, 0;
        Param6 = 0, ,, 0x0000, 0xC8,4, "RPI","us","", 2000,100000,20000, 1,1,1,0, ,,,, 0;
        Param7 = 0, ,, 0x0000, 0xC1,1, "Opened","","", 0,1,0, 1,1,1,0, ,,,, 0;
        Param8 = 0, ,, 0x0000, 0xC1,1, "Closed","","", 0,1,0, 1,1,1,0, ,,,, 0;
        Param9 = 0, 6,"20 70 24 01 30 09", 0x0010, 0xC9,8, "Cycles","","", ,,, 1,1,1,0, ,,,, 0;
[Assembly]
        Object_Name = "Assembly Object"; Object_Class_Code = 0x04;
        Assem100 = "Inputs", "20 04 24 64 30 03", 8, 0x0000, ,, 16,Param3, 1,Param7, 1,Param8, 6,, 8,Param2, 32,Param4;
        Assem150 = "Outputs", "20 04 24 96 30 03", 4, 0x0000, ,, 16,Param1, 8,Param2, 1,Param7, 1,Param7, 6,;
        Assem151 = "Configuration", "20 04 24 97 30 03", 3, 0x0000, ,, 16,Param1, 8,Param2;
[Connection Manager]
        Object_Name = "Connection Manager Object"; Object_Class_Code = 0x06;
        Connection1 = 0x04030002, 0x44640405, Param6,,Assem150, Param6,,Assem100, ,, ,Assem151,
                 "Exclusive Owner", "", "20 04 24 97 2C 96 2C 64";
        Connection2 = 0x02010002, 0x44640305, Param6,0,, Param6,,Assem100, ,, ,,
                 "Input Only", "", "20 04 24 97 2C FE 2C 64";
        Connection3 = 0x01010002, 0x44240305, Param6,0,, Param6,,Assem100, ,, ,,
                 "Listen Only", "", "20 04 24 97 2C FF 2C 64";
)eds";

/// A text that can be read, whatever may be found in it.
inline eds::DataSheet sheet_of(std::string_view text) {
    auto sheet = eds::read(text);
    EXPECT_TRUE(sheet) << to_text(sheet.error());
    return sheet ? std::move(*sheet) : eds::DataSheet{};
}

inline eds::DataSheet valve() {
    auto sheet = sheet_of(valve_text);
    for (const auto& finding : sheet.findings) ADD_FAILURE() << to_text(finding);
    return sheet;
}

/// A file that is gone with this object.
class SheetFile {
public:
    explicit SheetFile(std::string_view text = valve_text) { std::ofstream(path_, std::ios::binary) << text; }
    ~SheetFile() { std::filesystem::remove(path_); }
    SheetFile(const SheetFile&) = delete;
    SheetFile& operator=(const SheetFile&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }

private:
    static std::string name() {
        static int count = 0;
        return "servobus-sheet-" + std::to_string(getpid()) + '-' + std::to_string(++count) + ".eds";
    }
    const std::string path_ = (std::filesystem::temp_directory_path() / name()).string();
};

/// The text with one place changed, which has to be there once.
inline std::string altered(std::string text, std::string_view from, std::string_view to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    EXPECT_EQ(text.find(from, at + 1), std::string::npos) << from << " is there twice";
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return text;
}

}  // namespace servobus::scanner::test
