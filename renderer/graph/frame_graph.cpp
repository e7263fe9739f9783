#include "renderer/graph/frame_graph.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/text.h"
#include "renderer/graph/access.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

constexpr uint32_t kMaxVersion = TextureId::kMaxVersion;

// Returns what an access does to the contents: "reads", "writes" or "updates".
const char* VerbFor(Access access) {
    if (!Writes(access)) return "reads";
    return NeedsContents(access) ? "updates" : "writes";
}

std::string PassText(const GraphPass& pass) {
    return "pass " + Quoted(pass.name);
}

// Builds and transfers order the parts of a resource themselves, so that they may use it more than once.
bool MayCombine(PassKind kind, ResourceKind resource) {
    if (kind == PassKind::AccelerationStructure) return true;
    return kind == PassKind::Transfer && resource == ResourceKind::Buffer;
}

std::optional<Subresources> FirstEmpty(const FrameGraph& graph, const GraphResource& resource,
                                       const Subresources& part) {
    if (resource.SubresourceCount() == 1)
        return resource.version > 0 || resource.isHostWritten ? std::nullopt : std::optional(part);
    for (uint32_t layer = part.layer; layer < part.layer + part.layerCount; ++layer)
        for (uint32_t level = part.level; level < part.level + part.levelCount; ++level)
            if (!graph.isFilled[resource.firstFilled + layer * resource.levels + level])
                return Subresource(level, layer);
    return std::nullopt;
}

// Returns why a part has no contents that a pass could read, to follow after its name. Empty if it has
// contents, or may have them from before the frame.
std::string EmptyReason(const FrameGraph& graph, const GraphResource& resource, const Subresources& part) {
    const std::optional<Subresources> one = FirstEmpty(graph, resource, part);
    if (!one) return {};
    std::string missing;  // " level 2" of a texture, if other parts are written
    if (resource.version > 0) missing = rhi::PartText(*one, resource.levels, resource.layers);
    if (resource.origin == Origin::Transient)
        return Text(", a transient {} {} nothing has written in this frame", Name(resource.kind),
                    missing.empty() ? "that" : "whose" + missing);
    if (resource.origin == Origin::Imported && resource.kind == ResourceKind::Texture &&
        resource.state.layout == VK_IMAGE_LAYOUT_UNDEFINED)
        return Text(", imported in the layout Undefined: {} has no contents until it is written",
                    missing.empty() ? "it" : "its" + missing);
    return {};
}

// Returns the intersection of two overlapping parts.
Subresources Shared(const Subresources& part, const Subresources& other) {
    const auto cut = [](uint32_t first, uint32_t count, uint32_t otherFirst, uint32_t otherCount) {
        const uint32_t from = std::max(first, otherFirst);
        return std::pair(from, std::min(first + count, otherFirst + otherCount) - from);
    };
    const auto [level, levelCount] = cut(part.level, part.levelCount, other.level, other.levelCount);
    const auto [layer, layerCount] = cut(part.layer, part.layerCount, other.layer, other.layerCount);
    return {.level = level, .levelCount = levelCount, .layer = layer, .layerCount = layerCount};
}

// Returns text such as "chain" level 2.
std::string NameOf(const GraphResource& resource, const Subresources& part) {
    return Quoted(resource.name) + rhi::PartText(part, resource.levels, resource.layers);
}

}  // namespace

const char* Name(Origin origin) {
    switch (origin) {
        case Origin::Transient:
            return "transient";
        case Origin::Persistent:
            return "persistent";
        case Origin::Imported:
            return "imported";
    }
    return "?";
}

const char* Name(ResourceKind kind) {
    switch (kind) {
        case ResourceKind::Texture:
            return "texture";
        case ResourceKind::Buffer:
            return "buffer";
        case ResourceKind::Tlas:
            return "TLAS";
        case ResourceKind::BlasSet:
            return "BLAS set";
        case ResourceKind::TextureSet:
            return "texture set";
    }
    return "?";
}

bool PreservesContents(ResourceKind kind, Access access) {
    return NeedsContents(access) || Has(Row(access).partOf, kind);
}

void FrameGraph::Begin(uint64_t frameNumber) {
    frame = frameNumber;
    waitStages = VK_PIPELINE_STAGE_2_NONE;
    resources.clear();
    passes.clear();
    uses.clear();
    roots.clear();
    otherStates.clear();
    isFilled.clear();
    m_otherCount = 0;
    if (m_texts.use_count() == 1)
        m_texts->Clear();
    else
        m_texts = std::make_shared<Arena>();
}

