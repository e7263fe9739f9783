// Tests renders beside the editor: the queue with small programs in place of `raygraph render`, the commands
// of the dialog, and a picture of the program itself.
#include "editor/app/render_queue.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "editor/app/render_dialog.h"
#include "editor/app/render_words.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/editor/editor_test.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/own_cache.h"
#include "tests/support/text_files.h"

namespace raygraph::editor {

namespace {

using State = RenderQueue::State;

RenderTask Shell(const std::string& text) {
    return {.command = {"sh", "-c", text}, .name = "a.png"};
}

// Goes on until the condition holds, for a minute at most.
template <typename Condition>
void Until(RenderQueue& queue, Condition&& holds) {
    const auto start = std::chrono::steady_clock::now();
    while (!holds() && std::chrono::steady_clock::now() - start < std::chrono::minutes(1)) {
        queue.Update();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(holds());
}

}  // namespace

TEST(RenderProgress, ReadsEventsAndLeavesOtherLines) {
    RenderProgress progress;
    EXPECT_TRUE(ReadProgress(
        R"({"event":"progress","picture":"frame 2 of 3","samples":32,"samples_wanted":128,"relative_error":0.034,)"
        R"("seconds_left":null})",
        progress));
    EXPECT_EQ(progress.text, "frame 2 of 3: 32 of 128 samples, error 3.4 %");
    EXPECT_EQ(progress.fraction, 0.25f);
    EXPECT_TRUE(ReadProgress(R"({"event":"written","files":["a.png","a.exr"]})", progress));
    EXPECT_EQ(progress.written, 1u);
    EXPECT_TRUE(ReadProgress(R"({"event":"loading","stage":"meshes","fraction":0.5})", progress));
    EXPECT_EQ(progress.text, "loading meshes");
    for (const char* line : {"", "a.png: 3 samples", "{", "{\"event\":3}", "[1]", "{}"})
        EXPECT_FALSE(ReadProgress(line, progress)) << line;
    EXPECT_EQ(progress.text, "loading meshes");
    const RenderQueue::Job job{.task = {.pictures = 4}, .progress = {.fraction = 0.5f, .written = 1}};
    EXPECT_EQ(job.Fraction(), 0.375f);
}

TEST(RenderQueue, RunsOneAfterAnotherAndReportsEach) {
    const test::TemporaryFolder folder;
    const std::string log = (folder / "log").string();
    RenderQueue queue;
    queue.Add(Shell(
        "echo one >> " + log +
        "; echo '{\"event\":\"progress\",\"samples\":4,\"samples_wanted\":8}' >&2; sleep 0.05; echo end >> " +
        log + "; echo 8 samples"));
    queue.Add(Shell("echo two >> " + log + "; echo 'raygraph: no such camera' >&2; exit 4"));
    queue.Add(Shell("exec true"));
    EXPECT_TRUE(queue.IsBusy());
    queue.Update();
    EXPECT_EQ(queue.Jobs()[0].state, State::Running);
    EXPECT_EQ(queue.Jobs()[1].state, State::Waiting);
    Until(queue, [&] { return !queue.IsBusy(); });
    EXPECT_EQ(queue.Jobs()[0].state, State::Done);
    EXPECT_EQ(queue.Jobs()[0].progress.text, "4 of 8 samples");
    EXPECT_EQ(queue.Jobs()[0].result, "rendered a.png: 8 samples");
    EXPECT_EQ(queue.Jobs()[1].state, State::Failed);
    EXPECT_EQ(queue.Jobs()[1].result, "a.png: not rendered: raygraph: no such camera");
    EXPECT_EQ(queue.Jobs()[2].state, State::Done) << "a failure does not end the queue";
    EXPECT_EQ(test::TextOf(log), "one\nend\ntwo\n");
    queue.RemoveOver();
    EXPECT_TRUE(queue.Jobs().empty());
}

TEST(RenderQueue, SaysWhyAProgramThatDoesNotStartOrEndsWithoutALineHasFailed) {
    const test::TemporaryFolder folder;
    RenderQueue queue;
    queue.Add({.command = {(folder / "raygraph (deleted)").string()}, .name = "a.png"});
    queue.Add(Shell("printf 'out of memory' >&2; exit 1"));
    queue.Add(Shell("exit 1"));
    Until(queue, [&] { return !queue.IsBusy(); });
    EXPECT_TRUE(queue.Jobs()[0].result.ends_with("raygraph (deleted) could not be started"))
        << queue.Jobs()[0].result;
    EXPECT_EQ(queue.Jobs()[1].result, "a.png: not rendered: out of memory");
    EXPECT_EQ(queue.Jobs()[2].result, "a.png: not rendered: the program ended");
}

TEST(RenderQueue, RendersNoSceneThatHasChangedSinceItWasQueued) {
    const test::TemporaryFolder folder;
    const std::filesystem::path scene = folder / "scene.gltf";
    test::Put(scene, "{}");
    RenderQueue queue;
    for (int i = 0; i < 2; ++i) {
        RenderTask task = Shell("exec true");
        task.scene = scene;
        task.stamp = StampOf(scene);
        task.outputs = {folder / "a.png"};
        queue.Add(std::move(task));
    }
    EXPECT_TRUE(queue.IsWriting(folder / "." / "a.png"));
    EXPECT_FALSE(queue.IsWriting(folder / "b.png"));
    queue.Update();
    test::Put(scene, "{\"asset\": {}}");
    Until(queue, [&] { return !queue.IsBusy(); });
    EXPECT_EQ(queue.Jobs()[0].state, State::Done);
    EXPECT_EQ(queue.Jobs()[1].state, State::Failed);
    EXPECT_TRUE(queue.Jobs()[1].result.ends_with("scene.gltf has changed since it was queued"))
        << queue.Jobs()[1].result;
    EXPECT_FALSE(queue.IsWriting(folder / "a.png")) << "all are over";
}

TEST(PrivateCopy, SweepingRemovesOldOnesAlone) {
    const test::TemporaryFolder folder;
    for (const char* name : {"old", "new"}) {
        std::filesystem::create_directory(folder / name);
        test::Put(folder / name / "scene.gltf", "{}");
    }
    std::filesystem::last_write_time(
        folder / "old", std::filesystem::file_time_type::clock::now() - std::chrono::hours(8 * 24));
    SweepCopies(folder.Path());
    EXPECT_FALSE(std::filesystem::exists(folder / "old"));
    EXPECT_TRUE(std::filesystem::exists(folder / "new" / "scene.gltf"));
    SweepCopies(folder / "none");
}

TEST(RenderQueue, CancelsAndStopsWithTheSamplesSoFar) {
    const test::TemporaryFolder folder;
    const std::string made = (folder / "made").string();
    std::filesystem::create_directory(folder / "copy");
    test::Put(folder / "copy" / "scene.gltf", "{}");
    RenderQueue queue;
    RenderTask slow = Shell("sleep 60; touch " + made);
    slow.copy = std::make_shared<PrivateCopy>(folder / "copy" / "scene.gltf");
    queue.Add(std::move(slow));
    queue.Add(Shell("touch " + made));
    const char* const kUntilTerm =
        "echo '{\"event\":\"step\",\"step\":\"ready\"}'; while :; do sleep 0.01; done";
    queue.Add(
        Shell(std::string("trap 'echo \"{\\\"event\\\":\\\"written\\\"}\"; exit 75' TERM; ") + kUntilTerm));
    queue.Add(Shell(kUntilTerm));
    queue.Update();
    EXPECT_EQ(queue.Jobs()[0].state, State::Running);
    queue.Cancel(1);
    queue.Cancel(0);
    EXPECT_EQ(queue.Jobs()[0].state, State::Cancelled);
    EXPECT_FALSE(std::filesystem::exists(folder / "copy")) << "nobody needs it now";
    for (const size_t job : {2, 3}) {
        Until(queue, [&] { return queue.Jobs()[job].progress.text == "ready"; });
        queue.Stop(job);
        Until(queue, [&] { return queue.Jobs()[job].IsOver(); });
    }
    EXPECT_EQ(queue.Jobs()[2].state, State::Stopped) << queue.Jobs()[2].result;
    EXPECT_EQ(queue.Jobs()[3].state, State::Cancelled) << "it had no samples to save";
    EXPECT_EQ(queue.Jobs()[1].state, State::Cancelled);
    EXPECT_FALSE(std::filesystem::exists(made));
}

namespace {

#ifdef RAYGRAPH_BUILT_PROGRAM
constexpr const char* kProgram = RAYGRAPH_BUILT_PROGRAM;
#else
constexpr const char* kProgram = "raygraph";
#endif

class RenderTaskTest : public EditorTest {
  protected:
    RenderTaskTest() : EditorTest({.render = {kProgram, "render"}}) {}
    RenderTask Task(const RenderRequest& request) {
        return TaskOf(editor.Work(), request, {"raygraph", "render"});
    }
    static bool Has(const RenderTask& task, const std::string& option, const std::string& value) {
        const auto found = std::ranges::find(task.command, option);
        return found != task.command.end() && found + 1 != task.command.end() && found[1] == value;
    }

