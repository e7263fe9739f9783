// The lights of GpuScene: the tables on the device are those of the scene, rebuilt when an emitter changes.
#include <cmath>
#include <cstring>

#include "rhi/shader_compiler.h"
#include "shared/environment_entries.h"
#include "shared/light_samplers.h"
#include "tests/support/scene_render.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::light_set_test {

namespace {

template <typename T>
std::vector<T> Records(const Readback& readback) {
    readback.Wait();
    const std::span<const std::byte> bytes = readback.Bytes();
    std::vector<T> records(bytes.size() / sizeof(T));
    std::memcpy(records.data(), bytes.data(), records.size() * sizeof(T));
    return records;
}

class LightSetTest : public VulkanTest {
  protected:
    struct Tables {
        gpu::LightSetRecord set;
        std::vector<gpu::LightRecord> lights;
        std::vector<gpu::LightNode> nodes;
        std::vector<gpu::AliasEntry> alias;
        std::vector<gpu::EnvironmentEntry> environment;
        std::vector<gpu::InstanceRecord> instances;
    };
    Tables Frame() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback lights = render.renderer.ReadBack(ids.lights);
        const Readback nodes = render.renderer.ReadBack(ids.lightNodes);
        const Readback alias = render.renderer.ReadBack(ids.lightAlias);
        const Readback environment = render.renderer.ReadBack(ids.environmentTable);
        const Readback instances = render.renderer.ReadBack(ids.instances);
        render.renderer.Execute();
        return {ids.lightSet,
                Records<gpu::LightRecord>(lights),
                Records<gpu::LightNode>(nodes),
                Records<gpu::AliasEntry>(alias),
                Records<gpu::EnvironmentEntry>(environment),
                Records<gpu::InstanceRecord>(instances)};
    }
    uint64_t Rebuilds() const { return render.scene.Statistics().lightRebuilds; }
    // Frames in which the tables have changed, one way or the other.
    uint64_t Changes() const { return Rebuilds() + render.scene.Statistics().lightUpdates; }

    SceneRender render{Device()};
};

// A lamp (material 1) and a wall (material 0), each placed twice, and a point light.
scene::SceneData Lamps() {
    scene::SceneData scene = SceneOf({QuadMesh(1.0f, 0), QuadMesh(0.5f, 1)},
                                     {Lambert(glm::vec3(0.5f)), Lambert({}, glm::vec3(2.0f))});
    scene.instances = {{.mesh = 0},
                       {.mesh = 1, .objectToWorld = Translation({0, 0, 1})},
                       {.mesh = 0, .objectToWorld = Translation({5, 0, 0})},
                       {.mesh = 1, .objectToWorld = Translation({5, 0, 1})}};
    scene.lights.push_back({.name = {}, .intensity = 3.0f});
    return scene;
}

// Irradiance at the origin facing +z by one light sample a texel: shaders/lights over the tables of GpuScene.
constexpr std::string_view kIrradianceShader = R"(#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_scalar_block_layout : require
#include "core/equirect.glsl"
#include "core/rng.glsl"
#include "lights/light_types.glsl"
#include "shared/scene_records.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) uniform writeonly image2D target;
layout(binding = 1, scalar) readonly buffer Lights { LightRecord at[]; } lights;
layout(binding = 2, scalar) readonly buffer Nodes { LightNode at[]; } lightNodes;
layout(binding = 3, scalar) readonly buffer Alias { AliasEntry at[]; } lightAlias;
layout(binding = 7, scalar) readonly buffer Meshes { LightMeshRecord at[]; } lightMeshes;
layout(binding = 8, scalar) readonly buffer Instances { InstanceRecord at[]; } instances;
layout(binding = 4, scalar) readonly buffer EnvironmentTable { EnvironmentEntry at[]; } environmentTable;
layout(binding = 5, scalar) uniform Set { LightSetRecord value; } lightSet;
layout(binding = 6) uniform sampler2D environmentMap;

