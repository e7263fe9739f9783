// Whole files: those of the reference assets, and mutated ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/model/check.h"
#include "tests/image/texture_files.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/ies_text.h"
#include "tests/support/material_extensions.h"
#include "tests/support/reference_assets.h"
#include "tests/support/source_file.h"

// Whole files: our own in scenes/, and where RAYGRAPH_ASSETS names their folder, published ones and malformed
// ones.
namespace raygraph::test::reference_scenes_test {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> SceneFiles(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".gltf" || entry.path().extension() == ".glb")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

scene::SceneStatistics OwnStatistics(const char* name) {
    return scene::Statistics(scene::LoadGltf(test::SourceFile("scenes") / name));
}

TEST(OwnScenes, LoadWithoutWarnings) {
    size_t count = 0;
    scene::LoadOptions options;
    options.pointsAndLines = {.points = {.value = 0.02f}, .lines = {.value = 0.02f}};
    for (const fs::path& file : SceneFiles(test::SourceFile("scenes"))) {
        const scene::SceneData scene = scene::LoadGltf(file, options);
        EXPECT_TRUE(scene.warnings.empty()) << file << ": " << scene.warnings[0];
        EXPECT_FALSE(scene.instances.empty()) << file;
        ++count;
    }
    EXPECT_GE(count, 11u);
}

TEST(OwnScenes, InstancedFieldSharesOneMesh) {
    const scene::SceneStatistics statistics = OwnStatistics("instanced_field.gltf");
    EXPECT_GE(statistics.instanceCount, 10000u);
    EXPECT_GE(statistics.placedTriangles, 10000u * 12);
    EXPECT_LT(statistics.uniqueTriangles, 100u);
}

scene::SceneData OwnScene(const char* name) {
    return scene::LoadGltf(test::SourceFile("scenes") / name);
}

// Placed triangles that emit, and the box around them.
struct EmissiveTriangles {
    size_t count = 0;
    scene::Bounds bounds;
};
EmissiveTriangles Emissive(const scene::SceneData& scene) {
    EmissiveTriangles result;
    for (const scene::Instance& instance : scene.instances)
        for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives) {
            if (scene.materials[primitive.material].EmittedRadiance() == glm::vec3(0.0f)) continue;
            result.count += primitive.TriangleCount();
            result.bounds.Extend(primitive.bounds.Transformed(instance.objectToWorld));
        }
    return result;
}

TEST(OwnScenes, SmallLightIsAnEightyTriangleSphereOfTwoCentimeters) {
    const EmissiveTriangles light = Emissive(OwnScene("small_light.gltf"));
    EXPECT_EQ(light.count, 80u);
    EXPECT_NEAR(0.5f * (light.bounds.max.x - light.bounds.min.x), 0.02f, 1e-3f);
}

TEST(OwnScenes, ManyLightsHasTwoThousandTrianglesAndTwoHundredPointLights) {
    const scene::SceneData scene = OwnScene("many_lights.gltf");
    EXPECT_EQ(Emissive(scene).count, 2000u);
    EXPECT_EQ(scene.lights.size(), 200u);
    for (const scene::Light& light : scene.lights) {
        EXPECT_EQ(light.type, scene::LightType::Point);
        EXPECT_GT(light.intensity, 0.0f);
    }
}

TEST(OwnScenes, NestedDielectricsRankGlassIceDrink) {
    std::map<std::string, uint32_t> priorities;
    for (const scene::Material& material : OwnScene("nested_dielectrics.gltf").materials)
        if (material.BoundsMedium()) priorities[material.name] = material.priority;
    EXPECT_EQ(priorities, (std::map<std::string, uint32_t>{{"drink", 1}, {"glass", 3}, {"ice", 2}}));
}