    const test::OwnCache cache{(folder / "cache").string()};
};

}  // namespace

TEST_F(RenderTaskTest, HasTheOptionsOfTheRequest) {
    Play(OpenCornell());
    RenderRequest request{
        .size = {64, 48}, .crop = passes::Region{1, 2, 3, 4}, .outputs = {folder / "a.png"}};
    EXPECT_EQ(WhyNotRendered(editor.Work(), request), "");
    RenderTask task = Task(request);
    EXPECT_FALSE(task.copy);
    EXPECT_EQ(task.command.at(2), test::SourceFile("scenes/cornell.gltf").string());
    EXPECT_TRUE(Has(task, "--size", "64x48"));
    EXPECT_TRUE(Has(task, "--crop", "1,2,3,4"));
    EXPECT_TRUE(Has(task, "--output", (folder / "a.png").string()));
    EXPECT_EQ(std::ranges::count(task.command, "--spp"), 0) << "until it looks clean";
    EXPECT_EQ(std::ranges::count(task.command, "--view"), 0) << "a render is path-traced, whatever is shown";

    request.stop = RenderStop::Time;
    request.minutes = 0.5f;
    Workspace& work = editor.Work();
    work.backdrop.reset();
    work.ShowBackdrop();
    request.pictures = RenderedPictures::Cameras;
    EXPECT_NE(WhyNotRendered(editor.Work(), request).find("{camera}"), std::string::npos);
    request.outputs = {folder / "a-{camera}.exr"};
    EXPECT_EQ(WhyNotRendered(editor.Work(), request), "");
    task = Task(request);
    EXPECT_TRUE(Has(task, "--time", "30"));
    EXPECT_TRUE(Has(task, "--transparent", "on"));
    EXPECT_TRUE(Has(task, "--camera", "camera")) << "by its name";
    EXPECT_EQ(std::ranges::count(task.command, "--camera"), 1);

    request.outputs.push_back(folder / "a-{camera}.jpg");
    EXPECT_EQ(WhyNotRendered(work, request), "a .jpg cannot be transparent");
    work.backdrop = passes::BackdropSettings{.color = glm::vec3(1.0f)};
    work.hasGround = true;
    work.ShowBackdrop();
    EXPECT_EQ(WhyNotRendered(work, request), "");
    task = Task(request);
    EXPECT_TRUE(Has(task, "--backdrop", "1,1,1"));
    EXPECT_TRUE(Has(task, "--ground", "on"));
    EXPECT_FALSE(Has(task, "--transparent", "on"));
    request.outputs.pop_back();
    EXPECT_TRUE(Has(Task(request), "--transparent", "on")) << "an .exr has nothing behind the scene";
    EXPECT_EQ(std::ranges::count(Task(request).command, "--backdrop"), 0);
    work.backdrop = passes::BackdropSettings{.blurDegrees = 10.0f};
    work.ShowBackdrop();
    request.outputs.back() = folder / "a-{camera}.png";
    EXPECT_FALSE(Has(Task(request), "--backdrop", "blur:10")) << "there is no map to blur";
    EXPECT_FALSE(Has(Task(request), "--transparent", "on")) << "the ground is before the environment";

    request.pictures = RenderedPictures::Frames;
    request.outputs = {folder / "a-##.exr"};
    EXPECT_EQ(WhyNotRendered(editor.Work(), request), "the scene has no animation");
    request.pictures = RenderedPictures::View;
    for (const auto& [file, why] :
         {std::pair{"none/a.png", "there is no folder"}, {"a.tiff", "must end in"}}) {
        request.outputs = {folder / file};
        EXPECT_NE(WhyNotRendered(editor.Work(), request).find(why), std::string::npos) << file;
    }
    request.outputs = {folder / "a.png"};
    request.crop = passes::Region{60, 0, 5, 1};
    EXPECT_NE(WhyNotRendered(editor.Work(), request).find("crop"), std::string::npos);
}

// The files are in another folder below the root, and one has a name that a copy may not have.
TEST_F(RenderTaskTest, ACopyHasTheFilesThatTheSceneHasElsewhere) {
    test::GltfDocument document;
    test::Json& triangle = document.AddTriangle();
    document.json["images"] = {{{"uri", "../textures/a.png"}}, {{"uri", ".b.png"}}};
    document.json["textures"] = {{{"source", 0}}, {{"source", 1}}};
    triangle["material"] =
        document.AddMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}},
                              {"emissiveTexture", {{"index", 1}}}});
    const std::string text = document.Text();
    for (const char* name : {"project/scenes", "project/textures"})
        std::filesystem::create_directories(folder / name);
    const std::filesystem::path scene = folder / "project/scenes/scene.gltf";
    test::Put(scene, text);
    for (const char* name : {"project/textures/a.png", "project/scenes/.b.png"}) {
        const test::Bytes png = test::MakePng(3, 2, {1, 2, 3, 255});
        test::Put(folder / name, {reinterpret_cast<const char*>(png.data()), png.size()});
    }
    editor.Work().root = folder / "project";
    Play("size 320x200\nview raster\nopen " + scene.string() + "\nwait\n");
    scene::Material material = editor.Work().document.Scene().materials[0];
    material.baseColorFactor.y = 0.0f;
    editor.Work().Apply(MaterialEdit{0, material});
    const RenderTask task = Task({.size = {8, 8}, .outputs = {folder / "a.png"}});
    ASSERT_TRUE(task.copy);
    EXPECT_EQ(std::ranges::count(task.command, "--root"), 0);
    const scene::SceneData copied = scene::LoadGltf(task.copy->File());
    EXPECT_EQ(copied.images.size(), 2u);
    EXPECT_EQ(copied.images[0].width, 3u);
    EXPECT_EQ(copied.materials[0].baseColorFactor.y, 0.0f);
    EXPECT_EQ(test::TextOf(scene), text);
    Play("size 320x200\nkey ctrl+z\n");
    EXPECT_TRUE(
        Has(Task({.size = {8, 8}, .outputs = {folder / "a.png"}}), "--root", (folder / "project").string()));
}

