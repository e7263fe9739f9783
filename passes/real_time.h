// RealTime: a picture with little noise from one sample a pixel and frame, for cameras and scenes that move.
//
//   TextureId sample = Trace(renderer, scene, settings).radiance;
//   renderer.Present(Tonemap(renderer, RealTime(renderer, scene, settings, sample, history)));
//
// docs/real-time.md describes the method and its measured errors. Threads: that of the Renderer.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/api.h"
#include "passes/accumulate.h"
#include "passes/trace.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// The state of one real-time picture between frames; it must outlive the frames that declare it. `name` keys
// its persistent resources and is unique on the Renderer. The state advances when a frame that shows the
// picture is submitted. RealTime detects changes of the camera, the lens and the extent by itself; a caller
// reports all others, transforms and poses included, before it declares the next frame.
class RAYGRAPH_API RealTimeHistory {
  public:
    explicit RealTimeHistory(std::string name) : m_name(std::move(name)) {}

    // Reports another scene, or one with other meshes: the next frame starts without history.
    void Forget() { Note(Change::Forget); }
    // Reports other lights, materials, transforms, poses, path settings or another environment. In so many
    // frames, earlier samples count for less where the light differs from theirs.
    static constexpr uint32_t kFramesOfChange = 16;
    void NoteChange() { Note(Change::Light); }
    // Returns the number of frames that have been filtered.
    uint32_t FrameCount() const { return m_frameCount; }
    // Returns the number of frames since the picture began, or since anything last changed.
    uint32_t StillFrames() const { return m_stillFrames; }
    // Counts these from 0 again, as after a change of the camera that no frame has seen yet.
    void Interrupt() { m_stillFrames = 0; }
    const std::string& Name() const { return m_name; }
    // Returns the name of a persistent texture. Each exists twice: one is read by a frame, one written.
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
    enum class Change : uint8_t { None, Light, Forget };
    void Note(Change change) {
        m_change = std::max(m_change, change);
        m_stillFrames = 0;
    }

    std::string m_name;
    bool m_isOdd = false;
    std::optional<Frame> m_before;
    Change m_change = Change::None;  // since the frame before, but for the camera
    uint32_t m_changeFrames = 0;     // for which light is still compared
    uint32_t m_frameCount = 0;
    uint32_t m_stillFrames = 0;
};

struct RealTimeSettings {
    uint32_t mostSamples = 32;      // largest number of samples in a surface's running mean
    uint32_t mostFramesMoving = 8;  // largest number of pictures averaged where something moves
    uint32_t mostFramesStill = 64;  // largest number of pictures averaged where nothing moves
    uint32_t filterLevels = 5;      // passes of the filter; its radius is 2^levels - 1 pixels
};

// Returns the radiance without most of its noise, rgba16f; w: the number of pictures averaged. `sample` is
// Trace's for these settings, with another sampleIndex in each frame; if it has several, the first counts.
// The sample is divided by the albedo, averaged with earlier ones of the same surface, filtered by an
// edge-avoiding filter that the variance guides, multiplied by the albedo, and averaged with earlier
// pictures. Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering: Real-Time Reconstruction for
// Path-Traced Global Illumination"; unlike there, the mean that goes on is not filtered, so that the mean of
// a picture that stands still is unbiased. Throws Error{Usage} if the settings have a region or a list of
// pixels.
[[nodiscard]] RAYGRAPH_API TextureId RealTime(Renderer& renderer, const SceneIds& scene,
                                              const TraceSettings& settings, TextureId sample,
                                              RealTimeHistory& history,
                                              const RealTimeSettings& realTime = {});

// Returns the picture of the last submitted frame, rgba16f. It is undefined (Renderer::IsFresh) before the
// first one, and for another extent than that frame's.
[[nodiscard]] RAYGRAPH_API TextureId LastRealTime(Renderer& renderer, const RealTimeHistory& history,
                                                  Extent2D extent);

