// Tests a window on a display of its own.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "base/files.h"
#include "editor/app/edit.h"
#include "editor/app/editor.h"
#include "editor/app/script.h"
#include "editor/app/window.h"
#include "editor/app/worker.h"
#include "editor/session/file/content_hash.h"
#include "editor/session/file/render_file.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "rhi/swapchain.h"
#include "tests/editor/editor_test.h"
#include "tests/rhi/fake_loader.h"
#include "tests/rhi/gate.h"
#include "tests/support/error_of.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::editor::window_test {

namespace {

constexpr const char* kServer = "/usr/bin/Xvfb";

// Runs an X server with a virtual screen while it lives.
class Display {
  public:
    Display() {
        int ends[2];
        if (pipe(ends) != 0) return;
        m_process = fork();
        if (m_process == 0) {
            const std::string reply = std::to_string(ends[1]);
            const int nowhere = open("/dev/null", O_WRONLY);
            dup2(nowhere, 1);
            dup2(nowhere, 2);
            close(ends[0]);
            execl(kServer, kServer, "-displayfd", reply.c_str(), "-screen", "0", "800x600x24", nullptr);
            _exit(1);
        }
        close(ends[1]);
        char letter = 0;
        while (read(ends[0], &letter, 1) == 1 && letter != '\n') m_name += letter;
        close(ends[0]);
    }
    ~Display() {
        if (m_process <= 0) return;
        kill(m_process, SIGTERM);
        waitpid(m_process, nullptr, 0);
    }
    Display(const Display&) = delete;
    Display& operator=(const Display&) = delete;
    const std::string& Name() const { return m_name; }  // e.g. "97"; "": the server did not start

  private:
    pid_t m_process = -1;
    std::string m_name;
};

// Makes each frame wait for a semaphore.
class GatedScreen final : public Screen {
  public:
    GatedScreen(Screen& screen, const rhi::SemaphoreUse& gate) : m_screen(screen), m_gate(gate) {}
    std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override {
        renderer.WaitSemaphore(m_gate);
        return m_screen.Begin(renderer, extent);
    }
    void End(Renderer& renderer, TextureId drawn) override { m_screen.End(renderer, drawn); }
    bool IsReady(const Renderer& renderer) override { return m_screen.IsReady(renderer); }

  private:
    Screen& m_screen;
    rhi::SemaphoreUse m_gate;
};

}  // namespace

TEST(WindowTest, OpensAndShowsFrames) {
    if (!std::filesystem::exists(kServer)) GTEST_SKIP() << "there is no Xvfb";
    const Display display;
    if (display.Name().empty()) GTEST_SKIP() << "Xvfb does not start";
    setenv("DISPLAY", (":" + display.Name()).c_str(), 1);
    testing::MessageLog messages;
    {
        Window window("test", {320, 200});
        const auto device = rhi::Device::Create({.validation = true,
                                                 .log = messages.Listener(),
                                                 .surfaceExtensions = window.SurfaceExtensions()});
        rhi::Swapchain swapchain(
            *device, {.name = "window", .makeSurface = window.SurfaceMaker(), .extent = window.Extent()});
        EXPECT_EQ(window.Extent(), (rhi::Extent2D{320, 200}));
        WindowScreen screen(swapchain);
        Editor editor(*device);
        for (int i = 0; i < 4; ++i) {
            EXPECT_TRUE(editor.Frame(window.Poll(), screen));
            EXPECT_EQ(editor.FrameError(), "");
        }
        device->WaitIdle();
    }
    EXPECT_EQ(messages.Text(0, true), "");
}

