// All lights of a scene as the tables of shaders/shared/light_records.h, built on the host, and what they
// are made of: records of punctual lights, lists of changes, alias tables. Threads: pure functions; objects
// as std::vector.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/instances/tlas_quality.h"
#include "renderer/gpu_scene/lights/light_bvh.h"
#include "renderer/gpu_scene/lights/light_groups.h"
#include "renderer/gpu_scene/lights/light_mesh.h"
#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

// --- Punctual lights, with a profile or without, as records ---

// Holds the profiles of a scene's lights in the layout of shaders/lights/light_profile.glsl.
struct ProfileTable {
    std::vector<float> words;
    std::vector<uint32_t> firstWords;  // indexed by profile
    std::vector<double> means;         // mean intensity over all directions, candela
};
ProfileTable MakeProfileTable(std::span<const scene::LightProfile> profiles);

// Holds a light and its power (luminance, W).
struct PoweredLight {
    gpu::LightRecord record;
    double power = 0.0;
};
// `sceneRadius`, in m, bounds the extent that infinite lights shine on. A hidden light has power 0.
PoweredLight PunctualLight(const scene::Light& light, bool isHidden, const ProfileTable& profiles,
                           double sceneRadius);

// Describes one TLAS instance of a group with emitters. It is one light for each of them, in their order, or
// one light in all.
struct EmitterPlacement {
    uint32_t record = 0;     // index of its InstanceRecord
    uint32_t instance = 0;   // index into LightScene::instances
    uint32_t group = 0;      // index into LightScene::groups
    bool isRemoved = false;  // the numbers of its lights stay taken, and the lights are dark
    uint32_t firstLight = 0;
    uint32_t lightCount = 0;
};

// Groups whose emitters would be more lights than this over all placements are shared: each placement is one
// light. Fewer are sampled a bit better one by one.
inline constexpr uint32_t kMaxExpandedLights = 4096;
// Groups with fewer emitters are not shared, since that would save nothing.
inline constexpr uint32_t kMinSharedEmitters = 4;

// Everything on which the tables depend.
struct LightScene {
    struct Instance {
        glm::mat4x3 objectToWorld{1.0f};
        bool isVisible = true;
    };
    std::vector<std::vector<Emitter>> groups;  // empty for groups without emitters
    // By group: deformed groups are never shared. Empty: none is deformed.
    std::vector<bool> isDeformed;
    std::vector<EmitterPlacement> placements;
    std::vector<Instance> instances;
    std::vector<glm::vec3> emission;  // by material: radiance, before the texture
    std::vector<scene::Light> punctual;
    std::vector<bool> isPunctualHidden;  // empty: none is hidden
    ProfileTable profiles;
    float radius = 0.0f;  // m, of what is visible: infinite lights shine on it

    LightGroups lightGroups;

    glm::vec3 environmentRadiance{0.0f};  // mean over the sphere
    float skyIrradiance = 0.0f;           // LightSetRecord::skyIrradiance
    float environmentRotation = 0.0f;
    uint32_t environmentWidth = 1, environmentHeight = 1;  // cells of its table

    uint32_t maxExpandedLights = kMaxExpandedLights;
    std::vector<bool> isShared;  // indexed by group

    // Tells whether each of `placementCount` placements of a group is one light.
    bool Shares(size_t group, uint64_t placementCount) const;
    // Decides which groups are shared, and numbers the lights of the placements from 0 on. Returns the number
    // of lights. With `stay`, a group that was shared stays so after placements have been removed: a few are
    // sampled a bit worse as one light, but the tables do not grow.
    uint32_t NumberEmitters(bool stay = false);
};

// The changes of a LightScene.
struct LightEdits {
    bool isAll = true;  // everything; the other fields are ignored
    // Transforms and visibility; positions of emitters, if they are not shared.
    std::vector<uint32_t> placements;
    std::vector<uint32_t> punctual;  // all properties except whether they are directional
    bool powersDirty = false;        // radius, or radiance of the environment
    bool transformsDirty = false;    // all transforms have been moved by the same translation

    bool IsEmpty() const {
        return !isAll && placements.empty() && punctual.empty() && !powersDirty && !transformsDirty;
    }
};

// The changes of the tables.
struct LightTableChanges {
    bool isAll = false;              // everything, sizes included
    bool isRebuilt = false;          // the tree
    bool allRecordsChanged = false;  // all records and nodes of lights
    bool isAlias = false;
    std::vector<uint32_t> lights, nodes;

    bool IsEmpty() const {
        return !isAll && !allRecordsChanged && !isAlias && lights.empty() && nodes.empty();
    }
};

