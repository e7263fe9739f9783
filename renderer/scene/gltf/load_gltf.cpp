#include "renderer/scene/gltf/load_gltf.h"

#include <algorithm>
#include <span>
#include <system_error>

#include "base/error.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/animations.h"
#include "renderer/scene/gltf/container.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/images.h"
#include "renderer/scene/gltf/lights.h"
#include "renderer/scene/gltf/materials.h"
#include "renderer/scene/gltf/meshes.h"
#include "renderer/scene/gltf/nodes.h"
#include "renderer/scene/gltf/outline.h"
#include "renderer/scene/gltf/reader.h"
#include "renderer/scene/gltf/skins.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {
namespace {

// Returns the index of the default material, which it gets if a primitive needs it; kNone if none does.
uint32_t AddDefaultMaterial(const std::vector<MeshLayout>& layouts, SceneData& scene) {
    const auto lacksOne = [](const PrimitiveLayout& primitive) { return primitive.material == kNone; };
    for (const MeshLayout& layout : layouts) {
        if (!std::any_of(layout.primitives.begin(), layout.primitives.end(), lacksOne)) continue;
        scene.materials.emplace_back().name = "default";
        return static_cast<uint32_t>(scene.materials.size() - 1);
    }
    return kNone;
}

// Returns, for each mesh, whether a node of the scene places it.
std::vector<bool> PlacedMeshes(const SceneData& scene, size_t meshCount) {
    std::vector<bool> isPlaced(meshCount, false);
    for (const uint32_t node : scene.nodeOrder)
        if (scene.nodes[node].mesh != kNone) isPlaced[scene.nodes[node].mesh] = true;
    return isPlaced;
}

std::vector<bool> ShownImages(const GltfOutline& outline) {
    std::vector<bool> isShown(outline.images.size(), false);
    const auto show = [&](uint32_t index) {
        const uint32_t material = index == kNone ? outline.defaultMaterial : index;
        ForEachShownTexture(outline.scene.materials[material], [&](const TextureRef& reference) {
            isShown[outline.scene.textures[static_cast<size_t>(reference.texture)].image] = true;
        });
    };
    const std::vector<bool> isPlaced = PlacedMeshes(outline.scene, outline.layouts.size());
    for (size_t mesh = 0; mesh < outline.layouts.size(); ++mesh) {
        if (!isPlaced[mesh]) continue;
        for (const PrimitiveLayout& primitive : outline.layouts[mesh].primitives) {
            show(primitive.material);
            for (const VariantMaterial& variant : primitive.variants) show(variant.material);
        }
    }
    return isShown;
}

// Decodes only meshes that are placed; the others keep their index and name.
void DecodeMeshes(GltfContext& context, AccessorReader& reader, const GltfOutline& outline,
                  SceneData& scene) {
    const std::vector<MeshLayout>& layouts = outline.layouts;
    const std::vector<bool> isPlaced = PlacedMeshes(scene, layouts.size());
    const std::vector<JointLimit> joints = JointLimits(scene, layouts.size());
    for (size_t i = 0; i < layouts.size(); ++i) {
        context.Progress("meshes", 0.1f + 0.4f * static_cast<float>(i) / static_cast<float>(layouts.size()));
        scene.meshes.push_back(
            isPlaced[i]
                ? DecodeMesh(context, reader, layouts[i], scene.materials, outline.defaultMaterial, joints[i])
                : Mesh{.name = layouts[i].name, .primitives = {}, .weights = layouts[i].weights});
    }
}

// Decodes the images of materials, and those of the environment.
void DecodePictures(GltfContext& context, const GltfOutline& outline, GltfBuffers& buffers,
                    SceneData& scene) {
    std::vector<ImageChoice> images = outline.images;
    if (outline.imageLight)
        for (const uint32_t face : ImagesOf(*outline.imageLight)) images.push_back({face});
    std::vector<bool> isShown = outline.isShown;
    isShown.resize(images.size(), true);
    std::vector<ImageData> decoded = DecodeImages(context, outline.imageSources, images, isShown, buffers);
    if (outline.imageLight)
        scene.environment = MakeEnvironmentLight(context, *outline.imageLight,
                                                 std::span(decoded).subspan(outline.images.size()));
    decoded.resize(outline.images.size());
    scene.images = std::move(decoded);
}

// Everything is checked before the first buffer is opened; meshes before images, which take longest.
SceneData Import(GltfContext& context, const GltfContainer& container) {
    GltfOutline outline = ReadOutline(context, container.json);
    SceneData scene = std::move(outline.scene);
    GltfBuffers buffers(context, outline.bufferSources, outline.tables, container);
    AccessorReader reader(context, outline.tables, buffers);
    DecodeMeshes(context, reader, outline, scene);
    DecodeSkins(context, reader, outline.skins, scene);
    scene.animations = DecodeAnimations(context, reader, outline.animations);
    PlaceInstances(context, reader, outline.instancing, scene);
    SetRadii(context, scene);
    scene.profiles = DecodeProfiles(context, outline.profiles, buffers);
    DecodePictures(context, outline, buffers, scene);
    CompleteNormalMaps(scene);
    Check(scene, context.label, ErrorKind::BadInput);
    context.Progress("done", 1.0f);
    scene.warnings = context.warnings.Take();
    return scene;
}

}  // namespace

