#include "tests/explain/exact_records.h"

#include <gtest/gtest.h>

#include <vector>

#include "editor/session/frames/device_scene.h"
#include "editor/session/settings/light_settings.h"
#include "renderer/graph/readback_values.h"
#include "shaders/shared/path_record.h"

namespace raygraph::testing {

RecordedPaths ExpectExactRecords(rhi::Device& device, const std::filesystem::path& scene, uint32_t sample) {
    struct Recorded {
        glm::uvec2 pixel;
        Readback record;
    };
    session::SceneInput input = session::LoadInput(scene);
    session::PictureSettings settings;
    settings.size = {16, 12};
    settings.light = session::ChooseLight(input, settings);
    session::DeviceScene placed(device, input, settings, {.traversal = Traversal::Driver});
    Renderer& renderer = placed.GraphRenderer();
    renderer.BeginFrame();
    const SceneIds ids = placed.Declare(sample);
    passes::TraceSettings traced = placed.SettingsFor(sample);
    const Readback radiance = renderer.ReadBack(passes::Trace(renderer, ids, traced).radiance);
    std::vector<Recorded> records;
    for (uint32_t y = 1; y < settings.size.height; y += 5)
        for (uint32_t x = 1; x < settings.size.width; x += 6) {
            traced.region = {x, y, 1, 1};
            const passes::TraceIds recorded = passes::Trace(renderer, ids, traced, {.record = true});
            records.push_back({{x, y}, renderer.ReadBack(recorded.record)});
        }
    renderer.Execute();
    const std::vector<glm::vec4> picture = WaitForValues<glm::vec4>(radiance);
    RecordedPaths found;
    for (const Recorded& recorded : records) {
        const std::vector<gpu::PathVertexRecord> path = passes::PathOf(recorded.record);
        if (path.empty()) {
            ADD_FAILURE() << "no vertex of pixel " << recorded.pixel.x << ',' << recorded.pixel.y;
            continue;
        }
        const glm::vec3 value(picture[recorded.pixel.y * settings.size.width + recorded.pixel.x]);
        EXPECT_EQ(passes::ValueOf(path), value) << recorded.pixel.x << ',' << recorded.pixel.y;
        EXPECT_EQ(path.back().radiance, value) << recorded.pixel.x << ',' << recorded.pixel.y;
        EXPECT_NE(path.back().end, uint32_t(PathEnd::None));
        ++found.paths;
        found.vertices += path.size();
        if (value != glm::vec3(0.0f)) ++found.lit;
    }
    return found;
}

}  // namespace raygraph::testing
