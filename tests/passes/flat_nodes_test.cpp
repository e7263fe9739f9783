// Meshes that their nodes scale to a plane: seen, shaded and shining as the plane that they are, by every
// traversal and in the raster view.
#include <cmath>

#include "passes/raster.h"
#include "tests/passes/deforming_scene.h"
#include "tests/passes/flat_nodes.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/two_levels.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::flat_nodes_test {

using glm::vec2;
using glm::vec3;
using passes::TraceSettings;

namespace {

constexpr vec3 kColor{0.25f, 0.5f, 0.75f};

// Adds a mesh without a node, and its material.
void Add(scene::SceneData& scene, scene::Mesh mesh, const scene::Material& material,
         const glm::mat4x3& placed = glm::mat4x3(1.0f)) {
    mesh.primitives[0].material = static_cast<uint32_t>(scene.materials.size());
    scene.instances.push_back({.mesh = static_cast<uint32_t>(scene.meshes.size()), .objectToWorld = placed});
    scene.meshes.push_back(std::move(mesh));
    scene.materials.push_back(material);
}

scene::Material Shining(const vec3& emission, bool isDoubleSided) {
    scene::Material material = Lambert(vec3(0.0f), emission);
    material.isDoubleSided = isDoubleSided;
    return material;
}

// Rays are traced by the driver, or by own trees of one level or two.
class FlatNodes : public VulkanTest {
  protected:
    explicit FlatNodes(uint32_t levelCount = 0)
        : levels(levelCount),
          render(Device(), {.traversal = levelCount == 0 ? Traversal::Driver : Traversal::Software}) {}

