// servobus-adapter as a person starts it: what it says, what it exits with, and how it stops.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "enip/encapsulation.hpp"
#include "enip/messages.hpp"
#include "tests/adapter/ptp_node.hpp"
#include "tests/adapter/tcp_client.hpp"
#include "tests/support/octets.hpp"
#include "tests/support/places.hpp"

extern char** environ;  // NOLINT(readability-redundant-declaration)

namespace servobus::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::StartsWith;

/// One run of the program. It is killed and reaped with this object, if it has not ended before.
class Program {
public:
    /// `terminal` takes the place of stderr, which errors() then does not tell.
    explicit Program(std::vector<std::string> arguments, int terminal = -1) {
        std::array<int, 2> in{};
        std::array<int, 2> out{};
        std::array<int, 2> err{};
        for (auto* ends : {&in, &out, &err}) {
            if (::pipe2(ends->data(), O_CLOEXEC) != 0) return;
        }
        posix_spawn_file_actions_t actions{};
        ::posix_spawn_file_actions_init(&actions);
        ::posix_spawn_file_actions_adddup2(&actions, in[0], STDIN_FILENO);
        ::posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
        ::posix_spawn_file_actions_adddup2(&actions, terminal >= 0 ? terminal : err[1], STDERR_FILENO);
        arguments.insert(arguments.begin(), program_path("servobus-adapter"));
        std::vector<char*> words;
        for (auto& word : arguments) words.push_back(word.data());
        words.push_back(nullptr);
        if (::posix_spawn(&id_, words[0], &actions, nullptr, words.data(), environ) != 0) id_ = -1;
        ::posix_spawn_file_actions_destroy(&actions);
        ::close(in[0]);
        ::close(out[1]);
        ::close(err[1]);
        in_ = in[1];
        out_ = out[0];
        err_ = err[0];
    }
    ~Program() {
        if (id_ > 0) {
            ::kill(id_, SIGKILL);
            ::waitpid(id_, nullptr, 0);
        }
        end_input();
        ::close(out_);
        ::close(err_);
    }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    void write(const std::string& text) const { ASSERT_GT(::write(in_, text.data(), text.size()), 0); }
    void end_input() {
        if (in_ >= 0) ::close(in_);
        in_ = -1;
    }
    /// The first line on stdout, empty when none comes in time.
    std::string first_line() const { return next_line(); }
    std::string next_line() const {
        std::string line;
        const auto end = Clock::now() + patience;
        for (char c = 0; Clock::now() < end;) {
            pollfd entry{out_, POLLIN, 0};
            if (::poll(&entry, 1, 100) <= 0) continue;
            if (::read(out_, &c, 1) != 1 || c == '\n') break;
            line += c;
        }
        return line;
    }
    void signal(int number) const { ::kill(id_, number); }

    /// The exit code; 1000 + n when signal n ended it, -1 when it does not end in time.
    int wait(std::chrono::milliseconds limit = patience) {
        for (const auto end = Clock::now() + limit; Clock::now() < end; std::this_thread::sleep_for(2ms)) {
            int status = 0;
            if (::waitpid(id_, &status, WNOHANG) != id_) continue;
            id_ = -1;
            return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
        }
        return -1;
    }
    /// What it has written; after it has ended.
    std::string output() const { return read_all(out_); }
    std::string errors() const { return read_all(err_); }

private:
    static std::string read_all(int descriptor) {
        std::string text;
        std::array<char, 4096> part{};
        for (auto size = ::read(descriptor, part.data(), part.size()); size > 0;
             size = ::read(descriptor, part.data(), part.size())) {
            text.append(part.data(), static_cast<std::size_t>(size));
        }
        return text;
    }

    pid_t id_ = -1;
    int in_ = -1;
    int out_ = -1;
    int err_ = -1;
};

std::uint16_t port_in(const std::string& line) {
    const auto at = line.find("127.0.0.1:");
    if (at == std::string::npos) return 0;
    return static_cast<std::uint16_t>(std::stoul(line.substr(at + 10)));
}

struct Result {
    int code;
    std::string output;
    std::string errors;
};

Result run(std::vector<std::string> arguments) {
    Program program(std::move(arguments));
    const auto code = program.wait();
    if (code < 0) return {code, "", ""};
    return {code, program.output(), program.errors()};
}

