// Finished pictures judged from Python: compared, verified against a reference, and explained, by the
// functions of the program's commands.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstring>
#include <optional>

#include "base/text.h"
#include "editor/session/explain/explain.h"
#include "editor/session/explain/path_text.h"
#include "editor/session/verify/difference.h"
#include "editor/session/verify/verify.h"
#include "python/bindings.h"

namespace raygraph::python {

namespace {

using namespace session;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

// Returns the texels of (height, width, 3 or 4) numbers.
Texels TexelsOf(const std::string& name, const Floats& array, Extent2D& size) {
    if (array.ndim() != 3 || array.shape(2) < 3 || array.shape(2) > 4)
        throw MakeError(ErrorKind::Usage, "{}: it is an array of (height, width, 3 or 4)", name);
    const Extent2D extent{static_cast<uint32_t>(array.shape(1)), static_cast<uint32_t>(array.shape(0))};
    if (!size.IsEmpty() && size != extent)
        throw MakeError(ErrorKind::Usage, "{}: radiance and variance have two sizes", name);
    size = extent;
    const auto channels = static_cast<size_t>(array.shape(2));
    Texels texels(size_t{4} * extent.width * extent.height, 1.0f);
    for (size_t i = 0; i < texels.size() / 4; ++i)
        std::copy_n(array.data() + i * channels, channels, &texels[4 * i]);
    return texels;
}

// Takes (name, path) or (name, color, variance of the mean or None, samples).
session::Picture PictureFrom(const py::tuple& given) {
    const auto name = given[0].cast<std::string>();
    if (given.size() == 2) {
        const auto path = given[1].cast<std::filesystem::path>();
        return WithoutGil([&] { return ReadPicture(path, {}, LogToPython()); });
    }
    session::Picture picture{.name = name};
    picture.radiance = TexelsOf(name, given[1].cast<Floats>(), picture.size);
    if (!given[2].is_none()) picture.variance = TexelsOf(name, given[2].cast<Floats>(), picture.size);
    picture.samples = given[3].cast<uint64_t>();
    return picture;
}

py::dict ToDict(const PictureDifference& difference, Extent2D size) {
    py::dict result;
    result["rel_mse"] = difference.relMse;
    result["rel_mse_of_noise"] = difference.relMseOfNoise;
    result["flip"] = difference.flip;
    result["ssim"] = difference.ssim;
    result["mean"] = difference.mean;
    result["mean_of_reference"] = difference.meanOfReference;
    result["z"] = py::none();
    if (difference.z) {
        py::dict z;
        z["rms"] = difference.z->rms;
        z["beyond_three"] = difference.z->beyondThree;
        z["differs_without_noise"] = difference.z->differsWithoutNoise;
        z["of_mean"] = difference.z->ofMean;
        result["z"] = z;
    }
    const auto map = std::make_shared<std::vector<float>>(difference.flipMap);
    const auto height = static_cast<py::ssize_t>(size.height), width = static_cast<py::ssize_t>(size.width);
    if (!map->empty()) result["flip_map"] = ViewOf(map, map->data(), {height, width}, {width, 1});
    return result;
}

py::dict Compare(const py::tuple& reference, const py::tuple& picture, float exposureEv,
                 const DevicePtr& chosen) {
    session::Picture a = PictureFrom(reference), b = PictureFrom(picture);
    const DevicePtr device = DeviceOrDefault(chosen);
    const Extent2D size = b.size;
    return ToDict(Interruptibly([device, exposureEv, a = std::move(a), b = std::move(b)](Caller&) {
                      Renderer renderer(*device);
                      return Difference(renderer, a, b, exposureEv);
                  }),
                  size);
}

py::dict VerifyPicture(Scene& scene, const py::tuple& given, const SettingTexts& texts, double tolerance,
                       uint32_t maxSamples, const std::filesystem::path& cache, const DevicePtr& chosen) {
    session::Picture picture = PictureFrom(given);
    VerifyDesc desc{.settings = SettingsFor(scene, texts)};
    if (!texts.contains("size")) desc.settings.size = picture.size;
    desc.tolerance.relative = tolerance;
    desc.maxSamples = maxSamples;
    desc.minSamples = std::min(desc.minSamples, maxSamples);
    desc.cache = cache;
    desc.log = LogToPython();
    scene.Update();
    const DevicePtr device = DeviceOrDefault(chosen);
    const Extent2D size = picture.size;
    const VerifyResult verified =
        Interruptibly([device, input = scene.InputFor(desc.settings.at.has_value()), desc = std::move(desc),
                       picture = std::move(picture)](Caller& caller) mutable {
            desc.isStopRequested = [&] { return caller.IsStopRequested(); };
            return Verify(*device, std::move(input), std::move(desc)).Check(picture);
        });
    py::dict result = ToDict(verified.verdict.difference, size);
    result["is_right"] = verified.verdict.isRight;
    result["is_decided"] = verified.verdict.isDecided;
    result["reference_samples"] = verified.referenceSamples;
    py::list checks, causes;
    for (const VerdictCheck& check : verified.verdict.checks) {
        py::dict entry;
        entry["name"] = check.name;
        entry["value"] = check.value;
        entry["limit"] = check.limit;
        entry["is_passed"] = check.isPassed;
        entry["where"] = check.where;
        checks.append(entry);
    }
    for (const Hypothesis& hypothesis : verified.diagnosis.hypotheses) {
        py::dict entry;
        entry["kind"] = hypothesis.kind;
        entry["name"] = hypothesis.name;
        entry["text"] = hypothesis.text;
        entry["explained"] = hypothesis.explained;
        causes.append(entry);
    }
    result["checks"] = checks;
    result["causes"] = causes;
    return result;
}

py::dict ExplainPixel(Scene& scene, std::array<uint32_t, 2> pixel, const SettingTexts& texts,
                      uint32_t brightest, std::optional<uint32_t> sample, uint32_t firstSample,
                      uint32_t sampleCount, const DevicePtr& chosen) {
    const PictureSettings settings = SettingsFor(scene, texts);
    const ExplainRequest request{.pixel = {pixel[0], pixel[1]},
                                 .sample = sample,
                                 .brightest = brightest,
                                 .firstSample = firstSample,
                                 .sampleCount = sampleCount};
    scene.Update();
    const DevicePtr device = DeviceOrDefault(chosen);
    const auto explained = std::make_shared<Explanation>(Interruptibly(
        [device, input = scene.InputFor(settings.at.has_value()), settings, request](Caller&) mutable {
            return Explain(*device, std::move(input), settings, request);
        }));
    py::dict result;
    result["text"] = py::bytes(Describe(*explained)).attr("decode")("utf-8", "replace");
    result["mean"] = py::make_tuple(explained->mean.x, explained->mean.y, explained->mean.z);
    result["relative_error"] = explained->relativeError;
    if (!explained->values.empty())
        result["values"] = ViewOf(explained, &explained->values[0].x,
                                  {static_cast<py::ssize_t>(explained->values.size()), 3}, {3, 1});
    py::list paths;
    for (const ExplainedPath& path : explained->paths) {
        py::dict entry;
        entry["sample"] = path.sample;
        entry["value"] = py::make_tuple(path.value.x, path.value.y, path.value.z);
        entry["cause"] = py::bytes(CauseOf(path, explained->names)).attr("decode")("utf-8", "replace");
        entry["is_exact"] = path.isExact;
        entry["vertices"] = path.vertices.size();
        paths.append(entry);
    }
    result["paths"] = paths;
    return result;
}

}  // namespace

void BindAnalysis(py::module_& module) {
    module.def("compare", &Compare);
    module.def("verify", &VerifyPicture);
    module.def("explain", &ExplainPixel);
}

}  // namespace raygraph::python
