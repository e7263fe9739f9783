#include "editor/graph_run/graph_run.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "base/files.h"
#include "base/median.h"
#include "base/printable.h"
#include "base/text.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/graph/readback_values.h"
#include "renderer/graph/renderer.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "rhi/reflection.h"
#include "rhi/shader_compiler.h"

namespace raygraph::graph_run {

namespace {

using rhi::ConstantType;

// Draws one triangle over the whole target; uv is (0, 0) in the upper left corner.
constexpr const char* kWholeTarget = R"(#version 460
layout(location = 0) out vec2 uv;
void main() {
    uv = vec2(gl_VertexIndex == 1 ? 2.0 : 0.0, gl_VertexIndex == 2 ? 2.0 : 0.0);
    gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0);
})";
constexpr const char* kWholeTargetName = "graph_run/whole_target.vert";

// The compiled shader of a pass.
struct PassShader {
    std::string name;
    rhi::ShaderInterface interface;
    std::vector<rhi::BlockMember> push;
};

// A texture or a buffer with what it begins with.
struct Resource {
    bool isTexture = false;
    GraphTextureDesc texture;
    GraphBufferDesc buffer;
    bool isPersistent = false;
    std::vector<std::byte> contents;  // empty: a persistent one begins with zeros
    // In the frame that is being declared:
    TextureId textureId;
    BufferId bufferId;
    bool isFilled = false;
};

// Returns the bits of the value in a shader; none if the type has no such value.
std::optional<uint32_t> WordOf(double value, ConstantType type) {
    const auto isWholeIn = [&](auto limits) {
        return value == std::floor(value) && value >= limits.min() && value <= limits.max();
    };
    switch (type) {
        case ConstantType::Float:
            if (std::abs(value) > std::numeric_limits<float>::max()) return std::nullopt;
            return std::bit_cast<uint32_t>(static_cast<float>(value));
        case ConstantType::Int:
            if (!isWholeIn(std::numeric_limits<int32_t>())) return std::nullopt;
            return static_cast<uint32_t>(static_cast<int32_t>(value));
        case ConstantType::Uint:
            if (!isWholeIn(std::numeric_limits<uint32_t>())) return std::nullopt;
            return static_cast<uint32_t>(value);
        case ConstantType::Bool:
            return value != 0.0 ? 1 : 0;
    }
    return std::nullopt;
}

const char* NameOf(ConstantType type) {
    constexpr const char* kNames[] = {"bool", "int", "uint", "float"};
    return kNames[static_cast<size_t>(type)];
}

// Returns the texels of a picture in a format, of which it may have fewer channels than the picture.
std::vector<std::byte> TexelsOf(const image::ImageF& picture, rhi::Format format) {
    const uint32_t channels = testing::ChannelCount(format);
    std::vector<float> values;
    values.reserve(picture.rgba.size() / 4 * channels);
    for (size_t i = 0; i < picture.rgba.size(); i += 4)
        for (uint32_t c = 0; c < channels; ++c) values.push_back(picture.rgba[i + c]);
    return testing::EncodeTexels(values, {picture.width, picture.height}, format);
}

image::ImageF ReadPicture(const std::filesystem::path& path) {
    const std::vector<std::byte> bytes = ReadFile(path, kMaxResourceBytes);
    const std::string name = path.filename().string();
    const image::FileFormat format = image::SniffFormat(bytes);
    if (format == image::FileFormat::Exr || format == image::FileFormat::Hdr)
        return image::DecodeFloats(bytes, name).image;
    const image::Image8 decoded =
        image::DecodeImage8(bytes, name, {.maxPixels = image::kEnvironmentLimits.maxPixels});
    image::ImageF picture{.width = decoded.width, .height = decoded.height, .rgba = {}};
    picture.rgba.reserve(decoded.rgba.size());
    for (const uint8_t value : decoded.rgba) picture.rgba.push_back(static_cast<float>(value) / 255.0f);
    return picture;
}

class Runner {
  public:
    Runner(rhi::Device& device, const GraphFile& graph) : m_graph(graph), m_renderer(device) {}

    GraphRun Run();

