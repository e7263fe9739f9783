// Tests the pictures of scenes/ in which the left square of each pair must look like the right one, and must
// no longer do so if the extension is removed from the file.
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/scene/gltf_document.h"
#include "tests/support/scene_render.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::grids_test {

namespace {

using test::Json;

constexpr uint32_t kPixelsAMeter = 16;
constexpr std::string_view kExpected = "expected ";

// Is a pair in the picture: the expected square; the tested one is as large, and left of it.
struct Pair {
    std::string name;
    uint32_t x = 0, y = 0, side = 0;
};

void Remove(Json& json, const std::string& extension) {
    if (json.is_object()) {
        if (const auto found = json.find("extensions"); found != json.end()) found->erase(extension);
        for (const char* list : {"extensionsUsed", "extensionsRequired"})
            if (const auto found = json.find(list); found != json.end())
                found->erase(std::remove(found->begin(), found->end(), extension), found->end());
    }
    if (json.is_structured())
        for (Json& child : json) Remove(child, extension);
}

class Grids : public VulkanTest {
  protected:
    Grids() { render.more = {}; }

    // Loads a scene, without these extensions, and finds its pairs.
    void Set(const std::string& name, const std::vector<std::string>& without = {}) {
        std::ifstream file(test::SourceFile("scenes/" + name));
        test::GltfDocument document;
        document.json = Json::parse(file);
        for (const std::string& extension : without) Remove(document.json, extension);
        scene::SceneData data = test::Load(document);
        ASSERT_EQ(data.cameras.size(), 1u);
        const scene::Camera& camera = data.cameras[0];
        settings.extent = {static_cast<uint32_t>(std::lround(2.0f * camera.xMag * kPixelsAMeter)),
                           static_cast<uint32_t>(std::lround(2.0f * camera.yMag * kPixelsAMeter))};
        settings.camera = ToRecord(scene::ViewOf(camera, camera.xMag / camera.yMag));
        pairs.clear();
        for (const scene::Instance& instance : data.instances) {
            const std::string& node = data.nodes[instance.node].name;
            if (!node.starts_with(kExpected)) continue;
            scene::Bounds bounds;
            for (const scene::Primitive& primitive : data.meshes[instance.mesh].primitives)
                bounds.Extend(primitive.bounds.Transformed(instance.objectToWorld));
            const auto pixel = [](float meters) {
                return static_cast<uint32_t>(std::lround(meters * kPixelsAMeter));
            };
            // The upper left corner of the picture is the origin.
            pairs.push_back({node.substr(kExpected.size()), pixel(bounds.min.x), pixel(-bounds.max.y),
                             pixel(bounds.max.x - bounds.min.x)});
        }
        render.scene.SetScene(std::move(data));
    }

    // Returns the pairs whose mean radiances differ by more than noise and `tolerance` explain. At the edges
    // pixels also see what is beside the squares.
    std::vector<std::string> DifferentMeans(uint32_t sampleCount, double tolerance, double errorLimit) {
        const RenderedImage seen = render.Render(settings, sampleCount);
        std::vector<std::string> names;
        glm::dvec3 allDifferences(0.0), allVariances(0.0);
        for (const Pair& pair : pairs) {
            const auto [tested, testedError] = MeanOf(seen, pair, pair.side);
            const auto [expected, expectedError] = MeanOf(seen, pair, 0);
            const glm::dvec3 error = glm::sqrt(testedError * testedError + expectedError * expectedError);
            EXPECT_LT(std::max({error.x, error.y, error.z}), errorLimit) << pair.name;
            allDifferences += tested - expected;
            allVariances += error * error;
            for (int c = 0; c < 3; ++c)
                if (std::abs(tested[c] - expected[c]) > 5.0 * error[c] + tolerance) {
                    names.push_back(pair.name + ": is " + TextOf(tested) + ", expected " + TextOf(expected) +
                                    ", standard error " + TextOf(error));
                    break;
                }
        }
        // A difference too small to be seen in one pair may be seen in all of them together
        const double count = double(pairs.size());
        for (int c = 0; c < 3 && names.empty(); ++c)
            if (std::abs(allDifferences[c]) > 5.0 * std::sqrt(allVariances[c]) + tolerance * count)
                names.push_back("all: differ by " + TextOf(allDifferences / count) + " on average");
        return names;
    }

