#include "renderer/scene/gltf/document.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/scene/gltf/container.h"
#include "renderer/scene/gltf/lights.h"
#include "renderer/scene/gltf/schema.h"

namespace raygraph::scene {
namespace {

using Json = nlohmann::json;

// Returns the elements of an array of the tree; none if it is absent.
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

uint64_t TakeNumber(Json& object, const char* name) {
    const auto found = object.find(name);
    if (found == object.end()) return 0;
    const auto number = found->get<uint64_t>();
    object.erase(found);
    return number;
}

std::vector<uint32_t> TakeStrides(Json& root) {
    std::vector<uint32_t> strides;
    if (Json::array_t* const views = ArrayOf(root, "bufferViews"))
        for (Json& view : *views) strides.push_back(static_cast<uint32_t>(TakeNumber(view, "byteStride")));
    return strides;
}

std::vector<SparseNumbers> TakeSparseNumbers(Json& root) {
    std::vector<SparseNumbers> all;
    Json::array_t* const accessors = ArrayOf(root, "accessors");
    if (!accessors) return all;
    for (Json& accessor : *accessors) {
        SparseNumbers& numbers = all.emplace_back();
        const auto sparse = accessor.find("sparse");
        if (sparse == accessor.end()) continue;
        numbers = {.count = TakeNumber(*sparse, "count"),
                   .indicesOffset = TakeNumber((*sparse)["indices"], "byteOffset"),
                   .valuesOffset = TakeNumber((*sparse)["values"], "byteOffset")};
        (*sparse)["count"] = 1;
    }
    return all;
}

uint32_t IndexOr(const Json& object, const char* name, uint32_t absent) {
    const auto found = object.find(name);
    return found == object.end() ? absent : found->get<uint32_t>();
}

std::vector<SkinSource> TakeSkins(Json& root) {
    std::vector<SkinSource> skins;
    if (Json::array_t* const list = ArrayOf(root, "skins"))
        for (Json& skin : *list)
            skins.push_back({TakeText(skin, "name").value_or(""), skin["joints"].get<std::vector<uint32_t>>(),
                             IndexOr(skin, "inverseBindMatrices", kNone)});
    root.erase("skins");
    return skins;
}

Interpolation ReadInterpolation(const Json& sampler) {
    const auto found = sampler.find("interpolation");
    if (found == sampler.end() || *found == "LINEAR") return Interpolation::Linear;
    return *found == "STEP" ? Interpolation::Step : Interpolation::CubicSpline;
}

AnimationSource::Channel TakeChannel(Json& channel) {
    Json& target = channel["target"];
    AnimationSource::Channel taken{.sampler = channel["sampler"].get<uint32_t>(),
                                   .node = IndexOr(target, "node", kNone),
                                   .path = TakeText(target, "path").value_or(""),
                                   .pointer = {}};
    const auto extensions = target.find("extensions");
    if (extensions == target.end() || !extensions->contains(kAnimationPointer)) return taken;
    taken.pointer = TakeText((*extensions)[kAnimationPointer], "pointer");
    return taken;
}

std::vector<AnimationSource> TakeAnimations(Json& root) {
    std::vector<AnimationSource> animations;
    Json::array_t* const list = ArrayOf(root, "animations");
    for (size_t i = 0; list && i < list->size(); ++i) {
        Json& file = (*list)[i];
        AnimationSource& animation = animations.emplace_back();
        animation.name = TakeText(file, "name").value_or("");
        for (const Json& sampler : file["samplers"])
            animation.samplers.push_back({sampler["input"].get<uint32_t>(), sampler["output"].get<uint32_t>(),
                                          ReadInterpolation(sampler)});
        for (Json& channel : file["channels"]) animation.channels.push_back(TakeChannel(channel));
    }
    root.erase("animations");
    return animations;
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

// Must run before tinygltf, which drops empty objects from the lists of an extension, so that indices would
// shift.
void CheckLightProfiles(GltfContext& context, Json& root) {
    const auto extensions = root.find("extensions");
    if (extensions == root.end()) return;
    const auto extension = extensions->find(kProfileExtension);
    if (extension == extensions->end()) return;
    const Json::array_t* const profiles = ArrayOf(*extension, "lights");
    for (size_t i = 0; profiles && i < profiles->size(); ++i)
        if ((*profiles)[i].contains("uri") == (*profiles)[i].contains("bufferView"))
            context.Fail(ProfilePlace(i), "must have either a uri or a bufferView");
}

// tinygltf refuses indices of an accessor without a view, which are all zeros or sparse ones.
void AddMissingBufferViews(Json& root) {
    Json& views = root["bufferViews"];
    if (views.is_null()) views = Json::array();
    const uint64_t none = views.size();
    views.emplace_back(Json::object({{"buffer", uint64_t{0}}, {"byteLength", uint64_t{1}}}));
    if (Json::array_t* const accessors = ArrayOf(root, "accessors"))
        for (Json& accessor : *accessors)
            if (!accessor.contains("bufferView")) accessor["bufferView"] = none;
}

// Adds the near planes that tinygltf requires and this reader does not.
void AddMissingNearPlanes(Json& root) {
    Json::array_t* const cameras = ArrayOf(root, "cameras");
    if (!cameras) return;
    for (Json& camera : *cameras)
        if (const auto found = camera.find("orthographic");
            found != camera.end() && !found->contains("znear"))
            (*found)["znear"] = 0.0;
}

// Counts the memory that tinygltf's model of a checked tree will take: an empty object of two characters
// becomes a material of two thousand bytes. What takes less than some tens of bytes a character of its text,
// as names and numbers do, is left out: the limit goes up with the text.
class ModelSize {
  public:
    explicit ModelSize(Json& root) {
        AddList(root, "accessors", sizeof(gltf::Accessor));
        AddList(root, "bufferViews", sizeof(gltf::BufferView));
        AddList(root, "buffers", sizeof(gltf::Buffer));
        AddList(root, "cameras", sizeof(gltf::Camera));
        AddList(root, "images", sizeof(gltf::Image));
        AddList(root, "materials", sizeof(gltf::Material), [this](Json& material) {
            AddTextureInfos(material);
            if (const auto pbr = material.find("pbrMetallicRoughness"); pbr != material.end())
                AddTextureInfos(*pbr);
        });
        AddList(root, "nodes", sizeof(gltf::Node));
        AddList(root, "samplers", sizeof(gltf::Sampler));
        AddList(root, "scenes", sizeof(gltf::Scene));
        AddList(root, "textures", sizeof(gltf::Texture));
        AddList(root, "skins", sizeof(SkinSource));
        AddList(root, "animations", sizeof(AnimationSource), [this](Json& animation) {
            AddList(animation, "samplers", sizeof(AnimationSource::Sampler));
            AddList(animation, "channels", sizeof(AnimationSource::Channel));
        });
        AddList(root, "meshes", sizeof(gltf::Mesh), [this](Json& mesh) {
            AddList(mesh, "primitives", sizeof(gltf::Primitive), [this](Json& primitive) {
                AddMembers(primitive["attributes"], sizeof(std::pair<const std::string, int>));
                AddList(primitive, "targets", sizeof(std::map<std::string, int>), [this](Json& target) {
                    AddMembers(target, sizeof(std::pair<const std::string, int>));
                });
            });
        });
        // Extensions are counted as values too: tinygltf keeps them all that way.
        AddExtensions(root);
        if (const auto extensions = root.find("extensions"); extensions != root.end())
            if (const auto lights = extensions->find("KHR_lights_punctual"); lights != extensions->end())
                AddList(*lights, "lights", sizeof(gltf::Light));
    }

    uint64_t Bytes() const { return m_bytes; }

  private:
    // The links and the color of a map's node, in addition to the pair.
    static constexpr size_t kNodeBytes = 4 * sizeof(void*);
    // A vector that grows has up to twice what it needs.
    static constexpr size_t kGrowth = 2;

    template <typename AddMore>
    void AddList(Json& object, const char* name, size_t elementBytes, const AddMore& more) {
        Json::array_t* const array = ArrayOf(object, name);
        if (!array) return;
        m_bytes += kGrowth * array->size() * elementBytes;
        for (Json& element : *array) {
            AddExtensions(element);
            more(element);
        }
    }
    void AddList(Json& object, const char* name, size_t elementBytes) {
        AddList(object, name, elementBytes, [](Json&) {});
    }
    void AddMembers(const Json& object, size_t pairBytes) {
        m_bytes += object.size() * (pairBytes + kNodeBytes);
    }
    // Adds the extensions of the members of `object` that are texture infos.
    void AddTextureInfos(const Json& object) {
        for (const auto& [name, member] : object.items())
            if (name.ends_with("Texture")) AddExtensions(member);
    }
    void AddExtensions(const Json& object) {
        for (const char* name : {"extensions", "extras"})
            if (const auto found = object.find(name); found != object.end()) AddValue(*found);
    }
    void AddValue(const Json& value) {
        m_bytes += kGrowth * sizeof(gltf::Value);
        if (value.is_object()) AddMembers(value, sizeof(std::pair<const std::string, gltf::Value>));
        if (value.is_structured())
            for (const Json& inner : value) AddValue(inner);
    }

    uint64_t m_bytes = 0;
};

}  // namespace

GltfDocument ReadDocument(GltfContext& context, std::string_view json) {
    Json root = ParseJson(context, json);
    CheckSchema(context, root);
    context.CheckModelBytes(ModelSize(root).Bytes(), json.size());
    GltfDocument document;
    document.skins = TakeSkins(root);
    document.animations = TakeAnimations(root);
    CheckLightProfiles(context, root);
    document.buffers = TakeBuffers(root);
    document.images = TakeImages(context, root);
    document.strides = TakeStrides(root);
    document.sparse = TakeSparseNumbers(root);
    AddMissingBufferViews(root);
    AddMissingNearPlanes(root);
    document.model = MakeModel(std::move(root), context.label);
    return document;
}

// --- Known extensions ---

namespace {

constexpr GltfExtension Read(std::string_view name, std::string_view note) {
    return {name, true, note};
}
constexpr GltfExtension Unsupported(std::string_view name, std::string_view why) {
    return {name, false, why};
}

// clang-format off
constexpr std::array kKnown{
    Read("EXT_lights_ies", "point lights with measured profiles"),
    Read("EXT_lights_image_based", "the environment, where --env and --background give none"),
    Read("EXT_mesh_gpu_instancing", "the mesh at each place"),
    Read("EXT_meshopt_compression", "decoded"),
    Unsupported("EXT_texture_avif", "there is no decoder for AVIF"),
    Read("EXT_texture_webp", "decoded"),
    Read("KHR_animation_pointer", "moves what gltf.md lists, at the time of --at"),
    Read("KHR_draco_mesh_compression", "decoded"),
    Unsupported("KHR_gaussian_splatting", "splats are not drawn"),
    Unsupported("KHR_interactivity", "behaviors are not run"),
    Read("KHR_lights_punctual", "point, spot and directional lights"),
    Read("KHR_materials_anisotropy", "stretched highlights"),
    Read("KHR_materials_clearcoat", "a coat over the surface"),
    Read("KHR_materials_diffuse_transmission", "diffuse light passes through"),
    Read("KHR_materials_dispersion", "media refract colors differently"),
    Read("KHR_materials_emissive_strength", "a factor of what is emitted"),
    Read("KHR_materials_ior", "the index of the dielectric"),
    Read("KHR_materials_iridescence", "a thin film over the surface, below the coat and sheen"),
    Read("KHR_materials_pbrSpecularGlossiness", "archived; read as KHR_materials_specular"),
    Read("KHR_materials_retroreflection", "a draft; facets reflect light back to where it came from"),
    Read("KHR_materials_scatter", "a draft; the medium scatters, or a thin surface does"),
    Read("KHR_materials_sheen", "fibers on the surface"),
    Read("KHR_materials_specular", "strength and color of the reflection"),
    Unsupported("KHR_materials_subsurface", "a proposal of 2021: now KHR_materials_volume_scatter"),
    Read("KHR_materials_transmission", "light passes through"),
    Read("KHR_materials_unlit", "shows its base color"),
    Read("KHR_materials_variants", "one is chosen with --variant"),
    Read("KHR_materials_volume", "the medium absorbs"),
    Read("KHR_materials_volume_scatter",
         "the medium scatters; it is homogeneous, so multiscatterColorTexture is not read"),
    Read("KHR_mesh_quantization", "all types of vertices"),
    Read("KHR_meshopt_compression",
         "decoded as by EXT_meshopt_compression: no version 1 of the codec before meshoptimizer 0.23"),
    Read("KHR_node_visibility", "hides nodes and what is below them"),
    Unsupported("KHR_physics_rigid_bodies", "bodies do not move"),
    Read("KHR_texture_basisu", "decoded"),
    Read("KHR_texture_transform", "in every texture"),
    Read("KHR_xmp_json_ld", "metadata, kept when saved"),
    Unsupported("MSFT_lod", "the finest level is shown, whatever the distance"),
    Read("MSFT_texture_dds", "decoded"),
};
// clang-format on
static_assert(std::ranges::is_sorted(kKnown, {}, &GltfExtension::name));

}  // namespace

std::span<const GltfExtension> KnownExtensions() {
    return kKnown;
}

}  // namespace raygraph::scene
