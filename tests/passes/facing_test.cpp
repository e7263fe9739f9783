#include <cmath>
#include <functional>
#include <tuple>

#include "passes/scene_bindings.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Back faces of single-sided materials are culled for every ray, whatever the transform.
namespace raygraph::testing::facing_test {

namespace {

scene::Material SingleSided(const glm::vec3& albedo, const glm::vec3& emission = glm::vec3(0.0f)) {
    scene::Material material = Lambert(albedo, emission);
    material.isDoubleSided = false;
    return material;
}

glm::mat4x3 Scaling(const glm::vec3& scale) {
    return {glm::vec3(scale.x, 0, 0), glm::vec3(0, scale.y, 0), glm::vec3(0, 0, scale.z), glm::vec3(0.0f)};
}

struct Sides {
    bool front = false;
    bool back = false;

    bool operator==(const Sides&) const = default;
};
void PrintTo(const Sides& sides, std::ostream* out) {
    *out << (sides.front ? "front" : "no front") << ", " << (sides.back ? "back" : "no back");
}
constexpr Sides kFront{true, false}, kBack{false, true}, kBoth{true, true};

class Facing : public VulkanTest {
  protected:
    // From where a quad that faces +z is seen: from +z (its front), from -z.
    Sides Seen(const scene::Material& material, const glm::mat4x3& transform = glm::mat4x3(1.0f)) {
        render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {material}, {transform}));
        return Seen();
    }
    Sides Seen() {
        const auto sees = [this](float z) {
            return render.PrimaryHits(LookAt({0, 0, z}, {0, 0, 0}, 0.1f, 1)).ids[0].x == 0u;
        };
        return {sees(3.0f), sees(-3.0f)};
    }

