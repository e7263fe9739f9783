#include "tests/verify/planted_mistakes.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <string>

#include "tests/support/source_file.h"

namespace raygraph::session::test {

namespace {

using scene::SceneData;

// An environment of a bright window in a dim sky, 32 x 16 texels.
image::ImageF Window() {
    image::ImageF map{.width = 32, .height = 16, .rgba = std::vector<float>(4 * 32 * 16, 0.15f)};
    for (uint32_t y = 3; y < 8; ++y)
        for (uint32_t x = 9; x < 14; ++x)
            for (uint32_t c = 0; c < 3; ++c) map.rgba[4 * (y * 32 + x) + c] = 6.0f - float(c);
    return map;
}

// A normal map.
std::vector<uint8_t> Bumps() {
    std::vector<uint8_t> rgba(4 * 32 * 32, 255);
    for (uint32_t y = 0; y < 32; ++y)
        for (uint32_t x = 0; x < 32; ++x) {
            const double u = 2.0 * std::numbers::pi * x / 32.0, v = 2.0 * std::numbers::pi * y / 32.0;
            const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3 * std::cos(u), 0.9 * std::cos(v), 1.0));
            for (int c = 0; c < 3; ++c)
                rgba[4 * (y * 32 + x) + uint32_t(c)] =
                    static_cast<uint8_t>(std::lround(127.5 + 127.5 * normal[c]));
        }
    return rgba;
}

scene::Material& RedPlastic(SceneData& data) {
    return *std::ranges::find(data.materials, "red plastic", &scene::Material::name);
}

// Applies a curve to a picture, whose noise is then not known.
Picture Curved(Picture picture, const std::function<float(float)>& curve) {
    for (size_t i = 0; i < picture.radiance.size(); ++i)
        if (i % 4 != 3) picture.radiance[i] = curve(picture.radiance[i]);
    picture.variance.clear();
    return picture;
}

// The block casts no shadow, and is itself seen as it should be.
Picture WithoutOcclusion(const Host& host) {
    PictureSettings settings = host.settings;
    settings.paths.seed = 11;
    Session session(host.device, PlantedScene(), {.settings = settings, .aovs = {Aov::Instance}});
    session.Run({.samples = host.samples});
    const RenderFile& right = session.Result().render;
    Picture picture = host.Render(PlantedScene([](SceneData& data) {
        std::ranges::find(data.nodes, "block", &scene::Node::name)->isVisible = false;
    }));
    const SceneData scene = PlantedScene().data;
    for (size_t pixel = 0; pixel < right.instance.size(); ++pixel)
        if (right.instance[pixel] < scene.instances.size() &&
            scene.nodes[scene.instances[right.instance[pixel]].node].name == "block")
            std::copy_n(&right.radiance[4 * pixel], 4, &picture.radiance[4 * pixel]);
    return picture;
}

// Half a pixel to the left: means of four of the pixels of a picture of twice the size.
Picture Shifted(const Host& host) {
    PictureSettings twice = host.settings;
    twice.size = {2 * twice.size.width, 2 * twice.size.height};
    const Picture fine = host.Render(PlantedScene(), twice);
    Picture shifted = host.Render(PlantedScene());
    const uint32_t width = twice.size.width;
    for (uint32_t y = 0; y < host.settings.size.height; ++y)
        for (uint32_t x = 0; x < host.settings.size.width; ++x)
            for (size_t c = 0; c < 3; ++c) {
                float sum = 0.0f;
                for (uint32_t v = 0; v < 2; ++v)
                    for (uint32_t u = 0; u < 2; ++u)
                        sum +=
                            fine.radiance[4 * ((2 * y + v) * width + std::min(2 * x + u + 1, width - 1)) + c];
                shifted.radiance[4 * (y * host.settings.size.width + x) + c] = 0.25f * sum;
            }
    return shifted;
}

Picture Edited(const Host& host, const std::function<void(SceneData&)>& edit) {
    return host.Render(PlantedScene(edit));
}

}  // namespace