bool is_one_line(const std::string& text) { return !text.empty() && text.find('\n') == text.size() - 1; }

TEST(Process, SaysWhoItIsAndWhereItListens) {
    const Program program({"--port", "0"});
    const auto line = program.first_line();
    EXPECT_THAT(
        line,
        MatchesRegex("XENAX Xvi 75V8S \\(vendor 1389, device type 43, product code 0x7509, revision 1.1, "
                     "serial number 0x00A1B2C3\\) listens at 127.0.0.1:[0-9]+, TCP and UDP; I/O data at UDP [0-9]+"));
    TcpClient client(port_in(line));
    ASSERT_TRUE(client.register_session());
    EXPECT_EQ(hex(client.call(octets("0E 03 20 64 24 01 30 00"))), hex("8E 00 00 00 14 00 00 00"));
}

TEST(Process, ManyDrivesHaveAnAddressAndASerialNumberEach) {
    Program program({"--bind", "127.0.43.1", "--count", "4", "--port", "0"});
    std::vector<std::uint16_t> ports;
    for (int i = 0; i < 4; ++i) {
        const auto line = program.next_line();
        EXPECT_THAT(line, HasSubstr("serial number 0x00A1B2C" + std::to_string(3 + i)));
        const auto address = "127.0.43." + std::to_string(1 + i) + ":";
        ASSERT_THAT(line, HasSubstr("listens at " + address));
        ports.push_back(static_cast<std::uint16_t>(std::stoul(line.substr(line.find(address) + address.size()))));
    }
    for (int i = 0; i < 4; ++i) {
        TcpClient client(ports[static_cast<std::size_t>(i)], 0, 0x7F002B01 + static_cast<std::uint32_t>(i));
        ASSERT_TRUE(client.register_session()) << i;
        const auto serial = hex("8E 00 00 00 C" + std::to_string(3 + i) + " B2 A1 00");
        EXPECT_EQ(hex(client.call(octets("0E 03 20 01 24 01 30 06"))), serial);
        // Each has a state of its own.
        EXPECT_EQ(hex(client.call(octets("0E 03 20 64 24 01 30 00"))), hex("8E 00 00 00 14 00 00 00"));
        EXPECT_EQ(hex(client.call(octets("10 03 20 64 24 01 30 00 32 00 00 00"))), hex("90 00 00 00"));
        const auto open = client.call(octets(
            "54 02 20 06 24 01 0A 0E 00000000 0B00110A 0B00 4D00 44332211 02 000000 10270000 1848 10270000 1E48 01 04 "
            "20 04 24 01 2C 65 2C 64"));
        EXPECT_EQ(open.size(), 30U) << "an owner for each";
    }
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_THAT(program.errors(), HasSubstr("127.0.43.4: exclusive owner 101/100 of 127.0.0.1 open"));
}

TEST(Process, StopsAtSigtermWithOpenSessions) {
    for (const int number : {SIGTERM, SIGINT}) {
        Program program({"--port", "0"});
        const auto port = port_in(program.first_line());
        TcpClient registered(port);
        ASSERT_TRUE(registered.register_session());
        ASSERT_TRUE(registered.open_class3());
        const TcpClient silent(port);
        ASSERT_TRUE(silent.send(octets("65 00 04")));
        ASSERT_FALSE(registered.call(octets("0E 03 20 64 24 01 30 00")).empty());
        const auto start = Clock::now();
        program.signal(number);
        EXPECT_EQ(program.wait(), 0);
        EXPECT_LT(Clock::now() - start, 1s);
        EXPECT_TRUE(registered.closed_by_peer());
        EXPECT_TRUE(silent.closed_by_peer());
        EXPECT_THAT(program.errors(), HasSubstr("stopping: 1 sessions are closed"));
    }
}

// Whoever reads the line may stop the program at once: from then on, it ends in order.
TEST(Process, StopsInOrderAsSoonAsItHasSaidThatItListens) {
    for (int i = 0; i < 30; ++i) {
        Program program({"--port", "0", "--log-level", "error"});
        ASSERT_NE(port_in(program.first_line()), 0);
        program.signal(SIGTERM);
        ASSERT_EQ(program.wait(), 0) << "start " << i;
    }
}

