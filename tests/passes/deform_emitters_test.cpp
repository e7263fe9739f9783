// What the host knows of the vertices of deformed groups: where emitters are, how well, and the box.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "renderer/gpu_scene/deform/deform_resources.h"

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

// As a device may, with products and sums fused, in another order.
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

// Of the formula in double, and of the same numbers as a device may compute them.
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
