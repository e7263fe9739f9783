// Tests views that show no light: values of surfaces, counts, and how they are painted.
#include <cmath>
#include <cstring>

#include "core/ramp.glsl"
#include "passes/raster.h"
#include "passes/shadow_maps.h"
#include "passes/views.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/graph/readback_values.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::views_test {

using passes::FilmPosition;
using passes::TraceSettings;
using passes::View;

namespace {

class SurfaceViews : public VulkanTest {
  protected:
    FloatImage Take(const std::function<TextureId(const SceneIds&)>& declare) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback readback = render.renderer.ReadBack(declare(ids));
        render.renderer.Execute();
        return ToFloatImage(readback);
    }
    // Returns the view of drawn surfaces, or of those that rays find.
    FloatImage Values(const TraceSettings& settings, View view, bool isTraced = false) {
        return Take([&](const SceneIds& ids) {
            const passes::RasterVisibility seen =
                isTraced ? passes::TraceVisibility(render.renderer, ids, settings, FilmPosition::Center)
                         : passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center);
            return passes::SurfaceView(render.renderer, ids, settings, seen, view);
        });
    }
    SceneRender render{Device()};
};

class PaintedViews : public VulkanTest {
  protected:
    // Paints a pixel for each four values; bytes are in [0, 1].
    Texels Paint(View view, const std::vector<float>& values) {
        return harness.Run([&](PassHarness& h) {
            return passes::PaintView(
                h.Graph(), h.Texture("values", {uint32_t(values.size() / 4), 1}, Format::Rgba32Float, values),
                view);
        });
    }
    static glm::vec3 Rgb(const Texels& shown, uint32_t x) {
        EXPECT_EQ(shown.At(x, 0)[3], 1.0f);
        return {shown.At(x, 0)[0], shown.At(x, 0)[1], shown.At(x, 0)[2]};
    }
    // Display values are stored as codes of 8 bits, and Vulkan lets a device take either of the two nearest
    // ("Conversion From Floating-Point to Normalized Fixed-Point").
    static void ExpectNear(const glm::vec3& a, const glm::vec3& b) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1.0f / 255.0f + 1e-4f);
    }
    PassHarness harness{Device()};
};

}  // namespace

TEST(ViewNames, EachViewHasANameOfItsOwn) {
    EXPECT_STREQ(passes::Name(View::PathTraced), "path-traced");
    EXPECT_STREQ(passes::Name(View::RayCost), "ray-cost");
    for (size_t i = 0; i < passes::kViewCount; ++i)
        for (size_t j = 0; j < i; ++j)
            EXPECT_STRNE(passes::Name(static_cast<View>(i)), passes::Name(static_cast<View>(j)));
}

TEST_F(SurfaceViews, ShowWhatTheMaterialSays) {
    scene::Material material;
    material.baseColorFactor = {0.25f, 0.5f, 0.75f, 1.0f};
    material.roughnessFactor = 0.35f;
    material.metallicFactor = 0.6f;
    material.emissiveFactor = {1.0f, 0.5f, 0.25f};
    material.emissiveStrength = 4.0f;
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 1), QuadMesh(0.2f, 0)}, {Lambert({1, 0, 0}), material},
                                  {Translation({0, 0, 0}), Translation({0.7f, 0, 1})}));
    const TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.8f, 32);
    const std::pair<View, glm::vec3> kExpected[] = {
        {View::Albedo, {0.25f, 0.5f, 0.75f}}, {View::Normals, {0, 0, 1}},
        {View::Roughness, glm::vec3(0.35f)},  {View::Metallic, glm::vec3(0.6f)},
        {View::Emissive, {4, 2, 1}},          {View::Depth, glm::vec3(4)},
        {View::Instance, glm::vec3(0)},       {View::Material, glm::vec3(1)}};
    for (const auto& [view, value] : kExpected) {
        SCOPED_TRACE(passes::Name(view));
        const FloatImage values = Values(settings, view);
        EXPECT_LT(glm::distance(values.At(12, 16), glm::vec4(value, 1.0f)), 1e-4f);
        EXPECT_EQ(values.At(0, 0), glm::vec4(0.0f)) << "nothing is there";
    }
    EXPECT_NEAR(Values(settings, View::Depth).At(25, 16).x, 3.0f, 1e-4f);
    EXPECT_EQ(Values(settings, View::Instance).At(25, 16).x, 1.0f);
    EXPECT_THROW(Values(settings, View::PathTraced), Error);
}

