#include "passes/limit.h"

#include <string>

#include "passes/scene_bindings.h"

namespace raygraph::passes {

namespace {

TextureId LimitInHit(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings) {
    TextureId result = renderer.CreateTexture("limit", {settings.extent, Format::R32Float});
    renderer.AddPass(
        "LimitInHit", PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("bench/limit_in_hit.rgen");
            pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
            BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::Off);
            pass.Miss(RayType::Radiance, "bench/limit_in_hit.rmiss");
            pass.HitGroup(RayType::Radiance,
                          {.closestHit = "bench/limit_in_hit.rchit", .anyHit = {}, .intersection = {}});
            BindInstances(pass, scene);
            result = pass.Writes("result", result);
        },
        [extent = settings.extent](CommandList& commands) { commands.TraceRays(extent); });
    return result;
}

TextureId LimitByBounce(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings) {
    constexpr uint32_t kBounces = 4;
    struct Constants {
        uint32_t size[2];
        uint32_t bounce;
    };
    const uint32_t pixels = settings.extent.width * settings.extent.height;
    TextureId result = renderer.CreateTexture("limit", {settings.extent, Format::R32Float});
    BufferId paths = renderer.CreateBuffer("limitPaths", {.size = uint64_t{pixels} * 64});
    BufferId counts = renderer.CreateBuffer("limitCounts", {.size = (kBounces + 2) * sizeof(uint32_t)});
    renderer.AddPass(
        "LimitCounts", PassKind::Transfer, [&](PassBuilder& pass) { counts = pass.CopiesTo(counts); },
        [counts](CommandList& commands, const PassResources& resources) {
            commands.Fill(resources.Buffer(counts), 0);
        });
    for (uint32_t bounce = 0; bounce <= kBounces; ++bounce)
        renderer.AddPass(
            "LimitBounce" + std::to_string(bounce), PassKind::RayTracing,
            [&](PassBuilder& pass) {
                pass.RayGen("bench/limit_by_bounce.rgen");
                pass.Specialize("kSamplerKind", static_cast<uint32_t>(settings.sampler));
                BindTracing(pass, scene, ParametersFor(scene, settings), AlphaTest::Off);
                BindInstances(pass, scene);
                pass.Constants(Constants{{settings.extent.width, settings.extent.height}, bounce});
                counts = pass.Updates("counts", counts);
                paths = bounce == 0 ? pass.Writes("paths", paths) : pass.Updates("paths", paths);
                result = bounce == 0 ? pass.Writes("result", result) : pass.Updates("result", result);
            },
            [extent = Extent2D{pixels, 1}](CommandList& commands) { commands.TraceRays(extent); });
    return result;
}

}  // namespace

TextureId Limit(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings, LimitKind kind,
                TextureId* rayCounts) {
    if (kind == LimitKind::PathInHit) return LimitInHit(renderer, scene, settings);
    if (kind == LimitKind::PathByBounce) return LimitByBounce(renderer, scene, settings);
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
