#include "passes/compare.h"

#include <algorithm>
#include <cmath>

#include "passes/same_extent.h"

namespace raygraph::passes {

TextureId Wipe(Renderer& renderer, TextureId left, TextureId right, float position) {
    const Extent2D extent = RequireComparable(renderer, "Wipe", left, right, Format::Rgba8Unorm);
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    struct Constants {
        int32_t column;
        int32_t lineWidth;
    };
    const float place = std::isfinite(position) ? std::clamp(position, 0.0f, 1.0f) : 0.0f;
    const auto column = static_cast<int32_t>(std::lround(double{place} * extent.width));
    // Thin, but visible on a picture of many pixels
    const int32_t lineWidth = column == 0 ? 0 : 1 + static_cast<int32_t>(extent.width / 1000);
    renderer.AddPass(
        "Wipe", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/wipe.comp");
            pass.Reads("left", left);
            pass.Reads("right", right);
            pass.Constants(Constants{column, lineWidth});
            display = pass.Writes("display", display);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return display;
}

TextureId SideBySide(Renderer& renderer, TextureId left, TextureId right) {
    const Extent2D extent = RequireComparable(renderer, "SideBySide", left, right, Format::Rgba8Unorm);
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    renderer.AddPass(
        "SideBySide", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/side_by_side.comp");
            pass.Reads("left", left);
            pass.Reads("right", right);
            display = pass.Writes("display", display);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return display;
}

}  // namespace raygraph::passes
