// All lights of a scene as the tables of shaders/shared/light_records.h, made on the host.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/instances/tlas_quality.h"
#include "renderer/gpu_scene/lights/light_bvh.h"
#include "renderer/gpu_scene/lights/light_groups.h"
#include "renderer/gpu_scene/lights/light_mesh.h"
#include "renderer/gpu_scene/lights/punctual_lights.h"
#include "renderer/gpu_scene/lights/triangle_lights.h"
#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

// One TLAS instance of a group with emitters. It is a light for each of them, in their order, or one in all.
struct EmitterPlacement {
    uint32_t record = 0;     // index of its InstanceRecord
    uint32_t instance = 0;   // into LightScene::instances
    uint32_t group = 0;      // into LightScene::groups
    bool isRemoved = false;  // keeps its lights' numbers, and they are dark
    uint32_t firstLight = 0;
    uint32_t lightCount = 0;
};

// Groups of emitters that would be more lights than this in all their placements are shared: each placement
// is one light. Fewer are sampled a bit better one by one.
inline constexpr uint32_t kMaxExpandedLights = 4096;
// Those of fewer emitters are not: it would save nothing.
inline constexpr uint32_t kMinSharedEmitters = 4;

// Everything that the tables depend on.
struct LightScene {
    struct Instance {
        glm::mat4x3 objectToWorld{1.0f};
        bool isVisible = true;
    };
    std::vector<std::vector<Emitter>> groups;  // those without emitters are empty
    std::vector<bool> isDeformed;              // by group: never shared. Empty: none is
    std::vector<EmitterPlacement> placements;
    std::vector<Instance> instances;
    std::vector<glm::vec3> emission;  // by material: radiance, before the texture
    std::vector<scene::Light> punctual;
    std::vector<bool> isPunctualHidden;  // empty: none is
    ProfileTable profiles;
    float radius = 0.0f;  // of what is visible, m: what infinite lights shine on

    LightGroups lightGroups;

    glm::vec3 environmentRadiance{0.0f};  // mean over the sphere
    float environmentRotation = 0.0f;
    uint32_t environmentWidth = 1, environmentHeight = 1;  // cells of its table

    uint32_t maxExpandedLights = kMaxExpandedLights;
    std::vector<bool> isShared;  // by group

    // Whether each of so many placements of a group is to be one light.
    bool Shares(size_t group, uint64_t placementCount) const;
    // Decides which groups are shared, and numbers the lights of the placements from 0 on; returns how many
    // there are. Where placements have been removed, those of a group that was shared may `stay` so: few are
    // sampled a bit worse then, but the tables do not grow.
    uint32_t NumberEmitters(bool stay = false);
};

// What of a LightScene has changed.
struct LightEdits {
    bool isAll = true;                 // anything; the rest does not count
    std::vector<uint32_t> placements;  // transforms and visibility, and emitters' places if not shared
    std::vector<uint32_t> punctual;    // all but whether they are directional
    bool powersDirty = false;          // radius, or radiance of the environment
    bool transformsDirty = false;      // all transforms have been moved by the same translation

    bool IsEmpty() const {
        return !isAll && placements.empty() && punctual.empty() && !powersDirty && !transformsDirty;
    }
};

// What of the tables has changed.
struct LightTableChanges {
    bool isAll = false;              // all of it, sizes included
    bool isRebuilt = false;          // the tree
    bool allRecordsChanged = false;  // records and nodes of the lights
    bool isAlias = false;
    std::vector<uint32_t> lights, nodes;

    bool IsEmpty() const {
        return !isAll && !allRecordsChanged && !isAlias && lights.empty() && nodes.empty();
    }
};

