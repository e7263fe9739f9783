#include "renderer/scene/environment.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raygraph::test {
namespace {

using glm::vec3;

glm::mat3 Turn(float degrees) {
    scene::EnvironmentDesc environment;
    environment.rotationDegrees = degrees;
    return scene::WorldToEnvironment(environment);
}

TEST(Environment, QuarterTurnsAreExact) {
    EXPECT_EQ(Turn(0), glm::mat3(1));
    EXPECT_EQ(Turn(360), glm::mat3(1));
    // Turned by 90 degrees about +y, what was seen along +x is seen along -z, so -z looks +x up.
    EXPECT_EQ(Turn(90) * vec3(0, 0, -1), vec3(1, 0, 0));
    EXPECT_EQ(Turn(-90) * vec3(0, 0, 1), vec3(1, 0, 0));
    EXPECT_EQ(Turn(180) * vec3(1, 0, 0), vec3(-1, 0, 0));
    EXPECT_EQ(Turn(270), Turn(-90));
}

TEST(Environment, AnyTurnIsARotationAboutY) {
    for (const float degrees : {1.0f, 44.0f, 46.0f, 133.0f, -200.0f, 725.0f}) {
        const glm::mat3 turn = Turn(degrees);
        EXPECT_EQ(turn * vec3(0, 1, 0), vec3(0, 1, 0));
        EXPECT_NEAR(glm::determinant(turn), 1.0f, 1e-6f);
        const float angle = glm::radians(degrees);
        const vec3 seen =
            turn * vec3(std::cos(angle), 0, -std::sin(angle));  // +x turned by `degrees` about +y.
        EXPECT_NEAR(seen.x, 1.0f, 1e-5f) << degrees;
        EXPECT_NEAR(seen.z, 0.0f, 1e-5f) << degrees;
    }
}

TEST(Environment, IntensityScalesTheColour) {
    scene::EnvironmentDesc environment;
    EXPECT_TRUE(environment.IsConstant());
    EXPECT_FALSE(environment.IsBlack());
    environment.color = vec3(1, 2, 3);
    environment.intensity = 2.0f;
    EXPECT_EQ(environment.Scale(), vec3(2, 4, 6));
    environment.intensity = 0.0f;
    EXPECT_TRUE(environment.IsBlack());
}

}  // namespace
}  // namespace raygraph::test
