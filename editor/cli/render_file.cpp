#include "editor/cli/render_file.h"

#include <span>

#include "base/error.h"
#include "editor/cli/exit_code.h"

namespace raygraph::cli {

namespace {

// Attributes. Settings are stored as the texts of their options: "raygraph.setting.seed" = "1".
constexpr const char* kAttributeVersion = "raygraph.version";
constexpr const char* kAttributeDevice = "raygraph.device";
constexpr const char* kAttributeDriver = "raygraph.driver";
constexpr const char* kAttributeScene = "raygraph.scene";
constexpr const char* kAttributeSceneHash = "raygraph.sceneHash";
constexpr const char* kAttributeEnvironment = "raygraph.environment";
constexpr const char* kAttributeEnvironmentHash = "raygraph.environmentHash";
constexpr const char* kAttributeSamples = "raygraph.samples";            // decimal: how many
constexpr const char* kAttributeSampleOffset = "raygraph.sampleOffset";  // decimal: index of the first
constexpr const char* kAttributeSampleRanges = "raygraph.sampleRanges";  // "0-63 128-191": which
constexpr std::string_view kSettingPrefix = "raygraph.setting.";

struct Group {
    const char* names[3];
    Texels RenderFile::*texels;
};
constexpr Group kGroups[] = {
    {{"variance.R", "variance.G", "variance.B"}, &RenderFile::variance},
    {{"albedo.R", "albedo.G", "albedo.B"}, &RenderFile::albedo},
    {{"N.X", "N.Y", "N.Z"}, &RenderFile::normal},
};
constexpr const char* kRadianceNames[] = {"R", "G", "B", "A"};

struct IdChannel {
    const char* name;
    std::vector<uint32_t> RenderFile::*ids;
};
constexpr IdChannel kIdChannels[] = {{"id.instance", &RenderFile::instance},
                                     {"id.material", &RenderFile::material}};

// Puts the channels of these names into RGBA texels; false if the first of them is not there.
bool TakeChannels(const image::ExrImage& file, std::span<const char* const> names, Texels& texels) {
    if (file.FloatChannel(names[0]) == nullptr) return false;
    texels.assign(size_t{4} * file.width * file.height, 0.0f);
    for (size_t c = 0; c < names.size(); c++) {
        const std::vector<float>* channel = file.FloatChannel(names[c]);
        if (channel == nullptr)
            throw Error(ErrorKind::BadInput, std::string("there is ") + names[0] + " but no " + names[c]);
        for (size_t i = 0; i < channel->size(); i++) texels[4 * i + c] = (*channel)[i];
    }
    return true;
}

std::string TextAttribute(const image::ExrImage& file, const char* name) {
    const auto attribute = file.attributes.find(name);
    if (attribute == file.attributes.end()) return {};
    const std::string* text = std::get_if<std::string>(&attribute->second);
    if (text == nullptr)
        throw Error(ErrorKind::BadInput, std::string("attribute ") + name + " is not a text");
    return *text;
}

SampleRanges SamplesOf(const image::ExrImage& file) {
    const std::string text = TextAttribute(file, kAttributeSampleRanges);
    if (text.empty())
        throw Error(ErrorKind::BadInput,
                    std::string("no attribute ") + kAttributeSampleRanges + ": not a render of this program");
    SampleRanges samples = ParseSampleRanges(text);
    if (SampleCount(samples) > 0xFFFFFFFFu)
        throw Error(ErrorKind::BadInput, std::string(kAttributeSampleRanges) + ": \"" + text +
                                             "\" are more samples than can be counted");
    return samples;
}

RenderFile FromExr(const image::ExrImage& file) {
    RenderFile render;
    render.samples = SamplesOf(file);
    render.size = {file.width, file.height};
    if (!TakeChannels(file, kRadianceNames, render.radiance))
        throw Error(ErrorKind::BadInput, "there is no float channel R");
    for (const Group& group : kGroups) TakeChannels(file, group.names, render.*group.texels);
    if (const std::vector<float>* depth = file.FloatChannel("Z")) render.depth = *depth;
    for (const IdChannel& channel : kIdChannels)
        if (const std::vector<uint32_t>* ids = file.UintChannel(channel.name)) render.*channel.ids = *ids;

    render.version = TextAttribute(file, kAttributeVersion);
    render.device = TextAttribute(file, kAttributeDevice);
    render.driver = TextAttribute(file, kAttributeDriver);
    render.sceneFile = TextAttribute(file, kAttributeScene);
    render.sceneHash = TextAttribute(file, kAttributeSceneHash);
    render.environmentFile = TextAttribute(file, kAttributeEnvironment);
    render.environmentHash = TextAttribute(file, kAttributeEnvironmentHash);
    for (const PictureSetting& setting : PictureSettingTable()) {
        const std::string name = std::string(kSettingPrefix) + setting.name;
        if (file.attributes.contains(name)) render.settings[setting.name] = TextAttribute(file, name.c_str());
    }
    ImageSize recorded;
    try {
        recorded = SettingsFrom(render.settings).size;
    } catch (const Error& error) {
        throw Error(ErrorKind::BadInput, std::string("recorded setting ") + error.what());
    }
    if (recorded != render.size)
        throw Error(ErrorKind::BadInput, "the recorded size " + ToText(recorded) +
                                             " is not that of the picture, " + ToText(render.size));
    return render;
}

}  // namespace

void WriteRenderFile(const std::filesystem::path& path, const RenderFile& render) {
    std::vector<image::ExrPlane> planes;
    for (size_t c = 0; c < 4; c++)
        planes.push_back({kRadianceNames[c], std::span<const float>(render.radiance).subspan(c), 4});
    for (const Group& group : kGroups) {
        const Texels& texels = render.*group.texels;
        for (size_t c = 0; c < 3 && !texels.empty(); c++)
            planes.push_back({group.names[c], std::span<const float>(texels).subspan(c), 4});
    }
    if (!render.depth.empty()) planes.push_back({"Z", std::span<const float>(render.depth)});
    for (const IdChannel& channel : kIdChannels)
        if (!(render.*channel.ids).empty())
            planes.push_back({channel.name, std::span<const uint32_t>(render.*channel.ids)});
    const std::string sampleCount = std::to_string(SampleCount(render.samples));
    const std::vector<uint32_t> samples(render.size.PixelCount(),
                                        static_cast<uint32_t>(SampleCount(render.samples)));
    planes.push_back({"samples", std::span<const uint32_t>(samples)});

    image::ExrAttributes attributes;
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
    for (const auto& [name, text] : render.settings) attributes[std::string(kSettingPrefix) + name] = text;
    image::WriteExr(path, render.size.width, render.size.height, planes, attributes);
}

RenderFile ReadRenderFile(const std::filesystem::path& path) {
    const image::ExrImage file = AsInput([&] { return image::ReadExr(path); });
    try {
        return FromExr(file);
    } catch (const Error& error) {
        throw Error(error.Kind(), path.string() + ": " + error.what());
    }
}

std::string FirstMismatch(const RenderFile& a, const RenderFile& b) {
    const auto differ = [](const char* what, const std::string& inA, const std::string& inB) {
        return std::string(what) + ": " + (inA.empty() ? "none" : inA) + " against " +
               (inB.empty() ? "none" : inB);
    };
    if (std::string difference = FirstDifference(a.settings, b.settings); !difference.empty())
        return difference;
    if (a.sceneFile != b.sceneFile) return differ("scene", a.sceneFile, b.sceneFile);
    if (a.environmentFile != b.environmentFile)
        return differ("environment", a.environmentFile, b.environmentFile);
    if (a.sceneHash != b.sceneHash) return "scene: the content of " + a.sceneFile + " has changed";
    if (a.environmentHash != b.environmentHash)
        return "environment: the content of " + a.environmentFile + " has changed";
    return {};
}

}  // namespace raygraph::cli
