// Passes of one's own from Python: GLSL text that runs once, with arrays in and out.
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <map>
#include <optional>

#include "base/printable.h"
#include "base/text.h"
#include "python/bindings.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/graph/readback_values.h"
#include "rhi/reflection.h"
#include "rhi/shader_compiler.h"

namespace raygraph::python {

namespace {

using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

// Holds what a binding takes and returns.
struct Bound {
    rhi::Binding binding;
    rhi::Format format = rhi::Format::Undefined;  // of an image
    Extent2D extent;
    std::vector<float> texels;     // of an image that is given
    std::vector<std::byte> bytes;  // of a buffer or a uniform block, or of the result
    bool isInput = false, isOutput = false;
    TextureId texture;
    BufferId buffer;
    Readback result;
};

bool IsImage(const rhi::Binding& binding) {
    return binding.kind == rhi::BindingKind::StorageImage || binding.kind == rhi::BindingKind::SampledImage;
}

rhi::Format FormatOf(const rhi::Binding& binding, py::ssize_t channels) {
    if (binding.imageFormat != rhi::Format::Undefined) return binding.imageFormat;
    return channels == 1   ? rhi::Format::R32Float
           : channels == 2 ? rhi::Format::Rg32Float
                           : rhi::Format::Rgba32Float;
}

void TakeImage(Bound& bound, const py::object& value) {
    const Floats array = Floats::ensure(value);
    if (!array || array.ndim() < 2 || array.ndim() > 3 || array.size() == 0)
        throw MakeError(ErrorKind::Usage,
                        "{}: an image is an array of (height, width) or (height, width, channels)",
                        bound.binding.name);
    const py::ssize_t channels = array.ndim() == 3 ? array.shape(2) : 1;
    bound.format = FormatOf(bound.binding, channels);
    bound.extent = {static_cast<uint32_t>(array.shape(1)), static_cast<uint32_t>(array.shape(0))};
    const size_t wanted = testing::ChannelCount(bound.format), given = static_cast<size_t>(channels);
    if (given > wanted)
        throw MakeError(ErrorKind::Usage, "{}: the array has {} channels, the shader's {} has {}",
                        bound.binding.name, given, rhi::Name(bound.format), wanted);
    const size_t count = size_t{bound.extent.width} * bound.extent.height;
    bound.texels.assign(wanted * count, 0.0f);
    for (size_t i = 0; i < count; ++i)
        for (size_t c = 0; c < wanted; ++c)
            bound.texels[wanted * i + c] = c < given ? array.data()[given * i + c] : (c == 3 ? 1.0f : 0.0f);
}

// Returns the value as an array that can be taken byte for byte. Throws for a ragged list, and for objects,
// whose bytes would be pointers.
py::array PlainArray(const std::string& name, const py::object& value) {
    const py::array array = py::array::ensure(value, py::array::c_style);
    if (!array || array.dtype().attr("hasobject").cast<bool>())
        throw MakeError(ErrorKind::Usage, "{}: it is no array of numbers", name);
    return array;
}

std::vector<std::byte> BytesOf(const std::string& name, const py::object& value) {
    const py::array array = PlainArray(name, value);
    const auto* first = static_cast<const std::byte*>(array.data());
    return {first, first + array.nbytes()};
}

// Returns the result; of a buffer, with the type and the shape of `like`.
py::object ArrayOf(const Bound& bound, const py::array& like) {
    const std::span<const std::byte> bytes = bound.bytes;
    if (!IsImage(bound.binding)) {
        py::array result(like.dtype(), std::vector<py::ssize_t>(like.shape(), like.shape() + like.ndim()));
        if (static_cast<size_t>(result.nbytes()) != bytes.size())
            throw MakeError(ErrorKind::Usage, "{}: the result has {} bytes, the array for it {}",
                            bound.binding.name, bytes.size(), result.nbytes());
        std::memcpy(result.mutable_data(), bytes.data(), bytes.size());
        return result;
    }
    const auto texels =
        std::make_shared<testing::Texels>(testing::DecodeTexels(bytes, bound.extent, bound.format));
    const auto height = static_cast<py::ssize_t>(bound.extent.height),
               width = static_cast<py::ssize_t>(bound.extent.width),
               channels = static_cast<py::ssize_t>(texels->channelCount);
    if (channels == 1) return ViewOf(texels, texels->values.data(), {height, width}, {width, 1});
    return ViewOf(texels, texels->values.data(), {height, width, channels}, {width * channels, channels, 1});
}

// Throws for a name that the shader does not have.
Bound& Find(std::map<std::string, Bound>& all, const std::string& name) {
    const auto found = all.find(name);
    if (found != all.end()) return found->second;
    std::string names;
    for (const auto& [each, bound] : all) names += (names.empty() ? "" : ", ") + each;
    throw MakeError(ErrorKind::Usage, "{}: the shader has no such binding; it has {}", name,
                    names.empty() ? "none" : names);
}

// Runs the shader, and replaces the bytes of outputs by their results.
void Run(rhi::Device& device, const std::vector<uint32_t>& words, std::map<std::string, Bound>& all,
         std::span<const std::byte> pushed, const std::optional<std::array<uint32_t, 3>>& groups,
         Extent2D covered) {
    testing::PassHarness harness(device);
    Renderer& renderer = harness.Graph();
    renderer.AddShader("pass.comp", words);
    renderer.BeginFrame();
    for (auto& [name, bound] : all) {
        if (IsImage(bound.binding))
            bound.texture = bound.isInput ? harness.Texture(name, bound.extent, bound.format,
                                                            std::span<const float>(bound.texels))
                                          : renderer.CreateTexture(name, {bound.extent, bound.format});
        else if (bound.binding.kind != rhi::BindingKind::UniformBuffer)
            bound.buffer = bound.isInput ? harness.Buffer(name, std::span<const std::byte>(bound.bytes))
                                         : renderer.CreateBuffer(name, {.size = bound.bytes.size()});
    }
    renderer.AddPass(
        "pass.comp", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("pass.comp");
            for (auto& [name, bound] : all) {
                if (bound.binding.kind == rhi::BindingKind::UniformBuffer)
                    pass.UniformBytes(name, bound.bytes);
                else if (bound.binding.kind == rhi::BindingKind::SampledImage)
                    pass.Reads(name, bound.texture, rhi::SamplerDesc{});
                else if (IsImage(bound.binding) && !bound.binding.isWritable)
                    pass.Reads(name, bound.texture);
                else if (IsImage(bound.binding))
                    bound.texture =
                        bound.isInput ? pass.Updates(name, bound.texture) : pass.Writes(name, bound.texture);
                else if (!bound.binding.isWritable)
                    pass.Reads(name, bound.buffer);
                else
                    bound.buffer =
                        bound.isInput ? pass.Updates(name, bound.buffer) : pass.Writes(name, bound.buffer);
            }
            if (!pushed.empty()) pass.ConstantBytes(pushed);
        },
        [groups, covered](CommandList& commands) {
            if (groups)
                commands.Dispatch((*groups)[0], (*groups)[1], (*groups)[2]);
            else
                commands.DispatchOver(covered);
        });
    for (auto& [name, bound] : all)
        if (bound.isOutput)
            bound.result =
                IsImage(bound.binding) ? renderer.ReadBack(bound.texture) : renderer.ReadBack(bound.buffer);
    renderer.Execute();
    for (auto& [name, bound] : all) {
        if (bound.isOutput) bound.bytes = WaitForValues<std::byte>(bound.result);
        bound.result = {};  // it is of the device
    }
}

py::dict RunPass(const std::string& glsl, const py::dict& inputs, const py::dict& outputs,
                 const py::object& constants, const std::optional<std::array<uint32_t, 3>>& groups,
                 const std::string& includeRoot, const DevicePtr& chosen) {
    rhi::GlslSource source{.name = "pass.comp", .text = glsl, .stage = rhi::StageKind::Compute};
    source.includeRoot = includeRoot;
    std::vector<uint32_t> words = WithoutGil([&] { return rhi::CompileGlsl(source); });
    const rhi::ShaderReflection shader = rhi::Reflect(words, source.name);
    std::map<std::string, Bound> all;
    std::map<std::string, py::array> likes;  // of buffers that are outputs
    for (const rhi::Binding& binding : shader.bindings) all[binding.name].binding = binding;

    for (const auto& [key, value] : inputs) {
        Bound& bound = Find(all, key.cast<std::string>());
        bound.isInput = true;
        const auto object = py::reinterpret_borrow<py::object>(value);
        if (IsImage(bound.binding))
            TakeImage(bound, object);
        else
            bound.bytes = BytesOf(bound.binding.name, object);
    }
    Extent2D covered;
    for (const auto& [key, value] : outputs) {
        Bound& bound = Find(all, key.cast<std::string>());
        bound.isOutput = true;
        const auto object = py::reinterpret_borrow<py::object>(value);
        if (!bound.binding.isWritable)
            throw MakeError(ErrorKind::Usage, "{}: the shader does not write it", bound.binding.name);
        if (!IsImage(bound.binding)) {
            // A shape, which is what an image is given by, would be taken for an array of integers
            if (!py::hasattr(object, "dtype"))
                throw MakeError(
                    ErrorKind::Usage,
                    "{}: it is no array of numbers with the type and shape of the result, such as "
                    "numpy.zeros(5, numpy.float32)",
                    bound.binding.name);
            const py::array like = likes[bound.binding.name] = PlainArray(bound.binding.name, object);
            const auto size = static_cast<size_t>(like.nbytes());
            if (!bound.isInput)
                bound.bytes.resize(size);
            else if (size != bound.bytes.size())
                throw MakeError(ErrorKind::Usage, "{}: the output has {} bytes, the input of this name {}",
                                bound.binding.name, size, bound.bytes.size());
        } else if (!bound.isInput) {
            const auto size = object.cast<std::vector<uint32_t>>();
            if (size.size() < 2)
                throw MakeError(ErrorKind::Usage, "{}: an image is given by (height, width)",
                                bound.binding.name);
            bound.extent = {size[1], size[0]};
            bound.format = FormatOf(bound.binding, 4);
        }
        if (IsImage(bound.binding)) covered = bound.extent;
    }
    if (!groups && covered.IsEmpty())
        throw Error(ErrorKind::Usage,
                    "groups: without an image among the outputs their number must be given");
    for (const auto& [name, bound] : all)
        if (!bound.isInput && !bound.isOutput)
            throw MakeError(ErrorKind::Usage,
                            "{}: the shader has it, and it is neither an input nor an output", name);
    std::vector<std::byte> pushed;
    if (!constants.is_none()) pushed = BytesOf("constants", constants);
    if (pushed.size() != shader.pushConstants.bytes)
        throw MakeError(ErrorKind::Usage, "constants: they have {} bytes, the block of the shader has {}",
                        pushed.size(), shader.pushConstants.bytes);

    const DevicePtr device = DeviceOrDefault(chosen);
    if (pushed.size() > device->Info().maxPushConstantBytes)
        throw MakeError(
            ErrorKind::Usage,
            "constants: {} bytes are more than the {} of {}; a uniform block takes them as an input",
            pushed.size(), device->Info().maxPushConstantBytes, device->Info().name);
    all = Interruptibly([device, words = std::move(words), all = std::move(all), pushed = std::move(pushed),
                         groups, covered](session::Caller&) mutable {
        Run(*device, words, all, pushed, groups, covered);
        return std::move(all);
    });
    py::dict results;
    for (const auto& [key, value] : outputs) {
        const auto name = key.cast<std::string>();
        results[key] = ArrayOf(all.at(name), likes[name]);
    }
    return results;
}

}  // namespace

void BindPasses(py::module_& module) {
    module.def("run_pass", &RunPass);
}

}  // namespace raygraph::python
