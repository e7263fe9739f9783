// RealTime: a picture with little noise from one sample a pixel and frame, for cameras and scenes that move.
//
//   TextureId sample = Trace(renderer, scene, settings).radiance;
//   renderer.Present(Tonemap(renderer, RealTime(renderer, scene, settings, sample, history)));
//
// docs/real-time.md describes the method and its measured errors. Threads: that of the Renderer.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/api.h"
#include "passes/accumulate.h"
#include "passes/trace.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// The state of one picture between frames. `name` keys its persistent resources. It advances when a frame
// that shows the picture is submitted. Camera, extent and transforms of instances are compared by RealTime:
// other changes are told by Limit.
class RAYGRAPH_API RealTimeHistory {
  public:
    explicit RealTimeHistory(std::string name) : m_name(std::move(name)) {}

    // In the next frame, earlier samples of a surface count as no more than so many, and so do earlier
    // pictures. 0 forgets them.
    void Limit(uint32_t samples);
    // The frames since the picture began, or since the camera, the extent or anything else last changed.
    uint32_t StillFrames() const { return m_stillFrames; }
    // Counts these from 0 again.
    void Interrupt() { m_stillFrames = 0; }
    const std::string& Name() const { return m_name; }
    // The name of a persistent texture. Each is there twice: what a frame reads, and what it writes.
    std::string NameOf(std::string_view part, bool isNext) const {
        return m_name + "." + std::string(part) + (isNext == m_isOdd ? ".0" : ".1");
    }

  private:
    friend class RealTimeFrame;
    struct Frame {
        Extent2D extent;
        gpu::CameraRecord camera;  // relative to that frame's origin of the scene
        glm::dvec3 eye;            // in world space
    };
    std::string m_name;
    bool m_isOdd = false;
    std::optional<Frame> m_before;
    std::optional<uint32_t> m_limit;  // of the next frame; empty: nothing but the camera has changed
    uint32_t m_stillFrames = 0;
};

struct RealTimeSettings {
    uint32_t mostSamples = 32;      // of a surface that count
    uint32_t mostFramesMoving = 8;  // pictures that count where something moves
    uint32_t mostFramesStill = 64;
    uint32_t filterLevels = 5;  // the filter's radius is 2^levels - 1 pixels
};

// Returns the radiance without most of its noise, rgba16f, alpha being the number of pictures that count.
// `sample` is Trace's for these settings; of several, the first counts. The sample is divided by the albedo,
// averaged with earlier ones of the same surface, filtered by an edge-avoiding filter that the variance
// guides, multiplied by the albedo, and averaged with earlier pictures. Schied et al. 2017, "Spatiotemporal
// Variance-Guided Filtering: Real-Time Reconstruction for Path-Traced Global Illumination"; unlike there, the
// mean that goes on is not filtered, so that the mean of a picture that stands still is unbiased.
[[nodiscard]] RAYGRAPH_API TextureId RealTime(Renderer& renderer, const SceneIds& scene,
                                              const TraceSettings& settings, TextureId sample,
                                              RealTimeHistory& history,
                                              const RealTimeSettings& realTime = {});

// The picture of the last frame that showed it, which must have had this extent.
[[nodiscard]] RAYGRAPH_API TextureId LastRealTime(Renderer& renderer, const RealTimeHistory& history,
                                                  Extent2D extent);

// Blends `picture`, of any format, with the mean of `samples`, which have squares, by the inverse of their
// squared errors in blocks of 8 x 8 pixels: that of the mean follows from its variance, and what the variance
// does not explain of the difference is the picture's. Pixels with less than four samples show `picture`.
[[nodiscard]] RAYGRAPH_API TextureId HandOver(Renderer& renderer, TextureId picture,
                                              const AccumulatedIds& samples,
                                              const Accumulation::Progress& progress);

// Releases the memory; between frames.
RAYGRAPH_API void Release(Renderer& renderer, RealTimeHistory& history);

