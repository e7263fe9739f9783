#include "renderer/graph/pass_declaration.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

template <typename... Values>
[[noreturn]] void Fail(const GraphPass& pass, fmt::format_string<Values...> format, Values&&... values) {
    throw MakeError(ErrorKind::Usage, "pass {} {}", Quoted(pass.name),
                    Text(format, std::forward<Values>(values)...));
}

const char* Verb(BindVerb verb) {
    switch (verb) {
        case BindVerb::Reads:
            return "reads";
        case BindVerb::Writes:
            return "writes";
        case BindVerb::Updates:
            return "updates";
        case BindVerb::Uniform:
            return "gives uniform data for";
    }
    return "?";
}

// Returns text such as "storage image, write".
std::string KindText(const rhi::BindingInfo& info) {
    std::string text = rhi::Name(info.kind);
    if (info.kind == rhi::BindingKind::StorageImage || info.kind == rhi::BindingKind::StorageBuffer ||
        info.kind == rhi::BindingKind::BufferAddress)
        text += !info.isWritable ? ", read" : info.isReadable ? ", read+write" : ", write";
    return text;
}

// Returns "pathtrace/pathtrace.rgen has sceneTlas (acceleration structure), radiance (storage image, write)".
std::string BindingsText(const rhi::ShaderInterface& interface) {
    if (interface.bindings.empty()) return "its shaders bind nothing by name";
    std::string text;
    std::string shader;
    for (const rhi::BindingInfo& info : interface.bindings) {
        const bool isSame = info.firstShader == shader;
        text += text.empty() ? "" : isSame ? ", " : "; ";
        if (!isSame) text += Text("{} has ", info.firstShader);
        text += Text("{} ({})", info.name, KindText(info));
        shader = info.firstShader;
    }
    return text;
}

std::string AskedKind(const DeclaredBinding& bound) {
    switch (bound.kind) {
        case ResourceKind::Texture:
            return bound.sampler ? "a sampled texture" : "a storage image";
        case ResourceKind::Tlas:
            return "an acceleration structure";
        default:
            return bound.verb == BindVerb::Uniform ? "uniform data" : "a buffer";
    }
}

bool FitsKind(const DeclaredBinding& bound, rhi::BindingKind kind) {
    switch (kind) {
        case rhi::BindingKind::StorageImage:
            return bound.kind == ResourceKind::Texture && !bound.sampler;
        case rhi::BindingKind::SampledImage:
            return bound.kind == ResourceKind::Texture && bound.sampler;
        case rhi::BindingKind::AccelerationStructure:
            return bound.kind == ResourceKind::Tlas;
        case rhi::BindingKind::StorageBuffer:
        case rhi::BindingKind::BufferAddress:
            return bound.kind == ResourceKind::Buffer && bound.verb != BindVerb::Uniform;
        case rhi::BindingKind::UniformBuffer:
            return bound.kind == ResourceKind::Buffer;
    }
    return false;
}

// A C++ struct may end in padding that the shader's block does not have.
bool SizesAgree(uint64_t given, uint64_t block, size_t alignment) {
    return given == block || (given > block && given - block < alignment);
}

void CheckWritability(const GraphPass& pass, const DeclaredBinding& bound, const rhi::BindingInfo& info) {
    const auto what = [&] {
        return Text("{} {}, which {}", Verb(bound.verb), Quoted(bound.name), info.firstShader);
    };
    if (bound.verb != BindVerb::Reads && !info.isWritable)
        Fail(pass, "{} declares readonly ({})", what(), KindText(info));
    if (bound.verb != BindVerb::Writes && !info.isReadable)
        Fail(pass, "{} declares writeonly ({})", what(), KindText(info));
    if (bound.verb == BindVerb::Reads && info.isWritable)
        Fail(pass, "{} may write ({}): declare it readonly there, or write or update it here", what(),
             KindText(info));
}

