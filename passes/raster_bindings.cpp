#include "passes/raster_bindings.h"

#include "passes/scene_bindings.h"

namespace raygraph::passes {

namespace {

// Push constants of shaders/raster/pixel.glsl.
struct PixelConstants {
    glm::vec2 filmOffset;
    uint32_t punctualLights;
    uint32_t view;
};

}  // namespace

void BindPixels(PassBuilder& pass, const SceneIds& scene, const TraceSettings& settings,
                const RasterVisibility& seen, uint32_t view) {
    pass.Uniform("parameters", RasterParameters(scene, settings));
    pass.Reads("visibility", seen.hits);
    pass.Constants(PixelConstants{seen.filmOffset, scene.punctualLights, view});
    BindGeometry(pass, scene);
    BindMaterials(pass, scene);
}

void BindDrawing(PassBuilder& pass, const SceneIds& scene, const gpu::TraceParameters& parameters,
                 const DrawList& list, bool isTested, SamplerKind sampler) {
    pass.Uniform("parameters", parameters);
    pass.Reads("instances", scene.instances);
    pass.Reads("visiblePlacements", list.visiblePlacements);
    pass.ReadsArguments(list.commands);
    if (!isTested) return;
    pass.Reads("geometries", scene.geometries);
    BindMaterials(pass, scene);
    pass.Specialize("kSamplerKind", static_cast<uint32_t>(sampler));
}

}  // namespace raygraph::passes
