#include "editor/app/scene_panels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>

namespace raygraph::editor::placement_test {

namespace {

const glm::mat4x3 kSheared(glm::vec3(2, 0, 0), glm::vec3(0.6f, 1, 0), glm::vec3(0, 0.3f, 0.5f),
                           glm::vec3(1, 2, 3));

float Apart(const glm::mat4x3& a, const glm::mat4x3& b) {
    float most = 0.0f;
    for (int i = 0; i < 4; ++i) most = std::max(most, glm::length(a[i] - b[i]));
    return most;
}

}  // namespace

TEST(Placement, MoveLeavesTheAxesToTheBit) {
    const Placement before = PlacementOf(kSheared);
    Placement after = before;
    after.translation.y = 7.0f;
    glm::mat4x3 moved = kSheared;
    moved[3].y = 7.0f;
    EXPECT_EQ(Placed(kSheared, before, after), moved);
    EXPECT_EQ(Placed(kSheared, before, before), kSheared);
}

TEST(Placement, RotationTurnsAShearedNodeAsAWhole) {
    const Placement before = PlacementOf(kSheared);
    Placement after = before;
    after.degrees = {20.0f, -30.0f, 40.0f};
    const glm::mat4x3 turned = Placed(kSheared, before, after);
    // Lengths and angles of the axes are the shear
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(glm::dot(turned[i], turned[k]), glm::dot(kSheared[i], kSheared[k]), 1e-5f);
    const Placement read = PlacementOf(turned);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(read.degrees[i], after.degrees[i], 1e-3f) << "what was typed";
    EXPECT_LT(Apart(Placed(turned, read, before), kSheared), 1e-5f) << "and back";
}

TEST(Placement, ScaleStretchesOneAxisAlone) {
    const Placement before = PlacementOf(kSheared);
    Placement after = before;
    after.scale.y *= 3.0f;
    glm::mat4x3 wanted = kSheared;
    wanted[1] *= 3.0f;
    EXPECT_LT(Apart(Placed(kSheared, before, after), wanted), 1e-6f);
    const Placement read = PlacementOf(wanted);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(read.degrees[i], before.degrees[i], 1e-3f);
}

TEST(Placement, MirroredAndFlatNodes) {
    const glm::mat4x3 mirrored(glm::scale(glm::mat4(1.0f), glm::vec3(-2.0f, 1.0f, 1.0f)));
    const Placement placed = PlacementOf(mirrored);
    EXPECT_EQ(placed.scale, glm::vec3(-2.0f, 1.0f, 1.0f));
    EXPECT_LT(glm::length(placed.degrees), 1e-4f);
    Placement after = placed;
    after.scale.x = 2.0f;
    EXPECT_LT(Apart(Placed(mirrored, placed, after), glm::mat4x3(glm::scale(glm::mat4(1.0f), {2, 1, 1}))),
              1e-6f);
    glm::mat4x3 flat(1.0f);
    flat[2] = glm::vec3(0.0f);
    const Placement of = PlacementOf(flat);
    after = of;
    after.scale.z = 2.0f;
    EXPECT_LT(glm::length(Placed(flat, of, after)[2] - glm::vec3(0, 0, 2)), 1e-5f);
}

}  // namespace raygraph::editor::placement_test
