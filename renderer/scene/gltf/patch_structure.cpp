#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "base/text.h"
#include "renderer/scene/gltf/choice_names.h"
#include "renderer/scene/gltf/patch.h"

namespace raygraph::scene {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::vector<bool> AreIn(const std::vector<uint32_t>& nodes, size_t count) {
    std::vector<bool> areIn(count, false);
    for (const uint32_t node : nodes) areIn[node] = true;
    return areIn;
}

OrderedJson& ListOf(OrderedJson& object, const char* name) {
    OrderedJson& list = object[name];
    if (!list.is_array()) list = OrderedJson::array();
    return list;
}

// --- Nodes that were added ---

class NodeAdder {
  public:
    NodeAdder(OrderedJson& root, GltfOutline& loaded, const SceneData& edited)
        : m_root(root), m_loaded(loaded), m_edited(edited), m_fileCount(loaded.scene.nodes.size()) {}

    // Adds the next node; `isGone`: only its index is wanted.
    void Add(std::span<const uint32_t> copiedFrom, bool isGone) {
        SceneData& scene = m_loaded.scene;
        const auto index = static_cast<uint32_t>(scene.nodes.size());
        uint32_t origin = copiedFrom[index - m_fileCount];
        while (origin != kNone && origin >= m_fileCount) origin = copiedFrom[origin - m_fileCount];
        const bool isCopy = origin != kNone && !isGone;
        OrderedJson node = isCopy ? m_root["nodes"][origin] : OrderedJson::object();
        node.erase("children");
        ListOf(m_root, "nodes").push_back(std::move(node));
        scene.nodes.push_back(isCopy ? Node(scene.nodes[origin]) : Node());
        scene.nodes.back().parent = kNone;
        if (isCopy)
            CopyLights(origin, index);
        else if (!isGone)
            AddObjects(index);
    }

  private:
    // Lights are sorted by the file's; those with a profile are the last ones (SceneData::lights).
    void InsertLight(Light light, uint32_t inFile) {
        std::vector<uint32_t>& indices = m_loaded.graph.lights;
        const auto at = std::ranges::upper_bound(indices, inFile) - indices.begin();
        indices.insert(indices.begin() + at, inFile);
        m_loaded.scene.lights.insert(m_loaded.scene.lights.begin() + at, std::move(light));
    }

    void CopyLights(uint32_t origin, uint32_t index) {
        std::vector<Light>& lights = m_loaded.scene.lights;
        for (size_t i = 0; i < lights.size(); ++i) {
            if (lights[i].node != origin) continue;
            Light copy = lights[i];
            copy.node = index;
            if (copy.profile == kNone) {
                InsertLight(std::move(copy), m_loaded.graph.lights[i]);
            } else {
                lights.push_back(std::move(copy));
            }
        }
    }

    void AddObjects(uint32_t index) {
        for (const Light& light : m_edited.lights)
            if (light.node == index) AddLight(light.type, index);
        for (const Camera& camera : m_edited.cameras)
            if (camera.node == index) AddCamera(camera, index);
    }

    // Adds a light with glTF's defaults, which are those of Light.
    void AddLight(LightType type, uint32_t node) {
        Use(m_root, kPunctualLights);
        OrderedJson& lights = ListOf(m_root["extensions"][kPunctualLights], "lights");
        const auto inFile = static_cast<uint32_t>(lights.size());
        lights.push_back({{"type", GltfName(type)}});
        if (type == LightType::Spot) lights.back()["spot"] = OrderedJson::object();
        m_root["nodes"][node]["extensions"][kPunctualLights]["light"] = inFile;
        InsertLight({.node = node, .type = type}, inFile);
    }

    void AddCamera(const Camera& camera, uint32_t node) {
        OrderedJson& cameras = ListOf(m_root, "cameras");
        m_root["nodes"][node]["camera"] = cameras.size();
        OrderedJson added = OrderedJson::object();
        const bool isPerspective = camera.projection == Projection::Perspective;
        added["type"] = isPerspective ? "perspective" : "orthographic";
        OrderedJson& values = added[isPerspective ? "perspective" : "orthographic"];
        const auto put = [&](const char* key, float value) { values[key] = JsonNumber(value); };
        if (isPerspective) {
            if (camera.aspectRatio > 0.0f) put("aspectRatio", camera.aspectRatio);
            put("yfov", camera.yFov);
        } else {
            put("xmag", camera.xMag);
            put("ymag", camera.yMag);
        }
        if (camera.zFar > 0.0f) put("zfar", camera.zFar);
        put("znear", camera.zNear);
        ListOf(m_root, "cameras").push_back(std::move(added));
    }

