// Light that goes straight through smooth thin walls: found by light sampling, and by paths that cross them,
// as if the wall was a hole for a share of the light.
#include <cmath>

#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_thin_walls_test {

using passes::TraceSettings;

namespace {

constexpr double kTolerance = 0.005;
const glm::vec3 kAlbedo(0.8f, 0.6f, 0.4f);
const glm::vec3 kTint(0.9f, 0.5f, 0.7f);

// Diffuse, and nothing else.
scene::Material Chalk(const glm::vec3& albedo) {
    scene::Material material = Lambert(albedo);
    material.metallicFactor = 0.0f;
    material.specularFactor = 0.0f;
    return material;
}

scene::Material Pane(const glm::vec3& tint = kTint) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(tint, 1.0f);
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.0f;
    material.transmissionFactor = 1.0f;
    return material;
}

// Share of light that a pane of index 1.5 does not reflect, by Schlick's curve.
double Passed(double cosine) {
    return 0.96 * (1.0 - std::pow(1.0 - cosine, 5.0));
}

// Shines along -z.
scene::Light Sun(float illuminance) {
    scene::Light light;
    light.type = scene::LightType::Directional;
    light.intensity = illuminance;
    return light;
}

scene::Light Bulb(float intensity, const glm::vec3& position) {
    scene::Light light;
    light.intensity = intensity;
    light.lightToWorld = Translation(position);
    return light;
}

