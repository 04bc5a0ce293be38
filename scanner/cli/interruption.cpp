#include "scanner/cli/interruption.hpp"

#include <csignal>
#include <cstdlib>

#include "scanner/cli/exit_code.hpp"

namespace servobus::scanner::cli {
namespace {

std::atomic<int> signals{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler counts it");

void on_signal(int) {
    if (signals.fetch_add(1) > 0) std::_Exit(static_cast<int>(ExitCode::interrupted));
}

}  // namespace

Interruption::Interruption(const std::atomic<int>* instead)
    : count_(instead != nullptr ? instead : &signals), watches_signals_(instead == nullptr) {
    if (!watches_signals_) return;
    signals = 0;
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
}

Interruption::~Interruption() {
    if (!watches_signals_) return;
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
}

}  // namespace servobus::scanner::cli
