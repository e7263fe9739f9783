#include "renderer/scene/variants.h"

#include <algorithm>
#include <charconv>
#include <span>
#include <string>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

// "0 'red', 1 'blue'", as far as they fit a line.
std::string Listed(const std::vector<std::string>& names) {
    constexpr size_t kMaxListed = 20, kMaxNameBytes = 60;
    std::string list;
    for (size_t i = 0; i < names.size() && i < kMaxListed; ++i)
        list += Text("{} {} {}", i == 0 ? "" : ",", i, Quoted(names[i], kMaxNameBytes));
    if (names.size() > kMaxListed) list += Text(" and {} more", names.size() - kMaxListed);
    return names.empty() ? " no variants" : list;
}

}  // namespace

uint32_t FindVariant(const SceneData& scene, std::string_view choice) {
    if (choice.empty()) return kNone;
    for (uint32_t i = 0; i < scene.variants.size(); ++i)
        if (scene.variants[i] == choice) return i;
    uint32_t index = 0;
    const auto [end, error] = std::from_chars(choice.data(), choice.data() + choice.size(), index);
    const bool isIndex = error == std::errc() && end == choice.data() + choice.size();
    if (isIndex && index < scene.variants.size()) return index;
    throw MakeError(ErrorKind::BadInput, "there is no variant {}; the scene has{}", Quoted(choice),
                    Listed(scene.variants));
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
