// Lines of a terminal that are written over in place.
#pragma once

#include <cstddef>
#include <ostream>
#include <string>
#include <vector>

namespace servobus::scanner::cli {

/// All of it goes out in one write, line over line and never through an empty screen, so that nothing flickers.
class LiveTable {
public:
    explicit LiveTable(std::ostream& terminal) : terminal_(terminal) {}
    ~LiveTable() { clear(); }
    LiveTable(const LiveTable&) = delete;
    LiveTable& operator=(const LiveTable&) = delete;

    /// Lines that are longer than the terminal is wide are cut by it.
    void show(const std::vector<std::string>& lines);
    /// Takes the lines away, so that something else can be said.
    void clear();

private:
    std::ostream& terminal_;
    std::size_t shown_ = 0;
};

}  // namespace servobus::scanner::cli
