#include "editor/session/explain/path_names.h"

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::session {

namespace {

std::string NameOf(const std::vector<std::string>& names, uint32_t index, const char* kind) {
    if (index < names.size() && !names[index].empty()) return Quoted(names[index]);
    return index == gpu::kNoRecord ? Text("no {}", kind) : Text("{} {}", kind, index);
}

}  // namespace

std::string NameOfUnnamed(const scene::Light& light, size_t index) {
    return Text("{} light {}", Name(light.type), index);
}

PathNames::PathNames(const scene::SceneData& scene) {
    for (const scene::Instance& instance : scene.instances) {
        const std::string node = instance.node < scene.nodes.size() ? scene.nodes[instance.node].name : "";
        m_instances.push_back(node.empty() ? scene.meshes[instance.mesh].name : node);
    }
    for (const scene::Material& material : scene.materials) m_materials.push_back(material.name);
    for (size_t i = 0; i < scene.lights.size(); ++i) {
        const scene::Light& light = scene.lights[i];
        const std::string name = light.name.empty() ? NameOfUnnamed(light, i) : "lamp " + Quoted(light.name);
        (light.type == scene::LightType::Directional ? m_directional : m_bounded).push_back(name);
    }
}

std::string PathNames::Instance(uint32_t instance) const {
    return NameOf(m_instances, instance, "instance");
}

std::string PathNames::Material(uint32_t material) const {
    return NameOf(m_materials, material, "material");
}

std::string PathNames::Emitter(uint32_t instance, uint32_t material) const {
    return Text("{} of {}", Material(material), Instance(instance));
}

std::string PathNames::Light(const gpu::LightCandidateRecord& candidate) const {
    const uint32_t firstBounded = m_lights.boundedCount - static_cast<uint32_t>(m_bounded.size());
    switch (static_cast<PathLight>(candidate.kind)) {
        case PathLight::Surface:
            return "lamp " + Emitter(candidate.instance, candidate.material);
        case PathLight::Environment:
            return "environment";
        case PathLight::Punctual:
            if (const size_t i = size_t{candidate.light} - m_lights.boundedCount; i < m_directional.size())
                return m_directional[i];
            if (const size_t i = size_t{candidate.light} - firstBounded; i < m_bounded.size())
                return m_bounded[i];
            return Text("light {}", candidate.light);
        case PathLight::None:
            break;
    }
    return "no light";
}

std::string PathNames::Emitter(const gpu::PathVertexRecord& vertex) const {
    if (static_cast<PathEvent>(vertex.event) == PathEvent::Environment) return "environment";
    return (vertex.light == gpu::kNoLight ? "glow of " : "lamp ") + Emitter(vertex.instance, vertex.material);
}

}  // namespace raygraph::session
