// Tests shadows of the raster view: rays give those of the path tracer, maps the same except near edges.
#include <cmath>

#include "passes/raster.h"
#include "passes/shadow_maps.h"
#include "shaders/shared/shadow_records.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_shadow_test {

using passes::FilmPosition;
using passes::RasterShadows;
using passes::TraceSettings;

namespace {

class RasterShadow : public VulkanTest {
  protected:
    FloatImage Draw(TraceSettings settings, RasterShadows shadows, uint32_t samples = 1) {
        const FilmPosition film = samples > 1 ? FilmPosition::Jittered : FilmPosition::Center;
        passes::Accumulation accumulation("drawn");
        for (uint32_t i = 0;; ++i) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            const passes::RasterVisibility seen =
                passes::DrawVisibility(render.renderer, ids, settings, film);
            const TextureId radiance =
                passes::RasterShade(render.renderer, ids, settings, seen, environment,
                                    {.shadows = shadows, .hasOcclusion = false, .hasTransmission = false});
            const Readback mean =
                render.renderer.ReadBack(passes::Accumulate(render.renderer, radiance, accumulation).mean);
            render.renderer.Execute();
            ++settings.sampleIndex;
            if (i + 1 == samples) return ToFloatImage(mean);
        }
    }

    // Returns whether light arrives at, or is seen in, another pixel of the square of this size around a
    // pixel.
    static bool IsNearEdge(const FloatImage& image, uint32_t x, uint32_t y, uint32_t reach) {
        const glm::vec4& here = image.At(x, y);
        for (uint32_t j = y < reach ? 0 : y - reach; j <= std::min(y + reach, image.extent.height - 1); ++j)
            for (uint32_t i = x < reach ? 0 : x - reach; i <= std::min(x + reach, image.extent.width - 1);
                 ++i)
                if (std::abs(image.At(i, j).y - here.y) > 0.15f * std::max(image.At(i, j).y, here.y))
                    return true;
        return false;
    }

