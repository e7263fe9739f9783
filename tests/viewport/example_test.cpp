// Runs the example of docs/viewport.md, which shows this text.
#include <gtest/gtest.h>

#include <vector>

#include "editor/viewport/vulkan_interop.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/source_file.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::example_test {

namespace {

struct Host {
    std::vector<viewport::PickResult> picked;
    int framesLeft = 40;
    bool IsOpen() { return framesLeft-- > 0; }
    bool IsClicked() const { return framesLeft == 30; }
    bool IsDragging() const { return framesLeft < 20; }
    void Select(const viewport::PickResult& result) { picked.push_back(result); }
};

// clang-format off
void ShowInPanel(rhi::Device& device, VkImage panelImage, Extent2D panelSize, const char* file, Host& host) {
    Renderer renderer(device);
    GpuScene scene(renderer);
    scene::SceneData data = scene::LoadGltf(file);
    scene::CameraView camera = scene::ChooseView(data, "", 1.0f);
    scene.SetScene(std::move(data));

    viewport::Viewport viewport(renderer, scene, {.size = panelSize});
    viewport.SetBudget({.frameMs = 12.0, .whileMoving = viewport::MotionView::Raster});
    viewport.SetShow({.view = viewport::View::Wipe, .wipePosition = 0.5f});
    viewport::HostImage panel(device, {.image = panelImage, .extent = panelSize});
    viewport::Pick pick;

    while (host.IsOpen()) {
        if (host.IsDragging()) camera.eye += 0.01f * camera.right;
        viewport.SetCamera(camera);                      // the same camera again changes nothing
        if (host.IsClicked()) pick = viewport.RequestPick({panelSize.width / 2, panelSize.height / 2});
        if (pick.IsReady()) {                            // some frames later; nothing ever waits for it
            host.Select(pick.Result());
            pick = {};
        }
        renderer.BeginFrame();
        TextureId shown = viewport.Declare();
        if (shown.IsValid()) panel.Show(renderer, shown);
        renderer.Execute();
    }
}
// clang-format on

class Example : public VulkanTest {};

}  // namespace

TEST_F(Example, TheExample_Runs) {
    constexpr Extent2D kSize{32, 32};
    const rhi::Texture image = Device().CreateTexture({.name = "panel", .extent = kSize});
    Host host;
    const std::string scene = test::SourceFile("scenes/cornell.gltf").string();
    ShowInPanel(Device(), image.Image(), kSize, scene.c_str(), host);
    ASSERT_EQ(host.picked.size(), 1u);
    EXPECT_TRUE(host.picked[0].isHit);
}

}  // namespace raygraph::testing::example_test