  private:
    [[noreturn]] void Fail(const std::string& where, std::string_view why) const {
        throw MakeError(ErrorKind::BadInput, "{}: {}: {}", Printable(m_graph.name, 1024),
                        Printable(where, 1024), why);
    }
    // Names the place in the description in an error about what stands there.
    template <typename Read>
    void At(const std::string& where, Read&& read) const {
        try {
            read();
        } catch (const Error& error) {
            const ErrorKind kind = error.Kind();
            if (kind != ErrorKind::Usage && kind != ErrorKind::Io && kind != ErrorKind::BadInput) throw;
            Fail(where, error.what());
        }
    }
    void LoadTexture(const std::string& name, const FileTexture& file);
    void LoadBuffer(const std::string& name, const FileBuffer& file);
    void SetSize(const std::string& name);
    void LoadShaders();
    void CheckBindings(const FilePass& pass, const PassShader& shader, const std::string& where) const;
    void CheckConstants(const FilePass& pass, const PassShader& shader, const std::string& where) const;
    void DeclareResources();
    void Begin(const std::string& name, Resource& resource);
    void Declare(const FilePass& pass, const PassShader& shader, uint32_t frame);
    void Bind(PassBuilder& builder, const rhi::Binding& binding, Resource& resource);
    std::optional<Extent2D> WrittenExtent(const FilePass& pass, const PassShader& shader) const;
    void DeclareFrame(uint32_t frame);
    void KeepOutputs();
    void ReadOutputs();
    void NoteTimings(std::map<std::string, std::vector<double>>& times);

    const GraphFile& m_graph;
    Renderer m_renderer;
    std::map<std::string, Resource> m_resources;
    std::vector<PassShader> m_shaders;               // by pass
    std::vector<std::vector<Readback>> m_readbacks;  // by output and layer, of the last frame
};

void Runner::LoadTexture(const std::string& name, const FileTexture& file) {
    Resource& resource = m_resources[name];
    resource.isTexture = true;
    resource.isPersistent = file.isPersistent || !file.file.empty();
    resource.texture = {.extent = file.size, .format = file.format, .layers = file.layers};
    if (file.file.empty() || LowerExtension(file.file) == ".bin") return;
    const std::string where = Text("textures.{}.file", name);
    if (rhi::IsUint(file.format)) Fail(where, "a picture has no integers; a .bin may have them");
    At(where, [&] {
        const image::ImageF picture = ReadPicture(m_graph.folder / file.file);
        resource.texture.extent = {picture.width, picture.height};
        resource.contents = TexelsOf(picture, file.format);
    });
}

// Completes a texture when all pictures are loaded: its size may be that of one.
void Runner::SetSize(const std::string& name) {
    Resource& resource = m_resources.at(name);
    const FileTexture& file = m_graph.textures.at(name);
    const FileTexture* sized = &file;
    std::string from = name;
    while (!sized->sizeOf.empty()) {
        from = sized->sizeOf;
        sized = &m_graph.textures.at(from);
    }
    resource.texture.extent = m_resources.at(from).texture.extent;
    const GraphTextureDesc& desc = resource.texture;
    const uint64_t bytes = TextureBytes(desc.format, desc.extent, desc.layers);
    if (bytes > kMaxResourceBytes)
        Fail(Text("textures.{}", name), Text("it has more than {}", BytesText(kMaxResourceBytes)));
    if (file.file.empty() || LowerExtension(file.file) != ".bin") return;
    const std::string where = Text("textures.{}.file", name);
    At(where, [&] { resource.contents = ReadFile(m_graph.folder / file.file, kMaxResourceBytes); });
    if (resource.contents.size() != bytes)
        Fail(where, Text("{} has {} bytes, the texture has {}", file.file, resource.contents.size(), bytes));
}

void Runner::LoadBuffer(const std::string& name, const FileBuffer& file) {
    Resource& resource = m_resources[name];
    resource.isPersistent = file.isPersistent || !file.file.empty();
    resource.buffer.size = file.bytes;
    if (!file.file.empty()) {
        const std::string where = Text("buffers.{}.file", name);
        At(where, [&] { resource.contents = ReadFile(m_graph.folder / file.file, kMaxResourceBytes); });
        resource.buffer.size = resource.contents.size();
        if (resource.contents.empty() || resource.contents.size() % 4 != 0)
            Fail(where,
                 Text("{} has {} bytes, a multiple of 4 is expected", file.file, resource.buffer.size));
    }
}

