#include "renderer/gpu_scene/light_groups.h"

#include <string>

#include "base/error.h"

namespace raygraph {

void RequireFitting(const LightGroups& groups, size_t instanceCount, size_t materialCount,
                    size_t lightCount) {
    const auto check = [&](const char* what, const std::vector<uint32_t>& list, size_t count) {
        if (!list.empty() && list.size() != count)
            throw Error(ErrorKind::Usage, "GpuScene: groups of " + std::to_string(list.size()) + " " + what +
                                              ", the scene has " + std::to_string(count));
        for (const uint32_t group : list)
            if (group != gpu::kLightGroupRest &&
                (group < gpu::kLightGroupNamed || group - gpu::kLightGroupNamed >= groups.namedCount))
                throw Error(ErrorKind::Usage, "GpuScene: light group " + std::to_string(group) + " of " +
                                                  what + ", with " + std::to_string(groups.namedCount) +
                                                  " named groups");
    };
    if (groups.namedCount > gpu::kMaxNamedLightGroups)
        throw Error(ErrorKind::Usage, "GpuScene: " + std::to_string(groups.namedCount) +
                                          " light groups, at most " +
                                          std::to_string(gpu::kMaxNamedLightGroups) + " have names");
    check("instances", groups.instances, instanceCount);
    check("materials", groups.materials, materialCount);
    check("lights", groups.lights, lightCount);
}

}  // namespace raygraph
