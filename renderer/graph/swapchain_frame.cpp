#include "renderer/graph/swapchain_frame.h"

#include <utility>

namespace raygraph {

std::optional<TextureId> SwapchainFrame::Begin(Renderer& renderer, Extent2D extent) {
    Show();
    std::optional<rhi::SwapchainImage> image;
    for (int attempt = 0; attempt < 2 && !image; ++attempt) {
        if (m_isStale || m_swapchain.Extent() != extent) m_swapchain.Resize(extent);
        m_isStale = false;
        image = m_swapchain.Acquire();
        if (!image) m_isStale = true;
    }
    if (!image || m_swapchain.Extent() != extent) return std::nullopt;
    m_image = *image;
    // The image has no contents, and the first write waits for the semaphore in any stage.
    m_state = {};
    m_state.readStages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    return renderer.Import("window", *m_image.texture, m_state);
}

void SwapchainFrame::Finish(Renderer& renderer, TextureId drawn) {
    // An image that was not shown is returned again, with the same semaphores.
    renderer.WaitSemaphore(m_image.acquired, DropPolicy::LeaveAlone);
    renderer.SignalSemaphore(m_image.drawn, DropPolicy::LeaveAlone);
    renderer.Export(drawn, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
}

void SwapchainFrame::End(Renderer& renderer, TextureId drawn) {
    Finish(renderer, drawn);
    Execute(renderer);
}

bool SwapchainFrame::TryEnd(Renderer& renderer, TextureId drawn) {
    Finish(renderer, drawn);
    if (!renderer.PreparePipelines()) return false;
    Execute(renderer);
    return true;
}

void SwapchainFrame::Execute(Renderer& renderer) {
    m_drawn = renderer.Execute();
    m_drawingOn = &renderer.Device();
    if (m_drawingOn->Info().type != rhi::DeviceType::Cpu) Show();
}

bool SwapchainFrame::ShowDrawn() {
    if (m_drawingOn && !m_drawingOn->HasCompleted(m_drawn)) return false;
    Show();
    return true;
}

void SwapchainFrame::Show() {
    if (!std::exchange(m_drawingOn, nullptr)) return;
    m_isStale = !m_swapchain.Present(m_image, m_drawn);
}

}  // namespace raygraph
