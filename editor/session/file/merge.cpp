#include "editor/session/file/merge.h"

#include <utility>

#include "base/printable.h"
#include "base/text.h"
#include "editor/session/file/render_file_parts.h"

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
    // The editor's albedo and normals are those of the pixels' centers, whereas a session traces those of the
    // samples
    const bool isViewportCapture = HasSums(part.render, {Aov::Albedo, Aov::Normal});
    throw MakeError(ErrorKind::BadInput, "{} lacks sums of samples: there is no channel {}{}", part.name,
                    missing,
                    isViewportCapture                     ? "; resume it once, and it can be merged"
                    : part.render.sums.radiance.IsEmpty() ? kHalfHint
                                                          : "");
}

// The mean of some samples becomes that of the others, too.
void AddMean(Texels& mean, uint64_t count, const Texels& others, uint64_t otherCount) {
    if (mean.empty() || others.empty()) {
        if (mean.empty()) mean = others;
        return;
    }
    const double own = static_cast<double>(count), more = static_cast<double>(otherCount);
    for (size_t i = 0; i < mean.size(); ++i)
        mean[i] = static_cast<float>((own * mean[i] + more * others[i]) / (own + more));
}

void AddDenoising(RenderFile& merged, const RenderFile& other) {
    DenoisingPlanes& planes = merged.denoising;
    for (const auto& [names, plane] : DenoisingChannels()) {
        const bool isHalf = plane == &DenoisingPlanes::firstHalf;
        AddMean(planes.*plane, isHalf ? planes.firstSamples : SampleCount(merged.samples),
                other.denoising.*plane, isHalf ? other.denoising.firstSamples : SampleCount(other.samples));
    }
    planes.firstSamples += other.denoising.firstSamples;
}

}  // namespace

void Merger::Add(NamedRender part) {
    if (m_merged) RequireCompatible(*m_merged, part);
    if (const std::string flaw = FirstFlaw(part.render); !flaw.empty())
        throw MakeError(ErrorKind::BadInput, "{} cannot be merged: {}", part.name, flaw);
    if (part.render.adaptive)
        throw MakeError(
            ErrorKind::BadInput,
            "{} cannot be merged: it is adaptive, and its pixels have different numbers of samples",
            part.name);
    RequireSums(part);
    for (const Part& other : m_parts)
        if (Overlap(other.samples, part.render.samples))
            throw MakeError(ErrorKind::BadInput, "{} and {} hold the same samples: {} and {}", other.name,
                            part.name, ToText(other.samples), ToText(part.render.samples));
    m_parts.push_back({part.name, part.render.samples});
    if (!m_merged) {
        m_merged = std::move(part);
        return;
    }
    RenderFile &merged = m_merged->render, &other = part.render;
    // Channels that are not accumulated are equal in all parts; the part with the first samples provides them
    if (other.samples.front().first < merged.samples.front().first) std::swap(merged, other);
    session::Add(merged.sums, std::move(other.sums));
    AddDenoising(merged, other);
    merged.removedSamples += other.removedSamples;
    merged.samples = Union(merged.samples, other.samples);
    merged.measuredError.reset();
}

RenderFile Merger::Take() {
    if (!m_merged) throw Error(ErrorKind::Usage, "there are no renders to merge");
    RenderFile merged = std::move(m_merged->render);
    m_merged.reset();
    m_parts.clear();
    if (const uint64_t total = SampleCount(merged.samples); total > 0xFFFFFFFFu)
        throw MakeError(ErrorKind::BadInput, "{} samples are more than can be counted", total);
    TakeMeans(merged);
    return merged;
}

RenderFile Merge(std::vector<NamedRender> parts) {
    Merger merger;
    for (NamedRender& part : parts) merger.Add(std::move(part));
    return merger.Take();
}

}  // namespace raygraph::session
