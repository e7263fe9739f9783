#include "editor/session/file/render_file.h"

#include <algorithm>
#include <deque>
#include <span>
#include <utility>

#include "base/check.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/session/file/render_file_parts.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/setting_table.h"
#include "renderer/image/exr.h"

namespace raygraph::session {

namespace {

// Puts the channels of these names into RGBA texels. Returns false if the first of them is missing.
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

// Reads the sums of a file, one picture after another.
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

    // Must be called after the last Take. Throws unless the sums have the digest of the file.
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

// Requires equally many samples of all pixels, unless the render is adaptive.
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

// Returns a count in an attribute; 0 without it.
uint32_t CountAttribute(const image::ExrImage& file, const char* name) {
    const std::string text = TextAttribute(file, name);
    if (text.empty()) return 0;
    try {
        return ParseCount(text);
    } catch (const Error& error) {
        throw MakeError(ErrorKind::BadInput, "{}: {}", name, error.what());
    }
}

void ReadDenoising(const image::ExrImage& file, RenderFile& render) {
    for (const auto& [names, plane] : DenoisingChannels())
        ReadColorChannels(file, names, render.denoising.*plane);
    render.denoising.firstSamples = CountAttribute(file, kAttributeFirstHalfSamples);
    if (const std::string flaw = FlawOfDenoising(render); !flaw.empty())
        throw Error(ErrorKind::BadInput, flaw);
}

void ReadRemovedLight(const image::ExrImage& file, SumsReader& sums, RenderFile& render) {
    for (const Bias bias : kBiases) {
        const size_t i = static_cast<size_t>(bias);
        const bool hasVariance = ReadColorChannels(file, VarianceChannels(bias), render.removedVariance[i]);
        if (hasVariance != !render.removed[i].empty())
            throw MakeError(ErrorKind::BadInput, "of {} there is one of mean and variance, not both",
                            Name(AovOf(bias)));
        if (!hasVariance) continue;
        render.removedSamples = CountAttribute(file, kAttributeRemovedSamples);
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

// Returns the member of an AOV: a RenderFile has the means and RenderSums their sums in members of the same
// names.
template <typename Owner>
auto MemberOf(Owner& owner, Aov aov) -> decltype(&owner.albedo) {
    const auto from = [&](Aov first) { return static_cast<size_t>(aov) - static_cast<size_t>(first); };
    if (aov == Aov::Albedo) return &owner.albedo;
    if (aov == Aov::Normal) return &owner.normal;
    if (aov < Aov::Emission) return nullptr;
    if (aov >= Aov::RemovedMaxDepth) return &owner.removed[from(Aov::RemovedMaxDepth)];
    return &owner.parts[from(Aov::Emission)];
}

// Returns the render's settings, and requires that the file has its picture where they say.
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

// Returns whether files of earlier versions have this setting, which does not change the picture.
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
    ReadDenoising(file, render);
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
    // Files without this setting are older than it
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
    aovs.Set(Aov::Denoising, !render.denoising.albedo.empty());
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
    if (!aovs.Has(Aov::Denoising)) render.denoising = {};
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
    std::deque<SumResiduals> residuals;  // keep their place, since the planes are spans of them
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
    for (size_t c = 0; c < 3 && !render.denoised.empty(); ++c) add(kDenoisedNames[c], render.denoised, c);
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
    for (const auto& [names, plane] : DenoisingChannels())
        for (size_t c = 0; c < 3 && !(render.denoising.*plane).empty(); ++c)
            add(names[c], render.denoising.*plane, c);
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
    if (render.denoising.firstSamples > 0)
        attributes[kAttributeFirstHalfSamples] = std::to_string(render.denoising.firstSamples);
    if (hasRemoved) attributes[kAttributeRemovedSamples] = std::to_string(render.removedSamples);
    if (render.measuredError && render.measuredError->relativeError)
        attributes[kAttributeMeasuredError] =
            Text("{} {}", render.measuredError->samples, *render.measuredError->relativeError);
    for (const auto& [name, text] : render.settings) attributes[std::string(kSettingPrefix) + name] = text;
    const uint64_t clamped = image::WriteExr(path, render.size.width, render.size.height, planes, attributes,
                                             WindowOf(SettingsFrom(render.settings)));
    if (clamped > 0)
        WriteLog(log, LogLevel::Warning, log_category::kScene,
                 "{}: {} {} beyond 65504, the most that a half float holds",
                 Printable(path.filename().string()), clamped, clamped == 1 ? "number was" : "numbers were");
    LogTransfer(log, path, render, "written", watch);
}

// --- Flaws of a render that was not read from a file ---

namespace {

std::string FlawOf(const SampleRanges& samples) {
    if (samples.empty()) return "it has no samples";
    uint64_t end = 0;
    for (const SampleRange& range : samples) {
        if (range.count == 0) return "it has a range of no samples";
        if (range.first < end)
            return Text("its sample ranges are out of order or overlap: {}", ToText(samples));
        end = range.End();
    }
    if (end > uint64_t{1} << 32) return Text("its sample {} is beyond the last, 4294967295", end - 1);
    if (SampleCount(samples) > 0xFFFFFFFFu) return "it has more samples than can be counted";
    return {};
}

// Checks a plane that may be missing.
template <typename T>
std::string FlawOf(const std::string& name, const std::vector<T>& plane, uint64_t size) {
    if (plane.empty() || plane.size() == size) return {};
    return Text("its {} has {} values, not {}", name, plane.size(), size);
}

std::string FlawOf(const std::string& name, const passes::ExactSums& sums, uint64_t size) {
    const auto isOfSize = [&](uint64_t wanted) {
        return [wanted](const passes::ExactSums::Plane& plane) { return plane.size() == wanted; };
    };
    if (std::ranges::all_of(sums.sums, isOfSize(sums.IsEmpty() ? 0 : size)) &&
        std::ranges::all_of(sums.squares, isOfSize(sums.HasSquares() ? size : 0)))
        return {};
    return Text("its sums of {} are not of its pixels", name);
}

// Checks all planes and their sums.
std::string FlawOfPlanes(const RenderFile& render) {
    const uint64_t pixels = PixelCount(render.size), texels = 4 * pixels;
    std::string flaw;
    const auto check = [&](const std::string& name, const auto& plane, uint64_t size) {
        if (flaw.empty()) flaw = FlawOf(name, plane, size);
    };
    if (render.radiance.empty()) return "it has no radiance";
    check("radiance", render.radiance, texels);
    check("radiance", render.sums.radiance, texels);
    check("variance", render.variance, texels);
    check("denoised picture", render.denoised, texels);
    for (const auto& [names, plane] : DenoisingChannels()) check(names[0], render.denoising.*plane, texels);
    if (flaw.empty()) flaw = FlawOfDenoising(render);
    for (const Aov aov : kAovs) {
        const Texels* mean = MeanOf(render, aov);
        if (mean == nullptr) continue;
        check(Name(aov), *mean, texels);
        check(Name(aov), *SumsOf(render.sums, aov), texels);
    }
    for (const Bias bias : kBiases) {
        const size_t i = static_cast<size_t>(bias);
        check(std::string(Name(AovOf(bias))) + ".variance", render.removedVariance[i], texels);
        if (flaw.empty() && render.removed[i].empty() != render.removedVariance[i].empty())
            flaw = Text("of {} it has one of mean and variance, not both", Name(AovOf(bias)));
    }
    for (const Texels& group : render.lightGroups) {
        if (flaw.empty() && group.empty()) flaw = "one of its groups of lights is empty";
        check("light of a group", group, texels);
    }
    for (const passes::ExactSums& sums : render.sums.lightGroups) check("groups of lights", sums, texels);
    check("depth", render.depth, pixels);
    check("instance", render.instance, pixels);
    check("material", render.material, pixels);
    check("motion", render.motion, 2 * pixels);
    return flaw;
}

}  // namespace

void RequireReadable(const PictureSettings& settings) {
    const PictureSettings reread = SettingsFrom(Texts(settings));
    if (reread.lightGroups != settings.lightGroups)
        throw SettingError(ErrorKind::Usage, Text("light-group: {}: a pattern holds a comma or a semicolon",
                                                  Printable(ToText(settings.lightGroups))));
}

std::string FirstFlaw(const RenderFile& render) {
    if (std::string flaw = FlawOf(render.samples); !flaw.empty()) return flaw;
    for (const auto& [name, text] : render.settings)
        if (!IsSetting(name)) return Text("its setting {} is not known", Printable(name));
    PictureSettings settings;
    try {
        settings = SettingsFrom(render.settings);
    } catch (const SettingError& error) {
        return std::string("its setting ") + error.what();
    }
    if (const Extent2D recorded = RenderedPart(settings).Extent(); recorded != render.size)
        return Text("its recorded size {} is not that of the picture, {}", ToText(recorded),
                    ToText(render.size));
    const size_t groups = LightGroupNames(settings.lightGroups).size();
    if (render.lightGroups.size() != groups ||
        (!render.sums.lightGroups.empty() && render.sums.lightGroups.size() != groups))
        return Text("it has {} groups of lights with {} sums; its settings name {}",
                    render.lightGroups.size(), render.sums.lightGroups.size(), groups);
    if (settings.isAdaptive != render.adaptive.has_value())
        return "its settings and its counts of samples do not agree on whether it is adaptive";
    if (std::string flaw = FlawOfCounts(render); !flaw.empty()) return flaw;
    return FlawOfPlanes(render);
}

std::string FlawOfDenoising(const RenderFile& render) {
    const DenoisingPlanes& planes = render.denoising;
    if (planes.albedo.empty() != planes.normal.empty() || planes.seen.empty() != planes.seenByAll.empty() ||
        planes.seen.empty() != planes.seenSquares.empty() ||
        planes.firstHalf.empty() != (planes.firstSamples == 0) ||
        (planes.albedo.empty() && !(planes.seen.empty() && planes.firstHalf.empty())))
        return "its channels of --aov denoising are incomplete";
    if (planes.firstSamples > 0 && planes.firstSamples >= SampleCount(render.samples))
        return Text("the first half has {} of its {} samples", planes.firstSamples,
                    SampleCount(render.samples));
    return {};
}

std::string FlawOfCounts(const RenderFile& render) {
    if (!render.adaptive) return {};
    if (std::string flaw = FlawOf(*render.adaptive, {render.size.width, render.size.height}); !flaw.empty())
        return flaw;
    const uint32_t average = render.adaptive->Average();
    if (render.samples.size() == 1 && average == render.samples.front().count) return {};
    return Text("its pixels have {} samples on average, and it says {}", average, ToText(render.samples));
}

// --- Sums ---

namespace {

void Add(passes::ExactSums& sums, passes::ExactSums&& others) {
    if (sums.IsEmpty())
        sums = std::move(others);
    else if (!others.IsEmpty())
        passes::AddSums(sums, others);
}

}  // namespace

void Add(RenderSums& sums, RenderSums&& others) {
    Add(sums.radiance, std::move(others.radiance));
    for (const Aov aov : kAovs)
        if (passes::ExactSums* of = SumsOf(sums, aov)) Add(*of, std::move(*SumsOf(others, aov)));
    for (size_t i = 0; i < sums.lightGroups.size(); ++i)
        Add(sums.lightGroups[i], std::move(others.lightGroups[i]));
}

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

std::vector<passes::ExactSums*> AllOf(RenderSums& sums) {
    std::vector<passes::ExactSums*> all{&sums.radiance, &sums.albedo, &sums.normal};
    for (passes::ExactSums& part : sums.parts) all.push_back(&part);
    for (passes::ExactSums& removed : sums.removed) all.push_back(&removed);
    for (passes::ExactSums& group : sums.lightGroups) all.push_back(&group);
    return all;
}

}  // namespace raygraph::session
