// DeviceRender renders one device's part of a picture. For editor/session/ alone.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "editor/session/frames/device_scene.h"
#include "editor/session/frames/sample_frames.h"
#include "editor/session/group/block_dealer.h"

namespace raygraph::session {

// Threads: one at a time, except where noted.
class DeviceRender {
  public:
    // Takes the arguments of DeviceScene.
    DeviceRender(rhi::Device& device, SceneInput& input, const PictureSettings& settings,
                 const TracingChoice& tracing)
        : m_scene(device, input, settings, tracing) {}

    DeviceScene& Scene() { return m_scene; }
    // Begins a picture.
    void Begin(const FramePlan& plan) {
        m_frames = std::make_unique<SampleFrames>(m_scene, plan);
        m_errorOfOneSample = 0.0;
        m_estimatedWidth = 0;
    }
    SampleFrames& Frames() { return *m_frames; }
    const SampleFrames& Frames() const { return *m_frames; }

    // Returns how many samples of the current picture one frame renders, a power of two.
    uint32_t PreferredBatchSize() const { return m_frames->PreferredBatchSize(); }
    // Renders the blocks of `source` for this device, and waits for the last sample. `isEstimating`:
    // estimates the error from time to time. `afterSamples` is called after some were submitted.
    void RenderBlocks(BlockSource& source, uint32_t device, bool isEstimating,
                      const std::function<void()>& afterSamples = {});
    // Is called for an adaptive picture instead: renders until it has the average, or until `afterFrames`
    // asks it to end; at least some frames.
    void RenderAdaptive(uint32_t average, bool isEstimating, const std::function<bool()>& afterFrames);
    // Returns the error of one sample by this device's samples, for progress; 0: not known. Threads: any.
    double ErrorOfOneSample() const { return m_errorOfOneSample.load(std::memory_order_relaxed); }

  private:
    void Estimate();

    DeviceScene m_scene;
    std::unique_ptr<SampleFrames> m_frames;
    bool m_isWarm = false;                    // the first sample, which compiles pipelines, is done
    double m_seconds = 0.0, m_samples = 0.0;  // of all other samples, in finished rounds
    int m_estimatedWidth = 0;                 // bits of the sample count at the last estimate
    uint32_t m_step = 1;                      // adaptive pictures: average samples per pixel and step
    std::atomic<double> m_errorOfOneSample{0.0};
};

}  // namespace raygraph::session
