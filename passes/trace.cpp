#include "passes/trace.h"

#include "passes/scene_bindings.h"

namespace raygraph::passes {

TextureId Trace(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                TextureId* rayCounts) {
    TextureId radiance = renderer.CreateTexture("radiance", {settings.extent, Format::Rgba32Float});
    if (rayCounts) *rayCounts = renderer.CreateTexture("rayCounts", {settings.extent, Format::R32Float});
    renderer.AddPass(
        "Trace", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen(rayCounts ? "pathtrace/pathtrace_counted.rgen" : "pathtrace/pathtrace.rgen");
            SpecializeTrace(pass, scene, settings);
            BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::On);
            BindShadowRays(pass, scene);
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            BindEnvironment(pass, scene);
            BindLights(pass, scene);
            pass.Reads("energyTables", scene.energyTables);
            radiance = pass.Writes("radiance", radiance);
            if (rayCounts) *rayCounts = pass.Writes("rayCounts", *rayCounts);
        },
        [extent = settings.extent](CommandList& commands) { commands.TraceRays(extent); });
    return radiance;
}

PrimaryHitIds PrimaryHits(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                          FilmPosition film) {
    PrimaryHitIds hits{
        .albedo = renderer.CreateTexture("albedo", {settings.extent, Format::Rgba32Float}),
        .normal = renderer.CreateTexture("normal", {settings.extent, Format::Rgba32Float}),
        .position = renderer.CreateTexture("position", {settings.extent, Format::Rgba32Float}),
        .ids = renderer.CreateTexture("ids", {settings.extent, Format::Rgba32Uint}),
    };
    renderer.AddPass(
        "PrimaryHits", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("pathtrace/primary_hits.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::On);
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            pass.Constants<uint32_t>(film == FilmPosition::Jittered ? 1u : 0u);
            hits.albedo = pass.Writes("albedo", hits.albedo);
            hits.normal = pass.Writes("normal", hits.normal);
            hits.position = pass.Writes("position", hits.position);
            hits.ids = pass.Writes("ids", hits.ids);
        },
        [extent = settings.extent](CommandList& commands) { commands.TraceRays(extent); });
    return hits;
}

}  // namespace raygraph::passes
