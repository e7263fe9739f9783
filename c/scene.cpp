// Scenes: loaded from a file, or made of the host's arrays.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "c/call.h"
#include "c/handles.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/check.h"

using raygraph::ErrorKind;
using raygraph::MakeError;
using raygraph::c::Call;
using raygraph::c::Guarded;
using raygraph::c::TextOr;
namespace scene = raygraph::scene;
namespace session = raygraph::session;

namespace raygraph::c {

void RequirePixels(const RgPixels& pixels, size_t bytesPerNumber) {
    if (pixels.data == nullptr) throw Error(ErrorKind::Usage, "pixels: data is NULL");
    if (pixels.width == 0 || pixels.height == 0)
        throw MakeError(ErrorKind::Usage, "pixels: {} x {} have no area", pixels.width, pixels.height);
    if (pixels.channels != 3 && pixels.channels != 4)
        throw MakeError(ErrorKind::Usage, "pixels: there are {} channels, not 3 or 4", pixels.channels);
    const uint64_t row = bytesPerNumber * pixels.channels * pixels.width;
    if (pixels.row_stride != 0 && pixels.row_stride < row)
        throw MakeError(ErrorKind::Usage, "pixels: the row_stride is {}, and a row has {} bytes",
                        pixels.row_stride, row);
}

namespace {

// Returns RGBA, with `opaque` where there are three channels.
template <typename Number>
std::vector<Number> RgbaOf(const RgPixels& pixels, Number opaque) {
    RequirePixels(pixels, sizeof(Number));
    const size_t row = size_t{pixels.channels} * pixels.width;
    const uint64_t stride = pixels.row_stride != 0 ? pixels.row_stride : row * sizeof(Number);
    std::vector<Number> line(row), rgba;
    rgba.reserve(size_t{4} * pixels.width * pixels.height);
    for (uint32_t y = 0; y < pixels.height; ++y) {
        std::memcpy(line.data(), static_cast<const std::byte*>(pixels.data) + y * stride,
                    row * sizeof(Number));
        for (size_t x = 0; x < row; x += pixels.channels) {
            rgba.insert(rgba.end(), &line[x], &line[x] + 3);
            rgba.push_back(pixels.channels == 4 ? line[x + 3] : opaque);
        }
    }
    return rgba;
}

// Returns the rows of an array of the host, which may be null: empty then.
template <int N>
std::vector<glm::vec<N, float>> RowsOf(const float* data, uint64_t stride, uint32_t count) {
    if (data == nullptr) return {};
    std::vector<glm::vec<N, float>> rows(count);
    if (stride == 0) stride = N * sizeof(float);
    for (uint32_t i = 0; i < count; ++i)
        std::memcpy(&rows[i], reinterpret_cast<const std::byte*>(data) + i * stride, N * sizeof(float));
    return rows;
}

std::vector<uint32_t> IndicesOf(const Call& call, const RgMeshDesc& desc) {
    std::vector<uint32_t> indices;
    if (desc.indices == nullptr) {
        if (desc.index_count != 0) call.Refuse("desc.indices is NULL, and index_count is not 0");
        for (uint32_t i = 0; i < desc.vertex_count; ++i) indices.push_back(i);
        return indices;
    }
    if (desc.index_size == 2) {
        const auto* narrow = static_cast<const uint16_t*>(desc.indices);
        indices.assign(narrow, narrow + desc.index_count);
    } else if (desc.index_size == 4 || desc.index_size == 0) {
        const auto* wide = static_cast<const uint32_t*>(desc.indices);
        indices.assign(wide, wide + desc.index_count);
    } else {
        call.Refuse(Text("desc.index_size is {}, not 2 or 4", desc.index_size));
    }
    return indices;
}

void RequireIndex(const Call& call, const char* what, size_t index, size_t count) {
    if (index >= count) call.Refuse(Text("{} {} does not exist: there are {}", what, index, count));
}

const scene::Node& NodeAt(const Call& call, const RgScene& of, uint32_t node) {
    RequireIndex(call, "node", node, of.scene.input.data.nodes.size());
    return of.scene.input.data.nodes[node];
}

void WriteMatrix(const scene::PlacedTransform& placed, double* matrix) {
    std::ranges::copy(session::MatrixOf(placed), matrix);
}

}  // namespace

std::vector<float> FloatsOf(const RgPixels& pixels) {
    return RgbaOf<float>(pixels, 1.0f);
}

}  // namespace raygraph::c

