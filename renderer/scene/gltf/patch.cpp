#include "renderer/scene/gltf/patch.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <type_traits>

#include "base/text.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/gltf/choice_names.h"
#include "renderer/scene/gltf/lights.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {
namespace {

using OrderedJson = nlohmann::ordered_json;

template <int Length>
OrderedJson JsonVector(const glm::vec<Length, float>& vector) {
    OrderedJson array = OrderedJson::array();
    for (int i = 0; i < Length; ++i) array.push_back(JsonNumber(vector[i]));
    return array;
}

// Writes the translation with the digits that its rest adds (scene_data.h).
OrderedJson JsonPlace(const glm::vec3& rounded, const glm::vec3& rest) {
    OrderedJson array = OrderedJson::array();
    for (int i = 0; i < 3; ++i)
        array.push_back(rest[i] == 0.0f ? JsonNumber(rounded[i])
                                        : OrderedJson(double{rounded[i]} + double{rest[i]}));
    return array;
}

// --- Nodes ---

// `isMoved` says that its position differs from that of the file, whose numbers may have more digits.
void PutMatrix(OrderedJson& node, const Node& edited, bool isMoved) {
    const glm::mat4x3 local = edited.LocalTransform();
    OrderedJson place = JsonPlace(local[3], edited.translationResidual);
    for (size_t i = 0; i < 3 && !isMoved; ++i) {
        if (node.contains("matrix"))
            place[i] = node["matrix"][12 + i];
        else if (node.contains("translation"))
            place[i] = node["translation"][i];
    }
    for (const char* part : {"translation", "rotation", "scale"}) node.erase(part);
    OrderedJson matrix = OrderedJson::array();
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row)
            matrix.push_back(column == 3 ? place[static_cast<size_t>(row)] : JsonNumber(local[column][row]));
        matrix.push_back(column == 3 ? 1 : 0);
    }
    node["matrix"] = std::move(matrix);
}

void PatchNode(OrderedJson& node, const Node& loaded, const Node& edited) {
    const glm::mat4x3 local = edited.LocalTransform(), before = loaded.LocalTransform();
    const bool isMoved = local[3] != before[3] || edited.translationResidual != loaded.translationResidual;
    // A node that is scaled to nothing has one transform, however it is turned
    const bool haveParts = !loaded.matrix && !edited.matrix;
    const bool isSame = !haveParts || (edited.rotation == loaded.rotation && edited.scale == loaded.scale);
    if (local == before && !isMoved && isSame) return;
    std::optional<TransformParts> parts;
    if (haveParts)
        parts = TransformParts{edited.translation, edited.rotation, edited.scale};
    else if (!loaded.matrix)
        parts = PartsOf(local, loaded);
    if (!parts) {
        PutMatrix(node, edited, isMoved);
        return;
    }
    if (isMoved) node["translation"] = JsonPlace(parts->translation, edited.translationResidual);
    if (parts->scale != loaded.scale) node["scale"] = JsonVector(parts->scale);
    const glm::quat& q = parts->rotation;
    if (q != loaded.rotation) node["rotation"] = JsonVector(glm::vec4(q.x, q.y, q.z, q.w));
}

constexpr const char* kVisibility = "KHR_node_visibility";

void PatchVisibility(OrderedJson& root, size_t index, const Node& loaded, const Node& edited) {
    if (edited.isVisible == loaded.isVisible) return;
    Use(root, kVisibility);
    root["nodes"][index]["extensions"][kVisibility]["visible"] = edited.isVisible;
}

// --- Fields ---

OrderedJson JsonOf(float value) {
    return JsonNumber(value);
}
OrderedJson JsonOf(bool value) {
    return value;
}
OrderedJson JsonOf(uint32_t value) {
    return value;
}
OrderedJson JsonOf(AlphaMode mode) {
    return GltfName(mode);
}
template <int Length>
OrderedJson JsonOf(const glm::vec<Length, float>& vector) {
    return JsonVector(vector);
}

template <typename Owner, typename T>
void PutField(OrderedJson& object, const Field<Owner, T>& field, const T& value) {
    if (field.omitsZero && value == T{})
        object.erase(field.key);
    else
        object[field.key] = JsonOf(value);
}

