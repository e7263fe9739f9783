// The outline of the selection: with hand-made texels, and in a viewport.
#include "passes/overlay.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "base/error.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/scene/animation/deform.h"
#include "tests/support/option_rows.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::outline_test {

using ::testing::HasSubstr;
using ::testing::Not;

namespace {

class Outline : public VulkanTest {
  protected:
    // Of what each pixel shows, instance + 1: the line around some instances.
    Texels LineOf(const std::vector<float>& seen, Extent2D from, Extent2D extent,
                  const std::vector<uint32_t>& instances, float width) {
        std::vector<float> hits;
        for (const float instance : seen) hits.insert(hits.end(), {instance, 7, 0, 0});
        return harness.Run([&](PassHarness& h) {
            const TextureId line = h.Graph().CreateTexture("line", {extent, Format::R32Float});
            return passes::OutlineInstances(h.Graph(), h.Texture("hits", from, Format::Rgba32Uint, hits),
                                            instances, line, width);
        });
    }
    PassHarness harness{Device()};
};

std::string Row(const Texels& line, uint32_t y) {
    std::string row;
    for (uint32_t x = 0; x < line.extent.width; ++x) {
        const float share = line.At(x, y)[0];
        row += share == 0.0f ? '.' : share == 1.0f ? '#' : '+';
    }
    return row;
}

class OutlinedViewport : public VulkanTest {
  protected:
    struct Shown {
        std::vector<uint8_t> picture, outlined;
    };
    Shown Frame() {
        viewed.renderer.BeginFrame();
        const TextureId picture = viewed.viewport.Declare();
        if (afterDeclare) afterDeclare();
        const TextureId outlined = viewed.viewport.DeclareOutline(picture);
        const Readback plain = viewed.renderer.ReadBack(picture), over = viewed.renderer.ReadBack(outlined);
        viewed.renderer.Execute();
        over.Wait();
        plain.Wait();
        const auto bytes = [](const Readback& readback) {
            const auto* first = reinterpret_cast<const uint8_t*>(readback.Bytes().data());
            return std::vector<uint8_t>(first, first + readback.Bytes().size());
        };
        return {bytes(plain), bytes(over)};
    }
    static size_t DifferentPixels(const Shown& shown) {
        size_t count = 0;
        for (size_t i = 0; i < shown.picture.size(); i += 4)
            count += !std::equal(&shown.picture[i], &shown.picture[i] + 4, &shown.outlined[i]);
        return count;
    }
    ViewedScene viewed{Device(), {48, 32}};
    std::function<void()> afterDeclare;
};

}  // namespace

TEST_F(Outline, LineLiesAroundTheInstancesAndNotOnThem) {
    const std::vector<float> seen{0, 0, 0,  0,  0, 0, 0,  //
                                  0, 0, 0,  0,  0, 0, 0,  //
                                  0, 0, 34, 34, 5, 0, 0,  //
                                  0, 0, 34, 34, 5, 0, 0,  //
                                  0, 0, 0,  0,  0, 0, 0};
    const Texels one = LineOf(seen, {7, 5}, {7, 5}, {33}, 1.0f);
    EXPECT_EQ(Row(one, 0), ".......");
    EXPECT_EQ(Row(one, 1), ".+##+..") << "corners are farther away: sqrt 2";
    EXPECT_EQ(Row(one, 2), ".#..#..") << "of the other instance's pixels, too";
    EXPECT_EQ(Row(one, 4), ".+##+..");
    EXPECT_NEAR(one.At(1, 1)[0], 2.0f - std::sqrt(2.0f), 1e-5f);
    const Texels both = LineOf(seen, {7, 5}, {7, 5}, {4, 33}, 1.0f);
    EXPECT_EQ(Row(both, 2), ".#...#.") << "nothing between what belongs together";
    const Texels wide = LineOf(seen, {7, 5}, {7, 5}, {33}, 2.0f);
    EXPECT_EQ(Row(wide, 2), "##..##.");
    EXPECT_EQ(Row(LineOf(seen, {7, 5}, {7, 5}, {100}, 1.0f), 2), ".......") << "which nothing shows";
}

