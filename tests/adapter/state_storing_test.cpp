// Drives, their files and the directory: what is there again in the next process, and who may use it.
#include "adapter/state_storing.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <deque>
#include <string>

#include "tests/adapter/fragile_files.hpp"
#include "tests/adapter/peers.hpp"

namespace servobus::test {
namespace {

using adapter::FileSystem;
using adapter::PosixFileSystem;
using adapter::StateDirectory;
using adapter::StateStoring;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::string_view set_s_curve = "10 03 20 64 24 01 30 00 32 00 00 00";
constexpr std::string_view get_s_curve = "0E 03 20 64 24 01 30 00";
constexpr std::string_view get_status = "0E 03 20 01 24 01 30 05";
const std::string set_done = hex("90 00 00 00");
const std::string s_curve_of_50 = hex("8E 00 00 00 32 00 00 00");
const std::string s_curve_of_20 = hex("8E 00 00 00 14 00 00 00");

class Directory : public testing::Test {
protected:
    Directory() {
        std::string pattern = testing::TempDir() + "servobus-state-XXXXXX";
        path_ = ::mkdtemp(pattern.data());
    }
    ~Directory() override { std::filesystem::remove_all(path_); }

    StateDirectory must_open() const {
        auto opened = StateDirectory::open(path_);
        if (const auto* reason = std::get_if<std::string>(&opened)) {
            ADD_FAILURE() << *reason;
            std::abort();
        }
        return std::get<StateDirectory>(std::move(opened));
    }

    std::filesystem::path path_;
};

TEST_F(Directory, IsMadeWhenItsParentIsThere) {
    const auto inner = path_ / "inner";
    EXPECT_TRUE(std::holds_alternative<StateDirectory>(StateDirectory::open(inner)));
    EXPECT_TRUE(std::filesystem::is_directory(inner));
    const auto missing = StateDirectory::open(path_ / "a" / "b");
    EXPECT_THAT(std::get<std::string>(missing), HasSubstr("No such file or directory"));
}

TEST_F(Directory, HasAFileForEachSerialNumber) {
    EXPECT_EQ(must_open().file_of(0xA1B2C3), std::filesystem::absolute(path_) / "drive-00A1B2C3.state");
}

TEST_F(Directory, IsNobodyElsesMeanwhile) {
    {
        const auto first = must_open();
        const auto second = StateDirectory::open(path_);
        ASSERT_TRUE(std::holds_alternative<std::string>(second));
        EXPECT_EQ(std::get<std::string>(second),
                  fmt::format("the state in '{}' is another servobus-adapter's, process {}; stop it, or choose another "
                              "--state",
                              path_.string(), ::getpid()));
    }
    EXPECT_TRUE(std::holds_alternative<StateDirectory>(StateDirectory::open(path_))) << "the lock goes with its holder";
}

TEST_F(Directory, ThatIsNoneIsRefused) {
    const auto file = path_ / "file";
    ASSERT_FALSE(PosixFileSystem().write(file, "text"));
    const auto opened = StateDirectory::open(file);
    EXPECT_THAT(std::get<std::string>(opened), HasSubstr("Not a directory"));
}

TEST_F(Directory, WithALockThatIsADirectoryIsRefused) {
    std::filesystem::create_directory(path_ / "lock");
    const auto opened = StateDirectory::open(path_);
    EXPECT_THAT(std::get<std::string>(opened), HasSubstr("Is a directory"));
}

/// One process after the other, each with one drive. Jobs run when the test says so.
class Storing : public Directory {
protected:
    struct Process {
        Process(FileSystem& files, StateDirectory directory)
            : storing(
                  files, std::move(directory),
                  [this](adapter::Adapter&, std::function<void()> job, std::function<void(enip::Time)> done) {
                      jobs.push_back(std::move(job));
                      dones.push_back(std::move(done));
                  },
                  [this](adapter::LogLevel, std::string_view line) { site.log.emplace_back(line); }) {
            storing.keep(site.adapter);
        }
        void work() {
            while (!jobs.empty()) {
                jobs.front()();
                jobs.pop_front();
                dones.front()(site.now);
                dones.pop_front();
            }
        }
        /// The reply to a write, once it is stored.
        std::string call(Peer& peer, std::string_view request) {
            const auto at_once = peer.call(request);
            if (!at_once.empty()) return at_once;
            work();
            const auto octets = site.adapter.take_replies(peer.id());
            const auto frame = enip::Frame::parse(octets);
            const auto data = frame ? enip::SendData::parse(frame->data) : cip::DecodeError::truncated;
            const auto message = data ? enip::unconnected_message(*data) : cip::DecodeError::truncated;
            return message ? hex(*message) : "";
        }

        Site site;
        std::deque<std::function<void()>> jobs;
        std::deque<std::function<void(enip::Time)>> dones;
        StateStoring storing;
    };

    std::unique_ptr<Process> start() { return std::make_unique<Process>(files_, must_open()); }
    std::filesystem::path file() const { return std::filesystem::absolute(path_) / "drive-00A1B2C3.state"; }

