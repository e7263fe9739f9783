// Session: renders one picture of a scene offline, a sample of every pixel a frame, with the channels that
// are asked for. It knows no command line and prints nothing.
//
//   const auto device = rhi::Device::Create();
//   session::Session session(*device, session::LoadInput("scene.gltf"), {.aovs = {session::Aov::Albedo}});
//   session.Run({.samples = 256});
//   session::WriteRenderFile("picture.exr", session.Result().render);
//
// The bits of a picture depend on the device, the settings and the range of samples, and not on how many runs
// took them: a resumed render has the bits of one that was never interrupted. Several devices of one kind
// render a picture together, each a part of the samples, with the bits that one of them gives.
//
// Threads: one at a time, as a Renderer; the devices may be in use by others. With several devices a run has
// a thread for each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/api.h"
#include "editor/session/file/image_statistics.h"
#include "editor/session/file/render_file.h"
#include "editor/session/file/resume.h"
#include "editor/session/frames/pass_times.h"
#include "editor/session/process_group.h"
#include "editor/session/run.h"
#include "editor/session/settings/aovs.h"
#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"
#include "editor/session/settings/tracing_choice.h"
#include "passes/denoise.h"
#include "passes/tonemap.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/image/image.h"
#include "rhi/device.h"

namespace raygraph::session {

struct SessionDesc {
    PictureSettings settings;
    AovSet aovs;
    uint32_t firstSample = 0;  // index; renders of disjoint ranges can be merged
    bool withVariance = true;  // variance of the radiance
    bool withSums = true;      // without them the render can be neither resumed nor merged
    // Renders a denoised picture, too, which Session::Display shows and the file has beside the radiance
    // (docs/denoise.md). It needs a path-traced picture with variance that is not adaptive, on one device
    // without a group.
    bool isDenoised = false;
    passes::Denoiser denoiser = passes::Denoiser::Network;
    // The number of samples that a frame traces at once if the picture allows several: a power of two up to
    // 64; 0: as many as fill the device. It does not affect the bits.
    uint32_t batchSize = 0;
    passes::TonemapSettings tonemap{};  // used by Session::Display
    // Session::Display shows this where the environment is hidden (PathSettings::isEnvironmentHidden). None:
    // the picture has an alpha there.
    std::optional<passes::BackdropSettings> backdrop;
    const ResumedRender* resumed = nullptr;  // render to resume; only used by the constructor
    TracingChoice tracing{};                 // other than Auto for measurements
    // The other processes that render the picture; null: none. It outlives the session. Each process has a
    // session with the same settings, first sample and AOVs, on devices of its own, and makes the same calls
    // in the same order; some functions below are for the root alone. Only the root gets `resumed`.
    ProcessGroup* group = nullptr;
};

// Holds what differs in the next picture.
struct NextPicture {
    std::optional<double> at;                // time of the animations; none: unchanged
    std::optional<std::string> camera;       // see PictureSettings::camera; none: unchanged
    const ResumedRender* resumed = nullptr;  // see SessionDesc
};

// Returns a render without samples: what is recorded beside its pictures. Throws SettingError of kind Usage
// if the input has another scene of its file, or another variant, than the settings.
RAYGRAPH_API RenderFile DescribeRender(const SceneInput& input, const PictureSettings& settings,
                                       const rhi::DeviceInfo& device);

// Returns a description with the render's settings, AOVs and samples. The render must outlive the session's
// constructor, so it must not be a temporary. Load settings.scene in settings.variant. Throws as
// RequireResumable does.
RAYGRAPH_API SessionDesc Resuming(const ResumedRender& render);
RAYGRAPH_API SessionDesc Resuming(const ResumedRender&& render) = delete;

struct SessionResult {
    RenderFile render;
    ImageStatistics statistics;
    std::map<Bias, RemovedLight> removed;  // for biases that are on, if samples were traced twice
};

struct SessionStatistics {
    std::vector<PassTime> passes;  // over all frames of samples
    GpuSceneStatistics scene;
    double pipelinesMs = 0.0;  // time to make pipelines
};

class RAYGRAPH_API Session {
  public:
    // Uploads the scene. `device` outlives the session. Throws SettingError of kind Usage for a missing
    // camera or group of lights, for another scene of the file than was loaded, and for settings that no
    // option takes, since a file with them could not be read; Error{Usage} for AOVs that a picture with these
    // settings cannot have, and for sample indices beyond the last; Error{BadInput} if scene, environment or
    // settings differ from those of the resumed render, and as RequireResumable does.
    Session(rhi::Device& device, SceneInput input, const SessionDesc& desc);
    // Uploads the scene to each of several devices, at least one. What concerns one device below is of the
    // first. Devices of different kinds render the same picture, but not the same bits.
    Session(std::span<rhi::Device* const> devices, SceneInput input, const SessionDesc& desc);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    // Renders until the rule is met, and waits for the last sample. It may be called again, to continue,
    // except for a view without a mean over samples (passes::IsAverageable), which takes one sample,
    // whatever the rule. Several runs to one relative error end where a single one would.
    //
    // `progress` is called on this thread: after each sample was submitted, and several times a second where
    // there are several devices. In a group the rule is the same everywhere, the root's time counts, it alone
    // has progress, and a stop may be requested in any process.
    //
    // Where albedo or normals of a resumed render have no sums, as those of the editor, the first run begins
    // by tracing those of its samples again; `progress` is called, and the rule asked whether to stop, for
    // each. A run that is stopped there ends without a sample of its own; the next goes on with it.
    //
    // Error{Usage} for a rule that cannot end (of a time that is not finite, of an error that is not above
    // 0), or that asks for fewer samples than there are: nothing is rendered. After any other Error, the
    // session can only be destroyed. A run whose rule is met from the start, as of a resumed render that is
    // complete, ends at once, and the result is that of the samples that there are.
    RunSummary Run(const StopRule& rule, const std::function<void(const ProgressState&)>& progress = {});

    // Begins another picture with otherwise equal settings. The scene stays on the devices, so this takes no
    // longer than moving it; the results of the last picture are gone. The bits are those of a session that
    // began with it, except where a ray hits two surfaces at exactly the same distance. Throws Error{Usage}
    // for a time of a scene without one, and for an invalid time; SettingError as the constructor does for a
    // camera; and as the constructor does for the resumed render. Then nothing changes.
    void StartPicture(const NextPicture& next);
    // Throws SettingError of kind Usage for a camera that is not in the scene.
    void RequireCamera(const std::string& camera) const;

    // Returns whether a run has taken a sample; in a group, on the root only.
    bool HasResult() const;
    // Call it after such a run: returns everything that was asked for. It copies this from the device, and
    // waits.
    SessionResult Result() const;
    // Returns the tone-mapped picture, or the view as passes::PaintView shows it, in sRGB. It is opaque
    // unless the environment is hidden (PathSettings::isEnvironmentHidden) and there is no backdrop: then
    // alpha is coverage, and the color is that of the covered part.
    image::Image8 Display() const;

    uint32_t SampleCount() const;  // returns the samples of the picture, resumed ones included
    // Returns how many samples of this session, or its group, were infinite or NaN, and count as black.
    uint64_t NonFiniteSamples();
    SessionStatistics Statistics();
    // Returns the number of rays of a path, on average over the paths of the first device; none without a
    // path.
    std::optional<double> RaysPerSample();
    // Returns the input without scene and environment, which are on the device.
    const SceneInput& Input() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

}  // namespace raygraph::session
