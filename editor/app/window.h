// A window of the desktop: its events as FrameInput, its surface for a swapchain. Main thread only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "editor/app/input.h"
#include "rhi/swapchain.h"

namespace raygraph::editor {

class Window {
  public:
    // Error{NoDevice} without a display.
    Window(const std::string& title, rhi::Extent2D size);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    // For DeviceDesc::surfaceExtensions.
    std::vector<std::string> SurfaceExtensions() const;
    // For SwapchainDesc::makeSurface; while the window lives.
    rhi::MakeSurface SurfaceMaker();
    rhi::Extent2D Extent() const;  // pixels

    // Returns the events since the last call, a request to close included; waits at most `seconds` for
    // an event.
    FrameInput Poll(double seconds = 0.0);
    void SetTitle(const std::string& title);
    void Hide();
    // What ImGui copies and pastes is the desktop's from then on, while the window lives. Needs ImGui's
    // context.
    void ShareClipboard();

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace raygraph::editor