void Runner::LoadShaders() {
    m_renderer.AddShader(kWholeTargetName,
                         rhi::CompileGlsl({.name = kWholeTargetName, .text = kWholeTarget}));
    std::map<std::filesystem::path, PassShader> compiled;
    for (size_t i = 0; i < m_graph.passes.size(); ++i) {
        const FilePass& pass = m_graph.passes[i];
        const std::string where = Text("passes[{}]", i);
        auto [at, isNew] = compiled.try_emplace(pass.shader);
        PassShader& shader = at->second;
        if (isNew) {
            shader.name = pass.shader.generic_string();
            std::vector<uint32_t> words;
            const auto compile = [&] {
                words = rhi::CompileGlslFile({.name = shader.name, .includeRoot = m_graph.folder / ""});
            };
            // The messages of the compiler begin with file and line.
            try {
                compile();
            } catch (const Error& error) {
                if (error.Kind() != ErrorKind::Io) throw;
                Fail(where + ".shader", error.what());
            }
            At(where + ".shader", [&] {
                const rhi::NamedReflection stages[] = {{shader.name, rhi::Reflect(words, shader.name)}};
                shader.interface = rhi::MergeInterface(stages);
                m_renderer.AddShader(shader.name, words);
            });
            shader.push = rhi::PushConstantMembers(words);
        }
        CheckBindings(pass, shader, where);
        CheckConstants(pass, shader, where);
        m_shaders.push_back(shader);
    }
}

template <typename Named>
std::string NamesOf(const std::vector<Named>& all) {
    std::string text;
    for (const Named& each : all)
        if (!each.name.empty()) text.append(text.empty() ? "" : ", ").append(each.name);
    return text.empty() ? std::string("none") : text;
}

template <typename Named>
const Named* FindNamed(const std::vector<Named>& all, const std::string& name) {
    const auto found = std::ranges::find(all, name, &Named::name);
    return found == all.end() ? nullptr : &*found;
}

void Runner::CheckBindings(const FilePass& pass, const PassShader& shader, const std::string& where) const {
    const std::vector<rhi::BindingInfo>& bindings = shader.interface.bindings;
    for (const auto& [name, bound] : pass.bind) {
        const std::string place = Text("{}.bind.{}", where, name);
        const rhi::BindingInfo* binding = shader.interface.Find(name);
        if (!binding)
            Fail(place, Text("{} has no such binding; there are {}", shader.name, NamesOf(bindings)));
        const bool isImage = binding->kind == rhi::BindingKind::StorageImage ||
                             binding->kind == rhi::BindingKind::SampledImage;
        const bool isTexture = m_resources.at(bound).isTexture;
        if (isImage != isTexture)
            Fail(place, Text("{} has a {} there, and {} is a {}", shader.name, rhi::Name(binding->kind),
                             Quoted(bound), isTexture ? "texture" : "buffer"));
    }
    for (const rhi::BindingInfo& binding : bindings)
        if (binding.isUsed && !pass.bind.contains(binding.name))
            Fail(where, Text("bind lacks {}, which {} uses", binding.name, shader.name));
}

void Runner::CheckConstants(const FilePass& pass, const PassShader& shader, const std::string& where) const {
    const auto check = [&](double value, ConstantType type, const std::string& place) {
        if (!WordOf(value, type)) Fail(place, Text("{} is no value of type {}", value, NameOf(type)));
    };
    for (const auto& [name, value] : pass.push) {
        const std::string place = Text("{}.push.{}", where, name);
        const rhi::BlockMember* member = FindNamed(shader.push, name);
        if (!member)
            Fail(place,
                 Text("{} has no such push constant; there are {}", shader.name, NamesOf(shader.push)));
        if (member->count == 0) Fail(place, "it is neither a number nor a vector of 32-bit numbers");
        const auto* numbers = std::get_if<std::vector<double>>(&value);
        const size_t given = numbers ? numbers->size() : 1;
        if (given != member->count)
            Fail(place, Text("it has {}, the shader {}", Counted(given, "number"), member->count));
        if (numbers)
            for (const double number : *numbers) check(number, member->type, place);
    }
    for (const rhi::BlockMember& member : shader.push)
        if (!pass.push.contains(member.name))
            Fail(where, Text("push lacks {}, which {} has", member.name, shader.name));
    for (const auto& [name, value] : pass.specialize) {
        const std::string place = Text("{}.specialize.{}", where, name);
        const std::vector<rhi::SpecializationConstant>& constants = shader.interface.specialization;
        const rhi::SpecializationConstant* constant = FindNamed(constants, name);
        if (!constant)
            Fail(place, Text("{} has no such constant; there are {}", shader.name, NamesOf(constants)));
        check(value, constant->type, place);
    }
}