// Returns a blend of `picture`, of any format, and the mean of `samples`, rgba32f. `samples` were
// accumulated with sums of squares. In blocks of 8 x 8 pixels, both are weighted by the inverse of their
// squared errors in the green channel: that of the mean follows from its variance, and what the variance
// does not explain of the difference is the picture's. Pixels with less than eight samples show `picture`.
// Throws Error{Usage} if the extents differ.
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
    TextureId albedo;  // w: dullness, 1 for diffuse surfaces and where nothing was hit, down to 0 for mirrors
    TextureId surfaces;  // rg32ui, as in shaders/real_time/surface.glsl
    // xy: motion vector to the frame before (pixels), of the surface or of its image in a mirror; z: its
    // depth there over its depth here; w: 1, or 0 if it was at no place of that picture's plane
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
    TextureId deviation;  // r16f, standard deviation of the samples' luminance
    TextureId surfaces;   // those of SurfaceIds
};
struct MovingMeanSettings {
    gpu::CameraRecord cameraBefore{};
    uint32_t mostBefore = 0;  // limits the weight of the means before, in samples; 0: no history
    uint32_t most = 32;       // limits the weight of the new means, in samples
    uint32_t frame = 0;       // another number in each frame, for random rounding
    TextureId changes;        // of FindChanges; invalid: light has not changed
};
// Compares the light of a sample with that of the means of the frame before. Returns a texel for each block
// of 8 x 8 pixels, rgba32f: sums over the differences in luminance, their squares, and the larger
// luminances.
[[nodiscard]] RAYGRAPH_API TextureId FindChanges(Renderer& renderer, TextureId sample, const SurfaceIds& seen,
                                                 const MovingMeanIds& before);
// Adds a sample to the means of the frame before.
[[nodiscard]] RAYGRAPH_API MovingMeanIds AccumulateMoving(Renderer& renderer, TextureId sample,
                                                          const SurfaceIds& seen, const MovingMeanIds& before,
                                                          const MovingMeanSettings& settings,
                                                          const MovingMeanIds& into = {});

// Returns the mean; w: the standard deviation of its luminance that the filter is to remove. Its square is
// raised by 1 + 6 / samples, since few samples underestimate it, and lowered by up to a factor of .1 for
// mirrors; of a firefly it is three times its luminance.
[[nodiscard]] RAYGRAPH_API TextureId EstimateVariance(Renderer& renderer, const MovingMeanIds& mean,
                                                      TextureId albedo, TextureId into = {});

// Returns `guided`, the result of EstimateVariance or of a finer level, filtered by 3 x 3 taps: `step` is
// from one to the next (pixels), and turned by 90 degrees from one row of them to the next.
[[nodiscard]] RAYGRAPH_API TextureId FilterLevel(Renderer& renderer, TextureId guided, TextureId surfaces,
                                                 const gpu::CameraRecord& camera, glm::ivec2 step,
                                                 TextureId into = {});

struct ResolveSettings {
    uint32_t mostBefore = 0;  // limits the weight of the picture before, in pictures; 0: no history
    uint32_t mostMoving = 8, mostStill = 64;  // as in RealTimeSettings
    bool hasChanged = false;                  // something else than the camera's place has
    bool isStill = false;                     // neither the camera nor anything else has changed
    bool hasLimit = false;                    // no more pictures count than samples of the mean
    uint32_t frame = 0;                       // as in MovingMeanSettings
};
// Multiplies by the albedo and averages with `pictureBefore`; w: the number of pictures that count. What
// stands still, as the surface of the frame before, is averaged as it is; else the earlier picture is clamped
// to the colors of the neighborhood (Karis 2014, "High-Quality Temporal Supersampling").
[[nodiscard]] RAYGRAPH_API TextureId ResolveMoving(Renderer& renderer, TextureId filtered,
                                                   const SurfaceIds& seen, TextureId mean,
                                                   TextureId surfacesBefore, TextureId pictureBefore,
                                                   const ResolveSettings& settings, TextureId into = {});

}  // namespace raygraph::passes
