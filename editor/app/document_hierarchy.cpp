// Edits of the hierarchy. A node is never erased: indices of nodes, instances and lights stay valid, on the
// device, too, where what has been removed is hidden. What is added gets the next indices.
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "base/text.h"
#include "editor/app/document.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/transforms.h"

namespace raygraph::editor {

namespace {

// FreeNames makes names such as "Cube.001", with the first number that no node has.
class FreeNames {
  public:
    explicit FreeNames(const scene::SceneData& scene) {
        for (const scene::Node& node : scene.nodes) m_taken.insert(node.name);
    }

    // Returns the name itself if no node has it.
    std::string This(const std::string& name) { return m_taken.insert(name).second ? name : Next(name); }
    std::string Next(std::string name) {
        constexpr size_t kDigits = 3;
        const size_t dot = name.rfind('.');
        if (dot != std::string::npos && name.size() - dot - 1 == kDigits &&
            std::all_of(name.end() - kDigits, name.end(), [](char c) { return c >= '0' && c <= '9'; }))
            name.resize(dot);
        std::string free;
        do free = Text("{}.{:03}", name, ++m_last[name]);
        while (!m_taken.insert(free).second);
        return free;
    }

  private:
    std::set<std::string> m_taken;
    std::map<std::string, uint32_t> m_last;
};

bool IsOfNode(scene::AnimatedProperty property) {
    using Property = scene::AnimatedProperty;
    return property == Property::Translation || property == Property::Rotation ||
           property == Property::Scale || property == Property::Weights || property == Property::Visibility;
}

}  // namespace

std::string Document::NameOf(uint32_t node) const {
    const scene::Node& of = m_scene.nodes.at(node);
    if (!of.name.empty()) return of.name;
    if (of.mesh != scene::kNone && !m_scene.meshes[of.mesh].name.empty()) return m_scene.meshes[of.mesh].name;
    return Text("node {}", node);
}

std::vector<uint32_t> Document::Tops(std::span<const uint32_t> nodes) const {
    std::vector<bool> isTaken(m_scene.nodes.size(), false), isBelow(m_scene.nodes.size(), false);
    for (const uint32_t node : nodes) isTaken.at(node) = true;
    std::vector<uint32_t> tops;
    for (const uint32_t node : m_scene.nodeOrder) {
        const uint32_t parent = m_scene.nodes[node].parent;
        isBelow[node] = parent != scene::kNone && (isTaken[parent] || isBelow[parent]);
        if (isTaken[node] && !isBelow[node]) tops.push_back(node);
    }
    return tops;
}

void Document::UpdateOrder() {
    const auto listPresent = [&](const std::vector<uint32_t>& all, std::vector<uint32_t>& present) {
        present.clear();
        std::ranges::copy_if(all, std::back_inserter(present), [&](uint32_t i) { return !m_isRemoved[i]; });
    };
    listPresent(m_allRoots, m_roots);
    m_children.resize(m_allChildren.size());
    for (size_t i = 0; i < m_allChildren.size(); ++i) listPresent(m_allChildren[i], m_children[i]);
    m_isPlaced.assign(m_scene.nodes.size(), false);
    std::vector<uint32_t>& order = m_scene.nodeOrder;
    order.clear();
    std::vector<uint32_t> stack(m_roots.rbegin(), m_roots.rend());
    while (!stack.empty()) {
        const uint32_t node = stack.back();
        stack.pop_back();
        order.push_back(node);
        m_isPlaced[node] = true;
        stack.insert(stack.end(), m_children[node].rbegin(), m_children[node].rend());
    }
    if (!m_scene.animations.empty()) m_rest.nodeOrder = order;
}

// --- Adding ---

uint32_t Document::AddNode(scene::Node node, uint32_t copied) {
    const auto index = static_cast<uint32_t>(m_scene.nodes.size());
    SiblingsOf(node.parent).push_back(index);
    if (!m_scene.animations.empty()) m_rest.nodes.push_back(node);
    m_scene.nodes.push_back(std::move(node));
    m_allChildren.emplace_back();
    m_isRemoved.push_back(false);
    m_isNodeAnimated.push_back(false);
    m_placed.emplace_back();
    m_copiedFrom.push_back(copied);
    return index;
}

void Document::CopyObjects(uint32_t original, uint32_t copy) {
    const Placed from = m_placed[original];
    Placed& to = m_placed[copy];
    const auto rename = [&](std::string& name) {
        if (name == m_scene.nodes[original].name) name = m_scene.nodes[copy].name;
    };
    const auto copyOf = [&](auto things, uint32_t index) {
        auto thing = (Rest().*things)[index];
        thing.node = copy;
        rename(thing.name);
        if (!m_scene.animations.empty()) (m_rest.*things).push_back(thing);
        (m_scene.*things).push_back(std::move(thing));
        return static_cast<uint32_t>((m_scene.*things).size() - 1);
    };
    to.firstInstance = static_cast<uint32_t>(m_scene.instances.size());
    to.instanceCount = from.instanceCount;
    for (uint32_t i = from.firstInstance; i < from.InstanceEnd(); ++i) {
        scene::Instance instance = m_scene.instances[i];
        instance.node = copy;
        m_scene.instances.push_back(instance);
    }
    for (uint32_t i = 0, end = static_cast<uint32_t>(m_scene.lights.size()); i < end; ++i)
        if (m_scene.lights[i].node == original) to.light = copyOf(&scene::SceneData::lights, i);
    if (from.camera != scene::kNone) to.camera = copyOf(&scene::SceneData::cameras, from.camera);
}

template <typename Nodes>
std::vector<uint32_t> Document::AddNodes(Nodes&& add, GpuScene& gpu) {
    const size_t nodes = m_scene.nodes.size(), instances = m_scene.instances.size(),
                 lights = m_scene.lights.size(), cameras = m_scene.cameras.size(),
                 copies = m_copiedFrom.size();
    const std::vector<uint32_t> tops = add();
    for (const uint32_t top : tops) m_isRemoved[top] = true;
    m_applier.Refresh(m_scene);
    try {
        gpu.Extend(m_scene);
    } catch (...) {
        for (scene::SceneData* const scene : {&m_scene, &m_rest}) {
            if (scene == &m_rest && m_scene.animations.empty()) continue;
            scene->nodes.resize(nodes);
            scene->lights.resize(lights);
            scene->cameras.resize(cameras);
        }
        m_scene.instances.resize(instances);
        const auto isNew = [&](uint32_t node) { return node >= nodes; };
        std::erase_if(m_allRoots, isNew);
        m_allChildren.resize(nodes);
        for (std::vector<uint32_t>& children : m_allChildren) std::erase_if(children, isNew);
        m_isRemoved.resize(nodes);
        m_isNodeAnimated.resize(nodes);
        m_placed.resize(nodes);
        m_copiedFrom.resize(copies);
        m_applier.Refresh(m_scene);
        throw;
    }
    std::vector<Edit> edits;
    for (const uint32_t top : tops) edits.push_back(PresenceEdit{top, true});
    Settle();
    Apply(edits, gpu);
    Settle();
    return tops;
}

std::vector<uint32_t> Document::Duplicate(std::span<const uint32_t> nodes, GpuScene& gpu) {
    const std::vector<uint32_t> originals = Tops(nodes);
    for (const uint32_t original : originals)
        for (const uint32_t instance : InstancesUnder(original))
            if (m_scene.instances[instance].isDeformed)
                throw MakeError(ErrorKind::Usage,
                                "'{}' is deformed by a skin or morph targets: it cannot be duplicated here",
                                NameOf(m_scene.instances[instance].node));
    return AddNodes(
        [&] {
            FreeNames names(m_scene);
            std::vector<uint32_t> tops;
            for (const uint32_t original : originals) {
                std::map<uint32_t, uint32_t> copies;
                for (const uint32_t source : Subtree(original)) {
                    scene::Node node = Rest().nodes[source];
                    node.name = names.Next(NameOf(source));
                    if (source != original) node.parent = copies.at(node.parent);
                    copies[source] = AddNode(std::move(node), source);
                    CopyObjects(source, copies[source]);
                }
                tops.push_back(copies.at(original));
                std::vector<uint32_t>& siblings = SiblingsOf(m_scene.nodes[original].parent);
                siblings.pop_back();
                siblings.insert(std::ranges::find(siblings, original) + 1, tops.back());
            }
            return tops;
        },
        gpu);
}

uint32_t Document::Add(scene::Node node, std::optional<scene::Light> light,
                       std::optional<scene::Camera> camera, GpuScene& gpu) {
    const auto place = [&](auto& object, auto things) {
        object->node = static_cast<uint32_t>(m_scene.nodes.size() - 1);
        object->name = m_scene.nodes.back().name;
        if (!m_scene.animations.empty()) (m_rest.*things).push_back(*object);
        (m_scene.*things).push_back(*object);
        return static_cast<uint32_t>((m_scene.*things).size() - 1);
    };
    const std::vector<uint32_t> added = AddNodes(
        [&] {
            node.name = FreeNames(m_scene).This(node.name);
            const uint32_t index = AddNode(std::move(node), scene::kNone);
            if (light) m_placed[index].light = place(light, &scene::SceneData::lights);
            if (camera) m_placed[index].camera = place(camera, &scene::SceneData::cameras);
            return std::vector{index};
        },
        gpu);
    return added.front();
}

// --- Removing and moving ---

Document::Removed Document::Remove(std::span<const uint32_t> nodes, GpuScene& gpu) {
    std::vector<bool> isRemoved(m_scene.nodes.size(), false);
    std::vector<Edit> edits;
    Removed removed;
    for (const uint32_t top : Tops(nodes)) {
        edits.push_back(PresenceEdit{top, false});
        for (const uint32_t node : Subtree(top)) isRemoved[node] = true;
    }
    // Nodes of other scenes of the file stay, too
    const auto stays = [&](uint32_t node) {
        for (; node != scene::kNone; node = m_scene.nodes[node].parent)
            if (isRemoved[node] || m_isRemoved[node]) return false;
        return true;
    };
    removed.nodes = static_cast<size_t>(std::ranges::count(isRemoved, true));
    for (uint32_t node = 0; node < m_scene.nodes.size(); ++node) {
        if (m_scene.nodes[node].skin == scene::kNone || !stays(node)) continue;
        for (const uint32_t joint : m_scene.skins[m_scene.nodes[node].skin].joints)
            if (isRemoved[joint])
                throw MakeError(ErrorKind::Usage, "'{}' is a joint of the skin of '{}', which {}",
                                NameOf(joint), NameOf(node),
                                IsPresent(node) ? "would stay" : "is in another scene of the file");
    }
    for (const scene::Animation& animation : m_scene.animations)
        for (const auto& [sampler, target] : animation.channels)
            if (IsOfNode(target.property) && isRemoved[target.object]) ++removed.channels;
    Settle();
    Apply(edits, gpu);
    Settle();
    return removed;
}

std::vector<size_t> Document::OtherScenesWith(uint32_t node) const {
    while (m_scene.nodes[node].parent != scene::kNone) node = m_scene.nodes[node].parent;
    std::vector<size_t> scenes;
    for (size_t i = 0; i < m_scene.otherScenes.size(); ++i)
        if (std::ranges::count(m_scene.otherScenes[i], node) > 0) scenes.push_back(i);
    return scenes;
}

void Document::Reparent(std::span<const uint32_t> nodes, uint32_t parent, uint32_t before, GpuScene& gpu) {
    const auto transforms = m_applier.NodeTransforms();
    const scene::PlacedTransform above =
        parent == scene::kNone ? scene::PlacedTransform() : transforms[parent];
    if (!scene::CanInvert(above.matrix))
        throw MakeError(ErrorKind::Usage, "'{}' is scaled to nothing: nothing can be put below it",
                        NameOf(parent));
    const glm::dmat3 toParent = glm::inverse(glm::dmat3(above.matrix));
    const std::vector<size_t> scenes =
        parent == scene::kNone ? std::vector<size_t>() : OtherScenesWith(parent);
    std::vector<Edit> edits;
    for (const uint32_t node : Tops(nodes)) {
        for (uint32_t other = parent; other != scene::kNone; other = m_scene.nodes[other].parent)
            if (other == node)
                throw MakeError(ErrorKind::Usage, "'{}' cannot be put below {}", NameOf(node),
                                node == parent ? "itself" : Text("'{}', which is below it", NameOf(parent)));
        if (node == before) continue;
        edits.push_back(ParentEdit{node, parent, before});
        if (m_scene.nodes[node].parent == parent) continue;
        if (!std::ranges::includes(scenes, OtherScenesWith(node)))
            throw MakeError(ErrorKind::Usage,
                            "'{}' is in another scene of the file, too, which would lose it", NameOf(node));
        const glm::mat3 linear(toParent * glm::dmat3(transforms[node].matrix));
        const scene::FloatPair place =
            scene::ToFloatPair(toParent * (transforms[node].Place() - above.Place()));
        edits.push_back(TransformEdit{node, {linear[0], linear[1], linear[2], place.rounded}, place.rest});
    }
    if (edits.empty()) return;
    Settle();
    Apply(edits, gpu);
    Settle();
}

}  // namespace raygraph::editor
