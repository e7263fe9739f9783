// The path integrator: energy, depth, roulette, media, light through smooth thin walls, and surfaces that transmit
// diffusely.
#include <set>

#include "tests/shading/path_scene.h"

namespace raygraph::shading::path_test {
namespace {

// All materials are Lambert's unless a test says otherwise.
class Path : public PathFixture {
  protected:
    Path() { UseOptions({}, BrdfModel::Lambert); }
};
using SheetPath = Path;

struct Ball {
    float radius = 1.0f;
    vec3 albedo{0.0f};
    float metallic = 0.0f;
    float roughness = 0.0f;
    vec3 emission{0.0f};
};

// A sphere about the origin in even radiance from everywhere, which paths find by chance: the light table is empty.
void SetScene(const Ball& ball, float environment = 0.0f) {
    testLights = {};
    testLights.environmentTint = vec3(environment);
    Shape sphere{.radius = ball.radius, .emission = [=](vec3, bool) { return ball.emission; }};
    sphere.material.baseColor = ball.albedo;
    sphere.material.metallic = ball.metallic;
    sphere.material.roughness = ball.roughness;
    sphere.material.ior = 1.5f;
    shapes = {sphere};
}

const vec3 kWallTint(0.9f, 0.7f, 0.5f);

SurfaceMaterial WallMaterial() {
    SurfaceMaterial material = ClearMaterial(1.5f, 0u);
    material.baseColor = kWallTint;
    return material;
}

// A sheet that transmits diffusely, under a rough layer unless `specular` is 0.
SurfaceMaterial PaperMaterial(float transmission, float specular) {
    SurfaceMaterial material = WallMaterial();
    material.transmission = 0.0f;
    material.roughness = 0.6f;
    material.specular = specular;
    material.diffuseTransmission = transmission;
    material.diffuseTransmissionColor = vec3(0.5f, 0.8f, 0.9f);
    return material;
}

void AddWalls(const std::vector<float>& heights, const SurfaceMaterial& material = WallMaterial()) {
    for (const float height : heights)
        shapes.push_back({.kind = Shape::Kind::Plane, .height = height, .material = material});
}

// Fills the sphere.
void Fill(const SurfaceMaterial& boundary, float extinction, float ior) {
    shapes[0].material = boundary;
    shapes[0].material.flags = kMaterialVolume;
    shapes[0].medium.extinction = vec3(extinction);
    shapes[0].medium.ior = ior;
}

// So large that light sampling goes by area.
void AddLargeLamp() {
    AddLamp({vec3(-60.0f, -50.0f, 2.5f), vec3(60.0f, -50.0f, 2.5f), vec3(0.0f, 80.0f, 2.5f)}, vec3(4.0f),
            true);
}

void AddPointLight() {
    testLights.AddPunctual(scene::LightType::Point, vec3(0.0f, 0.0f, 4.0f), vec3(0.0f, 0.0f, -1.0f),
                           vec3(9.0f));
    testLights.Build();
}

Ray FromCenter() {
    return {.origin = vec3(0.0f), .direction = normalize(vec3(0.3f, -0.5f, 0.7f))};
}

// The sphere from above, in the middle of the picture.
Ray FromAbove() {
    return {.origin = vec3(0.0f, 0.0f, 5.0f), .direction = vec3(0.0f, 0.0f, -1.0f)};
}

PathState Traced(Ray ray, PathSettings settings, MediumStack media) {
    PathState path = StartPath(ray, StartPixelSample(uvec2(0u), 0u, 0u));
    path.media = media;
    while (ExtendPath(path, settings)) {
    }
    return path;
}

}  // namespace

TEST_F(Path, ClosedSphereHasRadianceOneOverOneMinusAlbedo) {
    for (const float albedo : {0.2f, 0.5f, 0.8f}) {
        SetScene({.albedo = vec3(albedo), .emission = vec3(1.0f)});
        const Mean mean = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 3u), 1u << 16);
        const double expected = 1.0 / (1.0 - albedo);
        EXPECT_NEAR(mean.radiance.y, expected, 4.0 * mean.error.y + 1e-4) << "albedo " << albedo;
        EXPECT_LT(mean.error.y, 0.005 * expected) << "too noisy to prove anything";
    }
}

