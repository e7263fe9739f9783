// SharedRender renders one picture on all devices of a session, and of the other processes if there are any;
// DeviceRender renders the part of one device. For editor/session/ alone.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "editor/session/frames/device_scene.h"
#include "editor/session/frames/sample_frames.h"
#include "editor/session/group/block_queue.h"
#include "editor/session/process_group.h"
#include "editor/session/settings/tracing_choice.h"

namespace raygraph::session {

// DeviceRender renders one device's part of a picture.
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
    double m_seconds = 0.0, m_samples = 0.0;  // seconds and number of all other samples, in finished rounds
    int m_estimatedWidth = 0;                 // bits of the sample count at the last estimate
    uint32_t m_step = 1;                      // adaptive pictures: average samples per pixel and step
    std::atomic<double> m_errorOfOneSample{0.0};
};

// Threads: one at a time; it has threads of its own while a round lasts.
class SharedRender {
  public:
    // Uploads the scene to each device, out of `input`; meanwhile each has a copy. `group` is null, or the
    // processes that make one of these each, and the same calls in the same order; it outlives the object, as
    // the devices do. All devices use the choice of the root's first one for what `tracing` leaves open.
    // Throws as DeviceScene does.
    SharedRender(std::span<rhi::Device* const> devices, SceneInput& input, const PictureSettings& settings,
                 const TracingChoice& tracing, ProcessGroup* group);

    // Returns why not all devices can use software traversal, which the first one wants; empty if they can,
    // or if it is not wanted.
    const std::string& DriverTraversalReason() const { return m_driverTraversalReason; }
    // Begins a picture. Only the root has a render that is continued. Returns its last measurement.
    std::optional<MeasuredError> Begin(const FramePlan& plan);
    // Changes the scene's time for another picture.
    void SetTime(double at);
    void SetCamera(const std::string& camera);
    // Throws as the constructor does for a camera that is not in the scene.
    void RequireCamera(const std::string& camera) const { First().Scene().RequireCamera(camera); }

    bool IsRoot() const { return m_group == nullptr || m_group->IsRoot(); }
    // Returns whether this process has one device, and there is no other process.
    bool IsAlone() const { return m_group == nullptr && m_devices.size() == 1; }
    uint32_t SampleCount() const { return m_sampleCount; }  // samples of the picture

    // Returns how many samples of the picture are known to be done.
    uint32_t SamplesDone();
    // Waits for all of them if there is one device.
    void WaitForSamples();
    // Returns the error for progress, from the samples of one device.
    std::optional<double> RelativeError() const;

    enum class RoundEnd : uint8_t { Complete, Stopped, Late };
    // Renders until the picture has `samples`, more than it has, or until `tick` ends the round early: at
    // least one sample. `tick` is called repeatedly on this thread; the root's result applies to all, and so
    // does Stopped from any process.
    RoundEnd RenderTo(uint32_t samples, bool isEstimating, const std::function<RoundEnd()>& tick);

    // Measures the error of the samples in the picture.
    MeasuredError MeasureError();
    // Combines what all have rendered: the root has the picture then. `described` names it.
    void Finish(const RenderFile& described);
    bool HasPicture() const;
    RenderFile Picture(const RenderFile& described) const;
    image::Image8 Display() const;
    uint64_t NonFiniteSamples();

    DeviceRender& First() const { return *m_devices.front(); }
    // Traces again what a continued render has no sums of, sample by sample; returns false if it was stopped
    // first.
    bool RestoreSurfaces(const std::function<bool()>& isStopRequested,
                         const std::function<void(uint32_t count)>& onRestored);

  private:
    // Makes all devices trace in one way: by the driver, unless all can use software traversal.
    void SynchronizeTraversal();
    RoundEnd RunAdaptive(uint32_t average, bool isEstimating, const std::function<RoundEnd()>& tick);
    RoundEnd RunRound(BlockDealer* dealer, bool isEstimating, const std::function<RoundEnd()>& tick);
    void CombineSums(RenderFile& render);

    ProcessGroup* m_group;
    std::vector<std::unique_ptr<DeviceRender>> m_devices;
    uint32_t m_deviceCount = 0;  // in all processes
    std::string m_driverTraversalReason;
    bool m_isAdaptive = false;
    uint32_t m_firstSample = 0;
    uint32_t m_sampleCount = 0;
    uint32_t m_samplesOfRounds = 0;         // samples before the round
    const BlockDealer* m_dealer = nullptr;  // deals the blocks of the round, on the root
    // Holds the combined picture of several devices after Finish
    std::optional<RenderFile> m_pooled;
    image::Image8 m_display;
    uint64_t m_nonFiniteSamples = 0;
};

}  // namespace raygraph::session
