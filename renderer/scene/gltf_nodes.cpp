#include "renderer/scene/gltf_nodes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <string>

#include "base/error.h"
#include "base/printable.h"
#include "renderer/scene/check.h"

namespace raygraph::scene {
namespace {

// glTF stores matrices column by column; the last row must say that the matrix is affine.
glm::mat4x3 ReadMatrix(const JsonValue& value) {
    std::array<float, 16> m{};
    value.Floats(m);
    constexpr float kTolerance = 1e-5f;
    for (size_t column = 0; column < 4; ++column) {
        const float expected = column == 3 ? 1.0f : 0.0f;
        if (std::abs(m[4 * column + 3] - expected) > kTolerance)
            value.Fail("is not affine: its last row must be 0 0 0 1");
    }
    glm::mat4x3 matrix;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) matrix[column][row] = m[static_cast<size_t>(4 * column + row)];
    return matrix;
}

// What float leaves of three numbers of an array.
glm::vec3 RestOf(const JsonValue& value, size_t first) {
    glm::vec3 rest;
    for (int i = 0; i < 3; ++i) {
        const double number = value.At(first + static_cast<size_t>(i)).Number();
        rest[i] = static_cast<float>(number - static_cast<double>(static_cast<float>(number)));
    }
    return rest;
}

glm::quat ReadRotation(GltfContext& context, const JsonValue& value) {
    std::array<float, 4> xyzw{0, 0, 0, 1};
    value.FloatsIfPresent(xyzw);
    const glm::dquat q(xyzw[3], xyzw[0], xyzw[1], xyzw[2]);
    const double length = glm::length(q);
    if (!(length > 1e-6)) value.Fail("is a quaternion of length 0");
    if (std::abs(length - 1.0) > 5e-3) context.Warn(value, "rotation", "is not of unit length, normalized");
    return glm::quat(q / length);
}

class GraphReader {
  public:
    GraphReader(GltfContext& context, const JsonValue& root, size_t meshCount, SceneData& scene)
        : m_context(context), m_root(root), m_meshCount(meshCount), m_scene(scene) {}

    void Read() {
        m_cameras = ReadCameras(m_context, m_root);
        m_lights = ReadLights(m_root);
        const JsonValue nodes = m_root["nodes"];
        m_scene.nodes.resize(nodes.Count());
        m_cameraOfNode.assign(nodes.Count(), kNone);
        m_lightOfNode.assign(nodes.Count(), kNone);
        for (size_t i = 0; i < nodes.Count(); ++i) ReadNode(nodes.At(i), static_cast<uint32_t>(i));
        CheckForest();
        m_scene.nodeOrder = Descendants(ChooseRoots());
        PlaceCameras();
        PlaceLights();
    }

  private:
    void ReadNode(const JsonValue& value, uint32_t index) {
        Node& node = m_scene.nodes[index];
        node.name = value.RequireObject()["name"].StringOr("");
        value["translation"].FloatsIfPresent({&node.translation.x, 3});
        if (value["translation"].IsPresent()) node.translationRest = RestOf(value["translation"], 0);
        if (value["matrix"].IsPresent()) {
            node.matrix = ReadMatrix(value["matrix"]);
            node.translationRest = RestOf(value["matrix"], 12);
        }
        node.rotation = ReadRotation(m_context, value["rotation"]);
        value["scale"].FloatsIfPresent({&node.scale.x, 3});
        node.mesh = value["mesh"].IndexOr(kNone, m_meshCount, "meshes");
        m_cameraOfNode[index] = value["camera"].IndexOr(kNone, m_cameras.size(), "cameras");
        const JsonValue light = value["extensions"]["KHR_lights_punctual"]["light"];
        m_lightOfNode[index] = light.IndexOr(kNone, m_lights.size(), "lights");
        if (value["skin"].IsPresent())
            m_context.Warn(value["skin"], "skin", "skins are not read, the bind pose is shown");

        const JsonValue children = value["children"];
        for (size_t i = 0; i < children.Count(); ++i) {
            const uint32_t child = children.At(i).Index(m_scene.nodes.size(), "nodes");
            uint32_t& parent = m_scene.nodes[child].parent;
            if (parent != kNone)
                children.At(i).Fail("nodes[" + std::to_string(child) + "] is already a child of nodes[" +
                                    std::to_string(parent) + "]");
            parent = index;
        }
    }

    // With one parent each, a node is on or below a cycle exactly if no root leads to it.
    void CheckForest() {
        BuildChildLists();
        std::vector<bool> isReached(m_scene.nodes.size(), false);
        for (const uint32_t node : Descendants(RootNodes())) isReached[node] = true;
        for (size_t i = 0; i < isReached.size(); ++i)
            if (!isReached[i]) m_root["nodes"].At(i).Fail("is its own ancestor, or below a node that is");
    }

    // Children of node i: m_children[m_firstChild[i]] to m_children[m_firstChild[i + 1] - 1], in the file's
    // order.
    void BuildChildLists() {
        const JsonValue nodes = m_root["nodes"];
        m_firstChild.assign(1, 0);
        for (size_t i = 0; i < m_scene.nodes.size(); ++i) {
            const JsonValue children = nodes.At(i)["children"];
            for (size_t k = 0; k < children.Count(); ++k)
                m_children.push_back(static_cast<uint32_t>(children.At(k).Unsigned()));
            m_firstChild.push_back(m_children.size());
        }
    }

    std::vector<uint32_t> RootNodes() const {
        std::vector<uint32_t> roots;
        for (uint32_t i = 0; i < m_scene.nodes.size(); ++i)
            if (m_scene.nodes[i].parent == kNone) roots.push_back(i);
        return roots;
    }

    // `roots` and all below them, depth first, parents before children. Not recursive: a chain may be long.
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

