// Round primitives on the device: hits against closed forms, pictures against triangle meshes and furnaces.
#include <cmath>

#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_capsules_test {

using passes::TraceSettings;

namespace {

// From x = -1 to 1, of radius 0.5.
scene::Mesh Capsule(uint32_t material = 0) {
    return RoundMesh({{-1, 0, 0}, {1, 0, 0}}, {0, 1}, {0.5f}, material);
}

// With back faces and gloss, of glTF's model.
scene::Material Gloss() {
    scene::Material material;
    material.baseColorFactor = {0.8f, 0.5f, 0.3f, 1.0f};
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.4f;
    return material;
}

scene::Material Glass(float thickness, const glm::vec3& tint = glm::vec3(1.0f)) {
    scene::Material material;
    material.baseColorFactor = glm::vec4(tint, 1.0f);
    material.metallicFactor = 0.0f;
    material.roughnessFactor = 0.0f;
    material.transmissionFactor = 1.0f;
    material.thicknessFactor = thickness;
    return material;
}

class TraceCapsules : public VulkanTest {
  protected:
    // The means of both agree to `tolerance`, with noise that could have shown a failure.
    void ExpectSameMean(const RenderedImage& a, const RenderedImage& b, double tolerance) {
        for (int channel = 0; channel < 3; ++channel) {
            const double error = a.StandardErrorOfMean()[channel] + b.StandardErrorOfMean()[channel];
            EXPECT_NEAR(a.mean.Mean()[channel], b.mean.Mean()[channel],
                        tolerance * b.mean.Mean()[channel] + 4.0 * error)
                << "channel " << channel;
            EXPECT_LT(4.0 * error, tolerance * b.mean.Mean()[channel]) << "too noisy to prove anything";
        }
    }
    void ExpectMean(const RenderedImage& image, double expected, double tolerance) {
        for (int channel = 0; channel < 3; ++channel) {
            EXPECT_NEAR(image.mean.Mean()[channel], expected, tolerance * expected) << "channel " << channel;
            EXPECT_LT(3.0 * image.StandardErrorOfMean()[channel], tolerance * expected) << "too noisy";
        }
    }
    // Positions are on the surface f = 0 of the world, and normals along its gradient.
    template <typename Value, typename Gradient>
    void ExpectHitsOn(const TraceSettings& settings, Value&& value, Gradient&& gradient, double share) {
        const SceneRender::Hits hits = render.PrimaryHits(settings);
        size_t hitCount = 0;
        for (size_t i = 0; i < hits.ids.size(); ++i) {
            if (hits.ids[i].x == 0xFFFFFFFFu) continue;
            ++hitCount;
            const glm::dvec3 position(hits.position.values[i]), normal(hits.normal.values[i]);
            ASSERT_LT(std::abs(value(position)), 2e-6) << i;
            ASSERT_GT(glm::dot(normal, glm::normalize(gradient(position))), 1.0 - 1e-6) << i;
        }
        EXPECT_NEAR(double(hitCount) / double(hits.ids.size()), share, 0.01);
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(TraceCapsules, Trace_SpheresAndCapsulesAreHitOnTheirSurfaces) {
    render.scene.SetScene(SceneOf({RoundSphere(1.0f)}, {Lambert(glm::vec3(0.5f))}));
    const TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 64);
    const double edge = 1.0 / std::sqrt(15.0) / std::tan(0.35);  // of half the picture
    ExpectHitsOn(
        settings, [](const glm::dvec3& p) { return glm::length(p) - 1.0; },
        [](const glm::dvec3& p) { return p; }, M_PI * edge * edge / 4.0);

    render.scene.SetScene(SceneOf({Capsule()}, {Lambert(glm::vec3(0.5f))}));
    const auto axis = [](const glm::dvec3& p) { return glm::dvec3(glm::clamp(p.x, -1.0, 1.0), 0, 0); };
    TraceSettings parallel = LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 128);
    parallel.camera.orthographic = 1;
    parallel.camera.right = {2, 0, 0};
    parallel.camera.up = {0, 2, 0};
    parallel.camera.zFar = 10.0f;
    ExpectHitsOn(
        parallel, [&](const glm::dvec3& p) { return glm::length(p - axis(p)) - 0.5; },
        [&](const glm::dvec3& p) { return p - axis(p); }, (2.0 + M_PI * 0.25) / 16.0);
}

// A sphere in object space becomes the ellipsoid of its transform: surface, normals, and as seen in a mirror.
TEST_F(TraceCapsules, Trace_UnevenAndMirroringTransformsMakeEllipsoids) {
    for (const float mirror : {1.0f, -1.0f}) {
        const glm::mat4x3 transform{
            {mirror * 0.5f, 0.2f, 0}, {0, 1.2f, 0}, {0.1f, 0, 0.8f}, {0.3f, -0.2f, 0.1f}};
        render.scene.SetScene(SceneOf({RoundSphere(1.0f)}, {Lambert(glm::vec3(0.5f))}, {transform}));
        const glm::dmat3 inverse = glm::inverse(glm::dmat3(glm::mat3(transform)));
        const auto inObject = [&](const glm::dvec3& p) { return inverse * (p - glm::dvec3(transform[3])); };
        const SceneRender::Hits hits = render.PrimaryHits(LookAt({0, 0, 6}, {0, 0, 0}, 0.6f, 64));
        size_t hitCount = 0;
        for (size_t i = 0; i < hits.ids.size(); ++i) {
            if (hits.ids[i].x == 0xFFFFFFFFu) continue;
            ++hitCount;
            const glm::dvec3 p = inObject(glm::dvec3(hits.position.values[i]));
            ASSERT_NEAR(glm::length(p), 1.0, 3e-6);
            const glm::dvec3 normal = glm::normalize(glm::transpose(inverse) * p);
            ASSERT_GT(glm::dot(normal, glm::dvec3(hits.normal.values[i])), 1.0 - 1e-6);
        }
        EXPECT_GT(hitCount, 500u);
    }
}

TEST_F(TraceCapsules, Trace_APictureOfSpheresIsThatOfTheirMeshes) {
    render.scene.SetEnvironmentMap(EveningSky());
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, 1, 4}, {0, 0, 0}, 0.8f, 64);
    settings.scattering.brdf = BrdfModel::Gltf;
    const std::vector<glm::mat4x3> places{Translation({-1, 0, 0}), Translation({1, 0, 0}),
                                          Translation({0, -3, 0})};
    const auto scene = [&](const scene::Mesh& ball) {
        scene::Mesh floor = QuadMesh(3.0f, 1);
        for (glm::vec3& p : floor.primitives[0].positions) p = {p.x, 2.0f, -p.y};
        floor.primitives[0].normals.assign(floor.primitives[0].positions.size(), {0, 1, 0});
        floor.primitives[0].bounds = {{-3, 2, -3}, {3, 2, 3}};
        return SceneOf({ball, ball, floor}, {Gloss(), Lambert(glm::vec3(0.6f))}, places);
    };
    render.scene.SetScene(scene(SphereMesh(0.9f, 256)));
    const RenderedImage mesh = render.Render(settings, 160);
    render.scene.SetScene(scene(RoundSphere(0.9f)));
    const RenderedImage round = render.Render(settings, 160);
    ExpectSameMean(round, mesh, 0.01);
    ExpectSameImage(round, mesh, "spheres", PixelErrors::Independent);
}