TEST_F(Outline, CoarserHitsGiveACoarserLine) {
    const std::vector<float> seen{0, 0, 0, 9, 0, 0};
    const Texels line = LineOf(seen, {3, 2}, {6, 4}, {8}, 1.0f);
    EXPECT_EQ(Row(line, 0), "......");
    EXPECT_EQ(Row(line, 1), "##+...");
    EXPECT_EQ(Row(line, 3), "..#...");
}

TEST_F(Outline, DrawnLineCoversThePictureByItsShare) {
    const Texels drawn = harness.Run([&](PassHarness& h) {
        return passes::DrawOutline(h.Graph(), h.Texture("picture", {3, 1}, Format::Rgba8Unorm, {0, 0, 1, 1}),
                                   h.Texture("line", {3, 1}, Format::R32Float, {0.0f, 0.5f, 1.0f}),
                                   {1, 0, 0});
    });
    EXPECT_EQ(drawn.At(0, 0)[2], 1.0f);
    EXPECT_NEAR(drawn.At(1, 0)[0], 0.5f, 0.01f);
    EXPECT_NEAR(drawn.At(1, 0)[2], 0.5f, 0.01f);
    EXPECT_EQ(drawn.At(2, 0)[0], 1.0f);
    EXPECT_EQ(drawn.At(2, 0)[2], 0.0f);
    EXPECT_EQ(drawn.At(2, 0)[3], 1.0f);
}

TEST_F(Outline, RefusesWhatItCannotDraw) {
    EXPECT_THROW(LineOf({1}, {1, 1}, {2, 2}, {0}, 0.0f), Error);
    EXPECT_THROW(LineOf({1}, {1, 1}, {2, 2}, {0}, 9.0f), Error);
}

TEST_F(OutlinedViewport, SelectionIsOutlinedAndAccumulationGoesOn) {
    viewed.RenderFrames(2);
    const uint32_t samples = viewed.Samples(), resets = viewed.AllResets();
    EXPECT_EQ(DifferentPixels(Frame()), 0u) << "nothing is selected";
    EXPECT_THAT(viewed.renderer.DescribePlan(), Not(HasSubstr("Outline")));
    viewed.viewport.SetOutlined({1});
    const size_t line = DifferentPixels(Frame());
    EXPECT_GT(line, 30u);
    EXPECT_LT(line, 500u);
    EXPECT_THAT(viewed.renderer.DescribePlan(), HasSubstr("OutlineInstances"));
    EXPECT_EQ(DifferentPixels(Frame()), line);
    EXPECT_THAT(viewed.renderer.DescribePlan(), Not(HasSubstr("OutlineInstances"))) << "it is kept";
    EXPECT_EQ(viewed.Samples(), samples + 3);
    EXPECT_EQ(viewed.AllResets(), resets);
    viewed.viewport.SetOutlined({});
    EXPECT_EQ(DifferentPixels(Frame()), 0u);
}

TEST_F(OutlinedViewport, LineFollowsCameraTransformAndSize) {
    viewed.viewport.SetOutlined({1});
    const Shown before = Frame();
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.2f;
    viewed.viewport.SetCamera(camera);
    Frame();
    EXPECT_THAT(viewed.renderer.DescribePlan(), HasSubstr("OutlineInstances"));
    viewed.scene.SetTransform(1, Translation({0.2f, -0.4f, 0.1f}));
    Frame();
    EXPECT_THAT(viewed.renderer.DescribePlan(), HasSubstr("OutlineInstances"));
    viewed.viewport.SetSize({20, 30});
    EXPECT_EQ(Frame().outlined.size(), size_t{20} * 30 * 4);
    viewed.viewport.SetView(View::SideBySide);
    EXPECT_EQ(DifferentPixels(Frame()), 0u);
}

