// Tests adaptive renders: which samples a pixel is the mean of, and that nothing else changes it. It needs a
// device.
#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <random>

#include "editor/session/file/merge.h"
#include "editor/session/frames/adaptive_frames.h"
#include "editor/session/session.h"
#include "shaders/shared/mix_bits.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

// A small picture with made-up noise, whose pixels get samples without a device.
namespace raygraph::session::adaptive_picture {
inline constexpr rhi::Extent2D kPicture{24, 17};
inline constexpr size_t kPixels = size_t{24} * 17;

// Returns noise that is ten times as strong on the left as on the right, and absent on the lower rows; the
// brightness is uniform.
inline PixelVariances Noted() {
    PixelVariances noted{std::vector<float>(kPixels), std::vector<float>(kPixels, 1.0f)};
    for (size_t i = 0; i < kPixels; ++i) noted.variance[i] = i / 24 > 11 ? 0.0f : i % 24 < 12 ? 1.0f : 0.01f;
    return noted;
}

inline PixelVariances AnyNoted(uint32_t seed) {
    std::mt19937 random(seed);
    std::lognormal_distribution<float> any(0.0f, 2.0f);
    PixelVariances noted;
    for (size_t i = 0; i < kPixels; ++i) {
        noted.variance.push_back(any(random));
        noted.mean.push_back(any(random));
    }
    return noted;
}

// Advances until each color has the average, with at most `atOnce` samples per step.
inline void RunTo(AdaptiveCounts& counts, uint32_t average, uint32_t atOnce, const PixelVariances& noted) {
    using Kind = AdaptiveCounts::Next::Kind;
    while (true) {
        const AdaptiveCounts::Next next = counts.NextTo(average);
        if (next.kind == Kind::Nothing) return;
        if (next.kind == Kind::Decision)
            counts.AllocateStage(next.color, noted);
        else
            counts.Advance(next, std::min(next.length, atOnce));
    }
}

}  // namespace raygraph::session::adaptive_picture