TEST(Process, APortInUseIsOneLineAndExitCode3) {
    const Program first({"--port", "0"});
    const auto port = std::to_string(port_in(first.first_line()));
    const auto second = run({"--port", port});
    EXPECT_EQ(second.code, 3);
    EXPECT_EQ(second.output, "");
    EXPECT_EQ(second.errors, "servobus-adapter: cannot listen at TCP 127.0.0.1:" + port +
                                 ": Address already in use; another program listens there, stop it or choose --port or "
                                 "--bind\n");
}

TEST(Process, AnAddressOfAnotherMachineIsExitCode3) {
    const auto result = run({"--bind", "192.0.2.1", "--port", "0"});
    EXPECT_EQ(result.code, 3);
    EXPECT_TRUE(is_one_line(result.errors)) << result.errors;
    EXPECT_THAT(result.errors, HasSubstr("this machine does not have that address"));
    EXPECT_EQ(run({"--bind", "localhost", "--port", "0"}).code, 3);
}

class ProcessWithConfig : public testing::Test {
protected:
    void SetUp() override { std::filesystem::create_directories(directory_); }
    void TearDown() override { std::filesystem::remove_all(directory_); }
    std::string file(const std::string& content, const std::string& name = "drive.json") const {
        const auto path = directory_ / name;
        std::ofstream(path, std::ios::binary) << content;
        return path.string();
    }
    const std::filesystem::path directory_ =
        std::filesystem::path(testing::TempDir()) /
        ("servobus_process_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST_F(ProcessWithConfig, ABadFileIsOneLineWithItsPlaceAndExitCode2) {
    const auto path = file("{\n  \"port\": 0,\n  \"variant\": \"99v9\"\n}\n");
    const auto result = run({"--config", path});
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(result.output, "");
    EXPECT_EQ(result.errors,
              "servobus-adapter: " + path + ":3:3: 'variant' must be one of \"75v8s\", \"75v8\", \"48v8\"\n");
}

TEST_F(ProcessWithConfig, AFileThatCannotBeReadIsOneLineAndExitCode2) {
    const auto path = (directory_ / "none.json").string();
    const auto result = run({"--config", path});
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(result.errors, "servobus-adapter: " + path + ": cannot be read\n");
}

TEST_F(ProcessWithConfig, ANumberThatOverflowsIsNoCrash) {
    const auto result = run({"--config", file("{\"port\": 1e999}")});
    EXPECT_EQ(result.code, 2);
    EXPECT_THAT(result.errors, HasSubstr("drive.json:1:14: "));
    EXPECT_TRUE(is_one_line(result.errors)) << result.errors;
}

TEST_F(ProcessWithConfig, TheCommandLineWinsOverTheFile) {
    const Program program({"--config",
                           file(R"({"variant": "48v8", "port": 1, "identity": {"product_name": "Press 7"}})"), "--port",
                           "0", "--variant", "75v8"});
    EXPECT_THAT(program.first_line(), StartsWith("Press 7 (vendor 1389, device type 43, product code 0x7508"));
}

TEST_F(ProcessWithConfig, APlainResetKeepsWhatWasWrittenAndAFactoryResetWhatIsConfigured) {
    const Program program({"--config", file(R"({"port": 0, "values": {"SCurve": 77}})")});
    const auto port = port_in(program.first_line());
    const auto s_curve_after = [&](const std::string& request) {
        TcpClient client(port);
        EXPECT_TRUE(client.register_session());
        client.call(octets("10 03 20 64 24 01 30 00 32 00 00 00"));
        EXPECT_EQ(hex(client.call(octets(request))), hex("85 00 00 00"));
        EXPECT_TRUE(client.closed_by_peer());
        TcpClient next(port);
        EXPECT_TRUE(next.register_session());
        return hex(next.call(octets("0E 03 20 64 24 01 30 00")));
    };
    EXPECT_EQ(s_curve_after("05 02 20 01 24 01 00"), hex("8E 00 00 00 32 00 00 00"));
    EXPECT_EQ(s_curve_after("05 02 20 01 24 01 01"), hex("8E 00 00 00 4D 00 00 00")) << "as delivered";
}

TEST(Process, ListsTheAxes) {
    const auto result = run({"--list-axes"});
    EXPECT_EQ(result.code, 0);
    EXPECT_EQ(result.errors, "");
    EXPECT_THAT(result.output, testing::ContainsRegex("(^|\n)linax-lxc-230f10 +LINAX Lxc 230F10\n"));
}

TEST(Process, AnUnknownAxisIsRefusedWithTheOnesThereAre) {
    const auto result = run({"--axis", "linax"});
    EXPECT_EQ(result.code, 2);
    EXPECT_TRUE(is_one_line(result.errors)) << result.errors;
    EXPECT_THAT(result.errors, HasSubstr("linax-lxc-230f10"));
}

TEST_F(ProcessWithConfig, ABadAxisFileIsOneLineWithItsPlaceAndExitCode2) {
    const auto path = file("{\n  \"key\": 5\n}", "axis.json");
    const auto result = run({"--port", "0", "--axis", path});
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(result.errors,
              "servobus-adapter: " + path + ":2:3: 'key' must be a text of small letters, digits and dashes\n");
    EXPECT_EQ(run({"--config", file("{\"port\": 0, \"axis\": \"" + path + "\"}")}).errors, result.errors);
}

TEST_F(ProcessWithConfig, ABadScenarioIsOneLineWithItsPlaceAndExitCode2) {
    const auto path = file("{\"events\": [\n  {\"at\": 1}]}", "night.json");
    const auto result = run({"--port", "0", "--scenario", path});
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(result.output, "");
    EXPECT_EQ(result.errors, "servobus-adapter: " + path + ":2:3: 'event' is missing\n");
    EXPECT_EQ(run({"--config", file("{\"port\": 0, \"scenario\": \"" + path + "\"}")}).errors, result.errors);
}

TEST_F(ProcessWithConfig, AScenarioHappens) {
    const auto path = file(R"({"events": [{"at": 0.05, "event": "set-input", "number": 3}]})", "night.json");
    Program program({"--port", "0", "--scenario", path, "--control", "-"});
    ASSERT_NE(port_in(program.first_line()), 0);
    double time = 0;
    while (time < 0.05) {
        program.write("{\"query\": \"state\"}\n");
        const auto line = program.next_line();
        ASSERT_THAT(line, StartsWith("{\"ok\":true,\"time\":"));
        time = std::stod(line.substr(18));
    }
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_THAT(program.errors(), HasSubstr("event: set-input number=3 high=true\n"));
}

TEST(Process, StandardInputControlsItAndItsEndEndsNothing) {
    Program program({"--port", "0", "--control", "-"});
    const auto port = port_in(program.first_line());
    program.write("garbage\n{\"event\": \"set-input\", \"number\": 2}\n{\"query\": \"axis\"}");
    EXPECT_THAT(program.next_line(), StartsWith("{\"ok\":false,\"error\":"));
    EXPECT_EQ(program.next_line(), "{\"ok\":true}");
    program.end_input();
    EXPECT_THAT(program.next_line(), HasSubstr("\"linax-lxc-230f10\""));
    TcpClient client(port);
    ASSERT_TRUE(client.register_session());
    EXPECT_EQ(hex(client.call(octets("0E 03 20 64 24 01 30 00"))), hex("8E 00 00 00 14 00 00 00"));
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_THAT(program.errors(), HasSubstr("event: set-input number=2 high=true\n"));
}

TEST(Process, SaysInJsonThatItIsReadyAndStopsOnCommand) {
    Program program({"--bind", "127.0.13.1", "--count", "2", "--port", "0", "--ready-json", "--control", "-"});
    const auto ready = nlohmann::json::parse(program.first_line(), nullptr, false);
    ASSERT_TRUE(ready.is_object());
    EXPECT_EQ(ready["ready"], true);
    EXPECT_GT(ready["pid"].get<int>(), 0);
    EXPECT_EQ(ready["control"], nlohmann::json({"-"}));
    ASSERT_EQ(ready["drives"].size(), 2U);
    EXPECT_EQ(ready["drives"][0]["address"], "127.0.13.1");
    EXPECT_EQ(ready["drives"][1]["address"], "127.0.13.2");
    EXPECT_NE(ready["drives"][0]["port"], 0);
    EXPECT_NE(ready["drives"][0]["io_port"], 0);
    EXPECT_EQ(ready["drives"][1]["serial_number"], ready["drives"][0]["serial_number"].get<int>() + 1);
    program.write("{\"event\": \"cut-cable\", \"drive\": \"127.0.13.2\"}\n");
    EXPECT_EQ(program.next_line(), "{\"ok\":true}");
    program.write("{\"command\": \"stop\"}\n");
    EXPECT_EQ(program.next_line(), "{\"ok\":true}");
    EXPECT_EQ(program.wait(), 0);
}

TEST(Process, FaultsReachItsSockets) {
    Program program({"--port", "0", "--control", "-"});
    TcpClient client(port_in(program.first_line()));
    ASSERT_TRUE(client.register_session());
    const auto request = octets("0E 03 20 64 24 01 30 00");
    const auto reply = hex("8E 00 00 00 14 00 00 00");
    const auto control = [&](const std::string& line) {
        program.write(line + "\n");
        EXPECT_EQ(program.next_line(), "{\"ok\":true}") << line;
    };
    control(R"({"event": "delay-replies", "milliseconds": 50, "count": 1})");
    EXPECT_EQ(hex(client.call(request)), reply) << "late, and by itself";
    control(R"({"event": "cut-cable", "seconds": 0.05})");
    EXPECT_EQ(hex(client.call(request)), reply) << "when the cable is back";
    control(R"({"event": "freeze", "seconds": 0.05})");
    EXPECT_EQ(hex(client.call(request)), reply);
    control(R"({"event": "withhold-replies", "count": 1})");
    const auto data = enip::SendData::unconnected(request).encode();
    ASSERT_TRUE(client.send(
        enip::Frame{.command = enip::Command::send_rr_data, .session = client.session(), .data = data}.encode()));
    EXPECT_EQ(hex(client.call(request)), reply) << "the answer to the second one";
    control(R"({"event": "restart", "seconds": 0})");
    EXPECT_TRUE(client.closed_by_peer());
}

TEST_F(ProcessWithConfig, AnAccessIsALineOfTheLogAndALineOfJson) {
    const auto path = (directory_ / "access.jsonl").string();
    for (int run = 0; run < 2; ++run) {  // the second adds to the file
        Program program({"--port", "0", "--read-only", "--access-log", path});
        TcpClient client(port_in(program.first_line()));
        ASSERT_TRUE(client.register_session());
        EXPECT_EQ(hex(client.call(octets("10 03 20 64 24 01 30 00 32 00 00 00"))), hex("90 00 0F 00"));
        EXPECT_EQ(hex(client.call(octets("0E 03 20 64 24 01 30 00"))), hex("8E 00 00 00 14 00 00 00"));
        program.signal(SIGTERM);
        EXPECT_EQ(program.wait(), 0);
        EXPECT_THAT(program.errors(),
                    testing::ContainsRegex("warning: access refused peer=127.0.0.1:[0-9]+ session=0x[0-9A-F]+ "
                                           "via=unconnected service=Set_Attribute_Single .* name=general.SCurve "));
    }
    std::ifstream file(path);
    std::string line;
    int lines = 0;
    for (; std::getline(file, line); ++lines) {
        const auto object = nlohmann::json::parse(line, nullptr, false);
        ASSERT_TRUE(object.is_object()) << line;
        EXPECT_EQ(object["event"], "access refused");
        EXPECT_EQ(object["level"], "warning");
        EXPECT_EQ(object["name"], "general.SCurve");
        EXPECT_EQ(object["value"], "32 00 00 00");
        EXPECT_EQ(object["result"], "0x0F privilege violation");
        EXPECT_EQ(object["why"], "the drive is read-only");
        EXPECT_THAT(object["time"].get<std::string>(), MatchesRegex("20[0-9-]+T[0-9:]+\\.[0-9][0-9][0-9]Z"));
    }
    EXPECT_EQ(lines, 2);
    const auto permissions = std::filesystem::status(path).permissions();
    EXPECT_EQ(permissions, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    const auto refused = run({"--port", "0", "--access-log", (directory_ / "none" / "x").string()});
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.errors, HasSubstr("none/x: cannot be written: No such file or directory\n"));
}

TEST_F(ProcessWithConfig, ProtectionComesFromTheFileToo) {
    const Program program({"--config", file(R"({"port": 0, "protection": {"harden": true, "allow": ["127.0.0.1"]}})")});
    TcpClient client(port_in(program.first_line()));
    ASSERT_TRUE(client.register_session());
    EXPECT_EQ(hex(client.call(octets("05 02 20 01 24 01 00"))), hex("85 00 0F 00"));
    EXPECT_EQ(hex(client.call(octets("10 03 20 64 24 01 30 00 32 00 00 00"))), hex("90 00 00 00"));
}

TEST(Process, OfManyDrivesALineSaysWhich) {
    Program program({"--bind", "127.0.44.1", "--count", "2", "--port", "0", "--ready-json"});
    const auto ready = nlohmann::json::parse(program.first_line(), nullptr, false);
    ASSERT_TRUE(ready.is_object());
    TcpClient client(ready["drives"][1]["port"].get<std::uint16_t>(), 0, 0x7F002C02);
    ASSERT_TRUE(client.register_session());
    EXPECT_EQ(hex(client.call(octets("10 03 20 64 24 01 30 00 32 00 00 00"))), hex("90 00 00 00"));
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_THAT(program.errors(), HasSubstr("info: access granted drive=127.0.44.2 peer=127.0.0.1:"));
}

TEST(Process, WhoIsNotAllowedIsClosedAtOnce) {
    Program program({"--port", "0", "--allow", "192.0.2.0/24", "198.51.100.7"});
    TcpClient client(port_in(program.first_line()));
    EXPECT_TRUE(client.closed_by_peer()) << "loopback too";
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_THAT(program.errors(), HasSubstr("warning: stranger refused peer=127.0.0.1:"));

    const Program open({"--port", "0", "--allow", "192.0.2.0/24", "--allow", "127.0.0.0/8"});
    TcpClient permitted(port_in(open.first_line()));
    EXPECT_TRUE(permitted.register_session());

    const auto wrong = run({"--port", "0", "--allow", "192.0.2.1/24"});
    EXPECT_EQ(wrong.code, 2);
    EXPECT_TRUE(is_one_line(wrong.errors)) << wrong.errors;
    EXPECT_THAT(wrong.errors, HasSubstr("'192.0.2.1/24' has host bits; the network is 192.0.2.0/24"));
}

/// A terminal, and what stands on it.
class Screen {
public:
    Screen() : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
        if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0) return;
        winsize size{};
        size.ws_row = 24;
        size.ws_col = columns;
        ::ioctl(master_, TIOCSWINSZ, &size);
        slave_ = ::open(::ptsname(master_), O_RDWR | O_NOCTTY | O_CLOEXEC);
    }
    ~Screen() {
        ::close(master_);
        ::close(slave_);
    }
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    int terminal() const { return slave_; }
    /// Reads until the text has been written somewhere, at most for the usual patience.
    bool wait_for(const std::string& text) {
        for (const auto end = Clock::now() + patience; Clock::now() < end;) {
            if (written_.find(text) != std::string::npos) return true;
            read_some();
        }
        return false;
    }
    void read_some() {
        pollfd entry{master_, POLLIN, 0};
        std::array<char, 4096> part{};
        if (::poll(&entry, 1, 100) <= 0) return;
        const auto size = ::read(master_, part.data(), part.size());
        if (size > 0) written_.append(part.data(), static_cast<std::size_t>(size));
    }
    /// The lines as a person sees them; the last is the one with the cursor.
    std::vector<std::string> lines() const {
        std::vector<std::string> all(1);
        std::size_t column = 0;
        for (std::size_t i = 0; i < written_.size(); ++i) {
            auto& line = all.back();
            if (written_[i] == '\n') {
                all.emplace_back();
                column = 0;
            } else if (written_[i] == '\r') {
                column = 0;
            } else if (written_.compare(i, 3, "\x1b[K") == 0) {
                line.resize(std::min(line.size(), column));
                i += 2;
            } else {
                line.resize(std::max(line.size(), column + 1), ' ');
                line[column++] = written_[i];
            }
        }
        return all;
    }
    static constexpr unsigned short columns = 60;

