// Fuzzes compressed geometry: the first bytes choose its container and the number of elements, the others are
// the compressed data.
#include <nlohmann/json.hpp>

#include "tests/fuzz/gltf_files.h"

namespace raygraph::fuzz {

namespace {

using Json = nlohmann::json;

// Tells from what a triangle of an otherwise valid file is read.
struct Kind {
    const char* mode;    // "": Draco
    const char* filter;  // nullptr: none
    uint32_t stride;
    const char* attribute;  // "": indices
    int componentType;
    const char* shape;
};
constexpr std::array<Kind, 9> kKinds{{{"", nullptr, 0, "POSITION", 5126, "VEC3"},
                                      {"ATTRIBUTES", nullptr, 12, "POSITION", 5126, "VEC3"},
                                      {"ATTRIBUTES", "EXPONENTIAL", 12, "POSITION", 5126, "VEC3"},
                                      {"ATTRIBUTES", "OCTAHEDRAL", 4, "NORMAL", 5120, "VEC3"},
                                      {"ATTRIBUTES", "OCTAHEDRAL", 8, "NORMAL", 5122, "VEC3"},
                                      {"ATTRIBUTES", "QUATERNION", 8, "ROTATION", 5122, "VEC4"},
                                      {"TRIANGLES", nullptr, 2, "", 5123, "SCALAR"},
                                      {"TRIANGLES", nullptr, 4, "", 5125, "SCALAR"},
                                      {"INDICES", nullptr, 4, "", 5125, "SCALAR"}}};

Json Accessor(uint64_t count, int componentType, const char* shape) {
    return {{"count", count},
            {"componentType", componentType},
            {"type", shape},
            {"normalized", componentType == 5120 || (componentType == 5122)}};
}

Json Scene(const Kind& kind, uint64_t vertices, uint64_t triangles, size_t size) {
    Json json;
    json["asset"]["version"] = "2.0";
    json["extensionsUsed"] = {"KHR_mesh_quantization"};
    json["scenes"][0]["nodes"] = {0};
    json["nodes"][0]["mesh"] = 0;
    Json& primitive = json["meshes"][0]["primitives"][0];
    json["accessors"] = {Accessor(vertices, 5126, "VEC3"), Accessor(3 * triangles, 5125, "SCALAR"),
                         Accessor(vertices, 5126, "VEC3")};
    primitive["attributes"] = {{"POSITION", 0}, {"NORMAL", 2}};
    primitive["indices"] = 1;
    json["buffers"] = {{{"byteLength", size}}};
    if (*kind.mode == 0) {
        json["bufferViews"] = {{{"buffer", 0}, {"byteLength", size}}};
        primitive["extensions"]["KHR_draco_mesh_compression"] = {
            {"bufferView", 0}, {"attributes", {{"POSITION", 0}, {"NORMAL", 1}}}};
        return json;
    }
    const bool isIndex = *kind.attribute == 0;
    const uint64_t count = isIndex ? 3 * triangles : vertices;
    json["buffers"].push_back({{"byteLength", count * kind.stride}});
    Json compressed{{"buffer", 0},
                    {"byteLength", size},
                    {"byteStride", kind.stride},
                    {"count", count},
                    {"mode", kind.mode}};
    if (kind.filter) compressed["filter"] = kind.filter;
    json["bufferViews"] = {{{"buffer", 1}, {"byteLength", count * kind.stride}}};
    if (!isIndex) json["bufferViews"][0]["byteStride"] = kind.stride;
    json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = std::move(compressed);
    Json accessor = Accessor(count, kind.componentType, kind.shape);
    accessor["bufferView"] = 0;
    json["accessors"].push_back(std::move(accessor));
    if (std::string_view(kind.attribute) == "ROTATION")
        json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] = 3;
    else
        (isIndex ? primitive["indices"] : primitive["attributes"][kind.attribute]) = 3;
    return json;
}

}  // namespace

Bytes CompressedFile(Input input) {
    const auto byte = [&](size_t i) { return std::to_integer<uint64_t>(input[i]); };
    const Input compressed = input.subspan(3);
    const Json json = Scene(kKinds[byte(0) % kKinds.size()], 1 + byte(1), 1 + byte(2), compressed.size());
    return MakeGlb(json.dump(), compressed);
}

void RunGltfCompressed(Input input) {
    if (input.size() >= 4) SharedSceneFolder().Load(CompressedFile(input));
}

}  // namespace raygraph::fuzz
