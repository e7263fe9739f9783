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

constexpr Extent2D kExtent{24, 16};
const glm::vec3 kEye{-0.8f, 0.1f, 0.3f}, kBody{0.3f, -0.5f, 0.1f};  // those of the room

// Where the center of a pixel is on the picture's plane, from -1 to 1.
glm::vec2 FilmOf(int x, int y) {
    const glm::vec2 size(kExtent.width, kExtent.height);
    return (2.0f * (glm::vec2(x, y) + 0.5f) / size - 1.0f) * glm::vec2(1.0f, -1.0f);
}

// The point that a pixel shows at that depth.
glm::vec3 PointAt(const gpu::CameraRecord& camera, const glm::vec2& film, float depth) {
    return glm::vec3(EyeOf(camera)) + depth * (camera.forward + film.x * camera.right + film.y * camera.up);
}

// Where a camera sees a point on its picture's plane.
glm::vec2 Projected(const gpu::CameraRecord& camera, const glm::vec3& point) {
    const glm::vec3 offset = point - glm::vec3(EyeOf(camera));
    const glm::vec2 at{glm::dot(offset, camera.right) / glm::dot(camera.right, camera.right),
                       glm::dot(offset, camera.up) / glm::dot(camera.up, camera.up)};
    return at / glm::dot(offset, camera.forward);
}

// Pixels from there to where a camera sees the point.
glm::vec2 MotionTo(const gpu::CameraRecord& camera, const glm::vec3& point, const glm::vec2& film,
                   const glm::vec2& size = {kExtent.width, kExtent.height}) {
    return (Projected(camera, point) - film) * glm::vec2(0.5f, -0.5f) * size;
}

scene::Material Mirror() {
    scene::Material mirror = Lambert(glm::vec3(0.9f));
    mirror.metallicFactor = 1.0f;
    mirror.roughnessFactor = 0.0f;
    return mirror;
}

class RealTimeSurfaces : public VulkanTest {
  protected:
    struct Seen {
        std::vector<uint32_t> numbers;
        std::vector<float> depths, dullness;
        std::vector<float> motion;
        bool IsShown(size_t pixel) const { return numbers[pixel] >= kFirstShownNumber; }  // by others
    };
    // Shows a room where the body has that material.
    void SetRoom(const scene::Material& material) {
        scene::SceneData data = Room();
        data.materials[1] = material;
        render.scene.SetScene(std::move(data));
    }
    static passes::TraceSettings SettingsFrom(const glm::vec3& eye) {
        passes::TraceSettings settings = RoomSettings(kExtent, eye);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }
    // Returns what the camera sees where the body in the room has that material, and looked from `eyeBefore`
    // in the frame before.
    Seen SeenOf(const scene::Material& material, const glm::vec3& eyeBefore = kEye) {
        SetRoom(material);
        render.renderer.BeginFrame();
        const SceneIds ids = render.Declare();
        const gpu::CameraRecord before = passes::ParametersFor(ids, SettingsFrom(eyeBefore)).camera;
        return Read(
            passes::TraceSurfaces(render.renderer, ids, SettingsFrom(kEye), {before, ids.instances, {}}));
    }
    // Returns what the camera sees after the body has moved by `shift`.
    Seen SeenOfMoved(const scene::Material& material, const glm::vec3& shift) {
        SetRoom(material);
        render.renderer.BeginFrame();
        const BufferId instances = Keep("instances", render.Declare().instances);
        const Readback unused = render.renderer.ReadBack(instances);
        render.renderer.Execute();
        render.scene.SetTransform(1, Translation(kBody + shift));
        render.renderer.BeginFrame();
        const SceneIds ids = render.Declare();
        const passes::TraceSettings settings = SettingsFrom(kEye);
        return Read(passes::TraceSurfaces(
            render.renderer, ids, settings,
            {passes::ParametersFor(ids, settings).camera,
             render.renderer.PersistBuffer("instances", render.renderer.Desc(ids.instances)),
             {}}));
    }
    // Copies a buffer of the open frame into one that the next frame finds.
    BufferId Keep(const char* name, BufferId from) {
        BufferId kept = render.renderer.PersistBuffer(name, {.size = render.renderer.Desc(from).size});
        render.renderer.AddPass(
            "Keep", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(from);
                kept = pass.CopiesTo(kept);
            },
            [from, kept](CommandList& commands, const PassResources& resources) {
                commands.CopyBuffer(resources.Buffer(from), 0, resources.Buffer(kept), 0,
                                    resources.Buffer(from).Size());
            });
        return kept;
    }
    // Executes the open frame.
    Seen Read(const passes::SurfaceIds& seen) {
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
    const glm::vec3 eyeBefore{-0.8f, 0.13f, 0.25f};
    const Seen seen = SeenOf(Mirror(), eyeBefore);
    const gpu::CameraRecord now = SettingsFrom(kEye).camera, before = SettingsFrom(eyeBefore).camera;
    int count = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x) {
            const size_t i = static_cast<size_t>(24 * y + x);
            if (!seen.IsShown(i)) continue;
            ++count;
            const glm::vec2 moved =
                MotionTo(before, PointAt(now, FilmOf(x, y), seen.depths[i]), FilmOf(x, y));
            EXPECT_NEAR(seen.motion[4 * i], moved.x, 0.03f) << x << " " << y;
            EXPECT_NEAR(seen.motion[4 * i + 1], moved.y, 0.03f) << x << " " << y;
        }
    EXPECT_GT(count, 20);
}

