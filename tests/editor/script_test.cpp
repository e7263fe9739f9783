// Tests the editor by scripts, without a window.
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <string>

#include "base/error.h"
#include "base/files.h"
#include "editor/app/file_content.h"
#include "editor/app/script.h"
#include "editor/session/file/content_hash.h"
#include "editor/session/file/render_file.h"
#include "editor/session/session.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/variants.h"
#include "tests/editor/editor_test.h"
#include "tests/support/environment_variable.h"
#include "tests/support/error_of.h"

namespace raygraph::editor::script_test {

namespace {

class ScriptTest : public EditorTest {
  protected:
    // Returns the message of the error with which the script ends.
    std::string Failure(const std::string& text) {
        return testing::ErrorOf([&] { Play(text); }).what();
    }
};

}  // namespace

TEST_F(ScriptTest, OpensEmptyAndLeavesABrokenFileAside) {
    Play("size 320x200\nview raster\nframes 2\n");
    const std::filesystem::path broken = folder.Path() / "broken.gltf";
    std::ofstream(broken) << "{ \"asset\": 3 }";
    Play(OpenCornell());
    const size_t nodes = editor.Work().document.Scene().nodes.size();
    EXPECT_GT(nodes, 0u);
    Play("open " + broken.string() + "\nwait\nexpect message broken.gltf\n");
    EXPECT_EQ(editor.Work().document.Scene().nodes.size(), nodes) << "the scene that was there stays";
}

TEST_F(ScriptTest, TogglesPicksEditsAndUndoes) {
    Play(OpenCornell() +
         "frames 3\nkey V\nexpect view path-traced\nkey V\nexpect view raster\n"
         "mouse 320 120\nclick left\nwait\n");
    ASSERT_TRUE(editor.Work().selectedMaterial) << "the back wall is there";
    const uint32_t material = *editor.Work().selectedMaterial;
    const glm::vec4 color = editor.Work().document.Scene().materials[material].baseColorFactor;
    Play("material base 1 0 0\nexpect edits 1\nkey ctrl+z\nexpect edits 0\n");
    EXPECT_EQ(editor.Work().document.Scene().materials[material].baseColorFactor, color);
    Play("key ctrl+y\nexpect edits 1\n");
}

TEST_F(ScriptTest, GizmoDragIsOneStepThatCanBeUndoneOrGivenUp) {
    Play(OpenCornell() + "mouse 320 120\nclick left\nwait\n");
    Workspace& work = editor.Work();
    ASSERT_TRUE(work.selectedNode);
    const uint32_t node = *work.selectedNode;
    const glm::mat4x3 before = work.document.WorldTransform(node);
    const uint32_t resets = work.view.ResetCount(passes::ResetCause::Camera);
    work.pivot = GizmoPivot::Origin;
    // The tip of the handle of y, in the picture, which lies between the panels
    const Extent2D size = work.view.Size();
    const PictureMap map(work.camera.View(), {size.width, size.height});
    const GizmoFrame frame = *FrameOf(before, GizmoTool::Move, GizmoSpace::World, map);
    const glm::vec2 tip =
        *map.PlaceOf(frame.origin + glm::vec3(0, 0.8f * frame.size, 0)) + glm::vec2(editor.PictureOrigin());
    const std::string there = "mouse " + std::to_string(tip.x) + " " + std::to_string(tip.y) + "\n";
    Play("size 640x400\nview raster\nframes 2\n" + there + "drag left 3 -40\nexpect edits 1\n");
    const glm::mat4x3 after = work.document.WorldTransform(node);
    EXPECT_GT(after[3].y, before[3].y);
    EXPECT_EQ(after[3].x, before[3].x);
    EXPECT_EQ(work.selectedNode, node) << "and the camera stays";
    EXPECT_EQ(work.view.ResetCount(passes::ResetCause::Camera), resets);
    Play("size 640x400\nkey ctrl+z\nexpect edits 0\n");
    EXPECT_EQ(work.document.WorldTransform(node), before);
    // Escape cancels the drag
    Play("size 640x400\n" + there + "press left\nmouse 320 60\nexpect edits 1\nkey escape\nexpect edits 0\n" +
         "release left\n");
    EXPECT_EQ(work.document.WorldTransform(node), before);
    // With the pivot in the middle, a rotation keeps the middle in place
    Play("size 640x400\nkey P\nkey E\nkey X\nframes 2\n");
    const scene::Bounds bounds = work.document.BoundsOf(node);
    const GizmoFrame middle = *FrameOf(before, GizmoTool::Rotate, GizmoSpace::Local, map, bounds.Center());
    const glm::vec2 ring =
        *map.PlaceOf(middle.origin + 1.15f * middle.size * map.View().up) + glm::vec2(editor.PictureOrigin());
    Play("size 640x400\nmouse " + std::to_string(ring.x) + " " + std::to_string(ring.y) +
         "\ndrag left 40 10\nexpect edits 1\n");
    const glm::mat4x3 turned = work.document.WorldTransform(node);
    EXPECT_NE(turned, before);
    const glm::vec3 inside = glm::inverse(glm::mat4(before)) * glm::vec4(bounds.Center(), 1.0f);
    EXPECT_LT(glm::length(turned * glm::vec4(inside, 1.0f) - bounds.Center()), 1e-4f);
    Play("size 640x400\nkey R\nframes 1\nkey escape\n");
    EXPECT_EQ(work.tool, GizmoTool::Scale);
    EXPECT_EQ(work.toolSpace, GizmoSpace::Local);
    EXPECT_FALSE(work.selectedNode);
}

TEST_F(ScriptTest, GizmoMovesAndTurnsAllThatIsSelectedOnceInOneStep) {
    Play(OpenCornell() + "select tall block\nkey P\n");
    Workspace& work = editor.Work();
    const Document& document = work.document;
    const std::vector<uint32_t> all = document.Scene().nodeOrder;
    const uint32_t room = all[0], block = all[1], below = all[2];
    work.Reparent(below, block);
    const auto place = [&](uint32_t node) { return glm::mat4(document.WorldTransform(node)); };
    const std::vector<glm::mat4> before{place(room), place(block), place(below)};
    const PictureMap map(work.camera.View(), {work.view.Size().width, work.view.Size().height});
    const auto drag = [&](GizmoTool tool, const glm::vec3& at, const char* way) {
        const GizmoFrame frame = *FrameOf(document.WorldTransform(below), tool, GizmoSpace::World, map);
        const glm::vec2 there =
            *map.PlaceOf(frame.origin + frame.size * at) + glm::vec2(editor.PictureOrigin());
        return "size 640x400\nselect room, short block, tall block\nmouse " + std::to_string(there.x) + " " +
               std::to_string(there.y) + "\ndrag left " + way + "\nexpect edits 2\n";
    };
    Play(drag(GizmoTool::Move, {0, 0.8f, 0}, "3 -40"));
    const glm::mat4 moved = place(room) * glm::inverse(before[0]);
    EXPECT_GT(moved[3].y, 0.0f);
    const auto expectAlike = [&](const glm::mat4& change) {
        for (const auto& [node, old] : {std::pair(block, before[1]), std::pair(below, before[2])})
            for (int column = 0; column < 4; ++column)
                EXPECT_LT(glm::length(place(node)[column] - (change * old)[column]), 1e-5f) << node;
    };
    expectAlike(moved);
    Play("size 640x400\nkey ctrl+z\nexpect edits 1\n");
    EXPECT_EQ(place(room), before[0]);
    EXPECT_EQ(place(below), before[2]);
    Play("size 640x400\nkey E\n" + drag(GizmoTool::Rotate, 1.15f * map.View().up, "40 10"));
    const glm::mat4 turned = place(room) * glm::inverse(before[0]);
    EXPECT_LT(turned[0][0], 0.999f);
    expectAlike(turned);
}

TEST_F(ScriptTest, SavedPictureHasNoOutline) {
    const std::string plain = (folder.Path() / "plain.png").string();
    const std::string selected = (folder.Path() / "selected.png").string();
    const std::string window = (folder.Path() / "window.png").string();
    Play(OpenCornell() + "samples 1\npicture " + plain +
         "\nmouse 320 120\nclick left\nwait\nframes 3\npicture " + selected + "\nwindow " + window + "\n");
    ASSERT_TRUE(editor.Work().selectedNode);
    EXPECT_NE(editor.Work().renderer.DescribePlan().find("DrawOutline"), std::string::npos);
    const auto bytes = [](const std::string& file) {
        std::ifstream stream(file, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(stream), {});
    };
    EXPECT_EQ(bytes(plain), bytes(selected));
    // The window shows the picture
    const std::string shown = bytes(window);
    const image::Image8 picture = image::DecodeImage8(std::as_bytes(std::span(shown)), "window.png");
    size_t orange = 0;
    for (size_t i = 0; i < picture.rgba.size(); i += 4)
        orange += picture.rgba[i] > 240 && picture.rgba[i + 1] > 140 && picture.rgba[i + 1] < 175 &&
                  picture.rgba[i + 2] < 70;
    EXPECT_GT(orange, 100u);
}

class DefaultViewTest : public EditorTest {
  protected:
    DefaultViewTest() : EditorTest({.shaders = {}, .log = std::make_shared<LogHistory>()}) {}

