// Pictures that a binding of another language renders and hands out: what is asked for, and the result as
// arrays, files and a display. The Python package and the C interface share it; hosts in C++ have Session.
// Threads: one at a time for each object.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/api.h"
#include "editor/session/binding/edited_scene.h"
#include "editor/session/session.h"

namespace raygraph::session {

// Holds what is asked for beside the settings of the picture. Texts are those of the options of `raygraph
// render`.
struct PictureRequest {
    std::vector<std::string> aovs;
    std::optional<uint32_t> samples;
    std::optional<double> seconds, relativeError;
    uint32_t firstSample = 0;
    std::string denoiser;  // "": not denoised
    float exposureEv = 0.0f;
    std::string tonemap;     // "": the default
    std::string whitePoint;  // "auto" or kelvin; "": the display's white
    // The render that the picture continues; null: none. Settings and AOVs that are not asked for, and a
    // first sample of 0, are those of the render; `samples` counts its samples, too.
    std::shared_ptr<const ResumedRender> resumed = nullptr;
};

// Returns how the picture is shown. `input` is for a white point of the scene's light, "auto"; without it
// this is refused. Throws SettingError of kind Usage, or BadInput for a scene without light.
RAYGRAPH_API passes::TonemapSettings TonemapOf(const PictureRequest& request, const SceneInput* input,
                                               const PictureSettings& settings);

// Holds everything of a render but its device.
struct PlannedPicture {
    SceneInput input;
    SessionDesc desc;
    StopRule rule;
    std::shared_ptr<const ResumedRender> resumed;  // what desc.resumed points to
};

// Takes a copy of the scene. Throws SettingError of kind Usage for what is asked for and cannot be had, for
// what differs from the render to resume, and for one without a limit of samples, time or error; and as
// SettingsFrom, EditedScene::Update and RequireResumable do.
RAYGRAPH_API PlannedPicture PlanPicture(EditedScene& scene, SettingTexts settings,
                                        const PictureRequest& request);

struct FinishedPicture {
    RenderFile render;
    std::optional<image::Image8> display;  // none: of a file or a merged picture
    double seconds = 0.0;                  // of sampling
    bool wasStopped = false;
};

// Renders on one device or several of one kind, as RunInterruptibly does. `goesOn`, which may be empty, is
// called on this thread after each sample; false ends the run with the samples so far. None:
// `isStopRequested` has ended it without a picture.
RAYGRAPH_API std::optional<FinishedPicture> Render(std::vector<std::shared_ptr<rhi::Device>> devices,
                                                   PlannedPicture planned,
                                                   const std::function<bool()>& isStopRequested,
                                                   const std::function<bool(const ProgressState&)>& goesOn);

// Describes an array of a picture, whose memory it views. A pixel has `channels` 32-bit numbers, and the next
// one begins `stride` numbers later. Rows are from the top, without gaps.
struct PictureChannel {
    std::string name;
    const void* data = nullptr;
    bool isInteger = false;  // uint32; false: float
    uint32_t channels = 0, stride = 0;
};
// Returns those that the picture has: "color", "variance", and what was asked for, by the names of AOVs.
RAYGRAPH_API std::vector<PictureChannel> ChannelsOf(const RenderFile& render);

// Returns the standard error of a pixel over the picture's mean; none if it is not known.
RAYGRAPH_API std::optional<double> RelativeErrorOf(const RenderFile& render);

// Returns a render as a display shows it by default: of a file or a merged picture.
RAYGRAPH_API image::Image8 ShowRender(rhi::Device& device, const RenderFile& render);

// Writes a .png or .jpg of what `shown` returns, an .exr with everything, or an .hdr. Throws Error{Usage} for
// another extension, and Error{Io}.
RAYGRAPH_API void SavePicture(const std::filesystem::path& path, const RenderFile& render,
                              const std::function<const image::Image8&()>& shown, const Log& log);

}  // namespace raygraph::session