void CheckContents(const FrameGraph& graph, const GraphPass& pass, const DeclaredBinding& bound,
                   const rhi::BindingInfo& info, const BindingLimits& limits) {
    if (info.kind == rhi::BindingKind::UniformBuffer && info.blockBytes > limits.uniformBlock)
        Fail(pass, "binds {} of {} in {}; on this device a uniform block has at most {}", Quoted(bound.name),
             BytesText(info.blockBytes), info.firstShader, BytesText(limits.uniformBlock));
    if (bound.verb == BindVerb::Uniform) {
        if (!SizesAgree(bound.uniformBytes, info.blockBytes, std::max(bound.uniformAlignment, 16u)))
            Fail(pass, "gives {} bytes for {}, which has {} in {}", bound.uniformBytes, Quoted(bound.name),
                 info.blockBytes, info.firstShader);
        return;
    }
    const GraphResource& resource = graph.resources[bound.resource];
    if (info.kind == rhi::BindingKind::StorageBuffer && resource.bytes > limits.storageBuffer)
        Fail(pass, "binds {} to {} of {}; on this device a shader can bind {}", Quoted(bound.name),
             Quoted(resource.name), BytesText(resource.bytes), BytesText(limits.storageBuffer));
    if (bound.kind == ResourceKind::Buffer && resource.bytes < info.blockBytes)
        Fail(pass, "binds {} to {} of {}; {} needs at least {}", Quoted(bound.name), Quoted(resource.name),
             BytesText(resource.bytes), info.firstShader, BytesText(info.blockBytes));
    if (info.kind == rhi::BindingKind::StorageImage && info.imageFormat != rhi::Format::Undefined &&
        info.imageFormat != resource.format)
        Fail(pass, "binds {} to {} of format {}; {} declares {}", Quoted(bound.name), Quoted(resource.name),
             rhi::Name(resource.format), info.firstShader, rhi::Name(info.imageFormat));
    const rhi::TexelType texels = rhi::IsUint(resource.format) ? rhi::TexelType::Uint : rhi::TexelType::Float;
    if (bound.kind == ResourceKind::Texture && info.texelType != texels)
        Fail(pass, "binds {} to {} of format {}, of {} texels; in {} they are {}", Quoted(bound.name),
             Quoted(resource.name), rhi::Name(resource.format), rhi::Name(texels), info.firstShader,
             rhi::Name(info.texelType));
}

// The view that the shader declares must fit the part that is bound.
void CheckView(const FrameGraph& graph, const GraphPass& pass, const DeclaredBinding& bound,
               const rhi::BindingInfo& info) {
    const GraphResource& resource = graph.resources[bound.resource];
    const Subresources& part = graph.uses[bound.use].part;
    const auto fail = [&](const std::string& parts, const std::string& why) {
        Fail(pass, "binds {} to {} of {}: {}", Quoted(bound.name), parts, Quoted(resource.name), why);
    };
    if (info.kind == rhi::BindingKind::StorageImage && part.levelCount != 1)
        fail(Text("{} levels", part.levelCount), "a storage image is one, as in Level(0)");
    const auto layers = [&] { return Counted(part.layerCount, "layer"); };
    const auto shape = [&](const char* has) {
        return Text("in {} it is a {}, of {}", info.firstShader, rhi::Name(info.shape), has);
    };
    if (info.shape == rhi::ImageShape::Plain && part.layerCount != 1)
        fail(layers(), shape("one layer, as in Layer(0)"));
    const bool isSquare = resource.extent.width == resource.extent.height;
    if (info.shape == rhi::ImageShape::Cube && (part.layerCount != 6 || !isSquare))
        fail(Text("{} of {}x{}", layers(), resource.extent.width, resource.extent.height),
             shape("six square layers"));
}

// Returns the place of a binding in the interface. It tries `guess` first, since a name is mostly bound to
// what it was in the last frame.
size_t PlaceOf(const rhi::ShaderInterface& interface, const GraphPass& pass, std::string_view name,
               size_t guess) {
    const std::vector<rhi::BindingInfo>& bindings = interface.bindings;
    if (guess < bindings.size() && bindings[guess].name == name) return guess;
    const rhi::BindingInfo* info = interface.Find(name);
    if (!info) Fail(pass, "binds {}: no such binding; {}", Quoted(name), BindingsText(interface));
    return static_cast<size_t>(info - bindings.data());
}

