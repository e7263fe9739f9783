#include <gmock/gmock.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>
#include <tuple>

#include "base/error.h"
#include "renderer/graph/readback_values.h"
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Trace and PrimaryHits promise more than the physics: same bits, ids, cameras, transforms.
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
    settings.lights.isOn = false;
    render.renderer.BeginFrame();
    const SceneIds ids = render.Declare();
    const passes::TraceIds traced = passes::Trace(render.renderer, ids, settings, {.rayCounts = true});
    const Readback counted = render.renderer.ReadBack(traced.radiance);
    const Readback counts = render.renderer.ReadBack(traced.rayCounts);
    const Readback bounces = render.renderer.ReadBack(traced.bounces);
    render.renderer.Execute();
    counts.Wait();
    for (const float count : WaitForValues<float>(bounces)) ASSERT_EQ(count, 2.0f);
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
        const SceneIds ids = render.Declare();
        const passes::TraceIds traced =
            passes::Trace(render.renderer, ids, settings, {.rayCounts = ofPixels});
        const Readback counts = render.renderer.ReadBack(traced.counts);
        const Readback rays = render.renderer.ReadBack(ofPixels ? traced.rayCounts : traced.radiance);
        render.renderer.Execute();
        if (!ofPixels) return WaitForValues<passes::TraceCounts>(counts).front().Rays();
        const std::vector<float> all = WaitForValues<float>(rays);
        return static_cast<uint64_t>(std::accumulate(all.begin(), all.end(), 0.0));
    };
    settings.form = passes::IntegratorForm::Loop;
    const uint64_t ofPixels = take(true);
    EXPECT_GT(ofPixels, 13 * passes::PathCount(settings)) << "shadow rays count, too";
    EXPECT_LE(ofPixels, 25 * passes::PathCount(settings));
    EXPECT_EQ(take(false), ofPixels);
    settings.form = passes::IntegratorForm::Wavefront;
    // A GPU rounds differently in each kernel
    EXPECT_NEAR(double(take(false)), double(ofPixels), 0.001 * double(ofPixels));
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

// Rounding may change a picture little, near the world's origin and far from it.
namespace raygraph::testing::trace_precision_test {

using passes::TraceSettings;

namespace {

const glm::dvec3 kPassing(0.224, 0.9, 0.224);  // share of light that passes the pane, face on

class TracePrecision : public VulkanTest {
  protected:
    // The largest relative error, of any pixel and channel, of what passes a pane that is seen face on, and
    // `thick` times as thick as its material is made for.
    double ErrorOfPane(const TraceSettings& settings, double thick = 1.0) {
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        double largest = 0.0;
        for (const glm::vec4& texel : render.Render(settings, 4).mean.values)
            for (int channel = 0; channel < 3; ++channel)
                largest = std::max(
                    largest, std::abs(double{texel[channel]} / std::pow(kPassing[channel], thick) - 1.0));
        return largest;
    }

