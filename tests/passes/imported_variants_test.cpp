// KHR_materials_variants, from the file to what is seen: by the scene that is set, and by one that is shown.
#include <algorithm>

#include "passes/raster.h"
#include "renderer/scene/model/variants.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::imported_variants_test {

namespace {

using test::GltfDocument;
using test::Json;

constexpr const char* kExtension = "KHR_materials_variants";

// A view along -z that is six high around the origin, of 24 pixels: four of them a unit.
passes::TraceSettings Facing() {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    view.height = 6.0f;
    passes::TraceSettings settings;
    settings.extent = {24, 24};
    settings.camera = ToRecord(view);
    return settings;
}

glm::vec3 SeenAt(const FloatImage& image, float x, float y) {
    return image.At(uint32_t((x + 3.0f) * 4.0f), uint32_t((3.0f - y) * 4.0f));
}

Json Glowing(const Json& color) {
    return {{"emissiveFactor", color}, {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}};
}

// Two triangles: one in front of the origin, which variants give other materials, and to the left one that
// stays as it is. Behind them a wall that glows, below a shelf that leans towards the viewer, in their light.
class ImportedVariants : public VulkanTest {
  protected:
    enum Material : uint32_t { Red, Green, Hole, Lamp, Dark, Glass, TwoSided, MaterialCount };
    static constexpr uint32_t kWall = MaterialCount;

    ImportedVariants() {
        Json& triangle = document.AddTriangle();
        triangle["attributes"]["TEXCOORD_0"] = document.AddAccessor<float>({0, 0, 1, 0, 0, 1}, 2);
        triangle["material"] = Red;
        document.Add("images",
                     {{"uri", test::DataUri(test::MakePngOf(2, 1, {255, 255, 255, 255, 0, 0, 0, 0}))}});
        document.Add("samplers", {{"magFilter", 9728}, {"minFilter", 9728}, {"wrapS", 33071}});
        document.Add("textures", {{"source", 0}, {"sampler", 0}});
        document.AddMaterial(Glowing({1, 0, 0}));
        document.AddMaterial(Glowing({0, 1, 0}));
        Json hole = Glowing({0, 0, 1}), lamp = Glowing({4, 4, 4}), twoSided = Glowing({1, 1, 0});
        hole["alphaMode"] = "MASK";
        hole["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
        lamp["emissiveTexture"]["index"] = 0;
        twoSided["doubleSided"] = true;
        document.AddMaterial(hole);
        document.AddMaterial(lamp);
        document.AddMaterial({{"pbrMetallicRoughness", {{"metallicFactor", 0}}}});
        document.AddMaterial({{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
                              {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}});
        document.AddMaterial(twoSided);
        document.AddMaterial(Glowing({0.25, 0.25, 0.25}));
        Json variants, mappings;
        for (uint32_t i = 0; i < MaterialCount; ++i) {
            variants.push_back({{"name", "variant " + std::to_string(i)}});
            mappings.push_back({{"material", i}, {"variants", {i}}});
        }
        variants.push_back({{"name", "not mapped"}});
        document.json["extensions"][kExtension]["variants"] = variants;
        Json& first = document.json["meshes"][0]["primitives"][0];
        first["extensions"][kExtension]["mappings"] = mappings;
        Json other = first;
        other["material"] = Green;
        other.erase("extensions");
        document.AddNode({{"mesh", document.AddMesh(other)}, {"translation", {-2, 0, 0}}});
        other["material"] = kWall;
        document.AddNode(
            {{"mesh", document.AddMesh(other)}, {"translation", {-3, -1, -2}}, {"scale", {6, 6, 1}}});
        other["material"] = Dark;
        document.AddNode({{"mesh", document.AddMesh(other)},
                          {"translation", {-2, -2.5, 1.5}},
                          {"rotation", {-0.38268343, 0, 0, 0.92387953}},
                          {"scale", {4, 2, 1}}});
    }

    void Set(uint32_t variant) {
        scene::SceneData data = test::Load(document);
        scene::SetVariant(data, variant);
        render.scene.SetScene(std::move(data));
        EXPECT_EQ(render.scene.Variant(), variant);
    }
    FloatImage Raster() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, Facing(), passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, Facing(), seen, environment, {}));
        render.renderer.Execute();
        return ToFloatImage(drawn);
    }
    // What the frame is declared with.
    SceneIds Ids() {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        render.renderer.DropFrame();
        return ids;
    }