// A scene's acceleration structures may take long to build. A driver that waited for the frame before showing
// it would wait forever.
TEST(WindowTest, AFrameThatTakesLongIsNotWaitedFor) {
    if (!std::filesystem::exists(kServer)) GTEST_SKIP() << "there is no Xvfb";
    const Display display;
    if (display.Name().empty()) GTEST_SKIP() << "Xvfb does not start";
    setenv("DISPLAY", (":" + display.Name()).c_str(), 1);
    testing::MessageLog messages;
    {
        Window window("test", {320, 200});
        const auto device = rhi::Device::Create({.validation = true,
                                                 .log = messages.Listener(),
                                                 .surfaceExtensions = window.SurfaceExtensions()});
        if (device->Info().type != rhi::DeviceType::Cpu) GTEST_SKIP() << "its driver shows frames by itself";
        rhi::Swapchain swapchain(
            *device, {.name = "window", .makeSurface = window.SurfaceMaker(), .extent = window.Extent()});
        WindowScreen screen(swapchain);
        Editor editor(*device);
        const Renderer& renderer = editor.Work().renderer;
        testing::Gate gate(*device);
        GatedScreen gated(screen, gate.At(1));
        EXPECT_TRUE(gated.IsReady(renderer)) << "there is no frame";
        EXPECT_TRUE(editor.Frame(window.Poll(), gated));
        EXPECT_FALSE(gated.IsReady(renderer));
        gate.Open();
        device->WaitIdle();
        EXPECT_TRUE(gated.IsReady(renderer));
        for (int i = 0; i < 3; ++i) {
            EXPECT_TRUE(editor.Frame(window.Poll(), screen));
            EXPECT_EQ(editor.FrameError(), "");
        }
        device->WaitIdle();
    }
    EXPECT_EQ(messages.Text(0, true), "");
}

}  // namespace raygraph::editor::window_test

