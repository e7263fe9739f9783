#include "editor/viewport/kept_display.h"

#include "passes/show.h"

namespace raygraph::viewport {

namespace {

using passes::Region;

// Returns the pixels that have a sample of the current pass over the picture.
std::vector<Region> CompletedRegions(const passes::TileCursor& cursor, Extent2D extent) {
    std::vector<Region> regions;
    if (cursor.Y() > 0) regions.push_back({0, 0, extent.width, cursor.Y()});
    if (cursor.X() > 0) regions.push_back({0, cursor.Y(), cursor.X(), cursor.BandHeight()});
    return regions;
}

// Returns the display's pixels that lie in these texels of a coarser picture.
Region Scaled(const Region& texels, Extent2D from, Extent2D to) {
    const auto scaled = [](uint32_t edge, uint32_t length, uint32_t toLength) {
        return static_cast<uint32_t>((uint64_t{edge} * toLength + length - 1) / length);
    };
    const uint32_t x = scaled(texels.x, from.width, to.width), y = scaled(texels.y, from.height, to.height);
    return {x, y, scaled(texels.x + texels.width, from.width, to.width) - x,
            scaled(texels.y + texels.height, from.height, to.height) - y};
}

}  // namespace

TextureId Keep(Renderer& renderer, TextureId picture, TextureId kept, std::function<void()> onSubmitted) {
    renderer.AddPass(
        "KeepPicture", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(picture);
            kept = pass.CopiesTo(kept);
        },
        [picture, kept, onSubmitted = std::move(onSubmitted)](CommandList& commands,
                                                              const PassResources& resources) {
            commands.CopyTexture(resources.Texture(picture), resources.Texture(kept));
            if (onSubmitted) commands.OnSubmitted(onSubmitted);
        });
    return kept;
}

// Returns whether only this frame's tiles are missing.
bool CachedDisplay::IsValid(const Source& source, const Key& now) const {
    if (!m_made) return false;
    Key before = now;
    before.progress = source.before;
    // The tiles that complete the first sample cover the last of the base
    if (now.progress.sampleCount > 0) before.baseScale = m_made->baseScale;
    return *m_made == before;
}

TextureId CachedDisplay::Declare(Renderer& renderer, const Source& source,
                                 const passes::TonemapSettings& tonemap,
                                 const std::optional<passes::Backdrop>& backdrop) {
    const Extent2D extent = renderer.Desc(source.mean).extent;
    TextureId display = renderer.Persist(m_name, {extent, Format::Rgba8Unorm});
    const bool hasSample = source.after.sampleCount > 0 && !source.isPreview;
    const Key now{.extent = extent,
                  .tonemap = tonemap,
                  .backdrop = backdrop ? std::optional(backdrop->settings) : std::nullopt,
                  .resetCount = source.resetCount,
                  .progress = source.after,
                  .baseScale = hasSample ? 1 : source.baseScale,
                  .isPreview = source.isPreview};
    const auto made = [this, now] { m_made = now; };
    std::vector<Region> changed = source.tiles;
    if (renderer.IsFresh(display) || !IsValid(source, now)) {
        if (hasSample) {
            changed = {passes::WholeOf(extent)};
        } else {
            display = passes::Show(renderer, passes::Tonemap(renderer, source.base, tonemap, backdrop),
                                   display, made);
            if (!source.isPreview) changed = CompletedRegions(source.after.cursor, extent);
        }
    }
    if (source.finer.IsValid()) {
        const Region region = Scaled(source.finerTile, renderer.Desc(source.finer).extent, extent);
        if (!region.IsEmpty())
            display = passes::TonemapInto(renderer, source.finer, display, region, tonemap, made, backdrop);
    }
    for (const Region& region : changed)
        display = passes::TonemapInto(renderer, source.mean, display, region, tonemap, made, backdrop);
    return display;
}

bool CachedDisplay::HasLast(Renderer& renderer, Extent2D extent) const {
    return m_made && m_made->extent == extent && DeclareLast(renderer).IsValid();
}

TextureId CachedDisplay::DeclareLast(Renderer& renderer) const {
    if (!m_made) return {};
    const TextureId display = renderer.Persist(m_name, {m_made->extent, Format::Rgba8Unorm});
    return renderer.IsFresh(display) ? TextureId{} : display;
}

}  // namespace raygraph::viewport