    // Radiance that leaves a floor of albedo 0.5 upwards in an environment of radiance `sky`, with a quad
    // parallel to it at half its own width above, whose front faces up or down.
    glm::dvec3 FloorBelow(const scene::Material& quad, bool facesUp, float sky) {
        const glm::vec3 z(0, 0, facesUp ? 1 : -1), x(facesUp ? 1 : -1, 0, 0);
        const glm::mat4x3 placed(x, glm::vec3(0, 1, 0), z, glm::vec3(0, 0, 1));  // a turn, no mirror
        render.scene.SetScene(SceneOf({QuadMesh(0.2f, 0), QuadMesh(1.0f, 1)},
                                      {SingleSided(glm::vec3(0.5f)), quad}, {glm::mat4x3(1.0f), placed}));
        render.scene.SetEnvironment({.radiance = glm::vec3(sky)});
        // From between the two
        return render.Render(LookAt({0, 0.05f, 0.9f}, {0, 0, 0}, 0.1f, 16), 64).mean.Mean();
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(Facing, SingleSidedQuadIsSeenFromItsFrontAlone) {
    EXPECT_EQ(Seen(SingleSided(glm::vec3(0.5f))), kFront);
}

TEST_F(Facing, DoubleSidedQuadIsSeenFromBothSides) {
    EXPECT_EQ(Seen(Lambert(glm::vec3(0.5f))), kBoth);
}

TEST_F(Facing, MirroringTransformKeepsTheFront) {
    for (const glm::vec3 mirror : {glm::vec3(-1, 1, 1), glm::vec3(2, -0.5f, 1), glm::vec3(-1, -1, 1)}) {
        EXPECT_EQ(Seen(SingleSided(glm::vec3(0.5f)), Scaling(mirror)), kFront);
        EXPECT_EQ(Seen(Lambert(glm::vec3(0.5f)), Scaling(mirror)), kBoth);
    }
    // Mirrored along the normal, and turned round: what was the front faces -z
    EXPECT_EQ(Seen(SingleSided(glm::vec3(0.5f)), Scaling({1, 1, -1})), kBack);
    EXPECT_EQ(Seen(SingleSided(glm::vec3(0.5f)), Scaling({-1, 1, -1})), kBack);
}

TEST_F(Facing, TransformThatComesToMirrorKeepsTheFront) {
    ASSERT_EQ(Seen(SingleSided(glm::vec3(0.5f))), kFront);
    for (int frame = 0; frame < 8; ++frame) Seen();  // past compaction: the next change is an update
    render.scene.SetTransform(0, Scaling({-1, 1, 1}));
    EXPECT_EQ(Seen(), kFront);
    render.scene.SetTransform(0, Scaling({1, 1, -1}));
    EXPECT_EQ(Seen(), kBack);
}

// The edit takes a note; what it needs on the device belongs to the frame, which is dropped without it.
TEST_F(Facing, SidesThatChangeWhileMemoryIsSpent_AreThoseOfTheNextFrame) {
    ASSERT_EQ(Seen(SingleSided(glm::vec3(0.5f))), kFront);
    for (int frame = 0; frame < 8; ++frame) Seen();
    Device().WaitIdle();
    Device().LimitMemory(1);
    EXPECT_NO_THROW(render.scene.SetMaterial(0, Lambert(glm::vec3(0.5f))));
    EXPECT_EQ(ErrorOf([&] { Seen(); }).Kind(), ErrorKind::OutOfMemory);
    Device().LimitMemory(0);
    EXPECT_EQ(Seen(), kBoth);
}

TEST_F(Facing, SingleSidedMaskAndBlendAreCulledToo) {
    for (const scene::AlphaMode mode : {scene::AlphaMode::Mask, scene::AlphaMode::Blend}) {
        scene::Material material = SingleSided(glm::vec3(0.5f));
        material.alphaMode = mode;
        EXPECT_EQ(Seen(material), kFront);
        material.isDoubleSided = true;
        EXPECT_EQ(Seen(material), kBoth);
    }
}

TEST_F(Facing, MaterialsThatLightPassesHaveBothSides) {
    scene::Material glass = SingleSided(glm::vec3(1.0f));
    glass.transmissionFactor = 1.0f;
    EXPECT_EQ(Seen(glass), kBoth);
    glass.thicknessFactor = 1.0f;
    EXPECT_EQ(Seen(glass), kBoth);
    scene::Material opaque = SingleSided(glm::vec3(1.0f));
    opaque.thicknessFactor = 1.0f;
    EXPECT_EQ(Seen(opaque), kFront) << "a volume that no light enters";
}

TEST_F(Facing, BackOfASingleSidedSurfaceDoesNotShadow) {
    const double open = FloorBelow(SingleSided(glm::vec3(0.0f)), true, 1.0f).x;
    EXPECT_NEAR(open, 0.5, 1e-3) << "the floor sees the quad's back, which is not there";
    EXPECT_LT(FloorBelow(SingleSided(glm::vec3(0.0f)), false, 1.0f).x, 0.4) << "its front does shadow";
    EXPECT_LT(FloorBelow(Lambert(glm::vec3(0.0f)), true, 1.0f).x, 0.4) << "and so does a double-sided back";
}

TEST_F(Facing, BackOfASingleSidedSurfaceDoesNotEmit) {
    const glm::vec3 radiance(2.0f);
    EXPECT_EQ(FloorBelow(SingleSided(glm::vec3(0.0f), radiance), true, 0.0f).x, 0.0);
    const double lit = FloorBelow(SingleSided(glm::vec3(0.0f), radiance), false, 0.0f).x;
    EXPECT_GT(lit, 0.3);
    EXPECT_NEAR(FloorBelow(Lambert(glm::vec3(0.0f), radiance), true, 0.0f).x, lit, 0.05 * lit);
}

TEST_F(Facing, PrimitivesOfOneMeshAreGroupedByHowRaysTreatThem) {
    // Two of each kind, opaque or not, culled or not
    scene::Mesh mesh;
    std::vector<scene::Material> materials;
    for (uint32_t i = 0; i < 8; ++i) {
        scene::Material material = SingleSided(glm::vec3(0.1f * float(i + 1)));
        material.isDoubleSided = (i & 1) != 0;
        material.alphaMode = (i & 2) != 0 ? scene::AlphaMode::Mask : scene::AlphaMode::Opaque;
        materials.push_back(material);
        mesh.primitives.push_back(QuadMesh(0.4f, i).primitives[0]);
        if (i & 2) {  // alpha has to be looked at: a corner is a hole
            mesh.primitives.back().colors.assign(4, glm::vec4(1.0f));
            mesh.primitives.back().colors[3].a = 0.0f;
        }
        for (glm::vec3& position : mesh.primitives.back().positions) position.x += float(i);
        mesh.primitives.back().bounds.min.x += float(i);
        mesh.primitives.back().bounds.max.x += float(i);
    }
    render.scene.SetScene(SceneOf({mesh}, materials));
    for (uint32_t i = 0; i < 8; ++i)
        for (const float side : {1.0f, -1.0f}) {
            const glm::vec3 center(float(i), 0, 0);
            const SceneRender::Hits hits =
                render.PrimaryHits(LookAt(center + glm::vec3(0, 0, side), center, 0.1f, 1));
            const bool isSeen = side > 0.0f || (i & 1) != 0;
            EXPECT_EQ(hits.ids[0].y, isSeen ? i : 0xFFFFFFFFu) << "material " << i << " from " << side;
        }
    EXPECT_EQ(render.scene.Statistics().blasCount, 4u);
}

TEST_F(Facing, AlphaThatLetsNothingThroughCostsNoGroup) {
    const auto groups = [this](const scene::Material& second, float vertexAlpha = 1.0f) {
        scene::Mesh mesh = QuadMesh(0.3f, 0);
        mesh.primitives.push_back(QuadMesh(0.5f, 1).primitives[0]);
        mesh.primitives[1].colors.assign(4, glm::vec4(1.0f, 0.5f, 1.0f, vertexAlpha));
        render.scene.SetScene(SceneOf({mesh}, {SingleSided(glm::vec3(0.5f)), second}));
        Seen();
        return render.scene.Statistics().blasCount;
    };
    scene::Material material = SingleSided(glm::vec3(0.5f));
    material.alphaMode = scene::AlphaMode::Blend;
    EXPECT_EQ(groups(material), 1u);
    EXPECT_EQ(groups(material, 0.99f), 2u) << "vertices have alpha";
    material.baseColorFactor.a = 0.99f;
    EXPECT_EQ(groups(material), 2u);
    material.alphaMode = scene::AlphaMode::Mask;
    EXPECT_EQ(groups(material), 1u) << "above the cutoff of 0.5";
    material.baseColorFactor.a = 0.5f;
    EXPECT_EQ(groups(material), 1u) << "at the cutoff";
    material.baseColorFactor.a = 0.49f;
    EXPECT_EQ(groups(material), 2u);
}

}  // namespace raygraph::testing::facing_test

// The environment that a scene brings along, from the text of a glTF file to what is seen.
namespace raygraph::testing::image_light_scene_test {

namespace {

using test::GltfDocument;
using test::Json;

// Red, green, blue, and the same at a fifth of the alpha: five times as bright. Above the triangle of the
// scene, which is small and far from the rays.
GltfDocument SixColors() {
    constexpr std::array<std::array<uint8_t, 4>, 6> kColors{{{255, 0, 0, 255},
                                                             {0, 255, 0, 255},
                                                             {0, 0, 255, 255},
                                                             {255, 0, 0, 51},
                                                             {0, 255, 0, 51},
                                                             {0, 0, 255, 51}}};
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["scale"] = {0.01, 0.01, 0.01};
    for (const auto& color : kColors)
        document.Add("images", {{"uri", test::DataUri(test::MakePng(1, 1, color))}});
    document.json["extensions"]["EXT_lights_image_based"]["lights"] =
        Json::array({{{"intensity", 0.5},
                      {"specularImageSize", 1},
                      {"specularImages", Json::array({{0, 1, 2, 3, 4, 5}})}}});
    document.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
    return document;
}

class ImageLightScene : public VulkanTest {
  protected:
    glm::vec3 Towards(const glm::vec3& direction) {
        const glm::vec3 eye(0.0f, 5.0f, 0.0f),
            up = direction.y == 0.0f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
        passes::TraceSettings settings;
        settings.extent = {1, 1};
        settings.camera = ToRecord(scene::CameraView::LookAt(eye, eye + direction, up));
        return render.TraceOnce(settings).At(0, 0);
    }
    void ExpectTowards(const glm::vec3& direction, const glm::vec3& radiance) {
        EXPECT_LT(glm::distance(Towards(direction), radiance), 1e-5f)
            << direction.x << ' ' << direction.y << ' ' << direction.z;
    }
    SceneRender render{Device()};
};

}  // namespace

TEST_F(ImageLightScene, LightsTheSceneFromEachSideAsItsFileSays) {
    render.scene.SetScene(test::Load(SixColors()));
    ExpectTowards({1, 0, 0}, {0.5f, 0, 0});
    ExpectTowards({-1, 0, 0}, {0, 0.5f, 0});
    ExpectTowards({0, 1, 0}, {0, 0, 0.5f});
    ExpectTowards({0, -1, 0.1f}, {2.5f, 0, 0});
    ExpectTowards({0, 0, 1}, {0, 2.5f, 0});
    ExpectTowards({0, 0, -1}, {0, 0, 2.5f});
    EXPECT_EQ(render.scene.Statistics().lightCount, 1u) << "it is sampled";
    EXPECT_TRUE(render.scene.Environment().usesScene);
}

TEST_F(ImageLightScene, GivesWayToWhatAHostSetsAndToTheNextScene) {
    GpuScene& scene = render.scene;
    scene.SetScene(test::Load(SixColors()));
    const auto black = glm::vec3(0.0f), red = glm::vec3(0.5f, 0, 0);
    ExpectTowards({1, 0, 0}, red);
    // Turned by a quarter, +x is at -z; tinted
    scene.SetEnvironment({.radiance = {2, 1, 1}, .rotation = 1.5707963f, .usesScene = true});
    ExpectTowards({0, 0, -1}, 2.0f * red);
    scene.SetEnvironment({.radiance = {1, 2, 3}});
    ExpectTowards({1, 0, 0}, {1, 2, 3});
    scene.SetEnvironment({});
    ExpectTowards({1, 0, 0}, black);
    EXPECT_EQ(scene.Statistics().lightCount, 0u);
    const EnvironmentSettings own{
        .radiance = glm::vec3(1.0f), .usesScene = true, .defaultLight = DefaultLight::None};
    scene.SetEnvironment(own);
    const uint64_t version = scene.Revisions().environment;
    scene.SetEnvironmentMap({1, 1, {4, 5, 6, 1}});
    EXPECT_GT(scene.Revisions().environment, version);
    ExpectTowards({1, 0, 0}, {4, 5, 6});
    scene.SetScene(test::Load(SixColors()));
    ExpectTowards({1, 0, 0}, {4, 5, 6});
    scene.RemoveEnvironmentMap();
    ExpectTowards({1, 0, 0}, red);
    GltfDocument plain = SixColors();
    plain.json["scenes"][0].erase("extensions");
    scene.SetScene(test::Load(plain));
    ExpectTowards({1, 0, 0}, black);
    EXPECT_EQ(scene.Statistics().lightCount, 0u);
    // Values that no file has are refused, and the old scene stays
    scene.SetScene(test::Load(SixColors()));
    scene::SceneData bad = test::Load(SixColors());
    bad.environment.map.rgba[7] = -1.0f;
    EXPECT_THROW(scene.SetScene(std::move(bad)), Error);
    ExpectTowards({1, 0, 0}, red);
}

}  // namespace raygraph::testing::image_light_scene_test

// Programs that can do more than a scene needs.
namespace raygraph::testing::more_features_test {

using passes::TraceSettings;

namespace {

constexpr uint32_t kSamples = 64;
// The features of light and of what materials read; all features would take a minute to compile.
constexpr TraceFeatures kMore = SceneRender::kLightsAndTextures;

class MoreFeatures : public VulkanTest {
  protected:
    // Expects the same mean, to the noise, with more features.
    void ExpectSameMean(TraceSettings settings) {
        render.more = {};
        const RenderedImage own = render.Render(settings, kSamples);
        settings.seed = 1;
        render.more = kMore;
        const RenderedImage more = render.Render(settings, kSamples);
        const glm::dvec3 a = own.mean.Mean(), b = more.mean.Mean();
        const glm::dvec3 errorA = own.StandardErrorOfMean(), errorB = more.StandardErrorOfMean();
        EXPECT_GT(a.y, 0.0);
        for (int i = 0; i < 3; ++i) {
            const double error = std::hypot(errorA[i], errorB[i]);
            EXPECT_NEAR(a[i], b[i], 4.0 * error + 1e-6);
            EXPECT_LT(error, 0.03 * a[i]) << "too noisy to prove anything";
        }
    }