    // Opens a scene in a window of that size, and draws until the view has been chosen.
    void Choose(const std::string& size, const std::string& more = {}) {
        editor.Work().ChooseViewByTime();
        Play("size " + size + "\nframes 3\n");
        EXPECT_EQ(editor.Work().view.Show().view, viewport::View::PathTraced)
            << "there is nothing to measure";
        Play("size " + size + "\nopen " + test::SourceFile("scenes/cornell.gltf").string() + "\nwait\n" +
             more + "frames 60\n");
        EXPECT_FALSE(editor.Work().IsChoosingView());
    }
    // Returns how many lines of the log say which view was chosen.
    size_t LinesAboutIt() {
        const std::vector<testing::MessageLog::Message> all = Log().All();
        return static_cast<size_t>(std::ranges::count_if(all, [](const testing::MessageLog::Message& one) {
            return one.level == LogLevel::Info && one.text.starts_with("the view is ");
        }));
    }
    const size_t linesBefore = LinesAboutIt();
    viewport::ShowSettings Shown() { return editor.Work().view.Show(); }
};

TEST_F(DefaultViewTest, IsRealTimeWhereFramesAreFast) {
    editor.Work().panels = {};
    Choose("120x100");
    EXPECT_EQ(Shown().view, viewport::View::RealTime);
    EXPECT_FALSE(Shown().isDenoised);
    EXPECT_EQ(LinesAboutIt() - linesBefore, 1u);
    EXPECT_LE(editor.Work().view.Progress().realTimeMs.value(), Workspace::kMostRealTimeMs);
    EXPECT_FALSE(editor.Work().SettingsToSave().view.has_value()) << "the next start measures again";
    Play("size 120x100\nkey V\n");
    EXPECT_EQ(editor.Work().SettingsToSave().view, viewport::View::Raster);
    Play("size 120x100\nkey V\nexpect view real-time\n");
}

TEST_F(DefaultViewTest, IsPathTracedAndDenoisedWhereTheyAreNot) {
    editor.Work().panels = {};
    Choose("2000x1200");
    EXPECT_EQ(Shown().view, viewport::View::PathTraced);
    EXPECT_TRUE(Shown().isDenoised);
    EXPECT_EQ(LinesAboutIt() - linesBefore, 1u);
    EXPECT_GT(editor.Work().view.Progress().realTimeMs.value(), Workspace::kMostRealTimeMs);
    EXPECT_FALSE(editor.Work().SettingsToSave().view.has_value());
}

TEST_F(DefaultViewTest, IsTheUsersWhereOneWasChosen) {
    Choose("120x100", "key V\n");
    EXPECT_EQ(Shown().view, viewport::View::Raster);
    EXPECT_EQ(editor.Work().SettingsToSave().view, viewport::View::Raster);
}

TEST_F(ScriptTest, SavedPicturesSayThatTheyAreDenoised) {
    const auto file = [&](const char* name) { return (folder.Path() / name).string(); };
    Play(OpenCornell() + "size 160x120\nbudget 0\nview path-traced\ndenoise on\nframes 60\npicture " +
         file("a.png") + "\nexpect message , denoised from\npicture " + file("a.exr") +
         "\nexpect message , with a denoised picture\ndenoise off\npicture " + file("b.png") + "\n");
    EXPECT_EQ(editor.Work().message.find("denoised"), std::string::npos);
    const auto texels = [&](const char* name) {
        return image::DecodeImage8(ReadFile(file(name)), name).rgba;
    };
    EXPECT_NE(texels("a.png"), texels("b.png"));
    EXPECT_GT(SampleCount(session::ReadRenderFile(file("a.exr")).samples), 10u);
}

TEST_F(ScriptTest, ErrorsOfTheRealTimeViewAreMeasuredWhileTheStatisticsShowThem) {
    const RealTimeErrorHistory& errors = editor.Work().realTimeErrors;
    Play(OpenCornell() + "size 200x200\ncompare real-time\nview wipe\nsamples 2\n");
    EXPECT_TRUE(errors.IsEmpty()) << "nobody looks";
    Play("size 200x600\nkey T\nsamples 4\nframes 4\n");
    EXPECT_FALSE(errors.IsEmpty());
    Play("size 200x600\ncompare raster\n");
    EXPECT_TRUE(errors.IsEmpty());
    EXPECT_NE(Failure("compare nothing\n").find("there is no picture to compare \"nothing\""),
              std::string::npos);
}

TEST_F(ScriptTest, DragTurnsTheCameraAndSizesMayBeAny) {
    Play(OpenCornell());
    const glm::dvec3 eye = editor.Work().camera.View().eye;
    Play("size 640x400\nmouse 320 200\ndrag left 60 0\n");
    EXPECT_NE(editor.Work().camera.View().eye, eye);
    EXPECT_FALSE(editor.Work().selectedNode) << "a drag is no click";
    Play("size 1x1\nsize 37x911\nsize 0x0\nsize 700x20\nsize 640x400\nframes 2\n");
}

// The picture is between two panels of equal width.
TEST_F(ScriptTest, LineOfTheWipeIsDraggedAndTheCameraStays) {
    Play(OpenCornell() + "size 640x400\nview wipe\nframes 2\n");
    const glm::dvec3 eye = editor.Work().camera.View().eye;
    const auto width = static_cast<float>(editor.Work().view.Size().width);
    Play("size 640x400\nmouse 320 300\ndrag left 60 10\n");
    EXPECT_NEAR(editor.Work().view.Show().wipePosition, 0.5f + 60.0f / width, 2.0f / width);
    EXPECT_EQ(editor.Work().camera.View().eye, eye);
    Play("size 640x400\nmouse 350 300\ndrag left 0 20\n");
    EXPECT_NEAR(editor.Work().view.Show().wipePosition, 0.5f + 60.0f / width, 2.0f / width);
    EXPECT_NE(editor.Work().camera.View().eye, eye) << "the line is not there";
}

TEST_F(ScriptTest, BordersOfPanelsAreDraggedAndADoubleClickGivesTheirOwnSizeBack) {
    Play(OpenCornell() + "size 1000x600\nframes 2\n");
    Workspace& work = editor.Work();
    const glm::dvec3 eye = work.camera.View().eye;
    Play("size 1000x600\nmouse 260 300\ndrag left 40 0\nmouse 740 100\ndrag left -20 0\n");
    EXPECT_EQ(work.panelSizes.left, 300.0f);
    EXPECT_EQ(work.panelSizes.right, 280.0f);
    EXPECT_EQ(work.view.Size().width, 1000u - 300u - 280u);
    EXPECT_EQ(work.camera.View().eye, eye);
    Play("size 1000x600\nmouse 300 300\nclick left\nclick left\nframes 1\n");
    EXPECT_EQ(work.panelSizes.left, 0.0f);
    EXPECT_EQ(work.panelSizes.right, 280.0f);
    EXPECT_EQ(work.view.Size().width, 1000u - 260u - 280u);
}

TEST_F(ScriptTest, PlanOfNoFrameIsNotShown) {
    FrameInput input;
    input.extent = {320, 200};
    class Closed final : public Screen {
      public:
        std::optional<TextureId> Begin(Renderer&, rhi::Extent2D) override { return std::nullopt; }
        void End(Renderer&, TextureId) override {}
    } closed;
    editor.Work().panels.graph = true;
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(editor.Frame(input, closed));
    EXPECT_TRUE(editor.Frame(input, screen));
    EXPECT_TRUE(editor.Frame(input, screen));
    EXPECT_EQ(editor.FrameError(), "");
}

// Refused edits are logged, but not at every frame.
TEST_F(ScriptTest, RefusedDragAndDroppedFramesAreOneWarningEach) {
    Play(OpenCornell());
    const auto warnings = [before = Log().Count()](const std::string& part) {
        const std::vector<testing::MessageLog::Message> all = Log().All();
        return std::count_if(
            all.begin() + static_cast<std::ptrdiff_t>(before), all.end(), [&](const auto& one) {
                return one.level == LogLevel::Warning && one.text.find(part) != std::string::npos;
            });
    };
    Workspace& work = editor.Work();
    const TransformEdit refused{0, glm::mat4x3(std::numeric_limits<float>::infinity())};
    for (int frame = 0; frame < 3; ++frame) work.Apply(refused);
    EXPECT_EQ(warnings("finite numbers"), 1);
    EXPECT_NE(work.message.find("finite numbers"), std::string::npos) << work.message;
    work.Apply(MaterialEdit{0, work.document.Scene().materials[0]});
    work.Apply(refused);
    EXPECT_EQ(warnings("finite numbers"), 2) << "another drag";

    class Broken final : public Screen {
      public:
        std::optional<TextureId> Begin(Renderer&, rhi::Extent2D) override {
            throw Error(ErrorKind::Vulkan, "no image of the window");
        }
        void End(Renderer&, TextureId) override {}
    } broken;
    FrameInput input;
    input.extent = {320, 200};
    for (int frame = 0; frame < 3; ++frame) editor.Frame(input, broken);
    EXPECT_EQ(editor.FrameError(), "no image of the window");
    EXPECT_EQ(warnings("no image of the window"), 1);
    editor.Frame(input, screen);
    EXPECT_EQ(editor.FrameError(), "");
    editor.Frame(input, broken);
    EXPECT_EQ(warnings("no image of the window"), 2) << "it has been well in between";
}

TEST_F(ScriptTest, FailedSavesAreInTheLog) {
    Play(OpenCornell() + "samples 1\n");
    const auto logged = [before = Log().Count()](const std::string& part) {
        return Log().Text(before).find(part) != std::string::npos;
    };
    const std::string none = (folder.Path() / "none" / "a").string();
    Failure("picture " + none + ".png\n");
    EXPECT_TRUE(logged(none + ".png"));
    Failure("scene " + none + ".gltf\n");
    EXPECT_TRUE(logged(none + ".gltf"));
    Failure("picture " + none + ".exr\n");
    EXPECT_TRUE(logged(none + ".exr"));
    Failure("picture " + (folder.Path() / "a.tga").string() + "\n");
    EXPECT_TRUE(logged("must end in .png or .exr"));
    std::ofstream(folder.Path() / "config") << "no folder";
    Play("config " + (folder.Path() / "config").string() + "\nkey T\n");
    EXPECT_TRUE(logged((folder.Path() / "config").string()));
}

// The files were left by an earlier run.
TEST_F(ScriptTest, AnOldFileIsNoPictureThatWasSaved) {
    const std::string render = (folder / "old.exr").string(), taken = (folder / "old.png").string();
    std::ofstream(render) << "old";
    std::filesystem::create_directory(taken);
    Play("size 320x200\nview surface\n");
    EXPECT_NE(Failure("picture " + render + "\n").find("shows no light"), std::string::npos);
    EXPECT_NE(Failure(OpenCornell() + "window " + taken + "\n").find("old.png"), std::string::npos);
    EXPECT_NE(Failure("picture " + taken + "\n").find("old.png"), std::string::npos);
}

TEST_F(ScriptTest, SavesTheWindow) {
    const std::filesystem::path file = folder.Path() / "window.png";
    Play(OpenCornell() + "key F1\nkey G\nkey T\nframes 4\nwindow " + file.string() + "\n");
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(stream), {});
    const image::Image8 picture = image::DecodeImage8(std::as_bytes(std::span(bytes)), "window.png");
    EXPECT_EQ(picture.width, 640u);
    EXPECT_EQ(picture.height, 400u);
    size_t bright = 0;
    for (size_t i = 0; i < picture.rgba.size(); i += 4) bright += picture.rgba[i] > 150;
    EXPECT_GT(bright, 200u) << "text and picture";
}

