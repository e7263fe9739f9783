// GpuScene: deforming meshes of several primitives, large ones, mirrored ones and broken ones.
#include <limits>

#include "renderer/scene/model/check.h"
#include "shaders/shared/deform_records.h"
#include "tests/passes/deform_fixture.h"

namespace raygraph::testing::deform_parts_test {

namespace {

scene::Primitive SheetAt(float x, const SheetOptions& options, uint32_t material) {
    scene::Primitive sheet = Sheet(options, material).primitives[0];
    sheet.bounds = {};
    for (glm::vec3& position : sheet.positions) {
        position.x = 0.3f * position.x + x;
        sheet.bounds.Extend(position);
    }
    scene::UpdateDeformationBounds(sheet);
    return sheet;
}

// One mesh, placed with two skins. Of its primitives three share a group with other influences each, one that
// no joint moves among them; one has a group of its own, and one a group that does not deform. Vertices are
// of odd numbers.
scene::SceneData SceneOfParts() {
    scene::SceneData scene = SheetScene({.influences = 2, .targets = 1});
    std::vector<scene::Primitive>& parts = scene.meshes[0].primitives;
    parts = {
        SheetAt(-0.8f, {.influences = 2, .targets = 1, .cells = {3, 5}}, 0),
        SheetAt(-0.4f, {.influences = 0, .cells = {1, 7}}, 0),
        SheetAt(0.0f, {.influences = 3, .targets = 1, .isFlat = true, .cells = {5, 3}}, 0),
        SheetAt(0.4f, {.influences = 5, .cells = {1, 9}}, 1),
        SheetAt(0.8f, {.influences = 0, .cells = {3, 3}}, 2),
    };
    parts[1].influences = {};
    scene::Material blended = Lambert(glm::vec3(0.9f)), oneSided = Lambert(glm::vec3(0.3f));
    blended.alphaMode = scene::AlphaMode::Blend;
    blended.baseColorFactor.a = 0.999f;
    oneSided.isDoubleSided = false;
    scene.materials.push_back(blended);
    scene.materials.push_back(oneSided);
    scene.nodes.resize(10);
    for (uint32_t joint = 5; joint < 9; ++joint) {
        scene.nodes[joint] = scene.nodes[joint - 5];
        if (joint > 5) scene.nodes[joint].parent = joint - 1;
    }
    scene.nodes[5].translation = {2.2f, 0.5f, 0};
    scene.nodes[9].mesh = 0;
    scene.nodes[9].skin = 1;
    for (uint32_t node = 5; node < 10; ++node) scene.nodeOrder.push_back(node);
    scene.skins.push_back(scene.skins[0]);
    for (uint32_t& joint : scene.skins[1].joints) joint += 5;
    scene.instances.push_back({.mesh = 0, .node = 9});
    scene::DeformInstances(scene);
    return scene;
}

}  // namespace

TEST_F(DeformTest, PartsOfGroupsAndCopiesAreDeformedEachByItsOwn) {
    PosedScene posed(SceneOfParts());
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    const passes::TraceSettings view = LookAt({1, 2.5f, 13}, {1, 2, 0}, 0.6f, 96);
    SceneRender still(Device());
    for (const double seconds : {0.0, 0.7}) {
        SCOPED_TRACE(seconds);
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds));
        std::vector<Group> expected;
        for (const uint32_t instance : {0u, 1u})
            for (const std::vector<uint32_t>& parts : {std::vector{0u, 1u, 2u}, {3u}}) {
                Group& group = expected.emplace_back();
                for (const uint32_t part : parts) group.push_back(posed.Streams(instance, part));
            }
        const std::vector<Group> actual = OnDevice(expected);
        for (size_t group = 0; group < expected.size(); ++group)
            for (size_t part = 0; part < expected[group].size(); ++part) {
                SCOPED_TRACE(::testing::Message() << "group " << group << ", part " << part);
                ExpectNear(actual[group][part], expected[group][part]);
            }
        still.scene.SetScene(posed.Frozen());
        const SceneRender::Hits traced = render.PrimaryHits(view);
        ExpectSameHits(traced, still.PrimaryHits(view), 4);
        ExpectSameHits(Drawn(view), traced, 60);
    }
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 2u);
    EXPECT_EQ(render.scene.Statistics().blasCount, 5u) << "what does not deform is shared";
}

