// Materials of glTF and of its extensions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/h_function.h"

namespace raygraph::test::import_material_test {
namespace {

using glm::vec3;
using glm::vec4;

// A triangle with `material`.
GltfDocument WithMaterial(const Json& material) {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial(material);
    return document;
}

size_t AddTexture(GltfDocument& document, uint32_t width) {
    const size_t image = document.Add("images", {{"uri", DataUri(MakePng(width, 2, {1, 2, 3, 4}))}});
    return document.Add("textures", {{"source", image}});
}

TEST(Materials, FactorsAreRead) {
    const Json json = R"({
        "name": "paint",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.75
        },
        "emissiveFactor": [0.1, 0.2, 3],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 10}},
        "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true
    })"_json;
    const scene::Material material = Load(WithMaterial(json)).materials.at(0);
    EXPECT_EQ(material.name, "paint");
    EXPECT_EQ(material.baseColorFactor, vec4(0.1f, 0.2f, 0.3f, 0.4f));
    EXPECT_EQ(material.metallicFactor, 0.5f);
    EXPECT_EQ(material.roughnessFactor, 0.75f);
    EXPECT_EQ(material.emissiveFactor, vec3(0.1f, 0.2f, 3.0f));
    EXPECT_EQ(material.emissiveStrength, 10.0f);
    EXPECT_EQ(material.EmittedRadiance(), vec3(1.0f, 2.0f, 30.0f));
    EXPECT_EQ(material.alphaMode, scene::AlphaMode::Mask);
    EXPECT_EQ(material.alphaCutoff, 0.25f);
    EXPECT_TRUE(material.isDoubleSided);
}

TEST(Materials, DefaultsAreGltfs) {
    const scene::Material material = Load(WithMaterial(Json::object())).materials.at(0);
    EXPECT_EQ(material.baseColorFactor, vec4(1.0f));
    EXPECT_EQ(material.metallicFactor, 1.0f);
    EXPECT_EQ(material.roughnessFactor, 1.0f);
    EXPECT_EQ(material.EmittedRadiance(), vec3(0.0f));
    EXPECT_EQ(material.alphaMode, scene::AlphaMode::Opaque);
    EXPECT_EQ(material.alphaCutoff, 0.5f);
    EXPECT_FALSE(material.isDoubleSided);
    EXPECT_FALSE(material.baseColorTexture.IsPresent());
}

TEST(Materials, FactorsOutOfRangeAreClampedWithOneWarning) {
    const Json json{{"pbrMetallicRoughness", {{"metallicFactor", 2}, {"roughnessFactor", -1}}}};
    const scene::SceneData scene = Load(WithMaterial(json));
    EXPECT_EQ(scene.materials[0].metallicFactor, 1.0f);
    EXPECT_EQ(scene.materials[0].roughnessFactor, 0.0f);
    EXPECT_EQ(
        scene.warnings,
        std::vector<std::string>{"scene.gltf: materials[0].pbrMetallicRoughness.metallicFactor: is 2, out of "
                                 "range, put into it (and 1 more)"});
}

TEST(Materials, MalformedOnesAreRefused) {
    ExpectRefused(
        WithMaterial(Json::object()),
        {{"/materials/0/alphaMode", "GLASS",
          "materials[0].alphaMode: is \"GLASS\", must be OPAQUE, MASK or BLEND"},
         {"/materials/0/emissiveFactor", {1, 2}, "materials[0].emissiveFactor: has 2 elements, must have 3"},
         {"/materials/0/pbrMetallicRoughness", 1,
          "materials[0].pbrMetallicRoughness: is 1, must be an object"},
         {"/materials/0/normalTexture/index", 0,
          "materials[0].normalTexture.index: is 0, but there are 0 textures"},
         {"/materials/0/doubleSided", 1, "materials[0].doubleSided: is 1, must be true or false"}});
}

TEST(Textures, ColorsAreSrgbAndDataLinear) {
    GltfDocument document = WithMaterial(Json::object());
    const size_t first = AddTexture(document, 3);
    const size_t second = AddTexture(document, 5);
    document.json["materials"][0] = {{"pbrMetallicRoughness",
                                      {{"baseColorTexture", {{"index", first}, {"texCoord", 1}}},
                                       {"metallicRoughnessTexture", {{"index", second}}}}},
                                     {"normalTexture", {{"index", second}, {"scale", 0.5}}},
                                     {"occlusionTexture", {{"index", first}, {"strength", 0.25}}},
                                     {"emissiveTexture", {{"index", first}}}};
    const scene::SceneData scene = Load(document);
    const scene::Material& material = scene.materials[0];
    const auto texture = [&](const scene::TextureRef& ref) {
        return scene.textures.at(static_cast<size_t>(ref.texture));
    };
    EXPECT_EQ(texture(material.baseColorTexture).colorSpace, scene::ColorSpace::Srgb);
    EXPECT_EQ(texture(material.emissiveTexture).colorSpace, scene::ColorSpace::Srgb);
    EXPECT_EQ(texture(material.metallicRoughnessTexture).colorSpace, scene::ColorSpace::Linear);
    EXPECT_EQ(texture(material.normalTexture).colorSpace, scene::ColorSpace::Linear);
    EXPECT_EQ(texture(material.occlusionTexture).colorSpace, scene::ColorSpace::Linear);
    EXPECT_EQ(material.baseColorTexture.texture, material.emissiveTexture.texture);
    EXPECT_NE(material.baseColorTexture.texture, material.occlusionTexture.texture)
        << "one image, two readings";
    EXPECT_EQ(material.baseColorTexture.texCoord, 1);
    EXPECT_EQ(material.normalScale, 0.5f);
    EXPECT_EQ(material.occlusionStrength, 0.25f);
    ASSERT_EQ(scene.images.size(), 2u) << "each image is decoded once";
    EXPECT_EQ(scene.images[texture(material.baseColorTexture).image].width, 3u);
    EXPECT_EQ(scene.images[texture(material.normalTexture).image].width, 5u);
    const scene::ImageData& image = scene.images[0];
    ASSERT_EQ(image.rgba.size(), 3u * 2 * 4);
    EXPECT_EQ((std::vector<uint8_t>(image.rgba.begin(), image.rgba.begin() + 4)),
              (std::vector<uint8_t>{1, 2, 3, 4}));
}