namespace raygraph::session::session_adaptive_test {

namespace {

using test::ExpectError;

class SessionAdaptiveTest : public testing::VulkanTest {
  protected:
    static SceneInput Scene(const char* file) { return LoadInput(test::SceneFile(file)); }
    static SessionDesc Desc(const SettingTexts& texts = {}) {
        SettingTexts all = texts;
        all.insert({{"size", "20x12"}, {"adaptive", "on"}, {"brdf", "lambert"}});
        SessionDesc desc;
        desc.settings = SettingsFrom(all);
        desc.tracing.form = passes::IntegratorForm::Loop;
        return desc;
    }
    // Returns a description with everything that can be accumulated.
    static SessionDesc DescOfAll(const SettingTexts& texts = {}) {
        SessionDesc desc = Desc(texts);
        desc.settings.lightGroups = {{"all", {"*"}}};
        for (const Aov aov : kAovs) desc.aovs.Set(aov, CanHave(aov, desc.settings));
        return desc;
    }
    static RenderFile Render(const SessionDesc& desc, uint32_t average, const char* file = "cornell.gltf") {
        Session session(Device(), Scene(file), desc);
        session.Run({.samples = average});
        EXPECT_EQ(session.NonFiniteSamples(), 0u);
        return std::move(session.Result()).render;
    }
    static void ExpectSame(const RenderFile& a, const RenderFile& b) {
        EXPECT_EQ(a.samples, b.samples);
        ASSERT_TRUE(a.adaptive && b.adaptive);
        EXPECT_TRUE(a.adaptive->counts == b.adaptive->counts);
        EXPECT_TRUE(*a.adaptive == *b.adaptive);
        EXPECT_TRUE(a.radiance == b.radiance);
        EXPECT_TRUE(a.variance == b.variance);
        EXPECT_TRUE(a.sums.radiance == b.sums.radiance);
        EXPECT_TRUE(a.lightGroups == b.lightGroups);
        for (const Aov aov : kAovs) {
            const Texels *ofA = MeanOf(a, aov), *ofB = MeanOf(b, aov);
            if (ofA == nullptr) continue;
            EXPECT_TRUE(*ofA == *ofB) << Name(aov);
            EXPECT_TRUE(*SumsOf(a.sums, aov) == *SumsOf(b.sums, aov)) << Name(aov);
        }
    }
    static void ExpectRefused(const SettingTexts& texts, const char* part) {
        const SessionDesc desc = Desc(texts);
        ExpectError(
            ErrorKind::Usage, [&] { const Session session(Device(), Scene("cornell.gltf"), desc); },
            "adaptive: ", part);
    }
    // Returns whether bits can be compared after many samples; on other devices, rounding may change them.
    static bool RoundsAlike() { return Device().Info().type == rhi::DeviceType::Cpu; }
};

}  // namespace

// The samples of a pixel are thus those of any render, and only their number is chosen.
TEST_F(SessionAdaptiveTest, PixelIsTheMeanOfItsFirstSamples) {
    const RenderFile adaptive = Render(DescOfAll(), 64);
    ASSERT_TRUE(adaptive.adaptive);
    const std::vector<uint32_t>& counts = adaptive.adaptive->counts;
    EXPECT_EQ(adaptive.samples, (SampleRanges{{0, 64}}));
    EXPECT_EQ(adaptive.adaptive->Average(), 64u);
    EXPECT_GE(std::ranges::min(counts), 16u);
    std::map<uint32_t, size_t> pixelsOf;
    for (const uint32_t count : counts) ++pixelsOf[count];
    EXPECT_GE(pixelsOf.size(), 4u);
    SessionDesc uniform = DescOfAll({{"adaptive", "off"}});
    Session session(Device(), Scene("cornell.gltf"), uniform);
    size_t compared = 0, differing = 0;
    for (const auto& [count, pixels] : pixelsOf) {
        if (count > session.SampleCount()) session.Run({.samples = count});
        const RenderFile render = session.Result().render;
        for (size_t i = 0; i < counts.size(); ++i) {
            if (counts[i] != count) continue;
            ++compared;
            const auto isSame = [&](const Texels& a, const Texels& b) {
                return std::equal(&a[4 * i], &a[4 * i] + 4, &b[4 * i]);
            };
            bool isAll =
                isSame(adaptive.radiance, render.radiance) && isSame(adaptive.variance, render.variance);
            for (size_t k = 0; k < render.parts.size(); ++k)
                isAll &= isSame(adaptive.parts[k], render.parts[k]);
            for (size_t k = 0; k < render.lightGroups.size(); ++k)
                isAll &= isSame(adaptive.lightGroups[k], render.lightGroups[k]);
            differing += isAll ? 0 : 1;
        }
        if (count == std::ranges::min(counts)) {
            // Surfaces are accumulated over as many samples as every pixel has
            EXPECT_TRUE(adaptive.albedo == render.albedo);
            EXPECT_TRUE(adaptive.normal == render.normal);
        }
    }
    EXPECT_EQ(compared, counts.size());
    EXPECT_LE(differing, RoundsAlike() ? 0 : counts.size() / 20);
}

// Later stages decide by values noted at exactly the base's samples, though pixels have more by then.
TEST_F(SessionAdaptiveTest, NotedVarianceIsThatOfTheBase) {
    const RenderFile adaptive = Render(Desc(), 64);
    ASSERT_TRUE(adaptive.adaptive && !adaptive.adaptive->noted.empty());
    Session session(Device(), Scene("cornell.gltf"), Desc({{"adaptive", "off"}}));
    size_t noted = 0, differing = 0;
    for (const auto& [base, of] : adaptive.adaptive->noted) {
        session.Run({.samples = base});
        const RenderFile uniform = session.Result().render;
        const auto sumOf = [](const Texels& texels, size_t i) {
            return texels[4 * i] + texels[4 * i + 1] + texels[4 * i + 2];
        };
        for (size_t i = 0; i < of.variance.size(); ++i) {
            const bool isNoted = adaptive.adaptive->counts[i] > base;
            noted += isNoted ? 1 : 0;
            differing += of.variance[i] == (isNoted ? sumOf(uniform.variance, i) : 0.0f) ? 0 : 1;
            differing += of.mean[i] == (isNoted ? sumOf(uniform.radiance, i) : 0.0f) ? 0 : 1;
        }
    }
    EXPECT_GT(noted, 100u);
    EXPECT_LE(differing, RoundsAlike() ? 0 : noted / 20);
}

TEST_F(SessionAdaptiveTest, CountsHaveTheirBoundsAndTheirAverage) {
    Session session(Device(), Scene("cornell.gltf"), Desc());
    for (const uint32_t average : {5u, 40u, 64u, 200u}) {
        session.Run({.samples = average});
        const RenderFile render = session.Result().render;
        ASSERT_TRUE(render.adaptive);
        const auto total = static_cast<double>(render.adaptive->Total());
        EXPECT_GE(total, average * 240.0);
        EXPECT_LE(total, average * 240.0 * 1.01 + 240.0);
        const uint32_t base = average < 64 ? 16u : average / 8;
        EXPECT_GE(std::ranges::min(render.adaptive->counts), std::min(average, base)) << average;
        EXPECT_EQ(SampleCount(render.samples), average);
        EXPECT_EQ(session.SampleCount(), average);
    }
}

TEST_F(SessionAdaptiveTest, FormsAndFramesOfAnySizeGiveTheSameBits) {
    const SettingTexts texts{{"seed", "3"}, {"crop", "3,2,15,9"}};
    SessionDesc desc = DescOfAll(texts);
    const RenderFile loop = Render(desc, 80);
    desc.batchSize = 8;
    ExpectSame(loop, Render(desc, 80));
    if (!RoundsAlike()) return;
    SessionDesc wavefront = DescOfAll(texts);
    wavefront.tracing.form = passes::IntegratorForm::Wavefront;
    wavefront.batchSize = 16;
    ExpectSame(loop, Render(wavefront, 80));
}

TEST_F(SessionAdaptiveTest, ResumedRenderHasTheBitsOfOneThatWasNot) {
    SessionDesc desc = DescOfAll({{"max-depth", "3"}, {"sampler", "pcg"}});
    desc.firstSample = 16;
    Session session(Device(), Scene("cornell.gltf"), desc);
    session.Run({.samples = 150});
    const RenderFile whole = session.Result().render;
    EXPECT_EQ(whole.samples, (SampleRanges{{16, 150}}));
    EXPECT_GT(whole.removedSamples, 0u);
    const test::TemporaryFolder folder;
    const std::filesystem::path file = folder / "part.exr";
    // Stops before the first stage, within it, and in the next one
    uint32_t before = 0;
    for (const uint32_t average : {10u, 16u, 50u, 66u, 128u, 131u, 150u}) {
        std::optional<ResumedRender> resumed;
        if (before > 0) resumed = ReadResumedRender(file);
        session.StartPicture({.resumed = resumed ? &*resumed : nullptr});
        EXPECT_EQ(session.SampleCount(), before);
        session.Run({.samples = average});
        WriteRenderFile(file, session.Result().render);
        before = average;
    }
    const RenderFile parts = ReadRenderFile(file);
    EXPECT_EQ(parts.removedSamples, whole.removedSamples);
    EXPECT_EQ(parts.settings.at("adaptive"), "on");
    ASSERT_TRUE(parts.adaptive && whole.adaptive);
    EXPECT_TRUE(*parts.adaptive == *whole.adaptive);
    EXPECT_TRUE(parts.radiance == whole.radiance);
    EXPECT_TRUE(parts.sums.radiance == whole.sums.radiance);
    // The file has no alpha for the other means
    for (const Aov aov : kAovs) {
        const Texels *ofParts = MeanOf(parts, aov), *ofWhole = MeanOf(whole, aov);
        for (size_t i = 0; ofParts != nullptr && i < ofParts->size(); ++i)
            if (i % 4 != 3) {
                ASSERT_EQ((*ofParts)[i], (*ofWhole)[i]) << Name(aov) << " " << i;
            }
    }
    // Continues as in a process of its own
    const ResumedRender resumed = ReadResumedRender(file);
    EXPECT_TRUE(Resuming(resumed).settings.isAdaptive);
}

// The surfaces' passes trace single samples, and lag behind frames with many.
TEST_F(SessionAdaptiveTest, SurfacesDoNotMakeFramesSmaller) {
    const auto framesWith = [](bool hasSurfaces) {
        SessionDesc desc = Desc({{"brdf", "lambert"}});
        desc.batchSize = 16;
        if (hasSurfaces) desc.aovs.Set(Aov::Albedo, true);
        Session session(Device(), Scene("cornell.gltf"), desc);
        session.Run({.samples = 128});
        for (const PassTime& pass : session.Statistics().passes)
            if (pass.name == "Trace") return pass.count;
        return 0u;
    };
    // Frames of single samples would be 128. A session begins with small ones, more of them on a busy machine
    for (const bool hasSurfaces : {false, true}) {
        const uint32_t frames = framesWith(hasSurfaces);
        EXPECT_GT(frames, 0u);
        EXPECT_LT(frames, 60u) << hasSurfaces;
    }
}

// A picture that follows another one has nothing of it.
TEST_F(SessionAdaptiveTest, PicturesOfASessionAreThoseOfSessionsOfTheirOwn) {
    Session session(Device(), Scene("cornell.gltf"), Desc());
    session.Run({.samples = 200});
    const RenderFile first = session.Result().render;
    session.StartPicture({});
    session.Run({.samples = 200});
    ExpectSame(session.Result().render, first);
}

// This holds for the error of the picture as a whole, and for its pixels' errors relative to their
// brightness.
TEST_F(SessionAdaptiveTest, ErrorIsBelowThatOfAsManySamplesEverywhere) {
    struct Errors {
        double ofPicture = 0.0, ofPixels = 0.0;
    };
    const auto errorsOf = [&](const char* isAdaptive) {
        Session session(Device(), Scene("cornell.gltf"), Desc({{"size", "32x32"}, {"adaptive", isAdaptive}}));
        session.Run({.samples = 128});
        const SessionResult result = session.Result();
        const RenderFile& render = result.render;
        Errors errors{.ofPicture = result.statistics.relativeError.value_or(0.0)};
        for (size_t i = 0; i < render.radiance.size(); ++i) {
            if (i % 4 == 3) continue;
            const double mean = render.radiance[i],
                         count = render.adaptive ? render.adaptive->counts[i / 4] : 128;
            errors.ofPixels += render.variance[i] / count / (mean * mean + 0.01);
        }
        return errors;
    };
    const Errors uniform = errorsOf("off"), adaptive = errorsOf("on");
    EXPECT_GT(adaptive.ofPicture, 0.0);
    EXPECT_LT(adaptive.ofPicture, 0.9 * uniform.ofPicture);
    EXPECT_LT(adaptive.ofPixels, 0.95 * uniform.ofPixels);
}

TEST_F(SessionAdaptiveTest, RunEndsWithTheErrorThatIsWanted) {
    Session session(Device(), Scene("cornell.gltf"), Desc());
    session.Run({.samples = 64});
    const double at64 = session.Result().statistics.relativeError.value_or(0.0);
    session.Run({.relativeError = at64 / 1.5});
    const uint32_t samples = session.SampleCount();
    EXPECT_GT(samples, 100u);
    EXPECT_LT(samples, 200u);
    EXPECT_LT(session.Result().statistics.relativeError.value_or(1.0), at64 / 1.4);
    EXPECT_TRUE(session.Result().render.measuredError);
}

// This holds between any two steps, where the state is a function of the average.
TEST_F(SessionAdaptiveTest, ARunThatIsStoppedIsARunToItsAverage) {
    Session stopped(Device(), Scene("cornell.gltf"), Desc());
    uint32_t asked = 0;
    constexpr uint32_t kNeverReached = 1u << 20;
    const RunSummary summary =
        stopped.Run({.samples = kNeverReached, .isStopRequested = [&] { return ++asked > 12; }});
    EXPECT_TRUE(summary.wasStopped);
    const RenderFile render = stopped.Result().render;
    const uint32_t average = static_cast<uint32_t>(SampleCount(render.samples));
    EXPECT_LT(average, kNeverReached);
    ExpectSame(render, Render(Desc(), average));

    Session late(Device(), Scene("cornell.gltf"), Desc());
    late.Run({.seconds = 0.2});
    const RenderFile timed = late.Result().render;
    ExpectSame(timed, Render(Desc(), static_cast<uint32_t>(SampleCount(timed.samples))));
}

TEST_F(SessionAdaptiveTest, WhatHasSamplesOfAllPixelsIsRefused) {
    ExpectRefused({{"view", "albedo"}}, "the view albedo");
    ExpectRefused({{"view", "raster"}}, "the view raster");
    ExpectRefused({{"rr", "frame:0.5"}}, "rr");
    SessionDesc blurred = Desc();
    blurred.settings.at = 0.5;
    blurred.settings.shutter = Shutter{.open = 0.0, .close = 0.1};
    SceneInput moving = Scene("cornell.gltf");
    moving.isAnimated = true;
    ExpectError(
        ErrorKind::Usage, [&] { const Session session(Device(), std::move(moving), blurred); },
        "adaptive: ", "shutter");
    SessionDesc late = Desc();
    late.firstSample = 1u << 31;
    ExpectError(
        ErrorKind::Usage, [&] { const Session session(Device(), Scene("cornell.gltf"), late); },
        "adaptive: ", "more indices than there are");
    SessionDesc desc = Desc();
    desc.withVariance = false;
    ExpectError(
        ErrorKind::Usage, [&] { const Session session(Device(), Scene("cornell.gltf"), desc); },
        "adaptive: ", "variance");
    rhi::Device* const two[] = {&Device(), &Device()};
    ExpectError(
        ErrorKind::Usage, [&] { const Session session(two, Scene("cornell.gltf"), Desc()); },
        "adaptive: ", "several devices");
    std::vector<NamedRender> parts(1);
    parts.front() = {"part.exr", Render(Desc(), 8)};
    ExpectError(
        ErrorKind::BadInput, [&] { Merge(std::move(parts)); }, "part.exr cannot be merged", "adaptive");
}

}  // namespace raygraph::session::session_adaptive_test

