#include "renderer/scene/gltf_document.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/scene/gltf_container.h"
#include "renderer/scene/gltf_schema.h"

namespace raygraph::scene {
namespace {

using Json = nlohmann::json;

// The elements of an array of the tree; none if it is absent.
Json::array_t* ArrayOf(Json& object, const char* name) {
    const auto found = object.find(name);
    return found == object.end() ? nullptr : found->get_ptr<Json::array_t*>();
}

std::optional<std::string> TakeText(Json& object, const char* name) {
    const auto found = object.find(name);
    if (found == object.end()) return std::nullopt;
    return std::move(found->get_ref<std::string&>());
}

std::vector<BufferSource> TakeBuffers(Json& root) {
    std::vector<BufferSource> sources;
    Json::array_t* const buffers = ArrayOf(root, "buffers");
    if (!buffers) return sources;
    for (Json& buffer : *buffers) {
        sources.push_back({TakeText(buffer, "uri"), buffer["byteLength"].get<uint64_t>()});
        buffer["byteLength"] = uint64_t{1};
        buffer["uri"] = "data:application/octet-stream;base64,AA==";
    }
    return sources;
}

std::vector<ImageSource> TakeImages(GltfContext& context, Json& root) {
    std::vector<ImageSource> sources;
    Json::array_t* const images = ArrayOf(root, "images");
    if (!images) return sources;
    for (Json& image : *images) {
        ImageSource source{.name = TakeText(image, "name").value_or(""), .uri = TakeText(image, "uri")};
        if (const auto view = image.find("bufferView"); view != image.end())
            source.view = view->get<uint32_t>();
        if (source.uri.has_value() == (source.view != kNone))
            context.Fail(Place("images")[sources.size()], "must have either a uri or a bufferView");
        sources.push_back(std::move(source));
        image = Json::object();
        image["uri"] = "placeholder";
    }
    return sources;
}

// tinygltf refuses indices of an accessor without a view, which are all zeros or sparse ones.
void GiveEachAccessorAView(Json& root) {
    Json& views = root["bufferViews"];
    if (views.is_null()) views = Json::array();
    const uint64_t none = views.size();
    views.emplace_back(Json::object({{"buffer", uint64_t{0}}, {"byteLength", uint64_t{1}}}));
    if (Json::array_t* const accessors = ArrayOf(root, "accessors"))
        for (Json& accessor : *accessors)
            if (!accessor.contains("bufferView")) accessor["bufferView"] = none;
}

// What tinygltf asks for and we do not.
void GiveCamerasANearPlane(Json& root) {
    Json::array_t* const cameras = ArrayOf(root, "cameras");
    if (!cameras) return;
    for (Json& camera : *cameras)
        if (const auto found = camera.find("orthographic");
            found != camera.end() && !found->contains("znear"))
            (*found)["znear"] = 0.0;
}

// An empty object of two characters becomes a material of two thousand bytes.
void CheckModelSize(GltfContext& context, Json& root) {
    uint64_t bytes = 0;
    const auto add = [&](Json& object, const char* name, size_t elementBytes) {
        if (const Json::array_t* const array = ArrayOf(object, name)) bytes += array->size() * elementBytes;
    };
    add(root, "accessors", sizeof(gltf::Accessor));
    add(root, "bufferViews", sizeof(gltf::BufferView));
    add(root, "buffers", sizeof(gltf::Buffer));
    add(root, "cameras", sizeof(gltf::Camera));
    add(root, "images", sizeof(gltf::Image));
    add(root, "materials", sizeof(gltf::Material));
    add(root, "nodes", sizeof(gltf::Node));
    add(root, "samplers", sizeof(gltf::Sampler));
    add(root, "scenes", sizeof(gltf::Scene));
    add(root, "textures", sizeof(gltf::Texture));
    if (Json::array_t* const meshes = ArrayOf(root, "meshes")) {
        bytes += meshes->size() * sizeof(gltf::Mesh);
        for (Json& mesh : *meshes) add(mesh, "primitives", sizeof(gltf::Primitive));
    }
    // A vector that grows has up to twice what it needs
    context.CheckModelBytes(2 * bytes);
}

}  // namespace

GltfDocument ReadDocument(GltfContext& context, std::string_view json) {
    Json root = ParseJson(json, context.label, context.options.limits);
    CheckSchema(context, root);
    CheckModelSize(context, root);
    if (const Json::array_t* const animations = ArrayOf(root, "animations");
        animations && !animations->empty())
        context.Warn(Place("animations"), "animations", "are not read, the scene stands still");
    root.erase("animations");
    root.erase("skins");
    GltfDocument document;
    document.buffers = TakeBuffers(root);
    document.images = TakeImages(context, root);
    GiveEachAccessorAView(root);
    GiveCamerasANearPlane(root);
    document.model = MakeModel(std::move(root), context.label);
    return document;
}

}  // namespace raygraph::scene
