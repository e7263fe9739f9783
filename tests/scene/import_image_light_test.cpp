// EXT_lights_image_based: the environment that a scene brings along.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <random>

#include "renderer/scene/formats/cube_map.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/gltf_document.h"

namespace raygraph::test::import_image_light_test {
namespace {

using glm::dvec3;
using glm::vec3;
using ::testing::HasSubstr;

// The sides as the extension has them: an image is seen from inside, not mirrored.
struct Side {
    vec3 center, right, top;
};
constexpr std::array<Side, 6> kSides{{{{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
                                      {{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}},
                                      {{0, 1, 0}, {-1, 0, 0}, {0, 0, -1}},
                                      {{0, -1, 0}, {-1, 0, 0}, {0, 0, 1}},
                                      {{0, 0, 1}, {-1, 0, 0}, {0, 1, 0}},
                                      {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}}}};

Json WithFaces(const Json& faces) {
    return {{"irradianceCoefficients", Json(9, Json{0.5, 0.25, 0})},
            {"specularImageSize", 2},
            {"specularImages", Json::array({faces})}};
}

// A document with these pictures as the six faces of its scene's light.
GltfDocument WithLight(const std::vector<Bytes>& pngs) {
    GltfDocument document;
    document.AddTriangle();
    for (const Bytes& png : pngs) document.Add("images", {{"uri", DataUri(png)}});
    Json faces = Json::array();
    for (size_t i = 0; i < 6; ++i) faces.push_back(std::min(i, pngs.size() - 1));
    document.json["extensionsUsed"] = {"EXT_lights_image_based"};
    document.json["extensions"]["EXT_lights_image_based"]["lights"] = Json::array({WithFaces(faces)});
    document.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
    return document;
}

Json& LightOf(GltfDocument& document) {
    return document.json["extensions"]["EXT_lights_image_based"]["lights"][0];
}

// The texel in a direction.
vec3 At(const image::ImageF& map, const vec3& direction) {
    const double u = std::atan2(direction.z, direction.x) / glm::two_pi<double>() + 0.5;
    const double v =
        std::acos(glm::clamp(direction.y / glm::length(direction), -1.0f, 1.0f)) / glm::pi<double>();
    const auto column = std::min(static_cast<uint32_t>(u * map.width), map.width - 1);
    const auto row = std::min(static_cast<uint32_t>(v * map.height), map.height - 1);
    const float* texel = &map.rgba[4 * (size_t{row} * map.width + column)];
    EXPECT_EQ(texel[3], 1.0f);
    return {texel[0], texel[1], texel[2]};
}

// Mean radiance over the sphere and its first moments.
struct Moments {
    dvec3 mean{0.0};
    std::array<dvec3, 3> first{};

    void Add(const dvec3& radiance, const dvec3& integral) {
        for (int axis = 0; axis < 3; ++axis)
            first[static_cast<size_t>(axis)] += radiance * integral[axis] / (4.0 * glm::pi<double>());
    }
};

// Returns the moments of the map's texels; with `own` below 1, of the interpolated map, of which a cell takes
// `own` of each axis from its texel, and the rest from both neighbors.
Moments MomentsOf(const image::ImageF& map, double own = 1.0) {
    Moments moments;
    const auto texel = [&](uint32_t x, int64_t y) {
        y = std::clamp<int64_t>(y, 0, map.height - 1);
        const float* rgb = &map.rgba[4 * (static_cast<size_t>(y) * map.width + x % map.width)];
        return dvec3(rgb[0], rgb[1], rgb[2]);
    };
    const double turn = glm::two_pi<double>() / map.width;
    for (uint32_t y = 0; y < map.height; ++y) {
        const double theta0 = glm::pi<double>() * y / map.height,
                     theta1 = glm::pi<double>() * (y + 1) / map.height;
        const double height = std::cos(theta0) - std::cos(theta1);
        // Integrals over theta of sin^2 and of sin cos
        const double across = 0.5 * (theta1 - theta0) - 0.25 * (std::sin(2 * theta1) - std::sin(2 * theta0));
        const double up = 0.5 * (std::pow(std::sin(theta1), 2) - std::pow(std::sin(theta0), 2));
        for (uint32_t x = 0; x < map.width; ++x) {
            dvec3 radiance(0.0);
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i)
                    radiance += (i == 0 ? own : 0.5 - 0.5 * own) * (j == 0 ? own : 0.5 - 0.5 * own) *
                                texel(x + map.width + static_cast<uint32_t>(i), int64_t{y} + j);
            const double phi = turn * (x + 0.5) - glm::pi<double>();
            const double chord = 2.0 * std::sin(0.5 * turn);
            moments.mean += radiance * height * turn / (4.0 * glm::pi<double>());
            moments.Add(radiance,
                        {std::cos(phi) * chord * across, up * turn, std::sin(phi) * chord * across});
        }
    }
    return moments;
}

// A cube of RGBD texels; the exact integrals over them.
struct Cube {
    std::array<scene::ImageData, 6> faces;

