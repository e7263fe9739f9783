#include "editor/app/document.h"

#include <cmath>
#include <utility>

#include "base/overloaded.h"
#include "base/text.h"
#include "editor/session/content_hash.h"
#include "renderer/scene/check.h"
#include "renderer/scene/load_gltf.h"
#include "renderer/scene/save_gltf.h"
#include "renderer/scene/still_scene.h"
#include "renderer/scene/variants.h"

namespace raygraph::editor {

namespace {

constexpr size_t kNeverSaved = ~size_t{0};
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
    outline.profiles = data.profiles;
    outline.environment = {data.environment.name, data.environment.faceSize, {}};
    outline.bounds = data.bounds;
    outline.warnings = data.warnings;
    outline.variants = data.variants;
    outline.variant = data.variant;
    for (const scene::Mesh& mesh : data.meshes) {
        scene::Mesh& kept = outline.meshes.emplace_back(scene::Mesh{.name = mesh.name, .primitives = {}});
        for (const scene::Primitive& primitive : mesh.primitives) {
            kept.primitives.emplace_back();
            kept.primitives.back().material = primitive.material;
            kept.primitives.back().bounds = primitive.bounds;
            kept.primitives.back().variants = primitive.variants;
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
            [&](const VisibilityEdit& e) { return e.node == std::get<VisibilityEdit>(b).node; },
            [&](const MaterialEdit& e) { return e.material == std::get<MaterialEdit>(b).material; },
            [&](const LightEdit& e) { return e.light == std::get<LightEdit>(b).light; },
        },
        a);
}

}  // namespace

std::optional<FileStamp> StampOf(const std::filesystem::path& file) {
    std::error_code error;
    const FileStamp stamp{std::filesystem::last_write_time(file, error),
                          std::filesystem::file_size(file, error)};
    return error ? std::nullopt : std::optional(stamp);
}

FileContent WithHash(FileContent content, const Log& log) {
    const auto isSame = [&] { return !content.file.empty() && StampOf(content.file) == content.stamp; };
    if (!isSame()) {
        content.hash.clear();
        return content;
    }
    if (!content.hash.empty()) return content;
    try {
        scene::SceneData scene =
            scene::LoadGltf(content.file, {.pointsAndLines = content.pointsAndLines, .log = log});
        scene::SetVariant(scene, content.variant);
        scene::FreezePose(scene, {});
        content.hash = session::HashOf(scene);
    } catch (const Error&) {
        return content;  // the picture is saved without
    }
    if (!isSame()) content.hash.clear();  // written while it was read
    return content;
}

Document::Document(std::filesystem::path file, const scene::SceneData& data,
                   const std::optional<FileStamp>& stamp, std::string hash)
    : m_file(std::move(file)),
      m_stamp(stamp),
      m_scene(OutlineOf(data)),
      m_statistics(scene::Statistics(data)) {
    if (!hash.empty()) m_hashes[m_scene.variant] = std::move(hash);
    m_children.resize(m_scene.nodes.size());
    for (const uint32_t node : m_scene.nodeOrder) {
        const uint32_t parent = m_scene.nodes[node].parent;
        (parent == scene::kNone ? m_roots : m_children[parent]).push_back(node);
    }
    m_placed.resize(m_scene.nodes.size());
    const auto place = [&](const auto& things, uint32_t Placed::*index) {
        for (uint32_t i = 0; i < things.size(); ++i)
            if (things[i].node != scene::kNone) m_placed[things[i].node].*index = i;
    };
    for (uint32_t i = 0; i < m_scene.instances.size(); ++i) {
        if (m_scene.instances[i].node == scene::kNone) continue;
        Placed& placed = m_placed[m_scene.instances[i].node];
        if (placed.instanceCount++ == 0) placed.firstInstance = i;
    }
    place(m_scene.lights, &Placed::light);
    place(m_scene.cameras, &Placed::camera);
    m_worldTransforms = scene::WorldTransforms(m_scene);
    m_isVisible = scene::VisibleNodes(m_scene);
    for (const scene::Mesh& mesh : m_scene.meshes) {
        scene::Bounds& bounds = m_meshBounds.emplace_back();
        for (const scene::Primitive& primitive : mesh.primitives) bounds.Extend(primitive.bounds);
    }
    for (uint32_t i = 0; i < m_scene.instances.size(); ++i) m_instanceBounds.push_back(InstanceBounds(i));
}

