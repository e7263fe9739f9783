// KHR_materials_pbrSpecularGlossiness, from the file to what is seen.
#include <cmath>
#include <cstring>

#include "passes/raster.h"
#include "passes/views.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::glossiness_test {

namespace {

using test::GltfDocument;
using test::Json;

constexpr const char* kExtension = "KHR_materials_pbrSpecularGlossiness";
constexpr uint8_t kSpecular[2][4] = {{60, 130, 190, 90}, {210, 70, 110, 160}};  // and glossiness

class Glossiness : public VulkanTest {
  protected:
    // A square that fills the view, under two lights. Its texture coordinates point at the middle of either of
    // two texels.
    static GltfDocument Square(const Json& material, int texel = 0) {
        GltfDocument document;
        const size_t positions = document.AddAccessor<float>({-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0}, 3);
        const size_t normals = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
        const float u = texel == 0 ? 0.25f : 0.75f;
        const size_t uv = document.AddAccessor<float>({u, 0.5f, u, 0.5f, u, 0.5f, u, 0.5f}, 2);
        const size_t indices = document.AddAccessor<uint16_t>({0, 1, 2, 0, 2, 3}, 1);
        document.AddNode(
            {{"mesh", document.AddMesh(
                          {{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uv}}},
                           {"indices", indices},
                           {"material", document.AddMaterial(material)}})}});
        document.Add("images",
                     {{"uri", test::DataUri(test::MakePngOf(
                                  2, 1, std::vector<uint8_t>(&kSpecular[0][0], &kSpecular[0][0] + 8)))}});
        document.Add("samplers", {{"magFilter", 9728}, {"minFilter", 9728}});
        document.Add("textures", {{"source", 0}, {"sampler", 0}});
        document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
            {{"type", "directional"}, {"intensity", 3}},
            {{"type", "point"}, {"intensity", 20}, {"color", {1, 0.5, 0.25}}}};
        document.AddNode({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}},
                          {"rotation", {-0.25881905, 0, 0, 0.96592583}}});
        document.AddNode(
            {{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}, {"translation", {1, 0.5, 2}}});
        return document;
    }
    static passes::TraceSettings Facing() {
        scene::CameraView view = scene::CameraView::LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
        view.projection = scene::Projection::Orthographic;
        view.height = 1.5f;
        passes::TraceSettings settings;
        settings.extent = {8, 8};
        settings.camera = ToRecord(view);
        return settings;
    }

    struct Picture {
        FloatImage traced, raster, roughness;
        gpu::MaterialRecord record;
    };
    Picture Take(const GltfDocument& document) {
        Picture picture;
        render.scene.SetScene(test::Load(document));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.5f)});
        picture.traced = render.TraceOnce(Facing());
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, Facing(), passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, Facing(), seen, environment, {}));
        const Readback roughness = render.renderer.ReadBack(passes::SurfaceView(
            render.renderer, ids, Facing(),
            passes::TraceVisibility(render.renderer, ids, Facing(), passes::FilmPosition::Center),
            passes::View::Roughness));
        const Readback records = render.renderer.ReadBack(ids.materials);
        render.renderer.Execute();
        picture.raster = ToFloatImage(drawn);
        picture.roughness = ToFloatImage(roughness);
        records.Wait();
        std::memcpy(&picture.record, records.Bytes().data(), sizeof(picture.record));
        return picture;
    }
    static void ExpectAlike(const FloatImage& a, const FloatImage& b, float tolerance) {
        ASSERT_EQ(a.values.size(), b.values.size());
        for (size_t i = 0; i < a.values.size(); ++i)
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(a.values[i][c], b.values[i][c], tolerance * (1.0f + std::abs(b.values[i][c])))
                    << "pixel " << i << ", channel " << c;
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

TEST_F(Glossiness, PictureIsThatOfTheSameMaterialSaidOtherwise) {
    const Picture glossy = Take(Square({{"extensions",
                                         {{kExtension,
                                           {{"diffuseFactor", {0.75, 0.5, 0.25, 1}},
                                            {"specularFactor", {0.5, 0.25, 0.125}},
                                            {"glossinessFactor", 0.5}}}}}}));
    const Picture same = Take(Square(
        {{"pbrMetallicRoughness",
          {{"baseColorFactor", {0.75, 0.5, 0.25, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.5}}},
         {"extensions",
          {{"KHR_materials_ior", {{"ior", 0}}},
           {"KHR_materials_specular", {{"specularColorFactor", {0.5, 0.25, 0.125}}}}}}}));
    EXPECT_EQ(glossy.traced.values, same.traced.values);
    EXPECT_EQ(glossy.raster.values, same.raster.values);
    EXPECT_EQ(std::memcmp(&glossy.record, &same.record, sizeof(same.record)), 0);
    EXPECT_GT(glossy.traced.Mean().x, 0.1);
    // As without the extension it is not
    const Picture plain = Take(Square(Json::object()));
    EXPECT_NE(glossy.traced.values, plain.traced.values);
}

// Glossiness is linear, and scales that of the factor; the other channels are a color.
TEST_F(Glossiness, TexturesAlphaIsItsGlossiness) {
    const double factor = 0.75;
    for (const int texel : {0, 1}) {
        SCOPED_TRACE(texel);
        const Json base{{"diffuseFactor", {0.5, 0.5, 0.5, 1}}, {"glossinessFactor", factor}};
        Json textured = base, plain = base;
        textured["specularGlossinessTexture"]["index"] = 0;
        textured["specularFactor"] = {0.5, 1, 0.75};
        const double glossiness = factor * kSpecular[texel][3] / 255.0;
        plain["glossinessFactor"] = glossiness;
        const double share[3] = {0.5, 1.0, 0.75};
        for (size_t c = 0; c < 3; ++c) {
            const double stored = kSpecular[texel][c] / 255.0;
            plain["specularFactor"].push_back(share[c] * std::pow((stored + 0.055) / 1.055, 2.4));
        }
        const auto take = [&](const Json& extension) {
            return Take(Square({{"extensions", {{kExtension, extension}}}}, texel));
        };
        const Picture seen = take(textured), expected = take(plain);
        EXPECT_NEAR(seen.roughness.At(4, 4).x, 1.0 - glossiness, 1e-6);
        ExpectAlike(seen.roughness, expected.roughness, 1e-6f);
        // A device's sRGB curve has half a step of eight bits
        ExpectAlike(seen.traced, expected.traced, 4e-3f);
        ExpectAlike(seen.raster, expected.raster, 4e-3f);
        EXPECT_EQ(seen.record.flags, gpu::kMaterialGlossiness);
        EXPECT_EQ(expected.record.flags, 0u);
    }
}

// Of a texture that KHR_materials_specular names, alpha says nothing.
TEST_F(Glossiness, AlphaOfOtherSpecularColorsIsNotRead) {
    const Picture seen = Take(
        Square({{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.5}}},
                {"extensions", {{"KHR_materials_specular", {{"specularColorTexture", {{"index", 0}}}}}}}}));
    EXPECT_EQ(seen.roughness.At(4, 4).x, 0.5f);
    EXPECT_EQ(seen.record.flags, 0u);
}

