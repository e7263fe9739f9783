// Tests the steps of RealTime, each by hand-made pictures, and HandOver.
#include "passes/real_time.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "passes/accumulate.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/graph/readback_values.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::real_time_test {

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

using Picture = std::vector<float>;  // RGBA
using Texel = std::array<float, 4>;

template <typename Function>  // from x, y to a Texel
Picture Made(Extent2D extent, const Function& function) {
    Picture picture;
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x) {
            const Texel texel = function(static_cast<int>(x), static_cast<int>(y));
            picture.insert(picture.end(), texel.begin(), texel.end());
        }
    return picture;
}
Picture Filled(Extent2D extent, const Texel& texel) {
    return Made(extent, [&](int, int) { return texel; });
}
Texel Gray(float value) {
    return {value, value, value, 1.0f};
}

// Looks along -z; what it sees at a depth of 2 is 4 m high.
gpu::CameraRecord Camera(Extent2D extent) {
    gpu::CameraRecord camera{};
    camera.right = {static_cast<float>(extent.width) / static_cast<float>(extent.height), 0, 0};
    camera.up = {0, 1, 0};
    camera.forward = {0, 0, -1};
    return camera;
}

// Surfaces: normal in the octahedron, depth, number (shaders/real_time/surface.glsl).
constexpr Texel kWall{0, 0, 2, 2};   // faces the camera
constexpr Texel kOther{0, 0, 2, 3};  // has another number
constexpr Texel kFarther{0, 0, 20, 2};
constexpr Texel kTurned{1, 0, 2, 2};  // its normal is +x
constexpr Texel kNothing{0, 0, 0, 1};
constexpr Texel kUnwritten{0, 0, 0, 0};
constexpr Texel kStill{0, 0, 1, 1};  // motion

std::vector<uint32_t> Packed(const Picture& surfaces) {
    std::vector<uint32_t> words;
    for (size_t i = 0; i < surfaces.size(); i += 4) {
        const auto coordinate = [&](size_t c) {
            return static_cast<uint32_t>(std::lround(511.0f * surfaces[i + c]) + 512);
        };
        words.push_back(std::bit_cast<uint32_t>(surfaces[i + 2]));
        words.push_back(coordinate(0) << 22 | coordinate(1) << 12 | static_cast<uint32_t>(surfaces[i + 3]));
    }
    return words;
}

// The largest relative error of a value that is rounded to a half, to either side.
constexpr float kRounding = 1.0f / 1024.0f;

struct Frame {
    Picture sample, surfaces, motion, albedo;
};
Frame StillFrame(Extent2D extent, const Picture& sample) {
    return {sample, Filled(extent, kWall), Filled(extent, kStill), Filled(extent, Gray(0.5f))};
}

struct Mean {
    Picture mean;
    std::vector<float> deviation;
    Picture surfaces;
};
Mean NoMean(Extent2D extent) {
    return {Filled(extent, {0, 0, 0, 0}), std::vector<float>(size_t{extent.width} * extent.height),
            Filled(extent, kUnwritten)};
}

