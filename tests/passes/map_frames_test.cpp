// Each directional map of a surface is read along its own texture coordinates. The expected directions are
// worked out here from the coordinates of a square's corners.
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/gltf/still_scene.h"
#include "shaders/shared/trace_options.h"
#include "tests/passes/gltf_square.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::map_frames_test {

using passes::TraceSettings;

namespace {

// The texture coordinates of a map in glTF: a set, and the scale and rotation of its transform.
struct Coordinates {
    int set = 0;
    double rotation = 0.0;
    glm::dvec2 scale{1.0};

    Json AsJson() const {
        Json map{{"index", 0}, {"texCoord", set}};
        if (rotation != 0.0 || scale != glm::dvec2(1.0))
            map["extensions"]["KHR_texture_transform"] = {{"rotation", rotation},
                                                          {"scale", {scale.x, scale.y}}};
        return map;
    }
};

// The texture coordinates of the four corners in both sets, in the order of Square.
struct Corners {
    std::vector<float> first = kUpright;
    std::vector<float> second = kUpright;
};

const std::vector<float> kQuarterTurn{1, 1, 1, 0, 0, 0, 0, 1};  // u to the bottom, v to the left
const std::vector<float> kMirrored{1, 1, 0, 1, 0, 0, 1, 0};     // u to the left
const std::vector<float> kSkewed{0.1f, 1.0f, 2.0f, 1.7f, 2.3f, 1.0f, 0.4f, 0.3f};

// The directions of the image's right and top in the xy plane, made perpendicular as in tangent frames.
struct ImageAxes {
    glm::dvec3 right, top;
};
ImageAxes AxesOn(const std::vector<float>& corners, const Coordinates& coordinates,
                 const glm::dvec2& alongX = {2.0, 0.0}, const glm::dvec2& alongY = {0.0, 2.0}) {
    const auto at = [&](size_t corner) {
        const double c = std::cos(coordinates.rotation), s = std::sin(coordinates.rotation);
        const glm::dvec2 uv = coordinates.scale * glm::dvec2(corners[2 * corner], corners[2 * corner + 1]);
        return glm::dvec2(c * uv.x + s * uv.y, -s * uv.x + c * uv.y);  // example of KHR_texture_transform
    };
    // These map coefficients along both edges to positions and to texture coordinates
    const glm::dmat2 places(alongX, alongY), uv(at(1) - at(0), at(3) - at(0));
    const glm::dmat2 toPlace = places * glm::inverse(uv);
    const glm::dvec2 right = glm::normalize(toPlace * glm::dvec2(1.0, 0.0));
    const glm::dvec2 up = toPlace * glm::dvec2(0.0, -1.0);
    const glm::dvec2 top = glm::normalize(up - glm::dot(up, right) * right);
    return {{right, 0.0}, {top, 0.0}};
}

// A normal map texel that no rotation or reflection maps to itself, and the normal that it encodes.
constexpr std::array<uint8_t, 4> kTilt{178, 102, 241, 255};
glm::dvec3 Bent(const ImageAxes& axes) {
    const glm::dvec3 read = 2.0 * glm::dvec3(kTilt[0], kTilt[1], kTilt[2]) / 255.0 - glm::dvec3(1.0);
    return glm::normalize(read.x * axes.right + read.y * axes.top + glm::dvec3(0.0, 0.0, read.z));
}

class MapFrames : public VulkanTest {
  protected:
    MapFrames() { render.more |= kTraceTextureTransforms | kTraceClearcoat | kTraceOpaque | kTraceSmooth; }

    // Returns the file of a square with `material`, whose texture 0 has the color kTilt.
    static GltfDocument File(const Json& material, const Corners& corners) {
        GltfDocument document;
        AddTexture(document, test::MakePng(2, 2, kTilt));
        Json primitive = Square(document, corners.first, document.AddMaterial(material));
        primitive["attributes"]["TEXCOORD_1"] = document.AddAccessor(corners.second, 2);
        document.AddNode({{"mesh", document.AddMesh(primitive)}});
        return document;
    }

