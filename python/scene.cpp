// Scenes from Python: loaded from a file or made of arrays, and edited. Views name an object of a scene by
// its index and keep the scene.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "base/printable.h"
#include "base/text.h"
#include "python/bindings.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::python {

using namespace session;

namespace {

using ScenePtr = std::shared_ptr<Scene>;
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Bytes = py::array_t<uint8_t, py::array::c_style>;

// An object of the list `kList` of a scene.
template <typename Object, std::vector<Object> scene::SceneData::*kList>
struct View {
    ScenePtr scene;
    uint32_t index = 0;

    const Object& Get() const { return (scene->input.data.*kList)[index]; }
    Object& Edit() const { return (scene->Edit().*kList)[index]; }
};
using NodeView = View<scene::Node, &scene::SceneData::nodes>;
using MaterialView = View<scene::Material, &scene::SceneData::materials>;
using LightView = View<scene::Light, &scene::SceneData::lights>;
using CameraView = View<scene::Camera, &scene::SceneData::cameras>;

ScenePtr Load(const std::filesystem::path& path, std::string sceneName, std::string variant,
              const std::string& points, const std::string& lines, std::filesystem::path environment,
              std::filesystem::path root) {
    InputOptions options{.scene = std::move(sceneName), .variant = std::move(variant), .isAnimated = true};
    options.pointsAndLines = {scene::ParseRoundRadius(points), scene::ParseRoundRadius(lines)};
    options.root = std::move(root);
    options.environment = std::move(environment);
    options.log = LogToPython();
    return Interruptibly([path, options = std::move(options)](Caller& caller) mutable {
        options.progress = [&](std::string_view, float) { caller.ThrowIfStopRequested(); };
        auto loaded = std::make_shared<Scene>();
        loaded->input = LoadInput(path, options);
        return loaded;
    });
}

// --- Values ---

std::string ShapeText(const py::array& array) {
    std::string text = "(";
    for (py::ssize_t i = 0; i < array.ndim(); ++i) text += Text("{}{}", i > 0 ? ", " : "", array.shape(i));
    return text + ")";
}

// Returns the rows of an array of shape (n, N). Throws if one is not finite.
template <int N>
std::vector<glm::vec<N, float>> RowsOf(const char* name, const Floats& array) {
    if (array.ndim() != 2 || array.shape(1) != N)
        throw MakeError(ErrorKind::Usage, "{}: the shape is {}, not (n, {})", name, ShapeText(array), N);
    std::vector<glm::vec<N, float>> rows(static_cast<size_t>(array.shape(0)));
    static_assert(sizeof(rows[0]) == N * sizeof(float));
    if (!rows.empty())
        std::memcpy(static_cast<void*>(rows.data()), array.data(), rows.size() * sizeof(rows[0]));
    if (!std::all_of(array.data(), array.data() + array.size(),
                     [](float value) { return std::isfinite(value); }))
        throw MakeError(ErrorKind::Usage, "{}: one is not finite", name);
    return rows;
}

// Returns the matrix of (4, 4) or (3, 4) numbers, of column vectors, whose translation is in the last column.
scene::PlacedTransform TransformOf(const Doubles& array) {
    if (array.ndim() != 2 || (array.shape(0) != 4 && array.shape(0) != 3) || array.shape(1) != 4)
        throw MakeError(ErrorKind::Usage, "matrix: the shape is {}, not (4, 4)", ShapeText(array));
    std::array<double, 16> matrix{};
    matrix[15] = 1.0;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            matrix[static_cast<size_t>(4 * column + row)] = array.at(row, column);
    return session::TransformOf(matrix);
}

py::array ArrayOf(const scene::PlacedTransform& placed) {
    const std::array<double, 16> matrix = MatrixOf(placed);
    Doubles array({4, 4});
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            array.mutable_at(row, column) = matrix[static_cast<size_t>(4 * column + row)];
    return array;
}

template <int N>
glm::vec<N, float> VectorOf(const py::object& value) {
    const auto numbers = value.cast<std::array<float, N>>();
    glm::vec<N, float> vector;
    for (int i = 0; i < N; ++i) vector[i] = numbers[static_cast<size_t>(i)];
    return vector;
}
template <int N>
py::tuple TupleOf(const glm::vec<N, float>& vector) {
    py::tuple tuple(N);
    for (int i = 0; i < N; ++i) tuple[static_cast<size_t>(i)] = vector[i];
    return tuple;
}

// "base_color_factor" for baseColorFactor, "double_sided" for isDoubleSided.
std::string AttributeName(std::string_view name) {
    if (name.starts_with("is")) name.remove_prefix(2);
    std::string attribute;
    for (const char c : name) {
        if (std::isupper(c) && !attribute.empty()) attribute += '_';
        attribute += static_cast<char>(std::tolower(c));
    }
    return attribute;
}

py::object ToPython(float value) {
    return py::float_(value);
}
py::object ToPython(bool value) {
    return py::bool_(value);
}
py::object ToPython(uint32_t value) {
    return py::int_(value);
}
py::object ToPython(scene::AlphaMode value) {
    return py::str(Name(value));
}
template <int N>
py::object ToPython(const glm::vec<N, float>& value) {
    return TupleOf<N>(value);
}

void FromPython(const py::object& value, float& to) {
    to = value.cast<float>();
}
void FromPython(const py::object& value, bool& to) {
    to = value.cast<bool>();
}
void FromPython(const py::object& value, uint32_t& to) {
    to = value.cast<uint32_t>();
}
void FromPython(const py::object& value, scene::AlphaMode& to) {
    const auto text = value.cast<std::string>();
    for (const scene::AlphaMode mode : Values<scene::AlphaMode>())
        if (text == Name(mode)) {
            to = mode;
            return;
        }
    throw MakeError(ErrorKind::Usage, "alpha_mode: {} is none of opaque, mask, blend", Quoted(text));
}
template <int N>
void FromPython(const py::object& value, glm::vec<N, float>& to) {
    to = VectorOf<N>(value);
}

// Sets a field of a copy, which is checked before it takes the place of the object.
template <typename Object, typename ViewOfObject, typename T>
void SetChecked(const ViewOfObject& view, T Object::*member, const py::object& value, const char* list) {
    Object edited = view.Get();
    FromPython(value, edited.*member);
    scene::Check(edited, Text("{}[{}]", list, view.index));
    view.Edit() = std::move(edited);
}

// --- Nodes, materials, lights, cameras ---

template <typename ViewOfObject>
std::vector<ViewOfObject> ViewsOf(const ScenePtr& scene, size_t count) {
    std::vector<ViewOfObject> views;
    for (uint32_t i = 0; i < count; ++i) views.push_back({scene, i});
    return views;
}

// Binds what all views have.
template <typename ViewOfObject>
py::class_<ViewOfObject> BindView(py::module_& module, const char* name, const char* text) {
    return py::class_<ViewOfObject>(module, name, text)
        .def_readonly("index", &ViewOfObject::index)
        .def_property(
            "name", [](const ViewOfObject& view) { return view.Get().name; },
            [](const ViewOfObject& view, std::string value) { view.Edit().name = std::move(value); })
        .def("__repr__", [name = std::string(name)](const ViewOfObject& view) {
            return Text("<raygraph.{} {} {}>", name, view.index, Quoted(view.Get().name));
        });
}

void SetMatrix(const NodeView& view, const Doubles& array) {
    const scene::PlacedTransform placed = TransformOf(array);
    scene::Node& node = view.Edit();
    node.matrix = placed.matrix;
    node.translationResidual = placed.rest;
}

glm::vec3 FiniteVector(const NodeView& view, const char* what, const py::object& value) {
    const glm::vec3 vector = VectorOf<3>(value);
    if (!scene::IsFinite(vector))
        throw MakeError(ErrorKind::Usage, "nodes[{}]: the {} is not finite", view.index, what);
    return vector;
}

scene::Node& WithoutMatrix(const NodeView& view) {
    scene::Node& node = view.Edit();
    if (node.matrix)
        throw MakeError(ErrorKind::Usage,
                        "nodes[{}] has a matrix, of which only the translation can be set alone", view.index);
    return node;
}

void BindNodes(py::module_& module) {
    BindView<NodeView>(module, "Node", "A node of a scene, which places what it has and the nodes below it.")
        .def_property(
            "matrix",
            [](const NodeView& view) {
                return ArrayOf({view.Get().LocalTransform(), view.Get().translationResidual});
            },
            &SetMatrix)
        .def_property_readonly(
            "world_matrix",
            [](const NodeView& view) { return ArrayOf(WorldTransforms(view.scene->input.data)[view.index]); })
        .def_property(
            "translation",
            [](const NodeView& view) {
                return TupleOf<3>(view.Get().matrix ? (*view.Get().matrix)[3] : view.Get().translation);
            },
            [](const NodeView& view, const py::object& value) {
                const glm::vec3 place = FiniteVector(view, "translation", value);
                scene::Node& node = view.Edit();
                (node.matrix ? (*node.matrix)[3] : node.translation) = place;
                node.translationResidual = {};
            })
        .def_property(
            "rotation",
            [](const NodeView& view) {
                const glm::quat& q = view.Get().rotation;
                return py::make_tuple(q.x, q.y, q.z, q.w);
            },
            [](const NodeView& view, const py::object& value) {
                const glm::vec4 q = VectorOf<4>(value);
                const float length = glm::length(q);
                if (!(length > 0.0f) || !std::isfinite(length))
                    throw MakeError(ErrorKind::Usage, "nodes[{}]: the rotation is no quaternion", view.index);
                WithoutMatrix(view).rotation =
                    glm::quat(q.w / length, q.x / length, q.y / length, q.z / length);
            })
        .def_property(
            "scale", [](const NodeView& view) { return TupleOf<3>(view.Get().scale); },
            [](const NodeView& view, const py::object& value) {
                const glm::vec3 scale = FiniteVector(view, "scale", value);
                WithoutMatrix(view).scale = scale;
            })
        .def_property(
            "visible", [](const NodeView& view) { return view.Get().isVisible; },
            [](const NodeView& view, bool value) { view.Edit().isVisible = value; })
        .def_property_readonly("parent", [](const NodeView& view) -> std::optional<NodeView> {
            if (view.Get().parent == scene::kNone) return std::nullopt;
            return NodeView{view.scene, view.Get().parent};
        });
}

// Makes an array of texels the texture that a field of a material names.
void SetTexels(const MaterialView& view, const scene::TextureField& field, const py::object& value) {
    if (value.is_none()) {
        SetTexture(*view.scene, view.index, field, {});
        return;
    }
    const Bytes texels = Bytes::ensure(value);
    if (!texels || !py::isinstance<py::array_t<uint8_t>>(value) || texels.ndim() != 3 ||
        texels.shape(2) < 3 || texels.shape(2) > 4 || texels.shape(0) < 1 || texels.shape(1) < 1)
        throw MakeError(ErrorKind::Usage, "{}: it is uint8 of (height, width, 3 or 4)",
                        AttributeName(field.name));
    scene::ImageData image{.name = view.Get().name + "." + AttributeName(field.name),
                           .width = static_cast<uint32_t>(texels.shape(1)),
                           .height = static_cast<uint32_t>(texels.shape(0))};
    const auto channels = static_cast<size_t>(texels.shape(2));
    const size_t count = size_t{image.width} * image.height;
    image.rgba.assign(4 * count, 255);
    for (size_t i = 0; i < count; ++i)
        std::copy_n(texels.data() + i * channels, channels,
                    image.rgba.begin() + static_cast<ptrdiff_t>(4 * i));
    SetTexture(*view.scene, view.index, field, std::move(image));
}

py::object TexelsOf(const MaterialView& view, const scene::TextureRef& reference) {
    if (!reference.IsPresent()) return py::none();
    const scene::SceneData& data = view.scene->input.data;
    const scene::ImageData& image = data.images[data.textures[static_cast<size_t>(reference.texture)].image];
    Bytes texels(
        {static_cast<py::ssize_t>(image.height), static_cast<py::ssize_t>(image.width), py::ssize_t{4}});
    std::copy(image.rgba.begin(), image.rgba.end(), texels.mutable_data());
    return texels;
}

void BindMaterials(py::module_& module) {
    auto material = BindView<MaterialView>(module, "Material",
                                           "A material: the fields of glTF and its extensions. A texture is "
                                           "uint8 of (height, width, 3 or 4), or None.");
    scene::ForEachMaterialField([&](const auto& field) {
        const auto member = field.member;
        const std::string name = AttributeName(field.name);
        if constexpr (std::is_same_v<std::decay_t<decltype(field)>, scene::TextureField>) {
            const scene::TextureField texture = field;
            material.def_property(
                name.c_str(),
                [member](const MaterialView& view) { return TexelsOf(view, view.Get().*member); },
                [texture](const MaterialView& view, const py::object& value) {
                    SetTexels(view, texture, value);
                });
        } else {
            material.def_property(
                name.c_str(), [member](const MaterialView& view) { return ToPython(view.Get().*member); },
                [member](const MaterialView& view, const py::object& value) {
                    SetChecked<scene::Material>(view, member, value, "materials");
                });
        }
    });
}

template <typename ViewOfObject>
std::optional<NodeView> NodeOf(const ViewOfObject& view) {
    if (view.Get().node == scene::kNone) return std::nullopt;
    return NodeView{view.scene, view.Get().node};
}

void BindLights(py::module_& module) {
    auto light = BindView<LightView>(module, "Light",
                                     "A light, in cd or, a directional one, lx; along -z of its node.");
    light.def_property_readonly("kind", [](const LightView& view) { return Name(view.Get().type); })
        .def_property_readonly("node", &NodeOf<LightView>);
    std::apply(
        [&](const auto&... fields) {
            const auto bind = [&](const auto& field) {
                const auto member = field.member;
                light.def_property(
                    AttributeName(field.name).c_str(),
                    [member](const LightView& view) { return ToPython(view.Get().*member); },
                    [member](const LightView& view, const py::object& value) {
                        SetChecked<scene::Light>(view, member, value, "lights");
                    });
            };
            (bind(fields), ...);
        },
        scene::light_fields::kAll);
}

void BindCameras(py::module_& module) {
    const auto number = [](const char* name, float scene::Camera::*member) {
        return std::pair([member](const CameraView& view) { return view.Get().*member; },
                         [name, member](const CameraView& view, float value) {
                             SetCameraField(*view.scene, view.index, member, value, name);
                         });
    };
    const auto yFov = number("y_fov", &scene::Camera::yFov), xMag = number("x_mag", &scene::Camera::xMag),
               yMag = number("y_mag", &scene::Camera::yMag);
    BindView<CameraView>(
        module, "Camera",
        "A camera, along -z of its node: perspective with the vertical angle y_fov in radians, or "
        "orthographic with half the width and height x_mag and y_mag in meters.")
        .def_property_readonly("node", &NodeOf<CameraView>)
        .def_property_readonly(
            "orthographic",
            [](const CameraView& view) { return view.Get().projection == scene::Projection::Orthographic; })
        .def_property("y_fov", yFov.first, yFov.second)
        .def_property("x_mag", xMag.first, xMag.second)
        .def_property("y_mag", yMag.first, yMag.second);
}

// --- Scenes made of arrays ---

NodeView MakeNode(const ScenePtr& scene, std::string name, const std::optional<NodeView>& parent,
                  const std::optional<Doubles>& matrix) {
    if (parent && parent->scene != scene) throw Error(ErrorKind::Usage, "parent: it is of another scene");
    scene::Node node{.name = std::move(name)};
    if (matrix) {
        const scene::PlacedTransform placed = TransformOf(*matrix);
        node.matrix = placed.matrix;
        node.translationResidual = placed.rest;
    }
    if (parent) node.parent = parent->index;
    return {scene, AddNode(*scene, std::move(node))};
}

MaterialView MakeMaterial(const ScenePtr& scene, std::string name) {
    return {scene, AddMaterial(*scene, std::move(name))};
}

std::vector<uint32_t> IndicesOf(const py::object& value, size_t vertexCount) {
    std::vector<uint32_t> indices;
    if (value.is_none()) {
        for (uint32_t i = 0; i < vertexCount; ++i) indices.push_back(i);
    } else {
        const py::array given = py::array::ensure(value);
        const char kind = given ? given.dtype().kind() : ' ';
        const bool isTriples = given && (given.ndim() == 1 || (given.ndim() == 2 && given.shape(1) == 3));
        if ((kind != 'i' && kind != 'u') || !isTriples)
            throw MakeError(ErrorKind::Usage, "indices: they are integers of (n, 3) or (3 n,)");
        const py::array_t<int64_t, py::array::c_style | py::array::forcecast> numbers(given);
        for (py::ssize_t i = 0; i < numbers.size(); ++i) {
            const int64_t index = numbers.data()[i];
            if (index < 0 || static_cast<uint64_t>(index) >= vertexCount)
                throw MakeError(ErrorKind::Usage, "indices: {} is not below the {} positions", index,
                                vertexCount);
            indices.push_back(static_cast<uint32_t>(index));
        }
    }
    return indices;
}

NodeView Place(const ScenePtr& scene, scene::Primitive primitive, std::optional<MaterialView> material,
               const std::string& name, const std::optional<NodeView>& parent,
               const std::optional<Doubles>& matrix) {
    if (material && material->scene != scene)
        throw Error(ErrorKind::Usage, "material: it is of another scene");
    const NodeView node = MakeNode(scene, name, parent, matrix);
    if (!material) material = MakeMaterial(scene, name);
    primitive.material = material->index;
    AddInstance(*scene, node.index, AddMesh(*scene, std::move(primitive), name));
    return node;
}

NodeView AddTriangles(const ScenePtr& scene, const Floats& positions, const py::object& indices,
                      const std::optional<Floats>& normals, const std::optional<Floats>& uvs,
                      const std::optional<Floats>& colors, const std::optional<Floats>& tangents,
                      const std::optional<MaterialView>& material, const std::string& name,
                      const std::optional<NodeView>& parent, const std::optional<Doubles>& matrix) {
    scene::Primitive primitive;
    primitive.positions = RowsOf<3>("positions", positions);
    primitive.indices = IndicesOf(indices, primitive.positions.size());
    if (uvs) primitive.uv0 = RowsOf<2>("uvs", *uvs);
    if (colors) {
        if (colors->ndim() == 2 && colors->shape(1) == 3)
            for (const glm::vec3& color : RowsOf<3>("colors", *colors))
                primitive.colors.push_back({color, 1.0f});
        else
            primitive.colors = RowsOf<4>("colors", *colors);
    }
    if (normals) primitive.normals = RowsOf<3>("normals", *normals);
    if (tangents) primitive.tangents = RowsOf<4>("tangents", *tangents);
    CompleteTriangles(primitive);
    return Place(scene, std::move(primitive), material, name, parent, matrix);
}

NodeView AddSpheres(const ScenePtr& scene, const Floats& centers, const py::object& radii,
                    const std::optional<Floats>& colors, const std::optional<MaterialView>& material,
                    const std::string& name, const std::optional<NodeView>& parent,
                    const std::optional<Doubles>& matrix) {
    scene::Primitive primitive;
    primitive.positions = RowsOf<3>("centers", centers);
    const size_t count = primitive.positions.size();
    const Floats given = Floats::ensure(radii);
    if (!given) throw Error(ErrorKind::Usage, "radii: they are no numbers");
    if (given.size() != 1 && static_cast<size_t>(given.size()) != count)
        throw MakeError(ErrorKind::Usage, "radii: there are {}, and {} centers", given.size(), count);
    for (uint32_t i = 0; i < count; ++i) {
        primitive.indices.insert(primitive.indices.end(), 2, i);
        const float radius = given.data()[given.size() == 1 ? 0 : i];
        if (!(radius >= scene::kMinRadius && radius <= scene::kMaxRadius))
            throw MakeError(ErrorKind::Usage, "radii: {} is not {} to {}", radius, scene::kMinRadius,
                            scene::kMaxRadius);
        primitive.radii.push_back(radius);
    }
    if (colors) {
        for (const glm::vec3& color : RowsOf<3>("colors", *colors)) primitive.colors.push_back({color, 1.0f});
        if (primitive.colors.size() != count)
            throw MakeError(ErrorKind::Usage, "colors: there are {}, and {} centers", primitive.colors.size(),
                            count);
    }
    primitive.bounds = scene::RoundBounds(primitive);
    return Place(scene, std::move(primitive), material, name, parent, matrix);
}

LightView MakeLight(const ScenePtr& scene, const std::string& kind, std::string name,
                    const std::optional<NodeView>& parent, const std::optional<Doubles>& matrix) {
    for (const scene::LightType type : Values<scene::LightType>())
        if (kind == Name(type)) {
            const NodeView node = MakeNode(scene, name, parent, matrix);
            return {scene, AddLight(*scene, node.index, type, std::move(name))};
        }
    throw MakeError(ErrorKind::Usage, "kind: {} is none of directional, point, spot", Quoted(kind));
}

CameraView MakeCamera(const ScenePtr& scene, std::string name, bool isOrthographic,
                      const std::optional<NodeView>& parent, const std::optional<Doubles>& matrix) {
    const NodeView node = MakeNode(scene, name, parent, matrix);
    return {scene,
            AddCamera(*scene, node.index,
                      isOrthographic ? scene::Projection::Orthographic : scene::Projection::Perspective,
                      std::move(name))};
}

void SetMap(Scene& scene, const Floats& map, std::string name) {
    if (map.ndim() != 3 || map.shape(2) < 3 || map.shape(2) > 4)
        throw MakeError(ErrorKind::Usage, "environment: the shape is {}, not (height, width, 3)",
                        ShapeText(map));
    image::ImageF image{static_cast<uint32_t>(map.shape(1)), static_cast<uint32_t>(map.shape(0)), {}};
    const auto channels = static_cast<size_t>(map.shape(2));
    const size_t count = size_t{image.width} * image.height;
    image.rgba.assign(4 * count, 1.0f);
    for (size_t i = 0; i < count; ++i)
        std::copy_n(map.data() + i * channels, 3, image.rgba.begin() + static_cast<ptrdiff_t>(4 * i));
    SetEnvironmentMap(scene, std::move(image), std::move(name));
}

}  // namespace

