// Rendering from Python, and what is done with finished pictures: files, display, merging.
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <optional>

#include "base/files.h"
#include "base/text.h"
#include "editor/session/denoise.h"
#include "editor/session/file/merge.h"
#include "editor/session/file/render_file.h"
#include "editor/session/file/resume.h"
#include "editor/session/session.h"
#include "editor/session/settings/light_settings.h"
#include "passes/pixel_list.h"
#include "passes/views.h"
#include "python/bindings.h"
#include "renderer/graph/readback_values.h"
#include "renderer/image/exr.h"

namespace raygraph::python {

namespace {

using namespace session;

// Holds how a picture is shown with eight bits.
struct Display {
    float exposureEv = 0.0f;
    std::string tonemap;
    py::object whitePoint;  // None, "auto" or kelvin
};

struct Picture {
    RenderFile render;
    std::optional<image::Image8> display;  // none: of a file or a merged picture
    double seconds = 0.0;                  // of sampling
    bool wasStopped = false;
};
using PicturePtr = std::shared_ptr<Picture>;

// Asks Python during a run whether a signal has come, as Ctrl-C, and what the progress function says. An
// exception of theirs ends the run, and is raised after it. Each question takes the GIL, which the run's
// threads do not hold; the constructor, Raise and the destructor need it.
class Listener {
  public:
    explicit Listener(py::object progress) : m_progress(std::move(progress)) {}

    std::function<void(const ProgressState&)> Progress() {
        if (m_progress.is_none()) return {};
        return [this](const ProgressState& state) {
            Ask([&] {
                const py::object answer = m_progress(state);
                if (answer.ptr() == Py_False) m_isStopped = true;
            });
        };
    }
    bool IsStopRequested() {
        // Often enough for a person, and rarely enough not to wait for other Python threads all the time.
        constexpr auto kInterval = std::chrono::milliseconds(20);
        const auto now = std::chrono::steady_clock::now();
        if (!m_raised && now - m_asked > kInterval) {
            m_asked = now;
            Ask([] {
                if (PyErr_CheckSignals() != 0) throw py::error_already_set();
            });
        }
        return m_isStopped || m_raised;
    }
    bool HasRaised() const { return m_raised != nullptr; }
    void Raise() const {
        if (m_raised) std::rethrow_exception(m_raised);
    }

  private:
    template <typename Question>
    void Ask(Question&& question) {
        if (m_raised) return;
        const py::gil_scoped_acquire acquired;
        SendMessages();
        try {
            question();
        } catch (...) {
            m_raised = std::current_exception();
        }
    }