TEST_F(SurfaceViews, APartByRaysHasTheBitsOfTheWholeAndDrawingRefusesIt) {
    render.scene.SetScene(SceneOf({SphereMesh(0.5f, 12), BoxMesh(0.4f)}, {Lambert({0.5f, 0.4f, 0.3f})},
                                  {Translation({-0.5f, 0, 0}), Translation({0.5f, 0.2f, -1})}));
    const TraceSettings whole = LookAt({0.3f, 0.4f, 4}, {0, 0, 0}, 0.6f, 64);
    TraceSettings part = whole;
    part.region = {19, 23, 21, 17};
    for (const View view : {View::Normals, View::Depth, View::Wireframe}) {
        const FloatImage all = Values(whole, view, true), some = Values(part, view, true);
        ASSERT_TRUE(some.extent == (rhi::Extent2D{21, 17}));
        uint32_t surfaces = 0;
        for (uint32_t y = 0; y < 17; ++y)
            for (uint32_t x = 0; x < 21; ++x) {
                EXPECT_EQ(some.At(x, y), all.At(19 + x, 23 + y)) << passes::Name(view) << x << " " << y;
                surfaces += some.At(x, y).w > 0.0f;
            }
        EXPECT_GT(surfaces, 50u);
    }
    EXPECT_THROW(Values(part, View::Depth), Error);
}

TEST_F(SurfaceViews, AreTheSameOfDrawnAndOfTracedHits) {
    render.scene.SetScene(SceneOf({SphereMesh(0.5f, 12), BoxMesh(0.4f)}, {Lambert({0.5f, 0.4f, 0.3f})},
                                  {Translation({-0.5f, 0, 0}), Translation({0.5f, 0.2f, -1})}));
    const TraceSettings settings = LookAt({0.3f, 0.4f, 4}, {0, 0, 0}, 0.6f, 64);
    for (const View view : {View::Normals, View::Depth, View::Instance, View::Wireframe}) {
        const FloatImage drawn = Values(settings, view), traced = Values(settings, view, true);
        uint32_t different = 0, surfaces = 0;
        for (size_t i = 0; i < drawn.values.size(); ++i) {
            surfaces += traced.values[i].w > 0.0f;
            different += glm::distance(drawn.values[i], traced.values[i]) > 0.02f;
        }
        EXPECT_GT(surfaces, 500u);
        EXPECT_LE(different, 20u) << passes::Name(view);  // at edges
    }
}

TEST_F(SurfaceViews, WireframeIsOnTheEdgesOfTriangles) {
    render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))}));
    const FloatImage values = Values(LookAt({0, 0, 4}, {0, 0, 0}, 0.6f, 65), View::Wireframe);
    float diagonal[2] = {};
    for (uint32_t i = 12; i < 53; ++i) {  // in the quad, off its sides
        diagonal[0] = std::max(diagonal[0], values.At(i, i).x);
        diagonal[1] = std::max(diagonal[1], values.At(i, 64 - i).x);
    }
    EXPECT_GT(std::max(diagonal[0], diagonal[1]), 0.9f) << "the edge that halves it";
    EXPECT_EQ(values.At(32, 20).x, 0.0f);
    EXPECT_EQ(values.At(20, 32).x, 0.0f);
    EXPECT_NEAR(values.At(32, 20).y, 1.0f, 0.05f) << "seen face on";
}

