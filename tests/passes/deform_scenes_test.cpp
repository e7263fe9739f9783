#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/geometry/blas_set.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/passes/deforming_scene.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_memory.h"
#include "tests/support/reference_assets.h"

// GpuScene: scenes with deforming meshes, as copies, lamps, large ones and published ones.
namespace raygraph::testing::deform_scenes_test {

// The sheet four times: deformed by two skins, by the first one of these at another node, which is hidden, and
// not at all.
TEST_F(DeformTest, InstancesShareWhatDeformsThemAlike) {
    scene::SceneData scene = SheetScene({.influences = 2});
    scene.skins.push_back(scene.skins[0]);
    for (uint32_t& joint : scene.skins[1].joints) joint = 0;
    scene.nodes.resize(7);
    for (const uint32_t node : {5u, 6u}) {
        scene.nodes[node].mesh = 0;
        scene.nodes[node].skin = node == 5 ? 1 : 0;
        scene.nodeOrder.push_back(node);
        scene.instances.push_back({.mesh = 0, .node = node});
    }
    scene.instances.push_back({.mesh = 0, .objectToWorld = Translation({2, 0, 0})});
    scene.nodes[6].isVisible = false;  // it is where the first one is
    scene::DeformInstances(scene);
    EXPECT_FALSE(scene.instances[3].isDeformed);
    PosedScene posed(scene);
    render.scene.SetScene(std::move(scene));
    const passes::TraceSettings view = LookAt({0.5f, 2, 12}, {0.5f, 2, 0}, 0.6f, 48);
    render.PrimaryHits(view);
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 2u);
    EXPECT_EQ(render.scene.Statistics().blasCount, 3u);
    const uint64_t triangles = posed.scene.meshes[0].primitives[0].TriangleCount();
    EXPECT_EQ(render.scene.Statistics().trianglesUnique, triangles);
    EXPECT_EQ(render.scene.Statistics().trianglesPlaced, 4 * triangles);
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.6));
    const SceneRender::Hits hits = render.PrimaryHits(view);
    EXPECT_EQ(render.scene.Statistics().blasRefits + render.scene.Statistics().blasRebuilds, 1u)
        << "only the first skin has moved";
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    still.scene.SetVisible(2, false);
    ExpectSameHits(hits, still.PrimaryHits(view), 2);
}

// A host may place a mesh without a node: each instance has weights of its own.
TEST_F(DeformTest, InstancesWithoutANodeAreMorphed) {
    PosedScene posed(SheetScene({.influences = 0, .targets = 1}));
    scene::SceneData data = posed.scene;
    data.animations.clear();
    data.nodes.clear();
    data.nodeOrder.clear();
    data.instances[0].node = scene::kNone;
    data.instances.push_back(data.instances[0]);
    render.scene.SetScene(std::move(data));
    posed.scene.nodes[4].weights = {0.8f};
    render.scene.SetMorphWeights(0, posed.scene.nodes[4].weights);
    const scene::DeformedStreams first = posed.Streams();
    posed.scene.nodes[4].weights = {-0.3f};
    const scene::DeformedStreams second = posed.Streams();
    render.scene.SetMorphWeights(1, posed.scene.nodes[4].weights);
    const std::vector<Group> actual = OnDevice({{first}, {second}});
    ExpectNear(actual[0][0], first);
    ExpectNear(actual[1][0], second);
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 2u);
}

// A lamp that bends over a floor.
scene::SceneData LampScene() {
    scene::SceneData scene = SheetScene({.influences = 2, .targets = 1, .cells = {3, 8}},
                                        Lambert(glm::vec3(0.0f), glm::vec3(3.0f)));
    scene.materials.push_back(Lambert(glm::vec3(0.7f)));
    scene.meshes.push_back(QuadMesh(3.0f, 1));
    scene.instances.push_back({.mesh = 1, .objectToWorld = Translation({0, 2, -1.2f})});
    return scene;
}

