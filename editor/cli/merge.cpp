#include "editor/cli/merge.h"

#include <map>

#include "base/check.h"
#include "base/error.h"

namespace raygraph::cli {

namespace {

// A part is folded into double-precision sums; the division comes once, at the end.
struct Sums {
    std::vector<double> mean;          // running mean
    std::vector<double> squaredError;  // sum over samples of (x - mean)^2
};

void RequireSameChannels(const NamedRender& first, const NamedRender& other) {
    const auto require = [&](const char* channels, bool inFirst, bool inOther) {
        if (inFirst == inOther) return;
        const NamedRender &with = inFirst ? first : other, &without = inFirst ? other : first;
        throw Error(ErrorKind::BadInput,
                    with.name + " has the channels of " + channels + ", " + without.name + " has not");
    };
    require("variance", !first.render.variance.empty(), !other.render.variance.empty());
    require("groups of lights", !first.render.lightGroups.empty(), !other.render.lightGroups.empty());
    const AovSet inFirst = AovsOf(first.render), inOther = AovsOf(other.render);
    for (const Aov aov : kAovs) require(Name(aov), inFirst.Has(aov), inOther.Has(aov));
}

void RequireCompatible(const NamedRender& first, const NamedRender& other) {
    const std::string mismatch = FirstMismatch(first.render, other.render);
    if (!mismatch.empty())
        throw Error(ErrorKind::BadInput, first.name + " and " + other.name + " differ: " + mismatch);
    RequireSameChannels(first, other);
}

void RequireDisjoint(const NamedRender& a, const NamedRender& b) {
    if (Overlap(a.render.samples, b.render.samples))
        throw Error(ErrorKind::BadInput, a.name + " and " + b.name + " hold the same samples: " +
                                             ToText(a.render.samples) + " and " + ToText(b.render.samples));
}

// Folds `count` samples of this mean (and variance, if there is one) into sums that hold `countBefore`.
void Fold(Sums& sums, double countBefore, const Texels& mean, const Texels& variance, double count) {
    sums.mean.resize(mean.size());
    sums.squaredError.resize(variance.size());
    const double weight = count / (countBefore + count);
    for (size_t i = 0; i < mean.size(); i++) {
        const double delta = mean[i] - sums.mean[i];
        if (!variance.empty())
            sums.squaredError[i] += variance[i] * (count - 1.0) + delta * delta * countBefore * weight;
        // The first part's mean as it is, infinity included
        sums.mean[i] = countBefore == 0.0 ? mean[i] : sums.mean[i] + delta * weight;
    }
}

Texels MeanOf(const Sums& sums) {
    return {sums.mean.begin(), sums.mean.end()};
}

Texels VarianceOf(const Sums& sums, double count) {
    Texels variance(sums.squaredError.size(), 0.0f);
    for (size_t i = 0; i < variance.size() && count > 1.0; i++)
        variance[i] = static_cast<float>(sums.squaredError[i] / (count - 1.0));
    return variance;
}

}  // namespace

RenderFile Merge(std::vector<NamedRender> parts) {
    RG_CHECK(!parts.empty());
    for (size_t i = 1; i < parts.size(); i++) RequireCompatible(parts[0], parts[i]);
    for (size_t i = 0; i < parts.size(); i++)
        for (size_t j = 0; j < i; j++) RequireDisjoint(parts[j], parts[i]);

    Sums radiance;
    std::map<Aov, Sums> aovs;
    std::array<Sums, kBiasCount> removed;
    double removedSamples = 0.0;
    std::vector<Sums> groups(parts[0].render.lightGroups.size());
    SampleRanges samples;
    for (const NamedRender& part : parts) {
        const RenderFile& render = part.render;
        const double before = static_cast<double>(SampleCount(samples));
        const double count = static_cast<double>(SampleCount(render.samples));
        Fold(radiance, before, render.radiance, render.variance, count);
        for (const Aov aov : kAovs)
            if (const Texels* mean = MeanOf(render, aov); mean && aov < Aov::RemovedMaxDepth)
                Fold(aovs[aov], before, *mean, {}, count);
        for (size_t i = 0; i < kBiasCount; i++)
            Fold(removed[i], removedSamples, render.removed[i], render.removedVariance[i],
                 render.removedSamples);
        removedSamples += render.removedSamples;
        for (size_t i = 0; i < groups.size(); i++) Fold(groups[i], before, render.lightGroups[i], {}, count);
        samples = Union(samples, render.samples);
    }
    const uint64_t total = SampleCount(samples);
    if (total > 0xFFFFFFFFu)
        throw Error(ErrorKind::BadInput, std::to_string(total) + " samples are more than can be counted");

    RenderFile merged = std::move(parts[0].render);
    merged.radiance = MeanOf(radiance);
    merged.variance = VarianceOf(radiance, static_cast<double>(total));
    for (const Aov aov : kAovs)
        if (Texels* mean = MeanOf(merged, aov)) *mean = MeanOf(aovs[aov]);
    for (size_t i = 0; i < kBiasCount; i++) {
        merged.removed[i] = MeanOf(removed[i]);
        merged.removedVariance[i] = VarianceOf(removed[i], removedSamples);
    }
    for (size_t i = 0; i < groups.size(); i++) merged.lightGroups[i] = MeanOf(groups[i]);
    merged.removedSamples = static_cast<uint32_t>(removedSamples);
    merged.samples = std::move(samples);
    return merged;
}

}  // namespace raygraph::cli
