// Tests a window on a display of its own.
#include "editor/app/window.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "base/error.h"
#include "editor/app/editor.h"
#include "rhi/swapchain.h"
#include "tests/rhi/gate.h"
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