TEST_F(ScriptTest, SettingsAreKeptWhereTheScriptSaysAndNowhereElse) {
    const std::filesystem::path config = folder.Path() / "config";
    const test::EnvironmentVariable home("XDG_CONFIG_HOME", folder / "home");
    Play(OpenCornell() + "key T\nframes 1\n");
    EXPECT_FALSE(std::filesystem::exists(folder.Path() / "home"));
    Play("config " + config.string() + "\n" + OpenCornell() + "view wipe\nkey T\nkey E\nframes 1\n");
    std::string message;
    const Settings kept = ReadSettings(config, message);
    EXPECT_EQ(kept.view, viewport::View::Wipe);
    EXPECT_TRUE(kept.panels.statistics);
    EXPECT_EQ(kept.tool, GizmoTool::Rotate);
    EXPECT_EQ(kept.window, (rhi::Extent2D{640, 400}));
    ASSERT_EQ(kept.recent.size(), 1u);
    EXPECT_EQ(kept.recent[0].filename(), "cornell.gltf");
    Play("config " + config.string() + "\nexpect view wipe\n");
    std::ofstream(config / "editor.json") << "{ broken";
    Play("config " + config.string() + "\nexpect message editor.json\n");
}

TEST_F(ScriptTest, ControlSSavesOverTheFileAndAKeyThatDoesNothingSaysWhy) {
    const std::filesystem::path file = folder.Path() / "own.gltf";
    Play(
        "size 640x400\nkey ctrl+s\nexpect message Ctrl+S: there is no scene to save\n"
        "key ctrl+z\nexpect message Ctrl+Z: there is nothing to undo\n"
        "key space\nexpect message Space: the scene has no animation\n"
        "key J\nexpect message J does nothing; F1 lists the keys\n");
    Play(OpenCornell() + "scene " + file.string() + "\nkey ctrl+s\nexpect message saved the view: \n" +
         "mouse 320 120\nclick left\nwait\nmaterial base 0.25 0.5 1\nkey ctrl+s\nexpect message saved\n");
    EXPECT_FALSE(editor.Work().document.IsEdited());
    const uint32_t material = *editor.Work().selectedMaterial;
    EXPECT_EQ(scene::LoadGltf(file).materials[material].baseColorFactor, glm::vec4(0.25f, 0.5f, 1.0f, 1.0f));
}

