#include "editor/session/settings/session_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/printable.h"
#include "base/text.h"
#include "base/version.h"
#include "editor/session/file/render_file_parts.h"

namespace raygraph::session {

namespace {

[[noreturn]] void RejectSetting(const std::string& setting, const std::string& why) {
    throw SettingError(ErrorKind::Usage, setting + ": " + why);
}

// A file records one choice, and a picture of another scene under it could never be made again.
void RequireChoice(const char* setting, const char* unnamed, const std::string& requested,
                   const std::string& loaded, const SceneInput& input) {
    if (loaded == requested) return;
    const auto called = [&](const std::string& choice) { return choice.empty() ? unnamed : Quoted(choice); };
    RejectSetting(setting, Text("{} of {} is to be rendered, but {} was loaded", called(requested),
                                Printable(input.file), called(loaded)));
}

void RequireScene(const SceneInput& input, const PictureSettings& settings) {
    if (settings.light == DefaultLight::Studio && !input.environmentFile.empty())
        RejectSetting("light",
                      Text("the studio takes the place of the map {}", Printable(input.environmentFile)));
    RequireChoice("scene", "the default one", settings.scene, input.scene, input);
    RequireChoice("variant", "none", settings.variant, input.variant, input);
    if (settings.at && !input.isAnimated)
        RejectSetting("at", Text("{} is a time, but {} was loaded without animations", AtText(settings.at),
                                 Printable(input.file)));
    if (!settings.at && input.isAnimated)
        RejectSetting("at",
                      Text("no time is given, but {} was loaded with animations", Printable(input.file)));
    if (!settings.at && !settings.clips.empty())
        RejectSetting("clips", "animations play at a time, and none is given");
    if (!settings.at && settings.shutter) RejectSetting("shutter", "it is around a time, and none is given");
    const auto requireRadius = [&](const char* setting, const scene::RoundRadius& requested,
                                   const scene::RoundRadius& loaded) {
        if (loaded != requested)
            RejectSetting(setting, Text("{} is to be rendered with {}, but was loaded with {}",
                                        Printable(input.file), ToText(requested), ToText(loaded)));
    };
    requireRadius("points", settings.pointsAndLines.points, input.pointsAndLines.points);
    requireRadius("lines", settings.pointsAndLines.lines, input.pointsAndLines.lines);
}

}  // namespace

void Reject(const std::string& why) {
    throw Error(ErrorKind::Usage, "Session: " + why);
}

void RequireValidDesc(const SessionDesc& desc) {
    const PictureSettings& settings = desc.settings;
    RequireReadable(settings);
    for (const Aov aov : kAovs)
        if (desc.aovs.Has(aov) && !CanHave(aov, settings))
            Reject(Text("the view {} with these biases has no {}", Name(settings.view), Name(aov)));
    if (settings.shutter && !passes::IsAverageable(settings.view))
        RejectSetting("shutter", Text("the view {} is not averaged over samples, so nothing is blurred",
                                      Name(settings.view)));
    if (settings.crop && !CanCrop(settings.view))
        RejectSetting("crop", Text("the view {} is drawn as a whole", Name(settings.view)));
    if (settings.light == DefaultLight::Studio && settings.background)
        RejectSetting("light", "the studio takes the place of a background");
    if (settings.hasGround && settings.view != View::PathTraced)
        RejectSetting("ground", Text("the view {} has no shadow on it", Name(settings.view)));
    if (const uint32_t samples = desc.batchSize; samples > 64 || (samples & (samples - 1)) != 0)
        Reject(Text("{} samples at once: a power of two up to 64", samples));
    if (!settings.lightGroups.empty() && settings.view != View::PathTraced)
        Reject(Text("the view {} has no light by groups", Name(settings.view)));
    if (desc.resumed == nullptr) return;
    RequireResumable(*desc.resumed);
    const RenderFile& render = desc.resumed->render;
    if (desc.firstSample != render.samples.front().first || desc.aovs != AovsOf(render))
        Reject(Text("first sample and AOVs are not those of {}", desc.resumed->path));
    if (!desc.withVariance) Reject("a render is resumed with its variance");
}

void RequireAdaptive(const SessionDesc& desc, size_t deviceCount) {
    if (!desc.settings.isAdaptive) return;
    const auto reject = [](const std::string& why) { RejectSetting("adaptive", why); };
    if (const View view = desc.settings.view; view != View::PathTraced)
        reject(Text("the view {} has as many samples in all pixels", Name(view)));
    if (desc.settings.hasGround)
        reject("the noise of the shadow on a ground is in alpha, which is not looked at");
    if (deviceCount > 1) reject("several devices share samples of all pixels");
    if (desc.group != nullptr) reject("several processes share samples of all pixels");
    if (desc.settings.shutter) reject("the samples of a time that the shutter sees are those of all pixels");
    if (desc.settings.paths.roulette.kind == Roulette::Frame)
        reject("the length of a sample's paths, by rr, is that of all pixels");
    if (desc.firstSample >= 1u << 31)
        reject(
            Text("pixels with many samples need more indices than there are from {} on", desc.firstSample));
    if (!desc.withVariance) reject("what pixels need is told by their variance, and none is kept");
}

void RequireDenoisable(const SessionDesc& desc, size_t deviceCount) {
    if (!desc.isDenoised && !desc.aovs.Has(Aov::Denoising)) return;
    const auto reject = [&](const std::string& why) {
        RejectSetting(desc.isDenoised ? "denoise" : "aov denoising", why);
    };
    if (const std::string why = NotDenoisedReason(desc.settings); !why.empty()) reject(why);
    if (deviceCount > 1 || desc.group != nullptr) reject("several devices or processes share the samples");
    if (!desc.withVariance)
        reject("it needs the variance, which this render does not keep (SessionDesc::withVariance)");
}

void RequireSame(const ResumedRender& resumed, const RenderFile& described) {
    const std::string mismatch = FirstMismatch(resumed.render, described);
    if (!mismatch.empty())
        throw MakeError(ErrorKind::BadInput, "{} cannot be resumed: {}", resumed.path, mismatch);
}

namespace {

[[noreturn]] void RefuseOther(const ResumedRender& resumed, const std::string& setting,
                              const std::string& given, const std::string& has) {
    throw SettingError(ErrorKind::Usage,
                       Text("{} {}: {} was rendered with {}", setting, given, resumed.path, Printable(has)));
}

}  // namespace

PictureSettings SettingsToResume(const ResumedRender& resumed, const SettingTexts& given) {
    SettingTexts inFile = Texts(SettingsFrom(resumed.render.settings));
    for (const auto& [name, text] : given) {
        std::string& has = inFile.at(name);
        // An open setting stands for the value that was chosen for the render
        if (has == text || IsOpen(name, text)) continue;
        if (!IsOpen(name, has)) RefuseOther(resumed, name, text, has.empty() ? "the default" : has);
        has = text;
    }
    return SettingsFrom(inFile);
}

void RequireAovs(const ResumedRender& resumed, const AovSet& given) {
    if (const AovSet has = AovsOf(resumed.render); given != has)
        RefuseOther(resumed, "aov", ListOf(given), ListOf(has));
}

void RequireFirstSample(const ResumedRender& resumed, uint32_t given) {
    if (const uint32_t has = resumed.render.samples.front().first; given != has)
        RefuseOther(resumed, "sample-offset", std::to_string(given), std::to_string(has));
}

void RequireValidRule(const StopRule& rule, uint32_t firstSample, uint32_t before, bool canEstimateError) {
    if (!rule.samples && !rule.seconds && !rule.relativeError) Reject("a run without an end");
    if (rule.relativeError && !canEstimateError)
        Reject("there is no variance that an error could be estimated from");
    if (rule.relativeError && !(*rule.relativeError > 0.0))
        Reject(Text("no render gets to a relative error of {}", *rule.relativeError));
    if (rule.seconds && !std::isfinite(*rule.seconds))
        Reject(Text("a run of {} seconds has no end", *rule.seconds));
    if (rule.samples && *rule.samples < std::max(before, 1u))
        Reject(Text("{} samples are asked for, and there are {}", *rule.samples, before));
    const uint64_t wanted = std::max<uint64_t>(uint64_t{before} + 1, rule.samples.value_or(1));
    if (wanted > std::numeric_limits<uint32_t>::max()) Reject("there are as many samples as can be counted");
    const uint64_t last = firstSample + wanted - 1;
    if (last > std::numeric_limits<uint32_t>::max())
        Reject(Text("sample {} is beyond the last, 4294967295", last));
}

RenderFile DescribeRender(const SceneInput& input, const PictureSettings& settings,
                          const rhi::DeviceInfo& device) {
    RequireScene(input, settings);
    const Version version = LibraryVersion();
    RenderFile render;
    render.size = RenderedPart(settings).Extent();
    render.settings = Texts(settings);
    render.sceneFile = input.file;
    render.sceneHash = input.hash;
    render.environmentFile = input.environmentFile;
    render.environmentHash = input.environmentHash;
    render.version = Text("{}.{}.{}", version.major, version.minor, version.patch);
    render.device = device.name;
    render.driver = device.driver;
    return render;
}

SessionDesc Resuming(const ResumedRender& render) {
    RequireResumable(render);
    return {.settings = SettingsFrom(render.render.settings),
            .aovs = AovsOf(render.render),
            .firstSample = render.render.samples.front().first,
            .resumed = &render};
}

}  // namespace raygraph::session