SceneInput PlantedScene(const std::function<void(SceneData&)>& edit) {
    SceneData data = LoadInput(raygraph::test::SourceFile("scenes/terrace.gltf")).data;
    const char* const names[] = {"sun", "spot", "lamp"};
    for (size_t i = 0; i < data.lights.size(); ++i) data.lights[i].name = names[i];
    data.images.push_back({.name = "bumps", .width = 32, .height = 32, .rgba = Bumps()});
    data.textures.push_back({.name = "bumps", .image = 0});
    scene::Material floor = data.materials[0];
    floor.name = "tiles";
    floor.normalTexture.texture = 0;
    data.materials.push_back(floor);
    scene::Primitive& ground = data.meshes[0].primitives[0];
    ground.material = static_cast<uint32_t>(data.materials.size() - 1);
    for (const glm::vec3& position : ground.positions) {
        ground.uv0.emplace_back(2.0f * position.x, 2.0f * position.z);
        ground.tangents.emplace_back(1.0f, 0.0f, 0.0f, -1.0f);
    }
    if (edit) edit(data);
    SceneInput input = MakeInput(std::move(data), "terrace");
    SetEnvironment(input, Window(), "window");
    return input;
}

Picture Host::Render(SceneInput input, const PictureSettings& changed) const {
    PictureSettings own = changed;
    own.paths.seed = 11;
    Session session(device, std::move(input), {.settings = own});
    session.Run({.samples = samples});
    return PictureOf(session.Result().render, "host");
}

bool PlantedMistake::IsNamedBy(const Diagnosis& diagnosis) const {
    if (diagnosis.hypotheses.empty()) return false;
    const Hypothesis& best = diagnosis.hypotheses.front();
    return (*kind == 0 || best.kind == kind) &&
           (*name == 0 || ("|" + std::string(name) + "|").find("|" + best.name + "|") != std::string::npos);
}

const std::vector<PlantedMistake>& PlantedMistakes() {
    static const std::vector<PlantedMistake> all{
        {"missing light",
         [](const Host& host) {
             return Edited(host, [](SceneData& data) { data.lights[1].intensity = 0.0f; });
         },
         "light group", "spot"},
        {"doubled albedo",
         [](const Host& host) {
             return Edited(host, [](SceneData& data) {
                 glm::vec4& color = RedPlastic(data).baseColorFactor;
                 color = {2.0f * color.x, 2.0f * color.y, 2.0f * color.z, 1.0f};
             });
         },
         "", "red plastic|ball"},
        {"gamma twice",
         [](const Host& host) {
             return Curved(host.Render(PlantedScene()), [](float x) { return Transfer().Encode(x); });
         },
         "gamma", ""},
        {"flipped normal map",
         [](const Host& host) {
             return Edited(host, [](SceneData& data) {
                 for (size_t i = 1; i < data.images[0].rgba.size(); i += 4)
                     data.images[0].rgba[i] = static_cast<uint8_t>(255 - data.images[0].rgba[i]);
             });
         },
         "", "tiles|floor"},
        {"missing occlusion of an object", WithoutOcclusion, "occlusion", "block"},
        {"wrong exposure",
         [](const Host& host) {
             return Curved(host.Render(PlantedScene()), [](float x) { return 1.4f * x; });
         },
         "exposure", ""},
        {"turned environment",
         [](const Host& host) {
             PictureSettings settings = host.settings;
             settings.environmentRotation = 70.0f;
             return host.Render(PlantedScene(), settings);
         },
         "environment rotation", "environment"},
        {"metallic and roughness swapped",
         [](const Host& host) {
             return Edited(host, [](SceneData& data) {
                 std::swap(RedPlastic(data).metallicFactor, RedPlastic(data).roughnessFactor);
             });
         },
         "", "red plastic|ball"},
        {"missing bounce",
         [](const Host& host) {
             PictureSettings settings = host.settings;
             settings.paths.biases.maxDepth = 1;
             return host.Render(PlantedScene(), settings);
         },
         "path", "indirect"},
        {"shift of half a pixel", Shifted, "shift", ""},
    };
    return all;
}

}  // namespace raygraph::session::test