TEST(Textures, ImagesThatNoMaterialUsesAreNotOpened) {
    GltfDocument document = WithMaterial(Json::object());
    document.Add("images", {{"uri", "not-there.png"}});
    document.Add("textures", {{"source", 0}});
    EXPECT_TRUE(Load(document).images.empty());
}

TEST(Textures, ImageFromABufferViewIsRead) {
    GltfDocument document = WithMaterial({{"emissiveTexture", {{"index", 0}}}});
    document.Add("images", {{"bufferView", document.AddBufferView(MakePng(7, 1, {9, 9, 9, 9}))},
                            {"mimeType", "image/png"},
                            {"name", "seven"}});
    document.Add("textures", {{"source", 0}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.images.size(), 1u);
    EXPECT_EQ(scene.images[0].width, 7u);
    EXPECT_EQ(scene.images[0].name, "seven");
}

TEST(Textures, LogTellsHowLongEachImageTook) {
    GltfDocument document =
        WithMaterial({{"emissiveTexture", {{"index", 0}}}, {"normalTexture", {{"index", 1}}}});
    document.Add("images", {{"bufferView", document.AddBufferView(MakePng(7, 1, {9, 9, 9, 9}))},
                            {"mimeType", "image/png"},
                            {"name", "seven"}});
    document.Add("textures", {{"source", 0}});
    AddTexture(document, 3);
    const auto said = [&](LogLevel least) {
        std::vector<std::string> lines;
        scene::LoadOptions options;
        options.log = Log(
            [&](const LogMessage& message) {
                if (message.level == LogLevel::Debug && message.category == log_category::kScene)
                    lines.emplace_back(message.text);
            },
            least);
        Load(document, options);
        return lines;
    };
    EXPECT_TRUE(said(LogLevel::Info).empty());
    std::vector<std::string> lines = said(LogLevel::Debug);
    ASSERT_EQ(lines.size(), 2u);
    std::ranges::sort(lines);  // they are decoded in the order in which the material names them
    const auto expect = [](const std::string& line, const std::string& image) {
        EXPECT_TRUE(line.starts_with("scene.gltf: " + image + " PNG of ")) << line;
        EXPECT_NE(line.find(" B decoded in "), std::string::npos) << line;
        EXPECT_TRUE(line.ends_with("s")) << line;
    };
    expect(lines[0], "images[0] \"seven\": 7 x 1");
    expect(lines[1], "images[1]: 3 x 2");
}

scene::Sampler LoadSampler(const Json& sampler) {
    GltfDocument document = WithMaterial({{"emissiveTexture", {{"index", 0}}}});
    AddTexture(document, 1);
    document.Add("samplers", sampler);
    document.json["textures"][0]["sampler"] = 0;
    return Load(document).textures.at(0).sampler;
}

TEST(Textures, SamplersAreRead) {
    const scene::Sampler sampler =
        LoadSampler({{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}, {"minFilter", 9985}});
    EXPECT_EQ(sampler.wrapU, scene::WrapMode::ClampToEdge);
    EXPECT_EQ(sampler.wrapV, scene::WrapMode::MirroredRepeat);
    EXPECT_EQ(sampler.magFilter, scene::FilterMode::Nearest);
    EXPECT_EQ(sampler.minFilter, scene::FilterMode::Linear);
    EXPECT_EQ(sampler.mipFilter, scene::FilterMode::Nearest);
    EXPECT_TRUE(sampler.usesMips);
    EXPECT_FALSE(LoadSampler({{"minFilter", 9729}}).usesMips);
    EXPECT_EQ(LoadSampler({{"wrapS", 10497}}), scene::Sampler());
}

TEST(Textures, UnknownSamplerNumbersAreRefused) {
    ExpectRefused(GltfDocument(),
                  {{"/samplers/0/wrapS", 10496, "samplers[0].wrapS: is 10496, must be 10497, 33648 or 33071"},
                   {"/samplers/0/minFilter", 1,
                    "samplers[0].minFilter: is 1, must be 9728, 9729, 9984, 9985, 9986 or 9987"},
                   {"/samplers/0/magFilter", 9984, "samplers[0].magFilter: is 9984, must be 9728 or 9729"}});
}

TEST(Textures, WebpExtensionsImageIsPreferred) {
    GltfDocument document = WithMaterial({{"emissiveTexture", {{"index", 0}}}});
    AddTexture(document, 1);
    document.Add("images", {{"uri", DataUri(MakePng(6, 1, {}))}});
    document.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
    EXPECT_EQ(Load(document).images.at(0).width, 6u);
}

TEST(Textures, TextureWithoutImageIsLeftOutWithAWarning) {
    GltfDocument document = WithMaterial({{"emissiveTexture", {{"index", 0}}}});
    document.Add("textures", Json::object());
    const scene::SceneData scene = Load(document);
    EXPECT_FALSE(scene.materials[0].emissiveTexture.IsPresent());
    EXPECT_EQ(scene.warnings,
              std::vector<std::string>{
                  "scene.gltf: materials[0].emissiveTexture: textures[0] has no image that can be "
                  "read, left out"});
}

TEST(Textures, ThirdTextureCoordinateSetIsTakenAsTheFirstWithAWarning) {
    GltfDocument document = WithMaterial({{"emissiveTexture", {{"index", 0}, {"texCoord", 2}}}});
    AddTexture(document, 1);
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.materials[0].emissiveTexture.texCoord, 0);
    EXPECT_EQ(scene.warnings.size(), 1u);
}

