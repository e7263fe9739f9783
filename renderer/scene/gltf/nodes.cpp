#include "renderer/scene/gltf/nodes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/gltf/lights.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {
namespace {

// glTF stores matrices column by column; the last row must say that the matrix is affine.
glm::mat4x3 ReadMatrix(const GltfContext& context, const std::vector<double>& numbers, const Place& where) {
    constexpr float kTolerance = 1e-5f;
    glm::mat4x3 matrix;
    for (int column = 0; column < 4; ++column) {
        const double* const m = &numbers[static_cast<size_t>(4 * column)];
        for (int row = 0; row < 3; ++row) matrix[column][row] = static_cast<float>(m[row]);
        const float expected = column == 3 ? 1.0f : 0.0f;
        if (std::abs(static_cast<float>(m[3]) - expected) > kTolerance)
            context.Fail(where, "is not affine: its last row must be 0 0 0 1");
    }
    return matrix;
}

glm::dvec3 ToVector(const double* numbers) {
    return {numbers[0], numbers[1], numbers[2]};
}

class GraphReader {
  public:
    GraphReader(GltfContext& context, const gltf::Model& model, SceneData& scene)
        : m_context(context), m_model(model), m_scene(scene) {}

    void Read() {
        m_cameras = ReadCameras(m_context, m_model);
        m_lights = ReadLights(m_context, m_model);
        const size_t count = m_model.nodes.size();
        m_scene.nodes.resize(count);
        m_cameraOfNode.assign(count, kNone);
        m_lightOfNode.assign(count, kNone);
        m_profileOfNode.assign(count, kNone);
        for (size_t i = 0; i < count; ++i) ReadNode(static_cast<uint32_t>(i));
        CheckForest();
        m_scene.nodeOrder = Descendants(ChooseRoots());
        PlaceCameras();
        PlaceLights();
        PlaceProfiles();
    }

    const GraphIndices& Indices() const { return m_indices; }

  private:
    static Place NodeAt(size_t index) { return Place("nodes")[index]; }

    void ReadNode(uint32_t index) {
        const gltf::Node& file = m_model.nodes[index];
        Node& node = m_scene.nodes[index];
        node.name = file.name;
        if (!file.translation.empty()) {
            const FloatPair place = ToFloatPair(ToVector(file.translation.data()));
            node.translation = place.rounded;
            node.translationResidual = place.rest;
        }
        if (!file.matrix.empty()) {
            node.matrix = ReadMatrix(m_context, file.matrix, NodeAt(index)["matrix"]);
            node.translationResidual = ToFloatPair(ToVector(&file.matrix[12])).rest;
        }
        if (!file.rotation.empty()) node.rotation = ReadRotation(file.rotation, index);
        if (!file.scale.empty()) node.scale = ToVector(file.scale.data());
        // -1 is none, as in all of tinygltf's indices
        node.mesh = static_cast<uint32_t>(file.mesh);
        m_cameraOfNode[index] = static_cast<uint32_t>(file.camera);
        if (const auto light = file.extensions.find("KHR_lights_punctual"); light != file.extensions.end())
            m_lightOfNode[index] = static_cast<uint32_t>(light->second.Get("light").GetNumberAsInt());
        if (const auto light = file.extensions.find(kProfileExtension); light != file.extensions.end())
            m_profileOfNode[index] = static_cast<uint32_t>(light->second.Get("light").GetNumberAsInt());
        if (const auto own = file.extensions.find("KHR_node_visibility"); own != file.extensions.end())
            node.isVisible = !own->second.Has("visible") || own->second.Get("visible").Get<bool>();
        for (size_t i = 0; i < file.children.size(); ++i) {
            uint32_t& parent = m_scene.nodes[static_cast<size_t>(file.children[i])].parent;
            if (parent != kNone)
                m_context.Fail(NodeAt(index)["children"][i],
                               Text("nodes[{}] is already a child of nodes[{}]", file.children[i], parent));
            parent = index;
        }
    }

    glm::quat ReadRotation(const std::vector<double>& xyzw, uint32_t index) {
        const FloatPair imaginary = ToFloatPair(ToVector(xyzw.data())),
                        real = ToFloatPair(glm::dvec3(xyzw[3]));
        const glm::dquat q(real.rounded.x, glm::dvec3(imaginary.rounded));
        const double length = glm::length(q);
        if (!(length > 1e-6)) m_context.Fail(NodeAt(index)["rotation"], "is a quaternion of length 0");
        if (std::abs(length - 1.0) > 5e-3)
            m_context.Warn(NodeAt(index)["rotation"], "rotation", "is not of unit length, normalized");
        return glm::quat(q / length);
    }