TEST_F(Path, SphereInUnitEnvironmentReflectsItsAlbedo) {
    SetScene({.albedo = vec3(0.7f)}, 1.0f);
    const Ray ray{.origin = vec3(0.2f, 0.1f, 5.0f), .direction = vec3(0.0f, 0.0f, -1.0f)};
    const Mean mean = MeanRadiance(ray, Unbiased(kNoLimit, 100u), 4096);
    EXPECT_NEAR(mean.radiance.y, 0.7, 1e-5);
    EXPECT_EQ(mean.rays, 2.0) << "a convex body sends every path out after one bounce";
}

TEST_F(Path, RouletteChangesTheNoiseAndNotTheMean) {
    SetScene({.albedo = vec3(0.5f), .emission = vec3(1.0f)});
    const Mean early = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 1u), 1u << 16);
    const Mean late = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 16u), 1u << 16);
    EXPECT_NEAR(early.radiance.y, 2.0, 4.0 * early.error.y);
    EXPECT_NEAR(late.radiance.y, 2.0, 4.0 * late.error.y + 1e-3);
    EXPECT_LT(early.rays, late.rays);
}

TEST_F(Path, RouletteLeavesPathsOfLittleThroughputAThird) {
    // Bounces survive with 0.99, 0.25 * 3 / 0.99, and then, at a third of throughput, with the albedo
    SetScene({.albedo = vec3(0.5f), .emission = vec3(1.0f)});
    const Mean mean = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 1u), 1u << 16);
    EXPECT_NEAR(mean.rays, 1.0 + 0.99 + 0.75 * 2.0, 0.03);
    PathState path = StartPath(FromCenter(), StartPixelSample(uvec2(0u), 0u, 0u));
    for (path.throughput = vec3(1.0e-3f); !SurviveRoulette(path, Unbiased(kNoLimit, 1u));)
        path.throughput = vec3(1.0e-3f);
    EXPECT_FLOAT_EQ(path.throughput.x, 1.0f / 3.0f);
}

TEST_F(Path, DirectionsOfEachTwoBouncesAreSpreadTogether) {
    const auto draw = [](uint sample, uint depth) {
        PathState path = StartPath({}, StartPixelSample(uvec2(8u, 3u), sample, 1u));
        path.depth = depth;
        return BounceDirectionSample(path);
    };
    const auto boxes = [&](uint first, uint second) {
        std::set<int> taken;
        for (uint sample = 0; sample < 256; ++sample) {
            const vec3 u = draw(sample, first);
            const vec3 v = draw(sample, second);
            taken.insert(((int(u.x * 4.0f) * 4 + int(u.y * 4.0f)) * 4 + int(v.x * 4.0f)) * 4 +
                         int(v.y * 4.0f));
        }
        return taken.size();
    };
    EXPECT_EQ(boxes(0, 1), 256u);
    EXPECT_EQ(boxes(2, 3), 256u);
    EXPECT_LT(boxes(1, 2), 220u) << "as many as 256 points at random take";
    EXPECT_LT(boxes(0, 3), 220u);
}

TEST_F(Path, DepthLimitCutsTheGeometricSeries) {
    SetScene({.albedo = vec3(0.5f), .emission = vec3(1.0f)});
    for (const uint depth : {0u, 1u, 2u, 5u}) {
        const Mean mean = MeanRadiance(FromCenter(), Unbiased(depth, kNoLimit), 64);
        EXPECT_NEAR(mean.radiance.y, (1.0 - std::pow(0.5, depth + 1.0)) / 0.5, 1e-5) << "depth " << depth;
        EXPECT_EQ(mean.rays, depth + 1.0);
    }
}

TEST_F(Path, BlackSurfaceEndsThePath) {
    SetScene({.emission = vec3(3.0f)}, 1.0f);
    const Mean mean = MeanRadiance(FromCenter(), Unbiased(kNoLimit, 3u), 16);
    EXPECT_EQ(mean.radiance.y, 3.0);
    EXPECT_EQ(mean.rays, 1.0);
}

TEST_F(Path, MissSeesTheEnvironmentWithoutAlpha) {
    SetScene({}, 2.0f);
    const Ray ray{.origin = vec3(0.0f, 0.0f, 5.0f), .direction = vec3(0.0f, 0.0f, 1.0f)};
    PathState path = StartPath(ray, StartPixelSample(uvec2(0u), 0u, 0u));
    EXPECT_FALSE(ExtendPath(path, Unbiased(kNoLimit, 3u)));
    EXPECT_EQ(path.radiance, vec3(2.0f));
    EXPECT_EQ(path.alpha, 0.0f);
}

