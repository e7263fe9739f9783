#include "passes/backdrop.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace raygraph::passes {

namespace {

constexpr double kTexelsPerDeviation = 2.0;  // of the blurred map; between them it is interpolated
constexpr uint32_t kLeastColumns = 16;

// Texels are means of the map over their solid angle.
TextureId ReduceMap(Renderer& renderer, TextureId map, Extent2D extent) {
    TextureId reduced = renderer.CreateTexture("reducedMap", {extent, Format::Rgba32Float});
    renderer.AddPass(
        "ReduceMap", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/reduce_map.comp");
            pass.Reads("map", map, rhi::SamplerDesc{});
            reduced = pass.Writes("reduced", reduced);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return reduced;
}

}  // namespace

TextureId BlurredEnvironment::Declare(Renderer& renderer, const SceneIds& scene, float degrees) {
    if (scene.environment.hasMap == 0u) return scene.environmentMap;
    const float deviation = glm::radians(degrees);
    const Extent2D map = renderer.Desc(scene.environmentMap).extent;
    const double columns = std::ceil(2.0 * std::numbers::pi * kTexelsPerDeviation / double{deviation});
    const uint32_t width = std::min(std::max(static_cast<uint32_t>(columns), kLeastColumns), map.width);
    const Extent2D extent{width, std::clamp(width / 2, 1u, map.height)};
    TextureId blurred = renderer.Persist(m_name, {extent, Format::Rgba32Float});
    if (!renderer.IsFresh(blurred) && m_version == scene.environmentVersion && m_degrees == degrees)
        return blurred;
    const TextureId reduced = ReduceMap(renderer, scene.environmentMap, extent);
    renderer.AddPass(
        "BlurMap", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/blur_map.comp");
            pass.Reads("map", reduced, rhi::SamplerDesc{});
            blurred = pass.Writes("blurred", blurred);
            pass.Constants(deviation);
        },
        [this, extent, degrees, version = scene.environmentVersion](CommandList& commands) {
            commands.DispatchOver(extent);
            commands.OnSubmitted([this, degrees, version] {
                m_version = version;
                m_degrees = degrees;
            });
        });
    return blurred;
}

Backdrop DeclareBackdrop(Renderer& renderer, const SceneIds& scene, const BackdropSettings& settings,
                         BlurredEnvironment& blurred, const gpu::CameraRecord& camera, Extent2D picture,
                         const Region& part) {
    const bool isBlurred = !settings.color && settings.blurDegrees > 0.0f;
    return {.settings = settings,
            .map = isBlurred ? blurred.Declare(renderer, scene, settings.blurDegrees) : scene.environmentMap,
            .environment = scene.environment,
            .camera = camera,
            .picture = picture,
            .part = part};
}

}  // namespace raygraph::passes
