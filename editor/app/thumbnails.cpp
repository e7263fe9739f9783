#include "editor/app/thumbnails.h"

#include <algorithm>

#include "passes/add_compute.h"

namespace raygraph::editor {

namespace {

constexpr uint32_t kMadeInFrame = 2;

struct Constants {
    glm::uvec2 corner, size;
    uint32_t slot, isSrgb;
};

glm::uvec2 SizeFor(glm::uvec2 image) {
    const uint32_t longest = std::max({image.x, image.y, 1u});
    return glm::max(glm::uvec2(1u), (image * Thumbnails::kSide + longest / 2) / longest);
}

}  // namespace

std::optional<Thumbnails::Picture> Thumbnails::Show(const Document& document, uint32_t texture) {
    const uint64_t revision = document.ImageRevision();
    auto cell = std::ranges::find_if(
        m_cells, [&](const Cell& one) { return one.texture == texture && one.revision == revision; });
    if (cell == m_cells.end()) {
        cell = std::ranges::min_element(m_cells, {}, &Cell::lastFrame);
        if (cell->lastFrame == m_frame) return std::nullopt;  // all of them are shown
        const ImageFacts image = document.ImageOf(texture);
        *cell = {.texture = texture, .revision = revision, .size = SizeFor({image.width, image.height})};
    }
    cell->lastFrame = m_frame;
    if (!cell->isMade) return std::nullopt;
    // Half a pixel is left at the edges, beside which another picture is
    constexpr auto kWhole = static_cast<float>(kSide * kAcross);
    const glm::vec2 corner(Corner(static_cast<size_t>(cell - m_cells.begin())));
    return Picture{(corner + 0.5f) / kWhole, (corner + glm::vec2(cell->size) - 0.5f) / kWhole};
}

TextureId Thumbnails::Declare(Renderer& renderer, const GpuScene& gpu, const Document& document) {
    const uint64_t frame = m_frame++;
    if (std::ranges::none_of(m_cells, [&](const Cell& cell) { return cell.lastFrame == frame; })) return {};
    TextureId pictures =
        renderer.Persist("thumbnails", {Extent2D{kSide * kAcross, kSide * kAcross}, Format::Rgba8Unorm});
    if (renderer.IsFresh(pictures))
        for (Cell& cell : m_cells) cell.isMade = false;
    std::optional<SceneMemory> memory;
    uint32_t made = 0;
    for (size_t i = 0; i < kCount && made < kMadeInFrame; ++i) {
        const Cell& cell = m_cells[i];
        if (cell.isMade || cell.lastFrame != frame) continue;
        if (!memory) memory = gpu.Memory();
        if (cell.texture >= memory->textures.size()) continue;
        const bool isSrgb = document.Scene().textures[cell.texture].colorSpace == scene::ColorSpace::Srgb;
        passes::AddCompute(
            renderer, "Thumbnail", "editor/thumbnail.comp", {cell.size.x, cell.size.y},
            [&](PassBuilder& pass) {
                pass.Uses(gpu.Textures(renderer));
                pass.Constants(Constants{Corner(i), cell.size, memory->textures[cell.texture].slot, isSrgb});
                pictures = pass.Writes("thumbnails", pictures);
            });
        renderer.OnSubmitted([this, i, texture = cell.texture, revision = cell.revision] {
            Cell& done = m_cells[i];
            done.isMade = done.texture == texture && done.revision == revision;
        });
        ++made;
    }
    return pictures;
}

}  // namespace raygraph::editor
