#include "tests/scene/gltf_document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <fstream>
#include <string_view>
#include <type_traits>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/support/error_of.h"

namespace raygraph::test {
namespace {

void AppendU32(Bytes& bytes, uint32_t value) {
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFFu));
}

void AppendChunk(Bytes& bytes, std::string_view type, std::span<const std::byte> content, std::byte padding) {
    const size_t padded = (content.size() + 3) / 4 * 4;
    AppendU32(bytes, static_cast<uint32_t>(padded));
    for (const char c : type) bytes.push_back(static_cast<std::byte>(c));
    bytes.insert(bytes.end(), content.begin(), content.end());
    bytes.insert(bytes.end(), padded - content.size(), padding);
}

}  // namespace

Bytes ToBytes(std::string_view text) {
    Bytes bytes(text.size());
    if (!text.empty()) std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

std::string DataUri(std::span<const std::byte> bytes) {
    constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string uri = "data:application/octet-stream;base64,";
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? std::to_integer<uint32_t>(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k)
            uri += i + k > bytes.size() ? '=' : kAlphabet[bits >> (6 * (3 - k)) & 63u];
    }
    return uri;
}

GltfDocument::GltfDocument() {
    json["asset"]["version"] = "2.0";
    json["scene"] = 0;
    json["scenes"] = Json::array({Json::object()});
}

size_t GltfDocument::Add(const char* array, const Json& value) {
    json[array].push_back(value);
    return json[array].size() - 1;
}

size_t GltfDocument::AddBufferView(const Bytes& bytes) {
    const size_t buffer = Add("buffers", {{"byteLength", bytes.size()}, {"uri", DataUri(bytes)}});
    return Add("bufferViews", {{"buffer", buffer}, {"byteLength", bytes.size()}});
}

size_t GltfDocument::AddAccessorOver(size_t view, int componentType, size_t count, size_t components,
                                     bool isNormalized) {
    constexpr std::array<const char*, 5> kTypes{"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    Json accessor{{"bufferView", view},
                  {"componentType", componentType},
                  {"count", count},
                  {"type", kTypes.at(components)}};
    if (isNormalized) accessor["normalized"] = true;
    return Add("accessors", accessor);
}

size_t GltfDocument::AddMesh(const Json& primitive) {
    return Add("meshes", {{"primitives", Json::array({primitive})}});
}

size_t GltfDocument::AddMaterial(const Json& material) {
    return Add("materials", material);
}

size_t GltfDocument::AddNode(const Json& node) {
    const size_t index = Add("nodes", node);
    json["scenes"][0]["nodes"].push_back(index);
    return index;
}

Json& GltfDocument::AddTriangle() {
    const size_t positions = AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
    const size_t normals = AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    const size_t mesh = AddMesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}});
    AddNode({{"mesh", mesh}});
    return json["meshes"][mesh]["primitives"][0];
}

SceneFolder::SceneFolder() : m_path(std::filesystem::canonical(m_folder.Path())) {}

std::filesystem::path SceneFolder::Write(std::string_view name, std::span<const std::byte> bytes) const {
    const std::filesystem::path path = m_path / name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file) throw std::runtime_error("cannot write " + path.string());
    return path;
}

std::filesystem::path SceneFolder::Write(std::string_view name, std::string_view text) const {
    return Write(name, ToBytes(text));
}

scene::SceneData SceneFolder::Load(std::span<const std::byte> file, scene::LoadOptions options) {
    options.reader = this;
    return scene::LoadGltf(Write("scene.gltf", file), options);
}

scene::SceneData SceneFolder::Load(const GltfDocument& document, scene::LoadOptions options) {
    return Load(ToBytes(document.Text()), std::move(options));
}

std::string SceneFolder::LoadError(std::span<const std::byte> file, scene::LoadOptions options) {
    const std::string text =
        testing::ErrorTextOf([&] { Load(file, std::move(options)); }, ErrorKind::BadInput);
    return text == "accepted" ? "loaded" : text;
}

std::string SceneFolder::LoadError(const GltfDocument& document, scene::LoadOptions options) {
    return LoadError(ToBytes(document.Text()), std::move(options));
}

std::vector<std::byte> SceneFolder::Read(const std::filesystem::path& path, uint64_t maxBytes) {
    reads.push_back(path);
    const auto found = replacements.find(path);
    return found == replacements.end() ? m_disk.Read(path, maxBytes) : found->second;
}

scene::SceneData Load(const GltfDocument& document, const scene::LoadOptions& options) {
    return SceneFolder().Load(document, options);
}

std::string LoadError(const GltfDocument& document, const scene::LoadOptions& options) {
    return SceneFolder().LoadError(document, options);
}

