// Own trees traversed on the host, by the text that the device runs.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "renderer/bvh/wide_scene.h"

namespace raygraph::shading {

inline thread_local const WideScene* s_scene = nullptr;
inline thread_local glm::uvec2 s_stack[gpu::kWideStackSize];
inline thread_local std::function<bool(const gpu::WideHit&, bool isBack, bool isAny)> s_isAccepted;

template <typename T>
glm::uvec4 WordOf(const std::vector<T>& records, uint32_t at) {
    glm::uvec4 word;
    std::memcpy(&word, reinterpret_cast<const std::byte*>(records.data()) + 16 * size_t{at}, 16);
    return word;
}
inline glm::uvec4 WideNodeWord(uint32_t at) {
    return WordOf(s_scene->nodes, at);
}
inline glm::uvec4 WideTriangleWord(uint32_t at) {
    return WordOf(s_scene->triangles, at);
}
inline glm::uvec4 WideInstanceWord(uint32_t at) {
    return WordOf(s_scene->instances, at);
}
inline void PushGroup(uint32_t at, glm::uvec2 group) {
    ASSERT_LT(at, gpu::kWideStackSize);
    s_stack[at] = group;
}
inline glm::uvec2 GroupAt(uint32_t at) {
    return s_stack[at];
}
inline bool IsAccepted(const gpu::WideHit& hit, bool isBack, bool isAny) {
    return s_isAccepted(hit, isBack, isAny);
}

}  // namespace raygraph::shading

#include "scene/wide_bvh.glsl"

namespace raygraph {

// A scene whose only instance is none has one level.
inline gpu::WideHit Traverse(const WideScene& scene, const gpu::BenchRay& ray, bool isAny) {
    shading::s_scene = &scene;
    gpu::WideCounts counts{};
    const bool hasOneLevel = scene.instances.size() == 1;
    return shading::TraverseWide(ray.origin, ray.direction, ray.tMax, isAny, hasOneLevel, counts);
}

}  // namespace raygraph