    // Returns the pairs whose albedo or normals differ in any pixel.
    std::vector<std::string> DifferentHits(float tolerance) {
        const SceneRender::Hits hits = render.PrimaryHits(settings);
        std::vector<std::string> names;
        for (const Pair& pair : pairs) {
            std::string line;
            for (uint32_t i = 0; i < pair.side * pair.side && line.empty(); ++i) {
                const uint32_t x = pair.x + i % pair.side, y = pair.y + i / pair.side;
                for (const FloatImage* image : {&hits.albedo, &hits.normal}) {
                    const glm::vec3 tested = image->At(x - pair.side, y), expected = image->At(x, y);
                    if (glm::distance(tested, expected) <= tolerance) continue;
                    line = pair.name + ": " + (image == &hits.albedo ? "albedo" : "normal") + " of pixel " +
                           TextOf({i % pair.side, i / pair.side, 0}) + " is " + TextOf(tested) +
                           ", expected " + TextOf(expected);
                }
            }
            if (!line.empty()) names.push_back(line);
        }
        return names;
    }

    SceneRender render{Device()};
    passes::TraceSettings settings;
    std::vector<Pair> pairs;

  private:
    // Returns the mean over the square `left` pixels left of the pair's, without its edge, and its standard
    // error.
    static std::pair<glm::dvec3, glm::dvec3> MeanOf(const RenderedImage& image, const Pair& pair,
                                                    uint32_t left) {
        glm::dvec3 sum(0.0), variance(0.0);
        for (uint32_t y = pair.y + 1; y + 1 < pair.y + pair.side; ++y)
            for (uint32_t x = pair.x + 1; x + 1 < pair.x + pair.side; ++x) {
                sum += glm::dvec3(image.mean.At(x - left, y));
                variance += glm::dvec3(image.variance.At(x - left, y)) / double(image.sampleCount);
            }
        const double count = double(pair.side - 2) * double(pair.side - 2);
        return {sum / count, glm::sqrt(variance) / count};
    }
    static std::string TextOf(const glm::vec3& value) {
        std::ostringstream text;
        text << '(' << value.x << ' ' << value.y << ' ' << value.z << ')';
        return text.str();
    }
};

std::string Lines(const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    return text;
}

}  // namespace

TEST_F(Grids, Trace_SlabsOfScatteringMediaReturnWhatDoublingComputes) {
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    Set("scattering_grid.gltf");
    ASSERT_EQ(pairs.size(), 30u);
    EXPECT_EQ(Lines(DifferentMeans(16, 0.002, 0.03)), "");
    // Light that is not scattered is attenuated by e^-depth.
    Set("scattering_grid.gltf", {"KHR_materials_volume_scatter"});
    EXPECT_EQ(DifferentMeans(4, 0.002, 0.03).size(), 30u);
}

TEST_F(Grids, Trace_SheetsPassAndReflectTheirSharesOfLight) {
    Set("diffuse_transmission_grid.gltf");
    ASSERT_EQ(pairs.size(), 15u);
    EXPECT_EQ(Lines(DifferentMeans(64, 0.002, 0.012)), "");
    Set("diffuse_transmission_grid.gltf", {"KHR_materials_diffuse_transmission"});
    EXPECT_EQ(DifferentMeans(32, 0.002, 0.02).size(), 12u) << "all but those that transmit nothing";
}