// Tests that events are processed while the device is busy.
namespace raygraph::editor::busy_test {

TEST(FrameInput, WhatComesLaterIsAddedAndWhatWasHeldHasHappened) {
    FrameInput input;
    input.extent = {10, 20};
    input.seconds = 0.5f;
    input.wheel = 1.0f;
    input.buttons[0] = true;
    input.keys[static_cast<size_t>(Key::A)] = true;
    input.pressed = {Key::A};
    input.isControl = true;
    input.text = U"a";
    input.dropped = {"a.gltf"};
    input.isClosing = true;
    FrameInput later;
    later.extent = {30, 40};
    later.scale = 2.0f;
    later.seconds = 0.25f;
    later.mouse = {3, 4};
    later.wheel = 2.0f;
    later.buttons[1] = true;
    later.keys[static_cast<size_t>(Key::B)] = true;
    later.pressed = {Key::B};
    later.isShift = later.isAlt = true;
    later.text = U"b";
    later.dropped = {"b.gltf"};
    input.Append(std::move(later));
    EXPECT_EQ(input.extent, (rhi::Extent2D{30, 40}));
    EXPECT_EQ(input.scale, 2.0f);
    EXPECT_EQ(input.seconds, 0.75f);
    EXPECT_EQ(input.mouse, glm::vec2(3, 4));
    EXPECT_EQ(input.wheel, 3.0f);
    EXPECT_EQ(input.buttons, (std::array{true, true, false}));
    EXPECT_TRUE(input.IsDown(Key::A) && input.IsDown(Key::B));
    EXPECT_EQ(input.pressed, (std::vector{Key::A, Key::B}));
    EXPECT_TRUE(input.isControl && input.isShift && input.isAlt);
    EXPECT_EQ(input.text, U"ab");
    EXPECT_EQ(input.dropped, (std::vector<std::filesystem::path>{"a.gltf", "b.gltf"}));
    EXPECT_TRUE(input.isClosing);
}

class BusyTest : public EditorTest {
  protected:
    void ShowPreviews() {
        viewport::BudgetSettings budget = editor.Work().view.Budget();
        budget.whilePreparing = viewport::PreparingView::Preview;
        editor.Work().view.SetBudget(budget);
    }
};

// F1 opens the help, and the window's button ends the editor: both arrive while no frame can begin.
TEST_F(BusyTest, EventsAreTakenUntilAFrameCanBegin) {
    class BusyScreen final : public Screen {
      public:
        std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override {
            ++frames;
            EXPECT_TRUE(isReady);
            isReady = false;
            return m_picture.Begin(renderer, extent);
        }
        void End(Renderer& renderer, TextureId drawn) override { m_picture.End(renderer, drawn); }
        bool IsReady(const Renderer&) override { return isReady = ++m_asked % 6 == 0; }

        int frames = 0;
        bool isReady = true;

      private:
        PictureScreen m_picture;
        int m_asked = 0;
    } busy;
    int polls = 0;
    const auto poll = [&](double) {
        FrameInput input;
        input.extent = {320, 200};
        ++polls;
        if (polls == 4) input.pressed = {Key::F1};
        input.isClosing = polls == 16;
        return input;
    };
    EXPECT_FALSE(editor.Work().panels.help);
    RunFrames(editor, busy, {.poll = poll, .setTitle = [](const std::string&) {}});
    EXPECT_TRUE(editor.Work().panels.help);
    EXPECT_EQ(busy.frames, 4);  // one frame for the first poll, and six polls before each other one
    EXPECT_EQ(polls, 19);
}

// The panels are drawn meanwhile, and the picture that is saved is the first frame that has one.
TEST_F(BusyTest, PanelsAreDrawnWhilePipelinesAreMade) {
    class WindowLike final : public Screen {
      public:
        std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override {
            return m_picture.Begin(renderer, extent);
        }
        void End(Renderer& renderer, TextureId drawn) override {
            ++withoutPicture;
            m_picture.End(renderer, drawn);
        }
        bool TryEnd(Renderer& renderer, TextureId drawn) override {
            renderer.Present(drawn);
            if (!renderer.PreparePipelines()) return false;
            ++whole;
            renderer.Execute();
            return true;
        }

        int withoutPicture = 0, whole = 0;

      private:
        PictureScreen m_picture;
    } window;
    FrameInput input;
    input.extent = {320, 200};
    editor.SaveWindow(folder / "window.png");
    for (int frame = 0; frame < 100'000 && editor.SavedCount() == 0; ++frame) {
        EXPECT_EQ(editor.FrameError(), "");
        ASSERT_TRUE(editor.Frame(input, window));
        EXPECT_EQ(window.whole + window.withoutPicture, frame + 1);
        if (window.whole == 0) {
            EXPECT_TRUE(editor.IsBusy()) << "saved without a picture";
        }
    }
    EXPECT_GT(window.withoutPicture, 0);
    EXPECT_TRUE(std::filesystem::exists(folder / "window.png"));
}

// While the path tracer's pipeline is made, a preview is shown, which the user does not want to save.
TEST_F(BusyTest, PicturesAreSavedOfSamplesAndNotOfAPreview) {
    ShowPreviews();
    FrameInput input;
    input.extent = {320, 200};
    editor.SavePicture(folder / "picture.png");
    ASSERT_TRUE(editor.Frame(input, screen));
    EXPECT_TRUE(editor.IsPreparing());
    for (int frame = 0; frame < 100'000 && editor.SavedCount() == 0; ++frame) {
        EXPECT_EQ(editor.FrameError(), "");
        ASSERT_TRUE(editor.Frame(input, screen));
        if (editor.IsPreparing()) {
            EXPECT_EQ(editor.SavedCount(), 0u);
        }
    }
    EXPECT_FALSE(editor.IsPreparing());
    EXPECT_TRUE(std::filesystem::exists(folder / "picture.png"));
}

// Frames copy the scene to the device, so they must not be throttled like those of a preview, which leave a
// CPU device to the compiler.
TEST_F(BusyTest, FramesThatCopyAScene_AreNotHeldBackByAPreview) {
    ShowPreviews();
    FrameInput input;
    input.extent = {320, 200};
    // The path tracer's pipeline is being made for the empty scene
    for (int frame = 0; frame < 1000 && !editor.Work().view.Progress().isPreview; ++frame)
        ASSERT_TRUE(editor.Frame(input, screen));
    ASSERT_TRUE(editor.IsPreparing());
    editor.Open(test::SourceFile("scenes/texture_formats_grid.gltf"));
    int copying = 0;
    while (editor.Work().IsLoading()) {
        ASSERT_TRUE(editor.Frame(input, screen));
        if (!editor.Work().IsLoading() || editor.Work().loader.IsLoading()) continue;
        ++copying;
        EXPECT_FALSE(editor.IsPreparing());
    }
    EXPECT_GT(copying, 0);
}

}  // namespace raygraph::editor::busy_test