void ExpectRefused(const GltfDocument& document, const std::vector<RefusedChange>& changes) {
    for (const RefusedChange& change : changes) {
        GltfDocument changed = document;
        changed.json[Json::json_pointer(change.where)] = change.value;
        const std::string start = change.message == std::string_view("loaded") ? "" : "scene.gltf: ";
        EXPECT_EQ(LoadError(changed), start + change.message) << change.where << " is " << change.value;
    }
}

const scene::Primitive& OnlyPrimitive(const scene::SceneData& scene) {
    static const scene::Primitive kNothing;
    EXPECT_EQ(scene.instances.size(), 1u);
    if (scene.instances.size() != 1) return kNothing;
    const scene::Mesh& mesh = scene.meshes[scene.instances[0].mesh];
    EXPECT_EQ(mesh.primitives.size(), 1u);
    return mesh.primitives.size() == 1 ? mesh.primitives[0] : kNothing;
}

Bytes MakeGlb(std::string_view json, const Bytes* binary) {
    Bytes chunks;
    AppendChunk(chunks, "JSON", ToBytes(json), std::byte{' '});
    if (binary) AppendChunk(chunks, std::string_view("BIN\0", 4), *binary, std::byte{0});
    Bytes file = ToBytes("glTF");
    AppendU32(file, 2);
    AppendU32(file, static_cast<uint32_t>(12 + chunks.size()));
    file.insert(file.end(), chunks.begin(), chunks.end());
    return file;
}

Bytes MakePng(uint32_t width, uint32_t height, std::array<uint8_t, 4> color) {
    std::vector<uint8_t> rgba;
    for (uint32_t i = 0; i < width * height; ++i) rgba.insert(rgba.end(), color.begin(), color.end());
    return MakePngOf(width, height, rgba);
}

Bytes MakePngOf(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba) {
    const TemporaryFolder folder;
    image::WritePng(folder / "image.png", {.width = width, .height = height, .rgba = rgba});
    return scene::DiskFileReader().Read(std::filesystem::canonical(folder / "image.png"), 1u << 30);
}

size_t AddMatrices(GltfDocument& document, const std::vector<float>& values) {
    const size_t view = document.AddBufferView(BytesOf(values));
    return document.Add(
        "accessors",
        {{"bufferView", view}, {"componentType", kFloat}, {"count", values.size() / 16}, {"type", "MAT4"}});
}

size_t AddAnimation(GltfDocument& document, size_t input, size_t output, const Json& target,
                    const char* interpolation) {
    const Json sampler{{"input", input}, {"output", output}, {"interpolation", interpolation}};
    return document.Add("animations", {{"samplers", Json::array({sampler})},
                                       {"channels", Json::array({{{"sampler", 0}, {"target", target}}})}});
}

Json Pointer(const std::string& pointer) {
    return {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}};
}

size_t Animate(GltfDocument& document, const Json& target, const std::vector<float>& times,
               const std::vector<float>& values, size_t components, const char* interpolation) {
    const size_t input = document.AddAccessor<float>(times, 1);
    const size_t output = document.AddAccessor<float>(values, components);
    return AddAnimation(document, input, output, target, interpolation);
}

GltfDocument SkinnedTriangle() {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"]["JOINTS_0"] =
        document.AddAccessor<uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, 4);
    primitive["attributes"]["WEIGHTS_0"] =
        document.AddAccessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, 4);
    document.AddNode({{"name", "first"}});
    document.AddNode({{"name", "second"}, {"translation", {1, 0, 0}}});
    const size_t binds = AddMatrices(document, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                                1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1});
    document.Add("skins", {{"name", "bones"}, {"joints", {1, 2}}, {"inverseBindMatrices", binds}});
    document.json["nodes"][0]["skin"] = 0;
    return document;
}