// Otherwise a ray could enter a medium and never leave it. Every edge is run through once each way; fronts
// face outwards, so that the volume counted by signed tetrahedra is positive.
TEST(OwnScenes, SurfacesOfMediaAreClosedAndFaceOutwards) {
    size_t count = 0;
    for (const char* name :
         {"glass_sphere.gltf", "material_row.gltf", "nested_dielectrics.gltf", "scattering_grid.gltf"}) {
        const scene::SceneData scene = OwnScene(name);
        for (const scene::Mesh& mesh : scene.meshes)
            for (const scene::Primitive& primitive : mesh.primitives) {
                if (!scene.materials[primitive.material].BoundsMedium()) continue;
                using Point = std::array<float, 3>;
                std::map<std::pair<Point, Point>, int> edges;
                double volume = 0.0;
                for (size_t i = 0; i < primitive.indices.size(); i += 3) {
                    std::array<glm::vec3, 3> corners;
                    for (size_t k = 0; k < 3; ++k)
                        corners[k] = primitive.positions[primitive.indices[i + k]] + glm::vec3(0.0f);
                    volume += glm::dot(corners[0], glm::cross(corners[1], corners[2])) / 6.0;
                    for (size_t k = 0; k < 3; ++k) {
                        const glm::vec3 a = corners[k], b = corners[(k + 1) % 3];
                        ++edges[{{a.x, a.y, a.z}, {b.x, b.y, b.z}}];
                    }
                }
                for (const auto& [edge, uses] : edges) {
                    ASSERT_EQ(uses, 1) << name << " " << mesh.name;
                    ASSERT_EQ(edges.count({edge.second, edge.first}), 1u) << name << " " << mesh.name;
                }
                EXPECT_GT(volume, 0.0) << name << " " << mesh.name;
                ++count;
            }
    }
    EXPECT_EQ(count, 41u);
}

// "| known.glb | ... | 12 / 1500 | ..." rows of the manifest: file name to triangle counts.
struct ManifestRow {
    std::string file;
    uint64_t uniqueTriangles = 0;
    uint64_t placedTriangles = 0;
};

std::vector<ManifestRow> ReadManifest(const fs::path& path) {
    std::vector<ManifestRow> rows;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::vector<std::string> cells;
        std::stringstream stream(line);
        for (std::string cell; std::getline(stream, cell, '|');) cells.push_back(cell);
        ManifestRow row;
        char slash = 0;
        if (cells.size() < 6) continue;
        std::stringstream counts(cells[5]);
        if (!(counts >> row.uniqueTriangles >> slash >> row.placedTriangles) || slash != '/') continue;
        std::stringstream(cells[1]) >> row.file;
        rows.push_back(row);
    }
    return rows;
}

TEST(ReferenceScenes, HaveTheTriangleCountsOfTheirManifest) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    const fs::path scenes = *ReferenceAssets() / "scenes";
    size_t count = 0;
    for (const ManifestRow& row : ReadManifest(scenes / "MANIFEST.md")) {
        const bool isFolder = row.file.ends_with('/');
        const fs::path path = fs::exists(scenes / "known" / row.file) ? scenes / "known" / row.file
                                                                      : scenes / "large" / row.file;
        ASSERT_TRUE(fs::exists(path)) << row.file;
        ++count;
        if (isFolder) continue;
        const scene::SceneStatistics statistics = scene::Statistics(scene::LoadGltf(path));
        EXPECT_EQ(statistics.uniqueTriangles, row.uniqueTriangles) << row.file;
        EXPECT_EQ(statistics.placedTriangles, row.placedTriangles) << row.file;
    }
    EXPECT_GE(count, 30u) << "the manifest was not understood";
}

