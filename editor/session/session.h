// Session: renders one picture of a scene offline, a sample of every pixel a frame, with the channels that
// are asked for. It knows no command line and prints nothing.
//
//   const auto device = rhi::Device::Create();
//   session::Session session(*device, session::LoadInput("scene.gltf"), {.aovs = {session::Aov::Albedo}});
//   session.Run({.samples = 256});
//   session::WriteRenderFile("picture.exr", session.Result().render);
//
// The bits of a picture depend on the device, the settings and the range of samples, and not on how many runs
// took them: a resumed render has the bits of one that was never interrupted.
//
// Threads: one at a time, as a Renderer; the device may be in use by others.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "base/api.h"
#include "editor/session/aovs.h"
#include "editor/session/image_statistics.h"
#include "editor/session/pass_times.h"
#include "editor/session/picture_settings.h"
#include "editor/session/render_file.h"
#include "editor/session/resume.h"
#include "editor/session/run.h"
#include "editor/session/scene_input.h"
#include "passes/tonemap.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/image/image.h"
#include "rhi/device.h"

namespace raygraph::session {

struct SessionDesc {
    PictureSettings settings;
    AovSet aovs;
    uint32_t firstSample = 0;                // index: renders of disjoint ranges of samples can be merged
    bool withVariance = true;                // of the radiance
    bool withSums = true;                    // without them the render can be neither resumed nor merged
    passes::TonemapSettings tonemap{};       // of Session::Display
    const ResumedRender* resumed = nullptr;  // its samples come first; not kept
};

// A render without samples: what is recorded beside its pictures. SettingError of kind Usage if the input is
// another of its file's scenes than that of the settings, or shows another variant.
RAYGRAPH_API RenderFile DescribeRender(const SceneInput& input, const PictureSettings& settings,
                                       const rhi::DeviceInfo& device);

// With its settings, AOVs and samples; it outlives the constructor of the session, so it is no temporary one.
// The scene to load is settings.scene, in settings.variant. Errors as of RequireResumable.
RAYGRAPH_API SessionDesc Resuming(const ResumedRender& render);
RAYGRAPH_API SessionDesc Resuming(const ResumedRender&& render) = delete;

struct SessionResult {
    RenderFile render;
    ImageStatistics statistics;
    std::map<Bias, RemovedLight> removed;  // of the biases that are on, where samples were traced twice
};

struct SessionStatistics {
    std::vector<PassTime> passes;  // over all frames of samples
    GpuSceneStatistics scene;
    double pipelinesMs = 0.0;  // making them
};

class RAYGRAPH_API Session {
  public:
    // Uploads the scene. `device` outlives the session. SettingError of kind Usage for a camera or group of
    // lights that is not in the scene, for another of the file's scenes than was loaded, and for settings
    // that no option takes, as they could not be read from a file; Error{Usage} for AOVs that a picture of
    // these settings cannot have, and for sample indices beyond the last; Error{BadInput} if scene,
    // environment or settings are not those of the resumed render, and as RequireResumable.
    Session(rhi::Device& device, SceneInput input, const SessionDesc& desc);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    // Renders until the rule says so, and waits for the last sample. May be called again, to go on; but for
    // a view without a mean over samples (passes::IsMeanMeaningful), which takes one sample, whatever the
    // rule says, it may be called once. `progress` is called after each sample was submitted, on this thread.
    //
    // Where albedo or normals of a resumed render have no sums, as those of the editor, the first run begins
    // by tracing those of its samples again; `progress` is called, and the rule asked whether to stop, for
    // each. A run that is stopped there ends without a sample of its own; the next goes on with it.
    //
    // Error{Usage} for a rule that cannot end (of a time that is not finite, of an error that is not above
    // 0), or that asks for no more samples than there are: nothing is rendered. After any other Error, the
    // session can only be destroyed.
    RunSummary Run(const StopRule& rule, const std::function<void(const ProgressState&)>& progress = {});

    // Begins another picture, at another time of the scene's animations, with the same settings else, and
    // without samples. What is on the device stays, so this takes no longer than moving the scene does; the
    // results of the last picture are gone. The bits are those of a session that began at this time, but
    // where a ray hits two surfaces at exactly the same distance. Error{Usage} for a scene without a time,
    // and a time that no setting can be.
    void StartPicture(double at);

    // Whether there is one: after a run that took a sample.
    bool HasResult() const;
    // After such a run: all that was asked for. Copies it from the device, and waits for that.
    SessionResult Result() const;
    // Tone-mapped, or the view as passes::PaintView shows it: sRGB. Opaque, unless the environment is hidden
    // (PathSettings::isEnvironmentHidden): then alpha is coverage, and color that of what is covered.
    image::Image8 Display() const;

    uint32_t SampleCount() const;  // in the picture, with resumed ones
    // Of the samples that this session rendered: infinite or NaN ones, which count as black.
    uint64_t NonFiniteSamples();
    SessionStatistics Statistics();
    // Rays that a path of the last sample takes, on average over the pixels; none where no paths are traced.
    // Renders that sample once more.
    std::optional<double> MeasureRaysPerSample();
    // Without scene and environment, which are on the device.
    const SceneInput& Input() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace raygraph::session