    struct Difference {
        double share = 0.0;     // fraction of pixels that differ by more than the tolerance
        double offEdges = 0.0;  // fraction of pixels that differ and are near no edge
        double shadowed = 0.0;  // fraction of pixels of `b` that are black
    };
    static Difference Compare(const FloatImage& a, const FloatImage& b, float tolerance, uint32_t reach) {
        const double brightest = b.Mean().y;
        Difference difference;
        for (uint32_t y = 0; y < b.extent.height; ++y)
            for (uint32_t x = 0; x < b.extent.width; ++x) {
                bool isSame = true;
                for (int c = 0; c < 3; ++c)
                    isSame = isSame && std::abs(a.At(x, y)[c] - b.At(x, y)[c]) <=
                                           tolerance * b.At(x, y)[c] + 1e-3 * brightest;
                difference.shadowed += b.At(x, y).w > 0.0f && b.At(x, y).y == 0.0f;
                if (isSame) continue;
                difference.share += 1.0;
                difference.offEdges += !IsNearEdge(b, x, y, reach);
            }
        const double pixels = double(b.extent.width) * b.extent.height;
        return {difference.share / pixels, difference.offEdges / pixels, difference.shadowed / pixels};
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

scene::Light Punctual(scene::LightType type, float intensity, const glm::mat4x3& lightToWorld) {
    scene::Light light;
    light.type = type;
    light.color = {1.0f, 0.9f, 0.8f};
    light.intensity = intensity;
    light.lightToWorld = lightToWorld;
    return light;
}

// Places an object at `eye` with its -z towards `target`.
glm::mat4x3 Aimed(const glm::vec3& eye, const glm::vec3& target) {
    const glm::vec3 z = glm::normalize(eye - target);
    const glm::vec3 x = glm::normalize(glm::cross(glm::vec3(0.1f, 1, 0.2f), z));
    return {x, glm::cross(z, x), z, eye};
}

std::vector<scene::Light> Lights() {
    scene::Light spot = Punctual(scene::LightType::Spot, 60.0f, Aimed({-2, 4, 2}, {0, 0, 0}));
    spot.innerConeAngle = 0.3f;
    spot.outerConeAngle = 0.6f;
    return {Punctual(scene::LightType::Directional, 3.0f, Aimed({1, 3, 2}, {0, 0, 0})), spot,
            Punctual(scene::LightType::Point, 40.0f, Translation({1.2f, 2.5f, 1.5f}))};
}

// Makes gold and chalk spheres, a one-sided box and a thin pane on and above a floor.
scene::SceneData Table(std::vector<scene::Light> lights) {
    scene::Material gold;
    gold.baseColorFactor = {1.0f, 0.77f, 0.34f, 1.0f};
    gold.roughnessFactor = 0.5f;
    scene::Material box = Lambert({0.3f, 0.5f, 0.8f});
    box.isDoubleSided = false;
    const glm::mat4x3 floor(glm::vec3(1, 0, 0), glm::vec3(0, 0, -1), glm::vec3(0, 1, 0), glm::vec3(0.0f));
    const glm::mat4x3 pane(glm::vec3(1, 0, 0), glm::vec3(0, 0.4f, -0.9f), glm::vec3(0, 0.9f, 0.4f),
                           glm::vec3(-0.6f, 1.3f, 0.4f));
    scene::SceneData scene = SceneOf({QuadMesh(3.0f, 0), SphereMesh(0.5f, 32, 1), SphereMesh(0.4f, 32, 0),
                                      BoxMesh(0.3f, 2), QuadMesh(0.3f, 0)},
                                     {Lambert(glm::vec3(0.7f)), gold, box},
                                     {floor, Translation({-0.9f, 0.5f, 0}), Translation({0.2f, 0.4f, 0.5f}),
                                      Translation({1.0f, 0.3f, -0.2f}), pane});
    scene.lights = std::move(lights);
    return scene;
}

TraceSettings ViewOfTable(uint32_t size) {
    TraceSettings settings = LookAt({0.5f, 2.2f, 4.5f}, {0, 0.4f, 0}, 0.7f, size);
    settings.scattering.brdf = BrdfModel::Gltf;
    settings.biases.maxDepth = 1;
    return settings;
}

}  // namespace

TEST_F(RasterShadow, WithRaysDirectLightIsAsPathTraced) {
    for (const scene::Light& light : Lights()) {
        SCOPED_TRACE(int(light.type));
        render.scene.SetScene(Table({light}));
        const TraceSettings settings = ViewOfTable(80);
        const Difference difference =
            Compare(Draw(settings, RasterShadows::Rays, 16), render.Render(settings, 16).mean, 0.01f, 2);
        EXPECT_LE(difference.offEdges, 5e-4) << "the rim of a spot is steep";
        EXPECT_LT(difference.share, 0.12);
        RecordProperty("edges, light " + std::to_string(int(light.type)), std::to_string(difference.share));
    }
}

// There are more hidden placements than invocations of one dispatch, followed by the visible ones.
TEST_F(RasterShadow, EveryPlacementIsDrawnAndCastsItsShadowHoweverManyThereAre) {
    const auto drawn = [&](size_t count) {
        scene::SceneData table = Table({Lights()[0]});
        const uint32_t speck = static_cast<uint32_t>(table.meshes.size());
        table.meshes.push_back(QuadMesh(1e-3f, 0));
        scene::Instance hidden;  // under the floor
        hidden.mesh = speck;
        hidden.objectToWorld = Translation({0, -0.01f, 0});
        table.instances.insert(table.instances.begin(), count, hidden);
        render.scene.SetScene(std::move(table));
        return Draw(ViewOfTable(64), RasterShadows::Maps);
    };
    const FloatImage few = drawn(1), many = drawn((1u << 18) + 100);
    EXPECT_EQ(few.values, many.values);
    EXPECT_GT(few.Mean().y, 0.1);
}

TEST_F(RasterShadow, WithRaysLightComesThroughThinWallsAsPathTraced) {
    scene::Material glass;
    glass.baseColorFactor = {0.9f, 0.5f, 0.7f, 1.0f};
    glass.metallicFactor = glass.roughnessFactor = 0.0f;
    glass.transmissionFactor = 1.0f;
    for (const scene::Light& light : Lights()) {
        SCOPED_TRACE(int(light.type));
        // A pane over all of it, above the picture and below the lights
        scene::SceneData table = Table({light});
        table.materials.push_back(glass);
        table.meshes.push_back(QuadMesh(9.0f, 3));
        table.instances.push_back({.mesh = uint32_t(table.meshes.size() - 1),
                                   .objectToWorld = {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 2.4f, 0}}});
        render.scene.SetScene(std::move(table));
        const TraceSettings settings = ViewOfTable(80);
        const FloatImage drawn = Draw(settings, RasterShadows::Rays, 16);
        const Difference difference = Compare(drawn, render.Render(settings, 16).mean, 0.01f, 2);
        EXPECT_LE(difference.offEdges, 5e-4) << "the rim of a spot is steep";
        EXPECT_LT(difference.share, 0.12);
        render.scene.SetVisible(uint32_t(render.scene.Statistics().instanceCount - 1), false);
        const glm::dvec3 passed = drawn.Mean() / Draw(settings, RasterShadows::Rays, 16).Mean();
        EXPECT_NEAR(passed.x, 0.96 * 0.9, 0.05);
        EXPECT_NEAR(passed.y, 0.96 * 0.5, 0.05);
    }
}