    // The root nodes of the scene that was asked for.
    std::vector<uint32_t> ChooseRoots() {
        const JsonValue scenes = m_root["scenes"];
        std::vector<std::vector<uint32_t>> roots;
        for (size_t i = 0; i < scenes.Count(); ++i) roots.push_back(ReadSceneRoots(scenes.At(i)));
        const uint32_t defaultScene = m_root["scene"].IndexOr(0, scenes.Count(), "scenes");
        const std::string& asked = m_context.options.scene;
        if (asked.empty() && roots.empty()) {
            if (!m_scene.nodes.empty())
                m_context.Warn(m_root, "no scenes", "has no scenes, all nodes are shown");
            return RootNodes();
        }
        const uint32_t chosen = asked.empty() ? defaultScene : FindScene(scenes, asked);
        m_scene.name = scenes.At(chosen)["name"].StringOr("");
        return std::move(roots[chosen]);
    }

    std::vector<uint32_t> ReadSceneRoots(const JsonValue& value) const {
        const JsonValue nodes = value.RequireObject()["nodes"];
        std::vector<uint32_t> roots;
        for (size_t i = 0; i < nodes.Count(); ++i) {
            const uint32_t node = nodes.At(i).Index(m_scene.nodes.size(), "nodes");
            if (m_scene.nodes[node].parent != kNone)
                nodes.At(i).Fail("nodes[" + std::to_string(node) + "] is a child of nodes[" +
                                 std::to_string(m_scene.nodes[node].parent) + "], must be a root");
            roots.push_back(node);
        }
        std::vector<uint32_t> sorted = roots;
        std::sort(sorted.begin(), sorted.end());
        const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
        if (twice != sorted.end()) nodes.Fail("nodes[" + std::to_string(*twice) + "] is listed twice");
        return roots;
    }

    uint32_t FindScene(const JsonValue& scenes, const std::string& asked) const {
        std::string names;
        for (size_t i = 0; i < scenes.Count(); ++i) {
            const std::string name = scenes.At(i)["name"].StringOr("");
            if (name == asked) return static_cast<uint32_t>(i);
            if (i < 8) names += (i ? ", " : "") + std::to_string(i) + " " + Quoted(name, 40);
            if (i == 8) names += ", ...";
        }
        uint32_t index = 0;
        const auto [end, error] = std::from_chars(asked.data(), asked.data() + asked.size(), index);
        if (error == std::errc() && end == asked.data() + asked.size() && index < scenes.Count())
            return index;
        throw Error(ErrorKind::Usage, m_context.label + ": there is no scene " + Quoted(asked) + "; there " +
                                          (names.empty() ? "are none" : "are: " + names));
    }

    // The loaded scene's nodes that have `thing`, by the thing's index, then by the order of nodes.
    std::vector<uint32_t> NodesWith(const std::vector<uint32_t>& thingOfNode) const {
        std::vector<uint32_t> nodes;
        for (const uint32_t node : m_scene.nodeOrder)
            if (thingOfNode[node] != kNone) nodes.push_back(node);
        std::stable_sort(nodes.begin(), nodes.end(),
                         [&](uint32_t a, uint32_t b) { return thingOfNode[a] < thingOfNode[b]; });
        return nodes;
    }

    void PlaceCameras() {
        for (const uint32_t node : NodesWith(m_cameraOfNode)) {
            Camera camera = m_cameras[m_cameraOfNode[node]];
            camera.node = node;
            if (camera.name.empty()) camera.name = m_scene.nodes[node].name;
            m_scene.cameras.push_back(std::move(camera));
        }
    }

    void PlaceLights() {
        for (const uint32_t node : NodesWith(m_lightOfNode)) {
            Light light = m_lights[m_lightOfNode[node]];
            light.node = node;
            if (light.name.empty()) light.name = m_scene.nodes[node].name;
            m_scene.lights.push_back(std::move(light));
        }
    }

    GltfContext& m_context;
    JsonValue m_root;
    size_t m_meshCount;
    SceneData& m_scene;
    std::vector<Camera> m_cameras;
    std::vector<Light> m_lights;
    std::vector<uint32_t> m_cameraOfNode;
    std::vector<uint32_t> m_lightOfNode;
    std::vector<size_t> m_firstChild;
    std::vector<uint32_t> m_children;
};

}  // namespace

void ReadNodes(GltfContext& context, const JsonValue& root, size_t meshCount, SceneData& scene) {
    GraphReader(context, root, meshCount, scene).Read();
}

void PlaceInstances(GltfContext& context, const JsonValue& root, SceneData& scene) {
    const JsonValue nodes = root["nodes"];
    const std::vector<PlacedTransform> transforms = WorldTransforms(scene);
    for (const uint32_t node : scene.nodeOrder) {
        const JsonValue where = nodes.At(node);
        if (!IsFinite(transforms[node].matrix)) where.Fail("its world transform is not finite");
        const uint32_t mesh = scene.nodes[node].mesh;
        if (mesh == kNone || scene.meshes[mesh].primitives.empty()) continue;
        if (!CanInvert(transforms[node].matrix)) {
            context.Warn(where, "singular", "is scaled to nothing or flat, its mesh is left out");
            continue;
        }
        scene.instances.push_back({mesh, node, transforms[node].matrix, transforms[node].rest});
    }
    UpdateWorldTransforms(scene);
    const bool isFinite =
        scene.bounds.IsEmpty() || (std::isfinite(glm::dot(scene.bounds.min, glm::vec3(1))) &&
                                   std::isfinite(glm::dot(scene.bounds.max, glm::vec3(1))));
    if (!isFinite) root.Fail("the scene's bounds are not finite");
}

}  // namespace raygraph::scene