// Tests work on another thread: its order, that nothing waits for it, and its completion on the main thread.
namespace raygraph::editor::worker_test {

namespace {

void NoFailure(const std::string& why) {
    ADD_FAILURE() << why;
}

void FinishAll(Worker& worker) {
    while (worker.IsBusy()) {
        worker.FinishTasks();
        std::this_thread::yield();
    }
}

}  // namespace

TEST(Worker, TasksRunInOrderBesideTheMainThread) {
    Worker worker;
    EXPECT_FALSE(worker.IsBusy());
    std::promise<void> go;
    std::vector<int> ran, finished;
    const std::thread::id main = std::this_thread::get_id();
    for (int i = 0; i < 3; ++i)
        worker.Add(
            [&, i]() -> Worker::Finish {
                if (i == 0) go.get_future().wait();
                EXPECT_NE(std::this_thread::get_id(), main);
                ran.push_back(i);
                return [&, i] {
                    EXPECT_EQ(std::this_thread::get_id(), main);
                    finished.push_back(i);
                };
            },
            NoFailure);
    worker.FinishTasks();  // returns although the first task waits for the code below
    EXPECT_TRUE(worker.IsBusy());
    EXPECT_TRUE(finished.empty());
    go.set_value();
    FinishAll(worker);
    EXPECT_EQ(ran, (std::vector{0, 1, 2}));
    EXPECT_EQ(finished, (std::vector{0, 1, 2}));
}

TEST(Worker, WhatATaskThrowsIsHeardOnTheMainThreadAndTheNextOneRuns) {
    Worker worker;
    std::vector<std::string> heard;
    worker.Add([]() -> Worker::Finish { throw std::runtime_error("no room"); },
               [&](const std::string& why) { heard.push_back(why); });
    worker.Add([&]() -> Worker::Finish { return [&] { heard.push_back("done"); }; }, NoFailure);
    FinishAll(worker);
    EXPECT_EQ(heard, (std::vector<std::string>{"no room", "done"}));
}

TEST(Worker, GoesWhenAllTasksAreDone) {
    int done = 0;
    {
        Worker worker;
        for (int i = 0; i < 5; ++i)
            worker.Add(
                [&]() -> Worker::Finish {
                    std::this_thread::sleep_for(std::chrono::milliseconds(2));
                    ++done;
                    return [] { ADD_FAILURE() << "there is nobody to hear of it"; };
                },
                NoFailure);
    }
    EXPECT_EQ(done, 5);
}

// Uses a device of its own, whose log tells the threads.
class SavingTest : public testing::VulkanTest {
  protected:
    SavingTest() {
        const raygraph::Log log([this](const LogMessage& message) {
            const std::scoped_lock lock(m_mutex);
            if (message.text.find("edited.gltf") != std::string_view::npos &&
                message.text.find(" read in ") != std::string_view::npos)
                m_readers.push_back(std::this_thread::get_id());
        });
        m_device = rhi::Device::Create({.log = log});
        m_editor = std::make_unique<Editor>(*m_device);
    }
    void Play(const std::string& text) {
        const std::filesystem::path file = m_folder / "script.txt";
        std::ofstream(file) << text;
        Script(file).Play(*m_editor, m_screen);
    }
    std::vector<std::thread::id> Readers() {
        const std::scoped_lock lock(m_mutex);
        return m_readers;
    }

