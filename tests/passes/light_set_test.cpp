#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>

#include "renderer/gpu_scene/lights/light_set.h"
#include "renderer/scene/model/ground.h"
#include "rhi/shader_compiler.h"
#include "shared/choice.h"
#include "shared/light_records.h"
#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

// The lights of GpuScene: the tables on the device are those of the scene, rebuilt when an emitter changes.
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

// An infinite light shines on what can be seen now, not on what could when the scene was loaded.
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
    // Moved instances count as soon as the tables are built again
    render.scene.SetTransform(4, Translation({0, 0, 1}));
    render.scene.SetVisible(4, true);
    EXPECT_EQ(probabilityOfTheSun(Frame()), near);
}

// A ground is far larger than what stands on it, whose own lamps would be chosen too seldom.
TEST_F(LightSetTest, InfiniteLightsAreNotChosenForTheGround) {
    scene::SceneData lamps = Lamps();
    lamps.lights.push_back({.name = {}, .type = scene::LightType::Directional, .intensity = 1.0f});
    const scene::Bounds bounds{.min = glm::vec3(-1.0f), .max = glm::vec3(1.0f)};
    render.scene.SetScene(std::move(lamps));
    const float before = Frame().alias.at(5).probability;
    const auto ground = render.scene.Add(scene::GroundUnder(bounds));
    EXPECT_EQ(Frame().alias.at(5).probability, before);
    render.scene.Remove(ground);
    EXPECT_EQ(Frame().alias.at(5).probability, before);
    // A ground alone is all that they can shine on
    render.scene.SetScene({});
    render.scene.AddLight({.name = {}, .type = scene::LightType::Directional, .intensity = 1.0f});
    render.scene.Add(scene::GroundUnder(bounds));
    EXPECT_GT(Frame().set.unboundedProbability, 0.0f);
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

// Programs sample the kinds of light that a scene has.
TEST_F(LightSetTest, FeaturesAreThoseOfTheKindsOfLight) {
    const auto lightsOf = [&](scene::SceneData scene, float sky) {
        render.scene.SetScene(std::move(scene));
        render.scene.SetEnvironment({.radiance = glm::vec3(sky)});
        render.renderer.BeginFrame();
        const TraceFeatures features = render.scene.Declare(render.renderer).features;
        render.renderer.DropFrame();
        return features & FeaturesOfKind(TraceFeatureKind::Lights);
    };
    scene::SceneData lamp = Lamps(), dark = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))}),
                     bulb = dark;
    lamp.lights.clear();
    bulb.lights.resize(1);
    EXPECT_EQ(lightsOf(dark, 0.0f), TraceFeatures{});
    EXPECT_EQ(lightsOf(lamp, 0.0f), kTraceLightSampling | kTraceTriangleLights);
    EXPECT_EQ(lightsOf(bulb, 0.0f), kTraceLightSampling | kTracePunctualLights);
    EXPECT_EQ(lightsOf(dark, 1.0f), kTraceLightSampling | kTraceEnvironmentLight);
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