TEST_F(RenderTaskTest, TheDialogFollowsTheSceneAndChoosesOneFormatOfAFile) {
    Play(OpenCornell() + "key ctrl+shift+e\nframes 1\n");
    RenderDialog& dialog = editor.OpenRenderDialog();
    using Paths = std::vector<std::filesystem::path>;
    EXPECT_EQ(dialog.Request().outputs, Paths{"cornell.png"});
    dialog.SetFile(folder / "a.exr");
    EXPECT_EQ(dialog.Request().outputs, Paths{folder / "a.exr"});
    Play("size 640x400\nopen " + test::SourceFile("scenes/furnace_sphere.gltf").string() +
         "\nwait\nframes 2\n");
    EXPECT_EQ(dialog.Request().outputs, Paths{"furnace_sphere.exr"});
}

namespace {

class SlowRenderTest : public EditorTest {
  protected:
    SlowRenderTest() : EditorTest({.render = {"sh", "-c", "exec sleep 60"}}) {}
};

}  // namespace

TEST_F(SlowRenderTest, ClosingWarnsOfEachRenderThatItCancels) {
    Play(OpenCornell() + "render 8x8 1 a.png\nkey enter\nexpect message queued\n");
    Play("size 640x400\nrender 8x8 1 ./a.png\nkey enter\nexpect message a render of the list writes it\n");
    Play("size 640x400\nclose\nexpect message not done yet\nexpect leaving no\n");
    Play("size 640x400\nrender 8x8 1 b.png\nkey enter\nexpect message queued\n");
    Play("size 640x400\nclose\nexpect message not done yet\nexpect leaving no\n");
    Play("size 640x400\nclose\nexpect leaving yes\n");
}

