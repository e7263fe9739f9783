#include "renderer/scene/gltf/pointer.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {
namespace {

using Steps = std::span<const std::string>;

// Returns the names of a pointer, without its escapes; nothing if it is none.
std::optional<std::vector<std::string>> StepsOf(std::string_view pointer) {
    std::vector<std::string> steps;
    if (pointer.empty() || pointer.front() != '/') return std::nullopt;
    for (size_t i = 0; i < pointer.size(); ++i) {
        if (pointer[i] == '/') {
            steps.emplace_back();
        } else if (pointer[i] != '~') {
            steps.back() += pointer[i];
        } else {
            if (++i == pointer.size() || (pointer[i] != '0' && pointer[i] != '1')) return std::nullopt;
            steps.back() += pointer[i] == '0' ? '~' : '/';
        }
    }
    return steps;
}

// Takes the steps that lead to `key` of `object` (fields.h) from the front; false, with some taken, if
// others do.
bool Take(Steps& steps, std::string_view object, std::string_view key) {
    const auto take = [&](std::string_view name) {
        if (name.empty()) return true;
        if (steps.empty() || steps.front() != name) return false;
        steps = steps.subspan(1);
        return true;
    };
    const KeyParts parts = KeyPartsOf(key);
    const bool isExtension = object.starts_with("KHR_");
    return !key.empty() && (!isExtension || take("extensions")) && take(object) && take(parts.object) &&
           take(parts.key);
}

// Returns the index of the element of `list` for which take(element) holds.
template <typename List, typename TakeOne>
size_t IndexOf(const List& list, const TakeOne& takeOne) {
    size_t index = 0, found = std::tuple_size_v<List>;
    const auto look = [&](const auto& field) {
        if (found == std::tuple_size_v<List> && takeOne(field)) found = index;
        ++index;
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, list);
    return found;
}

template <typename T>
constexpr ValueKind KindOf() {
    return std::is_same_v<T, bool> ? ValueKind::Flag : ValueKind::Plain;
}

class PointerResolver {
  public:
    PointerResolver(GltfContext& context, const std::string& pointer, const PointerScene& pointed,
                    const Place& where)
        : m_context(context), m_pointer(pointer), m_pointed(pointed), m_where(where) {}

    PointerTargets Resolve() {
        const std::optional<std::vector<std::string>> all = StepsOf(m_pointer);
        if (!all) m_context.Fail(m_where, Text("is {}, which is no JSON pointer", Quoted(m_pointer, 80)));
        Steps steps = *all;
        const bool isRead = Read(steps);
        if (!isRead)
            m_context.Warn(m_where, "animation pointer",
                           Text("is {}, which is not animated here", Quoted(m_pointer, 80)));
        return isRead ? std::move(m_result) : PointerTargets{};
    }

  private:
    // Returns false if it points at nothing that is read.
    bool Read(Steps steps) {
        const SceneData& scene = m_pointed.scene;
        if (TakeName(steps, "nodes")) return ReadNode(TakeIndex(steps, scene.nodes.size(), "node"), steps);
        if (TakeName(steps, "meshes"))
            return ReadMesh(TakeIndex(steps, m_pointed.meshCount, "mesh", "meshes"), steps);
        if (TakeName(steps, "materials"))
            return ReadMaterial(TakeIndex(steps, m_pointed.materialCount, "material"), steps);
        if (TakeName(steps, "cameras"))
            return ReadCamera(TakeIndex(steps, m_pointed.cameraCount, "camera"), steps);
        if (steps.size() >= 3 && steps[0] == "extensions" && steps[1] == "KHR_lights_punctual" &&
            steps[2] == "lights") {
            steps = steps.subspan(3);
            return ReadLight(TakeIndex(steps, m_pointed.lightCount, "light"), steps);
        }
        return false;
    }

    static bool TakeName(Steps& steps, std::string_view name) {
        if (steps.size() < 2 || steps.front() != name) return false;
        steps = steps.subspan(1);
        return true;
    }

    uint32_t TakeIndex(Steps& steps, size_t count, std::string_view one, std::string_view many = {}) {
        const std::string text = steps.empty() ? "" : steps.front();
        uint32_t index = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
        const bool isIndex = error == std::errc() && end == text.data() + text.size() &&
                             (text.size() == 1 || text.front() != '0');
        if (!isIndex)
            m_context.Fail(m_where, Text("is {}, must name a {} by its index", Quoted(m_pointer, 80), one));
        if (index >= count)
            m_context.Fail(m_where,
                           Text("is {}, but {}", Quoted(m_pointer, 80), CountPhrase(count, one, many)));
        steps = steps.subspan(1);
        return index;
    }

    void Add(const AnimationTarget& target, ValueKind kind = ValueKind::Plain) {
        m_result.kind = kind;
        m_result.targets.push_back(target);
    }

