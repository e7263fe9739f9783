// GpuSceneStatistics are for tests and reports, SceneRevisions for caches. Threads: plain values.
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
    std::string noWideBvhReason;  // empty: there are some
    uint64_t geometryBytes = 0;
    uint64_t textureBytes = 0;     // all levels; without what the device adds to align them
    uint64_t textureBudget = 0;    // in bytes, when the scene was set
    uint32_t reducedTextures = 0;  // smaller than their images, to fit it
    TlasWork lastTlasWork = TlasWork::None;
    uint64_t tlasUpdates = 0;
    uint64_t tlasRebuilds = 0;
    uint64_t blasBuilds = 0;
    uint64_t blasRefits = 0;             // of deformed meshes, after their vertices have moved
    uint64_t blasRebuilds = 0;           // likewise, in place: refits had decayed
    uint64_t deformations = 0;           // frames in which vertices were deformed; of this scene
    uint32_t deformedMeshes = 0;         // copies of meshes, each with vertices of its own
    uint32_t lightCount = 0;             // those that shine, the environment included, when last declared
    uint64_t emissiveTriangleCount = 0;  // placed, that shine
    uint64_t lightRebuilds = 0;          // of this scene's light tree
    uint64_t lightUpdates = 0;           // likewise, in place
    uint64_t lightTableBytes = 0;        // on the device: records, trees and alias tables of all lights
    uint64_t lightBytesUploaded = 0;     // into these, since the scene was set
    double uploadMs = 0.0;               // host time of the last SetScene: sorting and staging
};

// How often the scene has changed, by kind of change: for caches of what was derived from it. An edit
// that changes nothing does not count; neither do changes that leave the picture as it is (light
// groups, compaction).
struct SceneRevisions {
    // SetScene, SetVisible, SetVariant, MarkChanged; meshes and instances that come and go; SetMaterial where
    // culling or alpha changes.
    uint64_t geometry = 0;
    uint64_t transforms = 0;   // SetTransform
    uint64_t shapes = 0;       // SetJointMatrices, SetMorphWeights: of visible instances
    uint64_t materials = 0;    // SetMaterial, emission included; SetVariant; materials that come and go
    uint64_t lights = 0;       // SetLight, SetLightVisible; lights that come and go
    uint64_t environment = 0;  // SetEnvironment, SetEnvironmentMap, RemoveEnvironmentMap

    bool operator==(const SceneRevisions&) const = default;
};

}  // namespace raygraph
