// Measures how fast files are decoded, by format (docs/gltf.md): on one core by processor time, so that other
// load counts little, and on all cores by the clock.
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "base/stopwatch.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/image/image_files.h"
#include "tests/image/texture_files.h"
#include "tests/image/uastc_writer.h"
#include "tests/support/reference_assets.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::test::decode_throughput_test {
namespace {

using Json = nlohmann::json;

constexpr uint32_t kSide = 2048;
constexpr size_t kImages = 16;

// Makes smooth shapes with a little noise, as in photographs.
image::Image8 Photograph() {
    image::Image8 image{
        .width = kSide, .height = kSide, .rgba = std::vector<uint8_t>(size_t{4} * kSide * kSide)};
    std::mt19937 random(1);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x)
            for (uint32_t c = 0; c < 4; ++c) {
                const double shape =
                    std::sin(0.011 * x + c) * std::cos(0.017 * y) + 0.4 * std::sin(0.13 * (x + y));
                const double value = 128.0 + 80.0 * shape + double(random() % 9);
                image.rgba[4 * (size_t{y} * kSide + x) + c] =
                    c == 3 ? 255 : static_cast<uint8_t>(std::clamp(value, 0.0, 255.0));
            }
    return image;
}

struct Format {
    const char* name;
    Bytes file;
};

std::vector<uint8_t> Uastc() {
    std::mt19937 random(1);
    std::vector<uint8_t> level;
    for (size_t i = 0; i < size_t{kSide / 4} * (kSide / 4); ++i)
        for (const std::byte byte : Pack(RandomUastcBlock(i % 19, random)))
            level.push_back(std::to_integer<uint8_t>(byte));
    return level;
}

Bytes Zstandard(Ktx2Desc desc, std::span<const uint8_t> level) {
    std::vector<uint8_t> packed(ZSTD_compressBound(level.size()));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), level.data(), level.size(), 3));
    desc.supercompression = 2;
    desc.inflatedBytes = level.size();
    return MakeKtx2(desc, packed);
}

std::vector<Format> Formats() {
    const image::Image8 photograph = Photograph();
    const std::span<const uint8_t> texels = photograph.rgba;
    std::vector<uint8_t> rgb;
    for (size_t i = 0; i < texels.size(); ++i)
        if (i % 4 != 3) rgb.push_back(texels[i]);
    const DdsDesc dds{.width = kSide, .height = kSide};
    DdsDesc bc1 = dds, bc7 = dds;
    bc1.fourCc = "DXT1";
    bc7.dxgiFormat = kDxgiBc7;
    const Ktx2Desc plain{.vkFormat = kVkRgba8, .width = kSide, .height = kSide};
    const Ktx2Desc uastc{.width = kSide, .height = kSide, .model = kUastc, .channels = {3}};
    const std::vector<uint8_t> blocks = Uastc();
    return {{"PNG", MakePng({.width = kSide, .height = kSide, .colorType = 2}, rgb)},
            {"JPEG", MakeJpeg(JpegKind::Rgb, kSide, kSide, rgb)},
            {"JPEG, progressive", MakeJpeg(JpegKind::ProgressiveRgb, kSide, kSide, rgb)},
            {"WebP", MakeLossyWebp(photograph, 90.0f)},
            {"WebP, lossless", MakeLosslessWebp(photograph)},
            {"DDS, plain", MakeDds(dds, texels)},
            {"DDS, BC1", MakeDds(bc1, texels.first(texels.size() / 8))},
            {"DDS, BC7", MakeDds(bc7, texels.first(texels.size() / 4))},
            {"KTX2, plain, Zstandard", Zstandard(plain, texels)},
            {"KTX2, UASTC", MakeKtx2(uastc, blocks)},
            {"KTX2, UASTC, Zstandard", Zstandard(uastc, blocks)},
            {"KTX2, ETC1S", MakeBasisLz(RandomBasisPicture(kSide, kSide, false, 3))}};
}

struct Times {
    double wall = 1e30, cpu = 1e30;  // seconds; the minimum of some runs
};

Times TimesOf(const std::function<void()>& run) {
    Times least;
    for (int i = 0; i < 3; ++i) {
        const Stopwatch watch;
        const std::clock_t start = std::clock();
        run();
        least.cpu = std::min(least.cpu, double(std::clock() - start) / CLOCKS_PER_SEC);
        least.wall = std::min(least.wall, watch.Seconds());
    }
    return least;
}

Times TimesToLoad(const std::filesystem::path& path, uint32_t threads) {
    scene::LoadOptions options;
    options.maxThreads = threads;
    return TimesOf([&] { scene::LoadGltf(path, options); });
}

unsigned Cores() {
    return std::max(1u, std::thread::hardware_concurrency());
}