    // Returns a black material under a smooth clear coat with a normal map; `base`, if given, is a normal map
    // of the base.
    static Json Coated(const Coordinates& coat, const Coordinates* base) {
        Json material{{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}}},
                      {"extensions",
                       {{"KHR_materials_specular", {{"specularFactor", 0}}},
                        {"KHR_materials_clearcoat",
                         {{"clearcoatFactor", 1}, {"clearcoatNormalTexture", coat.AsJson()}}}}}};
        if (base) material["normalTexture"] = base->AsJson();
        return material;
    }

    // Returns the share of a lamp's radiance that a coat with this normal mirrors to a far viewer above the
    // square. The lamp fills 3 degrees around the mirror direction, so that it is not seen if the normal is
    // off by 2 degrees. All else is black.
    double Mirrored(GltfDocument document, const glm::dvec3& normal, bool isFrozen = false) {
        const glm::dvec3 mirror = 2.0 * normal.z * normal - glm::dvec3(0.0, 0.0, 1.0);
        const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(0.1, 0.7, 0.3), -mirror));
        const glm::dvec3 y = glm::cross(-mirror, x), place = 8.0 * mirror;
        const double size = 8.0 * std::tan(0.05);
        const size_t lamp = document.AddMaterial(
            {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}, {"emissiveFactor", {1, 1, 1}}});
        document.AddNode(
            {{"mesh", document.AddMesh(Square(document, {}, lamp))},
             {"matrix",
              {size * x.x, size * x.y, size * x.z, 0, size * y.x, size * y.y, size * y.z, 0, -size * mirror.x,
               -size * mirror.y, -size * mirror.z, 0, place.x, place.y, place.z, 1}}});
        scene::SceneData scene = Load(document);
        if (isFrozen)
            scene::FreezePose(scene, {});
        else
            scene::DeformInstances(scene);
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt({0, 0, 100.0f}, {0, 0, 0}, 1e-4f, 4);
        settings.scattering.brdf = BrdfModel::Gltf;
        return render.TraceOnce(settings).Mean().y;
    }
    static double Fresnel(const glm::dvec3& normal) { return 0.04 + 0.96 * std::pow(1.0 - normal.z, 5.0); }
    void ExpectMirrored(const GltfDocument& document, const glm::dvec3& normal, const char* what,
                        bool isFrozen = false) {
        EXPECT_NEAR(Mirrored(document, normal, isFrozen), Fresnel(normal), 2e-4) << what;
    }

    glm::vec3 NormalSeen() { return render.PrimaryHits(Facing(1.0f, 4)).normal.At(1, 1); }
    TraceFeatures TextureFeatures() {
        render.renderer.BeginFrame();
        const TraceFeatures features = render.scene.Declare(render.renderer).features;
        render.renderer.Execute();
        return features & FeaturesOfKind(TraceFeatureKind::Textures);
    }

    SceneRender render{Device()};
};

struct Row {
    const char* what;
    Coordinates coat, base;
    Corners corners;
};
const Row kRows[] = {
    {"the same coordinates", {}, {}, {}},
    {"another set, turned by 90 degrees", {.set = 1}, {}, {.second = kQuarterTurn}},
    {"another set, mirrored", {.set = 1}, {}, {.second = kMirrored}},
    {"another set, skewed", {.set = 1}, {}, {.second = kSkewed}},
    {"the first set below the second one", {}, {.set = 1}, {.second = kQuarterTurn}},
    {"another rotation", {.rotation = 0.7}, {}, {}},
    {"a rotation of the base alone", {}, {.rotation = -2.0}, {}},
    {"another rotation of skewed coordinates", {.rotation = 0.7}, {}, {.first = kSkewed}},
    {"mirrored by its scale", {.scale = {-1.0, 1.0}}, {}, {}},
    {"upside down by its scale, on mirrored coordinates", {.scale = {1.0, -2.0}}, {}, {.first = kMirrored}},
    {"another set and rotation and scale",
     {.set = 1, .rotation = 2.5, .scale = {-3.0, 0.5}},
     {.rotation = -1.0},
     {.second = kSkewed}},
};

}  // namespace