TEST_F(ScriptTest, KeysLookAlongAxesAndChangeTheProjection) {
    Play(OpenCornell() + "view raster\nkey 7\nframes 1\n");
    const CameraController& camera = editor.Work().camera;
    EXPECT_EQ(camera.View().forward, glm::vec3(0.0f, -1.0f, 0.0f));
    Play(
        "size 640x400\nkey ctrl+3\nkey 5\nframes 1\nkey ctrl+shift+1\nexpect message camera kept under "
        "Shift+1\n"
        "key 1\n");
    EXPECT_EQ(camera.View().forward, glm::vec3(0.0f, 0.0f, -1.0f));
    EXPECT_EQ(camera.View().projection, scene::Projection::Orthographic);
    Play("size 640x400\nkey 5\nkey shift+1\n");
    EXPECT_EQ(camera.View().forward, glm::vec3(1.0f, 0.0f, 0.0f)) << "the view from the left was kept";
    Play("size 640x400\nkey shift+2\nexpect message there is no camera under Shift+2\n");
}

TEST_F(ScriptTest, KeysAreBoundInTheHelpAndStored) {
    const std::filesystem::path config = folder.Path() / "config";
    Workspace& work = editor.Work();
    Play("config " + config.string() + "\nsize 640x400\nkey f1\nframes 1\n");
    work.actionToBind = Action::Move;
    Play("size 640x400\nkey V\nexpect message V is no longer: raster, and back\nkey escape\n");
    EXPECT_FALSE(work.panels.help) << "Escape closes it";
    work.tool = GizmoTool::Scale;
    Play("size 640x400\nkey W\nexpect message W does nothing; F1 lists the keys\nkey V\n");
    EXPECT_EQ(work.tool, GizmoTool::Move);
    std::string message;
    EXPECT_EQ(ReadSettings(config, message).keys, work.keys);
    EXPECT_EQ(work.keys.Changed(), (std::vector{Action::Raster, Action::Move}));
    std::ofstream(config / "editor.json") << R"({"keys": {"preset": "blender", "hide": ["J", "Ctrl+J"]}})";
    Play("config " + config.string() + "\nsize 640x400\n");
    EXPECT_EQ(work.keys.ActionOf({Key::G}), Action::Move);
    EXPECT_EQ(work.keys.ActionOf({Key::J, true}), Action::Hide);
    EXPECT_EQ(work.keys.TextOf(Action::Graph), "") << "G is another's";
    std::ofstream(config / "editor.json") << R"({"keys": {"hide": ["Hyper+J"]}})";
    Play("config " + config.string() + "\nexpect message there is no modifier\n");
}

