// The window of the desktop, whose events become FrameInput and whose surface is for a swapchain, and
// Screen, the target of the editor's frames. Main thread only.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "editor/app/input.h"
#include "renderer/graph/renderer.h"
#include "renderer/graph/swapchain_frame.h"
#include "rhi/swapchain.h"

namespace raygraph::editor {

class Window {
  public:
    // Throws Error{NoDevice} without a display.
    Window(const std::string& title, rhi::Extent2D size);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    // Returns the extensions for DeviceDesc::surfaceExtensions.
    std::vector<std::string> SurfaceExtensions() const;
    // Returns the function for SwapchainDesc::makeSurface; it is valid while the window lives.
    rhi::MakeSurface SurfaceMaker();
    rhi::Extent2D Extent() const;  // pixels

    // Returns the events since the last call, a request to close included; waits up to `seconds` for an
    // event.
    FrameInput Poll(double seconds = 0.0);
    void SetTitle(const std::string& title);
    void Hide();
    // Connects ImGui's copy and paste with the desktop's clipboard while the window lives. Needs ImGui's
    // context.
    void ShareClipboard();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

// Screen is the target of the editor's frames: a window's swapchain, or a picture without a window.
class Screen {
  public:
    Screen() = default;
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;
    virtual ~Screen() = default;

    // Returns the color target of the open frame, of size `extent`; nullopt if this frame cannot be shown.
    virtual std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) = 0;
    // Executes the frame and shows it, now or when IsReady is asked. `drawn` is the target's last version.
    virtual void End(Renderer& renderer, TextureId drawn) = 0;
    // Ends the frame like End if that need not wait for pipelines. Returns false if it would wait; the frame
    // is still open then.
    virtual bool TryEnd(Renderer& renderer, TextureId drawn) {
        End(renderer, drawn);
        return true;
    }
    // Returns whether a frame can begin without waiting for the device, which may be busy for long.
    virtual bool IsReady(const Renderer&) { return true; }
};

class WindowScreen final : public Screen {
  public:
    explicit WindowScreen(rhi::Swapchain& swapchain) : m_frame(swapchain) {}
    std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override {
        return m_frame.Begin(renderer, extent);
    }
    void End(Renderer& renderer, TextureId drawn) override { m_frame.End(renderer, drawn); }
    bool TryEnd(Renderer& renderer, TextureId drawn) override { return m_frame.TryEnd(renderer, drawn); }
    bool IsReady(const Renderer& renderer) override { return m_frame.ShowDrawn() && !renderer.WouldBlock(); }

  private:
    SwapchainFrame m_frame;
};

// Renders scripts on machines without a display. It waits for pipelines.
class PictureScreen final : public Screen {
  public:
    std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override;
    void End(Renderer& renderer, TextureId drawn) override;
};

}  // namespace raygraph::editor