TEST_F(DeformTest, ADeformingLampLightsAsItsFrozenPoseDoes) {
    PosedScene posed(LampScene());
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    passes::TraceSettings settings = LookAt({0, 2, 8}, {0, 2, 0}, 0.7f, 16);
    render.TraceOnce(settings);
    const auto changes = [&] {
        return render.scene.Statistics().lightRebuilds + render.scene.Statistics().lightUpdates;
    };
    const uint64_t before = changes();
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.6));
    const RenderedImage lit = render.Render(settings, 64);
    EXPECT_EQ(changes(), before + 1);
    EXPECT_EQ(render.scene.Statistics().emissiveTriangleCount, 48u);
    settings.lights.isOn = false;
    const RenderedImage found = render.Render(settings, 256);
    settings.lights.isOn = true;
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    still.scene.SetEnvironment({.radiance = glm::vec3(0.0f)});
    const RenderedImage frozen = still.Render(settings, 64);
    for (const auto& [a, b] : {std::pair{&lit, &frozen}, std::pair{&lit, &found}}) {
        const double error = glm::length(glm::dvec2(a->StandardErrorOfMean().x, b->StandardErrorOfMean().x));
        EXPECT_NEAR(a->mean.Mean().x, b->mean.Mean().x, 4.0 * error);
        EXPECT_LT(error, 0.02 * b->mean.Mean().x);
    }
    // Without MIS, a light that is elsewhere or shadowed by itself would show
    settings.lights.mis = MisHeuristic::Off;
    const RenderedImage sampled = render.Render(settings, 64), expected = still.Render(settings, 64);
    const double error =
        glm::length(glm::dvec2(sampled.StandardErrorOfMean().x, expected.StandardErrorOfMean().x));
    EXPECT_NEAR(sampled.mean.Mean().x, expected.mean.Mean().x, 4.0 * error);
}

// SetScene allocates the memory of poses: frames with next to no memory left still deform.
TEST_F(DeformTest, SceneThatDoesNotFitLeavesTheOldOneAndOneThatDoesCanBePosed) {
    const auto leaveMemory = [](uint64_t bytes) {
        Device().WaitIdle();
        Device().LimitMemory(Device().Memory().usedBytes + bytes);
    };
    constexpr uint64_t kStep = 2u << 20, kOfFrames = 512u << 10;
    PosedScene posed(SheetScene({.influences = 4, .targets = 1, .cells = {32, 128}}));
    render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))}));
    const SceneRender::Hits before = render.PrimaryHits(Front());
    uint32_t failureCount = 0;
    for (bool isSet = false; !isSet && failureCount < 32;) {
        leaveMemory(failureCount * kStep);
        try {
            scene::SceneData data = posed.scene;
            render.scene.SetScene(std::move(data));
            isSet = true;
        } catch (const Error& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
            ++failureCount;
            leaveMemory(kOfFrames);
            EXPECT_EQ(render.PrimaryHits(Front()).ids, before.ids);
        }
        Device().LimitMemory(0);
    }
    EXPECT_GE(failureCount, 2u);
    leaveMemory(kOfFrames);
    for (const double seconds : {0.0, 0.5, 1.0}) {
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds));
        EXPECT_NO_THROW(render.PrimaryHits(Front()));
    }
    Device().LimitMemory(0);
    ExpectNear(OnDevice(posed.Streams()), posed.Streams());
}

TEST_F(DeformTest, AWalkingFoxIsWhereTheCpuHasIt) {
    RAYGRAPH_SKIP_WITHOUT_ASSET_SCENES();
    scene::SceneData fox = scene::LoadGltf(*test::ReferenceAssets() / "scenes/known/Fox.glb");
    uint32_t walk = 0;
    while (fox.animations.at(walk).name != "Walk") ++walk;
    scene::DeformInstances(fox);
    PosedScene posed(fox);
    render.scene.SetScene(std::move(fox));
    const passes::TraceSettings settings = LookAt({180, 90, 160}, {0, 40, 0}, 0.7f, 96);
    SceneRender still(Device());
    for (const double seconds : {0.2, 0.5}) {
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds, walk));
        const SceneRender::Hits traced = render.PrimaryHits(settings);
        still.scene.SetScene(posed.Frozen());
        ExpectSameHits(traced, still.PrimaryHits(settings), 4, 160.0f);
        ExpectSameHits(Drawn(settings), traced, 40, 160.0f);
    }
}

}  // namespace raygraph::testing::deform_scenes_test