// Lambert's sphere, and facets, for which the light is chosen from several candidates (RIS).
TEST_F(Path, LightSamplingFindsTheLightThatChanceFinds) {
    struct Case {
        BrdfModel brdf;
        float metallic, roughness;
    };
    for (const Case& test : {Case{BrdfModel::Lambert, 0.0f, 0.0f}, Case{BrdfModel::Gltf, 0.0f, 0.5f},
                             Case{BrdfModel::Gltf, 1.0f, 0.5f}}) {
        SCOPED_TRACE(::testing::Message() << "model " << int(test.brdf) << ", metallic " << test.metallic);
        SetScene({.albedo = vec3(0.7f), .metallic = test.metallic, .roughness = test.roughness});
        testLights.SetEnvironment(SkyWithALamp(), vec3(1.0f));
        testLights.Build();
        UseOptions({}, test.brdf);
        const Ray ray{.origin = vec3(0.2f, 4.0f, 3.0f), .direction = normalize(vec3(0.0f, -4.0f, -3.0f))};
        ExpectSamplingFindsWhatChanceFinds(ray, Unbiased(kNoLimit, 100u), kTraceEnvironmentLight);
    }
}

// Otherwise the environment's table would choose its smallest cells too seldom or too often.
TEST_F(Path, NumbersOfCandidatesAreMovedByExactlyAQuarterEach) {
    constexpr int kSteps = 1 << 24;
    for (const int step : {0, 1, kSteps / 4 - 1, kSteps / 4, kSteps / 2 + 1, 3 * kSteps / 4, kSteps - 1}) {
        const auto u = static_cast<float>(std::ldexp(double(step), -24));
        for (uint candidate = 0; candidate < kLightCandidates; ++candidate) {
            const vec3 v = CandidateSample(vec3(u), candidate);
            const int moved = kSteps / int(kLightCandidates) * int(candidate);
            const int across = (step + moved) % kSteps, back = (step + kSteps - moved) % kSteps;
            EXPECT_EQ(double(v.x), std::ldexp(double(across), -24)) << step << ", " << candidate;
            EXPECT_EQ(double(v.y), std::ldexp(double(across), -24)) << step << ", " << candidate;
            EXPECT_EQ(double(v.z), std::ldexp(double(back), -24)) << step << ", " << candidate;
        }
    }
}

// Whichever code traces the shadow rays, some of which the lamp stops.
TEST_F(Path, RaysTracedAtOnePlaceGiveTheSamePaths) {
    SetScene({.albedo = vec3(0.7f)}, 0.5f);
    AddLargeLamp();
    testLights.SetEnvironment({.width = 1, .height = 1, .rgba = {1.0f, 1.0f, 1.0f, 1.0f}}, vec3(0.5f));
    testLights.Build();
    const Ray ray{.origin = vec3(0.2f, 1.5f, 1.2f), .direction = normalize(vec3(-0.1f, -1.2f, -0.4f))};
    const PathSettings settings = Unbiased(kNoLimit, kNoLimit);
    threadTraceFeatures |= kTraceLightSampling | kTraceEnvironmentLight | kTraceTriangleLights;
    const Mean apart = MeanRadiance(ray, settings, 1024);
    threadLoopOptions = kLoopOneTrace;
    const Mean together = MeanRadiance(ray, settings, 1024);
    EXPECT_EQ(together.radiance.y, apart.radiance.y);
    EXPECT_EQ(together.rays, apart.rays);
    EXPECT_GT(apart.rays, 2.0) << "no light was sampled";
}

// Lambert and Beer: rho / pi I / d^2 exp(-sigma (d + c)), c from the eye to the surface.
TEST_F(Path, MediumDimsTheWayToTheLightAndToTheEye) {
    SetScene({.albedo = vec3(0.7f)});
    shapes[0].medium.extinction = vec3(0.25f);
    AddPointLight();
    threadTraceFeatures = kTraceLightSampling | kTracePunctualLights | kTraceVolumes;
    const PathState path = Traced(FromAbove(), Unbiased(kNoLimit, 100u), EnterMedium(NoMedia(), 0u));
    const double expected = 0.7 * double(kInvPi) * 9.0 / (3.0 * 3.0) * std::exp(-0.25 * (3.0 + 4.0));
    EXPECT_NEAR(path.radiance.y, expected, 1e-4 * expected);
}