    explicit Cube(uint32_t size) {
        for (scene::ImageData& face : faces)
            face = {"", size, size, std::vector<uint8_t>(size_t{4} * size * size)};
    }
    scene::CubeMap Map() const {
        scene::CubeMap map;
        for (size_t i = 0; i < 6; ++i) map.faces[i] = &faces[i];
        return map;
    }
    uint8_t* Texel(size_t face, uint32_t x, uint32_t y) {
        return &faces[face].rgba[4 * (size_t{y} * faces[face].width + x)];
    }
    // Integrates over parts of each texel by quadrature, with 2 x 2 Gauss-Legendre points in each.
    Moments Exact() const {
        Moments moments;
        const uint32_t size = faces[0].width, parts = 2 + 32 / size, fine = parts * size;
        for (size_t face = 0; face < 6; ++face)
            for (uint32_t y = 0; y < fine; ++y)
                for (uint32_t x = 0; x < fine; ++x) {
                    const size_t texel = size_t{y / parts} * size + x / parts;
                    const dvec3 radiance = scene::FaceRadiance(&faces[face].rgba[4 * texel]);
                    for (const double i : {-0.5773502691896258, 0.5773502691896258})
                        for (const double j : {-0.5773502691896258, 0.5773502691896258}) {
                            const double s = (2.0 * x + 1.0 + i) / fine - 1.0;
                            const double t = (2.0 * y + 1.0 + j) / fine - 1.0;
                            const Side& side = kSides[face];
                            const dvec3 d = dvec3(side.center) + s * dvec3(side.right) - t * dvec3(side.top);
                            const double angle = 1.0 / (1.0 * fine * fine * std::pow(glm::length(d), 3.0));
                            moments.mean += radiance * angle / (4.0 * glm::pi<double>());
                            moments.Add(radiance, glm::normalize(d) * angle);
                        }
                }
        return moments;
    }
};

void ExpectSame(const Moments& seen, const Moments& exact, double tolerance, double firstTolerance) {
    const double scale = std::max({exact.mean.x, exact.mean.y, exact.mean.z});
    EXPECT_LT(glm::distance(seen.mean, exact.mean) / scale, tolerance);
    for (size_t axis = 0; axis < 3; ++axis)
        EXPECT_LT(glm::distance(seen.first[axis], exact.first[axis]) / scale, firstTolerance) << axis;
}

TEST(ImageLights, EachQuarterOfEachFaceIsWhereItBelongs) {
    std::vector<Bytes> pngs;
    const auto color = [](size_t face, int x, int y) {
        return std::array<uint8_t, 4>{static_cast<uint8_t>(40 * face + 10),
                                      static_cast<uint8_t>(100 + 100 * x), static_cast<uint8_t>(50 + 100 * y),
                                      255};
    };
    for (size_t face = 0; face < 6; ++face) {
        std::vector<uint8_t> texels;
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 2; ++x)
                for (const uint8_t value : color(face, x, y)) texels.push_back(value);
        pngs.push_back(MakePngOf(2, 2, texels));
    }
    const glm::quat turn = glm::normalize(glm::quat(0.8f, 0.1f, -0.5f, 0.3f));
    for (const glm::quat& rotation : {glm::quat(1, 0, 0, 0), turn}) {
        GltfDocument document = WithLight(pngs);
        LightOf(document)["name"] = "sky";
        LightOf(document)["intensity"] = 3;
        LightOf(document)["rotation"] = {rotation.x, rotation.y, rotation.z, rotation.w};
        const scene::EnvironmentLight light = Load(document).environment;
        EXPECT_EQ(light.name, "sky");
        EXPECT_EQ(light.faceSize, 2u);
        ASSERT_TRUE(light.IsPresent());
        for (size_t face = 0; face < 6; ++face)
            for (int y = 0; y < 2; ++y)
                for (int x = 0; x < 2; ++x) {
                    const Side& side = kSides[face];
                    const vec3 local = side.center + (static_cast<float>(x) - 0.5f) * side.right +
                                       (0.5f - static_cast<float>(y)) * side.top;
                    const auto texel = color(face, x, y);
                    const vec3 expected = 3.0f * scene::FaceRadiance(texel.data());
                    EXPECT_LT(glm::distance(At(light.map, rotation * local), expected), 1e-5f)
                        << "face " << face << ", " << x << ' ' << y;
                }
    }
}

TEST(ImageLights, RgbIsSrgbAndDividedByAlpha) {
    struct Value {
        std::array<uint8_t, 4> rgba;
        float red;
    };
    // 0.21586 is the sRGB curve at 128 / 255; alpha 0 counts as 1 / 255
    for (const Value& value : {Value{{255, 255, 255, 255}, 1.0f}, Value{{128, 0, 0, 255}, 0.21586f},
                               Value{{128, 0, 0, 51}, 5.0f * 0.21586f}, Value{{255, 0, 0, 1}, 255.0f},
                               Value{{255, 0, 0, 0}, 255.0f}, Value{{0, 0, 0, 0}, 0.0f}}) {
        const scene::SceneData scene = Load(WithLight({MakePng(1, 1, value.rgba)}));
        for (const vec3& direction : {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0.3f, -0.8f, 0.5f)})
            EXPECT_NEAR(At(scene.environment.map, direction).x, value.red, 1e-5f * value.red + 1e-12f);
        // One that differs is said to, and the images' size counts
        ASSERT_EQ(scene.warnings.size(), 1u);
        EXPECT_THAT(scene.warnings[0],
                    HasSubstr("specularImageSize: is 2, but the images are 1 x 1; ignored"));
    }
}

