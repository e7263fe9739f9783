// Variants of a scene: which materials its primitives have (KHR_materials_variants).
//
//   scene::SetVariant(data, scene::FindVariant(data, "red"));    // before GpuScene::SetScene
//   gpuScene.SetVariant(scene::FindVariant(data, "blue"));       // after it
//
// Threads: pure functions of their arguments, for any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Returns the variant of this name (the first, if several have it), else of this index as decimal digits;
// kNone for "". Error{BadInput} naming what there is, if there is no such variant.
RAYGRAPH_API uint32_t FindVariant(const SceneData& scene, std::string_view choice);

// Returns the text by which FindVariant finds a variant: its name, or its index if an earlier one has that
// name; "" for kNone.
RAYGRAPH_API std::string VariantText(const SceneData& scene, uint32_t variant);

// Returns the index in Primitive::variants, or in another list that ascends by `variant` and ends with kNone,
// of the entry for a variant; the list is not empty.
template <typename Entry>
size_t VariantEntry(std::span<const Entry> entries, uint32_t variant) {
    size_t low = 0, high = entries.size() - 1;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (entries[middle].variant < variant)
            low = middle + 1;
        else
            high = middle;
    }
    return entries[low].variant == variant ? low : entries.size() - 1;
}

// Returns the material of a primitive in a variant; kNone: in none.
RAYGRAPH_API uint32_t MaterialOf(const Primitive& primitive, uint32_t variant);

// Gives all primitives their materials in the variant; kNone: those without one. Error{Usage} if there is no
// such variant.
RAYGRAPH_API void SetVariant(SceneData& scene, uint32_t variant);

}  // namespace raygraph::scene
