// What a person typed, read; or what is wrong with it.
#pragma once

#include <boost/system/result.hpp>
#include <string>

namespace servobus::scanner {

/// A sentence without a full stop, for the person who typed it.
struct Mistake {
    std::string text;
};

template <class T>
using Parsed = boost::system::result<T, Mistake>;

}  // namespace servobus::scanner