class RealTimeSteps : public VulkanTest {
  protected:
    TextureId Texture(PassHarness& h, const char* name, Extent2D extent, const Picture& picture) {
        return h.Texture(name, extent, Format::Rgba16Float, picture);
    }
    TextureId Deviation(PassHarness& h, Extent2D extent, const std::vector<float>& values) {
        return h.Texture("deviation", extent, Format::R16Float, values);
    }
    TextureId Surfaces(PassHarness& h, Extent2D extent, const Picture& surfaces) {
        TextureId texture = h.Graph().CreateTexture("surfaces", {extent, Format::Rg32Uint});
        const BufferId words = h.Buffer("surfaces", Packed(surfaces));
        h.Graph().AddPass(
            "FillSurfaces", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(words);
                texture = pass.CopiesTo(texture);
            },
            [words, texture](CommandList& commands, const PassResources& resources) {
                commands.CopyToTexture(resources.Buffer(words), 0, resources.Texture(texture));
            });
        return texture;
    }
    passes::SurfaceIds Seen(PassHarness& h, Extent2D extent, const Frame& frame) {
        return {Texture(h, "albedo", extent, frame.albedo), Surfaces(h, extent, frame.surfaces),
                Texture(h, "motion", extent, frame.motion)};
    }
    Mean Accumulate(Extent2D extent, const Frame& frame, const Mean& before, uint32_t mostBefore = 100,
                    uint32_t most = 100) {
        Mean now{.mean = {}, .deviation = {}, .surfaces = frame.surfaces};
        Readback deviation;
        now.mean = harness
                       .Run([&](PassHarness& h) {
                           const passes::MovingMeanIds ids = passes::AccumulateMoving(
                               h.Graph(), h.Texture("sample", extent, Format::Rgba32Float, frame.sample),
                               Seen(h, extent, frame),
                               {Texture(h, "meanBefore", extent, before.mean),
                                Deviation(h, extent, before.deviation), Surfaces(h, extent, before.surfaces)},
                               {.cameraBefore = Camera(extent),
                                .mostBefore = mostBefore,
                                .most = most,
                                .frame = ++m_frame});
                           deviation = h.Graph().ReadBack(ids.deviation);
                           return ids.mean;
                       })
                       .values;
        deviation.Wait();
        now.deviation = DecodeTexels(deviation.Bytes(), extent, deviation.Format()).values;
        return now;
    }
    // Accumulate where the light is compared with that of the means before.
    Mean AccumulateChanged(Extent2D extent, const Frame& frame, const Mean& before) {
        Mean now = before;
        now.mean = harness
                       .Run([&](PassHarness& h) {
                           const TextureId sample =
                               h.Texture("sample", extent, Format::Rgba32Float, frame.sample);
                           const passes::SurfaceIds seen = Seen(h, extent, frame);
                           const passes::MovingMeanIds old{Texture(h, "meanBefore", extent, before.mean),
                                                           Deviation(h, extent, before.deviation),
                                                           Surfaces(h, extent, before.surfaces)};
                           return passes::AccumulateMoving(
                                      h.Graph(), sample, seen, old,
                                      {.cameraBefore = Camera(extent),
                                       .mostBefore = 32,
                                       .frame = ++m_frame,
                                       .changes = passes::FindChanges(h.Graph(), sample, seen, old)})
                               .mean;
                       })
                       .values;
        return now;
    }
    Picture Variance(Extent2D extent, const Mean& mean, float dullness = 1.0f) {
        return harness
            .Run([&](PassHarness& h) {
                return passes::EstimateVariance(
                    h.Graph(),
                    {Texture(h, "mean", extent, mean.mean), Deviation(h, extent, mean.deviation),
                     Surfaces(h, extent, mean.surfaces)},
                    h.Texture("albedo", extent, Format::Rgba16Float, {0.5f, 0.5f, 0.5f, dullness}));
            })
            .values;
    }
    Picture Filter(Extent2D extent, const Picture& guided, const Picture& surfaces, int stride) {
        return harness
            .Run([&](PassHarness& h) {
                return passes::FilterLevel(h.Graph(), Texture(h, "guided", extent, guided),
                                           Surfaces(h, extent, surfaces), Camera(extent), {stride, 0});
            })
            .values;
    }
    Picture Resolve(Extent2D extent, const Picture& filtered, const Frame& frame, const Picture& mean,
                    const Picture& surfacesBefore, const Picture& before, passes::ResolveSettings settings) {
        settings.frame = ++m_frame;
        return harness
            .Run([&](PassHarness& h) {
                return passes::ResolveMoving(h.Graph(), Texture(h, "filtered", extent, filtered),
                                             Seen(h, extent, frame), Texture(h, "mean", extent, mean),
                                             Surfaces(h, extent, surfacesBefore),
                                             Texture(h, "pictureBefore", extent, before), settings);
            })
            .values;
    }
    // All steps, frame by frame.
    struct Loop {
        Mean mean;
        Picture picture;
    };
    Loop Begin(Extent2D extent) { return {NoMean(extent), Filled(extent, {0, 0, 0, 0})}; }
    void Advance(Extent2D extent, Loop& loop, const Frame& frame, uint32_t mostBefore = 64) {
        const Picture surfacesBefore = loop.mean.surfaces;
        loop.mean = Accumulate(extent, frame, loop.mean, mostBefore, 32);
        Picture filtered = Variance(extent, loop.mean);
        for (const int stride : {1, 2, 4, 8, 16}) filtered = Filter(extent, filtered, frame.surfaces, stride);
        loop.picture = Resolve(extent, filtered, frame, loop.mean.mean, surfacesBefore, loop.picture,
                               {mostBefore, 10, 64, false});
    }
    PassHarness harness{Device()};

  private:
    uint32_t m_frame = 0;
};

float At(const Picture& picture, Extent2D extent, int x, int y, int channel = 0) {
    return picture[4 * (static_cast<size_t>(y) * extent.width + static_cast<size_t>(x)) +
                   static_cast<size_t>(channel)];
}

}  // namespace

// --- AccumulateMoving ---

TEST_F(RealTimeSteps, AccumulateMoving_Still_IsTheMeanOfSampleOverAlbedo) {
    const Extent2D extent{5, 3};
    Mean mean = NoMean(extent);
    for (const float value : {1.0f, 2.0f, 6.0f, 3.0f})
        mean = Accumulate(extent, StillFrame(extent, Filled(extent, Gray(value))), mean);
    for (size_t i = 0; i < mean.deviation.size(); ++i) {
        EXPECT_NEAR(mean.mean[4 * i], 6.0f, 6.0f * 2.0f * kRounding);  // 12 / 4 / .5
        EXPECT_EQ(mean.mean[4 * i + 3], 4.0f);
        // The square root of (1 + 4 + 36 + 9) / 4 / .25 - 6 * 6
        EXPECT_NEAR(mean.deviation[i], 3.7417f, 3.7f * 2.0f * kRounding);
    }
}

