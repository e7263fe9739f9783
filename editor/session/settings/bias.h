// The named biases of a render, and how much light each of them removed.
//
// Every sample whose index is a multiple of kSecondTracePeriod is traced a second time for each bias that is
// on, with only that bias off and the same random numbers. The second trace minus the sample is an unbiased
// estimate of what the bias removed (or, below 0, added). Threads: plain values and pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "base/api.h"
#include "passes/trace.h"

namespace raygraph::session {

// The names follow those of the AOV removed_max_depth and of the report.
#define RAYGRAPH_BIASES(X, Of)                          \
    X(Of, MaxDepth, 0, "max_depth", "")                 \
    X(Of, ClampIndirect, 1, "clamp_indirect", "")       \
    X(Of, Regularize, 2, "regularize", "")              \
    X(Of, ShadowTerminator, 3, "shadow_terminator", "") \
    X(Of, TextureLod, 4, "texture_lod", "")
RAYGRAPH_CHOICE(Bias, RAYGRAPH_BIASES)
inline constexpr size_t kBiasCount = Texts(Bias{}).size();
inline constexpr std::array kBiases = Values<Bias>();

// Whether a sample is traced twice depends only on its index, not on the run. Any fixed position within
// blocks of a power of two is valid: the samplers treat all indices of a block alike, and shuffle the
// blocks independently.
inline constexpr uint32_t kSecondTracePeriod = 16;

RAYGRAPH_API bool IsOn(const passes::BiasSettings& biases, Bias bias);

// Returns the settings with this bias off. Paths that only a depth limit would have ended then end by
// roulette.
RAYGRAPH_API passes::TraceSettings Without(passes::TraceSettings settings, Bias bias);

// Holds luminances, as means over the pixels.
struct RemovedLight {
    uint32_t samples = 0;  // number of samples that were traced twice
    double mean = 0.0;
    // Holds an upper bound; none below two samples. It takes pixels as independent, and channels as fully
    // dependent.
    std::optional<double> standardError;
    // The share is relative to the mean without the bias; none if that mean is not positive.
    std::optional<double> share, shareStandardError;
};

// Takes RGBA texels: mean and variance of second trace minus sample over `samples` of them; the biased
// picture.
RAYGRAPH_API RemovedLight MeasureRemoved(std::span<const float> removed, std::span<const float> variance,
                                         uint32_t samples, std::span<const float> picture);

}  // namespace raygraph::session
