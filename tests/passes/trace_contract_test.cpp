// What Trace and PrimaryHits promise besides the physics: same bits, ids, cameras, transforms.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "renderer/graph/readback_values.h"
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_contract_test {

using passes::TraceSettings;

namespace {

class TraceContract : public VulkanTest {
  protected:
    // A lit box in a box: paths of every length.
    void SetBoxes() {
        render.scene.SetScene(SceneOf({BoxMesh(1.0f), BoxMesh(0.4f, 1)},
                                      {Lambert(glm::vec3(0.6f), glm::vec3(0.3f)), Lambert(glm::vec3(0.8f))},
                                      {glm::mat4x3(1.0f), Translation({0.4f, -0.5f, 0.1f})}));
    }
    static TraceSettings InsideBoxes() { return LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, 48); }

    SceneRender render{Device()};
};

bool SameBits(const FloatImage& a, const FloatImage& b) {
    return std::equal(a.values.begin(), a.values.end(), b.values.begin(), b.values.end());
}

}  // namespace

TEST_F(TraceContract, Trace_IsAFunctionOfSeedPixelAndSample) {
    SetBoxes();
    TraceSettings settings = InsideBoxes();
    settings.sampleIndex = 5;
    const FloatImage first = render.TraceOnce(settings);
    settings.sampleIndex = 6;
    EXPECT_FALSE(SameBits(first, render.TraceOnce(settings)));
    settings.sampleIndex = 5;
    settings.seed = 1;
    EXPECT_FALSE(SameBits(first, render.TraceOnce(settings)));
    settings.seed = 0;
    EXPECT_TRUE(SameBits(first, render.TraceOnce(settings))) << "what was rendered in between must not show";
    SceneRender another(Device());
    another.scene.SetScene(SceneOf({BoxMesh(1.0f), BoxMesh(0.4f, 1)},
                                   {Lambert(glm::vec3(0.6f), glm::vec3(0.3f)), Lambert(glm::vec3(0.8f))},
                                   {glm::mat4x3(1.0f), Translation({0.4f, -0.5f, 0.1f})}));
    EXPECT_TRUE(SameBits(first, another.TraceOnce(settings)));
}

// Options that hardly change the mean: tests of the mean would not notice if one had no effect.
TEST_F(TraceContract, Trace_HowLightIsChosenWeighedAndReflectedChangesTheSample) {
    scene::Material metal = Lambert({0.9f, 0.6f, 0.3f});
    metal.metallicFactor = 1.0f;
    metal.roughnessFactor = 0.4f;
    render.scene.SetScene(SceneOf({BoxMesh(1.0f), BoxMesh(0.4f, 1)},
                                  {Lambert(glm::vec3(0.6f), {0.3f, 0.2f, 0.1f}), metal},
                                  {glm::mat4x3(1.0f), Translation({0.4f, -0.5f, 0.1f})}));
    TraceSettings settings = LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, 16);
    settings.scattering = {};
    const FloatImage first = render.TraceOnce(settings);
    const auto differs = [&](auto change) {
        TraceSettings changed = settings;
        change(changed);
        return !SameBits(first, render.TraceOnce(changed));
    };
    EXPECT_TRUE(differs([](TraceSettings& s) { s.lights.sampler = LightSampler::Uniform; }));
    EXPECT_TRUE(differs([](TraceSettings& s) { s.lights.mis = MisHeuristic::Balance; }));
    EXPECT_TRUE(differs([](TraceSettings& s) { s.scattering.fresnel = FresnelModel::Lazanyi; }));
}

TEST_F(TraceContract, Trace_CountsItsRays) {
    SetBoxes();
    TraceSettings settings = InsideBoxes();
    settings.biases.maxDepth = 2;
    settings.roulette.start = 100;
    settings.lights.isOn = false;  // shadow rays count, too
    render.renderer.BeginFrame();
    const SceneIds ids = render.scene.Declare(render.renderer);
    const passes::TraceIds traced = passes::Trace(render.renderer, ids, settings, {.rayCounts = true});
    const Readback counted = render.renderer.ReadBack(traced.radiance);
    const Readback counts = render.renderer.ReadBack(traced.rayCounts);
    render.renderer.Execute();
    counts.Wait();
    const auto* rays = reinterpret_cast<const float*>(counts.Bytes().data());
    for (size_t i = 0; i < counts.Bytes().size() / sizeof(float); ++i)
        ASSERT_EQ(rays[i], 3.0f) << "a closed box ends every path at the depth limit";
    EXPECT_TRUE(SameBits(ToFloatImage(counted), render.TraceOnce(settings)))
        << "counting must not change the picture";
}