// Returns the fraction that a wall of relative index eta does not reflect, by Schlick's curve.
double Passed(double eta, double cosine) {
    const double f0 = std::pow((eta - 1.0) / (eta + 1.0), 2.0);
    return (1.0 - f0) * (1.0 - std::pow(1.0 - cosine, 5.0));
}

TEST_F(Path, PointLightThroughWallsIsDimmedByEach) {
    for (const float ior : {1.0f, 1.33f}) {
        SetScene({.albedo = vec3(0.7f)});
        shapes[0].medium.ior = ior;
        AddWalls({2.0f, 2.5f});
        AddPointLight();
        UseOptions(~(kTraceProbeMedia | kTraceShadowTerminator | kTraceTextureLod | kTraceHiddenEnvironment));
        const Ray ray{.origin = vec3(0.0f, 0.0f, 1.5f), .direction = vec3(0.0f, 0.0f, -1.0f)};
        const PathState path =
            Traced(ray, Unbiased(1u, kNoLimit), ior > 1.0f ? EnterMedium(NoMedia(), 0u) : NoMedia());
        const double passed = std::pow(Passed(1.5 / ior, 1.0), 2.0);
        for (int channel = 0; channel < 3; ++channel) {
            const double expected = 0.7 * double(kInvPi) * passed * std::pow(double(kWallTint[channel]), 2.0);
            EXPECT_NEAR(path.radiance[channel], expected, 1e-4 * expected) << "index " << ior;
        }
    }
}

// Light behind walls is met with the densities of the last surface that scattered. A lamp and a small sun behind sheets
// light the sphere, and the sheets from below and from between them and the lamp, by diffuse transmission.
TEST_F(Path, LightSamplingFindsBehindWallsAndSheetsWhatChanceFinds) {
    struct Case {
        const char* name;
        SurfaceMaterial wall;
        Ray ray;
        uint depth;
        TraceFeatures features;
    };
    const Ray below{.origin = vec3(0.2f, 1.5f, 1.2f), .direction = normalize(vec3(-0.1f, -1.2f, -0.4f))};
    const Ray up{.origin = vec3(0.2f, 1.5f, 1.2f), .direction = normalize(vec3(-0.1f, 0.3f, 0.4f))};
    const Ray down{.origin = vec3(0.2f, 1.5f, 2.2f), .direction = normalize(vec3(-0.1f, 0.3f, -0.4f))};
    const SurfaceMaterial wall = WallMaterial(), sheet = PaperMaterial(0.6f, 1.0f);
    const TraceFeatures glass = kTraceThinWalls | kTraceGlass, diffuse = kTraceDiffuseTransmission;
    for (const Case& test :
         {Case{"wall", wall, below, 1u, glass}, Case{"wall", wall, below, kNoLimit, glass},
          Case{"sheet from below", sheet, up, 1u, diffuse}, Case{"sheet from below", sheet, up, 3u, diffuse},
          Case{"sheet from above", sheet, down, 1u, diffuse},
          Case{"sheet from above", sheet, down, 3u, diffuse}}) {
        SCOPED_TRACE(::testing::Message() << test.name << ", depth " << test.depth);
        SetScene({.albedo = vec3(0.7f)});
        AddWalls({1.5f, 1.7f}, test.wall);
        AddLargeLamp();
        testLights.SetEnvironment(SkyWithALamp(), vec3(1.0f));
        testLights.Build();
        UseOptions(test.features);
        ExpectSamplingFindsWhatChanceFinds(test.ray, Unbiased(test.depth, kNoLimit),
                                           kTraceEnvironmentLight | kTraceTriangleLights);
    }
}

// Straight crossings move the ray's origin, and a lamp that is sampled by area has a density that grows with
// the square of the distance.
TEST_F(Path, SmallLampBehindAWallIsWeighedByTheWholeWay) {
    SetScene({});
    const float side = 0.01f, distance = 10.0f;
    const vec3 from(0.0f, 0.0f, 1.0f), corner(-0.002f, -0.002f, from.z + distance);
    testLights.AddTriangle(corner, corner + vec3(side, 0.0f, 0.0f), corner + vec3(0.0f, side, 0.0f),
                           vec3(4.0f), true);
    testLights.Build();
    const PathSettings settings = Unbiased(kNoLimit, kNoLimit);
    UseOptions(kTraceThinWalls | kTraceLightSampling | kTraceTriangleLights);
    for (const float crossed : {0.0f, 4.0f}) {
        const Ray ray{.origin = from + vec3(0.0f, 0.0f, crossed), .direction = vec3(0.0f, 0.0f, 1.0f)};
        PathState path = StartPath(ray, StartPixelSample(uvec2(0u), 0u, 0u));
        path.scatter.position = from;
        path.scatterPDF = distance * distance / (0.5f * side * side);  // the density of light sampling
        AddHitEmission(path, vec3(4.0f), 0u, 0u, distance - crossed, settings);
        EXPECT_NEAR(path.radiance.y, 2.0f, 1e-3f) << "a wall at " << crossed;
    }
}