TEST_F(ScriptTest, TabStaysOutOfNumberFieldsAndScreenshotsAreNumbered) {
    Play(OpenCornell() +
         "view path-traced\nmouse 320 120\nclick left\nwait\nkey tab\nframes 2\nkey f12\nwait\nkey "
         "f12\nwait\n");
    EXPECT_NE(editor.Work().view.Show().view, viewport::View::PathTraced) << "Tab went to a field";
    EXPECT_TRUE(std::filesystem::exists(folder / "cornell-0001.png"));
    EXPECT_TRUE(std::filesystem::exists(folder / "cornell-0002.png"));
}

TEST_F(ScriptTest, SavesTheSceneWithItsEdits) {
    const std::string file = (folder.Path() / "saved.gltf").string();
    Play(OpenCornell() + "mouse 320 120\nclick left\nwait\nmaterial base 0.25 0.5 1\nscene " + file +
         "\nexpect message saved\n");
    const uint32_t material = *editor.Work().selectedMaterial;
    EXPECT_FALSE(editor.Work().document.IsEdited());
    EXPECT_EQ(scene::LoadGltf(file).materials[material].baseColorFactor, glm::vec4(0.25f, 0.5f, 1.0f, 1.0f));
    Play("size 640x400\nkey ctrl+z\n");
    EXPECT_TRUE(editor.Work().document.IsEdited()) << "than what was saved";
    Play("size 640x400\nkey ctrl+y\n");
    EXPECT_FALSE(editor.Work().document.IsEdited());
    // A file that another program has written meanwhile is not overwritten
    std::ofstream(file, std::ios::app) << " ";
    EXPECT_NE(Failure("scene " + file + "\n").find("has changed since it was opened"), std::string::npos);
    Failure("scene /nowhere/at/all.gltf\n");
}

// Frames follow until none is needed, like those of a window.
TEST_F(ScriptTest, PicturesOnTheirWayAreWrittenBeforeTheEditorCloses) {
    Play(OpenCornell());
    FrameInput input;
    input.extent = {640, 400};
    const auto close = [&] {
        input.isClosing = true;
        int frames = 1;
        for (; editor.Frame(input, screen) && frames < 1000; ++frames) input.isClosing = false;
        return frames;
    };
    editor.SavePicture(folder.Path() / "a.png");
    editor.SavePicture(folder.Path() / "a.exr");
    EXPECT_LT(close(), 1000);
    EXPECT_TRUE(std::filesystem::exists(folder.Path() / "a.png"));
    EXPECT_EQ(session::ReadRenderFile(folder.Path() / "a.exr").sceneFile, "cornell.gltf");
    EXPECT_TRUE(editor.IsQuitting());
}

// Pictures that can never arrive do not keep the editor open: the window is minimized.
TEST_F(ScriptTest, PicturesThatCannotBeTakenDoNotKeepTheEditorOpen) {
    Play(OpenCornell());
    editor.SavePicture(folder.Path() / "a.exr");
    FrameInput input;
    input.isClosing = true;
    EXPECT_FALSE(editor.Frame(input, screen));
    EXPECT_NE(editor.Work().message.find("a.exr: not saved"), std::string::npos) << editor.Work().message;
}

TEST_F(ScriptTest, ExrNamesTheFilesAndTheSkyOfTheFrameThatWasSaved) {
    image::ImageF sky{8, 4, std::vector<float>(8 * 4 * 4, 0.5f)};
    image::WriteHdr(folder.Path() / "sky.hdr", sky);
    const std::string open = OpenCornell() + "open " + (folder.Path() / "sky.hdr").string();
    Play(open + "\nwait\n");
    Workspace& work = editor.Work();
    const auto save = [&](auto&& change) {
        editor.SavePicture(folder.Path() / "picture.exr");
        change();  // changes before the next frame
        Play("size 640x400\nwait\n");
    };
    save([&] { work.gpu.SetEnvironment({.radiance = {0.25f, 0.5f, 1.0f}, .rotation = 0.5f}); });
    session::RenderFile saved = session::ReadRenderFile(folder.Path() / "picture.exr");
    session::PictureSettings settings = session::SettingsFrom(saved.settings);
    EXPECT_EQ(settings.environmentTint, (std::array{0.25f, 0.5f, 1.0f}));
    EXPECT_NEAR(settings.environmentRotation, glm::degrees(0.5f), 1e-4f);
    EXPECT_EQ(saved.environmentFile, "sky.hdr");
    EXPECT_EQ(saved.environmentHash,
              session::HashOf(image::ReadEnvironment(folder.Path() / "sky.hdr").image));
    EXPECT_EQ(saved.sceneFile, "cornell.gltf");
    save([&] { work.RemoveEnvironmentMap(); });
    saved = session::ReadRenderFile(folder.Path() / "picture.exr");
    EXPECT_EQ(saved.environmentFile + saved.environmentHash, "");
    settings = session::SettingsFrom(saved.settings);
    EXPECT_FALSE(settings.background);
    EXPECT_EQ(settings.light, DefaultLight::None) << "without the map the box has its lamp alone";
}

TEST_F(ScriptTest, ExrNamesLensAndRasterSettingsOfItsFrame) {
    viewport::Viewport& view = editor.Work().view;
    view.SetRaster({.shadows = passes::RasterShadows::Maps});
    Play(OpenCornell() + "samples 1\npicture " + (folder / "picture.exr").string() + "\n");
    EXPECT_EQ(session::SettingsFrom(session::ReadRenderFile(folder / "picture.exr").settings).raster,
              view.Raster());
    viewport::CaptureResult picture{.extent = {4, 2}, .lens = {.radius = 0.125f, .focusDistance = 2.5f}};
    const session::SettingTexts texts = RenderOf(std::move(picture), {}, Device().Info()).settings;
    EXPECT_EQ(session::SettingsFrom(texts).aperture, 0.125f);
    EXPECT_EQ(session::SettingsFrom(texts).focusDistance, 2.5f);
}

TEST_F(ScriptTest, ExrIsOfTheFileWhereNoEditsAreUnsaved) {
    const std::filesystem::path file = folder.Path() / "edited.gltf", picture = folder.Path() / "picture.exr";
    const auto save = [&] {
        Play("picture " + picture.string() + "\nexpect message sample\n");
        return session::ReadRenderFile(picture).sceneHash;
    };
    const auto hashOf = [](const std::filesystem::path& scene) {
        return session::HashOf(scene::LoadGltf(scene));
    };
    Play(OpenCornell() + "samples 1\n");
    EXPECT_EQ(save(), hashOf(test::SourceFile("scenes/cornell.gltf")));
    Play("mouse 320 120\nclick left\nwait\nmaterial base 1 0 0\nexpect edits 1\nsamples 1\n");
    EXPECT_EQ(save(), "") << "an edit is in no file";
    Play("scene " + file.string() + "\nsamples 1\n");
    EXPECT_EQ(save(), hashOf(file));
    EXPECT_NE(hashOf(file), hashOf(test::SourceFile("scenes/cornell.gltf")));
}