// The normal map of a clear coat is read along its own coordinates, whatever those of the base's map.
TEST_F(MapFrames, ClearCoat_IsReadAlongItsOwnCoordinates) {
    for (const Row& row : kRows) {
        const glm::dvec3 normal =
            Bent(AxesOn(row.coat.set == 1 ? row.corners.second : row.corners.first, row.coat));
        SCOPED_TRACE(row.what);
        ExpectMirrored(File(Coated(row.coat, nullptr), row.corners), normal, "without a base's map");
        ExpectMirrored(File(Coated(row.coat, &row.base), row.corners), normal, "with one");
    }
}

// The rows are the same: the coat's map must not change how the base's map is read.
TEST_F(MapFrames, Base_IsReadAlongItsOwnCoordinates) {
    for (const Row& row : kRows) {
        const Corners& corners = row.corners;
        const glm::dvec3 normal = Bent(AxesOn(row.base.set == 1 ? corners.second : corners.first, row.base));
        render.scene.SetScene(Load(File(Coated(row.coat, &row.base), corners)));
        ExpectNear(NormalSeen(), normal, 2e-3f, row.what);
    }
}

// In glTF, a file's tangents are the tangent space of the primitive, in which all its textures operate.
TEST_F(MapFrames, GivenTangents_AreTheFrameOfAllMaps) {
    const Coordinates coat{.set = 1, .rotation = 0.7}, base;
    GltfDocument document = File(Coated(coat, &base), {.second = kMirrored});
    document.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = document.AddAccessor<float>(
        {0.6f, 0.8f, 0, 1, 0.6f, 0.8f, 0, 1, 0.6f, 0.8f, 0, 1, 0.6f, 0.8f, 0, 1}, 4);
    const scene::SceneData file = Load(document);
    ASSERT_EQ(file.warnings.size(), 1u);
    EXPECT_NE(file.warnings[0].find("count along TANGENT"), std::string::npos) << file.warnings[0];
    const glm::dvec3 normal = Bent({{0.6, 0.8, 0.0}, {-0.8, 0.6, 0.0}});
    ExpectMirrored(document, normal, "coat");
    ExpectNear(NormalSeen(), normal, 2e-3f, "base");
}

// An edited or animated rotation turns the directions with the image.
TEST_F(MapFrames, EditedTransform_TurnsTheFrame) {
    const Coordinates upright;
    const scene::SceneData file = Load(File({{"normalTexture", upright.AsJson()}}, {}));
    render.scene.SetScene(scene::SceneData(file));
    ExpectNear(NormalSeen(), Bent(AxesOn(kUpright, upright)), 2e-3f, "as in the file");
    for (const Coordinates& edited : {Coordinates{.rotation = 1.2}, Coordinates{.scale = {-1.0, 1.0}}}) {
        scene::Material material = file.materials[0];
        material.normalTexture.transform.rotation = static_cast<float>(edited.rotation);
        material.normalTexture.transform.scale = edited.scale;
        render.scene.SetMaterial(0, material);
        ExpectNear(NormalSeen(), Bent(AxesOn(kUpright, edited)), 2e-3f, "edited");
    }
}

TEST_F(MapFrames, AnimatedRotation_TurnsTheFrame) {
    GltfDocument document = File({{"normalTexture", Coordinates{.rotation = 0.1}.AsJson()}}, {});
    document.Add("extensionsUsed", "KHR_animation_pointer");
    const size_t times = document.AddAccessor<float>({0, 1}, 1);
    document.json["accessors"][times]["min"] = {0};
    document.json["accessors"][times]["max"] = {1};
    document.json["animations"] = {
        {{"samplers", {{{"input", times}, {"output", document.AddAccessor<float>({0, 2}, 1)}}}},
         {"channels",
          {{{"sampler", 0},
            {"target",
             {{"path", "pointer"},
              {"extensions",
               {{"KHR_animation_pointer",
                 {{"pointer",
                   "/materials/0/normalTexture/extensions/KHR_texture_transform/rotation"}}}}}}}}}}}};
    for (const double time : {0.25, 1.0}) {
        scene::SceneData scene = Load(document);
        scene::FreezePose(scene, scene::FindClips(scene, "0", time));
        render.scene.SetScene(std::move(scene));
        ExpectNear(NormalSeen(), Bent(AxesOn(kUpright, {.rotation = 2.0 * time})), 2e-3f, "animated");
    }
}

