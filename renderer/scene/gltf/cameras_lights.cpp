#include <cmath>

#include "base/text.h"
#include "renderer/scene/gltf/choice.h"
#include "renderer/scene/gltf/nodes.h"
#include "renderer/scene/gltf/values.h"
#include "renderer/scene/model/camera_fields.h"
#include "renderer/scene/model/light_fields.h"

namespace raygraph::scene {
namespace {

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
    camera.projection =
        file.type == camera_fields::kPerspective ? Projection::Perspective : Projection::Orthographic;
    ForEachCameraField(camera.projection, [&](const auto& field) {
        float& value = camera.*field.member;
        // A number of tinygltf, by its key
#define RAYGRAPH_READ(view, number) \
    if (file.type == #view && field.key == std::string_view(#number)) value = ToFloat(file.view.number);
        RAYGRAPH_READ(perspective, yfov)
        RAYGRAPH_READ(perspective, aspectRatio)
        RAYGRAPH_READ(perspective, znear)
        RAYGRAPH_READ(perspective, zfar)
        RAYGRAPH_READ(orthographic, xmag)
        RAYGRAPH_READ(orthographic, ymag)
        RAYGRAPH_READ(orthographic, znear)
        RAYGRAPH_READ(orthographic, zfar)
#undef RAYGRAPH_READ
    });
    if (camera.projection == Projection::Orthographic) {
        const Place orthographic = where[camera_fields::kOrthographic];
        camera.xMag = Magnification(context, camera.xMag, orthographic["xmag"]);
        camera.yMag = Magnification(context, camera.yMag, orthographic["ymag"]);
    }
    if (camera.zFar == 0.0f || camera.zFar > camera.zNear) return camera;
    const std::string why = Text("zfar ({:f}) must be greater than znear ({:f})", camera.zFar, camera.zNear);
    if (camera.projection == Projection::Orthographic) context.Fail(where, why);
    context.Warn(where, "zfar", why + ", taken as infinite, as in all perspective views");
    camera.zFar = 0.0f;
    return camera;
}

Light ReadLight(GltfContext& context, const ValueReader& file, const Place& where) {
    Light light;
    std::string type;
    file.Read("name", light.name);
    file.Read("type", type);
    ReadChoice(type, light.type);
    ForEachLightField(light.type, [&](const auto& field) {
        const ValueReader object = *field.object == 0 ? file : file.In(field.object);
        object.Read(field.key, light.*field.member);
    });
    if (light.type == LightType::Spot) {
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
    const ValueReader files = ValueReader(model.extensions, "KHR_lights_punctual").In("lights");
    std::vector<Light> read;
    for (size_t i = 0; i < model.lights.size(); ++i) read.push_back(ReadLight(context, files[i], lights[i]));
    return read;
}

}  // namespace raygraph::scene