TEST(Textures, MalformedOnesAreRefused) {
    GltfDocument document = WithMaterial({{"emissiveTexture", {{"index", 0}}}});
    document.Add("textures", {{"source", 0}});
    EXPECT_EQ(LoadError(document), "scene.gltf: textures[0].source: is 0, but there are 0 images");
    document.Add("images", Json::object());
    ExpectRefused(document,
                  {{"/images/0", Json::object(), "images[0]: must have either a uri or a bufferView"},
                   {"/images/0/bufferView", 9, "images[0].bufferView: is 9, but there are 2 bufferViews"},
                   {"/images/0/uri", 9, "images[0].uri: is 9, must be a string"}});
}

TEST(Textures, ImageThatCannotBeDecodedIsRefusedByName) {
    GltfDocument document = WithMaterial({{"emissiveTexture", {{"index", 0}}}});
    document.Add("images", {{"uri", DataUri(ToBytes("no image"))}, {"name", "wood"}});
    document.Add("textures", {{"source", 0}});
    EXPECT_EQ(LoadError(document).find("scene.gltf: images[0] \"wood\": "), 0u) << LoadError(document);
}

TEST(Textures, ImagesBeyondTheLimitsAreRefused) {
    GltfDocument document =
        WithMaterial({{"emissiveTexture", {{"index", 0}}}, {"normalTexture", {{"index", 1}}}});
    AddTexture(document, 40);
    AddTexture(document, 50);
    scene::LoadOptions options;
    options.limits.maxImageExtent = 45;
    EXPECT_EQ(LoadError(document, options).find("scene.gltf: images[1]: 50 x 2 "), 0u)
        << LoadError(document, options);
    options.limits.maxImageExtent = 50;
    options.limits.maxAllImageTexels = 2 * 90;
    EXPECT_EQ(LoadError(document, options), "loaded");
    options.limits.maxAllImageTexels = 2 * 90 - 1;
    EXPECT_NE(LoadError(document, options), "loaded");
}

}  // namespace
}  // namespace raygraph::test::import_material_test

namespace raygraph::test::import_material_extension_test {
namespace {

using glm::vec3;

GltfDocument WithMaterial(const Json& material) {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial(material);
    return document;
}

scene::SceneData LoadExtensions(const Json& extensions) {
    return Load(WithMaterial({{"extensions", extensions}}));
}

scene::Material MaterialWith(const Json& extensions) {
    const scene::SceneData scene = LoadExtensions(extensions);
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    return scene.materials.at(0);
}

void AddTexture(GltfDocument& document, uint32_t width) {
    const size_t image = document.Add("images", {{"uri", DataUri(MakePng(width, 1, {1, 2, 3, 4}))}});
    document.Add("textures", {{"source", image}});
}

// Every property of every material extension, each with a value of its own; textures 0 to 3.
Json AllExtensions() {
    return R"({
        "KHR_materials_emissive_strength": {"emissiveStrength": 7},
        "KHR_materials_ior": {"ior": 1.25},
        "KHR_materials_specular": {"specularFactor": 0.75, "specularTexture": {"index": 0},
                                   "specularColorFactor": [0.5, 1.5, 2],
                                   "specularColorTexture": {"index": 1, "texCoord": 1}},
        "KHR_materials_transmission": {"transmissionFactor": 0.25, "transmissionTexture": {"index": 2}},
        "KHR_materials_volume": {"thicknessFactor": 0.5, "thicknessTexture": {"index": 3},
                                 "attenuationDistance": 2, "attenuationColor": [0.125, 0.25, 0.5]},
        "KHR_materials_unlit": {}
    })"_json;
}

GltfDocument WithAllExtensions() {
    GltfDocument document = WithMaterial({{"extensions", AllExtensions()}});
    for (uint32_t width = 1; width <= 4; ++width) AddTexture(document, width);
    return document;
}

