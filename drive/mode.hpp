// The modes of operation by number: 6060h and 6061h, 0x66/0x20 and 0x21 (000 §2.3.4.3, 004 §4.2.4).
#pragma once

namespace servobus::drive::mode {

inline constexpr int jog = -1;
inline constexpr int none = 0;
inline constexpr int profile_position = 1;
inline constexpr int reference = 6;
inline constexpr int cyclic_position = 8;

}  // namespace servobus::drive::mode
