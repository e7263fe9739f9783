#include "editor/session/binding/finished_picture.h"

#include <utility>

#include "base/files.h"
#include "base/text.h"
#include "editor/session/binding/interruptible.h"
#include "editor/session/denoise.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/session_checks.h"
#include "passes/pixel_list.h"
#include "passes/views.h"
#include "renderer/graph/readback_values.h"
#include "renderer/image/exr.h"

namespace raygraph::session {

namespace {

// Runs `parse`, whose errors then begin with the name of the setting.
template <typename Parse>
auto ParseSetting(const char* setting, Parse&& parse) {
    try {
        return parse();
    } catch (const Error& error) {
        throw SettingError(error.Kind(), Text("{}: {}", setting, error.what()));
    }
}

template <typename Number>
void RequirePositive(const char* setting, const std::optional<Number>& value) {
    if (value && !(*value > 0))
        throw SettingError(ErrorKind::Usage, Text("{}: {} is not above 0", setting, *value));
}

}  // namespace

passes::TonemapSettings TonemapOf(const PictureRequest& request, const SceneInput* input,
                                  const PictureSettings& settings) {
    passes::TonemapSettings tonemap{.exposureEv = request.exposureEv};
    if (request.tonemap == "raw")
        tonemap.tonemapOperator = TonemapOperator::Linear;
    else if (!request.tonemap.empty())
        tonemap.tonemapOperator =
            ParseSetting("tonemap", [&] { return ParseChoice<TonemapOperator>(request.tonemap); });
    if (request.whitePoint.empty()) return tonemap;
    if (request.whitePoint != "auto") {
        const double kelvin = ParseSetting("white-point", [&] {
            return ParseNumber(request.whitePoint, passes::kMinWhitePoint, passes::kMaxWhitePoint);
        });
        tonemap.whiteBalance = passes::WhiteBalance(passes::WhitePointAt(kelvin));
        return tonemap;
    }
    if (input == nullptr)
        throw SettingError(ErrorKind::Usage, "white-point: auto is for a finished picture of a scene");
    const std::optional<glm::dvec3> light = LightColor(*input, settings);
    if (!light)
        throw SettingError(ErrorKind::BadInput,
                           Text("white-point: {} has no light to take the color of", Printable(input->file)));
    tonemap.whiteBalance = passes::WhiteBalance(passes::ChromaticityOf(*light));
    return tonemap;
}

PlannedPicture PlanPicture(EditedScene& scene, SettingTexts settings, const PictureRequest& request) {
    PlannedPicture planned{.resumed = request.resumed};
    const ResumedRender* const resumed = planned.resumed.get();
    const bool isCutOut = settings.contains("transparent");
    HideBehindGround(settings);
    if (resumed != nullptr) {
        RequireResumable(*resumed);
        settings = Texts(SettingsToResume(*resumed, settings));
        if (request.firstSample != 0) RequireFirstSample(*resumed, request.firstSample);
    }
    SessionDesc& desc = planned.desc;
    desc.settings = SettingsFor(scene, settings);
    desc.firstSample = resumed != nullptr ? resumed->render.samples.front().first : request.firstSample;
    desc.resumed = resumed;
    if (!isCutOut && desc.settings.hasGround && desc.settings.paths.isEnvironmentHidden)
        desc.backdrop = passes::BackdropSettings{};  // only the shadow is seen
    for (const std::string& name : request.aovs) {
        const Aov aov = ParseSetting("aov", [&] { return ParseChoice<Aov>(name); });
        if (!CanHave(aov, desc.settings))
            throw SettingError(ErrorKind::Usage, Text("aov: a picture with these settings has no {}", name));
        desc.aovs.Set(aov);
    }
    if (resumed != nullptr) {
        if (!request.aovs.empty()) RequireAovs(*resumed, desc.aovs);
        desc.aovs = AovsOf(resumed->render);
        if (!request.samples && !request.seconds && !request.relativeError)
            throw SettingError(ErrorKind::Usage,
                               Text("spp: it is the total to reach, and needed to resume {}, which has {}",
                                    resumed->path, Counted(SampleCount(resumed->render.samples), "sample")));
    }
    RequirePositive("spp", request.samples);
    RequirePositive("time", request.seconds);
    RequirePositive("error", request.relativeError);
    desc.isDenoised = !request.denoiser.empty();
    if (desc.isDenoised) {
        if (const std::string why = NotDenoisedReason(desc.settings); !why.empty())
            throw SettingError(ErrorKind::Usage, "denoise: " + why);
        desc.denoiser =
            ParseSetting("denoise", [&] { return ParseChoice<passes::Denoiser>(request.denoiser); });
    }
    scene.Update();
    planned.input = scene.InputFor(desc.settings.at.has_value());
    desc.settings.light = ChooseLight(planned.input, desc.settings, resumed);
    desc.tonemap = TonemapOf(request, &planned.input, desc.settings);
    planned.rule = {
        .samples = request.samples, .seconds = request.seconds, .relativeError = request.relativeError};
    if (!passes::IsAverageable(desc.settings.view)) planned.rule = {.samples = 1};
    return planned;
}

std::optional<FinishedPicture> Render(std::vector<std::shared_ptr<rhi::Device>> devices,
                                      PlannedPicture planned, const std::function<bool()>& isStopRequested,
                                      const std::function<bool(const ProgressState&)>& goesOn) {
    // The work has `goesOn` for the questions that the caller answers, and for nothing else
    auto work = [devices = std::move(devices), planned = std::move(planned), hasProgress = bool(goesOn),
                 &goesOn](Caller& caller) mutable -> FinishedPicture {
        bool isEnded = false;
        planned.rule.isStopRequested = [&] { return isEnded || caller.IsStopRequested(); };
        std::function<void(const ProgressState&)> progress;
        if (hasProgress)
            progress = [&](const ProgressState& state) { caller.Ask([&] { isEnded |= !goesOn(state); }); };
        std::vector<rhi::Device*> used;
        for (const auto& device : devices) used.push_back(device.get());
        Session session(used, std::move(planned.input), planned.desc);
        planned.resumed.reset();  // it may be large
        const RunSummary run = session.Run(planned.rule, progress);
        caller.ThrowIfStopRequested();
        return {.render = session.Result().render,
                .display = session.Display(),
                .seconds = run.seconds,
                .wasStopped = run.wasStopped};
    };
    return RunInterruptibly(std::move(work), isStopRequested);
}

std::vector<PictureChannel> ChannelsOf(const RenderFile& render) {
    std::vector<PictureChannel> list;
    const auto add = [&](std::string name, const auto& values, uint32_t channels, uint32_t stride) {
        constexpr bool kIsInteger = std::is_same_v<std::decay_t<decltype(values[0])>, uint32_t>;
        if (!values.empty()) list.push_back({std::move(name), values.data(), kIsInteger, channels, stride});
    };
    add("color", render.radiance, 4, 4);
    add("denoised", render.denoised, 4, 4);
    add("variance", render.variance, 3, 4);
    for (const Aov aov : kAovs)
        if (const Texels* mean = MeanOf(render, aov)) add(Name(aov), *mean, 3, 4);
    for (const Bias bias : kBiases)
        add(std::string(Name(AovOf(bias))) + ".variance", render.removedVariance[static_cast<size_t>(bias)],
            3, 4);
    add("depth", render.depth, 1, 1);
    add("instance", render.instance, 1, 1);
    add("material", render.material, 1, 1);
    add("motion", render.motion, 2, 2);
    add("denoising.albedo", render.denoising.albedo, 3, 4);
    add("denoising.normal", render.denoising.normal, 3, 4);
    const std::vector<std::string> groups = LightGroupNames(SettingsFrom(render.settings).lightGroups);
    for (size_t i = 0; i < render.lightGroups.size(); ++i)
        add("light." + groups.at(i), render.lightGroups[i], 3, 4);
    if (render.adaptive) add("samples", render.adaptive->counts, 1, 1);
    return list;
}

std::optional<double> RelativeErrorOf(const RenderFile& render) {
    return (render.adaptive ? Measure(render.radiance, render.variance, render.adaptive->counts)
                            : Measure(render.radiance, render.variance,
                                      static_cast<uint32_t>(SampleCount(render.samples))))
        .relativeError;
}

image::Image8 ShowRender(rhi::Device& device, const RenderFile& render) {
    const PictureSettings settings = SettingsFrom(render.settings);
    Renderer renderer(device);
    renderer.BeginFrame();
    const TextureId radiance = passes::UploadTexels(
        renderer, std::as_bytes(std::span(render.denoised.empty() ? render.radiance : render.denoised)),
        renderer.CreateTexture("picture", {render.size, Format::Rgba32Float}));
    const Readback shown = renderer.ReadBack(
        passes::ShowsLight(settings.view) ? passes::Tonemap(renderer, radiance, WithAlphaOf({}, settings))
                                          : passes::PaintView(renderer, radiance, settings.view));
    renderer.Execute();
    return {render.size.width, render.size.height, WaitForValues<uint8_t>(shown)};
}

void SavePicture(const std::filesystem::path& path, const RenderFile& render,
                 const std::function<const image::Image8&()>& shown, const Log& log) {
    const std::string extension = LowerExtension(path);
    if (extension == ".exr") {
        const image::ExrThreads threads;
        WriteRenderFile(path, render, log);
    } else if (extension == ".hdr") {
        image::WriteHdr(path, {render.size.width, render.size.height, render.radiance});
    } else if (extension == ".png") {
        image::WritePng(path, shown());
    } else if (extension == ".jpg" || extension == ".jpeg") {
        image::WriteJpeg(path, shown());
    } else {
        throw MakeError(ErrorKind::Usage, "{}: a picture is a .png, .jpg, .exr or .hdr", path);
    }
}

}  // namespace raygraph::session
