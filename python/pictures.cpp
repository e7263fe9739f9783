// Rendering from Python, and what is done with finished pictures: files, display, merging.
#include <pybind11/functional.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>

#include "editor/session/binding/finished_picture.h"
#include "editor/session/file/merge.h"
#include "python/bindings.h"
#include "renderer/image/exr.h"

namespace raygraph::python {

namespace {

using namespace session;

using Picture = FinishedPicture;
using PicturePtr = std::shared_ptr<Picture>;

PicturePtr RenderScene(Scene& scene, const SettingTexts& texts, const PictureRequest& request,
                       const py::object& progress, const std::vector<DevicePtr>& devices) {
    PlannedPicture planned = PlanPicture(scene, texts, request);
    std::vector<DevicePtr> used = devices;
    if (used.empty()) used.push_back(DeviceOrDefault(nullptr));
    for (const DevicePtr& device : used)
        if (!device) throw Error(ErrorKind::Usage, "device: one of the list is None");
    Listener listener;
    std::function<bool(const ProgressState&)> goesOn;
    if (!progress.is_none())
        goesOn = [&](const ProgressState& state) {
            bool isLast = false;
            listener.Ask([&] { isLast = py::object(progress(state)).ptr() == Py_False; });
            return !isLast;
        };
    return std::make_shared<Picture>(listener.ResultOf([&] {
        return Render(
            std::move(used), std::move(planned), [&] { return listener.IsStopRequested(); }, goesOn);
    }));
}

// --- The arrays of a picture ---

py::dict ArraysOf(const PicturePtr& picture) {
    const RenderFile& render = picture->render;
    const auto height = static_cast<py::ssize_t>(render.size.height);
    const auto width = static_cast<py::ssize_t>(render.size.width);
    py::dict arrays;
    for (const PictureChannel& channel : ChannelsOf(render)) {
        const py::ssize_t stride = channel.stride;
        std::vector<py::ssize_t> shape{height, width}, strides{width * stride, stride};
        if (channel.channels > 1) {
            shape.push_back(channel.channels);
            strides.push_back(1);
        }
        arrays[py::str(channel.name)] =
            channel.isInteger ? ViewOf(picture, static_cast<const uint32_t*>(channel.data), shape, strides)
                              : ViewOf(picture, static_cast<const float*>(channel.data), shape, strides);
    }
    return arrays;
}

// Returns the picture as `render` shows it, or one of a file or merged one with the default display. The
// first result stays, since arrays of Python view its memory.
const image::Image8& Shown(Picture& picture) {
    if (picture.display) return *picture.display;
    const DevicePtr device = DeviceOrDefault(nullptr);
    image::Image8 made = WithoutGil([&] { return ShowRender(*device, picture.render); });
    if (!picture.display) picture.display = std::move(made);  // another thread may have been first
    return *picture.display;
}

void Save(Picture& picture, const std::filesystem::path& path) {
    WithoutGil([&] {
        const auto shown = [&]() -> const image::Image8& {
            const py::gil_scoped_acquire acquired;
            return Shown(picture);
        };
        SavePicture(path, picture.render, shown, LogToPython());
        return 0;
    });
}

PicturePtr Read(const std::filesystem::path& path) {
    return WithoutGil([&] {
        const image::ExrThreads threads;
        auto picture = std::make_shared<Picture>();
        picture->render = ReadRenderFile(path, LogToPython());
        return picture;
    });
}

// Takes None, the path of an .exr, or a picture.
std::shared_ptr<const ResumedRender> ResumedFrom(const py::object& given) {
    if (given.is_none()) return nullptr;
    if (py::isinstance<Picture>(given))
        return std::make_shared<ResumedRender>(
            ResumedRender{"the picture", given.cast<PicturePtr>()->render});
    const auto path = given.cast<std::filesystem::path>();
    return WithoutGil([&] {
        const image::ExrThreads threads;
        return std::make_shared<ResumedRender>(ReadResumedRender(path, LogToPython()));
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
        .def_property_readonly("relative_error",
                               [](const Picture& picture) { return RelativeErrorOf(picture.render); })
        .def_readonly("seconds", &Picture::seconds)
        .def_readonly("was_stopped", &Picture::wasStopped);
    module.def(
        "render", [](Scene& scene, const SettingTexts& texts, std::vector<std::string> aovs,
                     std::optional<uint32_t> samples, std::optional<double> seconds,
                     std::optional<double> error, uint32_t firstSample, std::string denoiser, float exposure,
                     std::string tonemap, std::string whitePoint, const py::object& resumed,
                     const py::object& progress, const std::vector<DevicePtr>& devices) {
            return RenderScene(scene, texts,
                               {std::move(aovs), samples, seconds, error, firstSample, std::move(denoiser),
                                exposure, std::move(tonemap), std::move(whitePoint), ResumedFrom(resumed)},
                               progress, devices);
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
