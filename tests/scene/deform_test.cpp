// Deformed meshes and flattened transforms.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <random>

#include "core/deform.glsl"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/check.h"

// Tests how morph targets and joints deform a vertex, against numbers computed by hand.
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

// The formula that devices deform vertices by is that of renderer/scene/animation/deform.h, on random vertices.
namespace raygraph::deform_shader_test {
namespace {

struct Random {
    std::mt19937 engine{7};
    float operator()() { return std::uniform_real_distribution<float>(-1.0f, 1.0f)(engine); }
    glm::vec3 Vector() { return {(*this)(), (*this)(), (*this)()}; }
};

constexpr uint32_t kVertices = 300, kTargets = 3, kInfluences = 5, kJoints = 7;

scene::Primitive RandomPrimitive(Random& random) {
    scene::Primitive primitive;
    primitive.influences.perVertex = kInfluences;
    primitive.targets.resize(kTargets);
    for (uint32_t i = 0; i < kVertices; ++i) {
        primitive.positions.push_back(random.Vector());
        primitive.normals.push_back(glm::normalize(random.Vector()));
        primitive.tangents.push_back(glm::vec4(glm::normalize(random.Vector()), i % 2 ? 1.0f : -1.0f));
        for (scene::MorphTarget& target : primitive.targets) {
            target.positions.push_back(random.Vector());
            target.normals.push_back(i % 16 ? random.Vector() : glm::vec3(0.0f));
            target.tangents.push_back(random.Vector());
        }
        for (uint32_t k = 0; k < kInfluences; ++k) {
            primitive.influences.joints.push_back(static_cast<uint16_t>((i + 3 * k) % kJoints));
            primitive.influences.weights.push_back(1.0f / kInfluences);
        }
    }
    // The sum of normal and targets has length 0
    primitive.targets[0].normals[5] = -primitive.normals[5];
    primitive.targets[1].normals[5] = primitive.targets[2].normals[5] = glm::vec3(0.0f);
    return primitive;
}

void ExpectSame(const shading::ShapedVertex& actual, const scene::DeformedVertex& expected) {
    constexpr float kTolerance = 2e-5f;  // normals of cofactors that almost vanish have lost digits
    EXPECT_LE(glm::length(actual.position - expected.position), 1e-5f);
    EXPECT_LE(glm::length(actual.normal - expected.normal), kTolerance);
    EXPECT_LE(glm::length(actual.tangent - expected.tangent), kTolerance);
}

TEST(Deform, TargetsAndJointsMoveVerticesAsOnTheCpu) {
    Random random;
    const scene::Primitive primitive = RandomPrimitive(random);
    const float weights[kTargets] = {1.0f, -0.4f, 0.7f};
    std::vector<glm::mat4x3> matrices(kJoints);
    for (glm::mat4x3& matrix : matrices)
        matrix = glm::mat4x3(random.Vector() + glm::vec3(2, 0, 0), random.Vector() + glm::vec3(0, 2, 0),
                             random.Vector() + glm::vec3(0, 0, 2), random.Vector());
    for (uint32_t i = 0; i < kVertices; ++i) {
        SCOPED_TRACE(i);
        shading::ShapedVertex base;
        base.position = primitive.positions[i];
        base.normal = primitive.normals[i];
        base.tangent = primitive.tangents[i];
        shading::ShapedVertex moved = base;
        for (uint32_t t = 0; t < kTargets; ++t)
            shading::AddMorphTarget(moved, weights[t], primitive.targets[t].positions[i],
                                    primitive.targets[t].normals[i], primitive.targets[t].tangents[i]);
        moved = shading::NormalizeMorphed(moved, base);
        const scene::DeformedVertex morphed = scene::MorphVertex(primitive, i, weights);
        ExpectSame(moved, morphed);
        glm::mat4x3 joints(0.0f);
        for (uint32_t k = kInfluences * i; k < kInfluences * (i + 1); ++k)
            joints += primitive.influences.weights[k] * matrices[primitive.influences.joints[k]];
        ExpectSame(shading::ApplySkinning(joints, moved), scene::SkinVertex(primitive, i, morphed, matrices));
    }
    EXPECT_EQ(scene::MorphVertex(primitive, 5, weights).normal, primitive.normals[5]);
}

TEST(Deform, TangentsAreLaidIntoTheSurfaceAsOnTheCpu) {
    Random random;
    for (int i = 0; i < 300; ++i) {
        const glm::vec3 normal = glm::normalize(random.Vector());
        // Every tenth is along the normal, but for rounding
        const glm::vec3 direction = i % 10 ? glm::normalize(random.Vector()) : -normal;
        const glm::vec4 tangent(direction, i % 2 ? 1.0f : -1.0f);
        const glm::vec4 actual = shading::TangentInPlane(tangent, normal);
        EXPECT_LE(glm::length(actual - scene::TangentInPlane(tangent, normal)), 1e-5f) << i;
        if (i % 10 == 0) {
            EXPECT_EQ(actual, tangent) << i;
        } else {
            EXPECT_NEAR(glm::dot(glm::vec3(actual), normal), 0.0f, 1e-4f) << i;
        }
    }
}

TEST(Deform, FlatNormalFacesTheFrontAndIsUpWithoutArea) {
    EXPECT_EQ(shading::FlatNormal({0, 0, 0}, {0, 2, 0}, {0, 0, 3}), glm::vec3(1, 0, 0));
    EXPECT_EQ(shading::FlatNormal({1, 1, 1}, {2, 2, 2}, {3, 3, 3}), glm::vec3(0, 0, 1));
}

}  // namespace
}  // namespace raygraph::deform_shader_test

