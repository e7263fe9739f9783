// KHR_animation_pointer: resolves a JSON pointer (RFC 6901) into the document to its targets in the scene.
// Internal to renderer/scene.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "renderer/scene/gltf/context.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// The conversion from the numbers of an accessor to those of a target.
enum class ValueKind : uint8_t {
    Plain,
    Rotation,    // unit length
    Flag,        // 0 or not
    Glossiness,  // 1 minus them
};

// Holds the scene as the outline has it, the file's indices of its cameras and lights (which ascend), and how
// many objects the file has.
struct PointerScene {
    const SceneData& scene;
    std::span<const uint32_t> cameras, lights;
    size_t materialCount = 0, meshCount = 0, cameraCount = 0, lightCount = 0;
};

struct PointerTargets {
    ValueKind kind = ValueKind::Plain;
    // Has several elements where the file's object is placed several times, and none if it is placed nowhere.
    std::vector<AnimationTarget> targets;
};

// Fails at `where` if the text is no pointer, or names an object that the file does not have. A pointer to
// what is not read gives a warning and no targets.
PointerTargets ResolvePointer(GltfContext& context, const std::string& pointer, const PointerScene& pointed,
                              const Place& where);

}  // namespace raygraph::scene
