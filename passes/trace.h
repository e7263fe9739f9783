// Trace: one path-traced sample per pixel of the scene's radiance.
#pragma once

#include <cstdint>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/sampler_kinds.h"

namespace raygraph::passes {

inline constexpr uint32_t kNoDepthLimit = 0xFFFFFFFFu;

struct TraceSettings {
    Extent2D extent;  // pixels
    gpu::CameraRecord camera{};
    SamplerKind sampler = SamplerKind::Sobol;
    uint32_t seed = 0;
    uint32_t sampleIndex = 0;
    // A limit on bounces darkens the picture (a named bias): off unless asked for.
    uint32_t maxDepth = kNoDepthLimit;
    // First bounce that Russian roulette on the throughput may end. In the Cornell box 1, 2 and 3 are equally
    // efficient within 2 %; from 2 on, the first bounce is never thinned, which matters on dark surfaces
    // under a sky.
    uint32_t rouletteStart = 2;
};

// Returns linear radiance, rgba32f, alpha 1 where the camera ray hit a surface and 0 where it escaped. A
// function of (scene, settings) alone: the same device gives the same bits. Surfaces are two-sided Lambert
// reflectors of their base colour and emit on both sides. `rayCounts`, if given, receives a texture (r32f)
// with the rays traced in each pixel.
[[nodiscard]] TextureId Trace(Renderer& renderer, const SceneIds& scene, const TraceSettings& settings,
                              TextureId* rayCounts = nullptr);

// The camera's first hits, without light: what AOVs and the diagnostic views show. All from one ray per
// pixel.
struct PrimaryHitIds {
    TextureId albedo;    // rgba32f, base colour; the environment's radiance is not in it: 0 on a miss
    TextureId normal;    // rgba32f, shading normal in world space, w = 0; 0 on a miss
    TextureId position;  // rgba32f, hit position in world space, w = depth along the camera's forward; inf on
                         // a miss
    TextureId
        ids;  // rgba32ui: instance, material, primitive (in the file's order), geometry; 0xFFFFFFFF on a miss
};

enum class FilmPosition : uint8_t {
    Center,    // through the pixel's centre: ids and depth, the same in every sample
    Jittered,  // where Trace's ray of the same sample goes: for averages
};

[[nodiscard]] PrimaryHitIds PrimaryHits(Renderer& renderer, const SceneIds& scene,
                                        const TraceSettings& settings, FilmPosition film);

}  // namespace raygraph::passes