    SceneRender render{Device()};
};

TraceSettings Inside() {
    return LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, 24);
}

}  // namespace

// No light at all that could be sampled, no texture, nothing transparent: the sky alone, seen from inside.
TEST_F(MoreFeatures, OfAPlainScene_KeepTheMean) {
    scene::Material chalk;
    chalk.baseColorFactor = {0.7f, 0.5f, 0.3f, 1.0f};
    chalk.metallicFactor = 0.0f;
    chalk.roughnessFactor = 0.6f;
    render.scene.SetScene(SceneOf({QuadMesh(3.0f), BoxMesh(0.4f)}, {chalk},
                                  {Translation({0.0f, 0.0f, -2.0f}), Translation({0.4f, -0.5f, 0.1f})}));
    render.scene.SetEnvironment({.radiance = {0.4f, 0.5f, 0.6f}});
    ExpectSameMean(Inside());
}

TEST_F(MoreFeatures, OfALitRoom_KeepTheMean) {
    render.scene.SetScene(SceneOf({BoxMesh(1.0f), BoxMesh(0.4f, 1)},
                                  {Lambert(glm::vec3(0.6f), glm::vec3(0.3f)), Lambert(glm::vec3(0.8f))},
                                  {glm::mat4x3(1.0f), Translation({0.4f, -0.5f, 0.1f})}));
    ExpectSameMean(Inside());
}

// Nothing shines: features of light find none.
TEST_F(MoreFeatures, OfADarkScene_StayDark) {
    render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.6f))}));
    EXPECT_EQ(render.Render(Inside(), 1).mean.Mean(), glm::dvec3(0.0));
}