TEST_F(SurfaceViews, OverdrawCountsWhatIsHiddenToo) {
    scene::Material mask = Lambert(glm::vec3(0.5f));
    mask.alphaMode = scene::AlphaMode::Mask;
    mask.baseColorFactor.a = 0.1f;
    render.scene.SetScene(SceneOf({QuadMesh(1.0f), QuadMesh(1.0f), QuadMesh(0.5f), QuadMesh(1.0f, 1)},
                                  {Lambert(glm::vec3(0.5f)), mask},
                                  {Translation({0, 0, 0}), Translation({0, 0, -0.1f}),
                                   Translation({0, 0, 0.1f}), Translation({0, 0, 0.2f})}));
    const TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.8f, 32);
    const FloatImage counts = Take([&](const SceneIds& ids) {
        return passes::Overdraw(render.renderer, ids, settings, FilmPosition::Center);
    });
    EXPECT_EQ(counts.At(14, 17), glm::vec4(3, 3, 3, 1));
    EXPECT_EQ(counts.At(9, 17), glm::vec4(2, 2, 2, 1));
    EXPECT_EQ(counts.At(0, 0), glm::vec4(0, 0, 0, 1));
}

TEST_F(PaintedViews, CountsAreSpreadOverTheChannels) {
    const Texels values = harness.Run([&](PassHarness& h) {
        return passes::SpreadCounts(h.Graph(), h.Texture("counts", {2, 1}, Format::R32Float, {7, 2049}));
    });
    for (uint32_t c = 0; c < 3; ++c) {
        EXPECT_EQ(values.At(0, 0)[c], 7.0f);
        EXPECT_EQ(values.At(1, 0)[c], 2049.0f);
    }
    EXPECT_EQ(values.At(1, 0)[3], 1.0f);
}

TEST_F(PaintedViews, NormalsMapMinusOneToOneOntoZeroToOne) {
    const Texels shown = Paint(View::Normals, {0, 0, 1, 1, -1, 0, 0, 1, 0, 0, 0, 0, 0, 0.5f, 0, 0.5f});
    ExpectNear(Rgb(shown, 0), {0.5f, 0.5f, 1.0f});
    ExpectNear(Rgb(shown, 1), {0.0f, 0.5f, 0.5f});
    ExpectNear(Rgb(shown, 2), {0, 0, 0});
    ExpectNear(Rgb(shown, 3), {0.25f, 0.5f, 0.25f});  // half of the pixel is covered
}

TEST_F(PaintedViews, ColorsAreSrgbEncodedAndFactorsAreNot) {
    ExpectNear(Rgb(Paint(View::Albedo, {0.21404114f, 0, 1, 1}), 0), {0.5f, 0, 1});
    ExpectNear(Rgb(Paint(View::Emissive, {5, 0.21404114f, 0, 1}), 0), {1, 0.5f, 0});
    ExpectNear(Rgb(Paint(View::Roughness, {0.3f, 0.3f, 0.3f, 1}), 0), glm::vec3(0.3f));
}

TEST_F(PaintedViews, NearIsBrighterThanFarAndAMissIsBlack) {
    const Texels shown = Paint(View::Depth, {2, 2, 2, 1, 4, 4, 4, 1, 0, 0, 0, 0, 3, 3, 3, 1});
    const float nearest = Rgb(shown, 0).x, farthest = Rgb(shown, 1).x;
    EXPECT_EQ(nearest, 1.0f);
    EXPECT_GT(farthest, 0.1f);
    EXPECT_NEAR(Rgb(shown, 3).x, 0.5f * (nearest + farthest), 1.0f / 255.0f);
    ExpectNear(Rgb(shown, 2), {0, 0, 0});
}

TEST_F(PaintedViews, EachIdHasAColorOfItsOwn) {
    std::vector<float> ids;
    for (int i = 0; i < 8; ++i) ids.insert(ids.end(), {float(i), float(i), float(i), 1.0f});
    const Texels shown = Paint(View::Instance, ids);
    for (uint32_t i = 0; i < 8; ++i)
        for (uint32_t j = 0; j < i; ++j) {
            const glm::vec3 difference = glm::abs(Rgb(shown, i) - Rgb(shown, j));
            EXPECT_GT(difference.x + difference.y + difference.z, 40.0f / 255.0f) << i << " and " << j;
        }
}

TEST_F(PaintedViews, HeatMapsAreTheRampOfTheLogarithm) {
    const Texels rays = Paint(View::RayCost, {0, 0, 0, 1, 31, 31, 31, 1, 1023, 0, 0, 1, 9999, 0, 0, 1});
    const float steps[] = {0.0f, 0.5f, 1.0f, 1.0f};
    for (uint32_t i = 0; i < 4; ++i)
        ExpectNear(Rgb(rays, i), shading::SrgbEncode(shading::HeatColor(steps[i])));
    for (const View view : {View::Overdraw, View::PathLength})
        ExpectNear(Rgb(Paint(view, {31, 0, 0, 1}), 0), shading::SrgbEncode(shading::HeatColor(1.0f)));
    EXPECT_THROW(Paint(View::Raster, {0, 0, 0, 1}), Error);
}