// GpuScene: deformed copies that nobody sees cost nothing, and what deformed leaves nothing behind.
namespace raygraph::testing::deform_hidden_test {

namespace {

// Two sheets with a skin each, side by side; clip 0 bends the first one. The second one glows.
scene::SceneData TwoFigures() {
    scene::SceneData scene = SheetScene({.influences = 2, .targets = 1});
    const auto first = static_cast<uint32_t>(scene.nodes.size());
    for (uint32_t joint = 0; joint < 5; ++joint) {
        scene::Node node = scene.nodes[joint];
        if (node.parent != scene::kNone) node.parent += first;
        if (joint == 0) node.translation = {1.5f, 0, 0};
        if (node.mesh != scene::kNone) node.mesh = node.skin = 1;
        scene.nodes.push_back(node);
        scene.nodeOrder.push_back(first + joint);
    }
    scene.skins.push_back(scene.skins[0]);
    for (uint32_t& joint : scene.skins[1].joints) joint += first;
    scene.meshes.push_back(scene.meshes[0]);
    scene.meshes[1].primitives[0].material = 1;
    scene.materials.push_back(Lambert(glm::vec3(0.2f), glm::vec3(1.0f)));
    scene.instances.push_back({.mesh = 1, .node = first + 4});
    scene::Animation& both = scene.animations.emplace_back(scene.animations[0]);
    for (const scene::AnimationChannel& channel : scene.animations[0].channels) {
        both.channels.push_back(channel);
        both.channels.back().target.object += first;
    }
    scene::DeformInstances(scene);
    return scene;
}

passes::TraceSettings BothFigures() {
    return LookAt({0.8f, 2.5f, 12.0f}, {0.8f, 2, 0}, 0.7f, 48);
}

}  // namespace

TEST_F(DeformTest, WhatNobodySeesIsDeformedOnceItIsShown) {
    constexpr uint32_t kBoth = 1;
    PosedScene posed(TwoFigures());
    scene::SceneData data = posed.scene;
    render.scene.SetScene(std::move(data));
    render.scene.SetVisible(1, false);
    for (int frame = 0; frame < 8; ++frame) render.PrimaryHits(BothFigures());  // past compaction
    ASSERT_TRUE(render.scene.IsSettled()) << "what is hidden is built as well";
    const GpuSceneStatistics before = render.scene.Statistics();
    const SceneRevisions revisions = render.scene.Revisions();
    posed.MoveTo(0.6, kBoth);
    for (const float x : {0.1f, 0.2f}) {
        std::vector<glm::mat4x3> matrices(posed.applier.JointMatricesOf(1).begin(),
                                          posed.applier.JointMatricesOf(1).end());
        matrices[3][3].x += x;
        render.scene.SetJointMatrices(1, matrices);
        render.scene.SetMorphWeights(1, std::array{x});
        EXPECT_TRUE(render.scene.IsSettled());
        EXPECT_EQ(render.scene.Revisions(), revisions) << "the picture stays as it is";
        render.PrimaryHits(BothFigures());
        EXPECT_EQ(render.scene.Statistics().deformations, before.deformations);
        EXPECT_EQ(render.scene.Statistics().blasRefits, before.blasRefits);
        EXPECT_EQ(render.scene.Statistics().lightRebuilds, before.lightRebuilds);
        EXPECT_EQ(render.scene.Statistics().lightUpdates, before.lightUpdates);
        EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None);
    }
    render.scene.SetPose(posed.scene, posed.applier);
    EXPECT_FALSE(render.scene.IsSettled()) << "it shows the second one";
    const SceneRender::Hits hits = render.PrimaryHits(BothFigures());
    EXPECT_TRUE(render.scene.IsSettled());
    const GpuSceneStatistics after = render.scene.Statistics();
    EXPECT_EQ(after.deformations, before.deformations + 1);
    EXPECT_EQ(after.blasRefits + after.blasRebuilds, before.blasRefits + before.blasRebuilds + 2);
    EXPECT_EQ(after.lightRebuilds + after.lightUpdates, before.lightRebuilds + before.lightUpdates + 1);
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    ExpectSameHits(hits, still.PrimaryHits(BothFigures()), 2);
    ExpectSameHits(Drawn(BothFigures()), hits, 20);
}