TEST_F(RealTimeSteps, AccumulateMoving_MostSamples_BoundWhatCounts) {
    const Extent2D extent{2, 2};
    const Mean old = Accumulate(extent, StillFrame(extent, Filled(extent, Gray(1.0f))), NoMean(extent));
    Mean mean = old;
    mean.mean[3] = 50.0f;  // samples
    const Frame dark = StillFrame(extent, Filled(extent, Gray(0.0f)));
    EXPECT_NEAR(Accumulate(extent, dark, mean, 3).mean[0], 2.0f * 3.0f / 4.0f, 2.0f * kRounding);
    EXPECT_NEAR(Accumulate(extent, dark, mean, 100, 10).mean[0], 2.0f * 9.0f / 10.0f, 2.0f * kRounding);
    EXPECT_EQ(Accumulate(extent, dark, mean, 0).mean[0], 0.0f);
    EXPECT_EQ(Accumulate(extent, dark, mean, 0).mean[3], 1.0f);
}

TEST_F(RealTimeSteps, AccumulateMoving_MovedSurface_BringsItsHistoryAlong) {
    const Extent2D extent{9, 4};
    const Frame first =
        StillFrame(extent, Made(extent, [](int x, int) { return Gray(static_cast<float>(x)); }));
    const Mean mean = Accumulate(extent, first, NoMean(extent));
    for (const float shift : {-3.0f, 2.0f, 0.5f, -1.25f}) {
        Frame second = first;
        second.motion = Filled(extent, {shift, 0, 1, 1});
        second.sample = Filled(extent, Gray(0.0f));
        const Mean moved = Accumulate(extent, second, mean);
        for (int x = 0; x < 9; ++x) {
            const float from = static_cast<float>(x) + shift;
            const bool isInside = from >= 0.0f && from <= 8.0f;
            if (from > -2.0f && from < 10.0f && !isInside) continue;  // it is beside the picture
            EXPECT_NEAR(At(moved.mean, extent, x, 1), isInside ? from : 0.0f, 8.0f * kRounding)
                << shift << " " << x;
            EXPECT_EQ(At(moved.mean, extent, x, 1, 3), isInside ? 2.0f : 1.0f) << shift << " " << x;
        }
    }
}

TEST_F(RealTimeSteps, AccumulateMoving_OtherSurface_HasNoHistory) {
    const Extent2D extent{4, 4};
    const Mean mean = Accumulate(extent, StillFrame(extent, Filled(extent, Gray(100.0f))), NoMean(extent));
    for (const Texel& surface : {kOther, kFarther, kTurned, kNothing}) {
        Frame frame = StillFrame(extent, Filled(extent, Gray(1.0f)));
        frame.surfaces = Filled(extent, surface);
        EXPECT_EQ(Accumulate(extent, frame, mean).mean, Filled(extent, {2, 2, 2, 1})) << surface[2];
    }
    Frame placeless = StillFrame(extent, Filled(extent, Gray(1.0f)));
    placeless.motion = Filled(extent, {0, 0, 1, 0});
    EXPECT_EQ(Accumulate(extent, placeless, mean).mean, Filled(extent, {2, 2, 2, 1}));
}

// What a mirror shows seems to be where it is not: its plane says nothing, and its distance must agree.
TEST_F(RealTimeSteps, AccumulateMoving_ShownSurface_HasItsHistoryByItsDistance) {
    const Extent2D extent{6, 4};
    const auto shown = [](float depth) { return Texel{0.7f, 0, depth, 3000}; };
    Frame frame = StillFrame(extent, Filled(extent, Gray(1.0f)));
    frame.surfaces = Made(extent, [&](int x, int) { return shown(2.0f + 0.02f * static_cast<float>(x)); });
    const Mean mean = Accumulate(extent, frame, NoMean(extent));
    frame.surfaces = Filled(extent, shown(2.05f));
    EXPECT_EQ(Accumulate(extent, frame, mean).mean, Filled(extent, {2, 2, 2, 2}));
    frame.surfaces = Filled(extent, shown(2.5f));
    EXPECT_EQ(Accumulate(extent, frame, mean).mean, Filled(extent, {2, 2, 2, 1}));
}