    bool ReadNode(uint32_t node, Steps steps) {
        const auto is = [&](std::string_view name) { return steps.size() == 1 && steps[0] == name; };
        if (is("translation")) return Add({.property = AnimatedProperty::Translation, .object = node}), true;
        if (is("scale")) return Add({.property = AnimatedProperty::Scale, .object = node}), true;
        if (is("rotation"))
            return Add({.property = AnimatedProperty::Rotation, .object = node}, ValueKind::Rotation), true;
        if (is("weights")) return Add({.property = AnimatedProperty::Weights, .object = node}), true;
        if (steps.size() == 2 && steps[0] == "weights")
            return Add({.property = AnimatedProperty::Weights, .object = node, .element = Weight(steps)}),
                   true;
        if (!Take(steps, "KHR_node_visibility", "visible") || !steps.empty()) return false;
        return Add({.property = AnimatedProperty::Visibility, .object = node}, ValueKind::Flag), true;
    }

    uint32_t Weight(Steps steps) {
        steps = steps.subspan(1);
        return TakeIndex(steps, kNone, "weight");
    }

    bool ReadMesh(uint32_t mesh, Steps steps) {
        if (steps.empty() || steps.size() > 2 || steps[0] != "weights") return false;
        const uint32_t element = steps.size() == 2 ? Weight(steps) : kNone;
        Add({.property = AnimatedProperty::MeshWeights, .object = mesh, .element = element});
        return true;
    }

    bool ReadMaterial(uint32_t index, Steps steps) {
        const Material& material = m_pointed.scene.materials[index];
        AnimationTarget target{.property = AnimatedProperty::MaterialField, .object = index};
        ValueKind kind = ValueKind::Plain;
        const size_t field = IndexOf(material_fields::kAll, [&](const auto& plain) {
            const auto placed = SpecularGlossinessField(plain);
            if (material.isSpecularGlossiness && !placed) return false;
            const auto at = material.isSpecularGlossiness ? *placed : plain;
            using Value = typename decltype(at)::Value;
            Steps rest = steps;
            if (!Take(rest, at.object, at.key)) return false;
            if constexpr (std::is_same_v<Value, TextureRef>) {
                const size_t part = IndexOf(kTransformFields, [&](const auto& transformed) {
                    Steps inner = rest;
                    return Take(inner, kTextureTransform, transformed.key) && inner.empty();
                });
                target.property = AnimatedProperty::TextureTransform;
                target.element = static_cast<uint32_t>(part);
                return part < std::tuple_size_v<decltype(kTransformFields)>;
            } else {
                constexpr bool isRead = !std::is_same_v<Value, AlphaMode> && !std::is_same_v<Value, uint32_t>;
                kind = IsGlossiness(at) ? ValueKind::Glossiness : KindOf<Value>();
                target.property = AnimatedProperty::MaterialField;
                target.element = kNone;
                return isRead && rest.empty();
            }
        });
        if (field == std::tuple_size_v<decltype(material_fields::kAll)>) return false;
        target.field = static_cast<uint8_t>(field);
        Add(target, kind);
        return true;
    }

    // Adds a target for each placed object that was made of the file's one. Returns false if some have no
    // such field.
    template <typename List, typename Placed, typename IsOf>
    bool ReadPlaced(AnimatedProperty property, const List& fields, std::span<const uint32_t> sources,
                    const Placed& placed, uint32_t index, Steps steps, const IsOf& isOf) {
        const auto [begin, end] = std::equal_range(sources.begin(), sources.end(), index);
        m_context.ChargeGeometry(m_where, static_cast<uint64_t>(end - begin) * sizeof(uint64_t));
        for (auto source = begin; source != end; ++source) {
            const auto i = static_cast<uint32_t>(source - sources.begin());
            const size_t field = IndexOf(fields, [&](const auto& at) {
                Steps rest = steps;
                return isOf(placed[i], at) && Take(rest, at.object, at.key) && rest.empty();
            });
            if (field == std::tuple_size_v<List>) return false;
            Add({.property = property, .field = static_cast<uint8_t>(field), .object = i});
        }
        return true;
    }

    bool ReadCamera(uint32_t index, Steps steps) {
        return ReadPlaced(AnimatedProperty::CameraField, camera_fields::kAll, m_pointed.cameras,
                          m_pointed.scene.cameras, index, steps, [](const Camera& camera, const auto& field) {
                              return HasField(camera.projection, field);
                          });
    }

    bool ReadLight(uint32_t index, Steps steps) {
        return ReadPlaced(AnimatedProperty::LightField, light_fields::kAll, m_pointed.lights,
                          m_pointed.scene.lights, index, steps,
                          [](const Light& light, const auto& field) { return HasField(light.type, field); });
    }

    GltfContext& m_context;
    const std::string& m_pointer;
    const PointerScene& m_pointed;
    const Place& m_where;
    PointerTargets m_result;
};

}  // namespace

PointerTargets ResolvePointer(GltfContext& context, const std::string& pointer, const PointerScene& pointed,
                              const Place& where) {
    return PointerResolver(context, pointer, pointed, where).Resolve();
}

}  // namespace raygraph::scene
