// What is fuzzed. A target is a function of octets that nobody has written on purpose; it says itself what must hold, and ends
// the program with a sentence when that does not hold. libFuzzer calls it (libfuzzer.cpp), and so do ordinary tests over
// what is committed in corpus/ and regressions/ (corpus_test.cpp). docs/fuzzing.md lists the properties.
#pragma once

#include <span>
#include <string_view>

#include "cip/bytes.hpp"

namespace servobus::fuzz {

// Each is in the file of its name, fuzz_<name>.cpp.
void adapter(cip::ByteView input);
void capture(cip::ByteView input);
void common_packet(cip::ByteView input);
void config(cip::ByteView input);
void eds(cip::ByteView input);
void encapsulation(cip::ByteView input);
void file_upload(cip::ByteView input);
void forward_open(cip::ByteView input);
void io_packet(cip::ByteView input);
void link(cip::ByteView input);
void message(cip::ByteView input);
void message_router(cip::ByteView input);
void path(cip::ByteView input);
void ptp_answers(cip::ByteView input);
void scanner_replies(cip::ByteView input);
void session(cip::ByteView input);

struct Target {
    std::string_view name;
    void (*run)(cip::ByteView input);
};

/// All of them, by name.
[[nodiscard]] std::span<const Target> targets();

}  // namespace servobus::fuzz
