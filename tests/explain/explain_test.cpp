// Tests that the path of a sample is explained: the record is of the path that the picture has, to the bit.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "editor/cli/explain_json.h"
#include "editor/session/cpu/scene_copy.h"
#include "editor/session/explain/explain.h"
#include "editor/session/explain/path_text.h"
#include "editor/session/session.h"
#include "tests/explain/cpu_paths.h"
#include "tests/explain/exact_records.h"
#include "tests/support/error_of.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::explain_test {

namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr Extent2D kSize{16, 12};

class ExplainTest : public testing::VulkanTest {};

PictureSettings Small() {
    PictureSettings settings;
    settings.size = kSize;
    return settings;
}

}  // namespace

// Surfaces that emit; delta lights, thin walls and rough glass; media that scatter. tests/long has all scenes.
TEST_F(ExplainTest, ContributionsOfARecordSumToTheSampleToTheBit) {
    size_t vertices = 0, lit = 0;
    for (const char* name : {"cornell", "terrace", "scattering_grid"}) {
        SCOPED_TRACE(name);
        const testing::RecordedPaths found = testing::ExpectExactRecords(
            Device(), test::SourceFile("scenes") / (std::string(name) + ".gltf"), 3);
        vertices += found.vertices;
        lit += found.lit;
    }
    EXPECT_GT(vertices, 45u) << "paths are too short to prove anything";
    EXPECT_GT(lit, 9u) << "pictures are too dark to prove anything";
}

// With the programs of the test above; tests/long has more scenes, and larger pictures.
TEST_F(ExplainTest, PathsOnTheCpuAreThoseOfTheDevice) {
    for (const char* name : {"cornell", "terrace", "scattering_grid"}) {
        SCOPED_TRACE(name);
        SceneInput input = LoadInput(test::SourceFile("scenes") / (std::string(name) + ".gltf"));
        testing::ExpectSamePaths(testing::ComparePaths(Device(), std::move(input), Small(), 3));
    }
}

TEST(CopiedMemoryTest, AReadOutsideOfTheScenesMemoryIsAnError) {
    CopiedMemory memory;
    memory.Add(0x1000, std::vector<std::byte>(24));
    EXPECT_EQ(memory.At<glm::vec3>(0x100c, 1).size(), 1u);
    for (const uint64_t address : {0xff4u, 0x1010u, 0x1018u, 0x100eu})
        EXPECT_THAT(testing::ErrorTextOf([&] { memory.At<glm::vec3>(address); }, ErrorKind::BadInput),
                    HasSubstr("reads 12 bytes at address"))
            << address;
    EXPECT_THAT(
        testing::ErrorTextOf([&] { memory.At<float>(0x1000, uint64_t{1} << 62); }, ErrorKind::BadInput),
        HasSubstr("reads"));
}

TEST(CopiedTextureTest, TexelsAreReadAsBySamplersOfADevice) {
    const auto sample = [](scene::WrapMode wrap, scene::FilterMode filter, float u, float lod = 0.0f) {
        const scene::Sampler sampler{.wrapU = wrap, .magFilter = filter};
        return CopiedTexture(sampler,
                             {{{2, 1}, {glm::vec4(0.0f), glm::vec4(1.0f)}}, {{1, 1}, {glm::vec4(4.0f)}}})
            .Sample({u, 0.5f}, lod)
            .x;
    };
    using enum scene::WrapMode;
    constexpr auto kNearest = scene::FilterMode::Nearest, kLinear = scene::FilterMode::Linear;
    EXPECT_EQ(sample(Repeat, kNearest, 1.25f), 0.0f);
    EXPECT_EQ(sample(Repeat, kNearest, -0.25f), 1.0f);
    EXPECT_EQ(sample(MirroredRepeat, kNearest, 1.25f), 1.0f);
    EXPECT_EQ(sample(MirroredRepeat, kNearest, -0.25f), 0.0f);
    EXPECT_EQ(sample(ClampToEdge, kNearest, 1.75f), 1.0f);
    EXPECT_EQ(sample(ClampToEdge, kNearest, -7.0f), 0.0f);
    EXPECT_EQ(sample(ClampToEdge, kLinear, 0.5f), 0.5f);
    EXPECT_EQ(sample(ClampToEdge, kLinear, 0.125f), 0.0f);
    EXPECT_EQ(sample(Repeat, kLinear, 0.0f), 0.5f);
    EXPECT_EQ(sample(ClampToEdge, kLinear, 0.5f, 1.0f), 4.0f);
    EXPECT_EQ(sample(ClampToEdge, kLinear, 0.5f, 0.5f), 2.25f);
    EXPECT_EQ(sample(ClampToEdge, kLinear, 0.5f, 9.0f), 4.0f);
    EXPECT_TRUE(std::isfinite(sample(Repeat, kLinear, std::numeric_limits<float>::quiet_NaN())));
}