// The sample of an edge's pixel is of either surface by chance.
TEST_F(RealTimeSteps, AccumulateMoving_PixelOfAnEdge_FindsItsSurfaceBesideIt) {
    const Extent2D extent{6, 3};
    Frame frame = StillFrame(extent, Made(extent, [](int x, int) { return Gray(x < 3 ? 1.0f : 9.0f); }));
    frame.surfaces = Made(extent, [](int x, int) { return x < 3 ? kWall : kOther; });
    const Mean mean = Accumulate(extent, frame, NoMean(extent));
    frame.surfaces = Made(extent, [](int x, int) { return x < 4 ? kWall : kOther; });
    frame.sample = Filled(extent, Gray(1.0f));
    const Mean next = Accumulate(extent, frame, mean);
    EXPECT_EQ(At(next.mean, extent, 3, 1), 2.0f);
    EXPECT_EQ(At(next.mean, extent, 3, 1, 3), 2.0f);
}

// Each sample adds less than half the distance between two halves.
TEST_F(RealTimeSteps, AccumulateMoving_SmallSteps_ReachTheirMean) {
    const Extent2D extent{16, 16};
    Mean mean = NoMean(extent);
    const Frame before = StillFrame(extent, Filled(extent, Gray(0.5f)));
    const Frame after = StillFrame(extent, Filled(extent, Gray(0.5025f)));
    for (int i = 0; i < 10; ++i) mean = Accumulate(extent, before, mean, 100, 32);
    EXPECT_EQ(mean.mean[0], 1.0f);
    for (int i = 0; i < 120; ++i) mean = Accumulate(extent, after, mean, 100, 32);
    double average = 0.0;
    for (size_t i = 0; i < mean.mean.size(); i += 4) average += mean.mean[i] / 256.0;
    EXPECT_NEAR(average, 1.005, 0.0005);
}

TEST_F(RealTimeSteps, AccumulateMoving_SmallDeviation_IsFoundBesideALargeMean) {
    const Extent2D extent{8, 8};
    Mean mean = NoMean(extent);
    for (int i = 0; i < 16; ++i)
        mean =
            Accumulate(extent, StillFrame(extent, Filled(extent, Gray(i % 2 == 0 ? 496.0f : 504.0f))), mean);
    for (const float deviation : mean.deviation) EXPECT_NEAR(deviation, 8.0f, 0.5f);
}

TEST_F(RealTimeSteps, AccumulateMoving_BeyondHalves_IsTheLargestHalf) {
    const Extent2D extent{3, 2};
    Mean mean = NoMean(extent);
    for (const float value : {1e9f, 40000.0f})
        mean = Accumulate(extent, StillFrame(extent, Filled(extent, Gray(value))), mean);
    for (size_t i = 0; i < mean.deviation.size(); ++i) {
        EXPECT_EQ(mean.mean[4 * i], 65504.0f);
        EXPECT_EQ(mean.deviation[i], 0.0f);
    }
}

// A lamp that lights the left part is dimmed; samples are as noisy as their mean.
TEST_F(RealTimeSteps, FindChanges_OldLightIsGoneInFourFramesAndStaysElsewhere) {
    const Extent2D extent{96, 32};
    std::mt19937 generator(17);
    std::exponential_distribution<float> exponential(1.0f);
    Mean mean{Filled(extent, {2, 2, 2, 32}), std::vector<float>(96 * 32, 2.0f), Filled(extent, kWall)};
    Frame frame = StillFrame(extent, {});
    for (int i = 0; i < 4; ++i) {
        frame.sample =
            Made(extent, [&](int x, int) { return Gray((x < 32 ? 0.5f : 1.0f) * exponential(generator)); });
        mean = AccumulateChanged(extent, frame, mean);
    }
    double left = 0.0, samplesRight = 0.0;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 96; ++x) {
            if (x < 24) left += At(mean.mean, extent, x, y) / (24.0 * 32.0);
            if (x >= 48) samplesRight += At(mean.mean, extent, x, y, 3) / (48.0 * 32.0);
        }
    EXPECT_NEAR(left, 1.0, 0.07);  // it was 2
    EXPECT_GT(samplesRight, 30.0);
}

// --- EstimateVariance ---

TEST_F(RealTimeSteps, EstimateVariance_OfManySamples_IsThatOfTheirMean) {
    const Extent2D extent{6, 5};
    Mean mean{Filled(extent, {3, 3, 3, 8}), std::vector<float>(30, 2.6458f), Filled(extent, kWall)};
    const Picture guided = Variance(extent, mean);
    for (size_t i = 0; i < 30; ++i)
        EXPECT_NEAR(guided[4 * i + 3] * guided[4 * i + 3], 1.75f,
                    4.0f * kRounding);  // (1 + 6 / 8) of 7 / (8 - 1)
    const float ofMirror = Variance(extent, mean, 0.0f)[3];
    EXPECT_NEAR(ofMirror * ofMirror, 0.175f, kRounding);
}

