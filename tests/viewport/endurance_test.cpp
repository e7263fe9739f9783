// Memory and the cost of a toggle stay the same however long a viewport is used.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <ctime>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include "tests/viewport/viewport_test.h"

#if defined(__SANITIZE_ADDRESS__)
#define RAYGRAPH_ADDRESSES_ARE_CHECKED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define RAYGRAPH_ADDRESSES_ARE_CHECKED 1
#endif
#endif
#ifdef RAYGRAPH_ADDRESSES_ARE_CHECKED
// Declared here because GCC's packages lack <sanitizer/allocator_interface.h>, whose function this is.
extern "C" size_t __sanitizer_get_current_allocated_bytes();
#endif

namespace raygraph::testing::endurance_test {

namespace {

class ViewportEndurance : public VulkanTest {
  protected:
    // CPU time of all threads of the process: other processes do not count, and a CPU device's work does.
    static double ProcessSeconds() {
        timespec time{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
        return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
    }
    static uint64_t ResidentBytes() {
#ifdef RAYGRAPH_ADDRESSES_ARE_CHECKED
        // The sanitizer keeps what was freed, in its quarantine, for a while: what is in use counts.
        return __sanitizer_get_current_allocated_bytes();
#else
        uint64_t total = 0, resident = 0;
        std::ifstream("/proc/self/statm") >> total >> resident;
        return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
#endif
    }
    // Returns the time of a frame of `view` after two frames of `viewBefore`, which may be the same. The
    // device is idle before it, so that both kinds of frames find the same resources to take back.
    double FrameSeconds(View view, View viewBefore) {
        viewed.viewport.SetView(viewBefore);
        viewed.RenderFrames(2);
        Device().WaitIdle();
        viewed.viewport.SetView(view);
        const double before = ProcessSeconds();
        Device().WaitFor(viewed.viewport.RenderFrame());
        return ProcessSeconds() - before;
    }
    // Returns what frames have made: the number of pipelines, and bytes of device memory.
    std::pair<uint32_t, uint64_t> Made() {
        Device().WaitIdle();
        viewed.viewport.RenderFrame();  // takes back resources that the device no longer uses
        Device().WaitIdle();
        return {viewed.renderer.PipelineCount(), Device().Memory().usedBytes};
    }

    // Returns the passes that the last frame executed, one on each line.
    std::string Passes() {
        std::istringstream plan(viewed.renderer.DescribePlan());
        std::string passes, line;
        std::getline(plan, line);  // skips the counts, which include barriers
        while (std::getline(plan, line))
            if (!line.empty() && std::isdigit(static_cast<unsigned char>(line[0]))) passes += line + "\n";
        return passes;
    }

    struct Times {
        std::vector<double> seconds;

        double Quantile(double share) {
            const auto place = seconds.begin() + static_cast<ptrdiff_t>(share * double(seconds.size() - 1));
            std::nth_element(seconds.begin(), place, seconds.end());
            return *place;
        }
        double Median() { return Quantile(0.5); }
        // Standard error of the median, for normally distributed times: sqrt(pi / 2) sigma / sqrt(n), where
        // the middle half of them spans 1.349 sigma.
        double ErrorOfMedian() {
            const double sigma = (Quantile(0.75) - Quantile(0.25)) / 1.349;
            return 1.2533 * sigma / std::sqrt(double(seconds.size()));
        }
    };

    ViewedScene viewed{Device(), {96, 72}};
};

}  // namespace

TEST_F(ViewportEndurance, Toggle_TheFirstFrameCostsNoMoreThanOneWithoutAToggle) {
    constexpr int kToggles = 20;
    viewed.viewport.SetBudget({.maxRasterSamples = 0});  // no view stops rendering
    for (int toggle = 0; toggle < 4; ++toggle) {         // makes pipelines and textures
        FrameSeconds(View::Raster, View::PathTraced);
        FrameSeconds(View::PathTraced, View::Raster);
    }
    const uint32_t resets = viewed.AllResets();
    const auto made = Made();
    for (const View view : {View::Raster, View::PathTraced}) {
        const View other = view == View::Raster ? View::PathTraced : View::Raster;
        Times toggled, steady;
        for (int toggle = 0; toggle < kToggles; ++toggle) {
            steady.seconds.push_back(FrameSeconds(view, view));
            const std::string passes = Passes();
            toggled.seconds.push_back(FrameSeconds(view, other));
            ASSERT_EQ(Passes(), passes) << "a toggle adds none";
        }
        // Whatever a toggle made anew would cost more than a fifth of a frame, or show in the plan. The noise
        // is four standard errors of the difference between the medians.
        const double noise = 4.0 * std::hypot(toggled.ErrorOfMedian(), steady.ErrorOfMedian());
        EXPECT_LT(toggled.Median(), 1.2 * steady.Median() + noise) << Name(view);
        RecordProperty(std::string("ratio of ") + Name(view),
                       std::to_string(toggled.Median() / steady.Median()));
        RecordProperty(std::string("noise of ") + Name(view), std::to_string(noise / steady.Median()));
    }
    EXPECT_EQ(viewed.AllResets(), resets);
    EXPECT_EQ(Made(), made) << "a toggle makes nothing anew";
}

TEST_F(ViewportEndurance, FiveHundredFrames_LeaveMemoryAsItWas) {
    viewed.viewport.SetSize({16, 12});
    const auto visit = [&](int frame) {
        scene::CameraView camera = InsideBoxes();
        const float angle = 0.1f * float(frame % 100);
        camera.eye += 0.1f * glm::vec3(std::cos(angle), 0.0f, std::sin(angle));
        if (frame % 3 == 0) viewed.viewport.SetCamera(camera);
        const View views[] = {View::PathTraced, View::Raster, View::Wipe, View::Difference};
        viewed.viewport.SetView(views[frame / 5 % 4]);
        const uint32_t size = 8 + static_cast<uint32_t>(frame % 10);
        if (frame % 10 < 2) viewed.viewport.SetSize({16 + size, 12 + size});
        if (frame % 7 == 0) viewed.scene.SetTransform(1, Translation({0.02f * float(frame % 20), -0.5f, 0}));
        if (frame % 11 == 0) viewed.scene.SetMaterial(1, Lambert(glm::vec3(0.01f * float(frame % 90))));
        viewed.viewport.RenderFrame();
    };
    constexpr int kFrames = 500, kSettled = 100;
    uint64_t deviceBytes = 0, residentBytes = 0;
    for (int frame = 0; frame < kFrames; ++frame) {
        visit(frame);
        if (frame != kSettled - 1 && frame != kFrames - 1) continue;
        std::ignore = Made();
        if (frame == kSettled - 1) {
            deviceBytes = Device().Memory().usedBytes;
            residentBytes = ResidentBytes();
        }
    }
    EXPECT_LE(Device().Memory().usedBytes, deviceBytes + deviceBytes / 50);
    EXPECT_LE(ResidentBytes(), residentBytes + (1u << 20u));
    RecordProperty("device bytes", std::to_string(Device().Memory().usedBytes));
    RecordProperty("host bytes more", std::to_string(int64_t(ResidentBytes()) - int64_t(residentBytes)));
}

}  // namespace raygraph::testing::endurance_test