LightSetRecord LightSet() { return lightSet.value; }
LightRecord LightAt(uint light) { return lights.at[light]; }
LightNode LightNodeAt(uint node) { return lightNodes.at[node]; }
AliasEntry LightAliasAt(uint slot) { return lightAlias.at[slot]; }
LightMeshRecord LightMeshAt(uint mesh) { return lightMeshes.at[mesh]; }
mat4x3 LightPlacement(uint instance) { return instances.at[instance].objectToWorld; }
float LightProfileAt(uint word) { return 0.0f; }
EnvironmentEntry EnvironmentEntryAt(uint slot) { return environmentTable.at[slot]; }
vec3 EnvironmentRadiance(vec3 d) {
    vec2 uv = EquirectFromDirection(d, LightSet().environmentRotation);
    return 0.2f * textureLod(environmentMap, uv, 0.0f).xyz;
}
vec3 TriangleEmission(LightRecord light, vec2 barycentrics, vec3 toViewer) { return vec3(2.0f); }
#include "lights/lights.glsl"

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(target)))) return;
    Sampler rng = StartPixelSample(uvec2(0u), uint(texel.y * imageSize(target).x + texel.x), 1u);
    LightContext context;
    context.position = vec3(0.0f);
    context.normal = vec3(0.0f, 0.0f, 1.0f);
    float uc = Get1D(rng);
    LightSample s = SampleLight(context, uc, Get2D(rng));
    float value = s.pdf > 0.0f ? s.radiance.y * max(s.wi.z, 0.0f) / s.pdf : 0.0f;
    // A sample whose density is not that of its hit counts for nothing
    if (s.pdf > 0.0f && s.isDelta == 0u) {
        float pdf = LightPDF(context, s.light, s.triangle, s.wi, s.distance);
        if (abs(pdf / s.pdf - 1.0f) > 1e-3f) value = -1e6f;
    }
    imageStore(target, texel, vec4(value));
})";

}  // namespace

TEST_F(LightSetTest, TablesOnTheDeviceAreThoseOfTheScene) {
    render.scene.SetScene(Lamps());
    const Tables tables = Frame();
    EXPECT_EQ(tables.set.lightCount, 5u);
    EXPECT_EQ(tables.set.boundedCount, 5u);
    EXPECT_EQ(tables.set.hasEnvironment, 0u);
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 4u);
    EXPECT_EQ(render.scene.Statistics().lightCount, 5u);
    ASSERT_EQ(tables.lights.size(), 5u);
    for (uint32_t light = 0; light < 4; ++light) {
        const gpu::LightRecord& record = tables.lights[light];
        EXPECT_EQ(record.kind, gpu::kLightTriangle);
        EXPECT_EQ(record.p0.z, 1.0f);
        EXPECT_EQ(record.p0.x > 2.0f, light >= 2);
        // From the hit's side: the instance knows its first light
        const gpu::InstanceRecord& instance = tables.instances[record.instance];
        EXPECT_EQ(instance.firstLight, light / 2 * 2);
        EXPECT_NE(instance.triangleLights, 0u);
        EXPECT_EQ(instance.objectToWorld[3].x, light >= 2 ? 5.0f : 0.0f);
    }
    EXPECT_EQ(tables.lights[4].kind, gpu::kLightPoint);
    EXPECT_EQ(tables.instances[0].triangleLights, 0u) << "a wall has no lights";
    EXPECT_EQ(tables.nodes[0].boundsMax.x, 5.5f);
    float sum = 0.0f;
    for (size_t i = 0; i < 6; ++i) sum += tables.alias[i].probability;
    EXPECT_NEAR(sum, 1.0f, 1e-6f);
    ASSERT_EQ(tables.environment.size(), 2u);
    EXPECT_EQ(tables.environment[1].probability, 1.0f);
}

TEST_F(LightSetTest, TablesChangeWhenAnEmitterDoesAndOnlyThen) {
    render.scene.SetScene(Lamps());
    Frame();
    EXPECT_EQ(Changes(), 1u);
    Frame();
    render.scene.SetTransform(0, Translation({0, 1, 0}));  // a wall
    render.scene.SetVisible(2, false);                     // another
    render.scene.SetMaterial(0, Lambert(glm::vec3(0.1f)));
    render.scene.SetMaterial(1, Lambert(glm::vec3(0.3f), glm::vec3(2.0f)));  // emits as it did
    Frame();
    EXPECT_EQ(Changes(), 1u);
    EXPECT_EQ(render.renderer.DescribePlan().find("UploadLights"), std::string::npos);

    render.scene.SetTransform(1, Translation({0, 0, 3}));
    EXPECT_EQ(Frame().lights[0].p0.z, 3.0f);
    EXPECT_EQ(Changes(), 2u);
    render.scene.SetVisible(1, false);
    const Tables hidden = Frame();
    EXPECT_EQ(Changes(), 3u);
    EXPECT_EQ(hidden.alias[0].probability, 0.0f);
    EXPECT_GT(hidden.alias[2].probability, 0.0f);
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 2u);
    render.scene.SetMaterial(1, Lambert(glm::vec3(0.3f)));
    EXPECT_EQ(Frame().set.activeCount, 1u) << "the point light";
    render.scene.SetMaterial(1, Lambert(glm::vec3(0.3f), glm::vec3(7.0f)));
    EXPECT_EQ(Frame().set.activeCount, 3u);
    EXPECT_EQ(Changes(), 5u);
}

