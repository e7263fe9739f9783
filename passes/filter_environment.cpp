#include "passes/filter_environment.h"

#include "passes/scene_bindings.h"
#include "shaders/shared/light_records.h"

namespace raygraph::passes {

namespace {

constexpr Extent2D kExtent{gpu::kFilteredWidth, gpu::kFilteredHeight* gpu::kFilteredLevels};

}  // namespace

TextureId FilterEnvironment(Renderer& renderer, const SceneIds& scene, FilteredEnvironment& state) {
    if (scene.environment.hasMap == 0u) return scene.environmentMap;
    TextureId filtered = renderer.Persist(state.m_name, {kExtent, Format::Rgba32Float});
    if (!renderer.IsFresh(filtered) && state.m_version == scene.environmentVersion) return filtered;
    gpu::TraceParameters parameters = ParametersFor(scene, {});
    parameters.environment.radiance = glm::vec3(1.0f);
    parameters.environment.rotation = parameters.lights.environmentRotation = 0.0f;
    renderer.AddPass(
        "FilterEnvironment", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("raster/filter_environment.comp");
            pass.Uniform("parameters", parameters);
            BindEnvironment(pass, scene);
            pass.Reads("environmentTable", scene.environmentTable);
            filtered = pass.Writes("filtered", filtered);
        },
        [&state, version = scene.environmentVersion](CommandList& commands) {
            commands.DispatchOver(kExtent);
            commands.OnSubmitted([&state, version] { state.m_version = version; });
        });
    return filtered;
}

}  // namespace raygraph::passes