#ifdef RAYGRAPH_BUILT_PROGRAM

TEST_F(RenderTaskTest, TheDialogRendersUnsavedEditsAsTheProgramRendersTheSavedScene) {
    Play("key ctrl+shift+e\nexpect message there is no scene\n");
    Workspace& work = editor.Work();
    Play(OpenCornell() + "mouse 320 120\nclick left\nwait\nmaterial base 1 0 0\nexpect edits 1\n");
    const std::string made = (folder / "made.png").string();
    work.panels.hierarchy = work.panels.inspector = false;
    Play("size 64x99\nview path-traced\nframes 1\n");  // the picture has 64 x 48 pixels
    Play("size 640x400\nkey ctrl+shift+e\nrender 64x48 2 " + made +
         "\nkey enter\nexpect message queued\nwait\n" + "expect message rendered " + made + ": 2 samples\n");
    EXPECT_TRUE(work.document.IsEdited()) << "the edits are still not saved";
    EXPECT_EQ(test::FileCount(folder / "cache" / "raygraph" / "renders"), 0u) << "the copy is gone";

    Play("key escape\nkey escape\nscene " + (folder / "saved.gltf").string() +
         "\nsize 64x99\nframes 1\nkey ctrl+shift+r\n");
    const std::string line = "cd " + folder.Path().string() +
                             " && PATH=" + std::filesystem::path(kProgram).parent_path().string() +
                             ":$PATH && " + ImGui::GetClipboardText() +
                             " --spp 2 --output shell.png > output 2>&1";
    ASSERT_EQ(std::system(line.c_str()), 0) << line << test::TextOf(folder / "output");
    EXPECT_TRUE(test::TextOf(made) == test::TextOf(folder / "shell.png"));
    EXPECT_FALSE(test::TextOf(made).empty());
}

#endif

}  // namespace raygraph::editor
