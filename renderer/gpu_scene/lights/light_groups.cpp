#include "renderer/gpu_scene/lights/light_groups.h"

#include <string>

#include "base/text.h"

namespace raygraph {

void RequireFitting(const LightGroups& groups, size_t instanceCount, size_t materialCount,
                    size_t lightCount) {
    const auto check = [&](const char* what, const std::vector<uint32_t>& list, size_t count) {
        if (!list.empty() && list.size() != count)
            throw MakeError(ErrorKind::Usage, "GpuScene: groups of {} {}, the scene has {}", list.size(),
                            what, count);
        for (const uint32_t group : list)
            if (group != gpu::kLightGroupRest &&
                (group < gpu::kLightGroupNamed || group - gpu::kLightGroupNamed >= groups.namedCount))
                throw MakeError(ErrorKind::Usage, "GpuScene: light group {} of {}, with {} named groups",
                                group, what, groups.namedCount);
    };
    if (groups.namedCount > gpu::kMaxNamedLightGroups)
        throw MakeError(ErrorKind::Usage, "GpuScene: {} light groups, at most {} have names",
                        groups.namedCount, gpu::kMaxNamedLightGroups);
    check("instances", groups.instances, instanceCount);
    check("materials", groups.materials, materialCount);
    check("lights", groups.lights, lightCount);
}

}  // namespace raygraph
