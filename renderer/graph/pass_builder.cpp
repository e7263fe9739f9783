#include "renderer/graph/pass_builder.h"

#include <algorithm>

#include "base/text.h"
#include "renderer/graph/renderer_impl.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

std::string PassText(const FrameGraph& graph) {
    return "pass " + Quoted(graph.passes.back().name);
}

}  // namespace

// Returns null for "": the stage is left out.
const Shader* PassBuilder::FindShader(std::string_view name) {
    if (name.empty()) return nullptr;
    if (m_pass.guess)
        for (const Shader* shader : m_pass.guess->Shaders())
            if (shader->name == name) return shader;
    try {
        return &m_shaders.Find(name);
    } catch (const Error& error) {
        throw MakeError(error.Kind(), "{}: {}", PassText(m_graph), error.what());
    }
}

PassBuilder& PassBuilder::RayGen(std::string_view shader) {
    m_pass.request.rayGen = FindShader(shader);
    return *this;
}

PassBuilder& PassBuilder::Miss(RayType rayType, std::string_view shader) {
    m_pass.request.miss[static_cast<size_t>(rayType)] = FindShader(shader);
    return *this;
}

PassBuilder& PassBuilder::HitGroup(RayType rayType, const HitGroupShaders& shaders, uint32_t hitSet) {
    constexpr uint32_t kMaxHitSets = 1024;
    if (hitSet >= kMaxHitSets)
        throw MakeError(ErrorKind::Usage, "{}: hit set {} is beyond the last one possible, {}",
                        PassText(m_graph), hitSet, kMaxHitSets - 1);
    auto& groups = m_pass.request.hitGroups;
    std::erase_if(groups, [&](const HitGroupRequest& group) {
        return group.hitSet == hitSet && group.rayType == rayType;
    });
    groups.push_back({.hitSet = hitSet,
                      .rayType = rayType,
                      .closestHit = FindShader(shaders.closestHit),
                      .anyHit = FindShader(shaders.anyHit),
                      .intersection = FindShader(shaders.intersection)});
    return *this;
}

PassBuilder& PassBuilder::Callable(std::string_view shader) {
    m_pass.request.callables.push_back(FindShader(shader));
    return *this;
}

PassBuilder& PassBuilder::MaxRecursion(uint32_t depth) {
    const rhi::DeviceInfo& device = m_renderer.Device().Info();
    if (depth == 0)
        throw MakeError(ErrorKind::Usage,
                        "{} asks for a ray recursion of 0; ray generation itself traces at 1",
                        PassText(m_graph));
    if (depth > device.maxRayRecursionDepth)
        throw MakeError(ErrorKind::Usage, "{} asks for a ray recursion of {}; the device {} allows {}",
                        PassText(m_graph), depth, device.name, device.maxRayRecursionDepth);
    m_pass.request.maxRecursion = depth;
    return *this;
}

PassBuilder& PassBuilder::Compute(std::string_view shader) {
    m_pass.request.compute = FindShader(shader);
    return *this;
}

PassBuilder& PassBuilder::Vertex(std::string_view shader) {
    m_pass.request.vertex = FindShader(shader);
    return *this;
}

PassBuilder& PassBuilder::Fragment(std::string_view shader) {
    m_pass.request.fragment = FindShader(shader);
    return *this;
}

PassBuilder& PassBuilder::Raster(const RasterState& state) {
    m_pass.request.raster = state;
    return *this;
}

PassBuilder& PassBuilder::Specialize(std::string_view constant, uint32_t value) {
    m_pass.request.specialization.push_back({.name = m_graph.Keep(constant), .value = value});
    return *this;
}

template <ResourceKind Kind>
ResourceId<Kind> PassBuilder::Bind(std::string_view name, ResourceId<Kind> id, BindVerb verb, Access access,
                                   const rhi::Sampler* sampler, const Subresources& part) {
    return AddBinding(m_graph, m_pass, name, id, verb, access, sampler, part);
}

void PassBuilder::Reads(std::string_view name, TextureId texture, const Subresources& part) {
    Bind(name, texture, BindVerb::Reads, Access::StorageRead, nullptr, part);
}
void PassBuilder::Reads(std::string_view name, TextureId texture, const Subresources& part,
                        const rhi::SamplerDesc& sampler) {
    Bind(name, texture, BindVerb::Reads, Access::Sampled, m_renderer.m_impl->FindSampler(sampler), part);
}
void PassBuilder::Reads(std::string_view name, BufferId buffer) {
    Bind(name, buffer, BindVerb::Reads, Access::StorageRead);
}
void PassBuilder::Reads(std::string_view name, TlasId tlas) {
    Bind(name, tlas, BindVerb::Reads, Access::TraceStructure);
}
TextureId PassBuilder::Writes(std::string_view name, TextureId texture, const Subresources& part) {
    return Bind(name, texture, BindVerb::Writes, Access::StorageWrite, nullptr, part);
}
BufferId PassBuilder::Writes(std::string_view name, BufferId buffer) {
    return Bind(name, buffer, BindVerb::Writes, Access::StorageWrite);
}
TextureId PassBuilder::Updates(std::string_view name, TextureId texture, const Subresources& part) {
    return Bind(name, texture, BindVerb::Updates, Access::StorageUpdate, nullptr, part);
}
BufferId PassBuilder::Updates(std::string_view name, BufferId buffer) {
    return Bind(name, buffer, BindVerb::Updates, Access::StorageUpdate);
}

