// The real adapter as a process, each test with a drive of its own.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "tests/scanner/run_scanner.hpp"
#include "tests/support/places.hpp"

namespace servobus::scanner::test {

class RunningAdapter : public testing::Test {
protected:
    void SetUp() override { start(); }
    void TearDown() override { stop(); }

    void start() {
        const auto adapter = servobus::test::program_path("servobus-adapter");
        // A loopback address that no other test has.
        const auto number = static_cast<unsigned>(getpid()) & 0xFFFFU;
        host = "127.88." + std::to_string(number >> 8) + "." + std::to_string(number & 0xFF);
        std::vector<std::string> words{adapter,       "--bind", host,        "--port",      "44818",
                                       "--log-level", "error",  "--control", control_path()};
        words.insert(words.end(), options.begin(), options.end());
        std::vector<char*> argv;
        for (auto& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", 1, 0);
        ASSERT_EQ(posix_spawn(&adapter_, adapter.c_str(), &actions, nullptr, argv.data(), environ), 0);
        posix_spawn_file_actions_destroy(&actions);
        for (int i = 0; i < 200; ++i) {
            if (run_scanner({"call", host, "0x0E", "1/1/1"}).code == 0) return;
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
        FAIL() << "the adapter does not answer";
    }

    /// In good manners.
    void stop() {
        const int status = end(SIGTERM);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    }
    /// As when its power goes.
    void crash() { (void)end(SIGKILL); }

    std::string file(const std::string& name) const {
        return (std::filesystem::temp_directory_path() / ("servobus-" + std::to_string(getpid()) + name)).string();
    }
    std::string control_path() const { return file(".control"); }

    /// A line to the control socket of the drive; the line that answers it.
    std::string control(const std::string& line) const {
        const int descriptor = socket(AF_UNIX, SOCK_STREAM, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::strncpy(address.sun_path, control_path().c_str(), sizeof address.sun_path - 1);
        EXPECT_EQ(connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        const auto text = line + "\n";
        EXPECT_EQ(write(descriptor, text.data(), text.size()), static_cast<ssize_t>(text.size()));
        std::string answer;
        for (char octet = 0; read(descriptor, &octet, 1) == 1 && octet != '\n';) answer += octet;
        close(descriptor);
        return answer;
    }

    std::string host;
    std::vector<std::string> options;  ///< of the program, beside the usual ones; before start()

private:
    int end(int signal) {
        int status = 0;
        if (adapter_ <= 0) return status;
        kill(adapter_, signal);
        waitpid(adapter_, &status, 0);
        adapter_ = 0;
        return status;
    }

    pid_t adapter_ = 0;
};

}  // namespace servobus::scanner::test
