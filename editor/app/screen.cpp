#include "editor/app/screen.h"

namespace raygraph::editor {

std::optional<TextureId> PictureScreen::Begin(Renderer& renderer, rhi::Extent2D extent) {
    if (extent.IsEmpty()) return std::nullopt;
    return renderer.CreateTexture("screen", {extent, rhi::Format::Rgba8Unorm});
}

void PictureScreen::End(Renderer& renderer, TextureId drawn) {
    renderer.Present(drawn);
    renderer.Execute();
}

}  // namespace raygraph::editor