TEST(HeatColor, GrowsEvenlyLighterAndStaysWithinTheScreensColors) {
    // CIE L* of its luminance rises all along; OKLab's lightness is what the ramp is made of
    float last = -1.0f;
    for (int i = 0; i <= 100; ++i) {
        const float t = float(i) / 100.0f;
        const shading::vec3 color = shading::HeatColor(t);
        const float luminance = shading::Luminance(color);
        EXPECT_GT(luminance, last);
        last = luminance;
        for (int c = 0; c < 3; ++c) {
            EXPECT_GT(color[c], 0.0f) << "cut at " << t;
            EXPECT_LT(color[c], 1.0f) << "cut at " << t;
        }
    }
    EXPECT_LT(shading::Luminance(shading::HeatColor(0.0f)), 0.01f);
    EXPECT_GT(last, 0.75f);
}

}  // namespace raygraph::testing::views_test

// Tests that a hidden object is in no view, and casts no shadow: pictures have the bits of a scene that never
// showed it, after an update of the TLAS.
namespace raygraph::testing::hidden_test {

using passes::FilmPosition;
using passes::Rasterizer;
using passes::RasterShadows;

namespace {

constexpr uint32_t kSize = 48;
constexpr uint32_t kFloor = 0;

struct Seen {
    std::vector<std::vector<glm::vec4>> pictures;
    std::vector<std::vector<glm::uvec4>> ids;
    std::vector<gpu::InstanceRecord> records;
};

class Hidden : public VulkanTest {
  protected:
    // Makes a floor under the sun, and on it a box, a ball, a lamp and a leaf with holes.
    static scene::SceneData Table(uint32_t hidden = scene::kNone) {
        scene::Material leaf = Lambert(glm::vec3(0.7f));
        leaf.alphaMode = scene::AlphaMode::Mask;
        scene::Mesh holed = QuadMesh(0.5f, 2);
        holed.primitives[0].colors.assign(4, glm::vec4(1.0f));
        holed.primitives[0].colors[2].a = 0.0f;
        scene::SceneData scene =
            SceneOf({QuadMesh(3.0f), BoxMesh(0.4f), RoundSphere(0.4f), holed, QuadMesh(0.2f, 1)},
                    {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.2f), glm::vec3(6.0f)), leaf},
                    {Translation({0, 0, 0}), Translation({-1, -1, 0.6f}), Translation({1, -1, 0.6f}),
                     Translation({-1, 1, 0.7f}), Translation({1, 1, 0.8f})});
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.lightToWorld = glm::mat4x3(glm::vec3(1, 0, 0), glm::vec3(0, 0.8f, 0.6f),
                                       glm::vec3(0, -0.6f, 0.8f), glm::vec3(0));
        scene.lights = {sun};
        if (hidden == scene::kNone) return scene;
        scene.nodes.resize(1);
        scene.nodes[0].isVisible = false;
        scene.nodeOrder = {0};
        scene.instances[hidden].node = 0;
        return scene;
    }

