// The path integrator where surfaces transmit diffusely: light from their other side, and from within bodies.
#include "tests/shading/path_scene.h"

namespace raygraph::shading::sheet_path_test {

namespace {
class SheetPath : public PathFixture {};
}  // namespace

// One radiance above the sheet and another one below: what is seen is (1 - t) of the one in the sheet's color
// and t of the other in that of its transmission.
TEST_F(SheetPath, SheetBetweenTwoEnvironmentsIsTheMixOfBoth) {
    SetScene({.radius = 1e-6f, .walls = {1.0f}, .arePaper = true});
    image::ImageF sky{.width = 256, .height = 4, .rgba = {}};
    for (uint32_t texel = 0; texel < 256 * 4; ++texel) {
        const float value = texel % 256 < 128 ? 3.0f : 0.5f;  // the latter where z > 0
        sky.rgba.insert(sky.rgba.end(), {value, value, value, 1.0f});
    }
    testLights.SetEnvironment(sky, vec3(1.0f));
    testLights.Build();
    const PathSettings settings = Unbiased(kNoLimit, 100u);
    for (const bool isFromAbove : {true, false})
        for (const float transmission : {0.3f, 1.0f}) {
            paper = PaperMaterial(transmission, 0.0f);
            const Ray ray{.origin = vec3(0.3f, 0.2f, isFromAbove ? 5.0f : 0.2f),
                          .direction = normalize(vec3(0.3f, 0.1f, isFromAbove ? -1.0f : 1.0f))};
            const double here = isFromAbove ? 0.5 : 3.0, there = isFromAbove ? 3.0 : 0.5;
            const double expected = (1.0 - double(transmission)) * double(kWallTint.y) * here +
                                    double(transmission) * 0.8 * there;
            UseOptions(kTraceDiffuseTransmission);
            const Mean byChance = MeanRadiance(ray, settings, 1u << 16);
            EXPECT_NEAR(byChance.radiance, expected, 4.0 * byChance.standardError + 2e-4 * expected);
            threadTraceFeatures |= kTraceLightSampling | kTraceEnvironmentLight;
            const Mean sampled = MeanRadiance(ray, settings, 1u << 16);
            EXPECT_NEAR(sampled.radiance, expected, 4.0 * sampled.standardError + 2e-4 * expected);
            EXPECT_LT(sampled.standardError, 0.01 * expected) << "too noisy to prove anything";
        }
}

// From within, a lamp and a small sun lie behind sheets, and light the sphere by diffuse transmission.
TEST_F(SheetPath, LightSamplingFindsBehindSheetsWhatChanceFinds) {
    SetScene({.albedo = vec3(0.7f), .walls = {1.5f, 1.7f}, .hasLamp = true, .arePaper = true});
    paper = PaperMaterial(0.6f, 1.0f);
    testLights.AddTriangle(kLampCorners[0], kLampCorners[1], kLampCorners[2], kLampRadiance, true);
    image::ImageF sky{.width = 16, .height = 8, .rgba = {}};
    for (uint32_t texel = 0; texel < 16 * 8; ++texel) {
        const float value = texel % 16 == 3 && texel / 16 == 2 ? 40.0f : 0.2f;
        sky.rgba.insert(sky.rgba.end(), {value, value, value, 1.0f});
    }
    testLights.SetEnvironment(sky, vec3(1.0f));
    testLights.Build();
    // At the lower sheet, and at the upper one from above, between it and the lamp
    for (const Ray& ray :
         {Ray{.origin = vec3(0.2f, 1.5f, 1.2f), .direction = normalize(vec3(-0.1f, 0.3f, 0.4f))},
          Ray{.origin = vec3(0.2f, 1.5f, 2.2f), .direction = normalize(vec3(-0.1f, 0.3f, -0.4f))}})
        for (const uint depth : {1u, 3u}) {
            const PathSettings settings = Unbiased(depth, kNoLimit);
            UseOptions(kTraceDiffuseTransmission);
            const Mean byChance = MeanRadiance(ray, settings, 1u << 18);
            ASSERT_LT(byChance.standardError, 0.01 * byChance.radiance);
            threadTraceFeatures |= kTraceLightSampling | kTraceEnvironmentLight | kTraceTriangleLights;
            for (const MisHeuristic mis : {MisHeuristic::Off, MisHeuristic::Balance, MisHeuristic::Power}) {
                threadMisHeuristic = mis;
                const Mean sampled = MeanRadiance(ray, settings, 1u << 16);
                const double error = std::hypot(sampled.standardError, byChance.standardError);
                EXPECT_NEAR(sampled.radiance, byChance.radiance, 4.0 * error)
                    << "heuristic " << int(mis) << ", depth " << depth << ", from " << ray.origin.z;
                EXPECT_LT(sampled.standardError, 0.02 * sampled.radiance) << "too noisy to prove anything";
            }
        }
}

// A ball of a medium in an even environment. Without a layer the light inside is even, too: with B the radiance
// that leaves the boundary inwards and T what the medium lets through of it,
//     B = t c + ((1 - t) b + (1 - 1 / n^2) t c) T B    and outwards    (1 - t) b + t c T B / n^2
// A chord at an angle of cosine m is 2 R m long, so that T is the mean over m dm of exp(-2 R sigma m).
TEST_F(SheetPath, DiffuselyTransmittingBallHasTheRadianceOfTheClosedForm) {
    const PathSettings settings = Unbiased(kNoLimit, 100u);
    for (const float absorbed : {0.0f, 0.7f})
        for (const float transmission : {0.4f, 1.0f}) {
            SetScene({.isMedium = true}, 1.0f);
            paper = PaperMaterial(transmission, 0.0f);
            UseOptions(kTraceDiffuseTransmission | kTraceVolumes);
            ballExtinction = absorbed;
            mediumIor = 1.5f;
            const Mean mean = MeanRadiance(FromAbove(), settings, 1u << 16);
            ballExtinction = 0.0f;
            mediumIor = 1.0f;
            const double a = 2.0 * double(absorbed), t = double(transmission);
            const double passed = a > 0.0 ? 2.0 * (1.0 - (1.0 + a) * std::exp(-a)) / (a * a) : 1.0;
            const double b = double(kWallTint.y), c = 0.8;
            const double out = 1.0 / (1.5 * 1.5);
            const double inside = t * c / (1.0 - ((1.0 - t) * b + (1.0 - out) * t * c) * passed);
            const double expected = (1.0 - t) * b + out * t * c * passed * inside;
            EXPECT_NEAR(mean.radiance, expected, 4.0 * mean.standardError + 1e-5) << absorbed << ", " << t;
            EXPECT_LT(mean.standardError, 0.01 * expected) << "too noisy to prove anything";
        }
}

// Equal radiance all around stays equal, and is n^2 of that inside, whatever the layer reflects on either side
// and whatever share of the boundary is glass.
TEST_F(SheetPath, WhiteDiffuselyTransmittingBallVanishesInAnEvenEnvironment) {
    PathSettings settings = Unbiased(kNoLimit, 5u);
    for (const auto& [ior, glass] : {std::pair{1.0f, 0.0f}, {1.5f, 0.0f}, {2.4f, 0.0f}, {1.5f, 0.5f}})
        for (const bool isInside : {false, true}) {
            SetScene({.isMedium = true}, 1.0f);
            paper = PaperMaterial(0.4f, 1.0f);
            paper.transmission = glass;
            paper.baseColor = paper.diffuseTransmissionColor = vec3(1.0f);
            UseOptions(kTraceDiffuseTransmission | kTraceVolumes |
                       (glass > 0.0f ? kTraceGlass : TraceFeatures{}));
            mediumIor = ior;
            Ray ray = FromAbove();
            ray.origin.x = 0.4f;
            double sum = 0.0;
            constexpr uint kCount = 1u << 15;
            for (uint i = 0; i < kCount; ++i) {
                PathState path = StartPath(ray, StartPixelSample(uvec2(7u, 11u), i, 42u));
                if (isInside) {
                    path.ray.origin.z = 0.0f;
                    path.media = EnterMedium(NoMedia(), 0u);
                }
                while (ExtendPath(path, settings)) {
                }
                sum += double(path.radiance.y) / kCount;
            }
            mediumIor = 1.0f;
            const double expected = isInside ? double{ior} * double{ior} : 1.0;
            EXPECT_NEAR(sum, expected, 0.015 * expected)
                << "index " << ior << ", glass " << glass << (isInside ? ", from within" : "");
        }
}

}  // namespace raygraph::shading::sheet_path_test
