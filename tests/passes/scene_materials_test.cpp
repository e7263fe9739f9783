// What pipelines need for the materials of a scene is found when something has changed, and only then.
#include "renderer/gpu_scene/materials/scene_materials.h"

#include "renderer/gpu_scene/deform/deform_resources.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/lights/environment_upload.h"
#include "renderer/gpu_scene/materials/material_records.h"
#include "rhi/blas_builder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::scene_materials_test {
namespace {

scene::Material Metal() {
    scene::Material metal;
    metal.metallicFactor = metal.roughnessFactor = 1.0f;
    return metal;
}

scene::Material Glass() {
    scene::Material glass = Metal();
    glass.metallicFactor = 0.0f;
    glass.transmissionFactor = 1.0f;
    return glass;
}

class SceneMaterialsTest : public VulkanTest {
  protected:
    rhi::Uploader uploader{Device()};
    rhi::BlasBuilder builder{Device()};
    std::shared_ptr<const rhi::Texture> white =
        std::make_shared<rhi::Texture>(WhiteTexture(Device(), uploader));
    rhi::Sampler sampler = Device().CreateSampler({.name = "sampler"});
    SceneMaterials materials{Device(), *white, sampler, 1.0f};
    SceneGeometry geometry{Device()};
    Renderer renderer{Device()};

    uint32_t AddMesh(GroupPart&& part) {
        std::vector<GroupResources> mesh(1);
        mesh.front().parts.push_back(std::move(part));
        mesh.front().records.emplace_back();
        return geometry.AddMesh(std::move(mesh), materials);
    }
    TraceFeatures Declare() {
        renderer.BeginFrame();
        SceneIds ids;
        materials.Declare(renderer, ids, geometry);
        renderer.Execute();
        return ids.features;
    }
    // Of a frame after a change; the one after it finds nothing again.
    void ExpectChanged(const char* what, TraceFeatures features) {
        const uint64_t before = materials.FeatureUpdates();
        EXPECT_EQ(Declare(), features) << what;
        EXPECT_EQ(Declare(), features) << what;
        EXPECT_EQ(materials.FeatureUpdates(), before + 1) << what;
    }
};

TEST_F(SceneMaterialsTest, FeaturesAreFoundAfterEachKindOfChangeAlone) {
    ExpectChanged("nothing is there", {});
    const std::vector<scene::Material> added{Metal(), Glass()};
    const std::vector<uint32_t> numbers = materials.Add(added, {});
    EXPECT_EQ(Declare(), TraceFeatures{}) << "no mesh uses them";
    EXPECT_EQ(materials.FeatureUpdates(), 1u);

    const uint32_t mesh = AddMesh({.material = numbers[0]});
    ExpectChanged("a mesh has come", kTraceMetals);
    const uint32_t painted =
        AddMesh({.material = numbers[0],
                 .variants = {{.material = numbers[0]}, {.variant = 0, .material = numbers[1]}}});
    ExpectChanged("another one has come", kTraceMetals);
    EXPECT_EQ(materials.PartCount(numbers[0]), 2u);
    EXPECT_EQ(materials.PartCount(numbers[1]), 1u) << "of a variant that is not shown";

    ChangeVariant(geometry, materials, builder, 0);
    ExpectChanged("a variant is shown", kTraceMetals | kTraceGlass);
    const gpu::MaterialRecord record = ToRecord(Glass(), materials.Records()[numbers[0]]);
    ChangeMaterial(geometry, materials, builder, numbers[0], record);
    ExpectChanged("a material was edited", kTraceGlass);

    const SceneTexture texture{std::make_shared<SceneImage>(SceneImage{.hostTexture = white}), {}};
    const uint32_t number = materials.AddTextures({&texture, 1}).front();
    ExpectChanged("a texture has come", kTraceGlass | kTraceTextures);
    materials.RemoveTexture(number);
    ExpectChanged("a texture has gone", kTraceGlass);

    geometry.RemoveMesh(mesh, materials);
    ExpectChanged("a mesh has gone", kTraceGlass);
    geometry.RemoveMesh(painted, materials);
    ExpectChanged("all have gone", {});
    EXPECT_EQ(materials.PartCount(numbers[0]), 0u);
}

}  // namespace
}  // namespace raygraph::testing::scene_materials_test