    SceneRender render{Device()};
};

// An axis-aligned box, `halfSize` about `center`.
scene::Mesh Block(const glm::vec3& halfSize, const glm::vec3& center = glm::vec3(0.0f)) {
    scene::Mesh mesh = BoxMesh(1.0f);
    for (scene::Primitive& primitive : mesh.primitives) {
        primitive.bounds = {};
        for (glm::vec3& position : primitive.positions) {
            position = center + halfSize * position;
            primitive.bounds.Extend(position);
        }
    }
    return mesh;
}

// The face is along x.
scene::Mesh Pane(float thickness) {
    return Block({0.5f * thickness, 1.0f, 1.0f});
}

// Refracts nothing, so that all light that is not absorbed passes.
scene::Material AbsorbingGlass(float thickness) {
    scene::Material glass;
    glass.metallicFactor = 0.0f;
    glass.roughnessFactor = 0.0f;
    glass.transmissionFactor = 1.0f;
    glass.ior = 1.0f;
    glass.thicknessFactor = thickness;
    glass.attenuationColor = kPassing;
    glass.attenuationDistance = thickness;
    return glass;
}

// From `distance` meters in front of a place on the x axis; sees half a meter of it.
TraceSettings FacingX(float x, float distance) {
    TraceSettings settings =
        LookAt({x + distance, 0.0f, 0.0f}, {x, 0.0f, 0.0f}, 2.0f * std::atan(0.025f / distance), 8);
    settings.scattering.brdf = BrdfModel::Gltf;
    settings.roulette.kind = Roulette::Off;
    return settings;
}

}  // namespace

TEST_F(TracePrecision, Trace_PaneAbsorbsTheSameNearAndFar) {
    for (const float x : {0.0f, -100.0f, 200.0f, 300.0f, 1000.0f, -3000.0f, 10000.0f}) {
        render.scene.SetScene(SceneOf({Pane(0.004f)}, {AbsorbingGlass(0.004f)}, {Translation({x, 0, 0})}));
        for (const float distance : {2.0f, 1000.0f})
            EXPECT_LT(ErrorOfPane(FacingX(x, distance)), 0.01) << x << " m, from " << distance << " m";
    }
}

TEST_F(TracePrecision, Trace_PaneOfAMillimeterAbsorbsTheSameUpToAKilometer) {
    // Alone, and in a scene that reaches to the camera, so that the pane is 1 km from where coordinates begin
    for (const bool isAlone : {true, false}) {
        for (const float x : {0.0f, 300.0f, 1000.0f}) {
            scene::SceneData data =
                SceneOf({Pane(0.001f)}, {AbsorbingGlass(0.001f)}, {Translation({x, 0, 0})});
            for (const float beside : {-5.0f, 1000.0f}) {
                if (isAlone) continue;
                data.instances.push_back({.mesh = 0, .objectToWorld = Translation({x + beside, 50, 0})});
            }
            render.scene.SetScene(std::move(data));
            for (const float distance : {2.0f, 1000.0f}) {
                const TraceSettings settings = FacingX(x, distance);
                render.scene.SetViewpoint(EyeOf(settings.camera));
                EXPECT_LT(ErrorOfPane(settings), 0.01)
                    << x << " m, from " << distance << " m" << (isAlone ? ", alone" : "");
            }
        }
    }
}

TEST_F(TracePrecision, Trace_PaneWhoseVerticesAreFarFromTheirOriginAbsorbsTheSame) {
    // Its faces stand on steps of float, 0.03 mm: it is as thick as its vertices say
    const float nearFace = 300.0f, farFace = 300.004f;
    scene::Mesh pane = Pane(0.004f);
    pane.primitives[0].bounds = {};
    for (glm::vec3& position : pane.primitives[0].positions) {
        position.x = position.x < 0.0f ? nearFace : farFace;
        pane.primitives[0].bounds.Extend(position);
    }
    render.scene.SetScene(SceneOf({std::move(pane)}, {AbsorbingGlass(0.004f)}));
    for (const float distance : {2.0f, 1000.0f}) {
        EXPECT_LT(ErrorOfPane(FacingX(300.0f, distance)), 0.01) << "from " << distance << " m";
        EXPECT_LT(ErrorOfPane(FacingX(300.0f, distance), double{farFace - nearFace} / 0.004), 0.005)
            << "below 0.1 % on llvmpipe, 0.29 % on an NVIDIA H200: they round otherwise";
    }
}

TEST_F(TracePrecision, Trace_LitQuadWhosePlaceCancelsDoesNotShadowItself) {
    // White sky, found by the surface's own sampling alone: all of it, unless a ray meets the quad again
    for (const float far : {0.0f, 1000.0f}) {
        for (const float tilt : {0.3f, 0.8f, 1.3f}) {
            scene::Mesh quad = QuadMesh(1.0f);
            quad.primitives[0].bounds = {};
            for (glm::vec3& p : quad.primitives[0].positions) {
                p = glm::vec3(p.x, p.y * std::cos(tilt), p.y * std::sin(tilt)) + glm::vec3(far);
                quad.primitives[0].bounds.Extend(p);
            }
            quad.primitives[0].normals.clear();
            render.scene.SetScene(
                SceneOf({std::move(quad)}, {Lambert(glm::vec3(0.5f))}, {Translation(glm::vec3(-far))}));
            render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
            TraceSettings settings = LookAt({0.5f, -3.0f, 3.0f}, {0, 0, 0}, 0.2f, 32);
            settings.lights.isOn = false;
            settings.roulette.kind = Roulette::Off;
            int darkCount = 0;
            for (const glm::vec4& texel : render.Render(settings, 4).mean.values)
                if (texel.y < 0.4999f) ++darkCount;
            EXPECT_EQ(darkCount, 0) << "vertices at " << far << ", tilted by " << tilt;
        }
    }
}

// A lamp lights a floor. `size` scales the vertices or the nodes, and the distance of the camera. It is a
// power of two, which leaves the digits of all numbers unchanged.
TEST_F(TracePrecision, Trace_SceneOfAnySizeLooksTheSame) {
    const auto mean = [this](float size, bool isOfVertices) {
        scene::Mesh floor = QuadMesh(1.0f), lamp = QuadMesh(0.5f, 1);
        for (scene::Mesh* mesh : {&floor, &lamp}) {
            if (!isOfVertices) continue;
            scene::Primitive& primitive = mesh->primitives[0];
            primitive.bounds = {};
            for (glm::vec3& position : primitive.positions) primitive.bounds.Extend(position *= size);
        }
        const float scale = isOfVertices ? 1.0f : size;
        const glm::mat4x3 low(glm::vec3(scale, 0, 0), glm::vec3(0, scale, 0), glm::vec3(0, 0, scale),
                              glm::vec3(0.0f));
        glm::mat4x3 high(glm::vec3(-scale, 0, 0), glm::vec3(0, scale, 0), glm::vec3(0, 0, -scale),
                         glm::vec3(0.2f, 0.1f, 1.0f) * size);  // faces down
        render.scene.SetScene(SceneOf({std::move(floor), std::move(lamp)},
                                      {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.3f), glm::vec3(2.0f))},
                                      {low, high}));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.1f)});
        const TraceSettings settings =
            LookAt(glm::vec3(0.5f, -3.0f, 2.0f) * size, glm::vec3(0.1f, 0.2f, 0.4f) * size, 0.6f, 24);
        return render.Render(settings, 16).mean.Mean().y;
    };
    const double expected = mean(1.0f, true);
    EXPECT_GT(expected, 0.2);
    for (const float size : {0x1p-40f, 0x1p-34f, 0x1p33f, 0x1p40f})
        for (const bool isOfVertices : {true, false})
            EXPECT_NEAR(mean(size, isOfVertices), expected, 1e-3 * expected)
                << size << (isOfVertices ? ", by vertices" : ", by scale");
}

