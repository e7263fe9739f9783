#include "passes/limit.h"

#include "passes/scene_bindings.h"

namespace raygraph::passes {

TextureId Limit(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, LimitKind kind,
                TextureId* rayCounts) {
    const bool isPath = kind == LimitKind::Path;
    TextureId result = renderer.CreateTexture("limit", {settings.extent, Format::R32Float});
    if (rayCounts)
        *rayCounts = renderer.CreateTexture("limit.rayCounts", {settings.extent, Format::R32Float});
    renderer.AddPass(
        isPath ? "LimitPath" : "Limit", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            if (isPath)
                pass.RayGen(rayCounts ? "bench/limit_path_counted.rgen" : "bench/limit_path.rgen");
            else
                pass.RayGen(rayCounts ? "bench/limit_counted.rgen" : "bench/limit.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::Off);
            if (isPath) BindInstances(pass, scene);
            result = pass.Writes("result", result);
            if (rayCounts) *rayCounts = pass.Writes("rayCounts", *rayCounts);
        },
        [extent = settings.extent](CommandList& commands) { commands.TraceRays(extent); });
    return result;
}

}  // namespace raygraph::passes