TEST_F(RealTimeSteps, EstimateVariance_OfOneSample_IsThatOfTheSurfaceAround) {
    const Extent2D extent{32, 32};
    std::mt19937 generator(3);
    std::normal_distribution<float> normal(10.0f, 2.0f);
    Mean mean{Made(extent, [&](int, int) { return Gray(normal(generator)); }), {}, {}};
    mean.surfaces = Made(extent, [](int x, int) { return x < 16 ? kWall : kOther; });
    for (size_t i = 0; i < 32 * 32; ++i) {
        if (i % 32 >= 16) mean.mean[4 * i] = mean.mean[4 * i + 1] = mean.mean[4 * i + 2] = 1000.0f;
        mean.deviation.push_back(0.0f);
    }
    const Picture guided = Variance(extent, mean);
    double average = 0.0;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 16; ++x) average += std::pow(At(guided, extent, x, y, 3), 2.0) / 512.0;
    EXPECT_NEAR(average, 7 * 4.0, 5.0);  // the other surface is not in it
    EXPECT_NEAR(At(guided, extent, 20, 9, 3), 0.0f, 1.0f);
}

// --- FilterLevel ---

TEST_F(RealTimeSteps, FilterLevel_ConstantStays) {
    const Extent2D extent{13, 7};
    const Picture constant = Filled(extent, {0.3f, 0.7f, 1.9f, 0.5f});
    const Picture filtered = Filter(extent, constant, Filled(extent, kWall), 2);
    for (size_t i = 0; i < constant.size(); ++i)
        EXPECT_NEAR(filtered[i], i % 4 == 3 ? filtered[i] : constant[i], constant[i] * kRounding);
}

TEST_F(RealTimeSteps, FilterLevel_WithoutVariance_ChangesNothing) {
    const Extent2D extent{16, 9};
    const Picture detailed = Made(extent, [](int x, int y) {
        return Texel{1.0f + 0.1f * static_cast<float>(x), 2.0f + 0.2f * static_cast<float>(y * x % 5), 1, 0};
    });
    const Picture filtered = Filter(extent, detailed, Filled(extent, kWall), 1);
    for (size_t i = 0; i < detailed.size(); ++i)
        EXPECT_NEAR(filtered[i], detailed[i], detailed[i] * kRounding);
}

TEST_F(RealTimeSteps, FilterLevel_NothingLeaksOverEdges) {
    const Extent2D extent{8, 8};
    const Picture guided = Made(extent, [](int x, int) {
        const float value = x < 4 ? 1.0f : 100.0f;
        return Texel{value, value, value, 1e4f};
    });
    for (const Texel& beyond : {kOther, kTurned, kNothing, kFarther}) {
        const Picture surfaces = Made(extent, [&](int x, int) { return x < 4 ? kWall : beyond; });
        for (const int stride : {1, 2}) {
            const Picture filtered = Filter(extent, guided, surfaces, stride);
            for (int y = 0; y < 8; ++y)
                for (int x = 0; x < 4; ++x)
                    EXPECT_NEAR(At(filtered, extent, x, y), 1.0f, kRounding) << beyond[2] << " " << stride;
        }
    }
}

TEST_F(RealTimeSteps, FilterLevel_Noise_FallsAndKeepsItsMean) {
    const Extent2D extent{64, 64};
    std::mt19937 generator(5);
    std::exponential_distribution<float> exponential(1.0f);
    Picture picture = Made(extent, [&](int, int) {
        const float value = exponential(generator);
        return Texel{value, value, value, 2.65f};  // as EstimateVariance takes it from a single sample
    });
    double before = 0.0, after = 0.0, error = 0.0;
    for (size_t i = 0; i < picture.size(); i += 4) before += picture[i] / 4096.0;
    for (const int stride : {1, 2, 4}) picture = Filter(extent, picture, Filled(extent, kWall), stride);
    for (size_t i = 0; i < picture.size(); i += 4) {
        after += picture[i] / 4096.0;
        error += (picture[i] - 1.0) * (picture[i] - 1.0) / 4096.0;
    }
    EXPECT_NEAR(after, before, 0.001 * before);
    EXPECT_LT(error, 0.1);  // it was 1
}