scene::Bounds Document::InstanceBounds(uint32_t instance) const {
    const scene::Instance& of = m_scene.instances[instance];
    return m_meshBounds[of.mesh].Transformed(of.objectToWorld);
}

std::vector<uint32_t> Document::Subtree(uint32_t node) const {
    std::vector<uint32_t> nodes{node};
    for (size_t i = 0; i < nodes.size(); ++i)
        for (const uint32_t child : m_children[nodes[i]]) nodes.push_back(child);
    return nodes;
}

std::vector<uint32_t> Document::InstancesUnder(uint32_t node) const {
    std::vector<uint32_t> instances;
    for (const uint32_t below : Subtree(node))
        for (uint32_t i = m_placed[below].firstInstance; i < m_placed[below].InstanceEnd(); ++i)
            instances.push_back(i);
    return instances;
}

scene::PlacedTransform Document::ParentPlace(uint32_t node) const {
    const uint32_t parent = m_scene.nodes.at(node).parent;
    return parent == scene::kNone ? scene::PlacedTransform{} : m_worldTransforms[parent];
}

glm::mat4x3 Document::ParentTransform(uint32_t node) const {
    return ParentPlace(node).matrix;
}

scene::Bounds Document::BoundsOf(uint32_t node) const {
    scene::Bounds bounds;
    for (const uint32_t instance : InstancesUnder(node)) bounds.Extend(m_instanceBounds[instance]);
    return bounds;
}

