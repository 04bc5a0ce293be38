# Writes OUTPUT, a source file that holds the text of each of FILES (separated by "|").
string(REPLACE "|" ";" files "${FILES}")
list(LENGTH files count)
set(source "// Written by cmake/EmbedAxes.cmake.
#include \"adapter/shipped_axis_files.hpp\"

#include <array>

namespace servobus::adapter {
namespace {

constexpr std::array<ShippedAxisFile, ${count}> files{{
")
foreach(file IN LISTS files)
    get_filename_component(name "${file}" NAME)
    file(READ "${file}" text)
    string(APPEND source "    {\"${name}\", R\"servobus(${text})servobus\"},\n")
endforeach()
string(APPEND source "}};

}  // namespace

std::span<const ShippedAxisFile> shipped_axis_files() { return files; }

}  // namespace servobus::adapter
")
file(WRITE "${OUTPUT}" "${source}")
