#include "editor/session/cpu/scene_copy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "passes/add_compute.h"
#include "renderer/graph/readback_values.h"
#include "rhi/transfer.h"
#include "shaders/shared/wide_bvh.h"

namespace raygraph::session {

// --- Memory ---

void CopiedMemory::Add(uint64_t address, std::vector<std::byte> bytes) {
    m_ranges.insert_or_assign(address, std::move(bytes));
}

const std::byte* CopiedMemory::Find(uint64_t address, uint64_t count, uint64_t size) const {
    auto range = m_ranges.upper_bound(address);
    if (range != m_ranges.begin()) {
        --range;
        const uint64_t offset = address - range->first;
        const uint64_t end = range->second.size();
        if (offset <= end && count <= (end - offset) / size && address % 4 == 0)
            return range->second.data() + offset;
    }
    throw MakeError(ErrorKind::BadInput, "a shader reads {} bytes at address {:#x}, where the scene has none",
                    size, address);
}

// --- Textures ---

namespace {

int64_t WrappedTexel(int64_t texel, int64_t size, scene::WrapMode mode) {
    const auto modulo = [](int64_t value, int64_t divisor) {
        const int64_t rest = value % divisor;
        return rest < 0 ? rest + divisor : rest;
    };
    switch (mode) {
        case scene::WrapMode::Repeat:
            return modulo(texel, size);
        case scene::WrapMode::MirroredRepeat: {
            const int64_t inPair = modulo(texel, 2 * size);
            return inPair < size ? inPair : 2 * size - 1 - inPair;
        }
        case scene::WrapMode::ClampToEdge:
            return std::clamp<int64_t>(texel, 0, size - 1);
    }
    return 0;
}

// Returns a texel coordinate within the range of integers, also for what is not a number.
float Bounded(float coordinate) {
    return std::isfinite(coordinate) ? std::clamp(coordinate, -1e9f, 1e9f) : 0.0f;
}

}  // namespace

glm::vec4 CopiedTexture::SampleLevel(const Level& level, const glm::vec2& uv,
                                     scene::FilterMode filter) const {
    const auto width = int64_t{level.extent.width}, height = int64_t{level.extent.height};
    const auto texel = [&](float x, float y) {
        const int64_t column = WrappedTexel(static_cast<int64_t>(x), width, m_sampler.wrapU);
        const int64_t row = WrappedTexel(static_cast<int64_t>(y), height, m_sampler.wrapV);
        return level.texels[static_cast<size_t>(row * width + column)];
    };
    const float x = Bounded(uv.x * static_cast<float>(width));
    const float y = Bounded(uv.y * static_cast<float>(height));
    if (filter == scene::FilterMode::Nearest) return texel(std::floor(x), std::floor(y));
    const float left = std::floor(x - 0.5f), top = std::floor(y - 0.5f);
    const float toRight = x - 0.5f - left, toBottom = y - 0.5f - top;
    const glm::vec4 upper = glm::mix(texel(left, top), texel(left + 1.0f, top), toRight);
    const glm::vec4 lower = glm::mix(texel(left, top + 1.0f), texel(left + 1.0f, top + 1.0f), toRight);
    return glm::mix(upper, lower, toBottom);
}

glm::vec4 CopiedTexture::Sample(const glm::vec2& uv, float lod) const {
    if (!(lod > 0.0f)) return SampleLevel(m_levels.front(), uv, m_sampler.magFilter);
    const auto last = static_cast<float>(m_levels.size() - 1);
    lod = std::min(lod, last);
    if (m_sampler.mipFilter == scene::FilterMode::Nearest)
        return SampleLevel(m_levels[static_cast<size_t>(std::ceil(lod + 0.5f) - 1.0f)], uv,
                           m_sampler.minFilter);
    const float lower = std::floor(lod);
    const auto level = static_cast<size_t>(lower);
    const glm::vec4 fine = SampleLevel(m_levels[level], uv, m_sampler.minFilter);
    if (lod == lower) return fine;
    return glm::mix(fine, SampleLevel(m_levels[level + 1], uv, m_sampler.minFilter), lod - lower);
}

// --- Copies ---

namespace {

using DeclareScene = std::function<SceneIds()>;

Extent2D LevelExtent(Extent2D extent, uint32_t level) {
    return {std::max(extent.width >> level, 1u), std::max(extent.height >> level, 1u)};
}

// Returns a level of a texture of the table, or of the environment map, by a frame of its own.
CopiedTexture::Level CopyLevel(Renderer& renderer, const DeclareScene& declare, uint32_t slot, uint32_t level,
                               Extent2D extent) {
    struct Constants {
        uint32_t slot;
        int32_t level;
        uint32_t width, height;
    };
    renderer.BeginFrame();
    const SceneIds ids = declare();
    BufferId texels =
        renderer.CreateBuffer("texels", {.size = uint64_t{extent.width} * extent.height * sizeof(glm::vec4)});
    passes::AddCompute(renderer, "FetchTexels", "scene/fetch_texels.comp", extent, [&](PassBuilder& pass) {
        pass.Uses(ids.textures);
        pass.Reads("environmentMap", ids.environmentMap, rhi::SamplerDesc{});
        pass.Constants(Constants{slot, static_cast<int32_t>(level), extent.width, extent.height});
        texels = pass.Writes("texels", texels);
    });
    const Readback copy = renderer.ReadBack(texels);
    renderer.Execute();
    return {extent, WaitForValues<glm::vec4>(copy)};
}

CopiedTexture CopyTexture(Renderer& renderer, const DeclareScene& declare,
                          const SceneMemory::Texture& texture) {
    std::vector<CopiedTexture::Level> levels;
    const rhi::TextureDesc& desc = texture.texture->Desc();
    for (uint32_t level = 0; level < desc.mipLevels; ++level)
        levels.push_back(CopyLevel(renderer, declare, texture.slot, level, LevelExtent(desc.extent, level)));
    return {texture.sampler, std::move(levels)};
}

void CopyTables(SceneCopy& copy, Renderer& renderer, const DeclareScene& declare) {
    renderer.BeginFrame();
    const SceneIds ids = declare();
    const Readback instances = renderer.ReadBack(ids.instances);
    const Readback geometries = renderer.ReadBack(ids.geometries);
    const Readback materials = renderer.ReadBack(ids.materials);
    const Readback lights = renderer.ReadBack(ids.lights);
    const Readback lightNodes = renderer.ReadBack(ids.lightNodes);
    const Readback lightAlias = renderer.ReadBack(ids.lightAlias);
    const Readback lightMeshes = renderer.ReadBack(ids.lightMeshes);
    const Readback lightProfiles = renderer.ReadBack(ids.lightProfiles);
    const Readback environmentTable = renderer.ReadBack(ids.environmentTable);
    if (ids.deformedStreams.IsValid()) std::ignore = renderer.ReadBack(ids.deformedStreams);
    const Extent2D mapExtent = renderer.Desc(ids.environmentMap).extent;
    renderer.Execute();
    copy.ids = ids;
    copy.instances = WaitForValues<gpu::InstanceRecord>(instances);
    copy.geometries = WaitForValues<gpu::GeometryRecord>(geometries);
    copy.materials = WaitForValues<gpu::MaterialRecord>(materials);
    copy.lights = WaitForValues<gpu::LightRecord>(lights);
    copy.lightNodes = WaitForValues<gpu::LightNode>(lightNodes);
    copy.lightAlias = WaitForValues<gpu::AliasEntry>(lightAlias);
    copy.lightMeshes = WaitForValues<gpu::LightMeshRecord>(lightMeshes);
    copy.lightProfiles = WaitForValues<float>(lightProfiles);
    copy.environmentTable = WaitForValues<gpu::EnvironmentEntry>(environmentTable);
    // The sampler of BindEnvironment
    const scene::Sampler sampler{.wrapV = scene::WrapMode::ClampToEdge};
    copy.environmentMap = {sampler, {CopyLevel(renderer, declare, gpu::kNoTexture, 0, mapExtent)}};
}

// --- Trees ---

// Builds the trees of the meshes, which instances share, and the one over the instances.
class TreeBuilder {
  public:
    explicit TreeBuilder(SceneCopy& copy) : m_copy(copy) {}

