// The file of a drive's state: whole or not at all, whatever fails, and of no use when it is not what it should be.
#include "adapter/state_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <iterator>
#include <random>
#include <string>

#include "tests/adapter/fragile_files.hpp"

namespace servobus::adapter {
namespace {

using test::FragileFiles;
using testing::HasSubstr;
using testing::StartsWith;

const std::filesystem::path path = "/state/drive-00000001.state";

std::string reason_of(const std::string& octets) {
    const auto result = unseal(octets);
    const auto* bad = std::get_if<BadState>(&result);
    return bad != nullptr ? bad->reason : "it is whole";
}

/// The payload as a new process finds it.
std::string found(FragileFiles& files) {
    StateFile file(files, path);
    const auto loaded = file.load();
    if (!loaded) return "no file";
    if (const auto* bad = std::get_if<BadState>(&*loaded)) return "bad: " + bad->reason;
    return std::get<std::string>(*loaded);
}

TEST(SealedState, IsALineAndThePayload) {
    // The CRC-32 of "123456789" is in every table of them.
    EXPECT_EQ(seal("123456789"), "servobus-state 1 CBF43926 9\n123456789");
    EXPECT_EQ(std::get<std::string>(unseal(seal("123456789"))), "123456789");
    EXPECT_EQ(std::get<std::string>(unseal(seal(""))), "");
    EXPECT_EQ(std::get<std::string>(unseal(seal("two\nlines\n"))), "two\nlines\n");
}

TEST(SealedState, ThatLacksItsEndIsDamagedWhereverItEnds) {
    const auto whole = seal("{\"network\":{}}\n");
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const auto result = unseal(whole.substr(0, size));
        ASSERT_TRUE(std::holds_alternative<BadState>(result)) << size;
        EXPECT_EQ(std::get<BadState>(result).kind, BadState::Kind::damaged);
    }
    EXPECT_EQ(reason_of(whole.substr(0, whole.size() - 1)), "it should have 15 octets and has 14");
    EXPECT_EQ(reason_of(whole + "x"), "it should have 15 octets and has 16");
}

TEST(SealedState, WithOneBitThatIsWrongIsNotTaken) {
    const std::string payload = "{\"network\":{}}\n";
    const auto whole = seal(payload);
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
        auto spoilt = whole;
        spoilt[bit / 8] = static_cast<char>(static_cast<unsigned char>(spoilt[bit / 8]) ^ 1U << bit % 8);
        const auto result = unseal(spoilt);
        // A hexadecimal digit may change its case and still be the same.
        const auto* same = std::get_if<std::string>(&result);
        EXPECT_TRUE(same == nullptr || *same == payload) << bit;
    }
}

TEST(SealedState, OfAnotherKindOrVersionIsNamed) {
    EXPECT_EQ(reason_of("garbage"), "it is no state of a drive");
    EXPECT_EQ(reason_of("garbage 1 00000000 0\n"), "it is no state of a drive");
    EXPECT_EQ(reason_of("servobus-state\n"), "it is no state of a drive");
    EXPECT_EQ(reason_of("servobus-state 0 00000000 0\n"), "its version is no number from 1 on");
    EXPECT_EQ(reason_of("servobus-state one 00000000 0\n"), "its version is no number from 1 on");
    EXPECT_EQ(reason_of("servobus-state 1 00000000\n"), "its first line is not whole");
    EXPECT_EQ(reason_of("servobus-state 1 xyz 0\n"), "its first line is not whole");
    EXPECT_EQ(reason_of("servobus-state 1 00000001 0\n"), "its checksum is wrong");
    const auto newer = unseal("servobus-state 2 anything else\nat all");
    ASSERT_TRUE(std::holds_alternative<BadState>(newer));
    EXPECT_EQ(std::get<BadState>(newer).kind, BadState::Kind::newer);
    EXPECT_EQ(std::get<BadState>(newer).reason, "it has version 2, and this program knows 1");
}

