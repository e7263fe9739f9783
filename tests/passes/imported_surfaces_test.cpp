// From the vertices, images and samplers of a glTF file to what is seen of a surface.
#include "tests/passes/gltf_square.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::imported_surfaces_test {

namespace {

class ImportedSurfaces : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

}  // namespace

// What a vertex of the file says is what is seen there: colors and both sets of coordinates, of bytes and
// shorts too.
TEST_F(ImportedSurfaces, VertexAttributesOfEveryWidthAreSeen) {
    // Rows from the top: black, dark, light, white, by levels that sRGB encodes as 0, 64, 128 and 255
    const test::Bytes rows =
        test::MakePngOf(1, 4, {0, 0, 0, 255, 64, 64, 64, 255, 128, 128, 128, 255, 255, 255, 255, 255});
    const float levels[] = {0.0f, 0.0513f, 0.2159f, 1.0f};
    for (const int set : {0, 1}) {
        GltfDocument document;
        const Json nearest{{"magFilter", 9728}, {"minFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33071}};
        const size_t texture = AddTexture(document, rows, nearest);
        document.AddMaterial(
            {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}, {"texCoord", set}}}}}});
        Json primitive = Square(document, {}, 0);
        // Set 0: bytes, left column the second row, right column the last. Set 1: shorts, first and third
        primitive["attributes"]["TEXCOORD_0"] =
            document.AddAccessor<uint8_t>({0, 96, 0, 224, 0, 224, 0, 96}, 2, true);
        primitive["attributes"]["TEXCOORD_1"] =
            document.AddAccessor<uint16_t>({0, 8192, 0, 40960, 0, 40960, 0, 8192}, 2, true);
        primitive["attributes"]["COLOR_0"] = document.AddAccessor<uint8_t>(
            {255, 128, 0, 255, 255, 128, 0, 255, 255, 128, 0, 255, 255, 128, 0, 255}, 4, true);
        document.AddNode({{"mesh", document.AddMesh(primitive)}});
        render.scene.SetScene(test::Load(document));
        const FloatImage albedo = render.PrimaryHits(Facing(2.0f, 16)).albedo;
        const float left = levels[set == 0 ? 1 : 0], right = levels[set == 0 ? 3 : 2];
        const glm::vec3 color(1.0f, 128.0f / 255.0f, 0.0f);
        ExpectNear(albedo.At(0, 5), left * color, 3e-3f, "left");
        ExpectNear(albedo.At(15, 5), right * color, 3e-3f, "right");
    }
}

// glTF 2.0, 3.9.3: the green channel points up in texture space, that is to the image's top. The tangents are
// made by the importer.
TEST_F(ImportedSurfaces, NormalMapIsBumpyTowardsTheImagesTopAndRight) {
    // How the image lies on the square: upright, mirrored from left to right, upside down
    const std::vector<float> kMirrored{1, 1, 0, 1, 0, 0, 1, 0}, kUpsideDown{0, 0, 1, 0, 1, 1, 0, 1};
    const glm::vec3 read = 2.0f * glm::vec3(140, 155, 250) / 255.0f - 1.0f;
    const std::pair<std::vector<float>, glm::vec3> kCases[] = {{kUpright, {read.x, read.y, read.z}},
                                                               {kMirrored, {-read.x, read.y, read.z}},
                                                               {kUpsideDown, {read.x, -read.y, read.z}}};
    for (const auto& [uv, bent] : kCases) {
        GltfDocument document;
        const size_t texture = AddTexture(document, test::MakePng(2, 2, {140, 155, 250, 255}));
        document.AddMaterial({{"normalTexture", {{"index", texture}}}});
        document.AddNode({{"mesh", document.AddMesh(Square(document, uv, 0))}});
        render.scene.SetScene(test::Load(document));
        ExpectNear(render.PrimaryHits(Facing(1.0f, 4)).normal.At(1, 1), glm::normalize(bent), 2e-3f,
                   "normal");
    }
}

// Wrap modes and filters by glTF's own numbers. The image: black, then white.
TEST_F(ImportedSurfaces, SamplersOfTheFileWrapAndFilterWhatIsSeen) {
    const test::Bytes png = test::MakePngOf(2, 1, {0, 0, 0, 255, 255, 255, 255, 255});
    constexpr int kRepeat = 10497, kMirror = 33648, kClamp = 33071, kNearest = 9728, kLinear = 9729;
    struct Case {
        int wrap, filter;
        float at[4];  // u = -0.375, 0.375, 0.875, 1.375
    };
    // Texel centers are at 0.25 and 0.75; what is asked for lies between centers a quarter or half of the way
    const Case kCases[] = {
        {kRepeat, kNearest, {1, 0, 1, 0}},
        {kMirror, kNearest, {0, 0, 1, 1}},
        {kClamp, kNearest, {0, 0, 1, 1}},
        {kRepeat, kLinear, {0.75f, 0.25f, 0.75f, 0.25f}},
        {kMirror, kLinear, {0.25f, 0.25f, 1, 0.75f}},
        {kClamp, kLinear, {0, 0.25f, 1, 1}},
    };
    for (const Case& expected : kCases)
        for (const bool isAlongU : {true, false}) {
            GltfDocument document;
            Json sampler{{"magFilter", expected.filter}};
            sampler[isAlongU ? "wrapS" : "wrapT"] = expected.wrap;
            sampler[isAlongU ? "wrapT" : "wrapS"] = expected.wrap == kClamp ? kRepeat : kClamp;
            const size_t texture = AddTexture(
                document, isAlongU ? png : test::MakePngOf(1, 2, {0, 0, 0, 255, 255, 255, 255, 255}),
                sampler);
            document.AddMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
            const float places[] = {-0.375f, 0.375f, 0.875f, 1.375f};
            for (size_t i = 0; i < 4; ++i) {
                std::vector<float> uv;
                for (int corner = 0; corner < 4; ++corner) {
                    uv.push_back(isAlongU ? places[i] : 0.5f);
                    uv.push_back(isAlongU ? 0.5f : places[i]);
                }
                document.AddNode({{"mesh", document.AddMesh(Square(document, uv, 0))},
                                  {"translation", {-3 + 2 * static_cast<int>(i), 0, 0}}});
            }
            render.scene.SetScene(test::Load(document));
            const FloatImage albedo = render.PrimaryHits(Facing(8.0f, 8)).albedo;
            for (uint32_t i = 0; i < 4; ++i)
                EXPECT_NEAR(albedo.At(2 * i, 3).y, expected.at[i], 0.01f)
                    << "wrap " << expected.wrap << ", filter " << expected.filter << ", at " << places[i]
                    << (isAlongU ? " along u" : " along v");
        }
}

}  // namespace raygraph::testing::imported_surfaces_test
