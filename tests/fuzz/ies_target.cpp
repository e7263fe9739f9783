// Fuzzes light profiles: files of IES LM-63.
#include <cmath>

#include "renderer/scene/formats/ies_file.h"
#include "renderer/scene/model/check.h"
#include "tests/fuzz/target.h"

namespace raygraph::fuzz {

void RunProfiles(Input input) {
    scene::IesFile file;
    if (!Succeeds("line ", {ErrorKind::BadInput}, [&] { file = scene::ParseIes(AsText(input)); })) return;
    const double mean = file.profile.MeanIntensity(), max = double{file.profile.MaxIntensity()};
    // A web between only two angles has this much rounding
    Require(std::isfinite(mean) && mean >= -1e-6 * max && mean <= (1.0 + 1e-5) * max,
            "the mean intensity is not one of the profile's");
    scene::SceneData scene;
    scene.profiles.push_back(std::move(file.profile));
    scene.lights.push_back({.profile = 0});
    Require(Succeeds("", {}, [&] { scene::Check(scene, "scene"); }), "a profile of a file is refused");
}

}  // namespace raygraph::fuzz
