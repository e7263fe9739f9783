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
    // `drawn` is the target's last version; executes the frame and shows it, now or when IsReady is asked.
    virtual void End(Renderer& renderer, TextureId drawn) = 0;
    // The same where the frame need not wait for pipelines. False: it would, and is still open.
    virtual bool TryEnd(Renderer& renderer, TextureId drawn) {
        End(renderer, drawn);
        return true;
    }
    // Whether a frame can begin that does not wait for the device, which may be busy for long.
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
    bool IsReady(const Renderer& renderer) override { return m_frame.ShowDrawn() && !renderer.WouldWait(); }

  private:
    SwapchainFrame m_frame;
};

// For scripts on machines without a display: waits for pipelines.
class PictureScreen final : public Screen {
  public:
    std::optional<TextureId> Begin(Renderer& renderer, rhi::Extent2D extent) override;
    void End(Renderer& renderer, TextureId drawn) override;
};

}  // namespace raygraph::editor
