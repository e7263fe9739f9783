// RenderJob is what `render` is to do, from the command line and a resumed file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/log.h"
#include "editor/cli/arguments.h"
#include "editor/cli/picture_list.h"
#include "editor/session/file/resume.h"
#include "editor/session/settings/scene_input.h"
#include "passes/tonemap.h"

namespace raygraph::cli {

struct RenderJob {
    PictureSettings settings;  // settings of the first picture
    AovSet aovs;
    uint32_t firstSample = 0;
    std::optional<uint32_t> samplesWanted;  // total for a picture; none: until the time is up
    std::optional<ResumedRender> resumed;   // for the first picture
};

// Returns how a .png shows a picture of this scene. Throws Error{BadInput} if its white point is that of the
// scene's light, and nothing emits light.
passes::TonemapSettings DisplayFor(const RenderArguments& arguments, const PictureSettings& settings,
                                   const SceneInput& input);

// Plans the job; `arguments` has all its outputs. Throws Error{Usage} for options that exclude each other.
RenderJob PlanJob(const RenderArguments& arguments, const Log& log);

// Returns the render that a picture continues, if one is asked for; with checkpoints it need not exist.
std::optional<ResumedRender> ResumedFor(const RenderArguments& arguments, const PictureName& name,
                                        const Log& log);

// Throws Error{BadInput} that names the first difference if a complete render is not that picture of the job.
// Scene and environment map are compared by the names of their files alone, since they are not loaded for
// this.
void RequireSameRequest(const ResumedRender& complete, const RenderArguments& arguments, const RenderJob& job,
                        const PlannedPicture& picture);

// Serialize the job, without the resumed render, for processes with the same arguments. JobFrom throws
// Error{BadInput} for malformed text.
std::string JobText(const RenderJob& job);
RenderJob JobFrom(const std::string& text);

bool WritesKind(const RenderArguments& arguments, OutputKind kind);

}  // namespace raygraph::cli
