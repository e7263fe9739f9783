// Tests the reload of shaders while the editor runs.
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <sstream>
#include <string>

#include "editor/app/editor.h"
#include "editor/app/script.h"
#include "editor/app/window.h"
#include "tests/rhi/fake_loader.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::editor::reload_test {

namespace {

// Loads shaders from a folder that a test may change.
class ReloadTest : public testing::VulkanTest {
  protected:
    ReloadTest() {
        std::filesystem::copy(test::SourceFile("shaders"), m_folder / "shaders",
                              std::filesystem::copy_options::recursive);
        m_editor = std::make_unique<Editor>(Device(), EditorOptions{.shaders = m_folder / "shaders"});
    }

    test::TemporaryFolder m_folder;
    PictureScreen m_screen;
    std::unique_ptr<Editor> m_editor;
};

}  // namespace

TEST_F(ReloadTest, SaysWhetherShadersHaveChanged) {
    const std::filesystem::path file = m_folder / "script.txt",
                                changed = m_folder / "shaders/post/tonemap.comp";
    const auto play = [&](const std::string& text) {
        std::ofstream(file) << text;
        Script(file).Play(*m_editor, m_screen);
    };
    play("size 320x200\nopen " + test::SourceFile("scenes/cornell.gltf").string() +
         "\nwait\n"
         "view raster\nsamples 1\nkey F5\nexpect message no shader has changed\n");
    std::stringstream text;
    text << std::ifstream(changed).rdbuf();
    std::string source = text.str();
    const std::string line = "vec4(shown, alpha)";
    ASSERT_NE(source.find(line), std::string::npos);
    std::ofstream(changed) << source.replace(source.find(line), line.size(), "vec4(shown, 0.5f * alpha)");
    play("size 320x200\nkey F5\nexpect message shaders reloaded\n");
    play("size 320x200\nkey F5\nexpect message no shader has changed\n");
}

// F5 does not block the frames until the path tracer's pipeline is ready: shaders are reloaded after that.
TEST(ReloadWhilePreparing, WaitsForNoPipelineThatIsBeingMade) {
    const test::TemporaryFolder folder;
    std::filesystem::copy(test::SourceFile("shaders"), folder / "shaders",
                          std::filesystem::copy_options::recursive);
    testing::FakeLoader loader;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.savePipelineCache = false, .getInstanceProcAddr = loader.Entry()});
    PictureScreen screen;
    Editor editor(*device, EditorOptions{.shaders = folder / "shaders"});
    Workspace& work = editor.Work();
    viewport::BudgetSettings budget = work.view.Budget();
    budget.whilePreparing = viewport::PreparingView::Preview;
    work.view.SetBudget(budget);
    FrameInput input;
    input.extent = {320, 200};
    const auto isTracerComing = [&] {
        return work.view.Progress().isPreview && work.renderer.IsPreparingPipelines();
    };
    editor.Frame(input, screen);  // makes the preview's pipeline
    ASSERT_TRUE(work.view.Progress().isPreview);
    std::promise<void> mayBegin;  // holds back the next pipeline
    loader.Tell().beforeRayTracing = mayBegin.get_future().share();
    for (int frame = 0; frame < 1000 && !isTracerComing(); ++frame) editor.Frame(input, screen);
    ASSERT_TRUE(isTracerComing());
    input.pressed = {Key::F5};
    editor.Frame(input, screen);
    EXPECT_TRUE(isTracerComing());
    EXPECT_EQ(work.message, "shaders are reloaded once the pipelines are there");
    input.pressed.clear();
    mayBegin.set_value();
    while (work.renderer.IsPreparingPipelines()) editor.Frame(input, screen);
    editor.Frame(input, screen);
    EXPECT_EQ(work.message, "no shader has changed");
    EXPECT_EQ(editor.FrameError(), "");
}

}  // namespace raygraph::editor::reload_test
