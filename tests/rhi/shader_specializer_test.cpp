// Tests SPIR-V that is specialized to values of its constants, and how it is cached. It needs no device.
#include "rhi/shader_specializer.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <memory>
#include <spirv-tools/libspirv.hpp>
#include <spirv.hpp>
#include <thread>
#include <vector>

#include "base/files.h"
#include "rhi/device_cache.h"
#include "rhi/reflection.h"
#include "rhi/shader_compiler.h"
#include "shaders/embedded.h"
#include "shaders/shared/trace_options.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::rhi::shader_specializer_test {
namespace {

using test::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

namespace fs = std::filesystem;

using Words = std::vector<uint32_t>;
using Values = std::vector<SpecializationValue>;

// Each feature calls one function of its own, which no other does.
const Words& FeaturesShader() {
    static const Words words = CompileGlsl({.name = "features.comp",
                                            .text = R"(#version 460
        layout(constant_id = 3) const uint kFeatures = 3u;
        layout(constant_id = 4) const bool kIsLong = false;
        layout(constant_id = 5) const float kScale = 2.0;
        layout(binding = 0) buffer Values { float at[]; } values;
        layout(binding = 1) uniform Settings { float x; } settings;
        bool IsThird() { return (kFeatures & 4u) != 0u; }
        float First(float x) { return sin(x); }
        float Second(float x) { if (x > 1.0) return 1.0; return cos(x); }
        float Third(float x) { return atan(x); }
        float Long(float x) { for (int i = 0; i < 7; ++i) x = sqrt(x); return x; }
        void main() {
            float x = values.at[0];
            if ((kFeatures & 1u) != 0u) x += First(x);
            if ((kFeatures & 2u) != 0u && settings.x > 0.0) x += Second(x);
            if (IsThird() && x > 0.5) x += Third(x);
            if (kIsLong) x = Long(x);
            values.at[1] = x * kScale;
        })",
                                            .stage = {}});
    return words;
}

template <typename Visit>
void ForEachInstruction(const Words& words, Visit visit) {
    for (size_t at = 5; at < words.size(); at += words[at] >> spv::WordCountShift)
        visit(static_cast<spv::Op>(words[at] & spv::OpCodeMask), std::span(words).subspan(at));
}

size_t CountOf(const Words& words, spv::Op wanted) {
    size_t count = 0;
    ForEachInstruction(words, [&](spv::Op op, auto) { count += op == wanted; });
    return count;
}

// Returns what the shader computes of the features, as numbers of functions in GLSL.std.450.
std::vector<uint32_t> ComputedFunctions(const Words& words) {
    std::vector<uint32_t> functions;
    ForEachInstruction(words, [&](spv::Op op, std::span<const uint32_t> instruction) {
        if (op == spv::OpExtInst) functions.push_back(instruction[4]);
    });
    return functions;
}
constexpr uint32_t kSin = 13, kCos = 14, kAtan = 18, kSqrt = 31;

bool HasFloat(const Words& words, float wanted) {
    bool hasIt = false;
    ForEachInstruction(words, [&](spv::Op op, std::span<const uint32_t> instruction) {
        if (op == spv::OpConstant && instruction[3] == std::bit_cast<uint32_t>(wanted)) hasIt = true;
    });
    return hasIt;
}

// Returns the validator's message about a module; empty: it is valid.
std::string Faults(const Words& words) {
    std::string faults;
    spvtools::SpirvTools tools(SPV_ENV_VULKAN_1_3);
    tools.SetMessageConsumer([&](spv_message_level_t, const char*, const spv_position_t&, const char* text) {
        faults += std::string(text) + "\n";
    });
    spvtools::ValidatorOptions options;
    options.SetScalarBlockLayout(true);
    if (!tools.Validate(words.data(), words.size(), options) && faults.empty()) faults = "it is not valid";
    return faults;
}

TEST(ShaderSpecializer, WhatConstantsSwitchOffIsGone) {
    const auto functions = [](const Values& values) {
        return ComputedFunctions(SpecializeSpirv(FeaturesShader(), values));
    };
    EXPECT_THAT(functions({{3, 0}}), IsEmpty());
    EXPECT_THAT(functions({{3, 1}}), UnorderedElementsAre(kSin));
    EXPECT_THAT(functions({{3, 2}}), UnorderedElementsAre(kCos));
    EXPECT_THAT(functions({{3, 4}}), UnorderedElementsAre(kAtan)) << "a function says so";
    EXPECT_THAT(functions({{3, 0}, {4, 1}}), UnorderedElementsAre(kSqrt));
    EXPECT_THAT(functions({{3, 7}, {4, 1}}), UnorderedElementsAre(kSin, kCos, kAtan, kSqrt));
    EXPECT_THAT(functions({}), UnorderedElementsAre(kSin, kCos)) << "the defaults";
}