TEST(ImageLights, MeanRadianceAndFirstMomentsStay) {
    for (const uint32_t size : {1u, 7u, 64u}) {
        SCOPED_TRACE(size);
        std::mt19937 random(size);
        Cube cube(size);
        for (scene::ImageData& face : cube.faces)
            for (uint8_t& value : face.rgba) value = static_cast<uint8_t>(random() % 255 + 1);
        const image::ImageF map = scene::ToEquirect(cube.Map(), 1);
        ExpectSame(MomentsOf(map), cube.Exact(), 1e-4, 1e-4);
        ExpectSame(MomentsOf(map, 0.75), cube.Exact(), 1e-3, 1e-3);  // interpolated
        scene::CubeMap turned = cube.Map();
        turned.rotation = glm::normalize(glm::quat(0.9f, 0.3f, 0.2f, 0.5f));
        EXPECT_LT(glm::distance(MomentsOf(scene::ToEquirect(turned, 1)).mean, cube.Exact().mean),
                  1e-3 * cube.Exact().mean.x);
    }
}

// The sun is a single texel: near a corner of the cube, on the seam of the map, at and beside a pole.
TEST(ImageLights, LoneTexelLosesNoLight) {
    constexpr uint32_t kSize = 32;
    struct Spot {
        size_t face;
        uint32_t x, y;
    };
    for (const Spot& spot : {Spot{0, 3, 9}, Spot{0, 0, 0}, Spot{4, 31, 31}, Spot{1, 15, 16}, Spot{1, 16, 16},
                             Spot{2, 16, 16}, Spot{2, 15, 16}, Spot{3, 16, 3}, Spot{3, 12, 18}}) {
        SCOPED_TRACE(::testing::Message() << spot.face << ": " << spot.x << ' ' << spot.y);
        Cube cube(kSize);
        const std::array<uint8_t, 4> sun{255, 200, 100, 1};
        std::ranges::copy(sun, cube.Texel(spot.face, spot.x, spot.y));
        // The sun lies at the positions of the map's texels
        ExpectSame(MomentsOf(scene::ToEquirect(cube.Map(), 1)), cube.Exact(), 3e-4, 2e-3);
    }
}

