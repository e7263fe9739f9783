// Renders small pictures of the scene as it is not, for mistakes that no AOV foretells: an environment that
// is turned, and an object that blocks no light. Threads: that of the device's Renderers.
#pragma once

#include <functional>

#include "base/api.h"
#include "editor/session/settings/scene_input.h"
#include "editor/session/verify/diagnosis.h"
#include "rhi/device.h"

namespace raygraph::session {

struct AlternativesRequest {
    const SceneInput& input;
    const PictureSettings& settings;  // of the reference
    const RenderFile& render;         // the reference with its AOVs
    const Picture &reference, &picture;
    const Texels& noise;  // variance of picture - reference
    double tolerance = 0.0;
    const std::vector<float>& relative;  // see JudgedAgainst
    std::function<bool()> isStopRequested;
};

// Adds what such pictures explain to the diagnosis, and ranks it. All are of 32 samples a pixel with the same
// random numbers as one of the scene as it is, so that their differences have little noise, and of about 4096
// pixels at most. The picture is averaged to their size.
RAYGRAPH_API void WeighAlternatives(Diagnosis& diagnosis, rhi::Device& device,
                                    const AlternativesRequest& request);

}  // namespace raygraph::session
