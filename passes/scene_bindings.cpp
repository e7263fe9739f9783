#include "passes/scene_bindings.h"

namespace raygraph::passes {

gpu::TraceParameters ParametersFor(const SceneIds& scene, const TraceSettings& settings) {
    return {
        .camera = settings.camera,
        .environment = scene.environment,
        .seed = settings.seed,
        .sampleIndex = settings.sampleIndex,
        .maxDepth = settings.maxDepth,
        .rouletteStart = settings.rouletteStart,
    };
}

void BindScene(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters) {
    pass.Miss(RayType::Radiance, "scene/miss.rmiss");
    pass.HitGroup(RayType::Radiance, {.closestHit = "scene/hit.rchit"});
    pass.Reads("sceneTlas", scene.tlas);
    pass.ReadsByAddress(scene.blases);
    pass.Reads("instances", scene.instances);
    pass.Reads("geometries", scene.geometries);
    pass.Reads("materials", scene.materials);
    pass.ReadsByAddress(scene.vertexData);
    pass.Uses(scene.textures);
    pass.Reads("environmentMap", scene.environmentMap, {.addressV = rhi::AddressMode::ClampToEdge});
    pass.Uniform("parameters", parameters);
}

}  // namespace raygraph::passes