// Tangents are made once for all variants of a primitive.
TEST_F(MapFrames, Variants_ReadTheirMapsAlongTheirOwnCoordinates) {
    GltfDocument document = File({{"normalTexture", Coordinates{}.AsJson()}}, {.second = kQuarterTurn});
    document.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "other"}}};
    const size_t other = document.AddMaterial({{"normalTexture", Coordinates{.set = 1}.AsJson()}});
    document.json["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] = {
        {{"material", other}, {"variants", {0}}}};
    const scene::SceneData file = Load(document);
    EXPECT_TRUE(file.warnings.empty());
    render.scene.SetScene(scene::SceneData(file));
    ExpectNear(NormalSeen(), Bent(AxesOn(kUpright, {})), 2e-3f, "its own");
    render.scene.SetVariant(0);
    ExpectNear(NormalSeen(), Bent(AxesOn(kQuarterTurn, {})), 2e-3f, "the variant's");
}

// One set runs around a disc of a few wedges, the other one is flat. The tangents of either are the same if
// the stored ones are those of the other set.
TEST_F(MapFrames, SetThatRunsAroundADisc_IsSmoothAsTheOnlyOne) {
    constexpr int kWedges = 8;
    std::vector<float> positions, normals, flat, around;
    std::vector<uint16_t> indices;
    for (int i = 0; i <= kWedges; ++i)
        for (const float radius : {0.2f, 1.0f}) {
            const float angle = 2.0f * glm::pi<float>() * float(i) / kWedges;
            const float x = radius * std::cos(angle), y = radius * std::sin(angle);
            positions.insert(positions.end(), {x, y, 0.0f});
            normals.insert(normals.end(), {0.0f, 0.0f, 1.0f});
            flat.insert(flat.end(), {x, -y});
            around.insert(around.end(), {float(i), 1.0f - radius});
        }
    for (int i = 0; i < kWedges; ++i)
        for (const int corner : {0, 1, 3, 0, 3, 2}) indices.push_back(static_cast<uint16_t>(2 * i + corner));
    // isOwn: the only map is read along the second set. Otherwise that is a variant of a material whose map is
    // read along the first one
    const auto seen = [&](bool isOwn, bool isSecondFlat) {
        GltfDocument document;
        AddTexture(document, test::MakePng(2, 2, kTilt));
        const size_t one = document.AddMaterial({{"normalTexture", Coordinates{.set = 1}.AsJson()}});
        const size_t other = document.AddMaterial({{"normalTexture", Coordinates{}.AsJson()}});
        Json primitive{{"attributes",
                        {{"POSITION", document.AddAccessor(positions, 3)},
                         {"NORMAL", document.AddAccessor(normals, 3)},
                         {"TEXCOORD_0", document.AddAccessor(isSecondFlat ? around : flat, 2)},
                         {"TEXCOORD_1", document.AddAccessor(isSecondFlat ? flat : around, 2)}}},
                       {"indices", document.AddAccessor(indices, 1)},
                       {"material", isOwn ? one : other}};
        if (!isOwn) {
            document.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "one"}}};
            primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
                {{"material", one}, {"variants", {0}}}};
        }
        document.AddNode({{"mesh", document.AddMesh(primitive)}});
        render.scene.SetScene(Load(document));
        if (!isOwn) render.scene.SetVariant(0);
        return render.PrimaryHits(Facing(2.0f, 48)).normal;
    };
    for (const bool isSecondFlat : {false, true}) {
        SCOPED_TRACE(isSecondFlat);
        const FloatImage expected = seen(true, isSecondFlat), shown = seen(false, isSecondFlat);
        size_t count = 0;
        for (size_t i = 0; i < expected.values.size(); ++i) {
            const glm::vec3 a(expected.values[i]), b(shown.values[i]);
            if (a == glm::vec3(0.0f)) continue;
            ASSERT_LT(glm::distance(a, b), 1e-4f) << "pixel " << i;
            ++count;
        }
        EXPECT_GT(count, 1000u);
    }
}

