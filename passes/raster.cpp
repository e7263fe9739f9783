#include "passes/raster.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "passes/scene_bindings.h"
#include "shaders/shared/draw_records.h"

namespace raygraph::passes {

namespace {

constexpr uint32_t kGroupSize = 64;  // of the shaders that take one invocation a record

constexpr std::array<const char*, kDrawKindCount> kPassNames{"DrawOpaque", "DrawOpaqueTwoSided",
                                                             "DrawAlphaTested", "DrawAlphaTestedTwoSided"};

// Push constants of the shaders in shaders/raster.
struct CullConstants {
    glm::vec2 shift;
    uint32_t count;
};
struct PixelConstants {
    glm::vec2 filmOffset;
    uint32_t punctualLights;
};

uint32_t GroupsFor(uint32_t count) {
    return (count + kGroupSize - 1) / kGroupSize;
}

gpu::TraceParameters ParametersOf(const SceneIds& scene, const TraceSettings& settings) {
    gpu::TraceParameters parameters = ParametersFor(scene, settings);
    parameters.camera.lensRadius = 0.0f;
    return parameters;
}

// A low-discrepancy sequence over the pixel: additive recurrence by the powers of 1 / g, g the real root of
// x^3 = x + 1. The first place is the pixel's centre.
glm::vec2 FilmOffset(FilmPosition film, uint32_t sampleIndex) {
    if (film == FilmPosition::Center) return glm::vec2(0.5f);
    const auto place = [&](double step) {
        const double x = 0.5 + step * sampleIndex;
        return static_cast<float>(x - std::floor(x));
    };
    return {place(0.75487766624669276), place(0.56984029099805327)};
}

// Clip units that bring this place of each pixel to the pixel's centre, where it is drawn.
glm::vec2 ShiftOf(const glm::vec2& filmOffset, Extent2D extent) {
    return 2.0f * (glm::vec2(0.5f) - filmOffset) / glm::vec2(extent.width, extent.height);
}

struct DrawList {
    BufferId commands;           // gpu::DrawCommand[], as scene.draws
    BufferId visiblePlacements;  // see shaders/shared/draw_records.h
};

uint32_t DrawCount(const SceneIds& scene) {
    return scene.drawsOfKind.back().first + scene.drawsOfKind.back().count;
}

DrawList ListDraws(Renderer& renderer, const SceneIds& scene, const gpu::TraceParameters& parameters,
                   const glm::vec2& shift) {
    const uint32_t drawCount = DrawCount(scene), placementCount = scene.placementCount;
    DrawList list{
        .commands = renderer.CreateBuffer("drawCommands",
                                          {.size = std::max(1u, drawCount) * sizeof(gpu::DrawCommand)}),
        .visiblePlacements = renderer.CreateBuffer("visiblePlacements",
                                                   {.size = std::max(1u, placementCount) * sizeof(uint32_t)}),
    };
    renderer.AddPass(
        "ResetDraws", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/reset_draws.comp");
            pass.Reads("draws", scene.draws);
            list.commands = pass.Writes("commands", list.commands);
            pass.Constants(drawCount);
        },
        [drawCount](CommandList& commands) { commands.Dispatch(GroupsFor(drawCount)); });
    renderer.AddPass(
        "CullInstances", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/cull_instances.comp");
            pass.Uniform("parameters", parameters);
            pass.Reads("instances", scene.instances);
            pass.Reads("draws", scene.draws);
            list.commands = pass.Updates("commands", list.commands);
            list.visiblePlacements = pass.Writes("visiblePlacements", list.visiblePlacements);
            pass.Constants(CullConstants{shift, placementCount});
        },
        [placementCount](CommandList& commands) { commands.Dispatch(GroupsFor(placementCount)); });
    return list;
}

void BindPixels(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings,
                const RasterVisibility& seen) {
    pass.Uniform("parameters", ParametersOf(scene, settings));
    pass.Reads("visibility", seen.hits);
    pass.Constants(PixelConstants{seen.filmOffset, scene.punctualLights});
    BindGeometry(pass, scene);
    BindMaterials(pass, scene);
}

}  // namespace

RasterVisibility DrawVisibility(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                                FilmPosition film) {
    const rhi::DeviceInfo& device = renderer.Device().Info();
    if (!device.optional.drawIndirectFirstInstance)
        throw Error(ErrorKind::Usage,
                    "DrawVisibility: the device " + device.name + " lacks drawIndirectFirstInstance");
    RasterVisibility seen{
        .hits = renderer.CreateTexture("visibility", {settings.extent, Format::Rgba32Uint}),
        .depth = renderer.CreateTexture("rasterDepth", {settings.extent, Format::D32Float}),
        .filmOffset = FilmOffset(film, settings.sampleIndex),
    };
    const gpu::TraceParameters parameters = ParametersOf(scene, settings);
    const glm::vec2 shift = ShiftOf(seen.filmOffset, settings.extent);
    const DrawList list = ListDraws(renderer, scene, parameters, shift);
    seen.drawCommands = list.commands;
    bool isFirst = true;
    for (size_t i = 0; i < kDrawKindCount; i++) {
        const auto kind = static_cast<DrawKind>(i);
        const DrawRange range = scene.drawsOfKind[i];
        // Without any draw, the first pass still clears
        if (range.count == 0 && (DrawCount(scene) > 0 || i > 0)) continue;
        const bool isTested = kind == DrawKind::AlphaTested || kind == DrawKind::AlphaTestedTwoSided;
        const bool isCulled = kind == DrawKind::Opaque || kind == DrawKind::AlphaTested;
        renderer.AddPass(
            kPassNames[i], PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("raster/visibility.vert");
                pass.Fragment(isTested ? "raster/visibility_tested.frag" : "raster/visibility.frag");
                pass.Raster({.cull = isCulled ? rhi::CullMode::Back : rhi::CullMode::None,
                             .depthCompare = rhi::DepthCompare::Greater});
                pass.Uniform("parameters", parameters);
                pass.Reads("instances", scene.instances);
                pass.Reads("visiblePlacements", list.visiblePlacements);
                pass.ReadsArguments(list.commands);
                pass.Constants(shift);
                if (isTested) {
                    pass.Reads("geometries", scene.geometries);
                    BindMaterials(pass, scene);
                    pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
                }
                seen.hits = pass.ColorTarget(0, seen.hits, {.clear = isFirst});
                seen.depth = pass.DepthTarget(seen.depth, {.clear = isFirst, .value = 0.0f});
            },
            [range, drawn = list.commands](CommandList& commands, const PassResources& resources) {
                commands.DrawIndirect(resources.Buffer(drawn), range.first, range.count);
            });
        isFirst = false;
    }
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