namespace {

// Returns whether the type can be compared as a whole. Bounds follow from what is compared.
template <typename T>
constexpr bool kIsValue = std::equality_comparable<T>;
template <typename T>
constexpr bool kIsValue<std::vector<T>> = kIsValue<T>;

// Compares all of their fields that are values, except for these.
template <typename T, typename... Members>
void ExpectSameFields(const T& a, const T& b, Members... others) {
    scene::ForEachField<T>([&](const auto& field) {
        if constexpr (kIsValue<typename std::decay_t<decltype(field)>::Value>)
            if (((field.name != std::string_view(others)) && ...)) {
                EXPECT_EQ(a.*field.member, b.*field.member) << field.name;
            }
    });
}

void ExpectSamePrimitive(const scene::Primitive& a, const scene::Primitive& b) {
    ExpectSameFields(a, b);
    ExpectSameFields(a.influences, b.influences);
    ASSERT_EQ(a.targets.size(), b.targets.size());
    for (size_t i = 0; i < a.targets.size(); ++i) ExpectSameFields(a.targets[i], b.targets[i]);
}

void ExpectSameMotion(const scene::SceneData& a, const scene::SceneData& b) {
    ASSERT_EQ(a.skins.size(), b.skins.size());
    for (size_t i = 0; i < a.skins.size(); ++i) ExpectSameFields(a.skins[i], b.skins[i]);
    ASSERT_EQ(a.animations.size(), b.animations.size());
    for (size_t i = 0; i < a.animations.size(); ++i) {
        const scene::Animation &first = a.animations[i], &second = b.animations[i];
        EXPECT_EQ(first.name, second.name);
        EXPECT_EQ(first.duration, second.duration);
        ASSERT_EQ(first.samplers.size(), second.samplers.size());
        for (size_t k = 0; k < first.samplers.size(); ++k)
            ExpectSameFields(first.samplers[k], second.samplers[k]);
        ASSERT_EQ(first.channels.size(), second.channels.size());
        for (size_t k = 0; k < first.channels.size(); ++k)
            ExpectSameFields(first.channels[k], second.channels[k]);
    }
}

}  // namespace

float Apart(const glm::mat4x3& a, const glm::mat4x3& b) {
    float most = 0.0f;
    for (int i = 0; i < 4; ++i) most = std::max(most, glm::length(a[i] - b[i]));
    return most;
}

void ExpectSame(const scene::SceneData& a, const scene::SceneData& b, float tolerance) {
    ExpectSameMotion(a, b);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.nodeOrder, b.nodeOrder);
    ASSERT_EQ(a.nodes.size(), b.nodes.size());
    for (size_t i = 0; i < a.nodes.size(); ++i) {
        ExpectSameFields(a.nodes[i], b.nodes[i], "translation", "translationResidual", "rotation", "scale",
                         "matrix");
        EXPECT_LE(Apart(a.nodes[i].LocalTransform(), b.nodes[i].LocalTransform()), tolerance) << "node " << i;
    }
    ASSERT_EQ(a.meshes.size(), b.meshes.size());
    for (size_t i = 0; i < a.meshes.size(); ++i) {
        ASSERT_EQ(a.meshes[i].primitives.size(), b.meshes[i].primitives.size());
        EXPECT_EQ(a.meshes[i].weights, b.meshes[i].weights);
        for (size_t k = 0; k < a.meshes[i].primitives.size(); ++k)
            ExpectSamePrimitive(a.meshes[i].primitives[k], b.meshes[i].primitives[k]);
    }
    ASSERT_EQ(a.materials.size(), b.materials.size());
    for (size_t i = 0; i < a.materials.size(); ++i) ExpectSameFields(a.materials[i], b.materials[i]);
    ASSERT_EQ(a.textures.size(), b.textures.size());
    for (size_t i = 0; i < a.textures.size(); ++i) ExpectSameFields(a.textures[i], b.textures[i]);
    ASSERT_EQ(a.images.size(), b.images.size());
    for (size_t i = 0; i < a.images.size(); ++i) ExpectSameFields(a.images[i], b.images[i]);
    ASSERT_EQ(a.instances.size(), b.instances.size());
    for (size_t i = 0; i < a.instances.size(); ++i) {
        EXPECT_EQ(a.instances[i].mesh, b.instances[i].mesh);
        EXPECT_EQ(a.instances[i].node, b.instances[i].node);
        EXPECT_EQ(a.instances[i].objectToNode, b.instances[i].objectToNode);
        // Saved node transforms are rounded to float: positions far from the origin differ by a few of its
        // steps
        const float steps = 4e-7f * glm::length(a.instances[i].objectToWorld[3]);
        EXPECT_LE(Apart(a.instances[i].objectToWorld, b.instances[i].objectToWorld), tolerance + steps);
    }
    ASSERT_EQ(a.cameras.size(), b.cameras.size());
    for (size_t i = 0; i < a.cameras.size(); ++i)
        ExpectSameFields(a.cameras[i], b.cameras[i], "cameraToWorld", "translationResidual");
    ASSERT_EQ(a.lights.size(), b.lights.size());
    for (size_t i = 0; i < a.lights.size(); ++i) {
        EXPECT_EQ(a.lights[i].name, b.lights[i].name);
        EXPECT_EQ(a.lights[i].node, b.lights[i].node);
        ASSERT_EQ(a.lights[i].type, b.lights[i].type);
        scene::ForEachLightField(a.lights[i], [&](const auto& field) {
            EXPECT_EQ(a.lights[i].*field.member, b.lights[i].*field.member) << i << ' ' << field.name;
        });
    }
}

}  // namespace raygraph::test