// --- The steps of RealTime, each for itself ---
// Textures have the picture's extent. They are rgba16f, which halves the memory and the time of 32 bits: what
// is above 65504 counts as that. A step writes to `into` where that is valid.

// The surfaces on Trace's camera rays, for the same settings, or those that smooth metal and clear glass show
// there.
struct SurfaceIds {
    // w: 1 where light looks alike from all sides, down to 0 for a mirror; 1 where nothing was hit
    TextureId albedo;
    TextureId surfaces;  // rg32ui, as in shaders/real_time/surface.glsl
    // xy: pixels to where the surface was in the frame before, or its picture in a mirror; z: its depth there
    // over that here; w: 0 if it had no place
    TextureId motion;
};
// The state of the scene in the frame before, for TraceSurfaces.
struct SceneBefore {
    gpu::CameraRecord camera;  // relative to its origin of the scene
    BufferId instances;        // contents of SceneIds::instances
    BufferId deformedStreams;  // contents of SceneIds::deformedStreams; invalid if there are none
};
// BLEND surfaces are hit where their opacity is above a half. `surfaces`, where valid, is what the surfaces
// are written to.
[[nodiscard]] RAYGRAPH_API SurfaceIds TraceSurfaces(Renderer& renderer, const SceneIds& scene,
                                                    const TraceSettings& settings, const SceneBefore& before,
                                                    TextureId surfaces = {});

struct MovingMeanIds {
    TextureId mean;       // radiance over albedo; w: number of samples
    TextureId deviation;  // r16f, root of the variance of the samples' luminance
    TextureId surfaces;   // those of SurfaceIds
};
struct MovingMeanSettings {
    gpu::CameraRecord cameraBefore{};
    uint32_t mostBefore = 0;  // samples that count of those before
    uint32_t most = 32;
    uint32_t frame = 0;  // another number in each frame, for random rounding
};
// Adds a sample to the means of the frame before.
[[nodiscard]] RAYGRAPH_API MovingMeanIds AccumulateMoving(Renderer& renderer, TextureId sample,
                                                          const SurfaceIds& seen, const MovingMeanIds& before,
                                                          const MovingMeanSettings& settings,
                                                          const MovingMeanIds& into = {});

// Returns the mean; w: the root of the variance of its luminance, as far as it is to be filtered: more of it
// where there are few samples, by a factor of 1 + 6 / samples, down to a tenth for mirrors, and all of a
// firefly.
[[nodiscard]] RAYGRAPH_API TextureId EstimateVariance(Renderer& renderer, const MovingMeanIds& mean,
                                                      TextureId albedo, TextureId into = {});

// Returns `guided`, the result of EstimateVariance or of a finer level, filtered by 3 x 3 taps: `step` is
// from one to the next (pixels), and turned by 90 degrees from one row of them to the next.
[[nodiscard]] RAYGRAPH_API TextureId FilterLevel(Renderer& renderer, TextureId guided, TextureId surfaces,
                                                 const gpu::CameraRecord& camera, glm::ivec2 step,
                                                 TextureId into = {});

struct ResolveSettings {
    uint32_t mostBefore = 0;  // pictures that count of those before
    uint32_t mostMoving = 8, mostStill = 64;
    bool hasChanged = false;  // something else than the camera has
    bool isStill = false;     // neither the camera nor anything else has changed
    uint32_t frame = 0;       // as in MovingMeanSettings
};
// Multiplies by the albedo and averages with `pictureBefore`; w: the number of pictures that count. What
// stands still, as the surface of the frame before, is averaged as it is; else the earlier picture is clamped
// to the colors of the neighborhood (Karis 2014, "High-Quality Temporal Supersampling").
[[nodiscard]] RAYGRAPH_API TextureId ResolveMoving(Renderer& renderer, TextureId filtered,
                                                   const SurfaceIds& seen, TextureId mean,
                                                   TextureId surfacesBefore, TextureId pictureBefore,
                                                   const ResolveSettings& settings, TextureId into = {});

}  // namespace raygraph::passes
