// The raster view: the scene drawn, with the instances, materials and BSDFs of the path tracer; the picture
// behind glass and the occlusion of the environment, which it needs.
//
//   RasterVisibility seen = DrawVisibility(renderer, scene, settings, FilmPosition::Center);
//   renderer.Present(Tonemap(renderer, RasterShade(renderer, scene, settings, seen, environment)));
//
// Threads: that of the Renderer.
#pragma once

#include <glm/glm.hpp>

#include "base/api.h"
#include "passes/filter_environment.h"
#include "passes/trace.h"

namespace raygraph::passes {

// Chooses the method that finds the pixels of a triangle.
enum class Rasterizer : uint8_t {
    Compute,  // compute shaders, at the positions where camera rays would be
    Device,   // the device's own rasterizer
};

// Holds the nearest surface of each pixel.
struct RasterVisibility {
    TextureId hits;              // rgba32ui, see shaders/raster/visibility.glsl
    TextureId depth;             // reversed, see shaders/raster/projection.glsl; rays leave none
    BufferId drawCommands;       // gpu::DrawCommand[], as drawn, after culling, for statistics
    BufferId visiblePlacements;  // see shaders/shared/draw_records.h
    glm::vec2 filmOffset{0.5f};  // the drawn position in each pixel
    Rasterizer rasterizer = Rasterizer::Compute;
};

// Draws all instances that may be in the picture: placements outside of it are culled on the device, and all
// triangles of the others are drawn by the same few passes, whatever their number. Back faces are culled as
// for rays; MASK and BLEND decide as they do for the camera ray of the same pixel and sample (settings.seed,
// sampleIndex), so that a mean over samples is blended, in any order. FilmPosition::Jittered draws one
// position for all pixels of a sample: a mean over samples is smooth at edges. The camera has no lens here,
// and sees nothing nearer than its zNear. Where surfaces coincide, either may be visible. Rasterizer::Compute
// falls back to Device where the device lacks shaderBufferInt64Atomics, the scene has 2^32 triangles placed
// or more, or 8 bytes a pixel are more than the device lets a shader bind (128 MiB on some: 4096 x 4096
// pixels). Throws Error{Usage} for Device without drawIndirectFirstInstance.
[[nodiscard]] RAYGRAPH_API RasterVisibility DrawVisibility(Renderer& renderer, const SceneIds& scene,
                                                           const TraceSettings& settings, FilmPosition film,
                                                           Rasterizer rasterizer = Rasterizer::Compute);

// Returns whether the device supports it; Error{Usage} as above.
[[nodiscard]] RAYGRAPH_API bool CanDrawVisibility(const Renderer& renderer, const SceneIds& scene,
                                                  Extent2D extent);

// Finds the visibility by rays through the same position of each pixel: for views of what the path tracer
// sees.
[[nodiscard]] RAYGRAPH_API RasterVisibility TraceVisibility(Renderer& renderer, const SceneIds& scene,
                                                            const TraceSettings& settings, FilmPosition film);

// Draws the visibility, or finds it by rays on a device that cannot draw it.
[[nodiscard]] RAYGRAPH_API RasterVisibility AnyVisibility(Renderer& renderer, const SceneIds& scene,
                                                          const TraceSettings& settings, FilmPosition film);

// Returns the outputs of PrimaryHits, of what was drawn. `settings` are those of DrawVisibility.
[[nodiscard]] RAYGRAPH_API PrimaryHitIds RasterHits(Renderer& renderer, const SceneIds& scene,
                                                    const TraceSettings& settings,
                                                    const RasterVisibility& seen);

// The method that finds shadows.
//   Off:  there are none: light passes through whatever is in its way
//   Maps: passes/shadow_maps.h: of punctual lights; emitting triangles cast no shadow
//   Rays: one ray a light, as the path tracer does; builds the acceleration structures that rays need
#define RAYGRAPH_RASTER_SHADOWS(X, Of)                                          \
    X(Of, Off, 0, "off", "")                                                    \
    X(Of, Maps, 1, "maps", "of point lights, spots and directional ones alone") \
    X(Of, Rays, 2, "rays", "")
RAYGRAPH_CHOICE(RasterShadows, RAYGRAPH_RASTER_SHADOWS)

struct RasterSettings {
    // Rays are exact, and their cost for a pixel hardly depends on the size of the scene. Measured on a CPU
    // device (lavapipe), three lights: 135 ms against 78 ms and 41 ms for the maps at 480 x 300; one light
    // and 65,536 instances: 93 ms against 61 ms and 1.6 s for the maps at 320 x 180.
    RasterShadows shadows = RasterShadows::Rays;
    uint32_t shadowAtlasSize = 4096;  // texels a side
    bool hasOcclusion = true;         // occlusion of the environment, in screen space (Occlusion)
    // Glass shows what is behind it (DrawBehindGlass), else the environment.
    bool hasTransmission = true;
    // Textures are read at the mip level that fits a pixel's footprint (shaders/raster/pixel_footprint.glsl),
    // else at level 0. Only where SceneIds::features has kTraceTextureLod.
    bool hasTextureLevels = true;