    // Shows 3 m around the origin, seen along a direction.
    TraceSettings Along(const vec3& direction) const {
        const vec3 up = std::abs(direction.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
        scene::CameraView view = scene::CameraView::LookAt(-4.0f * direction, vec3(0.0f), up);
        view.projection = scene::Projection::Orthographic;
        view.height = 3.0f;
        TraceSettings settings;
        settings.extent = {48, 48};
        settings.camera = ToRecord(view);
        settings.scattering.brdf = BrdfModel::Lambert;
        return Traced(settings);
    }
    TraceSettings Traced(TraceSettings settings) const {
        settings.traversal = levels == 0 ? Traversal::Driver : Traversal::Software;
        return settings;
    }
    // Pixels that are not black; all numbers are finite.
    static size_t Covered(const FloatImage& image) {
        size_t covered = 0;
        for (const glm::vec4& value : image.values) {
            EXPECT_TRUE(std::isfinite(glm::dot(value, glm::vec4(1.0f))));
            covered += vec3(value) != vec3(0.0f);
        }
        return covered;
    }
    SceneRender::Hits Drawn(const TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        return render.ReadHits(passes::RasterHits(render.renderer, ids, settings, seen));
    }
    // The radiance of a small wall in the plane z = 0, which is white, over that of light all around it.
    double LightOnWall(bool isSampled, uint32_t samples) {
        TraceSettings settings = Traced(LookAt({0.5f, 0.0f, 0.5f}, {0, 0, 0}, 0.0005f, 32));
        settings.biases.maxDepth = 1;
        settings.lights.isOn = isSampled;
        if (isSampled) settings.lights.mis = MisHeuristic::Off;  // or paths make up for a part
        return render.Render(settings, samples).mean.Mean().y;
    }

    void SetScene(scene::SceneData&& data) {
        render.scene.SetScene(std::move(data));
        if (levels == 2) ForceTwoLevelTree(render);
    }

    const uint32_t levels;
    SceneRender render;
};

class FlatNodesByTraversal : public FlatNodes, public ::testing::WithParamInterface<uint32_t> {
  protected:
    FlatNodesByTraversal() : FlatNodes(GetParam()) {}
};
constexpr std::array kTraversals{"Driver", "OneLevel", "TwoLevels"};
INSTANTIATE_TEST_SUITE_P(Traversals, FlatNodesByTraversal, ::testing::Values(0u, 1u, 2u),
                         [](const auto& of) { return kTraversals[of.param]; });

}  // namespace

// By the sun, whose shadow rays are slanted, and by light from everywhere, from which paths come back: neither
// side of what is flat shadows the other one or itself. A plate in its place shows the same.
TEST_P(FlatNodesByTraversal, LitMeshesAreAsBrightAsAPlate) {
    constexpr float kAlbedo = 0.5f, kSlope = 1.2f;
    const double sunlit = double{kAlbedo} / M_PI / std::sqrt(1.0 + double{kSlope} * double{kSlope});
    std::vector<Chain> chains = Chains();
    chains.push_back({"a plate", {Scaled(vec3(1))}, {0, 0, 1}});
    for (const Chain& chain : chains) {
        const bool isPlate = &chain == &chains.back();
        std::vector<scene::Mesh> meshes{isPlate ? QuadMesh(0.5f) : BoxMesh(0.5f)};
        if (!isPlate) meshes.push_back(SphereMesh(0.5f, 24));
        for (const scene::Mesh& mesh : meshes)
            for (const float side : {1.0f, -1.0f}) {
                SCOPED_TRACE(chain.name);
                SCOPED_TRACE(&mesh == &meshes[0] ? "box" : "sphere");
                const vec3 normal = side * chain.normal;
                const auto expect = [&](TraceSettings settings, double expected) {
                    settings.biases.maxDepth = 4;
                    const FloatImage seen = render.TraceOnce(settings);
                    for (uint32_t y = 21; y < 27; ++y)
                        for (uint32_t x = 21; x < 27; ++x)
                            EXPECT_NEAR(double{seen.At(x, y).y}, expected, 1e-3 * expected);
                };
                scene::SceneData scene = Under(chain.nodes, mesh, Lambert(vec3(kAlbedo)));
                scene::Light& sun = scene.lights.emplace_back();
                sun.type = scene::LightType::Directional;
                const vec3 across = glm::normalize(glm::cross(normal, vec3(0.3f, 0.5f, 0.8f)));
                sun.lightToWorld[2] = glm::normalize(normal + kSlope * across);  // towards it
                SetScene(std::move(scene));
                expect(Along(-normal), sunlit);
                SetScene(Under(chain.nodes, mesh, Lambert(vec3(kAlbedo))));
                render.scene.SetEnvironment({.radiance = vec3(1.0f)});
                TraceSettings settings = Along(-normal);
                settings.lights.isOn = false;
                expect(settings, double{kAlbedo});
                render.scene.SetEnvironment({});
            }
    }
}

// From far away the distances of the two sides differ by few steps of float: the near one is still hit first,
// and the far one casts no shadow on it.
TEST_P(FlatNodesByTraversal, ABoxIsAsBrightFromFarAway) {
    constexpr float kAlbedo = 0.5f;
    for (const Chain& chain : Chains())
        for (const bool isDoubleSided : {false, true}) {
            SCOPED_TRACE(chain.name);
            scene::Material material = Lambert(vec3(kAlbedo));
            material.isDoubleSided = isDoubleSided;
            SetScene(Under(chain.nodes, BoxMesh(1.0f), material));
            render.scene.SetEnvironment({.radiance = vec3(1.0f)});
            for (const float distance : {5.0f, 100.0f, 200.0f}) {
                const vec3 eye = distance * glm::normalize(chain.normal + vec3(0.1f, 0.2f, 0.15f));
                TraceSettings settings = Traced(LookAt(eye, vec3(0.0f), 0.5f / distance, 48));
                settings.biases.maxDepth = 4;
                settings.lights.isOn = false;
                EXPECT_NEAR(double{render.TraceOnce(settings).Mean().y}, double{kAlbedo}, 2e-3)
                    << distance << " m, double-sided: " << isDoubleSided;
            }
            render.scene.SetEnvironment({});
        }
}

// Both sides of the box come to lie in one plane.
TEST_P(FlatNodesByTraversal, ABoxIsSeenFromBothSidesInItsColor) {
    for (const Chain& chain : Chains())
        for (const bool isDoubleSided : {false, true}) {
            SCOPED_TRACE(chain.name);
            SetScene(Under(chain.nodes, BoxMesh(0.5f), Shining(kColor, isDoubleSided)));
            for (const vec3& direction : {chain.normal, -chain.normal}) {
                const FloatImage seen = render.TraceOnce(Along(direction));
                for (uint32_t y = 20; y < 28; ++y)
                    for (uint32_t x = 20; x < 28; ++x) EXPECT_EQ(vec3(seen.At(x, y)), kColor);
                const size_t covered = Covered(seen);
                EXPECT_GT(covered, 48u * 48u / 12u);
                if (levels != 0) continue;  // it draws the same
                const SceneRender::Hits drawn = Drawn(Along(direction));
                const auto count =
                    std::ranges::count_if(drawn.ids, [](const glm::uvec4& id) { return id.x == 0; });
                EXPECT_NEAR(double(count), double(covered), 0.1 * double(covered)) << "the raster view";
            }
        }
}

// The nearer one of two sides of a box: the front of that side, and no other.
TEST_P(FlatNodesByTraversal, TheSideTowardsTheViewerIsSeen) {
    scene::Mesh box = BoxMesh(0.5f);
    scene::Primitive& sides = box.primitives[0];
    for (const vec3& normal : sides.normals)
        sides.colors.push_back(normal.z > 0.5f    ? glm::vec4(1, 0, 0, 1)
                               : normal.z < -0.5f ? glm::vec4(0, 1, 0, 1)
                                                  : glm::vec4(0, 0, 1, 1));
    scene::Material material = Lambert(vec3(1.0f));
    material.isUnlit = true;
    SetScene(Under({Scaled({1, 1, 0})}, box, material));
    EXPECT_EQ(vec3(render.TraceOnce(Along({0, 0, -1})).At(24, 24)), vec3(1, 0, 0));
    EXPECT_EQ(vec3(render.TraceOnce(Along({0, 0, 1})).At(24, 24)), vec3(0, 1, 0));
}

TEST_F(FlatNodes, NormalsAreThoseOfThePlane) {
    for (const Chain& chain : Chains()) {
        SCOPED_TRACE(chain.name);
        SetScene(Under(chain.nodes, SphereMesh(0.8f, 24), Lambert(vec3(0.5f))));
        const TraceSettings settings = Along(-chain.normal);
        const std::array both{render.PrimaryHits(settings), Drawn(settings)};
        for (const SceneRender::Hits& hits : both) {
            size_t surfaces = 0, others = 0;
            for (size_t i = 0; i < hits.ids.size(); ++i) {
                if (hits.ids[i].x != 0) continue;
                ++surfaces;
                others += glm::dot(vec3(hits.normal.values[i]), chain.normal) < 0.999f;
                EXPECT_LT(std::abs(glm::dot(vec3(hits.position.values[i]), chain.normal)), 8e-4f);
            }
            EXPECT_GT(surfaces, 300u);
            EXPECT_LT(others, surfaces / 100) << "the rim, at most";
        }
    }
}

// Where in the plane, by the texture coordinates that a hit has: those of rays in the mesh's own space are
// inexact, the more so the thinner a mesh is that is turned below a flat node.
TEST_F(FlatNodes, RaysHitThePlaneWhereTheyMeetIt) {
    std::vector<Chain> chains = Chains();
    const glm::quat turn = glm::angleAxis(0.9f, glm::normalize(vec3(1, 2, 3)));
    for (const float scale : {1e-9f, 1e-7f, 1e-5f, -1e-5f})
        chains.push_back({"almost 0", {Scaled({1, 1, scale}), Scaled(vec3(1), turn)}, {0, 0, 1}});
    for (const Chain& chain : chains) {
        SCOPED_TRACE(chain.name);
        SCOPED_TRACE(chain.nodes[0].scale.z);
        SetScene(Under(chain.nodes, SphereMesh(0.8f, 24), Lambert(vec3(0.5f))));
        const vec3 eye = 20.0f * glm::normalize(chain.normal + vec3(0.2f, 0.1f, 0.0f));
        const TraceSettings settings = Traced(LookAt(eye, vec3(0.0f), 0.1f, 48));
        const SceneRender::Hits hits = render.PrimaryHits(settings);
        double sum = 0.0, count = 0.0;
        for (uint32_t i = 0; i < hits.ids.size(); ++i) {
            if (hits.ids[i].x != 0) continue;
            const vec2 film = (vec2(i % 48, i / 48) + 0.5f) / 24.0f - 1.0f;
            const glm::dvec3 ray = glm::dvec3(settings.camera.forward) +
                                   double{film.x} * glm::dvec3(settings.camera.right) -
                                   double{film.y} * glm::dvec3(settings.camera.up);
            const glm::dvec3 meets = glm::dvec3(eye) - glm::dot(glm::dvec3(eye), glm::dvec3(chain.normal)) /
                                                           glm::dot(ray, glm::dvec3(chain.normal)) * ray;
            const double off = glm::distance(meets, glm::dvec3(hits.position.values[i]));
            sum += off * off;
            ++count;
        }
        EXPECT_GT(count, 300.0);
        EXPECT_LT(std::sqrt(sum / count), 1.3e-4 * 20.0);
    }
}

TEST_P(FlatNodesByTraversal, TheFrontOfACardIsThatOfASmallScale) {
    const glm::quat turn = glm::angleAxis(0.5f, glm::normalize(vec3(2, -1, 1)));
    for (const vec3& scale : {vec3(1, 1, 0), vec3(-1, 1, 0), vec3(1, -1, 0), vec3(-1, -1, 0)})
        for (const bool isBelow : {false, true}) {
            std::vector<scene::Node> nodes{Scaled(scale)};
            if (isBelow) nodes.push_back(Scaled(vec3(1), turn));
            std::array<size_t, 2> thin{}, flat{};
            for (const bool isFlat : {false, true}) {
                nodes[0].scale.z = isFlat ? 0.0f : 0.01f;
                SetScene(Under(nodes, QuadMesh(0.8f), Shining(kColor, false)));
                std::array<size_t, 2>& covered = isFlat ? flat : thin;
                covered[0] = Covered(render.TraceOnce(Along({0, 0, -1})));
                covered[1] = Covered(render.TraceOnce(Along({0, 0, 1})));
            }
            EXPECT_EQ(flat[0] > 300u, thin[0] > 300u) << scale.x << scale.y << isBelow;
            EXPECT_EQ(flat[1] > 300u, thin[1] > 300u);
            EXPECT_EQ(std::min(flat[0], flat[1]), 0u) << "one side is culled";
        }
}

// The form factors of a square of 1 m and of a disc, above the middle. Far away a shadow ray ends before the
// thickness of what is flat.
TEST_P(FlatNodesByTraversal, FlatMeshesShineAsTheirPlanes) {
    const auto square = [](double distance) {
        const double slope = 0.5 / distance, side = slope / std::sqrt(1.0 + slope * slope);
        return 4.0 / M_PI * side * std::atan(side);
    };
    const auto disc = [](double distance) { return 0.25 / (0.25 + distance * distance); };
    struct Lamp {
        const char* name;
        scene::Mesh mesh;
        std::function<double(double)> formFactor;
        bool isShared = false;
    };
    scene::Mesh both = QuadMesh(0.5f);  // one triangle faces up, the other one down
    std::swap(both.primitives[0].indices[4], both.primitives[0].indices[5]);
    // The last one is placed twice, so that each placement is one light; the other placement is out of sight
    const std::array lamps{Lamp{"card", QuadMesh(0.5f), square}, Lamp{"card wound both ways", both, square},
                           Lamp{"box", BoxMesh(0.5f), square}, Lamp{"ball", SphereMesh(0.5f, 24), disc},
                           Lamp{"balls", SphereMesh(0.5f, 64), disc, true}};
    for (const Lamp& lamp : lamps)
        for (const float distance : {1.0f, 7.0f})
            for (const bool isDoubleSided : {false, true}) {
                if (&lamp < &lamps[2] && !isDoubleSided) continue;  // it faces up
                SCOPED_TRACE(std::string(lamp.name) + (isDoubleSided ? ", both sides" : ""));
                SCOPED_TRACE(distance);
                const glm::quat turn = glm::angleAxis(0.3f, vec3(0, 0, 1));
                scene::SceneData scene = Under({Scaled(vec3(1), turn), Scaled({1, 1, 0})}, lamp.mesh,
                                               Shining(vec3(1.0f), isDoubleSided), {0, 0, distance});
                if (lamp.isShared) {
                    scene::Instance& other = scene.instances.emplace_back(scene.instances[0]);
                    other.node = scene::kNone;
                    other.objectToWorld[3].z = -5.0f;
                }
                Add(scene, QuadMesh(0.001f), Lambert(vec3(1.0f)));
                SetScene(std::move(scene));
                const double expected = lamp.formFactor(double{distance});
                EXPECT_NEAR(LightOnWall(true, lamp.isShared ? 128 : 64), expected, 0.01 * expected);
                if (distance > 1.0f) continue;  // chance finds none there
                EXPECT_NEAR(LightOnWall(false, 64), expected, 0.02 * expected);
            }
}

// A box that a chain of nodes flattens has the light of its outline, whose area is the sum of those of the
// three sides.
TEST_F(FlatNodes, BoxesShineAsTheirOutlines) {
    for (const Chain& chain : Chains()) {
        std::vector<scene::Node> nodes = chain.nodes;
        nodes.insert(nodes.begin(), Scaled(vec3(1), glm::quat(chain.normal, vec3(0, 0, 1))));
        for (const float distance : {7.0f, 50.0f})
            for (const bool isDoubleSided : {false, true}) {
                scene::SceneData scene =
                    Under(nodes, BoxMesh(0.5f), Shining(vec3(1.0f), isDoubleSided), {0, 0, distance});
                const glm::dmat3 linear(scene.instances[0].objectToWorld);
                double area = 0.0;
                for (int i = 0; i < 3; ++i) area += glm::length(glm::cross(linear[i], linear[(i + 1) % 3]));
                Add(scene, QuadMesh(0.001f), Lambert(vec3(1.0f)));
                SetScene(std::move(scene));
                render.scene.SetEnvironment({.defaultLight = DefaultLight::None});
                const double expected = area / (M_PI * double{distance} * double{distance});
                EXPECT_NEAR(LightOnWall(true, 16), expected, (distance < 10.0f ? 0.025 : 0.01) * expected)
                    << chain.name << ", " << distance << " m, double-sided: " << isDoubleSided;
            }
    }
}

// Into flatness, to a line, and out of it again; as a light, too.
TEST_P(FlatNodesByTraversal, AnAnimationGoesThroughFlatness) {
    scene::SceneData scene =
        Under({Scaled(vec3(1)), Scaled(vec3(1))}, BoxMesh(0.5f), Shining(vec3(2.0f), true), {0, 0, 1});
    Add(scene, QuadMesh(0.001f), Lambert(vec3(1.0f)));
    scene::Animation& clip = scene.animations.emplace_back();
    clip.duration = 4.0f;
    clip.samplers.push_back(
        {.width = 3, .times = {0, 1, 2, 3, 4}, .values = {1, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0, 0, 1, 1, -1}});
    clip.channels.push_back({0, {.property = scene::AnimatedProperty::Scale, .object = 0}});
    PosedScene posed(std::move(scene));
    scene::SceneData data = posed.scene;
    SetScene(std::move(data));
    const double flat = 2.0 * 0.239456;
    for (const double seconds : {0.0, 1.0, 2.0, 1.0, 3.0, 1.0, 0.5, 1.0, 2.0, 4.0}) {
        SCOPED_TRACE(seconds);
        render.scene.SetPose(posed.scene, posed.applier, posed.MoveTo(seconds));
        const size_t covered = Covered(render.TraceOnce(Along({0, 0, -1})));
        const double light = LightOnWall(true, 16);
        const bool isSeen = seconds < 1.5 || seconds > 3.5;
        EXPECT_EQ(render.scene.IsVisible(0), isSeen);
        EXPECT_EQ(covered > 200u, isSeen);
        EXPECT_EQ(covered > 0u, isSeen);
        EXPECT_EQ(light > 0.0, isSeen);
        if (seconds == 1.0) {
            EXPECT_NEAR(light, flat, 0.01 * flat);
        } else if (isSeen) {
            EXPECT_GT(light, 1.1 * flat) << "it is nearer";
        }
    }
}

// In light from everywhere glass that absorbs nothing is not to be told from nothing.
TEST_P(FlatNodesByTraversal, GlassNeitherLosesLightNorMakesUpNumbers) {
    scene::Material glass;
    glass.metallicFactor = 0.0f;
    glass.roughnessFactor = 0.0f;
    glass.transmissionFactor = 1.0f;
    glass.thicknessFactor = 1.0f;
    glass.attenuationDistance = 0.5f;
    glass.attenuationColor = vec3(0.1f);
    for (const Chain& chain : Chains()) {
        SCOPED_TRACE(chain.name);
        for (const bool isBall : {false, true}) {
            SetScene(Under(chain.nodes, isBall ? SphereMesh(0.8f, 24) : BoxMesh(0.8f), glass));
            render.scene.SetEnvironment({.radiance = vec3(1.0f)});
            TraceSettings settings = Along(-chain.normal);
            settings.scattering.brdf = BrdfModel::Gltf;
            const FloatImage seen = render.Render(settings, 4).mean;
            Covered(seen);
            EXPECT_NEAR(seen.Mean().y, 1.0, 0.01) << isBall;
        }
    }
}

// Stretched highlights, coats, sheen and bent normals on what is flat, to the rim.
TEST_F(FlatNodes, NoMaterialMakesUpNumbers) {
    scene::Material material = Lambert(vec3(0.7f));
    material.roughnessFactor = 0.3f;
    material.metallicFactor = 0.5f;
    material.anisotropyStrength = 0.8f;
    material.clearcoatFactor = 0.5f;
    material.sheenColorFactor = vec3(0.5f);
    material.sheenRoughnessFactor = 0.4f;
    for (const Chain& chain : Chains()) {
        SCOPED_TRACE(chain.name);
        SetScene(Under(chain.nodes, SphereMesh(0.8f, 24), material));
        render.scene.SetEnvironment({.radiance = vec3(1.0f)});
        for (const float tilt : {0.0f, 1.5f}) {
            TraceSettings settings = Along(glm::normalize(-chain.normal + tilt * vec3(0.3f, 0.9f, 0.1f)));
            settings.scattering.brdf = BrdfModel::Gltf;
            EXPECT_GT(Covered(render.Render(settings, 4).mean), 0u);
        }
    }
}

TEST_P(FlatNodesByTraversal, AHostMayFlattenWhatItPlaces) {
    const glm::mat4x3 flat{vec3(1, 0, 0), vec3(0, 1, 0), vec3(0), vec3(0)};
    scene::SceneData scene = SceneOf({BoxMesh(0.5f)}, {Shining(kColor, true)}, {flat});
    SetScene(std::move(scene));
    const auto covered = [&] { return Covered(render.TraceOnce(Along({0, 0, -1}))); };
    const size_t set = covered();
    EXPECT_GT(set, 200u);
    render.scene.SetTransform(0, glm::mat4x3(1.0f));
    render.scene.SetTransform(0, flat);
    const SceneRevisions before = render.scene.Revisions();
    render.scene.SetTransform(0, flat);
    render.scene.SetTransform(0, render.scene.Transform(0));
    EXPECT_EQ(render.scene.Revisions(), before) << "nothing has changed";
    EXPECT_EQ(covered(), set);
    render.scene.SetVisible(0, false);
    EXPECT_EQ(covered(), 0u);
    render.scene.AddInstance(0, scene::PlacedTransform{flat});
    EXPECT_EQ(covered(), set);
}

// EXT_mesh_gpu_instancing: two of three are flat, of which one shows its back.
TEST_F(FlatNodes, InstancesOfANodeMayBeFlat) {
    test::GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial({{"emissiveFactor", {1, 1, 1}}});
    test::Json& attributes = document.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    attributes["TRANSLATION"] = document.AddAccessor<float>({-1.2f, 0, 0, 0, 0, 0, 1.4f, 0, 0}, 3);
    attributes["SCALE"] = document.AddAccessor<float>({1, 1, 1, 1, 1, 0, -1, 1, 0}, 3);
    scene::SceneData scene = test::Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.instances.size(), 3u);
    SetScene(std::move(scene));
    const FloatImage front = render.TraceOnce(Along({0, 0, -1}));
    const auto at = [](const FloatImage& image, float x, float y) {
        return image.At(uint32_t((x + 1.5f) * 16.0f), uint32_t((1.5f - y) * 16.0f)).x;
    };
    EXPECT_EQ(at(front, -0.9f, 0.3f), 1.0f);
    EXPECT_EQ(at(front, 0.3f, 0.3f), 1.0f);
    EXPECT_EQ(at(front, 1.1f, 0.3f), 1.0f);
    EXPECT_EQ(Covered(render.TraceOnce(Along({0, 0, 1}))), 0u) << "all of them face the other side";
}

}  // namespace raygraph::testing::flat_nodes_test