TEST(MaterialExtensions, ValuesAreRead) {
    const scene::SceneData scene = Load(WithAllExtensions());
    EXPECT_TRUE(scene.warnings.empty());
    const scene::Material& material = scene.materials.at(0);
    EXPECT_EQ(material.emissiveStrength, 7.0f);
    EXPECT_EQ(material.ior, 1.25f);
    EXPECT_EQ(material.specularFactor, 0.75f);
    EXPECT_EQ(material.specularColorFactor, vec3(0.5f, 1.5f, 2.0f)) << "not bounded by 1";
    EXPECT_EQ(material.transmissionFactor, 0.25f);
    EXPECT_EQ(material.thicknessFactor, 0.5f);
    EXPECT_EQ(material.attenuationDistance, 2.0f);
    EXPECT_EQ(material.attenuationColor, vec3(0.125f, 0.25f, 0.5f));
    EXPECT_TRUE(material.isUnlit);

    const auto texture = [&](const scene::TextureRef& ref) {
        return scene.textures.at(static_cast<size_t>(ref.texture));
    };
    EXPECT_EQ(scene.images.at(texture(material.specularTexture).image).width, 1u);
    EXPECT_EQ(scene.images.at(texture(material.specularColorTexture).image).width, 2u);
    EXPECT_EQ(scene.images.at(texture(material.transmissionTexture).image).width, 3u);
    EXPECT_EQ(texture(material.specularTexture).colorSpace, scene::ColorSpace::Linear);
    EXPECT_EQ(texture(material.specularColorTexture).colorSpace, scene::ColorSpace::Srgb);
    EXPECT_EQ(texture(material.transmissionTexture).colorSpace, scene::ColorSpace::Linear);
    EXPECT_EQ(material.specularColorTexture.texCoord, 1);
}

TEST(MaterialExtensions, ThicknessTextureIsNotOpened) {
    EXPECT_EQ(Load(WithAllExtensions()).images.size(), 3u);
    GltfDocument document = WithAllExtensions();
    document.json["materials"][0]["extensions"]["KHR_materials_volume"]["thicknessTexture"]["index"] = 9;
    EXPECT_EQ(LoadError(document), "loaded");
}

TEST(MaterialExtensions, TextureOfAMediumIsCheckedAndNotReadWithAWarning) {
    GltfDocument document = WithMaterial(
        {{"extensions",
          {{"KHR_materials_volume_scatter",
            {{"multiscatterColorFactor", {0.5, 0.5, 0.5}}, {"multiscatterColorTexture", {{"index", 0}}}}}}}});
    EXPECT_THAT(LoadError(document), ::testing::HasSubstr("multiscatterColorTexture.index: is 0, but"));
    AddTexture(document, 2);
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.textures.empty());
    EXPECT_THAT(
        scene.warnings,
        ::testing::ElementsAre(::testing::HasSubstr("volume_scatter.multiscatterColorTexture: is not read")));
}

TEST(MaterialExtensions, AbsentAndEmptyOnesMeanTheDefaults) {
    const Json empty = R"({"KHR_materials_ior": {}, "KHR_materials_specular": {},
                           "KHR_materials_transmission": {}, "KHR_materials_volume": {}})"_json;
    for (const Json& extensions : {Json::object(), empty}) {
        const scene::Material material = MaterialWith(extensions);
        EXPECT_EQ(material.ior, 1.5f);
        EXPECT_EQ(material.specularFactor, 1.0f);
        EXPECT_EQ(material.specularColorFactor, vec3(1.0f));
        EXPECT_FALSE(material.specularTexture.IsPresent());
        EXPECT_FALSE(material.specularColorTexture.IsPresent());
        EXPECT_EQ(material.transmissionFactor, 0.0f);
        EXPECT_FALSE(material.transmissionTexture.IsPresent());
        EXPECT_FALSE(material.IsTransmissive());
        EXPECT_FALSE(material.BoundsMedium());
        EXPECT_EQ(material.Extinction(), vec3(0.0f));
        EXPECT_FALSE(material.isUnlit);
        EXPECT_EQ(material.priority, 0u);
    }
}

