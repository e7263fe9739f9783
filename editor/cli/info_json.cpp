#include "editor/cli/info_json.h"

#include <nlohmann/json.hpp>

#include "editor/cli/device_list.h"
#include "editor/cli/json_values.h"
#include "editor/cli/scene_text.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/picture_settings.h"
#include "renderer/scene/gltf/document.h"
#include "renderer/scene/model/camera_view.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::cli {

namespace {

using Json = nlohmann::ordered_json;

using cli::ValueJson;  // those below hide it

Json ValueJson(scene::AlphaMode value) {
    return Name(value);
}
Json ValueJson(const scene::TextureRef& value) {
    return value.texture;
}

// Returns the values that differ from those of a struct without any, by their places in the file: "range",
// "KHR_materials_ior.ior". `forEach` calls its argument with each field.
template <typename Owner, typename ForEach>
Json FieldsJson(const Owner& owner, ForEach&& forEach) {
    Json json = Json::object();
    forEach([&](const auto& field) {
        if (owner.*field.member == Owner{}.*field.member) return;
        std::string place = field.object;
        if (!place.empty() && *field.key != 0) place += '.';
        json[place + field.key] = ValueJson(owner.*field.member);
    });
    return json;
}

Json CameraJson(const scene::Camera& camera) {
    const bool isOrthographic = camera.projection == scene::Projection::Orthographic;
    Json json{{"name", camera.name}, {"projection", isOrthographic ? "orthographic" : "perspective"}};
    if (isOrthographic)
        json["height_m"] = ValueJson(2.0f * camera.yMag);
    else
        json["fov_degrees"] = ValueJson(glm::degrees(camera.yFov));
    json["eye"] = ValueJson(camera.cameraToWorld[3]);
    json["option"] = session::CameraText(scene::ViewOf(camera, 1.0f));
    json["fields"] =
        FieldsJson(camera, [&](const auto& visit) { scene::ForEachCameraField(camera.projection, visit); });
    return json;
}

Json LightJson(const scene::Light& light, const std::vector<scene::LightProfile>& profiles) {
    const bool isDirectional = light.type == scene::LightType::Directional;
    Json json{{"name", light.name}, {"type", Name(light.type)}};
    if (light.profile != scene::kNone) {
        json["type"] = "profile";
        json["max_intensity_cd"] = ValueJson(light.intensity * profiles.at(light.profile).MaxIntensity());
    } else {
        json[isDirectional ? "illuminance_lx" : "intensity_cd"] = ValueJson(light.intensity);
    }
    if (light.type == scene::LightType::Spot)
        json["cone_degrees"] = ValueJson(2.0f * glm::degrees(light.outerConeAngle));
    json["color"] = ValueJson(light.color);
    json["fields"] = FieldsJson(light, [&](const auto& visit) { scene::ForEachLightField(light, visit); });
    return json;
}

Json MaterialJson(const scene::Material& material) {
    return {
        {"name", material.name},
        {"base_color", ValueJson(glm::vec3(material.baseColorFactor))},
        {"has_base_color_texture", material.baseColorTexture.IsPresent()},
        {"emits", ValueJson(material.EmittedRadiance())},
        {"has_emissive_texture", material.emissiveTexture.IsPresent()},
        {"alpha", Name(material.alphaMode)},
        {"fields", FieldsJson(material, [&](const auto& visit) { scene::ForEachFieldOf(material, visit); })}};
}

template <typename Thing, typename ToJson>
Json List(const std::vector<Thing>& things, ToJson&& toJson) {
    Json list = Json::array();
    for (const Thing& thing : things) list.push_back(toJson(thing));
    return list;
}

// Names come from files and drivers: bytes that are not valid UTF-8 are replaced.
std::string TextOf(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string SceneJson(const session::SceneInput& input) {
    const scene::SceneData& scene = input.data;
    const scene::SceneStatistics statistics = scene::Statistics(scene);
    Json json;
    json["schema"] = 1;
    json["file"] = input.file;
    json["triangles_placed"] = statistics.placedTriangles;
    json["triangles_unique"] = statistics.uniqueTriangles;
    json["points_placed"] = statistics.placedSpheres;
    json["segments_placed"] = statistics.placedCapsules;
    json["instances"] = statistics.instanceCount;
    json["meshes"] = statistics.meshCount;
    json["textures"] = statistics.textureCount;
    json["geometry_bytes"] = statistics.geometryBytes;
    json["image_bytes"] = statistics.imageBytes;
    json["bounds_m"] = nullptr;
    if (!scene.bounds.IsEmpty())
        json["bounds_m"] = {{"min", ValueJson(scene.bounds.min)}, {"max", ValueJson(scene.bounds.max)}};
    json["environment"] = nullptr;
    if (const scene::EnvironmentLight& light = scene.environment; light.IsPresent())
        json["environment"] = {{"name", light.name}, {"face_size", light.faceSize}};
    json["cameras"] = List(scene.cameras, CameraJson);
    json["framed_camera"] = session::CameraText(FramedView(scene));
    json["lights"] =
        List(scene.lights, [&](const scene::Light& light) { return LightJson(light, scene.profiles); });
    json["materials"] = List(scene.materials, MaterialJson);
    json["variants"] = List(scene.variants, [](const std::string& name) { return name; });
    json["variant"] = scene.variant < scene.variants.size() ? Json(scene.variant) : Json();
    json["animations"] = List(input.animations, [](const session::AnimationLength& animation) {
        return Json{{"name", animation.name}, {"seconds", ValueJson(animation.seconds)}};
    });
    return TextOf(json);
}

std::string DevicesJson(std::span<const rhi::DeviceReport> devices) {
    Json json{{"schema", 1}, {"devices", Json::array()}};
    for (const rhi::DeviceReport& device : devices)
        json["devices"].push_back({{"index", device.index},
                                   {"name", device.name},
                                   {"type", Name(device.type)},
                                   {"vulkan", VersionText(device.apiVersion)},
                                   {"driver", device.driver},
                                   {"suitable", device.refusals.empty()},
                                   {"refusals", device.refusals}});
    return TextOf(json);
}

std::string ExtensionsJson() {
    Json json{{"schema", 1}, {"extensions", Json::array()}};
    for (const scene::GltfExtension& extension : scene::KnownExtensions())
        json["extensions"].push_back(
            {{"name", extension.name}, {"read", extension.isRead}, {"note", extension.note}});
    return TextOf(json);
}

}  // namespace raygraph::cli