TEST_F(ScriptTest, SavesAnExr) {
    const std::string file = (folder.Path() / "picture.exr").string();
    Play(OpenCornell() + "size 320x200\nsamples 1\npicture " + file + "\nexpect message sample\n");
    const session::RenderFile saved = session::ReadRenderFile(file);
    const session::PictureSettings settings = session::SettingsFrom(saved.settings);
    EXPECT_EQ(saved.sceneFile, "cornell.gltf");
    EXPECT_EQ(settings.view, session::View::Raster);
    EXPECT_GE(SampleCount(saved.samples), 1u);
    EXPECT_EQ(saved.size, editor.Work().view.Size());
    EXPECT_EQ(settings.camera, session::CameraText(editor.Work().camera.View()));
    Play("size 320x200\npicture " + (folder / "Other.Exr").string() + "\n");
    EXPECT_EQ(session::ReadRenderFile(folder / "Other.Exr").size, saved.size);
    EXPECT_NE(Failure("picture " + (folder.Path() / "picture.bmp").string() + "\n").find(".png or .exr"),
              std::string::npos);
    EXPECT_NE(Failure("picture " + (folder.Path() / "missing" / "a.exr").string() + "\n").find("missing"),
              std::string::npos);
}

TEST_F(ScriptTest, EnvironmentMapIsLoadedAndStaysWithTheNextScene) {
    const std::filesystem::path file = folder.Path() / "sky.hdr";
    image::ImageF sky{8, 4, std::vector<float>(8 * 4 * 4, 0.5f)};
    image::WriteHdr(file, sky);
    Play(OpenCornell() + "open " + file.string() + "\nwait\n");
    Workspace& work = editor.Work();
    EXPECT_EQ(work.EnvironmentFile(), file);
    EXPECT_EQ(work.gpu.Environment().radiance, glm::vec3(1.0f));
    Play(OpenCornell());
    EXPECT_EQ(work.EnvironmentFile(), file);
    EXPECT_EQ(work.gpu.Environment().radiance, glm::vec3(1.0f)) << "a scene with lights does not put it out";
    std::ofstream(folder.Path() / "broken.hdr") << "no picture";
    Play("open " + (folder.Path() / "broken.hdr").string() + "\nwait\nexpect message broken.hdr\n");
    EXPECT_EQ(work.EnvironmentFile(), file);
    work.RemoveEnvironmentMap();
    EXPECT_TRUE(work.EnvironmentFile().empty());
}

TEST_F(ScriptTest, FailuresNameTheLine) {
    EXPECT_NE(Failure("frames 1\n\nsmile\n").find("script.txt:3: smile"), std::string::npos);
    EXPECT_NE(Failure("expect view raster\n").find("it is 'path-traced'"), std::string::npos);
    EXPECT_NE(Failure("key Nokey\n").find("Nokey"), std::string::npos);
    EXPECT_NE(Failure("size big\n").find("script.txt:1"), std::string::npos);
}

TEST_F(ScriptTest, MistakesAreFoundBeforeAnythingIsPlayed) {
    const std::filesystem::path picture = folder.Path() / "picture.png";
    EXPECT_NE(Failure("size 64x48\nwindow " + picture.string() + "\nsmile\n").find("script.txt:3"),
              std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(picture));
}

TEST_F(ScriptTest, KeysWhileFlyingOnlyFly) {
    Play(OpenCornell() +
         "mouse 320 200\npress right\nkey ctrl+q\nkey V\nexpect view raster\n"
         "release right\nkey V\nexpect view path-traced\n");
}

TEST_F(ScriptTest, ReloadSaysThatThereAreNoSources) {
    Play("key F5\nexpect message --shaders\n");
}

}  // namespace raygraph::editor::script_test

