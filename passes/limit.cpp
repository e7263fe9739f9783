#include "passes/limit.h"

#include "passes/scene_bindings.h"

namespace raygraph::passes {

TextureId Limit(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, LimitKind kind,
                TextureId* rayCounts) {
    const bool isPath = kind != LimitKind::CameraRays, isSoftware = kind == LimitKind::SoftwarePath;
    TextureId result = renderer.CreateTexture("limit", {settings.extent, Format::R32Float});
    if (rayCounts)
        *rayCounts = renderer.CreateTexture("limit.rayCounts", {settings.extent, Format::R32Float});
    renderer.AddPass(
        isSoftware ? "LimitPathSoftware"
        : isPath   ? "LimitPath"
                   : "Limit",
        isSoftware ? PassKind::Compute : PassKind::RayTracing,
        [&](PassBuilder& pass) {
            if (isSoftware)
                pass.Compute(rayCounts ? "bench/limit_path_software_counted.comp"
                                       : "bench/limit_path_software.comp");
            else if (isPath)
                pass.RayGen(rayCounts ? "bench/limit_path_counted.rgen" : "bench/limit_path.rgen");
            else
                pass.RayGen(rayCounts ? "bench/limit_counted.rgen" : "bench/limit.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            if (isSoftware) {
                SpecializeFeatures(pass, {});
                BindSoftwareTracing(pass, scene, ParametersFor(scene, settings));
                // the text of alpha tests reads it, but never runs
                pass.Reads("geometries", scene.geometries);
                BindMaterials(pass, scene);
            } else {
                BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::Off);
            }
            if (isPath) BindInstances(pass, scene);
            result = pass.Writes("result", result);
            if (rayCounts) *rayCounts = pass.Writes("rayCounts", *rayCounts);
        },
        [extent = settings.extent, isSoftware](CommandList& commands) {
            isSoftware ? commands.DispatchOver(extent) : commands.TraceRays(extent);
        });
    return result;
}

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