// Places and boxes are those of a table that is built there; nothing is sorted again.
TEST_F(LightSetTest, OriginThatMovesPlacesTheLightsAgain) {
    scene::SceneData scene = Lamps();
    for (scene::Instance& instance : scene.instances) instance.objectToWorld[3].x += 5000.0f;
    scene.lights[0].lightToWorld = Translation({5000, 2, 1});
    scene.instances.push_back({.mesh = 0});
    render.scene.SetScene(std::move(scene));
    const Tables before = Frame();
    render.scene.SetViewpoint({5000, 0, 0});
    const Tables moved = Frame();
    EXPECT_EQ(Rebuilds(), 1u);
    render.scene.SetLightGroups({});  // all of it again
    const Tables built = Frame();
    EXPECT_EQ(Rebuilds(), 2u);
    ASSERT_EQ(moved.lights.size(), built.lights.size());
    for (size_t i = 0; i < moved.lights.size(); ++i) {
        EXPECT_EQ(moved.lights[i].p0, built.lights[i].p0) << i;
        EXPECT_EQ(moved.lights[i].spotOffsetOrClearance, built.lights[i].spotOffsetOrClearance) << i;
        EXPECT_EQ(moved.lights[i].bitTrail, before.lights[i].bitTrail) << i;
        EXPECT_NEAR(before.lights[i].p0.x - moved.lights[i].p0.x, 39 * 128.0, 1e-3) << i;
    }
    ASSERT_EQ(moved.set.nodeCount, 9u);
    for (uint32_t i = 0; i < moved.set.nodeCount; ++i) {
        EXPECT_EQ(moved.nodes[i].link, built.nodes[i].link) << i;
        EXPECT_EQ(moved.nodes[i].boundsMin, built.nodes[i].boundsMin) << i;
        EXPECT_EQ(moved.nodes[i].boundsMax, built.nodes[i].boundsMax) << i;
    }
    EXPECT_EQ(
        std::memcmp(moved.alias.data(), before.alias.data(), moved.alias.size() * sizeof(gpu::AliasEntry)),
        0);
}

// What an infinite light shines on is what can be seen now, not what could when the scene was loaded.
TEST_F(LightSetTest, InfiniteLightsShineOnWhatIsShownLater) {
    const auto probabilityOfTheSun = [&](const Tables& tables) { return tables.alias.at(5).probability; };
    const auto withSun = [](bool isFarVisible) {
        scene::SceneData scene = Lamps();
        scene.lights.push_back({.name = {}, .type = scene::LightType::Directional, .intensity = 1.0f});
        scene.nodes.resize(1);
        scene.nodes[0].isVisible = isFarVisible;
        scene.nodes[0].translation = {0, 0, 40};
        scene.nodeOrder = {0};
        scene.instances.push_back({.mesh = 0, .node = 0});
        scene.instances.push_back({.mesh = 0, .objectToWorld = Translation({2, 0, 0.5f})});
        scene::UpdateWorldTransforms(scene);
        return scene;
    };
    render.scene.SetScene(withSun(true));
    const float far = probabilityOfTheSun(Frame());
    render.scene.SetScene(withSun(false));
    const float near = probabilityOfTheSun(Frame());
    EXPECT_GT(far, 1.2f * near);
    const uint64_t before = Changes();
    render.scene.SetVisible(4, true);
    EXPECT_EQ(probabilityOfTheSun(Frame()), far);
    EXPECT_EQ(Changes(), before + 1);
    render.scene.SetVisible(4, false);
    EXPECT_EQ(probabilityOfTheSun(Frame()), near);
    render.scene.SetVisible(5, false);  // among what else is seen
    Frame();
    EXPECT_EQ(Changes(), before + 2);
    // What has moved counts as soon as the tables are built again
    render.scene.SetTransform(4, Translation({0, 0, 1}));
    render.scene.SetVisible(4, true);
    EXPECT_EQ(probabilityOfTheSun(Frame()), near);
}