TEST(ImageLights, WhiteCubeIsWhiteEverywhereWhateverItsSizeAndTurn) {
    for (const uint32_t size : {1u, 2u, 3u, 16u, 65u})
        for (const glm::quat& rotation : {glm::quat(1, 0, 0, 0), glm::normalize(glm::quat(1, 1, 0, 0)),
                                          glm::normalize(glm::quat(3, 1, 2, 0))}) {
            Cube cube(size);
            for (scene::ImageData& face : cube.faces) std::ranges::fill(face.rgba, uint8_t{255});
            scene::CubeMap map = cube.Map();
            map.rotation = rotation;
            const image::ImageF equirect = scene::ToEquirect(map, 1);
            const auto [least, most] = std::ranges::minmax(equirect.rgba);
            EXPECT_NEAR(least, 1.0f, 1e-5f) << size;
            EXPECT_NEAR(most, 1.0f, 1e-5f) << size;
        }
}

// The map has several bands.
TEST(ImageLights, MapIsTheSameForAnyNumberOfThreads) {
    Cube cube(300);
    std::mt19937 random(1);
    for (scene::ImageData& face : cube.faces)
        for (uint8_t& value : face.rgba) value = static_cast<uint8_t>(random());
    scene::CubeMap map = cube.Map();
    map.rotation = glm::normalize(glm::quat(0.9f, 0.3f, 0.2f, 0.5f));
    const image::ImageF one = scene::ToEquirect(map, 1);
    EXPECT_EQ(one.height, 600u);
    EXPECT_TRUE(one.rgba == scene::ToEquirect(map, 3).rgba);
}

// These are 4 and 13 bands. The map is rotated, so that a row of a face reaches into many of them.
TEST(ImageLights, TimeGrowsWithTheTexelsNotWithTheirRowsTimesBands) {
    uint64_t drawn[2]{};
    for (const uint32_t size : {512u, 1024u}) {
        const Cube black(size);
        scene::CubeMap map = black.Map();
        map.rotation = glm::normalize(glm::quat(0.9f, 0.3f, 0.2f, 0.5f));
        scene::ToEquirect(map, 1, &drawn[size / 1024]);
        EXPECT_GE(drawn[size / 1024], uint64_t{6} * size * size);
        EXPECT_LT(drawn[size / 1024], uint64_t{9} * size * size) << size;
    }
    EXPECT_LT(static_cast<double>(drawn[1]), 4.5 * static_cast<double>(drawn[0]));
}