// A smooth surface from straight above, where light comes from everywhere: it reflects its specular color, and
// of the rest, which is the same for all channels, the diffuse one. The extension: diffuse * (1 - max(specular)).
TEST_F(Glossiness, DiffuseColorGetsWhatTheStrongestChannelOfTheSpecularLeaves) {
    struct Case {
        glm::vec3 diffuse, specular;
    };
    for (const Case& c : {Case{{1, 1, 1}, {0.4f, 0.2f, 0.1f}}, Case{{0.5f, 0.25f, 1}, {0.1f, 0.6f, 0.3f}},
                          Case{{1, 1, 1}, {1, 1, 1}}, Case{{0.5f, 0.5f, 0.5f}, {0, 0, 0}}}) {
        GltfDocument document =
            Square({{"extensions",
                     {{kExtension,
                       {{"diffuseFactor", {c.diffuse.x, c.diffuse.y, c.diffuse.z, 1}},
                        {"specularFactor", {c.specular.x, c.specular.y, c.specular.z}}}}}}});
        document.json["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = 0;
        document.json["extensions"]["KHR_lights_punctual"]["lights"][1]["intensity"] = 0;
        render.scene.SetScene(test::Load(document));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        const RenderedImage image = render.Render(Facing(), 256);
        const glm::dvec3 mean = image.mean.Mean(), error = image.StandardErrorOfMean();
        const float left = 1.0f - std::max({c.specular.x, c.specular.y, c.specular.z});
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(mean[channel], c.specular[channel] + left * c.diffuse[channel],
                        4.0 * error[channel] + 2e-3)
                << "specular " << c.specular.x << ", channel " << channel;
    }
}

}  // namespace raygraph::testing::glossiness_test