// Its first pose comes before its first frame, in which everything is built.
TEST_F(DeformTest, WhatIsHiddenFromTheStartIsBuiltInItsLatestPose) {
    PosedScene posed(TwoFigures());
    scene::SceneData data = posed.scene;
    data.nodes[9].isVisible = false;
    render.scene.SetScene(std::move(data));
    ASSERT_FALSE(render.scene.IsVisible(1));
    posed.MoveTo(0.6, 1);
    render.scene.SetJointMatrices(1, posed.applier.JointMatricesOf(1));
    render.scene.SetMorphWeights(1, scene::MorphWeights(posed.scene, posed.scene.instances[1]));
    render.PrimaryHits(BothFigures());
    EXPECT_EQ(render.scene.Statistics().deformations, 1u);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 2u);
    render.scene.SetPose(posed.scene, posed.applier);
    const SceneRender::Hits hits = render.PrimaryHits(BothFigures());
    EXPECT_EQ(render.scene.Statistics().blasRefits + render.scene.Statistics().blasRebuilds, 1u)
        << "the first one alone has moved since";
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    ExpectSameHits(hits, still.PrimaryHits(BothFigures()), 2);
}

// A host's mesh may have joints and no triangles.
TEST_F(DeformTest, WhatHasNoTrianglesIsSettled) {
    scene::SceneData scene = SheetScene({.influences = 2});
    scene.meshes[0].primitives[0].indices.clear();
    render.scene.SetScene(std::move(scene));
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 1u);
    for (int frame = 0; frame < 2; ++frame) {
        render.PrimaryHits(Front(8));
        EXPECT_TRUE(render.scene.IsSettled());
        EXPECT_EQ(render.renderer.DescribePlan().find(" Deform "), std::string::npos);
        render.scene.SetJointMatrices(0, std::vector<glm::mat4x3>(4, glm::mat4x3(2.0f)));
    }
}

TEST_F(DeformTest, AnEmptySceneLeavesNothingOfADeformingOne) {
    const auto usedBytes = [] {
        Device().WaitIdle();
        Device().CollectGarbage();
        return Device().Memory().usedBytes;
    };
    const scene::SceneData still = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f))});
    const auto show = [&](scene::SceneData data) {
        render.scene.SetScene(std::move(data));
        for (int frame = 0; frame < 4; ++frame) render.PrimaryHits(Front(8));
    };
    show(still);
    render.scene.SetScene({});
    const uint64_t empty = usedBytes();
    PosedScene posed(SheetScene({.influences = 4, .targets = 1, .cells = {32, 128}}));
    show(posed.scene);
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.5));
    render.PrimaryHits(Front(8));
    render.scene.SetScene({});
    EXPECT_EQ(usedBytes(), empty);
    show(still);
    const uint64_t ofStill = usedBytes();
    show(posed.scene);
    show(still);
    EXPECT_LE(usedBytes(), ofStill) << "beside another scene, too";
}

// Instances share what does not deform of a mesh, and do so when its sides change.
TEST_F(DeformTest, VariantsOfCopiesAreBuiltOnceWhereTheyShareAStructure) {
    scene::SceneData scene = TwoFigures();
    scene.variants = {"blended"};
    scene.materials.push_back(Lambert(glm::vec3(0.9f)));
    scene.materials[2].alphaMode = scene::AlphaMode::Blend;
    scene.materials[2].baseColorFactor.a = 0.999f;
    scene.instances[1].mesh = 0;
    scene.nodes[9].mesh = 0;
    scene.meshes.resize(1);
    scene::Primitive& wall = scene.meshes[0].primitives.emplace_back(QuadMesh(0.3f, 1).primitives[0]);
    for (scene::Primitive& primitive : scene.meshes[0].primitives)
        primitive.variants = {{0, 2}, {scene::kNone, primitive.material}};
    scene.materials[1].isDoubleSided = false;  // in a group of its own
    wall.positions[0].z += 0.01f;
    wall.bounds.Extend(wall.positions[0]);
    scene::DeformInstances(scene);
    PosedScene posed(scene);
    render.scene.SetScene(std::move(scene));
    render.PrimaryHits(BothFigures());
    EXPECT_EQ(render.scene.Statistics().deformedMeshes, 2u);
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 3u) << "a sheet each, and the wall";
    render.scene.SetVariant(0);
    render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(0.6, 1));
    const SceneRender::Hits hits = render.PrimaryHits(BothFigures());
    EXPECT_EQ(render.scene.Statistics().blasBuilds, 6u);
    EXPECT_EQ(render.scene.Statistics().blasCount, 3u);
    SceneRender still(Device());
    still.scene.SetScene(posed.Frozen());
    still.scene.SetVariant(0);
    ExpectSameHits(hits, still.PrimaryHits(BothFigures()), 20);
    ExpectSameHits(Drawn(BothFigures()), hits, 40);
}

}  // namespace raygraph::testing::deform_hidden_test

