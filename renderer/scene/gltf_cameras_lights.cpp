#include <cmath>

#include "base/text.h"
#include "renderer/scene/gltf_choice.h"
#include "renderer/scene/gltf_nodes.h"
#include "renderer/scene/light_fields.h"

namespace raygraph::scene {
namespace {

// Finite and in its range: the schema has seen to it.
float ToFloat(double number) {
    return static_cast<float>(number);
}

// Half the size of an orthographic view.
float Magnification(GltfContext& context, double value, const Place& where) {
    const float number = ToFloat(value);
    if (number == 0.0f) context.Fail(where, "is 0, must not be");
    if (number < 0.0f) context.Warn(where, "mag", "is negative, taken without its sign");
    return std::abs(number);
}

Camera ReadCamera(GltfContext& context, const gltf::Camera& file, const Place& where) {
    Camera camera;
    camera.name = file.name;
    if (file.type == "perspective") {
        camera.projection = Projection::Perspective;
        camera.yFov = ToFloat(file.perspective.yfov);
        camera.aspectRatio = ToFloat(file.perspective.aspectRatio);
        camera.zNear = ToFloat(file.perspective.znear);
        camera.zFar = ToFloat(file.perspective.zfar);
    } else {
        const Place orthographic = where["orthographic"];
        camera.projection = Projection::Orthographic;
        camera.xMag = Magnification(context, file.orthographic.xmag, orthographic["xmag"]);
        camera.yMag = Magnification(context, file.orthographic.ymag, orthographic["ymag"]);
        camera.zNear = ToFloat(file.orthographic.znear);
        camera.zFar = ToFloat(file.orthographic.zfar);
    }
    if (camera.zFar == 0.0f || camera.zFar > camera.zNear) return camera;
    const std::string why = Text("zfar ({:f}) must be greater than znear ({:f})", camera.zFar, camera.zNear);
    if (camera.projection == Projection::Orthographic) context.Fail(where, why);
    context.Warn(where, "zfar", why + ", taken as infinite, as in all perspective views");
    camera.zFar = 0.0f;
    return camera;
}

Light ReadLight(GltfContext& context, const gltf::Light& file, const Place& where) {
    Light light;
    light.name = file.name;
    for (size_t i = 0; i < file.color.size(); ++i) light.color[static_cast<int>(i)] = ToFloat(file.color[i]);
    light.intensity = ToFloat(file.intensity);
    ReadChoice(file.type, light.type);
    if (light.type == LightType::Directional) return light;  // a range would mean nothing
    light.range = ToFloat(file.range);
    if (light.type == LightType::Spot) {
        light.innerConeAngle = ToFloat(file.spot.innerConeAngle);
        light.outerConeAngle = ToFloat(file.spot.outerConeAngle);
        // Exporters mean a cone without a soft edge
        if (light.innerConeAngle == light.outerConeAngle && light.outerConeAngle > 0.0f) {
            context.Warn(
                where[light_fields::kSpot]["innerConeAngle"], "cone",
                Text("is {}, which outerConeAngle is too, taken as just below it", light.innerConeAngle));
            light.innerConeAngle = std::nextafter(light.outerConeAngle, 0.0f);
        }
        if (!HasCone(light)) context.Fail(where[light_fields::kSpot], kConeRule);
    }
    return light;
}

}  // namespace

std::vector<Camera> ReadCameras(GltfContext& context, const gltf::Model& model) {
    std::vector<Camera> cameras;
    for (size_t i = 0; i < model.cameras.size(); ++i)
        cameras.push_back(ReadCamera(context, model.cameras[i], Place("cameras")[i]));
    return cameras;
}

std::vector<Light> ReadLights(GltfContext& context, const gltf::Model& model) {
    const Place lights = Place("extensions")["KHR_lights_punctual"]["lights"];
    std::vector<Light> read;
    for (size_t i = 0; i < model.lights.size(); ++i)
        read.push_back(ReadLight(context, model.lights[i], lights[i]));
    return read;
}

}  // namespace raygraph::scene
