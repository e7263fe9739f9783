#include "editor/session/settings/bias.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace raygraph::session {

namespace {

constexpr double kLuminance[] = {0.2126, 0.7152, 0.0722};  // Rec. 709, as in shaders/core/color.glsl

}  // namespace

bool IsOn(const passes::BiasSettings& biases, Bias bias) {
    switch (bias) {
        case Bias::MaxDepth:
            return biases.maxDepth != passes::kNoDepthLimit;
        case Bias::ClampIndirect:
            return !std::isinf(biases.clampIndirect);
        case Bias::Regularize:
            return biases.regularize > 0.0f;
        case Bias::ShadowTerminator:
            return biases.shadowTerminator;
        case Bias::TextureLod:
            return !std::isinf(biases.textureLod);
    }
    return false;
}

passes::TraceSettings Without(passes::TraceSettings settings, Bias bias) {
    const passes::BiasSettings off;
    switch (bias) {
        case Bias::MaxDepth: {
            settings.biases.maxDepth = off.maxDepth;
            passes::RouletteSettings& roulette = settings.roulette;
            const bool hasFixedProbability =
                roulette.kind == Roulette::Constant || roulette.kind == Roulette::Frame;
            if (roulette.kind == Roulette::Off || (hasFixedProbability && roulette.survival >= 1.0f))
                roulette = {};
            break;
        }
        case Bias::ClampIndirect:
            settings.biases.clampIndirect = off.clampIndirect;
            break;
        case Bias::Regularize:
            settings.biases.regularize = off.regularize;
            break;
        case Bias::ShadowTerminator:
            settings.biases.shadowTerminator = off.shadowTerminator;
            break;
        case Bias::TextureLod:
            settings.biases.textureLod = off.textureLod;
            break;
    }
    return settings;
}

RemovedLight MeasureRemoved(std::span<const float> removed, std::span<const float> variance, uint32_t samples,
                            std::span<const float> picture) {
    RG_CHECK_EQ(removed.size(), variance.size());
    RG_CHECK_EQ(removed.size(), picture.size());
    double removedSum = 0.0, varianceSum = 0.0, pictureSum = 0.0;
    for (size_t i = 0; i + 3 < removed.size(); i += 4) {
        double luminance = 0.0, left = 0.0, deviation = 0.0;
        for (size_t c = 0; c < 3; ++c) {
            luminance += kLuminance[c] * removed[i + c];
            left += kLuminance[c] * picture[i + c];
            deviation += kLuminance[c] * std::sqrt(double{variance[i + c]});
        }
        removedSum += luminance;
        pictureSum += left;
        varianceSum += deviation * deviation;
    }
    RemovedLight light{.samples = samples};
    if (removed.empty()) return light;
    const double pixels = 0.25 * static_cast<double>(removed.size());
    light.mean = removedSum / pixels;
    if (samples > 1) light.standardError = std::sqrt(varianceSum / samples) / pixels;
    const double whole = pictureSum / pixels + light.mean;
    if (!(whole > 0.0)) return light;
    light.share = light.mean / whole;
    if (light.standardError) light.shareStandardError = *light.standardError / whole;
    return light;
}

}  // namespace raygraph::session
