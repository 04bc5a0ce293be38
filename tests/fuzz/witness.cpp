#include "tests/fuzz/witness.hpp"

#include <unistd.h>

#include <array>
#include <charconv>
#include <csignal>
#include <string_view>

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/common_interface_defs.h>
#endif

namespace servobus::fuzz {
namespace {

const Witness*& present() {
    static const Witness* witness = nullptr;
    return witness;
}

void let_speak() {
    if (present() != nullptr) present()->speak();
}

extern "C" void on_signal(int number) {
    let_speak();
    std::signal(number, SIG_DFL);
    std::raise(number);
}

void say(std::string_view text) {
    while (!text.empty()) {
        const auto written = ::write(STDERR_FILENO, text.data(), text.size());
        if (written <= 0) return;
        text.remove_prefix(static_cast<std::size_t>(written));
    }
}

void say(std::size_t number) {
    std::array<char, 24> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    say({digits.data(), static_cast<std::size_t>(end - digits.data())});
}

}  // namespace

Witness::Witness(std::string target) : target_(std::move(target)) {
    present() = this;
    std::signal(SIGABRT, on_signal);
#if defined(__SANITIZE_ADDRESS__)
    __sanitizer_set_death_callback(let_speak);
#else
    for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) std::signal(number, on_signal);
#endif
}

Witness::~Witness() {
    std::signal(SIGABRT, SIG_DFL);
    present() = nullptr;
}

void Witness::expect(const std::string& file, std::size_t mutation, cip::ByteView input) {
    file_ = &file;
    mutation_ = mutation;
    input_ = input;
}

void Witness::speak() const {
    if (file_ == nullptr) return;
    say("\nThe target '");
    say(target_);
    say("' has ended the program at ");
    say(*file_);
    if (mutation_ > 0) {
        say(", changed for the time number ");
        say(mutation_);
    }
    say(":\n");
    constexpr std::string_view digits = "0123456789abcdef";
    for (const auto octet : input_) {
        const std::array pair{digits[octet >> 4U], digits[octet & 0xFU]};
        say({pair.data(), pair.size()});
    }
    say("\n");
}

}  // namespace servobus::fuzz
