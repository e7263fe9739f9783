#include <cmath>
#include <glm/gtc/constants.hpp>

#include "renderer/scene/gltf_nodes.h"

namespace raygraph::scene {
namespace {

float Positive(const JsonValue& value) {
    const float number = value.Float();
    if (!(number > 0.0f)) value.Fail("is " + value.Shown() + ", must be above 0");
    return number;
}

float NotNegative(const JsonValue& value, float absent) {
    const float number = value.FloatOr(absent);
    if (number < 0.0f) value.Fail("is " + value.Shown() + ", must not be negative");
    return number;
}

void ReadPerspective(const JsonValue& value, Camera& camera) {
    camera.projection = Projection::Perspective;
    camera.yFov = Positive(value.RequireObject()["yfov"]);
    if (camera.yFov >= glm::pi<float>())
        value["yfov"].Fail("is " + value["yfov"].Shown() + ", must be below pi");
    if (value["aspectRatio"].IsPresent()) camera.aspectRatio = Positive(value["aspectRatio"]);
    camera.zNear = Positive(value["znear"]);
    if (value["zfar"].IsPresent()) camera.zFar = Positive(value["zfar"]);
}

void ReadOrthographic(GltfContext& context, const JsonValue& value, Camera& camera) {
    camera.projection = Projection::Orthographic;
    const auto magnification = [&](const JsonValue& mag) {
        const float number = mag.Float();
        if (number == 0.0f) mag.Fail("is 0, must not be");
        if (number < 0.0f) context.Warn(mag, "mag", "is " + mag.Shown() + ", taken without its sign");
        return std::abs(number);
    };
    camera.xMag = magnification(value.RequireObject()["xmag"]);
    camera.yMag = magnification(value["ymag"]);
    camera.zNear = NotNegative(value["znear"], 0.0f);
    camera.zFar = Positive(value["zfar"]);
}

Camera ReadCamera(GltfContext& context, const JsonValue& value) {
    Camera camera;
    camera.name = value.RequireObject()["name"].StringOr("");
    const JsonValue type = value["type"];
    if (type.String() == "perspective") {
        ReadPerspective(value["perspective"], camera);
    } else if (type.String() == "orthographic") {
        ReadOrthographic(context, value["orthographic"], camera);
    } else {
        type.Fail("is " + type.Shown() + ", must be perspective or orthographic");
    }
    if (camera.zFar != 0.0f && camera.zFar <= camera.zNear)
        value.Fail("zfar (" + std::to_string(camera.zFar) + ") must be greater than znear (" +
                   std::to_string(camera.zNear) + ")");
    return camera;
}

Light ReadLight(const JsonValue& value) {
    Light light;
    light.name = value.RequireObject()["name"].StringOr("");
    value["color"].FloatsIfPresent({&light.color.x, 3});
    for (int i = 0; i < 3; ++i)
        if (light.color[i] < 0.0f) value["color"].Fail("must not be negative");
    light.intensity = NotNegative(value["intensity"], 1.0f);
    if (value["range"].IsPresent()) light.range = Positive(value["range"]);
    const JsonValue type = value["type"];
    if (type.String() == "directional") {
        light.type = LightType::Directional;
    } else if (type.String() == "point") {
        light.type = LightType::Point;
    } else if (type.String() == "spot") {
        light.type = LightType::Spot;
        const JsonValue spot = value["spot"].RequireObject();
        light.innerConeAngle = NotNegative(spot["innerConeAngle"], 0.0f);
        light.outerConeAngle = NotNegative(spot["outerConeAngle"], glm::quarter_pi<float>());
        // A rounded pi/2 may be a little above it.
        if (light.outerConeAngle > glm::half_pi<float>() + 1e-5f ||
            light.innerConeAngle >= light.outerConeAngle)
            spot.Fail("innerConeAngle must be below outerConeAngle, and that at most pi/2");
    } else {
        type.Fail("is " + type.Shown() + ", must be directional, point or spot");
    }
    return light;
}

}  // namespace

std::vector<Camera> ReadCameras(GltfContext& context, const JsonValue& root) {
    std::vector<Camera> cameras;
    const JsonValue values = root["cameras"];
    for (size_t i = 0; i < values.Count(); ++i) cameras.push_back(ReadCamera(context, values.At(i)));
    return cameras;
}

std::vector<Light> ReadLights(const JsonValue& root) {
    std::vector<Light> lights;
    const JsonValue values = root["extensions"]["KHR_lights_punctual"]["lights"];
    for (size_t i = 0; i < values.Count(); ++i) lights.push_back(ReadLight(values.At(i)));
    return lights;
}

}  // namespace raygraph::scene