// LightSet as objects come and go: its tables are those of a set that had them from the start.
namespace raygraph::testing::light_objects_test {

namespace {

constexpr uint32_t kInstances = 12;
constexpr uint32_t kLamp = 0, kSign = 1;  // groups, of a mesh each

// Small triangles in a row, of one material.
std::vector<Emitter> Emitters(uint32_t count) {
    std::vector<Emitter> emitters;
    for (uint32_t i = 0; i < count; ++i) {
        const glm::vec3 p(0.01f * float(i), 0.0f, 0.0f);
        emitters.push_back(
            {.p0 = p, .p1 = p + glm::vec3(0.01f, 0, 0), .p2 = p + glm::vec3(0, 0, 0.5f), .primitive = i});
    }
    return emitters;
}

bool IsLamp(uint32_t instance) {
    return instance % 3 != 0;
}

// The lights of some of the instances: lamps of 1000 triangles and signs of 2.
class World {
  public:
    explicit World(Renderer& renderer, uint32_t placed, LightRule rule = LightRule::Decay)
        : m_renderer(renderer), m_uploader(renderer.Device()) {
        m_geometry.meshes = {{.firstGroup = 0, .groupCount = 1}, {.firstGroup = 1, .groupCount = 1}};
        m_geometry.groups.resize(2);
        m_geometry.groups[kLamp].emitters = Emitters(1000);
        m_geometry.groups[kSign].emitters = Emitters(2);
        scene::SceneData data;
        data.materials = {Lambert({}, glm::vec3(1.0f))};
        data.lights.resize(1);
        for (uint32_t i = 0; i < kInstances; ++i) {
            data.instances.push_back({.mesh = IsLamp(i) ? 0u : 1u, .objectToWorld = PlaceOf(i)});
            m_geometry.meshOf.push_back(data.instances.back().mesh);
        }
        instances.emplace(renderer.Device(), m_geometry, data);
        data.instances.resize(placed);
        m_uploader.FlushAfter([&] {
            lights.emplace(renderer.Device(), m_uploader, m_geometry, instances->Placements().first(placed),
                           data, rule);
        });
    }
    static glm::mat4x3 PlaceOf(uint32_t instance) { return Translation({0, 0, float(instance)}); }
    void Add(uint32_t instance) {
        lights->AddPlacement(instance, instance, IsLamp(instance) ? kLamp : kSign, PlaceOf(instance), true);
    }

    // The probability of a light by the InstanceRecord it is of, and of all others under kInstances.
    std::map<uint32_t, double> Probabilities() {
        m_renderer.BeginFrame();
        SceneIds ids;
        lights->Declare(m_renderer, ids, *instances);
        const Readback recordBytes = m_renderer.ReadBack(ids.lights);
        const Readback aliasBytes = m_renderer.ReadBack(ids.lightAlias);
        m_renderer.Execute();
        recordBytes.Wait();
        aliasBytes.Wait();
        std::vector<gpu::LightRecord> records(recordBytes.Bytes().size() / sizeof(gpu::LightRecord));
        std::memcpy(records.data(), recordBytes.Bytes().data(), records.size() * sizeof(gpu::LightRecord));
        std::vector<gpu::AliasEntry> alias(aliasBytes.Bytes().size() / sizeof(gpu::AliasEntry));
        std::memcpy(alias.data(), aliasBytes.Bytes().data(), alias.size() * sizeof(gpu::AliasEntry));
        std::map<uint32_t, double> probabilities;
        groups.clear();
        for (const gpu::LightRecord& record : records)
            groups.push_back(record.flags >> gpu::kLightGroupShift);
        set = ids.lightSet;
        hasMeshes = ids.features.Has(kTraceMeshLights);
        for (uint32_t i = 0; i < set.lightCount; ++i) {
            if (!(alias[i].probability > 0.0f)) continue;
            const bool isSurface = i < ids.triangleLights;
            probabilities[isSurface ? records[i].instance : kInstances] += double(alias[i].probability);
            if (!isSurface) continue;
            // From the hit's side
            const uint32_t first = instances->Placements()[records[i].instance].firstLight;
            const bool isMesh = records[i].kind == gpu::kLightMesh;
            EXPECT_EQ((first & gpu::kFirstLightIsMesh) != 0u, isMesh);
            EXPECT_EQ(i - (first & ~gpu::kFirstLightIsMesh), isMesh ? 0u : records[i].primitive);
        }
        return probabilities;
    }

    std::optional<InstanceSet> instances;
    std::optional<LightSet> lights;
    gpu::LightSetRecord set{};
    bool hasMeshes = false;
    std::vector<uint32_t> groups;  // by light