    test::TemporaryFolder m_folder;
    std::mutex m_mutex;
    std::vector<std::thread::id> m_readers;
    std::unique_ptr<rhi::Device> m_device;
    PictureScreen m_screen;
    std::unique_ptr<Editor> m_editor;
};

TEST_F(SavingTest, SceneWhoseEditsWereSavedIsReadOnceAndNotByTheWindowsThread) {
    const std::filesystem::path scene = m_folder / "edited.gltf", picture = m_folder / "picture.exr";
    Play("size 320x200\nview raster\nopen " + test::SourceFile("scenes/cornell.gltf").string() +
         "\nwait\nmouse 160 80\nclick left\nwait\nmaterial base 1 0 0\nscene " + scene.string() +
         "\nsamples 1\n");
    EXPECT_TRUE(Readers().empty());
    const std::string save = "size 320x200\npicture " + picture.string() + "\nexpect message sample\n";
    Play(save);
    ASSERT_EQ(Readers().size(), 1u);
    EXPECT_NE(Readers()[0], std::this_thread::get_id());
    EXPECT_EQ(session::ReadRenderFile(picture).sceneHash, session::HashOf(scene::LoadGltf(scene)));
    Play(save);
    EXPECT_EQ(Readers().size(), 1u) << "what is in the file is known by now";
    EXPECT_FALSE(session::ReadRenderFile(picture).sceneHash.empty());
    // Another program has written the file, so the scene of the picture is unknown
    std::ofstream(scene, std::ios::app) << " ";
    Play(save);
    EXPECT_EQ(session::ReadRenderFile(picture).sceneHash, "");
}

}  // namespace raygraph::editor::worker_test