void BindScene(py::module_& module) {
    BindNodes(module);
    BindMaterials(module);
    BindLights(module);
    BindCameras(module);
    py::class_<Scene, ScenePtr>(module, "Scene",
                                "A scene, to be rendered and edited; Scene() is empty. Units are those of "
                                "glTF: meters, radians, candela "
                                "and lux; +y is up.")
        .def(py::init([] {
            auto scene = std::make_shared<Scene>();
            scene->input = MakeInput({}, "python");
            return scene;
        }))
        .def_property_readonly("file", [](const Scene& scene) { return scene.input.file; })
        .def_property_readonly("bounds",
                               [](Scene& scene) -> py::object {
                                   scene.Update();
                                   const scene::Bounds& box = scene.input.data.bounds;
                                   if (box.IsEmpty()) return py::none();
                                   return py::make_tuple(TupleOf<3>(box.min), TupleOf<3>(box.max));
                               })
        .def_property_readonly(
            "nodes",
            [](const ScenePtr& scene) { return ViewsOf<NodeView>(scene, scene->input.data.nodes.size()); })
        .def_property_readonly("materials",
                               [](const ScenePtr& scene) {
                                   return ViewsOf<MaterialView>(scene, scene->input.data.materials.size());
                               })
        .def_property_readonly(
            "lights",
            [](const ScenePtr& scene) { return ViewsOf<LightView>(scene, scene->input.data.lights.size()); })
        .def_property_readonly("cameras",
                               [](const ScenePtr& scene) {
                                   return ViewsOf<CameraView>(scene, scene->input.data.cameras.size());
                               })
        .def("add_node", &MakeNode, py::arg("name") = "", py::kw_only(), py::arg("parent") = py::none(),
             py::arg("matrix") = py::none(), "Adds a node that places nothing, and returns it.")
        .def("add_mesh", &AddTriangles, py::arg("positions"), py::arg("indices") = py::none(), py::kw_only(),
             py::arg("normals") = py::none(), py::arg("uvs") = py::none(), py::arg("colors") = py::none(),
             py::arg("tangents") = py::none(), py::arg("material") = py::none(), py::arg("name") = "",
             py::arg("parent") = py::none(), py::arg("matrix") = py::none(),
             "Adds triangles and returns the node that places them. positions: (n, 3), meters. indices: "
             "integers of "
             "(m, 3) or (3 m,), counter-clockwise from the front; None: each three positions are a triangle. "
             "normals: (n, 3); None: those of the triangles. uvs: (n, 2), (0, 0) is the upper left corner of "
             "a "
             "texture. colors: (n, 3 or 4), linear. tangents: (n, 4), for normal maps. material: None is a "
             "new one. "
             "matrix: (4, 4), of column vectors. Raises Error of kind usage.")
        .def("add_spheres", &AddSpheres, py::arg("centers"), py::arg("radii"), py::kw_only(),
             py::arg("colors") = py::none(), py::arg("material") = py::none(), py::arg("name") = "",
             py::arg("parent") = py::none(), py::arg("matrix") = py::none(),
             "Adds spheres and returns the node that places them. centers: (n, 3); radii: (n,) or one "
             "number, meters; "
             "colors: (n, 3), linear.")
        .def("_add_material", &MakeMaterial)
        .def("_add_light", &MakeLight)
        .def("_add_camera", &MakeCamera)
        .def("_load_environment",
             [](Scene& scene, const std::filesystem::path& path) {
                 WithoutGil([&] {
                     LoadEnvironmentMap(scene, path, LogToPython());
                     return 0;
                 });
             })
        .def("_set_environment", &SetMap);
    module.def("load", &Load);
}

}  // namespace raygraph::python