void Write(const std::filesystem::path& path, const Bytes& bytes) {
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// Makes a triangle per material, with materials that show the file "image".
Json WithImages() {
    Json json{{"asset", {{"version", "2.0"}}}};
    json["accessors"] = Json::array({{{"componentType", 5126}, {"type", "VEC3"}, {"count", 3}}});
    for (size_t i = 0; i < kImages; ++i) {
        json["images"].push_back({{"uri", "image"}});
        json["textures"].push_back({{"source", i}});
        json["materials"].push_back({{"emissiveTexture", {{"index", i}}}});
        json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"material", i}});
    }
    json["nodes"] = Json::array({{{"mesh", 0}}});
    return json;
}

TEST(DecodeThroughput, ImagesByFormat) {
    std::printf(
        "| %u x %u texels | MB a file | MB/s | million texels/s | %u cores | speedup "
        "|\n|---|---|---|---|---|---|\n",
        kSide, kSide, Cores());
    for (const Format& format : Formats()) {
        const TemporaryFolder folder;
        Write(folder / "image", format.file);
        const std::filesystem::path path = folder / "scene.gltf";
        std::ofstream(path) << WithImages();
        const double megabytes = double(kImages * format.file.size()) / 1e6;
        const double texels = double(kImages) * kSide * kSide / 1e6;
        const Times one = TimesToLoad(path, 1), all = TimesToLoad(path, 0);
        const double speedup = one.wall / all.wall;
        std::printf("| %s | %.2f | %.0f | %.0f | %.0f | %.1f |\n", format.name,
                    double(format.file.size()) / 1e6, megabytes / one.cpu, texels / one.cpu,
                    texels / all.wall, speedup);
        // Images are independent; memory's bandwidth is shared
        const double cores = std::min<double>(Cores(), kImages);
        EXPECT_GT(speedup, cores < 2 ? 0.7 : 0.35 * cores) << format.name;
    }
}

// Makes a bumpy square with so many vertices per side.
struct Grid {
    static constexpr uint32_t kPoints = 700;
    std::vector<float> positions, normals;
    std::vector<uint32_t> indices;
    Grid() {
        for (uint32_t i = 0; i < kPoints * kPoints; ++i) {
            const uint32_t x = i % kPoints, y = i / kPoints;
            const float height = 3.0f * std::sin(0.05f * float(x)) * std::cos(0.04f * float(y));
            positions.insert(positions.end(), {float(x), float(y), height});
            normals.insert(normals.end(), {0, 0, 1});
            if (x + 1 < kPoints && y + 1 < kPoints)
                indices.insert(indices.end(), {i, i + 1, i + kPoints, i + kPoints, i + 1, i + kPoints + 1});
        }
    }
    uint32_t Count() const { return kPoints * kPoints; }
};

Bytes BytesOf(const void* data, size_t size) {
    Bytes bytes(size);
    std::memcpy(bytes.data(), data, size);
    return bytes;
}

// Stores the grid in a binary file beside the document that describes it.
struct Geometry {
    const char* name;
    Json json;
    Bytes binary;
};

Json Mesh(const Grid& grid) {
    Json json{{"asset", {{"version", "2.0"}}}};
    json["nodes"] = Json::array({{{"mesh", 0}}});
    json["accessors"] =
        Json::array({{{"componentType", 5126}, {"type", "VEC3"}, {"count", grid.Count()}},
                     {{"componentType", 5126}, {"type", "VEC3"}, {"count", grid.Count()}},
                     {{"componentType", 5125}, {"type", "SCALAR"}, {"count", grid.indices.size()}}});
    json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}, {"indices", 2}}}}}};
    return json;
}

void AddView(Geometry& geometry, const Bytes& bytes) {
    geometry.json["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", geometry.binary.size()}, {"byteLength", bytes.size()}});
    geometry.binary.insert(geometry.binary.end(), bytes.begin(), bytes.end());
    geometry.binary.resize((geometry.binary.size() + 3) / 4 * 4);
}

Geometry Plain(const Grid& grid) {
    Geometry geometry{"plain", Mesh(grid), {}};
    AddView(geometry, BytesOf(grid.positions.data(), grid.positions.size() * 4));
    AddView(geometry, BytesOf(grid.normals.data(), grid.normals.size() * 4));
    AddView(geometry, BytesOf(grid.indices.data(), grid.indices.size() * 4));
    for (size_t i = 0; i < 3; ++i) geometry.json["accessors"][i]["bufferView"] = i;
    return geometry;
}

Geometry Meshopt(const Grid& grid) {
    Geometry geometry{"EXT_meshopt_compression", Mesh(grid), {}};
    const auto add = [&](std::vector<unsigned char> bytes, size_t size, const char* mode, size_t count,
                         size_t stride) {
        const size_t view = geometry.json["bufferViews"].size();
        AddView(geometry, BytesOf(bytes.data(), size));
        Json& json = geometry.json["bufferViews"][view];
        json["extensions"]["EXT_meshopt_compression"] = {
            {"buffer", 0},          {"byteOffset", json["byteOffset"]},
            {"byteLength", size},   {"count", count},
            {"byteStride", stride}, {"mode", mode}};
        json["buffer"] = 1;
        json["byteOffset"] = 0;
        json["byteLength"] = count * stride;
        geometry.json["accessors"][view]["bufferView"] = view;
    };
    geometry.json["bufferViews"] = Json::array();
    for (const std::vector<float>* values : {&grid.positions, &grid.normals}) {
        std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(grid.Count(), 12));
        const size_t size =
            meshopt_encodeVertexBuffer(out.data(), out.size(), values->data(), grid.Count(), 12);
        add(out, size, "ATTRIBUTES", grid.Count(), 12);
    }
    std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(grid.indices.size(), grid.Count()));
    const size_t size =
        meshopt_encodeIndexBuffer(out.data(), out.size(), grid.indices.data(), grid.indices.size());
    add(out, size, "TRIANGLES", grid.indices.size(), 4);
    return geometry;
}

