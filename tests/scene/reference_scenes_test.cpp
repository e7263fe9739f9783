// Whole files: our own in scenes/, and where RAYGRAPH_ASSETS names their folder, published ones and malformed
// ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>

#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/reference_assets.h"
#include "tests/support/source_file.h"

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
