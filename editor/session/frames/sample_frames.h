// SampleFrames renders samples of one picture on one device, one or more a frame, and returns the
// accumulated result. Also the times of samples within a shutter, and the tiles of groups of lights. For
// editor/session/ alone.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/api.h"
#include "editor/session/file/image_statistics.h"
#include "editor/session/file/render_file.h"
#include "editor/session/frames/adaptive_frames.h"
#include "editor/session/frames/device_scene.h"
#include "editor/session/frames/pass_times.h"
#include "editor/session/frames/second_traces.h"
#include "passes/accumulate.h"
#include "passes/denoise.h"
#include "passes/filter_environment.h"
#include "passes/tonemap.h"
#include "passes/trace.h"
#include "passes/views.h"

namespace raygraph::session {

struct FramePlan {
    View view = View::PathTraced;
    AovSet aovs;                   // additional outputs
    uint32_t firstSample = 0;      // index of the picture's first sample
    uint32_t lightGroupCount = 0;  // rendered separately; 0: none
    bool withVariance = false;     // variance of the radiance
    bool isAdaptive = false;       // see PictureSettings; with variance
    bool withSums = false;         // returns the sums of everything accumulated
    bool isDenoised = false;       // see SessionDesc; with variance, as Aov::Denoising
    passes::Denoiser denoiser = passes::Denoiser::Network;
    uint32_t batchSize = 0;                            // see SessionDesc
    passes::RasterSettings raster;                     // settings of the raster view
    passes::TonemapSettings tonemap;                   // settings of the display picture
    std::optional<passes::BackdropSettings> backdrop;  // shown behind the display picture
    bool hasUnblurred = true;                          // renders depth, ids and motion if asked for
    RetracedBiases retraced{};                         // biases without which samples are traced again
    const RenderFile* continues = nullptr;  // render that is continued; only used by the constructor

    bool NeedsGuides() const { return isDenoised || aovs.Has(Aov::Denoising); }
};

class SampleFrames {
  public:
    // `scene` outlives the object.
    SampleFrames(DeviceScene& scene, const FramePlan& plan);

    // Returns how many samples a frame renders at most, a power of two; 1 if one keeps the device busy.
    uint32_t PreferredBatchSize() const { return m_batchSize; }
    // Submits new samples of the picture, at most PreferredBatchSize, in one frame; waits while as many
    // frames are in flight as the device allows.
    void RenderSamples(SampleRange samples);
    // Is called for an adaptive picture instead: submits samples where they are needed, on the way to
    // `average` samples per pixel, at most `most` more than it has. Then the state of the picture is a
    // function of its average.
    void RenderAdaptive(uint32_t average, uint32_t most);
    // Returns how many continued samples still need their albedo and normals traced, which had no sums,
    // before the first RenderSamples.
    uint32_t SamplesToRestore() const { return m_toRestore; }
    // Submits the surfaces of the next such sample; waits as RenderSamples does.
    void RestoreSample();
    // These return the samples in the picture, continued ones included: those that the device has finished,
    // all submitted ones, and their ranges. For an adaptive picture they are averages per pixel, rounded
    // down.
    uint32_t SamplesDone();
    uint32_t SamplesSubmitted() const { return m_submitted; }
    const SampleRanges& Samples() const { return m_samples; }
    // Starts to estimate the error of the submitted samples, of which there must be some, unless an estimate
    // is pending.
    void MeasureError();
    // Returns the newest estimate that has arrived; 0 for a black picture.
    const std::optional<MeasuredError>& NewestError();
    // Measures the error of all samples, and waits for it.
    MeasuredError MeasureErrorNow();
    // Returns how many finished samples of this object were infinite or NaN, and count as black.
    uint64_t NonFiniteSamples();
    // Waits until the device has finished what was submitted.
    void WaitForSamples();
    Extent2D Size() const;  // returns the size of the picture