TEST(MaterialExtensions, AreAcceptedWhenTheFileRequiresThem) {
    GltfDocument document = WithAllExtensions();
    const Json extensions = AllExtensions();
    for (const auto& entry : extensions.items()) {
        document.json["extensionsRequired"].push_back(entry.key());
        document.json["extensionsUsed"].push_back(entry.key());
    }
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(MaterialExtensions, MalformedOnesAreRefused) {
    const struct {
        const char* extension;
        Json value;
        const char* message;
    } rows[] = {
        {"ior", 1.5, ": is 1.5, must be an object"},
        {"ior", {{"ior", "glass"}}, ".ior: is \"glass\", must be a number"},
        {"specular",
         {{"specularColorFactor", {1e60, 1, 1}}},
         ".specularColorFactor[0]: is 1e+60, too large for a float"},
        {"specular", {{"specularFactor", nullptr}}, ".specularFactor: is null, must be a number"},
        {"specular", {{"specularColorFactor", {1, 1}}}, ".specularColorFactor: has 2 elements, must have 3"},
        {"specular",
         {{"specularTexture", {{"index", 0}}}},
         ".specularTexture.index: is 0, but there are 0 textures"},
        {"specular",
         {{"specularColorTexture", {{"index", -1}}}},
         ".specularColorTexture.index: is -1, must be a whole number of at least 0"},
        {"transmission", {{"transmissionFactor", true}}, ".transmissionFactor: is true, must be a number"},
        {"transmission",
         {{"transmissionTexture", Json::object()}},
         ".transmissionTexture.index: is absent, must be a whole number of at least 0"},
        {"volume", {{"thicknessFactor", "1"}}, ".thicknessFactor: is \"1\", must be a number"},
        {"volume", {{"attenuationColor", "red"}}, ".attenuationColor: is \"red\", must be an array"},
        {"volume",
         {{"attenuationDistance", Json::array()}},
         ".attenuationDistance: is an array, must be a number"},
        {"unlit", true, ": is true, must be an object"},
    };
    for (const auto& [extension, value, message] : rows) {
        const std::string name = std::string("KHR_materials_") + extension;
        EXPECT_EQ(LoadError(WithMaterial({{"extensions", {{name, value}}}})),
                  "scene.gltf: materials[0].extensions." + name + message);
    }
}

TEST(MaterialExtensions, FactorsOutOfRangeAreClampedWithAWarning) {
    const auto clamped = [](const char* extension, const Json& value) {
        const scene::SceneData scene = LoadExtensions({{extension, value}});
        EXPECT_EQ(scene.warnings.size(), 1u) << value;
        return scene.materials.at(0);
    };
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", 0.5}}).ior, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", -2}}).ior, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", 1e30}}).ior, 1e4f);
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", 1e60}}).ior, 1e4f);
    EXPECT_EQ(clamped("KHR_materials_ior", {{"ior", -1e60}}).ior, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_specular", {{"specularFactor", 2}}).specularFactor, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_specular", {{"specularColorFactor", {-1, 1, 3}}}).specularColorFactor,
              vec3(0, 1, 3));
    EXPECT_EQ(clamped("KHR_materials_transmission", {{"transmissionFactor", 1.5}}).transmissionFactor, 1.0f);
    EXPECT_EQ(clamped("KHR_materials_volume", {{"thicknessFactor", -1}}).thicknessFactor, 0.0f);
    EXPECT_EQ(clamped("KHR_materials_volume", {{"attenuationColor", {0.5, 2, -1}}}).attenuationColor,
              vec3(0.5f, 1.0f, 0.0f));
    EXPECT_EQ(clamped("KHR_materials_volume", {{"attenuationDistance", 0}}).attenuationDistance, 0.0f);
    EXPECT_EQ(clamped("KHR_materials_volume", {{"attenuationDistance", -3}}).attenuationDistance, 0.0f);
}