// Tests, on the host alone, which pixels of an adaptive render get samples, and how many.
namespace raygraph::session::adaptive_counts_test {

using namespace adaptive_picture;

namespace {

using Extent2D = rhi::Extent2D;

double AverageOf(std::span<const uint32_t> counts) {
    return static_cast<double>(std::accumulate(counts.begin(), counts.end(), uint64_t{0})) /
           static_cast<double>(counts.size());
}

uint32_t ColorOf(size_t pixel) {
    return (pixel % 24 + pixel / 24) % 2;
}

// Returns `noted` with the values of `changed` in the pixels of color `ofColor`.
PixelVariances WithColor(PixelVariances noted, uint32_t ofColor, const PixelVariances& changed) {
    ForPixelsOfColor(kPicture, ofColor, [&](size_t i) {
        noted.variance[i] = changed.variance[i];
        noted.mean[i] = changed.mean[i];
    });
    return noted;
}

// Allocates samples for both colors.
std::vector<uint32_t> Allocate(const PixelVariances& noted, std::span<const uint32_t> least,
                               uint32_t average = 64) {
    std::vector<uint32_t> wanted(kPixels);
    for (const uint32_t color : {0u, 1u}) AllocateSamples(kPicture, color, noted, least, average, wanted);
    return wanted;
}

}  // namespace

TEST(AdaptiveCounts, AllocationGoesWithTheDeviationAndHasTheAverage) {
    const std::vector<uint32_t> wanted = Allocate(Noted(), std::vector<uint32_t>(kPixels, 16));
    double ofColor[2] = {}, pixelsOfColor[2] = {};
    for (size_t i = 0; i < kPixels; ++i) {
        EXPECT_GE(wanted[i], 16u);
        EXPECT_LE(wanted[i], 16u * 64u);
        EXPECT_TRUE(std::has_single_bit(wanted[i])) << wanted[i];
        ofColor[ColorOf(i)] += wanted[i];
        pixelsOfColor[ColorOf(i)] += 1.0;
    }
    // Each color has its own average, and never less
    for (const int color : {0, 1}) {
        EXPECT_GE(ofColor[color] / pixelsOfColor[color], 64.0);
        EXPECT_LE(ofColor[color] / pixelsOfColor[color], 65.0);
    }
    EXPECT_EQ(wanted[20 * 1 + 24 * 14], 16u) << "far from any noise";
    EXPECT_GT(wanted[24 * 5 + 4], 100u);
    EXPECT_LT(wanted[24 * 5 + 20], wanted[24 * 5 + 4] / 4);
}

// A pixel's error counts relative to its brightness, except in the dark.
TEST(AdaptiveCounts, AllocationIsRelativeToTheMean) {
    const std::vector<uint32_t> least(kPixels, 1);
    const std::vector<float> ones(kPixels, 1.0f);
    PixelVariances bright{ones, ones}, dark{ones, ones};
    for (size_t i = 0; i < kPixels; ++i)
        if (i % 24 < 12) {
            bright.mean[i] = 2.0f;
            bright.variance[i] = 4.0f;
            dark.mean[i] = 1e-4f;
            dark.variance[i] = 1e-8f;
        }
    const std::vector<uint32_t> even = Allocate(bright, least);
    EXPECT_NEAR(even[24 * 8 + 4], 64.0, 16.0);
    EXPECT_NEAR(even[24 * 8 + 20], 64.0, 16.0);
    const std::vector<uint32_t> uneven = Allocate(dark, least);
    EXPECT_LT(uneven[24 * 8 + 4], 8u);
    EXPECT_GT(uneven[24 * 8 + 20], 100u);
}

TEST(AdaptiveCounts, AllocationIsWithinItsBoundsWhereFewPixelsVary) {
    const std::vector<uint32_t> least(kPixels, 16);
    const PixelVariances still{std::vector<float>(kPixels, 0.0f), std::vector<float>(kPixels, 1.0f)};
    // Without noise all pixels get equally many
    for (const uint32_t count : Allocate(still, least)) EXPECT_EQ(count, 64u);
    // Around a single noisy pixel, its neighbors get the most, and the others the rest
    PixelVariances lone = still;
    lone.variance[24 * 8 + 12] = 1.0f;
    const std::vector<uint32_t> wanted = Allocate(lone, least);
    EXPECT_NEAR(AverageOf(wanted), 64.0, 0.64);
    EXPECT_GT(wanted[24 * 8 + 13], 8u * 64u);
    // The noisy pixel's own color must not depend on this noise
    EXPECT_NEAR(wanted[24 * 8 + 12], 64.0, 4.0);
    EXPECT_LT(wanted[1], 64u);
    // A picture of one pixel has no neighbor
    std::vector<uint32_t> one(1);
    AllocateSamples({1, 1}, 0, {{1.0f}, {1.0f}}, std::vector<uint32_t>{16}, 64, one);
    EXPECT_EQ(one, std::vector<uint32_t>{64});
    // Pixels that already have more keep it
    std::vector<uint32_t> uneven(kPixels, 16);
    uneven[3] = 200;
    EXPECT_GE(Allocate(Noted(), uneven)[3], 200u);
}

// Otherwise the number of a pixel's samples would depend on their values, and bias the mean.
TEST(AdaptiveCounts, WhatAPixelGetsIsAFunctionOfTheOtherColorAlone) {
    const std::vector<uint32_t> least(kPixels, 16);
    for (const uint32_t changed : {0u, 1u}) {
        const std::vector<uint32_t> before = Allocate(AnyNoted(7), least);
        const std::vector<uint32_t> after = Allocate(WithColor(AnyNoted(7), changed, AnyNoted(8)), least);
        size_t others = 0;
        for (size_t i = 0; i < kPixels; ++i) {
            if (ColorOf(i) == changed) {
                EXPECT_EQ(after[i], before[i]) << i;
            } else {
                others += after[i] != before[i] ? 1 : 0;
            }
        }
        EXPECT_GT(others, kPixels / 4) << "those of the other color follow";
    }
}

// This holds wherever a render ends: one number of samples for both colors would tell each of the other's.
TEST(AdaptiveCounts, WhereARenderEndsAColorIsAFunctionOfTheOtherAlone) {
    for (const uint32_t average : {16u, 17u, 40u, 64u, 65u, 100u, 127u, 128u, 129u, 130u, 200u, 256u, 300u})
        for (const uint32_t changed : {0u, 1u}) {
            AdaptiveCounts before(kPicture), after(kPicture);
            RunTo(before, average, 1000, AnyNoted(7));
            RunTo(after, average, 1000, WithColor(AnyNoted(7), changed, AnyNoted(8)));
            const std::vector<uint32_t> countsBefore = before.State().counts,
                                        countsAfter = after.State().counts;
            size_t own = 0, others = 0;
            for (size_t i = 0; i < kPixels; ++i)
                (ColorOf(i) == changed ? own : others) += countsAfter[i] != countsBefore[i] ? 1 : 0;
            EXPECT_EQ(own, 0u) << average << ", color " << changed;
            // The changed color also keeps the average, to less than one sample per pixel
            uint64_t total = 0;
            ForPixelsOfColor(kPicture, changed, [&](size_t i) { total += countsAfter[i]; });
            EXPECT_EQ(total / PixelsOfColor(kPicture, changed), average);
            if (average > 20) {
                EXPECT_GT(others, kPixels / 8) << average;
            }
        }
}

TEST(AdaptiveCounts, StagesHaveTheirBaseAndTheirAverage) {
    AdaptiveCounts counts(kPicture);
    EXPECT_EQ(counts.WalkPixels(0).size(), kPixels) << "the first samples are of all pixels";
    RunTo(counts, 16, 1000, Noted());
    EXPECT_EQ(counts.State().counts, std::vector<uint32_t>(kPixels, 16));
    for (uint32_t stage = 128; stage <= 1024; stage *= 2) {
        RunTo(counts, stage, 1000, Noted());
        const AdaptiveState state = counts.State();
        EXPECT_EQ(state.stages, (std::array<uint32_t, 2>{stage, stage}));
        EXPECT_EQ(counts.MinimumCount(), std::ranges::min(state.counts));
        EXPECT_GE(counts.MinimumCount(), stage / 4) << "the base of the next one";
        EXPECT_NEAR(AverageOf(state.counts), stage, 0.02 * stage);
        EXPECT_LE(std::ranges::max(state.counts), 16 * stage);
    }
    // A color never has less than its average, however counts are rounded
    for (uint32_t seed = 0; seed < 20; ++seed) {
        AdaptiveCounts any(kPicture);
        RunTo(any, 256, 1000, AnyNoted(seed));
        EXPECT_EQ(any.State().stages, (std::array<uint32_t, 2>{256, 256})) << seed;
    }
}

// The values that are noted at a base are thus those of its samples alone.
TEST(AdaptiveCounts, NoStepCrossesABaseAndEachIsNoted) {
    AdaptiveCounts counts(kPicture);
    RunTo(counts, 16, 1000, AnyNoted(7));
    std::map<uint32_t, std::vector<bool>> noted;
    for (uint32_t average = 17; average <= 600; ++average) {
        while (true) {
            const AdaptiveCounts::Next next = counts.NextTo(average);
            if (next.kind == AdaptiveCounts::Next::Kind::Nothing) break;
            if (next.kind == AdaptiveCounts::Next::Kind::Decision) {
                const AdaptiveState state = counts.State();
                const uint32_t base = BaseAfter(state.stages[next.color]);
                ForPixelsOfColor(kPicture, 1 - next.color, [&](size_t i) {
                    EXPECT_TRUE(state.counts[i] == base || (state.counts[i] > base && noted[base].at(i)))
                        << i << " has " << state.counts[i] << ", base " << base;
                });
                counts.AllocateStage(next.color, AnyNoted(7));
                continue;
            }
            const std::vector<AdaptiveCounts::WalkPixel>& pixels = counts.WalkPixels(next.color);
            const uint32_t base = counts.BaseToRecord(next.color);
            for (uint32_t i = 0; i < next.pixels; ++i) {
                const uint32_t count = pixels[i].count + next.taken;
                for (uint32_t crossed = 16; crossed < 4096; crossed *= 2)
                    EXPECT_FALSE(count < crossed && count + next.length > crossed);
                if (base > 0 && count == base) {
                    noted[base].resize(kPixels);
                    noted[base][pixels[i].pixel] = true;
                }
            }
            counts.Advance(next, next.length);
        }
        const std::vector<uint32_t> now = counts.State().counts;
        EXPECT_EQ(counts.MinimumCount(), std::ranges::min(now));
        EXPECT_EQ(counts.Average(), average);
    }
}

TEST(AdaptiveCounts, NeitherStepsNorStopsChangeWhatComesNext) {
    const PixelVariances noted = AnyNoted(3);
    AdaptiveCounts one(kPicture), many(kPicture);
    RunTo(one, 300, 1, noted);
    RunTo(many, 300, 1000, noted);
    EXPECT_EQ(one.State(), many.State());
    EXPECT_GE(one.Total(), 300u * kPixels);
    EXPECT_LT(one.Total(), 301u * kPixels);
    // Continues from the state that a file would have, at several averages
    AdaptiveCounts stopped(kPicture);
    for (const uint32_t average : {1u, 7u, 16u, 17u, 40u, 64u, 65u, 128u, 129u, 130u, 131u, 256u, 300u}) {
        RunTo(stopped, average, 1000, noted);
        EXPECT_EQ(stopped.Average(), average);
        EXPECT_EQ(stopped.Average(), stopped.State().Average());
        stopped = AdaptiveCounts(kPicture, stopped.State());
        EXPECT_EQ(stopped.MinimumCount(), std::ranges::min(stopped.State().counts));
    }
    EXPECT_EQ(one.State(), stopped.State());
}

// Otherwise a render of many pixels would wait for the host: steps are the first pixels of one list.
TEST(AdaptiveCounts, AStageHasFewWalksAndSteps) {
    AdaptiveCounts counts(kPicture);
    RunTo(counts, 128, 1000, AnyNoted(3));
    uint32_t steps = 0, walks = 0;
    uint64_t last = 0;
    while (true) {
        const AdaptiveCounts::Next next = counts.NextTo(256);
        if (next.kind == AdaptiveCounts::Next::Kind::Nothing) break;
        if (next.kind == AdaptiveCounts::Next::Kind::Decision) {
            counts.AllocateStage(next.color, AnyNoted(3));
            continue;
        }
        walks += std::exchange(last, counts.WalkId(next.color)) != last ? 1 : 0;
        ++steps;
        const std::vector<AdaptiveCounts::WalkPixel>& pixels = counts.WalkPixels(next.color);
        EXPECT_TRUE(std::ranges::is_sorted(pixels, std::greater{}, &AdaptiveCounts::WalkPixel::missing));
        counts.Advance(next, next.length);
    }
    EXPECT_LT(walks, 60u);
    EXPECT_LT(steps, 600u);
}

namespace {

// Draws samples from a heavy-tailed distribution of mean 1: mostly 0, and now and then 50. `shared` is the
// number of consecutive pixels with the same numbers.
class HeavyTail {
  public:
    HeavyTail(uint32_t seed, uint32_t shared) : m_seed(seed), m_shared(shared) {}
    double At(size_t pixel, uint32_t index) const {
        const auto stream = static_cast<uint32_t>(pixel / m_shared);
        const uint32_t bits = gpu::MixBits(gpu::MixBits(stream * 65536 + index) ^ gpu::MixBits(m_seed));
        return bits < 0xFFFFFFFFu / 50 ? 50.0 : 0.0;
    }
    // Returns the variance of the first `count` samples.
    float VarianceOf(size_t pixel, uint32_t count) const {
        const double mean = MeanOf(pixel, count);
        return static_cast<float>((mean * 50.0 - mean * mean) * count / (count - 1.0));
    }
    double MeanOf(size_t pixel, uint32_t count) const {
        double sum = 0.0;
        for (uint32_t i = 0; i < count; ++i) sum += At(pixel, i);
        return sum / count;
    }