TEST_F(ExplainTest, ASampleIsThatOfARenderAndItsPathTellsItsCause) {
    Session session(Device(), LoadInput(test::SourceFile("scenes/cornell.gltf")),
                    {.settings = Small(), .firstSample = 7, .withVariance = false});
    session.Run({.samples = 1});
    const Texels rendered = session.Result().render.radiance;
    Explainer explainer(Device(), LoadInput(test::SourceFile("scenes/cornell.gltf")), Small());
    for (const glm::uvec2 pixel : {glm::uvec2(8, 1), glm::uvec2(3, 9), glm::uvec2(12, 6)}) {
        const Explanation why = explainer.Explain({.pixel = pixel, .sample = 7});
        ASSERT_EQ(why.paths.size(), 1u);
        const ExplainedPath& path = why.paths[0];
        EXPECT_TRUE(path.isExact);
        // A render's mean of one sample is the sample, rounded to the steps of its sums
        const size_t texel = 4 * (pixel.y * kSize.width + pixel.x);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(path.value[c], rendered[texel + c], 1e-5f * (1.0f + rendered[texel + c]));
    }
    const Explanation lamp = explainer.Explain({.pixel = {3, 9}, .brightest = 2, .sampleCount = 16});
    ASSERT_EQ(lamp.paths.size(), 2u);
    EXPECT_EQ(lamp.values.size(), 16u);
    EXPECT_GE(LuminanceOf(lamp.paths[0].value), LuminanceOf(lamp.paths[1].value));
    for (const glm::vec3& value : lamp.values)
        EXPECT_LE(LuminanceOf(value), LuminanceOf(lamp.paths[0].value));
    EXPECT_EQ(lamp.paths[0].value, lamp.values[lamp.paths[0].sample]);
    EXPECT_THAT(CauseOf(lamp.paths[0], lamp.names), HasSubstr("lamp \"lamp\" of \"room\""));

    const json out = json::parse(cli::ExplanationJson(lamp));
    ASSERT_EQ(out.at("paths").size(), 2u);
    glm::vec3 sum(0.0f);
    for (const json& vertex : out["paths"][0].at("vertices"))
        for (const char* part : {"emitted", "lit"})
            for (int c = 0; c < 3; ++c) sum[c] += vertex.at(part).at(c).get<float>();
    EXPECT_EQ(sum, lamp.paths[0].value) << "the digits of JSON do not read back as the same numbers";
    EXPECT_EQ(out["paths"][0]["vertices"][0].at("event"), "surface");
}

// The lamp's radiance is the largest float: with what its light adds to it, the sum is infinite.
TEST_F(ExplainTest, DiscardedSamplesComeFirstAndSayWhereTheyAreNotFinite) {
    SceneInput input = LoadInput(test::SourceFile("scenes/cornell.gltf"));
    for (scene::Material& material : input.data.materials)
        if (material.name == "lamp") {
            material.emissiveFactor = glm::vec3(3.4e38f);
            material.emissiveStrength = 1.0f;
        }
    Explainer explainer(Device(), std::move(input), Small());
    const Explanation why = explainer.Explain({.pixel = {8, 1}, .brightest = 2, .sampleCount = 16});
    ASSERT_FALSE(why.discarded.empty()) << "no sample is infinite: the test proves nothing";
    EXPECT_EQ(why.paths[0].sample, why.discarded[0]);
    EXPECT_EQ(why.paths[0].value, glm::vec3(0.0f));
    EXPECT_THAT(CauseOf(why.paths[0], why.names), HasSubstr("discarded, black in the picture"));
    EXPECT_THAT(Describe(why), HasSubstr("of them because they are not finite"));
    EXPECT_EQ(json::parse(cli::ExplanationJson(why)).at("discarded").size(), why.discarded.size());
}

TEST_F(ExplainTest, AClampedContributionSaysSo) {
    PictureSettings clamped = Small();
    clamped.paths.biases.clampIndirect = 0.01f;
    Explainer explainer(Device(), LoadInput(test::SourceFile("scenes/cornell.gltf")), clamped);
    EXPECT_THAT(Describe(explainer.Explain({.pixel = {3, 9}, .brightest = 4})),
                HasSubstr("by --clamp-indirect"));
}

TEST_F(ExplainTest, WhatCannotBeExplainedIsRefused) {
    PictureSettings drawn = Small();
    drawn.view = View::Normals;
    const SceneInput cornell = LoadInput(test::SourceFile("scenes/cornell.gltf"));
    EXPECT_THAT(testing::ErrorTextOf([&] { const Explainer explainer(Device(), cornell, drawn); }),
                HasSubstr("view: normals has no paths"));
    Explainer explainer(Device(), cornell, Small());
    EXPECT_THAT(testing::ErrorOf([&] {
                    explainer.Explain({.pixel = {16, 3}});
                }).what(),
                HasSubstr("pixel 16,3 is outside of the picture, which has 16x12"));
    EXPECT_THAT(
        testing::ErrorTextOf([&] { explainer.Explain({.firstSample = 0xFFFFFFFFu, .sampleCount = 2}); }),
        HasSubstr("beyond the last"));
}

}  // namespace raygraph::session::explain_test