TEST_F(TracePrecision, Trace_ShadowOfAThinBoxBeginsAtTheBox) {
    // A box of 10 cm, 1 mm high, on a floor; light comes over its edge at 45 degrees: a shadow of 1 mm
    const float height = 0.001f;
    for (const float x : {0.0f, 100.0f, 1000.0f, 10000.0f}) {
        scene::SceneData data =
            SceneOf({Block({1.0f, 0.5f, 1.0f}, {0, -0.5f, 0}), Block({0.05f, 0.5f * height, 0.05f})},
                    {Lambert(glm::vec3(0.8f))}, {Translation({x, 0, 0}), Translation({x, 0.5f * height, 0})});
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 1.0f;
        const float half = std::sqrt(0.5f);
        sun.lightToWorld =
            glm::mat4x3(glm::vec3(half, half, 0), glm::vec3(0, 0, 1), glm::vec3(-half, half, 0),
                        glm::vec3(0.0f));  // travels along (1, -1, 0)
        data.lights = {sun};
        render.scene.SetScene(std::move(data));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
        const auto darkAndLit = [&](float fromEdge) {  // shares of a square of 0.4 mm
            TraceSettings settings =
                LookAt({x + 0.05f + fromEdge, 1.0f, 0.0f}, {x + 0.05f + fromEdge, 0.0f, 0.0f}, 0.0004f, 8);
            settings.biases.maxDepth = 1;
            glm::dvec2 shares(0.0);
            const std::vector<glm::vec4> texels = render.Render(settings, 1).mean.values;
            for (const glm::vec4& texel : texels)
                shares[texel.y > 0.0f ? 1 : 0] += 1.0 / double(texels.size());
            return shares;
        };
        EXPECT_EQ(darkAndLit(0.0005f).x, 1.0) << x << " m: in the shadow";
        EXPECT_EQ(darkAndLit(0.0015f).y, 1.0) << x << " m: beyond it";
    }
}

}  // namespace raygraph::testing::trace_precision_test

