#include "renderer/scene/gltf/image_light.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "renderer/scene/formats/cube_map.h"

namespace raygraph::scene {
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
    // Four times the bytes of a texture
    const uint64_t height = EquirectHeight(size), texels = 4 * (2 * height * height);
    const uint64_t left = context.options.limits.maxAllImageTexels - context.imageTexels;
    if (texels > left)
        context.Fail(where, Text("its map takes {} texels, which exceed the {} that are left", texels, left));
    context.imageTexels += texels;
    return {light.name, size, ToEquirect(cube, context.ThreadCount())};
}

}  // namespace raygraph::scene