// The host knows where emitters of deformed groups are, how well, and the box of their vertices.
namespace raygraph::testing::deform_emitters_test {
namespace {

using glm::vec3;

struct Shape {
    GroupTriangles triangles;
    scene::Primitive primitive;
    std::vector<Emitter> emitters;
};

// Triangles about `center`, which all emit, with four joints and `targetCount` targets.
Shape Lamp(const vec3& center, uint32_t targetCount) {
    std::mt19937 engine(11);
    std::uniform_real_distribution<float> random(-1.0f, 1.0f);
    const auto vector = [&] { return vec3(random(engine), random(engine), random(engine)); };
    Shape shape;
    scene::Primitive& primitive = shape.primitive;
    primitive.influences.perVertex = 4;
    primitive.targets.resize(targetCount);
    for (uint32_t i = 0; i < 300; ++i) {
        primitive.positions.push_back(center + vector());
        primitive.indices.push_back(i);
        primitive.bounds.Extend(primitive.positions.back());
        for (scene::MorphTarget& target : primitive.targets) target.positions.push_back(1000.0f * vector());
        float sum = 0.0f;
        for (uint16_t joint = 0; joint < 4; ++joint) {
            const float weight = 0.1f + std::abs(random(engine));
            primitive.influences.joints.push_back(joint);
            primitive.influences.weights.push_back(weight);
            sum += weight;
        }
        for (size_t k = 4 * i; k < primitive.influences.weights.size(); ++k)
            primitive.influences.weights[k] /= sum;
        if (i % 3 == 0) shape.emitters.push_back({.primitive = i / 3});
    }
    scene::UpdateDeformationBounds(primitive);
    shape.triangles = {.positions = primitive.positions, .indices = primitive.indices, .firstVertices = {0}};
    return shape;
}

OutlinePose PoseOf(const Shape& shape, std::span<const float> weights,
                   std::span<const glm::mat4x3> matrices) {
    scene::Primitive primitive = shape.primitive;
    scene::Primitive* const primitives[] = {&primitive};
    OutlinePose pose;
    DeformOutline(shape.triangles, primitives, shape.emitters).Deform(weights, matrices, pose);
    return pose;
}

// Computes as a device may: products and sums are fused, in another order.
vec3 Fused(const scene::Primitive& primitive, size_t vertex, std::span<const float> weights,
           std::span<const glm::mat4x3> matrices) {
    vec3 p = primitive.positions[vertex];
    for (size_t t = weights.size(); t-- > 0;)
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = std::fma(weights[t], primitive.targets[t].positions[vertex][axis], p[axis]);
    glm::mat4x3 sum(0.0f);
    for (size_t k = 4; k-- > 0;)
        for (int column = 0; column < 4; ++column)
            for (int axis = 0; axis < 3; ++axis)
                sum[column][axis] = std::fma(
                    primitive.influences.weights[4 * vertex + k],
                    matrices[primitive.influences.joints[4 * vertex + k]][column][axis], sum[column][axis]);
    vec3 moved;
    for (int axis = 0; axis < 3; ++axis)
        moved[axis] = std::fma(sum[0][axis], p.x,
                               std::fma(sum[1][axis], p.y, std::fma(sum[2][axis], p.z, sum[3][axis])));
    return moved;
}

// Compares with the formula in double, and with the numbers that a device may compute.
void ExpectWithinError(const Shape& shape, std::span<const float> weights,
                       std::span<const glm::mat4x3> matrices, double sharpness) {
    std::vector<Emitter> emitters = shape.emitters;
    PoseEmitters(PoseOf(shape, weights, matrices), emitters);
    double worst = 0.0;
    for (size_t i = 0; i < emitters.size(); ++i) {
        const vec3 corners[] = {emitters[i].p0, emitters[i].p1, emitters[i].p2};
        for (size_t k = 0; k < 3; ++k) {
            const size_t vertex = 3 * i + k;
            glm::dvec3 p = shape.primitive.positions[vertex];
            for (size_t t = 0; t < weights.size(); ++t)
                p += double{weights[t]} * glm::dvec3(shape.primitive.targets[t].positions[vertex]);
            glm::dvec3 exact(0.0);
            for (size_t n = 4 * vertex; n < 4 * (vertex + 1); ++n)
                exact += double{shape.primitive.influences.weights[n]} *
                         (glm::dmat4x3(matrices[shape.primitive.influences.joints[n]]) * glm::dvec4(p, 1.0));
            const vec3 device = Fused(shape.primitive, vertex, weights, matrices);
            for (int axis = 0; axis < 3; ++axis) {
                ASSERT_LE(std::abs(corners[k][axis] - device[axis]), emitters[i].error) << vertex;
                ASSERT_LE(std::abs(double{corners[k][axis]} - exact[axis]), double{emitters[i].error});
                worst = std::max(worst, std::abs(double{corners[k][axis]} - exact[axis]));
            }
        }
    }
    EXPECT_LE(double{emitters[0].error}, sharpness * worst) << "a lamp would not light what is near it";
}

// A lamp that was modelled far from its joint, which takes it back to the origin: the result is small, and
// its rounding is that of the large terms.
TEST(DeformEmitters, AreWhereADeviceMayHaveThemThoughLargeTermsCancel) {
    const Shape shape = Lamp({1e4f, -2e4f, 5e3f}, 0);
    std::vector<glm::mat4x3> matrices;
    for (int joint = 0; joint < 4; ++joint) {
        const float angle = 0.4f * float(joint), c = std::cos(angle), s = std::sin(angle);
        const glm::mat3 turn(c, s, 0, -s, c, 0, 0, 0, 1);
        matrices.push_back(
            glm::mat4x3(turn[0], turn[1], turn[2], turn * vec3(-1e4f, 2e4f, -5e3f) + vec3(0, joint, 0)));
    }
    ExpectWithinError(shape, {}, matrices, 50.0);
    const OutlinePose pose = PoseOf(shape, {}, matrices);
    EXPECT_GT(pose.emitterError, 1e-3f);
    EXPECT_LT(glm::length(pose.emitters[0]), 10.0f);
}

TEST(DeformEmitters, AreWhereADeviceMayHaveThemThoughTargetsCancel) {
    const Shape shape = Lamp({0, 0, 0}, 2);
    Shape opposed = shape;
    for (size_t i = 0; i < shape.primitive.positions.size(); ++i)
        opposed.primitive.targets[1].positions[i] = -shape.primitive.targets[0].positions[i];
    scene::UpdateDeformationBounds(opposed.primitive);
    const std::vector<glm::mat4x3> still(4, glm::mat4x3(1.0f));
    ExpectWithinError(opposed, std::vector{0.7f, 0.7f}, still, 100.0);
}

TEST(DeformEmitters, AreExactWhereNothingIsLarge) {
    const Shape shape = Lamp({0, 0, 0}, 0);
    const std::vector<glm::mat4x3> still(4, glm::mat4x3(1.0f));
    EXPECT_LT(PoseOf(shape, {}, still).emitterError, 3e-6f);
}

// A joint that scales beyond the numbers: where its vertices are nobody knows, but the others are in the box.
TEST(DeformOutline, ItsBoxContainsWhatIsMovedByFiniteJoints) {
    Shape shape = Lamp({0, 0, 0}, 0);
    shape.primitive.influences.perVertex = 1;
    shape.primitive.influences.joints.clear();
    shape.primitive.influences.weights.assign(300, 1.0f);
    for (uint32_t i = 0; i < 300; ++i) shape.primitive.influences.joints.push_back(uint16_t(i / 150));
    scene::UpdateDeformationBounds(shape.primitive);
    const float huge = std::numeric_limits<float>::max();
    const std::vector<glm::mat4x3> matrices{
        glm::mat4x3(vec3(huge, 0, 0), vec3(0, huge, 0), vec3(0, 0, huge), vec3(2.0f)),
        glm::mat4x3(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(30, 0, 0))};
    const OutlinePose pose = PoseOf(shape, {}, matrices);
    EXPECT_TRUE(std::isfinite(pose.bounds.Radius()));
    for (size_t i = 150; i < 300; ++i) {
        const vec3 moved = shape.primitive.positions[i] + vec3(30, 0, 0);
        EXPECT_TRUE(glm::all(glm::lessThanEqual(pose.bounds.min, moved)) &&
                    glm::all(glm::greaterThanEqual(pose.bounds.max, moved)));
    }
}

}  // namespace
}  // namespace raygraph::testing::deform_emitters_test

