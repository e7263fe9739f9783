// Extensions of textures that name another file of the same picture.
#include <gtest/gtest.h>

#include "renderer/scene/save_gltf.h"
#include "tests/image/texture_files.h"
#include "tests/scene/gltf_document.h"

namespace raygraph::test {
namespace {

namespace fs = std::filesystem;

constexpr std::array<uint8_t, 4> kColor{10, 20, 30, 40};

// The smallest lossless WebP of one color: its four codes have a single symbol each (WebP Lossless Bitstream
// Specification).
Bytes MakeWebp(uint32_t width, uint32_t height, const std::array<uint8_t, 4>& color) {
    std::vector<uint8_t> bits;
    size_t bitCount = 0;
    const auto put = [&](uint32_t value, unsigned count) {
        for (unsigned i = 0; i < count; ++i, ++bitCount) {
            if (bitCount % 8 == 0) bits.push_back(0);
            bits.back() = static_cast<uint8_t>(bits.back() | (value >> i & 1) << bitCount % 8);
        }
    };
    put(0x2F, 8);
    put(width - 1, 14);
    put(height - 1, 14);
    put(1, 1);  // Has alpha
    put(0, 3);  // Version
    put(0, 1);  // No transform, no color cache, no other codes
    put(0, 1);
    put(0, 1);
    for (const uint8_t symbol : {color[1], color[0], color[2], color[3], uint8_t{0}}) {
        put(1, 1);  // Simple code
        put(0, 1);  // One symbol
        put(1, 1);  // Of eight bits
        put(symbol, 8);
    }
    Bytes bytes = ToBytes("RIFF");
    const size_t padded = bits.size() + bits.size() % 2;
    PutNumber(bytes, 12 + padded);
    const Bytes names = ToBytes("WEBPVP8L");
    bytes.insert(bytes.end(), names.begin(), names.end());
    PutNumber(bytes, bits.size());
    PutBytes(bytes, bits);
    bytes.resize(20 + padded);
    return bytes;
}

struct Kind {
    const char* extension;
    const char* file;
    Bytes bytes;  // 8 x 4 texels of kColor.
};

std::vector<Kind> Kinds() {
    return {{"EXT_texture_webp", "a.webp", MakeWebp(8, 4, kColor)},
            {"MSFT_texture_dds", "a.dds", MakePlainDds(8, 4, kColor)}};
}

// A triangle with a texture whose `source` is a PNG of 2 x 2 texels, if it has one.
GltfDocument WithTexture(bool hasSource) {
    GltfDocument document;
    document.AddTriangle()["material"] =
        document.AddMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    document.Add("images", {{"uri", DataUri(MakePng(2, 2, {}))}});
    document.Add("textures", hasSource ? Json{{"source", 0}} : Json::object());
    return document;
}

void AddKind(GltfDocument& document, const Kind& kind, const std::string& uri) {
    const size_t image = document.Add("images", {{"uri", uri}});
    document.json["textures"][0]["extensions"][kind.extension] = {{"source", image}};
    document.json["extensionsUsed"].push_back(kind.extension);
}

TEST(TextureExtensions, ImageOfTheExtensionIsReadAndRequiredOnesLoad) {
    for (const Kind& kind : Kinds()) {
        SCOPED_TRACE(kind.extension);
        for (const bool isRequired : {false, true}) {
            GltfDocument document = WithTexture(!isRequired);
            AddKind(document, kind, DataUri(kind.bytes));
            if (isRequired) document.json["extensionsRequired"] = {kind.extension};
            const scene::SceneData scene = Load(document);
            EXPECT_TRUE(scene.warnings.empty());
            ASSERT_EQ(scene.images.size(), 1u);
            EXPECT_EQ(scene.images[0].width, 8u);
            EXPECT_EQ(scene.images[0].height, 4u);
            ASSERT_EQ(scene.images[0].rgba.size(), 4u * 8 * 4);
            for (size_t i = 0; i < scene.images[0].rgba.size(); ++i)
                ASSERT_EQ(scene.images[0].rgba[i], kColor[i % 4]) << i;
        }
    }
}

TEST(TextureExtensions, IndicesOutOfRangeAreRefused) {
    for (const Kind& kind : Kinds()) {
        GltfDocument document = WithTexture(true);
        document.json["textures"][0]["extensions"][kind.extension] = {{"source", 7}};
        EXPECT_EQ(LoadError(document), std::string("scene.gltf: textures[0].extensions.") + kind.extension +
                                           ".source: is 7, but there are 1 images");
    }
}

// Each of them has another width; the first in this order is read.
TEST(TextureExtensions, OfSeveralTheOneThatLostLeastIsRead) {
    const std::vector<std::pair<const char*, Bytes>> order{
        {"EXT_texture_webp", MakeWebp(11, 1, kColor)},
        {"MSFT_texture_dds", MakePlainDds(12, 1, kColor)},
    };
    for (size_t first = 0; first < order.size(); ++first) {
        GltfDocument document = WithTexture(true);
        for (size_t i = order.size(); i-- > first;)
            AddKind(document, {order[i].first, "", {}}, DataUri(order[i].second));
        EXPECT_EQ(Load(document).images.at(0).width, 11 + first) << order[first].first;
    }
}

TEST(TextureExtensions, FilesAreSavedAlong) {
    for (const Kind& kind : Kinds()) {
        SCOPED_TRACE(kind.extension);
        SceneFolder folder;
        folder.Write(kind.file, kind.bytes);
        GltfDocument document = WithTexture(true);
        AddKind(document, kind, kind.file);
        const fs::path source = folder.Write("scene.gltf", document.Text());
        const TemporaryFolder target;
        scene::SaveGltf(source, scene::LoadGltf(source), target / "saved.gltf");
        const scene::SceneData saved = scene::LoadGltf(target / "saved.gltf");
        ASSERT_EQ(saved.images.size(), 1u);
        EXPECT_EQ(saved.images[0].width, 8u);
    }
}

}  // namespace
}  // namespace raygraph::test
