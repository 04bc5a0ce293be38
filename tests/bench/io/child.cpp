#include "tests/bench/io/child.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <utility>

namespace servobus::bench {

Child::Child(std::vector<std::string> command) {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) give_up_errno("pipe");
    output_ = Descriptor(ends[0]);
    Descriptor input(ends[1]);

    std::vector<char*> words;
    for (auto& word : command) words.push_back(word.data());
    words.push_back(nullptr);
    const pid_t parent = ::getpid();
    id_ = ::fork();
    if (id_ < 0) give_up_errno("fork");
    if (id_ == 0) {
        // It must not outlive the benchmark, however that ends.
        ::prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (::getppid() != parent) ::_exit(1);
        ::dup2(input.number(), STDOUT_FILENO);
        ::execv(words[0], words.data());
        ::_exit(127);
    }
}

Child::Child(Child&& other) noexcept
    : id_(std::exchange(other.id_, -1)), output_(std::move(other.output_)), first_line_(std::move(other.first_line_)) {}

Child::~Child() {
    if (id_ > 0) stop();
}

Child Child::in_role(std::vector<std::string> words) {
    std::vector<std::string> command{"/proc/self/exe", "--role"};
    command.insert(command.end(), words.begin(), words.end());
    Child child(std::move(command));
    child.first_line_ = child.line();
    return child;
}

std::string Child::line() {
    std::string result;
    for (char c = 0; ::read(output_.number(), &c, 1) == 1;) {
        if (c == '\n') return result;
        result += c;
    }
    give_up(fmt::format("process {} ended before it said anything", id_));
}

std::string Child::stop() {
    ::kill(id_, SIGTERM);
    std::string result;
    std::array<char, 4096> part{};
    for (ssize_t got = 0; (got = ::read(output_.number(), part.data(), part.size())) > 0;) {
        result.append(part.data(), static_cast<std::size_t>(got));
    }
    ::waitpid(std::exchange(id_, -1), nullptr, 0);
    return result;
}

bool Child::runs() const {
    siginfo_t info{};
    return ::waitid(P_PID, static_cast<id_t>(id_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
}

Nanoseconds Child::cpu() const {
    Nanoseconds result = 0;
    std::error_code error;
    for (const auto& task : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", id_), error)) {
        Nanoseconds spent = 0;
        if (std::ifstream(task.path() / "schedstat") >> spent) result += spent;
    }
    return result;
}

}  // namespace servobus::bench
