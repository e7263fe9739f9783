// A window's swapchain as the target of the graph's frames.
#pragma once

#include <optional>

#include "renderer/graph/renderer.h"
#include "rhi/swapchain.h"

namespace raygraph {

//   renderer.BeginFrame();
//   if (std::optional<TextureId> window = frame.Begin(renderer, extent))
//       frame.End(renderer, DrawOver(renderer, *window));
//   else
//       renderer.DropFrame();
//   ...until frame.ShowDrawn(), and not renderer.WouldBlock(): handle events, then the next frame
//
// Threads: that of the Renderer. The swapchain outlives the object.
class SwapchainFrame {
  public:
    explicit SwapchainFrame(rhi::Swapchain& swapchain) : m_swapchain(swapchain) {}
    SwapchainFrame(const SwapchainFrame&) = delete;
    SwapchainFrame& operator=(const SwapchainFrame&) = delete;

    // Acquires the window's next image for the open frame, as a color target of that extent without contents,
    // and follows the window's size. Returns nullopt if the window cannot be drawn to now, or its size has
    // just changed.
    std::optional<TextureId> Begin(Renderer& renderer, Extent2D extent);
    // Executes the frame and shows `drawn`, the last version of the target that Begin returned. Drivers of
    // CPUs would wait here until it is drawn: with these, ShowDrawn shows it, or the next Begin, which waits.
    void End(Renderer& renderer, TextureId drawn);
    // Ends the frame and returns true if Renderer::PreparePipelines does. Otherwise returns false: the frame
    // stays open, and nothing is shown. After DropFrame another frame may be declared.
    bool TryEnd(Renderer& renderer, TextureId drawn);
    // Returns false if the last frame has not been drawn yet. Never waits for it.
    bool ShowDrawn();

  private:
    void Finish(Renderer& renderer, TextureId drawn);
    void Execute(Renderer& renderer);
    void Show();

    rhi::Swapchain& m_swapchain;
    rhi::SwapchainImage m_image;
    ResourceState m_state;
    bool m_isStale = false;              // the window may have another size
    rhi::Device* m_drawingOn = nullptr;  // not null: m_image is not shown yet
    rhi::Submission m_drawn;             // the frame that draws it
};

}  // namespace raygraph
