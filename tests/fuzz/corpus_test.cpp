// Every target over its committed inputs, over what has once been found with it, and over a few thousand changes of them. What
// does not hold ends the program, with a sentence and the name of the input (docs/fuzzing.md).
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "tests/fuzz/mutation.hpp"
#include "tests/fuzz/targets.hpp"
#include "tests/fuzz/witness.hpp"
#include "tests/support/places.hpp"

namespace servobus::fuzz {
namespace {

namespace fs = std::filesystem;

/// Of each input. More of them, SERVOBUS_FUZZ_CHANGES=10000 for example, are other ones too: a search without clang.
std::size_t changes_of_each() {
    constexpr std::size_t usual = 50;
    const char* wanted = std::getenv("SERVOBUS_FUZZ_CHANGES");
    return wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : usual;
}
constexpr std::size_t most_committed_octets = std::size_t{300} * 1024;

struct InputFile {
    std::string name;
    cip::Bytes octets;
};

const fs::path& folder(std::string_view kind) {
    static const fs::path corpus = test::data_path("fuzz/corpus");
    static const fs::path regressions = test::data_path("fuzz/regressions");
    return kind == "corpus" ? corpus : regressions;
}

std::vector<InputFile> read_inputs(std::string_view kind, std::string_view target) {
    std::set<fs::path> paths;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder(kind) / target, none)) paths.insert(entry.path());
    std::vector<InputFile> inputs;
    for (const auto& path : paths) {
        std::ifstream file(path, std::ios::binary);
        inputs.push_back({(fs::path(kind) / target / path.filename()).string(),
                          {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}});
    }
    return inputs;
}

void run_all(const Target& target, const std::vector<InputFile>& inputs, std::size_t changes) {
    Witness witness{std::string(target.name)};
    std::vector<cip::Bytes> all;
    for (const auto& input : inputs) all.push_back(input.octets);
    std::mt19937_64 random(changes);
    for (const auto& input : inputs) {
        for (std::size_t change = 0; change <= changes; ++change) {
            const auto octets = change == 0 ? input.octets : mutate(input.octets, all, random);
            witness.expect(input.name, change, octets);
            target.run(octets);
        }
    }
}

class EachTarget : public testing::TestWithParam<Target> {};

TEST_P(EachTarget, HoldsForItsInputs) {
    const auto inputs = read_inputs("corpus", GetParam().name);
    ASSERT_FALSE(inputs.empty()) << "there are no inputs in " << folder("corpus") / GetParam().name;
    run_all(GetParam(), inputs, 0);
    run_all(GetParam(), read_inputs("regressions", GetParam().name), 0);
}

TEST_P(EachTarget, HoldsForChangesOfItsInputs) {
    run_all(GetParam(), read_inputs("corpus", GetParam().name), changes_of_each());
}

INSTANTIATE_TEST_SUITE_P(Fuzz, EachTarget, testing::ValuesIn(targets().begin(), targets().end()),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(Corpus, BelongsToTargetsAndIsSmall) {
    std::set<std::string> names;
    for (const auto& target : targets()) names.insert(std::string(target.name));
    std::uintmax_t octets = 0;
    for (const std::string_view kind : {"corpus", "regressions"}) {
        if (!fs::exists(folder(kind))) continue;
        for (const auto& entry : fs::recursive_directory_iterator(folder(kind))) {
            if (entry.is_directory()) {
                EXPECT_TRUE(names.contains(entry.path().filename())) << entry.path() << " belongs to no target";
            } else {
                octets += entry.file_size();
            }
        }
    }
    EXPECT_LT(octets, most_committed_octets);
}

TEST(Witness, NamesTheInputThatEndsTheProgram) {
    const Target planted{"planted", [](cip::ByteView input) {
                             if (input.size() > 1 && input[1] == 0x2A) std::abort();
                         }};
    const std::vector<InputFile> inputs{{"corpus/planted/first", {1, 2}}, {"corpus/planted/second", {1, 0x2A, 3}}};
    EXPECT_DEATH(run_all(planted, inputs, 0), "'planted' has ended the program at corpus/planted/second:\n012a03");
    run_all(planted, {inputs.front()}, 0);
}

TEST(Mutation, RepeatsAndChangesSomething) {
    const cip::Bytes input{1, 2, 3, 4, 5, 6, 7, 8};
    const std::array others{input};
    std::mt19937_64 one(7);
    std::mt19937_64 other(7);
    unsigned changed = 0;
    std::set<std::size_t> sizes;
    for (int i = 0; i < 200; ++i) {
        const auto octets = mutate(input, others, one);
        ASSERT_EQ(octets, mutate(input, others, other));
        if (octets != input) ++changed;
        sizes.insert(octets.size());
    }
    EXPECT_GT(changed, 190U);
    EXPECT_GT(sizes.size(), 5U) << "inputs grow and shrink";
}

}  // namespace
}  // namespace servobus::fuzz