    // With one parent each, a node is on or below a cycle exactly if no root leads to it.
    void CheckForest() {
        BuildChildLists();
        std::vector<bool> isReached(m_scene.nodes.size(), false);
        for (const uint32_t node : Descendants(RootNodes())) isReached[node] = true;
        for (size_t i = 0; i < isReached.size(); ++i)
            if (!isReached[i]) m_context.Fail(NodeAt(i), "is its own ancestor, or below a node that is");
    }

    // Sorts the children: those of node i are m_children[m_firstChild[i]] to m_children[m_firstChild[i + 1] -
    // 1], in the file's order.
    void BuildChildLists() {
        m_firstChild.assign(1, 0);
        for (const gltf::Node& node : m_model.nodes) {
            m_children.insert(m_children.end(), node.children.begin(), node.children.end());
            m_firstChild.push_back(m_children.size());
        }
    }

    std::vector<uint32_t> RootNodes() const {
        std::vector<uint32_t> roots;
        for (uint32_t i = 0; i < m_scene.nodes.size(); ++i)
            if (m_scene.nodes[i].parent == kNone) roots.push_back(i);
        return roots;
    }

    // Returns `roots` and all below them, depth first, parents before children. It is not recursive, since a
    // chain may be long.
    std::vector<uint32_t> Descendants(const std::vector<uint32_t>& roots) const {
        std::vector<uint32_t> order;
        std::vector<uint32_t> stack(roots.rbegin(), roots.rend());
        while (!stack.empty()) {
            const uint32_t node = stack.back();
            stack.pop_back();
            order.push_back(node);
            for (size_t i = m_firstChild[node + 1]; i > m_firstChild[node]; --i)
                stack.push_back(m_children[i - 1]);
        }
        return order;
    }

    // Returns the root nodes of the scene that was asked for.
    std::vector<uint32_t> ChooseRoots() {
        const std::vector<gltf::Scene>& scenes = m_model.scenes;
        std::vector<std::vector<uint32_t>> roots;
        for (size_t i = 0; i < scenes.size(); ++i) roots.push_back(ReadSceneRoots(i));
        const std::string& requested = m_context.options.scene;
        if (requested.empty() && roots.empty()) {
            if (!m_scene.nodes.empty()) m_context.Warn("", "no scenes", "has no scenes, all nodes are shown");
            return RootNodes();
        }
        const size_t chosen =
            requested.empty() ? static_cast<size_t>(std::max(m_model.defaultScene, 0)) : FindScene(requested);
        m_indices.scene = static_cast<uint32_t>(chosen);
        m_scene.name = scenes[chosen].name;
        std::vector<uint32_t> own = std::move(roots[chosen]);
        roots.erase(roots.begin() + static_cast<std::ptrdiff_t>(chosen));
        m_scene.otherScenes = std::move(roots);
        return own;
    }

    std::vector<uint32_t> ReadSceneRoots(size_t scene) const {
        const Place where = Place("scenes")[scene]["nodes"];
        const std::vector<int>& nodes = m_model.scenes[scene].nodes;
        std::vector<uint32_t> roots(nodes.begin(), nodes.end());
        for (size_t i = 0; i < roots.size(); ++i)
            if (const uint32_t parent = m_scene.nodes[roots[i]].parent; parent != kNone)
                m_context.Fail(where[i],
                               Text("nodes[{}] is a child of nodes[{}], must be a root", roots[i], parent));
        std::vector<uint32_t> sorted = roots;
        std::sort(sorted.begin(), sorted.end());
        const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
        if (twice != sorted.end()) m_context.Fail(where, Text("nodes[{}] is listed twice", *twice));
        return roots;
    }

    size_t FindScene(const std::string& requested) const {
        const std::vector<gltf::Scene>& scenes = m_model.scenes;
        std::string names;
        for (size_t i = 0; i < scenes.size(); ++i) {
            if (scenes[i].name == requested) return i;
            if (i < 8) names += Text("{}{} {}", i ? ", " : "", i, Quoted(scenes[i].name, 40));
            if (i == 8) names += ", ...";
        }
        uint32_t index = 0;
        const auto [end, error] =
            std::from_chars(requested.data(), requested.data() + requested.size(), index);
        if (error == std::errc() && end == requested.data() + requested.size() && index < scenes.size())
            return index;
        throw MakeError(ErrorKind::Usage, "{}: there is no scene {}; there are{}", m_context.label,
                        Quoted(requested), names.empty() ? " none" : ": " + names);
    }