TEST_F(Path, CrossingAWallIsNoBounce) {
    SetScene({.albedo = vec3(0.7f), .emission = vec3(2.0f)});
    AddWalls({2.0f, 3.0f});
    UseOptions(kTraceThinWalls | kTraceGlass);
    const Mean mean = MeanRadiance(FromAbove(), Unbiased(0u, kNoLimit), 1u << 14);
    const double expected = 2.0 * std::pow(double(kWallTint.y) * 0.96, 2.0);
    EXPECT_NEAR(mean.radiance.y, expected, 4.0 * mean.error.y);
    EXPECT_LT(mean.error.y, 0.005 * expected) << "too noisy to prove anything";
}

// One radiance above the sheet and another one below: what is seen is (1 - t) of the one in the sheet's color
// and t of the other in that of its transmission.
TEST_F(SheetPath, SheetBetweenTwoEnvironmentsIsTheMixOfBoth) {
    image::ImageF sky{.width = 256, .height = 4, .rgba = {}};
    for (uint32_t texel = 0; texel < 256 * 4; ++texel) {
        const float value = texel % 256 < 128 ? 3.0f : 0.5f;  // the latter where z > 0
        sky.rgba.insert(sky.rgba.end(), {value, value, value, 1.0f});
    }
    const PathSettings settings = Unbiased(kNoLimit, 100u);
    for (const bool isFromAbove : {true, false})
        for (const float transmission : {0.3f, 1.0f}) {
            SetScene({.radius = 1e-6f});
            AddWalls({1.0f}, PaperMaterial(transmission, 0.0f));
            testLights.SetEnvironment(sky, vec3(1.0f));
            testLights.Build();
            const Ray ray{.origin = vec3(0.3f, 0.2f, isFromAbove ? 5.0f : 0.2f),
                          .direction = normalize(vec3(0.3f, 0.1f, isFromAbove ? -1.0f : 1.0f))};
            const double here = isFromAbove ? 0.5 : 3.0, there = isFromAbove ? 3.0 : 0.5;
            const double expected = (1.0 - double(transmission)) * double(kWallTint.y) * here +
                                    double(transmission) * 0.8 * there;
            for (const TraceFeatures sampling :
                 {TraceFeatures{}, TraceFeatures{kTraceLightSampling | kTraceEnvironmentLight}}) {
                UseOptions(kTraceDiffuseTransmission | sampling);
                const Mean mean = MeanRadiance(ray, settings, 1u << 15);
                EXPECT_NEAR(mean.radiance.y, expected, 4.0 * mean.error.y + 2e-4 * expected);
                EXPECT_LT(mean.error.y, 0.01 * expected) << "too noisy to prove anything";
            }
        }
}

// A ball of a medium in an even environment. Without a layer the light inside is even, too: with B the radiance
// that leaves the boundary inwards and T what the medium lets through of it,
//     B = t c + ((1 - t) b + (1 - 1 / n^2) t c) T B    and outwards    (1 - t) b + t c T B / n^2
// A chord at an angle of cosine m is 2 R m long, so that T is the mean over m dm of exp(-2 R sigma m).
TEST_F(SheetPath, DiffuselyTransmittingBallHasTheRadianceOfTheClosedForm) {
    for (const float absorbed : {0.0f, 0.7f})
        for (const float transmission : {0.4f, 1.0f}) {
            SetScene({}, 1.0f);
            Fill(PaperMaterial(transmission, 0.0f), absorbed, 1.5f);
            UseOptions(kTraceDiffuseTransmission | kTraceVolumes);
            const Mean mean = MeanRadiance(FromAbove(), Unbiased(kNoLimit, 100u), 1u << 16);
            const double a = 2.0 * double(absorbed), t = double(transmission);
            const double passed = a > 0.0 ? 2.0 * (1.0 - (1.0 + a) * std::exp(-a)) / (a * a) : 1.0;
            const double b = double(kWallTint.y), c = 0.8;
            const double out = 1.0 / (1.5 * 1.5);
            const double inside = t * c / (1.0 - ((1.0 - t) * b + (1.0 - out) * t * c) * passed);
            const double expected = (1.0 - t) * b + out * t * c * passed * inside;
            EXPECT_NEAR(mean.radiance.y, expected, 4.0 * mean.error.y + 1e-5) << absorbed << ", " << t;
            EXPECT_LT(mean.error.y, 0.01 * expected) << "too noisy to prove anything";
        }
}

