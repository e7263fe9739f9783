// Tests adaptive renders: which samples a pixel is the mean of, and that nothing else changes it. It needs a
// device.
#include <algorithm>
#include <bit>
#include <map>
#include <optional>

#include "editor/session/file/merge.h"
#include "editor/session/session.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

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
    const uint32_t without = framesWith(false), with = framesWith(true);
    EXPECT_LT(without, 60u);
    EXPECT_GT(with, 0u);
    EXPECT_LE(with, without);
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