    GltfDocument document;
    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

TEST_F(ImportedVariants, PictureIsOfTheMaterialsOfTheVariant) {
    const auto seenAs = [&](uint32_t variant, const glm::vec3& color) {
        Set(variant);
        const FloatImage radiance = render.TraceOnce(Facing());
        EXPECT_EQ(SeenAt(radiance, 0.1f, 0.3f), color) << variant;
        EXPECT_EQ(SeenAt(radiance, -1.9f, 0.3f), glm::vec3(0, 1, 0)) << "is in all of them";
        EXPECT_EQ(render.PrimaryHits(Facing()).ids.size(), 24u * 24u);
    };
    seenAs(scene::kNone, {1, 0, 0});
    seenAs(Green, {0, 1, 0});
    seenAs(TwoSided, {1, 1, 0});
    seenAs(MaterialCount, {1, 0, 0});
}

// All that follows from materials: opacity, culling, straight transmission, lights, what is compiled in.
TEST_F(ImportedVariants, ShownIsWhatItWouldHaveBeenSetTo) {
    struct Picture {
        FloatImage traced, raster;
        uint32_t lights = 0;
        TraceFeatures features;
        uint64_t emissive = 0;
    };
    const auto take = [&] {
        Picture picture;
        for (int frame = 0; frame < 2; ++frame) picture.traced = render.TraceOnce(Facing());
        picture.raster = Raster();
        const SceneIds ids = Ids();
        picture.lights = render.scene.Statistics().lightCount;
        picture.emissive = render.scene.Statistics().emissiveTriangleCount;
        picture.features = ids.features;
        return picture;
    };
    std::vector<Picture> set;
    for (uint32_t variant = 0; variant < MaterialCount; ++variant) {
        Set(variant);
        set.push_back(take());
    }
    EXPECT_EQ(set[Dark].emissive + 1, set[Red].emissive);
    EXPECT_TRUE(set[Hole].features.Has(kTraceAnyHit) && set[Glass].features.Has(kTraceThinWalls));
    EXPECT_FALSE(set[Red].features.Has(kTraceAnyHit));
    EXPECT_NE(set[Red].raster.values, set[Green].raster.values);
    EXPECT_NE(set[Red].raster.values, set[Hole].raster.values);
    Set(scene::kNone);
    // From each to the next, and from the last to the first
    for (uint32_t turn = 0; turn <= MaterialCount; ++turn) {
        const uint32_t variant = turn % MaterialCount;
        SCOPED_TRACE(variant);
        render.scene.SetVariant(variant);
        EXPECT_EQ(render.scene.Variant(), variant);
        const Picture shown = take();
        EXPECT_EQ(shown.traced.values, set[variant].traced.values);
        EXPECT_EQ(shown.raster.values, set[variant].raster.values);
        EXPECT_EQ(shown.lights, set[variant].lights);
        EXPECT_EQ(shown.emissive, set[variant].emissive);
        EXPECT_EQ(shown.features, set[variant].features);
        const uint32_t next = (variant + 1) % MaterialCount;
        EXPECT_NE(shown.traced.values, set[next].traced.values);
    }
}

// Two primitives of one mesh, which are one list of triangles until a variant parts them.
TEST_F(ImportedVariants, PrimitivesOfOneMeshAreShownEachWithItsOwn) {
    Json second = document.json["meshes"][1]["primitives"][0];
    second["attributes"]["POSITION"] = document.AddAccessor<float>({1, 1, 0, 2, 1, 0, 1, 2, 0}, 3);
    document.json["meshes"][0]["primitives"].push_back(second);
    Set(scene::kNone);
    const auto expectSeen = [&](uint32_t variant, const glm::vec3& solid, const glm::vec3& cut) {
        render.scene.SetVariant(variant);
        const FloatImage radiance = render.TraceOnce(Facing());
        EXPECT_EQ(SeenAt(radiance, 0.1f, 0.3f), solid) << variant;
        EXPECT_EQ(SeenAt(radiance, 1.1f, 1.3f), glm::vec3(0, 1, 0)) << variant;
        EXPECT_EQ(SeenAt(radiance, 0.8f, 0.1f), cut) << variant;
        EXPECT_EQ(render.PrimaryHits(Facing()).ids.size(), 24u * 24u);
    };
    expectSeen(scene::kNone, {1, 0, 0}, {1, 0, 0});
    expectSeen(Green, {0, 1, 0}, {0, 1, 0});
    expectSeen(Hole, {0, 0, 1}, glm::vec3(0.25f));
    const auto materialAt = [&](float x, float y) {
        const auto ids = render.PrimaryHits(Facing()).ids;
        return ids[size_t{uint32_t((3.0f - y) * 4.0f)} * 24 + uint32_t((x + 3.0f) * 4.0f)].y;
    };
    EXPECT_EQ(materialAt(0.8f, 0.1f), kWall) << "through the hole";
    EXPECT_EQ(materialAt(0.1f, 0.3f), Hole);
    EXPECT_EQ(materialAt(1.1f, 1.3f), Green);
    expectSeen(TwoSided, {1, 1, 0}, {1, 1, 0});
}

TEST_F(ImportedVariants, SwitchingCountsAsAChangeAndKeepsEdits) {
    Set(scene::kNone);
    for (int frame = 0; frame < 4; ++frame) render.TraceOnce(Facing());  // compaction is done by then
    ASSERT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None);
    const SceneRevisions before = render.scene.Revisions();
    render.scene.SetVariant(scene::kNone);
    EXPECT_EQ(render.scene.Revisions(), before) << "it is shown already";
    scene::Material purple = test::Load(document).materials[Green];
    purple.emissiveFactor = {0.5f, 0, 0.5f};
    render.scene.SetMaterial(Green, purple);
    const SceneRevisions edited = render.scene.Revisions();
    render.scene.SetVariant(Green);
    EXPECT_NE(render.scene.Revisions().materials, edited.materials);
    EXPECT_NE(render.scene.Revisions().geometry, edited.geometry);
    EXPECT_EQ(SeenAt(render.TraceOnce(Facing()), 0.1f, 0.3f), purple.emissiveFactor);
    EXPECT_EQ(render.scene.Statistics().lastTlasWork, TlasWork::None) << "rays treat both alike";
    EXPECT_THROW(render.scene.SetVariant(MaterialCount + 1), Error);
    EXPECT_EQ(render.scene.Variant(), Green);
    render.renderer.BeginFrame();
    std::ignore = render.scene.Declare(render.renderer);
    EXPECT_THROW(render.scene.SetVariant(Red), Error) << "a frame is open";
    render.renderer.DropFrame();
    render.scene.SetVariant(Red);
    // A frame that was dropped has not shown it
    render.renderer.BeginFrame();
    std::ignore = render.scene.Declare(render.renderer);
    render.renderer.DropFrame();
    EXPECT_EQ(SeenAt(render.TraceOnce(Facing()), 0.1f, 0.3f), glm::vec3(1, 0, 0));
    render.scene.SetScene({});
    EXPECT_EQ(render.scene.Variant(), scene::kNone);
    EXPECT_THROW(render.scene.SetVariant(0), Error);
}

}  // namespace raygraph::testing::imported_variants_test