// The measure by which deforming structures are rebuilt: what a rebuild would gain, and nothing else.
namespace raygraph::testing::refit_quality_test {
namespace {

using glm::vec3;

// Small triangles over a sheet 1 by 4.
std::vector<vec3> SheetSample() {
    std::mt19937 engine(3);
    std::uniform_real_distribution<float> random(0.0f, 1.0f);
    std::vector<vec3> corners;
    for (size_t i = 0; i < RefitQuality::kSampleCount; ++i) {
        const vec3 at(random(engine), 4.0f * random(engine), 0.0f);
        for (const vec3& corner : {vec3(0), vec3(0.05f, 0, 0), vec3(0, 0.05f, 0.01f)})
            corners.push_back(at + corner);
    }
    return corners;
}

template <typename Move>
std::vector<vec3> Moved(std::vector<vec3> corners, Move&& move) {
    for (vec3& corner : corners) corner = move(corner);
    return corners;
}

// Each triangle is where another one was.
std::vector<vec3> Scrambled(const std::vector<vec3>& corners) {
    std::vector<vec3> scrambled = corners;
    const size_t count = corners.size() / 3;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < 3; ++k) scrambled[3 * (i * 37 % count) + k] = corners[3 * i + k];
    return scrambled;
}

}  // namespace

