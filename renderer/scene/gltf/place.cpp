#include "renderer/scene/gltf/place.h"

#include "base/text.h"

namespace raygraph::scene {

std::string Place::Path() const {
    std::string path;
    for (uint32_t i = 0; i < m_count; ++i) {
        const Step& step = m_steps[i];
        if (step.name)
            path += Text("{}{}", path.empty() ? "" : ".", step.name);
        else
            path += Text("[{}]", step.index);
    }
    return path;
}

}  // namespace raygraph::scene