// Tests the parser of scripts, without playing them.
namespace raygraph::editor::script_commands_test {

namespace {

template <typename Command>
Command Only(const std::string& text) {
    const std::vector<ScriptLine> lines = ParseScript(text, "s");
    EXPECT_EQ(lines.size(), 1u) << text;
    return std::get<Command>(lines.at(0).command);
}

std::string Refusal(const std::string& text) {
    try {
        ParseScript(text, "s");
    } catch (const Error& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        return error.what();
    }
    return "";
}

}  // namespace

TEST(ScriptCommands, AreReadWithTheirNumbersAndTexts) {
    EXPECT_TRUE(ParseScript("", "s").empty());
    const std::vector<ScriptLine> lines = ParseScript("# nothing\n\n  wait   # until then\nclose", "s");
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_EQ(lines[0].number, 3u);
    EXPECT_EQ(lines[0].text, "wait");
    EXPECT_EQ(lines[1].number, 4u);
    EXPECT_EQ(Only<SetSize>("size 640x0").extent, (rhi::Extent2D{640, 0}));
    EXPECT_EQ(Only<MoveMouse>("mouse -3 2.5").place, glm::vec2(-3.0f, 2.5f));
    EXPECT_EQ(Only<DropFile>("open a b.gltf").file, "a b.gltf");
    EXPECT_EQ(Only<TypeText>("text gr\xC3\xBC\xC3\x9F \xF0\x9F\x98\x80").text, U"gr\u00FC\u00DF \U0001F600");
    const PressKey key = Only<PressKey>("key ctrl+shift+z");
    EXPECT_TRUE(key.key == Key::Z && key.isControl && key.isShift);
    const HoldButton drag = Only<HoldButton>("drag middle 3 -4");
    EXPECT_TRUE(drag.button == MouseButton::Middle && drag.isDown && drag.isUp && drag.isDragged);
    EXPECT_EQ(drag.way, glm::vec2(3.0f, -4.0f));
    const HoldButton click = Only<HoldButton>("click ctrl+shift+right");
    EXPECT_TRUE(click.button == MouseButton::Right && click.isControl && click.isShift);
    EXPECT_FALSE(Only<HoldButton>("press left").isUp);
    EXPECT_FALSE(Only<HoldButton>("release left").isDown);
    EXPECT_EQ(Only<Expectation>("expect view side by side").view, viewport::View::SideBySide);
    EXPECT_EQ(Only<Expectation>("expect samples-above 7").number, 7u);
    EXPECT_EQ(Only<PlayFor>("play 0.5").seconds, 0.5);
    EXPECT_EQ(Only<ShowTime>("time 2").seconds, 2.0);
    EXPECT_EQ(Only<ChooseClips>("clips walk:0.3,look left").list, "walk:0.3,look left");
    EXPECT_EQ(Only<Expectation>("expect time 0.250").text, "0.250");
    EXPECT_EQ(Only<Expectation>("expect playing yes").number, 1u);
}

TEST(ScriptCommands, RefusalsNameTheLine) {
    EXPECT_EQ(Refusal("wait\n\nsmile at me\n"), "s:3: smile at me: there is no such command");
    EXPECT_EQ(Refusal("mouse 1"), "s:1: mouse 1: a word is missing");
    EXPECT_EQ(Refusal("text"), "s:1: text: a word is missing");
    EXPECT_EQ(Refusal("click leftmost"), "s:1: click leftmost: there is no mouse button \"leftmost\"");
    EXPECT_EQ(Refusal("key alt+z"), "s:1: key alt+z: there is no modifier \"alt\"");
    EXPECT_EQ(Refusal("expect asking perhaps"),
              "s:1: expect asking perhaps: it is yes or no, not \"perhaps\"");
}

// Otherwise numbers would be cast to types that cannot hold them, or play forever.
TEST(ScriptCommands, NumbersAreFiniteAndInRange) {
    for (const char* line : {"frames 1e30",         "frames -1",       "frames 1.5",
                             "frames nan",          "samples -1",      "samples 1e10",
                             "samples inf",         "mouse nan 0",     "mouse 0 1e30",
                             "drag left inf 0",     "wheel nan",       "size 1e9x1",
                             "size -1x1",           "scale 0",         "scale nan",
                             "budget -1",           "budget inf",      "material base 1 nan 0",
                             "material base 2 0 0", "expect edits -1", "expect samples-below x"})
        EXPECT_NE(Refusal(line), "") << line;
    for (const char* line : {"play -1", "play nan", "play 1e9", "time -1", "time inf"})
        EXPECT_NE(Refusal(line), "") << line;
}

TEST(ScriptCommands, ControlCharactersAndBrokenUtf8AreRefused) {
    for (const char* line : {"text a\x1b[31m", "open \xFF.gltf", "text \xC3", "open a\x7F"}) {
        const std::string refusal = Refusal(line);
        EXPECT_NE(refusal.find("has control characters"), std::string::npos) << refusal;
        EXPECT_EQ(refusal.find_first_of("\x1b\x7f\xff\xc3"), std::string::npos) << "nor has the message";
    }
}

}  // namespace raygraph::editor::script_commands_test

// Tests a whole visit to the editor: everything that a user does, and more often than a user would.
namespace raygraph::editor::visit_test {

class VisitTest : public EditorTest {};

TEST_F(VisitTest, OpensOrbitsTogglesEditsUndoesPicksSavesResizesAndForgivesABrokenFile) {
    const std::string broken = (folder.Path() / "broken.glb").string();
    std::ofstream(broken) << "glTF and no more";
    const auto file = [&](const char* name) { return (folder.Path() / name).string(); };
    std::ostringstream script;
    script
        << "size 400x260\nopen " << test::SourceFile("scenes/cornell.gltf").string() << "\nwait\n"
        << "mouse 200 100\ndrag left 40 10\ndrag middle 5 5\nwheel 1\nframes 2\n"
        << "key V\nframes 2\nkey V\nframes 2\nkey C\nframes 2\nview relative error\nframes 3\nkey C\nkey C\n"
        << "mouse 200 90\nclick left\nwait\nmaterial base 0.1 0.9 0.2\nexpect edits 1\nkey ctrl+z\nexpect "
           "edits 0\n"
        << "key T\nframes 2\nkey G\nframes 2\nkey F1\nframes 2\nkey F1\nkey T\nkey G\n"
        << "picture " << file("picture.png") << "\nscene " << file("scene.glb") << "\nwindow "
        << file("window.png") << "\n";
    for (int i = 0; i < 200; ++i) script << "size " << 1 + i * 73 % 400 << "x" << 1 + i * 51 % 260 << "\n";
    script << "size 400x260\nopen " << broken
           << "\nwait\nexpect message broken.glb\nbudget 0\nview path-traced\nsamples 2\nexpect edits 0\n";
    Play(script.str());
    // Counts the colors in a picture's first columns
    const auto colors = [](const image::Image8& picture, uint32_t columns) {
        std::set<std::array<uint8_t, 3>> seen;
        for (size_t i = 0; i < picture.rgba.size(); i += 4)
            if (i / 4 % picture.width < columns)
                seen.insert({picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]});
        return seen.size();
    };
    const auto read = [&](const char* name) { return image::DecodeImage8(ReadFile(file(name)), name); };
    const image::Image8 picture = read("picture.png"), window = read("window.png");
    EXPECT_EQ(window.width, 400u);
    EXPECT_EQ(window.height, 260u);
    const glm::ivec2 origin = editor.PictureOrigin();
    EXPECT_EQ(int(picture.width), 400 - 2 * origin.x) << "panels of one width on both sides";
    EXPECT_LT(int(picture.height), 260 - origin.y) << "and a status line";
    EXPECT_GT(colors(picture, picture.width), 100u) << "a room";
    const size_t panelColors = colors(window, static_cast<uint32_t>(origin.x));
    EXPECT_GT(panelColors, 5u) << "a panel on its left, with text";
    EXPECT_GT(colors(window, window.width), 2 * panelColors) << "and the picture beside it";
    // The undone edit has left nothing, neither here nor in the file
    const scene::SceneData original = scene::LoadGltf(test::SourceFile("scenes/cornell.gltf"));
    EXPECT_EQ(session::HashOf(scene::LoadGltf(file("scene.glb"))), session::HashOf(original));
    const Document& document = editor.Work().document;
    EXPECT_EQ(document.File(), file("scene.glb"));
    EXPECT_FALSE(document.IsEdited());
    EXPECT_EQ(document.Scene().nodes.size(), original.nodes.size());
    for (size_t i = 0; i < original.materials.size(); ++i)
        EXPECT_EQ(document.Scene().materials.at(i).baseColorFactor, original.materials[i].baseColorFactor);
}

}  // namespace raygraph::editor::visit_test

