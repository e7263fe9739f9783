// Extensions of textures that name another file of the same picture.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/scene/gltf/save_gltf.h"
#include "tests/image/basis_files.h"
#include "tests/scene/gltf_document.h"

namespace raygraph::test::import_texture_test {
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
        put(1, 1);  // It has eight bits
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
    Bytes bytes;  // 8 x 4 texels of the color.
    std::array<uint8_t, 4> color;
};

// UASTC's blocks of one color: a mode of 5 bits, and RGBA.
Bytes MakeUastc(uint32_t width, uint32_t height, const std::array<uint8_t, 4>& color) {
    Bytes level;
    for (uint32_t i = 0; i < (width + 3) / 4 * ((height + 3) / 4); ++i) {
        uint64_t bits = 0x17;
        for (unsigned c = 0; c < 4; ++c) bits |= uint64_t{color[c]} << (5 + 8 * c);
        PutNumber(level, bits, 8);
        PutNumber(level, 0, 8);
    }
    return MakeKtx2({.width = width, .height = height, .model = kUastc, .channels = {3}}, level);
}

// Colors of ETC1S have 5 bits and a modifier: 8 is 66 - 8, 58; and so on.
constexpr std::array<uint8_t, 4> kEtc1sColor{58, 8, 124, 25};
Bytes MakeEtc1s(uint32_t width, uint32_t height) {
    BasisPicture picture{
        .width = width, .height = height, .colors = {{{8, 2, 16}, 0}, {{4, 4, 4}, 0}}, .patterns = {0}};
    const size_t blockCount = (width + 3) / 4 * ((height + 3) / 4);
    picture.color = {std::vector<uint32_t>(blockCount, 0), std::vector<uint32_t>(blockCount, 0)};
    picture.alpha = {std::vector<uint32_t>(blockCount, 1), std::vector<uint32_t>(blockCount, 0)};
    return MakeBasisLz(picture);
}

std::vector<Kind> Kinds() {
    return {{"EXT_texture_webp", "a.webp", MakeWebp(8, 4, kColor), kColor},
            {"MSFT_texture_dds", "a.dds", MakePlainDds(8, 4, kColor), kColor},
            {"KHR_texture_basisu", "uastc.ktx2", MakeUastc(8, 4, kColor), kColor},
            {"KHR_texture_basisu", "etc1s.ktx2", MakeEtc1s(8, 4), kEtc1sColor}};
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
        SCOPED_TRACE(kind.file);
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
                ASSERT_EQ(scene.images[0].rgba[i], kind.color[i % 4]) << i;
        }
    }
}

TEST(TextureExtensions, IndicesOutOfRangeAreRefused) {
    for (const Kind& kind : Kinds()) {
        GltfDocument document = WithTexture(true);
        document.json["textures"][0]["extensions"][kind.extension] = {{"source", 7}};
        EXPECT_EQ(LoadError(document), std::string("scene.gltf: textures[0].extensions.") + kind.extension +
                                           ".source: is 7, but there is 1 image");
    }
}

// An image that cannot be read is no reason to refuse a scene that has another one of the same picture.
TEST(TextureExtensions, ImageThatCannotBeReadIsReplacedBySourceWithAWarning) {
    for (const Kind& kind : Kinds()) {
        SCOPED_TRACE(kind.file);
        for (const uint32_t threads : {1u, 4u}) {
            scene::LoadOptions options;
            options.maxThreads = threads;
            GltfDocument document = WithTexture(true);
            AddKind(document, kind, "missing.file");
            const scene::SceneData scene = Load(document, options);
            ASSERT_EQ(scene.images.size(), 1u);
            EXPECT_EQ(scene.images[0].width, 2u);
            ASSERT_EQ(scene.warnings.size(), 1u);
            EXPECT_TRUE(scene.warnings[0].starts_with("scene.gltf: images[1].uri: \"missing.file\": "))
                << scene.warnings[0];
            EXPECT_TRUE(scene.warnings[0].ends_with("; images[0] takes its place")) << scene.warnings[0];
            // The fallback cannot be read either: the error is about the first failure
            document.json["images"][0]["uri"] = DataUri(ToBytes("no image"));
            EXPECT_TRUE(LoadError(document, options).starts_with("scene.gltf: images[1].uri: \"missing"));
        }
    }
}

// Each of them has another width; the first in this order is read.
TEST(TextureExtensions, OfSeveralTheOneThatLostLeastIsRead) {
    const std::vector<std::pair<const char*, Bytes>> order{
        {"EXT_texture_webp", MakeWebp(11, 1, kColor)},
        {"MSFT_texture_dds", MakePlainDds(12, 1, kColor)},
        {"KHR_texture_basisu", MakeUastc(13, 1, kColor)},
    };
    for (size_t first = 0; first < order.size(); ++first) {
        GltfDocument document = WithTexture(true);
        for (size_t i = order.size(); i-- > first;)
            AddKind(document, {order[i].first, "", {}, {}}, DataUri(order[i].second));
        EXPECT_EQ(Load(document).images.at(0).width, 11 + first) << order[first].first;
    }
}

// The extension does not allow this, but the file is unambiguous without it.
TEST(TextureExtensions, PlainKtx2IsAnImageLikeOthers) {
    GltfDocument document = WithTexture(true);
    const Bytes texels = MakePlainDds(3, 3, kColor);
    const Bytes ktx2 = MakeKtx2({.vkFormat = kVkRgba8, .width = 3, .height = 3},
                                std::span<const std::byte>(texels).last(4 * 3 * 3));
    document.json["images"][0]["uri"] = DataUri(ktx2);
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.images.at(0).width, 3u);
    EXPECT_TRUE(std::ranges::equal(std::span(scene.images[0].rgba).first(4), kColor));
}

TEST(TextureExtensions, FilesAreSavedAlong) {
    for (const Kind& kind : Kinds()) {
        SCOPED_TRACE(kind.file);
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
}  // namespace raygraph::test::import_texture_test