// Joints that mirror: the object space of the instance is mirrored in turn.
TEST_F(DeformTest, MirroredFiguresKeepTheirFront) {
    scene::Material oneSided = Lambert(glm::vec3(0.5f));
    oneSided.isDoubleSided = false;
    scene::SceneData scene = SheetScene({.influences = 3, .targets = 1}, oneSided);
    scene.nodes[0].scale = {-1.2f, 0.9f, 1.0f};
    scene.nodes[0].translation = {0.2f, 0.3f, -0.1f};
    scene::DeformInstances(scene);
    ASSERT_TRUE(scene.instances[0].IsMirrored());
    PosedScene posed(std::move(scene));
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    SceneRender still(Device());
    for (const double seconds : {0.0, 0.6}) {
        SCOPED_TRACE(seconds);
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds));
        ExpectNear(OnDevice(posed.Streams()), posed.Streams());
        still.scene.SetScene(posed.Frozen());
        const SceneRender::Hits traced = render.PrimaryHits(Front());
        ExpectSameHits(traced, still.PrimaryHits(Front()), 2);
        ExpectSameHits(Drawn(Front()), traced, 20);
    }
}

// A host's matrices may take vertices beyond the numbers. These stay where the base shape has them; what
// moves by other joints is drawn where it is.
TEST_F(DeformTest, VerticesBeyondTheNumbersStayAndOthersAreDrawn) {
    scene::SceneData scene = SheetScene({.influences = 1, .cells = {5, 24}});  // none at x = 0
    const float huge = std::numeric_limits<float>::max();
    std::vector<glm::mat4x3> matrices(4, Translation({30, 0, 0}));
    matrices[0] = {{huge, huge, 0}, {0, 1, 0}, {0, 0, 1}, {huge, -huge, 0}};
    const scene::Primitive& sheet = scene.meshes[0].primitives[0];
    scene::DeformedStreams expected;
    expected.positions = sheet.positions;
    size_t stayed = 0;
    for (size_t i = 0; i < sheet.positions.size(); ++i) {
        if (sheet.influences.joints[i] != 0) {
            expected.positions[i] += glm::vec3(30, 0, 0);
            continue;
        }
        ++stayed;
        const glm::vec3 beyond = matrices[0] * glm::vec4(sheet.positions[i], 1.0f);
        ASSERT_FALSE(scene::IsFinite(beyond));
    }
    ASSERT_GT(stayed, 20u);
    render.scene.SetScene(std::move(scene));
    render.scene.SetJointMatrices(0, matrices);
    const scene::DeformedStreams actual = OnDevice(expected);
    for (size_t i = 0; i < expected.positions.size(); ++i)
        ASSERT_EQ(actual.positions[i], expected.positions[i]) << i;
    const passes::TraceSettings there = LookAt({30, 2.5f, 9}, {30, 2.5f, 0}, 0.7f, 48);
    ExpectSameHits(Drawn(there), render.PrimaryHits(there), 20, 40.0f);
}

// More groups of vertices than a row of a dispatch has, and records on both sides of its end.
TEST_F(DeformTest, MeshesOfMillionsOfVerticesAreDeformedToTheLast) {
    constexpr uint32_t kCount = gpu::kDeformRowGroups * gpu::kDeformGroupSize + 3 * 100;
    scene::SceneData scene = SheetScene({.influences = 0, .targets = 1});
    scene::Primitive large;
    large.material = 0;
    large.positions.resize(kCount);
    for (uint32_t i = 0; i < kCount; ++i) large.positions[i] = glm::vec3(i % 1024, i / 1024, i % 3) / 1024.0f;
    large.normals.assign(kCount, {0, 0, 1});
    large.targets.resize(1);
    large.targets[0].positions.assign(kCount, {0, 0, 1});
    large.indices = {0, 1, 2, kCount - 3, kCount - 2, kCount - 1};
    large.bounds = {glm::vec3(0.0f), glm::vec3(4.0f)};
    scene::UpdateDeformationBounds(large);
    std::vector<scene::Primitive>& parts = scene.meshes[0].primitives;
    const scene::Primitive small = parts[0];
    parts.insert(parts.begin(), large);
    render.scene.SetScene(std::move(scene));
    render.scene.SetMorphWeights(0, std::array{0.5f});
    scene::DeformedStreams ofSmall;
    scene::DeformPrimitive(small, std::array{0.5f}, {}, ofSmall);
    for (glm::vec3& position : large.positions) position.z += 0.5f;
    const std::vector<Group> actual =
        OnDevice({{scene::DeformedStreams{large.positions, large.normals, {}}, ofSmall}});
    const std::vector<glm::vec3>& positions = actual[0][0].positions;
    size_t others = 0;
    for (uint32_t i = 0; i < kCount; ++i) others += positions[i] == large.positions[i] ? 0 : 1;
    EXPECT_EQ(others, 0u);
    ExpectNear(actual[0][1], ofSmall);
}

}  // namespace raygraph::testing::deform_parts_test
