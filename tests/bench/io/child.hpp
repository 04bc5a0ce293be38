// A process of the benchmark: the adapter, or this program in another role. It ends with its object, by its own id.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/bench/io/clock.hpp"
#include "tests/bench/io/sockets.hpp"

namespace servobus::bench {

class Child {
public:
    explicit Child(std::vector<std::string> command);
    Child(Child&& other) noexcept;
    Child& operator=(Child&&) = delete;
    ~Child();

    /// This program in a role (roles.hpp), after it has said what it has to say first.
    [[nodiscard]] static Child in_role(std::vector<std::string> words);

    [[nodiscard]] pid_t id() const { return id_; }
    /// The line that a role says first: the port that it has taken.
    [[nodiscard]] const std::string& first_line() const { return first_line_; }
    /// The next line of its standard output; gives up when there is none.
    [[nodiscard]] std::string line();
    /// SIGTERM; returns the rest of its standard output.
    std::string stop();
    [[nodiscard]] bool runs() const;
    /// What its threads have spent so far. Nothing more is known once it has ended.
    [[nodiscard]] Nanoseconds cpu() const;

private:
    pid_t id_ = -1;
    Descriptor output_;
    std::string first_line_;
};

}  // namespace servobus::bench