// A morph target turns and skews the square; maps of either set follow it, along tangents that were made.
TEST_F(MapFrames, DeformedMesh_TurnsTheFramesOfBothSets) {
    const Coordinates coat{.set = 1}, base;
    GltfDocument document = File(Coated(coat, &base), {.second = kMirrored});
    Json& mesh = document.json["meshes"][0];
    // The target moves the corners so that the edge along x becomes (1.2, 1.3), and the edge along y (-0.6,
    // 1.7)
    const glm::dvec2 alongX(1.2, 1.3), alongY(-0.6, 1.7);
    std::vector<float> moves;
    for (const glm::dvec2& corner :
         {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1), glm::dvec2(-1, 1)}) {
        const glm::dvec2 move = 0.5 * (corner.x * alongX + corner.y * alongY) - corner;
        moves.insert(moves.end(), {float(move.x), float(move.y), 0.0f});
    }
    mesh["primitives"][0]["targets"] = {{{"POSITION", document.AddAccessor(moves, 3)}}};
    mesh["weights"] = {1};
    const glm::dvec3 ofCoat = Bent(AxesOn(kMirrored, coat, alongX, alongY));
    const glm::dvec3 ofBase = Bent(AxesOn(kUpright, base, alongX, alongY));
    for (const bool isFrozen : {false, true}) {
        SCOPED_TRACE(isFrozen ? "on the host" : "on the device");
        ExpectMirrored(document, ofCoat, "coat", isFrozen);
        ExpectNear(NormalSeen(), ofBase, 2e-3f, "base");
    }
}

// A joint turns the square, which keeps the angle between the frames of its sets.
TEST_F(MapFrames, SkinnedMesh_TurnsTheFrameOfAnotherSet) {
    const Coordinates coat{.set = 1}, base;
    GltfDocument document = File(Coated(coat, &base), {.second = kMirrored});
    Json& attributes = document.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = document.AddAccessor<uint8_t>(std::vector<uint8_t>(16, 0), 4);
    attributes["WEIGHTS_0"] =
        document.AddAccessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 4);
    const double angle = 0.8;
    document.json["skins"] = {
        {{"joints", {document.AddNode({{"rotation", {0, 0, std::sin(angle / 2), std::cos(angle / 2)}}})}}}};
    document.json["nodes"][0]["skin"] = 0;
    const glm::dvec2 x(std::cos(angle), std::sin(angle)), y(-x.y, x.x);
    const glm::dvec3 normal = Bent(AxesOn(kMirrored, coat, 2.0 * x, 2.0 * y));
    ExpectMirrored(document, normal, "on the device");
    ExpectMirrored(document, normal, "on the host", true);
}

// Pipelines know of other frames only where a material needs one.
TEST_F(MapFrames, ScenesOfOneSet_HaveNoFeatureMore) {
    const Coordinates first, second{.set = 1};
    const auto featuresOf = [&](const Json& material) {
        render.scene.SetScene(Load(File(material, {})));
        return TextureFeatures();
    };
    EXPECT_EQ(featuresOf(Coated(first, &first)), kTraceTextures);
    EXPECT_EQ(featuresOf(Coated(second, &second)), kTraceTextures);
    EXPECT_EQ(featuresOf(Coated(second, nullptr)), kTraceTextures);
    EXPECT_EQ(featuresOf(Coated(second, &first)), kTraceTextures | kTraceTextureTransforms);
    EXPECT_EQ(featuresOf(Coated(first, &second)), kTraceTextures | kTraceTextureTransforms);
}

// A map encodes the tilt of the surface before it is placed: relief that is stretched along the surface gets
// flatter, relief that is stretched along the normal gets steeper.
TEST_F(MapFrames, ScaledNode_ScalesTheRelief) {
    const glm::dvec3 read = 2.0 * glm::dvec3(kTilt[0], kTilt[1], kTilt[2]) / 255.0 - glm::dvec3(1.0);
    for (const glm::dvec3& scale : {glm::dvec3(4.0, 1.0, 1.0), glm::dvec3(1.0, 1.0, 0.5), glm::dvec3(3.0)}) {
        GltfDocument document = File({{"normalTexture", Coordinates{}.AsJson()}}, {});
        document.json["nodes"][0]["scale"] = {scale.x, scale.y, scale.z};
        render.scene.SetScene(Load(document));
        ExpectNear(NormalSeen(), glm::normalize(read / scale), 2e-3f, "normal");
    }
}

}  // namespace raygraph::testing::map_frames_test
