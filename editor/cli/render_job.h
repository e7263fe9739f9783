// What `render` is asked for, once the command line and a resumed file have been brought together.
#pragma once

#include <cstdint>
#include <optional>

#include "base/log.h"
#include "editor/cli/arguments.h"
#include "editor/session/resume.h"
#include "editor/session/scene_input.h"
#include "passes/tonemap.h"

namespace raygraph::cli {

struct RenderJob {
    PictureSettings settings;  // of the first frame
    AovSet aovs;
    uint32_t firstSample = 0;
    uint32_t samplesBefore = 0;             // of a resumed render
    std::optional<uint32_t> samplesWanted;  // in all; none: until the time is up
    std::optional<ResumedRender> resumed;
};

// How a .png of the job shows the picture, of this scene. Error{BadInput} where its white point is to be that
// of the scene's light, and nothing emits any.
passes::TonemapSettings DisplayFor(const RenderArguments& arguments, const PictureSettings& settings,
                                   const SceneInput& input);

// `arguments` with all its outputs. Error{Usage} for what does not go together.
RenderJob PlanJob(const RenderArguments& arguments, const Log& log);

bool WritesKind(const RenderArguments& arguments, OutputKind kind);

}  // namespace raygraph::cli
