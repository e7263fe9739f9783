// The formula that devices deform vertices by is that of renderer/scene/animation/deform.h, on random vertices.
#include "core/deform.glsl"

#include <gtest/gtest.h>

#include <random>

#include "renderer/scene/animation/deform.h"

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
