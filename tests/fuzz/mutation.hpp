// Inputs made from others, by chance that repeats: what ordinary tests try beside the committed inputs. A fuzzer does this
// better, and for longer.
#pragma once

#include <cstdint>
#include <random>
#include <span>

#include "cip/bytes.hpp"

namespace servobus::fuzz {

/// One input changed at a few places, or with a part of another one in it. `random` decides all.
[[nodiscard]] cip::Bytes mutate(cip::ByteView input, std::span<const cip::Bytes> others, std::mt19937_64& random);

}  // namespace servobus::fuzz
