#include "editor/app/document.h"

#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/overloaded.h"

namespace raygraph::editor {

namespace {

constexpr float kLargest = 1e18f;  // of a transform's numbers: their products stay finite

scene::SceneData OutlineOf(const scene::SceneData& data) {
    scene::SceneData outline;
    outline.name = data.name;
    outline.materials = data.materials;
    outline.textures = data.textures;
    outline.nodes = data.nodes;
    outline.nodeOrder = data.nodeOrder;
    outline.instances = data.instances;
    outline.cameras = data.cameras;
    outline.lights = data.lights;
    outline.bounds = data.bounds;
    outline.warnings = data.warnings;
    for (const scene::Mesh& mesh : data.meshes) {
        scene::Mesh& kept = outline.meshes.emplace_back(scene::Mesh{.name = mesh.name, .primitives = {}});
        for (const scene::Primitive& primitive : mesh.primitives) {
            kept.primitives.emplace_back();
            kept.primitives.back().material = primitive.material;
            kept.primitives.back().bounds = primitive.bounds;
        }
    }
    return outline;
}

// Whether two edits are of one thing.
bool IsSameTarget(const Edit& a, const Edit& b) {
    if (a.index() != b.index()) return false;
    return std::visit(
        Overloaded{
            [&](const TransformEdit& e) { return e.node == std::get<TransformEdit>(b).node; },
            [&](const MaterialEdit& e) { return e.material == std::get<MaterialEdit>(b).material; },
            [&](const LightEdit& e) { return e.light == std::get<LightEdit>(b).light; },
        },
        a);
}

}  // namespace

Document::Document(std::filesystem::path file, const scene::SceneData& data)
    : m_file(std::move(file)), m_scene(OutlineOf(data)), m_statistics(scene::Statistics(data)) {
    m_children.resize(m_scene.nodes.size());
    for (const uint32_t node : m_scene.nodeOrder) {
        const uint32_t parent = m_scene.nodes[node].parent;
        (parent == scene::kNone ? m_roots : m_children[parent]).push_back(node);
    }
}

bool Document::IsUnder(uint32_t node, uint32_t ancestor) const {
    for (; node != scene::kNone; node = m_scene.nodes[node].parent)
        if (node == ancestor) return true;
    return false;
}

scene::Bounds Document::BoundsOf(uint32_t node) const {
    scene::Bounds bounds;
    for (const scene::Instance& instance : m_scene.instances) {
        if (!IsUnder(instance.node, node)) continue;
        for (const scene::Primitive& primitive : m_scene.meshes[instance.mesh].primitives)
            bounds.Extend(primitive.bounds.Transformed(instance.objectToWorld));
    }
    return bounds;
}

Edit Document::Current(const Edit& of) const {
    return std::visit(Overloaded{
                          [&](const TransformEdit& e) -> Edit {
                              return TransformEdit{e.node, m_scene.nodes.at(e.node).LocalTransform()};
                          },
                          [&](const MaterialEdit& e) -> Edit {
                              return MaterialEdit{e.material, m_scene.materials.at(e.material)};
                          },
                          [&](const LightEdit& e) -> Edit {
                              return LightEdit{e.light, m_scene.lights.at(e.light)};
                          },
                      },
                      of);
}

void Document::PutTransform(const TransformEdit& edit, GpuScene& gpu) {
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 3; row++)
            if (!(std::abs(edit.local[column][row]) < kLargest))
                throw Error(ErrorKind::Usage, "a node's transform has to be made of finite numbers");
    scene::Node& node = m_scene.nodes.at(edit.node);
    const std::optional<glm::mat4x3> before = std::exchange(node.matrix, edit.local);
    const std::vector<scene::Instance> instances = m_scene.instances;
    const std::vector<scene::Light> lights = m_scene.lights;
    scene::UpdateWorldTransforms(m_scene);
    try {
        for (uint32_t i = 0; i < lights.size(); i++)  // these may be refused
            if (!(lights[i] == m_scene.lights[i])) gpu.SetLight(i, m_scene.lights[i]);
    } catch (const Error&) {
        node.matrix = before;
        scene::UpdateWorldTransforms(m_scene);
        for (uint32_t i = 0; i < lights.size(); i++)
            if (!(lights[i] == gpu.Light(i))) gpu.SetLight(i, lights[i]);
        throw;
    }
    for (uint32_t i = 0; i < instances.size(); i++)
        if (instances[i].objectToWorld != m_scene.instances[i].objectToWorld)
            gpu.SetTransform(i, m_scene.instances[i].objectToWorld);
}

void Document::Put(const Edit& edit, GpuScene& gpu) {
    std::visit(Overloaded{
                   [&](const TransformEdit& e) { PutTransform(e, gpu); },
                   [&](const MaterialEdit& e) {
                       gpu.SetMaterial(e.material, e.values);
                       m_scene.materials.at(e.material) = e.values;
                   },
                   [&](const LightEdit& e) {
                       gpu.SetLight(e.light, e.values);
                       m_scene.lights.at(e.light) = e.values;
                   },
               },
               edit);
}

void Document::Apply(const Edit& edit, GpuScene& gpu) {
    const Edit before = Current(edit);
    Put(edit, gpu);
    m_steps.resize(m_done);
    if (m_isOpen && m_done > 0 && IsSameTarget(m_steps.back().after, edit)) {
        m_steps.back().after = edit;
    } else {
        m_steps.push_back({before, edit});
        m_done++;
    }
    m_isOpen = true;
}

void Document::Undo(GpuScene& gpu) {
    if (!CanUndo()) return;
    m_isOpen = false;
    Put(m_steps[--m_done].before, gpu);
}

void Document::Redo(GpuScene& gpu) {
    if (!CanRedo()) return;
    m_isOpen = false;
    Put(m_steps[m_done++].after, gpu);
}

}  // namespace raygraph::editor
