// DenoisedView keeps a denoised version of a viewport's path-traced picture, and decides when it is
// updated.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "passes/accumulate.h"
#include "passes/trace.h"
#include "renderer/graph/pass_series.h"

namespace raygraph::viewport {

// Denoising takes as long as several samples. So it waits for half as many after a change, and from then on
// takes about a quarter of the device's time: of many samples, it is updated with every quarter more. Frames
// end with whole samples where it is begun, and where the mean of the first half of the samples is kept,
// which tells how noisy the picture is (passes/denoise.h). Where it takes longer than a frame may, it is made
// over several frames, while sampling goes on.
class DenoisedView {
  public:
    explicit DenoisedView(std::string name) : m_name(std::move(name)), m_series(m_name) {}

    struct Ids {
        TextureId picture;     // rgba32f; invalid: there is none yet
        uint32_t samples = 0;  // of the mean from which it was made
        uint64_t version = 0;  // differs for every picture
        // Passes of which some make it in this frame, from `first` to before `end`. It may be begun in one
        // frame and complete in another.
        PassId first, end;
        bool isBegun = false;
        bool isComplete = false;
    };
    struct Request {
        // Milliseconds of this frame that it may take; 0: any number.
        double frameMs = 0.0;
        // It is updated if there are any new samples.
        bool isWanted = false;
        // It is made in this frame, whatever `frameMs`.
        bool isUrgent = false;
        // Its pipelines may be waited for; otherwise, it is made once they exist.
        bool mayWait = true;
    };
    // Declares the picture of a frame, after all its samples. They are all of `settings`, and have squares.
    Ids Declare(Renderer& renderer, const SceneIds& scene, const passes::TraceSettings& settings,
                const passes::Accumulation& samples, const Request& request);
    // Returns the picture as it was made last, without passes.
    Ids DeclareLast(Renderer& renderer, Extent2D extent, const passes::Accumulation& samples);
    // Returns the number of samples with which the next frame must end at the latest.
    uint32_t NextStop(const passes::Accumulation& samples) const;
    // Returns the samples of the picture that is shown of these samples; 0: there is none.
    uint32_t SampleCount(const passes::Accumulation& samples) const;
    // Records the times of the frame for which Declare returned `frame`: its passes took `milliseconds`, and
    // a sample takes `sampleMs`.
    void AddTimings(const FrameTiming& timing, const Ids& frame, double milliseconds, double sampleMs);
    void Release(Renderer& renderer);

    // Returns the number of samples with which a picture is made: the first one, and the next after one of
    // `last` samples. `cost` is the time of making it over that of a sample.
    static uint32_t First(double cost);
    static uint32_t Next(uint32_t last, double cost);

  private:
    struct State {
        uint64_t resetCount = 0;           // of the accumulation
        uint32_t samples = 0;              // of the picture; 0: there is none
        uint32_t pending = 0;              // of the picture that is being made over several frames
        uint32_t pendingHalf = 0;          // samples of the mean that tells its noise
        std::array<uint32_t, 2> halves{};  // samples of the means that are kept; 0: none
    };
    struct Inputs {
        TextureId mean, variance;
        std::optional<TextureId> half;
    };
    static constexpr size_t kNoHalf = 2;
    // Returns the state, empty if the accumulation was restarted since.
    State StateFor(const passes::Accumulation& samples) const;
    uint32_t Due(const State& state) const;
    std::string HalfName(size_t i) const { return m_name + (i == 0 ? ".half.0" : ".half.1"); }
    TextureId Half(Renderer& renderer, Extent2D extent, size_t i) const;
    std::string InputName(const char* input) const { return m_name + "." + input; }
    TextureId Input(Renderer& renderer, Extent2D extent, const char* name) const;
    Inputs KeepInputs(Renderer& renderer, const Inputs& inputs) const;
    Inputs KeptInputs(Renderer& renderer, Extent2D extent, const State& state) const;
    // Returns whether the mean of so many samples is kept.
    static bool IsHalf(const State& state, uint32_t count);
    // Keeps the mean if it is one of those, and returns its number.
    std::optional<size_t> KeepHalf(Renderer& renderer, const passes::AccumulatedIds& radiance,
                                   const State& state, uint32_t count);
    // Returns which of the means is about half of so many samples; kNoHalf: none.
    size_t HalfFor(Renderer& renderer, Extent2D extent, const State& state, uint32_t count) const;
    // Returns the state to be changed when a frame is submitted.
    State& StateOf(uint64_t resetCount);

    std::string m_name;
    State m_state;
    uint64_t m_version = 0;
    PassSeries m_series;
    double m_spentMs = 0.0;  // on the picture that is being made
    double m_cost = 10.0;    // as docs/denoise.md has measured it
};

}  // namespace raygraph::viewport
