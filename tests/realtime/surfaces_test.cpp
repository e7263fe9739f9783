// Tests TraceSurfaces: what a camera ray sees, and where that was.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "passes/real_time.h"
#include "passes/scene_bindings.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/graph/readback_values.h"
#include "tests/passes/deforming_scene.h"
#include "tests/realtime/room.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::real_time_surfaces_test {

namespace {

constexpr uint32_t kNothingHit = 1;  // shaders/real_time/surface.glsl
constexpr uint32_t kFirstShownNumber = 2041;

class RealTimeSurfaces : public VulkanTest {
  protected:
    struct Seen {
        std::vector<uint32_t> numbers;
        std::vector<float> depths, dullness;
        std::vector<float> motion;
        bool IsShown(size_t pixel) const { return numbers[pixel] >= kFirstShownNumber; }  // by others
    };
    // Returns what the camera sees where the body in the room has that material, and looked from `eyeBefore`
    // in the frame before.
    Seen SeenOf(const scene::Material& material, const glm::vec3& eyeBefore = {-0.8f, 0.1f, 0.3f}) {
        scene::SceneData data = Room();
        data.materials[1] = material;
        render.scene.SetScene(std::move(data));
        passes::TraceSettings settings = RoomSettings({24, 16});
        settings.scattering.brdf = BrdfModel::Gltf;
        render.renderer.BeginFrame();
        const SceneIds ids = render.Declare();
        const gpu::CameraRecord before = passes::ParametersFor(ids, RoomSettings({24, 16}, eyeBefore)).camera;
        const passes::SurfaceIds seen =
            passes::TraceSurfaces(render.renderer, ids, settings, {before, ids.instances, {}});
        const Readback surfaces = render.renderer.ReadBack(seen.surfaces),
                       albedo = render.renderer.ReadBack(seen.albedo),
                       motion = render.renderer.ReadBack(seen.motion);
        render.renderer.Execute();
        Seen result;
        const std::vector<uint32_t> words = WaitForValues<uint32_t>(surfaces);
        for (size_t i = 0; i < words.size(); i += 2) {
            result.depths.push_back(std::bit_cast<float>(words[i]));
            result.numbers.push_back(words[i + 1] & 0xFFFu);
        }
        motion.Wait();
        result.motion = DecodeTexels(motion.Bytes(), motion.Extent(), motion.Format()).values;
        albedo.Wait();
        result.dullness = ChannelOf(DecodeTexels(albedo.Bytes(), albedo.Extent(), albedo.Format()).values, 3);
        return result;
    }

    SceneRender render{Device()};
};

}  // namespace

// A sample hits it by chance; pixels and frames must see the same of both surfaces.
TEST_F(RealTimeSurfaces, BlendSurface_IsSeenWhereItIsRatherOpaque) {
    const auto numbersSeen = [&](float alpha) {
        scene::Material material = Lambert(glm::vec3(0.8f));
        material.alphaMode = scene::AlphaMode::Blend;
        material.baseColorFactor.a = alpha;
        return SeenOf(material).numbers;
    };
    const std::vector<uint32_t> opaque = numbersSeen(1.0f), clear = numbersSeen(0.3f);
    EXPECT_EQ(numbersSeen(0.7f), opaque);
    EXPECT_NE(opaque, clear);
    EXPECT_EQ(clear, std::vector<uint32_t>(clear.size(), clear[0]));  // The room alone
}

// Samples of what does not move with its surface count for few, and paint is no metal.
TEST_F(RealTimeSurfaces, Metal_IsDullByItsRoughnessAndAnotherSurfaceThanPaint) {
    const auto seen = [&](float metallic, float roughness) {
        scene::Material material = Lambert(glm::vec3(0.8f));
        material.metallicFactor = metallic;
        material.roughnessFactor = roughness;
        return SeenOf(material);
    };
    const auto leastDullness = [](const Seen& of) { return *std::ranges::min_element(of.dullness); };
    const Seen paint = seen(0.0f, 0.1f), polished = seen(1.0f, 0.25f), metal = seen(1.0f, 0.65f);
    EXPECT_EQ(leastDullness(paint), 1.0f);
    EXPECT_EQ(leastDullness(polished), 0.0f);
    EXPECT_NEAR(leastDullness(metal), 0.5f, 0.01f);
    EXPECT_EQ(leastDullness(seen(1.0f, 1.0f)), 1.0f);
    EXPECT_EQ(polished.numbers, metal.numbers);
    const Seen mirror = seen(1.0f, 0.1f);
    EXPECT_EQ(leastDullness(mirror), 1.0f);  // that of the walls which it shows
    for (size_t i = 0; i < polished.dullness.size(); ++i) {
        EXPECT_EQ(paint.numbers[i] == polished.numbers[i], polished.dullness[i] == 1.0f);
        EXPECT_EQ(mirror.IsShown(i), polished.dullness[i] != 1.0f);
    }
}