    FragileFiles files_;
};

TEST_F(Storing, AWriteIsThereInTheNextProcess) {
    {
        const auto process = start();
        auto peer = registered(process->site);
        EXPECT_EQ(process->call(peer, set_s_curve), set_done);
        EXPECT_EQ(process->call(peer, "10 03 20 F5 24 01 30 06 0600 70 72 65 73 73 37"), set_done) << "host name";
    }
    const auto next = start();
    auto peer = registered(next->site);
    EXPECT_EQ(peer.call(get_s_curve), s_curve_of_50);
    EXPECT_EQ(peer.call("0E 03 20 F5 24 01 30 06"), hex("8E 00 00 00 0600 70 72 65 73 73 37"));
    EXPECT_EQ(peer.call(get_status), hex("8E 00 00 00 3400"));
    EXPECT_THAT(next->site.log, Contains(HasSubstr("the state is that of")));
}

TEST_F(Storing, AStaticAddressIsThereInTheNextProcess) {
    const std::string address = "640210AC 00FFFFFF 010210AC 00000000 00000000 0000";
    {
        const auto process = start();
        auto peer = registered(process->site);
        EXPECT_EQ(process->call(peer, "10 03 20 F5 24 01 30 03 00 00 00 00"), set_done);
        EXPECT_EQ(process->call(peer, "10 03 20 F5 24 01 30 05" + address), set_done);
    }
    const auto next = start();
    auto peer = registered(next->site);
    EXPECT_EQ(peer.call("0E 03 20 F5 24 01 30 03"), hex("8E 00 00 00 00 00 00 00"));
    EXPECT_EQ(peer.call("0E 03 20 F5 24 01 30 05"), hex("8E 00 00 00" + address));
}

TEST_F(Storing, FactoryDefaultsAreThereInTheNextProcess) {
    {
        const auto process = start();
        auto peer = registered(process->site);
        EXPECT_EQ(process->call(peer, set_s_curve), set_done);
        EXPECT_EQ(process->call(peer, "05 02 20 01 24 01 01"), hex("85 00 00 00"));
    }
    const auto next = start();
    auto peer = registered(next->site);
    EXPECT_EQ(peer.call(get_s_curve), s_curve_of_20);
    EXPECT_EQ(peer.call(get_status), hex("8E 00 00 00 3000"));
}

TEST_F(Storing, AFullDiskRefusesTheWriteAndIsNamed) {
    {
        const auto process = start();
        auto peer = registered(process->site);
        EXPECT_EQ(process->call(peer, set_s_curve), set_done);
        files_.heal();
        files_.fail_at(1, std::make_error_code(std::errc::no_space_on_device));
        EXPECT_EQ(process->call(peer, "10 03 20 64 24 01 30 00 33 00 00 00"), hex("90 00 19 00"));
        EXPECT_THAT(process->site.log, Contains(HasSubstr("drive-00A1B2C3.state cannot be stored: No space left")));
        EXPECT_EQ(peer.call(get_s_curve), s_curve_of_50);
        EXPECT_EQ(process->call(peer, "10 03 20 64 24 01 30 00 34 00 00 00"), set_done) << "there is room again";
    }
    const auto next = start();
    auto peer = registered(next->site);
    EXPECT_EQ(peer.call(get_s_curve), hex("8E 00 00 00 34 00 00 00"));
}

TEST_F(Storing, AnyFileThatIsOfNoUseIsKeptAsideAndTheIdentityTellsSo) {
    const auto sealed = [](const std::string& payload) { return adapter::seal(payload); };
    const std::vector<std::pair<std::string, std::string>> files{
        {"", "damaged-1"},
        {"garbage", "damaged-2"},
        {sealed("{}").substr(0, 20), "damaged-3"},
        {"servobus-state 1 00000000 2\n{}", "damaged-4"},
        {sealed("no json"), "damaged-5"},
        {sealed(R"({"parameters":{"0x64/0x00":"fifty"}})"), "damaged-6"},
        {sealed(R"({"network":{"colour":"red"}})"), "damaged-7"},
        {"servobus-state 0 00000000 2\n{}", "damaged-8"},
        {"servobus-state 2 whatever comes\n", "newer-1"},
    };
    for (const auto& [content, name] : files) {
        files_.put(file(), content);
        const auto process = start();
        EXPECT_EQ(files_.files().count(file()), 0U) << name;
        const auto aside = files_.files().find(file().string() + "." + name);
        ASSERT_NE(aside, files_.files().end()) << name;
        EXPECT_EQ(aside->second, content);
        EXPECT_THAT(process->site.log, Contains(HasSubstr("it is kept as drive-00A1B2C3.state." + name)));
        auto peer = registered(process->site);
        EXPECT_EQ(peer.call(get_s_curve), s_curve_of_20);
        EXPECT_EQ(peer.call(get_status), hex("8E 00 00 00 4000")) << name;
        EXPECT_EQ(process->call(peer, set_s_curve), set_done);
        EXPECT_EQ(peer.call(get_status), hex("8E 00 00 00 3400"));
    }
}

TEST_F(Storing, WhatIsWrittenUnderWayIsFinishedAtTheEnd) {
    {
        const auto process = start();
        auto peer = registered(process->site);
        EXPECT_EQ(peer.call(set_s_curve), "");
        process->jobs.front()();  // the process is told to stop before the reply
        process->storing.finish();
    }
    const auto next = start();
    auto peer = registered(next->site);
    EXPECT_EQ(peer.call(get_s_curve), s_curve_of_50);
}

TEST_F(Storing, ADriveThatNothingIsWrittenToHasNoFile) {
    {
        const auto process = start();
        auto peer = registered(process->site);
        EXPECT_EQ(peer.call(get_s_curve), s_curve_of_20);
        process->work();
        process->storing.finish();
    }
    EXPECT_THAT(files_.files(), IsEmpty());
}

}  // namespace
}  // namespace servobus::test