// The radiance of each group of lights, as Trace separates it.
namespace raygraph::testing::trace_groups_test {

namespace {

constexpr uint32_t kRest = gpu::kLightGroupRest, kFirst = gpu::kLightGroupNamed;

class TraceGroups : public VulkanTest {
  protected:
    // One picture for each group, and last the radiance.
    std::vector<FloatImage> Trace(const passes::TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds scene = render.Declare();
        const passes::TraceIds traced =
            passes::Trace(render.renderer, scene, settings, {.lightGroups = true});
        const Readback radiance = render.renderer.ReadBack(traced.radiance);
        const Readback tiles = render.renderer.ReadBack(traced.lightGroups);
        render.renderer.Execute();
        const FloatImage all = ToFloatImage(tiles);
        const Extent2D across = passes::LightGroupTiles(scene.lightGroupCount), size = settings.extent;
        std::vector<FloatImage> pictures;
        for (uint32_t group = 0; group < scene.lightGroupCount; ++group) {
            FloatImage& picture = pictures.emplace_back(FloatImage{size, {}});
            for (uint32_t y = 0; y < size.height; ++y)
                for (uint32_t x = 0; x < size.width; ++x)
                    picture.values.push_back(all.At(group % across.width * size.width + x,
                                                    group / across.width * size.height + y));
        }
        pictures.push_back(ToFloatImage(radiance));
        return pictures;
    }
    // A floor, two lamps of different instances and materials over it, and a point light.
    passes::TraceSettings SetScene() {
        const glm::mat4x3 flat({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0});
        scene::SceneData data =
            SceneOf({QuadMesh(3.0f, 0), QuadMesh(0.3f, 1), QuadMesh(0.3f, 2)},
                    {Lambert(glm::vec3(0.6f)), Lambert({}, {4, 0, 0}), Lambert({}, {0, 4, 0})},
                    {flat, Translation({-1, 1, 0}), Translation({1, 1, 0})});
        data.lights = {{.color = {0, 0, 1}, .intensity = 2.0f, .lightToWorld = Translation({0, 2, 0})}};
        render.scene.SetScene(std::move(data));
        return LookAt({0, 1.2f, 4}, {0, 0.5f, 0}, 0.9f, 48);
    }
    SceneRender render{Device()};
};

}  // namespace

// Each triangle of a mesh that is one light is in a group of its own material's or its instance's.
TEST_F(TraceGroups, Trace_TrianglesOfAMeshThatIsPlacedOftenAreInTheirGroups) {
    scene::Mesh lamp = SphereMesh(0.2f, 16, 1);
    scene::Primitive green = lamp.primitives[0];
    scene::Primitive& red = lamp.primitives[0];
    const size_t half = red.indices.size() / 6 * 3;
    green.indices.erase(green.indices.begin(), green.indices.begin() + static_cast<std::ptrdiff_t>(half));
    green.material = 2;
    red.indices.resize(half);
    lamp.primitives.push_back(std::move(green));
    const glm::mat4x3 flat({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0});
    scene::SceneData data =
        SceneOf({QuadMesh(3.0f, 0), std::move(lamp)},
                {Lambert(glm::vec3(0.6f)), Lambert({}, {4, 0, 0}), Lambert({}, {0, 4, 0})},
                {flat, Translation({0, 1, 0})});
    for (int i = 1; i < 8; ++i)
        data.instances.push_back({.mesh = 1, .objectToWorld = Translation({0.5f * float(i - 4), 1, -1})});
    render.scene.SetScene(std::move(data));
    std::vector<uint32_t> ofInstances(9, kRest);
    ofInstances[1] = kFirst + 1;
    render.scene.SetLightGroups(
        {.namedCount = 3, .instances = ofInstances, .materials = {kRest, kFirst, kFirst + 2}});
    for (const bool isSampled : {true, false}) {
        passes::TraceSettings settings = LookAt({0, 1.2f, 4}, {0, 0.5f, 0}, 0.9f, 48);
        settings.lights.isOn = isSampled;
        const std::vector<FloatImage> pictures = Trace(settings);
        ASSERT_EQ(render.scene.Statistics().lightCount, 8u) << "a mesh is a light";
        const glm::dvec3 reds = pictures[kFirst].Mean(), lone = pictures[kFirst + 1].Mean(),
                         greens = pictures[kFirst + 2].Mean();
        EXPECT_TRUE(reds.x > 0.0 && reds.y == 0.0);
        EXPECT_TRUE(lone.x == 0.0 && lone.y > 0.0);
        EXPECT_TRUE(greens.x == 0.0 && greens.y > lone.y);
        EXPECT_EQ(pictures[kRest].Mean(), glm::dvec3(0.0));
    }
}

TEST_F(TraceGroups, Trace_EveryLightIsInItsGroupAloneAndTheyAreTheRadiance) {
    const passes::TraceSettings settings = SetScene();
    render.scene.SetEnvironment({.radiance = {0.1f, 0.1f, 0.1f}});
    render.scene.SetLightGroups({.namedCount = 3,
                                 .instances = {kRest, kFirst, kRest},
                                 .materials = {kRest, kFirst + 2, kFirst + 1},
                                 .lights = {kFirst + 2}});
    const std::vector<FloatImage> pictures = Trace(settings);
    ASSERT_EQ(pictures.size(), 6u);
    // Red: by its instance, which is in an earlier group than its material. Green: by its material
    const glm::dvec3 red = pictures[kFirst].Mean(), green = pictures[kFirst + 1].Mean(),
                     blue = pictures[kFirst + 2].Mean(), sky = pictures[gpu::kLightGroupEnvironment].Mean();
    EXPECT_TRUE(red.x > 0.0 && red.y == 0.0 && red.z == 0.0);
    EXPECT_TRUE(green.x == 0.0 && green.y > 0.0 && green.z == 0.0);
    EXPECT_TRUE(blue.x == 0.0 && blue.y == 0.0 && blue.z > 0.0);
    EXPECT_TRUE(sky.x > 0.0 && sky.x == sky.y && sky.y == sky.z);
    EXPECT_EQ(pictures[kRest].Mean(), glm::dvec3(0.0));
    for (size_t i = 0; i < pictures[0].values.size(); ++i) {
        glm::dvec4 sum(0.0);
        for (size_t group = 0; group < 5; ++group) sum += glm::dvec4(pictures[group].values[i]);
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(sum[c], pictures[5].values[i][c], 1e-5 * std::max(1e-3, sum[c])) << i;
    }
    const FloatImage alone = render.TraceOnce(settings);
    EXPECT_EQ(
        std::memcmp(alone.values.data(), pictures[5].values.data(), alone.values.size() * sizeof(glm::vec4)),
        0);
}

TEST_F(TraceGroups, Trace_WhatEmitsAndIsNoLightIsInRest) {
    const passes::TraceSettings settings = SetScene();
    render.scene.SetLightGroups({.namedCount = 1, .instances = {kFirst, kFirst, kFirst}, .lights = {kFirst}});
    render.scene.SetMaterial(0, Lambert(glm::vec3(0.6f), glm::vec3(1.0f)));  // dark when the scene was set
    const std::vector<FloatImage> pictures = Trace(settings);
    EXPECT_GT(pictures[kRest].Mean().x, 0.1);
    EXPECT_GT(pictures[kFirst].Mean().x, 0.0);
}

TEST_F(TraceGroups, SetLightGroups_RefusesWhatDoesNotFitTheScene) {
    SetScene();
    const auto refuses = [&](LightGroups groups) {
        EXPECT_THROW(render.scene.SetLightGroups(std::move(groups)), Error);
    };
    refuses({.namedCount = 9});
    refuses({.namedCount = 1, .instances = {kFirst}});
    refuses({.namedCount = 1, .materials = {kRest, kRest, kFirst + 1}});
    refuses({.namedCount = 1, .lights = {gpu::kLightGroupEnvironment}});
    render.scene.SetLightGroups({.namedCount = 1, .lights = {kFirst}});
    SetScene();
    render.renderer.BeginFrame();
    EXPECT_EQ(render.scene.Declare(render.renderer).lightGroupCount, kFirst);  // none is left
}

}  // namespace raygraph::testing::trace_groups_test

