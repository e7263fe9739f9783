#include "renderer/scene/gltf/lights.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "renderer/scene/formats/cube_map.h"
#include "renderer/scene/formats/ies_file.h"
#include "renderer/scene/gltf/choice_names.h"
#include "renderer/scene/gltf/reader.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {

// --- Cameras and punctual lights ---

namespace {

// Returns half the size of an orthographic view.
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
        // Reads a number of tinygltf, by its key
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

// --- The environment: EXT_lights_image_based ---

namespace {

Place PlaceOf(uint32_t light) {
    return Place("extensions")[kImageLightExtension]["lights"][light];
}

glm::quat ReadRotation(GltfContext& context, const gltf::Value& xyzw, const Place& where) {
    const auto number = [&](int i) { return xyzw.Get(i).GetNumberAsDouble(); };
    const glm::dquat q(number(3), number(0), number(1), number(2));
    const double length = glm::length(q);
    if (!(length > 1e-6)) context.Fail(where, "is a quaternion of length 0");
    if (std::abs(length - 1.0) > 5e-3) context.Warn(where, "rotation", "is not of unit length, normalized");
    return glm::quat(q / length);
}

}  // namespace

std::optional<ImageLight> ReadImageLight(GltfContext& context, const gltf::Model& model, uint32_t scene) {
    if (scene == kNone) return std::nullopt;
    const gltf::ExtensionMap& used = model.scenes[scene].extensions;
    const auto use = used.find(kImageLightExtension);
    if (use == used.end()) return std::nullopt;
    ImageLight light;
    light.index = static_cast<uint32_t>(use->second.Get("light").GetNumberAsInt());
    const gltf::Value& file =
        model.extensions.at(kImageLightExtension).Get("lights").Get(static_cast<int>(light.index));
    if (file.Has("name")) light.name = file.Get("name").Get<std::string>();
    if (file.Has("intensity"))
        light.intensity = static_cast<float>(file.Get("intensity").GetNumberAsDouble());
    if (file.Has("rotation"))
        light.rotation = ReadRotation(context, file.Get("rotation"), PlaceOf(light.index)["rotation"]);
    if (file.Has("specularImageSize"))
        light.size = static_cast<uint32_t>(file.Get("specularImageSize").GetNumberAsDouble());
    const gltf::Value& faces = file.Get("specularImages").Get(0);
    for (size_t i = 0; i < light.faces.size(); ++i)
        light.faces[i] = static_cast<uint32_t>(faces.Get(static_cast<int>(i)).GetNumberAsInt());
    return light;
}

std::vector<uint32_t> ImagesOf(const ImageLight& light) {
    std::vector<uint32_t> images(light.faces.begin(), light.faces.end());
    std::ranges::sort(images);
    images.erase(std::unique(images.begin(), images.end()), images.end());
    return images;
}

EnvironmentLight MakeEnvironmentLight(GltfContext& context, const ImageLight& light,
                                      std::span<const ImageData> images) {
    const std::vector<uint32_t> indices = ImagesOf(light);
    CubeMap cube{.intensity = light.intensity, .rotation = light.rotation};
    const Place where = PlaceOf(light.index);
    for (size_t i = 0; i < cube.faces.size(); ++i) {
        const ImageData& face =
            images[static_cast<size_t>(std::ranges::lower_bound(indices, light.faces[i]) - indices.begin())];
        const Place here = where["specularImages"][size_t{0}][i];
        const auto fail = [&](const char* rule) {
            context.Fail(here,
                         Text("images[{}] is {} x {}, {}", light.faces[i], face.width, face.height, rule));
        };
        if (face.width != face.height) fail("must be square");
        if (i > 0 && face.width != cube.faces[0]->width)
            fail(Text("the face before it {} x {}", cube.faces[0]->width, cube.faces[0]->width).c_str());
        cube.faces[i] = &face;
    }
    const uint32_t size = cube.faces[0]->width;
    if (light.size != 0 && light.size != size)
        context.Warn(where["specularImageSize"], "specularImageSize",
                     Text("is {}, but the images are {} x {}; ignored", light.size, size, size));
    // Each texel takes four times the bytes of a texture
    const uint64_t height = EquirectHeight(size), texels = 4 * (2 * height * height);
    const uint64_t left = context.options.limits.maxAllImageTexels - context.imageTexels;
    if (texels > left)
        context.Fail(where, Text("its map takes {} texels, which exceed the {} that are left", texels, left));
    context.imageTexels += texels;
    return {light.name, size, ToEquirect(cube, context.ThreadCount())};
}

// --- Lights with measured profiles: EXT_lights_ies ---

namespace {

ProfileSource ReadSource(const gltf::Value& file, uint32_t index) {
    ProfileSource source{.index = index};
    if (file.Has("name")) source.name = file.Get("name").Get<std::string>();
    if (file.Has("uri")) source.uri = file.Get("uri").Get<std::string>();
    if (file.Has("bufferView")) source.view = static_cast<uint32_t>(file.Get("bufferView").GetNumberAsInt());
    return source;
}

LightProfile Decode(GltfContext& context, const ProfileSource& source, GltfBuffers& buffers) {
    const Place where = ProfilePlace(source.index)[source.uri ? "uri" : "bufferView"];
    std::vector<std::byte> file;
    if (source.uri) file = context.ReadUri(*source.uri, where);
    const std::span<const std::byte> bytes = source.uri ? file : buffers.View(source.view);
    IesFile ies;
    try {
        ies = ParseIes({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    } catch (const Error& error) {
        context.Fail(where, error.what());
    }
    for (const std::string& warning : ies.warnings) context.Warn(where, "light profile", warning);
    context.ChargeGeometry(where, uint64_t{ies.profile.candela.size()} * sizeof(float));
    ies.profile.name = source.name;
    return std::move(ies.profile);
}

}  // namespace

Place ProfilePlace(size_t profile) {
    return Place("extensions")[kProfileExtension]["lights"][profile];
}

std::vector<ProfileSource> ReadProfileSources(const gltf::Model& model,
                                              const std::vector<uint32_t>& profiles) {
    const auto extension = model.extensions.find(kProfileExtension);
    if (extension == model.extensions.end() || !extension->second.Has("lights")) return {};
    const gltf::Value& files = extension->second.Get("lights");
    std::vector<ProfileSource> all, used;
    for (uint32_t i = 0; i < files.ArrayLen(); ++i)
        all.push_back(ReadSource(files.Get(static_cast<int>(i)), i));
    for (const uint32_t profile : profiles) used.push_back(all[profile]);
    return used;
}

Light ReadProfileLight(const gltf::Model& model, uint32_t node) {
    const ValueReader file(model.nodes[node].extensions, kProfileExtension);
    int profile = 0;
    file.Read("light", profile);
    Light light;
    ValueReader(model.extensions, kProfileExtension)
        .In("lights")[static_cast<size_t>(profile)]
        .Read("name", light.name);
    file.Read("multiplier", light.intensity);
    file.Read("color", light.color);
    return light;
}

std::vector<LightProfile> DecodeProfiles(GltfContext& context, const std::vector<ProfileSource>& sources,
                                         GltfBuffers& buffers) {
    std::vector<LightProfile> profiles;
    for (const ProfileSource& source : sources) profiles.push_back(Decode(context, source, buffers));
    return profiles;
}

}  // namespace raygraph::scene