class LightTable {
  public:
    // Brings the tables up to date with `scene`, in which the emitters are numbered.
    //
    // The tree is built again if `mayRefit` is false, or if a light shines that was dark when it was built.
    // Otherwise the records, the leaves and the nodes above of what has changed are updated in place, and
    // powers that differ by less than kPowerTolerance stay as they are: they are only weights. Triangles that
    // are hidden, dark or without area keep their number and have probability 0. With the tree, infinite
    // lights are chosen by their share of the power, but neither they nor the bounded lights with less than
    // kMinLightShare, because it is not known how much of the infinite light reaches a point.
    LightTableChanges Update(const LightScene& scene, const LightEdits& edits, bool mayRefit);
    // A frame samples the tree as it is now. True: updates have decayed it, by the rule of tlas_quality.h for
    // LightTree::RelativeCost.
    bool UpdateDecay() { return m_quality.UpdateDecay(m_tree.RelativeCost(), m_tree.Nodes().size() / 2); }
    void BuildTree(const LightScene& scene, LightTableChanges& changes);

    // Counts and shares; without the environment's place.
    const gpu::LightSetRecord& Set() const { return m_set; }
    // With it, as it is in the scene now.
    gpu::LightSetRecord SetIn(const LightScene& scene) const;
    uint64_t EmissiveTriangleCount() const { return m_emissiveTriangleCount; }  // those that shine
    const std::vector<gpu::LightMeshRecord>& Meshes() const { return m_meshRecords; }
    const std::vector<gpu::AliasEntry>& Alias() const { return m_alias; }  // without those of meshes
    const std::vector<gpu::AliasEntry>& MeshAlias() const { return m_meshAlias; }
    // The tables as on the device. Of numbers between the lights' and the meshes' there is nothing to read.
    size_t LightCount() const { return m_lights.size() + m_meshLights.size(); }
    size_t NodeCount() const { return FirstMeshNode() + m_meshNodes.size(); }
    size_t AliasCount() const { return FirstMeshAlias() + m_meshAlias.size(); }
    uint32_t FirstMeshNode() const { return 2 * m_set.boundedCount; }
    uint32_t FirstMeshAlias() const { return 3 * (m_set.lightCount + 1); }
    gpu::LightRecord LightAt(size_t index) const;
    gpu::LightNode NodeAt(size_t index) const;
    gpu::AliasEntry AliasAt(size_t index) const;

  private:
    void Number(const LightScene& scene);
    void BuildMeshes(const LightScene& scene);
    void SetPlacement(const LightScene& scene, uint32_t placement, bool isRefit, LightTableChanges& changes);
    void SetPunctual(const LightScene& scene, uint32_t light, bool isRefit, LightTableChanges& changes);
    // `bounds` is null: those of the record.
    void SetLight(uint32_t number, gpu::LightRecord record, double power, const LightBounds* bounds,
                  bool isRefit, LightTableChanges& changes);
    void SetInfinitePowers(const LightScene& scene);
    void Place(const LightScene& scene, LightTableChanges& changes);
    void UpdateNodeCount();
    void BuildAlias();

    std::vector<gpu::LightRecord> m_lights;
    std::vector<double> m_power;  // by light, the environment last
    LightTree m_tree;             // over the bounded ones
    std::vector<gpu::AliasEntry> m_alias;
    gpu::LightSetRecord m_set{};
    uint64_t m_emissiveTriangleCount = 0;
    std::vector<uint32_t> m_shiningCounts;    // by placement: triangles
    std::vector<uint32_t> m_punctualNumbers;  // by punctual light
    TlasQuality m_quality;

    std::vector<LightMesh> m_meshes;
    std::vector<uint32_t> m_meshOf;         // by group, if it is shared
    std::vector<LightBounds> m_meshBounds;  // by placement, if its group is shared
    std::vector<gpu::LightMeshRecord> m_meshRecords;
    std::vector<gpu::LightRecord> m_meshLights;
    std::vector<gpu::LightNode> m_meshNodes;
    std::vector<gpu::AliasEntry> m_meshAlias;
};

inline constexpr double kMinLightShare = 0.1;
inline constexpr double kPowerTolerance = 1e-3;

// The table of a scene in which the emitters are numbered. O(n log n).
LightTable BuildLightTable(const LightScene& scene);

}  // namespace raygraph
