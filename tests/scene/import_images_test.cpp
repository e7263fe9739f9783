// Images and textures: their files, their URIs, and which files may be read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <zstd.h>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "base/printable.h"
#include "renderer/image/pixel_budget.h"
#include "renderer/scene/gltf/container.h"
#include "renderer/scene/gltf/file_access.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "tests/image/texture_files.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/peak_memory.h"

// Images are decoded on several threads, and nobody can tell by the result.
namespace raygraph::test::import_images_test {
namespace {

constexpr std::array<uint32_t, 5> kThreadCounts{1, 2, 3, 16, 0xFFFFFFFFu};

Bytes NoisyPng(uint32_t width, uint32_t height, uint32_t seed) {
    std::vector<uint8_t> texels(size_t{4} * width * height);
    for (size_t i = 0; i < texels.size(); ++i)
        texels[i] = static_cast<uint8_t>((i * 2654435761u + seed) >> 13);
    return MakePngOf(width, height, texels);
}

// A triangle whose materials use these images, one after another.
GltfDocument WithImages(const std::vector<std::string>& uris) {
    GltfDocument document;
    for (size_t i = 0; i < uris.size(); ++i) {
        document.Add("images", {{"uri", uris[i]}});
        document.Add("textures", {{"source", i}});
        document.AddTriangle()["material"] = document.AddMaterial({{"emissiveTexture", {{"index", i}}}});
    }
    return document;
}

std::vector<std::string> ManyImages() {
    std::vector<std::string> uris;
    for (uint32_t i = 0; i < 24; ++i) uris.push_back(DataUri(NoisyPng(1 + i * 7 % 40, 1 + i % 5, i)));
    return uris;
}

TEST(ImageThreads, SceneIsTheSameForAnyNumber) {
    const GltfDocument document = WithImages(ManyImages());
    std::vector<scene::ImageData> expected;
    for (const uint32_t threads : kThreadCounts) {
        std::vector<float> fractions;
        scene::LoadOptions options;
        options.maxThreads = threads;
        options.progress = [&](std::string_view, float fraction) { fractions.push_back(fraction); };
        const scene::SceneData scene = Load(document, options);
        EXPECT_TRUE(std::ranges::is_sorted(fractions));
        if (threads == 1) expected = scene.images;
        ASSERT_EQ(scene.images.size(), 24u);
        for (size_t i = 0; i < scene.images.size(); ++i) {
            EXPECT_EQ(scene.images[i].width, 1 + i * 7 % 40) << threads;
            EXPECT_EQ(scene.images[i].rgba, expected[i].rgba) << threads;
        }
    }
}

TEST(ImageThreads, LowestAlphaIsComputedByTheDecoders) {
    std::vector<uint8_t> texels(size_t{4} * 100 * 90, 255);
    texels[size_t{4} * 100 * 90 - 1] = 17;
    for (const uint32_t threads : kThreadCounts) {
        scene::LoadOptions options;
        options.maxThreads = threads;
        const std::vector<scene::ImageData> images =
            Load(WithImages({DataUri(MakePngOf(100, 90, texels)), DataUri(MakePng(3, 3, {1, 2, 3, 255})),
                             DataUri(MakePng(2, 1, {9, 9, 9, 0}))}),
                 options)
                .images;
        EXPECT_EQ(images[0].lowestAlpha, 17) << threads;
        EXPECT_EQ(images[1].lowestAlpha, 255) << threads;
        EXPECT_EQ(images[2].lowestAlpha, 0) << threads;
    }
}

// The first one in order, whatever the others run into meanwhile.
TEST(ImageThreads, ErrorIsTheSameForAnyNumber) {
    std::vector<std::string> uris = ManyImages();
    const auto expect = [&](const std::string& start, const scene::LoadLimits& limits) {
        std::string expected;
        for (const uint32_t threads : kThreadCounts) {
            for (int round = 0; round < 5; ++round) {
                scene::LoadOptions options;
                options.limits = limits;
                options.maxThreads = threads;
                const std::string error = LoadError(WithImages(uris), options);
                if (expected.empty()) expected = error;
                ASSERT_EQ(error, expected) << threads;
                ASSERT_TRUE(error.starts_with(start)) << error;
            }
        }
    };
    uris[20] = "missing.png";
    expect("scene.gltf: images[20].uri: \"missing.png\": ", {});
    uris[12] = DataUri(ToBytes("no image"));
    uris[13] = DataUri(ToBytes("none either"));
    expect("scene.gltf: images[12]: is of an unknown format", {});
    // The first three images have 1, 16 and 45 texels, the fourth 88, for which 10 are left
    expect("scene.gltf: images[3]: 22 x 4 pixels exceed the limit of ",
           {.maxAllImageTexels = 1 + 16 + 45 + 10});
    expect("scene.gltf: images[2]: 15 x 3 pixels exceed the limit of 12 x 12", {.maxImageExtent = 12});
}

TEST(ImageThreads, LimitOfAllTexelsIsExactForAnyNumber) {
    std::vector<std::string> uris;
    for (uint32_t i = 0; i < 12; ++i) uris.push_back(DataUri(NoisyPng(10, 10, i)));
    for (const uint32_t threads : kThreadCounts) {
        scene::LoadOptions options;
        options.maxThreads = threads;
        options.limits.maxAllImageTexels = 1200;
        EXPECT_EQ(LoadError(WithImages(uris), options), "loaded") << threads;
        options.limits.maxAllImageTexels = 1199;
        EXPECT_EQ(LoadError(WithImages(uris), options),
                  "scene.gltf: images[11]: 10 x 10 pixels exceed the limit of 99 pixels")
            << threads;
    }
}

// Sixteen images that are decoded at once have no more memory than two that are allowed: of each its pixels,
// as many bytes that the decoder inflates, and little beside.
TEST(ImageThreads, MemoryIsThatOfTheLimitForAnyNumber) {
    constexpr size_t kImageBytes = size_t{4} << 20;
    const std::string uri = DataUri(MakePngOf(1024, 1024, std::vector<uint8_t>(kImageBytes, 7)));
    const GltfDocument document = WithImages(std::vector<std::string>(16, uri));
    for (const uint32_t threads : kThreadCounts) {
        scene::LoadOptions options;
        options.maxThreads = threads;
        options.limits.maxAllImageTexels = uint64_t{2} << 20;
        const testing::PeakMemory peak;
        EXPECT_EQ(LoadError(document, options).substr(0, 22), "scene.gltf: images[2]:");
        EXPECT_LT(peak.Bytes(), 4 * kImageBytes + kImageBytes / 2) << threads;
    }
}

// Inflated Zstandard data exists beside the texels until it is decoded: for as many images as are decoded at
// once, which are a quarter of all here.
TEST(ImageThreads, MemoryOfDecodersIsThatOfAQuarterOfAllTexels) {
    constexpr size_t kImageBytes = size_t{4} << 20, kImages = 8;
    const std::vector<uint8_t> texels(kImageBytes, 7);
    std::vector<uint8_t> packed(ZSTD_compressBound(kImageBytes));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), texels.data(), kImageBytes, 1));
    const Bytes file = MakeKtx2({.vkFormat = kVkRgba8,
                                 .width = 1024,
                                 .height = 1024,
                                 .supercompression = 2,
                                 .inflatedBytes = kImageBytes},
                                packed);
    const GltfDocument document = WithImages(std::vector<std::string>(kImages, DataUri(file)));
    scene::LoadOptions options;
    options.maxThreads = 16;
    options.limits.maxImageTexels = uint64_t{1} << 20;
    options.limits.maxAllImageTexels = kImages << 20;
    const testing::PeakMemory peak;
    EXPECT_EQ(Load(document, options).images.size(), kImages);
    EXPECT_LT(peak.Bytes(), (kImages + kImages / 4) * kImageBytes + kImageBytes / 2);
}

