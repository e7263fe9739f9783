#include "editor/session/file/render_file.h"

#include <algorithm>
#include <span>

#include "base/check.h"
#include "base/path_text.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/session/file/render_file_names.h"
#include "editor/session/file/render_flaws.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/setting_table.h"
#include "renderer/image/exr.h"

namespace raygraph::session {

namespace {

// Puts the channels of these names into RGBA texels; false if the first of them is not there.
template <typename Names>
bool ReadColorChannels(const image::ExrImage& file, const Names& names, Texels& texels) {
    if (file.FloatChannel(names[0]) == nullptr) return false;
    texels.assign(size_t{4} * file.width * file.height, 0.0f);
    for (size_t c = 0; c < std::size(names); ++c) {
        const std::vector<float>* channel = file.FloatChannel(names[c]);
        if (channel == nullptr)
            throw MakeError(ErrorKind::BadInput, "there is {} but no {}", names[0], names[c]);
        for (size_t i = 0; i < channel->size(); ++i) texels[4 * i + c] = (*channel)[i];
    }
    return true;
}

std::string TextAttribute(const image::ExrImage& file, const char* name) {
    const auto attribute = file.attributes.find(name);
    if (attribute == file.attributes.end()) return {};
    const std::string* text = std::get_if<std::string>(&attribute->second);
    if (text == nullptr) throw MakeError(ErrorKind::BadInput, "attribute {} is not a text", name);
    return *text;
}

// The sums of a file, picture after picture.
class SumsReader {
  public:
    explicit SumsReader(const image::ExrImage& file)
        : m_file(file), m_holdsWords(TextAttribute(file, kAttributeFormat) == kWordFormat) {}

    // Reads the sums in the channels of these names, with squares if there is a variance; empty if there are
    // none.
    template <typename Names>
    passes::ExactSums Take(const Names& names, const Texels& mean, const Texels& variance,
                           const std::vector<uint32_t>& counts) {
        if (Channel(WordChannel(names, SumWord{})) == nullptr) return {};
        if (m_holdsWords) return ReadSumWords(names, !variance.empty());
        std::array<std::span<const uint32_t>, kSumWordCount> residuals;
        for (size_t i = 0; i < kSumWordCount; ++i)
            if (kSumWords[i].channel < std::size(names))
                if (const auto* words = Channel(WordChannel(names, kSumWords[i]))) residuals[i] = *words;
        const bool hasSquares = Channel(WordChannel(names, SumWord{.isSquareSum = true})) != nullptr;
        PredictedSums predicted =
            SumsOf(residuals, std::size(names), m_file.width,
                   {mean, hasSquares ? variance : Texels(), counts}, DigestSeed(names[0]));
        m_digest += predicted.digest;
        m_hasPredicted = true;
        return std::move(predicted.sums);
    }

    // After the last one.
    void RequireDigest() const {
        if (!m_hasPredicted || TextAttribute(m_file, kAttributeSumsDigest) == Text("{:016x}", m_digest))
            return;
        throw Error(ErrorKind::BadInput,
                    "its sums are not those that were written: another program has changed its channels");
    }

  private:
    const std::vector<uint32_t>* Channel(const std::string& name) const { return m_file.UintChannel(name); }
    template <typename Names>
    passes::ExactSums ReadSumWords(const Names& names, bool withSquares) const {
        passes::ExactSums sums = passes::MakeExactSums(size_t{m_file.width} * m_file.height, withSquares);
        for (const SumWord& which : kSumWords) {
            if (which.channel >= std::size(names) || (which.isSquareSum && !withSquares)) continue;
            const std::vector<uint32_t>* words = Channel(WordChannel(names, which));
            if (words == nullptr)
                throw MakeError(ErrorKind::BadInput, "there are sums of samples but no channel {}",
                                WordChannel(names, which));
            passes::ExactSums::Plane& plane = !which.isSquareSum ? sums.sums[which.word]
                                              : which.word < passes::ExactSums::kPlanes
                                                  ? sums.squares[which.word]
                                                  : sums.squares[which.channel];
            const size_t component = which.word < passes::ExactSums::kPlanes ? which.channel : 3;
            for (size_t i = 0; i < words->size(); ++i) plane[4 * i + component] = (*words)[i];
        }
        return sums;
    }