private:
    int master_;
    int slave_ = -1;
    std::string written_;
};

TEST(Process, AStatusLineStaysBelowTheLog) {
    Screen screen;
    ASSERT_GE(screen.terminal(), 0);
    Program program({"--port", "0", "--status-line"}, screen.terminal());
    const auto port = port_in(program.first_line());
    ASSERT_TRUE(screen.wait_for("RUN - ERR")) << "it blinks";
    ASSERT_TRUE(screen.wait_for("RUN * ERR"));
    {
        TcpClient client(port);
        ASSERT_TRUE(client.register_session());
        EXPECT_EQ(hex(client.call(octets("10 03 20 64 24 01 30 00 00 00 00 00"))), hex("90 00 09 00"));
        ASSERT_TRUE(client.open_class3());
        ASSERT_TRUE(screen.wait_for("1 class 3"));
        for (const auto& line : screen.lines()) {
            const bool is_status = line.starts_with("RUN ");
            EXPECT_TRUE(is_status || line.empty() || std::isdigit(static_cast<unsigned char>(line[0]))) << line;
            EXPECT_TRUE(!is_status || line.size() < Screen::columns) << "it must not go on in the next line";
        }
        EXPECT_THAT(screen.lines().back(), StartsWith("RUN * ERR - ST1 - ST2 - | no owner | 0 I/O, 1 class 3"));
        EXPECT_THAT(screen.lines(),
                    testing::Contains(testing::ContainsRegex("^[0-9:.]+ warning: access refused peer=.* "
                                                             "result=\"0x09 invalid attribute value\"$")));
    }
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    ASSERT_TRUE(screen.wait_for("are closed"));
    screen.read_some();
    EXPECT_EQ(screen.lines().back(), "") << "nothing of it is left";
    EXPECT_EQ(std::ranges::count_if(screen.lines(), [](const auto& line) { return line.starts_with("RUN"); }), 0);
}