TEST_F(Grids, Trace_LayersReflectAndPassWhatTheirFormulasSay) {
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    Set("layers_grid.gltf");
    ASSERT_EQ(pairs.size(), 40u);
    EXPECT_EQ(Lines(DifferentMeans(16, 0.003, 0.01)), "");
    Set("layers_grid.gltf", {"KHR_materials_clearcoat", "KHR_materials_sheen", "KHR_materials_ior",
                             "KHR_materials_transmission"});
    EXPECT_EQ(DifferentMeans(16, 0.003, 0.01).size(), 30u) << "all but metal and the specular layer";
    Set("layers_grid.gltf", {"KHR_materials_specular"});
    EXPECT_GE(DifferentMeans(16, 0.003, 0.01).size(), 5u);
}

// The spectra of linear sRGB are sums of Gaussians in the shader: shaders/bxdf/thin_film.glsl.
TEST_F(Grids, Trace_FilmsReflectTheColorsOfAirysFormula) {
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    Set("films_grid.gltf");
    ASSERT_EQ(pairs.size(), 24u);
    EXPECT_EQ(Lines(DifferentMeans(4, 0.012, 0.005)), "");
    Set("films_grid.gltf", {"KHR_materials_iridescence"});
    EXPECT_EQ(DifferentMeans(4, 0.012, 0.005).size(), 24u);
}

TEST_F(Grids, EveryTextureFormatShowsThePicture) {
    Set("texture_formats_grid.gltf");
    ASSERT_EQ(pairs.size(), 24u);
    constexpr float kTolerance =
        3e-3f;  // Less than a step of eight bits: devices need not round BC7 to these.
    EXPECT_EQ(Lines(DifferentHits(kTolerance)), "");
    const auto without = [&](const char* extension) {
        Set("texture_formats_grid.gltf", {extension});
        return DifferentHits(kTolerance).size();
    };
    EXPECT_EQ(without("EXT_texture_webp"), 1u);
    EXPECT_EQ(without("KHR_texture_basisu"), 12u);
    EXPECT_EQ(without("MSFT_texture_dds"), 9u);
}

TEST_F(Grids, TextureCoordinatesAreTransformedAndChosen) {
    Set("texture_coordinates_grid.gltf");
    ASSERT_EQ(pairs.size(), 8u);
    EXPECT_EQ(Lines(DifferentHits(1e-6f)), "");
    EXPECT_EQ(Lines(DifferentMeans(16, 0.002, 0.02)), "");
    Set("texture_coordinates_grid.gltf", {"KHR_texture_transform"});
    EXPECT_EQ(DifferentHits(1e-6f).size(), 6u) << "all but the one of the core format, and emission";
    EXPECT_NE(Lines(DifferentMeans(16, 0.002, 0.02)).find("EMISSION"), std::string::npos);
}

// Each variant shows the row of its name, and no other.
TEST_F(Grids, VariantsShowTheirRows) {
    const std::array names{"NO VARIANT", "DAY", "NIGHT", "RUST"};
    for (uint32_t shown = 0; shown < names.size(); ++shown) {
        Set("variants_grid.gltf");
        ASSERT_EQ(pairs.size(), 16u);
        render.scene.SetVariant(shown == 0 ? scene::kNone : shown - 1);
        const std::string different = Lines(DifferentHits(1e-6f));
        for (uint32_t row = 0; row < names.size(); ++row)
            EXPECT_EQ(different.find(names[row]) == different.npos, row == shown)
                << "of " << names[shown] << ":\n"
                << different;
    }
}

TEST_F(Grids, StoredMeshesAreThePlainOne) {
    Set("meshes_grid.gltf");
    ASSERT_EQ(pairs.size(), 10u);
    EXPECT_EQ(Lines(DifferentHits(2e-3f)), "") << "normals of 8 bits are made unit vectors";
    for (const char* extension : {"KHR_draco_mesh_compression", "EXT_mesh_gpu_instancing"}) {
        Set("meshes_grid.gltf", {extension});
        EXPECT_EQ(DifferentHits(2e-3f).size(), 1u) << extension;
    }
}

}  // namespace raygraph::testing::grids_test