TEST_F(TraceCapsules, Trace_WhiteCapsulesAndGlassVanishInUnitEnvironment) {
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, 1, 4}, {0, 0, 0}, 0.7f, 32);
    render.scene.SetScene(SceneOf({Capsule(), RoundSphere(0.4f)}, {Lambert(glm::vec3(1.0f))},
                                  {glm::mat4x3(1.0f), Translation({0.0f, 0.8f, 0.2f})}));
    ExpectMean(render.Render(settings, 64), 1.0, 0.003);
    // Light that goes in comes out: each ray that starts inside leaves
    settings.scattering.brdf = BrdfModel::Gltf;
    for (const float thickness : {0.0f, 1.0f}) {
        render.scene.SetScene(SceneOf({Capsule(), RoundSphere(0.4f)}, {Glass(thickness)},
                                      {glm::mat4x3(1.0f), Translation({0.0f, 1.0f, 0.2f})}));
        ExpectMean(render.Render(settings, 64), 1.0, 0.003);
    }
}

// Beer's law along a chord of a glass sphere of index 1, which refracts nothing.
TEST_F(TraceCapsules, Trace_AMediumInASphereAbsorbsAlongItsChord) {
    scene::Material glass = Glass(1.0f);
    glass.ior = 1.0f;
    glass.attenuationColor = glm::vec3(0.5f);
    glass.attenuationDistance = 2.0f;
    render.scene.SetScene(SceneOf({RoundSphere(1.5f)}, {glass}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    TraceSettings settings = LookAt({0, 0, 9}, {0, 0, 0}, 1e-3f, 8);
    settings.scattering.brdf = BrdfModel::Gltf;
    ExpectMean(render.Render(settings, 4), std::pow(0.5, 3.0 / 2.0), 0.002);
}

// The shadow of a line on a floor, under the sun: black within its radius, full light outside.
TEST_F(TraceCapsules, Trace_ALineCastsTheShadowOfItsRadius) {
    scene::SceneData scene =
        SceneOf({QuadMesh(4.0f, 0), RoundMesh({{0, -9, 1}, {0, 9, 1}}, {0, 1}, {0.25f}, 1)},
                {Lambert(glm::vec3(0.5f)), Lambert(glm::vec3(0.0f))});
    scene::Light sun;  // along -z
    sun.type = scene::LightType::Directional;
    sun.intensity = 2.0f;
    scene.lights = {sun};
    render.scene.SetScene(std::move(scene));
    for (const auto& [x, expected] :
         {std::pair{0.0f, 0.0}, {0.24f, 0.0}, {-0.24f, 0.0}, {0.26f, 1.0}, {-0.26f, 1.0}}) {
        TraceSettings settings = LookAt({x, 0, 0.5f}, {x, 0, 0}, 1e-3f, 8);
        settings.biases.maxDepth = 1;
        EXPECT_NEAR(render.Render(settings, 4).mean.Mean().y, expected * 0.5 * 2.0 / M_PI, 1e-4) << x;
    }
}

// Each side stops the share alpha of the light, one-sided ones only from outside: the sun on the floor, through
// any-hit of shadow rays, and the floor seen from above, through that of camera rays.
TEST_F(TraceCapsules, Trace_BlendedSpheresPassTheirShareOfEachSide) {
    for (const bool isDoubleSided : {false, true}) {
        scene::Material veil = Lambert(glm::vec3(0.0f));
        veil.alphaMode = scene::AlphaMode::Blend;
        veil.baseColorFactor.a = 0.6f;
        veil.isDoubleSided = isDoubleSided;
        scene::Mesh ball = RoundSphere(0.5f, 1, {0, 0, 2});
        ball.primitives[0].colors = {{1, 1, 1, 0.5f}};  // alpha 0.3 in all
        // Instance 0 is the ball: the number that tells surfaces apart is 0 for its primitive
        scene::SceneData scene = SceneOf({ball, QuadMesh(4.0f, 0)}, {Lambert(glm::vec3(0.5f)), veil});
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 2.0f;
        scene.lights = {sun};
        render.scene.SetScene(std::move(scene));
        const double passed = isDoubleSided ? 0.7 * 0.7 : 0.7;
        TraceSettings settings = LookAt({0.2f, 0, 0.5f}, {0.2f, 0, 0}, 1e-3f, 32);
        settings.biases.maxDepth = 1;
        ExpectMean(render.Render(settings, 256), passed * 0.5 * 2.0 / M_PI, 0.01);
        // From above: seen through the ball as well as lit through it
        settings = LookAt({0.2f, 0, 6}, {0.2f, 0, 0}, 1e-3f, 32);
        settings.biases.maxDepth = 1;
        ExpectMean(render.Render(settings, 256), passed * passed * 0.5 * 2.0 / M_PI, 0.015);
    }
}

// A smooth thin wall is a hole for a share of the light, at each of its two sides, with and without other
// surfaces that are tested in the scene.
TEST_F(TraceCapsules, Trace_LightThroughAThinWalledSphereIsThatOfItsTwoWalls) {
    for (const bool hasAlpha : {false, true}) {
        SCOPED_TRACE(hasAlpha ? "with a veil elsewhere" : "alone");
        scene::Material veil = Lambert(glm::vec3(0.0f));
        veil.alphaMode = scene::AlphaMode::Blend;
        veil.baseColorFactor.a = 0.5f;
        scene::SceneData scene = SceneOf(
            {QuadMesh(1.0f, 0), RoundSphere(0.5f, 1, {0, 0, 2}), RoundSphere(0.5f, 2, {9, 0, 2})},
            {Lambert(glm::vec3(0.5f)), Glass(0.0f, {0.8f, 0.5f, 0.3f}), hasAlpha ? veil : Lambert({})});
        scene.materials[0].metallicFactor = 0.0f;
        scene.materials[0].specularFactor = 0.0f;
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 2.0f;
        scene.lights = {sun};
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt({0, 0, 0.5f}, {0, 0, 0}, 1e-3f, 8);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 1;
        const glm::dvec3 mean = render.Render(settings, 8).mean.Mean();
        const glm::dvec3 tint(0.8, 0.5, 0.3);
        for (int channel = 0; channel < 3; ++channel) {
            const double expected = 0.5 * 2.0 / M_PI * std::pow(0.96 * tint[channel], 2.0);
            EXPECT_NEAR(mean[channel], expected, 0.01 * expected) << channel;
        }
    }
}

// Two segments of one primitive: colors run along each, ids count in the file's order, and the emission of a
// round primitive is found by rays.
TEST_F(TraceCapsules, Trace_ColorsRunAlongSegmentsAndIdsAreTheFiles) {
    scene::Mesh lines = RoundMesh({{-1, 0.5f, 0}, {1, 0.5f, 0}, {-1, -0.5f, 0}, {1, -0.5f, 0}}, {2, 3, 0, 1},
                                  {0.2f, 0.2f}, 1);
    lines.primitives[0].colors = {{0, 0, 1, 1}, {1, 0, 1, 1}, {0, 1, 1, 1}, {1, 1, 1, 1}};
    scene::Mesh both = RoundSphere(0.1f, 0, {0, 2, 0});
    both.primitives.push_back(lines.primitives[0]);
    scene::Material unlit = Lambert(glm::vec3(1.0f));
    unlit.isUnlit = true;
    render.scene.SetScene(SceneOf({QuadMesh(0.1f, 0), both}, {Lambert(glm::vec3(0.5f)), unlit},
                                  {Translation({9, 9, 0}), glm::mat4x3(1.0f)}));
    const SceneRender::Hits hits = render.PrimaryHits(LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 64));
    size_t seen[2] = {};
    for (size_t i = 0; i < hits.ids.size(); ++i) {
        if (hits.ids[i].x == 0xFFFFFFFFu) continue;
        const glm::vec4 position = hits.position.values[i], color = hits.albedo.values[i];
        ASSERT_EQ(hits.ids[i].x, 1u);
        ASSERT_EQ(hits.ids[i].y, 1u);
        ASSERT_EQ(hits.ids[i].z, position.y < 0.0f ? 0u : 1u);
        seen[hits.ids[i].z]++;
        ASSERT_NEAR(color.x, glm::clamp(0.5f + 0.5f * position.x, 0.0f, 1.0f), 1e-5f);
        ASSERT_NEAR(color.y, position.y < 0.0f ? 1.0f : 0.0f, 1e-6f);
    }
    EXPECT_GT(seen[0], 100u);
    EXPECT_GT(seen[1], 100u);
    const FloatImage shines = render.TraceOnce(LookAt({0, -0.5f, 4}, {0, -0.5f, 0}, 1e-3f, 8));
    EXPECT_NEAR(shines.Mean().x, 0.5, 0.01);
    EXPECT_NEAR(shines.Mean().y, 1.0, 1e-5);
}

// An edit that changes how rays treat a round group builds it again, and its other sides follow.
TEST_F(TraceCapsules, Trace_AMaterialThatIsEditedTakesEffect) {
    scene::Material veil = Lambert(glm::vec3(0.5f));
    veil.alphaMode = scene::AlphaMode::Mask;
    render.scene.SetScene(SceneOf({RoundSphere(0.5f)}, {veil}));
    const TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 1e-2f, 4);
    EXPECT_EQ(render.PrimaryHits(settings).ids[0].x, 0u);
    veil.baseColorFactor.a = 0.2f;
    render.scene.SetMaterial(0, veil);
    EXPECT_EQ(render.PrimaryHits(settings).ids[0].x, 0xFFFFFFFFu) << "below the cutoff it is a hole";
    // From inside, back faces are culled where they are one-sided
    veil.baseColorFactor.a = 1.0f;
    veil.isDoubleSided = false;
    render.scene.SetMaterial(0, veil);
    const TraceSettings inside = LookAt({0, 0, 0}, {0, 0, 1}, 1e-2f, 4);
    EXPECT_EQ(render.PrimaryHits(inside).ids[0].x, 0xFFFFFFFFu);
    veil.isDoubleSided = true;
    render.scene.SetMaterial(0, veil);
    EXPECT_EQ(render.PrimaryHits(inside).ids[0].x, 0u);
}

TEST_F(TraceCapsules, Trace_MeshesBesideRoundPrimitivesKeepTheirBits) {
    const auto scene = [](bool hasPoint) {
        scene::SceneData room = RoomWithLamp();
        if (hasPoint) {
            room.meshes.push_back(RoundSphere(0.01f));
            scene::Instance far;
            far.mesh = static_cast<uint32_t>(room.meshes.size() - 1);
            far.objectToWorld = Translation({0, -1000, 0});
            room.instances.push_back(far);
        }
        return room;
    };
    render.scene.SetScene(scene(false));
    const SceneRender::Hits without = render.PrimaryHits(ViewOfRoom(32));
    render.scene.SetScene(scene(true));
    const SceneRender::Hits with = render.PrimaryHits(ViewOfRoom(32));
    EXPECT_EQ(without.ids, with.ids);
    EXPECT_EQ(without.position.values, with.position.values);
}

}  // namespace raygraph::testing::trace_capsules_test
