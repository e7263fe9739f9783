#include "tests/graph/random_frames.h"

#include <algorithm>
#include <array>

#include "base/error.h"
#include "tests/graph/access_table.h"

namespace raygraph {

namespace {

constexpr uint32_t kFamily = 0;
constexpr uint32_t kComputeFamily = 2;
constexpr uint32_t kOtherFamily = 3;

// The kinds of resources that an access can have, apart from what the graph refuses.
bool Fits(ResourceKind kind, const golden::AccessRow& row) {
    switch (row.access) {
        case Access::TraceStructure:
        case Access::BuildRead:
        case Access::BuildWrite:
        case Access::BuildUpdate:
            return kind == ResourceKind::Tlas || kind == ResourceKind::BlasSet;
        case Access::StorageRead:
        case Access::StorageWrite:
        case Access::StorageUpdate:
        case Access::CopyRead:
        case Access::CopyWrite:
            return kind == ResourceKind::Buffer || kind == ResourceKind::Texture;
        case Access::AddressRead:
            return kind == ResourceKind::Buffer || kind == ResourceKind::BlasSet;
        default:
            return kind ==
                   (row.layout == VK_IMAGE_LAYOUT_UNDEFINED ? ResourceKind::Buffer : ResourceKind::Texture);
    }
}

}  // namespace

RandomFrames::RandomFrames(uint64_t seed, oracle::Oracle& oracle, bool hasComputeQueue)
    : m_random(seed), m_hasComputeQueue(hasComputeQueue) {
    m_graph.queueFamily = kFamily;
    if (m_hasComputeQueue) m_graph.computeFamily = Chance(80) ? kComputeFamily : kFamily;
    constexpr std::array<VkPipelineStageFlags2, 4> kWaits{
        VK_PIPELINE_STAGE_2_NONE, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
        VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT};
    m_waitStages = kWaits[Below(kWaits.size())];
    for (uint32_t i = Below(4); i > 0; --i) AddKept(ResourceKind::Texture, Origin::Persistent);
    for (uint32_t i = Below(3); i > 0; --i) AddKept(ResourceKind::Buffer, Origin::Persistent);
    for (uint32_t i = Below(3); i > 0; --i) AddKept(ResourceKind::Texture, Origin::Imported);
    for (uint32_t i = Below(3); i > 0; --i) AddKept(ResourceKind::Buffer, Origin::Imported);
    if (Chance(60)) AddKept(ResourceKind::Tlas, Origin::Imported);
    if (Chance(60)) AddKept(ResourceKind::BlasSet, Origin::Imported);
    for (Kept& kept : m_kept)
        if (kept.owner != Owner::Graph) {
            kept.resource.state.layout = kept.resource.kind == ResourceKind::Texture
                                             ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL
                                             : VK_IMAGE_LAYOUT_UNDEFINED;
            kept.resource.state.queueFamily = kept.family;
            UseAsOwner(kept, oracle);
        }
}

void RandomFrames::AddKept(ResourceKind kind, Origin origin) {
    Kept kept;
    kept.name = std::string(Name(origin)) + ' ' + std::to_string(m_kept.size());
    kept.resource = {.kind = kind,
                     .origin = origin,
                     .persistence = Chance(30) ? Persistence::Always : Persistence::OnDemand,
                     .extent = {8, 8},
                     .format = rhi::Format::Rgba32Float,
                     .bytes = 64};
    MakeParts(kept.resource);
    const bool isOneObject = kind == ResourceKind::Texture || kind == ResourceKind::Buffer;
    if (isOneObject) kept.resource.isShared = m_hasComputeQueue ? Chance(50) : m_kept.size() % 2 == 0;
    if (origin == Origin::Imported && isOneObject && Chance(70)) {
        kept.owner = m_waitStages != 0 && Chance(70) ? Owner::Signals : Owner::Queue;
        if (kept.owner == Owner::Signals && Chance(50)) kept.family = kOtherFamily;
    }
    m_kept.push_back(std::move(kept));
}

// The owner's turn between two frames: the resource is in the state that the frame has left, or that it has
// at the beginning, and goes back in the same layout.
void RandomFrames::UseAsOwner(Kept& kept, oracle::Oracle& oracle) {
    ResourceState& state = kept.resource.state;
    if (kept.owner == Owner::Signals) {
        const uint32_t owner = kept.resource.isShared ? VK_QUEUE_FAMILY_IGNORED : kept.family;
        oracle.OwnerSignals(kept.name, m_waitStages, state.layout, owner);
        if (kept.family == VK_QUEUE_FAMILY_IGNORED && Chance(50)) state = {.layout = state.layout};
        return;
    }
    const oracle::Scope copy{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT};
    oracle.OwnerUses(kept.name, copy, state.layout);
    if (m_frame == 0 || Chance(50))
        state = {.writeStages = copy.stages, .writeAccess = copy.access, .layout = state.layout};
}

// Some textures have several levels, layers or both.
void RandomFrames::MakeParts(GraphResource& texture) {
    if (texture.kind != ResourceKind::Texture || Chance(50)) return;
    texture.levels = 1 + Below(4);
    texture.layers = 1 + Below(3);
}

// All of it, or any rectangle.
Subresources RandomFrames::PartOf(const GraphResource& texture) {
    if (Chance(30)) return {};
    Subresources part{.level = Below(texture.levels), .layer = Below(texture.layers)};
    part.levelCount = 1 + Below(texture.levels - part.level);
    part.layerCount = 1 + Below(texture.layers - part.layer);
    return part;
}

GraphResource RandomFrames::Transient(std::string_view name) {
    GraphResource resource{.name = name,
                           .kind = Chance(60) ? ResourceKind::Texture : ResourceKind::Buffer,
                           .extent = {8, 8},
                           .format = rhi::Format::Rgba32Float,
                           .bytes = 64};
    MakeParts(resource);
    const bool isUpload = resource.kind == ResourceKind::Buffer && Chance(20);
    resource.isHostWritten = isUpload;
    if (!isUpload)
        resource.memory = {.size = uint64_t{1 + Below(6)} << 20,
                           .alignment = uint64_t{256} << Below(3),
                           .memoryTypeBits = Chance(70) ? 7u : 1u + Below(7)};
    return resource;
}

uint32_t RandomFrames::Add(const GraphResource& resource, std::span<const ResourceState> otherStates) {
    switch (resource.kind) {
        case ResourceKind::Texture:
            return m_graph.Add<ResourceKind::Texture>(resource, otherStates).resource;
        case ResourceKind::Buffer:
            return m_graph.Add<ResourceKind::Buffer>(resource, otherStates).resource;
        case ResourceKind::Tlas:
            return m_graph.Add<ResourceKind::Tlas>(resource, otherStates).resource;
        default:
            return m_graph.Add<ResourceKind::BlasSet>(resource, otherStates).resource;
    }
}

// False: the graph refuses it, and nothing has changed.
bool RandomFrames::Use(uint32_t resource, Access access) {
    try {
        switch (m_graph.resources[resource].kind) {
            case ResourceKind::Texture:
                m_graph.Use(m_graph.IdOf<ResourceKind::Texture>(resource), access,
                            PartOf(m_graph.resources[resource]));
                break;
            case ResourceKind::Buffer:
                m_graph.Use(m_graph.IdOf<ResourceKind::Buffer>(resource), access);
                break;
            case ResourceKind::Tlas:
                m_graph.Use(m_graph.IdOf<ResourceKind::Tlas>(resource), access);
                break;
            default:
                m_graph.Use(m_graph.IdOf<ResourceKind::BlasSet>(resource), access);
                break;
        }
        return true;
    } catch (const Error&) {
        return false;
    }
}

const FrameGraph& RandomFrames::Declare() {
    m_graph.Begin(++m_frame);
    m_graph.waitStages = m_waitStages;
    for (Kept& kept : m_kept) {
        kept.index = kNone;
        // Imports that were handed over for this frame have to be in it.
        if (kept.owner == Owner::Graph && Chance(20)) continue;
        GraphResource resource = kept.resource;
        resource.name = kept.name;
        kept.index = Add(resource, kept.otherStates);
    }
    for (uint32_t i = 0, count = 2 + Below(7); i < count; ++i)
        Add(Transient("transient " + std::to_string(i)));
    for (uint32_t i = 0, count = 3 + Below(10); i < count; ++i) AddPass(i);
    AddRoots();
    return m_graph;
}

void RandomFrames::AddPass(uint32_t number) {
    constexpr std::array kKinds{PassKind::RayTracing, PassKind::Compute, PassKind::Raster, PassKind::Transfer,
                                PassKind::AccelerationStructure};
    const PassKind kind = kKinds[Below(kKinds.size())];
    m_graph.AddPass(std::string(Name(kind)) + ' ' + std::to_string(number), kind);
    m_graph.passes.back().keepAlive = Chance(35);
    if (m_hasComputeQueue && Chance(50)) m_graph.passes.back().queue = rhi::QueueKind::Compute;
    uint32_t wanted = 1 + Below(4);
    for (uint32_t attempt = 0; attempt < 60 && wanted > 0; ++attempt) {
        const golden::AccessRow& row = golden::kAccessRows[Below(golden::kAccessRows.size())];
        const uint32_t resource = Below(static_cast<uint32_t>(m_graph.resources.size()));
        if (row.kind != kind || !Fits(m_graph.resources[resource].kind, row)) continue;
        if (Use(resource, row.access)) --wanted;
    }
}

void RandomFrames::AddRoots() {
    for (uint32_t r = 0, count = static_cast<uint32_t>(m_graph.resources.size()); r < count; ++r) {
        const GraphResource& resource = m_graph.resources[r];
        if (resource.version == 0 || resource.origin == Origin::Imported) continue;
        const auto isFilled = [](uint8_t filled) { return filled != 0; };
        if (resource.kind == ResourceKind::Texture && Chance(15) &&
            (resource.SubresourceCount() == 1 ||
             std::all_of(m_graph.isFilled.begin() + resource.firstFilled,
                         m_graph.isFilled.begin() + resource.firstFilled + resource.SubresourceCount(),
                         isFilled)))
            m_graph.Present(m_graph.IdOf<ResourceKind::Texture>(r));
        else if (resource.kind == ResourceKind::Buffer && Chance(15))
            ReadOnHost(r);
    }
    constexpr std::array kLayouts{VK_IMAGE_LAYOUT_GENERAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                  VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
    for (const Kept& kept : m_kept) {
        if (kept.owner == Owner::Graph) continue;
        // One whose owner signals what it does need not be handed back by the graph as well.
        if (kept.owner == Owner::Signals && kept.family == VK_QUEUE_FAMILY_IGNORED && Chance(50)) continue;
        if (kept.resource.kind == ResourceKind::Texture)
            m_graph.Export(m_graph.IdOf<ResourceKind::Texture>(kept.index), kLayouts[Below(kLayouts.size())],
                           kept.family);
        else
            m_graph.Export(m_graph.IdOf<ResourceKind::Buffer>(kept.index), kept.family);
    }
}

// Copies as Renderer::ReadBack does.
void RandomFrames::ReadOnHost(uint32_t resource) {
    const uint32_t target =
        Add({.name = "readback " + std::to_string(m_frame) + ' ' + std::to_string(resource),
             .kind = ResourceKind::Buffer,
             .origin = Origin::Imported,
             .bytes = 64});
    m_graph.AddPass("read back " + std::string(m_graph.resources[resource].name), PassKind::Transfer);
    Use(resource, Access::CopyRead);
    Use(target, Access::CopyWrite);
    m_graph.ReadOnHost(m_graph.IdOf<ResourceKind::Buffer>(target));
}

void RandomFrames::Commit(const Plan& plan, oracle::Oracle& oracle) {
    m_graph.blockStates = plan.blockStates;
    for (Kept& kept : m_kept) {
        if (kept.index == kNone) continue;
        kept.otherStates.clear();
        m_graph.ForEachSubresource(kept.index, [&](uint32_t number, auto&&) {
            if (number == kept.index)
                kept.resource.state = plan.states[number];
            else if (kept.resource.origin == Origin::Persistent)
                kept.otherStates.push_back(plan.states[number]);
        });
        if (kept.owner != Owner::Graph) UseAsOwner(kept, oracle);
    }
}

}  // namespace raygraph
