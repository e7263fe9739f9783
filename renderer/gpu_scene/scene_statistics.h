// GpuSceneStatistics is for tests and reports, SceneRevisions for caches. Threads: plain values.
#pragma once

#include <cstdint>
#include <string>

#include "base/api.h"

namespace raygraph {

enum class TlasWork : uint8_t { None, Update, Rebuild };
RAYGRAPH_API const char* Name(TlasWork work);

struct GpuSceneStatistics {
    uint32_t instanceCount = 0;
    uint32_t blasCount = 0;
    uint32_t geometryCount = 0;
    uint64_t trianglesUnique = 0;
    uint64_t trianglesPlaced = 0;
    uint64_t blasBytesBuilt = 0;
    uint64_t blasBytesCompacted = 0;  // equals blasBytesBuilt where compaction is off
    uint32_t compactionsPending = 0;
    bool isCompactionOff = false;
    std::string compactionDisabledReason;
    uint64_t tlasBytes = 0;
    uint64_t wideTreeBytes = 0;
    std::string noWideBvhReason;  // empty if there are wide BVHs
    uint64_t geometryBytes = 0;
    uint64_t textureBytes = 0;     // all levels, without the padding that the device adds
    uint64_t textureBudget = 0;    // bytes, as it was when the scene was set
    uint32_t reducedTextures = 0;  // textures made smaller than their images to fit the budget
    TlasWork lastTlasWork = TlasWork::None;
    uint64_t tlasUpdates = 0;
    uint64_t tlasRebuilds = 0;
    uint64_t blasBuilds = 0;
    uint64_t blasRefits = 0;             // of deformed meshes, after their vertices have moved
    uint64_t blasRebuilds = 0;           // rebuilds in place of those whose refits had decayed
    uint64_t deformations = 0;           // frames in which vertices of this scene were deformed
    uint32_t deformedMeshes = 0;         // deformed copies of meshes
    uint32_t lightCount = 0;             // lights that shine when last declared, the environment included
    uint64_t emissiveTriangleCount = 0;  // placed triangles that shine
    uint64_t lightRebuilds = 0;          // rebuilds of this scene's light tree
    uint64_t lightUpdates = 0;           // updates of that tree in place
    uint64_t lightTableBytes = 0;        // on the device: records, trees and alias tables of all lights
    uint64_t lightBytesUploaded = 0;     // bytes uploaded into these tables since the scene was set
    double uploadMs = 0.0;               // host time of the last SetScene: sorting and staging
};

// Counts the changes of the scene by kind, for caches of derived data. Edits that change nothing are not
// counted, nor are changes that leave the picture as it is (light groups, compaction).
struct SceneRevisions {
    // SetScene, SetVisible, SetVariant, MarkChanged; added and removed meshes and instances; SetMaterial
    // where culling or alpha changes.
    uint64_t geometry = 0;
    uint64_t transforms = 0;   // SetTransform
    uint64_t shapes = 0;       // SetJointMatrices, SetMorphWeights of visible instances
    uint64_t materials = 0;    // SetMaterial, emission included; SetVariant; added and removed materials
    uint64_t lights = 0;       // SetLight, SetLightVisible; added and removed lights
    uint64_t environment = 0;  // SetEnvironment, SetEnvironmentMap, RemoveEnvironmentMap

    bool operator==(const SceneRevisions&) const = default;
};

}  // namespace raygraph
