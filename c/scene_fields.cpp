// Objects of a scene by kind, index and name, and their numbers.
#include <cctype>
#include <cmath>
#include <utility>
#include <vector>

#include "c/call.h"
#include "c/handles.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"

using raygraph::Quoted;
using raygraph::Text;
using raygraph::c::Call;
using raygraph::c::Guarded;
namespace scene = raygraph::scene;

namespace raygraph::c {

namespace {

constexpr const char* kKinds[] = {"node", "mesh", "material", "instance", "light", "camera"};
constexpr const char* kLists[] = {"nodes", "meshes", "materials", "instances", "lights", "cameras"};

size_t CountOf(const Call& call, const scene::SceneData& data, RgObject kind) {
    switch (kind) {
        case RG_NODE:
            return data.nodes.size();
        case RG_MESH:
            return data.meshes.size();
        case RG_MATERIAL:
            return data.materials.size();
        case RG_INSTANCE:
            return data.instances.size();
        case RG_LIGHT:
            return data.lights.size();
        case RG_CAMERA:
            return data.cameras.size();
        default:
            call.Refuse(Text("{} is no kind of object", kind));
    }
}

void RequireObject(const Call& call, const scene::SceneData& data, RgObject kind, uint32_t index) {
    const size_t count = CountOf(call, data, kind);
    if (index >= count) call.Refuse(Text("{} {} does not exist: there are {}", kKinds[kind], index, count));
}

const std::string& NameOf(const scene::SceneData& data, RgObject kind, uint32_t index) {
    static const std::string none;
    switch (kind) {
        case RG_NODE:
            return data.nodes[index].name;
        case RG_MESH:
            return data.meshes[index].name;
        case RG_MATERIAL:
            return data.materials[index].name;
        case RG_LIGHT:
            return data.lights[index].name;
        case RG_CAMERA:
            return data.cameras[index].name;
        default:
            return data.instances[index].node == scene::kNone ? none
                                                              : data.nodes[data.instances[index].node].name;
    }
}

// Returns the name by which a host calls a field: "doubleSided" is isDoubleSided.
std::string HostName(std::string_view field) {
    if (!field.starts_with("is")) return std::string(field);
    std::string name(field.substr(2));
    name[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(name[0])));
    return name;
}

// --- A field as numbers ---

template <typename T>
constexpr bool kIsNumber = false;
template <>
constexpr bool kIsNumber<float> = true;
template <>
constexpr bool kIsNumber<bool> = true;
template <>
constexpr bool kIsNumber<uint32_t> = true;
template <>
constexpr bool kIsNumber<scene::AlphaMode> = true;
template <int N>
constexpr bool kIsNumber<glm::vec<N, float>> = true;

template <typename T>
constexpr uint32_t kNumberCount = 1;
template <int N>
constexpr uint32_t kNumberCount<glm::vec<N, float>> = N;

template <typename T>
void Store(T& to, const float* values) {
    to = static_cast<T>(values[0]);
}
void Store(bool& to, const float* values) {
    to = values[0] != 0.0f;
}
template <int N>
void Store(glm::vec<N, float>& to, const float* values) {
    for (int i = 0; i < N; ++i) to[i] = values[i];
}

template <typename T>
void Fetch(const T& from, float* values) {
    values[0] = static_cast<float>(from);
}
template <int N>
void Fetch(const glm::vec<N, float>& from, float* values) {
    for (int i = 0; i < N; ++i) values[i] = from[i];
}

// Describes what a host asks to read or write.
struct Numbers {
    const Call& call;
    RgObject kind;
    std::string_view name;
    uint32_t count;
    bool isFound = false;
    std::string names;  // of all fields

    template <typename Field>
    bool Is(const Field& field) {
        using Value = typename Field::Value;
        if constexpr (!kIsNumber<Value>) {
            return false;
        } else {
            const std::string called = HostName(field.name);
            names += (names.empty() ? "" : ", ") + called;
            if (called != name) return false;
            if (count != kNumberCount<Value>)
                call.Refuse(Text("{} has {}, and {} are given", called,
                                 Counted(kNumberCount<Value>, "number"), count));
            return isFound = true;
        }
    }
    void RequireFound() const {
        if (!isFound)
            call.Refuse(Text("{} is no number of a {}; there are {}", Quoted(name), kKinds[kind],
                             names.empty() ? "none" : names));
    }
};

// Numbers that no value of the field stands for, such as an alpha mode of 7.
template <typename Value>
void RequireStorable(const Numbers& numbers, const float* values) {
    double highest = 0.0;
    if constexpr (std::is_same_v<Value, bool>)
        highest = 1.0;
    else if constexpr (std::is_same_v<Value, scene::AlphaMode>)
        highest = static_cast<double>(Texts(Value{}).size() - 1);
    else if constexpr (std::is_same_v<Value, uint32_t>)
        highest = 1 << 24;  // the largest range of whole floats
    else
        return;
    if (!(values[0] >= 0.0f && values[0] <= highest) || values[0] != std::floor(values[0]))
        numbers.call.Refuse(
            Text("{} is {}, must be a whole number from 0 to {}", numbers.name, values[0], highest));
}

// Sets a field of a copy, which is checked before it takes the place of the object.
template <typename Object, typename Field>
void SetIn(std::vector<Object>& list, uint32_t index, Numbers& numbers, const Field& field,
           const float* values) {
    if constexpr (kIsNumber<typename Field::Value>) {
        if (!numbers.Is(field)) return;
        RequireStorable<typename Field::Value>(numbers, values);
        Object edited = list[index];
        Store(edited.*field.member, values);
        scene::Check(edited, Text("{}[{}]", kLists[numbers.kind], index));
        list[index] = std::move(edited);
    }
}

template <typename Object, typename Field>
void GetFrom(const Object& object, Numbers& numbers, const Field& field, float* values) {
    if constexpr (kIsNumber<typename Field::Value>)
        if (numbers.Is(field)) Fetch(object.*field.member, values);
}

constexpr auto kNodeVisible =
    scene::FieldPlace<scene::Node, bool>{&scene::Node::isVisible, "isVisible", "", ""};

template <typename Visit>
void ForEachLightField(Visit&& visit) {
    std::apply([&](const auto&... fields) { (visit(fields), ...); }, scene::light_fields::kAll);
}

}  // namespace

}  // namespace raygraph::c