// Exporters write these values for infinity, which JSON does not have.
TEST(MaterialExtensions, InfiniteDistanceIsNullOrTheLargestDouble) {
    for (const Json& infinite : {Json(nullptr), Json(std::numeric_limits<double>::max())}) {
        const scene::SceneData scene = LoadExtensions(
            {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
             {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", infinite}}}});
        EXPECT_EQ(scene.materials.at(0).attenuationDistance, 0.0f) << infinite;
        EXPECT_EQ(scene.materials.at(0).thicknessFactor, 1.0f) << infinite;
        ASSERT_EQ(scene.warnings.size(), 1u) << infinite;
        EXPECT_THAT(scene.warnings[0], ::testing::HasSubstr("taken as infinite")) << infinite;
    }
}

TEST(MaterialExtensions, IorZeroIsLegal) {
    EXPECT_EQ(MaterialWith({{"KHR_materials_ior", {{"ior", 0}}}}).ior, 0.0f);
}

TEST(MaterialExtensions, MediumTurnsWhiteIntoItsColorOverItsDistance) {
    const scene::Material material = MaterialWith(
        {{"KHR_materials_volume",
          {{"thicknessFactor", 1}, {"attenuationColor", {0.25, 1, 0.5}}, {"attenuationDistance", 0.1}}}});
    const vec3 passed = glm::exp(-material.Extinction() * 0.1f);
    EXPECT_NEAR(passed.x, 0.25f, 1e-6f);
    EXPECT_EQ(passed.y, 1.0f);
    EXPECT_NEAR(passed.z, 0.5f, 1e-6f);
}

TEST(MaterialExtensions, AbsorptionIsFiniteWhateverTheColorAndDistance) {
    scene::Material material;
    material.attenuationColor = vec3(0.0f, 1e-45f, 1.0f);
    for (const float distance : {1e-45f, 1e-30f, 1.0f, 1e38f}) {
        material.attenuationDistance = distance;
        const vec3 extinction = material.Extinction();
        EXPECT_EQ(extinction.x, scene::Material::kMaxExtinction) << "color 0 is black over any distance";
        EXPECT_TRUE(std::isfinite(extinction.y));
        EXPECT_EQ(extinction.z, 0.0f);
    }
    material.attenuationDistance = 0.0f;
    EXPECT_EQ(material.Extinction(), vec3(0.0f)) << "an infinite distance attenuates nothing";
}

TEST(MaterialExtensions, UnlitMaterialsHaveNoEmissionOfTheirOwn) {
    scene::Material material;
    material.emissiveFactor = vec3(1.0f);
    EXPECT_EQ(material.EmittedRadiance(), vec3(1.0f));
    material.isUnlit = true;
    EXPECT_EQ(material.EmittedRadiance(), vec3(0.0f));
}

TEST(MaterialExtensions, OnlySingleSidedSurfacesThatNoLightPassesAreCulled) {
    scene::Material material;
    EXPECT_TRUE(material.IsBackCulled());
    for (const scene::AlphaMode mode : {scene::AlphaMode::Mask, scene::AlphaMode::Blend}) {
        material.alphaMode = mode;
        EXPECT_TRUE(material.IsBackCulled());
    }
    material.isDoubleSided = true;
    EXPECT_FALSE(material.IsBackCulled());
    material = {};
    material.transmissionFactor = 0.5f;
    EXPECT_FALSE(material.IsBackCulled());
    material = {};
    material.thicknessFactor = 0.5f;
    EXPECT_TRUE(material.IsBackCulled()) << "a volume that no light enters";
    material.transmissionFactor = 0.5f;
    EXPECT_FALSE(material.IsBackCulled());
    material.transmissionFactor = 0.0f;
    EXPECT_FALSE(material.BoundsMedium());
    material.diffuseTransmissionFactor = 0.5f;
    EXPECT_FALSE(material.IsBackCulled()) << "light passes diffusely";
    EXPECT_TRUE(material.BoundsMedium());
    material.thicknessFactor = 0.0f;
    EXPECT_FALSE(material.IsBackCulled());
    EXPECT_FALSE(material.BoundsMedium());
}

TEST(MaterialPriority, IsReadFromExtras) {
    const scene::SceneData scene = Load(WithMaterial({{"extras", {{"priority", 7}, {"author", "x"}}}}));
    EXPECT_EQ(scene.materials.at(0).priority, 7u);
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(MaterialPriority, WhatOthersPutIntoExtrasRefusesNoFile) {
    for (const Json& extras : {Json(3), Json("priority"), Json::array({1}), Json(nullptr), Json::object()}) {
        const scene::SceneData scene = Load(WithMaterial({{"extras", extras}}));
        EXPECT_EQ(scene.materials.at(0).priority, 0u);
        EXPECT_TRUE(scene.warnings.empty()) << extras;
    }
    for (const Json& priority : {Json(-1), Json(0.5), Json("high"), Json(4294967296u), Json(1e300)}) {
        const scene::SceneData scene = Load(WithMaterial({{"extras", {{"priority", priority}}}}));
        EXPECT_EQ(scene.materials.at(0).priority, 0u);
        EXPECT_EQ(scene.warnings,
                  std::vector<std::string>{"scene.gltf: materials[0].extras.priority: is " +
                                           (priority.is_string() ? "\"high\"" : priority.dump()) +
                                           ", must be a whole number of 0 to 4294967295, taken as 0"});
    }
}

// The color that a file gives is about what a half space of the medium returns of light from all sides.
TEST(MaterialExtensions, MultiscatterColorIsTheAlbedoOfAHalfSpace) {
    const auto albedoOf = [](float color, float anisotropy) {
        const Json volume = {
            {"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {0.5, 0.5, 0.5}}};
        const scene::Material material = MaterialWith(
            {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
             {"KHR_materials_volume", volume},
             {"KHR_materials_volume_scatter",
              {{"multiscatterColorFactor", {color, 0, color}}, {"scatterAnisotropy", anisotropy}}}});
        EXPECT_EQ(material.Scattering().y, 0.0f);
        return double{material.Scattering().x} / double{material.Extinction().x};
    };
    for (const float color : {0.05f, 0.2f, 0.5f, 0.8f, 0.95f}) {
        const double albedo = albedoOf(color, 0.0f);
        EXPECT_NEAR(raygraph::testing::HFunction(albedo).ReflectedToAll(), color, 0.02) << color;
        // By similarity, a medium of mean cosine g with 1 / (1 - g) times the scattering coefficient looks
        // the same
        const double forward = albedoOf(color, 0.75f);
        EXPECT_NEAR(forward * 0.25 / (1.0 - 0.75 * forward), albedo, 1e-3) << color;
    }
    EXPECT_NEAR(albedoOf(1.0f, 0.0f), 1.0, 1e-4);
}

}  // namespace
}  // namespace raygraph::test::import_material_extension_test

// KHR_materials_pbrSpecularGlossiness: what it stands for, and where its values are saved.
namespace raygraph::test::import_glossiness_test {
namespace {

using scene::Material, scene::SceneData;

constexpr const char* kExtension = "KHR_materials_pbrSpecularGlossiness";

// A triangle of one material, of which this is the extension.
GltfDocument Glossy(const Json& extension) {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial({{"extensions", {{kExtension, extension}}}});
    return document;
}

// Makes a document with the extension's two textures, and two of pbrMetallicRoughness.
GltfDocument Textured() {
    GltfDocument document = Glossy(
        {{"diffuseTexture", {{"index", 0}}}, {"specularGlossinessTexture", {{"index", 1}, {"texCoord", 1}}}});
    for (uint32_t i = 0; i < 4; ++i) {
        document.Add("images", {{"uri", DataUri(MakePng(i + 1, 1, {1, 2, 3, 4}))}});
        document.Add("textures", {{"source", i}});
    }
    document.json["materials"][0]["pbrMetallicRoughness"] = {{"baseColorFactor", {0.1, 0.1, 0.1, 0.1}},
                                                             {"metallicFactor", 0.75},
                                                             {"roughnessFactor", 0.75},
                                                             {"baseColorTexture", {{"index", 2}}},
                                                             {"metallicRoughnessTexture", {{"index", 3}}}};
    return document;
}

Json Saved(const GltfDocument& document, const SceneData& edited, SceneData& saved) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", document.Text());
    const std::filesystem::path target = folder.Path() / "saved.gltf";
    scene::SaveGltf(source, edited, target);
    saved = scene::LoadGltf(target);
    const Bytes text = folder.Read(target, 1 << 20);
    const auto* begin = reinterpret_cast<const char*>(text.data());
    return Json::parse(begin, begin + text.size());
}

TEST(Glossiness, FactorsAreThoseOfTheSameMaterialSaidOtherwise) {
    const SceneData scene = Load(Glossy({{"diffuseFactor", {0.1, 0.2, 0.3, 0.4}},
                                         {"specularFactor", {0.5, 0.6, 0.7}},
                                         {"glossinessFactor", 0.75}}));
    EXPECT_TRUE(scene.warnings.empty());
    const Material& read = scene.materials.at(0);
    EXPECT_TRUE(read.isSpecularGlossiness);
    EXPECT_EQ(read.baseColorFactor, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
    EXPECT_EQ(read.specularColorFactor, glm::vec3(0.5f, 0.6f, 0.7f));
    EXPECT_EQ(read.roughnessFactor, 0.25f);
    EXPECT_EQ(read.metallicFactor, 0.0f);
    EXPECT_EQ(read.ior, 0.0f) << "it reflects all of the specular color";
    EXPECT_EQ(read.specularFactor, 1.0f);
    // The extension's defaults: white, and as smooth as can be
    const Material bare = Load(Glossy(Json::object())).materials.at(0);
    EXPECT_EQ(bare.baseColorFactor, glm::vec4(1.0f));
    EXPECT_EQ(bare.specularColorFactor, glm::vec3(1.0f));
    EXPECT_EQ(bare.roughnessFactor, 0.0f);
    EXPECT_FALSE(Material().isSpecularGlossiness);
}

TEST(Glossiness, CountsBeforeAllElseThatSaysTheSame) {
    GltfDocument document = Textured();
    SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty()) << "files have pbrMetallicRoughness for readers without";
    const Material& read = scene.materials.at(0);
    EXPECT_EQ(read.baseColorFactor, glm::vec4(1.0f));
    EXPECT_EQ(read.metallicFactor, 0.0f);
    EXPECT_EQ(read.roughnessFactor, 0.0f);
    EXPECT_FALSE(read.metallicRoughnessTexture.IsPresent());
    ASSERT_EQ(scene.textures.size(), 2u) << "no others are loaded";
    const auto texture = [&](const scene::TextureRef& of) {
        return scene.textures.at(static_cast<size_t>(of.texture));
    };
    EXPECT_EQ(scene.images.at(texture(read.baseColorTexture).image).width, 1u);
    EXPECT_EQ(scene.images.at(texture(read.specularColorTexture).image).width, 2u);
    EXPECT_EQ(texture(read.baseColorTexture).colorSpace, scene::ColorSpace::Srgb);
    EXPECT_EQ(texture(read.specularColorTexture).colorSpace, scene::ColorSpace::Srgb);
    EXPECT_EQ(read.specularColorTexture.texCoord, 1);
    document.json["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = 1.25;
    document.json["materials"][0]["extensions"]["KHR_materials_specular"] = {
        {"specularFactor", 0.5}, {"specularColorFactor", {0.5, 0.5, 0.5}}};
    document.json["materials"][0]["extensions"]["KHR_materials_clearcoat"]["clearcoatFactor"] = 0.5;
    scene = Load(document);
    EXPECT_EQ(scene.warnings,
              std::vector<std::string>{
                  "scene.gltf: materials[0].extensions.KHR_materials_ior: has no effect: the material is one "
                  "of KHR_materials_pbrSpecularGlossiness (and 1 more)"});
    EXPECT_EQ(scene.materials.at(0).ior, 0.0f);
    EXPECT_EQ(scene.materials.at(0).specularFactor, 1.0f);
    EXPECT_EQ(scene.materials.at(0).specularColorFactor, glm::vec3(1.0f));
    EXPECT_EQ(scene.materials.at(0).clearcoatFactor, 0.5f) << "which says something else";
}

TEST(Glossiness, BadValuesAreRefusedOrPutIntoTheirRange) {
    const std::string extension = "/materials/0/extensions/" + std::string(kExtension);
    const std::string at = "materials[0].extensions." + std::string(kExtension);
    const auto place = [&](const char* key) { return extension + "/" + key; };
    const std::string places[] = {place("diffuseFactor"), place("specularFactor"), place("glossinessFactor"),
                                  place("specularGlossinessTexture/index")};
    const std::string messages[] = {at + ".diffuseFactor: has 3 elements, must have 4",
                                    at + ".specularFactor[1]: is \"x\", must be a number",
                                    at + ".glossinessFactor: is true, must be a number",
                                    at + ".specularGlossinessTexture.index: is 4, but there are 4 textures"};
    ExpectRefused(Textured(), {{places[0].c_str(), {1, 1, 1}, messages[0].c_str()},
                               {places[1].c_str(), {1, "x", 1}, messages[1].c_str()},
                               {places[2].c_str(), true, messages[2].c_str()},
                               {places[3].c_str(), 4, messages[3].c_str()}});
    const SceneData scene = Load(Glossy(
        {{"diffuseFactor", {2, 0.5, 0.5, 0.5}}, {"specularFactor", {-1, 0.5, 2}}, {"glossinessFactor", 3}}));
    EXPECT_EQ(scene.materials.at(0).baseColorFactor.x, 1.0f);
    EXPECT_EQ(scene.materials.at(0).specularColorFactor, glm::vec3(0.0f, 0.5f, 1.0f));
    EXPECT_EQ(scene.materials.at(0).roughnessFactor, 0.0f);
    EXPECT_EQ(scene.warnings.size(), 1u) << "of all of them";
    // No file can contain these values
    Material material = scene.materials.at(0);
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::Check(material, "paint"); }), "accepted");
    material.specularColorFactor.y = 1.5f;
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::Check(material, "paint"); }),
              "paint: specularColorFactor is 1.5, must be 0 to 1");
}