TEST_F(RasterShadow, MapsAreAsRaysButNearShadowEdges) {
    for (const scene::Light& light : Lights()) {
        SCOPED_TRACE(int(light.type));
        render.scene.SetScene(Table({light}));
        const TraceSettings settings = ViewOfTable(160);
        const Difference difference =
            Compare(Draw(settings, RasterShadows::Maps), Draw(settings, RasterShadows::Rays), 0.02f, 2);
        EXPECT_GT(difference.shadowed, 0.03);
        EXPECT_LE(difference.share, 0.05);
        EXPECT_LE(difference.offEdges, 0.001);
        RecordProperty("differ, light " + std::to_string(int(light.type)), std::to_string(difference.share));
        RecordProperty("differ off edges, light " + std::to_string(int(light.type)),
                       std::to_string(difference.offEdges));
    }
}

TEST_F(RasterShadow, APointLightIsShadowedOnAllSides) {
    // A room with a box between the lamp and the middle of each wall
    std::vector<scene::Mesh> meshes{BoxMesh(2.0f)};
    std::vector<glm::mat4x3> transforms{Translation({0, 0, 0})};
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 at(0.0f);
            at[axis] = side;
            meshes.push_back(BoxMesh(0.2f));
            transforms.push_back(Translation(at));
        }
    scene::SceneData room = SceneOf(std::move(meshes), {Lambert(glm::vec3(0.5f))}, std::move(transforms));
    room.lights = {Punctual(scene::LightType::Point, 10.0f, Translation({0.05f, 0.1f, -0.05f}))};
    render.scene.SetScene(std::move(room));
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 target(0.0f);
            target[axis] = side;
            SCOPED_TRACE(std::to_string(axis) + (side < 0 ? "-" : "+"));
            const TraceSettings settings =
                LookAt(-1.5f * target + glm::vec3(0.3f, 0.35f, 0.3f), 2.0f * target, 1.2f, 48);
            const Difference difference =
                Compare(Draw(settings, RasterShadows::Maps), Draw(settings, RasterShadows::Rays), 0.02f, 2);
            EXPECT_GT(difference.shadowed, 0.02);
            EXPECT_LE(difference.offEdges, 0.002);
            EXPECT_LE(difference.share, 0.1);
        }
}

