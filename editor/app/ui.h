// Runs Dear ImGui in the render graph, input in, one raster pass out, with the editor's style. Main thread
// only.
#pragma once

#include <imgui.h>
#include <memory>

#include "editor/app/input.h"
#include "renderer/graph/renderer.h"

namespace raygraph::editor {

// Returns what ImGui::Image takes to show the picture that is passed to DrawUi.
inline ImTextureID PictureTexture() {
    return reinterpret_cast<ImTextureID>(uintptr_t{1});
}

// Returns what it takes to show the thumbnails.
inline ImTextureID ThumbnailTexture() {
    return reinterpret_cast<ImTextureID>(uintptr_t{2});
}

// Owns the only ImGui context of the process, with the editor's fonts and style.
class Ui {
  public:
    Ui();
    ~Ui();
    Ui(const Ui&) = delete;
    Ui& operator=(const Ui&) = delete;

    // Starts a frame of ImGui calls. Sizes are in points, which are input.scale pixels; fonts follow the
    // scale.
    void Begin(const FrameInput& input);
    // Ends the calls; Draw draws the result.
    void End();
    // Draws over all of `target`, a color target of the window's extent. `picture` and `thumbnails` are not
    // drawn if they are invalid. Returns the target's new version.
    [[nodiscard]] TextureId Draw(Renderer& renderer, TextureId target, TextureId picture,
                                 TextureId thumbnails);

  private:
    TextureId DeclareAtlas(Renderer& renderer);
    float m_scale = 0.0f;  // scale of the current fonts
    uint32_t m_atlas = 0;  // number of font atlases so far
};

// --- Style, and keys ---

// Sets a dark, neutral style with one accent, which does not bias the judgement of a picture's color. Sizes
// are in points.
void ApplyStyle(ImGuiStyle& style);

// Passes keys to ImGui, for text fields and for shortcuts of its widgets.
void FeedKeys(ImGuiIO& io, const FrameInput& input);

}  // namespace raygraph::editor
