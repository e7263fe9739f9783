// From the nodes of a glTF file to what is seen: which meshes are there, where, and whether they shine.
#include <set>

#include "passes/raster.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::imported_nodes_test {

namespace {

using test::GltfDocument;
using test::Json;

// A view along -z that is six high around the origin, of 24 pixels: four of them a unit.
passes::TraceSettings Facing() {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 6.0f;
    passes::TraceSettings settings;
    settings.extent = {24, 24};
    settings.camera = ToRecord(view);
    return settings;
}

// Red, where the pixel shows the point.
float SeenAt(const FloatImage& image, float x, float y) {
    return image.At(uint32_t((x + 3.0f) * 4.0f), uint32_t((3.0f - y) * 4.0f)).x;
}

// A triangle with its corner at a node's origin, which shines.
GltfDocument ShiningTriangle() {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial({{"emissiveFactor", {1, 1, 1}}});
    return document;
}

class ImportedNodes : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

}  // namespace

TEST_F(ImportedNodes, EachOfTheInstancesOfANodeIsSeenAndShines) {
    GltfDocument document = ShiningTriangle();
    const size_t places = document.AddAccessor<float>({-2, 0, 0, 0, 0, 0, 1, 1, 0}, 3);
    document.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = places;
    render.scene.SetScene(test::Load(document));
    const FloatImage radiance = render.TraceOnce(Facing());
    for (const glm::vec2 corner : {glm::vec2(-2, 0), glm::vec2(0, 0), glm::vec2(1, 1)})
        EXPECT_EQ(SeenAt(radiance, corner.x + 0.3f, corner.y + 0.3f), 1.0f) << corner.x;
    EXPECT_EQ(SeenAt(radiance, -0.7f, 0.3f), 0.0f);
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 3u);
    std::set<uint32_t> instances;
    for (const glm::uvec4& id : render.PrimaryHits(Facing()).ids) instances.insert(id.x);
    EXPECT_EQ(instances.size(), 4u) << "three, and none";
}

// Two nodes, each with a triangle that shines and one with a light, of which the second is hidden and shown.
TEST_F(ImportedNodes, HiddenNodesAreNotSeenAndDoNotShine) {
    GltfDocument document = ShiningTriangle();
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({{{"type", "point"}}});
    document.AddNode({{"translation", {-2, 0, 0}},
                      {"children", {2}},
                      {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
    document.Add("nodes", {{"mesh", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    render.scene.SetScene(test::Load(document));
    const auto expectSeen = [&](float hidden) {
        const FloatImage radiance = render.TraceOnce(Facing());
        EXPECT_EQ(SeenAt(radiance, 0.3f, 0.3f), 1.0f);
        EXPECT_EQ(SeenAt(radiance, -1.7f, 0.3f), hidden);
    };
    expectSeen(0.0f);
    EXPECT_FALSE(render.scene.IsVisible(1));
    EXPECT_FALSE(render.scene.IsLightVisible(0));
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 1u);
    EXPECT_EQ(render.scene.Statistics().lightCount, 1u);
    render.scene.SetVisible(1, true);
    const SceneRevisions before = render.scene.Revisions();
    render.scene.SetLightVisible(0, true);
    EXPECT_EQ(render.scene.Revisions().lights, before.lights + 1);
    render.scene.SetLightVisible(0, true);
    EXPECT_EQ(render.scene.Revisions().lights, before.lights + 1) << "changes nothing";
    expectSeen(1.0f);
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 2u);
    EXPECT_EQ(render.scene.Statistics().lightCount, 3u);
    EXPECT_THROW(render.scene.SetLightVisible(1, true), Error);
}

// A white floor under a light that is hidden, in both views.
TEST_F(ImportedNodes, HiddenLightLightsNothing) {
    GltfDocument document;
    document.AddTriangle()["material"] =
        document.AddMaterial({{"pbrMetallicRoughness", {{"metallicFactor", 0}}}});
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({{{"type", "point"}}});
    document.AddNode(
        {{"translation", {0.3f, 0.3f, 1}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    render.scene.SetScene(test::Load(document));
    passes::FilteredEnvironment environment{"environment"};
    const auto raster = [&] {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, Facing(), passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, Facing(), seen, environment, {}));
        render.renderer.Execute();
        return SeenAt(ToFloatImage(drawn), 0.3f, 0.3f);
    };
    EXPECT_GT(SeenAt(render.TraceOnce(Facing()), 0.3f, 0.3f), 0.1f);
    EXPECT_GT(raster(), 0.1f);
    render.scene.SetLightVisible(0, false);
    EXPECT_EQ(SeenAt(render.TraceOnce(Facing()), 0.3f, 0.3f), 0.0f);
    EXPECT_EQ(raster(), 0.0f);
}

}  // namespace raygraph::testing::imported_nodes_test
