#include "editor/session/render_file.h"

#include <algorithm>
#include <span>

#include "base/check.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/session/as_input.h"
#include "editor/session/parse.h"
#include "editor/session/render_flaws.h"
#include "editor/session/setting_table.h"
#include "renderer/image/exr.h"

namespace raygraph::session {

namespace {

// Of the channels and attributes together. 1, which had no such attribute: means alone, without sums.
// 2: scenes had another hash.
constexpr std::string_view kFormat = "3";

// Attributes. Settings are stored as the texts of their options: "raygraph.setting.seed" = "1".
constexpr const char* kAttributeFormat = "raygraph.format";
constexpr const char* kAttributeVersion = "raygraph.version";
constexpr const char* kAttributeDevice = "raygraph.device";
constexpr const char* kAttributeDriver = "raygraph.driver";
constexpr const char* kAttributeScene = "raygraph.scene";
constexpr const char* kAttributeSceneHash = "raygraph.sceneHash";
constexpr const char* kAttributeEnvironment = "raygraph.environment";
constexpr const char* kAttributeEnvironmentHash = "raygraph.environmentHash";
constexpr const char* kAttributeSamples = "raygraph.samples";                // decimal: how many
constexpr const char* kAttributeSampleOffset = "raygraph.sampleOffset";      // decimal: index of the first
constexpr const char* kAttributeSampleRanges = "raygraph.sampleRanges";      // "0-63 128-191": which
constexpr const char* kAttributeRemovedSamples = "raygraph.removedSamples";  // decimal: traced twice
constexpr std::string_view kSettingPrefix = "raygraph.setting.";

constexpr const char* kRadianceNames[] = {"R", "G", "B", "A"};
constexpr const char* kVarianceNames[] = {"variance.R", "variance.G", "variance.B"};
constexpr const char* kMotionNames[] = {"motion.X", "motion.Y"};

// Of an AOV that is a mean.
using ChannelNames = std::array<std::string, 3>;
ChannelNames ColorChannels(const std::string& name) {
    return {name + ".R", name + ".G", name + ".B"};
}

ChannelNames MeanChannels(Aov aov) {
    if (aov == Aov::Normal) return {"N.X", "N.Y", "N.Z"};
    return ColorChannels(Name(aov));
}

// Of the groups of lights that a render of these settings has.
std::vector<ChannelNames> GroupChannels(const SettingTexts& settings) {
    std::vector<ChannelNames> channels;
    for (const std::string& name : LightGroupNames(SettingsFrom(settings).lightGroups))
        channels.push_back(ColorChannels("light." + name));
    return channels;
}

// Of what a bias removed.
ChannelNames VarianceChannels(Bias bias) {
    return ColorChannels(std::string(Name(AovOf(bias))) + ".variance");
}

// "albedo.R" becomes "albedo.sum0.R", "R" becomes "sum0.R".
std::string WordChannel(const std::string& channel, const char* what, size_t word) {
    std::string name = channel;
    return name.insert(name.rfind('.') + 1, Text("{}{}.", what, word));
}

// Word k of the squares of channel c lies in this plane, in component c or, of the highest word, 3.
size_t SquarePlane(size_t k, size_t c) {
    return k < passes::ExactSums::kPlanes ? k : c;
}
size_t SquareComponent(size_t k, size_t c) {
    return k < passes::ExactSums::kPlanes ? c : 3;
}

struct IdChannel {
    const char* name;
    std::vector<uint32_t> RenderFile::*ids;
};
constexpr IdChannel kIdChannels[] = {{"id.instance", &RenderFile::instance},
                                     {"id.material", &RenderFile::material}};

// Puts the channels of these names into RGBA texels; false if the first of them is not there.
template <typename Names>
bool TakeChannels(const image::ExrImage& file, const Names& names, Texels& texels) {
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

// The same with the words of their sums, and with those of their squares.
template <typename Names>
bool TakeSums(const image::ExrImage& file, const Names& names, bool withSquares, passes::ExactSums& sums) {
    if (file.UintChannel(WordChannel(names[0], "sum", 0)) == nullptr) return false;
    sums = passes::MakeExactSums(size_t{file.width} * file.height, withSquares);
    const auto take = [&](const std::string& name, passes::ExactSums::Plane& plane, size_t component) {
        const std::vector<uint32_t>* words = file.UintChannel(name);
        if (words == nullptr)
            throw MakeError(ErrorKind::BadInput, "there are sums of samples but no channel {}", name);
        for (size_t i = 0; i < words->size(); ++i) plane[4 * i + component] = (*words)[i];
    };
    for (size_t c = 0; c < std::size(names); ++c)
        for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k)
            take(WordChannel(names[c], "sum", k), sums.sums[k], c);
    for (size_t c = 0; c < 3 && withSquares; ++c)
        for (size_t k = 0; k <= passes::ExactSums::kPlanes; ++k)
            take(WordChannel(names[c], "squares", k), sums.squares[SquarePlane(k, c)], SquareComponent(k, c));
    return true;
}

std::string TextAttribute(const image::ExrImage& file, const char* name) {
    const auto attribute = file.attributes.find(name);
    if (attribute == file.attributes.end()) return {};
    const std::string* text = std::get_if<std::string>(&attribute->second);
    if (text == nullptr) throw MakeError(ErrorKind::BadInput, "attribute {} is not a text", name);
    return *text;
}

void RequireFormat(const image::ExrImage& file) {
    const std::string format = TextAttribute(file, kAttributeFormat);
    if (format == kFormat) return;
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

// Every pixel has as many samples, so far.
void RequireEven(const image::ExrImage& file, uint64_t sampleCount) {
    const std::vector<uint32_t>* counts = file.UintChannel("samples");
    if (counts == nullptr) throw Error(ErrorKind::BadInput, "there is no uint channel samples");
    for (const uint32_t count : *counts)
        if (count != sampleCount)
            throw MakeError(ErrorKind::BadInput, "a pixel has {} samples, the render {}", count, sampleCount);
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

void TakeRemoved(const image::ExrImage& file, RenderFile& render) {
    for (const Bias bias : kBiases) {
        const size_t i = static_cast<size_t>(bias);
        const bool hasVariance = TakeChannels(file, VarianceChannels(bias), render.removedVariance[i]);
        if (hasVariance != !render.removed[i].empty())
            throw MakeError(ErrorKind::BadInput, "of {} there is one of mean and variance, not both",
                            Name(AovOf(bias)));
        if (!hasVariance) continue;
        TakeSums(file, MeanChannels(AovOf(bias)), true, render.sums.removed[i]);
        const std::string count = TextAttribute(file, kAttributeRemovedSamples);
        try {
            render.removedSamples = ParseCount(count);
        } catch (const Error& error) {
            throw MakeError(ErrorKind::BadInput, "{}: {}", kAttributeRemovedSamples, error.what());
        }
    }
}

void TakeMotion(const image::ExrImage& file, std::vector<float>& motion) {
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

// `done`: "read" or "written".
void SayHow(const Log& log, const std::filesystem::path& path, const RenderFile& render, const char* done,
            const Stopwatch& watch) {
    Say(log, LogLevel::Info, log_category::kScene, "{}: {} samples of {} pixels {} in {}",
        Printable(path.filename().string()), SampleCount(render.samples), ToText(render.size), done,
        DurationText(watch.Seconds()));
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

// Where the file says that its pixels are in the picture, as the settings do.
image::ExrWindow WindowOf(const PictureSettings& settings) {
    const passes::Region part = RenderedPart(settings);
    return {static_cast<int32_t>(part.x), static_cast<int32_t>(part.y), settings.size.width,
            settings.size.height};
}

void RequireWindow(const image::ExrImage& file, const RenderFile& render) {
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
}

RenderFile FromExr(const image::ExrImage& file) {
    RenderFile render;
    RequireFormat(file);
    render.samples = SamplesOf(file);
    render.size = {file.width, file.height};
    if (!TakeChannels(file, kRadianceNames, render.radiance))
        throw Error(ErrorKind::BadInput, "there is no float channel R");
    RequireEven(file, SampleCount(render.samples));
    const bool hasVariance = TakeChannels(file, kVarianceNames, render.variance);
    TakeSums(file, kRadianceNames, hasVariance, render.sums.radiance);
    for (const Aov aov : kAovs) {
        Texels* mean = MeanOf(render, aov);
        if (mean == nullptr || !TakeChannels(file, MeanChannels(aov), *mean)) continue;
        if (aov < Aov::RemovedMaxDepth) TakeSums(file, MeanChannels(aov), false, *SumsOf(render.sums, aov));
    }
    TakeRemoved(file, render);
    if (const std::vector<float>* depth = file.FloatChannel("Z")) render.depth = *depth;
    for (const IdChannel& channel : kIdChannels)
        if (const std::vector<uint32_t>* ids = file.UintChannel(channel.name)) render.*channel.ids = *ids;
    TakeMotion(file, render.motion);

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
        // What it changes in the picture is not known here: its samples are not to be mixed with others
        if (!IsSetting(name))
            throw MakeError(ErrorKind::BadInput, "setting {} is of a newer version", Printable(name));
        render.settings[name] = TextAttribute(file, attribute.c_str());
    }
    RequireWindow(file, render);
    for (const ChannelNames& names : GroupChannels(render.settings)) {
        if (!TakeChannels(file, names, render.lightGroups.emplace_back()))
            throw MakeError(ErrorKind::BadInput, "there is no float channel {}", names[0]);
        TakeSums(file, names, false, render.sums.lightGroups.emplace_back());
    }
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

void WriteRenderFile(const std::filesystem::path& path, const RenderFile& render, const Log& log) {
    const Stopwatch watch;
    if (const std::string flaw = FirstFlaw(render); !flaw.empty())
        throw MakeError(ErrorKind::Usage, "{}: the render cannot be written: {}", path.string(), flaw);
    std::vector<image::ExrPlane> planes;
    const auto add = [&](const std::string& name, const Texels& texels, size_t c) {
        planes.push_back({name, std::span<const float>(texels).subspan(c), 4});
    };
    const auto addWords = [&](const std::string& name, const passes::ExactSums::Plane& plane, size_t c) {
        planes.push_back({name, std::span<const uint32_t>(plane).subspan(c), 4});
    };
    const auto addSums = [&](const auto& names, const passes::ExactSums& sums) {
        for (size_t c = 0; c < std::size(names) && !sums.IsEmpty(); ++c)
            for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k)
                addWords(WordChannel(names[c], "sum", k), sums.sums[k], c);
        for (size_t c = 0; c < 3 && sums.HasSquares(); ++c)
            for (size_t k = 0; k <= passes::ExactSums::kPlanes; ++k)
                addWords(WordChannel(names[c], "squares", k), sums.squares[SquarePlane(k, c)],
                         SquareComponent(k, c));
    };
    for (size_t c = 0; c < 4; ++c) add(kRadianceNames[c], render.radiance, c);
    for (size_t c = 0; c < 3 && !render.variance.empty(); ++c) add(kVarianceNames[c], render.variance, c);
    addSums(kRadianceNames, render.sums.radiance);
    for (const Aov aov : kAovs) {
        const Texels* mean = MeanOf(render, aov);
        if (mean == nullptr || mean->empty()) continue;
        for (size_t c = 0; c < 3; ++c) add(MeanChannels(aov)[c], *mean, c);
        addSums(MeanChannels(aov), *SumsOf(render.sums, aov));
    }
    if (!render.lightGroups.empty()) {
        const std::vector<ChannelNames> names = GroupChannels(render.settings);
        RG_CHECK_EQ(names.size(), render.lightGroups.size());
        for (size_t i = 0; i < names.size(); ++i) {
            for (size_t c = 0; c < 3; ++c) add(names[i][c], render.lightGroups[i], c);
            if (!render.sums.lightGroups.empty()) addSums(names[i], render.sums.lightGroups[i]);
        }
    }
    bool hasRemoved = false;
    for (const Bias bias : kBiases) {
        const Texels& variance = render.removedVariance[static_cast<size_t>(bias)];
        hasRemoved |= !variance.empty();
        for (size_t c = 0; c < 3 && !variance.empty(); ++c) add(VarianceChannels(bias)[c], variance, c);
    }
    if (!render.depth.empty()) planes.push_back({"Z", std::span<const float>(render.depth)});
    for (const IdChannel& channel : kIdChannels)
        if (!(render.*channel.ids).empty())
            planes.push_back({channel.name, std::span<const uint32_t>(render.*channel.ids)});
    for (size_t c = 0; c < 2 && !render.motion.empty(); ++c)
        planes.push_back({kMotionNames[c], std::span<const float>(render.motion).subspan(c), 2});
    const std::string sampleCount = std::to_string(SampleCount(render.samples));
    const std::vector<uint32_t> samples(PixelCount(render.size),
                                        static_cast<uint32_t>(SampleCount(render.samples)));
    planes.push_back({"samples", std::span<const uint32_t>(samples)});

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
    if (hasRemoved) attributes[kAttributeRemovedSamples] = std::to_string(render.removedSamples);
    for (const auto& [name, text] : render.settings) attributes[std::string(kSettingPrefix) + name] = text;
    image::WriteExr(path, render.size.width, render.size.height, planes, attributes,
                    WindowOf(SettingsFrom(render.settings)));
    SayHow(log, path, render, "written", watch);
}

RenderFile ReadRenderFile(const std::filesystem::path& path, const Log& log) {
    const Stopwatch watch;
    const image::ExrImage file = AsInput([&] { return image::ReadExr(path); });
    try {
        RenderFile render = FromExr(file);
        SayHow(log, path, render, "read", watch);
        return render;
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}: {}", path.string(), Printable(error.what(), 1024));
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