    // Submits the readback of what Take* return. More samples may follow.
    void FinishPicture();
    // Returns true after FinishPicture, until the next sample.
    bool HasPicture() const { return m_hasPicture; }
    // Call it after FinishPicture: fills in the picture, its channels and samples, and waits for them. The
    // rest of the render is kept. Without a sample, sums are zero, and there are no means.
    void TakePicture(RenderFile& render) const;
    // Returns the tone-mapped picture with the alpha of plan.tonemap, or the view as PaintView shows it,
    // opaque.
    image::Image8 TakeDisplay() const;
    // Does so for the sums of `sampleCount` samples by several devices.
    image::Image8 DisplayOf(const passes::ExactSums& sums, uint32_t sampleCount);
    // Frees the memory of readbacks; there is no picture until the next FinishPicture.
    void DropPicture();
    // Returns the sums of the radiance alone, with squares; zeros without a sample.
    passes::ExactSums RadianceSums();

    // Returns the number of rays of a path, on average over all paths that were rendered here; none without a
    // path.
    std::optional<double> RaysPerSample();
    // Returns GPU times of all frames of samples.
    const PassTimes& Times();
    bool ShowsLight() const { return passes::ShowsLight(m_plan.view); }
    bool TracesPaths() const { return m_plan.view == View::PathTraced; }

  private:
    // Holds an accumulated picture; FinishPicture sets the readbacks.
    struct Accumulated {
        explicit Accumulated(const char* name) : accumulation(name) {}
        passes::Accumulation accumulation;
        Readback mean;
        passes::SumsReadback sums;
    };
    struct KeptPart {
        size_t index;  // index of the PathPart
        Accumulated sum;
    };
    struct Measurement {
        uint32_t sampleCount = 0;
        Readback mean, variance;
        std::vector<uint32_t> counts;  // samples of each pixel, for adaptive pictures
    };

    void RestoreFrom(const RenderFile& render);
    uint32_t ChooseBatchSize() const;
    // Declares samples of the radiance, by the pipeline of all samples.
    passes::TraceIds DeclareSamples(const SceneIds& ids, const passes::TraceSettings& settings);
    // Adds the samples, and what is computed beside them.
    void DeclareRadiance(const SceneIds& ids, const passes::TraceSettings& settings);
    // Declares a view that shows no light.
    void DeclareValues(const SceneIds& ids, const passes::TraceSettings& settings);
    // Adds surfaces to the means over the samples.
    void DeclareAverages(const SceneIds& ids, const passes::TraceSettings& settings, bool isLast = true);
    void TraceUnblurred();  // depth, ids and motion, in frames of their own
    Readback ProjectAt(double shutterPosition, const gpu::CameraRecord& seenBy);
    // Accumulates samples of Trace, or of their texture.
    void AccumulateTraced(TextureId samples, const passes::TraceSettings& settings,
                          passes::Accumulation& accumulation, bool withVariance = false);
    // Accumulates samples of all pixels; `isLast`: the last of the frame.
    void AccumulateFrame(TextureId samples, uint32_t count, Accumulated& into, bool isLast = true);
    // Declares surfaces and removed light, which have as many samples as all pixels.
    void DeclareUniformSamples(const SceneIds& ids);
    void RenderMissingUniformSamples();
    void RenderListed(uint32_t average);
    // Declares the counts of an adaptive picture, for Resolve.
    std::optional<TextureId> DeclareCounts();
    passes::AccumulatedIds Resolve(const passes::Accumulation& accumulation, Extent2D extent,
                                   bool withVariance, const std::optional<TextureId>& counts);
    // Without counts, all pixels have equally many samples.
    passes::AccumulatedIds ReadBack(Accumulated& from, Extent2D extent,
                                    const std::optional<TextureId>& counts = {}, bool withVariance = false);
    // With a backdrop, the scene is that of the frame.
    TextureId DeclareDisplay(TextureId mean, const SceneIds& scene);
    void TakeMeans(RenderFile& render) const;
    // Stores the sums of the samples so far for the denoiser, if they might be half of all samples.
    void KeepFirstHalf();
    // Restores the last stored sums of at most two thirds of the samples, if there are any.
    void RestoreFirstHalf(passes::Accumulation& into);
    // Declares what the denoiser takes; `firstHalf` has the first samples of the picture.
    passes::DenoiseInputs DeclareDenoiseInputs(const SceneIds& scene, const passes::AccumulatedIds& radiance,
                                               TextureId albedo, TextureId normal,
                                               const passes::Accumulation& firstHalf);
    void ReadBackDenoising(const passes::DenoiseInputs& inputs, uint32_t firstSamples);
    void ZeroMeans(RenderFile& render) const;
    void Take(const Accumulated& from, Texels& mean, passes::ExactSums& sums) const;

