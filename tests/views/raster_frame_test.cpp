// Tests that a raster frame costs the host the same whatever it draws, since the device culls and draws by
// itself.
#include <algorithm>

#include "passes/raster.h"
#include "passes/tonemap.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::raster_frame_test {

using passes::FilmPosition;
using passes::TraceSettings;

namespace {

class RasterFrame : public VulkanTest {
  protected:
    struct Cost {
        double hostMs;  // declaring, compiling and recording; the median of some frames
        size_t passCount;
    };
    Cost Measure(const TraceSettings& settings, const passes::RasterSettings& raster) {
        std::vector<double> times;
        size_t passCount = 0;
        for (int frame = 0; frame < 12; ++frame) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            const passes::RasterVisibility seen =
                passes::DrawVisibility(render.renderer, ids, settings, FilmPosition::Center);
            render.renderer.Present(passes::Tonemap(
                render.renderer,
                passes::RasterShade(render.renderer, ids, settings, seen, environment, raster)));
            Device().WaitFor(render.renderer.Execute());
            for (const FrameTiming& timing : render.renderer.TakeTimings()) {
                passCount = timing.passes.size();
                if (frame > 4) times.push_back(timing.declareMs + timing.compileMs + timing.recordMs);
            }
        }
        std::ranges::sort(times);
        return {times[times.size() / 2], passCount};
    }

    // Makes boxes in a square, under a sun and a sky.
    void SetBoxes(int perSide) {
        std::vector<glm::mat4x3> places;
        for (int y = 0; y < perSide; ++y)
            for (int x = 0; x < perSide; ++x)
                places.push_back(Translation({float(x - perSide / 2), 0, float(y - perSide / 2)}));
        scene::SceneData scene;
        scene.meshes = {BoxMesh(0.3f)};
        scene.materials = {Lambert(glm::vec3(0.6f))};
        for (const glm::mat4x3& place : places) {
            scene.instances.emplace_back();
            scene.instances.back().mesh = 0;
            scene.instances.back().objectToWorld = place;
        }
        scene::Light sun;
        sun.type = scene::LightType::Directional;
        sun.intensity = 2.0f;
        sun.lightToWorld = glm::mat4x3(glm::vec3(1, 0, 0), glm::vec3(0, 0.8f, -0.6f),
                                       glm::vec3(0, 0.6f, 0.8f), glm::vec3(0.0f));
        scene.lights = {sun};
        render.scene.SetScene(std::move(scene));
        render.scene.SetEnvironment({.radiance = glm::vec3(0.3f)});
    }

    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

}  // namespace

TEST_F(RasterFrame, CostsTheHostTheSameForAnyNumberOfInstances) {
    const TraceSettings settings = LookAt({0, 6, 12}, {0, 0, 0}, 0.8f, 32);
    const passes::RasterSettings raster{.shadows = passes::RasterShadows::Maps, .shadowAtlasSize = 256};
    SetBoxes(2);
    const Cost few = Measure(settings, raster);
    SetBoxes(128);
    const Cost many = Measure(settings, raster);
    EXPECT_EQ(many.passCount, few.passCount);
    // 4,096 times the instances: a loop over them would take milliseconds, noise does not
    EXPECT_LT(many.hostMs, 10.0 * few.hostMs + 1.0) << few.hostMs;
    RecordProperty("host ms of 4 instances", std::to_string(few.hostMs));
    RecordProperty("host ms of 16384 instances", std::to_string(many.hostMs));
    RecordProperty("passes", std::to_string(many.passCount));
}

}  // namespace raygraph::testing::raster_frame_test