// The parts into which Trace separates the radiance.
namespace raygraph::testing::trace_parts_test {

using passes::kPathPartCount;
using passes::PathPart;
using passes::PathPartIds;
using passes::TraceSettings;

namespace {

struct SplitImage {
    FloatImage radiance;
    std::array<FloatImage, kPathPartCount> parts, variances;
    uint32_t sampleCount = 0;

    const FloatImage& operator[](PathPart part) const { return parts[static_cast<size_t>(part)]; }
    glm::dvec3 Mean(PathPart part) const { return (*this)[part].Mean(); }
    glm::dvec3 StandardErrorOfMean(PathPart part) const {
        const size_t i = static_cast<size_t>(part);
        return RenderedImage{parts[i], variances[i], sampleCount}.StandardErrorOfMean();
    }
};

class TraceParts : public VulkanTest {
  protected:
    // One sample, or the mean of several.
    SplitImage Split(TraceSettings settings, uint32_t sampleCount = 1) {
        passes::Accumulation sum("whole");
        std::vector<passes::Accumulation> sums;
        for (size_t i = 0; i < kPathPartCount; ++i) sums.emplace_back("part" + std::to_string(i));
        SplitImage image;
        for (const uint32_t end = settings.sampleIndex + sampleCount; settings.sampleIndex < end;
             settings.sampleIndex += settings.sampleCount) {
            settings.sampleCount = SamplesOfAFrame(settings, end - settings.sampleIndex);
            const passes::SampleRows rows{settings.sampleCount, settings.extent.height};
            Renderer& renderer = render.renderer;
            renderer.BeginFrame();
            const SceneIds scene = render.Declare();
            const passes::TraceIds traced = passes::Trace(renderer, scene, settings, {.parts = true});
            const bool isLast = settings.sampleIndex + settings.sampleCount == end;
            Readback whole;
            std::vector<Readback> means, variances;
            const auto take = [&](TextureId texture) {
                if (isLast) return renderer.ReadBack(texture);
                renderer.Present(texture);
                return Readback();
            };
            whole = take(passes::Accumulate(renderer, traced.radiance, rows, sum).mean);
            for (size_t i = 0; i < kPathPartCount; ++i) {
                std::ignore = passes::Accumulate(renderer, traced.parts[i], rows, sums[i], true);
                const passes::AccumulatedIds resolved =
                    passes::Resolve(renderer, sums[i], settings.extent, true);
                means.push_back(take(resolved.mean));
                variances.push_back(take(resolved.variance));
            }
            renderer.Execute();
            if (!isLast) continue;
            image.radiance = ToFloatImage(whole);
            image.sampleCount = sampleCount;
            for (size_t i = 0; i < kPathPartCount; ++i) {
                image.parts[i] = ToFloatImage(means[i]);
                image.variances[i] = ToFloatImage(variances[i]);
            }
        }
        return image;
    }

