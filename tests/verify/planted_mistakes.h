// A scene for Verify, and pictures of it with the mistakes of a host's renderer. Threads: pure functions, but
// for those that take a device: its thread.
#pragma once

#include <functional>
#include <vector>

#include "editor/session/session.h"
#include "editor/session/verify/verify.h"

namespace raygraph::session::test {

// Returns the terrace with named lights, under a sky with a bright window, with bumps on its floor. `edit`
// changes it before it is prepared.
SceneInput PlantedScene(const std::function<void(scene::SceneData&)>& edit = {});

// Renders pictures as a host's renderer may: each with a seed that the reference has not.
struct Host {
    rhi::Device& device;
    PictureSettings settings;
    uint32_t samples = 64;

    Picture Render(SceneInput input, const PictureSettings& changed) const;
    Picture Render(SceneInput input) const { return Render(std::move(input), settings); }
};

struct PlantedMistake {
    const char* what;
    std::function<Picture(const Host&)> picture;
    // The hypothesis that names it. Several names are separated by '|'; "" is any.
    const char *kind, *name;

    bool IsNamedBy(const Diagnosis& diagnosis) const;
};

const std::vector<PlantedMistake>& PlantedMistakes();

}  // namespace raygraph::session::test
