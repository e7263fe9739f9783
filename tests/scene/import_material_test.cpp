#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/scene/gltf_document.h"

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