// Pixels exchange equal parts, however their noise, their brightness, their normals and, in mirrors, the lengths
// of their paths differ.
TEST_F(RealTimeSteps, FilterLevel_LosesNoLight) {
    const Extent2D extent{40, 40};
    const auto sum = [](const Picture& of) {
        double total = 0.0;
        for (size_t i = 0; i < of.size(); i += 4) total += of[i];
        return total;
    };
    const float kShown = 3000.0f;
    for (const float number : {2.0f, kShown}) {
        std::mt19937 generator(9);
        std::exponential_distribution<float> exponential(1.0f);
        const Picture surfaces = Made(extent, [&](int x, int y) {
            const float slope = number == kShown ? 0.08f : 0.01f;
            return Texel{0.02f * static_cast<float>(x % 7), 0, 2.0f + slope * static_cast<float>(y), number};
        });
        // Brighter with each row, so that an unequal exchange between rows would show
        Picture picture = Made(extent, [&](int, int y) {
            const float value = static_cast<float>(y + 1) * std::pow(exponential(generator), 3.0f);
            return Texel{value, value, value, 20.0f * exponential(generator)};
        });
        const double before = sum(picture);
        for (const int stride : {1, 2, 4}) {
            const Picture filtered = Filter(extent, picture, surfaces, stride);
            EXPECT_NEAR(sum(filtered), before, 0.001 * before) << number << " " << stride;
            picture = filtered;
        }
    }
}

TEST_F(RealTimeSteps, Firefly_IsDistributedButABodyIsNot) {
    const Extent2D extent{33, 33};
    const auto filtered = [&](int side) {  // a bright square
        Mean mean{Made(extent,
                       [&](int x, int y) {
                           const bool isBright =
                               std::clamp(x, 16, 15 + side) == x && std::clamp(y, 16, 15 + side) == y;
                           return Texel{isBright ? 500.0f : 1.0f, isBright ? 500.0f : 1.0f,
                                        isBright ? 500.0f : 1.0f, 8};
                       }),
                  std::vector<float>(33 * 33), Filled(extent, kWall)};
        Picture picture = Variance(extent, mean);
        for (const int stride : {1, 2, 4, 8, 16}) picture = Filter(extent, picture, mean.surfaces, stride);
        return picture;
    };
    const Picture firefly = filtered(1);
    EXPECT_LT(At(firefly, extent, 16, 16), 50.0f);
    double sum = 0.0;
    for (size_t i = 0; i < firefly.size(); i += 4) sum += firefly[i];
    EXPECT_NEAR(sum, 500.0 + 33 * 33 - 1, 0.005 * sum);
    EXPECT_NEAR(At(filtered(2), extent, 16, 16), 500.0f, 1.0f);
}

// --- ResolveMoving ---

TEST_F(RealTimeSteps, ResolveMoving_Still_IsTheMeanOfAllPicturesTheLastOnesMost) {
    const Extent2D extent{4, 3};
    Frame frame = StillFrame(extent, {});
    Picture picture = Filled(extent, {0, 0, 0, 0});
    const passes::ResolveSettings settings{.mostBefore = 64, .mostMoving = 2, .mostStill = 64};
    float samples = 1.0f;
    for (const float value : {2.0f, 8.0f, 2.0f, 4.0f})  // a clamp to the neighborhood would show
        picture = Resolve(extent, Filled(extent, Gray(value)), frame, Filled(extent, {1, 1, 1, samples++}),
                          frame.surfaces, picture, settings);
    for (size_t i = 0; i < picture.size(); i += 4) {
        EXPECT_NEAR(picture[i], 2.0f, 4.0f * kRounding);  // (2 + 2 * 8 + 3 * 2 + 4 * 4) / 10 * .5
        EXPECT_EQ(picture[i + 3], 4.0f);
    }
}

// A pixel may show either of two surfaces by chance: the picture of both is their mean while all stands still.
TEST_F(RealTimeSteps, ResolveMoving_StillFrame_AveragesDifferentSurfaces) {
    const Extent2D extent{5, 4};
    const Frame frame = StillFrame(extent, {});
    const auto shown = [&](bool isStill) {
        return Resolve(extent, Filled(extent, Gray(2.0f)), frame, Filled(extent, {1, 1, 1, 1}),
                       Filled(extent, kOther), Filled(extent, {34, 34, 34, 9}),
                       {.mostBefore = 64, .isStill = isStill})[0];
    };
    EXPECT_NEAR(shown(true), 28.0f, 28.0f * kRounding);  // 34 + (1 - 34) * 2 / 11
    EXPECT_EQ(shown(false), 1.0f);                       // its neighborhood shows nothing else
}

TEST_F(RealTimeSteps, ResolveMoving_Moving_ClampsWhatItsNeighborhoodCannotBe) {
    const Extent2D extent{8, 8};
    Frame frame = StillFrame(extent, {});
    frame.motion = Filled(extent, {1, 0, 1, 1});
    const Picture picture = Resolve(extent, Filled(extent, Gray(2.0f)), frame, Filled(extent, {1, 1, 1, 9}),
                                    frame.surfaces, Filled(extent, {50, 50, 50, 9}), {.mostBefore = 64});
    EXPECT_NEAR(At(picture, extent, 3, 3), 1.0f, kRounding);
}

// --- All steps ---