    // Returns the loaded scene's nodes that have `thing`, by the thing's index, then by the order of nodes.
    std::vector<uint32_t> NodesWith(const std::vector<uint32_t>& objectOfNode) const {
        std::vector<uint32_t> nodes;
        for (const uint32_t node : m_scene.nodeOrder)
            if (objectOfNode[node] != kNone) nodes.push_back(node);
        std::stable_sort(nodes.begin(), nodes.end(),
                         [&](uint32_t a, uint32_t b) { return objectOfNode[a] < objectOfNode[b]; });
        return nodes;
    }

    void PlaceCameras() {
        for (const uint32_t node : NodesWith(m_cameraOfNode)) {
            Camera camera = m_cameras[m_cameraOfNode[node]];
            camera.node = node;
            if (camera.name.empty()) camera.name = m_scene.nodes[node].name;
            m_indices.cameras.push_back(m_cameraOfNode[node]);
            m_scene.cameras.push_back(std::move(camera));
        }
    }

    void PlaceLights() {
        for (const uint32_t node : NodesWith(m_lightOfNode)) {
            Light light = m_lights[m_lightOfNode[node]];
            light.node = node;
            m_indices.lights.push_back(m_lightOfNode[node]);
            if (light.name.empty()) light.name = m_scene.nodes[node].name;
            m_scene.lights.push_back(std::move(light));
        }
    }

    void PlaceProfiles() {
        std::vector<uint32_t>& profiles = m_indices.profiles;
        for (const uint32_t node : NodesWith(m_profileOfNode)) {
            const uint32_t profile = m_profileOfNode[node];
            if (profiles.empty() || profiles.back() != profile) profiles.push_back(profile);
            Light light = ReadProfileLight(m_model, node);
            light.node = node;
            light.profile = static_cast<uint32_t>(profiles.size() - 1);
            if (light.name.empty()) light.name = m_scene.nodes[node].name;
            m_scene.lights.push_back(std::move(light));
        }
    }

    GltfContext& m_context;
    const gltf::Model& m_model;
    SceneData& m_scene;
    GraphIndices m_indices;
    std::vector<Camera> m_cameras;
    std::vector<Light> m_lights;
    std::vector<uint32_t> m_cameraOfNode;
    std::vector<uint32_t> m_lightOfNode;
    std::vector<uint32_t> m_profileOfNode;
    std::vector<size_t> m_firstChild;
    std::vector<uint32_t> m_children;
};

// Nodes that may have an area at another time than now: their scale or rotation or that of a node above is
// animated, or a skin places them.
std::vector<bool> NodesThatMayGrow(const SceneData& scene) {
    std::vector<bool> mayGrow(scene.nodes.size(), false);
    for (const Animation& animation : scene.animations)
        for (const AnimationChannel& channel : animation.channels)
            if (channel.target.property == AnimatedProperty::Scale ||
                channel.target.property == AnimatedProperty::Rotation)
                mayGrow[channel.target.object] = true;
    for (const uint32_t index : scene.nodeOrder) {
        const Node& node = scene.nodes[index];
        mayGrow[index] =
            mayGrow[index] || node.skin != kNone || (node.parent != kNone && mayGrow[node.parent]);
    }
    return mayGrow;
}

// Returns false if nothing of the instance is visible, unless it may grow, as isCollapsed says before the
// call. Afterwards isCollapsed says whether nothing of it is visible now.
bool PlaceAt(const SceneData& scene, const PlacedTransform& placed, Instance& instance) {
    const bool mayGrow = instance.isCollapsed;
    const std::optional<PlacedTransform> shown = WithThickness(scene, instance, placed);
    instance.isCollapsed = !shown;
    if (!shown) return mayGrow;
    instance.objectToWorld = shown->matrix;
    instance.translationResidual = shown->rest;
    return true;
}

// Places the instances of one node: `one`, at each of the layout's transforms.
void PlaceInstancing(GltfContext& context, AccessorReader& reader, const InstancingLayout& layout,
                     Instance one, const PlacedTransform& nodeToWorld, SceneData& scene) {
    // Charges this memory for an instance, here and in GpuScene and its users.
    constexpr uint64_t kBytesPerInstance = 4 * sizeof(Instance);
    context.ChargeGeometry(layout.where, layout.count * kBytesPerInstance);
    const std::vector<glm::mat4x3> transforms = DecodeInstancing(context, reader, layout);
    for (size_t i = 0; i < transforms.size(); ++i) {
        one.objectToNode = transforms[i];
        const PlacedTransform placed = PlaceInstance(nodeToWorld, one);
        if (!IsFinite(placed.matrix))
            context.Fail(layout.where, Text("the world transform of instance {} is not finite", i));
        Instance instance = one;
        if (!PlaceAt(scene, placed, instance)) {
            context.Warn(layout.where, "singular instance",
                         Text("instance {} is scaled to nothing or to a line, left out", i));
            continue;
        }
        scene.instances.push_back(instance);
    }
}

}  // namespace

