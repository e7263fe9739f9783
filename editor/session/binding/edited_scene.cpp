#include "editor/session/binding/edited_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.h"
#include "editor/session/file/content_hash.h"
#include "editor/session/settings/as_input.h"
#include "editor/session/settings/light_settings.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/check.h"

namespace raygraph::session {

void EditedScene::Update() {
    if (!isEdited) return;
    scene::UpdateWorldTransforms(input.data);
    scene::Check(input.data);
    input.statistics = scene::Statistics(input.data);
    input.hash = HashOf(input.data);
    isEdited = false;
}

SceneInput EditedScene::InputFor(bool isAnimated) const {
    SceneInput copy = input;
    copy.isAnimated = isAnimated;
    if (!isAnimated) AsInput([&] { scene::FreezePose(copy.data, {}); });
    return copy;
}

PictureSettings SettingsFor(const EditedScene& scene, SettingTexts texts) {
    HideBehindGround(texts);
    PictureSettings settings = SettingsFrom(texts);
    settings.scene = scene.input.scene;
    settings.variant = scene.input.variant;
    settings.pointsAndLines = scene.input.pointsAndLines;
    return settings;
}

scene::PlacedTransform TransformOf(std::span<const double, 16> matrix) {
    scene::PlacedTransform placed;
    for (int column = 0; column < 4; ++column) {
        const double* from = &matrix[static_cast<size_t>(4 * column)];
        if (from[3] != (column == 3 ? 1.0 : 0.0))
            throw Error(ErrorKind::Usage, "matrix: its last row is not 0, 0, 0, 1");
        placed.matrix[column] = glm::vec3(glm::dvec3(from[0], from[1], from[2]));
    }
    if (!scene::IsFinite(placed.matrix)) throw Error(ErrorKind::Usage, "matrix: it is not finite");
    placed.rest = scene::ToFloatPair({matrix[12], matrix[13], matrix[14]}).rest;
    return placed;
}

std::array<double, 16> MatrixOf(const scene::PlacedTransform& placed) {
    std::array<double, 16> matrix{};
    for (int column = 0; column < 4; ++column) {
        const glm::dvec3 from = column == 3 ? placed.Place() : glm::dvec3(placed.matrix[column]);
        for (int row = 0; row < 3; ++row) matrix[static_cast<size_t>(4 * column + row)] = from[row];
    }
    matrix[15] = 1.0;
    return matrix;
}

uint32_t AddNode(EditedScene& scene, scene::Node node) {
    scene::SceneData& data = scene.Edit();
    const auto index = static_cast<uint32_t>(data.nodes.size());
    data.nodes.push_back(std::move(node));
    data.nodeOrder.push_back(index);
    return index;
}

uint32_t AddMaterial(EditedScene& scene, std::string name) {
    std::vector<scene::Material>& materials = scene.Edit().materials;
    materials.push_back({.name = std::move(name)});
    return static_cast<uint32_t>(materials.size() - 1);
}

uint32_t AddLight(EditedScene& scene, uint32_t node, scene::LightType type, std::string name) {
    std::vector<scene::Light>& lights = scene.Edit().lights;
    lights.push_back({.name = std::move(name), .node = node, .type = type});
    return static_cast<uint32_t>(lights.size() - 1);
}

uint32_t AddCamera(EditedScene& scene, uint32_t node, scene::Projection projection, std::string name) {
    std::vector<scene::Camera>& cameras = scene.Edit().cameras;
    cameras.push_back({.name = std::move(name), .node = node, .projection = projection});
    return static_cast<uint32_t>(cameras.size() - 1);
}

uint32_t AddMesh(EditedScene& scene, scene::Primitive primitive, std::string name) {
    std::vector<scene::Mesh>& meshes = scene.Edit().meshes;
    meshes.push_back({.name = std::move(name), .primitives = {}});
    meshes.back().primitives.push_back(std::move(primitive));
    return static_cast<uint32_t>(meshes.size() - 1);
}

uint32_t AddInstance(EditedScene& scene, uint32_t node, uint32_t mesh) {
    scene::SceneData& data = scene.Edit();
    data.nodes[node].mesh = mesh;
    data.instances.push_back({.mesh = mesh, .node = node});
    return static_cast<uint32_t>(data.instances.size() - 1);
}

namespace {

// Gives each triangle its own vertices and normal, as the importer does to meshes without normals.
void MakeFlat(scene::Primitive& primitive) {
    const auto split = [&](auto& stream) {
        if (stream.empty()) return;
        auto own = stream;
        own.clear();
        for (const uint32_t index : primitive.indices) own.push_back(stream[index]);
        stream = std::move(own);
    };
    split(primitive.positions);
    split(primitive.uv0);
    split(primitive.colors);
    for (size_t i = 0; i < primitive.indices.size(); ++i) primitive.indices[i] = static_cast<uint32_t>(i);
    for (size_t i = 0; i + 2 < primitive.positions.size(); i += 3) {
        const glm::dvec3 a(primitive.positions[i]), b(primitive.positions[i + 1]),
            c(primitive.positions[i + 2]);
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        const double length = glm::length(normal);
        primitive.normals.insert(primitive.normals.end(), 3,
                                 length > 0.0 ? glm::vec3(normal / length) : glm::vec3(0.0f, 0.0f, 1.0f));
    }
    primitive.hasFlatNormals = true;
}

template <typename Rows>
void CheckStream(const char* name, const Rows& rows, size_t count) {
    if (!rows.empty() && rows.size() != count)
        throw MakeError(ErrorKind::Usage, "{}: there are {}, and {} positions", name, rows.size(), count);
    for (const auto& row : rows)
        for (int i = 0; i < row.length(); ++i)
            if (!std::isfinite(row[i])) throw MakeError(ErrorKind::Usage, "{}: one is not finite", name);
}

}  // namespace

void CompleteTriangles(scene::Primitive& primitive) {
    const size_t count = primitive.positions.size();
    CheckStream("positions", primitive.positions, count);
    CheckStream("normals", primitive.normals, count);
    CheckStream("uvs", primitive.uv0, count);
    CheckStream("colors", primitive.colors, count);
    CheckStream("tangents", primitive.tangents, count);
    for (const uint32_t index : primitive.indices)
        if (index >= count)
            throw MakeError(ErrorKind::Usage, "indices: {} is not below the {} positions", index, count);
    if (primitive.indices.size() % 3 != 0)
        throw MakeError(ErrorKind::Usage, "indices: {} are no triangles", primitive.indices.size());
    if (primitive.indices.empty()) throw Error(ErrorKind::Usage, "positions: there is no triangle");
    for (glm::vec3& normal : primitive.normals) {
        const float length = glm::length(normal);
        if (!(length > 0.0f) || !std::isfinite(length))
            throw Error(ErrorKind::Usage, "normals: one has no direction");
        normal /= length;
    }
    if (primitive.normals.empty()) {
        if (!primitive.tangents.empty()) throw Error(ErrorKind::Usage, "tangents: they need normals");
        MakeFlat(primitive);
    }
    primitive.bounds = scene::BoundsOf(primitive.positions);
}

namespace {

// Returns whether a single field of the materials has this texture, and no other texture has its image.
bool HasOneUser(const scene::SceneData& data, int32_t texture) {
    size_t fields = 0;
    for (const scene::Material& material : data.materials)
        scene::ForEachMaterialField([&](const auto& field) {
            if constexpr (std::is_same_v<std::decay_t<decltype(field)>, scene::TextureField>)
                fields += (material.*field.member).texture == texture ? 1 : 0;
        });
    const uint32_t image = data.textures[static_cast<size_t>(texture)].image;
    return fields == 1 && std::ranges::count(data.textures, image, &scene::Texture::image) == 1;
}

}  // namespace

void SetTexture(EditedScene& scene, uint32_t material, const scene::TextureField& field,
                scene::ImageData image) {
    scene::SceneData& data = scene.Edit();
    scene::TextureRef& reference = data.materials[material].*field.member;
    if (image.rgba.empty()) {
        reference = {};
        return;
    }
    if (!reference.IsPresent() || !HasOneUser(data, reference.texture)) {
        data.textures.push_back({.image = static_cast<uint32_t>(data.images.size())});
        data.images.emplace_back();
        reference.texture = static_cast<int32_t>(data.textures.size() - 1);
    }
    scene::Texture& texture = data.textures[static_cast<size_t>(reference.texture)];
    texture = {.name = image.name, .image = texture.image, .colorSpace = field.colorSpace};
    data.images[texture.image] = std::move(image);
}

void SetCameraField(EditedScene& scene, uint32_t camera, float scene::Camera::*member, float value,
                    const std::string& name) {
    scene::Camera edited = scene.input.data.cameras[camera];
    edited.*member = value;
    scene::ForEachCameraField(edited.projection, [&](const auto& field) {
        const float number = edited.*field.member;
        if (!(number >= field.range.min && number <= field.range.max) &&
            !(number == 0.0f && field.range.mayBeZero))
            throw MakeError(ErrorKind::Usage, "cameras[{}]: {} is {}, must be {} to {}", camera,
                            field.member == member ? name : field.name, number, field.range.min,
                            field.range.max);
    });
    scene.Edit().cameras[camera] = std::move(edited);
}

void SetEnvironmentMap(EditedScene& scene, image::ImageF map, std::string name) {
    for (size_t i = 0; i < map.rgba.size(); ++i)
        if (i % 4 != 3 && !(map.rgba[i] >= 0.0f && std::isfinite(map.rgba[i])))
            throw MakeError(ErrorKind::Usage, "environment: {} is no radiance", map.rgba[i]);
    SetEnvironment(scene.input, std::move(map), std::move(name));
}

void LoadEnvironmentMap(EditedScene& scene, const std::filesystem::path& path, const Log& log) {
    SceneInput loaded;
    LoadEnvironment(loaded, path, log);
    scene.input.environment = std::move(loaded.environment);
    scene.input.environmentFile = std::move(loaded.environmentFile);
    scene.input.environmentHash = std::move(loaded.environmentHash);
    scene.input.loadMs += loaded.loadMs;
}

}  // namespace raygraph::session