Geometry Draco(const Grid& grid) {
    draco::Mesh mesh;
    mesh.set_num_points(grid.Count());
    for (size_t i = 0; i < grid.indices.size(); i += 3)
        mesh.AddFace({draco::PointIndex(grid.indices[i]), draco::PointIndex(grid.indices[i + 1]),
                      draco::PointIndex(grid.indices[i + 2])});
    const auto add = [&](draco::GeometryAttribute::Type type, const std::vector<float>& values) {
        draco::GeometryAttribute attribute;
        attribute.Init(type, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
        const int id = mesh.AddAttribute(attribute, true, grid.Count());
        for (uint32_t i = 0; i < grid.Count(); ++i)
            mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), &values[size_t{3} * i]);
    };
    add(draco::GeometryAttribute::POSITION, grid.positions);
    add(draco::GeometryAttribute::NORMAL, grid.normals);
    draco::ExpertEncoder encoder(mesh);
    encoder.SetTrackEncodedProperties(true);
    encoder.SetSpeedOptions(3, 3);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetAttributeQuantization(0, 14);
    encoder.SetAttributeQuantization(1, 10);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeToBuffer(&buffer).ok());
    Geometry geometry{"KHR_draco_mesh_compression", Mesh(grid), {}};
    AddView(geometry, BytesOf(buffer.data(), buffer.size()));
    for (size_t i = 0; i < 2; ++i) geometry.json["accessors"][i]["count"] = encoder.num_encoded_points();
    geometry.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
        {"bufferView", 0}, {"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}};
    return geometry;
}

TEST(DecodeThroughput, GeometryByCompression) {
    const Grid grid;
    const double decoded = double(grid.positions.size() * 8 + grid.indices.size() * 4) / 1e6;
    std::printf("| %zu triangles | MB a file | MB/s | MB/s of geometry |\n|---|---|---|---|\n",
                grid.indices.size() / 3);
    double plain = 0.0;
    for (Geometry& geometry : std::vector{Plain(grid), Meshopt(grid), Draco(grid)}) {
        const TemporaryFolder folder;
        Write(folder / "b.bin", geometry.binary);
        geometry.json["buffers"] = {{{"uri", "b.bin"}, {"byteLength", geometry.binary.size()}}};
        geometry.json["buffers"].push_back({{"byteLength", grid.indices.size() * 4}});
        const std::filesystem::path path = folder / "scene.gltf";
        std::ofstream(path) << geometry.json;
        const double seconds = TimesToLoad(path, 1).cpu;
        const double megabytes = double(geometry.binary.size()) / 1e6;
        std::printf("| %s | %.2f | %.0f | %.0f |\n", geometry.name, megabytes, megabytes / seconds,
                    decoded / seconds);
        if (plain == 0.0) plain = seconds;
        EXPECT_LT(seconds, 60.0 * plain) << geometry.name;
    }
}

// Measures the reference scenes: the bytes alone, and loading on one core and on all.
TEST(DecodeThroughput, ReferenceScenes) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    std::printf("| scene | MB | read | one core | %u cores | MB/s |\n|---|---|---|---|---|---|\n", Cores());
    double sumOfOne = 0.0, sumOfAll = 0.0;
    std::vector<std::filesystem::path> paths;
    for (const char* folder : {"known", "large"})
        for (const auto& file : std::filesystem::directory_iterator(*ReferenceAssets() / "scenes" / folder))
            if (file.path().extension() == ".glb" && file.file_size() > 500'000) paths.push_back(file.path());
    std::ranges::sort(paths);
    for (const std::filesystem::path& path : paths) {
        const auto size = std::filesystem::file_size(path);
        std::vector<char> bytes(size);
        const Times read = TimesOf([&] {
            std::ifstream(path, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(size));
        });
        const Times one = TimesToLoad(path, 1), all = TimesToLoad(path, 0);
        std::printf("| %s | %.2f | %.1f ms | %.0f ms | %.0f ms | %.0f |\n", path.stem().c_str(),
                    double(size) / 1e6, 1e3 * read.cpu, 1e3 * one.cpu, 1e3 * all.wall,
                    double(size) / 1e6 / one.cpu);
        sumOfOne += one.wall;
        sumOfAll += all.wall;
    }
    EXPECT_LT(sumOfAll, 1.1 * sumOfOne) << "more cores are not slower";
}

}  // namespace
}  // namespace raygraph::test::decode_throughput_test