TEST(ShaderSpecializer, NothingIsLeftToDecide) {
    for (const uint32_t features : {0u, 1u, 6u, 7u}) {
        SCOPED_TRACE(features);
        const Words words = SpecializeSpirv(FeaturesShader(), Values{{3, features}});
        EXPECT_EQ(Faults(words), "");
        for (const spv::Op op : {spv::OpSpecConstant, spv::OpSpecConstantTrue, spv::OpSpecConstantFalse,
                                 spv::OpSpecConstantOp, spv::OpName})
            EXPECT_EQ(CountOf(words, op), 0u) << op;
        EXPECT_LT(words.size(), FeaturesShader().size());
    }
    const Words none = SpecializeSpirv(FeaturesShader(), Values{{3, 0}});
    EXPECT_EQ(CountOf(none, spv::OpFunction), 1u);
    EXPECT_EQ(CountOf(none, spv::OpBranchConditional), 0u);
}

TEST(ShaderSpecializer, ValuesTakeThePlaceOfConstants) {
    EXPECT_TRUE(HasFloat(SpecializeSpirv(FeaturesShader(), {}), 2.0f));
    const Words scaled = SpecializeSpirv(FeaturesShader(), Values{{5, std::bit_cast<uint32_t>(0.375f)}});
    EXPECT_TRUE(HasFloat(scaled, 0.375f));
    EXPECT_FALSE(HasFloat(scaled, 2.0f));
}

TEST(ShaderSpecializer, WhatIsBoundStaysBound) {
    const Words words = SpecializeSpirv(FeaturesShader(), Values{{3, 2}});
    const ShaderReflection reflection = Reflect(words, "features.comp");
    EXPECT_EQ(reflection.stage, StageKind::Compute);
    ASSERT_EQ(reflection.bindings.size(), 2u);
    EXPECT_EQ(reflection.bindings[0].binding, 0u);
    EXPECT_EQ(reflection.bindings[1].binding, 1u);
}

TEST(ShaderSpecializer, OnlyAModulesOwnValuesCount) {
    EXPECT_EQ(ValuesOf(FeaturesShader(), Values{{9, 1}, {5, 7}, {3, 6}, {0, 2}}), (Values{{3, 6}, {5, 7}}));
    EXPECT_THAT(ValuesOf(FeaturesShader(), Values{{9, 1}}), IsEmpty());
}

TEST(ShaderSpecializer, WhatIsNoModuleIsLeftAlone) {
    EXPECT_THAT(SpecializeSpirv({}, {}), IsEmpty());
    EXPECT_THAT(SpecializeSpirv(Words(100, 0x07230203u), {}), IsEmpty());
}