// The line is drawn again after every change of the scene that may move it, and after no other.
TEST_F(OutlinedViewport, LineFollowsEveryChangeOfTheSceneThatMayMoveIt) {
    scene::SceneData data = Boxes();
    scene::Mesh& inner = data.meshes[1];
    inner.weights = {0.0f};
    scene::MorphTarget& target = inner.primitives[0].targets.emplace_back();
    for (const glm::vec3& position : inner.primitives[0].positions)
        target.positions.push_back({0.5f * position.y, 0, 0});
    scene::UpdateDeformationBounds(inner.primitives[0]);
    data.instances[1].isDeformed = true;
    scene::Material veil = data.materials[1];
    veil.alphaMode = scene::AlphaMode::Blend;
    veil.baseColorFactor.a = 0.75f;
    data.materials[1] = veil;
    viewed.scene.SetScene(std::move(data));
    viewed.viewport.SetOutlined({1});
    veil.baseColorFactor.a = 0.5f;
    scene::Light light = viewed.scene.Light(0);
    light.intensity *= 2.0f;
    struct Edit {
        const char* name;
        bool moves;
        std::function<void(GpuScene&)> apply;
    };
    const Edit edits[] = {
        {"shape", true, [](GpuScene& scene) { scene.SetMorphWeights(1, std::array{1.0f}); }},
        {"transform", true,
         [](GpuScene& scene) {
             scene.SetTransform(1, Translation({0.2f, -0.4f, 0}));
         }},
        {"light", false, [&](GpuScene& scene) { scene.SetLight(0, light); }},
        {"environment", false, [](GpuScene& scene) { scene.SetEnvironment({.radiance = glm::vec3(1.0f)}); }},
        {"visibility", true, [](GpuScene& scene) { scene.SetVisible(0, false); }},
        {"alpha", true, [&](GpuScene& scene) { scene.SetMaterial(1, veil); }},
    };
    auto rows = OptionRowsOf<SceneRevisions>([](SceneRevisions& s) {
        auto& [geometry, transforms, shapes, materials, lights, environment] = s;
        return std::tie(geometry, transforms, shapes, materials, lights, environment);
    });
    const auto isDrawn = [&] {
        Frame();
        return viewed.renderer.DescribePlan().find("OutlineInstances") != std::string::npos;
    };
    Frame();
    for (const Edit& edit : edits) {
        SCOPED_TRACE(edit.name);
        const SceneRevisions before = viewed.scene.Revisions();
        edit.apply(viewed.scene);
        rows.Add(edit.name, before, viewed.scene.Revisions());
        EXPECT_EQ(isDrawn(), edit.moves);
        EXPECT_FALSE(isDrawn());
    }
    rows.ExpectComplete();
    viewed.viewport.SetOutlined({0});
    EXPECT_TRUE(isDrawn()) << "of another instance";
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.2f;
    viewed.viewport.SetCamera(camera);
    viewed.viewport.SetBudget({.frameMs = 1e6, .settleMs = 1e9});
    EXPECT_TRUE(isDrawn()) << "coarse, while the camera moves";
    EXPECT_FALSE(isDrawn());
    viewed.viewport.SetBudget({.frameMs = 1e6, .settleMs = 0.0});
    EXPECT_TRUE(isDrawn()) << "as fine as it is when nothing moves";
    EXPECT_FALSE(isDrawn());
}

TEST_F(OutlinedViewport, CameraSetAfterDeclareIsOfTheNextFramesLine) {
    viewed.viewport.SetOutlined({1});
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.2f;
    afterDeclare = [&] { viewed.viewport.SetCamera(camera); };
    Frame();  // the line of where the camera was
    afterDeclare = {};
    Frame();
    EXPECT_THAT(viewed.renderer.DescribePlan(), HasSubstr("OutlineInstances"));
}

}  // namespace raygraph::testing::outline_test