class LightTable {
  public:
    // Updates the tables to `scene`, in which the emitters are numbered.
    //
    // The tree is rebuilt if `mayRefit` is false, or if a light shines that was dark when the tree was built.
    // Otherwise the changed records, their leaves and the nodes above are updated in place, and powers that
    // differ by less than kPowerTolerance keep their values, since they are only weights. Triangles that are
    // hidden, dark or without area keep their number and have probability 0. With the tree, infinite lights
    // are chosen by their share of the power; but neither they nor the bounded lights are chosen with less
    // than kMinLightShare, because it is not known how much of the infinite light reaches a point.
    LightTableChanges Update(const LightScene& scene, const LightEdits& edits, bool mayRefit);
    // Must be called once for each frame that samples the current tree. Returns true if updates have decayed
    // it, by the rule of tlas_quality.h for LightTree::RelativeCost.
    bool UpdateDecay() { return m_quality.UpdateDecay(m_tree.RelativeCost(), m_tree.Nodes().size() / 2); }
    void BuildTree(const LightScene& scene, LightTableChanges& changes);

    // Counts and shares, without the record of the environment.
    const gpu::LightSetRecord& Set() const { return m_set; }
    // Returns the record with the environment as it is in the scene now.
    gpu::LightSetRecord SetIn(const LightScene& scene) const;
    uint64_t EmissiveTriangleCount() const { return m_emissiveTriangleCount; }  // those that shine
    const std::vector<gpu::LightMeshRecord>& Meshes() const { return m_meshRecords; }
    const std::vector<gpu::AliasEntry>& Alias() const { return m_alias; }  // without those of meshes
    const std::vector<gpu::AliasEntry>& MeshAlias() const { return m_meshAlias; }
    // These are the tables as on the device. Records between those of the lights and those of the meshes are
    // never read.
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
    // `bounds` is null: the bounds are those of the record.
    void SetLight(uint32_t number, gpu::LightRecord record, double power, const LightBounds* bounds,
                  bool isRefit, LightTableChanges& changes);
    void SetInfinitePowers(const LightScene& scene);
    void Place(const LightScene& scene, LightTableChanges& changes);
    void UpdateNodeCount();
    void BuildAlias();

    std::vector<gpu::LightRecord> m_lights;
    std::vector<double> m_power;  // by light, the environment last
    LightTree m_tree;             // over the bounded lights
    std::vector<gpu::AliasEntry> m_alias;
    gpu::LightSetRecord m_set{};
    uint64_t m_emissiveTriangleCount = 0;
    std::vector<uint32_t> m_shiningCounts;    // by placement: triangles that shine
    std::vector<uint32_t> m_punctualNumbers;  // by punctual light: its number
    TlasQuality m_quality;

    std::vector<LightMesh> m_meshes;
    std::vector<uint32_t> m_meshOf;         // by group: its mesh, if it is shared
    std::vector<LightBounds> m_meshBounds;  // by placement, if its group is shared
    std::vector<gpu::LightMeshRecord> m_meshRecords;
    std::vector<gpu::LightRecord> m_meshLights;
    std::vector<gpu::LightNode> m_meshNodes;
    std::vector<gpu::AliasEntry> m_meshAlias;
};

inline constexpr double kMinLightShare = 0.1;
inline constexpr double kPowerTolerance = 1e-3;

// Builds the table of a scene in which the emitters are numbered. O(n log n).
LightTable BuildLightTable(const LightScene& scene);

// --- ChangeList: the indices of changed objects, each listed once ---

// Makes room for `count` more elements, at least doubling the capacity.
template <typename Value>
void ReserveMore(std::vector<Value>& list, size_t count) {
    if (list.capacity() - list.size() < count)
        list.reserve(std::max(list.size() + count, 2 * list.capacity()));
}

class ChangeList {
  public:
    explicit ChangeList(size_t count = 0) : m_isListed(count) {}
    // Adds an index. Returns false if it is listed already.
    bool Add(uint32_t index) {
        if (m_isListed[index]) return false;
        m_list.push_back(index);
        m_isListed[index] = true;
        return true;
    }
    // Makes room for `count` more indices, so that adding them does not throw.
    void Reserve(size_t count) { ReserveMore(m_list, count); }
    void Clear() {
        for (const uint32_t index : m_list) m_isListed[index] = false;
        m_list.clear();
    }
    bool IsEmpty() const { return m_list.empty(); }
    // Returns the indices in the order in which they were added.
    std::span<const uint32_t> List() const { return m_list; }

  private:
    std::vector<uint32_t> m_list;
    std::vector<bool> m_isListed;
};

// --- Alias tables: a choice by weight in constant time. The slots are gpu::AliasEntry ---

// Fills one slot for each weight, in linear time (Vose 1991, "A Linear Algorithm for Generating Random
// Numbers with a Given Distribution"). Weights are finite and not negative. An outcome with a weight of 0 is
// never chosen, unless all weights are 0: then every slot chooses itself with probability 0. Returns the sum
// of the weights.
double BuildAliasTable(std::span<const double> weights, std::span<gpu::AliasEntry> slots);

}  // namespace raygraph