TEST(ShaderSpecializer, EveryShaderIsValidAfterwards) {
    // The Cornell box has these; other features of the path tracer add code of the same kind.
    const TraceFeatures features = kTraceLightSampling | kTraceTriangleLights | kTraceOpaque;
    const Values values{{9, features.x}, {12, features.y}};
    size_t specialized = 0;
    for (const EmbeddedShader& shader : EmbeddedShaders()) {
        const Values own = ValuesOf(shader.Words(), values);
        const bool isPathTracer = shader.name == "pathtrace/pathtrace.rgen";
        if (own.empty() || (shader.Words().size() > 100'000 && !isPathTracer)) continue;
        SCOPED_TRACE(shader.name);
        const Words words = SpecializeSpirv(shader.Words(), own);
        EXPECT_EQ(Faults(words), "");
        if (isPathTracer) {
            EXPECT_LT(words.size(), shader.Words().size() / 3);
        }
        ++specialized;
    }
    EXPECT_GT(specialized, 2u);
}

// ------------------------------------------------------------------------------------- what is kept

class SpecializedShadersTest : public ::testing::Test {
  protected:
    SpecializedShaders Open(std::string version = SpecializerVersion()) {
        return {folder.Path(), log.Listener(), std::move(version)};
    }
    std::vector<fs::path> Files() {
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(folder / "shaders")) files.push_back(entry.path());
        return files;
    }
    // Returns the only file, and expects that there is no other.
    fs::path File() {
        const std::vector<fs::path> files = Files();
        EXPECT_EQ(files.size(), 1u);
        return files.empty() ? fs::path() : files[0];
    }
    static void Overwrite(const fs::path& path, const std::vector<std::byte>& bytes) {
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }

    TemporaryFolder folder;
    testing::MessageLog log;
    const Values values{{3, 2}, {11, 5}};
    const Words expected = SpecializeSpirv(FeaturesShader(), values);
};

TEST_F(SpecializedShadersTest, AreMadeOnce) {
    SpecializedShaders shaders = Open();
    const auto first = shaders.Find(FeaturesShader(), values);
    ASSERT_TRUE(first);
    EXPECT_EQ(*first, expected);
    EXPECT_EQ(shaders.Find(FeaturesShader(), values), first);
    EXPECT_EQ(shaders.Find(FeaturesShader(), Values{{3, 2}}), first) << "11 is not the module's";
    EXPECT_NE(*shaders.Find(FeaturesShader(), Values{{3, 1}}), expected);
    EXPECT_NE(*shaders.Find(FeaturesShader(), Values{{5, 2}}), expected);
    EXPECT_FALSE(shaders.Find(FeaturesShader(), Values{{11, 2}})) << "it has no such constant";
    EXPECT_EQ(log.Text(), "");
}

TEST_F(SpecializedShadersTest, ThreadsThatMissAtOnceGetTheSame) {
    SpecializedShaders shaders = Open();
    std::array<SpecializedShaders::Words, 8> found;
    {
        std::vector<std::jthread> threads;
        for (SpecializedShaders::Words& words : found)
            threads.emplace_back([&] { words = shaders.Find(FeaturesShader(), values); });
    }
    ASSERT_TRUE(found[0]);
    EXPECT_EQ(*found[0], expected);
    for (const SpecializedShaders::Words& words : found) EXPECT_EQ(words, found[0]);
    // The file is enough
    const std::weak_ptr<const Words> kept = found[0];
    found = {};
    EXPECT_TRUE(kept.expired());
}

TEST_F(SpecializedShadersTest, StayInMemoryWithoutAFolder) {
    SpecializedShaders shaders({}, log.Listener(), SpecializerVersion());
    const std::weak_ptr<const Words> kept = shaders.Find(FeaturesShader(), values);
    ASSERT_FALSE(kept.expired());
    EXPECT_EQ(shaders.Find(FeaturesShader(), values), kept.lock());
}

TEST_F(SpecializedShadersTest, FilesAreReadByTheNext) {
    Open().Find(FeaturesShader(), values);
    // Another valid file under its name shows that this is the file that is read
    std::vector<std::byte> bytes = ReadFile(File());
    const size_t headerBytes = bytes.size() - expected.size() * sizeof(uint32_t);
    ASSERT_EQ(headerBytes, 40u);
    EXPECT_EQ(std::memcmp(bytes.data() + headerBytes, expected.data(), bytes.size() - headerBytes), 0);
    bytes[headerBytes + 8] ^= std::byte{1};  // a byte of the word that names the module's generator
    const uint64_t checksum = Checksum(std::span(bytes).subspan(headerBytes));
    std::memcpy(bytes.data() + 32, &checksum, sizeof(checksum));
    Overwrite(File(), bytes);
    Words changed = expected;
    changed[2] ^= 1;
    EXPECT_EQ(*Open().Find(FeaturesShader(), values), changed);
    EXPECT_EQ(log.Text(), "");
}

TEST_F(SpecializedShadersTest, DamagedFileIsRefusedAndMadeAnew) {
    Open().Find(FeaturesShader(), values);
    const fs::path path = File();
    const std::vector<std::byte> good = ReadFile(path);
    size_t refused = 0;
    for (size_t i = 0; i < good.size(); i += i < 48 ? 1 : 97) {
        std::vector<std::byte> bad = good;
        bad[i] ^= std::byte{0x10};
        Overwrite(path, bad);
        EXPECT_EQ(*Open().Find(FeaturesShader(), values), expected) << i;
        EXPECT_EQ(ReadFile(path), good) << i;
        EXPECT_EQ(log.Count(), ++refused) << i;
    }
    for (const size_t size : {size_t{0}, size_t{39}, size_t{40}, good.size() - 4}) {
        Overwrite(path, {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)});
        EXPECT_EQ(*Open().Find(FeaturesShader(), values), expected) << size;
        EXPECT_EQ(log.Count(), ++refused) << size;
    }
    EXPECT_THAT(log.All()[0].text, AllOf(HasSubstr(path.string()), HasSubstr("is made again")));
    EXPECT_EQ(log.All()[0].level, LogLevel::Warning);
}

