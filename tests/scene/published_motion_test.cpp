// Published models with animations, skins and morph targets, at a time: where their vertices are in the world.
// The numbers were computed from the files by a program in another language, which shares nothing with ours.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/check.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/reference_assets.h"

namespace raygraph::test::published_motion_test {
namespace {

using glm::vec3;
using scene::kNone;

struct Row {
    const char* file;
    uint32_t animation;  // kNone: the rest pose
    double seconds;
    vec3 min, max, mean;  // over the corners of all triangles
};
const Row kRows[] = {
    {"SimpleSkin.gltf",
     0,
     0,
     {-0.50000f, 0.00000f, 0.00000f},
     {0.50000f, 2.00000f, 0.00000f},
     {0.000000f, 1.000000f, 0.000000f}},
    {"SimpleSkin.gltf",
     0,
     1.2,
     {-1.00000f, 0.00000f, 0.00000f},
     {0.50000f, 1.50000f, 0.00000f},
     {-0.208333f, 0.833333f, 0.000000f}},
    {"SimpleSkin.gltf",
     0,
     5,
     {-0.55178f, 0.00000f, 0.00000f},
     {1.06083f, 2.06049f, 0.00000f},
     {0.126539f, 0.930279f, 0.000000f}},
    {"RiggedSimple.glb",
     0,
     1,
     {-1.00000f, -4.57508f, -2.86531f},
     {1.00000f, 4.10119f, 1.00000f},
     {0.002216f, -0.236317f, -0.820256f}},
    {"RiggedFigure.glb",
     0,
     0.7,
     {-0.47572f, -0.00000f, -0.12384f},
     {0.46732f, 1.46545f, 0.21469f},
     {-0.000639f, 0.695547f, 0.028346f}},
    {"Fox.glb",
     2,
     0.4,
     {-13.08644f, 6.43600f, -92.64679f},
     {13.75206f, 69.34771f, 72.43568f},
     {-0.041306f, 38.117716f, 1.397207f}},
    {"Fox.glb",
     0,
     1.3,
     {-11.59712f, -0.13068f, -82.82688f},
     {25.48049f, 75.98534f, 57.92423f},
     {2.999373f, 32.314676f, -2.467304f}},
    {"AnimatedMorphCube.glb",
     0,
     1.1,
     {-1.00000f, -1.00000f, -1.00000f},
     {1.00000f, 1.00000f, -0.45414f},
     {-0.000000f, -0.000000f, -0.727072f}},
    {"MorphPrimitivesTest.glb",
     kNone,
     0,
     {-0.50000f, 0.00000f, -0.50000f},
     {0.50000f, 0.10000f, 0.50000f},
     {0.000000f, 0.056250f, 0.000000f}},
    {"BoxAnimated.glb",
     0,
     1,
     {-0.50000f, -0.50000f, -0.50000f},
     {0.50000f, 2.51600f, 0.50000f},
     {0.000006f, 0.484252f, -0.001787f}},
    {"BoxAnimated.glb",
     0,
     2.8,
     {-0.50000f, -0.50000f, -0.50000f},
     {0.50000f, 2.39434f, 0.50000f},
     {0.000006f, 0.454540f, -0.000044f}},
    {"CesiumMilkTruck.glb",
     0,
     0.3,
     {-2.43091f, 0.00103f, -1.39600f},
     {2.43800f, 2.58437f, 1.39600f},
     {0.325158f, 0.886324f, -0.001424f}},
    {"InterpolationTest.glb",
     0,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     1,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     2,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00367f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     3,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     4,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.35251f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     5,
     0.9,
     {-4.36236f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     6,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.214180f, 0.019231f}},
    {"InterpolationTest.glb",
     7,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.236594f, 0.019231f}},
    {"InterpolationTest.glb",
     8,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.73419f, 1.00894f},
     {0.008187f, 3.251959f, 0.019231f}},
};

TEST(PublishedMotion, VerticesAreWhereTheFilesSay) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    for (const Row& row : kRows) {
        SCOPED_TRACE(std::string(row.file) + " " + std::to_string(row.animation));
        scene::SceneData scene = scene::LoadGltf(*ReferenceAssets() / "scenes" / "known" / row.file);
        // The weights of some vertices sum to 0.2
        const bool isUneven = row.file == std::string_view("RiggedFigure.glb");
        EXPECT_EQ(scene.warnings.size(), isUneven ? 1u : 0u) << ::testing::PrintToString(scene.warnings);
        scene::PoseEvaluator evaluator(scene);
        scene::PoseApplier applier(scene);
        if (row.animation != kNone) {
            const std::array clips{scene::ClipState{row.animation, row.seconds}};
            applier.Apply(scene, evaluator.Evaluate(scene, clips));
        }
        scene::Bounds exact;
        glm::dvec3 sum(0.0);
        size_t count = 0;
        scene::DeformedStreams streams;
        for (const scene::Instance& instance : scene.instances) {
            const uint32_t skin = scene.nodes[instance.node].skin;
            for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives) {
                scene::DeformPrimitive(primitive, scene::MorphWeights(scene, instance),
                                       applier.JointMatricesOf(skin), streams);
                for (const uint32_t index : primitive.indices) {
                    const vec3 place = instance.objectToWorld * glm::vec4(streams.positions[index], 1.0f);
                    exact.Extend(place);
                    sum += glm::dvec3(place);
                    ++count;
                }
            }
        }
        const float size = glm::length(row.max - row.min);
        const vec3 mean(sum / double(count));
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(exact.min[i], row.min[i], 2e-5f * size) << i;
            EXPECT_NEAR(exact.max[i], row.max[i], 2e-5f * size) << i;
            EXPECT_NEAR(mean[i], row.mean[i], 1e-5f * size) << i;
            // The scene's own bounds are around it, and not much wider
            EXPECT_LE(scene.bounds.min[i], exact.min[i] + 1e-5f * size) << i;
            EXPECT_GE(scene.bounds.max[i], exact.max[i] - 1e-5f * size) << i;
        }
        EXPECT_LT(scene.bounds.Radius(), 1.6f * exact.Radius());
    }
}

// A scene frozen at this time, which anything can draw, gives the same result.
TEST(PublishedMotion, FrozenScenesAreThere) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    for (const Row& row : kRows) {
        SCOPED_TRACE(std::string(row.file) + " " + std::to_string(row.animation));
        scene::SceneData scene = scene::LoadGltf(*ReferenceAssets() / "scenes" / "known" / row.file);
        std::vector<scene::ClipState> clips;
        if (row.animation != kNone) clips.push_back({row.animation, row.seconds});
        scene::FreezePose(scene, clips);
        EXPECT_NO_THROW(scene::Check(scene, "frozen"));
        const float size = glm::length(row.max - row.min);
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(scene.bounds.min[i], row.min[i], 0.05f * size) << i;
            EXPECT_NEAR(scene.bounds.max[i], row.max[i], 0.05f * size) << i;
        }
        scene::Bounds exact;
        for (const scene::Instance& instance : scene.instances)
            for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives)
                for (const uint32_t index : primitive.indices)
                    exact.Extend(instance.objectToWorld * glm::vec4(primitive.positions[index], 1.0f));
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(exact.min[i], row.min[i], 2e-5f * size) << i;
            EXPECT_NEAR(exact.max[i], row.max[i], 2e-5f * size) << i;
        }
    }
}

}  // namespace
}  // namespace raygraph::test::published_motion_test
