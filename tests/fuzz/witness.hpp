// Says which input it was when a target ends the program: a property that does not hold, an assertion, a sanitizer.
#pragma once

#include <cstddef>
#include <string>

#include "cip/bytes.hpp"

namespace servobus::fuzz {

/// There is one at a time; while it is there, it speaks.
class Witness {
public:
    explicit Witness(std::string target);
    ~Witness();
    Witness(const Witness&) = delete;
    Witness& operator=(const Witness&) = delete;

    /// What runs next: an input of a file, or the nth change of it (0: none). Both outlive the run.
    void expect(const std::string& file, std::size_t mutation, cip::ByteView input);
    /// To stderr, with nothing but system calls.
    void speak() const;

private:
    std::string target_;
    const std::string* file_ = nullptr;
    std::size_t mutation_ = 0;
    cip::ByteView input_;
};

}  // namespace servobus::fuzz
