// The target of the editor's frames: a window's swapchain, or a picture without a window.
#pragma once

#include <optional>

#include "renderer/graph/renderer.h"
#include "renderer/graph/swapchain_frame.h"

namespace raygraph::editor {

class Screen {
  public:
    Screen() = default;
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;
    virtual ~Screen() = default;

    // Of the open frame: the color target to draw over, of `extent`. Nullopt: this frame cannot be shown.
    virtual std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) = 0;
    // `drawn` is the target's last version; executes the frame and shows it.
    virtual void End(Renderer& renderer, TextureId drawn) = 0;
};

class WindowScreen final : public Screen {
  public:
    explicit WindowScreen(rhi::Swapchain& swapchain) : m_frame(swapchain) {}
    std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override {
        return m_frame.Begin(renderer, extent);
    }
    void End(Renderer& renderer, TextureId drawn) override { m_frame.End(renderer, drawn); }

  private:
    SwapchainFrame m_frame;
};

// For scripts on machines without a display.
class PictureScreen final : public Screen {
  public:
    std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override;
    void End(Renderer& renderer, TextureId drawn) override;
};

}  // namespace raygraph::editor