void PassBuilder::ReadsByAddress(BufferId buffer) {
    m_graph.Use(buffer, Access::AddressRead);
}
void PassBuilder::ReadsByAddress(BlasSetId structures) {
    m_graph.Use(structures, Access::TraceStructure);
}
BufferId PassBuilder::WritesByAddress(BufferId buffer) {
    return m_graph.Use(buffer, Access::AddressWrite);
}
void PassBuilder::ReadsArguments(BufferId buffer) {
    m_graph.Use(buffer, Access::IndirectRead);
}
void PassBuilder::ReadsIndices(BufferId buffer) {
    m_graph.Use(buffer, Access::IndexRead);
}

void PassBuilder::Uses(TextureSetId textures) {
    m_pass.textureSet = m_graph.Use(textures, Access::Sampled).resource;
}

TextureId PassBuilder::ColorTarget(uint32_t index, TextureId texture, const Subresources& part,
                                   const ColorLoad& load) {
    const TextureId after = m_graph.Use(texture, load.clear ? Access::ColorWrite : Access::ColorUpdate, part);
    m_pass.colors.push_back(
        {.index = index, .resource = after.resource, .load = load, .part = m_graph.uses.back().part});
    return after;
}

TextureId PassBuilder::DepthTarget(TextureId texture, const Subresources& part, const DepthLoad& load) {
    if (m_pass.depth != kNone)
        throw MakeError(ErrorKind::Usage, "{} has two depth targets", PassText(m_graph));
    const TextureId after = m_graph.Use(texture, load.clear ? Access::DepthWrite : Access::DepthUpdate, part);
    m_pass.depth = after.resource;
    m_pass.depthPart = m_graph.uses.back().part;
    m_pass.depthLoad = load;
    return after;
}

void PassBuilder::CopiesFrom(TextureId texture, const Subresources& part) {
    m_graph.Use(texture, Access::CopyRead, part);
}
void PassBuilder::CopiesFrom(BufferId buffer) {
    m_graph.Use(buffer, Access::CopyRead);
}
TextureId PassBuilder::CopiesTo(TextureId texture, const Subresources& part) {
    return m_graph.Use(texture, Access::CopyWrite, part);
}
BufferId PassBuilder::CopiesTo(BufferId buffer) {
    return m_graph.Use(buffer, Access::CopyWrite);
}
void PassBuilder::BuildsFrom(BufferId input) {
    m_graph.Use(input, Access::BuildInput);
}
void PassBuilder::BuildsFrom(BlasSetId structures) {
    m_graph.Use(structures, Access::BuildRead);
}
TlasId PassBuilder::Builds(TlasId tlas) {
    return m_graph.Use(tlas, Access::BuildWrite);
}
BlasSetId PassBuilder::Builds(BlasSetId structures) {
    return m_graph.Use(structures, Access::BuildWrite);
}
TlasId PassBuilder::Refits(TlasId tlas) {
    return m_graph.Use(tlas, Access::BuildUpdate);
}
BlasSetId PassBuilder::Refits(BlasSetId structures) {
    return m_graph.Use(structures, Access::BuildUpdate);
}

void PassBuilder::Dividable() {
    m_pass.isDividable = true;
}

void PassBuilder::AsyncCompute() {
    m_graph.passes.back().queue = rhi::QueueKind::Compute;
}

void PassBuilder::KeepAlive() {
    m_graph.passes.back().keepAlive = true;
}

void PassBuilder::ConstantBytes(std::span<const std::byte> bytes, size_t alignment) {
    if (m_pass.hasConstants)
        throw MakeError(ErrorKind::Usage, "{} gives its constants twice", PassText(m_graph));
    m_pass.hasConstants = true;
    m_pass.constantAlignment = std::max<size_t>(alignment, 4);
    m_pass.constants.assign(bytes.begin(), bytes.end());
}

void PassBuilder::UniformBytes(std::string_view name, std::span<const std::byte> bytes, size_t alignment) {
    const uint64_t offset = m_renderer.m_impl->TakeUniform(bytes.size());
    std::copy(bytes.begin(), bytes.end(),
              m_renderer.m_impl->uniformBytes.begin() + static_cast<ptrdiff_t>(offset));
    DeclaredBinding& bound = m_pass.bindings.emplace_back();
    bound.name = m_graph.Keep(name);
    bound.verb = BindVerb::Uniform;
    bound.uniformOffset = static_cast<uint32_t>(offset);
    bound.uniformBytes = static_cast<uint32_t>(bytes.size());
    bound.uniformAlignment = static_cast<uint32_t>(alignment);
}

}  // namespace raygraph
