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