class TraceThinWalls : public VulkanTest {
  protected:
    // A chalk floor in the plane z = 0 under panes (material 1) that fill the planes at these heights.
    void SetFloorUnder(const std::vector<float>& heights, const scene::Light& light,
                       const scene::Material& pane = Pane(), float halfSize = 1.0f) {
        std::vector<scene::Mesh> meshes{QuadMesh(halfSize, 0)};
        std::vector<glm::mat4x3> transforms{glm::mat4x3(1.0f)};
        for (const float height : heights) {
            meshes.push_back(QuadMesh(halfSize, 1));
            transforms.push_back(Translation({0, 0, height}));
        }
        scene::SceneData scene = SceneOf(std::move(meshes), {Chalk(kAlbedo), pane}, transforms);
        scene.lights = {light};
        render.scene.SetScene(std::move(scene));
    }
    // The middle of the floor from between it and a pane at 0.5, or from above one. All pixels see the same:
    // many of them make many samples in few frames.
    static TraceSettings View(float height = 0.25f, uint32_t maxDepth = 1, uint32_t size = 8) {
        TraceSettings settings = LookAt({0, 0, height}, {0, 0, 0}, 1e-3f, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = maxDepth;
        return settings;
    }
    void ExpectRadiance(const TraceSettings& settings, uint32_t samples, const glm::dvec3& expected) {
        const RenderedImage image = render.Render(settings, samples);
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(image.mean.Mean()[channel], expected[channel], kTolerance * expected[channel])
                << "channel " << channel;
        EXPECT_LE(3.0 * image.StandardErrorOfMean().y, kTolerance * expected.y)
            << "too noisy to prove anything";
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(TraceThinWalls, Trace_SunThroughPanesIsDimmedByTheReflectionAndTintOfEach) {
    for (const int count : {1, 2, 5}) {
        std::vector<float> heights;
        for (int i = 0; i < count; ++i) heights.push_back(0.5f + 0.1f * float(i));
        SetFloorUnder(heights, Sun(3.0f));
        const glm::dvec3 passed = glm::pow(glm::dvec3(kTint) * 0.96, glm::dvec3(count));
        ExpectRadiance(View(), 1, glm::dvec3(kAlbedo) * passed * (3.0 / M_PI));
    }
    // Under the middle of quads, many shadow rays go through the edge between two triangles: one wall
    SetFloorUnder({0.5f}, Sun(3.0f), Pane(glm::vec3(0.01f)));
    for (const glm::vec4& texel : render.Render(View(), 1).mean.values)
        EXPECT_NEAR(texel.x, kAlbedo.x * 0.01 * 3.0 * 0.96 / M_PI, 0.005 * texel.x);
}

// A floor without an end under a pane without an end, which reflects the share R of what a diffuse surface
// sends: the floor's irradiance E is that of the sun and the floor's own, R albedo E.
TEST_F(TraceThinWalls, Trace_FloorAndPaneReflectEachOther) {
    SetFloorUnder({0.01f}, Sun(3.0f), Pane(), 100.0f);
    const double reflected = 0.04 + 0.96 / 21.0;
    const glm::dvec3 albedo(kAlbedo);
    const glm::dvec3 irradiance = glm::dvec3(kTint) * (3.0 * 0.96) / (1.0 - reflected * albedo);
    ExpectRadiance(View(0.005f, passes::kNoDepthLimit, 64), 16, albedo * irradiance / M_PI);
}

TEST_F(TraceThinWalls, Trace_PointLightThroughAPaneIsDimmedByItsAngle) {
    SetFloorUnder({0.5f}, Bulb(7.0f, {0, 0, 2}));
    ExpectRadiance(View(), 1, glm::dvec3(kAlbedo * kTint) * (7.0 / 4.0 * 0.96 / M_PI));
    SetFloorUnder({0.25f}, Bulb(7.0f, {0, 4, 3}), Pane(), 10.0f);
    ExpectRadiance(View(0.2f), 1, glm::dvec3(kAlbedo * kTint) * (7.0 * 0.6 / 25.0 * Passed(0.6) / M_PI));
}

TEST_F(TraceThinWalls, Trace_CrossingCostsNoDepth) {
    // The camera above two panes sees the floor under them by the light of one bounce
    SetFloorUnder({0.5f, 0.6f}, Sun(3.0f));
    const glm::dvec3 passed = glm::pow(glm::dvec3(kTint) * 0.96, glm::dvec3(2));
    ExpectRadiance(View(0.9f, 1, 64), 32, glm::dvec3(kAlbedo) * passed * passed * (3.0 / M_PI));
    // And what emits behind them by that of none
    render.scene.SetMaterial(0, Lambert(glm::vec3(0.0f), glm::vec3(2.0f)));
    ExpectRadiance(View(0.9f, 0, 64), 32, 2.0 * passed);
}

TEST_F(TraceThinWalls, Trace_RoughWallsAndVolumesStopShadowRays) {
    scene::Material rough = Pane(), volume = Pane();
    rough.roughnessFactor = 0.2f;
    volume.thicknessFactor = 1.0f;
    for (const scene::Material& material : {rough, volume}) {
        SetFloorUnder({0.5f}, Sun(3.0f), material);
        EXPECT_EQ(render.Render(View(), 4).mean.Mean(), glm::dvec3(0.0));
    }
}

TEST_F(TraceThinWalls, Trace_PartlyTransmissivePaneWithAlphaIsDimmedByAll) {
    scene::Material pane = Pane();
    pane.transmissionFactor = 0.7f;
    pane.metallicFactor = 0.2f;
    pane.alphaMode = scene::AlphaMode::Blend;
    pane.baseColorFactor.a = 0.6f;
    // A shadow ray loses the part that the sheet scatters.
    for (const float strength : {0.0f, 0.25f}) {
        pane.scatterStrengthFactor = strength;
        SetFloorUnder({0.5f}, Sun(3.0f), pane);
        const glm::dvec3 passed = 0.4 + 0.6 * 0.8 * 0.7 * 0.96 * (1.0 - strength) * glm::dvec3(kTint);
        ExpectRadiance(View(0.25f, 1, 64), 64, glm::dvec3(kAlbedo) * passed * (3.0 / M_PI));
    }
}

// A lamp above a pane above a floor; a second pane stands beside it, half diffuse.
TEST_F(TraceThinWalls, Trace_HowLightIsFoundThroughPanesLeavesTheImage) {
    scene::Material milky = Pane({0.6f, 0.8f, 0.9f});
    milky.transmissionFactor = 0.5f;
    const glm::mat4x3 upright({1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0.6f, 0.4f});
    const glm::mat4x3 lamp({1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0.1f, 0.2f, 1.2f});
    render.scene.SetScene(
        SceneOf({QuadMesh(1.0f, 0), QuadMesh(0.8f, 1), QuadMesh(0.4f, 2), QuadMesh(0.3f, 3)},
                {Chalk(kAlbedo), Pane(), milky, Lambert(glm::vec3(0.0f), glm::vec3(5.0f))},
                {glm::mat4x3(1.0f), Translation({0, 0, 0.8f}), upright, lamp}));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.1f)});
    TraceSettings settings = LookAt({0.3f, -1.6f, 0.5f}, {0, 0, 0.3f}, 0.7f, 32);
    settings.scattering.brdf = BrdfModel::Gltf;
    for (const uint32_t maxDepth : {1u, 4u}) {
        settings.biases.maxDepth = maxDepth;
        settings.lights = {};
        settings.seed = 0;
        const RenderedImage reference = render.Render(settings, 192);
        settings.seed = 1;
        if (maxDepth == 1) {
            for (const MisHeuristic mis : {MisHeuristic::Balance, MisHeuristic::Off}) {
                settings.lights.mis = mis;
                ExpectSameImage(render.Render(settings, 96), reference, "mis " + std::to_string(int(mis)));
            }
            settings.lights.mis = MisHeuristic::Power;
            for (const LightSampler sampler : {LightSampler::Uniform, LightSampler::Power}) {
                settings.lights.sampler = sampler;
                ExpectSameImage(render.Render(settings, 96), reference,
                                "sampler " + std::to_string(int(sampler)));
            }
        }
        settings.lights.isOn = false;
        ExpectSameImage(render.Render(settings, 384), reference, "BSDF sampling alone");
    }
}