  private:
    Renderer& m_renderer;
    rhi::Uploader m_uploader;
    SceneGeometry m_geometry;
};

class LightObjects : public VulkanTest {
  protected:
    static void ExpectAlike(const std::map<uint32_t, double>& a, const std::map<uint32_t, double>& b) {
        ASSERT_EQ(a.size(), b.size());
        for (const auto& [record, probability] : a) {
            ASSERT_TRUE(b.contains(record)) << record;
            EXPECT_NEAR(probability, b.at(record), 2e-5) << record;
        }
    }
    RendererLease lease{Device()};
};

}  // namespace

TEST_F(LightObjects, TablesAreThoseOfASetThatHadTheLightsFromTheStart) {
    World all(*lease, kInstances), grown(*lease, 4);
    const auto expected = all.Probabilities();
    EXPECT_TRUE(all.hasMeshes) << "8 lamps are too many to be expanded";
    EXPECT_EQ(expected.size(), kInstances + 1u);
    EXPECT_EQ(grown.Probabilities().size(), 5u);
    EXPECT_FALSE(grown.hasMeshes);
    for (uint32_t i = 4; i < kInstances; ++i) {
        grown.Add(i);
        EXPECT_EQ(grown.Probabilities().size(), i + 2u);
    }
    EXPECT_TRUE(grown.hasMeshes);
    ExpectAlike(grown.Probabilities(), expected);
}

TEST_F(LightObjects, WhatIsRemovedIsDarkAndItsNumbersAreUsedAgain) {
    World world(*lease, kInstances);
    const auto expected = world.Probabilities();
    const uint32_t count = world.set.lightCount;
    const auto numbers = [&] {
        std::vector<uint32_t> first;
        for (const InstanceSet::Placement& placement : world.instances->Placements())
            first.push_back(placement.firstLight);
        return first;
    };
    const std::vector<uint32_t> before = numbers();
    for (const uint32_t instance : {2u, 3u}) {
        world.lights->RemovePlacements(instance);
        EXPECT_FALSE(world.lights->IsEmitter(instance));
    }
    auto without = world.Probabilities();
    EXPECT_FALSE(without.contains(2) || without.contains(3));
    EXPECT_EQ(without.size(), expected.size() - 2);
    EXPECT_EQ(world.set.lightCount, count) << "the others keep their numbers";
    EXPECT_EQ(numbers(), before);
    const uint64_t bytes = world.lights->Statistics().tableBytes;
    world.Add(3);
    world.Add(2);
    ExpectAlike(world.Probabilities(), expected);
    EXPECT_EQ(world.set.lightCount, count);
    EXPECT_EQ(world.lights->Statistics().tableBytes, bytes);
    // Once most are gone, the rest gets new numbers
    for (uint32_t i = 0; i < kInstances; ++i)
        if (i != 5) world.lights->RemovePlacements(i);
    EXPECT_EQ(world.Probabilities().size(), 2u);
    EXPECT_EQ(world.set.lightCount, 1000u + 1u) << "a lamp alone is expanded";
}

// Groups were made for what there was.
TEST_F(LightObjects, WhatTakesTheIndexOfAnotherIsNotInItsGroup) {
    World world(*lease, kInstances);
    const uint32_t named = gpu::kLightGroupNamed;
    world.lights->SetGroups({.namedCount = 1,
                             .instances = std::vector<uint32_t>(kInstances, named),
                             .materials = {gpu::kLightGroupRest},
                             .lights = {named}});
    world.Probabilities();
    const auto groupOf = [&](uint32_t instance) {
        return world.groups[world.instances->Placements()[instance].firstLight & ~gpu::kFirstLightIsMesh];
    };
    EXPECT_EQ(groupOf(1), named);
    EXPECT_EQ(groupOf(2), named);
    EXPECT_EQ(world.groups[world.set.lightCount - 1], named);
    world.lights->RemovePlacements(1);
    world.lights->RemovePunctual(0);
    world.Add(1);
    EXPECT_EQ(world.lights->AddPunctual({}, true), 0u);
    world.Probabilities();
    EXPECT_EQ(groupOf(1), gpu::kLightGroupRest);
    EXPECT_EQ(groupOf(2), named);
    EXPECT_EQ(world.groups[world.set.lightCount - 1], gpu::kLightGroupRest);
}

TEST_F(LightObjects, TablesOfTheRuleAlwaysAreThoseOfWhatIsThere) {
    World all(*lease, kInstances, LightRule::Always), grown(*lease, 6, LightRule::Always);
    grown.Probabilities();
    for (uint32_t i = kInstances; i-- > 6;) grown.Add(i);
    grown.lights->RemovePlacements(1);
    grown.Probabilities();
    grown.Add(1);
    EXPECT_EQ(grown.Probabilities(), all.Probabilities());
    for (uint32_t i = 0; i < kInstances; ++i)
        EXPECT_EQ(grown.instances->Placements()[i].firstLight, all.instances->Placements()[i].firstLight)
            << i;
}

TEST_F(LightObjects, GroupsMaterialsAndPunctualLightsAreAddedToo) {
    World world(*lease, 4);
    world.Probabilities();
    const uint64_t bytes = world.lights->Statistics().tableBytes;
    world.lights->AddMaterial(1, glm::vec3(5.0f));
    std::vector<Emitter> emitters = Emitters(3000);
    for (Emitter& emitter : emitters) emitter.material = 1;
    world.lights->AddGroup(2, emitters, {}, false);
    world.lights->AddPlacement(4, 4, 2, World::PlaceOf(4), true);
    scene::Light sun;
    sun.type = scene::LightType::Directional;
    EXPECT_EQ(world.lights->AddPunctual(sun, true), 1u);
    EXPECT_EQ(world.lights->AddPunctual(scene::Light{.intensity = 1000.0f}, true), 2u);
    auto probabilities = world.Probabilities();
    EXPECT_EQ(world.set.boundedCount, 2u + 2000u + 2u + 3000u + 2u);
    EXPECT_EQ(world.set.lightCount, world.set.boundedCount + 1u);
    EXPECT_NEAR(probabilities[4] / probabilities[1], 15.0, 1e-3) << "3 times as many, 5 times as bright";
    const double punctual = probabilities[kInstances];
    EXPECT_GT(world.lights->Statistics().tableBytes, 2 * bytes - 1000) << "grows by doubling";
    world.lights->RemovePunctual(2);
    probabilities = world.Probabilities();
    EXPECT_LT(probabilities[kInstances], 0.5 * punctual);
    EXPECT_EQ(world.lights->AddPunctual(scene::Light{}, true), 2u);
    // A material that begins to shine
    world.lights->SetEmission(1, glm::vec3(0.0f));
    EXPECT_FALSE(world.Probabilities().contains(4));
}

}  // namespace raygraph::testing::light_objects_test

