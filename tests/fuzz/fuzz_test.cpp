// Runs the fuzzing targets in every build on their seeds, on the inputs that once were findings, and on some
// thousand mutated inputs, which are the same in every run. ./dev fuzz runs longer.
#include <gtest/gtest.h>

#include <filesystem>

#include "base/files.h"
#include "tests/fuzz/gltf_files.h"
#include "tests/fuzz/mutator.h"
#include "tests/support/source_file.h"

namespace raygraph::fuzz::fuzz_test {

namespace {

class Fuzz : public ::testing::TestWithParam<Target> {
  protected:
    // Returns false after a finding.
    static bool Holds(Input input) {
        try {
            GetParam().run(input);
            return true;
        } catch (const Finding& finding) {
            ADD_FAILURE() << finding.what();
            return false;
        }
    }
};

std::string NameOf(const ::testing::TestParamInfo<Target>& target) {
    return target.param.name;
}

// Rounds that take a second or two per target.
constexpr int kRounds = 2000, kSlowRounds = 100;

}  // namespace

void PrintTo(const Target& target, std::ostream* out) {
    *out << target.name;
}

TEST_P(Fuzz, SeedsKeepThePromises) {
    const std::vector<Seed> seeds = Seeds(GetParam(), false);
    ASSERT_FALSE(seeds.empty());
    for (const Seed& seed : seeds) {
        SCOPED_TRACE(seed.name);
        Holds(seed.bytes);
    }
}

TEST_P(Fuzz, FindingsOfBeforeAreGone) {
    const std::filesystem::path folder =
        test::SourceFile("tests/fuzz/regressions") / std::filesystem::path(GetParam().name);
    if (!std::filesystem::exists(folder)) return;  // there were no findings
    for (const auto& file : std::filesystem::directory_iterator(folder)) {
        SCOPED_TRACE(file.path().string());
        Holds(ReadFile(file.path()));
    }
}

TEST_P(Fuzz, ChangedInputsKeepThePromises) {
    const std::vector<Seed> seeds = Seeds(GetParam(), false);
    std::mt19937 random(1);
    const int rounds = GetParam().isSlow ? kSlowRounds : kRounds;
    for (int round = 0; round < rounds; ++round) {
        Bytes input = Mutate(seeds, GetParam().maxBytes, random);
        if (GetParam().repair && round % 2 == 0) GetParam().repair(input);
        SCOPED_TRACE("round " + std::to_string(round));
        if (!Holds(input)) return;
    }
}

INSTANTIATE_TEST_SUITE_P(All, Fuzz, ::testing::ValuesIn(Targets().begin(), Targets().end()), NameOf);

// A target that accepts everything would find nothing.
TEST(FuzzTarget, ReportsOtherExceptionsAndLines) {
    const auto succeeds = [](const std::function<void()>& read) {
        return Succeeds("a: ", {ErrorKind::BadInput}, read);
    };
    EXPECT_TRUE(succeeds([] {}));
    EXPECT_FALSE(succeeds([] { throw Error(ErrorKind::BadInput, "a: b"); }));
    EXPECT_THROW(succeeds([] { throw Error(ErrorKind::Usage, "a: b"); }), Finding);
    EXPECT_THROW(succeeds([] { throw Error(ErrorKind::BadInput, "b"); }), Finding);
    EXPECT_THROW(succeeds([] { throw Error(ErrorKind::BadInput, "a: b\n"); }), Finding);
    EXPECT_THROW(succeeds([] { throw Error(ErrorKind::BadInput, "a: \x1b[31m"); }), Finding);
    EXPECT_THROW(succeeds([] { throw Error(ErrorKind::BadInput, "a: " + std::string(5000, 'b')); }), Finding);
    EXPECT_THROW(succeeds([] { throw std::out_of_range("a: b"); }), Finding);
    EXPECT_THROW(succeeds([] { throw Finding("b"); }), Finding);
}

// Mutations of files that are refused would not reach far.
TEST(FuzzTarget, SeedsOfGltfAreRead) {
    for (const char* name : {"gltf_text", "gltf_container", "gltf_accessors"}) {
        size_t readCount = 0;
        const std::vector<Seed> seeds = Seeds(*FindTarget(name), false);
        std::string refused;
        for (const Seed& seed : seeds) {
            const bool isDecided = std::string_view(name) == "gltf_accessors";
            const bool isRead = SharedSceneFolder().Load(isDecided ? AccessorFile(seed.bytes) : seed.bytes);
            readCount += isRead;
            if (!isRead) refused += " " + seed.name;
        }
        EXPECT_GE(4 * readCount, 3 * seeds.size()) << name << " refuses" << refused;
    }
}

// Repaired files are read, so that mutations reach the code after the checks.
TEST(FuzzTarget, RepairsLengthsAndChecksums) {
    for (const char* name : {"gltf_container", "images"}) {
        const Target& target = *FindTarget(name);
        const Seed seed = Seeds(target, false).front();
        Bytes repaired = seed.bytes;
        target.repair(repaired);
        EXPECT_EQ(repaired, seed.bytes) << name << ": what is right stays";
        Bytes broken = seed.bytes;
        for (size_t i = 0; i < 4; ++i)
            broken[name[0] == 'g' ? 8 + i : broken.size() - 4 + i] = std::byte{0x55};
        ASSERT_NE(broken, seed.bytes);
        target.repair(broken);
        EXPECT_EQ(broken, seed.bytes) << name;
    }
}

}  // namespace raygraph::fuzz::fuzz_test