TEST(Glossiness, EditsAreSavedInTheExtension) {
    const GltfDocument document = Textured();
    SceneData edited = Load(document);
    Material& material = edited.materials.at(0);
    material.baseColorFactor = {0.25f, 0.5f, 0.75f, 0.875f};
    material.specularColorFactor = {0.5f, 0.25f, 0.125f};
    material.roughnessFactor = 0.3f;
    material.specularColorTexture.transform.rotation = 0.5f;
    material.clearcoatFactor = 0.5f;
    SceneData saved;
    const Json json = Saved(document, edited, saved);
    ExpectSame(edited, saved);
    Json expected = document.json;
    Json& extensions = expected["materials"][0]["extensions"];
    extensions["KHR_materials_clearcoat"]["clearcoatFactor"] = 0.5;
    extensions[kExtension]["diffuseFactor"] = {0.25, 0.5, 0.75, 0.875};
    extensions[kExtension]["specularFactor"] = {0.5, 0.25, 0.125};
    extensions[kExtension]["glossinessFactor"] = 0.7;
    extensions[kExtension]["specularGlossinessTexture"]["extensions"]["KHR_texture_transform"]["rotation"] =
        0.5;
    expected["extensionsUsed"] = json["extensionsUsed"];
    EXPECT_EQ(json, expected) << "and nothing in another place";
}

