// Tests how morph targets and joints deform a vertex, against numbers computed by hand.
#include "renderer/scene/animation/deform.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/check.h"

namespace raygraph::scene::deform_test {
namespace {

using glm::mat4x3;
using glm::vec3;
using glm::vec4;

void ExpectNear(const vec3& actual, const vec3& expected, float tolerance = 1e-6f) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

// One vertex at (1, 2, 3), normal +z, tangent +x.
Primitive OneVertex() {
    Primitive primitive;
    primitive.positions = {{1, 2, 3}};
    primitive.normals = {{0, 0, 1}};
    primitive.tangents = {{1, 0, 0, -1}};
    primitive.bounds.Extend(primitive.positions[0]);
    return primitive;
}

TEST(MorphVertex, AddsEachTargetByItsWeight) {
    Primitive primitive = OneVertex();
    primitive.targets.resize(2);
    primitive.targets[0] = {{{10, 0, 0}}, {{0, 1, 0}}, {{0, 3, 0}}, {}};
    primitive.targets[1] = {{{0, 0, 100}}, {}, {}, {}};
    const std::vector<float> weights{0.5f, -0.25f};
    const DeformedVertex morphed = MorphVertex(primitive, 0, weights);
    ExpectNear(morphed.position, {6, 2, -22});
    ExpectNear(morphed.normal, vec3(0, 0.5f, 1) / std::sqrt(1.25f));
    ExpectNear(vec3(morphed.tangent), vec3(1, 1.5f, 0) / std::sqrt(3.25f));
    EXPECT_EQ(morphed.tangent.w, -1.0f);
}

TEST(MorphVertex, WithoutLengthKeepsTheBase) {
    Primitive primitive = OneVertex();
    primitive.targets.resize(1);
    primitive.targets[0] = {{}, {{0, 0, -1}}, {{-1, 0, 0}}, {}};
    const std::vector<float> weights{1.0f};
    const DeformedVertex morphed = MorphVertex(primitive, 0, weights);
    EXPECT_EQ(morphed.normal, vec3(0, 0, 1));
    EXPECT_EQ(vec3(morphed.tangent), vec3(1, 0, 0));
}

void Follow(Primitive& primitive, std::vector<uint16_t> joints, std::vector<float> weights) {
    primitive.influences.perVertex = uint32_t(joints.size() / primitive.positions.size());
    primitive.influences.joints = std::move(joints);
    primitive.influences.weights = std::move(weights);
    UpdateDeformationBounds(primitive);
}

DeformedVertex Skinned(const Primitive& primitive, const std::vector<mat4x3>& matrices) {
    return SkinVertex(primitive, 0, MorphVertex(primitive, 0, {}), matrices);
}

TEST(SkinVertex, IsTheWeightedMeanOfWhereItsJointsMoveIt) {
    Primitive primitive = OneVertex();
    Follow(primitive, {2, 0}, {0.75f, 0.25f});
    mat4x3 up(1.0f), aside(1.0f);
    up[3] = {0, 8, 0};
    aside[3] = {4, 0, 0};
    const DeformedVertex vertex = Skinned(primitive, {aside, mat4x3(0.0f), up});
    ExpectNear(vertex.position, {2, 8, 3});
    ExpectNear(vertex.normal, {0, 0, 1});
}

// A quarter turn about +x after a scale by (2, 1, 1).
TEST(SkinVertex, NormalsGoByTheInverseTransposeTangentsByTheMatrix) {
    Primitive primitive = OneVertex();
    primitive.normals[0] = glm::normalize(vec3(1, 1, 0));
    primitive.tangents[0] = {glm::normalize(vec3(1, -1, 0)), 1};
    Follow(primitive, {0}, {1});
    const mat4x3 matrix{vec3(2, 0, 0), vec3(0, 0, 1), vec3(0, -1, 0), vec3(0, 0, 0)};
    const DeformedVertex vertex = Skinned(primitive, {matrix});
    ExpectNear(vertex.position, {2, -3, 2});
    ExpectNear(vertex.normal, glm::normalize(vec3(0.5f, 0, 1)));
    ExpectNear(vec3(vertex.tangent), glm::normalize(vec3(2, 0, -1)));
    EXPECT_NEAR(glm::dot(vertex.normal, vec3(vertex.tangent)), 0.0f, 1e-6f);
}

// A flat joint has no inverse, and a normal all the same. A mirroring one turns the winding, and the normal with
// it.
TEST(SkinVertex, NormalsStayOnTheSideOfTheWinding) {
    Primitive primitive = OneVertex();
    Follow(primitive, {0}, {1});
    ExpectNear(Skinned(primitive, {mat4x3(vec3(3, 0, 0), vec3(0, 2, 0), vec3(0, 0, 0), vec3(0))}).normal,
               {0, 0, 1});
    ExpectNear(Skinned(primitive, {mat4x3(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(0))}).normal,
               {0, 0, -1});
}

TEST(SkinVertex, MovesWhatIsMorphedAlready) {
    Primitive primitive = OneVertex();
    primitive.targets.resize(1);
    primitive.targets[0].positions = {{1, 0, 0}};
    Follow(primitive, {0}, {1});
    const std::vector<float> weights{2.0f};
    const std::vector<mat4x3> matrices{mat4x3(vec3(10, 0, 0), vec3(0, 10, 0), vec3(0, 0, 10), vec3(0))};
    DeformedStreams streams;
    DeformPrimitive(primitive, weights, matrices, streams);
    ExpectNear(streams.positions[0], {30, 20, 30});
}

// tangent - dot(tangent, normal) * normal of the morphed ones, at three weights.
TEST(DeformPrimitive, TangentsOfMorphedVerticesArePerpendicularToTheirNormals) {
    Primitive primitive = OneVertex();
    primitive.targets.resize(1);
    primitive.targets[0] = {{}, {{1, 2, 0}}, {{0, 1, 3}}, {}};
    DeformedStreams streams;
    for (const float weight : {0.0f, 0.3f, 1.0f}) {
        SCOPED_TRACE(weight);
        DeformPrimitive(primitive, std::array{weight}, {}, streams);
        const glm::dvec3 normal = glm::normalize(glm::dvec3(weight, 2.0 * weight, 1.0));
        const glm::dvec3 tangent = glm::normalize(glm::dvec3(1.0, weight, 3.0 * weight));
        const vec3 expected(glm::normalize(tangent - glm::dot(tangent, normal) * normal));
        ExpectNear(streams.normals[0], vec3(normal));
        ExpectNear(vec3(streams.tangents[0]), expected);
        EXPECT_EQ(streams.tangents[0].w, -1.0f);
        // A matrix that stretches and shears: both have other directions, and the angle stays right
        Primitive skinned = primitive;
        Follow(skinned, {0}, {1});
        const std::vector<mat4x3> matrices{mat4x3(vec3(3, 1, 0), vec3(0, 0.5f, 0), vec3(1, 0, 2), vec3(0))};
        DeformPrimitive(skinned, std::array{weight}, matrices, streams);
        EXPECT_NEAR(glm::dot(streams.normals[0], vec3(streams.tangents[0])), 0.0f, 1e-6f);
        EXPECT_NEAR(glm::length(vec3(streams.tangents[0])), 1.0f, 1e-6f);
    }
}

TEST(DeformPrimitive, ATangentAlongTheNormalStaysAsItIs) {
    Primitive primitive = OneVertex();
    primitive.targets.resize(1);
    primitive.targets[0] = {{}, {}, {{-1, 0, 1}}, {}};
    DeformedStreams streams;
    DeformPrimitive(primitive, std::array{1.0f}, {}, streams);
    EXPECT_EQ(streams.tangents[0], vec4(0, 0, 1, -1));
}

// The file's angle of the tangent stays unchanged.
TEST(DeformPrimitive, TangentsThatOnlyJointsMoveGoByTheMatrix) {
    Primitive primitive = OneVertex();
    primitive.tangents[0] = vec4(0.6f, 0, 0.8f, 1);
    Follow(primitive, {0}, {1});
    DeformedStreams streams;
    DeformPrimitive(primitive, {}, std::array{mat4x3(1.0f)}, streams);
    ExpectNear(vec3(streams.tangents[0]), {0.6f, 0, 0.8f});
}

TEST(SkinVertex, AJointThatMovesNothingNeedNotBeFinite) {
    Primitive primitive = OneVertex();
    Follow(primitive, {0, 1}, {1, 0});
    const float nan = std::numeric_limits<float>::quiet_NaN();
    DeformedStreams streams;
    DeformPrimitive(primitive, {},
                    std::array{mat4x3(1.0f), mat4x3(vec3(nan), vec3(nan), vec3(nan), vec3(nan))}, streams);
    EXPECT_EQ(streams.positions[0], primitive.positions[0]);
}

TEST(DeformPrimitive, FlatNormalsAreThoseOfTheDeformedTriangle) {
    Primitive primitive;
    primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    primitive.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    primitive.indices = {0, 1, 2};
    primitive.tangents.assign(3, {0, 1 / std::sqrt(2.0f), 1 / std::sqrt(2.0f), 1});
    primitive.hasFlatNormals = true;
    primitive.targets.resize(1);
    primitive.targets[0].positions = {{0, 0, 0}, {0, 0, 0}, {0, -1, 1}};
    const std::vector<float> weights{1.0f};
    DeformedStreams streams;
    DeformPrimitive(primitive, weights, {}, streams);
    for (const vec3& normal : streams.normals) ExpectNear(normal, {0, -1, 0});
    for (const vec4& tangent : streams.tangents) ExpectNear(vec3(tangent), {0, 0, 1});
    primitive.hasFlatNormals = false;
    DeformPrimitive(primitive, weights, {}, streams);
    ExpectNear(streams.normals[0], {0, 0, 1});
}

// A scene whose skin has joints at these nodes, far from the origin.
SceneData Bones(const glm::dvec3& place) {
    SceneData scene;
    scene.nodes.resize(3);
    for (const uint32_t joint : {0u, 1u}) {
        const glm::dvec3 at = place + glm::dvec3(joint, 0, 0);
        scene.nodes[joint].translation = vec3(at);
        scene.nodes[joint].translationResidual = vec3(at - glm::dvec3(vec3(at)));
    }
    scene.nodes[2].mesh = 0;
    scene.nodes[2].skin = 0;
    scene.nodes[2].translation = {-500, 3, 7};  // does not count
    scene.nodes[2].scale = vec3(5);
    scene.nodeOrder = {0, 1, 2};
    Skin& skin = scene.skins.emplace_back();
    skin.joints = {0, 1};
    skin.inverseBinds.assign(2, mat4x3(1.0f));
    skin.inverseBinds[1][3].x = -1.0f;
    Primitive primitive = OneVertex();
    Follow(primitive, {0, 1}, {0.5f, 0.5f});
    scene.materials.resize(1);
    scene.meshes.push_back({.name = "", .primitives = {primitive}, .weights = {}});
    scene.instances.push_back({.mesh = 0, .node = 2});
    return scene;
}

TEST(SkinFrame, InstanceIsAtTheFirstJointWhateverItsNodeSays) {
    SceneData scene = Bones({4, 5, 6});
    UpdateWorldTransforms(scene);
    EXPECT_EQ(scene.instances[0].objectToWorld[0].x, 5.0f) << "not deformed: where the node is";
    DeformInstances(scene);
    EXPECT_TRUE(scene.instances[0].isDeformed);
    EXPECT_EQ(scene.instances[0].objectToWorld,
              mat4x3(vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1), vec3(4, 5, 6)));
    // Joint 1 is where it was bound: the vertex is at (1, 2, 3) from joint 0
    ExpectNear(scene.bounds.min, {5, 7, 9}, 1e-5f);
    ExpectNear(scene.bounds.max, {5, 7, 9}, 1e-5f);
    EXPECT_NO_THROW(Check(scene));
}

// At 10,000 km floats are 1 m apart: matrices in world space would lose the quarter of a meter.
TEST(JointMatrices, KeepTheirDigitsFarFromTheOrigin) {
    SceneData scene = Bones({1e7 + 0.125, -1e7, 0});
    scene.nodes[1].translationResidual.x += 0.25f;
    DeformInstances(scene);
    const PlacedTransform frame{scene.instances[0].objectToWorld, scene.instances[0].translationResidual};
    EXPECT_EQ(frame.Place(), glm::dvec3(1e7 + 0.125, -1e7, 0));
    std::vector<mat4x3> matrices(2);
    JointMatrices(WorldTransforms(scene), scene.skins[0], frame, matrices);
    EXPECT_EQ(matrices[0], mat4x3(1.0f));
    EXPECT_EQ(matrices[1][3], vec3(0.25f, 0, 0));
}

// Below a node that mirrors, deformed vertices keep their winding, and the instance mirrors them.
TEST(SkinFrame, MirrorsWhatItsJointsMirror) {
    SceneData scene = Bones({0, 0, 0});
    scene.nodes[0].scale = scene.nodes[1].scale = {1, 1, -1};
    DeformInstances(scene);
    const Instance& instance = scene.instances[0];
    EXPECT_TRUE(instance.IsMirrored());
    std::vector<mat4x3> matrices(2);
    JointMatrices(WorldTransforms(scene), scene.skins[0],
                  {instance.objectToWorld, instance.translationResidual}, matrices);
    EXPECT_GT(glm::determinant(glm::mat3(matrices[0])), 0.0f);
    const DeformedVertex vertex = Skinned(scene.meshes[0].primitives[0], matrices);
    ExpectNear(instance.objectToWorld * vec4(vertex.position, 1), {1, 2, -3});
}

// The boxes are around all that random weights and joints make of random vertices, and no wider than what a
// vertex could reach.
TEST(DeformedBounds, AreAroundWhatIsDeformed) {
    std::mt19937 random(5);
    const auto number = [&](float scale) { return scale * (float(random() % 2001) / 1000.0f - 1.0f); };
    const auto vector = [&](float scale) { return vec3(number(scale), number(scale), number(scale)); };
    for (int round = 0; round < 50; ++round) {
        Primitive primitive;
        std::vector<uint16_t> joints;
        std::vector<float> weights;
        for (int i = 0; i < 20; ++i) {
            primitive.positions.push_back(vector(2.0f));
            primitive.bounds.Extend(primitive.positions.back());
            const float share = float(random() % 101) / 100.0f;
            joints.insert(joints.end(), {uint16_t(random() % 5), uint16_t(random() % 5)});
            weights.insert(weights.end(), {share, 1.0f - share});
        }
        primitive.targets.resize(3);
        for (MorphTarget& target : primitive.targets)
            for (int i = 0; i < 20; ++i) target.positions.push_back(vector(0.5f));
        Follow(primitive, joints, weights);
        std::vector<mat4x3> matrices;
        for (int i = 0; i < 5; ++i) matrices.emplace_back(vector(2), vector(2), vector(2), vector(5));
        const std::vector<float> amounts{number(2), number(2), number(2)};
        for (const bool hasJoints : {false, true}) {
            const std::vector<mat4x3> used = hasJoints ? matrices : std::vector<mat4x3>();
            DeformedStreams streams;
            DeformPrimitive(primitive, amounts, used, streams);
            const Bounds bounds = DeformedBounds(primitive, amounts, used);
            const Bounds exact = BoundsOf(streams.positions);
            for (int i = 0; i < 3; ++i) {
                EXPECT_LE(bounds.min[i], exact.min[i] + 1e-4f);
                EXPECT_GE(bounds.max[i], exact.max[i] - 1e-4f);
            }
            EXPECT_LT(bounds.Radius(), 8.0f * exact.Radius());
        }
    }
}

// A joint that moves nothing makes the box no larger, wherever it is.
// A host's matrix may be finite and the places that it moves to not, nor on one side of anything.
TEST(DeformedBounds, AreEverywhereWhereAJointGoesBeyondTheNumbers) {
    Primitive primitive;
    primitive.positions = {{2, 2, 0}, {1, 0, 0}};
    primitive.influences = {1, {0, 1}, {1, 1}, {}};
    UpdateDeformationBounds(primitive);
    std::vector<glm::mat4x3> matrices(2, glm::mat4x3(1.0f));
    EXPECT_EQ(DeformedBounds(primitive, {}, matrices).max, vec3(2, 2, 0));
    const float huge = std::numeric_limits<float>::max();
    for (const float sign : {1.0f, -1.0f}) {
        matrices[0] = {{huge, 0, 0}, {sign * huge, 0, 0}, {0, 0, 1}, {0, 0, 0}};
        EXPECT_TRUE(std::isinf(DeformedBounds(primitive, {}, matrices).max.x));
        EXPECT_TRUE(std::isinf(DeformedBounds(primitive, {}, matrices).min.y));
    }
}

TEST(DeformedBounds, LeaveOutJointsThatMoveNothing) {
    Primitive primitive = OneVertex();
    Follow(primitive, {1, 0}, {1, 0});
    mat4x3 far(1.0f);
    far[3] = {1e6f, 0, 0};
    const std::vector<mat4x3> matrices{far, mat4x3(1.0f), far};
    EXPECT_EQ(DeformedBounds(primitive, {}, matrices).max, vec3(1, 2, 3));
}

}  // namespace
}  // namespace raygraph::scene::deform_test