TEST_F(RasterShadow, AlphaAndSidesCastShadowsAsTheyStopRays) {
    // Before a wall: a half-covering veil, and a quad whose back is towards the light and is not there
    scene::Material veil = Lambert(glm::vec3(0.5f)), oneSided = Lambert(glm::vec3(0.5f));
    veil.alphaMode = scene::AlphaMode::Blend;
    veil.baseColorFactor.a = 0.5f;
    oneSided.isDoubleSided = false;
    const glm::mat4x3 turned(glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, -1),
                             glm::vec3(1, 0, 1));
    scene::SceneData scene =
        SceneOf({QuadMesh(3.0f), QuadMesh(0.4f, 1), QuadMesh(0.4f, 2), QuadMesh(0.4f, 2)},
                {Lambert(glm::vec3(0.5f)), veil, oneSided},
                {Translation({0, 0, 0}), Translation({-1, 0, 1}), Translation({0, 0, 1}), turned});
    scene.lights = {Punctual(scene::LightType::Directional, 1.0f, Aimed({0, 3, 3}, {0, 0, 0}))};
    render.scene.SetScene(std::move(scene));
    const TraceSettings settings = LookAt({0, -1.2f, 5}, {0, -1, 0}, 0.6f, 64);
    const FloatImage maps = Draw(settings, RasterShadows::Maps, 64);
    const FloatImage rays = Draw(settings, RasterShadows::Rays, 64);
    const float lit = rays.At(32, 60).y;
    EXPECT_GT(lit, 0.05f);
    const auto expect = [&](float x, float share) {
        const auto column = uint32_t(32.0f + x * 64.0f / (2.0f * 5.0f * std::tan(0.3f)));
        EXPECT_NEAR(maps.At(column, 32).y / lit, share, 0.1f) << x;
        EXPECT_NEAR(rays.At(column, 32).y / lit, share, 0.1f) << x;
    };
    expect(-1.0f, 0.5f);
    // A ray from the wall to the light meets the quad's back, and the turned one's front
    expect(0.0f, 1.0f);
    expect(1.0f, 0.0f);
}

TEST_F(RasterShadow, CascadesMoveInWholeTexelsAndKeepTheirSize) {
    render.scene.SetScene(Table({Lights()[0]}));
    const auto views = [&](const glm::vec3& offset) {
        TraceSettings settings = ViewOfTable(32);
        settings.camera.origin += offset;
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback readback = render.renderer.ReadBack(
            passes::DrawShadowMaps(render.renderer, ids, settings, {.atlasSize = 512}).views);
        render.renderer.Execute();
        readback.Wait();
        const auto all = As<gpu::ShadowView>(readback.Bytes());
        return std::vector<gpu::ShadowView>(all.begin(), all.begin() + gpu::kShadowCascades);
    };
    const std::vector<gpu::ShadowView> before = views({0, 0, 0});
    EXPECT_LT(before[0].texel, before[3].texel);
    double moved = 0.0;
    for (int step = 1; step <= 8; ++step) {
        const std::vector<gpu::ShadowView> after = views(0.013f * float(step) * glm::vec3(1, 0.7f, -0.4f));
        for (size_t i = 0; i < after.size(); ++i) {
            EXPECT_EQ(after[i].texel, before[i].texel);
            const glm::vec3 way = after[i].camera.origin - before[i].camera.origin;
            for (const glm::vec3& axis : {after[i].camera.right, after[i].camera.up}) {
                const double texels = glm::dot(way, glm::normalize(axis)) / after[i].texel;
                EXPECT_NEAR(texels, std::round(texels), 0.02) << "cascade " << i;
                moved += std::abs(texels);
            }
        }
    }
    EXPECT_GT(moved, 5.0);
}

TEST_F(RasterShadow, LightsBeyondTheAtlasCastNoShadow) {
    std::vector<scene::Light> lights;
    for (int i = 0; i < 12; ++i)
        lights.push_back(
            Punctual(scene::LightType::Point, i < 11 ? 1e-6f : 40.0f, Translation({1.2f, 2.5f, 1.5f})));
    render.scene.SetScene(Table(lights));
    const TraceSettings settings = ViewOfTable(48);
    const FloatImage unshadowed = Draw(settings, RasterShadows::Off);
    EXPECT_LT(Compare(Draw(settings, RasterShadows::Maps), unshadowed, 0.01f, 1).share, 0.001)
        << "ten lights of six faces fill the atlas";
    for (scene::Light& light : lights)
        if (light.intensity < 1.0f) light.intensity = 0.0f;
    render.scene.SetScene(Table(lights));
    EXPECT_GT(Compare(Draw(settings, RasterShadows::Maps), unshadowed, 0.01f, 1).share, 0.05)
        << "dark lights take no tiles";
}

}  // namespace raygraph::testing::raster_shadow_test