// Equal radiance all around stays equal, and is n^2 of that inside, whatever the layer reflects on either side
// and whatever share of the boundary is glass.
TEST_F(SheetPath, WhiteDiffuselyTransmittingBallVanishesInAnEvenEnvironment) {
    for (const auto& [ior, glass] : {std::pair{1.0f, 0.0f}, {1.5f, 0.0f}, {2.4f, 0.0f}, {1.5f, 0.5f}})
        for (const bool isInside : {false, true}) {
            SurfaceMaterial white = PaperMaterial(0.4f, 1.0f);
            white.transmission = glass;
            white.baseColor = white.diffuseTransmissionColor = vec3(1.0f);
            SetScene({}, 1.0f);
            Fill(white, 0.0f, ior);
            UseOptions(kTraceDiffuseTransmission | kTraceVolumes |
                       (glass > 0.0f ? kTraceGlass : TraceFeatures{}));
            const Ray ray{.origin = vec3(0.4f, 0.0f, isInside ? 0.0f : 5.0f),
                          .direction = vec3(0.0f, 0.0f, -1.0f)};
            const Mean mean = MeanRadiance(ray, Unbiased(kNoLimit, 5u), 1u << 15,
                                           isInside ? EnterMedium(NoMedia(), 0u) : NoMedia());
            const double expected = isInside ? double{ior} * double{ior} : 1.0;
            EXPECT_NEAR(mean.radiance.y, expected, 0.015 * expected)
                << "index " << ior << ", glass " << glass << (isInside ? ", from within" : "");
        }
}

// The cone of a path that is extended by one ray, which meets the ball or a wall.
PathState ExtendedWith(PathState path, TraceFeatures features) {
    threadTraceFeatures |= features | kTraceTextureLod;
    EXPECT_TRUE(ExtendPath(path, Unbiased(kNoLimit, kNoLimit)));
    return path;
}
PathState FromAboveWith(RayCone cone) {
    Ray ray = FromAbove();
    ray.cone = cone;
    return StartPath(ray, StartPixelSample(uvec2(7u, 11u), 3u, 42u));
}

// 4 meters to the ball, whose radius is 1, and which is diffuse.
TEST_F(Path, ConeWidensByDistanceCurvatureAndLobe) {
    SetScene({.albedo = vec3(0.7f)});
    const PathState path = ExtendedWith(FromAboveWith(MakeCone(0.01f, 0.02f)), {});
    const float width = 0.01f + 4.0f * 0.02f;
    EXPECT_NEAR(path.ray.cone.width, width, 1e-5f);
    ASSERT_GT(path.scatterPDF, 0.0f);
    const float lobe = std::sqrt(std::min(1.0f / path.scatterPDF, 6.2831853f) / 4.0f);
    EXPECT_NEAR(path.ray.cone.spread, 0.02f + 2.0f * width + lobe, 1e-4f);
}

TEST_F(Path, ConeGoesStraightThroughWalls) {
    SetScene({.albedo = vec3(0.7f)});
    AddWalls({3.0f});
    UseOptions({});
    PathState path = FromAboveWith(MakeCone(0.01f, 0.02f));
    // The wall passes nearly all of it: the first sample that does so
    for (uint sample = 0u;; ++sample) {
        ASSERT_LT(sample, 100u);
        path.rng = StartPixelSample(uvec2(7u, 11u), sample, 42u);
        const PathState behind = ExtendedWith(path, kTraceThinWalls | kTraceGlass);
        if (behind.depth > 0u) continue;
        EXPECT_NEAR(behind.ray.cone.width, 0.01f + 2.0f * 0.02f, 1e-5f);
        EXPECT_EQ(behind.ray.cone.spread, 0.02f);
        break;
    }
}

}  // namespace raygraph::shading::path_test