TEST_F(TraceContract, Trace_CountsTheRaysOfAllPaths) {
    SetBoxes();
    TraceSettings settings = InsideBoxes();
    settings.sampleCount = 3;
    settings.biases.maxDepth = 12;  // more rays than a wavefront has steps
    settings.roulette.start = 100;
    const auto take = [&](bool ofPixels) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::TraceIds traced =
            passes::Trace(render.renderer, ids, settings, {.rayCounts = ofPixels});
        const Readback counts = render.renderer.ReadBack(traced.counts);
        const Readback rays = render.renderer.ReadBack(ofPixels ? traced.rayCounts : traced.radiance);
        render.renderer.Execute();
        if (!ofPixels) return WaitForValues<passes::TraceCounts>(counts).front().Rays();
        const std::vector<float> all = WaitForValues<float>(rays);
        return static_cast<uint64_t>(std::accumulate(all.begin(), all.end(), 0.0));
    };
    for (const bool lightsAreOn : {false, true}) {
        settings.lights.isOn = lightsAreOn;
        settings.form = passes::IntegratorForm::Loop;
        const uint64_t ofPixels = take(true);
        EXPECT_EQ(take(false), ofPixels);
        if (!lightsAreOn) {
            EXPECT_EQ(ofPixels, 13 * passes::PathCount(settings));
        }
        settings.form = passes::IntegratorForm::Wavefront;
        // A GPU rounds differently in each kernel
        EXPECT_NEAR(double(take(false)), double(ofPixels), 0.001 * double(ofPixels));
    }
}

TEST_F(TraceContract, PrimaryHits_NameInstanceMaterialAndTheFilesPrimitive) {
    // Triangles of a fine sphere in an order that no spatial sort would leave
    scene::Mesh sphere = SphereMesh(1.0f, 24, 1);
    scene::Primitive& primitive = sphere.primitives[0];
    const size_t count = primitive.TriangleCount();
    std::vector<uint32_t> shuffled;
    for (size_t i = 0; i < count; ++i) {
        const size_t source = i * 997 % count;  // 997 is prime: a permutation
        for (size_t corner = 0; corner < 3; ++corner)
            shuffled.push_back(primitive.indices[3 * source + corner]);
    }
    primitive.indices = shuffled;
    const scene::Primitive original = primitive;
    const glm::vec3 offset(0.3f, -0.2f, 0.1f);
    render.scene.SetScene(SceneOf({QuadMesh(0.1f), sphere},
                                  {Lambert(glm::vec3(0.1f)), Lambert(glm::vec3(0.7f))},
                                  {Translation({9, 9, 9}), Translation(offset)}));
    const SceneRender::Hits hits = render.PrimaryHits(LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 48));
    uint32_t hitCount = 0;
    for (size_t i = 0; i < hits.ids.size(); ++i) {
        if (hits.ids[i].x == 0xFFFFFFFFu) {
            EXPECT_TRUE(std::isinf(hits.position.values[i].w));
            continue;
        }
        ++hitCount;
        ASSERT_EQ(hits.ids[i].x, 1u);
        ASSERT_EQ(hits.ids[i].y, 1u);
        ASSERT_LT(hits.ids[i].z, count);
        EXPECT_EQ(glm::vec3(hits.albedo.values[i]), glm::vec3(0.7f));
        // The hit lies in the triangle that the id names, as the file ordered it
        const uint32_t* corner = &original.indices[3 * hits.ids[i].z];
        const glm::vec3 p = glm::vec3(hits.position.values[i]) - offset;
        const glm::vec3 a = original.positions[corner[0]], b = original.positions[corner[1]],
                        c = original.positions[corner[2]];
        const glm::vec3 n = glm::cross(b - a, c - a);
        EXPECT_LT(std::abs(glm::dot(p - a, glm::normalize(n))), 1e-5f);
        EXPECT_GT(glm::dot(glm::cross(b - a, p - a), n), -1e-6f);
        EXPECT_GT(glm::dot(glm::cross(c - b, p - b), n), -1e-6f);
        EXPECT_GT(glm::dot(glm::cross(a - c, p - c), n), -1e-6f);
        EXPECT_NEAR(hits.position.values[i].w, 4.0f - (p + offset).z, 1e-4f) << "depth runs along the view";
    }
    EXPECT_GT(hitCount, 500u);
}

