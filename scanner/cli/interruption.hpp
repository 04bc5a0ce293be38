// Ctrl-C while an axis moves: counted, so that the axis can be halted first.
#pragma once

#include <atomic>

namespace servobus::scanner::cli {

/// While it lives, SIGINT and SIGTERM are counted; the second one ends the program at once.
class Interruption {
public:
    /// `instead` counts in place of the signals: for tests.
    explicit Interruption(const std::atomic<int>* instead = nullptr);
    ~Interruption();
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    [[nodiscard]] int count() const { return *count_; }

private:
    const std::atomic<int>* count_;
    bool watches_signals_;
};

}  // namespace servobus::scanner::cli
