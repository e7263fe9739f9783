#include "passes/raster.h"

#include "passes/draw_list.h"
#include "passes/project_hits.h"
#include "passes/raster_bindings.h"
#include "passes/rasterize.h"
#include "passes/scene_bindings.h"

namespace raygraph::passes {

bool CanDrawVisibility(const Renderer& renderer, const SceneIds& scene, Extent2D extent) {
    return CanRasterize(renderer, scene, extent) ||
           renderer.Device().Info().optional.drawIndirectFirstInstance;
}

RasterVisibility DrawVisibility(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                                FilmPosition film, Rasterizer rasterizer) {
    RequireFullFrame(settings, "DrawVisibility");
    if (!CanRasterize(renderer, scene, settings.extent)) rasterizer = Rasterizer::Device;
    if (rasterizer == Rasterizer::Device) RequireIndirectDraws(renderer, "DrawVisibility");
    RasterVisibility seen{
        .hits = renderer.CreateTexture("visibility", {settings.extent, Format::Rgba32Uint}),
        .depth = DepthTexture(renderer, "rasterDepth", settings.extent, rasterizer),
        .filmOffset = FilmOffset(film, settings.sampleIndex),
        .rasterizer = rasterizer,
    };
    const glm::vec2 shift = ClipOffset(seen.filmOffset, settings.extent);
    const DrawList list = ListDraws(renderer, scene, RasterParameters(scene, settings), shift);
    seen.drawCommands = list.commands;
    seen.visiblePlacements = list.visiblePlacements;
    DrawHits(renderer, scene, settings, seen, GlassDrawn::Yes);
    return seen;
}

RasterVisibility TraceVisibility(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                                 FilmPosition film) {
    RasterVisibility seen{
        .hits = renderer.CreateTexture("visibility", {RegionOf(settings).Extent(), Format::Rgba32Uint}),
        .depth = {},
        .drawCommands = {},
        .visiblePlacements = {},
        .filmOffset = FilmOffset(film, settings.sampleIndex),
    };
    seen.hits = TraceHits(renderer, scene, settings, seen.hits, seen.filmOffset);
    return seen;
}

RasterVisibility AnyVisibility(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                               FilmPosition film) {
    if (CanDrawVisibility(renderer, scene, settings.extent))
        return DrawVisibility(renderer, scene, settings, film);
    return TraceVisibility(renderer, scene, settings, film);
}

PrimaryHitIds RasterHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                         const RasterVisibility& seen) {
    PrimaryHitIds hits{
        .albedo = renderer.CreateTexture("albedo", {settings.extent, Format::Rgba32Float}),
        .normal = renderer.CreateTexture("normal", {settings.extent, Format::Rgba32Float}),
        .position = renderer.CreateTexture("position", {settings.extent, Format::Rgba32Float}),
        .ids = renderer.CreateTexture("ids", {settings.extent, Format::Rgba32Uint}),
    };
    renderer.AddPass(
        "RasterHits", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/hits.comp");
            pass.Uniform("parameters", RasterParameters(scene, settings));
            BindPixelSurfaces(pass, scene, seen, {});
            hits.albedo = pass.Writes("albedo", hits.albedo);
            hits.normal = pass.Writes("normal", hits.normal);
            hits.position = pass.Writes("position", hits.position);
            hits.ids = pass.Writes("ids", hits.ids);
        },
        [extent = settings.extent](CommandList& commands) { commands.DispatchOver(extent); });
    return hits;
}

}  // namespace raygraph::passes