// Emitting meshes that are placed often: the size of their tables, what a change uploads, and their light.
namespace raygraph::testing::mesh_lights_test {

using passes::TraceSettings;

namespace {

constexpr float kWhite = 0.8f, kRadiance = 3.0f, kHeight = 2.0f, kHalfSize = 0.3f;
constexpr uint32_t kCuts = 15;  // 450 triangles

// A panel of 450 triangles in the xy plane that emits from both sides.
scene::Mesh Panel() {
    scene::Mesh panel = QuadMesh(kHalfSize, 1);
    scene::Primitive& primitive = panel.primitives[0];
    primitive.positions.clear();
    primitive.normals.clear();
    primitive.indices.clear();
    for (uint32_t row = 0; row <= kCuts; ++row)
        for (uint32_t column = 0; column <= kCuts; ++column) {
            primitive.positions.push_back(kHalfSize * glm::vec3(2.0f * float(column) / kCuts - 1.0f,
                                                                2.0f * float(row) / kCuts - 1.0f, 0.0f));
            primitive.normals.emplace_back(0.0f, 0.0f, 1.0f);
        }
    for (uint32_t row = 0; row < kCuts; ++row)
        for (uint32_t column = 0; column < kCuts; ++column) {
            const uint32_t a = row * (kCuts + 1) + column, b = a + 1, c = a + kCuts + 1, d = c + 1;
            for (const uint32_t index : {a, b, d, a, d, c}) primitive.indices.push_back(index);
        }
    return panel;
}

// Some turned, some stretched, some mirrored; all parallel to the floor.
glm::mat4x3 PanelAt(uint32_t index, float x, float y) {
    const float stretch = index % 3 == 0 ? 1.4f : 1.0f, side = index % 4 == 0 ? -1.0f : 1.0f;
    const float angle = 0.1f * float(index % 7);
    const glm::vec3 u(std::cos(angle), std::sin(angle), 0.0f), v(-u.y, u.x, 0.0f);
    return {side * stretch * u, v, {0, 0, 1}, {x, y, kHeight}};
}

// Lambert's formula, for a receiver at the origin that faces +z.
double IrradianceOf(const glm::mat4x3& placed) {
    double sum = 0.0;
    glm::dvec3 corners[4];
    for (int i = 0; i < 4; ++i) {
        const double x = i == 0 || i == 3 ? -1.0 : 1.0, y = i < 2 ? -1.0 : 1.0;
        corners[i] =
            glm::normalize(glm::dmat4x3(placed) * glm::dvec4(x * kHalfSize, y * kHalfSize, 0.0, 1.0));
    }
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 across = glm::cross(corners[i], corners[(i + 1) % 4]);
        const double sine = glm::length(across);
        sum += std::atan2(sine, glm::dot(corners[i], corners[(i + 1) % 4])) * across.z / sine;
    }
    return 0.5 * kRadiance * std::abs(sum);
}

// Instance 0 is a wall at the origin, so small that all of it is lit as its middle is; the others are panels.
scene::SceneData Panels(uint32_t count) {
    scene::SceneData scene = SceneOf({QuadMesh(0.001f, 0), Panel()},
                                     {Lambert(glm::vec3(kWhite)), Lambert({}, glm::vec3(kRadiance))});
    scene.instances.resize(1);
    const auto side = static_cast<uint32_t>(std::ceil(std::sqrt(double(count))));
    for (uint32_t i = 0; i < count; ++i)
        scene.instances.push_back({.mesh = 1,
                                   .objectToWorld = PanelAt(i, float(i % side) - 0.5f * float(side - 1),
                                                            float(i / side) - 0.5f * float(side - 1))});
    return scene;
}

double IrradianceOf(const std::vector<scene::Instance>& instances) {
    double sum = 0.0;
    for (size_t i = 1; i < instances.size(); ++i) sum += IrradianceOf(instances[i].objectToWorld);
    return sum;
}

class MeshLights : public VulkanTest {
  protected:
    static TraceSettings Settings() {
        TraceSettings settings = LookAt({0.5f, 0.0f, 0.5f}, {0, 0, 0}, 0.0005f, 32);
        settings.biases.maxDepth = 1;
        return settings;
    }
    void ExpectIrradiance(double expected, const TraceSettings& settings = Settings()) {
        const RenderedImage image = render.Render(settings, 64);
        const double radiance = expected * kWhite / std::numbers::pi;
        EXPECT_NEAR(image.mean.Mean().y, radiance, 0.005 * radiance + 3.0 * image.StandardErrorOfMean().y);
        EXPECT_LT(image.StandardErrorOfMean().y, 0.01 * radiance) << "too noisy to prove anything";
    }
    const GpuSceneStatistics& Statistics() const { return render.scene.Statistics(); }