GraphIndices ReadNodes(GltfContext& context, const gltf::Model& model, SceneData& scene) {
    GraphReader reader(context, model, scene);
    reader.Read();
    return reader.Indices();
}

void PlaceInstances(GltfContext& context, AccessorReader& reader,
                    const std::vector<InstancingLayout>& instancing, SceneData& scene) {
    const std::vector<PlacedTransform> transforms = WorldTransforms(scene);
    const std::vector<bool> mayGrow = NodesThatMayGrow(scene);
    for (const uint32_t node : scene.nodeOrder) {
        const Place where = Place("nodes")[node];
        if (!IsFinite(transforms[node].matrix)) context.Fail(where, "its world transform is not finite");
        const uint32_t mesh = scene.nodes[node].mesh;
        if (mesh == kNone || scene.meshes[mesh].primitives.empty()) continue;
        Instance instance{.mesh = mesh, .node = node};
        instance.isCollapsed = mayGrow[node];
        if (instancing[node].count > 0) {
            PlaceInstancing(context, reader, instancing[node], instance, transforms[node], scene);
            continue;
        }
        if (!PlaceAt(scene, transforms[node], instance)) {
            context.Warn(where, "singular", "is scaled to nothing or to a line, its mesh is left out");
            continue;
        }
        scene.instances.push_back(instance);
    }
    UpdateWorldTransforms(scene);
    const bool isFinite =
        scene.bounds.IsEmpty() || (std::isfinite(glm::dot(scene.bounds.min, glm::vec3(1))) &&
                                   std::isfinite(glm::dot(scene.bounds.max, glm::vec3(1))));
    if (!isFinite) context.Fail("", "the scene's bounds are not finite");
}

// --- EXT_mesh_gpu_instancing ---

namespace {

constexpr const char* kInstancingExtension = "EXT_mesh_gpu_instancing";

bool IsVectorOfFloats(const Accessor& accessor) {
    return !accessor.isMatrix && accessor.componentCount == 3 &&
           accessor.componentType == ComponentType::Float;
}

bool IsQuaternion(const Accessor& accessor) {
    if (accessor.isMatrix || accessor.componentCount != 4) return false;
    if (accessor.componentType == ComponentType::Float) return true;
    return accessor.isNormalized &&
           (accessor.componentType == ComponentType::Int8 || accessor.componentType == ComponentType::Int16);
}

// Returns the layout of a node's instances, checked.
InstancingLayout ReadLayout(GltfContext& context, const gltf::Value& attributes, const AccessorTables& tables,
                            const Place& where) {
    InstancingLayout layout{.where = where};
    const char* first = nullptr;
    const auto read = [&](const char* name, auto isAllowed, const char* allowed) {
        if (!attributes.Has(name)) return kNone;
        const auto index = static_cast<uint32_t>(attributes.Get(name).GetNumberAsInt());
        const Accessor& accessor = tables.accessors[index];
        if (!isAllowed(accessor)) context.Fail(where[name], Text("accessors[{}] must be {}", index, allowed));
        if (first && accessor.count != layout.count)
            context.Fail(where[name], Text("accessors[{}] has {}, {} has {}", index,
                                           Counted(accessor.count, "element"), first, layout.count));
        if (!first) first = name;
        layout.count = accessor.count;
        return index;
    };
    constexpr const char* kVector = "VEC3 of float";
    layout.translation = read("TRANSLATION", IsVectorOfFloats, kVector);
    layout.rotation = read("ROTATION", IsQuaternion, "VEC4 of float, normalized byte or normalized short");
    layout.scale = read("SCALE", IsVectorOfFloats, kVector);
    return layout;
}

std::vector<glm::quat> ReadRotations(GltfContext& context, AccessorReader& reader,
                                     const InstancingLayout& layout) {
    const Place where = layout.where["ROTATION"];
    const std::vector<glm::vec4> elements =
        reader.ReadVectors<glm::vec4>(layout.rotation, {layout.count}, where);
    context.ChargeGeometry(where, layout.count * sizeof(glm::quat));
    std::vector<glm::quat> rotations;
    rotations.reserve(elements.size());
    for (size_t i = 0; i < elements.size(); ++i) {
        const glm::vec4& xyzw = elements[i];
        const glm::dquat q(double{xyzw.w}, double{xyzw.x}, double{xyzw.y}, double{xyzw.z});
        const double length = glm::length(q);
        if (!(length > 1e-6)) context.Fail(where, Text("element {} is a quaternion of length 0", i));
        constexpr double kRounding = 1e-2;  // of four bytes
        if (std::abs(length - 1.0) > kRounding)
            context.Warn(where, "rotation", "is not of unit length, normalized");
        rotations.emplace_back(q / length);
    }
    return rotations;
}

// A scale of 0 becomes so small a positive one that the matrix tells which side is the front, and nothing
// else.
glm::vec3 AwayFromZero(glm::vec3 scale) {
    for (int i = 0; i < 3; ++i)
        if (scale[i] == 0.0f) scale[i] = std::numeric_limits<float>::min();
    return scale;
}

}  // namespace