void Runner::DeclareResources() {
    for (auto& [name, resource] : m_resources) {
        resource.isFilled = resource.isPersistent;
        bool isFresh = false;
        if (resource.isTexture && resource.isPersistent) {
            resource.textureId = m_renderer.Persist(name, resource.texture, Persistence::Always);
            isFresh = m_renderer.IsFresh(resource.textureId);
        } else if (resource.isTexture) {
            resource.textureId = m_renderer.CreateTexture(name, resource.texture);
        } else if (resource.isPersistent) {
            resource.bufferId = m_renderer.PersistBuffer(name, resource.buffer, Persistence::Always);
            isFresh = m_renderer.IsFresh(resource.bufferId);
        } else {
            resource.bufferId = m_renderer.CreateBuffer(name, resource.buffer);
        }
        if (isFresh) Begin(name, resource);
    }
}

// Gives a persistent resource its first contents.
void Runner::Begin(const std::string& name, Resource& resource) {
    std::optional<BufferId> upload;
    if (!resource.contents.empty())
        upload = m_renderer.CreateBuffer(
            "contents of " + name, {.size = resource.contents.size(), .memory = rhi::MemoryKind::Upload});
    m_renderer.AddPass(
        "Begin " + name, PassKind::Transfer,
        [&](PassBuilder& pass) {
            if (upload) pass.CopiesFrom(*upload);
            if (resource.isTexture)
                resource.textureId = pass.CopiesTo(resource.textureId);
            else
                resource.bufferId = pass.CopiesTo(resource.bufferId);
        },
        [upload, resource = &resource, texture = resource.textureId, buffer = resource.bufferId](
            CommandList& commands, const PassResources& resources) {
            const std::vector<std::byte>& contents = resource->contents;
            if (upload) std::ranges::copy(contents, resources.Buffer(*upload).Mapped().begin());
            if (!resource->isTexture && upload) {
                commands.CopyBuffer(resources.Buffer(*upload), 0, resources.Buffer(buffer), 0,
                                    contents.size());
            } else if (!resource->isTexture) {
                commands.Fill(resources.Buffer(buffer), 0);
            } else if (upload) {
                const uint32_t layers = resource->texture.layers;
                for (uint32_t layer = 0; layer < layers; ++layer)
                    commands.CopyToTexture(resources.Buffer(*upload), contents.size() / layers * layer,
                                           resources.Texture(texture), 0, layer);
            } else {
                commands.Clear(resources.Texture(texture), {0.0f, 0.0f, 0.0f, 0.0f});
            }
        });
}

void Runner::Bind(PassBuilder& builder, const rhi::Binding& binding, Resource& resource) {
    // A transient that nothing has written yet has no contents that a shader could read.
    const bool isUpdate = binding.isReadable && resource.isFilled;
    const auto write = [&](auto& id) {
        id = isUpdate ? builder.Updates(binding.name, id) : builder.Writes(binding.name, id);
    };
    rhi::SamplerDesc sampler;
    if (rhi::IsUint(resource.texture.format))  // Vulkan filters no integers
        sampler.magFilter = sampler.minFilter = sampler.mipFilter = rhi::Filter::Nearest;
    if (binding.kind == rhi::BindingKind::SampledImage)
        builder.Reads(binding.name, resource.textureId, sampler);
    else if (!binding.isWritable && resource.isTexture)
        builder.Reads(binding.name, resource.textureId);
    else if (!binding.isWritable)
        builder.Reads(binding.name, resource.bufferId);
    else if (resource.isTexture)
        write(resource.textureId);
    else
        write(resource.bufferId);
    resource.isFilled = resource.isFilled || binding.isWritable;
}

// Returns the extent of the first texture that the pass writes, in the order of the shader's bindings.
std::optional<Extent2D> Runner::WrittenExtent(const FilePass& pass, const PassShader& shader) const {
    for (const rhi::BindingInfo& binding : shader.interface.bindings) {
        const auto bound = pass.bind.find(binding.name);
        if (bound == pass.bind.end() || !binding.isWritable) continue;
        const Resource& written = m_resources.at(bound->second);
        if (written.isTexture) return written.texture.extent;
    }
    return std::nullopt;
}