    // A floor, as glossy as varnish, under a lamp, with a thin pane of tinted glass that stands on it; and by
    // themselves, 20 m off on either side: a mirror, a rough metal, and a clear pane before a wall that
    // shines.
    TraceSettings SetScene() {
        scene::Material floor = Lambert({0.7f, 0.4f, 0.2f});
        floor.metallicFactor = 0.0f;
        floor.roughnessFactor = 0.3f;
        scene::Material lamp = Lambert(glm::vec3(0.0f), {9.0f, 8.0f, 6.0f});
        lamp.metallicFactor = 0.0f;
        lamp.specularFactor = 0.0f;
        scene::Material pane = floor;
        pane.transmissionFactor = 0.8f;
        pane.roughnessFactor = 0.2f;
        pane.baseColorFactor = {0.6f, 0.9f, 0.7f, 1.0f};
        scene::Material mirror = Lambert(glm::vec3(0.9f)), metal = mirror;
        mirror.roughnessFactor = 0.0f;
        metal.roughnessFactor = 0.5f;
        scene::Material clear = floor;
        clear.transmissionFactor = 1.0f;
        clear.roughnessFactor = 0.0f;
        clear.baseColorFactor = glm::vec4(1.0f);
        const glm::mat4x3 flat({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0});
        const glm::mat4x3 above({1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {0, 2, -1});
        render.scene.SetScene(
            SceneOf({QuadMesh(3.0f, 0), QuadMesh(0.5f, 1), QuadMesh(0.6f, 2), QuadMesh(1.0f, 3),
                     QuadMesh(1.0f, 4), QuadMesh(1.0f, 5), QuadMesh(1.0f, 1)},
                    {floor, lamp, pane, mirror, metal, clear},
                    {flat, above, Translation({0.5f, 0.6f, 0.6f}), Translation({-20, 0, 0}),
                     Translation({-20, 20, 0}), Translation({20, 0, 0}), Translation({20, 0, -1})}));
        render.scene.SetEnvironment({.radiance = {0.05f, 0.1f, 0.2f}});
        return View({0, 1.2f, 4}, {0, 1.0f, 0}, 0.9f, 64);
    }
    static TraceSettings View(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size) {
        TraceSettings settings = LookAt(eye, target, yFov, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

const std::vector<PathPart> kScatteredParts = {PathPart::Direct, PathPart::Indirect, PathPart::Diffuse,
                                               PathPart::Specular, PathPart::Transmission};

void ExpectNothingIn(const SplitImage& image, const std::vector<PathPart>& parts) {
    for (const PathPart part : parts) EXPECT_EQ(image.Mean(part), glm::dvec3(0.0)) << Name(part);
}

// Expects that this part is all of the radiance.
void ExpectAllIn(const SplitImage& image, PathPart part) {
    ASSERT_GT(image.radiance.Mean().y, 0.0);
    for (size_t i = 0; i < image.radiance.values.size(); ++i)
        ASSERT_EQ(glm::vec3(image[part].values[i]), glm::vec3(image.radiance.values[i])) << Name(part);
}

void ExpectSumsAreTheRadiance(const SplitImage& image) {
    for (size_t i = 0; i < image.radiance.values.size(); ++i)
        for (int channel = 0; channel < 3; ++channel) {
            const auto at = [&](PathPart part) { return double{image[part].values[i][channel]}; };
            const double radiance = image.radiance.values[i][channel];
            const double tolerance = 1e-5 * radiance;
            ASSERT_NEAR(at(PathPart::Emission) + at(PathPart::Direct) + at(PathPart::Indirect), radiance,
                        tolerance)
                << "pixel " << i;
            ASSERT_NEAR(at(PathPart::Emission) + at(PathPart::Diffuse) + at(PathPart::Specular) +
                            at(PathPart::Transmission),
                        radiance, tolerance)
                << "pixel " << i;
        }
}

}  // namespace

TEST_F(TraceParts, Trace_PartsSumToTheRadianceOfEveryPixel) {
    const TraceSettings settings = SetScene();
    for (const uint32_t sampleCount : {1u, 16u}) {
        const SplitImage image = Split(settings, sampleCount);
        ExpectSumsAreTheRadiance(image);
        EXPECT_GT(image.Mean(PathPart::Emission).y, 0.0);
        for (const PathPart part : kScatteredParts)
            EXPECT_GT(image.Mean(part).y, 0.005 * image.radiance.Mean().y) << Name(part) << " is not tried";
    }
}

TEST_F(TraceParts, Trace_TellingPartsApartLeavesTheRadiance) {
    const TraceSettings settings = SetScene();
    const SplitImage image = Split(settings);
    const FloatImage alone = render.TraceOnce(settings);
    ASSERT_EQ(alone.values.size(), image.radiance.values.size());
    // Other drivers may compile the longer shader with other roundings; few of them decide where a path goes.
    const bool isExact = Device().Info().isLavapipe;
    size_t same = 0;
    for (size_t i = 0; i < alone.values.size(); ++i) {
        const glm::vec4 difference = glm::abs(alone.values[i] - image.radiance.values[i]);
        const glm::vec4 limit = isExact ? glm::vec4(0.0f) : 1e-5f * glm::abs(alone.values[i]) + 1e-7f;
        same += glm::all(glm::lessThanEqual(difference, limit));
    }
    const size_t wanted = isExact ? alone.values.size() : alone.values.size() * 99 / 100;
    EXPECT_GE(same, wanted) << "of " << alone.values.size();
}

TEST_F(TraceParts, Trace_PartsDoNotDependOnHowLightIsFound) {
    // Lamps sampled or met by chance: each part converges to the same
    TraceSettings settings = SetScene();
    const SplitImage sampled = Split(settings, 32);
    settings.seed = 1;
    settings.lights.isOn = false;
    const SplitImage met = Split(settings, 256);
    for (const PathPart part : kScatteredParts) {
        const glm::dvec3 a = sampled.Mean(part), b = met.Mean(part);
        const double error = std::hypot(sampled.StandardErrorOfMean(part).y, met.StandardErrorOfMean(part).y);
        EXPECT_NEAR(a.y, b.y, 4.0 * error) << Name(part);
        EXPECT_LT(4.0 * error, 0.2 * b.y) << Name(part) << " is too noisy to prove anything";
    }
}

TEST_F(TraceParts, Trace_LampSeenDirectlyIsAllEmission) {
    SetScene();
    const SplitImage image = Split(View({0, 1, -1}, {0.01f, 2, -1}, 0.5f, 8));
    ExpectAllIn(image, PathPart::Emission);
    EXPECT_EQ(image.radiance.Mean(), glm::dvec3(9, 8, 6));
    ExpectNothingIn(image, kScatteredParts);
}

TEST_F(TraceParts, Trace_MetalIsAllSpecularSmoothOrRough) {
    SetScene();
    for (const float y : {0.0f, 20.0f}) {
        const SplitImage image = Split(View({-20, y, 2}, {-20, y, 0}, 0.5f, 16));
        ExpectAllIn(image, PathPart::Specular);
        ExpectNothingIn(image, {PathPart::Emission, PathPart::Diffuse, PathPart::Transmission});
    }
}

TEST_F(TraceParts, Trace_LampBehindAClearPaneIsEmissionThatIsNotScattered) {
    SetScene();
    const SplitImage image = Split(View({20, 0, 2}, {20, 0, 0}, 0.1f, 16), 64);
    // Fresnel at normal incidence: 0.04 of the environment before it, 0.96 of the lamp behind
    EXPECT_NEAR(image.Mean(PathPart::Emission).y, 0.96 * 8.0, 0.01 * 8.0);
    EXPECT_NEAR(image.Mean(PathPart::Specular).y, 0.04 * 0.1, 0.05 * 0.04);
    EXPECT_NEAR(image.Mean(PathPart::Direct).y, image.Mean(PathPart::Specular).y, 1e-5);
    ExpectNothingIn(image, {PathPart::Transmission, PathPart::Indirect, PathPart::Diffuse});
}

TEST_F(TraceParts, Trace_LambertWallUnderAPointLightIsAllDirectAndDiffuse) {
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert({0.8f, 0.5f, 0.2f})});
    scene::Light light;
    light.intensity = 5.0f;
    light.lightToWorld = Translation({0, 0, 1});
    scene.lights = {light};
    render.scene.SetScene(std::move(scene));
    const SplitImage image = Split(LookAt({0, 0, 2}, {0, 0, 0}, 0.5f, 16));
    ExpectAllIn(image, PathPart::Direct);
    ExpectAllIn(image, PathPart::Diffuse);
    ExpectNothingIn(image,
                    {PathPart::Emission, PathPart::Indirect, PathPart::Specular, PathPart::Transmission});
}

TEST_F(TraceParts, Trace_RefusesRayCountsBesideParts) {
    render.renderer.BeginFrame();
    const SceneIds ids = render.scene.Declare(render.renderer);
    EXPECT_THROW(std::ignore = passes::Trace(render.renderer, ids, LookAt({0, 0, 1}, {0, 0, 0}, 1.0f, 4),
                                             {.rayCounts = true, .parts = true}),
                 Error);
    render.renderer.Execute();
}

}  // namespace raygraph::testing::trace_parts_test