RgResult rg_scene_load(const char* path, const RgLoadDesc* desc, RgScene** scene) {
    return Guarded("rg_scene_load", [&](const Call& call) {
        call.RequiredText(path, "path");
        call.Required(scene, "scene");
        const RgLoadDesc given = call.ReadOr(desc, "desc");
        session::InputOptions options;
        options.scene = TextOr(given.scene);
        options.variant = TextOr(given.variant);
        options.isAnimated = true;
        options.pointsAndLines = {scene::ParseRoundRadius(TextOr(given.points, "off")),
                                  scene::ParseRoundRadius(TextOr(given.lines, "off"))};
        options.environment = TextOr(given.environment);
        options.root = TextOr(given.root);
        options.log = raygraph::c::LogOf(given.log);
        auto loaded = std::make_unique<RgScene>();
        loaded->scene.input = session::LoadInput(path, options);
        *scene = loaded.release();
    });
}

RgResult rg_scene_create(const char* name, RgScene** scene) {
    return Guarded("rg_scene_create", [&](const Call& call) {
        call.Required(scene, "scene");
        auto made = std::make_unique<RgScene>();
        made->scene.input = session::MakeInput({}, call.RequiredText(name, "name"));
        *scene = made.release();
    });
}

void rg_scene_destroy(RgScene* scene) {
    delete scene;
}

RgResult rg_scene_set_transform(RgScene* scene, uint32_t node, const double matrix[16]) {
    return Guarded("rg_scene_set_transform", [&](const Call& call) {
        RgScene& of = call.Required(scene, "scene");
        raygraph::c::NodeAt(call, of, node);
        const scene::PlacedTransform placed = raygraph::c::TransformAt(&call.Required(matrix, "matrix"));
        scene::Node& edited = of.scene.Edit().nodes[node];
        edited.matrix = placed.matrix;
        edited.translationResidual = placed.rest;
    });
}

RgResult rg_scene_get_transform(const RgScene* scene, uint32_t node, double matrix[16]) {
    return Guarded("rg_scene_get_transform", [&](const Call& call) {
        const scene::Node& of = raygraph::c::NodeAt(call, call.Required(scene, "scene"), node);
        raygraph::c::WriteMatrix({of.LocalTransform(), of.translationResidual},
                                 &call.Required(matrix, "matrix"));
    });
}

RgResult rg_scene_get_world_transform(const RgScene* scene, uint32_t node, double matrix[16]) {
    return Guarded("rg_scene_get_world_transform", [&](const Call& call) {
        const RgScene& of = call.Required(scene, "scene");
        raygraph::c::NodeAt(call, of, node);
        raygraph::c::WriteMatrix(scene::WorldTransforms(of.scene.input.data)[node],
                                 &call.Required(matrix, "matrix"));
    });
}

RgResult rg_scene_add_node(RgScene* scene, const char* name, uint32_t parent, const double matrix[16],
                           uint32_t* node) {
    return Guarded("rg_scene_add_node", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        call.Required(node, "node");
        if (parent != RG_NONE) raygraph::c::NodeAt(call, to, parent);
        scene::Node made{.name = TextOr(name), .parent = parent};
        if (matrix != nullptr) {
            const scene::PlacedTransform placed = raygraph::c::TransformAt(matrix);
            made.matrix = placed.matrix;
            made.translationResidual = placed.rest;
        }
        *node = AddNode(to.scene, std::move(made));
        to.structure = RgScene::NextStructure();
    });
}

RgResult rg_scene_add_material(RgScene* scene, const char* name, uint32_t* material) {
    return Guarded("rg_scene_add_material", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        call.Required(material, "material") = AddMaterial(to.scene, TextOr(name));
        to.structure = RgScene::NextStructure();
    });
}

