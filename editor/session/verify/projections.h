// Projections of the difference of two pictures on predictions of it: the light of a part, of an object or of
// a material, or a shift. They are sums over many pixels, and tell a mistake from noise where no pixel and no
// tile can. Threads: pure functions.
#pragma once

#include <string>
#include <vector>

#include "base/api.h"
#include "editor/session/file/render_file.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::session {

struct Compared;

// Names of the scene that ids of AOVs stand for.
struct SceneNames {
    std::vector<std::string> instances, materials;  // by index; "" becomes a number
};
RAYGRAPH_API SceneNames NamesOf(const scene::SceneData& scene);

struct Projection {
    std::string kind, name, part;  // as in Hypothesis; `part` is what of an object is off, "": its light
    double amount = 0.0;           // picture = reference + amount * prediction, fitted
    double z = 0.0;                // of the sum
    // The difference along the prediction, beyond the noise, over the values that an error is relative to
    // (Tolerance). With the noise of the reference taken off what noise explains, or added to it, it decides
    // that the picture is right, or that it is not.
    double error = 0.0, errorForRight = 0.0, errorForWrong = 0.0;
};

// Returns "object `ball`, its diffuse light".
RAYGRAPH_API std::string ToText(const Projection& projection);

// Returns the projections that noise does not explain, largest error first.
//
// A prediction x at a pixel is the mean of the reference's part over the pixels around it, without the pixel
// itself, and so are the weights w, 1 / (variance + the square of what is allowed): then neither depends on
// the noise there, and the sum S of w x d has the mean 0 for a right picture. For a shift, x is the central
// difference of the reference. The variance of S is the larger one of that which the known noise gives, with
// colors correlated, and of the sum of squares that are left once the amount is fitted. All of a right
// picture are within their noise with a probability of 0.99 (Sidak). Predictions that have less than 32
// pixels to their sum do not count.
RAYGRAPH_API std::vector<Projection> Project(const Compared& all, const RenderFile* render,
                                             const SceneNames& names);

// Returns k for which |z| <= k holds for all of `count` normal numbers with probability 1 - significance.
RAYGRAPH_API double SidakDeviations(size_t count, double significance);

}  // namespace raygraph::session
