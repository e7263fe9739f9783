// Thumbnails are small pictures of the scene's textures, which the device makes from its own copies once a
// panel shows them: a few in a frame, and as many as one texture of 1 MiB holds. Threads: that of the
// Renderer.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>

#include "editor/app/document.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"

namespace raygraph::editor {

class Thumbnails {
  public:
    static constexpr uint32_t kSide = 64, kAcross = 8, kCount = kAcross * kAcross;  // pixels; cells

    struct Picture {
        glm::vec2 from{0.0f}, to{0.0f};  // texture coordinates in Declare's texture
    };
    // Returns the picture of a texture of the document; none until a frame has made it. A picture that no
    // frame asks for may give its place to another one.
    std::optional<Picture> Show(const Document& document, uint32_t texture);
    // Makes what was asked for since the last call. Returns the texture; an invalid id if nothing was.
    TextureId Declare(Renderer& renderer, const GpuScene& gpu, const Document& document);
    void Clear() { m_cells = {}; }  // the scene is another one

  private:
    struct Cell {
        uint32_t texture = scene::kNone;
        uint64_t revision = 0;  // Document::ImageRevision
        uint64_t lastFrame = 0;
        bool isMade = false;
        glm::uvec2 size{0u};  // pixels
    };
    static glm::uvec2 Corner(size_t cell) { return kSide * glm::uvec2(cell % kAcross, cell / kAcross); }

    std::array<Cell, kCount> m_cells;
    uint64_t m_frame = 1;
};

}  // namespace raygraph::editor
