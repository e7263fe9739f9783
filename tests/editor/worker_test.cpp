// Tests work on another thread: its order, that nothing waits for it, and its completion on the main thread.
#include "editor/app/scene_loader.h"

#include <gtest/gtest.h>

#include <fstream>
#include <future>
#include <mutex>
#include <stdexcept>

#include "editor/app/editor.h"
#include "editor/app/script.h"
#include "editor/app/window.h"
#include "editor/session/file/content_hash.h"
#include "editor/session/file/render_file.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

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
    Play("size 320x200\nopen " + test::SourceFile("scenes/cornell.gltf").string() +
         "\nwait\nview raster\nmouse 160 80\nclick left\nwait\nmaterial base 1 0 0\nscene " + scene.string() +
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