TEST(PixelBudget, OfThoseBeingDecodedNoMoreThanAreAllowedAtOnce) {
    image::PixelBudget budget(1000, 100);
    std::atomic<uint32_t> decoding = 0, most = 0, refused = 0;
    const auto decode = [&](uint64_t pixels) {
        image::PixelBudget::Share share(budget);
        if (!share.Take(pixels)) {
            ++refused;
            return;
        }
        const uint32_t now = ++decoding;
        for (uint32_t before = most; now > before && !most.compare_exchange_weak(before, now);) {
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        --decoding;
    };
    std::vector<std::thread> threads;
    for (int i = 0; i < 24; ++i) threads.emplace_back(decode, 40);
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(most, 2u);
    EXPECT_EQ(refused, 0u);
    decode(41);  // 40 are left
    EXPECT_EQ(refused, 1u);
    decode(40);
    EXPECT_EQ(refused, 1u);
    image::PixelBudget large(1000, 100);
    image::PixelBudget::Share alone(large);
    EXPECT_TRUE(alone.Take(500));
}

size_t RunningThreads() {
    const std::filesystem::directory_iterator tasks("/proc/self/task");
    return static_cast<size_t>(std::distance(begin(tasks), end(tasks)));
}

TEST(ImageThreads, ThereAreAsManyAsAskedFor) {
    const std::string uri = DataUri(NoisyPng(1024, 512, 1));
    const GltfDocument document = WithImages(std::vector<std::string>(4, uri));
    for (const uint32_t threads : {1u, 4u}) {
        const size_t before = RunningThreads();
        size_t most = 0;
        scene::LoadOptions options;
        options.maxThreads = threads;
        options.progress = [&](std::string_view, float) { most = std::max(most, RunningThreads()); };
        Load(document, options);
        if (threads == 1)
            EXPECT_EQ(most, before);
        else
            EXPECT_GT(most, before);
        EXPECT_EQ(RunningThreads(), before) << "they end before the call does";
    }
}

}  // namespace
}  // namespace raygraph::test::import_images_test