    SceneRender render{Device()};
};

double Milliseconds(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

TEST_F(MeshLights, TablesOfAHundredThousandLampsAreSmallAndMovingOneUploadsItsPath) {
    constexpr uint32_t kCount = 100'000;
    scene::SceneData data = Panels(kCount);
    const std::vector<scene::Instance> instances = data.instances;
    const double expected = IrradianceOf(instances);
    const double set = Milliseconds([&] { render.scene.SetScene(std::move(data)); });
    const auto declare = [&] {
        render.renderer.BeginFrame();
        const double took = Milliseconds([&] { render.scene.Declare(render.renderer); });
        render.renderer.DropFrame();
        return took;
    };
    const double first = declare();
    EXPECT_LT(set + first, 20'000.0);
    EXPECT_EQ(Statistics().emissiveTriangleCount, uint64_t{kCount} * 2 * kCuts * kCuts);
    EXPECT_EQ(Statistics().lightCount, kCount);
    EXPECT_LT(Statistics().lightTableBytes, 25'000'000u) << "expanded they would be 9 GB";
    ExpectIrradiance(expected);

    // From above the wall to where no other is
    const uint32_t side = 317, instance = 1 + (side / 2) * side + side / 2;
    const glm::mat4x3 old = instances[instance].objectToWorld;
    glm::mat4x3 moved = old;
    moved[3] = glm::vec3(200.0f, 0.0f, kHeight);
    ASSERT_GT(IrradianceOf(old), 0.05 * expected);
    const GpuSceneStatistics before = Statistics();
    render.scene.SetTransform(instance, moved);
    const double move = declare();
    render.Render(Settings(), 1);
    EXPECT_EQ(Statistics().lightRebuilds, before.lightRebuilds);
    EXPECT_GT(Statistics().lightUpdates, before.lightUpdates);
    // Its leaf and the nodes above. The record is as it was
    const uint64_t uploaded = Statistics().lightBytesUploaded - before.lightBytesUploaded;
    EXPECT_LE(uploaded, 33 * sizeof(gpu::LightNode));
    EXPECT_GE(uploaded, 3 * sizeof(gpu::LightNode));
    ExpectIrradiance(expected - IrradianceOf(old) + IrradianceOf(moved));
    RecordProperty("setMilliseconds", std::to_string(set));
    RecordProperty("firstDeclareMilliseconds", std::to_string(first));
    RecordProperty("moveMilliseconds", std::to_string(move));
    RecordProperty("moveBytes", std::to_string(uploaded));
    RecordProperty("tableBytes", std::to_string(Statistics().lightTableBytes));
}

// Twelve lamps are few, but too many triangles to be lights of their own.
TEST_F(MeshLights, EverySamplerAndStrategyFindsTheirLight) {
    scene::SceneData data = Panels(12);
    const double expected = IrradianceOf(data.instances);
    render.scene.SetScene(std::move(data));
    TraceSettings settings = Settings();
    for (const LightSampler sampler : {LightSampler::Uniform, LightSampler::Power, LightSampler::Bvh}) {
        settings.lights.sampler = sampler;
        ExpectIrradiance(expected, settings);
    }
    settings.lights.mis = MisHeuristic::Off;
    ExpectIrradiance(expected, settings);
    EXPECT_EQ(Statistics().lightCount, 12u);
    EXPECT_EQ(Statistics().emissiveTriangleCount, 12u * 450u);
    // Hidden lamps do not shine, alone or with the whole mesh's material
    render.scene.SetVisible(5, false);
    EXPECT_EQ((render.Render(Settings(), 1), Statistics().lightCount), 11u);
    EXPECT_EQ(Statistics().emissiveTriangleCount, 11u * 450u);
    render.scene.SetVisible(5, true);
    render.scene.SetMaterial(1, Lambert({}, glm::vec3(2.0f * kRadiance)));
    ExpectIrradiance(2.0 * expected);
    render.scene.SetMaterial(1, Lambert({}));
    EXPECT_EQ(render.Render(Settings(), 1).mean.Mean().y, 0.0);
}

// Trees of this many lights are updated where they can be; smaller ones are always rebuilt.
constexpr uint32_t kMany = 1100;

// A render does not depend on what moved, went and came before; a view may.
TEST_F(MeshLights, PicturesOfTheRuleAlwaysDoNotDependOnWhatWasShownBefore) {
    const auto picture = [&](LightRule rule, bool isEdited) {
        SceneRender other(Device(), {.lightRule = rule});
        scene::SceneData data = Panels(kMany);
        const glm::mat4x3 last = data.instances[3].objectToWorld;
        other.scene.SetScene(std::move(data));
        if (isEdited) other.scene.SetTransform(3, PanelAt(5, -3.0f, 0.5f));
        other.Render(Settings(), 1);
        if (isEdited) {
            other.scene.SetVisible(7, false);
            other.Render(Settings(), 1);
            other.scene.SetVisible(7, true);
            other.scene.SetTransform(3, PanelAt(5, 2.0f, 0.5f));
            other.Render(Settings(), 1);
            other.scene.SetTransform(3, last);
        }
        const RenderedImage image = other.Render(Settings(), 16);
        const uint64_t rebuilds = other.scene.Statistics().lightRebuilds;
        EXPECT_EQ(rebuilds, !isEdited || rule == LightRule::Decay ? 1u : 4u);
        return image.mean;
    };
    const FloatImage set = picture(LightRule::Always, false);
    EXPECT_EQ(picture(LightRule::Always, true).values, set.values);
    const double viewed = picture(LightRule::Decay, true).Mean().y;
    EXPECT_NEAR(viewed, set.Mean().y, 0.02 * viewed);
}

// Nothing of it is updated that does not change, and what decays is built again.
TEST_F(MeshLights, TreeIsRebuiltWhenUpdatesHaveDecayedIt) {
    render.scene.SetScene(Panels(kMany));
    render.Render(Settings(), 1);
    const uint64_t rebuilds = Statistics().lightRebuilds;
    // Each by little, and then to the place of one that is far in the tree
    for (uint32_t i = 1; i <= kMany; ++i)
        render.scene.SetTransform(i,
                                  PanelAt(i - 1, float((i - 1) % 34) - 16.45f, float((i - 1) / 34) - 16.55f));
    render.Render(Settings(), 1);
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds);
    for (uint32_t i = 1; i <= kMany; ++i) {
        const uint32_t place = i * 37 % (kMany + 1);
        render.scene.SetTransform(i, PanelAt(i - 1, float(place % 34) - 16.5f, float(place / 34) - 16.5f));
    }
    render.Render(Settings(), 1);
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds + 1);
}

// One that goes leaves the others as they are, and one that comes takes its place.
TEST_F(MeshLights, LampsComeAndGoInPlace) {
    scene::SceneData data = Panels(kMany);
    const std::vector<scene::Instance> all = data.instances;
    constexpr uint32_t kGone = 1 + 16 * 34 + 17;
    const double whole = IrradianceOf(all), own = IrradianceOf(all[kGone].objectToWorld);
    ASSERT_GT(own, 0.05 * whole);
    render.scene.SetScene(std::move(data));
    render.Render(Settings(), 1);
    const uint64_t rebuilds = Statistics().lightRebuilds;
    render.scene.RemoveInstance(kGone);
    ExpectIrradiance(whole - own);
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds);
    EXPECT_EQ(Statistics().lightCount, kMany - 1);
    EXPECT_EQ(render.scene.AddInstance(1, scene::PlacedTransform{all[kGone].objectToWorld}), kGone);
    ExpectIrradiance(whole);
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds);
    // One more has no number yet
    (void)render.scene.AddInstance(1, scene::PlacedTransform{PanelAt(1, 0.0f, 20.0f)});
    ExpectIrradiance(whole + IrradianceOf(PanelAt(1, 0.0f, 20.0f)));
    EXPECT_EQ(Statistics().lightRebuilds, rebuilds + 1);
    EXPECT_EQ(Statistics().lightCount, kMany + 1);
}

}  // namespace raygraph::testing::mesh_lights_test