// A scene that is given features has those of a scene with what they are for, and no others.
TEST(WithFeatures, AreThoseOfTheProgram) {
    TraceSettings settings = Inside();
    settings.scattering.brdf = BrdfModel::Gltf;
    const SceneIds scene{.features = kTraceOpaque};
    for (const TraceFeatures feature :
         {kTraceAnyHit, kTraceThinWalls, kTraceCapsules, kTraceVolumes, kMore}) {
        const SceneIds wide = passes::WithFeatures(scene, feature);
        EXPECT_EQ(passes::ProgramFeatures(wide, settings), kTraceOpaque | feature);
    }
    const SceneIds asSet = passes::WithFeatures(scene, FeaturesOfKind(TraceFeatureKind::Settings));
    EXPECT_EQ(passes::ProgramFeatures(asSet, settings), kTraceOpaque);
}

// Programs have the features of the scene that settings use.
TEST(ProgramFeatures, AreThoseThatSettingsUse) {
    const TraceFeatures all = ~FeaturesOfKind(TraceFeatureKind::Settings) | kTraceTextureLod;
    const TraceFeatures scene = all & ~kTraceShadowCatcher;
    const auto of = [](TraceFeatures features, const std::function<void(TraceSettings&)>& set) {
        TraceSettings settings;
        set(settings);
        return passes::ProgramFeatures({.features = features}, settings);
    };
    const auto levels = [](TraceSettings& s) { s.biases.textureLod = 0.0f; };
    EXPECT_EQ(of(scene, levels), scene);
    EXPECT_EQ(of(scene, [](TraceSettings&) {}), scene & ~kTraceTextureLod);
    EXPECT_EQ(of(kTraceTextureLod | kTraceOpaque, levels), kTraceOpaque) << "nothing has levels";
    const TraceFeatures unlit = of(scene, [](TraceSettings& s) { s.lights.isOn = false; });
    EXPECT_EQ(unlit, scene & ~(FeaturesOfKind(TraceFeatureKind::Lights) | kTraceTextureLod));
    const TraceFeatures plain = of(scene, [](TraceSettings& s) { s.scattering.brdf = BrdfModel::Lambert; });
    EXPECT_EQ(plain, scene & ~(FeaturesOfKind(TraceFeatureKind::Lobes) | kTraceTextureLod));
    EXPECT_EQ(of({}, [](TraceSettings& s) { s.biases.shadowTerminator = true; }), kTraceShadowTerminator);
    const auto hide = [](TraceSettings& s) { s.isEnvironmentHidden = true; };
    EXPECT_EQ(of({}, hide), kTraceHiddenEnvironment);
    EXPECT_EQ(of(all, levels), scene) << "the camera sees a catcher as any surface before an environment";
    EXPECT_TRUE(of(all, hide).Has(kTraceShadowCatcher));
}

}  // namespace raygraph::testing::more_features_test