void Runner::Declare(const FilePass& pass, const PassShader& shader, uint32_t frame) {
    const bool isFragment = !pass.targets.empty();
    const std::optional<Extent2D> over =
        pass.over.empty() ? WrittenExtent(pass, shader) : m_resources.at(pass.over).texture.extent;
    if (!isFragment && !pass.groups && !over)
        throw Error(ErrorKind::Usage, "it needs a dispatch, since it writes no texture");
    m_renderer.AddPass(
        pass.name, isFragment ? PassKind::Raster : PassKind::Compute,
        [&](PassBuilder& builder) {
            if (isFragment)
                builder.Vertex(kWholeTargetName).Fragment(shader.name);
            else
                builder.Compute(shader.name);
            if (pass.isAsync) builder.AsyncCompute();
            for (const auto& [name, value] : pass.specialize)
                builder.Specialize(name,
                                   *WordOf(value, FindNamed(shader.interface.specialization, name)->type));
            for (const rhi::BindingInfo& binding : shader.interface.bindings)
                if (const auto bound = pass.bind.find(binding.name); bound != pass.bind.end())
                    Bind(builder, binding, m_resources.at(bound->second));
            for (uint32_t i = 0; i < pass.targets.size(); ++i) {
                Resource& target = m_resources.at(pass.targets[i]);
                target.textureId = builder.ColorTarget(i, target.textureId);
                target.isFilled = true;
            }
            if (shader.push.empty()) return;
            std::vector<std::byte> bytes(shader.interface.pushConstants.bytes);
            for (const rhi::BlockMember& member : shader.push) {
                const auto* numbers = std::get_if<std::vector<double>>(&pass.push.at(member.name));
                for (uint32_t c = 0; c < member.count; ++c) {
                    const uint32_t word = *WordOf(numbers ? (*numbers)[c] : frame, member.type);
                    std::memcpy(bytes.data() + member.offset + 4 * c, &word, sizeof word);
                }
            }
            builder.ConstantBytes(bytes);
        },
        [isFragment, groups = pass.groups, over](CommandList& commands) {
            if (isFragment)
                commands.Draw(3);
            else if (groups)
                commands.Dispatch((*groups)[0], (*groups)[1], (*groups)[2]);
            else
                commands.DispatchOver(*over);
        });
}

void Runner::DeclareFrame(uint32_t frame) {
    m_renderer.BeginFrame();
    DeclareResources();
    // The graph's own messages name pass and binding.
    for (size_t i = 0; i < m_graph.passes.size(); ++i)
        At(Text("passes[{}]", i), [&] { Declare(m_graph.passes[i], m_shaders[i], frame); });
    for (const FileOutput& output : m_graph.outputs)
        if (!m_resources.at(output.resource).isFilled)
            Fail(Text("outputs.{}", output.file), Text("no pass writes {}", Quoted(output.resource)));
}

// Frames before the last one execute the passes that lead to an output, too.
void Runner::KeepOutputs() {
    m_renderer.AddPass(
        "Keep outputs", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.KeepAlive();
            for (const FileOutput& output : m_graph.outputs) {
                const Resource& resource = m_resources.at(output.resource);
                if (resource.isTexture)
                    pass.CopiesFrom(resource.textureId);
                else
                    pass.CopiesFrom(resource.bufferId);
            }
        },
        [](CommandList&) {});
}

void Runner::ReadOutputs() {
    for (const FileOutput& output : m_graph.outputs) {
        const Resource& resource = m_resources.at(output.resource);
        std::vector<Readback>& layers = m_readbacks.emplace_back();
        if (!resource.isTexture)
            layers.push_back(m_renderer.ReadBack(resource.bufferId));
        else if (LowerExtension(output.file) != ".bin")
            layers.push_back(m_renderer.ReadBack(resource.textureId, 0, output.layer));
        else
            for (uint32_t layer = 0; layer < resource.texture.layers; ++layer)
                layers.push_back(m_renderer.ReadBack(resource.textureId, 0, layer));
    }
}

void Runner::NoteTimings(std::map<std::string, std::vector<double>>& times) {
    for (const FrameTiming& timing : m_renderer.TakeTimings())
        for (const PassTiming& pass : timing.passes) times[pass.name].push_back(pass.gpuMs);
}

