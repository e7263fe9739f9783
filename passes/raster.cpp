#include "passes/raster.h"

#include "passes/add_compute.h"
#include "passes/draw_list.h"
#include "passes/project_hits.h"
#include "passes/raster_bindings.h"
#include "passes/rasterize.h"
#include "passes/scene_bindings.h"
#include "passes/shadow_maps.h"
#include "shaders/shared/blur_levels.h"
#include "shaders/shared/shade_options.h"
#include "shaders/shared/trace_options.h"

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
    AddCompute(renderer, "RasterHits", "raster/hits.comp", settings.extent, [&](PassBuilder& pass) {
        pass.Uniform("parameters", RasterParameters(scene, settings));
        BindPixelSurfaces(pass, scene, seen, {});
        hits.albedo = pass.Writes("albedo", hits.albedo);
        hits.normal = pass.Writes("normal", hits.normal);
        hits.position = pass.Writes("position", hits.position);
        hits.ids = pass.Writes("ids", hits.ids);
    });
    return hits;
}

namespace {

constexpr rhi::Filter kNearest = rhi::Filter::Nearest;
constexpr rhi::AddressMode kClamp = rhi::AddressMode::ClampToEdge;

// Turns shadows off where the scene has none of the lights that the method handles.
RasterShadows ShadowsFor(const SceneIds& scene, RasterShadows shadows) {
    const bool hasPunctual = scene.punctualLights > 0;
    if (shadows == RasterShadows::Maps && !hasPunctual) return RasterShadows::Off;
    if (shadows == RasterShadows::Rays && !hasPunctual && scene.triangleLights == 0)
        return RasterShadows::Off;
    return shadows;
}

// Holds the inputs of all shading in a frame, and those of one picture. An invalid id: not present.
struct Shading {
    TextureId filteredEnvironment;
    RasterShadows shadows = RasterShadows::Off;
    ShadowMapIds maps;
    TextureId ambientVisibility;
    TextureId behind, behindBlurred, behindDepth;
    bool hasTextureLevels = false;
};

void BindShading(PassBuilder& pass, const SceneIds& scene, const Shading& shading) {
    const auto sampled = [&](const char* name, TextureId texture, const rhi::SamplerDesc& sampler) {
        pass.Reads(name, texture.IsValid() ? texture : scene.environmentMap, sampler);
    };
    const rhi::SamplerDesc nearest{.magFilter = kNearest, .minFilter = kNearest};
    const rhi::SamplerDesc linear{.addressU = kClamp, .addressV = kClamp};
    sampled("ambientVisibility", shading.ambientVisibility, nearest);
    sampled("behind", shading.behind, linear);
    sampled("behindBlurred", shading.behindBlurred, linear);
    sampled("behindDepth", shading.behindDepth, nearest);
    if (shading.shadows == RasterShadows::Maps) {
        pass.Reads("shadowAtlas", shading.maps.atlas, nearest);
        pass.Reads("shadowViews", shading.maps.views);
        pass.Reads("shadowLights", shading.maps.lights);
    }
    pass.Reads("filteredEnvironment", shading.filteredEnvironment, {.addressV = kClamp});
    BindEnvironment(pass, scene);
    BindLights(pass, scene);
    pass.Reads("energyTables", scene.energyTables);
}

TextureId ShadePixels(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                      const RasterVisibility& seen, const Shading& shading, const char* name) {
    TextureId radiance = renderer.CreateTexture("radiance", {settings.extent, Format::Rgba32Float});
    const bool isTraced = shading.shadows == RasterShadows::Rays;
    const auto setup = [&](PassBuilder& pass) {
        if (isTraced) {
            pass.RayGen("raster/shade_rays.rgen");
            BindTracing(pass, scene, RasterParameters(scene, settings), AlphaTest::On);
            BindShadowRays(pass, scene);
        } else {
            pass.Compute(shading.shadows == RasterShadows::Maps ? "raster/shade_maps.comp"
                                                                : "raster/shade.comp");
            pass.Uniform("parameters", RasterParameters(scene, settings));
        }
        uint32_t options = shading.ambientVisibility.IsValid() ? gpu::kShadeOcclusion : 0u;
        if (shading.behind.IsValid()) options |= gpu::kShadeBehind;
        BindPixelSurfaces(pass, scene, seen, {.option = options, .shadowTiles = shading.maps.tilesPerSide});
        BindShading(pass, scene, shading);
        SpecializeDirect(pass, scene, settings, shading.hasTextureLevels);
        radiance = pass.Writes("radiance", radiance);
    };
    const Extent2D extent = settings.extent;
    if (isTraced)
        renderer.AddPass(name, PassKind::RayTracing, setup,
                         [extent](CommandList& commands) { commands.TraceRays(extent); });
    else
        renderer.AddPass(name, PassKind::Compute, setup,
                         [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return radiance;
}

}  // namespace

TextureId RasterShade(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                      const RasterVisibility& seen, FilteredEnvironment& environment,
                      const RasterSettings& raster) {
    RequireFullFrame(settings, "RasterShade");
    Shading shading;
    shading.filteredEnvironment = FilterEnvironment(renderer, scene, environment);
    shading.shadows = ShadowsFor(scene, raster.shadows);
    shading.hasTextureLevels = raster.hasTextureLevels;
    if (shading.shadows == RasterShadows::Maps)
        shading.maps = DrawShadowMaps(renderer, scene, settings, {.atlasSize = raster.shadowAtlasSize});
    const bool hasDepth = seen.depth.IsValid();
    const bool hasOcclusion = raster.hasOcclusion && hasDepth && scene.lightSet.hasEnvironment != 0u;
    if (raster.hasTransmission && hasDepth && ProgramFeatures(scene, settings).Has(kTraceGlass)) {
        const RasterVisibility behind = DrawBehindGlass(renderer, scene, settings, seen);
        Shading behindShading = shading;
        if (hasOcclusion) behindShading.ambientVisibility = Occlusion(renderer, scene, settings, behind);
        shading.behind = ShadePixels(renderer, scene, settings, behind, behindShading, "ShadeBehind");
        shading.behindBlurred = BlurLevels(renderer, shading.behind);
        shading.behindDepth = behind.depth;
    }
    if (hasOcclusion) shading.ambientVisibility = Occlusion(renderer, scene, settings, seen);
    return ShadePixels(renderer, scene, settings, seen, shading, "RasterShade");
}

TextureId AnyRasterShade(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                         FilmPosition film, FilteredEnvironment& environment, const RasterSettings& raster) {
    RasterSettings possible = raster;
    // Round primitives are found by rays alone
    if (possible.shadows == RasterShadows::Maps &&
        (scene.features.Has(kTraceCapsules) || !renderer.Device().Info().optional.drawIndirectFirstInstance))
        possible.shadows = RasterShadows::Rays;
    return RasterShade(renderer, scene, settings, AnyVisibility(renderer, scene, settings, film), environment,
                       possible);
}

RasterVisibility DrawBehindGlass(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                                 const RasterVisibility& seen) {
    RasterVisibility behind = seen;
    behind.hits = renderer.CreateTexture("behindVisibility", renderer.Desc(seen.hits));
    behind.depth = DepthTexture(renderer, "behindDepth", settings.extent, seen.rasterizer);
    DrawHits(renderer, scene, settings, behind, GlassDrawn::No);
    return behind;
}

TextureId BlurLevels(Renderer& renderer, TextureId picture) {
    const Extent2D size = renderer.Desc(picture).extent;
    const Extent2D extent{gpu::BlurSize(size.width, 1), gpu::BlurRow(size.height, gpu::kBlurLevels + 1)};
    TextureId levels = renderer.CreateTexture("blurLevels", {extent, Format::Rgba32Float});
    AddCompute(renderer, "BlurLevels", "post/blur_levels.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("picture", picture,
                   {.addressU = rhi::AddressMode::ClampToEdge, .addressV = rhi::AddressMode::ClampToEdge});
        levels = pass.Writes("levels", levels);
    });
    return levels;
}

TextureId Occlusion(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                    const RasterVisibility& seen) {
    TextureId share = renderer.CreateTexture("ambientVisibility", {settings.extent, Format::R32Float});
    AddCompute(renderer, "Occlusion", "raster/occlusion.comp", settings.extent, [&](PassBuilder& pass) {
        pass.Uniform("parameters", RasterParameters(scene, settings));
        BindPixelSurfaces(pass, scene, seen, {});
        pass.Reads("depths", seen.depth,
                   {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
        pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
        share = pass.Writes("ambientVisibility", share);
    });
    return share;
}

}  // namespace raygraph::passes
