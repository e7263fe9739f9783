// Accumulate: running mean, and variance if asked for, of one sample a frame.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// Why an accumulation started anew. Exposure and tone mapping are no causes: they come after it.
enum class ResetCause : uint8_t {
    Start,
    Camera,
    Transform,
    Material,
    Light,
    Geometry,
    Environment,
    Resize,
    Settings,
    Count
};
const char* Name(ResetCause cause);

// What one accumulation remembers between frames. One object per accumulated image; `name` keys the
// persistent textures. Count and resets follow the frames that were submitted: an Accumulate that is culled,
// or whose frame is dropped, adds nothing and resets nothing.
class Accumulation {
  public:
    explicit Accumulation(std::string name) : m_name(std::move(name)) {}

    // The next sample starts from nothing. A frame that has been declared but not executed may still show its
    // sample within the old mean; it is not counted.
    void Reset(ResetCause cause);
    // Samples in the mean.
    uint32_t SampleCount() const { return m_sampleCount; }
    uint32_t ResetCount(ResetCause cause) const { return m_resets[static_cast<size_t>(cause)]; }
    const std::string& Name() const { return m_name; }

  private:
    friend class AccumulationStep;
    std::string m_name;
    uint64_t m_resetCount = 0;  // tells a declaration that a reset came after it
    uint32_t m_sampleCount = 0;
    bool m_hasVariance = false;  // of all samples in the mean
    Extent2D m_extent;
    std::array<uint32_t, static_cast<size_t>(ResetCause::Count)> m_resets{};
};

struct AccumulatedIds {
    TextureId mean;  // rgba32f
    TextureId
        variance;  // rgba32f, unbiased variance of one sample, 0 below two samples; invalid if not asked for
};

// mean_n = mean_(n-1) + (x - mean_(n-1)) / n and Welford's recurrence for the sample variance (Welford 1962,
// "Note on a Method for Calculating Corrected Sums of Squares and Products"), in float32. The state is
// exactly (mean, variance, n): storing and restoring the three continues bit for bit. A changed extent resets
// with ResetCause::Resize; asking for the variance of samples that were taken without it resets with
// ResetCause::Settings. `accumulation` outlives the frame.
[[nodiscard]] AccumulatedIds Accumulate(Renderer& renderer, TextureId sample, Accumulation& accumulation,
                                        bool withVariance = false);

// Continues from stored state: rgba32f texels of mean and variance (may be empty if it is not accumulated)
// after `sampleCount` samples. Declares an upload into the persistent textures: in a frame of its own,
// executed before the first Accumulate. `accumulation` outlives the frame and changes when it is submitted.
void Restore(Renderer& renderer, Accumulation& accumulation, Extent2D extent, uint32_t sampleCount,
             std::span<const float> mean, std::span<const float> variance);

}  // namespace raygraph::passes
