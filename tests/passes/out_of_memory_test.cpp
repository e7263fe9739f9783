// Exhausted host memory: an Error, and everything as before.
#include "base/out_of_memory.h"

#include <new>
#include <numeric>

#include "base/error.h"
#include "renderer/gpu_scene/deform/deform_resources.h"
#include "renderer/gpu_scene/instances/draw_table.h"
#include "rhi/device.h"
#include "tests/support/error_of.h"
#include "tests/support/failing_memory.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::out_of_memory_test {
namespace {

// The Error that `action` throws while allocations of more than `bytes` fail.
template <typename Action>
std::string MessageOf(size_t bytes, Action&& action) {
    return ErrorTextOf(
        [&] {
            const FailingMemory failing(bytes);
            action();
        },
        ErrorKind::OutOfMemory);
}

TEST(OutOfMemory, LeavesAsAnErrorThatNamesWhatWasAskedFor) {
    EXPECT_EQ(MessageOf(1000, [] { WithMemoryErrors("scene.gltf", [] { return std::vector<int>(1000); }); }),
              "scene.gltf: host memory is exhausted");
    EXPECT_EQ(MessageOf(1000,
                        [] {
                            WithMemoryErrors("scene.gltf", [] {
                                return std::vector<int>(std::vector<int>().max_size() + 1);
                            });
                        }),
              "scene.gltf: asks for more memory than a process can have");
}

// Without layers, which allocate on the same thread and do not expect to fail.
class OutOfMemoryTest : public ::testing::Test {
  protected:
    std::vector<int> kept;  // so that no compiler takes the allocation away
    std::unique_ptr<rhi::Device> device = rhi::Device::Create({.savePipelineCache = false});
    SceneRender render{*device};
    const passes::TraceSettings settings = LookAt({0, 0, 3}, {0, 0, 0}, 0.8f, 8);
};

TEST_F(OutOfMemoryTest, SetScene_LeavesTheSceneThatWasThere) {
    render.scene.SetScene(SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))}));
    const FloatImage before = render.TraceOnce(settings);
    scene::SceneData large = SceneOf({SphereMesh(0.5f, 64)}, {Lambert(glm::vec3(0.5f), glm::vec3(3.0f))});
    EXPECT_EQ(MessageOf(16384, [&] { render.scene.SetScene(std::move(large)); }),
              "SetScene: host memory is exhausted");
    EXPECT_EQ(render.TraceOnce(settings).values, before.values);
    render.scene.SetScene(SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f), glm::vec3(2.0f))}));
    EXPECT_EQ(render.TraceOnce(settings).At(4, 4).x, 2.0f * before.At(4, 4).x);
}

// The names of lights are what is large here. The scene is so far off that its origin is elsewhere.
TEST_F(OutOfMemoryTest, SetScene_LeavesTheSceneThatWasThere_WhicheverAllocationFails) {
    render.scene.SetScene(SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))}));
    const FloatImage before = render.TraceOnce(settings);
    size_t failureCount = 0;
    bool isSet = false;
    while (!isSet && failureCount < 20) {
        scene::SceneData far = SceneOf({BoxMesh(0.5f)}, {Lambert(glm::vec3(0.5f), glm::vec3(3.0f))},
                                       {Translation({5000, 0, 0})});
        far.lights.push_back({.name = std::string(200000, 'x')});
        try {
            const FailingMemory failing(100000, failureCount);
            render.scene.SetScene(std::move(far));
            isSet = true;
        } catch (const Error& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory);
            ++failureCount;
        }
        const FloatImage after = render.TraceOnce(settings);
        ASSERT_EQ(after.values == before.values, !isSet) << failureCount;
    }
    EXPECT_TRUE(isSet);
    EXPECT_GE(failureCount, 2u);
}

// A draw that is not a group's own would be culled and drawn as another, or freed while it is taken.
TEST_F(OutOfMemoryTest, NumbersOfDraws_StayAsTheyWere_WhicheverAllocationFails) {
    constexpr uint32_t kFew = 100, kMany = 1000;
    SceneGeometry geometry(*device);
    InstanceSet instances(*device, geometry, {});
    const auto add = [&](uint32_t group) {
        geometry.groups.emplace_back().triangleCount = 1;
        geometry.meshes.push_back({.firstGroup = group, .groupCount = 1});
        instances.AddMesh(group);
    };
    for (uint32_t group = 0; group < kFew; ++group) add(group);
    DrawTable draws(*device, geometry, instances);
    for (uint32_t group = kFew; group < kMany; ++group) {
        add(group);
        draws.Add(geometry.groups.back());
    }
    const auto numbers = [&] {
        std::vector<uint32_t> all;
        for (const GroupResources& group : geometry.groups) all.push_back(group.record.draw);
        return all;
    };
    const std::vector<uint32_t> before = numbers();
    EXPECT_EQ(before[kFew - 1], kFew - 1);
    EXPECT_EQ(before[kFew], gpu::kNotDrawn) << "there is room";
    size_t failureCount = 0;
    bool isNumbered = false;
    while (!isNumbered && failureCount < 50) {
        try {
            const FailingMemory failing(4000, failureCount);
            draws.Refresh(geometry, instances);
            isNumbered = true;
        } catch (const std::bad_alloc&) {
            ++failureCount;
            ASSERT_EQ(numbers(), before) << failureCount;
        }
    }
    EXPECT_GE(failureCount, 2u);
    std::vector<uint32_t> expected(kMany);
    std::iota(expected.begin(), expected.end(), 0u);
    EXPECT_EQ(numbers(), expected);
}

TEST_F(OutOfMemoryTest, Frame_IsDropped) {
    Renderer& renderer = render.renderer;
    const auto declare = [&](bool inSetup, bool inExecute) {
        renderer.BeginFrame();
        renderer.AddPass(
            "Allocates", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.KeepAlive();
                if (inSetup) std::vector<int>(1000).swap(kept);
            },
            [this, inExecute](CommandList&) {
                if (inExecute) std::vector<int>(1000).swap(kept);
            });
        renderer.Execute();
    };
    EXPECT_EQ(MessageOf(3000, [&] { declare(true, false); }),
              R"(AddPass "Allocates": host memory is exhausted)");
    EXPECT_EQ(MessageOf(3000, [&] { declare(false, true); }), "Execute: host memory is exhausted");
    EXPECT_NO_THROW(declare(true, true));
}

}  // namespace
}  // namespace raygraph::testing::out_of_memory_test