    static Seen Look(SceneRender& render) {
        passes::TraceSettings settings = LookAt({0.3f, -0.4f, 7.0f}, {0, 0, 0}, 0.8f, kSize);
        settings.biases.maxDepth = 2;
        Seen seen;
        const auto add = [&](const SceneRender::Hits& hits) {
            seen.ids.push_back(hits.ids);
            seen.pictures.push_back(hits.normal.values);
        };
        add(render.PrimaryHits(settings));
        seen.pictures.push_back(render.TraceOnce(settings).values);
        for (const Rasterizer rasterizer : {Rasterizer::Compute, Rasterizer::Device}) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            add(render.ReadHits(passes::RasterHits(
                render.renderer, ids, settings,
                passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center, rasterizer))));
        }
        for (const RasterShadows shadows : {RasterShadows::Rays, RasterShadows::Maps}) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            passes::FilteredEnvironment environment("environment");
            const Readback shaded = render.renderer.ReadBack(passes::RasterShade(
                render.renderer, ids, settings,
                passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center), environment,
                {.shadows = shadows, .hasOcclusion = false, .hasTransmission = false}));
            const Readback records = render.renderer.ReadBack(ids.instances);
            render.renderer.Execute();
            seen.pictures.push_back(ToFloatImage(shaded).values);
            seen.records = WaitForValues<gpu::InstanceRecord>(records);
        }
        return seen;
    }

    static void ExpectSame(const Seen& actual, const Seen& expected) {
        EXPECT_EQ(actual.ids, expected.ids);
        for (size_t i = 0; i < expected.pictures.size(); ++i)
            EXPECT_EQ(std::memcmp(actual.pictures[i].data(), expected.pictures[i].data(),
                                  expected.pictures[i].size() * sizeof(glm::vec4)),
                      0)
                << "picture " << i;
        for (size_t i = 0; i < expected.records.size(); ++i) {
            EXPECT_EQ(actual.records.at(i).draw, expected.records[i].draw) << i;
            EXPECT_EQ(actual.records[i].objectToWorld, expected.records[i].objectToWorld) << i;
        }
    }

    static void Settle(SceneRender& render) {
        for (int frame = 0; frame < 8 && !render.scene.IsSettled(); ++frame)
            render.PrimaryHits(LookAt({0, 0, 7}, {0, 0, 0}, 0.8f, 1));
        ASSERT_TRUE(render.scene.IsSettled());
    }

    SceneRender edited{Device()}, expected{Device()};
};

}  // namespace

TEST_F(Hidden, IsInNoViewAndCastsNoShadow) {
    edited.scene.SetScene(Table());
    Settle(edited);
    const Seen all = Look(edited);
    const uint64_t rebuilds = edited.scene.Statistics().tlasRebuilds;
    for (uint32_t instance = 0; instance < 5; ++instance) {
        SCOPED_TRACE(instance);
        edited.scene.SetVisible(instance, false);
        const Seen hidden = Look(edited);
        expected.scene.SetScene(Table(instance));
        Settle(expected);
        ExpectSame(hidden, Look(expected));
        for (const std::vector<glm::uvec4>& ids : hidden.ids)
            for (const glm::uvec4& id : ids) ASSERT_NE(id.x, instance);
        for (size_t i = 0; i < all.ids.size(); ++i) EXPECT_NE(hidden.ids[i], all.ids[i]) << "it was seen";
        // Objects that were hidden when the scene was set can be shown
        expected.scene.SetVisible(instance, true);
        const uint64_t before = expected.scene.Statistics().tlasRebuilds;
        ExpectSame(Look(expected), all);
        EXPECT_EQ(expected.scene.Statistics().tlasRebuilds, before);
        edited.scene.SetVisible(instance, true);
    }
    ExpectSame(Look(edited), all);
    EXPECT_EQ(edited.scene.Statistics().tlasRebuilds, rebuilds) << "updates only";
}

// The camera sees the floor alone, so that only shadows and light differ.
TEST_F(Hidden, ShadowsOfWhatIsHiddenAreGone) {
    edited.scene.SetScene(Table());
    const passes::TraceSettings settings = LookAt({0.3f, -0.4f, 7.0f}, {0, 0, 0}, 0.8f, kSize);
    const auto lit = [&] {
        const SceneRender::Hits hits = edited.PrimaryHits(settings);
        const FloatImage image = edited.Render(settings, 4).mean;
        double sum = 0.0;
        for (size_t i = 0; i < hits.ids.size(); ++i)
            if (hits.ids[i].x == kFloor) sum += image.values[i].y > 0.1f ? 1.0 : 0.0;
        return sum;
    };
    edited.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    edited.scene.SetVisible(4, false);  // the lamp
    double before = lit();
    for (const uint32_t instance : {1u, 2u, 3u}) {
        edited.scene.SetVisible(instance, false);
        const double now = lit();
        EXPECT_GT(now, before + 10.0) << instance;
        before = now;
    }
}

}  // namespace raygraph::testing::hidden_test