void ResolveBinding(FrameGraph& graph, const GraphPass& pass, DeclaredBinding& bound,
                    const rhi::BindingInfo* info, const BindingLimits& limits) {
    if (!FitsKind(bound, info->kind))
        Fail(pass, "binds {} as {}; in {} it is a {}", Quoted(bound.name), AskedKind(bound),
             info->firstShader, rhi::Name(info->kind));
    if (info->kind == rhi::BindingKind::UniformBuffer) {
        if (bound.verb == BindVerb::Writes || bound.verb == BindVerb::Updates)
            Fail(pass, "{} {}, a uniform buffer in {}", Verb(bound.verb), Quoted(bound.name),
                 info->firstShader);
        if (bound.use != kNone) {
            graph.uses[bound.use].access = Access::Uniform;
            bound.uniformBytes = info->blockBytes;
        }
    } else if (info->kind == rhi::BindingKind::StorageBuffer ||
               info->kind == rhi::BindingKind::StorageImage ||
               info->kind == rhi::BindingKind::BufferAddress) {
        CheckWritability(pass, bound, *info);
    }
    CheckContents(graph, pass, bound, *info, limits);
    if (bound.kind == ResourceKind::Texture) {
        CheckView(graph, pass, bound, *info);
        bound.shape = info->shape;
        bound.isPart =
            graph.resources[bound.resource].SubresourceCount() > 1 || bound.shape != rhi::ImageShape::Plain;
    }
    bound.binding = info->binding;
    bound.element = info->element;
    bound.type = rhi::ToVk(info->kind);
    bound.isAddress = info->kind == rhi::BindingKind::BufferAddress;
    bound.addressOffset = info->offset;
}

// Lists the address tables of the shaders. All addresses of a block are listed, including those that the pass
// does not need.
void ListAddressTables(const rhi::ShaderInterface& interface, std::vector<AddressTable>& tables) {
    tables.clear();
    for (const rhi::BindingInfo& info : interface.bindings) {
        if (info.kind != rhi::BindingKind::BufferAddress) continue;
        if (tables.empty() || tables.back().binding != info.binding)
            tables.push_back({.binding = info.binding});
        tables.back().bytes = info.offset + static_cast<uint32_t>(sizeof(VkDeviceAddress));
    }
}

void CheckConstants(const GraphPass& pass, const PassDeclaration& declared,
                    const rhi::ShaderInterface& interface) {
    const uint32_t block = interface.pushConstants.bytes;
    if (!declared.hasConstants) {
        if (block != 0)
            Fail(pass, "gives no constants; {} has {} bytes of push constants", interface.pushConstantShader,
                 block);
        return;
    }
    if (block == 0)
        Fail(pass, "gives {} bytes of constants; its shaders have no push constants",
             declared.constants.size());
    if (!SizesAgree(declared.constants.size(), block, declared.constantAlignment))
        Fail(pass, "gives {} bytes of constants; {} has {} bytes of push constants",
             declared.constants.size(), interface.pushConstantShader, block);
}

// Every binding that a shader uses must be bound: using an unbound one is undefined behavior. Those that are
// have their place in isPlaced.
void CheckComplete(const GraphPass& pass, const PassDeclaration& declared,
                   const rhi::ShaderInterface& interface) {
    std::string missing;
    for (size_t place = 0; place < interface.bindings.size(); ++place) {
        const rhi::BindingInfo& info = interface.bindings[place];
        if (info.isUsed && !declared.isPlaced[place])
            missing += Text("{}{} ({}, in {})", missing.empty() ? "" : ", ", info.name, KindText(info),
                            info.firstShader);
    }
    if (!missing.empty()) Fail(pass, "does not bind what its shaders use: {}", missing);
    if (interface.usesTextureTable && declared.textureSet == kNone)
        Fail(pass, "uses no texture set, but its shaders read the bindless textures of set 1");
}

}  // namespace

void PassDeclaration::Clear(PassKind kind, Program* lastProgram) {
    request.Clear(kind);
    guess = lastProgram;
    bindings.clear();
    addressTables.clear();
    textureSet = kNone;
    colors.clear();
    depth = kNone;
    depthLoad = {};
    depthPart = {};
    hasConstants = false;
    constantAlignment = 1;
    constants.clear();
    isDividable = kind == PassKind::Compute;
}