// 1 - g has other digits than g.
TEST(Glossiness, RoughnessComesBackToTheBit) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", Glossy(Json::object()).Text());
    const std::filesystem::path target = folder.Path() / "saved.gltf";
    SceneData edited = scene::LoadGltf(source);
    const auto savedAs = [&](float roughness) {
        edited.materials[0].roughnessFactor = roughness;
        scene::SaveGltf(source, edited, target);
        return scene::LoadGltf(target).materials[0].roughnessFactor;
    };
    for (const float roughness : {1.0f, 0.1f, 0.3f, 1.0f / 3.0f, 0.0001f, 1e-7f, std::nextafter(1.0f, 0.0f)})
        EXPECT_EQ(savedAs(roughness), roughness);
    // Glossiness has no digits for these
    for (const float roughness : {1e-12f, std::nextafter(0.0f, 1.0f)})
        EXPECT_NEAR(savedAs(roughness), roughness, 1e-16f);
}

TEST(Glossiness, MaterialStaysOneOfTheExtension) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", Textured().Text());
    const auto refusal = [&](const auto& change) {
        SceneData edited = scene::LoadGltf(source);
        change(edited.materials[0]);
        return testing::ErrorTextOf([&] { scene::SaveGltf(source, edited, folder.Path() / "saved.gltf"); });
    };
    const std::string start = "scene.gltf: materials[0]: ";
    EXPECT_EQ(refusal([](Material& material) { material.isSpecularGlossiness = false; }),
              start + "whether it is one of KHR_materials_pbrSpecularGlossiness cannot be changed");
    EXPECT_EQ(refusal([](Material& material) { material.metallicFactor = 0.5f; }),
              start + "its metallicFactor cannot be changed, KHR_materials_pbrSpecularGlossiness has none");
    EXPECT_EQ(refusal([](Material& material) { material.ior = 1.5f; }),
              start + "its ior cannot be changed, KHR_materials_pbrSpecularGlossiness has none");
    EXPECT_EQ(refusal([](Material& material) { material.roughnessFactor = 0.5f; }), "accepted");
}

}  // namespace
}  // namespace raygraph::test::import_glossiness_test
