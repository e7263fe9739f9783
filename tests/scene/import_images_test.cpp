// Images are decoded on several threads, and nobody can tell by the result.
#include <gtest/gtest.h>
#include <zstd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <thread>

#include "renderer/image/pixel_budget.h"
#include "tests/image/texture_files.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/peak_memory.h"

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
