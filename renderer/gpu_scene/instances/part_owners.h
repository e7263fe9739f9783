// Whose the objects of a GpuScene are: what takes the index of one that has been removed is not the same.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace raygraph {

// Of objects of one kind, by index. Parts count from kOwnedByScene + 1 on.
inline constexpr uint32_t kOwnedByNone = 0, kOwnedByScene = 1;

class Owners {
  public:
    // So many of the scene that has been set, and no others.
    void Reset(size_t count) { m_owners.assign(count, kOwnedByScene); }
    // Room for an object that is about to be added, so that Set throws nothing.
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
