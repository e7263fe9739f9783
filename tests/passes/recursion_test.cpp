// LambertPath: the loop and the recursion that the bench compares do the same work.
#include "passes/recursion.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::recursion_test {

using passes::PathForm;

namespace {

class LambertPathTest : public VulkanTest {
  protected:
    void SetUp() override {
        VulkanTest::SetUp();
        if (!passes::CanRecurse(Device()))
            GTEST_SKIP() << "maxRayRecursionDepth is " << Device().Info().maxRayRecursionDepth;
    }
    FloatImage Render(PathForm form, const passes::TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback radiance =
            render.renderer.ReadBack(passes::LambertPath(render.renderer, ids, settings, form));
        render.renderer.Execute();
        return ToFloatImage(radiance);
    }

    SceneRender render{Device()};
};

// Largest difference of a component, relative to the larger of the two.
double LargestRelativeDifference(const FloatImage& a, const FloatImage& b) {
    double largest = 0.0;
    for (size_t i = 0; i < a.values.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double x = double{a.values[i][c]}, y = double{b.values[i][c]};
            if (x != y) largest = std::max(largest, std::abs(x - y) / std::max(std::abs(x), std::abs(y)));
        }
    return largest;
}

}  // namespace

TEST_F(LambertPathTest, BothForms_SumTenBouncesInAClosedBox) {
    const double albedo = 0.75, emission = 0.25;
    render.scene.SetScene(
        SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(float(albedo)), glm::vec3(float(emission)))}));
    const passes::TraceSettings settings = LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, 32);
    const double sum = emission * (1.0 - std::pow(albedo, kLambertBounces + 1)) / (1.0 - albedo);
    for (const PathForm form : {PathForm::Loop, PathForm::Recursive})
        for (const glm::vec4& value : Render(form, settings).values)
            ASSERT_NEAR(value.x, sum, 1e-5 * sum) << "form " << int(form);
}

TEST_F(LambertPathTest, BothForms_SeeTheSkyAndWhatAFloorReflectsOfIt) {
    render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {Lambert({0.5f, 0.25f, 0.125f})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(2.0f)});
    const passes::TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 1.0f, 32);
    for (const PathForm form : {PathForm::Loop, PathForm::Recursive}) {
        const FloatImage image = Render(form, settings);
        EXPECT_EQ(glm::vec3(image.At(0, 0)), glm::vec3(2.0f)) << "form " << int(form);
        EXPECT_EQ(glm::vec3(image.At(16, 16)), glm::vec3(1.0f, 0.5f, 0.25f)) << "form " << int(form);
    }
}

// Boxes under a sky: paths of every length.
TEST_F(LambertPathTest, BothForms_GiveTheSamePicture) {
    render.scene.SetScene(SceneOf(
        {BoxMesh(0.4f, 0), SphereMesh(0.5f, 12, 1), QuadMesh(2.0f, 2)},
        {Lambert({0.8f, 0.3f, 0.1f}), Lambert(glm::vec3(0.9f), {0.0f, 0.2f, 0.4f}), Lambert(glm::vec3(0.7f))},
        {Translation({0.4f, -0.5f, 0.5f}), Translation({-0.6f, 0.2f, 0.55f}), glm::mat4x3(1.0f)}));
    render.scene.SetEnvironment({.radiance = {0.5f, 0.6f, 0.7f}});
    passes::TraceSettings settings = LookAt({0.5f, -2.0f, 2.0f}, {0, 0, 0.3f}, 0.9f, 64);
    settings.sampleIndex = 3;
    const FloatImage loop = Render(PathForm::Loop, settings);
    const FloatImage recursive = Render(PathForm::Recursive, settings);
    EXPECT_LT(LargestRelativeDifference(loop, recursive), 1e-5);
    settings.sampleIndex = 4;
    EXPECT_GT(LargestRelativeDifference(loop, Render(PathForm::Recursive, settings)), 0.1)
        << "another sample is another picture";
}

}  // namespace raygraph::testing::recursion_test