  private:
    uint32_t m_seed, m_shared;
};

// Returns how far the mean over many renders of `average` samples is from 1, in standard errors.
double DeviationOfMean(uint32_t average, uint32_t renders, uint32_t shared) {
    using Kind = AdaptiveCounts::Next::Kind;
    constexpr Extent2D kSmall{8, 8};
    double sum = 0.0, squares = 0.0;
    for (uint32_t seed = 0; seed < renders; ++seed) {
        const HeavyTail values(seed, shared);
        AdaptiveCounts counts(kSmall);
        for (auto next = counts.NextTo(average); next.kind != Kind::Nothing; next = counts.NextTo(average)) {
            if (next.kind == Kind::Samples) {
                counts.Advance(next, next.length);
                continue;
            }
            const uint32_t base = BaseAfter(counts.State().stages[next.color]);
            PixelVariances noted;
            for (size_t i = 0; i < 64; ++i) {
                noted.variance.push_back(values.VarianceOf(i, base));
                noted.mean.push_back(static_cast<float>(values.MeanOf(i, base)));
            }
            counts.AllocateStage(next.color, noted);
        }
        const std::vector<uint32_t> taken = counts.State().counts;
        double mean = 0.0;
        for (size_t i = 0; i < 64; ++i) mean += values.MeanOf(i, taken[i]) / 64.0;
        sum += mean;
        squares += mean * mean;
    }
    const double mean = sum / renders;
    const double variance = (squares / renders - mean * mean) / (renders - 1.0);
    return (mean - 1.0) / std::sqrt(variance);
}

}  // namespace

// The mean is exact for any distribution, and wherever a render ends. Where pixels share random numbers, a
// neighbor's samples are the pixel's own, and decide for it: the test would find such a bias if a pixel's
// samples decided about itself, which is why adaptive renders refuse samplers that pixels share.
TEST(AdaptiveCounts, MeanIsUnbiasedUnlessPixelsShareTheirNumbers) {
    for (const auto& [average, renders] : {std::pair{64u, 1500u}, {100u, 1500u}, {200u, 600u}})
        EXPECT_LT(std::abs(DeviationOfMean(average, renders, 1)), 3.3) << average;
    for (const uint32_t average : {64u, 100u}) EXPECT_LT(DeviationOfMean(average, 1500, 2), -5.0) << average;
}

TEST(AdaptiveCounts, AStageThatEndsEarlyHasExtraSamplesEverywhere) {
    AdaptiveCounts half(kPicture), whole(kPicture);
    RunTo(half, 192, 1000, Noted());
    RunTo(whole, 256, 1000, Noted());
    const std::vector<uint32_t> ofHalf = half.State().counts, ofWhole = whole.State().counts;
    const auto noisiest = static_cast<size_t>(std::ranges::max_element(ofWhole) - ofWhole.begin());
    EXPECT_GE(ofHalf[noisiest], ofWhole[noisiest] / 2);
    for (size_t i = 0; i < kPixels; ++i) EXPECT_LE(ofHalf[i], ofWhole[i]);
}

}  // namespace raygraph::session::adaptive_counts_test

