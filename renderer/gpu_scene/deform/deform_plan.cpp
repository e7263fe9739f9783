#include "renderer/gpu_scene/deform/deform_plan.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "renderer/scene/animation/deform.h"

namespace raygraph {

DeformPlan PlanDeformation(const scene::SceneData& scene) {
    DeformPlan plan;
    plan.copyOf.assign(scene.instances.size(), scene::kNone);
    std::vector<bool> isPlaced(scene.meshes.size());
    plan.isBaseShapeDrawn.assign(scene.meshes.size(), false);
    struct Owner {  // of the weights
        bool hasTargets = false, isNode = false;
        uint32_t index = 0;
        auto operator<=>(const Owner&) const = default;
    };
    std::map<std::tuple<uint32_t, uint32_t, Owner>, std::vector<uint32_t>> copies;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const scene::Instance& instance = scene.instances[i];
        const bool hasSkin = instance.isDeformed && scene::HasSkin(scene, instance);
        const bool hasTargets = instance.isDeformed && scene::HasTargets(scene, instance);
        isPlaced[instance.mesh] = true;
        if (!hasSkin && !hasTargets) {
            plan.isBaseShapeDrawn[instance.mesh] = true;
            continue;
        }
        const uint32_t skin = hasSkin ? scene.nodes[instance.node].skin : scene::kNone;
        const bool isNode = instance.node != scene::kNone;
        const Owner owner = hasTargets ? Owner{true, isNode, isNode ? instance.node : i} : Owner{};
        copies[{instance.mesh, skin, owner}].push_back(i);
    }
    for (size_t mesh = 0; mesh < isPlaced.size(); ++mesh)
        if (!isPlaced[mesh]) plan.isBaseShapeDrawn[mesh] = true;
    for (auto& [key, instances] : copies) {
        for (const uint32_t instance : instances)
            plan.copyOf[instance] = static_cast<uint32_t>(plan.copies.size());
        plan.copies.push_back({.mesh = std::get<0>(key),
                               .skin = std::get<1>(key),
                               .hasTargets = std::get<2>(key).hasTargets,
                               .instances = std::move(instances)});
    }
    return plan;
}

}  // namespace raygraph
