// The names of scene/bindings.glsl, and what else shaders have of the device, for shader text that is
// compiled as C++: over copiedScene and parameters, which are set before. For trace.cpp alone. Threads: those
// variables are of the calling thread.
#pragma once

#include <cstddef>
#include <cstring>
#include <glm/glm.hpp>
#include <vector>

#include "base/text.h"
#include "core/capsule.glsl"
#include "editor/session/cpu/scene_copy.h"
#include "renderer/gpu_scene/materials/energy_tables.h"
#include "shaders/shared/path_record.h"
#include "shaders/shared/scene_records.h"
#include "shaders/shared/wide_bvh.h"

namespace raygraph::shading {

using namespace gpu;

static thread_local const session::SceneCopy* copiedScene = nullptr;
static thread_local struct { TraceParameters value; } parameters;

template <typename T>
[[noreturn]] void RefuseIndex(uint index, size_t size) {
    throw MakeError(ErrorKind::BadInput, "a shader reads record {} of a table of {}, of {} bytes each", index,
                    size, sizeof(T));
}

// --- Buffer references, checked at each access ---

// Values at an address of the device.
template <typename T>
struct StreamOf {
    struct Values {
        uint64_t address;
        const T& operator[](uint index) const {
            return copiedScene->memory.At<T>(address + uint64_t{index} * sizeof(T)).front();
        }
    } at;
    explicit StreamOf(Address address) : at{address} {}
    explicit StreamOf(uvec2 address) : at{address.x | uint64_t{address.y} << 32u} {}
};
using UintStream = StreamOf<uint>;
using CapsuleStream = StreamOf<CapsuleRecord>;
using Vec2Stream = StreamOf<vec2>;
using Vec3Stream = StreamOf<vec3>;
using Vec4Stream = StreamOf<vec4>;
using PixelListStream = StreamOf<ListedPixel>;

// A table of the scene.
template <typename T, std::vector<T> session::SceneCopy::*table>
struct TableOf {
    struct Records {
        const T& operator[](uint index) const {
            const std::vector<T>& records = copiedScene->*table;
            if (index >= records.size()) RefuseIndex<T>(index, records.size());
            return records[index];
        }
    } at;
};
inline constexpr TableOf<InstanceRecord, &session::SceneCopy::instances> instances;
inline constexpr TableOf<GeometryRecord, &session::SceneCopy::geometries> geometries;
inline constexpr TableOf<MaterialRecord, &session::SceneCopy::materials> materials;
inline constexpr TableOf<LightRecord, &session::SceneCopy::lights> lights;
inline constexpr TableOf<LightNode, &session::SceneCopy::lightNodes> lightNodes;
inline constexpr TableOf<AliasEntry, &session::SceneCopy::lightAlias> lightAlias;
inline constexpr TableOf<LightMeshRecord, &session::SceneCopy::lightMeshes> lightMeshes;
inline constexpr TableOf<float, &session::SceneCopy::lightProfiles> lightProfiles;
inline constexpr TableOf<EnvironmentEntry, &session::SceneCopy::environmentTable> environmentTable;

static const struct {
    struct Entries {
        uvec4 operator[](uint index) const {
            const EnergyEntryBits& entry = EnergyTables()[index];
            const auto word = [&](size_t i) { return uint{entry[2 * i]} | uint{entry[2 * i + 1]} << 16u; };
            return {word(0), word(1), word(2), word(3)};
        }
    } at;
} energyTables;

static inline InstanceRecord InstanceAt(uint index) {
    return instances.at[index];
}
static inline bool IsPresent(Address address) {
    return address != 0;
}

// --- Textures ---

#define nonuniformEXT(index) (index)

static const struct {
    const session::CopiedTexture& operator[](uint slot) const {
        if (slot >= copiedScene->textures.size())
            RefuseIndex<session::CopiedTexture>(slot, copiedScene->textures.size());
        return copiedScene->textures[slot];
    }
} textures;
#define environmentMap copiedScene->environmentMap

static inline vec4 textureLod(const session::CopiedTexture& texture, vec2 uv, float lod) {
    return texture.Sample(uv, lod);
}
static inline glm::ivec2 textureSize(const session::CopiedTexture& texture, int) {
    return {texture.Extent().width, texture.Extent().height};
}

// --- Trees ---

static thread_local uvec2 groupStack[kWideStackSize];

static inline void PushGroup(uint at, uvec2 group) {
    if (at >= kWideStackSize) RefuseIndex<uvec2>(at, kWideStackSize);
    groupStack[at] = group;
}
static inline uvec2 GroupAt(uint at) {
    return groupStack[at];
}

template <typename T>
uvec4 WordOf(const std::vector<T>& records, uint at) {
    uvec4 word;
    const size_t offset = sizeof(word) * size_t{at};
    if (offset >= records.size() * sizeof(T))
        RefuseIndex<uvec4>(at, records.size() * sizeof(T) / sizeof(word));
    std::memcpy(&word, reinterpret_cast<const std::byte*>(records.data()) + offset, sizeof(word));
    return word;
}
static inline uvec4 WideNodeWord(uint at) {
    return WordOf(copiedScene->trees.nodes, at);
}
static inline uvec4 WideTriangleWord(uint at) {
    return WordOf(copiedScene->trees.triangles, at);
}
static inline uvec4 WideInstanceWord(uint at) {
    return WordOf(copiedScene->trees.instances, at);
}

// --- The records of the path ---

// Grows to the vertices that a path has.
class RecordList {
  public:
    static int length() { return static_cast<int>(kMaxRecordedVertices); }
    PathVertexRecord& operator[](uint index) {
        if (index >= m_records.size()) m_records.resize(index + size_t{1});
        return m_records[index];
    }
    void Clear() { m_records.clear(); }
    std::vector<PathVertexRecord> Take(uint count) {
        m_records.resize(count);
        return std::move(m_records);
    }

  private:
    std::vector<PathVertexRecord> m_records;
};
static thread_local struct {
    uint count = 0;
    RecordList at;
} pathRecords;

}  // namespace raygraph::shading
