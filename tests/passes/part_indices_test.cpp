// Indices that are used again: parts, poses and light groups mean what had them, not what has them now.
#include "renderer/scene/animation/pose_applier.h"
#include "tests/passes/scene_parts.h"
#include "tests/support/error_of.h"

namespace raygraph::testing::part_indices_test {

TEST_F(SceneParts, PartsRemoveWhatIsStillTheirs) {
    const AddedPart part = render.scene.Add(SquareOf(1, 1, true));
    render.scene.RemoveInstance(part.instances[0]);
    EXPECT_EQ(render.scene.AddInstance(0, scene::PlacedTransform{Translation(PartPlace(2))}),
              part.instances[0]);
    render.scene.Remove(part);
    std::vector<Cell> expected(kCells);
    expected[0] = {0, ColorOf(0)};
    expected[2] = {part.instances[0], ColorOf(0)};
    EXPECT_EQ(Seen(), expected);
    // Its mesh, material and texture have gone, and another part has their indices
    const AddedPart other = render.scene.Add(SquareOf(3, 3, true));
    EXPECT_EQ(other.meshes, part.meshes);
    EXPECT_EQ(other.textures, part.textures);
    render.scene.Remove(part);
    expected[3] = {other.instances[0], ColorOf(3)};
    EXPECT_EQ(Seen(), expected);
    // Of another scene
    render.scene.SetScene(
        SceneOf({QuadMesh(0.4f), QuadMesh(0.4f), QuadMesh(0.4f)}, {Lambert(ColorOf(4))},
                {Translation(PartPlace(4)), Translation(PartPlace(5)), Translation(PartPlace(6))}));
    render.scene.Remove(part);
    render.scene.Remove(other);
    render.scene.Remove(AddedPart{});
    const std::vector<Cell> seen = Seen();
    for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(seen[4 + i], (Cell{i, ColorOf(4)}));
}

TEST_F(SceneParts, PartsRemoveTheirOwnLights) {
    scene::SceneData data;
    data.lights.resize(2);
    const AddedPart part = render.scene.Add(std::move(data));
    EXPECT_EQ(render.scene.Statistics().instanceCount, 1u);
    render.scene.RemoveLight(part.lights[1]);
    scene::Light light;
    light.intensity = 7.0f;
    EXPECT_EQ(render.scene.AddLight(light), part.lights[1]);
    render.scene.Remove(part);
    EXPECT_EQ(render.scene.Light(part.lights[1]).intensity, 7.0f);
    EXPECT_EQ(ErrorTextOf([&] { (void)render.scene.Light(part.lights[0]); }),
              "GpuScene: light 0 has been removed");
}

TEST_F(SceneParts, PosesMoveWhatTheSceneBrought) {
    scene::SceneData data =
        SceneOf({QuadMesh(0.4f), QuadMesh(0.4f)}, {Lambert(ColorOf(1)), Lambert(ColorOf(2))},
                {Translation(PartPlace(1)), Translation(PartPlace(2))});
    data.nodes.resize(3);
    data.nodeOrder = {0, 1, 2};
    for (uint32_t i = 0; i < 2; ++i) {
        data.nodes[i].translation = PartPlace(1 + i);
        data.instances[i].node = i;
    }
    data.lights.resize(1);
    data.lights[0].node = 2;
    scene::SceneData posed = scene::PoseOutline(data);
    scene::PoseApplier applier(posed);
    render.scene.SetScene(std::move(data));
    render.scene.RemoveInstance(1);
    render.scene.RemoveMaterial(1);
    render.scene.RemoveLight(0);
    ASSERT_EQ(render.scene.AddMaterial(Lambert(ColorOf(7))), 1u);
    const uint32_t mesh = render.scene.AddMesh(QuadMesh(0.4f, 1));
    ASSERT_EQ(render.scene.AddInstance(mesh, scene::PlacedTransform{Translation(PartPlace(5))}), 1u);
    scene::Light light;
    light.intensity = 7.0f;
    ASSERT_EQ(render.scene.AddLight(light), 0u);
    posed.nodes[0].translation = PartPlace(3);
    posed.instances[0].objectToWorld = Translation(PartPlace(3));
    posed.instances[1].objectToWorld = Translation(PartPlace(4));
    posed.materials[0] = Lambert(ColorOf(8));
    posed.materials[1] = Lambert(ColorOf(9));
    posed.lights[0].intensity = 9.0f;
    render.scene.SetPose(posed, applier);
    std::vector<Cell> expected(kCells);
    expected[3] = {0, ColorOf(8)};
    expected[5] = {1, ColorOf(7)};
    EXPECT_EQ(Seen(), expected);
    EXPECT_EQ(render.scene.Light(0).intensity, 7.0f);
}

}  // namespace raygraph::testing::part_indices_test
