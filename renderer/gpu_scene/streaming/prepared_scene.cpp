#include "renderer/gpu_scene/streaming/prepared_scene.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/gpu_scene/lights/own_light.h"
#include "renderer/gpu_scene/materials/scene_materials.h"
#include "renderer/gpu_scene/streaming/scene_content.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/check.h"

namespace raygraph {
namespace {

// Returns how meshes are kept for software traversal. With one level, all triangles are in one tree.
WideBvhUse TreesOf(const PreparedContent& content, const PrepareSettings& settings) {
    if (!settings.buildsWideBvhs) return WideBvhUse::None;
    uint64_t placed = 0;
    for (const scene::Instance& instance : content.data.instances)
        for (const scene::Primitive& primitive : content.data.meshes[instance.mesh].primitives)
            placed += primitive.TriangleCount();
    return placed <= kMaxLevelTriangles ? WideBvhUse::Triangles : WideBvhUse::Tree;
}

void PackMeshes(PreparedContent& content, const PrepareSettings& settings) {
    constexpr uint32_t kMaxThreads = 64;
    const uint32_t wanted =
        settings.maxThreads != 0 ? settings.maxThreads : std::thread::hardware_concurrency();
    const uint32_t threadCount = std::clamp(wanted, 1u, kMaxThreads);
    scene::PieceLimits limits = kPortableLimits;
    limits.maxTriangles = std::min<uint64_t>(limits.maxTriangles, std::max(1u, settings.maxTriangles));
    scene::SceneData& data = content.data;
    const PackingMaterials materials{MaterialRecords(data.materials, {}), LowestTextureAlphas(data)};
    const WideBvhUse trees = TreesOf(content, settings);
    std::vector<bool> isDeformed(data.meshes.size());
    for (const DeformedCopy& copy : content.deform.copies) isDeformed[copy.mesh] = true;
    content.meshes.resize(data.meshes.size());
    const auto workers = static_cast<uint32_t>(std::clamp<size_t>(data.meshes.size(), 1, threadCount));
    std::atomic<uint32_t> next = 0;
    const auto work = [&] {
        EmitterFinder finder(data);
        for (uint32_t i = next++; i < data.meshes.size(); i = next++) {
            const MeshUse use{.isDeformed = isDeformed[i],
                              .isBaseDrawn = content.deform.isBaseShapeDrawn[i],
                              .tree = trees,
                              .bvhThreads = threadCount / workers};
            content.meshes[i] = PackMesh(data.meshes[i], materials, use, finder, limits);
        }
    };
    // These futures wait in their destructors, also after an exception.
    std::vector<std::future<void>> others;
    for (uint32_t i = 1; i < workers; ++i)
        others.push_back(std::async(std::launch::async | std::launch::deferred, work));
    work();
    for (std::future<void>& other : others) other.get();
}

// Gives flat instances a thickness. Only instances that a host placed lack it: those of nodes already have
// one.
void ThickenInstances(scene::SceneData& data) {
    for (scene::Instance& instance : data.instances) {
        if (!scene::MayGainThickness(instance.objectToWorld)) continue;
        const scene::PlacedTransform flat{instance.objectToWorld, instance.translationResidual};
        const scene::PlacedTransform shown = scene::WithThickness(data, instance, flat).value_or(flat);
        instance.objectToWorld = shown.matrix;
        instance.translationResidual = shown.rest;
    }
}

}  // namespace

PreparedScene::PreparedScene(scene::SceneData&& data, const PrepareSettings& settings) {
    WithMemoryErrors("PreparedScene", [&] {
        scene::Check(data, "PreparedScene");
        Prepare(std::move(data), settings);
    });
}

PreparedScene::PreparedScene(scene::SceneData&& data, const PrepareSettings& settings, const char* call) {
    WithMemoryErrors(call, [&] {
        scene::Check(data, Text("GpuScene: {}", call));
        Prepare(std::move(data), settings);
    });
}

void PreparedScene::Prepare(scene::SceneData&& data, const PrepareSettings& settings) {
    m_content = std::make_unique<PreparedContent>();
    ThickenInstances(data);
    m_content->hasOwnLight =
        settings.measuresLight ? HasOwnLight(data, settings.maxThreads) : MayHaveOwnLight(data);
    m_content->deform = PlanDeformation(data);
    m_content->data = std::move(data);
    try {
        PackMeshes(*m_content, settings);
    } catch (...) {
        data = std::move(m_content->data);
        data.meshes.clear();  // Some meshes have been consumed, so that a retry would lack them
        throw;
    }
}

PreparedScene::~PreparedScene() = default;
PreparedScene::PreparedScene(PreparedScene&& other) noexcept = default;
PreparedScene& PreparedScene::operator=(PreparedScene&& other) noexcept = default;

const scene::SceneData& PreparedScene::Data() const {
    return m_content->data;
}

uint64_t PreparedScene::GeometryBytes() const {
    uint64_t bytes = 0;
    for (const PackedMesh& mesh : m_content->meshes) bytes += mesh.Bytes();
    return bytes;
}

}  // namespace raygraph