RgResult rg_scene_count(const RgScene* scene, RgObject kind, uint32_t* count) {
    return Guarded("rg_scene_count", [&](const Call& call) {
        const RgScene& of = call.Required(scene, "scene");
        call.Required(count, "count") =
            static_cast<uint32_t>(raygraph::c::CountOf(call, of.scene.input.data, kind));
    });
}

RgResult rg_scene_find(const RgScene* scene, RgObject kind, const char* name, uint32_t* index) {
    return Guarded("rg_scene_find", [&](const Call& call) {
        const scene::SceneData& data = call.Required(scene, "scene").scene.input.data;
        call.RequiredText(name, "name");
        call.Required(index, "index");
        const size_t count = raygraph::c::CountOf(call, data, kind);
        for (uint32_t i = 0; i < count; ++i)
            if (raygraph::c::NameOf(data, kind, i) == name) {
                *index = i;
                return;
            }
        call.Refuse(Text("no {} is called {}", raygraph::c::kKinds[kind], Quoted(name)));
    });
}

RgResult rg_scene_get_name(const RgScene* scene, RgObject kind, uint32_t index, const char** name) {
    return Guarded("rg_scene_get_name", [&](const Call& call) {
        const scene::SceneData& data = call.Required(scene, "scene").scene.input.data;
        raygraph::c::RequireObject(call, data, kind, index);
        call.Required(name, "name") = raygraph::c::NameOf(data, kind, index).c_str();
    });
}

RgResult rg_scene_set(RgScene* scene, RgObject kind, uint32_t index, const char* name, const float* values,
                      uint32_t count) {
    return Guarded("rg_scene_set", [&](const Call& call) {
        raygraph::session::EditedScene& to = call.Required(scene, "scene").scene;
        scene::SceneData& data = to.input.data;
        raygraph::c::RequireObject(call, data, kind, index);
        raygraph::c::Numbers numbers{call, kind, call.RequiredText(name, "name"), count};
        call.Required(values, "values");
        if (kind == RG_MATERIAL)
            scene::ForEachMaterialField([&](const auto& field) {
                raygraph::c::SetIn(data.materials, index, numbers, field, values);
            });
        else if (kind == RG_LIGHT)
            raygraph::c::ForEachLightField(
                [&](const auto& field) { raygraph::c::SetIn(data.lights, index, numbers, field, values); });
        else if (kind == RG_CAMERA)
            scene::ForEachCameraField(data.cameras[index].projection, [&](const auto& field) {
                if (numbers.Is(field)) SetCameraField(to, index, field.member, values[0], field.name);
            });
        else if (kind == RG_NODE && numbers.Is(raygraph::c::kNodeVisible)) {
            raygraph::c::RequireStorable<bool>(numbers, values);
            data.nodes[index].isVisible = values[0] != 0.0f;
        }
        numbers.RequireFound();
        to.isEdited = true;
    });
}

RgResult rg_scene_get(const RgScene* scene, RgObject kind, uint32_t index, const char* name, float* values,
                      uint32_t count) {
    return Guarded("rg_scene_get", [&](const Call& call) {
        const scene::SceneData& data = call.Required(scene, "scene").scene.input.data;
        raygraph::c::RequireObject(call, data, kind, index);
        raygraph::c::Numbers numbers{call, kind, call.RequiredText(name, "name"), count};
        call.Required(values, "values");
        if (kind == RG_MATERIAL)
            scene::ForEachMaterialField([&](const auto& field) {
                raygraph::c::GetFrom(data.materials[index], numbers, field, values);
            });
        else if (kind == RG_LIGHT)
            raygraph::c::ForEachLightField(
                [&](const auto& field) { raygraph::c::GetFrom(data.lights[index], numbers, field, values); });
        else if (kind == RG_CAMERA)
            scene::ForEachCameraField(data.cameras[index].projection, [&](const auto& field) {
                raygraph::c::GetFrom(data.cameras[index], numbers, field, values);
            });
        else if (kind == RG_NODE)
            raygraph::c::GetFrom(data.nodes[index], numbers, raygraph::c::kNodeVisible, values);
        numbers.RequireFound();
    });
}
