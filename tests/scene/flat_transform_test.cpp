// Tests of transforms that flatten a mesh into a plane, and of the invertible ones that replace them.
#include "renderer/scene/geometry/transforms.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <random>

#include "renderer/scene/model/check.h"

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