// Tests which states of adaptive renders a file may have, and that every valid one continues.
namespace raygraph::session::adaptive_state_test {

using namespace adaptive_picture;

namespace {

// Returns the state that a file stores at this average.
AdaptiveState StateAt(uint32_t average) {
    AdaptiveCounts counts(kPicture);
    RunTo(counts, average, 1000, Noted());
    AdaptiveState state = counts.State();
    for (uint32_t base = counts.FirstBaseNeeded(); base < std::ranges::max(state.counts); base *= 2)
        state.noted[base] = {std::vector<float>(kPixels, 1.0f), std::vector<float>(kPixels, 1.0f)};
    return state;
}

}  // namespace

TEST(AdaptiveState, FlawsAreNamed) {
    const AdaptiveState good = StateAt(100);
    for (const uint32_t average : {1u, 15u, 16u, 17u, 64u, 100u, 128u, 129u, 200u, 256u, 700u})
        EXPECT_EQ(FlawOf(StateAt(average), kPicture), "") << average;
    ASSERT_FALSE(good.noted.empty());
    const auto expectFlaw = [&](const char* part, auto&& change) {
        AdaptiveState bad = good;
        change(bad);
        const std::string flaw = FlawOf(bad, kPicture);
        EXPECT_NE(flaw.find(part), std::string::npos) << part << ": " << flaw;
    };
    expectFlaw("counts", [](AdaptiveState& s) { s.counts.pop_back(); });
    expectFlaw("without a sample", [](AdaptiveState& s) { s.counts[5] = 0; });
    expectFlaw("fewer samples than a stage of 128 begins with", [](AdaptiveState& s) { s.counts[5] = 3; });
    expectFlaw("wanted", [](AdaptiveState& s) { s.wanted.pop_back(); });
    expectFlaw("more samples than it is to have", [](AdaptiveState& s) { s.wanted[5] = s.counts[5] - 1; });
    expectFlaw("gives no pixel as many", [](AdaptiveState& s) { s.wanted[5] = 0xFFFFFFFFu; });
    expectFlaw("gives no pixel as many", [](AdaptiveState& s) { s.counts[5] = s.wanted[5] = 17; });
    expectFlaw("stage of 96", [](AdaptiveState& s) { s.stages[1] = 96; });
    expectFlaw("stage of 0", [](AdaptiveState& s) { s.stages[0] = 0; });
    expectFlaw("stage of 2147483648", [](AdaptiveState& s) { s.stages[0] = 1u << 31; });
    expectFlaw("not of one time", [](AdaptiveState& s) { s.stages[0] = 512; });
    expectFlaw("not of one time", [](AdaptiveState& s) { s.stages[1] = 16; });
    expectFlaw("before their first stage", [](AdaptiveState& s) { s.stages = {16, 16}; });
    // One color alone has too many
    expectFlaw("samples on average", [](AdaptiveState& s) {
        ForPixelsOfColor(kPicture, 1, [&](size_t i) { s.wanted[i] = std::max(s.counts[i], 32u); });
    });
    expectFlaw("samples on average",
               [](AdaptiveState& s) { ForPixelsOfColor(kPicture, 0, [&](size_t i) { s.wanted[i] = 300; }); });
    expectFlaw("no variance of", [](AdaptiveState& s) { s.noted.clear(); });
    expectFlaw("not of its pixels", [](AdaptiveState& s) { s.noted.begin()->second.variance.pop_back(); });
    expectFlaw("not of its pixels", [](AdaptiveState& s) { s.noted.begin()->second.mean.pop_back(); });
    expectFlaw("is no number", [](AdaptiveState& s) { s.noted.begin()->second.variance[1] = -1.0f; });
    expectFlaw("is no number", [](AdaptiveState& s) { s.noted.begin()->second.mean[1] = INFINITY; });
    // Every pixel has as many times the average as one pixel may have
    expectFlaw("samples on average", [](AdaptiveState& s) {
        s.counts.assign(kPixels, 1088);
        s.wanted = s.counts;
        s.stages = {128, 128};
        for (uint32_t base = 32; base <= 1024; base *= 2) s.noted[base] = s.noted.begin()->second;
    });
    // A file without sums cannot continue, which is no flaw
    const AdaptiveState ended{.counts = good.counts, .wanted = {}, .noted = {}};
    EXPECT_EQ(FlawOf(ended, kPicture), "");
}

// These states include those that no render has written.
TEST(AdaptiveState, AnyStateWithoutFlawGoesOnAndEnds) {
    std::mt19937 random(5);
    uint32_t gone = 0;
    for (int turn = 0; turn < 200; ++turn) {
        AdaptiveState state = StateAt(150);
        const uint32_t stage = 128u << random() % 3;
        state.stages = {stage, random() % 2 == 0 ? stage : 2 * stage};
        for (const uint32_t color : {0u, 1u})
            ForPixelsOfColor(kPicture, color, [&](size_t i) {
                const uint32_t own = state.stages[color];
                state.wanted[i] = own + static_cast<uint32_t>(random() % own);
                state.counts[i] = own / 8 + static_cast<uint32_t>(random() % (state.wanted[i] - own / 8 + 1));
                if (turn % 3 == 0) state.counts[i] = state.wanted[i];
            });
        for (uint32_t base = 16; base <= 4096; base *= 2) state.noted[base] = AnyNoted(1);
        ASSERT_EQ(FlawOf(state, kPicture), "");
        AdaptiveCounts counts(kPicture, state);
        const uint32_t average = counts.Average() + 300;
        RunTo(counts, average, 1u << 20, AnyNoted(2));
        EXPECT_GE(counts.Average(), average);
        ++gone;
    }
    EXPECT_EQ(gone, 200u);
}

TEST(AdaptiveState, ThereIsALastStage) {
    constexpr rhi::Extent2D kTwo{2, 1};
    AdaptiveState state{.counts = {kLastStage, kLastStage},
                        .wanted = {kLastStage, kLastStage},
                        .stages = {kLastStage, kLastStage}};
    EXPECT_EQ(FlawOf(state, kTwo).find("no variance of"), 7u) << FlawOf(state, kTwo);
    for (uint32_t base = kLastStage / 4; base < kLastStage; base *= 2)
        state.noted[base] = {{1.0f, 1.0f}, {1.0f, 1.0f}};
    ASSERT_EQ(FlawOf(state, kTwo), "");
    AdaptiveCounts counts(kTwo, state);
    const AdaptiveCounts::Next next = counts.NextTo(kLastStage + 1);
    ASSERT_EQ(next.kind, AdaptiveCounts::Next::Kind::Decision);
    test::ExpectError(
        ErrorKind::Usage,
        [&] {
            counts.AllocateStage(next.color, {{1.0f, 1.0f}, {1.0f, 1.0f}});
        },
        "the most samples");
}

}  // namespace raygraph::session::adaptive_state_test