    py::object m_progress;
    std::chrono::steady_clock::time_point m_asked;
    bool m_isStopped = false;
    std::exception_ptr m_raised;
};

template <typename Choice>
Choice ChoiceOf(const std::string& what, const std::string& text) {
    constexpr auto kTexts = Texts(Choice{});
    std::string all;
    for (size_t i = 0; i < kTexts.size(); ++i) {
        if (text == kTexts[i]) return static_cast<Choice>(i);
        all += (all.empty() ? "" : ", ") + std::string(kTexts[i]);
    }
    throw MakeError(ErrorKind::Usage, "{}: {} is none of {}", what, Quoted(text), all);
}

// Returns how `raygraph render` shows such a picture.
passes::TonemapSettings TonemapOf(const Display& display, const SceneInput* input,
                                  const PictureSettings& settings) {
    passes::TonemapSettings tonemap{.exposureEv = display.exposureEv};
    if (!display.tonemap.empty())
        tonemap.tonemapOperator = display.tonemap == "raw"
                                      ? TonemapOperator::Linear
                                      : ChoiceOf<TonemapOperator>("tonemap", display.tonemap);
    if (display.whitePoint.is_none()) return tonemap;
    if (!py::isinstance<py::str>(display.whitePoint)) {
        tonemap.whiteBalance = passes::WhiteBalance(passes::WhitePointAt(display.whitePoint.cast<double>()));
        return tonemap;
    }
    if (display.whitePoint.cast<std::string>() != "auto" || input == nullptr)
        throw Error(ErrorKind::Usage, "white_point: it is \"auto\", for a scene, or a number of kelvin");
    const std::optional<glm::dvec3> light = LightColor(*input, settings);
    if (!light)
        throw MakeError(ErrorKind::BadInput, "white_point: {} has no light to take the color of",
                        input->file);
    tonemap.whiteBalance = passes::WhiteBalance(passes::ChromaticityOf(*light));
    return tonemap;
}

// Holds what is asked for beside the settings of the picture.
struct Request {
    std::vector<std::string> aovs;
    std::optional<uint32_t> samples;
    std::optional<double> seconds, error;
    uint32_t firstSample = 0;
    std::string denoiser;  // "": not denoised
};

// Returns the settings of a picture of this scene.
PictureSettings SettingsFor(const Scene& scene, const SettingTexts& texts) {
    PictureSettings settings = SettingsFrom(texts);
    settings.scene = scene.input.scene;
    settings.variant = scene.input.variant;
    settings.pointsAndLines = scene.input.pointsAndLines;
    return settings;
}

PicturePtr Render(Scene& scene, const SettingTexts& texts, const Request& request, const Display& display,
                  py::object progress, const std::vector<DevicePtr>& devices) {
    SettingTexts given = texts;
    const bool showsOnlyShadow = HideBehindGround(given);
    SessionDesc desc{.settings = SettingsFor(scene, given), .firstSample = request.firstSample};
    if (showsOnlyShadow) desc.backdrop = passes::BackdropSettings{};
    for (const std::string& name : request.aovs) {
        const Aov aov = ChoiceOf<Aov>("aovs", name);
        if (!CanHave(aov, desc.settings))
            throw MakeError(ErrorKind::Usage, "aovs: a picture with these settings has no {}", name);
        desc.aovs.Set(aov);
    }
    const auto requirePositive = [](const char* what, const auto& value) {
        if (value && !(*value > 0)) throw MakeError(ErrorKind::Usage, "{}: {} is not above 0", what, *value);
    };
    requirePositive("spp", request.samples);
    requirePositive("seconds", request.seconds);
    requirePositive("error", request.error);
    desc.isDenoised = !request.denoiser.empty();
    if (desc.isDenoised) {
        if (const std::string why = NotDenoisedReason(desc.settings); !why.empty())
            throw Error(ErrorKind::Usage, "denoise: " + why);
        desc.denoiser = ChoiceOf<passes::Denoiser>("denoise", request.denoiser);
    }
    scene.Update();
    SceneInput input = scene.InputFor(desc.settings.at.has_value());
    desc.settings.light = ChooseLight(input, desc.settings);
    desc.tonemap = TonemapOf(display, &input, desc.settings);
    StopRule rule{.samples = request.samples, .seconds = request.seconds, .relativeError = request.error};
    if (!passes::IsAverageable(desc.settings.view)) rule = {.samples = 1};
    std::vector<DevicePtr> used = devices;
    if (used.empty()) used.push_back(DeviceOrDefault(nullptr));
    std::vector<rhi::Device*> pointers;
    for (const DevicePtr& device : used) {
        if (!device) throw Error(ErrorKind::Usage, "device: one of the list is None");
        pointers.push_back(device.get());
    }

    Listener listener(std::move(progress));
    rule.isStopRequested = [&] { return listener.IsStopRequested(); };
    const PicturePtr picture = WithoutGil([&]() -> PicturePtr {
        Session session(pointers, std::move(input), desc);
        const RunSummary run = session.Run(rule, listener.Progress());
        if (listener.HasRaised()) return nullptr;
        auto made = std::make_shared<Picture>();
        made->render = session.Result().render;
        made->display = session.Display();
        made->seconds = run.seconds;
        made->wasStopped = run.wasStopped;
        return made;
    });
    listener.Raise();
    return picture;
}

// --- The arrays of a picture ---

py::dict ArraysOf(const PicturePtr& picture) {
    const RenderFile& render = picture->render;
    const auto height = static_cast<py::ssize_t>(render.size.height);
    const auto width = static_cast<py::ssize_t>(render.size.width);
    py::dict arrays;
    const auto add = [&](const std::string& name, const auto& values, py::ssize_t channels,
                         py::ssize_t stride) {
        if (values.empty()) return;
        std::vector<py::ssize_t> shape{height, width}, strides{width * stride, stride};
        if (channels > 1) {
            shape.push_back(channels);
            strides.push_back(1);
        }
        arrays[py::str(name)] = ViewOf(picture, values.data(), shape, strides);
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
    return arrays;
}

// Returns the picture as `render` shows it, or one of a file or merged one with the default display. The
// first result stays, since arrays of Python view its memory.
const image::Image8& Shown(Picture& picture) {
    if (picture.display) return *picture.display;
    const DevicePtr device = DeviceOrDefault(nullptr);
    image::Image8 made = WithoutGil([&] {
        const RenderFile& render = picture.render;
        const PictureSettings settings = SettingsFrom(render.settings);
        Renderer renderer(*device);
        renderer.BeginFrame();
        const TextureId radiance = passes::UploadTexels(
            renderer, std::as_bytes(std::span(render.denoised.empty() ? render.radiance : render.denoised)),
            renderer.CreateTexture("picture", {render.size, Format::Rgba32Float}));
        const Readback shown = renderer.ReadBack(
            passes::ShowsLight(settings.view) ? passes::Tonemap(renderer, radiance, WithAlphaOf({}, settings))
                                              : passes::PaintView(renderer, radiance, settings.view));
        renderer.Execute();
        return image::Image8{render.size.width, render.size.height, WaitForValues<uint8_t>(shown)};
    });
    if (!picture.display) picture.display = std::move(made);  // another thread may have been first
    return *picture.display;
}

void Save(Picture& picture, const std::filesystem::path& path) {
    const std::string extension = LowerExtension(path);
    if (extension == ".exr") {
        WithoutGil([&] {
            const image::ExrThreads threads;
            WriteRenderFile(path, picture.render, LogToPython());
            return 0;
        });
    } else if (extension == ".hdr") {
        WithoutGil([&] {
            const RenderFile& render = picture.render;
            image::WriteHdr(path, {render.size.width, render.size.height, render.radiance});
            return 0;
        });
    } else if (extension == ".png" || extension == ".jpg" || extension == ".jpeg") {
        const image::Image8& shown = Shown(picture);
        WithoutGil([&] {
            extension == ".png" ? image::WritePng(path, shown) : image::WriteJpeg(path, shown);
            return 0;
        });
    } else {
        throw MakeError(ErrorKind::Usage, "{}: a picture is a .png, .jpg, .exr or .hdr", path);
    }
}

PicturePtr Read(const std::filesystem::path& path) {
    return WithoutGil([&] {
        const image::ExrThreads threads;
        auto picture = std::make_shared<Picture>();
        picture->render = ReadRenderFile(path, LogToPython());
        return picture;
    });
}

PicturePtr MergeAll(const std::vector<std::pair<std::string, PicturePtr>>& parts) {
    return WithoutGil([&] {
        Merger merger;
        for (const auto& [name, part] : parts) merger.Add({name, part->render});
        auto picture = std::make_shared<Picture>();
        picture->render = merger.Take();
        return picture;
    });
}

}  // namespace

void BindPictures(py::module_& module) {
    py::class_<ProgressState>(module, "Progress",
                              "How far a render is. Numbers that are not known yet are None, or 0 for "
                              "samples_per_second, which counts all pixels.")
        .def_readonly("samples", &ProgressState::samplesDone)
        .def_readonly("samples_wanted", &ProgressState::samplesWanted)
        .def_readonly("samples_per_second", &ProgressState::samplesPerSecond)
        .def_readonly("relative_error", &ProgressState::relativeError)
        .def_readonly("seconds_left", &ProgressState::secondsLeft);
    py::class_<Picture, PicturePtr>(module, "Picture")
        .def("arrays", &ArraysOf)
        .def("display",
             [](const PicturePtr& picture) {
                 const image::Image8& shown = Shown(*picture);
                 const auto height = static_cast<py::ssize_t>(shown.height);
                 const auto width = static_cast<py::ssize_t>(shown.width);
                 return ViewOf(picture, shown.rgba.data(), {height, width, 4}, {4 * width, 4, 1});
             })
        .def("png",
             [](Picture& picture) {
                 const std::vector<std::byte> bytes = image::EncodePng(Shown(picture), "picture");
                 return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
             })
        .def("save", &Save)
        .def_property_readonly("size",
                               [](const Picture& picture) {
                                   return py::make_tuple(picture.render.size.width,
                                                         picture.render.size.height);
                               })
        .def_property_readonly("samples",
                               [](const Picture& picture) { return SampleCount(picture.render.samples); })
        .def_property_readonly("settings", [](const Picture& picture) { return picture.render.settings; })
        .def_property_readonly("device", [](const Picture& picture) { return picture.render.device; })
        .def_property_readonly("scene", [](const Picture& picture) { return picture.render.sceneFile; })
        .def_property_readonly(
            "relative_error",
            [](const Picture& picture) {
                const RenderFile& render = picture.render;
                return render.adaptive
                           ? Measure(render.radiance, render.variance, render.adaptive->counts).relativeError
                           : Measure(render.radiance, render.variance,
                                     static_cast<uint32_t>(SampleCount(render.samples)))
                                 .relativeError;
            })
        .def_readonly("seconds", &Picture::seconds)
        .def_readonly("was_stopped", &Picture::wasStopped);
    module.def("render", [](Scene& scene, const SettingTexts& texts, std::vector<std::string> aovs,
                            std::optional<uint32_t> samples, std::optional<double> seconds,
                            std::optional<double> error, uint32_t firstSample, std::string denoiser,
                            float exposure, std::string tonemap, py::object whitePoint, py::object progress,
                            const std::vector<DevicePtr>& devices) {
        return Render(scene, texts,
                      {std::move(aovs), samples, seconds, error, firstSample, std::move(denoiser)},
                      {exposure, std::move(tonemap), std::move(whitePoint)}, std::move(progress), devices);
    });
    module.def("read", &Read);
    module.def("merge", &MergeAll);
    module.def("setting_names", [] {
        std::vector<std::string> names;
        for (const auto& [name, text] : Texts(PictureSettings{})) names.push_back(name);
        return names;
    });
}

}  // namespace raygraph::python