TEST(Process, WithoutATerminalThereIsNoStatusLine) {
    Program program({"--port", "0", "--status-line"});
    ASSERT_NE(port_in(program.first_line()), 0);
    std::this_thread::sleep_for(300ms);  // it would have been written by now
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_THAT(program.errors(), testing::Not(HasSubstr("RUN")));
    const auto both = run({"--port", "0", "--status-line", "--control", "-"});
    EXPECT_EQ(both.code, 2);
    EXPECT_THAT(both.errors, HasSubstr("want the same terminal"));
}

TEST(Process, WithoutControlStandardInputIsLeftAlone) {
    Program program({"--port", "0"});
    ASSERT_NE(port_in(program.first_line()), 0);
    program.write("{\"event\": \"power-cycle\"}\n");
    program.end_input();
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_EQ(program.output(), "");
}

TEST(Process, APowerCycleFromStandardInputEndsTheConnections) {
    Program program({"--port", "0", "--control", "-"});
    TcpClient client(port_in(program.first_line()));
    ASSERT_TRUE(client.register_session());
    program.write("{\"event\": \"power-cycle\"}\n");
    EXPECT_EQ(program.next_line(), "{\"ok\":true}");
    EXPECT_TRUE(client.closed_by_peer());
}

TEST_F(ProcessWithConfig, ASocketControlsItBesideStandardInput) {
    const auto path = (directory_ / "control").string();
    Program program({"--port", "0", "--control", path, "--control", "-"});
    ASSERT_NE(port_in(program.first_line()), 0);
    EXPECT_TRUE(std::filesystem::is_socket(path));
    program.write("{\"event\": \"block-axis\"}\n");
    EXPECT_EQ(program.next_line(), "{\"ok\":true}");
    const auto second = run({"--port", "0", "--control", path});
    EXPECT_EQ(second.code, 3);
    EXPECT_EQ(second.errors, "servobus-adapter: cannot listen at '" + path + "': another program listens there\n");
    program.signal(SIGTERM);
    EXPECT_EQ(program.wait(), 0);
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Process, WrongUsageIsOneLineAndExitCode2) {
    for (const auto& arguments : std::vector<std::vector<std::string>>{{"--prot", "0"},
                                                                       {"--port", "65536"},
                                                                       {"--port", "-1"},
                                                                       {"--port", "many"},
                                                                       {"--port"},
                                                                       {"--variant", "75V8S"},
                                                                       {"--log-level", "loud"},
                                                                       {"--axis", "linax"},
                                                                       {"--seed", "-1"},
                                                                       {"--control", "-", "--control", "-"},
                                                                       {"--control"},
                                                                       {"--ptp-socket", "/run/ptp4l"},
                                                                       {"--ptp-domain", "0"},
                                                                       {"--time-sync", "--ptp-domain", "256"},
                                                                       {"surplus"}}) {
        const auto result = run(arguments);
        EXPECT_EQ(result.code, 2) << arguments.front();
        EXPECT_EQ(result.output, "");
        EXPECT_THAT(result.errors, StartsWith("servobus-adapter: "));
        EXPECT_THAT(result.errors, HasSubstr("--help"));
        EXPECT_TRUE(is_one_line(result.errors)) << result.errors;
    }
}