// --- Materials ---

// Returns the shortest number that gives this roughness again.
OrderedJson JsonGlossiness(float roughness) {
    const double exact = 1.0 - double{roughness};
    const OrderedJson shortest = JsonNumber(static_cast<float>(exact));
    return static_cast<float>(1.0 - shortest.get<double>()) == roughness ? shortest : OrderedJson(exact);
}

// Holds one material's JSON, a copy that is not in the tree of `root`, and puts edits there.
class MaterialPatch {
  public:
    MaterialPatch(OrderedJson& root, OrderedJson& material) : m_root(root), m_material(material) {}

    // They are of one kind (RequireSameKind).
    void Put(const Material& loaded, const Material& edited) {
        ForEachFieldOf(edited, [&](const auto& field) {
            if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>)
                PutTransform(field, loaded.*field.member, edited.*field.member);
            else if (loaded.*field.member != edited.*field.member)
                Put(field, edited.*field.member);
        });
    }

  private:
    void PutTransform(const TextureField& field, const TextureRef& loaded, const TextureRef& edited) {
        // The transform has no place in the file without a texture, and no effect.
        if (!loaded.IsPresent() || loaded.transform == edited.transform) return;
        OrderedJson& extension = Extension(Object(field.object)[field.key], kTextureTransform);
        ForEachTransformField([&](const auto& part) {
            if (loaded.transform.*part.member != edited.transform.*part.member)
                PutField(extension, part, edited.transform.*part.member);
        });
    }

    template <typename T>
    void Put(const MaterialField<T>& field, const T& value) {
        const std::string_view object = field.object;
        // The value has no place in the file without the texture that it belongs to, and no effect.
        if (object.ends_with("Texture") && !m_material.contains(object)) return;
        if (const KeyParts parts = KeyPartsOf(field.key); !parts.object.empty()) {
            const OrderedJson::json_pointer texture(Text("/extensions/{}/{}", field.object, parts.object));
            if (m_material.contains(texture)) m_material[texture][parts.key] = JsonOf(value);
        } else if (IsGlossiness(field)) {
            if constexpr (std::is_same_v<T, float>) Object(field.object)[field.key] = JsonGlossiness(value);
        } else if (*field.key != 0) {
            PutField(Object(field.object), field, value);
        } else if (value != T{}) {
            Object(field.object);
        } else {
            m_material["extensions"].erase(field.object);
        }
    }

    OrderedJson& Object(const char* name) {
        const std::string_view object = name;
        if (object.empty()) return m_material;
        if (object.starts_with("KHR_")) return Extension(m_material, name);
        OrderedJson& inner = m_material[name];
        if (object == "extras" && !inner.is_null() && !inner.is_object())
            throw Error(ErrorKind::Usage, "a material's extras are no object: no priority can be put there");
        return inner;
    }

    OrderedJson& Extension(OrderedJson& object, const char* name) {
        Use(m_root, name);
        OrderedJson& extension = object["extensions"][name];
        if (extension.is_null()) extension = OrderedJson::object();
        return extension;
    }

    OrderedJson& m_root;
    OrderedJson& m_material;
};

// Compares the textures except for their transforms.
bool HasSameTextures(const Material& a, const Material& b) {
    bool isSame = true;
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>)
            isSame &= (a.*field.member).texture == (b.*field.member).texture &&
                      (a.*field.member).texCoord == (b.*field.member).texCoord;
    });
    return isSame;
}

// A material stays one of the extension that it is of, and that has not all of the fields.
void RequireSameKind(const Material& loaded, const Material& edited, size_t index) {
    if (loaded.isSpecularGlossiness != edited.isSpecularGlossiness)
        throw MakeError(ErrorKind::Usage, "materials[{}]: whether it is one of {} cannot be changed", index,
                        kSpecularGlossiness);
    if (!edited.isSpecularGlossiness) return;
    ForEachMaterialField([&](const auto& field) {
        if (!SpecularGlossinessField(field) && !(loaded.*field.member == edited.*field.member))
            throw MakeError(ErrorKind::Usage, "materials[{}]: its {} cannot be changed, {} has none", index,
                            field.name, kSpecularGlossiness);
    });
}