void CheckShaders(const GraphPass& pass, const ProgramRequest& request) {
    const std::string kind = Text("is of kind {}", Name(pass.kind));
    const bool isTracing = pass.kind == PassKind::RayTracing;
    const bool isCompute = pass.kind == PassKind::Compute;
    const bool isRaster = pass.kind == PassKind::Raster;
    if (isTracing && !request.rayGen) Fail(pass, "{} and names no ray-generation shader (RayGen)", kind);
    if (isCompute && !request.compute) Fail(pass, "{} and names no compute shader (Compute)", kind);
    if (isRaster && !request.vertex) Fail(pass, "{} and names no vertex shader (Vertex)", kind);
    if (request.maxRecursion != 1 && !isTracing)
        Fail(pass, "{} and cannot have a ray recursion (MaxRecursion)", kind);
    std::vector<const Shader*> shaders;
    request.ListShaders(shaders);
    for (const Shader* shader : shaders) {
        const rhi::StageKind stage = shader->reflection.stage;
        const bool isRasterStage = stage == rhi::StageKind::Vertex || stage == rhi::StageKind::Fragment;
        const bool isComputeStage = stage == rhi::StageKind::Compute;
        const bool fits = isRaster    ? isRasterStage
                          : isCompute ? isComputeStage
                          : isTracing ? !isRasterStage && !isComputeStage
                                      : false;
        if (!fits) Fail(pass, "{} and cannot run {}, a {} shader", kind, shader->name, rhi::Name(stage));
    }
}

void ResolveBindings(FrameGraph& graph, PassDeclaration& declared, const rhi::ShaderInterface* interface,
                     const BindingLimits& limits) {
    const GraphPass& pass = graph.passes.back();
    if (!interface) {
        const auto fail = [&](const std::string& what) {
            Fail(pass, "is of kind {} and has no shaders: it cannot {}", Name(pass.kind), what);
        };
        if (!declared.bindings.empty()) fail("bind " + Quoted(declared.bindings[0].name));
        if (declared.hasConstants) fail("take constants");
        return;
    }
    std::vector<size_t>& places = declared.places;
    if (places.size() < declared.bindings.size()) places.resize(declared.bindings.size());
    declared.isPlaced.assign(interface->bindings.size(), 0);
    for (size_t i = 0; i < declared.bindings.size(); ++i) {
        DeclaredBinding& bound = declared.bindings[i];
        places[i] = PlaceOf(*interface, pass, bound.name, places[i]);
        if (std::exchange(declared.isPlaced[places[i]], uint8_t{1}))
            Fail(pass, "binds {} twice", Quoted(bound.name));
        ResolveBinding(graph, pass, bound, &interface->bindings[places[i]], limits);
    }
    ListAddressTables(*interface, declared.addressTables);
    CheckComplete(pass, declared, *interface);
    CheckConstants(pass, declared, *interface);
}

void ResolveTargets(const FrameGraph& graph, PassDeclaration& declared, bool hasLayeredTargets) {
    const GraphPass& pass = graph.passes.back();
    if (pass.kind != PassKind::Raster) return;
    if (declared.colors.empty() && declared.depth == kNone)
        Fail(pass, "is of kind raster and has neither a color nor a depth target");
    std::ranges::sort(declared.colors, {}, &DeclaredColor::index);
    const GraphResource* first = nullptr;
    rhi::Extent2D extent;
    uint32_t layerCount = 1;
    const Shader* vertex = declared.request.vertex;
    if (vertex && vertex->reflection.writesLayer && !hasLayeredTargets)
        Fail(pass,
             "runs {}, which writes gl_Layer, but the device has no layered targets (shaderOutputLayer)",
             vertex->name);
    if (declared.colors.size() > rhi::kMaxColorTargets)
        Fail(pass, "has {} color targets, at most {}", declared.colors.size(), rhi::kMaxColorTargets);
    const auto checkShape = [&](const GraphResource& target, const Subresources& part) {
        if (part.levelCount != 1)
            Fail(pass, "draws to {} levels of {}: a target is one level, as in Level(0)", part.levelCount,
                 Quoted(target.name));
        if (part.layerCount != 1 && !(vertex && vertex->reflection.writesLayer))
            Fail(pass,
                 "draws to {} layers of {}, but its vertex shader does not write gl_Layer; one is Layer(0)",
                 part.layerCount, Quoted(target.name));
        const rhi::Extent2D own = rhi::MipExtent(target.extent, part.level);
        if (!first) {
            first = &target;
            extent = own;
            layerCount = part.layerCount;
        }
        if (part.layerCount != layerCount)
            Fail(pass, "draws to {} of {} and to {} of {}", Counted(layerCount, "layer"), Quoted(first->name),
                 Counted(part.layerCount, "layer"), Quoted(target.name));
        if (extent != own)
            Fail(pass, "draws to {} of {}x{} and to {} of {}x{}", Quoted(first->name), extent.width,
                 extent.height, Quoted(target.name), own.width, own.height);
    };
    for (size_t i = 0; i < declared.colors.size(); ++i) {
        if (declared.colors[i].index != i)
            Fail(pass, "has no color target {}, but one at {}", i, declared.colors[i].index);
        const GraphResource& target = graph.resources[declared.colors[i].resource];
        if (rhi::IsDepth(target.format))
            Fail(pass, "has {} of format {} as color target", Quoted(target.name), rhi::Name(target.format));
        checkShape(target, declared.colors[i].part);
        declared.request.colorFormats.push_back(target.format);
    }
    if (declared.depth == kNone) return;
    const GraphResource& target = graph.resources[declared.depth];
    if (!rhi::IsDepth(target.format))
        Fail(pass, "has {} of format {} as depth target", Quoted(target.name), rhi::Name(target.format));
    checkShape(target, declared.depthPart);
    declared.request.depthFormat = target.format;
}