TEST_F(TraceContract, PrimaryHits_RowZeroIsTheTopAndColumnZeroTheLeft) {
    render.scene.SetScene(SceneOf({QuadMesh(0.2f, 0), QuadMesh(0.2f, 1)},
                                  {Lambert(glm::vec3(1, 0, 0)), Lambert(glm::vec3(0, 1, 0))},
                                  {Translation({0, 0.7f, 0}), Translation({0.7f, 0, 0})}));
    const SceneRender::Hits hits = render.PrimaryHits(LookAt({0, 0, 2}, {0, 0, 0}, 0.9f, 9));
    EXPECT_EQ(glm::vec3(hits.albedo.At(4, 1)), glm::vec3(1, 0, 0)) << "+y is up";
    EXPECT_EQ(glm::vec3(hits.albedo.At(7, 4)), glm::vec3(0, 1, 0)) << "+x is right";
    EXPECT_EQ(glm::vec3(hits.albedo.At(1, 4)), glm::vec3(0.0f));
}

TEST_F(TraceContract, PrimaryHits_OrthographicRaysAreParallel) {
    render.scene.SetScene(SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f))}));
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 2.0f;
    TraceSettings settings;
    settings.extent = {64, 64};
    settings.camera = ToRecord(view);
    const SceneRender::Hits hits = render.PrimaryHits(settings);
    uint32_t covered = 0;
    for (size_t i = 0; i < hits.ids.size(); ++i) {
        if (hits.ids[i].x == 0xFFFFFFFFu) continue;
        ++covered;
        EXPECT_EQ(glm::vec3(hits.normal.values[i]), glm::vec3(0, 0, 1)) << "only the front face is seen";
    }
    EXPECT_EQ(covered, 32u * 32u) << "half the height, half the width";
}

TEST_F(TraceContract, PrimaryHits_MirroredInstanceKeepsItsFront) {
    glm::mat4x3 mirrored(1.0f);
    mirrored[0].x = -2.0f;  // mirrors and stretches
    render.scene.SetScene(SceneOf({SphereMesh(1.0f, 32)}, {Lambert(glm::vec3(0.5f))}, {mirrored}));
    const SceneRender::Hits hits = render.PrimaryHits(LookAt({0, 0, 5}, {0, 0, 0}, 0.5f, 32));
    uint32_t hitCount = 0;
    for (size_t i = 0; i < hits.ids.size(); ++i) {
        if (hits.ids[i].x == 0xFFFFFFFFu) continue;
        ++hitCount;
        const glm::vec3 p(hits.position.values[i]);
        const glm::vec3 expected =
            glm::normalize(glm::vec3(p.x / 4.0f, p.y, p.z));  // gradient of the ellipsoid
        EXPECT_GT(glm::dot(glm::vec3(hits.normal.values[i]), expected), 0.995f);
    }
    EXPECT_GT(hitCount, 300u);
}

TEST_F(TraceContract, Trace_RefusesChancesThatAreNone) {
    for (const float survival : {0.0f, -0.5f, 1.5f, std::nanf("")}) {
        Renderer renderer(Device());
        GpuScene scene(renderer);
        TraceSettings settings = InsideBoxes();
        settings.roulette = {.kind = Roulette::Frame, .start = 1, .survival = survival};
        renderer.BeginFrame();
        const SceneIds ids = scene.Declare(renderer);
        EXPECT_THAT(ErrorTextOf([&] { (void)passes::Trace(renderer, ids, settings); }),
                    ::testing::HasSubstr("roulette.survival is"));
    }
}

}  // namespace raygraph::testing::trace_contract_test
