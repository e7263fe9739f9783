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
//
// Threads: that of the Renderer. The swapchain outlives the object.
class SwapchainFrame {
  public:
    explicit SwapchainFrame(rhi::Swapchain& swapchain) : m_swapchain(swapchain) {}
    SwapchainFrame(const SwapchainFrame&) = delete;
    SwapchainFrame& operator=(const SwapchainFrame&) = delete;

    // The window's next image, for the open frame: a color target of that extent, without contents. Follows
    // the window's size. Nullopt: the window cannot be drawn to now, or its size has just changed.
    std::optional<TextureId> Begin(Renderer& renderer, Extent2D extent);
    // Executes the frame and shows `drawn`, the last version of what Begin returned.
    void End(Renderer& renderer, TextureId drawn);

  private:
    rhi::Swapchain& m_swapchain;
    rhi::SwapchainImage m_image;
    ResourceState m_state;
    bool m_isStale = false;  // the window may have another size
};

}  // namespace raygraph
