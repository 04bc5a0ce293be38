# How every target of this project is compiled, and how a folder becomes a library.

add_library(servobus_options INTERFACE)
target_compile_features(servobus_options INTERFACE cxx_std_20)
target_compile_options(servobus_options INTERFACE
    $<BUILD_INTERFACE:-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Werror>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # gcc 12 reports these falsely inside its own headers when it inlines them.
    target_compile_options(servobus_options INTERFACE
        $<BUILD_INTERFACE:-Wno-maybe-uninitialized -Wno-restrict -Wno-stringop-overflow
        -Wno-array-bounds -Wno-stringop-overread>)
endif()
if(SERVOBUS_SANITIZE)
    target_compile_options(servobus_options INTERFACE
        $<BUILD_INTERFACE:-fsanitize=${SERVOBUS_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer>)
    target_link_options(servobus_options INTERFACE $<BUILD_INTERFACE:-fsanitize=${SERVOBUS_SANITIZE}>)
    # Boost.Asio has fences, which gcc says that it cannot follow.
    if(SERVOBUS_SANITIZE STREQUAL "thread" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
        target_compile_options(servobus_options INTERFACE $<BUILD_INTERFACE:-Wno-tsan>)
    endif()
endif()

# servobus_library(<folder> SOURCES <file>... [LINKS <target>...]): target servobus_<folder>, alias servobus::<folder>.
function(servobus_library folder)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINKS")
    add_library(servobus_${folder} STATIC ${arg_SOURCES})
    add_library(servobus::${folder} ALIAS servobus_${folder})
    set_target_properties(servobus_${folder} PROPERTIES EXPORT_NAME ${folder})
    target_include_directories(servobus_${folder} PUBLIC
        $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
        $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/servobus>)
    target_link_libraries(servobus_${folder} PUBLIC servobus_options ${arg_LINKS})
endfunction()