bool FrameGraph::HasSamePlanAs(const FrameGraph& other) const {
    return queueFamily == other.queueFamily && computeFamily == other.computeFamily &&
           waitStages == other.waitStages && roots == other.roots && passes == other.passes &&
           uses == other.uses && resources == other.resources && blockStates == other.blockStates &&
           otherStates == other.otherStates;
}

uint32_t FrameGraph::AddResource(const GraphResource& added, ResourceKind kind,
                                 std::span<const ResourceState> others) {
    if (resources.size() >= TextureId::kInvalid)
        throw MakeError(ErrorKind::Usage, "{}: a frame has at most {} resources", Quoted(added.name),
                        TextureId::kInvalid);
    GraphResource& resource = resources.emplace_back(added);
    resource.kind = kind;
    resource.name = Keep(added.name);
    if (const uint32_t count = resource.SubresourceCount(); count > 1) {
        resource.firstOther = m_otherCount;
        m_otherCount += count - 1;
        const bool isEmpty =
            resource.origin == Origin::Transient ||
            (resource.origin == Origin::Imported && resource.state.layout == VK_IMAGE_LAYOUT_UNDEFINED);
        resource.firstFilled = static_cast<uint32_t>(isFilled.size());
        isFilled.resize(isFilled.size() + count, isEmpty ? 0 : 1);
        resource.hasOtherStates = !others.empty();
        otherStates.resize(m_otherCount);
        std::ranges::copy(others, otherStates.begin() + resource.firstOther);
    }
    return static_cast<uint32_t>(resources.size() - 1);
}

uint32_t FrameGraph::AddPass(std::string_view name, PassKind kind) {
    passes.push_back({.name = Keep(name), .kind = kind, .firstUse = static_cast<uint32_t>(uses.size())});
    return static_cast<uint32_t>(passes.size() - 1);
}

uint32_t FrameGraph::ResolveAnyVersion(AnyId id, std::string_view what) const {
    const std::string kind = Name(id.kind);
    if (!id.isValid)
        throw MakeError(ErrorKind::Usage, "{} an empty {} id, which names no resource", what, kind);
    const uint32_t age = static_cast<uint32_t>(frame - id.frame) & TextureId::kFrameMask;
    if (age != 0)
        throw MakeError(ErrorKind::Usage,
                        "{} a {} id of an earlier frame ({} before this one): ids last for one frame", what,
                        kind, age);
    if (id.resource >= resources.size() || resources[id.resource].kind != id.kind)
        throw MakeError(ErrorKind::Usage,
                        "{} a {} id that this frame did not give out: it is of another Renderer", what, kind);
    return id.resource;
}

uint32_t FrameGraph::Resolve(AnyId id, std::string_view what) const {
    const uint32_t index = ResolveAnyVersion(id, what);
    const GraphResource& resource = resources[index];
    if (id.version == resource.version) return index;
    const GraphPass* writer = nullptr;
    for (const GraphPass& pass : passes)
        for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u)
            if (uses[u].resource == index && uses[u].versionOut == id.version + 1u && Writes(uses[u].access))
                writer = &pass;
    throw MakeError(ErrorKind::Usage,
                    "{} {} as it was before {} wrote it: use the id that the write returned", what,
                    Quoted(resource.name), (writer ? PassText(*writer) : std::string("a pass")));
}

uint32_t FrameGraph::UseResource(AnyId id, Access access, const Subresources& requested) {
    GraphPass& pass = passes.back();
    const auto sentence = [&] { return PassText(pass) + " " + VerbFor(access); };
    // The text is built only for an error, since frames declare this often.
    const bool isGood = id.isValid && id.frame == (frame & TextureId::kFrameMask) &&
                        id.resource < resources.size() && resources[id.resource].kind == id.kind &&
                        resources[id.resource].version == id.version;
    const uint32_t index = isGood ? id.resource : Resolve(id, sentence());
    GraphResource& resource = resources[index];
    if (!IsLegal(pass.kind, access))
        throw MakeError(ErrorKind::Usage, "{} uses {} as {}, which a pass of kind {} cannot do",
                        PassText(pass), Quoted(resource.name), Name(access), Name(pass.kind));
    Subresources part = resource.Whole();
    if (requested != Subresources{}) {
        part = rhi::Resolved(requested, resource.levels, resource.layers);
        const std::string missing = rhi::DescribeMissing(part, resource.levels, resource.layers);
        if (!missing.empty())
            throw MakeError(ErrorKind::Usage, "{} {}: {}", sentence(), Quoted(resource.name), missing);
    }
    if (NeedsContents(access) && FirstEmpty(*this, resource, part))
        if (const std::string empty = EmptyReason(*this, resource, part); !empty.empty())
            throw MakeError(ErrorKind::Usage, "{} {}{}", sentence(), NameOf(resource, part), empty);
    for (uint32_t u = pass.firstUse; u < pass.firstUse + pass.useCount; ++u)
        if (uses[u].resource == index && rhi::Overlap(uses[u].part, part))
            CheckWithinPass(pass, resource, uses[u], access, part);

    const uint32_t versionIn = resource.version;
    if (Writes(access)) {
        if (versionIn == kMaxVersion)
            throw MakeError(ErrorKind::Usage, "{}: {} has been written {} times, the most in one frame",
                            PassText(pass), Quoted(resource.name), kMaxVersion);
        ++resource.version;
    }
    if (Writes(access) && resource.SubresourceCount() > 1)
        for (uint32_t layer = part.layer; layer < part.layer + part.layerCount; ++layer)
            std::fill_n(isFilled.begin() + resource.firstFilled + layer * resource.levels + part.level,
                        part.levelCount, uint8_t{1});
    uses.push_back({.resource = index,
                    .versionIn = versionIn,
                    .versionOut = resource.version,
                    .access = access,
                    .part = part});
    ++pass.useCount;
    return index;
}

