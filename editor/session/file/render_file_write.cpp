#include <deque>
#include <span>

#include "base/check.h"
#include "base/path_text.h"
#include "editor/session/file/render_file_names.h"
#include "editor/session/file/render_flaws.h"

namespace raygraph::session {

void WriteRenderFile(const std::filesystem::path& path, const RenderFile& render, const Log& log,
                     ExrType type) {
    const Stopwatch watch;
    const bool isHalf = type == ExrType::Half;
    if (const std::string flaw = FirstFlaw(render); !flaw.empty())
        throw MakeError(ErrorKind::Usage, "{}: the render cannot be written: {}", path, flaw);
    std::vector<image::ExrPlane> planes;
    const auto add = [&](const std::string& name, const Texels& texels, size_t c) {
        planes.push_back({name, std::span<const float>(texels).subspan(c), 4, isHalf});
    };
    std::vector<uint32_t> samples{static_cast<uint32_t>(SampleCount(render.samples))};
    if (render.adaptive) samples = render.adaptive->counts;
    std::deque<SumResiduals> residuals;  // where they are, as the planes are spans of them
    uint64_t digest = 0;
    const auto addSums = [&](const auto& names, const passes::ExactSums& sums, const Texels& mean,
                             const Texels& variance, const std::vector<uint32_t>& counts) {
        if (isHalf || sums.IsEmpty() || mean.empty()) return;
        const SumResiduals& stored = residuals.emplace_back(ResidualsOf(
            sums, std::size(names), render.size.width, {mean, variance, counts}, DigestSeed(names[0])));
        digest += stored.digest;
        for (size_t i = 0; i < kSumWordCount; ++i)
            if (!stored.words[i].empty())
                planes.push_back(
                    {WordChannel(names, kSumWords[i]), std::span<const uint32_t>(stored.words[i])});
    };
    for (size_t c = 0; c < 4; ++c) add(kRadianceNames[c], render.radiance, c);
    for (size_t c = 0; c < 3 && !render.variance.empty(); ++c) add(kVarianceNames[c], render.variance, c);
    addSums(kRadianceNames, render.sums.radiance, render.radiance, render.variance, samples);
    for (const Aov aov : kAovs) {
        const Texels* mean = MeanOf(render, aov);
        if (mean == nullptr || mean->empty()) continue;
        for (size_t c = 0; c < 3; ++c) add(MeanChannels(aov)[c], *mean, c);
        if (aov < Aov::RemovedMaxDepth)
            addSums(MeanChannels(aov), *SumsOf(render.sums, aov), *mean, {}, CountsOf(aov, samples));
    }
    if (!render.lightGroups.empty()) {
        const std::vector<ChannelNames> names = GroupChannels(render.settings);
        RG_CHECK_EQ(names.size(), render.lightGroups.size());
        for (size_t i = 0; i < names.size(); ++i) {
            for (size_t c = 0; c < 3; ++c) add(names[i][c], render.lightGroups[i], c);
            if (!render.sums.lightGroups.empty())
                addSums(names[i], render.sums.lightGroups[i], render.lightGroups[i], {}, samples);
        }
    }
    bool hasRemoved = false;
    for (const Bias bias : kBiases) {
        const Texels& variance = render.removedVariance[static_cast<size_t>(bias)];
        hasRemoved |= !variance.empty();
        addSums(MeanChannels(AovOf(bias)), *SumsOf(render.sums, AovOf(bias)), *MeanOf(render, AovOf(bias)),
                variance, {render.removedSamples});
        for (size_t c = 0; c < 3 && !variance.empty(); ++c) add(VarianceChannels(bias)[c], variance, c);
    }
    if (!render.depth.empty()) planes.push_back({"Z", std::span<const float>(render.depth)});
    for (const IdChannel& channel : kIdChannels)
        if (!(render.*channel.ids).empty())
            planes.push_back({channel.name, std::span<const uint32_t>(render.*channel.ids)});
    for (size_t c = 0; c < 2 && !render.motion.empty(); ++c)
        planes.push_back({kMotionNames[c], std::span<const float>(render.motion).subspan(c), 2, isHalf});
    const std::string sampleCount = std::to_string(SampleCount(render.samples));
    samples.resize(PixelCount(render.size), samples.front());
    planes.push_back({kCountsName, std::span<const uint32_t>(samples)});
    const bool goesOn = render.adaptive && !render.adaptive->wanted.empty() && !isHalf;
    if (goesOn) {
        planes.push_back({kWantedName, std::span<const uint32_t>(render.adaptive->wanted)});
        for (const auto& [base, noted] : render.adaptive->noted) {
            const std::string number = std::to_string(base);
            planes.push_back({std::string(kVariancePrefix) + number, std::span<const float>(noted.variance)});
            planes.push_back({std::string(kMeanPrefix) + number, std::span<const float>(noted.mean)});
        }
    }

    image::ExrAttributes attributes;
    attributes[kAttributeFormat] = std::string(kFormat);
    attributes[kAttributeVersion] = render.version;
    attributes[kAttributeDevice] = render.device;
    attributes[kAttributeDriver] = render.driver;
    attributes[kAttributeScene] = render.sceneFile;
    attributes[kAttributeSceneHash] = render.sceneHash;
    attributes[kAttributeEnvironment] = render.environmentFile;
    attributes[kAttributeEnvironmentHash] = render.environmentHash;
    attributes[kAttributeSamples] = sampleCount;
    attributes[kAttributeSampleOffset] = std::to_string(render.samples.front().first);
    attributes[kAttributeSampleRanges] = ToText(render.samples);
    if (!residuals.empty()) attributes[kAttributeSumsDigest] = Text("{:016x}", digest);
    if (goesOn)
        attributes[kAttributeStage] = Text("{} {}", render.adaptive->stages[0], render.adaptive->stages[1]);
    if (hasRemoved) attributes[kAttributeRemovedSamples] = std::to_string(render.removedSamples);
    if (render.measuredError && render.measuredError->relativeError)
        attributes[kAttributeMeasuredError] =
            Text("{} {}", render.measuredError->samples, *render.measuredError->relativeError);
    for (const auto& [name, text] : render.settings) attributes[std::string(kSettingPrefix) + name] = text;
    const uint64_t clamped = image::WriteExr(path, render.size.width, render.size.height, planes, attributes,
                                             WindowOf(SettingsFrom(render.settings)));
    if (clamped > 0)
        Say(log, LogLevel::Warning, log_category::kScene,
            "{}: {} {} beyond 65504, the most that a half float holds", Printable(path.filename().string()),
            clamped, clamped == 1 ? "number was" : "numbers were");
    LogTransfer(log, path, render, "written", watch);
}

}  // namespace raygraph::session
