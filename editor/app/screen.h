// Where the editor's frames go: a window's swapchain, or a picture without one.
#pragma once

#include <optional>

#include "renderer/graph/renderer.h"
#include "rhi/swapchain.h"

namespace raygraph::editor {

class Screen {
  public:
    Screen() = default;
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;
    virtual ~Screen() = default;

    // Of the open frame: the color target to draw over, of `extent`. Nothing: this frame cannot be shown.
    virtual std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) = 0;
    // `drawn` is the target's last version; executes the frame and shows it.
    virtual void End(Renderer& renderer, TextureId drawn) = 0;
};

class WindowScreen final : public Screen {
  public:
    explicit WindowScreen(rhi::Swapchain& swapchain) : m_swapchain(swapchain) {}
    std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override;
    void End(Renderer& renderer, TextureId drawn) override;

  private:
    rhi::Swapchain& m_swapchain;
    rhi::SwapchainImage m_image;
    ResourceState m_state;
    bool m_isStale = false;
};

// For scripts on machines without a display.
class PictureScreen final : public Screen {
  public:
    std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override;
    void End(Renderer& renderer, TextureId drawn) override;
};

}  // namespace raygraph::editor