/// The socket of a PTP node.
class PtpSocket {
public:
    explicit PtpSocket(const std::string& path) : descriptor_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof(address.sun_path) - 1);
        EXPECT_EQ(::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0) << path;
    }
    ~PtpSocket() { ::close(descriptor_); }
    PtpSocket(const PtpSocket&) = delete;
    PtpSocket& operator=(const PtpSocket&) = delete;

    /// Answers one question, if it comes soon.
    void serve() const {
        pollfd waiting{descriptor_, POLLIN, 0};
        if (::poll(&waiting, 1, 50) != 1) return;
        std::array<std::uint8_t, 256> octets{};
        sockaddr_un from{};
        socklen_t length = sizeof(from);
        auto* peer = reinterpret_cast<sockaddr*>(&from);
        const auto size = ::recvfrom(descriptor_, octets.data(), octets.size(), 0, peer, &length);
        ASSERT_GT(size, 0);
        const auto answer = node_.answer(cip::ByteView(octets).first(static_cast<std::size_t>(size)));
        EXPECT_EQ(::sendto(descriptor_, answer.data(), answer.size(), 0, peer, length),
                  static_cast<ssize_t>(answer.size()));
    }

private:
    int descriptor_;
    FakePtpNode node_;
};

std::chrono::nanoseconds time_of_day() { return std::chrono::system_clock::now().time_since_epoch(); }