// Tests of transforms that flatten a mesh into a plane, and of the invertible ones that replace them.
namespace raygraph::scene::flat_transform_test {
namespace {

using glm::vec3;

constexpr Bounds kCube{vec3(-0.5f), vec3(0.5f)};

glm::mat4x3 Scaling(const vec3& scale) {
    return {vec3(scale.x, 0, 0), vec3(0, scale.y, 0), vec3(0, 0, scale.z), vec3(0)};
}

glm::mat4x3 Turn(float angle, const vec3& axis) {
    return glm::mat4x3(glm::mat3_cast(glm::angleAxis(angle, glm::normalize(axis))));
}

// The product in float, as the transforms of nodes are composed.
glm::mat4x3 Product(const glm::mat4x3& a, const glm::mat4x3& b) {
    return Compose({a}, {b}).matrix;
}

// A transform that flattens, and the normal of the plane.
struct Flat {
    const char* name;
    glm::mat4x3 matrix;
    vec3 normal;
    bool isOblique = false;  // the flattened direction is no axis of the mesh
};
std::vector<Flat> Flats() {
    const glm::mat4x3 turn = Turn(0.9f, {1, 2, 3}), other = Turn(0.5f, {2, -1, 1});
    const vec3 turned(turn[2]);
    std::vector<Flat> flats;
    for (const float z : {0.0f, 1e-12f, -1e-12f, 1e-20f}) {
        flats.push_back({"a scale", Scaling({1, 1, z}), {0, 0, 1}});
        flats.push_back({"turned", Product(turn, Scaling({2, 0.5f, z})), turned});
        flats.push_back({"of what is turned", Product(Scaling({1, 1, z}), other), {0, 0, 1}, true});
        flats.push_back({"between turns", Product(turn, Product(Scaling({3, 2, z}), other)), turned, true});
        flats.push_back({"large", Product(Scaling(vec3(1e6f)), Scaling({1, 1, z})), {0, 0, 1}});
    }
    flats.push_back(
        {"no axis is 0", glm::mat4x3(vec3(1, 0, 0), vec3(0, 1, 0), vec3(1, 1, 0), vec3(0)), {0, 0, 1}, true});
    return flats;
}

vec3 NormalUnder(const glm::mat4x3& matrix, const vec3& normal) {
    return glm::normalize(glm::transpose(glm::inverse(glm::dmat3(matrix))) * glm::dvec3(normal));
}

TEST(FlatTransform, WhatIsNotFlatKeepsItsBits) {
    std::mt19937 engine(3);
    std::uniform_real_distribution<float> random(-1.0f, 1.0f);
    const auto vector = [&] { return vec3(random(engine), random(engine), random(engine)); };
    for (int i = 0; i < 20000; ++i) {
        const glm::mat4x3 turn = Turn(3.0f * random(engine), vector() + vec3(0, 0, 1e-3f));
        vec3 scale;
        const bool isOblique = i % 3 == 0;
        for (int axis = 0; axis < 3; ++axis)
            scale[axis] = std::exp2((isOblique ? 4.0f : 13.0f) * random(engine));
        if (i % 2 != 0) scale.x = -scale.x;
        // Axes differ by factors up to 2^26, or up to 2^8 if not those of the mesh. The scale multiplies whole
        // rows or columns, so that float loses no digits
        glm::mat4x3 matrix = isOblique ? Product(Scaling(scale), turn) : Product(turn, Scaling(scale));
        matrix[3] = vector();
        const PlacedTransform placed{matrix, 1e-9f * vector()};
        EXPECT_FALSE(IsFlat(matrix)) << i;
        EXPECT_EQ(WithThickness(placed, kCube), placed) << i;
    }
}

TEST(FlatTransform, TheMeshLiesInThePlaneAndHasItsNormal) {
    for (const Flat& flat : Flats())
        for (const bool isMirrored : {false, true}) {
            SCOPED_TRACE(flat.name);
            ASSERT_TRUE(IsFlat(flat.matrix));
            const auto shown = WithThickness(PlacedTransform{flat.matrix}, kCube, isMirrored);
            ASSERT_TRUE(shown);
            const glm::mat4x3& matrix = shown->matrix;
            EXPECT_TRUE(CanInvert(matrix));
            EXPECT_FALSE(IsFlat(matrix)) << "it would change again";
            EXPECT_EQ(glm::determinant(glm::mat3(matrix)) < 0.0f, isMirrored);
            const float size = glm::length(matrix[0]) + glm::length(matrix[1]) + glm::length(matrix[2]);
            float thickness = 0.0f;
            for (int corner = 0; corner < 8; ++corner) {
                const vec3 at(corner & 1 ? 0.5f : -0.5f, corner & 2 ? 0.5f : -0.5f,
                              corner & 4 ? 0.5f : -0.5f);
                const vec3 before = flat.matrix * glm::vec4(at, 1), after = matrix * glm::vec4(at, 1);
                EXPECT_LT(glm::distance(before, after), 6e-4f * size);
                thickness = std::max(thickness, std::abs(glm::dot(after, flat.normal)));
            }
            EXPECT_GT(thickness, 1e-6f * size) << "rays tell the sides apart";
            for (const vec3& normal : {vec3(0.3f, 0.2f, 1), vec3(-0.5f, 0.1f, -0.6f), vec3(0, 0.4f, 0.3f)})
                EXPECT_GT(std::abs(glm::dot(NormalUnder(matrix, normal), flat.normal)), 0.9999f);
            EXPECT_LT(thickness, (flat.isOblique ? 6e-4f : 8e-5f) * size);
        }
}

// Rays in the space of a mesh that is not squeezed along its axes need a thickness before float does.
TEST(FlatTransform, WhatIsAlmostFlatAndObliqueGetsWhatRaysNeed) {
    const glm::mat4x3 turn = Turn(0.9f, {1, 2, 3}), other = Turn(0.5f, {2, -1, 1});
    const auto widthOf = [](const glm::mat4x3& matrix) {  // width of a cube in z
        return std::abs(matrix[0].z) + std::abs(matrix[1].z) + std::abs(matrix[2].z);
    };
    double before = 0.0;
    for (const float z : {0.0f, 1e-9f, 1e-7f, 1e-5f, 1e-4f, 1e-3f, 1e-2f})
        for (const float side : {1.0f, -1.0f}) {
            const glm::mat4x3 matrix = Product(Scaling({2, 1, side * z}), other);
            EXPECT_EQ(MayGainThickness(matrix), z < 1e-3f);
            const auto shown = WithThickness(PlacedTransform{matrix}, kCube, side < 0.0f);
            ASSERT_TRUE(shown);
            EXPECT_EQ(WithThickness(*shown, kCube), shown) << "it would change again";
            EXPECT_EQ(glm::determinant(glm::mat3(shown->matrix)) < 0.0f, side < 0.0f);
            EXPECT_GE(widthOf(shown->matrix), 0.99 * before) << z << ": a thinner one gets more";
            EXPECT_LT(widthOf(shown->matrix), std::max(1.01f * widthOf(matrix), 1e-3f));
            EXPECT_GT(widthOf(shown->matrix), 4e-4f);
            if (side < 0.0f) before = widthOf(shown->matrix);
            const PlacedTransform straight{Product(turn, Scaling({2, 1, side * z}))};
            EXPECT_TRUE(z < 1e-8f || WithThickness(straight, kCube) == straight) << "along an axis";
        }
}

// The scale goes from (-1, 1, s) with s > 0 to s = 0.
TEST(FlatTransform, TheFrontIsThatOfASmallScale) {
    SceneData scene;
    scene.meshes.resize(1);
    scene.meshes[0].primitives.resize(1);
    scene.meshes[0].primitives[0].bounds = kCube;
    scene.nodes.resize(3);
    scene.nodeOrder = {0, 1, 2};
    scene.nodes[1].parent = 0;
    scene.nodes[2].parent = 1;
    scene.nodes[2].mesh = 0;
    scene.instances = {{.mesh = 0, .node = 2}};
    const auto normalAt = [&](float s) {
        for (Node& node : scene.nodes)
            for (int axis = 0; axis < 3; ++axis)
                if (std::abs(node.scale[axis]) < 0.01f) node.scale[axis] = s;
        UpdateWorldTransforms(scene);
        return NormalUnder(scene.instances[0].objectToWorld, vec3(0.1f, 0.2f, 1.0f));
    };
    for (const vec3& outer : {vec3(1), vec3(-1, 1, 1), vec3(-1, -2, 1)})
        for (const vec3& flat : {vec3(1, 1, 0), vec3(-1, 1, 0), vec3(1, -1, 0), vec3(-1, -1, 0)})
            for (const vec3& inner : {vec3(1), vec3(1, 1, -1)}) {
                scene.nodes[0].scale = outer;
                scene.nodes[0].rotation = glm::angleAxis(0.9f, glm::normalize(vec3(1, 2, 3)));
                scene.nodes[1].scale = flat;
                scene.nodes[2].scale = inner;
                scene.nodes[2].rotation = glm::angleAxis(0.4f, glm::normalize(vec3(2, -1, 1)));
                const vec3 before = normalAt(1e-3f);
                EXPECT_GT(glm::dot(normalAt(0.0f), before), 0.99f)
                    << outer.x << outer.y << ' ' << flat.x << flat.y << ' ' << inner.z;
                EXPECT_LT(glm::dot(normalAt(-1e-12f), before), -0.99f);
            }
}

// A scale does not change the direction of a light or a camera.
TEST(FlatTransform, LightsAndCamerasOfFlatNodesKeepTheirDirections) {
    SceneData scene;
    scene.nodes.resize(1);
    scene.nodeOrder = {0};
    scene.nodes[0].rotation = glm::angleAxis(0.9f, glm::normalize(vec3(1, 2, 3)));
    scene.lights = {Light{.name = "", .node = 0}};
    scene.cameras = {Camera{.name = "", .node = 0}};
    for (const vec3& scale : {vec3(1, 1, 0), vec3(-1, 2, 0), vec3(0, 1, 1), vec3(1, 0, -1)}) {
        scene.nodes[0].scale = scale;
        UpdateWorldTransforms(scene);
        for (int axis = 0; axis < 3; ++axis) {
            vec3 direction(0.0f);
            direction[axis] = scale[axis] < 0.0f ? -1.0f : 1.0f;
            direction = scene.nodes[0].rotation * direction;
            for (const glm::mat4x3& placed : {scene.lights[0].lightToWorld, scene.cameras[0].cameraToWorld})
                EXPECT_GT(glm::dot(glm::normalize(placed[axis]), direction), 0.9999f) << axis;
        }
    }
}

TEST(FlatTransform, AMeshFarFromItsOriginIsFlattenedIntoThePlane) {
    const Bounds far{{-1, -1, 1e5f}, {1, 1, 1e5f + 2}};
    const PlacedTransform placed{{vec3(1, 0, 0), vec3(0, 1, 0), vec3(0), vec3(3, 4, 1000)}, vec3(1e-5f)};
    const auto shown = WithThickness(placed, far);
    ASSERT_TRUE(shown);
    for (const float z : {1e5f, 1e5f + 2}) {
        const double place = glm::dmat3(shown->matrix)[2].z * double{z} + shown->Place().z;
        EXPECT_NEAR(place, placed.Place().z, 3e-4);
    }
    EXPECT_EQ(shown->Place().x, placed.Place().x);
}

// The thickness follows from the square root of the area, whatever the extent along the flattened direction.
TEST(FlatTransform, ATowerIsNoThickerThanACube) {
    for (const float height : {0.01f, 1.0f, 1000.0f}) {
        const auto shown =
            WithThickness(PlacedTransform{Scaling({1, 1, 0})}, Bounds{{-1, -1, 0}, {1, 1, height}});
        ASSERT_TRUE(shown);
        const double thickness = double{shown->matrix[2].z} * double{height};
        EXPECT_GT(thickness, 2.0 * kFlatThickness * 0.015);
        EXPECT_LT(thickness, 2.0 * kFlatThickness * 1.01);
    }
}

TEST(FlatTransform, NothingIsSeenOfWhatHasNoArea) {
    const glm::mat4x3 turn = Turn(0.9f, {1, 2, 3}), other = Turn(0.5f, {2, -1, 1});
    for (const vec3& scale :
         {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0), vec3(1, 1e-12f, 0), vec3(0, 1e-15f, 1e-15f)}) {
        EXPECT_FALSE(WithThickness(PlacedTransform{Scaling(scale)}, kCube));
        EXPECT_FALSE(WithThickness(PlacedTransform{Product(turn, Product(Scaling(scale), other))}, kCube));
    }
    glm::mat4x3 endless(1.0f);
    endless[1].y = std::numeric_limits<float>::infinity();
    EXPECT_FALSE(WithThickness(PlacedTransform{endless}, kCube));
    endless[2] = vec3(0.0f);
    EXPECT_FALSE(WithThickness(PlacedTransform{endless}, kCube));
}

// A scale turns the card into a line, although the transform has an area.
TEST(FlatTransform, ACardSeenFromItsEdgeStaysThin) {
    const auto shown = WithThickness(PlacedTransform{Scaling({0, 1, 1})}, Bounds{{-1, -1, 0}, {1, 1, 0}});
    ASSERT_TRUE(shown);
    EXPECT_LT(std::abs(shown->matrix[0].x), 1e-8f);
    EXPECT_TRUE(CanInvert(shown->matrix));
}

TEST(FlatTransform, MeanScaleIsOfTheDirectionsThatAreLeft) {
    EXPECT_DOUBLE_EQ(MeanScale(Scaling({2, 4, 1})), 2.0);
    EXPECT_DOUBLE_EQ(MeanScale(Scaling({-2, 8, 0})), 4.0);
    EXPECT_NEAR(MeanScale(Product(Turn(0.4f, {1, 2, 3}), Scaling({2, 0, 8}))), 4.0, 1e-5);
}

}  // namespace
}  // namespace raygraph::scene::flat_transform_test