PassMarks::PassMarks(rhi::Device& device)
    : m_words(device.CreateBuffer({.name = "pass marks",
                                   .size = uint64_t{device.FramesInFlight()} * kMaxPasses * sizeof(uint32_t),
                                   .usage = rhi::BufferUsage::CopyDestination,
                                   .memory = rhi::MemoryKind::Readback})),
      m_frames(device.FramesInFlight()) {
    std::memset(m_words.Mapped().data(), 0, m_words.Mapped().size());
}

void PassMarks::BeginFrame(uint64_t number, const FrameGraph& graph, const Plan& plan) {
    const std::lock_guard lock(m_mutex);
    m_slot = number % m_frames.size();
    m_marked = 0;
    Frame& frame = m_frames[m_slot];
    frame.number = number;
    frame.passCount = static_cast<uint32_t>(std::min<size_t>(plan.passes.size(), kMaxPasses));
    if (frame.passes.size() < frame.passCount) frame.passes.resize(frame.passCount);
    for (uint32_t i = 0; i < frame.passCount; ++i) frame.passes[i] = graph.passes[plan.passes[i].pass].name;
    frame.queues.assign(plan.passes.size(), rhi::QueueKind::Main);
    for (const PlannedBatch& batch : plan.batches)
        std::fill_n(frame.queues.begin() + batch.firstPass, batch.passCount, batch.queue);
}

void PassMarks::Mark(rhi::CommandList& commands) {
    const Frame& frame = m_frames[m_slot];  // only this thread changes it
    if (m_marked == frame.passCount) return;
    commands.Fill(m_words, ValueOf(frame.number), OffsetOf(m_slot, m_marked++), sizeof(uint32_t));
}

std::string PassMarks::Report() const {
    const std::lock_guard lock(m_mutex);
    const Frame* newest = nullptr;
    std::array<size_t, rhi::kQueueKinds.size()> reached{};  // by queue: passes up to the last mark
    for (size_t slot = 0; slot < m_frames.size(); ++slot) {
        const Frame& frame = m_frames[slot];
        for (size_t pass = 0; pass < frame.passCount; ++pass) {
            uint32_t word = 0;
            std::memcpy(&word, m_words.Mapped().data() + OffsetOf(slot, pass), sizeof word);
            if (word != ValueOf(frame.number) || (newest && newest->number > frame.number)) continue;
            if (newest != &frame) reached = {};
            newest = &frame;
            reached[static_cast<size_t>(frame.queues[pass])] = pass + 1;
        }
    }
    if (!newest) return {};
    const auto passText = [&](size_t count) {
        return Text("pass {} ({} of {})", Quoted(newest->passes[count - 1]), count, newest->passCount);
    };
    const size_t onMain = reached[static_cast<size_t>(rhi::QueueKind::Main)];
    const size_t onCompute = reached[static_cast<size_t>(rhi::QueueKind::Compute)];
    if (onMain != 0 && onCompute != 0)
        return Text("the last passes reached were {} and, on the compute queue, {} of frame {}",
                    passText(onMain), passText(onCompute), newest->number);
    return Text("the last pass reached was {} of frame {}", passText(std::max(onMain, onCompute)),
                newest->number);
}

}  // namespace raygraph