RgResult rg_scene_add_mesh(RgScene* scene, const RgMeshDesc* desc, uint32_t* mesh) {
    return Guarded("rg_scene_add_mesh", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        call.Required(mesh, "mesh");
        const RgMeshDesc given = call.Read(desc, "desc");
        const uint32_t count = given.vertex_count;
        scene::Primitive primitive;
        primitive.material = given.material;
        raygraph::c::RequireIndex(call, "material", given.material, to.scene.input.data.materials.size());
        primitive.positions = raygraph::c::RowsOf<3>(&call.Required(given.positions, "desc.positions"),
                                                     given.position_stride, count);
        primitive.normals = raygraph::c::RowsOf<3>(given.normals, given.normal_stride, count);
        primitive.uv0 = raygraph::c::RowsOf<2>(given.uvs, given.uv_stride, count);
        primitive.colors = raygraph::c::RowsOf<4>(given.colors, given.color_stride, count);
        primitive.tangents = raygraph::c::RowsOf<4>(given.tangents, given.tangent_stride, count);
        primitive.indices = raygraph::c::IndicesOf(call, given);
        session::CompleteTriangles(primitive);
        *mesh = AddMesh(to.scene, std::move(primitive), TextOr(given.name));
        to.structure = RgScene::NextStructure();
    });
}

RgResult rg_scene_add_instance(RgScene* scene, uint32_t node, uint32_t mesh, uint32_t* instance) {
    return Guarded("rg_scene_add_instance", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        call.Required(instance, "instance");
        if (raygraph::c::NodeAt(call, to, node).mesh != scene::kNone)
            call.Refuse(raygraph::Text("node {} places a mesh already", node));
        raygraph::c::RequireIndex(call, "mesh", mesh, to.scene.input.data.meshes.size());
        *instance = AddInstance(to.scene, node, mesh);
        to.structure = RgScene::NextStructure();
    });
}

RgResult rg_scene_add_light(RgScene* scene, uint32_t node, RgLightKind kind, const char* name,
                            uint32_t* light) {
    return Guarded("rg_scene_add_light", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        call.Required(light, "light");
        raygraph::c::NodeAt(call, to, node);
        if (kind > RG_LIGHT_SPOT) call.Refuse(raygraph::Text("{} is no kind of light", kind));
        *light = AddLight(to.scene, node, static_cast<scene::LightType>(kind), TextOr(name));
        to.structure = RgScene::NextStructure();
    });
}

RgResult rg_scene_add_camera(RgScene* scene, uint32_t node, const char* name, uint32_t* camera) {
    return Guarded("rg_scene_add_camera", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        call.Required(camera, "camera");
        raygraph::c::NodeAt(call, to, node);
        *camera = session::AddCamera(to.scene, node, scene::Projection::Perspective, TextOr(name));
    });
}

RgResult rg_scene_set_environment(RgScene* scene, const RgPixels* pixels, const char* name) {
    return Guarded("rg_scene_set_environment", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        const RgPixels given = call.Read(pixels, "pixels");
        session::SetEnvironmentMap(to.scene, {given.width, given.height, raygraph::c::FloatsOf(given)},
                                   call.RequiredText(name, "name"));
        to.structure = RgScene::NextStructure();
    });
}

RgResult rg_scene_load_environment(RgScene* scene, const char* path, const RgLog* log) {
    return Guarded("rg_scene_load_environment", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        session::LoadEnvironmentMap(to.scene, call.RequiredText(path, "path"),
                                    log == nullptr ? raygraph::Log() : raygraph::c::LogOf(*log));
        to.structure = RgScene::NextStructure();
    });
}

RgResult rg_scene_set_texture(RgScene* scene, uint32_t material, const char* name, const RgPixels* pixels) {
    return Guarded("rg_scene_set_texture", [&](const Call& call) {
        RgScene& to = call.Required(scene, "scene");
        call.RequiredText(name, "name");
        raygraph::c::RequireIndex(call, "material", material, to.scene.input.data.materials.size());
        std::optional<scene::TextureField> field;
        std::string names;
        scene::ForEachMaterialField([&](const auto& each) {
            if constexpr (std::is_same_v<std::decay_t<decltype(each)>, scene::TextureField>) {
                if (std::string_view(each.name) == name) field = each;
                names += std::string(names.empty() ? "" : ", ") + each.name;
            }
        });
        if (!field)
            call.Refuse(raygraph::Text("{} is no texture of a material; there are {}", raygraph::Quoted(name),
                                       names));
        scene::ImageData image{.name = to.scene.input.data.materials[material].name + "." + name};
        if (pixels != nullptr) {
            const RgPixels given = call.Read(pixels, "pixels");
            image.width = given.width;
            image.height = given.height;
            image.rgba = raygraph::c::RgbaOf<uint8_t>(given, 255);
        }
        SetTexture(to.scene, material, *field, std::move(image));
        to.structure = RgScene::NextStructure();
    });
}