    void Add(const SceneMemory::Placement& placed) {
        const gpu::InstanceRecord& record = m_copy.instances.at(placed.record);
        if (placed.primitives == 0) return;
        if (record.indices == 0) return AddCapsules(record, placed);
        const Mesh& mesh = MeshOf(record, placed.primitives);
        m_placements.push_back({.objectToWorld = record.objectToWorld,
                                .box = mesh.box,
                                .root = mesh.root,
                                .number = placed.record,
                                .flags = placed.flags});
    }

    void Finish() {
        WideScene& trees = m_copy.trees;
        WideInstances top = BuildWideInstances(m_placements);
        if (top.depth > kMaxInstanceDepth || m_depth > kMaxMeshDepth)
            throw MakeError(ErrorKind::Usage, "trees of {} and {} levels: there is room for {} and {}",
                            top.depth, m_depth, kMaxInstanceDepth, kMaxMeshDepth);
        top.instances[0].root = static_cast<uint32_t>(trees.nodes.size());
        MoveNodes(top.nodes, top.instances[0].root, 0);
        trees.nodes.insert(trees.nodes.end(), top.nodes.begin(), top.nodes.end());
        trees.instances = std::move(top.instances);
    }

  private:
    struct Mesh {
        Box box;
        uint32_t root = 0;
    };