TEST(ReferenceScenes, PrimitiveModesDrawTwoTrianglesOrNone) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    for (int i = 0; i < 16; ++i) {
        const std::string name =
            std::string("Mesh_PrimitiveMode_") + (i < 10 ? "0" : "") + std::to_string(i) + ".gltf";
        const scene::SceneData scene =
            scene::LoadGltf(*ReferenceAssets() / "scenes/known/Mesh_PrimitiveMode" / name);
        // The generator's table: 0 to 3 and 7 to 10 are points, lines, loops and strips of lines.
        const bool isSolid = (i >= 4 && i <= 6) || i >= 11;
        EXPECT_EQ(scene::Statistics(scene).placedTriangles, isSolid ? 2u : 0u) << name;
        EXPECT_EQ(scene.warnings.size(), isSolid ? 0u : 1u) << name;
        for (const scene::Instance& instance : scene.instances)
            for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives)
                for (const glm::vec3& normal : primitive.normals)
                    EXPECT_NEAR(normal.z, 1.0f, 1e-6f)
                        << name << ": the quad faces +z, so every winding is right";
    }
}

TEST(ReferenceScenes, NormalTangentTestGetsTangentsThatFollowItsTextureCoordinates) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    const scene::SceneData scene = scene::LoadGltf(*ReferenceAssets() / "scenes/known/NormalTangentTest.glb");
    size_t triangleCount = 0;
    for (const scene::Mesh& mesh : scene.meshes)
        for (const scene::Primitive& primitive : mesh.primitives) {
            ASSERT_EQ(primitive.tangents.size(), primitive.positions.size());
            for (size_t i = 0; i < primitive.tangents.size(); ++i) {
                const glm::vec3 tangent(primitive.tangents[i]);
                ASSERT_NEAR(glm::length(tangent), 1.0f, 1e-5f);
                ASSERT_NEAR(glm::dot(tangent, primitive.normals[i]), 0.0f, 1e-4f);
            }
            for (size_t i = 0; i < primitive.indices.size(); i += 3) {
                const uint32_t* corner = &primitive.indices[i];
                const glm::vec2 a = primitive.uv0[corner[1]] - primitive.uv0[corner[0]];
                const glm::vec2 b = primitive.uv0[corner[2]] - primitive.uv0[corner[0]];
                const float area = a.x * b.y - a.y * b.x;
                if (area == 0.0f) continue;
                const glm::vec3 alongU =
                    (b.y * (primitive.positions[corner[1]] - primitive.positions[corner[0]]) -
                     a.y * (primitive.positions[corner[2]] - primitive.positions[corner[0]])) /
                    area;
                for (size_t k = 0; k < 3; ++k) {
                    const glm::vec4& tangent = primitive.tangents[corner[k]];
                    EXPECT_GT(glm::dot(glm::vec3(tangent), glm::normalize(alongU)), 0.5f);
                    EXPECT_EQ(tangent.w, area < 0.0f ? 1.0f : -1.0f);
                }
                ++triangleCount;
            }
        }
    EXPECT_GT(triangleCount, 7000u);
}

// A reader that refuses nothing but writes down what is read.
class Recorder final : public scene::FileReader {
  public:
    std::vector<std::byte> Read(const fs::path& path, uint64_t maxBytes) override {
        reads.push_back(path);
        if (path == replacedPath) return replacement;
        return m_disk.Read(path, maxBytes);
    }
    std::vector<fs::path> reads;
    fs::path replacedPath;
    Bytes replacement;

  private:
    scene::DiskFileReader m_disk;
};

// Loads; checks that it ends well or with one line, and that every read was below the file's folder.
bool LoadsOrIsRefused(const fs::path& file, Recorder& reader) {
    bool isLoaded = false;
    scene::LoadOptions options;
    options.reader = &reader;
    try {
        scene::LoadGltf(file, options);
        isLoaded = true;
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_TRUE(error.Kind() == ErrorKind::BadInput || error.Kind() == ErrorKind::Io) << message;
        EXPECT_EQ(message.find(file.filename().string() + ": "), 0u) << message;
        EXPECT_EQ(message.find_first_of("\n\r\x1b"), std::string::npos) << message;
        EXPECT_LT(message.size(), 500u) << message;
    }
    const std::string folder = fs::canonical(file.parent_path()).string() + "/";
    for (const fs::path& path : reader.reads)
        EXPECT_TRUE(path.string().starts_with(folder)) << file << " read " << path;
    return isLoaded;
}

