// SceneObjects: its creation, and its work in each frame.
#include <utility>

#include "base/text.h"
#include "renderer/gpu_scene/instances/scene_objects.h"

namespace raygraph {

SceneObjects::SceneObjects(SceneContext& context, std::unique_ptr<SceneMaterials> newMaterials,
                           std::unique_ptr<SceneGeometry> newGeometry, const scene::SceneData& data)
    : m_context(context),
      materials(std::move(newMaterials)),
      geometry(std::move(newGeometry)),
      instances(context.device, *geometry, data),
      blases(context.builder, *geometry, instances),
      draws(context.device, *geometry, instances),
      lights(context.device, context.uploader, *geometry, instances.Placements(), data,
             context.desc.lightRule),
      setInstances(data.instances.size()),
      setMaterials(data.materials.size()),
      setLights(data.lights.size()) {
    draws.Upload(context.uploader);
    if (geometry->deform) deform.emplace(context.device, *geometry, instances);
    context.builder.Reserve();
    owners.meshes.Reset(data.meshes.size());
    owners.instances.Reset(data.instances.size());
    owners.materials.Reset(data.materials.size());
    owners.lights.Reset(data.lights.size());
    MoveOrigin(ChooseSceneOrigin({}, glm::dvec3(0.0), instances.Reach()));
    if (context.traversal != Traversal::Own) return;
    trees.emplace(context.device, context.desc.lightRule == LightRule::Decay);
    trees->Follow(*geometry, instances);
    Say(context.device.Log(), LogLevel::Debug, log_category::kGeometry, "trees for own traversal: {}",
        trees->UnavailableReason().empty() ? BytesText(trees->Bytes()) : trees->UnavailableReason());
}

void SceneObjects::Declare(Renderer& renderer, SceneIds& ids) {
    draws.Refresh(*geometry, instances);
    ids.origin = m_origin;
    m_context.environment.Declare(renderer, ids, lights);
    ids.geometries = geometry->records.Declare(renderer);
    materials->Declare(renderer, ids, *geometry);
    ids.placementCount = instances.RecordCount();
    ids.blases = renderer.ImportBlasSet("BLASes", m_context.blasState);
    if (deform) deform->DeclareDeformation(renderer, ids, lights, draws);
    draws.Declare(renderer, ids);
    blases.Declare(renderer, ids, deform ? &*deform : nullptr);
    if (trees) {
        trees->Follow(*geometry, instances);
        trees->Declare(renderer, ids);
    }
    lights.Declare(renderer, ids, instances);
    blases.BeginFrame();
    instances.DeclareRefresh(renderer, ids, [this](TlasWork work) {
        blases.MarkUsed();
        GpuSceneStatistics& statistics = m_context.statistics;
        statistics.lastTlasWork = work;
        statistics.tlasUpdates += work == TlasWork::Update ? 1 : 0;
        statistics.tlasRebuilds += work == TlasWork::Rebuild ? 1 : 0;
    });
}

bool SceneObjects::IsSettled() const {
    return blases.IsSettled() && (!deform || !deform->HasWork());
}

void SceneObjects::RefreshStatistics() const {
    GpuSceneStatistics& statistics = m_context.statistics;
    const rhi::CompactionStatistics blas = m_context.builder.Statistics();
    statistics.blasCount = blas.blasCount;
    statistics.blasBytesBuilt = blas.bytesBuilt;
    statistics.blasBytesCompacted = blas.bytesCompacted;
    statistics.compactionsPending = blas.pending;
    statistics.isCompactionOff = blas.isOff;
    statistics.compactionDisabledReason = blas.disabledReason;
    statistics.blasBuilds = blas.buildCount;
    statistics.blasRefits = blas.refitCount;
    statistics.blasRebuilds = blas.rebuildCount;
    statistics.deformations = deform ? deform->DeformCount() : 0;
    statistics.textureBytes = materials->Textures().Bytes();
    statistics.reducedTextures = materials->Textures().ReducedImages();
    statistics.geometryCount = static_cast<uint32_t>(geometry->records.Size());
    statistics.geometryBytes = geometry->streamBytes;
    statistics.deformedMeshes = deform ? static_cast<uint32_t>(geometry->deform->meshes.size()) : 0;
    statistics.instanceCount = instances.ExistingCount();
    statistics.trianglesUnique = statistics.trianglesPlaced = 0;
    for (const MeshResources& mesh : geometry->meshes) {
        if (!mesh.isCopy) statistics.trianglesUnique += mesh.triangleCount;
        statistics.trianglesPlaced += mesh.triangleCount * mesh.instanceCount;
    }
    statistics.tlasBytes = instances.TlasBytes();
    statistics.wideTreeBytes = trees ? trees->Bytes() : 0;
    statistics.noWideBvhReason = trees ? trees->UnavailableReason() : "the driver's traversal is used";
    statistics.lightCount = lights.LightCount();
    statistics.emissiveTriangleCount = lights.EmissiveTriangleCount();
    const LightStatistics& tables = lights.Statistics();
    statistics.lightRebuilds = tables.rebuilds;
    statistics.lightUpdates = tables.updates;
    statistics.lightTableBytes = tables.tableBytes;
    statistics.lightBytesUploaded = tables.bytesUploaded;
}

}  // namespace raygraph
