// Every property of every material extension, for files that are changed at random.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "renderer/scene/model/scene_fields.h"

namespace raygraph::test {

// A material's `extensions`; there are textures 0 and 1. But for KHR_materials_pbrSpecularGlossiness, which
// excludes others.
inline nlohmann::json MaterialExtensions() {
    nlohmann::json extensions;
    int texture = 0;
    scene::ForEachMaterialField([&](const auto& field) {
        using Value = typename std::decay_t<decltype(field)>::Value;
        std::string place = std::string("/") + field.object + "/" + field.key;
        if (!place.starts_with("/KHR_") || *field.key == 0) return;
        std::ranges::replace(place, '.', '/');
        nlohmann::json& value = extensions[nlohmann::json::json_pointer(place)];
        if constexpr (std::is_same_v<Value, scene::TextureRef>)
            value["index"] = texture++ % 2;
        else if constexpr (std::is_same_v<Value, glm::vec3>)
            value = {0, 0.5, 1};
        else
            value = std::max(0.5f, field.range.min);
    });
    extensions["KHR_materials_volume"]["thicknessTexture"]["index"] = 1;
    extensions["KHR_materials_volume_scatter"]["multiscatterColorTexture"]["index"] = 0;
    extensions["KHR_materials_sheen"]["sheenRoughnessTexture"]["extensions"]["KHR_texture_transform"] = {
        {"offset", {0, 1}}, {"rotation", 1}, {"scale", {1, 2}}, {"texCoord", 1}};
    return extensions;
}

}  // namespace raygraph::test