    const Mesh& MeshOf(const gpu::InstanceRecord& record, uint32_t triangles) {
        const auto [found, isNew] = m_meshes.try_emplace({record.positions, record.indices});
        if (!isNew) return found->second;
        const std::span<const uint32_t> indices =
            m_copy.memory.At<uint32_t>(record.indices, uint64_t{3} * triangles);
        const uint32_t vertices = *std::ranges::max_element(indices) + 1;
        WideMesh mesh = CollectTriangles(m_copy.memory.At<glm::vec3>(record.positions, vertices), indices);
        if (mesh.triangles.empty()) return found->second;
        BuildTree(mesh);
        if (mesh.nodes.empty())
            throw Error(ErrorKind::Usage, "a mesh reaches farther than 1e18: there is no tree over it");
        WideScene& trees = m_copy.trees;
        found->second = {mesh.box, static_cast<uint32_t>(trees.nodes.size())};
        MoveNodes(mesh.nodes, found->second.root, static_cast<uint32_t>(trees.triangles.size()));
        trees.nodes.insert(trees.nodes.end(), mesh.nodes.begin(), mesh.nodes.end());
        trees.triangles.insert(trees.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
        m_depth = std::max(m_depth, mesh.depth);
        return found->second;
    }

    void AddCapsules(const gpu::InstanceRecord& record, const SceneMemory::Placement& placed) {
        const std::span<const gpu::CapsuleRecord> capsules =
            m_copy.memory.At<gpu::CapsuleRecord>(record.positions, placed.primitives);
        std::vector<Box> boxes;
        for (const gpu::CapsuleRecord& capsule : capsules) {
            Box box;
            box.Extend(glm::min(capsule.p0, capsule.p1) - capsule.radius);
            box.Extend(glm::max(capsule.p0, capsule.p1) + capsule.radius);
            boxes.push_back(box);
        }
        const glm::dmat3 linear = glm::inverse(glm::dmat3(glm::mat3(record.objectToWorld)));
        const glm::dvec3 place = -(linear * glm::dvec3(record.objectToWorld[3]));
        m_copy.capsules.push_back({.instance = placed.record,
                                   .flags = placed.flags,
                                   .toObject = glm::dmat4x3(linear[0], linear[1], linear[2], place),
                                   .capsules = capsules,
                                   .tree = BuildBinaryBvh(boxes, {.isBalanced = true})});
    }

    SceneCopy& m_copy;
    std::map<std::pair<uint64_t, uint64_t>, Mesh> m_meshes;  // by positions and indices
    std::vector<WidePlacement> m_placements;
    uint32_t m_depth = 0;
};

}  // namespace

SceneCopy CopyScene(Renderer& renderer, const GpuScene& scene, const DeclareScene& declare) {
    SceneCopy copy;
    CopyTables(copy, renderer, declare);
    const SceneMemory memory = scene.Memory();
    for (const rhi::Buffer* const streams : memory.streams)
        copy.memory.Add(streams->Address(), rhi::ReadBuffer(renderer.Device(), *streams));
    for (const SceneMemory::Texture& texture : memory.textures) {
        if (copy.textures.size() <= texture.slot) copy.textures.resize(texture.slot + size_t{1});
        copy.textures[texture.slot] = CopyTexture(renderer, declare, texture);
    }
    TreeBuilder builder(copy);
    for (const SceneMemory::Placement& placed : memory.placements) builder.Add(placed);
    builder.Finish();
    return copy;
}

}  // namespace raygraph::session