    DeviceScene& m_scene;
    Renderer& m_renderer;
    FramePlan m_plan;
    SecondTraces m_secondTraces;
    uint32_t m_batchSize = 1;
    bool m_isKeepingAlbedo, m_isKeepingNormal, m_isKeepingCenter, m_isKeepingMotion;
    bool m_hasPicture = false;
    bool m_wasSharpTraced = false;
    uint32_t m_submitted = 0;     // samples in the picture, continued ones included
    SampleRanges m_samples;       // the ranges of m_submitted
    uint32_t m_lastRestored = 0;  // index of the last sample of the continued render
    uint32_t m_toRestore = 0;     // how many of the continued samples are still to be traced again
    struct PendingSamples {
        rhi::Submission frame;  // adds them
        uint64_t count;         // adaptive pictures: of all pixels together
    };
    std::deque<PendingSamples> m_pending;

    std::unique_ptr<AdaptiveFrames> m_adaptive;  // set for an adaptive picture
    uint32_t m_uniformSamples = 0;               // samples with surfaces

    Accumulated m_radiance{"radiance"};  // or the view's values
    Accumulated m_albedo{"albedo"}, m_normal{"normal"};
    passes::FilteredEnvironment m_filteredEnvironment{"filtered environment"};
    Accumulated m_groups{"lightGroups"};
    std::vector<KeptPart> m_parts;  // never resized: frames refer to its accumulations
    struct FirstSamples {
        uint32_t count = 0;
        passes::SumsReadback sums;
    };
    std::array<FirstSamples, 2> m_firstHalves;  // by age, the older one first
    Readback m_variance, m_denoised, m_display, m_position, m_ids, m_placesAtOpen, m_placesAtClose;
    std::vector<std::pair<Texels DenoisingPlanes::*, Readback>> m_denoising;
    passes::BlurredEnvironment m_blurred{"backdrop"};
    uint32_t m_firstSamples = 0;  // samples of DenoisingPlanes::firstHalf
    struct CountsOfFrame {
        Readback counts;  // TraceCounts
        uint64_t paths;
    };
    std::deque<CountsOfFrame> m_counts;  // until they have arrived
    uint64_t m_nonFiniteSamples = 0, m_rays = 0, m_paths = 0;
    std::optional<Measurement> m_measurement;  // pending until its readback has arrived
    std::optional<MeasuredError> m_error;
    PassTimes m_times;
};

// --- The time of a shutter at which a sample sees the scene ---

// Returns the position from 0, when the shutter opens, to below 1, when it closes. It is the same for all
// pixels of the sample. Each aligned block of 2^k samples has one time in each of 2^k equal parts, at random
// positions within them, so that any number of samples is unbiased, and their mean converges to the integral
// over the shutter.
//
// The positions are the sequence of van der Corput, Owen-scrambled: each bit of the time is flipped by a
// hash of those above it (Owen 1995, "Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences"). The dimensions
// of a pixel each shuffle their sample indices by themselves (shaders/core/rng.glsl), so that none is
// coupled to this one. Threads: any.
RAYGRAPH_API double ShutterPosition(uint32_t sampleIndex, uint32_t seed);

// --- Radiance by group of lights: tiles of a texture on the device, pictures in a file ---

// Return a picture, or the sums of one, for each group of the tiles.
std::vector<Texels> GroupsFromTiles(const Texels& tiles, Extent2D size, uint32_t groupCount);
std::vector<passes::ExactSums> GroupsFromTiles(const passes::ExactSums& tiles, Extent2D size,
                                               uint32_t groupCount);

// Converts pictures to tiles; unused tiles are black. Squares have no tiles.
passes::ExactSums TilesFromGroups(const std::vector<passes::ExactSums>& pictures, Extent2D size);

}  // namespace raygraph::session