TEST(SealedState, TakesAnyOctetsWithoutTrouble) {
    std::mt19937 random(1);
    for (int i = 0; i < 10'000; ++i) {
        std::string octets(random() % 64, '\0');
        for (auto& c : octets) c = static_cast<char>(random());
        EXPECT_TRUE(std::holds_alternative<BadState>(unseal(octets)));
        EXPECT_TRUE(std::holds_alternative<BadState>(unseal("servobus-state 1 " + octets)));
    }
}

TEST(StateFile, IsThereOnceItIsStored) {
    FragileFiles files;
    EXPECT_EQ(found(files), "no file");
    StateFile file(files, path);
    EXPECT_EQ(file.store("old"), std::error_code());
    files.cut_power(FragileFiles::Renames::lost);
    EXPECT_EQ(found(files), "old");
    EXPECT_EQ(file.store("new"), std::error_code());
    files.cut_power(FragileFiles::Renames::lost);
    EXPECT_EQ(found(files), "new");
    EXPECT_EQ(files.files().size(), 1U) << "and nothing beside it";
}

class OperationsThatFail : public testing::TestWithParam<std::errc> {};

// Each operation in turn: the one before is there at once and after power-off, and the next attempt succeeds.
TEST_P(OperationsThatFail, LeaveTheStateBefore) {
    for (const bool had_one : {false, true}) {
        const std::string before = had_one ? "old" : "no file";
        for (std::size_t number = 1;; ++number) {
            FragileFiles files;
            StateFile file(files, path);
            if (had_one) {
                ASSERT_FALSE(file.store("old"));
            }
            files.heal();
            files.fail_at(number, std::make_error_code(GetParam()));
            const auto error = file.store("new");
            if (!error) {
                EXPECT_EQ(number, 4U) << "write, rename, synchronise";
                break;
            }
            EXPECT_EQ(error, GetParam()) << number;
            EXPECT_EQ(found(files), before) << number;
            files.cut_power(FragileFiles::Renames::kept);
            EXPECT_EQ(found(files), before) << number;
            EXPECT_FALSE(file.store("new")) << number;
            files.cut_power(FragileFiles::Renames::lost);
            EXPECT_EQ(found(files), "new") << number;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Errors, OperationsThatFail,
                         testing::Values(std::errc::no_space_on_device, std::errc::io_error,
                                         std::errc::read_only_file_system, std::errc::permission_denied));

// A process that goes in the middle of anything, or power that goes then: the old or the new state, whole, and the new
// one when it has been said to be stored.
TEST(StateFile, IsWholeWhereverTheProcessOrThePowerGoes) {
    for (const auto renames : {FragileFiles::Renames::lost, FragileFiles::Renames::kept}) {
        for (const bool had_one : {false, true}) {
            bool all_done = false;
            for (std::size_t number = 1; !all_done; ++number) {
                ASSERT_LT(number, 10U);
                FragileFiles files;
                StateFile file(files, path);
                if (had_one) {
                    ASSERT_FALSE(file.store("old"));
                }
                files.heal();
                files.die_at(number);
                const bool stored = !file.store("new") && !files.is_dead();
                all_done = stored;
                EXPECT_THAT(found(files), testing::AnyOf(had_one ? "old" : "no file", "new")) << number;
                files.cut_power(renames);
                const auto afterwards = found(files);
                EXPECT_THAT(afterwards, testing::AnyOf(had_one ? "old" : "no file", "new")) << number;
                if (stored) {
                    EXPECT_EQ(afterwards, "new");
                }
                StateFile next(files, path);
                (void)next.load();
                EXPECT_FALSE(next.store("newer")) << "what is left does not stand in the way";
                EXPECT_EQ(found(files), "newer");
            }
        }
    }
}

TEST(StateFile, ThatIsTooLongIsNeitherReadNorWritten) {
    FragileFiles files;
    StateFile file(files, path);
    EXPECT_EQ(file.store(std::string(max_state_octets, 'x')), std::errc::file_too_large);
    EXPECT_EQ(found(files), "no file");
    files.put(path, std::string(max_state_octets + 1, 'x'));
    EXPECT_THAT(found(files), StartsWith("bad: it cannot be read"));
}

TEST(StateFile, ThatIsOfNoUseIsKeptAsideUnderAFreeName) {
    FragileFiles files;
    for (int i = 1; i <= max_kept_aside + 2; ++i) {
        files.put(path, "garbage " + std::to_string(i));
        StateFile file(files, path);
        ASSERT_TRUE(file.load());
        const auto aside = file.keep_aside(BadState::Kind::damaged);
        ASSERT_TRUE(std::holds_alternative<std::filesystem::path>(aside));
        EXPECT_EQ(std::get<std::filesystem::path>(aside),
                  path.string() + ".damaged-" + std::to_string(std::min(i, max_kept_aside)));
        EXPECT_EQ(found(files), "no file");
    }
    EXPECT_EQ(files.files().size(), static_cast<std::size_t>(max_kept_aside));
    EXPECT_EQ(files.files().at(path.string() + ".damaged-1"), "garbage 1");
    EXPECT_EQ(files.files().at(path.string() + ".damaged-9"), "garbage 11") << "the last one has made room";
    files.put(path, "servobus-state 2\n");
    StateFile file(files, path);
    ASSERT_TRUE(file.load());
    EXPECT_EQ(std::get<std::filesystem::path>(file.keep_aside(BadState::Kind::newer)), path.string() + ".newer-1");
}

TEST(StateFile, ThatCannotBeKeptAsideSaysWhy) {
    FragileFiles files;
    files.put(path, "garbage");
    files.fail_at(1, std::make_error_code(std::errc::io_error));
    StateFile file(files, path);
    EXPECT_EQ(std::get<std::error_code>(file.keep_aside(BadState::Kind::damaged)), std::errc::io_error);
}

/// The same with the operating system's files.
class PosixState : public testing::Test {
protected:
    PosixState() {
        std::string pattern = testing::TempDir() + "servobus-state-XXXXXX";
        directory_ = ::mkdtemp(pattern.data());
    }
    ~PosixState() override { std::filesystem::remove_all(directory_); }

    std::filesystem::path directory_;
    PosixFileSystem files_;
};

TEST_F(PosixState, IsStoredAndLoaded) {
    const auto file = directory_ / "a.state";
    {
        StateFile state(files_, file);
        EXPECT_EQ(state.load(), std::nullopt);
        EXPECT_FALSE(state.store("old"));
        EXPECT_FALSE(state.store(std::string(100'000, 'n')));
    }
    StateFile again(files_, file);
    const auto loaded = again.load();
    ASSERT_TRUE(loaded && std::holds_alternative<std::string>(*loaded));
    EXPECT_EQ(std::get<std::string>(*loaded), std::string(100'000, 'n'));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory_), std::filesystem::directory_iterator()), 1);
}

TEST_F(PosixState, SaysWhatTheSystemSays) {
    const auto missing = directory_ / "missing" / "a.state";
    StateFile state(files_, missing);
    EXPECT_EQ(state.load(), std::nullopt);
    EXPECT_EQ(state.store("new"), std::errc::no_such_file_or_directory);
    EXPECT_EQ(files_.remove(missing), std::errc::no_such_file_or_directory);
    EXPECT_EQ(files_.rename(missing, directory_ / "b"), std::errc::no_such_file_or_directory);
    EXPECT_EQ(files_.synchronise_directory(missing.parent_path()), std::errc::no_such_file_or_directory);
    StateFile at_directory(files_, directory_);
    const auto loaded = at_directory.load();
    ASSERT_TRUE(loaded && std::holds_alternative<BadState>(*loaded));
    EXPECT_THAT(std::get<BadState>(*loaded).reason, HasSubstr("it cannot be read"));
}

}  // namespace
}  // namespace servobus::adapter
