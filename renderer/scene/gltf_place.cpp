#include "renderer/scene/gltf_place.h"

namespace raygraph::scene {

std::string Place::Path() const {
    std::string path;
    for (uint32_t i = 0; i < m_count; ++i) {
        const Step& step = m_steps[i];
        if (step.name)
            path.append(path.empty() ? "" : ".").append(step.name);
        else
            path.append("[").append(std::to_string(step.index)).append("]");
    }
    return path;
}

}  // namespace raygraph::scene
