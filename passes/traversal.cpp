#include "passes/traversal.h"

namespace raygraph::passes {

BufferId TraceBuffer(Renderer& renderer, const DriverScene::Ids& scene, BufferId rays, uint32_t count,
                     RayQuestion question) {
    BufferId hits = renderer.CreateBuffer("benchHits", {.size = count * sizeof(gpu::WideHit)});
    const bool isAny = question == RayQuestion::Any;
    renderer.AddPass(
        isAny ? "DriverAny" : "DriverNearest", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen(isAny ? "bench/trace_any.rgen" : "bench/trace_rays.rgen");
            if (isAny) {
                pass.Miss(RayType::Shadow, "bench/trace_any.rmiss");
                pass.HitGroup(RayType::Shadow, {});
            } else {
                pass.Miss(RayType::Radiance, "scene/miss.rmiss");
                pass.HitGroup(RayType::Radiance,
                              {.closestHit = "scene/hit.rchit", .anyHit = {}, .intersection = {}});
            }
            pass.Reads("sceneTlas", scene.tlas);
            pass.ReadsByAddress(scene.blases);
            pass.Reads("rays", rays);
            hits = pass.Writes("hits", hits);
            pass.KeepAlive();
        },
        [count](CommandList& commands) {
            commands.TraceRays({count, 1});
        });
    return hits;
}

BufferId TraverseBuffer(Renderer& renderer, const WideDeviceScene::Ids& scene, BufferId rays, uint32_t count,
                        const TraverseSettings& settings) {
    const bool isAny = settings.question == RayQuestion::Any;
    BufferId hits = renderer.CreateBuffer("benchHits", {.size = count * sizeof(gpu::WideHit)});
    const uint64_t countBytes = (settings.counts ? count : 1) * sizeof(gpu::WideCounts);
    BufferId counts = renderer.CreateBuffer("benchCounts", {.size = countBytes});
    renderer.AddPass(
        isAny ? "WideAny" : "WideNearest", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("bench/traverse.comp");
            pass.Specialize("kIsAny", isAny ? 1 : 0);
            pass.Specialize("kCounts", settings.counts ? 1 : 0);
            pass.Specialize("kHasOneLevel", settings.hasOneLevel ? 1 : 0);
            pass.Reads("wideNodes", scene.nodes);
            pass.Reads("wideTriangles", scene.triangles);
            pass.Reads("wideInstances", scene.instances);
            pass.Reads("rays", rays);
            hits = pass.Writes("hits", hits);
            counts = pass.Writes("counts", counts);
            pass.Constants(gpu::BenchConstants{.rayCount = count});
            pass.KeepAlive();
        },
        [count](CommandList& commands) {
            commands.DispatchOver({count, 1});
        });
    if (settings.counts) *settings.counts = counts;
    return hits;
}

}  // namespace raygraph::passes