std::vector<InstancingLayout> ReadInstancing(GltfContext& context, const gltf::Model& model,
                                             const AccessorTables& tables) {
    std::vector<InstancingLayout> layouts(model.nodes.size());
    for (size_t i = 0; i < model.nodes.size(); ++i) {
        const gltf::Node& node = model.nodes[i];
        const auto found = node.extensions.find(kInstancingExtension);
        if (found == node.extensions.end()) continue;
        const Place where = Place("nodes")[i]["extensions"][kInstancingExtension];
        layouts[i] = ReadLayout(context, found->second.Get("attributes"), tables, where["attributes"]);
        if (node.mesh < 0)
            context.Warn(where, "instancing", "is of a node without a mesh, ignored");
        else if (layouts[i].count == 0)
            context.Warn(where, "instancing",
                         "has no TRANSLATION, ROTATION or SCALE, the mesh is shown once");
    }
    return layouts;
}

std::vector<glm::mat4x3> DecodeInstancing(GltfContext& context, AccessorReader& reader,
                                          const InstancingLayout& layout) {
    const auto vectors = [&](uint32_t accessor, const char* name) {
        if (accessor == kNone) return std::vector<glm::vec3>();
        return reader.ReadVectors<glm::vec3>(accessor, {layout.count}, layout.where[name]);
    };
    const std::vector<glm::vec3> translations = vectors(layout.translation, "TRANSLATION");
    const std::vector<glm::vec3> scales = vectors(layout.scale, "SCALE");
    std::vector<glm::quat> rotations;
    if (layout.rotation != kNone) rotations = ReadRotations(context, reader, layout);
    std::vector<glm::mat4x3> transforms;
    transforms.reserve(layout.count);
    Node parts;
    for (size_t i = 0; i < layout.count; ++i) {
        if (!translations.empty()) parts.translation = translations[i];
        if (!rotations.empty()) parts.rotation = rotations[i];
        if (!scales.empty()) parts.scale = AwayFromZero(scales[i]);
        transforms.push_back(parts.LocalTransform());
    }
    return transforms;
}

// --- The radii of points and lines ---

namespace {

bool IsSomeRound(const SceneData& scene) {
    return std::ranges::any_of(scene.meshes, [](const Mesh& mesh) {
        return std::ranges::any_of(mesh.primitives, [](const Primitive& p) { return p.IsRound(); });
    });
}

// Returns the largest scale at which each mesh is placed; 0: not at all.
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
float RequestedRadius(const RoundRadius& requested) {
    return requested.isRelative ? -requested.value : requested.value;
}

void SetRadii(GltfContext& context, SceneData& scene) {
    if (!IsSomeRound(scene)) return;
    const double diagonal = 2.0 * static_cast<double>(scene.bounds.Radius());
    const std::vector<double> scales = ScalesOf(scene);
    for (size_t m = 0; m < scene.meshes.size(); ++m)
        for (Primitive& primitive : scene.meshes[m].primitives) {
            if (!primitive.IsRound()) continue;
            const double requested = static_cast<double>(primitive.radii.front());
            if (requested < 0.0 && !(diagonal > 0.0))
                context.Fail(
                    Place("meshes")[m],
                    "all of the scene is one point, to which no radius is relative: give it in meters");
            const double inWorld = requested < 0.0 ? -requested * diagonal : requested;
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