// The camera stands still: points of the body were where they are now without the shift, the walls' where they are.
TEST_F(RealTimeSurfaces, MovedBody_HasTheMotionOfItsPoints) {
    const glm::vec3 shift{0.04f, 0.05f, -0.08f};
    const Seen seen = SeenOfMoved(Lambert(glm::vec3(0.8f)), shift);
    const gpu::CameraRecord camera = SettingsFrom(kEye).camera;
    int count = 0;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x) {
            const size_t i = static_cast<size_t>(24 * y + x);
            const bool isBody = seen.numbers[i] != seen.numbers[0];  // the first one is of a wall
            const glm::vec3 point = PointAt(camera, FilmOf(x, y), seen.depths[i]);
            const glm::vec2 moved = isBody ? MotionTo(camera, point - shift, FilmOf(x, y)) : glm::vec2(0.0f);
            count += isBody ? 1 : 0;
            EXPECT_NEAR(seen.motion[4 * i], moved.x, 0.1f) << x << " " << y;
            EXPECT_NEAR(seen.motion[4 * i + 1], moved.y, 0.1f) << x << " " << y;
        }
    EXPECT_GT(count, 20);
}

// The walls that a face of the body shows move by twice the face's shift along its normal.
TEST_F(RealTimeSurfaces, MovedMirror_ShowsWhatMovesTwiceAsFar) {
    const glm::vec3 shift{0.004f, 0.006f, -0.005f};
    const Seen seen = SeenOfMoved(Mirror(), shift);
    const gpu::CameraRecord camera = SettingsFrom(kEye).camera;
    // The axis of the face that a pixel shows, by the slabs of the body
    const auto faceAt = [&](int x, int y) {
        const glm::vec3 direction = PointAt(camera, FilmOf(x, y), 1.0f) - kEye, to = kBody + shift - kEye;
        const glm::vec3 near = (to - 0.3f * glm::sign(direction)) / direction;
        return near.x > near.y && near.x > near.z ? 0 : near.y > near.z ? 1 : 2;
    };
    int count = 0;
    for (int y = 1; y < 15; ++y)
        for (int x = 1; x < 23; ++x) {
            const size_t i = static_cast<size_t>(24 * y + x);
            const int face = faceAt(x, y);
            const bool isInside = face == faceAt(x - 1, y) && face == faceAt(x + 1, y) &&
                                  face == faceAt(x, y - 1) && face == faceAt(x, y + 1);
            if (!seen.IsShown(i) || !isInside) continue;
            ++count;
            glm::vec3 before = PointAt(camera, FilmOf(x, y), seen.depths[i]);
            before[face] -= 2.0f * shift[face];
            const glm::vec2 moved = MotionTo(camera, before, FilmOf(x, y));
            EXPECT_NEAR(seen.motion[4 * i], moved.x, 0.02f) << x << " " << y;
            EXPECT_NEAR(seen.motion[4 * i + 1], moved.y, 0.02f) << x << " " << y;
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
    const Readback unused = render.renderer.ReadBack(Keep("realTimeTest.vertices", ids.deformedStreams));
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
    const std::vector<float> pixels = DecodeTexels(motion.Bytes(), motion.Extent(), motion.Format()).values;
    const std::vector<uint32_t> surfaces = ValuesOf<uint32_t>(found);
    const auto numberAt = [&](size_t pixel) { return surfaces[2 * pixel + 1] & 0xFFFu; };
    for (size_t i = 0; i < 32 * 32; ++i)
        if (numberAt(i) == kNothingHit) {
            EXPECT_EQ(pixels[4 * i], 0.0f);
        }
    // Each vertex says where the pixel that shows it was
    const scene::Primitive& sheet = posed.scene.meshes[0].primitives[0];
    const gpu::CameraRecord& camera = settings.camera;
    double moved = 0.0, wrong = 0.0, count = 0.0;
    for (size_t v = 0; v < sheet.positions.size(); ++v) {
        const glm::vec2 film = Projected(camera, sheet.positions[v] + sheet.targets[0].positions[v]);
        const glm::vec2 place = 32.0f * (glm::vec2(0.5f, -0.5f) * film + 0.5f);
        if (!(place.x > 0.0f && place.x < 32.0f && place.y > 0.0f && place.y < 32.0f)) continue;
        const size_t i = 32 * static_cast<size_t>(place.y) + static_cast<size_t>(place.x);
        if (numberAt(i) == kNothingHit) continue;
        const glm::vec2 expected = MotionTo(camera, sheet.positions[v], film, glm::vec2(32.0f));
        moved += glm::length(expected);
        wrong += glm::length(expected - glm::vec2(pixels[4 * i], pixels[4 * i + 1]));
        count += 1.0;
    }
    ASSERT_GT(count, 400.0);
    EXPECT_GT(moved / count, 0.3);   // pixels
    EXPECT_LT(wrong / moved, 0.15);  // vertices are beside the centers of pixels
    render.renderer.Release("realTimeTest.vertices");
}

}  // namespace raygraph::testing::real_time_surfaces_test