    const image::ExrImage& m_file;
    bool m_holdsWords;
    bool m_hasPredicted = false;
    uint64_t m_digest = 0;
};

void RequireFormat(const image::ExrImage& file) {
    const std::string format = TextAttribute(file, kAttributeFormat);
    if (format == kFormat || format == kWordFormat) return;
    if (!format.empty())
        throw MakeError(ErrorKind::BadInput, "{} is {}; this program reads {}", kAttributeFormat, format,
                        kFormat);
    if (file.attributes.contains(kAttributeSampleRanges))
        throw Error(
            ErrorKind::BadInput,
            "written by an older version, which stored no sums of samples: it can be neither resumed nor "
            "merged");
    throw MakeError(ErrorKind::BadInput, "no attribute {}: not a render of this program", kAttributeFormat);
}

const std::vector<uint32_t>& CountsOf(const image::ExrImage& file) {
    const std::vector<uint32_t>* counts = file.UintChannel(kCountsName);
    if (counts == nullptr) throw MakeError(ErrorKind::BadInput, "there is no uint channel {}", kCountsName);
    return *counts;
}

// Every pixel has as many samples, unless the render is adaptive.
void RequireUniformCounts(const image::ExrImage& file, uint64_t sampleCount) {
    for (const uint32_t count : CountsOf(file))
        if (count != sampleCount)
            throw MakeError(ErrorKind::BadInput, "a pixel has {} samples, the render {}", count, sampleCount);
}

AdaptiveState AdaptiveStateOf(const image::ExrImage& file) {
    AdaptiveState state;
    state.counts = CountsOf(file);
    const std::vector<uint32_t>* wanted = file.UintChannel(kWantedName);
    if (wanted == nullptr) return state;
    state.wanted = *wanted;
    const std::string stage = TextAttribute(file, kAttributeStage);
    const size_t space = std::min(stage.find(' '), stage.size());
    try {
        state.stages = {ParseCount(stage.substr(0, space)),
                        ParseCount(stage.substr(std::min(space + 1, stage.size())))};
    } catch (const Error& error) {
        throw MakeError(ErrorKind::BadInput, "{}: {}", kAttributeStage, error.what());
    }
    for (uint32_t base = kFirstBase; base <= kLastStage; base *= 2) {
        const auto* variance = file.FloatChannel(std::string(kVariancePrefix) + std::to_string(base));
        const auto* mean = file.FloatChannel(std::string(kMeanPrefix) + std::to_string(base));
        if (variance != nullptr && mean != nullptr) state.noted[base] = {*variance, *mean};
    }
    return state;
}

void ReadCounts(const image::ExrImage& file, RenderFile& render) {
    render.adaptive = AdaptiveStateOf(file);
    if (const std::string flaw = FlawOfCounts(render); !flaw.empty()) throw Error(ErrorKind::BadInput, flaw);
}

SampleRanges SamplesOf(const image::ExrImage& file) {
    const std::string text = TextAttribute(file, kAttributeSampleRanges);
    if (text.empty())
        throw MakeError(ErrorKind::BadInput, "no attribute {}: not a render of this program",
                        kAttributeSampleRanges);
    SampleRanges samples = ParseSampleRanges(text);
    if (SampleCount(samples) > 0xFFFFFFFFu)
        throw MakeError(ErrorKind::BadInput, "{}: \"{}\" are more samples than can be counted",
                        kAttributeSampleRanges, text);
    return samples;
}

std::optional<MeasuredError> MeasuredErrorOf(const image::ExrImage& file) {
    const std::string text = TextAttribute(file, kAttributeMeasuredError);
    if (text.empty()) return std::nullopt;
    const size_t space = std::min(text.find(' '), text.size() - 1);
    try {
        return MeasuredError{ParseCount(text.substr(0, space), 1), ParseNumber(text.substr(space + 1), 0.0)};
    } catch (const Error& error) {
        throw MakeError(ErrorKind::BadInput, "{}: {}", kAttributeMeasuredError, error.what());
    }
}

void ReadRemovedLight(const image::ExrImage& file, SumsReader& sums, RenderFile& render) {
    for (const Bias bias : kBiases) {
        const size_t i = static_cast<size_t>(bias);
        const bool hasVariance = ReadColorChannels(file, VarianceChannels(bias), render.removedVariance[i]);
        if (hasVariance != !render.removed[i].empty())
            throw MakeError(ErrorKind::BadInput, "of {} there is one of mean and variance, not both",
                            Name(AovOf(bias)));
        if (!hasVariance) continue;
        const std::string count = TextAttribute(file, kAttributeRemovedSamples);
        try {
            render.removedSamples = ParseCount(count);
        } catch (const Error& error) {
            throw MakeError(ErrorKind::BadInput, "{}: {}", kAttributeRemovedSamples, error.what());
        }
        render.sums.removed[i] = sums.Take(MeanChannels(AovOf(bias)), render.removed[i],
                                           render.removedVariance[i], {render.removedSamples});
    }
}

void ReadMotion(const image::ExrImage& file, std::vector<float>& motion) {
    const std::vector<float>*x = file.FloatChannel(kMotionNames[0]), *y = file.FloatChannel(kMotionNames[1]);
    if ((x == nullptr) != (y == nullptr))
        throw MakeError(ErrorKind::BadInput, "of {} and {} there is one, not both", kMotionNames[0],
                        kMotionNames[1]);
    if (x == nullptr) return;
    motion.resize(2 * x->size());
    for (size_t i = 0; i < x->size(); ++i) {
        motion[2 * i] = (*x)[i];
        motion[2 * i + 1] = (*y)[i];
    }
}

// The one of an AOV: a RenderFile has the means and RenderSums their sums in members of the same names.
template <typename Owner>
auto MemberOf(Owner& owner, Aov aov) -> decltype(&owner.albedo) {
    const auto from = [&](Aov first) { return static_cast<size_t>(aov) - static_cast<size_t>(first); };
    if (aov == Aov::Albedo) return &owner.albedo;
    if (aov == Aov::Normal) return &owner.normal;
    if (aov < Aov::Emission) return nullptr;
    if (aov >= Aov::RemovedMaxDepth) return &owner.removed[from(Aov::RemovedMaxDepth)];
    return &owner.parts[from(Aov::Emission)];
}

// Returns the settings.
PictureSettings RequireWindow(const image::ExrImage& file, const RenderFile& render) {
    PictureSettings settings;
    try {
        settings = SettingsFrom(render.settings);
    } catch (const Error& error) {
        throw MakeError(ErrorKind::BadInput, "recorded setting {}", error.what());
    }
    const Extent2D recorded = RenderedPart(settings).Extent();
    if (recorded != render.size)
        throw MakeError(ErrorKind::BadInput, "the recorded size {} is not that of the picture, {}",
                        ToText(recorded), ToText(render.size));
    if (!(file.window == WindowOf(settings)))
        throw Error(ErrorKind::BadInput, "its data window is not where the recorded settings say");
    return settings;
}

// Settings that files of earlier versions have, and that do not change the picture.
bool IsLegacySetting(std::string_view name) {
    return name == "integrator-form" || name == "traversal";
}

RenderFile FromExr(const image::ExrImage& file) {
    RenderFile render;
    RequireFormat(file);
    render.samples = SamplesOf(file);
    render.size = {file.width, file.height};
    if (!ReadColorChannels(file, kRadianceNames, render.radiance))
        throw Error(ErrorKind::BadInput, "there is no float channel R");
    const std::string adaptive = std::string(kSettingPrefix) + "adaptive";
    std::vector<uint32_t> counts{static_cast<uint32_t>(SampleCount(render.samples))};
    if (TextAttribute(file, adaptive.c_str()) == "on")
        counts = CountsOf(file);
    else
        RequireUniformCounts(file, counts.front());
    ReadColorChannels(file, kVarianceNames, render.variance);
    SumsReader sums(file);
    render.sums.radiance = sums.Take(kRadianceNames, render.radiance, render.variance, counts);
    for (const Aov aov : kAovs) {
        Texels* mean = MeanOf(render, aov);
        if (mean == nullptr || !ReadColorChannels(file, MeanChannels(aov), *mean)) continue;
        if (aov < Aov::RemovedMaxDepth)
            *SumsOf(render.sums, aov) = sums.Take(MeanChannels(aov), *mean, {}, CountsOf(aov, counts));
    }
    ReadRemovedLight(file, sums, render);
    if (const std::vector<float>* depth = file.FloatChannel("Z")) render.depth = *depth;
    for (const IdChannel& channel : kIdChannels)
        if (const std::vector<uint32_t>* ids = file.UintChannel(channel.name)) render.*channel.ids = *ids;
    ReadMotion(file, render.motion);

    render.measuredError = MeasuredErrorOf(file);
    render.version = TextAttribute(file, kAttributeVersion);
    render.device = TextAttribute(file, kAttributeDevice);
    render.driver = TextAttribute(file, kAttributeDriver);
    render.sceneFile = TextAttribute(file, kAttributeScene);
    render.sceneHash = TextAttribute(file, kAttributeSceneHash);
    render.environmentFile = TextAttribute(file, kAttributeEnvironment);
    render.environmentHash = TextAttribute(file, kAttributeEnvironmentHash);
    for (const auto& [attribute, value] : file.attributes) {
        if (!attribute.starts_with(kSettingPrefix)) continue;
        const std::string name = attribute.substr(kSettingPrefix.size());
        if (IsLegacySetting(name)) continue;
        // The effect of an unknown setting is not known, so its samples must not be mixed with others
        if (!IsSetting(name))
            throw MakeError(ErrorKind::BadInput, "setting {} is of a newer version", Printable(name));
        render.settings[name] = TextAttribute(file, attribute.c_str());
    }
    // Files that do not say are from before there was one
    render.settings.try_emplace(std::string(kLightSetting), Name(DefaultLight::None));
    const PictureSettings settings = RequireWindow(file, render);
    if (settings.isAdaptive) ReadCounts(file, render);
    for (const ChannelNames& names : GroupChannels(render.settings)) {
        if (!ReadColorChannels(file, names, render.lightGroups.emplace_back()))
            throw MakeError(ErrorKind::BadInput, "there is no float channel {}", names[0]);
        render.sums.lightGroups.push_back(sums.Take(names, render.lightGroups.back(), {}, counts));
    }
    sums.RequireDigest();
    return render;
}

}  // namespace

Texels* MeanOf(RenderFile& render, Aov aov) {
    return MemberOf(render, aov);
}

const Texels* MeanOf(const RenderFile& render, Aov aov) {
    return MemberOf(render, aov);
}

passes::ExactSums* SumsOf(RenderSums& sums, Aov aov) {
    return MemberOf(sums, aov);
}

const passes::ExactSums* SumsOf(const RenderSums& sums, Aov aov) {
    return MemberOf(sums, aov);
}

std::string FirstMissingChannel(const RenderFile& render, const AovSet& others) {
    if (render.sums.radiance.IsEmpty()) return WordChannel(kRadianceNames[0], "sum", 0);
    if (render.sums.radiance.HasSquares() && render.variance.empty()) return kVarianceNames[0];
    if (!render.sums.radiance.HasSquares() && !render.variance.empty())
        return WordChannel(kRadianceNames[0], "squares", 0);
    for (const Aov aov : kAovs)
        if (const Texels* mean = MeanOf(render, aov);
            mean && !mean->empty() && !others.Has(aov) && SumsOf(render.sums, aov)->IsEmpty())
            return WordChannel(MeanChannels(aov)[0], "sum", 0);
    for (size_t i = 0; i < render.lightGroups.size(); ++i)
        if (i >= render.sums.lightGroups.size() || render.sums.lightGroups[i].IsEmpty())
            return WordChannel(GroupChannels(render.settings).at(i)[0], "sum", 0);
    return {};
}

bool HasSums(const RenderFile& render, const AovSet& others) {
    return FirstMissingChannel(render, others).empty();
}

AovSet AovsOf(const RenderFile& render) {
    AovSet aovs;
    for (const Aov aov : kAovs)
        if (const Texels* mean = MeanOf(render, aov)) aovs.Set(aov, !mean->empty());
    aovs.Set(Aov::Depth, !render.depth.empty());
    aovs.Set(Aov::Instance, !render.instance.empty());
    aovs.Set(Aov::Material, !render.material.empty());
    aovs.Set(Aov::Motion, !render.motion.empty());
    return aovs;
}

void KeepOnly(RenderFile& render, const AovSet& aovs) {
    for (const Aov aov : kAovs)
        if (Texels* mean = MeanOf(render, aov); mean && !aovs.Has(aov)) {
            mean->clear();
            *SumsOf(render.sums, aov) = {};
        }
    for (const Bias bias : kBiases)
        if (!aovs.Has(AovOf(bias))) render.removedVariance[static_cast<size_t>(bias)].clear();
    if (!aovs.Has(Aov::Depth)) render.depth.clear();
    if (!aovs.Has(Aov::Instance)) render.instance.clear();
    if (!aovs.Has(Aov::Material)) render.material.clear();
    if (!aovs.Has(Aov::Motion)) render.motion.clear();
}

RenderFile ReadRenderFile(const std::filesystem::path& path, const Log& log) {
    const Stopwatch watch;
    const image::ExrImage file = AsInput([&] { return image::ReadExr(path); });
    try {
        RenderFile render = FromExr(file);
        LogTransfer(log, path, render, "read", watch);
        return render;
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}: {}", path, Printable(error.what(), 1024));
    }
}

std::string FirstMismatch(const RenderFile& a, const RenderFile& b) {
    const auto differ = [](const char* what, const std::string& inA, const std::string& inB) {
        return Text("{}: {} against {}", what, inA.empty() ? "none" : inA, inB.empty() ? "none" : inB);
    };
    if (std::string difference = FirstDifference(a.settings, b.settings); !difference.empty())
        return difference;
    if (a.sceneFile != b.sceneFile) return differ("scene", a.sceneFile, b.sceneFile);
    if (a.environmentFile != b.environmentFile)
        return differ("environment", a.environmentFile, b.environmentFile);
    if (a.sceneHash.empty() || b.sceneHash.empty())
        return Text("scene: {} was saved by the editor, perhaps with edits that are in no file", a.sceneFile);
    if (a.sceneHash != b.sceneHash) return Text("scene: the content of {} has changed", a.sceneFile);
    if (a.environmentHash != b.environmentHash)
        return Text("environment: the content of {} has changed", a.environmentFile);
    return {};
}

}  // namespace raygraph::session