// Adds the default material to the file's materials, for every primitive without one, and returns its JSON.
OrderedJson& AddDefault(OrderedJson& root) {
    OrderedJson& materials = root["materials"];
    if (!materials.is_array()) materials = OrderedJson::array();
    const size_t index = materials.size();
    for (OrderedJson& mesh : root["meshes"])
        for (OrderedJson& primitive : mesh["primitives"])
            if (!primitive.contains("material")) primitive["material"] = index;
    materials.push_back({{"name", "default"}});
    return materials.back();
}

// --- Lights ---

bool HasSameValues(const Light& a, const Light& b) {
    bool isSame = a.type == b.type && a.profile == b.profile;
    ForEachLightField(a, [&](const auto& field) { isSame &= a.*field.member == b.*field.member; });
    return isSame;
}

void PutLight(OrderedJson& light, const Light& loaded, const Light& edited) {
    ForEachLightField(edited, [&](const auto& field) {
        if (edited.*field.member == loaded.*field.member) return;
        PutField(*field.object == 0 ? light : light[field.object], field, edited.*field.member);
    });
}

// The values of a node's light with a profile, whose color glTF bounds by 1: what is above goes to the
// factor.
void PutProfileLight(OrderedJson& node, const Light& loaded, Light edited) {
    if (HasSameValues(loaded, edited)) return;
    const float brightest = std::max({edited.color.x, edited.color.y, edited.color.z});
    if (brightest > 1.0f) {
        edited.color /= brightest;
        edited.intensity *= brightest;
    }
    OrderedJson& light = node["extensions"][kProfileExtension];
    if (edited.color != loaded.color) light["color"] = JsonOf(edited.color);
    if (edited.intensity != loaded.intensity) light["multiplier"] = JsonOf(edited.intensity);
}

// Returns the edited light of each loaded one, by their nodes, which have at most one each, and one with a
// profile: a light that was split when the file was saved has a later index in the file than in what was
// edited.
std::vector<const Light*> EditedLights(const SceneData& loaded, const SceneData& edited) {
    std::vector<const Light*> byNode[2];
    for (std::vector<const Light*>& ofKind : byNode) ofKind.resize(loaded.nodes.size(), nullptr);
    for (const Light& light : edited.lights)
        if (light.node < loaded.nodes.size()) byNode[light.profile != kNone][light.node] = &light;
    std::vector<const Light*> lights;
    for (const Light& light : loaded.lights) {
        lights.push_back(byNode[light.profile != kNone].at(light.node));
        if (!lights.back())
            throw MakeError(ErrorKind::BadInput,
                            "nodes[{}] has a light in the file and none in the scene: it is not the one "
                            "that was loaded",
                            light.node);
    }
    return lights;
}

}  // namespace

void Use(OrderedJson& root, const char* extension) {
    OrderedJson& used = root["extensionsUsed"];
    if (!used.is_array()) used = OrderedJson::array();
    if (std::find(used.begin(), used.end(), extension) == used.end()) used.push_back(extension);
}

OrderedJson* LightOf(OrderedJson& node) {
    const auto extensions = node.find("extensions");
    if (extensions == node.end()) return nullptr;
    const auto lights = extensions->find(kPunctualLights);
    if (lights == extensions->end()) return nullptr;
    const auto light = lights->find("light");
    return light == lights->end() ? nullptr : &*light;
}

void FailOther(const char* what, size_t inFile, size_t inScene) {
    throw MakeError(ErrorKind::BadInput,
                    "the file has {} {}, the scene {}: it is not the one that was loaded", inFile, what,
                    inScene);
}

OrderedJson JsonNumber(float value) {
    // A double of these digits is written with these digits, and is the float again when it is rounded
    char digits[32];
    const auto [end, failure] = std::to_chars(digits, digits + sizeof digits, value);
    double number = value;
    if (failure == std::errc{}) std::from_chars(digits, end, number);
    if (static_cast<float>(number) != value) number = value;
    return number;
}