ScenePath Locate(const std::filesystem::path& path) {
    std::error_code error;
    ScenePath located{std::filesystem::canonical(path, error), path.parent_path(),
                      Printable(path.filename().string())};
    if (error) throw MakeError(ErrorKind::Io, "{}: {}", path, error.message());
    return located;
}

namespace {

// Reads the names of KHR_materials_variants.
std::vector<std::string> ReadVariantNames(const gltf::Model& model) {
    std::vector<std::string> names;
    const auto found = model.extensions.find("KHR_materials_variants");
    if (found == model.extensions.end() || !found->second.Has("variants")) return names;
    const gltf::Value& variants = found->second.Get("variants");
    for (int i = 0; i < static_cast<int>(variants.ArrayLen()); ++i) {
        const gltf::Value& variant = variants.Get(i);
        names.push_back(variant.Has("name") ? variant.Get("name").Get<std::string>() : std::string());
    }
    return names;
}

}  // namespace

GltfOutline ReadOutline(GltfContext& context, std::string_view json) {
    GltfDocument document = ReadDocument(context, json);
    GltfOutline outline;
    outline.tables = ReadAccessorTables(context, document);
    outline.images = ReadMaterials(context, document.model, outline.scene);
    outline.layouts = ReadMeshLayouts(context, document.model, outline.tables);
    outline.instancing = ReadInstancing(context, document.model, outline.tables);
    outline.graph = ReadNodes(context, document.model, outline.scene);
    const GraphIndices& graph = outline.graph;
    ReadSkins(context, document, outline.tables, outline.layouts, outline.instancing, outline.scene);
    outline.animations = ReadAnimations(
        context, document.animations, outline.tables, outline.layouts,
        {outline.scene, graph.cameras, graph.lights, document.model.materials.size(),
         document.model.meshes.size(), document.model.cameras.size(), document.model.lights.size()});
    outline.imageLight = ReadImageLight(context, document.model, graph.scene);
    outline.profiles = ReadProfileSources(document.model, graph.profiles);
    outline.defaultMaterial = AddDefaultMaterial(outline.layouts, outline.scene);
    outline.isShown = ShownImages(outline);
    outline.scene.variants = ReadVariantNames(document.model);
    outline.skins = std::move(document.skins);
    outline.bufferSources = std::move(document.buffers);
    outline.imageSources = std::move(document.images);
    return outline;
}

SceneData LoadGltf(const std::filesystem::path& path, const LoadOptions& options) {
    const Stopwatch watch;
    const ScenePath located = Locate(path);
    DiskFileReader disk;
    FileReader& files = options.reader ? *options.reader : disk;
    const ConfinedFolder folder(located.folder, files, options.root);
    GltfContext context{.label = located.label, .options = options, .folder = folder, .warnings = {}};
    return WithMemoryErrors(context.label, [&] {
        context.Progress("file", 0.0f);
        const std::vector<std::byte> file = files.Read(located.file, options.limits.maxFileBytes);
        context.bytesRead = file.size();
        SceneData scene = Import(context, OpenContainer(file, context.label));
        for (const std::string& warning : scene.warnings)
            options.log.Send(LogLevel::Warning, log_category::kScene, warning);
        WriteLog(options.log, LogLevel::Info, log_category::kScene, "{}: {} read in {}", context.label,
                 BytesText(context.bytesRead), DurationText(watch.Seconds()));
        return scene;
    });
}

}  // namespace raygraph::scene
