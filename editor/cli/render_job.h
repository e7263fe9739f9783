// What `render` is asked for, once the command line and a resumed file have been brought together.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/log.h"
#include "editor/cli/arguments.h"
#include "editor/cli/picture_list.h"
#include "editor/session/resume.h"
#include "editor/session/scene_input.h"
#include "passes/tonemap.h"

namespace raygraph::cli {

struct RenderJob {
    PictureSettings settings;  // of the first picture
    AovSet aovs;
    uint32_t firstSample = 0;
    std::optional<uint32_t> samplesWanted;  // of a picture in all; none: until the time is up
    std::optional<ResumedRender> resumed;   // of the first picture
};

// How a .png of the job shows the picture, of this scene. Error{BadInput} where its white point is to be that
// of the scene's light, and nothing emits any.
passes::TonemapSettings DisplayFor(const RenderArguments& arguments, const PictureSettings& settings,
                                   const SceneInput& input);

// `arguments` with all its outputs. Error{Usage} for what does not go together.
RenderJob PlanJob(const RenderArguments& arguments, const Log& log);

// The render that a picture goes on with, if one is asked for: where there are checkpoints, if it is there.
std::optional<ResumedRender> ResumedFor(const RenderArguments& arguments, const PictureName& name,
                                        const Log& log);

// Error{BadInput} naming the first difference, where a complete render is not that picture of the job. The
// contents of scene and environment map are not compared: they are not loaded for it; the files' names are.
void RequireAsked(const ResumedRender& complete, const RenderArguments& arguments, const RenderJob& job,
                  const PlannedPicture& picture);

// For other processes, that have the same arguments: all but the resumed render. Error{BadInput} for a text
// that is none.
std::string JobText(const RenderJob& job);
RenderJob JobFrom(const std::string& text);

bool WritesKind(const RenderArguments& arguments, OutputKind kind);

}  // namespace raygraph::cli