TEST(MalformedScenes, LoadOrEndWithOneLine) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    size_t loadedCount = 0, refusedCount = 0;
    for (const fs::path& file : SceneFiles(*ReferenceAssets() / "scenes/bad")) {
        Recorder reader;
        ++(LoadsOrIsRefused(file, reader) ? loadedCount : refusedCount);
    }
    EXPECT_GT(loadedCount, 100u);
    EXPECT_GT(refusedCount, 50u);
}

// Most of those files place nothing, so nothing of them would be decoded: here everything is placed and used.
TEST(MalformedScenes, LoadOrEndWithOneLineWithEverythingPlaced) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    size_t changedCount = 0, refusedCount = 0;
    for (const fs::path& file : SceneFiles(*ReferenceAssets() / "scenes/bad")) {
        std::ifstream stream(file);
        Json json = Json::parse(stream, nullptr, false);
        if (!json.is_object()) continue;
        const auto count = [&](const char* key) { return json[key].is_array() ? json[key].size() : 0; };
        const size_t meshCount = count("meshes"), imageCount = count("images"),
                     bufferCount = count("buffers");
        if (meshCount + imageCount + bufferCount == 0 || json["nodes"].is_array()) continue;
        for (const char* key :
             {"meshes", "images", "buffers", "bufferViews", "accessors", "materials", "textures"})
            if (json[key].is_null()) json.erase(key);
        json["nodes"] = Json::array();
        json.erase("scene");
        json.erase("scenes");
        for (size_t i = 0; i < meshCount; ++i) json["nodes"].push_back({{"mesh", i}});
        for (size_t i = 0; i < imageCount; ++i) {
            json["textures"].push_back({{"source", i}});
            json["materials"].push_back({{"emissiveTexture", {{"index", json["textures"].size() - 1}}}});
            json["accessors"].push_back({{"componentType", kFloat}, {"count", 3}, {"type", "VEC3"}});
            json["meshes"].push_back({{"primitives",
                                       {{{"attributes", {{"POSITION", json["accessors"].size() - 1}}},
                                         {"material", json["materials"].size() - 1}}}}});
            json["nodes"].push_back({{"mesh", json["meshes"].size() - 1}});
        }
        for (size_t i = 0; i < bufferCount; ++i) {
            // One byte of the buffer as an index of nothing: it must be opened to be checked.
            json["bufferViews"].push_back({{"buffer", i}, {"byteLength", 1}});
            json["accessors"].push_back({{"bufferView", json["bufferViews"].size() - 1},
                                         {"componentType", kUint8},
                                         {"count", 1},
                                         {"type", "SCALAR"}});
            json["accessors"].push_back({{"componentType", kFloat}, {"count", 256}, {"type", "VEC3"}});
            json["meshes"].push_back({{"primitives",
                                       {{{"attributes", {{"POSITION", json["accessors"].size() - 1}}},
                                         {"indices", json["accessors"].size() - 2}}}}});
            json["nodes"].push_back({{"mesh", json["meshes"].size() - 1}});
        }
        Recorder reader;
        reader.replacedPath = fs::canonical(file);
        reader.replacement = ToBytes(json.dump());
        refusedCount += LoadsOrIsRefused(file, reader) ? 0 : 1;
        ++changedCount;
    }
    EXPECT_GT(changedCount, 80u);
    EXPECT_GT(refusedCount, 40u);
}

