// The named biases of a render, and how much light each of them took.
//
// Every sample whose index is a multiple of kTwinPeriod is traced once more for each bias that is on, with
// that bias alone switched off and the same random numbers. What the twin has more than the sample is an
// unbiased estimate of what the bias removed (or, below 0, added).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "passes/trace.h"

namespace raygraph::cli {

// Named as in the AOV removed_max_depth and in the report.
#define RAYGRAPH_BIASES(X, Of)                    \
    X(Of, MaxDepth, 0, "max_depth", "")           \
    X(Of, ClampIndirect, 1, "clamp_indirect", "") \
    X(Of, Regularize, 2, "regularize", "")        \
    X(Of, ShadowTerminator, 3, "shadow_terminator", "")
RAYGRAPH_CHOICE(Bias, RAYGRAPH_BIASES)
inline constexpr size_t kBiasCount = Texts(Bias{}).size();
inline constexpr std::array kBiases = Values<Bias>();
std::string Option(Bias bias);  // "--max-depth"

// A sample has twins or not whichever run it is traced in. Any fixed place within blocks of a power of two
// does: the samplers give every index of a block the same chances, and shuffle the blocks independently.
inline constexpr uint32_t kTwinPeriod = 16;

bool IsOn(const passes::BiasSettings& biases, Bias bias);
bool IsAnyOn(const passes::BiasSettings& biases);

// The same with this bias off. Paths that a depth alone would have ended end by roulette then.
passes::TraceSettings Without(passes::TraceSettings settings, Bias bias);

// Luminances, as means over the pixels.
struct RemovedLight {
    uint32_t samples = 0;  // that had twins
    double mean = 0.0;
    // At most this; none below two twins. Pixels count as independent, channels as fully dependent.
    std::optional<double> standardError;
    // Of the mean without the bias, and its standard error; none where that mean is not positive.
    std::optional<double> share, shareStandardError;
};

// RGBA texels: mean and variance of what `samples` twins had more, and the biased picture.
RemovedLight MeasureRemoved(std::span<const float> removed, std::span<const float> variance, uint32_t samples,
                            std::span<const float> picture);

// "--max-depth removed 25 % +- 0.3 % of the light"
std::string Describe(Bias bias, const RemovedLight& removed);

}  // namespace raygraph::cli