TEST_F(LightSetTest, EnvironmentIsOneMoreLight) {
    render.scene.SetScene(Lamps());
    Frame();
    render.scene.SetEnvironment({.radiance = glm::vec3(0.5f), .rotation = 1.0f});
    Tables tables = Frame();
    EXPECT_EQ(tables.set.hasEnvironment, 1u);
    EXPECT_EQ(tables.set.activeCount, 6u);
    EXPECT_EQ(tables.set.environmentRotation, 1.0f);
    EXPECT_GT(tables.set.unboundedProbability, 0.0f);
    EXPECT_EQ(Changes(), 2u);
    render.scene.SetEnvironment({.radiance = glm::vec3(0.5f), .rotation = 2.0f});
    EXPECT_EQ(Frame().set.environmentRotation, 2.0f);
    EXPECT_EQ(Changes(), 2u) << "turning it changes no power";

    image::ImageF map{.width = 4, .height = 2, .rgba = std::vector<float>(32, 0.0f)};
    for (size_t c = 0; c < 4; ++c) map.rgba[c] = 100'000.0f;
    render.scene.SetEnvironmentMap(map);
    tables = Frame();
    EXPECT_EQ(tables.set.environmentWidth, 4u);
    EXPECT_EQ(tables.set.environmentHeight, 2u);
    ASSERT_EQ(tables.environment.size(), 10u);
    EXPECT_GT(tables.environment[2].probability, tables.environment[3].probability);
    render.scene.RemoveEnvironmentMap();
    EXPECT_EQ(Frame().set.environmentWidth, 1u);
}

TEST_F(LightSetTest, IrradianceOnTheDeviceIsTheSumOfTheClosedForms) {
    rhi::GlslSource source;
    source.name = "test/irradiance.comp";
    source.text = kIrradianceShader;
    source.includeRoot = test::SourceFile("shaders");
    render.renderer.AddShader("test/irradiance.comp", rhi::CompileGlsl(source));

    // A lamp of radiance 2 facing down, 2 m above; a point light; light from above; a gray sky
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert({}, glm::vec3(2.0f))});
    scene.instances[0].objectToWorld =
        glm::mat4x3(glm::vec3(1, 0, 0), glm::vec3(0, -1, 0), glm::vec3(0, 0, -1), glm::vec3(0, 0, 2));
    scene.lights.resize(2);
    scene.lights[0].lightToWorld[3] = glm::vec3(1, 0, 1);
    scene.lights[1].type = scene::LightType::Directional;
    scene.lights[1].intensity = 0.5f;
    render.scene.SetScene(std::move(scene));
    render.scene.SetEnvironmentMap({.width = 8, .height = 4, .rgba = std::vector<float>(128, 1.0f)});
    render.scene.SetEnvironment({.radiance = glm::vec3(0.2f), .rotation = 0.3f});
    // A small patch under a square of half its height's side: J. R. Howell's catalogue, B-4, four times
    const double factor = 4.0 * 2.0 * 0.5 / std::sqrt(1.25) * std::atan(0.5 / std::sqrt(1.25)) / (2.0 * M_PI);
    const double expected = 2.0 * M_PI * factor + 1.0 / (2.0 * std::sqrt(2.0)) + 0.5 + 0.2 * M_PI;

    for (const LightSampler sampler : {LightSampler::Uniform, LightSampler::Power, LightSampler::Bvh}) {
        constexpr Extent2D kExtent{256, 256};
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        TextureId target =
            render.renderer.CreateTexture("irradiance", {.extent = kExtent, .format = Format::R32Float});
        render.renderer.AddPass(
            "Irradiance", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("test/irradiance.comp");
                pass.Reads("lights", ids.lights);
                pass.Reads("lightNodes", ids.lightNodes);
                pass.Reads("lightAlias", ids.lightAlias);
                pass.Reads("lightMeshes", ids.lightMeshes);
                pass.Reads("instances", ids.instances);
                pass.Reads("environmentTable", ids.environmentTable);
                pass.Reads("environmentMap", ids.environmentMap, {.addressV = rhi::AddressMode::ClampToEdge});
                pass.Uniform("lightSet", ids.lightSet);
                pass.Specialize("kLightSampler", static_cast<uint32_t>(sampler));
                target = pass.Writes("target", target);
            },
            [extent = kExtent](CommandList& commands) { commands.DispatchOver(extent); });
        const std::vector<float> values = [&] {
            const Readback readback = render.renderer.ReadBack(target);
            render.renderer.Execute();
            return Records<float>(readback);
        }();
        double sum = 0.0;
        for (const float value : values) sum += static_cast<double>(value);
        EXPECT_NEAR(sum / double(values.size()), expected, 0.005 * expected) << "sampler " << int(sampler);
    }
}

TEST_F(LightSetTest, UploadThatLeadsNowhereStaysDue) {
    render.scene.SetScene(Lamps());
    render.renderer.BeginFrame();
    const SceneIds ids = render.scene.Declare(render.renderer);
    const Readback records = render.renderer.ReadBack(ids.instances);
    render.renderer.Execute();
    records.Wait();
    EXPECT_EQ(Frame().lights.at(4).e2, glm::vec3(3.0f));
    EXPECT_EQ(Rebuilds(), 1u);
}

}  // namespace raygraph::testing::light_set_test
