// Dear ImGui in the render graph: input in, one raster pass out.
#pragma once

#include <imgui.h>

#include <memory>

#include "editor/app/input.h"
#include "renderer/graph/renderer.h"

namespace raygraph::editor {

// For ImGui::Image: what DrawUi is given as the picture.
inline ImTextureID PictureTexture() {
    return reinterpret_cast<ImTextureID>(uintptr_t{1});
}

// The one ImGui context of the process, with our fonts and style. Main thread alone.
class Ui {
  public:
    Ui();
    ~Ui();
    Ui(const Ui&) = delete;
    Ui& operator=(const Ui&) = delete;

    // Starts a frame of ImGui calls. Sizes are points: pixels over input.scale. Fonts follow the scale.
    void Begin(const FrameInput& input);
    // Ends the calls; Draw shows what they made.
    void End();
    // Draws over all of `target`, a color target of the window's extent; `picture` may be invalid: then
    // nothing of it is drawn. Returns the target's new version.
    [[nodiscard]] TextureId Draw(Renderer& renderer, TextureId target, TextureId picture);

  private:
    TextureId DeclareAtlas(Renderer& renderer);
    float m_scale = 0.0f;  // of the fonts at hand
    uint32_t m_atlas = 0;  // counts font atlases
};

}  // namespace raygraph::editor
