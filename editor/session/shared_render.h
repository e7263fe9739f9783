// One picture, rendered by all devices of a session, and of the other processes if there are any. For
// editor/session/ alone.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "editor/session/device_render.h"
#include "editor/session/process_group.h"
#include "editor/session/tracing_choice.h"

namespace raygraph::session {

// Threads: one at a time; it has others of its own, for as long as a round takes.
class SharedRender {
  public:
    // Uploads the scene to each device, out of `input`; while it does, each has a copy. `group`: null, or of
    // processes of which each makes one of these, and makes the same calls in the same order; it outlives the
    // object, as the devices do. What `tracing` leaves open is for all devices as the root's first one has
    // it. Errors as of DeviceScene.
    SharedRender(std::span<rhi::Device* const> devices, SceneInput& input, const PictureSettings& settings,
                 const TracingChoice& tracing, ProcessGroup* group);

    // Why own traversal, which the first device wants, is not possible on all of them; empty: it is, or is
    // not wanted.
    const std::string& WhyNotOwn() const { return m_whyNotOwn; }
    // Begins a picture. Of a render that is continued the root alone has it. Returns what it measured last.
    std::optional<MeasuredError> Begin(const FramePlan& plan);
    // The scene as another picture has it.
    void SetTime(double at);
    void SetCamera(const std::string& camera);
    // Throws as the constructor for a camera that is not in the scene.
    void RequireCamera(const std::string& camera) const { First().Scene().RequireCamera(camera); }

    bool IsRoot() const { return m_group == nullptr || m_group->IsRoot(); }
    // This process has one device, and there is no other process.
    bool IsAlone() const { return m_group == nullptr && m_devices.size() == 1; }
    uint32_t SampleCount() const { return m_sampleCount; }  // in the picture

    // Of the samples in the picture now, those that are done, as far as is known.
    uint32_t SamplesDone();
    // Waits for all of them where there is one device.
    void WaitForSamples();
    // For progress, from the samples of one device.
    std::optional<double> RelativeError() const;

    enum class RoundEnd : uint8_t { Complete, Stopped, Late };
    // Renders until the picture has `samples`, more than it has, or until `tick` says that it is to end
    // early: at least one sample. `tick` is called again and again, on this thread; what the root says is of
    // effect everywhere, and so is Stopped from any process.
    RoundEnd RenderTo(uint32_t samples, bool isEstimating, const std::function<RoundEnd()>& tick);

    // Of the samples in the picture.
    MeasuredError MeasureError();
    // Takes together what all have rendered: the root has the picture then. `described` is what it is called.
    void Finish(const RenderFile& described);
    bool HasPicture() const;
    RenderFile Picture(const RenderFile& described) const;
    image::Image8 Display() const;
    uint64_t NonFiniteSamples();

    DeviceRender& First() const { return *m_devices.front(); }
    // Traces again what a continued render has no sums of, sample by sample; false: it was stopped first.
    bool RestoreSurfaces(const std::function<bool()>& isStopRequested,
                         const std::function<void(uint32_t count)>& onRestored);

  private:
    // All devices trace in one way: by the driver, unless all can trace by own trees.
    void AgreeOnTraversal();
    RoundEnd RunAdaptive(uint32_t average, bool isEstimating, const std::function<RoundEnd()>& tick);
    RoundEnd RunRound(BlockDealer* dealer, bool isEstimating, const std::function<RoundEnd()>& tick);
    void Pool(RenderFile& render);

    ProcessGroup* m_group;
    std::vector<std::unique_ptr<DeviceRender>> m_devices;
    uint32_t m_deviceCount = 0;  // of all processes
    std::string m_whyNotOwn;
    bool m_isAdaptive = false;
    uint32_t m_firstSample = 0;
    uint32_t m_sampleCount = 0;
    uint32_t m_samplesOfRounds = 0;         // before the round
    const BlockDealer* m_dealer = nullptr;  // of the round, on the root
    // Of several devices, once finished
    std::optional<RenderFile> m_pooled;
    image::Image8 m_display;
    uint64_t m_nonFiniteSamples = 0;
};

}  // namespace raygraph::session