TEST(ImageLights, LoneTexelLosesNoLightWhenItsFaceIsMadeSmaller) {
    constexpr uint32_t kSize = 200, kSmall = 64;
    constexpr double kRatio = static_cast<double>(kSize) / kSmall;
    const auto solidAngle = [](uint32_t size, uint32_t column, uint32_t row) {
        const auto corner = [&](uint32_t x, uint32_t y) {
            const double s = 2.0 * x / size - 1.0, t = 2.0 * y / size - 1.0;
            return std::atan(s * t / std::sqrt(1.0 + s * s + t * t));
        };
        return corner(column + 1, row + 1) - corner(column, row + 1) - corner(column + 1, row) +
               corner(column, row);
    };
    // Within a texel of the small face, across the border of two, in corners
    for (const auto& [x, y] : {std::array{151u, 9u}, {3u, 100u}, {6u, 9u}, {0u, 0u}, {199u, 0u}}) {
        SCOPED_TRACE(::testing::Message() << x << ' ' << y);
        Cube cube(kSize);
        std::ranges::copy(std::array<uint8_t, 4>{255, 200, 100, 1}, cube.Texel(0, x, y));
        dvec3 light(0.0);
        double columns = 0.0, rows = 0.0;
        for (uint32_t row = 0; row < kSmall; ++row)
            for (uint32_t column = 0; column < kSmall; ++column) {
                const dvec3 part = dvec3(scene::MeanRadiance(cube.faces[0], kSmall, column, row)) *
                                   solidAngle(kSmall, column, row);
                light += part;
                columns += part.x * (column + 0.5);
                rows += part.x * (row + 0.5);
            }
        const dvec3 sun = scene::FaceRadiance(cube.Texel(0, x, y));
        EXPECT_LT(glm::distance(light / (sun * solidAngle(kSize, x, y)), dvec3(1.0)), 2e-4);
        EXPECT_NEAR(columns / light.x, (x + 0.5) / kRatio, 0.5);
        EXPECT_NEAR(rows / light.x, (y + 0.5) / kRatio, 0.5);
    }
}

TEST(ImageLights, IsThatOfTheLoadedScene) {
    GltfDocument document = WithLight({MakePng(1, 1, {255, 0, 0, 255})});
    document.Add("images", {{"uri", DataUri(MakePng(1, 1, {0, 255, 0, 255}))}});
    Json second = WithFaces(Json(6, 1));
    second["name"] = "green";
    document.json["extensions"]["EXT_lights_image_based"]["lights"].push_back(second);
    document.Add("scenes", {{"name", "dark"}, {"nodes", {0}}});
    document.Add(
        "scenes",
        {{"name", "other"}, {"nodes", {0}}, {"extensions", {{"EXT_lights_image_based", {{"light", 1}}}}}});
    EXPECT_EQ(At(Load(document).environment.map, {0, 0, 1}), vec3(1, 0, 0));
    scene::LoadOptions options;
    options.scene = "dark";
    EXPECT_FALSE(Load(document, options).environment.IsPresent());
    options.scene = "other";
    const scene::EnvironmentLight light = Load(document, options).environment;
    EXPECT_EQ(At(light.map, {0, 0, 1}), vec3(0, 1, 0));
    EXPECT_EQ(light.name, "green");
}

TEST(ImageLights, OnlyTheFirstLevelIsOpenedAndEachImageOnce) {
    SceneFolder folder;
    folder.Write("a.png", MakePng(4, 4, {255, 255, 255, 255}));
    GltfDocument document = WithLight({MakePng(1, 1, {0, 0, 0, 255})});
    document.json["images"] = Json::array({{{"uri", "a.png"}}, {{"uri", "missing.png"}}});
    LightOf(document)["specularImageSize"] = 4;
    LightOf(document)["specularImages"] = Json::array({Json(6, 0), Json(6, 1)});
    const scene::SceneData scene = folder.Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(std::ranges::count(folder.reads, folder.Path() / "a.png"), 1);
    EXPECT_EQ(scene.images.size(), 0u) << "no texture uses them";
    EXPECT_EQ(scene::Statistics(scene).imageBytes, 16u * 256 * 128);
}