// Its clock is that of this machine, in UTC until a master has said how far PTP time is ahead.
TEST_F(ProcessWithConfig, TellsWhatThePtpNodeOfItsMachineTells) {
    const auto path = (directory_ / "ptp4l").string();
    const Program program({"--port", "0", "--time-sync", "--ptp-socket", path});
    TcpClient client(port_in(program.first_line()));
    ASSERT_TRUE(client.register_session());
    const auto get = [&](unsigned attribute) {
        return client.call(octets(fmt::format("0E 03 20 43 24 01 30 {:02X}", attribute)));
    };
    const auto expect_ahead = [&](std::chrono::seconds offset) {
        constexpr auto tolerance = 50ms;  // whoever compares two clocks may be held up in between
        const auto before = time_of_day();
        const auto answer = get(4);
        const auto after = time_of_day();
        ASSERT_EQ(answer.size(), 12U);
        const auto told = cip::Reader(cip::ByteView(answer).subspan(4)).u64();
        const std::chrono::nanoseconds time(static_cast<std::int64_t>(told));
        EXPECT_GE(time, before + offset - tolerance);
        EXPECT_LE(time, after + offset + tolerance);
    };
    EXPECT_EQ(hex(get(2)), hex("8E 00 00 00 00"));
    expect_ahead(0s);
    const PtpSocket node(path);
    for (const auto end = Clock::now() + 4 * patience; Clock::now() < end;) {
        node.serve();
        if (hex(get(2)) == hex("8E 00 00 00 01")) break;
    }
    EXPECT_EQ(hex(get(8)), hex("8E 00 00 00 E6DF21FFFE788277 0600 2100 5D4E 2500 3C00 2000 0A00 0B00"));
    expect_ahead(37s);
}

TEST(Process, ASocketThatHasNoSuchPathIsOneLineAndExitCode2) {
    const auto result = run({"--port", "0", "--time-sync", "--ptp-socket", std::string(200, 'x')});
    EXPECT_EQ(result.code, 2);
    EXPECT_TRUE(is_one_line(result.errors)) << result.errors;
    EXPECT_THAT(result.errors, HasSubstr("is no path of a socket"));
}

TEST(Process, HelpAndVersionAreAnsweredOnStdout) {
    const auto help = run({"--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_EQ(help.errors, "");
    for (const auto* option : {"--variant", "--bind", "--port", "--config", "--log-level", "--axis", "--list-axes",
                               "--seed", "--scenario", "--control", "--version", "Exit codes"}) {
        EXPECT_THAT(help.output, HasSubstr(option));
    }
    const auto version = run({"--version"});
    EXPECT_EQ(version.code, 0);
    EXPECT_EQ(version.errors, "");
    EXPECT_THAT(version.output, MatchesRegex("servobus-adapter [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

}  // namespace
}  // namespace servobus::test
