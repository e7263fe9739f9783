// Sampling of directions to the environment.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/rng.glsl"
#include "tests/shading/light_scene.h"
#include "tests/shading/random_values.h"
#include "tests/support/chi_square.h"

namespace raygraph::shading::environment_light_test {
namespace {

TEST(EnvironmentLight, DirectionsFollowTheDensityOfTheCells) {
    std::mt19937 random(16);
    testLights = {};
    testLights.SetEnvironment(RandomMap(16, 8, random), vec3(1.0f), 1.1f);
    testLights.Build();
    // Quarters of cells: halves in azimuth and in cos theta
    constexpr uint kColumns = 32, kRows = 16;
    std::vector<double> observed(kColumns * kRows, 0.0), expected(kColumns * kRows);
    for (uint row = 0; row < kRows; ++row)
        for (uint column = 0; column < kColumns; ++column)
            expected[row * kColumns + column] =
                0.25e6 * double(EnvironmentEntryAt(8u + row / 2u * 16u + column / 2u).probability);
    for (int i = 0; i < 1'000'000; ++i) {
        const float choice = Uniform(random);
        const EnvironmentSample s =
            SampleEnvironmentLight(LightSet(), choice, vec2(Uniform(random), Uniform(random)));
        const vec2 uv = EquirectFromDirection(s.wi, 1.1f);
        const uint row = min(uint(uv.y * 8.0f), 7u);
        const double cosMiddle = 0.5 * (std::cos(M_PI * row / 8.0) + std::cos(M_PI * (row + 1.0) / 8.0));
        const uint subRow = 2u * row + (double(s.wi.y) < cosMiddle ? 1u : 0u);
        observed[subRow * kColumns + min(uint(uv.x * float(kColumns)), kColumns - 1u)] += 1.0;
        ASSERT_NEAR(length(s.wi), 1.0f, 1e-5f);
    }
    EXPECT_GT(test::ChiSquareTest(observed, expected).pValue, 0.01);
}

// A choice of the table by the definition: the first entry whose end is above u.
uint ChosenByDefinition(uint first, uint count, float u) {
    uint entry = 0;
    while (entry + 1u < count && !(u < EnvironmentEntryAt(first + entry).end)) ++entry;
    return entry;
}

// Even, so that entries end where slots do, but for three black rows, of which no light reaches the middle.
image::ImageF BandedMap(uvec2 size) {
    image::ImageF map{.width = size.x, .height = size.y, .rgba = {}};
    for (uint32_t i = 0; i < 4 * size.x * size.y; ++i)
        map.rgba.push_back(float((i / 4 / size.x + 1) / 3 != 1));
    return map;
}

// The left half is 1. The right half is half of the mean, which is left to BSDF sampling, and 2^-10 to 2^-26
// of that more: entries of all numbers of steps, from one on.
image::ImageF BarelyAboveTheLevel(uvec2 size, std::mt19937& random) {
    const image::ImageF exponents = RandomMap(size.x, size.y, random);
    image::ImageF map = exponents;
    float level = 0.3f;
    for (int i = 0; i < 60; ++i) {  // the mean depends on the level
        for (uint32_t y = 0; y < size.y; ++y)
            for (uint32_t x = 0; x < size.x; ++x) {
                const size_t at = 4 * (y * size.x + x);
                const float above = std::exp2(-10.0f - 16.0f * exponents.rgba[at]);
                for (size_t c = 0; c < 3; ++c)
                    map.rgba[at + c] = 2 * x < size.x ? 1.0f : level + level * above;
            }
        level = 0.5f * BuildEnvironmentTable(map).meanRadiance.y;
    }
    return map;
}

TEST(EnvironmentLight, EachStepOfTheNumberChoosesTheEntryThatItsProbabilityCounts) {
    std::mt19937 random(18);
    for (const uvec2 size : {uvec2(1u, 1u), uvec2(16u, 8u), uvec2(7u, 5u), uvec2(301u, 3u), uvec2(13u, 6u)}) {
        testLights = {};
        const image::ImageF map = size.x == 13u ? BandedMap(size) : BarelyAboveTheLevel(size, random);
        testLights.SetEnvironment(map, vec3(1.0f));
        testLights.Build();
        uint few = 0;  // entries of at most 64 steps
        const auto expectRow = [&few](uint first, uint count, float share) {
            double sum = 0.0;
            for (uint i = 0; i < count; ++i) {
                const float begin = i > 0u ? EnvironmentEntryAt(first + i - 1u).end : 0.0f;
                const float end = EnvironmentEntryAt(first + i).end;
                ASSERT_NEAR(EnvironmentEntryAt(first + i).probability, share * (end - begin),
                            1e-6f * share * (end - begin));
                sum += double(end - begin);
                few += end > begin && end - begin <= 0x1p-18f;
                for (const float u : {begin, begin + 0x1p-24f, 0.5f * (begin + end), end - 0x1p-24f, end,
                                      float(i) / float(count), float(i + 1u) / float(count) - 0x1p-24f}) {
                    if (u < 0.0f || u > kOneMinusEpsilon) continue;
                    float rest = u;
                    ASSERT_EQ(InvertEnvironmentTable(first, count, 0.0f, rest),
                              ChosenByDefinition(first, count, u))
                        << u << " of " << count;
                    ASSERT_TRUE(rest >= 0.0f && rest < 1.0f);
                }
            }
            ASSERT_EQ(sum, 1.0);
        };
        expectRow(0u, size.y, 1.0f);
        for (uint row = 0; row < size.y; ++row)
            if (const float share = EnvironmentEntryAt(row).probability; share > 0.0f)
                expectRow(size.y + row * size.x, size.x, share);
        if (HasFatalFailure()) return;
        if (size.x != 1u && size.x != 13u) {
            EXPECT_GT(few, 0u);
        }
    }
}

// The number that decides between a light and another one must not have lost its digits when it chooses a cell.
TEST(EnvironmentLight, BesideASunEveryCellHasItsChance) {
    constexpr uint kColumns = 64;
    std::mt19937 random(20);
    LightContext context = {};
    context.normal = vec3(0.0f, 1.0f, 0.0f);
    float keep = 1.0f;
    for (float sun = 1.0f; keep * 0x1p24f > 64.0f; sun *= 4.0f) {
        ASSERT_LT(sun, 1e20f);
        testLights = {};
        testLights.SetEnvironment(RandomMap(kColumns, 2, random), vec3(1.0f));
        testLights.AddPunctual(scene::LightType::Directional, vec3(0.0f), vec3(0.0f, -1.0f, 0.0f), vec3(sun));
        testLights.Build();
        keep = LightAliasAt(LightSet().lightCount + 2u).keep;
    }
    const LightSetRecord lights = LightSet();
    const auto kept = uint(std::ceil(keep * 0x1p24f));
    ASSERT_GT(kept, 4u);
    constexpr uint kChoices = 8192;
    std::vector<double> columns(kColumns, 0.0);
    double all = 0.0;
    for (uint step = 0; step < kept; ++step)
        for (uint i = 0; i < kChoices; ++i) {
            const float uc = 0.5f + (float(i) + 0.5f) / (2.0f * kChoices);
            const LightSample light = SampleLight(context, uc, vec2(float(step) * 0x1p-24f, 0.25f));
            if (light.light != lights.lightCount) continue;
            all += 1.0;
            columns[min(uint(EquirectFromDirection(light.wi, 0.0f).x * kColumns), kColumns - 1u)] += 1.0;
        }
    EXPECT_GT(all, 0.9 * kept * kChoices);
    const uint first = lights.environmentHeight;  // the cells of the upper row
    for (uint column = 0; column < kColumns; ++column) {
        const double share =
            EnvironmentEntryAt(first + column).probability / EnvironmentEntryAt(0u).probability;
        // The last of the few steps is only in part below `keep`, and counts as a whole one
        EXPECT_GE(columns[column] / all, 0.9 * share * (kept - 1.0) / kept) << column;
        EXPECT_LT(columns[column] / all, 1.1 * share + 1.0 / kept) << column;
    }
}

TEST(EnvironmentLight, EvenNumbersGiveEvenDirections) {
    std::mt19937 random(19);
    testLights = {};
    testLights.SetEnvironment(RandomMap(16, 8, random), vec3(1.0f));
    testLights.Build();
    constexpr int kCount = 1024;
    std::vector<double> rows(8, 0.0);
    for (uint i = 0; i < kCount; ++i) {
        Sampler rng = StartPixelSample(uvec2(2u, 3u), i, 4u);
        const vec3 u = Get3D(rng);
        const vec3 wi = SampleEnvironmentLight(LightSet(), u.z, vec2(u)).wi;
        rows[min(uint(EquirectFromDirection(wi, 0.0f).y * 8.0f), 7u)] += 1.0;
    }
    // Independent numbers, or an alias table, would miss by about the root of the number
    for (uint row = 0; row < 8; ++row)
        EXPECT_NEAR(rows[row], kCount * double(EnvironmentEntryAt(row).probability), 2.0) << row;
}

TEST(EnvironmentLight, PDFIntegratesToOne) {
    std::mt19937 random(17);
    for (const uvec2 size : {uvec2(1u, 1u), uvec2(16u, 8u), uvec2(7u, 5u)}) {
        testLights = {};
        testLights.SetEnvironment(RandomMap(size.x, size.y, random), vec3(1.0f), 0.4f);
        testLights.Build();
        double integral = 0.0;
        constexpr int kCount = 1000;
        for (int i = 0; i < kCount; ++i)
            for (int j = 0; j < kCount; ++j) {
                const vec3 d = SampleUniformSphere((vec2(float(i), float(j)) + 0.5f) / float(kCount));
                integral +=
                    double(LightPDF({d, d}, LightSet().lightCount, 0u, vec3(d.x, d.z, d.y), kInfinity));
            }
        EXPECT_NEAR(integral * 4.0 * M_PI / (kCount * kCount), 1.0, 2e-3) << size.x;
    }
}

}  // namespace
}  // namespace raygraph::shading::environment_light_test