// Tests unsaved edits, and the actions that might lose them.
namespace raygraph::editor::unsaved_test {

namespace {

constexpr glm::vec4 kBlue{0.25f, 0.5f, 1.0f, 1.0f};

class UnsavedTest : public EditorTest {
  protected:
    void Edit() {
        Workspace& work = editor.Work();
        scene::Material material = work.document.Scene().materials[0];
        material.baseColorFactor = kBlue;
        work.Apply(MaterialEdit{0, material});
        work.document.Settle();
    }
};

}  // namespace

TEST_F(UnsavedTest, AsksBeforeEditsAreLost) {
    const std::string file = (folder.Path() / "saved.gltf").string();
    const std::string other = test::SourceFile("scenes/furnace_sphere.gltf").string();
    Play(OpenCornell() + "mouse 320 120\nclick left\nwait\nscene " + file + "\n");
    const uint32_t material = *editor.Work().selectedMaterial;
    const std::string edit = "material base 0.25 0.5 1\n";
    // Escape keeps everything, whatever was about to lose the edits
    Play(edit);
    for (const std::string& loss :
         {std::string("close\n"), std::string("key ctrl+q\n"), "open " + other + "\nwait\n"})
        Play("size 640x400\n" + loss +
             "expect asking yes\nexpect leaving no\nkey escape\nexpect asking no\n");
    Play("wait\nexpect leaving no\nexpect edits 1\nopen " + (folder.Path() / "sky.hdr").string() +
         "\nexpect asking no\nwait\n");
    EXPECT_EQ(editor.Work().document.File(), file);
    EXPECT_NE(scene::LoadGltf(file).materials[material].baseColorFactor.x, 0.25f);
    // If the file cannot be written, everything is kept, too
    std::ofstream(file, std::ios::app) << " ";
    Play(
        "size 640x400\nkey ctrl+q\nkey s\nexpect asking no\nexpect leaving no\nexpect edits 1\n"
        "expect message has changed\n");
    // Discards the edits
    Play("size 640x400\nopen " + other +
         "\nexpect asking yes\nkey d\nwait\nexpect asking no\nexpect edits 0\n");
    EXPECT_EQ(editor.Work().document.File(), other);
    // Saves the edits
    Play(OpenCornell() + "mouse 320 120\nclick left\nwait\nscene " + file + ".gltf\n" + edit +
         "close\nkey s\nexpect leaving yes\n");
    EXPECT_EQ(scene::LoadGltf(file + ".gltf").materials[material].baseColorFactor.x, 0.25f);
    EXPECT_FALSE(editor.Work().document.IsEdited());
}

// No edit existed when the other scene was opened.
TEST_F(UnsavedTest, AsksAboutEditsThatWereMadeWhileAnotherSceneWasLoaded) {
    const std::filesystem::path cornell = test::SourceFile("scenes/cornell.gltf");
    const std::filesystem::path other = test::SourceFile("scenes/furnace_sphere.gltf");
    Play(OpenCornell());
    Workspace& work = editor.Work();
    editor.Open(other);
    Edit();
    Play("size 640x400\nwait\nframes 2\nexpect asking yes\nexpect edits 1\nkey escape\n");
    EXPECT_EQ(work.document.File(), cornell);
    Play("size 640x400\nwait\nframes 2\nexpect asking no\nexpect edits 1\nkey ctrl+z\n");
    // The other question is answered first
    editor.Open(other);
    Edit();
    Play("size 640x400\nwait\nkey escape\nclose\nexpect asking yes\n");
    work.Open(other);
    Play("size 640x400\nwait\nframes 2\nexpect asking yes\nkey escape\nframes 2\nexpect asking yes\n");
    EXPECT_EQ(work.document.File(), cornell);
    Play("size 640x400\nkey d\nframes 2\nexpect asking no\nexpect edits 0\n");
    EXPECT_EQ(work.document.File(), other);
}

TEST_F(UnsavedTest, NothingIsAskedWhereNothingIsLost) {
    Play("size 320x200\nclose\nexpect asking no\nexpect leaving yes\n");
}

// The device fails, as it might in a window.
TEST_F(UnsavedTest, IsSavedBesideTheSceneWhenTheEditorEndsByAnError) {
    class Lost final : public Screen {
      public:
        std::optional<TextureId> Begin(Renderer&, rhi::Extent2D) override {
            throw Error(ErrorKind::DeviceLost, "the device is lost in Trace", -4);
        }
        void End(Renderer&, TextureId) override {}
    } lost;
    const auto end = [&] {
        return testing::ErrorOf([&] {
            FrameInput input;
            input.extent = {320, 200};
            RunFrames(editor, lost, {.poll = [&](double) { return input; }, .setTitle = [](auto&) {}});
        });
    };
    std::filesystem::copy(test::SourceFile("scenes/cornell.gltf"), folder / "a.gltf");
    const auto original = ReadFile(folder / "a.gltf");
    Play("size 320x200\nview raster\nopen " + (folder / "a.gltf").string() + "\nwait\n");
    EXPECT_STREQ(end().what(), "the device is lost in Trace") << "there is nothing to save";
    for (const char* name : {"a-recovered.gltf", "a-recovered-2.gltf"}) {
        Edit();
        const Error error = end();
        const std::filesystem::path saved = folder / name;
        EXPECT_EQ(error.what(), "the device is lost in Trace; unsaved edits are in " + saved.string());
        EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost);
        EXPECT_EQ(error.Result(), -4);
        ASSERT_TRUE(std::filesystem::exists(saved));
        EXPECT_EQ(scene::LoadGltf(saved).materials[0].baseColorFactor, kBlue);
    }
    EXPECT_EQ(ReadFile(folder / "a.gltf"), original);
    std::filesystem::remove(folder / "a.gltf");
    EXPECT_NE(std::string(end().what()).find("; unsaved edits are lost: "), std::string::npos);
}

}  // namespace raygraph::editor::unsaved_test

// Tests the reload of shaders while the editor runs.
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
    play("size 320x200\nview raster\nopen " + test::SourceFile("scenes/cornell.gltf").string() +
         "\nwait\nsamples 1\nkey F5\nexpect message no shader has changed\n");
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
