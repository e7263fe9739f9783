// LightSet as objects come and go: its tables are those of a set that had them from the start.
#include <cstring>
#include <map>

#include "renderer/gpu_scene/lights/light_set.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

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