TEST_F(RealTimeSteps, ValuesThatAreNotFinite_LeaveTheOthersFinite) {
    const Extent2D extent{7, 5};
    Loop loop = Begin(extent);
    for (int i = 0; i < 3; ++i) {
        Picture sample = Filled(extent, Gray(1.0f));
        sample[4 * 9] = kNan;
        sample[4 * 17 + 1] = kInfinity;
        sample[4 * 23 + 2] = -kInfinity;
        Advance(extent, loop, StillFrame(extent, sample));
    }
    for (const float value : loop.picture) EXPECT_TRUE(std::isfinite(value));
}

TEST_F(RealTimeSteps, WithoutNoise_ThePictureIsTheSample) {
    for (const Extent2D extent : {Extent2D{1, 1}, Extent2D{17, 11}}) {
        Loop loop = Begin(extent);
        Frame frame = StillFrame(extent, Made(extent, [](int x, int y) {
                                     return Texel{1.0f + static_cast<float>((x * 7 + y * 3) % 5), 1, 2, 1};
                                 }));
        for (int i = 0; i < 64; ++i) Advance(extent, loop, frame);
        for (size_t i = 0; i < loop.picture.size(); ++i)
            EXPECT_NEAR(loop.picture[i], i % 4 == 3 ? 64.0f : frame.sample[i], 0.015f * frame.sample[i]);
    }
}

// Surfaces that a dark mirror shows have a small albedo, black ones none.
TEST_F(RealTimeSteps, AnyAlbedo_LosesNoLight) {
    const Extent2D extent{4, 3};
    Loop loop = Begin(extent);
    Frame frame = StillFrame(extent, Filled(extent, {0.5f, 2.0f, 3.0f, 1.0f}));
    frame.albedo = Filled(extent, {0.001f, 0.3f, 0.0f, 1.0f});
    for (int i = 0; i < 3; ++i) Advance(extent, loop, frame);
    for (size_t i = 0; i < loop.picture.size(); ++i)
        EXPECT_NEAR(loop.picture[i], i % 4 == 3 ? 3.0f : frame.sample[i], 4.0f * kRounding * frame.sample[i]);
}

// Places between pixels are sampled by weights that sum to 1.
TEST_F(RealTimeSteps, WithoutNoise_AConstantStaysWhateverMoves) {
    const Extent2D extent{19, 13};
    Loop loop = Begin(extent);
    Frame frame = StillFrame(extent, Filled(extent, {0.25f, 3.0f, 40.0f, 1.0f}));
    for (int i = 0; i < 12; ++i) {
        frame.motion = Filled(extent, {0.37f, -1.61f, 1, 1});
        Advance(extent, loop, frame);
        for (size_t p = 0; p < loop.picture.size(); ++p) {
            if (p % 4 == 3) continue;
            ASSERT_NEAR(loop.picture[p], frame.sample[p], 2.0f * kRounding * frame.sample[p]) << i;
        }
    }
}

// A noisy bright wall beside a dark one: of its light, less than a thousandth gets over the edge.
TEST_F(RealTimeSteps, NoisyNeighbor_DoesNotLeak) {
    const Extent2D extent{24, 16};
    std::mt19937 generator(21);
    std::exponential_distribution<float> bright(1.0f / 100.0f);
    for (const Texel& beyond : {kOther, kTurned}) {
        Loop loop = Begin(extent);
        for (int i = 0; i < 8; ++i) {
            Frame frame = StillFrame(
                extent, Made(extent, [&](int x, int) { return Gray(x < 12 ? 1.0f : bright(generator)); }));
            frame.surfaces = Made(extent, [&](int x, int) { return x < 12 ? kWall : beyond; });
            Advance(extent, loop, frame);
        }
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 12; ++x) EXPECT_NEAR(At(loop.picture, extent, x, y), 1.0f, 0.1f) << x;
    }
}

// A lit checker moves two pixels a frame: its history moves with it.
TEST_F(RealTimeSteps, MovingChecker_LeavesNoGhost) {
    const Extent2D extent{48, 24};
    Loop loop = Begin(extent);
    Frame frame = StillFrame(extent, {});
    frame.motion = Filled(extent, {-2, 0, 1, 1});
    const auto checker = [&](int shift) {
        return Made(extent, [&](int x, int y) {
            return Gray(((x - shift + 96) / 6 + y / 6) % 2 == 0 ? 1.0f : 0.1f);
        });
    };
    for (int i = 0; i < 12; ++i) {
        frame.sample = checker(2 * i);
        Advance(extent, loop, frame);
    }
    const Picture truth = checker(22);
    double error = 0.0, count = 0.0;
    for (int y = 0; y < 24; ++y)
        for (int x = 26; x < 46; ++x, count += 1.0)
            error += std::abs(At(loop.picture, extent, x, y) - At(truth, extent, x, y));
    EXPECT_LT(error / count, 0.02);
}

