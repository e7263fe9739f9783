// DenoisedView keeps a denoised version of a viewport's path-traced picture, and decides when it is updated.
// Threads: that of the Renderer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "passes/accumulate.h"
#include "passes/trace.h"
#include "renderer/graph/pass_series.h"

namespace raygraph::viewport {

// Denoising takes as long as several samples. The first picture is made after half as many samples as it
// takes, and later ones so that denoising takes at most about a quarter of the device's time (First, Next).
// A picture that takes longer than a frame may is divided among frames (PassSeries) while sampling goes on.
// Frames end with whole samples (NextStop) where a picture is begun, and at 8, 16, 32 samples and so on,
// whose mean is kept: it serves later as that of the first half, which tells how noisy the picture is
// (passes/denoise.h). The view must outlive the frames that declare it.
class DenoisedView {
  public:
    explicit DenoisedView(std::string name) : m_name(std::move(name)), m_series(m_name) {}

    struct Ids {
        TextureId picture;     // rgba32f; invalid: there is none yet
        uint32_t samples = 0;  // in the mean from which the picture was made
        uint64_t version = 0;  // differs for every picture
        // Denoising passes of this frame, from `first` to before `end`; a picture may be begun in one frame
        // and be complete in a later one.
        PassId first, end;
        bool isBegun = false;
        bool isComplete = false;
    };
    struct Request {
        // Milliseconds that denoising may take in this frame; 0: no limit.
        double frameMs = 0.0;
        // With any new samples, a picture is begun, whether one is due or not.
        bool isWanted = false;
        // A picture of all samples is made in this frame, whatever `frameMs`.
        bool isUrgent = false;
        // The frame may wait for pipelines; otherwise, no picture is made before they exist.
        bool mayWait = true;
    };
    // Declares the picture of a frame, after all its samples. They are all of `settings`, and have squares.
    Ids Declare(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                const passes::Accumulation& samples, const Request& request);
    // Returns the picture as it was made last, without passes. Both release what is kept of other samples.
    Ids DeclareLast(Renderer& renderer, Extent2D extent, const passes::Accumulation& samples);
    // Returns the number of samples with which the next frame must end if it would have more.
    uint32_t NextStop(const passes::Accumulation& samples) const;
    // Returns how many of these samples are in the picture that is shown; 0: there is none.
    uint32_t SampleCount(const passes::Accumulation& samples) const;
    // Records the times of the frame for which Declare returned `frame`: its passes took `milliseconds`, and
    // a sample takes `sampleMs`.
    void AddTimings(const FrameTiming& timing, const Ids& frame, double milliseconds, double sampleMs);
    // Releases all memory, and forgets the picture.
    void Release(Renderer& renderer);

    // Returns the number of samples after which a picture is made: the first one, and the one after a picture
    // of `last` samples. `cost` is the time of denoising over that of a sample.
    static uint32_t First(double cost);
    static uint32_t Next(uint32_t last, double cost);

  private:
    struct State {
        uint64_t resetCount = 0;         // of the accumulation
        uint32_t samples = 0;            // in the picture; 0: there is none
        uint32_t samplesInProgress = 0;  // in the picture that is being made over several frames; 0: none is
        uint32_t halfInProgress = 0;     // samples in the mean of its first half; 0: it has none
        std::array<uint32_t, 2> keptMeans{};  // their numbers of samples; 0: none
    };
    struct Inputs {
        TextureId mean, variance;
        std::optional<TextureId> half;
    };
    static constexpr size_t kNoHalf = 2;
    bool IsStale(const passes::Accumulation& samples) const;
    // Returns the state, empty if it is stale.
    State StateFor(const passes::Accumulation& samples) const;
    // Returns the number of samples with which the next picture is due.
    uint32_t NextUpdate(const State& state) const;
    std::string HalfName(size_t i) const { return m_name + (i == 0 ? ".half.0" : ".half.1"); }
    TextureId Half(Renderer& renderer, Extent2D extent, size_t i) const;
    std::string InputName(const char* input) const { return m_name + "." + input; }
    TextureId Input(Renderer& renderer, Extent2D extent, const char* name) const;
    Inputs KeepInputs(Renderer& renderer, const Inputs& inputs) const;
    Inputs KeptInputs(Renderer& renderer, Extent2D extent, const State& state) const;
    // Discards the picture in progress and its inputs.
    void ReleaseProgress(Renderer& renderer);
    // Returns whether the mean of so many samples is kept.
    static bool IsHalf(const State& state, uint32_t count);
    // Keeps the mean if it is one of those, and returns its index.
    std::optional<size_t> KeepHalf(Renderer& renderer, const passes::AccumulatedIds& radiance,
                                   const State& state, uint32_t count);
    // Returns the index of the kept mean that has about half of so many samples; kNoHalf: none has.
    size_t HalfFor(Renderer& renderer, Extent2D extent, const State& state, uint32_t count) const;
    // Returns the state to be changed when a frame is submitted.
    State& StateOf(uint64_t resetCount);

    std::string m_name;
    State m_state;
    uint64_t m_version = 0;
    PassSeries m_series;
    double m_spentMs = 0.0;  // on the picture in progress
    double m_cost = 10.0;    // time of a picture over that of a sample; a guess until AddTimings
};

}  // namespace raygraph::viewport