// Errors of displayed data, as the corpus calls them, must be refused or repaired, not passed on.
TEST(MalformedScenes, IndexBeyondTheVerticesIsNamed) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    const fs::path file =
        *ReferenceAssets() / "scenes/bad/gltf-validator/base/data/mesh_data/index_buffer_oob.gltf";
    std::ifstream stream(file);
    Json json = Json::parse(stream);
    json["nodes"] = {{{"mesh", 0}}};
    Recorder reader;
    reader.replacedPath = fs::canonical(file);
    reader.replacement = ToBytes(json.dump());
    scene::LoadOptions options;
    options.reader = &reader;
    const std::string text =
        testing::ErrorTextOf([&] { scene::LoadGltf(file, options); }, ErrorKind::BadInput);
    EXPECT_NE(text.find("but POSITION has"), std::string::npos) << text;
}

}  // namespace
}  // namespace raygraph::test::reference_scenes_test

// Valid files with a few bytes changed: each loads or ends with one line, and nothing is read outside the
// folder. Worth most under AddressSanitizer and UndefinedBehaviorSanitizer.
namespace raygraph::test::mutation_test {
namespace {

using Random = std::mt19937;

uint32_t Below(Random& random, size_t bound) {
    return static_cast<uint32_t>(random() % bound);
}

// A skin, morph targets and animations of the first node and others.
void AddMotion(GltfDocument& document) {
    const size_t joints = document.AddAccessor<uint8_t>({0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0}, 4);
    const size_t weights =
        document.AddAccessor<uint8_t>({155, 100, 0, 0, 255, 0, 0, 0, 200, 55, 0, 0}, 4, true);
    const size_t binds = AddMatrices(document, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                                1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1});
    const size_t shifts = document.AddAccessor<int16_t>({1, 2, 3, 0, 0, 0, -4, 5, -6}, 3);
    for (Json& primitive : document.json["meshes"][0]["primitives"]) {
        primitive["attributes"].update({{"JOINTS_0", joints}, {"WEIGHTS_0", weights}});
        primitive["targets"] = {{{"POSITION", shifts}},
                                {{"POSITION", shifts}, {"NORMAL", 1}, {"TANGENT", 1}}};
    }
    document.json["meshes"][0]["weights"] = {0.5, -1};
    document.json["nodes"][0].update({{"skin", 0}, {"weights", {1, 0}}});
    document.Add("skins", {{"joints", {1, 3}}, {"inverseBindMatrices", binds}, {"skeleton", 1}});
    const size_t times = document.AddAccessor<float>({0, 0.5, 2}, 1);
    const size_t vectors = document.AddAccessor<float>({1, 2, 3, 0, 0, 0, -1, 1, 1}, 3);
    const size_t turns = document.AddAccessor<int8_t>({0, 0, 0, 127, 127, 0, 0, 0, 0, 90, 90, 0}, 4, true);
    const size_t numbers = document.AddAccessor<uint8_t>({0, 1, 2}, 1);
    const size_t pairs = document.AddAccessor<float>({0, 1, 1, 0, 0.5f, 0.5f}, 1);
    const size_t splines = document.AddAccessor<float>(std::vector<float>(27, 0.25f), 3);
    const auto sampler = [&](size_t output, const char* interpolation) {
        return Json{{"input", times}, {"output", output}, {"interpolation", interpolation}};
    };
    const auto channel = [](size_t of, const Json& target) {
        return Json{{"sampler", of}, {"target", target}};
    };
    document.Add(
        "animations",
        {{"name", "all"},
         {"samplers",
          {sampler(vectors, "LINEAR"), sampler(turns, "LINEAR"), sampler(numbers, "STEP"),
           sampler(pairs, "LINEAR"), sampler(splines, "CUBICSPLINE")}},
         {"channels",
          {channel(0, {{"node", 1}, {"path", "translation"}}),
           channel(1, {{"node", 3}, {"path", "rotation"}}), channel(4, {{"node", 3}, {"path", "scale"}}),
           channel(3, {{"node", 0}, {"path", "weights"}}),
           channel(2, Pointer("/nodes/3/extensions/KHR_node_visibility/visible")),
           channel(2, Pointer("/materials/0/pbrMetallicRoughness/metallicFactor")),
           channel(2,
                   Pointer("/materials/1/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor")),
           channel(2, Pointer("/cameras/0/perspective/yfov")),
           channel(0, Pointer("/extensions/KHR_lights_punctual/lights/0/color")),
           channel(2, Pointer("/materials/0/normalTexture/extensions/KHR_texture_transform/rotation"))}}});
}

// A file that uses a bit of everything.
GltfDocument RichDocument() {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"]["TEXCOORD_0"] =
        document.AddAccessor<uint16_t>({0, 0, 65535, 0, 0, 65535}, 2, true);
    primitive["attributes"]["COLOR_0"] =
        document.AddAccessor<uint8_t>({9, 8, 7, 255, 0, 1, 2, 255, 3, 4, 5, 255}, 4, true);
    primitive["attributes"]["TANGENT"] =
        document.AddAccessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1}, 4);
    primitive["indices"] = document.AddAccessor<uint16_t>({0, 1, 2}, 1);
    primitive["mode"] = 5;
    primitive["material"] = document.AddMaterial(
        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0.5}}},
         {"normalTexture",
          {{"index", 0},
           {"scale", 2},
           {"extensions",
            {{"KHR_texture_transform", {{"offset", {0, 1}}, {"rotation", 1}, {"scale", {1, 2}}}}}}}},
         {"alphaMode", "MASK"},
         {"extensions", MaterialExtensions()},
         {"extras", {{"priority", 3}}}});
    document.AddMaterial({{"extensions",
                           {{"KHR_materials_pbrSpecularGlossiness",
                             {{"diffuseFactor", {1, 0.5, 0.25, 1}},
                              {"glossinessFactor", 0.5},
                              {"specularGlossinessTexture", {{"index", 0}}}}},
                            {"KHR_materials_unlit", Json::object()}}}});
    document.Add("images", {{"uri", DataUri(MakePng(3, 3, {1, 2, 3, 4}))}});
    document.Add("samplers", {{"minFilter", 9987}, {"wrapS", 33071}});
    document.Add("textures", {{"source", 0}, {"sampler", 0}});
    document.Add("images", {{"uri", DataUri(MakePlainDds(2, 2, {1, 2, 3, 4}))}});
    document.Add("textures", {{"extensions", {{"MSFT_texture_dds", {{"source", 1}}}}}, {"source", 0}});
    const size_t indexView = document.AddBufferView(BytesOf<uint8_t>({0, 2}));
    const size_t valueView = document.AddBufferView(BytesOf<float>({1, 2, 3, 4, 5, 6}));
    document.json["accessors"][0]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", indexView}, {"componentType", kUint8}}},
        {"values", {{"bufferView", valueView}}}};
    document.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "spot"}, {"spot", Json::object()}}};
    document.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "a"}}, {{"name", "b"}}};
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 0}, {"variants", {1, 0}}}};
    document.json["extensions"]["EXT_lights_ies"]["lights"] = Json::array(
        {{{"uri", DataUri(ToBytes(IesText{.vertical = {0, 30, 90}, .horizontal = {0, 90}}.Text()))},
          {"mimeType", "application/x-ies-lm-63"}}});
    document.json["extensions"]["EXT_lights_image_based"]["lights"] =
        Json::array({{{"intensity", 2},
                      {"rotation", {0, 1, 0, 0}},
                      {"irradianceCoefficients", Json(9, Json{1, 0.5, 0})},
                      {"specularImageSize", 2},
                      {"specularImages", Json::array({Json(6, 0), Json(6, 0)})}}});
    document.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
    Json line = primitive;
    line["mode"] = 3;
    document.json["meshes"][0]["primitives"].push_back(line);
    document.AddNode({{"camera", 0}, {"children", {2, 3}}, {"rotation", {0, 0, 0, 1}}});
    document.Add("nodes", {{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
    document.Add("nodes", {{"extensions",
                            {{"KHR_lights_punctual", {{"light", 0}}},
                             {"EXT_lights_ies", {{"light", 0}, {"multiplier", 2}, {"color", {1, 0.5, 0}}}},
                             {"KHR_node_visibility", {{"visible", false}}}}},
                           {"scale", {1, 2, -3}}});
    AddMotion(document);
    const size_t places = document.AddAccessor<float>({1, 2, 3, 4, 5, 6}, 3);
    const size_t turns = document.AddAccessor<int8_t>({0, 0, 0, 127, 127, 0, 0, 0}, 4, true);
    document.AddNode(
        {{"mesh", 0},
         {"extensions",
          {{"EXT_mesh_gpu_instancing",
            {{"attributes", {{"TRANSLATION", places}, {"ROTATION", turns}, {"SCALE", places}}}}}}}});
    return document;
}

// Collects all values of the tree, containers included.
void Collect(Json& value, std::vector<Json*>& out) {
    out.push_back(&value);
    if (value.is_structured())
        for (Json& child : value) Collect(child, out);
}

Json HostileValue(Random& random) {
    switch (Below(random, 14)) {
        case 0:
            return nullptr;
        case 1:
            return -1;
        case 2:
            return 0;
        case 3:
            return 1;
        case 4:
            return 4294967295u;
        case 5:
            return 18446744073709551615u;
        case 6:
            return 9223372036854775807;
        case 7:
            return 1e308;
        case 8:
            return 0.5;
        case 9:
            return "..";
        case 10:
            return Json::array();
        case 11:
            return Json::object();
        case 12:
            return true;
        default:
            return Below(random, 12);
    }
}

class Mutations : public ::testing::Test {
  protected:
    void LoadMutant(const Bytes& file) {
        scene::LoadOptions options;
        // Small, so that a mutant that claims much costs little time.
        options.limits.maxGeometryBytes = 1 << 20;
        options.limits.maxAllImageTexels = 1 << 20;
        options.limits.maxImageTexels = 1 << 20;
        options.pointsAndLines = {.points = {.value = 0.1f}, .lines = {.value = 0.1f, .isRelative = true}};
        options.reader = &m_folder;
        m_folder.replacements[m_path] = file;
        try {
            scene::SceneData scene = scene::LoadGltf(m_path, options);
            Play(scene);
            for (const scene::Instance& instance : scene.instances) {
                for (const scene::Primitive& primitive : scene.meshes.at(instance.mesh).primitives) {
                    const bool isRound = primitive.IsRound();
                    ASSERT_EQ(primitive.indices.size() % (isRound ? 2 : 3), 0u);
                    ASSERT_TRUE(!isRound || primitive.indices.size() == 2 * primitive.radii.size());
                    ASSERT_LT(primitive.material, scene.materials.size());
                    ASSERT_EQ(primitive.normals.size(), isRound ? 0 : primitive.positions.size());
                    for (const uint32_t index : primitive.indices)
                        ASSERT_LT(index, primitive.positions.size());
                }
            }
            ++m_loadedCount;
        } catch (const Error& error) {
            ASSERT_TRUE(error.Kind() == ErrorKind::BadInput) << error.what();
            const std::string message = error.what();
            ASSERT_EQ(message.find("scene.gltf: "), 0u) << message;
            ASSERT_EQ(message.find_first_of("\n\r\x1b"), std::string::npos) << message;
            ++m_refusedCount;
        }
        for (const std::filesystem::path& read : m_folder.reads)
            ASSERT_EQ(read.parent_path(), m_folder.Path());
        m_folder.reads.clear();
    }

    // Whatever the values of an animation are, the scene must stay drawable.
    static void Play(scene::SceneData& scene) {
        scene::PoseEvaluator evaluator(scene);
        scene::PoseApplier applier(scene);
        for (uint32_t i = 0; i < scene.animations.size(); ++i)
            for (const double share : {0.0, 0.3, 1.0}) {
                const std::array clips{
                    scene::ClipState{i, share * double{scene.animations[i].duration}, 0.75f}};
                if (!scene.animations[i].defect.empty()) {
                    EXPECT_THROW(evaluator.Evaluate(scene, clips), Error);
                    continue;
                }
                applier.Apply(scene, evaluator.Evaluate(scene, clips));
                scene::Check(scene, "scene.gltf", ErrorKind::Usage);
            }
        scene::DeformedStreams streams;
        for (const scene::Instance& instance : scene.instances)
            for (const scene::Primitive& primitive : scene.meshes.at(instance.mesh).primitives)
                scene::DeformPrimitive(primitive, scene::MorphWeights(scene, instance),
                                       applier.JointMatricesOf(scene.nodes.at(instance.node).skin), streams);
    }

    // Both outcomes must occur: otherwise the mutations test nothing.
    void ExpectBothOutcomes() {
        EXPECT_GT(m_loadedCount, 0u);
        EXPECT_GT(m_refusedCount, 0u);
    }

    SceneFolder m_folder;
    const std::filesystem::path m_path = m_folder.Write("scene.gltf", "");
    size_t m_loadedCount = 0;
    size_t m_refusedCount = 0;
};

constexpr int kRounds = 3000;

// Otherwise animations and skins would not be mutated.
TEST(RichDocument, NothingThatMovesIsLeftOut) {
    const scene::SceneData scene = Load(RichDocument());
    EXPECT_EQ(scene.nodes[0].skin, 0u);
    EXPECT_EQ(scene.meshes[0].primitives[0].influences.perVertex, 2u);
    EXPECT_EQ(scene.meshes[0].primitives[0].targets.size(), 2u);
    ASSERT_EQ(scene.animations.size(), 1u);
    EXPECT_EQ(scene.animations[0].channels.size(), 10u);
}

TEST_F(Mutations, ChangedBytesOfAGlbNeverCrash) {
    GltfDocument document = RichDocument();
    const Bytes binary = BytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
    document.json["buffers"][0].erase("uri");
    const Bytes original = MakeGlb(document.Text(), &binary);
    LoadMutant(original);
    ASSERT_EQ(m_loadedCount, 1u);
    Random random(1);
    for (int round = 0; round < kRounds; ++round) {
        Bytes mutant = original;
        for (uint32_t i = 0; i < 1 + Below(random, 4); ++i)
            mutant[Below(random, mutant.size())] = static_cast<std::byte>(random());
        if (Below(random, 8) == 0) mutant.resize(Below(random, mutant.size()));
        ASSERT_NO_FATAL_FAILURE(LoadMutant(mutant)) << "round " << round;
    }
    ExpectBothOutcomes();
}

TEST_F(Mutations, ChangedValuesOfTheJsonNeverCrash) {
    const GltfDocument original = RichDocument();
    Random random(2);
    for (int round = 0; round < kRounds; ++round) {
        Json mutant = original.json;
        for (uint32_t i = 0; i < 1 + Below(random, 2); ++i) {
            std::vector<Json*> values;
            Collect(mutant, values);
            *values[1 + Below(random, values.size() - 1)] = HostileValue(random);
        }
        ASSERT_NO_FATAL_FAILURE(LoadMutant(ToBytes(mutant.dump())))
            << "round " << round << ": " << mutant.dump();
    }
    ExpectBothOutcomes();
}

TEST_F(Mutations, ExchangedDigitsOfTheTextNeverCrash) {
    const std::string original = RichDocument().Text();
    Random random(3);
    for (int round = 0; round < kRounds; ++round) {
        std::string mutant = original;
        for (int i = 0; i < 3;) {
            char& c = mutant[Below(random, mutant.size())];
            if (c < '0' || c > '9') continue;
            c = "0123456789.-e"[Below(random, 13)];
            ++i;
        }
        ASSERT_NO_FATAL_FAILURE(LoadMutant(ToBytes(mutant))) << "round " << round << ": " << mutant;
    }
    ExpectBothOutcomes();
}

}  // namespace
}  // namespace raygraph::test::mutation_test
