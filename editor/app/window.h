// Opens a window of the desktop: its events become FrameInput, its surface is for a swapchain. Main thread
// only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "editor/app/input.h"
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

}  // namespace raygraph::editor