    OrderedJson& m_root;
    GltfOutline& m_loaded;
    const SceneData& m_edited;
    size_t m_fileCount;
};

void RemoveContent(OrderedJson& root, GltfOutline& loaded, uint32_t node, const Node& edited) {
    root["nodes"][node] = OrderedJson::object();
    loaded.scene.nodes[node] = edited;
    std::vector<Light>& lights = loaded.scene.lights;
    std::vector<uint32_t>& indices = loaded.graph.lights;
    for (size_t i = lights.size(); i-- > 0;) {
        if (lights[i].node != node) continue;
        if (i < indices.size()) indices.erase(indices.begin() + static_cast<std::ptrdiff_t>(i));
        lights.erase(lights.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

// --- The hierarchy ---

// Writes a list of nodes where it differs; glTF has no empty ones.
void PutNodes(OrderedJson& object, const char* key, const std::vector<uint32_t>& nodes) {
    const auto found = object.find(key);
    if (found == object.end() ? nodes.empty() : *found == OrderedJson(nodes)) return;
    if (nodes.empty())
        object.erase(key);
    else
        object[key] = nodes;
}

void PutScenes(OrderedJson& root, const GltfOutline& loaded, const SceneData& edited,
               const std::vector<uint32_t>& roots, const NodeChanges& changes) {
    if (loaded.graph.scene == kNone) return;
    OrderedJson& scenes = root["scenes"];
    for (size_t i = 0; i < scenes.size(); ++i) {
        if (i == loaded.graph.scene) {
            PutNodes(scenes[i], "nodes", roots);
            continue;
        }
        std::vector<uint32_t> others;
        for (const OrderedJson& node : scenes[i].value("nodes", OrderedJson::array()))
            if (const auto index = node.get<uint32_t>();
                !changes.isGone[index] && edited.nodes[index].parent == kNone)
                others.push_back(index);
        PutNodes(scenes[i], "nodes", others);
    }
}

// Removes the elements of an optional list for which `isGone` returns true; a list that becomes empty goes,
// too. Returns the new indices, kNone for what is gone.
template <typename IsGone>
std::vector<uint32_t> RemoveFrom(OrderedJson& object, const char* key, IsGone&& isGone) {
    std::vector<uint32_t> newIndices;
    const auto list = object.find(key);
    if (list == object.end()) return newIndices;
    OrderedJson kept = OrderedJson::array();
    for (size_t i = 0; i < list->size(); ++i) {
        const bool isKept = !isGone((*list)[i], i);
        newIndices.push_back(isKept ? static_cast<uint32_t>(kept.size()) : kNone);
        if (isKept) kept.push_back(std::move((*list)[i]));
    }
    if (kept.empty() && !newIndices.empty())
        object.erase(key);
    else
        *list = std::move(kept);
    return newIndices;
}

// Returns the node that a channel's target names, by its index or by a pointer, and where in the pointer's
// text the number ends.
struct TargetNode {
    OrderedJson* node = nullptr;     // the index
    std::string* pointer = nullptr;  // "/nodes/12/..."
    uint32_t index = kNone;
    size_t end = 0;
};
constexpr std::string_view kNodePointer = "/nodes/";
TargetNode NodeOf(OrderedJson& target) {
    TargetNode of;
    if (const auto node = target.find("node"); node != target.end()) {
        of.node = &*node;
        of.index = node->get<uint32_t>();
    }
    const OrderedJson::json_pointer place(Text("/extensions/{}/pointer", kAnimationPointer));
    if (!target.contains(place)) return of;
    auto& text = target[place].get_ref<std::string&>();
    if (!text.starts_with(kNodePointer)) return of;
    const char* const begin = text.data() + kNodePointer.size();
    const auto [end, failure] = std::from_chars(begin, text.data() + text.size(), of.index);
    if (failure != std::errc{}) return of;
    of.pointer = &text;
    of.end = static_cast<size_t>(end - text.data());
    return of;
}

void RemoveChannels(OrderedJson& root, const std::vector<bool>& isGone) {
    const auto isOfGone = [&](OrderedJson& channel, size_t) {
        const uint32_t node = NodeOf(channel["target"]).index;
        return node < isGone.size() && isGone[node];
    };
    RemoveFrom(root, "animations", [&](OrderedJson& animation, size_t) {
        const auto channels = animation.find("channels");
        if (channels == animation.end() || channels->empty()) return false;
        RemoveFrom(animation, "channels", isOfGone);
        return !animation.contains("channels");
    });
}

void RemoveSkins(OrderedJson& root, const std::vector<bool>& isGone) {
    const auto skins = RemoveFrom(root, "skins", [&](OrderedJson& skin, size_t) {
        if (const auto skeleton = skin.find("skeleton");
            skeleton != skin.end() && isGone[skeleton->get<uint32_t>()])
            skin.erase("skeleton");
        return std::ranges::any_of(skin["joints"],
                                   [&](const OrderedJson& joint) { return isGone[joint.get<uint32_t>()]; });
    });
    OrderedJson& nodes = root["nodes"];
    for (size_t i = 0; i < nodes.size(); ++i) {
        const auto skin = nodes[i].find("skin");
        if (skin == nodes[i].end()) continue;
        const uint32_t now = skins.at(skin->get<uint32_t>());
        if (now == kNone)
            throw MakeError(ErrorKind::Usage, "nodes[{}]: a joint of its skin has been removed", i);
        *skin = now;
    }
}

void RemoveNodes(OrderedJson& root, const std::vector<bool>& isRemoved) {
    const std::vector<uint32_t> now =
        RemoveFrom(root, "nodes", [&](OrderedJson&, size_t i) { return isRemoved[i]; });
    const auto renumber = [&](OrderedJson& object, const char* key) {
        if (const auto list = object.find(key); list != object.end())
            for (OrderedJson& node : *list) node = now.at(node.get<size_t>());
    };
    const auto forEach = [&](const char* key, auto&& visit) {
        if (const auto list = root.find(key); list != root.end())
            for (OrderedJson& element : *list) visit(element);
    };
    forEach("nodes", [&](OrderedJson& node) { renumber(node, "children"); });
    forEach("scenes", [&](OrderedJson& scene) { renumber(scene, "nodes"); });
    forEach("skins", [&](OrderedJson& skin) {
        renumber(skin, "joints");
        if (const auto skeleton = skin.find("skeleton"); skeleton != skin.end())
            *skeleton = now.at(skeleton->get<size_t>());
    });
    forEach("animations", [&](OrderedJson& animation) {
        for (OrderedJson& channel : animation["channels"]) {
            const TargetNode target = NodeOf(channel["target"]);
            if (target.index >= now.size()) continue;
            if (target.node) *target.node = now[target.index];
            if (target.pointer)
                target.pointer->replace(kNodePointer.size(), target.end - kNodePointer.size(),
                                        std::to_string(now[target.index]));
        }
    });
}

}  // namespace

bool AreExtensionsRead(const OrderedJson& root) {
    const auto used = root.find("extensionsUsed");
    if (used == root.end()) return true;
    return std::ranges::all_of(*used, [](const OrderedJson& name) {
        return std::ranges::any_of(KnownExtensions(), [&](const GltfExtension& known) {
            return known.isRead && name.is_string() && known.name == name.get_ref<const std::string&>();
        });
    });
}

NodeChanges PatchNodeList(OrderedJson& root, GltfOutline& loaded, const SceneData& edited,
                          std::span<const uint32_t> copiedFrom) {
    NodeChanges changes{.fileCount = loaded.scene.nodes.size(), .isGone = {}};
    if (edited.nodes.size() != changes.fileCount + copiedFrom.size())
        FailOther("nodes", changes.fileCount, edited.nodes.size());
    changes.isGone = AreIn(loaded.scene.nodeOrder, edited.nodes.size());
    for (size_t i = changes.fileCount; i < edited.nodes.size(); ++i) changes.isGone[i] = true;
    for (const uint32_t node : edited.nodeOrder) changes.isGone[node] = false;
    NodeAdder adder(root, loaded, edited);
    for (size_t i = changes.fileCount; i < edited.nodes.size(); ++i) adder.Add(copiedFrom, changes.isGone[i]);
    for (uint32_t i = 0; i < edited.nodes.size(); ++i)
        if (changes.isGone[i]) RemoveContent(root, loaded, i, edited.nodes[i]);
    return changes;
}

void PatchHierarchy(OrderedJson& root, const GltfOutline& loaded, const SceneData& edited,
                    const NodeChanges& changes) {
    std::vector<std::vector<uint32_t>> children(edited.nodes.size());
    std::vector<uint32_t> roots;
    for (const uint32_t node : edited.nodeOrder) {
        const uint32_t parent = edited.nodes[node].parent;
        (parent == kNone ? roots : children[parent]).push_back(node);
    }
    for (const uint32_t node : edited.nodeOrder) {
        OrderedJson& file = root["nodes"][node];
        if (const std::string& name = edited.nodes[node].name; name != loaded.scene.nodes[node].name) {
            if (name.empty())
                file.erase("name");
            else
                file["name"] = name;
        }
        PutNodes(file, "children", children[node]);
    }
    PutScenes(root, loaded, edited, roots, changes);
    if (std::ranges::find(changes.isGone, true) == changes.isGone.end()) return;
    std::vector<bool> isRemoved = changes.isGone;
    if (AreExtensionsRead(root)) {
        RemoveChannels(root, changes.isGone);  // and animations without any, whose indices may be named, too
        RemoveSkins(root, changes.isGone);
    } else {
        std::fill_n(isRemoved.begin(), changes.fileCount, false);
    }
    RemoveNodes(root, isRemoved);
}

}  // namespace raygraph::scene