// Extensions of textures that name another file of the same picture.
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

namespace raygraph::test::uri_test {
namespace {

std::string Decoded(std::string_view uri) {
    const std::vector<std::byte> bytes = scene::DecodeDataUri(uri, 1000);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string DecodeError(std::string_view uri, uint64_t maxBytes = 1000) {
    return testing::ErrorTextOf([&] { scene::DecodeDataUri(uri, maxBytes); }, ErrorKind::BadInput);
}

TEST(Uri, Base64OfEveryLengthIsDecoded) {
    EXPECT_EQ(Decoded("data:;base64,"), "");
    EXPECT_EQ(Decoded("data:;base64,Zg=="), "f");
    EXPECT_EQ(Decoded("data:;base64,Zm8="), "fo");
    EXPECT_EQ(Decoded("data:;base64,Zm9v"), "foo");
    EXPECT_EQ(Decoded("data:;base64,Zm9vYmFy"), "foobar");
    EXPECT_EQ(Decoded("data:;base64,Zg"), "f") << "padding may be missing";
    EXPECT_EQ(Decoded("DATA:a/b;x=y;BASE64,+/-_"), "\xFB\xFF\xBF");
    EXPECT_EQ(Decoded("data:;base64,Zg%3D%3D"), "f");
}

TEST(Uri, PlainDataIsPercentDecoded) {
    EXPECT_EQ(Decoded("data:text/plain,a%20b%zz"), "a b%zz");
}

TEST(Uri, MalformedDataUrisAreRefused) {
    EXPECT_EQ(DecodeError("data:;base64"), "data URI: it has no comma");
    EXPECT_EQ(DecodeError("data:;base64,Zm9vY"), "data URI: its base64 text is cut short");
    EXPECT_EQ(DecodeError("data:;base64,Zm 9"), "data URI: character 2 of its data is not base64");
    EXPECT_EQ(DecodeError("data:;base64,Z===Zg=="), "data URI: character 1 of its data is not base64");
    EXPECT_EQ(DecodeError("data:;base64,Zm9v", 2), "data URI: 3 bytes exceed the limit of 2");
    EXPECT_EQ(DecodeError("data:,abc", 2), "data URI: 3 bytes exceed the limit of 2");
}

TEST(Uri, SchemesAreTold) {
    EXPECT_EQ(scene::UriScheme("http://x"), "http");
    EXPECT_EQ(scene::UriScheme("a+b-c.d:x"), "a+b-c.d");
    EXPECT_EQ(scene::UriScheme("a/b:c"), std::nullopt);
    EXPECT_EQ(scene::UriScheme("1a:b"), std::nullopt);
    EXPECT_EQ(scene::UriScheme(""), std::nullopt);
    EXPECT_TRUE(scene::IsDataUri("data:,"));
    EXPECT_FALSE(scene::IsDataUri("database.bin"));
}

TEST(Uri, PercentAtTheEndStays) {
    EXPECT_EQ(scene::PercentDecode("a%"), "a%");
    EXPECT_EQ(scene::PercentDecode("a%4"), "a%4");
    EXPECT_EQ(scene::PercentDecode("a%41"), "aA");
}

TEST(Text, PrintableKeepsUtf8AndHidesTheRest) {
    EXPECT_EQ(Printable("gr\xC3\xBC\xC3\x9F \xF0\x9F\x98\x80"), "gr\xC3\xBC\xC3\x9F \xF0\x9F\x98\x80");
    EXPECT_EQ(Printable("a\tb\r\nc\x7F"), "a?b??c?");
    EXPECT_EQ(Printable("\xC2\x9B"
                        "31m"),
              "?31m")
        << "a C1 control starts an escape sequence too";
    EXPECT_EQ(Printable("\xC0\xAF\xED\xA0\x80\xF5"), "??????");
    // The last code point before the surrogates, and the first one after them
    EXPECT_EQ(Printable("\xED\x9F\xBF\xED\xBF\xBF\xEE\x80\x80"), "\xED\x9F\xBF???\xEE\x80\x80");
    EXPECT_EQ(Printable("\xE2\x82"), "??");
    EXPECT_EQ(Printable("abcdef", 3), "abc...");
    EXPECT_EQ(Printable("ab\xC3\xBC", 3), "ab...") << "never half a character";
}

}  // namespace
}  // namespace raygraph::test::uri_test

// A scene reads what stands in its own folder and nothing else.
namespace raygraph::test::file_access_test {
namespace {

namespace fs = std::filesystem;

// A triangle whose positions are in the file that `uri` names.
GltfDocument WithBufferUri(const std::string& uri) {
    GltfDocument document;
    document.AddTriangle();
    document.json["buffers"][0]["uri"] = uri;
    return document;
}

const Bytes kPositions = BytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});

// Returns the error about the URI, without the part that every message has.
std::string UriError(SceneFolder& folder, const std::string& uri) {
    const std::string message = folder.LoadError(WithBufferUri(uri));
    const std::string start = "scene.gltf: buffers[0].uri: ";
    EXPECT_EQ(message.find(start), 0u) << message;
    return message.substr(std::min(start.size(), message.size()));
}

TEST(FileAccess, FilesBesideTheSceneAreRead) {
    SceneFolder folder;
    folder.Write("a b.bin", kPositions);
    folder.Write("deep/er/data.bin", kPositions);
    EXPECT_EQ(folder.LoadError(WithBufferUri("a b.bin")), "loaded");
    EXPECT_EQ(folder.LoadError(WithBufferUri("a%20b.bin")), "loaded");
    EXPECT_EQ(folder.LoadError(WithBufferUri("./deep/er/data.bin")), "loaded");
    EXPECT_EQ(folder.reads.back(), folder.Path() / "deep/er/data.bin");
}

// Returns the message that refuses a URI that leads out.
std::string Outside(const std::string& uri) {
    return '"' + uri +
           "\": leads out of the scene's folder; --root FOLDER allows what is below another folder";
}

TEST(FileAccess, DotsAreResolvedBeforeTheUriIsChecked) {
    SceneFolder folder;
    folder.Write("own.bin", kPositions);
    const std::string name = folder.Path().filename().string();
    for (const std::string uri : {"sub/../own.bin", "a/b/../../own.bin", "./x/./../own.bin",
                                  "sub/%2e%2e/own.bin", "sub%2F..%2fown.bin", "sub//../own.bin"})
        EXPECT_EQ(folder.LoadError(WithBufferUri(uri)), "loaded") << uri;
    EXPECT_EQ(folder.LoadError(WithBufferUri("../" + name + "/own.bin")), "loaded") << "out, and in again";
    EXPECT_EQ(folder.reads.back(), folder.Path() / "own.bin");
    // ".." is resolved in the text of the URI, not where a link leads
    const SceneFolder outside;
    outside.Write("inner/secret.bin", kPositions);
    outside.Write("own.bin", "none of the scene's");
    fs::create_directory_symlink(outside.Path() / "inner", folder.Path() / "link");
    EXPECT_EQ(folder.LoadError(WithBufferUri("link/../own.bin")), "loaded");
    EXPECT_EQ(folder.reads.back(), folder.Path() / "own.bin");
}

TEST(FileAccess, UrisThatLeadOutAreRefusedUnread) {
    SceneFolder folder;
    folder.Write("inner/keep.txt", "");
    for (const std::string uri :
         {"../secret.bin", "inner/../../secret.bin", "%2e%2e/secret.bin", "%2E%2E%2Fsecret.bin", "..",
          "../..", "inner/../..", "../../../../../../../../../../etc/passwd"})
        EXPECT_EQ(UriError(folder, uri), Outside(uri));
    EXPECT_EQ(UriError(folder, "/etc/passwd"),
              "\"/etc/passwd\": must be a relative path, not an absolute one");
    EXPECT_EQ(UriError(folder, "%2Fetc/passwd"),
              "\"%2Fetc/passwd\": must be a relative path, not an absolute one");
    EXPECT_EQ(UriError(folder, "//host/share"),
              "\"//host/share\": must be a relative path, not an absolute one");
    EXPECT_EQ(UriError(folder, "file:///etc/passwd"),
              "\"file:///etc/passwd\": must be a relative path or a data URI, not \"file\"");
    EXPECT_EQ(UriError(folder, "http://example.com/x"),
              "\"http://example.com/x\": must be a relative path or a data URI, not \"http\"");
    EXPECT_EQ(UriError(folder, "C:\\x.bin"),
              "\"C:\\x.bin\": must be a relative path or a data URI, not \"C\"");
    EXPECT_EQ(UriError(folder, "..\\x.bin"), "\"..\\x.bin\": contains a backslash");
    EXPECT_EQ(UriError(folder, "a%00b"), "\"a%00b\": contains a zero byte");
    EXPECT_EQ(UriError(folder, ""), "\"\": is empty");
    for (const fs::path& path : folder.reads) EXPECT_EQ(path, folder.Path() / "scene.gltf");
}

TEST(FileAccess, SymbolicLinksOutOfTheFolderAreRefusedUnread) {
    const SceneFolder outside;
    outside.Write("data.bin", kPositions);
    SceneFolder folder;
    fs::create_symlink(outside.Path() / "data.bin", folder.Path() / "link.bin");
    fs::create_directory_symlink(outside.Path(), folder.Path() / "dir");
    EXPECT_EQ(UriError(folder, "link.bin"), Outside("link.bin"));
    EXPECT_EQ(UriError(folder, "dir/data.bin"), Outside("dir/data.bin"));
    for (const fs::path& path : folder.reads) EXPECT_EQ(path, folder.Path() / "scene.gltf");
}

TEST(FileAccess, FolderWhoseNameOnlyStartsAlikeIsOutside) {
    const TemporaryFolder outer;
    fs::create_directories(outer / "scene");
    fs::create_directories(outer / "scene-secret");
    std::ofstream(outer / "scene-secret/x.bin") << "x";
    fs::create_symlink(outer / "scene-secret/x.bin", outer / "scene/x.bin");
    scene::DiskFileReader disk;
    const scene::ConfinedFolder folder(outer / "scene", disk);
    EXPECT_THROW(folder.Read("x.bin", 100), Error);
}

// A folder with scene/scene.gltf, and textures and secrets beside it.
class RootTest : public ::testing::Test {
  protected:
    RootTest() : path(fs::canonical(outer.Path())) {
        for (const char* folder : {"scene", "textures/deep", "secrets"})
            fs::create_directories(path / folder);
        for (const char* file : {"scene/own.bin", "textures/x.bin", "textures/deep/y.bin", "secrets/z.bin"})
            Write(file, kPositions);
        fs::create_symlink(path / "secrets/z.bin", path / "textures/link.bin");
        fs::create_symlink(path / "textures/x.bin", path / "scene/in.bin");
    }
    void Write(const fs::path& file, const Bytes& bytes) const {
        std::ofstream(path / file, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
    // Loads a scene that names the file by this URI. Returns "loaded", or the message about the URI.
    std::string Load(const std::string& uri, const fs::path& root) const {
        Write("scene/scene.gltf", ToBytes(WithBufferUri(uri).Text()));
        try {
            scene::LoadGltf(path / "scene/scene.gltf", {.root = root});
            return "loaded";
        } catch (const Error& error) {
            const std::string message = error.what(), start = "scene.gltf: buffers[0].uri: \"" + uri + "\": ";
            return message.starts_with(start) ? message.substr(start.size()) : message;
        }
    }
    TemporaryFolder outer;
    fs::path path;
};

TEST_F(RootTest, FilesBelowItAreReadBesidesThoseOfTheSceneFolder) {
    for (const char* uri : {"../textures/x.bin", "%2e%2e/textures/deep/../deep/y.bin", "own.bin", "in.bin"}) {
        EXPECT_EQ(Load(uri, path), "loaded") << uri;
        EXPECT_EQ(Load(uri, path / "scene/.."), "loaded") << uri;
        EXPECT_EQ(Load(uri, path / "textures"), "loaded") << uri << ": it need not be a folder above";
    }
    EXPECT_EQ(Load("../textures/link.bin", path), "loaded");
    EXPECT_EQ(Load("../textures/x.bin", {}),
              "leads out of the scene's folder; --root FOLDER allows what is below another folder");
}

TEST_F(RootTest, WhatLeadsOutOfItTooIsRefused) {
    const std::string outside =
        "leads out of the scene's folder and of the root \"" + (path / "textures").string() + '"';
    for (const char* uri : {"../secrets/z.bin", "../textures/../secrets/z.bin", "../textures/link.bin", "..",
                            "../../x.bin", "../textures-too/x.bin", "../textures"})
        EXPECT_EQ(Load(uri, path / "textures"), outside) << uri;
    EXPECT_EQ(Load((path / "textures/x.bin").string(), path), "must be a relative path, not an absolute one");
    EXPECT_THAT(Load("file://" + (path / "textures/x.bin").string(), path),
                ::testing::HasSubstr("must be a relative path or a data URI"));
    EXPECT_EQ(Load("../textures", path), "is not a regular file");
    ASSERT_EQ(mkfifo((path / "textures/pipe").c_str(), 0600), 0);
    EXPECT_EQ(Load("../textures/pipe", path), "is not a regular file");
    const std::string device = "../../../../../../../../../../../../dev/zero";
    EXPECT_EQ(Load(device, "/"), "is not a regular file");
    EXPECT_EQ(Load("../textures/gone.bin", path), "No such file or directory");
}

TEST_F(RootTest, ItMustBeAFolder) {
    EXPECT_EQ(Load("own.bin", path / "none"), (path / "none").string() + ": No such file or directory");
    EXPECT_EQ(Load("own.bin", path / "scene/own.bin"),
              (path / "scene/own.bin").string() + ": is not a folder");
}

TEST_F(RootTest, SavedElsewhereNothingIsWrittenOutsideOfTheTarget) {
    ASSERT_EQ(Load("../textures/x.bin", path), "loaded");
    const fs::path source = path / "scene/scene.gltf";
    const scene::LoadOptions options{.root = path};
    const scene::SceneData scene = scene::LoadGltf(source, options);
    // A scene saved in the folder beside it reaches the same file
    fs::create_directory(path / "other");
    scene::SaveGltf(source, scene, path / "other/saved.gltf", options);
    EXPECT_EQ(scene::LoadGltf(path / "other/saved.gltf", options).instances.size(), 1u);
    fs::create_directories(path / "far/away");
    EXPECT_EQ(
        testing::ErrorTextOf([&] { scene::SaveGltf(source, scene, path / "far/away/saved.gltf", options); },
                             ErrorKind::BadInput),
        "\"../textures/x.bin\": leads out of the scene's folder, and is not copied to " +
            (path / "far/away/../textures/x.bin").string());
    EXPECT_FALSE(fs::exists(path / "far/textures"));
    EXPECT_FALSE(fs::exists(path / "far/away/saved.gltf"));
    fs::create_directory(path / "far/textures");
    Write("far/textures/x.bin", ToBytes("another"));
    EXPECT_THROW(scene::SaveGltf(source, scene, path / "far/away/saved.gltf", options), Error);
}

TEST(FileAccess, SymbolicLinksWithinTheFolderAreFollowed) {
    SceneFolder folder;
    folder.Write("real/data.bin", kPositions);
    fs::create_symlink("real/data.bin", folder.Path() / "link.bin");
    EXPECT_EQ(folder.LoadError(WithBufferUri("link.bin")), "loaded");
}

TEST(FileAccess, ThingsThatAreNoFilesAreRefusedWithoutWaiting) {
    SceneFolder folder;
    ASSERT_EQ(mkfifo((folder.Path() / "pipe").c_str(), 0600), 0);
    fs::create_directory(folder.Path() / "folder");
    EXPECT_EQ(UriError(folder, "pipe"), "\"pipe\": is not a regular file");
    EXPECT_EQ(UriError(folder, "folder"), "\"folder\": is not a regular file");
    scene::DiskFileReader disk;
    EXPECT_THROW(disk.Read("/dev/zero", 100), Error);
}

TEST(FileAccess, MissingFilesAreRefusedByName) {
    SceneFolder folder;
    EXPECT_EQ(UriError(folder, "gone.bin"), "\"gone.bin\": No such file or directory");
}

TEST(FileAccess, FilesBeyondTheLimitAreRefusedUnread) {
    SceneFolder folder;
    folder.Write("big.bin", Bytes(5000));
    const GltfDocument document = WithBufferUri("big.bin");
    scene::LoadOptions options;
    options.limits.maxFileBytes = document.Text().size() + 4000;
    EXPECT_EQ(folder.LoadError(document, options),
              "scene.gltf: buffers[0].uri: \"big.bin\": 5000 bytes exceed the limit of 4000");
}

TEST(FileAccess, HostileUriIsQuotedInOneLine) {
    SceneFolder folder;
    EXPECT_EQ(UriError(folder, "a\nb\x1b[31m\xE2\x80\xA8.bin"),
              "\"a?b?[31m?.bin\": No such file or directory");
    EXPECT_LT(UriError(folder, std::string(100000, 'x')).size(), 200u);
}

TEST(FileAccess, MissingSceneIsAnIoError) {
    const SceneFolder folder;
    EXPECT_EQ(testing::ErrorTextOf([&] { scene::LoadGltf(folder.Path() / "none.glb"); }, ErrorKind::Io),
              (folder.Path() / "none.glb").string() + ": No such file or directory");
}

TEST(FileAccess, FolderAsSceneIsAnIoError) {
    const SceneFolder folder;
    EXPECT_EQ(testing::ErrorOf([&] { scene::LoadGltf(folder.Path()); }).Kind(), ErrorKind::Io);
}

TEST(FileAccess, LinkToASceneFindsWhatStandsBesideTheLink) {
    SceneFolder real;
    real.Write("scene.gltf", WithBufferUri("data.bin").Text());
    SceneFolder folder;
    folder.Write("data.bin", kPositions);
    fs::create_symlink(real.Path() / "scene.gltf", folder.Path() / "link.gltf");
    EXPECT_EQ(scene::LoadGltf(folder.Path() / "link.gltf").instances.size(), 1u);
}

}  // namespace
}  // namespace raygraph::test::file_access_test
