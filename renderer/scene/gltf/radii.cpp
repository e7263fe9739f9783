#include "renderer/scene/gltf/radii.h"

#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "renderer/scene/geometry/flat_transform.h"

namespace raygraph::scene {
namespace {

bool IsSomeRound(const SceneData& scene) {
    return std::ranges::any_of(scene.meshes, [](const Mesh& mesh) {
        return std::ranges::any_of(mesh.primitives, [](const Primitive& p) { return p.IsRound(); });
    });
}

// The largest scale at which each mesh is placed; 0: not at all.
std::vector<double> ScalesOf(const SceneData& scene) {
    const std::vector<PlacedTransform> transforms = WorldTransforms(scene);
    std::vector<double> scales(scene.meshes.size(), 0.0);
    for (const Instance& instance : scene.instances) {
        const PlacedTransform placed = PlaceInstance(transforms[instance.node], instance);
        scales[instance.mesh] = std::max(scales[instance.mesh], MeanScale(placed.matrix));
    }
    return scales;
}

}  // namespace

// Relative ones are negative: what they are relative to is not known before all is placed.
float RequestedRadius(const RoundRadius& asked) {
    return asked.isRelative ? -asked.value : asked.value;
}

void SetRadii(GltfContext& context, SceneData& scene) {
    if (!IsSomeRound(scene)) return;
    const double diagonal = 2.0 * static_cast<double>(scene.bounds.Radius());
    const std::vector<double> scales = ScalesOf(scene);
    for (size_t m = 0; m < scene.meshes.size(); ++m)
        for (Primitive& primitive : scene.meshes[m].primitives) {
            if (!primitive.IsRound()) continue;
            const double asked = static_cast<double>(primitive.radii.front());
            if (asked < 0.0 && !(diagonal > 0.0))
                context.Fail(
                    Place("meshes")[m],
                    "all of the scene is one point, to which no radius is relative: give it in meters");
            const double inWorld = asked < 0.0 ? -asked * diagonal : asked;
            // A mesh that is placed nowhere gets any valid radius.
            const double radius = inWorld / (scales[m] > 0.0 ? scales[m] : 1.0);
            if (!(radius >= static_cast<double>(kMinRadius) && radius <= static_cast<double>(kMaxRadius)))
                context.Fail(Place("meshes")[m],
                             Text("a radius of {:.6g} m is {:.6g} at its scale, must be {:.6g} to {:.6g}",
                                  inWorld, radius, kMinRadius, kMaxRadius));
            std::ranges::fill(primitive.radii, static_cast<float>(radius));
            primitive.bounds = RoundBounds(primitive);
        }
    UpdateWorldTransforms(scene);
}

}  // namespace raygraph::scene
