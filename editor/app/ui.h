// Dear ImGui in the render graph: input in, one raster pass out.
#pragma once

#include <imgui.h>

#include <memory>

#include "editor/app/input.h"
#include "renderer/graph/renderer.h"

namespace raygraph::editor {

// For ImGui::Image: the picture that is passed to DrawUi.
inline ImTextureID PictureTexture() {
    return reinterpret_cast<ImTextureID>(uintptr_t{1});
}

// The only ImGui context of the process, with the editor's fonts and style. Main thread only.
class Ui {
  public:
    Ui();
    ~Ui();
    Ui(const Ui&) = delete;
    Ui& operator=(const Ui&) = delete;

    // Starts a frame of ImGui calls. Sizes are points: pixels over input.scale. Fonts follow the scale.
    void Begin(const FrameInput& input);
    // Ends the calls; Draw draws the result.
    void End();
    // Draws over all of `target`, a color target of the window's extent; `picture` may be invalid: then it is
    // not drawn. Returns the target's new version.
    [[nodiscard]] TextureId Draw(Renderer& renderer, TextureId target, TextureId picture);

  private:
    TextureId DeclareAtlas(Renderer& renderer);
    float m_scale = 0.0f;  // of the current fonts
    uint32_t m_atlas = 0;  // counts font atlases
};

}  // namespace raygraph::editor
