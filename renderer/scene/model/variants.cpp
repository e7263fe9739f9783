#include "renderer/scene/model/variants.h"

#include <algorithm>
#include <span>
#include <string>

#include "renderer/scene/model/named_choice.h"

namespace raygraph::scene {

uint32_t FindVariant(const SceneData& scene, std::string_view choice) {
    if (choice.empty()) return kNone;
    return FindNamed(scene.variants, choice, "variant", " no variants",
                     [](const std::string& name) -> const std::string& { return name; });
}

std::string VariantText(const SceneData& scene, uint32_t variant) {
    if (variant == kNone) return "";
    const std::string& name = scene.variants.at(variant);
    const bool isFound =
        !name.empty() && std::ranges::find(scene.variants, name) == scene.variants.begin() + variant;
    return isFound ? name : std::to_string(variant);
}

uint32_t MaterialOf(const Primitive& primitive, uint32_t variant) {
    if (primitive.variants.empty()) return primitive.material;
    const std::span<const VariantMaterial> entries = primitive.variants;
    return entries[VariantEntry(entries, variant)].material;
}

void SetVariant(SceneData& scene, uint32_t variant) {
    if (variant != kNone && variant >= scene.variants.size())
        throw MakeError(ErrorKind::Usage, "there is no variant {}, the scene has {}", variant,
                        scene.variants.size());
    for (Mesh& mesh : scene.meshes)
        for (Primitive& primitive : mesh.primitives) primitive.material = MaterialOf(primitive, variant);
    scene.variant = variant;
}

}  // namespace raygraph::scene