TEST_F(SpecializedShadersTest, FileOfOtherValuesIsRefused) {
    Open().Find(FeaturesShader(), Values{{3, 1}});
    const std::vector<std::byte> other = ReadFile(File());
    fs::remove(File());
    Open().Find(FeaturesShader(), values);
    Overwrite(File(), other);
    EXPECT_EQ(*Open().Find(FeaturesShader(), values), expected);
    EXPECT_THAT(log.Text(), HasSubstr("it is of another shader"));
}

TEST_F(SpecializedShadersTest, OtherWordsValuesAndVersionsHaveFilesOfTheirOwn) {
    struct Row {
        const char* name;
        Words words;
        Values values;
        std::string version;
    };
    Words otherMaker = FeaturesShader();
    otherMaker[2] ^= 1;
    Words otherDefault = FeaturesShader();
    std::ranges::replace(otherDefault, std::bit_cast<uint32_t>(2.0f), std::bit_cast<uint32_t>(3.0f));
    const std::string version = SpecializerVersion();
    const Row rows[] = {{"plain", FeaturesShader(), values, version},
                        {"words that change nothing", otherMaker, values, version},
                        {"a constant's default", otherDefault, values, version},
                        {"value", FeaturesShader(), {{3, 1}}, version},
                        {"constant", FeaturesShader(), {{5, 2}}, version},
                        {"one more constant", FeaturesShader(), {{3, 2}, {4, 1}}, version},
                        {"version", FeaturesShader(), values, version + "x"}};
    size_t count = 0;
    for (const Row& row : rows) {
        Open(row.version).Find(row.words, row.values);
        EXPECT_EQ(Files().size(), ++count) << row.name;
    }
    for (const Row& row : rows) Open(row.version).Find(row.words, row.values);
    EXPECT_EQ(Files().size(), count);
    EXPECT_EQ(log.Text(), "");
}

TEST_F(SpecializedShadersTest, OldestFilesMakeRoomForNewOnes) {
    constexpr uint64_t kMebibyte = uint64_t{1} << 20;
    fs::create_directory(folder / "shaders");
    const auto now = fs::file_time_type::clock::now();
    const auto name = [&](int i) { return folder / ("shaders/old" + std::to_string(i) + ".spv"); };
    for (int i = 0; i < 65; ++i) {
        Overwrite(name(i), {});
        fs::resize_file(name(i), kMebibyte);  // takes no space on the disk
        fs::last_write_time(name(i), now - std::chrono::hours(100 - i));
    }
    const fs::path theirs = folder / "shaders/notes.txt";
    Overwrite(theirs, {});
    Open().Find(FeaturesShader(), values);
    EXPECT_FALSE(fs::exists(name(0)));
    EXPECT_FALSE(fs::exists(name(1)));
    EXPECT_TRUE(fs::exists(name(2)));
    EXPECT_TRUE(fs::exists(name(64)));
    EXPECT_TRUE(fs::exists(theirs));
    for (int i = 2; i < 65; ++i) fs::remove(name(i));
    fs::remove(theirs);
    EXPECT_EQ(fs::file_size(File()), 40 + expected.size() * sizeof(uint32_t));
}

TEST_F(SpecializedShadersTest, WithoutAFolderNothingIsWritten) {
    SpecializedShaders shaders({}, log.Listener(), SpecializerVersion());
    EXPECT_EQ(*shaders.Find(FeaturesShader(), values), expected);
    EXPECT_TRUE(fs::is_empty(folder.Path()));
    EXPECT_EQ(log.Text(), "");
}

TEST_F(SpecializedShadersTest, UnwritableFolderIsAMessageNotAnError) {
    Overwrite(folder / "file", {});
    SpecializedShaders shaders(folder / "file", log.Listener(LogLevel::Info), SpecializerVersion());
    EXPECT_EQ(*shaders.Find(FeaturesShader(), values), expected);
    EXPECT_THAT(log.Text(), HasSubstr("specialized shader is not saved"));
    EXPECT_EQ(log.All()[0].level, LogLevel::Info);
}

}  // namespace
}  // namespace raygraph::rhi::shader_specializer_test
