#include "passes/views.h"

#include "base/text.h"
#include "passes/add_compute.h"
#include "passes/draw_list.h"
#include "passes/raster_bindings.h"
#include "passes/scene_bindings.h"

namespace raygraph::passes {

namespace {

void Reject(const char* pass, View view) {
    throw MakeError(ErrorKind::Usage, "{}: the view {} is none of its views", pass, Name(view));
}

// Minimum and maximum, see post/value_range.comp.
BufferId ValueRange(Renderer& renderer, TextureId values) {
    BufferId range = renderer.CreateBuffer("valueRange", {.size = 2 * sizeof(uint32_t)});
    renderer.AddPass(
        "ResetRange", PassKind::Transfer, [&](PassBuilder& pass) { range = pass.CopiesTo(range); },
        [range](CommandList& commands, const PassResources& resources) {
            commands.Fill(resources.Buffer(range), 0);
        });
    AddCompute(renderer, "ValueRange", "post/value_range.comp", renderer.Desc(values).extent,
               [&](PassBuilder& pass) {
                   pass.Reads("values", values);
                   range = pass.Updates("range", range);
               });
    return range;
}

}  // namespace

TextureId SurfaceView(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                      const RasterVisibility& seen, View view) {
    if (!ShowsSurface(view)) Reject("SurfaceView", view);
    const Extent2D visibleExtent = RegionOf(settings).Extent();
    TextureId values = renderer.CreateTexture("surfaceView", {visibleExtent, Format::Rgba32Float});
    AddCompute(renderer, "SurfaceView", "raster/surface_view.comp", visibleExtent, [&](PassBuilder& pass) {
        pass.Uniform("parameters", RasterParameters(scene, settings));
        BindPixelSurfaces(pass, scene, seen, {.option = static_cast<uint32_t>(view)});
        values = pass.Writes("values", values);
    });
    return values;
}

TextureId Overdraw(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                   FilmPosition film) {
    RequireIndirectDraws(renderer, "Overdraw");
    RequireFullFrame(settings, "Overdraw");
    TextureId counts = renderer.CreateTexture("overdraw", {settings.extent, Format::R16Float});
    const gpu::TraceParameters parameters = RasterParameters(scene, settings);
    const glm::vec2 shift = ClipOffset(FilmOffset(film, settings.sampleIndex), settings.extent);
    const DrawList list = ListDraws(renderer, scene, parameters, shift);
    bool isFirst = true;
    for (const DrawClass& drawn : ClassesOf(scene)) {
        // Without any draw, the first pass still clears
        if (drawn.range.count == 0 && (DrawCount(scene) > 0 || !isFirst)) continue;
        renderer.AddPass(
            std::string("Overdraw") + drawn.name, PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("raster/visibility.vert");
                pass.Fragment(drawn.isTested ? "raster/overdraw_tested.frag" : "raster/overdraw.frag");
                pass.Raster({.cull = drawn.isCulled ? rhi::CullMode::Back : rhi::CullMode::None,
                             .blend = rhi::BlendMode::Additive});
                BindDrawing(pass, scene, parameters, list, drawn.isTested, settings.sampler);
                pass.Constants(shift);
                counts = pass.ColorTarget(0, counts, {.clear = isFirst});
            },
            [range = drawn.range, list](CommandList& commands, const PassResources& resources) {
                commands.DrawIndirect(resources.Buffer(list.commands), range.first, range.count);
            });
        isFirst = false;
    }
    return SpreadCounts(renderer, counts);
}

TextureId SpreadCounts(Renderer& renderer, TextureId counts) {
    const Extent2D extent = renderer.Desc(counts).extent;
    TextureId values = renderer.CreateTexture("counts", {extent, Format::Rgba32Float});
    AddCompute(renderer, "SpreadCounts", "post/spread_counts.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("counts", counts, {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
        values = pass.Writes("values", values);
    });
    return values;
}

TextureId ViewValues(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, View view,
                     FilmPosition film, SurfaceSource surfaces) {
    if (CountsPaths(view)) {
        const TraceIds traced = Trace(renderer, scene, settings, {.rayCounts = true});
        return SpreadCounts(renderer, view == View::RayCost ? traced.rayCounts : traced.bounces);
    }
    if (view == View::Overdraw) return Overdraw(renderer, scene, settings, film);
    if (!ShowsSurface(view)) Reject("ViewValues", view);
    const auto visibility = surfaces == SurfaceSource::Rays ? TraceVisibility : AnyVisibility;
    return SurfaceView(renderer, scene, settings, visibility(renderer, scene, settings, film), view);
}

TextureId PaintView(Renderer& renderer, TextureId values, View view) {
    if (ShowsLight(view)) Reject("PaintView", view);
    const Extent2D extent = renderer.Desc(values).extent;
    TextureId display = renderer.CreateTexture("display", {extent, Format::Rgba8Unorm});
    const BufferId range = ValueRange(renderer, values);
    AddCompute(renderer, "PaintView", "post/paint_view.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("values", values);
        pass.Reads("range", range);
        pass.Constants(static_cast<uint32_t>(view));
        display = pass.Writes("display", display);
    });
    return display;
}

// --- Properties of views that need no drawing ---

bool ShowsLight(View view) {
    return view == View::PathTraced || view == View::Raster;
}

bool ShowsSurface(View view) {
    return !ShowsLight(view) && view != View::Overdraw && !CountsPaths(view);
}

bool CountsPaths(View view) {
    return view == View::RayCost || view == View::PathLength;
}

bool IsAverageable(View view) {
    return view != View::Depth && view != View::Instance && view != View::Material;
}

}  // namespace raygraph::passes
