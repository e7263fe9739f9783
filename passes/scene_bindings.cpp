#include "passes/scene_bindings.h"

namespace raygraph::passes {

gpu::TraceParameters ParametersFor(const SceneIds& scene, const TraceSettings& settings) {
    return {
        .camera = settings.camera,
        .environment = scene.environment,
        .lights = scene.lightSet,
        .seed = settings.seed,
        .sampleIndex = settings.sampleIndex,
        .maxDepth = settings.maxDepth,
        .rouletteStart = settings.rouletteStart,
    };
}

void BindTracing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters) {
    pass.Miss(RayType::Radiance, "scene/miss.rmiss");
    pass.HitGroup(RayType::Radiance, {.closestHit = "scene/hit.rchit", .anyHit = {}, .intersection = {}});
    pass.Reads("sceneTlas", scene.tlas);
    pass.ReadsByAddress(scene.blases);
    pass.Uniform("parameters", parameters);
}

void BindGeometry(PassBuilder& pass, const SceneIds& scene) {
    pass.Reads("instances", scene.instances);
    pass.Reads("geometries", scene.geometries);
}

void BindMaterials(PassBuilder& pass, const SceneIds& scene) {
    pass.Reads("materials", scene.materials);
    pass.Uses(scene.textures);
}

void BindEnvironment(PassBuilder& pass, const SceneIds& scene) {
    pass.Reads("environmentMap", scene.environmentMap, {.addressV = rhi::AddressMode::ClampToEdge});
}

}  // namespace raygraph::passes