// Tests variants of a scene's materials in the editor.
namespace raygraph::editor::variant_test {

using VariantTest = EditorTest;

// In the Cornell box, the variant "paint" gives all meshes but the lamp one material.
TEST_F(VariantTest, IsShownInAllViewsAndIsNoEdit) {
    nlohmann::json json = nlohmann::json::parse(std::ifstream(test::SourceFile("scenes/cornell.gltf")));
    json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "paint"}}, {{"name", "plain"}}};
    for (nlohmann::json& mesh : json["meshes"])
        for (nlohmann::json& primitive : mesh["primitives"])
            if (primitive["material"] != 3)
                primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
                    {{"material", 0}, {"variants", {0}}}};
    const std::filesystem::path file = folder.Path() / "box.gltf", picture = folder.Path() / "picture.exr",
                                saved = folder.Path() / "saved.gltf";
    std::ofstream(file) << json;
    Workspace& work = editor.Work();
    const auto save = [&](const std::string& script) {
        Play("size 120x100\n" + script + "picture " + picture.string() + "\nexpect message sample\n");
        return session::ReadRenderFile(picture);
    };
    const auto hashOf = [](const std::filesystem::path& of, uint32_t variant) {
        scene::SceneData scene = scene::LoadGltf(of);
        scene::SetVariant(scene, variant);
        return session::HashOf(scene);
    };
    for (const std::string view : {"path-traced", "raster"}) {
        SCOPED_TRACE(view);
        Play("size 120x100\nbudget 0\nopen " + file.string() + "\nwait\nview " + view +
             "\nexpect variant none\n");
        const session::RenderFile plain = save("samples 1\n");
        const auto resets = [&] { return work.view.ResetCount(passes::ResetCause::Geometry); };
        const uint32_t before = resets();
        const session::RenderFile paint = save("variant paint\nexpect variant paint\nsamples 1\n");
        EXPECT_GT(resets(), before) << "samples of the other materials are gone";
        EXPECT_NE(paint.radiance, plain.radiance);
        EXPECT_EQ(paint.settings.at("variant"), "paint");
        EXPECT_EQ(paint.sceneHash, hashOf(file, 0));
        EXPECT_EQ(plain.settings.at("variant"), "");
        EXPECT_EQ(plain.sceneHash, hashOf(file, scene::kNone));
    }
    EXPECT_EQ(save("variant 1\nexpect variant plain\nsamples 1\n").sceneHash, hashOf(file, scene::kNone));
    Play("size 120x100\nvariant none\nexpect variant none\n");
    EXPECT_NE(std::string(testing::ErrorOf([&] { Play("variant red\n"); }).what())
                  .find("there is no variant \"red\""),
              std::string::npos);
    EXPECT_EQ(work.document.EditCount(), 0u);
    // Edits apply to the active materials, and saving keeps the variants
    Play("size 120x100\nvariant paint\nmouse 60 40\nclick left\nwait\n");
    ASSERT_EQ(work.selectedMaterial, 0u);
    Play("size 120x100\nmaterial base 0.25 0.5 1\nscene " + saved.string() +
         "\nexpect variant paint\nexpect edits 1\n");
    scene::SceneData scene = scene::LoadGltf(saved);
    EXPECT_EQ(scene.variants, (std::vector<std::string>{"paint", "plain"}));
    EXPECT_EQ(scene.materials[0].baseColorFactor, glm::vec4(0.25f, 0.5f, 1.0f, 1.0f));
    EXPECT_EQ(scene.meshes[0].primitives[1].material, 2u);
    EXPECT_EQ(save("samples 1\n").sceneHash, hashOf(saved, 0));
}

}  // namespace raygraph::editor::variant_test

// Tests of the light in which the editor shows the open scene.
namespace raygraph::editor::light_test {

namespace {

class LightTest : public EditorTest {
  protected:
    LightTest() { editor.Work().UseLight(DefaultLight::Auto); }
    static std::string Open(const char* name) {
        return "size 320x200\nview raster\nopen " + test::SourceFile(std::string("scenes/") + name).string() +
               "\nwait\n";
    }
    bool HasStudio() { return editor.Work().gpu.ShownEnvironment().defaultLight == DefaultLight::Studio; }
    std::string LightOfSaved() {
        const std::string file = (folder.Path() / "saved.exr").string();
        Play("samples 1\npicture " + file + "\nexpect message sample\n");
        return session::ReadRenderFile(file).settings.at("light");
    }
};

}  // namespace

TEST_F(LightTest, ASceneWithoutLightIsShownInTheStudioAndSavedSo) {
    Play(Open("furnace_sphere.gltf"));
    EXPECT_TRUE(HasStudio());
    EXPECT_EQ(LightOfSaved(), "studio");
    Play(Open("cornell.gltf"));
    EXPECT_FALSE(HasStudio());
    EXPECT_EQ(LightOfSaved(), "none");
}

TEST_F(LightTest, TheStudioIsTurnedOnAndOffForScenesToCome) {
    editor.Work().UseLight(DefaultLight::None);
    Play(Open("furnace_sphere.gltf"));
    EXPECT_FALSE(HasStudio());
    editor.Work().UseLight(DefaultLight::Studio);
    EXPECT_TRUE(HasStudio());
    Play(Open("cornell.gltf"));
    EXPECT_TRUE(HasStudio()) << "it is asked for";
}

TEST_F(LightTest, AllThreeChoicesAreThereInWhateverOrder) {
    EXPECT_EQ(editor.Work().Light(), DefaultLight::Auto);
    for (const DefaultLight before : {DefaultLight::None, DefaultLight::Studio}) {
        editor.Work().UseLight(before);
        Play(Open("furnace_sphere.gltf"));
        editor.Work().UseLight(DefaultLight::Auto);
        EXPECT_EQ(editor.Work().Light(), DefaultLight::Auto);
        EXPECT_TRUE(HasStudio());
        Play(Open("cornell.gltf"));
        EXPECT_FALSE(HasStudio()) << "the scene has a lamp";
    }
}

TEST_F(LightTest, AMapTakesItsPlaceUntilItIsRemoved) {
    Play(Open("furnace_sphere.gltf"));
    image::WriteHdr(folder.Path() / "sky.hdr", {2, 1, std::vector<float>(8, 0.5f)});
    Play("size 320x200\nopen " + (folder.Path() / "sky.hdr").string() + "\nwait\n");
    EXPECT_FALSE(HasStudio());
    editor.Work().RemoveEnvironmentMap();
    EXPECT_TRUE(HasStudio());
}

}  // namespace raygraph::editor::light_test