    bool operator==(const RasterSettings&) const = default;
};

// Returns linear radiance, rgba32f, alpha as in Trace: emission, direct light by settings.scattering, and the
// environment behind the surfaces. Punctual lights are summed; of the emitting triangles one is sampled by
// the light tree (settings.seed, sampleIndex): its noise falls in a mean over samples, and smooth surfaces do
// not show it. Of the environment, a lobe takes its mean over the lobe (`environment`, see
// shaders/raster/environment_lobes.glsl). Unlike Trace it lacks light that is scattered more than once, and
// the media around the camera. `seen` is from DrawVisibility; from TraceVisibility, too, but then without
// occlusion and transmission, which need its depth.
[[nodiscard]] RAYGRAPH_API TextureId RasterShade(Renderer& renderer, const SceneIds& scene,
                                                 const TraceSettings& settings, const RasterVisibility& seen,
                                                 FilteredEnvironment& environment,
                                                 const RasterSettings& raster = {});

// RasterShade of AnyVisibility, with as much of `raster` as the device can do: no occlusion or transmission
// where it cannot draw, and rays in place of shadow maps where it lacks drawIndirectFirstInstance.
[[nodiscard]] RAYGRAPH_API TextureId AnyRasterShade(Renderer& renderer, const SceneIds& scene,
                                                    const TraceSettings& settings, FilmPosition film,
                                                    FilteredEnvironment& environment,
                                                    const RasterSettings& raster);

// --- The picture behind glass: drawn without the glass, and blurred ---

// Draws `seen` without its transmissive surfaces, from its lists: the nearest surface behind them in each
// pixel.
[[nodiscard]] RAYGRAPH_API RasterVisibility DrawBehindGlass(Renderer& renderer, const SceneIds& scene,
                                                            const TraceSettings& settings,
                                                            const RasterVisibility& seen);

// Makes blurred copies of an rgba32f picture, rgba32f, color multiplied by alpha: the levels of
// shaders/shared/blur_levels.h, level i for footprints of 2^i pixels.
[[nodiscard]] RAYGRAPH_API TextureId BlurLevels(Renderer& renderer, TextureId picture);

// --- Occlusion: the visible part of the environment at each surface, in screen space ---

// Returns, r32f, the share of the directions above each surface, weighted by the cosine, that no surface on
// the screen within 0.4 of the picture's height occludes; 1 without a surface. Hidden surfaces and those
// outside of the picture occlude nothing; visible ones occlude as if they were as deep as they look. A few
// directions for each sample (settings.seed, sampleIndex): the noise falls in a mean over samples. Source and
// formulas: shaders/raster/occlusion.comp. `seen` is from DrawVisibility.
[[nodiscard]] RAYGRAPH_API TextureId Occlusion(Renderer& renderer, const SceneIds& scene,
                                               const TraceSettings& settings, const RasterVisibility& seen);

}  // namespace raygraph::passes