TEST(RefitQuality, WhatMovesAsAWholeDoesNotDecay) {
    const std::vector<vec3> rest = SheetSample();
    RefitQuality quality;
    EXPECT_EQ(quality.Follow(rest), 1.0f);
    quality.OnBuild();
    EXPECT_EQ(quality.Follow(rest), 1.0f);
    const auto expectGood = [&](const std::vector<vec3>& corners, const char* what) {
        EXPECT_LT(quality.Follow(corners), RefitQuality::kMaxDecay) << what;
    };
    expectGood(Moved(rest, [](const vec3& p) { return p + vec3(100, -50, 7); }), "moved");
    expectGood(Moved(rest, [](const vec3& p) { return vec3(-p.y, p.x, p.z); }), "turned by a quarter");
    expectGood(Moved(rest, [](const vec3& p) { return vec3(p.x, 2.5f * p.y, p.z); }), "stretched");
    expectGood(
        Moved(rest, [](const vec3& p) { return vec3(p.x, std::sin(0.4f * p.y), std::cos(0.4f * p.y)); }),
        "bent");
}

TEST(RefitQuality, WhatIsScrambledDecaysUntilItIsBuiltAgain) {
    const std::vector<vec3> rest = SheetSample(), scrambled = Scrambled(rest);
    RefitQuality quality;
    quality.Follow(rest);
    quality.OnBuild();
    EXPECT_GT(quality.Follow(scrambled), 2.0f);
    quality.OnBuild();
    EXPECT_EQ(quality.Follow(scrambled), 1.0f);
    EXPECT_GT(quality.Follow(rest), 2.0f);
    quality.OnBuild();
    quality.OnBuild();  // of another structure, of the same pose
    EXPECT_EQ(quality.Follow(rest), 1.0f);
    EXPECT_GT(quality.Follow(scrambled), 2.0f) << "the build was that of the other pose";
}

// It is told of builds once a frame has been submitted: a failure would end the program.
TEST(RefitQuality, BuildsAreNotedWithoutMemory) {
    const std::vector<vec3> rest = SheetSample(), scrambled = Scrambled(rest);
    RefitQuality quality;
    quality.Follow(rest);
    {
        const FailingMemory none(0);
        quality.OnBuild();
    }
    EXPECT_GT(quality.Follow(scrambled), 2.0f);
    {
        const FailingMemory none(0);
        quality.OnBuild();
    }
    EXPECT_EQ(quality.Follow(scrambled), 1.0f);
}

TEST(RefitQuality, PointsAndNothingHaveNoQualityToLose) {
    RefitQuality quality;
    EXPECT_EQ(quality.Follow({}), 1.0f);
    quality.OnBuild();
    EXPECT_EQ(quality.Follow({}), 1.0f);
    const std::vector<vec3> point(3 * 8, vec3(1.0f));
    RefitQuality ofPoint;
    ofPoint.Follow(point);
    ofPoint.OnBuild();
    EXPECT_EQ(ofPoint.Follow(point), 1.0f);
}

}  // namespace raygraph::testing::refit_quality_test
