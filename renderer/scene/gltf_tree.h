// The JSON tree of a glTF document. Internal to renderer/scene.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace raygraph::scene {

// The standard allocator under a name of ours: it makes the tree a type of ours, for which tinygltf's call of
// the parser means something else than for all other trees (tinygltf.cpp).
template <typename T>
struct GltfTreeAllocator : std::allocator<T> {
    GltfTreeAllocator() = default;
    template <typename U>
    GltfTreeAllocator(const GltfTreeAllocator<U>&) {}
};

using GltfTree = nlohmann::basic_json<std::map, std::vector, std::string, bool, int64_t, uint64_t, double,
                                      GltfTreeAllocator>;

}  // namespace raygraph::scene