TEST(ImageLights, MalformedOnesAreRefused) {
    const std::string light = "extensions.EXT_lights_image_based.lights[0]";
    GltfDocument document = WithLight({MakePng(2, 2, {1, 2, 3, 255})});
    document.Add("images", {{"uri", DataUri(MakePng(2, 1, {1, 2, 3, 255}))}});
    document.Add("images", {{"uri", DataUri(MakePng(4, 4, {1, 2, 3, 255}))}});
    const std::string pointer = "/extensions/EXT_lights_image_based/lights/0";
    const auto expect = [&](const std::string& where, const Json& value, const std::string& message) {
        const std::string place = pointer + where, text = light + message;
        ExpectRefused(document, {{place.c_str(), value, text.c_str()}});
    };
    expect("/specularImages/0/3", 1, ".specularImages[0][3]: images[1] is 2 x 1, must be square");
    expect("/specularImages/0/5", 2, ".specularImages[0][5]: images[2] is 4 x 4, the face before it 2 x 2");
    expect("/specularImages/0/5", 3, ".specularImages[0][5]: is 3, but there are 3 images");
    expect("/specularImages/0", {0, 0, 0, 0, 0}, ".specularImages[0]: has 5 elements, must have 6");
    expect("/specularImages", Json::array(), ".specularImages: has no elements, must have at least one");
    expect("/specularImages", {1}, ".specularImages[0]: is 1, must be an array");
    expect("/specularImages", nullptr, ".specularImages: is null, must be an array");
    expect("/rotation", {0, 0, 0, 0}, ".rotation: is a quaternion of length 0");
    expect("/rotation", {0, 0, 1}, ".rotation: has 3 elements, must have 4");
    ExpectRefused(document,
                  {{"/scenes/0/extensions/EXT_lights_image_based/light", 1,
                    "scenes[0].extensions.EXT_lights_image_based.light: is 1, but there is 1 light"}});
    document.json["extensions"].erase("EXT_lights_image_based");
    EXPECT_EQ(LoadError(document),
              "scene.gltf: scenes[0].extensions.EXT_lights_image_based.light: is 0, but there are 0 lights");
}

TEST(ImageLights, IntensityIsFiniteLightOrPutIntoRange) {
    GltfDocument document = WithLight({MakePng(1, 1, {255, 255, 255, 1})});
    LightOf(document)["specularImageSize"] = 1;
    LightOf(document)["intensity"] = 3e38;
    EXPECT_EQ(LoadError(document), "scene.gltf: environment: its radiance must be finite and not negative");
    LightOf(document)["intensity"] = -2;
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_THAT(scene.warnings[0], HasSubstr("intensity: is -2, out of range, put into it"));
    EXPECT_EQ(At(scene.environment.map, {1, 0, 0}), vec3(0.0f));
}

TEST(ImageLights, MapCountsAgainstTheLimitOfImages) {
    scene::LoadOptions options;
    options.limits.maxAllImageTexels = 4 * 256 * 128;  // the map alone
    const GltfDocument document = WithLight({MakePng(2, 2, {1, 2, 3, 255})});
    EXPECT_EQ(
        LoadError(document, options),
        "scene.gltf: extensions.EXT_lights_image_based.lights[0]: its map takes 131072 texels, which exceed "
        "the 131068 that are left");
    options.limits.maxAllImageTexels += 4;
    EXPECT_EQ(LoadError(document, options), "loaded");
}

TEST(ImageLights, SavingKeepsThemAndTheirFaces) {
    SceneFolder from;
    from.Write("a.png", MakePng(2, 2, {9, 8, 7, 255}));
    GltfDocument document = WithLight({MakePng(1, 1, {0, 0, 0, 255})});
    document.json["images"][0] = {{"uri", "a.png"}};
    const std::filesystem::path source = from.Write("scene.gltf", document.Text());
    const TemporaryFolder to;
    scene::SceneData edited = scene::LoadGltf(source);
    edited.nodes[0].translation = {1, 2, 3};
    scene::SaveGltf(source, edited, to.Path() / "saved.gltf");
    const scene::EnvironmentLight saved = scene::LoadGltf(to.Path() / "saved.gltf").environment;
    EXPECT_EQ(saved.map.rgba, edited.environment.map.rgba);
    std::filesystem::remove(from.Path() / "a.png");
    EXPECT_THROW(scene::SaveGltf(source, edited, to.Path() / "again/saved.gltf"), Error);
}

}  // namespace
}  // namespace raygraph::test::import_image_light_test
