#include "passes/raster_bindings.h"

#include "passes/add_compute.h"
#include "passes/rasterize.h"
#include "passes/scene_bindings.h"

namespace raygraph::passes {

namespace {

// These are push constants of shaders/raster/pixel.glsl.
struct PixelConstants {
    glm::vec2 filmOffset;
    uint32_t punctualLights;
    uint32_t option;
    uint32_t shadowTiles;
};
// Holds the push constants of shaders/raster/trace_capsules.rgen.
struct CapsuleConstants {
    glm::vec2 filmOffset;
    uint32_t drawsGlass;
};

}  // namespace

void BindPixelSurfaces(PassBuilder& pass, const SceneIds& scene, const RasterVisibility& seen,
                       const PixelOptions& options) {
    pass.Reads("visibility", seen.hits);
    pass.Constants(
        PixelConstants{seen.filmOffset, scene.punctualLights, options.option, options.shadowTiles});
    BindGeometry(pass, scene);
    BindMaterials(pass, scene);
}

void BindDrawing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters,
                 const DrawList& list, bool isTested, SamplerKind sampler) {
    pass.Uniform("parameters", parameters);
    BindInstances(pass, scene);
    pass.Reads("visiblePlacements", list.visiblePlacements);
    pass.ReadsArguments(list.commands);
    if (isTested) BindAlphaTest(pass, scene, sampler);
}

void BindAlphaTest(PassBuilder& pass, const SceneIds& scene, SamplerKind sampler) {
    pass.Reads("geometries", scene.geometries);
    BindMaterials(pass, scene);
    pass.Specialize("kSamplerKind", static_cast<uint32_t>(sampler));
}

TextureId DepthTexture(Renderer& renderer, const char* name, Extent2D extent, Rasterizer rasterizer) {
    const bool isDevice = rasterizer == Rasterizer::Device;
    return renderer.CreateTexture(name, {extent, isDevice ? Format::D32Float : Format::R32Float});
}

namespace {

void DrawTriangles(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                   RasterVisibility& seen, GlassDrawn glass) {
    if (seen.rasterizer == Rasterizer::Compute) return RasterizeHits(renderer, scene, settings, seen, glass);
    const gpu::TraceParameters parameters = RasterParameters(scene, settings);
    const glm::vec2 shift = ClipOffset(seen.filmOffset, settings.extent);
    const DrawList list{seen.drawCommands, seen.visiblePlacements};
    const bool skipsGlass = glass == GlassDrawn::No;
    bool isFirst = true;
    for (const DrawClass& drawn : ClassesOf(scene)) {
        // Without any draw, the first pass still clears
        if (drawn.range.count == 0 && (DrawCount(scene) > 0 || !isFirst)) continue;
        renderer.AddPass(
            std::string(skipsGlass ? "DrawBehind" : "Draw") + drawn.name, PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex(skipsGlass ? "raster/visibility_opaque.vert" : "raster/visibility.vert");
                pass.Fragment(drawn.isTested ? "raster/visibility_tested.frag" : "raster/visibility.frag");
                pass.Raster({.cull = drawn.isCulled ? rhi::CullMode::Back : rhi::CullMode::None,
                             .depthCompare = rhi::DepthCompare::Greater});
                BindDrawing(pass, scene, parameters, list, drawn.isTested, settings.sampler);
                if (skipsGlass && !drawn.isTested) {
                    pass.Reads("geometries", scene.geometries);
                    pass.Reads("materials", scene.materials);
                }
                pass.Constants(shift);
                seen.hits = pass.ColorTarget(0, seen.hits, {.clear = isFirst});
                seen.depth = pass.DepthTarget(seen.depth, {.clear = isFirst, .value = 0.0f});
            },
            [range = drawn.range, list](CommandList& commands, const PassResources& resources) {
                commands.DrawIndirect(resources.Buffer(list.commands), range.first, range.count);
            });
        isFirst = false;
    }
    AddCompute(renderer, "PlaceHits", "raster/place_hits.comp", settings.extent, [&](PassBuilder& pass) {
        pass.Uniform("parameters", parameters);
        BindInstances(pass, scene);
        pass.Constants(shift);
        seen.hits = pass.Updates("visibility", seen.hits);
    });
}

// Round primitives are no triangles: rays find those in front of what was drawn.
void TraceCapsules(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                   RasterVisibility& seen, GlassDrawn glass) {
    TextureId depth = renderer.CreateTexture("capsuleDepth", {settings.extent, Format::R32Float});
    renderer.AddPass(
        "TraceCapsules", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("raster/trace_capsules.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            BindTracing(pass, scene, RasterParameters(scene, settings), AlphaTest::On);
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            pass.Constants(CapsuleConstants{seen.filmOffset, glass == GlassDrawn::Yes ? 1u : 0u});
            pass.Reads("drawnDepth", seen.depth,
                       {.magFilter = rhi::Filter::Nearest, .minFilter = rhi::Filter::Nearest});
            seen.hits = pass.Updates("visibility", seen.hits);
            depth = pass.Writes("depths", depth);
        },
        [extent = settings.extent](CommandList& commands) { commands.TraceRays(extent); });
    seen.depth = depth;
}

}  // namespace

void DrawHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
              RasterVisibility& seen, GlassDrawn glass) {
    DrawTriangles(renderer, scene, settings, seen, glass);
    if (scene.features.Has(kTraceCapsules)) TraceCapsules(renderer, scene, settings, seen, glass);
}

}  // namespace raygraph::passes
