// Makes seeds of glTF: the scenes as they are, and the long ones with their buffers and images outside.
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "renderer/scene/gltf/container.h"
#include "tests/fuzz/gltf_files.h"
#include "tests/fuzz/seeds.h"
#include "tests/support/material_extensions.h"
#include "tests/support/source_file.h"

namespace raygraph::fuzz {

namespace {

using Json = nlohmann::ordered_json;

std::string ReadText(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

Bytes ToBytes(std::string_view text) {
    const Input input = AsInput(text);
    return {input.begin(), input.end()};
}

// This small file has everything that is read, except for MaterialExtensions().
constexpr const char* kRich = R"({"asset": {"version": "2.0", "minVersion": "2.0"}, "scene": 0,
"extensionsUsed": ["KHR_lights_punctual", "EXT_texture_webp", "MSFT_texture_dds",
 "KHR_texture_basisu", "X_unknown"],
"extensionsRequired": ["KHR_mesh_quantization", "EXT_mesh_gpu_instancing"],
"scenes": [{"name": "one", "nodes": [0, 1, 4], "extensions": {"EXT_lights_image_based": {"light": 0}}}, {"nodes": []}],
"nodes": [{"name": "a", "camera": 0, "children": [2, 3], "rotation": [0, 0, 0, 1], "translation": [1e3, 2.5, -3]},
 {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1], "skin": 0},
 {"extensions": {"KHR_lights_punctual": {"light": 0}, "KHR_node_visibility": {"visible": false}},
  "scale": [1, 2, -3]},
 {"mesh": 1, "camera": 1, "extensions": {"KHR_lights_punctual": {"light": 1},
  "EXT_lights_ies": {"light": 0, "multiplier": 2, "color": [1, 0.5, 0]}}},
 {"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0, "ROTATION": 5, "SCALE": 0,
  "_ID": 3}}}}],
"extensions": {"EXT_lights_ies": {"lights": [
 {"uri": "data:,TILT=NONE%201%20-1%201%202%201%201%201%200%200%200%201%201%201%200%2090%200%205%207"}]},
"EXT_lights_image_based": {"lights": [{"intensity": 2, "rotation": [0, 1, 0, 0], "specularImageSize": 2,
 "specularImages": [[0, 0, 0, 0, 0, 0]]}]},
"KHR_lights_punctual": {"lights": [
 {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.7}, "color": [1, 0.5, 0.25], "intensity": 9},
 {"type": "directional", "range": 3}]},
 "KHR_materials_variants": {"variants": [{"name": "a"}, {"name": "b"}]}},
"cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1, "zfar": 9, "aspectRatio": 1.5}},
 {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 2, "znear": 0.1, "zfar": 9}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_0": 1, "COLOR_0": 2, "JOINTS_0": 6, "WEIGHTS_0": 2},
  "indices": 3, "material": 0, "mode": 4, "targets": [{"POSITION": 0, "NORMAL": 0}], "extensions": {"KHR_materials_variants":
   {"mappings": [{"material": 1, "variants": [0]}, {"material": 0, "variants": [1]}]}}}], "weights": [0.5]},
 {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_1": 1}, "mode": 5, "material": 1},
  {"attributes": {"POSITION": 0}, "mode": 1}]}],
"skins": [{"joints": [2, 0], "skeleton": 0, "inverseBindMatrices": 8}],
"animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}},
  {"sampler": 1, "target": {"node": 2, "path": "scale"}},
  {"sampler": 2, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer":
   {"pointer": "/materials/0/normalTexture/scale"}}}},
  {"sampler": 2, "target": {"node": 4, "path": "weights"}}],
 "samplers": [{"input": 4, "output": 9, "interpolation": "LINEAR"},
  {"input": 4, "output": 10, "interpolation": "CUBICSPLINE"},
  {"input": 4, "output": 7, "interpolation": "STEP"}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 6, "min": [0, 0, 0], "max": [0, 0, 0],
  "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0}}},
 {"bufferView": 0, "byteOffset": 4, "componentType": 5123, "type": "VEC2", "count": 6, "normalized": true},
 {"bufferView": 0, "componentType": 5121, "type": "VEC4", "count": 6, "normalized": true},
 {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 6},
 {"bufferView": 2, "componentType": 5126, "type": "SCALAR", "count": 2},
 {"bufferView": 0, "componentType": 5122, "type": "VEC4", "count": 6, "normalized": true},
 {"bufferView": 0, "componentType": 5121, "type": "VEC4", "count": 6},
 {"componentType": 5126, "type": "SCALAR", "count": 2},
 {"bufferView": 3, "componentType": 5126, "type": "MAT4", "count": 2},
 {"componentType": 5126, "type": "VEC3", "count": 2},
 {"componentType": 5126, "type": "VEC3", "count": 6}],
"bufferViews": [{"buffer": 0, "byteOffset": 8, "byteLength": 400, "byteStride": 12, "target": 34962},
 {"buffer": 1, "byteLength": 6}, {"buffer": 2, "byteLength": 8}, {"buffer": 3, "byteLength": 128}],
