#include "passes/raster.h"

#include "passes/draw_list.h"
#include "passes/raster_bindings.h"
#include "passes/scene_bindings.h"

namespace raygraph::passes {

RasterVisibility DrawVisibility(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                                FilmPosition film) {
    RasterVisibility seen{
        .hits = renderer.CreateTexture("visibility", {settings.extent, Format::Rgba32Uint}),
        .depth = renderer.CreateTexture("rasterDepth", {settings.extent, Format::D32Float}),
        .filmOffset = FilmOffset(film, settings.sampleIndex),
    };
    const gpu::TraceParameters parameters = RasterParameters(scene, settings);
    const glm::vec2 shift = ShiftOf(seen.filmOffset, settings.extent);
    const DrawList list = ListDraws(renderer, scene, parameters, shift, "DrawVisibility");
    seen.drawCommands = list.commands;
    bool isFirst = true;
    for (const DrawClass& drawn : ClassesOf(scene)) {
        // Without any draw, the first pass still clears
        if (drawn.range.count == 0 && (DrawCount(scene) > 0 || !isFirst)) continue;
        renderer.AddPass(
            std::string("Draw") + drawn.name, PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("raster/visibility.vert");
                pass.Fragment(drawn.isTested ? "raster/visibility_tested.frag" : "raster/visibility.frag");
                pass.Raster({.cull = drawn.isCulled ? rhi::CullMode::Back : rhi::CullMode::None,
                             .depthCompare = rhi::DepthCompare::Greater});
                BindDrawing(pass, scene, parameters, list, drawn.isTested, settings.sampler);
                pass.Constants(shift);
                seen.hits = pass.ColorTarget(0, seen.hits, {.clear = isFirst});
                seen.depth = pass.DepthTarget(seen.depth, {.clear = isFirst, .value = 0.0f});
            },
            [range = drawn.range, list](CommandList& commands, const PassResources& resources) {
                commands.DrawIndirect(resources.Buffer(list.commands), range.first, range.count);
            });
        isFirst = false;
    }
    return seen;
}

RasterVisibility TraceVisibility(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                                 FilmPosition film) {
    RasterVisibility seen{
        .hits = renderer.CreateTexture("visibility", {settings.extent, Format::Rgba32Uint}),
        .depth = {},
        .drawCommands = {},
        .filmOffset = FilmOffset(film, settings.sampleIndex),
    };
    renderer.AddPass(
        "TraceVisibility", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("raster/trace_visibility.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            BindTracing(pass, scene, RasterParameters(scene, settings), AlphaTest::On);
            if (scene.hasAlpha) {
                BindGeometry(pass, scene);
                BindMaterials(pass, scene);
            }
            pass.Constants(seen.filmOffset);
            seen.hits = pass.Writes("visibility", seen.hits);
        },
        [extent = settings.extent](CommandList& commands) { commands.TraceRays(extent); });
    return seen;
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
            BindPixels(pass, scene, settings, seen);
            hits.albedo = pass.Writes("albedo", hits.albedo);
            hits.normal = pass.Writes("normal", hits.normal);
            hits.position = pass.Writes("position", hits.position);
            hits.ids = pass.Writes("ids", hits.ids);
        },
        [extent = settings.extent](CommandList& commands) { commands.DispatchOver(extent); });
    return hits;
}

TextureId RasterShade(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                      const RasterVisibility& seen, FilteredEnvironment& environment) {
    const TextureId filtered = FilterEnvironment(renderer, scene, environment);
    TextureId radiance = renderer.CreateTexture("radiance", {settings.extent, Format::Rgba32Float});
    renderer.AddPass(
        "RasterShade", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/shade.comp");
            BindPixels(pass, scene, settings, seen);
            BindEnvironment(pass, scene);
            pass.Reads("filteredEnvironment", filtered, {.addressV = rhi::AddressMode::ClampToEdge});
            BindLights(pass, scene);
            pass.Reads("energyTables", scene.energyTables);
            SpecializeDirect(pass, scene, settings);
            radiance = pass.Writes("radiance", radiance);
        },
        [extent = settings.extent](CommandList& commands) { commands.DispatchOver(extent); });
    return radiance;
}

}  // namespace raygraph::passes
