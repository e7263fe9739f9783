// PartOwners tells which part owns an object of a GpuScene, so that a new object at the index of a removed
// one is not taken for it. Threads: as std::vector.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace raygraph {

// Owners of the objects of one kind, by index. Parts are numbered from kOwnedByScene + 1 on.
inline constexpr uint32_t kOwnedByNone = 0, kOwnedByScene = 1;

class Owners {
  public:
    // Makes the scene the owner of objects 0 to `count` - 1, and removes all others.
    void Reset(size_t count) { m_owners.assign(count, kOwnedByScene); }
    // Makes room for an object that is about to be added, so that Set does not throw.
    void Reserve(size_t count) {
        if (m_owners.capacity() < count) m_owners.reserve(std::max(count, 2 * m_owners.capacity()));
    }
    void Set(uint32_t index, uint32_t owner) {
        if (index >= m_owners.size()) m_owners.resize(index + size_t{1}, kOwnedByNone);
        m_owners[index] = owner;
    }
    void Forget(uint32_t index) noexcept {
        if (index < m_owners.size()) m_owners[index] = kOwnedByNone;
    }
    uint32_t Of(uint32_t index) const { return index < m_owners.size() ? m_owners[index] : kOwnedByNone; }

  private:
    std::vector<uint32_t> m_owners;
};

struct ObjectOwners {
    Owners textures, materials, meshes, instances, lights;
};

}  // namespace raygraph
