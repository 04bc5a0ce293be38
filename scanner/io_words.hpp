// The words in which people choose how an I/O connection is: one table for those who read them and those who write them.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "cip/forward_open.hpp"
#include "cip/real_time_format.hpp"
#include "enip/io_stream.hpp"

namespace servobus::scanner {

template <class Value>
using Word = std::pair<std::string_view, Value>;

inline constexpr std::array format_words{
    Word<cip::RealTimeFormat>{"header32", cip::RealTimeFormat::header32},
    Word<cip::RealTimeFormat>{"modeless", cip::RealTimeFormat::modeless},
    Word<cip::RealTimeFormat>{"heartbeat", cip::RealTimeFormat::heartbeat},
    Word<cip::RealTimeFormat>{"zero-length", cip::RealTimeFormat::zero_length},
};
inline constexpr std::array trigger_words{
    Word<enip::Trigger>{"cyclic", enip::Trigger::cyclic},
    Word<enip::Trigger>{"cos", enip::Trigger::change_of_state},
    Word<enip::Trigger>{"application", enip::Trigger::application},
};
inline constexpr std::array priority_words{
    Word<cip::Priority>{"low", cip::Priority::low},
    Word<cip::Priority>{"high", cip::Priority::high},
    Word<cip::Priority>{"scheduled", cip::Priority::scheduled},
    Word<cip::Priority>{"urgent", cip::Priority::urgent},
};

/// The word of a value; empty when it has none.
template <class Value, std::size_t size>
[[nodiscard]] constexpr std::string_view word_of(const std::array<Word<Value>, size>& words, Value value) {
    const auto found = std::ranges::find(words, value, &Word<Value>::second);
    return found != words.end() ? found->first : std::string_view();
}

}  // namespace servobus::scanner
