// One device's part of a picture. For editor/session/ alone.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "editor/session/block_dealer.h"
#include "editor/session/device_scene.h"
#include "editor/session/sample_frames.h"

namespace raygraph::session {

// Threads: one at a time, but for what says otherwise.
class DeviceRender {
  public:
    // As DeviceScene.
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

    // A power of two: of the picture that was begun, as many as one frame renders.
    uint32_t SamplesAtOnce() const { return m_frames->SamplesAtOnce(); }
    // Renders what `source` has for this device, and waits for the last sample. `isEstimating`: estimates the
    // error from time to time. `afterSamples` is called after some were submitted.
    void RenderBlocks(BlockSource& source, uint32_t device, bool isEstimating,
                      const std::function<void()>& afterSamples = {});
    // Of an adaptive picture, instead: until it has that average, or `afterFrames` says that it is to end; at
    // least some frames.
    void RenderWhereNeeded(uint32_t average, bool isEstimating, const std::function<bool()>& afterFrames);
    // The error of one sample, from this device's samples, for progress; 0: not known. Threads: any.
    double ErrorOfOneSample() const { return m_errorOfOneSample.load(std::memory_order_relaxed); }

  private:
    void Estimate();

    DeviceScene m_scene;
    std::unique_ptr<SampleFrames> m_frames;
    bool m_isWarm = false;                    // the first sample, which compiles the pipelines, is done
    double m_seconds = 0.0, m_samples = 0.0;  // of the others, of rounds that have ended
    int m_estimatedWidth = 0;                 // of the count of samples at the last estimate, in bits
    uint32_t m_step = 1;                      // of an adaptive picture: samples of a pixel, on average
    std::atomic<double> m_errorOfOneSample{0.0};
};

}  // namespace raygraph::session
