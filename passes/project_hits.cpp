#include "passes/project_hits.h"

#include "passes/add_compute.h"
#include "passes/raster_bindings.h"
#include "passes/scene_bindings.h"

namespace raygraph::passes {

TextureId TraceHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, TextureId hits,
                    glm::vec2 filmOffset) {
    renderer.AddPass(
        "TraceVisibility", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("raster/trace_visibility.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            BindTracing(pass, scene, RasterParameters(scene, settings), AlphaTest::On);
            if (scene.features.Has(kTraceAnyHit | kTraceCapsules)) {
                BindGeometry(pass, scene);
                BindMaterials(pass, scene);
            }
            pass.Constants(filmOffset);
            hits = pass.Writes("visibility", hits);
        },
        [extent = RegionOf(settings).Extent()](CommandList& commands) { commands.TraceRays(extent); });
    return hits;
}

TextureId ProjectHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                      TextureId hits, const gpu::CameraRecord& seenBy) {
    TextureId places = renderer.CreateTexture("places", {RegionOf(settings).Extent(), Format::Rgba32Float});
    AddCompute(renderer, "ProjectHits", "raster/project_hits.comp", RegionOf(settings).Extent(),
               [&](PassBuilder& pass) {
                   SpecializeFeatures(pass, scene.features & kTraceCapsules);
                   pass.Uniform("parameters", RasterParameters(scene, settings));
                   pass.Uniform("seenBy", seenBy);
                   BindInstances(pass, scene);
                   pass.ReadsByAddress(scene.blases);
                   pass.Reads("visibility", hits);
                   places = pass.Writes("places", places);
               });
    return places;
}

}  // namespace raygraph::passes