TEST_F(TraceThinWalls, SetMaterial_MakesAWallThatSunGoesThrough) {
    // One-sided, with its back to the floor: to rays from there it is not there at all
    scene::Material wall = Chalk(glm::vec3(0.5f));
    wall.isDoubleSided = false;
    const glm::dvec3 lit = glm::dvec3(kAlbedo) * (3.0 / M_PI);
    SetFloorUnder({0.5f}, Sun(3.0f), wall);
    ExpectRadiance(View(), 1, lit);
    render.scene.SetMaterial(1, Pane());
    ExpectRadiance(View(), 1, lit * 0.96 * glm::dvec3(kTint));
    wall.isDoubleSided = true;
    render.scene.SetMaterial(1, wall);
    EXPECT_EQ(render.Render(View(), 1).mean.Mean(), glm::dvec3(0.0));
    render.scene.SetMaterial(1, Pane(glm::vec3(1.0f)));
    ExpectRadiance(View(), 1, lit * 0.96);
    wall.isDoubleSided = false;
    render.scene.SetMaterial(1, wall);
    ExpectRadiance(View(), 1, lit);
}

TEST_F(TraceThinWalls, SetMaterial_LeavesTheOtherWallsOfAMesh) {
    // A mesh of two one-sided walls, of which one becomes a pane
    scene::Material wall = Chalk(glm::vec3(0.5f));
    wall.isDoubleSided = false;
    scene::Mesh mesh = QuadMesh(0.5f, 1);
    scene::Primitive other = QuadMesh(0.5f, 2).primitives[0];
    for (glm::vec3& position : other.positions) position.x += 1.0f;
    other.bounds.min.x += 1.0f;
    other.bounds.max.x += 1.0f;
    mesh.primitives.push_back(other);
    for (const bool isTurned : {false, true}) {
        const glm::mat4x3 turned({1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0, 0, 0.5f});
        scene::SceneData scene = SceneOf({QuadMesh(3.0f, 0), mesh}, {Chalk(kAlbedo), wall, wall},
                                         {glm::mat4x3(1.0f), isTurned ? turned : Translation({0, 0, 0.5f})});
        scene.lights = {Sun(3.0f)};
        render.scene.SetScene(std::move(scene));
        render.scene.SetMaterial(1, Pane());
        TraceSettings beside = View();
        beside.camera.origin.x += 1.0f;
        const glm::dvec3 lit = glm::dvec3(kAlbedo) * (3.0 / M_PI);
        ExpectRadiance(View(), 1, lit * 0.96 * glm::dvec3(kTint));
        if (isTurned)
            EXPECT_EQ(render.Render(beside, 1).mean.Mean(), glm::dvec3(0.0));
        else
            ExpectRadiance(beside, 1, lit);
    }
}

}  // namespace raygraph::testing::trace_thin_walls_test