// The room's body is a mirror: the image of a wall behind its face is a point like others, as far away as the
// path to the wall is long.
TEST_F(RealTimeSurfaces, PlaneMirror_ShowsWhatMovesAsPointsBehindIt) {
    scene::Material mirror = Lambert(glm::vec3(0.9f));
    mirror.metallicFactor = 1.0f;
    mirror.roughnessFactor = 0.0f;
    const Seen seen = SeenOf(mirror, glm::vec3{-0.8f, 0.13f, 0.25f});
    const Extent2D extent{24, 16};
    const gpu::CameraRecord now = RoomSettings(extent).camera;
    const gpu::CameraRecord before = RoomSettings(extent, {-0.8f, 0.13f, 0.25f}).camera;
    int count = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x) {
            const size_t i = static_cast<size_t>(24 * y + x);
            if (!seen.IsShown(i)) continue;
            ++count;
            const glm::vec2 film =
                (glm::vec2(x, y) + 0.5f) * glm::vec2(2.0f / 24.0f, -2.0f / 16.0f) + glm::vec2(-1.0f, 1.0f);
            const glm::vec3 point =
                EyeOf(now) +
                glm::dvec3(seen.depths[i] * (now.forward + film.x * now.right + film.y * now.up));
            const glm::vec3 offset = glm::vec3(glm::dvec3(point) - EyeOf(before));
            const float depth = glm::dot(offset, before.forward);
            const glm::vec2 filmBefore{glm::dot(offset, before.right) / glm::dot(before.right, before.right),
                                       glm::dot(offset, before.up) / glm::dot(before.up, before.up)};
            const glm::vec2 moved = (filmBefore / depth - film) * glm::vec2(12.0f, -8.0f);
            EXPECT_NEAR(seen.motion[4 * i], moved.x, 0.03f) << x << " " << y;
            EXPECT_NEAR(seen.motion[4 * i + 1], moved.y, 0.03f) << x << " " << y;
        }
    EXPECT_GT(count, 20);
}

// The camera stands still: what moves on the picture are deformed vertices alone.
TEST_F(RealTimeSurfaces, DeformedVertices_HaveTheMotionOfTheirPose) {
    PosedScene posed(SheetScene({.influences = 0, .targets = 1}));
    render.scene.SetScene(scene::SceneData(posed.scene));
    const passes::TraceSettings settings = LookAt({3, 2, 4}, {0, 2, 0}, 1.0f, 32);
    render.renderer.BeginFrame();
    const SceneIds ids = render.Declare();
    const BufferId kept = render.renderer.PersistBuffer(
        "realTimeTest.vertices", {.size = render.renderer.Desc(ids.deformedStreams).size});
    BufferId copied;
    render.renderer.AddPass(
        "Copy", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(ids.deformedStreams);
            copied = pass.CopiesTo(kept);
        },
        [from = ids.deformedStreams, kept](CommandList& commands, const PassResources& resources) {
            commands.CopyBuffer(resources.Buffer(from), 0, resources.Buffer(kept), 0,
                                resources.Buffer(from).Size());
        });
    const Readback unused = render.renderer.ReadBack(copied);
    render.renderer.Execute();

    render.scene.SetMorphWeights(0, std::array{1.0f});
    render.renderer.BeginFrame();
    const SceneIds now = render.Declare();
    const passes::SurfaceIds seen = passes::TraceSurfaces(
        render.renderer, now, settings,
        {passes::ParametersFor(now, settings).camera, now.instances,
         render.renderer.PersistBuffer("realTimeTest.vertices", render.renderer.Desc(now.deformedStreams))});
    const Readback motion = render.renderer.ReadBack(seen.motion),
                   found = render.renderer.ReadBack(seen.surfaces);
    render.renderer.Execute();
    motion.Wait();
    found.Wait();
    double moved = 0.0, count = 0.0;
    const std::vector<float> pixels = DecodeTexels(motion.Bytes(), motion.Extent(), motion.Format()).values;
    const std::vector<uint32_t> surfaces = ValuesOf<uint32_t>(found);
    for (size_t i = 0; i < pixels.size() / 4; ++i) {
        if ((surfaces[2 * i + 1] & 0xFFFu) == kNothingHit) {
            EXPECT_EQ(pixels[4 * i], 0.0f);
            continue;
        }
        moved += std::hypot(pixels[4 * i], pixels[4 * i + 1]);
        count += 1.0;
    }
    ASSERT_GT(count, 40.0);
    EXPECT_GT(moved / count, 0.3);  // pixels
    EXPECT_LT(moved / count, 3.0);
    render.renderer.Release("realTimeTest.vertices");
}

}  // namespace raygraph::testing::real_time_surfaces_test
