// Poses whose values belong together: what is applied is legal, and the rest comes back as it was.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "renderer/scene/animation/pose.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/pose_scene.h"

namespace raygraph::scene::pose_legal_test {
namespace {

using List = std::vector<uint32_t>;

uint8_t EmissiveFactor() {
    uint8_t index = 0, found = 255;
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), glm::vec3 Material::*>)
            if (field.member == &Material::emissiveFactor) found = index;
        ++index;
    });
    return found;
}

// A mesh with two morph targets, a camera and a spot light.
class LegalPose : public ::testing::Test {
  protected:
    const PoseChanges& At(double seconds, uint32_t animation = 0) {
        if (!m_evaluator) m_evaluator.emplace(m_scene);
        if (!m_applier) m_applier.emplace(m_scene);
        const std::array clips{ClipState{animation, seconds}};
        const PoseChanges& changes = m_applier->Apply(m_scene, m_evaluator->Evaluate(m_scene, clips));
        EXPECT_NO_THROW(Check(m_scene));
        return changes;
    }

    SceneData m_scene = Chain();
    std::optional<PoseEvaluator> m_evaluator;
    std::optional<PoseApplier> m_applier;
};

// An inner angle above the outer one is cut off, whatever came before, and is back at rest. Only one of both is
// animated.
TEST_F(LegalPose, ConesStayCones) {
    m_scene.lights[0].innerConeAngle = 0.4f;
    m_scene.lights[0].outerConeAngle = 0.7f;
    Add(m_scene, {.property = AnimatedProperty::LightField, .field = 4}, {0.7f}, {0.1f});
    Add(m_scene, {.property = AnimatedProperty::LightField, .field = 3}, {0.4f}, {0.9f});
    const Light& light = m_scene.lights[0];
    for (int i = 0; i < 2; ++i) {
        At(1);
        EXPECT_EQ(light.outerConeAngle, 0.1f);
        EXPECT_EQ(light.innerConeAngle, std::nextafter(0.1f, 0.0f));
        At(1, 1);
        EXPECT_EQ(light.outerConeAngle, 0.7f);
        EXPECT_EQ(light.innerConeAngle, std::nextafter(0.7f, 0.0f));
        At(0);
        EXPECT_EQ(light.outerConeAngle, 0.7f);
        EXPECT_EQ(light.innerConeAngle, 0.4f);
    }
}

TEST_F(LegalPose, CamerasKeepTheirNearPlaneBeforeTheFarOne) {
    m_scene.cameras[0].zNear = 0.5f;
    m_scene.cameras[0].zFar = 100.0f;
    Add(m_scene, {.property = AnimatedProperty::CameraField, .field = 3}, {100}, {0.25f});
    const Camera& camera = m_scene.cameras[0];
    EXPECT_EQ(At(1).cameras, List{0});
    EXPECT_EQ(camera.zFar, 0.25f);
    EXPECT_EQ(camera.zNear, std::nextafter(0.25f, 0.0f));
    At(0);
    EXPECT_EQ(camera.zFar, 100.0f);
    EXPECT_EQ(camera.zNear, 0.5f);
}

TEST_F(LegalPose, ProductsOfColorAndStrengthStayFinite) {
    constexpr float kMax = std::numeric_limits<float>::max();
    m_scene.materials[0].emissiveStrength = 1e38f;
    const uint8_t color = EmissiveFactor();
    Add(m_scene, {.property = AnimatedProperty::MaterialField, .field = color}, {1, 1, 1}, {9, 1, 1});
    m_scene.lights[0].intensity = 1e38f;
    Add(m_scene, {.property = AnimatedProperty::LightField, .field = 0}, {1, 1, 1}, {9, 1, 1});
    const Material& material = m_scene.materials[0];
    At(1);
    const bool isFinite = std::isfinite(material.EmittedRadiance().x);
    EXPECT_TRUE(isFinite);
    EXPECT_EQ(material.emissiveStrength, kMax / std::max(1.0f, material.emissiveFactor.x));
    At(1, 1);
    EXPECT_EQ(m_scene.lights[0].intensity, kMax / 9);
    EXPECT_EQ(material.emissiveStrength, 1e38f);
    At(0, 1);
    EXPECT_EQ(m_scene.lights[0].intensity, 1e38f);
}

// Numbers beyond what a float holds are at no place.
TEST_F(LegalPose, WhatIsDeformedBeyondNumbersIsHidden) {
    m_scene.meshes[0].primitives[0].targets[1].positions.assign(3, {0, 0, 10});
    UpdateDeformationBounds(m_scene.meshes[0].primitives[0]);
    Add(m_scene, OfNode(AnimatedProperty::Weights, 2), {0.5f, 0}, {0.5f, 3e38f});
    EXPECT_EQ(At(1).shown, List{0});
    EXPECT_FALSE(m_applier->IsVisible(0));
    EXPECT_TRUE(m_scene.instances[0].isCollapsed);
    EXPECT_TRUE(m_scene.bounds.IsEmpty());
    EXPECT_EQ(At(0).shown, List{0});
    EXPECT_TRUE(m_applier->IsVisible(0));
}

}  // namespace
}  // namespace raygraph::scene::pose_legal_test
