#include "editor/session/merge.h"

#include <algorithm>
#include <utility>

#include "base/printable.h"
#include "base/text.h"
#include "editor/session/render_flaws.h"

namespace raygraph::session {

namespace {

void RequireSameChannels(const NamedRender& first, const NamedRender& other) {
    const auto require = [&](const char* channels, bool inFirst, bool inOther) {
        if (inFirst == inOther) return;
        const NamedRender &with = inFirst ? first : other, &without = inFirst ? other : first;
        throw MakeError(ErrorKind::BadInput, "{} has the channels of {}, {} has not", with.name, channels,
                        without.name);
    };
    require("variance", !first.render.variance.empty(), !other.render.variance.empty());
    require("groups of lights", !first.render.lightGroups.empty(), !other.render.lightGroups.empty());
    const AovSet inFirst = AovsOf(first.render), inOther = AovsOf(other.render);
    for (const Aov aov : kAovs) require(Name(aov), inFirst.Has(aov), inOther.Has(aov));
}

void RequireCompatible(const NamedRender& first, const NamedRender& other) {
    const std::string mismatch = FirstMismatch(first.render, other.render);
    if (!mismatch.empty())
        throw MakeError(ErrorKind::BadInput, "{} and {} differ: {}", first.name, other.name,
                        Printable(mismatch, 1024));
    RequireSameChannels(first, other);
}

void RequireSums(const NamedRender& part) {
    const std::string missing = FirstMissingChannel(part.render);
    if (missing.empty()) return;
    // The editor's albedo and normals are those of the pixels' centers; a session traces those of the samples
    const bool isOfEditor = HasSums(part.render, {Aov::Albedo, Aov::Normal});
    throw MakeError(ErrorKind::BadInput, "{} lacks sums of samples: there is no channel {}{}", part.name,
                    missing,
                    isOfEditor                            ? "; resume it once, and it can be merged"
                    : part.render.sums.radiance.IsEmpty() ? kHalfHint
                                                          : "");
}

void RequireDisjoint(const NamedRender& a, const NamedRender& b) {
    if (Overlap(a.render.samples, b.render.samples))
        throw MakeError(ErrorKind::BadInput, "{} and {} hold the same samples: {} and {}", a.name, b.name,
                        ToText(a.render.samples), ToText(b.render.samples));
}

// Adds to sums that may be of no part yet.
void Add(passes::ExactSums& sums, passes::ExactSums&& others) {
    if (sums.IsEmpty())
        sums = std::move(others);
    else if (!others.IsEmpty())
        passes::AddSums(sums, others);
}

void Add(RenderSums& sums, RenderSums&& others) {
    Add(sums.radiance, std::move(others.radiance));
    for (const Aov aov : kAovs)
        if (passes::ExactSums* of = SumsOf(sums, aov)) Add(*of, std::move(*SumsOf(others, aov)));
    for (size_t i = 0; i < sums.lightGroups.size(); ++i)
        Add(sums.lightGroups[i], std::move(others.lightGroups[i]));
}

// Sets the pictures to what the sums say.
void TakeMeans(RenderFile& render) {
    const auto count = static_cast<uint32_t>(SampleCount(render.samples));
    render.radiance = passes::MeanOf(render.sums.radiance, count);
    if (render.sums.radiance.HasSquares()) render.variance = passes::VarianceOf(render.sums.radiance, count);
    for (const Aov aov : kAovs) {
        const passes::ExactSums* sums = SumsOf(render.sums, aov);
        if (sums != nullptr && !sums->IsEmpty() && aov < Aov::RemovedMaxDepth)
            *MeanOf(render, aov) = passes::MeanOf(*sums, count);
    }
    for (size_t i = 0; i < kBiasCount; ++i) {
        const passes::ExactSums& sums = render.sums.removed[i];
        if (sums.IsEmpty() || render.removedSamples == 0) continue;
        render.removed[i] = passes::MeanOf(sums, render.removedSamples);
        render.removedVariance[i] = passes::VarianceOf(sums, render.removedSamples);
    }
    for (size_t i = 0; i < render.lightGroups.size(); ++i)
        render.lightGroups[i] = passes::MeanOf(render.sums.lightGroups[i], count);
}

}  // namespace

RenderFile Merge(std::vector<NamedRender> parts) {
    if (parts.empty()) throw Error(ErrorKind::Usage, "there are no renders to merge");
    for (size_t i = 1; i < parts.size(); ++i) RequireCompatible(parts[0], parts[i]);
    for (const NamedRender& part : parts) {
        if (const std::string flaw = FirstFlaw(part.render); !flaw.empty())
            throw MakeError(ErrorKind::BadInput, "{} cannot be merged: {}", part.name, flaw);
        RequireSums(part);
    }
    for (size_t i = 0; i < parts.size(); ++i)
        for (size_t j = 0; j < i; ++j) RequireDisjoint(parts[j], parts[i]);

    // What is not accumulated is alike in all parts, and comes from that of the first samples
    std::ranges::sort(parts, {}, [](const NamedRender& part) { return part.render.samples.front().first; });
    RenderFile merged = std::move(parts[0].render);
    for (size_t i = 1; i < parts.size(); ++i) {
        RenderFile& part = parts[i].render;
        Add(merged.sums, std::move(part.sums));
        merged.removedSamples += part.removedSamples;
        merged.samples = Union(merged.samples, part.samples);
    }
    if (const uint64_t total = SampleCount(merged.samples); total > 0xFFFFFFFFu)
        throw MakeError(ErrorKind::BadInput, "{} samples are more than can be counted", total);
    TakeMeans(merged);
    return merged;
}

}  // namespace raygraph::session