GraphRun Runner::Run() {
    for (const auto& [name, file] : m_graph.textures) LoadTexture(name, file);
    for (const auto& [name, file] : m_graph.textures) SetSize(name);
    for (const auto& [name, file] : m_graph.buffers) LoadBuffer(name, file);
    LoadShaders();
    std::map<std::string, std::vector<double>> times;
    for (uint32_t frame = 0; frame < m_graph.frames; ++frame) {
        DeclareFrame(frame);
        if (frame + 1 < m_graph.frames)
            KeepOutputs();
        else
            ReadOutputs();
        m_renderer.Execute();
        NoteTimings(times);
    }
    m_renderer.Device().WaitIdle();
    NoteTimings(times);
    GraphRun run;
    run.plan = m_renderer.DescribePlan();
    run.dot = m_renderer.DescribePlanDot();
    // The graph has passes of its own, which read outputs back.
    for (const PassTiming& pass : m_renderer.Timing().passes)
        if (std::ranges::find(m_graph.passes, pass.name, &FilePass::name) != m_graph.passes.end())
            run.passes.push_back({.name = pass.name, .gpuMs = Median(times[pass.name])});
    for (size_t i = 0; i < m_readbacks.size(); ++i) {
        const Resource& resource = m_resources.at(m_graph.outputs[i].resource);
        OutputValues& values = run.outputs.emplace_back();
        values.format = resource.isTexture ? resource.texture.format : rhi::Format::Undefined;
        values.extent = resource.texture.extent;
        for (const Readback& layer : m_readbacks[i]) {
            const auto bytes = WaitForValues<std::byte>(layer);
            values.bytes.insert(values.bytes.end(), bytes.begin(), bytes.end());
        }
    }
    return run;
}

void WriteOutputExr(const OutputValues& values, const std::filesystem::path& file) {
    static constexpr const char* kNames[4][4] = {{"Y"}, {"R", "G"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
    const uint32_t channels = testing::ChannelCount(values.format);
    const testing::Texels texels = testing::DecodeTexels(values.bytes, values.extent, values.format);
    // Floats have not all integers.
    std::vector<uint32_t> words;
    if (rhi::IsUint(values.format)) {
        words.resize(values.bytes.size() / sizeof(uint32_t));
        std::memcpy(words.data(), values.bytes.data(), words.size() * sizeof(uint32_t));
    }
    std::vector<image::ExrPlane> planes(channels);
    for (uint32_t c = 0; c < channels; ++c) {
        planes[c] = {.name = kNames[channels - 1][c], .samples = {}, .stride = channels};
        if (words.empty())
            planes[c].samples = std::span<const float>(texels.values).subspan(c);
        else
            planes[c].samples = std::span<const uint32_t>(words).subspan(c);
    }
    image::WriteExr(file, values.extent.width, values.extent.height, planes);
}

void WriteOutputPng(const OutputValues& values, const std::filesystem::path& file) {
    const uint32_t channels = testing::ChannelCount(values.format);
    const testing::Texels texels = testing::DecodeTexels(values.bytes, values.extent, values.format);
    image::Image8 image{.width = values.extent.width, .height = values.extent.height, .rgba = {}};
    image.rgba.reserve(size_t{4} * image.width * image.height);
    for (size_t i = 0; i < texels.values.size(); i += channels)
        for (uint32_t c = 0; c < 4; ++c) {
            // One channel is shown as gray; alpha is opaque where there is none.
            float value = c == 3 ? 1.0f : 0.0f;
            if (c < channels) value = texels.values[i + c];
            if (channels == 1 && c < 3) value = texels.values[i];
            image.rgba.push_back(
                static_cast<uint8_t>(std::lround(255.0f * (value > 0.0f ? std::min(value, 1.0f) : 0.0f))));
        }
    image::WritePng(file, image);
}

}  // namespace

GraphRun RunGraph(rhi::Device& device, const GraphFile& graph) {
    try {
        return Runner(device, graph).Run();
    } catch (const Error& error) {
        // A resource that the device cannot have is found when a frame is compiled.
        if (error.Kind() != ErrorKind::Usage) throw;
        throw MakeError(ErrorKind::BadInput, "{}: {}", Printable(graph.name, 1024), error.what());
    }
}

void WriteOutput(const OutputValues& values, const std::filesystem::path& file) {
    const std::string extension = LowerExtension(file);
    if (extension == ".exr") return WriteOutputExr(values, file);
    if (extension == ".png") return WriteOutputPng(values, file);
    AtomicFile raw(file);
    raw.Write(values.bytes);
    raw.Commit();
}

}  // namespace raygraph::graph_run