"buffers": [{"uri": "b.bin", "byteLength": 1000},
 {"uri": "data:application/octet-stream;base64,AAECAwQF", "byteLength": 6},
 {"uri": "data:application/octet-stream;base64,AAAAAAAAgD8=", "byteLength": 8},
 {"uri": "data:application/octet-stream;base64,AACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8=",
  "byteLength": 128}],
"images": [{"uri": "i.png", "name": "picture"}, {"uri": "./i.png", "mimeType": "image/png"}],
"samplers": [{"minFilter": 9987, "magFilter": 9728, "wrapS": 33071, "wrapT": 33648}],
"textures": [{"source": 0, "sampler": 0}, {"extensions": {"EXT_texture_webp": {"source": 1},
 "MSFT_texture_dds": {"source": 0}, "KHR_texture_basisu": {"source": 1}}}],
"materials": [{"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1], "metallicFactor": 0.5,
   "roughnessFactor": 0.5, "baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 1}},
  "normalTexture": {"index": 0, "scale": 2,
   "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 1, "scale": [1, 2], "texCoord": 1}}},
  "occlusionTexture": {"index": 1, "strength": 0.5, "texCoord": 1},
  "emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 1], "alphaMode": "MASK", "alphaCutoff": 0.4,
  "doubleSided": true, "extras": {"priority": 3}},
 {"alphaMode": "BLEND", "extensions": {"KHR_materials_unlit": {}}},
 {"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 0.5, 0.25, 1], "specularFactor": [0, 0, 1],
  "glossinessFactor": 0.5, "diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 0}}}}]})";

// Replaces embedded data by the files of SceneFolder.
std::string WithFilesOutside(const std::string& text) {
    Json json = Json::parse(text);
    for (Json& buffer : json["buffers"]) buffer["uri"] = kBufferName;
    if (json.contains("images"))
        for (Json& image : json["images"]) image["uri"] = kImageName;
    return json.dump(1);
}

// Makes the first buffer the BIN chunk, with zeros if it is a file.
Bytes AsGlb(const std::string& text) {
    Json json = Json::parse(text);
    Json& buffer = json["buffers"][0];
    const std::string uri = buffer["uri"];
    const Bytes binary = scene::IsDataUri(uri) ? scene::DecodeDataUri(uri, 1 << 24)
                                               : Bytes(buffer["byteLength"].get<size_t>());
    buffer.erase("uri");
    return MakeGlb(json.dump(), binary);
}

// Returns a .glb of CompressedFile() as text.
std::string WithDataUri(Input glb) {
    uint32_t length = 0;
    std::memcpy(&length, &glb[12], sizeof(length));
    const char* const text = reinterpret_cast<const char*>(&glb[20]);
    Json json = Json::parse(text, text + length);
    Json& buffer = json["buffers"][0];
    std::string uri = "data:,";
    for (const std::byte byte : glb.subspan(size_t{28} + length, buffer["byteLength"].get<size_t>()))
        for (const uint32_t digit :
             {16u, std::to_integer<uint32_t>(byte) >> 4, std::to_integer<uint32_t>(byte) & 15})
            uri += "0123456789ABCDEF%"[digit];
    buffer["uri"] = uri;
    return json.dump(1);
}

}  // namespace

std::vector<Seed> GltfSeeds(std::string_view target) {
    std::vector<Seed> seeds;
    if (target == "gltf_accessors") {
        // The decisions choose nothing, all attributes, sparse parts, or no views
        for (const int present : {0, 2, 255})
            for (const int kinds : {0, 2, 4, 5}) {
                Bytes bytes(64, std::byte{0});
                bytes[0] = static_cast<std::byte>(present);
                bytes[1] = static_cast<std::byte>(kinds);
                seeds.push_back({std::to_string(present) + "_" + std::to_string(kinds), bytes});
            }
        return seeds;
    }
    const auto add = [&](const std::string& name, const std::string& text) {
        Bytes bytes = target == "gltf_container" ? AsGlb(text) : ToBytes(text);
        if (target == "gltf_save") bytes.insert(bytes.begin(), static_cast<std::byte>(seeds.size() % 2));
        seeds.push_back({name, bytes});
    };
    Json rich = Json::parse(kRich);
    rich["materials"][0]["extensions"] = test::MaterialExtensions();
    add("rich", rich.dump());
    if (target != "gltf_container") {
        // A name with broken characters is repaired, and a path with ".." is resolved
        std::string broken = rich.dump();
        broken.replace(broken.find("\"one\""), 5, "\"\\ud83d\xE9\n\\ud83d\\ude00\"");
        broken.replace(broken.find("./i.png"), 7, "x/../%2e/i.png");
        add("repaired", broken);
    }
    for (const Seed& compressed : CompressedSeeds()) {
        const Bytes file = CompressedFile(compressed.bytes);
        if (target == "gltf_container")
            seeds.push_back({compressed.name, file});
        else
            add(compressed.name, WithDataUri(file));
    }
    for (const auto& file : std::filesystem::directory_iterator(test::SourceFile("scenes"))) {
        if (file.path().extension() != ".gltf" || file.file_size() > 400000) continue;
        const std::string text = ReadText(file.path()), stem = file.path().stem().string();
        add(stem, text);
        add(stem + "_outside", WithFilesOutside(text));
    }
    return seeds;
}

}  // namespace raygraph::fuzz
