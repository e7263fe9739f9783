#include "passes/trace.h"

#include <algorithm>

#include "passes/scene_bindings.h"

namespace raygraph::passes {

namespace {

// Paths differ in length, and a GPU's lanes wait for the longest of their group. Where there are more pixels
// than the GPU runs at a time, an invocation takes several, one path after the other: 1.51 ms a sample
// become 1.26 ms on an H200 at 1920x1080. A CPU driver gains nothing by it.
uint32_t PixelsPerInvocation(rhi::DeviceType type, Extent2D extent) {
    constexpr uint32_t kFull = 1u << 18;
    constexpr uint32_t kMost = 8;
    if (type == rhi::DeviceType::Cpu) return 1;
    return std::clamp(extent.width * extent.height / kFull, 1u, kMost);
}

}  // namespace

TextureId Trace(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                TextureId* rayCounts) {
    TextureId radiance = renderer.CreateTexture("radiance", {settings.extent, Format::Rgba32Float});
    if (rayCounts) *rayCounts = renderer.CreateTexture("rayCounts", {settings.extent, Format::R32Float});
    gpu::TraceParameters parameters = ParametersFor(scene, settings);
    parameters.pixelsPerInvocation = PixelsPerInvocation(renderer.Device().Info().type, settings.extent);
    const Extent2D launch{
        settings.extent.width,
        (settings.extent.height + parameters.pixelsPerInvocation - 1) / parameters.pixelsPerInvocation};
    renderer.AddPass(
        "Trace", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen(rayCounts ? "pathtrace/pathtrace_counted.rgen" : "pathtrace/pathtrace.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            BindTracing(pass, scene, parameters);
            BindGeometry(pass, scene);
            BindMaterials(pass, scene);
            BindEnvironment(pass, scene);
            radiance = pass.Writes("radiance", radiance);
            if (rayCounts) *rayCounts = pass.Writes("rayCounts", *rayCounts);
        },
        [launch](CommandList& commands) { commands.TraceRays(launch); });
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
            BindTracing(pass, scene, ParametersFor(scene, settings));
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