void FrameGraph::CheckWithinPass(const GraphPass& pass, const GraphResource& resource,
                                 const ResourceUse& earlier, Access access, const Subresources& part) const {
    const bool isTexture = resource.kind == ResourceKind::Texture;
    const bool hasSameLayout =
        !isTexture || MasksFor(pass.kind, earlier.access).layout == MasksFor(pass.kind, access).layout;
    const bool isReadOnly = !Writes(earlier.access) && !Writes(access);
    if (hasSameLayout && (isReadOnly || MayCombine(pass.kind, resource.kind))) return;
    std::string why;
    if (isReadOnly)
        why = "a pass sees a texture in one way only";
    else if (Writes(earlier.access) && Writes(access))
        why = "a pass writes a resource once";
    else
        why = "a pass that reads what it writes updates it";
    throw MakeError(ErrorKind::Usage, "{} uses {} both as {} and as {}: {}", PassText(pass),
                    NameOf(resource, Shared(earlier.part, part)), Name(earlier.access), Name(access), why);
}

void FrameGraph::Present(TextureId texture) {
    const uint32_t index = Resolve(texture, "Present shows");
    const GraphResource& resource = resources[index];
    if (resource.origin == Origin::Transient)
        if (const std::string empty = EmptyReason(*this, resource, resource.Whole()); !empty.empty())
            throw MakeError(ErrorKind::Usage, "Present shows {}{}", Quoted(resource.name), empty);
    roots.push_back({.kind = RootKind::Presented, .resource = index, .version = resource.version});
}

void FrameGraph::Export(TextureId texture, VkImageLayout layout, uint32_t toQueueFamily) {
    const uint32_t index = Resolve(texture, "Export hands back");
    const GraphResource& resource = resources[index];
    if (layout == VK_IMAGE_LAYOUT_UNDEFINED || layout == VK_IMAGE_LAYOUT_PREINITIALIZED)
        throw MakeError(ErrorKind::Usage, "Export hands back {} in a layout that drops its contents",
                        Quoted(resource.name));
    ExportResource(index, layout, toQueueFamily);
}

void FrameGraph::Export(BufferId buffer, uint32_t toQueueFamily) {
    ExportResource(Resolve(buffer, "Export hands back"), VK_IMAGE_LAYOUT_UNDEFINED, toQueueFamily);
}

void FrameGraph::ExportResource(uint32_t index, VkImageLayout layout, uint32_t toQueueFamily) {
    const GraphResource& resource = resources[index];
    if (resource.origin != Origin::Imported)
        throw MakeError(ErrorKind::Usage, "Export hands back {}, a {} {}: only imported ones have an owner",
                        Quoted(resource.name), Name(resource.origin), Name(resource.kind));
    for (const Root& root : roots)
        if (root.kind == RootKind::Exported && root.resource == index)
            throw MakeError(ErrorKind::Usage, "Export hands back {} twice", Quoted(resource.name));
    roots.push_back({.kind = RootKind::Exported,
                     .resource = index,
                     .version = resource.version,
                     .layout = layout,
                     .queueFamily = toQueueFamily});
}

void FrameGraph::ReadOnHost(BufferId buffer) {
    const uint32_t index = Resolve(buffer, "ReadBack reads");
    roots.push_back({.kind = RootKind::HostRead, .resource = index, .version = resources[index].version});
}

}  // namespace raygraph