Edit Document::Current(const Edit& of) const {
    return std::visit(Overloaded{
                          [&](const TransformEdit& e) -> Edit {
                              const scene::Node& node = m_scene.nodes.at(e.node);
                              return TransformEdit{e.node, node.LocalTransform(), node.translationRest};
                          },
                          [&](const VisibilityEdit& e) -> Edit {
                              return VisibilityEdit{e.node, m_scene.nodes.at(e.node).isVisible};
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
    if (edit.node >= m_scene.nodes.size())
        throw MakeError(ErrorKind::Usage, "there is no node {}", edit.node);
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row)
            if (!(std::abs(edit.local[column][row]) < kLargest))
                throw Error(ErrorKind::Usage, "a node's transform has to be made of finite numbers");
    const scene::Node& edited = m_scene.nodes[edit.node];
    const bool isTurned = edit.rest == glm::vec3(0.0f) && edit.local[3] == edited.LocalTransform()[3];
    const glm::vec3 rest = isTurned ? edited.translationRest : edit.rest;  // its place stays
    const std::vector<uint32_t> moved = Subtree(edit.node);
    std::vector<scene::PlacedTransform> before;
    for (const uint32_t node : moved) before.push_back(m_worldTransforms[node]);
    // Only what lies below the node moves
    const auto place = [&](uint32_t node, const scene::PlacedTransform& nodeToWorld) {
        const Placed& placed = m_placed[node];
        for (uint32_t i = placed.firstInstance; i < placed.InstanceEnd(); ++i)
            scene::CheckTransform(scene::PlaceInstance(nodeToWorld, m_scene.instances[i]),
                                  Text("node {}", node));
        m_worldTransforms[node] = nodeToWorld;
        const uint32_t light = m_placed[node].light;
        if (light == scene::kNone) return;
        scene::Light values = m_scene.lights[light];
        values.lightToWorld = nodeToWorld.matrix;
        values.translationRest = nodeToWorld.rest;
        gpu.SetLight(light, values);  // may be refused
        m_scene.lights[light] = values;
    };
    const auto local = [&](uint32_t node) -> scene::PlacedTransform {
        if (node == edit.node) return {edit.local, rest};
        return {m_scene.nodes[node].LocalTransform(), m_scene.nodes[node].translationRest};
    };
    size_t done = 0;
    try {
        for (; done < moved.size(); ++done)
            place(moved[done], scene::Compose(ParentPlace(moved[done]), local(moved[done])));
    } catch (const Error&) {
        m_worldTransforms[moved[done]] = before[done];
        while (done-- > 0) place(moved[done], before[done]);
        throw;
    }
    m_scene.nodes[edit.node].matrix = edit.local;
    m_scene.nodes[edit.node].translationRest = rest;
    for (const uint32_t node : moved) {
        const Placed& placed = m_placed[node];
        const scene::PlacedTransform& nodeToWorld = m_worldTransforms[node];
        if (placed.camera != scene::kNone) {
            m_scene.cameras[placed.camera].cameraToWorld = nodeToWorld.matrix;
            m_scene.cameras[placed.camera].translationRest = nodeToWorld.rest;
        }
        for (uint32_t i = placed.firstInstance; i < placed.InstanceEnd(); ++i) {
            const scene::PlacedTransform instance = scene::PlaceInstance(nodeToWorld, m_scene.instances[i]);
            m_scene.instances[i].objectToWorld = instance.matrix;
            m_scene.instances[i].translationRest = instance.rest;
            m_instanceBounds[i] = InstanceBounds(i);
            gpu.SetTransform(i, instance);
        }
    }
    UpdateBounds();
}

void Document::UpdateBounds() {
    m_scene.bounds = {};
    for (size_t i = 0; i < m_instanceBounds.size(); ++i) {
        if (scene::IsVisible(m_isVisible, m_scene.instances[i])) m_scene.bounds.Extend(m_instanceBounds[i]);
    }
}

void Document::PutVisibility(const VisibilityEdit& edit, GpuScene& gpu) {
    m_scene.nodes.at(edit.node).isVisible = edit.isVisible;
    m_isVisible = scene::VisibleNodes(m_scene);
    for (const uint32_t node : Subtree(edit.node)) {
        const Placed& placed = m_placed[node];
        for (uint32_t i = placed.firstInstance; i < placed.InstanceEnd(); ++i)
            gpu.SetVisible(i, m_isVisible[node]);
        if (placed.light != scene::kNone) gpu.SetLightVisible(placed.light, m_isVisible[node]);
    }
    UpdateBounds();
}

void Document::Put(const Edit& edit, GpuScene& gpu) {
    ++m_changes;
    std::visit(Overloaded{
                   [&](const TransformEdit& e) { PutTransform(e, gpu); },
                   [&](const VisibilityEdit& e) { PutVisibility(e, gpu); },
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
    if (m_saved > m_done) m_saved = kNeverSaved;  // those steps are forgotten
    m_steps.resize(m_done);
    if (m_isOpen && m_done > 0 && IsSameTarget(m_steps.back().after, edit)) {
        m_steps.back().after = edit;
    } else {
        m_steps.push_back({before, edit});
        ++m_done;
    }
    m_isOpen = true;
}

void Document::Save(const std::filesystem::path& to) {
    if (m_file.empty()) throw Error(ErrorKind::Usage, "no scene is open");
    if (m_stamp && StampOf(m_file) != m_stamp)
        throw MakeError(ErrorKind::BadInput, "{}: has changed since it was opened; not saved",
                        m_file.string());
    scene::SaveGltf(m_file, m_scene, to);
    if (IsEdited()) m_hashes.clear();
    m_isOpen = false;
    m_file = to;
    m_stamp = StampOf(to);
    m_saved = m_done;
}

std::filesystem::path Document::SaveBeside() const {
    const std::string name = m_file.stem().string() + "-recovered", extension = m_file.extension().string();
    const auto isThere = [](const std::filesystem::path& file) {
        std::error_code unknown;
        return std::filesystem::exists(std::filesystem::symlink_status(file, unknown));
    };
    std::filesystem::path to = m_file;
    to.replace_filename(name + extension);
    for (int number = 2; isThere(to); ++number) to.replace_filename(Text("{}-{}{}", name, number, extension));
    scene::SaveGltf(m_file, m_scene, to);
    return to;
}

FileContent Document::Content() const {
    if (m_file.empty() || IsEdited()) return {};
    const auto known = m_hashes.find(m_scene.variant);
    return {m_file, m_stamp, m_scene.variant, known == m_hashes.end() ? "" : known->second};
}

void Document::Know(const FileContent& content) {
    if (!content.hash.empty() && content.file == m_file && content.stamp == m_stamp)
        m_hashes[content.variant] = content.hash;
}

void Document::ShowVariant(uint32_t variant, GpuScene& gpu) {
    gpu.SetVariant(variant);  // may be refused
    scene::SetVariant(m_scene, variant);
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
