#include "passes/recursion.h"

#include "passes/scene_bindings.h"

namespace raygraph::passes {

bool CanRecurse(const rhi::Device& device) {
    return device.Info().maxRayRecursionDepth >= kLambertRecursion;
}

TextureId LambertPath(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                      PathForm form) {
    TextureId radiance = renderer.CreateTexture("lambertPath", {settings.extent, Format::Rgba32Float});
    const bool isLoop = form == PathForm::Loop;
    renderer.AddPass(
        isLoop ? "LambertLoop" : "LambertRecursive", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen(isLoop ? "bench/lambert_loop.rgen" : "bench/lambert_recursive.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            SpecializeFeatures(pass, scene.features & FeaturesOfKind(TraceFeatureKind::Textures));
            BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::Off);
            if (!isLoop) {
                pass.Miss(RayType::Radiance, "bench/lambert_recursive.rmiss");
                pass.HitGroup(
                    RayType::Radiance,
                    {.closestHit = "bench/lambert_recursive.rchit", .anyHit = {}, .intersection = {}});
                pass.MaxRecursion(kLambertRecursion);
            }
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            radiance = pass.Writes("radiance", radiance);
        },
        [extent = settings.extent](CommandList& commands) { commands.TraceRays(extent); });
    return radiance;
}

}  // namespace raygraph::passes
