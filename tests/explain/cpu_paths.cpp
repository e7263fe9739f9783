#include "tests/explain/cpu_paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <vector>

#include "editor/session/cpu/scene_copy.h"
#include "editor/session/cpu/trace.h"
#include "editor/session/frames/device_scene.h"
#include "editor/session/settings/light_settings.h"
#include "shaders/shared/path_record.h"

namespace raygraph::testing {

namespace {

// Values may differ by this: devices round functions as the logarithm to about 2^-16, weights of texels to 2^-8.
constexpr double kRounding = 0.01;

using Path = std::vector<gpu::PathVertexRecord>;

// Returns the paths of a row of the picture on the device: a record has room for the longest path, so that
// those of a whole picture would take gigabytes.
std::vector<Path> DevicePaths(session::DeviceScene& scene, uint32_t sample, uint32_t y, uint32_t width) {
    Renderer& renderer = scene.GraphRenderer();
    std::vector<Readback> records;
    renderer.BeginFrame();
    const SceneIds ids = scene.Declare(sample);
    passes::TraceSettings traced = scene.SettingsFor(sample);
    for (uint32_t x = 0; x < width; ++x) {
        traced.region = {x, y, 1, 1};
        records.push_back(renderer.ReadBack(passes::Trace(renderer, ids, traced, {.record = true}).record));
    }
    renderer.Execute();
    std::vector<Path> paths;
    for (const Readback& record : records) paths.push_back(passes::PathOf(record));
    return paths;
}

bool AreAlike(const Path& a, const Path& b) {
    return std::ranges::equal(a, b, [](const gpu::PathVertexRecord& u, const gpu::PathVertexRecord& v) {
        return u.event == v.event && u.instance == v.instance && u.primitive == v.primitive &&
               u.isFront == v.isFront && u.lobe == v.lobe && u.end == v.end && u.medium == v.medium &&
               u.chosen == v.chosen && u.candidates[0].light == v.candidates[0].light &&
               u.candidates[0].triangle == v.candidates[0].triangle;
    });
}

double DifferenceOf(const glm::vec3& a, const glm::vec3& b) {
    double difference = 0.0;
    for (int c = 0; c < 3; ++c) {
        const double larger = std::max(std::abs(double{a[c]}), std::abs(double{b[c]}));
        if (larger > 1e-6) difference = std::max(difference, std::abs(double{a[c]} - b[c]) / larger);
    }
    return difference;
}

}  // namespace

ComparedPaths ComparePaths(rhi::Device& device, session::SceneInput input, session::PictureSettings settings,
                           uint32_t sample) {
    settings.light = session::ChooseLight(input, settings);
    session::DeviceScene placed(device, input, settings, {.traversal = Traversal::Driver});
    const session::SceneCopy copy =
        session::CopyScene(placed.GraphRenderer(), placed.Scene(), [&] { return placed.Declare(sample); });
    ComparedPaths compared;
    std::vector<double> differences;
    for (uint32_t y = 0; y < settings.size.height; ++y) {
        const std::vector<Path> ofDevice = DevicePaths(placed, sample, y, settings.size.width);
        for (uint32_t x = 0; x < settings.size.width; ++x) {
            const session::CpuPath onCpu = TraceOnCpu(copy, placed.SettingsFor(sample), {x, y});
            EXPECT_EQ(passes::ValueOf(onCpu.vertices), onCpu.value) << x << ',' << y;
            const glm::vec3 value = passes::ValueOf(ofDevice[x]);
            ++compared.paths;
            compared.vertices += onCpu.vertices.size();
            compared.deviceMean += value;
            compared.cpuMean += onCpu.value;
            compared.lit += onCpu.value != glm::vec3(0.0f);
            if (!AreAlike(ofDevice[x], onCpu.vertices)) {
                ++compared.different;
                continue;
            }
            const double difference = DifferenceOf(value, onCpu.value);
            if (onCpu.value != glm::vec3(0.0f)) differences.push_back(difference);
            compared.apart += difference > kRounding;
        }
    }
    compared.deviceMean /= compared.paths;
    compared.cpuMean /= compared.paths;
    std::ranges::sort(differences);
    if (!differences.empty()) compared.medianDifference = differences[differences.size() / 2];
    return compared;
}

void ExpectSamePaths(const ComparedPaths& compared, double mostApart) {
    const auto most = static_cast<size_t>(mostApart * static_cast<double>(compared.paths));
    EXPECT_GT(5 * compared.lit, compared.paths) << "the picture is too dark to prove anything";
    EXPECT_LE(compared.different, most);
    EXPECT_LE(compared.apart, most);
    EXPECT_LT(compared.medianDifference, 1e-4);
    // One path that differs may bring all of its light, and no more than a few times the mean
    const double tolerance = compared.different + compared.apart > 0 ? 0.05 : 1e-4;
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(compared.cpuMean[c], compared.deviceMean[c], tolerance * compared.deviceMean[c]);
}

std::ostream& operator<<(std::ostream& out, const ComparedPaths& compared) {
    return out << compared.paths << " paths of " << compared.vertices << " vertices, " << compared.lit
               << " lit; " << compared.different << " differ, " << compared.apart
               << " have another value, median " << compared.medianDifference;
}

}  // namespace raygraph::testing
