// The distance at which rays leave a triangle: that of its rounding, in the world and as every traversal has it.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/frame.glsl"
#include "core/ray_offset.glsl"
#include "tests/shading/wide_traversal.h"
#include "tests/support/triangle_soup.h"

namespace raygraph::shading::ray_clearance_test {
namespace {

float Uniform(std::mt19937& generator) {
    return static_cast<float>(generator() >> 8) * 0x1p-24f;
}

vec3 UnitVector(std::mt19937& generator) {
    std::normal_distribution<float> normal;
    vec3 v(0.0f);
    while (length(v) < 1e-3f) v = vec3(normal(generator), normal(generator), normal(generator));
    return normalize(v);
}

// A placed triangle, and a point of it as scene/surface.glsl computes it.
struct Placed {
    mat3 linear{1.0f};
    vec3 translation{0.0f};
    vec3 p0{0.0f}, e1{0.0f}, e2{0.0f};
    vec2 weights{0.0f};

    vec3 ObjectPoint() const { return p0 + weights.x * e1 + weights.y * e2; }
    vec3 Point() const { return linear * ObjectPoint() + translation; }
    float Clearance() const { return RayClearance(linear, translation, p0, e1, e2, ObjectPoint()); }
    vec3 Normal() const {
        const vec3 n = cross(e1, e2);
        return normalize(n.x * cross(linear[1], linear[2]) + n.y * cross(linear[2], linear[0]) +
                         n.z * cross(linear[0], linear[1]));
    }
};

glm::dvec3 Double(vec3 v) {
    return glm::dvec3(v);
}

glm::dmat3 Double(const mat3& m) {
    return {Double(m[0]), Double(m[1]), Double(m[2])};
}

// Meters of `place` above the plane of the exact triangle, on the side of the normal.
double HeightAbove(const Placed& placed, const glm::dvec3& place) {
    const glm::dmat3 linear = Double(placed.linear);
    const glm::dvec3 normal = glm::normalize(glm::transpose(glm::inverse(linear)) *
                                             glm::cross(Double(placed.e1), Double(placed.e2))) *
                              (glm::determinant(linear) < 0.0 ? -1.0 : 1.0);
    return glm::dot(normal, place - (linear * Double(placed.p0) + Double(placed.translation)));
}

// Returns where a device puts the origin that inverts the transform in float and transforms the ray's origin
// to object space in float, transformed back to the world without further error.
glm::dvec3 AsDeviceHasIt(const Placed& placed, vec3 origin) {
    const glm::mat4 matrix(glm::vec4(placed.linear[0], 0.0f), glm::vec4(placed.linear[1], 0.0f),
                           glm::vec4(placed.linear[2], 0.0f), glm::vec4(placed.translation, 1.0f));
    const glm::mat4 inverse = glm::inverse(matrix);
    const vec3 inObject = vec3(inverse[0]) * origin.x + vec3(inverse[1]) * origin.y +
                          vec3(inverse[2]) * origin.z + vec3(inverse[3]);
    return Double(placed.linear) * Double(inObject) + Double(placed.translation);
}

mat3 RandomLinear(std::mt19937& generator, int kind) {
    if (kind == 0) return mat3(1.0f);
    const Frame turn = FrameFromZ(UnitVector(generator));
    const float angle = 6.0f * Uniform(generator);
    const vec3 x = std::cos(angle) * turn.x + std::sin(angle) * turn.y;
    mat3 linear(x, cross(turn.z, x), turn.z);
    if (kind == 1) return linear;
    for (int i = 0; i < 3; ++i) linear[i] *= std::exp(2.0f * Uniform(generator) - 1.0f);
    if (kind == 3) linear[0] = linear[0] + 0.5f * linear[1];  // sheared
    if (kind == 4) linear[2] = -linear[2];                    // mirrored
    return linear;
}

// A triangle of `extent` meters, `far` from its object's origin, at `near` from the world's.
Placed RandomTriangle(std::mt19937& generator, int kind, float extent, float far, float near) {
    Placed placed;
    placed.linear = RandomLinear(generator, kind);
    placed.p0 = far * UnitVector(generator) + extent * UnitVector(generator);
    placed.e1 = (placed.p0 + extent * UnitVector(generator)) - placed.p0;
    placed.e2 = (placed.p0 + extent * UnitVector(generator)) - placed.p0;
    placed.translation = near * UnitVector(generator) - placed.linear * placed.p0;
    const float b1 = std::sqrt(Uniform(generator));
    placed.weights = vec2(b1, (1.0f - b1) * Uniform(generator));
    return placed;
}

TEST(RayClearance, LeavesTheSurfaceInTheWorldAndAsTheDeviceHasIt) {
    struct Place {
        float extent, far, near;
    };
    std::mt19937 generator(3);
    // Tiny things, rooms, towns, vertices and nodes that cancel, and what is far off
    for (const Place& place :
         {Place{0.001f, 0.01f, 0.01f}, Place{1.0f, 1.0f, 10.0f}, Place{1.0f, 1000.0f, 1.0f},
          Place{0.1f, 300.0f, 300.0f}, Place{100.0f, 1.0f, 10000.0f}, Place{1.0f, 1e5f, 10.0f},
          Place{1e4f, 1e6f, 1e6f}}) {
        for (int kind = 0; kind < 5; ++kind) {
            int behindCount = 0;
            double largest = 0.0;  // clearance over the size of a float step of the largest coordinate
            for (int i = 0; i < 20'000; ++i) {
                const Placed placed = RandomTriangle(generator, kind, place.extent, place.far, place.near);
                const float area = length(cross(placed.e1, placed.e2));
                if (area < 0.05f * place.extent * place.extent)
                    continue;  // slivers have a bound of their own
                const float clearance = placed.Clearance();
                for (const float side : {1.0f, -1.0f}) {
                    const vec3 origin = OffsetRayOrigin(placed.Point(), side * placed.Normal(), clearance);
                    if (!(side * HeightAbove(placed, Double(origin)) > 0.0)) ++behindCount;
                    if (!(side * HeightAbove(placed, AsDeviceHasIt(placed, origin)) > 0.0)) ++behindCount;
                }
                const double size = length(placed.Point()) + length(placed.translation) +
                                    length(placed.linear * placed.p0) + place.extent;
                largest = std::max(largest, double{clearance} / (size * 0x1p-23));
            }
            EXPECT_EQ(behindCount, 0)
                << place.extent << ' ' << place.far << ' ' << place.near << ", " << kind;
            // Rotations add up to the root of 3 on each axis, there and back; scale and shear some more
            EXPECT_LT(largest, kind == 0 ? 12.0 : 80.0) << place.far << ' ' << place.near << ", " << kind;
        }
    }
}

// The bound is made of what was rounded, axis by axis: what is exact costs nothing.
TEST(RayClearance, CountsOnlyWhatHasAnErrorAlongTheNormal) {
    Placed wall;  // faces along x, a meter wide, 100 m off along y
    wall.p0 = vec3(0.0f, 100.0f, 0.0f);
    wall.e1 = vec3(0.0f, 1.0f, 0.0f);
    wall.e2 = vec3(0.0f, 0.0f, 1.0f);
    wall.weights = vec2(0.25f, 0.25f);
    const float near = wall.Clearance();
    EXPECT_GT(near, 0.0f);
    EXPECT_LT(near, 1e-6f);
    wall.translation = vec3(0.0f, 10000.0f, 5000.0f);
    EXPECT_LT(wall.Clearance(), 1e-6f) << "moved along itself";
    wall.translation = vec3(1000.0f, 0.0f, 0.0f);
    // Two roundings of its place, six of the terms of the inverse: o.x - t.x
    EXPECT_NEAR(wall.Clearance(), gpu::kRoundoff * (2.0f + 6.0f * 2.0f) * 1000.0f, 1e-5f);
    EXPECT_LT(wall.Clearance(), 0.9e-3f) << "a pane of 1 mm at 1 km";
    wall.translation = vec3(-1000.0f, 0.0f, 0.0f);
    wall.p0.x = 1000.0f;
    // Two of the vertices and three of the transform, and the inverse
    EXPECT_NEAR(wall.Clearance(), gpu::kRoundoff * (2.0f + 3.0f + 6.0f) * 1000.0f, 1e-5f)
        << "the place is near 0, its terms are not";
}

// From triangles of 1e-12 m to those of 1e12 m; their normals are in square meters.
TEST(RayClearance, IsInProportionToTheSizeOfTheWorld) {
    std::mt19937 generator(6);
    for (int i = 0; i < 1000; ++i) {
        const Placed placed = RandomTriangle(generator, 1, 1.0f, 1.0f, 1.0f);
        for (const float size : {0x1p-40f, 0x1p33f, 0x1p40f}) {
            Placed vertices = placed;
            for (vec3* v : {&vertices.p0, &vertices.e1, &vertices.e2, &vertices.translation}) *v *= size;
            const float expected = size * placed.Clearance();
            ASSERT_NEAR(vertices.Clearance(), expected, 1e-5f * expected) << size;
            Placed transform = placed;
            for (int axis = 0; axis < 3; ++axis) transform.linear[axis] *= size;
            transform.translation *= size;
            ASSERT_NEAR(transform.Clearance(), expected, 1e-5f * expected) << size;
        }
    }
}

TEST(RayClearance, GrowsWithTheScaleOfTheWorldAndIsFiniteForSlivers) {
    std::mt19937 generator(5);
    for (int i = 0; i < 1000; ++i) {
        Placed placed = RandomTriangle(generator, 1, 1.0f, 10.0f, 10.0f);
        const float clearance = placed.Clearance();
        placed.linear = mat3(64.0f * placed.linear[0], 64.0f * placed.linear[1], 64.0f * placed.linear[2]);
        placed.translation *= 64.0f;
        EXPECT_NEAR(placed.Clearance(), 64.0f * clearance, 1e-3f * 64.0f * clearance);
        placed = RandomTriangle(generator, 1, 1.0f, 1.0f, 10.0f);
        placed.e2 = placed.e1 + 1e-5f * UnitVector(generator);
        EXPECT_GT(placed.Clearance(), 0.0f);
        EXPECT_LT(placed.Clearance(), 1e-3f);
        placed.e2 = placed.e1;  // without area
        EXPECT_GT(placed.Clearance(), 0.0f);
        EXPECT_LT(placed.Clearance(), 1e-3f);
    }
}

// Transforms under which a triangle has another shape in the world than in its object.
struct Distortion {
    const char* name;
    vec3 scale;
    float shear = 0.0f;  // shear of the first axis along the second one
    bool isTurned = false;
};
constexpr std::array kDistortions{Distortion{"none", vec3(1.0f)},
                                  Distortion{"flat along x", vec3(1.5e-5f, 1.0f, 1.0f)},
                                  Distortion{"flat along y", vec3(1.0f, 1.5e-5f, 1.0f)},
                                  Distortion{"flat along z", vec3(1.0f, 1.0f, 1.5e-5f)},
                                  Distortion{"flat and turned", vec3(1.0f, 1.0f, 1.5e-5f), 0.0f, true},
                                  Distortion{"slab", vec3(100.0f, 100.0f, 1.0f)},
                                  Distortion{"turned slab", vec3(100.0f, 100.0f, 0.01f), 0.0f, true},
                                  Distortion{"rail", vec3(1.0f, 1000.0f, 1.0f), 0.0f, true},
                                  Distortion{"sheared", vec3(1.0f), 300.0f, true}};

Placed Distorted(std::mt19937& generator, const Distortion& distortion) {
    Placed placed = RandomTriangle(generator, distortion.isTurned ? 1 : 0, 1.0f, 0.0f, 0.0f);
    placed.linear =
        placed.linear * mat3(vec3(distortion.scale.x, distortion.shear, 0.0f),
                             vec3(0.0f, distortion.scale.y, 0.0f), vec3(0.0f, 0.0f, distortion.scale.z));
    placed.translation = UnitVector(generator);
    return placed;
}

bool IsSliver(vec3 e1, vec3 e2) {
    const float extent = max(length(e1), max(length(e2), length(e2 - e1)));
    return length(cross(e1, e2)) < 0.05f * extent * extent;
}

// Tests rays in all directions away from the plane, many of them nearly along it.
TEST(RayClearance, NoTraversalMeetsTheTriangleThatARayLeaves) {
    constexpr uint32_t kTriangles = 500, kRays = 64;
    std::mt19937 generator(8);
    for (const Distortion& distortion : kDistortions) {
        std::array<uint32_t, 2> met{};
        double largest = 0.0;  // clearance over a step of float of the triangle's size and place
        for (uint32_t i = 0; i < kTriangles;) {
            const Placed placed = Distorted(generator, distortion);
            const vec3 e1 = placed.linear * placed.e1, e2 = placed.linear * placed.e2;
            if (IsSliver(placed.e1, placed.e2) || IsSliver(e1, e2)) continue;
            ++i;
            BvhScene scene;
            scene.meshes.push_back({{placed.p0, placed.p0 + placed.e1, placed.p0 + placed.e2}, {0, 1, 2}});
            scene.instances.push_back(
                {0, glm::mat4x3(placed.linear[0], placed.linear[1], placed.linear[2], placed.translation)});
            const std::array levels{BuildOneLevel(scene), testing::BuildWideScene(scene)};
            const float clearance = placed.Clearance();
            for (uint32_t ray = 0; ray < kRays; ++ray) {
                const vec3 normal = ray % 2 == 0 ? placed.Normal() : -placed.Normal();
                vec3 direction = UnitVector(generator);
                direction -= dot(direction, normal) * normal;
                direction += std::exp(-12.0f * Uniform(generator)) * normal;
                const gpu::BenchRay leaving{.origin = OffsetRayOrigin(placed.Point(), normal, clearance),
                                            .tMax = 1e30f,
                                            .direction = normalize(direction)};
                for (size_t level = 0; level < levels.size(); ++level)
                    met[level] += Traverse(levels[level], leaving, true).t >= 0.0f;
            }
            const double size = length(placed.Point()) + length(placed.translation) + length(e1) + length(e2);
            largest = std::max(largest, double{clearance} / (size * 0x1p-23));
        }
        EXPECT_EQ(met[0], 0u) << distortion.name << ", of one level";
        EXPECT_EQ(met[1], 0u) << distortion.name << ", of two levels";
        EXPECT_LT(largest, 80.0) << distortion.name;
    }
}

}  // namespace
}  // namespace raygraph::shading::ray_clearance_test