void PatchNodes(OrderedJson& root, const SceneData& loaded, const SceneData& edited) {
    if (loaded.nodes.size() != edited.nodes.size())
        FailOther("nodes", loaded.nodes.size(), edited.nodes.size());
    for (size_t i = 0; i < loaded.nodes.size(); ++i) {
        PatchNode(root["nodes"][i], loaded.nodes[i], edited.nodes[i]);
        PatchVisibility(root, i, loaded.nodes[i], edited.nodes[i]);
    }
}

void PatchMaterials(OrderedJson& root, const GltfOutline& outline, const SceneData& edited) {
    const std::vector<Material>& loaded = outline.scene.materials;
    if (loaded.size() != edited.materials.size())
        FailOther("materials", loaded.size(), edited.materials.size());
    for (size_t i = 0; i < loaded.size(); ++i) {
        if (!HasSameTextures(loaded[i], edited.materials[i]))
            throw MakeError(ErrorKind::Usage, "materials[{}]: its textures cannot be exchanged", i);
        RequireSameKind(loaded[i], edited.materials[i], i);
        // The edit goes into a copy: a material that has not been edited leaves the tree as it is.
        const bool isDefault = i == outline.defaultMaterial;
        OrderedJson changed = isDefault ? OrderedJson::object() : root["materials"][i];
        const OrderedJson before = changed;
        MaterialPatch(root, changed).Put(loaded[i], edited.materials[i]);
        if (changed == before) continue;
        if (isDefault)
            AddDefault(root).update(changed);
        else
            root["materials"][i] = std::move(changed);
    }
}

void PatchLights(OrderedJson& root, const SceneData& loaded, const SceneData& edited) {
    std::vector<bool> isPlaced(edited.nodes.size(), false);
    for (const uint32_t node : edited.nodeOrder) isPlaced[node] = true;
    const auto count = static_cast<size_t>(std::ranges::count_if(
        edited.lights, [&](const Light& light) { return light.node == kNone || isPlaced[light.node]; }));
    if (loaded.lights.size() != count) FailOther("lights", loaded.lights.size(), count);
    if (loaded.lights.empty()) return;
    const std::vector<const Light*> now = EditedLights(loaded, edited);
    OrderedJson& nodes = root["nodes"];
    size_t punctual = count;  // without those with a profile, which are the last ones
    for (; punctual > 0 && loaded.lights[punctual - 1].profile != kNone; --punctual) {
        const Light& light = loaded.lights[punctual - 1];
        PutProfileLight(nodes[light.node], light, *now[punctual - 1]);
    }
    if (punctual == 0) return;
    OrderedJson& lights = root["extensions"][kPunctualLights]["lights"];
    std::vector<size_t> userCount(lights.size(), 0);  // nodes
    for (OrderedJson& node : nodes)
        if (const OrderedJson* light = LightOf(node)) userCount[light->get<size_t>()]++;
    // The scene's lights are visited by the file's: those of one are neighbors (SceneData::lights)
    for (size_t first = 0, end = 0; first < punctual; first = end) {
        const auto lightOf = [&](size_t i) { return LightOf(nodes[loaded.lights[i].node])->get<size_t>(); };
        const size_t index = lightOf(first);
        bool isAlike = true;
        for (end = first; end < punctual && lightOf(end) == index; ++end) {
            if (now[end]->type != loaded.lights[end].type)
                throw MakeError(ErrorKind::Usage, "the light of nodes[{}]: its type cannot be changed",
                                now[end]->node);
            isAlike = isAlike && HasSameValues(*now[end], *now[first]);
        }
        if (isAlike && end - first == userCount[index]) {
            PutLight(lights[index], loaded.lights[first], *now[first]);
            continue;
        }
        // Shared with others that stay as they are
        const OrderedJson shared = lights[index];
        for (size_t i = first; i < end; ++i) {
            if (HasSameValues(*now[i], loaded.lights[i])) continue;
            OrderedJson own = shared;
            PutLight(own, loaded.lights[i], *now[i]);
            *LightOf(nodes[loaded.lights[i].node]) = lights.size();
            lights.push_back(std::move(own));
        }
    }
}

}  // namespace raygraph::scene