// A bright body moves away from a dark wall.
TEST_F(RealTimeSteps, DisoccludedWall_ShowsNoOldColor) {
    const Extent2D extent{32, 16};
    Loop loop = Begin(extent);
    for (int i = 0; i < 12; ++i) {
        const int left = i < 8 ? 8 : 20;  // of 8 pixels
        const auto isBody = [&](int x) { return x >= left && x < left + 8; };
        Frame frame =
            StillFrame(extent, Made(extent, [&](int x, int) { return Gray(isBody(x) ? 10.0f : 0.1f); }));
        frame.surfaces = Made(extent, [&](int x, int) { return isBody(x) ? kOther : kWall; });
        if (i == 8)
            frame.motion = Made(extent, [&](int x, int) {
                return Texel{isBody(x) ? -12.0f : 0.0f, 0, 1, 1};
            });
        Advance(extent, loop, frame);
    }
    for (int y = 0; y < 16; ++y)
        for (int x = 8; x < 16; ++x) EXPECT_NEAR(At(loop.picture, extent, x, y), 0.1f, 1e-3f);
}

// --- HandOver ---

// The mean of noisy samples around 1, with a picture of that value.
TEST_F(RealTimeSteps, HandOver_WeighsByBothErrors) {
    const Extent2D extent{24, 16};
    passes::Accumulation accumulation("handOver");
    std::mt19937 generator(11);
    std::normal_distribution<float> normal(1.0f, 0.5f);
    const auto show = [&](float picture, uint32_t addedSamples) {
        Picture mean;
        for (uint32_t i = 0; i < addedSamples; ++i)
            mean = harness
                       .Run([&](PassHarness& h) {
                           const Picture sample =
                               Made(extent, [&](int, int) { return Gray(normal(generator)); });
                           return passes::Accumulate(h.Graph(),
                                                     h.Texture("sample", extent, Format::Rgba32Float, sample),
                                                     accumulation, true)
                               .mean;
                       })
                       .values;
        const Picture shown =
            harness
                .Run([&](PassHarness& h) {
                    return passes::HandOver(h.Graph(),
                                            Texture(h, "picture", extent, Filled(extent, Gray(picture))),
                                            passes::StoredAccumulation(h.Graph(), accumulation, extent, true),
                                            accumulation.Declared());
                })
                .values;
        double deviation = 0.0;  // from 1
        for (size_t i = 0; i < shown.size(); i += 4)
            deviation += (shown[i] - 1.0) * (shown[i] - 1.0) / (double(shown.size()) / 4.0);
        return std::sqrt(deviation);
    };
    EXPECT_NEAR(show(3.0f, 7), 2.0, 1e-3);   // They are too few: it is the picture
    EXPECT_LT(show(1.0f, 1), 0.06);          // The mean has an error of .18
    EXPECT_NEAR(show(3.0f, 0), 0.18, 0.05);  // The picture has one of 2
    EXPECT_LT(show(1.2f, 60), 0.08);         // The mean has one of .06
    accumulation.Reset(passes::ResetCause::Start);
    passes::Release(harness.Graph(), accumulation);
}

// A tile of the eighth sample has reached the first rows: only there are enough samples.
TEST_F(RealTimeSteps, HandOver_TileOfASample_CountsWhereItIs) {
    const Extent2D extent{13, 21};
    constexpr uint32_t kRows = 8;
    passes::Accumulation accumulation("handOverTiles");
    const auto add = [&](uint32_t rows) {
        harness.Run([&](PassHarness& h) {
            const passes::Region region =
                accumulation.Declared().cursor.Next(extent, uint64_t{extent.width} * rows);
            const Extent2D size{region.width, region.height};
            return passes::AccumulateTile(
                       h.Graph(), h.Texture("tile", size, Format::Rgba32Float, Filled(size, Gray(1.0f))),
                       extent, region, accumulation, true)
                .mean;
        });
    };
    for (int i = 0; i < 7; ++i) add(extent.height);
    add(kRows);
    ASSERT_EQ(accumulation.Declared().cursor.Y(), kRows);
    const Picture shown =
        harness
            .Run([&](PassHarness& h) {
                return passes::HandOver(h.Graph(), Texture(h, "picture", extent, Filled(extent, Gray(7.0f))),
                                        passes::StoredAccumulation(h.Graph(), accumulation, extent, true),
                                        accumulation.Declared());
            })
            .values;
    for (int y = 0; y < 21; ++y)
        for (int x = 0; x < 13; ++x)
            if (y < 4 || y >= 8) {
                EXPECT_NEAR(At(shown, extent, x, y), y < 4 ? 1.0f : 7.0f, 0.01f) << x << " " << y;
            }
    accumulation.Reset(passes::ResetCause::Start);
    passes::Release(harness.Graph(), accumulation);
}

}  // namespace raygraph::testing::real_time_test
